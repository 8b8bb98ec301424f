// SPDX-License-Identifier: MIT
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "alidade/core/cancel.h"
#include "alidade/target/checkerboard.h"
#include "alidade/target/view.h"
#include "command.h"

namespace alidade {

/// What a command that needs views of a board was told.
struct ViewsRequest {
  std::string command;              ///< its name, for messages
  std::vector<std::string> inputs;  ///< folders, image files or patterns; or one corners file
  std::string board;                ///< SPEC or board file; a corners file knows its own
  /// See DetectionRequest; nothing: the command has no flag for it.
  std::optional<std::string> debug_folder = std::nullopt;
};

/// What was given to a calibration, for the reports.
struct CalibrationInput {
  Checkerboard board;
  std::size_t num_images = 0;        ///< given
  std::size_t num_found = 0;         ///< with a board
  std::string measures;              ///< how the images show the board; empty if that is not known
  std::vector<std::string> reasons;  ///< a line an image without one
  std::vector<std::string> notes;
};

struct GivenViews {
  CalibrationInput input;
  std::vector<View> views;  ///< of one image size
};

/// True for the name of a corners file.
[[nodiscard]] bool isCornersFile(const std::string& path);

/// Reads the corners file, or finds the board in the images.
/// @throws Error (kInput) where there is no board, (kUsage) for images without a board SPEC; Cancelled
[[nodiscard]] GivenViews readViews(const ViewsRequest& request, const CommonOptions& options,
                                   const CancelFlag* cancel);

}  // namespace alidade
