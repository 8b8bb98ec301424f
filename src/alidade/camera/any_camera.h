// SPDX-License-Identifier: MIT
#pragma once

#include <cstddef>
#include <cstdint>
#include <limits>
#include <map>
#include <memory>
#include <numbers>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include <Eigen/Core>

#include "alidade/core/image.h"

namespace alidade {

namespace detail {
struct CameraVariant;  // see camera_variant.h
}  // namespace detail

/// A camera of one model (camera.h).
template <class M>
class Camera;

/// Whether a point has a pixel, and if not, why.
enum class ProjectStatus : std::uint8_t {
  kOk,
  kBehind,         ///< not in front of a camera that sees only forward
  kOutsideDomain,  ///< beyond the first fold or the domain of the model, or not a valid point (not
                   ///< finite, or at a distance outside 1e-100 to 1e100)
};

/// "ok", "behind" or "outside". `alidade project`, which knows the image size, also prints "out_of_image".
[[nodiscard]] std::string_view statusId(ProjectStatus status);

/// The projection of a point in the camera frame. `pixel` is NaN unless the status is kOk.
struct Projection {
  Eigen::Vector2d pixel = Eigen::Vector2d::Constant(std::numeric_limits<double>::quiet_NaN());
  ProjectStatus status = ProjectStatus::kOutsideDomain;

  [[nodiscard]] bool ok() const { return status == ProjectStatus::kOk; }
};

/// The cone around the optical axis in which the projection is one-to-one.
struct CertifiedCone {
  double max_angle_rad = std::numbers::pi;  ///< largest field angle that may be used
  bool is_limited_by_fold = false;          ///< by a fold or pole; false: by the model itself
};

/// Ids of all models, in the order of the model list.
[[nodiscard]] const std::vector<std::string>& modelIds();

/// Names of a model's parameters in storage order (fx fy cx cy, then the lens).
/// @throws Error (kUsage) for an unknown id, naming the known ones.
[[nodiscard]] std::span<const std::string_view> parameterNames(std::string_view model_id);

/// The index of `name` among the names of parameters.
[[nodiscard]] std::optional<std::size_t> parameterIndex(std::span<const std::string_view> names,
                                                        std::string_view name);

/// Describes for a message what parameter `i` (in storage order) of a model must be: finite, positive (fx and
/// fy), or in its range (lens). std::nullopt if `value` is valid.
/// @pre the model has such a parameter
[[nodiscard]] std::optional<std::string> parameterComplaint(std::string_view model_id, std::size_t i,
                                                            double value);

/// Parameters of the model's initial guess, with the principal point at the image centre and the given focal
/// length (positive) in pixels per radian on the axis. In some models, fx and fy differ from this focal
/// length.
[[nodiscard]] std::vector<double> startParameters(std::string_view model_id, double focal_px, ImageSize size);

/// A camera of any model, with value semantics. It is immutable, so copies share memory.
class AnyCamera {
 public:
  /// Defined in camera_variant.h, which is not installed.
  template <class M>
  explicit AnyCamera(const Camera<M>& camera);
  // Not movable: a moved-from camera would be empty.
  AnyCamera(const AnyCamera&) = default;
  AnyCamera& operator=(const AnyCamera&) = default;
  ~AnyCamera() = default;

  /// Creates a camera from a model's id and its parameters in storage order.
  /// @throws Error (kUsage) for an unknown id; Error (kInput) for a wrong count, a number that is not finite,
  /// a focal length that is not positive, or a lens parameter out of its range, naming the parameter.
  [[nodiscard]] static AnyCamera make(std::string_view model_id, std::span<const double> params);
  /// The same, from all parameters by name in any order: make("pinhole", {{"fx", 500}, {"fy", 500}, ...}).
  /// @throws also Error (kInput) for a missing name; Error (kUsage) for an unknown one
  [[nodiscard]] static AnyCamera make(std::string_view model_id, const std::map<std::string, double>& params);

  [[nodiscard]] std::string_view modelId() const;
  [[nodiscard]] std::span<const std::string_view> parameterNames() const;
  [[nodiscard]] std::span<const double> parameters() const&;
  std::span<const double> parameters() const&& = delete;  ///< the span would outlive the camera
  /// A parameter by its name. @throws Error (kUsage) for a name that the model does not have
  [[nodiscard]] double parameter(std::string_view name) const;
  [[nodiscard]] const CertifiedCone& cone() const;

  /// The pixel of a point in the camera frame, in any unit of length, or why it has none. The camera does not
  /// know its image size: the pixel may lie outside the image.
  /// The row-major Jacobians J_px_cam (2x3) and J_px_params (2xN) may be null. They are written only if the
  /// status is kOk. projectBatch() also has those of a pose.
  [[nodiscard]] Projection project(const Eigen::Vector3d& p_cam, double* J_px_cam = nullptr,
                                   double* J_px_params = nullptr) const;
  /// The unit ray in the camera frame that projects to `pixel`; std::nullopt if no ray of the domain does.
  /// The row-major Jacobian J_ray_pixel (3x2) may be null. It is written only if there is a ray.
  [[nodiscard]] std::optional<Eigen::Vector3d> unproject(const Eigen::Vector2d& pixel,
                                                         double* J_ray_pixel = nullptr) const;

  /// Projects many points. projectBatch() is even faster if there is one array per coordinate.
  void project(std::span<const Eigen::Vector3d> points_cam, std::span<Projection> out) const;

  /// Calls f(const Camera<M>&) with the type of the model. Defined in camera_variant.h, which is not
  /// installed.
  template <class F>
  decltype(auto) visit(F&& f) const;

 private:
  std::shared_ptr<const detail::CameraVariant> camera_;
};

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

/// Whether the lens folds over or has a pole in the illuminated part of the image. A lens of less than 180
/// degrees illuminates the whole image. Pixels more than 90 degrees from the axis are assumed to be the dark
/// corners of a fisheye image.
[[nodiscard]] bool foldsInsideImage(const DomainCertificate& domain);
/// The same, but runs certifyDomain() first, which is slower.
[[nodiscard]] bool foldsInsideImage(const AnyCamera& camera, ImageSize size);

}  // namespace alidade
