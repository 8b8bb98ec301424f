// SPDX-License-Identifier: MIT
#include "alidade/imagery/video_program.h"

#include <array>
#include <cerrno>
#include <string_view>
#include <system_error>
#include <utility>

#include <boost/algorithm/string/predicate.hpp>

#include "alidade/core/size_groups.h"
#include "alidade/core/text.h"

namespace alidade {
namespace {

// Containers that consist of one file. Others name further files or addresses to read.
constexpr const char* kContainers =
    "mov,matroska,avi,mpegts,mpeg,asf,flv,ogg,mxf,yuv4mpegpipe,h264,hevc,mjpeg,m4v";

ChildProcess start(const std::vector<std::string>& command, const std::string& path) {
  // Enough for the 17 largest frames that a decoder holds.
  constexpr std::size_t kMaxBytes = std::size_t{8} << 30U;
  try {
    return {command, kMaxBytes};
  } catch (const std::system_error& error) {
    const bool is_missing = error.code().value() == ENOENT;
    throw inputError(
        {.where = path,
         .found = is_missing ? "the program " + command.front() + ", which reads videos, was not found"
                             : "the program " + command.front() +
                                   ", which reads videos, cannot be started (" + error.code().message() + ")",
         .expected = "FFmpeg's programs ffmpeg and ffprobe, of version 4.4 or later, in PATH",
         .next_step = "install them (Debian, Ubuntu: sudo apt install ffmpeg)"});
  }
}

}  // namespace

Error videoError(const std::string& path, std::string found) {
  return inputError(
      {.where = path,
       .found = std::move(found),
       .expected = "a video (MP4, MOV, AVI, Matroska, WebM, MPEG and others)",
       .next_step = "play it in a video player; copy or record it again, or convert it: ffmpeg -i '" + path +
                    "' -c:v libx264 -crf 10 converted.mp4"});
}

void checkFrameSize(const std::string& path, ImageSize size, std::int64_t max_pixels) {
  if (std::int64_t{size.width} * size.height <= max_pixels) return;
  throw inputError({.where = path,
                    .found = "frames of " + sizeText(size) + " pixels",
                    .expected = "at most " + std::to_string(max_pixels) + " pixels in a frame",
                    .next_step = "check that the file is not damaged, or make the video smaller"});
}

Error videoProgramError(const std::string& path, const std::string& program, const std::string& failure,
                        const std::string& messages) {
  const std::string message(split(trim(messages), '\n').front());
  return inputError({.where = path,
                     .found = "the program " + program + ", which reads the video, ended with " +
                              (failure.empty() ? "nothing to show" : failure) +
                              (message.empty() ? "" : ": " + message),
                     .expected = "a video that can be decoded completely",
                     .next_step = "try it again; if it fails in the same way, check that '" + program +
                                  " -version' works, or convert the video elsewhere"});
}

ChildProcess openByProgram(const std::string& program, const std::string& path,
                           const std::vector<std::string>& options_before_input,
                           const std::vector<std::string>& options_after_input) {
  // A table of a kilobyte may claim a billion frames; this limit allows fifty hours, and frames of 8192x8192.
  constexpr std::int64_t kMaxAllocation = std::int64_t{130} << 20U;
  std::vector<std::string> command = {program,
                                      "-hide_banner",
                                      "-max_alloc",
                                      std::to_string(kMaxAllocation),
                                      "-format_whitelist",
                                      kContainers,
                                      "-protocol_whitelist",
                                      "file",
                                      "-max_streams",
                                      "32"};  // each may have large tables
  command.insert(command.end(), options_before_input.begin(), options_before_input.end());
  // Judged by content alone, a stream of JPEG images looks like a single image.
  if (boost::iends_with(path, ".mjpeg")) command.insert(command.end(), {"-f", "mjpeg"});
  // With the protocol, because a name may contain a colon or begin with a dash.
  command.insert(command.end(), {"-i", "file:" + path});
  command.insert(command.end(), options_after_input.begin(), options_after_input.end());
  return start(command, path);
}

std::string videoDecoderVersion(const std::string& path) {
  ChildProcess program = start({"ffmpeg", "-version"}, path);
  std::string output;
  std::string messages;
  std::array<char, 4096> block{};
  while (!program.isOutputAtEnd() || !program.areMessagesAtEnd())
    output.append(block.data(), program.read(block.data(), block.size(), messages, nullptr));
  const std::string failure = program.failure();
  const std::vector<std::string_view> words = split(split(output, '\n').front(), ' ');
  if (!failure.empty() || words.size() < 3) throw videoProgramError(path, "ffmpeg", failure, messages);
  return std::string(words[2]);
}

}  // namespace alidade
