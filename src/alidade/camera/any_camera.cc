// SPDX-License-Identifier: MIT
#include "alidade/camera/any_camera.h"

#include <algorithm>
#include <array>
#include <cmath>

#include <Eigen/Geometry>
#include <Eigen/LU>

#include "alidade/camera/camera_variant.h"
#include "alidade/camera/centred_point.h"
#include "alidade/camera/correction_field.h"
#include "alidade/camera/model_traits.h"
#include "alidade/core/error.h"
#include "alidade/core/mapped.h"
#include "alidade/core/text.h"

namespace alidade {
namespace {

std::string parametersOf(std::string_view model_id) {
  return "parameters of model " + std::string(model_id);
}

std::string list(std::span<const std::string_view> names) {
  return join(std::vector<std::string>(names.begin(), names.end()), ", ");
}

Error unknownParameter(std::string_view model_id, std::string_view name) {
  return usageError({.where = parametersOf(model_id),
                     .found = "unknown name '" + std::string(name) + "'",
                     .expected = list(alidade::parameterNames(model_id))});
}

std::string rangeText(const ParamRange& range) {
  if (std::isfinite(range.max))
    return "a number from " + exactText(range.min) + " to " + exactText(range.max);
  if (std::isfinite(range.min)) return "a number of at least " + exactText(range.min);
  return "a finite number";
}

}  // namespace

const std::vector<std::string>& modelIds() {
  static const std::vector<std::string> ids =
      mapped(allModelTraits(), [](const ModelTraits& model) { return std::string(model.id); });
  return ids;
}

std::span<const std::string_view> parameterNames(std::string_view model_id) {
  return modelTraits(model_id).parameter_names;
}

std::optional<std::size_t> parameterIndex(std::span<const std::string_view> names, std::string_view name) {
  const auto at = std::find(names.begin(), names.end(), name);
  if (at == names.end()) return std::nullopt;
  return static_cast<std::size_t>(at - names.begin());
}

std::optional<std::string> parameterComplaint(std::string_view model_id, std::size_t i, double value) {
  if (i < 2) {
    if (std::isfinite(value) && value > 0) return std::nullopt;
    return "a positive focal length in pixels";
  }
  const ParamRange range = i < kNumAffine ? ParamRange() : modelTraits(model_id).lens_ranges[i - kNumAffine];
  if (std::isfinite(value) && value >= range.min && value <= range.max) return std::nullopt;
  return rangeText(range);
}

AnyCamera::AnyCamera(const detail::CameraVariant& camera)
    : camera_(std::make_shared<const detail::CameraVariant>(camera)) {}

AnyCamera AnyCamera::make(std::string_view model_id, std::span<const double> params) {
  const auto names = alidade::parameterNames(model_id);
  if (params.size() != names.size()) {
    throw inputError({.where = parametersOf(model_id),
                      .found = std::to_string(params.size()) + " numbers",
                      .expected = std::to_string(names.size())});
  }
  for (std::size_t i = 0; i < params.size(); ++i) {
    if (const auto complaint = parameterComplaint(model_id, i, params[i])) {
      throw inputError({.where = "parameter " + std::string(names[i]),
                        .found = exactText(params[i]),
                        .expected = *complaint});
    }
  }
  std::optional<AnyCamera> camera;
  AllModels::forEach([&]<class M>() {
    if (M::kId != model_id) return;
    typename Camera<M>::Params values{};
    std::ranges::copy(params, values.begin());
    camera.emplace(Camera<M>(values));
  });
  return *camera;
}

AnyCamera AnyCamera::make(std::string_view model_id, const std::map<std::string, double>& params) {
  const auto names = alidade::parameterNames(model_id);
  std::vector<double> values;
  for (const std::string_view name : names) {
    const auto value = params.find(std::string(name));
    if (value == params.end())
      throw inputError(
          {.where = parametersOf(model_id), .found = "no " + std::string(name), .expected = list(names)});
    values.push_back(value->second);
  }
  for (const auto& [name, value] : params) {
    if (!parameterIndex(names, name)) throw unknownParameter(model_id, name);
  }
  return make(model_id, values);
}

double AnyCamera::parameter(std::string_view name) const {
  const auto i = parameterIndex(parameterNames(), name);
  if (!i) throw unknownParameter(modelId(), name);
  return parameters()[*i];
}

std::string_view AnyCamera::modelId() const {
  return std::visit([]<class M>(const Camera<M>&) { return M::kId; }, camera_->camera);
}

std::span<const std::string_view> AnyCamera::parameterNames() const {
  return alidade::parameterNames(modelId());
}

std::span<const double> AnyCamera::parameters() const& {
  return std::visit([](const auto& c) { return std::span<const double>(c.params()); }, camera_->camera);
}

const CertifiedCone& AnyCamera::cone() const {
  return std::visit([](const auto& c) -> const CertifiedCone& { return c.cone(); }, camera_->camera);
}

Projection AnyCamera::project(const Eigen::Vector3d& p_cam, double* J_px_cam, double* J_px_params) const {
  const auto of_model = [&](const auto& c) { return c.project(p_cam, J_px_cam, J_px_params); };
  Projection projection = std::visit(of_model, camera_->camera);
  if (correction_ == nullptr || !projection.ok()) return projection;
  if (!correction_->grid().has(projection.pixel)) return {.status = ProjectStatus::kOutsideDomain};
  Eigen::Matrix2d gradient;
  projection.pixel += correction_->at(projection.pixel, &gradient);
  const Eigen::Matrix2d J = Eigen::Matrix2d::Identity() + gradient;
  const auto apply = [&J](double* rows, Eigen::Index n) {
    if (rows == nullptr) return;
    Eigen::Map<Eigen::Matrix<double, 2, Eigen::Dynamic, Eigen::RowMajor>> to(rows, 2, n);
    for (Eigen::Index i = 0; i < n; ++i) to.col(i) = Eigen::Vector2d(J * to.col(i));
  };
  apply(J_px_cam, 3);
  apply(J_px_params, static_cast<Eigen::Index>(parameters().size()));
  return projection;
}

Projection AnyCamera::projectPoint(const Eigen::Vector3d& p_cam_m, double* J_px_cam,
                                   double* J_px_params) const {
  if (pupil_.isFixed()) return project(p_cam_m, J_px_cam, J_px_params);
  const auto moved = detail::centredPoint(pupil_.s1_m, pupil_.s2_m, p_cam_m.data());
  if (!(moved.certainty > moved.kLeast)) return {.status = ProjectStatus::kOutsideDomain};
  const Projection projection = project({p_cam_m.x(), p_cam_m.y(), moved.z}, J_px_cam, J_px_params);
  if (projection.ok() && J_px_cam != nullptr) moved.apply(J_px_cam);
  return projection;
}

Eigen::Vector3d AnyCamera::startOf(const Eigen::Vector3d& ray) const {
  if (pupil_.isFixed()) return Eigen::Vector3d::Zero();
  return pupil_.at(std::atan2(ray.head<2>().norm(), ray.z())) * Eigen::Vector3d::UnitZ();
}

AnyCamera AnyCamera::withPupil(const EntrancePupil& pupil) const {
  expect(std::isfinite(pupil.s1_m) && std::isfinite(pupil.s2_m), "a finite entrance pupil");
  AnyCamera camera = *this;
  camera.pupil_ = pupil;
  return camera;
}

AnyCamera AnyCamera::withCorrection(std::shared_ptr<const CorrectionField> correction) const {
  AnyCamera camera = *this;
  camera.correction_ = std::move(correction);
  return camera;
}

void AnyCamera::requireUncorrected() const {
  if (correction_ == nullptr) return;
  throw inputError(
      {.where = "camera of model " + std::string(modelId()),
       .found = "a correction field",
       .expected = "a camera without one for this command",
       .next_step = "fit its model to the whole: alidade convert CAMERA -o PLAIN --drop-correction"});
}

AnyCamera AnyCamera::withParameters(std::span<const double> params) const {
  return make(modelId(), params).withPupil(pupil_).withCorrection(correction_);
}

std::optional<std::string> EntrancePupil::complaint(double value_m) {
  constexpr double kMost = 0.1;  // ten times what the largest lenses have
  if (std::isfinite(value_m) && std::abs(value_m) <= kMost) return std::nullopt;
  return "a number of metres from -0.1 to 0.1";
}

void EntrancePupil::validate() const {
  for (const auto& [name, value_m] : {std::pair(kNames[0], s1_m), std::pair(kNames[1], s2_m)}) {
    if (const auto expected = complaint(value_m)) {
      throw inputError({.where = "entrance pupil " + std::string(name),
                        .found = exactText(value_m),
                        .expected = *expected});
    }
  }
}

std::optional<Eigen::Vector3d> AnyCamera::unproject(const Eigen::Vector2d& pixel, double* J_ray_pixel) const {
  const auto of_model = [&](const Eigen::Vector2d& at) {
    return std::visit([&](const auto& c) { return c.unproject(at, J_ray_pixel); }, camera_->camera);
  };
  if (correction_ == nullptr) return of_model(pixel);
  const auto at = correction_->undisplaced(pixel);
  const auto ray = at ? of_model(*at) : std::nullopt;
  if (ray && J_ray_pixel != nullptr) {
    Eigen::Matrix2d gradient;
    static_cast<void>(correction_->at(*at, &gradient));
    Eigen::Map<Eigen::Matrix<double, 3, 2, Eigen::RowMajor>> J(J_ray_pixel);
    J *= (Eigen::Matrix2d::Identity() + gradient).inverse();
  }
  return ray;
}

}  // namespace alidade
