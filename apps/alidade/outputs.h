// SPDX-License-Identifier: MIT
#pragma once

#include <span>
#include <string>
#include <vector>

#include "flags.h"

// Outputs of commands, checked before any long work.

namespace alidade {

/// A flag for an output file, and the given path.
struct Output {
  std::string flag;
  std::string path;          ///< empty if not given
  std::string example = {};  ///< of a good name
};

/// Checks that each output can be written, differs from the others and would overwrite none of the sources.
/// Only --output may be standard output ("-"), and only without --json.
/// @param sources  any inputs; those that are not file paths are ignored
/// @param num_checked  number of leading outputs that were already checked, with other sources
/// @throws Error (kUsage, kInput)
void checkOutputs(std::span<const Output> outputs, const std::vector<std::string>& sources,
                  const CommonOptions& options, std::size_t num_checked = 0);
inline void checkOutput(const std::string& path, const std::vector<std::string>& sources,
                        const CommonOptions& options) {
  const Output output{.flag = "--output", .path = path};
  checkOutputs({&output, 1}, sources, options);
}

/// `inputs` and their images. Without the images if the inputs are invalid; reading them reports the error.
[[nodiscard]] std::vector<std::string> withImages(std::vector<std::string> inputs);

/// "camera.yaml was not written", and whether an older file with that name exists.
[[nodiscard]] std::string notWritten(const std::string& output);

/// Reports a negative answer and, unless it was kept, that `output` (may be empty) was not written.
void printRefusal(const std::string& claim, const std::string& output, bool is_kept);

}  // namespace alidade
