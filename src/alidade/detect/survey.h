// SPDX-License-Identifier: MIT
#pragma once

#include <cstddef>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "alidade/core/diagnosis.h"
#include "alidade/detect/detect_images.h"
#include "alidade/target/checkerboard.h"
#include "alidade/target/view.h"

namespace alidade {

/// A board that images show while another was asked for.
struct BoardHint {
  int columns = 0;  ///< inner corners along the longer side
  int rows = 0;
  int num_images = 0;      ///< images that show it
  bool is_closed = false;  ///< its border was seen: no more corners hide outside the images
};

/// Something noticed about the images that is no failure of one of them.
struct SurveyNote {
  enum class Kind {
    kSeveralSizes,     ///< `images` have another size than most, which have `size` and are `num_used`
    kBlurred,          ///< `images` are much more blurred than the others; their corners are used
    kExifOrientation,  ///< `images` ask to be shown turned; their pixels are used as stored
    kAmbiguousBoard,   ///< the board looks the same when it is turned
    kOtherBoard,       ///< images show the board of `hint` whole
  };
  Kind kind = Kind::kSeveralSizes;
  std::vector<std::size_t> images = {};  ///< indices of outcomes
  ImageSize size = {};
  std::size_t num_used = 0;
  int exif_orientation = 1;
  std::optional<BoardHint> hint = std::nullopt;
};

/// What a set of images of one camera shows: the seam between images and everything after.
struct BoardSurvey {
  Checkerboard board;
  std::vector<std::string> paths;      ///< of the images, as given
  std::vector<ImageOutcome> outcomes;  ///< one per path; names without the folders that all paths share
  std::vector<SurveyNote> notes;

  /// Images that give corners, and those that show every corner.
  [[nodiscard]] std::size_t numFound() const;
  [[nodiscard]] std::size_t numWhole() const;
  /// The views of the images that give corners, in the order of the outcomes.
  [[nodiscard]] std::vector<View> views() const;
};

/// Finds the board in all images, in parallel, and withdraws the corners of those that must not be used:
/// - images of another size than most of those with corners (kOtherSize);
/// - images that may show a part of another board (kOtherBoard): not all of the board's border is seen, and
///   either more images show another board whole than show all of this one, or at least three give corners,
///   none of them shows all lines of this board, and most show the same fewer ones;
/// - images whose corners are those of an earlier image to within a quarter of a pixel (RMS; kDuplicate):
///   copies and frames of a resting camera would feign more certainty than there is.
/// An image that cannot be read has the outcome kUnreadable; the others go on.
/// @param paths  of image files in natural order, as listImages() gives them; at least one
/// @throws Cancelled
[[nodiscard]] BoardSurvey surveyImages(const std::vector<std::string>& paths, const Checkerboard& board,
                                       const DetectImagesOptions& options = {});

/// Why an image does not give every corner, by the stable name of its reason; nothing where it does.
[[nodiscard]] std::optional<Diagnosis> diagnosisOf(const ImageOutcome& outcome);
[[nodiscard]] Diagnosis diagnosisOf(const SurveyNote& note, const BoardSurvey& survey);

/// The commonest grid other than the board asked for, among images without corners; of those that were seen
/// whole, if there are any. Nothing if they show none.
[[nodiscard]] std::optional<BoardHint> diagnoseBoard(std::span<const ImageOutcome> outcomes,
                                                     const Checkerboard& asked);

/// The hint in a sentence, with the SPEC to use and the likely slip.
[[nodiscard]] std::string hintText(const BoardHint& hint, const Checkerboard& asked);

}  // namespace alidade
