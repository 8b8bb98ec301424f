// SPDX-License-Identifier: MIT
// Camera files of other tools on the command line: every command takes them, and convert hands them on.
#include <gmock/gmock.h>

#include "apps/command_line.h"
#include "apps/scratch_folder.h"

namespace alidade {
namespace {

constexpr const char* kChain = R"(cam0:
  camera_model: pinhole
  distortion_coeffs: [-0.1, 0.02, 0.001, 0.002]
  distortion_model: radtan
  intrinsics: [500.0, 501.0, 320.0, 240.0]
  resolution: [640, 480]
cam1:
  camera_model: pinhole
  distortion_coeffs: [-0.01, 0.02, -0.03, 0.004]
  distortion_model: equidistant
  intrinsics: [300.0, 301.0, 320.0, 240.0]
  resolution: [640, 480]
  T_cn_cnm1: [[1, 0, 0, 0.1], [0, 1, 0, 0], [0, 0, 1, 0], [0, 0, 0, 1]]
)";

std::string project(const std::string& camera) {
  const RunResult run = runAlidade({"project", camera, "-"}, {.input = "x,y,z\n0.3,-0.2,1\n"});
  EXPECT_EQ(run.exit_code, 0) << run.err;
  return run.out;
}

// From Kalibr through all formats that hold the lens, and back to Kalibr.
TEST(Formats, HandACameraOn) {
  const ScratchFolder folder;
  const std::string chain = folder.write("camchain.yaml", kChain);
  const std::string start = project(chain + "#cam1");
  std::string last = chain + "#cam1";
  int num_formats = 0;
  for (const char* format :
       {"alidade", "opencv", "ros", "colmap", "basalt", "nerfstudio", "camodocal", "orbslam", "kalibr"}) {
    const std::string next = folder.path(std::string("camera.") + format);
    const RunResult run = runAlidade({"convert", last, "-o", next, "--to", format});
    ASSERT_EQ(run.exit_code, 0) << run.err;
    EXPECT_THAT(run.err, testing::HasSubstr("written to"));
    EXPECT_EQ(run.err.find("T_cn_cnm1") != std::string::npos, num_formats == 0) << run.err;
    EXPECT_EQ(project(next), start) << format;
    last = next;
    ++num_formats;
  }
  EXPECT_EQ(num_formats, 9);
}

TEST(Formats, HoldAllCamerasOfAChain) {
  const ScratchFolder folder;
  const std::string chain = folder.write("camchain.yaml", kChain);
  const std::string cameras = folder.path("cameras.txt");
  ASSERT_EQ(runAlidade({"convert", chain, "-o", cameras, "--to", "colmap"}).exit_code, 0);
  EXPECT_EQ(project(cameras + "#1"), project(chain + "#cam0"));
  EXPECT_EQ(project(cameras + "#2"), project(chain + "#cam1"));
  const RunResult which = runAlidade({"project", cameras, "-"});
  EXPECT_EQ(which.exit_code, 1);
  EXPECT_THAT(which.err,
              testing::AllOf(testing::HasSubstr("2 cameras: 1, 2"), testing::HasSubstr("cameras.txt#1")));
}

TEST(Formats, RefuseWhatTheyCannotHold) {
  const ScratchFolder folder;
  const std::string chain = folder.write("camchain.yaml", kChain);
  const std::string output = folder.path("camera.cameramodel");
  const RunResult refused = runAlidade({"convert", chain + "#cam1", "-o", output, "--to", "mrcal"});
  EXPECT_EQ(refused.exit_code, 1);
  EXPECT_THAT(refused.err,
              testing::AllOf(testing::HasSubstr("kannala_brandt"), testing::HasSubstr("--model")));
  EXPECT_FALSE(folder.has("camera.cameramodel"));
}

}  // namespace
}  // namespace alidade
