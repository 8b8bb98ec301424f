// SPDX-License-Identifier: MIT
#include "alidade/detect/board/seen_markers.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <optional>
#include <utility>

#include <opencv2/imgproc.hpp>

#include "alidade/detect/corner/grey_at.h"
#include "alidade/imagery/gray_image.h"
#include "alidade/imagery/opencv_versions.h"
#include "alidade/target/board_kinds.h"

namespace alidade {
namespace {

using Quad = std::vector<cv::Point2f>;

// A print and OpenCV's settings for it.
struct PrintReader {
  explicit PrintReader(const MarkerPrint& print)
      : known(findMarkerDictionary(print.dictionary).value()),
        dictionary(detail::markerDictionary(known.opencv_id)),
        border(print.border),
        is_apart(print.is_apart) {
    // With fewer bits, correcting all errors that the dictionary allows would find its markers in any
    // clutter.
    constexpr int kManyBits = 6;
    if (known.num_bits >= kManyBits) correction_rate = 1.0;
  }

  MarkerDictionary known;
  cv::aruco::Dictionary dictionary;
  int border = 1;
  bool is_apart = false;
  double correction_rate = 0.6;
};

constexpr int kCellPx = 8;
constexpr double kCellMargin = 0.2;  // share of a cell, on each side
constexpr double kMostBorderErrors = 0.35;

// A quadrilateral of the image whose sides are divided into cells.
class CellFrame {
 public:
  CellFrame(const GrayImage& image, const Quad& corners, int num_cells) : image_(image) {
    const auto side = static_cast<float>(num_cells);
    const Quad upright = {{0, 0}, {side, 0}, {side, side}, {0, side}};
    image_from_cells_ = cv::Matx33d(cv::getPerspectiveTransform(upright, corners));
  }

  // Grey value at a place in cells; places outside the image have the value of its border.
  [[nodiscard]] double levelAt(double across, double down) const {
    const cv::Vec3d p = image_from_cells_ * cv::Vec3d(across, down, 1);
    const double x = std::clamp(p[0] / p[2], 0.0, image_.size.width - 1.0);
    const double y = std::clamp(p[1] / p[2], 0.0, image_.size.height - 1.0);
    return greyAt(image_, {x, y}).value_or(0);
  }

 private:
  const GrayImage& image_;
  cv::Matx33d image_from_cells_;
};

// True if the sides of a quadrilateral are edges. A border wider than the window of the threshold also has an
// inner outline, behind which the border continues.
bool hasEdges(const GrayImage& image, const Quad& corners, int num_cells) {
  const CellFrame frame(image, corners, num_cells);
  constexpr double kLeastContrast = 10;
  constexpr double kOff = 0.5;  // in cells, on either side
  double sum = 0;
  int count = 0;
  for (double share = 0.25; share <= 0.75; share += 0.125) {
    const double along = share * num_cells;
    const auto across = [&](double side, double outwards) {
      sum += frame.levelAt(along, side + outwards) - frame.levelAt(along, side - outwards);
      sum += frame.levelAt(side + outwards, along) - frame.levelAt(side - outwards, along);
      count += 2;
    };
    across(0, -kOff);
    across(num_cells, kOff);
  }
  return std::abs(sum) >= kLeastContrast * count;
}

// Mean grey value of each cell of a quadrilateral in the image, including the cells of the border.
cv::Mat cellLevels(const GrayImage& image, const Quad& corners, int num_cells) {
  const CellFrame frame(image, corners, num_cells);
  constexpr std::array kPlaces = {0.27, 0.42, 0.58, 0.73};  // positions in a cell
  cv::Mat levels(num_cells, num_cells, CV_64FC1);
  for (int row = 0; row < num_cells; ++row) {
    for (int column = 0; column < num_cells; ++column) {
      double sum = 0;
      for (const double down : kPlaces) {
        for (const double across : kPlaces) sum += frame.levelAt(column + across, row + down);
      }
      levels.at<double>(row, column) = sum / (kPlaces.size() * kPlaces.size());
    }
  }
  return levels;
}

// Midway between dark and bright cells; nothing without contrast.
std::optional<double> midLevel(const cv::Mat& levels) {
  constexpr double kLeastDeviation = 5;
  cv::Scalar mean;
  cv::Scalar deviation;
  cv::meanStdDev(levels, mean, deviation);
  if (deviation[0] < kLeastDeviation) return std::nullopt;
  double mid = mean[0];
  constexpr int kRounds = 5;
  for (int round = 0; round < kRounds; ++round) {
    const cv::Mat is_bright = levels > mid;
    const cv::Mat is_dark = levels <= mid;
    mid = 0.5 * (cv::mean(levels, is_bright)[0] + cv::mean(levels, is_dark)[0]);
  }
  return mid;
}

// The marker in a quadrilateral, with its corners in the order of the marker's; pixels of the searched image.
std::optional<std::pair<int, Quad>> readMarker(const cv::Mat& levels, const Quad& corners,
                                               const PrintReader& reader) {
  const int num_bits = reader.known.num_bits;
  const cv::Rect inner(reader.border, reader.border, num_bits, num_bits);
  const auto most = static_cast<int>(kMostBorderErrors * num_bits * num_bits);
  // Blur raises dark bits between bright ones as much as it lowers the bright ones. The outer cells of a wide
  // border stay dark and would lower the threshold, so only the innermost ring of the border counts.
  const cv::Rect around(reader.border - 1, reader.border - 1, num_bits + 2, num_bits + 2);
  const auto mid = midLevel(levels(around));
  if (!mid) return std::nullopt;
  const cv::Mat cells = (levels > *mid) / 255;
  for (const bool is_inverted : {false, true}) {
    const cv::Mat seen = is_inverted ? cv::Mat(1 - cells) : cells;
    const cv::Mat bits = seen(inner).clone();
    if (cv::countNonZero(seen) - cv::countNonZero(bits) > most) continue;
    int id = 0;
    int turns = 0;
    if (!reader.dictionary.identify(bits, id, turns, reader.correction_rate)) return std::nullopt;
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

cv::aruco::DetectorParameters searchParameters(const PrintReader& reader) {
  cv::aruco::DetectorParameters parameters;
  parameters.markerBorderBits = reader.border;
  parameters.detectInvertedMarker = true;
  parameters.minMarkerPerimeterRate = 0.02;
  parameters.adaptiveThreshWinSizeMax = 43;
  parameters.perspectiveRemovePixelPerCell = kCellPx;
  parameters.perspectiveRemoveIgnoredMarginPerCell = kCellMargin;
  parameters.maxErroneousBitsInBorderRate = kMostBorderErrors;
  parameters.errorCorrectionRate = reader.correction_rate;
  return parameters;
}

}  // namespace

int MarkerPrint::numCells() const {
  return findMarkerDictionary(dictionary).value().num_bits + 2 * border;
}

std::vector<MarkerLook> markerLooks(ImageSize size) {
  constexpr int kLeastSide = 12;  // no marker is visible in fewer pixels
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
  GrayImage scaled;
  if (look.scale < 1) scaled = detail::shrunk(image, static_cast<int>(std::lround(1 / look.scale)));
  if (look.scale > 1) {
    const int factor = static_cast<int>(look.scale);
    scaled = {
        .size = {factor * image.size.width, factor * image.size.height},
        .pixels = std::vector<std::uint8_t>(static_cast<std::size_t>(factor * factor) * image.pixels.size())};
    cv::Mat out = detail::matOf(scaled);
    cv::resize(detail::matOf(image), out, out.size(), 0, 0, cv::INTER_CUBIC);
  }
  const GrayImage& searched = look.scale == 1 ? image : scaled;
  std::vector<std::vector<SeenMarker>> markers(prints.size());
  std::vector<Quad> rest;
  if (!prints.empty()) {
    const PrintReader reader(prints[0]);
    std::vector<Quad> found;
    std::vector<int> ids;
    detail::findMarkers(detail::matOf(searched), reader.dictionary, searchParameters(reader), found, ids,
                        rest);
    const int num_cells = prints[0].numCells();
    for (std::size_t i = 0; i < ids.size(); ++i) {
      if (reader.is_apart && !hasEdges(searched, found[i], num_cells)) continue;
      markers[0].push_back(inImage(ids[i], found[i], look.scale));
    }
  }
  std::map<int, std::vector<cv::Mat>> levels_of;  // by the number of cells along a side
  for (std::size_t p = 1; p < prints.size() && markers[p - 1].size() < enough; ++p) {
    const PrintReader reader(prints[p]);
    const int num_cells = prints[p].numCells();
    std::vector<cv::Mat>& levels = levels_of[num_cells];
    for (std::size_t i = levels.size(); i < rest.size(); ++i)
      levels.push_back(cellLevels(searched, rest[i], num_cells));
    for (std::size_t i = 0; i < rest.size(); ++i) {
      const auto read = readMarker(levels[i], rest[i], reader);
      if (read && (!reader.is_apart || hasEdges(searched, rest[i], num_cells)))
        markers[p].push_back(inImage(read->first, read->second, look.scale));
    }
  }
  return markers;
}

}  // namespace alidade
