// SPDX-License-Identifier: MIT
#include "alidade/calibrate/weak_prior.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <vector>

#include "alidade/calibrate/start_poses.h"
#include "support/simulated_set.h"

namespace alidade {
namespace {

constexpr ImageSize kSize{.width = 1280, .height = 960};
constexpr double kNoisePx = 0.1;

bool hasFinding(const CalibrationResult& result, const char* id) {
  return std::any_of(result.findings.begin(), result.findings.end(),
                     [&](const Finding& f) { return f.id == id; });
}

// A mild lens, seen as a quotient of polynomials: what the denominator does, the numerator does as well.
std::vector<double> mildLens(Random& random) {
  return {random.uniform(900, 1300),
          random.uniform(900, 1300),
          640 + random.uniform(-20, 20),
          480 + random.uniform(-20, 20),
          random.uniform(-0.15, 0.1),
          random.uniform(-0.05, 0.05),
          random.uniform(-1e-3, 1e-3),
          random.uniform(-1e-3, 1e-3),
          0,
          0,
          0,
          0};
}

struct Errors {
  double sum = 0;  // of squares over the variance that was stated, an axis
  double largest = 0;
  int count = 0;
};

// Of the projection of rays all over the image, in stated sigmas.
void addErrors(const CalibrationResult& result, const AnyCamera& truth, Errors& errors) {
  const auto n = static_cast<Eigen::Index>(truth.parameters().size());
  Eigen::Matrix<double, 2, Eigen::Dynamic, Eigen::RowMajor> J(2, n);
  for (int x = 0; x <= 8; ++x) {
    for (int y = 0; y <= 6; ++y) {
      const Eigen::Vector2d pixel(x / 8.0 * (kSize.width - 1), y / 6.0 * (kSize.height - 1));
      const auto ray = truth.unproject(pixel);
      ASSERT_TRUE(ray);
      const Projection found =
          result.camera.visit([&](const auto& camera) { return camera.project(*ray, nullptr, J.data()); });
      ASSERT_TRUE(found.ok());
      const Eigen::Matrix2d covariance = J * *result.covariance * J.transpose();
      const Eigen::Vector2d error = found.pixel - pixel;
      for (int axis = 0; axis < 2; ++axis) {
        const double share = error(axis) * error(axis) / covariance(axis, axis);
        errors.sum += share;
        errors.largest = std::max(errors.largest, std::sqrt(share));
        ++errors.count;
      }
    }
  }
}

TEST(WeakPrior, KeepsARationalLensWithinReason) {
  int num_held = 0;
  int num_sets = 0;
  for (const int num_views : {12, 30}) {
    Errors errors;
    for (std::uint64_t seed = 1; seed <= 12; ++seed) {
      SCOPED_TRACE(testing::Message() << num_views << " views, seed " << seed);
      Random random(streamSeed(77, seed));
      std::vector<double> params = mildLens(random);
      params[1] = params[0] * random.uniform(0.995, 1.005);
      const AnyCamera truth = AnyCamera::make("rational", params);
      const SimulatedSet set = simulateSet(truth, kSize, num_views, kNoisePx, seed);
      const CalibrationResult result = calibrate(set.board, set.views, {.model = "rational"});
      ASSERT_TRUE(result.isTrustworthy()) << result.findings.front().message << result.weak_prior.width;
      ASSERT_TRUE(result.covariance);
      for (std::size_t i = 4; i < params.size(); ++i) {
        EXPECT_LT(std::abs(result.camera.parameters()[i]), 10) << result.camera.parameterNames()[i];
      }
      const bool is_held = !result.weak_prior.isNone();
      EXPECT_EQ(hasFinding(result, "ill_conditioned"), is_held);
      EXPECT_EQ(result.weak_prior.least_known.empty(), !is_held);
      num_held += is_held ? 1 : 0;
      addErrors(result, truth, errors);
      ++num_sets;
    }
    std::printf("%d views: error %.2f stated sigmas in the mean, %.2f at most, of %d\n", num_views,
                std::sqrt(errors.sum / errors.count), errors.largest, errors.count);
    EXPECT_EQ(errors.count, 12 * 63 * 2);
    // Errors of one set go together: twelve sets scatter by a fifth.
    EXPECT_LT(std::sqrt(errors.sum / errors.count), 1.4);
    EXPECT_LT(errors.largest, 5);
  }
  EXPECT_EQ(num_sets, 24);
  EXPECT_GE(num_held, 12) << "or these lenses are not mild";
}

TEST(WeakPrior, LeavesAloneWhatIsDetermined) {
  const std::vector<double> params = {1003, 1001, 645, 475, -0.28, 0.08, 8e-4, -4e-4, -0.01};
  const AnyCamera truth = AnyCamera::make("radtan", params);
  double largest_change = 0;
  int num_sets = 0;
  for (std::uint64_t seed = 1; seed <= 10; ++seed) {
    const SimulatedSet set = simulateSet(truth, kSize, 12, kNoisePx, seed);
    const CalibrationResult result = calibrate(set.board, set.views);
    EXPECT_TRUE(result.weak_prior.isNone());
    EXPECT_FALSE(hasFinding(result, "ill_conditioned"));
    // Even if the widest prior were there, it would not show.
    std::vector<Eigen::Vector3d> rays;
    BundleState state{.params = {}, .camera_from_board = {}};
    state.params.assign(result.camera.parameters().begin(), result.camera.parameters().end());
    for (std::size_t v = 0; v < set.views.size(); ++v) {
      state.camera_from_board.push_back(result.views[v].camera_from_board);
      for (const Corner& corner : set.views[v].corners)
        rays.push_back(state.camera_from_board.back() * set.board.corner(corner.id));
    }
    ASSERT_TRUE(result.outliers.empty());
    const LensScale scale = lensScale("radtan", result.camera, rays, kSize);
    const double variance = result.coordinate_sigma_px * result.coordinate_sigma_px;
    const auto observations = observationsOf(set.board, set.views);
    BundleOptions options;
    options.loss = result.loss;
    options.prior = scale.prior(10, variance);
    ASSERT_EQ(solveBundle("radtan", observations, state, options).termination, Termination::kConverged);
    for (std::size_t i = 0; i < params.size(); ++i) {
      const double change = std::abs(state.params[i] - result.camera.parameters()[i]);
      largest_change = std::max(largest_change, change / result.parameterStd(static_cast<int>(i)));
    }
    ++num_sets;
  }
  std::printf("the widest prior moves parameters by %.1e sigma\n", largest_change);
  EXPECT_EQ(num_sets, 10);
  EXPECT_LT(largest_change, 1e-3);
  EXPECT_GT(largest_change, 0) << "the prior counts";
}

// Boards that keep to the middle leave k3 to noise, which may fold the lens in the corners.
TEST(WeakPrior, UnfoldsALensInCornersThatNoBoardReached) {
  const std::vector<double> params = {900, 900, 640, 480, -0.28, 0.09, 5e-4, -4e-4, -0.012};
  const AnyCamera truth = AnyCamera::make("radtan", params);
  int num_held = 0;
  int num_sets = 0;
  for (std::uint64_t seed = 1; seed <= 40; ++seed) {
    SimulatedSet set = simulateSet(truth, kSize, 12, 0.3, seed);
    for (View& view : set.views) {
      std::erase_if(view.corners,
                    [](const Corner& c) { return (c.pixel - Eigen::Vector2d(640, 480)).norm() > 400; });
    }
    std::erase_if(set.views, [](const View& view) { return view.corners.size() < 18; });
    if (set.views.size() < 8) continue;
    const CalibrationResult result = calibrate(set.board, set.views);
    EXPECT_TRUE(result.domain.full_image || hasFinding(result, "folds_in_image"));
    if (!result.weak_prior.isNone()) {
      EXPECT_TRUE(result.domain.full_image);
      EXPECT_TRUE(hasFinding(result, "ill_conditioned"));
      for (std::size_t i = 4; i < params.size(); ++i) {
        EXPECT_LT(std::abs(result.camera.parameters()[i] - params[i]),
                  5 * result.parameterStd(static_cast<int>(i)))
            << seed << " " << result.camera.parameterNames()[i];
      }
      ++num_held;
    }
    ++num_sets;
  }
  std::printf("%d of %d sets would fold\n", num_held, num_sets);
  EXPECT_GE(num_sets, 20);
  EXPECT_GE(num_held, 1) << "nothing to be seen here otherwise";
}

TEST(WeakPrior, NarrowPriorsDoNotMakeSigmasSmall) {
  LensScale scale{.mean = Eigen::VectorXd::Zero(5), .size = Eigen::VectorXd::Zero(5)};
  scale.size(4) = 2;
  Eigen::MatrixXd information = Eigen::MatrixXd::Identity(5, 5);
  information(4, 4) = 0;  // the views say nothing of the lens
  constexpr double kVariance = 0.04;
  double previous = std::numeric_limits<double>::infinity();
  int num_widths = 0;
  for (const double width : {10.0, 1.0, 0.1, 0.03}) {
    const WeakPrior held{.width = width, .prior = scale.prior(width, kVariance), .scale = scale};
    const auto covariance = heldCovariance(information, held, kVariance, {});
    ASSERT_TRUE(covariance);
    const double sigma = std::sqrt((*covariance)(4, 4));
    EXPECT_NEAR(sigma, 2 * std::max(width, 1.0), 1e-9) << "a natural size at least";
    EXPECT_LE(sigma, previous + 1e-9);
    EXPECT_NEAR((*covariance)(0, 0), kVariance, 1e-12);
    previous = sigma;
    ++num_widths;
  }
  EXPECT_EQ(num_widths, 4);
}

}  // namespace
}  // namespace alidade
