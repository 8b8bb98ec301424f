// SPDX-License-Identifier: MIT
#include "alidade/imagery/decoder_log.h"

#include <algorithm>
#include <array>
#include <charconv>
#include <system_error>
#include <vector>

#include "alidade/core/text.h"
#include "alidade/imagery/video_program.h"

namespace alidade {
namespace {

std::optional<std::int64_t> ticksOf(std::string_view word) {
  std::int64_t value = 0;
  const auto [end, error] = std::from_chars(word.data(), word.data() + word.size(), value);
  return error == std::errc() && end == word.data() + word.size() ? std::optional(value) : std::nullopt;
}

// Bits of a sample of "gray" or "gray10le"; 0 if it is another format.
int depthOf(std::string_view format) {
  if (format == "gray") return 8;
  if (!format.starts_with("gray") || format.size() < 7) return 0;
  const int depth = parseInt(format.substr(4, format.size() - 6)).value_or(0);
  return depth > 8 && depth <= 16 ? depth : 0;
}

}  // namespace

// A line: "[h264 @ 0x55d4] [error] text".
struct DecoderLog::Message {
  std::string_view speaker;  // the first one; "" for the program
  std::string_view level;
  std::string_view text;

  explicit Message(std::string_view line) {
    constexpr std::array<std::string_view, 5> kLevels = {"info", "warning", "error", "fatal", "panic"};
    while (line.starts_with('[') && level.empty()) {
      const std::string_view word = line.substr(1, line.find(']') - 1);
      if (std::ranges::find(kLevels, word) != kLevels.end())
        level = word;
      else if (speaker.empty())
        speaker = word;
      line.remove_prefix(std::min(line.size(), word.size() + 3));
    }
    text = line;
  }

  [[nodiscard]] bool has(std::string_view words) const { return text.find(words) != std::string_view::npos; }
  [[nodiscard]] bool isFrame() const { return has(" iskey:"); }  // of the filter showinfo
  [[nodiscard]] bool isComplaint() const {
    return level == "error" || level == "fatal" || level == "panic" ||
           (level == "warning" && has("corrupt")) || hasForeignWords();
  }

  // The filter showinfo writes its lines in pieces: "n:   4 pts:   8192 ... type:P " and "color_range:tv
  // color_space:bt709 ...". So is the description of the output. What another thread writes in between is
  // appended to a piece without its level. Debugging lines, which have an arrow, are no complaints.
  [[nodiscard]] bool hasForeignWords() const {
    const auto isIn = [this](std::string_view words) { return has(words); };
    if (has(" -> ") || has(" <- ")) return false;
    if (speaker.empty() && level == "info") {
      constexpr std::array<std::string_view, 4> kComplaints = {"rror", "nvalid", "corrupt", "issing"};
      return std::ranges::any_of(kComplaints, isIn);
    }
    constexpr std::array<std::string_view, 8> kDescriptions = {
        "Output #", "Metadata", "encoder", "Stream #", "rawvideo", "SAR ", " tbn", "(default)"};
    if (!speaker.starts_with("Parsed_showinfo") || text.starts_with("config ") ||
        std::ranges::any_of(kDescriptions, isIn))
      return false;
    if (isFrame()) return !trim(text.substr(std::min(text.size(), text.find(" type:") + 7))).empty();
    const std::vector<std::string_view> words = split(trim(text), ' ');
    return std::any_of(words.begin() + 1, words.end(),
                       [](std::string_view word) { return !word.starts_with("color_"); });
  }

  // The word after "key:", also if blanks pad it.
  [[nodiscard]] std::string_view word(std::string_view key) const {
    const std::size_t at = text.find(key);
    if (at == std::string_view::npos) return {};
    const std::string_view rest = trim(text.substr(at + key.size()));
    return rest.substr(0, rest.find(' '));
  }
};

void DecoderLog::add(std::string_view text) {
  line_ += text;
  std::size_t begin = 0;
  for (std::size_t end = 0; (end = line_.find('\n', begin)) != std::string::npos; begin = end + 1)
    note(Message(std::string_view(line_).substr(begin, end - begin)));
  line_.erase(0, begin);
}

// A line may hold several messages; see hasForeignWords().
void DecoderLog::note(const Message& message) {
  // Before that, the file says what it is, such as its title.
  if (message.text == "Stream mapping:") is_decoding_ = true;
  if (!is_decoding_ && message.level == "info") return;
  if (message.isFrame()) announce(message);
  if (message.has("demuxer -> ")) notePacket(message);
  if (message.has("decoder -> ")) {
    decoded_.push_back({.is_flawed = std::exchange(is_flawed_, false),
                        .repaired_ticks = repaired_ticks_,
                        .num_lost = num_lost_});
  }
  if (message.isComplaint()) noteComplaint(message);
  if (message.level.empty() && first_complaint_.empty()) first_complaint_ = message.text;
}

void DecoderLog::noteComplaint(const Message& message) {
  if (first_complaint_.empty()) first_complaint_ = message.text;
  // Raw streams have the name of their codec.
  const bool is_of_demuxer =
      (message.speaker.starts_with(facts_.container) && facts_.container != facts_.codec) ||
      message.speaker.starts_with("in#");
  if (is_of_demuxer)
    is_skipping_ = true;
  else
    noteFlaw();
  // In the words of FFmpeg up to 6.0, and since.
  if (message.has("Error while decoding stream") || message.has("Error submitting packet") ||
      message.has("Decoding error")) {
    ++num_lost_;
    // The complaints were about the packet, and none of the other packets needs it.
    is_flawed_ = !facts_.are_all_key;
  }
  if (message.level == "error" && (message.text.starts_with("file:") || message.has("Error during demuxing")))
    is_cut_ = true;
}

void DecoderLog::noteFlaw() {
  is_flawed_ = true;
  repaired_ticks_ = read_ticks_;
}

void DecoderLog::notePacket(const Message& message) {
  if (std::exchange(is_skipping_, false)) noteFlaw();
  const auto shown = ticksOf(message.word(" pkt_pts:"));
  const auto ticks = shown ? shown : ticksOf(message.word(" pkt_dts:"));
  if (ticks) read_ticks_ = std::max(read_ticks_.value_or(*ticks), *ticks);
  for (; num_gaps_ < facts_.gaps.size() && facts_.gaps[num_gaps_].packet == num_packets_; ++num_gaps_) {
    ++num_lost_;
    if (!facts_.gaps[num_gaps_].is_fresh) noteFlaw();
  }
  ++num_packets_;
}

// [Parsed_showinfo_1 @ 0x55d4] [info] n:   0 pts:      0 pts_time:0 fmt:gray sar:1/1 s:848x480 i:P iskey:1
void DecoderLog::announce(const Message& message) {
  const std::string_view format = message.word(" fmt:");
  const std::vector<std::string_view> size = split(message.word(" s:"), 'x');
  Frame next{.ticks = ticksOf(message.word(" pts:")),
             .size = {parseInt(size.front()).value_or(0), parseInt(size.back()).value_or(0)},
             .depth = depthOf(format),
             .high_byte = format.ends_with("be") ? 0 : 1,
             .is_interlaced = message.word(" i:") != "P"};
  if (decoded_.empty() || next.depth == 0 || next.size.width <= 0 || next.size.height <= 0)
    throw videoProgramError(path_, "ffmpeg", "a line of an unknown form", std::string(message.text));
  if (format_.empty()) format_ = format;
  if (format != format_)
    throw videoError(path_, "pixels whose bits change from " + format_ + " to " + std::string(format));
  const Decoded& known = decoded_.front();
  next.num_lost = known.num_lost;
  const bool is_later = !next.ticks || !known.repaired_ticks || *next.ticks > *known.repaired_ticks;
  const bool is_fresh = message.word(" iskey:") == "1" && is_later;
  is_repaired_ = facts_.are_all_key ? known.is_flawed : (is_repaired_ || known.is_flawed) && !is_fresh;
  next.is_intact = !is_repaired_;
  decoded_.pop_front();
  frames.push_back(next);
}

}  // namespace alidade
