// SPDX-License-Identifier: MIT
#include "alidade/calibrate/uncertainty/view_evidence.h"

#include <gmock/gmock.h>

#include <algorithm>
#include <cmath>
#include <string>

#include "alidade/calibrate/calibrator.h"
#include "support/spoiled_set.h"

namespace alidade {
namespace {

constexpr const char* kModels[] = {"radtan", "kannala_brandt"};

Calibration run(const SimulatedSet& set) {
  return calibrate(set.board, set.views, {.model = std::string(set.camera.modelId())});
}

std::vector<std::string> named(const Calibration& result, std::string_view id) {
  std::vector<std::string> images;
  for (const Diagnosis& finding : result.diagnoses) {
    if (finding.id == id) images.push_back(finding.message().substr(0, finding.message().find(':')));
  }
  return images;
}

// The most that any function of the parameters moves by is the length of the step in their own metric.
double moveSigmas(const Calibration& with, const Calibration& without) {
  const auto a = onlyCamera(with.fit).params;
  const auto b = onlyCamera(without.fit).params;
  Eigen::VectorXd step(a.size());
  for (std::size_t i = 0; i < a.size(); ++i) step(static_cast<Eigen::Index>(i)) = b[i] - a[i];
  return std::sqrt(step.dot(with.uncertainty.covariance->view().ldlt().solve(step)));
}

TEST(ViewInfluence, IsWhatLeavingTheViewOutDoes) {
  int num_checked = 0;
  for (const char* model : kModels) {
    const SimulatedSet set = cleanSet(model, 12, 3);
    const Calibration all = run(set);
    for (std::size_t v = 0; v < all.fit.views.size(); v += 2) {
      std::vector<View> views = set.views;
      std::erase_if(views, [&](const View& view) { return view.image == all.fit.views[v].image; });
      const double truth = moveSigmas(all, calibrate(set.board, views, {.model = model}));
      // Of first order, and the loss weighs some corners anew.
      EXPECT_NEAR(all.uncertainty.influences[v].move_sigmas, truth, 0.15 * truth + 0.1)
          << all.fit.views[v].image;
      ++num_checked;
    }
  }
  EXPECT_EQ(num_checked, 12);
}

TEST(ViewInfluence, AFaintlyBentViewIsNamedAndCleanOnesAreNot) {
  int num_found = 0;
  int num_sets = 0;
  for (const char* model : kModels) {
    for (std::uint64_t seed = 1; seed <= 8; ++seed) {
      SimulatedSet set = cleanSet(model, 15, seed);
      EXPECT_THAT(named(run(set), "influential_view"), testing::IsEmpty());
      const auto bad = spoilViews(set, Spoiler::kFaint, 1, seed);
      const Calibration result = run(set);
      auto images = named(result, "influential_view");
      for (const ExcludedView& view : result.dropped.views) images.push_back(view.image);
      for (const std::string& image : images) EXPECT_EQ(image.substr(0, image.find(' ')), bad.front());
      if (!images.empty()) ++num_found;
      ++num_sets;
    }
  }
  EXPECT_EQ(num_sets, 16);
  EXPECT_GE(num_found, 14);
}

TEST(BoardStretch, IsFoundWithItsSigma) {
  int num_checked = 0;
  for (const char* model : kModels) {
    for (const double stretch : {0.005, -0.005}) {
      const Calibration result = run(stretchedSet(model, 25, 1 + stretch, 11));
      ASSERT_FALSE(result.uncertainty.common_errors.empty());
      const CommonError& found = result.uncertainty.common_errors.front();
      ASSERT_EQ(found.cause, CommonCause::kStretch);
      // Of first order: a hundredth of the stretch is left.
      EXPECT_NEAR(found.value, stretch, 4 * found.sigma);
      EXPECT_LT(found.sigma, 5e-4);
      EXPECT_EQ(named(result, "board_not_square").size(), 1U);
      ++num_checked;
    }
  }
  EXPECT_EQ(num_checked, 4);
}

TEST(BoardStretch, OfSquareBoardsIsWithinItsSigma) {
  double sum = 0;
  int num_sets = 0;
  for (const char* model : kModels) {
    for (std::uint64_t seed = 1; seed <= 15; ++seed) {
      const Calibration result = run(cleanSet(model, 12, 100 + seed));
      ASSERT_FALSE(result.uncertainty.common_errors.empty());
      const CommonError& found = result.uncertainty.common_errors.front();
      ASSERT_EQ(found.cause, CommonCause::kStretch);
      EXPECT_TRUE(named(result, "board_not_square").empty());
      const double z = found.value / found.sigma;
      sum += z * z;
      ++num_sets;
    }
  }
  EXPECT_EQ(num_sets, 30);
  // Chi-square of 30: 1 in 1000 outside. The larger of two sigmas makes it a little small.
  EXPECT_GT(sum / num_sets, 0.38);
  EXPECT_LT(sum / num_sets, 1.99);
}

// A set whose views all have one error of this size.
SimulatedSet setWith(CommonCause cause, double size, std::uint64_t seed) {
  SimulatedSet set = simulateSet(spoiledCamera("radtan"), kSpoiledSize, 30, 0, seed, {}, kSpoiledBoard);
  Random random(seed);
  const Eigen::Vector3d middle = set.board.middle();
  for (std::size_t v = 0; v < set.views.size(); ++v) {
    const SE3& pose = set.poses[v];
    std::vector<double> params(set.camera.parameters().begin(), set.camera.parameters().end());
    if (cause == CommonCause::kFocus) {
      for (const std::size_t i : {0U, 1U}) params[i] *= 1 + size / (pose * middle).norm();
    }
    const AnyCamera camera = AnyCamera::make("radtan", params);
    for (Corner& corner : set.views[v].corners) {
      Eigen::Vector3d p = set.board.corner(corner.id);
      const Eigen::Vector3d out = p - middle;
      const double X = out.x() / middle.x();
      const double Y = out.y() / middle.y();
      if (cause == CommonCause::kGradingX) p.x() += size * middle.x() * X * X;
      if (cause == CommonCause::kGradingY) p.y() += size * middle.y() * Y * Y;
      if (cause == CommonCause::kTwist) p.z() += size * middle.x() * X * Y;
      Eigen::Vector3d p_cam = pose * p;
      if (cause == CommonCause::kPupil)
        p_cam.z() -= size * std::pow(std::atan2(p_cam.head<2>().norm(), p_cam.z()), 2);
      corner.pixel = camera.project(p_cam).pixel;
      if (cause == CommonCause::kOutward) {
        const Eigen::Vector2d beyond = camera.project(pose * (p + 1e-3 * out)).pixel - corner.pixel;
        corner.pixel += size * (X * X + Y * Y) * beyond.normalized();
      }
      corner.pixel += 0.1 * Eigen::Vector2d(random.normal(), random.normal());
    }
  }
  return set;
}

TEST(CommonErrors, AreFoundWithTheirSigmasAndToldApart) {
  struct Case {
    CommonCause cause;
    double size;
    const char* id;
  };
  int num_checked = 0;
  int num_beside = 0;
  for (const Case& c :
       {Case{CommonCause::kGradingX, 3e-3, "board_graded"},
        Case{CommonCause::kGradingY, -3e-3, "board_graded"}, Case{CommonCause::kTwist, 8e-3, "board_twisted"},
        Case{CommonCause::kPupil, 0.02, "centre_moves"}, Case{CommonCause::kFocus, 5e-3, "focus_breathes"},
        Case{CommonCause::kOutward, 0.15, "corners_biased"}}) {
    for (const std::uint64_t seed : {31U, 32U}) {
      const Calibration result = run(setWith(c.cause, c.size, seed));
      for (const CommonError& found : result.uncertainty.common_errors) {
        if (found.cause == c.cause) {
          EXPECT_NEAR(found.value, c.size, 4 * found.sigma + 0.02 * std::abs(c.size)) << c.id << " " << seed;
        } else if (found.isSignificant()) {
          ++num_beside;
        }
      }
      EXPECT_EQ(named(result, c.id).size(), 1U) << c.id << " " << seed;
      ++num_checked;
    }
  }
  EXPECT_EQ(num_checked, 12);
  EXPECT_LE(num_beside, 2) << "of 72 others, beside the one that is there";
}

TEST(BoardStretch, CannotBeToldFromFxByViewsThatFaceTheBoard) {
  SimulatedSet set = simulateSet(spoiledCamera("radtan"), kSpoiledSize, 10, 0.1, 12,
                                 {.max_tilt_deg = 0, .max_roll_deg = 0}, kSpoiledBoard);
  const Calibration result = run(set);
  EXPECT_TRUE(named(result, "board_not_square").empty());
}

}  // namespace
}  // namespace alidade
