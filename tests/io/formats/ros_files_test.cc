// SPDX-License-Identifier: MIT
// ROS: what its calibrator writes is read, and its parser reads ours without a loss.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "alidade/io/camera_source.h"
#include "alidade/io/formats/camera_format.h"
#include "apps/run_program.h"
#include "apps/scratch_folder.h"
#include "support/model_fixture.h"
#include "support/peer.h"

namespace alidade {
namespace {

// The function by which camera_calibration writes its file, for each of its three models.
constexpr const char* kScript = R"(
import sys
import numpy as np
from camera_calibration.calibrator import MonoCalibrator, CAMERA_MODEL

K = np.array([[533.123456789, 0., 342.5], [0., 534.25, 233.987654321], [0., 0., 1.]])
P = np.hstack([K, np.zeros((3, 1))])
for name, model, d in (
        ('plumb_bob', CAMERA_MODEL.PINHOLE, [-0.2812345678, 0.02, 0.00123456789, -0.0001, 0.1]),
        ('rational', CAMERA_MODEL.PINHOLE, [0.1, 0.2, 0.001, 0.002, 0.03, 0.4, 0.05, 0.0066666666]),
        ('fisheye', CAMERA_MODEL.FISHEYE, [-0.0123456789, 0.02, -0.03, 0.004])):
    with open(sys.argv[1] + '/' + name + '.yaml', 'w') as f:
        f.write(MonoCalibrator.lryaml('narrow_stereo', np.array([d]), K, np.eye(3), P, (640, 480), model))
)";

TEST(RosFiles, OfTheCalibratorAreReadAsFarAsTheirDigitsGo) {
  for (const auto& [module, package] :
       {std::pair("camera_calibration", "python3-camera-calibration"),
        std::pair("cv_bridge", "python3-cv-bridge"), std::pair("image_geometry", "python3-image-geometry")}) {
    ALIDADE_NEED_PEER("/usr/lib/python3/dist-packages/" + std::string(module) + "/__init__.py", package);
  }
  const ScratchFolder folder;
  const RunResult run = runProgram("/usr/bin/python3", {"-c", kScript, folder.path()});
  ASSERT_EQ(run.exit_code, 0) << run.err;
  struct Written {
    std::string name;
    std::string_view model;
    std::vector<double> parameters;
  };
  const std::vector<double> pinhole = {533.123456789, 534.25, 342.5, 233.987654321};
  const std::vector<Written> files = {
      {"plumb_bob", "radtan", {-0.2812345678, 0.02, 0.00123456789, -0.0001, 0.1}},
      {"rational", "rational", {0.1, 0.2, 0.001, 0.002, 0.03, 0.4, 0.05, 0.0066666666}},
      {"fisheye", "kannala_brandt", {-0.0123456789, 0.02, -0.03, 0.004}}};
  int num_numbers = 0;
  for (const Written& file : files) {
    const CameraSource source = readCameras(folder.path(file.name + ".yaml"));
    EXPECT_EQ(source.format, "ros");
    const StatedCamera& read = source.cameras.at(0);
    EXPECT_EQ(read.camera.modelId(), file.model);
    EXPECT_EQ(read.name, "narrow_stereo");
    EXPECT_EQ(read.image_size, std::optional(ImageSize{.width = 640, .height = 480}));
    EXPECT_TRUE(read.remarks.empty());
    std::vector<double> parameters = pinhole;
    parameters.insert(parameters.end(), file.parameters.begin(), file.parameters.end());
    ASSERT_EQ(read.camera.parameters().size(), parameters.size());
    ASSERT_EQ(read.half_units.size(), parameters.size());
    for (std::size_t i = 0; i < parameters.size(); ++i) {
      constexpr double kRounding = 1e-12;
      EXPECT_LE(std::abs(read.camera.parameters()[i] - parameters[i]), read.half_units[i] + kRounding)
          << file.name << " " << i;
      ++num_numbers;
    }
    EXPECT_EQ(read.half_units[4], 5e-7);
  }
  EXPECT_EQ(num_numbers, 9 + 12 + 8);
}

template <class M>
int passThroughParser(const ScratchFolder& folder) {
  Random random(17);
  int num_cameras = 0;
  for (int i = 0; i < 5; ++i) {
    const AnyCamera camera(Camera<M>(ModelFixture<M>::randomParams(random)));
    folder.write(
        "ours.yaml",
        formatText(cameraFormat("ros"),
                   std::vector<NamedCamera>{{.name = "left", .camera = camera, .image_size = kTestImage}}));
    const RunResult run = runProgram("/usr/lib/camera_calibration_parsers/convert",
                                     {folder.path("ours.yaml"), folder.path("theirs.yaml")});
    EXPECT_EQ(run.exit_code, 0) << run.err;
    const StatedCamera back = readCameras(folder.path("theirs.yaml")).cameras.at(0);
    EXPECT_EQ(back.camera.modelId(), camera.modelId());
    EXPECT_EQ(back.name, "left");
    EXPECT_EQ(back.image_size, std::optional(kTestImage));
    EXPECT_THAT(std::vector<double>(back.camera.parameters().begin(), back.camera.parameters().end()),
                testing::ElementsAreArray(camera.parameters().begin(), camera.parameters().end()));
    ++num_cameras;
  }
  return num_cameras;
}

TEST(RosFiles, OfOursPassThroughTheParserOfRos) {
  ALIDADE_NEED_PEER("/usr/lib/camera_calibration_parsers/convert", "camera-calibration-parsers-tools");
  const ScratchFolder folder;
  EXPECT_EQ(passThroughParser<Radtan>(folder) + passThroughParser<Rational>(folder) +
                passThroughParser<KannalaBrandt>(folder),
            15);
}

}  // namespace
}  // namespace alidade
