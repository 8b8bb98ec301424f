// SPDX-License-Identifier: MIT
#include "alidade/calibrate/pose_elimination.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "alidade/calibrate/gram_tiles.h"
#include "alidade/calibrate/vector_call.h"
#include "alidade/camera/model_list.h"
#include "alidade/core/error.h"

namespace alidade {
namespace {

constexpr double kMinDiagonal = 1e-6;  // a pose that nothing is seen of stays where it is

template <int kParams>
class EliminationOf final : public PoseElimination {
 public:
  void eliminate(std::span<const double> equations, double damping, std::span<double> factors,
                 Eigen::MatrixXd& schur) const override {
    expect(equations.size() == factors.size() && equations.size() % kSize == 0, "whole views");
    alignas(Lanes) std::array<double, kNumShared * kSharedWidth> taken{};
    callVectorised([&]() ALIDADE_INLINE_LAMBDA {
      for (std::size_t at = 0; at < equations.size(); at += kSize) {
        double* factor = factors.data() + at;
        factorize(equations.data() + at, damping, factor);
        addProducts(factor, taken.data());
      }
    });
    for (std::size_t i = 0; i < kNumShared; ++i) {
      for (std::size_t j = i; j < kNumShared; ++j)
        schur(static_cast<Eigen::Index>(j), static_cast<Eigen::Index>(i)) -= taken[i * kSharedWidth + j];
    }
  }

  void step(std::span<const double> factors, double share, std::span<const double> params_step,
            std::span<const SE3> from, std::span<SE3> to) const override {
    expect(params_step.size() == kParams && factors.size() == from.size() * kSize && from.size() == to.size(),
           "whole views");
    alignas(Lanes) std::array<double, kSharedWidth> shared_step{};
    std::copy(params_step.begin(), params_step.end(), shared_step.begin());
    shared_step[kParams] = share;
    callVectorised([&]() ALIDADE_INLINE_LAMBDA {
      for (std::size_t v = 0; v < from.size(); ++v) {
        SE3::Vec6 xi;
        solve(factors.data() + v * kSize, shared_step.data(), xi.data());
        to[v] = from[v] * SE3::exp(xi);
      }
    });
  }

 private:
  using Layout = PoseRowLayout;
  static constexpr std::size_t kPose = Layout::kPose;
  static constexpr std::size_t kNumShared = kParams + 1;
  static constexpr std::size_t kStride = Layout::stride(kParams);
  static constexpr std::size_t kSize = Layout::size(kParams);
  static constexpr std::size_t kSharedWidth = kStride - Layout::kShared;

  // Of each row only what is right of the diagonal means something, from the group of lanes that it is in.
  ALIDADE_ALWAYS_INLINE static void factorize(const double* equations, double damping, double* factor) {
    std::copy_n(equations, kSize, factor);
    for (std::size_t k = 0; k < kPose; ++k) {
      double& diagonal = factor[k * kStride + k];
      diagonal += damping * std::max(diagonal, kMinDiagonal);
    }
    for (std::size_t k = 0; k < kPose; ++k) {
      double* row = factor + k * kStride;
      const double inverse = 1 / std::sqrt(row[k]);
      for (std::size_t j = k / kNumLanes * kNumLanes; j < kStride; j += kNumLanes)
        lane::store(lane::load(row + j) * inverse, row + j);
      for (std::size_t i = k + 1; i < kPose; ++i) {
        double* other = factor + i * kStride;
        const double f = row[i];
        for (std::size_t j = i / kNumLanes * kNumLanes; j < kStride; j += kNumLanes)
          lane::store(lane::load(other + j) - f * lane::load(row + j), other + j);
      }
    }
  }

  // Adds the products of the columns after the pose, the upper triangle.
  ALIDADE_ALWAYS_INLINE static void addProducts(const double* factor, double* sums) {
    for (std::size_t i = 0; i < kNumShared; ++i) {
      for (std::size_t j = i / kNumLanes * kNumLanes; j < kSharedWidth; j += kNumLanes) {
        Lanes sum = lane::load(sums + i * kSharedWidth + j);
        const double* row = factor + Layout::kShared;
        for (std::size_t k = 0; k < kPose; ++k, row += kStride) sum += row[i] * lane::load(row + j);
        lane::store(sum, sums + i * kSharedWidth + j);
      }
    }
  }

  // R xi = -(the other columns times the step).
  ALIDADE_ALWAYS_INLINE static void solve(const double* factor, const double* shared_step, double* xi) {
    for (std::size_t k = kPose; k-- > 0;) {
      const double* row = factor + k * kStride;
      Lanes products = {};
      for (std::size_t j = 0; j < kSharedWidth; j += kNumLanes)
        products += lane::load(row + Layout::kShared + j) * lane::load(shared_step + j);
      double sum = detail::sumOfLanes(products);
      for (std::size_t j = k + 1; j < kPose; ++j) sum += row[j] * xi[j];
      xi[k] = -sum / row[k];
    }
  }
};

}  // namespace

const PoseElimination& poseElimination(int num_params) {
  const PoseElimination* elimination = nullptr;
  forEachModel(AllModels{}, [&](auto tag) {
    constexpr int kParams = kNumParams<typename decltype(tag)::Model>;
    static const EliminationOf<kParams> of_size;
    if (kParams == num_params) elimination = &of_size;
  });
  expect(elimination != nullptr, "a model has as many parameters");
  return *elimination;
}

}  // namespace alidade
