// SPDX-License-Identifier: MIT
#include "alidade/calibrate/uncertainty/model_spread.h"

#include <cmath>
#include <cstddef>
#include <tuple>

#include "alidade/calibrate/uncertainty/far_difference.h"

namespace alidade {
namespace {

constexpr double kDifferentSigmas = 3;

std::optional<ModelSpread> spreadTo(const RivalCamera& rival, const AnyCamera& camera,
                                    std::span<const Eigen::Vector2d> corners, const UncertaintyGrid& grid) {
  const std::vector<double> differences =
      farDifferences(camera, AnyCamera::make(rival.id, rival.params), grid.pixels, corners);
  ModelSpread spread{.id = rival.id};
  int num_seen = 0;
  int num_compared = 0;
  int num_apart = 0;
  for (std::size_t i = 0; i < differences.size(); ++i) {
    if (!std::isfinite(grid.std_px[i])) continue;
    ++num_seen;
    if (!std::isfinite(differences[i])) continue;
    ++num_compared;
    if (differences[i] > kApartPx && differences[i] > kDifferentSigmas * grid.std_px[i]) ++num_apart;
    if (differences[i] >= spread.worst_px) {
      spread.worst_px = differences[i];
      spread.worst_pixel = grid.pixels[i];
    }
  }
  if (num_compared == 0) return std::nullopt;
  spread.share_apart = static_cast<double>(num_apart) / num_seen;
  return spread;
}

}  // namespace

std::optional<ModelSpread> modelSpread(const AnyCamera& camera, std::span<const RivalCamera> rivals,
                                       std::span<const Eigen::Vector2d> corners,
                                       const UncertaintyGrid& grid) {
  std::optional<ModelSpread> widest;
  const auto size = [](const ModelSpread& s) { return std::tuple(s.share_apart, s.worst_px); };
  for (const RivalCamera& rival : rivals) {
    auto spread = spreadTo(rival, camera, corners, grid);
    if (spread && (!widest || size(*spread) > size(*widest))) widest = std::move(spread);
  }
  return widest;
}

}  // namespace alidade
