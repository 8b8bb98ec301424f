// SPDX-License-Identifier: MIT
#include "alidade/camera/lens_fit.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <limits>

#include <Eigen/QR>

#include "alidade/camera/any_camera.h"
#include "alidade/camera/model_list.h"
#include "alidade/camera/projection.h"
#include "alidade/core/error.h"

namespace alidade {
namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();

// A residual that stands for "no value", pixels: worse than any that a useful fit has.
constexpr double kLostPx = 1e4;

struct Range {
  double min = -kInfinity;
  double max = kInfinity;
};

// What the fit needs of a model, without its type.
struct Formula {
  bool (*project)(const double* params, const double* ray, double* px, double* J_px_ray,
                  double* J_px_params) = nullptr;
  std::vector<Range> lens_ranges;
  std::vector<double> start_lens;
};

Formula formulaOf(std::string_view model_id) {
  Formula formula;
  forEachModel(AllModels{}, [&](auto tag) {
    using M = typename decltype(tag)::Model;
    if (M::kId != model_id) return;
    formula.project = &projectFormulaJacobian<M>;
    formula.start_lens.assign(M::kStartLens.begin(), M::kStartLens.end());
    formula.lens_ranges.resize(formula.start_lens.size());
    if constexpr (requires { M::kLensRanges; }) {
      for (std::size_t i = 0; i < formula.lens_ranges.size(); ++i)
        formula.lens_ranges[i] = {.min = M::kLensRanges[i].min, .max = M::kLensRanges[i].max};
    }
  });
  expect(formula.project != nullptr, "the id of a model");
  return formula;
}

// The least squares problem about one point: |R d + z|^2 plus a constant is the cost of a step d.
struct Linearisation {
  Eigen::MatrixXd R;
  Eigen::VectorXd z;
};

class Problem {
 public:
  Problem(std::string_view model_id, const std::vector<RaySample>& samples,
          std::span<const std::string_view> absent = {})
      : formula_(formulaOf(model_id)), samples_(samples) {
    const auto names = parameterNames(model_id).subspan(4);
    for (std::size_t i = 0; i < names.size(); ++i) {
      if (std::find(absent.begin(), absent.end(), names[i]) != absent.end())
        formula_.lens_ranges[i] = {.min = 0, .max = 0};
    }
  }

  [[nodiscard]] double cost(const std::vector<double>& params) const {
    double sum = 0;
    for (const RaySample& sample : samples_) {
      double px[2];
      const bool has_value =
          formula_.project(params.data(), sample.ray.data(), px, nullptr, nullptr) && isFinite(px);
      sum += has_value ? (Eigen::Vector2d(px[0], px[1]) - sample.pixel).squaredNorm() : kLostPx * kLostPx;
    }
    return sum;
  }

  [[nodiscard]] Linearisation linearise(const std::vector<double>& params) const {
    const auto n = static_cast<Eigen::Index>(params.size());
    const auto num_rows = 2 * static_cast<Eigen::Index>(samples_.size());
    // At least n + 1 rows, so that the triangle below is whole.
    Eigen::MatrixXd J_and_r = Eigen::MatrixXd::Zero(std::max(num_rows, n + 1), n + 1);
    Eigen::Matrix<double, 2, Eigen::Dynamic, Eigen::RowMajor> J(2, n);
    for (std::size_t i = 0; i < samples_.size(); ++i) {
      double px[2];
      if (!formula_.project(params.data(), samples_[i].ray.data(), px, nullptr, J.data())) continue;
      if (!isFinite(px) || !J.allFinite()) continue;
      const auto row = 2 * static_cast<Eigen::Index>(i);
      J_and_r.middleRows(row, 2).leftCols(n) = J;
      J_and_r.col(n).segment(row, 2) = Eigen::Vector2d(px[0], px[1]) - samples_[i].pixel;
    }
    // An orthogonal factorisation, because high powers of the radius leave normal equations no digits.
    const Eigen::HouseholderQR<Eigen::MatrixXd> qr(J_and_r);
    const Eigen::MatrixXd triangle = qr.matrixQR().topRows(n + 1).triangularView<Eigen::Upper>();
    return {.R = triangle.topLeftCorner(n, n), .z = triangle.col(n).head(n)};
  }

  [[nodiscard]] Range range(std::size_t i) const {
    if (i < 2) return {.min = std::numeric_limits<double>::min(), .max = kInfinity};  // fx, fy
    return i < 4 ? Range{} : formula_.lens_ranges[i - 4];
  }

 private:
  static bool isFinite(const double* px) { return std::isfinite(px[0]) && std::isfinite(px[1]); }

  Formula formula_;
  const std::vector<RaySample>& samples_;
};

// Minimises |R d + z|^2 + lambda |D d|^2 over those d of which `is_free` says so; the others stay zero.
Eigen::VectorXd dampedStep(const Linearisation& at, const Eigen::VectorXd& scale, double lambda,
                           const std::vector<bool>& is_free) {
  const Eigen::Index n = at.R.cols();
  Eigen::MatrixXd A = Eigen::MatrixXd::Zero(2 * n, n);
  Eigen::VectorXd b = Eigen::VectorXd::Zero(2 * n);
  A.topRows(n) = at.R;
  b.head(n) = -at.z;
  for (Eigen::Index i = 0; i < n; ++i) {
    A(n + i, i) = std::sqrt(lambda) * scale(i);
    if (is_free[static_cast<std::size_t>(i)]) continue;
    A.col(i).setZero();
    A(n + i, i) = 1;
  }
  return A.colPivHouseholderQr().solve(b);
}

}  // namespace

std::vector<std::vector<double>> lensStarts(std::string_view model_id, const Eigen::Vector2d& focal_px,
                                            const Eigen::Vector2d& axis_px,
                                            const std::vector<double>& named) {
  const Formula formula = formulaOf(model_id);
  std::vector<std::vector<double>> lenses = {formula.start_lens};
  if (named.size() == formula.start_lens.size()) lenses.push_back(named);
  for (std::size_t i = 0; i < formula.lens_ranges.size(); ++i) {
    const Range& range = formula.lens_ranges[i];
    if (!std::isfinite(range.min)) continue;
    const double width = std::isfinite(range.max) ? range.max - range.min : 4.0;
    for (const double share : {0.0, 0.25, 0.5, 0.75}) {
      lenses.push_back(formula.start_lens);
      lenses.back()[i] = range.min + share * width;
    }
  }
  std::vector<std::vector<double>> starts;
  for (const std::vector<double>& lens : lenses) {
    std::vector<double> params = {1, 1, 0, 0};
    for (std::size_t i = 0; i < lens.size(); ++i)
      params.push_back(std::clamp(lens[i], formula.lens_ranges[i].min, formula.lens_ranges[i].max));
    const double axis[3] = {0, 0, 1};
    double px[2];
    double J[6];
    if (!formula.project(params.data(), axis, px, J, nullptr)) continue;
    params[0] = focal_px.x() / J[0];
    params[1] = focal_px.y() / J[4];
    params[2] = axis_px.x();
    params[3] = axis_px.y();
    const bool is_usable =
        std::isfinite(params[0]) && std::isfinite(params[1]) && params[0] > 0 && params[1] > 0;
    if (is_usable) starts.push_back(std::move(params));
  }
  return starts;
}

double lensCost(std::string_view model_id, const std::vector<RaySample>& samples,
                const std::vector<double>& params) {
  return Problem(model_id, samples).cost(params);
}

LensFit fitLens(std::string_view model_id, const std::vector<RaySample>& samples, std::vector<double> start,
                std::span<const std::string_view> absent) {
  constexpr int kMaxIterations = 200;
  constexpr double kMaxLambda = 1e12;
  constexpr double kStillPx = 1e-11;   // RMS by which a step moves the pixels when it has arrived
  constexpr double kSmallGain = 1e-9;  // of the cost,
  constexpr int kMaxSmallGains = 6;    // this often in a row
  const Problem problem(model_id, samples, absent);
  LensFit fit{.params = std::move(start)};
  for (std::size_t i = 0; i < fit.params.size(); ++i) {
    const Range range = problem.range(i);
    fit.params[i] = std::clamp(fit.params[i], range.min, range.max);
  }
  fit.cost = problem.cost(fit.params);
  const std::size_t n = fit.params.size();
  Eigen::VectorXd scale = Eigen::VectorXd::Zero(static_cast<Eigen::Index>(n));
  double lambda = 1e-4;
  int num_small_gains = 0;
  while (fit.num_iterations < kMaxIterations && num_small_gains < kMaxSmallGains) {
    ++fit.num_iterations;
    const Linearisation at = problem.linearise(fit.params);
    // The largest columns so far, which keeps the steps of parameters without effect bounded.
    scale = scale.cwiseMax(at.R.colwise().norm().transpose());
    const Eigen::VectorXd gradient = at.R.transpose() * at.z;
    std::vector<bool> is_free(n);
    for (std::size_t i = 0; i < n; ++i) {
      const double down = -gradient(static_cast<Eigen::Index>(i));
      const Range range = problem.range(i);
      is_free[i] = scale(static_cast<Eigen::Index>(i)) > 0 && !(fit.params[i] <= range.min && down < 0) &&
                   !(fit.params[i] >= range.max && down > 0);
    }
    bool has_moved = false;
    while (!has_moved && lambda <= kMaxLambda) {
      const Eigen::VectorXd step = dampedStep(at, scale, lambda, is_free);
      if (!step.allFinite()) break;
      if ((at.R * step).norm() <= kStillPx * std::sqrt(static_cast<double>(samples.size()))) break;
      std::vector<double> params = fit.params;
      for (std::size_t i = 0; i < n; ++i) {
        const Range range = problem.range(i);
        params[i] = std::clamp(params[i] + step(static_cast<Eigen::Index>(i)), range.min, range.max);
      }
      const double cost = problem.cost(params);
      if (cost < fit.cost) {
        num_small_gains = fit.cost - cost < kSmallGain * fit.cost ? num_small_gains + 1 : 0;
        fit.params = std::move(params);
        fit.cost = cost;
        lambda = std::max(lambda * 0.1, 1e-15);
        has_moved = true;
      } else {
        lambda *= 5;
      }
    }
    if (!has_moved) break;
  }
  return fit;
}

}  // namespace alidade
