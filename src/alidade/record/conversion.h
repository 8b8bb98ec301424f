// SPDX-License-Identifier: MIT
#pragma once

#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "alidade/camera/camera_edit.h"
#include "alidade/camera/model_fit.h"
#include "alidade/record/camera_record.h"

namespace alidade {

/// What a camera is to be converted to; nothing or empty = not asked for.
struct ConversionRequest {
  std::optional<PixelRect> crop;
  std::optional<int> bin;  ///< N x N pixels become one
  std::optional<ImageSize> resize;
  std::optional<int> rotate_deg;              ///< clockwise, a multiple of 90
  std::string model;                          ///< id
  std::vector<std::string_view> absent = {};  ///< parameters of the model that have to be 0
  double max_error_px = 0.1;                  ///< accepted RMS error of the new model
};

/// Why a converted camera is not to be trusted.
enum class ConversionProblem {
  kSourceUntrustworthy,  ///< the source says so of itself
  kUnreachedPixels,      ///< the new model does not reach more than kMaxUnreachedShare of the pixels
  kModelRms,             ///< its RMS error is above `max_error_px`
  kModelError,           ///< its error at one pixel is above kMaxErrorFactor times that
};
inline constexpr double kMaxUnreachedShare = 1e-3;
inline constexpr double kMaxErrorFactor = 10;

/// Stable, for scripts and the findings of a record: "model_rms".
[[nodiscard]] std::string_view problemId(ConversionProblem problem);

struct Conversion {
  /// What was asked for, in the order in which it is done.
  struct Step {
    std::string name;   ///< "crop"
    std::string value;  ///< "10,20,600,400"
    ImageSize size;     ///< afterwards
  };

  EditedCamera edit;  ///< all edits in one
  std::vector<Step> steps;
  std::optional<ModelFit> fit;
  double max_error_px = 0;                  ///< as accepted
  std::vector<ConversionProblem> problems;  ///< empty = the result can be used

  [[nodiscard]] const AnyCamera& camera() const { return fit ? fit->camera : edit.camera; }
};

/// Crops, bins, resizes and rotates, in this order, and replaces the model last.
/// @throws Error (kUsage) for a size that no camera file could state; Error (kInput) where an edit does not
/// go with the image
[[nodiscard]] Conversion convertCamera(const CameraRecord& source, const ConversionRequest& request);

/// The converted camera with what its source says of itself, as far as it still holds.
/// @param created_by  what made it, and from what
[[nodiscard]] CameraRecord convertedRecord(const CameraRecord& source, const Conversion& conversion,
                                           std::string created_by);

}  // namespace alidade
