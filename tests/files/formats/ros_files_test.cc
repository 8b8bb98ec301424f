// SPDX-License-Identifier: MIT
// ROS: what its calibrator writes is read, and its parser reads ours without a loss.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "alidade/camera/camera_variant.h"
#include "alidade/files/camera_source.h"
#include "alidade/files/formats/camera_format.h"
#include "alidade/files/rig_file.h"
#include "apps/run_program.h"
#include "files/formats/reading.h"
#include "support/model_fixture.h"
#include "support/peer.h"
#include "support/scratch_folder.h"

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
    const CameraSource source = loadCameras(folder.path(file.name + ".yaml"));
    EXPECT_EQ(source.format, "ros");
    const StatedCamera& read = source.cameras.at(0);
    EXPECT_EQ(read.camera.modelId(), file.model);
    EXPECT_EQ(read.name, "narrow_stereo");
    EXPECT_EQ(read.image_size, std::optional(ImageSize{.width = 640, .height = 480}));
    EXPECT_TRUE(read.remarks.empty());
    std::vector<double> parameters = pinhole;
    parameters.insert(parameters.end(), file.parameters.begin(), file.parameters.end());
    ASSERT_EQ(read.camera.parameters().size(), parameters.size());
    for (std::size_t i = 0; i < parameters.size(); ++i) {
      // Five decimals in matrices, six in coefficients.
      const double rounding = (i < 4 ? 5e-6 : 5e-7) + 1e-12;
      EXPECT_LE(std::abs(read.camera.parameters()[i] - parameters[i]), rounding) << file.name << " " << i;
      ++num_numbers;
    }
  }
  EXPECT_EQ(num_numbers, 9 + 12 + 8);
}

// The same function for a pair, rectified by OpenCV as its stereo calibrator does it.
constexpr const char* kPairScript = R"(
import sys
import cv2
import numpy as np
from camera_calibration.calibrator import StereoCalibrator, CAMERA_MODEL

K = np.array([[533., 0., 342.5], [0., 534.25, 233.], [0., 0., 1.]])
d = np.array([[-0.28, 0.02, 0.001, -0.0001, 0.1]])
R, _ = cv2.Rodrigues(np.array([0.01, -0.02, 0.03]))
T = np.array([[-0.12], [0.003], [0.002]])
R1, R2, P1, P2, _, _, _ = cv2.stereoRectify(K, d, K, d, (640, 480), R, T, alpha=0)
for name, r, p in (('left', R1, P1), ('right', R2, P2)):
    with open(sys.argv[1] + '/' + name + '.yaml', 'w') as f:
        f.write(StereoCalibrator.lryaml('stereo', d, K, r, p, (640, 480), CAMERA_MODEL.PINHOLE))
)";

TEST(RosFiles, OfAPairSayWhereItsCamerasAre) {
  for (const auto& [module, package] :
       {std::pair("camera_calibration", "python3-camera-calibration"),
        std::pair("cv_bridge", "python3-cv-bridge"), std::pair("image_geometry", "python3-image-geometry")}) {
    ALIDADE_NEED_PEER("/usr/lib/python3/dist-packages/" + std::string(module) + "/__init__.py", package);
  }
  const ScratchFolder folder;
  const RunResult run = runProgram("/usr/bin/python3", {"-c", kPairScript, folder.path()});
  ASSERT_EQ(run.exit_code, 0) << run.err;
  const std::vector<std::string> paths = {folder.path("left.yaml"), folder.path("right.yaml")};
  const std::vector<StatedCamera> cameras = gatherCameras(paths, {}).source.cameras;
  const SE3 right_from_left = *cameras.at(1).camera_from_rig * cameras.at(0).camera_from_rig->inverse();
  // Eight decimals of R, and five of P, whose focal length is about 500 px.
  EXPECT_LT((right_from_left.rotation.log() - Eigen::Vector3d(0.01, -0.02, 0.03)).norm(), 5e-8);
  EXPECT_LT((right_from_left.translation - Eigen::Vector3d(-0.12, 0.003, 0.002)).norm(), 5e-8);
  EXPECT_EQ(cameras.at(0).name, "left");  // both files say "stereo"
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
    const StatedCamera back = loadCameras(folder.path("theirs.yaml")).cameras.at(0);
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

std::string message(int sequence, const std::string& K, const std::string& model = "plumb_bob",
                    const std::string& D = "[0.1, 0.0, 0.0, 0.0, 0.0]") {
  return "header: \n  seq: " + std::to_string(sequence) +
         "\n  frame_id: \"left\"\nheight: 480\nwidth: 640\ndistortion_model: \"" + model + "\"\nD: " + D +
         "\nK: " + K + "\nbinning_x: 0\n---\n";
}
constexpr const char* kMatrix = "[500.0, 0.0, 320.0, 0.0, 501.0, 240.0, 0.0, 0.0, 1.0]";
constexpr const char* kOtherMatrix = "[500.5, 0.0, 320.0, 0.0, 501.0, 240.0, 0.0, 0.0, 1.0]";

TEST(RosFiles, OfSeveralMessagesAreReadIfAllSayTheSame) {
  for (const std::string start : {"", "---\n"}) {
    for (const int count : {1, 2, 3}) {
      std::string text = start;
      for (int i = 0; i < count; ++i) text += message(i, kMatrix);
      const CameraSource source = parseCameras(text, "file");
      ASSERT_EQ(source.cameras.size(), 1u);
      EXPECT_EQ(source.cameras.front().camera.parameters()[1], 501.0);
    }
  }
  EXPECT_THAT(complaintAbout(message(1, kMatrix) + message(2, kMatrix) + message(3, kOtherMatrix)),
              testing::AllOf(testing::HasSubstr("file:21: found a message that differs from the first"),
                             testing::HasSubstr("rostopic echo -n 1")));
  // One that was cut says something else too.
  const std::string two = message(1, kMatrix) + message(2, kMatrix);
  EXPECT_THAT(complaintAbout(two.substr(0, two.size() - 12)), testing::HasSubstr("file:11: found a message"));
  // Other messages are no cameras.
  EXPECT_NE(complaintAbout("header:\n  seq: 1\na: 1\n---\nheader:\n  seq: 2\na: 1\n"), "");
}

TEST(RosFiles, OfTheCalibratorInIniAreRefusedForTheYaml) {
  EXPECT_THAT(
      complaintAbout("# oST version 5.0 parameters\n\n[image]\n\nwidth\n640\n\nheight\n480\n\n"
                     "[narrow_stereo]\n\ncamera matrix\n500 0 320\n0 501 240\n0 0 1\n"),
      testing::AllOf(testing::StartsWith("file: found the INI file"), testing::HasSubstr("use ost.yaml")));
}

// Calibrators of before 2012 knew only plumb_bob and did not name it.
TEST(RosFiles, WithoutAModelAreOfPlumbBob) {
  const auto file = [](const std::string& coefficients, int count = 5) {
    return "image_width: 800\nimage_height: 600\ncamera_name: cam_a\ncamera_matrix:\n  rows: 3\n  cols: 3\n"
           "  data: [1400, 0, 390, 0, 1410, 310, 0, 0, 1]\ndistortion_coefficients:\n  rows: 1\n  cols: " +
           std::to_string(count) +
           "\n"
           "  data: [" +
           coefficients +
           "]\nrectification_matrix:\n  rows: 3\n  cols: 3\n"
           "  data: [1, 0, 0, 0, 1, 0, 0, 0, 1]\nprojection_matrix:\n  rows: 3\n  cols: 4\n"
           "  data: [1400, 0, 390, -140, 0, 1410, 310, 0, 0, 0, 1, 0]\n";
  };
  const CameraSource source = parseCameras(file("-0.01, -1.6, -0.012, -0.0013, 0"), "file");
  EXPECT_EQ(source.format, "ros");
  const StatedCamera& camera = source.cameras.at(0);
  EXPECT_EQ(camera.camera.modelId(), "radtan");
  EXPECT_EQ(camera.camera.parameter("k2"), -1.6);
  EXPECT_THAT(remarksOn(camera), testing::HasSubstr("assumed: "));
  EXPECT_THAT(remarksOn(camera), testing::Not(testing::HasSubstr("unknown_keys")));
  ASSERT_TRUE(camera.camera_from_rig) << "the second of a pair";
  EXPECT_NEAR(camera.camera_from_rig->translation.x(), -0.1, 1e-12);
  EXPECT_THAT(complaintAbout(file("0.1, 0.2, 0.3", 3)),
              testing::HasSubstr("3 distortion coefficients; expected none, 4, 5, 8"));
}

// image_geometry goes by the number of coefficients, whatever the name; drivers fill lists up with zeros.
TEST(RosFiles, AreOfTheModelThatTheirCoefficientsSay) {
  struct Case {
    std::string name;
    std::string coefficients;
    std::string model;  // or what the refusal says
  };
  const std::string five = "0.1, -0.2, 0.01, 0.02, 0.3";
  const std::string zeros = ", 0, 0, 0";
  const std::vector<Case> cases = {
      {"plumb_bob", "", "pinhole"},
      {"plumb_bob", "0.1, -0.2, 0.01, 0.02", "radtan"},
      {"plumb_bob", five + zeros, "radtan"},
      {"plumb_bob", five + zeros + zeros + zeros, "radtan"},
      {"plumb_bob", five + ", 0, 0.1, 0", "plumb_bob with 5 (radtan), or rational_polynomial"},
      {"plumb_bob", "0.1, 0.2, 0.3", "3 distortion coefficients"},
      {"rational_polynomial", five, "radtan"},
      {"rational_polynomial", "", "pinhole"},
      {"rational_polynomial", five + ", 0.1, 0.2, 0.3", "rational"},
      {"rational_polynomial", five + ", 0.1, 0.2, 0.3, 0.01, 0.02, 0.03, 0.04", "thin_prism"},
      {"rational_polynomial", five + ", 0.1, 0.2, 0.3, 0.01, 0.02, 0.03, 0.04, 0, 0", "thin_prism"},
      {"rational_polynomial", five + ", 0.1, 0.2, 0.3, 0, 0, 0, 0, -0.02, 0.01", "tilted"},
      {"rational_polynomial", five + zeros + zeros, "11 distortion coefficients"},
      {"equidistant", five, "5 coefficients"}};
  std::size_t num_read = 0;
  for (const Case& one : cases) {
    SCOPED_TRACE(one.name + " [" + one.coefficients + "]");
    const std::string text = message(1, kMatrix, one.name, "[" + one.coefficients + "]");
    const std::string complaint = complaintAbout(text);
    if (!complaint.empty()) {
      EXPECT_THAT(complaint, testing::AllOf(testing::HasSubstr("file:7: D"), testing::HasSubstr(one.model)));
      continue;
    }
    const AnyCamera camera = parseCameras(text, "file").cameras.at(0).camera;
    EXPECT_EQ(camera.modelId(), one.model);
    EXPECT_EQ(one.model == "pinhole" ? 0.02 : camera.parameter("p2"), 0.02);
    ++num_read;
  }
  EXPECT_EQ(num_read, 10U);
}

TEST(RosFiles, OfZerosSayWhatTheyMean) {
  const std::string zero9 = "[0, 0, 0, 0, 0, 0, 0, 0, 0]";
  EXPECT_THAT(complaintAbout(message(1, zero9)),
              testing::AllOf(testing::HasSubstr("file:8: K"), testing::HasSubstr("not calibrated"),
                             testing::HasSubstr("next: calibrate the camera")));
  const auto remarks = [&](const std::string& R, const std::string& P) {
    const std::string text = "width: 640\nheight: 480\nK: " + std::string(kMatrix) +
                             "\nD: [0.1, 0, 0, 0, 0]\nR: " + R + "\nP: " + P +
                             "\n";  // without distortion_model, as of old drivers
    const CameraSource source = parseCameras(text, "file");
    EXPECT_EQ(source.format, "ros");
    EXPECT_EQ(source.cameras.at(0).camera.modelId(), "radtan");
    return remarksOn(source.cameras.at(0));
  };
  const std::string unit = "[1, 0, 0, 0, 1, 0, 0, 0, 1]";
  const std::string P = "[500, 0, 320, -50, 0, 501, 240, 0, 0, 0, 1, 0]";
  EXPECT_THAT(remarks(zero9, P),
              testing::AllOf(testing::HasSubstr("no_pose: file:5: R"), testing::HasSubstr("0.1 m")));
  EXPECT_THAT(remarks(unit, "[0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0]"),
              testing::HasSubstr("no_pose: file:6: P: only zeros"));
  EXPECT_THAT(remarks(unit, P), testing::Not(testing::HasSubstr("no_pose")));
}

// sensor_msgs/CameraInfo: K is of the whole image; a ROI of zeros is all of it; binning combines pixels.
TEST(RosFiles, StateAPartOfTheImageThatIsReadOnRequest) {
  struct Case {
    std::string roi;  // x_offset, y_offset, width, height
    int bin_x, bin_y;
    ImageSize size;
    double fx, fy, cx, cy;
    std::string text;  // of the remark; empty: none
  };
  const std::string half = "x_offset: 320, y_offset: 200, width: 640, height: 400";
  const std::vector<Case> cases = {
      {"x_offset: 0, y_offset: 0, width: 0, height: 0", 0, 1, {1280, 800}, 600, 601, 630, 410, ""},
      {"x_offset: 0, y_offset: 0, width: 1280, height: 800", 1, 0, {1280, 800}, 600, 601, 630, 410, ""},
      {half,
       0,
       0,
       {640, 400},
       600,
       601,
       310,
       210,
       "K is of 1280x800; this image is its part at x 320, y 200 of 640x400"},
      {half, 2, 2, {320, 200}, 300, 300.5, 154.75, 104.75, "2x2 pixels combined into one: 320x200"},
      {"x_offset: 320, y_offset: 200, width: 0, height: 0",
       0,
       0,
       {960, 600},
       600,
       601,
       310,
       210,
       "at x 320, y 200 of 960x600"},
      {"width: 0", 4, 2, {320, 400}, 150, 300.5, 157.125, 204.75, "all of it, 4x2 pixels combined"},
      {"x_offset: 1, y_offset: 0, width: 9, height: 9",
       2,
       2,
       {4, 4},
       300,
       300.5,
       314.25,
       204.75,
       "at x 1, y 0 of 9x9"}};
  std::size_t num_read = 0;
  for (const Case& one : cases) {
    SCOPED_TRACE(one.roi);
    const std::string text =
        "width: 1280\nheight: 800\ndistortion_model: plumb_bob\nD: [0.1, 0, 0, 0, 0]\n"
        "K: [600, 0, 630, 0, 601, 410, 0, 0, 1]\nP: [700, 0, 640, 0, 0, 702, 400, 0, 0, 0, 1, 0]\n"
        "binning_x: " +
        std::to_string(one.bin_x) + "\nbinning_y: " + std::to_string(one.bin_y) + "\nroi: {" + one.roi +
        "}\n";
    const StatedCamera whole = parseCameras(text, "file").cameras.at(0);
    EXPECT_EQ(whole.camera.parameter("cx"), 630);
    const std::string remarks = remarksOn(whole);
    EXPECT_THAT(remarks, testing::HasSubstr(one.text));
    EXPECT_EQ(remarks.find("--apply-roi") == std::string::npos, one.text.empty());
    const StatedCamera part =
        parseCameras(text, "file", {.image_size = {}, .model = "", .applies_roi = true}).cameras.at(0);
    EXPECT_EQ(part.image_size, std::optional(one.size));
    EXPECT_NEAR(part.camera.parameter("fx"), one.fx, 1e-12);
    EXPECT_NEAR(part.camera.parameter("fy"), one.fy, 1e-12);
    EXPECT_NEAR(part.camera.parameter("cx"), one.cx, 1e-12);
    EXPECT_NEAR(part.camera.parameter("cy"), one.cy, 1e-12);
    EXPECT_EQ(part.camera.parameter("k1"), 0.1);
    EXPECT_NEAR(part.rectified_focal->x() / 700, one.fx / 600, 1e-12);
    ++num_read;
  }
  EXPECT_EQ(num_read, 7U);
  const std::string beyond =
      "width: 1280\nheight: 800\ndistortion_model: none\nK: [600, 0, 630, 0, 601, 410, 0, 0, 1]\n"
      "roi: {x_offset: 1000, y_offset: 0, width: 640, height: 400}\n";
  EXPECT_EQ(complaintAbout(beyond), "");
  EXPECT_THAT(complaintAbout(beyond, {.image_size = {}, .model = "", .applies_roi = true}),
              testing::HasSubstr("file:5: roi"));
}

TEST(RosFiles, OfModelsThatAreNotRosOwnSayWhatToDo) {
  const std::string zeros = "[0.0, 0.0, 0.0, 0.0, 0.0]";
  EXPECT_EQ(parseCameras(message(1, kMatrix, "None", zeros), "file").cameras.at(0).camera.modelId(),
            "pinhole");
  struct Case {
    std::string model;
    std::string coefficients;
    std::string advice;
  };
  int num_cases = 0;
  for (const Case& one :
       std::vector<Case>{{"None", "[0.1]", "write the model that"},
                         {"blumb_bob", "[0.1, 0.0, 0.0, 0.0, 0.0]", "did you mean 'plumb_bob'?"}}) {
    EXPECT_THAT(
        complaintAbout(message(1, kMatrix, one.model, one.coefficients)),
        testing::AllOf(testing::HasSubstr("file:6: distortion_model"), testing::HasSubstr(one.advice)));
    ++num_cases;
  }
  EXPECT_EQ(num_cases, 2);
  // RealSense's own name, and skew, which only cv::fisheye and so image_geometry knows.
  const auto modelOf = [](const std::string& text) {
    return parseCameras(text, "file").cameras.at(0).camera.modelId();
  };
  EXPECT_EQ(modelOf(message(1, kMatrix, "Inverse Brown Conrady", "[0.1, 0.0, 0.0, 0.0, 0.0]")),
            "inverse_brown");
}

}  // namespace
}  // namespace alidade
