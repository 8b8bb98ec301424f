// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "alidade/core/error.h"
#include "alidade/core/image.h"
#include "alidade/imagery/child_process.h"

namespace alidade {

[[nodiscard]] Error videoError(const std::string& path, std::string found);

/// @throws Error (kInput) for frames of more than so many pixels
void checkFrameSize(const std::string& path, ImageSize size, std::int64_t max_pixels);

/// The error of a program of FFmpeg that did not do its work. `failure` is ChildProcess::failure(), and
/// `messages` is what it said, of which the first line is shown.
[[nodiscard]] Error videoProgramError(const std::string& path, const std::string& program,
                                      const std::string& failure, const std::string& messages);

/// Starts FFmpeg's program "ffmpeg" or "ffprobe", which opens the video. It reads no other files, and damaged
/// headers can make it request only so much memory. @throws Error (kInput) if it is not in PATH
[[nodiscard]] ChildProcess openByProgram(const std::string& program, const std::string& path,
                                         const std::vector<std::string>& options_before_input,
                                         const std::vector<std::string>& options_after_input);

/// The version of ffmpeg, as in "5.1.9-0+deb12u1". `path` is the video, for messages.
/// @throws Error (kInput) if the program is not in PATH or does not work
[[nodiscard]] std::string videoDecoderVersion(const std::string& path);

}  // namespace alidade
