// SPDX-License-Identifier: MIT
#include <algorithm>
#include <filesystem>
#include <optional>

#include <fmt/format.h>

#include "alidade/core/error.h"
#include "alidade/core/text.h"
#include "alidade/files/camera_source.h"
#include "alidade/files/point_cloud.h"
#include "alidade/files/pose_list.h"
#include "alidade/files/text/atomic_file.h"
#include "alidade/footage/follow/footage_frames.h"
#include "alidade/footage/map/odometry.h"
#include "alidade/report/data/json_output.h"
#include "camera_files.h"
#include "command.h"
#include "console.h"
#include "outputs.h"
#include "summary_lines.h"

namespace alidade {
namespace {

constexpr const char* kScaleNote =
    "the scale is arbitrary: lengths are not in metres, but in units of the first step of each piece";

// The path that the odometry found, with the times of the frames.
struct TrackedPath {
  Path path;
  std::vector<double> seconds;  // of each frame; empty if unknown
  FootagePass pass;
  FrontEndKind front_end = FrontEndKind::kFlow;

  [[nodiscard]] double timeOf(std::size_t frame) const {
    return seconds.empty() ? static_cast<double>(path.frames[frame].number) : seconds[frame];
  }
};

// Text for a range of frame numbers: "frame 7", "frames 7 to 9".
std::string framesText(std::size_t first, std::size_t last) {
  return first == last ? fmt::format("frame {}", first) : fmt::format("frames {} to {}", first, last);
}

struct FrameRange {
  std::size_t first = 0;  // numbers
  std::size_t last = 0;
  std::size_t count = 0;
};

// Runs of frames without a pose.
std::vector<FrameRange> unposed(const Path& path) {
  std::vector<FrameRange> ranges;
  bool is_open = false;
  for (const PathFrame& frame : path.frames) {
    if (frame.segment) {
      is_open = false;
      continue;
    }
    if (!is_open) ranges.push_back({frame.number, frame.number, 0});
    is_open = true;
    ranges.back().last = frame.number;
    ++ranges.back().count;
  }
  return ranges;
}

std::string whyNot(const Path& path) {
  switch (path.obstacle) {
    case StartObstacle::kStill:
      return "nothing moves in the pictures";
    case StartObstacle::kRotation:
      return "the camera only turns in place, or all points are far away";
    case StartObstacle::kNoMotion:
      return "the points do not move as one rigid scene does";
    default:
      return "too few points can be followed";
  }
}

std::string whatToDo(const TrackedPath& tracked) {
  switch (tracked.path.obstacle) {
    case StartObstacle::kStill:
    case StartObstacle::kRotation:
      return "move the camera sideways while filming; distances cannot be seen without";
    case StartObstacle::kNoMotion:
      return "check the camera file with alidade validate, and that most of the scene stands still";
    default:
      return tracked.front_end == FrontEndKind::kFlow
                 ? "use sharp and bright pictures; if they are far apart, add --front-end keypoints"
                 : "use sharp and bright pictures that show parts of the scene several times";
  }
}

class TrackCommand final : public Command {
 public:
  void setUp(Flags& flags) override {
    flags.explain(
        "Example: alidade track walk.mp4 --camera camera.yaml -o trajectory.txt\nVisual odometry: errors add "
        "up along the way, and places that are seen again are not recognised. The scale is "
        "arbitrary.\nWrites a TUM trajectory: timestamp tx ty tz qx qy qz qw, world_from_camera "
        "(docs/tracking.md).");
    flags.add("input", &inputs_, "Video, folder of images, or pattern (*.jpg, frame%04d.png)", kFile);
    flags.add("--camera", &camera_path_, "Camera file of any format (docs/formats.md)", kFile);
    flags.add(
        "--front-end", &front_end_,
        "How points are followed: flow (small motions) or keypoints (any); default: flow for videos and "
        "numbered images, keypoints for others",
        oneOf({"flow", "keypoints"}));
    flags.add("-o,--output", &output_, "Trajectory file to write; - for standard output", kFile);
    flags.add("--map", &map_, "Also write the points, as a PLY file", kFile);
    camera_.addOptions(flags);
    flags.addCommon(common_, false);
  }

  int run(const Flags&) override {
    checkUsage();
    const CancelFlag* cancel = catchInterrupts();
    const CameraRecord camera = readCameraTelling(camera_path_, camera_.readOptions(), common_.quiet);
    const TrackedPath tracked = track(camera, cancel);
    const Path& path = tracked.path;
    if (path.frames.size() < 2) {
      throw inputError({.where = inputs_.front(),
                        .found = "1 frame",
                        .expected = "at least 2",
                        .next_step = "give a video, or a folder with several images of one scene"});
    }
    if (!path.segments.empty()) write(tracked);
    print(tracked);
    if (path.segments.size() == 1) return 0;
    printMessage("error: " + inputs_.front() + ": " +
                 (path.segments.empty()
                      ? fmt::format("no path can be found: {}; {}\n  next: {}", whyNot(path),
                                    notWritten(output_), whatToDo(tracked))
                      : fmt::format("the path is in {} pieces that nothing connects; each has a world and a "
                                    "scale of its own\n  next: film without interruption, dark frames and "
                                    "quick turns, or cut the video there",
                                    path.segments.size())));
    return kUntrustworthyExit;
  }

  [[nodiscard]] bool owesJson() const override { return common_.json && !has_answered_; }

 private:
  void checkUsage() const {
    if (inputs_.empty()) throw missingError("track", "no footage", "a video or a folder of images");
    if (camera_path_.empty()) throw missingError("track", "no --camera", "--camera FILE");
    if (output_.empty()) throw missingError("track", "no --output", "-o FILE");
    std::vector<std::string> sources = withImages(inputs_);
    append(sources, {cameraFilePath(camera_path_), common_.config});
    checkOutputs(std::vector<Output>{{"--output", output_}, {"--map", map_, "map.ply"}}, sources, common_);
  }

  [[nodiscard]] TrackedPath track(const CameraRecord& camera, const CancelFlag* cancel) const {
    TrackedPath tracked;
    const bool is_flow = front_end_.empty() ? isVideoFootage(inputs_) : front_end_ == "flow";
    tracked.front_end = is_flow ? FrontEndKind::kFlow : FrontEndKind::kKeyPoints;
    const std::unique_ptr<FrontEnd> front_end = makeFrontEnd(tracked.front_end);
    Odometry odometry(camera.camera, camera.image_size);
    ProgressBar bar("tracking", common_.quiet);
    tracked.pass =
        forEachFrame(inputs_,
                     [&](const auto& frame) {
                       odometry.add(frame.number, front_end->follow(frame.image));
                       tracked.seconds.push_back(frame.seconds);
                     },
                     {.expected_size = camera.image_size,
                      .progress = [&](std::size_t done, std::size_t total) { bar.update(done, total); },
                      .cancel = cancel});
    tracked.path = odometry.finish();
    // Some files do not state times.
    const bool is_timed =
        std::ranges::adjacent_find(tracked.seconds, std::greater_equal<>()) == tracked.seconds.end();
    if (!is_timed) tracked.seconds.clear();
    return tracked;
  }

  void write(const TrackedPath& tracked) const {
    if (!map_.empty()) writeFileAtomically(map_, mapText(tracked.path));
    const std::string text = trajectoryOf(tracked);
    if (output_ == "-") {
      printResult(text);
    } else {
      writeFileAtomically(output_, text);
    }
  }

  void print(const TrackedPath& tracked) {
    if (common_.json) {
      printResult(pathJson(tracked));
      has_answered_ = true;
    } else if (!common_.quiet && output_ != "-" && !tracked.path.segments.empty()) {
      printResult(summary(tracked));
    }
    if (!common_.quiet) printNotes(tracked.pass.notes);
  }

  // "piece 2: frames 7 to 90", and the basis of its scale.
  static std::vector<std::string> pieceComments(const Path& path, std::size_t index) {
    const PathSegment& segment = path.segments[index];
    std::vector<std::string> comments = {fmt::format(
        "piece {} of {}: {}; its world and its scale are its own", index + 1, path.segments.size(),
        framesText(path.frames[segment.begin].number, path.frames[segment.end - 1].number))};
    for (const std::size_t frame : segment.scale_breaks)
      comments.push_back(
          fmt::format("from frame {} the scale is a guess: no point of known distance was in sight",
                      path.frames[frame].number));
    return comments;
  }

  [[nodiscard]] std::vector<std::string> headComments() const {
    return {programName() + " track", kScaleNote};
  }

  [[nodiscard]] std::string trajectoryOf(const TrackedPath& tracked) const {
    const Path& path = tracked.path;
    std::vector<std::string> comments = headComments();
    comments.push_back("world_from_camera; a piece's world is its first camera (x right, y down, z forward)");
    comments.emplace_back(tracked.seconds.empty() ? "timestamps are the numbers of the frames, from 0"
                                                  : "timestamps are seconds from the beginning of the video");
    std::string text;
    for (const std::string& comment : comments) text += "# " + comment + "\n";
    for (std::size_t s = 0; s < path.segments.size(); ++s) {
      for (const std::string& comment : pieceComments(path, s)) text += "# " + comment + "\n";
      std::vector<double> times;
      std::vector<SE3> poses;
      for (std::size_t i = 0; i < path.frames.size(); ++i) {
        if (path.frames[i].segment != s) continue;
        times.push_back(tracked.timeOf(i));
        poses.push_back(path.frames[i].camera_from_world);
      }
      text += tumText(times, poses);
    }
    return text;
  }

  [[nodiscard]] std::string mapText(const Path& path) const {
    std::vector<std::vector<Eigen::Vector3d>> pieces;
    for (const PathSegment& segment : path.segments) pieces.push_back(segment.points);
    return pointCloudText(headComments(), pieces);
  }

  [[nodiscard]] std::string summary(const TrackedPath& tracked) const {
    const Path& path = tracked.path;
    std::size_t num_keys = 0;
    std::size_t num_points = 0;
    double length = 0;
    for (const PathSegment& segment : path.segments) {
      num_keys += segment.num_keys;
      num_points += segment.points.size();
      length += segment.length;
    }
    Lines lines = {
        fmt::format("{}: poses of {} of {} frames", printable(output_), path.numPosed(), path.frames.size())};
    if (path.segments.size() == 1) {
      append(lines, wrapped("Path", fmt::format("{:.4g} units long; {}", length, kScaleNote)));
    } else {
      append(lines, wrapped("Path", fmt::format("in {} pieces that nothing connects; {}",
                                                path.segments.size(), kScaleNote)));
      constexpr std::size_t kMostPieces = 3;
      for (std::size_t s = 0; s < std::min(kMostPieces, path.segments.size()); ++s) {
        const PathSegment& segment = path.segments[s];
        append(lines, wrapped("", fmt::format("piece {}: {}, {:.4g} units long", s + 1,
                                              framesText(path.frames[segment.begin].number,
                                                         path.frames[segment.end - 1].number),
                                              segment.length)));
      }
      if (path.segments.size() > kMostPieces)
        append(lines, wrapped("", fmt::format("{} more pieces", path.segments.size() - kMostPieces)));
    }
    append(lines, wrapped("Fit", fmt::format("reprojection RMS {:.2f} px; {} key frames, {} points{}",
                                             path.rms_px, num_keys, num_points,
                                             map_.empty() ? "" : ", written to " + printable(map_))));
    append(lines, lostLines(path));
    append(lines, scaleLines(path));
    return join(lines, "\n") + "\n";
  }

  static Lines lostLines(const Path& path) {
    const std::vector<FrameRange> ranges = unposed(path);
    if (ranges.empty()) return {};
    std::string text = "no pose: ";
    constexpr std::size_t kMost = 3;
    for (std::size_t i = 0; i < std::min(kMost, ranges.size()); ++i)
      text += (i == 0 ? "" : ", ") + framesText(ranges[i].first, ranges[i].last);
    if (ranges.size() > kMost) text += fmt::format(" and {} more ranges", ranges.size() - kMost);
    if (!path.frames.back().segment) text += "; at the end, " + whyNot(path);
    return wrapped("Lost", text);
  }

  static Lines scaleLines(const Path& path) {
    std::vector<std::size_t> frames;
    for (const PathSegment& segment : path.segments)
      for (const std::size_t frame : segment.scale_breaks) frames.push_back(path.frames[frame].number);
    if (frames.empty()) return {};
    return wrapped(
        "Scale",
        fmt::format("a guess from frame {} on{}: no point of known distance was in sight", frames.front(),
                    frames.size() > 1 ? fmt::format(", and {} times more", frames.size() - 1) : ""));
  }

  [[nodiscard]] std::string pathJson(const TrackedPath& tracked) const {
    const Path& path = tracked.path;
    json pieces = json::array();
    for (std::size_t s = 0; s < path.segments.size(); ++s) {
      const PathSegment& segment = path.segments[s];
      json breaks = json::array();
      for (const std::size_t frame : segment.scale_breaks) breaks.push_back(path.frames[frame].number);
      const auto num_frames = std::count_if(path.frames.begin(), path.frames.end(),
                                            [&](const PathFrame& frame) { return frame.segment == s; });
      pieces.push_back({{"first_frame", path.frames[segment.begin].number},
                        {"last_frame", path.frames[segment.end - 1].number},
                        {"num_frames", num_frames},
                        {"num_keyframes", segment.num_keys},
                        {"num_points", segment.points.size()},
                        {"length", segment.length},
                        {"scale_guessed_from", std::move(breaks)}});
    }
    json lost = json::array();
    for (const FrameRange& range : unposed(path))
      lost.push_back({{"first_frame", range.first}, {"last_frame", range.last}, {"num_frames", range.count}});
    const bool is_found = !path.segments.empty();
    return jsonText({{"trajectory", is_found ? json(output_) : json(nullptr)},
                     {"map", is_found && !map_.empty() ? json(map_) : json(nullptr)},
                     {"front_end", tracked.front_end == FrontEndKind::kFlow ? "flow" : "keypoints"},
                     {"timestamps", tracked.seconds.empty() ? "frame_number" : "seconds"},
                     {"scale", "arbitrary"},
                     {"num_frames", path.frames.size()},
                     {"num_posed", path.numPosed()},
                     {"rms_px", is_found ? json(path.rms_px) : json(nullptr)},
                     {"obstacle", obstacleId(path.obstacle)},
                     {"pieces", std::move(pieces)},
                     {"lost", std::move(lost)},
                     {"notes", tracked.pass.notes}});
  }

  std::vector<std::string> inputs_;
  std::string camera_path_;
  CameraOptions camera_;
  std::string front_end_;
  std::string output_;
  std::string map_;
  bool has_answered_ = false;
};

}  // namespace

std::unique_ptr<Command> makeTrackCommand() {
  return std::make_unique<TrackCommand>();
}

}  // namespace alidade
