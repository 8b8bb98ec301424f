// SPDX-License-Identifier: MIT
#pragma once

#include <vector>

namespace alidade {

/// A camera of the same model, far from the result by the result's own sigmas, that the corners do not rule
/// out.
struct OtherOptimum {
  std::vector<double> params;  ///< N, in storage order, solved to rest on the corners of the result
  double rms_px = 0;           ///< weighted, to be compared with weightedRms() of the fit
  /// By how much its cost exceeds the result's: twice the difference over the variance of a coordinate. Below
  /// 0 where it was refined to less than the result, which then has gone astray since the two were compared.
  double excess_chi2 = 0;
  /// The largest parameter difference in stated standard deviations of the result.
  double sigmas = 0;
  /// The largest difference of the pixels of far points over the image, the rotation taken out, px; NaN where
  /// the two cameras have no pixel of the image in common.
  double projection_px = 0;
};

}  // namespace alidade
