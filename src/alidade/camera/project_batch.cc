// SPDX-License-Identifier: MIT
#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <numbers>

#include <Eigen/Core>

#include "alidade/camera/batch.h"
#include "alidade/camera/batch_kernel.h"
#include "alidade/camera/camera_variant.h"
#include "alidade/camera/projection.h"
#include "alidade/core/error.h"

namespace alidade {
namespace {

struct Pose {
  explicit Pose(const SE3& a_from_b) {
    Eigen::Map<Eigen::Matrix<double, 3, 3, Eigen::RowMajor>>(R.data()) = a_from_b.rotation.matrix();
    Eigen::Map<Eigen::Vector3d>(t.data()) = a_from_b.translation;
  }
  std::array<double, 9> R{};
  std::array<double, 3> t{};
};

// One call's arrays, and the first of the points that the loops have reached.
struct ProjectArrays {
  const double* x;
  const double* y;
  const double* z;
  double* u;
  double* v;
  ProjectStatus* status;
  PixelJacobians jacobians;
};

template <CameraModel M>
class ProjectLoop {
 public:
  ProjectLoop(const Camera<M>& camera, const Pose& pose) : params_(camera.params()), pose_(pose) {
    const double c = std::cos(camera.cone().max_angle_rad);
    signed_cos2_ = c * std::abs(c);
  }

  template <bool kHasPose, bool kHasJacobians>
  ALIDADE_ALWAYS_INLINE void group(const ProjectArrays& a, std::size_t i) const {
    const Lanes p[3] = {lane::load(a.x + i), lane::load(a.y + i), lane::load(a.z + i)};
    Lanes p_cam[3] = {p[0], p[1], p[2]};
    if constexpr (kHasPose) {
      const auto& R = pose_.R;
      const auto& t = pose_.t;
      for (std::size_t r = 0; r < 3; ++r)
        p_cam[r] = R[3 * r] * p[0] + (R[3 * r + 1] * p[1] + (R[3 * r + 2] * p[2] + t[r]));
    }
    // As Camera::classify(), in squares.
    const Lanes norm2 = p_cam[0] * p_cam[0] + p_cam[1] * p_cam[1] + p_cam[2] * p_cam[2];
    const Lanes z = p_cam[2];
    const Lanes signed_z2 = lane::select(z < 0.0, -z * z, z * z);
    const LaneMask is_point = lane::both(norm2 >= kMinLength2, norm2 <= kMaxLength2);
    LaneMask is_ok = lane::both(is_point, signed_z2 >= signed_cos2_ * norm2);
    const LaneMask is_behind = lane::both(is_point, z <= 0.0);
    constexpr bool kLooksForward = M::kMaxAngle <= std::numbers::pi / 2;
    if constexpr (kLooksForward) is_ok = lane::both(is_ok, z > 0.0);

    constexpr int kParams = kNumParams<M>;
    Lanes px[2];
    Lanes J_px_cam[6];
    Lanes J_px_params[2 * kParams];
    Lanes* const not_wanted = nullptr;
    projectInside<M>(params_.data(), p_cam, px, kHasJacobians ? J_px_cam : not_wanted,
                     kHasJacobians && a.jacobians.by_params != nullptr ? J_px_params : not_wanted);
    // x - x is NaN for infinities too.
    const Lanes undefined = (px[0] - px[0]) + (px[1] - px[1]);
    is_ok = lane::both(is_ok, undefined == 0.0);
    const Lanes nothing = lane::select(is_ok, Lanes{}, Lanes{} + batch::kNaN);
    lane::store(lane::select(is_ok, px[0], nothing), a.u + i);
    lane::store(lane::select(is_ok, px[1], nothing), a.v + i);
    if (lane::isAll(is_ok)) {
      std::fill_n(a.status + i, kNumLanes, ProjectStatus::kOk);
    } else {
      for (std::size_t l = 0; l < kNumLanes; ++l)
        a.status[i + l] = statusOf(batch::laneOf(is_ok, l), kLooksForward && batch::laneOf(is_behind, l));
    }
    if constexpr (kHasJacobians) {
      if (a.jacobians.by_params != nullptr)
        batch::scatter<2 * kParams>(J_px_params, nothing, a.jacobians.by_params + i * 2 * kParams);
      const auto& R = pose_.R;
      Lanes by_point[6];
      for (std::size_t r = 0; r < 2; ++r) {
        const Lanes* row = J_px_cam + 3 * r;
        for (std::size_t c = 0; c < 3; ++c)
          by_point[3 * r + c] = row[0] * R[c] + row[1] * R[3 + c] + row[2] * R[6 + c];
      }
      if (a.jacobians.by_point != nullptr) batch::scatter<6>(by_point, nothing, a.jacobians.by_point + i * 6);
      if (a.jacobians.by_pose != nullptr) {
        Lanes by_pose[12];
        for (std::size_t r = 0; r < 2; ++r) {
          const Lanes* g = by_point + 3 * r;
          Lanes* to = by_pose + 6 * r;
          for (std::size_t c = 0; c < 3; ++c) to[c] = g[c];
          to[3] = p[1] * g[2] - p[2] * g[1];
          to[4] = p[2] * g[0] - p[0] * g[2];
          to[5] = p[0] * g[1] - p[1] * g[0];
        }
        batch::scatter<12>(by_pose, nothing, a.jacobians.by_pose + i * 12);
      }
    }
  }

 private:
  static constexpr double kMinLength2 = 1e-200;
  static constexpr double kMaxLength2 = 1e200;

  static ALIDADE_ALWAYS_INLINE ProjectStatus statusOf(bool is_ok, bool is_behind) {
    if (is_ok) return ProjectStatus::kOk;
    return is_behind ? ProjectStatus::kBehind : ProjectStatus::kOutsideDomain;
  }

  typename Camera<M>::Params params_;
  Pose pose_;
  double signed_cos2_;
};

template <bool kHasPose, bool kHasJacobians, CameraModel M>
ALIDADE_ALWAYS_INLINE void projectGroups(const ProjectLoop<M>& loop, const ProjectArrays& a,
                                         std::size_t count) {
  // Copies that nobody else can write to: what depends on the parameters alone is computed once.
  const ProjectLoop<M> local = loop;
  const ProjectArrays arrays = a;
  for (std::size_t i = 0; i < count; i += kNumLanes) local.template group<kHasPose, kHasJacobians>(arrays, i);
}

#if defined(ALIDADE_HAS_AVX2_VARIANT)
template <bool kHasPose, bool kHasJacobians, CameraModel M>
ALIDADE_TARGET_AVX2 void projectGroupsAvx2(const ProjectLoop<M>& loop, const ProjectArrays& a,
                                           std::size_t count) {
  projectGroups<kHasPose, kHasJacobians>(loop, a, count);
}
#endif

// `count` is a multiple of the number of lanes.
template <bool kHasPose, bool kHasJacobians, CameraModel M>
void projectWhole(const ProjectLoop<M>& loop, const ProjectArrays& a, std::size_t count) {
#if defined(ALIDADE_HAS_AVX2_VARIANT)
  if (batch::usesAvx2()) return projectGroupsAvx2<kHasPose, kHasJacobians>(loop, a, count);
#endif
  projectGroups<kHasPose, kHasJacobians>(loop, a, count);
}

template <bool kHasPose, bool kHasJacobians, CameraModel M>
void projectArrays(const Camera<M>& camera, const Pose& pose, const ProjectArrays& a, std::size_t count) {
  const ProjectLoop<M> loop(camera, pose);
  const std::size_t whole = count - count % kNumLanes;
  projectWhole<kHasPose, kHasJacobians>(loop, a, whole);
  const std::size_t rest = count - whole;
  if (rest == 0) return;
  const batch::Padded<double> x(a.x + whole, rest, batch::kNaN);
  const batch::Padded<double> y(a.y + whole, rest, batch::kNaN);
  const batch::Padded<double> z(a.z + whole, rest, batch::kNaN);
  double u[kNumLanes];
  double v[kNumLanes];
  ProjectStatus status[kNumLanes];
  constexpr std::size_t kParams = 2 * kNumParams<M>;
  std::array<double, 6 * kNumLanes> by_point{};
  std::array<double, 12 * kNumLanes> by_pose{};
  std::array<double, kParams * kNumLanes> by_params{};
  const PixelJacobians J = a.jacobians;
  projectWhole<kHasPose, kHasJacobians>(
      loop,
      {.x = x.data(),
       .y = y.data(),
       .z = z.data(),
       .u = u,
       .v = v,
       .status = status,
       .jacobians = {.by_point = J.by_point ? by_point.data() : nullptr,
                     .by_pose = J.by_pose ? by_pose.data() : nullptr,
                     .by_params = J.by_params ? by_params.data() : nullptr}},
      kNumLanes);
  std::copy_n(u, rest, a.u + whole);
  std::copy_n(v, rest, a.v + whole);
  std::copy_n(status, rest, a.status + whole);
  if (J.by_point != nullptr) std::copy_n(by_point.data(), 6 * rest, J.by_point + 6 * whole);
  if (J.by_pose != nullptr) std::copy_n(by_pose.data(), 12 * rest, J.by_pose + 12 * whole);
  if (J.by_params != nullptr) std::copy_n(by_params.data(), kParams * rest, J.by_params + kParams * whole);
}

void project(const AnyCamera& camera, const SE3* camera_from_points, const PointColumns& points,
             const PixelResults& pixels, const PixelJacobians& jacobians) {
  const std::size_t count = points.x.size();
  expect(points.y.size() == count && points.z.size() == count && pixels.u.size() == count &&
             pixels.v.size() == count && pixels.status.size() == count,
         "the arrays of a batch have one length");
  const ProjectArrays arrays = {.x = points.x.data(),
                                .y = points.y.data(),
                                .z = points.z.data(),
                                .u = pixels.u.data(),
                                .v = pixels.v.data(),
                                .status = pixels.status.data(),
                                .jacobians = jacobians};
  const bool has_jacobians =
      jacobians.by_point != nullptr || jacobians.by_pose != nullptr || jacobians.by_params != nullptr;
  const Pose pose(camera_from_points != nullptr ? *camera_from_points : SE3());
  camera.visit([&](const auto& c) {
    if (has_jacobians) {
      projectArrays<true, true>(c, pose, arrays, count);
    } else if (camera_from_points != nullptr) {
      projectArrays<true, false>(c, pose, arrays, count);
    } else {
      projectArrays<false, false>(c, pose, arrays, count);
    }
  });
}

}  // namespace

void projectBatch(const AnyCamera& camera, const PointColumns& points_cam, const PixelResults& pixels,
                  const PixelJacobians& jacobians) {
  project(camera, nullptr, points_cam, pixels, jacobians);
}

void projectBatch(const AnyCamera& camera, const SE3& camera_from_points, const PointColumns& points,
                  const PixelResults& pixels, const PixelJacobians& jacobians) {
  project(camera, &camera_from_points, points, pixels, jacobians);
}

}  // namespace alidade
