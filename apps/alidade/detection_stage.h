// SPDX-License-Identifier: MIT
#pragma once

#include <string>
#include <vector>

#include "alidade/detect/survey.h"
#include "alidade/target/checkerboard.h"
#include "command.h"

namespace alidade {

/// What images show, and what to tell the user about them.
struct DetectionStage {
  BoardSurvey survey;
  std::vector<std::string> notes;  ///< a sentence each
};

struct DetectionRequest {
  std::vector<std::string> inputs;  ///< folders, files, patterns
  Checkerboard board;
  std::string debug_folder;  ///< where to write the images with what was found drawn on them; empty: nowhere
};

/// Finds the board in all images that the inputs stand for, with progress on a terminal, and sorts out those
/// that must not be used (see surveyImages).
/// @throws Error (kInput) when there is no image; (kUsage) when the debug folder holds inputs; Cancelled
[[nodiscard]] DetectionStage runDetection(const DetectionRequest& request, const CommonOptions& options,
                                          const CancelFlag* cancel);

/// Goes on only if at least one image gives corners. Otherwise says what each image shows instead.
/// @param has_debug_flag  whether the command in use has --debug, which hints may then name
/// @throws Error (kInput)
void requireBoards(const BoardSurvey& survey, const CommonOptions& options, bool has_debug_flag);

/// Checks before any long work that the debug folder and the output are not the same. @throws Error (kUsage)
void checkDebugFolder(const std::string& folder, const std::string& output);

/// The flag --debug, for commands that find boards.
void addDebugOption(CLI::App& app, std::string& folder);

/// One line an image that does not show the whole board, "name: reason: why", for people.
[[nodiscard]] std::vector<std::string> reasonLines(const BoardSurvey& survey);

/// The range of each measure over the images that give corners, in a line for people; empty without images.
[[nodiscard]] std::string measuresText(const BoardSurvey& survey);

/// One CSV line an image with its reason and measures, after a header line.
[[nodiscard]] std::vector<std::string> imageTable(const BoardSurvey& survey);

}  // namespace alidade
