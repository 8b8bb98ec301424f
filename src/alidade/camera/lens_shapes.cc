// SPDX-License-Identifier: MIT
#include "alidade/camera/lens_shapes.h"

#include <algorithm>
#include <cmath>

#include "alidade/camera/lens_fit.h"
#include "alidade/camera/model_list.h"

namespace alidade {
namespace {

// Where a lens is a quotient of polynomials in r^2 (k1 k2 k3 over k4 k5 k6), both multiplied by 1 + c r^2 up
// to its sixth power: nearly the same lens, from which the solver takes another way.
std::vector<std::vector<double>> quotientLenses(std::string_view model_id, const std::vector<double>& plain) {
  const auto names = parameterNames(model_id);
  const auto k1 = parameterIndex(names, "k1");
  const auto k2 = parameterIndex(names, "k2");
  const auto k3 = parameterIndex(names, "k3");
  const auto k4 = parameterIndex(names, "k4");
  if (!k1 || !k2 || !k3 || !k4 || !parameterIndex(names, "k6")) return {};
  std::vector<std::vector<double>> lenses;
  for (const double c : {0.5, 2.0, -0.3}) {
    std::vector<double> params = plain;
    params[*k1] += c;
    params[*k2] += c * plain[*k1];
    params[*k3] += c * plain[*k2];
    params[*k4] += c;
    lenses.push_back(std::move(params));
  }
  return lenses;
}

// Other values worth trying for the lens' first parameter if it is a shape of its own beside others: those
// have a range, while coefficients of polynomials do not. A shape that is alone has one best value.
std::vector<double> otherCharacters(std::string_view model_id, double best) {
  std::vector<double> others;
  forEachModel(AllModels{}, [&](auto tag) {
    using M = typename decltype(tag)::Model;
    if constexpr (M::kNumLensParams > 1) {
      const ParamRange range = M::kLensRanges[0];
      if (M::kId != model_id || !std::isfinite(range.min)) return;
      const double width = std::isfinite(range.max) ? range.max - range.min : 4.0;
      for (const double share : {-0.3, -0.2, -0.1, -0.04, 0.04, 0.1, 0.2, 0.3}) {
        const double value = best + share * width;
        if (value >= range.min && value <= range.max) others.push_back(value);
      }
    }
  });
  return others;
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
  constexpr double kStep = 1e-4;  // radians; the models' own derivatives are differenced, to 1e-8
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

std::vector<double> parametersByName(std::string_view from_id, std::span<const double> params,
                                     std::string_view model_id) {
  const auto own = parameterNames(from_id);
  std::vector<double> named;
  for (const std::string_view name : parameterNames(model_id)) {
    const auto i = parameterIndex(own, name);
    named.push_back(i ? params[*i] : 0.0);
  }
  return named;
}

std::vector<LensShape> lensShapes(std::string_view model_id, const AnyCamera& like,
                                  std::span<const Eigen::Vector2d> pixels) {
  std::vector<RaySample> samples;
  for (const Eigen::Vector2d& pixel : pixels) {
    if (const auto ray = like.unproject(pixel)) samples.push_back({pixel, *ray});
  }
  const std::vector<double> named = parametersByName(like.modelId(), like.parameters(), model_id);
  const Eigen::Vector2d axis_px(like.parameters()[2], like.parameters()[3]);
  const std::vector<std::vector<double>> starts =
      lensStarts(model_id, axisFocal(like), axis_px, {named.begin() + 4, named.end()});

  std::vector<LensShape> shapes;
  std::optional<LensFit> best;
  for (const std::vector<double>& start : starts) {
    LensFit fit = fitLens(model_id, samples, start);
    if (!best || fit.cost < best->cost) best = std::move(fit);
  }
  if (best) shapes.push_back({.params = best->params});
  for (std::vector<double>& params : quotientLenses(model_id, named))
    shapes.push_back({.params = std::move(params)});
  if (!best) return shapes;
  const std::size_t first = kAffineParamNames.size();
  for (const double value :
       otherCharacters(model_id, best->params.size() > first ? best->params[first] : 0.0)) {
    std::vector<double> lens(best->params.begin() + static_cast<std::ptrdiff_t>(first), best->params.end());
    lens.front() = value;
    // The second start is the one with the lens that is named.
    const auto scaled = lensStarts(model_id, axisFocal(like), axis_px, lens);
    if (scaled.size() > 1) shapes.push_back({.params = scaled[1], .character = static_cast<int>(first)});
  }
  return shapes;
}

}  // namespace alidade
