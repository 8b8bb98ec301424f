// SPDX-License-Identifier: MIT
#include <algorithm>
#include <array>
#include <cmath>

#include <fmt/format.h>

#include "alidade/adjust/board/errors.h"
#include "alidade/calibrate/bend/shape_fit.h"
#include "alidade/core/degrees.h"
#include "alidade/core/diagnosis.h"
#include "alidade/core/number_text.h"
#include "alidade/core/size_groups.h"
#include "alidade/core/text.h"
#include "command.h"
#include "commands/calibrate/calibration_output.h"
#include "console.h"
#include "summary_lines.h"

namespace alidade {
namespace {

// ", not counting the 1.7 px of focal_changed": the largest effect of a cause that exceeds the accuracy,
// which assumes that nothing is wrong.
std::string uncountedText(const Calibration& result) {
  const Diagnosis* largest = nullptr;
  for (const Diagnosis& diagnosis : result.diagnoses) {
    if (diagnosis.severity < Severity::kWarning || diagnosis.id.kind().rank == Rank::kConsequence ||
        !(diagnosis.effect_px > result.uncertainty.accuracy->covered_px))
      continue;
    if (largest == nullptr || diagnosis.effect_px > largest->effect_px) largest = &diagnosis;
  }
  return largest == nullptr
             ? ""
             : fmt::format(", not counting the {} of {}", pixels(largest->effect_px), largest->id);
}

Lines accuracyLines(const Calibration& result, double tolerance_px) {
  if (!result.uncertainty.accuracy)
    return wrapped("Accuracy", "unknown: the views do not determine the camera");
  const Accuracy& accuracy = *result.uncertainty.accuracy;
  const std::string where =
      std::isinf(accuracy.distance_m) ? "" : fmt::format(" at {:g} m", accuracy.distance_m);
  const char* whole = result.domain.full_image ? "the image" : "the pixels with a ray";
  Lines lines =
      wrapped("Accuracy", fmt::format("within {} (95 %){} where boards were seen ({} of {}){}",
                                      pixels(accuracy.covered_px), where, percentText(accuracy.covered_share),
                                      whole, uncountedText(result)));
  addLines(lines, "", "within {:.3g} px in {} of {}; worst {} at pixel ({:.0f}, {:.0f})", tolerance_px,
           percentText(accuracy.shareWithin(tolerance_px)), whole, pixels(accuracy.worst_px),
           accuracy.worst_pixel.x(), accuracy.worst_pixel.y());
  return lines;
}

std::string fitText(const Calibration& result, const GivenViews& given) {
  const double holdout = result.uncertainty.holdout.rms_px;
  const std::string views =
      result.fit.boards.size() > 1 ? fmt::format("{} views in ", result.fit.views.size()) : "";
  const auto num_other =
      given.surveys.empty()
          ? 0
          : std::ranges::count_if(given.surveys.front().outcomes, [](const ImageOutcome& outcome) {
              return outcome.detection.reason == DetectionReason::kOtherSize;
            });
  return fmt::format(
      "RMS {:.3f} px, cross-validation {}; {} corners in {}{} of {} images{}{}", rms(result.fit),
      std::isfinite(holdout) ? fmt::format("{:.3f} px", holdout) : "impossible", numCorners(result.fit),
      views, numImagesUsed(result), given.num_images,
      num_other > 0 ? fmt::format(" ({} left out for their size)", num_other) : "",
      result.dropped.outliers.empty() ? "" : fmt::format("; {} outliers", result.dropped.outliers.size()));
}

std::string viewsText(const CoverageReport& coverage) {
  return fmt::format(
      "{} of {} tilted by more than 15 degrees; {:.2g} to {:.2g} m away; {} of 4 image corners covered",
      coverage.numTilted(kTiltedRad), coverage.views.size(), coverage.nearest_m, coverage.farthest_m,
      coverage.num_image_corners);
}

// The rest is for --verbose.

constexpr std::size_t kDetailIndent = 9;

// The first line after a label, the others below it.
std::string labelled(std::string_view label, const std::string& lines) {
  std::string text;
  for (const std::string_view line : split(lines, '\n')) {
    if (!line.empty()) text += fmt::format("{:<9}{}\n", text.empty() ? label : "", line);
  }
  return text;
}

// The results of the two tests for a bend.
std::string bendTests(const ShapeReport& shape) {
  if (!shape.by_views) return fmt::format("F = {:.3g}", shape.f);
  return fmt::format("F = {:.3g} from corner noise, {:.3g} between views, p-value {:.2g} %", shape.f,
                     shape.by_views->f, 100 * shape.by_views->chance);
}

// The bend of a board according to the views, in one or two lines.
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
      bendTests(shape), millimetresText(bend.bend_x_m, std_m.x()), millimetresText(bend.bend_y_m, std_m.y()),
      shape.flat_rms_px, shape.flat_params[0], onlyCamera(result.fit).params[0]);
}

// The same for all boards, each with its SPEC and its views if there are several.
std::string boardShapesText(const Calibration& result) {
  const Fit& fit = result.fit;
  if (fit.boards.size() == 1) return boardShapeText(result, 0);
  std::string text;
  for (std::size_t b = 0; b < fit.boards.size(); ++b) {
    const std::size_t num_views = numViews(fit, b);
    text += fmt::format("Board    {}: {}\n", fit.boards[b].target.spec(), counted(num_views, "view"));
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

// Table of candidate models.
std::string modelChoiceText(const ModelChoice& choice) {
  const auto px = [](double value) { return std::isfinite(value) ? fmt::format("{:.4g}", value) : "-"; };
  const std::string field =
      std::isfinite(choice.field_rad)
          ? fmt::format("a field of view of {:.0f} degrees", choice.field_rad * kDegPerRad)
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

// The least certain quantity that a weak prior constrains.
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
                     cone.max_angle_rad * kDegPerRad, cone.is_limited_by_fold ? " (a fold or pole)" : "",
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

std::string startText(const StartReport& start) {
  if (start.num_tried == 0) return "Starts   the given camera\n";
  std::string text = fmt::format(
      "Starts   {} fields of view tried, the best {} solved, {} of these converged to the same solution",
      start.num_tried, start.num_solved, start.num_agreed);
  if (start.num_optima > 1) text += fmt::format("; {} lens shapes compared", start.num_optima);
  return text + "\n";
}

// Without the evidence, to save lines.
Lines toldShortly(const Diagnosis& diagnosis) {
  return wrapped(severityLabel(diagnosis.severity),
                 diagnosis.cause + (diagnosis.next_step.empty() ? "" : "; " + diagnosis.next_step));
}

}  // namespace

std::string summaryText(const Calibration& result, const GivenViews& given, const Guidance& guidance,
                        double tolerance_px, bool is_coloured, bool is_verbose) {
  Lines lines = wrapped("Verdict", verdictText(result.verdict(), "camera", is_coloured));
  append(lines, accuracyLines(result, tolerance_px));
  Lines rest =
      wrapped("Camera", fmt::format("{}, {} px{}", onlyCamera(result.fit).model, sizeText(result.imageSize()),
                                    result.choice.model ? ", model chosen by cross-validation" : ""));
  append(rest, parameterLines(result));
  append(rest, pupilLines(result));
  append(rest, correctionLines(result));
  append(rest, wrapped("Fit", fitText(result, given)));
  if (is_verbose) {
    append(lines, rest);
    return join(lines, "\n") + "\n";
  }
  Lines last = wrapped("Views", viewsText(guidance.coverage));
  // The reason for a rejection or reservations is always shown.
  const bool has_reason =
      !result.diagnoses.empty() && result.diagnoses.front().severity >= Severity::kWarning;
  const std::size_t num_needed = has_reason ? toldShortly(result.diagnoses.front()).size() : 0;
  std::size_t num_others = lines.size() + rest.size() + last.size() + (guidance.target ? 3 : 1) + num_needed;
  // It matters more than the next view.
  const Lines next = wrapped("Next", shortNextViewText(guidance, result.imageSize()));
  if (!has_reason || num_others + next.size() < kMaxLines) {
    append(last, next);
    num_others += next.size();
  }
  append(rest, boardLines(result.fit, std::clamp<std::size_t>(kMaxLines - std::min(num_others, kMaxLines), 1,
                                                              kMaxBoardLines)));
  append(rest, last);
  // The diagnoses get the remaining lines; those that do not fit are counted, except for the reason.
  const std::size_t num_reserved = lines.size() + rest.size() + (guidance.target ? 3 : 1);
  const Lines more = addDiagnoses(
      lines, result.diagnoses, std::max(num_needed, kMaxLines - std::min(num_reserved, kMaxLines)),
      [&](const Diagnosis& diagnosis, std::size_t room) {
        if (diagnosis.severity == Severity::kNote) return Lines();
        Lines told = diagnosisLines(diagnosis);
        const bool is_reason = &diagnosis == &result.diagnoses.front();
        const bool is_shortened = is_reason || diagnosis.severity == Severity::kFailure;
        return told.size() > room && is_shortened ? toldShortly(diagnosis) : told;
      });
  append(lines, rest);
  if (guidance.target) {
    const std::string target = targetText(guidance);
    append(lines, wrapped("Target", target.substr(0, target.find('\n'))));
  }
  append(lines, more);
  return join(lines, "\n") + "\n";
}

std::string detailsText(const Calibration& result, const GivenViews& given, const Guidance& guidance) {
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
  text += fmt::format("Solver   {} after {}\n", terminationName(solver.termination),
                      counted(solver.num_iterations, "iteration"));
  text += labelled("Coverage", coverageText(guidance.coverage)) +
          labelled("Next", nextViewText(guidance, result.imageSize())) +
          labelled("Target", targetText(guidance));
  for (const std::string& note : given.notes) text += "Note     " + note + "\n";
  return text + diagnosesText(result.diagnoses);
}

std::string coveragePicture(const CoverageReport& coverage) {
  // Two characters each, because a character is about half as wide as high.
  constexpr std::array<const char*, 6> kCells = {"  ", "··", "░░", "▒▒", "▓▓", "██"};
  const int most = coverage.num_corners.empty() ? 0 : *std::ranges::max_element(coverage.num_corners);
  const auto cellOf = [&](int count) -> std::size_t {
    if (count < 0) return 0;  // no ray
    if (count == 0) return 1;
    const double strength = std::sqrt(static_cast<double>(count) / most);
    return 2 + std::min<std::size_t>(3, static_cast<std::size_t>(4 * strength));
  };
  const std::array<std::string, 2> words = {"the image; the darker, the more corners",
                                            "·· none: put the board there"};
  std::string text;
  for (int row = 0; row < coverage.rows; ++row) {
    text += row == 0 ? "Seen      " : "          ";
    for (int column = 0; column < coverage.columns; ++column)
      text += kCells[cellOf(coverage.num_corners[static_cast<std::size_t>(row * coverage.columns + column)])];
    if (static_cast<std::size_t>(row) < words.size()) text += "   " + words[static_cast<std::size_t>(row)];
    text += "\n";
  }
  return text;
}

}  // namespace alidade
