// SPDX-License-Identifier: MIT
#include "alidade/calibrate/lens_prior.h"

#include <algorithm>
#include <cmath>
#include <vector>

#include "alidade/camera/lens_fit.h"
#include "alidade/camera/lens_shapes.h"
#include "alidade/camera/model_list.h"

namespace alidade {
namespace {

constexpr auto kNumAffine = static_cast<Eigen::Index>(kAffineParamNames.size());

// The largest shift of a pixel by each parameter, px a unit, from the centre of the image to its corner.
Eigen::VectorXd largestShifts(const AnyCamera& camera, ImageSize size) {
  constexpr int kNumSteps = 16;
  const auto n = static_cast<Eigen::Index>(camera.parameters().size());
  const Eigen::Vector2d corner_px(size.width - 1, size.height - 1);
  Eigen::VectorXd largest = Eigen::VectorXd::Zero(n);
  Eigen::Matrix<double, 2, Eigen::Dynamic, Eigen::RowMajor> J(2, n);
  for (int i = 1; i <= kNumSteps; ++i) {
    const auto ray = camera.unproject(0.5 * (1 + static_cast<double>(i) / kNumSteps) * corner_px);
    if (!ray) break;
    const bool is_seen = camera.visit([&](const auto& c) { return c.project(*ray, nullptr, J.data()).ok(); });
    if (is_seen) largest = largest.cwiseMax(J.colwise().norm().transpose());
  }
  return largest;
}

}  // namespace

double LensPrior::cost(std::span<const double> params) const {
  if (isNone()) return 0;
  const Eigen::Map<const Eigen::VectorXd> p(params.data(), static_cast<Eigen::Index>(params.size()));
  return 0.5 * precision.dot((p - mean).cwiseAbs2());
}

void LensPrior::addTo(std::span<const double> params, Eigen::MatrixXd& equations) const {
  const Eigen::Index n = precision.size();
  for (Eigen::Index i = 0; i < n; ++i) {
    const double off = params[static_cast<std::size_t>(i)] - mean(i);
    equations(i, i) += precision(i);
    equations(n, i) += precision(i) * off;
    equations(n, n) += precision(i) * off * off;
  }
}

void LensPrior::addTo(std::span<const double> params, Eigen::MatrixXd& information,
                      Eigen::VectorXd& gradient) const {
  for (Eigen::Index i = 0; i < precision.size(); ++i) {
    information(i, i) += precision(i);
    gradient(i) += precision(i) * (params[static_cast<std::size_t>(i)] - mean(i));
  }
}

LensPrior LensScale::prior(double width, double variance) const {
  LensPrior prior{.mean = mean, .precision = Eigen::VectorXd::Zero(size.size())};
  for (Eigen::Index i = kNumAffine; i < size.size(); ++i)
    prior.precision(i) = variance / std::pow(width * size(i), 2);
  return prior;
}

double LensScale::distance(std::span<const double> params, Eigen::Index i) const {
  return i < kNumAffine ? 0.0 : std::abs(params[static_cast<std::size_t>(i)] - mean(i)) / size(i);
}

LensScale lensScale(std::string_view model_id, const AnyCamera& like, ImageSize size) {
  const Eigen::Vector2d axis_px(0.5 * (size.width - 1), 0.5 * (size.height - 1));
  const std::vector<double> plain = lensStarts(model_id, axisFocal(like), axis_px, {}).front();
  const Eigen::VectorXd shifts = largestShifts(AnyCamera::make(model_id, plain), size);
  const double half_diagonal = 0.5 * std::hypot(size.width, size.height);
  LensScale scale{.mean = Eigen::Map<const Eigen::VectorXd>(plain.data(), shifts.size()),
                  .size = Eigen::VectorXd::Zero(shifts.size())};
  for (Eigen::Index i = kNumAffine; i < shifts.size(); ++i)
    scale.size(i) = shifts(i) > 0 ? half_diagonal / shifts(i) : 1.0;
  return scale;
}

}  // namespace alidade
