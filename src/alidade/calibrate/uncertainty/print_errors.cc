// SPDX-License-Identifier: MIT
#include "alidade/calibrate/uncertainty/print_errors.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "alidade/core/number_text.h"
#include "alidade/core/text.h"
#include "alidade/geometry/decompositions.h"

namespace alidade {
namespace {

// The share of an error in the offsets of an uneven board: their least-squares fit by a motion in the plane,
// a scale and this error.
// @param at  the displacement of a point per unit of the error
template <class At>
double shareIn(const FitBoard& board, const At& at) {
  using Columns = Eigen::Matrix<double, Eigen::Dynamic, 5>;
  const auto count = std::ssize(board.shape.offsets_m);
  Columns J(2 * count, 5);
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
  return inverse ? (*inverse * (J.transpose() * offsets))(4) : 0.0;
}

}  // namespace

std::vector<Eigen::Vector3d> gapOffsets(const Board& board) {
  const std::optional<double> gap = board.gap();
  if (!gap) return {};
  std::vector<Eigen::Vector3d> offsets = board.withGap(*gap + 1).corners();
  for (std::size_t i = 0; i < offsets.size(); ++i) offsets[i] -= board.corners()[i];
  return offsets;
}

std::optional<CommonError> printError(const Fit& fit, std::span<const CommonError> errors, CommonCause cause,
                                      std::size_t board) {
  const auto found = std::ranges::find_if(
      errors, [&](const CommonError& error) { return error.cause == cause && error.board == board; });
  if (found == errors.end()) return std::nullopt;
  CommonError error = *found;
  const FitBoard& of = fit.boards[board];
  if (!of.isUneven()) return error;
  const std::vector<Eigen::Vector3d> by_gap = gapOffsets(of.target);
  error.value += shareIn(of, [&](std::size_t id, const Eigen::Vector3d& p) {
    return cause == CommonCause::kGap ? by_gap[id] : Eigen::Vector3d(p.x(), 0, 0);
  });
  return error;
}

double sureStretch(const CommonError& stretch) {
  constexpr double kSigmas = 2;
  if (!(stretch.sigmas() > kSigmas)) return 0;
  return std::sqrt(stretch.value * stretch.value - stretch.sigma * stretch.sigma);
}

double sizeStd(const FitBoard& board, const CommonError& stretch) {
  // If the stretch is not estimated with everything else, a length is as wrong as one side.
  return sureStretch(stretch) / (board.isUneven() ? 2 : std::numbers::sqrt2);
}

bool reviseGaps(const Fit& fit, std::span<const CommonError> errors, std::span<const Board> stated,
                std::vector<Board>& boards) {
  constexpr double kRefuted = 5e-3;  // of the board's size; blur and spread of ink change it by up to 0.2 %
  constexpr double kExact = 1e-3;    // for a gap that is already estimated
  constexpr double kSigmas = 5;
  bool is_any = false;
  for (std::size_t b = 0; b < boards.size(); ++b) {
    if (stated[b].refutedGap()) continue;
    const auto error = printError(fit, errors, CommonCause::kGap, b);
    if (!error || !(error->sigmas() > kSigmas)) continue;
    const double gap = *boards[b].gap();
    if (!(std::abs(error->value) / (1 + gap) > (boards[b].refutedGap() ? kExact : kRefuted))) continue;
    boards[b] = boards[b].withGap(*parseDouble(numberText("%.4g", gap + error->value)));
    is_any = true;
  }
  return is_any;
}

}  // namespace alidade
