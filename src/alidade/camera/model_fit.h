// SPDX-License-Identifier: MIT
#pragma once

#include <optional>
#include <span>
#include <string_view>

#include <Eigen/Core>

#include "alidade/camera/any_camera.h"
#include "alidade/camera/image_domain.h"

namespace alidade {

/// A camera of one model fitted to a camera of another model, and the error of the fit.
///
/// The error of a pixel is the distance, in pixels, between it and the new camera's projection of its ray. It
/// is sampled on a uniform grid over the image. `max_error_px` also includes the outer edges of the
/// image and the places where the domain of one camera ends inside the image. Both are NaN if the new camera
/// represents none of the pixels.
struct ModelFit {
  AnyCamera camera;
  bool is_exact = false;  ///< an identical lens (same_lens.h), not the result of a fit
  double rms_px = 0;      ///< sqrt(mean of dx^2 + dy^2) over the pixels that are represented
  double max_error_px = 0;
  Eigen::Vector2d worst_pixel = Eigen::Vector2d::Zero();  ///< where the error is largest
  int num_pixels = 0;                                     ///< sampled pixels that have a ray in the source
  int num_without_ray = 0;                                ///< sampled pixels without a ray, which are ignored
  int num_unreached = 0;  ///< of num_pixels, number whose rays the new camera does not project
  std::optional<Eigen::Vector2d> unreached_pixel;  ///< one of them
  DomainCertificate domain;                        ///< of the new camera over the image

  /// Share of the pixels with a ray that the new camera cannot represent, 0 to 1.
  [[nodiscard]] double unreachedShare() const {
    return static_cast<double>(num_unreached) / static_cast<double>(num_pixels);
  }
};

/// The camera of model `model_id` that is closest to `source` over the whole image: an identical lens if the
/// model has one, otherwise the least-squares fit over a uniform grid of pixels from several initial guesses.
/// The result depends only on the arguments.
/// @param absent  names of parameters to keep at 0 because a format cannot represent them
/// @throws Error (kUsage) for an unknown id; Error (kInput) if almost no pixel of the image has a ray
[[nodiscard]] ModelFit fitModel(const AnyCamera& source, ImageSize size, std::string_view model_id,
                                std::span<const std::string_view> absent = {});

}  // namespace alidade
