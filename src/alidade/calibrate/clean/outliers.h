// SPDX-License-Identifier: MIT
#pragma once

#include <string>
#include <vector>

#include <Eigen/Core>

#include "alidade/adjust/robust_weighting.h"
#include "alidade/calibrate/start/prepared_views.h"

namespace alidade {

/// A corner left out of the estimate because it lies far from where the camera puts it.
struct Outlier {
  std::string image;
  int corner_id = 0;
  Eigen::Vector2d error_px{0, 0};  ///< projected minus observed
};

/// Leaves out corners that are no noise, and views that do not fit the camera of the others, and solves
/// again. Outliers are judged anew in each round, among all corners, until the same ones come out.
/// @throws Error (kInput) if too few views are left
[[nodiscard]] SettledFit withoutOutliers(SettledFit settled, const PreparedViews& given,
                                         const CancelFlag* cancel);

/// Corners of the views in use that are not in use.
[[nodiscard]] std::vector<Outlier> outliersOf(const Fit& fit, const PreparedViews& given);

}  // namespace alidade
