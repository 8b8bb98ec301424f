// SPDX-License-Identifier: MIT
#include "alidade/record/camera_record.h"

#include <vector>

#include <gmock/gmock.h>

#include "alidade/camera/projection_uncertainty.h"

namespace alidade {
namespace {

using testing::ElementsAre;

const AnyCamera kCamera = AnyCamera::make("pinhole", std::vector<double>{500, 510, 320, 240});
constexpr ImageSize kSize{.width = 640, .height = 480};

TEST(CameraRecord, HoldsSymmetricMatricesByTheirLowerTriangle) {
  const std::vector<double> triangle = {4, 1, 9, 2, 3, 16};
  const Eigen::MatrixXd full = fullMatrix(triangle, 3);
  EXPECT_EQ(full(0, 2), 2);
  EXPECT_EQ(full, full.transpose());
  EXPECT_EQ(lowerTriangle(full), triangle);
}

TEST(CameraRecord, StatesTheCovarianceToUse) {
  CameraRecord record = bareRecord(kCamera, kSize, "test");
  EXPECT_FALSE(statedCovariance(record).has_value());
  EXPECT_FALSE(isStatedByViews(record));
  record.calibration.emplace();
  record.calibration->covariance = {1, 0, 1, 0, 0, 1, 0, 0, 0, 1};
  EXPECT_EQ(statedCovariance(record), Eigen::MatrixXd::Identity(4, 4));
  EXPECT_FALSE(isStatedByViews(record));
  record.calibration->stated_covariance = {4, 0, 4, 0, 0, 4, 0, 0, 0, 4};
  EXPECT_EQ(statedCovariance(record), 4 * Eigen::MatrixXd::Identity(4, 4));
  EXPECT_TRUE(isStatedByViews(record));
}

TEST(BareRecord, HasADomainAndPointsToCheckItselfBy) {
  const CameraRecord record = bareRecord(kCamera, kSize, "test");
  ASSERT_TRUE(record.domain.has_value());
  EXPECT_TRUE(record.domain->full_image);
  EXPECT_FALSE(record.self_check.empty());
  EXPECT_TRUE(runSelfCheck(record.camera, record.image_size, record.self_check).isPassed());
}

TEST(ProjectionRecord, KeepsFourDigits) {
  UncertaintyGrid grid;
  grid.columns = 2;
  grid.rows = 1;
  grid.center_px = 0.123456;
  grid.worst_px = 12345.6;
  grid.std_px = {1.00005e-7, 98.765};
  const auto record = projectionRecord(grid);
  ASSERT_TRUE(record.has_value());
  EXPECT_EQ(record->center_px, 0.1235);
  EXPECT_EQ(record->worst_px, 12350);
  EXPECT_THAT(record->std_px, ElementsAre(1e-7, 98.77));
  grid.worst_px = std::numeric_limits<double>::quiet_NaN();
  EXPECT_FALSE(projectionRecord(grid).has_value());
}

}  // namespace
}  // namespace alidade
