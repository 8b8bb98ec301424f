// SPDX-License-Identifier: MIT
#include "alidade/detect/board/seen_markers.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <functional>
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

float areaOf(const Quad& q) {
  return 0.5F * std::abs((q[2] - q[0]).cross(q[3] - q[1]));
}

cv::Point2f middleOf(const Quad& q) {
  return 0.25F * (q[0] + q[1] + q[2] + q[3]);
}

// A print, and what its markers are compared with.
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
    const cv::Matx33d& h = image_from_cells_;
    const double by_depth = 1 / (h(2, 0) * across + h(2, 1) * down + h(2, 2));
    const double x = (h(0, 0) * across + h(0, 1) * down + h(0, 2)) * by_depth;
    const double y = (h(1, 0) * across + h(1, 1) * down + h(1, 2)) * by_depth;
    // NaN becomes 0.
    const auto inside = [](double at, int size) { return at > 0 ? std::min(at, size - 1.0) : 0.0; };
    return greyInside(image_, {inside(x, image_.size.width), inside(y, image_.size.height)});
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

// Mean grey values of the cells of a quadrilateral in the image, including those of the border.
class CellLevels {
 public:
  // Samples each cell at the given positions along both sides, from 0 to 1.
  CellLevels(const GrayImage& image, const Quad& corners, int num_cells, std::span<const double> positions)
      : num_cells_(num_cells) {
    const CellFrame frame(image, corners, num_cells);
    levels_.reserve(static_cast<std::size_t>(num_cells * num_cells));
    for (int row = 0; row < num_cells; ++row) {
      for (int column = 0; column < num_cells; ++column) {
        double sum = 0;
        for (const double down : positions) {
          for (const double across : positions) sum += frame.levelAt(column + across, row + down);
        }
        levels_.push_back(sum / static_cast<double>(positions.size() * positions.size()));
      }
    }
  }

  // Calls `f` with the level of each cell that is at least `margin` cells from the sides.
  template <class F>
  void forEachInside(int margin, const F& f) const {
    for (int row = margin; row < num_cells_ - margin; ++row) {
      for (int column = margin; column < num_cells_ - margin; ++column)
        f(levels_[static_cast<std::size_t>(row * num_cells_ + column)]);
    }
  }
  [[nodiscard]] int numAbove(double level, int margin) const {
    int num = 0;
    forEachInside(margin, [&](double of_cell) { num += of_cell > level ? 1 : 0; });
    return num;
  }
  // Share of the cells in the outermost ring whose colour differs from that of most.
  [[nodiscard]] double oddShare(double mid) const {
    const int odd = std::min(borderErrors(mid, 1, false), borderErrors(mid, 1, true));
    return odd / (4.0 * (num_cells_ - 1));
  }
  // Number of cells in the outer rings whose colour differs from that of a dark, or of a bright border.
  [[nodiscard]] int borderErrors(double mid, int border, bool is_inverted) const {
    const int inside = num_cells_ - 2 * border;
    const int num_bright = numAbove(mid, 0) - numAbove(mid, border);
    return is_inverted ? num_cells_ * num_cells_ - inside * inside - num_bright : num_bright;
  }
  // Variance within dark and within bright cells as a share of the squared contrast. It is small if the cells
  // are those of the print.
  [[nodiscard]] double spread(double mid) const {
    std::array<double, 2> count{};
    std::array<double, 2> sum{};
    double squares = 0;
    forEachInside(0, [&](double level) {
      const std::size_t side = level > mid ? 1 : 0;
      count[side] += 1;
      sum[side] += level;
      squares += level * level;
    });
    const std::array<double, 2> mean = {sum[0] / count[0], sum[1] / count[1]};
    const double within = (squares - sum[0] * mean[0] - sum[1] * mean[1]) / (count[0] + count[1]);
    return within / ((mean[1] - mean[0]) * (mean[1] - mean[0]));
  }
  // Midway between dark and bright cells; nothing without contrast.
  [[nodiscard]] std::optional<double> midLevel(int margin, double least_deviation) const {
    double count = 0;
    double sum = 0;
    double squares = 0;
    forEachInside(margin, [&](double level) {
      count += 1;
      sum += level;
      squares += level * level;
    });
    double mid = sum / count;
    if (!(squares / count - mid * mid > least_deviation * least_deviation)) return std::nullopt;
    constexpr int kRounds = 5;
    for (int round = 0; round < kRounds; ++round) {
      double num_bright = 0;
      double bright = 0;
      forEachInside(margin, [&](double level) {
        if (level > mid) {
          num_bright += 1;
          bright += level;
        }
      });
      mid = 0.5 * (bright / num_bright + (sum - bright) / (count - num_bright));
    }
    return mid;
  }

 private:
  int num_cells_;
  std::vector<double> levels_;  // row by row
};

struct Reading {
  int id = 0;
  int turns = 0;             // by a quarter, to the marker's first corner
  double spread = HUGE_VAL;  // see CellLevels
};

// The marker with these cells; nothing if there is none.
std::optional<Reading> readMarker(const CellLevels& levels, const PrintReader& reader) {
  // Blur raises dark bits between bright ones as much as it lowers the bright ones. The outer cells of a wide
  // border stay dark and would lower the threshold, so only the innermost ring of the border counts.
  constexpr double kLeastDeviation = 5;  // grey levels
  const auto mid = levels.midLevel(reader.border - 1, kLeastDeviation);
  if (!mid) return std::nullopt;
  const int num_bits = reader.known.num_bits;
  for (const bool is_inverted : {false, true}) {
    if (levels.borderErrors(*mid, reader.border, is_inverted) > kMostBorderErrors * num_bits * num_bits)
      continue;
    cv::Mat bits(num_bits, num_bits, CV_8UC1);
    auto* bit = bits.ptr<std::uint8_t>();
    levels.forEachInside(reader.border,
                         [&](double level) { *bit++ = (level > *mid) != is_inverted ? 1 : 0; });
    int id = 0;
    int turns = 0;
    if (!reader.dictionary.identify(bits, id, turns, reader.correction_rate)) return std::nullopt;
    return Reading{.id = id, .turns = turns, .spread = levels.spread(*mid)};
  }
  return std::nullopt;
}

// One quadrilateral of the image, whose cells are sampled once for all prints with the same number of cells.
class QuadReader {
 public:
  QuadReader(const GrayImage& image, const Quad& corners) : image_(image), corners_(corners) {}

  [[nodiscard]] std::optional<Reading> read(const PrintReader& reader) {
    const int num_cells = reader.known.num_bits + 2 * reader.border;
    const auto [at, is_new] = levels_.try_emplace(num_cells);
    if (is_new) at->second = sample(num_cells);
    const auto read = at->second ? readMarker(*at->second, reader) : std::nullopt;
    return read && reader.is_apart && !hasEdges(image_, corners_, num_cells) ? std::nullopt : read;
  }
  // True if the outer ring of cells has one colour, as far as prints were tried.
  [[nodiscard]] bool isFramed() const { return is_framed_; }

 private:
  // Nothing if the outer ring of cells cannot be that of a marker.
  [[nodiscard]] std::optional<CellLevels> sample(int num_cells) {
    constexpr std::array kCoarse = {0.5};  // positions in a cell
    constexpr std::array kFine = {0.27, 0.42, 0.58, 0.73};
    constexpr double kMostOdd = 0.45;  // share of the ring's cells with another colour
    constexpr double kFewOdd = 0.05;
    const CellLevels coarse(image_, corners_, num_cells, kCoarse);
    constexpr double kNoise = 1;  // grey levels; the fine samples decide on the contrast
    const auto mid = coarse.midLevel(0, kNoise);
    const double odd_share = mid ? coarse.oddShare(*mid) : 1;
    is_framed_ = is_framed_ || odd_share <= kFewOdd;
    if (odd_share > kMostOdd) return std::nullopt;
    return CellLevels(image_, corners_, num_cells, kFine);
  }

  const GrayImage& image_;
  const Quad& corners_;
  std::map<int, std::optional<CellLevels>> levels_;  // by the number of cells along a side
  bool is_framed_ = false;
};

// A marker by the outline and the dictionary that fit best. A square around a marker may be read as another
// marker by chance.
struct FoundMarker {
  Quad corners;
  std::size_t print = 0;
  Reading reading = {};

  // True for a quadrilateral with nearly the same middle.
  [[nodiscard]] bool isAround(const Quad& quad) const {
    constexpr float kNear = 1.0F / 64;  // squared distance, as a share of the area
    const cv::Point2f apart = middleOf(quad) - middleOf(corners);
    return apart.dot(apart) < kNear * areaOf(corners);
  }
};

// Quadrilaterals among the outlines of what is darker than its neighbourhood, largest first, clockwise in the
// image. Most are found more than once.
std::vector<Quad> findQuads(const cv::Mat& grey) {
  struct Comparison {
    int window;  // side of the neighbourhood, pixels
    int darker;  // grey levels
  };
  // Small windows keep outlines apart in blur and in shadows, and large ones see large markers whole. The
  // last one separates tags from the squares that touch their corners.
  constexpr std::array kComparisons = {Comparison{5, 7}, Comparison{15, 7}, Comparison{63, 7},
                                       Comparison{63, 30}};
  constexpr std::size_t kLeastOutline = 20;  // pixels
  constexpr double kLeastFilled =
      0.012;  // area over the square of the outline's length; an upright square has 0.06
  constexpr double kMostOff = 0.03;    // of the outline's length, between outline and quadrilateral
  constexpr double kLeastSide = 0.05;  // of the outline's length
  constexpr float kMarginPx = 3;
  std::vector<Quad> quads;
  cv::Mat mean;
  cv::Mat mask;
  std::vector<std::vector<cv::Point>> outlines;
  std::vector<cv::Vec4i> hierarchy;
  std::vector<cv::Point> polygon;
  for (const auto& [window, darker] : kComparisons) {
    cv::boxFilter(grey, mean, CV_8U, {window, window}, {-1, -1}, true, cv::BORDER_REPLICATE);
    cv::subtract(mean, grey, mask);
    cv::threshold(mask, mask, darker - 1, 255, cv::THRESH_BINARY);
    // With a hierarchy, all versions use one algorithm, in one thread.
    cv::findContours(mask, outlines, hierarchy, cv::RETR_LIST, cv::CHAIN_APPROX_NONE);
    for (const auto& outline : outlines) {
      const auto length = static_cast<double>(outline.size());
      if (outline.size() < kLeastOutline || cv::contourArea(outline) < kLeastFilled * length * length)
        continue;
      cv::approxPolyDP(outline, polygon, kMostOff * length, true);
      if (polygon.size() != 4 || !cv::isContourConvex(polygon)) continue;
      Quad quad(polygon.begin(), polygon.end());
      if ((quad[1] - quad[0]).cross(quad[2] - quad[0]) < 0) std::swap(quad[1], quad[3]);
      bool is_inside = true;
      bool is_wide = true;
      for (std::size_t k = 0; k < 4; ++k) {
        is_wide = is_wide && cv::norm(quad[k] - quad[(k + 1) % 4]) >= kLeastSide * length;
        is_inside = is_inside && quad[k].x >= kMarginPx && quad[k].y >= kMarginPx &&
                    quad[k].x < static_cast<float>(grey.cols) - kMarginPx &&
                    quad[k].y < static_cast<float>(grey.rows) - kMarginPx;
      }
      if (is_wide && is_inside) quads.push_back(std::move(quad));
    }
  }
  std::ranges::stable_sort(quads, std::greater(), areaOf);
  return quads;
}

SeenMarker inImage(int id, const Quad& corners, double scale) {
  SeenMarker marker{.id = id, .corners = {}};
  for (std::size_t k = 0; k < 4; ++k) {
    const Eigen::Vector2d at(corners[k].x, corners[k].y);
    marker.corners[k] = (at + Eigen::Vector2d(0.5, 0.5)) / scale - Eigen::Vector2d(0.5, 0.5);
  }
  return marker;
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

SeenMarkers seeMarkers(const GrayImage& image, std::span<const MarkerPrint> prints, MarkerLook look,
                       std::size_t enough) {
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
  const std::vector<PrintReader> readers(prints.begin(), prints.end());
  std::vector<FoundMarker> found;
  std::vector<std::size_t> num_found(prints.size());
  std::size_t num_prints = prints.size();
  int num_framed = 0;
  for (const Quad& quad : findQuads(detail::matOf(searched))) {
    const auto other = std::ranges::find_if(found, [&](const FoundMarker& of) { return of.isAround(quad); });
    constexpr float kSameSize = 0.9F;  // of the areas
    if (other != found.end() && areaOf(quad) > kSameSize * areaOf(other->corners)) continue;
    QuadReader reader(searched, quad);
    FoundMarker marker{.corners = quad};
    for (std::size_t p = 0; p < num_prints; ++p) {
      // An outline inside a wide border can be read with a narrower one: the order of prints decides.
      const bool is_read = !std::isinf(marker.reading.spread);
      if (is_read && prints[p].dictionary == prints[marker.print].dictionary) continue;
      const auto reading = reader.read(readers[p]);
      if (!reading || reading->spread >= marker.reading.spread) continue;
      marker.print = p;
      marker.reading = *reading;
    }
    num_framed += reader.isFramed() ? 1 : 0;
    if (std::isinf(marker.reading.spread)) continue;
    // Where the same marker is read again, the larger outline is its own.
    if (other != found.end() &&
        (marker.reading.id == other->reading.id || marker.reading.spread >= other->reading.spread))
      continue;
    if (++num_found[marker.print] >= enough) num_prints = std::min(num_prints, marker.print + 1);
    if (other == found.end()) {
      found.push_back(std::move(marker));
    } else {
      --num_found[other->print];
      *other = std::move(marker);
    }
  }
  SeenMarkers seen{.of_prints = std::vector<std::vector<SeenMarker>>(prints.size())};
  for (FoundMarker& marker : found) {
    std::rotate(marker.corners.begin(), marker.corners.end() - marker.reading.turns, marker.corners.end());
    seen.of_prints[marker.print].push_back(inImage(marker.reading.id, marker.corners, look.scale));
  }
  seen.num_framed = num_framed;
  return seen;
}

}  // namespace alidade
