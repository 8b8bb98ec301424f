// SPDX-License-Identifier: MIT
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <limits>
#include <numbers>
#include <optional>
#include <utility>
#include <vector>

#include <Eigen/Core>
#include <Eigen/Geometry>

#include "alidade/camera/camera_model.h"
#include "alidade/camera/domain.h"
#include "alidade/camera/project_status.h"
#include "alidade/camera/projection.h"

namespace alidade {

/// A camera of one model: its parameters and the cone in which they are one-to-one. Immutable.
template <class M>
class Camera {
  static_assert(CameraModel<M>);

 public:
  using Model = M;
  static constexpr int kNumParams = alidade::kNumParams<M>;
  using Params = std::array<double, static_cast<std::size_t>(kNumParams)>;

  /// Certifies the cone for `params` (fx fy cx cy, then the lens; all finite, fx and fy positive).
  explicit Camera(const Params& params) : params_(params), domain_(domainOf(params)) {}

  [[nodiscard]] const Params& params() const { return params_; }
  [[nodiscard]] const CertifiedCone& cone() const { return domain_.cone; }
  /// For M::quickUnlens().
  [[nodiscard]] const typename M::Start& start() const { return domain_.start; }

  /// Pixel of a point in the camera frame (any unit of length), or why there is none. Row-major Jacobians
  /// J_px_cam (2x3) and J_px_params (2 x kNumParams), null: not computed, are written only if the status is
  /// kOk.
  [[nodiscard]] Projection project(const Eigen::Vector3d& p_cam, double* J_px_cam = nullptr,
                                   double* J_px_params = nullptr) const {
    Projection result;
    result.status = classify(p_cam);
    if (!result.ok()) return result;
    double px[2];
    if (!projectFormulaJacobian<M>(params_.data(), p_cam.data(), px, J_px_cam, J_px_params)) {
      result.status = ProjectStatus::kOutsideDomain;
      return result;
    }
    result.pixel = {px[0], px[1]};
    return result;
  }

  /// Unit ray in the camera frame that projects to `pixel`; nothing if no ray of the domain does. The
  /// row-major Jacobian J_ray_pixel (3x2), null: not computed, is written only if there is a ray.
  [[nodiscard]] std::optional<Eigen::Vector3d> unproject(const Eigen::Vector2d& pixel,
                                                         double* J_ray_pixel = nullptr) const {
    const double m[2] = {(pixel.x() - params_[2]) / params_[0], (pixel.y() - params_[3]) / params_[1]};
    // The image of the cone is bounded by that of its rim. False for NaN too.
    if (!(std::hypot(m[0], m[1]) <= domain_.rim_radius)) return std::nullopt;
    std::optional<Eigen::Vector3d> ray(std::in_place);
    M::quickUnlens(params_.data() + 4, domain_.start, m, domain_.cone.max_angle_rad, ray->data());
    if (classify(*ray) != ProjectStatus::kOk) {
      if (!M::unlens(params_.data() + 4, m, domain_.cone.max_angle_rad, ray->data())) return std::nullopt;
      if (classify(*ray) != ProjectStatus::kOk) ray = onRim(*ray, pixel);
    }
    if (ray && J_ray_pixel != nullptr) rayByPixel<M>(params_.data(), ray->data(), J_ray_pixel);
    return ray;
  }

 private:
  [[nodiscard]] ProjectStatus classify(const Eigen::Vector3d& p) const {
    // Squares of longer or shorter vectors overflow or vanish, and a lens that divides by infinity would give
    // a pixel for any point. The norm is then infinite or zero, which is outside the bounds too.
    constexpr double kMinLength = 1e-100;
    constexpr double kMaxLength = 1e100;
    const double norm = p.norm();
    if (!(norm >= kMinLength && norm <= kMaxLength)) return ProjectStatus::kOutsideDomain;
    if (M::kMaxAngle <= std::numbers::pi / 2 && p.z() <= 0.0) return ProjectStatus::kBehind;
    return p.z() >= domain_.cos_max_angle * norm ? ProjectStatus::kOk : ProjectStatus::kOutsideDomain;
  }

  // A ray exactly on the rim of the cone returns from its pixel with rounding, which may put it outside. It
  // counts if it cannot be distinguished from the nearest ray on the rim, by angle or by pixel.
  [[nodiscard]] std::optional<Eigen::Vector3d> onRim(const Eigen::Vector3d& ray,
                                                     const Eigen::Vector2d& pixel) const {
    constexpr double kSameRay = 1e-13;   // rad
    constexpr double kNearRay = 1e-9;    // rad; rounding of rays where the lens nearly folds
    constexpr double kSamePixel = 1e-8;  // px
    const double rho = std::hypot(ray.x(), ray.y());
    if (!(rho > 0.0)) return std::nullopt;
    // Inside by more than the rounding of classify().
    const double z = domain_.cos_max_angle + 4 * std::numeric_limits<double>::epsilon();
    const double scale = std::sqrt(std::max(0.0, (1 - z) * (1 + z))) / rho;
    const Eigen::Vector3d rim(scale * ray.x(), scale * ray.y(), z);
    const double away = (rim - ray).norm();
    if (!(away <= kNearRay)) return std::nullopt;
    const Projection projection = project(rim);
    if (!projection.ok()) return std::nullopt;
    if (away > kSameRay && !((projection.pixel - pixel).norm() <= kSamePixel)) return std::nullopt;
    return rim;
  }

  // What follows from the lens alone.
  struct Domain {
    CertifiedCone cone;
    double cos_max_angle;
    double rim_radius;  // no pixel of the cone lies farther from the axis in the normalised plane
    typename M::Start start;

    explicit Domain(const double* lens)
        : cone(certifyCone(lensFunction<M>(lens), {.model_rad = M::kMaxAngle,
                                                   .closed_form_rad = M::maxAngle(lens),
                                                   .is_axially_symmetric = M::isAxiallySymmetric(lens),
                                                   .is_one_to_one_without_fold = M::kIsOneToOneWithoutFold,
                                                   .margin_rad = M::kEndMargin})),
          cos_max_angle(std::cos(cone.max_angle_rad)),
          rim_radius(rimRadius(lens)),
          start(M::makeStart(lens, cone.max_angle_rad)) {}

    [[nodiscard]] double rimRadius(const double* lens) const {
      constexpr int kNumAzimuths = 64;
      constexpr double kLeastStep = 1e-9;
      const double s = std::sin(cone.max_angle_rad);
      const auto radiusAt = [&](double azimuth) {
        const double ray[3] = {s * std::cos(azimuth), s * std::sin(azimuth), cos_max_angle};
        double m[2] = {};
        const double radius = M::lens(lens, ray, m) ? std::hypot(m[0], m[1]) : HUGE_VAL;
        return std::isnan(radius) ? HUGE_VAL : radius;
      };
      double farthest = radiusAt(0);
      // Margins for rounding and a ray onRim(), and for other maxima between the azimuths.
      if (M::isAxiallySymmetric(lens)) return farthest * (1 + 1e-6);
      double azimuth = 0;
      const auto look = [&](double at) {
        const double radius = radiusAt(at);
        if (!(radius > farthest)) return;
        farthest = radius;
        azimuth = at;
      };
      double step = 2 * std::numbers::pi / kNumAzimuths;
      for (int i = 1; i < kNumAzimuths; ++i) look(i * step);
      // Near a pole of one azimuth the farthest point lies in a narrow peak.
      for (; step > kLeastStep; step *= 0.5) {
        look(azimuth + step);
        look(azimuth - step);
      }
      return 1.1 * farthest;
    }
  };

  // Certifying a lens takes up to a millisecond, and callers often change only how it is placed on the
  // sensor, or alternate between a few cameras: each thread remembers the lenses that it used last.
  static const Domain& domainOf(const Params& params) {
    struct Entry {
      Params params;
      Domain domain;
    };
    constexpr std::size_t kNumRemembered = 4;
    thread_local std::vector<Entry> remembered;  // the last one first
    const auto isSameLens = [&](const Entry& entry) {
      return std::equal(params.begin() + kNumAffine, params.end(), entry.params.begin() + kNumAffine);
    };
    auto found = std::find_if(remembered.begin(), remembered.end(), isSameLens);
    if (found == remembered.end()) {
      Entry entry{params, Domain(params.data() + kNumAffine)};
      if (remembered.size() == kNumRemembered) remembered.pop_back();
      remembered.push_back(std::move(entry));
      found = remembered.end() - 1;
    }
    std::rotate(remembered.begin(), found, found + 1);
    return remembered.front().domain;
  }

  Params params_;
  Domain domain_;
};

}  // namespace alidade
