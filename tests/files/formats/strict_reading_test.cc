// SPDX-License-Identifier: MIT
// Formats of the table, and messages of several cameras: no number is dropped in silence, no camera gets the
// numbers or the name of another one, and small texts that stand for very much end soon.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <chrono>

#include "alidade/files/camera_source.h"
#include "alidade/files/formats/camera_format.h"
#include "alidade/files/text/atomic_file.h"
#include "files/formats/reading.h"
#include "support/source_tree.h"

namespace alidade {
namespace {

using testing::AllOf;
using testing::HasSubstr;

// An example of docs/examples/formats with a part replaced.
std::string changedExample(const std::string& file, const std::string& from, const std::string& to) {
  std::string text = readBinaryFile(sourcePath("docs/examples/formats/" + file), 1U << 20U);
  const std::size_t at = text.find(from);
  EXPECT_NE(at, std::string::npos) << file << ": " << from;
  return at == std::string::npos ? text : text.replace(at, from.size(), to);
}

std::string remarksOf(const CameraSource& source) {
  std::string all;
  for (const StatedCamera& camera : source.cameras) all += remarksOn(camera);
  return all;
}

std::vector<std::string> namesOf(const CameraSource& source) {
  std::vector<std::string> names;
  for (const StatedCamera& camera : source.cameras) names.push_back(camera.name);
  return names;
}

const std::string kFlat = "fx: 500\nfy: 501\ncx: 320\ncy: 240\nwidth: 640\nheight: 480\n";
const std::string kFive = "dist: [-0.1, 0.02, 0.001, 0.002, 0.03]\n";
const std::string kKeys = "k1: -0.1\nk2: 0.02\np1: 0.001\np2: 0.002\n";

TEST(StrictReading, RefusesNumbersThatTheLensDoesNotHave) {
  const std::string perspective = "\"focal\": 0.8, \"k1\": -0.1, \"k2\": 0.02}";
  const std::string vikit =
      "cam_model: Pinhole\ncam_width: 640\ncam_height: 480\ncam_fx: 500\ncam_fy: 501\n"
      "cam_cx: 320\ncam_cy: 240\n";
  const std::vector<std::pair<std::string, std::string>> refused = {
      {changedExample("opensfm.json", perspective, "\"focal\": 0.8, \"p1\": 0.001, \"k1\": 0, \"k2\": 0}"),
       "v2 another.p1: found '0.001'; expected 0, because the lens 'perspective' has none"},
      {changedExample("opensfm.json", perspective, "\"focal\": 0.8, \"k3\": 0.1, \"k1\": 0, \"k2\": 0}"),
       "k3"},
      {vikit + "k1: 0.1\n", "file:8: k1: found '0.1'"},
      {changedExample("aslam.yaml", "type: radial-tangential", "type: none"), "found numbers; expected 0"},
      {changedExample("metashape.xml", "<b1>", "<p3>0.1</p3><b1>"), "p3: found '0.1'"},
      {changedExample("metashape.xml", "<b1>", "<p4>-0.1</p4><b1>"), "p4: found '-0.1'"},
      {kFlat + kFive + "skew: 0.5\n", "file:8: skew: found '0.5'"},
      {kFlat + kFive + "xi: 1.2\n", "xi: found '1.2'"},
      {kFlat + kFive + "k4: 0.1\n", "k4: found '0.1'"},
      {kFlat + kKeys + "xi: 1.2\n", "xi: found '1.2'"},
      {kFlat + kKeys + "k4: 0.1\n", "6 distortion coefficients"},
      {kFlat + kKeys + "model: division\n", "'division'"},
      {kFlat + kKeys + "model: fisheye\nk3: 0.1\nk4: 0.1\n", "p1: found '0.001'"},
      {changedExample("zed.conf", "k3=-.001\n", "k3=-.001\nk4=0.1\n"), "6 distortion coefficients"}};
  std::size_t num_refused = 0;
  for (const auto& [text, part] : refused) {
    EXPECT_THAT(complaintAbout(text), HasSubstr(part)) << text;
    ++num_refused;
  }
  EXPECT_EQ(num_refused, 14U);
  // Zeros are no numbers of another lens.
  for (const std::string& text :
       {changedExample("opensfm.json", perspective, "\"focal\": 0.8, \"p1\": 0, \"k1\": 0, \"k2\": 0}"),
        changedExample("metashape.xml", "<b1>", "<p3>0</p3><b1>"), vikit + "k1: 0\n",
        kFlat + kFive + "skew: 0.0\nxi: 0\n", kFlat + kKeys + "k4: 0\n"})
    EXPECT_EQ(complaintAbout(text), "") << text;
}

TEST(StrictReading, UsesWhatFlatFilesState) {
  const auto modelOf = [](const std::string& text) {
    return std::string(parseCameras(text, "file").cameras.at(0).camera.modelId());
  };
  const CameraSource rational =
      parseCameras(kFlat + kKeys + "k3: 0.03\nk4: 0.4\nk5: 0.05\nk6: 0.006\n", "file");
  EXPECT_THAT(rational.cameras.at(0).camera.parameters(),
              testing::ElementsAre(500, 501, 320, 240, -0.1, 0.02, 0.001, 0.002, 0.03, 0.4, 0.05, 0.006));
  EXPECT_EQ(modelOf(kFlat + kKeys + "model: radtan\n"), "radtan");
  EXPECT_EQ(modelOf(kFlat + "model: equidistant\nk1: 0.1\nk2: 0\nk3: 0\nk4: 0\np1: 0\np2: 0\n"),
            "kannala_brandt");
  EXPECT_EQ(modelOf(kFlat + "camera_model: pinhole\ndistortion_model: equidistant\nD: [0.1, 0, 0, 0]\n"),
            "kannala_brandt");
  EXPECT_EQ(modelOf(kFlat + "camera_model: pinhole\ndistortion_model: radtan\nD: [0.1, 0, 0, 0]\n"),
            "radtan");
  EXPECT_EQ(modelOf(kFlat + "camera_model: pinhole\ndistortion_model: none\nD: []\n"), "pinhole");
  EXPECT_THAT(complaintAbout(kFlat + "distortion_model: none\nD: [0, 0.1, 0, 0]\n"),
              HasSubstr("0.1 as number 6"));
  EXPECT_THAT(complaintAbout(kFlat + "model: radtan\ndistortion_model: fisheye\nD: [0.1, 0, 0, 0]\n"),
              HasSubstr("'radtan+fisheye'"));
  EXPECT_EQ(modelOf(changedExample("zed.conf", "k3=-.001\n", "k3=-.001\nk4=0.1\nk5=0\nk6=0.1\n")),
            "rational");
}

TEST(StrictReading, RefusesAlternativesThatDisagree) {
  const std::vector<std::pair<std::string, std::vector<std::string>>> refused = {
      {kFlat + kFive + "D: [-0.1, 0.02, 0.001, 0.002, 0.06]\n", {"file:8: D", "differs from file:7: dist"}},
      {kFlat + kFive + "w: 0.9\n", {"file:8: w", "differs from file:5: width"}},
      {kFlat + kFive + "distortion: fisheye\n", {"file:8: distortion", "differs from file:7: dist"}},
      {changedExample("vikit.yaml", "cam_model: ATAN", "cam_model: EquidistantCamera\nk1: 0.5"),
       {"cam_d0", "k1"}}};
  std::size_t num_refused = 0;
  for (const auto& [text, parts] : refused) {
    for (const std::string& part : parts) EXPECT_THAT(complaintAbout(text), HasSubstr(part)) << text;
    ++num_refused;
  }
  EXPECT_EQ(num_refused, 4U);
  EXPECT_EQ(complaintAbout(kFlat + kFive + "D: [-0.1, 0.02, 0.001, 0.0020, 0.03]\nw: 640\n"), "");
  // A rotation as a vector and as a matrix.
  const auto withTurn = [](const std::string& turn) {
    return parseCameras(changedExample("easymocap.yaml", "names:",
                                       "R_01: [0, " + turn +
                                           ", 0]\nRot_01: [1, 0, 0, 0, 1, 0, 0, 0, 1]\nT_01: [0, 0, 0]\n"
                                           "R_02: [0, 0, 0]\nT_02: [1, 0, 0]\nnames:"),
                        "file");
  };
  EXPECT_TRUE(withTurn("0").cameras.at(1).camera_from_rig);
  EXPECT_THAT(remarksOf(withTurn("0.1")), AllOf(HasSubstr("bad_pose"), HasSubstr("differs from")));
}

TEST(StrictReading, RefusesListsWhereOneNumberBelongs) {
  const std::vector<std::pair<std::string, std::string>> refused = {
      {"fx: [500, 501, 320]\nfy: 501\ncx: 320\ncy: 240\n" + kFive, "file:1: fx: found a list"},
      {"fx: [500]\nfy: 501\ncx: 320\ncy: 240\n" + kKeys, "file:1: fx: found a list"},
      {changedExample("woodscape.json", "\"k1\": 340.0", "\"k1\": []"), "k1: found a list"},
      {changedExample("woodscape.json", "\"aspect_ratio\": 1.01", "\"aspect_ratio\": []"), "found a list"},
      {changedExample("driveworks.json", "\"0 1.0e-03 -2.0e-09 3.0e-11 4.0e-15\"", "\"\""),
       "5 numbers of the lens"},
      {changedExample("driveworks.json", "\"0 950 -3 -12 2 0\"", "\"0\""), "6 numbers of the lens"},
      {changedExample("driveworks.json", "\"cx\": \"963.5\"", "\"cx\": []"), "found a list"},
      {changedExample("oak.json",
                      "[-0.01, 0.02, -0.03, 0.004, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0]",
                      "[-0.01, 0.02, -0.03]"),
       "7 numbers of the lens"}};
  std::size_t num_refused = 0;
  for (const auto& [text, part] : refused) {
    EXPECT_THAT(complaintAbout(text, {.image_size = ImageSize{640, 480}, .model = ""}), HasSubstr(part))
        << text;
    ++num_refused;
  }
  EXPECT_EQ(num_refused, 8U);
}

TEST(StrictReading, NamesTheCamerasOfOakByTheirSockets) {
  const std::string second = "[1, {\"cameraType\": 1";
  EXPECT_THAT(namesOf(parseCameras(
                  changedExample("oak.json", "[0, {\"cameraType\": 0", "[4, {\"cameraType\": 0"), "file")),
              testing::ElementsAre("CAM_E", "CAM_B"));
  // One that is not calibrated is left out, and shifts no name.
  for (const std::string matrix : {"[]", "[[0, 0, 0], [0, 0, 0], [0, 0, 0]]"}) {
    const CameraSource source = parseCameras(
        changedExample(
            "oak.json", "\"cameraData\": [",
            "\"cameraData\": [[2, {\"cameraType\": 0, \"width\": 0, \"height\": 0, \"intrinsicMatrix\": " +
                matrix + ", \"distortionCoeff\": []}],"),
        "file");
    EXPECT_THAT(namesOf(source), testing::ElementsAre("CAM_A", "CAM_B"));
    EXPECT_THAT(remarksOf(source),
                HasSubstr("not_carried: file:3: cameraData[0][1]: not a calibrated camera"));
  }
  EXPECT_THAT(
      namesOf(parseCameras(changedExample("oak.json", "\"cameraData\": [", "\"cameraData\": [[],"), "file")),
      testing::ElementsAre("CAM_A", "CAM_B"));
}

TEST(StrictReading, PrefersTheAdjustedCalibrationOfMetashape) {
  const auto calibration = [](const std::string& name, const std::string& f) {
    return "<calibration type='frame' class='" + name + "'><resolution width='640' height='480'/><f>" + f +
           "</f><k1>0.1</k1></calibration>\n";
  };
  const auto document = [](const std::string& sensors) {
    return "<document><chunk><sensors>" + sensors + "</sensors></chunk></document>";
  };
  const std::string both =
      "<sensor id='0'>" + calibration("initial", "400") + calibration("adjusted", "500") + "</sensor>\n";
  const std::string one = "<sensor id='1'>" + calibration("initial", "600") + "</sensor>\n";
  const CameraSource source = parseCameras(document(both + one), "file");
  ASSERT_EQ(source.cameras.size(), 2U);
  EXPECT_EQ(source.cameras[0].camera.parameters()[0], 500);
  EXPECT_EQ(remarksOn(source.cameras[0]), "");
  EXPECT_EQ(source.cameras[1].camera.parameters()[0], 600);
  EXPECT_THAT(remarksOn(source.cameras[1]), AllOf(HasSubstr("assumed"), HasSubstr("'initial'")));
  const CameraSource alone = parseCameras(document(both), "file");
  ASSERT_EQ(alone.cameras.size(), 1U);
  EXPECT_EQ(alone.cameras[0].camera.parameters()[0], 500);
}

// The parent of all poses of multical is the first camera.
TEST(StrictReading, TakesPosesOnlyIfEachCameraHasOne) {
  const std::string child = "\"right_to_left\"";
  const auto poseOf = [](const std::string& text) {
    const CameraSource source = parseCameras(text, "file");
    return source.cameras.at(1).camera_from_rig.has_value();
  };
  EXPECT_TRUE(poseOf(changedExample("multical.json", child, child)));
  EXPECT_FALSE(poseOf(changedExample("multical.json", child, "\"right_to_middle\"")));
  EXPECT_FALSE(poseOf(changedExample(
      "multical.json",
      "\"left\": {\"R\": [[1, 0, 0], [0, 1, 0], [0, 0, 1]], \"T\": [0, 0, 0]},\n  \"right_to_left\"",
      "\"right\": {\"R\": [[1, 0, 0], [0, 1, 0], [0, 0, 1]], \"T\": [0, 0, 0]},\n  \"left_to_right\"")));
  EXPECT_THAT(remarksOf(parseCameras(changedExample("multical.json", child, "\"right_to_middle\""), "file")),
              HasSubstr("not_carried: file:4: cameras.right: camera 'right' has no pose"));
  EXPECT_THAT(remarksOf(parseCameras(changedExample("caliscope.toml", "rotation = ", "turn = "), "file")),
              HasSubstr("camera '0' has no pose, so the poses of the others are not read"));
}

TEST(StrictReading, TellsWhatItTakesForGranted) {
  const std::string realsense =
      changedExample("realsense.json", "\"coeffs\": [0.0, 0.0", "\"coeffs\": [0.1, 0.0");
  EXPECT_THAT(
      remarksOf(parseCameras(realsense, "file")),
      AllOf(HasSubstr("assumed: file:4: depth.coeffs: "), HasSubstr("Inverse Brown Conrady is taken as")));
  // Once for all cameras of a flat file.
  const CameraSource kitti =
      parseCameras(changedExample("kitti.txt", "corner_dist", "x: 1\ncorner_distance"), "file");
  EXPECT_THAT(remarksOn(kitti.cameras.at(0)), HasSubstr("unknown_keys"));
  EXPECT_EQ(remarksOn(kitti.cameras.at(1)), "");
  EXPECT_THAT(complaintAbout("Pinhole 500 501 -1 0.5 0\n640 480\ncrop\n640 480\n"),
              HasSubstr("the principal point -1, 0.5"));
  const ReadOptions roi{.image_size = {}, .model = "", .applies_roi = true};
  EXPECT_THAT(remarksOf(parseCameras(kFlat + kFive, "file", roi)), HasSubstr("--apply-roi changes nothing"));
}

TEST(StrictReading, OfMessagesOfSeveralCamerasFollowsTheRulesOfOne) {
  const auto message = [](const std::string& more) {
    return "{width: 640, height: 480, distortion_model: plumb_bob, D: [0.1, 0, 0, 0, 0], "
           "K: [500, 0, 320, 0, 501, 240, 0, 0, 1]" +
           more + "}";
  };
  const auto pose = [](double shift) {
    return ", R: [1, 0, 0, 0, 1, 0, 0, 0, 1], P: [500, 0, 320, " + std::to_string(-500 * shift) +
           ", 0, 501, 240, 0, 0, 0, 1, 0]";
  };
  // Several may be those of several pairs, each with a frame of its own.
  const CameraSource pair =
      parseCameras("left: " + message(pose(0)) + "\nright: " + message(pose(0.1)) + "\n", "file");
  EXPECT_EQ(pair.format, "ros");
  EXPECT_THAT(namesOf(pair), testing::ElementsAre("left", "right"));
  EXPECT_FALSE(pair.cameras.at(1).camera_from_rig);
  EXPECT_THAT(remarksOn(pair.cameras.at(1)), HasSubstr("not_carried: file:2: right.P"));
  EXPECT_TRUE(parseCameras("[" + message(pose(0)) + "]", "file").cameras.at(0).camera_from_rig);
  const std::string roi =
      "a: " + message(", roi: {x_offset: 10, y_offset: 0, width: 320, height: 240}") + "\n";
  EXPECT_THAT(remarksOf(parseCameras(roi, "file")), HasSubstr("--apply-roi reads that of the part"));
  const CameraSource part =
      parseCameras("rig:\n - " + message(", roi: {x_offset: 10, y_offset: 0, width: 320, height: 240}"),
                   "file", {.image_size = {}, .model = "", .applies_roi = true});
  EXPECT_EQ(part.cameras.at(0).camera.parameters()[2], 310);
  EXPECT_THAT(
      complaintAbout("a: {width: 640, height: 480, distortion_model: '', D: [0.1, 0, 0, 0], K: [500, 0, 320, "
                     "0, 501, 240, 0, 0, 1]}\n"),
      HasSubstr("no distortion model"));
  // A name of digits is no list of numbers.
  EXPECT_EQ(parseCameras(
                "camera_name: 0012 3456\nimage_width: 640\nimage_height: 480\ndistortion_model: plumb_bob\n"
                "camera_matrix: {rows: 3, cols: 3, data: [500, 0, 320, 0, 501, 240, 0, 0, 1]}\n"
                "distortion_coefficients: {rows: 1, cols: 5, data: [0.1, 0, 0, 0, 0]}\n",
                "file")
                .cameras.at(0)
                .name,
            "0012 3456");
}

TEST(StrictReading, EndsSoonForTextsThatStandForVeryMuch) {
  std::string ones = "[0";
  for (int i = 0; i < 1000; ++i) ones += ",0";
  ones += "]";
  std::string aliases = "[*a";
  for (int i = 0; i < 1000; ++i) aliases += ",*a";
  aliases += "]";
  std::string keys = "{k: 0";
  for (int i = 0; i < 900; ++i) keys += ", k" + std::to_string(i) + ": 0";
  keys += "}";
  std::string elements = "<calibration>";
  for (int i = 0; i < 60000; ++i) elements += "<a" + std::to_string(i) + "/>";
  elements += "</calibration>";
  std::string list = "[0";
  for (int i = 0; i < 1000000; ++i) list += ",0";
  const std::vector<std::string> texts = {"x: &a " + ones + "\ncameras: " + aliases + "\n",
                                          "x: &a " + keys + "\ncameras: " + aliases + "\n",
                                          "cameras: " + list + "]\n", "[" + list + "]]", elements};
  const auto start = std::chrono::steady_clock::now();
  std::size_t num_refused = 0;
  for (const std::string& text : texts) num_refused += complaintAbout(text).empty() ? 0 : 1;
  EXPECT_EQ(num_refused, 5U);
  EXPECT_LT(std::chrono::steady_clock::now() - start, std::chrono::seconds(60));
}

}  // namespace
}  // namespace alidade
