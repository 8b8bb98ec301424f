// SPDX-License-Identifier: MIT
#include "alidade/calibrate/uncertainty/view_evidence.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <optional>
#include <span>
#include <utility>
#include <vector>

#include <Eigen/Cholesky>

#include "alidade/adjust/noise/covariance.h"
#include "alidade/adjust/noise/view_shares.h"
#include "alidade/adjust/noise/view_ways.h"
#include "alidade/calibrate/uncertainty/print_errors.h"
#include "alidade/core/mapped.h"
#include "alidade/core/median.h"
#include "alidade/core/statistics.h"
#include "alidade/geometry/decompositions.h"
#include "alidade/geometry/symmetric_eigen.h"

namespace alidade {
namespace {

double inflation(double freedom) {
  return studentT95(freedom) / kNormal95;
}

// In every direction the larger of two covariances, the first of which is `variance` times the identity.
Eigen::MatrixXd larger(double variance, const Eigen::MatrixXd& covariance) {
  const SymmetricEigen solver(covariance);
  const Eigen::VectorXd values = solver.eigenvalues().cwiseMax(variance);
  return solver.eigenvectors() * values.asDiagonal() * solver.eigenvectors().transpose();
}

constexpr int kNumOtherCauses = static_cast<int>(kCommonCauses.size()) - kNumBoardCauses;

// One additional column per cause, in the order of CommonCause: first those of each board in turn, then the
// others. For the views of one board; the columns of other boards are zero.
class CommonColumns {
 public:
  CommonColumns(const Fit& fit, std::size_t board)
      : first_(kNumBoardCauses * static_cast<int>(board)),
        num_board_columns_(kNumBoardCauses * static_cast<int>(fit.boards.size())),
        middle_(fit.boards[board].target.middle()),
        by_gap_(gapOffsets(fit.boards[board].target)),
        focal_{onlyCamera(fit).params[0], onlyCamera(fit).params[1]} {}

  [[nodiscard]] int size() const {
    return num_board_columns_ + static_cast<int>(kCommonCauses.size()) - kNumBoardCauses;
  }
  [[nodiscard]] ExtraElements<kCommonCauses.size()> elements(const CornerRows& rows, int axis) const {
    // The displacement of a board point acts like a translation of the pose.
    using Row = Eigen::Map<const Eigen::RowVector3d>;
    const auto at = static_cast<std::size_t>(axis);
    const Row J(rows.J_px_pose[at]);
    const Eigen::Vector3d& p = rows.corner.p_board;
    const Eigen::Vector3d out = p - middle_;
    const double X = out.x() / middle_.x();
    const double Y = out.y() / middle_.y();
    const Eigen::Vector3d p_cam = rows.camera_from_board * p;
    const double angle = std::atan2(p_cam.head<2>().norm(), p_cam.z());
    const Eigen::Vector3d optical_axis = rows.camera_from_board.rotation.matrix().row(2);
    const double distance_m = (rows.camera_from_board * middle_).norm();
    const double* by_params = rows.J_px_params[at];
    const double outward = std::hypot(Row(rows.J_px_pose[0]).dot(out), Row(rows.J_px_pose[1]).dot(out));
    const double by_gap =
        by_gap_.empty() ? 0.0 : J.dot(by_gap_[static_cast<std::size_t>(rows.corner.id)].transpose());
    const int rest = num_board_columns_;
    return {.column = {first_, first_ + 1, first_ + 2, first_ + 3, first_ + 4, rest, rest + 1, rest + 2},
            .value = {J[0] * p.x(), J[0] * middle_.x() * X * X, J[1] * middle_.y() * Y * Y,
                      J[2] * middle_.x() * X * Y, by_gap, -angle * angle * J.dot(optical_axis),
                      (focal_[0] * by_params[0] + focal_[1] * by_params[1]) / distance_m,
                      outward > 0 ? rows.root_weight * (X * X + Y * Y) * J.dot(out) / outward : 0.0}};
  }

 private:
  int first_;
  int num_board_columns_;
  Eigen::Vector3d middle_;
  std::vector<Eigen::Vector3d> by_gap_;
  std::array<double, 2> focal_;
};

// A view compared with the others, in coordinates in which noise gives the result the covariance 1.
struct OneView {
  Eigen::MatrixXd S;             // its share of the total information, between 0 and 1
  Eigen::VectorXd move;          // of the result if the view is omitted
  Eigen::VectorXd disagreement;  // its pull, corrected for its own influence on the fit
  Eigen::VectorXd pull;          // each element has variance 1 if there is only noise
  double freedom = 0;            // number of directions that it and others inform about
};

OneView oneView(const Eigen::MatrixXd& share, const Eigen::VectorXd& gradient) {
  constexpr double kNothing =
      1e-6;  // share below which a view does not contribute; above 1 less this, no other does
  const SymmetricEigen solver(share);
  Eigen::VectorXd move = Eigen::VectorXd::Zero(gradient.size());
  Eigen::VectorXd disagreement = move;
  OneView view{.S = share, .move = {}, .disagreement = {}, .pull = move};
  const Eigen::VectorXd g = solver.eigenvectors().transpose() * gradient;
  for (Eigen::Index i = 0; i < g.size(); ++i) {
    const double s = solver.eigenvalues()(i);
    if (s < kNothing || s > 1 - kNothing) continue;
    // The gradient has the variance s (1 - s) because the others also pulled the fit.
    move(i) = g(i) / (1 - s);
    disagreement(i) = g(i) / std::sqrt(1 - s);
    view.pull(i) = g(i) / std::sqrt(s * (1 - s));
    ++view.freedom;
  }
  view.move = solver.eigenvectors() * move;
  view.disagreement = solver.eigenvectors() * disagreement;
  return view;
}

// Disagreement of the views beyond noise, in the same coordinates.
class Disagreement {
 public:
  explicit Disagreement(Eigen::Index num_free) : squares_(Eigen::MatrixXd::Zero(num_free, num_free)) {}

  void add(const OneView& view, int sign) {
    squares_ += sign * view.disagreement * view.disagreement.transpose();
    squares_of_shares_ += sign * view.S.squaredNorm();
    num_views_ += sign;
  }

  // The size of a change in the sigmas that the views imply: those by noise, or those by their disagreement
  // if it is larger beyond chance.
  [[nodiscard]] double sigmas(const Eigen::VectorXd& change) const {
    const Eigen::Index m = squares_.rows();
    const auto num_free = static_cast<double>(m);
    const double excess = squares_.trace() / num_free;
    const bool is_exceeded =
        num_views_ > m &&
        normalOfMeanSquare(excess, num_free * num_free / squares_of_shares_) > kBeyondChance;
    if (!is_exceeded) return change.norm();
    const SymmetricEigen solver(squares_);
    const Eigen::VectorXd along = solver.eigenvectors().transpose() * change;
    return std::sqrt(along.cwiseAbs2().cwiseQuotient(solver.eigenvalues().cwiseMax(1)).sum());
  }

 private:
  Eigen::MatrixXd squares_;
  double squares_of_shares_ = 0;
  Eigen::Index num_views_ = 0;
};

// Scores come from corners weighted by the loss and are less accurate than the data of the covariance.
std::optional<Eigen::MatrixXd> inverseOf(const Eigen::MatrixXd& matrix) {
  constexpr double kSingular = 1e-12;
  return scaledInverse(matrix, kSingular).inverse;
}

// A held value that may be wrong, and how the parameters change with it.
struct HeldCause {
  CommonError named;
  Eigen::VectorXd direction;
};

bool isFocal(int parameter) {
  return parameter == 0 || parameter == 1;
}

// None if the whole lens is given: such a lens is tested against the one that the views give.
std::vector<HeldCause> heldCauses(const FitCamera& camera, Eigen::Index num_free) {
  const Eigen::Index n = std::ssize(camera.params);
  const ParamConstraint& constraint = camera.constraint;
  std::vector<HeldCause> causes;
  if (num_free == 0) return causes;
  const int num_focals = (constraint.holds(0) ? 1 : 0) + (constraint.holds(1) ? 1 : 0);
  if (num_focals == 2 || (num_focals == 1 && constraint.same_focal)) {
    HeldCause& both = causes.emplace_back(HeldCause{{.cause = CommonCause::kHeldFocal}, {}});
    both.direction = Eigen::VectorXd::Zero(n);
    both.direction.head<2>() << camera.params[0], camera.params[1];
  }
  for (const int i : constraint.held) {
    if ((constraint.same_focal && isFocal(i)) || i >= static_cast<int>(camera.numLensParams())) continue;
    causes.push_back({{.cause = CommonCause::kHeld, .parameter = i}, Eigen::VectorXd::Unit(n, i)});
  }
  return causes;
}

// Estimates of common errors from all views together. Causes are named by their columns, after which come
// held values.
class CommonEstimate {
 public:
  CommonEstimate(std::span<const Reduced> scores, const Eigen::MatrixXd& directions, double variance,
                 double smoothness, std::vector<HeldCause> held = {})
      : scores_(scores),
        directions_(directions),
        held_(std::move(held)),
        variance_(variance),
        smoothness_(smoothness) {
    const Eigen::Index size = scores.front().gradient.size();
    information_ = Eigen::MatrixXd::Zero(size, size);
    gradient_ = Eigen::VectorXd::Zero(size);
    for (const Reduced& score : scores) {
      information_ += score.information;
      gradient_ += score.gradient;
    }
  }

  [[nodiscard]] int numColumns() const { return static_cast<int>(gradient_.size() - directions_.rows()); }
  [[nodiscard]] int numCauses() const { return numColumns() + static_cast<int>(held_.size()); }

  // The cause, without its estimate.
  [[nodiscard]] CommonError named(int column) const {
    if (column >= numColumns()) return held(column).named;
    const int beyond_boards = column - (numColumns() - kNumOtherCauses);
    if (beyond_boards >= 0) return {.cause = static_cast<CommonCause>(kNumBoardCauses + beyond_boards)};
    return {.cause = static_cast<CommonCause>(column % kNumBoardCauses),
            .board = static_cast<std::size_t>(column / kNumBoardCauses)};
  }

  // Estimates one cause with others free, excluding those that follow from it.
  [[nodiscard]] std::optional<CommonError> of(int column, const std::vector<int>& others) const {
    std::vector<int> free = others;
    free.push_back(column);
    const Eigen::MatrixXd all = basis(free);
    const auto inverse = inverseOf(all.transpose() * information_ * all);
    if (!inverse) return std::nullopt;
    const Eigen::Index last = all.cols() - 1;
    const Eigen::VectorXd values = -*inverse * (all.transpose() * gradient_);
    const Eigen::VectorXd step = all * values;
    const Eigen::RowVectorXd along = inverse->row(last) * all.transpose();
    const auto num_views = static_cast<double>(scores_.size());
    Eigen::RowVectorXd shares(std::ssize(scores_));
    for (Eigen::Index v = 0; v < shares.size(); ++v) {
      const Reduced& score = scores_[static_cast<std::size_t>(v)];
      shares(v) = along.dot(score.gradient + score.information * step);
    }
    CommonError error = named(column);
    // The step's own freedom makes the views' shares agree slightly too well. A print is judged by what is
    // sure of its errors, so theirs are not enlarged.
    const bool is_series =
        numColumns() == kNumBoardCauses + kNumOtherCauses && error.cause >= CommonCause::kPupil;
    const double by_views = (is_series ? serialFactor(shares) : 1.0) * shares.squaredNorm() * num_views /
                            std::max(1.0, num_views - 1);
    error.value = values(last);
    error.sigma = smoothness_ * std::sqrt(std::max(by_views, variance_ * (*inverse)(last, last)));
    // Pupils move by a few millimetres; views that hardly determine the motion give it other errors' size.
    constexpr double kPupilPriorM = 0.01;
    if (error.cause == CommonCause::kPupil) {
      const double trust = 1 / (1 + std::pow(error.sigma / kPupilPriorM, 2));
      error.value *= trust;
      error.sigma *= std::sqrt(trust);
    }
    return error;
  }

  // Error of the intrinsics if an error of this size is not taken into account.
  [[nodiscard]] std::vector<double> stepFor(int column, double value) const {
    Eigen::VectorXd moved = Eigen::VectorXd::Zero(directions_.rows());
    const Eigen::MatrixXd intrinsics = basis({});
    if (intrinsics.cols() > 0) {
      const Eigen::VectorXd pull = information_ * basis({column}).rightCols<1>();
      Eigen::MatrixXd own = intrinsics.transpose() * information_ * intrinsics;
      const Eigen::VectorXd along = intrinsics.transpose() * pull;
      if (const auto known = inverseOf(own)) {
        moved = -value * directions_ * (*known * along);
      } else {  // the step of the nearest problem that has one; none would look harmless
        constexpr double kLittle = 1e-9;
        own.diagonal() *= 1 + kLittle;
        moved = -value * directions_ * solveSpd(own, along);
      }
    }
    if (column >= numColumns()) moved += value * held(column).direction;
    return {moved.begin(), moved.end()};
  }

 private:
  [[nodiscard]] const HeldCause& held(int column) const {
    return held_[static_cast<std::size_t>(column - numColumns())];
  }

  // The free directions: the intrinsics and these columns.
  [[nodiscard]] Eigen::MatrixXd basis(const std::vector<int>& columns) const {
    const Eigen::Index n = directions_.rows();
    const Eigen::Index m = directions_.cols();
    Eigen::MatrixXd free =
        Eigen::MatrixXd::Zero(n + numColumns(), m + static_cast<Eigen::Index>(columns.size()));
    free.topLeftCorner(n, m) = directions_;
    for (std::size_t i = 0; i < columns.size(); ++i) {
      auto along = free.col(m + static_cast<Eigen::Index>(i));
      if (columns[i] < numColumns()) {
        along(n + columns[i]) = 1;
      } else {
        along.head(n) = held(columns[i]).direction;
      }
    }
    return free;
  }

  std::span<const Reduced> scores_;
  Eigen::MatrixXd directions_;
  std::vector<HeldCause> held_;
  double variance_;
  double smoothness_;
  Eigen::MatrixXd information_;
  Eigen::VectorXd gradient_;
};

}  // namespace

std::optional<ViewCovariance> viewCovariance(std::span<const Reduced> pulls,
                                             const Eigen::MatrixXd& directions, int num_params,
                                             double variance, double mean_slope, bool is_series) {
  constexpr std::size_t kFewestViews = 3;  // two always disagree
  constexpr double kLeastFreedom = 2;      // with less, no factor is large enough
  const Eigen::Index m = directions.cols();
  if (m == 0 || pulls.size() < kFewestViews) return std::nullopt;
  const auto shares = ViewShares::make(pulls, directions, mean_slope);
  if (!shares) return std::nullopt;

  ViewCovariance result;
  if (is_series) result.serial_factor = serialFactor(shares->pulls());
  const Eigen::MatrixXd meat = result.serial_factor * shares->covariance();
  const Eigen::MatrixXd root = shares->basis().topRows(num_params);
  result.covariance = root * meat * root.transpose();
  double most = 1;
  for (int i = 0; i < num_params; ++i) {
    // Views that are alike count as fewer.
    result.freedom.push_back(shares->freedomOf(root.row(i).transpose()) / result.serial_factor);
    if (result.covariance(i, i) > 0) most = std::max(most, inflation(result.freedom.back()));
  }
  const auto num_free = static_cast<double>(m);
  result.excess = meat.trace() / (num_free * variance);
  const double squares_of_shares = result.serial_factor * shares->squaresOfShares();
  result.excess_sigmas = normalOfMeanSquare(result.excess, num_free * num_free / squares_of_shares);
  result.is_pooled = static_cast<Eigen::Index>(pulls.size()) <= m || !std::isfinite(most);
  if (result.is_pooled) {
    const auto most_freedom = static_cast<double>(pulls.size()) - 1;
    const double freedom = std::clamp(num_free / squares_of_shares - 1, kLeastFreedom, most_freedom);
    const double pooled = inflation(freedom) * inflation(freedom) * result.excess;
    const double capped = inflation(kLeastFreedom) * inflation(kLeastFreedom);
    result.larger = root * larger(variance * std::max(1.0, pooled), capped * meat) * root.transpose();
  } else {
    result.larger = root * larger(variance, most * most * meat) * root.transpose();
  }
  return result;
}

std::vector<Reduced> viewScores(const Fit& fit) {
  return mapped(fit.views, [&](const FitView& view) {
    return reduced(fit, view, LossWeights::kUse, CommonColumns(fit, view.board));
  });
}

std::vector<CommonError> commonErrors(std::span<const Reduced> scores, const Eigen::MatrixXd& directions,
                                      const FitCamera& camera, std::span<const Reduced> flexible,
                                      double variance, double smoothness) {
  const CommonEstimate own(scores, directions, variance, smoothness, heldCauses(camera, directions.cols()));
  const Eigen::Index num_flexible =
      flexible.empty() ? 0 : flexible.front().gradient.size() - own.numColumns();
  const CommonEstimate estimate =
      flexible.empty() ? own
                       : CommonEstimate(flexible, Eigen::MatrixXd::Identity(num_flexible, num_flexible),
                                        variance, smoothness);
  const auto is_held = [&](int cause) { return cause >= own.numColumns(); };
  // A value that was entered is the likelier cause of what looks like several others. One of two focal
  // lengths looks like squares that are not square, and either may be it.
  const auto likelihood = [&](const CommonError& error) {
    constexpr double kEntered = 1.5;
    const bool is_entered = error.cause == CommonCause::kHeldFocal ||
                            (error.cause == CommonCause::kHeld && !isFocal(error.parameter));
    return (is_entered ? kEntered : 1) * error.sigmas();
  };
  // Both focal lengths in proportion, and one of them, are not estimated together.
  const auto excludes = [&](const CommonError& a, const CommonError& b) {
    return a.cause == CommonCause::kHeldFocal && b.cause == CommonCause::kHeld && isFocal(b.parameter);
  };
  std::vector<int> found;
  for (;;) {
    std::vector<CommonError> errors;
    std::vector<int> columns;  // of the errors
    std::optional<std::size_t> surest;
    double most = 0;
    for (int column = 0; column < own.numCauses(); ++column) {
      if (camera.hasPupil() && own.named(column).cause == CommonCause::kPupil) continue;  // estimated
      std::vector<int> others = found;
      const bool is_new = std::erase(others, column) == 0;
      const bool is_excluded = std::ranges::any_of(others, [&](int other) {
        return excludes(own.named(other), own.named(column)) || excludes(own.named(column), own.named(other));
      });
      if (is_excluded) continue;
      // The flexible model has parameters of its own, all of them free.
      const bool is_own = is_held(column) || flexible.empty();
      if (!is_own) std::erase_if(others, is_held);
      const auto error = (is_own ? own : estimate).of(column, others);
      if (!error) continue;
      const double certainty = likelihood(*error);
      if (is_new && error->isSignificant() && certainty > most) {
        surest = errors.size();
        most = certainty;
      }
      errors.push_back(*error);
      columns.push_back(column);
    }
    if (!surest) {
      for (std::size_t i = 0; i < errors.size(); ++i)
        errors[i].params_step = own.stepFor(columns[i], errors[i].value);
      for (CommonError& error : errors) error.params_step.resize(camera.numLensParams());
      return errors;
    }
    found.push_back(columns[*surest]);
  }
}

std::vector<ViewInfluence> viewInfluences(std::span<const Reduced> scores, const Eigen::MatrixXd& directions,
                                          double variance) {
  const Eigen::Index n = directions.rows();
  const Eigen::Index m = directions.cols();
  if (m == 0) return {};
  Eigen::MatrixXd information = Eigen::MatrixXd::Zero(m, m);
  for (const Reduced& score : scores)
    information += directions.transpose() * score.information.topLeftCorner(n, n) * directions;
  const auto inverse = inverseOf(information);
  if (!inverse) return {};
  const Eigen::MatrixXd root = inverse->llt().matrixL();
  // In coordinates in which the total information is equal in every direction, noise has the covariance 1.
  const Eigen::MatrixXd basis = directions * root / std::sqrt(variance);
  std::vector<OneView> views;
  Disagreement all(m);
  std::vector<double> means;  // of squares that are 1 on average if there is only noise
  for (const Reduced& score : scores) {
    const Eigen::MatrixXd share =
        variance * basis.transpose() * score.information.topLeftCorner(n, n) * basis;
    views.push_back(oneView(share, basis.transpose() * score.gradient.head(n)));
    all.add(views.back(), 1);
    means.push_back(views.back().freedom > 0 ? views.back().pull.squaredNorm() / views.back().freedom : 0.0);
  }
  const double typical = std::max(1.0, medianOf(means));
  std::vector<ViewInfluence> influences;
  for (std::size_t v = 0; v < views.size(); ++v) {
    Disagreement others = all;
    others.add(views[v], -1);
    influences.push_back({.move_sigmas = others.sigmas(views[v].move)});
    if (views[v].freedom > 0)
      influences[v].surprise_sigmas = normalOfMeanSquare(means[v] / typical, views[v].freedom);
  }
  return influences;
}

ViewVariations viewVariations(const Fit& fit) {
  constexpr std::size_t kMinViewsToVary = 4;
  ViewVariations variations;
  if (fit.views.size() < kMinViewsToVary) return variations;
  const ViewWays ways(fit);
  if (!ways.isRedundant(2)) return variations;
  const auto spreadOf = [&](ViewWay way, double variance) {
    return std::sqrt(ways.varianceOf(way, variance));
  };
  const WayDrop by_focal = ways.dropBy(kFocalWay);
  const WayDrop by_rows = ways.dropBy(kRowWays);
  const double rows_variance = ways.varianceLeft(by_rows);
  variations.focal_share = by_rows.squares > 0 ? std::min(1.0, by_focal.squares / by_rows.squares) : 0.0;
  variations.focal_f = ways.f(by_focal);
  variations.focal_spread = spreadOf(ViewWay::kFocal, ways.varianceLeft(by_focal));
  variations.rows_f = ways.f(by_rows);
  variations.rows_spread =
      std::max(spreadOf(ViewWay::kShear, rows_variance), spreadOf(ViewWay::kStretch, rows_variance));
  return variations;
}

}  // namespace alidade
