// SPDX-License-Identifier: MIT
// Rigs tested on other frames, as at a monthly check: right ones pass, and changes that matter are found.
#include "alidade/rig/rig_validation.h"

#include <algorithm>
#include <cstdint>
#include <cstdio>
#include <numbers>
#include <string>
#include <utility>
#include <vector>

#include <gmock/gmock.h>

#include "alidade/core/random.h"
#include "rig_scene.h"

namespace alidade {
namespace {

constexpr double kNoisePx = 0.1;

// Two cameras with lenses and a baseline of their own.
std::vector<TrueCamera> pairOfCameras(std::uint64_t seed) {
  Random random(seed);
  std::vector<TrueCamera> cameras;
  for (int c = 0; c < 2; ++c) {
    const double focal = random.uniform(500, 950);
    const std::vector<double> params = {focal,
                                        focal * random.uniform(0.995, 1.005),
                                        random.uniform(310, 330),
                                        random.uniform(230, 250),
                                        random.uniform(-0.3, -0.05),
                                        random.uniform(0, 0.1),
                                        random.uniform(-1e-3, 1e-3),
                                        random.uniform(-1e-3, 1e-3),
                                        0};
    cameras.push_back({AnyCamera::make("radtan", params), {640, 480}, {}});
  }
  cameras[1].camera_from_rig = poseAt(-random.uniform(0.06, 0.15), random.uniform(-0.005, 0.005),
                                      random.uniform(-0.005, 0.005), random.uniform(-0.08, 0.08));
  return cameras;
}

struct Monthly {
  std::vector<TrueCamera> cameras;
  RigRecord record;  // calibrated when the rig was new
  std::uint64_t seed = 0;

  explicit Monthly(std::uint64_t of_seed, int num_frames) : cameras(pairOfCameras(of_seed)), seed(of_seed) {
    const RigScene scene = sceneOf(cameras, kCharuco, num_frames, kNoisePx, 2 * seed);
    record = recordOf(calibrate(kCharuco, scene.views, optionsFor(scene)), "");
  }

  // On frames of a rig whose second camera was moved.
  [[nodiscard]] RigValidation test(const SE3& moved, double stretch = 1) const {
    return test(record, moved, stretch);
  }
  [[nodiscard]] RigValidation test(const RigRecord& stored, const SE3& moved, double stretch = 1) const {
    std::vector<TrueCamera> now = cameras;
    now[1].camera_from_rig = moved * now[1].camera_from_rig;
    now[1].camera_from_rig.translation *= stretch;
    const RigScene scene = sceneOf(now, kCharuco, 8, kNoisePx, 2 * seed + 1);
    return validateRig(stored, std::span(&kCharuco, 1), scene.views, rigTolerancePx(stored),
                       optionsFor(scene));
  }
};

bool hasFailure(const RigValidation& tested, std::string_view id) {
  return std::ranges::any_of(tested.diagnoses, [&](const Diagnosis& diagnosis) {
    return diagnosis.id == id && diagnosis.severity == Severity::kFailure;
  });
}

// As if errors of the lenses and of the poses were independent.
RigRecord withoutCorrelation(RigRecord record) {
  std::size_t num_params = 0;
  for (const RigCameraRecord& camera : record.cameras) num_params += camera.camera.camera.parameters().size();
  const std::size_t count = num_params + 6;
  for (std::size_t row = num_params, at = row * (row + 1) / 2; row < count; at += ++row)
    std::fill_n(record.covariance.begin() + static_cast<std::ptrdiff_t>(at), num_params, 0.0);
  return record;
}

TEST(MonthlyCheck, PassesRightRigs) {
  int num_checked = 0;
  int num_failed = 0;
  double most_sigmas = 0;
  double sum_sigmas = 0;
  for (std::uint64_t seed = 1; seed <= 40; ++seed) {
    const RigValidation tested = Monthly(seed, seed % 2 == 0 ? 7 : 20).test({});
    most_sigmas = std::max(most_sigmas, tested.cameras[1].sigmas);
    sum_sigmas += tested.cameras[1].sigmas;
    if (tested.verdict() == Verdict::kNo) {
      ++num_failed;
      std::printf("%llu: %s\n", static_cast<unsigned long long>(seed),
                  tested.diagnoses.front().message().c_str());
    }
    ++num_checked;
  }
  const double mean_sigmas = sum_sigmas / num_checked;
  std::printf("right rigs: %d of %d failed, at most %.1f sigma, %.2f on average\n", num_failed, num_checked,
              most_sigmas, mean_sigmas);
  EXPECT_EQ(num_failed, 0);
  EXPECT_LT(most_sigmas, 4);
  // The positive part of a standard normal variable has the mean 0.40.
  EXPECT_GT(mean_sigmas, 0.1);
  EXPECT_LT(mean_sigmas, 1.0);
  EXPECT_EQ(num_checked, 40);
}

TEST(MonthlyCheck, FindsATenthOfADegreeAndAHundredthOfTheBaseline) {
  constexpr double kTurnRad = 0.1 * std::numbers::pi / 180;
  std::vector<std::pair<std::string, SE3>> changes;
  for (int axis = 0; axis < 3; ++axis)
    changes.emplace_back("axis " + std::to_string(axis),
                         SE3{SO3::exp(kTurnRad * Eigen::Vector3d::Unit(axis)), Eigen::Vector3d::Zero()});
  std::vector<int> num_found(4);
  int num_found_without_correlation = 0;
  std::vector<double> least_sigmas(4, 1e9);
  constexpr int kNumRigs = 20;
  for (std::uint64_t seed = 101; seed < 101 + kNumRigs; ++seed) {
    const Monthly rig(seed, 15);
    for (std::size_t i = 0; i < 4; ++i) {
      const RigValidation tested = i < 3 ? rig.test(changes[i].second) : rig.test({}, 1.01);
      num_found[i] += hasFailure(tested, "pose_contradicted") ? 1 : 0;
      least_sigmas[i] = std::min(least_sigmas[i], tested.cameras[1].sigmas);
    }
    const RigValidation by_marginals = rig.test(withoutCorrelation(rig.record), changes[1].second);
    num_found_without_correlation += hasFailure(by_marginals, "pose_contradicted") ? 1 : 0;
  }
  for (std::size_t i = 0; i < 4; ++i) {
    std::printf("%s: %d of %d, at least %.1f sigma\n", i < 3 ? changes[i].first.c_str() : "baseline",
                num_found[i], kNumRigs, least_sigmas[i]);
    EXPECT_EQ(num_found[i], kNumRigs) << i;
  }
  std::printf("axis 1, errors of lenses and poses taken as independent: %d\n", num_found_without_correlation);
  EXPECT_LT(num_found_without_correlation, kNumRigs / 2);
}

// Rig files of other programs state no covariance.
TEST(MonthlyCheck, FailsWhatMattersInARigWithoutCovariance) {
  int num_checked = 0;
  for (std::uint64_t seed = 201; seed < 206; ++seed) {
    const Monthly rig(seed, 15);
    RigRecord stored = rig.record;
    stored.covariance.clear();
    EXPECT_NE(rig.test(stored, {}).verdict(), Verdict::kNo) << seed;
    const SE3 turn{SO3::exp(Eigen::Vector3d(0.005, 0, 0)), Eigen::Vector3d::Zero()};
    EXPECT_TRUE(hasFailure(rig.test(stored, turn), "pose_contradicted")) << seed;
    ++num_checked;
  }
  EXPECT_EQ(num_checked, 5);
}

}  // namespace
}  // namespace alidade
