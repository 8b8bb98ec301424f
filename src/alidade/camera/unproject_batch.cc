// SPDX-License-Identifier: MIT
#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>

#include <Eigen/Core>

#include "alidade/camera/batch.h"
#include "alidade/camera/batch_kernel.h"
#include "alidade/camera/camera_variant.h"
#include "alidade/camera/projection.h"
#include "alidade/core/error.h"

namespace alidade {
namespace {

struct UnprojectArrays {
  const double* u;
  const double* v;
  double* x;
  double* y;
  double* z;
  ProjectStatus* status;
  double* J_ray_pixel;
};

template <CameraModel M>
class UnprojectLoop {
 public:
  explicit UnprojectLoop(const Camera<M>& camera)
      : camera_(camera),
        params_(camera.params()),
        start_(camera.start()),
        max_angle_(camera.cone().max_angle_rad),
        cos_max_angle_(std::cos(max_angle_)) {}

  ALIDADE_ALWAYS_INLINE void group(const UnprojectArrays& a, std::size_t i) const {
    const double* params = params_.data();
    const Lanes u = lane::load(a.u + i);
    const Lanes v = lane::load(a.v + i);
    const Lanes m[2] = {(u - params[2]) * (1 / params[0]), (v - params[3]) * (1 / params[1])};
    Lanes ray[3];
    M::quickUnlens(params + 4, start_, m, max_angle_, ray);
    const Lanes norm2 = ray[0] * ray[0] + ray[1] * ray[1] + ray[2] * ray[2];
    LaneMask is_ok = lane::both(norm2 > 0.5, ray[2] >= cos_max_angle_);
    if constexpr (M::kMaxAngle <= std::numbers::pi / 2) is_ok = lane::both(is_ok, ray[2] > 0.0);
    const Lanes nothing = lane::select(is_ok, Lanes{}, Lanes{} + batch::kNaN);
    lane::store(ray[0] + nothing, a.x + i);
    lane::store(ray[1] + nothing, a.y + i);
    lane::store(ray[2] + nothing, a.z + i);
    std::fill_n(a.status + i, kNumLanes, ProjectStatus::kOk);
    if (!lane::isAll(is_ok)) {
      for (std::size_t l = 0; l < kNumLanes; ++l)
        if (!batch::laneOf(is_ok, l)) tryHarder({u[l], v[l]}, a, i + l);
    }
    if (a.J_ray_pixel != nullptr) {
      const Lanes found[3] = {lane::load(a.x + i), lane::load(a.y + i), lane::load(a.z + i)};
      Lanes J[6];
      rayByPixel<M>(params, found, J);
      batch::scatter<6>(J, 0.0 * found[0], a.J_ray_pixel + 6 * i);
    }
  }

 private:
  // The rim, what Newton's method does not come by at once, and pixels without a ray.
  void tryHarder(const Eigen::Vector2d& pixel, const UnprojectArrays& a, std::size_t i) const {
    const auto ray = camera_.unproject(pixel);
    a.status[i] = ray ? ProjectStatus::kOk : ProjectStatus::kOutsideDomain;
    if (!ray) return;
    a.x[i] = ray->x();
    a.y[i] = ray->y();
    a.z[i] = ray->z();
  }

  const Camera<M>& camera_;
  typename Camera<M>::Params params_;
  typename M::Start start_;
  double max_angle_;
  double cos_max_angle_;
};

template <CameraModel M>
ALIDADE_ALWAYS_INLINE void unprojectGroups(const UnprojectLoop<M>& loop, const UnprojectArrays& a,
                                           std::size_t count) {
  // Copies that nobody else can write to: what depends on the parameters alone is computed once.
  const UnprojectLoop<M> local = loop;
  const UnprojectArrays arrays = a;
  for (std::size_t i = 0; i < count; i += kNumLanes) local.group(arrays, i);
}

#if defined(ALIDADE_HAS_AVX2_VARIANT)
template <CameraModel M>
ALIDADE_TARGET_AVX2 void unprojectGroupsAvx2(const UnprojectLoop<M>& loop, const UnprojectArrays& a,
                                             std::size_t count) {
  unprojectGroups(loop, a, count);
}
#endif

// `count` is a multiple of the number of lanes.
template <CameraModel M>
void unprojectWhole(const UnprojectLoop<M>& loop, const UnprojectArrays& a, std::size_t count) {
#if defined(ALIDADE_HAS_AVX2_VARIANT)
  if (batch::usesAvx2()) return unprojectGroupsAvx2(loop, a, count);
#endif
  unprojectGroups(loop, a, count);
}

template <CameraModel M>
void unprojectArrays(const Camera<M>& camera, const UnprojectArrays& a, std::size_t count) {
  const UnprojectLoop<M> loop(camera);
  const std::size_t whole = count - count % kNumLanes;
  unprojectWhole(loop, a, whole);
  const std::size_t rest = count - whole;
  if (rest == 0) return;
  const batch::Padded<double> u(a.u + whole, rest, batch::kNaN);
  const batch::Padded<double> v(a.v + whole, rest, batch::kNaN);
  double x[kNumLanes];
  double y[kNumLanes];
  double z[kNumLanes];
  ProjectStatus status[kNumLanes];
  std::array<double, 6 * kNumLanes> J{};
  unprojectWhole(loop,
                 {.u = u.data(),
                  .v = v.data(),
                  .x = x,
                  .y = y,
                  .z = z,
                  .status = status,
                  .J_ray_pixel = a.J_ray_pixel != nullptr ? J.data() : nullptr},
                 kNumLanes);
  std::copy_n(x, rest, a.x + whole);
  std::copy_n(y, rest, a.y + whole);
  std::copy_n(z, rest, a.z + whole);
  std::copy_n(status, rest, a.status + whole);
  if (a.J_ray_pixel != nullptr) std::copy_n(J.data(), 6 * rest, a.J_ray_pixel + 6 * whole);
}

}  // namespace

void unprojectBatch(const AnyCamera& camera, const PixelColumns& pixels, const RayResults& rays,
                    double* J_ray_pixel) {
  const std::size_t count = pixels.u.size();
  expect(pixels.v.size() == count && rays.x.size() == count && rays.y.size() == count &&
             rays.z.size() == count && rays.status.size() == count,
         "the arrays of a batch have one length");
  camera.visit([&](const auto& c) {
    unprojectArrays(c,
                    {.u = pixels.u.data(),
                     .v = pixels.v.data(),
                     .x = rays.x.data(),
                     .y = rays.y.data(),
                     .z = rays.z.data(),
                     .status = rays.status.data(),
                     .J_ray_pixel = J_ray_pixel},
                    count);
  });
}

}  // namespace alidade
