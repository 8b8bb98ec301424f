// SPDX-License-Identifier: MIT
#include "alidade/calibrate/choose/model_solution.h"

#include <gmock/gmock.h>
#include <cmath>

#include <algorithm>

#include "alidade/adjust/board/errors.h"
#include "alidade/calibrate/calibrator.h"
#include "alidade/camera/model_traits.h"
#include "alidade/core/error.h"
#include "support/choice_sweep.h"
#include "support/image_sizes.h"
#include "support/simulated_set.h"

namespace alidade {
namespace {

using testing::HasSubstr;

const std::vector<double> kTruth = {535, 534, 322, 238, -0.28, 0.08, 8e-4, -4e-4, -0.01};

SimulatedSet noisySet(const AnyCamera& camera, int num_views, std::uint64_t seed, double noise_px = 0.1) {
  return simulateSet(camera, kVga, num_views, noise_px, seed);
}

Calibration chosenFor(const SimulatedSet& set, const CalibratorOptions& options = {.model = "auto"}) {
  return calibrate(set.board, set.views, options);
}

const ModelCandidate& candidate(const Calibration& result, std::string_view id) {
  const auto& all = result.choice.model->candidates;
  const auto at = std::find_if(all.begin(), all.end(), [&](const auto& c) { return c.id == id; });
  EXPECT_NE(at, all.end()) << id;
  return *at;
}

std::string messageOf(const SimulatedSet& set, const CalibratorOptions& options) {
  try {
    static_cast<void>(calibrate(set.board, set.views, options));
  } catch (const Error& e) {
    return e.what();
  }
  return "no error";
}

// The bench choice_bench draws more of these.
TEST(ModelChoice, IsTheTrueModelOrOneThatIsAsGood) {
  constexpr double kAsGood = 0.01;  // of the held-out RMS
  int num_sets = 0;
  int num_undetermined = 0;
  for (const ModelTraits& traits : allModelTraits()) {
    if (!traits.is_candidate) continue;
    const std::string model(traits.id);
    constexpr std::uint64_t kSeed = 11;
    const std::uint64_t num_of_model = model == "pinhole" || model == "radtan" ? 5 : 2;
    const bool is_large = traits.parameter_names.size() > 16 ||
                          (traits.family == LensFamily::kWide && traits.parameter_names.size() > 9);
    for (std::uint64_t number = 0; number < num_of_model; ++number, ++num_sets) {
      const ChoiceSet set = drawChoiceSet(model, kSeed, number);
      const Calibration result = calibrate(set.set.board, set.set.views, {.model = "auto"});
      const std::string chosen(result.camera().modelId());
      EXPECT_NE(judgeChoice(model, result), ChoiceVerdict::kOther)
          << model << " " << number << ": " << chosen;
      EXPECT_EQ(result.choice.model->candidates.size(), result.choice.model->is_wide ? 14u : 5u);
      if (model == "pinhole" || model == "radtan") {
        EXPECT_EQ(chosen, model);
      }
      // A smaller one than a large model must predict as well as that does, if the views determine it.
      if (!is_large || chosen == model) continue;
      const ModelCandidate& truth = candidate(result, model);
      if (truth.verdict == "ill_conditioned") {
        ++num_undetermined;
      } else {
        EXPECT_LE(candidate(result, chosen).holdout_rms_px, (1 + kAsGood) * truth.holdout_rms_px)
            << model << " " << number << ": " << chosen;
      }
    }
  }
  EXPECT_EQ(num_sets, 34);
  EXPECT_EQ(num_undetermined, 1);
}

// Where a lens deviates enough from the smaller models.
TEST(ModelChoice, TakesEachLargeModel) {
  constexpr std::uint64_t kSeed = 12;
  constexpr int kNumViews = 30;
  int num_taken = 0;
  for (const char* const model : {"tilted", "thin_prism_fisheye", "fisheye624", "ocam"}) {
    int num_of_model = 0;
    for (std::uint64_t number = 0; number < 2; ++number) {
      const ChoiceSet set = drawChoiceSet(model, kSeed, number, kNumViews);
      const Calibration result = calibrate(set.set.board, set.set.views, {.model = "auto"});
      num_of_model += result.camera().modelId() == model ? 1 : 0;
    }
    EXPECT_GE(num_of_model, 1) << model;
    num_taken += num_of_model;
  }
  EXPECT_EQ(num_taken, 5);
}

TEST(ModelChoice, GivesWhatTheChosenModelGivesByName) {
  const SimulatedSet set = noisySet(AnyCamera::make("radtan", kTruth), 15, 1);
  const Calibration chosen = chosenFor(set);
  const Calibration named = chosenFor(set, {.model = "radtan"});
  ASSERT_EQ(chosen.camera().modelId(), "radtan");
  for (std::size_t i = 0; i < kTruth.size(); ++i)
    EXPECT_EQ(onlyCamera(chosen.fit).params[i], onlyCamera(named.fit).params[i]);
  EXPECT_EQ(rms(chosen.fit), rms(named.fit));
  EXPECT_EQ(chosen.uncertainty.holdout.rms_px, named.uncertainty.holdout.rms_px);
  EXPECT_EQ(*chosen.uncertainty.covariance, *named.uncertainty.covariance);
  EXPECT_TRUE(chosen.diagnoses.empty());
  EXPECT_FALSE(named.choice.model);
}

TEST(ModelChoice, DoesNotDependOnThreadsAndOrder) {
  ChoiceSet set = drawChoiceSet("double_sphere", 3, 1);
  const Calibration one = calibrate(set.set.board, set.set.views, {.model = "auto"});
  std::reverse(set.set.views.begin(), set.set.views.end());
  const Calibration two = calibrate(set.set.board, set.set.views, {.model = "auto", .jobs = 3});
  ASSERT_EQ(one.camera().modelId(), two.camera().modelId());
  EXPECT_TRUE(std::equal(onlyCamera(one.fit).params.begin(), onlyCamera(one.fit).params.end(),
                         onlyCamera(two.fit).params.begin()));
  int num_compared = 0;
  for (const ModelCandidate& c : one.choice.model->candidates) {
    const ModelCandidate& other = candidate(two, c.id);
    EXPECT_EQ(c.verdict, other.verdict);
    if (!(c.holdout_rms_px > 0)) continue;
    EXPECT_EQ(c.holdout_rms_px, other.holdout_rms_px) << c.id;
    EXPECT_EQ(c.excess, other.excess) << c.id;
    ++num_compared;
  }
  EXPECT_GE(num_compared, 5);
}

TEST(ModelChoice, ComparesOnTheCornersThatTheBestModelKeeps) {
  const Calibration result = chosenFor(noisySet(AnyCamera::make("radtan", kTruth), 15, 2));
  EXPECT_EQ(result.choice.model->reference, "radtan");
  EXPECT_EQ(result.choice.model->best, "radtan");
  const ModelCandidate& pinhole = candidate(result, "pinhole");
  EXPECT_EQ(pinhole.verdict, "worse");
  EXPECT_GT(pinhole.rms_px, 1);  // by itself it would leave out half of the corners
  EXPECT_EQ(pinhole.reason, "fits corners worse than radtan") << "so it is not cross-validated";
  EXPECT_TRUE(std::isnan(pinhole.holdout_rms_px));
  EXPECT_EQ(candidate(result, "rational").verdict, "larger");
}

TEST(ModelChoice, HoldsWithoutNoise) {
  const Calibration lens = chosenFor(noisySet(AnyCamera::make("radtan", kTruth), 10, 3, 0));
  EXPECT_EQ(lens.camera().modelId(), "radtan");
  const Calibration none =
      chosenFor(noisySet(AnyCamera::make("pinhole", std::vector<double>{535, 534, 322, 238}), 10, 4, 0));
  EXPECT_EQ(none.camera().modelId(), "pinhole");
}

TEST(ModelChoice, IsThatOfTheInitialCamera) {
  const SimulatedSet set = noisySet(AnyCamera::make("radtan", kTruth), 10, 5);
  std::vector<double> rational = kTruth;
  rational.resize(12, 0.0);
  const InitialCamera initial{.camera = AnyCamera::make("rational", rational), .size = kVga};
  const Calibration result = chosenFor(set, {.model = "auto", .initial = initial});
  EXPECT_EQ(result.camera().modelId(), "rational");
  EXPECT_FALSE(result.choice.model);
}

TEST(ModelChoice, HoldsWhatAllModelsHave) {
  const SimulatedSet set = noisySet(AnyCamera::make("radtan", kTruth), 12, 6);
  const Calibration result = chosenFor(set, {.model = "auto", .held = {"cx"}, .same_focal = true});
  EXPECT_EQ(onlyCamera(result.fit).params[2], 319.5);
  EXPECT_EQ(onlyCamera(result.fit).params[0], onlyCamera(result.fit).params[1]);
  EXPECT_THAT(messageOf(set, {.model = "auto", .held = {"k1"}}),
              HasSubstr("parameters that all models have"));
  EXPECT_THAT(messageOf(set, {.model = "auto", .held = {"fx"}}), HasSubstr("give a camera file with --init"));
  EXPECT_THAT(messageOf(set, {.model = "automatic"}), HasSubstr("automatic"));
}

TEST(ModelChoice, IsAmongTheAllowedModels) {
  const SimulatedSet set = noisySet(AnyCamera::make("radtan", kTruth), 12, 7);
  const Calibration without = chosenFor(set, {.models = {"pinhole", "rational", "kannala_brandt"}});
  EXPECT_THAT(without.camera().modelId(), testing::AnyOf("rational", "kannala_brandt"));
  EXPECT_EQ(candidate(without, "radtan").verdict, "not_allowed");
  EXPECT_EQ(without.choice.model->candidates.size(), 4u) << "radtan, which tells the field, and the three";
  EXPECT_EQ(chosenFor(set, {.models = {"pinhole", "rational"}}).camera().modelId(), "rational");

  // k3 is 1.2 % of the distortion here, which shows.
  std::vector<double> params = kTruth;
  params[8] = -0.12;
  const SimulatedSet strong = noisySet(AnyCamera::make("radtan", params), 12, 8);
  const CalibratorOptions four{.models = {"pinhole", "radtan"}, .held = {"radtan.k3"}};
  const Calibration held = chosenFor(strong, four);
  EXPECT_EQ(held.camera().modelId(), "radtan");
  EXPECT_EQ(held.camera().parameter("k3"), 0);
  EXPECT_EQ(candidate(held, "radtan").num_params, 8);
  EXPECT_NE(chosenFor(strong, {.models = {"pinhole", "radtan"}}).camera().parameter("k3"), 0);
  // A candidate is scored with what it holds, whatever the reference holds.
  const Calibration beside =
      chosenFor(strong, {.models = {"pinhole", "radtan", "kannala_brandt"}, .held = {"radtan.k3"}});
  EXPECT_NEAR(candidate(beside, "radtan").rms_px, candidate(held, "radtan").rms_px, 0.005)
      << "on other corners";
  EXPECT_GT(candidate(beside, "radtan").rms_px, 1.01 * candidate(chosenFor(strong), "radtan").rms_px);
  EXPECT_THAT(messageOf(set, {.model = "fov", .held = {"radtan.w"}}), HasSubstr("'w' of radtan"));
  EXPECT_THAT(messageOf(set, {.held = {"radtan.k9"}}), HasSubstr("k9"));
  EXPECT_THAT(messageOf(set, {.held = {"radial.k3"}}), HasSubstr("radial"));
}

// The boards leave out the image's corners, where radtan turns back and the lens does not.
TEST(ModelChoice, TakesASoundModelInPlaceOfOneThatFolds) {
  std::size_t num_folded = 0;
  for (std::uint64_t seed = 0; seed < 4; ++seed) {
    const AnyCamera wide =
        AnyCamera::make("double_sphere", std::vector<double>{290, 290, 319.5, 239.5, -0.2, 0.58});
    SimulatedSet set = noisySet(wide, 14, 40 + seed);
    for (View& view : set.views) {
      std::erase_if(view.corners, [&](const Corner& corner) {
        return (corner.pixel - Eigen::Vector2d(319.5, 239.5)).norm() > 215;
      });
    }
    const Calibration chosen = chosenFor(set);
    num_folded += candidate(chosen, "radtan").verdict == "folds_in_image" ? 1 : 0;
    EXPECT_NE(chosen.camera().modelId(), "radtan") << seed;
    EXPECT_FALSE(hasFinding(chosen, "folds_in_image")) << seed;
  }
  EXPECT_GE(num_folded, 1U);
}

// A named model is called too lean only where the choice would have gone by it.
TEST(ModelChoice, AgreesWithTheWarningOfALeanModel) {
  int num_lean = 0;
  for (std::uint64_t seed = 0; seed < 12; ++seed) {
    std::vector<double> params = kTruth;
    const double strength = 0.01 * static_cast<double>(seed);  // from nothing to clearly more than noise
    for (std::size_t i = 4; i < params.size(); ++i) params[i] *= strength;
    const SimulatedSet set = noisySet(AnyCamera::make("radtan", params), 15, seed);
    const Calibration lean = chosenFor(set, {.model = "pinhole"});
    const Calibration chosen = chosenFor(set);
    EXPECT_EQ(lean.choice.better_model.has_value(), chosen.camera().modelId() != "pinhole") << seed;
    if (lean.choice.better_model) ++num_lean;
  }
  EXPECT_GE(num_lean, 3);
  EXPECT_LE(num_lean, 11);
}

}  // namespace
}  // namespace alidade
