// SPDX-License-Identifier: MIT
#include "alidade/adjust/board/view_kernel.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>

#include "alidade/adjust/board/disc_rows.h"
#include "alidade/adjust/board/elimination.h"
#include "alidade/adjust/board/view_equations.h"
#include "alidade/camera/model_list.h"
#include "alidade/core/error.h"
#include "alidade/core/lanes.h"

namespace alidade {
namespace {

using detail::ViewCamera;

template <CameraModel M>
class ModelKernel final : public ViewKernel {
 public:
  [[nodiscard]] int numParams() const override { return kParams; }

  [[nodiscard]] bool factor(const double* params, const SE3& camera_from_board,
                            std::span<const CornerGroup> corners, HuberLoss loss, Unseen unseen,
                            double* rows) const override {
    const ViewCamera<M> camera(params, camera_from_board);
    bool is_seen = true;
    callVectorised([&]() ALIDADE_INLINE_LAMBDA {
      detail::ViewEquations<M> equations;
      is_seen = detail::areDiscs(corners)
                    ? sumDiscs(params, camera_from_board, corners, loss, unseen, equations)
                    : detail::sumView<M>(camera, corners, loss, unseen, equations);
      if (!is_seen) return;
      constexpr std::size_t kLast = kSize - 1;
      std::array<double, kSize> diagonal;
      for (std::size_t i = 0; i < kSize; ++i) diagonal[i] = equations.at(i, i);
      equations.template eliminate<0, kPose>(diagonal, rows, kSize);
      for (std::size_t i = kPose; i < kLast; ++i) {
        for (std::size_t j = kPose; j < i; ++j) equations.at(i, j) = equations.at(j, i);
      }
      equations.template eliminate<kPose, kLast>(diagonal, rows + kPose * kSize, kSize);
      double* last = rows + kLast * kSize;
      std::fill_n(last, kLast, 0.0);
      // With the sum of rho in place of r^T r, this is what the other rows leave missing.
      last[kLast] = std::sqrt(std::max(equations.at(kLast, kLast), 0.0));
    });
    return is_seen;
  }

  [[nodiscard]] double sumOfRho(const double* params, const SE3& camera_from_board,
                                std::span<const CornerGroup> corners, HuberLoss loss) const override {
    if (detail::areDiscs(corners)) return sumOfDiscs(params, camera_from_board, corners, loss);
    const ViewCamera<M> camera(params, camera_from_board);
    double sum = 0;
    callVectorised([&]() ALIDADE_INLINE_LAMBDA {
      const ViewCamera<M> local = camera;
      Lanes rho = {};
      for (const CornerGroup& group : corners) {
        const detail::GroupProjection at = detail::projectGroup<false>(local, group, nullptr);
        const Lanes of_group = detail::GroupError(at, group, loss).rho;
        rho += lane::select(at.is_seen, of_group, Lanes{} + lane::kNaN);
      }
      sum = detail::sumOfLanes(rho);
    });
    return sum;
  }

  void errors(const double* params, const SE3& camera_from_board, std::span<const CornerGroup> corners,
              std::span<Eigen::Vector2d> errors) const override {
    if (detail::areDiscs(corners)) {
      const detail::DiscRows discs(*this, params, camera_from_board);
      for (std::size_t i = 0; i < errors.size(); ++i)
        errors[i] = discs.error(corners[i / kNumLanes], i % kNumLanes);
      return;
    }
    const ViewCamera<M> camera(params, camera_from_board);
    callVectorised([&]() ALIDADE_INLINE_LAMBDA {
      const ViewCamera<M> local = camera;
      std::size_t i = 0;
      for (const CornerGroup& group : corners) {
        const detail::GroupProjection at = detail::projectGroup<false>(local, group, nullptr);
        const Lanes nothing = lane::select(at.is_seen, Lanes{}, Lanes{} + lane::kNaN);
        double u[kNumLanes];
        double v[kNumLanes];
        lane::store(at.px[0] - lane::load(group.u.data()) + nothing, u);
        lane::store(at.px[1] - lane::load(group.v.data()) + nothing, v);
        for (std::size_t l = 0; l < kNumLanes && i < errors.size(); ++l, ++i) errors[i] = {u[l], v[l]};
      }
    });
  }

  void rows(const double* params, const SE3& camera_from_board, std::span<const CornerGroup> corners,
            std::span<double> rows) const override {
    if (detail::areDiscs(corners)) {
      const detail::DiscRows discs(*this, params, camera_from_board);
      for (std::size_t i = 0; i < rows.size() / (2 * kSize); ++i) {
        double* const to = rows.data() + 2 * i * kSize;
        const CornerGroup& group = corners[i / kNumLanes];
        discs.write(group, i % kNumLanes, to);
        for (std::size_t c = 0; c < 2 * kSize; ++c) to[c] *= group.root_weight[i % kNumLanes];
      }
      return;
    }
    const ViewCamera<M> camera(params, camera_from_board);
    std::fill(rows.begin(), rows.end(), 0.0);
    callVectorised([&]() ALIDADE_INLINE_LAMBDA {
      const ViewCamera<M> local = camera;
      std::size_t corner = 0;
      for (const CornerGroup& group : corners) {
        Lanes of[2][Rows::kWidth];
        Lanes rho = {};
        Rows::write(local, group, kNoLoss, of[0], of[1], rho);
        const std::size_t count = std::min<std::size_t>(kNumLanes, rows.size() / (2 * kSize) - corner);
        for (int axis = 0; axis < 2; ++axis) {
          for (int c = 0; c < Rows::kWidth; ++c) {
            double values[kNumLanes];
            lane::store(of[axis][c], values);
            double* to = rows.data() + (2 * corner + static_cast<std::size_t>(axis)) * kSize +
                         static_cast<std::size_t>(Rows::columnOf(axis, c));
            for (std::size_t l = 0; l < count; ++l) to[l * 2 * kSize] = values[l];
          }
        }
        corner += count;
      }
    });
  }

 private:
  using Rows = detail::ViewRows<M>;

  // As sumView() does it.
  bool sumDiscs(const double* params, const SE3& camera_from_board, std::span<const CornerGroup> corners,
                HuberLoss loss, Unseen unseen, detail::ViewEquations<M>& to) const {
    const detail::DiscRows discs(*this, params, camera_from_board);
    double sum_of_rho = 0;
    std::array<double, 2 * kSize> rows;
    for (const CornerGroup& group : corners) {
      for (std::size_t l = 0; l < kNumLanes; ++l) {
        if (group.root_weight[l] == 0) continue;  // fills up the group
        if (!discs.write(group, l, rows.data())) {
          if (unseen == Unseen::kRefuse) return false;
          continue;
        }
        const double weight = group.root_weight[l] * group.root_weight[l];
        const double u = rows[kSize - 1];
        const double v = rows[2 * kSize - 1];
        const double s = weight * (u * u + v * v);
        sum_of_rho += loss.rho(s);
        const double factor = weight * loss.weight(s);
        for (std::size_t i = 0; i < kSize; ++i) {
          for (std::size_t j = i; j < kSize; ++j)
            to.at(i, j) += factor * (rows[i] * rows[j] + rows[kSize + i] * rows[kSize + j]);
        }
      }
    }
    to.at(kSize - 1, kSize - 1) = sum_of_rho;
    for (std::size_t i = 0; i < kPose; ++i) {
      for (std::size_t j = 0; j < i; ++j) to.at(i, j) = to.at(j, i);
    }
    return true;
  }

  double sumOfDiscs(const double* params, const SE3& camera_from_board, std::span<const CornerGroup> corners,
                    HuberLoss loss) const {
    const detail::DiscRows discs(*this, params, camera_from_board);
    double sum = 0;
    for (const CornerGroup& group : corners) {
      for (std::size_t l = 0; l < kNumLanes; ++l) {
        if (group.root_weight[l] == 0) continue;
        const double weight = group.root_weight[l] * group.root_weight[l];
        sum += loss.rho(weight * discs.error(group, l).squaredNorm());
      }
    }
    return sum;
  }

  static constexpr int kParams = kNumParams<M>;
  static constexpr std::size_t kPose = Rows::kPose;
  static constexpr std::size_t kSize = Rows::kSize;
};

}  // namespace

const ViewKernel& viewKernel(std::string_view model_id) {
  const ViewKernel* kernel = nullptr;
  AllModels::forEach([&]<class M>() {
    static const ModelKernel<M> of_model;
    if (M::kId == model_id) kernel = &of_model;
  });
  expect(kernel != nullptr, "the model's id is known");
  return *kernel;
}

std::optional<ViewFactor> viewFactor(const ViewKernel& kernel, std::span<const double> params,
                                     const SE3& camera_from_board, std::span<const CornerGroup> corners,
                                     HuberLoss loss, Unseen unseen) {
  const Eigen::Index size = kernel.numParams() + 7;
  ViewFactor factor(size, size);
  if (!kernel.factor(params.data(), camera_from_board, corners, loss, unseen, factor.data()))
    return std::nullopt;
  return factor;
}

Eigen::MatrixXd paramsInformation(const ViewFactor& factor) {
  const Eigen::Index num_params = factor.cols() - 7;
  const auto rest = factor.block(6, 6, num_params, num_params);
  return rest.transpose() * rest;
}

}  // namespace alidade
