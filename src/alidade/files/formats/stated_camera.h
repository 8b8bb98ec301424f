// SPDX-License-Identifier: MIT
#pragma once

#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "alidade/camera/any_camera.h"
#include "alidade/core/error.h"
#include "alidade/record/camera_record.h"

namespace alidade {

/// Something about a file that a reader noticed and did not refuse: for `validate`, and for people.
struct Remark {
  std::string id;       ///< stable, for scripts: "unknown_keys", "assumed", "not_carried"
  std::string message;  ///< one sentence, with the place
};

/// A camera as a file of any format states it, in this program's conventions: pixel (0, 0) is the centre of
/// the top-left pixel, parameters in storage order.
struct StatedCamera {
  std::string name;        ///< as the file calls it; empty where it has no names
  std::size_t number = 0;  ///< its place among the cameras of the file, from 0
  AnyCamera camera;
  std::optional<ImageSize> image_size;  ///< nothing: the file does not say
  /// By how much the text of each parameter may be rounded: half a unit of its last digit, 0 for a whole
  /// number. In parameter order; empty = unknown.
  std::vector<double> half_units;
  std::vector<Remark> remarks;
  std::optional<CameraRecord> own;  ///< all the rest of this program's own camera file
};

/// A sound statement of a camera that this program has no model for, unlike damage, which makes a whole file
/// doubtful.
class UnsupportedCamera final : public Error {
 public:
  explicit UnsupportedCamera(const Error& reason) : Error(reason) {}
};

/// A camera of a file that is not supported, beside others that may be.
struct RefusedCamera {
  std::string name;  ///< as of StatedCamera
  std::size_t number = 0;
  UnsupportedCamera reason;
};

/// What a file of any format states, in its order.
struct StatedCameras {
  std::vector<StatedCamera> cameras = {};
  std::vector<RefusedCamera> refused = {};
  /// Names of cameras that ReadOptions::only does not ask for and that were not made.
  std::vector<std::string> passed = {};

  /// Takes the camera that `read` returns, or the reason if it throws UnsupportedCamera.
  template <class Read>
  void add(const std::string& name, const Read& read) {
    const std::size_t number = cameras.size() + refused.size() + passed.size();
    try {
      cameras.push_back(read());
      cameras.back().number = number;
    } catch (const UnsupportedCamera& reason) {
      refused.push_back({.name = name, .number = number, .reason = reason});
    }
  }
};

/// What a file leaves open and a user can add.
struct ReadOptions {
  std::optional<ImageSize> image_size;  ///< for files that do not state one
  std::string model;                    ///< what coefficients of an unnamed model mean; empty = the file says
  /// The name of the only camera that is wanted; empty = all are. A format may then look through the others
  /// for damage alone, since making a camera takes milliseconds, in which it is certified.
  std::string only = {};
};

/// A camera to be written.
struct NamedCamera {
  std::string name;  ///< empty = the format's usual name
  AnyCamera camera;
  ImageSize image_size;
  std::string where = "camera";  ///< for messages: the file that it comes from
};

}  // namespace alidade
