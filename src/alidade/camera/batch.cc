// SPDX-License-Identifier: MIT
#include "alidade/camera/batch.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstring>
#include <numbers>
#include <utility>

#include <Eigen/Core>

#include "alidade/camera/camera_variant.h"
#include "alidade/camera/centred_point.h"
#include "alidade/camera/correction_field.h"
#include "alidade/camera/projection.h"
#include "alidade/core/error.h"
#include "alidade/core/lanes.h"

namespace alidade {
namespace {

// The arrays of one call. Null outputs are not computed. A stride is the step from one point's coordinate to
// the next point's: 1 in columns. In rows, the coordinates of a point are neighbours, and all arrays overlap
// the first one.
template <std::size_t kNumIn, std::size_t kNumOut>
struct Arrays {
  std::array<const double*, kNumIn> in;
  std::array<double*, kNumOut> out;
  ProjectStatus* status;
  std::size_t in_stride = 1;
  std::size_t out_stride = 1;  // of coordinates; Jacobians have no gaps
};

ALIDADE_ALWAYS_INLINE Lanes loadStrided(const double* from, std::size_t i, std::size_t stride) {
  if (stride == 1) return lane::load(from + i);
#if defined(ALIDADE_HAS_VECTORS)
  const double* const p = from + i * stride;
  return Lanes{p[0], p[stride], p[2 * stride], p[3 * stride]};
#else
  return from[i * stride];
#endif
}

ALIDADE_ALWAYS_INLINE void storeStrided(const Lanes& lanes, double* to, std::size_t i, std::size_t stride) {
  if (stride == 1) return lane::store(lanes, to + i);
#if defined(ALIDADE_HAS_VECTORS)
  for (std::size_t l = 0; l < kNumLanes; ++l) to[(i + l) * stride] = lanes[l];
#else
  to[i * stride] = lanes;
#endif
}

#if defined(ALIDADE_HAS_VECTORS)
// Loads two neighbours from each of two places. Processors move numbers faster within the halves of a vector
// than across them.
using LanePair = double __attribute__((vector_size(16)));

ALIDADE_ALWAYS_INLINE Lanes loadPairs(const double* low, const double* high) {
  LanePair l;
  LanePair h;
  std::memcpy(&l, low, sizeof l);
  std::memcpy(&h, high, sizeof h);
  return __builtin_shufflevector(l, h, 0, 1, 2, 3);
}
#endif

// In rows, x, y and z are neighbours, so six loads of two numbers replace twelve of one.
template <bool kIsRows>
ALIDADE_ALWAYS_INLINE void loadPoints(const std::array<const double*, 3>& from, std::size_t i, Lanes* p) {
#if defined(ALIDADE_HAS_VECTORS)
  if constexpr (kIsRows) {
    const double* const rows = from[0] + 3 * i;
    const Lanes a = loadPairs(rows, rows + 6);       // x0 y0 x2 y2
    const Lanes b = loadPairs(rows + 2, rows + 8);   // z0 x1 z2 x3
    const Lanes c = loadPairs(rows + 4, rows + 10);  // y1 z1 y3 z3
    p[0] = __builtin_shufflevector(a, b, 0, 5, 2, 7);
    p[1] = __builtin_shufflevector(a, c, 1, 4, 3, 6);
    p[2] = __builtin_shufflevector(b, c, 0, 5, 2, 7);
    return;
  }
#endif
  for (std::size_t c = 0; c < from.size(); ++c) p[c] = loadStrided(from[c], i, kIsRows ? from.size() : 1);
}

// In rows, u and v are neighbours, so two stores of four numbers replace eight of one.
template <bool kIsRows>
ALIDADE_ALWAYS_INLINE void storePixels(const Lanes& u, const Lanes& v, double* to_u, double* to_v,
                                       std::size_t i) {
#if defined(ALIDADE_HAS_VECTORS)
  if constexpr (kIsRows) {
    double* const rows = to_u + 2 * i;
    const Lanes even = __builtin_shufflevector(u, v, 0, 4, 2, 6);  // u0 v0 u2 v2
    const Lanes odd = __builtin_shufflevector(u, v, 1, 5, 3, 7);   // u1 v1 u3 v3
    lane::store(__builtin_shufflevector(even, odd, 0, 1, 4, 5), rows);
    lane::store(__builtin_shufflevector(even, odd, 2, 3, 6, 7), rows + kNumLanes);
    return;
  }
#endif
  storeStrided(u, to_u, i, kIsRows ? 2 : 1);
  storeStrided(v, to_v, i, kIsRows ? 2 : 1);
}

ALIDADE_ALWAYS_INLINE bool laneOf(const LaneMask& mask, std::size_t l) {
#if defined(ALIDADE_HAS_VECTORS)
  return mask[l] != 0;
#else
  return l == 0 && mask;
#endif
}

// Writes row-major Jacobians of kSize numbers, one lane after another, plus `nothing`: 0, or NaN in lanes
// without a result.
template <int kSize>
ALIDADE_ALWAYS_INLINE void scatter(const Lanes* from, const Lanes& nothing, double* to) {
  for (int e = 0; e < kSize; ++e) {
    double values[kNumLanes];
    lane::store(from[e] + nothing, values);
    for (std::size_t l = 0; l < kNumLanes; ++l) to[l * kSize + static_cast<std::size_t>(e)] = values[l];
  }
}

// `count` is a multiple of the number of lanes.
template <class Loop>
void runGroups(const Loop& loop, const typename Loop::Columns& arrays, std::size_t count) {
  callVectorised([&]() ALIDADE_INLINE_LAMBDA {
    // Local copies, so that values that depend only on the parameters are computed once.
    const Loop local = loop;
    const typename Loop::Columns a = arrays;
    const std::size_t end = count;
    if (a.in_stride == 1) {
      for (std::size_t i = 0; i < end; i += kNumLanes) local.template group<false>(a, i);
    } else {
      for (std::size_t i = 0; i < end; i += kNumLanes) local.template group<true>(a, i);
    }
  });
}

// Calls loop.group<kIsRows>(arrays, i) for each group of points. A last, incomplete group is copied to arrays
// of full length and back.
template <class Loop>
void runLoop(const Loop& loop, const typename Loop::Columns& arrays, std::size_t count) {
  const std::size_t whole = count - count % kNumLanes;
  runGroups(loop, arrays, whole);
  const std::size_t rest = count - whole;
  if (rest == 0) return;
  constexpr auto kWidths = Loop::kWidths;  // numbers per point in each output
  double in[std::tuple_size_v<decltype(arrays.in)>][kNumLanes];
  double out[kWidths.size()][kNumLanes * std::ranges::max(kWidths)];
  ProjectStatus status[kNumLanes];
  typename Loop::Columns padded = {.in = {}, .out = {}, .status = status};
  for (std::size_t c = 0; c < arrays.in.size(); ++c) {
    std::fill_n(in[c], kNumLanes, lane::kNaN);
    for (std::size_t l = 0; l < rest; ++l) in[c][l] = arrays.in[c][(whole + l) * arrays.in_stride];
    padded.in[c] = in[c];
  }
  for (std::size_t c = 0; c < kWidths.size(); ++c) padded.out[c] = arrays.out[c] ? out[c] : nullptr;
  runGroups(loop, padded, kNumLanes);
  for (std::size_t c = 0; c < kWidths.size(); ++c) {
    if (arrays.out[c] == nullptr) continue;
    const std::size_t stride = kWidths[c] == 1 ? arrays.out_stride : kWidths[c];
    for (std::size_t l = 0; l < rest; ++l)
      std::copy_n(out[c] + l * kWidths[c], kWidths[c], arrays.out[c] + (whole + l) * stride);
  }
  std::copy_n(status, rest, arrays.status + whole);
}

struct Pose {
  explicit Pose(const SE3& a_from_b) {
    Eigen::Map<Eigen::Matrix<double, 3, 3, Eigen::RowMajor>>(R.data()) = a_from_b.rotation.matrix();
    Eigen::Map<Eigen::Vector3d>(t.data()) = a_from_b.translation;
  }
  std::array<double, 9> R{};
  std::array<double, 3> t{};
};

template <CameraModel M, bool kHasPose, bool kHasJacobians>
class ProjectLoop {
 public:
  using Columns = Arrays<3, 5>;  // x, y, z; u, v and the Jacobians by point, pose and parameters
  static constexpr std::size_t kNumByParams = 2 * kNumParams<M>;
  static constexpr std::array<std::size_t, 5> kWidths = {1, 1, 6, 12, kNumByParams};

  ProjectLoop(const Camera<M>& camera, const EntrancePupil& pupil, const Pose& pose)
      : params_(camera.params()), pupil_(pupil), is_central_(pupil.isFixed()), pose_(pose) {
    const double c = std::cos(camera.cone().max_angle_rad);
    signed_cos2_ = c * std::abs(c);
  }

  template <bool kIsRows>
  ALIDADE_ALWAYS_INLINE void group(const Columns& a, std::size_t i) const {
    const auto [u, v, by_point_out, by_pose_out, by_params_out] = a.out;
    Lanes p[3];
    loadPoints<kIsRows>(a.in, i, p);
    Lanes p_cam[3] = {p[0], p[1], p[2]};
    const auto& R = pose_.R;
    if constexpr (kHasPose) {
      const auto& t = pose_.t;
      for (std::size_t r = 0; r < 3; ++r)
        p_cam[r] = R[3 * r] * p[0] + (R[3 * r + 1] * p[1] + (R[3 * r + 2] * p[2] + t[r]));
    }
    detail::CentredPoint<Lanes> moved;
    if (!is_central_) {
      moved = detail::centredPoint(pupil_.s1_m, pupil_.s2_m, p_cam);
      p_cam[2] = lane::select(moved.certainty > moved.kLeast, moved.z, Lanes{} + lane::kNaN);
    }
    // Same as Camera::classify(), but with squared lengths.
    const Lanes norm2 = p_cam[0] * p_cam[0] + p_cam[1] * p_cam[1] + p_cam[2] * p_cam[2];
    const Lanes z = p_cam[2];
    const Lanes signed_z2 = lane::select(z < 0.0, -z * z, z * z);
    const LaneMask is_point = lane::both(norm2 >= kMinLength2, norm2 <= kMaxLength2);
    LaneMask is_ok = lane::both(is_point, signed_z2 >= signed_cos2_ * norm2);
    const LaneMask is_behind = lane::both(is_point, z <= 0.0);
    constexpr bool kLooksForward = M::kMaxAngle <= std::numbers::pi / 2;
    if constexpr (kLooksForward) is_ok = lane::both(is_ok, z > 0.0);

    Lanes px[2];
    Lanes J_px_cam[6];
    Lanes J_px_params[kNumByParams];
    Lanes* const not_wanted = nullptr;
    projectInside<M>(params_.data(), p_cam, px, kHasJacobians ? J_px_cam : not_wanted,
                     kHasJacobians && by_params_out != nullptr ? J_px_params : not_wanted);
    // x - x is NaN for infinities too.
    const Lanes undefined = (px[0] - px[0]) + (px[1] - px[1]);
    is_ok = lane::both(is_ok, undefined == 0.0);
    const Lanes nothing = lane::select(is_ok, Lanes{}, Lanes{} + lane::kNaN);
    storePixels<kIsRows>(lane::select(is_ok, px[0], nothing), lane::select(is_ok, px[1], nothing), u, v, i);
    std::fill_n(a.status + i, kNumLanes, ProjectStatus::kOk);
    if (!lane::isAll(is_ok)) {
      for (std::size_t l = 0; l < kNumLanes; ++l) {
        if (laneOf(is_ok, l)) continue;
        a.status[i + l] =
            kLooksForward && laneOf(is_behind, l) ? ProjectStatus::kBehind : ProjectStatus::kOutsideDomain;
      }
    }
    if constexpr (kHasJacobians) {
      if (by_params_out != nullptr)
        scatter<kNumByParams>(J_px_params, nothing, by_params_out + i * kNumByParams);
      if (!is_central_) moved.apply(J_px_cam);
      Lanes by_point[6];
      for (std::size_t r = 0; r < 2; ++r) {
        const Lanes* row = J_px_cam + 3 * r;
        for (std::size_t c = 0; c < 3; ++c)
          by_point[3 * r + c] = row[0] * R[c] + row[1] * R[3 + c] + row[2] * R[6 + c];
      }
      if (by_point_out != nullptr) scatter<6>(by_point, nothing, by_point_out + i * 6);
      if (by_pose_out != nullptr) {
        Lanes by_pose[12];
        for (std::size_t r = 0; r < 2; ++r) {
          const Lanes* g = by_point + 3 * r;
          Lanes* to = by_pose + 6 * r;
          for (std::size_t c = 0; c < 3; ++c) to[c] = g[c];
          to[3] = p[1] * g[2] - p[2] * g[1];
          to[4] = p[2] * g[0] - p[0] * g[2];
          to[5] = p[0] * g[1] - p[1] * g[0];
        }
        scatter<12>(by_pose, nothing, by_pose_out + i * 12);
      }
    }
  }

 private:
  static constexpr double kMinLength2 = 1e-200;
  static constexpr double kMaxLength2 = 1e200;

  typename Camera<M>::Params params_;
  EntrancePupil pupil_;
  bool is_central_;
  Pose pose_;
  double signed_cos2_;
};

template <CameraModel M>
class UnprojectLoop {
 public:
  using Columns = Arrays<2, 4>;  // u, v; x, y, z and the Jacobian of the ray
  static constexpr std::array<std::size_t, 4> kWidths = {1, 1, 1, 6};

  explicit UnprojectLoop(const Camera<M>& camera)
      : camera_(camera),
        params_(camera.params()),
        start_(camera.start()),
        max_angle_(camera.cone().max_angle_rad),
        cos_max_angle_(std::cos(max_angle_)) {}

  template <bool kIsRows>
  ALIDADE_ALWAYS_INLINE void group(const Columns& a, std::size_t i) const {
    constexpr std::size_t kInStride = kIsRows ? 2 : 1;
    constexpr std::size_t kOutStride = kIsRows ? 3 : 1;
    const auto [x, y, z, J_ray_pixel] = a.out;
    const double* params = params_.data();
    const Lanes u = loadStrided(a.in[0], i, kInStride);
    const Lanes v = loadStrided(a.in[1], i, kInStride);
    const Lanes m[2] = {(u - params[2]) * (1 / params[0]), (v - params[3]) * (1 / params[1])};
    Lanes ray[3];
    M::quickUnlens(params + 4, start_, m, max_angle_, ray);
    const Lanes norm2 = ray[0] * ray[0] + ray[1] * ray[1] + ray[2] * ray[2];
    LaneMask is_ok = lane::both(norm2 > 0.5, ray[2] >= cos_max_angle_);
    if constexpr (M::kMaxAngle <= std::numbers::pi / 2) is_ok = lane::both(is_ok, ray[2] > 0.0);
    const Lanes nothing = lane::select(is_ok, Lanes{}, Lanes{} + lane::kNaN);
    storeStrided(ray[0] + nothing, x, i, kOutStride);
    storeStrided(ray[1] + nothing, y, i, kOutStride);
    storeStrided(ray[2] + nothing, z, i, kOutStride);
    std::fill_n(a.status + i, kNumLanes, ProjectStatus::kOk);
    if (!lane::isAll(is_ok)) {
      for (std::size_t l = 0; l < kNumLanes; ++l)
        if (!laneOf(is_ok, l)) tryHarder({u[l], v[l]}, a, i + l);
    }
    if (J_ray_pixel != nullptr) {
      const Lanes found[3] = {loadStrided(x, i, kOutStride), loadStrided(y, i, kOutStride),
                              loadStrided(z, i, kOutStride)};
      Lanes J[6];
      rayByPixel<M>(params, found, J);
      scatter<6>(J, 0.0 * found[0], J_ray_pixel + 6 * i);
    }
  }

 private:
  // Retries pixels at the rim, pixels for which Newton's method does not converge at once, and pixels without
  // a ray.
  void tryHarder(const Eigen::Vector2d& pixel, const Columns& a, std::size_t i) const {
    const auto ray = camera_.unproject(pixel);
    a.status[i] = ray ? ProjectStatus::kOk : ProjectStatus::kOutsideDomain;
    if (!ray) return;
    for (std::size_t c = 0; c < 3; ++c) a.out[c][i * a.out_stride] = (*ray)[static_cast<Eigen::Index>(c)];
  }

  const Camera<M>& camera_;
  typename Camera<M>::Params params_;
  typename M::Start start_;
  double max_angle_;
  double cos_max_angle_;
};

// Of four neighbouring control points.
struct SplineWeights {
  double of[4];
  ALIDADE_ALWAYS_INLINE explicit SplineWeights(double t) {
    const double s = 1 - t;
    constexpr double kSixth = 1.0 / 6;
    of[0] = kSixth * s * s * s;
    of[1] = kSixth * (4 + t * t * (3 * t - 6));
    of[2] = kSixth * (4 + s * s * (3 * s - 6));
    of[3] = kSixth * t * t * t;
  }
};

// Displaces the pixels of a model, and turns their Jacobians.
void displace(const CorrectionField& field, const Arrays<3, 5>& arrays, std::size_t num_params,
              std::size_t count) {
  const CorrectionGrid& grid = field.grid();
  const double* const points = field.points().data();
  const auto [u, v, by_point, by_pose, by_params] = arrays.out;
  const bool has_jacobians = by_point != nullptr || by_pose != nullptr || by_params != nullptr;
  const std::array<std::pair<double*, std::size_t>, 3> jacobians = {
      {{by_point, 3}, {by_pose, 6}, {by_params, num_params}}};
  const Eigen::Vector2d per_px = grid.cell_px.cwiseInverse();
  callVectorised([&]() ALIDADE_INLINE_LAMBDA {
    const std::size_t row_size = 2 * static_cast<std::size_t>(grid.pointsAcross());
    const double end_x = grid.columns;
    const double end_y = grid.rows;
    for (std::size_t i = 0; i < count; ++i) {
      double* const to[2] = {u + i * arrays.out_stride, v + i * arrays.out_stride};
      if (arrays.status[i] != ProjectStatus::kOk) continue;
      const double at_x = (*to[0] - grid.origin_px.x()) * per_px.x();
      const double at_y = (*to[1] - grid.origin_px.y()) * per_px.y();
      // Inside the grid, without derivatives: the four points along x as u, v, u, v.
      if (!has_jacobians && at_x >= 0 && at_y >= 0 && at_x < end_x && at_y < end_y) {
        const auto column = static_cast<std::size_t>(at_x);
        const auto row = static_cast<std::size_t>(at_y);
        const SplineWeights x(at_x - static_cast<double>(column));
        const SplineWeights y(at_y - static_cast<double>(row));
        const double* from = points + row * row_size + 2 * column;
        double sums[8];
        for (std::size_t k = 0; k < 8; ++k) sums[k] = y.of[0] * from[k];
        for (std::size_t j = 1; j < 4; ++j) {
          from += row_size;
          for (std::size_t k = 0; k < 8; ++k) sums[k] += y.of[j] * from[k];
        }
        *to[0] += (x.of[0] * sums[0] + x.of[1] * sums[2]) + (x.of[2] * sums[4] + x.of[3] * sums[6]);
        *to[1] += (x.of[0] * sums[1] + x.of[1] * sums[3]) + (x.of[2] * sums[5] + x.of[3] * sums[7]);
        continue;
      }
      if (!grid.has({*to[0], *to[1]})) {
        arrays.status[i] = ProjectStatus::kOutsideDomain;
        *to[0] = *to[1] = lane::kNaN;
        for (const auto& [J, width] : jacobians) {
          if (J != nullptr) std::fill_n(J + 2 * width * i, 2 * width, lane::kNaN);
        }
        continue;
      }
      const CorrectionGrid::Patch patch = grid.patchAt({*to[0], *to[1]});
      double sums[8] = {};  // over y, of the four points along x
      double by_y[8] = {};
      for (std::size_t j = 0; j < 4; ++j) {
        const double* const row = points + 2 * patch.first + j * row_size;
        for (std::size_t k = 0; k < 8; ++k) sums[k] += patch.y[j] * row[k];
        if (!has_jacobians) continue;
        for (std::size_t k = 0; k < 8; ++k) by_y[k] += patch.dy[j] * row[k];
      }
      double gradient[2][2] = {};
      for (std::size_t k = 0; k < 4; ++k) {
        for (std::size_t axis = 0; axis < 2; ++axis) {
          *to[axis] += patch.x[k] * sums[2 * k + axis];
          gradient[axis][0] += patch.dx[k] * sums[2 * k + axis];
          gradient[axis][1] += patch.x[k] * by_y[2 * k + axis];
        }
      }
      for (const auto& [J, width] : jacobians) {
        if (J == nullptr) continue;
        double* const of_u = J + 2 * width * i;
        double* const of_v = of_u + width;
        for (std::size_t c = 0; c < width; ++c) {
          const double du = of_u[c];
          const double dv = of_v[c];
          of_u[c] += gradient[0][0] * du + gradient[0][1] * dv;
          of_v[c] += gradient[1][0] * du + gradient[1][1] * dv;
        }
      }
    }
  });
}

void project(const AnyCamera& camera, const SE3* camera_from_points, const Arrays<3, 5>& arrays,
             std::size_t count) {
  const bool has_jacobians = arrays.out[2] != nullptr || arrays.out[3] != nullptr || arrays.out[4] != nullptr;
  const Pose pose(camera_from_points != nullptr ? *camera_from_points : SE3());
  const auto run = [&]<class M>(const Camera<M>& c) {
    if (has_jacobians) {
      runLoop(ProjectLoop<M, true, true>(c, camera.pupil(), pose), arrays, count);
    } else if (camera_from_points != nullptr) {
      runLoop(ProjectLoop<M, true, false>(c, camera.pupil(), pose), arrays, count);
    } else {
      runLoop(ProjectLoop<M, false, false>(c, camera.pupil(), pose), arrays, count);
    }
  };
  std::visit(run, camera.variant().camera);
  if (camera.correction() != nullptr)
    displace(*camera.correction(), arrays, camera.parameters().size(), count);
}

void unproject(const AnyCamera& camera, const Arrays<2, 4>& arrays, std::size_t count) {
  if (camera.correction() == nullptr) {
    std::visit([&](const auto& c) { runLoop(UnprojectLoop(c), arrays, count); }, camera.variant().camera);
    return;
  }
  for (std::size_t i = 0; i < count; ++i) {
    const Eigen::Vector2d pixel(arrays.in[0][i * arrays.in_stride], arrays.in[1][i * arrays.in_stride]);
    double* const J = arrays.out[3] == nullptr ? nullptr : arrays.out[3] + 6 * i;
    const auto ray = camera.unproject(pixel, J);
    arrays.status[i] = ray ? ProjectStatus::kOk : ProjectStatus::kOutsideDomain;
    if (!ray && J != nullptr) std::fill_n(J, 6, lane::kNaN);
    for (std::size_t c = 0; c < 3; ++c)
      arrays.out[c][i * arrays.out_stride] = ray ? (*ray)[static_cast<Eigen::Index>(c)] : lane::kNaN;
  }
}

void projectColumns(const AnyCamera& camera, const SE3* camera_from_points, const PointColumns& points,
                    const PixelResults& pixels, const PixelJacobians& jacobians) {
  const std::size_t count = points.x.size();
  expect(points.y.size() == count && points.z.size() == count && pixels.u.size() == count &&
             pixels.v.size() == count && pixels.status.size() == count,
         "the arrays of a batch have one length");
  project(
      camera, camera_from_points,
      {.in = {points.x.data(), points.y.data(), points.z.data()},
       .out = {pixels.u.data(), pixels.v.data(), jacobians.by_point, jacobians.by_pose, jacobians.by_params},
       .status = pixels.status.data()},
      count);
}

}  // namespace

void projectBatch(const AnyCamera& camera, const PointColumns& points_cam, const PixelResults& pixels,
                  const PixelJacobians& jacobians) {
  projectColumns(camera, nullptr, points_cam, pixels, jacobians);
}

void projectBatch(const AnyCamera& camera, const SE3& camera_from_points, const PointColumns& points,
                  const PixelResults& pixels, const PixelJacobians& jacobians) {
  projectColumns(camera, &camera_from_points, points, pixels, jacobians);
}

void unprojectBatch(const AnyCamera& camera, const PixelColumns& pixels, const RayResults& rays,
                    double* J_ray_pixel) {
  const std::size_t count = pixels.u.size();
  expect(pixels.v.size() == count && rays.x.size() == count && rays.y.size() == count &&
             rays.z.size() == count && rays.status.size() == count,
         "the arrays of a batch have one length");
  unproject(camera,
            {.in = {pixels.u.data(), pixels.v.data()},
             .out = {rays.x.data(), rays.y.data(), rays.z.data(), J_ray_pixel},
             .status = rays.status.data()},
            count);
}

void projectRows(const AnyCamera& camera, const SE3* camera_from_points, std::span<const double> points,
                 std::span<double> pixels, std::span<ProjectStatus> status, const PixelJacobians& jacobians) {
  const std::size_t count = status.size();
  expect(points.size() == 3 * count && pixels.size() == 2 * count, "the arrays of a batch have as many rows");
  project(
      camera, camera_from_points,
      {.in = {points.data(), points.data() + 1, points.data() + 2},
       .out = {pixels.data(), pixels.data() + 1, jacobians.by_point, jacobians.by_pose, jacobians.by_params},
       .status = status.data(),
       .in_stride = 3,
       .out_stride = 2},
      count);
}

void unprojectRows(const AnyCamera& camera, std::span<const double> pixels, std::span<double> rays,
                   std::span<ProjectStatus> status, double* J_ray_pixel) {
  const std::size_t count = status.size();
  expect(pixels.size() == 2 * count && rays.size() == 3 * count, "the arrays of a batch have as many rows");
  unproject(camera,
            {.in = {pixels.data(), pixels.data() + 1},
             .out = {rays.data(), rays.data() + 1, rays.data() + 2, J_ray_pixel},
             .status = status.data(),
             .in_stride = 2,
             .out_stride = 3},
            count);
}

void projectBatch(const AnyCamera& camera, std::span<const Eigen::Vector3d> points_cam,
                  std::span<Projection> out) {
  expect(points_cam.size() == out.size(), "one projection per point");
  constexpr std::size_t kChunk = 256;  // points; their numbers fit into the L1 cache
  std::array<double, 2 * kChunk> pixels;
  std::array<ProjectStatus, kChunk> status;
  for (std::size_t begin = 0; begin < points_cam.size(); begin += kChunk) {
    const std::size_t count = std::min(kChunk, points_cam.size() - begin);
    projectRows(camera, nullptr, {points_cam[begin].data(), 3 * count}, {pixels.data(), 2 * count},
                {status.data(), count});
    for (std::size_t i = 0; i < count; ++i)
      out[begin + i] = {.pixel = {pixels[2 * i], pixels[2 * i + 1]}, .status = status[i]};
  }
}

}  // namespace alidade
