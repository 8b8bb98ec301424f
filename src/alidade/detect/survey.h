// SPDX-License-Identifier: MIT
#pragma once

#include <cstddef>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "alidade/core/diagnosis.h"
#include "alidade/detect/detect_images.h"
#include "alidade/target/board.h"
#include "alidade/target/view.h"

namespace alidade {

/// A board in the images that differs from the expected one.
struct BoardHint {
  int columns = 0;  ///< inner corners along the longer side
  int rows = 0;
  int num_images = 0;      ///< images that show it
  bool is_closed = false;  ///< its whole border is visible, so the counts are exact
};

/// A board in a set of images of one camera: the interface between images and calibration.
struct BoardSurvey {
  Board board;
  std::size_t index = 0;               ///< of the board among the expected boards
  std::vector<std::string> paths;      ///< names of the images in their set
  std::vector<ImageOutcome> outcomes;  ///< one per path; names omit the folders that all paths share
  std::vector<Diagnosis> notes;        ///< on the images together, not on a failure of one

  /// The number of images with corners, and of those with all corners.
  [[nodiscard]] std::size_t numFound() const;
  [[nodiscard]] std::size_t numWhole() const;
  /// The views of the images that give corners, in the order of the outcomes.
  [[nodiscard]] std::vector<View> views() const;
};

/// Finds the board in all images, in parallel, and discards the corners of images that must not be used:
/// - images whose size differs from that of most images with corners (kOtherSize);
/// - images that may show a part of another board (kOtherBoard). Their board is not completely visible, and
///   either most complete boards in the images have other counts, or there are at least three images, none
///   shows all rows and columns, and most show the same smaller counts;
/// - images whose corners agree with those of an earlier image to a quarter of a pixel (RMS; kDuplicate),
///   because copies and frames of a static scene would make the uncertainty look too small. For frames of one
///   video, or images of one sequence, the limit is 1 % of the image's longer side.
/// An image that cannot be read has the outcome kUnreadable; the others are still processed.
/// @param images  at least one: the result of openImages(), or paths of files
/// @throws Cancelled
[[nodiscard]] BoardSurvey surveyImages(const ImageSet& images, const Board& board,
                                       const DetectImagesOptions& options = {});

/// The same for several boards: one survey for each, in their order. All images must have the same size, and
/// notes that concern only the images are in the first survey. Corners that two boards claim in one image
/// belong to the board that is certain, by its markers or because it is completely visible, or to neither.
/// @param boards  that images can distinguish, see requireDistinguishable()
/// @throws Error (kUsage) for boards that look alike; Cancelled
[[nodiscard]] std::vector<BoardSurvey> surveyImages(const ImageSet& images, std::span<const Board> boards,
                                                    const DetectImagesOptions& options = {});

/// Compares the images of one camera, which the surveys share, and discards the corners of those that
/// must not be used, see surveyImages(). Images that are much more blurred than the others keep their corners
/// and get a note.
/// @param surveys  with the outcomes in natural order of their names
void triage(std::span<BoardSurvey> surveys);

/// The reason why an image does not give every corner, with its stable name; std::nullopt if it does.
[[nodiscard]] std::optional<Diagnosis> diagnosisOf(const ImageOutcome& outcome);

/// Reports the turns after which the board looks the same. @pre board.isAmbiguous()
[[nodiscard]] Diagnosis ambiguityOf(const Board& board);

/// One line for each image that does not show the whole board, "name: reason: why", for users. With several
/// boards, each line names its board, and an image that shows one of them need not show the others.
[[nodiscard]] std::vector<std::string> reasonLines(std::span<const BoardSurvey> surveys);

/// The most common grid other than the expected board among images without corners, preferably one that is
/// completely visible. std::nullopt if there is none.
/// @param others  further boards that the images may show
[[nodiscard]] std::optional<BoardHint> diagnoseBoard(std::span<const ImageOutcome> outcomes,
                                                     const Board& asked, std::span<const Board> others = {});

/// The hint as a sentence, with the SPEC to use and the likely mistake.
[[nodiscard]] std::string hintText(const BoardHint& hint, const Board& asked);

}  // namespace alidade
