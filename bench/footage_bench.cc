// SPDX-License-Identifier: MIT
// Simulated footage on one thread: one picture, the simulator itself, and exact tracks over all frames.
#include <string>
#include <string_view>
#include <vector>

#include <benchmark/benchmark.h>

#include "alidade/simulate/footage_simulator.h"
#include "median_reporter.h"

namespace alidade {
namespace {

AnyCamera cameraOf(std::string_view model) {
  if (model == "radtan")
    return AnyCamera::make(model, std::vector<double>{500, 500, 319.5, 239.5, -0.2, 0.05, 0, 0, 0});
  return AnyCamera::make(model, std::vector<double>{200, 200, 319.5, 239.5, -0.01, 0, 0, 0});
}

FootageScene sceneOf(std::string_view model, std::string_view kind) {
  FootageScene scene{.camera = cameraOf(model), .image_size = {640, 480}, .num_jobs = 1};
  if (kind == "rolling") scene.effects.rolling_shutter = 0.8;
  if (kind == "crowd") {
    scene.effects.moving_objects = 40;
    scene.effects.moving_share = 0.75;
  }
  return scene;
}

void renderFootage(benchmark::State& state, const FootageScene& scene) {
  const FootageSimulator simulator(scene);
  int frame = 0;
  for ([[maybe_unused]] auto _ : state)
    benchmark::DoNotOptimize(simulator.renderFrame(frame++ % scene.num_frames));
}

void trackFootage(benchmark::State& state, const FootageScene& scene) {
  std::size_t num_pixels = 0;
  for ([[maybe_unused]] auto _ : state) {
    num_pixels = 0;
    for (const TrueTrack& track : FootageSimulator(scene).trackPoints()) num_pixels += track.pixels.size();
  }
  state.counters["pixels"] = static_cast<double>(num_pixels);
}

void registerFootage() {
  for (const std::string model : {"radtan", "kannala_brandt"}) {
    for (const std::string kind : {"plain", "rolling", "crowd"}) {
      const FootageScene scene = sceneOf(model, kind);
      const std::string name = model + "/" + kind;
      benchmark::RegisterBenchmark(("footage/render/" + name).c_str(),
                                   [scene](auto& state) { renderFootage(state, scene); })
          ->Unit(benchmark::kMillisecond)
          ->Repetitions(5);
      benchmark::RegisterBenchmark(("footage/tracks/" + name).c_str(),
                                   [scene](auto& state) { trackFootage(state, scene); })
          ->Unit(benchmark::kMillisecond)
          ->Repetitions(5);
    }
  }
}

}  // namespace
}  // namespace alidade

int main(int argc, char** argv) {
  benchmark::Initialize(&argc, argv);
  if (benchmark::ReportUnrecognizedArguments(argc, argv)) return 2;
  alidade::registerFootage();
  alidade::MedianReporter reporter;
  benchmark::RunSpecifiedBenchmarks(&reporter);
  return 0;
}
