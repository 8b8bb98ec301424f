// SPDX-License-Identifier: MIT
#include "alidade/detect/corner/disc_model.h"

#include <cmath>
#include <cstddef>

#include "alidade/detect/corner/edge_lanes.h"

namespace alidade {
namespace {

using lanes::kNumLanes;
using lanes::Lanes;
using lanes::load;
using lanes::store;

constexpr std::size_t kNumColumns = DiscModel::kNumParameters + 1;  // the derivatives and the residual

struct FloatDisc {
  explicit FloatDisc(const DiscModel& m)
      : x(f(m[DiscModel::kX])),
        y(f(m[DiscModel::kY])),
        xx(f(m[DiscModel::kShapeXX])),
        xy(f(m[DiscModel::kShapeXY])),
        yy(f(m[DiscModel::kShapeYY])),
        sharp(f(1 / m[DiscModel::kBlur])),
        mean(f(m[DiscModel::kMean])),
        amplitude(f(m[DiscModel::kAmplitude])),
        shade_x(f(m[DiscModel::kShadeX])),
        shade_y(f(m[DiscModel::kShadeY])) {}
  static float f(double value) { return static_cast<float>(value); }

  float x, y, xx, xy, yy, sharp, mean, amplitude, shade_x, shade_y;
};

// One vector of pixels under the model.
struct RimValues {
  Lanes dx, dy, normal_x, normal_y, by_norm, z, pattern, shade, tone, slope, residual;
};

ALIDADE_ALWAYS_INLINE Lanes squareRoot(const Lanes& square) {
  float values[kNumLanes];
  store(square, values);
  for (float& value : values) value = std::sqrt(value);
  return load(values);
}

ALIDADE_ALWAYS_INLINE void evaluateRim(const FloatDisc& m, const Lanes& x, const Lanes& y, const Lanes& grey,
                                       RimValues& at) {
  at.dx = x - m.x;
  at.dy = y - m.y;
  at.normal_x = at.dx * m.xx + at.dy * m.xy;
  at.normal_y = at.dx * m.xy + at.dy * m.yy;
  const Lanes square = at.dx * at.normal_x + at.dy * at.normal_y;
  at.by_norm = 1.0F / (squareRoot(at.normal_x * at.normal_x + at.normal_y * at.normal_y) + 1e-12F);
  at.z = (square - squareRoot(square)) * at.by_norm * m.sharp;
  Lanes steep;
  lanes::edgeProfile(at.z, at.pattern, steep);
  at.shade = x * m.shade_x + y * m.shade_y + 1.0F;
  at.tone = at.pattern * m.amplitude + m.mean;
  at.slope = at.shade * steep * (m.amplitude * m.sharp);
  at.residual = grey - at.shade * at.tone;
}

ALIDADE_ALWAYS_INLINE void fillRimColumns(const FloatDisc& m, const Lanes& x, const Lanes& y,
                                          const Lanes& grey, lanes::Columns<kNumColumns>& columns,
                                          std::size_t vector) {
  RimValues at;
  evaluateRim(m, x, y, grey, at);
  const Lanes outwards = at.slope * at.by_norm;
  columns[DiscModel::kX][vector] = -outwards * at.normal_x;
  columns[DiscModel::kY][vector] = -outwards * at.normal_y;
  columns[DiscModel::kShapeXX][vector] = outwards * at.dx * at.dx * 0.5F;
  columns[DiscModel::kShapeXY][vector] = outwards * at.dx * at.dy;
  columns[DiscModel::kShapeYY][vector] = outwards * at.dy * at.dy * 0.5F;
  columns[DiscModel::kBlur][vector] = -at.slope * at.z;
  columns[DiscModel::kMean][vector] = at.shade;
  columns[DiscModel::kAmplitude][vector] = at.shade * at.pattern;
  columns[DiscModel::kShadeX][vector] = at.tone * x;
  columns[DiscModel::kShadeY][vector] = at.tone * y;
  columns[DiscModel::kNumParameters][vector] = at.residual;
}

}  // namespace

void sumNormalEquations(const EdgePixels& pixels, const DiscModel& model, DiscSums& sums) {
  const FloatDisc m(model);
  lanes::sumEquations(
      pixels,
      [&](const Lanes& x, const Lanes& y, const Lanes& grey, lanes::Columns<kNumColumns>& columns,
          std::size_t vector) ALIDADE_INLINE_LAMBDA { fillRimColumns(m, x, y, grey, columns, vector); },
      sums);
}

void evaluateResiduals(const EdgePixels& pixels, const DiscModel& model, DiscResiduals& residuals) {
  lanes::holdPixels(pixels, residuals.residual, residuals.slope, residuals.pattern);
  const FloatDisc m(model);
  callVectorised([&]() ALIDADE_INLINE_LAMBDA {
    for (std::size_t i = 0; i < pixels.size(); i += kNumLanes) {
      RimValues at;
      evaluateRim(m, load(pixels.x() + i), load(pixels.y() + i), load(pixels.grey() + i), at);
      store(at.residual, residuals.residual.data() + i);
      store(at.slope, residuals.slope.data() + i);
      store(at.pattern, residuals.pattern.data() + i);
    }
  });
}

}  // namespace alidade
