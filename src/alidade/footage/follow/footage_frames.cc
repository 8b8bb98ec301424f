// SPDX-License-Identifier: MIT
#include "alidade/footage/follow/footage_frames.h"

#include <algorithm>

#include <fmt/format.h>

#include "alidade/core/error.h"
#include "alidade/imagery/image_file.h"
#include "alidade/imagery/image_list.h"
#include "alidade/imagery/video_reader.h"

namespace alidade {
namespace {

InputFiles filesOf(std::span<const std::string> inputs) {
  InputFiles files = listInputs(inputs);
  const std::size_t num_timed = files.videos.size() + files.sequences.size();
  if (num_timed > 1 || (num_timed == 1 && !files.images.empty())) {
    throw usageError({.where = inputs.front(),
                      .found = fmt::format("{} video{} or sequence{} and {} photograph{}", num_timed,
                                           num_timed == 1 ? "" : "s", num_timed == 1 ? "" : "s",
                                           files.images.size(), files.images.size() == 1 ? "" : "s"),
                      .expected = "one video, one sequence (img%04d.png), or photographs"});
  }
  return files;
}

// Requires the common size of the footage: that of the camera, or else of the first image.
void requireSize(const std::string& name, ImageSize size, const FootagePassOptions& options,
                 std::optional<ImageSize>& common) {
  if (!common) common = options.expected_size.value_or(size);
  if (size == *common) return;
  const bool is_turned = size.width == common->height && size.height == common->width;
  throw inputError(
      {.where = name,
       .found = fmt::format("{}x{} pixels", size.width, size.height),
       .expected = fmt::format("{}x{}, {}", common->width, common->height,
                               options.expected_size ? "as the camera file says" : "as the other images"),
       .next_step = is_turned ? "turn the camera file (alidade convert --rotate 90), or the images"
                              : "adapt the camera file (alidade convert --resize or --crop)"});
}

FootagePass showVideo(const std::string& path, const std::function<void(const FootageImage&)>& show,
                      const FootagePassOptions& options) {
  FootagePass pass{.is_video = true};
  std::optional<ImageSize> size;
  VideoReader reader(path, {.cancel = options.cancel});
  std::size_t num_interlaced = 0;
  int orientation = 1;
  while (reader.advance()) {
    throwIfCancelled(options.cancel);
    ++pass.num_frames;
    num_interlaced += reader.isInterlaced() ? 1 : 0;
    if (reader.isIntact()) {
      const LoadedImage frame = reader.image();
      orientation = frame.exif_orientation;
      requireSize(path, frame.image.size, options, size);
      show({.image = frame.image, .number = reader.number(), .seconds = reader.seconds()});
    } else {
      ++pass.num_damaged;
    }
    if (options.progress) options.progress(pass.num_frames, reader.statedFrames());
  }
  constexpr double kMuch = 0.1;
  constexpr double kLittle = 0.02;  // headers may count frames that cannot be read
  const double missing = reader.missingShare();
  if (pass.num_frames == pass.num_damaged || missing > kMuch) {
    throw inputError(
        {.where = path,
         .found = pass.num_frames == 0 ? "no frame can be decoded"
                  : pass.num_frames == pass.num_damaged
                      ? fmt::format("all {} frames are damaged", pass.num_frames)
                      : fmt::format("the file ends early: only {:.0f} % can be read", 100 * (1 - missing)),
         .expected = "a video that can be decoded completely",
         .next_step =
             "copy the video again, or convert it: ffmpeg -i '" + path + "' -map 0:v:0 -c copy whole.mp4"});
  }
  if (orientation != 1) {
    pass.notes.push_back(fmt::format("{}: players show the video {}; its pixels are used as stored", path,
                                     describeExifOrientation(orientation)));
  }
  if (missing > kLittle || reader.isCut()) pass.notes.push_back(path + ": the file ends a little early");
  if (pass.num_damaged > 0) {
    pass.notes.push_back(fmt::format("{}: {} of {} frames are damaged; they are not used", path,
                                     pass.num_damaged, pass.num_frames));
  }
  if (num_interlaced > 0) {
    pass.notes.push_back(
        fmt::format("{}: {} frames are interlaced: each holds two moments, which makes points inexact", path,
                    num_interlaced));
  }
  return pass;
}

}  // namespace

bool isVideoFootage(std::span<const std::string> inputs) {
  return filesOf(inputs).images.empty();
}

FootagePass forEachFrame(std::span<const std::string> inputs,
                         const std::function<void(const FootageImage&)>& show,
                         const FootagePassOptions& options) {
  const InputFiles files = filesOf(inputs);
  if (!files.videos.empty()) return showVideo(files.videos.front(), show, options);
  const bool is_sequence = !files.sequences.empty();
  const std::vector<std::string>& names = is_sequence ? files.sequences.front().files : files.images;
  FootagePass pass{.is_video = is_sequence};
  std::optional<ImageSize> size;
  for (const std::string& name : names) {
    throwIfCancelled(options.cancel);
    const LoadedImage loaded = readGrayImage(name);
    requireSize(name, loaded.image.size, options, size);
    show({.image = loaded.image, .number = pass.num_frames, .seconds = 0});
    ++pass.num_frames;
    if (options.progress) options.progress(pass.num_frames, names.size());
  }
  return pass;
}

FootageTracks trackFootage(std::span<const std::string> inputs, FrontEndKind kind, FootagePass& pass,
                           const FootagePassOptions& options) {
  FootageTracks tracks;
  tracks.is_video = isVideoFootage(inputs);
  std::size_t num_points = kUsualNumPoints;
  if (kind == FrontEndKind::kKeyPoints && !tracks.is_video) {
    // Each image is matched with those before it, which takes a few seconds for this many points in total.
    constexpr std::size_t kAll = 10000;
    constexpr std::size_t kMost = 1000;
    const std::size_t num_images = std::max<std::size_t>(1, listImages(inputs).size());
    num_points = std::clamp(kAll / num_images, num_points, kMost);
  }
  const std::unique_ptr<FrontEnd> tracker = makeFrontEnd(kind, num_points);
  pass = forEachFrame(
      inputs,
      [&](const FootageImage& frame) {
        tracks.size = frame.image.size;
        std::vector<TrackPixel> points = tracker->follow(frame.image);
        if (!isKeyframe(tracks, points)) return;
        tracks.frames.push_back(std::move(points));
        tracks.numbers.push_back(frame.number);
      },
      options);
  return tracks;
}

}  // namespace alidade
