// SPDX-License-Identifier: MIT
#pragma once

#include <cstddef>
#include <map>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include <Eigen/Core>

#include "alidade/camera/entrance_pupil.h"
#include "alidade/camera/project_status.h"
#include "alidade/core/image.h"

namespace alidade {

namespace detail {
struct CameraVariant;  // see camera_variant.h
}  // namespace detail
class CorrectionField;

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

/// A camera of any model, with value semantics. It is immutable, so copies share memory.
class AnyCamera {
 public:
  /// A camera of any one model; the header of its type is not installed.
  explicit AnyCamera(const detail::CameraVariant& camera);
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
  std::span<const double> parameters() const&& = delete;  ///< the span would outlive a temporary camera
  /// A parameter by its name. @throws Error (kUsage) for a name that the model does not have
  [[nodiscard]] double parameter(std::string_view name) const;
  [[nodiscard]] const CertifiedCone& cone() const;
  [[nodiscard]] const EntrancePupil& pupil() const { return pupil_; }
  /// The same lens with another entrance pupil.
  /// @pre its numbers are finite
  [[nodiscard]] AnyCamera withPupil(const EntrancePupil& pupil) const;
  /// How the lens deviates from its model; null: not at all.
  [[nodiscard]] const std::shared_ptr<const CorrectionField>& correction() const { return correction_; }
  /// The same lens with another correction field, or without one.
  [[nodiscard]] AnyCamera withCorrection(std::shared_ptr<const CorrectionField> correction) const;
  /// For what takes a camera as its model's parameters. @throws Error (kInput) if it has a correction field
  void requireUncorrected() const;
  /// The same camera with other parameters of its model. @throws Error, see make()
  [[nodiscard]] AnyCamera withParameters(std::span<const double> params) const;

  /// The pixel of a ray of the camera frame, or of a far point on it in any unit of length, or why it has
  /// none; it does not depend on the entrance pupil. The camera does not know its image size: the pixel may
  /// lie outside the image.
  /// The row-major Jacobians J_px_cam (2x3) and J_px_params (2xN) may be null. They are written only if the
  /// status is kOk. projectBatch() takes many points and also has the Jacobians of a pose.
  [[nodiscard]] Projection project(const Eigen::Vector3d& p_cam, double* J_px_cam = nullptr,
                                   double* J_px_params = nullptr) const;
  /// The same for a near point, metres, which an entrance pupil that moves sees in another direction. Without
  /// one, the same as project().
  [[nodiscard]] Projection projectPoint(const Eigen::Vector3d& p_cam_m, double* J_px_cam = nullptr,
                                        double* J_px_params = nullptr) const;
  /// The unit ray in the camera frame that projects to `pixel`; std::nullopt if no ray of the domain does.
  /// The row-major Jacobian J_ray_pixel (3x2) may be null. It is written only if there is a ray.
  [[nodiscard]] std::optional<Eigen::Vector3d> unproject(const Eigen::Vector2d& pixel,
                                                         double* J_ray_pixel = nullptr) const;

  /// Where on the axis a ray starts, metres in the camera frame.
  [[nodiscard]] Eigen::Vector3d startOf(const Eigen::Vector3d& ray) const;

  /// The camera of its model, without pupil and correction, for the library's own loops.
  [[nodiscard]] const detail::CameraVariant& variant() const { return *camera_; }

 private:
  std::shared_ptr<const detail::CameraVariant> camera_;
  EntrancePupil pupil_ = {};
  std::shared_ptr<const CorrectionField> correction_ = {};
};

}  // namespace alidade
