// SPDX-License-Identifier: MIT
#include "alidade/record/camera_record.h"

#include <vector>

#include <gmock/gmock.h>

#include "alidade/camera/projection_uncertainty.h"
#include "support/image_sizes.h"

namespace alidade {
namespace {

using testing::ElementsAre;

const AnyCamera kCamera = AnyCamera::make("pinhole", std::vector<double>{500, 510, 320, 240});

TEST(CameraRecord, HoldsSymmetricMatricesByTheirLowerTriangle) {
  const std::vector<double> triangle = {4, 1, 9, 2, 3, 16};
  const Eigen::MatrixXd full = fullMatrix(triangle, 3);
  EXPECT_EQ(full(0, 2), 2);
  EXPECT_EQ(full, full.transpose());
  EXPECT_EQ(lowerTriangle(full), triangle);
}

TEST(CameraRecord, StatesTheCovarianceToUse) {
  CameraRecord record = bareRecord(kCamera, kVga, "test");
  EXPECT_FALSE(statedCovariance(record).has_value());
  record.calibration.emplace();
  record.calibration->covariance = {1, 0, 1, 0, 0, 1, 0, 0, 0, 1};
  EXPECT_EQ(statedCovariance(record), Eigen::MatrixXd::Identity(4, 4));
}

TEST(BareRecord, HasADomainAndPointsToCheckItselfBy) {
  const CameraRecord record = bareRecord(kCamera, kVga, "test");
  ASSERT_TRUE(record.domain.has_value());
  EXPECT_TRUE(record.domain->full_image);
  EXPECT_FALSE(record.self_check.empty());
  EXPECT_TRUE(runSelfCheck(record.camera, record.image_size, record.self_check).isPassed());
}

}  // namespace
}  // namespace alidade
