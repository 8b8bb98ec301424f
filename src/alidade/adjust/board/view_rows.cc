// SPDX-License-Identifier: MIT
#include <algorithm>
#include <array>
#include <cstddef>

#include "alidade/adjust/board/view_equations.h"
#include "alidade/adjust/board/view_kernel.h"
#include "alidade/camera/centred_point.h"
#include "alidade/camera/entrance_pupil.h"
#include "alidade/camera/model_list.h"
#include "alidade/camera/projection.h"
#include "alidade/core/error.h"

namespace alidade {
namespace {

using detail::GroupLoss;

// Camera and pose in the form that the loops read.
template <CameraModel M>
struct ViewCamera {
  ViewCamera(const double* from, std::size_t num_of_pupil, const SE3& camera_from_board)
      : num_pupil(num_of_pupil) {
    std::copy_n(from, kNumParams<M>, params.data());
    std::copy_n(from + kNumParams<M>, num_pupil, pupil.data());
    Eigen::Map<Eigen::Matrix<double, 3, 3, Eigen::RowMajor>>(R.data()) = camera_from_board.rotation.matrix();
    Eigen::Map<Eigen::Vector3d>(t.data()) = camera_from_board.translation;
  }
  std::array<double, static_cast<std::size_t>(kNumParams<M>)> params{};
  std::array<double, EntrancePupil::kSize> pupil{};
  std::size_t num_pupil;
  std::array<double, 9> R{};
  std::array<double, 3> t{};
};

// Pixels of a group's corners, and whether they project.
struct GroupProjection {
  Lanes px[2];
  Lanes J_px_cam[6];
  Lanes J_px_pupil[2 * EntrancePupil::kSize];
  LaneMask is_seen;
};

// Derivatives by points on rays of the pupil, from those by the moved points.
ALIDADE_ALWAYS_INLINE void applyPupil(const detail::CentredPoint<Lanes>& moved, GroupProjection& to) {
  const Lanes by_s1 = moved.byS1();
  for (std::size_t axis = 0; axis < 2; ++axis) {
    Lanes* const J_pupil = to.J_px_pupil + EntrancePupil::kSize * axis;
    J_pupil[0] = to.J_px_cam[3 * axis + 2] * by_s1;
    J_pupil[1] = J_pupil[0] * moved.angle2;
  }
  moved.apply(to.J_px_cam);
  to.is_seen = lane::both(to.is_seen, moved.certainty > moved.kLeast);
}

// @tparam kHasPupil  false: without its instructions, which would change the rounding of the others
template <bool kHasParams, bool kHasPupil, CameraModel M>
ALIDADE_ALWAYS_INLINE GroupProjection projectGroup(const ViewCamera<M>& camera, const CornerGroup& group,
                                                   Lanes* J_px_params) {
  const Lanes p[3] = {lane::load(group.x.data()), lane::load(group.y.data()), lane::load(group.z.data())};
  const auto& R = camera.R;
  Lanes p_cam[3];
  for (std::size_t r = 0; r < 3; ++r)
    p_cam[r] = R[3 * r] * p[0] + (R[3 * r + 1] * p[1] + (R[3 * r + 2] * p[2] + camera.t[r]));
  GroupProjection to;
  detail::CentredPoint<Lanes> moved;
  if constexpr (kHasPupil) {
    moved = detail::centredPoint(camera.pupil[0], camera.pupil[1], p_cam);
    p_cam[2] = moved.z;
  }
  Lanes* const not_wanted = nullptr;
  projectInside<M>(camera.params.data(), p_cam, to.px, to.J_px_cam, kHasParams ? J_px_params : not_wanted);
  // Sign of the Jacobian's determinant on the unit sphere, as in the domain certificate.
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
  if constexpr (kHasPupil) applyPupil(moved, to);
  return to;
}

template <bool kHasParams, CameraModel M>
ALIDADE_ALWAYS_INLINE GroupProjection projected(const ViewCamera<M>& camera, const CornerGroup& group,
                                                Lanes* J_px_params) {
  if (camera.num_pupil == 0) return projectGroup<kHasParams, false>(camera, group, J_px_params);
  return projectGroup<kHasParams, true>(camera, group, J_px_params);
}

template <CameraModel M>
class KernelOf final : public ViewKernel {
 public:
  explicit KernelOf(std::size_t num_pupil)
      : num_pupil_(num_pupil), layout_(static_cast<std::size_t>(kLens) + num_pupil) {}

  [[nodiscard]] const RowLayout& layout() const override { return layout_; }

  bool write(const double* params, const SE3& camera_from_board, std::span<const CornerGroup> groups,
             HuberLoss loss, Lanes* rows, Lanes& sum_rho) const override {
    const ViewCamera<M> camera(params, num_pupil_, camera_from_board);
    bool is_seen = true;
    const std::size_t width = layout_.width;
    callVectorised([&]() ALIDADE_INLINE_LAMBDA {
      const ViewCamera<M> local = camera;
      Lanes rho = sum_rho;
      Lanes* row = rows;
      for (const CornerGroup& group : groups) {
        if (!writeGroup(local, group, loss, row, row + width, rho)) is_seen = false;
        row += 2 * width;
      }
      sum_rho = rho;
    });
    return is_seen;
  }

  void writeErrors(const double* params, const SE3& camera_from_board, std::span<const CornerGroup> groups,
                   Lanes* errors) const override {
    const ViewCamera<M> camera(params, num_pupil_, camera_from_board);
    callVectorised([&]() ALIDADE_INLINE_LAMBDA {
      const ViewCamera<M> local = camera;
      Lanes* to = errors;
      for (const CornerGroup& group : groups) {
        const GroupProjection at = projected<false>(local, group, nullptr);
        const Lanes nothing = lane::select(at.is_seen, Lanes{}, Lanes{} + lane::kNaN);
        *to++ = at.px[0] - lane::load(group.u.data()) + nothing;
        *to++ = at.px[1] - lane::load(group.v.data()) + nothing;
      }
    });
  }

 private:
  static constexpr int kLens = M::kNumLensParams;
  static_assert(RowLayout(static_cast<std::size_t>(kLens) + EntrancePupil::kSize).size <= kMaxColumns);
  static constexpr auto kPose = static_cast<int>(RowLayout::kPose);

  ALIDADE_ALWAYS_INLINE static bool writeGroup(const ViewCamera<M>& camera, const CornerGroup& group,
                                               HuberLoss loss, Lanes* u, Lanes* v, Lanes& sum_rho) {
    constexpr int kParams = kNumParams<M>;
    Lanes J_px_params[2 * kParams];
    const GroupProjection at = projected<true>(camera, group, J_px_params);
    const Lanes error[2] = {at.px[0] - lane::load(group.u.data()), at.px[1] - lane::load(group.v.data())};
    const GroupLoss of_loss(error, group, loss);
    const Lanes root = of_loss.root;
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
      row += kPose + kLens;
      for (std::size_t i = 0; i < camera.num_pupil; ++i)
        *row++ = root * at.J_px_pupil[EntrancePupil::kSize * static_cast<std::size_t>(axis) + i];
      row[0] = root * error[axis];
      row[1] = root * J[axis];
      row[2] = root;
    }
    if (lane::isAll(at.is_seen)) {
      sum_rho += of_loss.rho;
      return true;
    }
    sum_rho += lane::select(at.is_seen, of_loss.rho, Lanes{});
    const std::ptrdiff_t width = v - u;
    for (std::ptrdiff_t i = 0; i < 2 * width; ++i) u[i] = lane::select(at.is_seen, u[i], Lanes{});
    return false;
  }

  std::size_t num_pupil_;
  RowLayout layout_;
};

}  // namespace

const ViewKernel& viewKernel(std::string_view model_id, std::size_t num_params) {
  const ViewKernel* kernel = nullptr;
  AllModels::forEach([&]<class M>() {
    static const std::array<KernelOf<M>, EntrancePupil::kSize + 1> of_model = {KernelOf<M>(0), KernelOf<M>(1),
                                                                               KernelOf<M>(2)};
    const std::size_t num_pupil = num_params - kNumParams<M>;
    if (M::kId == model_id && num_pupil < of_model.size()) kernel = &of_model[num_pupil];
  });
  expect(kernel != nullptr, "a known model with its number of parameters");
  return *kernel;
}

}  // namespace alidade
