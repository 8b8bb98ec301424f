// SPDX-License-Identifier: MIT
#include <cmath>

#include <gmock/gmock.h>
#include <yaml-cpp/yaml.h>

#include "alidade/core/error.h"
#include "alidade/files/camera_source.h"
#include "alidade/files/formats/alidade_writer.h"
#include "support/message_of.h"
#include "support/source_tree.h"

namespace alidade {
namespace {

TEST(CameraRecord, ReadsTheStatedCovariance) {
  const CameraRecord file = loadCamera(sourcePath("testdata/camera_files/version_1.yaml"));
  ASSERT_TRUE(file.calibration);
  ASSERT_EQ(file.calibration->covariance.size(), 45u);
  for (std::size_t i = 0; i < 9; ++i) {
    const double std = file.calibration->parameter_std[i];
    EXPECT_NEAR(file.calibration->covariance[i * (i + 3) / 2], std * std, 1e-9 * std * std);
  }
  const CameraRecord again = onlyCamera(parseCameras(cameraFileText(file), "again.yaml"));
  EXPECT_EQ(again.calibration->covariance, file.calibration->covariance);
  EXPECT_EQ(again.calibration->verdict, file.calibration->verdict);
}

TEST(CameraRecord, KeepsWhatItIsCalled) {
  CameraRecord file = bareRecord(AnyCamera::make("pinhole", std::vector<double>{500, 500, 320, 240}),
                                 {.width = 640, .height = 480}, "test");
  EXPECT_THAT(cameraFileText(file), testing::Not(testing::HasSubstr("\ncamera:")));
  file.name = {.name = "left", .serial = "0012", .lens = "6 mm: f/1.4"};
  EXPECT_THAT(cameraFileText(file), testing::HasSubstr("serial: \"0012\""));
  const CameraRecord back = onlyCamera(parseCameras(cameraFileText(file), "camera.yaml"));
  EXPECT_EQ(back.name.name, "left");
  EXPECT_EQ(back.name.serial, "0012");
  EXPECT_EQ(back.name.lens, "6 mm: f/1.4");
}

TEST(CameraRecord, KeepsTheBoardsAndTheirBends) {
  CameraRecord file = bareRecord(AnyCamera::make("pinhole", std::vector<double>{500, 500, 320, 240}),
                                 {.width = 640, .height = 480}, "test");
  file.calibration = CalibrationRecord{.rms_px = 0.1, .num_views = 12, .num_corners = 600, .boards = {}};
  const WarpRecord bend{.board = 0, .shape = {.bend_x_m = 1e-3, .bend_y_m = -2e-3}, .std_m = {1e-5, 2e-5}};
  struct Case {
    std::vector<std::string> boards;
    std::vector<WarpRecord> warps;
    std::string written;
  };
  const std::vector<std::string> two = {"checkerboard:9x6:25mm", "aprilgrid:6x6:88mm:0.3"};
  WarpRecord of_second = bend;
  of_second.board = 1;
  const std::vector<Case> cases = {
      {{}, {}, "num_corners: 600\n"},
      {{two[0]}, {}, "  board: checkerboard:9x6:25mm\n"},
      {{two[0]}, {bend}, "  board_warp: {bend_x_m: 0.001, bend_y_m: -0.002, bend_x_std_m: 1e-05"},
      {two, {}, "  board:\n    - checkerboard:9x6:25mm\n    - aprilgrid:6x6:88mm:0.3\n"},
      {two, {of_second}, "  board_warp:\n    - {board: aprilgrid:6x6:88mm:0.3, bend_x_m: 0.001"},
      {two, {bend, of_second}, "    - {board: checkerboard:9x6:25mm, bend_x_m: 0.001"},
  };
  std::size_t num_checked = 0;
  for (const Case& c : cases) {
    file.calibration->boards = c.boards;
    file.calibration->warps = c.warps;
    const std::string text = cameraFileText(file);
    EXPECT_THAT(text, testing::HasSubstr(c.written));
    const CalibrationRecord back = onlyCamera(parseCameras(text, "camera.yaml")).calibration.value();
    EXPECT_EQ(back.boards, c.boards);
    ASSERT_EQ(back.warps.size(), c.warps.size());
    for (std::size_t i = 0; i < c.warps.size(); ++i) {
      EXPECT_EQ(back.warps[i].board, c.warps[i].board);
      EXPECT_EQ(back.warps[i].shape, c.warps[i].shape);
      EXPECT_EQ(back.warps[i].std_m, c.warps[i].std_m);
    }
    ++num_checked;
  }
  EXPECT_EQ(num_checked, 6U);
  std::string text = cameraFileText(file);
  text.replace(text.rfind("aprilgrid:6x6"), 13, "aprilgrid:5x5");
  EXPECT_THAT(
      messageOf([&] { (void)onlyCamera(parseCameras(text, "camera.yaml")); }),
      testing::AllOf(testing::HasSubstr("camera.yaml:"), testing::HasSubstr("'aprilgrid:5x5:88mm:0.3'"),
                     testing::HasSubstr("a board of 'board'")));
}

TEST(CameraRecord, KeepsTheKeysOfTheUser) {
  const std::string camera =
      "alidade_camera: 1\nmodel: pinhole\nimage_size: &size {width: 640, height: 480}\n"
      "parameters: {fx: 500, fy: 500, cx: 320, cy: 240}\n";
  const std::string own =
      "x_serial: \"0012\"\nx_rig:\n  cameras: [left, {name: right, offset: 0.12}]\n  notes:\n    - &n first\n"
      "    - *n\n    - ~\nx_size: *size\nx_tagged: !mine 1\nx_text: |\n  two\n  lines\n";
  const CameraRecord file = onlyCamera(parseCameras(camera + own, "camera.yaml"));
  const std::string written = cameraFileText(file);
  EXPECT_THAT(written, testing::HasSubstr("x_serial: \"0012\"\n"));
  // Ours is still what it was, and theirs says the same.
  const CameraRecord again = onlyCamera(parseCameras(written, "again.yaml"));
  EXPECT_EQ(cameraFileText(again), written);
  const YAML::Node before = YAML::Load(camera + own);
  const YAML::Node after = YAML::Load(written);
  int num_keys = 0;
  for (const char* key : {"x_serial", "x_rig", "x_size", "x_tagged", "x_text"}) {
    ASSERT_TRUE(after[key]) << key;
    EXPECT_EQ(YAML::Dump(after[key]), YAML::Dump(before[key])) << key;
    EXPECT_EQ(after[key].Tag(), before[key].Tag()) << key;
    ++num_keys;
  }
  EXPECT_EQ(num_keys, 5);
  EXPECT_EQ(onlyCamera(parseCameras(camera, "camera.yaml")).user_keys, "");
}

// Each level ten times the one below: what is shared stays shared.
TEST(CameraRecord, DoesNotUnfoldSharedValuesOfTheUser) {
  std::string text =
      "alidade_camera: 1\nmodel: pinhole\nimage_size: {width: 640, height: 480}\n"
      "parameters: {fx: 500, fy: 500, cx: 320, cy: 240}\nx_0: &x0 [1, 1]\n";
  constexpr int kNumLevels = 20;
  for (int i = 1; i <= kNumLevels; ++i) {
    const std::string below = "*x" + std::to_string(i - 1);
    text += "x_" + std::to_string(i) + ": &x" + std::to_string(i) + " [" + below;
    for (int k = 1; k < 10; ++k) text += ", " + below;
    text += "]\n";
  }
  EXPECT_LT(onlyCamera(parseCameras(text, "camera.yaml")).user_keys.size(), 3 * text.size());
}

std::string keysText(std::string_view model) {
  std::string text;
  for (const std::string_view name : parameterNames(model))
    text += (text.empty() ? "" : ", ") + std::string(name) + ": 1";
  return "{" + text + "}";
}

std::string complaintAbout(const std::string& text) {
  try {
    (void)onlyCamera(parseCameras(text, "camera.yaml"));
    return "";
  } catch (const Error& error) {
    return error.what();
  }
}

// As if the model's name alone had been changed by hand.
TEST(CameraRecord, TellsWhoseParametersItHas) {
  int num_pairs = 0;
  for (const std::string& model : modelIds()) {
    for (const std::string& other : modelIds()) {
      const auto own = parameterNames(model);
      const auto theirs = parameterNames(other);
      if (std::ranges::equal(own, theirs)) continue;  // the same, or only the self-check tells them apart
      const auto first = std::ranges::find_if(modelIds(), [&theirs](const std::string& id) {
        return std::ranges::equal(parameterNames(id), theirs);
      });
      EXPECT_THAT(
          complaintAbout("alidade_camera: 1\nmodel: " + model + "\nimage_size: {width: 640, height: 480}\n" +
                         "parameters: " + keysText(other) + "\n"),
          testing::AllOf(
              testing::StartsWith("camera.yaml:4: parameters: found the keys of the model " + *first),
              testing::HasSubstr("the keys of " + model + ": fx"),
              testing::HasSubstr("change it back to " + *first)));
      ++num_pairs;
    }
  }
  EXPECT_EQ(num_pairs, 20 * 19 - 2 * 2);
  const std::string start =
      "alidade_camera: 1\nmodel: kannala_brandt\nimage_size: {width: 640, height: 480}\n"
      "parameters: {fx: 500, fy: 500, cx: 320, cy: 240, k1: 0, k2: 0, k3: 0, k4: 0}\n";
  EXPECT_THAT(
      complaintAbout(start +
                     "calibration:\n  rms_px: 0.1\n  num_views: 13\n  num_corners: 702\n  parameter_std: " +
                     keysText("radtan") + "\n"),
      testing::StartsWith("camera.yaml:9: calibration.parameter_std: found the keys of the model radtan"));
  // One wrong key is a slip of the hand.
  EXPECT_THAT(complaintAbout("alidade_camera: 1\nmodel: pinhole\nimage_size: {width: 640, height: 480}\n"
                             "parameters: {fx: 500, fy: 500, cx: 320, cz: 240}\n"),
              testing::AllOf(testing::HasSubstr("unknown key 'cz'"), testing::HasSubstr("did you mean")));
}

// A coefficient's sign makes a pixel in the corner move by many pixels; the eighth digit of fx by none that
// would matter, yet it is not the number that was written.
TEST(CameraRecord, IsNotReadWhereItsSelfCheckFails) {
  const AnyCamera camera =
      AnyCamera::make("radtan", std::vector<double>{500, 501, 320, 240, -0.25, 0.1, 1e-3, 2e-3, 0});
  const CameraRecord good = bareRecord(camera, {.width = 640, .height = 480}, "");
  ASSERT_EQ(good.self_check.size(), 9u);
  EXPECT_EQ(onlyCamera(parseCameras(cameraFileText(good), "good.yaml")).self_check.size(), 9u);
  struct Slip {
    std::size_t parameter;
    double value;
    const char* complaint;
  };
  const std::vector<Slip> slips = {{0, 500.00001, "e-06 px away from its stated pixel ("},
                                   {4, 0.25, "px away from its stated pixel ("},
                                   {4, -25, "cannot project this point"}};
  int num_refused = 0;
  for (const Slip& slip : slips) {
    std::vector<double> values(camera.parameters().begin(), camera.parameters().end());
    values[slip.parameter] = slip.value;
    CameraRecord wrong = good;
    wrong.camera = AnyCamera::make("radtan", values);
    try {
      (void)onlyCamera(parseCameras(cameraFileText(wrong), "wrong.yaml"));
      ADD_FAILURE() << slip.complaint;
    } catch (const Error& error) {
      EXPECT_EQ(error.code(), ErrorCode::kInput);
      EXPECT_THAT(error.what(), testing::AllOf(testing::HasSubstr("wrong.yaml: self_check["),
                                               testing::HasSubstr(slip.complaint)));
      ++num_refused;
    }
  }
  EXPECT_EQ(num_refused, 3);
}

}  // namespace
}  // namespace alidade
