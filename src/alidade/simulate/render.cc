// SPDX-License-Identifier: MIT
#include "alidade/simulate/render.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <numbers>
#include <utility>

#include "alidade/core/error.h"
#include "alidade/core/parallel.h"
#include "alidade/core/random.h"
#include "alidade/simulate/observe.h"

namespace alidade {
namespace {

constexpr double kMaxLevel = 255;

// The light of one board in one pose, in grey levels. `Pattern` gives the tone of a place and a lower bound
// of its distance to the nearest edge, in units of unit() metres.
template <class Pattern>
class BoardLight {
 public:
  BoardLight(Pattern pattern, const SE3& camera_from_board, const RenderOptions& options)
      : pattern_(std::move(pattern)),
        is_visible_(seesPrintedSide(camera_from_board)),
        spread_(makePointSpread(options.blur_px, options.samples)) {
    levels_[static_cast<std::size_t>(BoardTone::kDark)] = options.dark_level;
    levels_[static_cast<std::size_t>(BoardTone::kBright)] = options.bright_level;
    levels_[static_cast<std::size_t>(BoardTone::kBackground)] = options.background_level;

    // The ray from the camera centre c along d meets z = 0 at (c_x d_z - c_z d_x, c_y d_z - c_z d_y) / d_z,
    // which is in front of the camera if d_z > 0, since c_z < 0 on the printed side.
    const SE3 board_from_camera = camera_from_board.inverse();
    const Eigen::Vector3d c = board_from_camera.translation / pattern_.unit();
    Eigen::Matrix3d plane_from_ray;
    plane_from_ray << -c.z(), 0, c.x(),  //
        0, -c.z(), c.y(),                //
        0, 0, 1;
    plane_from_camera_ray_ = plane_from_ray * board_from_camera.rotation.matrix();
  }

  // Mean over the point spread around the pixel centre.
  [[nodiscard]] double at(const RayExpansion& pixel) const {
    if (!is_visible_) return level(BoardTone::kBackground);
    // Homogeneous coordinates on the board, in units of the pattern, as quadratic polynomials of the place in
    // the image.
    const Terms terms = plane_from_camera_ray_ * pixel.terms;
    if (isUniform(terms)) return level(toneAt(terms(0, 0), terms(1, 0), terms(2, 0)));

    std::array<int, 3> counts = {0, 0, 0};
    for (std::size_t i = 0; i < spread_.size(); ++i) {
      const double x = spread_.x[i];
      const double y = spread_.y[i];
      const auto place = [&](int row) {
        return terms(row, 0) + x * (terms(row, 1) + x * terms(row, 3) + y * terms(row, 4)) +
               y * (terms(row, 2) + y * terms(row, 5));
      };
      ++counts[static_cast<std::size_t>(toneAt(place(0), place(1), place(2)))];
    }
    double sum = 0;
    for (std::size_t tone = 0; tone < counts.size(); ++tone) sum += counts[tone] * levels_[tone];
    return sum / static_cast<double>(spread_.size());
  }

 private:
  using Terms = Eigen::Matrix<double, 3, 6>;

  [[nodiscard]] double level(BoardTone tone) const { return levels_[static_cast<std::size_t>(tone)]; }

  // The tone of a place on the board's plane in homogeneous coordinates, in units of the pattern.
  [[nodiscard]] BoardTone toneAt(double x, double y, double w) const {
    return w > 0 ? pattern_.tone({x / w, y / w}) : BoardTone::kBackground;
  }

  // True if no edge can be within the point spread. With the centre at p = X / w, a place at offset d is at p
  // + (dX - p dw) / (w + dw), which is bounded by the first derivatives and the smallest w within the spread.
  [[nodiscard]] bool isUniform(const Terms& terms) const {
    // Allows for the second order, which is smaller than the first by about the radius of the spread over the
    // focal length.
    constexpr double kSafety = 1.1;
    const double radius = kSafety * spread_.radius_px;
    const double w = terms(2, 0);
    const double change_of_w = radius * std::hypot(terms(2, 1), terms(2, 2));
    if (w + change_of_w <= 0) return true;
    if (w - change_of_w <= 0) return false;
    const Eigen::Vector2d p = terms.col(0).head<2>() / w;
    const Eigen::Matrix2d first = terms.block<2, 2>(0, 1) - p * terms.block<1, 2>(2, 1);
    return pattern_.edgeDistance(p) > radius * first.norm() / (w - change_of_w);
  }

  Pattern pattern_;
  bool is_visible_;
  PointSpread spread_;
  std::array<double, 3> levels_{};
  Eigen::Matrix3d plane_from_camera_ray_;
};

// Share of the light that reaches a pixel.
double shading(const RayExpansion& pixel, double x, ImageSize size, const RenderOptions& options) {
  double share = 1 - options.falloff * (x + 0.5) / size.width;
  if (options.vignetting_exponent > 0) {
    const Eigen::Vector3d ray = pixel.terms.col(0);
    share *= std::pow(std::max(0.0, ray.z() / ray.norm()), options.vignetting_exponent);
  }
  return share;
}

std::uint8_t withNoise(double light, const RenderOptions& options, Random& random) {
  double variance = options.read_noise * options.read_noise;
  if (options.full_well_electrons > 0) variance += light * kMaxLevel / options.full_well_electrons;
  const double level = light + std::sqrt(variance) * random.normal();
  return static_cast<std::uint8_t>(std::lround(std::clamp(level, 0.0, kMaxLevel)));
}

// The place at which pointSpreadShare() is `share`, by bisection; share in (0, 0.5].
double leftQuantile(double share, double blur_px) {
  if (blur_px == 0) return share - 0.5;
  double low = -0.5 - 10 * blur_px;  // the share there is below 1e-23
  double high = 0;
  constexpr int kNumBisections = 60;
  for (int i = 0; i < kNumBisections; ++i) {
    const double middle = 0.5 * (low + high);
    (pointSpreadShare(middle, blur_px) < share ? low : high) = middle;
  }
  return 0.5 * (low + high);
}

template <class Pattern>
GrayImage renderPattern(const RayLattice& lattice, Pattern pattern, const SE3& camera_from_board,
                        const RenderOptions& options, const CancelFlag* cancel) {
  options.validate();
  const ImageSize size = lattice.size();
  const auto width = static_cast<std::size_t>(size.width);
  const auto height = static_cast<std::size_t>(size.height);
  const BoardLight<Pattern> board_light(std::move(pattern), camera_from_board, options);
  GrayImage image{size, std::vector<std::uint8_t>(width * height)};

  // Threads take several rows at a time, so that buffers are allocated less often.
  constexpr std::size_t kRowsAtOnce = 8;
  parallelFor(
      (height + kRowsAtOnce - 1) / kRowsAtOnce, options.num_jobs,
      [&](std::size_t piece) {
        std::vector<RayExpansion> rays;
        for (std::size_t y = piece * kRowsAtOnce; y < std::min(height, (piece + 1) * kRowsAtOnce); ++y) {
          lattice.expandRow(static_cast<int>(y), rays);
          // Seeded by row, so that noise does not depend on the threads.
          Random random(streamSeed(options.seed, y));
          for (std::size_t x = 0; x < width; ++x) {
            double light = 0;
            if (rays[x].has_ray) {
              light = board_light.at(rays[x]) * shading(rays[x], static_cast<double>(x), size, options);
            }
            image.pixels[y * width + x] = withNoise(light, options, random);
          }
        }
      },
      cancel);
  return image;
}

}  // namespace

double SquaresPattern::edgeDistance(const Eigen::Vector2d& p) const {
  const Eigen::Array2d beyond = beyondSquares(p);
  const auto distanceToBox = [](double dx, double dy) {
    return dx > 0 && dy > 0 ? std::hypot(dx, dy) : std::abs(std::max(dx, dy));
  };
  if (beyond.x() <= 0 && beyond.y() <= 0) {
    return std::min(
        {std::abs(p.x() - std::round(p.x())), std::abs(p.y() - std::round(p.y())), -beyond.x(), -beyond.y()});
  }
  const double to_paper = distanceToBox(beyond.x() - 1, beyond.y() - 1);
  const bool is_on_paper = beyond.x() <= 1 && beyond.y() <= 1;
  return is_on_paper ? std::min(distanceToBox(beyond.x(), beyond.y()), to_paper) : to_paper;
}

double pointSpreadShare(double x_px, double blur_px) {
  if (blur_px == 0) return std::clamp(x_px + 0.5, 0.0, 1.0);
  // The integral of the normal distribution function; the share is its rise over the pixel's width.
  const auto integral = [blur_px](double t) {
    const double z = t / blur_px;
    const double density = std::exp(-0.5 * z * z) * std::numbers::inv_sqrtpi / std::numbers::sqrt2;
    const double distribution = 0.5 * std::erfc(-z / std::numbers::sqrt2);
    return t * distribution + blur_px * density;
  };
  return integral(x_px + 0.5) - integral(x_px - 0.5);
}

PointSpread makePointSpread(double blur_px, int min_samples) {
  constexpr int kMaxSamples = 1'000'000;
  expect(blur_px >= 0, "a blur that is not negative");
  expect(min_samples >= 1 && min_samples <= kMaxSamples, "1 to 1e6 samples");
  std::int64_t generator = 1;
  std::int64_t count = 1;
  while (count < min_samples) {
    const std::int64_t next = generator + count;
    generator = count;
    count = next;
  }

  // Coordinate k of an axis is the quantile of (2 k + 1) / (2 count); the second half mirrors the first.
  std::vector<double> quantiles(static_cast<std::size_t>(count), 0.0);
  for (std::size_t k = 0; k < quantiles.size() / 2; ++k) {
    const double share = (static_cast<double>(k) + 0.5) / static_cast<double>(count);
    quantiles[k] = leftQuantile(share, blur_px);
    quantiles[quantiles.size() - 1 - k] = -quantiles[k];
  }

  PointSpread spread;
  // The offset of y puts the lattice point of index count - 1 - i opposite to that of i, and keeps the
  // numerator odd (of a generator and a count next to each other, at most one is even).
  const std::int64_t offset = generator + (generator % 2 == 0 ? count : 0);
  for (std::int64_t i = 0; i < count; ++i) {
    const std::int64_t numerator = (2 * i * generator + offset) % (2 * count);
    spread.x.push_back(quantiles[static_cast<std::size_t>(i)]);
    spread.y.push_back(quantiles[static_cast<std::size_t>(numerator / 2)]);
    spread.radius_px = std::max(spread.radius_px, std::hypot(spread.x.back(), spread.y.back()));
  }
  return spread;
}

GrayImage Renderer::render(const Checkerboard& board, const SE3& camera_from_board,
                           const RenderOptions& options, const CancelFlag* cancel) const {
  expect(board.columns > 0 && board.rows > 0 && board.square_m > 0, "a board with squares");
  return renderPattern(rays_, SquaresPattern(board, options.border_square), camera_from_board, options,
                       cancel);
}

GrayImage Renderer::render(const BoardInk& ink, const SE3& camera_from_board, const RenderOptions& options,
                           const CancelFlag* cancel) const {
  return renderPattern(rays_, InkPattern(ink), camera_from_board, options, cancel);
}

}  // namespace alidade
