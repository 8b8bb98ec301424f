// SPDX-License-Identifier: MIT
#pragma once

#include <cstddef>
#include <functional>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "alidade/core/cancel.h"
#include "alidade/core/image.h"
#include "alidade/footage/follow/front_end.h"
#include "alidade/footage/follow/tracks.h"

namespace alidade {

/// An image of some footage.
struct FootageImage {
  const GrayImage& image;
  std::size_t number = 0;  ///< in the video, or among the photographs; from 0
  double seconds = 0;      ///< from the beginning of the video; 0 for photographs
};

/// Summary of a pass through footage.
struct FootagePass {
  bool is_video = false;  ///< a video or a numbered sequence: frames are equally spaced in time
  std::size_t num_frames = 0;
  std::size_t num_damaged = 0;          ///< for a video: skipped
  std::vector<std::string> notes = {};  ///< messages for the user, one sentence each
};

struct FootagePassOptions {
  std::optional<ImageSize> expected_size;  ///< of the camera; a different size is an error
  /// (done, total) after each frame; total = 0: unknown.
  std::function<void(std::size_t, std::size_t)> progress = {};
  const CancelFlag* cancel = nullptr;
};

/// True if inputs are a video or a numbered sequence; false for photographs.
/// @throws Error as listInputs(); Error (kUsage) for several videos, or a video with photographs
[[nodiscard]] bool isVideoFootage(std::span<const std::string> inputs);

/// Visits each image once, in order: those of one video, one numbered sequence (img%04d.png), or photographs.
/// Only one image is in memory at a time.
/// @throws Error as listInputs(); Error (kInput) for a damaged photograph, a video without an intact frame or
/// with less than nine tenths of its stated length, and images of different sizes; Cancelled
FootagePass forEachFrame(std::span<const std::string> inputs,
                         const std::function<void(const FootageImage&)>& show,
                         const FootagePassOptions& options = {});

/// Tracks points through footage. Of a video, only keyframes are kept. With fewer photographs, more key
/// points are sought in each: 10000 over their number, 400 to 1000.
/// @param pass  set to a summary
[[nodiscard]] FootageTracks trackFootage(std::span<const std::string> inputs, FrontEndKind kind,
                                         FootagePass& pass, const FootagePassOptions& options = {});

}  // namespace alidade
