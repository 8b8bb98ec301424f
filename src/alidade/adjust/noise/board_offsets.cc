// SPDX-License-Identifier: MIT
#include "alidade/adjust/noise/board_offsets.h"

#include <algorithm>
#include <cmath>
#include <utility>
#include <vector>

#include "alidade/adjust/board/solve.h"
#include "alidade/adjust/noise/joint_information.h"
#include "alidade/adjust/noise/robust_weighting.h"
#include "alidade/geometry/decompositions.h"

namespace alidade {
namespace {

constexpr double kFirstScatter = 0.02;  // share of the points' spacing
constexpr double kLeastScatter = 1e-5;  // smaller offsets count as zero
constexpr double kFewestOffsets = 3;    // number of coordinates that the corners determine

// The normal equations of the whole fit, including the priors of the lenses.
JointEquations equationsOf(const Fit& fit, const JointColumns& columns, LossWeights weights) {
  JointEquations sum = jointEquations(fit, columns, weights);
  for (std::size_t c = 0; c < fit.cameras.size(); ++c) {
    const FitCamera& camera = fit.cameras[c];
    camera.weak_prior.prior.addTo(camera.params, sum.information, sum.gradient, columns.params[c]);
  }
  return sum;
}

// Orthonormal directions of a board's offsets (x, y, z of each point) that deform the board as a whole:
// stretch, shear, gradation, twist or bend. Directions that keep its shape are excluded, and their share is
// removed from the others.
std::vector<Eigen::VectorXd> smoothModes(const Board& target) {
  using Offset = Eigen::Vector3d;
  const Offset middle = target.middle();
  std::vector<Eigen::VectorXd> basis;
  const auto add = [&](const auto& offsetAt) {
    constexpr double kNothing = 1e-6;
    Eigen::VectorXd offsets(3 * target.numCorners());
    for (int i = 0; i < target.numCorners(); ++i) {
      const Offset p = (target.corner(i) - middle) / middle.head<2>().norm();
      offsets.segment<3>(3 * i) = offsetAt(p.x(), p.y());
    }
    const double norm = offsets.norm();
    for (const Eigen::VectorXd& other : basis) offsets -= other.dot(offsets) * other;
    if (offsets.norm() > kNothing * norm) basis.push_back(offsets.normalized());
  };
  for (const int axis : {0, 1, 2}) add([&](double, double) { return Offset(Offset::Unit(axis)); });
  add([](double x, double y) { return Offset(-y, x, 0); });
  add([](double x, double y) { return Offset(x, y, 0); });
  add([](double x, double) { return Offset(0, 0, x); });
  add([](double, double y) { return Offset(0, 0, y); });
  const auto num_of_pose_and_size = static_cast<std::ptrdiff_t>(basis.size());
  add([](double x, double y) { return Offset(x, -y, 0); });
  add([](double x, double y) { return Offset(y, x, 0); });
  for (const int axis : {0, 1, 2}) {
    add([&](double x, double) { return Offset(x * x * Offset::Unit(axis)); });
    add([&](double x, double y) { return Offset(x * y * Offset::Unit(axis)); });
    add([&](double, double y) { return Offset(y * y * Offset::Unit(axis)); });
  }
  return {basis.begin() + num_of_pose_and_size, basis.end()};
}

// A board whose offsets are estimated, with their prior: each coordinate scatters about zero, in the plane or
// normal to it, and each smooth mode has its own estimated scatter. If all points scattered independently, a
// stretch of the board would seem much better known than it is.
class UnevenBoard {
 public:
  // @param first  index of its first offset among those of all boards
  UnevenBoard(const FitBoard& board, std::size_t index, Eigen::Index first)
      : index_(index),
        first_(first),
        count_(3 * static_cast<Eigen::Index>(board.target.numCorners())),
        spacing_(board.target.spacing()),
        precision_(*board.offset_precision) {
    for (Eigen::VectorXd& direction : smoothModes(board.target)) {
      bool is_across = false;
      for (Eigen::Index i = 2; i < count_; i += 3) is_across = is_across || direction(i) != 0;
      const int axes = is_across ? kAcross : kInPlane;
      modes_.push_back({.direction = std::move(direction), .axes = axes, .precision = precision_(axes)});
    }
  }

  // This board's part of a vector over the offsets of all boards.
  [[nodiscard]] auto own(Eigen::VectorXd& all) const { return all.segment(first_, count_); }
  [[nodiscard]] auto own(const Eigen::VectorXd& all) const { return all.segment(first_, count_); }

  // The information of the prior: a diagonal, less the product of the roots with themselves.
  [[nodiscard]] Eigen::VectorXd diagonal() const {
    Eigen::VectorXd precisions(count_);
    for (Eigen::Index i = 0; i < count_; ++i) precisions(i) = precision_(axesOf(i));
    return precisions;
  }
  [[nodiscard]] Eigen::MatrixXd roots(Eigen::Index num_all) const {
    Eigen::MatrixXd rows = modes(num_all).transpose();
    for (Eigen::Index k = 0; k < rows.rows(); ++k) {
      const Mode& mode = modes_[static_cast<std::size_t>(k)];
      rows.row(k) *= std::sqrt(std::max(0.0, precision_(mode.axes) - mode.precision));
    }
    return rows;
  }
  // Number of offsets that the prior determines.
  [[nodiscard]] double numHeld(const OffsetMatrix& inverse) const {
    const Eigen::VectorXd of_points = inverse.diagonal();
    const Eigen::MatrixXd columns = roots(of_points.size()).transpose();
    return own(of_points).dot(diagonal()) - columns.cwiseProduct(inverse.times(columns)).sum();
  }

  // Sets the scatter and the modes; returns the largest relative change of a scatter.
  double update(const Eigen::VectorXd& offsets, const OffsetMatrix& inverse, double variance) {
    double largest = 0;
    const Eigen::VectorXd all_points = inverse.diagonal();
    const Eigen::VectorXd of_points = own(all_points);
    const Eigen::MatrixXd of_modes = ofModes(inverse);
    for (const int axes : {kInPlane, kAcross}) {
      const double least = kLeastScatter * spacing_;
      const double determined = determinedOf(of_points, of_modes, axes);
      const double scatter_m =
          std::max(least, determined > 0 ? std::sqrt(squaresOf(offsets, axes) / determined) : 0.0);
      const double precision = variance / (scatter_m * scatter_m);
      const double change = std::abs(precision / precision_(axes) - 1);
      precision_(axes) = precision;
      if (scatter_m > least) largest = std::max(largest, change);
    }
    for (Mode& mode : modes_) mode.precision = std::min(mode.precision, precision_(mode.axes));
    freeModes(offsets, of_modes, variance);
    return largest;
  }

  // Sets the variance of each mode to its most likely value: the square of the amplitude that the corners
  // alone give, minus their own variance. It is at least the variance of the scatter. The result does not
  // depend on the previous variances.
  // @param of_modes  see ofModes(); a covariance when multiplied by `variance`
  void freeModes(const Eigen::VectorXd& offsets, const Eigen::MatrixXd& of_modes, double variance) {
    constexpr int kMaxRounds = 100;
    constexpr double kSteady = 1e-9;
    constexpr double kSomething = 0.01;  // least share of the corners in the information on a mode
    // Information on the amplitudes with all other offsets eliminated, with and without the modes' own
    // priors.
    const auto known = scaledInverseSpd(of_modes);
    if (!known) return;
    const Eigen::VectorXd gradient = *known * (modes(count_, 0).transpose() * offsets);
    Eigen::MatrixXd by_others = *known;
    by_others.diagonal() -= heldBy();
    for (int round = 0; round < kMaxRounds; ++round) {
      Eigen::MatrixXd sum = by_others;
      sum.diagonal() += heldBy();
      const auto posterior = scaledInverseSpd(sum);
      if (!posterior) return;
      const Eigen::VectorXd amplitudes = *posterior * gradient;
      double change = 0;
      Eigen::Index k = 0;
      for (Mode& mode : modes_) {
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
        ++k;
      }
      if (change < kSteady) return;
    }
  }

  // The part of the modes in the inverse of the sum of the corners' information and this prior.
  [[nodiscard]] Eigen::MatrixXd ofModes(const OffsetMatrix& inverse) const {
    const Eigen::MatrixXd U = modes(inverse.diagonal().size());
    return U.transpose() * inverse.times(U);
  }

  // Writes the offsets and their scatter to the fit; returns the largest step as a share of the points'
  // spacing.
  double apply(const Eigen::VectorXd& step, const Eigen::VectorXd& offsets, double num_free, Fit& fit) const {
    FitBoard& board = fit.boards[index_];
    *board.offset_precision = precision_;
    for (Eigen::Index i = 0; i < count_; ++i)
      board.shape.offsets_m[static_cast<std::size_t>(i / 3)](i % 3) = offsets(i);
    board.num_free_offsets = num_free;
    return step.cwiseAbs().maxCoeff() / spacing_;
  }

 private:
  struct Mode {
    Eigen::VectorXd direction;
    int axes = kInPlane;
    double precision = 0;
  };

  static constexpr int kInPlane = 0;
  static constexpr int kAcross = 1;

  static int axesOf(Eigen::Index i) { return i % 3 == 2 ? kAcross : kInPlane; }

  [[nodiscard]] Eigen::VectorXd heldBy() const {
    Eigen::VectorXd precisions(static_cast<Eigen::Index>(modes_.size()));
    std::ranges::transform(modes_, precisions.data(), &Mode::precision);
    return precisions;
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

  // The directions of the modes, one per column, among the offsets of all boards.
  [[nodiscard]] Eigen::MatrixXd modes(Eigen::Index num_all) const { return modes(num_all, first_); }
  [[nodiscard]] Eigen::MatrixXd modes(Eigen::Index num_all, Eigen::Index first) const {
    Eigen::MatrixXd U = Eigen::MatrixXd::Zero(num_all, std::ssize(modes_));
    Eigen::Index column = 0;
    for (const Mode& mode : modes_) U.col(column++).segment(first, count_) = mode.direction;
    return U;
  }

  // Number of these coordinates that the corners determine.
  [[nodiscard]] double determinedOf(const Eigen::VectorXd& of_points, const Eigen::MatrixXd& of_modes,
                                    int axes) const {
    double trace = 0;
    double count = 0;
    for (Eigen::Index i = 0; i < count_; ++i) {
      if (axesOf(i) != axes) continue;
      trace += of_points(i);
      ++count;
    }
    for (Eigen::Index k = 0; k < of_modes.cols(); ++k) {
      if (modes_[static_cast<std::size_t>(k)].axes != axes) continue;
      trace -= of_modes(k, k);
      --count;
    }
    return count - precision_(axes) * trace;
  }

  std::size_t index_;
  Eigen::Index first_;
  Eigen::Index count_;
  double spacing_;
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

// The equations of the offsets with all other unknowns eliminated.
class OffsetEquations {
 public:
  // Nothing if the other unknowns are not determined.
  // @param kept  the uneven boards so far; empty: initial ones without freed modes
  static std::optional<OffsetEquations> make(const Fit& fit, const std::vector<UnevenBoard>& kept = {},
                                             LossWeights weights = LossWeights::kUse) {
    const JointColumns columns = jointColumns(fit, Offsets::kInclude);
    JointEquations all = equationsOf(fit, columns, weights);
    OffsetEquations result;
    const Eigen::Index num_others = columns.num_others;
    const Eigen::Index num_offsets = columns.count - num_others;
    // Plain matrices, because each type of block would need a compiled product of its own.
    const Eigen::MatrixXd own = all.information.topRows(num_others);
    result.others_ = jointDirections(fit, jointColumns(fit), own);
    const Eigen::MatrixXd& others = result.others_;
    const Eigen::MatrixXd coupling = all.information.bottomRows(num_offsets);
    const Eigen::MatrixXd mixed = coupling * others;
    const auto inverse = scaledInverseSpd(others.transpose() * own * others);
    if (!inverse) return std::nullopt;
    result.gains_ = mixed * *inverse;
    result.information_ = std::move(all.of_offsets);
    OffsetMatrix& information = result.information_;
    if (information.full.size() > 0) {
      information.full -= result.gains_ * mixed.transpose();
    } else {
      const Eigen::MatrixXd roots = (mixed * choleskyOf(*inverse)).transpose();
      information.roots.conservativeResize(information.roots.rows() + roots.rows(), num_offsets);
      information.roots.bottomRows(roots.rows()) = roots;
    }
    result.gradient_ =
        all.gradient.tail(num_offsets) - result.gains_ * (others.transpose() * all.gradient.head(num_others));
    result.squares_ = 2 * fit.summary.cost;
    result.freedom_ = 2 * static_cast<double>(numCorners(fit)) - static_cast<double>(others.cols()) -
                      6 * static_cast<double>(fit.placements.size());
    result.offsets_.resize(num_offsets);
    for (std::size_t b = 0; b < fit.boards.size(); ++b) {
      if (columns.offsets[b] < 0) continue;
      result.boards_.push_back(kept.empty() ? UnevenBoard(fit.boards[b], b, columns.offsets[b] - num_others)
                                            : kept[result.boards_.size()]);
      result.boards_.back().own(result.offsets_) = offsetsOf(fit.boards[b]);
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
      for (UnevenBoard& board : boards_)
        change = std::max(change, board.update(board.own(next_), inverse_, variance_));
      if (change < kSteady) break;
    }
    return step();
  }

  // Estimates the offsets with the present scatter and freed modes; false if there is no solution.
  bool freeModes() {
    if (!step()) return false;
    for (UnevenBoard& board : boards_) board.freeModes(board.own(next_), board.ofModes(inverse_), variance_);
    return step();
  }

  // Estimates the offsets with the present scatter; false if there is no solution.
  bool step() {
    if (!invert()) return false;
    next_ = inverse_.times(information_.times(offsets_) - gradient_);
    const Eigen::VectorXd step = next_ - offsets_;
    const double squares = squares_ + 2 * gradient_.dot(step) + step.dot(information_.times(step).col(0));
    double num_determined = static_cast<double>(next_.size());
    for (const UnevenBoard& board : boards_) num_determined -= board.numHeld(inverse_);
    freedom_left_ = std::max(1.0, freedom_ - num_determined);
    variance_ = std::max(squares, 0.0) / freedom_left_;
    return std::isfinite(variance_);
  }

  // By how much the covariance of the other unknowns grows because the offsets are uncertain, per variance.
  [[nodiscard]] Eigen::MatrixXd share() const {
    const Eigen::MatrixXd by_offsets = gains_ * others_.transpose();
    return by_offsets.transpose() * inverse_.times(by_offsets);
  }

  [[nodiscard]] const std::vector<UnevenBoard>& boards() const { return boards_; }

  // Variance of the errors after the step, divided by that without a step.
  [[nodiscard]] double varianceShare() const { return variance_ / (squares_ / freedom_); }
  [[nodiscard]] double shareStd() const { return varianceShare() * std::sqrt(2 / freedom_left_); }

  // Writes the offsets and their scatter to the fit; returns the largest step as a share of the points'
  // spacing.
  double apply(Fit& fit) const {
    double largest = 0;
    for (const UnevenBoard& board : boards_) {
      const Eigen::VectorXd next = board.own(next_);
      const double num_free = static_cast<double>(next.size()) - board.numHeld(inverse_);
      largest = std::max(largest, board.apply(next - board.own(offsets_), next, num_free, fit));
    }
    return largest;
  }

 private:
  // Inverts the sum of the information and the prior; false if it is singular.
  bool invert() {
    const Eigen::Index count = offsets_.size();
    Eigen::VectorXd diagonal(count);
    Eigen::MatrixXd roots = information_.roots;
    for (const UnevenBoard& board : boards_) {
      board.own(diagonal) = board.diagonal();
      const Eigen::MatrixXd of_board = board.roots(count);
      roots.conservativeResize(roots.rows() + of_board.rows(), count);
      roots.bottomRows(of_board.rows()) = of_board;
    }
    if (information_.full.size() > 0) {
      Eigen::MatrixXd sum = information_.full - roots.transpose() * roots;
      sum.diagonal() += diagonal;
      const auto inverse = scaledInverseSpd(sum);
      if (inverse) inverse_ = {.full = *inverse};
      return inverse.has_value();
    }
    // Woodbury 1950, Inverting modified matrices.
    Eigen::MatrixXd blocks(count, 3);
    Eigen::MatrixXd solved(count, roots.rows());
    for (Eigen::Index i = 0; i < count; i += 3) {
      Eigen::Matrix3d block = information_.blocks.middleRows<3>(i);
      block.diagonal() += diagonal.segment<3>(i);
      blocks.middleRows<3>(i) = inverseSpd(block);
      solved.middleRows<3>(i) = blocks.middleRows<3>(i) * roots.middleCols<3>(i).transpose();
    }
    Eigen::MatrixXd rest = Eigen::MatrixXd::Identity(roots.rows(), roots.rows());
    rest.triangularView<Eigen::Lower>() -= roots * solved;
    const auto inverse_root = inverseRootOf(rest);
    if (!inverse_root) return false;
    inverse_ = {.blocks = std::move(blocks), .roots = (solved * *inverse_root).transpose()};
    return true;
  }

  OffsetMatrix information_;  // with all other unknowns eliminated
  Eigen::MatrixXd others_;    // free directions of the unknowns before the offsets
  Eigen::MatrixXd gains_;     // of these by the offsets
  Eigen::VectorXd gradient_;
  Eigen::VectorXd offsets_;  // present offsets of the fit
  Eigen::VectorXd next_;     // offsets after the step
  OffsetMatrix inverse_;     // of the sum of the information and the prior
  std::vector<UnevenBoard> boards_;
  double squares_ = 0;
  double freedom_ = 0;       // degrees of freedom without the offsets
  double freedom_left_ = 1;  // with them
  double variance_ = 0;
};

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

double varianceLeftByOffsets(const Fit& fit, double limit) {
  auto equations = OffsetEquations::make(fit);
  if (!equations) return 1;
  if (std::isfinite(limit)) {
    // The first scatter hardly holds the offsets: what they leave of the variance is noise.
    constexpr double kChance = 3;
    if (!equations->step()) return 1;
    if (equations->varianceShare() > limit + kChance * equations->shareStd())
      return equations->varianceShare();
  }
  return equations->estimate() ? equations->varianceShare() : 1;
}

std::optional<Fit> withOffsets(Fit fit, OffsetScatter scatter, const CancelFlag* cancel, double at_rest) {
  constexpr int kMaxSteps = 50;
  constexpr double kScatterAtRest = 1e-4;  // share of the points' spacing: the remaining change moves no
                                           // camera
  constexpr double kLoose = 1e-9;          // share of the cost
  constexpr int kMaxChanges = 12;  // of the modes: a barely determined one may be freed and held forever
  if (!isAnyUneven(fit)) return fit;
  std::vector<UnevenBoard> kept;
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
    if (!is_estimated && kept.empty() && ++num_changes == kMaxChanges) kept = equations->boards();
    const double step = equations->apply(fit);
    for (FitBoard& board : fit.boards) {  // boards with undetermined offsets become even
      if (is_estimated && board.isUneven() && board.num_free_offsets < kFewestOffsets) makeEven(board);
    }
    if (step < kScatterAtRest) scatter = OffsetScatter::kKeep;
    const bool is_at_rest = step < at_rest;
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
  auto equations = OffsetEquations::make(fit);
  if (!equations || !equations->freeModes()) return std::nullopt;
  auto unweighted = OffsetEquations::make(fit, equations->boards(), LossWeights::kLeaveOut);
  if (!unweighted || !unweighted->step()) return std::nullopt;
  return unweighted->share();
}

}  // namespace alidade
