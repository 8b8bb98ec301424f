// SPDX-License-Identifier: MIT
#include <cmath>
#include <utility>

#include <opencv2/imgproc.hpp>
#include <opencv2/video/tracking.hpp>

#include "alidade/footage/follow/front_end.h"
#include "alidade/footage/follow/image_patch.h"
#include "alidade/footage/follow/image_view.h"
#include "alidade/imagery/opencv_versions.h"

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

// Tracks points from one frame to another; `to` holds initial guesses.
std::vector<bool> flow(const std::vector<cv::Mat>& from_pyramid, const std::vector<cv::Mat>& to_pyramid,
                       const std::vector<cv::Point2f>& from, std::vector<cv::Point2f>& to) {
  std::vector<bool> is_found(from.size(), false);
  if (from.empty()) return is_found;
  std::vector<unsigned char> status;
  std::vector<float> error;
  cv::calcOpticalFlowPyrLK(from_pyramid, to_pyramid, from, to, status, error, {kPatch, kPatch}, kLevels,
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

cv::Point2f pixelIn(const PatchPlace& place) {
  return {place.pixel.x(), place.pixel.y()};
}

TrackPixel pixelOf(std::uint32_t track, const PatchPlace& place, const Eigen::Vector2f& velocity) {
  constexpr float kLeastSigma = 0.1F;  // px; interpolation, and deformation that no affine map explains
  const float variance = 0.5F * place.covariance.trace() + kLeastSigma * kLeastSigma;
  return {.track = track,
          .pixel = place.pixel.cast<double>(),
          .sigma_px = std::sqrt(static_cast<double>(variance)),
          .velocity_px = velocity.cast<double>()};
}

class FlowTracker final : public FrontEnd {
 public:
  explicit FlowTracker(std::size_t num_points) : num_points_(num_points) {}
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

  std::size_t num_points_;
  std::vector<cv::Mat> last_pyramid_;
  std::vector<Point> points_;
  std::uint32_t next_track_ = 0;
};

std::vector<TrackPixel> FlowTracker::follow(const GrayImage& image) {
  detail::useOneThread();
  const std::vector<cv::Mat> pyramid = pyramidOf(viewOf(image));
  if (!last_pyramid_.empty()) advance(pyramid, image);
  if (4 * points_.size() < 3 * num_points_) addPoints(image);
  last_pyramid_ = pyramid;
  std::vector<TrackPixel> result;
  result.reserve(points_.size());
  for (const Point& point : points_) result.push_back(pixelOf(point.track, point.place, point.velocity));
  return result;
}

void FlowTracker::advance(const std::vector<cv::Mat>& pyramid, const GrayImage& image) {
  std::vector<cv::Point2f> last;
  std::vector<cv::Point2f> now;
  for (const Point& point : points_) {
    last.emplace_back(point.place.pixel.x(), point.place.pixel.y());
    now.push_back(last.back() + cv::Point2f(point.velocity.x(), point.velocity.y()));
  }
  const std::vector<bool> is_found = flow(last_pyramid_, pyramid, last, now);
  std::vector<Point> kept;
  kept.reserve(points_.size());
  for (std::size_t i = 0; i < points_.size(); ++i) {
    if (!is_found[i]) continue;
    Point& point = points_[i];
    PatchPlace guess = point.place;
    guess.pixel = {now[i].x, now[i].y};
    const auto place = point.patch.findIn(image, guess);
    constexpr float kAlike = 0.9F;  // correlation
    if (!place || place->correlation < kAlike) continue;
    point.velocity = place->pixel - point.place.pixel;
    point.place = *place;
    kept.push_back(std::move(point));
  }
  points_ = std::move(kept);
}

void FlowTracker::addPoints(const GrayImage& picture) {
  const cv::Mat image = viewOf(picture);
  constexpr int kColumns = 8;
  constexpr int kRows = 6;
  cv::Mat quality;
  cv::cornerMinEigenVal(image, quality, 5);
  double best = 0;
  cv::minMaxLoc(quality, nullptr, &best);
  if (!(best > 0)) return;
  constexpr double kLeast = 0.003;  // of the best corner's quality
  // Patches of points closer to the edge would extend beyond it.
  constexpr int kEdge = ImagePatch::kRadius + 3;
  const cv::Rect inner(kEdge, kEdge, image.cols - 2 * kEdge, image.rows - 2 * kEdge);
  if (inner.width <= 0 || inner.height <= 0) return;
  cv::Mat usable = cv::Mat::zeros(quality.size(), quality.type());
  quality(inner).copyTo(usable(inner));
  const auto per_cell = static_cast<int>(num_points_ / (kColumns * kRows)) + 1;
  const float apart = 0.4F * std::sqrt(static_cast<float>(image.cols) * static_cast<float>(image.rows) /
                                       static_cast<float>(num_points_));
  for (int row = 0; row < kRows; ++row) {
    for (int column = 0; column < kColumns; ++column) {
      const int x0 = column * image.cols / kColumns;
      const int y0 = row * image.rows / kRows;
      const cv::Rect cell(x0, y0, (column + 1) * image.cols / kColumns - x0,
                          (row + 1) * image.rows / kRows - y0);
      int count = 0;
      for (const Point& point : points_) count += cell.contains(cv::Point(pixelIn(point.place))) ? 1 : 0;
      cv::Mat part = usable(cell).clone();
      for (const Point& point : points_) {
        const cv::Point2f at =
            pixelIn(point.place) - cv::Point2f(static_cast<float>(x0), static_cast<float>(y0));
        cv::circle(part, at, static_cast<int>(apart), cv::Scalar(0), cv::FILLED);
      }
      while (count < per_cell) {
        double value = 0;
        cv::Point at;
        cv::minMaxLoc(part, nullptr, &value, nullptr, &at);
        if (value < kLeast * best) break;
        cv::circle(part, at, static_cast<int>(apart), cv::Scalar(0), cv::FILLED);
        const cv::Point2f pixel(static_cast<float>(at.x + x0), static_cast<float>(at.y + y0));
        PatchPlace place{.pixel = {pixel.x, pixel.y}};
        auto patch = ImagePatch::at(picture, place.pixel);
        if (!patch) continue;
        constexpr float kOwnSigma = 0.05F;  // px; the patch's own noise shows only in later matches
        place.covariance *= kOwnSigma * kOwnSigma;
        points_.push_back({.track = next_track_++, .patch = std::move(*patch), .place = place});
        ++count;
      }
    }
  }
}

}  // namespace

std::unique_ptr<FrontEnd> detail::makeFlowTracker(std::size_t num_points) {
  return std::make_unique<FlowTracker>(num_points);
}

}  // namespace alidade
