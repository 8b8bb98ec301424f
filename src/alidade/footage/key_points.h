// SPDX-License-Identifier: MIT
#pragma once

#include <deque>
#include <vector>

#include <opencv2/core/mat.hpp>

#include "alidade/footage/front_end.h"

namespace alidade {

/// Key points with descriptors (SIFT, Lowe 2004), matched between an image and those before it: the nearest
/// descriptor in either direction, clearly nearer than the second. Needs no small motion from image to image.
class KeyPointMatcher final : public FrontEnd {
 public:
  explicit KeyPointMatcher(const FrontEndOptions& options) : options_(options) {}
  [[nodiscard]] std::vector<TrackPixel> follow(const GrayImage& image) override;

 private:
  struct Image {
    std::vector<TrackPixel> points;
    cv::Mat descriptors;  // a row each
  };

  [[nodiscard]] Image describe(const GrayImage& image) const;

  FrontEndOptions options_;
  std::deque<Image> earlier_;
  std::uint32_t next_track_ = 0;
};

}  // namespace alidade
