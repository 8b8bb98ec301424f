// SPDX-License-Identifier: MIT
#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "alidade/core/image.h"

namespace alidade {

/// What a camera of an example is, worked out by hand: parameters in storage order, pixel (0, 0) the centre
/// of the top-left one.
struct ExampleCamera {
  std::string name;
  std::string_view model;
  ImageSize size;
  std::vector<double> parameters;
};

/// A file as its tool writes it.
struct FormatExample {
  std::string_view format;
  std::string name;  ///< for messages
  std::string text;
  std::vector<ExampleCamera> cameras;
  std::vector<std::string> remarks = {};  ///< ids of those on its first camera, in order
};

/// Files by relatives of the programs that the formats are named after, which differ from these in keys.
[[nodiscard]] std::vector<FormatExample> dialectExamples();

/// The files of docs/examples/formats of formats that are only read.
[[nodiscard]] std::vector<FormatExample> smallExamples();

/// At least one of each format; of each lens that a format has a name for; with the dialects.
[[nodiscard]] const std::vector<FormatExample>& formatExamples();

}  // namespace alidade
