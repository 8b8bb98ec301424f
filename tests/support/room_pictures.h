// SPDX-License-Identifier: MIT
#pragma once

#include <array>
#include <cmath>
#include <limits>
#include <span>
#include <vector>

#include <opencv2/imgproc.hpp>

#include <Eigen/Core>

#include "alidade/camera/any_camera.h"
#include "alidade/core/image.h"
#include "alidade/geometry/se3.h"

namespace alidade::testing {

/// What a camera sees in a room of 6 x 4 x 6 m about the origin whose walls are covered with spots.
inline std::vector<cv::Mat> roomPictures(const AnyCamera& camera, ImageSize size,
                                         std::span<const SE3> poses) {
  constexpr int kTexels = 512;  // along a wall
  std::array<cv::Mat, 6> walls;
  for (int i = 0; i < 6; ++i) {
    cv::Mat noise(kTexels, kTexels, CV_32F);
    cv::RNG(static_cast<std::uint64_t>(i + 1)).fill(noise, cv::RNG::UNIFORM, 0, 255);
    cv::GaussianBlur(noise, noise, {0, 0}, 4);
    cv::normalize(noise, walls[static_cast<std::size_t>(i)], 20, 235, cv::NORM_MINMAX);
  }
  const Eigen::Array3d half(3, 2, 3);
  std::vector<cv::Mat> pictures;
  for (const SE3& camera_from_world : poses) {
    const SE3 world_from_camera = camera_from_world.inverse();
    const Eigen::Array3d from = world_from_camera.translation.array();
    cv::Mat picture(size.height, size.width, CV_8U, cv::Scalar(0));
    for (int y = 0; y < size.height; ++y) {
      for (int x = 0; x < size.width; ++x) {
        const auto ray = camera.unproject(Eigen::Vector2d(x, y));
        if (!ray) continue;
        const Eigen::Array3d along = (world_from_camera.rotation * *ray).array();
        Eigen::Index axis = 0;
        const double distance = ((along.sign() * half - from) / along).abs().minCoeff(&axis);
        const Eigen::Array3d at = (from + distance * along) / half;  // -1 to 1
        const auto wall = static_cast<std::size_t>(2 * axis + (along[axis] > 0 ? 1 : 0));
        const double u = 0.5 * (at[(axis + 1) % 3] + 1) * (kTexels - 2);
        const double v = 0.5 * (at[(axis + 2) % 3] + 1) * (kTexels - 2);
        const int column = static_cast<int>(u);
        const int row = static_cast<int>(v);
        const double right = u - column;
        const double down = v - row;
        const cv::Mat& texels = walls[wall];
        const auto texel = [&](int r, int c) { return static_cast<double>(texels.at<float>(r, c)); };
        const double grey =
            (1 - down) * ((1 - right) * texel(row, column) + right * texel(row, column + 1)) +
            down * ((1 - right) * texel(row + 1, column) + right * texel(row + 1, column + 1));
        picture.at<std::uint8_t>(y, x) = cv::saturate_cast<std::uint8_t>(grey);
      }
    }
    pictures.push_back(picture);
  }
  return pictures;
}

}  // namespace alidade::testing
