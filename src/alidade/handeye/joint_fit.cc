// SPDX-License-Identifier: MIT
#include "alidade/handeye/joint_fit.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <utility>

#include "alidade/adjust/board/errors.h"
#include "alidade/adjust/board/view_kernel.h"
#include "alidade/adjust/noise/covariance.h"
#include "alidade/core/error.h"
#include "alidade/geometry/decompositions.h"
#include "alidade/geometry/least_squares.h"
#include "alidade/geometry/symmetric_eigen.h"

namespace alidade {
namespace {

constexpr Eigen::Index kPose = 6;
// No robot or detector is better; a precision needs an end.
constexpr double kLeastRotation = 1e-8;     // rad
constexpr double kLeastTranslation = 1e-9;  // m
constexpr double kLeastCorner = 1e-5;       // px

using Matrix = Eigen::MatrixXd;
using Vector = Eigen::VectorXd;

SE3 gripperOf(const RobotFrame& frame) {
  return frame.base_from_gripper * SE3::exp(frame.deviation);
}

Vector6d precisionOf(const RobotFit& fit) {
  const double t = std::max(kLeastTranslation, fit.noise.translation_m);
  const double r = std::max(kLeastRotation, fit.noise.rotation_rad);
  const double variance = fit.corner_sigma_px * fit.corner_sigma_px;
  Vector6d precision;
  precision << Eigen::Vector3d::Constant(variance / (t * t)), Eigen::Vector3d::Constant(variance / (r * r));
  return precision;
}

double robotCost(const RobotFit& fit) {
  const Vector6d precision = precisionOf(fit);
  double cost = 0;
  for (const RobotFrame& frame : fit.frames) cost += frame.deviation.cwiseAbs2().dot(precision);
  return cost;
}

// Moves the poses of the views to where mount, boards and robot put them.
void placeViews(RobotFit& fit) {
  const SE3 camera_from_mount = fit.mount_from_camera.inverse();
  for (const RobotFrame& frame : fit.frames) {
    const SE3 motion = camera_from_mount * motionOf(fit.camera_on, gripperOf(frame));
    for (const std::size_t v : frame.views) {
      const FitView& view = fit.fit.views[v];
      setCameraFromBoard(fit.fit, view, motion * fit.world_from_boards[view.board]);
    }
  }
}

class Equations {
 public:
  explicit Equations(const RobotFit& fit)
      : kernel_(viewKernel(onlyCamera(fit.fit).model, onlyCamera(fit.fit).params.size())),
        directions_(freeDirections(kernel_.numParams(), onlyCamera(fit.fit).constraint)),
        num_shared_(directions_.cols() + kPose * (1 + std::ssize(fit.world_from_boards))) {
    for (const FitView& view : fit.fit.views) groups_.push_back(groupsOf(cornersOnShape(fit.fit, view)));
  }

  [[nodiscard]] Eigen::Index numShared() const { return num_shared_; }
  [[nodiscard]] Eigen::Index numFree() const { return directions_.cols(); }
  [[nodiscard]] const Matrix& directions() const { return directions_; }

  // Sum of rho; infinite where a corner has no pixel.
  [[nodiscard]] double cornersCost(const RobotFit& fit) const {
    const std::vector<double>& params = onlyCamera(fit.fit).params;
    double sum = 0;
    for (const RobotFrame& frame : fit.frames) {
      for (const std::size_t v : frame.views)
        sum += kernel_.sumOfRho(params.data(), cameraFromBoard(fit.fit, fit.fit.views[v]), groups_[v],
                                fit.fit.loss);
    }
    return std::isnan(sum) ? std::numeric_limits<double>::infinity() : sum;
  }

  // What the corners say of each frame's deviation and the shared unknowns: those of the camera, the mount
  // and the boards. Normal equations with the gradient in the last column.
  // @pre the views are placed, and every corner has a pixel
  [[nodiscard]] std::vector<Matrix> atPresent(const RobotFit& fit) const {
    std::vector<Matrix> all;
    for (const RobotFrame& frame : fit.frames) {
      Matrix normal = Matrix::Zero(kPose + num_shared_ + 1, kPose + num_shared_ + 1);
      for (const std::size_t v : frame.views) {
        const Matrix rows = rowsOf(fit, frame, v);
        normal.selfadjointView<Eigen::Lower>().rankUpdate(rows.transpose());
      }
      all.emplace_back(normal.selfadjointView<Eigen::Lower>());
    }
    return all;
  }

 private:
  [[nodiscard]] Matrix rowsOf(const RobotFit& fit, const RobotFrame& frame, std::size_t v) const {
    const FitView& view = fit.fit.views[v];
    const SE3 camera_from_board = cameraFromBoard(fit.fit, view);
    const auto factor = viewFactor(kernel_, onlyCamera(fit.fit).params, camera_from_board, groups_[v],
                                   fit.fit.loss, Unseen::kLeaveOut);
    expect(factor.has_value(), "a view of a solved fit");
    const std::size_t board = view.board;
    const Eigen::Index num_params = kernel_.numParams();
    const Eigen::Index at_mount = kPose + directions_.cols();
    Matrix J = Matrix::Zero(factor->cols(), kPose + num_shared_ + 1);
    const SE3& world_from_board = fit.world_from_boards[board];
    // A right perturbation of the gripper, the mount and the board, as one of camera_from_board.
    J.topLeftCorner<kPose, kPose>() =
        fit.camera_on == CameraOn::kHand
            ? Matrix6d(-(world_from_board.inverse() * gripperOf(frame)).adjoint())
            : world_from_board.inverse().adjoint();
    J.block<kPose, kPose>(0, at_mount) = -camera_from_board.inverse().adjoint();
    J.block<kPose, kPose>(0, at_mount + kPose * (1 + static_cast<Eigen::Index>(board))).setIdentity();
    J.block(kPose, kPose, num_params, directions_.cols()) = directions_;
    J(factor->cols() - 1, J.cols() - 1) = 1;
    return *factor * J;
  }

  const ViewKernel& kernel_;
  Matrix directions_;
  Eigen::Index num_shared_;
  std::vector<std::vector<CornerGroup>> groups_;
};

// The solution of the equations of all frames with the robot's noise as it is: the steps, and the covariance
// over the variance of a corner of weight 1.
struct Solution {
  Vector shared;
  std::vector<Vector6d> deviations;  // steps
  Matrix covariance;
  std::vector<Matrix6d> covariances;  // of the deviations
};

// @param num_known  of the shared unknowns, the first ones that are known
Solution solutionOf(const std::vector<Matrix>& frames, const std::vector<RobotFrame>& stated,
                    const Vector6d& precision, double damping, Eigen::Index num_known = 0) {
  const Eigen::Index num_shared = frames.front().cols() - kPose - 1;
  Matrix sum = Matrix::Zero(num_shared, num_shared);
  Vector gradient = Vector::Zero(num_shared);
  struct Own {
    Matrix6d inverse;
    Matrix gain;  // inverse * [shared, gradient]
  };
  std::vector<Own> own;
  for (std::size_t f = 0; f < frames.size(); ++f) {
    const Matrix& N = frames[f];
    const Matrix6d J = SE3::rightJacobianInverse(stated[f].deviation);
    Matrix6d H = N.topLeftCorner<kPose, kPose>();
    H += J.transpose() * precision.asDiagonal() * J;
    H.diagonal() *= 1 + damping;
    Matrix across = N.block(0, kPose, kPose, num_shared + 1);
    across.rightCols<1>() += J.transpose() * precision.cwiseProduct(stated[f].deviation);
    Matrix inverse;
    Matrix gain = solveSpd(H, across, &inverse);
    sum += N.block(kPose, kPose, num_shared, num_shared) -
           across.leftCols(num_shared).transpose() * gain.leftCols(num_shared);
    gradient += N.block(kPose, kPose + num_shared, num_shared, 1) -
                across.leftCols(num_shared).transpose() * gain.rightCols<1>();
    own.push_back({inverse, std::move(gain)});
  }
  sum.diagonal() *= 1 + damping;
  for (Eigen::Index i = 0; i < num_known; ++i) {
    sum.row(i).setZero();
    sum.col(i).setZero();
    sum(i, i) = 1;
    gradient(i) = 0;
  }
  // Parameters of different units.
  const Vector scale = sum.diagonal().cwiseMax(1e-300).cwiseSqrt().cwiseInverse();
  const Matrix scaled = scale.asDiagonal() * sum * scale.asDiagonal();
  Matrix inverse;
  Solution solution;
  solution.shared =
      -scale.cwiseProduct(solveSpd(scaled, Matrix(scale.cwiseProduct(gradient)), &inverse).col(0));
  solution.covariance = scale.asDiagonal() * inverse * scale.asDiagonal();
  for (Eigen::Index i = 0; i < num_known; ++i) solution.covariance(i, i) = 0;
  for (const Own& frame : own) {
    const Matrix by_shared = frame.gain.leftCols(num_shared);
    solution.deviations.emplace_back(-frame.gain.rightCols<1>() - by_shared * solution.shared);
    solution.covariances.emplace_back(frame.inverse +
                                      by_shared * solution.covariance * by_shared.transpose());
  }
  return solution;
}

// The number of a frame's coordinates, of translation and rotation, that the corners determine.
std::array<double, 2> numFree(const Matrix6d& covariance, const Vector6d& precision) {
  const Vector6d known = precision.cwiseProduct(covariance.diagonal());
  return {3 - known.head<3>().sum(), 3 - known.tail<3>().sum()};
}

// One step of restricted maximum likelihood; returns the largest relative change.
double updateNoise(const Solution& solution, RobotFit& fit) {
  const Vector6d precision = precisionOf(fit);
  std::array<double, 2> squares{};
  std::array<double, 2> num_free{};
  for (std::size_t f = 0; f < fit.frames.size(); ++f) {
    const Vector6d deviation = fit.frames[f].deviation + solution.deviations[f];
    const auto own = numFree(solution.covariances[f], precision);
    for (std::size_t part : {0U, 1U}) {
      squares[part] += deviation.segment<3>(3 * static_cast<Eigen::Index>(part)).squaredNorm();
      num_free[part] += own[part];
    }
  }
  double change = 0;
  const auto update = [&](double& sigma, double least, std::size_t part) {
    const double next = std::max(least, std::sqrt(squares[part] / std::max(num_free[part], 1e-9)));
    // What the corners do not determine needs no digits.
    const double share = num_free[part] / (3 * static_cast<double>(fit.frames.size()));
    change = std::max(change, share * std::abs(std::log(next / std::max(least, sigma))));
    sigma = next;
  };
  update(fit.noise.translation_m, kLeastTranslation, 0);
  update(fit.noise.rotation_rad, kLeastRotation, 1);
  return change;
}

void updateCorners(const Equations& equations, const Solution& solution, RobotFit& fit) {
  const Vector6d precision = precisionOf(fit);
  double num_free = static_cast<double>(equations.numShared());
  for (const Matrix6d& covariance : solution.covariances) {
    const auto own = numFree(covariance, precision);
    num_free += own[0] + own[1];
  }
  for (FitView& view : fit.fit.views) view.errors = viewErrors(fit.fit, view);
  fit.corner_sigma_px =
      std::max(kLeastCorner, std::sqrt(coordinateVariance(weightedErrors(fit.fit), fit.fit.loss, num_free)));
}

RobotFit moved(const RobotFit& fit, const Equations& equations, const Solution& step) {
  RobotFit next = fit;
  FitCamera& camera = next.fit.cameras.front();
  const Eigen::Index free = equations.numFree();
  Eigen::Map<Vector>(camera.params.data(), std::ssize(camera.params)) +=
      equations.directions() * step.shared.head(free);
  next.mount_from_camera = fit.mount_from_camera * SE3::exp(step.shared.segment<kPose>(free));
  for (std::size_t b = 0; b < fit.world_from_boards.size(); ++b) {
    const Eigen::Index at = free + kPose * (1 + static_cast<Eigen::Index>(b));
    next.world_from_boards[b] = fit.world_from_boards[b] * SE3::exp(step.shared.segment<kPose>(at));
  }
  for (std::size_t f = 0; f < fit.frames.size(); ++f)
    next.frames[f].deviation = (SE3::exp(fit.frames[f].deviation) * SE3::exp(step.deviations[f])).log();
  placeViews(next);
  return next;
}

// The length of a frame's deviation over that expected of the coordinates that the corners determine.
double sigmasOf(const RobotFrame& frame, const Matrix6d& covariance, const Vector6d& precision,
                double corner_sigma_px) {
  constexpr double kDetermined = 1e-3;
  const Vector6d root = precision.cwiseSqrt();
  const SymmetricEigen eigen(Matrix6d::Identity() - root.asDiagonal() * covariance * root.asDiagonal());
  const Vector6d normal = eigen.eigenvectors().transpose() * root.cwiseProduct(frame.deviation);
  double squares = 0;
  int count = 0;
  for (Eigen::Index i = 0; i < kPose; ++i) {
    if (eigen.eigenvalues()(i) < kDetermined) continue;
    squares += normal(i) * normal(i) / eigen.eigenvalues()(i);
    ++count;
  }
  return count > 0 ? std::sqrt(squares / count) / corner_sigma_px : 0;
}

// With the camera's parameters in place of their free directions.
Matrix withAllParams(const Equations& equations, const Matrix& covariance) {
  const Eigen::Index num_params = equations.directions().rows();
  const Eigen::Index free = equations.numFree();
  Matrix all = Matrix::Zero(num_params + equations.numShared() - free, equations.numShared());
  all.topLeftCorner(num_params, free) = equations.directions();
  all.bottomRightCorner(equations.numShared() - free, equations.numShared() - free).setIdentity();
  return all * covariance * all.transpose();
}

}  // namespace

SE3 motionOf(CameraOn on, const SE3& base_from_gripper) {
  return on == CameraOn::kHand ? base_from_gripper.inverse() : base_from_gripper;
}

RobotFit solved(RobotFit fit, const CancelFlag* cancel) {
  constexpr int kMaxNoiseSteps = 100;
  constexpr double kSameNoise = 1e-4;
  constexpr double kSameCost = 1e-10;  // of rounding
  constexpr double kUndamped = 1e-6;
  constexpr double kSettled = 1e-4;  // variances of a corner: a hundredth of a standard deviation
  // Raised from the first worse step on.
  constexpr DampingRule kRule = {.start = 0,
                                 .raised = [](double d) { return d > 0 ? 10 * d : 1e-4; },
                                 .lowered = [](double d) { return d > 1e-6 ? 0.1 * d : 0; },
                                 .max_steps = 60};
  fit.corner_sigma_px = std::max(kLeastCorner, fit.corner_sigma_px);
  const Equations equations(fit);
  placeViews(fit);
  double corners = equations.cornersCost(fit);
  std::vector<Matrix> frames = equations.atPresent(fit);
  fit.is_converged = minimise(kRule, [&](double damping) {
    throwIfCancelled(cancel);
    const RobotNoise before = fit.noise;
    double change = 0;
    for (int i = 0; i < kMaxNoiseSteps; ++i) {
      const Solution plain = solutionOf(frames, fit.frames, precisionOf(fit), 0);
      const double step = updateNoise(plain, fit);
      if (i == 0) change = step;
      if (step < kSameNoise) break;
    }
    const Solution solution = solutionOf(frames, fit.frames, precisionOf(fit), damping);
    RobotFit next = moved(fit, equations, solution);
    const double next_corners = equations.cornersCost(next);
    const double cost = corners + robotCost(fit);
    const double gain = cost - next_corners - robotCost(next);
    if (!(gain >= -kSameCost * cost)) {
      fit.noise = before;
      return StepResult::kWorse;
    }
    fit = std::move(next);
    corners = next_corners;
    const double sigma_before = fit.corner_sigma_px;
    updateCorners(equations, solution, fit);
    frames = equations.atPresent(fit);
    const bool is_settled = damping <= kUndamped && change < 10 * kSameNoise &&
                            gain <= kSettled * std::pow(sigma_before, 2) &&
                            std::abs(std::log(fit.corner_sigma_px / sigma_before)) < kSameNoise;
    return is_settled ? StepResult::kConverged : StepResult::kBetter;
  });
  const Vector6d precision = precisionOf(fit);
  const Solution last = solutionOf(frames, fit.frames, precision, 0);
  const double variance = fit.corner_sigma_px * fit.corner_sigma_px;
  fit.covariance = variance * withAllParams(equations, last.covariance);
  fit.noise_freedom = {};
  for (std::size_t f = 0; f < fit.frames.size(); ++f) {
    fit.frames[f].sigmas = sigmasOf(fit.frames[f], last.covariances[f], precision, fit.corner_sigma_px);
    const auto own = numFree(last.covariances[f], precision);
    for (std::size_t part : {0U, 1U}) fit.noise_freedom[part] += own[part];
  }
  return fit;
}

Eigen::MatrixXd covarianceWith(const RobotFit& fit, const RobotNoiseShares& shares) {
  const Equations equations(fit);
  RobotFit other = fit;
  other.corner_sigma_px *= shares.corners;
  other.noise.translation_m *= shares.translation;
  other.noise.rotation_rad *= shares.rotation;
  const Solution solution = solutionOf(equations.atPresent(fit), fit.frames, precisionOf(other), 0,
                                       shares.is_lens_known ? equations.numFree() : 0);
  return other.corner_sigma_px * other.corner_sigma_px * withAllParams(equations, solution.covariance);
}

RobotScale robotScale(const RobotFit& fit) {
  const Equations equations(fit);
  const Eigen::Index last = equations.numShared();
  std::vector<Matrix> frames = equations.atPresent(fit);
  for (std::size_t f = 0; f < frames.size(); ++f) {
    // Longer lengths of the robot move the gripper along its own position.
    const RobotFrame& frame = fit.frames[f];
    Matrix J = Matrix::Zero(kPose + last + 1, kPose + last + 2);
    J.leftCols(kPose + last).setIdentity();
    J.col(kPose + last).head<3>() = gripperOf(frame).rotation.inverse() * frame.base_from_gripper.translation;
    J(kPose + last, kPose + last + 1) = 1;
    frames[f] = Matrix(J.transpose() * frames[f] * J);
  }
  const Solution solution = solutionOf(frames, fit.frames, precisionOf(fit), 0);
  return {solution.shared(last), fit.corner_sigma_px * std::sqrt(solution.covariance(last, last))};
}

}  // namespace alidade
