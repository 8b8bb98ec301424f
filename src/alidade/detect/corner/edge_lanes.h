// SPDX-License-Identifier: MIT
// Vector code of the models of edges; to be compiled at -O3, without a precompiled header.
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <utility>

#include "alidade/core/vector_code.h"
#include "alidade/detect/corner/edge_pixels.h"

#if defined(ALIDADE_HAS_VECTORS)
#pragma GCC diagnostic ignored "-Wpsabi"  // vectors are passed only to inlined functions
#endif

namespace alidade::lanes {

#if defined(ALIDADE_HAS_VECTORS)
inline constexpr std::size_t kNumLanes = 8;
using Lanes = float __attribute__((vector_size(32)));
using IntLanes = std::int32_t __attribute__((vector_size(32)));
#else
inline constexpr std::size_t kNumLanes = 1;
using Lanes = float;
using IntLanes = std::int32_t;
#endif

inline constexpr std::size_t kChunk = EdgePixels::kChunk;
inline constexpr std::size_t kVectorsPerChunk = kChunk / kNumLanes;
static_assert(kVectorsPerChunk * kNumLanes == kChunk);

ALIDADE_ALWAYS_INLINE Lanes load(const float* from) {
  Lanes lanes;
  std::memcpy(&lanes, from, sizeof lanes);
  return lanes;
}

ALIDADE_ALWAYS_INLINE void store(const Lanes& lanes, float* to) {
  std::memcpy(to, &lanes, sizeof lanes);
}

// 2^x for x in [-120, 0]: the integer part goes into the exponent, the rest within +-0.5 into a Taylor
// polynomial whose error is below 3e-8.
ALIDADE_ALWAYS_INLINE Lanes powerOfTwo(const Lanes& x) {
  constexpr float kRounder = 12582912.0F;  // 1.5 * 2^23: adding it leaves the integer part in the lowest bits
  const Lanes shifted = x + kRounder;
  const Lanes rest = x - (shifted - kRounder);
  IntLanes bits;
  std::memcpy(&bits, &shifted, sizeof bits);
  const IntLanes exponent = (bits - 0x4B400000 + 127) << 23;
  Lanes scale;
  std::memcpy(&scale, &exponent, sizeof scale);
  Lanes sum = rest * 1.54035304e-4F + 1.33335581e-3F;
  sum = sum * rest + 9.61812911e-3F;
  sum = sum * rest + 5.55041087e-2F;
  sum = sum * rest + 2.40226507e-1F;
  sum = sum * rest + 6.93147181e-1F;
  sum = sum * rest + 1.0F;
  return sum * scale;
}

// erf(z / sqrt 2) and its derivative by z.
ALIDADE_ALWAYS_INLINE void edgeProfile(const Lanes& z, Lanes& value, Lanes& derivative) {
  constexpr float kFarthest = 12.0F;  // beyond, the profile is flat in single precision
  const Lanes zero = {};
  const Lanes magnitude = z < zero ? -z : z;
  const Lanes x = magnitude > kFarthest ? zero + kFarthest : magnitude;
  const Lanes bell = powerOfTwo(x * x * -0.721347520F);  // exp(-z^2 / 2)
  const Lanes t = 1.0F / (x * 0.231641888F + 1.0F);      // 0.3275911 / sqrt 2
  Lanes sum = t * 1.061405429F - 1.453152027F;
  sum = sum * t + 1.421413741F;
  sum = sum * t - 0.284496736F;
  sum = sum * t + 0.254829592F;
  const Lanes positive = 1.0F - sum * t * bell;
  value = z < zero ? -positive : positive;
  derivative = bell * 0.797884561F;  // sqrt(2 / pi)
}

/// Columns of a chunk of pixels: the derivatives and, last, the residual.
template <std::size_t kNumColumns>
using Columns = Lanes[kNumColumns][kVectorsPerChunk];

// Adds the products of column I with columns 0 to I.
template <std::size_t I, std::size_t kNumColumns>
ALIDADE_ALWAYS_INLINE void addProducts(const Columns<kNumColumns>& columns, std::size_t num_vectors,
                                       Lanes* sums) {
  Lanes sum[I + 1];
  for (std::size_t j = 0; j <= I; ++j) sum[j] = sums[I * (I + 1) / 2 + j];
  for (std::size_t vector = 0; vector < num_vectors; ++vector) {
    const Lanes factor = columns[I][vector];
    for (std::size_t j = 0; j <= I; ++j) sum[j] += factor * columns[j][vector];
  }
  for (std::size_t j = 0; j <= I; ++j) sums[I * (I + 1) / 2 + j] = sum[j];
}

template <std::size_t kNumColumns, std::size_t... I>
ALIDADE_ALWAYS_INLINE void addAllProducts(const Columns<kNumColumns>& columns, std::size_t num_vectors,
                                          Lanes* sums, std::index_sequence<I...>) {
  (addProducts<I, kNumColumns>(columns, num_vectors, sums), ...);
}

/// Sums of the products of each two columns, the lower triangle row by row. `fill(x, y, grey, columns,
/// vector)` computes the columns of the pixels of one vector.
template <std::size_t kNumColumns, class Fill>
ALIDADE_ALWAYS_INLINE void sumProducts(const EdgePixels& pixels, const Fill& fill, double* totals) {
  constexpr std::size_t kNumSums = kNumColumns * (kNumColumns + 1) / 2;
  Lanes sums[kNumSums] = {};
  Columns<kNumColumns> columns;
  for (std::size_t begin = 0; begin < pixels.size(); begin += kChunk) {
    const std::size_t count = std::min(kChunk, pixels.size() - begin);
    const std::size_t num_vectors = (count + kNumLanes - 1) / kNumLanes;
    for (std::size_t vector = 0; vector < num_vectors; ++vector) {
      const std::size_t at = begin + vector * kNumLanes;
      fill(load(pixels.x() + at), load(pixels.y() + at), load(pixels.grey() + at), columns, vector);
    }
    // Lanes of the last vector beyond the last pixel must not count.
    for (auto& column : columns) {
      std::memset(reinterpret_cast<char*>(column) + count * sizeof(float), 0,
                  (num_vectors * kNumLanes - count) * sizeof(float));
    }
    addAllProducts<kNumColumns>(columns, num_vectors, sums, std::make_index_sequence<kNumColumns>());
  }
  for (std::size_t i = 0; i < kNumSums; ++i) {
    float lanes[kNumLanes];
    store(sums[i], lanes);
    totals[i] = 0;
    for (const float lane : lanes) totals[i] += lane;
  }
}

/// The normal equations of a model, by sumProducts() with the best instructions of the processor. `fill` must
/// be inlined (ALIDADE_INLINE_LAMBDA).
template <int kSize, class Fill>
void sumEquations(const EdgePixels& pixels, const Fill& fill, NormalEquations<kSize>& sums) {
  constexpr std::size_t kNumColumns = kSize + 1;
  double totals[kNumColumns * (kNumColumns + 1) / 2];
  callVectorised([&]() ALIDADE_INLINE_LAMBDA { sumProducts<kNumColumns>(pixels, fill, totals); });
  const double* total = totals;
  for (int i = 0; i < kSize; ++i) {
    for (int j = 0; j <= i; ++j) sums.hessian(i, j) = sums.hessian(j, i) = *total++;
  }
  for (int i = 0; i < kSize; ++i) sums.gradient(i) = *total++;
  sums.cost = *total;
}

/// Makes columns hold whole vectors of pixels.
template <class... Column>
void holdPixels(const EdgePixels& pixels, Column&... columns) {
  const std::size_t size = (pixels.size() + kNumLanes - 1) / kNumLanes * kNumLanes;
  (columns.resize(std::max(columns.size(), size)), ...);
}

}  // namespace alidade::lanes
