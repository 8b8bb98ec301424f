// SPDX-License-Identifier: MIT
#pragma once

#include <span>
#include <string>
#include <vector>

namespace alidade::detail {

/// A node at the top of a file of OpenCV's FileStorage: a whole number, a real one, or a matrix row by row.
struct OpenCvNode {
  std::string key;
  int whole = 0;
  int rows = 0;  ///< 0 = a number: the first of the values, or if there are none `whole`
  int columns = 0;
  std::vector<double> values = {};
};

/// The three forms of the same file.
[[nodiscard]] std::string openCvYaml(std::span<const OpenCvNode> nodes);
[[nodiscard]] std::string openCvXml(std::span<const OpenCvNode> nodes);
[[nodiscard]] std::string openCvJson(std::span<const OpenCvNode> nodes);

}  // namespace alidade::detail
