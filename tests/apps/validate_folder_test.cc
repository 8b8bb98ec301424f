// SPDX-License-Identifier: MIT
// A folder of camera files as other programs write them, half of them wrong in the ways in which files go
// wrong: `validate` tells them apart, by default and with --strict.
#include <map>
#include <set>

#include <fmt/format.h>
#include <nlohmann/json.hpp>
#include <pugixml.hpp>

#include "alidade/files.h"
#include "alidade/files/formats/camera_format.h"
#include "apps/command_line.h"
#include "files/formats/examples.h"
#include "support/image_sizes.h"
#include "support/source_tree.h"

namespace alidade {
namespace {

using testing::AllOf;
using testing::HasSubstr;

AnyCamera goodCamera() {
  return AnyCamera::make("radtan",
                         std::vector<double>{533.1, 533.4, 342.5, 233.9, -0.281, 0.071, 0.0012, -1e-4, 0});
}

// As each program of our list of formats would have it, by our writers: format and extension.
const std::vector<std::pair<std::string, std::string>> kWritten = {
    {"alidade", ".yaml"}, {"opencv", ".yml"},      {"opencv", ".xml"},     {"opencv", ".json"},
    {"ros", ".yaml"},     {"kalibr", ".yaml"},     {"colmap", ".txt"},     {"mrcal", ".cameramodel"},
    {"basalt", ".json"},  {"nerfstudio", ".json"}, {"camodocal", ".yaml"}, {"matlab", ".json"}};

std::string written(const std::string& format, const std::string& extension) {
  const NamedCamera named{.name = "", .camera = goodCamera(), .image_size = kVga};
  return formatText(cameraFormat(format), {&named, 1}, "camera" + extension);
}

struct Numbers {
  int width = 640, height = 480;
  double fx = 533.1, fy = 533.4, cx = 342.5, cy = 233.9;
  std::string coefficients = "-0.281000, 0.071000, 0.001200, -0.000100, 0.000000";
  double rectified_cx = 345.2, rectified_cy = 232.1;
};

// As ROS camera_calibration writes it: the projection matrix is that of the rectified images.
std::string rosText(const Numbers& n) {
  return fmt::format(
      "image_width: {}\nimage_height: {}\ncamera_name: narrow_stereo\ncamera_matrix:\n  rows: 3\n  cols: 3\n"
      "  data: [{:.5f},   0.     , {:.5f},\n           0.     , {:.5f}, {:.5f},\n           0.     ,   0.    "
      " "
      ",   1.     ]\ndistortion_model: plumb_bob\ndistortion_coefficients:\n  rows: 1\n  cols: 5\n  data: "
      "[{}]\n"
      "rectification_matrix:\n  rows: 3\n  cols: 3\n  data: [0.99992, 0.00871, 0.00912,\n         -0.00873, "
      "0.99996, "
      "0.00161,\n         -0.00911, -0.00169, 0.99996]\nprojection_matrix:\n  rows: 3\n  cols: 4\n  data: "
      "[461.12,   0. "
      "    , {:.5f},   0.     ,\n           0.     , 498.71, {:.5f},   0.     ,\n           0.     ,   0.    "
      " ,   1.  "
      "   ,   0.     ]\n",
      n.width, n.height, n.fx, n.cx, n.fy, n.cy, n.coefficients, n.rectified_cx, n.rectified_cy);
}

// As OpenCV's sample calibration.cpp writes it.
std::string opencvText(const Numbers& n) {
  return fmt::format(
      "%YAML:1.0\n---\ncalibration_time: \"Sun Nov  2 10:00:00 2025\"\nnframes: 2\nimage_width: "
      "{}\nimage_height: {}\n"
      "board_width: 9\nboard_height: 6\nsquare_size: 2.5e-02\nflags: 0\ncamera_matrix: !!opencv-matrix\n   "
      "rows: 3\n"
      "   cols: 3\n   dt: d\n   data: [ {}, 0., {}, 0., {}, {}, 0., 0., 1. ]\ndistortion_coefficients: "
      "!!opencv-matrix\n   rows: 5\n   cols: 1\n   dt: d\n   data: [ {} ]\navg_reprojection_error: 1.95e-01\n"
      "extrinsic_parameters: !!opencv-matrix\n   rows: 2\n   cols: 6\n   dt: d\n   data: [ 0.1, 0.2, 0.3, "
      "0.4, 0.5, "
      "0.6,\n       0.1, 0.2, 0.3, 0.4, 0.5, 0.6 ]\n",
      n.width, n.height, n.fx, n.cx, n.fy, n.cy, n.coefficients);
}

// As OpenCV's sample stereo_calib.cpp writes it from the photographs of its samples: a pair, no image size.
std::string stereoText(const std::string& left_coefficients) {
  const std::string tail = "\n   cols: 3\n   dt: d\n   data: [ ";
  return "%YAML:1.0\n---\nM1: !!opencv-matrix\n   rows: 3" + tail +
         "533.98794545095393, 0., 328.38647470393420, 0., 528.71081491500581, 236.84272837245879, 0., 0., 1. "
         "]\n"
         "D1: !!opencv-matrix\n   rows: 1\n   cols: 14\n   dt: d\n   data: [ " +
         left_coefficients + " ]\nM2: !!opencv-matrix\n   rows: 3" + tail +
         "533.98794545095393, 0., 313.77033540418699, 0., 528.71081491500581, 241.87045349503515, 0., 0., 1. "
         "]\n"
         "D2: !!opencv-matrix\n   rows: 1\n   cols: 14\n   dt: d\n"
         "   data: [ -0.26296, -0.01215, 0., 0., 0., 0., 0., -0.1951, 0., 0., 0., 0., 0., 0. ]\n";
}

std::string kalibrText(const Numbers& n) {
  const std::string camera = fmt::format(
      "  camera_model: pinhole\n  distortion_coeffs: [-0.28340811, 0.07395907, 0.00019359, 1.76187114e-05]\n"
      "  distortion_model: radtan\n  intrinsics: [{}, {}, {}, {}]\n  resolution: [{}, {}]\n",
      n.fx, n.fy, n.cx, n.cy, n.width, n.height);
  return "cam0:\n  cam_overlaps: [1]\n" + camera + "  rostopic: /cam0/image_raw\ncam1:\n  T_cn_cnm1:\n" +
         "  - [0.99999, 0.0023, 0.0003, -0.11007]\n  - [-0.0023, 0.99989, -0.0142, 0.00039]\n" +
         "  - [-0.0003, 0.0142, 0.99989, -0.00085]\n  - [0.0, 0.0, 0.0, 1.0]\n  cam_overlaps: [0]\n" +
         camera + "  rostopic: /cam1/image_raw\n";
}

// ORB-SLAM2's file of a single EuRoC camera: no type of lens, no image size.
std::string orbslamText(const Numbers& n) {
  return fmt::format(
      "%YAML:1.0\n\n# Camera calibration and distortion parameters (OpenCV)\nCamera.fx: {}\nCamera.fy: "
      "{}\nCamera.cx: "
      "{}\nCamera.cy: {}\n\nCamera.k1: -0.28340811\nCamera.k2: 0.07395907\nCamera.p1: 0.00019359\nCamera.p2: "
      "1.76187114e-05\n\n# Camera frames per second\nCamera.fps: 20.0\nCamera.RGB: "
      "1\nORBextractor.nFeatures: 1000\n"
      "Viewer.KeyFrameSize: 0.05\n",
      n.fx, n.fy, n.cx, n.cy);
}

std::string euRocSensorText() {
  return "# General sensor definitions.\nsensor_type: camera\ncomment: VI-Sensor cam0 (MT9M034)\n\nT_BS:\n  "
         "cols: 4\n"
         "  rows: 4\n  data: [0.0148655429818, -0.999880929698, 0.00414029679422, -0.0216401454975,\n"
         "         0.999557249008, 0.0149672133247, 0.025715529948, -0.064676986768,\n"
         "        -0.0257744366974, 0.00375618835797, 0.999660727178, 0.00981073058949,\n         0.0, 0.0, "
         "0.0, 1.0]\n"
         "\nrate_hz: 20\nresolution: [752, 480]\ncamera_model: pinhole\n"
         "intrinsics: [458.654, 457.296, 367.215, 248.375] #fu, fv, cu, cv\ndistortion_model: "
         "radial-tangential\n"
         "distortion_coefficients: [-0.28340811, 0.07395907, 0.00019359, 1.76187114e-05]\n";
}

std::string handText(const std::string& size, const std::string& parameters) {
  return "alidade_camera: 1\nmodel: radtan\nimage_size: {" + size + "}\nparameters: {" + parameters + "}\n";
}

const std::string kVgaLine = "width: 640, height: 480";
const std::string kHandParameters =
    "fx: 532.8, fy: 532.9, cx: 342.5, cy: 233.9, k1: -0.281, k2: 0.025, p1: 0.0012, p2: -0.0001, k3: 0.163";

std::vector<std::string> writeSoundFiles(const ScratchFolder& scratch) {
  std::vector<std::string> files;
  const auto add = [&](const std::string& name, const std::string& text) {
    files.push_back(scratch.write("set/sound/" + name, text));
  };
  for (const auto& [format, extension] : kWritten)
    add(format + "/written" + extension, written(format, extension));
  add("ros/ost.yaml", rosText({}));
  add("opencv/out_camera_data.yml", opencvText({}));
  add("opencv/intrinsics.yml",
      stereoText("-0.25897, -0.12619, 0., 0., 0., 0., 0., -0.39963, 0., 0., 0., 0., 0., 0."));
  add("kalibr/camchain.yaml",
      kalibrText({.width = 752, .fx = 458.654, .fy = 457.296, .cx = 367.215, .cy = 248.375}));
  add("orbslam/EuRoC.yaml", orbslamText({.fx = 458.654, .fy = 457.296, .cx = 367.215, .cy = 248.375}));
  add("euroc/cam0/sensor.yaml", euRocSensorText());
  add("hand.yaml", handText(kVgaLine, kHandParameters));
  // As calibrated, with a verdict of reservations.
  add("calibrated.yaml", replaced(readFile(sourcePath("testdata/camera_files/version_1.yaml")),
                                  "verdict: trustworthy", "verdict: usable_with_reservations"));
  return files;
}

// With the check or the text that has to give the reason.
std::map<std::string, std::string> writeWrongFiles(const ScratchFolder& scratch) {
  std::map<std::string, std::string> files;
  const auto add = [&](const std::string& name, const std::string& text, const std::string& reason) {
    files.emplace(scratch.write("set/wrong/" + name, text), reason);
  };
  const Numbers good;
  const std::string alidade = written("alidade", ".yaml");
  // Other units.
  add("in_mm.yaml", rosText({.fx = 0.5331, .fy = 0.5334}), "focal_length");
  add("negative.yml", opencvText({.fx = -533.1}), "expected a positive focal length");
  add("nan.yml", replaced(opencvText({}), "[ 533.1,", "[ .NaN,"), "expected a finite number");
  add("normalised.yaml", kalibrText({.width = 752, .fx = 0.61, .fy = 0.95, .cx = 0.488, .cy = 0.517}),
      "focal_length");
  add("normalised_without_size.yaml", orbslamText({.fx = 0.61, .fy = 0.95, .cx = 0.488, .cy = 0.517}),
      "focal_length");
  // Images of another size.
  add("half_size.yaml", handText("width: 1280, height: 960", kHandParameters), "principal_point");
  add("other_shape.yaml", rosText({.width = 1280, .height = 720}), "principal_point");
  add("portrait.yml", opencvText({.width = 480, .height = 640}), "principal_point");
  // The principal point.
  add("swapped.yaml",
      replaced(replaced(written("camodocal", ".yaml"), "342.5", "233.9 # "), "cy: 233.9", "cy: 342.5"),
      "principal_point");
  add("swapped_square.yaml",
      rosText(
          {.width = 1024, .height = 1024, .cx = 471, .cy = 562, .rectified_cx = 559, .rectified_cy = 474}),
      "projection_matrix");
  add("outside.cameramodel", replaced(written("mrcal", ".cameramodel"), "342.5", "-342.5"),
      "principal_point");
  // Coefficients in the wrong places.
  add("permuted.yml", opencvText({.coefficients = "0.0012, -0.0001, -0.281, 0.6, 0."}), "tangential");
  add("order.yaml", rosText({.coefficients = "-0.281, 0.025, 0.163, 0.0012, -0.0001"}), "tangential");
  add("folding.yaml", rosText({.coefficients = "-0.481, 0., 0., 0., 0."}), "one_to_one");
  // Slips in keys.
  add("key.yaml", replaced(rosText(good), "camera_matrix:", "camera_matix:"),
      "did you mean 'camera_matrix'?");
  add("deep/key.yaml",
      replaced(
          replaced(kalibrText(good).substr(0, kalibrText(good).find("cam1:")), "intrinsics:", "intrinsic:"),
          "cam_overlaps: [1]", "cam_overlaps: []"),
      "did you mean 'intrinsics'?");
  add("deep/own_key.yaml", replaced(alidade, "alidade_camera:", "alidade_camra:"),
      "did you mean 'alidade_camera'?");
  add("deep/prefix.yaml", "%YAML:1.0\nCam1.fx: 458.6\nCam1.fy: 457.2\nCam1.cx: 367.2\nCam1.cy: 248.3\n",
      "did you mean 'Camera1.fx'?");
  // Damage.
  const std::string basalt = written("basalt", ".json");
  add("deep/cut.json", basalt.substr(0, basalt.size() / 2), "not valid JSON");
  add("edited.yaml", replaced(alidade, "fx: 533.1", "fx: 533.2"), "self_check");
  return files;
}

void writeOtherFiles(const ScratchFolder& scratch) {
  scratch.write("set/poses.yaml", "- {quaternion_xyzw: [0, 0, 0, 1], translation_m: [0, 0, 1]}\n");
  scratch.write("set/board.yaml", "kind: checkerboard\ncolumns: 9\nrows: 6\nsquare: 25mm\n");
  scratch.write("set/extrinsics.yaml", "extrinsics: [0, 0, 0, 0, 0, 0]\nresolution: 0.05\n");
  scratch.write("set/package.xml",
                "<?xml version=\"1.0\"?>\n<package format=\"2\"><name>camera_matrix</name></package>\n");
  scratch.write("set/README.txt", "See the folders: camera_matrix: and more\n");
  scratch.write("set/scene.yaml", readFile(sourcePath("config/scene.yaml")));
  scratch.write("set/template.json", "{{ not json }}\n");
  // The ROS calibrator writes it beside ost.yaml.
  scratch.write("set/sound/ros/ost.txt",
                "# oST version 5.0 parameters\n\n\n[image]\n\nwidth\n640\n\nheight\n480\n\n"
                "[narrow_stereo]\n\ncamera matrix\n533.1 0 342.5\n0 533.4 233.9\n0 0 1\n");
}

// What the reason has to contain: the failed checks of a file, or its error.
std::string reasonsOf(const nlohmann::json& file) {
  std::string reasons = file.at("error").is_null() ? "" : file.at("error").get<std::string>();
  for (const auto& camera : file.at("cameras")) {
    for (const auto& check : camera.at("checks")) {
      if (check.at("status") == "failure") reasons += check.at("id").get<std::string>() + "\n";
    }
  }
  return reasons;
}

TEST(ValidateFolder, TellsSoundFilesFromWrongOnes) {
  const ScratchFolder scratch;
  const std::vector<std::string> sound = writeSoundFiles(scratch);
  const std::map<std::string, std::string> wrong = writeWrongFiles(scratch);
  writeOtherFiles(scratch);
  ASSERT_EQ(sound.size(), 20u);
  ASSERT_EQ(wrong.size(), 20u);
  for (const bool is_strict : {false, true}) {
    std::vector<std::string> args = {"validate", scratch.path("set"), "--json"};
    if (is_strict) args.emplace_back("--strict");
    const RunResult result = runAlidade(args);
    ASSERT_THAT(result, EndsWith(3));
    const auto document = nlohmann::json::parse(result.out);
    int num_passed = 0;
    int num_failed = 0;
    for (const auto& file : document.at("files")) {
      const std::string name = file.at("file");
      if (std::count(sound.begin(), sound.end(), name) == 1) {
        EXPECT_EQ(file.at("status"), "pass") << file.dump(1);
        ++num_passed;
      } else {
        ASSERT_EQ(wrong.count(name), 1u) << file.dump(1);
        EXPECT_EQ(file.at("status"), "failure") << file.dump(1);
        EXPECT_THAT(reasonsOf(file), HasSubstr(wrong.at(name))) << name;
        ++num_failed;
      }
    }
    EXPECT_EQ(num_passed, 20);
    EXPECT_EQ(num_failed, 20);
    EXPECT_EQ(document.at("totals"), nlohmann::json({{"files", 40},
                                                     {"passed", 20},
                                                     {"passed_with_warnings", 0},
                                                     {"failed", 20},
                                                     {"other_files", 8}}));
    EXPECT_EQ(document.at("other_files").size(), 8u);
  }
  const RunResult table = runAlidade({"validate", scratch.path("set")});
  EXPECT_EQ(std::count(table.out.begin(), table.out.end(), '\n'), 42);  // with one on lenses that fold over
  EXPECT_THAT(table.out, testing::EndsWith(
                             "\n40 files: 20 passed, 20 failed; 8 other files without a readable camera\n"));
  EXPECT_EQ(table.err, "");
  const RunResult failures = runAlidade({"validate", scratch.path("set"), "--quiet"});
  EXPECT_EQ(std::count(failures.out.begin(), failures.out.end(), '\n'), 20);
}

TEST(ValidateFolder, PassesEverySoundFileByItself) {
  const ScratchFolder scratch;
  int num_passed = 0;
  for (const std::string& file : writeSoundFiles(scratch)) {
    const RunResult result = runAlidade({"validate", file, "--strict"});
    EXPECT_THAT(result, EndsWith(0));
    EXPECT_THAT(result.out, AllOf(testing::StartsWith("PASS  " + file),
                                  testing::EndsWith("1 file: 1 passed, 0 failed\n")));
    ++num_passed;
  }
  EXPECT_EQ(num_passed, 20);
}

TEST(ValidateFolder, PassesWhatToolsWrite) {
  const ScratchFolder scratch;
  std::size_t num_written = 0;
  for (const FormatExample& example : formatExamples()) {
    const char first = example.text[example.text.find_first_not_of(" \n")];
    const bool is_json = first == '{' && example.format != "mrcal";
    const char* extension = first == '<' ? ".xml" : is_json ? ".json" : first == '#' ? ".txt" : ".yaml";
    scratch.write(fmt::format("set/{}_{}{}", example.format, num_written++, extension), example.text);
  }
  EXPECT_GE(num_written, 30u);
  for (const char* flag : {"--verbose", "--strict"}) {
    const RunResult result = runAlidade({"validate", scratch.path("set"), "--json", flag});
    EXPECT_THAT(result, EndsWith(0)) << result.out;
    EXPECT_EQ(nlohmann::json::parse(result.out).at("totals").at("passed"), num_written);
  }
}

// Users expect a word about what may be a camera, and none about anything else.
TEST(ValidateFolder, CountsCamerasOfOtherProgramsAndNoOtherFile) {
  const ScratchFolder scratch;
  scratch.write("set/camera.yaml", readFile(dataPath("camera.yaml")));
  const std::vector<std::string> foreign = {
      scratch.write("set/calib.npz", "PK"), scratch.write("set/front.toml", "[camera]\nfx = 533\n"),
      scratch.write("set/left.ini", "[image]\ncamera matrix\ndistortion\n"),
      scratch.write("set/left.toml", "[cam_0]\ndistortions = [0, 0, 0, 0, 0]\n"),
      scratch.write("set/values.PKL", "\x80\x04}\x8c\x03mtx")};
  scratch.write("set/pyproject.toml", "[project]\nname = 'a'\n");
  scratch.write("set/corners.csv", readFile(dataPath("corners.csv")));
  scratch.write("set/numbers.npz", "PK numbers.npy");
  scratch.write("set/photo.png", "no camera_matrix is looked for here");
  const RunResult result =
      runAlidade({"validate", scratch.path("set"), "--junit", scratch.path("report.xml")});
  EXPECT_THAT(result, EndsWith(0));
  EXPECT_THAT(result.out,
              testing::EndsWith("\n1 file: 1 passed, 0 failed; 5 other files without a readable camera\n"));
  const RunResult verbose = runAlidade({"validate", scratch.path("set"), "--verbose"});
  pugi::xml_document report;
  ASSERT_TRUE(report.load_file(scratch.path("report.xml").c_str()));
  for (const char* node : {"testsuites", "testsuites/testsuite"}) {
    const pugi::xml_node suite = report.select_node(node).node();
    EXPECT_EQ(suite.attribute("tests").as_int(), 6);
    EXPECT_EQ(suite.attribute("failures").as_int(), 0);
    EXPECT_EQ(suite.attribute("skipped").as_int(), 5);
  }
  const auto skipped = report.select_nodes("//testcase[skipped/@message]");
  ASSERT_EQ(skipped.size(), foreign.size());
  for (std::size_t i = 0; i < foreign.size(); ++i) {
    EXPECT_EQ(skipped[i].node().attribute("name").as_string(), foreign[i]);
    EXPECT_STREQ(skipped[i].node().attribute("classname").as_string(), "other_file");
    EXPECT_THAT(verbose.out, HasSubstr("other " + foreign[i] + "  not a camera file"));
  }
  // Alone they are no folder of camera files.
  scratch.write("other/calib.toml", "");
  EXPECT_THAT(runAlidade({"validate", scratch.path("other")}),
              FailsWith(1, HasSubstr("no file with the extension of a camera file")));
}

// OpenCV ships a pair of which the first camera has the coefficients of another lens: on the photographs of
// the samples it is off by 16 px.
TEST(ValidateFolder, WarnsOfOpenCvsOwnPair) {
  const ScratchFolder scratch;
  const std::string file = scratch.write(
      "intrinsics.yml", stereoText("0.29589, -1.03547, 0., 0., 0., 0., 0., 0., 0., 0., 0., 0., 0., 0."));
  const RunResult result = runAlidade({"validate", file});
  EXPECT_THAT(result, EndsWith(0));
  EXPECT_THAT(result.out,
              AllOf(testing::StartsWith("WARN  "), HasSubstr("1: one_to_one: the distortion folds over"),
                    HasSubstr("% of an image of 658x475 px around the principal point has a ray")));
  EXPECT_THAT(runAlidade({"validate", file, "--strict"}), EndsWith(3));
  EXPECT_THAT(runAlidade({"validate", file, "--image-size", "640x480"}), EndsWith(3));
}

}  // namespace
}  // namespace alidade
