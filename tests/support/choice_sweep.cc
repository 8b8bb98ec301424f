// SPDX-License-Identifier: MIT
#include "support/choice_sweep.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "alidade/calibrate/uncertainty/aligned_difference.h"
#include "alidade/camera/any_camera.h"
#include "alidade/camera/image_domain.h"
#include "alidade/camera/model_list.h"
#include "alidade/camera/model_traits.h"
#include "alidade/core/error.h"

namespace alidade {
namespace {

constexpr double kNoisePx = 0.1;
constexpr double kAsGood = 0.01;  // of the held-out RMS

bool isPerspective(std::string_view model_id) {
  return modelTraits(model_id).family == LensFamily::kPerspective;
}

}  // namespace

ChoiceSet drawChoiceSet(std::string_view model_id, std::uint64_t seed, std::uint64_t number,
                        std::optional<int> num_views) {
  constexpr int kMaxDraws = 1000;
  constexpr std::uint64_t kFewestViews = 12;
  constexpr std::uint64_t kMostViews = 40;
  std::uint64_t own_seed = streamSeed(seed, number);
  for (const char c : model_id) own_seed = streamSeed(own_seed, static_cast<std::uint64_t>(c));
  Random random(own_seed);
  const double least = isPerspective(model_id) ? 60 : 110;
  const double most = isPerspective(model_id) ? 110 : model_id == Fov::kId ? 150 : 190;
  for (int i = 0; i < kMaxDraws; ++i) {
    const double fov_deg = random.uniform(least, most);
    const DrawnCamera drawn = drawCamera(model_id, fov_deg, random);
    if (foldsInsideImage(certifyDomain(drawn.camera, drawn.size))) continue;
    const auto drawn_views = static_cast<int>(kFewestViews + random.index(kMostViews - kFewestViews + 1));
    return {.drawn = drawn,
            .fov_deg = fov_deg,
            .set = drawUserViews(drawn, num_views.value_or(drawn_views), kNoisePx, random)};
  }
  expect(false, "a lens that does not fold");
  throw std::logic_error("unreachable");
}

bool isNested(std::string_view small, std::string_view large) {
  if (small == Pinhole::kId || modelTraits(large).extends(small)) return true;
  return small == Ucm::kId && (large == Eucm::kId || large == DoubleSphere::kId || large == Omni::kId);
}

std::vector<std::string> modelsTooLeanFor(std::string_view model_id) {
  if (model_id == "pinhole") return {};
  if (model_id == "radtan") return {"pinhole"};
  if (modelTraits(model_id).extends("radtan")) return {"pinhole", "radtan"};
  if (model_id == "fov") return {"ucm"};
  if (model_id == "ucm") return {"fov"};
  return {"fov", "ucm"};
}

double shareAstray(const AnyCamera& truth, std::span<const View> views, const Calibration& result) {
  constexpr double kAstrayPx = 1;
  constexpr double kSigmas = 3;
  if (!result.uncertainty.projection_far) return std::numeric_limits<double>::quiet_NaN();
  std::vector<Eigen::Vector2d> corners;
  for (const View& view : views) {
    for (const Corner& corner : view.corners) corners.push_back(corner.pixel);
  }
  const UncertaintyGrid& grid = *result.uncertainty.projection_far;
  const auto differences = alignedDifferences(result.camera(), truth, grid.pixels, corners);
  int num_seen = 0;
  int num_astray = 0;
  for (std::size_t i = 0; i < differences.size(); ++i) {
    if (!std::isfinite(grid.std_px[i])) continue;
    ++num_seen;
    if (differences[i] > kAstrayPx && differences[i] > kSigmas * grid.std_px[i]) ++num_astray;
  }
  return static_cast<double>(num_astray) / num_seen;
}

bool hasFinding(const Calibration& result, std::string_view id) {
  return std::any_of(result.diagnoses.begin(), result.diagnoses.end(),
                     [&](const Diagnosis& f) { return f.id == id; });
}

ChoiceVerdict judgeChoice(std::string_view true_model, const Calibration& result) {
  const auto& candidates = result.choice.model->candidates;
  const auto find = [&](std::string_view id) {
    return std::find_if(candidates.begin(), candidates.end(),
                        [&](const ModelCandidate& c) { return c.id == id; });
  };
  const std::string_view chosen = result.camera().modelId();
  if (chosen == true_model) return ChoiceVerdict::kTrue;
  const auto truth = find(true_model);
  if (isNested(chosen, true_model)) return ChoiceVerdict::kNested;
  const auto own = find(chosen);
  const bool is_as_good = truth != candidates.end() && own->num_params <= truth->num_params &&
                          own->holdout_rms_px <= (1 + kAsGood) * truth->holdout_rms_px;
  return is_as_good ? ChoiceVerdict::kEqual : ChoiceVerdict::kOther;
}

}  // namespace alidade
