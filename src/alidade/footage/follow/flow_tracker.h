// SPDX-License-Identifier: MIT
#pragma once

#include <vector>

#include <opencv2/core/mat.hpp>

#include "alidade/footage/follow/front_end.h"
#include "alidade/footage/follow/image_patch.h"

namespace alidade {

/// Optical flow: pyramidal Lucas-Kanade (Bouguet 2000) from frame to frame, then alignment with the patch of
/// the first frame that showed the point, in its current deformation, so that errors do not accumulate. A
/// point is dropped if its patch no longer matches. Cells of the image with too few points get new ones: the
/// best corners of the cell (Shi and Tomasi 1994).
class FlowTracker final : public FrontEnd {
 public:
  explicit FlowTracker(const FrontEndOptions& options) : options_(options) {}
  [[nodiscard]] std::vector<TrackPixel> follow(const GrayImage& image) override;

 private:
  struct Point {
    std::uint32_t track = 0;
    ImagePatch patch;  // as first seen
    PatchPlace place;  // in the last frame
    Eigen::Vector2f velocity{0, 0};
  };

  void advance(const std::vector<cv::Mat>& pyramid, const GrayImage& image);
  void addPoints(const GrayImage& image);

  FrontEndOptions options_;
  std::vector<cv::Mat> last_pyramid_;
  std::vector<Point> points_;
  std::uint32_t next_track_ = 0;
};

}  // namespace alidade
