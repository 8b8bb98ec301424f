// SPDX-License-Identifier: MIT
#pragma once

#include <functional>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "alidade/core/aliases.h"
#include "alidade/files/formats/stated_camera.h"

namespace alidade {

namespace detail {
class CameraDocument;
}

/// A format of camera files: detection, reading and writing. A new format is one file that defines such an
/// object, and a line in camera_format.cc; or, if it is only keys and numbers and only read, a row of
/// small_formats.cc.
struct CameraFormat {
  static constexpr std::size_t kAnyNumber = 1'000'000;  ///< of cameras

  std::string_view id;            ///< as in --to: "kalibr"
  std::string_view title;         ///< for display: "Kalibr camchain (YAML)"
  std::string_view aliases = {};  ///< other words for --to: names of the tool and of its files
  /// The models that the format stores exactly, in the order in which they are tried for a camera of an
  /// equivalent model.
  std::vector<std::string_view> models;
  /// Parameters, each with its model, that the format lacks: they must be zero.
  std::vector<std::pair<std::string_view, std::string_view>> absent = {};
  std::size_t max_cameras = 1;  ///< in a file that is written
  /// Poses that a file can state: none, the pose of each camera from the first, or camera_from_rig. read()
  /// may find more poses than are written.
  enum class Poses { kNone, kFromFirst, kFromRig };
  Poses poses = Poses::kNone;
  /// A file states how its camera is rectified. Two files state the poses of a pair.
  bool holds_rectification = false;
  std::size_t max_read = 1;       ///< cameras in a file that is read, if these are more
  bool reads_poses = false;       ///< files that are read may state poses, though none are written
  bool holds_part = false;        ///< a file may state that images are a part of the whole one
  bool holds_size = true;         ///< the image size
  bool holds_pupil = false;       ///< an EntrancePupil that moves
  bool holds_correction = false;  ///< a CorrectionField
  /// Keys of this format that hardly any other file has. They distinguish a camera file with a typo in a key
  /// from a file without a camera.
  std::vector<std::string_view> marks = {};

  std::function<bool(const detail::CameraDocument&)> recognises = nullptr;
  /// Reads all cameras of a document that it recognises. @throws Error (kInput) that names line and key;
  /// UnsupportedCamera if the only camera has a model that Alidade does not support
  std::function<CameraSource(const detail::CameraDocument&, const ReadOptions&)> read = nullptr;
  /// Empty for formats that are only read. `cameras` have models that the format stores (see formatText); the
  /// extension of `path` may select a notation. @throws Error (kInput) for other properties that it cannot
  /// store
  std::function<std::string(std::span<const NamedCamera> cameras, const std::string& path)> write = nullptr;

  /// True if files state poses: one file, or those of a pair together.
  [[nodiscard]] bool holdsPoses() const { return poses != Poses::kNone || holds_rectification; }
  /// "1, reads 2", or "any number".
  [[nodiscard]] std::string camerasText() const;
};

/// THE list of formats; the first one is this program's own. No file is recognised by two of them.
[[nodiscard]] std::span<const CameraFormat* const> cameraFormats();

/// The ids of all formats with their aliases, or only of those that can be written.
[[nodiscard]] std::vector<AliasedName> aliasedFormats(bool only_written = false);

/// @throws Error (kUsage) for an unknown id, naming the known ones
[[nodiscard]] const CameraFormat& cameraFormat(std::string_view id);

/// A model of which a format can represent every lens.
struct HeldModel {
  std::string_view model;
  std::string_view as;                        ///< the model in the format: the same, or an equivalent one
  std::vector<std::string_view> absent = {};  ///< parameters that must be 0

  friend bool operator==(const HeldModel&, const HeldModel&) = default;
};

/// In the order of the model list.
[[nodiscard]] std::vector<HeldModel> heldModels(const CameraFormat& format);

/// A lens of the model with a focal length of half the width of a 640x480 image, in which every coefficient
/// is 0.01 away from the start of a calibration.
[[nodiscard]] NamedCamera exampleLens(std::string_view model);

/// Parameters of the model that must be zero because this format does not store them with it.
[[nodiscard]] std::vector<std::string_view> absentParameters(const CameraFormat& format,
                                                             std::string_view model);

/// Those among them that no other model of the format stores either.
[[nodiscard]] std::vector<std::string_view> unrepresentableParameters(const CameraFormat& format,
                                                                      std::string_view model);

/// The file of these cameras. Each is converted to an equivalent model that `format` stores, including every
/// parameter that is not zero. The text is read back before it is returned: every camera must project as
/// before, and have its old pose as far as the format stores poses.
/// @param cameras  at least one; all have a pose, or none
/// @param path     destination, whose extension may select a notation
/// @throws Error (kInput) if a camera cannot be stored exactly, or if there are too many, with the reason
[[nodiscard]] std::string formatText(const CameraFormat& format, std::span<const NamedCamera> cameras,
                                     const std::string& path = "");

/// The known format that resembles a text of unknown format most.
struct FormatGuess {
  const CameraFormat* format = nullptr;
  int line = 0;              ///< of `key`, from 1
  std::string key = {};      ///< the key in the text that names a camera: "camera_matix"
  std::string meant = {};    ///< the format's key that it is nearest to: "camera_matrix"
  std::string missing = {};  ///< the first key that the format needs and the text does not have; may be empty
  std::size_t num_found = 0;  ///< keys of the format that the text has exactly or nearly
};

/// Searches YAML, JSON or XML, damaged or not, for keys of camera formats or similar spellings.
/// @returns std::nullopt if the text does not name a camera
[[nodiscard]] std::optional<FormatGuess> guessFormat(const std::string& text);

/// The formats, each defined in a file of its name (ros_format.cc), which cites its sources.
namespace detail::formats {

[[nodiscard]] const CameraFormat& alidade();
[[nodiscard]] const CameraFormat& basalt();
[[nodiscard]] const CameraFormat& camodocal();
[[nodiscard]] const CameraFormat& colmap();
[[nodiscard]] const CameraFormat& colmapRig();
[[nodiscard]] const CameraFormat& kalibr();
[[nodiscard]] const CameraFormat& matlab();
[[nodiscard]] const CameraFormat& mrcal();
[[nodiscard]] const CameraFormat& nerfstudio();
[[nodiscard]] const CameraFormat& ocam();
[[nodiscard]] const CameraFormat& opencv();
[[nodiscard]] const CameraFormat& orbslam();
[[nodiscard]] const CameraFormat& ros();

}  // namespace detail::formats

}  // namespace alidade
