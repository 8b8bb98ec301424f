// SPDX-License-Identifier: MIT
#include "alidade/footage/check/rig_check.h"

#include <algorithm>
#include <cmath>
#include <functional>
#include <utility>
#include <vector>

#include <gtest/gtest.h>

#include "alidade/core/statistics.h"
#include "alidade/footage/check/pair_fit.h"
#include "footage/points_scene.h"

namespace alidade {
namespace {

using testing::footageCameras;
using testing::kFootageSize;
using testing::noisy;
using testing::randomDirection;

constexpr double kDeg = std::numbers::pi / 180;

// Pairs of cameras of all kinds, 0.1 m apart, side by side or one above the other, a little turned.
AnyRig pairOf(std::size_t kind, Random& random) {
  const std::vector<AnyCamera> cameras = footageCameras();
  const AnyCamera& first = cameras[kind % cameras.size()];
  // Pairs of one kind, then of the first lens with each other one.
  const AnyCamera& second = kind < cameras.size() ? first : cameras[(kind + 1) % cameras.size()];
  const Eigen::Vector3d baseline =
      kind % 2 == 0 ? Eigen::Vector3d(-0.1, 0, 0) : Eigen::Vector3d(0.01, -0.1, 0.02);
  const SE3 second_from_first{SO3::exp(0.05 * randomDirection(random)), baseline};
  return AnyRig({{"left", first, kFootageSize, {}}, {"right", second, kFootageSize, second_from_first}});
}

struct ScenePart {
  int instants = 6;
  std::size_t points = 60;  // of each instant, those that both cameras see
  double near_m = 0.4;
  double far_m = 5;
  double noise_px = 0.15;
  double false_share = 0.1;
};

// What the true rig shows, with noise and some false matches.
RigPairMatches matchesOf(const AnyRig& rig, const ScenePart& scene, Random& random) {
  RigPairMatches matches{.first = 0, .second = 1, .instants = {}};
  for (int k = 0; k < scene.instants; ++k) {
    std::vector<PixelMatch>& instant = matches.instants.emplace_back();
    for (int trial = 0; trial < 20000 && instant.size() < scene.points; ++trial) {
      const Eigen::Vector2d a(random.uniform(0, kFootageSize.width - 1),
                              random.uniform(0, kFootageSize.height - 1));
      const auto ray = rig.camera(0).camera.unproject(a);
      if (!ray) continue;
      // As many near as far ones, by the inverse of the distance.
      const double distance = 1 / random.uniform(1 / scene.far_m, 1 / scene.near_m);
      const Projection b = rig.camera(1).camera.project(rig.camera(1).camera_from_rig * (distance * *ray));
      if (!b.ok() || !testing::isInFootage(b.pixel)) continue;
      PixelMatch match{noisy(a, scene.noise_px, random), noisy(b.pixel, scene.noise_px, random), 1};
      if (random.uniform() < scene.false_share)
        match.b = Eigen::Vector2d(random.uniform(0, 639), random.uniform(0, 479));
      instant.push_back(match);
    }
  }
  return matches;
}

AnyRig withLens(const AnyRig& rig, std::size_t i, const std::function<void(std::vector<double>&)>& change) {
  std::vector<MountedCamera> cameras = rig.cameras();
  std::vector<double> params(cameras[i].camera.parameters().begin(), cameras[i].camera.parameters().end());
  change(params);
  cameras[i].camera = AnyCamera::make(cameras[i].camera.modelId(), params);
  return AnyRig(cameras);
}

AnyRig turned(const AnyRig& rig, const Eigen::Vector3d& w) {
  std::vector<MountedCamera> cameras = rig.cameras();
  cameras[1].camera_from_rig = SE3{SO3::exp(w), Eigen::Vector3d::Zero()} * cameras[1].camera_from_rig;
  return AnyRig(cameras);
}

RigPairCheck checked(const AnyRig& stated, const RigPairMatches& matches) {
  return checkRigOnFootage(stated, std::vector{matches},
                           {.tolerance_px = kRigFootageTolerancePx, .num_jobs = 1})
      .pairs.front();
}

constexpr std::size_t kNumPairs = 7;

// Whether a change is the explanation, or explains the matches nearly as well.
bool isNamed(const RigPairCheck& check, CameraChangeKind kind, PairSide side) {
  const auto isIt = [&](std::size_t i) {
    return check.changes[i].kind == kind && check.changes[i].side == side;
  };
  return check.explanation && (isIt(*check.explanation) ||
                               std::any_of(check.alternatives.begin(), check.alternatives.end(), isIt));
}

TEST(RigCheck, TrueRigsAreConsistent) {
  Random random(11);
  int num_checked = 0;
  for (std::size_t kind = 0; kind < kNumPairs; ++kind) {
    for (int round = 0; round < 2; ++round) {
      const AnyRig rig = pairOf(kind, random);
      const RigPairCheck check = checked(rig, matchesOf(rig, {}, random));
      EXPECT_EQ(check.verdict, FootageVerdict::kConsistent) << kind << " " << gapId(check.gap);
      EXPECT_FALSE(check.explanation);
      EXPECT_LT(check.blind_px, 0.2);
      EXPECT_NEAR(check.noise_px, 0.15, 0.03);
      EXPECT_EQ(check.num_instants, 6);
      ++num_checked;
    }
  }
  EXPECT_EQ(num_checked, 14);
}

TEST(RigCheck, TurnedCamerasAreFound) {
  Random random(12);
  int num_checked = 0;
  int num_wrong = 0;
  int num_named = 0;
  for (std::size_t kind = 0; kind < kNumPairs; ++kind) {
    const AnyRig rig = pairOf(kind, random);
    const RigPairMatches matches = matchesOf(rig, {}, random);
    // About the baseline, which moves points across their epipolar curves most.
    const Eigen::Vector3d turn = -0.2 * kDeg * rig.camera(1).camera_from_rig.translation.normalized();
    const RigPairCheck check = checked(turned(rig, turn), matches);
    ++num_checked;
    num_wrong += check.verdict == FootageVerdict::kInconsistent ? 1 : 0;
    // 0.2 degrees are 0.7 px of the fisheye lenses, and less than fails.
    ASSERT_TRUE(check.explanation) << kind;
    const RigChange& change = check.changes[*check.explanation];
    EXPECT_EQ(check.verdict == FootageVerdict::kInconsistent, change.effect_px > 1) << kind;
    if (change.kind != CameraChangeKind::kRotation && change.kind != CameraChangeKind::kPose) continue;
    ++num_named;
    const Eigen::Vector3d w(change.amounts[0], change.amounts[1], change.amounts[2]);
    EXPECT_NEAR(w.norm(), turn.norm(), 0.05 * kDeg) << kind;
    // The file has turned the points by `turn`, so the camera itself is turned by as much against the file;
    // or the other one the other way.
    EXPECT_GT(w.dot(turn) * (change.side == PairSide::kFirst ? -1 : 1), 0) << kind;
  }
  EXPECT_EQ(num_checked, 7);
  EXPECT_GE(num_wrong, 3);
  EXPECT_GE(num_named, 6);
}

TEST(RigCheck, WrongLensesAreFoundAndNamed) {
  Random random(13);
  int num_checked = 0;
  int num_first = 0;
  for (std::size_t kind = 0; kind < kNumPairs; ++kind) {
    const AnyRig rig = pairOf(kind, random);
    const RigPairMatches matches = matchesOf(rig, {}, random);
    for (const std::size_t camera : {0, 1}) {
      SCOPED_TRACE(::testing::Message() << kind << " " << camera);
      const RigPairCheck longer =
          checked(withLens(rig, camera, [](auto& p) { p[0] *= 1.02, p[1] *= 1.02; }), matches);
      EXPECT_EQ(longer.verdict, FootageVerdict::kInconsistent);
      const PairSide side = camera == 0 ? PairSide::kFirst : PairSide::kSecond;
      EXPECT_TRUE(isNamed(longer, CameraChangeKind::kFocalLength, side));
      num_first +=
          longer.explanation && longer.changes[*longer.explanation].kind == CameraChangeKind::kFocalLength
              ? 1
              : 0;
      for (const RigChange& change : longer.changes) {
        if (change.kind != CameraChangeKind::kFocalLength || change.side != side) continue;
        EXPECT_NEAR(change.amounts[0], 1 / 1.02 - 1, 0.003);
        ++num_checked;
      }
    }
  }
  EXPECT_EQ(num_checked, 14);
  EXPECT_GE(num_first, 13);
}

TEST(RigCheck, MissingDistortionIsFoundAndNamed) {
  Random random(14);
  const auto drop = [](std::vector<double>& params) { std::fill(params.begin() + 4, params.end(), 0.0); };
  int num_checked = 0;
  for (int round = 0; round < 3; ++round) {
    const AnyRig rig = pairOf(1, random);
    const RigPairMatches matches = matchesOf(rig, {}, random);
    const std::vector<std::pair<AnyRig, PairSide>> cases = {
        {withLens(rig, 1, drop), PairSide::kSecond},
        {withLens(rig, 0, drop), PairSide::kFirst},
        {withLens(withLens(rig, 0, drop), 1, drop), PairSide::kBoth}};
    for (const auto& [stated, side] : cases) {
      const RigPairCheck check = checked(stated, matches);
      EXPECT_EQ(check.verdict, FootageVerdict::kInconsistent);
      ASSERT_TRUE(check.explanation);
      const RigChange& change = check.changes[*check.explanation];
      EXPECT_EQ(change.kind, CameraChangeKind::kFirstRadial) << describe(change, "left", "right");
      EXPECT_EQ(change.side, side) << describe(change, "left", "right");
      ++num_checked;
    }
  }
  EXPECT_EQ(num_checked, 9);
}

TEST(RigCheck, ImagesThatCannotTellSaySo) {
  Random random(15);
  int num_checked = 0;
  for (std::size_t kind = 0; kind < kNumPairs; ++kind) {
    const AnyRig rig = pairOf(kind, random);
    const auto far = checked(rig, matchesOf(rig, {.near_m = 200, .far_m = 1000}, random));
    EXPECT_EQ(far.verdict, FootageVerdict::kCannotTell) << kind;
    EXPECT_EQ(far.gap, FootageGap::kNoParallax) << kind << " " << gapId(far.gap);
    const auto few = checked(rig, matchesOf(rig, {.instants = 3, .points = 7}, random));
    EXPECT_EQ(few.gap, FootageGap::kFewPoints) << kind << " " << gapId(few.gap);
    const auto once = checked(rig, matchesOf(rig, {.instants = 1, .points = 200}, random));
    EXPECT_EQ(once.gap, FootageGap::kFewFrames) << kind << " " << gapId(once.gap);
    const auto other = checked(rig, matchesOf(rig, {.false_share = 1}, random));
    EXPECT_EQ(other.gap, FootageGap::kMovingScene) << kind << " " << gapId(other.gap);
    num_checked += 4;
  }
  EXPECT_EQ(num_checked, 28);
}

TEST(RigCheck, ExchangedImagesLieBehindTheCameras) {
  Random random(16);
  const AnyCamera camera = footageCameras()[0];
  const AnyRig rig({{"left", camera, kFootageSize, {}},
                    {"right", camera, kFootageSize, {SO3(), Eigen::Vector3d(-0.1, 0, 0)}}});
  RigPairMatches matches = matchesOf(rig, {}, random);
  EXPECT_EQ(checked(rig, matches).verdict, FootageVerdict::kConsistent);
  for (auto& instant : matches.instants) {
    for (PixelMatch& match : instant) std::swap(match.a, match.b);
  }
  const RigPairCheck check = checked(rig, matches);
  EXPECT_EQ(check.verdict, FootageVerdict::kInconsistent);
  EXPECT_TRUE(check.is_behind);
}

TEST(RigCheck, ConsistentPairsMustConnectTheCameras) {
  Random random(17);
  const AnyRig pair = pairOf(1, random);
  std::vector<MountedCamera> cameras = pair.cameras();
  cameras.push_back(cameras[1]);
  cameras[2].name = "third";
  cameras[2].camera_from_rig = SE3{SO3(), Eigen::Vector3d(0.05, 0, 0)} * cameras[2].camera_from_rig;
  const AnyRig rig(cameras);
  const RigPairMatches first = matchesOf(rig, {}, random);
  EXPECT_EQ(checkRigOnFootage(rig, std::vector{first}).verdict, FootageVerdict::kCannotTell);
  EXPECT_EQ(checkRigOnFootage(pair, std::vector{first}).verdict, FootageVerdict::kConsistent);
  const RigPairMatches none{.first = 1, .second = 2, .instants = {}};
  const RigCheck check = checkRigOnFootage(rig, std::vector{first, none});
  EXPECT_EQ(check.verdict, FootageVerdict::kCannotTell);
  EXPECT_EQ(check.pairs.at(1).gap, FootageGap::kFewPoints);
}

// Of changes that one instant determines well: how often the truth lies within 1.96 stated
// standard deviations.
TEST(RigCheck, StatedDeviationsCoverTheTruth) {
  Random random(18);
  int num_within = 0;
  int num_checked = 0;
  for (int round = 0; round < 70; ++round) {
    const AnyRig rig = pairOf(static_cast<std::size_t>(round) % kNumPairs, random);
    const RigPairMatches matches = matchesOf(rig, {.false_share = 0}, random);
    std::vector<TimedMatch> timed;
    for (std::size_t k = 0; k < matches.instants.size(); ++k) {
      for (const PixelMatch& match : matches.instants[k]) timed.push_back({match, k});
    }
    PosedPair pair{rig.camera(0).camera, rig.camera(1).camera, rig.camera(1).camera_from_rig};
    pair.second_from_first.translation.normalize();
    for (const PairFreedom& freedom : pairFreedoms(pair, {kFootageSize.width, kFootageSize.width})) {
      const bool is_open = freedom.kind == CameraChangeKind::kPrincipalPoint ||
                           freedom.kind == CameraChangeKind::kPose ||
                           freedom.kind == CameraChangeKind::kSeveral;
      if (is_open) continue;
      const PairFit fit = fitPair(pair, freedom, timed, Eigen::VectorXd::Zero(freedom.size()), 0.15);
      ASSERT_TRUE(fit.is_converged);
      for (Eigen::Index i = 0; i < freedom.size(); ++i) {
        num_within += std::abs(fit.amounts[i]) < kNormal95 * std::sqrt(fit.covariance(i, i)) ? 1 : 0;
        ++num_checked;
      }
    }
  }
  EXPECT_EQ(num_checked, 970);
  EXPECT_GE(num_within, 0.90 * num_checked);
  EXPECT_LE(num_within, 0.98 * num_checked);
}

// The cameras are not triggered together, and the rig turns or moves between their images.
TEST(RigCheck, ImagesOfDifferentInstantsAreNotBlamedOnTheRig) {
  Random random(23);
  int num_checked = 0;
  int num_wrong = 0;  // blamed or confirmed
  int num_named = 0;
  for (std::size_t kind = 0; kind < kNumPairs; ++kind) {
    for (const bool is_moving : {false, true}) {
      for (const int num_instants : {3, 8}) {
        const AnyRig rig = pairOf(kind, random);
        const Eigen::Vector3d heading = randomDirection(random);
        RigPairMatches matches{.first = 0, .second = 1, .instants = {}};
        for (int k = 0; k < num_instants; ++k) {
          std::vector<MountedCamera> cameras = rig.cameras();
          const Eigen::Vector3d way = 0.05 * random.uniform(0.5, 1.5) * heading;
          const double degrees = (is_moving ? 0.3 : 1) * random.normal();
          const SE3 between{SO3::exp(degrees * kDeg * randomDirection(random)),
                            is_moving ? way : Eigen::Vector3d::Zero()};
          cameras[1].camera_from_rig = between * cameras[1].camera_from_rig;
          matches.instants.push_back(
              matchesOf(AnyRig(cameras), {.instants = 1, .far_m = 20}, random).instants.front());
        }
        const RigPairCheck check = checked(rig, matches);
        num_wrong += check.verdict == FootageVerdict::kCannotTell ? 0 : 1;
        num_named += check.gap == FootageGap::kInstants ? 1 : 0;
        ++num_checked;
      }
    }
  }
  EXPECT_EQ(num_checked, 28);
  EXPECT_LE(num_wrong, 4);  // the lag may look like another baseline, or be too small
  EXPECT_GE(num_named, 18);

  // Right and turned rigs of which few points are seen, and of these many falsely.
  int num_synchronous = 0;
  int num_falsely_named = 0;
  for (std::size_t kind = 0; kind < kNumPairs; ++kind) {
    for (const std::size_t points : {18U, 40U}) {
      const AnyRig rig = pairOf(kind, random);
      const RigPairMatches matches =
          matchesOf(rig, {.instants = 4, .points = points, .false_share = 0.35}, random);
      for (const AnyRig& stated : {rig, turned(rig, kDeg * randomDirection(random))}) {
        num_falsely_named += checked(stated, matches).gap == FootageGap::kInstants ? 1 : 0;
        ++num_synchronous;
      }
    }
  }
  EXPECT_EQ(num_synchronous, 28);
  EXPECT_LE(num_falsely_named, 1);
}

// An error that all matches of an instant share is a hundred errors of one match.
TEST(RigCheck, InstantsThatDifferWidenTheDeviations) {
  Random random(19);
  int num_significant = 0;
  int num_within = 0;
  int num_differing = 0;
  constexpr int kRounds = 40;
  for (int round = 0; round < kRounds; ++round) {
    const AnyRig rig = pairOf(0, random);
    RigPairMatches matches = matchesOf(rig, {.instants = 8}, random);
    for (auto& instant : matches.instants) {
      const double shift = 0.3 * random.normal();
      for (PixelMatch& match : instant) match.b.y() += shift;
    }
    std::vector<TimedMatch> timed;
    for (std::size_t k = 0; k < matches.instants.size(); ++k) {
      for (const PixelMatch& match : matches.instants[k]) timed.push_back({match, k});
    }
    PosedPair pair{rig.camera(0).camera, rig.camera(1).camera, rig.camera(1).camera_from_rig};
    pair.second_from_first.translation.normalize();
    const PairFreedom freedom = pairFreedoms(pair, {640, 640}).front();
    ASSERT_EQ(freedom.kind, CameraChangeKind::kRotation);
    const PairFit fit = fitPair(pair, freedom, timed, Eigen::VectorXd::Zero(3), 0.3);
    num_differing += fit.disagreement > 2 ? 1 : 0;
    const double x = std::abs(fit.amounts[0]) / std::sqrt(fit.covariance(0, 0));
    num_within += x < kNormal95 ? 1 : 0;
    num_significant += x > 4 ? 1 : 0;
  }
  // Chi-square with seven degrees of freedom, about 12 times its expectation, stays below 2 once in 90 cases.
  EXPECT_GE(num_differing, kRounds - 2);
  EXPECT_GE(num_within, kRounds * 8 / 10);
  // Student's t with seven degrees of freedom exceeds 4 once in 200 cases.
  EXPECT_LE(num_significant, 1);
}

}  // namespace
}  // namespace alidade
