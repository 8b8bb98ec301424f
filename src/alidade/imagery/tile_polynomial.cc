// SPDX-License-Identifier: MIT
#include "alidade/imagery/tile_polynomial.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <numbers>

#include <Eigen/LU>

#include "alidade/core/error.h"
#include "alidade/core/vector_code.h"

#if defined(ALIDADE_HAS_VECTORS)
#pragma GCC diagnostic ignored "-Wpsabi"  // vectors cross no call that is not inlined
#endif

namespace alidade {
namespace {

constexpr std::size_t kN = TilePolynomial::kNumNodes;
using Matrix = Eigen::Matrix<double, kN, kN, Eigen::RowMajor>;

// The vectors of the loop over pixels: x and y of some pixels one after another, as the table has them.
#if defined(ALIDADE_HAS_VECTORS)
using Doubles4 = double __attribute__((vector_size(32)));
struct Lanes8 {
  using Floats = float __attribute__((vector_size(32)));
  using Pairs = std::int64_t __attribute__((vector_size(32)));
};

// One x and y over and over.
template <class L>
ALIDADE_ALWAYS_INLINE typename L::Floats repeat(const float* pair) {
  std::int64_t bits = 0;
  std::memcpy(&bits, pair, sizeof bits);
  const typename L::Pairs pairs = typename L::Pairs{} + bits;
  typename L::Floats result;
  std::memcpy(&result, &pairs, sizeof result);
  return result;
}
#else
using Doubles4 = Eigen::Array<double, 4, 1>;
struct Lanes8 {
  using Floats = Eigen::Array<float, 2, 1>;
};

template <class L>
typename L::Floats repeat(const float* pair) {
  return {pair[0], pair[1]};
}
#endif

// Powers of the places, one row a place.
Matrix powersAt(const std::array<double, kN>& places) {
  Matrix powers;
  for (std::size_t i = 0; i < kN; ++i) {
    double power = 1;
    for (std::size_t k = 0; k < kN; ++k, power *= places[i])
      powers(static_cast<Eigen::Index>(i), static_cast<Eigen::Index>(k)) = power;
  }
  return powers;
}

// What the loop over pixels is given.
struct Rows {
  const double* coefficients;
  int width;
  int height;
  float* out;
  std::ptrdiff_t stride;  // in floats
};

// x and y of a row's coefficients: the nearest floats to the values at its middle, what those leave, and the
// coefficients of the powers 1 to 5 of the distance from there in pixels.
using RowFloats = std::array<float, 2 * (kN + 1)>;

ALIDADE_ALWAYS_INLINE void makeRow(const double* coefficients, const double* scales, double t,
                                   RowFloats& row) {
  constexpr std::size_t kStep = 4;
  static_assert(2 * kN % kStep == 0);
  double c[2 * kN];
  for (std::size_t i = 0; i < 2 * kN; i += kStep) {
    Doubles4 sum, next;
    std::memcpy(&sum, coefficients + 2 * kN * (kN - 1) + i, sizeof sum);
    for (std::size_t j = kN - 1; j-- > 0;) {
      std::memcpy(&next, coefficients + 2 * kN * j + i, sizeof next);
      sum = sum * t + next;
    }
    std::memcpy(&next, scales + i, sizeof next);
    sum = sum * next;
    std::memcpy(c + i, &sum, sizeof sum);
  }
  for (std::size_t i = 0; i < 2; ++i) {
    row[i] = static_cast<float>(c[i]);
    c[i] -= row[i];
  }
  for (std::size_t i = 0; i < 2 * kN; ++i) row[2 + i] = static_cast<float>(c[i]);
}

template <class L>
ALIDADE_ALWAYS_INLINE void writeRow(const RowFloats& row, const typename L::Floats& begin, int width,
                                    float* out) {
  using V = typename L::Floats;
  constexpr int kPixels = sizeof(V) / (2 * sizeof(float));
  static_assert(kPixels >= 1 && kPixels <= TilePolynomial::kMinSide);
  const V base = repeat<L>(row.data());
  const V c0 = repeat<L>(row.data() + 2);
  const V c1 = repeat<L>(row.data() + 4);
  const V c2 = repeat<L>(row.data() + 6);
  const V c3 = repeat<L>(row.data() + 8);
  const V c4 = repeat<L>(row.data() + 10);
  const V c5 = repeat<L>(row.data() + 12);
  const int last = width - kPixels;
  V u = begin;
  for (int x = 0; x < last; x += kPixels, u = u + static_cast<float>(kPixels)) {
    const V value = base + (((((c5 * u + c4) * u + c3) * u + c2) * u + c1) * u + c0);
    std::memcpy(out + 2 * x, &value, sizeof value);
  }
  // The last vector ends with the row and may overlap the one before: the same values once more.
  u = begin + static_cast<float>(last);
  const V value = base + (((((c5 * u + c4) * u + c3) * u + c2) * u + c1) * u + c0);
  std::memcpy(out + 2 * last, &value, sizeof value);
}

template <class L>
ALIDADE_ALWAYS_INLINE void writeRows(const Rows& rows) {
  constexpr std::size_t kNumFloats = sizeof(typename L::Floats) / sizeof(float);
  constexpr int kBatch = 16;  // rows whose coefficients are made before they are used
  const double half_width = 0.5 * (rows.width - 1);
  const double half_height = 0.5 * (rows.height - 1);
  double scales[2 * kN];
  for (std::size_t i = 0; i < 2 * kN; ++i) scales[i] = i < 2 ? 1 : scales[i - 2] / half_width;
  float distances[kNumFloats];
  for (std::size_t i = 0; i < kNumFloats; ++i)
    distances[i] = static_cast<float>(static_cast<double>(i / 2) - half_width);  // exact
  typename L::Floats begin;
  std::memcpy(&begin, distances, sizeof begin);
  std::array<RowFloats, kBatch> batch;
  for (int y = 0; y < rows.height; y += kBatch) {
    const int count = std::min(kBatch, rows.height - y);
    for (int i = 0; i < count; ++i)
      makeRow(rows.coefficients, scales, (y + i - half_height) / half_height,
              batch[static_cast<std::size_t>(i)]);
    for (int i = 0; i < count; ++i)
      writeRow<L>(batch[static_cast<std::size_t>(i)], begin, rows.width, rows.out + (y + i) * rows.stride);
  }
}

struct Places {
  const double* s;
  const double* t;
  std::size_t count;
  double* x;
  double* y;
};

ALIDADE_ALWAYS_INLINE void evaluateAll(const double* coefficients, const Places& places) {
  constexpr std::size_t kStep = TilePolynomial::kGroup;
  for (std::size_t at = 0; at < places.count; at += kStep) {
    Doubles4 s, t;
    std::memcpy(&s, places.s + at, sizeof s);
    std::memcpy(&t, places.t + at, sizeof t);
    Doubles4 x = s * 0.0, y = x;
    for (std::size_t j = kN; j-- > 0;) {
      const double* c = coefficients + 2 * kN * j;
      Doubles4 row_x = s * c[2 * kN - 2] + c[2 * kN - 4];
      Doubles4 row_y = s * c[2 * kN - 1] + c[2 * kN - 3];
      for (std::size_t i = kN - 2; i-- > 0;) {
        row_x = row_x * s + c[2 * i];
        row_y = row_y * s + c[2 * i + 1];
      }
      x = x * t + row_x;
      y = y * t + row_y;
    }
    std::memcpy(places.x + at, &x, sizeof x);
    std::memcpy(places.y + at, &y, sizeof y);
  }
}

#if defined(ALIDADE_HAS_AVX2_VARIANT)
ALIDADE_TARGET_AVX2 void evaluateAllAvx2(const double* coefficients, const Places& places) {
  evaluateAll(coefficients, places);
}

ALIDADE_TARGET_AVX2 void writeRowsAvx2(const Rows& rows) {
  writeRows<Lanes8>(rows);
}
#endif

void writeRowsAnywhere(const Rows& rows) {
#if defined(ALIDADE_HAS_AVX2_VARIANT)
  if (hasAvx2()) return writeRowsAvx2(rows);
#endif
  writeRows<Lanes8>(rows);
}

}  // namespace

const std::array<double, kN>& TilePolynomial::nodes() {
  static const std::array<double, kN> places = [] {
    std::array<double, kN> result{};
    for (std::size_t i = 0; i < kN; ++i)
      result[i] = -std::cos(std::numbers::pi * static_cast<double>(i) / (kN - 1));
    result.front() = -1;
    result.back() = 1;
    return result;
  }();
  return places;
}

const std::array<double, kN - 1>& TilePolynomial::middles() {
  static const std::array<double, kN - 1> places = [] {
    std::array<double, kN - 1> result{};
    for (std::size_t i = 0; i + 1 < kN; ++i)
      result[i] = -std::cos(std::numbers::pi * (static_cast<double>(i) + 0.5) / (kN - 1));
    return result;
  }();
  return places;
}

TilePolynomial::TilePolynomial(std::span<const Eigen::Vector2d> values) {
  static const Matrix from_values = powersAt(nodes()).inverse();
  for (Eigen::Index c = 0; c < 2; ++c) {
    Matrix grid;
    for (Eigen::Index i = 0; i < grid.size(); ++i) grid.data()[i] = values[static_cast<std::size_t>(i)][c];
    const Matrix coefficients = from_values * grid * from_values.transpose();
    for (Eigen::Index i = 0; i < grid.size(); ++i)
      coefficients_[static_cast<std::size_t>(2 * i + c)] = coefficients.data()[i];
  }
}

void TilePolynomial::evaluate(std::span<const double> s, std::span<const double> t, double* x,
                              double* y) const {
  expect(s.size() == t.size() && s.size() % kGroup == 0, "places come in whole groups");
  const Places places{s.data(), t.data(), s.size(), x, y};
#if defined(ALIDADE_HAS_AVX2_VARIANT)
  if (hasAvx2()) return evaluateAllAvx2(coefficients_.data(), places);
#endif
  evaluateAll(coefficients_.data(), places);
}

Eigen::Vector2d TilePolynomial::spread() const {
  Eigen::Vector2d sum = Eigen::Vector2d::Zero();
  for (std::size_t i = 2; i < coefficients_.size(); i += 2)
    sum += Eigen::Vector2d(std::abs(coefficients_[i]), std::abs(coefficients_[i + 1]));
  return sum;
}

void TilePolynomial::write(int width, int height, SourcePixel* out, std::ptrdiff_t stride) const {
  static_assert(sizeof(SourcePixel) == 2 * sizeof(float) && offsetof(SourcePixel, y) == sizeof(float));
  expect(width >= kMinSide && height >= kMinSide, "a tile has the least size of a polynomial");
  writeRowsAnywhere({coefficients_.data(), width, height, &out->x, 2 * stride});
}

}  // namespace alidade
