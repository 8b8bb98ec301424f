// SPDX-License-Identifier: MIT
#include "alidade/core/random.h"

#include <cmath>
#include <numbers>

namespace alidade {

double Random::uniform(double low, double high) {
  constexpr double kTwoToMinus53 = 0x1.0p-53;
  return low + (high - low) * (static_cast<double>(engine_() >> 11U) * kTwoToMinus53);
}

double Random::normal() {
  if (has_spare_) {
    has_spare_ = false;
    return spare_;
  }
  const double radius = std::sqrt(-2.0 * std::log(1.0 - uniform()));
  const double angle = 2.0 * std::numbers::pi * uniform();
  spare_ = radius * std::sin(angle);
  has_spare_ = true;
  return radius * std::cos(angle);
}

std::uint64_t Random::index(std::uint64_t count) {
  // The remainder has a bias below count / 2^64, too small to matter in a simulation.
  return engine_() % count;
}

std::uint64_t streamSeed(std::uint64_t seed, std::uint64_t stream) {
  std::uint64_t z = seed + 0x9e3779b97f4a7c15ULL * (stream + 1);
  z = (z ^ (z >> 30U)) * 0xbf58476d1ce4e5b9ULL;
  z = (z ^ (z >> 27U)) * 0x94d049bb133111ebULL;
  return z ^ (z >> 31U);
}

}  // namespace alidade
