// SPDX-License-Identifier: MIT
// Rigs from videos that start at different times, and mirrored videos.
#include <cmath>
#include <cstdlib>

#include <nlohmann/json.hpp>

#include "alidade/files/rig_file.h"
#include "alidade/print/ink_of_board.h"
#include "alidade/simulate/render.h"
#include "alidade/target/board_spec.h"
#include "apps/command_line.h"
#include "imagery/video_files.h"

namespace alidade {
namespace {

using nlohmann::json;
using testing::AllOf;
using testing::HasSubstr;
using testing::Not;

constexpr const char* kBoard = "charuco:5x4:70mm:52mm:DICT_4X4_50";
constexpr double kRate = 30;  // of the files, in frames a second
constexpr int kLead = 7;      // frames by which the second recording started later

// Two cameras, turned towards each other, before which a board is waved.
struct Recordings {
  ScratchFolder scratch;
  std::string left = scratch.path("left.avi");
  std::string right = scratch.path("right.avi");
  std::string mirrored = scratch.path("mirrored.avi");

  Recordings() {
    std::vector<cv::Mat> flipped;
    const std::vector<cv::Mat> seen_right = recorded({SO3::exp({0, 0.3, 0}), {-0.25, 0, 0.05}}, kLead);
    writeVideo(left, recorded(SE3(), 0));
    writeVideo(right, seen_right);
    for (const cv::Mat& frame : seen_right) cv::flip(frame, flipped.emplace_back(), 1);
    writeVideo(mirrored, flipped);
  }

  static std::vector<cv::Mat> recorded(const SE3& camera_from_rig, int first) {
    constexpr int kNumFrames = 150;
    const Board board = parseBoardSpec(kBoard);
    const BoardInk ink = inkOf(board);
    const Renderer renderer(
        AnyCamera::make("radtan", std::vector<double>{380, 380, 239.5, 179.5, -0.2, 0.05, 0, 0, 0}),
        {480, 360});
    RenderOptions light;
    light.blur_px = 0.7;
    light.read_noise = 1;
    light.samples = 32;
    std::vector<cv::Mat> frames;
    for (int frame = 0; frame < kNumFrames; ++frame) {
      const double t = (frame + first) / kRate;
      const SE3 waved = {
          SO3::exp({0.4 * std::sin(1.9 * t), 0.4 * std::sin(2.3 * t + 1), 0.5 * std::sin(1.3 * t)}),
          {0.1 + 0.12 * std::sin(1.7 * t), 0.08 * std::sin(2.6 * t), 0.75 + 0.12 * std::sin(1.1 * t)}};
      light.seed = static_cast<std::uint64_t>(frame);
      const GrayImage image =
          renderer.render(ink, camera_from_rig * waved * SE3{SO3(), -board.middle()}, light);
      frames.push_back(
          cv::Mat(image.size.height, image.size.width, CV_8U, const_cast<std::uint8_t*>(image.pixels.data()))
              .clone());
    }
    return frames;
  }
};

const Recordings& recordings() {
  static const Recordings made;
  return made;
}

// By a frame that is not read of both.
TEST(RigVideos, AreAlignedByTheMotion) {
  const std::string rig = recordings().scratch.path("rig.yaml");
  const RunResult result =
      runAlidade({"rig", "calibrate", recordings().left, recordings().right, "--board", kBoard, "--model",
                  "radtan", "--json", "--keep-untrustworthy", "-o", rig});
  const json document = json::parse(result.out);
  ASSERT_TRUE(document.contains("cameras")) << result.out << result.err;
  EXPECT_EQ(document.at("cameras").at(0).at("lead").get<double>() -
                document.at("cameras").at(1).at("lead").get<double>(),
            kLead);
  // Frames taken together are read.
  const double delay = document.at("cameras").at(1).value("delay_intervals", 0.0);
  EXPECT_LT(std::abs(delay), 0.05);
  EXPECT_THAT(result.err, HasSubstr("the videos start at different times"));
  EXPECT_NEAR(loadRig(rig).cameras.at(1).time_offset_s.value_or(0), kLead / kRate, 1e-3);
  const RunResult tested =
      runAlidade({"rig", "validate", rig, recordings().left, recordings().right, "--board", kBoard});
  EXPECT_THAT(tested, EndsWith(0));
  EXPECT_THAT(tested.out, HasSubstr("start at different times"));
}

TEST(RigVideos, KeepTheirMirrorsWhenTheyAreSorted) {
  const ScratchFolder& scratch = recordings().scratch;
  const std::string rig = scratch.path("flipped.yaml");
  ASSERT_EQ(runAlidade({"rig", "calibrate", recordings().left, recordings().mirrored, "--board", kBoard,
                        "--model", "radtan", "--mirrored", "-,image", "--keep-untrustworthy", "-o", rig})
                .out.find("error"),
            std::string::npos);
  const RunResult sorted = runAlidade({"rig", "validate", rig, recordings().mirrored, recordings().left,
                                       "--board", kBoard, "--mirrored", "image,-"});
  EXPECT_THAT(sorted, EndsWith(0));
  EXPECT_THAT(sorted.err, HasSubstr("assigned to the cameras by their names"));
  EXPECT_THAT(runAlidade({"rig", "validate", rig, recordings().left, recordings().mirrored, "--footage",
                          "--mirrored", "image"}),
              FailsWith(2, HasSubstr("--mirrored with --footage")));
}

TEST(RigVideos, OfACameraInMirrorModeAreFlippedBackOnRequest) {
  const std::vector<std::string> command = {"rig",     "calibrate", recordings().left, recordings().mirrored,
                                            "--board", kBoard,      "--model",         "radtan"};
  std::vector<std::string> flipped = command;
  flipped.insert(flipped.end(), {"--mirrored", "-,image", "--json", "--keep-untrustworthy"});
  const json document = json::parse(runAlidade(flipped).out);
  ASSERT_TRUE(document.contains("cameras")) << document;
  EXPECT_NEAR(document.at("cameras").at(1).at("distance_std_m").get<double>(), 0, 0.01);
  const auto& shift = document.at("cameras").at(1).at("camera_from_rig").at("translation_m");
  EXPECT_NEAR(shift.at(0).get<double>(), -0.25, 0.01);
  const RunResult alone = runAlidade({"calibrate", recordings().mirrored, "--board", kBoard, "--model",
                                      "radtan", "--keep-untrustworthy", "--verbose"});
  EXPECT_THAT(alone.out, AllOf(HasSubstr("all views are mirrored"), HasSubstr("--mirrored image")));
  EXPECT_THAT(runAlidade({"calibrate", recordings().mirrored, "--board", kBoard, "--model", "radtan",
                          "--mirrored", "image", "--keep-untrustworthy", "--verbose"})
                  .out,
              Not(HasSubstr("views are mirrored")));
  // Flipped although it is not mirrored.
  EXPECT_THAT(runAlidade({"calibrate", recordings().left, "--board", kBoard, "--model", "radtan",
                          "--mirrored", "image", "--keep-untrustworthy", "--verbose"})
                  .out,
              AllOf(HasSubstr("all views are mirrored: they are, after the images were flipped"),
                    HasSubstr("leave out --mirrored image")));
  EXPECT_THAT(runAlidade({"calibrate", recordings().mirrored, "--board", kBoard, "--model", "radtan",
                          "--mirrored", "back", "--keep-untrustworthy", "--verbose"})
                  .out,
              HasSubstr("Note     all views are mirrored"));
}

}  // namespace
}  // namespace alidade
