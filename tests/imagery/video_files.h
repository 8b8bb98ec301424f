// SPDX-License-Identifier: MIT
#pragma once

#include <string>
#include <vector>

#include <opencv2/core.hpp>
#include <opencv2/imgproc.hpp>
#include <opencv2/videoio.hpp>

namespace alidade {

/// Writes a video by OpenCV: MJPG in AVI (every frame on its own) or mp4v in MP4. @returns its path
inline std::string writeVideo(const std::string& path, const std::vector<cv::Mat>& frames) {
  const int code = path.ends_with(".avi") ? cv::VideoWriter::fourcc('M', 'J', 'P', 'G')
                                          : cv::VideoWriter::fourcc('m', 'p', '4', 'v');
  constexpr double kFramesPerSecond = 30;
  cv::VideoWriter writer(path, cv::CAP_FFMPEG, code, kFramesPerSecond, frames.front().size(), false);
  for (const cv::Mat& frame : frames) writer.write(frame);
  return path;
}

/// A bright square that moves over a grey ground: frame i of many.
inline cv::Mat movingSquare(int i) {
  cv::Mat frame(120, 160, CV_8UC1, cv::Scalar(90));
  cv::rectangle(frame, cv::Rect(4 + 3 * (i % 40), 30 + 5 * (i / 40), 28, 28), cv::Scalar(220), cv::FILLED);
  return frame;
}

inline std::vector<cv::Mat> movingSquares(int count) {
  std::vector<cv::Mat> frames;
  for (int i = 0; i < count; ++i) frames.push_back(movingSquare(i));
  return frames;
}

}  // namespace alidade
