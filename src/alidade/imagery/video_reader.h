// SPDX-License-Identifier: MIT
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <string>

#include "alidade/core/cancel.h"
#include "alidade/core/image.h"
#include "alidade/imagery/image_file.h"

namespace alidade {

struct VideoOptions {
  /// Largest frame. A decoder holds up to 17 frames at a time, so this limits the memory that a damaged
  /// header can request.
  std::int64_t max_pixels = std::int64_t{1} << 26U;
  const CancelFlag* cancel = nullptr;  ///< must outlive the reader
};

/// The frames of a video file, in the order in which they are shown; one is in memory at a time. FFmpeg's
/// programs ffprobe and ffmpeg (4.4 or later, in PATH) decode them. Frames are counted from 0. A frame is the
/// luma of the stored pixels, as coded (often 16 to 235), rounded to 8 bits; pixels without luma (RGB) are
/// converted to grey, 0 to 255. The display orientation is not applied.
///
/// Decoders replace damaged data with invented pixels. A frame is intact only if the decoder did not complain
/// about it or any frame since the last key frame. Some good frames before damage may count as damaged,
/// because the decoder works ahead. Damage that leaves valid codes goes unnoticed; HEVC and VP9 detect
/// little.
///
/// All functions that read throw Cancelled soon after the flag is set, even during a long search for the next
/// frame.
class VideoReader {
 public:
  /// Reads all packets of the file and decodes only its first frames.
  /// @throws Error (kInput) if FFmpeg's programs are missing, or the file is missing, not a regular file, not
  /// a video, too large, in a format that FFmpeg lacks, or yields more data than it can hold
  explicit VideoReader(const std::string& path, const VideoOptions& options = {});
  ~VideoReader();
  VideoReader(VideoReader&&) noexcept;
  VideoReader& operator=(VideoReader&&) noexcept;

  /// Goes to the next frame; false at the end. Before the first call there is no frame.
  /// @throws Error (kInput) if frames become too large, FFmpeg lacks the codec, or ffmpeg crashes
  [[nodiscard]] bool advance();

  [[nodiscard]] std::size_t number() const;   ///< number of the frame
  [[nodiscard]] bool isIntact() const;        ///< the frame is undamaged
  [[nodiscard]] std::size_t numLost() const;  ///< parts of the file so far that yielded no frame because of
                                              ///< damage
  [[nodiscard]] bool isInterlaced() const;    ///< the frame holds two instants, in alternating rows
  /// The frame as a grey image.
  [[nodiscard]] LoadedImage image() const;

  /// The number of frames and the seconds that the file states; 0 if unknown.
  [[nodiscard]] std::size_t statedFrames() const;
  [[nodiscard]] double statedSeconds() const;
  /// Average number of frames in a second; 0 if unknown.
  [[nodiscard]] double frameRate() const;
  /// At the end: share of the stated frames and seconds that was not reached; the smaller one if the file
  /// states both. Headers may count frames that are not shown, and round a duration.
  [[nodiscard]] double missingShare() const;
  [[nodiscard]] bool isCut() const;  ///< reading ended at unreadable data, not at the end of the file
  /// Display time of the frame, from the beginning of the video; 0 if the file does not state it.
  [[nodiscard]] double seconds() const;

 private:
  struct State;
  std::unique_ptr<State> state_;
};

/// @throws Error (kInput) if the file is missing, empty, or not a regular file. Does not wait for a pipe.
void checkVideoFile(const std::string& path);

/// True for a name with the extension of a video file, in upper or lower case.
[[nodiscard]] bool hasVideoName(const std::string& path);

}  // namespace alidade
