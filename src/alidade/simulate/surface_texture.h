// SPDX-License-Identifier: MIT
#pragma once

#include <array>
#include <cstdint>

#include <Eigen/Core>

namespace alidade {

/// An unbounded grey texture with detail at all scales and without repetition: gradient noise of many octaves
/// (Perlin 1985), discs and squares of several sizes, and on some surfaces bricks. Detectors find corners and
/// blobs everywhere, at any distance.
class SurfaceTexture {
 public:
  /// Different seeds give unrelated textures.
  explicit SurfaceTexture(std::uint32_t seed);

  /// The grey level, 4 to 252, at a place on the surface, in metres. Detail finer than about two times
  /// `footprint_m` is left out, and detail finer than four times fades, so that samples one footprint apart
  /// show no aliasing. `footprint_m` > 0.
  [[nodiscard]] double levelAt(const Eigen::Vector2d& p, double footprint_m) const;

 private:
  static constexpr int kMaxOctaves = 20;

  std::array<std::uint32_t, kMaxOctaves> seeds_;  // of the octaves
  std::uint32_t brick_seed_;
  bool has_bricks_;
  double tone_;  // of the whole surface, -1 to 1
};

}  // namespace alidade
