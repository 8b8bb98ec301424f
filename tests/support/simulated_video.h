// SPDX-License-Identifier: MIT
#pragma once

#include <cstring>
#include <vector>

#include <opencv2/core.hpp>

#include "alidade/simulate/footage_simulator.h"

namespace alidade {

/// The frames of simulated footage, for writeVideo().
inline std::vector<cv::Mat> simulatedFrames(const FootageSimulator& simulator) {
  std::vector<cv::Mat> frames;
  for (int i = 0; i < simulator.numFrames(); ++i) {
    const GrayImage image = simulator.renderFrame(i);
    cv::Mat& frame = frames.emplace_back(image.size.height, image.size.width, CV_8U);
    std::memcpy(frame.data, image.pixels.data(), image.pixels.size());
  }
  return frames;
}

/// The true poses, camera_from_world of each frame.
inline std::vector<SE3> simulatedPoses(const FootageSimulator& simulator) {
  std::vector<SE3> poses;
  for (int i = 0; i < simulator.numFrames(); ++i) poses.push_back(simulator.poseOf(i));
  return poses;
}

}  // namespace alidade
