// SPDX-License-Identifier: MIT
// Effect of bad corners and bad views on a calibration, and whether it reports them. Tables over simulated
// sets of 25 (and 8) views of 70 corners with noise of 0.1 px.
//   robust_bench [sets per row, default 100]
//                [outliers | views | influence | aspect [radtan | kannala_brandt]]
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <map>
#include <set>
#include <string>

#include "alidade/calibrate/calibrator.h"
#include "alidade/core/error.h"
#include "support/spoiled_set.h"

namespace alidade {
namespace {

using Models = std::vector<std::string>;

class Spread {
 public:
  void add(double x) {
    ++n_;
    sum_ += x;
    squares_ += x * x;
  }
  [[nodiscard]] double mean() const { return sum_ / n_; }
  [[nodiscard]] double deviation() const { return std::sqrt(squares_ / n_ - mean() * mean()); }

 private:
  int n_ = 0;
  double sum_ = 0;
  double squares_ = 0;
};

Calibration run(const SimulatedSet& set) {
  return calibrate(set.board, set.views, {.model = std::string(set.camera.modelId())});
}

// A message without its numbers, to count equal ones.
std::string withoutNumbers(const std::string& text) {
  std::string out;
  for (const char c : text) {
    const bool is_digit = (c >= '0' && c <= '9') || c == '.';
    if (!is_digit) out += c;
    if (is_digit && (out.empty() || out.back() != '#')) out += '#';
  }
  return out;
}

void outlierTable(const Models& models, int num_sets) {
  std::printf("%-15s %-7s %9s %9s %7s %9s %9s %9s\n", "model", "moved", "std fx", "clean", "ratio", "false %",
              "missed %", "missed>1px");
  for (const std::string& model : models) {
    for (const Blunder blunder : {Blunder::kAround, Blunder::kBox}) {
      Spread clean_fx;
      Spread fx;
      double num_false = 0;
      double num_clean = 0;
      double num_moved = 0;
      double num_missed = 0;
      double num_far_missed = 0;
      for (int i = 0; i < num_sets; ++i) {
        const auto seed = static_cast<std::uint64_t>(1000 + i);
        SimulatedSet set = cleanSet(model, 25, seed);
        const Calibration clean = run(set);
        clean_fx.add(onlyCamera(clean.fit).params[0]);
        const auto moved = moveCorners(set, blunder, 0.05, seed);
        const Calibration result = run(set);
        fx.add(onlyCamera(result.fit).params[0]);
        std::set<std::pair<std::string, int>> named;
        for (const Outlier& o : result.dropped.outliers) named.insert({o.image, o.corner_id});
        for (const CornerName& corner : moved) {
          if (named.erase({corner.image, corner.corner_id}) > 0) continue;
          ++num_missed;
          if (corner.moved_px > 1) ++num_far_missed;
        }
        num_moved += static_cast<double>(moved.size());
        num_false += static_cast<double>(named.size());
        num_clean += 25 * 70 - static_cast<double>(moved.size());
      }
      std::printf("%-15s %-7s %9.4f %9.4f %7.3f %9.4f %9.3f %9.3f\n", model.c_str(),
                  blunder == Blunder::kAround ? "around" : "box", fx.deviation(), clean_fx.deviation(),
                  fx.deviation() / clean_fx.deviation(), 100 * num_false / num_clean,
                  100 * num_missed / num_moved, 100 * num_far_missed / num_moved);
      std::fflush(stdout);
    }
  }
}

// Largest difference of a parameter from the clean result, in sigmas of the clean one.
double largestPull(const Calibration& result, const Calibration& clean) {
  double largest = 0;
  for (std::size_t i = 0; i < onlyCamera(clean.fit).params.size(); ++i) {
    largest = std::max(largest, std::abs(onlyCamera(result.fit).params[i] - onlyCamera(clean.fit).params[i]) /
                                    clean.uncertainty.parameterStdByNoise(static_cast<int>(i)));
  }
  return largest;
}

// True if the image is named in a finding or is among the views left out.
bool isNamed(const Calibration& result, const std::string& image) {
  return std::any_of(result.diagnoses.begin(), result.diagnoses.end(),
                     [&](const Diagnosis& f) { return f.message().starts_with(image + ":"); });
}

void viewTable(const Models& models, int num_sets) {
  std::printf("%-15s %-15s %6s %9s %9s %9s %9s %9s\n", "model", "view", "bad", "within3s%", "named%",
              "wrongly", "warned%", "errors");
  for (const std::string& model : models) {
    for (const int num_views : {25, 8}) {
      std::vector<Calibration> cleans;
      for (int i = 0; i < num_sets; ++i)
        cleans.push_back(run(cleanSet(model, num_views, static_cast<std::uint64_t>(5000 + i))));
      for (const Spoiler spoiler :
           {Spoiler::kBent, Spoiler::kOtherCamera, Spoiler::kShifted, Spoiler::kColumnsFirst, Spoiler::kFaint,
            Spoiler::kMirrored, Spoiler::kTurned, Spoiler::kLargerSquares}) {
        const int num_bad = spoiler == Spoiler::kFaint ? 1 : 3;
        int num_within = 0;
        int num_named = 0;
        int num_wrong = 0;
        int num_warned = 0;
        int num_errors = 0;
        std::map<std::string, int> reasons;
        for (int i = 0; i < num_sets; ++i) {
          const auto seed = static_cast<std::uint64_t>(5000 + i);
          SimulatedSet set = cleanSet(model, num_views, seed);
          const Calibration& clean = cleans[static_cast<std::size_t>(i)];
          const auto bad = spoilViews(set, spoiler, num_bad, seed);
          try {
            const Calibration result = run(set);
            if (largestPull(result, clean) < 3) ++num_within;
            for (const std::string& image : bad) num_named += isNamed(result, image) ? 1 : 0;
            for (const View& view : set.views) {
              if (std::find(bad.begin(), bad.end(), view.image) == bad.end() && isNamed(result, view.image))
                ++num_wrong;
            }
            if (std::any_of(result.diagnoses.begin(), result.diagnoses.end(), [](const Diagnosis& f) {
                  return f.id != "few_views" && f.id != "focal_uncertain";
                }))
              ++num_warned;
            for (const Diagnosis& f : result.diagnoses) {
              const auto at = f.message().find(": ");
              const bool is_view = f.message().starts_with("view_") && at != std::string::npos;
              ++reasons[std::string(f.id) +
                        (is_view ? " " + withoutNumbers(f.message().substr(at + 2)) : "")];
            }
          } catch (const Error& error) {
            ++num_errors;
          }
        }
        std::printf("%-15s %-15s %d/%-4d %9.1f %9.1f %9d %9.1f %9d\n", model.c_str(),
                    std::string(spoilerName(spoiler)).c_str(), num_bad, num_views,
                    100.0 * num_within / num_sets, 100.0 * num_named / num_sets / num_bad, num_wrong,
                    100.0 * num_warned / num_sets, num_errors);
        for (const auto& [reason, count] : reasons) std::printf("    %5d  %.150s\n", count, reason.c_str());
        std::fflush(stdout);
      }
    }
  }
}

bool hasFinding(const Calibration& result, std::string_view id) {
  return std::any_of(result.diagnoses.begin(), result.diagnoses.end(),
                     [&](const Diagnosis& f) { return f.id == id; });
}

double shareAbove(const std::vector<double>& values, double limit) {
  const auto count = std::count_if(values.begin(), values.end(), [&](double x) { return x > limit; });
  return 100.0 * static_cast<double>(count) / static_cast<double>(values.size());
}

// The largest influence among a set's views.
ViewInfluence largestInfluence(const Calibration& result) {
  ViewInfluence largest;
  for (const ViewInfluence& influence : result.uncertainty.influences) {
    largest.move_sigmas = std::max(largest.move_sigmas, influence.move_sigmas);
    largest.surprise_sigmas = std::max(largest.surprise_sigmas, influence.surprise_sigmas);
  }
  return largest;
}

void influenceTable(const Models& models, int num_sets) {
  std::printf(
      "%-15s %-7s %5s   share of sets, %%, whose most surprising view exceeds 3 4 5 6 sigmas; most moving 2 "
      "4\n",
      "model", "views", "");
  for (const std::string& model : models) {
    for (const int num_views : {25, 8}) {
      for (const bool is_clean : {true, false}) {
        std::vector<double> surprise;
        std::vector<double> move;
        int num_named = 0;
        for (int i = 0; i < num_sets; ++i) {
          SimulatedSet set = cleanSet(model, num_views, static_cast<std::uint64_t>(9000 + i));
          if (!is_clean) spoilViews(set, Spoiler::kFaint, 1, static_cast<std::uint64_t>(i));
          const Calibration result = run(set);
          num_named += hasFinding(result, "influential_view") ? 1 : 0;
          const ViewInfluence largest = largestInfluence(result);
          surprise.push_back(largest.surprise_sigmas);
          move.push_back(largest.move_sigmas);
        }
        std::printf("%-15s %-7d %5s ", model.c_str(), num_views, is_clean ? "clean" : "faint");
        for (const double limit : {3.0, 4.0, 5.0, 6.0}) std::printf(" %6.1f", shareAbove(surprise, limit));
        for (const double limit : {2.0, 4.0}) std::printf(" %6.1f", shareAbove(move, limit));
        std::printf("; %6.1f\n", 100.0 * num_named / num_sets);
        std::fflush(stdout);
      }
    }
  }
}

void aspectTable(const Models& models, int num_sets) {
  std::printf("%-15s %5s %9s %11s %11s %11s   share of sets, %%, beyond 3 4 5 sigma; with the finding\n",
              "model", "views", "stretch", "mean", "std", "said");
  for (const std::string& model : models) {
    for (const int num_views : {25, 8}) {
      for (const double stretch : {0.0, 0.001, 0.005}) {
        Spread found;
        Spread sigma;
        std::vector<double> z;
        int num_named = 0;
        for (int i = 0; i < num_sets; ++i) {
          const auto result =
              run(stretchedSet(model, num_views, 1 + stretch, static_cast<std::uint64_t>(20000 + i)));
          num_named += hasFinding(result, "board_not_square") ? 1 : 0;
          const std::vector<CommonError>& errors = result.uncertainty.common_errors;
          if (errors.empty() || errors.front().cause != CommonCause::kStretch) continue;
          found.add(errors.front().value);
          sigma.add(errors.front().sigma);
          z.push_back(std::abs(errors.front().value) / errors.front().sigma);
        }
        std::printf("%-15s %5d %9.4f %11.6f %11.6f %11.6f ", model.c_str(), num_views, stretch, found.mean(),
                    found.deviation(), sigma.mean());
        for (const double limit : {3.0, 4.0, 5.0}) std::printf(" %6.1f", shareAbove(z, limit));
        std::printf("; %6.1f\n", 100.0 * num_named / num_sets);
        std::fflush(stdout);
      }
    }
  }
}

}  // namespace
}  // namespace alidade

int main(int argc, char** argv) {
  const int num_sets = argc > 1 ? std::atoi(argv[1]) : 100;
  const std::string only = argc > 2 ? argv[2] : "";
  const alidade::Models models =
      argc > 3 ? alidade::Models{argv[3]} : alidade::Models{"radtan", "kannala_brandt"};
  if (num_sets < 1) {
    std::fprintf(stderr,
                 "usage: robust_bench [sets a row, at least 1] [outliers | views | influence | aspect "
                 "[radtan | kannala_brandt]]\n");
    return 2;
  }
  if (only.empty() || only == "outliers") alidade::outlierTable(models, num_sets);
  if (only.empty() || only == "views") alidade::viewTable(models, num_sets);
  if (only.empty() || only == "influence") alidade::influenceTable(models, num_sets);
  if (only.empty() || only == "aspect") alidade::aspectTable(models, num_sets);
  return 0;
}
