// SPDX-License-Identifier: MIT
#pragma once

#include <array>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "alidade/calibrate/start/calibration_options.h"
#include "alidade/detect/survey.h"
#include "alidade/imagery/image_set.h"
#include "alidade/report/data/evidence.h"
#include "alidade/report/figures/page_pictures.h"
#include "alidade/target/board.h"
#include "alidade/target/view.h"
#include "flags.h"

// Views of boards, found in images or read from corners files.

namespace alidade {

/// The inputs and options of a command that needs views of boards.
struct BoardInputs {
  std::vector<std::string> inputs = {};  ///< folders, image files, patterns or videos; or corners files
  std::vector<std::string> boards = {};  ///< SPECs or board files; a .csv corners file states its own
  std::size_t num_frames = 100;          ///< to search in each video or sequence
  /// Frames of videos are evenly spaced from this number on, so that those of several match.
  std::optional<std::size_t> even_from = {};
  /// "image": all images are flipped left to right; "back": they show the back of a board printed through.
  std::string mirrored = {};
  std::string cache = {};  ///< folder for results of detection; empty: none
  /// Folder for images with the detections drawn on them; empty: none.
  std::string debug_folder = {};
  bool has_debug_flag = false;               ///< the command has --debug
  std::optional<ImageSize> image_size = {};  ///< for .vnl files, which do not state it
  PassingPictures* pictures = nullptr;       ///< filled during the search for boards, by path

  /// The flag --board, which may be repeated. A wrong SPEC is reported where it was given, on the command
  /// line or in a settings file.
  void addBoards(Flags& flags);
  /// The flags --frames and --cache, and --debug for commands that only find boards.
  void addDetection(Flags& flags, bool has_debug);
  /// The flag --mirrored, for commands to which it makes no difference which side of the board is seen.
  void addMirrored(Flags& flags);
  [[nodiscard]] bool areFlipped() const { return mirrored == "image"; }
  /// Checks before any long work that the debug folder and the output differ.
  /// @throws Error (kUsage)
  void checkDebugFolder(const std::string& output) const;
};

/// For the help of flags and arguments that take a board.
inline constexpr const char* kBoardText =
    "Board SPEC, for example checkerboard:9x6:25mm (9 x 6 inner corners), or YAML file; all kinds: alidade help boards";
/// The kinds of boards, for "alidade help boards".
[[nodiscard]] std::string boardsHelp();

inline const Values kBoardShapes = oneOf({kBoardShapeModes.begin(), kBoardShapeModes.end()});

/// --pupil, and the CalibratorOptions::num_pupil that its value means.
void addPupilFlag(Flags& flags, std::string& value);
[[nodiscard]] std::optional<std::size_t> pupilNumbers(const std::string& value);

/// CalibratorOptions::correction_cells of the value of --correction. @throws Error (kUsage) naming the flag
[[nodiscard]] std::optional<std::array<int, 2>> correctionCells(const std::string& value);

inline constexpr const char* kMirroredText =
    "image: a camera in mirror mode took the images. They are flipped back, and results are those of the flipped images";

/// The views given to a command, with the information that its reports need.
struct GivenViews : GivenImages {
  std::vector<Board> boards = {};
  std::vector<std::string> measures = {};  ///< measures of each board's images, if known
  std::vector<View> views = {};            ///< of one image size
  std::vector<BoardSurvey> surveys = {};   ///< one per board; empty for corners files, like the rest
  std::vector<std::string> images = {};    ///< all that were searched for boards
  std::vector<std::string> paths = {};     ///< of these images
  std::optional<ImageSet> image_set = {};  ///< these images, for reading them again
};

/// Finds the boards in all images of the inputs, with progress on a terminal, and sets aside those that must
/// not be used (see surveyImages).
/// @throws Error (kInput) if there is no image; (kUsage) without a board, for boards that look alike, or if
/// the debug folder holds inputs; Cancelled
[[nodiscard]] GivenViews runDetection(const BoardInputs& inputs, const CommonOptions& options);

/// Throws unless at least one image has corners; the error states what each image shows instead. Warns of
/// boards that no image shows.
void requireBoards(const GivenViews& found, const BoardInputs& given, const CommonOptions& options);

/// The range of each measure over the images with corners, in one line for people; empty without images.
[[nodiscard]] std::string measuresText(const BoardSurvey& survey);

/// Adapts what is said of mirrored views to the value of --mirrored.
/// @param camera  beginning of the cause, in a rig
void explainMirrors(const std::string& mirrored, const std::string& camera,
                    std::vector<Diagnosis>& diagnoses);

/// True for the name of a corners file.
[[nodiscard]] bool isCornersFile(const std::string& path);

/// Reads the corners files, or finds the boards in the images.
/// @throws Error (kInput) if there is no board, (kUsage) for images without a board SPEC; Cancelled
[[nodiscard]] GivenViews readViews(const BoardInputs& inputs, const CommonOptions& options);

/// Pictures of images by their names in the evidence, in which bytes that are not UTF-8 are replaced. An
/// image that cannot be read has no picture.
/// @param names    of the images of the set, which may be none
/// @param passing  pictures made while these images were searched, which outlive the source; may be null
[[nodiscard]] PictureSource picturesOf(const std::vector<std::string>& names,
                                       const std::optional<ImageSet>& set, const PassingPictures* passing);

}  // namespace alidade
