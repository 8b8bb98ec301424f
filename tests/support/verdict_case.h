// SPDX-License-Identifier: MIT
#pragma once

#include <array>
#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "alidade/calibrate/calibrator.h"
#include "support/simulated_set.h"

namespace alidade {

/// What is wrong with a set of photographs.
enum class Flaw {
  kNone,            ///< 30 views as the advice has them
  kThreeViews,      ///< as good as these can be
  kFrontoParallel,  ///< 15 views, all within 4 degrees of parallel
  kCentreOnly,      ///< 15 views that stay in the middle ninth of the image
  kFocalChanged,    ///< the second half with focal lengths 1 to 3 % longer
  kSwappedImage,    ///< one of 15 images by another camera
  kTooLean,         ///< a lens with distortion, and a model without or with less
  kFolded,          ///< a fisheye lens, and a polynomial for narrow ones
  kBentBoard,       ///< by 1.5 % of its size
  kStretchedBoard,  ///< squares 0.5 % wider than high
  kRollingShutter,  ///< a board carried along while the rows are read
  kUnsharp,         ///< corners to 0.6 px only
};
inline constexpr std::array kFlaws = {Flaw::kNone,           Flaw::kThreeViews,     Flaw::kFrontoParallel,
                                      Flaw::kCentreOnly,     Flaw::kFocalChanged,   Flaw::kSwappedImage,
                                      Flaw::kTooLean,        Flaw::kFolded,         Flaw::kBentBoard,
                                      Flaw::kStretchedBoard, Flaw::kRollingShutter, Flaw::kUnsharp};

[[nodiscard]] std::string_view flawName(Flaw flaw);

/// Ids of diagnoses of which any one names the flaw; empty for none.
[[nodiscard]] std::vector<DiagnosisId> findingsFor(Flaw flaw);

/// A set of views with one flaw and how a user would calibrate it.
struct VerdictCase {
  SimulatedSet set;
  CalibratorOptions options;
};

/// Case `number` of a flaw. `model` is radtan (a field of view of about 70 degrees) or kannala_brandt (120
/// degrees); noise of 0.1 px.
/// @param strength  of the flaw relative to its description; 0 leaves the same views without it. Only for
/// flaws
///                  with a strength, see hasStrength()
[[nodiscard]] VerdictCase makeVerdictCase(Flaw flaw, std::string_view model, std::uint64_t number,
                                          double strength = 1);

/// Whether a flaw can be stronger and weaker than its description.
[[nodiscard]] bool hasStrength(Flaw flaw);

}  // namespace alidade
