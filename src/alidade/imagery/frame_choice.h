// SPDX-License-Identifier: MIT
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "alidade/core/image.h"

namespace alidade {

/// Properties of a frame that decide if a search for boards is worthwhile.
struct FrameLook {
  static constexpr int kColumns = 16;
  static constexpr int kRows = 12;
  double sharpness = 0;  ///< mean square of the Laplacian of the grey values
  std::array<std::uint8_t, std::size_t{kColumns} * kRows> thumbnail{};  ///< mean grey values, row by row
};

[[nodiscard]] FrameLook lookAt(const GrayImage& image);

/// Chooses frames of a video that are sharp and show something new. It keeps at most eight looks per wanted
/// frame, regardless of the length of the video.
class FrameChooser {
 public:
  /// @param num_wanted  at least 1
  explicit FrameChooser(std::size_t num_wanted);

  /// @param number  of the frame, higher than before
  void add(std::size_t number, const FrameLook& look);

  /// The numbers of the chosen frames, in rising order: those whose thumbnails differ most, with less weight
  /// for a frame that is less sharp than its neighbours. Frames that look the same are chosen once, so there
  /// may be fewer than wanted.
  [[nodiscard]] std::vector<std::size_t> chosen() const;

 private:
  struct Candidate {
    std::size_t number = 0;
    FrameLook look;
  };

  void halve();
  [[nodiscard]] std::vector<double> sharpnessWeights() const;

  std::size_t num_wanted_;
  std::size_t run_length_ = 1;  // number of successive frames of which the sharpest is a candidate
  std::size_t num_in_run_ = 0;  // number of frames that the last candidate represents
  std::vector<Candidate> candidates_;
};

}  // namespace alidade
