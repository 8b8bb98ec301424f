// SPDX-License-Identifier: MIT
#include "summary_lines.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include <fmt/format.h>

#include "alidade/adjust/board/errors.h"
#include "alidade/camera/correction_field.h"
#include "alidade/core/degrees.h"
#include "alidade/core/mapped.h"
#include "alidade/core/number_text.h"
#include "alidade/core/text.h"
#include "alidade/geometry/rotation_conversions.h"
#include "command.h"
#include "console.h"

namespace alidade {
namespace {

// "533.69 +- 0.95", rounded to two digits of the standard deviation.
std::string valueText(double value, double std) {
  if (std::isnan(std)) return fmt::format("{:.6g}", value);
  if (!(std > 0) || !std::isfinite(std)) return fmt::format("{:.6g} fixed", value);
  const int decimals = decimalsFor(std, std::abs(value) < 10 ? 5 : 3);  // four values per line
  return fmt::format("{:.{}f} +- {:.{}f}", value, decimals, std, decimals);
}

// What differs from a flat or evenly bent board; empty for an even one.
std::string unevenText(const FitBoard& board) {
  if (board.isFlexible())
    return fmt::format(", bending by {:.2g} mm from view to view", 1e3 * board.flex.std_m);
  if (!board.isUneven()) return "";
  const Eigen::Vector2d rms_m = offsetRms(board.shape);
  return fmt::format(", uneven: {} {:.2g} mm off in the plane and {:.2g} mm across it (RMS)",
                     board.target.words().points, 1e3 * rms_m.x(), 1e3 * rms_m.y());
}

std::string boardText(const Fit& fit, std::size_t board) {
  const BoardShape& shape = fit.boards[board].shape;
  std::string text = fit.boards[board].target.spec();
  if (fit.boards.size() > 1) {
    const std::size_t num_views = numViews(fit, board);
    if (num_views == 0) return text + ", not used";
    text += fmt::format(" in {}", counted(num_views, "view"));
  }
  const std::string uneven = unevenText(fit.boards[board]);
  if (fit.boards[board].is_shape_fixed) return text + (uneven.empty() ? ", flat" : uneven);
  return text +
         fmt::format(", bent by {:.2g} mm in x and {:.2g} mm in y", 1e3 * shape.bend_x_m,
                     1e3 * shape.bend_y_m) +
         uneven;
}

}  // namespace

Lines wrapped(std::string_view label, const std::string& text) {
  Lines lines;
  std::string line = fmt::format("{:<{}}", label, kIndent);
  for (const std::string_view word : split(text, ' ')) {
    if (line.size() > kIndent && line.size() + 1 + word.size() > kMaxColumns)
      lines.push_back(std::exchange(line, std::string(kIndent, ' ')));
    if (line.size() > kIndent) line += " ";
    line += word;
  }
  if (line.size() > kMaxColumns) line = line.substr(0, kMaxColumns - 3) + "...";
  lines.push_back(std::move(line));
  return lines;
}

int decimalsFor(double std, int most) {
  return std > 0 ? std::clamp(1 - static_cast<int>(std::floor(std::log10(std))), 0, most) : most;
}

std::string pixels(double px) {
  constexpr double kLeast = 1e-4;
  if (!std::isfinite(px)) return "unknown";
  if (px < kLeast) return "0.0001 px";
  return px >= 100 ? fmt::format("{:.0f} px", px) : fmt::format("{:.{}f} px", px, decimalsFor(px, 4));
}

std::string millimetresText(double value_m, double std_m) {
  const int decimals = decimalsFor(1e3 * std_m, 6);
  return fmt::format("{:.{}f} +- {:.{}f}", 1e3 * value_m, decimals, 1e3 * std_m, decimals);
}

std::string turnText(const SO3& rotation) {
  const auto [angles, gimbal_lock] = eulerFromRotation(rotation);
  const auto degrees = [](double rad) {
    constexpr double kSteps = 1000;  // per degree
    return fmt::format("{:.3f}", std::round(kSteps * kDegPerRad * rad) / kSteps + 0.0);
  };
  return fmt::format("{} degrees ({} about z, {} about the new y, {} about the new x{})",
                     degrees(rotation.log().norm()), degrees(angles[0]), degrees(angles[1]),
                     degrees(angles[2]), gimbal_lock ? "; gimbal lock: z and x are one axis" : "");
}

std::string verdictText(Verdict verdict, std::string_view what, bool is_coloured) {
  const auto [text, colour] = verdict == Verdict::kTrustworthy ? std::pair(std::string("trustworthy"), 32)
                              : verdict == Verdict::kReservations
                                  ? std::pair(std::string("usable with reservations"), 33)
                                  : std::pair(fmt::format("rejected: do not use this {}", what), 31);
  return is_coloured ? fmt::format("\x1b[1;{}m{}\x1b[0m", colour, text) : text;
}

std::string_view severityLabel(Severity severity) {
  return severity == Severity::kFailure ? "FAILED" : severity == Severity::kWarning ? "Warning" : "Note";
}

Lines diagnosisLines(const Diagnosis& diagnosis) {
  return wrapped(severityLabel(diagnosis.severity),
                 diagnosis.message() + (diagnosis.next_step.empty() ? "" : "; " + diagnosis.next_step));
}

Lines moreLines(std::size_t num_warnings, std::size_t num_notes) {
  if (num_warnings + num_notes == 0) return {};
  const auto count = [](std::size_t n, const char* what) { return n == 0 ? "" : counted(n, what); };
  return {fmt::format("{:<{}}{}{}{}: see --verbose", "More", kIndent, count(num_warnings, "more warning"),
                      num_warnings > 0 && num_notes > 0 ? ", " : "", count(num_notes, "note"))};
}

Lines addDiagnoses(Lines& lines, std::span<const Diagnosis> diagnoses, std::size_t room,
                   const std::function<Lines(const Diagnosis&, std::size_t)>& lines_of) {
  std::size_t num_warnings = 0;
  std::size_t num_notes = 0;
  for (const Diagnosis& diagnosis : diagnoses) {
    const Lines told = lines_of(diagnosis, room);
    if (told.empty() || told.size() > room) {
      ++(diagnosis.severity == Severity::kNote ? num_notes : num_warnings);
    } else {
      room -= told.size();
      append(lines, told);
    }
  }
  return moreLines(num_warnings, num_notes);
}

Lines pupilLines(const Calibration& result) {
  const std::vector<double>& std_m = result.uncertainty.pupil_std_m;
  if (std_m.empty()) return {};
  const EntrancePupil pupil = cameraOf(result.fit).pupil();
  if (std_m.front() == 0) return wrapped("Pupil", "as given");
  const auto at = [&](double degrees) { return 1e3 * pupil.at(degrees / kDegPerRad); };
  return wrapped(
      "Pupil", std_m.size() == 1
                   ? fmt::format("moves by {} mm at 57 degrees off the axis",
                                 millimetresText(pupil.s1_m, std_m.front()))
                   : fmt::format("moves by {:.2g} mm at 30 degrees and {:.2g} mm at 60 degrees off the axis",
                                 at(30), at(60)));
}

Lines correctionLines(const Calibration& result) {
  const auto& field = onlyCamera(result.fit).correction;
  if (result.choice.is_correction_undetermined)
    return wrapped("Field", "none: the views show none beyond noise");
  if (field == nullptr) return {};
  const auto& found = result.choice.correction;
  if (!found) return wrapped("Field", "as given");
  return wrapped("Field",
                 fmt::format("{} by {} cells, {:.2g} px (RMS), at most {:.2g} px{}", field->grid().columns,
                             field->grid().rows, found->rms_px, found->worst_px,
                             found->excess ? fmt::format("; held-out errors {:.0f} % larger without",
                                                         100 * found->excess->share)
                                           : ""));
}

Lines parameterLines(const Calibration& result) {
  const FitCamera& camera = onlyCamera(result.fit);
  const auto names = parameterNames(camera.model);
  Lines lines;
  for (std::size_t i = 0; i < names.size(); ++i) {
    if (i % 4 == 0) lines.push_back(fmt::format("{:<{}}", i == 0 ? "Values" : "", kIndent));
    const double std = result.uncertainty.parameterStd(static_cast<int>(i));
    const std::string item = fmt::format("{} {}", names[i], valueText(camera.params[i], std));
    lines.back() += i % 4 == 3 || i + 1 == names.size() ? item : fmt::format("{:<21} ", item);
  }
  return lines;
}

Lines boardLines(const Fit& fit, std::size_t room) {
  Lines lines;
  for (std::size_t b = 0; b < fit.boards.size(); ++b) {
    const std::size_t num_left = fit.boards.size() - b;
    if (num_left > 1 && lines.size() + 1 >= room) {
      addLines(lines, b == 0 ? "Board" : "", "{} {}boards: see --verbose", num_left, b == 0 ? "" : "more ");
      break;
    }
    append(lines, wrapped(b == 0 ? "Board" : "", boardText(fit, b)));
  }
  return lines;
}

std::string outliersText(const Calibration& result) {
  const std::vector<Outlier>& outliers = result.dropped.outliers;
  if (outliers.empty()) return "";
  const Lines lines = mapped(outliers, [&](const Outlier& o) {
    return fmt::format("{}{} corner {}: error ({:.2f}, {:.2f}) px", printable(o.image),
                       boardSuffix(result.fit, o.board), o.corner_id, o.error_px.x(), o.error_px.y());
  });
  return fmt::format("Outliers {} of {} corners ({:.2g} %)\n", outliers.size(),
                     outliers.size() + numCorners(result.fit),
                     100 * result.dropped.outlierShare(result.fit)) +
         listed(lines);
}

std::string diagnosesText(std::span<const Diagnosis> diagnoses) {
  std::string text;
  for (const Diagnosis& diagnosis : diagnoses) {
    text +=
        fmt::format("{:<9}{} [{}]\n", severityLabel(diagnosis.severity), diagnosis.message(), diagnosis.id);
    if (!diagnosis.next_step.empty()) text += fmt::format("         next: {}\n", diagnosis.next_step);
  }
  return text;
}

}  // namespace alidade
