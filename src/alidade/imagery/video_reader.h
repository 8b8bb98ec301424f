// SPDX-License-Identifier: MIT
#pragma once

#include <cstddef>
#include <memory>
#include <string>

#include "alidade/core/image.h"
#include "alidade/imagery/image_file.h"

namespace alidade {

/// The frames of a video file, in the order in which they are shown; one is in memory at a time. Frames are
/// counted from 0. A frame is the luma of the stored pixels, 8 bits, as coded (often 16 to 235); the display
/// orientation is not applied.
///
/// Decoders repair damaged data with pixels of their own making. A frame is intact only if the decoder did
/// not complain about it or any frame since the last key frame. Some damage leaves valid codes, of which no
/// decoder complains; HEVC and VP9 notice little.
class VideoReader {
 public:
  /// @throws Error (kInput) if the file is missing, no video, or in a format or codec that FFmpeg lacks
  explicit VideoReader(const std::string& path);
  ~VideoReader();
  VideoReader(VideoReader&&) noexcept;
  VideoReader& operator=(VideoReader&&) noexcept;

  /// Goes to the next frame; false at the end. Before the first call there is no frame.
  [[nodiscard]] bool advance();

  [[nodiscard]] std::size_t number() const;  ///< of the frame
  [[nodiscard]] bool isIntact() const;       ///< the frame
  [[nodiscard]] std::size_t numLost()
      const;                                ///< parts of the file so far that gave no frame for their damage
  [[nodiscard]] bool isInterlaced() const;  ///< the frame holds two moments, in alternating rows
  /// The frame as a grey image. @throws Error (kInput) if it is too large
  [[nodiscard]] LoadedImage image() const;

  /// The number of frames and the seconds that the file says it has; 0 if it does not say.
  [[nodiscard]] std::size_t statedFrames() const;
  [[nodiscard]] double statedSeconds() const;
  /// When the frame is shown, from the beginning of the video; 0 if the file does not say.
  [[nodiscard]] double seconds() const;

 private:
  struct State;
  std::unique_ptr<State> state_;
};

/// True for a name with the extension of a video file, in upper or lower case.
[[nodiscard]] bool hasVideoName(const std::string& path);

}  // namespace alidade
