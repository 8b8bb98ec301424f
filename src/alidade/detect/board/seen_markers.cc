// SPDX-License-Identifier: MIT
#include "alidade/detect/board/seen_markers.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <optional>
#include <utility>

#include <opencv2/aruco.hpp>
#include <opencv2/imgproc.hpp>

#include "alidade/target/charuco_board.h"

namespace alidade {
namespace {

using Quad = std::vector<cv::Point2f>;

// OpenCV only reads.
cv::Mat matOf(const GrayImage& image) {
  return {image.size.height, image.size.width, CV_8UC1, const_cast<std::uint8_t*>(image.pixels.data())};
}

// A print and OpenCV's settings for it.
struct PrintReader {
  explicit PrintReader(const MarkerPrint& print)
      : known(findMarkerDictionary(print.dictionary).value()),
        dictionary(cv::aruco::getPredefinedDictionary(known.opencv_id)),
        border(print.border) {
    // Among fewer bits, correcting as many errors as a dictionary can finds its markers in any clutter.
    constexpr int kManyBits = 6;
    if (known.num_bits >= kManyBits) correction_rate = 1.0;
  }

  MarkerDictionary known;
  cv::Ptr<cv::aruco::Dictionary> dictionary;
  int border = 1;
  double correction_rate = 0.6;
};

constexpr int kCellPx = 8;
constexpr double kCellMargin = 0.2;  // of a cell, on each side
constexpr double kMostBorderErrors = 0.35;

// 1 for each bright cell of a quadrilateral in the image, the border's cells included; empty without
// contrast.
cv::Mat brightCells(const cv::Mat& image, const Quad& corners, int num_cells) {
  const auto side = static_cast<float>(num_cells * kCellPx - 1);
  const Quad upright = {{0, 0}, {side, 0}, {side, side}, {0, side}};
  cv::Mat flat;
  cv::warpPerspective(image, flat, cv::getPerspectiveTransform(corners, upright),
                      cv::Size(num_cells * kCellPx, num_cells * kCellPx), cv::INTER_NEAREST);
  constexpr double kLeastDeviation = 5;
  cv::Scalar mean;
  cv::Scalar deviation;
  cv::meanStdDev(flat, mean, deviation);
  if (deviation[0] < kLeastDeviation) return {};
  cv::threshold(flat, flat, 125, 255, cv::THRESH_BINARY | cv::THRESH_OTSU);
  cv::Mat cells(num_cells, num_cells, CV_8UC1);
  const int margin = static_cast<int>(kCellMargin * kCellPx);
  const int inner = kCellPx - 2 * margin;
  for (int row = 0; row < num_cells; ++row) {
    for (int column = 0; column < num_cells; ++column) {
      const cv::Mat cell = flat(cv::Rect(column * kCellPx + margin, row * kCellPx + margin, inner, inner));
      cells.at<std::uint8_t>(row, column) = 2 * cv::countNonZero(cell) > inner * inner ? 1 : 0;
    }
  }
  return cells;
}

// The marker that a quadrilateral shows, its corners turned as the marker's; pixels of the searched image.
std::optional<std::pair<int, Quad>> readMarker(const cv::Mat& cells, const Quad& corners,
                                               const PrintReader& reader) {
  const int num_bits = reader.known.num_bits;
  const cv::Rect inner(reader.border, reader.border, num_bits, num_bits);
  const auto most = static_cast<int>(kMostBorderErrors * num_bits * num_bits);
  for (const bool is_inverted : {false, true}) {
    const cv::Mat seen = is_inverted ? cv::Mat(1 - cells) : cells;
    const cv::Mat bits = seen(inner).clone();
    if (cv::countNonZero(seen) - cv::countNonZero(bits) > most) continue;
    int id = 0;
    int turns = 0;
    if (!reader.dictionary->identify(bits, id, turns, reader.correction_rate)) return std::nullopt;
    Quad turned = corners;
    std::rotate(turned.begin(), turned.end() - turns, turned.end());
    return std::pair(id, turned);
  }
  return std::nullopt;
}

SeenMarker inImage(int id, const Quad& corners, double scale) {
  SeenMarker marker{.id = id, .corners = {}};
  for (std::size_t k = 0; k < 4; ++k) {
    const Eigen::Vector2d at(corners[k].x, corners[k].y);
    marker.corners[k] = (at + Eigen::Vector2d(0.5, 0.5)) / scale - Eigen::Vector2d(0.5, 0.5);
  }
  return marker;
}

cv::Ptr<cv::aruco::DetectorParameters> searchParameters(const PrintReader& reader) {
  auto parameters = cv::aruco::DetectorParameters::create();
  parameters->markerBorderBits = reader.border;
  parameters->detectInvertedMarker = true;
  parameters->minMarkerPerimeterRate = 0.02;
  parameters->adaptiveThreshWinSizeMax = 43;
  parameters->perspectiveRemovePixelPerCell = kCellPx;
  parameters->perspectiveRemoveIgnoredMarginPerCell = kCellMargin;
  parameters->maxErroneousBitsInBorderRate = kMostBorderErrors;
  parameters->errorCorrectionRate = reader.correction_rate;
  return parameters;
}

}  // namespace

std::vector<MarkerLook> markerLooks(ImageSize size) {
  constexpr int kLeastSide = 12;  // no marker is seen in less
  constexpr int kQuickSide = 1000;
  constexpr int kLargeSide = 2400;
  constexpr int kSmallSide = 1600;
  const int longer = std::max(size.width, size.height);
  const int shorter = std::min(size.width, size.height);
  const auto fractionFor = [&](int side) { return (longer + side - 1) / side; };
  const int usual = fractionFor(kLargeSide);
  const int quick = std::max(2 * usual, fractionFor(kQuickSide));
  std::vector<MarkerLook> looks;
  if (longer > kQuickSide && shorter / quick >= kLeastSide)
    looks.push_back({.scale = 1.0 / quick, .is_quick = true});
  if (shorter / usual >= kLeastSide) looks.push_back({.scale = 1.0 / usual});
  if (longer <= kSmallSide && shorter >= kLeastSide) looks.push_back({.scale = 2});
  return looks;
}

std::vector<std::vector<SeenMarker>> seeMarkers(const GrayImage& image, std::span<const MarkerPrint> prints,
                                                MarkerLook look, std::size_t enough) {
  cv::Mat searched = matOf(image);
  if (look.scale != 1) {
    const int fraction = look.scale < 1 ? static_cast<int>(std::lround(1 / look.scale)) : 1;
    const cv::Rect whole(0, 0, image.size.width / fraction * fraction,
                         image.size.height / fraction * fraction);
    cv::resize(searched(whole), searched, {}, look.scale, look.scale,
               look.scale > 1 ? cv::INTER_CUBIC : cv::INTER_AREA);
  }
  std::vector<std::vector<SeenMarker>> markers(prints.size());
  std::vector<Quad> rest;
  if (!prints.empty()) {
    const PrintReader reader(prints[0]);
    std::vector<Quad> found;
    std::vector<int> ids;
    cv::aruco::detectMarkers(searched, reader.dictionary, found, ids, searchParameters(reader), rest);
    for (std::size_t i = 0; i < ids.size(); ++i) markers[0].push_back(inImage(ids[i], found[i], look.scale));
  }
  std::map<int, std::vector<cv::Mat>> cells_of;  // by their number along a side
  for (std::size_t p = 1; p < prints.size() && markers[p - 1].size() < enough; ++p) {
    const PrintReader reader(prints[p]);
    const int num_cells = reader.known.num_bits + 2 * reader.border;
    std::vector<cv::Mat>& cells = cells_of[num_cells];
    for (std::size_t i = cells.size(); i < rest.size(); ++i)
      cells.push_back(brightCells(searched, rest[i], num_cells));
    for (std::size_t i = 0; i < rest.size(); ++i) {
      const auto read = cells[i].empty() ? std::nullopt : readMarker(cells[i], rest[i], reader);
      if (read) markers[p].push_back(inImage(read->first, read->second, look.scale));
    }
  }
  return markers;
}

}  // namespace alidade
