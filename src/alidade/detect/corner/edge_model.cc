// SPDX-License-Identifier: MIT
#include "alidade/detect/corner/edge_model.h"

#include <algorithm>
#include <cstdint>
#include <cstring>
#include <utility>

#include "alidade/core/vector_code.h"

#if defined(ALIDADE_HAS_VECTORS)
#pragma GCC diagnostic ignored "-Wpsabi"  // vectors are passed only to inlined functions
#endif

namespace alidade {
namespace {

#if defined(ALIDADE_HAS_VECTORS)
constexpr std::size_t kNumLanes = 8;
using Lanes = float __attribute__((vector_size(32)));
using IntLanes = std::int32_t __attribute__((vector_size(32)));
#else
constexpr std::size_t kNumLanes = 1;
using Lanes = float;
using IntLanes = std::int32_t;
#endif

constexpr std::size_t kChunk =
    128;  // pixels, a multiple of kNumLanes; the columns of one chunk stay in the L1 cache
constexpr std::size_t kNumColumns = EdgeModel::kNumParameters + 1;  // the derivatives and the residual
constexpr std::size_t kNumSums = kNumColumns * (kNumColumns + 1) / 2;
constexpr std::size_t kVectorsPerChunk = kChunk / kNumLanes;
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

struct FloatModel {
  explicit FloatModel(const EdgeModel& m)
      : x(f(m[EdgeModel::kX])),
        y(f(m[EdgeModel::kY])),
        cos1(f(std::cos(m[EdgeModel::kAngle1]))),
        sin1(f(std::sin(m[EdgeModel::kAngle1]))),
        cos2(f(std::cos(m[EdgeModel::kAngle2]))),
        sin2(f(std::sin(m[EdgeModel::kAngle2]))),
        k1(f(m[EdgeModel::kCurvature1])),
        k2(f(m[EdgeModel::kCurvature2])),
        sharp1(f(1 / m[EdgeModel::kBlur1])),
        sharp2(f(1 / m[EdgeModel::kBlur2])),
        mean(f(m[EdgeModel::kMean])),
        amplitude(f(m[EdgeModel::kAmplitude])),
        tone(f(m[EdgeModel::kTone])),
        shade_x(f(m[EdgeModel::kShadeX])),
        shade_y(f(m[EdgeModel::kShadeY])) {}
  static float f(double value) { return static_cast<float>(value); }

  float x, y, cos1, sin1, cos2, sin2, k1, k2, sharp1, sharp2, mean, amplitude, tone, shade_x, shade_y;
};

// One vector of pixels under the model.
struct Evaluated {
  Lanes u1, v1, z1, slope1;
  Lanes u2, v2, z2, slope2;
  Lanes pattern, tone, shade, residual;
};

ALIDADE_ALWAYS_INLINE void evaluate(const FloatModel& m, const Lanes& x, const Lanes& y, const Lanes& grey,
                                    Evaluated& e) {
  const Lanes dx = x - m.x;
  const Lanes dy = y - m.y;
  e.u1 = dx * m.cos1 + dy * m.sin1;
  e.v1 = dy * m.cos1 - dx * m.sin1;
  e.u2 = dx * m.cos2 + dy * m.sin2;
  e.v2 = dy * m.cos2 - dx * m.sin2;
  e.z1 = (e.v1 - e.u1 * e.u1 * (0.5F * m.k1)) * m.sharp1;
  e.z2 = (e.v2 - e.u2 * e.u2 * (0.5F * m.k2)) * m.sharp2;
  Lanes profile1, profile2, steep1, steep2;
  edgeProfile(e.z1, profile1, steep1);
  edgeProfile(e.z2, profile2, steep2);
  e.pattern = profile1 * profile2;
  e.shade = x * m.shade_x + y * m.shade_y + 1.0F;
  e.tone = e.pattern * m.amplitude + (1.0F - e.pattern * e.pattern) * m.tone + m.mean;
  e.residual = grey - e.shade * e.tone;
  const Lanes by_pattern = e.shade * (m.amplitude - e.pattern * (2.0F * m.tone));
  e.slope1 = by_pattern * profile2 * steep1 * m.sharp1;
  e.slope2 = by_pattern * profile1 * steep2 * m.sharp2;
}

using Columns = Lanes[kNumColumns][kVectorsPerChunk];

ALIDADE_ALWAYS_INLINE void fillColumns(const FloatModel& m, const float* px, const float* py,
                                       const float* grey, std::size_t vector, Columns& columns) {
  const std::size_t at = vector * kNumLanes;
  const Lanes x = load(px + at);
  const Lanes y = load(py + at);
  Evaluated e;
  evaluate(m, x, y, load(grey + at), e);
  const Lanes bend1 = e.u1 * m.k1;
  const Lanes bend2 = e.u2 * m.k2;
  columns[EdgeModel::kX][vector] =
      e.slope1 * (bend1 * m.cos1 + m.sin1) + e.slope2 * (bend2 * m.cos2 + m.sin2);
  columns[EdgeModel::kY][vector] =
      e.slope1 * (bend1 * m.sin1 - m.cos1) + e.slope2 * (bend2 * m.sin2 - m.cos2);
  columns[EdgeModel::kAngle1][vector] = -e.slope1 * (e.u1 + bend1 * e.v1);
  columns[EdgeModel::kAngle2][vector] = -e.slope2 * (e.u2 + bend2 * e.v2);
  columns[EdgeModel::kCurvature1][vector] = e.slope1 * e.u1 * e.u1 * -0.5F;
  columns[EdgeModel::kCurvature2][vector] = e.slope2 * e.u2 * e.u2 * -0.5F;
  columns[EdgeModel::kBlur1][vector] = -e.slope1 * e.z1;
  columns[EdgeModel::kBlur2][vector] = -e.slope2 * e.z2;
  columns[EdgeModel::kMean][vector] = e.shade;
  columns[EdgeModel::kAmplitude][vector] = e.shade * e.pattern;
  columns[EdgeModel::kTone][vector] = e.shade * (1.0F - e.pattern * e.pattern);
  columns[EdgeModel::kShadeX][vector] = e.tone * x;
  columns[EdgeModel::kShadeY][vector] = e.tone * y;
  columns[EdgeModel::kNumParameters][vector] = e.residual;
}

// Adds the products of column I with columns 0 to I.
template <std::size_t I>
ALIDADE_ALWAYS_INLINE void addProducts(const Columns& columns, std::size_t num_vectors, Lanes* sums) {
  Lanes sum[I + 1];
  for (std::size_t j = 0; j <= I; ++j) sum[j] = sums[I * (I + 1) / 2 + j];
  for (std::size_t vector = 0; vector < num_vectors; ++vector) {
    const Lanes factor = columns[I][vector];
    for (std::size_t j = 0; j <= I; ++j) sum[j] += factor * columns[j][vector];
  }
  for (std::size_t j = 0; j <= I; ++j) sums[I * (I + 1) / 2 + j] = sum[j];
}

template <std::size_t... I>
ALIDADE_ALWAYS_INLINE void addAllProducts(const Columns& columns, std::size_t num_vectors, Lanes* sums,
                                          std::index_sequence<I...>) {
  (addProducts<I>(columns, num_vectors, sums), ...);
}

ALIDADE_ALWAYS_INLINE void sumAll(const EdgePixels& pixels, const EdgeModel& model, double* totals) {
  const FloatModel m(model);
  Lanes sums[kNumSums] = {};
  Columns columns;
  for (std::size_t begin = 0; begin < pixels.size(); begin += kChunk) {
    const float* x = pixels.x() + begin;
    const float* y = pixels.y() + begin;
    const float* grey = pixels.grey() + begin;
    const std::size_t count = std::min(kChunk, pixels.size() - begin);
    const std::size_t num_vectors = (count + kNumLanes - 1) / kNumLanes;
    for (std::size_t vector = 0; vector < num_vectors; ++vector) fillColumns(m, x, y, grey, vector, columns);
    // Lanes of the last vector beyond the last pixel must not count.
    for (auto& column : columns) {
      std::memset(reinterpret_cast<char*>(column) + count * sizeof(float), 0,
                  (num_vectors * kNumLanes - count) * sizeof(float));
    }
    addAllProducts(columns, num_vectors, sums, std::make_index_sequence<kNumColumns>());
  }
  for (std::size_t i = 0; i < kNumSums; ++i) {
    float lanes[kNumLanes];
    store(sums[i], lanes);
    totals[i] = 0;
    for (const float lane : lanes) totals[i] += lane;
  }
}

ALIDADE_ALWAYS_INLINE void evaluateAll(const EdgePixels& pixels, const EdgeModel& model, EdgeResiduals& out) {
  const FloatModel m(model);
  for (std::size_t at = 0; at < pixels.size(); at += kNumLanes) {
    Evaluated e;
    evaluate(m, load(pixels.x() + at), load(pixels.y() + at), load(pixels.grey() + at), e);
    store(e.residual, out.residual.data() + at);
    store(e.slope1, out.slope1.data() + at);
    store(e.slope2, out.slope2.data() + at);
    store(e.pattern, out.pattern.data() + at);
  }
}

}  // namespace

void EdgePixels::grow() {
  const std::size_t size = x_.empty() ? 8 * kChunk : 2 * x_.size();  // whole chunks
  x_.resize(size);
  y_.resize(size);
  grey_.resize(size);
}

void sumNormalEquations(const EdgePixels& pixels, const EdgeModel& model, NormalEquations& sums) {
  double totals[kNumSums];
  callVectorised([&]() ALIDADE_INLINE_LAMBDA { sumAll(pixels, model, totals); });
  const double* total = totals;
  for (int i = 0; i < NormalEquations::kSize; ++i) {
    for (int j = 0; j <= i; ++j) sums.hessian(i, j) = sums.hessian(j, i) = *total++;
  }
  for (int i = 0; i < NormalEquations::kSize; ++i) sums.gradient(i) = *total++;
  sums.cost = *total;
}

void evaluateResiduals(const EdgePixels& pixels, const EdgeModel& model, EdgeResiduals& residuals) {
  const std::size_t size = (pixels.size() + kNumLanes - 1) / kNumLanes * kNumLanes;
  if (residuals.residual.size() < size) {
    for (auto* column : {&residuals.residual, &residuals.slope1, &residuals.slope2, &residuals.pattern})
      column->resize(size);
  }
  callVectorised([&]() ALIDADE_INLINE_LAMBDA { evaluateAll(pixels, model, residuals); });
}

}  // namespace alidade
