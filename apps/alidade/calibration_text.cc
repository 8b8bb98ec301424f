// SPDX-License-Identifier: MIT
#include <algorithm>
#include <cmath>
#include <numbers>
#include <utility>

#include <fmt/format.h>

#include "alidade/adjust/errors.h"
#include "alidade/core/mapped.h"
#include "alidade/core/number_text.h"
#include "alidade/core/size_groups.h"
#include "alidade/core/text.h"
#include "calibration_output.h"
#include "console.h"

namespace alidade {
namespace {

using Lines = std::vector<std::string>;

constexpr std::size_t kMaxLines = 16;
constexpr std::size_t kMaxColumns = 100;
constexpr std::size_t kIndent = 10;
constexpr std::size_t kMaxBoardLines = 3;

// Breaks words over lines of kMaxColumns; the first line has the label, the others an indent.
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

void append(Lines& lines, const Lines& more) {
  lines.insert(lines.end(), more.begin(), more.end());
}

// The decimals that show two digits of a standard deviation.
int decimalsFor(double std, int most) {
  return std > 0 ? std::clamp(1 - static_cast<int>(std::floor(std::log10(std))), 0, most) : most;
}

// Two digits of what is uncertain, without an exponent.
std::string pixels(double px) {
  constexpr double kLeast = 1e-4;
  if (!std::isfinite(px)) return "unknown";
  if (px < kLeast) return "0.0001 px";
  return px >= 100 ? fmt::format("{:.0f} px", px) : fmt::format("{:.{}f} px", px, decimalsFor(px, 4));
}

std::string verdictText(const Calibration& result, bool is_coloured) {
  const Verdict verdict = result.verdict();
  const auto [text, colour] = verdict == Verdict::kTrustworthy ? std::pair("trustworthy", 32)
                              : verdict == Verdict::kReservations
                                  ? std::pair("usable with reservations", 33)
                                  : std::pair("rejected: do not use this camera", 31);
  return is_coloured ? fmt::format("\x1b[1;{}m{}\x1b[0m", colour, text) : text;
}

std::string_view severityLabel(Severity severity) {
  return severity == Severity::kFailure ? "FAILED" : severity == Severity::kWarning ? "Warning" : "Note";
}

Lines accuracyLines(const Calibration& result, double tolerance_px) {
  if (!result.uncertainty.accuracy)
    return wrapped("Accuracy", "unknown: the views do not determine the camera");
  const Accuracy& accuracy = *result.uncertainty.accuracy;
  const std::string where =
      std::isinf(accuracy.distance_m) ? "" : fmt::format(" at {:g} m", accuracy.distance_m);
  const char* whole = result.domain.full_image ? "the image" : "the pixels with a ray";
  return {fmt::format("{:<{}}within {} (95 %){} where boards were seen ({} of {})", "Accuracy", kIndent,
                      pixels(accuracy.covered_px), where, percentText(accuracy.covered_share), whole),
          fmt::format("{:<{}}within {:.3g} px in {} of {}; worst {} at pixel ({:.0f}, {:.0f})", "", kIndent,
                      tolerance_px, percentText(accuracy.shareWithin(tolerance_px)), whole,
                      pixels(accuracy.worst_px), accuracy.worst_pixel.x(), accuracy.worst_pixel.y())};
}

// "533.69 +- 0.95", rounded to two digits of the standard deviation.
std::string valueText(double value, double std) {
  if (std::isnan(std)) return fmt::format("{:.6g}", value);
  if (!(std > 0) || !std::isfinite(std)) return fmt::format("{:.6g} fixed", value);
  const int decimals = decimalsFor(std, std::abs(value) < 10 ? 5 : 3);  // four values to a line
  return fmt::format("{:.{}f} +- {:.{}f}", value, decimals, std, decimals);
}

// Four parameters a line.
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

std::string fitText(const Calibration& result, const GivenViews& given) {
  const double holdout = result.uncertainty.holdout.rms_px;
  const std::string views =
      result.fit.boards.size() > 1 ? fmt::format("{} views in ", result.fit.views.size()) : "";
  return fmt::format(
      "RMS {:.3f} px, cross-validation {}; {} corners in {}{} of {} images{}", rms(result.fit),
      std::isfinite(holdout) ? fmt::format("{:.3f} px", holdout) : "impossible", numCorners(result.fit),
      views, numImagesUsed(result), given.num_images,
      result.dropped.outliers.empty() ? "" : fmt::format("; {} outliers", result.dropped.outliers.size()));
}

// Empty for an even board.
std::string unevenText(const FitBoard& board) {
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
    text += fmt::format(" in {} view{}", num_views, num_views == 1 ? "" : "s");
  }
  const std::string uneven = unevenText(fit.boards[board]);
  if (fit.boards[board].is_shape_fixed) return text + (uneven.empty() ? ", flat" : uneven);
  return text +
         fmt::format(", bent by {:.2g} mm in x and {:.2g} mm in y", 1e3 * shape.bend_x_m,
                     1e3 * shape.bend_y_m) +
         uneven;
}

// One line for each board, or as many boards as there is room for and the number of the others.
Lines boardLines(const Fit& fit, std::size_t room) {
  Lines lines;
  for (std::size_t b = 0; b < fit.boards.size(); ++b) {
    const std::size_t num_left = fit.boards.size() - b;
    if (num_left > 1 && lines.size() + 1 >= room) {
      append(lines, wrapped(b == 0 ? "Board" : "",
                            fmt::format("{} {}boards: see --verbose", num_left, b == 0 ? "" : "more ")));
      break;
    }
    append(lines, wrapped(b == 0 ? "Board" : "", boardText(fit, b)));
  }
  return lines;
}

std::string viewsText(const CoverageReport& coverage) {
  return fmt::format(
      "{} of {} tilted by more than 15 degrees; {:.2g} to {:.2g} m away; {} of 4 image corners covered",
      coverage.num_tilted, coverage.views.size(), coverage.nearest_m, coverage.farthest_m,
      coverage.num_image_corners);
}

// What follows is for --verbose.

constexpr std::size_t kDetailIndent = 9;

// The first line behind a label, the others under it.
std::string labelled(std::string_view label, const std::string& lines) {
  std::string text;
  for (const std::string_view line : split(lines, '\n')) {
    if (!line.empty()) text += fmt::format("{:<9}{}\n", text.empty() ? label : "", line);
  }
  return text;
}

// "1.02 +- 0.01"
std::string millimetres(double value_m, double std_m) {
  const int decimals = decimalsFor(1e3 * std_m, 6);
  return fmt::format("{:.{}f} +- {:.{}f}", 1e3 * value_m, decimals, 1e3 * std_m, decimals);
}

// What the two tests for a bend say.
std::string bendTests(const ShapeReport& shape) {
  if (!shape.by_views) return fmt::format("F = {:.3g}", shape.f);
  return fmt::format("F = {:.3g} from corner noise, {:.3g} between views, p-value {:.2g} %", shape.f,
                     shape.by_views->f, 100 * shape.by_views->chance);
}

// What the views say of a board's bend: one line or two.
std::string boardShapeText(const Calibration& result, std::size_t board) {
  const ShapeReport& shape = result.choice.shapes[board];
  const Eigen::Vector2d& std_m = result.uncertainty.bend_std_m[board];
  if (!shape.is_determined) return "Board    assumed flat: these views cannot show whether it is bent\n";
  if (result.fit.boards[board].is_shape_fixed) {
    if (!std::isfinite(shape.f)) return "Board    assumed flat\n";
    return fmt::format("Board    flat: {} ({}; standard deviation {:.2g} and {:.2g} mm)\n",
                       shape.f > kBendF ? "the views do not agree on a bend" : "no bend detected",
                       bendTests(shape), 1e3 * std_m.x(), 1e3 * std_m.y());
  }
  const BoardShape& bend = result.fit.boards[board].shape;
  return fmt::format(
      "Board    bent ({}): its centre is {} mm behind its left and right edges and {} mm behind its top and "
      "bottom edges;\n         with a flat board, the RMS would be {:.4g} px and fx {:.2f} instead of {:.2f} "
      "px\n",
      bendTests(shape), millimetres(bend.bend_x_m, std_m.x()), millimetres(bend.bend_y_m, std_m.y()),
      shape.flat_rms_px, shape.flat_params[0], onlyCamera(result.fit).params[0]);
}

// The same for all boards, each with its SPEC and its views if there are several.
std::string boardShapesText(const Calibration& result) {
  const Fit& fit = result.fit;
  if (fit.boards.size() == 1) return boardShapeText(result, 0);
  std::string text;
  for (std::size_t b = 0; b < fit.boards.size(); ++b) {
    const std::size_t num_views = numViews(fit, b);
    text += fmt::format("Board    {}: {} view{}\n", fit.boards[b].target.spec(), num_views,
                        num_views == 1 ? "" : "s");
    if (num_views > 0) text += "         " + boardShapeText(result, b).substr(kDetailIndent);
  }
  return text;
}

std::string excessText(const ModelCandidate& candidate) {
  if (!std::isfinite(candidate.excess)) return "-";
  constexpr double kManyTimes = 2;
  if (candidate.excess > kManyTimes) return fmt::format("{:.3g} times", 1 + candidate.excess);
  return fmt::format("{:+.1f} +- {:.1f} %", 100 * candidate.excess, 100 * candidate.excess_std);
}

// The table of models.
std::string modelChoiceText(const ModelChoice& choice) {
  const auto px = [](double value) { return std::isfinite(value) ? fmt::format("{:.4g}", value) : "-"; };
  const std::string field =
      std::isfinite(choice.field_rad)
          ? fmt::format("a field of view of {:.0f} degrees", choice.field_rad * 180 / std::numbers::pi)
          : "an image wider than the field of view of the lens";
  std::string text = fmt::format("Models   compared by cross-validation RMS, for {}\n", field);
  text += fmt::format("  {:<14} {:>10} {:>9} {:>9} {:>20}\n", "", "parameters", "RMS px", "held-out",
                      "excess over best");
  for (const ModelCandidate& c : choice.candidates) {
    text += fmt::format("  {:<14} {:>10} {:>9} {:>9} {:>20}  {}\n", c.id, c.num_params, px(c.rms_px),
                        px(c.holdout_rms_px), excessText(c), c.verdict == "chosen" ? "chosen" : c.reason);
  }
  return text;
}

// The least known of what a weak prior holds together.
std::string weakPriorText(const Calibration& result) {
  const WeakPrior& held = onlyCamera(result.fit).weak_prior;
  if (held.isNone()) return "";
  std::string text = fmt::format("Prior    width {:g} units per lens parameter; without it:", held.width);
  for (const int i : held.least_known) {
    const auto at = static_cast<std::size_t>(i);
    text += fmt::format(" {} {:.4g}", parameterNames(onlyCamera(result.fit).model)[at], held.free_params[at]);
  }
  return text + "\n";
}

// "0.012 px at the image's centre, at worst 0.31 px at pixel (0, 0)"
std::string gridText(const UncertaintyGrid& grid) {
  const std::string center = std::isfinite(grid.center_px)
                                 ? fmt::format("{:.2g} px at the image's centre", grid.center_px)
                                 : "no ray at the image's centre";
  if (!std::isfinite(grid.worst_px)) return center + ", unknown elsewhere";
  return fmt::format("{}, at worst {:.2g} px at pixel ({:.0f}, {:.0f})", center, grid.worst_px,
                     grid.worst_pixel.x(), grid.worst_pixel.y());
}

std::string projectionText(const Uncertainty& known) {
  if (!known.projection_far) return "";
  std::string text = "Projection, one sigma: error of a point's pixel due to the parameters\n";
  text += fmt::format("  {:<14} {}\n", "distant points", gridText(*known.projection_far));
  text += fmt::format("  {:<14} {}\n", "board distance", gridText(*known.projection_near));
  return text;
}

std::string domainText(const Calibration& result) {
  const CertifiedCone& cone = result.domain.cone;
  return fmt::format("Domain   one-to-one up to {:.1f} degrees from the axis{}; {}\n",
                     cone.max_angle_rad * 180 / std::numbers::pi,
                     cone.is_limited_by_fold ? " (a fold or pole)" : "",
                     result.domain.full_image ? "every pixel of the image has a ray"
                                              : "NOT every pixel of the image has a ray");
}

std::string worstViewsText(const Calibration& result) {
  constexpr std::size_t kNumWorst = 3;
  std::vector<ViewSummary> views = viewSummaries(result);
  std::stable_sort(views.begin(), views.end(),
                   [](const ViewSummary& a, const ViewSummary& b) { return a.rms_px > b.rms_px; });
  views.resize(std::min(views.size(), kNumWorst));
  std::string text = "Views with the largest errors\n";
  for (const ViewSummary& view : views) {
    text += fmt::format("  {:<24} RMS {:.3g} px, largest {:.3g} px, {} corners\n",
                        printable(view.image) + boardSuffix(result.fit, view.board), view.rms_px,
                        view.max_error_px, view.num_corners);
  }
  return text;
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

std::string startText(const StartReport& start) {
  if (start.num_tried == 0) return "Starts   the given camera\n";
  std::string text = fmt::format(
      "Starts   {} fields of view tried, the best {} solved, {} of these converged to the same solution",
      start.num_tried, start.num_solved, start.num_agreed);
  if (start.num_optima > 1) text += fmt::format("; {} lens shapes compared", start.num_optima);
  return text + "\n";
}

std::string diagnosesText(const Calibration& result) {
  std::string text;
  for (const Diagnosis& diagnosis : result.diagnoses) {
    text +=
        fmt::format("{:<9}{} [{}]\n", severityLabel(diagnosis.severity), diagnosis.message(), diagnosis.id);
    if (!diagnosis.next_step.empty()) text += fmt::format("         next: {}\n", diagnosis.next_step);
  }
  return text;
}

}  // namespace

std::size_t numImagesUsed(const Calibration& result) {
  const std::vector<FitView>& views = result.fit.views;
  std::size_t count = 0;
  for (std::size_t v = 0; v < views.size(); ++v) {
    // Views of one image are neighbours.
    if (v == 0 || views[v].image != views[v - 1].image) ++count;
  }
  return count;
}

std::string summaryText(const Calibration& result, const GivenViews& given, const Advice& advice,
                        const SummaryStyle& style) {
  Lines lines = wrapped("Verdict", verdictText(result, style.is_coloured));
  append(lines, accuracyLines(result, style.tolerance_px));
  Lines rest =
      wrapped("Camera", fmt::format("{}, {} px{}", onlyCamera(result.fit).model, sizeText(result.imageSize()),
                                    result.choice.model ? ", model chosen by cross-validation" : ""));
  append(rest, parameterLines(result));
  append(rest, wrapped("Fit", fitText(result, given)));
  Lines last = wrapped("Views", viewsText(advice.coverage));
  append(last, wrapped("Next", shortNextViewText(advice.guidance, result.imageSize())));
  const std::size_t num_others = lines.size() + rest.size() + last.size() + (advice.guidance.target ? 3 : 1);
  append(rest, boardLines(result.fit, std::clamp<std::size_t>(kMaxLines - std::min(num_others, kMaxLines), 1,
                                                              kMaxBoardLines)));
  append(rest, last);
  // The diagnoses have the room that is left; what does not fit is counted.
  const std::size_t num_reserved = lines.size() + rest.size() + (advice.guidance.target ? 3 : 1);
  std::size_t room = kMaxLines - std::min(num_reserved, kMaxLines);
  std::size_t num_untold = 0;
  std::size_t num_notes = 0;
  for (const Diagnosis& diagnosis : result.diagnoses) {
    if (diagnosis.severity == Severity::kNote) {
      ++num_notes;
      continue;
    }
    const Lines told =
        wrapped(severityLabel(diagnosis.severity),
                diagnosis.message() + (diagnosis.next_step.empty() ? "" : "; " + diagnosis.next_step));
    if (told.size() > room) {
      ++num_untold;
      continue;
    }
    room -= told.size();
    append(lines, told);
  }
  append(lines, rest);
  if (advice.guidance.target) {
    const std::string target = targetText(advice.guidance);
    append(lines, wrapped("Target", target.substr(0, target.find('\n'))));
  }
  if (num_untold + num_notes > 0) {
    const auto count = [](std::size_t n, const char* what) {
      return n == 0 ? "" : fmt::format("{} {}{}", n, what, n == 1 ? "" : "s");
    };
    lines.push_back(fmt::format("{:<{}}{}{}{}: see --verbose", "More", kIndent,
                                count(num_untold, "more warning"),
                                num_untold > 0 && num_notes > 0 ? ", " : "", count(num_notes, "note")));
  }
  return join(lines, "\n") + "\n";
}

std::string detailsText(const Calibration& result, const GivenViews& given, const Advice& advice) {
  const Uncertainty& known = result.uncertainty;
  const SolveSummary& solver = result.fit.summary;
  std::string text =
      fmt::format("Images   {} given, {} with {} board, {} used\n", given.num_images, given.num_found,
                  given.boards.size() > 1 ? "a" : "the", numImagesUsed(result));
  for (const std::string& measures : given.measures) text += "         " + measures + "\n";
  text += listed(given.reasons);
  text += fmt::format("Noise    {:.3g} px per coordinate (standard deviation of the residuals)\n",
                      known.coordinate_sigma_px);
  if (std::isfinite(known.unexplained_sigma_px)) {
    text += fmt::format("         {:.3g} px of it is not explained by the detector's standard deviations\n",
                        known.unexplained_sigma_px);
  }
  text += boardShapesText(result);
  if (result.choice.model) text += modelChoiceText(*result.choice.model);
  text += weakPriorText(result) + projectionText(known) + domainText(result) + worstViewsText(result) +
          outliersText(result) + startText(result.choice.start);
  text += fmt::format("Solver   {} after {} iterations: {}\n", terminationName(solver.termination),
                      solver.num_iterations, solver.reason);
  text += labelled("Coverage", coverageText(advice.coverage)) +
          labelled("Next", nextViewText(advice.guidance, result.imageSize())) +
          labelled("Target", targetText(advice.guidance));
  for (const std::string& note : given.notes) text += "Note     " + note + "\n";
  return text + diagnosesText(result);
}

}  // namespace alidade
