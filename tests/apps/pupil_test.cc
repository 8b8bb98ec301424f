// SPDX-License-Identifier: MIT
#include <algorithm>
#include <cmath>
#include <numbers>

#include <nlohmann/json.hpp>

#include "alidade/camera/any_camera.h"
#include "alidade/files/camera_source.h"
#include "alidade/files/corners_file.h"
#include "apps/command_line.h"

namespace alidade {
namespace {

using testing::AllOf;
using testing::HasSubstr;
using testing::Not;

std::string wideCamera(const std::string& pupil) {
  return "alidade_camera: 1\nmodel: kannala_brandt\nimage_size: {width: 640, height: 480}\n"
         "parameters: {fx: 260, fy: 260.3, cx: 322, cy: 238, k1: 0.01, k2: -0.004, k3: 0.001, k4: 0}\n" +
         pupil;
}

const std::string kMoving = "pupil: {s1: 0.002}\n";
const std::string kBoard = "checkerboard:8x6:20mm";

// Corners, and a few images, of a board near a wide lens whose pupil moves.
void simulate(const ScratchFolder& scratch, int num_views) {
  scratch.write("camera.yaml", wideCamera(kMoving));
  const std::string scene = scratch.write(
      "scene.yaml", "alidade_scene: 1\ncamera: camera.yaml\nboard: " + kBoard +
                        "\nviews: {random: " + std::to_string(num_views) +
                        "}\nseed: 4\nrandom: {max_tilt_deg: 35, min_fill: 0.25, max_fill: 0.7}\n" +
                        "corner_noise_px: 0.05\n");
  ASSERT_THAT(runAlidade({"simulate", scene, "-o", scratch.path("set")}), EndsWith(0));
}

TEST(Pupil, IsSeenByNearPointsOnly) {
  const ScratchFolder scratch;
  const std::string moving = scratch.write("moving.yaml", wideCamera(kMoving));
  const std::string central = scratch.write("central.yaml", wideCamera(""));
  const auto pixelsOf = [&](const std::string& camera, const std::string& point) {
    const RunResult result = runAlidade({"project", camera}, {.input = point + "\n"});
    EXPECT_THAT(result, EndsWith(0));
    return result.out;
  };
  EXPECT_EQ(pixelsOf(moving, "1e12,0,1e12").substr(0, 20), pixelsOf(central, "1e12,0,1e12").substr(0, 20));
  EXPECT_NE(pixelsOf(moving, "0.2,0,0.2"), pixelsOf(central, "0.2,0,0.2"));
  // 45 degrees off the axis, the ray starts 1.2337 mm along it.
  const double start_m = 0.002 * std::pow(std::numbers::pi / 4, 2);
  EXPECT_EQ(pixelsOf(moving, "0.25,0," + std::to_string(0.25 + start_m)).substr(0, 9),
            pixelsOf(central, "0.25,0,0.25").substr(0, 9));
}

TEST(Pupil, IsCheckedInFiles) {
  const ScratchFolder scratch;
  int num_refused = 0;
  for (const auto& [pupil, complaint] :
       {std::pair("pupil: {s1: 1}\n", "-0.1 to 0.1"), std::pair("pupil: {s1: .nan}\n", "line 5"),
        std::pair("pupil: {s3: 0.001}\n", "s3"), std::pair("pupil: 0.001\n", "line 5"),
        std::pair("pupli: {s1: 0.001}\n", "pupil")}) {
    const RunResult result = runAlidade({"validate", scratch.write("camera.yaml", wideCamera(pupil))});
    EXPECT_THAT(result, EndsWith(3)) << pupil;
    EXPECT_THAT(result.out + result.err, HasSubstr(complaint));
    ++num_refused;
  }
  EXPECT_EQ(num_refused, 5);
}

TEST(Pupil, IsKeptByConversionsOrRefused) {
  const ScratchFolder scratch;
  const std::string from = scratch.write("camera.yaml", wideCamera("pupil: {s1: 0.002, s2: -0.0003}\n"));
  const std::string to = scratch.path("to.yaml");
  for (const std::vector<std::string>& how : std::vector<std::vector<std::string>>{
           {"--resize", "320x240"}, {"--rotate", "90"}, {"--model", "omni", "--max-error", "1"}}) {
    std::vector<std::string> args = {"convert", from, "-o", to};
    args.insert(args.end(), how.begin(), how.end());
    ASSERT_THAT(runAlidade(args), EndsWith(0));
    const EntrancePupil pupil = onlyCamera(parseCameras(scratch.read("to.yaml"), "to.yaml")).camera.pupil();
    EXPECT_EQ(pupil, (EntrancePupil{.s1_m = 0.002, .s2_m = -0.0003}));
    EXPECT_THAT(runAlidade({"validate", to}), EndsWith(0));
  }
  const RunResult refused = runAlidade({"convert", from, "-o", scratch.path("ros.yaml"), "--to", "ros"});
  EXPECT_THAT(refused, EndsWith(1));
  EXPECT_THAT(refused.err, AllOf(HasSubstr("px at 0.3 m"), HasSubstr("--drop-pupil")));
  ASSERT_THAT(runAlidade({"convert", from, "-o", scratch.path("ros.yaml"), "--to", "ros", "--drop-pupil"}),
              EndsWith(0));
  ASSERT_THAT(runAlidade({"convert", from, "-o", to, "--drop-pupil"}), EndsWith(0));
  EXPECT_THAT(scratch.read("to.yaml"), Not(HasSubstr("\npupil")));
}

TEST(Pupil, IsCalibratedValidatedAndReported) {
  const ScratchFolder scratch;
  simulate(scratch, 24);
  const std::string corners = scratch.path("set/corners.csv");
  const std::string found = scratch.path("found.yaml");
  const RunResult result = runAlidade({"calibrate", corners, "--model", "kannala_brandt", "-o", found,
                                       "--report", scratch.path("page.html"), "--json"});
  ASSERT_THAT(result, EndsWith(0));
  const nlohmann::json document = nlohmann::json::parse(result.out);
  const nlohmann::json& pupil = document["entrance_pupil"];
  EXPECT_NEAR(pupil["s1"].get<double>(), 0.002, 4 * pupil["std"][0].get<double>());
  EXPECT_LT(pupil["std"][0].get<double>(), 1e-4);
  EXPECT_EQ(pupil["s2"], 0);
  const CameraRecord record = onlyCamera(parseCameras(scratch.read("found.yaml"), "found.yaml"));
  EXPECT_EQ(record.camera.pupil().s1_m, pupil["s1"].get<double>());
  EXPECT_EQ(record.calibration->pupil_std.size(), 1U);
  EXPECT_THAT(scratch.read("page.html"), AllOf(HasSubstr("Entrance pupil"), HasSubstr("pupil s1, mm")));
  EXPECT_THAT(runAlidade({"calibrate", corners, "--model", "kannala_brandt", "-o", found}).out,
              HasSubstr("Pupil     moves by"));
  // The true camera passes on these images; one whose pupil does not move fails.
  EXPECT_THAT(runAlidade({"validate", scratch.path("camera.yaml"), "--images", corners}), EndsWith(0));
  const std::string central = scratch.write("central.yaml", wideCamera(""));
  EXPECT_THAT(runAlidade({"validate", central, "--images", corners}), EndsWith(3));
  // Other formats have no place for it.
  EXPECT_THAT(
      runAlidade({"calibrate", corners, "-o", scratch.path("ros.yaml"), "--to", "ros", "--pupil", "1"}),
      EndsWith(2));
}

// The rendered images show it as the exact corners do.
TEST(Pupil, IsInRenderedImages) {
  const ScratchFolder scratch;
  simulate(scratch, 3);
  ASSERT_THAT(
      runAlidade({"detect", scratch.path("set/images"), "--board", kBoard, "-o", scratch.path("found.csv")}),
      EndsWith(0));
  const CornersFile exact = readCornersFile(scratch.path("set/corners.csv"));
  const CornersFile found = readCornersFile(scratch.path("found.csv"));
  ASSERT_EQ(found.views.size(), 3U);
  double squares = 0;
  int num_checked = 0;
  for (const View& view : found.views) {
    const auto at = std::ranges::find(exact.views, view.image, &View::image);
    ASSERT_NE(at, exact.views.end());
    for (const Corner& corner : view.corners) {
      const auto truth = std::ranges::find(at->corners, corner.id, &Corner::id);
      if (truth == at->corners.end()) continue;
      squares += (corner.pixel - truth->pixel).squaredNorm();
      ++num_checked;
    }
  }
  EXPECT_GT(num_checked, 100);
  EXPECT_LT(std::sqrt(squares / num_checked), 0.12);  // mostly the noise of the corners file
}

}  // namespace
}  // namespace alidade
