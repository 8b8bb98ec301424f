// SPDX-License-Identifier: MIT
#include "alidade/report/rig_page.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "alidade/report/rig_figures.h"

namespace alidade {
namespace {

constexpr double kRigDegrees = 180 / std::numbers::pi;

std::vector<PageSection> rigSections(const ReportedRig& rig) {
  const std::vector<EpipolarPair> pairs = epipolarPairs(rig);
  PageSection space{.id = "space", .title = "Where the cameras are", .figures = {rigSceneFigure(rig)}};
  if (!pairs.empty()) space.figures.push_back(epipolarFigure(rig, pairs));
  PageSection errors{.id = "errors", .title = "Errors over time"};
  if (!pairs.empty()) errors.figures.push_back(epipolarOverTimeFigure(rig, pairs));
  errors.figures.push_back(frameErrorsFigure(rig));
  return {space, errors};
}

std::string camerasTable(const ReportedRig& rig) {
  std::string html =
      "<figure id=\"rig-cameras\" class=\"wide\"><h3>Cameras</h3><div class=\"scroll\"><table><thead><tr>"
      "<th scope=\"col\">Camera</th><th scope=\"col\">Model</th><th scope=\"col\">Position, mm</th><th "
      "scope=\"col\">"
      "Standard deviation, mm</th><th scope=\"col\">Turned by</th><th scope=\"col\">Standard "
      "deviation</th><th "
      "scope=\"col\">RMS, px</th><th scope=\"col\">Alone, px</th><th scope=\"col\">From its neighbour, "
      "px</th></tr></thead>"
      "<tbody>\n";
  const auto px = [](double value) {
    return std::isfinite(value) ? fmt::format("{:.3f}", value) : std::string("–");
  };
  for (std::size_t c = 0; c < rig.cameras.size(); ++c) {
    const ReportedRigCamera& camera = rig.cameras[c];
    Eigen::Vector3d place = 1e3 * camera.camera_from_rig.inverse().translation;
    for (double& x : place) x = std::abs(x) < 0.05 ? 0 : x;  // no "-0.0"
    const bool is_first = c == 0;                            // it is at the rig's origin
    html += fmt::format(
        "<tr><td>{}</td><td>{}</td><td>{:.1f}, {:.1f}, "
        "{:.1f}</td><td>{}</td><td>{:.3f}°</td><td>{}</td><td>{}</td><td>{}"
        "</td><td>{}</td></tr>\n",
        escapedMarkup(camera.name), camera.camera.modelId(), place.x(), place.y(), place.z(),
        is_first ? "–" : twoDigits(1e3 * camera.position_std_m),
        kRigDegrees * camera.camera_from_rig.rotation.log().norm(),
        is_first ? "–" : twoDigits(kRigDegrees * camera.rotation_std_rad) + "°", px(camera.rms_px),
        px(camera.alone_rms_px), px(camera.transfer_px));
  }
  return html +
         "</tbody></table></div><figcaption class=\"reading\">The last column is the error (95 %) with which "
         "a pixel of the "
         "neighbouring camera becomes a pixel of this one; an RMS far above that of the camera alone means "
         "that the "
         "cameras contradict each other.</figcaption></figure>\n";
}

std::string rigSentence(const ReportedRig& rig) {
  double worst = 0;
  for (const ReportedRigCamera& camera : rig.cameras)
    if (std::isfinite(camera.transfer_px)) worst = std::max(worst, camera.transfer_px);
  if (!(worst > 0)) return "How well the cameras agree is unknown.";
  return fmt::format(
      "In 95 of 100 cases a pixel of one camera becomes a pixel of its neighbour within {}, for points at "
      "the distance of "
      "the boards.",
      errorText(worst));
}

std::vector<PageNumber> rigNumbers(const ReportedRig& rig) {
  return {{.name = "Reprojection error",
           .value = fmt::format("{:.3f} px", rig.rms_px),
           .more = "RMS of all corners"},
          {.name = "Cross-validation",
           .value = std::isfinite(rig.holdout_rms_px) ? fmt::format("{:.3f} px", rig.holdout_rms_px)
                                                      : "impossible",
           .more = "RMS in unseen frames"},
          {.name = "Cameras", .value = std::to_string(rig.cameras.size()), .more = "in one rig"},
          {.name = "Frames", .value = std::to_string(rig.frames.size()), .more = "with a board"},
          {.name = "Links",
           .value = std::to_string(rig.num_linked),
           .more = "boards seen by two or more cameras"}};
}

}  // namespace

std::string rigPage(const nlohmann::json& evidence, const std::string& file) {
  const ReportedRig rig = readRig(evidence, file);
  PageContent page{.title = fmt::format("Rig of {} cameras", rig.cameras.size()),
                   .subject = "rig",
                   .verdict = rig.verdict,
                   .sentence = rigSentence(rig),
                   .findings = rig.findings,
                   .numbers = rigNumbers(rig),
                   .sections = rigSections(rig),
                   .created_by = rig.created_by};
  for (const Board& board : rig.boards) page.subtitle += (page.subtitle.empty() ? "" : ", ") + board.spec();
  for (const ReportedRigCamera& camera : rig.cameras) page.names.push_back(camera.name);
  page.sections.front().more = camerasTable(rig);
  page.details = listHtml(fmt::format("{} frames", rig.frames.size()), rig.frames);
  return pageText(page, evidence);
}

std::vector<FigureFile> rigFigures(const nlohmann::json& evidence, const std::string& file) {
  return figureFiles(rigSections(readRig(evidence, file)));
}

}  // namespace alidade
