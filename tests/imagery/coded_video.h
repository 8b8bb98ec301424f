// SPDX-License-Identifier: MIT
#pragma once

#include <functional>
#include <string>
#include <vector>

#include "alidade/core/image.h"

namespace alidade {

/// A video for tests, as FFmpeg's encoders make it.
struct CodedVideo {
  std::string codec;         ///< name of the encoder, such as "ffv1", which loses nothing
  std::string pixel_format;  ///< such as "yuv420p10le"
  ImageSize size{64, 48};
  int num_frames = 1;
  /// Value of the first component (luma) at (x, y) of a frame; of each component for RGB.
  std::function<unsigned(int x, int y, int frame)> sample;
  double frames_per_second = 30;
  bool is_header_first = false;        ///< of MP4 and MOV
  int quality = 3;                     ///< of encoders with a fixed step of quantisation: 1 (best) to 31
  std::vector<std::string> options{};  ///< more of ffmpeg's options, such as {"-bf", "2"}
};

/// Writes it in the container that the name asks for. @throws std::runtime_error. @returns the path
std::string writeVideo(const std::string& path, const CodedVideo& video);

/// Whether this FFmpeg has an encoder; some, as of H.264, are optional.
[[nodiscard]] bool hasEncoder(const std::string& name);

}  // namespace alidade
