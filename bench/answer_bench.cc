// SPDX-License-Identifier: MIT
// Compares the accuracy that calibrations of simulated and real sets state with the truth.
//   answer_bench sound [sets per row, default 200]  30 views over the whole image, nothing wrong
//   answer_bench flawed [sets, default 600] [flaw]  flaws of all kinds and sizes, and trust in the results
//   answer_bench cameras [pairs, default 100]       mixed views of two cameras
//   answer_bench uneven [sets per row, default 200] stated deviations with printed, stretched and flat boards
//   answer_bench halves CORNERS.csv...              random halves of a set compared
// With ALIDADE_VERBOSE in the environment, `flawed` prints each set.
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <map>
#include <numeric>
#include <optional>
#include <string>
#include <vector>

#include "alidade/calibrate/calibrator.h"
#include "alidade/calibrate/uncertainty/aligned_difference.h"
#include "alidade/core/error.h"
#include "alidade/core/parallel.h"
#include "alidade/files/corners_file.h"
#include "support/answer.h"
#include "support/flawed_set.h"
#include "support/spoiled_set.h"

namespace alidade {
namespace {

template <class AnswerTo>
std::vector<Answer> answers(std::size_t count, const AnswerTo& answer_to) {
  std::vector<Answer> all(count);
  parallelFor(count, 0, [&](std::size_t i) { all[i] = answer_to(i); });
  return all;
}

std::size_t countTrustworthy(const std::vector<Answer>& all) {
  return static_cast<std::size_t>(
      std::ranges::count(all, Verdict::kTrustworthy, [](const Answer& a) { return a.verdict; }));
}

double percent(std::size_t part, std::size_t all) {
  return all == 0 ? 0 : 100.0 * static_cast<double>(part) / static_cast<double>(all);
}

void printIds(const std::vector<Answer>& all, Severity least) {
  std::map<std::string, int> counts;
  for (const Answer& answer : all) {
    for (const Diagnosis& d : answer.diagnoses) counts[std::string(d.id)] += d.severity >= least ? 1 : 0;
  }
  for (const auto& [id, count] : counts) {
    if (count > 0) std::printf(" %s %d", id.c_str(), count);
  }
  std::printf("\n");
}

int runSound(std::size_t num_sets) {
  std::printf("%-15s %5s %12s %14s %13s  warnings\n", "camera", "noise", "trustworthy", "within stated",
              "beyond 3x");
  for (const std::string model : {"radtan", "kannala_brandt"}) {
    for (const double noise : {0.1, 0.2}) {
      const AnyCamera camera = spoiledCamera(model);
      const std::vector<Answer> all = answers(num_sets, [&](std::size_t i) {
        const SimulatedSet set =
            simulateSet(camera, kSpoiledSize, 30, noise, streamSeed(11, i), {}, kSpoiledBoard);
        return answerOf(set.board, set.views, {.jobs = 1}, camera);
      });
      std::size_t num_within = 0;
      std::size_t num_covered = 0;
      for (const Answer& answer : all) {
        num_within += answer.num_within;
        num_covered += answer.num_covered;
      }
      const auto num_beyond = std::ranges::count_if(all, [](const Answer& a) { return a.worst_ratio > 3; });
      std::printf("%-15s %5.1f %10.1f %% %12.1f %% %11.1f %% ", model.c_str(), noise,
                  percent(countTrustworthy(all), num_sets), percent(num_within, num_covered),
                  percent(static_cast<std::size_t>(num_beyond), num_sets));
      printIds(all, Severity::kWarning);
      std::fflush(stdout);
    }
  }
  return 0;
}

int runFlawed(std::size_t num_sets, const std::string& only) {
  struct Case {
    const FlawKind* kind;
    std::size_t number;
  };
  std::vector<Case> cases;
  for (std::size_t i = 0; cases.size() < num_sets; ++i) {
    const FlawKind& kind = flawKinds()[i % flawKinds().size()];
    if (only.empty() || kind.name == only) cases.push_back({&kind, i});
  }
  const std::vector<Answer> all = answers(cases.size(), [&](std::size_t i) {
    const std::string model = cases[i].number / flawKinds().size() % 2 == 0 ? "radtan" : "kannala_brandt";
    const FlawedSet set = drawFlawedSet(*cases[i].kind, model, streamSeed(600, cases[i].number));
    return answerOf(set.set.board, set.set.views, {.jobs = 1}, set.drawn.camera);
  });
  struct Row {
    int num_sets = 0;
    int num_trustworthy = 0;
    int num_rejected = 0;
    int num_wrong = 0;
  };
  std::map<std::string_view, Row> rows;
  Row total;
  for (std::size_t i = 0; i < all.size(); ++i) {
    const Answer& a = all[i];
    const bool is_trustworthy = a.verdict == Verdict::kTrustworthy;
    const bool is_wrong = is_trustworthy && (a.p95_px > kTolerancePx || a.worst_ratio > 3);
    for (Row* row : {&rows[cases[i].kind->name], &total}) {
      ++row->num_sets;
      row->num_trustworthy += is_trustworthy ? 1 : 0;
      row->num_rejected += a.verdict == Verdict::kNo ? 1 : 0;
      row->num_wrong += is_wrong ? 1 : 0;
    }
    if (std::getenv("ALIDADE_VERBOSE") != nullptr) {
      std::printf("%s %zu: %s, stated %.3g px, true %.3g px;", std::string(cases[i].kind->name).c_str(),
                  cases[i].number, std::string(verdictName(a.verdict)).c_str(), a.stated_px, a.p95_px);
      printIds({a}, Severity::kWarning);
    }
    if (!is_wrong) continue;
    std::printf(
        "wrong: %s, set %zu: stated %.3g px where boards were seen; 95 %% of what is said to be good "
        "%.3g px, worst %.3g px, "
        "%.1f times the stated error;",
        std::string(cases[i].kind->name).c_str(), cases[i].number, a.stated_px, a.p95_px, a.worst_px,
        a.worst_ratio);
    printIds({a}, Severity::kNote);
  }
  std::printf("%-16s %5s %12s %9s %7s\n", "flaw", "sets", "trustworthy", "rejected", "wrong");
  rows["all"] = total;
  for (const auto& [name, row] : rows) {
    std::printf("%-16s %5d %12d %9d %7d\n", std::string(name).c_str(), row.num_sets, row.num_trustworthy,
                row.num_rejected, row.num_wrong);
  }
  return 0;
}

// Sum of squared differences in stated standard deviations, and their number.
struct Sum {
  double squares = 0;
  int count = 0;
  void add(double difference, double std) {
    squares += difference * difference / (std * std);
    ++count;
  }
  [[nodiscard]] double rms() const { return std::sqrt(squares / count); }
};

int runCameras(std::size_t num_pairs) {
  std::printf("%-15s %6s %7s %18s\n", "camera", "pairs", "named", "named in one alone");
  for (const std::string model : {"radtan", "kannala_brandt"}) {
    const AnyCamera first = spoiledCamera(model);
    const auto isTold = [](const Answer& a) {
      return a.isNamed("two_cameras") || a.isNamed("focal_changed");
    };
    const auto viewsOf = [&](const AnyCamera& camera, int count, std::uint64_t seed) {
      return simulateSet(camera, kSpoiledSize, count, 0.1, seed, {}, kSpoiledBoard);
    };
    // Cameras of one series: focal lengths within 0.3 %, principal points within 10 px. Only pairs count that
    // differ by more than three stated standard deviations.
    const std::vector<Answer> pairs = answers(num_pairs, [&](std::size_t i) {
      Random random(streamSeed(300, i));
      const SimulatedSet set = viewsOf(first, 12, streamSeed(301, i));
      const Calibration alone = calibrate(set.board, set.views, {.model = model, .jobs = 1});
      std::vector<double> params(first.parameters().begin(), first.parameters().end());
      for (int attempt = 0; attempt < 100; ++attempt) {
        double most = 0;
        for (int k = 0; k < 4; ++k) {
          const auto at = static_cast<std::size_t>(k);
          const double size = k < 2 ? 0.001 * first.parameters()[0] : 3.0;
          params[at] = first.parameters()[at] + size * random.normal();
          most = std::max(most, std::abs(params[at] - first.parameters()[at]) / std::sqrt(2) /
                                    alone.uncertainty.parameterStd(k));
        }
        if (most > 3) break;
      }
      SimulatedSet both = set;
      for (View& view : viewsOf(AnyCamera::make(model, params), 12, streamSeed(302, i)).views) {
        view.image = "second_" + view.image;
        both.views.push_back(std::move(view));
      }
      for (View& view : both.views) {
        if (!view.image.starts_with("second_")) view.image = "first_" + view.image;
      }
      return answerOf(both.board, both.views, {.jobs = 1}, first);
    });
    const std::vector<Answer> singles = answers(2 * num_pairs, [&](std::size_t i) {
      SimulatedSet set = viewsOf(first, 24, streamSeed(303, i));
      for (std::size_t v = 0; v < set.views.size(); ++v)
        set.views[v].image = (2 * v < set.views.size() ? "first_" : "second_") + set.views[v].image;
      return answerOf(set.board, set.views, {.jobs = 1}, first);
    });
    std::printf("%-15s %6zu %7td %11td of %zu\n", model.c_str(), pairs.size(),
                std::ranges::count_if(pairs, isTold), std::ranges::count_if(singles, isTold), singles.size());
    std::fflush(stdout);
  }
  return 0;
}

struct Print {
  const char* name;
  double stretch;  // standard deviation
  double point_m;  // of each point, in the plane
  double wave_m;   // of the paper
};
// The first is a board as people print it.
constexpr Print kPrints[] = {{"uneven", 1e-3, 3e-5, 2e-4}, {"stretched", 1e-3, 0, 0}, {"flat", 0, 0, 0}};

std::vector<Eigen::Vector3d> printedPoints(const Checkerboard& board, const Print& print, Random& random) {
  const double stretch = print.stretch * random.normal();
  const double height = print.wave_m * random.normal();
  const double bow = print.wave_m * random.normal();
  const double phase = random.uniform(0, 6.28);
  std::vector<Eigen::Vector3d> points;
  for (int i = 0; i < board.numCorners(); ++i) {
    Eigen::Vector3d p = board.corner(i);
    const Eigen::Vector2d at = (p - board.middle()).head<2>().cwiseQuotient(board.middle().head<2>());
    p.x() *= 1 + stretch;
    p += print.point_m * Eigen::Vector3d(random.normal(), random.normal(), 0);
    p.z() = height * std::sin(3 * at.x() + phase) + bow * at.y() * at.y();
    points.push_back(p);
  }
  return points;
}

// How often the truth lies within the stated 95 % of single parameters.
int runUneven(std::size_t num_sets, const Print& print) {
  const AnyCamera camera = spoiledCamera("radtan");
  constexpr double kNoisePx = 0.1;
  std::printf("%s\n%5s %5s %7s %7s  %s\n", print.name, "views", "sets", "usable", "uneven",
              "share within 1.96 deviations, RMS of deviations");
  for (const int num_views : {6, 12, 30}) {
    struct One {
      bool is_usable = false;
      bool is_uneven = false;
      std::vector<double> deviations = {};
    };
    std::vector<One> all(num_sets);
    parallelFor(num_sets, 0, [&](std::size_t i) {
      SimulatedSet set =
          simulateSet(camera, kSpoiledSize, num_views, 0,
                      streamSeed(400 + static_cast<std::uint64_t>(num_views), i), {}, kSpoiledBoard);
      Random random(streamSeed(500 + static_cast<std::uint64_t>(num_views), i));
      const std::vector<Eigen::Vector3d> points = printedPoints(set.board, print, random);
      for (std::size_t v = 0; v < set.views.size(); ++v) {
        for (Corner& corner : set.views[v].corners) {
          const Projection at = camera.project(set.poses[v] * points[static_cast<std::size_t>(corner.id)]);
          const double x = random.normal();
          corner.pixel = at.pixel + kNoisePx * Eigen::Vector2d(x, random.normal());
        }
      }
      try {
        const Calibration result = calibrate(set.board, set.views, {.model = "radtan", .jobs = 1});
        One& one = all[i];
        one.is_usable = result.isUsable();
        one.is_uneven = isAnyUneven(result.fit);
        if (!result.uncertainty.covariance) return;
        for (int k = 0; k < 5; ++k) {
          const auto at = static_cast<std::size_t>(k);
          one.deviations.push_back((onlyCamera(result.fit).params[at] - camera.parameters()[at]) /
                                   result.uncertainty.parameterStd(k));
        }
      } catch (const Error&) {  // counts as unusable
        return;
      }
    });
    std::printf("%5d %5zu %7td %7td ", num_views, num_sets, std::ranges::count(all, true, &One::is_usable),
                std::ranges::count(all, true, &One::is_uneven));
    for (std::size_t k = 0; k < 5; ++k) {
      Sum sum;
      std::size_t num_within = 0;
      for (const One& one : all) {
        if (one.deviations.empty()) continue;
        sum.add(one.deviations[k], 1);
        num_within += std::abs(one.deviations[k]) < 1.96 ? 1 : 0;
      }
      std::printf(" %s %.1f %% %.2f", std::string(camera.parameterNames()[k]).c_str(),
                  percent(num_within, static_cast<std::size_t>(sum.count)), sum.rms());
    }
    std::printf("\n");
    std::fflush(stdout);
  }
  return 0;
}

int runHalves(const std::vector<std::string>& paths) {
  constexpr std::size_t kNumHalvings = 8;
  std::printf("%-40s %6s %-15s %9s %6s\n", "set", "views", "model", "halvings", "rms");
  for (const std::string& path : paths) {
    const CornersFile file = readCornersFile(path);
    const Calibration whole = calibrate(file.boards, file.views, {});
    const std::string model = onlyCamera(whole.fit).model;
    Sum sum;
    std::size_t num_made = 0;
    for (std::size_t h = 0; h < kNumHalvings; ++h) {
      Random random(streamSeed(8, h));
      std::vector<View> order = file.views;
      for (std::size_t i = order.size(); i > 1; --i) std::swap(order[i - 1], order[random.index(i)]);
      const auto middle = order.begin() + static_cast<std::ptrdiff_t>(order.size() / 2);
      try {
        const Calibration a = calibrate(file.boards, {order.begin(), middle}, {.model = model});
        const Calibration b = calibrate(file.boards, {middle, order.end()}, {.model = model});
        if (!a.uncertainty.covariance || !b.uncertainty.covariance) continue;
        ++num_made;
        for (std::size_t k = 0; k < onlyCamera(a.fit).params.size(); ++k) {
          const int i = static_cast<int>(k);
          const double std = std::hypot(a.uncertainty.parameterStd(i), b.uncertainty.parameterStd(i));
          if (std > 0) sum.add(onlyCamera(a.fit).params[k] - onlyCamera(b.fit).params[k], std);
        }
      } catch (const Error& error) {
        std::fprintf(stderr, "%s: %s\n", path.c_str(), error.what());
      }
    }
    std::printf("%-40s %6zu %-15s %9zu %6.2f\n", path.c_str(), file.views.size(), model.c_str(), num_made,
                sum.rms());
    std::fflush(stdout);
  }
  return 0;
}

int run(const std::vector<std::string>& args) {
  const std::string what = args.empty() ? "" : args[0];
  const auto count = [&](std::size_t by_default) {
    return args.size() > 1 ? static_cast<std::size_t>(std::atoi(args[1].c_str())) : by_default;
  };
  if (what == "sound") return runSound(count(200));
  if (what == "flawed") return runFlawed(count(600), args.size() > 2 ? args[2] : "");
  if (what == "cameras") return runCameras(count(100));
  if (what == "uneven") {
    for (const Print& print : kPrints) runUneven(count(200), print);
    return 0;
  }
  if (what == "halves" && args.size() > 1) return runHalves({args.begin() + 1, args.end()});
  std::fprintf(
      stderr,
      "usage: answer_bench sound [SETS] | flawed [SETS [FLAW]] | cameras [PAIRS] | uneven [SETS] | halves "
      "CORNERS.csv...\n");
  return 2;
}

}  // namespace
}  // namespace alidade

int main(int argc, char** argv) {
  return alidade::run({argv + 1, argv + argc});
}
