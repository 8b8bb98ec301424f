// SPDX-License-Identifier: MIT
// Diagnosis checkerboards, from JPEG file to refined corners, beside OpenCV on the same files in the same
// run.
#include <sys/resource.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <ctime>
#include <filesystem>
#include <functional>
#include <string>
#include <vector>

#include <opencv2/calib3d.hpp>
#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>

#include "alidade/core/random.h"
#include "alidade/detect/detect_images.h"
#include "alidade/imagery/image_file.h"
#include "alidade/simulate/random_views.h"
#include "alidade/simulate/render.h"

namespace alidade {
namespace {

namespace fs = std::filesystem;

const Checkerboard kBoard{.columns = 9, .rows = 6, .square_m = 0.025};
constexpr ImageSize kSizes[] = {
    {.width = 640, .height = 480}, {.width = 1920, .height = 1200}, {.width = 4000, .height = 3000}};
constexpr int kNumViews = 3;

double cpuMilliseconds() {
  timespec t{};
  clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &t);
  return 1e3 * static_cast<double>(t.tv_sec) + 1e-6 * static_cast<double>(t.tv_nsec);
}

double medianTime(int repetitions, const std::function<void()>& work) {
  std::vector<double> times;
  for (int r = 0; r < repetitions; ++r) {
    const double start = cpuMilliseconds();
    work();
    times.push_back(cpuMilliseconds() - start);
  }
  std::sort(times.begin(), times.end());
  return times[times.size() / 2];
}

void writeJpeg(const std::string& path, const GrayImage& image) {
  const cv::Mat mat(image.size.height, image.size.width, CV_8U,
                    const_cast<std::uint8_t*>(image.pixels.data()));
  cv::imwrite(path, mat, {cv::IMWRITE_JPEG_QUALITY, 92});
}

std::vector<std::string> writeBoards(const fs::path& folder, ImageSize size) {
  const double f = 0.85 * size.width;
  const std::vector<double> params = {f,     f,    0.5 * size.width, 0.5 * size.height, -0.28, 0.08, 8e-4,
                                      -4e-4, -0.01};
  const AnyCamera camera = AnyCamera::make("radtan", params);
  Random random(7);
  const Renderer renderer(camera, size);
  std::vector<std::string> paths;
  int i = 0;
  for (const SE3& pose : randomViews(camera, size, kBoard, kNumViews, random)) {
    RenderOptions options;
    options.blur_px = 1;
    options.read_noise = 3;
    options.seed = static_cast<std::uint64_t>(i);
    paths.push_back(
        (folder / ("board_" + std::to_string(size.width) + "_" + std::to_string(i++) + ".jpg")).string());
    writeJpeg(paths.back(), renderer.render(kBoard, pose, options));
  }
  return paths;
}

// A picture with detail of all sizes and no board: octaves of noise, some of it in hard edges.
std::vector<std::string> writeTextures(const fs::path& folder, ImageSize size) {
  std::vector<std::string> paths;
  for (int i = 0; i < kNumViews; ++i) {
    cv::RNG rng(static_cast<std::uint64_t>(i + 1));
    cv::Mat sum = cv::Mat::zeros(size.height, size.width, CV_32F);
    for (int cell = size.width / 4; cell >= 2; cell /= 2) {
      cv::Mat noise(size.height / cell + 2, size.width / cell + 2, CV_32F);
      rng.fill(noise, cv::RNG::NORMAL, 0.0, std::sqrt(static_cast<double>(cell)));
      cv::Mat octave;
      const int interpolation = (cell & 4) != 0 ? cv::INTER_NEAREST : cv::INTER_CUBIC;
      cv::resize(noise, octave, sum.size(), 0, 0, interpolation);
      sum += octave;
    }
    cv::normalize(sum, sum, 0, 255, cv::NORM_MINMAX);
    cv::Mat gray;
    sum.convertTo(gray, CV_8U);
    paths.push_back(
        (folder / ("texture_" + std::to_string(size.width) + "_" + std::to_string(i) + ".jpg")).string());
    cv::imwrite(paths.back(), gray, {cv::IMWRITE_JPEG_QUALITY, 92});
  }
  return paths;
}

bool opencvClassic(const std::string& path) {
  const cv::Mat image = cv::imread(path, cv::IMREAD_GRAYSCALE);
  std::vector<cv::Point2f> corners;
  if (!cv::findChessboardCorners(image, {kBoard.columns, kBoard.rows}, corners,
                                 cv::CALIB_CB_ADAPTIVE_THRESH | cv::CALIB_CB_NORMALIZE_IMAGE))
    return false;
  cv::cornerSubPix(image, corners, {5, 5}, {-1, -1},
                   {cv::TermCriteria::COUNT | cv::TermCriteria::EPS, 30, 0.01});
  return true;
}

bool opencvSectors(const std::string& path) {
  const cv::Mat image = cv::imread(path, cv::IMREAD_GRAYSCALE);
  std::vector<cv::Point2f> corners;
  if (!cv::findChessboardCornersSB(image, {kBoard.columns, kBoard.rows}, corners)) return false;
  cv::cornerSubPix(image, corners, {5, 5}, {-1, -1},
                   {cv::TermCriteria::COUNT | cv::TermCriteria::EPS, 30, 0.01});
  return true;
}

void compare(const char* what, const std::vector<std::string>& paths, ImageSize size) {
  const bool is_large = size.width > 3000;
  const double n = static_cast<double>(paths.size());
  int found[3] = {0, 0, 0};
  const auto each = [&](int repetitions, int* count, const std::function<bool(const std::string&)>& work) {
    return medianTime(repetitions,
                      [&] {
                        if (count != nullptr) *count = 0;
                        for (const std::string& path : paths) {
                          const bool is_found = work(path);
                          if (count != nullptr) *count += is_found ? 1 : 0;
                        }
                      }) /
           n;
  };
  const double decode = each(
      7, nullptr, [](const std::string& path) { return !cv::imread(path, cv::IMREAD_GRAYSCALE).empty(); });
  const double ours = each(7, &found[0], [](const std::string& path) {
    return findBoard(readGrayImage(path).image, kBoard).hasCorners();
  });
  const double sectors = each(is_large ? 1 : 3, &found[1], opencvSectors);
  const double classic = each(is_large ? 1 : 3, &found[2], opencvClassic);
  std::printf("%4dx%-4d %-8s %8.2f %8.2f (%4.1f x) %9.1f (%5.1f x) %9.1f (%5.1f x)   %d %d %d of %zu\n",
              size.width, size.height, what, decode, ours, ours / decode, sectors, sectors / ours, classic,
              classic / ours, found[0], found[1], found[2], paths.size());
}

double wallMilliseconds(const std::vector<std::string>& paths, int jobs) {
  std::vector<double> times;
  for (int r = 0; r < 3; ++r) {
    const auto start = std::chrono::steady_clock::now();
    DetectImagesOptions options;
    options.num_jobs = jobs;
    (void)detectInImages(paths, readGrayImage, kBoard, options);
    times.push_back(
        std::chrono::duration<double, std::milli>(std::chrono::steady_clock::now() - start).count());
  }
  return *std::min_element(times.begin(), times.end());
}

long peakMegabytes() {
  rusage usage{};
  getrusage(RUSAGE_SELF, &usage);
  return usage.ru_maxrss / 1024;
}

int run(int num_memory_images) {
  useOneThreadPerImage();
  const fs::path folder = fs::temp_directory_path() / "alidade_detect_bench";
  fs::create_directories(folder);
  if (num_memory_images > 0) {
    // Alone in its process, so that the peak is that of detection: the renderer needs more.
    std::vector<std::string> paths;
    for (int i = 0; i < num_memory_images; ++i)
      paths.push_back((folder / ("board_4000_" + std::to_string(i % kNumViews) + ".jpg")).string());
    if (!fs::exists(paths.front())) {
      std::fprintf(stderr, "run without an argument first: it writes the images\n");
      return 1;
    }
    const auto outcomes = detectInImages(paths, readGrayImage, kBoard);
    const auto num_found = std::count_if(outcomes.begin(), outcomes.end(),
                                         [](const ImageOutcome& o) { return o.detection.hasCorners(); });
    std::printf("%d images of 4000x3000, all threads: %ld found, peak memory %ld MB\n", num_memory_images,
                static_cast<long>(num_found), peakMegabytes());
    return 0;
  }
  std::printf(
      "CPU ms an image, one thread, from JPEG file to refined corners; in brackets times decoding, and times "
      "ours\n");
  std::printf(
      "size      shows      decode     ours            SB + refine         findChessboard + refine  found\n");
  for (const ImageSize& size : kSizes) {
    compare("board", writeBoards(folder, size), size);
    compare("texture", writeTextures(folder, size), size);
  }
  std::vector<std::string> many;
  for (int i = 0; i < 24; ++i)
    many.push_back((folder / ("board_4000_" + std::to_string(i % kNumViews) + ".jpg")).string());
  const double one = wallMilliseconds(many, 1);
  const double two = wallMilliseconds(many, 2);
  std::printf("24 images of 4000x3000: one thread %.0f ms, two threads %.0f ms, %.2f times as fast\n", one,
              two, one / two);
  return 0;
}

}  // namespace
}  // namespace alidade

int main(int argc, char** argv) {
  return alidade::run(argc > 1 ? std::atoi(argv[1]) : 0);
}
