// SPDX-License-Identifier: MIT
#include "alidade/footage/geometry/pair_geometry.h"

#include <cmath>
#include <limits>

#include "alidade/footage/geometry/essential.h"

namespace alidade {

std::optional<PairRays> raysOf(const PosedPair& pair, const PixelMatch& match) {
  PairRays rays;
  const auto a = pair.first.unproject(match.a, rays.J_first.data());
  const auto b = a ? pair.second.unproject(match.b, rays.J_second.data()) : std::nullopt;
  if (!b) return std::nullopt;
  rays.first = *a;
  rays.second = *b;
  return rays;
}

std::vector<double> sampsonErrors(const PosedPair& pair, std::span<const TimedMatch> matches) {
  const Eigen::Matrix3d E = essentialMatrix(pair.second_from_first);
  std::vector<double> errors;
  errors.reserve(matches.size());
  for (const TimedMatch& match : matches) {
    const auto rays = raysOf(pair, match.pixels);
    if (!rays) {
      errors.push_back(std::numeric_limits<double>::quiet_NaN());
      continue;
    }
    const Eigen::Vector3d line_second = E * rays->first;
    const Eigen::Vector3d line_first = E.transpose() * rays->second;
    const double variance = (rays->J_first.transpose() * line_first).squaredNorm() +
                            (rays->J_second.transpose() * line_second).squaredNorm();
    errors.push_back(rays->second.dot(line_second) / std::sqrt(variance));
  }
  return errors;
}

}  // namespace alidade
