// SPDX-License-Identifier: MIT
#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include <gmock/gmock.h>

#include "alidade/calibrate/calibrator.h"
#include "alidade/core/error.h"
#include "support/image_sizes.h"
#include "support/simulated_set.h"

namespace alidade {
namespace {

using testing::HasSubstr;

const std::vector<double> kConstrainedTruth = {535, 535, 319.5, 239.5, -0.28, 0.08, 8e-4, -4e-4, 0};

// The loss settles to 2 % of its threshold, from each start a little differently.
constexpr double kSettled = 1e-4;  // of cost and sigma

SimulatedSet noisySet() {
  return simulateSet(AnyCamera::make("radtan", kConstrainedTruth), kVga, 12, 0.1, 3);
}

std::string messageOf(const SimulatedSet& set, const CalibratorOptions& options) {
  try {
    static_cast<void>(calibrate(set.board, set.views, options));
  } catch (const Error& e) {
    return e.what();
  }
  return "no error";
}

TEST(Held, ParametersKeepTheirValueWithSigmaZero) {
  const SimulatedSet set = noisySet();
  const Calibration free = calibrate(set.board, set.views, {.model = "radtan"});
  const Calibration held = calibrate(set.board, set.views, {.model = "radtan", .held = {"cx", "k3", "cy"}});
  EXPECT_EQ(onlyCamera(held.fit).params[2], 319.5);
  EXPECT_EQ(onlyCamera(held.fit).params[3], 239.5);
  EXPECT_EQ(onlyCamera(held.fit).params[8], 0.0);
  EXPECT_EQ(onlyCamera(held.fit).constraint.held, (std::vector<int>{2, 3, 8}));
  for (const int i : onlyCamera(held.fit).constraint.held)
    EXPECT_EQ(held.uncertainty.parameterStdByNoise(i), 0.0);
  // What is known makes the rest better known, and right values cost next to nothing.
  EXPECT_LT(held.uncertainty.parameterStdByNoise(4), 0.8 * free.uncertainty.parameterStdByNoise(4));
  EXPECT_GE(held.fit.summary.cost, free.fit.summary.cost * (1 - 1e-9));
  EXPECT_LE(held.fit.summary.cost, 1.02 * free.fit.summary.cost);
  for (const int i : {0, 1, 4, 5, 6, 7}) {
    EXPECT_NEAR(onlyCamera(held.fit).params[static_cast<std::size_t>(i)],
                kConstrainedTruth[static_cast<std::size_t>(i)], 5 * held.uncertainty.parameterStdByNoise(i));
  }
}

// A set whose camera is calibrated with parameter values `factor` times the true ones.
Calibration heldAt(double factor, const std::vector<std::string>& names, std::uint64_t seed) {
  const SimulatedSet set = simulateSet(AnyCamera::make("radtan", kConstrainedTruth), kVga, 12, 0.1, seed);
  std::vector<double> params = kConstrainedTruth;
  for (const std::string& name : names)
    params[static_cast<std::size_t>(*parameterIndex(parameterNames("radtan"), name))] *= factor;
  return calibrate(
      set.board, set.views,
      {.model = "radtan", .initial = InitialCamera{AnyCamera::make("radtan", params), kVga}, .held = names});
}

std::ptrdiff_t numNamed(const Calibration& result, std::string_view id = "held_value") {
  return std::ranges::count_if(result.diagnoses, [&](const Diagnosis& d) { return d.id == id; });
}

TEST(Held, WrongValuesAreNamedWithWhatTheImagesGive) {
  struct Case {
    std::vector<std::string> names;
    double wrong;    // factor
    bool is_single;  // one cause, whose true value the images give
  };
  const std::vector<Case> cases = {{{"fx", "fy"}, 1.01, true},
                                   {{"cx"}, 1.01, true},
                                   {{"k1", "k2"}, 1.05, false},
                                   {{"cx", "cy", "fy"}, 1.01, false}};
  int num_right = 0;
  int num_right_named = 0;
  int num_wrong = 0;
  int num_wrong_named = 0;
  int num_values = 0;
  for (const Case& c : cases) {
    for (std::uint64_t seed = 1; seed <= 5; ++seed) {
      num_right_named += numNamed(heldAt(1, c.names, seed)) == 0 ? 0 : 1;
      ++num_right;
      const Calibration wrong = heldAt(c.wrong, c.names, seed);
      num_wrong_named += numNamed(wrong) == 0 ? 0 : 1;
      ++num_wrong;
      if (!c.is_single) continue;
      EXPECT_EQ(numNamed(wrong), 1) << c.names.front() << " " << seed;
      for (const CommonError& error : wrong.uncertainty.common_errors) {
        if (error.cause == CommonCause::kHeldFocal) {
          EXPECT_NEAR(c.wrong * (1 + error.value), 1, 5 * error.sigma) << seed;
          ++num_values;
        } else if (error.cause == CommonCause::kHeld) {
          EXPECT_NEAR(c.wrong * kConstrainedTruth[2] + error.value, kConstrainedTruth[2], 5 * error.sigma)
              << seed;
          ++num_values;
        }
      }
    }
  }
  EXPECT_EQ(num_right, 20);
  EXPECT_LE(num_right_named, 1);
  EXPECT_EQ(num_wrong, 20);
  EXPECT_EQ(num_wrong_named, 20);
  EXPECT_EQ(num_values, 10);
}

TEST(Held, RightFocalLengthsAreNotBlamedForTheBoard) {
  int num_checked = 0;
  int num_blamed = 0;
  int num_named = 0;
  for (std::uint64_t seed = 1; seed <= 5; ++seed) {
    SimulatedSet set = simulateSet(AnyCamera::make("radtan", kConstrainedTruth), kVga, 12, 0, seed);
    Random random(seed);
    for (std::size_t v = 0; v < set.views.size(); ++v) {
      for (Corner& corner : set.views[v].corners) {
        const Eigen::Vector3d p = set.board.corner(corner.id).cwiseProduct(Eigen::Vector3d(1.002, 1, 1));
        const double x = random.normal();
        corner.pixel = set.camera.project(set.poses[v] * p).pixel + 0.1 * Eigen::Vector2d(x, random.normal());
      }
    }
    const Calibration result =
        calibrate(set.board, set.views,
                  {.model = "radtan", .initial = InitialCamera{set.camera, kVga}, .held = {"fx", "fy"}});
    num_blamed += numNamed(result) > 0 ? 1 : 0;
    num_named += numNamed(result, "board_not_square") > 0 ? 1 : 0;
    ++num_checked;
  }
  EXPECT_EQ(num_checked, 5);
  EXPECT_LE(num_blamed, 1);  // one focal length looks almost the same
  EXPECT_GE(num_named, 4);
}

TEST(Held, EqualFocalLengthsAreOneValueAndAWholeLensIsNotTested) {
  const SimulatedSet set = noisySet();
  std::vector<double> params = kConstrainedTruth;
  params[0] = params[1] = 1.01 * kConstrainedTruth[0];
  const InitialCamera wrong{AnyCamera::make("radtan", params), kVga};
  const Calibration equal = calibrate(
      set.board, set.views, {.model = "radtan", .initial = wrong, .held = {"fx"}, .same_focal = true});
  EXPECT_EQ(numNamed(equal), 1);
  const auto countOf = [&](CommonCause cause) {
    return std::ranges::count(equal.uncertainty.common_errors, cause, &CommonError::cause);
  };
  EXPECT_EQ(countOf(CommonCause::kHeldFocal), 1);
  EXPECT_EQ(countOf(CommonCause::kHeld), 0);
  const auto names = parameterNames("radtan");
  const Calibration whole = calibrate(
      set.board, set.views,
      {.model = "radtan", .initial = wrong, .held = std::vector<std::string>(names.begin(), names.end())});
  EXPECT_EQ(numNamed(whole), 0);
}

TEST(Held, DegreesOfFreedomCountWhatIsFree) {
  const SimulatedSet set = noisySet();
  const Calibration free = calibrate(set.board, set.views, {.model = "radtan"});
  const Calibration all = calibrate(set.board, set.views,
                                    {.model = "radtan",
                                     .initial = InitialCamera{free.camera(), kVga},
                                     .held = {"fx", "fy", "cx", "cy", "k1", "k2", "p1", "p2", "k3"}});
  EXPECT_NEAR(all.fit.summary.cost, free.fit.summary.cost, kSettled * free.fit.summary.cost);
  const double corners = numCorners(free.fit);
  const double expected = std::sqrt((2 * corners - 9 - 6 * 12) / (2 * corners - 6 * 12));
  EXPECT_NEAR(all.uncertainty.coordinate_sigma_px / free.uncertainty.coordinate_sigma_px, expected, kSettled);
  for (int i = 0; i < 9; ++i) EXPECT_EQ(all.uncertainty.parameterStdByNoise(i), 0.0);
}

TEST(SameFocal, GivesOneFocalLength) {
  const SimulatedSet set = noisySet();
  const Calibration result = calibrate(set.board, set.views, {.model = "radtan", .same_focal = true});
  EXPECT_EQ(onlyCamera(result.fit).params[0], onlyCamera(result.fit).params[1]);
  EXPECT_NEAR(onlyCamera(result.fit).params[0], 535, 5 * result.uncertainty.parameterStdByNoise(0));
  EXPECT_EQ(result.uncertainty.parameterStdByNoise(0), result.uncertainty.parameterStdByNoise(1));
  EXPECT_EQ(result.fit.summary.termination, Termination::kConverged);
}

TEST(Initial, LeadsToTheSameAnswerFromThisOrAnotherModel) {
  const SimulatedSet set = noisySet();
  const Calibration searched = calibrate(set.board, set.views, {.model = "radtan"});
  const AnyCamera rough =
      AnyCamera::make("radtan", std::vector<double>{500, 560, 330, 230, -0.2, 0, 0, 0, 0});
  const AnyCamera other = AnyCamera::make("pinhole", std::vector<double>{560, 540, 310, 250});
  int num_starts = 0;
  for (const AnyCamera& start : {rough, other}) {
    const Calibration given =
        calibrate(set.board, set.views, {.model = "radtan", .initial = InitialCamera{start, kVga}});
    EXPECT_NEAR(given.fit.summary.cost, searched.fit.summary.cost, kSettled * searched.fit.summary.cost);
    EXPECT_NEAR(onlyCamera(given.fit).params[0], onlyCamera(searched.fit).params[0],
                0.01 * searched.uncertainty.parameterStdByNoise(0));
    EXPECT_EQ(given.choice.start.num_tried, 0);
    ++num_starts;
  }
  EXPECT_EQ(num_starts, 2);
}

TEST(Constraints, SayWhatIsWrongWithThem) {
  const SimulatedSet set = noisySet();
  EXPECT_THAT(messageOf(set, {.model = "radtan", .held = {"k9"}}), HasSubstr("'k9'"));
  EXPECT_THAT(messageOf(set, {.model = "radtan", .held = {"ccx"}}), HasSubstr("did you mean 'cx'?"));
  EXPECT_THAT(messageOf(set, {.model = "radtan", .held = {"fx"}}), HasSubstr("'fx' without a value"));
  EXPECT_THAT(messageOf(set, {.model = "eucm", .held = {"beta"}}), HasSubstr("'beta' without a value"));
  const InitialCamera wrong{AnyCamera::make("radtan", kConstrainedTruth), {.width = 1280, .height = 960}};
  EXPECT_THAT(messageOf(set, {.model = "radtan", .initial = wrong}), HasSubstr("1280x960"));
}

}  // namespace
}  // namespace alidade
