// SPDX-License-Identifier: MIT
#pragma once

#include <optional>

#include <Eigen/Core>

#include "alidade/camera/any_camera.h"
#include "alidade/core/image.h"

namespace alidade {

/// The domain in which the projection is one-to-one, and how much of the image it covers.
struct DomainCertificate {
  CertifiedCone cone;
  bool full_image = false;                           ///< every pixel of the image has a ray
  std::optional<Eigen::Vector2d> pixel_without_ray;  ///< an example of a pixel without a ray
  /// Smallest |det| of the lens Jacobian on the unit sphere over the image, relative to the axis. A small
  /// value means that the image comes near a fold.
  double min_relative_det = 0;
};

/// Certifies `camera` over an image. The image of the cone has no holes, so every pixel has a ray if and only
/// if every border pixel has one.
[[nodiscard]] DomainCertificate certifyDomain(const AnyCamera& camera, ImageSize size);

/// True if the lens folds over or has a pole in the illuminated part of the image. A lens of less than 180
/// degrees illuminates the whole image. Pixels more than 90 degrees from the axis are assumed to be the dark
/// corners of a fisheye image.
[[nodiscard]] bool foldsInsideImage(const DomainCertificate& domain);
/// The same, but runs certifyDomain() first, which is slower.
[[nodiscard]] bool foldsInsideImage(const AnyCamera& camera, ImageSize size);

}  // namespace alidade
