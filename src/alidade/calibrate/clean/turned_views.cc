// SPDX-License-Identifier: MIT
#include "alidade/calibrate/clean/turned_views.h"

#include <algorithm>
#include <cstddef>
#include <vector>

#include <Eigen/Core>

#include "alidade/adjust/board/reduced.h"
#include "alidade/adjust/noise/board_offsets.h"
#include "alidade/calibrate/clean/view_fit.h"
#include "alidade/target/board_turns.h"

namespace alidade {
namespace {

// The scores of the offsets of a board's points in one view, as a unit vector; empty if no pose explains it.
Eigen::VectorXd scoresOf(const Fit& fit, const AnyCamera& camera, const View& view) {
  const auto alone = fitAlone(fit, camera, view);
  if (!alone) return {};
  const FitBoard& board = fit.boards[view.board];
  const detail::ViewGram gram =
      detail::gramOf(onlyCamera(fit).model, onlyCamera(fit).params, alone->camera_from_board,
                     onShape(board.target, board.shape, alone->corners), fit.loss, LossWeights::kUse, {},
                     detail::PointShifts::kInclude);
  Eigen::VectorXd scores = Eigen::VectorXd::Zero(3 * board.target.numCorners());
  for (std::size_t k = 0; k < gram.ids.size(); ++k) {
    scores.segment<3>(3 * gram.ids[k]) =
        gram.points.col(gram.points.cols() - 1).segment<3>(3 * static_cast<Eigen::Index>(k));
  }
  return scores.normalized();
}

// For each turn of the board, the scores of its points after the turn.
std::vector<Eigen::VectorXd> afterTurns(const Eigen::VectorXd& scores, const std::vector<BoardTurn>& turns) {
  std::vector<Eigen::VectorXd> all;
  for (const BoardTurn& turn : turns) {
    Eigen::VectorXd turned(scores.size());
    for (std::size_t id = 0; id < turn.id_of.size(); ++id) {
      turned.segment<3>(3 * turn.id_of[id]) =
          turn.turned_from_board.rotation * scores.segment<3>(3 * static_cast<Eigen::Index>(id)).eval();
    }
    all.push_back(std::move(turned));
  }
  return all;
}

struct Assignment {
  std::vector<std::size_t> turn_of;  // of each view
  Eigen::VectorXd sum;               // of the views' scores after their turns

  // The number of views that agree: about 1 for random scores, all if they are the same.
  [[nodiscard]] double agreement() const { return sum.squaredNorm() / static_cast<double>(turn_of.size()); }
};

// Turns of the views after which their scores agree best, found from those of one view.
Assignment assignedFrom(std::size_t first, const std::vector<std::vector<Eigen::VectorXd>>& scores) {
  constexpr int kMostRounds = 20;
  Assignment all{.turn_of = std::vector<std::size_t>(scores.size(), 0), .sum = scores[first][0]};
  for (int round = 0; round < kMostRounds; ++round) {
    bool is_changed = false;
    for (std::size_t v = 0; v < scores.size(); ++v) {
      const bool is_in_sum = round > 0 || v == first;
      if (is_in_sum) all.sum -= scores[v][all.turn_of[v]];
      const auto best = std::ranges::max_element(
          scores[v], {}, [&](const Eigen::VectorXd& turned) { return turned.dot(all.sum); });
      const auto turn = static_cast<std::size_t>(best - scores[v].begin());
      is_changed = is_changed || !is_in_sum || turn != all.turn_of[v];
      all.turn_of[v] = turn;
      all.sum += *best;
    }
    if (!is_changed) break;
  }
  return all;
}

// The same with most views as they are.
Assignment withFewestTurned(Assignment all, const std::vector<std::vector<Eigen::VectorXd>>& scores) {
  const std::size_t num_turns = scores.front().size();
  std::vector<std::ptrdiff_t> counts;
  for (std::size_t turn = 0; turn < num_turns; ++turn)
    counts.push_back(std::ranges::count(all.turn_of, turn));
  const auto most = static_cast<std::size_t>(std::ranges::max_element(counts) - counts.begin());
  all.sum.setZero();
  for (std::size_t v = 0; v < scores.size(); ++v) {
    all.turn_of[v] = (all.turn_of[v] + num_turns - most) % num_turns;
    all.sum += scores[v][all.turn_of[v]];
  }
  return all;
}

void renumber(const BoardTurn& turn, View& view) {
  for (Corner& corner : view.corners) corner.id = turn.id_of[static_cast<std::size_t>(corner.id)];
  std::ranges::sort(view.corners, {}, &Corner::id);
}

bool renumberViewsOf(std::size_t board, const Fit& fit, PreparedViews& given) {
  constexpr std::size_t kFewestViews = 4;
  constexpr double kAgreeing = 4;   // views; random scores of many views reach 2.5
  constexpr double kShare = 0.25;   // of the views
  constexpr double kBetter = 1.05;  // than as they are
  constexpr double kAlike = 0.4;    // least cosine of a turned view with the others, and its gain
  const std::vector<BoardTurn> turns = boardTurns(given.boards[board]);
  const AnyCamera camera = cameraOf(fit);
  std::vector<std::size_t> views;
  std::vector<std::vector<Eigen::VectorXd>> scores;
  for (std::size_t v = 0; v < given.views.size(); ++v) {
    if (given.views[v].board != board) continue;
    const Eigen::VectorXd own = scoresOf(fit, camera, given.views[v]);
    if (own.size() == 0 || !own.allFinite()) continue;
    views.push_back(v);
    scores.push_back(afterTurns(own, turns));
  }
  if (views.size() < kFewestViews) return false;
  Assignment before{.turn_of = std::vector<std::size_t>(views.size(), 0),
                    .sum = Eigen::VectorXd::Zero(scores[0][0].size())};
  for (const auto& of_view : scores) before.sum += of_view[0];
  Assignment best = before;
  constexpr std::size_t kMostStarts = 30;  // spread over the views, so that the time grows linearly with them
  const std::size_t num_starts = std::min(kMostStarts, views.size());
  for (std::size_t start = 0; start < num_starts; ++start) {
    Assignment other = assignedFrom(start * views.size() / num_starts, scores);
    if (other.agreement() > best.agreement()) best = std::move(other);
  }
  if (!(best.agreement() > std::max(kAgreeing, kShare * static_cast<double>(views.size()))) ||
      !(best.agreement() > kBetter * before.agreement()))
    return false;
  best = withFewestTurned(std::move(best), scores);
  bool is_any = false;
  for (std::size_t i = 0; i < views.size(); ++i) {
    const std::size_t turn = best.turn_of[i];
    const Eigen::VectorXd others = (best.sum - scores[i][turn]).normalized();
    const double cosine = scores[i][turn].dot(others);
    if (turn == 0 || !(cosine > kAlike) || !(cosine > scores[i][0].dot(others) + kAlike)) continue;
    renumber(turns[turn], given.views[views[i]]);
    is_any = true;
  }
  return is_any;
}

}  // namespace

bool renumberTurnedViews(const Fit& fit, PreparedViews& given) {
  Fit even = fit;  // what its offsets would hide shows in the scores
  for (FitBoard& board : even.boards) makeEven(board);
  bool is_any = false;
  for (std::size_t b = 0; b < given.boards.size(); ++b) {
    if (given.boards[b].isAmbiguous()) is_any = renumberViewsOf(b, even, given) || is_any;
  }
  return is_any;
}

}  // namespace alidade
