// SPDX-License-Identifier: MIT
#pragma once

#include <initializer_list>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "alidade/files/formats/stated_camera.h"
#include "alidade/files/text/yaml_node.h"

namespace alidade::detail {

/// A number as stated in a text, accurate to half a unit of its last digit at best. A whole number without a
/// point is taken as exact.
struct StatedNumber {
  double value = 0;
  double half_unit = 0;
};

/// True if two texts state the same number within the accuracy of their digits.
[[nodiscard]] bool isSameStated(const StatedNumber& a, const StatedNumber& b);
/// The same of lists of the same length.
[[nodiscard]] bool isSameStated(std::span<const StatedNumber> a, std::span<const StatedNumber> b);

[[nodiscard]] bool areZero(std::span<const StatedNumber> numbers);
/// True for nothing, zeros and unit matrices.
[[nodiscard]] bool saysNothing(const YamlNode& node);

/// @throws Error (kInput) if the node is not a finite number
[[nodiscard]] StatedNumber statedNumber(const YamlNode& node);
/// The numbers of a list, of a list of lists row by row, or of a map {rows, cols, data} as OpenCV and ROS
/// write matrices. @throws Error (kInput) also if rows and columns do not match the number of data, or if
/// there are more numbers than any lens has
[[nodiscard]] std::vector<StatedNumber> statedNumbers(const YamlNode& node);
[[nodiscard]] std::vector<StatedNumber> statedNumbers(const YamlNode& node, std::size_t count);

/// fx, fy, cx, cy of a camera matrix [fx s cx; 0 fy cy; 0 0 1], and s if `skew` is not null.
/// @throws Error (kInput) if it is transposed or not a camera matrix; UnsupportedCamera if it has only zeros,
/// as before a calibration, or a skew that is not asked for
[[nodiscard]] std::vector<StatedNumber> readCameraMatrix(const YamlNode& node, StatedNumber* skew = nullptr);

/// The model of a lens of `model` behind skewed pixels; adds the skew to its parameters. cv::projectPoints
/// ignores skew and other programs do not, so that only a fisheye has one reading (cv::fisheye).
/// @throws UnsupportedCamera for other models, unless it is zero
[[nodiscard]] std::string_view takeSkew(const YamlNode& matrix, std::string_view model,
                                        const StatedNumber& skew, std::vector<StatedNumber>& parameters);

/// Alidade's model for OpenCV's coefficients: k1 k2 p1 p2 [k3 [k4 k5 k6 [s1 s2 s3 s4 [tx ty]]]], or k1 k2 k3
/// k4 of cv::fisheye if `stated` is kannala_brandt. They become the parameters of that model.
/// @param pinhole  fx fy cx cy
/// @param stated   radtan, kannala_brandt, or empty if unknown
/// @throws Error (kInput) for four coefficients of an unknown lens, with the difference of the two readings,
/// and for other numbers of them
[[nodiscard]] std::string_view openCvModel(const YamlNode& node, std::span<const StatedNumber> pinhole,
                                           std::vector<StatedNumber>& coefficients,
                                           const std::string& stated);
/// The models of cv::projectPoints, by number of coefficients; theirs are in its order.
[[nodiscard]] std::span<const std::string_view> openCvModels();
/// The model that cv::projectPoints applies to this many coefficients k1 k2 p1 p2 [k3 [k4 k5 k6 [s1 s2 s3 s4
/// [tau_x tau_y]]]]: pinhole, radtan, rational, thin_prism or tilted. The list gets as many as the model has.
/// @throws Error (kInput) for another number of them
[[nodiscard]] std::string_view modelOfCoefficients(const YamlNode& place,
                                                   std::vector<StatedNumber>& coefficients);

/// The values of these keys of a map; each must be there. @throws Error (kInput)
[[nodiscard]] std::vector<StatedNumber> numbersOf(const YamlNode& map, std::span<const std::string> keys);

/// A width and a height in pixels, checked. @throws Error (kInput)
[[nodiscard]] ImageSize readSize(const YamlNode& width, const YamlNode& height);
/// The same from a list of two numbers.
[[nodiscard]] ImageSize readSize(const YamlNode& list);

/// The size of the image in pixels, from two keys of the first of these maps that has them; nothing if
/// neither side is stated. A single stated side is used only if `given` (--image-size) agrees with it;
/// `given` is then the size, with a remark.
/// @throws Error (kInput) that names the missing key if `given` does not help, and for sides that are not
/// numbers of pixels
[[nodiscard]] std::optional<ImageSize> sizeOfSides(std::initializer_list<YamlNode> maps,
                                                   const std::string& width_key,
                                                   const std::string& height_key,
                                                   const std::optional<ImageSize>& given,
                                                   std::vector<Remark>& remarks);

/// A lens in the notation of another program.
struct LensLayout {
  std::string_view name;   ///< the program's name for it
  std::string_view model;  ///< Alidade's name
  /// The parameters by Alidade's names, in the program's order: "xi fx fy cx cy". "f" is both fx and fy;
  /// unlisted parameters are zero.
  std::string_view order;
};

/// The layout of this name; null if there is none.
[[nodiscard]] const LensLayout* findLayout(std::span<const LensLayout> layouts, std::string_view name);

/// The layout that a file names. `advice` is for a name that does not resemble any of them.
/// @throws UnsupportedCamera with the known names
[[nodiscard]] LensLayout layoutNamed(std::span<const LensLayout> layouts, const YamlNode& name,
                                     const std::string& advice);
[[nodiscard]] std::vector<std::string> layoutNames(std::span<const LensLayout> layouts);

/// COLMAP's, in the order of the numbers of its models.
[[nodiscard]] std::span<const LensLayout> colmapLenses();

/// The layout with the most parameters for a camera of this model, the first of them; @pre there is one.
[[nodiscard]] const LensLayout& layoutOf(std::span<const LensLayout> layouts, std::string_view model);

/// From the program's order to Alidade's; `listed` has a number for each name.
[[nodiscard]] std::vector<StatedNumber> storageOrder(const LensLayout& layout,
                                                     std::span<const StatedNumber> listed);

/// From Alidade's order to that of a program whose first pixel has its centre at (origin, origin). Parameters
/// that the layout does not list are dropped, so they must be zero.
[[nodiscard]] std::vector<double> listedOrder(const LensLayout& layout, const AnyCamera& camera,
                                              double origin = 0);

/// Converts from the origin of a program whose first pixel has its centre at (origin, origin) to Alidade's:
/// the principal point is the third and fourth parameter.
void takeOrigin(std::span<StatedNumber> parameters, double origin);

/// The camera with these parameters, in storage order, without a name. @throws Error (kInput), with the
/// place, if they are invalid
[[nodiscard]] StatedCamera stateCamera(const std::string& place, std::string_view model,
                                       std::span<const StatedNumber> parameters,
                                       std::optional<ImageSize> image_size, std::vector<Remark> remarks = {});

/// Appends `more`.
void append(std::vector<StatedNumber>& numbers, std::span<const StatedNumber> more);

/// The fewest digits that read back as the same number, with a point before the exponent: readers of YAML 1.1
/// (Python's, and so Kalibr and ROS) read 1e-05 as text and 1 as an integer.
[[nodiscard]] std::string realText(double value);

/// "[1.0, 0.25, -3.0e-05]": a list of such numbers.
[[nodiscard]] std::string listText(std::span<const double> values);

/// A string as a YAML scalar, quoted if necessary.
[[nodiscard]] std::string yamlText(const std::string& text);

/// Adds a remark if the map has keys other than these.
void remarkUnknownKeys(const YamlNode& map, const std::vector<std::string>& known, StatedCamera& camera);

/// Adds a remark if one of these keys states information that is not read: times, noise, poses of other
/// things. Zeros, empty values and unit matrices state none.
void remarkNotCarried(const YamlNode& map, const std::vector<std::string>& keys, StatedCamera& camera);

}  // namespace alidade::detail
