// SPDX-License-Identifier: MIT
// Undistortion maps against OpenCV's, one thread.
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include <benchmark/benchmark.h>
#include <opencv2/calib3d.hpp>
#include <opencv2/imgproc.hpp>

#include "alidade/camera/any_camera.h"
#include "alidade/camera/lens_shapes.h"
#include "alidade/core/error.h"
#include "alidade/imagery/remap.h"
#include "alidade/imagery/undistortion_view.h"
#include "median_reporter.h"

namespace alidade {
namespace {

constexpr ImageSize kSize{1920, 1200};
constexpr int kRepetitions = 9;

struct Case {
  std::string name;
  AnyCamera camera;
  OutputView view;
};

std::vector<double> paramsOf(std::string_view model) {
  if (model == "pinhole") return {1003, 1001, 955, 604};
  if (model == "radtan") return {1003, 1001, 955, 604, -0.2, 0.08, 5e-4, -4e-4, -0.01};
  if (model == "rational") return {1003, 1001, 955, 604, 0.35, 0.05, 5e-4, -4e-4, 0.01, 0.68, 0.12, 0.005};
  if (model == "thin_prism")
    return {1003, 1001, 955, 604, 0.35, 0.05, 5e-4, -4e-4, 0.01, 0.68, 0.12, 0.005, 1e-3, -2e-4, -8e-4, 3e-4};
  if (model == "kannala_brandt") return {560, 559, 955, 604, -0.012, 0.004, -0.003, 0.0006};
  if (model == "fov") return {600, 601, 955, 604, 0.93};
  if (model == "ucm") return {500, 501, 955, 604, 0.62};
  if (model == "omni") return {1300, 1302, 955, 604, 1.2, -0.15, 0.05, 1e-3, -8e-4};
  if (model == "eucm") return {480, 481, 955, 604, 0.6, 1.1};
  if (model == "double_sphere") return {400, 401, 955, 604, -0.2, 0.6};
  return startParameters(model, 500, {.width = 1920, .height = 1200});
}

Case makeCase(const std::string& model, ViewProjection projection, ViewExtent extent) {
  const AnyCamera camera = AnyCamera::make(model, paramsOf(model));
  const ViewRequest request{.projection = projection, .extent = extent, .size = {}};
  std::string name = model + "/" + std::string(projectionName(projection));
  if (extent == ViewExtent::kAll) name += "_all";
  return {name, camera, chooseView(camera, kSize, request).view};
}

const Case& plain(const std::string& model) {
  static const Case radtan = makeCase("radtan", ViewProjection::kRectilinear, ViewExtent::kSameScale);
  static const Case fisheye =
      makeCase("kannala_brandt", ViewProjection::kRectilinear, ViewExtent::kSameScale);
  return model == "radtan" ? radtan : fisheye;
}

// The largest error of positions against the exact projection, over one pixel in seven.
template <class PlaceOf>
double largestError(const Case& c, const PlaceOf& place_of) {
  double worst = 0;
  for (int y = 0; y < kSize.height; ++y) {
    for (int x = y % 7; x < kSize.width; x += 7) {
      const auto ray = c.view.rayFromPixel({x, y});
      const Projection exact = ray ? c.camera.project(*ray) : Projection{};
      const Eigen::Vector2d place = place_of(x, y);
      if (!exact.ok() || std::isnan(place.x())) continue;
      const double error = (place - exact.pixel).lpNorm<Eigen::Infinity>();
      worst = error <= worst ? worst : error;
    }
  }
  return worst;
}

void mapAlidade(benchmark::State& state, const Case& c) {
  RemapTable table;
  for (auto _ : state) {
    table = makeRemapTable(c.camera, kSize, c.view);
    benchmark::DoNotOptimize(table.pixels.data());
    benchmark::ClobberMemory();
  }
  state.counters["max_error_px"] =
      largestError(c, [&](int x, int y) { return Eigen::Vector2d(table.at(x, y).x, table.at(x, y).y); });
}

cv::Mat matrixOf(double fx, double fy, double cx, double cy) {
  return cv::Mat(cv::Matx33d(fx, 0, cx, 0, fy, cy, 0, 0, 1));
}

struct OpenCvMaps {
  cv::Mat first;
  cv::Mat second;
};

void openCvMaps(const Case& c, int type, OpenCvMaps& maps) {
  const auto p = c.camera.parameters();
  const cv::Mat K = matrixOf(p[0], p[1], p[2], p[3]);
  const cv::Mat lens(std::vector<double>(p.begin() + 4, p.end()), true);
  const OutputView& v = c.view;
  const cv::Mat new_K = matrixOf(v.scale_px.x(), v.scale_px.y(), v.axis_px.x(), v.axis_px.y());
  const cv::Size size(kSize.width, kSize.height);
  if (c.camera.modelId() == "radtan") {
    cv::initUndistortRectifyMap(K, lens, cv::Mat(), new_K, size, type, maps.first, maps.second);
  } else {
    cv::fisheye::initUndistortRectifyMap(K, lens, cv::Matx33d::eye(), new_K, size, type, maps.first,
                                         maps.second);
  }
}

void mapOpenCv(benchmark::State& state, const Case& c, int type) {
  OpenCvMaps maps;
  for (auto _ : state) {
    maps = {};
    openCvMaps(c, type, maps);
    benchmark::DoNotOptimize(maps.first.data);
    benchmark::ClobberMemory();
  }
  state.counters["max_error_px"] = largestError(c, [&](int x, int y) {
    if (type == CV_32FC1) return Eigen::Vector2d(maps.first.at<float>(y, x), maps.second.at<float>(y, x));
    const auto place = maps.first.at<cv::Vec2f>(y, x);
    return Eigen::Vector2d(place[0], place[1]);
  });
}

template <class Run>
void add(const std::string& name, const Run& run) {
  benchmark::RegisterBenchmark(name.c_str(), run)
      ->Unit(benchmark::kMillisecond)
      ->MinTime(0.1)
      ->Repetitions(kRepetitions)
      ->ReportAggregatesOnly();
}

void registerAll() {
  for (const std::string model : {"radtan", "kannala_brandt"}) {
    const std::string name = "map/" + model + "/";
    add(name + "alidade", [=](auto& state) { mapAlidade(state, plain(model)); });
    add(name + "opencv_32FC1", [=](auto& state) { mapOpenCv(state, plain(model), CV_32FC1); });
    if (model == "radtan")
      add(name + "opencv_32FC2", [=](auto& state) { mapOpenCv(state, plain(model), CV_32FC2); });
  }
  for (const ViewProjection projection :
       {ViewProjection::kRectilinear, ViewProjection::kCylindrical, ViewProjection::kEquirectangular}) {
    for (const std::string& model : modelIds()) {
      const auto c = std::make_shared<Case>(makeCase(model, projection, ViewExtent::kAll));
      add("map_model/" + c->name, [c](auto& state) { mapAlidade(state, *c); });
    }
  }
}

void printSummary(const MedianReporter& reporter) {
  for (const std::string variant :
       {"radtan/opencv_32FC1", "radtan/opencv_32FC2", "kannala_brandt/opencv_32FC1"}) {
    const std::string opencv = "map/" + variant;
    const std::string alidade = "map/" + variant.substr(0, variant.find('/')) + "/alidade";
    if (const auto ratio = reporter.ratio(opencv, alidade))
      std::printf("%s takes %.3g times as long as %s\n", opencv.c_str(), *ratio, alidade.c_str());
  }
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
  alidade::printSummary(reporter);
  return 0;
}
