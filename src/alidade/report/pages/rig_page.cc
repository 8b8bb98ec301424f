// SPDX-License-Identifier: MIT
#include "alidade/report/pages/rig_page.h"

#include <algorithm>
#include <cmath>

#include <fmt/format.h>

#include "alidade/core/degrees.h"
#include "alidade/core/mapped.h"
#include "alidade/report/canvas/page_table.h"
#include "alidade/report/figures/camera_figures.h"
#include "alidade/report/figures/rig_figures.h"

namespace alidade {
namespace {

std::vector<PageSection> rigSections(const ReportedRig& rig) {
  const std::vector<EpipolarPair> pairs = epipolarPairs(rig);
  PageSection space{.id = "space", .title = "Where the cameras are", .figures = {rigSceneFigure(rig)}};
  // A single pair has a single number, which is already shown above.
  if (pairs.size() > 1) space.figures.push_back(epipolarFigure(rig, pairs));
  PageSection errors{.id = "errors", .title = "Errors over time"};
  if (!pairs.empty()) errors.figures.push_back(epipolarOverTimeFigure(rig, pairs));
  errors.figures.push_back(frameErrorsFigure(rig));
  return {space, errors};
}

// The lens of a camera and its views, folded.
std::string cameraFold(const ReportedRig& rig, std::size_t camera, const PictureSource& source,
                       int num_jobs) {
  const CalibrationEvidence data = cameraData(rig, camera);
  std::vector<Figure> figures;
  if (data.accuracy) figures.push_back(accuracyFigure(data));
  figures.push_back(coverageFigure(data));
  append(figures, lensFigures(data));
  figures.push_back(imageResidualsFigure(data));
  const std::string id = fmt::format("camera{}", camera);
  for (Figure& figure : figures) figure = withPrefix(std::move(figure), id + "-");
  return fmt::format(
      "<details class=\"file wide\" id=\"{}\" data-camera=\"{}\"><summary>{}</summary>\n{}</details>\n", id,
      camera, escapedMarkup(rig.cameras[camera].name),
      figuresHtml(figures, viewSheet(data, viewPictures(data, 0, source, num_jobs), id + "-")));
}

// "119.9 ± 0.3", with the digits that the standard deviation justifies.
std::string withDeviation(double value, double std) {
  if (!(std > 0) || !std::isfinite(std)) return fmt::format("{:.1f}", value);
  return valueText(value, std) + " ± " + valueText(std, std);
}

std::string distanceText(const ReportedRigCamera& camera) {
  return withDeviation(1e3 * camera.camera_from_rig.translation.norm(), 1e3 * camera.distance_std_m);
}

std::string turnText(const ReportedRigCamera& camera) {
  return withDeviation(kDegPerRad * camera.camera_from_rig.rotation.log().norm(),
                       kDegPerRad * camera.rotation_std_rad) +
         "°";
}

std::string camerasTable(const ReportedRig& rig) {
  const auto px = [](double value) { return std::isfinite(value) ? shortNumber(value) : std::string("–"); };
  std::vector<PageRow> rows;
  for (std::size_t c = 0; c < rig.cameras.size(); ++c) {
    const ReportedRigCamera& camera = rig.cameras[c];
    Eigen::Vector3d place = 1e3 * camera.camera_from_rig.inverse().translation;
    for (double& x : place) x = std::abs(x) < 0.05 ? 0 : x;  // no "-0.0"
    const bool is_first = c == 0;                            // it is at the rig's origin
    rows.push_back({.cells = {camera.name, std::string(camera.camera.modelId()),
                              fmt::format("{:.1f}, {:.1f}, {:.1f}", place.x(), place.y(), place.z()),
                              is_first ? "–" : distanceText(camera), is_first ? "–" : turnText(camera),
                              px(camera.rms_px), px(camera.alone_rms_px), px(camera.transfer_px)},
                    .link = fmt::format("#camera{}", c)});
  }
  return tableFigure(
      "rig-cameras", "Cameras",
      {{"Camera", "", true},
       {"Model"},
       {"Position, mm"},
       {"Distance, mm"},
       {"Turned by"},
       {"RMS, px"},
       {"Alone, px"},
       {"From its neighbour, px"}},
      rows,
      "Positions, distances and rotations are those from the first camera, with standard deviations. The "
      "last column is the error (95 %) with which a pixel of the neighbouring camera becomes a pixel of this "
      "one; an RMS far above that of the camera alone means that the cameras contradict each other.");
}

// The largest transfer error between cameras; 0 if none is known.
double worstTransferPx(const ReportedRig& rig) {
  double worst = 0;
  for (const ReportedRigCamera& camera : rig.cameras)
    if (std::isfinite(camera.transfer_px)) worst = std::max(worst, camera.transfer_px);
  return worst;
}

std::string rigSentence(const ReportedRig& rig) {
  const double worst = worstTransferPx(rig);
  if (!(worst > 0)) return "How well the cameras agree is unknown.";
  return fmt::format(
      "A pixel of one camera maps to its neighbour within {} (95\u00a0%), for points at the boards' "
      "distance.",
      errorText(worst));
}

std::vector<PageNumber> rigNumbers(const ReportedRig& rig) {
  std::vector<PageNumber> numbers;
  const double worst = worstTransferPx(rig);
  if (worst > 0)
    numbers.push_back({"From camera to camera", errorText(worst), "95 %, at the boards' distance", true});
  if (rig.cameras.size() == 2) {
    numbers.push_back({"Baseline", distanceText(rig.cameras[1]) + " mm", "with standard deviation", true});
    numbers.push_back({"Rotation", turnText(rig.cameras[1]), "between the cameras", true});
  }
  const bool is_uneven = std::ranges::any_of(
      rig.findings, [](const Diagnosis& finding) { return finding.id == DiagnosisId("uneven_board"); });
  numbers.push_back({"Cross-validation",
                     std::isfinite(rig.holdout_rms_px) ? rmsText(rig.holdout_rms_px) : "impossible",
                     "RMS in unseen frames"});
  numbers.push_back({"Reprojection error", rmsText(rig.rms_px),
                     is_uneven
                         ? "RMS of all corners; too good, because the board's points were fitted to them"
                         : "RMS of all corners"});
  const std::vector<EpipolarPair> pairs = epipolarPairs(rig);
  if (pairs.size() == 1)
    numbers.push_back({"Epipolar error", rmsText(pairs.front().rms_px), "RMS of all common corners"});
  numbers.push_back({"Cameras", std::to_string(rig.cameras.size()), "in one rig"});
  numbers.push_back({"Frames", std::to_string(rig.frames.size()), "of images"});
  numbers.push_back({"Links", std::to_string(rig.num_linked),
                     "boards, or sets of boards fixed to each other, seen by two or more cameras"});
  return numbers;
}

// "Rig of 2 cameras: left, right"
std::string rigTitle(const ReportedRig& rig) {
  constexpr std::size_t kMostNames = 6;
  std::string names;
  for (std::size_t c = 0; c < std::min(rig.cameras.size(), kMostNames); ++c)
    names += (c == 0 ? "" : ", ") + rig.cameras[c].name;
  return fmt::format("Rig of {} cameras: {}{}", rig.cameras.size(), names,
                     rig.cameras.size() > kMostNames ? " and others" : "");
}

}  // namespace

PageContent rigPage(const ReportedRig& rig, const std::vector<PictureSource>& pictures, int num_jobs) {
  std::vector<std::string> names = mapped(rig.cameras, &ReportedRigCamera::name);
  for (const ReportedView& view : rig.views) names.push_back(view.image);
  PageContent page{.title = rigTitle(rig),
                   .origin = rig.origin,
                   .headline = verdictHeadline(rig.verdict, "rig"),
                   .verdict = rig.verdict,
                   .sentence = rigSentence(rig),
                   .findings = asSentences(rig.findings, names),
                   .numbers = rigNumbers(rig),
                   .sections = rigSections(rig)};
  for (const Board& board : rig.boards) page.subtitle += (page.subtitle.empty() ? "" : ", ") + board.spec();
  page.sections.front().more = camerasTable(rig);
  PageSection each{.id = "each", .title = "Each camera"};
  for (std::size_t c = 0; c < rig.cameras.size(); ++c) each.more += cameraFold(rig, c, pictures[c], num_jobs);
  page.sections.push_back(std::move(each));
  page.details = listHtml(fmt::format("{} frames", rig.frames.size()), rig.frames);
  return page;
}

}  // namespace alidade
