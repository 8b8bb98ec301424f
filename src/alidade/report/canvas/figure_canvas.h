// SPDX-License-Identifier: MIT
#pragma once

#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include <Eigen/Core>
#include <Eigen/Geometry>

#include "alidade/core/image.h"

namespace alidade {

/// A figure of the report page: a drawing and the words around it.
struct Figure {
  std::string id = {};       ///< of the element, and the name of its file: "accuracy"
  std::string title = {};    ///< a few words
  std::string reading = {};  ///< one sentence on how to read it
  std::string alt = {};      ///< description with its numbers, for readers who cannot see it
  std::string svg = {};      ///< an <svg> element whose colours come from the page's style sheet
};

/// The figure with new ids, for a page with several of its kind.
/// @param prefix  of letters, digits and hyphens
[[nodiscard]] Figure withPrefix(Figure figure, const std::string& prefix);

/// Escapes `text` for HTML and XML, in an element or in an attribute in double quotes.
[[nodiscard]] std::string escapedMarkup(std::string_view text);

/// A coordinate: at most two decimals, without trailing zeros.
[[nodiscard]] std::string coordinate(double value);
/// "12.3,4 " as in paths.
[[nodiscard]] std::string pointText(const Eigen::Vector2d& point);
/// A path through the points: "M0,0 L1,2 ".
[[nodiscard]] std::string pathThrough(const std::vector<Eigen::Vector2d>& points, bool is_closed = false);

/// The corners of a box in turn, beginning with the least values.
[[nodiscard]] std::vector<Eigen::Vector2d> cornersOf(const Eigen::AlignedBox2d& box);

/// An arrow; a short one has no head, and an invisibly short one is omitted.
[[nodiscard]] std::string arrowPath(const Eigen::Vector2d& from, const Eigen::Vector2d& along);
/// A star with five points.
[[nodiscard]] std::string starPath(const Eigen::Vector2d& middle, double radius);

/// Round values for marks between low and high, at most `most` values.
[[nodiscard]] std::vector<double> roundTicks(double low, double high, int most);
/// Magnification of arrows, in words: "2000 times longer".
[[nodiscard]] std::string timesLonger(double times);
/// A value of 1, 2 or 5 times a power of ten, not above `value`. @pre positive
[[nodiscard]] double roundBelow(double value);
/// The value with three significant digits at most, without an exponent; "unknown" for NaN.
[[nodiscard]] std::string shortNumber(double value);
/// Two digits, for uncertain values; "unknown" for values that are not finite.
[[nodiscard]] std::string twoDigits(double value);

/// Colours from low (0) to high (1), pale enough for lines on top.
[[nodiscard]] std::string rampColour(double share);

/// A drawing (see FigureCanvas::svg()) as a separate file, with the style that it needs.
[[nodiscard]] std::string standaloneSvg(const std::string& svg);

/// A part of a drawing with its own coordinates.
struct PlotArea {
  Eigen::AlignedBox2d box;     ///< in the drawing; y downwards
  Eigen::Vector2d low{0, 0};   ///< values at its left and upper edge for images, lower edge for charts
  Eigen::Vector2d high{1, 1};  ///< at the opposite edges
  bool is_upward = true;       ///< y values increase upwards

  [[nodiscard]] Eigen::Vector2d at(double x, double y) const;
  [[nodiscard]] Eigen::Vector2d at(const Eigen::Vector2d& value) const { return at(value.x(), value.y()); }
  /// Length in the drawing of one unit of x.
  [[nodiscard]] double scale() const { return box.sizes().x() / (high.x() - low.x()); }
};

/// Classes of swatches and their labels, see FigureCanvas::addLegend().
using Legend = std::vector<std::pair<std::string, std::string>>;

/// The entries for the colours of cells, up to the largest RMS.
[[nodiscard]] Legend warmthLegend(double most_px);

/// The largest area with an image's aspect ratio in a drawing of this width, with room for marks.
[[nodiscard]] PlotArea imageArea(const ImageSize& size, double width);

/// Errors in a part of an image.
struct ErrorCell {
  int count = 0;
  double rms_px = 0;
  Eigen::Vector2d arrow{0, 0};  ///< mean error, as drawn
};

/// A drawing of the report in units in which text is kTextSize high. Colours and fonts are classes of
/// assets/figure.css, so that one drawing suits light and dark pages, and print.
class FigureCanvas {
 public:
  static constexpr double kWidth = 440;
  static constexpr double kFileWidth = 660;  ///< width of figure files, so that paths fit under them
  static constexpr double kTextSize = 11;
  static constexpr double kMarks = 22;  ///< room for the marks under an image

  explicit FigureCanvas(double height, double width = kWidth) : width_(width), height_(height) {}
  /// A drawing around an area. It ends `below` under the area, where a legend begins.
  explicit FigureCanvas(const PlotArea& area, double below = kMarks, double width = kWidth)
      : area_(area), width_(width), height_(area.box.max().y() + below) {}
  /// A drawing over an image. @param ground  class of the background
  FigureCanvas(const ImageSize& size, std::string_view ground);
  /// A chart without axes, of values from `low` to `high`.
  FigureCanvas(const Eigen::Vector2d& low, const Eigen::Vector2d& high);

  [[nodiscard]] double width() const { return width_; }
  [[nodiscard]] double height() const { return height_; }
  [[nodiscard]] const PlotArea& area() const { return area_; }
  /// Position in the drawing of a value in the area.
  [[nodiscard]] Eigen::Vector2d at(const Eigen::Vector2d& value) const { return area_.at(value); }
  [[nodiscard]] Eigen::Vector2d at(double x, double y) const { return area_.at(x, y); }
  [[nodiscard]] std::vector<Eigen::Vector2d> at(const std::vector<Eigen::Vector2d>& values) const;

  /// @param attributes  names of classes, or literal attributes: class="dots" rx="4"
  void open(std::string_view attributes);
  void close();
  void addPath(const std::string& d, std::string_view attributes);
  void addLine(const Eigen::Vector2d& from, const Eigen::Vector2d& to, std::string_view attributes);
  void addRect(const Eigen::Vector2d& low, const Eigen::Vector2d& high, std::string_view attributes);
  void addCircle(const Eigen::Vector2d& at, double radius, std::string_view attributes);
  /// @param anchor  start, middle or end
  void addText(const Eigen::Vector2d& at, std::string_view text, std::string_view anchor = "middle",
               std::string_view attributes = "");
  /// A rectangle over the whole area.
  void addArea(std::string_view attributes) { addRect(area_.box.min(), area_.box.max(), attributes); }
  /// A clip path with this id around the area.
  void addClip(std::string_view id);
  /// A ring with contrast to what lies below.
  void addRing(const Eigen::Vector2d& at, double radius);
  /// Arrows with contrast to what lies below. @param d  see arrowPath()
  void addMeanArrows(const std::string& d);
  /// Inserts SVG unchanged.
  void addRaw(std::string_view svg) { svg_ += svg; }

  /// Frame, marks with their values, and the names of both axes.
  void addAxes(std::string_view x_name, std::string_view y_name);
  /// The same with names at x = 1, 2, 3 and so on; if there are many, only every n-th.
  void addNamedAxes(const std::vector<std::string>& names, std::string_view x_name, std::string_view y_name);
  /// Only the names.
  void addNames(const std::vector<std::string>& names, std::string_view x_name);
  /// Frame and marks in pixels of an image.
  void addImageFrame();
  /// Rows of swatches with labels; the drawing grows to fit them. The first word of a class may be "line",
  /// "dot", "star" or, with the length before the class, "arrow 25"; otherwise it is a filled square.
  void addLegend(const Eigen::Vector2d& at, const Legend& legend);
  /// The same under the area.
  void addLegend(const Legend& legend) { addLegend({area_.box.min().x(), height_}, legend); }

  /// A row below the drawing with a bar of the ramp's colours between labels for its ends.
  void addRamp(std::string_view least, std::string_view most);
  /// Lines of text below the drawing, wrapped when too long.
  void addCaption(std::string_view text);
  /// Draws cells over an image row by row, coloured by RMS, with RMS and count as data-rms and data-count.
  /// @returns a path of their arrows
  std::string addErrorCells(int columns, int rows, const std::vector<ErrorCell>& cells);

  /// The complete element. @param alt  description for readers who cannot see it
  [[nodiscard]] std::string svg(std::string_view alt, std::string_view attributes = "") const;
  /// Adds the legend under the area, and returns the figure with the complete element.
  [[nodiscard]] Figure drawn(Figure words, const Legend& legend = {}, std::string_view attributes = "");

 private:
  // Frame, and marks of y.
  void addValues(std::string_view y_name);

  PlotArea area_;
  double width_;
  double height_;
  std::string svg_;
};

}  // namespace alidade
