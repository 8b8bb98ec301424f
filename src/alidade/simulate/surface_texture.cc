// SPDX-License-Identifier: MIT
#include "alidade/simulate/surface_texture.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <numbers>

namespace alidade {
namespace {

using Eigen::Vector2d;

constexpr double kCoarsestM = 2;  // spacing of the coarsest noise
constexpr double kOctaveRatio = 0.4;
constexpr double kNoiseLevels = 48;  // of one octave, whose noise has a standard deviation of about a quarter
constexpr double kShapeLevels = 48;
constexpr double kBrickLevels = 36;
constexpr double kToneLevels = 35;  // of the whole surface

// Mixes the bits so that neighbouring inputs give unrelated outputs.
std::uint32_t scrambled(std::uint32_t x) {
  x ^= x >> 16U;
  x *= 0x7feb352dU;
  x ^= x >> 15U;
  x *= 0x846ca68bU;
  return x ^ (x >> 16U);
}

std::uint32_t rowHash(std::int64_t j, std::uint32_t seed) {
  return scrambled(static_cast<std::uint32_t>(j) * 0x85ebca77U ^ seed);
}

std::uint32_t cellHash(std::int64_t i, std::uint32_t row_hash) {
  return scrambled(static_cast<std::uint32_t>(i) * 0x9e3779b1U ^ row_hash);
}

std::uint32_t cellHash(std::int64_t i, std::int64_t j, std::uint32_t seed) {
  return cellHash(i, rowHash(j, seed));
}

// Rounds down. std::floor is a function call unless the instruction set has rounding. |x| < 1e18.
std::int64_t floorOf(double x) {
  const auto truncated = static_cast<std::int64_t>(x);
  return truncated - (x < static_cast<double>(truncated) ? 1 : 0);
}

// A number in [0, 1) from eight bits.
double share(std::uint32_t hash, int byte) {
  return ((hash >> static_cast<unsigned>(8 * byte)) & 0xffU) / 256.0;
}

// Linear interpolation; std::lerp has branches, which take time.
double mixed(double a, double b, double share_of_b) {
  return a + share_of_b * (b - a);
}

double smoothStep(double x) {
  const double t = std::clamp(x, 0.0, 1.0);
  return t * t * (3 - 2 * t);
}

// Share of a detail of this size that is shown: nothing up to two footprints, everything from four.
double detailWeight(double size_m, double footprint_m) {
  return std::clamp(0.5 * (size_m / footprint_m - 2), 0.0, 1.0);
}

// Unit vectors in 256 directions.
struct UnitVectors {
  std::array<Vector2d, 256> at;

  UnitVectors() {
    for (std::size_t i = 0; i < at.size(); ++i) {
      const double angle = 2 * std::numbers::pi * static_cast<double>(i) / static_cast<double>(at.size());
      at[i] = {std::cos(angle), std::sin(angle)};
    }
  }
};

// Gradient noise of lattice spacing 1 with the interpolant of Perlin 2002; within about +-0.7.
double gradientNoise(const Vector2d& p, std::uint32_t seed, const UnitVectors& vectors) {
  const std::int64_t i = floorOf(p.x());
  const std::int64_t j = floorOf(p.y());
  const double x = p.x() - static_cast<double>(i);
  const double y = p.y() - static_cast<double>(j);
  const std::array<std::uint32_t, 2> rows = {rowHash(j, seed), rowHash(j + 1, seed)};
  const auto corner = [&](int di, std::size_t dj) {
    const Vector2d& g = vectors.at[cellHash(i + di, rows[dj]) & 0xffU];
    return g.x() * (x - di) + g.y() * (y - static_cast<double>(dj));
  };
  const auto fade = [](double t) { return t * t * t * (t * (6 * t - 15) + 10); };
  const double u = fade(x);
  return mixed(mixed(corner(0, 0), corner(1, 0), u), mixed(corner(0, 1), corner(1, 1), u), fade(y));
}

// Tone of a shape within its cell of a grid: a disc or a square, brighter or darker. -1 to 1.
double shapeTone(const Vector2d& p, double cell_m, double footprint_m, std::uint32_t seed,
                 const UnitVectors& vectors) {
  const std::int64_t i = floorOf(p.x() / cell_m);
  const std::int64_t j = floorOf(p.y() / cell_m);
  const std::uint32_t hash = cellHash(i, j, seed);
  constexpr std::uint32_t kShapesOf8 = 6;
  if ((hash & 7U) >= kShapesOf8) return 0;
  const std::uint32_t more = scrambled(hash);
  const double radius = cell_m * (0.15 + 0.2 * share(more, 0));
  const Vector2d middle = cell_m * Vector2d(static_cast<double>(i), static_cast<double>(j)) +
                          Vector2d::Constant(radius) +
                          (cell_m - 2 * radius) * Vector2d(share(more, 1), share(more, 2));
  const Vector2d offset = p - middle;
  double beyond = 0;  // signed distance to the rim
  if ((hash & 8U) != 0) {
    beyond = offset.norm() - 0.9 * radius;
  } else {
    const Vector2d& side = vectors.at[more >> 24U];
    const double half_side = radius / std::numbers::sqrt2;
    beyond = std::max(std::abs(side.dot(offset)), std::abs(side.x() * offset.y() - side.y() * offset.x())) -
             half_side;
  }
  const double tone = (hash & 16U) != 0 ? 1 : -1;
  return tone * (0.5 + 0.5 * share(hash, 2)) * smoothStep(0.5 - beyond / (2 * footprint_m));
}

// Rows of bricks of different lengths and tones between dark joints. -1 to 1.
double brickTone(const Vector2d& p, double row_m, double footprint_m, std::uint32_t seed) {
  const double length = 2.3 * row_m;
  const std::int64_t row_id = floorOf(p.y() / row_m);
  const double along = p.x() / length + share(cellHash(row_id, 0, seed), 1);
  const std::int64_t slot_id = floorOf(along);
  // Each joint is moved by up to 0.3 of a brick.
  const auto joint = [&](std::int64_t id) {
    return static_cast<double>(id) + 0.6 * (share(cellHash(id, row_id, seed), 0) - 0.5);
  };
  std::int64_t brick = slot_id;
  if (along < joint(slot_id)) --brick;
  if (along >= joint(slot_id + 1)) ++brick;
  const double to_side = length * std::min(along - joint(brick), joint(brick + 1) - along);
  const double in_row = p.y() - static_cast<double>(row_id) * row_m;
  const double to_joint = std::min({to_side, in_row, row_m - in_row});
  const double half_joint = 0.04 * row_m;
  const double tone = 2 * share(cellHash(brick, row_id, seed), 2) - 1;
  const double brick_share = smoothStep(0.5 + (to_joint - half_joint) / (2 * footprint_m));
  return mixed(-1, 0.8 * tone, brick_share);
}

}  // namespace

SurfaceTexture::SurfaceTexture(std::uint32_t seed) {
  const std::uint32_t own = scrambled(seed + 0x51ed270bU);
  for (std::size_t i = 0; i < seeds_.size(); ++i) seeds_[i] = scrambled(own + static_cast<std::uint32_t>(i));
  brick_seed_ = scrambled(own + 99);
  has_bricks_ = (brick_seed_ & 1U) != 0;
  tone_ = 2 * share(scrambled(own + 98), 0) - 1;
}

double SurfaceTexture::levelAt(const Vector2d& p, double footprint_m) const {
  static const UnitVectors kVectors;
  double level = kToneLevels * tone_;
  double spacing = kCoarsestM;
  for (const std::uint32_t seed : seeds_) {
    const double weight = detailWeight(spacing, footprint_m);
    if (weight == 0) break;
    // Shifted, because the noise is zero at all points of its lattice.
    const Vector2d shift(share(seed, 0), share(seed, 1));
    level += weight * kNoiseLevels * gradientNoise(p / spacing + shift, seed, kVectors);
    const double shape_weight = detailWeight(0.25 * spacing, footprint_m);
    if (shape_weight > 0)
      level += shape_weight * kShapeLevels * shapeTone(p, spacing, footprint_m, ~seed, kVectors);
    spacing *= kOctaveRatio;
  }
  if (has_bricks_) {
    constexpr double kRowM = 0.3;
    const double weight = detailWeight(0.5 * kRowM, footprint_m);
    if (weight > 0) level += weight * kBrickLevels * brickTone(p, kRowM, footprint_m, brick_seed_);
  }
  // Limited smoothly.
  constexpr double kMiddle = 128;
  constexpr double kRange = 124;
  return kMiddle + kRange * std::tanh(level / kRange);
}

}  // namespace alidade
