// SPDX-License-Identifier: MIT
#include "alidade/detect/board/x_corner.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

#include <opencv2/imgproc.hpp>

namespace alidade {
namespace {

using Eigen::Vector2d;

// Patterns weaker than this many grey levels are noise or shadows.
constexpr double kMinSquareContrast = 10;
constexpr double kRingPx = 4;
constexpr double kSmallRingPx = 2.8;
constexpr int kBorder = 3;
// The differences below are 4 times the second derivatives of the grey levels, over two pixels, times 256.
constexpr double kDerivativeScale = 256.0 * 4.0;

// The response of an X-corner with contrast c and total blur s is (c / (pi s^2))^2. Including the blur of the
// binomial filter and of the differences, s is rarely below 1.5, and is 3 for blurred images.
constexpr double kMinResponse = (kMinSquareContrast * 0.04) * (kMinSquareContrast * 0.04);

struct Hessian {
  double xx;
  double xy;
  double yy;
  double x;  // gradient
  double y;
};

Hessian hessianAt(const SmoothImage& image, int x, int y) {
  const std::uint16_t* here = image.row(y) + x;
  const std::ptrdiff_t w = image.size.width;
  const auto value = [here, w](int dx, int dy) { return static_cast<double>(here[dy * w + dx]); };
  return {.xx = value(-2, 0) + value(2, 0) - 2 * value(0, 0),
          .xy = value(1, 1) + value(-1, -1) - value(1, -1) - value(-1, 1),
          .yy = value(0, -2) + value(0, 2) - 2 * value(0, 0),
          .x = value(2, 0) - value(-2, 0),
          .y = value(0, 2) - value(0, -2)};
}

// The point where the gradient vanishes, by one Newton step from a pixel; at most one pixel away along each
// axis.
Vector2d saddleNear(const SmoothImage& image, int x, int y) {
  const Hessian h = hessianAt(image, x, y);
  const double det = h.xx * h.yy - h.xy * h.xy;
  // The gradient is 4 times the first derivative, the Hessian 4 times the second.
  const double dx = -(h.yy * h.x - h.xy * h.y) / det;
  const double dy = -(h.xx * h.y - h.xy * h.x) / det;
  return {x + std::clamp(dx, -1.0, 1.0), y + std::clamp(dy, -1.0, 1.0)};
}

constexpr std::size_t kNumRing = 32;
const std::array<Vector2d, kNumRing>& ringDirections() {
  static const std::array<Vector2d, kNumRing> kDirections = [] {
    std::array<Vector2d, kNumRing> directions;
    for (std::size_t k = 0; k < kNumRing; ++k) {
      const double angle = 2 * std::numbers::pi * static_cast<double>(k) / kNumRing;
      directions[k] = {std::cos(angle), std::sin(angle)};
    }
    return directions;
  }();
  return kDirections;
}

// Quick test on a circle of radius 4: at an X-corner, opposite pixels are alike and differ from those a
// quarter of the circle away (Bennett and Lasenby 2014, ChESS). Passes about one place in ten of a texture.
bool looksLikeCorner(const SmoothImage& image, int x, int y) {
  constexpr int kReach = 4;
  if (x < kReach || y < kReach || x >= image.size.width - kReach || y >= image.size.height - kReach)
    return true;
  constexpr std::array kCircleX = {4, 4, 3, 2, 0, -2, -3, -4, -4, -4, -3, -2, 0, 2, 3, 4};
  constexpr std::array kCircleY = {0, 2, 3, 4, 4, 4, 3, 2, 0, -2, -3, -4, -4, -4, -3, -2};
  const std::ptrdiff_t w = image.size.width;
  const std::uint16_t* here = image.row(y) + x;
  std::array<int, 16> level{};
  for (std::size_t k = 0; k < 16; ++k) level[k] = here[kCircleY[k] * w + kCircleX[k]];
  int alike = 0;   // differences of opposite pixels
  int unlike = 0;  // differences of pairs a quarter apart
  for (std::size_t k = 0; k < 8; ++k) alike += std::abs(level[k] - level[k + 8]);
  for (std::size_t k = 0; k < 4; ++k)
    unlike += std::abs(level[k] + level[k + 8] - level[k + 4] - level[k + 12]);
  return unlike > alike;
}

// Reads the circle around `center`; false if it does not look like an X-corner.
bool readRing(const SmoothImage& image, const Vector2d& center, double radius, XCorner& corner) {
  if (!image.covers(center - Vector2d(radius, radius)) || !image.covers(center + Vector2d(radius, radius)))
    return false;
  std::array<double, kNumRing> level{};
  double low = std::numeric_limits<double>::infinity();
  double high = -low;
  for (std::size_t k = 0; k < kNumRing; ++k) {
    level[k] = image.at(center + radius * ringDirections()[k]);
    low = std::min(low, level[k]);
    high = std::max(high, level[k]);
  }
  const double range = high - low;
  if (range < kMinSquareContrast) return false;
  const double middle = 0.5 * (low + high);
  // At the corner itself, the level is halfway.
  constexpr double kMaxOffCenter = 0.3;  // share of the range
  if (std::abs(image.at(center) - middle) > kMaxOffCenter * range) return false;

  std::size_t count = 0;
  std::array<std::size_t, 4> crossing{};  // the sample before each
  for (std::size_t k = 0; k < kNumRing; ++k) {
    if ((level[k] < middle) == (level[(k + 1) % kNumRing] < middle)) continue;
    if (count == 4) return false;
    crossing[count++] = k;
  }
  if (count != 4) return false;
  // Sector n is between crossings n and n + 1; its extreme value shows how distinct it is.
  constexpr double kMinSector = 0.22;  // share of the range
  double sum_of_extremes = 0;
  for (std::size_t n = 0; n < 4; ++n) {
    const std::size_t first = crossing[n];
    const std::size_t end = n < 3 ? crossing[n + 1] : crossing[0] + kNumRing;
    double extreme = 0;
    for (std::size_t k = first + 1; k <= end; ++k)
      extreme = std::max(extreme, std::abs(level[k % kNumRing] - middle));
    if (extreme < kMinSector * range) return false;
    sum_of_extremes += extreme;
    const double a = level[first] - middle;
    const double b = level[(first + 1) % kNumRing] - middle;
    const double share = a / (a - b);
    corner.edges[n] =
        ((1 - share) * ringDirections()[first] + share * ringDirections()[(first + 1) % kNumRing])
            .normalized();
  }
  // Opposite edges form one line, bent at most by the lens.
  constexpr double kMaxBendCos = -0.825;  // 34 degrees
  if (corner.edges[0].dot(corner.edges[2]) > kMaxBendCos ||
      corner.edges[1].dot(corner.edges[3]) > kMaxBendCos)
    return false;
  corner.pixel = center;
  corner.first_sector_is_dark = level[(crossing[0] + 1) % kNumRing] < middle;
  corner.contrast = 0.5 * sum_of_extremes;
  return true;
}

// OpenCV has no view of constant data; the result must not be written to.
cv::Mat viewOf(const GrayImage& image) {
  return {image.size.height, image.size.width, CV_8UC1, const_cast<std::uint8_t*>(image.pixels.data())};
}

}  // namespace

GrayImage halved(const GrayImage& image) {
  GrayImage half{.size = {.width = image.size.width / 2, .height = image.size.height / 2}, .pixels = {}};
  if (half.size.width == 0 || half.size.height == 0) return {};
  half.pixels.resize(static_cast<std::size_t>(half.size.width) * static_cast<std::size_t>(half.size.height));
  cv::Mat out(half.size.height, half.size.width, CV_8UC1, half.pixels.data());
  cv::resize(viewOf(image)(cv::Rect(0, 0, 2 * out.cols, 2 * out.rows)), out, out.size(), 0, 0,
             cv::INTER_AREA);
  return half;
}

SmoothImage smoothed(const GrayImage& image) {
  SmoothImage out{.size = image.size, .values = std::vector<std::uint16_t>(image.pixels.size())};
  if (image.empty()) return out;
  cv::Mat smooth(image.size.height, image.size.width, CV_16UC1, out.values.data());
  cv::Mat scaled;
  viewOf(image).convertTo(scaled, CV_16U, 256);
  // With a standard deviation of 0, OpenCV's kernel of five is the binomial one, and the result is exact.
  cv::GaussianBlur(scaled, smooth, cv::Size(5, 5), 0, 0, cv::BORDER_REPLICATE);
  return out;
}

std::vector<XCorner> findXCorners(const SmoothImage& image) {
  std::vector<XCorner> corners;
  const int width = image.size.width;
  const int height = image.size.height;
  if (width <= 2 * kBorder || height <= 2 * kBorder) return corners;
  const auto stride = static_cast<std::size_t>(width);
  constexpr float kThreshold = static_cast<float>(kMinResponse * kDerivativeScale * kDerivativeScale);

  // Responses of three rows, in a ring buffer; outside the border they stay 0.
  std::array<std::vector<float>, 3> rows;
  for (auto& row : rows) row.assign(stride, 0.0F);
  const auto respond = [&](int y) {
    float* out = rows[static_cast<std::size_t>(y % 3)].data();
    if (y >= height - kBorder) {
      std::fill_n(out, stride, 0.0F);
      return;
    }
    const std::uint16_t* up2 = image.row(y - 2);
    const std::uint16_t* up = image.row(y - 1);
    const std::uint16_t* here = image.row(y);
    const std::uint16_t* down = image.row(y + 1);
    const std::uint16_t* down2 = image.row(y + 2);
    for (int x = kBorder; x < width - kBorder; ++x) {
      const int twice = 2 * here[x];
      const auto xx = static_cast<float>(here[x - 2] + here[x + 2] - twice);
      const auto yy = static_cast<float>(up2[x] + down2[x] - twice);
      const auto xy = static_cast<float>(up[x - 1] + down[x + 1] - up[x + 1] - down[x - 1]);
      out[x] = xy * xy - xx * yy;
    }
  };
  respond(kBorder);
  for (int y = kBorder; y < height - kBorder; ++y) {
    respond(y + 1);
    const float* above = rows[static_cast<std::size_t>((y + 2) % 3)].data();
    const float* here = rows[static_cast<std::size_t>(y % 3)].data();
    const float* below = rows[static_cast<std::size_t>((y + 1) % 3)].data();
    for (int x = kBorder; x < width - kBorder; ++x) {
      const float r = here[x];
      if (r <= kThreshold) continue;
      const bool is_peak = r > here[x - 1] && r >= here[x + 1] && r > above[x - 1] && r > above[x] &&
                           r > above[x + 1] && r >= below[x - 1] && r >= below[x] && r >= below[x + 1];
      if (!is_peak) continue;
      if (!looksLikeCorner(image, x, y)) continue;
      const Vector2d saddle = saddleNear(image, x, y);
      XCorner corner;
      if (readRing(image, saddle, kRingPx, corner) || readRing(image, saddle, kSmallRingPx, corner))
        corners.push_back(corner);
    }
  }
  // More corners than the largest board has come from a fine texture, so dropping some loses nothing.
  constexpr std::size_t kMaxCorners = 60000;
  if (corners.size() > kMaxCorners) {
    std::stable_sort(corners.begin(), corners.end(),
                     [](const XCorner& a, const XCorner& b) { return a.contrast > b.contrast; });
    corners.resize(kMaxCorners);
  }
  return corners;
}

bool xCornerNear(const SmoothImage& image, const Vector2d& guess, double radius_px, double ring_px,
                 XCorner& corner) {
  const int reach = std::max(1, static_cast<int>(std::lround(radius_px)));
  const int cx = static_cast<int>(std::lround(guess.x()));
  const int cy = static_cast<int>(std::lround(guess.y()));
  double best = 0;
  int best_x = -1;
  int best_y = -1;
  for (int y = std::max(kBorder, cy - reach); y <= std::min(image.size.height - 1 - kBorder, cy + reach);
       ++y) {
    for (int x = std::max(kBorder, cx - reach); x <= std::min(image.size.width - 1 - kBorder, cx + reach);
         ++x) {
      const Hessian h = hessianAt(image, x, y);
      const double response = h.xy * h.xy - h.xx * h.yy;
      if (response <= best) continue;
      best = response;
      best_x = x;
      best_y = y;
    }
  }
  return best_x >= 0 && readRing(image, saddleNear(image, best_x, best_y), ring_px, corner);
}

}  // namespace alidade
