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
#include <set>
#include <utility>

#include <Eigen/Cholesky>
#include <Eigen/LU>
#include <opencv2/imgproc.hpp>

#include "alidade/detect/corner/corner_fit.h"
#include "alidade/imagery/gray_image.h"

namespace alidade {
namespace {

using Eigen::Matrix2d;
using Eigen::Vector2d;

template <class T>
T powerOf(T x, std::size_t n) {
  T product = 1;
  for (std::size_t i = 0; i < n; ++i) product *= x;
  return product;
}

// Sums of x^p y^q over the pixels of one spot, for p + q <= 4, relative to its first pixel.
class Moments {
 public:
  static constexpr std::size_t kMost = 4;

  // Adds the pixels from column `first` to `last` of a row.
  void addRun(int row, int first, int last) {
    if (count() == 0) origin_ = {first, row};
    // The sums of k^0 to k^4 for k up to n; the formulas also hold for negative n (Faulhaber's polynomials).
    const auto powerSums = [](double n) {
      const double m = n * (n + 1);
      return std::array{n, m / 2, m * (2 * n + 1) / 6, m * m / 4, m * (2 * n + 1) * (3 * m - 1) / 30};
    };
    const auto upto = powerSums(last - origin_.x());
    const auto before = powerSums(first - 1 - origin_.x());
    const double y = row - origin_.y();
    double power = 1;
    for (std::size_t q = 0; q <= kMost; ++q) {
      for (std::size_t p = 0; p + q <= kMost; ++p) sums_[kFirst[q] + p] += power * (upto[p] - before[p]);
      power *= y;
    }
  }

  [[nodiscard]] double count() const { return sums_[0]; }
  // Relative to the origin of central().
  [[nodiscard]] Vector2d offset() const { return Vector2d(sums_[1], sums_[kFirst[1]]) / count(); }
  [[nodiscard]] Vector2d mean() const { return origin_.cast<double>() + offset(); }
  // Mean of (x - mean)^p (y - mean)^q.
  [[nodiscard]] double central(std::size_t p, std::size_t q) const {
    const Vector2d back = -offset();
    double sum = 0;
    for (std::size_t i = 0; i <= p; ++i) {
      for (std::size_t j = 0; j <= q; ++j) {
        sum += kBinomials[p][i] * kBinomials[q][j] * powerOf(back.x(), p - i) * powerOf(back.y(), q - j) *
               sums_[kFirst[j] + i];
      }
    }
    return sum / count();
  }
  // Mean of z^power, where z = from_x (x - mean) + from_y (y - mean).
  [[nodiscard]] std::complex<double> meanPower(std::complex<double> from_x, std::complex<double> from_y,
                                               std::size_t power) const {
    std::complex<double> sum = 0;
    for (std::size_t k = 0; k <= power; ++k)
      sum += kBinomials[power][k] * powerOf(from_x, power - k) * powerOf(from_y, k) * central(power - k, k);
    return sum;
  }

 private:
  static constexpr double kBinomials[kMost + 1][kMost + 1] = {
      {1}, {1, 1}, {1, 2, 1}, {1, 3, 3, 1}, {1, 4, 6, 4, 1}};

  static constexpr std::array<std::size_t, kMost + 1> kFirst = {
      0, 5, 9, 12, 14};  // index of the sum with p = 0, for each q

  Eigen::Vector2i origin_ = Eigen::Vector2i::Zero();
  std::array<double, 15> sums_{};
};

// The ellipse with a spot's area and second moments; nothing if the spot has another shape.
std::optional<Blob> blobOf(const Moments& of) {
  constexpr double kMinAreaPx = 12;
  if (of.count() < kMinAreaPx) return std::nullopt;
  Matrix2d covariance;
  covariance << of.central(2, 0), of.central(1, 1), of.central(1, 1), of.central(0, 2);
  const double det = covariance.determinant();
  const double trace = covariance.trace();
  constexpr double kMinRatio = 0.02;  // of the variances: ellipses up to seven times as long as wide
  if (!(det > kMinRatio * 0.25 * trace * trace)) return std::nullopt;
  // A filled ellipse has the area 4 pi sqrt(det).
  constexpr double kMostOff = 0.12;
  constexpr double kMostOffSmall = 0.25;
  constexpr double kSmallPx = 80;
  const double off = of.count() / (4 * std::numbers::pi * std::sqrt(det)) - 1;
  if (std::abs(off) > (of.count() < kSmallPx ? kMostOffSmall : kMostOff)) return std::nullopt;
  const Matrix2d shape = 0.25 * covariance.inverse();
  // Corners of a polygon: in coordinates z = x + iy in which a spot's second moments are those of a disc of
  // radius 1, the means of z^3 and z^4 vanish for an ellipse. For a square of a checkerboard, |z^4| is 0.15,
  // and for a triangle, |z^3| is 0.2.
  constexpr double kMostAngular = 0.07;
  const Matrix2d root = shape.llt().matrixU();
  const std::complex<double> from_x(root(0, 0), 0);
  const std::complex<double> from_y(root(0, 1), root(1, 1));
  for (const std::size_t power : {3U, 4U}) {
    if (!(std::abs(of.meanPower(from_x, from_y, power)) < kMostAngular)) return std::nullopt;
  }
  return Blob{.pixel = of.mean(), .shape = shape, .area_px = of.count()};
}

// The spots that differ from the mean of their neighbourhood, without those that the image's border cuts.
std::vector<Moments> findSpots(const GrayImage& image, bool is_bright, double window_share) {
  const cv::Mat grey = detail::matOf(image);
  constexpr int kLeastWindow = 15;
  constexpr double kMinStep = 4;
  const int window =
      std::max(kLeastWindow, static_cast<int>(window_share * std::min(grey.cols, grey.rows))) | 1;
  cv::Mat smooth;
  cv::GaussianBlur(grey, smooth, {3, 3}, 0);
  cv::Mat mean;
  cv::boxFilter(grey, mean, CV_8U, {window, window}, {-1, -1}, true, cv::BORDER_REPLICATE);
  cv::Mat mask;
  cv::subtract(is_bright ? smooth : mean, is_bright ? mean : smooth, mask);
  cv::threshold(mask, mask, kMinStep, 255, cv::THRESH_BINARY);
  cv::Mat labels;
  const int num_labels = cv::connectedComponents(mask, labels, 4, CV_32S);
  std::vector<Moments> spots(static_cast<std::size_t>(num_labels));
  std::vector<char> is_cut(spots.size());
  is_cut[0] = 1;  // the background
  for (int y = 0; y < labels.rows; ++y) {
    const int* row = labels.ptr<int>(y);
    for (int first = 0, end = 0; first < labels.cols; first = end) {
      while (end < labels.cols && row[end] == row[first]) ++end;
      const auto label = static_cast<std::size_t>(row[first]);
      if (is_cut[label] != 0) continue;
      if (y == 0 || y == labels.rows - 1 || first == 0 || end == labels.cols) {
        is_cut[label] = 1;
        spots[label] = {};
      } else {
        spots[label].addRun(y, first, end - 1);
      }
    }
  }
  return spots;
}

// Large images are searched at a whole fraction of their size.
std::vector<Blob> findBlobs(const GrayImage& image, bool is_bright, double window_share) {
  constexpr int kLargeSide = 2400;
  constexpr int kLeastSide = 12;
  const int fraction = (std::max(image.size.width, image.size.height) + kLargeSide - 1) / kLargeSide;
  if (std::min(image.size.width, image.size.height) / fraction < kLeastSide) return {};
  std::vector<Blob> blobs;
  const GrayImage small = fraction > 1 ? detail::shrunk(image, fraction) : GrayImage{};
  for (const Moments& spot : findSpots(fraction > 1 ? small : image, is_bright, window_share)) {
    std::optional<Blob> blob = blobOf(spot);
    if (!blob) continue;
    blob->pixel = fraction * (blob->pixel + Vector2d(0.5, 0.5)) - Vector2d(0.5, 0.5);
    blob->shape /= fraction * fraction;
    blob->area_px *= fraction * fraction;
    blobs.push_back(*blob);
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

using Place = std::pair<int, int>;      // along the lattice's two directions
using Basis = std::array<Vector2d, 2>;  // the steps along them

// Grows one lattice from a blob.
class LatticeGrowth {
 public:
  LatticeGrowth(const std::vector<Blob>& blobs, const BlobIndex& index, const std::vector<char>& is_taken)
      : blobs_(blobs), index_(index), is_taken_(is_taken) {}

  [[nodiscard]] std::map<Place, std::size_t> from(std::size_t seed) {
    nodes_.clear();
    used_.clear();
    const auto basis = basisAt(seed);
    if (!basis) return {};
    std::deque<std::pair<Place, Basis>> open = {{{0, 0}, *basis}};
    add({0, 0}, seed);
    while (!open.empty()) {
      const auto [here, basis_here] = open.front();
      open.pop_front();
      for (int direction = 0; direction < 4; ++direction) {
        const Place place = neighbour(here, direction);
        if (nodes_.contains(place)) continue;
        const auto found = seek(here, basis_here, direction);
        if (!found) continue;
        add(place, *found);
        Basis basis_there = basis_here;
        const Vector2d step = blobs_[*found].pixel - blobs_[nodes_.at(here)].pixel;
        basis_there[static_cast<std::size_t>(direction % 2)] = direction < 2 ? step : Vector2d(-step);
        open.emplace_back(place, basis_there);
      }
    }
    return nodes_;
  }

 private:
  static Place neighbour(Place place, int direction) {
    constexpr std::array<int, 4> kI = {1, 0, -1, 0};
    constexpr std::array<int, 4> kJ = {0, 1, 0, -1};
    const auto d = static_cast<std::size_t>(direction);
    return {place.first + kI[d], place.second + kJ[d]};
  }

  void add(Place place, std::size_t blob) {
    nodes_[place] = blob;
    used_.insert(blob);
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
      if (first) return crossProduct(*first, step) > 0 ? Basis{*first, step} : Basis{*first, -step};
      first = step;
    }
    return std::nullopt;
  }

  [[nodiscard]] std::optional<std::size_t> seek(Place place, const Basis& basis, int direction) const {
    constexpr double kMostOff = 0.3;  // of the step
    const Blob& from = blobs_[nodes_.at(place)];
    Vector2d step = basis[static_cast<std::size_t>(direction % 2)];
    if (direction >= 2) step = -step;
    const auto behind = nodes_.find(neighbour(place, direction ^ 2));
    if (behind != nodes_.end()) step = from.pixel - blobs_[behind->second].pixel;
    const auto found = index_.nearest(from.pixel + step, kMostOff * step.norm(), from.area_px);
    if (!found || used_.contains(*found) || is_taken_[*found] != 0) return std::nullopt;
    return found;
  }

  const std::vector<Blob>& blobs_;
  const BlobIndex& index_;
  const std::vector<char>& is_taken_;
  std::map<Place, std::size_t> nodes_;
  std::set<std::size_t> used_;
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
