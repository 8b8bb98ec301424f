// SPDX-License-Identifier: MIT
#include "alidade/simulate/footage_render.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <vector>

#include "alidade/camera/batch.h"
#include "alidade/core/parallel.h"
#include "alidade/core/random.h"
#include "alidade/simulate/render.h"
#include "alidade/simulate/surface_texture.h"

namespace alidade {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;

// The bodies at the times of all rows of the sensor that the picture shows.
class RowViews {
 public:
  RowViews(const FootageFrame& frame, ImageSize size) {
    if (!frame.hasRollingShutter()) {
      rows_.push_back(frame.viewsAt(frame.timeOfRow(0.5 * (size.height - 1))));
      return;
    }
    // Extends a little beyond the picture, for the blur.
    constexpr double kMarginPx = 50;
    double low = std::numeric_limits<double>::infinity();
    double high = -low;
    for (const double x : {-kMarginPx, size.width + kMarginPx}) {
      for (const double y : {-kMarginPx, size.height + kMarginPx}) {
        const Vector2d corner = frame.toSensor({x, y});
        if (!corner.allFinite()) continue;
        low = std::min(low, corner.y());
        high = std::max(high, corner.y());
      }
    }
    // Limited, because stabilisation moves rows by less than the image's height unless the camera turns too
    // far for a useful result.
    first_row_ = std::floor(std::max(low, -2.0 * size.height));
    const double last_row = std::ceil(std::min(high, 3.0 * size.height));
    for (double row = first_row_; row <= last_row; ++row)
      rows_.push_back(frame.viewsAt(frame.timeOfRow(row)));
  }

  [[nodiscard]] SurfaceHit cast(const std::vector<SceneBody>& bodies, double sensor_row,
                                const Vector3d& ray) const {
    if (rows_.size() == 1) return castRay(bodies, rows_.front(), rows_.front(), 0, ray);
    const double last = static_cast<double>(rows_.size() - 1);
    const double at = std::clamp(sensor_row - first_row_, 0.0, last);
    const double below = std::min(std::floor(at), last - 1);
    const auto i = static_cast<std::size_t>(below);
    return castRay(bodies, rows_[i], rows_[i + 1], at - below, ray);
  }

 private:
  double first_row_ = 0;
  std::vector<std::vector<BodyView>> rows_;
};

// Values for the rays of one row.
struct RowBuffers {
  std::vector<double> u, v, x, y, z;
  std::vector<ProjectStatus> status;
  std::vector<double> pixel_rad;  // angle that each pixel spans
  std::vector<double> light;

  explicit RowBuffers(std::size_t num)
      : u(num), v(num), x(num), y(num), z(num), status(num), pixel_rad(num), light(num) {}
};

// Light of rays half a pixel apart along both axes; the outermost ones lie beyond the picture by the extent
// of the blur.
class FineRows {
 public:
  FineRows(const FootageScene& scene, const std::vector<SceneBody>& bodies, const FootageFrame& frame)
      : size_(scene.image_size), bodies_(bodies), frame_(frame), views_(frame, size_) {
    constexpr double kNumSigmas = 4;
    const int half = static_cast<int>(std::ceil(2 * (0.5 + kNumSigmas * scene.effects.blur_px)));
    // Sample k covers [k / 2, (k + 1) / 2] pixels from the centre of a pixel.
    for (int k = -half; k < half; ++k)
      kernel_.push_back(pointSpreadShare(0.5 * (k + 1), scene.effects.blur_px) -
                        pointSpreadShare(0.5 * k, scene.effects.blur_px));
    double sum = 0;
    for (const double weight : kernel_) sum += weight;
    for (double& weight : kernel_) weight /= sum;
    margin_ = half - 1;
    for (const SceneBody& body : bodies) {
      for (std::uint32_t face = 0; face < kNumFaces; ++face)
        textures_.emplace_back(kNumFaces * body.seed + face);
    }
  }

  [[nodiscard]] const std::vector<double>& kernel() const { return kernel_; }
  [[nodiscard]] std::size_t numRows() const { return numFine(size_.height); }

  [[nodiscard]] RowBuffers makeBuffers() const { return RowBuffers(numFine(size_.width)); }

  // The light of a row of rays, blurred along the row and sampled at the pixels.
  void render(std::size_t fine_row, RowBuffers& row, float* out) const {
    const double v = coordinate(fine_row);
    for (std::size_t i = 0; i < row.u.size(); ++i) {
      const Vector2d sensor = frame_.toSensor({coordinate(i), v});
      row.u[i] = sensor.x();
      row.v[i] = sensor.y();
    }
    unprojectBatch(frame_.camera(), {row.u, row.v}, {row.x, row.y, row.z, row.status});
    measurePixels(row);
    for (std::size_t i = 0; i < row.u.size(); ++i)
      row.light[i] = row.status[i] == ProjectStatus::kOk ? lightOf(row, i) : 0;
    for (std::size_t x = 0; x < static_cast<std::size_t>(size_.width); ++x) {
      double sum = 0;
      for (std::size_t k = 0; k < kernel_.size(); ++k) sum += kernel_[k] * row.light[2 * x + k];
      out[x] = static_cast<float>(sum);
    }
  }

 private:
  static constexpr std::uint32_t kNumFaces = 6;
  static constexpr std::size_t kNodeStep = 16;  // samples

  [[nodiscard]] std::size_t numFine(int num_pixels) const {
    return 2 * (static_cast<std::size_t>(num_pixels) + static_cast<std::size_t>(margin_));
  }
  [[nodiscard]] double coordinate(std::size_t fine) const {
    return 0.5 * (static_cast<double>(fine) - margin_ + 0.5) - 0.5;
  }

  // Sets the longest side of each pixel's parallelogram of rays: exact at some nodes, and constant around
  // each.
  void measurePixels(RowBuffers& row) const {
    double last = 0;
    for (std::size_t i = 0; i < row.u.size(); ++i) {
      if (i % kNodeStep == 0) {
        const std::size_t node = std::min(i + kNodeStep / 2, row.u.size() - 1);
        Eigen::Matrix<double, 3, 2, Eigen::RowMajor> J_ray_pixel;
        if (row.status[node] == ProjectStatus::kOk &&
            frame_.camera().unproject({row.u[node], row.v[node]}, J_ray_pixel.data()).has_value() &&
            J_ray_pixel.allFinite()) {
          last = J_ray_pixel.colwise().norm().maxCoeff();
        }
      }
      row.pixel_rad[i] = last;
    }
  }

  [[nodiscard]] double lightOf(const RowBuffers& row, std::size_t i) const {
    const SurfaceHit hit = views_.cast(bodies_, row.v[i], {row.x[i], row.y[i], row.z[i]});
    constexpr double kMiddleLevel = 128;
    if (hit.body < 0) return kMiddleLevel;
    constexpr double kLeastPixelRad = 1e-9;
    constexpr double kLeastCosine = 1e-3;
    // On a slanted surface, rays are dense enough along the foreshortened direction.
    constexpr double kRaysPerPixel = 2;
    const auto body = static_cast<std::size_t>(hit.body);
    const double scale = 1 / bodies_[body].texture_scale;
    const double footprint = hit.distance_m * std::max(row.pixel_rad[i], kLeastPixelRad) /
                             std::clamp(kRaysPerPixel * hit.cos_incidence, kLeastCosine, 1.0);
    const SurfaceTexture& texture = textures_[kNumFaces * body + static_cast<std::size_t>(hit.face)];
    return texture.levelAt(scale * hit.on_face, scale * footprint);
  }

  ImageSize size_;
  const std::vector<SceneBody>& bodies_;
  const FootageFrame& frame_;
  RowViews views_;
  std::vector<double> kernel_;
  int margin_ = 0;  // samples beyond the picture on each side
  std::vector<SurfaceTexture> textures_;
};

std::uint8_t noisyLevel(double light, double sigma, Random& random) {
  constexpr double kMaxLevel = 255;
  if (sigma > 0) light += sigma * random.normal();
  return static_cast<std::uint8_t>(std::lround(std::clamp(light, 0.0, kMaxLevel)));
}

}  // namespace

GrayImage renderFootageFrame(const FootageScene& scene, const std::vector<SceneBody>& bodies,
                             const FootageFrame& frame, std::uint64_t noise_seed, const CancelFlag* cancel) {
  const FineRows rows(scene, bodies, frame);
  const auto width = static_cast<std::size_t>(scene.image_size.width);
  const auto height = static_cast<std::size_t>(scene.image_size.height);
  std::vector<float> light(rows.numRows() * width);
  // Threads take several rows at a time, so that buffers are allocated less often.
  constexpr std::size_t kRowsAtOnce = 16;
  const auto inPieces = [&](std::size_t num_rows, const auto& work) {
    parallelFor(
        (num_rows + kRowsAtOnce - 1) / kRowsAtOnce, scene.num_jobs,
        [&](std::size_t piece) { work(piece * kRowsAtOnce, std::min(num_rows, (piece + 1) * kRowsAtOnce)); },
        cancel);
  };
  inPieces(rows.numRows(), [&](std::size_t first, std::size_t end) {
    RowBuffers buffers = rows.makeBuffers();
    for (std::size_t row = first; row < end; ++row) rows.render(row, buffers, light.data() + row * width);
  });
  GrayImage image{scene.image_size, std::vector<std::uint8_t>(width * height)};
  inPieces(height, [&](std::size_t first, std::size_t end) {
    std::vector<double> sums(width);
    for (std::size_t y = first; y < end; ++y) {
      std::ranges::fill(sums, 0);
      for (std::size_t k = 0; k < rows.kernel().size(); ++k) {
        const float* row = light.data() + (2 * y + k) * width;
        for (std::size_t x = 0; x < width; ++x) sums[x] += rows.kernel()[k] * row[x];
      }
      Random random(streamSeed(noise_seed, y));  // seeded by row, so that noise does not depend on the
                                                 // threads
      for (std::size_t x = 0; x < width; ++x)
        image.pixels[y * width + x] = noisyLevel(sums[x], scene.effects.read_noise, random);
    }
  });
  return image;
}

}  // namespace alidade
