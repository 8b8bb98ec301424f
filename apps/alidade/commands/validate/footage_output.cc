// SPDX-License-Identifier: MIT
// The result of the check of a camera on footage, as text and as JSON.
#include <fmt/format.h>

#include "alidade/core/number_text.h"
#include "alidade/core/size_groups.h"
#include "alidade/report/data/json_output.h"
#include "commands/validate/validation_output.h"

namespace alidade {
namespace {

json changeJson(const CameraChange& change) {
  return {{"id", changeId(change.kind)},
          {"text", describe(change)},
          {"amounts", change.amounts},
          {"std", change.std},
          {"parameters", parametersJson(change.camera.parameterNames(), change.camera.parameters())},
          {"cost_drop", change.cost_drop},
          {"score", change.score},
          {"effect_px", change.effect_px},
          {"sure_px", change.sure_px},
          {"blind_px", change.blind_px}};
}

json cellsJson(const FootageCheck& check) {
  json cells = json::array();
  for (const FootageCell& cell : check.cells) {
    cells.push_back({{"num_pixels", cell.num_pixels},
                     {"rms_px", cell.num_pixels > 0 ? json(cell.rms_px) : json(nullptr)},
                     {"dx", cell.num_pixels > 0 ? json(cell.mean_px.x()) : json(nullptr)},
                     {"dy", cell.num_pixels > 0 ? json(cell.mean_px.y()) : json(nullptr)}});
  }
  return cells;
}

json checkJson(const FootageCheck& check) {
  json changes = json::array();
  for (const CameraChange& change : check.changes) changes.push_back(changeJson(change));
  const bool is_tested = check.num_windows > 0;
  const auto orNone = [&](double value) { return is_tested ? json(value) : json(nullptr); };
  return {{"verdict", verdictId(check.verdict)},
          {"gap", check.gap == FootageGap::kNone ? json(nullptr) : json(gapId(check.gap))},
          {"explanation",
           check.explanation ? json(changeId(check.changes.at(*check.explanation).kind)) : json(nullptr)},
          {"changes", std::move(changes)},
          {"blind_px", check.changes.empty() ? json(nullptr) : json(check.blind_px)},
          {"num_frames", check.num_frames},
          {"num_windows", check.num_windows},
          {"num_points", check.num_points},
          {"num_pixels", check.num_pixels},
          {"parallax_px", check.parallax_px},
          {"noise_px", orNone(check.noise_px)},
          {"holdout_rms_px", orNone(check.holdout_rms_px)},
          {"readout_frames", check.is_video && is_tested ? json(check.readout) : json(nullptr)},
          {"cell_columns", FootageCheck::kColumns},
          {"cell_rows", FootageCheck::kRows},
          {"cells", cellsJson(check)}};
}

std::string changeLines(const FootageCheck& check) {
  std::string text;
  for (std::size_t i = 0; i < check.changes.size(); ++i) {
    const CameraChange& change = check.changes[i];
    text += fmt::format(
        "      {:<15}  {}; displaces points by {:.1f} px, surely by {:.1f} px; squared errors {:.0f} % "
        "less{}\n",
        changeId(change.kind), describe(change), change.effect_px, change.sure_px,
        std::max(0.0, 100 * change.cost_drop), check.explanation == i ? "; best explanation" : "");
  }
  return text;
}

std::string checkLines(const FootageJudgement& judgement, const FootageCheck& check) {
  std::string text =
      fmt::format("      {} of {} frames in {}, {} points, {} pixels; parallax {:.0f} px\n", check.num_frames,
                  judgement.num_frames_given, counted(check.num_windows, "window"), check.num_points,
                  check.num_pixels, check.parallax_px);
  if (check.num_windows > 0)
    text += fmt::format("      held-out error {:.2f} px RMS, noise {:.2f} px\n", check.holdout_rms_px,
                        check.noise_px);
  return text + changeLines(check);
}

}  // namespace

std::string footageLines(const FootageJudgement& judgement) {
  if (judgement.edits.empty()) return checkLines(judgement, judgement.check);
  std::string text;
  for (const FootageEdit& edit : judgement.edits) {
    text += fmt::format("    {}: {}\n", editFlags(edit.request), verdictId(edit.check.verdict));
    text += checkLines(judgement, edit.check);
  }
  return text;
}

nlohmann::json footageJson(const FootageJudgement& judgement) {
  json edits = json::array();
  for (const FootageEdit& edit : judgement.edits) {
    json crop = nullptr;
    if (const auto& part = edit.request.crop)
      crop = {{"x", part->x}, {"y", part->y}, {"width", part->width}, {"height", part->height}};
    std::string id = editWords(edit.request);
    std::ranges::replace(id, ' ', '_');
    edits.push_back({{"id", std::move(id)},
                     {"crop", std::move(crop)},
                     {"resize", orNull(edit.request.resize)},
                     {"rotate_deg", edit.request.rotate_deg ? json(*edit.request.rotate_deg) : json(nullptr)},
                     {"flags", editFlags(edit.request)},
                     {"check", checkJson(edit.check)}});
  }
  return {{"verdict", verdictId(judgement.verdict())},
          {"image_size", judgement.image_size},
          {"num_frames_given", judgement.num_frames_given},
          {"tolerance_px", judgement.check.tolerance_px},
          {"check", judgement.isOtherSize() ? json(nullptr) : checkJson(judgement.check)},
          {"edits", std::move(edits)}};
}

}  // namespace alidade
