// SPDX-License-Identifier: MIT
#pragma once

#include <functional>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include <Eigen/Core>

#include "alidade/camera/any_camera.h"
#include "alidade/core/error.h"
#include "alidade/geometry/se3.h"
#include "alidade/record/camera_record.h"
#include "alidade/record/rig_record.h"

namespace alidade {

/// Something unusual in a file that the reader accepted: for `validate` and for messages.
struct Remark {
  std::string id;  ///< stable, for scripts: "unknown_keys", "assumed", "not_carried", "bad_pose", "no_pose"
  std::string message;  ///< one sentence, with the place
};

/// A camera as stated by a file of any format, in Alidade's conventions: pixel (0, 0) is the centre of the
/// top-left pixel, parameters in storage order.
struct StatedCamera {
  std::string name = {};   ///< the name in the file; empty if it has none
  std::size_t number = 0;  ///< its index among the cameras of the file, from 0
  AnyCamera camera;
  std::optional<ImageSize> image_size = {};  ///< empty: the file does not state it
  std::vector<Remark> remarks = {};
  /// The principal point of the rectified images, px, if a ROS file states a projection matrix.
  std::optional<Eigen::Vector2d> rectified_center = std::nullopt;
  std::optional<Eigen::Vector2d> rectified_focal = std::nullopt;  ///< the focal lengths of these images, px
  /// The pose, if the file states those of all its cameras. A file with one camera may also state it, in a
  /// frame shared with other files.
  std::optional<SE3> camera_from_rig = {};
  std::optional<CameraRecord> own = {};  ///< the whole record of an Alidade camera file
};

/// A valid camera for which Alidade has no model. In contrast, damage makes a whole file invalid.
class UnsupportedCamera final : public Error {
 public:
  explicit UnsupportedCamera(const Error& reason) : Error(reason) {}
};

/// The Error of a file that can be read, has no known format, and does not name a camera: a list of poses, or
/// the settings of another program.
class NotACameraFile final : public Error {
 public:
  explicit NotACameraFile(const Error& reason) : Error(reason) {}
};

/// An unsupported camera of a file that may also contain supported ones.
struct RefusedCamera {
  std::string name;  ///< as in StatedCamera
  std::size_t number = 0;
  UnsupportedCamera reason;
};

/// The text after FILE# that selects a StatedCamera or RefusedCamera: its name, or its number.
template <class Camera>
[[nodiscard]] std::string cameraLabel(const Camera& camera) {
  return camera.name.empty() ? std::to_string(camera.number) : camera.name;
}

/// All cameras of a file, in their order.
struct CameraSource {
  std::string path = {};                   ///< without "#NAME"
  std::string_view format = {};            ///< id: "ros"
  std::string_view format_name = {};       ///< for display: "ROS camera_info (YAML)"
  std::vector<StatedCamera> cameras = {};  ///< at least one, unless ReadOptions::only is set
  /// Unsupported cameras of the same file; empty if one camera was selected.
  std::vector<RefusedCamera> refused = {};
  /// Names of cameras that were skipped because ReadOptions::only selects a different one.
  std::vector<std::string> passed = {};
  /// Reads what an Alidade rig file states beside cameras and poses; empty for other files, and if one camera
  /// was selected.
  std::function<void(RigRecord&)> readRigRest = {};

  /// Adds the camera that `read` returns, with this name, or the reason if it throws UnsupportedCamera.
  template <class Read>
  void add(const std::string& name, const Read& read) {
    const std::size_t number = cameras.size() + refused.size() + passed.size();
    try {
      cameras.push_back(read());
      cameras.back().name = name;
      cameras.back().number = number;
    } catch (const UnsupportedCamera& reason) {
      refused.push_back({.name = name, .number = number, .reason = reason});
    }
  }
};

/// Information that a file may lack and the user can supply.
struct ReadOptions {
  std::optional<ImageSize> image_size;  ///< for files that do not state one
  std::string model;                    ///< for files that do not name the model; empty = unknown
  /// The name of the only camera to read; empty = read all. The others are then checked only for damage,
  /// because certifying a camera takes milliseconds.
  std::string only = {};
  std::string format = {};  ///< id of the format; empty = detect it
  /// Reads the camera of the images that a topic publishes, if the file states that they are a part of the
  /// whole image (ROI, binning).
  bool applies_roi = false;
};

/// The mapping of a camera's images to a rectified pair, as by cv::stereoRectify().
struct RectifiedCamera {
  SO3 rectified_from_camera;  ///< R1 or R2
  /// P1 or P2, for points (metres) in the rectified frame of the first camera.
  Eigen::Matrix<double, 3, 4> pixel_from_first = Eigen::Matrix<double, 3, 4>::Zero();
};

/// A camera to write.
struct NamedCamera {
  std::string name;  ///< empty = the format's usual name
  AnyCamera camera;
  ImageSize image_size;
  std::optional<SE3> camera_from_rig = {};        ///< set for all cameras of a file, or for none
  std::string where = "camera";                   ///< for messages: the file of the camera
  std::optional<RectifiedCamera> rectified = {};  ///< for formats that hold it
};

}  // namespace alidade
