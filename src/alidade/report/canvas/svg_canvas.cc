// SPDX-License-Identifier: MIT
#include "alidade/report/canvas/svg_canvas.h"

#include <algorithm>

#include <fmt/format.h>

#include "alidade/core/text.h"

namespace alidade {
namespace {

constexpr double kTextUnits = 70;  // the least width for text, for images that are high and narrow
constexpr double kLetterUnits = 1.14;

std::string escapedXml(std::string_view text) {
  std::string escaped;
  for (const char c : text) {
    escaped += c == '<'   ? "&lt;"
               : c == '>' ? "&gt;"
               : c == '&' ? "&amp;"
               : c == '"' ? "&quot;"
                          : std::string(1, c);
  }
  return escaped;
}

// A word of at most `most` bytes: of a longer one, such as a path, its ends. UTF-8 characters stay whole.
std::string shortened(const std::string& word, std::size_t most) {
  const std::string gap = "...";
  if (word.size() <= most || most <= gap.size()) return word;
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

SvgCanvas::SvgCanvas(ImageSize size, double margin)
    : size_(size),
      unit_(std::max(size.width, size.height) / 100.0),
      margin_(margin * unit_),
      low_(size.height + margin_) {}

void SvgCanvas::addFrame() {
  svg_ += fmt::format(
      "<rect x=\"-0.5\" y=\"-0.5\" width=\"{}\" height=\"{}\" fill=\"none\" stroke=\"#333\" "
      "stroke-width=\"{:.2f}\"/>\n",
      size_.width, size_.height, 0.25 * unit_);
}

void SvgCanvas::addRect(const Eigen::Vector2d& low, const Eigen::Vector2d& high, const std::string& fill) {
  svg_ += fmt::format("<rect x=\"{:.1f}\" y=\"{:.1f}\" width=\"{:.1f}\" height=\"{:.1f}\" fill=\"{}\"/>\n",
                      low.x(), low.y(), high.x() - low.x(), high.y() - low.y(), fill);
}

void SvgCanvas::addDots(const std::vector<Eigen::Vector2d>& pixels, const char* colour, double radius) {
  svg_ += fmt::format("<g fill=\"{}\">\n", colour);
  for (const Eigen::Vector2d& pixel : pixels)
    svg_ += fmt::format("<circle cx=\"{:.1f}\" cy=\"{:.1f}\" r=\"{:.2f}\"/>\n", pixel.x(), pixel.y(),
                        radius * unit_);
  svg_ += "</g>\n";
}

void SvgCanvas::addRing(const Eigen::Vector2d& at, const char* colour, double radius) {
  svg_ += fmt::format(
      "<circle cx=\"{:.1f}\" cy=\"{:.1f}\" r=\"{:.2f}\" fill=\"none\" stroke=\"{}\" "
      "stroke-width=\"{:.2f}\"/>\n",
      at.x(), at.y(), radius * unit_, colour, 0.35 * unit_);
}

void SvgCanvas::addLine(const std::vector<Eigen::Vector2d>& pixels, const char* colour, double width) {
  if (pixels.size() < 2) return;
  svg_ += fmt::format("<polyline fill=\"none\" stroke=\"{}\" stroke-width=\"{:.2f}\" points=\"", colour,
                      width * unit_);
  for (const Eigen::Vector2d& pixel : pixels) svg_ += fmt::format("{:.1f},{:.1f} ", pixel.x(), pixel.y());
  svg_ += "\"/>\n";
}

void SvgCanvas::addLabel(const Eigen::Vector2d& at, const char* colour, const std::string& text,
                         const char* anchor) {
  svg_ += fmt::format(
      "<text x=\"{:.1f}\" y=\"{:.1f}\" fill=\"{}\" text-anchor=\"{}\" paint-order=\"stroke\" "
      "stroke=\"white\" stroke-width=\"{:.2f}\">{}</text>\n",
      at.x(), at.y(), colour, anchor, 0.5 * unit_, escapedXml(text));
}

void SvgCanvas::addCaption(const std::string& text) {
  const auto most = static_cast<std::size_t>((fullWidth() - 2 * margin_) / (kLetterUnits * unit_));
  std::string line;
  const auto flush = [&] {
    if (line.empty()) return;
    low_ += 2.6 * unit_;
    addLabel({0, low_}, "#111", line, "start");
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

double SvgCanvas::takeRow(double height) {
  const double top = low_;
  low_ += height * unit_;
  return top;
}

double SvgCanvas::addRamp(double top, const std::string& least, const std::string& most) {
  constexpr int kSteps = 24;
  const double step = 1.25 * unit_;
  const Eigen::Vector2d size(1.05 * step, 2 * unit_);
  for (int i = 0; i < kSteps; ++i) {
    const Eigen::Vector2d low(8 * unit_ + i * step, top);
    addRect(low, low + size, rampColour(i / (kSteps - 1.0)));
  }
  const double end = 8 * unit_ + kSteps * step;
  const double base = top + 1.7 * unit_;
  addLabel({7 * unit_, base}, "#111", least, "end");
  addLabel({end + unit_, base}, "#111", most, "start");
  return end;
}

Eigen::Vector2d SvgCanvas::inside(const Eigen::Vector2d& at) const {
  const double edge = margin_ - 4 * unit_;
  return {std::clamp(at.x(), -edge, size_.width + edge), std::clamp(at.y(), -edge, size_.height + edge)};
}

double SvgCanvas::fullWidth() const {
  return std::max<double>(size_.width, kTextUnits * unit_) + 2 * margin_;
}

std::string SvgCanvas::text() const {
  return fmt::format(
             "<svg xmlns=\"http://www.w3.org/2000/svg\" width=\"900\" viewBox=\"{0:.1f} {0:.1f} {1:.1f} "
             "{2:.1f}\" font-family=\"sans-serif\" font-size=\"{3:.2f}\">\n<rect x=\"{0:.1f}\" y=\"{0:.1f}\" "
             "width=\"{1:.1f}\" height=\"{2:.1f}\" fill=\"white\"/>\n",
             -margin_, fullWidth(), low_ + margin_ + 2 * unit_, 2.2 * unit_) +
         svg_ + "</svg>\n";
}

}  // namespace alidade
