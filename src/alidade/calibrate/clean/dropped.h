// SPDX-License-Identifier: MIT
#pragma once

#include <cstddef>
#include <string>
#include <vector>

#include <Eigen/Core>

#include "alidade/calibrate/start/prepared_views.h"
#include "alidade/core/cancel.h"

namespace alidade {

/// A corner left out of the estimate because it lies far from where the camera puts it.
struct Outlier {
  std::size_t source = 0;  ///< see FitView
  std::string image;
  std::size_t board = 0;  ///< see View
  int corner_id = 0;
  Eigen::Vector2d error_px{0, 0};  ///< projected minus observed
};

/// What of the given views is not in the fit.
struct Dropped {
  std::vector<ExcludedView> views;  ///< in order of image name and board
  std::vector<RepeatedView> repeated;
  std::vector<Outlier> outliers;  ///< of the views in use, in their order

  /// Of the views, those that do not fit the camera of the others.
  [[nodiscard]] std::size_t numMisfits() const;
  /// Of the corners of the views in use, the share that was left out.
  [[nodiscard]] double outlierShare(const Fit& fit) const;
};

/// What the fit has left out, each view with its reason as far as its corners show one.
[[nodiscard]] Dropped droppedFrom(const Fit& fit, const PreparedViews& given, const CancelFlag* cancel);

}  // namespace alidade
