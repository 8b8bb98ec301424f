// SPDX-License-Identifier: MIT
#include <algorithm>
#include <functional>
#include <memory>
#include <utility>

#include <fmt/format.h>

#include "alidade/core/error.h"
#include "alidade/core/mapped.h"
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

// Runs of frames without a pose: the first and the last of each.
std::vector<std::pair<std::size_t, std::size_t>> unposed(const Path& path) {
  std::vector<std::pair<std::size_t, std::size_t>> runs;
  for (std::size_t i = 0; i < path.frames.size(); ++i) {
    if (path.frames[i].segment) continue;
    if (i > 0 && !path.frames[i - 1].segment) {
      runs.back().second = i;
    } else {
      runs.emplace_back(i, i);
    }
  }
  return runs;
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

std::string whatToDo(const Path& path, bool is_flow) {
  switch (path.obstacle) {
    case StartObstacle::kStill:
    case StartObstacle::kRotation:
      return "move the camera sideways while filming; distances cannot be seen without";
    case StartObstacle::kNoMotion:
      return "check the camera file with alidade validate, and that most of the scene stands still";
    default:
      return is_flow ? "use sharp and bright pictures; if they are far apart, add --front-end keypoints"
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
    flags.add("input", &inputs_, "Video, folder of images, or pattern (*.jpg, frame%04d.png)", kFilePath);
    flags.add("--camera", &camera_path_, "Camera file of any format (docs/formats.md)", kFilePath);
    flags.add(
        "--front-end", &front_end_,
        "How points are followed: flow (small motions) or keypoints (any); default: flow for videos and "
        "numbered images, keypoints for others",
        oneOf({"flow", "keypoints"}));
    flags.add("-o,--output", &output_, "Trajectory file to write; - for standard output", kFilePath);
    flags.add("--map", &map_, "Also write the points, as a PLY file", kFilePath);
    addReadOptions(flags, camera_);
    flags.addCommon(common_, false);
  }

  int run(const Flags&) override {
    checkUsage();
    common_.cancel = catchInterrupts();
    const CameraRecord camera = readCameraTelling(camera_path_, camera_, common_.quiet);
    track(camera);
    if (path_.frames.size() < 2) {
      throw inputError({.where = inputs_.front(),
                        .found = "1 frame",
                        .expected = "at least 2",
                        .next_step = "give a video, or a folder with several images of one scene"});
    }
    if (!path_.segments.empty()) write();
    print();
    if (path_.segments.size() == 1) return 0;
    printMessage("error: " + inputs_.front() + ": " +
                 (path_.segments.empty()
                      ? fmt::format("no path can be found: {}; {}\n  next: {}", whyNot(path_),
                                    notWritten(output_), whatToDo(path_, is_flow_))
                      : fmt::format("the path is in {} pieces that nothing connects; each has a world and a "
                                    "scale of its own\n  next: film without interruption, dark frames and "
                                    "quick turns, or cut the video there",
                                    path_.segments.size())));
    return kUntrustworthyExit;
  }

 private:
  void checkUsage() const {
    if (inputs_.empty()) throw missing("no footage", "a video or a folder of images");
    if (camera_path_.empty()) throw missing("no --camera", "--camera FILE");
    if (output_.empty()) throw missing("no --output", "-o FILE");
    std::vector<std::string> sources = withImages(inputs_);
    append(sources, {cameraFilePath(camera_path_), common_.config});
    checkOutputs(std::vector<Output>{{"--output", output_}, {"--map", map_, "map.ply"}}, sources, common_);
  }

  void track(const CameraRecord& camera) {
    is_flow_ = front_end_.empty() ? isVideoFootage(inputs_) : front_end_ == "flow";
    const std::unique_ptr<FrontEnd> front_end =
        makeFrontEnd(is_flow_ ? FrontEndKind::kFlow : FrontEndKind::kKeyPoints);
    Odometry odometry(camera.camera, camera.image_size);
    ProgressBar bar("tracking", common_.quiet);
    const FootagePass pass = forEachFrame(
        inputs_,
        [&](const auto& frame) {
          odometry.add(frame.number, front_end->follow(frame.image));
          seconds_.push_back(frame.seconds);
        },
        {.expected_size = camera.image_size, .progress = bar.reporter(), .cancel = common_.cancel});
    notes_ = pass.notes;
    path_ = odometry.finish();
    // Some files do not state times.
    const bool is_timed = std::ranges::adjacent_find(seconds_, std::greater_equal<>()) == seconds_.end();
    if (!is_timed) seconds_.clear();
  }

  void write() const {
    if (!map_.empty()) writeFileAtomically(map_, mapText());
    const std::string text = trajectory();
    if (output_ == "-") {
      printResult(text);
    } else {
      writeFileAtomically(output_, text);
    }
  }

  void print() {
    answer([&] { return pathJson(); },
           [&] { return output_ == "-" || path_.segments.empty() ? "" : summary(); });
    if (!common_.quiet) printNotes(notes_);
  }

  // "piece 2: frames 7 to 90", and the basis of its scale.
  [[nodiscard]] std::vector<std::string> pieceComments(std::size_t index) const {
    const PathSegment& segment = path_.segments[index];
    std::vector<std::string> comments = {
        fmt::format("piece {} of {}: {}; its world and its scale are its own", index + 1,
                    path_.segments.size(), framesText(segment.begin, segment.end - 1))};
    for (const std::size_t frame : segment.scale_breaks)
      comments.push_back(
          fmt::format("from frame {} the scale is a guess: no point of known distance was in sight",
                      path_.frames[frame].number));
    return comments;
  }

  // The numbers of a range of frames: "frame 7", "frames 7 to 9".
  [[nodiscard]] std::string framesText(std::size_t first, std::size_t last) const {
    const std::size_t number = path_.frames[first].number;
    return first == last ? fmt::format("frame {}", number)
                         : fmt::format("frames {} to {}", number, path_.frames[last].number);
  }

  [[nodiscard]] std::vector<std::string> headComments() const { return {maker(), kScaleNote}; }

  [[nodiscard]] std::string trajectory() const {
    std::vector<std::string> comments = headComments();
    comments.push_back("world_from_camera; a piece's world is its first camera (x right, y down, z forward)");
    comments.emplace_back(seconds_.empty() ? "timestamps are the numbers of the frames, from 0"
                                           : "timestamps are seconds from the beginning of the video");
    std::string text;
    for (const std::string& comment : comments) text += "# " + comment + "\n";
    for (std::size_t s = 0; s < path_.segments.size(); ++s) {
      for (const std::string& comment : pieceComments(s)) text += "# " + comment + "\n";
      std::vector<double> times;
      std::vector<SE3> poses;
      for (std::size_t i = 0; i < path_.frames.size(); ++i) {
        const PathFrame& frame = path_.frames[i];
        if (frame.segment != s) continue;
        times.push_back(seconds_.empty() ? static_cast<double>(frame.number) : seconds_[i]);
        poses.push_back(frame.camera_from_world);
      }
      text += tumText(times, poses);
    }
    return text;
  }

  [[nodiscard]] std::string mapText() const {
    return pointCloudText(headComments(), mapped(path_.segments, &PathSegment::points));
  }

  [[nodiscard]] std::string summary() const {
    std::size_t num_keys = 0;
    std::size_t num_points = 0;
    double length = 0;
    for (const PathSegment& segment : path_.segments) {
      num_keys += segment.num_keys;
      num_points += segment.points.size();
      length += segment.length;
    }
    Lines lines = {fmt::format("{}: poses of {} of {} frames", printable(output_), path_.numPosed(),
                               path_.frames.size())};
    if (path_.segments.size() == 1) {
      addLines(lines, "Path", "{:.4g} units long; {}", length, kScaleNote);
    } else {
      addLines(lines, "Path", "in {} pieces that nothing connects; {}", path_.segments.size(), kScaleNote);
      constexpr std::size_t kMostPieces = 3;
      for (std::size_t s = 0; s < std::min(kMostPieces, path_.segments.size()); ++s) {
        const PathSegment& segment = path_.segments[s];
        addLines(lines, "", "piece {}: {}, {:.4g} units long", s + 1,
                 framesText(segment.begin, segment.end - 1), segment.length);
      }
      if (path_.segments.size() > kMostPieces)
        addLines(lines, "", "{} more pieces", path_.segments.size() - kMostPieces);
    }
    addLines(lines, "Fit", "reprojection RMS {:.2f} px; {} key frames, {} points{}", path_.rms_px, num_keys,
             num_points, map_.empty() ? "" : ", written to " + printable(map_));
    append(lines, lostLines());
    append(lines, scaleLines());
    return join(lines, "\n") + "\n";
  }

  [[nodiscard]] Lines lostLines() const {
    const auto ranges = unposed(path_);
    if (ranges.empty()) return {};
    std::string text = "no pose: ";
    constexpr std::size_t kMost = 3;
    for (std::size_t i = 0; i < std::min(kMost, ranges.size()); ++i)
      text += (i == 0 ? "" : ", ") + framesText(ranges[i].first, ranges[i].second);
    if (ranges.size() > kMost) text += fmt::format(" and {} more ranges", ranges.size() - kMost);
    if (!path_.frames.back().segment) text += "; at the end, " + whyNot(path_);
    return wrapped("Lost", text);
  }

  [[nodiscard]] Lines scaleLines() const {
    std::vector<std::size_t> frames;
    for (const PathSegment& segment : path_.segments)
      for (const std::size_t frame : segment.scale_breaks) frames.push_back(path_.frames[frame].number);
    if (frames.empty()) return {};
    return wrapped(
        "Scale",
        fmt::format("a guess from frame {} on{}: no point of known distance was in sight", frames.front(),
                    frames.size() > 1 ? fmt::format(", and {} times more", frames.size() - 1) : ""));
  }

  [[nodiscard]] std::string pathJson() const {
    json pieces = json::array();
    for (std::size_t s = 0; s < path_.segments.size(); ++s) {
      const PathSegment& segment = path_.segments[s];
      const auto numberOf = [&](std::size_t frame) { return path_.frames[frame].number; };
      const auto num_frames = std::count_if(path_.frames.begin(), path_.frames.end(),
                                            [&](const PathFrame& frame) { return frame.segment == s; });
      pieces.push_back({{"first_frame", path_.frames[segment.begin].number},
                        {"last_frame", path_.frames[segment.end - 1].number},
                        {"num_frames", num_frames},
                        {"num_keyframes", segment.num_keys},
                        {"num_points", segment.points.size()},
                        {"length", segment.length},
                        {"scale_guessed_from", mapped(segment.scale_breaks, numberOf)}});
    }
    json lost = json::array();
    for (const auto& [first, last] : unposed(path_))
      lost.push_back({{"first_frame", path_.frames[first].number},
                      {"last_frame", path_.frames[last].number},
                      {"num_frames", last - first + 1}});
    const bool is_found = !path_.segments.empty();
    return jsonText({{"trajectory", is_found ? json(output_) : json(nullptr)},
                     {"map", is_found && !map_.empty() ? json(map_) : json(nullptr)},
                     {"front_end", is_flow_ ? "flow" : "keypoints"},
                     {"timestamps", seconds_.empty() ? "frame_number" : "seconds"},
                     {"scale", "arbitrary"},
                     {"num_frames", path_.frames.size()},
                     {"num_posed", path_.numPosed()},
                     {"rms_px", is_found ? json(path_.rms_px) : json(nullptr)},
                     {"obstacle", obstacleId(path_.obstacle)},
                     {"pieces", std::move(pieces)},
                     {"lost", std::move(lost)},
                     {"notes", notes_}});
  }

  std::vector<std::string> inputs_;
  std::string camera_path_;
  ReadOptions camera_;
  std::string front_end_;
  std::string output_;
  std::string map_;
  bool is_flow_ = true;
  Path path_;
  std::vector<double> seconds_;  // of each frame; empty if unknown
  std::vector<std::string> notes_;
};

}  // namespace

const CommandEntry kTrackCommand = {"track", "Find the path of a camera in a video (visual odometry)",
                                    made<TrackCommand>};

}  // namespace alidade
