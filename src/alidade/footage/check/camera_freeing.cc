// SPDX-License-Identifier: MIT
#include "alidade/footage/check/camera_freeing.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "alidade/camera/camera_change.h"
#include "alidade/core/error.h"
#include "alidade/core/median.h"
#include "alidade/core/parallel.h"
#include "alidade/geometry/decompositions.h"
#include "alidade/geometry/least_squares.h"
#include "alidade/geometry/symmetric_eigen.h"

namespace alidade {
namespace {

constexpr int kMostSolveSteps = 40;

// Directions of the parameters, with the readout as the last one.
Eigen::MatrixXd withReadout(const Eigen::MatrixXd& directions) {
  Eigen::MatrixXd D = Eigen::MatrixXd::Zero(directions.rows() + 1, directions.cols() + 1);
  D.topLeftCorner(directions.rows(), directions.cols()) = directions;
  D(directions.rows(), directions.cols()) = 1;
  return D;
}

// Scales for the parameters, which differ by many orders of magnitude.
Eigen::VectorXd unitsOf(const Eigen::MatrixXd& A) {
  return A.diagonal().cwiseMax(1e-300).cwiseSqrt().cwiseInverse();
}
Eigen::VectorXd solveScaled(const Eigen::MatrixXd& A, const Eigen::VectorXd& b) {
  const Eigen::VectorXd unit = unitsOf(A);
  return unit.asDiagonal() *
         solveSpd(unit.asDiagonal() * A * unit.asDiagonal(), Eigen::VectorXd(unit.asDiagonal() * b));
}
Eigen::MatrixXd inverseScaled(const Eigen::MatrixXd& A) {
  const Eigen::VectorXd unit = unitsOf(A);
  const Eigen::MatrixXd scaled = unit.asDiagonal() * A * unit.asDiagonal();
  return unit.asDiagonal() * inverseSpd(scaled) * unit.asDiagonal();
}

// The scatter, raised to the information where it is smaller, which could only be chance.
Eigen::MatrixXd atLeast(const Eigen::MatrixXd& scatter, const Eigen::MatrixXd& information, double* mean) {
  const Eigen::VectorXd unit = unitsOf(information);
  Eigen::MatrixXd scaled = unit.asDiagonal() * information * unit.asDiagonal();
  scaled.diagonal().array() += 1e-10;
  const Eigen::MatrixXd root = choleskyOf(scaled);
  const Eigen::MatrixXd half = solveLower(root, unit.asDiagonal() * scatter * unit.asDiagonal());
  const SymmetricEigen eigen(solveLower(root, half.transpose()));
  const Eigen::VectorXd factors = eigen.eigenvalues().cwiseMax(1);
  *mean = factors.size() > 0 ? factors.mean() : 1;
  const Eigen::MatrixXd rotated = root.triangularView<Eigen::Lower>() * eigen.eigenvectors();
  const Eigen::VectorXd scale = unit.cwiseInverse();
  return scale.asDiagonal() * rotated * factors.asDiagonal() * rotated.transpose() * scale.asDiagonal();
}

}  // namespace

CameraFreeing::CameraFreeing(const AnyCamera& given, std::vector<Reconstruction> windows,
                             const FootageTracks& tracks, int num_jobs, const CancelFlag* cancel)
    : given_(given),
      windows_(std::move(windows)),
      num_jobs_(num_jobs),
      cancel_(cancel),
      is_video_(tracks.is_video) {
  const auto params = given.parameters();
  num_ = static_cast<Eigen::Index>(params.size()) + 1;
  start_ = Eigen::VectorXd::Zero(num_);
  for (std::size_t i = 0; i < params.size(); ++i) start_[static_cast<Eigen::Index>(i)] = params[i];
  setNoise();
  setPrior();
  field_px_ = 0.1;
  State state = unsolved();
  if (!settle(state)) return;
  const Eigen::MatrixXd all = Eigen::MatrixXd::Identity(num_ - 1, num_ - 1);
  constexpr double kLeast = 0.01;  // px
  constexpr int kRounds = 5;
  for (int round = 0; round < kRounds; ++round) {
    solve(state, all, 2);
    const double next = std::max(kLeast, std::sqrt(state.sums.field_square / state.sums.num_coefficients));
    const bool is_settled = std::abs(next - field_px_) < 0.2 * field_px_;
    field_px_ = next;
    setField(state);
    if (!settle(state)) return;
    if (is_settled) break;
  }
  const bool is_found = solve(state, all, kMostSolveSteps);
  State given_state = unsolved();
  if (!settle(given_state)) return;
  is_usable_ = solve(given_state, Eigen::MatrixXd(num_ - 1, 0), kMostSolveSteps);
  if (is_found) at_all_ = std::move(state);
  at_given_ = std::move(given_state);
}

std::optional<FreedCamera> CameraFreeing::given() const {
  if (!is_usable_) return std::nullopt;
  return freedAt(at_given_->at, at_given_->sums, Eigen::MatrixXd(num_ - 1, 0), true);
}

std::optional<FreedCamera> CameraFreeing::all() const {
  if (!is_usable_ || !at_all_) return std::nullopt;
  return freedAt(at_all_->at, at_all_->sums, Eigen::MatrixXd::Identity(num_ - 1, num_ - 1), true);
}

std::optional<FreedCamera> CameraFreeing::along(const Eigen::MatrixXd& directions) const {
  if (!is_usable_) return std::nullopt;
  State state = *at_given_;
  const bool is_converged = solve(state, directions, kMostSolveSteps);
  return freedAt(state.at, state.sums, directions, is_converged);
}

std::optional<FreedCamera> CameraFreeing::predictedAlong(const Eigen::MatrixXd& directions) const {
  if (!is_usable_) return std::nullopt;
  const Eigen::MatrixXd D = withReadout(directions);
  Sums sums = at_given_->sums;
  const Eigen::VectorXd pull = sums.gradient + prior_ * (at_given_->at - start_);
  const Eigen::VectorXd step =
      -D * solveScaled(D.transpose() * (sums.information + prior_) * D, D.transpose() * pull);
  sums.cost += sums.gradient.dot(step) + 0.5 * step.dot(sums.information * step);
  sums.gradient += sums.information * step;
  for (std::size_t w = 0; w < sums.window_gradients.size(); ++w)
    sums.window_gradients[w] += sums.window_informations[w] * step;
  return freedAt(at_given_->at + step, sums, directions, true);
}

std::optional<AnyCamera> CameraFreeing::cameraAt(const Eigen::VectorXd& at) const {
  return cameraWith(given_.modelId(), {at.data(), static_cast<std::size_t>(num_ - 1)});
}

std::optional<FreedCamera> CameraFreeing::freedAt(const Eigen::VectorXd& at, const Sums& sums,
                                                  const Eigen::MatrixXd& directions,
                                                  bool is_converged) const {
  const auto camera = cameraAt(at);
  if (!camera) return std::nullopt;
  FreedCamera freed{.camera = *camera,
                    .amounts = {},
                    .cost = sums.cost,
                    .covariance = {},
                    .amount_covariance = {},
                    .readout = at[num_ - 1],
                    .is_converged = is_converged};
  const Eigen::MatrixXd D = withReadout(directions);
  const Eigen::VectorXd change = at - start_;
  if (directions.cols() > 0) {
    const Eigen::MatrixXd gram = directions.transpose() * directions;
    freed.amounts = solveSpd(gram, Eigen::VectorXd(directions.transpose() * change.head(num_ - 1)));
  }
  const Eigen::MatrixXd information = D.transpose() * sums.information * D;
  const Eigen::MatrixXd prior = D.transpose() * prior_ * D;
  const Eigen::MatrixXd own = D.transpose() * sums.scatter * D;
  // Each window's gradient at the common optimum.
  const std::size_t num_windows = sums.window_gradients.size();
  if (num_windows > 1) {
    double sum = 0;
    for (std::size_t w = 0; w < num_windows; ++w) {
      const Eigen::MatrixXd scatter = D.transpose() * sums.window_scatters[w] * D + 1e-6 * prior;
      const Eigen::VectorXd gradient = D.transpose() * sums.window_gradients[w];
      sum += gradient.dot(solveScaled(scatter, gradient));
    }
    const double freedom = static_cast<double>(D.cols()) * static_cast<double>(num_windows - 1);
    freed.disagreement = sum / freedom;
  }
  const auto points = static_cast<double>(sums.num_points);
  const double few = points / std::max(1.0, points - static_cast<double>(D.cols()));
  const Eigen::MatrixXd scatter =
      std::max(1.0, freed.disagreement) * atLeast(few * own, information, &freed.dispersion);
  const Eigen::MatrixXd inverse = inverseScaled(information + prior);
  const Eigen::MatrixXd covariance = inverse * (scatter + prior) * inverse;
  freed.amount_covariance = Eigen::MatrixXd(covariance.topLeftCorner(directions.cols(), directions.cols()));
  freed.covariance = Eigen::MatrixXd(D * covariance * D.transpose());
  return freed;
}

double CameraFreeing::noisePx() const {
  double sum = 0;
  for (const Reconstruction& window : windows_) sum += window.noise_px;
  return sum / static_cast<double>(windows_.size());
}

void CameraFreeing::setNoise() {
  std::vector<double> noises;
  for (const Reconstruction& window : windows_) noises.push_back(noiseOf(*window.fit));
  noise_ = std::max(1e-3, medianOf(noises));
  for (Reconstruction& window : windows_) window.fit->loss = {.threshold_px = 2.5 * noise_};
}

// The prior acts like a measurement of the mean square change of the footage's pixels as zero, so
// undetermined parameters keep their values.
void CameraFreeing::setPrior() {
  Eigen::MatrixXd sum = Eigen::MatrixXd::Zero(num_, num_);
  double count = 0;
  for (const Reconstruction& window : windows_) {
    for (const SceneSighting& sighting : window.fit->sightings) {
      const SceneProjection p = projectSighting(*window.fit, sighting);
      if (!p.ok) continue;
      Eigen::MatrixXd J(2, num_);
      J << p.J_params, sighting.readout_px;
      sum += J.transpose() * J;
      count += 1;
    }
  }
  constexpr double kPriorPx = 20;  // standard deviation of plausible changes, RMS
  prior_ = sum / (std::max(1.0, count) * kPriorPx * kPriorPx);
  // Directions that do not move the pixels at all need a prior too.
  for (Eigen::Index i = 0; i < num_; ++i) prior_(i, i) += 1e-6 * prior_(i, i) + 1e-12;
  if (is_video_) {
    prior_(num_ - 1, num_ - 1) += 1;  // a readout takes at most the time of a frame
  } else {
    prior_(num_ - 1, num_ - 1) = 1e12;
  }
}

CameraFreeing::State CameraFreeing::unsolved() const {
  State state{.windows = windows_, .at = start_, .sums = {}};
  setField(state);
  return state;
}

// Sets the standard deviation of the coefficients in units of the pixels' noise.
void CameraFreeing::setField(State& state) const {
  for (Reconstruction& window : state.windows) {
    SceneFit& fit = *window.fit;
    fit.field_px = field_px_ / noise_;
    fit.fields.resize(fit.camera_from_world.size(), ErrorField::Coefficients::Zero());
  }
}

double CameraFreeing::priorCost(const Eigen::VectorXd& at) const {
  const Eigen::VectorXd change = at - start_;
  return 0.5 * change.dot(prior_ * change);
}

// Moves solved windows to the camera at these unknowns, to first order where that costs less than staying.
// @returns their cost; infinite if there is no such camera
double CameraFreeing::follow(State& state, const Eigen::VectorXd& at) const {
  const auto camera = cameraAt(at);
  if (!camera) return HUGE_VAL;
  double cost = 0;
  for (std::size_t w = 0; w < state.windows.size(); ++w) {
    SceneFit& fit = *state.windows[w].fit;
    SceneFit moved = fit;
    followCamera(moved, state.sums.window_responses[w], *camera, at - state.at);
    fit.camera = *camera;
    fit.readout = at[num_ - 1];
    const double moved_cost = sceneCost(moved);
    const double stayed_cost = sceneCost(fit);
    if (moved_cost < stayed_cost) fit = std::move(moved);
    cost += std::min(moved_cost, stayed_cost) / (noise_ * noise_);
  }
  state.at = at;
  return cost;
}

// Solves the windows for their camera. @returns false on failure
bool CameraFreeing::settle(State& state) const {
  if (!solveWindows(state.windows, num_jobs_, cancel_)) return false;
  state.sums = sumsOf(state.windows);
  return true;
}

CameraFreeing::Sums CameraFreeing::sumsOf(const std::vector<Reconstruction>& windows) const {
  std::vector<SceneEquations> equations(windows.size());
  parallelFor(windows.size(), num_jobs_,
              [&](std::size_t i) { equations[i] = sceneEquations(*windows[i].fit); });
  Sums sums;
  sums.information = Eigen::MatrixXd::Zero(num_, num_);
  sums.gradient = Eigen::VectorXd::Zero(num_);
  sums.scatter = Eigen::MatrixXd::Zero(num_, num_);
  const double unit = 1 / (noise_ * noise_);
  for (const SceneEquations& window : equations) {
    sums.cost += unit * window.cost;
    sums.information += unit * window.information.view();
    const Eigen::MatrixXd gradients = unit * window.point_gradients.view();
    sums.window_gradients.emplace_back(gradients.rowwise().sum() + unit * window.prior_gradient.view());
    sums.window_scatters.emplace_back(gradients * gradients.transpose());
    sums.window_informations.emplace_back(unit * window.information.view());
    sums.window_responses.emplace_back(window.J_optimum_camera.view());
    sums.gradient += sums.window_gradients.back();
    sums.scatter += sums.window_scatters.back();
    sums.num_points += static_cast<std::size_t>(gradients.cols());
    sums.field_square += window.field_square + noise_ * noise_ * window.field_variance;
    sums.num_coefficients += ErrorField::kSize * static_cast<double>(window.pose_covariance.rows() / 6 + 1);
  }
  return sums;
}

// Gauss-Newton steps on the windows' normal equations. @returns true if the optimum was reached
bool CameraFreeing::solve(State& state, const Eigen::MatrixXd& directions, int max_steps) const {
  const Eigen::MatrixXd D = withReadout(directions);
  double cost = state.sums.cost + priorCost(state.at);
  const DampingRule rule{
      .raised = [](double damping) { return damping > 1e8 / 8 ? HUGE_VAL : std::max(1e-2, damping * 8); },
      .lowered = [](double damping) { return damping > 1e-3 ? damping / 8 : 0; },
      .max_steps = max_steps};
  return minimise(rule, [&](double damping) {
    throwIfCancelled(cancel_);
    Eigen::MatrixXd A = D.transpose() * (state.sums.information + prior_) * D;
    A.diagonal() += damping * A.diagonal();
    const Eigen::VectorXd gradient = D.transpose() * (state.sums.gradient + prior_ * (state.at - start_));
    const Eigen::VectorXd delta = -solveScaled(A, gradient);
    const double promise = -0.5 * gradient.dot(delta);
    if (!(promise >= 0)) return StepResult::kFailed;
    if (promise < 1e-2 * (1 + damping)) return StepResult::kConverged;
    State trial = state;
    const Eigen::VectorXd at = state.at + D * delta;
    // From costlier starts, windows did not converge to a better scene in any footage that was tried; from
    // cheaper ones they often did.
    constexpr double kMostRise = 1000;
    if (!(follow(trial, at) + priorCost(at) < kMostRise * cost) || !settle(trial)) return StepResult::kWorse;
    const double trial_cost = trial.sums.cost + priorCost(trial.at);
    if (!(trial_cost <= cost + 1e-9 * cost)) return StepResult::kWorse;
    state = std::move(trial);
    cost = trial_cost;
    return StepResult::kBetter;
  });
}

}  // namespace alidade
