// SPDX-License-Identifier: MIT
#include "alidade/simulate/render.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <limits>
#include <numbers>
#include <utility>

#include "alidade/core/error.h"
#include "alidade/core/lanes.h"
#include "alidade/core/parallel.h"
#include "alidade/core/random.h"
#include "alidade/core/vector_code.h"
#include "alidade/simulate/ink_pattern.h"
#include "alidade/simulate/observe.h"
#include "alidade/target/board_turns.h"

namespace alidade {
namespace {

constexpr double kMaxLevel = 255;

// The light of one board in one pose, in grey levels.
class BoardLight {
 public:
  using Marks = std::vector<const InkPattern::Mark*>;

  BoardLight(InkPattern pattern, const SE3& camera_from_board, const RenderOptions& options)
      : pattern_(std::move(pattern)),
        is_visible_(seesPrintedSide(camera_from_board)),
        spread_(makePointSpread(options.blur_px, options.samples)),
        num_places_(spread_.size()),
        dark_(options.dark_level),
        bright_(options.bright_level),
        background_(options.background_level),
        board_from_camera_(camera_from_board.inverse()) {
    // Whole groups of lanes; what fills the last one lies nowhere.
    while (spread_.size() % kNumLanes != 0) {
      spread_.x.push_back(lane::kNaN);
      spread_.y.push_back(lane::kNaN);
    }
    plane_from_camera_ray_ = planeFromCameraRay(0);
  }

  // Mean over the point spread around the pixel centre, whose ray starts at `start_m` on the optical axis.
  // `near` is a buffer.
  [[nodiscard]] double at(const RayExpansion& pixel, double start_m, Marks& near) const {
    if (!is_visible_) return background_;
    // Homogeneous coordinates on the board as quadratic polynomials of the place in the image.
    const Terms terms = (start_m == 0 ? plane_from_camera_ray_ : planeFromCameraRay(start_m)) * pixel.terms;
    const Eigen::AlignedBox2d window = windowOf(terms);
    if (!pattern_.paper().intersects(window)) return background_;
    double num_dark = 0;
    double num_on_paper = 0;
    if (pattern_.findFewIn(window, near)) {
      if (near.empty() && pattern_.paper().contains(window)) return bright_;
      if (near.size() == 1 && !near[0]->is_disc && near[0]->box.contains(window)) return dark_;
      callVectorised([&]() ALIDADE_INLINE_LAMBDA { count(terms, near, num_dark, num_on_paper); });
    } else {
      countOneByOne(terms, num_dark, num_on_paper);
    }
    const auto num = static_cast<double>(num_places_);
    return (num_dark * dark_ + (num_on_paper - num_dark) * bright_ + (num - num_on_paper) * background_) /
           num;
  }

 private:
  using Terms = Eigen::Matrix<double, 3, 6>;

  // The ray from c along d meets z = 0 at (c_x d_z - c_z d_x, c_y d_z - c_z d_y) / d_z, which is in front of
  // the camera if d_z > 0, since c_z < 0 on the printed side.
  [[nodiscard]] Eigen::Matrix3d planeFromCameraRay(double start_m) const {
    const Eigen::Vector3d c = board_from_camera_ * Eigen::Vector3d(0, 0, start_m);
    Eigen::Matrix3d plane_from_ray;
    plane_from_ray << -c.z(), 0, c.x(),  //
        0, -c.z(), c.y(),                //
        0, 0, 1;
    return plane_from_ray * board_from_camera_.rotation.matrix();
  }

  // A box that holds the places of the whole point spread: empty if they are behind the camera, the whole
  // plane if the horizon is among them. With the centre at p = X / w, a place at offset d is at
  // p + (dX - p dw) / (w + dw), bounded by the first derivatives and the smallest w within the spread.
  [[nodiscard]] Eigen::AlignedBox2d windowOf(const Terms& terms) const {
    // Allows for the second order, which is smaller than the first by about the radius of the spread over the
    // focal length.
    constexpr double kSafety = 1.1;
    const double radius = kSafety * spread_.radius_px;
    const double w = terms(2, 0);
    const double change_of_w = radius * std::hypot(terms(2, 1), terms(2, 2));
    if (w + change_of_w <= 0) return {};
    Eigen::Vector2d p = Eigen::Vector2d::Zero();
    double reach = std::numeric_limits<double>::infinity();
    if (w > change_of_w) {
      p = terms.col(0).head<2>() / w;
      const Eigen::Matrix2d first = terms.block<2, 2>(0, 1) - p * terms.block<1, 2>(2, 1);
      reach = radius * first.norm() / (w - change_of_w);
    }
    const Eigen::Vector2d half = Eigen::Vector2d::Constant(reach);
    return {p - half, p + half};
  }

  // A homogeneous coordinate of the place at (x, y) pixels from the centre.
  template <class T>
  ALIDADE_ALWAYS_INLINE static T coordinate(const Terms& terms, int row, const T& x, const T& y) {
    return terms(row, 0) + x * (terms(row, 1) + x * terms(row, 3) + y * terms(row, 4)) +
           y * (terms(row, 2) + y * terms(row, 5));
  }

  // The same as count(), from all marks.
  void countOneByOne(const Terms& terms, double& num_dark, double& num_on_paper) const {
    for (std::size_t i = 0; i < num_places_; ++i) {
      const auto at = [&](int row) { return coordinate(terms, row, spread_.x[i], spread_.y[i]); };
      const double w = at(2);
      const Eigen::Vector2d p(at(0) / w, at(1) / w);
      if (!(w > 0 && pattern_.paper().contains(p))) continue;
      num_on_paper += 1;
      num_dark += pattern_.isDark(p) ? 1 : 0;
    }
  }

  // The numbers of places on one of these marks and on the paper.
  ALIDADE_ALWAYS_INLINE void count(const Terms& terms, const Marks& near, double& num_dark,
                                   double& num_on_paper) const {
    const Lanes zero = {};
    const Lanes one = zero + 1.0;
    Lanes dark = zero;
    Lanes on_paper = zero;
    for (std::size_t i = 0; i < spread_.size(); i += kNumLanes) {
      const Lanes x = lane::load(&spread_.x[i]);
      const Lanes y = lane::load(&spread_.y[i]);
      const Lanes X = coordinate(terms, 0, x, y);
      const Lanes Y = coordinate(terms, 1, x, y);
      const Lanes w = coordinate(terms, 2, x, y);
      const auto isIn = [&](const Eigen::AlignedBox2d& box) ALIDADE_INLINE_LAMBDA {
        return lane::both(lane::both(w * box.min().x() <= X, X <= w * box.max().x()),
                          lane::both(w * box.min().y() <= Y, Y <= w * box.max().y()));
      };
      Lanes is_dark = zero;
      for (const InkPattern::Mark* mark : near) {
        if (mark->is_disc) {
          const Lanes dx = X - w * (0.5 * (mark->box.min().x() + mark->box.max().x()));
          const Lanes dy = Y - w * (0.5 * (mark->box.min().y() + mark->box.max().y()));
          const Lanes radius = w * (0.5 * (mark->box.max().x() - mark->box.min().x()));
          is_dark = lane::select(dx * dx + dy * dy <= radius * radius, one, is_dark);
        } else {
          is_dark = lane::select(isIn(mark->box), one, is_dark);
        }
      }
      const LaneMask is_on_paper = lane::both(w > 0.0, isIn(pattern_.paper()));
      dark += lane::select(is_on_paper, is_dark, zero);
      on_paper += lane::select(is_on_paper, one, zero);
    }
    std::array<double, kNumLanes> sums{};
    lane::store(dark, sums.data());
    for (const double sum : sums) num_dark += sum;
    lane::store(on_paper, sums.data());
    for (const double sum : sums) num_on_paper += sum;
  }

  InkPattern pattern_;
  bool is_visible_;
  PointSpread spread_;
  std::size_t num_places_;
  double dark_;
  double bright_;
  double background_;
  SE3 board_from_camera_;
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

GrayImage renderPattern(const RayLattice& lattice, InkPattern pattern, const SE3& camera_from_board,
                        const RenderOptions& options, const CancelFlag* cancel) {
  options.validate();
  const ImageSize size = lattice.size();
  const auto width = static_cast<std::size_t>(size.width);
  const auto height = static_cast<std::size_t>(size.height);
  const BoardLight board_light(std::move(pattern), camera_from_board, options);
  GrayImage image{size, std::vector<std::uint8_t>(width * height)};

  // Threads take several rows at a time, so that buffers are allocated less often.
  constexpr std::size_t kRowsAtOnce = 8;
  parallelFor((height + kRowsAtOnce - 1) / kRowsAtOnce, options.num_jobs,
              [&](std::size_t piece) {
                std::vector<RayExpansion> rays;
                BoardLight::Marks near;
                for (std::size_t y = piece * kRowsAtOnce; y < std::min(height, (piece + 1) * kRowsAtOnce);
                     ++y) {
                  lattice.expandRow(static_cast<int>(y), rays);
                  // Seeded by row, so that noise does not depend on the threads.
                  Random random(streamSeed(options.seed, y));
                  for (std::size_t x = 0; x < width; ++x) {
                    double light = 0;
                    if (rays[x].has_ray) {
                      const double start_m = lattice.camera().startOf(rays[x].terms.col(0)).z();
                      light = board_light.at(rays[x], start_m, near) *
                              shading(rays[x], static_cast<double>(x), size, options);
                    }
                    image.pixels[y * width + x] = withNoise(light, options, random);
                  }
                }
              },
              cancel);
  return image;
}

}  // namespace

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
  options.validate();
  return renderPattern(rays_, InkPattern(board, options.border_square), camera_from_board, options, cancel);
}

GrayImage Renderer::render(const BoardInk& ink, const SE3& camera_from_board, const RenderOptions& options,
                           const CancelFlag* cancel) const {
  return renderPattern(rays_, InkPattern(ink), camera_from_board, options, cancel);
}

}  // namespace alidade
