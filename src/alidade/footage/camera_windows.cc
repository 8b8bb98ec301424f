// SPDX-License-Identifier: MIT
#include "alidade/footage/camera_windows.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>

#include "alidade/adjust/scene_fit.h"
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

// The windows' sums at one camera.
struct Sums {
  double cost = 0;  // of the pixels, in units of their noise
  Eigen::MatrixXd information;
  Eigen::VectorXd gradient;
  Eigen::MatrixXd scatter;                        // by points
  std::vector<Eigen::VectorXd> window_gradients;  // and each one's scatter
  std::vector<Eigen::MatrixXd> window_scatters;
  std::size_t num_points = 0;
  double field_square = 0;  // expected, px^2, of so many coefficients
  double num_coefficients = 0;
};

class Freeing {
 public:
  Freeing(const AnyCamera& given, std::vector<Reconstruction> windows, const FootageTracks& tracks,
          const FreeingOptions& options)
      : given_(given), windows_(std::move(windows)), options_(options), is_video_(tracks.is_video) {
    const auto params = given.parameters();
    start_ = Eigen::Map<const Eigen::VectorXd>(params.data(), static_cast<Eigen::Index>(params.size()));
    num_ = start_.size() + 1;
    setNoise();
    setPrior();
  }

  std::optional<FreedCamera> run() {
    Eigen::VectorXd at = Eigen::VectorXd::Zero(num_);
    at.head(start_.size()) = start_;
    double field = 0.1;  // px
    setField(field);
    if (!solveAt(at)) return std::nullopt;
    Sums sums = sumsHere();
    bool is_converged = false;
    for (int round = 0; round < 6; ++round) {
      is_converged = minimise(at, sums);
      const double next = std::max(kLeastField, std::sqrt(sums.field_square / sums.num_coefficients));
      if (std::abs(next - field) < 0.1 * field) break;
      field = next;
      setField(field);
      if (!solveAt(at)) return std::nullopt;
      sums = sumsHere();
    }
    field_ = field;
    return result(at, sums, is_converged);
  }

 private:
  // Moves to the optimum. @returns whether it was reached
  bool minimise(Eigen::VectorXd& at, Sums& sums) {
    double cost = sums.cost + priorCost(at);
    double damping = 0;
    for (int step = 0; step < 40; ++step) {
      throwIfCancelled(options_.cancel);
      Eigen::MatrixXd A = sums.information + prior_;
      A.diagonal() += damping * A.diagonal();
      const Eigen::VectorXd gradient = sums.gradient + prior_ * offset(at);
      const Eigen::VectorXd delta = -solved(A, gradient);
      const double promise = -0.5 * gradient.dot(delta);
      if (!(promise > 0)) return false;
      if (promise < 1e-3 * (1 + damping)) return true;
      const std::vector<Reconstruction> before = windows_;
      const Eigen::VectorXd trial = at + delta;
      if (solveAt(trial)) {
        const Sums there = sumsHere();
        const double trial_cost = there.cost + priorCost(trial);
        if (trial_cost <= cost + 1e-9 * cost) {
          at = trial;
          sums = there;
          cost = trial_cost;
          damping = damping > 1e-3 ? damping / 8 : 0;
          continue;
        }
      }
      windows_ = before;
      damping = std::max(1e-2, damping * 8);
      if (damping > 1e8) return false;
    }
    return false;
  }

  void setField(double field_px) {
    for (Reconstruction& window : windows_) {
      SceneFit& fit = *window.fit;
      fit.field_px = field_px / noise_;
      fit.fields.resize(fit.camera_from_world.size(), ErrorField::Coefficients::Zero());
    }
  }

  void setNoise() {
    std::vector<double> noises;
    for (const Reconstruction& window : windows_) noises.push_back(noiseOf(*window.fit));
    noise_ = std::max(1e-3, medianOf(noises));
    for (Reconstruction& window : windows_) window.fit->loss = {.threshold_px = 2.5 * noise_};
  }

  // The mean square change of the footage's pixels is as if measured to be zero, with the options' deviation.
  void setPrior() {
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

  [[nodiscard]] Eigen::VectorXd offset(const Eigen::VectorXd& at) const {
    Eigen::VectorXd change = at;
    change.head(start_.size()) -= start_;
    return change;
  }
  [[nodiscard]] double priorCost(const Eigen::VectorXd& at) const {
    const Eigen::VectorXd change = offset(at);
    return 0.5 * change.dot(prior_ * change);
  }

  // Parameters differ by many orders of magnitude.
  static Eigen::VectorXd solved(const Eigen::MatrixXd& A, const Eigen::VectorXd& b) {
    const Eigen::VectorXd scale = A.diagonal().cwiseMax(1e-300).cwiseSqrt().cwiseInverse();
    const Eigen::MatrixXd scaled = scale.asDiagonal() * A * scale.asDiagonal();
    return scale.asDiagonal() * scaled.ldlt().solve(scale.asDiagonal() * b);
  }
  static Eigen::MatrixXd inverseOf(const Eigen::MatrixXd& A) {
    const Eigen::VectorXd scale = A.diagonal().cwiseMax(1e-300).cwiseSqrt().cwiseInverse();
    const Eigen::MatrixXd scaled = scale.asDiagonal() * A * scale.asDiagonal();
    return scale.asDiagonal() * scaled.ldlt().solve(Eigen::MatrixXd::Identity(A.rows(), A.cols())) *
           scale.asDiagonal();
  }

  // The scatter, in no direction less than the information: that would be by chance.
  static Eigen::MatrixXd atLeast(const Eigen::MatrixXd& scatter, const Eigen::MatrixXd& information) {
    const Eigen::VectorXd scale = information.diagonal().cwiseMax(1e-300).cwiseSqrt();
    const Eigen::VectorXd unscale = scale.cwiseInverse();
    Eigen::MatrixXd scaled = unscale.asDiagonal() * information * unscale.asDiagonal();
    scaled.diagonal().array() += 1e-10;
    const Eigen::LLT<Eigen::MatrixXd> root(scaled);
    const Eigen::MatrixXd L = root.matrixL();
    const Eigen::MatrixXd half =
        root.matrixL().solve(Eigen::MatrixXd(unscale.asDiagonal() * scatter * unscale.asDiagonal()));
    const Eigen::MatrixXd whitened = root.matrixL().solve(Eigen::MatrixXd(half.transpose()));
    const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> eigen(whitened);
    const Eigen::MatrixXd rotated = L * eigen.eigenvectors();
    return scale.asDiagonal() * rotated * eigen.eigenvalues().cwiseMax(1).asDiagonal() * rotated.transpose() *
           scale.asDiagonal();
  }

  bool solveAt(const Eigen::VectorXd& at) {
    const std::span<const double> params(at.data(), static_cast<std::size_t>(start_.size()));
    for (std::size_t i = 0; i < params.size(); ++i) {
      if (parameterComplaint(given_.modelId(), i, params[i])) return false;
    }
    const AnyCamera camera = AnyCamera::make(given_.modelId(), params);
    std::vector<char> is_solved(windows_.size(), 0);
    parallelFor(windows_.size(), options_.num_jobs, [&](std::size_t i) {
      SceneFit& fit = *windows_[i].fit;
      fit.camera = camera;
      fit.readout = at[num_ - 1];
      fit = solveScene(std::move(fit), {.max_iterations = 100, .function_tolerance = 1e-9, .cancel = options_.cancel});
      is_solved[i] = fit.summary.termination != Termination::kFailed;
    }, options_.cancel);
    return std::all_of(is_solved.begin(), is_solved.end(), [](char ok) { return ok != 0; });
  }

  [[nodiscard]] Sums sumsHere() const {
    std::vector<SceneEquations> equations(windows_.size());
    parallelFor(windows_.size(), options_.num_jobs,
                [&](std::size_t i) { equations[i] = sceneEquations(*windows_[i].fit); });
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
      sums.field_square += window.field_square + noise_ * noise_ * window.field_variance;
      sums.num_coefficients += ErrorField::kSize * static_cast<double>(window.pose_covariance.rows() / 6 + 1);
      sums.window_scatters.emplace_back(gradients * gradients.transpose());
      sums.gradient += sums.window_gradients.back();
      sums.scatter += sums.window_scatters.back();
      sums.num_points += static_cast<std::size_t>(gradients.cols());
    }
    return sums;
  }

  // By how much the gradients of the windows vary more than those of their points explain.
  [[nodiscard]] double disagreementOf(const Sums& sums) const {
    if (windows_.size() < 2) return 1;
    // Each window's gradient at the common optimum, in the directions in which it says something.
    double sum = 0;
    double count = 0;
    for (std::size_t w = 0; w < windows_.size(); ++w) {
      const Eigen::MatrixXd scatter = sums.window_scatters[w] + 1e-6 * Eigen::MatrixXd(prior_);
      sum += sums.window_gradients[w].dot(solved(scatter, sums.window_gradients[w]));
      count += static_cast<double>(num_);
    }
    const double freedom = count - static_cast<double>(num_);
    return freedom > 0 ? sum / freedom : 1;
  }

  FreedCamera result(const Eigen::VectorXd& at, const Sums& sums, bool is_converged) {
    const auto points = static_cast<double>(sums.num_points);
    const double few = points / std::max(1.0, points - static_cast<double>(num_));
    FreedCamera freed{.camera = AnyCamera::make(given_.modelId(),
                                                std::span<const double>(
                                                    at.data(), static_cast<std::size_t>(start_.size()))),
                      .readout = at[num_ - 1],
                      .covariance = {},
                      .information = sums.information,
                      .scatter = {},
                      .windows = {},
                      .is_converged = is_converged,
                      .has_readout = is_video_};
    freed.disagreement = disagreementOf(sums);
    const Eigen::MatrixXd scatter =
        std::max(1.0, freed.disagreement) * atLeast(few * sums.scatter, sums.information);
    const Eigen::MatrixXd inverse = inverseOf(sums.information + prior_);
    freed.scatter = scatter;
    freed.covariance = Eigen::MatrixXd(inverse * (scatter + prior_) * inverse);
    double sigma = 0;
    for (const Reconstruction& window : windows_) sigma += window.noise_px / static_cast<double>(windows_.size());
    freed.noise_px = sigma;
    freed.field_px = field_;
    freed.windows = std::move(windows_);
    return freed;
  }

  const AnyCamera& given_;
  std::vector<Reconstruction> windows_;
  const FreeingOptions& options_;
  bool is_video_;
  Eigen::VectorXd start_;
  Eigen::Index num_ = 0;
  static constexpr double kLeastField = 0.01;  // px
  double noise_ = 1;
  double field_ = 0;
  Eigen::MatrixXd prior_;
};

}  // namespace

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
  const std::size_t kFrames = tracks.is_video ? 9 : 25;  // of a window
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

std::optional<FreedCamera> freeCamera(const AnyCamera& given, std::vector<Reconstruction> windows,
                                      const FootageTracks& tracks, const FreeingOptions& options) {
  expect(!windows.empty(), "there are windows");
  return Freeing(given, std::move(windows), tracks, options).run();
}

}  // namespace alidade
