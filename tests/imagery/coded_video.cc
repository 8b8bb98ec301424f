// SPDX-License-Identifier: MIT
#include "imagery/coded_video.h"

#include <array>
#include <filesystem>
#include <fstream>
#include <stdexcept>
#include <string_view>
#include <vector>

#include "alidade/imagery/child_process.h"

namespace alidade {
namespace {

// What it prints. @throws std::runtime_error if it fails
std::string outputOf(const std::vector<std::string>& command) {
  constexpr std::size_t kMaxBytes = std::size_t{8} << 30U;
  ChildProcess program(command, kMaxBytes);
  std::string output;
  std::string messages;
  std::array<char, 4096> block{};
  while (!program.isOutputAtEnd() || !program.areMessagesAtEnd())
    output.append(block.data(), program.read(block.data(), block.size(), messages, nullptr));
  if (const std::string failure = program.failure(); !failure.empty())
    throw std::runtime_error(command.front() + " ended with " + failure + ": " + messages);
  return output;
}

// The raw frames of a video, in those of FFmpeg's pixel formats that tests use.
class RawFrames {
 public:
  explicit RawFrames(const CodedVideo& video) : video_(video) {
    for (int i = 0; i < video.num_frames; ++i) addFrame(i);
  }
  [[nodiscard]] const std::string& bytes() const { return bytes_; }

 private:
  [[nodiscard]] bool isNamed(std::string_view part) const {
    return video_.pixel_format.find(part) != std::string::npos;
  }
  // Bits of "gray12le" and "yuv420p10le".
  [[nodiscard]] int depth() const {
    if (!video_.pixel_format.ends_with("le")) return 8;
    return std::stoi(video_.pixel_format.substr(video_.pixel_format.size() - 4));
  }
  void add(unsigned value) {
    bytes_ += static_cast<char>(value & 0xFFU);
    if (depth() > 8) bytes_ += static_cast<char>(value >> 8U);
  }
  void addFrame(int number) {
    const auto [width, height] = video_.size;
    const unsigned grey = 1U << static_cast<unsigned>(depth() - 1);
    const int num_planes = isNamed("gbrp") ? 3 : 1;
    for (int plane = 0; plane < num_planes; ++plane) {
      for (int y = 0; y < height; ++y) {
        for (int x = 0; x < width; ++x) {
          const unsigned value = video_.sample(x, y, number);
          if (isNamed("uyvy")) add(grey);
          for (int i = 0; i < (isNamed("bgr0") ? 4 : 1); ++i) add(value);
          if (isNamed("yuyv")) add(grey);
        }
      }
    }
    const bool has_chroma_planes = isNamed("yuv4") || isNamed("yuvj4") || isNamed("nv12");
    const int num_chroma = !has_chroma_planes                  ? 0
                           : isNamed("420") || isNamed("nv12") ? width * height / 2
                                                               : 2 * width * height;
    for (int i = 0; i < num_chroma; ++i) add(grey);
  }

  const CodedVideo& video_;
  std::string bytes_;
};

}  // namespace

std::string writeVideo(const std::string& path, const CodedVideo& video) {
  const std::string raw = path + ".raw";
  std::ofstream(raw, std::ios::binary) << RawFrames(video).bytes();
  std::vector<std::string> command = {
      "ffmpeg",     "-v",
      "error",      "-y",
      "-f",         "rawvideo",
      "-pix_fmt",   video.pixel_format,
      "-s",         std::to_string(video.size.width) + "x" + std::to_string(video.size.height),
      "-framerate", std::to_string(video.frames_per_second),
      "-i",         raw,
      "-c:v",       video.codec,
      "-g",         "12",
      "-bf",        "0",
      "-threads",   "1",
      "-strict",    "unofficial",
      "-q:v",       std::to_string(video.quality)};
  if (video.is_header_first) command.insert(command.end(), {"-movflags", "faststart"});
  command.insert(command.end(), video.options.begin(), video.options.end());
  command.push_back("file:" + path);
  (void)outputOf(command);
  std::filesystem::remove(raw);
  return path;
}

bool hasEncoder(const std::string& name) {
  return outputOf({"ffmpeg", "-v", "error", "-encoders"}).find(" " + name + " ") != std::string::npos;
}

}  // namespace alidade
