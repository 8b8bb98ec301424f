// SPDX-License-Identifier: MIT
// Files that say two things, or leave something out: refused with both places, or read with a remark.
#include <cmath>
#include <tuple>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "alidade/core/error.h"
#include "alidade/files/camera_source.h"
#include "files/formats/reading.h"

namespace alidade {
namespace {

using testing::AllOf;
using testing::HasSubstr;

const std::string kRest =
    R"("ImageSize":[480,640],"RadialDistortion":[-0.1,0.02],"TangentialDistortion":[0,0]})";
const std::string kNamed = R"({"FocalLength":[500.25,501],"PrincipalPoint":[321,241],)";
const std::string kRosMatrix =
    "camera_matrix: {rows: 3, cols: 3, data: [532.8, 0, 342.5, 0, 532.9, 233.9, 0, 0, 1]}\n"
    "distortion_model: plumb_bob\n";
const std::string kRosCoefficients =
    "distortion_coefficients: {rows: 1, cols: 5, data: [-0.281, 0.025, 0.0012, -0.0001, 0.163]}\n";
const std::string kRosSize = "image_width: 640\nimage_height: 480\n";
const std::string kOpenCv =
    "camera_matrix: {rows: 3, cols: 3, data: [532.8, 0, 342.5, 0, 532.9, 233.9, 0, 0, 1]}\n" +
    kRosCoefficients;
const ReadOptions kWithSize{.image_size = ImageSize{.width = 640, .height = 480}, .model = ""};

TEST(FormatContradictions, OfMatlabsMatrixAndFocalLengthAreRefused) {
  for (const auto& [other, name] :
       {std::pair(R"("K":[[500,0,321],[0,501,241],[0,0,1]],)", "K"),
        std::pair(R"("K":[[500.25,0,321],[0,501,240],[0,0,1]],)", "K"),
        std::pair(R"("IntrinsicMatrix":[[500.25,0,0],[0,502,0],[321,241,1]],)", "IntrinsicMatrix")}) {
    EXPECT_THAT(complaintAbout(kNamed + other + kRest),
                AllOf(HasSubstr("file:1: " + std::string(name)), HasSubstr("FocalLength"),
                      HasSubstr("values that agree")));
  }
  EXPECT_THAT(
      complaintAbout(R"({"K":[[500,0,321],[0,501,241],[0,0,1]],"Intrinsics":)" + kNamed + kRest + "}"),
      AllOf(HasSubstr("file:1: K"), HasSubstr("Intrinsics.FocalLength")));
}

TEST(FormatContradictions, OfMatlabAreNoneToPrintedDigits) {
  // "500.25" and "500.2500" are the same, and 500.3 is 500.25 rounded.
  for (const char* other :
       {R"("K":[[500.2500,0,321],[0,501.0,241],[0,0,1]],)", R"("K":[[500.3,0,321],[0,501,241],[0,0,1]],)",
        R"("IntrinsicMatrix":[[500.25,0,0],[0,501,0],[321,241,1]],)"}) {
    const CameraSource source = parseCameras(kNamed + other + kRest, "file");
    EXPECT_EQ(source.cameras.at(0).camera.parameters()[0], 500.25) << other;
    EXPECT_EQ(remarksOn(source.cameras.at(0)), "") << other;
  }
}

TEST(FormatContradictions, OfRosKeysOfTwoKindsAreRefused) {
  const std::string five = "[-0.281, 0.025, 0.0012, -0.0001, 0.163]\n";
  EXPECT_THAT(complaintAbout(kRosSize + kRosMatrix + "D: " + five),
              AllOf(HasSubstr("file:5: D"), HasSubstr("'camera_matrix'")));
  EXPECT_THAT(complaintAbout(kRosSize + kRosMatrix + kRosCoefficients + "K: [1, 0, 3, 0, 1, 2, 0, 0, 1]\n"),
              AllOf(HasSubstr("file:6: K"), HasSubstr("'camera_matrix' at file:3")));
  EXPECT_THAT(complaintAbout(kRosSize + kRosMatrix + kRosCoefficients + "width: 320\n"),
              AllOf(HasSubstr("file:6: width"), HasSubstr("'image_width'")));
  const CameraSource same = parseCameras(kRosSize + kRosMatrix + kRosCoefficients + "width: 640\nD: " + five +
                                             "K: [532.8, 0, 342.5, 0, 532.9, 233.9, 0, 0, 1]\n",
                                         "file");
  EXPECT_EQ(same.cameras.at(0).camera.parameters()[8], 0.163);
}

TEST(FormatContradictions, OfRosAProjectionOfItsOwnIsTold) {
  const auto remarks = [](const std::string& P) {
    return remarksOn(parseCameras(kRosSize + kRosMatrix + kRosCoefficients +
                                      "projection_matrix: {rows: 3, cols: 4, data: " + P + "}\n",
                                  "file")
                         .cameras.at(0));
  };
  EXPECT_THAT(remarks("[500, 0, 342, 0, 0, 501, 233, 0, 0, 0, 1, 0]"),
              AllOf(HasSubstr("not_carried: file:6"), HasSubstr("rectified")));
  EXPECT_EQ(remarks("[532.8, 0, 342.5, -60, 0, 532.9, 233.9, 0, 0, 0, 1, 0]"), "");
  EXPECT_EQ(remarks("[532.80000, 0, 342.50000, 0, 0, 533.0, 233.90000, 0, 0, 0, 1, 0]"), "");  // half a digit
  EXPECT_EQ(remarks("[0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0]"), "");
}

TEST(FormatOmissions, OfRosSizeAreLeftToTheUser) {
  int num_read = 0;
  for (const char* size :
       {"", "image_width: 0\nimage_height: 0\n", "image_width: 640\n", "image_height: 480\n"}) {
    const std::string text = size + kRosMatrix + kRosCoefficients;
    EXPECT_THAT(complaintAbout(text), AllOf(HasSubstr("file:"), HasSubstr("--image-size"))) << size;
    const StatedCamera camera = parseCameras(text, "file", kWithSize).cameras.at(0);
    EXPECT_EQ(camera.image_size, kWithSize.image_size);
    EXPECT_THAT(remarksOn(camera), AllOf(HasSubstr("assumed: file:1"), HasSubstr("640x480"))) << size;
    ++num_read;
  }
  EXPECT_EQ(num_read, 4);
  EXPECT_THAT(
      complaintAbout("image_width: 641\nimage_height: 0\n" + kRosMatrix + kRosCoefficients, kWithSize),
      AllOf(HasSubstr("'641'"), HasSubstr("640 from --image-size")));
}

TEST(FormatOmissions, OfOneSideInOpenCvsFilesAreNoticed) {
  struct Case {
    std::string stated;
    std::string place;
    std::string missing;
  };
  const ReadOptions hd{.image_size = ImageSize{.width = 1920, .height = 1080}, .model = ""};
  int num_cases = 0;
  for (const auto& [stated, place, missing] :
       {Case{"image_width: 640\n", "file:1: image_width", "image_height"},
        Case{"image_height: 480\n", "file:1: image_height", "image_width"},
        Case{"image_Width: 640\n", "file:1: image_Width", "image_Height"},
        Case{"height: 480\n", "file:1: height", "width"}}) {
    const std::string text = stated + kOpenCv;
    EXPECT_THAT(complaintAbout(text),
                AllOf(HasSubstr(place), HasSubstr("without '" + missing + "'"), HasSubstr("--image-size")));
    EXPECT_THAT(complaintAbout(text, hd), AllOf(HasSubstr(place), HasSubstr("1920x1080 from --image-size")));
    const StatedCamera camera = parseCameras(text, "file", kWithSize).cameras.at(0);
    EXPECT_EQ(camera.image_size, kWithSize.image_size);
    EXPECT_THAT(remarksOn(camera), AllOf(HasSubstr("assumed: " + place), HasSubstr("no " + missing),
                                         HasSubstr("640x480 from --image-size")));
    ++num_cases;
  }
  EXPECT_EQ(num_cases, 4);
  // Another pair of keys says the size.
  EXPECT_EQ(remarksOn(parseCameras("image_size: [640, 480]\nheight: 480\n" + kOpenCv, "file").cameras.at(0)),
            "");
  EXPECT_THAT(complaintAbout(kRosSize + "height: 6\n" + kOpenCv),
              AllOf(HasSubstr("file:3: height"), HasSubstr("640x480")));
}

TEST(FormatContradictions, OfOrbSlamKeysOfTwoKindsAreRefused) {
  const auto pinhole = [](const std::string& prefix) {
    return prefix + ".fx: 532.8\n" + prefix + ".fy: 532.9\n" + prefix + ".cx: 342.5\n" + prefix +
           ".cy: 233.9\n";
  };
  const std::string both =
      "%YAML:1.0\n---\nCamera.type: \"PinHole\"\n" + pinhole("Camera") + pinhole("Camera1");
  const std::string older = "%YAML:1.0\n---\nCamera.type: \"PinHole\"\n" + pinhole("Camera");
  int num_refused = 0;
  for (const auto& [text, place, other] :
       {std::tuple(both + "Camera.k1: 0.1\nCamera1.k1: 0.2\n", "file:12: Camera.k1", "file:13: Camera1.k1"),
        std::tuple(both + "Camera.k1: 0.1\n", "file:12: Camera.k1", "file:8: Camera1.fx"),
        std::tuple(older + "Camera1.k1: 0.1\n", "file:8: Camera1.k1", "file:4: Camera.fx"),
        std::tuple(older + "Camera1.fx: 500.0\n", "file:4: Camera.fx", "file:8: Camera1.fx"),
        std::tuple(older + "Camera1.cy: 500.0\n", "file:8: Camera1.cy", "file:7: Camera.cy")}) {
    EXPECT_THAT(complaintAbout(text), AllOf(HasSubstr(place), HasSubstr(other))) << text;
    ++num_refused;
  }
  EXPECT_EQ(num_refused, 5);
  for (const char* more :
       {"", "Camera.k1: 0.0\n",
        "Camera.k1: 0.10\nCamera1.k1: 0.1\nCamera1.k2: 0\nCamera1.p1: 0\nCamera1.p2: 0\n"}) {
    const CameraSource source = parseCameras(both + more, "file");
    ASSERT_EQ(source.cameras.size(), 1U);
    EXPECT_EQ(source.cameras[0].camera.parameters()[0], 532.8);
    EXPECT_EQ(remarksOn(source.cameras[0]), "");
  }
}

// A slip in the key of the coefficients must not make a pinhole of the camera.
TEST(FormatOmissions, OfOpenCvsCoefficientsAreNoticed) {
  const std::string camera = R"({"camera_matrix": [[500, 0, 320], [0, 500, 240], [0, 0, 1]])";
  int num_noticed = 0;
  for (const char* coefficients : {"[-0.1, 0.02, 0, 0, 0]", "[[-0.1, 0.02, 0, 0, 0]]"}) {
    EXPECT_THAT(complaintAbout(camera + R"(, "dist_coef": )" + coefficients + "}"),
                AllOf(HasSubstr("5 numbers in 'dist_coef'"), HasSubstr("coefficients under a known name")));
    ++num_noticed;
  }
  EXPECT_EQ(num_noticed, 2);
  EXPECT_EQ(complaintAbout(camera + "}"), "");
}

TEST(FormatContradictions, OfOpenCvAFlagIsOneOrZero) {
  const std::string four = kRosSize + kOpenCv.substr(0, kOpenCv.find("distortion_coefficients")) +
                           "distortion_coefficients: [-0.1, 0.02, 0.001, 0.002]\n";
  const auto modelOf = [&](const std::string& flag) {
    return std::string(
        parseCameras(four + "fisheye_model: " + flag + "\n", "file").cameras.at(0).camera.modelId());
  };
  for (const char* flag : {"1", "1.", "true"}) EXPECT_EQ(modelOf(flag), "kannala_brandt") << flag;
  for (const char* flag : {"0", "0.", "false"}) EXPECT_EQ(modelOf(flag), "radtan") << flag;
  int num_refused = 0;
  for (const char* flag : {"2", "-1", "0.5", "yes", "\"\""}) {
    for (const char* more : {"", "xi: 0.5\n"}) {
      EXPECT_THAT(complaintAbout(four + more + "fisheye_model: " + flag + "\n"),
                  AllOf(HasSubstr(": fisheye_model: found"), HasSubstr("1 for a fisheye")))
          << flag;
      ++num_refused;
    }
  }
  EXPECT_EQ(num_refused, 10);
  EXPECT_THAT(complaintAbout(four + "xi: 0.5\nfisheye_model: 1\n"), HasSubstr("and 'xi'"));
  EXPECT_EQ(complaintAbout(four + "xi: 0.5\nfisheye_model: 0\n"), "");
}

TEST(FormatOmissions, OfNerfFocalLengthsAreWorkedOutFromTheAngle) {
  const std::string angle = R"({"camera_angle_x":0.6911112070083618,)";
  const std::string frames = R"("frames":[{"file_path":"a.png"},{"file_path":"b.png"}]})";
  const double focal = 0.5 * 800 / std::tan(0.5 * 0.6911112070083618);
  const StatedCamera blender =
      parseCameras(angle + frames, "file",
                   {.image_size = ImageSize{.width = 800, .height = 600}, .model = ""})
          .cameras.at(0);
  EXPECT_EQ(blender.camera.modelId(), "pinhole");
  EXPECT_THAT(std::vector<double>(blender.camera.parameters().begin(), blender.camera.parameters().end()),
              testing::ElementsAre(focal, focal, 399.5, 299.5));
  EXPECT_THAT(remarksOn(blender), AllOf(HasSubstr("fl_y the same"), HasSubstr("no cx"), HasSubstr("no cy")));
  const StatedCamera stated =
      parseCameras(R"({"camera_angle_x":0.69,"camera_angle_y":0.5,"cx":401.0,"w":800,"h":600,"frames":[]})",
                   "file")
          .cameras.at(0);
  EXPECT_EQ(stated.camera.parameters()[1], 300 / std::tan(0.25));
  EXPECT_EQ(stated.camera.parameters()[2], 400.5);
  EXPECT_THAT(remarksOn(stated), AllOf(HasSubstr("no cy"), testing::Not(HasSubstr("no cx"))));

  EXPECT_THAT(complaintAbout(angle + frames),
              AllOf(HasSubstr("file:1: camera_angle_x"), HasSubstr("w and h"), HasSubstr("--image-size")));
  EXPECT_THAT(complaintAbout(R"({"camera_angle_x":39.6,"w":800,"h":600,"frames":[]})"), HasSubstr("radians"));
  EXPECT_THAT(complaintAbout(R"({"is_fisheye":true,"camera_angle_x":0.6,"w":800,"h":600,"frames":[]})"),
              HasSubstr("fl_x, fl_y, cx and cy"));
}

TEST(FormatRemarks, NameTheLineOfTheKey) {
  struct Case {
    std::string text;
    std::string remark;
  };
  const std::string fisheye =
      "%YAML:1.0\n---\nmodel_type: KANNALA_BRANDT\ncamera_name: camera\nimage_width: 640\nimage_height: 480\n"
      "projection_parameters:\n   k2: -0.01\n   k3: 0.02\n   k4: -0.03\n   k5: 0.004\n   mu: 300.0\n   mv: "
      "301.0\n"
      "   u0: 320.0\n   v0: 240.0\n";
  const std::string nerf =
      "{\"w\": 640, \"h\": 480,\n\"fl_x\": 532.8, \"fl_y\": 532.9, \"cx\": 343.0, \"cy\": 234.4,\n";
  const std::vector<Case> cases = {
      {fisheye + "distortion_parameters:\n   k1: 0.1\n   k2: 0.2\n",
       "unknown_keys: file:16: distortion_parameters is unknown"},
      {fisheye + "   s: 1\n   t: 2\nserial: 7\n",
       "unknown_keys: file:16: projection_parameters.s, t (line 17) are unknown"},
      {fisheye + "serial: 7\nlens:\n  name: wide\n",
       "unknown_keys: file:16: serial, lens (line 17) are unknown"},
      {"%YAML:1.0\n---\n" + kRosSize + kRosMatrix + kRosCoefficients +
           "rectification_matrix:\n  rows: 3\n  cols: 3\n  data: [1, 0, 0, 0, 0.9, 0, 0, 0, 1]\n",
       "not_carried: file:8: rectification_matrix is ignored"},
      {kRosSize + kRosMatrix + kRosCoefficients + "roi:\n  x_offset: 1\n  width: 320\n",
       "not_carried: file:6: roi:"},
      {kRosSize + kRosMatrix + kRosCoefficients +
           "projection_matrix:\n  rows: 3\n  cols: 4\n  data: [500, 0, 342, 0, 0, 501, 233, 0, 0, 0, 1, 0]\n",
       "not_carried: file:6: projection_matrix:"},
      {nerf + "\"camera_model\": \"OPENCV\",\n\n\"serial\":\n{\"a\": [1,\n2]},\n\"lens\": 7}",
       "unknown_keys: file:5: serial, lens (line 8) are unknown"},
      {"<?xml "
       "version=\"1.0\"?>\n<opencv_storage>\n<image_width>640</image_width>\n<image_height>480</"
       "image_height>\n"
       "<camera_matrix type_id=\"opencv-matrix\">\n  <rows>3</rows>\n  <cols>3</cols>\n  <dt>d</dt>\n  "
       "<data>\n"
       "    500 0 320 0\n    500 240 0 0 1</data></camera_matrix>\n"
       "<distortion_coefficients>0.1 0.2 0 0 "
       "0.1</distortion_coefficients>\n<flag_fisheye>\n0</flag_fisheye>\n"
       "<lens>\n<name>wide</name></lens>\n</opencv_storage>\n",
       "unknown_keys: file:13: flag_fisheye, lens (line 15) are unknown"},
  };
  int num_lines = 0;
  for (const Case& c : cases) {
    EXPECT_THAT(remarksOn(parseCameras(c.text, "file").cameras.at(0)), HasSubstr(c.remark)) << c.text;
    ++num_lines;
  }
  EXPECT_EQ(num_lines, 8);
}

TEST(FormatContradictions, OfNerfAnglesAndFocalLengthsAreRefused) {
  // 640 pixels at 500 px are 1.1384 rad, 480 at 500 px 0.8954 rad; a fisheye of 500 px sees 1.28 rad.
  const std::string rest = R"("fl_x":500.0,"fl_y":500.0,"cx":320.0,"cy":240.0,"w":640,"h":480,"frames":[]})";
  int num_refused = 0;
  for (const auto& [angle, key, focal] :
       {std::tuple(R"("camera_angle_x":1.16,)", "camera_angle_x", "fl_x"),
        std::tuple(R"("camera_angle_x":1.28,)", "camera_angle_x", "fl_x"),
        std::tuple(R"("camera_angle_x":0.8954,)", "camera_angle_x", "fl_x"),
        std::tuple(R"("camera_angle_x":1.1384,"camera_angle_y":1.1384,)", "camera_angle_y", "fl_y"),
        std::tuple(R"("camera_model":"OPENCV_FISHEYE","camera_angle_x":1.5,)", "camera_angle_x", "fl_x")}) {
    EXPECT_THAT(complaintAbout("{" + std::string(angle) + rest),
                AllOf(HasSubstr("file:1: " + std::string(key)), HasSubstr("file:1: " + std::string(focal)),
                      HasSubstr("500")));
    ++num_refused;
  }
  EXPECT_EQ(num_refused, 5);
  for (const char* angle :
       {R"("camera_angle_x":1.1384,"camera_angle_y":0.8954,)", R"("camera_angle_x":1.135,)",
        R"("camera_model":"OPENCV_FISHEYE","camera_angle_x":1.1384,)",
        R"("camera_model":"OPENCV_FISHEYE","camera_angle_x":1.28,)"})
    EXPECT_EQ(complaintAbout("{" + std::string(angle) + rest), "") << angle;
}

TEST(FormatContradictions, OfNerfFramesAndTheTopAreRefused) {
  const std::string lens = R"("fl_x":500.0,"fl_y":501.0,"cx":320.0,"cy":240.0,)";
  const std::string half = R"("fl_x":250.0,"fl_y":250.5,"cx":160.0,"cy":120.0)";
  const auto file = [](const std::string& top, const std::string& frame) {
    return R"({"camera_model":"OPENCV",)" + top + R"("w":640,"h":480,"k1":0.1,)" + "\n" +
           R"("frames":[{"file_path":"a.png"},)" + "\n{" + R"("file_path":"b.png",)" + frame + "}]}";
  };
  const CameraSource same = parseCameras(file(lens, R"("w":640.0,"h":480,"fl_x":500.0)"), "file");
  ASSERT_EQ(same.cameras.size(), 1U);
  EXPECT_EQ(remarksOn(same.cameras[0]), "");
  int num_refused = 0;
  for (const std::string& frame :
       {half + R"(,"w":320,"h":240)", std::string(R"("w":320,"h":240)"), R"("w":320,)" + half,
        std::string(R"("fl_x":250.0)"), std::string(R"("w":640,"h":481)")}) {
    EXPECT_THAT(
        complaintAbout(file(lens, frame)),
        AllOf(HasSubstr("file:3: frames[1]."), HasSubstr(" where file:1: "), HasSubstr("as at the top")))
        << frame;
    ++num_refused;
  }
  EXPECT_EQ(num_refused, 5);
}

TEST(FormatTexts, ThatAreNotUtf8AreRefusedWithTheirLine) {
  struct Case {
    std::string text;
    std::string place;
    std::string bytes;
  };
  const std::string xml_rest =
      "<image_width>640</image_width>\n<camera_matrix>1 0 0 0 1 0 0 0 1</camera_matrix></opencv_storage>\n";
  const std::string own =
      "alidade_camera: 1\nmodel: pinhole\nimage_size: {width: 640, height: 480}\n"
      "parameters: {fx: 500, fy: 500, cx: 320, cy: 240}\ncreated_by: ";
  const std::vector<Case> cases = {
      {kRosSize + "camera_name: K\xF6ln\n" + kRosMatrix + kRosCoefficients, "file:3", "K\\xF6ln"},
      {own + "\"\xFF\xFE\"\n", "file:5", "\\xFF\\xFE"},
      {own + "\"\xC0\xAF\"\n", "file:5", "\\xC0\\xAF"},           // an overlong form
      {own + "\"\xED\xA0\x80\"\n", "file:5", "\\xED\\xA0\\x80"},  // half of a pair
      {own + "\"\xF4\x90\x80\x80\"\n", "file:5", "\\xF4\\x90"},   // beyond the last character
      {own + "\"\xE2\x82", "file:5", "\\xE2\\x82"},               // cut off
      {"# \xE9t\xE9\n1 PINHOLE 640 480 500 500 320 240\n", "file:1", "\\xE9t\\xE9"},
      {"<?xml version=\"1.0\"?>\n<opencv_storage>\n<camera_name>a&#xD800;b</camera_name>\n" + xml_rest,
       "file:3", "a\\xED\\xA0\\x80b"},
  };
  int num_refused = 0;
  for (const Case& c : cases) {
    const std::string complaint = complaintAbout(c.text);
    EXPECT_THAT(complaint, AllOf(HasSubstr(c.place + ":"), HasSubstr(c.bytes), HasSubstr("UTF-8")));
    for (const char byte : complaint) EXPECT_GE(byte, '\n');
    num_refused += complaint.empty() ? 0 : 1;
  }
  EXPECT_EQ(num_refused, 8);
  const CameraSource good = parseCameras(own + "\"K\u00F6ln \u65E5\u672C \U0001F4F7\"\n", "file");
  EXPECT_EQ(good.cameras.at(0).own->created_by, "K\u00F6ln \u65E5\u672C \U0001F4F7");
}

}  // namespace
}  // namespace alidade
