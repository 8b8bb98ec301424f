// SPDX-License-Identifier: MIT
#include "alidade/detect/corner/corner_fit.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include <Eigen/Cholesky>
#include <Eigen/LU>

#include "alidade/detect/corner/corner_task.h"
#include "alidade/detect/corner/edge_fit.h"

namespace alidade {
namespace {

// Largest angle between the lines and the steps of the guess.
constexpr double kMaxTurnDeg = 25;

// First search: all pixels near the guess, thinned out to about this many, in windows that shrink until
// nearly no pixel is dropped. The half size of the first window, as a share of the spacing, is the largest
// without neighbouring corners.
constexpr double kSearchShare = 0.45;
constexpr double kSearchSamples = 420;
constexpr std::size_t kMinSearchPixels = 20;

// Half sizes of the windows of the actual fit. The first is safe if a board ends in squares of half the size;
// the last uses the whole edge. A fit with this reach in pixels precedes large windows.
constexpr double kSafeShare = 0.5;
constexpr double kFullShare = 0.8;
constexpr double kNarrowShare = 0.3;
constexpr double kApproachPx = 30;
// Pixels within this many blurs of a line determine the grey levels on both sides.
constexpr double kBandBlurs = 3.0;
constexpr double kMinReachPx = 2.5;
constexpr double kFewBlurs = 4;
constexpr std::size_t kFewestPixels = 50;

// Expectations that matter only if the pixels contain little information: typical curvature and shading.
EdgePrior priorFor(const CornerTask& task) {
  constexpr double kVariance = 4;  // of the noise, squared grey levels
  constexpr double kCurvatureTimesStep = 0.1;
  constexpr double kShadeTimesStep = 0.5;
  constexpr double kToneLevels = 40;
  constexpr double kBlurDifferencePx = 1;
  const auto precision = [](double sigma) { return kVariance / (sigma * sigma); };
  EdgePrior prior;
  for (const auto p : {EdgeModel::kCurvature1, EdgeModel::kCurvature2})
    prior.precision[p] = precision(kCurvatureTimesStep / task.spacing);
  for (const auto p : {EdgeModel::kShadeX, EdgeModel::kShadeY})
    prior.precision[p] = precision(kShadeTimesStep / task.spacing);
  prior.precision[EdgeModel::kTone] = precision(kToneLevels);
  prior.equal_blur = precision(kBlurDifferencePx);
  return prior;
}

// Initial grey levels: their mean, and their regression on the pattern of the squares.
void startLevels(const EdgePixels& pixels, EdgeModel& model) {
  const Eigen::Vector2d n1 = model.normal(0);
  const Eigen::Vector2d n2 = model.normal(1);
  double count = 0;
  double grey = 0;
  double sign = 0;
  double product = 0;
  for (std::size_t i = 0; i < pixels.size(); ++i) {
    const double dx = pixels.x()[i] - model[EdgeModel::kX];
    const double dy = pixels.y()[i] - model[EdgeModel::kY];
    const double s = (dx * n1.x() + dy * n1.y()) * (dx * n2.x() + dy * n2.y()) > 0 ? 1 : -1;
    count += 1;
    grey += pixels.grey()[i];
    sign += s;
    product += s * pixels.grey()[i];
  }
  model[EdgeModel::kMean] = grey / count;
  model[EdgeModel::kAmplitude] = (product - sign * grey / count) / count;
}

struct WindowFit {
  EdgeModel model;
  EdgeQuality quality;
  Eigen::Matrix2d covariance;
  double window = 0;
  [[nodiscard]] double sigma() const { return std::sqrt(0.5 * covariance.trace()); }
};

// Covariance of the corner. Each line's share of the error scales with the noise of its own cross-sections,
// because the corner moves across line i only by the error of line i.
Eigen::Matrix2d cornerCovariance(const EdgeModel& model, const EdgeSums& sums, const EdgeQuality& quality) {
  constexpr double kLeastVariance = 1.0 / 12;  // rounding to whole grey levels
  using Columns = Eigen::Matrix<double, EdgeModel::kNumParameters, 2>;
  const EdgeSums::Vector scale = sums.scale();
  const EdgeSums::Matrix system = scale.asDiagonal() * sums.hessian * scale.asDiagonal();
  const Columns solved = system.llt().solve(Columns::Identity());
  const Eigen::Matrix2d unit = (scale.asDiagonal() * solved).topRows<2>() * scale.head<2>().asDiagonal();
  Eigen::Matrix2d normals;
  normals << model.normal(0).transpose(), model.normal(1).transpose();
  const Eigen::Vector2d sigmas(std::sqrt(std::max(kLeastVariance, quality.line_variance[0])),
                               std::sqrt(std::max(kLeastVariance, quality.line_variance[1])));
  const Eigen::Matrix2d back = normals.inverse() * sigmas.asDiagonal() * normals;
  return back * unit * back.transpose();
}

// True if the lines and their crossing are near those of the guess.
bool isPlausible(const CornerTask& task, const EdgeModel& model) {
  static const double max_turn_sine = std::sin(kMaxTurnDeg * std::numbers::pi / 180);
  static const double min_crossing_sine = std::sin(kMinCrossingDeg * std::numbers::pi / 180);
  if (!(task.distanceFromGuess(model) <= kMaxMoveShare * task.spacing)) return false;
  const Eigen::Vector2d e1 = model.direction(0);
  const Eigen::Vector2d e2 = model.direction(1);
  return std::abs(crossProduct(e1, task.guess.step_u.normalized())) <= max_turn_sine &&
         std::abs(crossProduct(e2, task.guess.step_v.normalized())) <= max_turn_sine &&
         std::abs(crossProduct(e1, e2)) >= min_crossing_sine &&
         std::abs(2 * model[EdgeModel::kAmplitude] * model.shadeAtCorner()) >= kMinContrast;
}

// True if all four arms of the corner show the contrast of its squares, above the noise. Softened fits have
// tighter limits, because an object in front of the board may have prevented convergence. A tone curve is
// monotone up to half the amplitude; sharpened edges need up to twice the amplitude, but so does an L or a T
// in a small window, where the corner is loose.
bool isCrossing(const WindowFit& candidate, bool is_softened, double spacing_px) {
  const double kLeastArm = is_softened ? 0.6 : 0.5;
  const double kMostArm = is_softened ? 1.5 : 1.7;
  const double kMostResidual = is_softened ? 0.2 : 1.0;  // of the squared amplitude
  int num_arms = 0;
  for (const double arm : candidate.quality.arm_contrast) {
    if (std::isnan(arm)) continue;
    if (arm < kLeastArm || arm > kMostArm) return false;
    ++num_arms;
  }
  const double amplitude = candidate.model[EdgeModel::kAmplitude];
  constexpr double kMostLoose = 0.0015;  // of the spacing
  if (std::abs(candidate.model[EdgeModel::kTone]) > std::abs(amplitude) &&
      candidate.sigma() > kMostLoose * spacing_px)
    return false;
  return num_arms >= 3 && candidate.quality.residual_variance < kMostResidual * amplitude * amplitude;
}

class Refinement {
 public:
  Refinement(const CornerTask& task, EdgePixels& pixels, EdgeResiduals& residuals)
      : task_(task), prior_(priorFor(task)), pixels_(pixels), residuals_(residuals) {}

  // Searches from the guess to within about a pixel.
  [[nodiscard]] std::optional<EdgeModel> search() {
    EdgeModel model;
    const Eigen::Vector2d start = task_.guess.pixel - task_.origin.cast<double>();
    model[EdgeModel::kX] = start.x();
    model[EdgeModel::kY] = start.y();
    model[EdgeModel::kAngle1] = std::atan2(task_.guess.step_u.y(), task_.guess.step_u.x());
    model[EdgeModel::kAngle2] = std::atan2(task_.guess.step_v.y(), task_.guess.step_v.x());
    EdgePrior prior = prior_;
    prior.precision[EdgeModel::kCurvature1] = prior.precision[EdgeModel::kCurvature2] = EdgePrior::kHeld;
    prior.precision[EdgeModel::kTone] = EdgePrior::kHeld;
    prior.common_blur = true;
    const double area = std::abs(crossProduct(task_.guess.step_u, task_.guess.step_v));
    constexpr double kLeastSearchPx = 3;
    double share = std::min(kSearchShare, std::max(task_.guess.clear_share, kLeastSearchPx / task_.spacing));
    bool is_first = true;
    while (true) {
      const double samples = 4 * share * share * area;
      const int stride = std::max(1, static_cast<int>(std::ceil(std::sqrt(samples / kSearchSamples))));
      const EdgeWindow window = task_.window(model.corner(), share);
      task_.gatherLattice(window, stride, pixels_);
      if (pixels_.size() < kMinSearchPixels) return std::nullopt;
      if (is_first) startLevels(pixels_, model);
      // Starting with more blur widens the basin of convergence.
      const double start_blur = std::max(0.3 * share * task_.spacing, 0.7);
      model[EdgeModel::kBlur1] = model[EdgeModel::kBlur2] =
          is_first ? start_blur : std::clamp(model[EdgeModel::kBlur1], 0.7, start_blur);
      EdgeSolverOptions options{.min_blur_px = std::max(0.2, 0.5 * (stride - 1)),
                                .max_blur_px = std::max(1.0, 0.4 * task_.spacing),
                                .max_iterations = is_first ? 25 : 10,
                                .step_share = 0.5};
      // In a window between markers, lines that miss the corner turn away from it instead of moving.
      if (is_first && share < kSearchShare) {
        options.are_angles_held = true;
        model = solveEdgeModel(pixels_, model, prior, options).model;
        options.are_angles_held = false;
      }
      model = solveEdgeModel(pixels_, model, prior, options).model;
      if (!isPlausible(task_, model)) return std::nullopt;
      if (stride <= 2) return model;
      const double next_px = std::max({4.0 * stride, 12.0, 5 * model[EdgeModel::kBlur1]});
      share = std::min(0.6 * share, next_px / task_.spacing);
      is_first = false;
    }
  }

  // The window of half size `share` around a model's corner, without parts that the blur of neighbours
  // reaches.
  [[nodiscard]] EdgeWindow windowFor(const EdgeModel& model, double share) const {
    // Steps along u end at edges that run along v, and blur like line 1.
    return task_.window(model.corner(), share,
                        task_.marginShare(task_.guess.step_u.norm(), model[EdgeModel::kBlur2]),
                        task_.marginShare(task_.guess.step_v.norm(), model[EdgeModel::kBlur1]));
  }
  // Distance from a line that the blur of markers does not reach.
  [[nodiscard]] double clearPx(const EdgeModel& model, std::size_t line) const {
    constexpr double kMarginBlurs = 1.5;
    constexpr double kLeastPx = 1.2;
    return std::max(kLeastPx, task_.clearPx(line) - kMarginBlurs * model[EdgeModel::kBlur1 + line]);
  }
  // True if the window is long enough along both lines, in pixels and in blurs.
  [[nodiscard]] bool hasRoom(const EdgeModel& model, double share, double least_px,
                             double least_blurs) const {
    return windowFor(model, share).shorterReach() >= std::max(least_px, least_blurs * model.largerBlur());
  }
  // True if an edge is shorter than a few blurs: its position then correlates strongly with its other
  // parameters.
  [[nodiscard]] bool isShort(const EdgeModel& model, double share) const {
    return !hasRoom(model, share, kMinReachPx, kFewBlurs);
  }

  // Fits a window of half size `share`, starting from a nearly correct model. Nothing if the window is too
  // small.
  [[nodiscard]] std::optional<WindowFit> fit(const EdgeModel& start, double share) {
    if (!hasRoom(start, share, kMinReachPx, 1)) return std::nullopt;
    const EdgeWindow window = windowFor(start, share);
    task_.gatherBands(window, start, kBandBlurs, {clearPx(start, 0), clearPx(start, 1)}, pixels_);
    if (pixels_.size() < kFewestPixels) return std::nullopt;
    EdgeSolverOptions options;
    options.max_blur_px = std::max(1.0, 0.5 * task_.spacing);
    EdgeSolution solution = solveEdgeModel(pixels_, start, prior_, options);
    const bool is_softened = !solution.converged;
    if (is_softened) {
      // Edges may be too sharp for the model to follow from pixel to pixel; a softer one finds the same
      // corner.
      constexpr double kSoftPx = 0.8;
      options.min_blur_px = kSoftPx;
      solution = solveEdgeModel(pixels_, solution.model, prior_, options);
    }
    if (!solution.converged || !isPlausible(task_, solution.model)) return std::nullopt;
    evaluateResiduals(pixels_, solution.model, residuals_);
    WindowFit candidate{.model = solution.model,
                        .quality = assessEdgeFit(pixels_, solution.model, residuals_, window.reachPx()),
                        .covariance = {},
                        .window = share};
    candidate.covariance = cornerCovariance(solution.model, solution.sums, candidate.quality);
    // The model did not fit these pixels well, so its own estimate of the error is too small.
    constexpr double kSoftenedSigmas = 2;
    if (is_softened) candidate.covariance *= kSoftenedSigmas * kSoftenedSigmas;
    if (!candidate.covariance.allFinite() || !isCrossing(candidate, is_softened, task_.spacing))
      return std::nullopt;
    return candidate;
  }

  // Fits the largest window that the model describes as well as the smaller ones.
  [[nodiscard]] std::optional<WindowFit> fitBestWindow(const EdgeModel& start) {
    const double approach = std::min(kSafeShare, kApproachPx / task_.spacing);
    std::optional<WindowFit> best = fit(start, approach);
    if (best && isBlurOff(start, best->model)) best = fit(best->model, approach);
    if ((!best || isSuspicious(*best)) && approach > kNarrowShare) {
      const std::optional<WindowFit> narrow = fit(best ? best->model : start, kNarrowShare);
      if (narrow && !(best && isAsGood(*best, *narrow))) best = narrow;
    }
    // Without a smaller window for comparison, the full one is accepted only if there was no room for a
    // smaller one.
    if (!best && hasRoom(start, approach, 2 * kMinReachPx, kFewBlurs)) return std::nullopt;
    const std::optional<WindowFit> full = fit(best ? best->model : start, kFullShare);
    if (!best) return full;
    if (full && isAsGood(*full, *best)) return full;
    if (best->window < kSafeShare) {
      const std::optional<WindowFit> safe = fit(best->model, kSafeShare);
      if (safe && isAsGood(*safe, *best)) return safe;
    }
    return best;
  }

 private:
  // True if the band of pixels was chosen for a different blur than the fitted one.
  static bool isBlurOff(const EdgeModel& assumed, const EdgeModel& fitted) {
    constexpr double kFactor = 1.3;
    for (const auto p : {EdgeModel::kBlur1, EdgeModel::kBlur2}) {
      if (fitted[p] > kFactor * assumed[p] || assumed[p] > kFactor * fitted[p] + 0.3) return true;
    }
    return false;
  }

  // True if the window may contain a different object: one arm has less or more contrast than the others, or
  // the residuals grow outwards.
  static bool isSuspicious(const WindowFit& candidate) {
    constexpr double kUnevenArm = 0.12;
    constexpr double kGrowth = 2.5;
    constexpr double kRounding = 0.5;  // squared grey levels
    for (const double arm : candidate.quality.arm_contrast) {
      if (std::abs(arm - 1) > kUnevenArm) return true;
    }
    return candidate.quality.outer_variance > kGrowth * candidate.quality.inner_variance + kRounding;
  }

  static bool isAsGood(const WindowFit& large, const WindowFit& small) {
    // Variances from few cross-sections scatter, so choosing the smaller one would be too optimistic.
    constexpr double kMoreSigma = 1.3;
    constexpr double kMoreResidual = 1.4;
    constexpr double kMoreScatter = 3.0;
    constexpr double kRounding = 0.2;  // squared grey levels; noise below this is not compared
    constexpr double kMaxSigmas = 4.0;
    const auto scatter = [](const WindowFit& c) {
      return 0.5 * (c.quality.line_variance[0] + c.quality.line_variance[1]);
    };
    const double moved = (large.model.corner() - small.model.corner()).norm();
    return large.sigma() <= kMoreSigma * small.sigma() && moved <= kMaxSigmas * small.sigma() &&
           large.quality.residual_variance <= kMoreResidual * small.quality.residual_variance + kRounding &&
           scatter(large) <= kMoreScatter * scatter(small) + kRounding;
  }

  const CornerTask& task_;
  EdgePrior prior_;
  EdgePixels& pixels_;
  EdgeResiduals& residuals_;
};

CornerFit asFit(const CornerTask& task, const WindowFit& candidate) {
  const EdgeModel& model = candidate.model;
  CornerFit fit;
  fit.pixel = model.corner() + task.origin.cast<double>();
  fit.covariance = candidate.covariance;
  fit.sigma_px = candidate.sigma();
  fit.blur_px = std::sqrt(0.5 * (model[EdgeModel::kBlur1] * model[EdgeModel::kBlur1] +
                                 model[EdgeModel::kBlur2] * model[EdgeModel::kBlur2]));
  // Squares on the positive side of the model's distances.
  const double side1 = model.normal(0).dot(task.guess.step_v);
  const double side2 = model.normal(1).dot(task.guess.step_u);
  const double sign = side1 * side2 > 0 ? -1 : 1;
  fit.contrast = sign * 2 * model[EdgeModel::kAmplitude] * model.shadeAtCorner();
  fit.window = candidate.window;
  return fit;
}

}  // namespace

std::optional<CornerFit> CornerFitter::fit(const GrayImage& image, const CornerGuess& guess) {
  const std::optional<CornerTask> task = makeCornerTask(image, guess);
  if (!task) return std::nullopt;
  Refinement refinement(*task, pixels_, residuals_);
  const std::optional<EdgeModel> start = refinement.search();
  const std::optional<WindowFit> best = start ? refinement.fitBestWindow(*start) : std::nullopt;
  // If there is room for an edge fit and it fails, there is no corner.
  constexpr double kSmallSpacingPx = 30;
  if (best && !refinement.isShort(best->model, best->window)) {
    const CornerFit fit = asFit(*task, *best);
    return task->hasColoursOf(fit) ? std::optional(fit) : std::nullopt;
  }
  if (!best && task->spacing > kSmallSpacingPx && !(start && refinement.isShort(*start, kFullShare)))
    return std::nullopt;
  const auto saddle =
      fitSaddleCorner(*task, start ? (start->corner() + task->origin.cast<double>()).eval() : guess.pixel);
  // For short edges, sigma may be too small if the blur is not Gaussian, so the saddle is preferred.
  constexpr double kPreferSaddle = 2.5;
  if (best && !(saddle && saddle->sigma_px < kPreferSaddle * best->sigma())) return asFit(*task, *best);
  return saddle;
}

}  // namespace alidade
