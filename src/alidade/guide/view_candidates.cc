// SPDX-License-Identifier: MIT
#include "alidade/guide/view_candidates.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <optional>

#include <Eigen/Geometry>

#include "alidade/guide/board_sighting.h"

namespace alidade {
namespace {

constexpr int kPlacesAlong = 7;
constexpr int kPlacesAcross = 5;
constexpr std::array<double, 3> kSpans = {0.3, 0.6, 0.95};  // of the image's smaller side
constexpr std::array<double, 5> kTiltsDeg = {0, -20, 20, -40, 40};
constexpr double kRadPerDeg = std::numbers::pi / 180;
constexpr double kMargin = 0.02;           // of the image's smaller side
constexpr double kLeastSquarePx = 6;       // below, corners are not found reliably
constexpr double kLeastSine = 0.25881905;  // of 15 degrees, between a line of sight and the board
constexpr double kPaper = 0.3;             // squares that must be seen of the paper beyond the squares
constexpr int kMaxAlong = 12;              // corners that stand for a row or column of the board

// Indices 0 to count - 1, or kMaxAlong of them evenly spaced.
std::vector<int> someOf(int count) {
  std::vector<int> indices;
  const int num = std::min(count, kMaxAlong);
  for (int i = 0; i < num; ++i) indices.push_back((2 * i * (count - 1) + num - 1) / (2 * (num - 1)));
  return indices;
}

class CandidateMaker {
 public:
  CandidateMaker(const AnyCamera& camera, ImageSize size, const Checkerboard& board,
                 const CandidateLimits& limits)
      : camera_(camera), size_(size), limits_(limits), middle_(board.middle()) {
    columns_ = someOf(board.columns);
    rows_ = someOf(board.rows);
    for (const int row : rows_) {
      for (const int column : columns_) points_board_.push_back(board.corner(row * board.columns + column));
    }
    const double beyond = (1 + kPaper) * board.square_m;
    const Eigen::Vector3d last = board.corner(board.numCorners() - 1);
    ends_ = {{{-beyond, -beyond, 0},
              {last.x() + beyond, -beyond, 0},
              {last.x() + beyond, last.y() + beyond, 0},
              {-beyond, last.y() + beyond, 0}}};
    weight_ = static_cast<double>(board.numCorners()) / static_cast<double>(points_board_.size());
    points_camera_.resize(points_board_.size());
    projections_.resize(points_board_.size());
    if (limits.is_upright) roll_ = SO3::exp({0, 0, std::numbers::pi / 2});
  }

  void addAt(const Eigen::Vector2d& pixel, std::vector<ViewCandidate>& candidates) {
    const auto ray = camera_.unproject(pixel);
    const auto square = squarePose(camera_, pixel);
    if (!ray || !square) return;
    for (const double span : kSpans) {
      const auto distance = distanceFor(span, *ray, *square);
      if (!distance || *distance < limits_.nearest_m || *distance > limits_.farthest_m) continue;
      for (const double across : kTiltsDeg) {
        for (const double along : kTiltsDeg) {
          const BoardTilt tilt = {.right_rad = kRadPerDeg * across, .lower_rad = kRadPerDeg * along};
          const SE3 pose = poseOf(*square * tiltedBoard(tilt), *distance * *ray);
          if (auto candidate = look(pose)) candidates.push_back(std::move(*candidate));
        }
      }
    }
  }

 private:
  [[nodiscard]] SE3 poseOf(const SO3& camera_from_upright, const Eigen::Vector3d& middle_camera) const {
    const SO3 rotation = camera_from_upright * roll_;
    return {rotation, middle_camera - rotation * middle_};
  }

  void project(const SE3& camera_from_board) {
    for (std::size_t i = 0; i < points_board_.size(); ++i)
      points_camera_[i] = camera_from_board * points_board_[i];
    camera_.project(points_camera_, projections_);
  }

  // The distance at which the untilted board spans this share of the smaller side, as if nothing cut it off.
  [[nodiscard]] std::optional<double> distanceFor(double span, const Eigen::Vector3d& ray,
                                                  const SO3& square) {
    // From afar, where every lens is a pinhole, and then nearer as the lens shows it.
    constexpr double kAfar = 100;
    constexpr int kNumSteps = 4;
    double distance = kAfar * 2 * middle_.norm();
    for (int i = 0; i < kNumSteps; ++i) {
      project(poseOf(square, distance * ray));
      Eigen::AlignedBox2d box;
      for (const Projection& projection : projections_) {
        // Of a board this near the lens does not show all, and how much it would span cannot be told better.
        if (!projection.ok()) return i > 0 ? std::optional(distance) : std::nullopt;
        box.extend(projection.pixel);
      }
      distance *= box.sizes().maxCoeff() / (span * std::min(size_.width, size_.height));
    }
    return distance;
  }

  [[nodiscard]] bool isInside(const Projection& projection) const {
    const double margin = kMargin * std::min(size_.width, size_.height);
    return projection.ok() && projection.pixel.minCoeff() >= margin - 0.5 &&
           projection.pixel.x() < size_.width - 0.5 - margin &&
           projection.pixel.y() < size_.height - 0.5 - margin;
  }

  // Neighbouring corners of the selection stand for one or more squares; the least pixels a square.
  [[nodiscard]] double leastSquarePx() const {
    const auto at = [&](std::size_t row, std::size_t column) -> const Projection& {
      return projections_[row * columns_.size() + column];
    };
    double least = std::numeric_limits<double>::infinity();
    const auto measure = [&](const Projection& a, const Projection& b, int num_squares) {
      if (isInside(a) && isInside(b)) least = std::min(least, (a.pixel - b.pixel).norm() / num_squares);
    };
    for (std::size_t row = 0; row < rows_.size(); ++row) {
      for (std::size_t column = 0; column < columns_.size(); ++column) {
        if (column > 0)
          measure(at(row, column - 1), at(row, column), columns_[column] - columns_[column - 1]);
        if (row > 0) measure(at(row - 1, column), at(row, column), rows_[row] - rows_[row - 1]);
      }
    }
    return least;
  }

  [[nodiscard]] std::optional<ViewCandidate> look(const SE3& pose) {
    project(pose);
    ViewCandidate candidate{.camera_from_board = pose, .corners = {}};
    const Eigen::Vector3d normal = pose.rotation * Eigen::Vector3d::UnitZ();
    for (std::size_t i = 0; i < projections_.size(); ++i) {
      if (!isInside(projections_[i])) continue;
      if (normal.dot(points_camera_[i]) < kLeastSine * points_camera_[i].norm()) return std::nullopt;
      candidate.corners.push_back({.p_board = points_board_[i],
                                   .pixel = projections_[i].pixel,
                                   .sigma_px = std::numeric_limits<double>::quiet_NaN(),
                                   .weight = weight_});
    }
    candidate.is_whole = candidate.corners.size() == projections_.size();
    if (2 * candidate.corners.size() < projections_.size() || leastSquarePx() < kLeastSquarePx)
      return std::nullopt;
    if (!candidate.is_whole && !showsASide(pose)) return std::nullopt;
    return candidate;
  }

  // Which corners a part of a board shows can be told from a side of which both ends are seen, the paper
  // beyond the squares too.
  [[nodiscard]] bool showsASide(const SE3& pose) const {
    std::array<bool, 4> is_seen{};
    for (std::size_t i = 0; i < 4; ++i) is_seen[i] = isInside(camera_.project(pose * ends_[i]));
    for (std::size_t i = 0; i < 4; ++i) {
      if (is_seen[i] && is_seen[(i + 1) % 4]) return true;
    }
    return false;
  }

  const AnyCamera& camera_;
  ImageSize size_;
  CandidateLimits limits_;
  Eigen::Vector3d middle_;
  SO3 roll_;
  std::vector<int> columns_;  // of the board that points_board_ has
  std::vector<int> rows_;
  double weight_ = 1;
  std::array<Eigen::Vector3d, 4> ends_;  // of the squares and a little paper, in turn around the board
  std::vector<Eigen::Vector3d> points_board_;
  std::vector<Eigen::Vector3d> points_camera_;  // of the last projection, as the next
  std::vector<Projection> projections_;
};

}  // namespace

std::vector<ViewCandidate> viewCandidates(const AnyCamera& camera, ImageSize size, const Checkerboard& board,
                                          const CandidateLimits& limits) {
  CandidateMaker maker(camera, size, board, limits);
  const bool is_wide = size.width >= size.height;
  const int columns = is_wide ? kPlacesAlong : kPlacesAcross;
  const int rows = is_wide ? kPlacesAcross : kPlacesAlong;
  std::vector<ViewCandidate> candidates;
  for (int row = 0; row < rows; ++row) {
    for (int column = 0; column < columns; ++column) {
      maker.addAt({(column + 0.5) / columns * size.width - 0.5, (row + 0.5) / rows * size.height - 0.5},
                  candidates);
    }
  }
  return candidates;
}

}  // namespace alidade
