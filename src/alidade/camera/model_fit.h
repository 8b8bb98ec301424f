// SPDX-License-Identifier: MIT
#pragma once

#include <optional>
#include <span>
#include <string_view>

#include <Eigen/Core>

#include "alidade/camera/any_camera.h"

namespace alidade {

/// A camera of one model in the place of a camera of another, and how well it does there.
///
/// The error of a pixel is the distance, in pixels, between it and where the new camera projects its ray.
/// It is looked at on a grid of equal cells over the image; `max_error_px` on the image's outer edges too,
/// and where the domain of one of the two cameras ends inside the image. Both are NaN if the new camera
/// reaches none of the pixels.
struct ModelFit {
  AnyCamera camera;
  bool is_exact = false;  ///< the same lens by algebra (same_lens.h), and not the result of a fit
  double rms_px = 0;      ///< sqrt(mean of dx^2 + dy^2) over the pixels that are reached
  double max_error_px = 0;
  Eigen::Vector2d worst_pixel = Eigen::Vector2d::Zero();  ///< where the error is largest
  int num_pixels = 0;                                     ///< pixels looked at that have a ray in the source
  int num_without_ray = 0;  ///< pixels looked at that have none, and do not count
  int num_unreached = 0;    ///< of num_pixels, those whose rays the new camera does not project
  std::optional<Eigen::Vector2d> unreached_pixel;  ///< one of them
  DomainCertificate domain;                        ///< of the new camera over the image

  /// Share of the pixels with a ray that the new camera does not reach, 0 to 1.
  [[nodiscard]] double unreachedShare() const {
    return static_cast<double>(num_unreached) / static_cast<double>(num_pixels);
  }
};

/// The camera of model `model_id` that comes closest to `source` over the whole image: the same lens where
/// algebra knows it, otherwise the least squares fit over a uniform grid of pixels, from several starts. The
/// result depends on nothing but the arguments.
/// @param absent  names of parameters that are 0 in the result, for who has no place for them
/// @throws Error (kUsage) for an unknown id; Error (kInput) if hardly a pixel of the image has a ray
[[nodiscard]] ModelFit fitModel(const AnyCamera& source, ImageSize size, std::string_view model_id,
                                std::span<const std::string_view> absent = {});

}  // namespace alidade
