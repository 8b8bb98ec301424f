// SPDX-License-Identifier: MIT
#pragma once

#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "alidade/files/formats/stated_camera.h"
#include "alidade/files/yaml_node.h"

namespace alidade::detail {

/// A number as a text states it: never better than half a unit of its last digit. A whole number without a
/// point is taken as exact.
struct StatedNumber {
  double value = 0;
  double half_unit = 0;
};

/// Do two texts say the same number, as far as their digits go?
[[nodiscard]] bool isSameStated(const StatedNumber& a, const StatedNumber& b);
/// The same of lists of the same length.
[[nodiscard]] bool isSameStated(std::span<const StatedNumber> a, std::span<const StatedNumber> b);

/// @returns nothing if `text` is not a finite number
[[nodiscard]] std::optional<StatedNumber> parseStated(std::string_view text);

/// @throws Error (kInput) if the node is no finite number
[[nodiscard]] StatedNumber statedNumber(const YamlNode& node);
/// The numbers of a list, of a list of lists row by row, or of a map {rows, cols, data} as OpenCV and ROS
/// write matrices. @throws Error (kInput) also where rows and columns do not go with the number of data, and
/// for more numbers than any lens has
[[nodiscard]] std::vector<StatedNumber> statedNumbers(const YamlNode& node);
[[nodiscard]] std::vector<StatedNumber> statedNumbers(const YamlNode& node, std::size_t count);

/// fx, fy, cx, cy of a camera matrix [fx 0 cx; 0 fy cy; 0 0 1].
/// @throws Error (kInput) if it is transposed, or is no camera matrix; UnsupportedCamera if it has skew
[[nodiscard]] std::vector<StatedNumber> readCameraMatrix(const YamlNode& node);

/// The values of these keys of a map; each must be there. @throws Error (kInput)
[[nodiscard]] std::vector<StatedNumber> numbersOf(const YamlNode& map, std::span<const std::string> keys);

/// A width and a height in pixels, checked. @throws Error (kInput)
[[nodiscard]] ImageSize readSize(const YamlNode& width, const YamlNode& height);
/// The same from a list of two.
[[nodiscard]] ImageSize readSize(const YamlNode& list);

/// The camera of these parameters, in storage order. @throws Error (kInput), with the place, where they are
/// no camera
[[nodiscard]] StatedCamera stateCamera(const std::string& place, std::string name, std::string_view model,
                                       std::span<const StatedNumber> parameters,
                                       std::optional<ImageSize> image_size);

/// Appends what is in `more`.
void append(std::vector<StatedNumber>& numbers, std::span<const StatedNumber> more);

/// A remark if the map has other keys than these.
void remarkUnknownKeys(const YamlNode& map, const std::vector<std::string>& known, StatedCamera& camera);

/// A remark if one of these keys says something that a camera alone does not hold: poses, times, noise.
/// Zeros, empty values and unit matrices say nothing.
void remarkNotCarried(const YamlNode& map, const std::vector<std::string>& keys, StatedCamera& camera);

}  // namespace alidade::detail
