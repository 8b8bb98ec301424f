// SPDX-License-Identifier: MIT
#include "alidade/footage/key_points.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <numeric>
#include <set>

#include <opencv2/features2d.hpp>
#include <opencv2/imgproc.hpp>

#include "alidade/footage/flow_tracker.h"

namespace alidade {
namespace {

constexpr std::size_t kImages = 24;  // before it, that an image is matched with

struct Match {
  int from = 0;
  int to = 0;
  float ratio = 1;  // of the distances to the nearest and the second nearest descriptor
};

// Mutual nearest descriptors, each clearly nearer than the second.
std::vector<Match> matchesBetween(const cv::Mat& from, const cv::Mat& to) {
  if (from.rows < 2 || to.rows < 2) return {};
  constexpr float kRatio = 0.8F;
  const cv::BFMatcher matcher(cv::NORM_L2);
  std::vector<std::vector<cv::DMatch>> forward;
  std::vector<std::vector<cv::DMatch>> backward;
  matcher.knnMatch(from, to, forward, 2);
  matcher.knnMatch(to, from, backward, 1);
  std::vector<Match> matches;
  for (const auto& best : forward) {
    if (best.size() < 2 || best[0].distance >= kRatio * best[1].distance) continue;
    const int i = best[0].queryIdx;
    const int j = best[0].trainIdx;
    const auto& back = backward[static_cast<std::size_t>(j)];
    if (!back.empty() && back[0].trainIdx == i)
      matches.push_back({i, j, best[0].distance / best[1].distance});
  }
  return matches;
}

}  // namespace

KeyPointMatcher::Image KeyPointMatcher::describe(const GrayImage& image) const {
  // SIFT takes seconds for more pixels, and its points at fine scales are the least repeatable.
  constexpr double kLongestSide = 2000;
  const cv::Mat whole(image.size.height, image.size.width, CV_8U,
                      const_cast<std::uint8_t*>(image.pixels.data()));
  const double scale = std::min(1.0, kLongestSide / std::max(whole.cols, whole.rows));
  cv::Mat used = whole;
  if (scale < 1) cv::resize(whole, used, {}, scale, scale, cv::INTER_AREA);
  const cv::Ptr<cv::SIFT> sift = cv::SIFT::create(0, 3, 0.02);
  std::vector<cv::KeyPoint> found;
  sift->detect(used, found);

  // The strongest of each cell, so that the points spread over the image; one of those at one place.
  constexpr int kColumns = 8;
  constexpr int kRows = 6;
  std::stable_sort(found.begin(), found.end(),
                   [](const cv::KeyPoint& a, const cv::KeyPoint& b) { return a.response > b.response; });
  const std::size_t per_cell = 2 * options_.num_points / (kColumns * kRows) + 1;
  std::array<std::size_t, std::size_t{kColumns} * kRows> count{};
  std::set<std::pair<int, int>> taken;
  std::vector<cv::KeyPoint> chosen;
  for (const cv::KeyPoint& point : found) {
    const int column =
        std::clamp(static_cast<int>(point.pt.x * kColumns / static_cast<float>(used.cols)), 0, kColumns - 1);
    const int row =
        std::clamp(static_cast<int>(point.pt.y * kRows / static_cast<float>(used.rows)), 0, kRows - 1);
    std::size_t& in_cell = count[static_cast<std::size_t>(row * kColumns + column)];
    if (in_cell >= per_cell) continue;
    if (!taken.emplace(static_cast<int>(point.pt.x), static_cast<int>(point.pt.y)).second) continue;
    ++in_cell;
    chosen.push_back(point);
  }
  Image result;
  sift->compute(used, chosen, result.descriptors);
  for (const cv::KeyPoint& point : chosen) {
    // OpenCV doubles the image first and takes half of the doubled image's pixel number, which leaves a
    // quarter of a pixel.
    constexpr double kDoubling = 0.25;
    const double x = (point.pt.x - kDoubling + 0.5) / scale - 0.5;
    const double y = (point.pt.y - kDoubling + 0.5) / scale - 0.5;
    constexpr double kSigmaBySize = 0.12;
    result.points.push_back({.pixel = {x, y}, .sigma_px = kSigmaBySize * point.size / scale});
  }
  return result;
}

std::vector<TrackPixel> KeyPointMatcher::follow(const GrayImage& image) {
  cv::setNumThreads(1);
  Image now = describe(image);
  // The clearest match of each point decides; false ones are rarely as clear. A track has one point in an
  // image.
  struct Claim {
    float ratio = 1;
    std::uint32_t track = 0;
  };
  constexpr std::uint32_t kNone = 0xFFFFFFFF;
  std::vector<Claim> claims(now.points.size(), {.track = kNone});
  for (const Image& earlier : earlier_) {
    for (const Match& match : matchesBetween(now.descriptors, earlier.descriptors)) {
      Claim& claim = claims[static_cast<std::size_t>(match.from)];
      if (match.ratio < claim.ratio)
        claim = {match.ratio, earlier.points[static_cast<std::size_t>(match.to)].track};
    }
  }
  std::map<std::uint32_t, std::size_t> holder;
  for (std::size_t i = 0; i < now.points.size(); ++i) {
    now.points[i].track = kNone;
    if (claims[i].track == kNone) continue;
    const auto [held, is_new] = holder.emplace(claims[i].track, i);
    if (!is_new) {
      if (claims[held->second].ratio <= claims[i].ratio) continue;
      now.points[held->second].track = kNone;
      held->second = i;
    }
    now.points[i].track = claims[i].track;
  }
  for (TrackPixel& point : now.points) {
    if (point.track == kNone) point.track = next_track_++;
  }
  // In rising order of track, the descriptors too.
  std::vector<int> order(now.points.size());
  std::iota(order.begin(), order.end(), 0);
  std::sort(order.begin(), order.end(), [&](int a, int b) {
    return now.points[static_cast<std::size_t>(a)].track < now.points[static_cast<std::size_t>(b)].track;
  });
  Image sorted;
  for (const int i : order) {
    sorted.points.push_back(now.points[static_cast<std::size_t>(i)]);
    sorted.descriptors.push_back(now.descriptors.row(i));
  }
  earlier_.push_back(sorted);
  if (earlier_.size() > kImages) earlier_.pop_front();
  return sorted.points;
}

std::unique_ptr<FrontEnd> makeFrontEnd(const FrontEndOptions& options) {
  if (options.kind == FrontEndKind::kFlow) return std::make_unique<FlowTracker>(options);
  return std::make_unique<KeyPointMatcher>(options);
}

}  // namespace alidade
