// SPDX-License-Identifier: MIT
// Counts which models are chosen for lenses of each model, how often a model that cannot follow the lens is
// detected, and how many cameras are wrong beyond their sigmas and trusted.
//   choice_bench [sets per model, default 20] [seed, default 1] [model or all]
//                [views per set, default 12 to 40]
#include <algorithm>
#include <cstdio>
#include <cstdlib>
#include <ctime>
#include <limits>
#include <optional>
#include <string>

#include "alidade/calibrate/calibrator.h"
#include "alidade/camera/any_camera.h"
#include "alidade/core/error.h"
#include "support/choice_sweep.h"

namespace alidade {
namespace {

constexpr double kRequiredShare = 0.95;
constexpr double kNoisePx = 0.1;

struct Tally {
  int num_sets = 0;
  int verdicts[4] = {};
  double largest_z = -std::numeric_limits<double>::infinity();  // of sets calibrated with their true model
  int num_clean = 0;                                            // number of these sets
  int num_false = 0;                                            // of these, sets with errors called biased
  int num_lean = 0;            // calibrations with a model that is off by more than half the noise
  int num_found = 0;           // of these, those called biased
  int num_astray = 0;          // chosen cameras that are wrong beyond their sigmas in a tenth of the image
  int num_astray_trusted = 0;  // of these, those without any finding
  double seconds = 0;

  [[nodiscard]] double share() const {
    return static_cast<double>(num_sets - verdicts[static_cast<int>(ChoiceVerdict::kOther)]) / num_sets;
  }
  void operator+=(const Tally& o) {
    num_sets += o.num_sets;
    for (int i = 0; i < 4; ++i) verdicts[i] += o.verdicts[i];
    largest_z = std::max(largest_z, o.largest_z);
    num_clean += o.num_clean;
    num_false += o.num_false;
    num_lean += o.num_lean;
    num_found += o.num_found;
    num_astray += o.num_astray;
    num_astray_trusted += o.num_astray_trusted;
    seconds += o.seconds;
  }
};

double cpuSeconds() {
  return static_cast<double>(std::clock()) / CLOCKS_PER_SEC;
}

void printOther(const std::string& model, int number, const ChoiceSet& set, const Calibration& result) {
  std::printf("  %s set %d, %.0f degrees, %zu views:", model.c_str(), number, set.fov_deg,
              set.set.views.size());
  for (const ModelCandidate& c : result.choice.model->candidates) {
    std::printf(" %s %.4g (%+.2f +- %.2f %%, %s)", c.id.c_str(), c.holdout_rms_px, 100 * c.excess,
                100 * c.excess_std, c.verdict.c_str());
  }
  std::printf("\n");
}

// A model that cannot follow the lens adds its own error to the noise.
void addLean(const ChoiceSet& set, const std::string& lean, Tally& tally) {
  constexpr double kHalfNoise = 0.5;
  try {
    const Calibration result = calibrate(set.set.board, set.set.views, {.model = lean});
    const double error_px = result.uncertainty.coordinate_sigma_px / kNoisePx;
    if (!(error_px * error_px > 1 + kHalfNoise * kHalfNoise)) return;
    ++tally.num_lean;
    if (result.uncertainty.image_bias.isSeen()) ++tally.num_found;
    if (!result.uncertainty.image_bias.isSeen())
      std::printf("  %s is not seen to be too lean: sigma %.3f px, z %.2f, %zu views\n", lean.c_str(),
                  result.uncertainty.coordinate_sigma_px, result.uncertainty.image_bias.z,
                  result.fit.views.size());
  } catch (const Error&) {
    return;  // a stronger statement
  }
}

void addSpread(const ChoiceSet& set, const Calibration& result, Tally& tally) {
  constexpr double kMuch = 0.1;
  const double share = shareAstray(set.drawn.camera, set.set.views, result);
  if (!(share > kMuch) || !result.isUsable()) return;
  ++tally.num_astray;
  const bool is_trusted = result.verdict() == Verdict::kTrustworthy;
  tally.num_astray_trusted += is_trusted ? 1 : 0;
  std::printf("  astray in %.0f %% of the image: %s for %s, %.0f degrees, %zu views:", 100 * share,
              std::string(result.camera().modelId()).c_str(), std::string(set.drawn.camera.modelId()).c_str(),
              set.fov_deg, set.set.views.size());
  for (const Diagnosis& f : result.diagnoses) std::printf(" %s", std::string(f.id).c_str());
  std::printf("\n");
}

Tally runSet(const std::string& model, std::uint64_t seed, int number, std::optional<int> num_views) {
  Tally tally{.num_sets = 1};
  const ChoiceSet set = drawChoiceSet(model, seed, static_cast<std::uint64_t>(number), num_views);
  const double before = cpuSeconds();
  const Calibration result = calibrate(set.set.board, set.set.views, {.model = kAutoModel});
  tally.seconds = cpuSeconds() - before;
  addSpread(set, result, tally);
  const ChoiceVerdict verdict = judgeChoice(model, result);
  ++tally.verdicts[static_cast<int>(verdict)];
  if (verdict == ChoiceVerdict::kOther) printOther(model, number, set, result);
  if (verdict == ChoiceVerdict::kTrue) {
    tally.num_clean = 1;
    tally.num_false = result.uncertainty.image_bias.isSeen() ? 1 : 0;
    tally.largest_z = result.uncertainty.image_bias.z;
  }
  for (const std::string& lean : modelsTooLeanFor(model)) addLean(set, lean, tally);
  return tally;
}

void printTally(const char* name, const Tally& t) {
  std::printf("%-16s %5d %6d %7d %6d %6d %8.1f%% %6d/%-5d %6.2f %6d/%-5d %9d/%-4d %9.1f\n", name, t.num_sets,
              t.verdicts[0], t.verdicts[1], t.verdicts[2], t.verdicts[3], 100 * t.share(), t.num_false,
              t.num_clean, t.largest_z, t.num_found, t.num_lean, t.num_astray_trusted, t.num_astray,
              1000 * t.seconds / t.num_sets);
  std::fflush(stdout);
}

int run(int num_sets, std::uint64_t seed, const std::string& only, std::optional<int> num_views) {
  std::printf("%-16s %5s %6s %7s %6s %6s %9s %12s %6s %12s %14s %9s\n", "true model", "sets", "true",
              "nested", "equal", "other", "as good", "false alarms", "max z", "lean, seen", "trusted/astray",
              "ms a set");
  Tally total;
  bool is_good = true;
  for (const std::string& model : modelIds()) {
    if (!only.empty() && only != "all" && model != only) continue;
    Tally tally;
    for (int number = 0; number < num_sets; ++number) tally += runSet(model, seed, number, num_views);
    printTally(model.c_str(), tally);
    is_good = is_good && tally.share() >= kRequiredShare;
    total += tally;
  }
  if (total.num_sets == 0) {
    std::fprintf(stderr, "no model is called %s\n", only.c_str());
    return 2;
  }
  printTally("all", total);
  if (!is_good) std::printf("FAILED: required are %g %% of each model\n", 100 * kRequiredShare);
  return is_good ? 0 : 1;
}

}  // namespace
}  // namespace alidade

int main(int argc, char** argv) {
  const int num_sets = argc > 1 ? std::atoi(argv[1]) : 20;
  if (num_sets < 1) {
    std::fprintf(stderr,
                 "usage: choice_bench [sets a model, at least 1] [seed] [model or all] [views a set]\n");
    return 2;
  }
  const auto seed = static_cast<std::uint64_t>(argc > 2 ? std::atoll(argv[2]) : 1);
  const int num_views = argc > 4 ? std::atoi(argv[4]) : 0;
  return alidade::run(num_sets, seed, argc > 3 ? argv[3] : "",
                      num_views > 0 ? std::optional(num_views) : std::nullopt);
}
