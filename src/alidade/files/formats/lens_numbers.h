// SPDX-License-Identifier: MIT
#pragma once

#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "alidade/files/formats/stated_camera.h"
#include "alidade/files/text/yaml_node.h"

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

/// A side of the image, in pixels, as a key of a file may state it.
struct StatedSide {
  std::string key;               ///< "image_width"
  std::optional<YamlNode> node;  ///< nothing: the key is not there
};

/// Sides as keys of `map`.
[[nodiscard]] StatedSide sideOf(const YamlNode& map, const std::string& key);

/// The size of the image in pixels; nothing where neither side is stated. One side alone is not passed over:
/// where `given` (--image-size) says the same of it, that is the size, with a remark.
/// @throws Error (kInput) that names the missing key, where `given` does not help, and for sides that are no
/// numbers of pixels
[[nodiscard]] std::optional<ImageSize> sizeOfSides(const StatedSide& width, const StatedSide& height,
                                                   const std::optional<ImageSize>& given,
                                                   std::vector<Remark>& remarks);

/// A lens as another program lists it.
struct LensLayout {
  std::string_view name;   ///< the program's own name of it
  std::string_view model;  ///< ours
  /// The parameters by our names, in the program's order: "xi fx fy cx cy". "f" is fx and fy alike; what is
  /// not listed is zero.
  std::string_view order;
};

/// The layout of this name; null if there is none.
[[nodiscard]] const LensLayout* findLayout(std::span<const LensLayout> layouts, std::string_view name);

/// The layout that a file names. `advice` is for a name that is not even nearly one of them.
/// @throws UnsupportedCamera with the known names
[[nodiscard]] const LensLayout& layoutNamed(std::span<const LensLayout> layouts, const YamlNode& name,
                                            const std::string& advice);
[[nodiscard]] std::vector<std::string> layoutNames(std::span<const LensLayout> layouts);

/// The first layout that can say a camera of this model; there must be one.
[[nodiscard]] const LensLayout& layoutOf(std::span<const LensLayout> layouts, std::string_view model);

/// From the program's order to ours; `listed` has a number for each name.
[[nodiscard]] std::vector<StatedNumber> storageOrder(const LensLayout& layout,
                                                     std::span<const StatedNumber> listed);

/// From ours to the program's, whose first pixel has its centre at (origin, origin). What the layout does not
/// list is dropped, so it must be zero.
[[nodiscard]] std::vector<double> listedOrder(const LensLayout& layout, const AnyCamera& camera,
                                              double origin = 0);

/// From the origin of a program whose first pixel has its centre at (origin, origin) to ours: the principal
/// point is the third and fourth parameter.
void takeOrigin(std::span<StatedNumber> parameters, double origin);

/// The camera of these parameters, in storage order. @throws Error (kInput), with the place, where they are
/// no camera
[[nodiscard]] StatedCamera stateCamera(const std::string& place, std::string name, std::string_view model,
                                       std::span<const StatedNumber> parameters,
                                       std::optional<ImageSize> image_size, std::vector<Remark> remarks = {});

/// Appends what is in `more`.
void append(std::vector<StatedNumber>& numbers, std::span<const StatedNumber> more);

/// The fewest digits that read back as the same number, with a point before the exponent: readers of YAML 1.1
/// (Python's, and with it Kalibr and ROS) take 1e-05 for a text and 1 for a whole number.
[[nodiscard]] std::string realText(double value);

/// "[1.0, 0.25, -3.0e-05]": a list of these.
[[nodiscard]] std::string listText(std::span<const double> values);

/// A string as a YAML scalar, in quotation marks where it needs them.
[[nodiscard]] std::string yamlText(const std::string& text);

/// A remark if the map has other keys than these.
void remarkUnknownKeys(const YamlNode& map, const std::vector<std::string>& known, StatedCamera& camera);

/// A remark if one of these keys says something that is not read: times, noise, poses of other things.
/// Zeros, empty values and unit matrices say nothing.
void remarkNotCarried(const YamlNode& map, const std::vector<std::string>& keys, StatedCamera& camera);

}  // namespace alidade::detail
