// SPDX-License-Identifier: MIT
#pragma once

#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <utility>
#include <variant>
#include <vector>

#include <Eigen/Core>

#include "alidade/camera/camera.h"
#include "alidade/camera/model_list.h"
#include "alidade/core/image.h"

namespace alidade {

namespace detail {
template <class List>
struct VariantOfList;
template <CameraModel... Models>
struct VariantOfList<ModelList<Models...>> {
  using type = std::variant<Camera<Models>...>;
};
}  // namespace detail

/// Ids of all models, in the list's order.
[[nodiscard]] const std::vector<std::string>& modelIds();

/// Names of a model's parameters in storage order (fx fy cx cy, then the lens).
/// @throws Error (kUsage) for an unknown id, naming the known ones.
[[nodiscard]] std::span<const std::string_view> parameterNames(std::string_view model_id);

/// Parameters of the model's start with the image's centre and the given focal length, in pixels a radian on
/// the axis: fx and fy are other numbers where the model's formula has a scale of its own.
[[nodiscard]] std::vector<double> startParameters(std::string_view model_id, double focal_px, ImageSize size);

/// A camera of any model of the list, by value.
class AnyCamera {
 public:
  using Variant = detail::VariantOfList<AllModels>::type;

  template <CameraModel M>
  explicit AnyCamera(Camera<M> camera) : camera_(std::move(camera)) {}

  /// Makes a camera from a model's id and its parameters in storage order.
  /// @throws Error (kUsage) for an unknown id; Error (kInput) for a wrong count, a number that is not finite,
  /// a focal length that is not positive, or a lens parameter out of its range, naming the parameter.
  [[nodiscard]] static AnyCamera make(std::string_view model_id, std::span<const double> params);

  [[nodiscard]] std::string_view modelId() const;
  [[nodiscard]] std::span<const std::string_view> parameterNames() const;
  [[nodiscard]] std::span<const double> parameters() const&;
  std::span<const double> parameters() const&& = delete;  ///< would outlive the camera
  [[nodiscard]] const CertifiedCone& cone() const;

  /// See Camera<M>.
  [[nodiscard]] Projection project(const Eigen::Vector3d& p_cam) const;
  [[nodiscard]] std::optional<Eigen::Vector3d> unproject(const Eigen::Vector2d& pixel) const;
  [[nodiscard]] std::optional<Eigen::Vector3d> unproject(const Eigen::Vector2d& pixel,
                                                         double* J_ray_pixel) const;

  /// Projects many points by projectBatch(), which is faster still where they lie in arrays by coordinate.
  void project(std::span<const Eigen::Vector3d> points_cam, std::span<Projection> out) const;

  /// Calls f(const Camera<M>&) with the model's own type.
  template <class F>
  decltype(auto) visit(F&& f) const {
    return std::visit(std::forward<F>(f), camera_);
  }

 private:
  Variant camera_;
};

/// What is certain about a camera over its image.
struct DomainCertificate {
  CertifiedCone cone;
  bool full_image = false;                           ///< every pixel of the image has a ray
  std::optional<Eigen::Vector2d> pixel_without_ray;  ///< one that has none, if so
  /// Smallest |det| over the image of the lens' Jacobian by the unit sphere, relative to the axis: how near
  /// to a fold the image comes.
  double min_relative_det = 0;
};

/// Certifies `camera` over an image. The image of the cone has no holes, so that every pixel has a ray
/// exactly if every pixel of the image's border has one.
[[nodiscard]] DomainCertificate certifyDomain(const AnyCamera& camera, ImageSize size);

/// Does the lens fold over, or have a pole, in that part of the image that it lights? A lens of less than 180
/// degrees lights all of it. What lies farther than 90 degrees from the axis is the dark corner of a
/// fisheye's image, as far as anyone can tell.
[[nodiscard]] bool foldsInsideImage(const DomainCertificate& domain);

}  // namespace alidade
