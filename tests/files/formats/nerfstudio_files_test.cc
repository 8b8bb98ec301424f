// SPDX-License-Identifier: MIT
// nerfstudio's and instant-ngp's files: which lens they mean, and what they lack.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "alidade/files/camera_source.h"
#include "files/formats/reading.h"

namespace alidade {
namespace {

using testing::AllOf;
using testing::HasSubstr;

constexpr const char* kNumbers =
    R"("fl_x": 500.0, "fl_y": 501.0, "cx": 320.0, "cy": 240.0, "w": 640, "h": 480)";

std::string file(const std::string& start, const std::string& frames = "[]") {
  return "{" + start + ",\n" + kNumbers + ",\n\"frames\": " + frames + "}";
}

TEST(NerfstudioFiles, WithAFlagAgainstAModelAreRefused) {
  struct Case {
    std::string model;
    std::string flag;
    bool is_fisheye;
    bool is_refused;
  };
  int num_cases = 0;
  for (const Case& one : std::vector<Case>{{"OPENCV", "true", false, true},
                                           {"PINHOLE", "true", false, true},
                                           {"OPENCV_FISHEYE", "false", true, true},
                                           {"OPENCV", "false", false, false},
                                           {"OPENCV_FISHEYE", "true", true, false}}) {
    const std::string text =
        file(R"("is_fisheye": )" + one.flag + ",\n\"camera_model\": \"" + one.model + "\"");
    ++num_cases;
    if (one.is_refused) {
      EXPECT_THAT(complaintAbout(text), AllOf(HasSubstr("file:1: is_fisheye: found '" + one.flag + "'"),
                                              HasSubstr("'" + one.model + "' at file:2: camera_model")));
    } else {
      EXPECT_EQ(parseCameras(text, "file").cameras.at(0).camera.modelId(),
                one.is_fisheye ? "kannala_brandt" : "pinhole");
    }
  }
  EXPECT_EQ(num_cases, 5);
  // One at the top, one in a frame.
  EXPECT_THAT(
      complaintAbout(file(R"("camera_model": "OPENCV")", R"([{"file_path": "a", "is_fisheye": true}])")),
      HasSubstr("file:3: frames[0].is_fisheye: found 'true'"));
}

TEST(NerfstudioFiles, OfOtherLensesAreRefused) {
  for (const std::string key : {"ftheta_p0", "latlong", "equirectangular", "orthographic"}) {
    for (const std::string& text :
         {file("\"" + key + "\": true"),
          file("\"aabb_scale\": 1", R"([{"file_path": "a", ")" + key + R"(": 0.5}])")}) {
      EXPECT_THAT(complaintAbout(text), AllOf(HasSubstr(key + ": found an instant-ngp lens of type"),
                                              HasSubstr("OPENCV_FISHEYE"), HasSubstr("next:")));
    }
  }
  EXPECT_EQ(parseCameras(file("\"latlong\": false"), "file").cameras.at(0).camera.modelId(), "pinhole");
  EXPECT_THAT(complaintAbout(file(R"("camera_model": "opencv")")),
              AllOf(HasSubstr("'opencv'"), HasSubstr("PERSPECTIVE"), HasSubstr("did you mean 'OPENCV'?")));
  EXPECT_THAT(complaintAbout(file(R"("camera_model": "EQUIRECTANGULAR")")),
              AllOf(HasSubstr("one of OPENCV, PINHOLE"), HasSubstr("next:")));
}

TEST(NerfstudioFiles, WithoutAFocalLengthSayWhatIsMissing) {
  EXPECT_THAT(
      complaintAbout(R"({"camera_model": "OPENCV", "frames": []})"),
      AllOf(HasSubstr("file:1: found no key 'fl_x'"), HasSubstr("or in each frame"), HasSubstr("next:")));
  EXPECT_THAT(complaintAbout("{\"camera_model\": \"OPENCV\",\n\"fx\": 500.0, \"fy\": 501.0, \"frames\": []}"),
              AllOf(HasSubstr("file:2: fx: found 'fx' but no 'fl_x'"), HasSubstr("rename it")));
  EXPECT_THAT(complaintAbout("{\"frames\": [\n{\"file_path\": \"a\"}]}"),
              AllOf(HasSubstr("file:2: frames[0]: found no key 'fl_x'"), HasSubstr("next:")));
}

}  // namespace
}  // namespace alidade
