// SPDX-License-Identifier: MIT
#pragma once

#include <optional>
#include <vector>

#include "alidade/core/cancel.h"
#include "alidade/files/camera_list.h"
#include "alidade/files/camera_source.h"
#include "alidade/footage/follow/tracks.h"
#include "alidade/record/camera_record.h"
#include "alidade/target/board.h"
#include "alidade/target/view.h"
#include "alidade/validate/camera_checks.h"
#include "alidade/validate/footage/footage_judgement.h"
#include "alidade/validate/held_out/held_out_images.h"

namespace alidade {

/// Tests of cameras of files beyond what the files state.
struct FileTests {
  std::vector<Board> boards = {};
  std::vector<View> views = {};            ///< of images that the cameras were not made from; empty: no test
  std::optional<CameraRecord> other = {};  ///< for comparison
  std::optional<FootageTracks> footage = {};  ///< points tracked through pictures of a rigid scene
  std::size_t num_footage_frames = 0;         ///< of these pictures, including those that are not keyframes
  double footage_tolerance_px = kFootageTolerancePx;
  double tolerance_px = kDefaultTolerancePx;
  int jobs = 0;  ///< threads for the tests on images and footage; 0: one per processor
  const CancelFlag* cancel = nullptr;
};

/// Reads a camera file and judges all its cameras; a file that cannot be read gives a judgement too. Nothing
/// if a file of a folder is not a camera file.
/// @param known  content of the file if already read; nothing: it is read
/// @throws Error (kUsage) for options that do not exist; Cancelled
[[nodiscard]] std::optional<FileJudgement> judgeFile(const ListedFile& file, const ReadOptions& options,
                                                     const FileTests& tests,
                                                     const CameraSource* known = nullptr);

}  // namespace alidade
