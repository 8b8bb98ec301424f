// SPDX-License-Identifier: MIT
#include <algorithm>
#include <cmath>
#include <cstddef>
#include <string>
#include <vector>

#include "alidade/calibrate/bend/shape_fit.h"
#include "alidade/calibrate/judge/judge.h"
#include "alidade/calibrate/uncertainty/print_errors.h"
#include "alidade/core/number_text.h"
#include "alidade/core/text.h"

namespace alidade::detail {
namespace {

// The larger bend as a share of the board's size in its direction.
double bendShare(const FitBoard& board) {
  const Board& target = board.target;
  return std::max(std::abs(board.shape.bend_x_m) / target.span().x(),
                  std::abs(board.shape.bend_y_m) / target.span().y());
}

// The tag's side is taken to be right, so lengths are as far off as the board's size.
void boardGap(Evidence& of) {
  constexpr double kWrong = 0.01;  // of the board's size
  for (std::size_t b = 0; b < of.fit.boards.size(); ++b) {
    const Board& board = of.fit.boards[b].target;
    const CommonError* error = findError(of.uncertainty.common_errors, CommonCause::kGap, b);
    if (error == nullptr || !(board.refutedGap() || isGapContradicted(board, *error))) continue;
    const double stated = board.refutedGap().value_or(*board.gap());
    const double seen = *board.gap() + error->value;
    const bool is_wrong = board.refutedGap() && std::abs(seen - stated) > kWrong * (1 + stated);
    of.add({.id = "board_gap",
            .severity = is_wrong ? Severity::kFailure : Severity::kWarning,
            .cause = "the gap between the board's tags contradicts the SPEC" + boardSuffix(of.fit, b),
            .evidence = numberText("%.4g", seen) + " +- " + numberText("%.1g", error->sigma) +
                        " of a tag's side, not " + numberText("%.6g", stated),
            .next_step = board.refutedGap()
                             ? "measure a tag and a gap, and correct the SPEC; lengths follow the tag's side"
                             : "measure a tag and a gap; if the SPEC is right, do not overexpose the tags"});
  }
}

void bentBoard(Evidence& of) {
  // A bend above this share of the board's size is no longer a paraboloid with two parameters.
  constexpr double kBentShare = 0.005;
  // Share of a strong bend that is assumed to deviate from that paraboloid.
  constexpr double kOtherShape = 0.25;
  for (const std::size_t board : estimatedShapes(of.fit)) {
    const double share = bendShare(of.fit.boards[board]);
    const std::vector<double>& flat = of.choice.shapes[board].flat_params;
    if (!(share > kBentShare) || flat.empty()) continue;
    const double bend_effect = effectOfCamera(of, cameraOf(onlyCamera(of.fit).model, flat));
    of.add({.id = "bent_board",
            .cause = "the board is strongly bent" + boardSuffix(of.fit, board),
            .evidence = "by " + numberText("%.2g", 100 * share) + " % of its size",
            .next_step = "mount the board on something flat and rigid, and photograph it again"},
           kOtherShape * bend_effect);
  }
}

void unevenBoard(Evidence& of) {
  if (of.choice.are_offsets_undetermined && !isAnyUneven(of.fit)) {
    of.add({.id = "board_even",
            .cause = "the views show no unevenness of the board beyond noise; its points are "
                     "assumed to be in their places"});
  }
  for (std::size_t b = 0; b < of.fit.boards.size(); ++b) {
    const FitBoard& board = of.fit.boards[b];
    if (!board.isUneven()) continue;
    const Eigen::Vector2d rms_m = offsetRms(board.shape);
    of.add({.id = "uneven_board",
            .cause = "the board is uneven" + boardSuffix(of.fit, b) +
                     "; the place of each of its points is estimated",
            .evidence = "off by " + numberText("%.2g", 1e3 * rms_m.x()) + " mm in the plane and " +
                        numberText("%.2g", 1e3 * rms_m.y()) + " mm across it (RMS)",
            .next_step = "mount the board on something flat and rigid: fewer views then do"});
  }
}

void boardFlexes(Evidence& of) {
  for (const FitBoard& board : of.fit.boards) {
    if (!board.isFlexible()) continue;
    of.add({.id = "board_flexes",
            .cause = "the board bends differently in each view; its bends are estimated view by view",
            .evidence = "standard deviation " + numberText("%.2g", 1e3 * board.flex.std_m) + " mm",
            .next_step = "mount the board on something flat and rigid, and photograph it again"});
  }
}

void bendIgnored(Evidence& of) {
  if (!of.uncertainty.ignored_bend) return;
  const IgnoredBend& ignored = *of.uncertainty.ignored_bend;
  std::vector<std::string> bends;
  for (std::size_t i = 0; i < ignored.boards.size(); ++i) {
    bends.push_back(numberText("%.2g", 1e3 * ignored.shapes[i].bend_x_m) + " and " +
                    numberText("%.2g", 1e3 * ignored.shapes[i].bend_y_m) + " mm" +
                    boardSuffix(of.fit, ignored.boards[i]));
  }
  const bool is_one = bends.size() == 1;
  const DenseMatrix::View step = ignored.params_step.view();
  of.add({.id = "bend_ignored",
          .cause = is_one ? "the board is bent, but --board-shape flat ignores it"
                          : "boards are bent, but --board-shape flat ignores it",
          .evidence = join(bends, "; "),
          .next_step = "use --board-shape auto"},
         effectOfStep(of, {step.data(), static_cast<std::size_t>(step.size())}));
}

void bendUnknown(Evidence& of) {
  for (std::size_t board = 0; board < of.choice.shapes.size(); ++board) {
    const ShapeReport& shape = of.choice.shapes[board];
    if (shape.is_determined || !shape.is_requested || numViews(of.fit, board) == 0) continue;
    of.add({.id = "bend_unknown",
            .cause = "the views do not show whether the board" + boardSuffix(of.fit, board) +
                     " is bent; it is assumed flat",
            .next_step = "add views tilted in both directions"});
  }
}

}  // namespace

void diagnoseBoards(Evidence& of) {
  for (const auto& diagnose : {boardGap, bentBoard, unevenBoard, boardFlexes, bendIgnored, bendUnknown})
    diagnose(of);
}

}  // namespace alidade::detail
