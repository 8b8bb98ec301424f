// SPDX-License-Identifier: MIT
#pragma once

#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "alidade/camera/camera_edit.h"
#include "alidade/camera/model_fit.h"
#include "alidade/files/camera_file.h"

namespace alidade {

/// What a camera is to be converted to, as it was asked for; empty = not asked for.
struct ConversionRequest {
  std::string crop;  ///< "X,Y,WIDTH,HEIGHT"
  std::optional<int> bin;
  std::string resize;                         ///< "WIDTHxHEIGHT"
  std::optional<int> rotate_deg;              ///< clockwise, a multiple of 90
  std::string model;                          ///< id
  std::vector<std::string_view> absent = {};  ///< parameters of the model that have to be 0
  double max_error_px = 0.1;
};

struct Conversion {
  /// What was asked for, in the order in which it is done.
  struct Step {
    std::string name;   ///< "crop"
    std::string value;  ///< "10,20,600,400"
    ImageSize size;     ///< afterwards
  };
  /// Why the answer is no.
  struct Reason {
    std::string id;  ///< stable, for scripts and the record in the file
    std::string message;
  };

  EditedCamera edit;  ///< all edits in one
  std::vector<Step> steps;
  std::optional<ModelFit> fit;
  std::vector<Reason> reasons;  ///< empty = the answer is not no

  [[nodiscard]] const AnyCamera& camera() const { return fit ? fit->camera : edit.camera; }
};

/// Crops, bins, resizes and rotates, in this order, and replaces the model last. `path` is for messages.
/// @throws Error (kUsage) for a part or a size that is none; Error (kInput) where an edit does not go with
/// the image
[[nodiscard]] Conversion convertCamera(const CameraRecord& source, const std::string& path,
                                       const ConversionRequest& request);

/// The converted camera with what its source says of itself, as far as it still holds.
[[nodiscard]] CameraRecord convertedFile(const CameraRecord& source, const std::string& path,
                                         const Conversion& conversion);

}  // namespace alidade
