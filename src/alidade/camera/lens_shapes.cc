// SPDX-License-Identifier: MIT
#include "alidade/camera/lens_shapes.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <limits>
#include <utility>

#include <Eigen/QR>

#include "alidade/camera/model_traits.h"
#include "alidade/camera/same_lens.h"
#include "alidade/core/error.h"
#include "alidade/geometry/decompositions.h"
#include "alidade/geometry/least_squares.h"

namespace alidade {
namespace {

// The ranges of all parameters.
std::vector<ParamRange> rangesOf(const ModelTraits& model) {
  constexpr ParamRange kPositive = {.min = std::numeric_limits<double>::min()};
  std::vector<ParamRange> ranges = {kPositive, kPositive, {}, {}};
  ranges.insert(ranges.end(), model.lens_ranges.begin(), model.lens_ranges.end());
  return ranges;
}

double clamped(double value, const ParamRange& range) {
  return std::clamp(value, range.min, range.max);
}

double widthOf(const ParamRange& range) {
  return std::isfinite(range.max) ? range.max - range.min : 4.0;
}

bool isFinite(const double* px) {
  return std::isfinite(px[0]) && std::isfinite(px[1]);
}

// A camera of a lens with this focal length in pixels per radian on the axis, which it sees at `axis_px`;
// nothing if the lens has no such camera.
std::optional<std::vector<double>> startWith(const ModelTraits& model, std::span<const double> lens,
                                             const Eigen::Vector2d& focal_px,
                                             const Eigen::Vector2d& axis_px) {
  std::vector<double> params = {1, 1, 0, 0};
  for (std::size_t i = 0; i < lens.size(); ++i) params.push_back(clamped(lens[i], model.lens_ranges[i]));
  const double axis[3] = {0, 0, 1};
  double px[2];
  double J[6];
  if (!model.project(params.data(), axis, px, J, nullptr)) return std::nullopt;
  const double focal[2] = {focal_px.x() / J[0], focal_px.y() / J[4]};
  if (!isFinite(focal) || !(focal[0] > 0 && focal[1] > 0)) return std::nullopt;
  std::copy_n(focal, 2, params.begin());
  std::copy_n(axis_px.data(), 2, params.begin() + 2);
  return params;
}

double costOf(const ModelTraits& model, const std::vector<RaySample>& samples,
              const std::vector<double>& params) {
  constexpr double kLostPx = 1e4;  // stands for "no value": worse than any residual of a useful fit
  double sum = 0;
  for (const RaySample& sample : samples) {
    double px[2];
    const bool has_value =
        model.project(params.data(), sample.ray.data(), px, nullptr, nullptr) && isFinite(px);
    sum += has_value ? (Eigen::Vector2d(px[0], px[1]) - sample.pixel).squaredNorm() : kLostPx * kLostPx;
  }
  return sum;
}

// The least-squares problem linearised at a point: a step d has the cost |R d + z|^2 plus a constant.
struct Linearisation {
  Eigen::MatrixXd R;
  Eigen::VectorXd z;
};

Linearisation linearise(const ModelTraits& model, const std::vector<RaySample>& samples,
                        const std::vector<double>& params) {
  const auto n = static_cast<Eigen::Index>(params.size());
  const auto num_rows = 2 * static_cast<Eigen::Index>(samples.size());
  // At least n + 1 rows, so that the triangle below is complete.
  Eigen::MatrixXd J_and_r = Eigen::MatrixXd::Zero(std::max(num_rows, n + 1), n + 1);
  Eigen::Matrix<double, 2, Eigen::Dynamic, Eigen::RowMajor> J(2, n);
  for (std::size_t i = 0; i < samples.size(); ++i) {
    double px[2];
    if (!model.project(params.data(), samples[i].ray.data(), px, nullptr, J.data())) continue;
    if (!isFinite(px) || !J.allFinite()) continue;
    const auto row = 2 * static_cast<Eigen::Index>(i);
    J_and_r.middleRows(row, 2).leftCols(n) = J;
    J_and_r.col(n).segment(row, 2) = Eigen::Vector2d(px[0], px[1]) - samples[i].pixel;
  }
  // An orthogonal factorisation, because high powers of the radius would ruin normal equations.
  const Eigen::HouseholderQR<Eigen::MatrixXd> qr(J_and_r);
  const Eigen::MatrixXd triangle = qr.matrixQR().topRows(n + 1).triangularView<Eigen::Upper>();
  return {.R = triangle.topLeftCorner(n, n), .z = triangle.col(n).head(n)};
}

// Minimises |R d + z|^2 + lambda |D d|^2 over the free components of d; the others are zero.
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
  return leastSquares(A, b);
}

// Variants of a lens that is a quotient of polynomials in r^2 (k1 k2 k3 over k4 k5 k6): both are multiplied
// by 1 + c r^2 up to the sixth power of r. This is nearly the same lens, but leads the solver along a
// different path.
std::vector<std::vector<double>> quotientLenses(std::string_view model_id, const std::vector<double>& plain) {
  const auto names = parameterNames(model_id);
  if (!parameterIndex(names, "k3") || !parameterIndex(names, "k6")) return {};
  std::vector<std::vector<double>> lenses;
  for (const double c : {0.5, 2.0, -0.3}) {
    std::vector<double> params = plain;
    const auto of = [&](std::string_view name) { return *parameterIndex(names, name); };
    params[of("k1")] += c;
    params[of("k2")] += c * plain[of("k1")];
    params[of("k3")] += c * plain[of("k2")];
    params[of("k4")] += c;
    lenses.push_back(std::move(params));
  }
  return lenses;
}

}  // namespace

Eigen::Vector2d axisFocal(const AnyCamera& camera) {
  double J_px_cam[6];
  const Eigen::Vector3d axis = Eigen::Vector3d::UnitZ();
  const bool is_seen = camera.project(axis, J_px_cam, nullptr).ok();
  return is_seen ? Eigen::Vector2d(J_px_cam[0], J_px_cam[4])
                 : Eigen::Vector2d(camera.parameters()[0], camera.parameters()[1]);
}

Eigen::MatrixXd axisFocalJacobian(const AnyCamera& camera) {
  constexpr double kStep = 1e-4;  // radians; numerical second derivatives are then accurate to 1e-8
  const auto num_params = static_cast<Eigen::Index>(camera.parameters().size());
  Eigen::Matrix<double, 2, Eigen::Dynamic, Eigen::RowMajor> ahead(2, num_params);
  Eigen::Matrix<double, 2, Eigen::Dynamic, Eigen::RowMajor> behind(2, num_params);
  Eigen::MatrixXd J = Eigen::MatrixXd::Identity(2, num_params);
  for (int axis = 0; axis < 2; ++axis) {
    const Eigen::Vector3d step = kStep * Eigen::Vector3d::Unit(axis);
    const bool is_seen = camera.project(Eigen::Vector3d::UnitZ() + step, nullptr, ahead.data()).ok() &&
                         camera.project(Eigen::Vector3d::UnitZ() - step, nullptr, behind.data()).ok();
    if (is_seen) J.row(axis) = (ahead.row(axis) - behind.row(axis)) / (2 * kStep);
  }
  return J;
}

std::vector<std::vector<double>> lensStarts(std::string_view model_id, const Eigen::Vector2d& focal_px,
                                            const Eigen::Vector2d& axis_px, std::span<const double> named) {
  const ModelTraits& model = modelTraits(model_id);
  const std::vector<double> own(model.start_lens.begin(), model.start_lens.end());
  std::vector<std::vector<double>> lenses = {own};
  if (named.size() == own.size()) lenses.emplace_back(named.begin(), named.end());
  for (std::size_t i = 0; i < own.size(); ++i) {
    const ParamRange& range = model.lens_ranges[i];
    if (!std::isfinite(range.min)) continue;
    for (const double share : {0.0, 0.25, 0.5, 0.75}) {
      lenses.push_back(own);
      lenses.back()[i] = range.min + share * widthOf(range);
    }
  }
  std::vector<std::vector<double>> starts;
  for (const std::vector<double>& lens : lenses) {
    if (auto start = startWith(model, lens, focal_px, axis_px)) starts.push_back(std::move(*start));
  }
  return starts;
}

std::vector<double> startParameters(std::string_view model_id, double focal_px, ImageSize size) {
  const Eigen::Vector2d center(0.5 * (size.width - 1), 0.5 * (size.height - 1));
  const auto starts = lensStarts(model_id, Eigen::Vector2d::Constant(focal_px), center, {});
  expect(!starts.empty(), "a focal length is positive");
  return starts.front();
}

LensFit fitLens(std::string_view model_id, const std::vector<RaySample>& samples, std::vector<double> start,
                std::span<const std::string_view> absent) {
  constexpr int kMaxIterations = 200;
  constexpr double kStillPx = 1e-11;   // RMS change of the pixels in the last step before convergence
  constexpr double kSmallGain = 1e-9;  // share of the cost
  constexpr int kMaxSmallGains = 6;    // largest number of small gains in a row
  const ModelTraits& model = modelTraits(model_id);
  std::vector<ParamRange> ranges = rangesOf(model);
  for (const std::string_view name : absent) {
    if (const auto i = parameterIndex(model.parameter_names, name)) ranges[*i] = {.min = 0, .max = 0};
  }
  const std::size_t n = start.size();
  for (std::size_t i = 0; i < n; ++i) start[i] = clamped(start[i], ranges[i]);
  LensFit fit{.params = std::move(start)};
  fit.cost = costOf(model, samples, fit.params);
  Eigen::VectorXd scale = Eigen::VectorXd::Zero(static_cast<Eigen::Index>(n));
  Linearisation at;
  std::vector<bool> is_free(n);
  const auto lineariseHere = [&] {
    ++fit.num_iterations;
    at = linearise(model, samples, fit.params);
    // The largest columns so far bound the steps of parameters without effect.
    scale = scale.cwiseMax(at.R.colwise().norm().transpose());
    const Eigen::VectorXd gradient = at.R.transpose() * at.z;
    for (std::size_t i = 0; i < n; ++i) {
      const double down = -gradient(static_cast<Eigen::Index>(i));
      const ParamRange& range = ranges[i];
      is_free[i] = scale(static_cast<Eigen::Index>(i)) > 0 && !(fit.params[i] <= range.min && down < 0) &&
                   !(fit.params[i] >= range.max && down > 0);
    }
  };
  lineariseHere();
  int num_small_gains = 0;
  const DampingRule rule{.start = 1e-4,
                         .raised = [](double lambda) { return 5 * lambda > 1e12 ? HUGE_VAL : 5 * lambda; },
                         .lowered = [](double lambda) { return std::max(lambda * 0.1, 1e-15); },
                         .max_steps = std::numeric_limits<int>::max()};
  minimise(rule, [&](double lambda) {
    const Eigen::VectorXd step = dampedStep(at, scale, lambda, is_free);
    if (!step.allFinite()) return StepResult::kFailed;
    if ((at.R * step).norm() <= kStillPx * std::sqrt(static_cast<double>(samples.size())))
      return StepResult::kConverged;
    std::vector<double> params = fit.params;
    for (std::size_t i = 0; i < n; ++i)
      params[i] = clamped(params[i] + step(static_cast<Eigen::Index>(i)), ranges[i]);
    const double cost = costOf(model, samples, params);
    if (!(cost < fit.cost)) return StepResult::kWorse;
    num_small_gains = fit.cost - cost < kSmallGain * fit.cost ? num_small_gains + 1 : 0;
    fit.params = std::move(params);
    fit.cost = cost;
    if (fit.num_iterations == kMaxIterations || num_small_gains == kMaxSmallGains)
      return StepResult::kConverged;
    lineariseHere();
    return StepResult::kBetter;
  });
  return fit;
}

LensFit bestLens(std::string_view model_id, const AnyCamera& like, const std::vector<RaySample>& samples,
                 std::span<const std::string_view> absent) {
  const std::vector<double> named = closestByName(like, model_id);
  const Eigen::Vector2d axis_px(like.parameters()[2], like.parameters()[3]);
  std::optional<LensFit> best;
  for (std::vector<double>& start :
       lensStarts(model_id, axisFocal(like), axis_px, std::span(named).subspan(kNumAffine))) {
    LensFit fit = fitLens(model_id, samples, std::move(start), absent);
    if (!best || fit.cost < best->cost) best = std::move(fit);
  }
  expect(best.has_value(), "every model can be started");
  return *best;
}

std::vector<LensShape> lensShapes(std::string_view model_id, const AnyCamera& like,
                                  std::span<const Eigen::Vector2d> pixels) {
  std::vector<RaySample> samples;
  for (const Eigen::Vector2d& pixel : pixels) {
    if (const auto ray = like.unproject(pixel)) samples.push_back({pixel, *ray});
  }
  const std::vector<double> best = bestLens(model_id, like, samples).params;
  std::vector<LensShape> shapes = {{.params = best}};
  const std::vector<double> named = closestByName(like, model_id);
  for (std::vector<double>& params : quotientLenses(model_id, named))
    shapes.push_back({.params = std::move(params)});

  // Other values of the lens's first parameter if it is a shape parameter beside others. Shape parameters
  // have a range; polynomial coefficients do not. A shape parameter alone has a single best value.
  const ModelTraits& model = modelTraits(model_id);
  if (model.lens_ranges.size() < 2 || !std::isfinite(model.lens_ranges[0].min)) return shapes;
  const ParamRange& range = model.lens_ranges[0];
  const Eigen::Vector2d axis_px(like.parameters()[2], like.parameters()[3]);
  for (const double share : {-0.3, -0.2, -0.1, -0.04, 0.04, 0.1, 0.2, 0.3}) {
    std::vector<double> lens(best.begin() + kNumAffine, best.end());
    lens[0] += share * widthOf(range);
    if (!(lens[0] >= range.min && lens[0] <= range.max)) continue;
    if (auto start = startWith(model, lens, axisFocal(like), axis_px))
      shapes.push_back({.params = std::move(*start), .character = static_cast<int>(kNumAffine)});
  }
  return shapes;
}

}  // namespace alidade
