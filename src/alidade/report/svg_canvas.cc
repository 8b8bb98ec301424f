// SPDX-License-Identifier: MIT
#include "alidade/report/svg_canvas.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>

#include <fmt/format.h>

namespace alidade {
namespace {

constexpr double kTextUnits = 70;  // the least width for text, for images that are high and narrow
constexpr double kLetterUnits = 1.14;

// How many bytes the UTF-8 character at the start of `text` has; 0 where there is none.
std::size_t characterBytes(std::string_view text) {
  const auto byte = [&](std::size_t i) { return static_cast<unsigned char>(text[i]); };
  const std::size_t count = byte(0) < 0x80                       ? 1
                            : byte(0) >= 0xC2 && byte(0) <= 0xDF ? 2
                            : (byte(0) & 0xF0) == 0xE0           ? 3
                            : byte(0) >= 0xF0 && byte(0) <= 0xF4 ? 4
                                                                 : 0;
  if (count == 0 || text.size() < count) return 0;
  std::uint32_t code = count == 1 ? byte(0) : byte(0) & (0x7FU >> count);
  for (std::size_t i = 1; i < count; ++i) {
    if ((byte(i) & 0xC0) != 0x80) return 0;
    code = (code << 6) | (byte(i) & 0x3FU);
  }
  const bool is_overlong = (count == 3 && code < 0x800) || (count == 4 && code < 0x10000);
  const bool is_surrogate = code >= 0xD800 && code <= 0xDFFF;
  const bool is_control = code < 0x20 || code == 0xFFFE || code == 0xFFFF;  // not allowed in XML
  return is_overlong || is_surrogate || is_control || code > 0x10FFFF ? 0 : count;
}

}  // namespace

std::string escapedXml(std::string_view text) {
  std::string escaped;
  while (!text.empty()) {
    const std::size_t count = characterBytes(text);
    if (count == 0) {
      escaped += "\xEF\xBF\xBD";
    } else if (text[0] == '<') {
      escaped += "&lt;";
    } else if (text[0] == '>') {
      escaped += "&gt;";
    } else if (text[0] == '&') {
      escaped += "&amp;";
    } else if (text[0] == '"') {
      escaped += "&quot;";
    } else {
      escaped += text.substr(0, count);
    }
    text.remove_prefix(std::max<std::size_t>(count, 1));
  }
  return escaped;
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

namespace {

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

void SvgCanvas::addCaption(const std::string& text) {
  const auto most = static_cast<std::size_t>((fullWidth() - 2 * margin_) / (kLetterUnits * unit_));
  std::string line;
  const auto flush = [&] {
    if (line.empty()) return;
    low_ += 2.6 * unit_;
    addLabel({0, low_}, "#111", line, "start");
    line.clear();
  };
  std::string word;
  const auto take = [&] {
    if (word.empty()) return;
    word = shortened(word, most);
    if (line.size() + word.size() > most) flush();
    line += (line.empty() ? "" : " ") + word;
    word.clear();
  };
  for (const char c : text) {
    if (c != ' ' && c != '\n') {
      word += c;
      continue;
    }
    take();
    if (c == '\n') flush();
  }
  take();
  flush();
}

double SvgCanvas::takeRow(double height) {
  const double top = low_;
  low_ += height * unit_;
  return top;
}

double SvgCanvas::addRamp(double top) {
  constexpr int kSteps = 24;
  const double step = 1.25 * unit_;
  const Eigen::Vector2d size(1.05 * step, 2 * unit_);
  for (int i = 0; i < kSteps; ++i) {
    const Eigen::Vector2d low(8 * unit_ + i * step, top);
    addRect(low, low + size, rampColour(i / (kSteps - 1.0)));
  }
  return 8 * unit_ + kSteps * step;
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
             "{2:.1f}\" font-family=\"sans-serif\" font-size=\"{3:.2f}\">\n<rect x=\"{0:.1f}\" "
             "y=\"{0:.1f}\" width=\"{1:.1f}\" height=\"{2:.1f}\" fill=\"white\"/>\n",
             -margin_, fullWidth(), low_ + margin_ + 2 * unit_, 2.2 * unit_) +
         svg_ + "</svg>\n";
}

}  // namespace alidade
