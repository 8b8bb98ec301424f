// SPDX-License-Identifier: MIT
// What is wrong with a file is said with its line, what was found and what was expected.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "alidade/core/error.h"
#include "alidade/files/camera_source.h"
#include "files/formats/examples.h"
#include "files/formats/reading.h"

namespace alidade {
namespace {

const FormatExample& exampleOf(std::string_view format, std::string_view name) {
  for (const FormatExample& example : formatExamples()) {
    if (example.format == format && example.name == name) return example;
  }
  throw std::logic_error("no example " + std::string(name));
}

std::string changed(std::string text, const std::string& from, const std::string& to) {
  const std::size_t at = text.find(from);
  if (at == std::string::npos) throw std::logic_error("the example has no " + from);
  return text.replace(at, from.size(), to);
}

struct Refusal {
  std::string_view format;
  std::string_view name;
  std::string from;
  std::string to;
  std::vector<std::string> message;  // parts of it
};

TEST(FormatRefusals, NamePlaceAndReason) {
  const std::vector<Refusal> refusals = {
      {"opencv", "YAML", "rows: 5", "rows: 4", {"file:16", "5 numbers", "4 x 1"}},
      {"opencv", "YAML", "3.4250000000000000e+02", ".nan", {"file:10", "'.nan'", "a finite number"}},
      {"opencv", "YAML", "e+02, 0., 3.425", "e+02, 0.5, 3.425", {"skew 0.5"}},
      {"opencv",
       "XML",
       "<fisheye_model>1</fisheye_model>",
       "",
       {"file:12", "4 distortion coefficients", "--read-as"}},
      {"opencv", "YAML", "image_width: 640", "image_width: 0", {"file:4", "1 to 1000000"}},
      {"opencv", "YAML", "image_width: 640", "image_width: 640.5", {"file:4", "'640.5'", "a whole number"}},
      {"colmap", "cameras.txt", "2 PINHOLE 640", "2 PINHOLE 640.5", {"file:5", "'640.5'", "a whole number"}},
      {"ros", "camera_info", "plumb_bob", "blumb_bob", {"file:10", "'blumb_bob'", "plumb_bob"}},
      {"ros", "camera_info", "image_width: 640\n", "", {"no key 'image_width'"}},
      {"kalibr",
       "a chain",
       "camera_model: pinhole",
       "camera_model: fisheye",
       {"file:3: cam0.camera_model", "'fisheye'", "eucm with none"}},
      {"kalibr",
       "a chain",
       "distortion_model: radtan",
       "distortion_model: equi",
       {"'equi'", "pinhole with equidistant", "did you mean 'equidistant'?"}},
      {"kalibr",
       "a sensor of EuRoC",
       "pinhole",
       "pinhole_",
       {"file:17: camera_model", "did you mean 'pinhole'?"}},
      {"kalibr",
       "a sensor of EuRoC",
       "rate_hz: 20",
       "distortion_coeffs: [0, 0, 0, 0]",
       {"file:20: distortion_coefficients", "and 'distortion_coeffs'", "remove the other"}},
      {"kalibr",
       "a chain",
       ", 1.76187114e-05]",
       "]",
       {"file:4", "3 numbers", "4 for pinhole-radtan: k1 k2 p1 p2"}},
      {"kalibr",
       "a chain",
       "[458.654, 457.296,",
       "[0.1, 458.654, 457.296,",
       {"file:6", "5 numbers", "fx fy cx cy"}},
      {"kalibr", "a chain", "[458.654", "[.inf", {"file:6", "'.inf'"}},
      {"kalibr", "a chain", "[458.654", "[-458.654", {"file:6", "fx"}},
      {"kalibr", "a chain", "  distortion_model: radtan\n", "", {"no key 'distortion_model'"}},
      {"kalibr", "a chain", "cam1:", "cam0:", {"file:9", "the key 'cam0' twice"}},
      {"colmap",
       "cameras.txt",
       "SIMPLE_RADIAL 640",
       "EQUIRECTANGULAR 640",
       {"file:6", "EQUIRECTANGULAR", "OPENCV_FISHEYE"}},
      {"colmap",
       "cameras.txt",
       "0.001 0.002\n6",
       "0.001\n6",
       {"file:8", "7 parameters", "8 for OPENCV: fx fy cx cy k1 k2 p1 p2"}},
      {"colmap",
       "cameras.txt",
       "PINHOLE 640 480 500 320",
       "PINHOLE 640 480 nan 320",
       {"file:4", "'nan'", "f"}},
      {"colmap", "cameras.txt", "2 PINHOLE 640", "2 PINHOLE 0", {"file:5", "'0'", "pixels"}},
      {"mrcal",
       "a calibration",
       "LENSMODEL_OPENCV8",
       "LENSMODEL_SPLINED_STEREOGRAPHIC_order=3",
       {"file:3: lensmodel", "SPLINED", "mrcal-convert-lensmodel"}},
      {"mrcal", "a calibration", "0.05, 0.006,]", "0.05,]", {"file:6", "11 numbers", "12"}},
      {"basalt", "two cameras", "\"ds\"", "\"sphere\"", {"file:8", "'sphere'", "ds"}},
      {"basalt", "two cameras", ", \"alpha\": 0.56", "", {"file:8", "no key 'alpha'"}},
      {"basalt", "two cameras", "[[752, 480], [640, 480]]", "[[752, 480]]", {"1 sizes", "2"}},
      {"nerfstudio",
       "one camera for all frames",
       "\"OPENCV\"",
       "\"EQUIRECTANGULAR\"",
       {"'EQUIRECTANGULAR'", "OPENCV_FISHEYE"}},
      {"nerfstudio", "one camera for all frames", "\"k4\": 0.0", "\"k4\": 0.1", {"k4 = 0.1", "has no k4"}},
      {"nerfstudio", "one camera for all frames", "\"fl_y\": 501.0,", "", {"no key 'fl_y'"}},
      {"camodocal",
       "MEI",
       "MEI",
       "PINHOLE_FULL",
       {"file:3", "'PINHOLE_FULL'", "PINHOLE, MEI, KANNALA_BRANDT"}},
      {"camodocal", "MEI", "   gamma1: 900.\n", "", {"no key 'gamma1'"}},
      {"orbslam", "two cameras", "Camera1.p2: 1.76187114e-05\n", "", {"no key 'Camera1.p2'"}},
      {"orbslam", "two cameras", "\"PinHole\"", "\"Fisheye\"", {"file:5", "'Fisheye'", "KannalaBrandt8"}},
      {"matlab", "cameraIntrinsics", "\"Skew\":0", "\"Skew\":0.3", {"skew 0.3", "not supported"}},
      {"matlab", "cameraIntrinsics", "[-0.1,0.02]", "[-0.1]", {"1 coefficients", "2 or 3"}},
      {"matlab",
       "stereoParameters",
       "[[500,0,0],[0,501,0],[320,240,1]]",
       "[[500,0,320],[0,501,240],[0,0,1]]",
       {"file:2", "not an IntrinsicMatrix", "cx cy 1"}},
      {"matlab",
       "stereoParameters",
       "\"EstimateSkew\":false",
       "\"MappingCoefficients\":[1,2]",
       {"DistortionCenter"}},
  };
  int num_refused = 0;
  int num_advised = 0;
  for (const Refusal& refusal : refusals) {
    const std::string text = changed(exampleOf(refusal.format, refusal.name).text, refusal.from, refusal.to);
    try {
      const CameraSource source = parseCameras(text, "file");
      // A model that is not supported is the matter of its camera alone.
      if (!source.refused.empty()) throw Error(source.refused.front().reason);
      ADD_FAILURE() << refusal.format << " with " << refusal.to;
    } catch (const Error& error) {
      EXPECT_EQ(error.code(), ErrorCode::kInput);
      EXPECT_THAT(error.what(), testing::StartsWith("file"));
      for (const std::string& part : refusal.message) EXPECT_THAT(error.what(), testing::HasSubstr(part));
      num_advised += std::string(error.what()).find("\n  next: ") != std::string::npos ? 1 : 0;
      ++num_refused;
    }
  }
  EXPECT_EQ(num_refused, 39);
  // Only where what was expected says all, such as a finite number, or a key once.
  EXPECT_EQ(num_refused - num_advised, 7);
}

TEST(FormatRefusals, OfNothingSaySo) {
  int num_files = 0;
  for (const auto& [text, found] :
       {std::pair("", "an empty file"), std::pair(" \n\n", "only spaces and comments"),
        std::pair("# Camera\n# list\n", "only spaces and comments"),
        std::pair("%YAML:1.0\n", "only spaces and comments")}) {
    EXPECT_THAT(complaintAbout(text), testing::AllOf(testing::StartsWith("file: "), testing::HasSubstr(found),
                                                     testing::HasSubstr("next: check the path")));
    ++num_files;
  }
  EXPECT_EQ(num_files, 4);
  EXPECT_THAT(
      complaintAbout("# Camera list with one line of data per camera:\n# Number of cameras: 0\n"),
      testing::AllOf(testing::HasSubstr("file: found only comments"),
                     testing::HasSubstr("ID MODEL WIDTH HEIGHT PARAMS"), testing::HasSubstr("next: ")));
}

TEST(FormatRefusals, AreNoneOfColmapsCutFiles) {
  const std::string start = "# Camera list with one line of data per camera:\n# Number of cameras: ";
  const std::string lines = "\n1 PINHOLE 640 480 500 500 320 240\n2 PINHOLE 640 480 501 501 320 240\n";
  for (const auto& [count, is_told] : {std::pair("3", true), std::pair("2, mean: 1", false),
                                       std::pair("1", true), std::pair("2", false), std::pair("x", false)}) {
    const CameraSource source = parseCameras(start + count + lines, "file");
    ASSERT_EQ(source.cameras.size(), 2u);
    EXPECT_EQ(remarksOn(source.cameras[0]),
              is_told ? "assumed: file:2: the header states " + std::string(count) +
                            " cameras, but the file contains 2; it was read, but it may be truncated\n"
                      : "");
    EXPECT_EQ(remarksOn(source.cameras[1]), "");
  }
}

// What is not refused is said.
TEST(FormatRefusals, SayWhatWasPassedOver) {
  struct Passed {
    std::string_view format;
    std::string_view name;
    std::string from;
    std::string to;
    std::string id;
    std::string part;  // of the message
  };
  const std::vector<Passed> passed = {
      {"kalibr", "a chain", "  cam_overlaps:", "  lens_type: wide\n  cam_overlaps:", "unknown_keys",
       "lens_type"},
      {"mrcal", "the sphere from its pole", "'imagersize'", "'size': 3, 'imagersize'", "unknown_keys",
       "size"},
      {"basalt", "the other lenses", "\"cy\": 240.0}", "\"cy\": 240.0, \"cz\": 1.0}", "unknown_keys", "cz"},
      {"nerfstudio", "one camera for all frames", "\"k4\": 0.0,", "\"k5\": 0.0,", "unknown_keys", "k5"},
      {"camodocal", "MEI", "camera_name: left", "camera_name: left\nserial: 7", "unknown_keys", "serial"},
      {"orbslam", "an older fisheye", "Camera.bf", "Camera.bff", "unknown_keys", "Camera.bff"},
      {"orbslam", "an older fisheye", "Camera.type: \"KannalaBrandt8\"\n", "", "assumed", "PinHole"},
      {"matlab", "cameraIntrinsics", "\"TangentialDistortion\":[0.001,0.002],", "", "assumed",
       "TangentialDistortion"},
      {"basalt", "the other lenses", "\"rpmax\": 0.0", "\"rpmax\": 0.5", "not_carried", "0.5"},
  };
  int num_said = 0;
  for (const Passed& one : passed) {
    std::string text = changed(exampleOf(one.format, one.name).text, one.from, one.to);
    // ORB-SLAM2 knows no fisheye.
    if (one.id == "assumed" && one.format == "orbslam")
      text = changed(changed(text, "Camera.k3: -0.03\nCamera.k4: 0.004\n", ""), "Camera.k2: 0.02",
                     "Camera.k2: 0.02\nCamera.p1: 0\nCamera.p2: 0");
    std::string said;
    for (const StatedCamera& camera : parseCameras(text, "file").cameras) {
      for (const Remark& remark : camera.remarks) said += remark.id + ": " + remark.message + "\n";
    }
    EXPECT_THAT(said, testing::HasSubstr(one.id + ": file")) << one.to;
    EXPECT_THAT(said, testing::HasSubstr(one.part)) << one.to;
    ++num_said;
  }
  EXPECT_EQ(num_said, 9);
}

// A file without a size, as MATLAB's may be, takes it from the user.
TEST(FormatRefusals, LeaveTheSizeToTheUser) {
  const std::string text = changed(exampleOf("matlab", "cameraIntrinsics").text, "[480,640]", "[]");
  EXPECT_FALSE(parseCameras(text, "file").cameras.at(0).image_size);
  const ReadOptions options{.image_size = ImageSize{.width = 640, .height = 480}, .model = ""};
  EXPECT_EQ(parseCameras(text, "file", options).cameras.at(0).image_size, options.image_size);
}

}  // namespace
}  // namespace alidade
