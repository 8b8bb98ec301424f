// SPDX-License-Identifier: MIT
// Tests whether held-out images distinguish a wrong camera from the true one. A row for each type of error:
// the numbers of simulated cameras, each tested on 10 views with noise of 0.1 px, that were rejected,
// accepted and neither.
//   validate_bench [trials per row, default 200] [model] [tolerance in px]
// Exits with 1 unless 99 % of the wrong cameras are rejected and 95 % of the true ones are not.
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <optional>
#include <string>
#include <vector>

#include "alidade/validate/held_out/held_out_images.h"
#include "support/lens_draw.h"
#include "support/user_views.h"
#include "support/wrong_camera.h"

namespace alidade {
namespace {

struct Row {
  int num_rejected = 0;
  int num_by_error = 0;
  int num_by_difference = 0;
  int num_passed = 0;
  std::vector<double> p95_px;
};

double at(std::vector<double> values, double share) {
  if (values.empty()) return NAN;
  std::sort(values.begin(), values.end());
  return values[static_cast<std::size_t>(share * static_cast<double>(values.size() - 1))];
}

// An ordinary camera, or nothing if a new one is drawn for each set.
struct Case {
  const char* name;
  std::optional<DrawnCamera> camera;
  const char* model = "";
  double fov_min_deg = 0;
  double fov_max_deg = 0;
};

std::vector<Case> cases() {
  const auto camera = [](const char* model, std::vector<double> params, ImageSize size, double rim_rad) {
    return DrawnCamera{AnyCamera::make(model, params), size, rim_rad};
  };
  return {{.name = "radtan_640",
           .camera = camera("radtan", {535, 534, 322.5, 238.1, -0.28, 0.08, 8e-4, -4e-4, -0.01},
                            {.width = 640, .height = 480}, 0.75)},
          {.name = "radtan_1920",
           .camera = camera("radtan", {1003.1, 1001.7, 961.3, 597.2, -0.28, 0.08, 5e-4, -4e-4, -0.01},
                            {.width = 1920, .height = 1200}, 0.95)},
          {.name = "fisheye_1280",
           .camera = camera("kannala_brandt", {450, 450.5, 642, 475, 0.03, -0.012, 0.004, -0.001},
                            {.width = 1280, .height = 960}, 1.4)},
          {.name = "drawn_radtan", .camera = {}, .model = "radtan", .fov_min_deg = 50, .fov_max_deg = 90},
          {.name = "drawn_fisheye",
           .camera = {},
           .model = "kannala_brandt",
           .fov_min_deg = 90,
           .fov_max_deg = 135}};
}

Row runRow(const Case& c, Wrong wrong, int num_trials, double tolerance_px) {
  constexpr int kViews = 10;
  constexpr double kNoisePx = 0.1;
  Row row;
  for (int i = 0; i < num_trials; ++i) {
    Random random(static_cast<std::uint64_t>(1000 + i));
    const DrawnCamera drawn =
        c.camera ? *c.camera : drawCamera(c.model, random.uniform(c.fov_min_deg, c.fov_max_deg), random);
    const UserSet set = drawUserViews(drawn, kViews, kNoisePx, random);
    const AnyCamera tested = spoiled(drawn.camera, wrong);
    const HeldOutJudgement judgement = judgeOnImages({&tested, drawn.size}, set.board, set.views);
    const std::vector<Diagnosis> checks = heldOutChecks(judgement, tolerance_px);
    const bool by_error = checks[0].severity == Severity::kFailure;
    const bool by_difference = checks[1].severity == Severity::kFailure;
    row.num_by_error += by_error ? 1 : 0;
    row.num_by_difference += by_difference ? 1 : 0;
    row.num_rejected += by_error || by_difference ? 1 : 0;
    row.num_passed += checks[0].severity == Severity::kPass && checks[1].severity == Severity::kPass ? 1 : 0;
    if (judgement.difference) row.p95_px.push_back(judgement.difference->p95_px);
    if (std::getenv("ALIDADE_VERBOSE") != nullptr) {
      for (const Diagnosis& check : checks) {
        if (check.severity != Severity::kPass)
          std::printf("  %d %s: %s; %s\n", i, std::string(check.id).c_str(), check.evidence.c_str(),
                      check.cause.c_str());
      }
    }
  }
  return row;
}

int run(int num_trials, const std::string& only, double tolerance_px) {
  std::printf("%-15s %-17s %8s %9s %9s %9s %8s  %s\n", "camera", "tested", "trials", "rejected", "by error",
              "by diff", "passed", "difference (95 %), px: 1 %, median, 99 %");
  bool is_good = true;
  for (const Case& c : cases()) {
    if (!only.empty() && only != c.name) continue;
    for (const Wrong wrong : kAllWrongs) {
      const Row row = runRow(c, wrong, num_trials, tolerance_px);
      const double percent = 100.0 / num_trials;
      std::printf("%-15s %-17s %8d %8.1f%% %8.1f%% %8.1f%% %7.1f%%  %.3g, %.3g, %.3g\n", c.name,
                  std::string(wrongName(wrong)).c_str(), num_trials, percent * row.num_rejected,
                  percent * row.num_by_error, percent * row.num_by_difference, percent * row.num_passed,
                  at(row.p95_px, 0.01), at(row.p95_px, 0.5), at(row.p95_px, 0.99));
      std::fflush(stdout);
      const double rejected = percent * row.num_rejected;
      if (c.camera) is_good = is_good && (wrong == Wrong::kNot ? rejected <= 5 : rejected >= 99);
    }
  }
  return is_good ? 0 : 1;
}

}  // namespace
}  // namespace alidade

int main(int argc, char** argv) {
  return alidade::run(argc > 1 ? std::atoi(argv[1]) : 200, argc > 2 ? argv[2] : "",
                      argc > 3 ? std::atof(argv[3]) : alidade::kDefaultTolerancePx);
}
