// SPDX-License-Identifier: MIT
#include "alidade/calibrate/ambiguity_finding.h"

#include <cmath>
#include <span>
#include <string>

#include "alidade/calibrate/number_text.h"

namespace alidade {
namespace {

std::string cameraText(const CalibrationResult& result, std::span<const double> params, double rms_px) {
  std::string text = "fx " + numberText("%.4g", params[0]) + " px";
  const auto names = result.camera.parameterNames();
  for (std::size_t i = 4; i < params.size(); ++i)
    text += ", " + std::string(names[i]) + " " + numberText("%.3g", params[i]);
  return text + " (RMS " + numberText("%.5g", rms_px) + " px)";
}

}  // namespace

void judgeAmbiguity(const CalibrationResult& result, std::vector<Finding>& findings) {
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
