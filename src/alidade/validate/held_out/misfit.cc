// SPDX-License-Identifier: MIT
#include "alidade/validate/held_out/misfit.h"

#include <algorithm>
#include <cmath>

#include "alidade/adjust/errors.h"
#include "alidade/core/statistics.h"

namespace alidade {

Misfit misfitOf(const PosedViews& posed) {
  Misfit misfit;
  std::size_t count = 0;
  for (std::size_t v = 0; v < posed.fit.views.size(); ++v) {
    double squares = 0;
    const auto errors = viewErrors(posed.fit, posed.fit.views[v]);
    for (const Eigen::Vector2d& error : errors) squares += error.squaredNorm();
    misfit.squares += squares;
    count += errors.size();
    misfit.weighted_squares += (posed.weights.empty() ? 1.0 : posed.weights[v]) * squares;
  }
  if (count > 0) misfit.rms_px = std::sqrt(misfit.squares / static_cast<double>(count));
  return misfit;
}

double misfitSigmas(const PosedViews& held, const PosedViews& freed) {
  constexpr double kNumbersPerView = 2;
  constexpr double kNumbersOfAPose = 6;
  double freedom = 0;
  double squares_of_finest = 0;
  for (const FitView& view : held.fit.views) {
    const auto coordinates = 2 * static_cast<double>(view.corners.size());
    freedom += std::clamp(coordinates - kNumbersOfAPose, 0.0, kNumbersPerView);
    squares_of_finest += coordinates * kFinestPx * kFinestPx;
  }
  const auto above = static_cast<double>(onlyCamera(held.fit).params.size());
  const double below = freedom - above;
  if (!(below > 0)) return 0;
  const double as_it_is = misfitOf(held).squares;
  const double once_freed = std::max(misfitOf(freed).squares, squares_of_finest);
  const double f = (as_it_is - once_freed) / above / (once_freed / below);
  return f > 0 ? normalOfF(f, above, below) : 0.0;
}

}  // namespace alidade
