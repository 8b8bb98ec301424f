// SPDX-License-Identifier: MIT
#include "alidade/detect/checkerboard_detector.h"

#include <algorithm>
#include <cmath>
#include <vector>

#include <opencv2/calib3d.hpp>
#include <opencv2/imgproc.hpp>

#include "alidade/core/error.h"
#include "alidade/detect/corner_order.h"

namespace alidade {
namespace {

// Half of the refinement window as a share of the distance to the nearest corner. The first window catches
// what the reduced image left; the last one stays clear of the neighbouring squares' edges.
constexpr double kCatchShare = 0.25;
constexpr double kFinalShare = 0.35;
// Printed boards often end in narrower squares: at the rim the window must not reach the board's edge.
constexpr double kRimShare = 0.22;
constexpr int kMinHalfWindow = 2;
constexpr int kMaxHalfWindow = 25;
// A corner that refinement moves further than this share of a square was not on a corner.
constexpr double kMaxMoveShare = 0.45;

// A view of the caller's pixels; OpenCV has no const matrices, and nothing here writes through it.
cv::Mat asMat(const GrayImage& image) {
  return {image.size.height, image.size.width, CV_8U, const_cast<std::uint8_t*>(image.pixels.data())};
}

bool searchAt(const cv::Mat& image, int side_px, const Checkerboard& board, CornerGrid& grid) {
  const double scale = std::min(1.0, static_cast<double>(side_px) / std::max(image.cols, image.rows));
  cv::Mat reduced = image;
  if (scale < 1.0) {
    const auto side = [scale](int full) { return std::max(1, static_cast<int>(std::lround(scale * full))); };
    cv::resize(image, reduced, {side(image.cols), side(image.rows)}, 0, 0, cv::INTER_AREA);
  }
  // The search filters with windows of some pixels; in less than this no board is to be seen anyway.
  constexpr int kMinSide = 16;
  if (std::min(reduced.cols, reduced.rows) < kMinSide) return false;
  std::vector<cv::Point2f> found;
  if (!cv::findChessboardCorners(reduced, {board.columns, board.rows}, found,
                                 cv::CALIB_CB_ADAPTIVE_THRESH | cv::CALIB_CB_NORMALIZE_IMAGE)) {
    return false;
  }
  // resize rounds the reduced size, so each axis has its own exact scale.
  const double sx = static_cast<double>(reduced.cols) / image.cols;
  const double sy = static_cast<double>(reduced.rows) / image.rows;
  grid.clear();
  for (const cv::Point2f& p : found) grid.emplace_back((p.x + 0.5) / sx - 0.5, (p.y + 0.5) / sy - 0.5);
  return true;
}

bool findGrid(const cv::Mat& image, const Checkerboard& board, const DetectorOptions& options,
              CornerGrid& grid) {
  if (searchAt(image, options.first_search_px, board, grid)) return true;
  return std::max(image.cols, image.rows) > options.first_search_px &&
         searchAt(image, options.last_search_px, board, grid);
}

// Refines one corner in a window of half-size share * spacing; false if it ran away.
bool refineCorner(const cv::Mat& image, double spacing, double share, Eigen::Vector2d& corner) {
  const int half = std::clamp(static_cast<int>(std::lround(share * spacing)), kMinHalfWindow, kMaxHalfWindow);
  std::vector<cv::Point2f> point = {
      cv::Point2f(static_cast<float>(corner.x()), static_cast<float>(corner.y()))};
  cv::cornerSubPix(image, point, {half, half}, {-1, -1},
                   {cv::TermCriteria::COUNT | cv::TermCriteria::EPS, 100, 1e-4});
  const Eigen::Vector2d moved(point[0].x, point[0].y);
  if (!((moved - corner).norm() <= kMaxMoveShare * spacing)) return false;
  corner = moved;
  return true;
}

bool isOnRim(const Checkerboard& board, int id) {
  const int column = id % board.columns;
  const int row = id / board.columns;
  return column == 0 || row == 0 || column + 1 == board.columns || row + 1 == board.rows;
}

bool refine(const cv::Mat& image, const Checkerboard& board, CornerGrid& grid) {
  for (const double inner_share : {kCatchShare, kFinalShare}) {
    const CornerGrid before = grid;
    for (int id = 0; id < board.numCorners(); ++id) {
      const double share = isOnRim(board, id) ? std::min(inner_share, kRimShare) : inner_share;
      if (!refineCorner(image, localSpacing(board, before, id), share, grid[static_cast<std::size_t>(id)]))
        return false;
    }
  }
  return true;
}

// All squares must be turned the same way round: a swapped or doubled corner breaks that.
bool isGrid(const Checkerboard& board, const CornerGrid& grid) {
  for (int row = 0; row + 1 < board.rows; ++row) {
    for (int column = 0; column + 1 < board.columns; ++column) {
      const auto id = static_cast<std::size_t>(row * board.columns + column);
      const Eigen::Vector2d a = grid[id + 1] - grid[id];
      const Eigen::Vector2d b = grid[id + static_cast<std::size_t>(board.columns)] - grid[id];
      if (!(a.x() * b.y() - a.y() * b.x() > 0)) return false;
    }
  }
  return true;
}

Detection refused(DetectionReason reason, std::string detail) {
  return {.reason = reason, .detail = std::move(detail), .corners = {}};
}

}  // namespace

std::string_view reasonCode(DetectionReason reason) {
  switch (reason) {
    case DetectionReason::kFound:
      return "found";
    case DetectionReason::kNoBoard:
      return "no_board";
    case DetectionReason::kLargerBoard:
      return "larger_board";
    case DetectionReason::kIrregular:
      return "irregular";
    case DetectionReason::kUnreadable:
      return "unreadable";
    case DetectionReason::kOtherSize:
      return "other_size";
  }
  return "unknown";
}

Detection detectCheckerboard(const GrayImage& image, const Checkerboard& board,
                             const DetectorOptions& options) {
  expect(!image.empty(), "the image has pixels");
  const cv::Mat mat = asMat(image);
  CornerGrid grid;
  if (!findGrid(mat, board, options, grid)) {
    return refused(DetectionReason::kNoBoard, "no board of " + std::to_string(board.columns) + "x" +
                                                  std::to_string(board.rows) + " inner corners seen whole");
  }
  grid = orderCorners(image, board, std::move(grid));
  if (!refine(mat, board, grid) || !isGrid(board, grid)) {
    return refused(DetectionReason::kIrregular, "the corners found do not form a regular grid");
  }
  if (!sidesThatContinue(image, board, grid).empty()) {
    return refused(DetectionReason::kLargerBoard, "the squares go on beyond " +
                                                      std::to_string(board.columns) + "x" +
                                                      std::to_string(board.rows) + " inner corners");
  }
  Detection detection;
  detection.reason = DetectionReason::kFound;
  for (int id = 0; id < board.numCorners(); ++id) {
    Corner corner;
    corner.id = id;
    corner.pixel = grid[static_cast<std::size_t>(id)];
    detection.corners.push_back(corner);
  }
  return detection;
}

}  // namespace alidade
