// SPDX-License-Identifier: MIT
#include "alidade/detect/board/disc_lattice.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <complex>
#include <deque>
#include <map>
#include <numbers>
#include <optional>
#include <utility>

#include <Eigen/Cholesky>
#include <Eigen/LU>
#include <opencv2/imgproc.hpp>

#include "alidade/core/mapped.h"
#include "alidade/detect/corner/corner_fit.h"

namespace alidade {
namespace {

using Eigen::Matrix2d;
using Eigen::Vector2d;

// Moments of the pixels of one spot.
struct Moments {
  double count = 0, x = 0, y = 0, xx = 0, xy = 0, yy = 0;
};

std::optional<Blob> blobOf(const Moments& of) {
  constexpr double kMinAreaPx = 12;
  if (of.count < kMinAreaPx) return std::nullopt;
  const Vector2d mean(of.x / of.count, of.y / of.count);
  Matrix2d covariance;
  covariance << of.xx / of.count - mean.x() * mean.x(), of.xy / of.count - mean.x() * mean.y(),
      of.xy / of.count - mean.x() * mean.y(), of.yy / of.count - mean.y() * mean.y();
  const double det = covariance.determinant();
  const double trace = covariance.trace();
  constexpr double kMinRatio = 0.02;  // of the variances: ellipses up to seven times as long as wide
  if (!(det > kMinRatio * 0.25 * trace * trace)) return std::nullopt;
  // A filled ellipse has the area 4 pi sqrt(det).
  constexpr double kMostOff = 0.12;
  constexpr double kMostOffSmall = 0.25;
  constexpr double kSmallPx = 80;
  const double off = of.count / (4 * std::numbers::pi * std::sqrt(det)) - 1;
  if (std::abs(off) > (of.count < kSmallPx ? kMostOffSmall : kMostOff)) return std::nullopt;
  return Blob{.pixel = mean, .shape = 0.25 * covariance.inverse(), .area_px = of.count};
}

// Labels of the pixels that differ from the mean of their neighbourhood, 0 for the others.
struct Spots {
  cv::Mat labels;
  std::vector<Moments> moments;  // of each label; zero if the border cuts the spot
};

Spots findSpots(const cv::Mat& grey, bool is_bright, double window_share) {
  constexpr int kLeastWindow = 15;
  constexpr double kMinStep = 4;
  const int window =
      std::max(kLeastWindow, static_cast<int>(window_share * std::min(grey.cols, grey.rows))) | 1;
  cv::Mat smooth;
  cv::GaussianBlur(grey, smooth, {3, 3}, 0);
  cv::Mat mean;
  cv::boxFilter(grey, mean, CV_8U, {window, window}, {-1, -1}, true, cv::BORDER_REPLICATE);
  cv::Mat mask;
  if (is_bright) {
    cv::subtract(smooth, mean, mask);
  } else {
    cv::subtract(mean, smooth, mask);
  }
  cv::threshold(mask, mask, kMinStep, 255, cv::THRESH_BINARY);
  cv::Mat labels;
  const int num_labels = cv::connectedComponents(mask, labels, 4, CV_32S);
  std::vector<Moments> moments(static_cast<std::size_t>(num_labels));
  std::vector<char> is_cut(moments.size());
  for (int y = 0; y < labels.rows; ++y) {
    const int* row = labels.ptr<int>(y);
    const bool is_border_row = y == 0 || y == labels.rows - 1;
    for (int x = 0; x < labels.cols; ++x) {
      if (row[x] == 0) continue;
      Moments& of = moments[static_cast<std::size_t>(row[x])];
      of.count += 1;
      of.x += x;
      of.y += y;
      of.xx += static_cast<double>(x) * x;
      of.xy += static_cast<double>(x) * y;
      of.yy += static_cast<double>(y) * y;
      if (is_border_row || x == 0 || x == labels.cols - 1) is_cut[static_cast<std::size_t>(row[x])] = 1;
    }
  }
  for (std::size_t i = 0; i < moments.size(); ++i) {
    if (i == 0 || is_cut[i] != 0) moments[i] = {};
  }
  return {.labels = labels, .moments = std::move(moments)};
}

// True for spots without the corners of a polygon: in coordinates z = x + iy in which a spot's second moments
// are those of a disc of radius 1, the means of z^3 and z^4 vanish for an ellipse. For a square of a
// checkerboard, |z^4| is 0.15, and for a triangle, |z^3| is 0.2.
std::vector<char> areRound(const Spots& spots, const std::vector<std::optional<Blob>>& blobs) {
  using Complex = std::complex<double>;
  std::vector<Matrix2d> roots(blobs.size());
  for (std::size_t i = 0; i < blobs.size(); ++i) {
    if (blobs[i]) roots[i] = blobs[i]->shape.llt().matrixU();
  }
  std::vector<std::array<Complex, 2>> sums(blobs.size());
  for (int y = 0; y < spots.labels.rows; ++y) {
    const int* row = spots.labels.ptr<int>(y);
    for (int x = 0; x < spots.labels.cols; ++x) {
      const auto label = static_cast<std::size_t>(row[x]);
      if (label == 0 || !blobs[label]) continue;
      const Vector2d p = roots[label] * (Vector2d(x, y) - blobs[label]->pixel);
      const Complex z(p.x(), p.y());
      const Complex zzz = z * z * z;
      sums[label][0] += zzz;
      sums[label][1] += zzz * z;
    }
  }
  constexpr double kMost = 0.07;
  std::vector<char> are_round(blobs.size());
  for (std::size_t i = 0; i < blobs.size(); ++i) {
    are_round[i] =
        blobs[i] && std::max(std::abs(sums[i][0]), std::abs(sums[i][1])) < kMost * blobs[i]->area_px;
  }
  return are_round;
}

// Large images are searched at a whole fraction of their size.
std::vector<Blob> findBlobs(const GrayImage& image, bool is_bright, double window_share) {
  constexpr int kLargeSide = 2400;
  constexpr int kLeastSide = 12;
  const int fraction = (std::max(image.size.width, image.size.height) + kLargeSide - 1) / kLargeSide;
  if (std::min(image.size.width, image.size.height) / fraction < kLeastSide) return {};
  cv::Mat grey(image.size.height, image.size.width, CV_8UC1,
               const_cast<std::uint8_t*>(image.pixels.data()));  // OpenCV only reads it
  if (fraction > 1) {
    const cv::Rect whole(0, 0, grey.cols / fraction * fraction, grey.rows / fraction * fraction);
    cv::Mat small;
    cv::resize(grey(whole), small, {}, 1.0 / fraction, 1.0 / fraction, cv::INTER_AREA);
    grey = small;
  }
  const Spots spots = findSpots(grey, is_bright, window_share);
  const std::vector<std::optional<Blob>> ellipses = mapped(spots.moments, blobOf);
  const std::vector<char> are_round = areRound(spots, ellipses);
  std::vector<Blob> blobs;
  for (std::size_t i = 0; i < ellipses.size(); ++i) {
    if (are_round[i] == 0) continue;
    Blob blob = *ellipses[i];
    blob.pixel = fraction * (blob.pixel + Vector2d(0.5, 0.5)) - Vector2d(0.5, 0.5);
    blob.shape /= fraction * fraction;
    blob.area_px *= fraction * fraction;
    blobs.push_back(blob);
  }
  return blobs;
}

// Blobs by position.
class BlobIndex {
 public:
  BlobIndex(const std::vector<Blob>& blobs, ImageSize size) : blobs_(blobs) {
    constexpr double kBlobsPerCell = 2;
    const double area = static_cast<double>(size.width) * size.height;
    cell_px_ = std::max(4.0, std::sqrt(kBlobsPerCell * area / static_cast<double>(blobs.size() + 1)));
    for (std::size_t i = 0; i < blobs.size(); ++i) cells_[cellOf(blobs[i].pixel)].push_back(i);
  }

  template <class F>
  void forEachNear(const Vector2d& at, double radius, const F& f) const {
    const auto [x0, y0] = cellOf(at - Vector2d(radius, radius));
    const auto [x1, y1] = cellOf(at + Vector2d(radius, radius));
    for (int x = x0; x <= x1; ++x) {
      for (int y = y0; y <= y1; ++y) {
        const auto cell = cells_.find({x, y});
        if (cell == cells_.end()) continue;
        for (const std::size_t i : cell->second) {
          const double distance = (blobs_[i].pixel - at).norm();
          if (distance <= radius) f(i, distance);
        }
      }
    }
  }

  // The nearest blob of about this area.
  [[nodiscard]] std::optional<std::size_t> nearest(const Vector2d& at, double radius, double area_px) const {
    std::optional<std::size_t> best;
    double least = radius;
    forEachNear(at, radius, [&](std::size_t i, double distance) {
      if (!haveLikeArea(blobs_[i].area_px, area_px) || (best && distance >= least)) return;
      best = i;
      least = distance;
    });
    return best;
  }

  static bool haveLikeArea(double a, double b) {
    constexpr double kMostRatio = 2.5;  // of neighbours on a strongly tilted board
    return a < kMostRatio * b && b < kMostRatio * a;
  }

 private:
  [[nodiscard]] std::pair<int, int> cellOf(const Vector2d& p) const {
    return {static_cast<int>(std::floor(p.x() / cell_px_)), static_cast<int>(std::floor(p.y() / cell_px_))};
  }

  const std::vector<Blob>& blobs_;
  double cell_px_;
  std::map<std::pair<int, int>, std::vector<std::size_t>> cells_;
};

struct Basis {
  Vector2d u;
  Vector2d v;
};

// Grows one lattice from a blob.
class LatticeGrowth {
 public:
  LatticeGrowth(const std::vector<Blob>& blobs, const BlobIndex& index, const std::vector<char>& is_taken)
      : blobs_(blobs), index_(index), is_taken_(is_taken) {}

  [[nodiscard]] std::map<std::pair<int, int>, std::size_t> from(std::size_t seed) {
    nodes_.clear();
    node_of_.clear();
    const auto basis = basisAt(seed);
    if (!basis) return {};
    struct Open {
      std::pair<int, int> place;
      Basis basis;
    };
    std::deque<Open> open = {{{0, 0}, *basis}};
    add({0, 0}, seed);
    while (!open.empty()) {
      const Open at = open.front();
      open.pop_front();
      for (int direction = 0; direction < 4; ++direction) {
        const auto place = neighbour(at.place, direction);
        if (nodes_.contains(place)) continue;
        const auto found = seek(at.place, at.basis, direction);
        if (!found) continue;
        add(place, *found);
        Basis basis_there = at.basis;
        const Vector2d step = blobs_[*found].pixel - blobs_[nodes_.at(at.place)].pixel;
        (direction % 2 == 0 ? basis_there.u : basis_there.v) = direction < 2 ? step : Vector2d(-step);
        open.push_back({place, basis_there});
      }
    }
    return nodes_;
  }

 private:
  static std::pair<int, int> neighbour(std::pair<int, int> place, int direction) {
    constexpr std::array<int, 4> kI = {1, 0, -1, 0};
    constexpr std::array<int, 4> kJ = {0, 1, 0, -1};
    const auto d = static_cast<std::size_t>(direction);
    return {place.first + kI[d], place.second + kJ[d]};
  }

  void add(std::pair<int, int> place, std::size_t blob) {
    nodes_[place] = blob;
    node_of_[blob] = place;
  }

  // Two pairs of opposite neighbours, the shortest that are not collinear.
  [[nodiscard]] std::optional<Basis> basisAt(std::size_t seed) const {
    constexpr double kReach = 6;  // in radii
    constexpr double kOpposite = 0.2;
    constexpr double kMinSine = 0.3;
    const Blob& of = blobs_[seed];
    const double radius = std::sqrt(of.area_px / std::numbers::pi);
    const double longest = 1 / std::sqrt(of.shape.trace() / 2) * kReach;
    std::vector<std::pair<double, std::size_t>> near;
    index_.forEachNear(of.pixel, std::max(kReach * radius, longest) * 2, [&](std::size_t i, double distance) {
      if (i != seed && is_taken_[i] == 0 && BlobIndex::haveLikeArea(blobs_[i].area_px, of.area_px))
        near.emplace_back(distance, i);
    });
    constexpr std::size_t kMostNear = 14;
    std::sort(near.begin(), near.end());
    near.resize(std::min(near.size(), kMostNear));
    std::optional<Vector2d> first;
    for (std::size_t a = 0; a < near.size(); ++a) {
      const Vector2d step = blobs_[near[a].second].pixel - of.pixel;
      if (first && std::abs(crossProduct(*first, step)) < kMinSine * first->norm() * step.norm()) continue;
      const bool has_opposite = std::any_of(near.begin(), near.end(), [&](const auto& other) {
        return (blobs_[other.second].pixel - of.pixel + step).norm() < kOpposite * step.norm();
      });
      if (!has_opposite) continue;
      if (!first) {
        first = step;
      } else {
        return crossProduct(*first, step) > 0 ? Basis{*first, step} : Basis{*first, -step};
      }
    }
    return std::nullopt;
  }

  [[nodiscard]] std::optional<std::size_t> seek(std::pair<int, int> place, const Basis& basis,
                                                int direction) const {
    constexpr double kMostOff = 0.3;  // of the step
    const Blob& from = blobs_[nodes_.at(place)];
    Vector2d step = direction % 2 == 0 ? basis.u : basis.v;
    if (direction >= 2) step = -step;
    const auto behind = nodes_.find(neighbour(place, direction ^ 2));
    if (behind != nodes_.end()) step = from.pixel - blobs_[behind->second].pixel;
    const auto found = index_.nearest(from.pixel + step, kMostOff * step.norm(), from.area_px);
    if (!found || node_of_.contains(*found) || is_taken_[*found] != 0) return std::nullopt;
    return found;
  }

  const std::vector<Blob>& blobs_;
  const BlobIndex& index_;
  const std::vector<char>& is_taken_;
  std::map<std::pair<int, int>, std::size_t> nodes_;
  std::map<std::size_t, std::pair<int, int>> node_of_;
};

}  // namespace

std::vector<DiscLattice> findLattices(const GrayImage& image, bool is_bright, double window_share) {
  constexpr std::size_t kFewest = 9;
  constexpr std::size_t kMostBlobs = 40'000;  // more are noise, not a board
  const std::vector<Blob> blobs = findBlobs(image, is_bright, window_share);
  std::vector<DiscLattice> lattices;
  if (blobs.size() < kFewest || blobs.size() > kMostBlobs) return lattices;
  const BlobIndex index(blobs, image.size);
  std::vector<char> is_taken(blobs.size());
  LatticeGrowth growth(blobs, index, is_taken);
  for (std::size_t seed = 0; seed < blobs.size(); ++seed) {
    if (is_taken[seed] != 0) continue;
    const auto nodes = growth.from(seed);
    if (nodes.size() < kFewest) continue;
    DiscLattice lattice;
    for (const auto& [place, blob] : nodes) {
      lattice.push_back({.i = place.first, .j = place.second, .blob = blobs[blob]});
      is_taken[blob] = 1;
    }
    lattices.push_back(std::move(lattice));
  }
  std::stable_sort(lattices.begin(), lattices.end(),
                   [](const auto& a, const auto& b) { return a.size() > b.size(); });
  return lattices;
}

}  // namespace alidade
