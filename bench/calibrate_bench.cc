// SPDX-License-Identifier: MIT
// alidade::calibrate() against cv::calibrateCamera() on the same simulated corners, one thread.
#include <cfloat>
#include <cmath>
#include <cstdio>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include <benchmark/benchmark.h>
#include <sys/resource.h>
#include <opencv2/calib3d.hpp>

#include "alidade/adjust/board/errors.h"
#include "alidade/calibrate/calibrator.h"
#include "alidade/simulate/observe.h"
#include "alidade/simulate/random_views.h"
#include "median_reporter.h"

namespace alidade {
namespace {

constexpr ImageSize kSize{1920, 1200};
constexpr double kNoisePx = 0.1;
constexpr int kMaxViews = 3000;
constexpr int kRepetitions = 5;
constexpr int kSlowRepetitions = 2;  // for cases that take seconds
constexpr double kRequiredRatio = 100;

const Checkerboard kBoard{.columns = 10, .rows = 7, .square_m = 0.03};

const AnyCamera& trueCamera() {
  static const AnyCamera camera =
      AnyCamera::make("radtan", std::vector<double>{1003, 1001, 955, 604, -0.2, 0.08, 5e-4, -4e-4, -0.01});
  return camera;
}

// A camera with 120 degrees over the image's width.
const AnyCamera& fisheyeCamera() {
  static const AnyCamera camera =
      AnyCamera::make("kannala_brandt", std::vector<double>{900, 898, 955, 604, 0.02, -0.01, 0.003, -5e-4});
  return camera;
}

std::vector<View> makeViews(const AnyCamera& camera, int count) {
  Random random(1);
  std::vector<View> views;
  for (const SE3& pose : randomViews(camera, kSize, kBoard, count, random)) {
    char name[32];
    std::snprintf(name, sizeof name, "view_%04zu.png", views.size());
    views.push_back(exactView(camera, kSize, kBoard, pose, name));
    addCornerNoise(views.back(), kNoisePx, random);
  }
  return views;
}

// The first `count` views of one fixed sequence.
std::vector<View> simulatedViews(int count) {
  static const std::vector<View> all = makeViews(trueCamera(), kMaxViews);
  return {all.begin(), all.begin() + count};
}

// Largest resident size of this process so far; it never falls, so cases run from small to large.
double peakMegabytes() {
  rusage usage{};
  getrusage(RUSAGE_SELF, &usage);
  return static_cast<double>(usage.ru_maxrss) / 1024;
}

// Counters that reveal a fast but wrong answer.
void setCounters(benchmark::State& state, double rms_px, double fx) {
  state.counters["rms_px"] = rms_px;
  state.counters["fx_error_px"] = fx - trueCamera().parameters()[0];
}

// Calibrates repeatedly; returns the last result.
std::optional<Calibration> calibrateViews(benchmark::State& state, const std::vector<View>& views,
                                          const char* model) {
  std::optional<Calibration> result;
  for (auto _ : state) {
    result = calibrate(kBoard, views, {.model = model});
    if (result->isUsable()) continue;
    state.SkipWithError("the calibration is not trustworthy");
    break;
  }
  return result;
}

// The chosen models may differ, so only the errors are comparable.
void runFisheye(benchmark::State& state) {
  const auto result =
      calibrateViews(state, makeViews(fisheyeCamera(), static_cast<int>(state.range(0))), kAutoModel);
  if (result) state.counters["rms_px"] = rms(result->fit);
}

void runAlidade(benchmark::State& state, const char* model) {
  const auto num_views = static_cast<int>(state.range(0));
  const auto result = calibrateViews(state, simulatedViews(num_views), model);
  if (result) setCounters(state, rms(result->fit), onlyCamera(result->fit).params[0]);
  state.counters["s_per_view"] = benchmark::Counter(
      num_views, benchmark::Counter::kIsIterationInvariantRate | benchmark::Counter::kInvert);
  state.counters["peak_MB"] = peakMegabytes();
}

void runOpenCv(benchmark::State& state, const cv::TermCriteria& criteria) {
  std::vector<std::vector<cv::Point3f>> object;
  std::vector<std::vector<cv::Point2f>> image;
  for (const View& view : simulatedViews(static_cast<int>(state.range(0)))) {
    object.emplace_back();
    image.emplace_back();
    for (const Corner& corner : view.corners) {
      const Eigen::Vector3f p = kBoard.corner(corner.id).cast<float>();
      object.back().emplace_back(p.x(), p.y(), p.z());
      image.back().emplace_back(static_cast<float>(corner.pixel.x()), static_cast<float>(corner.pixel.y()));
    }
  }
  for (auto _ : state) {
    cv::Mat K;
    cv::Mat distortion;
    std::vector<cv::Mat> rotations;
    std::vector<cv::Mat> translations;
    const double rms_px = cv::calibrateCamera(object, image, {kSize.width, kSize.height}, K, distortion,
                                              rotations, translations, 0, criteria);
    setCounters(state, rms_px, K.at<double>(0, 0));
  }
  state.counters["peak_MB"] = peakMegabytes();
}

void runOpenCvDefault(benchmark::State& state) {
  runOpenCv(state, {cv::TermCriteria::COUNT + cv::TermCriteria::EPS, 30, DBL_EPSILON});
}

void runOpenCvConverged(benchmark::State& state) {
  runOpenCv(state, {cv::TermCriteria::COUNT + cv::TermCriteria::EPS, 500, 1e-12});
}

void registerAll() {
  const auto common = [](benchmark::internal::Benchmark* b) {
    return b->Unit(benchmark::kMillisecond)->MeasureProcessCPUTime()->ReportAggregatesOnly();
  };
  common(benchmark::RegisterBenchmark("calibrate/alidade_auto", runAlidade, kAutoModel))
      ->Arg(10)
      ->Arg(100)
      ->Repetitions(kRepetitions);
  common(benchmark::RegisterBenchmark("calibrate/alidade_auto_fisheye", runFisheye))
      ->Arg(100)
      ->Repetitions(kRepetitions);
  common(benchmark::RegisterBenchmark("calibrate/alidade", runAlidade, "radtan"))
      ->Arg(10)
      ->Arg(30)
      ->Arg(100)
      ->Arg(300)
      ->Arg(1000)
      ->Arg(kMaxViews)
      ->Repetitions(kRepetitions);
  const std::pair<const char*, void (*)(benchmark::State&)> opencv[] = {
      {"calibrate/opencv_default", runOpenCvDefault}, {"calibrate/opencv_converged", runOpenCvConverged}};
  for (const auto& [name, run] : opencv) {
    common(benchmark::RegisterBenchmark(name, run))->Arg(10)->Arg(30)->Repetitions(kRepetitions);
    common(benchmark::RegisterBenchmark(name, run))->Arg(100)->Iterations(1)->Repetitions(kSlowRepetitions);
  }
}

// Prints the ratios; false if the required one was measured and is too small.
bool printSummary(const MedianReporter& reporter) {
  bool is_fast_enough = true;
  for (const char* opencv : {"calibrate/opencv_default", "calibrate/opencv_converged"}) {
    for (const char* views : {"/10", "/30", "/100"}) {
      const auto ratio =
          reporter.ratio(opencv + std::string(views), "calibrate/alidade" + std::string(views));
      if (!ratio) continue;
      std::printf("%s%s takes %.3g times as long as alidade\n", opencv, views, *ratio);
      if (std::string(views) == "/100" && *ratio < kRequiredRatio) is_fast_enough = false;
    }
  }
  if (const auto ratio = reporter.ratio("calibrate/alidade_auto/100", "calibrate/alidade/100"))
    std::printf("with the choice of a model alidade takes %.3g times as long at 100 views\n", *ratio);
  if (const auto ratio = reporter.ratio("calibrate/opencv_default/100", "calibrate/alidade_auto/100"))
    std::printf("opencv_default/100 takes %.3g times as long as that\n", *ratio);
  const std::string largest = "calibrate/alidade/" + std::to_string(kMaxViews);
  if (const auto growth = reporter.ratio(largest, "calibrate/alidade/100")) {
    std::printf("alidade grows with the number of views to the power of %.2f between 100 and %d\n",
                std::log(*growth) / std::log(kMaxViews / 100.0), kMaxViews);
  }
  if (!is_fast_enough)
    std::printf("FAILED: required is a ratio of at least %g at 100 views\n", kRequiredRatio);
  return is_fast_enough;
}

}  // namespace
}  // namespace alidade

int main(int argc, char** argv) {
  benchmark::Initialize(&argc, argv);
  if (benchmark::ReportUnrecognizedArguments(argc, argv)) return 2;
  cv::setNumThreads(1);
  alidade::registerAll();
  alidade::MedianReporter reporter;
  benchmark::RunSpecifiedBenchmarks(&reporter);
  return alidade::printSummary(reporter) ? 0 : 1;
}
