// SPDX-License-Identifier: MIT
#pragma once

#include <vector>

#include <opencv2/core/mat.hpp>

#include "alidade/footage/front_end.h"

namespace alidade {

/// Optical flow: pyramidal Lucas-Kanade (Bouguet 2000) of image patches.
///
/// A point is found from the last frame, and then again from an earlier one, the anchor, so that errors do
/// not add up from frame to frame. It is kept if the way back to the anchor ends where it began. The anchor
/// moves on when points have moved far, and where cells of the image have too few points, the best corners
/// of the cell (Shi and Tomasi 1994) are added.
class FlowTracker final : public FrontEnd {
 public:
  explicit FlowTracker(const FrontEndOptions& options) : options_(options) {}
  [[nodiscard]] std::vector<TrackPixel> follow(const GrayImage& image) override;

 private:
  struct Point {
    std::uint32_t track = 0;
    cv::Point2f anchor;    // where the anchor frame shows it
    cv::Point2f previous;  // and the last one
    cv::Point2f velocity;
    bool has_velocity = false;
  };

  void advance(const std::vector<cv::Mat>& pyramid);
  void addPoints(const cv::Mat& image);
  void moveAnchor(const std::vector<cv::Mat>& pyramid);

  FrontEndOptions options_;
  std::vector<cv::Mat> anchor_pyramid_;
  std::vector<cv::Mat> last_pyramid_;
  std::vector<Point> points_;
  std::uint32_t next_track_ = 0;
};

}  // namespace alidade
