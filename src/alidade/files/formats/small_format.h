// SPDX-License-Identifier: MIT
#pragma once

#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "alidade/files/formats/camera_document.h"
#include "alidade/files/formats/lens_numbers.h"
#include "alidade/files/formats/stated_camera.h"
#include "alidade/files/text/yaml_node.h"

// Formats that a table can describe: which keys hold which numbers.
//
// A path has keys separated by '.', from the map of the camera, or from the root after '/'; '*' is the name
// of the camera, '~' that of the first one, and '|' separates alternatives, which must agree.
// Lists of paths are separated by blanks; a path that ends in '?' may be missing.
namespace alidade::detail {

/// A lens of a small format.
struct SmallLens {
  /// The program's names for it, separated by '|'; an empty one is for files without a name. Of a name of
  /// several parts, "a+b", the last may be missing: "a".
  std::string_view name;
  /// Alidade's model; or "opencv", which means the one that OpenCV has for this number of coefficients; or
  /// "opencv?" where four of them may also be those of a fisheye.
  std::string_view model;
  /// What the numbers are, by Alidade's names of parameters, in the order of the paths; "f" is both fx and
  /// fy, "0" must be zero (at the end, any number of them), and parameters that are not listed are zero.
  /// Coefficients of "opencv" follow unlisted.
  std::string_view order;
  /// Of a number each, or after "L=" of a list of numbers, after "K=" of a camera matrix (fx fy cx cy), after
  /// "P=" of a projection matrix (the same). Numbers of missing paths are zero. Those of the row's other
  /// lenses must be zero.
  std::string_view paths;
  /// Makes the numbers of `order` from those of the paths where these are no parameters; null: they are.
  void (*convert)(std::vector<StatedNumber>& listed) = nullptr;
};

/// The models that it may have.
[[nodiscard]] std::vector<std::string_view> modelsOf(const SmallLens& lens);

/// Units of the focal length and the principal point.
enum class SmallUnit {
  kPixels,
  kSides,          ///< the image's width for x and height for y, from the corner of the first pixel
  kSidesIfBelow1,  ///< as kSides if the principal point is above 0 and below 1 in both, else pixels
  kLongSide,       ///< the longer side of the image, from its centre
  kFromCentre,     ///< pixels, the principal point from the image's centre
};

/// A format as a row of a table.
struct SmallFormat {
  std::string_view id;
  std::string_view title;
  /// Paths that every camera has and that hardly any other file has all of; '!' negates.
  std::string_view marks;
  /// Where the cameras are: "." for the root, else keys separated by '.', of which '*' stands for any text or
  /// item of a list, '0' for its first item and '#' for digits; after '+' it is one value or each of a list.
  /// Several are separated by blanks. The last key names the camera, or the first item of a list if it is a
  /// text.
  std::string_view cameras = ".";
  /// A key and a text: of a list after '+', only the items with this value, if there are any.
  std::string_view preferred = {};
  /// The cameras are not maps: only their names come from there, and paths start at the root. A name is then
  /// what '*' or '#' stands for.
  bool is_flat = false;
  std::string_view name = {};   ///< path of a better name
  std::string_view size = {};   ///< path of the image's width and height, or one for each
  bool is_size_named = false;   ///< the name of a camera says its image size
  std::string_view model = {};  ///< paths of the lens' name; several are joined by '+'
  std::span<const SmallLens> lenses;
  SmallUnit unit = SmallUnit::kPixels;
  double origin = 0;  ///< of the first pixel's centre, in pixels
  std::string_view pose =
      {};  ///< path of a 4x4 matrix, or of R (matrix, rotation vector, or x y z w) and t, or "P="
  bool is_rig_from_camera = false;
  std::string_view zero = {};         ///< paths of further numbers that no lens has: they must be zero
  std::string_view known = {};        ///< further keys, of the camera's map or the root; '*' and '#' as above
  std::string_view not_carried = {};  ///< keys of them that state something else than the camera
  /// Completes what the table cannot say. @throws Error (kInput)
  void (*finish)(const YamlNode& root, const ReadOptions& options, CameraSource& all) = nullptr;
};

/// A camera of a file: its name, and the map where its paths start.
struct SmallPlace {
  std::string name;
  YamlNode map;
  std::string first = {};  ///< the name of the first camera
};

/// All places that the patterns of SmallFormat::cameras match. @throws Error (kInput) if they are very many
[[nodiscard]] std::vector<SmallPlace> placesOf(const SmallFormat& format, const YamlNode& root);

/// True if the document has a camera of this format.
[[nodiscard]] bool recognisesSmall(const SmallFormat& format, const CameraDocument& document);

/// Its cameras. @throws Error (kInput) with line and key; UnsupportedCamera
[[nodiscard]] CameraSource readSmall(const SmallFormat& format, const CameraDocument& document,
                                     const ReadOptions& options);

/// The table, with a source for each row.
[[nodiscard]] std::span<const SmallFormat> smallFormats();

}  // namespace alidade::detail
