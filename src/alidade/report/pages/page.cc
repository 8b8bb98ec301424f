// SPDX-License-Identifier: MIT
#include "alidade/report/pages/page.h"

#include <algorithm>
#include <cmath>
#include <optional>
#include <utility>

#include <fmt/format.h>

#include "alidade/core/diagnosis.h"
#include "alidade/core/error.h"
#include "alidade/core/mapped.h"
#include "alidade/core/number_text.h"
#include "alidade/core/text.h"
#include "alidade/report/canvas/page_table.h"
#include "alidade/report/figures/camera_figures.h"
#include "alidade/report/figures/scene_figure.h"
#include "alidade/report/pages/page_shell.h"
#include "alidade/report/pages/rig_page.h"

namespace alidade {
namespace {

constexpr double kMostOfImage = 0.9;  // share within the tolerance, as for a trustworthy camera

bool isMostlyAccurate(const CalibrationEvidence& data) {
  return data.accuracy && data.accuracy->shareWithin(data.tolerance_px) >= kMostOfImage;
}

// "81 % of the image is within 1 px"
std::string shareSentence(const CalibrationEvidence& data) {
  const Accuracy& accuracy = *data.accuracy;
  return fmt::format("{} of {} {} within {:g}\u00a0px", percentText(accuracy.shareWithin(data.tolerance_px)),
                     wholeName(accuracy), hasBlindPixels(accuracy) ? "are" : "is", data.tolerance_px);
}

std::string accuracySentence(const CalibrationEvidence& data) {
  if (!data.accuracy) return "The accuracy is unknown, because the views do not determine the camera.";
  const Accuracy& accuracy = *data.accuracy;
  const std::string of =
      std::isinf(accuracy.distance_m) ? "" : fmt::format(" for points {:g} m away", accuracy.distance_m);
  std::string text = fmt::format("Accurate to {} (95\u00a0%){} where boards were seen, which is {} of {}.",
                                 errorText(accuracy.covered_px), of, percentText(accuracy.covered_share),
                                 wholeName(accuracy));
  // With reservations, the headline already states the share.
  if (data.verdict != Verdict::kReservations || isMostlyAccurate(data))
    text += " " + shareSentence(data) + ".";
  text += fmt::format(" The worst place can be off by up to {}.", errorText(accuracy.worst_px));
  if (!isMostlyAccurate(data) && accuracy.shareWithin(data.tolerance_px) > 0)
    text += " Use it inside the thick line of the map.";
  return text;
}

std::vector<PageNumber> numbersOf(const CalibrationEvidence& data) {
  std::vector<PageNumber> numbers;
  if (data.accuracy) {
    numbers = {{"Accuracy", errorText(data.accuracy->covered_px), "95 %, where boards were seen", true},
               withinTolerance(data)};
  }
  append(
      numbers,
      {{"Cross-validation", std::isfinite(data.holdout_rms_px) ? rmsText(data.holdout_rms_px) : "impossible",
        "RMS of unseen corners"},
       {"Reprojection error", rmsText(data.rms_px), "RMS of all corners"},
       {"Images", fmt::format("{} of {}", data.num_images_used, data.num_images_given),
        "used for the calibration"},
       {"Corners", std::to_string(allCorners(data).size()),
        data.num_outliers == 0 ? "no outliers" : fmt::format("{} outliers left out", data.num_outliers)}});
  return numbers;
}

std::string parametersHtml(const CalibrationEvidence& data) {
  const auto names = data.camera.parameterNames();
  const auto values = data.camera.parameters();
  std::vector<PageRow> rows;
  for (std::size_t i = 0; i < names.size(); ++i) {
    const double std = data.parameter_std[i];
    rows.push_back({{std::string(names[i]), valueText(values[i], std), deviationText(values[i], std)},
                    isUndetermined(values[i], std) ? "weak" : ""});
  }
  const EntrancePupil& pupil = data.camera.pupil();
  for (std::size_t i = 0; i < data.pupil_std_m.size(); ++i) {
    const double value_mm = 1e3 * (i == 0 ? pupil.s1_m : pupil.s2_m);
    const double std_mm = 1e3 * data.pupil_std_m[i];
    rows.push_back({{"pupil " + std::string(EntrancePupil::kNames.at(i)) + ", mm",
                     valueText(value_mm, std_mm), deviationText(value_mm, std_mm)},
                    isUndetermined(value_mm, std_mm) ? "weak" : ""});
  }
  return tableFigure(
      "parameters", "Parameters", {{"Parameter"}, {"Value"}, {"Standard deviation"}}, rows,
      "The true value lies within two standard deviations in 95 of 100 cases. These photographs do not "
      "determine a parameter whose standard deviation exceeds it.");
}

// Explains why the chosen model's errors in the table differ from the camera's.
std::string choiceFootnote(const CalibrationEvidence& data) {
  const auto chosen = std::ranges::find(data.models, "chosen", &ModelCandidate::verdict);
  if (chosen == data.models.end()) return "";
  const bool is_same = shortNumber(chosen->rms_px) == shortNumber(data.rms_px) &&
                       shortNumber(chosen->holdout_rms_px) == shortNumber(data.holdout_rms_px);
  return is_same ? ""
                 : " The errors of the camera above differ: here each corner counts by its weight, and only "
                   "corners that all models share are compared.";
}

std::string modelsHtml(const CalibrationEvidence& data) {
  if (data.models.empty()) return "";
  const auto px = [](double value) { return std::isfinite(value) ? shortNumber(value) : std::string("–"); };
  std::vector<PageRow> rows;
  for (const ModelCandidate& model : data.models) {
    const bool is_chosen = model.verdict == "chosen";
    rows.push_back({{model.id, std::to_string(model.num_params), px(model.rms_px), px(model.holdout_rms_px),
                     is_chosen ? "chosen" : model.reason},
                    is_chosen ? "chosen" : ""});
  }
  return tableFigure(
      "models", "Candidate lens models",
      {{"Model"}, {"Parameters"}, {"Weighted RMS, px"}, {"Cross-validation, px"}, {"Result", "words"}}, rows,
      "Cross-validation measures the error on corners that were not used for the fit: a larger model that "
      "does not lower it only fits noise. The smallest model is chosen that no other outperforms; “–” was "
      "not needed for that." +
          choiceFootnote(data));
}

std::string detailsHtml(const CalibrationEvidence& data) {
  std::string html;
  std::vector<std::string> boards;
  for (const FitBoard& board : data.boards) {
    const bool is_flat = board.shape == BoardShape{};
    boards.push_back(board.target.spec() +
                     (board.isFlexible()
                          ? fmt::format(", bending by {:.2g} mm from view to view", 1e3 * board.flex.std_m)
                      : is_flat ? ", flat"
                                : fmt::format(", bent by {:.2g} mm in x and {:.2g} mm in y",
                                              1e3 * board.shape.bend_x_m, 1e3 * board.shape.bend_y_m)));
    const Eigen::Vector2d rms_m = offsetRms(board.shape);
    if (!board.shape.offsets_m.empty()) {
      boards.back() += fmt::format("; {} {:.2g} mm off in the plane and {:.2g} mm across it (RMS)",
                                   board.target.words().points, 1e3 * rms_m.x(), 1e3 * rms_m.y());
    }
  }
  html += listHtml(boards.size() == 1 ? "Board" : "Boards", boards);
  html += listHtml(counted(data.reasons.size(), "image") + " without a usable board", data.reasons);
  html += listHtml("Notes of the detection", data.notes);
  return html + listHtml("Settings", data.settings);
}

// @param pictures  of the views
std::vector<PageSection> sectionsOf(const CalibrationEvidence& data, const std::optional<RivalCamera>& rival,
                                    const ImageOfView& image_of, const std::vector<std::string>& pictures) {
  PageSection accuracy{.id = "where", .title = "Where the camera is accurate"};
  if (data.accuracy) {
    accuracy.figures.push_back(accuracyFigure(data));
  } else {
    accuracy.more =
        "<p class=\"reading\">There is no map of the accuracy, because these views do not determine the "
        "camera.</p>\n";
  }
  accuracy.figures.push_back(coverageFigure(data));
  PageSection next{.id = "how", .title = "How the board was held"};
  if (data.next_view) next.figures.push_back(nextViewFigure(data));
  append(next.figures, {tiltFigure(data), distanceFigure(data), sceneFigure(data)});
  PageSection errors{.id = "errors",
                     .title = "Reprojection errors",
                     .figures = {imageResidualsFigure(data), viewErrorsFigure(data)}};
  append(errors.figures, boardResidualsFigures(data));
  append(errors.figures, {histogramFigure(data), normalPlotFigure(data)});
  PageSection views{.id = "views", .title = "Views", .figures = {}, .more = viewSheet(data, pictures)};
  PageSection lens{.id = "lens", .title = "Lens", .figures = lensFigures(data)};
  if (std::optional<Figure> figure = undistortedFigure(data, image_of))
    lens.figures.push_back(*std::move(figure));
  if (rival) lens.figures.push_back(differenceFigure(data, *rival));
  PageSection parameters{.id = "values",
                         .title = "Parameters and models",
                         .figures = {},
                         .more = parametersHtml(data) + modelsHtml(data)};
  if (data.covariance) parameters.figures.push_back(correlationFigure(data));
  return {accuracy, next, errors, views, lens, parameters};
}

// The evidence for display: no suggestion if no photograph can help.
CalibrationEvidence readShownData(const nlohmann::json& evidence, const std::string& file) {
  CalibrationEvidence data = readCalibration(evidence, file);
  const bool is_in_vain = std::ranges::any_of(data.findings, [](const Diagnosis& finding) {
    return finding.severity == Severity::kFailure && finding.id.kind().rank == Rank::kCause;
  });
  if (is_in_vain) data.next_view.reset();
  for (Diagnosis& finding : data.findings)
    if (finding.id == DiagnosisId("poor_coverage") && !data.next_view)
      finding.next_step.clear();  // "take the suggested view"
  return data;
}

// The page of a rig has no comparison.
PageContent rigContent(const nlohmann::json& evidence, const std::string& file, const PageOptions& options) {
  if (options.rival) {
    throw usageError({.where = file,
                      .found = "the evidence of a rig, with --against",
                      .expected = "the evidence of one camera",
                      .next_step = "compare rigs with alidade diff"});
  }
  const ReportedRig rig = readRig(evidence, file);
  std::vector<PictureSource> pictures = options.pictures;
  if (!pictures.empty() && pictures.size() != rig.cameras.size()) {
    throw usageError({.where = "--images",
                      .found = fmt::format("{} inputs for the {} cameras of {}", pictures.size(),
                                           rig.cameras.size(), file),
                      .expected = "one for each camera, in the order of the file"});
  }
  pictures.resize(rig.cameras.size());
  return rigPage(rig, pictures, options.num_jobs);
}

}  // namespace

std::string reportPage(const nlohmann::json& evidence, const std::string& file, const PageOptions& options) {
  if (isRigEvidence(evidence)) return pageText(rigContent(evidence, file, options), evidence);
  const CalibrationEvidence data = readShownData(evidence, file);
  PictureSource source = options.pictures.empty() ? PictureSource() : options.pictures.front();
  source.image_of = keepingOne(source.image_of, undistortedImageName(data));
  const std::vector<std::string> pictures =
      viewPictures(data, data.num_images_given, source, options.num_jobs);
  PageContent page{
      .title = fmt::format("{}, {} × {} px", data.camera.modelId(), data.size.width, data.size.height),
      .origin = data.origin,
      .headline = verdictHeadline(data.verdict, "camera"),
      .verdict = data.verdict,
      .sentence = accuracySentence(data),
      .findings = asSentences(data.findings, mapped(data.views, &ReportedView::image)),
      .numbers = numbersOf(data),
      .sections = sectionsOf(data, options.rival, source.image_of, pictures),
      .details = detailsHtml(data)};
  if (data.verdict == Verdict::kReservations && data.accuracy && !isMostlyAccurate(data))
    page.headline += ": only " + shareSentence(data);
  page.subtitle = join(mapped(data.boards, [](const FitBoard& board) { return board.target.spec(); }), ", ");
  if (data.next_view) page.next_text = data.next_text;
  return pageText(page, evidence);
}

std::vector<FigureFile> reportFigures(const nlohmann::json& evidence, const std::string& file,
                                      const PageOptions& options) {
  if (isRigEvidence(evidence)) return figureFiles(rigContent(evidence, file, options).sections);
  const CalibrationEvidence data = readShownData(evidence, file);
  const ImageOfView image_of = options.pictures.empty() ? ImageOfView() : options.pictures.front().image_of;
  return figureFiles(sectionsOf(data, options.rival, image_of, std::vector<std::string>(data.views.size())));
}

}  // namespace alidade
