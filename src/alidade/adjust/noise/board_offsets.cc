// SPDX-License-Identifier: MIT
#include "alidade/adjust/noise/board_offsets.h"

#include <algorithm>
#include <cmath>
#include <utility>
#include <vector>

#include <Eigen/Cholesky>

#include "alidade/adjust/board/solve.h"
#include "alidade/adjust/noise/joint_information.h"
#include "alidade/adjust/noise/robust_weighting.h"
#include "alidade/core/mapped.h"

namespace alidade {
namespace {

constexpr double kFirstScatter = 0.02;  // share of the points' spacing
constexpr double kLeastScatter = 1e-5;  // smaller offsets count as zero
constexpr double kFewestOffsets = 3;    // number of coordinates that the corners determine

// The inverse of a symmetric positive definite matrix, scaled first; nothing if it is not positive definite.
std::optional<Eigen::MatrixXd> inverseOf(const Eigen::MatrixXd& matrix) {
  if (matrix.size() == 0) return matrix;
  if (!(matrix.diagonal().minCoeff() > 0)) return std::nullopt;
  const Eigen::VectorXd scale = matrix.diagonal().cwiseSqrt().cwiseInverse();
  const Eigen::LLT<Eigen::MatrixXd> llt(scale.asDiagonal() * matrix * scale.asDiagonal());
  if (llt.info() != Eigen::Success) return std::nullopt;
  const Eigen::MatrixXd inverse = llt.solve(Eigen::MatrixXd::Identity(matrix.rows(), matrix.cols()));
  if (!inverse.allFinite()) return std::nullopt;
  return Eigen::MatrixXd(scale.asDiagonal() * inverse * scale.asDiagonal());
}

// The normal equations of the whole fit, including the priors of the lenses.
Reduced equationsOf(const Fit& fit, const JointColumns& columns, LossWeights weights) {
  Reduced sum{.information = Eigen::MatrixXd::Zero(columns.count, columns.count),
              .gradient = Eigen::VectorXd::Zero(columns.count)};
  forEachFrame(fit, columns, weights, [&](const Reduced& frame) {
    sum.information += frame.information;
    sum.gradient += frame.gradient;
  });
  for (std::size_t c = 0; c < fit.cameras.size(); ++c) {
    const FitCamera& camera = fit.cameras[c];
    const LensPrior& prior = camera.weak_prior.prior;
    for (std::size_t i = 0; i < prior.precision.size(); ++i) {
      const Eigen::Index at = columns.params[c] + static_cast<Eigen::Index>(i);
      sum.information(at, at) += prior.precision[i];
      sum.gradient(at) += prior.precision[i] * (camera.params[i] - prior.mean[i]);
    }
  }
  return sum;
}

// Orthonormal directions of a board's offsets (x, y, z of each point) that deform the board as a whole:
// stretch, shear, gradation, twist or bend. Directions that keep its shape are excluded, and their share is
// removed from the others.
std::vector<Eigen::VectorXd> smoothModes(const Board& target) {
  const Eigen::Index num_points = target.numCorners();
  const Eigen::Vector3d middle = target.middle();
  const auto field = [&](const auto& offsetAt) {
    Eigen::VectorXd offsets(3 * num_points);
    for (Eigen::Index i = 0; i < num_points; ++i) {
      const Eigen::Vector3d p = (target.corner(static_cast<int>(i)) - middle) / middle.head<2>().norm();
      offsets.segment<3>(3 * i) = offsetAt(p.x(), p.y());
    }
    return offsets;
  };
  using Offset = Eigen::Vector3d;
  std::vector<Eigen::VectorXd> basis;
  const auto add = [&](Eigen::VectorXd offsets) {
    constexpr double kNothing = 1e-6;
    const double norm = offsets.norm();
    for (const Eigen::VectorXd& other : basis) offsets -= other.dot(offsets) * other;
    if (offsets.norm() > kNothing * norm) basis.push_back(offsets.normalized());
  };
  add(field([](double, double) { return Offset(1, 0, 0); }));
  add(field([](double, double) { return Offset(0, 1, 0); }));
  add(field([](double, double) { return Offset(0, 0, 1); }));
  add(field([](double x, double y) { return Offset(-y, x, 0); }));
  add(field([](double x, double y) { return Offset(x, y, 0); }));
  add(field([](double x, double) { return Offset(0, 0, x); }));
  add(field([](double, double y) { return Offset(0, 0, y); }));
  const auto num_of_pose_and_size = static_cast<std::ptrdiff_t>(basis.size());
  add(field([](double x, double y) { return Offset(x, -y, 0); }));
  add(field([](double x, double y) { return Offset(y, x, 0); }));
  for (const int axis : {0, 1, 2}) {
    add(field([&](double x, double) { return Offset(x * x * Offset::Unit(axis)); }));
    add(field([&](double x, double y) { return Offset(x * y * Offset::Unit(axis)); }));
    add(field([&](double, double y) { return Offset(y * y * Offset::Unit(axis)); }));
  }
  return {basis.begin() + num_of_pose_and_size, basis.end()};
}

// Prior of a board's offsets: each coordinate scatters about zero, in the plane or normal to it, and each
// smooth mode has its own estimated scatter. If all points scattered independently, a stretch of the board
// would seem much better known than it is.
class OffsetPrior {
 public:
  explicit OffsetPrior(const FitBoard& board)
      : count_(3 * static_cast<Eigen::Index>(board.target.numCorners())),
        precision_(*board.offset_precision) {
    for (Eigen::VectorXd& direction : smoothModes(board.target)) {
      bool is_across = false;
      for (Eigen::Index i = 2; i < count_; i += 3) is_across = is_across || direction(i) != 0;
      const int axes = is_across ? kAcross : kInPlane;
      modes_.push_back({.direction = std::move(direction), .axes = axes, .precision = precision_(axes)});
    }
  }

  static constexpr int kInPlane = 0;
  static constexpr int kAcross = 1;

  [[nodiscard]] double scatterPrecision(int axes) const { return precision_(axes); }
  void setScatterPrecision(int axes, double precision) { precision_(axes) = precision; }

  // Sets the variance of each mode to its most likely value: the square of the amplitude that the corners
  // alone give, minus their own variance. It is at least the variance of the scatter. The result does not
  // depend on the previous variances.
  // @param inverse  of the sum of the corners' information and this prior; a covariance when multiplied by
  // `variance`
  void freeModes(const Eigen::VectorXd& offsets, const Eigen::MatrixXd& inverse, double variance) {
    constexpr int kMaxRounds = 100;
    constexpr double kSteady = 1e-9;
    constexpr double kSomething = 0.01;  // least share of the corners in the information on a mode
    const auto count = static_cast<Eigen::Index>(modes_.size());
    Eigen::MatrixXd U(count_, count);
    Eigen::VectorXd held(count);
    for (Eigen::Index k = 0; k < count; ++k) {
      U.col(k) = modes_[static_cast<std::size_t>(k)].direction;
      held(k) = modes_[static_cast<std::size_t>(k)].precision;
    }
    // Information on the amplitudes with all other offsets eliminated, with and without the modes' own
    // priors.
    const auto known = inverseOf(U.transpose() * inverse * U);
    if (!known) return;
    const Eigen::VectorXd gradient = *known * (U.transpose() * offsets);
    Eigen::MatrixXd by_others = *known;
    by_others.diagonal() -= held;
    for (int round = 0; round < kMaxRounds; ++round) {
      Eigen::MatrixXd sum = by_others;
      for (Eigen::Index k = 0; k < count; ++k) sum(k, k) += modes_[static_cast<std::size_t>(k)].precision;
      const auto posterior = inverseOf(sum);
      if (!posterior) return;
      const Eigen::VectorXd amplitudes = *posterior * gradient;
      double change = 0;
      for (Eigen::Index k = 0; k < count; ++k) {
        Mode& mode = modes_[static_cast<std::size_t>(k)];
        const double of_all = 1 / (*posterior)(k, k);
        const double by_corners = of_all - mode.precision;
        double precision = precision_(mode.axes);
        if (by_corners > kSomething * of_all) {
          const double amplitude = amplitudes(k) * of_all / by_corners;
          precision =
              variance / std::max(variance / precision, amplitude * amplitude - variance / by_corners);
        }
        change = std::max(change, std::abs(precision / mode.precision - 1));
        mode.precision = precision;
      }
      if (change < kSteady) return;
    }
  }

  // Sum of squares of the offsets without the modes.
  [[nodiscard]] double squaresOf(const Eigen::VectorXd& offsets, int axes) const {
    double squares = 0;
    for (Eigen::Index i = 0; i < count_; ++i) squares += axesOf(i) == axes ? offsets(i) * offsets(i) : 0;
    for (const Mode& mode : modes_) {
      const double amplitude = mode.direction.dot(offsets);
      squares -= mode.axes == axes ? amplitude * amplitude : 0;
    }
    return std::max(0.0, squares);
  }

  // Number of these coordinates that the corners determine.
  [[nodiscard]] double determinedOf(const Eigen::MatrixXd& inverse, int axes) const {
    double trace = 0;
    double count = 0;
    for (Eigen::Index i = 0; i < count_; ++i) {
      if (axesOf(i) != axes) continue;
      trace += inverse(i, i);
      ++count;
    }
    for (const Mode& mode : modes_) {
      if (mode.axes != axes) continue;
      trace -= mode.direction.dot(inverse * mode.direction);
      --count;
    }
    return count - precision_(axes) * trace;
  }

  [[nodiscard]] Eigen::MatrixXd information() const {
    Eigen::MatrixXd matrix = Eigen::MatrixXd::Zero(count_, count_);
    for (Eigen::Index i = 0; i < count_; ++i) matrix(i, i) = precision_(axesOf(i));
    for (const Mode& mode : modes_)
      matrix += (mode.precision - precision_(mode.axes)) * mode.direction * mode.direction.transpose();
    return matrix;
  }

 private:
  struct Mode {
    Eigen::VectorXd direction;
    int axes = kInPlane;
    double precision = 0;
  };

  static int axesOf(Eigen::Index i) { return i % 3 == 2 ? kAcross : kInPlane; }

  Eigen::Index count_;
  Eigen::Vector2d precision_;
  std::vector<Mode> modes_;
};

// The present offsets of a board in the fit.
Eigen::VectorXd offsetsOf(const FitBoard& board) {
  Eigen::VectorXd offsets(3 * std::ssize(board.shape.offsets_m));
  for (std::size_t i = 0; i < board.shape.offsets_m.size(); ++i)
    offsets.segment<3>(3 * static_cast<Eigen::Index>(i)) = board.shape.offsets_m[i];
  return offsets;
}

// One of the boards whose offsets are estimated.
struct UnevenBoard {
  std::size_t board = 0;
  Eigen::Index first = 0;  // first column of its offsets
  Eigen::Index count = 0;
  double spacing = 0;
  OffsetPrior prior;
};

// The equations of the offsets with all other unknowns eliminated.
class OffsetEquations {
 public:
  // Nothing if the other unknowns are not determined.
  // @param priors  of the uneven boards; empty: initial ones without freed modes
  static std::optional<OffsetEquations> make(const Fit& fit, std::span<const OffsetPrior> priors = {}) {
    const JointColumns columns = jointColumns(fit, Offsets::kInclude);
    const Reduced all = equationsOf(fit, columns, LossWeights::kUse);
    OffsetEquations result;
    const auto first = std::ranges::find_if(columns.offsets, [](int at) { return at >= 0; });
    const Eigen::Index num_others = first == columns.offsets.end() ? columns.count : *first;
    const Eigen::Index num_offsets = columns.count - num_others;
    const Eigen::MatrixXd directions = jointDirections(fit, columns, all.information);
    const Eigen::Index num_free = directions.cols() - num_offsets;
    const auto others = directions.topLeftCorner(num_others, num_free);
    const Eigen::MatrixXd mixed = all.information.bottomLeftCorner(num_offsets, num_others) * others;
    const auto inverse =
        inverseOf(others.transpose() * all.information.topLeftCorner(num_others, num_others) * others);
    if (!inverse) return std::nullopt;
    result.information_ =
        all.information.bottomRightCorner(num_offsets, num_offsets) - mixed * *inverse * mixed.transpose();
    result.gradient_ = all.gradient.tail(num_offsets) -
                       mixed * (*inverse * (others.transpose() * all.gradient.head(num_others)));
    result.squares_ = 2 * fit.summary.cost;
    result.freedom_ = 2 * static_cast<double>(numCorners(fit)) - static_cast<double>(num_free) -
                      6 * static_cast<double>(fit.placements.size());
    result.offsets_.resize(num_offsets);
    for (std::size_t b = 0; b < fit.boards.size(); ++b) {
      if (columns.offsets[b] < 0) continue;
      const FitBoard& board = fit.boards[b];
      UnevenBoard uneven{.board = b,
                         .first = columns.offsets[b] - num_others,
                         .count = 3 * static_cast<Eigen::Index>(board.target.numCorners()),
                         .spacing = board.target.spacing(),
                         .prior = OffsetPrior(board)};
      if (!priors.empty()) uneven.prior = priors[result.boards_.size()];
      const Eigen::VectorXd offsets = offsetsOf(board);
      result.offsets_.segment(uneven.first, uneven.count) = offsets;
      result.boards_.push_back(std::move(uneven));
    }
    return result;
  }

  // Estimates the most likely scatter for these equations, and the offsets with it; false if there is no
  // solution.
  bool estimate() {
    constexpr int kMaxRounds = 30;
    constexpr double kSteady = 0.01;
    for (int round = 0; round < kMaxRounds; ++round) {
      if (!step()) return false;
      double change = 0;
      for (UnevenBoard& board : boards_) change = std::max(change, update(board));
      if (change < kSteady) break;
    }
    return step();
  }

  // Estimates the offsets with the present scatter and freed modes; false if there is no solution.
  bool freeModes() {
    if (!step()) return false;
    for (UnevenBoard& board : boards_)
      board.prior.freeModes(next_.segment(board.first, board.count), inverseOfBoard(board), variance_);
    return step();
  }

  // Estimates the offsets with the present scatter; false if there is no solution.
  bool step() {
    prior_ = Eigen::MatrixXd::Zero(information_.rows(), information_.cols());
    for (const UnevenBoard& board : boards_)
      prior_.block(board.first, board.first, board.count, board.count) = board.prior.information();
    const auto inverse = inverseOf(information_ + prior_);
    if (!inverse) return false;
    inverse_ = *inverse;
    next_ = inverse_ * (information_ * offsets_ - gradient_);
    const Eigen::VectorXd step = next_ - offsets_;
    const double squares = squares_ + 2 * gradient_.dot(step) + step.dot(information_ * step);
    const double num_determined = static_cast<double>(inverse_.rows()) - prior_.cwiseProduct(inverse_).sum();
    variance_ = std::max(squares, 0.0) / std::max(1.0, freedom_ - num_determined);
    return std::isfinite(variance_);
  }

  [[nodiscard]] std::vector<OffsetPrior> priors() const { return mapped(boards_, &UnevenBoard::prior); }

  // Variance of the errors after the step, divided by that without a step.
  [[nodiscard]] double varianceShare() const { return variance_ / (squares_ / freedom_); }

  // Writes the offsets and their scatter to the fit; returns the largest step as a share of the points'
  // spacing.
  double apply(Fit& fit) const {
    double largest = 0;
    for (const UnevenBoard& uneven : boards_) {
      FitBoard& board = fit.boards[uneven.board];
      *board.offset_precision = {uneven.prior.scatterPrecision(OffsetPrior::kInPlane),
                                 uneven.prior.scatterPrecision(OffsetPrior::kAcross)};
      const auto own = [&](const Eigen::VectorXd& all) { return all.segment(uneven.first, uneven.count); };
      for (Eigen::Index i = 0; i < uneven.count; ++i)
        board.shape.offsets_m[static_cast<std::size_t>(i / 3)](i % 3) = next_(uneven.first + i);
      const auto block = [&](const Eigen::MatrixXd& all) {
        return all.block(uneven.first, uneven.first, uneven.count, uneven.count);
      };
      board.num_free_offsets =
          static_cast<double>(uneven.count) - block(prior_).cwiseProduct(block(inverse_)).sum();
      largest = std::max(largest, (own(next_) - own(offsets_)).cwiseAbs().maxCoeff() / uneven.spacing);
    }
    return largest;
  }

 private:
  [[nodiscard]] Eigen::MatrixXd inverseOfBoard(const UnevenBoard& board) const {
    return inverse_.block(board.first, board.first, board.count, board.count);
  }

  // Sets the scatter and the modes of a board; returns the relative change of the scatter.
  double update(UnevenBoard& board) const {
    const Eigen::VectorXd offsets = next_.segment(board.first, board.count);
    const Eigen::MatrixXd inverse = inverseOfBoard(board);
    double largest = 0;
    for (const int axes : {OffsetPrior::kInPlane, OffsetPrior::kAcross}) {
      const double least = kLeastScatter * board.spacing;
      const double determined = board.prior.determinedOf(inverse, axes);
      const double scatter_m = std::max(
          least, determined > 0 ? std::sqrt(board.prior.squaresOf(offsets, axes) / determined) : 0.0);
      const double precision = variance_ / (scatter_m * scatter_m);
      const double change = std::abs(precision / board.prior.scatterPrecision(axes) - 1);
      board.prior.setScatterPrecision(axes, precision);
      if (scatter_m > least) largest = std::max(largest, change);
    }
    board.prior.freeModes(offsets, inverse, variance_);
    return largest;
  }

  Eigen::MatrixXd information_;
  Eigen::VectorXd gradient_;
  Eigen::VectorXd offsets_;  // present offsets of the fit
  Eigen::VectorXd next_;     // offsets after the step
  Eigen::MatrixXd prior_;    // prior of the last step
  Eigen::MatrixXd inverse_;  // inverse of the sum of `information_` and `prior_`
  std::vector<UnevenBoard> boards_;
  double squares_ = 0;
  double freedom_ = 0;  // degrees of freedom without the offsets
  double variance_ = 0;
};

// Makes boards even whose offsets the corners do not determine.
void evenOut(Fit& fit) {
  for (FitBoard& board : fit.boards) {
    if (!board.isUneven() || board.num_free_offsets >= kFewestOffsets) continue;
    makeEven(board);
  }
}

}  // namespace

void makeEven(FitBoard& board) {
  board.offset_precision.reset();
  board.num_free_offsets = 0;
  board.shape.offsets_m.clear();
}

Fit startedUneven(Fit fit, std::span<const std::size_t> boards) {
  const double sigma_px = noiseSigma(fit);
  for (const std::size_t b : boards) {
    if (numViews(fit, b) == 0) continue;
    FitBoard& board = fit.boards[b];
    const double scatter_m = kFirstScatter * board.target.spacing();
    board.offset_precision = Eigen::Vector2d::Constant(sigma_px * sigma_px / (scatter_m * scatter_m));
    board.shape.offsets_m.assign(static_cast<std::size_t>(board.target.numCorners()),
                                 Eigen::Vector3d::Zero());
  }
  return fit;
}

double varianceLeftByOffsets(const Fit& fit) {
  auto equations = OffsetEquations::make(fit);
  return equations && equations->estimate() ? equations->varianceShare() : 1.0;
}

std::optional<Fit> withOffsets(Fit fit, OffsetScatter scatter, const CancelFlag* cancel) {
  constexpr int kMaxSteps = 50;
  constexpr double kScatterAtRest = 1e-4;  // share of the points' spacing: the remaining change moves no
                                           // camera
  constexpr double kAtRest = 1e-7;
  constexpr double kLoose = 1e-9;  // share of the cost
  constexpr int kMaxChanges = 12;  // of the modes: a barely determined one may be freed and held forever
  if (!isAnyUneven(fit)) return fit;
  std::vector<OffsetPrior> kept;
  int num_changes = 0;
  for (int i = 0; isAnyUneven(fit); ++i) {
    if (i == kMaxSteps) return std::nullopt;
    auto equations = OffsetEquations::make(fit, kept);
    if (!equations) return std::nullopt;
    const bool is_estimated = scatter == OffsetScatter::kEstimate;
    const bool is_solved = is_estimated   ? equations->estimate()
                           : kept.empty() ? equations->freeModes()
                                          : equations->step();
    if (!is_solved) return std::nullopt;
    if (!is_estimated && kept.empty() && ++num_changes == kMaxChanges) kept = equations->priors();
    const double step = equations->apply(fit);
    if (is_estimated) evenOut(fit);
    if (step < kScatterAtRest) scatter = OffsetScatter::kKeep;
    const bool is_at_rest = step < kAtRest;
    const double tolerance = is_at_rest ? SolveOptions().function_tolerance : kLoose;
    fit = solve(std::move(fit), {.function_tolerance = tolerance, .cancel = cancel});
    const Termination end = fit.summary.termination;
    if (end == Termination::kFailed || end == Termination::kIterationLimit) return std::nullopt;
    if (is_at_rest) return fit;
  }
  return solve(std::move(fit), {.cancel = cancel});  // all boards have become even
}

std::optional<Eigen::MatrixXd> offsetShare(const Fit& fit) {
  const Eigen::Index num_columns = jointColumns(fit).count;
  if (!isAnyUneven(fit)) return Eigen::MatrixXd::Zero(num_columns, num_columns);
  const JointColumns columns = jointColumns(fit, Offsets::kInclude);
  Eigen::MatrixXd information = equationsOf(fit, columns, LossWeights::kLeaveOut).information;
  auto equations = OffsetEquations::make(fit);
  if (!equations || !equations->freeModes()) return std::nullopt;
  const std::vector<OffsetPrior> priors = equations->priors();
  std::size_t k = 0;
  for (std::size_t b = 0; b < fit.boards.size(); ++b) {
    if (columns.offsets[b] < 0) continue;
    const Eigen::MatrixXd of_board = priors[k++].information();
    information.block(columns.offsets[b], columns.offsets[b], of_board.rows(), of_board.cols()) += of_board;
  }
  const Eigen::MatrixXd directions = jointDirections(fit, columns, information);
  const Eigen::Index num_others = directions.cols() - (columns.count - num_columns);
  const Eigen::MatrixXd free = directions.transpose() * information * directions;
  const auto whole = inverseOf(free);
  const auto given = inverseOf(free.topLeftCorner(num_others, num_others));
  if (!whole || !given) return std::nullopt;
  const auto others = directions.topLeftCorner(num_columns, num_others);
  return Eigen::MatrixXd(others * (whole->topLeftCorner(num_others, num_others) - *given) *
                         others.transpose());
}

}  // namespace alidade
