// SPDX-License-Identifier: MIT
// The rows of Jacobian and error that corners give, several at a time; included by the source that holds the
// loops.
#pragma once

#include <algorithm>
#include <array>
#include <cstddef>

#include <Eigen/Core>

#include "alidade/adjust/board/corner_groups.h"
#include "alidade/camera/projection.h"
#include "alidade/geometry/se3.h"

namespace alidade::detail {

/// Camera and pose as the loops read them.
template <CameraModel M>
struct ViewCamera {
  ViewCamera(const double* from, const SE3& camera_from_board) {
    std::copy_n(from, kNumParams<M>, params.data());
    Eigen::Map<Eigen::Matrix<double, 3, 3, Eigen::RowMajor>>(R.data()) = camera_from_board.rotation.matrix();
    Eigen::Map<Eigen::Vector3d>(t.data()) = camera_from_board.translation;
  }
  std::array<double, static_cast<std::size_t>(kNumParams<M>)> params{};
  std::array<double, 9> R{};
  std::array<double, 3> t{};
};

/// Where a group's corners are seen, and whether they are: not behind the camera, beyond a pole, or where the
/// lens has folded.
struct GroupProjection {
  Lanes px[2];
  Lanes J_px_cam[6];
  LaneMask is_seen;
};

template <bool kHasParams, CameraModel M>
ALIDADE_ALWAYS_INLINE GroupProjection projectGroup(const ViewCamera<M>& camera, const CornerGroup& group,
                                                   Lanes* J_px_params) {
  const Lanes p[3] = {lane::load(group.x.data()), lane::load(group.y.data()), lane::load(group.z.data())};
  const auto& R = camera.R;
  Lanes p_cam[3];
  for (std::size_t r = 0; r < 3; ++r)
    p_cam[r] = R[3 * r] * p[0] + (R[3 * r + 1] * p[1] + (R[3 * r + 2] * p[2] + camera.t[r]));
  GroupProjection to;
  Lanes* const not_wanted = nullptr;
  projectInside<M>(camera.params.data(), p_cam, to.px, to.J_px_cam, kHasParams ? J_px_params : not_wanted);
  // Sign of the Jacobian on the unit sphere, as in the domain certificate.
  const Lanes* a = to.J_px_cam;
  const Lanes* b = to.J_px_cam + 3;
  const Lanes det = (a[1] * b[2] - a[2] * b[1]) * p_cam[0] + (a[2] * b[0] - a[0] * b[2]) * p_cam[1] +
                    (a[0] * b[1] - a[1] * b[0]) * p_cam[2];
  to.is_seen = det > 0.0;
  double rays[3][kNumLanes];
  for (std::size_t r = 0; r < 3; ++r) lane::store(p_cam[r], rays[r]);
  bool has_value[kNumLanes];
  bool has_all = true;
  for (std::size_t l = 0; l < kNumLanes; ++l) {
    const double ray[3] = {rays[0][l], rays[1][l], rays[2][l]};
    has_value[l] = M::hasValue(camera.params.data() + 4, ray);
    has_all = has_all && has_value[l];
  }
  if (!has_all) {
    double mask[kNumLanes];
    for (std::size_t l = 0; l < kNumLanes; ++l) mask[l] = has_value[l] ? 1.0 : 0.0;
    to.is_seen = lane::both(to.is_seen, lane::load(mask) > 0.0);
  }
  return to;
}

/// A group's errors, and what the loss makes of them.
struct GroupError {
  ALIDADE_ALWAYS_INLINE GroupError(const GroupProjection& at, const CornerGroup& group, HuberLoss loss)
      : px{at.px[0] - lane::load(group.u.data()), at.px[1] - lane::load(group.v.data())},
        root(lane::load(group.root_weight.data())) {
    const Lanes s = root * root * (px[0] * px[0] + px[1] * px[1]);
    rho = s;
    const double threshold = loss.threshold_px;
    const LaneMask is_far = s > threshold * threshold;
    if (!lane::isAny(is_far)) return;
    // HuberLoss, side by side.
    const Lanes length = lane::squareRoot(s);
    rho = lane::select(is_far, 2 * threshold * length - threshold * threshold, s);
    root = lane::select(is_far, root * lane::squareRoot(Lanes(threshold / length)), root);
  }
  Lanes px[2];
  Lanes root;  ///< of the weight, times that of the loss' weight
  Lanes rho;
};

/// The two rows of each corner, [J r] times the root of its weight. Most columns are in both rows: the pose
/// (its tangent: translation, rotation), the lens and, last of them, the error. Then follow a row's own, the
/// focal length and the centre of its axis; those of the other axis are zero in it. A parameter that
/// moves both coordinates of a pixel belongs among the shared columns.
template <CameraModel M>
struct ViewRows {
  static constexpr int kPose = 6;
  static constexpr int kLens = M::kNumLensParams;
  static constexpr int kShared = kPose + kLens + 1;
  static constexpr int kOwn = 2;
  static constexpr int kWidth = kShared + kOwn;
  static constexpr int kError = kShared - 1;
  static constexpr int kSize = kPose + kNumParams<M> + 1;  ///< columns of both axes: pose, parameters, error

  /// Column among all kSize of column c of a row of the axis u (0) or v (1).
  static constexpr int columnOf(int axis, int c) {
    if (c < kPose) return c;
    if (c < kPose + kLens) return c + 4;
    if (c == kError) return kSize - 1;
    return kPose + axis + (c == kShared ? 0 : 2);
  }

  /// Writes both rows of each corner of a group, also scaled by the root of the loss' weight, and adds its
  /// rho. Corners that are not seen get zeros; false if there are any.
  ALIDADE_ALWAYS_INLINE static bool write(const ViewCamera<M>& camera, const CornerGroup& group,
                                          HuberLoss loss, Lanes* u, Lanes* v, Lanes& sum_rho) {
    constexpr int kParams = kNumParams<M>;
    Lanes J_px_params[2 * kParams];
    const GroupProjection at = projectGroup<true>(camera, group, J_px_params);
    const GroupError error(at, group, loss);
    const Lanes root = error.root;
    const Lanes x = lane::load(group.x.data());
    const Lanes y = lane::load(group.y.data());
    const Lanes z = lane::load(group.z.data());
    const auto& R = camera.R;
    Lanes* const rows[2] = {u, v};
    for (int axis = 0; axis < 2; ++axis) {
      Lanes* row = rows[axis];
      const Lanes j[3] = {root * at.J_px_cam[3 * axis], root * at.J_px_cam[3 * axis + 1],
                          root * at.J_px_cam[3 * axis + 2]};
      // d p_cam / d translation = R, d p_cam / d rotation = -R hat(p_board).
      Lanes g[3];
      for (std::size_t c = 0; c < 3; ++c) g[c] = j[0] * R[c] + j[1] * R[3 + c] + j[2] * R[6 + c];
      row[0] = g[0];
      row[1] = g[1];
      row[2] = g[2];
      row[3] = y * g[2] - z * g[1];
      row[4] = z * g[0] - x * g[2];
      row[5] = x * g[1] - y * g[0];
      const Lanes* J = J_px_params + axis * kParams;
      for (int i = 0; i < kLens; ++i) row[kPose + i] = root * J[4 + i];
      row[kError] = root * error.px[axis];
      row[kShared] = root * J[axis];
      row[kShared + 1] = root;
    }
    if (lane::isAll(at.is_seen)) {
      sum_rho += error.rho;
      return true;
    }
    sum_rho += lane::select(at.is_seen, error.rho, Lanes{});
    for (int i = 0; i < kWidth; ++i) {
      u[i] = lane::select(at.is_seen, u[i], Lanes{});
      v[i] = lane::select(at.is_seen, v[i], Lanes{});
    }
    return false;
  }
};

}  // namespace alidade::detail
