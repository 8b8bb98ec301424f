// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>

#include "alidade/camera/any_camera.h"
#include "alidade/core/cancel.h"
#include "alidade/core/image.h"
#include "alidade/geometry/se3.h"
#include "alidade/simulate/ray_lattice.h"
#include "alidade/target/checkerboard.h"

namespace alidade {

/// How a rendered image looks. Grey levels are those of the 8-bit image, 0 to 255, proportional to light.
struct RenderOptions {
  double blur_px = 0.8;  ///< standard deviation of the lens' Gaussian blur, besides the pixel's own square
  double dark_level = 30;
  double bright_level = 220;
  double background_level = 110;
  double falloff = 0;  ///< share of the light lost, linearly, from the left border to the right one
  double vignetting_exponent = 0;  ///< light falls by cos^n of the angle to the optical axis; 4 is natural
  double read_noise = 1.5;         ///< standard deviation of the noise without light, grey levels
  /// Electrons at level 255, which decide the shot noise: its variance in electrons is their number. 0: no
  /// shot noise.
  double full_well_electrons = 10000;
  std::uint64_t seed = 1;  ///< of the noise; give each image its own
  /// Places a pixel's light is averaged over, see makePointSpread(). At edges between the default levels 987
  /// err by 0.3 grey levels (root mean square; 377 by 0.6).
  int samples = 987;
  int num_jobs = 0;  ///< threads; 0: one a processor. The image does not depend on it.

  /// @throws Error (kInput) naming the first option that is out of its range.
  void validate() const;
};

/// Renders views of checkerboards by one camera: the board and its margin (see boardTone()) before an even
/// background. Anything seen from behind is background; pixels without a ray get no light.
///
/// A pixel's light is the mean over its point spread, each place of which is traced to the board's plane by
/// the expansion of RayLattice; light that would come across the domain's rim is not modelled. Shading is
/// evaluated at pixel centres. Noise is normal, which for shot noise needs more than some ten electrons.
class Renderer {
 public:
  /// Traces the camera's rays once. Both sides of `size` are positive.
  Renderer(const AnyCamera& camera, ImageSize size, int num_jobs = 0) : rays_(camera, size, num_jobs) {}

  /// The same bytes for the same arguments, whatever the number of threads.
  /// @throws Error (kInput) for options out of range; Cancelled once `cancel` is raised.
  [[nodiscard]] GrayImage render(const Checkerboard& board, const SE3& camera_from_board,
                                 const RenderOptions& options, const CancelFlag* cancel = nullptr) const;

 private:
  RayLattice rays_;
};

/// The same for a single image.
[[nodiscard]] GrayImage renderBoard(const AnyCamera& camera, ImageSize size, const Checkerboard& board,
                                    const SE3& camera_from_board, const RenderOptions& options);

}  // namespace alidade
