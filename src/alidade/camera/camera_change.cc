// SPDX-License-Identifier: MIT
#include "alidade/camera/camera_change.h"

#include <algorithm>
#include <array>
#include <vector>

#include "alidade/camera/model_traits.h"

namespace alidade {

std::string_view changeId(CameraChangeKind kind) {
  constexpr std::array<std::string_view, 12> kIds = {
      "focal_length", "aspect", "principal_point", "cx",       "cy",   "pixel_origin",
      "distortion",   "radial", "rotation",        "position", "pose", "several"};
  return kIds.at(static_cast<std::size_t>(kind));
}

Eigen::Index numAmounts(CameraChangeKind kind) {
  if (kind == CameraChangeKind::kRotation) return 3;
  return kind == CameraChangeKind::kPosition || kind == CameraChangeKind::kPrincipalPoint ? 2 : 1;
}

Eigen::MatrixXd directionsOf(CameraChangeKind kind, const AnyCamera& camera, std::size_t num_params) {
  using enum CameraChangeKind;
  const auto params = camera.parameters();
  const auto n = static_cast<Eigen::Index>(std::max(num_params, params.size()));
  if (kind == kSeveral) return Eigen::MatrixXd::Identity(n, n);
  Eigen::MatrixXd D = Eigen::MatrixXd::Zero(n, numAmounts(kind));
  if (kind == kFocalLength || kind == kAspect) D(0, 0) = params[0];
  if (kind == kFocalLength) D(1, 0) = params[1];
  if (kind == kPrincipalPoint || kind == kCenterX || kind == kPixelOrigin) D(2, 0) = 1;
  if (kind == kPrincipalPoint) D(3, 1) = 1;
  if (kind == kCenterY || kind == kPixelOrigin) D(3, 0) = 1;
  if (kind == kFirstRadial && n > 4) D(4, 0) = 1;
  for (std::size_t i = 4; kind == kDistortion && i < params.size(); ++i)
    D(static_cast<Eigen::Index>(i), 0) = params[i];
  return D;
}

std::optional<AnyCamera> changedCamera(const AnyCamera& camera, CameraChangeKind kind,
                                       const Eigen::VectorXd& amounts) {
  std::string_view model = camera.modelId();
  std::vector<double> params(camera.parameters().begin(), camera.parameters().end());
  if (kind == CameraChangeKind::kFirstRadial && params.size() == 4) {
    const ModelTraits& with_distortion = *nextLargerModel(model);
    model = with_distortion.id;
    params.resize(with_distortion.parameter_names.size(), 0);
  }
  const bool is_factor = kind == CameraChangeKind::kFocalLength || kind == CameraChangeKind::kAspect ||
                         kind == CameraChangeKind::kDistortion;
  const Eigen::MatrixXd D = directionsOf(kind, camera, params.size());
  for (std::size_t i = 0; i < params.size(); ++i) {
    const auto row = D.row(static_cast<Eigen::Index>(i));
    if (row.isZero(0)) continue;
    if (is_factor) {
      params[i] *= 1 + amounts[0];
    } else {
      params[i] += row.dot(amounts);
    }
  }
  return cameraWith(model, params);
}

std::optional<AnyCamera> cameraWith(std::string_view model_id, std::span<const double> params) {
  for (std::size_t i = 0; i < params.size(); ++i) {
    if (parameterComplaint(model_id, i, params[i])) return std::nullopt;
  }
  return AnyCamera::make(model_id, params);
}

}  // namespace alidade
