// SPDX-License-Identifier: MIT
#include "alidade/imagery/remap_table.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <limits>
#include <numeric>
#include <optional>
#include <span>
#include <utility>

#include "alidade/core/error.h"
#include "alidade/core/parallel.h"
#include "alidade/imagery/tile_polynomial.h"
#include "alidade/imagery/view_rays.h"

namespace alidade {
namespace {

constexpr float kNaN = std::numeric_limits<float>::quiet_NaN();

constexpr int kTileSide = 160;         // pixels, of the first tiles
constexpr int kExactArea = 128;        // pixels that are projected one by one rather than split any further
constexpr double kPathStep = 4;        // pixels
constexpr double kMaxError = 1e-5;     // px, at the checked places: a tenth of what is promised
constexpr double kAwayFactor = 100;    // by which an error between the checked places may be larger
constexpr double kMaxRounding = 2e-5;  // px, of floats on the way to a result
constexpr double kCosMargin = 1e-12;   // of the camera's own comparison, which rounds
constexpr std::size_t kNumNodes = TilePolynomial::kNumNodes * TilePolynomial::kNumNodes;
constexpr std::size_t kGroup = TilePolynomial::kGroup;

// Places of a tile in the coordinates of its polynomial, and where the camera sees their rays.
class Samples {
 public:
  explicit Samples(const Tile& tile)
      : tile_(tile), half_width_(0.5 * (tile.width - 1)), half_height_(0.5 * (tile.height - 1)) {}

  template <std::size_t kCount>
  void addGrid(const ViewRays& rays, const std::array<double, kCount>& places) {
    std::array<ViewRays::Column, kCount> columns;
    for (std::size_t i = 0; i < kCount; ++i)
      columns[i] = rays.column(tile_.x + half_width_ * (1 + places[i]));
    for (const double t : places) {
      const ViewRays::Row row = rays.row(tile_.y + half_height_ * (1 + t));
      for (std::size_t i = 0; i < kCount; ++i) add(places[i], t, ViewRays::ray(columns[i], row));
    }
  }

  void addPixel(const ViewRays& rays, const Eigen::Vector2d& place) {
    add((place.x() - tile_.x) / half_width_ - 1, (place.y() - tile_.y) / half_height_ - 1,
        ViewRays::ray(rays.column(place.x()), rays.row(place.y())));
  }

  // Where the camera sees the places added since the last call; NaN where it sees nothing.
  std::span<const Projection> project(const AnyCamera& camera) {
    const std::size_t first = std::exchange(num_projected_, size_);
    const std::span<Projection> sources(sources_.data() + first, size_ - first);
    camera.project({rays_.data() + first, sources.size()}, sources);
    return sources;
  }

  // Largest difference of a coordinate between the polynomial and the camera; NaN if there is one.
  [[nodiscard]] double largestError(const TilePolynomial& polynomial) const {
    std::array<double, kMaxSize> x;
    std::array<double, kMaxSize> y;
    const std::size_t padded = (size_ + kGroup - 1) / kGroup * kGroup;
    polynomial.evaluate({s_.data(), padded}, {t_.data(), padded}, x.data(), y.data());
    double error = 0;
    for (std::size_t i = 0; i < size_; ++i) {
      const Eigen::Vector2d& source = sources_[i].pixel;
      const double e = std::max(std::abs(x[i] - source.x()), std::abs(y[i] - source.y()));
      if (std::isnan(e)) return e;
      error = std::max(error, e);
    }
    return error;
  }

 private:
  static constexpr std::size_t kMaxSize = 256;
  static_assert(kMaxSize % kGroup == 0);
  static_assert(kMaxSize >= 2 * kNumNodes + static_cast<std::size_t>(1.5 * kTileSide / kPathStep) + 1);

  void add(double s, double t, const Eigen::Vector3d& ray) {
    s_[size_] = s;
    t_[size_] = t;
    rays_[size_++] = ray;
  }

  const Tile& tile_;
  double half_width_;
  double half_height_;
  std::size_t size_ = 0;
  std::size_t num_projected_ = 0;
  std::array<double, kMaxSize> s_{};  // zeros fill up the last group
  std::array<double, kMaxSize> t_{};
  std::array<Eigen::Vector3d, kMaxSize> rays_;
  std::array<Projection, kMaxSize> sources_;
};

// Fills the pixels of a table tile by tile. Where the lens is smooth a tile is a polynomial, checked against
// the camera between its nodes; where it is not, and about the ends of the camera's cone, tiles are halved
// until few pixels are left, which are projected themselves.
class TableFiller {
 public:
  TableFiller(const AnyCamera& camera, ImageSize source_size, const OutputView& view, SourcePixel* pixels)
      : camera_(camera),
        view_(view),
        rays_(view),
        right_(source_size.width - 0.5),
        bottom_(source_size.height - 0.5),
        // Floats near the border are off by what is allowed and half a unit in their last place.
        margin_(4 * (kMaxError + kMaxRounding) +
                std::numeric_limits<float>::epsilon() * std::max(source_size.width, source_size.height)),
        cos_max_angle_(std::cos(camera.cone().max_angle_rad)),
        pixels_(pixels) {}

  [[nodiscard]] const Tile& pixelsWithRay() const { return rays_.pixelsWithRay(); }

  // Writes all pixels of a tile, which all have rays, and returns how many have a source.
  std::size_t fill(const Tile& tile) const {
    const ViewRays::AxisRange range = rays_.axisRange(tile);
    if (range.max_cos < cos_max_angle_ - kCosMargin) return fillNone(tile);
    if (tile.width * tile.height <= kExactArea ||
        std::min(tile.width, tile.height) < TilePolynomial::kMinSide)
      return fillExactly(tile);
    if (range.min_cos > cos_max_angle_ + kCosMargin) {
      if (const auto count = fillSmoothly(tile, range)) return *count;
    }
    const auto [first, second] = halves(tile);
    return fill(first) + fill(second);
  }

  std::size_t fillNone(const Tile& tile) const {
    for (int y = tile.y; y < tile.y + tile.height; ++y)
      std::fill_n(at(tile.x, y), tile.width, SourcePixel{kNaN, kNaN});
    return 0;
  }

 private:
  static std::pair<Tile, Tile> halves(const Tile& tile) {
    Tile first = tile;
    Tile second = tile;
    if (tile.width >= tile.height) {
      first.width /= 2;
      second.x += first.width;
      second.width -= first.width;
    } else {
      first.height /= 2;
      second.y += first.height;
      second.height -= first.height;
    }
    return {first, second};
  }

  [[nodiscard]] SourcePixel* at(int x, int y) const {
    return pixels_ + static_cast<std::ptrdiff_t>(y) * view_.size.width + x;
  }

  [[nodiscard]] SourcePixel sourceOf(const Projection& source) const {
    // False for NaN too.
    const bool is_inside = source.ok() && source.pixel.x() >= -0.5 && source.pixel.x() < right_ &&
                           source.pixel.y() >= -0.5 && source.pixel.y() < bottom_;
    if (!is_inside) return {kNaN, kNaN};
    return {static_cast<float>(source.pixel.x()), static_cast<float>(source.pixel.y())};
  }

  std::size_t fillExactly(const Tile& tile) const {
    std::size_t count = 0;
    for (int y = tile.y; y < tile.y + tile.height; ++y) {
      const ViewRays::Row row = rays_.row(y);
      for (int x = tile.x; x < tile.x + tile.width; ++x) {
        SourcePixel& pixel = *at(x, y);
        pixel = sourceOf(camera_.project(ViewRays::ray(rays_.column(x), row)));
        count += pixel.exists() ? 1 : 0;
      }
    }
    return count;
  }

  // By a polynomial; nothing if the tile is not smooth enough for one.
  std::optional<std::size_t> fillSmoothly(const Tile& tile, const ViewRays::AxisRange& range) const {
    Samples samples(tile);
    samples.addGrid(rays_, TilePolynomial::nodes());
    std::array<Eigen::Vector2d, kNumNodes> values;
    const std::span<const Projection> sources = samples.project(camera_);
    for (std::size_t i = 0; i < kNumNodes; ++i) values[i] = sources[i].pixel;
    const TilePolynomial polynomial(values);
    const Eigen::Vector2d spread = polynomial.spread();
    samples.addGrid(rays_, TilePolynomial::middles());
    samples.project(camera_);
    const double error = samples.largestError(polynomial);
    const Eigen::Array2d low = polynomial.centre() - spread;
    const Eigen::Array2d high = polynomial.centre() + spread;
    const Eigen::Array2d end(right_, bottom_);
    // Where all is far outside of the image, a rough polynomial is enough to know it.
    const auto is_away = [&](double largest_error) {
      const double slack = kAwayFactor * largest_error + margin_;
      return (high < -0.5 - slack).any() || (low > end + slack).any();
    };
    const double rounding = std::numeric_limits<float>::epsilon() * spread.maxCoeff();
    const bool is_fine = error <= kMaxError && rounding <= kMaxRounding;
    if (!is_fine && !is_away(error)) return std::nullopt;
    // From the ray nearest to the optical axis to the farthest one: across whatever rings a lens has.
    const Eigen::Vector2d way = range.farthest - range.nearest;
    const int num_steps = static_cast<int>(way.norm() / kPathStep) + 1;
    for (int i = 1; i < num_steps; ++i) samples.addPixel(rays_, range.nearest + way * i / num_steps);
    samples.project(camera_);
    const double path_error = samples.largestError(polynomial);
    if (is_away(path_error)) return fillNone(tile);
    if (!is_fine || !(path_error <= kMaxError)) return std::nullopt;
    polynomial.write(tile.width, tile.height, at(tile.x, tile.y), view_.size.width);
    if ((low > -0.5 + margin_).all() && (high < end - margin_).all())
      return static_cast<std::size_t>(tile.width) * static_cast<std::size_t>(tile.height);
    std::size_t count = 0;
    for (int y = tile.y; y < tile.y + tile.height; ++y) count += clipRow(tile, y);
    return count;
  }

  // Takes out the sources outside of the image, where those next to its border are projected themselves.
  // Returns how many are left.
  std::size_t clipRow(const Tile& tile, int y) const {
    SourcePixel* row = at(tile.x, y);
    const auto low = static_cast<float>(-0.5 - margin_);
    const auto right = static_cast<float>(right_ + margin_);
    const auto bottom = static_cast<float>(bottom_ + margin_);
    const auto inner_low = static_cast<float>(-0.5 + margin_);
    const auto inner_right = static_cast<float>(right_ - margin_);
    const auto inner_bottom = static_cast<float>(bottom_ - margin_);
    // Without branches, so that these loops become vector instructions.
    const auto is_outside = [=](const SourcePixel& p) {
      return static_cast<int>(p.x < low) | static_cast<int>(p.x > right) | static_cast<int>(p.y < low) |
             static_cast<int>(p.y > bottom);
    };
    const auto is_inside = [=](const SourcePixel& p) {
      return static_cast<int>(p.x >= inner_low) & static_cast<int>(p.x <= inner_right) &
             static_cast<int>(p.y >= inner_low) & static_cast<int>(p.y <= inner_bottom);
    };
    int num_inside = 0;
    int num_outside = 0;
    for (int i = 0; i < tile.width; ++i) {
      num_inside += is_inside(row[i]);
      num_outside += is_outside(row[i]);
    }
    auto count = static_cast<std::size_t>(num_inside);
    if (num_inside + num_outside < tile.width) {
      for (int i = 0; i < tile.width; ++i) {
        if (is_inside(row[i]) == 0 && is_outside(row[i]) == 0) count += fillExactly({tile.x + i, y, 1, 1});
      }
    }
    if (num_outside == 0) return count;
    for (int i = 0; i < tile.width; ++i) {
      const bool outside = is_outside(row[i]) != 0;
      row[i].x = outside ? kNaN : row[i].x;
      row[i].y = outside ? kNaN : row[i].y;
    }
    return count;
  }

  const AnyCamera& camera_;
  const OutputView& view_;
  ViewRays rays_;
  double right_;
  double bottom_;
  double margin_;
  double cos_max_angle_;
  SourcePixel* pixels_;
};

// The end of part i of n about equal parts.
int partEnd(int length, int i, int n) {
  return static_cast<int>(static_cast<std::int64_t>(length) * i / n);
}

}  // namespace

void fillRemapTable(const AnyCamera& camera, ImageSize source_size, const OutputView& view, RemapTable& table,
                    int num_jobs, const CancelFlag* cancel) {
  expect(view.size.width > 0 && view.size.height > 0, "an output image has pixels");
  const auto num_pixels =
      static_cast<std::size_t>(view.size.width) * static_cast<std::size_t>(view.size.height);
  // What is thrown leaves an empty table.
  std::vector<SourcePixel> pixels = std::move(std::exchange(table, {}).pixels);
  pixels.resize(num_pixels);
  const TableFiller filler(camera, source_size, view, pixels.data());
  const Tile& seen = filler.pixelsWithRay();
  const int end_x = seen.x + seen.width;
  const int end_y = seen.y + seen.height;
  filler.fillNone({0, 0, view.size.width, seen.y});
  filler.fillNone({0, end_y, view.size.width, view.size.height - end_y});
  filler.fillNone({0, seen.y, seen.x, seen.height});
  filler.fillNone({end_x, seen.y, view.size.width - end_x, seen.height});
  const int num_columns = (seen.width + kTileSide - 1) / kTileSide;
  const int num_rows = (seen.height + kTileSide - 1) / kTileSide;
  const auto num_tiles = static_cast<std::size_t>(num_columns) * static_cast<std::size_t>(num_rows);
  std::vector<std::size_t> num_with_source(num_tiles);
  parallelFor(
      num_tiles, num_jobs,
      [&](std::size_t i) {
        const int column = static_cast<int>(i) % num_columns;
        const int row = static_cast<int>(i) / num_columns;
        const int x = partEnd(seen.width, column, num_columns);
        const int y = partEnd(seen.height, row, num_rows);
        num_with_source[i] = filler.fill({.x = seen.x + x,
                                          .y = seen.y + y,
                                          .width = partEnd(seen.width, column + 1, num_columns) - x,
                                          .height = partEnd(seen.height, row + 1, num_rows) - y});
      },
      cancel);
  const std::size_t num_found =
      std::accumulate(num_with_source.begin(), num_with_source.end(), std::size_t{0});
  table = {.source_size = source_size,
           .size = view.size,
           .pixels = std::move(pixels),
           .num_without_source = num_pixels - num_found};
}

RemapTable makeRemapTable(const AnyCamera& camera, ImageSize source_size, const OutputView& view,
                          int num_jobs, const CancelFlag* cancel) {
  RemapTable table;
  fillRemapTable(camera, source_size, view, table, num_jobs, cancel);
  return table;
}

}  // namespace alidade
