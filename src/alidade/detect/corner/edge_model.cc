// SPDX-License-Identifier: MIT
#include "alidade/detect/corner/edge_model.h"

#include <cstddef>

#include "alidade/detect/corner/edge_lanes.h"

namespace alidade {
namespace {

using lanes::kNumLanes;
using lanes::Lanes;
using lanes::load;
using lanes::store;

constexpr std::size_t kNumColumns = EdgeModel::kNumParameters + 1;  // the derivatives and the residual

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
  lanes::edgeProfile(e.z1, profile1, steep1);
  lanes::edgeProfile(e.z2, profile2, steep2);
  e.pattern = profile1 * profile2;
  e.shade = x * m.shade_x + y * m.shade_y + 1.0F;
  e.tone = e.pattern * m.amplitude + (1.0F - e.pattern * e.pattern) * m.tone + m.mean;
  e.residual = grey - e.shade * e.tone;
  const Lanes by_pattern = e.shade * (m.amplitude - e.pattern * (2.0F * m.tone));
  e.slope1 = by_pattern * profile2 * steep1 * m.sharp1;
  e.slope2 = by_pattern * profile1 * steep2 * m.sharp2;
}

ALIDADE_ALWAYS_INLINE void fillColumns(const FloatModel& m, const Lanes& x, const Lanes& y, const Lanes& grey,
                                       lanes::Columns<kNumColumns>& columns, std::size_t vector) {
  Evaluated e;
  evaluate(m, x, y, grey, e);
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

void sumNormalEquations(const EdgePixels& pixels, const EdgeModel& model, EdgeSums& sums) {
  const FloatModel m(model);
  lanes::sumEquations(
      pixels,
      [&](const Lanes& x, const Lanes& y, const Lanes& grey, lanes::Columns<kNumColumns>& columns,
          std::size_t vector) ALIDADE_INLINE_LAMBDA { fillColumns(m, x, y, grey, columns, vector); },
      sums);
}

void evaluateResiduals(const EdgePixels& pixels, const EdgeModel& model, EdgeResiduals& residuals) {
  lanes::holdPixels(pixels, residuals.residual, residuals.slope1, residuals.slope2, residuals.pattern);
  callVectorised([&]() ALIDADE_INLINE_LAMBDA { evaluateAll(pixels, model, residuals); });
}

}  // namespace alidade
