// SPDX-License-Identifier: MIT
// Tests whether the verdict names the flaw, and accepts good sets. A row for each flaw: the numbers of sets
// with each finding.
//   verdict_bench [sets per row, default 100] [flaw] [radtan | kannala_brandt]
// Exits with 1 unless 95 % of the sets with a flaw are given its finding and 95 % of those without are given
// none.
//   verdict_bench graded [sets per row, default 100]
// Flaws with an adjustable strength: one that displaces points by the tolerance, and by a tenth of it. Exits
// with 1 unless 97 % of the strong ones are named in a warning or failure, and 97 % of the weak ones are not.
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <map>
#include <optional>
#include <string>

#include "alidade/adjust/board/errors.h"
#include "alidade/calibrate/uncertainty/aligned_difference.h"
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
  const std::vector<DiagnosisId> expected = findingsFor(flaw);
  // A view that was left out does no more harm, and a lens may deviate slightly.
  const bool is_harmless = flaw == Flaw::kSwappedImage || flaw == Flaw::kTooLean;
  for (int i = 0; i < num_sets; ++i) {
    const VerdictCase c = makeVerdictCase(flaw, model, static_cast<std::uint64_t>(i));
    ++row.num_sets;
    try {
      const Calibration result = calibrate(c.set.board, c.set.views, c.options);
      bool is_named = false;
      for (const Diagnosis& f : result.diagnoses) {
        if (f.severity == Severity::kNote && !is_harmless) continue;
        ++row.ids[std::string(f.id)];
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
            rms(result.fit), result.uncertainty.local_sigma_px, result.uncertainty.variations.focal_f,
            result.uncertainty.variations.focal_spread, result.uncertainty.variations.rows_f,
            result.uncertainty.variations.rows_spread, result.uncertainty.variations.focal_share);
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

// A flawed set and the same views without the flaw: same camera, poses and noise.
class GradedCase {
 public:
  GradedCase(Flaw flaw, const std::string& model, std::uint64_t number)
      : flaw_(flaw), model_(model), number_(number), sound_(calibratedWith(0)) {
    const Accuracy& accuracy = sound_.uncertainty.accuracy.value();
    for (std::size_t i = 0; i < accuracy.pixels.size(); ++i) {
      if (accuracy.is_covered[i]) covered_.push_back(accuracy.pixels[i]);
    }
  }

  struct Graded {
    double effect_px = 0;  // largest effect of the flaw where boards were seen
    bool is_mended = false;
    bool is_warned = false;
  };
  [[nodiscard]] Graded at(double strength) const {
    Graded graded;
    try {
      const Calibration result = calibratedWith(strength);
      const std::vector<DiagnosisId> expected = findingsFor(flaw_);
      graded.is_warned = std::ranges::any_of(result.diagnoses, [&](const Diagnosis& d) {
        return d.severity > Severity::kNote && std::ranges::find(expected, d.id) != expected.end();
      });
      graded.effect_px = effectOn(result);
      if (flaw_ == Flaw::kBentBoard) {
        // An estimated bend has little effect left. The stated effect is that of a bend taken for a plane.
        graded.is_mended = graded.effect_px < kMendedPx;
        graded.effect_px = effectOn(calibratedWith(strength, BoardShapeMode::kFlat));
      }
    } catch (const Error&) {
      graded = {.effect_px = INFINITY, .is_warned = true};  // refused
    }
    return graded;
  }

 private:
  static constexpr double kMendedPx = 0.25;  // not worth a warning

  [[nodiscard]] Calibration calibratedWith(double strength,
                                           BoardShapeMode shape = BoardShapeMode::kAuto) const {
    VerdictCase c = makeVerdictCase(flaw_, model_, number_, strength);
    c.options.board_shape = shape;
    return calibrate(c.set.board, c.set.views, c.options);
  }
  [[nodiscard]] double effectOn(const Calibration& result) const {
    double largest = 0;
    for (const double d : alignedDifferences(result.camera(), sound_.camera(), covered_, covered_))
      largest = std::fmax(largest, std::isnan(d) ? INFINITY : d);
    return largest;
  }

  Flaw flaw_;
  std::string model_;
  std::uint64_t number_;
  Calibration sound_;
  std::vector<Eigen::Vector2d> covered_;
};

// A flaw grows until it is harmful. Some are detected and corrected earlier: an image that fits less and less
// is left out.
struct GradedRow {
  int num_sets = 0;
  int num_harmful = 0;
  int num_named = 0;  // of the harmful ones
  int num_weak = 0;   // with an effect just below a tenth of the tolerance
  int num_quiet = 0;  // of the weak ones

  void add(const GradedCase& graded) {
    constexpr double kTolerancePx = 1;
    constexpr double kLeast = 1.0 / 256;
    constexpr double kMost = 16;
    ++num_sets;
    std::optional<GradedCase::Graded> weak;
    bool is_weak = true;
    for (double strength = kLeast; strength <= kMost; strength *= std::sqrt(2.0)) {
      const GradedCase::Graded now = graded.at(strength);
      is_weak = is_weak && now.effect_px < 0.1 * kTolerancePx;
      if (is_weak) weak = now;
      if (now.effect_px < kTolerancePx) continue;
      ++num_harmful;
      num_named += now.is_warned || now.is_mended ? 1 : 0;
      break;
    }
    if (!weak) return;
    ++num_weak;
    num_quiet += weak->is_warned ? 0 : 1;
  }
};

int runGraded(int num_sets) {
  std::printf("%-16s %-15s %6s %8s %8s %6s %11s\n", "flaw", "model", "sets", "harmful", "named", "weak",
              "not warned");
  bool is_good = true;
  for (const Flaw flaw : kFlaws) {
    if (!hasStrength(flaw)) continue;
    for (const std::string model : {"radtan", "kannala_brandt"}) {
      GradedRow row;
      for (int i = 0; i < num_sets; ++i) row.add(GradedCase(flaw, model, static_cast<std::uint64_t>(i)));
      std::printf("%-16s %-15s %6d %8d %7.1f%% %6d %10.1f%%\n", std::string(flawName(flaw)).c_str(),
                  model.c_str(), row.num_sets, row.num_harmful, 100.0 * row.num_named / row.num_harmful,
                  row.num_weak, 100.0 * row.num_quiet / row.num_weak);
      std::fflush(stdout);
      is_good = is_good && row.num_harmful > 0 && row.num_named >= 0.97 * row.num_harmful &&
                row.num_weak > 0 && row.num_quiet >= 0.97 * row.num_weak;
    }
  }
  return is_good ? 0 : 1;
}

}  // namespace
}  // namespace alidade

int main(int argc, char** argv) {
  if (argc > 1 && std::string(argv[1]) == "graded")
    return alidade::runGraded(argc > 2 ? std::atoi(argv[2]) : 100);
  return alidade::run(argc > 1 ? std::atoi(argv[1]) : 100, argc > 2 ? argv[2] : "", argc > 3 ? argv[3] : "");
}
