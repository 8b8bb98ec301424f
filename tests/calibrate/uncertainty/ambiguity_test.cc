// SPDX-License-Identifier: MIT
#include <algorithm>
#include <cmath>
#include <cstdint>
#include <vector>

#include <gtest/gtest.h>

#include "alidade/adjust/board/errors.h"
#include "alidade/calibrate/uncertainty/other_optima.h"
#include "support/simulated_set.h"
#include "support/verdict_case.h"

namespace alidade {
namespace {

SimulatedSet fewDoubleSphereViews(std::uint64_t seed, int num_views) {
  const AnyCamera camera =
      AnyCamera::make("double_sphere", std::vector<double>{180, 181, 322, 238, -0.2, 0.6});
  return simulateSet(camera, {640, 480}, num_views, 0.1, seed,
                     {.max_tilt_deg = 50, .max_roll_deg = 30, .min_fill = 0.3, .max_fill = 0.8});
}

const Diagnosis* ambiguity(const Calibration& result) {
  const auto found = std::find_if(result.diagnoses.begin(), result.diagnoses.end(),
                                  [](const Diagnosis& f) { return f.id == "ambiguous_optimum"; });
  return found == result.diagnoses.end() ? nullptr : &*found;
}

// Views that leave the border of a wide image to the model: xi above and below zero explain them alike.
TEST(Ambiguity, IsNamedWhereTwoCamerasExplainTheCorners) {
  int num_named = 0;
  int num_astray = 0;
  int num_sets = 0;
  for (std::uint64_t seed = 0; seed < 30; ++seed) {
    SCOPED_TRACE(seed);
    const SimulatedSet set = fewDoubleSphereViews(seed, 5);
    const Calibration result = calibrate(set.board, set.views, {.model = "double_sphere"});
    ++num_sets;
    const Diagnosis* finding = ambiguity(result);
    EXPECT_EQ(finding != nullptr, !result.uncertainty.other_optima.empty());
    // The other side of xi = 0, by sigmas that do not reach there.
    const double off = std::abs(onlyCamera(result.fit).params[4] - set.camera.parameters()[4]);
    const bool is_astray = off > 0.3 && off > 6 * result.uncertainty.parameterStd(4);
    num_astray += is_astray ? 1 : 0;
    EXPECT_TRUE(!is_astray || finding != nullptr) << off;
    if (finding == nullptr) continue;
    ++num_named;
    EXPECT_EQ(finding->severity, severityOf(finding->effect_px, 1));
    EXPECT_TRUE(!is_astray || result.verdict() != Verdict::kTrustworthy);
    EXPECT_NE(finding->evidence.find("fx "), std::string::npos) << finding->evidence;
    EXPECT_NE(finding->evidence.find("RMS "), std::string::npos) << finding->evidence;
    const OtherOptimum& other = result.uncertainty.other_optima.front();
    EXPECT_GT(other.sigmas, 3);
    EXPECT_LT(other.excess_chi2, kNoiseChi2);
    EXPECT_GT(other.projection_px, 0);
    EXPECT_NEAR(other.rms_px, weightedRms(result.fit), 0.02 * weightedRms(result.fit));
    if (!is_astray) continue;
    EXPECT_NEAR(other.params[4], set.camera.parameters()[4], 0.1) << "the other one is the true one";
  }
  EXPECT_EQ(num_sets, 30);
  EXPECT_GE(num_named, 10);
  EXPECT_GE(num_astray, 3);
}

TEST(Ambiguity, IsNotSeenInOrdinarySets) {
  int num_sets = 0;
  for (const char* model : {"radtan", "kannala_brandt"}) {
    for (std::uint64_t number = 0; number < 5; ++number) {
      const VerdictCase c = makeVerdictCase(Flaw::kNone, model, number);
      const Calibration result = calibrate(c.set.board, c.set.views, c.options);
      EXPECT_EQ(ambiguity(result), nullptr) << model << " " << number;
      EXPECT_TRUE(result.uncertainty.other_optima.empty()) << model << " " << number;
      ++num_sets;
    }
  }
  EXPECT_EQ(num_sets, 10);
}

// With views enough the second optimum costs more than noise makes.
TEST(Ambiguity, GoesWithViews) {
  int num_sets = 0;
  for (std::uint64_t seed = 0; seed < 5; ++seed) {
    const SimulatedSet set = fewDoubleSphereViews(seed, 40);
    const Calibration result = calibrate(set.board, set.views, {.model = "double_sphere"});
    EXPECT_EQ(ambiguity(result), nullptr) << seed;
    EXPECT_NEAR(onlyCamera(result.fit).params[4], -0.2, 0.1) << seed;
    ++num_sets;
  }
  EXPECT_EQ(num_sets, 5);
}

}  // namespace
}  // namespace alidade
