// SPDX-License-Identifier: MIT
// The joint solve of rigs compared with mrcal and cv::stereoCalibrate, on the same simulated corners from the
// same start; and how often the stated covariance of a rig covers the truth.
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <ctime>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include <opencv2/calib3d.hpp>

#include "alidade/adjust/board/errors.h"
#include "alidade/adjust/board/solve.h"
#include "alidade/rig/rig_calibrator.h"
#include "alidade/simulate/observe.h"
#include "alidade/simulate/random_views.h"
#include "mrcal_input.h"

namespace alidade {
namespace {

constexpr ImageSize kSize{1920, 1200};
constexpr double kNoisePx = 0.1;
const Checkerboard kBoard{.columns = 10, .rows = 7, .square_m = 0.03};

struct TrueRig {
  std::vector<AnyCamera> cameras;
  std::vector<ImageSize> sizes;
  std::vector<SE3> camera_from_rig;
};

// Cameras in rows of four, 60 mm apart, slightly turned.
TrueRig sameCameras(int num_cameras) {
  TrueRig rig;
  for (int c = 0; c < num_cameras; ++c) {
    const std::vector<double> params = {1003.0 + c, 1001.0 + c, 955, 604, -0.2, 0.08, 5e-4, -4e-4, -0.01};
    rig.cameras.push_back(AnyCamera::make("radtan", params));
    rig.sizes.push_back(kSize);
    const Eigen::Vector3d turn(0.01 * (c / 4), 0.015 * (c % 4), 0.005 * c);
    const Eigen::Vector3d centre(0.06 * (c % 4), 0.06 * (c / 4), 0);
    const SE3 rig_from_camera{c == 0 ? SO3() : SO3::exp(turn), centre};
    rig.camera_from_rig.push_back(rig_from_camera.inverse());
  }
  return rig;
}

struct Problem {
  std::vector<RigViews> views;
  Fit start;
};

// A start like that of a calibration: lenses off by a few per cent, poses by a few millimetres and degrees.
Problem makeProblem(int num_cameras, int num_frames) {
  const TrueRig rig = sameCameras(num_cameras);
  Problem problem;
  problem.start.boards.push_back({.target = kBoard});
  problem.start.loss = {.threshold_px = 3 * kNoisePx};
  Random random(1);
  for (int c = 0; c < num_cameras; ++c) {
    problem.views.push_back({.name = "camera" + std::to_string(c), .views = {}});
    const auto at = static_cast<std::size_t>(c);
    const SE3 off{SO3::exp(0.01 * Eigen::Vector3d(random.normal(), random.normal(), random.normal())),
                  0.003 * Eigen::Vector3d(random.normal(), random.normal(), random.normal())};
    problem.start.cameras.push_back({.model = "radtan",
                                     .size = kSize,
                                     .params = {1023, 1021, 959.5, 599.5, 0, 0, 0, 0, 0},
                                     .camera_from_rig = c == 0 ? SE3() : off * rig.camera_from_rig[at],
                                     .is_rig_pose_fixed = c == 0});
  }
  std::size_t source = 0;
  for (const SE3& pose : randomViews(rig.cameras.front(), kSize, kBoard, num_frames, random)) {
    const std::size_t frame = problem.start.placements.size();
    const SE3 off{SO3::exp(0.01 * Eigen::Vector3d(random.normal(), random.normal(), random.normal())),
                  0.003 * Eigen::Vector3d(random.normal(), random.normal(), random.normal())};
    problem.start.placements.push_back({.frame = frame, .rig_from_body = pose * off});
    for (std::size_t c = 0; c < rig.cameras.size(); ++c) {
      View view =
          exactView(rig.cameras[c], kSize, kBoard, rig.camera_from_rig[c] * pose, std::to_string(frame));
      constexpr std::size_t kFewest = 12;
      std::erase_if(view.corners, [](const Corner& corner) { return !isInOrNearImage(corner.pixel, kSize); });
      if (view.corners.size() < kFewest) continue;
      addCornerNoise(view, kNoisePx, random);
      problem.start.views.push_back(
          {.camera = c, .placement = frame, .source = source++, .corners = observationsOf(kBoard, view)});
      problem.views[c].views.push_back(std::move(view));
    }
  }
  return problem;
}

double cpuMilliseconds() {
  timespec now{};
  clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &now);
  return 1e3 * static_cast<double>(now.tv_sec) + 1e-6 * static_cast<double>(now.tv_nsec);
}

// Shortest of as many runs as fit into two seconds, at most 20.
template <class F>
double leastMilliseconds(const F& f) {
  std::vector<double> times;
  double total = 0;
  while (times.empty() || (total < 2000 && times.size() < 20)) {
    const double start = cpuMilliseconds();
    f();
    times.push_back(cpuMilliseconds() - start);
    total += times.back();
  }
  return *std::ranges::min_element(times);
}

void printStereo(const Problem& problem) {
  std::vector<std::vector<cv::Point3f>> object;
  std::array<std::vector<std::vector<cv::Point2f>>, 2> image;
  const std::vector<FitView>& views = problem.start.views;
  for (std::size_t v = 0; v + 1 < views.size(); ++v) {
    if (views[v].placement != views[v + 1].placement ||
        views[v].corners.size() != views[v + 1].corners.size())
      continue;
    object.emplace_back();
    for (const Observation& corner : views[v].corners) {
      const Eigen::Vector3f p = corner.p_board.cast<float>();
      object.back().emplace_back(p.x(), p.y(), p.z());
    }
    for (std::size_t c = 0; c < 2; ++c) {
      image[c].emplace_back();
      for (const Observation& corner : views[v + c].corners)
        image[c].back().emplace_back(static_cast<float>(corner.pixel.x()),
                                     static_cast<float>(corner.pixel.y()));
    }
  }
  double rms_px = 0;
  const double ms = leastMilliseconds([&] {
    std::array<cv::Mat, 2> K;
    std::array<cv::Mat, 2> distortion;
    for (std::size_t c = 0; c < 2; ++c) {
      K[c] = cv::Mat(cv::Matx33d(1023, 0, 959.5, 0, 1021, 599.5, 0, 0, 1));
      distortion[c] = cv::Mat::zeros(1, 5, CV_64F);
    }
    cv::Mat R;
    cv::Mat T;
    cv::Mat E;
    cv::Mat F;
    rms_px = cv::stereoCalibrate(object, image[0], image[1], K[0], distortion[0], K[1], distortion[1],
                                 {kSize.width, kSize.height}, R, T, E, F, cv::CALIB_USE_INTRINSIC_GUESS,
                                 {cv::TermCriteria::COUNT + cv::TermCriteria::EPS, 500, 1e-12});
  });
  std::printf("  OpenCV     %9.1f ms  RMS %.5f px, %zu frames\n", ms, rms_px, object.size());
}

int printTimes() {
  using Case = std::pair<int, int>;
  for (const auto& [num_cameras, num_frames] :
       {Case{2, 50}, Case{4, 200}, Case{8, 125}, Case{8, 250}, Case{8, 500}}) {
    const Problem problem = makeProblem(num_cameras, num_frames);
    std::printf("%d cameras, %d frames, %zu views\n", num_cameras, num_frames, problem.start.views.size());
    Fit fit;
    const double ms = leastMilliseconds([&] { fit = solve(problem.start); });
    for (FitView& view : fit.views) view.errors = viewErrors(fit, view);
    std::printf("  solve      %9.1f ms  RMS %.5f px  %d steps, %s\n", ms, rms(fit),
                fit.summary.num_iterations, std::string(terminationName(fit.summary.termination)).c_str());
    RigCalibration rig;
    RigOptions options;
    options.camera.model = "radtan";
    options.camera.board_shape = BoardShapeMode::kFlat;
    const Board board = kBoard;
    const double whole =
        leastMilliseconds([&] { rig = calibrate(std::span(&board, 1), problem.views, options); });
    std::printf("  rig        %9.1f ms  RMS %.5f px  (calibrate, whole)\n", whole, rms(rig.fit));
    if (num_cameras == 2) printStereo(problem);
    std::printf("  mrcal (ms, MB, RMS, fx) ");
    std::fflush(stdout);
    constexpr int kFewFrames = 200;
    if (!solveByMrcal(problem.start, num_frames <= kFewFrames ? 3 : 1)) std::printf("not run\n");
  }
  return 0;
}

// Alternating models and resolutions, on an arc; in a large rig, a camera shares boards only with its
// neighbours.
TrueRig mixedCameras(int num_cameras) {
  struct Lens {
    const char* model;
    ImageSize size;
    std::vector<double> params;
  };
  const std::vector<Lens> lenses = {
      {"radtan", {1280, 960}, {900, 902, 640, 478, -0.25, 0.08, 4e-4, -3e-4, 0}},
      {"kannala_brandt", {1024, 768}, {420, 421, 512, 383, 0.01, -0.003, 0.001, 0}},
      {"pinhole", {800, 600}, {700, 700, 400, 300}},
      {"double_sphere", {1280, 1024}, {450, 451, 640, 510, -0.2, 0.55}},
      {"eucm", {1024, 1024}, {460, 459, 511, 512, 0.55, 1.1}},
      {"fov", {752, 480}, {370, 371, 375, 240, 0.9}},
      {"ucm", {640, 480}, {300, 301, 320, 240, 0.5}},
      {"rational", {1920, 1080}, {1100, 1101, 960, 540, 0.3, 0.05, 1e-4, -1e-4, 0, 0.55, 0.1, 0}}};
  TrueRig rig;
  for (int c = 0; c < num_cameras; ++c) {
    const Lens& lens = lenses[static_cast<std::size_t>(c) % lenses.size()];
    rig.cameras.push_back(AnyCamera::make(lens.model, lens.params));
    rig.sizes.push_back(lens.size);
    constexpr double kStepRad = 0.35;
    constexpr double kRadius = 0.2;
    const double angle = kStepRad * c;
    const SE3 rig_from_camera{SO3::exp(Eigen::Vector3d(0, angle, 0)),
                              kRadius * Eigen::Vector3d(std::sin(angle), 0.1 * (c % 3), std::cos(angle) - 1)};
    rig.camera_from_rig.push_back(rig_from_camera.inverse());
  }
  return rig;
}

// Frames with a board in front of each camera in turn.
std::vector<RigViews> mixedViews(const TrueRig& rig, const Board& board, int num_frames, double noise_px,
                                 std::uint64_t seed) {
  Random random(seed);
  std::vector<RigViews> views;
  for (std::size_t c = 0; c < rig.cameras.size(); ++c)
    views.push_back({.name = "camera" + std::to_string(c), .views = {}});
  int frame = 0;
  for (std::size_t host = 0; host < rig.cameras.size(); ++host) {
    for (const SE3& pose : randomViews(rig.cameras[host], rig.sizes[host], board, num_frames, random)) {
      const SE3 rig_from_board = rig.camera_from_rig[host].inverse() * pose;
      const std::string name = "frame" + std::to_string(frame++);
      for (std::size_t c = 0; c < rig.cameras.size(); ++c) {
        View view =
            exactView(rig.cameras[c], rig.sizes[c], board, rig.camera_from_rig[c] * rig_from_board, name);
        std::erase_if(view.corners,
                      [&](const Corner& corner) { return !isInOrNearImage(corner.pixel, rig.sizes[c]); });
        constexpr std::size_t kFewest = 12;
        if (view.corners.size() < kFewest) continue;
        addCornerNoise(view, noise_px, random);
        views[c].views.push_back(std::move(view));
      }
    }
  }
  return views;
}

int printCoverage(int num_sets) {
  const Board board = CharucoBoard{
      .columns = 11, .rows = 8, .square_m = 0.03, .marker_m = 0.022, .dictionary = "DICT_4X4_250"};
  std::printf("cameras  sets  within 95 %%  rms z  worst z  not together  named falsely\n");
  int all = 0;
  int all_within = 0;
  for (const int num_cameras : {2, 3, 4, 6, 8, 12, 16}) {
    const TrueRig truth = mixedCameras(num_cameras);
    RigOptions options;
    options.camera.board_shape = BoardShapeMode::kFlat;
    for (const AnyCamera& camera : truth.cameras) options.models.emplace_back(camera.modelId());
    int count = 0;
    int within = 0;
    int named = 0;
    double squares = 0;
    double worst = 0;
    std::size_t num_apart = 0;
    const int sets = std::max(1, num_sets / 7);
    for (int set = 0; set < sets; ++set) {
      constexpr int kFrames = 12;
      const std::vector<RigViews> views =
          mixedViews(truth, board, kFrames, 0.2, static_cast<std::uint64_t>(1000 * num_cameras + set));
      const RigCalibration rig = calibrate(std::span(&board, 1), views, options);
      named += rig.links.unlinked.empty() && rig.motions.empty() ? 0 : 1;
      for (std::size_t c = 1; c < truth.cameras.size(); ++c) {
        Eigen::Matrix<double, 6, 1> std;
        std << rig.cameras[c].link.translation_std_m, rig.cameras[c].link.rotation_std_rad;
        const Eigen::Matrix<double, 6, 1> z =
            (truth.camera_from_rig[c].inverse() * rig.fit.cameras[c].camera_from_rig)
                .log()
                .cwiseQuotient(std);
        count += 6;
        within += static_cast<int>((z.cwiseAbs().array() < 1.96).count());
        squares += z.squaredNorm();
        worst = std::max(worst, z.cwiseAbs().maxCoeff());
      }
      std::vector<std::vector<bool>> meet(truth.cameras.size(), std::vector<bool>(truth.cameras.size()));
      for (const FitView& a : rig.fit.views) {
        for (const FitView& b : rig.fit.views)
          if (a.placement == b.placement) meet[a.camera][b.camera] = true;
      }
      for (const auto& of_camera : meet)
        num_apart += static_cast<std::size_t>(std::ranges::count(of_camera, false));
    }
    std::printf("%7d  %4d  %9.1f %%  %5.2f  %7.2f  %6.0f pairs  %8d sets\n", num_cameras, sets,
                100.0 * within / count, std::sqrt(squares / count), worst,
                static_cast<double>(num_apart) / (2.0 * sets), named);
    std::fflush(stdout);
    all += count;
    all_within += within;
  }
  std::printf("    all           %9.1f %%\n", 100.0 * all_within / all);
  return 0;
}

}  // namespace
}  // namespace alidade

int main(int argc, char** argv) {
  cv::setNumThreads(1);
  if (argc == 1) return alidade::printTimes();
  if (argc == 3 && std::string_view(argv[1]) == "coverage") return alidade::printCoverage(std::atoi(argv[2]));
  std::fprintf(stderr, "usage: rig_bench [coverage SETS]\n");
  return 2;
}
