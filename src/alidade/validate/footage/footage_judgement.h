// SPDX-License-Identifier: MIT
#pragma once

#include <cstddef>
#include <optional>
#include <string>
#include <vector>

#include "alidade/core/cancel.h"
#include "alidade/core/diagnosis.h"
#include "alidade/core/image.h"
#include "alidade/footage/check/camera_check.h"
#include "alidade/footage/follow/tracks.h"
#include "alidade/record/camera_record.h"
#include "alidade/record/conversion.h"

namespace alidade {

/// The default of FootageCheckOptions::tolerance_px for camera files.
inline constexpr double kFootageTolerancePx = 1;

/// An edit that may have turned a camera's images into images of a different size, and the verdict of footage
/// on the resulting camera.
struct FootageEdit {
  ConversionRequest request;  ///< only crop, resize and rotate_deg
  FootageCheck check;
};

/// The verdict of footage on a camera.
struct FootageJudgement {
  ImageSize camera_size;  ///< px, from the camera file
  ImageSize image_size;   ///< px, of the footage
  std::size_t num_frames_given = 0;
  /// For the camera as it is; if the sizes differ, for the camera after edits.front(), if there is one.
  FootageCheck check;
  /// Edits tried because the sizes differ: consistent ones first, by error, then the others.
  std::vector<FootageEdit> edits = {};

  [[nodiscard]] bool isOtherSize() const { return camera_size != image_size; }
  /// The edit that makes the camera consistent with the footage; nothing if none does.
  [[nodiscard]] const FootageEdit* foundEdit() const;
  /// The verdict on the camera file: that of the check, but inconsistent if the sizes differ.
  [[nodiscard]] FootageVerdict verdict() const;
};

/// Tests a camera on tracks. If its image size differs from that of the footage, tests it after each edit
/// that may explain the difference.
/// @param tracks  with at least one frame
/// @param num_frames_given  frames of the footage, including those that are not keyframes
/// @throws Cancelled
[[nodiscard]] FootageJudgement judgeOnFootage(const CameraRecord& camera, const FootageTracks& tracks,
                                              const FootageCheckOptions& options,
                                              std::size_t num_frames_given);

/// The edits that make images of one size from those of another: resized, cropped in the centre, or both, and
/// also rotated by a quarter turn if one size is upright and the other is not.
/// @returns none for equal sizes
[[nodiscard]] std::vector<ConversionRequest> editsBetween(ImageSize from, ImageSize to);

/// "cropped and resized"; with underscores, an id: "cropped_and_resized".
[[nodiscard]] std::string editWords(const ConversionRequest& edit);
/// Flags of `alidade convert` for this edit: "--crop 0,60,640,360 --resize 320x180".
[[nodiscard]] std::string editFlags(const ConversionRequest& edit);

/// The verdict of footage on a camera file, as checks: `footage` (a failure if it is inconsistent, a warning
/// if footage cannot decide), and notes: `footage_fit` (a different camera fits better, but not
/// significantly) and `footage_shutter` (a rolling shutter).
/// @param file  the camera file's name, for commands
[[nodiscard]] std::vector<Diagnosis> footageFindings(const FootageJudgement& judgement,
                                                     const CameraRecord& camera, const std::string& file);

/// The likely cause of a change, in plain words, and what to do.
/// @param file  the camera as stated in the file
[[nodiscard]] std::string likelyCause(const CameraChange& change, const AnyCamera& file);

}  // namespace alidade
