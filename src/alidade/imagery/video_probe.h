// SPDX-License-Identifier: MIT
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "alidade/core/cancel.h"

namespace alidade {

/// What a video file says about itself, and how far its data reaches.
struct VideoFacts {
  /// A place where packets are missing.
  struct Gap {
    std::size_t packet = 0;  ///< number of the next packet of the pictures
    bool is_fresh = false;   ///< that packet is a key frame, which needs none of the missing ones
  };

  std::string program_version;  ///< of FFmpeg
  int stream = 0;               ///< the index of the pictures among the streams of the file
  std::string container;        ///< FFmpeg's name: "matroska,webm"
  std::string codec;            ///< FFmpeg's name: "h264"
  std::string pixel_format;     ///< FFmpeg's name: "yuv420p"
  double seconds_per_tick = 0;
  std::optional<std::int64_t> start_ticks;
  int exif_orientation = 1;
  std::size_t stated_frames = 0;  ///< 0 if unknown
  double stated_seconds = 0;      ///< 0 if unknown
  double frame_rate_hz = 0;       ///< average; 0 if unknown
  double reached_seconds = 0;     ///< end of the last packet of any stream, from where the stated ones count
  bool are_all_key = true;        ///< every picture is coded on its own
  std::vector<Gap> gaps;          ///< in their order
};

/// Reads all packets of the file and decodes only the first frames.
/// @throws Error (kInput) if it is not a video, too large, or yields more data than it can hold; Cancelled
[[nodiscard]] VideoFacts probeVideo(const std::string& path, std::int64_t max_pixels,
                                    const CancelFlag* cancel);

}  // namespace alidade
