// SPDX-License-Identifier: MIT
#pragma once

#include <optional>
#include <span>
#include <string>
#include <vector>

#include "alidade/core/cancel.h"
#include "alidade/detect/survey.h"
#include "alidade/imagery/image_set.h"
#include "alidade/report/figures/page_pictures.h"
#include "alidade/target/board.h"
#include "alidade/target/view.h"
#include "options.h"

// Views of boards, found in images or read from corners files.

namespace alidade {

/// What images show, and what to tell the user about them.
struct DetectionStage {
  std::vector<BoardSurvey> surveys;  ///< one for each board
  std::optional<ImageSet> images;    ///< that were searched
  std::vector<std::string> notes;    ///< a sentence each

  [[nodiscard]] std::size_t numImages() const { return surveys.front().outcomes.size(); }
  /// The number of images with corners of any board.
  [[nodiscard]] std::size_t numFound() const;
  /// The views of all boards, board by board.
  [[nodiscard]] std::vector<View> views() const;
};

/// What a command that needs views of boards was told.
struct ViewsRequest {
  std::string command;              ///< its name, for messages
  std::vector<std::string> inputs;  ///< folders, image files, patterns or videos; or corners files
  std::vector<std::string> boards;  ///< SPECs or board files; a .csv corners file knows its own
  /// Where to write the images with what was found drawn on them; empty: nowhere. Nothing: the command has no
  /// flag for it.
  std::optional<std::string> debug_folder = std::nullopt;
  DetectionOptions detection = {};
  PassingPictures* pictures = nullptr;  ///< to be filled while the images are searched, by their paths
  std::optional<ImageSize> image_size = std::nullopt;  ///< for .vnl files, which do not state it
};

/// Finds the boards in all images that the inputs stand for, with progress on a terminal, and sorts out those
/// that must not be used (see surveyImages).
/// @throws Error (kInput) when there is no image; (kUsage) without a board, for boards that look alike, or
/// when the debug folder holds inputs; Cancelled
[[nodiscard]] DetectionStage runDetection(const ViewsRequest& request, const CommonOptions& options,
                                          const CancelFlag* cancel);

/// Goes on only if at least one image gives corners. Otherwise says what each image shows instead. Warns of
/// boards that no image shows.
/// @param has_debug_flag  whether the command in use has --debug, which hints may then name
/// @throws Error (kInput)
void requireBoards(const DetectionStage& stage, const CommonOptions& options, bool has_debug_flag);

/// Checks before any long work that the debug folder and the output are not the same. @throws Error (kUsage)
void checkDebugFolder(const std::string& folder, const std::string& output);

/// The range of each measure over the images that give corners, in a line for people; empty without images.
[[nodiscard]] std::string measuresText(const BoardSurvey& survey);

/// The views that a command was given, with what its reports tell about them.
struct GivenViews {
  std::vector<Board> boards;
  std::size_t num_images = 0;         ///< given
  std::size_t num_found = 0;          ///< with a board
  std::vector<std::string> measures;  ///< how the images show each board, as far as that is known
  std::vector<std::string> reasons;   ///< a line an image without one
  std::vector<std::string> notes;
  std::vector<View> views;            ///< of one image size
  std::vector<std::string> images;    ///< all that were searched for boards; none for corners files
  std::vector<std::string> paths;     ///< of these images
  std::optional<ImageSet> image_set;  ///< these images, to be read again
};

/// True for the name of a corners file.
[[nodiscard]] bool isCornersFile(const std::string& path);

/// Reads the corners files, or finds the boards in the images.
/// @throws Error (kInput) where there is no board, (kUsage) for images without a board SPEC; Cancelled
[[nodiscard]] GivenViews readViews(const ViewsRequest& request, const CommonOptions& options,
                                   const CancelFlag* cancel);

}  // namespace alidade
