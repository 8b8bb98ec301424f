// SPDX-License-Identifier: MIT
#include "alidade/validate/camera_checks.h"

#include <gmock/gmock.h>

#include <algorithm>

#include "support/image_sizes.h"

namespace alidade {
namespace {

const std::vector<double> kGood = {535, 534, 322, 238, -0.28, 0.08, 8e-4, -4e-4, -0.01};

Severity statusOf(const std::vector<FileCheck>& checks, const std::string& id) {
  const auto check =
      std::find_if(checks.begin(), checks.end(), [&](const FileCheck& c) { return c.id == id; });
  if (check == checks.end()) throw std::out_of_range(id);
  return check->severity;
}

// Checks of `params` with the claims of `claimed`, as if a file's numbers had been edited.
std::vector<FileCheck> checksOf(const std::vector<double>& params,
                                const std::vector<double>& claimed = kGood) {
  const AnyCamera camera = AnyCamera::make("radtan", params);
  const AnyCamera original = AnyCamera::make("radtan", claimed);
  CameraRecord record = bareRecord(original, kVga, "test");
  record.camera = camera;
  return checkCamera(record);
}

TEST(CheckCamera, PassesAGoodCamera) {
  const std::vector<FileCheck> checks = checksOf(kGood);
  std::size_t num_values = 0;
  for (const FileCheck& check : checks) {
    EXPECT_EQ(check.severity, Severity::kPass) << check.id << ": " << check.message;
    EXPECT_FALSE(check.message.empty()) << check.id;
    num_values += check.values.size();
  }
  EXPECT_EQ(checks.size(), 7U);
  EXPECT_EQ(num_values, 21U);
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

// As read from another program's file: without anything that proves the numbers.
FileCheck bareCheck(const std::vector<double>& params, const std::string& id, ImageSize size = kVga,
                    bool is_size_guessed = false, const std::optional<Eigen::Vector2d>& rectified_center = {},
                    const std::string& model = "radtan") {
  const CameraRecord record{.camera = AnyCamera::make(model, params),
                            .image_size = size,
                            .domain = {},
                            .self_check = {},
                            .calibration = {},
                            .created_by = {}};
  const std::vector<FileCheck> checks = checkCamera(record, is_size_guessed, rectified_center);
  const auto check =
      std::find_if(checks.begin(), checks.end(), [&](const FileCheck& c) { return c.id == id; });
  if (check == checks.end()) throw std::out_of_range(id);
  return *check;
}

TEST(CheckCamera, JudgesNumbersByTheImage) {
  struct Case {
    std::size_t parameter;
    double value;
    const char* id;
    Severity severity;
  };
  const std::vector<Case> cases = {{0, 560, "aspect", Severity::kPass},
                                   {0, 640, "aspect", Severity::kWarning},
                                   {0, 900, "aspect", Severity::kFailure},
                                   {0, 0.53, "focal_length", Severity::kFailure},
                                   {0, 26, "focal_length", Severity::kPass},
                                   {0, 1.9e5, "focal_length", Severity::kPass},
                                   {0, 2e5, "focal_length", Severity::kFailure},
                                   {2, 365, "principal_point", Severity::kPass},
                                   {2, 400, "principal_point", Severity::kNote},
                                   {2, 450, "principal_point", Severity::kWarning},
                                   {2, 700, "principal_point", Severity::kFailure},
                                   {6, 0.008, "tangential", Severity::kPass},
                                   {6, 0.02, "tangential", Severity::kWarning},
                                   {6, 1.2, "tangential", Severity::kFailure}};
  int num_judged = 0;
  for (const Case& c : cases) {
    std::vector<double> params = kGood;
    params[8] = 0;
    params[c.parameter] = c.value;
    const FileCheck check = bareCheck(params, c.id);
    EXPECT_EQ(check.severity, c.severity) << c.value << " " << check.message;
    ++num_judged;
  }
  EXPECT_EQ(num_judged, 14);
}

TEST(CheckCamera, SeesAnImageSizeThatDoesNotFit) {
  struct Case {
    ImageSize size;
    Severity severity;
  };
  // Sizes for the numbers of a 640x480 image.
  const std::vector<Case> cases = {{{.width = 640, .height = 480}, Severity::kPass},
                                   {{.width = 656, .height = 496}, Severity::kPass},
                                   {{.width = 1280, .height = 960}, Severity::kFailure},
                                   {{.width = 320, .height = 240}, Severity::kFailure},
                                   {{.width = 800, .height = 600}, Severity::kFailure},
                                   {{.width = 512, .height = 384}, Severity::kFailure},
                                   {{.width = 1280, .height = 720}, Severity::kFailure},
                                   {{.width = 1920, .height = 1080}, Severity::kFailure},
                                   {{.width = 480, .height = 640}, Severity::kFailure},
                                   {{.width = 640, .height = 360}, Severity::kWarning}};
  int num_judged = 0;
  for (const Case& c : cases) {
    const FileCheck check = bareCheck(kGood, "principal_point", c.size);
    EXPECT_EQ(check.severity, c.severity) << c.size.width << " " << check.message;
    ++num_judged;
  }
  EXPECT_EQ(num_judged, 10);
}

// Rows or columns that were cut off at one end: the size is that before.
TEST(CheckCamera, NamesTheSizeThatAnImageMayHaveBeenCroppedFrom) {
  struct Case {
    double cx, cy;
    ImageSize size;
    Severity severity;
    std::string from;
  };
  const std::vector<Case> cases = {{640.2, 462.8, {1280, 720}, Severity::kNote, "1280x926"},
                                   {640.2, 256.2, {1280, 720}, Severity::kNote, "1280x926"},
                                   {720, 360, {1280, 720}, Severity::kPass, ""},
                                   {760, 360, {1280, 720}, Severity::kNote, "1522x720"},
                                   {470, 300, {800, 600}, Severity::kNote, "942x600"},
                                   {470, 180, {800, 600}, Severity::kWarning, "942x840"},
                                   {330, 235, {640, 480}, Severity::kPass, ""}};
  int num_judged = 0;
  for (const Case& c : cases) {
    const FileCheck check = bareCheck({535, 534, c.cx, c.cy, 0, 0, 0, 0, 0}, "principal_point", c.size);
    EXPECT_EQ(check.severity, c.severity) << check.message;
    EXPECT_THAT(check.message, testing::HasSubstr(c.from.empty() ? "cx" : "cropped, from about " + c.from));
    ++num_judged;
  }
  EXPECT_EQ(num_judged, 7);
}

TEST(CheckCamera, SeesASwappedPrincipalPoint) {
  int num_seen = 0;
  for (const ImageSize size :
       {ImageSize{.width = 640, .height = 480}, ImageSize{.width = 1280, .height = 1024},
        ImageSize{.width = 1920, .height = 1080}, ImageSize{.width = 752, .height = 480}}) {
    std::vector<double> params = kGood;
    params[2] = 0.5 * size.height - 3;
    params[3] = 0.5 * size.width + 5;
    const FileCheck check = bareCheck(params, "principal_point", size);
    EXPECT_EQ(check.severity, Severity::kFailure) << size.width;
    num_seen += check.message.find("swapped") != std::string::npos ? 1 : 0;
  }
  EXPECT_EQ(num_seen, 4);
  // In a square image only the projection matrix can show it.
  const ImageSize square{.width = 1024, .height = 1024};
  std::vector<double> params = kGood;
  params[2] = 471;
  params[3] = 562;
  const auto severityBy = [&](const Eigen::Vector2d& rectified) {
    return bareCheck(params, "projection_matrix", square, false, rectified).severity;
  };
  EXPECT_EQ(severityBy({559, 474}), Severity::kFailure);
  EXPECT_EQ(severityBy({475, 559}), Severity::kPass);
  EXPECT_EQ(severityBy({300, 300}), Severity::kPass);
}

// The denominator 1 + k4 r2 is zero at r = 1 / sqrt(-k4); the corner of an image without distortion is at
// r = hypot(320, 240) / fx.
TEST(CheckCamera, WarnsOfAPoleJustOutsideTheImage) {
  struct Case {
    double fx;
    double k4;
    Severity severity;
  };
  const std::vector<Case> cases = {{400, -0.8, Severity::kWarning}, {400, -0.7, Severity::kWarning},
                                   {400, -0.5, Severity::kPass},    {400, 0.2, Severity::kPass},
                                   {800, -0.8, Severity::kPass},    {400, 0, Severity::kPass}};
  int num_judged = 0;
  for (const Case& c : cases) {
    // Numerator and denominator are equal, so that there is no other distortion.
    const FileCheck check = bareCheck({c.fx, c.fx, 319.5, 239.5, c.k4, 0, 0, 0, 0, c.k4, 0, 0}, "one_to_one",
                                      kVga, false, {}, "rational");
    EXPECT_EQ(check.severity, c.severity) << check.message;
    if (c.k4 < 0) {
      const double share = 1 / std::sqrt(-c.k4) / (400 / c.fx);
      EXPECT_EQ(check.values.at(3).first, "pole_over_corner");
      EXPECT_NEAR(check.values.at(3).second, share, 1e-6);
    }
    ++num_judged;
  }
  EXPECT_EQ(num_judged, 6);
}

TEST(CheckCamera, SaysWhichShareOfTheImageHasARay) {
  const auto shareOf = [](const FileCheck& check) { return check.values.at(0).second; };
  const FileCheck whole = bareCheck(kGood, "one_to_one");
  EXPECT_EQ(whole.severity, Severity::kPass);
  EXPECT_EQ(shareOf(whole), 1);
  const FileCheck folding = bareCheck({535, 535, 320, 240, -0.4, 0, 0, 0, 0}, "one_to_one");
  EXPECT_EQ(folding.severity, Severity::kFailure);
  EXPECT_GT(shareOf(folding), 0.5);
  EXPECT_LT(shareOf(folding), 0.99);
  // The same where the image size was guessed.
  EXPECT_EQ(bareCheck({535, 535, 320, 240, -0.4, 0, 0, 0, 0}, "one_to_one", kVga, true).severity,
            Severity::kWarning);
  // A fold that only the very corners reach.
  const FileCheck corners = bareCheck({535, 535, 319.5, 239.5, -0.285, 0, 0, 0, 0}, "one_to_one");
  EXPECT_GT(shareOf(corners), 0.99);
  EXPECT_LT(shareOf(corners), 1);
  EXPECT_EQ(corners.severity, Severity::kNote);
}

TEST(CheckCamera, BelievesACalibrationThatDoubtsItself) {
  const AnyCamera camera = AnyCamera::make("radtan", kGood);
  CameraRecord record = bareRecord(camera, kVga, "test");
  record.calibration.emplace();
  record.calibration->verdict = Verdict::kNo;
  EXPECT_EQ(statusOf(checkCamera(record), "calibration"), Severity::kFailure);
  record.calibration->verdict = Verdict::kReservations;
  EXPECT_EQ(statusOf(checkCamera(record), "calibration"), Severity::kNote);
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
    CameraRecord record = bareRecord(camera, kVga, "test");
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
