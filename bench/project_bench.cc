// SPDX-License-Identifier: MIT
// Batch projection of points and unprojection of pixels, compared with OpenCV's functions for the same models
// and with plain loops over arrays, which are a lower bound for the arithmetic; one thread.
#include <cmath>
#include <cstdint>
#include <cstdio>
#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include <benchmark/benchmark.h>
#include <opencv2/calib3d.hpp>

#include "alidade/camera/any_camera.h"
#include "alidade/camera/batch.h"
#include "alidade/core/error.h"
#include "alidade/core/random.h"
#include "median_reporter.h"
#include "plain_loops.h"

namespace alidade {
namespace {

constexpr ImageSize kSize{1920, 1200};
constexpr std::size_t kNumPoints = 1000000;
constexpr int kRepetitions = 5;

struct Columns {
  std::vector<double> x, y, z;

  explicit Columns(std::size_t n) : x(n), y(n), z(n) {}
  [[nodiscard]] Eigen::Vector3d at(std::size_t i) const { return {x[i], y[i], z[i]}; }
  void set(std::size_t i, const Eigen::Vector3d& p) {
    x[i] = p.x();
    y[i] = p.y();
    z[i] = p.z();
  }
};

std::vector<double> paramsOf(std::string_view model) {
  if (model == "pinhole") return {1003, 1001, 955, 604};
  if (model == "radtan") return {1003, 1001, 955, 604, -0.2, 0.08, 5e-4, -4e-4, -0.01};
  if (model == "rational") return {1003, 1001, 955, 604, -0.2, 0.08, 5e-4, -4e-4, -0.01, 0.01, 0.01, 1e-3};
  if (model == "thin_prism")
    return {1003, 1001, 955, 604, -0.2, 0.08, 5e-4, -4e-4, -0.01, 0.01, 0.01, 1e-3, 1e-3, 1e-4, -1e-3, 1e-4};
  if (model == "brown") return {1003, 1001, 955, 604, -0.2, 0.08, 5e-4, -4e-4, -0.01, 1e-3, 1e-4};
  if (model == "inverse_brown") return {1003, 1001, 955, 604, 0.2, -0.05, 5e-4, -4e-4, 0.01};
  if (model == "tilted")
    return {1003, 1001, 955,  604,  -0.2, 0.08,  5e-4, -4e-4,  -0.01,
            0.01, 0.01, 1e-3, 1e-3, 1e-4, -1e-3, 1e-4, -0.025, -0.006};
  if (model == "division") return {900, 901, 955, 604, -0.25, 0};
  if (model == "kannala_brandt") return {750, 751, 955, 604, 0.04275, -0.05002, 0.01984, -0.00294};
  if (model == "kannala_brandt_skew") return {750, 751, 955, 604, 0.04275, -0.05002, 0.01984, -0.00294, 1e-3};
  if (model == "thin_prism_fisheye")
    return {750, 751, 955, 604, 0.04275, -0.05002, 0.01984, -0.00294, 5e-4, -4e-4, 1e-3, -1e-3};
  if (model == "fisheye624")
    return {750,  751,   955,  604,   0.04275, -0.05002, 0.01984, -0.00294,
            1e-4, -1e-5, 5e-4, -4e-4, 1e-3,    1e-4,     -1e-3,   1e-4};
  if (model == "ftheta") return {650, 651, 955, 604, -0.02, 0.05, -0.02, 0.01, 0};
  if (model == "ftheta_inverse") return {650, 651, 955, 604, 0.003, 0.02, -0.004, 0.012, -0.002};
  if (model == "ocam") return {650, 651, 955, 604, -0.251, 0.049, -0.027, 0, 0, 1e-4, -3e-4};
  if (model == "fov") return {900, 901, 955, 604, 0.9};
  if (model == "ucm") return {600, 601, 955, 604, 0.6};
  if (model == "omni") return {1500, 1501, 955, 604, 1.2, -0.1, 0.02, 1e-3, -1e-3};
  if (model == "eucm") return {600, 601, 955, 604, 0.6, 1.1};
  expect(model == "double_sphere", "each model has parameters here");
  return {600, 601, 955, 604, -0.2, 0.6};
}

// A camera, pixels all over its image, and for each a point on its ray in a separate frame: each side is the
// truth for the other.
struct Scene {
  AnyCamera camera;
  SE3 camera_from_points{.rotation = SO3::exp({0.1, -0.2, 0.3}), .translation = {0.05, -0.02, 0.1}};
  std::vector<double> u, v;
  Columns points;

  explicit Scene(std::string_view model)
      : camera(AnyCamera::make(model, paramsOf(model))), u(kNumPoints), v(kNumPoints), points(kNumPoints) {
    Random random(1);
    const SE3 points_from_camera = camera_from_points.inverse();
    for (std::size_t i = 0; i < kNumPoints; ++i) {
      u[i] = random.uniform(-0.5, kSize.width - 0.5);
      v[i] = random.uniform(-0.5, kSize.height - 0.5);
      const auto ray = camera.unproject({u[i], v[i]});
      expect(ray.has_value(), "every pixel of the benchmark's image has a ray");
      points.set(i, points_from_camera * Eigen::Vector3d(random.uniform(0.5, 5) * *ray));
    }
  }
};

// One at a time, because a million points of ten models need much memory.
const Scene& sceneOf(const std::string& model) {
  static std::string name;
  static std::unique_ptr<Scene> scene;
  if (name != model) scene = std::make_unique<Scene>(model);
  name = model;
  return *scene;
}

cv::Mat openCvMatrix(const Scene& scene) {
  const auto p = scene.camera.parameters();
  return cv::Mat(cv::Matx33d(p[0], 0, p[2], 0, p[1], p[3], 0, 0, 1));
}

cv::Mat openCvDistortion(const Scene& scene) {
  const auto lens = scene.camera.parameters().subspan(4);
  return cv::Mat(std::vector<double>(lens.begin(), lens.end()), true);
}

// Points per second, and the largest error in pixels, which reveals a fast but wrong answer. `pixelOf(i)` is
// the pixel for answer i.
template <class PixelOf>
void setCounters(benchmark::State& state, const Scene& scene, const PixelOf& pixelOf) {
  double worst = 0;
  for (std::size_t i = 0; i < kNumPoints; ++i) {
    const double error = (pixelOf(i) - Eigen::Vector2d(scene.u[i], scene.v[i])).norm();
    worst = error <= worst ? worst : error;  // a NaN stays
  }
  state.counters["max_error_px"] = worst;
  state.SetItemsProcessed(state.iterations() * static_cast<std::int64_t>(kNumPoints));
}

void projectAlidade(benchmark::State& state, const Scene& scene, bool with_jacobians) {
  const auto& p = scene.points;
  std::vector<double> u(kNumPoints);
  std::vector<double> v(kNumPoints);
  std::vector<ProjectStatus> status(kNumPoints);
  const std::size_t num_params = scene.camera.parameters().size();
  std::vector<double> by_pose(with_jacobians ? 12 * kNumPoints : 0);
  std::vector<double> by_params(with_jacobians ? 2 * num_params * kNumPoints : 0);
  const PixelJacobians jacobians =
      with_jacobians ? PixelJacobians{nullptr, by_pose.data(), by_params.data()} : PixelJacobians{};
  for (auto _ : state) {
    projectBatch(scene.camera, scene.camera_from_points, {p.x, p.y, p.z}, {u, v, status}, jacobians);
    benchmark::ClobberMemory();
  }
  setCounters(state, scene, [&](std::size_t i) { return Eigen::Vector2d(u[i], v[i]); });
}

void projectOpenCv(benchmark::State& state, const Scene& scene, bool with_jacobians) {
  std::vector<cv::Point3d> points;
  for (std::size_t i = 0; i < kNumPoints; ++i)
    points.emplace_back(scene.points.x[i], scene.points.y[i], scene.points.z[i]);
  const Eigen::Vector3d w = scene.camera_from_points.rotation.log();
  const Eigen::Vector3d t = scene.camera_from_points.translation;
  const cv::Vec3d rotation(w.x(), w.y(), w.z());
  const cv::Vec3d translation(t.x(), t.y(), t.z());
  const cv::Mat K = openCvMatrix(scene);
  const cv::Mat distortion = openCvDistortion(scene);
  const bool is_fisheye = scene.camera.modelId() == "kannala_brandt";
  std::vector<cv::Point2d> out;
  cv::Mat jacobian;
  for (auto _ : state) {
    if (is_fisheye) {
      cv::fisheye::projectPoints(points, out, rotation, translation, K, distortion, 0,
                                 with_jacobians ? cv::OutputArray(jacobian) : cv::noArray());
    } else {
      cv::projectPoints(points, rotation, translation, K, distortion, out,
                        with_jacobians ? cv::OutputArray(jacobian) : cv::noArray());
    }
    benchmark::ClobberMemory();
  }
  setCounters(state, scene, [&](std::size_t i) { return Eigen::Vector2d(out[i].x, out[i].y); });
}

void projectPlain(benchmark::State& state, const Scene& scene) {
  const auto& p = scene.points;
  std::vector<double> u(kNumPoints);
  std::vector<double> v(kNumPoints);
  const Eigen::Matrix<double, 3, 3, Eigen::RowMajor> R = scene.camera_from_points.rotation.matrix();
  for (auto _ : state) {
    plainProjectRadtan(scene.camera.parameters().data(), R.data(),
                       scene.camera_from_points.translation.data(), p.x.data(), p.y.data(), p.z.data(),
                       kNumPoints, u.data(), v.data());
    benchmark::ClobberMemory();
  }
  setCounters(state, scene, [&](std::size_t i) { return Eigen::Vector2d(u[i], v[i]); });
}

void unprojectAlidade(benchmark::State& state, const Scene& scene) {
  Columns rays(kNumPoints);
  std::vector<ProjectStatus> status(kNumPoints);
  for (auto _ : state) {
    unprojectBatch(scene.camera, {scene.u, scene.v}, {rays.x, rays.y, rays.z, status});
    benchmark::ClobberMemory();
  }
  setCounters(state, scene, [&](std::size_t i) { return scene.camera.project(rays.at(i)).pixel; });
}

void unprojectPlain(benchmark::State& state, const Scene& scene) {
  std::vector<double> x(kNumPoints);
  std::vector<double> y(kNumPoints);
  for (auto _ : state) {
    plainUnprojectRadtan(scene.camera.parameters().data(), scene.u.data(), scene.v.data(), kNumPoints,
                         x.data(), y.data());
    benchmark::ClobberMemory();
  }
  setCounters(state, scene, [&](std::size_t i) { return scene.camera.project({x[i], y[i], 1}).pixel; });
}

void unprojectOpenCv(benchmark::State& state, const Scene& scene, const cv::TermCriteria& criteria) {
  std::vector<cv::Point2d> pixels;
  for (std::size_t i = 0; i < kNumPoints; ++i) pixels.emplace_back(scene.u[i], scene.v[i]);
  const cv::Mat K = openCvMatrix(scene);
  const cv::Mat distortion = openCvDistortion(scene);
  const bool is_fisheye = scene.camera.modelId() == "kannala_brandt";
  std::vector<cv::Point2d> out;
  for (auto _ : state) {
    if (is_fisheye) {
      cv::fisheye::undistortPoints(pixels, out, K, distortion, cv::noArray(), cv::noArray(), criteria);
    } else {
      cv::undistortPoints(pixels, out, K, distortion, cv::noArray(), cv::noArray(), criteria);
    }
    benchmark::ClobberMemory();
  }
  setCounters(state, scene, [&](std::size_t i) {
    return scene.camera.project({out[i].x, out[i].y, 1}).pixel;
  });
}

template <class Run>
void add(const std::string& model, const std::string& name, const Run& run) {
  benchmark::RegisterBenchmark((model + "/" + name).c_str(),
                               [=](benchmark::State& state) { run(state, sceneOf(model)); })
      ->Unit(benchmark::kMillisecond)
      ->Repetitions(kRepetitions)
      ->ReportAggregatesOnly();
}

void registerModel(const std::string& model) {
  using benchmark::State;
  const cv::TermCriteria by_default(cv::TermCriteria::COUNT, 5, 0.01);
  const cv::TermCriteria exactly(cv::TermCriteria::COUNT + cv::TermCriteria::EPS, 500, 1e-9);
  const bool is_in_opencv = model == "pinhole" || model == "radtan" || model == "rational" ||
                            model == "thin_prism" || model == "tilted" || model == "kannala_brandt";
  add(model, "project/alidade", [](State& s, const Scene& c) { projectAlidade(s, c, false); });
  if (is_in_opencv)
    add(model, "project/opencv", [](State& s, const Scene& c) { projectOpenCv(s, c, false); });
  if (model == "radtan") add(model, "project/plain", projectPlain);
  add(model, "jacobians/alidade", [](State& s, const Scene& c) { projectAlidade(s, c, true); });
  if (is_in_opencv)
    add(model, "jacobians/opencv", [](State& s, const Scene& c) { projectOpenCv(s, c, true); });
  add(model, "unproject/alidade", unprojectAlidade);
  if (is_in_opencv) {
    add(model, "unproject/opencv_exact", [=](State& s, const Scene& c) { unprojectOpenCv(s, c, exactly); });
    add(model, "unproject/opencv_default",
        [=](State& s, const Scene& c) { unprojectOpenCv(s, c, by_default); });
  }
  if (model == "radtan") add(model, "unproject/plain", unprojectPlain);
}

void printSummary(const MedianReporter& reporter) {
  const auto print = [&](const std::string& slow, const std::string& fast, const char* words) {
    const auto ratio = reporter.ratio(slow, fast);
    if (ratio) std::printf("%-36s %s %.3g times as long as %s\n", slow.c_str(), words, *ratio, fast.c_str());
  };
  for (const std::string& model : modelIds()) {
    for (const char* variant : {"project/opencv", "jacobians/opencv", "unproject/opencv_exact",
                                "unproject/opencv_default", "project/plain", "unproject/plain"}) {
      const std::string name = model + "/" + variant;
      print(name, name.substr(0, name.rfind('/')) + "/alidade", "takes");
    }
    for (const char* variant : {"/project/alidade", "/jacobians/alidade", "/unproject/alidade"})
      if (model != "radtan") print(model + variant, std::string("radtan") + variant, "takes");
  }
}

}  // namespace
}  // namespace alidade

int main(int argc, char** argv) {
  benchmark::Initialize(&argc, argv);
  if (benchmark::ReportUnrecognizedArguments(argc, argv)) return 2;
  cv::setNumThreads(1);
  for (const std::string& model : alidade::modelIds()) alidade::registerModel(model);
  alidade::MedianReporter reporter;
  benchmark::RunSpecifiedBenchmarks(&reporter);
  alidade::printSummary(reporter);
  return 0;
}
