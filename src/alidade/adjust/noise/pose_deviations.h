// SPDX-License-Identifier: MIT
#pragma once

#include <vector>

#include "alidade/adjust/board/fit.h"

namespace alidade {

/// The scatter of the deviations of all views of a solved fit; its factors and its shift without views that
/// are off by more than three times what is usual.
struct DeviationScatter {
  /// Factors on the standard deviations of time and path that the roots state, from the estimated deviations:
  /// restricted maximum likelihood, one step (Harville 1977, Maximum likelihood approaches to variance
  /// component estimation and to related problems, Journal of the American Statistical Association 72(358)).
  double time_factor = 1;
  double path_factor = 1;
  double num_free = 0;  ///< number of coordinates that the corners determine, not the scatter
  /// RMS displacement of the corners of a view by its deviation, in units of their noise.
  double shift_sigmas = 0;
  /// RMS of the normal coordinates of each view, over that expected of the number that its corners determine;
  /// 0 for a view without a deviation.
  std::vector<double> sizes = {};
  double usual_size = 0;  ///< their median over the views with a deviation
};

/// Corner weights are inverse variances.
[[nodiscard]] DeviationScatter deviationScatter(const Fit& fit);

}  // namespace alidade
