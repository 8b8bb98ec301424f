// SPDX-License-Identifier: MIT
#pragma once

#include <span>
#include <string>
#include <vector>

#include "flags.h"

// Where commands write, checked before any long work.

namespace alidade {

/// A flag for a file to write, and the path that was given.
struct Output {
  std::string flag;
  std::string path;          ///< empty: not given
  std::string example = {};  ///< of a good name
};

/// Checks that each output can be written, is no other's and would overwrite none of the sources. Only the
/// output of --output may be standard output ("-"), which --json has for itself.
/// @param sources  anything that was given; what is not the path of a file is left aside
/// @param num_checked  so many first outputs were checked before, with other sources
/// @throws Error (kUsage, kInput)
void checkOutputs(std::span<const Output> outputs, const std::vector<std::string>& sources,
                  const CommonOptions& options, std::size_t num_checked = 0);
inline void checkOutput(const std::string& path, const std::vector<std::string>& sources,
                        const CommonOptions& options) {
  const Output output{.flag = "--output", .path = path};
  checkOutputs({&output, 1}, sources, options);
}

/// `inputs` and the images that they stand for. Without the images if the inputs are at fault: reading them
/// says how.
[[nodiscard]] std::vector<std::string> withImages(std::vector<std::string> inputs);

/// "camera.yaml was not written", and whether an older file of that name is still there.
[[nodiscard]] std::string notWritten(const std::string& output);

/// Tells that the answer is no and, unless it was kept, that `output` (may be empty) was not written.
void printRefusal(const std::string& claim, const std::string& output, bool is_kept);

}  // namespace alidade
