// SPDX-License-Identifier: MIT
#include <gmock/gmock.h>

#include <algorithm>
#include <string>

#include "alidade/adjust/noise/robust_weighting.h"
#include "alidade/calibrate/calibrator.h"
#include "alidade/calibrate/choose/model_solution.h"
#include "alidade/calibrate/clean/outliers.h"
#include "alidade/calibrate/start/prepared_views.h"
#include "support/spoiled_set.h"

namespace alidade {
namespace {

constexpr int kNumViews = 25;
constexpr int kNumBad = 3;
constexpr std::uint64_t kNumSeeds = 2;
constexpr const char* kModels[] = {"radtan", "kannala_brandt"};

Calibration run(const SimulatedSet& set) {
  return calibrate(set.board, set.views, {.model = std::string(set.camera.modelId())});
}

std::vector<std::string> findingIds(const Calibration& result) {
  std::vector<std::string> ids;
  for (const Diagnosis& finding : result.diagnoses) ids.emplace_back(finding.id);
  return ids;
}

void expectNear(const Calibration& result, const Calibration& clean) {
  for (std::size_t i = 0; i < onlyCamera(clean.fit).params.size(); ++i) {
    EXPECT_NEAR(onlyCamera(result.fit).params[i], onlyCamera(clean.fit).params[i],
                3 * clean.uncertainty.parameterStdByNoise(static_cast<int>(i)))
        << clean.camera().parameterNames()[i];
  }
}

TEST(ForeignViews, AreLeftOutWithAReasonThatFits) {
  const std::pair<Spoiler, const char*> cases[] = {{Spoiler::kColumnsFirst, "column by column"},
                                                   {Spoiler::kShifted, "one column back"},
                                                   {Spoiler::kBent, "displaced together"},
                                                   {Spoiler::kOtherCamera, "focal lengths 1."}};
  int num_checked = 0;
  for (const char* model : kModels) {
    for (const auto& [spoiler, reason] : cases) {
      for (std::uint64_t seed = 1; seed <= kNumSeeds; ++seed) {
        SCOPED_TRACE(std::string(model) + " " + std::string(spoilerName(spoiler)) + " " +
                     std::to_string(seed));
        SimulatedSet set = cleanSet(model, kNumViews, seed);
        const Calibration clean = run(set);
        EXPECT_THAT(clean.diagnoses, testing::IsEmpty());
        const auto bad = spoilViews(set, spoiler, kNumBad, seed);
        const Calibration result = run(set);
        EXPECT_TRUE(result.isUsable());
        std::vector<std::string> named;
        for (const ExcludedView& view : result.dropped.views) {
          named.push_back(view.image);
          EXPECT_THAT(view.reason, testing::HasSubstr(reason)) << view.image;
        }
        EXPECT_THAT(named, testing::UnorderedElementsAreArray(bad));
        EXPECT_EQ(result.dropped.numMisfits(), static_cast<std::size_t>(kNumBad));
        EXPECT_TRUE(result.dropped.outliers.empty());
        expectNear(result, clean);
        ++num_checked;
      }
    }
  }
  EXPECT_EQ(num_checked, 16);
}

// The distance makes up for another size of the squares, a turn for numbering from the other end.
TEST(ForeignViews, WhatThePoseMakesUpForIsNeitherSeenNorHarmful) {
  int num_checked = 0;
  for (const char* model : kModels) {
    for (const Spoiler spoiler : {Spoiler::kLargerSquares, Spoiler::kTurned}) {
      SimulatedSet set = cleanSet(model, kNumViews, 7);
      const Calibration clean = run(set);
      spoilViews(set, spoiler, kNumBad, 7);
      const Calibration result = run(set);
      EXPECT_THAT(findingIds(result), testing::IsEmpty()) << spoilerName(spoiler);
      EXPECT_EQ(result.fit.views.size(), static_cast<std::size_t>(kNumViews));
      expectNear(result, clean);
      ++num_checked;
    }
  }
  EXPECT_EQ(num_checked, 4);
}

TEST(ForeignViews, MirroredOnesAreNamedAndDoNoHarm) {
  SimulatedSet set = cleanSet("radtan", kNumViews, 4);
  const Calibration clean = run(set);
  const auto bad = spoilViews(set, Spoiler::kMirrored, kNumBad, 4);
  const Calibration result = run(set);
  ASSERT_THAT(findingIds(result), testing::ElementsAre("mirrored_view"));
  EXPECT_EQ(result.diagnoses.front().severity, Severity::kNote);
  for (const std::string& name : bad) EXPECT_THAT(result.diagnoses.front().cause, testing::HasSubstr(name));
  expectNear(result, clean);
}

TEST(ForeignViews, AllMirroredIsOneFinding) {
  SimulatedSet set = cleanSet("radtan", 10, 5);
  spoilViews(set, Spoiler::kMirrored, 10, 5);
  const Calibration result = run(set);
  ASSERT_THAT(findingIds(result), testing::ElementsAre("mirrored_view"));
  EXPECT_EQ(result.diagnoses.front().severity, Severity::kWarning);
}

TEST(ForeignViews, ThreeOfEightAreAtLeastWarnedOf) {
  int num_checked = 0;
  for (const char* model : kModels) {
    for (const Spoiler spoiler :
         {Spoiler::kColumnsFirst, Spoiler::kShifted, Spoiler::kBent, Spoiler::kOtherCamera}) {
      SimulatedSet set = cleanSet(model, 8, 6);
      const auto known = findingIds(run(set));
      spoilViews(set, spoiler, 3, 6);
      const auto ids = findingIds(run(set));
      const auto is_told = [&](const std::string& id) {
        return id != "few_views" && std::find(known.begin(), known.end(), id) == known.end();
      };
      EXPECT_TRUE(std::any_of(ids.begin(), ids.end(), is_told)) << model << " " << spoilerName(spoiler);
      ++num_checked;
    }
  }
  EXPECT_EQ(num_checked, 8);
}

TEST(ForeignViews, NoisyOnesStay) {
  SimulatedSet set = cleanSet("radtan", 15, 8);
  Random random(8);
  addCornerNoise(set.views[4], 0.3, random);  // three times as much, but nothing more than noise
  for (Corner& corner : set.views[4].corners) corner.sigma_px = 0.1;
  const Calibration result = run(set);
  EXPECT_TRUE(result.dropped.views.empty());
}

TEST(ForeignViews, OneThatFitsAfterAllComesBackToItsPlace) {
  const SimulatedSet set = cleanSet("radtan", 12, 9);
  const Board board = set.board;
  const PreparedViews given = prepareViews(std::span(&board, 1), set.views);
  SettledFit now{.fit = fittedPlainly(given, {.model = "radtan"}).fit};
  now.fit = withoutView(withoutView(now.fit, 5), 2);
  ASSERT_EQ(viewsLeftOut(given, now.fit), (std::vector<std::size_t>{2, 5}));
  EXPECT_TRUE(readmitViews(now, given, nullptr));
  ASSERT_EQ(now.fit.views.size(), 12U);
  for (std::size_t v = 0; v < 12; ++v) {
    EXPECT_EQ(now.fit.views[v].source, v);
    EXPECT_EQ(now.fit.views[v].errors.size(), now.fit.views[v].corners.size());
  }
  EXPECT_TRUE(viewsLeftOut(given, now.fit).empty());
  EXPECT_FALSE(readmitViews(now, given, nullptr));
}

TEST(ForeignViews, WhenHalfOfThemDisagreeTheAnswerIsNo) {
  Calibration result = run(cleanSet("radtan", 10, 10));
  for (int i = 0; i < 10; ++i)
    result.dropped.views.push_back(
        {.image = "other_" + std::to_string(i), .reason = "does not fit", .is_misfit = true});
  result.diagnoses = judge(result);
  EXPECT_FALSE(result.isUsable());
  EXPECT_EQ(result.diagnoses.front().id, "views_disagree");
}

}  // namespace
}  // namespace alidade
