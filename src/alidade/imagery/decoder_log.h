// SPDX-License-Identifier: MIT
#pragma once

#include <cstddef>
#include <cstdint>
#include <deque>
#include <optional>
#include <string>
#include <string_view>
#include <utility>

#include "alidade/core/image.h"
#include "alidade/imagery/video_probe.h"

namespace alidade {

/// What ffmpeg writes while it decodes a video with `-loglevel repeat+level+info -debug_ts` and the filter
/// showinfo. The lines of its demuxer, decoder and filters are in their order each, but from version 7 on
/// they are threads, and the former run ahead of the latter.
class DecoderLog {
 public:
  struct Frame {
    std::optional<std::int64_t> ticks;
    ImageSize size;
    int depth = 8;      ///< bits of a sample; more than 8 are two bytes
    int high_byte = 1;  ///< which of the two is the higher one
    bool is_interlaced = false;
    bool is_intact = true;
    std::size_t num_lost = 0;  ///< parts of the file that gave no frame, so far
  };

  /// `facts` must outlive the object.
  DecoderLog(std::string path, const VideoFacts& facts) : path_(std::move(path)), facts_(facts) {}

  /// Reads more of the text. @throws Error (kInput) if it is not as expected
  void add(std::string_view text);

  std::deque<Frame> frames;  ///< whose pixels come next, added at the end; to be taken from the front

  /// Parts of the file that gave no frame, those after the last frame included.
  [[nodiscard]] std::size_t numLostAtEnd() const { return num_lost_ + facts_.gaps.size() - num_gaps_; }
  [[nodiscard]] bool isCut() const { return is_cut_; }  ///< the end of the file could not be read
  [[nodiscard]] const std::string& firstComplaint() const { return first_complaint_; }

 private:
  struct Message;
  // What was said up to a frame that left the decoder.
  struct Decoded {
    bool is_flawed = false;  // complaints since the last frame
    std::optional<std::int64_t> repaired_ticks;
    std::size_t num_lost = 0;
  };

  void note(const Message& message);
  void noteComplaint(const Message& message);
  void notePacket(const Message& message);
  void noteFlaw();
  void announce(const Message& message);

  std::string path_;
  const VideoFacts& facts_;
  std::string line_;  // its beginning, until the rest comes
  std::string format_;
  std::deque<Decoded> decoded_;  // frames that left the decoder, but not the filters
  std::string first_complaint_;
  std::size_t num_packets_ = 0;
  std::size_t num_gaps_ = 0;  // of facts_.gaps, those passed
  std::size_t num_lost_ = 0;
  bool is_decoding_ = false;  // what threads say can be mixed
  bool is_skipping_ = false;  // complaints of the demuxer since the last packet
  bool is_flawed_ = false;    // complaints since the last frame left the decoder
  bool is_repaired_ = false;  // a frame since the last key frame was repaired
  bool is_cut_ = false;
  std::optional<std::int64_t> read_ticks_;  // the latest of all packets read
  // The same at the last complaint: only later key frames are known not to be affected.
  std::optional<std::int64_t> repaired_ticks_;
};

}  // namespace alidade
