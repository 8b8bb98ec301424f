// SPDX-License-Identifier: MIT
// Quality of the suggested next view, and the cost of the search for it. See README.md.
#include <algorithm>
#include <chrono>
#include <cstdio>
#include <cstdlib>
#include <ctime>
#include <limits>
#include <string>
#include <vector>

#include <Eigen/LU>

#include "alidade/calibrate/calibrator.h"
#include "alidade/camera/projection_uncertainty.h"
#include "alidade/core/error.h"
#include "alidade/core/median.h"
#include "alidade/core/parallel.h"
#include "alidade/guide/guidance.h"
#include "support/poor_set.h"

namespace alidade {
namespace {

constexpr int kNumOthers = 50;

CalibratorOptions optionsFor(const SimulatedSet& set) {
  return {.model = std::string(set.camera.modelId())};
}

// The worst uncertainty after calibrating a set again with one more view, with its true noise; infinite if
// the calibration fails.
double worstAfter(const SimulatedSet& set, const SE3& camera_from_board, std::uint64_t seed) {
  std::vector<View> views = set.views;
  views.push_back(noisyView(set, camera_from_board, "view_next", seed));
  try {
    const Calibration result = calibrate(set.board, std::move(views), optionsFor(set));
    if (!result.uncertainty.covariance) return std::numeric_limits<double>::infinity();
    const ProjectionUncertainty uncertainty(result.camera(), result.imageSize(),
                                            std::numeric_limits<double>::infinity());
    const double scale = kPoorSetNoisePx / result.uncertainty.coordinate_sigma_px;
    return scale * uncertainty.worst(*result.uncertainty.covariance).std_px;
  } catch (const Error&) {
    return std::numeric_limits<double>::infinity();
  }
}

struct Outcome {
  double now = 0;
  double forecast = 0;
  double suggested = std::numeric_limits<double>::infinity();
  double median = 0;
  double best = 0;
};

Outcome runCase(std::size_t i) {
  const SimulatedSet set = drawPoorSet(i % 2 == 0 ? "radtan" : "kannala_brandt", 1000 + i);
  const Calibration result = calibrate(set.board, set.views, optionsFor(set));
  const Guidance guidance = guide(result, coverageOf(result, set.views));
  Outcome outcome{.now = guidance.worst_px};
  if (guidance.next) {
    outcome.forecast = guidance.next->worst_px;
    outcome.suggested = worstAfter(set, guidance.next->camera_from_board, 9000 + i);
  }
  std::vector<double> others;
  for (const SE3& pose : drawOtherViews(set, kNumOthers, 5000 + i))
    others.push_back(worstAfter(set, pose, 9000 + i));
  outcome.median = medianOf(others);
  outcome.best = *std::min_element(others.begin(), others.end());
  return outcome;
}

void compareWithRandomViews(std::size_t num_sets) {
  std::vector<Outcome> outcomes(num_sets);
  parallelFor(num_sets, 0, [&](std::size_t i) { outcomes[i] = runCase(i); });
  std::size_t num_better = 0;
  std::size_t num_best = 0;
  std::vector<double> gains;
  std::vector<double> median_gains;
  std::vector<double> forecasts;
  for (std::size_t i = 0; i < num_sets; ++i) {
    const Outcome& o = outcomes[i];
    const bool is_better = o.suggested < o.median;
    if (is_better) ++num_better;
    if (o.suggested < o.best) ++num_best;
    if (!is_better) std::printf("  not better: set %zu, %.3g px against %.3g px\n", i, o.suggested, o.median);
    gains.push_back(o.suggested / o.now);
    median_gains.push_back(o.median / o.now);
    forecasts.push_back(o.suggested / o.forecast);
  }
  std::printf("%zu sets, each calibrated anew with the suggested view and with %d random ones\n", num_sets,
              kNumOthers);
  std::printf("  better than the median random view: %zu; than the best one: %zu\n", num_better, num_best);
  std::printf("  worst uncertainty over that before, median: suggested %.3f, random %.3f\n", medianOf(gains),
              medianOf(median_gains));
  std::printf("  over its forecast, median: %.3f\n", medianOf(forecasts));
}

double processorSeconds() {
  timespec now{};
  clock_gettime(CLOCK_THREAD_CPUTIME_ID, &now);
  return static_cast<double>(now.tv_sec) + 1e-9 * static_cast<double>(now.tv_nsec);
}

template <class F>
double medianMilliseconds(int count, const F& f) {
  std::vector<double> times;
  for (int i = 0; i < count; ++i) {
    const double start = processorSeconds();
    f();
    times.push_back(1e3 * (processorSeconds() - start));
  }
  return medianOf(times);
}

void timeSearches() {
  std::printf("time of one search, ms of one thread, and over that of the calibration of the same set\n");
  for (const char* model : {"radtan", "kannala_brandt", "thin_prism"}) {
    for (const int num_views : {4, 12, 100}) {
      SimulatedSet set = drawPoorSet(std::string(model) == "thin_prism" ? "radtan" : model, 1234);
      for (const SE3& pose : drawOtherViews(set, num_views, 77)) {
        set.views.push_back(
            noisyView(set, pose, "more_" + std::to_string(set.views.size()), 7 + set.views.size()));
      }
      CalibratorOptions options{.model = model};
      Calibration result = calibrate(set.board, set.views, options);
      const double calibration =
          medianMilliseconds(5, [&] { result = calibrate(set.board, set.views, options); });
      const CoverageReport coverage = coverageOf(result, set.views);
      const double plain = medianMilliseconds(9, [&] { (void)guide(result, coverage); });
      const double target = medianMilliseconds(5, [&] { (void)guide(result, coverage, 1e-6); });
      const double cover = medianMilliseconds(9, [&] { (void)coverageOf(result, set.views); });
      std::printf("  %-15s %3zu views: %6.1f (%.2f), coverage %.2f, with a forecast of %d views %.1f\n",
                  model, set.views.size(), plain, plain / calibration, cover, kMaxForecast, target);
    }
  }
}

}  // namespace
}  // namespace alidade

int main(int argc, char** argv) {
  const int num_sets = argc > 1 ? std::atoi(argv[1]) : 100;
  if (num_sets < 1) {
    std::fprintf(stderr, "usage: guidance_bench [number of sets, 1 or more]\n");
    return 2;
  }
  alidade::timeSearches();
  alidade::compareWithRandomViews(static_cast<std::size_t>(num_sets));
  return 0;
}
