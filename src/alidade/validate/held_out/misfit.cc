// SPDX-License-Identifier: MIT
#include "alidade/validate/held_out/misfit.h"

#include <algorithm>
#include <cmath>

#include "alidade/core/statistics.h"

namespace alidade {

std::vector<std::vector<Eigen::Vector2d>> errorsOf(std::string_view model_id, const PosedViews& posed) {
  std::vector<std::vector<Eigen::Vector2d>> errors;
  for (std::size_t v = 0; v < posed.views.size(); ++v) {
    errors.push_back(
        reprojectionErrors(model_id, posed.state.params, posed.state.camera_from_board[v], posed.views[v]));
  }
  return errors;
}

Misfit misfitOf(std::string_view model_id, const PosedViews& posed) {
  Misfit misfit;
  std::size_t count = 0;
  const auto errors = errorsOf(model_id, posed);
  for (std::size_t v = 0; v < errors.size(); ++v) {
    double squares = 0;
    for (const Eigen::Vector2d& error : errors[v]) squares += error.squaredNorm();
    misfit.squares += squares;
    count += errors[v].size();
    misfit.weighted_squares += (posed.weights.empty() ? 1.0 : posed.weights[v]) * squares;
  }
  if (count > 0) misfit.rms_px = std::sqrt(misfit.squares / static_cast<double>(count));
  return misfit;
}

double misfitSigmas(std::string_view model_id, const PosedViews& held, const PosedViews& freed) {
  constexpr double kNumbersPerView = 2;
  constexpr double kNumbersOfAPose = 6;
  double freedom = 0;
  double squares_of_finest = 0;
  for (const auto& view : held.views) {
    const auto coordinates = 2 * static_cast<double>(view.size());
    freedom += std::clamp(coordinates - kNumbersOfAPose, 0.0, kNumbersPerView);
    squares_of_finest += coordinates * kFinestPx * kFinestPx;
  }
  const auto above = static_cast<double>(held.state.params.size());
  const double below = freedom - above;
  if (!(below > 0)) return 0;
  const double as_it_is = misfitOf(model_id, held).squares;
  const double once_freed = std::max(misfitOf(model_id, freed).squares, squares_of_finest);
  const double f = (as_it_is - once_freed) / above / (once_freed / below);
  return f > 0 ? normalOfF(f, above, below) : 0.0;
}

}  // namespace alidade
