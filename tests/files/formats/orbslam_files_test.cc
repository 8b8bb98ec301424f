// SPDX-License-Identifier: MIT
// ORB-SLAM's settings and OpenVSLAM's: which lens they mean, and what they say that no lens holds.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "alidade/files/camera_source.h"
#include "files/formats/reading.h"

namespace alidade {
namespace {

using testing::AllOf;
using testing::HasSubstr;
using testing::Not;

const std::string kSize = "Camera.width: 640\nCamera.height: 480\n";

std::string pinhole(const std::string& prefix) {
  return prefix + ".fx: 500.0\n" + prefix + ".fy: 501.0\n" + prefix + ".cx: 320.0\n" + prefix +
         ".cy: 240.0\n";
}

// "Camera.k1: 0.1\n" for each name.
std::string coefficients(const std::string& prefix, const std::vector<std::string>& names,
                         const std::string& value = "0.1") {
  std::string text;
  for (const std::string& name : names) text += prefix + "." + name + ": " + value + "\n";
  return text;
}

TEST(OrbslamFiles, WithACoefficientThatTheLensHasNotAreRefused) {
  struct Case {
    std::string first_line;
    std::vector<std::string> names;
    std::string place;
    std::string expected;
    std::string advice;
  };
  const std::vector<Case> cases = {
      {"Camera.type: \"PinHole\"\n",
       {"k1", "k2", "p1", "p2", "k3", "k4"},
       "file:11: Camera.k4",
       "an ordinary lens has k1 k2 p1 p2 k3",
       "write Camera.type: KannalaBrandt8"},
      {"Camera.type: \"PinHole\"\n",
       {"k1", "k2", "p1", "p2", "k6"},
       "file:10: Camera.k6",
       "an ordinary lens has k1 k2 p1 p2 k3",
       "only these"},
      {"\n",
       {"k1", "k2", "p1", "p2", "k3", "k4"},
       "file:11: Camera.k4",
       "an ordinary lens has",
       "write Camera.type: KannalaBrandt8"},
      {"Camera.type: \"Rectified\"\n",
       {"k1"},
       "file:6: Camera.k1",
       "Rectified images have no distortion",
       "write PinHole"},
      {"Camera.type: \"KannalaBrandt8\"\n",
       {"k1", "k2", "p1", "p2"},
       "file:8: Camera.p1",
       "p1 and p2 belong to PinHole",
       "correct the type"},
      {"Camera.model: \"perspective\"\n",
       {"k1", "k2", "k3", "k4"},
       "file:9: Camera.k4",
       "an ordinary lens has",
       "write Camera.model: fisheye"},
  };
  int num_refused = 0;
  for (const Case& one : cases) {
    const std::string start = one.first_line + pinhole("Camera");
    EXPECT_THAT(
        complaintAbout(start + coefficients("Camera", one.names) + kSize),
        AllOf(HasSubstr(one.place + ": found '0.1'"), HasSubstr(one.expected), HasSubstr(one.advice)));
    ++num_refused;
  }
  EXPECT_EQ(num_refused, 6);
  // Of the second camera too.
  EXPECT_THAT(complaintAbout("Camera.type: \"PinHole\"\n" + pinhole("Camera1") + pinhole("Camera2") +
                             coefficients("Camera2", {"k1", "k2", "p1", "p2", "k4"}) + kSize),
              HasSubstr("file:14: Camera2.k4"));
  // Zeros say nothing.
  const CameraSource zeros =
      parseCameras("Camera.type: \"Rectified\"\n" + pinhole("Camera") +
                       coefficients("Camera", {"k1", "k2", "p1", "p2", "k3", "k4", "k5"}, "0.0") + kSize,
                   "file");
  EXPECT_EQ(zeros.cameras.at(0).camera.modelId(), "pinhole");
  EXPECT_EQ(remarksOn(zeros.cameras.at(0)), "");
}

TEST(OrbslamFiles, OfAFisheyeWithoutATypeAskForIt) {
  for (const std::string prefix : {"Camera", "Camera1"}) {
    EXPECT_THAT(complaintAbout(pinhole(prefix) + coefficients(prefix, {"k1", "k2", "k3", "k4"}) + kSize),
                AllOf(HasSubstr("file:8: " + prefix + ".k4"), HasSubstr("no Camera.type"),
                      HasSubstr("write Camera.type: KannalaBrandt8")));
    // A k4 of 0 is none.
    const CameraSource plain =
        parseCameras(pinhole(prefix) + coefficients(prefix, {"k4"}, "0.0") + kSize, "file");
    EXPECT_EQ(plain.cameras.at(0).camera.modelId(), "pinhole");
    EXPECT_THAT(complaintAbout(pinhole(prefix) + coefficients(prefix, {"k1", "k2", "k3"}) +
                               coefficients(prefix, {"k4"}, "0.0") + kSize),
                AllOf(HasSubstr(prefix + ".p1"), Not(HasSubstr("KannalaBrandt8"))));
  }
}

TEST(OrbslamFiles, OfOpenVslamAreOfTheirModelAndSize) {
  EXPECT_THAT(complaintAbout("Camera.model: equirectangular\nCamera.cols: 640\nCamera.rows: 320\n"),
              AllOf(HasSubstr("file:1: Camera.model: found 'equirectangular'"),
                    HasSubstr("perspective or fisheye"), HasSubstr("next:")));
  EXPECT_THAT(complaintAbout("Camera.model: fisheye\nCamera.type: PinHole\n" + pinhole("Camera")),
              AllOf(HasSubstr("file:2: Camera.type: found 'PinHole' and Camera.model 'fisheye'")));
  const std::string plain = "Camera.model: perspective\n" + pinhole("Camera");
  EXPECT_THAT(complaintAbout(plain + "Camera.cols: 640\nCamera.rows: 512\n" + kSize),
              AllOf(HasSubstr("file:6: Camera.cols"), HasSubstr("an image size that differs")));
  EXPECT_THAT(complaintAbout(plain + "Camera.cols: 640\n"),
              AllOf(HasSubstr("file:6"), HasSubstr("add Camera.rows")));
  const ImageSize vga{.width = 640, .height = 480};
  const CameraSource given =
      parseCameras(plain + "Camera.cols: 640\n", "file", {.image_size = vga, .model = ""});
  EXPECT_EQ(given.cameras.at(0).image_size, std::optional(vga));
  EXPECT_THAT(remarksOn(given.cameras.at(0)), HasSubstr("assumed: file:6"));
}

TEST(OrbslamFiles, TellThatRawCamerasAreNotRead) {
  const CameraSource source = parseCameras("%YAML:1.0\n" + pinhole("Camera") + kSize +
                                               "LEFT.D: [-0.28, 0.07, 0.0001, 0.0001, 0.0]\nLEFT.K: [458.0, "
                                               "0.0, 367.0, 0.0, 457.0, 248.0, 0.0, 0.0, 1.0]\n",
                                           "file");
  EXPECT_EQ(source.cameras.at(0).camera.parameters()[0], 500.0);
  EXPECT_THAT(remarksOn(source.cameras.at(0)),
              AllOf(HasSubstr("not_carried: file:9: LEFT.K"), HasSubstr("belongs to the rectified images")));
}

// ORB-SLAM3's Settings.cc reads Stereo.T_c1_c2 as the left camera from the right one.
TEST(OrbslamFiles, OfTwoCamerasAreARigByTheirTransform) {
  const std::string cameras = pinhole("Camera1") + pinhole("Camera2") + kSize + "Camera.type: PinHole\n";
  const StatedCamera second =
      parseCameras(cameras + "Stereo.T_c1_c2: [0, -1, 0, 0.05, 1, 0, 0, 0.02, 0, 0, 1, 0.01, 0, 0, 0, 1]\n",
                   "file")
          .cameras.at(1);
  ASSERT_TRUE(second.camera_from_rig);
  // The right camera's centre, and a point in front of it.
  EXPECT_LT((*second.camera_from_rig * Eigen::Vector3d(0.05, 0.02, 0.01)).norm(), 1e-12);
  EXPECT_LT(
      (*second.camera_from_rig * Eigen::Vector3d(0.05 - 2, 0.02 + 1, 0.01 + 3) - Eigen::Vector3d(1, 2, 3))
          .norm(),
      1e-12);
  EXPECT_FALSE(parseCameras(cameras, "file").cameras.at(1).camera_from_rig);
  EXPECT_THAT(remarksOn(parseCameras(cameras + "Stereo.T_c1_c2: [1, 2]\n", "file").cameras.at(0)),
              HasSubstr("bad_pose"));
}

// ORB-SLAM2's stereo_euroc rectifies LEFT and RIGHT with R and P; Camera.bf is the baseline times fx.
TEST(OrbslamFiles, OfARawPairAreTheRigOfItsRawCameras) {
  const std::string side =
      ".height: 480\nSIDE.width: 640\nSIDE.D: [-0.28, 0.07, 0.0001, 0.0002, 0.0]\nSIDE.K: [458.0, 0.0, 367.0, 0.0, "
      "457.0, 248.0, 0.0, 0.0, 1.0]\nSIDE.R: [0.8, 0.6, 0, -0.6, 0.8, 0, 0, 0, 1]\nSIDE.P: [500, 0, 320, BF, 0, 500, "
      "240, 0, 0, 0, 1, 0]\n";
  const auto of = [&side](const std::string& name, const std::string& bf) {
    std::string text = name + side;
    for (std::size_t at = 0; (at = text.find("SIDE")) != std::string::npos;) text.replace(at, 4, name);
    return text.replace(text.find("BF"), 2, bf);
  };
  const std::string text =
      pinhole("Camera") + kSize + "Camera.bf: 55.0\n" + of("LEFT", "0") + of("RIGHT", "-55.0");
  const CameraSource raw = parseCameras(text, "file");
  ASSERT_EQ(raw.cameras.size(), 2U);
  EXPECT_EQ(raw.cameras[0].name, "LEFT");
  EXPECT_EQ(raw.cameras[1].name, "RIGHT");
  for (const StatedCamera& camera : raw.cameras) {
    EXPECT_EQ(camera.camera.modelId(), "radtan");
    EXPECT_EQ(camera.camera.parameter("fx"), 458);
    EXPECT_EQ(camera.camera.parameter("p2"), 0.0002);
    EXPECT_EQ(camera.image_size, std::optional(ImageSize{.width = 640, .height = 480}));
    EXPECT_THAT(remarksOn(camera), AllOf(HasSubstr("FILE#Camera1"), Not(HasSubstr("unknown_keys"))));
  }
  // The right camera stands 55 / 500 m to the right in the rectified frame, which the rig has.
  EXPECT_LT((*raw.cameras[1].camera_from_rig * Eigen::Vector3d(0.11, 0, 0)).norm(), 1e-12);
  EXPECT_LT(
      (*raw.cameras[0].camera_from_rig * Eigen::Vector3d(0.8, -0.6, 0) - Eigen::Vector3d(1, 0, 0)).norm(),
      1e-12);
  const CameraSource rectified =
      parseCameras(text, "file", {.image_size = {}, .model = "", .only = "Camera2"});
  ASSERT_EQ(rectified.cameras.size(), 2U);
  EXPECT_EQ(rectified.cameras[1].camera.parameter("fx"), 500);
  EXPECT_NEAR(rectified.cameras[1].camera_from_rig->translation.x(), -0.11, 1e-12);
}

}  // namespace
}  // namespace alidade
