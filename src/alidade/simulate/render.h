// SPDX-License-Identifier: MIT
#pragma once

#include "alidade/camera/any_camera.h"
#include "alidade/core/cancel.h"
#include "alidade/core/image.h"
#include "alidade/geometry/se3.h"
#include "alidade/record/scene.h"
#include "alidade/simulate/ray_lattice.h"
#include "alidade/target/checkerboard.h"

namespace alidade {

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
