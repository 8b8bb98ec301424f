// SPDX-License-Identifier: MIT
#pragma once

#include <optional>
#include <span>
#include <string>
#include <vector>

#include "alidade/detect/detect_images.h"

namespace alidade {

/// Looks at the images of one camera together and takes the corners from those that must not be used:
/// - images of another size than most (kOtherSize);
/// - images whose corners are all within a quarter of a pixel (RMS) of those of an image before them
///   (kDuplicate): copies and frames of a resting camera would feign more certainty than there is;
/// - where more images show another board whole than show this one: those in which not all of this board's
///   border is seen (kOtherBoard), since what they show may be a part of the other one.
/// Images much more blurred than the others keep their corners and are named.
/// @param outcomes  in natural order of their names
/// @returns what the user should know, a sentence each
std::vector<std::string> triage(std::span<ImageOutcome> outcomes);

/// A board that images show while another was asked for.
struct BoardHint {
  int columns = 0;
  int rows = 0;
  int num_images = 0;      ///< images that show it
  bool is_closed = false;  ///< its border was seen: no more corners hide outside the images
};

/// The commonest grid among images without corners; of those that were seen whole, if there are any. Nothing
/// if they show none.
[[nodiscard]] std::optional<BoardHint> diagnoseBoard(std::span<const ImageOutcome> outcomes);

/// The hint in a sentence, with the SPEC to use and the likely slip.
[[nodiscard]] std::string hintText(const BoardHint& hint, const Checkerboard& asked);

/// For people, if the board's ends cannot be told apart: what that means. Empty for other boards.
[[nodiscard]] std::string ambiguityText(const Checkerboard& board);

}  // namespace alidade
