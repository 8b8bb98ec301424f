// SPDX-License-Identifier: MIT
// How accurately a camera's place on a robot is found, beside OpenCV and beside fits that take the robot as
// exact. A table over the robot's accuracy and that of the corners.
//   handeye_bench [sets per cell, default 40] [views, default 15] [hand | base] [seed, default 1]
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <limits>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include <Eigen/Cholesky>
#include <opencv2/calib3d.hpp>

#include "alidade/calibrate/calibrator.h"
#include "alidade/core/error.h"
#include "alidade/simulate/robot.h"
#ifdef ALIDADE_HAS_HANDEYE
#include "alidade/handeye/hand_eye.h"
#endif

namespace alidade {
namespace {

using Eigen::MatrixXd;
using Eigen::VectorXd;

constexpr std::size_t kNumOfOpenCv = 5;
constexpr std::array<std::string_view, 7> kMethods = {"TSAI",       "PARK",        "HORAUD",  "ANDREFF",
                                                      "DANIILIDIS", "camera held", "all free"};
constexpr std::array kNoises = {RobotNoise{1e-4, 5e-5}, RobotNoise{5e-4, 2e-4}, RobotNoise{2e-3, 1.5e-3},
                                RobotNoise{5e-3, 3e-3}};
constexpr std::array kCornerNoises = {0.05, 0.1, 0.3};

RobotScene sceneOf(const RobotNoise& robot_noise, double corner_noise_px, int num_views, CameraOn camera_on) {
  return {.camera =
              AnyCamera::make("radtan", std::vector<double>{510, 512, 324, 236, -0.25, 0.08, 5e-4, -3e-4, 0}),
          .size = {.width = 640, .height = 480},
          .board = Checkerboard{.columns = 9, .rows = 6, .square_m = 0.025},
          .camera_on = camera_on,
          .num_views = num_views,
          .robot_noise = robot_noise,
          .corner_noise_px = corner_noise_px};
}

CalibratorOptions cameraOptions() {
  return {.model = "radtan"};
}

// The mount's and the board's place, and the lens.
struct Places {
  SE3 mount_from_camera;
  SE3 world_from_board;
  AnyCamera camera;
};

// The images and the robot's poses of the views in use.
struct Recording {
  const Fit& fit;
  std::vector<SE3> mount_from_world;  // by the robot

  Recording(const RobotSet& set, const Fit& of) : fit(of) {
    for (const FitView& view : fit.views) {
      const auto pose = std::ranges::find(set.robot.poses, view.image, &RobotPose::image);
      mount_from_world.push_back(set.scene.camera_on == CameraOn::kHand ? pose->base_from_gripper.inverse()
                                                                        : pose->base_from_gripper);
    }
  }
};

// A cv::Mat of 3 x 3 or 3 x 1.
template <class Derived>
cv::Mat matOf(const Eigen::MatrixBase<Derived>& matrix) {
  cv::Mat mat(static_cast<int>(matrix.rows()), static_cast<int>(matrix.cols()), CV_64F);
  for (int r = 0; r < mat.rows; ++r)
    for (int c = 0; c < mat.cols; ++c) mat.at<double>(r, c) = matrix(r, c);
  return mat;
}

std::optional<SE3> byOpenCv(const Recording& recording, cv::HandEyeCalibrationMethod method) {
  std::vector<cv::Mat> mount_R;
  std::vector<cv::Mat> mount_t;
  std::vector<cv::Mat> board_R;
  std::vector<cv::Mat> board_t;
  for (std::size_t i = 0; i < recording.fit.views.size(); ++i) {
    const SE3 world_from_mount = recording.mount_from_world[i].inverse();
    const SE3 camera_from_board = cameraFromBoard(recording.fit, recording.fit.views[i]);
    mount_R.push_back(matOf(world_from_mount.rotation.matrix()));
    mount_t.push_back(matOf(world_from_mount.translation));
    board_R.push_back(matOf(camera_from_board.rotation.matrix()));
    board_t.push_back(matOf(camera_from_board.translation));
  }
  cv::Mat R;
  cv::Mat t;
  try {
    cv::calibrateHandEye(mount_R, mount_t, board_R, board_t, R, t, method);
  } catch (const cv::Exception&) {
    return std::nullopt;
  }
  if (!cv::checkRange(R) || !cv::checkRange(t)) return std::nullopt;
  cv::Mat rotation_vector;
  cv::Rodrigues(R, rotation_vector);
  const double* w = rotation_vector.ptr<double>();
  return SE3{SO3::exp({w[0], w[1], w[2]}), {t.at<double>(0), t.at<double>(1), t.at<double>(2)}};
}

// The normal equations of the corners' errors for tangents of the two places and, if it is free, the lens.
struct Equations {
  double cost = 0;  // infinite if a corner has no pixel
  MatrixXd H;
  VectorXd g;
};

Equations equationsOf(const Recording& recording, const Places& places, bool is_lens_free) {
  const auto num_lens = is_lens_free ? static_cast<Eigen::Index>(places.camera.parameters().size()) : 0;
  Equations equations{.H = MatrixXd::Zero(12 + num_lens, 12 + num_lens), .g = VectorXd::Zero(12 + num_lens)};
  const SE3 camera_from_mount = places.mount_from_camera.inverse();
  std::vector<double> by_lens(2 * places.camera.parameters().size());
  MatrixXd J(2, 12 + num_lens);
  for (std::size_t i = 0; i < recording.fit.views.size(); ++i) {
    const SE3 camera_from_board = camera_from_mount * recording.mount_from_world[i] * places.world_from_board;
    for (const Observation& corner : cornersOnShape(recording.fit, recording.fit.views[i])) {
      const Eigen::Vector3d p = camera_from_board * corner.p_board;
      Eigen::Matrix<double, 2, 3, Eigen::RowMajor> by_point;
      const Projection projection = places.camera.projectPoint(p, by_point.data(), by_lens.data());
      if (!projection.ok()) {
        equations.cost = std::numeric_limits<double>::infinity();
        return equations;
      }
      const Eigen::Matrix<double, 2, 3> by_board = by_point * camera_from_board.rotation.matrix();
      J.leftCols<3>() = -by_point;
      J.middleCols<3>(3) = by_point * hat(p);
      J.middleCols<3>(6) = by_board;
      J.middleCols<3>(9) = -by_board * hat(corner.p_board);
      if (is_lens_free)
        J.rightCols(num_lens) = Eigen::Map<Eigen::Matrix<double, 2, Eigen::Dynamic, Eigen::RowMajor>>(
            by_lens.data(), 2, num_lens);
      const Eigen::Vector2d error = projection.pixel - corner.pixel;
      equations.cost += error.squaredNorm();
      equations.H += J.transpose() * J;
      equations.g += J.transpose() * error;
    }
  }
  return equations;
}

Places moved(const Places& places, const VectorXd& step) {
  const auto lens = places.camera.parameters();
  std::vector<double> params(lens.begin(), lens.end());
  for (Eigen::Index i = 12; i < step.size(); ++i) params[static_cast<std::size_t>(i - 12)] += step[i];
  return {places.mount_from_camera * SE3::exp(step.head<6>()),
          places.world_from_board * SE3::exp(step.segment<6>(6)),
          step.size() > 12 ? places.camera.withParameters(params) : places.camera};
}

// The least sum of squared errors of all corners, with the robot's poses as they are (Levenberg and
// Marquardt).
std::optional<SE3> byReprojection(const Recording& recording, Places places, bool is_lens_free) {
  constexpr int kMaxSteps = 100;
  constexpr double kSmall = 1e-12;
  Equations here = equationsOf(recording, places, is_lens_free);
  double damping = 1e-4;
  for (int i = 0; i < kMaxSteps && std::isfinite(here.cost); ++i) {
    MatrixXd H = here.H;
    H.diagonal() *= 1 + damping;
    const VectorXd step = -H.ldlt().solve(here.g);
    if (-step.dot(here.g) <= kSmall * here.cost) return places.mount_from_camera;
    try {
      const Places next_places = moved(places, step);
      Equations next = equationsOf(recording, next_places, is_lens_free);
      if (next.cost <= here.cost) {
        places = next_places;
        here = std::move(next);
        damping *= 0.1;
        continue;
      }
    } catch (const Error&) {
      // The step has left the range of lenses.
    }
    damping *= 10;
  }
  return std::nullopt;
}

// Root mean square of the errors, millimetres, of the sets in which there is an answer.
struct Errors {
  double squares = 0;
  int num = 0;
  int num_failed = 0;

  void add(const std::optional<SE3>& found, const SE3& truth) {
    if (found) squares += (found->translation - truth.translation).squaredNorm();
    ++(found ? num : num_failed);
  }
  [[nodiscard]] double rmsMm() const { return 1000 * std::sqrt(squares / num); }
};

using MethodErrors = std::array<Errors, kMethods.size()>;

void addMethods(const RobotSet& set, MethodErrors& errors) {
  const Calibration calibration = calibrate(set.scene.board, set.views, cameraOptions());
  const Recording recording(set, calibration.fit);
  constexpr std::array kOpenCv = {cv::CALIB_HAND_EYE_TSAI, cv::CALIB_HAND_EYE_PARK, cv::CALIB_HAND_EYE_HORAUD,
                                  cv::CALIB_HAND_EYE_ANDREFF, cv::CALIB_HAND_EYE_DANIILIDIS};
  for (std::size_t k = 0; k < kNumOfOpenCv; ++k)
    errors[k].add(byOpenCv(recording, kOpenCv[k]), set.mount_from_camera);
  const auto start = byOpenCv(recording, cv::CALIB_HAND_EYE_PARK);
  for (const bool is_lens_free : {false, true}) {
    std::optional<SE3> found;
    if (start) {
      const SE3 world_from_board = recording.mount_from_world[0].inverse() * *start *
                                   cameraFromBoard(recording.fit, recording.fit.views[0]);
      found = byReprojection(recording, {*start, world_from_board, cameraOf(recording.fit)}, is_lens_free);
    }
    errors[is_lens_free ? 6 : 5].add(found, set.mount_from_camera);
  }
}

#ifdef ALIDADE_HAS_HANDEYE
// What calibrateHandEye() finds, and whether it knows how accurate that is.
struct JointFit {
  Errors errors;
  double num_covered = 0;  // tangent components within 1.96 standard deviations
  double rotation_ratio = 0;
  double translation_ratio = 0;

  void add(const RobotSet& set) {
    try {
      const HandEyeCalibration found =
          calibrateHandEye({&set.scene.board, 1}, set.views, set.robot,
                           {.camera = cameraOptions(), .camera_on = set.scene.camera_on});
      errors.add(found.mount_from_camera, set.mount_from_camera);
      const SE3::Tangent off = (found.mount_from_camera.inverse() * set.mount_from_camera).log();
      const Eigen::ArrayXd sigmas = found.covariance.diagonal().head<6>().array().sqrt();
      num_covered += static_cast<double>((off.array().abs() < 1.96 * sigmas).count());
      rotation_ratio += found.robot_noise.rotation_rad / set.scene.robot_noise.rotation_rad;
      translation_ratio += found.robot_noise.translation_m / set.scene.robot_noise.translation_m;
    } catch (const Error&) {
      errors.add(std::nullopt, set.mount_from_camera);
    }
  }
  void print(double best_mm) const {
    std::printf(" %9.3f %7.3f %8.1f %6.2f %6.2f %6d", errors.rmsMm(), errors.rmsMm() / best_mm,
                100 * num_covered / (6 * errors.num), rotation_ratio / errors.num,
                translation_ratio / errors.num, errors.num_failed);
  }
};
constexpr const char* kJointHeader = "   alidade / best  covered  turn/   mm/ failed";
#else
struct JointFit {
  void add(const RobotSet& /*set*/) {}
  void print(double /*best_mm*/) const {}
};
constexpr const char* kJointHeader = "";
#endif

void run(int num_sets, int num_views, CameraOn camera_on, std::uint64_t seed) {
  std::printf("%d views on the %s, RMS error of the translation, mm; %d sets per cell\n", num_views,
              std::string(cameraOnName(camera_on)).c_str(), num_sets);
  std::printf("%5s %5s %5s", "mrad", "mm", "px");
  for (const std::string_view method : kMethods) std::printf(" %11s", std::string(method).c_str());
  std::printf(" %11s %6s%s\n", "best", "failed", kJointHeader);
  for (const RobotNoise& robot_noise : kNoises) {
    for (const double corner_noise_px : kCornerNoises) {
      MethodErrors errors;
      JointFit joint;
      for (int i = 0; i < num_sets; ++i) {
        const RobotSet set = simulateRobot(sceneOf(robot_noise, corner_noise_px, num_views, camera_on),
                                           streamSeed(seed, static_cast<std::uint64_t>(i)));
        addMethods(set, errors);
        joint.add(set);
      }
      std::printf("%5.1f %5.2f %5.2f", 1000 * robot_noise.rotation_rad, 1000 * robot_noise.translation_m,
                  corner_noise_px);
      int num_failed = 0;
      for (const Errors& of : errors) {
        std::printf(" %11.3f", of.rmsMm());
        num_failed += of.num_failed;
      }
      const auto best = std::ranges::min_element(errors, {}, &Errors::rmsMm) - errors.begin();
      std::printf(" %11s %6d", std::string(kMethods[static_cast<std::size_t>(best)]).c_str(), num_failed);
      joint.print(errors[static_cast<std::size_t>(best)].rmsMm());
      std::printf("\n");
      std::fflush(stdout);
    }
  }
}

}  // namespace
}  // namespace alidade

int main(int argc, char** argv) {
  const int num_sets = argc > 1 ? std::atoi(argv[1]) : 40;
  const int num_views = argc > 2 ? std::atoi(argv[2]) : 15;
  const std::string on = argc > 3 ? argv[3] : "hand";
  const auto seed = static_cast<std::uint64_t>(argc > 4 ? std::atoll(argv[4]) : 1);
  if (num_sets < 1 || num_views < 3 || (on != "hand" && on != "base")) {
    std::fprintf(
        stderr,
        "usage: handeye_bench [sets per cell, at least 1] [views, at least 3] [hand | base] [seed]\n");
    return 2;
  }
  alidade::run(num_sets, num_views, on == "hand" ? alidade::CameraOn::kHand : alidade::CameraOn::kBase, seed);
  return 0;
}
