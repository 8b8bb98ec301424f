// SPDX-License-Identifier: MIT
#include "alidade/report/data/evidence.h"

#include <algorithm>
#include <span>

#include "alidade/adjust/board/errors.h"
#include "alidade/core/mapped.h"
#include "alidade/record/camera_record.h"
#include "alidade/report/data/json_output.h"
#include "alidade/report/data/shape_json.h"

namespace alidade {

NLOHMANN_DEFINE_TYPE_NON_INTRUSIVE(StartReport, num_tried, num_solved, num_agreed, num_optima)
NLOHMANN_DEFINE_TYPE_NON_INTRUSIVE(TiltCounts, left, right, upper, lower)
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

void to_json(json& j, const ExcludedView& view) {
  j = {{"image", view.image}, {"reason", view.reason}};
}

void to_json(json& j, const RepeatedView& view) {
  j = {{"image", view.image}, {"same_as", view.same_as}};
}

void to_json(json& j, const Outlier& o) {
  j = {{"image", o.image}, {"corner_id", o.corner_id}, {"dx", o.error_px.x()}, {"dy", o.error_px.y()}};
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
  j = {{"grid",
        {{"columns", coverage.columns}, {"rows", coverage.rows}, {"num_corners", coverage.num_corners}}},
       {"share", coverage.share},
       {"border_share", coverage.border_share},
       {"num_image_corners", coverage.num_image_corners},
       {"empty_regions", coverage.empty_regions},
       {"num_tilted_15_degrees", coverage.num_tilted},
       {"num_tilted_30_degrees", coverage.num_steep},
       {"num_tilted_to", coverage.tilts},
       {"nearest_m", coverage.nearest_m},
       {"farthest_m", coverage.farthest_m},
       {"smallest_fill", coverage.smallest_fill},
       {"largest_fill", coverage.largest_fill},
       {"views", coverage.views}};
}

namespace {

// A document of one board is as it was before there could be several: lists of several boards stand where one
// board has a value, and what belongs to a view names its board.

bool hasSeveralBoards(const Calibration& result) {
  return result.fit.boards.size() > 1;
}

json specOf(const Calibration& result, std::size_t board) {
  return result.fit.boards[board].target.spec();
}

// A list of things that belong to a view, with their boards.
template <class Items>
json withBoards(const Calibration& result, const Items& items) {
  json list = items;
  if (!hasSeveralBoards(result)) return list;
  for (std::size_t i = 0; i < items.size(); ++i) list[i]["board"] = specOf(result, items[i].board);
  return list;
}

// The outliers with the pixels where they were seen, which the fit does not keep.
json outliersJson(const Calibration& result, std::span<const View> given) {
  const std::vector<Outlier>& outliers = result.dropped.outliers;
  json list = withBoards(result, outliers);
  for (std::size_t i = 0; i < outliers.size(); ++i) {
    const std::vector<Corner>& corners = given[outliers[i].source].corners;
    const auto seen = std::ranges::find(corners, outliers[i].corner_id, &Corner::id);
    if (seen == corners.end()) continue;
    list[i]["u"] = seen->pixel.x();
    list[i]["v"] = seen->pixel.y();
  }
  return list;
}

bool isOfBoard(const CommonError& error) {
  return static_cast<int>(error.cause) < kNumBoardCauses;
}

// Errors by cause; those of several boards are listed under "boards".
json commonErrorsJson(const Calibration& result) {
  json errors = json::object();
  if (hasSeveralBoards(result))
    errors["boards"] = ofEachBoard(result.fit, [&](std::size_t board) -> json {
      return {{"board", specOf(result, board)}};
    });
  for (const CommonError& error : result.uncertainty.common_errors) {
    json& of = hasSeveralBoards(result) && isOfBoard(error) ? errors["boards"][error.board] : errors;
    of[std::string(kCommonCauses[static_cast<std::size_t>(error.cause)])] = {{"value", error.value},
                                                                             {"sigma", error.sigma}};
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
          {"reached", target.is_reached},
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
  json document = {
      {"parameters", parametersJson(names, onlyCamera(result.fit).params)},
      {"parameter_order", names},  // that of the covariances; an object has none
      {"parameter_std", byName([&](int i) { return known.parameterStd(i); })},
      {"parameter_std_by_noise", byName([&](int i) { return known.parameterStdByNoise(i); })},
      {"parameter_std_by_view", nullptr},
      {"view_excess", nullptr},
      {"covariance", nullptr},
      {"covariance_by_noise", nullptr},
      {"strongest_correlation", nullptr},
      {"projection_std", nullptr},
  };
  if (known.by_views) {
    document["parameter_std_by_view"] = byName([&](int i) { return known.by_views->effectiveStd(i); });
    document["view_excess"] = {{"variance_ratio", known.by_views->excess},
                               {"sigmas", known.by_views->excess_sigmas},
                               {"exceeded", known.isNoiseExceeded()}};
  }
  if (known.covariance) {
    document["covariance"] = lowerTriangle(known.statedCovariance());
    document["covariance_by_noise"] = lowerTriangle(*known.covariance);
  }
  if (const auto strongest = known.strongestCorrelation()) {
    document["strongest_correlation"] = {{"parameters",
                                          {names[static_cast<std::size_t>(strongest->first)],
                                           names[static_cast<std::size_t>(strongest->second)]}},
                                         {"value", strongest->value}};
  }
  if (known.projection_far) {
    document["projection_std"] = {{"infinity", *known.projection_far},
                                  {"board_distance", *known.projection_near},
                                  {"board_distance_m", known.board_distance_m}};
  }
  return document;
}

json documentOf(const Calibration& result, const GivenImages& given, std::span<const View> views,
                const Advice& advice) {
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
      {"outliers", outliersJson(result, views)},
      {"outlier_share", result.dropped.outlierShare(result.fit)},
      {"excluded_views", withBoards(result, result.dropped.views)},
      {"repeated_views", withBoards(result, result.dropped.repeated)},
      {"common_errors", commonErrorsJson(result)},
      {"variations",
       {{"focal_f", known.variations.focal_f},
        {"focal_spread", known.variations.focal_spread},
        {"rows_f", known.variations.rows_f},
        {"rows_spread", known.variations.rows_spread},
        {"focal_share", known.variations.focal_share}}},
      {"views", viewsJson(result)},
      {"notes", given.notes},
      {"coverage", advice.coverage},
      {"next_view", nextViewJson(advice.guidance, result.imageSize())},
      {"target", targetJson(advice.guidance)},
  });
  document["coverage"]["views"] = withBoards(result, advice.coverage.views);
  return document;
}

}  // namespace

Advice adviceOn(const Calibration& result, const std::vector<View>& views, std::optional<double> target_px) {
  Advice advice{.coverage = coverageOf(result, views), .guidance = {}};
  advice.guidance = guide(result, advice.coverage, target_px);
  return advice;
}

std::size_t numImagesUsed(const Calibration& result) {
  const std::vector<FitView>& views = result.fit.views;
  std::size_t count = 0;
  for (std::size_t v = 0; v < views.size(); ++v) {
    // Views of one image are neighbours.
    if (v == 0 || views[v].image != views[v - 1].image) ++count;
  }
  return count;
}

std::string summaryJson(const Calibration& result, const GivenImages& given, std::span<const View> views,
                        const Advice& advice) {
  return jsonText(documentOf(result, given, views, advice));
}

json evidenceDocument(const Calibration& result, const GivenImages& given, std::span<const View> views,
                      const Advice& advice, const EvidenceOrigin& origin) {
  json document = documentOf(result, given, views, advice);
  for (std::size_t v = 0; v < result.fit.views.size(); ++v) {
    const FitView& view = result.fit.views[v];
    json& corners = document["views"][v]["corners"] = json::array();
    for (std::size_t i = 0; i < view.corners.size(); ++i) {
      corners.push_back(cornerJson(view.corners[i].id, view.corners[i].pixel, view.errors[i]));
    }
  }
  document["settings"] = json::object();
  for (const auto& [name, values] : origin.settings) document["settings"][name] = values;
  document["tolerance_px"] = origin.tolerance_px;
  document["created_by"] = origin.created_by;
  return document;
}

}  // namespace alidade
