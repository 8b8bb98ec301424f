// SPDX-License-Identifier: MIT
#pragma once

#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "alidade/files/formats/stated_camera.h"

namespace alidade {

namespace detail {
class CameraDocument;
}

/// A parameter of a model for which a format has no place, so that it must be zero: k3 of radtan in Kalibr's
/// files.
struct AbsentParameter {
  std::string_view model;
  std::string_view parameter;
};

/// A format of camera files: how to know it, to read it and to write it. Adding one is one file that defines
/// such an object, and a line in camera_format.cc.
struct CameraFormat {
  static constexpr std::size_t kAnyNumber = 1'000'000;  ///< of cameras

  std::string_view id;     ///< as in --to: "kalibr"
  std::string_view title;  ///< for people: "Kalibr camchain (YAML)"
  /// The models that it can hold exactly, in the order in which they are tried where a camera is of another
  /// model that is the same lens.
  std::vector<std::string_view> models;
  /// What of these models it cannot say.
  std::vector<AbsentParameter> absent = {};
  std::size_t max_cameras = 1;  ///< in a file
  /// Where cameras are, as far as a file can say it: nothing, the pose of each from the first, or
  /// camera_from_rig. What read() knows of poses may be more than what is written.
  enum class Poses { kNone, kFromFirst, kFromRig };
  Poses poses = Poses::kNone;
  /// A file tells how its camera is rectified. Two of them tell where the cameras of a pair are.
  bool holds_rectification = false;
  bool holds_size = true;  ///< the image size
  /// Keys that a file of this format has, and that hardly anything but a camera file has. They tell a camera
  /// file with a slip in a key from a file without a camera.
  std::vector<std::string_view> marks = {};

  bool (*recognises)(const detail::CameraDocument&) = nullptr;
  /// All cameras of a document that it recognises. @throws Error (kInput) that names line and key;
  /// UnsupportedCamera where the only camera is of a model that this program does not have
  StatedCameras (*read)(const detail::CameraDocument&, const ReadOptions&) = nullptr;
  /// `cameras` are of models that the format holds (see formatText). @throws Error (kInput) for what it
  /// cannot say of one all the same
  std::string (*write)(std::span<const NamedCamera> cameras) = nullptr;

  /// Another way to write the same, into files with this extension.
  struct Dialect {
    std::string_view extension;  ///< ".xml"
    std::string (*write)(std::span<const NamedCamera> cameras);
  };
  std::vector<Dialect> dialects = {};
};

/// THE list of formats; the first one is this program's own. No file is recognised by two of them.
[[nodiscard]] std::span<const CameraFormat* const> cameraFormats();

/// @throws Error (kUsage) for an unknown id, naming the known ones
[[nodiscard]] const CameraFormat& cameraFormat(std::string_view id);

/// The models whose every lens a format can represent, if parameters for which it has no place are 0.
struct RepresentableModels {
  std::vector<std::string_view> models;
  std::vector<AbsentParameter>
      absent;  ///< of these models, where no other model of the format has room for them
};
[[nodiscard]] RepresentableModels representableModels(const CameraFormat& format);

/// The file of these cameras, each in a model that `format` holds, with every parameter that is not zero, and
/// that is the same lens. It is read back before it is handed out: every camera projects as it did, and
/// stands where it did, as far as the format says poses.
/// @param cameras  at least one; all have a pose, or none
/// @param path     where it is to be written, as far as its extension tells a dialect
/// @throws Error (kInput) if a camera cannot be held exactly, or if there are too many, with the reason
[[nodiscard]] std::string formatText(const CameraFormat& format, std::span<const NamedCamera> cameras,
                                     const std::string& path = "");

/// The format that a text of no known format comes nearest to.
struct FormatGuess {
  const CameraFormat* format = nullptr;
  int line = 0;              ///< of `key`, from 1
  std::string key = {};      ///< the key in the text that names a camera: "camera_matix"
  std::string meant = {};    ///< the format's key that it is nearest to: "camera_matrix"
  std::string missing = {};  ///< the first key that the format needs and the text does not have; may be empty
  std::size_t num_found = 0;  ///< keys of the format that the text has, or nearly has
};

/// Looks for keys of camera formats, or keys nearly spelled like them, in YAML, JSON or XML, damaged or not.
/// @returns std::nullopt if the text does not name a camera
[[nodiscard]] std::optional<FormatGuess> guessFormat(const std::string& text);

/// The formats, each defined in a file of its name (ros_format.cc). Where the facts come from stands there.
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
[[nodiscard]] const CameraFormat& opencv();
[[nodiscard]] const CameraFormat& orbslam();
[[nodiscard]] const CameraFormat& ros();

}  // namespace detail::formats

}  // namespace alidade
