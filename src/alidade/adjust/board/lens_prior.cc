// SPDX-License-Identifier: MIT
#include "alidade/adjust/board/lens_prior.h"

#include <cmath>

#include "alidade/camera/camera_model.h"
#include "alidade/camera/lens_shapes.h"

namespace alidade {
namespace {

// The largest shift of a pixel by each parameter, px per unit, on the way from the centre of the image to its
// corner.
Eigen::VectorXd largestShifts(const AnyCamera& camera, ImageSize size) {
  constexpr int kNumSteps = 16;
  const auto n = static_cast<Eigen::Index>(camera.parameters().size());
  const Eigen::Vector2d corner_px(size.width - 1, size.height - 1);
  Eigen::VectorXd largest = Eigen::VectorXd::Zero(n);
  Eigen::Matrix<double, 2, Eigen::Dynamic, Eigen::RowMajor> J(2, n);
  for (int i = 1; i <= kNumSteps; ++i) {
    const auto ray = camera.unproject(0.5 * (1 + static_cast<double>(i) / kNumSteps) * corner_px);
    if (!ray) break;
    if (camera.project(*ray, nullptr, J.data()).ok())
      largest = largest.cwiseMax(J.colwise().norm().transpose());
  }
  return largest;
}

}  // namespace

double LensPrior::cost(std::span<const double> params) const {
  double twice = 0;
  for (std::size_t i = 0; i < precision.size(); ++i) twice += precision[i] * std::pow(params[i] - mean[i], 2);
  return 0.5 * twice;
}

void LensPrior::addTo(std::span<const double> params, Eigen::MatrixXd& information, Eigen::VectorXd& gradient,
                      Eigen::Index first) const {
  for (std::size_t i = 0; i < precision.size(); ++i) {
    const Eigen::Index row = first + static_cast<Eigen::Index>(i);
    information(row, row) += precision[i];
    gradient(row) += precision[i] * (params[i] - mean[i]);
  }
}

LensPrior LensScale::prior(double width, double variance) const {
  LensPrior prior{.mean = mean, .precision = std::vector<double>(size.size())};
  for (std::size_t i = kNumAffine; i < size.size(); ++i)
    prior.precision[i] = variance / std::pow(width * size[i], 2);
  return prior;
}

double LensScale::distance(std::span<const double> params, std::size_t i) const {
  return i < kNumAffine ? 0.0 : std::abs(params[i] - mean[i]) / size[i];
}

LensScale lensScale(std::string_view model_id, const AnyCamera& like, ImageSize size) {
  const Eigen::Vector2d axis_px(0.5 * (size.width - 1), 0.5 * (size.height - 1));
  LensScale scale{.mean = lensStarts(model_id, axisFocal(like), axis_px, {}).front(), .size = {}};
  const Eigen::VectorXd shifts = largestShifts(AnyCamera::make(model_id, scale.mean), size);
  const double half_diagonal = 0.5 * std::hypot(size.width, size.height);
  scale.size.resize(scale.mean.size());
  for (std::size_t i = kNumAffine; i < scale.size.size(); ++i) {
    const double shift = shifts(static_cast<Eigen::Index>(i));
    scale.size[i] = shift > 0 ? half_diagonal / shift : 1.0;
  }
  return scale;
}

}  // namespace alidade
