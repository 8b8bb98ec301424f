// SPDX-License-Identifier: MIT
#include "support/coverage.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

#include <Eigen/LU>

#include "alidade/camera/model_traits.h"
#include "alidade/camera/projection_uncertainty.h"
#include "alidade/core/statistics.h"
#include "alidade/geometry/symmetric_eigen.h"
#include "alidade/simulate/observe.h"
#include "alidade/target/board_shape.h"

namespace alidade {
namespace {

constexpr double kNoisePx = 0.1;
constexpr double kInfinity = std::numeric_limits<double>::infinity();

Eigen::Vector2d randomDirection(Random& random) {
  const double azimuth = random.uniform(0, 2 * std::numbers::pi);
  return {std::cos(azimuth), std::sin(azimuth)};
}

void bendBoard(TroubledSet& set, Random& random) {
  constexpr double kBendM = 3e-4;
  const double bend = random.uniform() < 0.5 ? kBendM : -kBendM;
  const bool is_along_x = random.uniform() < 0.5;
  const BoardShape shape{.bend_x_m = is_along_x ? bend : 0.0, .bend_y_m = is_along_x ? 0.0 : bend};
  const Checkerboard& board = set.views.board;
  for (std::size_t v = 0; v < set.views.views.size(); ++v) {
    for (Corner& corner : set.views.views[v].corners) {
      const Eigen::Vector3d p = set.views.poses[v] * onBentBoard(board, shape, board.corner(corner.id));
      const Projection projection = set.drawn.camera.project(p);
      if (projection.ok()) corner.pixel = projection.pixel;
    }
  }
}

void moveViews(TroubledSet& set, Random& random) {
  constexpr double kMotionPx = 0.5;
  const Checkerboard& board = set.views.board;
  const double width = board.corner(board.numCorners() - 1).x();
  for (View& view : set.views.views) {
    const Eigen::Vector2d motion = kMotionPx * random.normal() * randomDirection(random);
    const Eigen::Vector2d along = randomDirection(random);
    for (Corner& corner : view.corners) {
      const double t = board.corner(corner.id).head<2>().dot(along) / width;
      corner.pixel += t * t * motion;
    }
  }
}

void moveCorners(TroubledSet& set, Random& random) {
  constexpr double kShare = 0.05;
  constexpr double kMovedPx = 10;
  for (View& view : set.views.views) {
    for (Corner& corner : view.corners) {
      if (random.uniform() < kShare) corner.pixel += kMovedPx * randomDirection(random);
    }
  }
}

// What is left, at the uncertainty's pixels, of the difference between the truth and the estimate after the
// rotation that undoes most of it: Gauss and Newton to the end, on the truth itself. Pixel of the truth less
// that of the estimate; zero where either has none.
std::vector<Eigen::Vector2d> differences(const AnyCamera& truth, const AnyCamera& estimate,
                                         const ProjectionUncertainty& uncertainty) {
  const std::vector<Eigen::Vector2d>& pixels = uncertainty.pixels();
  SO3 turn;
  constexpr int kRounds = 4;
  std::vector<Eigen::Vector2d> result;
  for (int round = 0; round <= kRounds; ++round) {
    result.assign(pixels.size(), Eigen::Vector2d::Zero());
    Eigen::Matrix3d JtJ = Eigen::Matrix3d::Zero();
    Eigen::Vector3d Jte = Eigen::Vector3d::Zero();
    for (std::size_t i = 0; i < pixels.size(); ++i) {
      const auto ray = estimate.unproject(pixels[i]);
      if (!ray) continue;
      const Eigen::Vector3d turned = turn * *ray;
      Eigen::Matrix<double, 2, 3, Eigen::RowMajor> J_point;
      const Projection projection = truth.project(turned, J_point.data(), nullptr);
      if (!projection.ok()) continue;
      result[i] = projection.pixel - pixels[i];
      const Eigen::Matrix<double, 2, 3> J = -J_point * hat(turned);
      JtJ += J.transpose() * J;
      Jte += J.transpose() * result[i];
    }
    turn = SO3::exp(-JtJ.ldlt().solve(Jte)) * turn;
  }
  return result;
}

class Tally {
 public:
  void add(double error, double std) {
    const double z = error / std;
    ++result_.count;
    sum_ += z;
    squares_ += z * z;
    if (std::abs(z) < kNormal95) ++num_covered_;
  }
  [[nodiscard]] Coverage get() const {
    Coverage result = result_;
    result.mean = sum_ / result.count;
    result.std = std::sqrt(squares_ / result.count - result.mean * result.mean);
    result.covered = static_cast<double>(num_covered_) / result.count;
    return result;
  }

 private:
  Coverage result_;
  double sum_ = 0;
  double squares_ = 0;
  int num_covered_ = 0;
};

int indexOf(const ProjectionUncertainty& uncertainty, Place place) {
  const int row = uncertainty.rows() / 2;
  const int column = uncertainty.columns() / 2;
  switch (place) {
    case Place::kCenter:
      return row * uncertainty.columns() + column;
    case Place::kMid:
      return row / 2 * uncertainty.columns() + column / 2;
    case Place::kCorner:
      return 0;
  }
  return 0;
}

}  // namespace

std::string_view troubleName(Trouble trouble) {
  switch (trouble) {
    case Trouble::kNone:
      return "clean";
    case Trouble::kOutliers:
      return "outliers";
    case Trouble::kBentBoard:
      return "bent, held flat";
    case Trouble::kMotion:
      return "motion";
  }
  return "";
}

TroubledSet drawTroubledSet(std::string_view model, Trouble trouble, std::uint64_t seed) {
  Random random(seed);
  const bool is_wide = modelTraits(model).family == LensFamily::kWide;
  DrawnCamera drawn = drawCamera(model, is_wide ? random.uniform(90, 135) : random.uniform(50, 90), random);
  constexpr int kFewestViews = 12;
  constexpr int kMostViews = 30;
  const int num_views = kFewestViews + static_cast<int>(random.index(kMostViews - kFewestViews + 1));
  TroubledSet set{.drawn = drawn, .views = drawUserViews(drawn, num_views, 0, random)};
  if (trouble == Trouble::kBentBoard) bendBoard(set, random);
  if (trouble == Trouble::kMotion) moveViews(set, random);
  for (View& view : set.views.views) addCornerNoise(view, kNoisePx, random);
  if (trouble == Trouble::kOutliers) moveCorners(set, random);
  return set;
}

Judged judgeSet(const TroubledSet& set, Trouble trouble) {
  const bool is_bent = trouble == Trouble::kBentBoard;
  const Calibration result =
      calibrate(set.views.board, set.views.views,
                {.model = std::string(set.drawn.camera.modelId()),
                 .board_shape = is_bent ? BoardShapeMode::kFlat : BoardShapeMode::kAuto});
  Judged judged;
  judged.is_converged =
      result.fit.summary.termination == Termination::kConverged && result.uncertainty.covariance;
  if (!judged.is_converged) return judged;
  judged.is_noise_exceeded = result.uncertainty.isNoiseExceeded();
  if (result.uncertainty.by_views) judged.excess = result.uncertainty.by_views->excess;
  const auto truth = set.drawn.camera.parameters();
  const std::vector<int>& held = onlyCamera(result.fit).constraint.held;
  for (std::size_t k = 0; k < truth.size(); ++k) {
    const int i = static_cast<int>(k);
    if (std::ranges::find(held, i) != held.end()) continue;
    judged.parameters.push_back({.error = onlyCamera(result.fit).params[k] - truth[k],
                                 .std = result.uncertainty.parameterStdByNoise(i),
                                 .std_by_views = result.uncertainty.by_views
                                                     ? result.uncertainty.by_views->effectiveStd(i)
                                                     : std::numeric_limits<double>::quiet_NaN(),
                                 .stated_std = result.uncertainty.parameterStd(i)});
  }
  const ProjectionUncertainty uncertainty(result.camera(), result.imageSize(), kInfinity);
  const auto error = differences(set.drawn.camera, result.camera(), uncertainty);
  for (const Place place : kAllPlaces) {
    const int i = indexOf(uncertainty, place);
    const auto J = uncertainty.jacobian(i);
    const Eigen::Matrix2d covariance = J * result.uncertainty.statedCovariance().view() * J.transpose();
    const SymmetricEigen solver(covariance);
    const Eigen::Vector2d& e = error[static_cast<std::size_t>(i)];
    judged.projections[static_cast<std::size_t>(place)] = {.error_px = solver.eigenvectors().col(1).dot(e),
                                                           .std_px = std::sqrt(solver.eigenvalues()(1)),
                                                           .squared_sigmas = e.dot(covariance.inverse() * e)};
  }
  return judged;
}

Coverage coverageOf(const std::vector<Judged>& sets, double Judged::Parameter::*std, int parameter) {
  Tally tally;
  for (const Judged& set : sets) {
    for (std::size_t k = 0; k < set.parameters.size(); ++k) {
      if (parameter >= 0 && static_cast<int>(k) != parameter) continue;
      const Judged::Parameter& p = set.parameters[k];
      if (!std::isnan(p.*std)) tally.add(p.error, p.*std);
    }
  }
  return tally.get();
}

Coverage coverageOf(const std::vector<Judged>& sets, Place place) {
  Tally tally;
  for (const Judged& set : sets) {
    if (!set.is_converged) continue;
    const Judged::Projection& p = set.projections[static_cast<std::size_t>(place)];
    tally.add(p.error_px, p.std_px);
  }
  return tally.get();
}

double ellipseShare(const std::vector<Judged>& sets, Place place) {
  constexpr double kEllipse95 = 5.991464547107979;  // of chi square with 2 degrees of freedom
  int num_inside = 0;
  int count = 0;
  for (const Judged& set : sets) {
    if (!set.is_converged) continue;
    ++count;
    if (set.projections[static_cast<std::size_t>(place)].squared_sigmas < kEllipse95) ++num_inside;
  }
  return static_cast<double>(num_inside) / count;
}

}  // namespace alidade
