// SPDX-License-Identifier: MIT
#include "alidade/report/pages/rig_validation_page.h"

#include <cmath>
#include <vector>

#include <fmt/format.h>

#include "alidade/core/degrees.h"
#include "alidade/core/mapped.h"
#include "alidade/report/canvas/page_table.h"
#include "alidade/report/pages/page_shell.h"

namespace alidade {
namespace {

std::string camerasTable(const RigValidation& tested) {
  constexpr double kMmPerM = 1000;
  std::vector<PageRow> rows;
  for (const TestedRigCamera& camera : tested.cameras) {
    const bool is_first = rows.empty();  // its pose defines the frame
    const auto moved = [&](double value) { return is_first ? std::string("–") : shortNumber(value); };
    const SE3& change = camera.freed_from_stated;
    rows.push_back(
        {{camera.name, shortNumber(camera.rms_px), shortNumber(camera.freed_rms_px),
          moved(kMmPerM * change.translation.norm()), moved(kDegPerRad * change.rotation.log().norm()),
          moved(camera.effect_px), moved(camera.sigmas)}});
  }
  return tableFigure(
      "tested-cameras", "Cameras",
      {{"Camera"},
       {"RMS, px"},
       {"With poses freed, px"},
       {"Moves by, mm"},
       {"Turns by, degrees"},
       {"Effect, px"},
       {"Sigmas"}},
      rows,
      "The images are fitted with the poses as the file states them, and with the poses freed. "
      "The effect is the displacement of the boards' points (95 %) between the two.");
}

std::vector<PageNumber> numbersOf(const RigValidation& tested) {
  std::vector<PageNumber> numbers;
  if (std::isfinite(tested.epipolar_px))
    numbers.push_back({"Epipolar error", rmsText(tested.epipolar_px), "RMS of all common corners"});
  numbers.push_back({"Reprojection error", rmsText(tested.rms_px), "RMS with the poses as stated"});
  numbers.push_back({"With poses freed", rmsText(tested.freed_rms_px), "RMS"});
  if (std::isfinite(tested.length_ratio)) {
    numbers.push_back(
        {"Lengths", fmt::format("{:+.3f} %", 100 * (tested.length_ratio - 1)),
         fmt::format("of the boards; standard deviation {:.3f} %", 100 * tested.length_ratio_std)});
  }
  numbers.push_back({"Common points", std::to_string(tested.num_points), "seen by two or more cameras"});
  numbers.push_back({"Tolerance", errorText(tested.tolerance_px), "effect of a difference (95 %)"});
  return numbers;
}

}  // namespace

std::string rigHeadline(Verdict verdict) {
  return verdict == Verdict::kTrustworthy    ? "The images confirm the rig"
         : verdict == Verdict::kReservations ? "The images confirm the rig with reservations"
                                             : "The images contradict the rig";
}

std::string rigValidationPage(const std::string& file, const RigValidation& tested, const RunOrigin& origin,
                              const nlohmann::json& document) {
  const std::vector<std::string> names = mapped(tested.cameras, &TestedRigCamera::name);
  PageContent page{.kind = "Rig validation",
                   .title = file,
                   .origin = origin,
                   .headline = rigHeadline(tested.verdict()),
                   .verdict = tested.verdict(),
                   .sentence = tested.verdict() == Verdict::kNo ? "" : mainFindingText(tested.diagnoses),
                   .findings = asSentences(tested.diagnoses, names),
                   .numbers = numbersOf(tested)};
  for (const std::string& name : names) page.subtitle += (page.subtitle.empty() ? "" : ", ") + name;
  page.sections = {{.id = "cameras", .title = "Cameras", .figures = {}, .more = camerasTable(tested)}};
  return pageText(page, document);
}

}  // namespace alidade
