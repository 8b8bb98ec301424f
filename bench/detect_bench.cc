// SPDX-License-Identifier: MIT
// Boards of each kind, from JPEG file to refined corners, compared with OpenCV on the same files in the same
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

#include <fmt/format.h>
#include <opencv2/aruco.hpp>
#include <opencv2/aruco/charuco.hpp>
#include <opencv2/calib3d.hpp>
#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>

#include "alidade/core/random.h"
#include "alidade/detect/detect_images.h"
#include "alidade/imagery/image_file.h"
#include "alidade/print/ink_of_board.h"
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

// An OpenCV function that finds a target.
struct Peer {
  const char* name;
  std::function<bool(const cv::Mat&)> finds;
};

struct Target {
  const char* name;
  Board board;
  std::vector<Peer> peers;
};

std::vector<std::string> writeBoards(const fs::path& folder, ImageSize size, const Target& target) {
  const double f = 0.85 * size.width;
  const std::vector<double> params = {f,     f,    0.5 * size.width, 0.5 * size.height, -0.28, 0.08, 8e-4,
                                      -4e-4, -0.01};
  const AnyCamera camera = AnyCamera::make("radtan", params);
  Random random(7);
  const Renderer renderer(camera, size);
  std::vector<std::string> paths;
  for (const SE3& pose : randomViews(camera, size, target.board, kNumViews, random)) {
    RenderOptions options;
    options.blur_px = 1;
    options.read_noise = 3;
    options.seed = paths.size();
    paths.push_back((folder / fmt::format("{}_{}_{}.jpg", target.name, size.width, paths.size())).string());
    writeJpeg(paths.back(), renderer.render(inkOf(target.board), pose, options));
  }
  return paths;
}

// An image with detail at all scales but no board: octaves of noise, some with hard edges.
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
    paths.push_back((folder / fmt::format("texture_{}_{}.jpg", size.width, i)).string());
    cv::imwrite(paths.back(), gray, {cv::IMWRITE_JPEG_QUALITY, 92});
  }
  return paths;
}

void refineCorners(const cv::Mat& image, std::vector<cv::Point2f>& corners) {
  cv::cornerSubPix(image, corners, {5, 5}, {-1, -1},
                   {cv::TermCriteria::COUNT | cv::TermCriteria::EPS, 30, 0.01});
}

bool findClassic(const cv::Mat& image) {
  std::vector<cv::Point2f> corners;
  if (!cv::findChessboardCorners(image, {kBoard.columns, kBoard.rows}, corners,
                                 cv::CALIB_CB_ADAPTIVE_THRESH | cv::CALIB_CB_NORMALIZE_IMAGE))
    return false;
  refineCorners(image, corners);
  return true;
}

bool findSectors(const cv::Mat& image) {
  std::vector<cv::Point2f> corners;
  if (!cv::findChessboardCornersSB(image, {kBoard.columns, kBoard.rows}, corners)) return false;
  refineCorners(image, corners);
  return true;
}

const CharucoBoard kCharuco{
    .columns = 11, .rows = 8, .square_m = 0.024, .marker_m = 0.018, .dictionary = "DICT_5X5_100"};

cv::Ptr<cv::aruco::Dictionary> dictionaryOf(std::string_view name) {
  return cv::aruco::getPredefinedDictionary(findMarkerDictionary(name)->opencv_id);
}

bool findCharuco(const cv::Mat& image) {
  static const auto board = cv::aruco::CharucoBoard::create(
      kCharuco.columns, kCharuco.rows, static_cast<float>(kCharuco.square_m),
      static_cast<float>(kCharuco.marker_m), dictionaryOf(kCharuco.dictionary));
  std::vector<std::vector<cv::Point2f>> markers;
  std::vector<std::vector<cv::Point2f>> rejected;
  std::vector<int> ids;
  cv::aruco::detectMarkers(image, board->dictionary, markers, ids, cv::aruco::DetectorParameters::create(),
                           rejected);
  cv::aruco::refineDetectedMarkers(image, board, markers, ids, rejected);
  if (ids.empty()) return false;
  cv::Mat corners;
  cv::Mat corner_ids;
  return cv::aruco::interpolateCornersCharuco(markers, ids, image, board, corners, corner_ids) >= 6;
}

const AprilGrid kGrid{.columns = 6, .rows = 6, .tag_m = 0.088, .gap = 0.3};

bool findTags(const cv::Mat& image) {
  const auto parameters = cv::aruco::DetectorParameters::create();
  parameters->markerBorderBits = 2;
  parameters->cornerRefinementMethod = cv::aruco::CORNER_REFINE_SUBPIX;
  std::vector<std::vector<cv::Point2f>> markers;
  std::vector<int> ids;
  cv::aruco::detectMarkers(image, dictionaryOf(AprilGrid::kDictionary), markers, ids, parameters);
  return ids.size() >= 2;
}

const CircleGrid kCircles{.columns = 10, .rows = 8, .spacing_m = 0.025, .diameter_m = 0.015};
const AsymmetricCircleGrid kStaggered{.columns = 4, .rows = 11, .spacing_m = 0.02, .diameter_m = 0.014};

bool findCircles(const cv::Mat& image) {
  std::vector<cv::Point2f> centers;
  return cv::findCirclesGrid(image, {kCircles.columns, kCircles.rows}, centers, cv::CALIB_CB_SYMMETRIC_GRID);
}

bool findStaggered(const cv::Mat& image) {
  std::vector<cv::Point2f> centers;
  return cv::findCirclesGrid(image, {kStaggered.columns, kStaggered.rows}, centers,
                             cv::CALIB_CB_ASYMMETRIC_GRID);
}

std::vector<Target> targets() {
  return {{"checkerboard",
           kBoard,
           {{"findChessboardCornersSB", findSectors}, {"findChessboardCorners", findClassic}}},
          {"charuco", kCharuco, {{"interpolateCornersCharuco", findCharuco}}},
          {"aprilgrid", kGrid, {{"aruco::detectMarkers", findTags}}},
          {"circles", kCircles, {{"findCirclesGrid", findCircles}}},
          {"acircles", kStaggered, {{"findCirclesGrid", findStaggered}}}};
}

// CPU time per image, ms, and the number of images in which the board is found.
struct Cost {
  double ms = 0;
  int num_found = 0;
};

Cost costOf(int repetitions, const std::vector<std::string>& paths,
            const std::function<bool(const std::string&)>& finds) {
  Cost cost;
  cost.ms = medianTime(repetitions,
                       [&] {
                         cost.num_found = 0;
                         for (const std::string& path : paths) cost.num_found += finds(path) ? 1 : 0;
                       }) /
            static_cast<double>(paths.size());
  return cost;
}

void compare(const Target& target, const char* shown, const std::vector<std::string>& paths, ImageSize size) {
  const int repetitions = size.width > 3000 ? 3 : 7;
  const Cost decode = costOf(repetitions, paths, [](const std::string& path) {
    return !cv::imread(path, cv::IMREAD_GRAYSCALE).empty();
  });
  const Cost ours = costOf(repetitions, paths, [&](const std::string& path) {
    return findBoard(readGrayImage(path).image, target.board).hasCorners();
  });
  fmt::print("{:>4}x{:<4} {:<12} {:<7} {:8.2f} {:8.2f} {}/{}", size.width, size.height, target.name, shown,
             decode.ms, ours.ms, ours.num_found, paths.size());
  for (const Peer& peer : target.peers) {
    const Cost cost = costOf(size.width > 3000 ? 1 : 3, paths, [&](const std::string& path) {
      return peer.finds(cv::imread(path, cv::IMREAD_GRAYSCALE));
    });
    fmt::print("   {} {:.1f} = {:.1f} x {}/{}", peer.name, cost.ms, cost.ms / ours.ms, cost.num_found,
               paths.size());
  }
  fmt::print("\n");
  std::fflush(stdout);
}

double wallMilliseconds(const std::vector<std::string>& paths, int jobs) {
  std::vector<double> times;
  for (int r = 0; r < 3; ++r) {
    const auto start = std::chrono::steady_clock::now();
    DetectImagesOptions options;
    options.num_jobs = jobs;
    (void)detectInImages(paths, kBoard, options);
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
    // Runs alone in its process, so that the peak is that of detection: the renderer needs more.
    std::vector<std::string> paths;
    for (int i = 0; i < num_memory_images; ++i)
      paths.push_back((folder / (fmt::format("checkerboard_4000_{}.jpg", i % kNumViews))).string());
    if (!fs::exists(paths.front())) {
      std::fprintf(stderr, "run without an argument first: it writes the images\n");
      return 1;
    }
    const auto outcomes = detectInImages(paths, kBoard);
    const auto num_found = std::count_if(outcomes.begin(), outcomes.end(),
                                         [](const ImageOutcome& o) { return o.detection.hasCorners(); });
    std::printf("%d images of 4000x3000, all threads: %ld found, peak memory %ld MB\n", num_memory_images,
                static_cast<long>(num_found), peakMegabytes());
    return 0;
  }
  fmt::print(
      "CPU ms an image, one thread, from JPEG file to refined corners; OpenCV's functions also as multiples "
      "of "
      "ours; the board is found in n/m images\n");
  fmt::print("{:<9} {:<12} {:<7} {:>8} {:>8}\n", "size", "target", "shows", "decode", "ours");
  for (const ImageSize& size : kSizes) {
    for (const Target& target : targets()) {
      compare(target, "board", writeBoards(folder, size, target), size);
      compare(target, "texture", writeTextures(folder, size), size);
    }
  }
  std::vector<std::string> many;
  for (int i = 0; i < 24; ++i)
    many.push_back((folder / (fmt::format("checkerboard_4000_{}.jpg", i % kNumViews))).string());
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
