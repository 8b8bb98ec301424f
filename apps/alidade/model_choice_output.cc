// SPDX-License-Identifier: MIT
#include "model_choice_output.h"

#include <cmath>
#include <numbers>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

namespace alidade {
namespace {

std::string pixelsText(double px) {
  return std::isfinite(px) ? fmt::format("{:.4g}", px) : "-";
}

std::string excessText(const ModelCandidate& candidate) {
  if (!std::isfinite(candidate.excess)) return "-";
  constexpr double kManyTimes = 2;
  if (candidate.excess > kManyTimes) return fmt::format("{:.3g} times", 1 + candidate.excess);
  return fmt::format("{:+.1f} +- {:.1f} %", 100 * candidate.excess, 100 * candidate.excess_std);
}

}  // namespace

std::string modelChoiceText(const ModelChoice& choice) {
  const std::string field =
      std::isfinite(choice.field_rad)
          ? fmt::format("a field of view of {:.0f} degrees", choice.field_rad * 180 / std::numbers::pi)
          : "an image wider than the field of view of the lens";
  std::string text = fmt::format("Models   compared by cross-validation RMS, for {}\n", field);
  text += fmt::format("  {:<14} {:>10} {:>9} {:>9} {:>20}\n", "", "parameters", "RMS px", "held-out",
                      "excess over best");
  for (const ModelCandidate& c : choice.candidates) {
    text +=
        fmt::format("  {:<14} {:>10} {:>9} {:>9} {:>20}  {}\n", c.id, c.num_params, pixelsText(c.rms_px),
                    pixelsText(c.holdout_rms_px), excessText(c), c.verdict == "chosen" ? "chosen" : c.reason);
  }
  return text;
}

nlohmann::json modelChoiceJson(const ModelChoice& choice) {
  using nlohmann::json;
  const auto orNull = [](double value) { return std::isfinite(value) ? json(value) : json(nullptr); };
  json candidates = json::array();
  for (const ModelCandidate& c : choice.candidates) {
    candidates.push_back({{"model", c.id},
                          {"num_parameters", c.num_params},
                          {"rms_px", orNull(c.rms_px)},
                          {"holdout_rms_px", orNull(c.holdout_rms_px)},
                          {"excess", orNull(c.excess)},
                          {"excess_std", orNull(c.excess_std)},
                          {"verdict", c.verdict},
                          {"reason", c.reason}});
  }
  return {{"candidates", candidates},
          {"best", choice.best.empty() ? json(nullptr) : json(choice.best)},
          {"reference", choice.reference},
          {"field_rad", orNull(choice.field_rad)},
          {"fisheye_models_considered", choice.is_wide}};
}

}  // namespace alidade
