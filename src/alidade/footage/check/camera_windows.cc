// SPDX-License-Identifier: MIT
#include "alidade/footage/check/camera_windows.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>

#include "alidade/adjust/scene/scene_fit.h"
#include "alidade/core/error.h"
#include "alidade/core/median.h"
#include "alidade/core/parallel.h"

namespace alidade {
namespace {

// Of what two frames share: how far its points move.
double medianMotion(const std::vector<TrackPixel>& a, const std::vector<TrackPixel>& b, double* shared) {
  std::vector<double> motions;
  for (const auto& [i, j] : commonTracks(a, b)) motions.push_back((a[i].pixel - b[j].pixel).norm());
  *shared = a.empty() ? 0 : static_cast<double>(motions.size()) / static_cast<double>(a.size());
  return motions.empty() ? std::numeric_limits<double>::infinity() : medianOf(std::move(motions));
}

constexpr int kMostSteps = 40;

// Directions of the parameters, with the readout as a last one.
Eigen::MatrixXd withReadout(const Eigen::MatrixXd& directions) {
  Eigen::MatrixXd D = Eigen::MatrixXd::Zero(directions.rows() + 1, directions.cols() + 1);
  D.topLeftCorner(directions.rows(), directions.cols()) = directions;
  D(directions.rows(), directions.cols()) = 1;
  return D;
}

// Parameters differ by many orders of magnitude.
Eigen::VectorXd unitsOf(const Eigen::MatrixXd& A) {
  return A.diagonal().cwiseMax(1e-300).cwiseSqrt().cwiseInverse();
}
Eigen::VectorXd solveScaled(const Eigen::MatrixXd& A, const Eigen::VectorXd& b) {
  const Eigen::VectorXd unit = unitsOf(A);
  return unit.asDiagonal() * (unit.asDiagonal() * A * unit.asDiagonal()).ldlt().solve(unit.asDiagonal() * b);
}
Eigen::MatrixXd inverseScaled(const Eigen::MatrixXd& A) {
  const Eigen::VectorXd unit = unitsOf(A);
  const Eigen::MatrixXd scaled = unit.asDiagonal() * A * unit.asDiagonal();
  return unit.asDiagonal() * scaled.ldlt().solve(Eigen::MatrixXd::Identity(A.rows(), A.cols())) *
         unit.asDiagonal();
}

// The scatter, in no direction less than the information: that would be by chance.
Eigen::MatrixXd atLeast(const Eigen::MatrixXd& scatter, const Eigen::MatrixXd& information, double* mean) {
  const Eigen::VectorXd unit = unitsOf(information);
  Eigen::MatrixXd scaled = unit.asDiagonal() * information * unit.asDiagonal();
  scaled.diagonal().array() += 1e-10;
  const Eigen::LLT<Eigen::MatrixXd> root(scaled);
  const Eigen::MatrixXd half =
      root.matrixL().solve(Eigen::MatrixXd(unit.asDiagonal() * scatter * unit.asDiagonal()));
  const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> eigen(
      Eigen::MatrixXd(root.matrixL().solve(Eigen::MatrixXd(half.transpose()))));
  const Eigen::VectorXd factors = eigen.eigenvalues().cwiseMax(1);
  *mean = factors.size() > 0 ? factors.mean() : 1;
  const Eigen::MatrixXd rotated = root.matrixL() * eigen.eigenvectors();
  const Eigen::VectorXd scale = unit.cwiseInverse();
  return scale.asDiagonal() * rotated * factors.asDiagonal() * rotated.transpose() * scale.asDiagonal();
}

}  // namespace

// The windows' sums at one camera.
struct CameraFreeing::Sums {
  double cost = 0;  // of the pixels, in units of their noise
  Eigen::MatrixXd information;
  Eigen::VectorXd gradient;
  Eigen::MatrixXd scatter;                        // by points
  std::vector<Eigen::VectorXd> window_gradients;  // and each one's scatter
  std::vector<Eigen::MatrixXd> window_scatters;
  std::vector<Eigen::MatrixXd> window_informations;
  std::size_t num_points = 0;
  double field_square = 0;  // expected, px^2, of so many coefficients
  double num_coefficients = 0;
};

// The windows, solved at a camera.
struct CameraFreeing::State {
  std::vector<Reconstruction> windows;
  Eigen::VectorXd at;
  Sums sums;
};

CameraFreeing::CameraFreeing(const AnyCamera& given, std::vector<Reconstruction> windows,
                             const FootageTracks& tracks, const FreeingOptions& options)
    : given_(given), windows_(std::move(windows)), options_(options), is_video_(tracks.is_video) {
  const auto params = given.parameters();
  num_ = static_cast<Eigen::Index>(params.size()) + 1;
  start_ = Eigen::VectorXd::Zero(num_);
  for (std::size_t i = 0; i < params.size(); ++i) start_[static_cast<Eigen::Index>(i)] = params[i];
  setNoise();
  setPrior();
  field_px_ = 0.1;
  State state{.windows = windows_, .at = start_, .sums = {}};
  setField(state, field_px_);
  if (!solveAt(state, start_)) return;
  state.sums = sumsAt(state);
  const Eigen::MatrixXd all = Eigen::MatrixXd::Identity(num_ - 1, num_ - 1);
  constexpr double kLeast = 0.01;  // px
  constexpr int kRounds = 5;
  for (int round = 0; round < kRounds; ++round) {
    minimise(state, all, 2);
    const double next = std::max(kLeast, std::sqrt(state.sums.field_square / state.sums.num_coefficients));
    const bool is_settled = std::abs(next - field_px_) < 0.2 * field_px_;
    field_px_ = next;
    setField(state, field_px_);
    if (!solveAt(state, state.at)) return;
    state.sums = sumsAt(state);
    if (is_settled) break;
  }
  is_all_found_ = minimise(state, all, kMostSteps);
  State given_state{.windows = windows_, .at = start_, .sums = {}};
  setField(given_state, field_px_);
  if (!solveAt(given_state, start_)) return;
  given_state.sums = sumsAt(given_state);
  is_usable_ = minimise(given_state, Eigen::MatrixXd(num_ - 1, 0), kMostSteps);
  at_all_ = std::make_unique<State>(std::move(state));
  at_given_ = std::make_unique<State>(std::move(given_state));
}

CameraFreeing::~CameraFreeing() = default;

const std::vector<Reconstruction>& CameraFreeing::windows() const {
  return at_given_ ? at_given_->windows : windows_;
}

std::optional<FreedCamera> CameraFreeing::given() const {
  if (!is_usable_) return std::nullopt;
  return freedAt(at_given_->at, at_given_->sums, Eigen::MatrixXd(num_ - 1, 0), true);
}

std::optional<FreedCamera> CameraFreeing::all() const {
  if (!is_usable_ || !is_all_found_) return std::nullopt;
  return freedAt(at_all_->at, at_all_->sums, Eigen::MatrixXd::Identity(num_ - 1, num_ - 1), true);
}

std::optional<FreedCamera> CameraFreeing::along(const Eigen::MatrixXd& directions) const {
  if (!is_usable_) return std::nullopt;
  State state = *at_given_;
  const bool is_converged = minimise(state, directions, kMostSteps);
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

std::optional<FreedCamera> CameraFreeing::freedAt(const Eigen::VectorXd& at, const Sums& sums,
                                                  const Eigen::MatrixXd& directions,
                                                  bool is_converged) const {
  const std::span<const double> params(at.data(), static_cast<std::size_t>(num_ - 1));
  for (std::size_t i = 0; i < params.size(); ++i) {
    if (parameterComplaint(given_.modelId(), i, params[i])) return std::nullopt;
  }
  FreedCamera freed{.camera = AnyCamera::make(given_.modelId(), params),
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
    freed.amounts = gram.ldlt().solve(directions.transpose() * change.head(num_ - 1));
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

// The mean square change of the footage's pixels is as if measured to be zero, with the options' deviation.
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
  prior_ = sum / (std::max(1.0, count) * options_.prior_px * options_.prior_px);
  // Of directions that do not move the pixels at all.
  for (Eigen::Index i = 0; i < num_; ++i) prior_(i, i) += 1e-6 * prior_(i, i) + 1e-12;
  if (is_video_) {
    prior_(num_ - 1, num_ - 1) += 1;  // a readout takes a frame's time at most
  } else {
    prior_(num_ - 1, num_ - 1) = 1e12;
  }
}

// A standard deviation of the coefficients in units of the pixels' noise.
void CameraFreeing::setField(State& state, double field_px) const {
  for (Reconstruction& window : state.windows) {
    SceneFit& fit = *window.fit;
    fit.field_px = field_px / noise_;
    fit.fields.resize(fit.camera_from_world.size(), ErrorField::Coefficients::Zero());
  }
}

double CameraFreeing::priorCost(const Eigen::VectorXd& at) const {
  const Eigen::VectorXd change = at - start_;
  return 0.5 * change.dot(prior_ * change);
}

bool CameraFreeing::solveAt(State& state, const Eigen::VectorXd& at) const {
  const std::span<const double> params(at.data(), static_cast<std::size_t>(num_ - 1));
  for (std::size_t i = 0; i < params.size(); ++i) {
    if (parameterComplaint(given_.modelId(), i, params[i])) return false;
  }
  const AnyCamera camera = AnyCamera::make(given_.modelId(), params);
  std::vector<char> is_solved(state.windows.size(), 0);
  parallelFor(
      state.windows.size(), options_.num_jobs,
      [&](std::size_t i) {
        SceneFit& fit = *state.windows[i].fit;
        fit.camera = camera;
        fit.readout = at[num_ - 1];
        fit = solveScene(std::move(fit),
                         {.max_iterations = 200, .function_tolerance = 1e-6, .cancel = options_.cancel});
        is_solved[i] = fit.summary.termination == Termination::kConverged ? 1 : 0;
      },
      options_.cancel);
  return std::all_of(is_solved.begin(), is_solved.end(), [](char ok) { return ok != 0; });
}

CameraFreeing::Sums CameraFreeing::sumsAt(const State& state) const {
  std::vector<SceneEquations> equations(state.windows.size());
  parallelFor(state.windows.size(), options_.num_jobs,
              [&](std::size_t i) { equations[i] = sceneEquations(*state.windows[i].fit); });
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
    sums.gradient += sums.window_gradients.back();
    sums.scatter += sums.window_scatters.back();
    sums.num_points += static_cast<std::size_t>(gradients.cols());
    sums.field_square += window.field_square + noise_ * noise_ * window.field_variance;
    sums.num_coefficients += ErrorField::kSize * static_cast<double>(window.pose_covariance.rows() / 6 + 1);
  }
  return sums;
}

// Gauss-Newton steps on the windows' normal equations, to the optimum. @returns whether it was reached
bool CameraFreeing::minimise(State& state, const Eigen::MatrixXd& directions, int max_steps) const {
  const Eigen::MatrixXd D = withReadout(directions);
  double cost = state.sums.cost + priorCost(state.at);
  double damping = 0;
  for (int step = 0; step < max_steps; ++step) {
    throwIfCancelled(options_.cancel);
    Eigen::MatrixXd A = D.transpose() * (state.sums.information + prior_) * D;
    A.diagonal() += damping * A.diagonal();
    const Eigen::VectorXd gradient = D.transpose() * (state.sums.gradient + prior_ * (state.at - start_));
    const Eigen::VectorXd delta = -solveScaled(A, gradient);
    const double promise = -0.5 * gradient.dot(delta);
    if (!(promise >= 0)) return false;
    if (promise < 1e-2 * (1 + damping)) return true;
    State trial{.windows = state.windows, .at = state.at + D * delta, .sums = {}};
    if (solveAt(trial, trial.at)) {
      trial.sums = sumsAt(trial);
      const double trial_cost = trial.sums.cost + priorCost(trial.at);
      if (trial_cost <= cost + 1e-9 * cost) {
        state = std::move(trial);
        cost = trial_cost;
        damping = damping > 1e-3 ? damping / 8 : 0;
        continue;
      }
    }
    damping = std::max(1e-2, damping * 8);
    if (damping > 1e8) return false;
  }
  return false;
}

FootageWindows reconstructAll(const AnyCamera& camera, const FootageTracks& tracks,
                              const ReconstructionOptions& options, int num_jobs) {
  constexpr std::size_t kMost = 12;
  const auto groups = chooseWindows(tracks, kMost);
  std::vector<std::vector<Reconstruction>> found(groups.size());
  parallelFor(
      groups.size(), num_jobs,
      [&](std::size_t g) {
        std::vector<std::size_t> left = groups[g];
        while (left.size() >= 2 && found[g].size() < kMost) {
          found[g].push_back(reconstruct(camera, tracks, left, options));
          const Reconstruction& window = found[g].back();
          if (!window.fit || tracks.is_video) break;
          std::erase_if(left, [&](std::size_t frame) {
            return std::find(window.frames.begin(), window.frames.end(), frame) != window.frames.end();
          });
        }
      },
      options.cancel);
  FootageWindows result;
  for (auto& group : found) {
    for (Reconstruction& window : group)
      (window.fit ? result.windows : result.without_fit).push_back(std::move(window));
  }
  return result;
}

bool isKeyframe(const FootageTracks& kept, const std::vector<TrackPixel>& frame) {
  constexpr double kMotion = 0.04;  // of the width
  constexpr double kShared = 0.5;   // of tracks
  if (frame.empty()) return false;
  if (!kept.is_video || kept.frames.empty()) return true;
  double shared = 0;
  const double motion = medianMotion(kept.frames.back(), frame, &shared);
  return motion > kMotion * kept.size.width || shared < kShared;
}

std::vector<std::vector<std::size_t>> chooseWindows(const FootageTracks& tracks, std::size_t most) {
  const std::size_t kFrames = tracks.is_video ? 9 : 40;  // of a window
  std::vector<std::vector<std::size_t>> windows;
  if (tracks.frames.size() < 2) return windows;
  // Of about equal length.
  const std::size_t count = (tracks.frames.size() + kFrames - 1) / kFrames;
  for (std::size_t w = 0; w < count; ++w) {
    const std::size_t begin = w * tracks.frames.size() / count;
    const std::size_t end = (w + 1) * tracks.frames.size() / count;
    if (end - begin < 2) continue;
    std::vector<std::size_t>& window = windows.emplace_back();
    for (std::size_t i = begin; i < end; ++i) window.push_back(i);
  }
  if (windows.size() > most) {
    std::vector<std::vector<std::size_t>> fewer;
    for (std::size_t k = 0; k < most; ++k) fewer.push_back(std::move(windows[k * windows.size() / most]));
    return fewer;
  }
  return windows;
}

}  // namespace alidade
