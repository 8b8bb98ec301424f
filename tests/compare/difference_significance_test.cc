// SPDX-License-Identifier: MIT
#include "alidade/compare/projection_difference.h"

#include <cmath>
#include <map>
#include <string_view>

#include <gmock/gmock.h>

#include "alidade/calibrate/calibrator.h"
#include "alidade/camera/camera_edit.h"
#include "alidade/core/random.h"
#include "support/image_sizes.h"
#include "support/simulated_set.h"

namespace alidade {
namespace {

AnyCamera truth() {
  return AnyCamera::make("radtan", std::vector<double>{533, 532, 342, 234, -0.15, 0.05, 1e-3, -5e-4, 0});
}

// What a calibration by 12 views knows of the camera.
const Eigen::MatrixXd& typicalCovariance() {
  static const Eigen::MatrixXd covariance = [] {
    const SimulatedSet set = simulateSet(truth(), kVga, 12, 0.1, 3);
    return calibrate(set.board, set.views, {.model = "radtan"}).uncertainty.covariance.value();
  }();
  return covariance;
}

AnyCamera drawn(const Eigen::MatrixXd& covariance, Random& random) {
  Eigen::VectorXd z(covariance.rows());
  for (double& value : z) value = random.normal();
  const AnyCamera camera = truth();
  const Eigen::VectorXd step = covariance.llt().matrixL() * z;
  std::vector<double> params(camera.parameters().begin(), camera.parameters().end());
  for (std::size_t i = 0; i < params.size(); ++i) params[i] += step(static_cast<Eigen::Index>(i));
  return AnyCamera::make("radtan", params);
}

TEST(DifferenceSignificance, IsThatOfChanceForTwoEstimatesOfOneCamera) {
  // Small enough for first order to hold in the corners, where no board was.
  const Eigen::MatrixXd covariance = typicalCovariance() / 100;
  Random random(11);
  constexpr int kPairs = 300;
  int num_significant = 0;
  int num_above_one_sigma = 0;
  int num_beyond = 0;
  double share_beyond = 0;
  double mean_square = 0;
  double expected = 0;
  for (int i = 0; i < kPairs; ++i) {
    const AnyCamera a = drawn(covariance, random);
    const AnyCamera b = drawn(covariance, random);
    const ComparedCamera in_a{&a, kVga, covariance};
    const ComparedCamera in_b{&b, kVga, covariance};
    const DifferenceOptions options{.columns = 12, .rows = 9};
    const auto difference = projectionDifference(in_a, in_b, options);
    const auto significance = significanceOf(difference, in_a, in_b, options.freed);
    ASSERT_TRUE(significance);
    num_significant += significance->isSignificant() ? 1 : 0;
    num_above_one_sigma += significance->sigmas > 1 ? 1 : 0;
    num_beyond += agreementOf(difference, significance, 0.0) == Agreement::kBeyond ? 1 : 0;
    share_beyond += significance->share_beyond / kPairs;
    mean_square += difference.rms_px * difference.rms_px / kPairs;
    expected += significance->expected_rms_px * significance->expected_rms_px / kPairs;
  }
  EXPECT_LE(num_significant, 9);           // 1 % of 300 is 3
  EXPECT_EQ(num_beyond, num_significant);  // beyond any tolerance
  EXPECT_NEAR(static_cast<double>(num_above_one_sigma) / kPairs, 0.16, 0.06);
  EXPECT_NEAR(share_beyond, 0.05, 0.02);
  EXPECT_NEAR(std::sqrt(mean_square / expected), 1, 0.15);
}

TEST(DifferenceSignificance, SeesWhatTheCovariancesDoNotExplain) {
  const AnyCamera a = truth();
  std::vector<double> params(a.parameters().begin(), a.parameters().end());
  params[0] *= 1.01;
  params[1] *= 1.01;
  const AnyCamera b = AnyCamera::make("radtan", params);
  int num_checked = 0;
  // As seen from either side, and by one whose covariance is unknown.
  for (const auto& [by_a, by_b] :
       {std::pair(true, true), std::pair(true, false), std::pair(false, true), std::pair(false, false)}) {
    const ComparedCamera in_a{&a, kVga, by_a ? std::optional(typicalCovariance()) : std::nullopt};
    const ComparedCamera in_b{&b, kVga, by_b ? std::optional(typicalCovariance()) : std::nullopt};
    const auto difference = projectionDifference(in_a, in_b);
    const auto significance = significanceOf(difference, in_a, in_b, Freed::kRotation);
    ASSERT_EQ(significance.has_value(), by_a || by_b);
    EXPECT_TRUE(!significance || significance->isSignificant());
    EXPECT_EQ(agreementOf(difference, significance, 0.3), Agreement::kBeyond);
    EXPECT_EQ(agreementOf(difference, significance, 30), Agreement::kWithin);
    ++num_checked;
  }
  EXPECT_EQ(num_checked, 4);
}

// Two cameras that are known badly may be far apart.
TEST(DifferenceSignificance, DoesNotTakeChanceForADifference) {
  const AnyCamera a = truth();
  Random random(2);
  const Eigen::MatrixXd poor = 400 * typicalCovariance();
  const AnyCamera b = drawn(poor, random);
  const ComparedCamera in_a{&a, kVga, poor};
  const ComparedCamera in_b{&b, kVga, poor};
  const auto difference = projectionDifference(in_a, in_b);
  ASSERT_GT(difference.p95_px, 0.3);
  EXPECT_EQ(agreementOf(difference, significanceOf(difference, in_a, in_b, Freed::kRotation), 0.3),
            Agreement::kUncertain);
}

// How often pairs of estimates get each answer, for cameras that are equal and for those that are not.
TEST(DifferenceSignificance, AnswersForEqualAndChangedCameras) {
  constexpr int kPairs = 40;
  constexpr double kTolerancePx = 0.5;
  // The RMS difference that typicalCovariance() predicts for two estimates, px.
  const double typical_px = [] {
    const AnyCamera camera = truth();
    const ComparedCamera both{&camera, kVga, typicalCovariance()};
    return significanceOf(projectionDifference(both, both), both, both, Freed::kRotation)->expected_rms_px;
  }();
  const auto answers = [&](double predicted_px, double change) {
    const Eigen::MatrixXd covariance = typicalCovariance() * std::pow(predicted_px / typical_px, 2);
    Random random(5);
    std::map<std::string_view, int> counts;
    for (int i = 0; i < kPairs; ++i) {
      const AnyCamera a = drawn(covariance, random);
      const AnyCamera near = drawn(covariance, random);
      std::vector<double> params(near.parameters().begin(), near.parameters().end());
      params[0] *= 1 + change;
      params[1] *= 1 + change;
      const AnyCamera b = near.withParameters(params);
      const ComparedCamera in_a{&a, kVga, covariance};
      const ComparedCamera in_b{&b, kVga, covariance};
      const auto difference = projectionDifference(in_a, in_b, {.columns = 12, .rows = 9});
      ++counts[answerOf(
          agreementOf(difference, significanceOf(difference, in_a, in_b, Freed::kRotation), kTolerancePx))];
    }
    return counts;
  };
  // Known well: equal cameras are the same, and 1 % of focal length is a change of 3 px in the corners.
  const auto equal = answers(0.05, 0);
  EXPECT_GE(equal.at("same"), 38);
  EXPECT_EQ(equal.count("changed"), 0U);
  EXPECT_EQ(answers(0.05, 0.01).at("changed"), kPairs);
  // Known badly: neither is told from the other.
  EXPECT_EQ(answers(2, 0).at("cannot tell"), kPairs);
  const auto unknown = answers(4, 0.002);
  EXPECT_EQ(unknown.count("same"), 0U);
  EXPECT_GE(unknown.at("cannot tell"), 38);
}

TEST(DifferenceSignificance, IsSymmetricWhateverTheResolution) {
  const AnyCamera a = truth();
  Random random(4);
  const AnyCamera other = drawn(25 * typicalCovariance(), random);
  const EditedCamera half = resizeCamera(other, kVga, {.width = 320, .height = 240});
  const EditedCamera turned = rotateCamera(half.camera, half.size, 3);
  const Eigen::MatrixXd J = turned.J_new_old.view() * half.J_new_old.view();
  const ComparedCamera in_a{&a, kVga, typicalCovariance()};
  const ComparedCamera in_b{&turned.camera, turned.size, J * typicalCovariance() * J.transpose()};
  int num_checked = 0;
  for (const Freed freed : {Freed::kRotation, Freed::kPose}) {
    const auto there = projectionDifference(in_a, in_b, {.freed = freed});
    const auto back = projectionDifference(in_b, in_a, {.freed = freed});
    const auto by_there = significanceOf(there, in_a, in_b, freed);
    const auto by_back = significanceOf(back, in_b, in_a, freed);
    EXPECT_NEAR(there.rms_px, back.rms_px, 1e-7);
    EXPECT_NEAR(by_there->sigmas, by_back->sigmas, 1e-4);
    EXPECT_NEAR(by_there->expected_rms_px, by_back->expected_rms_px, 1e-6);
    EXPECT_NEAR(by_there->sure_p95_px, by_back->sure_p95_px, 1e-6);
    EXPECT_EQ(by_there->share_beyond, by_back->share_beyond);
    // A camera at half the size is the same difference as at its own.
    const ComparedCamera whole{&other, kVga, typicalCovariance()};
    const auto plain = projectionDifference(in_a, whole, {.freed = freed, .columns = 40, .rows = 30});
    EXPECT_NEAR(there.rms_px / plain.rms_px, 1, 0.05);
    ++num_checked;
  }
  EXPECT_EQ(num_checked, 2);
}

}  // namespace
}  // namespace alidade
