// SPDX-License-Identifier: MIT
#pragma once

#include <optional>
#include <span>
#include <string>
#include <vector>

#include "alidade/detect/detect_images.h"

namespace alidade {

/// Looks at the images of one camera together and takes the corners from those that must not be used:
/// - images of another size than most of those with corners (kOtherSize);
/// - images in which not all of the board's border is seen, where more images show another board whole than
/// show
///   all of this one, or where at least three give corners, none of them shows all lines of this board, and
///   most show the same fewer ones (kOtherBoard): what they show may be a part of another board, or all of
///   it;
/// - images whose corners are those of an image before them to within a quarter of a pixel (RMS; kDuplicate):
///   copies and frames of a resting camera would feign more certainty than there is.
/// Images much more blurred than the others keep their corners and are named.
/// @param outcomes  in natural order of their names
/// @returns what the user should know, a sentence each
std::vector<std::string> triage(std::span<ImageOutcome> outcomes, const Checkerboard& board);

/// A board that images show while another was asked for.
struct BoardHint {
  int columns = 0;
  int rows = 0;
  int num_images = 0;      ///< images that show it
  bool is_closed = false;  ///< its border was seen: no more corners hide outside the images
};

/// The commonest grid other than the board asked for, among images without corners; of those that were seen
/// whole, if there are any. Nothing if they show none.
[[nodiscard]] std::optional<BoardHint> diagnoseBoard(std::span<const ImageOutcome> outcomes,
                                                     const Checkerboard& asked);

/// The hint in a sentence, with the SPEC to use and the likely slip.
[[nodiscard]] std::string hintText(const BoardHint& hint, const Checkerboard& asked);

/// For people, if the board's ends cannot be told apart: what that means. Empty for other boards.
[[nodiscard]] std::string ambiguityText(const Checkerboard& board);

}  // namespace alidade
