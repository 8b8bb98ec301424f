// SPDX-License-Identifier: MIT
// Does the verdict name what is wrong, and leave good sets alone? A row for each flaw: how many sets were
// given each finding.
//   verdict_bench [sets a row, default 100] [flaw] [radtan | kannala_brandt]
// Exits with 1 unless 95 % of the sets with a flaw are given its finding and 95 % of those without are given
// none.
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <map>
#include <string>

#include "alidade/core/error.h"
#include "support/verdict_case.h"

namespace alidade {
namespace {

struct Row {
  int num_sets = 0;
  int num_right = 0;
  int num_usable = 0;
  std::map<std::string, int> ids;
};

Row runRow(Flaw flaw, const std::string& model, int num_sets) {
  Row row;
  const std::vector<std::string> expected = findingsFor(flaw);
  // A view that was left out does no harm any more, and a lens may deviate by little.
  const bool is_harmless = flaw == Flaw::kSwappedImage || flaw == Flaw::kTooLean;
  for (int i = 0; i < num_sets; ++i) {
    const VerdictCase c = makeVerdictCase(flaw, model, static_cast<std::uint64_t>(i));
    ++row.num_sets;
    try {
      const Calibration result = calibrate(c.set.board, c.set.views, c.options);
      bool is_named = false;
      for (const Diagnosis& f : result.diagnoses) {
        if (f.severity == Severity::kNote && !is_harmless) continue;
        ++row.ids[f.id];
        is_named = is_named || std::find(expected.begin(), expected.end(), f.id) != expected.end();
      }
      if (expected.empty()) is_named = result.verdict() == Verdict::kTrustworthy;
      row.num_right += is_named ? 1 : 0;
      row.num_usable += result.isUsable() ? 1 : 0;
      if (std::getenv("ALIDADE_VERBOSE") != nullptr) {
        const double worst =
            result.uncertainty.projection_far ? result.uncertainty.projection_far->worst_px : NAN;
        const double centre =
            result.uncertainty.projection_far ? result.uncertainty.projection_far->center_px : NAN;
        std::printf(
            "  %3d worst %.3f centre %.3f bias z %.2f rms %.3f rms %.3f local %.3f focal F %.2f spread %.5f "
            "rows F %.2f spread %.5f share %.2f\n",
            i, worst, centre, result.uncertainty.image_bias.z, result.uncertainty.image_bias.rms_px,
            rms(result.fit), result.uncertainty.local_sigma_px, result.uncertainty.variations.focal.f,
            result.uncertainty.variations.focal.spread, result.uncertainty.variations.rows.f,
            result.uncertainty.variations.rows.spread, result.uncertainty.variations.focal_share);
      }
    } catch (const Error& error) {
      ++row.ids["error"];
    }
  }
  return row;
}

int run(int num_sets, const std::string& only_flaw, const std::string& only_model) {
  std::printf("%-16s %-15s %6s %8s %8s  findings\n", "flaw", "model", "sets", "named", "usable");
  bool is_good = true;
  for (const Flaw flaw : kFlaws) {
    if (!only_flaw.empty() && only_flaw != flawName(flaw)) continue;
    for (const std::string model : {"radtan", "kannala_brandt"}) {
      if (!only_model.empty() && only_model != model) continue;
      const Row row = runRow(flaw, model, num_sets);
      std::printf("%-16s %-15s %6d %7.1f%% %7.1f%% ", std::string(flawName(flaw)).c_str(), model.c_str(),
                  row.num_sets, 100.0 * row.num_right / row.num_sets, 100.0 * row.num_usable / row.num_sets);
      for (const auto& [id, count] : row.ids) std::printf(" %s %d", id.c_str(), count);
      std::printf("\n");
      std::fflush(stdout);
      is_good = is_good && row.num_right >= 0.95 * row.num_sets;
    }
  }
  return is_good ? 0 : 1;
}

}  // namespace
}  // namespace alidade

int main(int argc, char** argv) {
  return alidade::run(argc > 1 ? std::atoi(argv[1]) : 100, argc > 2 ? argv[2] : "", argc > 3 ? argv[3] : "");
}
