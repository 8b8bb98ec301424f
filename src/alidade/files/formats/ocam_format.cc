// SPDX-License-Identifier: MIT
// Scaramuzza's OCamCalib: calib_results.txt, in which five lines hold the direct polynomial (its number of
// coefficients first), the inverse one, the centre (row, column; from 0), c d e, and height and width. Its
// rays have the axes down, right, backward. world2cam solves the direct polynomial; the inverse one, for its
// fast version in C, approximates that (Scaramuzza, Martinelli and Siegwart 2006, A toolbox for easily
// calibrating omnidirectional cameras, IROS; and the toolbox's own documentation). py-OCamCalib writes the
// same as JSON, with the axes right, down, forward, the centre as (x, y), and no image size
// (src/pyocamcalib/modelling/camera.py).
#include <algorithm>
#include <cmath>
#include <limits>
#include <string>
#include <utility>

#include <fmt/format.h>
#include <Eigen/Dense>

#include "alidade/core/mapped.h"
#include "alidade/core/number_text.h"
#include "alidade/core/text.h"
#include "alidade/files/formats/camera_document.h"
#include "alidade/files/formats/camera_format.h"
#include "alidade/files/formats/ocam_numbers.h"

namespace alidade::detail::formats {
namespace ocam_format {

struct Line {
  std::string place;
  std::vector<double> numbers;
};

// The first lines of numbers, at most five; empty if another line comes before the fifth.
std::vector<Line> linesOf(const CameraDocument& document) {
  std::vector<Line> lines;
  std::size_t count = 0;
  for (const std::string_view text : split(document.text(), '\n')) {
    ++count;
    if (trim(text).empty() || trim(text).front() == '#') continue;
    Line line = {.place = document.file() + ":" + std::to_string(count), .numbers = {}};
    for (const std::string& word : words(text)) {
      const auto number = parseDouble(word);
      if (!number || !std::isfinite(*number)) return {};
      line.numbers.push_back(*number);
    }
    lines.push_back(std::move(line));
    if (lines.size() == 5) return lines;
  }
  return {};
}

bool isCounted(const Line& line) {
  return line.numbers.size() > 2 && line.numbers.front() == static_cast<double>(line.numbers.size() - 1);
}

bool areResults(const std::vector<Line>& lines) {
  return lines.size() == 5 && isCounted(lines[0]) && isCounted(lines[1]) && lines[2].numbers.size() == 2 &&
         lines[3].numbers.size() == 3 && lines[4].numbers.size() == 2;
}

bool recognises(const CameraDocument& document) {
  return document.has("taylor_coefficient") || (!document.isMap() && areResults(linesOf(document)));
}

std::vector<StatedNumber> stated(std::span<const double> numbers) {
  return mapped(numbers, [](double value) { return StatedNumber{value}; });
}

CameraSource readJson(const YamlNode& root, const ReadOptions& options) {
  OcamNumbers numbers = {
      .polynomial = statedNumbers(root.at("taylor_coefficient")), .affine = {}, .centre = {}};
  const std::vector<StatedNumber> A = statedNumbers(root.at("stretch_matrix"), 4);
  if (A[3].value != 1)
    throw root.at("stretch_matrix").error("another last element than 1", "[[c, d], [e, 1]]");
  numbers.affine = {A[0], A[1], A[2]};
  const std::vector<StatedNumber> centre = statedNumbers(root.at("distortion_center"), 2);
  numbers.centre = {centre[0], centre[1]};
  StatedCamera camera = stateOcam(root.at("taylor_coefficient").where(), numbers, options.image_size);
  if (const auto name = root.find("camera_name")) camera.name = name->text();
  remarkUnknownKeys(
      root,
      words("date camera_name valid taylor_coefficient distortion_center stretch_matrix inverse_poly "
            "extrinsics_t img_path rms_overall rms_mean_list rms_std_list"),
      camera);
  return {.cameras = {camera}};
}

// The ray's angle from the sensor's plane, which the inverse polynomial takes.
double elevation(const std::vector<double>& direct, double radius) {
  double z = 0;
  for (std::size_t i = direct.size(); i-- > 0;) z = z * radius + direct[i];
  return std::atan2(z, radius);
}

double valueOf(const Eigen::VectorXd& polynomial, double x) {
  double sum = 0;
  for (Eigen::Index i = polynomial.size(); i-- > 0;) sum = sum * x + polynomial[i];
  return sum;
}

// The radius up to which the direct polynomial has an inverse, at most `limit`: the ray's angle rises (or
// falls) with the radius. Close to where it turns no polynomial follows.
double invertibleRadius(const std::vector<double>& direct, double limit) {
  constexpr int kNumRadii = 400;
  constexpr double kNearTurn = 0.75;
  const double sign = direct.front() < 0 ? 1 : -1;
  double before = sign * elevation(direct, 0);
  for (int i = 1; i <= kNumRadii; ++i) {
    const double here = sign * elevation(direct, limit * i / kNumRadii);
    if (!(here > before)) return kNearTurn * limit * (i - 1) / kNumRadii;
    before = here;
  }
  return limit;
}

// How far the inverse polynomial misses the direct one, px.
double missOf(const std::vector<double>& direct, const Eigen::VectorXd& inverse, double max_radius) {
  constexpr int kNumRadii = 200;
  double worst = 0;
  for (int i = 1; i <= kNumRadii; ++i) {
    const double radius = max_radius * i / kNumRadii;
    worst = std::max(worst, std::abs(valueOf(inverse, elevation(direct, radius)) - radius));
  }
  return worst;
}

double outerRadius(const std::vector<double>& direct, std::span<const double> centre, ImageSize size) {
  const double corner =
      std::hypot(std::max(centre[0], size.height - centre[0]), std::max(centre[1], size.width - centre[1]));
  return invertibleRadius(direct, corner);
}

CameraSource read(const CameraDocument& document, const ReadOptions& options) {
  if (document.isMap()) return readJson(document.root(), options);
  const std::vector<Line> lines = linesOf(document);
  if (!areResults(lines)) {
    throw errorAt(
        document.file(), "found no five lines of numbers",
        "two polynomials after their numbers of coefficients; row and column; c, d, e; height and width");
  }
  const std::vector<double> direct(lines[0].numbers.begin() + 1, lines[0].numbers.end());
  const std::span<const double> inverse = std::span(lines[1].numbers).subspan(1);
  const auto side = [&](double number) {
    constexpr double kMaxSide = 1e6;
    if (number >= 1 && number <= kMaxSide && number == std::floor(number)) return static_cast<int>(number);
    throw errorAt(lines[4].place, "found " + exactText(number), "a whole number of pixels, 1 to 1000000");
  };
  const ImageSize size = {.width = side(lines[4].numbers[1]), .height = side(lines[4].numbers[0])};
  OcamNumbers numbers = {.polynomial = stated(direct), .affine = {}, .centre = {}, .is_row_first = true};
  std::ranges::copy(stated(lines[3].numbers), numbers.affine.begin());
  std::ranges::copy(stated(lines[2].numbers), numbers.centre.begin());
  StatedCamera camera = stateOcam(lines[0].place, numbers, size);
  constexpr double kSamePx = 0.1;
  const double miss = missOf(
      direct, Eigen::Map<const Eigen::VectorXd>(inverse.data(), static_cast<Eigen::Index>(inverse.size())),
      outerRadius(direct, lines[2].numbers, size));
  if (!(miss < kSamePx)) {
    camera.remarks.push_back(
        {"assumed", lines[1].place + ": this inverse polynomial misses the direct one by up to " +
                        numberText("%.2g", miss) + " px in the image; the direct one was read"});
  }
  return {.cameras = {camera}};
}

// The smallest inverse polynomial that is exact to a hundredth of a pixel, as the toolbox computes it.
Eigen::VectorXd inverseOf(const std::vector<double>& direct, double max_radius) {
  constexpr int kNumSamples = 400;
  constexpr Eigen::Index kMaxDegree = 20;
  constexpr double kGoodPx = 0.01;
  Eigen::VectorXd best;
  double least_miss = std::numeric_limits<double>::infinity();
  for (Eigen::Index degree = 4; degree <= kMaxDegree; ++degree) {
    Eigen::MatrixXd A(kNumSamples, degree + 1);
    Eigen::VectorXd radii(kNumSamples);
    for (Eigen::Index i = 0; i < kNumSamples; ++i) {
      radii[i] = max_radius * static_cast<double>(i + 1) / kNumSamples;
      const double angle = elevation(direct, radii[i]);
      for (Eigen::Index k = 0; k <= degree; ++k) A(i, k) = std::pow(angle, static_cast<double>(k));
    }
    const Eigen::VectorXd inverse = A.colPivHouseholderQr().solve(radii);
    const double miss = missOf(direct, inverse, max_radius);
    if (miss < least_miss) best = inverse;
    least_miss = std::min(least_miss, miss);
    if (miss < kGoodPx) break;
  }
  return best;
}

std::string write(std::span<const NamedCamera> cameras, const std::string&) {
  const NamedCamera& named = cameras.front();
  const OcamNumbers numbers = ocamNumbers(named.camera, true, 0);
  std::vector<double> direct = mapped(numbers.polynomial, [](const StatedNumber& n) { return -n.value; });
  while (direct.size() > 5 && direct.back() == 0) direct.pop_back();
  const std::array<double, 2> centre = {numbers.centre[0].value, numbers.centre[1].value};
  const Eigen::VectorXd inverse = inverseOf(direct, outerRadius(direct, centre, named.image_size));
  const auto counted = [](std::span<const double> values) {
    return std::to_string(values.size()) + " " + join(mapped(values, exactText), " ") + "\n";
  };
  return "#polynomial coefficients for the DIRECT mapping function\n\n" + counted(direct) +
         "\n#polynomial coefficients for the inverse mapping function\n\n" +
         counted({inverse.data(), static_cast<std::size_t>(inverse.size())}) +
         fmt::format(
             "\n#center: \"row\" and \"column\", starting from 0\n\n{} {}\n\n#affine parameters \"c\", \"d\", \"e\""
             "\n\n{} {} {}\n\n#image size: \"height\" and \"width\"\n\n{} {}\n",
             exactText(centre[0]), exactText(centre[1]), exactText(numbers.affine[0].value),
             exactText(numbers.affine[1].value), exactText(numbers.affine[2].value), named.image_size.height,
             named.image_size.width);
}

}  // namespace ocam_format

const CameraFormat& ocam() {
  using namespace ocam_format;
  static const CameraFormat kFormat = {.id = "ocam",
                                       .title = "OCamCalib calib_results (text)",
                                       .aliases = "ocamcalib scaramuzza calib_results",
                                       .models = {"ocam"},
                                       .marks = {"taylor_coefficient", "stretch_matrix", "distortion_center"},
                                       .recognises = recognises,
                                       .read = read,
                                       .write = write};
  return kFormat;
}

}  // namespace alidade::detail::formats
