// SPDX-License-Identifier: MIT
#pragma once

#include <limits>

#include "alidade/adjust/board/fit.h"

namespace alidade {

/// How far views differ in something of which a camera has only one.
struct ViewVariation {
  /// F statistic of one value a view against the same for all: about 1 where nothing varies. NaN with too few
  /// views.
  double f = std::numeric_limits<double>::quiet_NaN();
  /// One standard deviation between views, as a share of the focal length or of the image's height, without
  /// what noise adds to it (DerSimonian and Laird 1986, Meta-analysis in clinical trials, Controlled Clinical
  /// Trials 7(3)).
  double spread = 0;
};

/// What single views say, each with a pose of its own, while the camera stays as estimated from all.
struct ViewVariations {
  /// Both focal lengths times the same factor: zoom, focus or crop changed between images.
  ViewVariation focal;
  /// The image sheared and stretched from row to row: the board or the camera moved while the rows were read
  /// one after the other. A plane seen from a free pose leaves two ways to disagree with a camera, and these
  /// are the two; so this explains a varying focal length as well.
  ViewVariation rows;
  /// Of what `rows` explains, the share that `focal` explains alone: near 1 if focal lengths vary, about a
  /// half if images are sheared at random.
  double focal_share = 0;
};

/// @param fit  of one camera, solved
[[nodiscard]] ViewVariations viewVariations(const Fit& fit);

}  // namespace alidade
