// SPDX-License-Identifier: MIT
#include <algorithm>
#include <array>
#include <cmath>
#include <deque>
#include <functional>
#include <limits>
#include <map>
#include <numbers>
#include <numeric>
#include <set>
#include <utility>

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <opencv2/imgproc.hpp>

#include "alidade/footage/follow/front_end.h"
#include "alidade/footage/follow/image_patch.h"
#include "alidade/footage/follow/image_view.h"
#include "alidade/imagery/opencv_versions.h"

namespace alidade {
namespace {

constexpr std::size_t kImages = 24;  // earlier images that an image is matched with

// Two descriptors and the ratio of their distance to the second smallest one.
struct Match {
  Eigen::Index from;
  Eigen::Index to;
  float ratio;
};

// Mutual nearest descriptors, each clearly nearer than the second nearest. Descriptors are whole numbers, one
// per row, so that their products are exact.
std::vector<Match> matchesBetween(const Eigen::MatrixXf& from, const Eigen::MatrixXf& to) {
  if (from.rows() < 2 || to.rows() < 2) return {};
  constexpr float kRatio = 0.8F;
  // Squared distances, less the squared length of the descriptor of `from` to which the column belongs.
  Eigen::MatrixXf rest = -2 * to * from.transpose();
  rest.colwise() += to.rowwise().squaredNorm();
  const Eigen::VectorXf lengths = from.rowwise().squaredNorm();
  std::vector<std::pair<float, Eigen::Index>> nearest_to(static_cast<std::size_t>(to.rows()),
                                                         {std::numeric_limits<float>::infinity(), -1});
  std::vector<Match> clear;
  for (Eigen::Index i = 0; i < from.rows(); ++i) {
    Match best{i, -1, 0};
    float least = std::numeric_limits<float>::infinity();
    float second = least;
    for (Eigen::Index j = 0; j < to.rows(); ++j) {
      const float square = std::max(0.0F, rest(j, i) + lengths[i]);
      if (square < second) {
        second = std::max(square, least);
        if (square < least) {
          least = square;
          best.to = j;
        }
      }
      auto& nearest = nearest_to[static_cast<std::size_t>(j)];
      if (square < nearest.first) nearest = {square, i};
    }
    best.ratio = std::sqrt(least) / std::sqrt(second);
    if (std::sqrt(least) < kRatio * std::sqrt(second)) clear.push_back(best);
  }
  std::erase_if(clear,
                [&](const Match& m) { return nearest_to[static_cast<std::size_t>(m.to)].second != m.from; });
  return clear;
}

// SIFT takes seconds for more pixels, and its points at fine scales are the least repeatable.
constexpr double kLongestSide = 2000;
constexpr double kShortestSide = 16;  // below it, SIFT has no octave

// Error of a point's position in a patch, px: a patch seen from a new direction is not only deformed.
constexpr double kPatchSigma = 0.1;
// Error of a descriptor's position, as a share of its size.
constexpr double kSigmaBySize = 0.12;

// Converts a pixel of the reduced image to one of the full image.
Eigen::Vector2d inWhole(const Eigen::Vector2f& pixel, double scale) {
  return ((pixel.cast<double>().array() + 0.5) / scale - 0.5).matrix();
}

GrayImage smaller(const GrayImage& image, double scale) {
  cv::Mat resized;
  cv::resize(viewOf(image), resized, {}, scale, scale, cv::INTER_AREA);
  return {{resized.cols, resized.rows}, {resized.begin<std::uint8_t>(), resized.end<std::uint8_t>()}};
}

class KeyPointMatcher final : public FrontEnd {
 public:
  explicit KeyPointMatcher(std::size_t num_points) : num_points_(num_points) {}
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
    Eigen::MatrixXf descriptors;  // one per row
  };

  [[nodiscard]] Image describe(const GrayImage& searched, double scale) const;
  static void align(const GrayImage& searched, double scale, Point& point);

  std::size_t num_points_;
  std::deque<Image> earlier_;
  std::uint32_t next_track_ = 0;
};

KeyPointMatcher::Image KeyPointMatcher::describe(const GrayImage& searched, double scale) const {
  const cv::Mat used = viewOf(searched);
  const cv::Ptr<cv::SIFT> sift = cv::SIFT::create(0, 3, 0.02);
  std::vector<cv::KeyPoint> found;
  sift->detect(used, found);

  // Keeps the strongest of each cell, so that points spread over the image, and one of those at the same
  // position.
  constexpr int kColumns = 8;
  constexpr int kRows = 6;
  std::ranges::stable_sort(found, std::greater(), &cv::KeyPoint::response);
  const std::size_t per_cell = 2 * num_points_ / (kColumns * kRows) + 1;
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
  cv::Mat descriptors;
  sift->compute(used, chosen, descriptors);
  using Rows = Eigen::Matrix<float, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;
  if (!descriptors.empty())
    result.descriptors = Eigen::Map<const Rows>(descriptors.ptr<float>(), descriptors.rows, descriptors.cols);
  for (const cv::KeyPoint& key : chosen) {
    // OpenCV doubles the image first and takes half of the doubled image's pixel number, which leaves a
    // quarter of a pixel.
    constexpr float kDoubling = 0.25F;
    constexpr float kDegree = std::numbers::pi_v<float> / 180;
    Point point{.pixel = {key.pt.x - kDoubling, key.pt.y - kDoubling},
                .size = key.size,
                .direction = kDegree * key.angle};
    point.at.pixel = inWhole(point.pixel, scale);
    constexpr int kReach = ImagePatch::kRadius + 4;
    const int x0 = std::clamp(static_cast<int>(point.pixel.x()) - kReach, 0, used.cols - 1);
    const int y0 = std::clamp(static_cast<int>(point.pixel.y()) - kReach, 0, used.rows - 1);
    const cv::Mat piece = used(
        cv::Rect(x0, y0, std::min(2 * kReach + 2, used.cols - x0), std::min(2 * kReach + 2, used.rows - y0)));
    point.look = {
        .around = {{piece.cols, piece.rows}, {piece.begin<std::uint8_t>(), piece.end<std::uint8_t>()}},
        .centre = point.pixel - Eigen::Vector2f(static_cast<float>(x0), static_cast<float>(y0)),
        .size = point.size,
        .direction = point.direction};
    result.points.push_back(std::move(point));
  }
  return result;
}

// Moves a point to where its track's first patch matches the image. If it matches nowhere, the descriptors
// determine its position and the first one.
void KeyPointMatcher::align(const GrayImage& searched, double scale, Point& point) {
  point.at.sigma_px = std::numbers::sqrt2 * kSigmaBySize * point.size / scale;
  const auto patch = ImagePatch::at(point.look.around, point.look.centre);
  if (!patch) return;
  PatchPlace guess{.pixel = point.pixel};
  guess.shape = point.size / point.look.size *
                Eigen::Rotation2Df(point.direction - point.look.direction).toRotationMatrix();
  const auto place = patch->findIn(searched, guess);
  constexpr float kAlike = 0.85F;  // correlation
  if (!place || place->correlation < kAlike) return;
  const double variance = 0.5 * static_cast<double>(place->covariance.trace()) + kPatchSigma * kPatchSigma;
  point.pixel = place->pixel;
  point.at.pixel = inWhole(point.pixel, scale);
  point.at.sigma_px = std::sqrt(variance) / scale;
}

std::vector<TrackPixel> KeyPointMatcher::follow(const GrayImage& image) {
  detail::useOneThread();
  const double scale = std::min(1.0, kLongestSide / std::max(image.size.width, image.size.height));
  if (scale * std::min(image.size.width, image.size.height) < kShortestSide) return {};
  const GrayImage resized = scale < 1 ? smaller(image, scale) : GrayImage();
  const GrayImage& searched = scale < 1 ? resized : image;
  Image now = describe(searched, scale);
  // The clearest match of each point wins, because false matches are rarely as clear. A track has one point
  // per image. A claim is a ratio and the point of an earlier image.
  std::vector<std::pair<float, const Point*>> claims(now.points.size(), {1.0F, nullptr});
  for (const Image& earlier : earlier_) {
    for (const Match& match : matchesBetween(now.descriptors, earlier.descriptors)) {
      auto& claim = claims[static_cast<std::size_t>(match.from)];
      if (match.ratio < claim.first)
        claim = {match.ratio, &earlier.points[static_cast<std::size_t>(match.to)]};
    }
  }
  std::map<std::uint32_t, std::size_t> holder;
  for (std::size_t i = 0; i < now.points.size(); ++i) {
    if (claims[i].second == nullptr) continue;
    const auto [held, is_new] = holder.emplace(claims[i].second->at.track, i);
    if (is_new) continue;
    std::size_t& best = held->second;
    const std::size_t worse = claims[best].first <= claims[i].first ? i : std::exchange(best, i);
    claims[worse].second = nullptr;
  }
  for (std::size_t i = 0; i < now.points.size(); ++i) {
    Point& point = now.points[i];
    if (claims[i].second == nullptr) {
      point.at.track = next_track_++;
      continue;
    }
    point.at.track = claims[i].second->at.track;
    point.look = claims[i].second->look;
    align(searched, scale, point);
  }
  // In ascending order of track, including the descriptors.
  std::vector<int> order(now.points.size());
  std::iota(order.begin(), order.end(), 0);
  std::ranges::sort(order, {}, [&](int i) { return now.points[static_cast<std::size_t>(i)].at.track; });
  Image sorted{.points = {}, .descriptors = now.descriptors};
  std::vector<TrackPixel> result;
  for (const int i : order) {
    result.push_back(now.points[static_cast<std::size_t>(i)].at);
    sorted.descriptors.row(std::ssize(sorted.points)) = now.descriptors.row(i);
    sorted.points.push_back(std::move(now.points[static_cast<std::size_t>(i)]));
  }
  earlier_.push_back(std::move(sorted));
  if (earlier_.size() > kImages) earlier_.pop_front();
  return result;
}

}  // namespace

std::unique_ptr<FrontEnd> detail::makeKeyPointMatcher(std::size_t num_points) {
  return std::make_unique<KeyPointMatcher>(num_points);
}

std::unique_ptr<FrontEnd> makeFrontEnd(FrontEndKind kind, std::size_t num_points) {
  return kind == FrontEndKind::kFlow ? detail::makeFlowTracker(num_points)
                                     : detail::makeKeyPointMatcher(num_points);
}

}  // namespace alidade
