// SPDX-License-Identifier: MIT
// Tests whether calibrate() finds the true optimum without a guess. A table over all models and fields of
// view.
//   start_bench [sets per cell, default 5] [model, default all] [seed, default 0]
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <string>

#include "support/start_sweep.h"

namespace {

constexpr double kRequiredShare = 0.995;
constexpr int kMaxSets = 100000;  // per cell; sets of different seeds never coincide

struct Tally {
  int num_sets = 0;
  int num_found = 0;
  int num_undetermined = 0;  // counted neither as found nor as missed
  int num_held = 0;          // nor these: the result states that the views do not determine the model
  int num_silent = 0;        // neither found nor reported
  int num_lonely = 0;        // found, but by one start of several
  int num_lonely_missed = 0;
  double seconds = 0;

  [[nodiscard]] double share() const {
    const int num_counted = num_sets - num_undetermined - num_held;
    return num_counted == 0 ? 1.0 : static_cast<double>(num_found) / num_counted;
  }
  void operator+=(const Tally& other) {
    num_sets += other.num_sets;
    num_found += other.num_found;
    num_undetermined += other.num_undetermined;
    num_held += other.num_held;
    num_lonely += other.num_lonely;
    num_lonely_missed += other.num_lonely_missed;
    num_silent += other.num_silent;
    seconds += other.seconds;
  }
};

void printMiss(const alidade::SweepCell& cell, int number, const alidade::SweepOutcome& outcome) {
  std::string ids;
  for (const auto& finding : outcome.result.diagnoses) ids += " " + std::string(finding.id);
  if (!outcome.error.empty()) ids = " error: " + outcome.error;
  std::printf(
      "  missed%s: %s %g set %d, %zu views, cost / true cost - 1 = %.2g, used %zu, outliers %zu, %s;%s\n",
      outcome.is_determined ? "" : " (undetermined)", cell.model.c_str(), cell.fov_deg, number,
      outcome.set.views.size(), outcome.result.fit.summary.cost / outcome.cost_from_truth - 1,
      outcome.result.fit.views.size(), outcome.result.dropped.outliers.size(),
      outcome.result.fit.summary.reason.c_str(), ids.c_str());
  const auto print = [](const char* name, const alidade::AnyCamera& camera) {
    std::printf("    %-6s", name);
    for (const double value : camera.parameters()) std::printf(" %.5g", value);
    std::printf("\n");
  };
  print("found", outcome.result.camera());
  print("true", outcome.drawn.camera);
}

void printTally(const char* name, double fov_deg, const Tally& tally) {
  std::printf("%-16s %6g %6d %13d %6d %7.2f%% %8d %10.1f\n", name, fov_deg, tally.num_sets,
              tally.num_undetermined, tally.num_held, 100 * tally.share(), tally.num_silent,
              1000 * tally.seconds / tally.num_sets);
}

}  // namespace

int main(int argc, char** argv) {
  const int num_sets = argc > 1 ? std::atoi(argv[1]) : 5;
  const std::string only = argc > 2 ? argv[2] : "all";
  const std::uint64_t seed = argc > 3 ? std::strtoull(argv[3], nullptr, 10) : 0;
  if (num_sets < 1 || num_sets > kMaxSets) {
    std::fprintf(stderr, "usage: start_bench [sets a cell, at least 1] [model or all] [seed]\n");
    return 2;
  }
  std::printf("%-16s %6s %6s %13s %6s %8s %8s %10s\n", "model", "fov", "sets", "undetermined", "held",
              "found", "silent", "ms a set");
  Tally total;
  for (const alidade::SweepCell& cell : alidade::sweepCells()) {
    if (only != "all" && cell.model != only) continue;
    Tally tally;
    for (int number = 0; number < num_sets; ++number) {
      const alidade::SweepOutcome outcome =
          alidade::runSweepSet(cell, seed * kMaxSets + static_cast<std::uint64_t>(number));
      const bool is_held = outcome.is_determined && outcome.isHeld();
      const bool is_found = outcome.isAtOptimum();
      const auto& start = outcome.result.choice.start;
      const bool is_lonely = start.num_solved > 1 && start.num_agreed == 1;
      tally += {.num_sets = 1,
                .num_found = is_found && outcome.is_determined && !is_held ? 1 : 0,
                .num_undetermined = outcome.is_determined ? 0 : 1,
                .num_held = is_held ? 1 : 0,
                .num_silent = is_found || outcome.isWarned() ? 0 : 1,
                .num_lonely = is_found && is_lonely ? 1 : 0,
                .num_lonely_missed = !is_found && !outcome.isHeld() && is_lonely ? 1 : 0,
                .seconds = outcome.seconds};
      if (!is_found && !outcome.isHeld()) printMiss(cell, number, outcome);
    }
    printTally(cell.model.c_str(), cell.fov_deg, tally);
    std::fflush(stdout);
    total += tally;
  }
  if (total.num_sets == 0) {
    std::fprintf(stderr, "no model is called %s\n", only.c_str());
    return 2;
  }
  printTally("all", 0, total);
  std::printf("starts that nothing confirmed: %d of those found, %d of those missed\n", total.num_lonely,
              total.num_lonely_missed);
  const bool is_good = total.share() >= kRequiredShare && total.num_silent == 0;
  if (!is_good) std::printf("FAILED: required are %g %% and none silent\n", 100 * kRequiredShare);
  return is_good ? 0 : 1;
}
