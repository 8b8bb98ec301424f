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

// Points along the border of an image, one per pixel.
// The corners of the image and its sides between them, each pixel up to a limit: the image of a cone is
// nearly convex, so that it has what lies between two points of a side.
std::vector<Eigen::Vector2d> imageBorder(ImageSize size) {
  constexpr int kMostSteps = 640;
  std::vector<Eigen::Vector2d> border;
  const auto at = [](int i, int num_steps, int side) { return -0.5 + i * (side / double(num_steps)); };
  const int columns = std::min(size.width, kMostSteps);
  for (int i = 0; i <= columns; ++i) {
    border.emplace_back(at(i, columns, size.width), -0.5);
    border.emplace_back(at(i, columns, size.width), size.height - 0.5);
  }
  const int rows = std::min(size.height, kMostSteps);
  for (int i = 1; i < rows; ++i) {
    border.emplace_back(-0.5, at(i, rows, size.height));
    border.emplace_back(size.width - 0.5, at(i, rows, size.height));
  }
  return border;
}

// Determinant of the lens's row-major Jacobian by the tangent plane of the unit sphere at `ray` (unit
// length), per steradian.
double sphereDeterminant(const double* J, const Eigen::Vector3d& ray) {
  const Eigen::Map<const Eigen::Matrix<double, 2, 3, Eigen::RowMajor>> J_m_ray(J);
  // Rows a, b of the 2x3 matrix, restricted to the plane normal to the ray: det = (a x b) . ray.
  return J_m_ray.row(0).cross(J_m_ray.row(1)).dot(ray);
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

DomainCertificate certifyDomain(const AnyCamera& camera, ImageSize size) {
  DomainCertificate result;
  result.cone = camera.cone();
  result.full_image = true;
  const auto certify = [&]<class M>(const Camera<M>& c) {
    const double* lens = c.params().data() + 4;
    const auto det = [&](const Eigen::Vector3d& ray) {
      double m[2];
      double J[6];
      return M::lens(lens, ray.data(), m, J) ? std::abs(sphereDeterminant(J, ray)) : 0.0;
    };
    const double axis_det = det(Eigen::Vector3d::UnitZ());
    result.min_relative_det = 1.0;
    const auto look = [&](double u, double v) {
      const std::optional<Eigen::Vector2d> at =
          camera.correction() == nullptr ? Eigen::Vector2d(u, v) : camera.correction()->undisplaced({u, v});
      const auto ray = at ? c.unproject(*at) : std::nullopt;
      if (!ray) {
        result.full_image = false;
        result.min_relative_det = 0.0;
        if (!result.pixel_without_ray) result.pixel_without_ray = Eigen::Vector2d(u, v);
        return;
      }
      result.min_relative_det = std::min(result.min_relative_det, det(*ray) / axis_det);
    };
    for (const Eigen::Vector2d& pixel : imageBorder(size)) look(pixel.x(), pixel.y());
    constexpr int kGrid = 24;  // the interior matters only for the determinant
    for (int j = 1; j < kGrid; ++j) {
      for (int i = 1; i < kGrid; ++i)
        look(-0.5 + i * size.width / double{kGrid}, -0.5 + j * size.height / double{kGrid});
    }
  };
  std::visit(certify, camera.variant().camera);
  return result;
}

bool foldsInsideImage(const DomainCertificate& domain) {
  return !domain.full_image && domain.cone.is_limited_by_fold &&
         domain.cone.max_angle_rad < std::numbers::pi / 2;
}

bool foldsInsideImage(const AnyCamera& camera, ImageSize size) {
  DomainCertificate domain;  // assumes that part of the image has no ray
  domain.cone = camera.cone();
  if (!foldsInsideImage(domain)) return false;
  const std::vector<Eigen::Vector2d> border = imageBorder(size);
  return std::any_of(border.begin(), border.end(),
                     [&](const Eigen::Vector2d& pixel) { return !camera.unproject(pixel); });
}

}  // namespace alidade
