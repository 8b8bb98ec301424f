// SPDX-License-Identifier: MIT
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <string>
#include <vector>

#include "alidade/calibrate/calibrator.h"
#include "support/choice_sweep.h"

namespace alidade {
namespace {

constexpr const char* kStepModels[] = {"radtan", "kannala_brandt"};
constexpr std::size_t kNumStepSets = 20;  // of each model
constexpr int kNumStepViews = 20;

// A set whose focal length is `factor` times as long in the second half.
ChoiceSet zoomedSet(const char* model, std::size_t number, double factor) {
  ChoiceSet set = drawChoiceSet(model, 31, number, kNumStepViews);
  DrawnCamera zoomed = set.drawn;
  std::vector<double> params(set.drawn.camera.parameters().begin(), set.drawn.camera.parameters().end());
  params[0] *= factor;
  params[1] *= factor;
  zoomed.camera = AnyCamera::make(model, params);
  Random random(streamSeed(32, number));
  std::vector<View>& views = set.set.views;
  views.resize(kNumStepViews / 2);
  for (View& view : drawUserViews(zoomed, kNumStepViews / 2, 0.1, random).views)
    views.push_back(std::move(view));
  for (std::size_t v = 0; v < views.size(); ++v) views[v].image = "view_" + std::to_string(v);
  return set;
}

// The variation between single views, of whatever order, is mostly too small for its own test.
TEST(FocalStep, OfAThousandthIsNamedWithItsFirstView) {
  std::size_t num_named = 0;
  std::size_t num_by_step = 0;
  std::size_t num_within_a_fifth = 0;
  std::size_t num_at_the_view = 0;
  for (const char* model : kStepModels) {
    for (std::size_t i = 0; i < kNumStepSets; ++i) {
      const ChoiceSet set = zoomedSet(model, i, 1.001);
      const Calibration result = calibrate(set.set.board, set.set.views, {.model = model});
      num_named += hasFinding(result, "focal_changed") || hasFinding(result, "two_cameras") ? 1 : 0;
      const auto named = std::ranges::find(result.diagnoses, "focal_changed", &Diagnosis::id);
      if (named == result.diagnoses.end() || named->evidence.find(" from view_") == std::string::npos)
        continue;
      ++num_by_step;
      const FocalStep& step = result.uncertainty.focal_step.value();
      num_within_a_fifth += std::abs(step.share - 0.001) < 2e-4 ? 1 : 0;
      num_at_the_view += std::abs(static_cast<int>(step.first_view) - kNumStepViews / 2) <= 2 ? 1 : 0;
    }
  }
  EXPECT_GE(num_named, 14u);  // of 40; at most 9 without the step
  EXPECT_GE(num_by_step, 5u);
  EXPECT_GE(num_within_a_fifth, 4u);
  EXPECT_GE(num_at_the_view, 5u);
}

TEST(FocalStep, IsNotSeenInSoundSets) {
  std::size_t num_seen = 0;
  std::size_t num_sets = 0;
  for (const char* model : kStepModels) {
    for (std::size_t i = 0; i < 2 * kNumStepSets; ++i) {
      const ChoiceSet set = drawChoiceSet(model, 33, i, kNumStepViews);
      const Calibration result = calibrate(set.set.board, set.set.views, {.model = model});
      ASSERT_TRUE(result.uncertainty.focal_step);
      ++num_sets;
      num_seen += result.uncertainty.focal_step->sigmas > 4 ? 1 : 0;
    }
  }
  EXPECT_EQ(num_sets, 4 * kNumStepSets);
  EXPECT_EQ(num_seen, 0u);
}

}  // namespace
}  // namespace alidade
