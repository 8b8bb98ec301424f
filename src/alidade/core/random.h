// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>
#include <random>

namespace alidade {

/// Seeded random numbers that are the same on every machine: the standard fixes the engine but leaves the
/// distributions to each library, so those are our own.
class Random {
 public:
  explicit Random(std::uint64_t seed) : engine_(seed) {}

  /// Uniform in [low, high).
  [[nodiscard]] double uniform(double low = 0.0, double high = 1.0);
  /// Normal with mean 0 and standard deviation 1 (Box and Muller 1958).
  [[nodiscard]] double normal();
  /// Uniform integer in [0, count); count > 0.
  [[nodiscard]] std::uint64_t index(std::uint64_t count);

 private:
  std::mt19937_64 engine_;
  double spare_ = 0.0;
  bool has_spare_ = false;
};

/// A seed for stream `stream` of a run seeded with `seed`; neighbouring streams are unrelated (SplitMix64,
/// Steele, Lea and Flood 2014).
[[nodiscard]] std::uint64_t streamSeed(std::uint64_t seed, std::uint64_t stream);

}  // namespace alidade
