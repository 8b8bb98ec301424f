// SPDX-License-Identifier: MIT
#include "alidade/adjust/scene/scene_fit.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <vector>

#include <gtest/gtest.h>
#include <Eigen/LU>
#include <Eigen/QR>

#include "alidade/core/random.h"

namespace alidade {
namespace {

constexpr std::size_t kFrames = 4;

// Points at 2 to 5 m before a camera that moves, most of which are seen in all frames; pixels with noise.
SceneFit someScene(double noise_px, double field_px, std::size_t num_held) {
  Random random(31);
  SceneFit fit{.camera = AnyCamera::make(
                   "radtan", std::vector<double>{520, 521, 318, 243, -0.28, 0.09, 0.001, -0.0005, 0.0}),
               .camera_from_world = {},
               .points = {},
               .sightings = {},
               .num_held_frames = num_held,
               .readout = 0.2,
               .size = {640, 480},
               .field_px = field_px};
  for (std::size_t i = 0; i < kFrames; ++i) {
    const auto t = static_cast<double>(i);
    fit.camera_from_world.push_back(
        {SO3::exp(0.02 * t * Eigen::Vector3d(1, -2, 0.5)), t * Eigen::Vector3d(0.3, -0.1, 0.15)});
    if (field_px > 0) {
      ErrorField::Coefficients& field = fit.fields.emplace_back();
      for (double& value : field) value = field_px * random.normal();
    }
  }
  while (fit.points.size() < 40) {
    const Eigen::Vector2d pixel(random.uniform(60, 580), random.uniform(60, 420));
    const Eigen::Vector3d p = random.uniform(2, 5) * *fit.camera.unproject(pixel);
    const auto id = static_cast<std::uint32_t>(fit.points.size());
    std::vector<SceneSighting> seen;
    for (std::size_t i = 0; i < kFrames; ++i) {
      const Projection projection = fit.camera.project(fit.camera_from_world[i] * p);
      if (!projection.ok() || random.uniform() < 0.1) continue;
      SceneSighting sighting{.frame = static_cast<std::uint32_t>(i), .point = id, .pixel = projection.pixel};
      sighting.sigma_px = random.uniform(0.5, 1.5);
      sighting.readout_px = {random.uniform(-3, 3), random.uniform(-3, 3)};
      sighting.pixel += fit.readout * sighting.readout_px;
      sighting.pixel += noise_px * Eigen::Vector2d(random.normal(), random.normal());
      seen.push_back(sighting);
    }
    if (seen.size() < 3) continue;
    fit.points.emplace_back(p.homogeneous().normalized());
    fit.sightings.insert(fit.sightings.end(), seen.begin(), seen.end());
  }
  return fit;
}

TEST(SceneFit, DerivativesAreThoseOfTheError) {
  const SceneFit fit = someScene(0.3, 0.2, 1);
  constexpr double kStep = 1e-6;
  int num_checked = 0;
  double worst = 0;
  // Both ways by a step, of an error that is linear to within its square.
  const auto compare = [&](const auto& apply, const SceneSighting& sighting,
                           const Eigen::Vector2d& expected) {
    SceneFit ahead = fit;
    SceneFit back = fit;
    apply(ahead, kStep);
    apply(back, -kStep);
    const Eigen::Vector2d numeric =
        (sightingError(ahead, sighting) - sightingError(back, sighting)) / (2 * kStep);
    worst = std::max(worst, (numeric - expected).norm() / (1 + expected.norm()));
    ++num_checked;
  };
  for (std::size_t s = 0; s < fit.sightings.size(); s += 10) {
    const SceneSighting& sighting = fit.sightings[s];
    const SceneProjection p = projectSighting(fit, sighting);
    ASSERT_TRUE(p.ok);
    EXPECT_LT((p.error - sightingError(fit, sighting)).norm(), 1e-12);
    for (Eigen::Index k = 0; k < 6; ++k) {
      const auto apply = [&](SceneFit& to, double step) {
        to.camera_from_world[sighting.frame] =
            to.camera_from_world[sighting.frame] * SE3::exp(step * Eigen::Matrix<double, 6, 1>::Unit(k));
      };
      compare(apply, sighting, p.J_pose.col(k));
    }
    for (Eigen::Index k = 0; k < 4; ++k) {
      compare([&](SceneFit& to, double step) { to.points[sighting.point][k] += step; }, sighting,
              p.J_point.col(k));
    }
    for (Eigen::Index k = 0; k < p.J_params.cols(); ++k) {
      const auto apply = [&](SceneFit& to, double step) {
        std::vector<double> params(to.camera.parameters().begin(), to.camera.parameters().end());
        params[static_cast<std::size_t>(k)] += step;
        to.camera = AnyCamera::make(to.camera.modelId(), params);
      };
      compare(apply, sighting, p.J_params.col(k));
    }
    for (Eigen::Index k = 0; k < ErrorField::kSize; ++k) {
      const bool is_x = k < ErrorField::kTerms;
      const double value = p.field[k % ErrorField::kTerms];
      compare([&](SceneFit& to, double step) { to.fields[sighting.frame][k] += step; }, sighting,
              is_x ? Eigen::Vector2d(value, 0) : Eigen::Vector2d(0, value));
    }
  }
  EXPECT_GE(num_checked, 10 * (6 + 4 + 9 + ErrorField::kSize));
  EXPECT_LT(worst, 1e-6);
}

// All unknowns in one dense system: poses, fields, points, then the camera and the readout.
struct DenseSystem {
  Eigen::MatrixXd normal;
  Eigen::VectorXd gradient;
  Eigen::Index num_camera = 0;
};

DenseSystem denseSystem(const SceneFit& fit) {
  const auto num_params = static_cast<Eigen::Index>(fit.camera.parameters().size());
  const auto num_pose = 6 * static_cast<Eigen::Index>(kFrames - fit.num_held_frames);
  const Eigen::Index num_field =
      fit.field_px > 0 ? ErrorField::kSize * static_cast<Eigen::Index>(kFrames) : 0;
  const auto num_point = 3 * static_cast<Eigen::Index>(fit.points.size());
  const Eigen::Index camera_at = num_pose + num_field + num_point;
  const Eigen::Index n = camera_at + num_params + 1;
  DenseSystem system{.normal = Eigen::MatrixXd::Zero(n, n), .gradient = Eigen::VectorXd::Zero(n)};
  system.num_camera = num_params + 1;
  for (const SceneSighting& sighting : fit.sightings) {
    const SceneProjection p = projectSighting(fit, sighting);
    Eigen::MatrixXd J = Eigen::MatrixXd::Zero(2, n);
    const auto frame = static_cast<Eigen::Index>(sighting.frame);
    if (sighting.frame >= fit.num_held_frames)
      J.middleCols<6>(6 * (frame - static_cast<Eigen::Index>(fit.num_held_frames))) = p.J_pose;
    if (num_field > 0) {
      const Eigen::Index at = num_pose + ErrorField::kSize * frame;
      J.block<1, ErrorField::kTerms>(0, at) = p.field.transpose();
      J.block<1, ErrorField::kTerms>(1, at + ErrorField::kTerms) = p.field.transpose();
    }
    J.middleCols<3>(num_pose + num_field + 3 * static_cast<Eigen::Index>(sighting.point)) =
        p.J_point * pointTangent(fit.points[sighting.point]);
    J.middleCols(camera_at, num_params) = p.J_params;
    J.col(n - 1) = sighting.readout_px;
    const Eigen::Vector2d error = p.error / sighting.sigma_px;
    const double weight = fit.loss.weight(error.squaredNorm());
    J /= sighting.sigma_px;
    system.normal += weight * J.transpose() * J;
    system.gradient += weight * J.transpose() * error;
  }
  for (Eigen::Index i = 0; i < num_field; ++i) {
    system.normal(num_pose + i, num_pose + i) += 1 / (fit.field_px * fit.field_px);
    system.gradient[num_pose + i] +=
        fit.fields[static_cast<std::size_t>(i / ErrorField::kSize)][i % ErrorField::kSize] /
        (fit.field_px * fit.field_px);
  }
  return system;
}

TEST(SceneFit, EquationsAreTheSchurComplementOfAllUnknowns) {
  int num_cases = 0;
  for (const double field_px : {0.0, 0.2}) {
    for (const std::size_t num_held : {std::size_t{1}, std::size_t{2}}) {
      SCOPED_TRACE(num_held);
      SceneFit fit = someScene(0.5, field_px, num_held);
      fit.loss = {.threshold_px = 0.8};  // so that some weights are below 1
      const SceneEquations equations = sceneEquations(fit);
      const DenseSystem dense = denseSystem(fit);
      const Eigen::Index k = dense.num_camera;
      const Eigen::Index m = dense.normal.rows() - k;
      // The least-norm solution: with one frame held the scale is free.
      const Eigen::MatrixXd B = dense.normal.topRightCorner(m, k);
      const Eigen::CompleteOrthogonalDecomposition<Eigen::MatrixXd> gone(dense.normal.topLeftCorner(m, m));
      const Eigen::MatrixXd T = gone.solve(B);
      const Eigen::MatrixXd information = dense.normal.bottomRightCorner(k, k) - B.transpose() * T;
      const Eigen::VectorXd gradient = dense.gradient.tail(k) - T.transpose() * dense.gradient.head(m);
      const Eigen::VectorXd unit = information.diagonal().cwiseSqrt().cwiseInverse();
      const Eigen::MatrixXd found = equations.information.view();
      // Free and weak directions are held by 1e-13 of the poses' information, which is 1e7 times the weakest.
      EXPECT_LT((unit.asDiagonal() * (found - information) * unit.asDiagonal()).cwiseAbs().maxCoeff(), 1e-5);
      const Eigen::VectorXd found_gradient =
          equations.point_gradients.view().rowwise().sum() + equations.prior_gradient.view();
      const Eigen::VectorXd scaled = unit.asDiagonal() * (found_gradient - gradient);
      EXPECT_LT(scaled.norm(), 1e-5 * (1 + (unit.asDiagonal() * gradient).norm()));
      ++num_cases;
    }
  }
  EXPECT_EQ(num_cases, 4);
}

// A point moved to where the sightings of it that are left fit best, the poses unchanged.
void placePoint(SceneFit& fit, std::uint32_t point, std::size_t left_out) {
  for (int step = 0; step < 20; ++step) {
    const Eigen::Matrix<double, 4, 3> tangent = pointTangent(fit.points[point]);
    Eigen::Matrix3d V = Eigen::Matrix3d::Zero();
    Eigen::Vector3d v = Eigen::Vector3d::Zero();
    for (std::size_t i = 0; i < fit.sightings.size(); ++i) {
      if (fit.sightings[i].point != point || i == left_out) continue;
      const SceneProjection p = projectSighting(fit, fit.sightings[i]);
      const Eigen::Matrix<double, 2, 3> J = p.J_point * tangent / fit.sightings[i].sigma_px;
      V += J.transpose() * J;
      v += J.transpose() * p.error / fit.sightings[i].sigma_px;
    }
    fit.points[point] = (fit.points[point] - tangent * V.ldlt().solve(v)).normalized();
  }
}

TEST(SceneFit, HeldOutErrorsAreThoseWithoutTheSighting) {
  SceneFit fit = someScene(0.1, 0, kFrames);
  const std::size_t none = fit.sightings.size();
  for (std::uint32_t point = 0; point < fit.points.size(); ++point) placePoint(fit, point, none);
  const std::vector<Eigen::Vector2d> errors = heldOutErrors(fit);
  ASSERT_EQ(errors.size(), fit.sightings.size());
  int num_checked = 0;
  int num_larger = 0;
  for (std::size_t i = 0; i < fit.sightings.size(); ++i) {
    ASSERT_TRUE(errors[i].allFinite());
    SceneFit without = fit;
    placePoint(without, fit.sightings[i].point, i);
    const Eigen::Vector2d expected = sightingError(without, fit.sightings[i]);
    EXPECT_LT((errors[i] - expected).norm(), 0.02 * expected.norm() + 1e-3);
    num_larger += errors[i].norm() > sightingError(fit, fit.sightings[i]).norm() ? 1 : 0;
    ++num_checked;
  }
  EXPECT_GE(num_checked, 120);
  EXPECT_EQ(num_larger, num_checked);
}

// A scene off its optimum: poses, points and, if there are fields, their targets.
SceneFit disturbed(SceneFit fit, std::uint64_t seed) {
  Random random(seed);
  for (SceneSighting& sighting : fit.sightings)
    sighting.pixel += Eigen::Vector2d(random.normal(), random.normal());
  for (std::size_t i = fit.num_held_frames; i < kFrames; ++i) {
    Eigen::Matrix<double, 6, 1> step;
    for (double& value : step) value = 0.003 * random.normal();
    fit.camera_from_world[i] = fit.camera_from_world[i] * SE3::exp(step);
  }
  return fit;
}

TEST(SceneFit, SolvedSceneHasNoGradient) {
  int num_cases = 0;
  for (const double field_px : {0.0, 0.2}) {
    for (const std::size_t num_held : {std::size_t{1}, std::size_t{2}, kFrames}) {
      for (const double huber_px : {1.5, std::numeric_limits<double>::infinity()}) {
        SceneFit fit = disturbed(someScene(0.5, field_px, num_held), 41);
        fit.loss = {.threshold_px = huber_px};
        const double before = sceneCost(fit);
        const SceneFit solved = solveScene(fit, {.max_iterations = 500, .function_tolerance = 1e-14});
        EXPECT_EQ(solved.summary.termination, Termination::kConverged) << solved.summary.reason;
        EXPECT_DOUBLE_EQ(solved.summary.cost, sceneCost(solved));
        EXPECT_LT(solved.summary.cost, before);
        const DenseSystem at_start = denseSystem(fit);
        const DenseSystem at_end = denseSystem(solved);
        const Eigen::Index m = at_end.normal.rows() - at_end.num_camera;
        EXPECT_LT(at_end.gradient.head(m).norm(), 1e-4 * at_start.gradient.head(m).norm())
            << field_px << " px, " << num_held << " held, Huber " << huber_px;
        ++num_cases;
      }
    }
  }
  EXPECT_EQ(num_cases, 12);
}

TEST(SceneFit, FollowsTheCameraToSecondOrder) {
  int num_cases = 0;
  for (const double field_px : {0.0, 0.2}) {
    const SolveOptions options{.max_iterations = 200, .function_tolerance = 1e-14};
    const SceneFit solved = solveScene(disturbed(someScene(0, field_px, 2), 42), options);
    const SceneEquations equations = sceneEquations(solved);
    const auto excess = [&](double share) {
      const auto params = solved.camera.parameters();
      Eigen::VectorXd delta = Eigen::VectorXd::Zero(std::ssize(params) + 1);
      delta[0] = delta[1] = share * params[0];
      std::vector<double> changed(params.begin(), params.end());
      for (std::size_t i = 0; i < changed.size(); ++i) changed[i] += delta[static_cast<Eigen::Index>(i)];
      SceneFit followed = solved;
      followCamera(followed, equations.J_optimum_camera, AnyCamera::make(solved.camera.modelId(), changed),
                   delta);
      const double cost = sceneCost(followed);
      return cost - solveScene(followed, options).summary.cost;
    };
    // Off by the square of the change: a cost of its fourth power.
    const double large = excess(4e-3);
    const double small = excess(1e-3);
    EXPECT_GT(small, 0) << field_px;
    EXPECT_GT(large, 100 * small) << field_px;
    ++num_cases;
  }
  EXPECT_EQ(num_cases, 2);
}

TEST(SceneFit, CannotStartWithoutAPixel) {
  SceneFit fit = someScene(0, 0, 1);
  fit.points[fit.sightings.front().point] = Eigen::Vector4d(0, 0, -1, 0);
  EXPECT_TRUE(std::isinf(sceneCost(fit)));
  const SceneFit solved = solveScene(fit, {});
  EXPECT_EQ(solved.summary.termination, Termination::kFailed);
  EXPECT_EQ(solved.summary.reason, "a point cannot be projected at the start");
}

TEST(SceneFit, SolvedSceneIsTheTrueOne) {
  SceneFit truth = someScene(0, 0, 2);
  SceneFit start = truth;
  Random random(32);
  for (std::size_t i = 2; i < kFrames; ++i) {
    Eigen::Matrix<double, 6, 1> step;
    for (double& value : step) value = 0.01 * random.normal();
    start.camera_from_world[i] = start.camera_from_world[i] * SE3::exp(step);
  }
  for (Eigen::Vector4d& point : start.points) {
    const Eigen::Vector4d noise(random.normal(), random.normal(), random.normal(), random.normal());
    point = (point + 0.005 * noise).normalized();
  }
  const SceneFit solved = solveScene(start, {.max_iterations = 50, .function_tolerance = 1e-14});
  EXPECT_EQ(solved.summary.termination, Termination::kConverged);
  for (std::size_t i = 2; i < kFrames; ++i)
    EXPECT_LT((solved.camera_from_world[i].inverse() * truth.camera_from_world[i]).log().norm(), 1e-6);
  for (const SceneSighting& sighting : solved.sightings)
    EXPECT_LT(sightingError(solved, sighting).norm(), 1e-4);
}

}  // namespace
}  // namespace alidade
