// SPDX-License-Identifier: MIT
#include "alidade/report/canvas/figure_canvas.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

#include <fmt/format.h>

#include "alidade/core/mapped.h"
#include "alidade/core/text.h"
#include "alidade/report/canvas/report_assets.h"

namespace alidade {
namespace {

using Eigen::Vector2d;

constexpr double kLegendRow = 17;
constexpr double kLetterWidth = 7.2;  // average for a sans-serif font at the size on small screens

// "0.25" for a step of 0.05: as many decimals as the step has.
std::string tickText(double value, double step) {
  const int decimals = std::max(0, -static_cast<int>(std::floor(std::log10(step) + 1e-9)));
  return fmt::format("{:.{}f}", value == 0 ? 0.0 : value, decimals);
}

// Turns names of classes into an attribute; returns attributes unchanged.
std::string attributesOf(std::string_view given) {
  const bool is_class = !given.empty() && given.find('=') == std::string_view::npos;
  return is_class ? fmt::format("class=\"{}\"", given) : std::string(given);
}

// Truncates to at most this many bytes, in whole UTF-8 characters.
std::string clippedText(const std::string& text, std::size_t most) {
  if (text.size() <= most) return text;
  std::size_t end = most;
  while (end > 0 && (static_cast<unsigned char>(text[end]) & 0xC0U) == 0x80U) --end;
  return text.substr(0, end) + "…";
}

// A word of at most `most` bytes; of a longer one, such as a path, both ends. UTF-8 characters stay whole.
std::string shortened(const std::string& word, std::size_t most) {
  const std::string gap = "...";
  if (word.size() <= most) return word;
  const auto isWithin = [&word](std::size_t i) {
    return (static_cast<unsigned char>(word[i]) & 0xC0U) == 0x80U;
  };
  std::size_t head = (most - gap.size()) / 2;
  std::size_t tail = word.size() - (most - gap.size() - head);
  while (head > 0 && isWithin(head)) --head;
  while (tail < word.size() && isWithin(tail)) ++tail;
  return word.substr(0, head) + gap + word.substr(tail);
}

}  // namespace

Figure withPrefix(Figure figure, const std::string& prefix) {
  figure.id = prefix + figure.id;
  // Text cannot contain these strings, because its quotation marks are escaped.
  for (const std::string_view before : {" id=\"", "\"url(#", "href=\"#"}) {
    for (std::size_t at = figure.svg.find(before); at != std::string::npos;
         at = figure.svg.find(before, at + before.size()))
      figure.svg.insert(at + before.size(), prefix);
  }
  return figure;
}

std::string escapedMarkup(std::string_view text) {
  constexpr std::string_view kMarkup = "<>&\"'";
  constexpr std::array<const char*, 5> kWritten = {"&lt;", "&gt;", "&amp;", "&quot;", "&#39;"};
  std::string escaped;
  for (const char c : text) {
    if (const std::size_t at = kMarkup.find(c); at != std::string_view::npos) {
      escaped += kWritten[at];
    } else if (static_cast<unsigned char>(c) < 0x20 || c == 0x7F) {
      // Control characters are not allowed in XML.
      escaped += fmt::format("\\x{:02x}", static_cast<unsigned char>(c));
    } else {
      escaped += c;
    }
  }
  return escaped;
}

std::string coordinate(double value) {
  std::string text = fmt::format("{:.2f}", value);
  text.erase(text.find_last_not_of('0') + 1);
  if (text.back() == '.') text.pop_back();
  return text == "-0" ? "0" : text;
}

std::string pointText(const Vector2d& point) {
  return coordinate(point.x()) + "," + coordinate(point.y()) + " ";
}

std::string pathThrough(const std::vector<Vector2d>& points, bool is_closed) {
  std::string d;
  for (const Vector2d& point : points) d += (d.empty() ? "M" : "L") + pointText(point);
  return is_closed && !d.empty() ? d + "Z" : d;
}

std::vector<Vector2d> cornersOf(const Eigen::AlignedBox2d& box) {
  return {box.min(), {box.max().x(), box.min().y()}, box.max(), {box.min().x(), box.max().y()}};
}

std::string rampColour(double share) {
  constexpr std::array<std::array<double, 3>, 3> kRamp = {{{232, 244, 250}, {254, 232, 168}, {240, 128, 92}}};
  const double at = 2 * std::clamp(share, 0.0, 1.0);
  const std::size_t low = at < 1 ? 0 : 1;
  const double t = at - static_cast<double>(low);
  std::array<int, 3> rgb{};
  for (std::size_t c = 0; c < 3; ++c)
    rgb[c] = static_cast<int>(std::lround((1 - t) * kRamp[low][c] + t * kRamp[low + 1][c]));
  return fmt::format("#{:02x}{:02x}{:02x}", rgb[0], rgb[1], rgb[2]);
}

std::string standaloneSvg(const std::string& svg) {
  const std::size_t end_of_tag = svg.find('>') + 1;
  // Comments in the style sheet may mention elements.
  return "<svg xmlns=\"http://www.w3.org/2000/svg\"" + svg.substr(4, end_of_tag - 4) +
         fmt::format("\n<style><![CDATA[\n{}{}svg {{ background: var(--ground); }}\n]]></style>\n",
                     paletteCss(), figureCss()) +
         svg.substr(end_of_tag);
}

double roundBelow(double value) {
  const double power = std::pow(10.0, std::floor(std::log10(value)));
  for (const double step : {5.0, 2.0}) {
    if (step * power <= value * (1 + 1e-12)) return step * power;
  }
  return power;
}

std::vector<double> roundTicks(double low, double high, int most) {
  if (!(high > low) || most < 1) return {};
  double step = roundBelow((high - low) / most);
  while ((high - low) / step > most) step = roundBelow(2.5 * step);
  std::vector<double> ticks;
  for (double k = std::ceil(low / step - 1e-9); k * step <= high + 1e-9 * step; ++k)
    ticks.push_back(k * step + 0.0);  // no "-0"
  return ticks;
}

std::string arrowPath(const Vector2d& from, const Vector2d& along) {
  constexpr double kLeastSeen = 0.2;
  const double length = along.norm();
  if (!(length > kLeastSeen)) return "";
  const Vector2d to = from + along;
  std::string d = pathThrough({from, to});
  if (length < 3) return d;
  const Vector2d back = std::min(4.0, 0.4 * length) / length * along;
  const Vector2d side(-0.5 * back.y(), 0.5 * back.x());
  return d + pathThrough({to - back + side, to, to - back - side});
}

std::string starPath(const Vector2d& middle, double radius) {
  std::vector<Vector2d> points;
  for (int i = 0; i < 10; ++i) {
    const double angle = std::numbers::pi * (0.2 * i - 0.5);
    points.push_back(middle +
                     (i % 2 == 0 ? radius : 0.45 * radius) * Vector2d(std::cos(angle), std::sin(angle)));
  }
  return pathThrough(points, true);
}

Legend warmthLegend(double most_px) {
  return {{"warmth weak", fmt::format("RMS {} px", shortNumber(most_px / 3))},
          {"warmth middling", fmt::format("{} px", shortNumber(2 * most_px / 3))},
          {"warmth", fmt::format("{} px", shortNumber(most_px))}};
}

std::string timesLonger(double times) {
  return (times >= 1 ? fmt::format("{:.0f}", times) : fmt::format("{:g}", times)) + " times longer";
}

std::string shortNumber(double value) {
  if (std::isnan(value)) return "unknown";
  if (std::isinf(value)) return value > 0 ? "infinite" : "-infinite";
  if (value == 0) return "0";
  const int digits = static_cast<int>(std::floor(std::log10(std::abs(value)))) + 1;
  return fmt::format("{:.{}f}", value, std::clamp(3 - digits, 0, 6));
}

std::string twoDigits(double value) {
  if (!std::isfinite(value)) return "unknown";
  if (value == 0) return "0";
  const int decimals = 1 - static_cast<int>(std::floor(std::log10(std::abs(value))));
  return fmt::format("{:.{}f}", value, std::clamp(decimals, 0, 4));
}

Vector2d PlotArea::at(double x, double y) const {
  const Vector2d share((x - low.x()) / (high.x() - low.x()), (y - low.y()) / (high.y() - low.y()));
  const double down = is_upward ? 1 - share.y() : share.y();
  return {box.min().x() + share.x() * box.sizes().x(), box.min().y() + down * box.sizes().y()};
}

PlotArea imageArea(const ImageSize& size, double width) {
  constexpr double kLeft = 36;
  constexpr double kRight = 10;
  constexpr double kTop = 8;
  const double most_width = width - kLeft - kRight;
  const double scale = std::min(most_width / size.width, 0.75 * width / size.height);
  const Vector2d sides(scale * size.width, scale * size.height);
  const double left = kLeft + 0.5 * (most_width - sides.x());
  return {.box = {Vector2d(left, kTop), Vector2d(left + sides.x(), kTop + sides.y())},
          .low = {-0.5, -0.5},
          .high = {size.width - 0.5, size.height - 0.5},
          .is_upward = false};
}

FigureCanvas::FigureCanvas(const ImageSize& size, std::string_view ground)
    : FigureCanvas(imageArea(size, kWidth)) {
  addArea(ground);
}

FigureCanvas::FigureCanvas(const Vector2d& low, const Vector2d& high)
    : FigureCanvas({.box = {Vector2d(44, 24), Vector2d(430, 250)}, .low = low, .high = high}, 38) {}

std::vector<Vector2d> FigureCanvas::at(const std::vector<Vector2d>& values) const {
  return mapped(values, [&](const Vector2d& value) { return area_.at(value); });
}

void FigureCanvas::open(std::string_view attributes) {
  svg_ += fmt::format("<g {}>", attributesOf(attributes));
}

void FigureCanvas::close() {
  svg_ += "</g>\n";
}

void FigureCanvas::addPath(const std::string& d, std::string_view attributes) {
  if (!d.empty()) svg_ += fmt::format("<path {} d=\"{}\"/>\n", attributesOf(attributes), d);
}

void FigureCanvas::addLine(const Vector2d& from, const Vector2d& to, std::string_view attributes) {
  addPath("M" + pointText(from) + "L" + pointText(to), attributes);
}

void FigureCanvas::addRect(const Vector2d& low, const Vector2d& high, std::string_view attributes) {
  svg_ += fmt::format("<rect x=\"{}\" y=\"{}\" width=\"{}\" height=\"{}\" {}/>\n", coordinate(low.x()),
                      coordinate(low.y()), coordinate(high.x() - low.x()), coordinate(high.y() - low.y()),
                      attributesOf(attributes));
}

void FigureCanvas::addCircle(const Vector2d& at, double radius, std::string_view attributes) {
  svg_ += fmt::format("<circle cx=\"{}\" cy=\"{}\" r=\"{}\" {}/>\n", coordinate(at.x()), coordinate(at.y()),
                      coordinate(radius), attributesOf(attributes));
}

void FigureCanvas::addText(const Vector2d& at, std::string_view text, std::string_view anchor,
                           std::string_view attributes) {
  svg_ += fmt::format("<text x=\"{}\" y=\"{}\" text-anchor=\"{}\"{}{}>{}</text>\n", coordinate(at.x()),
                      coordinate(at.y()), anchor, attributes.empty() ? "" : " ", attributesOf(attributes),
                      escapedMarkup(text));
}

void FigureCanvas::addAxes(std::string_view x_name, std::string_view y_name) {
  const Vector2d low = area_.box.min();
  const Vector2d high = area_.box.max();
  const std::vector<double> xs =
      roundTicks(area_.low.x(), area_.high.x(), std::max(2, static_cast<int>((high.x() - low.x()) / 50)));
  for (const double x : xs) {
    const double at = area_.at(x, area_.low.y()).x();
    addLine({at, low.y()}, {at, high.y()}, "grid");
    addText({at, high.y() + 14}, tickText(x, xs.size() > 1 ? xs[1] - xs[0] : 1), "middle", "tick");
  }
  addText({area_.box.center().x(), high.y() + 29}, x_name, "middle", "axis");
  addValues(y_name);
}

void FigureCanvas::addNamedAxes(const std::vector<std::string>& names, std::string_view x_name,
                                std::string_view y_name) {
  addNames(names, x_name);
  addValues(y_name);
}

void FigureCanvas::addNames(const std::vector<std::string>& names, std::string_view x_name) {
  constexpr std::size_t kMostLetters = 12;
  std::size_t longest = 1;
  for (const std::string& name : names) longest = std::max(longest, std::min(name.size(), kMostLetters));
  const double room = area_.box.sizes().x() / static_cast<double>(std::max<std::size_t>(1, names.size()));
  const double width = kLetterWidth * static_cast<double>(longest) + 6;
  const auto step = static_cast<std::size_t>(std::max(1.0, std::ceil(width / room)));
  for (std::size_t i = 0; i < names.size(); i += step) {
    const Vector2d at(area_.at(static_cast<double>(i) + 1, area_.low.y()).x(), area_.box.max().y());
    const double half = 0.5 * kLetterWidth * static_cast<double>(std::min(names[i].size(), kMostLetters));
    if (at.x() + half > width_) break;
    addLine(at, at + Vector2d(0, 3), "mark");
    addText(at + Vector2d(0, 14), clippedText(names[i], kMostLetters), "middle", "tick");
  }
  addText({area_.box.center().x(), area_.box.max().y() + 29}, x_name, "middle", "axis");
}

void FigureCanvas::addValues(std::string_view y_name) {
  const Vector2d low = area_.box.min();
  const Vector2d high = area_.box.max();
  const std::vector<double> ys =
      roundTicks(area_.low.y(), area_.high.y(), std::max(2, static_cast<int>((high.y() - low.y()) / 32)));
  for (const double y : ys) {
    const double at = area_.at(area_.low.x(), y).y();
    addLine({low.x(), at}, {high.x(), at}, "grid");
    addText({low.x() - 5, at + 4}, tickText(y, ys.size() > 1 ? ys[1] - ys[0] : 1), "end", "tick");
  }
  addRect(low, high, "frame");
  addText({low.x(), low.y() - 6}, y_name, "start", "axis");
}

void FigureCanvas::addImageFrame() {
  const Vector2d low = area_.box.min();
  const Vector2d high = area_.box.max();
  // A mark at 0 is at the centre of the first pixel.
  for (const double x : roundTicks(0, area_.high.x(), std::max(2, static_cast<int>((high - low).x() / 55)))) {
    const double at = area_.at(x, 0).x();
    addLine({at, high.y()}, {at, high.y() + 3}, "mark");
    addText({at, high.y() + 14}, fmt::format("{:.0f}", x), "middle", "tick");
  }
  for (const double y : roundTicks(0, area_.high.y(), std::max(2, static_cast<int>((high - low).y() / 45)))) {
    const double at = area_.at(0, y).y();
    addLine({low.x() - 3, at}, {low.x(), at}, "mark");
    addText({low.x() - 5, at + 4}, fmt::format("{:.0f}", y), "end", "tick");
  }
  addText({low.x() - 8, high.y() + 14}, "px", "end", "axis");
  addRect(low, high, "frame");
}

void FigureCanvas::addMeanArrows(const std::string& d) {
  addPath(d, "mean halo-line");
  addPath(d, "mean");
}

void FigureCanvas::addClip(std::string_view id) {
  addRaw(fmt::format("<clipPath id=\"{}\">", id));
  addArea("");
  addRaw("</clipPath>\n");
}

void FigureCanvas::addRing(const Vector2d& at, double radius) {
  addCircle(at, radius, "worst worst-halo");
  addCircle(at, radius, "worst");
}

void FigureCanvas::addLegend(const Vector2d& at, const Legend& legend) {
  constexpr double kSwatch = 12;
  Vector2d place = at;
  for (const auto& [shape, words] : legend) {
    // An arrow in a legend has its true length in the drawing.
    const std::size_t end_of_length = shape.starts_with("arrow ") ? shape.find(' ', 6) : 0;
    const double swatch = end_of_length > 0 ? std::stod(shape.substr(6)) : kSwatch;
    const double length = swatch + 5 + kLetterWidth * static_cast<double>(words.size()) + 12;
    if (place.x() > at.x() && place.x() + length > width_) place = {at.x(), place.y() + kLegendRow};
    const Vector2d middle = place + Vector2d(0.5 * kSwatch, 0.5 * kSwatch);
    if (end_of_length > 0) {
      addPath(arrowPath({place.x(), middle.y()}, {swatch, 0}), shape.substr(end_of_length + 1));
    } else if (shape.starts_with("line")) {
      addLine(middle - Vector2d(0.5 * kSwatch, 0), middle + Vector2d(0.5 * kSwatch, 0), shape.substr(5));
    } else if (shape.starts_with("star")) {
      addPath(starPath(middle, 7), shape.substr(5));
    } else if (shape.starts_with("dot")) {
      addCircle(middle, 3, shape.substr(4));
    } else {
      addRect(place, place + Vector2d(kSwatch, kSwatch), shape);
    }
    addText(place + Vector2d(swatch + 5, kSwatch - 2), words, "start");
    place.x() += length;
  }
  height_ = std::max(height_, place.y() + kLegendRow);
}

void FigureCanvas::addRamp(std::string_view least, std::string_view most) {
  constexpr int kSteps = 24;
  constexpr double kStep = 8;
  const double left = 72;
  const double base = height_ + 10;
  for (int i = 0; i < kSteps; ++i) {
    const Vector2d low(left + i * kStep, height_);
    addRect(low, low + Vector2d(1.05 * kStep, 12),
            fmt::format("fill=\"{}\"", rampColour(i / (kSteps - 1.0))));
  }
  addText({left - 5, base}, least, "end");
  addText({left + kSteps * kStep + 6, base}, most, "start");
  height_ += kLegendRow;
}

void FigureCanvas::addCaption(std::string_view text) {
  constexpr double kEdge = 8;
  const auto most = static_cast<std::size_t>((width_ - 2 * kEdge) / kLetterWidth);
  std::string line;
  const auto flush = [&] {
    if (line.empty()) return;
    height_ += kLegendRow;
    addText({kEdge, height_ - 6}, line, "start");
    line.clear();
  };
  for (const std::string_view row : split(text, '\n')) {
    for (const std::string_view whole : split(row, ' ')) {
      if (whole.empty()) continue;
      const std::string word = shortened(std::string(whole), most);
      if (line.size() + word.size() > most) flush();
      line += (line.empty() ? "" : " ") + word;
    }
    flush();
  }
}

std::string FigureCanvas::addErrorCells(int columns, int rows, const std::vector<ErrorCell>& cells) {
  const double most = std::ranges::max_element(cells, {}, &ErrorCell::rms_px)->rms_px;
  const Vector2d sides = area_.box.sizes().cwiseQuotient(Vector2d(columns, rows));
  std::string arrows;
  for (std::size_t i = 0; i < cells.size(); ++i) {
    const ErrorCell& cell = cells[i];
    if (cell.count == 0) continue;
    const int index = static_cast<int>(i);
    const Vector2d low = area_.box.min() + sides.cwiseProduct(Vector2d(index % columns, index / columns));
    addRect(low, low + sides,
            fmt::format("class=\"warmth\" fill-opacity=\"{:.2f}\" data-count=\"{}\" data-rms=\"{:.9g}\"",
                        0.1 + 0.5 * (most > 0 ? cell.rms_px / most : 0), cell.count, cell.rms_px));
    arrows += arrowPath(low + 0.5 * sides, cell.arrow);
  }
  return arrows;
}

std::string FigureCanvas::svg(std::string_view alt, std::string_view attributes) const {
  return fmt::format(
      "<svg class=\"drawing\" viewBox=\"0 0 {} {}\" role=\"img\" aria-label=\"{}\"{}{}>\n{}</svg>\n",
      coordinate(width_), coordinate(height_), escapedMarkup(alt), attributes.empty() ? "" : " ", attributes,
      svg_);
}

Figure FigureCanvas::drawn(Figure words, const Legend& legend, std::string_view attributes) {
  if (!legend.empty()) addLegend(legend);
  words.svg = svg(words.alt, attributes);
  return words;
}

}  // namespace alidade
