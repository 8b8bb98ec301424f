// SPDX-License-Identifier: MIT
#include "alidade/calibrate/choose/model_solution.h"

#include <utility>

#include "alidade/adjust/noise/weak_prior.h"
#include "alidade/calibrate/bend/board_bend.h"
#include "alidade/calibrate/bend/uneven_board.h"
#include "alidade/calibrate/clean/outliers.h"
#include "alidade/calibrate/start/start_fit.h"

namespace alidade {

ModelSolution fittedPlainly(const PreparedViews& given, const CalibratorOptions& options) {
  StartedFit started = startedFit(given, options);
  SettledFit settled = settledFromStart(std::move(started.fit), options.cancel);
  ComparedFit compared = comparedWithRivals(std::move(settled.fit), started.rivals, options.cancel);
  return {.fit = std::move(compared.fit),
          .choice = {.start = started.report, .shapes = {}, .is_settled = settled.is_settled},
          .close_params = std::move(compared.close_params)};
}

ModelSolution withDataSettled(ModelSolution solution, const PreparedViews& given,
                              const CalibratorOptions& options) {
  const CancelFlag* cancel = options.cancel;
  SettledFit settled{.fit = regularised(std::move(solution.fit), cancel),
                     .is_settled = solution.choice.is_settled};
  BentFit now = bent(std::move(settled), options.board_shape, cancel);
  UnevenFit of_points = uneven(std::move(now.settled), options.board_shape, cancel);
  now.settled = withoutOutliers(std::move(of_points.settled), given, cancel);
  const std::vector<std::size_t> bent_boards = estimatedShapes(now.settled.fit);
  now = bendTestedAgain(std::move(now), options.board_shape, cancel);
  if (estimatedShapes(now.settled.fit) != bent_boards)
    now.settled = withoutOutliers(std::move(now.settled), given, cancel);
  // Again on the corners that are left.
  now.settled = unevenAgain(std::move(now.settled), cancel);
  solution.fit = regularised(std::move(now.settled.fit), cancel);
  solution.choice.is_settled = now.settled.is_settled;
  solution.choice.shapes = std::move(now.reports);
  solution.choice.points = of_points.report;
  return solution;
}

}  // namespace alidade
