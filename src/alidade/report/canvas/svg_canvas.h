// SPDX-License-Identifier: MIT
#pragma once

#include <string>
#include <vector>

#include <Eigen/Core>

#include "alidade/core/image.h"

namespace alidade {

/// Colours from little (0) to much (1), pale enough for lines on top.
[[nodiscard]] std::string rampColour(double share);

/// A drawing over an image, in its pixels, with lines of text under it. Texts are UTF-8 without control
/// characters.
class SvgCanvas {
 public:
  /// @param margin  around the image, in units
  SvgCanvas(ImageSize size, double margin);

  /// A hundredth of the image's longer side: lines and letters look alike for images of any size.
  [[nodiscard]] double unit() const { return unit_; }
  [[nodiscard]] const ImageSize& size() const { return size_; }

  void addFrame();
  /// `fill` is a colour or a pattern.
  void addRect(const Eigen::Vector2d& low, const Eigen::Vector2d& high, const std::string& fill);
  /// @param radius  in units, as all widths
  void addDots(const std::vector<Eigen::Vector2d>& pixels, const char* colour, double radius);
  void addRing(const Eigen::Vector2d& at, const char* colour, double radius);
  void addLine(const std::vector<Eigen::Vector2d>& pixels, const char* colour, double width);
  void addLabel(const Eigen::Vector2d& at, const char* colour, const std::string& text,
                const char* anchor = "middle");
  /// SVG as it stands: definitions, groups.
  void addText(const std::string& svg) { svg_ += svg; }

  /// Lines of text under what is drawn so far, broken where they get too long.
  void addCaption(const std::string& text);
  /// Makes room under what is drawn so far, of this many units, and returns its upper edge.
  double takeRow(double height);
  /// A bar of the ramp's colours at the upper edge `top`, from 8 units on, between what it begins and ends
  /// at. @returns its right end
  double addRamp(double top, const std::string& least, const std::string& most);

  /// The nearest place at which a word can be read as a whole.
  [[nodiscard]] Eigen::Vector2d inside(const Eigen::Vector2d& at) const;
  /// All of it, a whole file.
  [[nodiscard]] std::string text() const;

 private:
  [[nodiscard]] double fullWidth() const;

  ImageSize size_;
  double unit_;
  double margin_;
  double low_;  // where the caption goes on
  std::string svg_;
};

}  // namespace alidade
