// SPDX-License-Identifier: MIT
// Undistortion maps and images against OpenCV's, one thread, and against a plain loop of the radtan formula.
#include <algorithm>
#include <cmath>
#include <cstdint>
#include <cstdio>
#include <memory>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include <benchmark/benchmark.h>
#include <opencv2/calib3d.hpp>
#include <opencv2/imgproc.hpp>

#include "alidade/camera/any_camera.h"
#include "alidade/core/error.h"
#include "alidade/core/random.h"
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
  throw usageError({.where = "undistort_bench",
                    .found = "model '" + std::string(model) + "'",
                    .expected = "a model that the benchmark has parameters for"});
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

// The largest error of places against the exact projection, over one pixel in seven.
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

void mapAlidade(benchmark::State& state, const Case& c, bool is_fresh) {
  RemapTable table = makeRemapTable(c.camera, kSize, c.view);
  for (auto _ : state) {
    if (is_fresh) table = {};
    fillRemapTable(c.camera, kSize, c.view, table);
    benchmark::DoNotOptimize(table.pixels.data());
    benchmark::ClobberMemory();
  }
  state.counters["max_error_px"] =
      largestError(c, [&](int x, int y) { return Eigen::Vector2d(table.at(x, y).x, table.at(x, y).y); });
}

cv::Mat matrixOf(double fx, double fy, double cx, double cy) {
  return (cv::Mat_<double>(3, 3) << fx, 0, cx, 0, fy, cy, 0, 0, 1);
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

void mapOpenCv(benchmark::State& state, const Case& c, int type, bool is_fresh) {
  OpenCvMaps maps;
  openCvMaps(c, type, maps);
  for (auto _ : state) {
    if (is_fresh) maps = {};
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

#if defined(__x86_64__)
__attribute__((target("avx2,fma")))
#endif
void fillFloor(const OutputView& view, std::span<const float> lens, std::span<const float> across,
               float* map_x, float* map_y) {
  const float fx = lens[0], fy = lens[1], cx = lens[2], cy = lens[3];
  const float k1 = lens[4], k2 = lens[5], p1 = lens[6], p2 = lens[7], k3 = lens[8];
  for (int row = 0; row < view.size.height; ++row, map_x += across.size(), map_y += across.size()) {
    const auto y = static_cast<float>(view.planeFromPixel({0, row}).y());
    for (std::size_t i = 0; i < across.size(); ++i) {
      const float x = across[i];
      const float r2 = x * x + y * y;
      const float a = 1 + r2 * (k1 + r2 * (k2 + r2 * k3));
      map_x[i] = fx * (x * a + 2 * p1 * x * y + p2 * (r2 + 2 * x * x)) + cx;
      map_y[i] = fy * (y * a + p1 * (r2 + 2 * y * y) + 2 * p2 * x * y) + cy;
    }
  }
}

// The least that the formula itself costs: floats, no domain, no border, two planes.
void mapFloor(benchmark::State& state, const Case& c) {
  const auto p = c.camera.parameters();
  const std::vector<float> lens(p.begin(), p.end());
  const auto width = static_cast<std::size_t>(kSize.width);
  const auto num_pixels = width * static_cast<std::size_t>(kSize.height);
  std::vector<float> across(width);
  for (std::size_t x = 0; x < width; ++x)
    across[x] = static_cast<float>(c.view.planeFromPixel({static_cast<double>(x), 0}).x());
  std::vector<float> map_x(num_pixels);
  std::vector<float> map_y(num_pixels);
  for (auto _ : state) {
    fillFloor(c.view, lens, across, map_x.data(), map_y.data());
    benchmark::DoNotOptimize(map_x.data());
    benchmark::DoNotOptimize(map_y.data());
    benchmark::ClobberMemory();
  }
  state.counters["max_error_px"] = largestError(c, [&](int x, int y) {
    const std::size_t i = static_cast<std::size_t>(y) * width + static_cast<std::size_t>(x);
    return Eigen::Vector2d(map_x[i], map_y[i]);
  });
}

// Waves and noise in three channels, of which the first `num_channels` are taken.
RasterImage picture(int num_channels) {
  RasterImage image{.size = kSize, .num_channels = num_channels, .bits_per_sample = 8, .bytes = {}};
  Random random(3);
  for (int y = 0; y < kSize.height; ++y) {
    for (int x = 0; x < kSize.width; ++x) {
      for (int c = 0; c < num_channels; ++c) {
        const double wave = std::sin(0.05 * x + 0.02 * c * y) + std::cos(0.03 * y);
        image.bytes.push_back(static_cast<std::uint8_t>(128 + 50 * wave + random.uniform(-10, 10)));
      }
    }
  }
  return image;
}

void remapAlidade(benchmark::State& state, int num_channels, Interpolation interpolation) {
  const Case& c = plain("radtan");
  const RemapTable table = makeRemapTable(c.camera, kSize, c.view);
  const RasterImage image = picture(num_channels);
  for (auto _ : state) {
    const RasterImage out = remap(table, image, interpolation);
    benchmark::DoNotOptimize(out.bytes.data());
    benchmark::ClobberMemory();
  }
}

void remapOpenCv(benchmark::State& state, int num_channels, int interpolation) {
  OpenCvMaps maps;
  openCvMaps(plain("radtan"), CV_32FC1, maps);
  RasterImage image = picture(num_channels);
  const cv::Mat source(kSize.height, kSize.width, CV_8UC(num_channels), image.bytes.data());
  for (auto _ : state) {
    cv::Mat out;  // a new one each time, as ours
    cv::remap(source, out, maps.first, maps.second, interpolation, cv::BORDER_CONSTANT);
    benchmark::DoNotOptimize(out.data);
    benchmark::ClobberMemory();
  }
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
  for (const bool is_fresh : {false, true}) {
    const std::string suffix = is_fresh ? "_fresh" : "";
    for (const std::string model : {"radtan", "kannala_brandt"}) {
      const std::string name = "map/" + model + "/";
      add(name + "alidade" + suffix, [=](auto& state) { mapAlidade(state, plain(model), is_fresh); });
      add(name + "opencv_32FC1" + suffix,
          [=](auto& state) { mapOpenCv(state, plain(model), CV_32FC1, is_fresh); });
      if (model == "radtan")
        add(name + "opencv_32FC2" + suffix,
            [=](auto& state) { mapOpenCv(state, plain(model), CV_32FC2, is_fresh); });
    }
  }
  add("map/radtan/floor", [](auto& state) { mapFloor(state, plain("radtan")); });
  for (const ViewProjection projection :
       {ViewProjection::kRectilinear, ViewProjection::kCylindrical, ViewProjection::kEquirectangular}) {
    for (const std::string& model : modelIds()) {
      const auto c = std::make_shared<Case>(makeCase(model, projection, ViewExtent::kAll));
      add("map_model/" + c->name, [c](auto& state) { mapAlidade(state, *c, false); });
    }
  }
  for (const int num_channels : {1, 3}) {
    const std::string name = "remap/channels_" + std::to_string(num_channels) + "/";
    add(name + "linear/alidade",
        [=](auto& state) { remapAlidade(state, num_channels, Interpolation::kLinear); });
    add(name + "linear/opencv", [=](auto& state) { remapOpenCv(state, num_channels, cv::INTER_LINEAR); });
    add(name + "cubic/alidade",
        [=](auto& state) { remapAlidade(state, num_channels, Interpolation::kCubic); });
    add(name + "cubic/opencv", [=](auto& state) { remapOpenCv(state, num_channels, cv::INTER_CUBIC); });
  }
}

void printSummary(const MedianReporter& reporter) {
  const auto print = [&](const std::string& slow, const std::string& fast) {
    if (const auto ratio = reporter.ratio(slow, fast))
      std::printf("%s takes %.3g times as long as %s\n", slow.c_str(), *ratio, fast.c_str());
  };
  for (const char* suffix : {"", "_fresh"}) {
    for (const std::string variant :
         {"radtan/opencv_32FC1", "radtan/opencv_32FC2", "kannala_brandt/opencv_32FC1"})
      print("map/" + variant + suffix, "map/" + variant.substr(0, variant.find('/')) + "/alidade" + suffix);
  }
  print("map/radtan/alidade", "map/radtan/floor");
  for (const std::string name : {"remap/channels_1/linear", "remap/channels_3/linear",
                                 "remap/channels_1/cubic", "remap/channels_3/cubic"})
    print(name + "/opencv", name + "/alidade");
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
