// SPDX-License-Identifier: MIT
#include "alidade/calibrate/calibrator.h"

#include <gmock/gmock.h>

#include <algorithm>
#include <cstdio>
#include <functional>
#include <limits>

#include "alidade/adjust/board/errors.h"
#include "alidade/core/error.h"
#include "alidade/core/size_groups.h"
#include "support/image_sizes.h"
#include "support/simulated_set.h"

namespace alidade {
namespace {

using testing::AllOf;
using testing::ElementsAre;
using testing::HasSubstr;

const std::vector<double> kTruth = {535, 534, 322, 238, -0.28, 0.08, 8e-4, -4e-4, -0.01};

SimulatedSet noisySet(int num_views, std::uint64_t seed) {
  return simulateSet(AnyCamera::make("radtan", kTruth), kVga, num_views, 0.1, seed);
}

std::string messageOf(const std::function<void()>& call) {
  try {
    call();
  } catch (const Error& e) {
    return e.what();
  }
  return "no error";
}

std::string findingsOf(const Calibration& result) {
  std::string text;
  for (const Diagnosis& finding : result.diagnoses)
    text += "[" + std::string(finding.id) + "] " + finding.message() + "\n";
  return text;
}

bool hasFinding(const Calibration& result, const std::string& id, Severity severity) {
  return std::any_of(result.diagnoses.begin(), result.diagnoses.end(),
                     [&](const Diagnosis& f) { return f.id == id && f.severity == severity; });
}

TEST(Calibrate, DoesNotDependOnTheOrderOfViewsAndCorners) {
  SimulatedSet set = noisySet(10, 1);
  const Calibration first = calibrate(set.board, set.views, {.model = "radtan"});
  std::reverse(set.views.begin(), set.views.end());
  for (View& view : set.views)
    std::rotate(view.corners.begin(), view.corners.begin() + 17, view.corners.end());
  const Calibration second = calibrate(set.board, set.views, {.model = "radtan"});
  for (std::size_t i = 0; i < kTruth.size(); ++i) {
    EXPECT_EQ(onlyCamera(first.fit).params[i], onlyCamera(second.fit).params[i]);
  }
  EXPECT_EQ(rms(first.fit), rms(second.fit));
  EXPECT_EQ(*first.uncertainty.covariance, *second.uncertainty.covariance);
}

TEST(Calibrate, RefusesWhatItCannotUse) {
  const SimulatedSet set = noisySet(5, 2);
  const auto message = [&](const std::function<void(std::vector<View>&)>& spoil,
                           const char* model = "radtan") {
    std::vector<View> views = set.views;
    spoil(views);
    return messageOf([&] { static_cast<void>(calibrate(set.board, views, {.model = model})); });
  };
  EXPECT_THAT(message([](auto& v) { v.resize(2); }), HasSubstr("2 views of the board; expected at least 3"));
  EXPECT_THAT(message([](auto& v) { v.clear(); }), HasSubstr("0 views"));
  EXPECT_THAT(message([](auto& v) { v[1].size.width = 641; }),
              HasSubstr("expected 640x480 as in the other views"));
  EXPECT_THAT(message([](auto& v) { v[1].size = {}; }),
              HasSubstr("expected the size of the image in pixels"));
  EXPECT_THAT(message([](auto& v) { v[1].image.clear(); }), HasSubstr("a view without a name"));
  EXPECT_THAT(message([](auto& v) { v[1].corners[3].id = 54; }), HasSubstr("corner id 54; expected 0 to 53"));
  EXPECT_THAT(message([](auto& v) { v[1].corners[3].pixel.x() = std::numeric_limits<double>::quiet_NaN(); }),
              HasSubstr("not a number"));
  EXPECT_THAT(message([](auto& v) {
                for (View& view : v) view.size = {.width = 480, .height = 640};
              }),
              AllOf(HasSubstr("outside the image of 480x640"), HasSubstr("may be swapped")));
  EXPECT_THAT(message([](auto& v) { v[1].corners[3].pixel.y() = -14; }),
              AllOf(HasSubstr("corner 3 at ("), HasSubstr(", -14.0)")));
  EXPECT_EQ(message([](auto& v) { v[1].corners[3].pixel.y() = -12; }), "no error") << "merely an outlier";
  EXPECT_THAT(message([](auto& v) { v[1].image = v[0].image; }), HasSubstr("two views with this name"));
  EXPECT_THAT(message([](auto&) {}, "radtn"), HasSubstr("did you mean 'radtan'?"));
  EXPECT_THAT(message([](auto& v) {
                for (std::size_t i = 0; i < 3; ++i) v[i].corners.resize(5);
              }),
              HasSubstr("5 corners; at least 6 are needed"));
}

TEST(Calibrate, StopsWhenCancelled) {
  const SimulatedSet set = noisySet(5, 3);
  const CancelFlag cancel{true};
  EXPECT_THROW(static_cast<void>(calibrate(set.board, set.views, {.model = "radtan", .cancel = &cancel})),
               Cancelled);
}

// Views that face the camera squarely leave focal length and distance to each other.
TEST(Calibrate, SaysNoToFrontoParallelViews) {
  const AnyCamera camera = AnyCamera::make("radtan", kTruth);
  const Checkerboard board{.columns = 9, .rows = 6, .square_m = 0.025};
  int num_refused = 0;
  for (const double noise : {0.0, 0.05, 0.3}) {
    for (std::uint64_t seed = 1; seed <= 5; ++seed) {
      Random random(seed);
      std::vector<View> views;
      while (views.size() < 12) {
        SE3 pose;
        pose.rotation = SO3::exp({0, 0, random.uniform(-0.5, 0.5)});
        pose.translation = {random.uniform(-0.2, 0.1), random.uniform(-0.15, 0.05),
                            random.uniform(0.25, 0.8)};
        View view = exactView(camera, kVga, board, pose, "view_" + std::to_string(views.size()));
        if (view.corners.size() != 54) continue;
        addCornerNoise(view, noise, random);
        views.push_back(view);
      }
      const Calibration result = calibrate(board, views, {.model = "radtan"});
      EXPECT_FALSE(result.isUsable());
      EXPECT_TRUE(hasFinding(result, "fronto_parallel", Severity::kFailure))
          << "noise " << noise << ", seed " << seed << "\n"
          << findingsOf(result);
      ++num_refused;
    }
  }
  EXPECT_EQ(num_refused, 15);
}

TEST(Calibrate, TrustsGoodSetsAndWarnsOfFewViews) {
  int num_trusted = 0;
  for (std::uint64_t seed = 1; seed <= 20; ++seed) {
    const SimulatedSet set = noisySet(25, seed);
    const Calibration result = calibrate(set.board, set.views, {.model = "radtan"});
    EXPECT_TRUE(result.isUsable()) << "seed " << seed << "\n" << findingsOf(result);
    ++num_trusted;
    EXPECT_FALSE(hasFinding(result, "few_views", Severity::kWarning));
  }
  EXPECT_EQ(num_trusted, 20);
  const SimulatedSet set = noisySet(4, 1);
  EXPECT_TRUE(
      hasFinding(calibrate(set.board, set.views, {.model = "radtan"}), "few_views", Severity::kWarning));
}

// Distortion learnt near the middle of the image bends back before its corners.
TEST(Calibrate, SaysNoToALensThatFoldsInTheImage) {
  const std::vector<double> folding = {535, 535, 319.5, 239.5, -1.0 / 3, 0, 0, 0, 0};
  RandomViewOptions options;
  options.max_fill = 0.5;
  const AnyCamera camera = AnyCamera::make("radtan", folding);
  const SimulatedSet set = simulateSet(camera, kVga, 15, 0.02, 4, options);
  const Calibration result = calibrate(set.board, set.views, {.model = "radtan"});
  EXPECT_TRUE(hasFinding(result, "folds_in_image", Severity::kFailure));
  EXPECT_FALSE(result.isUsable());
}

TEST(Calibrate, SaysNoToAModelThatIsTooLean) {
  int num_refused = 0;
  for (std::uint64_t seed = 1; seed <= 10; ++seed) {
    const SimulatedSet set = noisySet(15, seed);
    const Calibration lean = calibrate(set.board, set.views, {.model = "pinhole"});
    EXPECT_TRUE(hasFinding(lean, "model_too_lean", Severity::kFailure)) << findingsOf(lean);
    const std::vector<double> undistorted = {535, 534, 322, 238};
    const SimulatedSet plain = simulateSet(AnyCamera::make("pinhole", undistorted), kVga, 15, 0.1, seed);
    const Calibration enough = calibrate(plain.board, plain.views, {.model = "pinhole"});
    EXPECT_TRUE(enough.isUsable()) << findingsOf(enough);
    EXPECT_FALSE(enough.choice.better_model);
    ++num_refused;
  }
  EXPECT_EQ(num_refused, 10);
}

// A quotient of polynomials over a polynomial that suffices: its coefficients are undetermined and run away,
// which must not be held against the smaller model.
TEST(Calibrate, TrustsAModelThatALargerOneOnlyOverfits) {
  int num_trusted = 0;
  const std::vector<std::vector<double>> lenses = {
      {-0.28, 0.08, 8e-4, -4e-4, -0.01}, {-0.05, 0.01, 0, 0, 0}, {0, 0, 0, 0, 0}};
  for (const std::vector<double>& lens : lenses) {
    std::vector<double> truth = {535, 534, 322, 238};
    truth.insert(truth.end(), lens.begin(), lens.end());
    for (std::uint64_t seed = 1; seed <= 10; ++seed) {
      for (const double noise : {0.02, 0.2}) {
        const SimulatedSet set = simulateSet(AnyCamera::make("radtan", truth), kVga, 20, noise, seed);
        const Calibration result = calibrate(set.board, set.views, {.model = "radtan"});
        EXPECT_FALSE(result.choice.better_model) << result.choice.better_model->id;
        num_trusted += result.isUsable() ? 1 : 0;
      }
    }
  }
  // In the odd set radtan's own k3 bends back before a corner that no view reached.
  EXPECT_GE(num_trusted, 57);
}

// A wide lens that a polynomial cannot follow and the quotient does.
TEST(Calibrate, NamesTheNextLargerModelWhereItIsNeeded) {
  int num_named = 0;
  const std::vector<double> truth = {300, 301, 322, 238, 1.35, 0.25, 5e-4, -4e-4, 0.01, 1.68, 0.62, 0.05};
  for (std::uint64_t seed = 1; seed <= 10; ++seed) {
    const SimulatedSet set = simulateSet(AnyCamera::make("rational", truth), kVga, 25, 0.05, seed);
    const Calibration lean = calibrate(set.board, set.views, {.model = "radtan"});
    EXPECT_FALSE(lean.isUsable());
    if (lean.choice.better_model) {
      EXPECT_EQ(lean.choice.better_model->id, "rational");
      ++num_named;
    }
    const Calibration enough = calibrate(set.board, set.views, {.model = "rational"});
    EXPECT_FALSE(enough.choice.better_model) << enough.choice.better_model->id;
  }
  std::printf("rational named for %d of 10 sets\n", num_named);
  EXPECT_GE(num_named, 3) << "the others fold inside the image themselves or do not settle";
}

TEST(Calibrate, CountsCopiesOfAViewOnce) {
  SimulatedSet set = noisySet(10, 1);
  const Calibration once = calibrate(set.board, set.views, {.model = "radtan"});
  for (int i = 0; i < 50; ++i) {
    View copy = set.views[3];
    copy.image = "copy_" + std::to_string(i);
    set.views.push_back(copy);
  }
  const Calibration copied = calibrate(set.board, set.views, {.model = "radtan"});
  EXPECT_EQ(copied.dropped.repeated.size(), 50U);
  EXPECT_EQ(copied.fit.views.size(), 10U);
  // The views are summed in another order, and the solver stops a step sooner or later for it.
  for (int i = 0; i < 9; ++i) {
    EXPECT_NEAR(copied.uncertainty.parameterStdByNoise(i), once.uncertainty.parameterStdByNoise(i),
                1e-6 * once.uncertainty.parameterStdByNoise(i));
  }
}

TEST(Calibrate, OneDegenerateViewIsLeftOutAndTheRestCalibrated) {
  SimulatedSet set = noisySet(25, 2);
  set.views[4].corners.resize(9);  // the first row alone: a line, which gives no pose
  const Calibration result = calibrate(set.board, set.views, {.model = "radtan"});
  ASSERT_EQ(result.dropped.views.size(), 1U);
  EXPECT_EQ(result.dropped.views[0].image, set.views[4].image);
  EXPECT_TRUE(result.isUsable()) << findingsOf(result);
}

TEST(GroupBySize, TakesTheLargestGroup) {
  const std::vector<ImageSize> sizes = {{641, 480}, {640, 480}, {640, 480}, {320, 240}, {640, 480}};
  const SizeGroups groups = groupBySize(sizes);
  EXPECT_EQ(groups.size, (ImageSize{640, 480}));
  EXPECT_THAT(groups.in_group, ElementsAre(1, 2, 4));
  EXPECT_THAT(groups.others, ElementsAre(0, 3));
  EXPECT_TRUE(groupBySize({}).in_group.empty());
}

}  // namespace
}  // namespace alidade
