// SPDX-License-Identifier: MIT
#include "alidade/validate/camera_checks.h"

#include <gmock/gmock.h>

#include <algorithm>

namespace alidade {
namespace {

constexpr ImageSize kSize{.width = 640, .height = 480};
const std::vector<double> kGood = {535, 534, 322, 238, -0.28, 0.08, 8e-4, -4e-4, -0.01};

Severity statusOf(const std::vector<Diagnosis>& checks, const std::string& id) {
  const auto check =
      std::find_if(checks.begin(), checks.end(), [&](const Diagnosis& c) { return c.id == id; });
  if (check == checks.end()) throw std::out_of_range(id);
  return check->severity;
}

// Checks of `params` with the claims of `claimed`, as if a file's numbers had been edited.
std::vector<Diagnosis> checksOf(const std::vector<double>& params,
                                const std::vector<double>& claimed = kGood) {
  const AnyCamera camera = AnyCamera::make("radtan", params);
  const AnyCamera original = AnyCamera::make("radtan", claimed);
  CameraRecord record = bareRecord(original, kSize, "test");
  record.camera = camera;
  return checkCamera(record);
}

TEST(CheckCamera, PassesAGoodCamera) {
  const std::vector<Diagnosis> checks = checksOf(kGood);
  EXPECT_EQ(checks.size(), 8U);
  for (const Diagnosis& check : checks) {
    EXPECT_EQ(check.severity,
              check.id == "covariance" || check.id == "calibration" ? Severity::kWarning : Severity::kPass)
        << check.id;
    EXPECT_FALSE(check.cause.empty() || check.evidence.empty() || check.limit.empty()) << check.id;
  }
}

TEST(CheckCamera, SelfCheckCatchesEveryEditedParameter) {
  int num_caught = 0;
  for (std::size_t i = 0; i < kGood.size(); ++i) {
    std::vector<double> edited = kGood;
    edited[i] += i < 4 ? 1e-4 : 1e-6;
    num_caught += statusOf(checksOf(edited), "self_check") == Severity::kFailure ? 1 : 0;
  }
  EXPECT_EQ(num_caught, 9);
}

TEST(CheckCamera, CatchesAFoldInTheImage) {
  EXPECT_EQ(statusOf(checksOf({535, 535, 320, 240, -0.4, 0, 0, 0, 0}), "one_to_one"), Severity::kFailure);
}

TEST(CheckCamera, CatchesAStatedDomainThatIsNotTheParameters) {
  EXPECT_EQ(statusOf(checksOf({535, 534, 322, 238, -0.25, 0.08, 8e-4, -4e-4, -0.01}), "domain"),
            Severity::kFailure);
}

TEST(CheckCamera, JudgesAspectFocalLengthAndPrincipalPoint) {
  const auto status = [](std::size_t i, double value, const char* id) {
    std::vector<double> params = kGood;
    params[i] = value;
    return statusOf(checksOf(params), id);
  };
  EXPECT_EQ(status(0, 560, "aspect"), Severity::kWarning);
  EXPECT_EQ(status(0, 900, "aspect"), Severity::kFailure);
  EXPECT_EQ(status(0, 2e5, "focal_length"), Severity::kWarning);
  EXPECT_EQ(status(2, 450, "principal_point"), Severity::kWarning);
  EXPECT_EQ(status(2, 700, "principal_point"), Severity::kFailure);
}

TEST(CheckCamera, BelievesACalibrationThatDoubtsItself) {
  const AnyCamera camera = AnyCamera::make("radtan", kGood);
  CameraRecord record = bareRecord(camera, kSize, "test");
  record.calibration.emplace();
  record.calibration->verdict = Verdict::kNo;
  EXPECT_EQ(statusOf(checkCamera(record), "calibration"), Severity::kFailure);
  record.calibration->verdict = Verdict::kTrustworthy;
  EXPECT_EQ(statusOf(checkCamera(record), "calibration"), Severity::kPass);
}

TEST(CheckCamera, CatchesACovarianceThatIsNone) {
  const std::vector<double> params = {535, 534, 322, 238};
  const AnyCamera camera = AnyCamera::make("pinhole", params);
  const std::vector<double> good = {4, 1, 4, 0, 0, 1, 0, 0, 0.1, 1};
  const std::vector<double> indefinite = {4, 9, 4, 0, 0, 1, 0, 0, 0.1, 1};
  const std::vector<double> std = {2, 2, 1, 1};
  const std::vector<double> other_std = {2, 2, 1, 1.1};
  const auto status = [&](const std::vector<double>& covariance, const std::vector<double>& parameter_std) {
    CameraRecord record = bareRecord(camera, kSize, "test");
    record.calibration.emplace();
    record.calibration->covariance = covariance;
    record.calibration->parameter_std = parameter_std;
    return statusOf(checkCamera(record), "covariance");
  };
  EXPECT_EQ(status(good, std), Severity::kPass);
  EXPECT_EQ(status(good, other_std), Severity::kFailure);
  EXPECT_EQ(status(indefinite, std), Severity::kFailure);
  // fx = fy, and cy held.
  EXPECT_EQ(status({4, 4, 4, 0, 0, 1, 0, 0, 0, 0}, {2, 2, 1, 0}), Severity::kPass);
  // A covariance without a variance.
  EXPECT_EQ(status({4, 1, 4, 0, 0, 1, 0, 0, 0.1, 0}, {2, 2, 1, 0}), Severity::kFailure);
}

}  // namespace
}  // namespace alidade
