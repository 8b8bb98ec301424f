// SPDX-License-Identifier: MIT
// The solver compared with its lower bound and other solvers, on the same simulated corners from the same
// start, each case in a separate process: CPU time, peak memory and the result.
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <ctime>
#include <filesystem>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include <ceres/ceres.h>
#include <sys/resource.h>
#include <unistd.h>
#include <opencv2/calib3d.hpp>

#include "alidade/adjust/board/errors.h"
#include "alidade/adjust/board/solve.h"
#include "alidade/adjust/board/view_pose.h"
#include "alidade/calibrate/calibrator.h"
#include "alidade/camera/radtan.h"
#include "alidade/simulate/observe.h"
#include "alidade/simulate/random_views.h"
#include "block_arrow.h"
#include "mrcal_input.h"
#include "support/corner_cost.h"

namespace alidade {
namespace {

constexpr ImageSize kSize{1920, 1200};
constexpr double kNoisePx = 0.1;
constexpr HuberLoss kLoss{.threshold_px = 3 * kNoisePx};
constexpr std::array kNumViews = {30, 100, 300, 1000, 3000};
const Checkerboard kBoard{.columns = 10, .rows = 7, .square_m = 0.03};

struct Problem {
  std::vector<View> views;
  Fit start;
};

// A start like that of a calibration: without distortion, with poses from that camera's rays.
Problem makeProblem(int num_views) {
  const AnyCamera camera =
      AnyCamera::make("radtan", std::vector<double>{1003, 1001, 955, 604, -0.2, 0.08, 5e-4, -4e-4, -0.01});
  Problem problem;
  problem.start = emptyFit("radtan", kSize, {1023, 1021, 959.5, 599.5, 0, 0, 0, 0, 0}, kBoard, kLoss);
  const AnyCamera guess = AnyCamera::make("radtan", problem.start.cameras.front().params);
  Random random(1);
  for (const SE3& pose : randomViews(camera, kSize, kBoard, num_views, random)) {
    View view = exactView(camera, kSize, kBoard, pose, std::to_string(problem.views.size()));
    addCornerNoise(view, kNoisePx, random);
    std::vector<Observation> corners = observationsOf(kBoard, view);
    const SE3 start = poseFromCorners(guess, corners).value();
    addView(problem.start, problem.views.size(), std::move(corners), start);
    problem.views.push_back(std::move(view));
  }
  return problem;
}

// The results of one case.
struct Outcome {
  double ms = 0;
  double peak_mb = 0;
  double rms_px = 0;  // over all corners, without the loss
  double fx = 0;
};

double cpuMilliseconds() {
  timespec now{};
  clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &now);
  return 1e3 * static_cast<double>(now.tv_sec) + 1e-6 * static_cast<double>(now.tv_nsec);
}

double peakMegabytes() {
  rusage usage{};
  getrusage(RUSAGE_SELF, &usage);
  return static_cast<double>(usage.ru_maxrss) / 1024;
}

// Shortest of as many runs as fit into two seconds, 1 to 50: other work on the machine only adds time.
template <class F>
double leastMilliseconds(const F& f) {
  std::vector<double> times;
  double total = 0;
  while (times.empty() || (total < 2000 && times.size() < 50)) {
    const double start = cpuMilliseconds();
    f();
    times.push_back(cpuMilliseconds() - start);
    total += times.back();
  }
  return *std::min_element(times.begin(), times.end());
}

template <class Solve>
Outcome runBundle(const Problem& problem, const Solve& solve) {
  Outcome outcome;
  Fit fit;
  outcome.ms = leastMilliseconds([&] {
    fit = problem.start;
    solve(fit);
  });
  outcome.peak_mb = peakMegabytes();
  for (FitView& view : fit.views) view.errors = viewErrors(fit, view);
  outcome.rms_px = rms(fit);
  outcome.fx = fit.cameras.front().params[0];
  return outcome;
}

void requireConverged(bool is_converged, const std::string& reason) {
  if (is_converged) return;
  std::fprintf(stderr, "not converged: %s\n", reason.c_str());
  std::exit(1);
}

Outcome runSolve(const Problem& problem) {
  return runBundle(problem, [&](Fit& fit) {
    fit = solve(std::move(fit));
    requireConverged(fit.summary.termination == Termination::kConverged, fit.summary.reason);
  });
}

Outcome runFloor(const Problem& problem) {
  return runBundle(problem, [&](Fit& fit) { requireConverged(solveBlockArrow(fit), "floor"); });
}

Outcome runCeres(const Problem& problem) {
  return runBundle(problem, [&](Fit& fit) {
    std::vector<PoseBlock> poses;
    std::vector<std::vector<Observation>> corners;
    for (const FitView& view : fit.views) {
      poses.push_back(toBlock(cameraFromBoard(fit, view)));
      corners.push_back(view.corners);
    }
    std::vector<double>& params = fit.cameras.front().params;
    ceres::Problem plain;
    addCorners<Radtan>(plain, corners, new ceres::HuberLoss(kLoss.threshold_px), params, poses);
    auto ordering = std::make_shared<ceres::ParameterBlockOrdering>();
    for (PoseBlock& pose : poses) ordering->AddElementToGroup(pose.data(), 0);
    ordering->AddElementToGroup(params.data(), 1);
    ceres::Solver::Options options;
    options.linear_solver_type = ceres::DENSE_SCHUR;
    options.linear_solver_ordering = ordering;
    options.max_num_iterations = SolveOptions().max_iterations;
    options.function_tolerance = SolveOptions().function_tolerance;
    options.parameter_tolerance = 1e-12;
    options.logging_type = ceres::SILENT;
    ceres::Solver::Summary summary;
    ceres::Solve(options, &plain, &summary);
    requireConverged(summary.termination_type == ceres::CONVERGENCE, summary.message);
    for (std::size_t v = 0; v < poses.size(); ++v)
      fit.placements[fit.views[v].placement].rig_from_body = fromBlock(poses[v].data());
  });
}

// The complete calibration, which finds its own start.
Outcome runCalibrate(const Problem& problem) {
  Outcome outcome;
  outcome.ms = leastMilliseconds([&] {
    const Calibration result = calibrate(kBoard, problem.views, {.model = "radtan"});
    requireConverged(result.isUsable(), "not trustworthy");
    outcome.rms_px = rms(result.fit);
    outcome.fx = onlyCamera(result.fit).params[0];
  });
  outcome.peak_mb = peakMegabytes();
  return outcome;
}

Outcome runOpenCv(const Problem& problem) {
  std::vector<std::vector<cv::Point3f>> object;
  std::vector<std::vector<cv::Point2f>> image;
  for (const FitView& view : problem.start.views) {
    object.emplace_back();
    image.emplace_back();
    for (const Observation& corner : view.corners) {
      const Eigen::Vector3f p = corner.p_board.cast<float>();
      object.back().emplace_back(p.x(), p.y(), p.z());
      image.back().emplace_back(static_cast<float>(corner.pixel.x()), static_cast<float>(corner.pixel.y()));
    }
  }
  Outcome outcome;
  outcome.ms = leastMilliseconds([&] {
    cv::Mat K;
    cv::Mat distortion;
    std::vector<cv::Mat> rotations;
    std::vector<cv::Mat> translations;
    outcome.rms_px =
        cv::calibrateCamera(object, image, {kSize.width, kSize.height}, K, distortion, rotations,
                            translations, 0, {cv::TermCriteria::COUNT + cv::TermCriteria::EPS, 500, 1e-12});
    outcome.fx = K.at<double>(0, 0);
  });
  outcome.peak_mb = peakMegabytes();
  return outcome;
}

// The script prints the outcome itself.
int runMrcal(const Problem& problem) {
  constexpr int kMany = 1000;
  return solveByMrcal(problem.start, problem.views.size() > kMany ? 1 : 5) ? 0 : 1;
}

struct Case {
  const char* name;
  int max_views;
  Outcome (*run)(const Problem&);  // null: mrcal
};

constexpr std::array kCases = {Case{"floor", 3000, runFloor},         Case{"solve", 3000, runSolve},
                               Case{"calibrate", 3000, runCalibrate}, Case{"ceres", 3000, runCeres},
                               Case{"mrcal", 3000, nullptr},          Case{"opencv", 100, runOpenCv}};

int runCase(std::string_view name, int num_views) {
  const auto* found =
      std::find_if(kCases.begin(), kCases.end(), [&](const Case& c) { return c.name == name; });
  if (found == kCases.end() || num_views < 2) {
    std::fprintf(stderr, "solver_bench: --case takes one of");
    for (const Case& c : kCases) std::fprintf(stderr, " %s", c.name);
    std::fprintf(stderr, " and a number of views from 2 on\n");
    return 2;
  }
  const Problem problem = makeProblem(num_views);
  if (found->run == nullptr) return runMrcal(problem);
  const Outcome outcome = found->run(problem);
  std::printf("%.17g %.17g %.17g %.17g\n", outcome.ms, outcome.peak_mb, outcome.rms_px, outcome.fx);
  return 0;
}

// Runs a case in a separate process; nothing if it fails, for instance because mrcal is not installed.
std::optional<Outcome> outcomeOf(const std::string& program, const Case& c, int num_views) {
  const std::string command =
      program + " --case " + c.name + " " + std::to_string(num_views) + " 2>/dev/null";
  FILE* pipe = popen(command.c_str(), "r");
  if (pipe == nullptr) return std::nullopt;
  Outcome outcome;
  const int num_read =
      std::fscanf(pipe, "%lf %lf %lf %lf", &outcome.ms, &outcome.peak_mb, &outcome.rms_px, &outcome.fx);
  if (pclose(pipe) != 0 || num_read != 4) return std::nullopt;
  return outcome;
}

using Times = std::map<std::pair<std::string, int>, double>;  // CPU ms by case and views

void printRatio(const Times& ms, const char* slow, const char* fast) {
  std::printf("%s / %s:", slow, fast);
  for (const int num_views : kNumViews) {
    const auto a = ms.find({slow, num_views});
    const auto b = ms.find({fast, num_views});
    if (a != ms.end() && b != ms.end()) std::printf("  %d views %.3g", num_views, a->second / b->second);
  }
  std::printf("\n");
}

void printGrowth(const Times& ms, const char* name) {
  constexpr int kFrom = 100;
  const int to = kNumViews.back();
  const auto a = ms.find({name, kFrom});
  const auto b = ms.find({name, to});
  if (a == ms.end() || b == ms.end()) return;
  std::printf("%s grows with the number of views to the power of %.2f between %d and %d\n", name,
              std::log(b->second / a->second) / std::log(static_cast<double>(to) / kFrom), kFrom, to);
}

void printAll(const std::string& program) {
  Times ms;
  std::printf("%-10s %6s %11s %8s %9s %11s %13s\n", "case", "views", "CPU ms", "x floor", "peak MB", "rms px",
              "fx px");
  for (const int num_views : kNumViews) {
    double floor_ms = 0;
    for (const Case& c : kCases) {
      if (num_views > c.max_views) continue;
      const auto outcome = outcomeOf(program, c, num_views);
      if (!outcome) {
        std::printf("%-10s %6d  failed or not installed\n", c.name, num_views);
        continue;
      }
      if (c.run == runFloor) floor_ms = outcome->ms;
      ms[{c.name, num_views}] = outcome->ms;
      std::printf("%-10s %6d %11.3f %8.2f %9.1f %11.8f %13.8f\n", c.name, num_views, outcome->ms,
                  outcome->ms / floor_ms, outcome->peak_mb, outcome->rms_px, outcome->fx);
      std::fflush(stdout);
    }
  }
  printRatio(ms, "solve", "floor");
  for (const char* peer : {"ceres", "mrcal", "opencv"}) printRatio(ms, peer, "solve");
  for (const char* peer : {"mrcal", "opencv"}) printRatio(ms, peer, "calibrate");
  for (const Case& c : kCases) printGrowth(ms, c.name);
}

}  // namespace
}  // namespace alidade

int main(int argc, char** argv) {
  cv::setNumThreads(1);
  if (argc == 4 && std::string_view(argv[1]) == "--case")
    return alidade::runCase(argv[2], std::atoi(argv[3]));
  if (argc != 1) {
    std::fprintf(stderr, "usage: solver_bench [--case NAME VIEWS]\n");
    return 2;
  }
  alidade::printAll(std::filesystem::read_symlink("/proc/self/exe").string());
  return 0;
}
