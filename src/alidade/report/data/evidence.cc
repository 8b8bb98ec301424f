// SPDX-License-Identifier: MIT
#include "alidade/report/data/evidence.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <span>
#include <utility>

#include "alidade/adjust/board/errors.h"
#include "alidade/camera/correction_field.h"
#include "alidade/core/mapped.h"
#include "alidade/record/camera_record.h"
#include "alidade/report/data/json_output.h"
#include "alidade/rig/rig_calibrator.h"

namespace alidade {

NLOHMANN_DEFINE_TYPE_NON_INTRUSIVE(StartReport, num_tried, num_solved, num_agreed, num_optima)
NLOHMANN_DEFINE_TYPE_NON_INTRUSIVE(ExcludedView, image, reason)
NLOHMANN_DEFINE_TYPE_NON_INTRUSIVE(RepeatedView, image, same_as)
NLOHMANN_DEFINE_TYPE_NON_INTRUSIVE(ViewInfluence, move_sigmas, surprise_sigmas)

void to_json(json& j, const ModelCandidate& c) {
  j = {{"model", c.id},        {"num_parameters", c.num_params},
       {"rms_px", c.rms_px},   {"holdout_rms_px", c.holdout_rms_px},
       {"excess", c.excess},   {"excess_std", c.excess_std},
       {"verdict", c.verdict}, {"reason", c.reason}};
}

void to_json(json& j, const ModelChoice& choice) {
  j = {{"candidates", choice.candidates},
       {"best", choice.best.empty() ? json(nullptr) : json(choice.best)},
       {"reference", choice.reference},
       {"field_rad", choice.field_rad},
       {"fisheye_models_considered", choice.is_wide}};
}

void to_json(json& j, const Outlier& o) {
  j = {{"image", o.image}, {"corner_id", o.corner_id}, {"u", o.pixel.x()},
       {"v", o.pixel.y()}, {"dx", o.error_px.x()},     {"dy", o.error_px.y()}};
}

void to_json(json& j, const BendByViews& by_views) {
  j = {{"f", by_views.f},
       {"freedom", by_views.freedom},
       {"chance", by_views.chance},
       {"bend_x_std_m", by_views.std_m.x()},
       {"bend_y_std_m", by_views.std_m.y()}};
}

void to_json(json& j, const Accuracy& accuracy) {
  j = {{"distance_m", accuracy.distance_m},
       {"covered_px", accuracy.covered_px},
       {"covered_share", accuracy.covered_share},
       {"worst_px", accuracy.worst_px},
       {"worst_pixel", vectorJson(accuracy.worst_pixel)},
       {"deviation_px", accuracy.deviation_px},
       {"columns", accuracy.columns},
       {"rows", accuracy.rows},
       {"error_px", accuracy.error_px},
       {"is_covered", accuracy.is_covered}};
}

void to_json(json& j, const UncertaintyGrid& grid) {
  j = {{"columns", grid.columns},
       {"rows", grid.rows},
       {"center_px", grid.center_px},
       {"worst_px", grid.worst_px},
       {"worst_pixel", vectorJson(grid.worst_pixel)},
       {"std_px", rowsJson(grid.columns, grid.rows, [&](std::size_t i) { return grid.std_px[i]; })}};
}

void to_json(json& j, const BoardTilt& tilt) {
  j = {{"right_nearer_rad", tilt.right_rad}, {"lower_nearer_rad", tilt.lower_rad}};
}

void to_json(json& j, const ImageRegion& region) {
  j = regionName(region);
}

void to_json(json& j, const ViewCoverage& view) {
  const BoardSighting& at = view.sighting;
  j = {{"image", view.image},
       {"middle_px", {{"u", at.middle_px.x()}, {"v", at.middle_px.y()}}},
       {"distance_m", at.distance_m},
       {"tilt", at.tilt},
       {"fill", view.fill}};
}

void to_json(json& j, const CoverageReport& coverage) {
  const std::vector<double> fills = mapped(coverage.views, &ViewCoverage::fill);
  j = {{"grid",
        {{"columns", coverage.columns}, {"rows", coverage.rows}, {"num_corners", coverage.num_corners}}},
       {"share", coverage.share},
       {"border_share", coverage.border_share},
       {"num_image_corners", coverage.num_image_corners},
       {"empty_regions", coverage.empty_regions},
       {"num_tilted_15_degrees", coverage.numTilted(kTiltedRad)},
       {"num_tilted_30_degrees", coverage.numTilted(kSteepRad)},
       {"num_tilted_to", json::object()},
       {"nearest_m", coverage.nearest_m},
       {"farthest_m", coverage.farthest_m},
       {"smallest_fill", fills.empty() ? 0 : std::ranges::min(fills)},
       {"largest_fill", fills.empty() ? 0 : std::ranges::max(fills)},
       {"views", coverage.views}};
  for (std::size_t side = 0; side < kSideNames.size(); ++side)
    j["num_tilted_to"][kSideNames[side]] = coverage.num_tilted_to[side];
}

namespace {

// A single value for the only board of a fit, or a list with one value per board.
template <class ValueOf>
json ofEachBoard(const Fit& fit, const ValueOf& valueOf) {
  if (fit.boards.size() == 1) return valueOf(std::size_t{0});
  json list = json::array();
  for (std::size_t board = 0; board < fit.boards.size(); ++board) list.push_back(valueOf(board));
  return list;
}

// The bend of a board (m), 0 if it is not estimated, and for an uneven board the offsets of its points, m, in
// the board's frame. If there are several boards, each has its SPEC and the number of its views.
json fittedShapeJson(const Fit& fit, std::size_t board) {
  const FitBoard& of_board = fit.boards[board];
  const bool is_estimated = !of_board.is_shape_fixed;
  const BoardShape bend = is_estimated ? of_board.shape : BoardShape{};
  json document = {{"estimated", is_estimated},
                   {"bend_x_m", bend.bend_x_m},
                   {"bend_y_m", bend.bend_y_m},
                   {"uneven", of_board.isUneven()}};
  if (of_board.isUneven()) {
    const Eigen::Vector2d rms_m = offsetRms(of_board.shape);
    document["offsets_m"] =
        mapped(of_board.shape.offsets_m, [](const Eigen::Vector3d& offset) { return vectorJson(offset); });
    document["offset_rms_in_plane_m"] = rms_m.x();
    document["offset_rms_across_m"] = rms_m.y();
  }
  if (of_board.isFlexible()) document["flex_std_m"] = of_board.flex.std_m;
  if (fit.boards.size() > 1) {
    document["board"] = of_board.target.spec();
    document["num_views"] = numViews(fit, board);
  }
  return document;
}

json cornersJson(const FitCamera& camera, const FitView& view) {
  json corners = json::array();
  for (std::size_t i = 0; i < view.corners.size(); ++i)
    corners.push_back(CornerError{.id = view.corners[i].id,
                                  .pixel = seenPixel(camera, view.corners[i].pixel),
                                  .error_px = view.errors[i]});
  return corners;
}

// Documents of one board keep their original form: with several boards, lists replace single values, and
// entries that belong to a view name its board.

bool hasSeveralBoards(const Calibration& result) {
  return result.fit.boards.size() > 1;
}

json specOf(const Calibration& result, std::size_t board) {
  return result.fit.boards[board].target.spec();
}

// A list of items that belong to a view, with their boards.
template <class Items>
json withBoards(const Calibration& result, const Items& items) {
  json list = items;
  if (!hasSeveralBoards(result)) return list;
  for (std::size_t i = 0; i < items.size(); ++i) list[i]["board"] = specOf(result, items[i].board);
  return list;
}

bool isOfBoard(const CommonError& error) {
  return static_cast<int>(error.cause) < kNumBoardCauses;
}

// Errors by cause; with several boards, listed under "boards".
json commonErrorsJson(const Calibration& result) {
  json errors = json::object();
  if (hasSeveralBoards(result))
    errors["boards"] = ofEachBoard(result.fit, [&](std::size_t board) -> json {
      return {{"board", specOf(result, board)}};
    });
  for (const CommonError& error : result.uncertainty.common_errors) {
    json& of = hasSeveralBoards(result) && isOfBoard(error) ? errors["boards"][error.board] : errors;
    const json estimate = {{"value", error.value}, {"sigma", error.sigma}};
    if (error.cause == CommonCause::kHeld) {
      const auto names = parameterNames(onlyCamera(result.fit).model);
      of["held"][std::string(names[static_cast<std::size_t>(error.parameter)])] = estimate;
    } else if (error.cause == CommonCause::kHeldFocal) {
      of["held"]["focal_share"] = estimate;
    } else {
      of[std::string(kCommonCauses[static_cast<std::size_t>(error.cause)])] = estimate;
    }
  }
  return errors;
}

json weakPriorJson(const FitCamera& camera) {
  const WeakPrior& held = camera.weak_prior;
  if (held.isNone()) return nullptr;
  const json least_known = mapped(
      held.least_known, [&](int i) { return parameterNames(camera.model)[static_cast<std::size_t>(i)]; });
  return {{"width", held.width}, {"least_known", least_known}, {"free_parameters", held.free_params}};
}

json boardShapeJson(const Calibration& result, std::size_t board) {
  const ShapeReport& shape = result.choice.shapes[board];
  const Eigen::Vector2d& std_m = result.uncertainty.bend_std_m[board];
  json document = fittedShapeJson(result.fit, board);
  document.update({{"determined", shape.is_determined},
                   {"f", shape.f},
                   {"by_views", orNull(shape.by_views)},
                   {"bend_x_std_m", std_m.x()},
                   {"bend_y_std_m", std_m.y()},
                   {"flat_rms_px", shape.flat_rms_px},
                   {"flat_parameters", shape.flat_params}});
  if (const auto& even = result.choice.even_excess) {
    document["even_excess"] = even->share;
    document["even_excess_std"] = even->std;
  }
  return document;
}

json viewsJson(const Calibration& result) {
  const std::vector<ViewSummary> summaries = viewSummaries(result);
  const std::vector<ViewInfluence>& influences = result.uncertainty.influences;
  json views = json::array();
  for (std::size_t v = 0; v < summaries.size(); ++v) {
    const ViewSummary& view = summaries[v];
    views.push_back({{"image", view.image},
                     {"num_corners", view.num_corners},
                     {"num_outliers", view.num_outliers},
                     {"rms_px", view.rms_px},
                     {"max_error_px", view.max_error_px},
                     {"camera_from_board", cameraFromBoard(result.fit, result.fit.views[v])},
                     {"influence", influences.empty() ? ViewInfluence{} : influences[v]}});
    if (hasSeveralBoards(result)) views.back()["board"] = specOf(result, view.board);
  }
  return views;
}

// Metres; null if it does not move.
json pupilJson(const EntrancePupil& pupil, const std::vector<double>& std_m) {
  if (pupil.isFixed() && std_m.empty()) return nullptr;
  return {{"s1", pupil.s1_m}, {"s2", pupil.s2_m}, {"std", std_m}};
}

// Pixels; null if there is none.
json correctionJson(const AnyCamera& camera) {
  if (camera.correction() == nullptr) return nullptr;
  const CorrectionGrid& grid = camera.correction()->grid();
  return {{"columns", grid.columns},
          {"rows", grid.rows},
          {"origin", vectorJson(grid.origin_px)},
          {"cell", vectorJson(grid.cell_px)},
          {"bounded", grid.is_bounded},
          {"coefficients", camera.correction()->points()}};
}

json correctionChoiceJson(const std::optional<CorrectionReport>& found) {
  if (!found) return nullptr;
  return {{"rms_px", found->rms_px},
          {"worst_px", found->worst_px},
          {"holdout_excess_without", found->excess ? json(found->excess->share) : json(nullptr)}};
}

json otherOptimaJson(const Calibration& result) {
  json other_optima = json::array();
  for (const OtherOptimum& other : result.uncertainty.other_optima) {
    other_optima.push_back(
        {{"parameters", parametersJson(parameterNames(onlyCamera(result.fit).model), other.params)},
         {"rms_px", other.rms_px},
         {"excess_chi2", other.excess_chi2},
         {"sigmas", other.sigmas},
         {"projection_px", other.projection_px}});
  }
  return other_optima;
}

json nextViewJson(const Guidance& guidance, ImageSize size) {
  if (!guidance.next) return nullptr;
  const NextView& next = *guidance.next;
  const Eigen::Vector2d& middle = next.sighting.middle_px;
  json view = {{"determined", guidance.is_determined},
               {"worst_now_px", guidance.worst_px},
               {"worst_then_px", guidance.is_determined ? json(next.worst_px) : json(nullptr)},
               {"middle_px", {{"u", middle.x()}, {"v", middle.y()}}},
               {"distance_m", next.sighting.distance_m},
               {"fill", next.fill},
               {"whole_board", next.is_whole},
               {"tilt", next.sighting.tilt},
               {"camera_from_board", next.camera_from_board},
               {"text", shortNextViewText(guidance, size)}};
  if (guidance.is_chosen) view["board"] = guidance.board.spec();
  return view;
}

json targetJson(const Guidance& guidance) {
  if (!guidance.target) return nullptr;
  const TargetReport& target = *guidance.target;
  return {{"target_px", target.target_px},
          {"worst_px", guidance.worst_px},
          {"reached", target.isReached()},
          {"num_more_views", orNull(target.num_more_views)},
          {"forecast_px", target.forecast_px}};
}

// Parameters, standard deviations, covariances and projection uncertainty.
json uncertaintyJson(const Calibration& result) {
  const Uncertainty& known = result.uncertainty;
  const auto names = parameterNames(onlyCamera(result.fit).model);
  const auto byName = [&](const auto& valueOf) {
    std::vector<double> values;
    for (std::size_t i = 0; i < names.size(); ++i) values.push_back(valueOf(static_cast<int>(i)));
    return parametersJson(names, values);
  };
  const auto strongest = known.strongestCorrelation();
  return {
      {"parameters", parametersJson(names, onlyCamera(result.fit).params)},
      {"parameter_order", names},  // order of the covariances, because JSON objects are unordered
      {"parameter_std", byName([&](int i) { return known.parameterStd(i); })},
      {"parameter_std_by_noise", byName([&](int i) { return known.parameterStdByNoise(i); })},
      {"parameter_std_by_view",
       known.by_views ? byName([&](int i) { return known.by_views->effectiveStd(i); }) : json()},
      {"view_excess", known.by_views ? json{{"variance_ratio", known.by_views->excess},
                                            {"sigmas", known.by_views->excess_sigmas},
                                            {"serial_factor", known.by_views->serial_factor},
                                            {"exceeded", known.isNoiseExceeded()}}
                                     : json()},
      {"covariance", known.covariance ? json(lowerTriangle(known.statedCovariance())) : json()},
      {"covariance_by_noise", known.covariance ? json(lowerTriangle(*known.covariance)) : json()},
      {"strongest_correlation", strongest ? json{{"parameters",
                                                  {names[static_cast<std::size_t>(strongest->first)],
                                                   names[static_cast<std::size_t>(strongest->second)]}},
                                                 {"value", strongest->value}}
                                          : json()},
      {"projection_std", known.projection_far ? json{{"infinity", *known.projection_far},
                                                     {"board_distance", *known.projection_near},
                                                     {"board_distance_m", known.board_distance_m}}
                                              : json()},
  };
}

json documentOf(const Calibration& result, const GivenImages& given, const Guidance& guidance) {
  const Uncertainty& known = result.uncertainty;
  const SolveSummary& solver = result.fit.summary;
  json document = uncertaintyJson(result);
  document.update({
      {"model", onlyCamera(result.fit).model},
      {"image_size", result.imageSize()},
      {"board", ofEachBoard(result.fit, [&](std::size_t board) { return specOf(result, board); })},
      {"images",
       {{"given", given.num_images},
        {"found", given.num_found},
        {"used", numImagesUsed(result)},
        {"reasons", given.reasons}}},
      {"rms_px", rms(result.fit)},
      {"holdout_rms_px", known.holdout.rms_px},
      {"holdout",
       {{"num_folds", known.holdout.num_folds},
        {"num_corners", known.holdout.num_corners},
        {"num_unseen", known.holdout.num_unseen}}},
      {"image_bias", {{"z", known.image_bias.z}, {"rms_px", known.image_bias.rms_px}}},
      {"model_choice", orNull(result.choice.model)},
      {"num_corners", numCorners(result.fit)},
      {"coordinate_sigma_px", known.coordinate_sigma_px},
      {"local_sigma_px", known.local_sigma_px},
      {"weighted_rms_px", weightedRms(result.fit)},
      {"unexplained_sigma_px", known.unexplained_sigma_px},
      {"domain",
       {{"max_angle_rad", result.domain.cone.max_angle_rad},
        {"full_image", result.domain.full_image},
        {"min_relative_det", result.domain.min_relative_det}}},
      {"board_shape",
       ofEachBoard(result.fit, [&](std::size_t board) { return boardShapeJson(result, board); })},
      {"entrance_pupil", pupilJson(result.camera().pupil(), known.pupil_std_m)},
      {"correction", correctionJson(result.camera())},
      {"correction_choice", correctionChoiceJson(result.choice.correction)},
      {"weak_prior", weakPriorJson(onlyCamera(result.fit))},
      {"start", result.choice.start},
      {"other_optima", otherOptimaJson(result)},
      {"solver",
       {{"termination", terminationName(solver.termination)},
        {"reason", solver.reason},
        {"num_iterations", solver.num_iterations}}},
      {"accuracy", orNull(known.accuracy)},
      {"verdict", verdictName(result.verdict())},
      {"findings", result.diagnoses},
      {"outliers", withBoards(result, result.dropped.outliers)},
      {"outlier_share", result.dropped.outlierShare(result.fit)},
      {"excluded_views", withBoards(result, result.dropped.views)},
      {"repeated_views", withBoards(result, result.dropped.repeated)},
      {"common_errors", commonErrorsJson(result)},
      {"variations",
       {{"focal_f", known.variations.focal_f},
        {"focal_spread", known.variations.focal_spread},
        {"rows_f", known.variations.rows_f},
        {"rows_spread", known.variations.rows_spread},
        {"focal_share", known.variations.focal_share},
        {"focal_step", known.focal_step
                           ? json{{"image", result.fit.views[known.focal_step->first_view].image},
                                  {"share", known.focal_step->share},
                                  {"sigmas", known.focal_step->sigmas}}
                           : json()}}},
      {"views", viewsJson(result)},
      {"notes", given.notes},
      {"coverage", guidance.coverage},
      {"next_view", nextViewJson(guidance, result.imageSize())},
      {"target", targetJson(guidance)},
  });
  document["coverage"]["views"] = withBoards(result, guidance.coverage.views);
  return document;
}

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
    cameras.push_back(
        {{"name", camera.name},
         {"model", fitted.model},
         {"image_size", fitted.size},
         {"parameters", parametersJson(parameterNames(fitted.model), fitted.params)},
         {"entrance_pupil", pupilJson(cameraOf(fitted).pupil(), camera.calibration.uncertainty.pupil_std_m)},
         {"correction", correctionJson(cameraOf(fitted))},
         {"camera_from_rig", fitted.camera_from_rig},
         {"translation_std_m", vectorJson(camera.link.translation_std_m)},
         {"rotation_std_rad", vectorJson(camera.link.rotation_std_rad)},
         {"position_std_m", vectorJson(camera.link.position_std_m)},
         {"distance_std_m", camera.link.distance_std_m},
         {"rms_px", camera.rms_px},
         {"alone_rms_px", camera.alone_rms_px},
         {"transfer_px", camera.link.transfer_px}});
    if (rig.frames.areShifted()) cameras.back()["lead"] = rig.frames.leads[c];
    if (!rig.exposure) continue;
    cameras.back()["delay_intervals"] = fitted.delay;
    cameras.back()["delay_std_intervals"] = camera.link.delay_std_intervals;
  }
  json motions = json::array();
  for (const CameraMotion& motion : rig.motions) {
    motions.push_back({{"camera", rig.cameras[motion.camera].name},
                       {"from_frame", motion.from_frame},
                       {"after_from_before", motion.after_from_before},
                       {"effect_px", motion.effect_px},
                       {"num_views_after", motion.num_after}});
  }
  json document = {{"verdict", verdictName(rig.verdict())},
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
  if (rig.exposure) {
    document["exposure"] = {{"interval_s", rig.frames.interval_s},
                            {"std_intervals", rig.exposure->std_intervals},
                            {"shift_m", rig.exposure->shift_m},
                            {"shift_px", rig.exposure->shift_px}};
  }
  return document;
}

}  // namespace

std::size_t numImagesUsed(const Calibration& result) {
  const std::vector<FitView>& views = result.fit.views;
  std::size_t count = 0;
  for (std::size_t v = 0; v < views.size(); ++v) {
    // Views of the same image are adjacent.
    if (v == 0 || views[v].image != views[v - 1].image) ++count;
  }
  return count;
}

std::string summaryJson(const Calibration& result, const GivenImages& given, const Guidance& guidance) {
  return jsonText(documentOf(result, given, guidance));
}

json evidenceDocument(const Calibration& result, const GivenImages& given, const Guidance& guidance,
                      const EvidenceOrigin& origin) {
  json document = documentOf(result, given, guidance);
  for (std::size_t v = 0; v < result.fit.views.size(); ++v)
    document["views"][v]["corners"] = cornersJson(onlyCamera(result.fit), result.fit.views[v]);
  document["settings"] = json::object();
  for (const auto& [name, values] : origin.settings) document["settings"][name] = values;
  document["tolerance_px"] = origin.tolerance_px;
  return withOrigin(std::move(document), origin.run);
}

std::string rigSummaryJson(const RigCalibration& rig) {
  return jsonText(documentOfRig(rig));
}

json rigEvidenceDocument(const RigCalibration& rig, double tolerance_px, const RunOrigin& origin) {
  json document = documentOfRig(rig);
  document["kind"] = "rig";
  document["tolerance_px"] = tolerance_px;
  for (std::size_t c = 0; c < rig.cameras.size(); ++c)
    document["cameras"][c]["accuracy"] = orNull(rig.cameras[c].calibration.uncertainty.accuracy);
  document["frames"] = rig.frames.names;
  json& boards = document["boards"] = json::array();
  for (const FitBoard& board : rig.fit.boards) boards.push_back(board.target.spec());
  json& placements = document["placements"] = json::array();
  std::map<std::pair<std::size_t, std::size_t>, std::size_t> placement_of;  // each board of a body
  json& views = document["views"] = json::array();
  for (const FitView& view : rig.fit.views) {
    double sum = 0;
    for (const Eigen::Vector2d& error : view.errors) sum += error.squaredNorm();
    const auto count = static_cast<double>(std::max<std::size_t>(1, view.corners.size()));
    const auto [placement, is_new] =
        placement_of.try_emplace({view.placement, view.board}, placements.size());
    if (is_new)
      placements.push_back({{"frame", rig.fit.placements[view.placement].frame},
                            {"board", view.board},
                            {"rig_from_board", rigFromBoard(rig.fit, view)}});
    views.push_back({{"camera", view.camera},
                     {"placement", placement->second},
                     {"image", view.image},
                     {"rms_px", std::sqrt(sum / count)},
                     {"corners", cornersJson(rig.fit.cameras[view.camera], view)}});
  }
  return withOrigin(std::move(document), origin);
}

}  // namespace alidade
