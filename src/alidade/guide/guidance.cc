// SPDX-License-Identifier: MIT
#include "alidade/guide/guidance.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numbers>
#include <utility>

#include <fmt/format.h>
#include <Eigen/Cholesky>
#include <Eigen/Geometry>

#include "alidade/adjust/board/view_kernel.h"
#include "alidade/camera/batch.h"
#include "alidade/camera/projection_uncertainty.h"
#include "alidade/core/degrees.h"
#include "alidade/core/number_text.h"

namespace alidade {
namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();
constexpr double kPartPenalty = 1.1;  // on the standard deviation, for a partly visible board
constexpr double kLeastGain = 1e-6;   // relative; a view with a smaller gain is useless

constexpr int kPlacesAlong = 7;
constexpr int kPlacesAcross = 5;
constexpr std::array<double, 3> kSpans = {0.3, 0.6, 0.95};  // share of the image's smaller side
constexpr std::array<double, 5> kTiltsDeg = {0, -20, 20, -40, 40};
constexpr double kMargin = 0.02;           // share of the image's smaller side
constexpr double kLeastSquarePx = 6;       // below, corners are not found reliably
constexpr double kLeastSine = 0.25881905;  // sine of 15 degrees, between a line of sight and the board
constexpr double kPaper = 0.3;             // visible paper beyond the outer squares, in squares
constexpr int kMaxAlong = 12;              // corners that represent a row or column of the board

// Indices 0 to count - 1, or kMaxAlong of them evenly spaced.
std::vector<int> someOf(int count) {
  std::vector<int> indices;
  const int num = std::min(count, kMaxAlong);
  for (int i = 0; i < num; ++i) indices.push_back((2 * i * (count - 1) + num - 1) / (2 * (num - 1)));
  return indices;
}

class CandidateMaker {
 public:
  CandidateMaker(const AnyCamera& camera, ImageSize size, const Board& board, const CandidateLimits& limits)
      : camera_(camera), size_(size), limits_(limits), middle_(board.middle()) {
    columns_ = someOf(board.columns());
    rows_ = someOf(board.rows());
    for (const int row : rows_) {
      for (const int column : columns_) points_board_.push_back(board.corner(row * board.columns() + column));
    }
    const Eigen::Vector2d paper = Eigen::Vector2d::Constant(kPaper * board.spacing());
    const Eigen::Vector2d low = board.printed().min() - paper;
    const Eigen::Vector2d high = board.printed().max() + paper;
    ends_ = {
        {{low.x(), low.y(), 0}, {high.x(), low.y(), 0}, {high.x(), high.y(), 0}, {low.x(), high.y(), 0}}};
    weight_ = static_cast<double>(board.numCorners()) / static_cast<double>(points_board_.size());
    points_camera_.resize(points_board_.size());
    projections_.resize(points_board_.size());
    if (limits.is_upright) roll_ = SO3::exp({0, 0, std::numbers::pi / 2});
  }

  void addAt(const Eigen::Vector2d& pixel, std::vector<ViewCandidate>& candidates) {
    const auto ray = camera_.unproject(pixel);
    const auto square = squarePose(camera_, pixel);
    if (!ray || !square) return;
    for (const double span : kSpans) {
      const auto distance = distanceFor(span, *ray, *square);
      if (!distance || *distance < limits_.nearest_m || *distance > limits_.farthest_m) continue;
      for (const double across : kTiltsDeg) {
        for (const double along : kTiltsDeg) {
          const BoardTilt tilt = {.right_rad = kRadPerDeg * across, .lower_rad = kRadPerDeg * along};
          const SE3 pose = poseOf(*square * tiltedBoard(tilt), *distance * *ray);
          if (auto candidate = look(pose)) candidates.push_back(std::move(*candidate));
        }
      }
    }
  }

 private:
  [[nodiscard]] SE3 poseOf(const SO3& camera_from_upright, const Eigen::Vector3d& middle_camera) const {
    const SO3 rotation = camera_from_upright * roll_;
    return {rotation, middle_camera - rotation * middle_};
  }

  void project(const SE3& camera_from_board) {
    for (std::size_t i = 0; i < points_board_.size(); ++i)
      points_camera_[i] = camera_from_board * points_board_[i];
    projectBatch(camera_, points_camera_, projections_);
  }

  // The distance at which the untilted board spans this share of the smaller side, ignoring the border of the
  // image.
  [[nodiscard]] std::optional<double> distanceFor(double span, const Eigen::Vector3d& ray,
                                                  const SO3& square) {
    // Starts far away, where every lens is a pinhole, and approaches with the lens as it is.
    constexpr double kAfar = 100;
    constexpr int kNumSteps = 4;
    double distance = kAfar * 2 * middle_.norm();
    for (int i = 0; i < kNumSteps; ++i) {
      project(poseOf(square, distance * ray));
      Eigen::AlignedBox2d box;
      for (const Projection& projection : projections_) {
        // This close, the lens does not show the whole board, so the span cannot be measured better.
        if (!projection.ok()) return i > 0 ? std::optional(distance) : std::nullopt;
        box.extend(projection.pixel);
      }
      distance *= box.sizes().maxCoeff() / (span * std::min(size_.width, size_.height));
    }
    return distance;
  }

  [[nodiscard]] bool isInside(const Projection& projection) const {
    const double margin = kMargin * std::min(size_.width, size_.height);
    return projection.ok() && projection.pixel.minCoeff() >= margin - 0.5 &&
           projection.pixel.x() < size_.width - 0.5 - margin &&
           projection.pixel.y() < size_.height - 0.5 - margin;
  }

  // Smallest size of a square in pixels. Neighbouring corners of the selection may be several squares apart.
  [[nodiscard]] double leastSquarePx() const {
    const auto at = [&](std::size_t row, std::size_t column) -> const Projection& {
      return projections_[row * columns_.size() + column];
    };
    double least = kInfinity;
    const auto measure = [&](const Projection& a, const Projection& b, int num_squares) {
      if (isInside(a) && isInside(b)) least = std::min(least, (a.pixel - b.pixel).norm() / num_squares);
    };
    for (std::size_t row = 0; row < rows_.size(); ++row) {
      for (std::size_t column = 0; column < columns_.size(); ++column) {
        if (column > 0)
          measure(at(row, column - 1), at(row, column), columns_[column] - columns_[column - 1]);
        if (row > 0) measure(at(row - 1, column), at(row, column), rows_[row] - rows_[row - 1]);
      }
    }
    return least;
  }

  [[nodiscard]] std::optional<ViewCandidate> look(const SE3& pose) {
    project(pose);
    ViewCandidate candidate{.camera_from_board = pose, .corners = {}};
    const Eigen::Vector3d normal = pose.rotation * Eigen::Vector3d::UnitZ();
    for (std::size_t i = 0; i < projections_.size(); ++i) {
      if (!isInside(projections_[i])) continue;
      if (normal.dot(points_camera_[i]) < kLeastSine * points_camera_[i].norm()) return std::nullopt;
      candidate.corners.push_back({.p_board = points_board_[i],
                                   .pixel = projections_[i].pixel,
                                   .sigma_px = std::numeric_limits<double>::quiet_NaN(),
                                   .weight = weight_});
    }
    candidate.is_whole = candidate.corners.size() == projections_.size();
    if (2 * candidate.corners.size() < projections_.size() || leastSquarePx() < kLeastSquarePx)
      return std::nullopt;
    if (!candidate.is_whole && !showsASide(pose)) return std::nullopt;
    return candidate;
  }

  // True if both ends of a side are visible, including the paper beyond the squares. Only then can the
  // corners of a partly visible board be identified.
  [[nodiscard]] bool showsASide(const SE3& pose) const {
    std::array<bool, 4> is_seen{};
    for (std::size_t i = 0; i < 4; ++i) is_seen[i] = isInside(camera_.projectPoint(pose * ends_[i]));
    for (std::size_t i = 0; i < 4; ++i) {
      if (is_seen[i] && is_seen[(i + 1) % 4]) return true;
    }
    return false;
  }

  const AnyCamera& camera_;
  ImageSize size_;
  CandidateLimits limits_;
  Eigen::Vector3d middle_;
  SO3 roll_;
  std::vector<int> columns_;  // columns of the board in points_board_
  std::vector<int> rows_;
  double weight_ = 1;
  std::array<Eigen::Vector3d, 4> ends_;  // outer corners of the squares with a little paper, in order around
                                         // the board
  std::vector<Eigen::Vector3d> points_board_;
  std::vector<Eigen::Vector3d> points_camera_;  // of the last projection, like the next member
  std::vector<Projection> projections_;
};

// Larger eigenvalue of the covariance of one pixel if corners have variance 1.
double largerVariance(const Eigen::Ref<const Eigen::MatrixXd>& jacobian, const Eigen::MatrixXd& inverse) {
  double a = 0;
  double b = 0;
  double c = 0;
  for (Eigen::Index i = 0; i < inverse.cols(); ++i) {
    const double u = inverse.col(i).dot(jacobian.col(0));
    const double v = inverse.col(i).dot(jacobian.col(1));
    a += u * jacobian(i, 0);
    b += u * jacobian(i, 1);
    c += v * jacobian(i, 1);
  }
  const double half = 0.5 * (a - c);
  return 0.5 * (a + c) + std::sqrt(half * half + b * b);
}

// Finds the largest variance over the image. Pixels that decided before are tried first.
class WorstPixel {
 public:
  explicit WorstPixel(const Eigen::MatrixXd& jacobians) : jacobians_(jacobians) {
    for (Eigen::Index i = 0; i < jacobians.cols() / 2; ++i) order_.push_back(i);
  }

  // Exact below `limit`, otherwise some value that is at least `limit`; infinite if the information is
  // singular.
  [[nodiscard]] double variance(const Eigen::MatrixXd& information, double limit) {
    cholesky_.compute(information);
    if (cholesky_.info() != Eigen::Success) return kInfinity;
    inverse_.setIdentity(information.rows(), information.cols());
    cholesky_.solveInPlace(inverse_);
    double largest = 0;
    for (std::size_t i = 0; i < order_.size(); ++i) {
      const double variance = largerVariance(jacobians_.middleCols<2>(2 * order_[i]), inverse_);
      if (!(variance < kInfinity)) return kInfinity;
      largest = std::max(largest, variance);
      if (largest < limit) continue;
      // A pixel that rejects one candidate is likely to reject the next.
      std::rotate(order_.begin(), order_.begin() + static_cast<std::ptrdiff_t>(i),
                  order_.begin() + static_cast<std::ptrdiff_t>(i) + 1);
      return largest;
    }
    return largest;
  }

 private:
  const Eigen::MatrixXd& jacobians_;
  std::vector<Eigen::Index> order_;
  Eigen::LLT<Eigen::MatrixXd> cholesky_;
  Eigen::MatrixXd inverse_;
};

constexpr double kReach = 2;  // factor by which views may be closer or farther than the existing ones

// The board with the most views; the first of equals.
std::size_t mostSeenBoard(const Fit& fit) {
  std::size_t most = 0;
  for (std::size_t board = 1; board < fit.boards.size(); ++board) {
    if (numViews(fit, board) > numViews(fit, most)) most = board;
  }
  return most;
}

// True if the board's columns run along the image's height in most of its views.
bool isHeldUpright(const Fit& fit, std::size_t board) {
  const auto num_upright = std::count_if(fit.views.begin(), fit.views.end(), [&](const FitView& view) {
    if (view.board != board) return false;
    const Eigen::Vector3d along_columns = cameraFromBoard(fit, view).rotation * Eigen::Vector3d::UnitX();
    return std::abs(along_columns.y()) > std::abs(along_columns.x());
  });
  return 2 * static_cast<std::size_t>(num_upright) > numViews(fit, board);
}

// The board, with its SPEC if there are several boards.
std::string boardName(const Guidance& guidance) {
  return guidance.is_chosen ? "the board " + guidance.board.spec() : "the board";
}

// Worst uncertainty by the stated covariance divided by that from noise alone, at least 1.
double inflationOf(const AnyCamera& camera, ImageSize size, const Uncertainty& known) {
  if (!known.covariance) return 1;
  const ProjectionUncertainty uncertainty(camera, size, kInfinity);
  const double ratio =
      uncertainty.worst(known.statedCovariance()).std_px / uncertainty.worst(*known.covariance).std_px;
  return std::isfinite(ratio) ? std::max(1.0, ratio) : 1;
}

TargetReport forecast(NextViewSearch search, const Guidance& guidance, double target_px) {
  TargetReport report{
      .target_px = target_px, .num_more_views = std::nullopt, .forecast_px = guidance.worst_px};
  if (guidance.worst_px <= target_px) report.num_more_views = 0;
  for (int i = 1; i <= kMaxForecast && !report.num_more_views; ++i) {
    const auto view = search.best();
    if (!view) return report;
    search.take(*view);
    report.forecast_px = guidance.inflation * view->worst_px;
    if (report.forecast_px <= target_px) report.num_more_views = i;
  }
  return report;
}

}  // namespace

std::vector<ViewCandidate> viewCandidates(const AnyCamera& camera, ImageSize size, const Board& board,
                                          const CandidateLimits& limits) {
  CandidateMaker maker(camera, size, board, limits);
  const bool is_wide = size.width >= size.height;
  const int columns = is_wide ? kPlacesAlong : kPlacesAcross;
  const int rows = is_wide ? kPlacesAcross : kPlacesAlong;
  std::vector<ViewCandidate> candidates;
  for (int row = 0; row < rows; ++row) {
    for (int column = 0; column < columns; ++column) {
      maker.addAt({(column + 0.5) / columns * size.width - 0.5, (row + 0.5) / rows * size.height - 0.5},
                  candidates);
    }
  }
  return candidates;
}

Eigen::MatrixXd viewInformation(const AnyCamera& camera, const SE3& camera_from_board,
                                const std::vector<Observation>& corners) {
  const auto params = camera.parameters();
  return paramsInformation(*viewFactor(viewKernel(camera.modelId(), params.size()), params, camera_from_board,
                                       groupsOf(corners), kNoLoss, Unseen::kLeaveOut));
}

NextViewSearch::NextViewSearch(const CameraKnowledge& known, const Board& board,
                               const CandidateLimits& limits)
    : known_(known),
      board_(board),
      limits_(limits),
      information_(known.directions.transpose() * known.information * known.directions),
      candidates_(viewCandidates(known.camera, known.size, board, limits)) {
  const Eigen::MatrixXd& directions = known_.directions;
  const ProjectionUncertainty uncertainty(known_.camera, known_.size, kInfinity);
  const int num_pixels = uncertainty.columns() * uncertainty.rows();
  jacobians_.resize(directions.cols(), 2 * static_cast<Eigen::Index>(num_pixels));
  Eigen::Index used = 0;
  for (int i = 0; i < num_pixels; ++i) {
    if (!uncertainty.hasRay(i)) continue;
    jacobians_.middleCols<2>(2 * used++) =
        (Eigen::MatrixXd(uncertainty.jacobian(i)) * directions).transpose();
  }
  jacobians_.conservativeResize(Eigen::NoChange, 2 * used);
  addPriorIfUndetermined();
  for (const ViewCandidate& candidate : candidates_) {
    gains_.emplace_back(directions.transpose() *
                        viewInformation(known_.camera, candidate.camera_from_board, candidate.corners) *
                        directions);
  }
}

void NextViewSearch::addPriorIfUndetermined() {
  // A first-order standard deviation larger than the image means only that the direction is unknown.
  const double diagonal = std::hypot(known_.size.width, known_.size.height);
  is_determined_ = worst() < diagonal;
  if (is_determined_ || jacobians_.cols() == 0) return;
  for (Eigen::Index i = 0; i < jacobians_.rows(); ++i) {
    const double px_per_unit = jacobians_.row(i).cwiseAbs().maxCoeff();
    information_(i, i) += px_per_unit * px_per_unit / (diagonal * diagonal);
  }
}

double NextViewSearch::worst() const {
  if (jacobians_.cols() == 0) return std::numeric_limits<double>::quiet_NaN();
  return std::sqrt(known_.variance) * std::sqrt(WorstPixel(jacobians_).variance(information_, kInfinity));
}

std::optional<NextView> NextViewSearch::best() const {
  if (information_.size() == 0 || jacobians_.size() == 0) return std::nullopt;
  WorstPixel worst(jacobians_);
  const double now = worst.variance(information_, kInfinity);
  double best = now * (1 - kLeastGain);  // uncertainty to beat, including the penalty
  std::optional<std::size_t> chosen;
  Eigen::MatrixXd sum;
  for (std::size_t i = 0; i < candidates_.size(); ++i) {
    const double penalty = candidates_[i].is_whole ? 1 : kPartPenalty * kPartPenalty;
    sum = information_ + gains_[i];
    const double left = penalty * worst.variance(sum, best / penalty);
    if (!(left < best)) continue;
    best = left;
    chosen = i;
  }
  if (!chosen) return std::nullopt;
  const ViewCandidate& candidate = candidates_[*chosen];
  const double penalty = candidate.is_whole ? 1 : kPartPenalty * kPartPenalty;
  Eigen::AlignedBox2d box;
  for (const Observation& corner : candidate.corners) box.extend(corner.pixel);
  return NextView{.camera_from_board = candidate.camera_from_board,
                  .sighting = sightBoard(known_.camera, board_, candidate.camera_from_board),
                  .fill = fillOf(box, known_.size),
                  .is_whole = candidate.is_whole,
                  .is_on_end = (board_.columns() > board_.rows() && limits_.is_upright) ||
                               (board_.columns() < board_.rows() && !limits_.is_upright),
                  .worst_px = std::sqrt(known_.variance) * std::sqrt(best / penalty),
                  .candidate = *chosen};
}

Guidance guide(const Calibration& calibration, std::span<const View> views, std::optional<double> target_px) {
  const Fit& fit = calibration.fit;
  const std::size_t board = mostSeenBoard(fit);
  const Uncertainty& known = calibration.uncertainty;
  const CameraKnowledge knowledge{.camera = calibration.camera(),
                                  .size = calibration.imageSize(),
                                  .information = known.information,
                                  .directions = known.free_directions,
                                  .variance = known.coordinate_sigma_px * known.coordinate_sigma_px};
  CoverageReport coverage = coverageOf(calibration, views);
  double nearest_m = kInfinity;
  double farthest_m = 0;
  for (const ViewCoverage& view : coverage.views) {
    if (view.board != board) continue;
    nearest_m = std::min(nearest_m, view.sighting.distance_m);
    farthest_m = std::max(farthest_m, view.sighting.distance_m);
  }
  const NextViewSearch search(knowledge, fit.boards[board].target,
                              {.nearest_m = nearest_m / kReach,
                               .farthest_m = farthest_m * kReach,
                               .is_upright = isHeldUpright(fit, board)});
  Guidance guidance{
      .coverage = std::move(coverage), .board = fit.boards[board].target, .is_chosen = fit.boards.size() > 1};
  guidance.is_determined = search.isDetermined();
  guidance.inflation = inflationOf(knowledge.camera, knowledge.size, known);
  guidance.worst_px =
      search.isDetermined() ? guidance.inflation * search.worst() : std::numeric_limits<double>::quiet_NaN();
  guidance.next = search.best();
  if (target_px) guidance.target = forecast(search, guidance, *target_px);
  if (guidance.next) guidance.next->worst_px *= guidance.inflation;
  return guidance;
}

std::string nextViewText(const Guidance& guidance, ImageSize size) {
  if (!guidance.next) return "no further view of this board would improve the camera\n";
  const NextView& next = *guidance.next;
  const BoardSighting& at = next.sighting;
  std::string text = fmt::format(
      "{}{} {} of the image, its centre at pixel ({:.0f}, {:.0f}), {:.2g} m away so that it fills {:.0f} % "
      "of the image{}, {}\n",
      boardName(guidance), next.is_on_end ? ", upright (portrait)," : "",
      placeName(regionAt(at.middle_px, size)), at.middle_px.x(), at.middle_px.y(), at.distance_m,
      100 * next.fill, next.is_whole ? "" : " and extends beyond it", tiltText(at.tilt));
  text += guidance.is_determined
              ? fmt::format("reduces the worst projection uncertainty from {:.2g} to {:.2g} px\n",
                            guidance.worst_px, next.worst_px)
              : "adds the most to what these views leave undetermined\n";
  return text;
}

std::string shortNextViewText(const Guidance& guidance, ImageSize size) {
  if (!guidance.next) return "no further view of this board would improve the camera";
  const BoardSighting& at = guidance.next->sighting;
  return fmt::format("put {}{} {} {}, {:.2g} m away, {}", boardName(guidance),
                     guidance.next->is_on_end ? " upright" : "", placeName(regionAt(at.middle_px, size)),
                     guidance.next->is_whole ? "of the image" : "and beyond the image", at.distance_m,
                     tiltText(at.tilt));
}

std::string targetText(const Guidance& guidance) {
  if (!guidance.target) return "";
  const TargetReport& target = *guidance.target;
  const std::string now = guidance.is_determined ? fmt::format("{:.2g} px", guidance.worst_px) : "unknown";
  if (target.isReached())
    return fmt::format("{:.3g} px: reached; the worst projection uncertainty is {}\n", target.target_px, now);
  const std::string text =
      fmt::format("{:.3g} px: not reached; the worst projection uncertainty is {}; ", target.target_px, now);
  if (!target.num_more_views) {
    return text + fmt::format("even {} more views like the suggested one are not enough ({:.2g} px)\n",
                              kMaxForecast, target.forecast_px);
  }
  return text +
         fmt::format("needs about {} like the suggested one\n", counted(*target.num_more_views, "more view"));
}

}  // namespace alidade
