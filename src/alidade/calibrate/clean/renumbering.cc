// SPDX-License-Identifier: MIT
#include "alidade/calibrate/clean/renumbering.h"

#include <algorithm>
#include <functional>
#include <utility>

#include "alidade/adjust/noise/robust_weighting.h"
#include "alidade/calibrate/clean/view_fit.h"

namespace alidade {

std::vector<Renumbering> renumberings(const Board& board, const View& view) {
  const int columns = board.columns();
  const int rows = board.rows();
  const int count = board.numCorners();
  const auto around = [](int i, int n) { return (i + n) % n; };
  const auto columnsOn = [&](int step) {
    return [=](int id) { return id / columns * columns + around(id % columns + step, columns); };
  };
  const auto idsOn = [&](int step) { return [=](int id) { return around(id + step, count); }; };
  const std::vector<std::pair<std::string, std::function<int(int)>>> orders = {
      {"column by column instead of row by row", [=](int id) { return id % rows * columns + id / rows; }},
      {"one column further in each row", columnsOn(1)},
      {"one column back in each row", columnsOn(-1)},
      {"one further", idsOn(1)},
      {"one back", idsOn(-1)},
      {"one row further", idsOn(columns)},
      {"one row back", idsOn(-columns)}};
  std::vector<Renumbering> all;
  for (const auto& [how, renumbered] : orders) {
    Renumbering renumbering{.how = how, .view = view};
    for (Corner& corner : renumbering.view.corners) corner.id = renumbered(corner.id);
    std::sort(renumbering.view.corners.begin(), renumbering.view.corners.end(),
              [](const Corner& a, const Corner& b) { return a.id < b.id; });
    all.push_back(std::move(renumbering));
  }
  return all;
}

std::optional<std::string> fittingOrder(const Fit& fit, const View& view) {
  for (const Renumbering& renumbering : renumberings(fit.boards[view.board].target, view)) {
    const auto alone = fitAlone(fit, renumbering.view);
    if (alone && isExplained(*alone, noiseSigma(fit))) return renumbering.how;
  }
  return std::nullopt;
}

}  // namespace alidade
