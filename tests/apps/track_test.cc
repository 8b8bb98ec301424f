// SPDX-License-Identifier: MIT
// The path of a camera in a video.
#include <algorithm>
#include <chrono>
#include <cmath>
#include <csignal>
#include <filesystem>
#include <sstream>

#include <opencv2/imgcodecs.hpp>

#include <fmt/format.h>
#include <Eigen/Geometry>
#include <nlohmann/json.hpp>

#include "alidade/files/pose_list.h"
#include "apps/command_line.h"
#include "imagery/video_files.h"
#include "support/simulated_video.h"

namespace alidade {
namespace {

using testing::AllOf;
using testing::HasSubstr;
using testing::Not;

constexpr ImageSize kRoomSize{320, 240};

// The camera of camera.yaml, at a walk unless another path is named.
FootageSimulator footageOf(int num_frames, FootagePath path = FootagePath::kWalk) {
  return FootageSimulator({.camera = AnyCamera::make("pinhole", std::vector<double>{200, 200, 159.5, 119.5}),
                           .image_size = kRoomSize,
                           .path = path,
                           .num_frames = num_frames});
}

// A walk that is rendered once.
struct Walk {
  FootageSimulator footage = footageOf(84);
  std::vector<cv::Mat> frames = simulatedFrames(footage);
  std::vector<SE3> poses = simulatedPoses(footage);
};
const Walk& walk() {
  static const Walk one;
  return one;
}

// Its first frames, as copies.
std::vector<cv::Mat> walkFrames(std::size_t num_frames) {
  std::vector<cv::Mat> frames;
  for (std::size_t i = 0; i < num_frames; ++i) frames.push_back(walk().frames[i].clone());
  return frames;
}
std::vector<SE3> walkPoses(std::size_t num_frames) {
  return {walk().poses.begin(), walk().poses.begin() + static_cast<std::ptrdiff_t>(num_frames)};
}

// A folder with a camera file, in which the command runs.
class TrackTest : public testing::Test {
 protected:
  void SetUp() override {
    scratch_.write("camera.yaml",
                   "alidade_camera: 1\nmodel: pinhole\nimage_size: {width: 320, height: 240}\n"
                   "parameters: {fx: 200, fy: 200, cx: 159.5, cy: 119.5}\n");
  }

  [[nodiscard]] RunResult track(const std::string& input, std::vector<std::string> more = {}) const {
    std::vector<std::string> args = {"track", input, "--camera", "camera.yaml", "-o", "trajectory.txt"};
    args.insert(args.end(), more.begin(), more.end());
    return runAlidade(args, {.folder = scratch_.path()});
  }

  std::string video(const std::string& name, const std::vector<cv::Mat>& frames) const {
    writeVideo(scratch_.path(name), frames);
    return name;
  }

  [[nodiscard]] bool hasOutput() const { return scratch_.has("trajectory.txt"); }

  ScratchFolder scratch_;
};

// The RMS distance from the true path after a similarity, as a share of its length.
double trajectoryError(const PoseList& list, const std::vector<SE3>& poses) {
  Eigen::Matrix3Xd found(3, static_cast<Eigen::Index>(list.poses.size()));
  Eigen::Matrix3Xd truth = found;
  double length = 0;
  for (Eigen::Index i = 0; i < found.cols(); ++i) {
    found.col(i) = list.poses[static_cast<std::size_t>(i)].camera_from_x.inverse().translation;
    truth.col(i) = poses[static_cast<std::size_t>(i)].inverse().translation;
    if (i > 0) length += (truth.col(i) - truth.col(i - 1)).norm();
  }
  const Eigen::Matrix4d similarity = Eigen::umeyama(found, truth, true);
  const Eigen::Matrix3Xd moved = similarity.topRows<3>() * found.colwise().homogeneous();
  return std::sqrt((moved - truth).squaredNorm() / static_cast<double>(found.cols())) / length;
}

constexpr double kMostPathShare = 0.02;

TEST_F(TrackTest, WritesTheTrajectoryOfAVideo) {
  const auto poses = walkPoses(50);
  const RunResult result = track(video("walk.avi", walkFrames(50)), {"--map", "points.ply"});
  ASSERT_THAT(result, EndsWith(0));
  EXPECT_THAT(result.out, AllOf(HasSubstr("poses of 50 of 50 frames"), HasSubstr("the scale is arbitrary"),
                                HasSubstr("reprojection RMS"), Not(HasSubstr("Lost"))));
  std::istringstream lines(result.out);
  std::size_t num_lines = 0;
  for (std::string line; std::getline(lines, line); ++num_lines) EXPECT_LE(line.size(), 100u);
  EXPECT_LE(num_lines, 16u);

  const std::string text = scratch_.read("trajectory.txt");
  EXPECT_THAT(text, AllOf(HasSubstr("the scale is arbitrary"), HasSubstr("# piece 1 of 1: frames 0 to 49"),
                          HasSubstr("# timestamps are seconds")));
  const PoseList list = parsePoseList(text, "trajectory.txt");
  ASSERT_EQ(list.poses.size(), poses.size());
  EXPECT_EQ(list.poses[15].id, "0.5");  // 30 frames a second
  EXPECT_LT(trajectoryError(list, poses), kMostPathShare);

  // The points lie on the walls.
  const std::string ply = scratch_.read("points.ply");
  EXPECT_THAT(ply, AllOf(HasSubstr("ply\nformat ascii 1.0\n"), HasSubstr("comment the scale is arbitrary"),
                         HasSubstr("property int piece\nend_header\n")));
  const auto num_rows =
      std::count(ply.begin() + static_cast<std::ptrdiff_t>(ply.find("end_header")), ply.end(), '\n') - 1;
  EXPECT_GT(num_rows, 100);
  EXPECT_THAT(ply, HasSubstr(fmt::format("element vertex {}\n", num_rows)));
}

TEST_F(TrackTest, TakesPhotographsByTheirKeyPoints) {
  std::vector<SE3> few;
  std::vector<cv::Mat> pictures;
  const auto poses = walkPoses(40);
  const auto frames = walkFrames(40);
  for (std::size_t i = 0; i < frames.size(); i += 5) {
    few.push_back(poses[i]);
    pictures.push_back(frames[i]);
  }
  scratch_.makeFolder("photos");
  for (std::size_t i = 0; i < pictures.size(); ++i)
    cv::imwrite(scratch_.path(fmt::format("photos/{}.png", i)), pictures[i]);
  const RunResult result = track("photos", {"--json"});
  ASSERT_THAT(result, EndsWith(0));
  const auto answer = nlohmann::json::parse(result.out);
  EXPECT_EQ(answer.at("front_end"), "keypoints");
  EXPECT_EQ(answer.at("timestamps"), "frame_number");
  EXPECT_EQ(answer.at("num_posed"), few.size());
  EXPECT_EQ(answer.at("pieces").size(), 1u);
  EXPECT_EQ(answer.at("obstacle"), "none");
  const PoseList list = parsePoseList(scratch_.read("trajectory.txt"), "trajectory.txt");
  ASSERT_EQ(list.poses.size(), few.size());
  EXPECT_LT(trajectoryError(list, few), kMostPathShare);
}

TEST_F(TrackTest, ReadsItsFlagsFromASettingsFile) {
  const std::string clip = video("walk.avi", walkFrames(50));
  scratch_.write("settings.yaml",
                 "camera: camera.yaml\noutput: path.txt\nfront-end: flow\nmap: points.ply\nquiet: true\n");
  const RunResult result =
      runAlidade({"track", clip, "--config", "settings.yaml"}, {.folder = scratch_.path()});
  ASSERT_THAT(result, EndsWith(0));
  EXPECT_EQ(result.out + result.err, "");
  EXPECT_TRUE(scratch_.has("path.txt"));
  EXPECT_TRUE(scratch_.has("points.ply"));
  const RunResult printed =
      runAlidade({"track", clip, "--camera", "camera.yaml", "-o", "-"}, {.folder = scratch_.path()});
  ASSERT_THAT(printed, EndsWith(0));
  EXPECT_EQ(printed.out, scratch_.read("path.txt"));
}

// Dark frames in between, after which nothing is known any more.
TEST_F(TrackTest, TellsWhereThePathBreaks) {
  auto frames = walkFrames(84);
  for (std::size_t f = 50; f < 54; ++f) frames[f].setTo(0);
  const RunResult result = track(video("walk.avi", frames));
  EXPECT_THAT(result, EndsWith(3));
  EXPECT_THAT(result.out, AllOf(HasSubstr("in 2 pieces"), HasSubstr("no pose: frames 50 to 53")));
  EXPECT_THAT(result.err, AllOf(HasSubstr("error: walk.avi: the path is in 2 pieces"), HasSubstr("next: ")));
  const std::string text = scratch_.read("trajectory.txt");
  const std::size_t second = text.find("# piece 2 of 2: frames 54 to 83");
  ASSERT_NE(second, std::string::npos);
  EXPECT_LT(text.find("\n1.6 "), second);
  EXPECT_GT(text.find("\n1.8 "), second);
  EXPECT_EQ(parsePoseList(text, "trajectory.txt").poses.size(), 80u);
}

TEST_F(TrackTest, SaysWhyThereIsNoPath) {
  const auto turning = simulatedFrames(footageOf(30, FootagePath::kRotation));
  const std::vector<cv::Mat> still(20, turning.front());
  const std::vector<cv::Mat> black(20, cv::Mat::zeros(kRoomSize.height, kRoomSize.width, CV_8U));
  const std::vector<cv::Mat> pair = {turning[0], turning[0]};
  struct Case {
    std::vector<cv::Mat> frames;
    const char* obstacle;
    const char* message;
  };
  const std::vector<Case> cases = {{turning, "rotation", "the camera only turns in place"},
                                   {still, "still", "nothing moves"},
                                   {black, "few_points", "too few points"},
                                   {pair, "still", "nothing moves"}};
  int num_cases = 0;
  for (const Case& c : cases) {
    SCOPED_TRACE(c.message);
    const std::string clip = video(fmt::format("clip{}.avi", num_cases), c.frames);
    EXPECT_THAT(track(clip),
                FailsWith(3, AllOf(HasSubstr("no path can be found"), HasSubstr(c.message),
                                   HasSubstr("trajectory.txt was not written"), HasSubstr("next: "))));
    const RunResult with_json = track(clip, {"--json"});
    EXPECT_THAT(with_json, EndsWith(3));
    const auto answer = nlohmann::json::parse(with_json.out);
    EXPECT_EQ(answer.at("obstacle"), c.obstacle);
    EXPECT_TRUE(answer.at("trajectory").is_null());
    EXPECT_FALSE(hasOutput());
    ++num_cases;
  }
  EXPECT_EQ(num_cases, 4);
  // An older result is told from one of this run.
  scratch_.write("trajectory.txt", "old");
  EXPECT_THAT(track("clip1.avi").err, HasSubstr("the file of that name is an older one"));
  EXPECT_EQ(scratch_.read("trajectory.txt"), "old");
}

TEST_F(TrackTest, ComplainsAboutItsInputs) {
  const auto frames = walkFrames(12);
  const std::string clip = video("walk.avi", frames);
  const std::string whole = scratch_.read("walk.avi");
  scratch_.write("cut.avi", whole.substr(0, whole.size() / 2));
  scratch_.write("text.mp4", "no video");
  video("one.avi", {frames.front()});
  std::vector<cv::Mat> small(12);
  for (std::size_t i = 0; i < small.size(); ++i) cv::resize(frames[i], small[i], {160, 120});
  video("small.avi", small);
  struct Case {
    const char* input;
    std::vector<const char*> parts;
  };
  const std::vector<Case> cases = {
      {"cut.avi", {"cut.avi", "ends early"}},
      {"text.mp4", {"text.mp4", "cannot be opened"}},
      {"missing.mp4", {"no such file"}},
      {"one.avi", {"one.avi: 1 frame", "at least 2"}},
      {"small.avi", {"160x120", "320x240", "alidade convert --resize"}},
  };
  int num_cases = 0;
  for (const Case& c : cases) {
    const RunResult result = track(c.input);
    for (const char* part : c.parts) EXPECT_THAT(result, FailsWith(1, HasSubstr(part))) << c.input;
    EXPECT_FALSE(hasOutput()) << c.input;
    ++num_cases;
  }
  EXPECT_EQ(num_cases, 5);
  EXPECT_THAT(track(clip, {"--front-end", "magic"}), FailsWith(2, HasSubstr("one of flow, keypoints")));
  EXPECT_THAT(track(clip, {"--map", "trajectory.txt"}), FailsWith(2, HasSubstr("the same file as --output")));
  EXPECT_THAT(track(clip, {"--map", clip}), FailsWith(2, HasSubstr("this is also an input")));
  const std::vector<std::string> line = {"track", clip, "--camera", "camera.yaml"};
  EXPECT_THAT(runAlidade(line, {.folder = scratch_.path()}), FailsWith(2, HasSubstr("no --output")));
  EXPECT_THAT(runAlidade({"track", clip, "-o", "x.txt"}, {.folder = scratch_.path()}),
              FailsWith(2, HasSubstr("no --camera")));
  EXPECT_THAT(runAlidade({"track"}), FailsWith(2, HasSubstr("no footage")));
}

// As a phone writes it that was held upright: a matrix in the header, the pixels as the sensor gave them.
TEST_F(TrackTest, TakesTheStoredPixelsOfAVideoThatIsShownRotated) {
  const std::string clip = video("walk.mp4", walkFrames(50));
  std::string bytes = scratch_.read(clip);
  const std::size_t header = bytes.find("tkhd");
  ASSERT_NE(header, std::string::npos);
  constexpr std::size_t kMatrixOffset = 4 + 40;  // behind the name
  const std::string quarter_turn = {0,      0,      0, 0, 0, 1, 0, 0, 0, 0, 0, 0,
                                    '\xff', '\xff', 0, 0, 0, 0, 0, 0, 0, 0, 0, 0};
  bytes.replace(header + kMatrixOffset, quarter_turn.size(), quarter_turn);
  scratch_.write("turned.mp4", bytes);
  ASSERT_THAT(track(clip), EndsWith(0));
  const std::string plain = scratch_.read("trajectory.txt");
  const RunResult result = track("turned.mp4");
  ASSERT_THAT(result, EndsWith(0));
  EXPECT_THAT(result.err, HasSubstr("note: turned.mp4: players show the video rotated 90 degrees clockwise"));
  EXPECT_EQ(scratch_.read("trajectory.txt"), plain);
}

TEST_F(TrackTest, LeavesNothingWhereItIsInterrupted) {
  const auto frames = walkFrames(50);
  std::vector<cv::Mat> many;
  while (many.size() < 3000) many.insert(many.end(), frames.begin(), frames.end());
  video("long.avi", many);
  RunningProgram program(alidadeProgram(),
                         {"track", "long.avi", "--camera", "camera.yaml", "-o", "trajectory.txt"},
                         {.folder = scratch_.path(), .time_limit = std::chrono::seconds(60)});
  ASSERT_TRUE(program.waitUntilItCatches(SIGINT));
  program.sendSignal(SIGINT);
  const RunResult result = program.wait();
  EXPECT_EQ(result.signal, SIGINT);
  EXPECT_EQ(result.err, "interrupted; no result was written\n");
  EXPECT_FALSE(hasOutput());
}

}  // namespace
}  // namespace alidade
