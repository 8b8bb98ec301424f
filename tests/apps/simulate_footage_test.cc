// SPDX-License-Identifier: MIT
#include <sstream>

#include <nlohmann/json.hpp>

#include "alidade/files/camera_source.h"
#include "alidade/files/pose_list.h"
#include "alidade/imagery/image_file.h"
#include "apps/command_line.h"

namespace alidade {
namespace {

using testing::AllOf;
using testing::HasSubstr;

std::string footageScene(const std::string& footage) {
  return "alidade_scene: 1\n"
         "camera: {model: radtan, image_size: {width: 96, height: 72},\n"
         "         parameters: {fx: 80, fy: 80, cx: 47.5, cy: 35.5, k1: -0.2, k2: 0.03, p1: 0, p2: 0, k3: "
         "0}}\n"
         "footage: " +
         footage +
         "\n"
         "seed: 3\n"
         "render: {blur_px: 0.5, read_noise: 2}\n";
}

struct TrackRow {
  int track = 0;
  int frame = 0;
  int moving = 0;
  Eigen::Vector2d pixel;
  Eigen::Vector3d point;
};

std::vector<TrackRow> tracksIn(const std::string& text) {
  std::istringstream lines(text);
  std::vector<TrackRow> rows;
  for (std::string line; std::getline(lines, line);) {
    if (line.empty() || !std::isdigit(static_cast<unsigned char>(line.front()))) continue;
    std::ranges::replace(line, ',', ' ');
    std::istringstream fields(line);
    TrackRow row;
    fields >> row.track >> row.frame >> row.pixel.x() >> row.pixel.y() >> row.moving >> row.point.x() >>
        row.point.y() >> row.point.z();
    EXPECT_TRUE(fields) << line;
    rows.push_back(row);
  }
  return rows;
}

TEST(SimulateFootage, WritesATruthThatAgreesWithItself) {
  const ScratchFolder scratch;
  const std::string scene =
      scratch.write("scene.yaml", footageScene("{frames: 4, flow_px: 2, moving_objects: 3}"));
  const RunResult run = runAlidade({"simulate", scene, "--json", "-o", scratch.path("out")});
  ASSERT_THAT(run, EndsWith(0));
  const auto document = nlohmann::json::parse(run.out);
  EXPECT_EQ(document.at("num_frames"), 4);

  const auto rows = tracksIn(scratch.read("out/tracks.csv"));
  EXPECT_EQ(document.at("num_pixels"), rows.size());
  EXPECT_GT(rows.size(), 4U * 16U * 12U * 9U / 10U);
  const CameraRecord camera = loadCamera(scratch.path("out/camera.yaml"));
  const PoseList poses = readPoseList(scratch.path("out/poses.yaml"));
  const PoseList trajectory = readPoseList(scratch.path("out/trajectory.txt"));
  ASSERT_EQ(poses.poses.size(), 4U);
  ASSERT_EQ(trajectory.poses.size(), 4U);
  EXPECT_EQ(poses.poses[3].id, "frame_00003.png");
  int num_moving = 0;
  for (const TrackRow& row : rows) {
    const auto frame = static_cast<std::size_t>(row.frame);
    for (const PoseList* list : {&poses, &trajectory}) {
      const Projection p = camera.camera.project(list->poses.at(frame).camera_from_x * row.point);
      ASSERT_TRUE(p.ok());
      EXPECT_LT((p.pixel - row.pixel).norm(), 1e-7);
    }
    num_moving += row.moving;
  }
  EXPECT_GT(num_moving, 0);
  EXPECT_LT(num_moving, static_cast<int>(rows.size()));
  for (const std::string name : {"frame_00000", "frame_00001", "frame_00002", "frame_00003"}) {
    const GrayImage image = readGrayImage(scratch.path("out/images/" + name + ".png")).image;
    EXPECT_EQ(image.size, (ImageSize{96, 72})) << name;
  }
}

TEST(SimulateFootage, MakesTheSameBytesForAnyNumberOfThreads) {
  const ScratchFolder scratch;
  const std::string scene = scratch.write(
      "scene.yaml",
      footageScene("{surroundings: plane, path: rotation, frames: 2, rolling_shutter: 0.5, zoom: 1.1,\n"
                   "          stabilisation_frames: 3, shake_px: 1}"));
  ASSERT_THAT(runAlidade({"simulate", scene, "-o", scratch.path("one"), "--jobs", "1"}), EndsWith(0));
  ASSERT_THAT(runAlidade({"simulate", scene, "-o", scratch.path("two"), "--jobs", "2"}), EndsWith(0));
  int num_same = 0;
  for (const std::string name : {"camera.yaml", "tracks.csv", "poses.yaml", "trajectory.txt",
                                 "images/frame_00000.png", "images/frame_00001.png"}) {
    ASSERT_TRUE(scratch.has("one/" + name)) << name;
    EXPECT_EQ(scratch.read("one/" + name), scratch.read("two/" + name)) << name;
    ++num_same;
  }
  EXPECT_EQ(num_same, 6);
  // The truth alone is the same.
  const RunResult run = runAlidade({"simulate", scene, "-o", scratch.path("truth"), "--truth-only"});
  ASSERT_THAT(run, EndsWith(0));
  EXPECT_THAT(run.out, AllOf(HasSubstr("2 frames"), HasSubstr("no images")));
  EXPECT_FALSE(scratch.has("truth/images"));
  EXPECT_EQ(scratch.read("truth/tracks.csv"), scratch.read("one/tracks.csv"));
  // And replaces only what simulate made.
  EXPECT_THAT(runAlidade({"simulate", scene, "-o", scratch.path("truth"), "--truth-only"}),
              FailsWith(1, HasSubstr("--overwrite")));
  EXPECT_THAT(runAlidade({"simulate", scene, "-o", scratch.path("truth"), "--truth-only", "--overwrite"}),
              EndsWith(0));
}

TEST(SimulateFootage, NamesTheKeyThatIsWrong) {
  const ScratchFolder scratch;
  const auto complaint = [&](const std::string& footage) {
    const std::string scene = scratch.write("scene.yaml", footageScene(footage));
    return runAlidade({"simulate", scene, "-o", scratch.path("out")});
  };
  EXPECT_THAT(complaint("{path: drive}"),
              FailsWith(1, AllOf(HasSubstr("scene.yaml:4: footage.path"),
                                 HasSubstr("walk, rotation, static or straight"))));
  EXPECT_THAT(complaint("{surroundings: forest}"),
              FailsWith(1, AllOf(HasSubstr("footage.surroundings"), HasSubstr("room, plane or far"))));
  EXPECT_THAT(complaint("{frames: 0}"), FailsWith(1, AllOf(HasSubstr("scene.yaml:4"), HasSubstr("frames"))));
  EXPECT_THAT(complaint("{flow: 3}"), FailsWith(1, HasSubstr("flow_px")));
  EXPECT_THAT(complaint("{moving_share: 0.5}"), FailsWith(1, HasSubstr("moving_share")));
  EXPECT_THAT(complaint("{path: straight, surroundings: far}"), FailsWith(1, HasSubstr("straight")));
  EXPECT_THAT(complaint("{moving_objects: 1, moving_share: 0.9}"),
              FailsWith(1, AllOf(HasSubstr("scene.yaml: footage"), HasSubstr("raise moving_objects"))));
  EXPECT_THAT(complaint("{}\nboard: checkerboard:4x3:30mm"), FailsWith(1, HasSubstr("board")));
  EXPECT_FALSE(scratch.has("out"));
}

}  // namespace
}  // namespace alidade
