// SPDX-License-Identifier: MIT
// Projection of points and unprojection of pixels against OpenCV's functions for the same models, one thread.
#include <cstdint>
#include <cstdio>
#include <string>
#include <string_view>
#include <vector>

#include <benchmark/benchmark.h>
#include <opencv2/calib3d.hpp>

#include "alidade/camera/any_camera.h"
#include "alidade/core/error.h"
#include "alidade/core/random.h"
#include "median_reporter.h"

namespace alidade {
namespace {

constexpr ImageSize kSize{1920, 1200};
constexpr std::size_t kNumPoints = 100000;
constexpr int kRepetitions = 5;

// A camera, pixels all over its image, and for each a point of its ray: each side has its truth in the other.
struct Scene {
  AnyCamera camera;
  std::vector<Eigen::Vector2d> pixels;
  std::vector<Eigen::Vector3d> points;
};

Scene makeScene(std::string_view model) {
  std::vector<double> params = {1003, 1001, 955, 604};
  if (model == "radtan") params.insert(params.end(), {-0.2, 0.08, 5e-4, -4e-4, -0.01});
  Scene scene{AnyCamera::make(model, params), {}, {}};
  Random random(1);
  while (scene.points.size() < kNumPoints) {
    const Eigen::Vector2d pixel(random.uniform(-0.5, kSize.width - 0.5),
                                random.uniform(-0.5, kSize.height - 0.5));
    const auto ray = scene.camera.unproject(pixel);
    expect(ray.has_value(), "every pixel of the benchmark's image has a ray");
    scene.pixels.push_back(pixel);
    scene.points.emplace_back(random.uniform(0.5, 5) * *ray);
  }
  return scene;
}

const Scene& sceneOf(const std::string& model) {
  static const Scene pinhole = makeScene("pinhole");
  static const Scene radtan = makeScene("radtan");
  return model == "pinhole" ? pinhole : radtan;
}

cv::Mat openCvMatrix(const Scene& scene) {
  const auto p = scene.camera.parameters();
  return (cv::Mat_<double>(3, 3) << p[0], 0, p[2], 0, p[1], p[3], 0, 0, 1);
}

cv::Mat openCvDistortion(const Scene& scene) {
  const auto lens = scene.camera.parameters().subspan(4);
  return cv::Mat(std::vector<double>(lens.begin(), lens.end()), true);
}

template <class From, class To>
std::vector<To> copyAs(const std::vector<From>& from) {
  std::vector<To> to;
  for (const From& item : from) {
    if constexpr (From::SizeAtCompileTime == 2) {
      to.emplace_back(item.x(), item.y());
    } else {
      to.emplace_back(item.x(), item.y(), item.z());
    }
  }
  return to;
}

// Points a second, and the largest error in pixels, which shows a fast but wrong answer. `pixelOf(i)` is the
// pixel that answer i stands for.
template <class PixelOf>
void setCounters(benchmark::State& state, const Scene& scene, const PixelOf& pixelOf) {
  double worst = 0;
  for (std::size_t i = 0; i < kNumPoints; ++i) {
    const double error = (pixelOf(i) - scene.pixels[i]).norm();
    worst = error <= worst ? worst : error;  // a NaN stays
  }
  state.counters["max_error_px"] = worst;
  state.SetItemsProcessed(state.iterations() * static_cast<std::int64_t>(kNumPoints));
}

void projectAlidade(benchmark::State& state, const Scene& scene) {
  std::vector<Projection> out(kNumPoints);
  for (auto _ : state) {
    scene.camera.project(scene.points, out);
    benchmark::DoNotOptimize(out.data());
    benchmark::ClobberMemory();
  }
  setCounters(state, scene, [&](std::size_t i) { return out[i].pixel; });
}

void projectOpenCv(benchmark::State& state, const Scene& scene) {
  const auto points = copyAs<Eigen::Vector3d, cv::Point3d>(scene.points);
  const cv::Mat K = openCvMatrix(scene);
  const cv::Mat distortion = openCvDistortion(scene);
  std::vector<cv::Point2d> out;
  for (auto _ : state) {
    cv::projectPoints(points, cv::Vec3d(), cv::Vec3d(), K, distortion, out);
    benchmark::DoNotOptimize(out.data());
    benchmark::ClobberMemory();
  }
  setCounters(state, scene, [&](std::size_t i) { return Eigen::Vector2d(out[i].x, out[i].y); });
}

void unprojectAlidade(benchmark::State& state, const Scene& scene) {
  std::vector<Eigen::Vector3d> out(kNumPoints);
  for (auto _ : state) {
    for (std::size_t i = 0; i < kNumPoints; ++i)
      out[i] = scene.camera.unproject(scene.pixels[i]).value_or(Eigen::Vector3d::Zero());
    benchmark::DoNotOptimize(out.data());
    benchmark::ClobberMemory();
  }
  setCounters(state, scene, [&](std::size_t i) { return scene.camera.project(out[i]).pixel; });
}

void unprojectOpenCv(benchmark::State& state, const Scene& scene, const cv::TermCriteria& criteria) {
  const auto pixels = copyAs<Eigen::Vector2d, cv::Point2d>(scene.pixels);
  const cv::Mat K = openCvMatrix(scene);
  const cv::Mat distortion = openCvDistortion(scene);
  std::vector<cv::Point2d> out;
  for (auto _ : state) {
    cv::undistortPoints(pixels, out, K, distortion, cv::noArray(), cv::noArray(), criteria);
    benchmark::DoNotOptimize(out.data());
    benchmark::ClobberMemory();
  }
  setCounters(state, scene, [&](std::size_t i) {
    return scene.camera.project(Eigen::Vector3d(out[i].x, out[i].y, 1)).pixel;
  });
}

void registerModel(const std::string& model) {
  const auto add = [](const std::string& name, auto run) {
    benchmark::RegisterBenchmark(name.c_str(), run)
        ->Unit(benchmark::kMillisecond)
        ->Repetitions(kRepetitions)
        ->ReportAggregatesOnly();
  };
  const auto add_opencv_unproject = [&](const std::string& variant, const cv::TermCriteria& criteria) {
    add("unproject/" + model + "/opencv_" + variant,
        [=](benchmark::State& state) { unprojectOpenCv(state, sceneOf(model), criteria); });
  };
  add("project/" + model + "/alidade", [=](benchmark::State& s) { projectAlidade(s, sceneOf(model)); });
  add("project/" + model + "/opencv", [=](benchmark::State& s) { projectOpenCv(s, sceneOf(model)); });
  add("unproject/" + model + "/alidade", [=](benchmark::State& s) { unprojectAlidade(s, sceneOf(model)); });
  add_opencv_unproject("default", {cv::TermCriteria::COUNT, 5, 0.01});
  add_opencv_unproject("converged", {cv::TermCriteria::COUNT + cv::TermCriteria::EPS, 100, 1e-12});
}

void printSummary(const MedianReporter& reporter) {
  for (const char* model : {"pinhole", "radtan"}) {
    for (const char* variant :
         {"project/%s/opencv", "unproject/%s/opencv_default", "unproject/%s/opencv_converged"}) {
      char opencv[64];
      std::snprintf(opencv, sizeof opencv, variant, model);
      const std::string name = opencv;
      const auto ratio = reporter.ratio(name, name.substr(0, name.rfind('/')) + "/alidade");
      if (ratio) std::printf("%s takes %.3g times as long as alidade\n", opencv, *ratio);
    }
  }
}

}  // namespace
}  // namespace alidade

int main(int argc, char** argv) {
  benchmark::Initialize(&argc, argv);
  if (benchmark::ReportUnrecognizedArguments(argc, argv)) return 2;
  cv::setNumThreads(1);
  for (const char* model : {"pinhole", "radtan"}) alidade::registerModel(model);
  alidade::MedianReporter reporter;
  benchmark::RunSpecifiedBenchmarks(&reporter);
  alidade::printSummary(reporter);
  return 0;
}
