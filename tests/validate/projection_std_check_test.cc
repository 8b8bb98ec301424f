// SPDX-License-Identifier: MIT
#include "alidade/validate/projection_std_check.h"

#include <cmath>
#include <limits>
#include <string>
#include <vector>

#include <fmt/format.h>
#include <gmock/gmock.h>

#include "alidade/camera/projection_uncertainty.h"

namespace alidade {
namespace {

constexpr ImageSize kSize{.width = 640, .height = 480};

// What a file states: in four digits, of a fisheye whose corners have no ray.
struct Stated {
  AnyCamera camera = AnyCamera::make(
      "kannala_brandt", std::vector<double>{110, 110, 319.5, 239.5, 0.01, -0.01, 0.003, -0.0005});
  std::vector<double> covariance;
  UncertaintyGrid grid;

  explicit Stated(double scale = 1) {
    const std::vector<double> sigmas = {0.1, 0.1, 0.2, 0.2, 1e-4, 2e-4, 1e-4, 5e-5};
    Eigen::MatrixXd full = Eigen::MatrixXd::Zero(8, 8);
    for (int i = 0; i < 8; ++i) {
      for (int j = 0; j < 8; ++j) {
        const double correlation = i == j ? 1 : 0.3;
        full(i, j) =
            scale * correlation * sigmas[static_cast<std::size_t>(i)] * sigmas[static_cast<std::size_t>(j)];
      }
    }
    for (int i = 0; i < 8; ++i) {
      for (int j = 0; j <= i; ++j) covariance.push_back(full(i, j));
    }
    grid = ProjectionUncertainty(camera, kSize, std::numeric_limits<double>::infinity()).grid(full);
    const auto rounded = [](double v) { return std::isfinite(v) ? std::stod(fmt::format("{:.4g}", v)) : v; };
    for (double& std : grid.std_px) std = rounded(std);
    grid.center_px = rounded(grid.center_px);
    grid.worst_px = rounded(grid.worst_px);
  }

  [[nodiscard]] CameraRecord recordOf(const std::vector<double>& triangle,
                                      const std::optional<ProjectionStdRecord>& claim) const {
    CameraRecord record = bareRecord(camera, kSize, "test");
    record.calibration.emplace();
    record.calibration->covariance = triangle;
    record.calibration->projection_std = claim;
    return record;
  }

  [[nodiscard]] Severity status() const {
    const ProjectionStdRecord claim{.center_px = grid.center_px,
                                    .worst_px = grid.worst_px,
                                    .worst_pixel = grid.worst_pixel,
                                    .columns = grid.columns,
                                    .rows = grid.rows,
                                    .std_px = grid.std_px};
    return checkProjectionStd(recordOf(covariance, claim))->severity;
  }
};

TEST(CheckProjectionStd, PassesWhatFourDigitsState) {
  int num_passed = 0;
  int num_without_ray = 0;
  for (const double scale : {1e-20, 1e-3, 1.0, 3.7, 1e6}) {
    const Stated stated(scale);
    for (const double std : stated.grid.std_px) num_without_ray += std::isnan(std) ? 1 : 0;
    num_passed += stated.status() == Severity::kPass ? 1 : 0;
  }
  EXPECT_EQ(num_passed, 5);
  EXPECT_GT(num_without_ray, 100);
}

TEST(CheckProjectionStd, FailsAnyNumberThatIsOff) {
  int num_failed = 0;
  const Stated good;
  const std::size_t middle = good.grid.std_px.size() / 2 + 20;
  ASSERT_TRUE(std::isfinite(good.grid.std_px[middle]) && std::isnan(good.grid.std_px[0]));
  const auto expectFail = [&](const auto& spoil) {
    Stated spoiled;
    spoil(spoiled);
    EXPECT_EQ(spoiled.status(), Severity::kFailure) << num_failed;
    ++num_failed;
  };
  // By two units of the fourth digit at most.
  expectFail([](Stated& s) { s.grid.center_px *= 1.002; });
  expectFail([](Stated& s) { s.grid.worst_px *= 0.998; });
  expectFail([&](Stated& s) { s.grid.std_px[middle] *= 1.002; });
  expectFail([](Stated& s) { s.grid.std_px[0] = 1; });  // no ray
  expectFail([&](Stated& s) { s.grid.std_px[middle] = std::numeric_limits<double>::quiet_NaN(); });
  expectFail([](Stated& s) { s.grid.worst_pixel = {320, 240}; });
  expectFail([](Stated& s) { s.grid.worst_pixel += Eigen::Vector2d(3, 0); });
  expectFail([](Stated& s) { std::swap(s.grid.columns, s.grid.rows); });
  expectFail([](Stated& s) { s.covariance[0] *= 1.1; });
  expectFail([](Stated& s) {
    s.grid.columns = s.grid.rows = 0;
    s.grid.std_px.clear();
  });
  expectFail([](Stated& s) {  // a long row would ask for as many rows as the image has
    s.grid.columns = 640;
    s.grid.rows = 1;
    s.grid.std_px.assign(640, 1.0);
  });
  EXPECT_EQ(num_failed, 11);
}

TEST(CheckProjectionStd, WarnsWhereOneOfTheTwoIsMissing) {
  const Stated stated;
  EXPECT_EQ(checkProjectionStd(stated.recordOf(stated.covariance, {}))->severity, Severity::kWarning);
  EXPECT_EQ(checkProjectionStd(stated.recordOf({}, ProjectionStdRecord{}))->severity, Severity::kWarning);
  EXPECT_FALSE(checkProjectionStd(stated.recordOf({}, {})).has_value());
}

}  // namespace
}  // namespace alidade
