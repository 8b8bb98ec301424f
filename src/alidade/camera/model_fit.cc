// SPDX-License-Identifier: MIT
#include "alidade/camera/model_fit.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <string>
#include <utility>
#include <vector>

#include "alidade/camera/lens_shapes.h"
#include "alidade/camera/same_lens.h"
#include "alidade/core/error.h"

namespace alidade {
namespace {

// Cells along the longer side: enough for the largest model in the fit, and to measure a share of 0.1 %
// afterwards.
constexpr int kFitCells = 40;
constexpr int kCheckCells = 160;
constexpr int kNumRimRays = 720;
// An algebraic result with a larger error is not an identical lens.
constexpr double kExactPx = 1e-6;

struct Samples {
  std::vector<RaySample> inside;  // the centres of equal cells
  std::vector<RaySample> border;  // on the outer edges and on the rim of the domain
  int num_without_ray = 0;        // number of pixels of `inside` without a ray
};

// Appends the rays at an angle from the axis whose pixels are inside the image.
void appendRim(const AnyCamera& camera, double angle, ImageSize size, std::vector<RaySample>& samples) {
  const double a = angle * (1 - 1e-9);  // inside despite rounding of the cosine
  for (int i = 0; i < kNumRimRays; ++i) {
    const double azimuth = 2 * std::numbers::pi * i / kNumRimRays;
    const Eigen::Vector3d ray(std::sin(a) * std::cos(azimuth), std::sin(a) * std::sin(azimuth), std::cos(a));
    const Projection rim = camera.project(ray);
    const bool is_inside = rim.ok() && std::abs(rim.pixel.x() - 0.5 * (size.width - 1)) <= 0.5 * size.width &&
                           std::abs(rim.pixel.y() - 0.5 * (size.height - 1)) <= 0.5 * size.height;
    if (is_inside) samples.push_back({rim.pixel, ray});
  }
}

Samples sampleRays(const AnyCamera& camera, ImageSize size, int num_cells) {
  Samples samples;
  const double cell = static_cast<double>(std::max(size.width, size.height)) / num_cells;
  const int nx = static_cast<int>(std::ceil(size.width / cell - 1e-9));
  const int ny = static_cast<int>(std::ceil(size.height / cell - 1e-9));
  const double step_x = static_cast<double>(size.width) / nx;
  const double step_y = static_cast<double>(size.height) / ny;
  for (int j = 0; j < ny; ++j) {
    for (int i = 0; i < nx; ++i) {
      const Eigen::Vector2d pixel((i + 0.5) * step_x - 0.5, (j + 0.5) * step_y - 0.5);
      if (const auto ray = camera.unproject(pixel)) {
        samples.inside.push_back({pixel, *ray});
      } else {
        ++samples.num_without_ray;
      }
    }
  }
  const auto look = [&](double u, double v) {
    const Eigen::Vector2d pixel(u, v);
    if (const auto ray = camera.unproject(pixel)) samples.border.push_back({pixel, *ray});
  };
  for (int i = 0; i <= nx; ++i) {
    look(i * step_x - 0.5, -0.5);
    look(i * step_x - 0.5, size.height - 0.5);
  }
  for (int j = 1; j < ny; ++j) {
    look(-0.5, j * step_y - 0.5);
    look(size.width - 0.5, j * step_y - 0.5);
  }
  appendRim(camera, camera.cone().max_angle_rad, size, samples.border);
  return samples;
}

ModelFit judge(const AnyCamera& source, AnyCamera camera, ImageSize size, const Samples& samples) {
  ModelFit fit{.camera = std::move(camera), .unreached_pixel = {}, .domain = {}};
  fit.num_without_ray = samples.num_without_ray;
  fit.num_pixels = static_cast<int>(samples.inside.size());
  double sum = 0;
  const auto error = [&fit](const RaySample& sample) -> std::optional<double> {
    const Projection projection = fit.camera.project(sample.ray);
    if (!projection.ok()) return std::nullopt;
    const double distance = (projection.pixel - sample.pixel).norm();
    if (distance > fit.max_error_px) {
      fit.max_error_px = distance;
      fit.worst_pixel = sample.pixel;
    }
    return distance;
  };
  for (const RaySample& sample : samples.inside) {
    if (const auto distance = error(sample)) {
      sum += *distance * *distance;
      continue;
    }
    ++fit.num_unreached;
    if (!fit.unreached_pixel) fit.unreached_pixel = sample.pixel;
  }
  // Errors are largest where one of the two cameras ends, which is between the centres of the cells.
  std::vector<RaySample> border = samples.border;
  appendRim(source, fit.camera.cone().max_angle_rad, size, border);
  for (const RaySample& sample : border) static_cast<void>(error(sample));
  const int num_reached = fit.num_pixels - fit.num_unreached;
  fit.rms_px = std::sqrt(sum / num_reached);  // NaN if num_reached is 0
  if (num_reached == 0) fit.max_error_px = fit.rms_px;
  fit.domain = certifyDomain(fit.camera, size);
  return fit;
}

}  // namespace

ModelFit fitModel(const AnyCamera& source, ImageSize size, std::string_view model_id,
                  std::span<const std::string_view> absent) {
  const auto num_params = parameterNames(model_id).size();
  const Samples samples = sampleRays(source, size, kCheckCells);
  if (samples.inside.size() <= num_params) {
    throw inputError(
        {.where = "camera of model " + std::string(source.modelId()),
         .found = "rays for " + std::to_string(samples.inside.size()) + " of " +
                  std::to_string(samples.num_without_ray + static_cast<int>(samples.inside.size())) +
                  " sampled pixels",
         .expected = "a camera that sees its image",
         .next_step = "run alidade validate for details"});
  }
  const auto made = [&](std::span<const double> values) {
    return AnyCamera::make(model_id, values).withPupil(source.pupil());
  };
  const auto params = sameLensParameters(source, model_id);
  const bool is_allowed = params && std::none_of(absent.begin(), absent.end(), [&](std::string_view name) {
                            const auto i = parameterIndex(parameterNames(model_id), name);
                            return i && (*params)[*i] != 0;
                          });
  if (is_allowed) {
    ModelFit fit = judge(source, made(*params), size, samples);
    fit.is_exact = !(fit.max_error_px > kExactPx);
    if (fit.is_exact) return fit;
  }
  const LensFit best = bestLens(model_id, source, sampleRays(source, size, kFitCells).inside, absent);
  return judge(source, made(best.params), size, samples);
}

}  // namespace alidade
