// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>
#include <deque>
#include <vector>

#include <Eigen/Core>
#include <opencv2/core/mat.hpp>

#include "alidade/core/image.h"
#include "alidade/footage/follow/front_end.h"

namespace alidade {

/// Key points with descriptors (SIFT, Lowe 2004), matched between an image and those before it: the nearest
/// descriptor in either direction, clearly nearer than the second nearest. Motion between images may be
/// large. A matched point is then aligned with its patch in the first image of its track, with size and
/// direction as a first guess of the deformation. If that fails, it stays at its descriptor's position.
class KeyPointMatcher final : public FrontEnd {
 public:
  explicit KeyPointMatcher(const FrontEndOptions& options) : options_(options) {}
  [[nodiscard]] std::vector<TrackPixel> follow(const GrayImage& image) override;

 private:
  // Appearance of a key point in the first image of its track.
  struct Look {
    GrayImage around;
    Eigen::Vector2f centre{0, 0};  // in `around`
    float size = 0;                // px
    float direction = 0;           // radians
  };
  struct Point {
    TrackPixel at = {};
    Eigen::Vector2f pixel{0, 0};  // in the searched image, which may be reduced
    float size = 0;
    float direction = 0;
    Look look = {};
  };
  struct Image {
    std::vector<Point> points;
    cv::Mat descriptors;  // one per row
  };

  [[nodiscard]] Image describe(const GrayImage& searched, double scale) const;
  static void align(const GrayImage& searched, double scale, Point& point);

  FrontEndOptions options_;
  std::deque<Image> earlier_;
  std::uint32_t next_track_ = 0;
};

}  // namespace alidade
