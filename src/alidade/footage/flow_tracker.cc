// SPDX-License-Identifier: MIT
#include "alidade/footage/flow_tracker.h"

#include <algorithm>
#include <cmath>

#include <opencv2/imgproc.hpp>
#include <opencv2/video/tracking.hpp>

namespace alidade {
namespace {

constexpr int kPatch = 15;
constexpr int kLevels = 3;

const cv::TermCriteria& stopRule() {
  static const cv::TermCriteria rule(cv::TermCriteria::COUNT + cv::TermCriteria::EPS, 20, 0.01);
  return rule;
}

std::vector<cv::Mat> pyramidOf(const cv::Mat& image) {
  std::vector<cv::Mat> pyramid;
  cv::buildOpticalFlowPyramid(image, pyramid, {kPatch, kPatch}, kLevels);
  return pyramid;
}

// Where points of one frame are in another; `to` holds guesses.
std::vector<bool> flow(const std::vector<cv::Mat>& from_pyramid, const std::vector<cv::Mat>& to_pyramid,
                       const std::vector<cv::Point2f>& from, std::vector<cv::Point2f>& to, int levels) {
  std::vector<bool> is_found(from.size(), false);
  if (from.empty()) return is_found;
  std::vector<unsigned char> status;
  std::vector<float> error;
  cv::calcOpticalFlowPyrLK(from_pyramid, to_pyramid, from, to, status, error, {kPatch, kPatch}, levels,
                           stopRule(), cv::OPTFLOW_USE_INITIAL_FLOW, 1e-3);
  const cv::Mat& image = to_pyramid.front();
  for (std::size_t i = 0; i < from.size(); ++i) {
    constexpr float kMargin = 3;
    is_found[i] = status[i] != 0 && to[i].x >= kMargin && to[i].y >= kMargin &&
                  to[i].x <= static_cast<float>(image.cols - 1) - kMargin &&
                  to[i].y <= static_cast<float>(image.rows - 1) - kMargin;
  }
  return is_found;
}

float distance(const cv::Point2f& a, const cv::Point2f& b) {
  return std::hypot(a.x - b.x, a.y - b.y);
}

}  // namespace

std::vector<TrackPixel> FlowTracker::follow(const GrayImage& image) {
  cv::setNumThreads(1);
  // Not written to.
  const cv::Mat view(image.size.height, image.size.width, CV_8U,
                     const_cast<std::uint8_t*>(image.pixels.data()));
  const std::vector<cv::Mat> pyramid = pyramidOf(view);
  if (last_pyramid_.empty()) {
    moveAnchor(pyramid);
  } else {
    advance(pyramid);
  }
  if (4 * points_.size() < 3 * options_.num_points) {
    moveAnchor(pyramid);
    addPoints(view);
  } else {
    std::vector<float> motions;
    for (const Point& point : points_) motions.push_back(distance(point.anchor, point.previous));
    std::nth_element(motions.begin(), motions.begin() + static_cast<std::ptrdiff_t>(motions.size() / 2),
                     motions.end());
    // Patches change their look on the way; beyond this they match less well than small errors would add up.
    constexpr float kFar = 0.05F;
    if (motions[motions.size() / 2] > kFar * static_cast<float>(view.cols)) moveAnchor(pyramid);
  }
  last_pyramid_ = pyramid;
  std::vector<TrackPixel> result;
  result.reserve(points_.size());
  for (const Point& point : points_) {
    TrackPixel at{.track = point.track, .pixel = {point.previous.x, point.previous.y}};
    if (point.has_velocity) at.velocity_px = {point.velocity.x, point.velocity.y};
    result.push_back(at);
  }
  return result;
}

void FlowTracker::advance(const std::vector<cv::Mat>& pyramid) {
  std::vector<cv::Point2f> last;
  std::vector<cv::Point2f> anchors;
  std::vector<cv::Point2f> now;
  for (const Point& point : points_) {
    last.push_back(point.previous);
    anchors.push_back(point.anchor);
    now.push_back(point.has_velocity ? point.previous + point.velocity : point.previous);
  }
  std::vector<bool> is_kept = flow(last_pyramid_, pyramid, last, now, kLevels);
  // From the anchor, starting there; and back.
  std::vector<cv::Point2f> from_anchor = now;
  const std::vector<bool> is_found = flow(anchor_pyramid_, pyramid, anchors, from_anchor, 1);
  std::vector<cv::Point2f> back = anchors;
  const std::vector<bool> is_back = flow(pyramid, anchor_pyramid_, from_anchor, back, 1);
  std::vector<Point> kept;
  for (std::size_t i = 0; i < points_.size(); ++i) {
    constexpr float kApart = 1.5F;   // px: the two ways to the new frame
    constexpr float kReturn = 0.3F;  // px
    if (!is_kept[i] || !is_found[i] || !is_back[i]) continue;
    if (distance(from_anchor[i], now[i]) > kApart || distance(back[i], anchors[i]) > kReturn) continue;
    Point point = points_[i];
    point.velocity = from_anchor[i] - point.previous;
    point.has_velocity = true;
    point.previous = from_anchor[i];
    kept.push_back(point);
  }
  points_ = std::move(kept);
}

void FlowTracker::moveAnchor(const std::vector<cv::Mat>& pyramid) {
  anchor_pyramid_ = pyramid;
  for (Point& point : points_) point.anchor = point.previous;
}

void FlowTracker::addPoints(const cv::Mat& image) {
  constexpr int kColumns = 8;
  constexpr int kRows = 6;
  cv::Mat quality;
  cv::cornerMinEigenVal(image, quality, 5);
  double best = 0;
  cv::minMaxLoc(quality, nullptr, &best);
  if (!(best > 0)) return;
  constexpr double kLeast = 0.003;  // of the best corner
  const auto per_cell = static_cast<int>(options_.num_points / (kColumns * kRows)) + 1;
  const float apart = 0.4F * std::sqrt(static_cast<float>(image.cols) * static_cast<float>(image.rows) /
                                       static_cast<float>(options_.num_points));
  for (int row = 0; row < kRows; ++row) {
    for (int column = 0; column < kColumns; ++column) {
      const int x0 = column * image.cols / kColumns;
      const int y0 = row * image.rows / kRows;
      const cv::Rect cell(x0, y0, (column + 1) * image.cols / kColumns - x0,
                          (row + 1) * image.rows / kRows - y0);
      int count = 0;
      for (const Point& point : points_) count += cell.contains(cv::Point(point.previous)) ? 1 : 0;
      cv::Mat part = quality(cell).clone();
      for (const Point& point : points_) {
        const cv::Point2f at = point.previous - cv::Point2f(static_cast<float>(x0), static_cast<float>(y0));
        cv::circle(part, at, static_cast<int>(apart), cv::Scalar(0), cv::FILLED);
      }
      while (count < per_cell) {
        double value = 0;
        cv::Point at;
        cv::minMaxLoc(part, nullptr, &value, nullptr, &at);
        if (value < kLeast * best) break;
        cv::circle(part, at, static_cast<int>(apart), cv::Scalar(0), cv::FILLED);
        const cv::Point2f pixel(static_cast<float>(at.x + x0), static_cast<float>(at.y + y0));
        constexpr float kMargin = kPatch / 2.0F;
        if (pixel.x < kMargin || pixel.y < kMargin || pixel.x > static_cast<float>(image.cols) - kMargin ||
            pixel.y > static_cast<float>(image.rows) - kMargin)
          continue;
        points_.push_back({.track = next_track_++, .anchor = pixel, .previous = pixel, .velocity = {}});
        ++count;
      }
    }
  }
}

}  // namespace alidade
