// SPDX-License-Identifier: MIT
#include "summary_output.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <utility>
#include <vector>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "alidade/adjust/errors.h"
#include "alidade/core/size_groups.h"
#include "alidade/target/board_spec.h"
#include "command.h"

namespace alidade {
namespace {

using nlohmann::json;

constexpr std::size_t kMaxLines = 16;
constexpr std::size_t kMaxColumns = 100;
constexpr std::size_t kIndent = 10;

// Breaks words over lines of kMaxColumns; the first line has the label, the others an indent.
std::vector<std::string> wrapped(const std::string& label, const std::string& text) {
  std::vector<std::string> lines;
  std::string line = fmt::format("{:<{}}", label, kIndent);
  bool is_empty = true;
  std::size_t begin = 0;
  while (begin < text.size()) {
    const std::size_t end = std::min(text.find(' ', begin), text.size());
    const std::string word = text.substr(begin, end - begin);
    begin = end + 1;
    if (!is_empty && line.size() + 1 + word.size() > kMaxColumns) {
      lines.push_back(std::move(line));
      line = std::string(kIndent, ' ');
      is_empty = true;
    }
    line += (is_empty ? "" : " ") + word;
    is_empty = false;
  }
  if (line.size() > kMaxColumns) line = line.substr(0, kMaxColumns - 3) + "...";
  lines.push_back(std::move(line));
  return lines;
}

// Two digits of what is uncertain, without an exponent.
std::string pixels(double px) {
  constexpr double kLeast = 1e-4;
  if (!std::isfinite(px)) return "unknown";
  if (px < kLeast) return "0.0001 px";
  if (px >= 100) return fmt::format("{:.0f} px", px);
  const int decimals = px > 0 ? std::clamp(1 - static_cast<int>(std::floor(std::log10(px))), 0, 4) : 4;
  return fmt::format("{:.{}f} px", px, decimals);
}

std::string verdictText(const Calibration& result, bool is_coloured) {
  const auto [text, colour] = [&]() -> std::pair<const char*, int> {
    switch (result.verdict()) {
      case Verdict::kTrustworthy:
        return {"trustworthy", 32};
      case Verdict::kReservations:
        return {"usable with reservations", 33};
      case Verdict::kNo:
        break;
    }
    return {"rejected: do not use this camera", 31};
  }();
  return is_coloured ? fmt::format("\x1b[1;{}m{}\x1b[0m", colour, text) : text;
}

std::vector<std::string> accuracyLines(const Calibration& result, double tolerance_px) {
  if (!result.uncertainty.accuracy)
    return wrapped("Accuracy", "unknown: the views do not determine the camera");
  const Accuracy& accuracy = *result.uncertainty.accuracy;
  return {fmt::format("{:<{}}within {} (95 %) where boards were seen ({:.0f} % of the image)", "Accuracy",
                      kIndent, pixels(accuracy.covered_px), 100 * accuracy.covered_share),
          fmt::format("{:<{}}within {:.3g} px in {:.0f} % of the image; worst {} at pixel ({:.0f}, {:.0f})",
                      "", kIndent, tolerance_px, 100 * accuracy.shareWithin(tolerance_px),
                      pixels(accuracy.worst_px), accuracy.worst_pixel.x(), accuracy.worst_pixel.y())};
}

// "533.69 +- 0.95", rounded to two digits of the standard deviation.
std::string valueText(double value, double std) {
  if (!(std > 0) || !std::isfinite(std)) return fmt::format("{:.6g} fixed", value);
  const int most = std::abs(value) < 10 ? 5 : 3;  // four values to a line
  const int decimals = std::clamp(1 - static_cast<int>(std::floor(std::log10(std))), 0, most);
  return fmt::format("{:.{}f} +- {:.{}f}", value, decimals, std, decimals);
}

// Four parameters a line.
std::vector<std::string> parameterLines(const Calibration& result) {
  const FitCamera& camera = onlyCamera(result.fit);
  const auto names = parameterNames(camera.model);
  std::vector<std::string> lines;
  for (std::size_t i = 0; i < names.size(); ++i) {
    if (i % 4 == 0) lines.push_back(fmt::format("{:<{}}", i == 0 ? "Values" : "", kIndent));
    const double std = result.uncertainty.statedStd(static_cast<int>(i));
    const std::string value =
        std::isnan(std) ? fmt::format("{:.6g}", camera.params[i]) : valueText(camera.params[i], std);
    const std::string item = fmt::format("{} {}", names[i], value);
    lines.back() += i % 4 == 3 || i + 1 == names.size() ? item : fmt::format("{:<21} ", item);
  }
  return lines;
}

std::string fitText(const Calibration& result, const CalibrationInput& input) {
  const double holdout = result.uncertainty.holdout.rms_px;
  return fmt::format(
      "RMS {:.3f} px, cross-validation {}; {} corners in {} of {} images{}", rms(result.fit),
      std::isfinite(holdout) ? fmt::format("{:.3f} px", holdout) : "impossible", numCorners(result.fit),
      result.fit.views.size(), input.num_images,
      result.dropped.outliers.empty() ? "" : fmt::format("; {} outliers", result.dropped.outliers.size()));
}

std::string boardText(const Calibration& result, const CalibrationInput& input) {
  std::string text = specText(input.board);
  if (!isShapeEstimated(result.fit)) return text + ", flat";
  const BoardShape& shape = onlyBoard(result.fit).shape;
  return text + fmt::format(", bent by {:.2g} mm along columns and {:.2g} mm along rows",
                            1e3 * shape.bend_x_m, 1e3 * shape.bend_y_m);
}

std::string viewsText(const CoverageReport& coverage) {
  return fmt::format(
      "{} of {} tilted by more than 15 degrees; {:.2g} to {:.2g} m away; {} of 4 image corners covered",
      coverage.num_tilted, coverage.views.size(), coverage.nearest_m, coverage.farthest_m,
      coverage.num_image_corners);
}

void append(std::vector<std::string>& lines, std::vector<std::string> more) {
  for (std::string& line : more) lines.push_back(std::move(line));
}

}  // namespace

std::string_view severityLabel(Severity severity) {
  return severity == Severity::kFailure ? "FAILED" : severity == Severity::kWarning ? "Warning" : "Note";
}

std::string summaryText(const Calibration& result, const CalibrationInput& input, const Advice& advice,
                        const SummaryStyle& style) {
  std::vector<std::string> lines;
  lines.push_back(fmt::format("{:<{}}{}", "Verdict", kIndent, verdictText(result, style.is_coloured)));
  append(lines, accuracyLines(result, style.tolerance_px));
  std::vector<std::string> rest;
  append(rest, wrapped("Camera",
                       fmt::format("{}, {} px{}", onlyCamera(result.fit).model, sizeText(result.imageSize()),
                                   result.choice.model ? ", model chosen by cross-validation" : "")));
  append(rest, parameterLines(result));
  append(rest, wrapped("Fit", fitText(result, input)));
  append(rest, wrapped("Board", boardText(result, input)));
  append(rest, wrapped("Views", viewsText(advice.coverage)));
  std::vector<std::string> next = wrapped("Next", shortNextViewText(advice.guidance, result.imageSize()));
  // The diagnoses have the room that is left; what does not fit is counted.
  const std::size_t num_reserved =
      lines.size() + rest.size() + next.size() + (advice.guidance.target ? 3 : 1);
  std::size_t room = kMaxLines - std::min(num_reserved, kMaxLines);
  std::size_t num_untold = 0;
  std::size_t num_notes = 0;
  for (const Diagnosis& diagnosis : result.diagnoses) {
    if (diagnosis.severity == Severity::kNote) {
      ++num_notes;
      continue;
    }
    const std::vector<std::string> told =
        wrapped(std::string(severityLabel(diagnosis.severity)),
                diagnosis.message() + (diagnosis.next_step.empty() ? "" : "; " + diagnosis.next_step));
    if (told.size() > room) {
      ++num_untold;
      continue;
    }
    room -= told.size();
    append(lines, told);
  }
  append(lines, std::move(rest));
  append(lines, std::move(next));
  if (advice.guidance.target) {
    const std::string target = targetText(advice.guidance);
    append(lines, wrapped("Target", target.substr(0, target.find('\n'))));
  }
  if (num_untold + num_notes > 0) {
    const auto count = [](std::size_t n, const char* what) {
      return fmt::format("{} {}{}", n, what, n == 1 ? "" : "s");
    };
    lines.push_back(fmt::format("{:<{}}{}{}{}: see --verbose", "More", kIndent,
                                num_untold > 0 ? count(num_untold, "more warning") : "",
                                num_untold > 0 && num_notes > 0 ? ", " : "",
                                num_notes > 0 ? count(num_notes, "note") : ""));
  }
  std::string text;
  for (const std::string& line : lines) text += line + "\n";
  return text;
}

json accuracyJson(const Calibration& result) {
  if (!result.uncertainty.accuracy) return nullptr;
  const Accuracy& accuracy = *result.uncertainty.accuracy;
  json error = json::array();
  for (const double px : accuracy.error_px) error.push_back(orNull(px));
  return {{"covered_px", orNull(accuracy.covered_px)},
          {"covered_share", accuracy.covered_share},
          {"worst_px", orNull(accuracy.worst_px)},
          {"worst_pixel", {accuracy.worst_pixel.x(), accuracy.worst_pixel.y()}},
          {"deviation_px", accuracy.deviation_px},
          {"columns", accuracy.columns},
          {"rows", accuracy.rows},
          {"error_px", std::move(error)},
          {"is_covered", accuracy.is_covered}};
}

}  // namespace alidade
