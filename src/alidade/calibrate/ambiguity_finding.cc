// SPDX-License-Identifier: MIT
#include "alidade/calibrate/ambiguity_finding.h"

#include <cmath>
#include <span>
#include <string>

#include "alidade/core/number_text.h"

namespace alidade {
namespace {

std::string cameraText(const CalibrationResult& result, std::span<const double> params, double rms_px) {
  std::string text = "fx " + numberText("%.4g", params[0]) + " px";
  const auto names = result.camera.parameterNames();
  for (std::size_t i = 4; i < params.size(); ++i)
    text += ", " + std::string(names[i]) + " " + numberText("%.3g", params[i]);
  return text + " (RMS " + numberText("%.5g", rms_px) + " px)";
}

// As much of the image as may be uncertain before `poor_coverage` says so.
constexpr double kMuch = 0.1;

void judgeSpread(const ModelSpread& spread, const std::string& model_id, std::vector<Finding>& findings) {
  if (spread.share_apart <= kMuch) return;
  findings.push_back(
      {.severity = Finding::Severity::kWarning,
       .id = "model_dependent",
       .cause = "in parts of the image it is the choice of the model and no corner that says where points "
                "appear, and the stated sigmas know of one model alone",
       .evidence = spread.id + " predicts corners as well as " + model_id + " and differs by more than " +
                   numberText("%.0f", kApartPx) + " px in " + numberText("%.0f", 100 * spread.share_apart) +
                   " % of the image, by up to " + numberText("%.2g", spread.worst_px) + " px at pixel (" +
                   numberText("%.0f", spread.worst_pixel.x()) + ", " +
                   numberText("%.0f", spread.worst_pixel.y()) + ")",
       .next_step = "add views with the board in the image's borders and corners, or do not use these"});
}

}  // namespace

void judgeAmbiguity(const CalibrationResult& result, std::vector<Finding>& findings) {
  if (result.model_spread) judgeSpread(*result.model_spread, std::string(result.camera.modelId()), findings);
  if (result.other_optima.empty()) return;
  const OtherOptimum& other = result.other_optima.front();
  const std::string apart =
      std::isfinite(other.projection_px)
          ? "their projections differ by up to " + numberText("%.2g", other.projection_px) + " px"
          : "they have no pixel in common";
  findings.push_back(
      {.severity = Finding::Severity::kWarning,
       .id = "ambiguous_optimum",
       .cause = "two different cameras explain the corners equally well, so either may be the true one, and "
                "the stated sigmas know of one alone",
       .evidence = cameraText(result, result.camera.parameters(), result.weighted_rms_px) + " or " +
                   cameraText(result, other.params, other.rms_px) + "; " + apart +
                   "; the costs differ by a chi square of " + numberText("%.2g", other.excess_chi2),
       .next_step = "add views that reach the image's border and corners, nearer and more tilted, or use a "
                    "model with fewer parameters"});
}

}  // namespace alidade
