// SPDX-License-Identifier: MIT
#include "alidade/imagery/video_probe.h"

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <map>
#include <string_view>
#include <utility>

#include "alidade/core/text.h"
#include "alidade/imagery/video_program.h"

namespace alidade {
namespace {

// A line of ffprobe's "compact" output: section|key=value|key=value. Of nested keys, as in
// disposition:default, the last part counts, because what comes before differs between versions.
class Section {
 public:
  explicit Section(std::string_view line) {
    const std::vector<std::string_view> parts = split(line, '|');
    name_ = parts.front();
    for (const std::string_view part : parts) {
      const std::size_t equals = part.find('=');
      if (equals == std::string_view::npos) continue;
      const std::string_view key = part.substr(0, equals);
      values_.emplace_back(key.substr(key.rfind(':') + 1), part.substr(equals + 1));
    }
  }

  [[nodiscard]] std::string_view name() const { return name_; }
  [[nodiscard]] std::string_view text(std::string_view key) const {
    const auto found = std::ranges::find(values_, key, &std::pair<std::string_view, std::string_view>::first);
    return found == values_.end() ? std::string_view() : found->second;
  }
  [[nodiscard]] std::optional<std::int64_t> number(std::string_view key) const {
    const std::string_view digits = text(key);
    std::int64_t value = 0;
    const auto [end, error] = std::from_chars(digits.data(), digits.data() + digits.size(), value);
    return error == std::errc() && end == digits.data() + digits.size() ? std::optional(value) : std::nullopt;
  }

 private:
  std::string_view name_;
  std::vector<std::pair<std::string_view, std::string_view>> values_;
};

// A ratio of whole numbers, as "1/15360".
double ratioOf(std::string_view text) {
  const std::vector<std::string_view> parts = split(text, '/');
  const double over = parseDouble(parts.front()).value_or(0);
  const double under = parseDouble(parts.back()).value_or(0);
  return parts.size() == 2 && under > 0 ? over / under : 0;
}

// FFmpeg measures rotations counter-clockwise.
int exifOrientationOf(std::int64_t rotation) {
  constexpr std::array<int, 4> kExif = {1, 6, 3, 8};
  const auto quarters = std::lround(-static_cast<double>(rotation % 360) / 90.0);
  return kExif[static_cast<std::size_t>((quarters + 4) % 4)];
}

class Probe {
 public:
  Probe(const std::string& path, std::int64_t max_pixels) : path_(path), max_pixels_(max_pixels) {
    std::error_code error;
    num_file_bytes_ = static_cast<std::int64_t>(std::filesystem::file_size(path, error));
    std::array<char, 4> head{};
    std::ifstream(path, std::ios::binary).read(head.data(), head.size());
    is_matroska_ = std::string_view(head.data(), head.size()) == "\x1A\x45\xDF\xA3";
  }

  void add(const Section& section) {
    if (section.name() == "packet") addPacket(section);
    if (section.name() == "program_version") facts_.program_version = section.text("version");
    if (section.name() == "stream") addStream(section);
    // Version 4 gives side data a line of their own.
    const auto rotation = section.number("rotation");
    if (rotation && is_best_stream_) facts_.exif_orientation = exifOrientationOf(*rotation);
    if (section.name() == "format") addFormat(section);
  }

  [[nodiscard]] bool isComplete() const { return is_complete_; }

  VideoFacts facts() {
    if (!rank_) throw videoError(path_, "no pictures in the file");
    Track& pictures = tracks_[facts_.stream];
    if (pictures.num_gaps < num_gaps_) pictures.gaps.push_back({.packet = pictures.num_packets});
    facts_.gaps = std::move(pictures.gaps);
    facts_.are_all_key = pictures.are_all_key;
    for (const auto& [stream, track] : tracks_)
      facts_.reached_seconds = std::max(facts_.reached_seconds, track.endSeconds() - start_seconds_);
    return std::move(facts_);
  }

 private:
  struct Track {
    std::size_t num_packets = 0;
    std::size_t num_gaps = 0;  // of the file, before the last packet
    std::vector<VideoFacts::Gap> gaps;
    bool are_all_key = true;
    std::size_t num_timed = 0;
    std::int64_t first = 0;
    std::int64_t last = 0;
    std::int64_t end = 0;
    double seconds_per_tick = 0;

    // The last frame lasts as long as the others, if nothing else is known.
    [[nodiscard]] double endSeconds() const {
      const auto span = static_cast<double>(last - first);
      const double gap = num_timed > 1 ? span / static_cast<double>(num_timed - 1) : 0;
      return std::max(static_cast<double>(end), static_cast<double>(last) + gap) * seconds_per_tick;
    }
  };

  void addPacket(const Section& packet) {
    const std::int64_t size = packet.number("size").value_or(0);
    ++num_packets_;
    num_packet_bytes_ += size;
    checkExtent();
    if (const auto position = packet.number("pos"); is_matroska_ && position) {
      // FFmpeg silently skips damaged structure to the next intact part. The packets of an intact file follow
      // each other with only short headers between them.
      constexpr std::int64_t kMostHeaders = 512;
      if (end_position_ > 0 && *position > end_position_ + kMostHeaders) ++num_gaps_;
      end_position_ = std::max(end_position_, *position + size);
    }
    Track& track = tracks_[packet.number("stream_index").value_or(-1)];
    const bool is_key = packet.text("flags").starts_with('K');
    track.are_all_key = track.are_all_key && is_key;
    if (std::exchange(track.num_gaps, num_gaps_) < num_gaps_)
      track.gaps.push_back({.packet = track.num_packets, .is_fresh = is_key});
    ++track.num_packets;
    const auto shown = packet.number("pts");
    const auto time = shown ? shown : packet.number("dts");
    if (!time) return;
    if (track.num_timed++ == 0) track.first = track.last = *time;
    track.first = std::min(track.first, *time);
    track.last = std::max(track.last, *time);
    track.end = std::max(track.end, *time + packet.number("duration").value_or(0));
  }

  // Each byte of a file is normally read about once. Tables that list the same data repeatedly would turn a
  // small file into an endless video. Matroska has no such tables, but may be compressed.
  void checkExtent() const {
    constexpr std::int64_t kMostReadings = 4;
    constexpr std::int64_t kSlack = 1 << 20;
    const bool is_too_much = num_packet_bytes_ > kMostReadings * num_file_bytes_ + kSlack;
    if (!(is_too_much && !is_matroska_) && num_packets_ <= num_file_bytes_) return;
    throw videoError(path_, "the video is damaged: it gives more data than the file holds");
  }

  void addStream(const Section& stream) {
    const std::int64_t index = stream.number("index").value_or(-1);
    tracks_[index].seconds_per_tick = ratioOf(stream.text("time_base"));
    is_best_stream_ = false;
    if (stream.text("codec_type") != "video") return;
    const ImageSize size{static_cast<int>(stream.number("width").value_or(0)),
                         static_cast<int>(stream.number("height").value_or(0))};
    checkFrameSize(path_, size, max_pixels_);
    // A picture of the cover is a video stream, too. Of several videos, the one with more data is better.
    const std::pair<std::int64_t, std::int64_t> rank = {
        stream.number("default").value_or(0) - 2 * stream.number("attached_pic").value_or(0),
        stream.number("bit_rate").value_or(0)};
    if (rank_ && rank <= *rank_) return;
    rank_ = rank;
    is_best_stream_ = true;
    facts_.exif_orientation = 1;
    facts_.stream = static_cast<int>(index);
    facts_.codec = stream.text("codec_name");
    facts_.pixel_format = stream.text("pix_fmt");
    facts_.seconds_per_tick = tracks_[index].seconds_per_tick;
    facts_.start_ticks = stream.number("start_pts");
    facts_.stated_frames =
        static_cast<std::size_t>(std::max<std::int64_t>(stream.number("nb_frames").value_or(0), 0));
    const std::vector<std::string_view> rate = split(stream.text("avg_frame_rate"), '/');
    const double frames = parseDouble(rate.front()).value_or(0);
    const double seconds = parseDouble(rate.back()).value_or(0);
    facts_.frame_rate_hz = rate.size() == 2 && frames > 0 && seconds > 0 ? frames / seconds : 0;
    of_stream_ = static_cast<double>(stream.number("duration_ts").value_or(0)) * facts_.seconds_per_tick;
  }

  void addFormat(const Section& format) {
    is_complete_ = true;
    const std::string_view name = format.text("format_name");
    facts_.container = name;
    // In Matroska the stated duration counts from 0.
    if (!is_matroska_) start_seconds_ = parseDouble(format.text("start_time")).value_or(0);
    if (name == "mpegts" || name == "mpeg") return;  // nothing is stated: the duration is the last time stamp
    const double of_file = parseDouble(format.text("duration")).value_or(0);
    // For a truncated file, FFmpeg reduces the duration, but not the number of frames. One frame is one tick
    // here.
    if (name == "avi" && facts_.stated_frames > 0)
      facts_.stated_seconds = static_cast<double>(facts_.stated_frames) * facts_.seconds_per_tick;
    else if (of_stream_ > 0 && of_file > 0)
      facts_.stated_seconds = std::min(of_stream_, of_file);  // edit lists may hide frames
    else
      facts_.stated_seconds = std::max({of_stream_, of_file, 0.0});
  }

  std::string path_;
  std::int64_t max_pixels_;
  std::int64_t num_file_bytes_ = 0;
  bool is_matroska_ = false;
  bool is_complete_ = false;
  std::map<std::int64_t, Track> tracks_;
  std::int64_t num_packets_ = 0;
  std::int64_t num_packet_bytes_ = 0;
  std::int64_t end_position_ = 0;  // in the file, after the packets so far
  std::size_t num_gaps_ = 0;
  std::optional<std::pair<std::int64_t, std::int64_t>> rank_;  // of the best video stream so far
  bool is_best_stream_ = false;                                // the last stream is that one
  double of_stream_ = 0;                                       // its stated seconds
  double start_seconds_ = 0;
  VideoFacts facts_;
};

}  // namespace

VideoFacts probeVideo(const std::string& path, std::int64_t max_pixels, const CancelFlag* cancel) {
  ChildProcess program = openByProgram(
      "ffprobe", path,
      {"-v", "warning", "-of", "compact", "-show_entries",
       "program_version=version:packet=stream_index,pts,dts,duration,size,pos,flags:stream=index,codec_type,"
       "codec_name,width,height,pix_fmt,time_base,start_pts,duration_ts,nb_frames,avg_frame_rate,bit_rate:stream_disposition="
       "default,attached_pic:stream_side_data_list:format=format_name,start_time,duration"},
      {});
  Probe probe(path, max_pixels);
  std::string lines;
  std::string messages;
  std::array<char, 65536> block{};
  while (!program.isOutputAtEnd() || !program.areMessagesAtEnd()) {
    lines.append(block.data(), program.read(block.data(), block.size(), messages, cancel));
    std::size_t begin = 0;
    for (std::size_t end = 0; (end = lines.find('\n', begin)) != std::string::npos; begin = end + 1)
      probe.add(Section(std::string_view(lines).substr(begin, end - begin)));
    lines.erase(0, begin);
  }
  const std::string failure = program.failure();
  if (failure.empty() && probe.isComplete()) {
    VideoFacts facts = probe.facts();
    if (messages.find("Estimating duration from bitrate") != std::string::npos) facts.stated_seconds = 0;
    return facts;
  }
  // "file:clip.mp4: Invalid data found when processing input"
  const std::string opening = "file:" + path + ": ";
  const std::size_t at = messages.rfind(opening);
  if (at == std::string::npos) throw videoProgramError(path, "ffprobe", failure, messages);
  const std::string_view reason = trim(std::string_view(messages).substr(at + opening.size()));
  throw videoError(path, "the video cannot be opened (" + std::string(reason) + ")");
}

}  // namespace alidade
