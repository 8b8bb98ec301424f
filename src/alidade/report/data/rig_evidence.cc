// SPDX-License-Identifier: MIT
#include "alidade/report/data/rig_evidence.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "alidade/adjust/board/errors.h"
#include "alidade/report/data/json_output.h"
#include "alidade/report/data/shape_json.h"
#include "alidade/rig/rig_calibrator.h"

namespace alidade {
namespace {

json imagesJson(const RigCalibration& rig, const std::vector<RigImage>& images) {
  json list = json::array();
  for (const RigImage& image : images) {
    list.push_back(
        {{"camera", rig.cameras[image.camera].name}, {"image", image.image}, {"frame", image.frame}});
  }
  return list;
}

// The frames are those in which two or more cameras saw a board, as in the rig file.
json documentOfRig(const RigCalibration& rig) {
  json cameras = json::array();
  for (std::size_t c = 0; c < rig.cameras.size(); ++c) {
    const RigCamera& camera = rig.cameras[c];
    const FitCamera& fitted = rig.fit.cameras[c];
    cameras.push_back({{"name", camera.name},
                       {"model", fitted.model},
                       {"image_size", fitted.size},
                       {"parameters", parametersJson(parameterNames(fitted.model), fitted.params)},
                       {"camera_from_rig", fitted.camera_from_rig},
                       {"translation_std_m", vectorJson(camera.link.translation_std_m)},
                       {"rotation_std_rad", vectorJson(camera.link.rotation_std_rad)},
                       {"position_std_m", vectorJson(camera.link.position_std_m)},
                       {"distance_std_m", camera.link.distance_std_m},
                       {"rms_px", camera.rms_px},
                       {"alone_rms_px", camera.alone_rms_px},
                       {"transfer_px", camera.link.transfer_px}});
  }
  json motions = json::array();
  for (const CameraMotion& motion : rig.motions) {
    motions.push_back({{"camera", rig.cameras[motion.camera].name},
                       {"from_frame", motion.from_frame},
                       {"after_from_before", motion.after_from_before},
                       {"effect_px", motion.effect_px},
                       {"num_views_after", motion.num_after}});
  }
  return {{"verdict", verdictName(rig.verdict())},
          {"rms_px", rms(rig.fit)},
          {"num_frames", numLinkedFrames(rig)},
          {"num_linked", rig.links.num_linked},
          {"num_renumbered", rig.links.num_renumbered},
          {"holdout_rms_px", rig.holdout.rms_px},
          {"time_spread", rig.frames.time_spread},
          {"unlinked", imagesJson(rig, rig.links.unlinked)},
          {"unmatched", imagesJson(rig, rig.frames.unmatched)},
          {"motions", std::move(motions)},
          {"cameras", std::move(cameras)},
          {"board_shape",
           ofEachBoard(rig.fit, [&](std::size_t board) { return fittedShapeJson(rig.fit, board); })},
          {"diagnoses", rig.diagnoses}};
}

}  // namespace

std::string rigSummaryJson(const RigCalibration& rig) {
  return jsonText(documentOfRig(rig));
}

json rigEvidenceDocument(const RigCalibration& rig, double tolerance_px, const std::string& created_by) {
  json document = documentOfRig(rig);
  document["kind"] = "rig";
  document["tolerance_px"] = tolerance_px;
  document["created_by"] = created_by;
  document["frames"] = rig.frames.names;
  json& boards = document["boards"] = json::array();
  for (const FitBoard& board : rig.fit.boards) boards.push_back(board.target.spec());
  json& placements = document["placements"] = json::array();
  for (const FitPlacement& placement : rig.fit.placements) {
    placements.push_back({{"frame", placement.frame},
                          {"board", placement.board},
                          {"rig_from_board", placement.rig_from_board}});
  }
  json& views = document["views"] = json::array();
  for (const FitView& view : rig.fit.views) {
    json corners = json::array();
    double sum = 0;
    for (std::size_t i = 0; i < view.corners.size(); ++i) {
      sum += view.errors[i].squaredNorm();
      corners.push_back(cornerJson(view.corners[i].id, view.corners[i].pixel, view.errors[i]));
    }
    const auto count = static_cast<double>(std::max<std::size_t>(1, view.corners.size()));
    views.push_back({{"camera", view.camera},
                     {"placement", view.placement},
                     {"image", view.image},
                     {"rms_px", std::sqrt(sum / count)},
                     {"corners", std::move(corners)}});
  }
  return document;
}

}  // namespace alidade
