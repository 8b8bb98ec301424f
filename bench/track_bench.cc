// SPDX-License-Identifier: MIT
// Visual odometry of a rendered video, from the file to the path, compared with OpenCV's two-view functions
// on the same tracks. One thread.
#include <unistd.h>

#include <array>
#include <cmath>
#include <cstdio>
#include <ctime>
#include <filesystem>
#include <string>
#include <vector>

#include <opencv2/calib3d.hpp>

#include "alidade/footage/follow/footage_frames.h"
#include "alidade/footage/map/odometry.h"
#include "footage/walk_tracks.h"
#include "imagery/video_files.h"
#include "support/simulated_video.h"

namespace alidade {
namespace {

constexpr int kNumFrames = 150;
constexpr double kFocalPx = 400;

double cpuSeconds() {
  timespec t{};
  clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &t);
  return static_cast<double>(t.tv_sec) + 1e-9 * static_cast<double>(t.tv_nsec);
}

void printRow(const char* what, double seconds, double error_share) {
  std::printf("%-44s %7.0f frames/s  %6.2f ms a frame", what, kNumFrames / seconds,
              1e3 * seconds / kNumFrames);
  if (error_share > 0) std::printf("  error %.3f %% of the way", 100 * error_share);
  std::printf("\n");
}

std::vector<cv::Point2d> pixelsOf(const std::vector<TrackPixel>& frame, const auto& indices, bool is_first) {
  std::vector<cv::Point2d> pixels;
  for (const auto& [i, j] : indices) {
    const Eigen::Vector2d& at = frame[is_first ? i : j].pixel;
    pixels.emplace_back(at.x(), at.y());
  }
  return pixels;
}

// Each step relative to the previous frame. Two views do not determine the length of a step, so the true one
// is given.
Path openCvPath(const FootageTracks& tracks, const std::vector<SE3>& poses) {
  const cv::Matx33d K(kFocalPx, 0, 319.5, 0, kFocalPx, 239.5, 0, 0, 1);
  Path path;
  SE3 at = poses.front();
  path.frames.push_back({.number = 0, .segment = 0, .camera_from_world = at});
  for (std::size_t f = 1; f < tracks.frames.size(); ++f) {
    const auto common = commonTracks(tracks.frames[f - 1], tracks.frames[f]);
    const auto a = pixelsOf(tracks.frames[f - 1], common, true);
    const auto b = pixelsOf(tracks.frames[f], common, false);
    cv::Mat mask;
    const cv::Mat E = cv::findEssentialMat(a, b, K, cv::RANSAC, 0.999, 1.0, mask);
    cv::Matx33d R;
    cv::Vec3d t;
    cv::recoverPose(E, a, b, K, R, t, mask);
    Eigen::Matrix3d turn;
    for (int i = 0; i < 9; ++i) turn(i / 3, i % 3) = R(i / 3, i % 3);
    const double length = (poses[f] * poses[f - 1].inverse()).translation.norm();
    SE3 step;
    step.rotation = SO3::fromQuaternion(Eigen::Quaterniond(turn));
    step.translation = length * Eigen::Vector3d(t[0], t[1], t[2]);
    at = step * at;
    path.frames.push_back({.number = f, .segment = 0, .camera_from_world = at});
  }
  return path;
}

int run() {
  const AnyCamera camera = AnyCamera::make("pinhole", std::vector<double>{kFocalPx, kFocalPx, 319.5, 239.5});
  const FootageSimulator footage(
      {.camera = camera, .image_size = testing::kFootageSize, .num_frames = kNumFrames});
  const std::vector<SE3> poses = simulatedPoses(footage);
  const std::string video =
      (std::filesystem::temp_directory_path() / ("track_bench_" + std::to_string(::getpid()) + ".avi"))
          .string();
  writeVideo(video, simulatedFrames(footage));

  const std::array<std::string, 1> inputs = {video};
  double start = cpuSeconds();
  forEachFrame(inputs, [](const FootageImage&) {});
  const double decoding = cpuSeconds() - start;

  FootageTracks tracks{.size = testing::kFootageSize, .is_video = true, .numbers = {}, .frames = {}};
  start = cpuSeconds();
  const auto front_end = makeFrontEnd(FrontEndKind::kFlow);
  forEachFrame(inputs, [&](const FootageImage& frame) {
    tracks.frames.push_back(front_end->follow(frame.image));
    tracks.numbers.push_back(frame.number);
  });
  const double following = cpuSeconds() - start;
  std::filesystem::remove(video);

  start = cpuSeconds();
  const Path path = testing::pathOf(camera, tracks);
  const double placing = cpuSeconds() - start;
  const double error = testing::pathError(path, 0, poses).share;
  start = cpuSeconds();
  const Path steps = openCvPath(tracks, poses);
  const double opencv = cpuSeconds() - start;

  std::printf("%d frames of 640x480; %zu of %zu have a pose, in %zu pieces\n", kNumFrames, path.numPosed(),
              path.frames.size(), path.segments.size());
  printRow("alidade track, in all", following + placing, error);
  printRow("  decoding", decoding, 0);
  printRow("  optical flow", following - decoding, 0);
  printRow("  poses and points", placing, error);
  printRow("opencv findEssentialMat and recoverPose", opencv, testing::pathError(steps, 0, poses).share);
  constexpr double kLeastRate = 30;
  if (path.segments.size() == 1 && kNumFrames / (following + placing) >= kLeastRate) return 0;
  std::printf("FAILED: fewer than %.0f frames/s, or the path is in pieces\n", kLeastRate);
  return 1;
}

}  // namespace
}  // namespace alidade

int main() {
  return alidade::run();
}
