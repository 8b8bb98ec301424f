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

/// Requested conversions of a camera; nothing or empty = not requested.
struct ConversionRequest {
  std::optional<PixelRect> crop;
  std::optional<int> bin;  ///< merges N x N pixels into one
  std::optional<ImageSize> resize;
  std::optional<int> rotate_deg;  ///< clockwise, a multiple of 90
  bool drops_pupil = false;       ///< takes the entrance pupil as fixed
  /// Leaves out the correction field, and fits the model anew to the whole camera.
  bool drops_correction = false;
  std::string model;                          ///< id
  std::vector<std::string_view> absent = {};  ///< parameters of the model that must be 0
  double max_error_px = 0.1;                  ///< accepted RMS error of the new model
};

/// Reasons not to trust a converted camera.
enum class ConversionProblem {
  kSourceUntrustworthy,  ///< the source file is marked as untrustworthy
  kUnreachedPixels,      ///< the new model does not reach more than kMaxUnreachedShare of the pixels
  kModelRms,             ///< its RMS error is above `max_error_px`
  kModelError,           ///< its error at one pixel is above kMaxErrorFactor times that
};
inline constexpr double kMaxUnreachedShare = 1e-3;
inline constexpr double kMaxErrorFactor = 10;

/// Stable, for scripts and the findings of a record: "model_rms".
[[nodiscard]] std::string_view problemId(ConversionProblem problem);

struct Conversion {
  /// The requested steps in the order of execution.
  struct Step {
    std::string name;   ///< "crop"
    std::string value;  ///< "10,20,600,400"
    ImageSize size;     ///< afterwards
  };

  EditedCamera edit;  ///< all edits in one
  std::vector<Step> steps;
  std::optional<ModelFit> fit;
  double max_error_px = 0;                  ///< as requested
  std::vector<ConversionProblem> problems;  ///< empty = the result can be used

  [[nodiscard]] const AnyCamera& camera() const { return fit ? fit->camera : edit.camera; }
};

/// Crops, bins, resizes and rotates, in this order, and replaces the model last.
/// @throws Error (kUsage) for a size that no camera file could state; Error (kInput) if an edit does not fit
/// the image
[[nodiscard]] Conversion convertCamera(const CameraRecord& source, const ConversionRequest& request);

/// The converted camera with those parts of its source's record that still hold.
/// @param created_by  program and source of the record
[[nodiscard]] CameraRecord convertedRecord(const CameraRecord& source, const Conversion& conversion,
                                           std::string created_by);

}  // namespace alidade
