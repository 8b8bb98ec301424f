// SPDX-License-Identifier: MIT
#include "alidade/imagery/video_reader.h"

#include <algorithm>
#include <array>
#include <charconv>
#include <filesystem>
#include <optional>
#include <string_view>
#include <system_error>
#include <utility>
#include <vector>

#include <boost/algorithm/string/predicate.hpp>

#include "alidade/core/error.h"
#include "alidade/core/text.h"
#include "alidade/files/text/atomic_file.h"
#include "alidade/imagery/decoder_log.h"
#include "alidade/imagery/video_probe.h"
#include "alidade/imagery/video_program.h"

namespace alidade {
namespace {

constexpr std::array<std::string_view, 20> kExtensions = {
    ".mp4",  ".m4v", ".mov", ".avi", ".mkv", ".webm", ".mpg", ".mpeg", ".ts",  ".mts",
    ".m2ts", ".wmv", ".flv", ".ogv", ".mxf", ".3gp",  ".y4m", ".264",  ".265", ".mjpeg"};

// The filter that makes luma or grey of pixels. Version 4 cannot extract the only plane of deep grey.
std::string grayFilter(std::string_view pixel_format) {
  constexpr std::array<std::string_view, 9> kColours = {"rgb",   "bgr", "gbr", "pal8", "mono",
                                                        "bayer", "xyz", "f16", "f32"};
  const bool is_colour = std::ranges::any_of(
      kColours, [&](std::string_view part) { return pixel_format.find(part) != std::string_view::npos; });
  // With 16 bits, because dithering to 8 bits would add noise to pixels with more bits.
  if (is_colour) return "scale=flags=neighbor+accurate_rnd,format=gray16le,";
  if (pixel_format.starts_with("gray") && pixel_format.size() > 4) return "";
  const bool is_planar =
      pixel_format.starts_with("yuv") || pixel_format.starts_with("ya") || pixel_format == "gray";
  return is_planar ? "extractplanes=y,"
                   : "scale=in_range=tv:out_range=tv,format=yuv444p16le,extractplanes=y,";
}

// The first two numbers of "5.1.9-0+deb12u1" or "n7.1". Builds without a number are recent ones.
std::pair<int, int> versionOf(std::string_view text) {
  constexpr std::pair<int, int> kRecent = {99, 0};
  if (text.starts_with('n')) text.remove_prefix(1);
  std::array<int, 2> numbers{};
  for (int& number : numbers) {
    const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), number);
    if (error != std::errc()) return kRecent;
    text.remove_prefix(std::min(text.size(), static_cast<std::size_t>(end - text.data()) + 1));
  }
  return {numbers[0], numbers[1]};
}

ChildProcess startDecoder(const std::string& path, const VideoFacts& facts, const VideoOptions& options) {
  const std::pair<int, int> version = versionOf(facts.program_version);
  std::vector<std::string> before = {
      "-nostdin", "-nostats", "-loglevel", "repeat+level+info", "-debug_ts", "-copyts", "-noautorotate",
      "-filter_threads", "1", "-max_pixels:v", std::to_string(options.max_pixels),
      // All checks: otherwise, most damage is repaired silently.
      "-err_detect:v", "crccheck+bitstream+buffer+explode", "-max_error_rate", "1",
      // With several frames at once, errors would be reported for later frames.
      "-thread_type:v", "slice"};
  // With several slices at once, the H.264 decoder does not check for missing parts.
  if (facts.codec == "h264") before.insert(before.end(), {"-threads:v", "1"});
  if (version >= std::pair(7, 1)) before.insert(before.end(), {"-apply_cropping:v", "codec"});
  std::vector<std::string> after = {"-map",
                                    "0:" + std::to_string(facts.stream),
                                    "-vf",
                                    grayFilter(facts.pixel_format) + "sidedata=delete,showinfo=checksum=0",
                                    "-noautoscale",
                                    "-map_metadata",
                                    "-1",
                                    "-map_metadata:s:v",
                                    "-1"};
  const bool is_old = version < std::pair(5, 1);
  after.insert(after.end(),
               {is_old ? "-vsync" : "-fps_mode", is_old ? "0" : "passthrough", "-f", "rawvideo", "pipe:1"});
  return openByProgram("ffmpeg", path, before, after);
}

std::uint8_t roundedTo8Bits(unsigned sample, int depth) {
  const int excess = depth - 8;
  const unsigned half = excess > 0 ? 1U << static_cast<unsigned>(excess - 1) : 0;
  return static_cast<std::uint8_t>(std::min((sample + half) >> static_cast<unsigned>(excess), 255U));
}

}  // namespace

struct VideoReader::State {
  State(std::string file, const VideoOptions& wanted)
      : path(std::move(file)),
        options(wanted),
        facts(probeVideo(path, options.max_pixels, options.cancel)),
        log(path, facts),
        program(startDecoder(path, facts, options)) {}

  std::string path;
  VideoOptions options;
  VideoFacts facts;
  DecoderLog log;
  ChildProcess program;
  DecoderLog::Frame frame;
  std::vector<std::uint8_t> samples;  // of the frame
  std::size_t num_frames = 0;
  bool is_over = false;

  // Reads up to so many bytes of pixels, and what the program says.
  std::size_t read(std::uint8_t* data, std::size_t size) {
    std::string messages;
    const std::size_t count = program.read(reinterpret_cast<char*>(data), size, messages, options.cancel);
    log.add(messages);
    return count;
  }

  bool advance() {
    while (log.frames.empty()) {
      if (program.areMessagesAtEnd()) return finish(false);
      read(nullptr, 0);
    }
    frame = log.frames.front();
    log.frames.pop_front();
    checkFrameSize(path, frame.size, options.max_pixels);
    samples.resize(static_cast<std::size_t>(frame.size.width) * static_cast<std::size_t>(frame.size.height) *
                   (frame.depth > 8 ? 2 : 1));
    for (std::size_t done = 0; done < samples.size();) {
      if (program.isOutputAtEnd()) return finish(true);
      done += read(samples.data() + done, samples.size() - done);
    }
    ++num_frames;
    return true;
  }

  // Always false. After a crash it is unknown what would have come, so that is an error.
  bool finish(bool is_in_frame) {
    if (std::exchange(is_over, true)) return false;
    const auto fail = [&](const std::string& how) {
      throw videoProgramError(path, "ffmpeg", how, log.firstComplaint());
    };
    std::uint8_t surplus = 0;
    while (!program.areMessagesAtEnd() || !program.isOutputAtEnd()) {
      if (read(&surplus, 1) > 0) fail("more pixels than it announced");
    }
    const std::string failure = program.failure();
    // It calls it a failure, too, if nothing could be decoded.
    const bool is_nothing_decoded =
        num_frames == 0 && log.numLostAtEnd() > 0 && failure.starts_with("status");
    if (!failure.empty() && !is_nothing_decoded) fail(failure);
    if (is_in_frame) fail("fewer pixels than it announced");
    return false;
  }

  [[nodiscard]] GrayImage grayImage() const {
    GrayImage gray{.size = frame.size, .pixels = {}};
    if (frame.depth == 8) {
      gray.pixels = samples;
      return gray;
    }
    gray.pixels.resize(samples.size() / 2);
    const std::uint8_t* sample = samples.data();
    for (std::uint8_t& pixel : gray.pixels) {
      const auto high = static_cast<unsigned>(sample[frame.high_byte]);
      pixel = roundedTo8Bits(high << 8U | sample[1 - frame.high_byte], frame.depth);
      sample += 2;
    }
    return gray;
  }
};

VideoReader::VideoReader(const std::string& path, const VideoOptions& options) {
  checkVideoFile(path);
  state_ = std::make_unique<State>(path, options);
}

VideoReader::~VideoReader() = default;
VideoReader::VideoReader(VideoReader&&) noexcept = default;
VideoReader& VideoReader::operator=(VideoReader&&) noexcept = default;

bool VideoReader::advance() {
  return state_->advance();
}

std::size_t VideoReader::number() const {
  return state_->num_frames - 1;
}

bool VideoReader::isIntact() const {
  return state_->frame.is_intact;
}

std::size_t VideoReader::numLost() const {
  return state_->is_over ? state_->log.numLostAtEnd() : state_->frame.num_lost;
}

bool VideoReader::isInterlaced() const {
  return state_->frame.is_interlaced;
}

LoadedImage VideoReader::image() const {
  return {.image = state_->grayImage(), .exif_orientation = state_->facts.exif_orientation};
}

std::size_t VideoReader::statedFrames() const {
  return state_->facts.stated_frames;
}

double VideoReader::frameRate() const {
  return state_->facts.frame_rate_hz;
}

double VideoReader::statedSeconds() const {
  return state_->facts.stated_seconds;
}

double VideoReader::missingShare() const {
  const auto shareOf = [](double reached, double stated) {
    return stated > 0 ? std::clamp(1 - reached / stated, 0.0, 1.0) : 1.0;
  };
  if (statedFrames() == 0 && statedSeconds() <= 0) return 0;
  return std::min(
      shareOf(static_cast<double>(state_->num_frames + numLost()), static_cast<double>(statedFrames())),
      shareOf(state_->facts.reached_seconds, statedSeconds()));
}

bool VideoReader::isCut() const {
  return state_->log.isCut();
}

double VideoReader::seconds() const {
  const std::optional<std::int64_t> ticks = state_->frame.ticks;
  if (!ticks) return 0;
  return static_cast<double>(*ticks - state_->facts.start_ticks.value_or(0)) * state_->facts.seconds_per_tick;
}

void checkVideoFile(const std::string& path) {
  std::error_code error;
  const std::filesystem::file_status status = std::filesystem::status(path, error);
  if (!std::filesystem::exists(status)) throw missingPathError(path);
  if (!std::filesystem::is_regular_file(status)) throw videoError(path, "this is no ordinary file");
  if (std::filesystem::file_size(path, error) == 0) throw videoError(path, "the file is empty (0 bytes)");
}

bool hasVideoName(const std::string& path) {
  return std::any_of(kExtensions.begin(), kExtensions.end(),
                     [&](std::string_view extension) { return boost::iends_with(path, extension); });
}

}  // namespace alidade
