// SPDX-License-Identifier: MIT
#include "alidade/calibrate/uncertainty/print_errors.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "alidade/core/median.h"
#include "alidade/core/number_text.h"
#include "alidade/core/text.h"
#include "alidade/geometry/decompositions.h"

namespace alidade {
namespace {

// The share of an error in the offsets of an uneven board, and its standard deviation by the other offsets:
// a least-squares fit by a motion in the plane, a scale and this error.
// @param at  the displacement of a point per unit of the error
template <class At>
void addShare(const FitBoard& board, const At& at, CommonError& error) {
  constexpr int kUnknowns = 5;
  const auto count = std::ssize(board.shape.offsets_m);
  Eigen::MatrixXd J(2 * count, kUnknowns);
  Eigen::VectorXd offsets(2 * count);
  for (Eigen::Index i = 0; i < count; ++i) {
    const auto id = static_cast<std::size_t>(i);
    const Eigen::Vector3d p = board.target.corners()[id] - board.target.middle();
    const Eigen::Vector3d by_error = at(id, p);
    J.row(2 * i) << 1, 0, -p.y(), p.x(), by_error.x();
    J.row(2 * i + 1) << 0, 1, p.x(), p.y(), by_error.y();
    offsets.segment<2>(2 * i) = board.shape.offsets_m[id].head<2>();
  }
  const auto inverse = scaledInverseSpd(J.transpose() * J);
  if (!inverse || J.rows() <= kUnknowns) return;
  const Eigen::VectorXd values = *inverse * (J.transpose() * offsets);
  const double squares = (offsets - J * values).squaredNorm();
  error.value += values(kUnknowns - 1);
  error.sigma = std::hypot(error.sigma, std::sqrt(squares / static_cast<double>(J.rows() - kUnknowns) *
                                                  (*inverse)(kUnknowns - 1, kUnknowns - 1)));
}

// Root of the variance of an error beyond that of its estimate.
double sureValue(const CommonError* error) {
  constexpr double kSigmas = 2;
  if (error == nullptr || !(error->sigmas() > kSigmas)) return 0;
  return std::sqrt(error->value * error->value - error->sigma * error->sigma);
}

// Median side of a board's tags in the images, px.
double tagPixels(const Fit& fit, std::size_t board) {
  std::vector<double> sides;
  for (const FitView& view : fit.views) {
    if (view.board != board) continue;
    for (std::size_t i = 1; i < view.corners.size(); ++i) {
      const Observation& left = view.corners[i - 1];
      if (left.id % 2 == 0 && view.corners[i].id == left.id + 1)
        sides.push_back((view.corners[i].pixel - left.pixel).norm());
    }
  }
  return sides.empty() ? 0 : medianOf(sides);
}

}  // namespace

std::vector<Eigen::Vector3d> gapOffsets(const Board& board) {
  const std::optional<double> gap = board.gap();
  if (!gap) return {};
  std::vector<Eigen::Vector3d> offsets = board.withGap(*gap + 1).corners();
  for (std::size_t i = 0; i < offsets.size(); ++i) offsets[i] -= board.corners()[i];
  return offsets;
}

void includeOffsets(const Fit& fit, std::vector<CommonError>& errors) {
  // Where the views do not determine a gap beside the parameters of a large lens model, the offsets do.
  for (std::size_t b = 0; b < fit.boards.size(); ++b) {
    if (fit.boards[b].isUneven() && fit.boards[b].target.gap() &&
        findError(errors, CommonCause::kGap, b) == nullptr)
      errors.push_back({.cause = CommonCause::kGap, .board = b});
  }
  for (CommonError& error : errors) {
    const FitBoard& board = fit.boards[error.board];
    if (!board.isUneven()) continue;
    const std::vector<Eigen::Vector3d> by_gap = gapOffsets(board.target);
    if (error.cause == CommonCause::kStretch)
      addShare(
          board, [](std::size_t, const auto& p) { return Eigen::Vector3d(p.x(), 0, 0); }, error);
    if (error.cause == CommonCause::kGap)
      addShare(
          board, [&](std::size_t id, const auto&) { return by_gap[id]; }, error);
  }
}

const CommonError* findError(std::span<const CommonError> errors, CommonCause cause, std::size_t board) {
  const auto found = std::ranges::find_if(
      errors, [&](const CommonError& error) { return error.cause == cause && error.board == board; });
  return found == errors.end() ? nullptr : &*found;
}

DenseMatrix ignoredStretches(const std::vector<FitBoard>& boards, std::span<const CommonError> errors) {
  const auto num_params = errors.empty() ? 0 : std::ssize(errors.front().params_step);
  Eigen::MatrixXd changes = Eigen::MatrixXd::Zero(num_params, std::ssize(boards));
  for (std::size_t b = 0; b < boards.size(); ++b) {
    const CommonError* stretch = findError(errors, CommonCause::kStretch, b);
    const double sure = sureValue(stretch);
    if (sure == 0 || boards[b].isUneven()) continue;
    const Eigen::Map<const Eigen::VectorXd> whole(stretch->params_step.data(), num_params);
    changes.col(static_cast<Eigen::Index>(b)) = sure / std::abs(stretch->value) * whole;
  }
  return changes;
}

double sizeStd(const FitBoard& of, std::span<const CommonError> errors, std::size_t board) {
  // If the stretch is not estimated with everything else, a length is as wrong as one side.
  const double by_stretch =
      sureValue(findError(errors, CommonCause::kStretch, board)) / (of.isUneven() ? 2 : std::numbers::sqrt2);
  const double by_gap = sureValue(findError(errors, CommonCause::kGap, board)) /
                        (1 + of.target.gap().value_or(0)) / std::numbers::sqrt2;
  return std::hypot(by_stretch, by_gap);
}

bool isGapContradicted(const Board& board, const CommonError& gap) {
  constexpr double kPrint = 5e-3;  // of the board's size
  constexpr double kSigmas = 5;
  return gap.sigmas() > kSigmas && std::abs(gap.value) > kPrint * (1 + *board.gap());
}

bool isOfSpec(const Diagnosis& diagnosis) {
  return diagnosis.id == DiagnosisId("board_gap");
}

Board withSeenGap(const Board& board, double gap) {
  return board.withGap(*parseDouble(numberText("%.4g", std::clamp(gap, kLeastTagGap, kLargestTagGap))));
}

bool reviseGaps(const Fit& fit, std::span<const CommonError> errors, std::span<const Board> stated,
                std::vector<Board>& boards) {
  constexpr double kBloomingPx = 0.6;  // on both sides of a gap together, in pictures that are overexposed
  constexpr double kExact = 2e-4;      // of the board's size, for a gap that is already estimated
  bool is_any = false;
  for (std::size_t b = 0; b < boards.size(); ++b) {
    const CommonError* error = findError(errors, CommonCause::kGap, b);
    if (error == nullptr || stated[b].refutedGap()) continue;
    const bool is_open = boards[b].refutedGap()
                             ? std::abs(error->value) > kExact * (1 + *boards[b].gap())
                             : isGapContradicted(boards[b], *error) &&
                                   std::abs(error->value) * tagPixels(fit, b) > kBloomingPx;
    const Board revised = is_open ? withSeenGap(boards[b], *boards[b].gap() + error->value) : boards[b];
    is_any = is_any || !(revised == boards[b]);
    boards[b] = revised;
  }
  return is_any;
}

}  // namespace alidade
