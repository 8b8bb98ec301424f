// SPDX-License-Identifier: MIT
#include "difference_output.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <numbers>
#include <string_view>
#include <utility>
#include <vector>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "alidade/core/size_groups.h"
#include "alidade/core/text.h"
#include "command.h"

namespace alidade {
namespace {

using nlohmann::json;

constexpr double kDegPerRad = 180 / std::numbers::pi;
constexpr double kRoundingPx = 1e-9;  // projecting one camera twice differs by less

// Up to `most` of `count` places, from the first to the last.
std::vector<int> spread(int count, int most) {
  std::vector<int> places;
  const int n = std::min(count, most);
  for (int i = 0; i < n; ++i)
    places.push_back(n == 1 ? 0
                            : static_cast<int>(std::lround(static_cast<double>(i) * (count - 1) / (n - 1))));
  return places;
}

std::string motionText(const ProjectionDifference& difference) {
  const Eigen::Vector3d w = difference.b_from_a.rotation.log();
  constexpr double kRoundingDeg = 1e-9;
  const double angle_deg = kDegPerRad * w.norm();
  std::string text = "by a rotation of 0 degrees";
  if (angle_deg >= kRoundingDeg) {
    text = fmt::format("by a rotation of {:.6g} degrees", angle_deg);
    const Eigen::Vector3d axis = w.normalized();
    text += fmt::format(" about ({:.4f}, {:.4f}, {:.4f}), from A's camera frame to B's", axis.x(), axis.y(),
                        axis.z());
  }
  const Eigen::Vector3d& t = difference.b_from_a.translation;
  if (t.norm() > 0)
    text += fmt::format("\n         and by a translation of ({:.6g}, {:.6g}, {:.6g}) m", t.x(), t.y(), t.z());
  return text;
}

}  // namespace

std::string differenceText(const ProjectionDifference& difference) {
  if (!difference.is_converged)
    return "Aligned  no: the best alignment was not found, so no difference can be stated\n";
  std::string text = "Aligned  " + motionText(difference) + "\n";
  if (difference.match.quarter_turns != 0) {
    text += fmt::format("         B's image is A's image rotated clockwise by {} degrees\n",
                        90 * difference.match.quarter_turns);
  }
  const auto num_pixels = difference.pixels.size();
  text += fmt::format("Compared {} of {} pixels", difference.num_compared, num_pixels);
  if (difference.num_seen_by_one > 0)
    text += fmt::format("; {} are seen by only one camera", difference.num_seen_by_one);
  if (difference.num_seen_by_neither > 0)
    text += fmt::format("; {} are seen by neither", difference.num_seen_by_neither);
  text += "\n";
  if (difference.num_compared == 0) return text;
  if (difference.max_px < kRoundingPx)
    return text + "Diff     none: the cameras are identical to within rounding\n";
  text += fmt::format(
      "Diff     mean {:.4g} px, RMS {:.4g} px, 95 % within {:.4g} px, at most {:.4g} px at pixel ({:.0f}, "
      "{:.0f}) of A; in pixels of the {} image\n",
      difference.mean_px, difference.rms_px, difference.p95_px, difference.max_px, difference.worst_pixel.x(),
      difference.worst_pixel.y(), sizeText(difference.match.unit_size));
  return text;
}

std::string unevenSizeText(ImageSize a, ImageSize b, int quarter_turns) {
  if (quarter_turns % 2 != 0) std::swap(b.width, b.height);
  if (std::int64_t{a.width} * b.height == std::int64_t{a.height} * b.width) return "";
  // The factor by which the finer image shrinks differs along x and y. As one factor, that of the mean, it
  // would be off at the border by this much.
  const bool is_a_finer = std::int64_t{a.width} * a.height >= std::int64_t{b.width} * b.height;
  const ImageSize fine = is_a_finer ? a : b;
  const ImageSize coarse = is_a_finer ? b : a;
  const double by_width = static_cast<double>(coarse.width) / fine.width;
  const double by_height = static_cast<double>(coarse.height) / fine.height;
  const double mean = std::sqrt(by_width * by_height);
  const double off_px = 0.5 * std::max(std::abs(by_width / mean - 1) * fine.width,
                                       std::abs(by_height / mean - 1) * fine.height);
  return fmt::format(
      "note: {} px is not {} px resized by one factor: it would be {:.5g} along x and {:.5g} along y. If the "
      "sides were only rounded after resizing or binning, this causes differences of up to {:.2g} px (of the "
      "{} image) at the border",
      sizeText(coarse), sizeText(fine), by_width, by_height, off_px, sizeText(fine));
}

std::string differenceTable(const ProjectionDifference& difference) {
  constexpr int kMostColumns = 9;
  constexpr int kMostRows = 7;
  const auto columns = spread(difference.columns, kMostColumns);
  const auto rows = spread(difference.rows, kMostRows);
  const auto at = [&](int row, int column) {
    return static_cast<std::size_t>(row * difference.columns + column);
  };
  std::string text = "Grid     differences in px; columns and rows are pixels of A\n            ";
  for (const int column : columns) text += fmt::format(" {:>8.0f}", difference.pixels[at(0, column)].x());
  text += "\n";
  for (const int row : rows) {
    text += fmt::format("    {:>8.0f}", difference.pixels[at(row, 0)].y());
    for (const int column : columns) {
      const double length = difference.lengthAt(at(row, column));
      if (length < kRoundingPx) {
        text += fmt::format(" {:>8}", 0);
        continue;
      }
      text += std::isfinite(length) ? fmt::format(" {:>8.3g}", length) : fmt::format(" {:>8}", "-");
    }
    text += "\n";
  }
  return text;
}

std::vector<std::string> figureLines(const std::string& text) {
  constexpr std::size_t kLabelColumns = 9;
  std::vector<std::string> lines;
  for (const std::string_view row : split(trim(text), '\n')) {
    if (row.starts_with(' ') && !lines.empty()) {
      lines.back() += "; " + std::string(trim(row));
      continue;
    }
    const std::string label(trim(row.substr(0, kLabelColumns)));
    lines.push_back(label + ": " + std::string(trim(row.substr(std::min(row.size(), kLabelColumns)))));
  }
  return lines;
}

std::string significanceText(const ProjectionDifference& difference,
                             const std::optional<DifferenceSignificance>& significance, bool has_a,
                             bool has_b) {
  if (!significance) {
    return "unknown: neither file states a covariance, so the difference cannot be compared with the "
           "uncertainty";
  }
  std::string text = fmt::format("the difference of {:.2g} px (RMS) is {}: {}",
                                 difference.rms_px < kRoundingPx ? 0.0 : difference.rms_px,
                                 significance->sigmas > 0 ? fmt::format("{:.1f} sigma", significance->sigmas)
                                                          : std::string("within chance"),
                                 significance->isSignificant() ? "significant" : "not significant");
  text += fmt::format(
      "; the covariances predict {0:.2g} px. At least {2:.3g} px of the {1:.3g} px (95 %) are real; {3:.0f} "
      "% of the pixels differ by more than their 95 % ellipse",
      significance->expected_rms_px, difference.p95_px, significance->sure_p95_px,
      100 * significance->share_beyond);
  if (!has_a || !has_b)
    text += fmt::format("; {} states no covariance and is assumed to be exact", has_a ? "B" : "A");
  return text;
}

json differenceJson(const ProjectionDifference& difference,
                    const std::optional<DifferenceSignificance>& significance) {
  const auto rowsOf = [&](const auto& valueAt) {
    json rows = json::array();
    for (int row = 0; row < difference.rows; ++row) {
      json values = json::array();
      for (int column = 0; column < difference.columns; ++column)
        values.push_back(valueAt(static_cast<std::size_t>(row * difference.columns + column)));
      rows.push_back(std::move(values));
    }
    return rows;
  };
  const auto vectorJson = [](const Eigen::Vector2d& v) {
    return v.allFinite() ? json({v.x(), v.y()}) : json(nullptr);
  };
  const Eigen::Quaterniond& q = difference.b_from_a.rotation.quaternion();
  const Eigen::Vector3d& t = difference.b_from_a.translation;
  const bool is_known = difference.is_converged;
  const auto known = [is_known](const auto& value) { return is_known ? json(value) : json(nullptr); };
  json document = {
      {"b_from_a", known(json({{"quaternion_xyzw", {q.x(), q.y(), q.z(), q.w()}},
                               {"translation_m", {t.x(), t.y(), t.z()}},
                               {"angle_deg", kDegPerRad * difference.b_from_a.rotation.log().norm()}}))},
      {"image_turn_deg", known(90 * difference.match.quarter_turns)},
      {"converged", difference.is_converged},
      {"pixels_of",
       {{"width", difference.match.unit_size.width}, {"height", difference.match.unit_size.height}}},
      {"num_compared", known(difference.num_compared)},
      {"num_seen_by_one", known(difference.num_seen_by_one)},
      {"num_seen_by_neither", known(difference.num_seen_by_neither)},
      {"mean_px", known(orNull(difference.mean_px))},
      {"rms_px", known(orNull(difference.rms_px))},
      {"p95_px", known(orNull(difference.p95_px))},
      {"max_px", known(orNull(difference.max_px))},
      {"worst_pixel", known(vectorJson(difference.worst_pixel))},
      {"grid",
       {{"columns", difference.columns},
        {"rows", difference.rows},
        {"pixels", rowsOf([&](std::size_t i) { return vectorJson(difference.pixels[i]); })},
        {"difference_px",
         rowsOf([&](std::size_t i) { return known(vectorJson(difference.difference_px[i])); })}}},
      {"significance", nullptr}};
  if (significance && is_known) {
    document["grid"]["std_px"] = rowsOf([&](std::size_t i) { return orNull(significance->std_px[i]); });
    document["significance"] = {{"sigmas", significance->sigmas},
                                {"significant", significance->isSignificant()},
                                {"expected_rms_px", significance->expected_rms_px},
                                {"sure_p95_px", significance->sure_p95_px},
                                {"share_beyond", significance->share_beyond}};
  }
  return document;
}

}  // namespace alidade
