// SPDX-License-Identifier: MIT
#include "alidade/adjust/board_offsets.h"

#include <algorithm>
#include <cmath>
#include <utility>
#include <vector>

#include <Eigen/Cholesky>

#include "alidade/adjust/joint_information.h"
#include "alidade/adjust/robust_weighting.h"
#include "alidade/adjust/solve.h"

namespace alidade {
namespace {

constexpr double kFirstScatter = 0.02;  // of the points' distance
constexpr double kLeastScatter = 1e-5;  // less is no offset
constexpr double kFewestOffsets = 3;    // coordinates that the corners determine

// The inverse of a symmetric positive definite matrix, scaled first; nothing for another one.
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

// The normal equations of the whole fit, what else is known of the lenses with them.
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

// A board's offsets in a plane or across it, among all that are estimated.
struct Scatter {
  std::size_t board = 0;
  int axes = 0;  // 0: in the plane, 1: across
  std::vector<Eigen::Index> at = {};
};

// The equations of the offsets with all other unknowns eliminated.
class OffsetEquations {
 public:
  // Nothing where the other unknowns are not determined.
  static std::optional<OffsetEquations> make(const Fit& fit) {
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
    result.precision_.resize(num_offsets);
    for (std::size_t b = 0; b < fit.boards.size(); ++b) {
      if (columns.offsets[b] >= 0) result.addBoard(fit, b, columns.offsets[b] - num_others);
    }
    return result;
  }

  // The likeliest scatter for these equations, and the offsets with it; false where there is no solution.
  bool estimate() {
    constexpr int kMaxRounds = 30;
    constexpr double kSteady = 0.01;
    for (int round = 0; round < kMaxRounds; ++round) {
      if (!step()) return false;
      double change = 0;
      for (const Scatter& scatter : scatters_) change = std::max(change, update(scatter));
      if (change < kSteady) break;
    }
    return step();
  }

  // The offsets with the scatter as it is; false where there is no solution.
  bool step() {
    Eigen::MatrixXd sum = information_;
    sum.diagonal() += precision_;
    const auto inverse = inverseOf(sum);
    if (!inverse) return false;
    next_ = *inverse * (information_ * offsets_ - gradient_);
    determined_ = 1 - precision_.array() * inverse->diagonal().array();
    const Eigen::VectorXd step = next_ - offsets_;
    const double squares = squares_ + 2 * gradient_.dot(step) + step.dot(information_ * step);
    variance_ = std::max(squares, 0.0) / std::max(1.0, freedom_ - determined_.sum());
    return std::isfinite(variance_);
  }

  // Of the errors, over what it is without a step.
  [[nodiscard]] double varianceShare() const { return variance_ / (squares_ / freedom_); }

  // Gives the fit the offsets and their scatter; returns the largest step over the points' distance.
  double apply(Fit& fit) const {
    double largest = 0;
    for (const Scatter& scatter : scatters_) {
      FitBoard& board = fit.boards[scatter.board];
      const double spacing = board.target.spacing();
      double& precision = (*board.offset_precision)(scatter.axes);
      precision = precision_(scatter.at.front());
      if (scatter.axes == 0) board.num_free_offsets = 0;
      for (const Eigen::Index at : scatter.at) {
        const Eigen::Index i = at - first_[scatter.board];
        board.shape.offsets_m[static_cast<std::size_t>(i / 3)](i % 3) = next_(at);
        board.num_free_offsets += determined_(at);
        largest = std::max(largest, std::abs(next_(at) - offsets_(at)) / spacing);
      }
    }
    return largest;
  }

 private:
  void addBoard(const Fit& fit, std::size_t b, Eigen::Index first) {
    const FitBoard& board = fit.boards[b];
    const Eigen::Index count = 3 * static_cast<Eigen::Index>(board.target.numCorners());
    first_.resize(fit.boards.size());
    first_[b] = first;
    Scatter in_plane{.board = b, .axes = 0};
    Scatter across{.board = b, .axes = 1};
    for (Eigen::Index i = 0; i < count; ++i) {
      const bool is_across = i % 3 == 2;
      (is_across ? across : in_plane).at.push_back(first + i);
      offsets_(first + i) = board.shape.offsets_m[static_cast<std::size_t>(i / 3)](i % 3);
      precision_(first + i) = (*board.offset_precision)(is_across ? 1 : 0);
    }
    spacing_.resize(fit.boards.size());
    spacing_[b] = board.target.spacing();
    scatters_.push_back(std::move(in_plane));
    scatters_.push_back(std::move(across));
  }

  // The relative change of a scatter.
  double update(const Scatter& scatter) {
    double squares = 0;
    double determined = 0;
    for (const Eigen::Index at : scatter.at) {
      squares += next_(at) * next_(at);
      determined += determined_(at);
    }
    const double least = kLeastScatter * spacing_[scatter.board];
    const double scatter_m = std::max(least, determined > 0 ? std::sqrt(squares / determined) : 0.0);
    const double precision = variance_ / (scatter_m * scatter_m);
    const double change = std::abs(precision / precision_(scatter.at.front()) - 1);
    for (const Eigen::Index at : scatter.at) precision_(at) = precision;
    return scatter_m > least ? change : 0.0;
  }

  Eigen::MatrixXd information_;
  Eigen::VectorXd gradient_;
  Eigen::VectorXd offsets_;     // as they are in the fit
  Eigen::VectorXd next_;        // and after the step
  Eigen::VectorXd precision_;   // of each
  Eigen::VectorXd determined_;  // the share of each that the corners determine
  std::vector<Scatter> scatters_;
  std::vector<Eigen::Index> first_;  // of each board
  std::vector<double> spacing_;      // of each board
  double squares_ = 0;
  double freedom_ = 0;  // without the offsets
  double variance_ = 0;
};

// Boards whose offsets the corners do not determine are even.
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
  constexpr double kScatterAtRest = 1e-4;  // of the points' distance: what is left moves no camera
  constexpr double kAtRest = 1e-7;
  constexpr double kLoose = 1e-9;  // of the cost
  if (!isAnyUneven(fit)) return fit;
  for (int i = 0; isAnyUneven(fit); ++i) {
    if (i == kMaxSteps) return std::nullopt;
    auto equations = OffsetEquations::make(fit);
    if (!equations) return std::nullopt;
    const bool is_estimated = scatter == OffsetScatter::kEstimate;
    if (!(is_estimated ? equations->estimate() : equations->step())) return std::nullopt;
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
  return solve(std::move(fit), {.cancel = cancel});  // all boards are even again
}

std::optional<Eigen::MatrixXd> offsetShare(const Fit& fit) {
  const Eigen::Index num_columns = jointColumns(fit).count;
  if (!isAnyUneven(fit)) return Eigen::MatrixXd::Zero(num_columns, num_columns);
  const JointColumns columns = jointColumns(fit, Offsets::kInclude);
  Eigen::MatrixXd information = equationsOf(fit, columns, LossWeights::kLeaveOut).information;
  for (std::size_t b = 0; b < fit.boards.size(); ++b) {
    if (columns.offsets[b] < 0) continue;
    for (int i = 0; i < 3 * fit.boards[b].target.numCorners(); ++i) {
      const int at = columns.offsets[b] + i;
      information(at, at) += (*fit.boards[b].offset_precision)(i % 3 == 2 ? 1 : 0);
    }
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
