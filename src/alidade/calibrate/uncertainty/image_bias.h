// SPDX-License-Identifier: MIT
#pragma once

#include <limits>

#include "alidade/adjust/board/fit.h"

namespace alidade {

/// Do errors at one place of the image point the same way in different views? A lens that does not follow its
/// model errs in the same way in all views at the same place of the image; a bent board does so at the same
/// place of the board, and noise nowhere.
struct ImageBias {
  /// How far what the views agree in exceeds 0, in standard deviations of what it is if each view has its
  /// errors with a sign by chance. Noise gives about 0, and whatever corners of one view have in common does
  /// not count. Sums of products have a longer tail than a normal variable, and no more than the root of half
  /// the number of views squared can be reached: with few views that look alike, little can be proved.
  double z = std::numeric_limits<double>::quiet_NaN();
  /// Root mean square of what they agree in, px of a corner of weight 1; 0 where it is negative.
  double rms_px = std::numeric_limits<double>::quiet_NaN();

  /// Is z larger than noise makes it? Less than one clean set in a hundred exceeds this limit.
  [[nodiscard]] bool isSeen() const { return z > kSeenZ; }
  static constexpr double kSeenZ = 4;
};

/// Each view votes for a displacement field over the image, bilinear between the nodes of a coarse grid, by
/// the score of the field at zero with the pose and the intrinsics following (Rao 1948, Large sample tests of
/// statistical hypotheses concerning several parameters). Without that, poses that give way to the lens
/// would hide what the views have in common.
/// @param fit  of one camera, solved
[[nodiscard]] ImageBias imageBias(const Fit& fit);

}  // namespace alidade
