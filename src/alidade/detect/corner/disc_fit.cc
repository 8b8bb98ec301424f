// SPDX-License-Identifier: MIT
#include "alidade/detect/corner/disc_fit.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

#include <Eigen/LU>

#include "alidade/detect/corner/disc_model.h"
#include "alidade/detect/corner/edge_fit.h"
#include "alidade/geometry/least_squares.h"

namespace alidade {
namespace {

using Eigen::Matrix2d;
using Eigen::Vector2d;

// False if no minimum was reached.
bool solveDisc(const EdgePixels& pixels, double min_blur, DiscModel& model, DiscSums& sums) {
  constexpr double kStepShare = 0.02;  // share of the estimate's standard deviation
  sumNormalEquations(pixels, model, sums);
  const DampingRule rule{
      .start = 1e-3,
      .raised = [](double damping) { return 10 * damping < 1e8 ? 10 * damping : HUGE_VAL; },
      .lowered = [](double damping) { return std::max(1e-7, 0.1 * damping); },
      .max_steps = 30};
  return minimise(rule, [&](double damping) {
    const DiscModel::Vector step = sums.step(damping);
    if (!step.allFinite()) return StepResult::kFailed;
    const bool is_short = sums.isShort(step, kStepShare, pixels.size());
    DiscModel trial = model;
    trial.values += step;
    trial[DiscModel::kBlur] = std::max(trial[DiscModel::kBlur], min_blur);
    DiscSums of_trial;
    if (trial.isEllipse()) sumNormalEquations(pixels, trial, of_trial);
    if (!trial.isEllipse() || !(of_trial.cost <= sums.cost))
      return is_short ? StepResult::kConverged : StepResult::kWorse;  // the difference is rounding
    model = trial;
    sums = of_trial;
    return is_short && damping < 0.1 ? StepResult::kConverged : StepResult::kBetter;
  });
}

// The fit of one disc.
class DiscTask {
 public:
  DiscTask(const GrayImage& image, const DiscGuess& guess)
      : image_(image), guess_(guess), unit_px_(std::pow(guess.shape.determinant(), -0.25)) {
    model_[DiscModel::kShapeXX] = guess.shape(0, 0) * unit_px_ * unit_px_;
    model_[DiscModel::kShapeXY] = guess.shape(0, 1) * unit_px_ * unit_px_;
    model_[DiscModel::kShapeYY] = guess.shape(1, 1) * unit_px_ * unit_px_;
    constexpr double kUsualBlurPx = 1;
    model_[DiscModel::kBlur] = kUsualBlurPx / unit_px_;
  }

  std::optional<DiscFit> fit() {
    constexpr int kRounds = 3;  // the first rounds determine the pixels around the rim
    for (int round = 0; round < kRounds; ++round) {
      if (!gather() || (round == 0 && !guessTones())) return std::nullopt;
      constexpr double kMinBlurPx = 0.3;  // the width of a pixel alone is 0.29
      const bool is_solved = solveDisc(pixels_, kMinBlurPx / unit_px_, model_, sums_);
      if (!is_solved || !isSound()) return std::nullopt;
    }
    return result();
  }

 private:
  // Gathers the pixels around the rim; false if there are too few, or a part of the rim is outside the image.
  bool gather() {
    constexpr double kBlurs = 3;
    constexpr double kMarginPx = 1;
    constexpr std::size_t kFewest = 3 * DiscModel::kNumParameters;
    const double band = kBlurs * model_[DiscModel::kBlur] + kMarginPx / unit_px_;
    const Matrix2d shape = model_.shape();
    const Matrix2d spread = shape.inverse();
    const Vector2d rim = unit_px_ * spread.diagonal().cwiseSqrt();
    const Vector2d middle = guess_.pixel + unit_px_ * model_.centre();
    const Vector2d last(image_.size.width - 1, image_.size.height - 1);
    const Vector2d slack = (middle - rim).cwiseMin(last - middle - rim);
    if (!(slack.minCoeff() >= kMarginPx + unit_px_ * model_[DiscModel::kBlur])) return false;
    const double outermost = std::min(guess_.reach, 1 + band * std::sqrt(largestOf(shape)));
    const Vector2d low = (middle - outermost * rim).cwiseMax(0.0);
    const Vector2d high = (middle + outermost * rim).cwiseMin(last);
    pixels_.clear();
    for (int row = static_cast<int>(std::ceil(low.y())); row <= high.y(); ++row) {
      for (int column = static_cast<int>(std::ceil(low.x())); column <= high.x(); ++column) {
        const Vector2d p = (Vector2d(column, row) - guess_.pixel) / unit_px_;
        const Vector2d from = p - model_.centre();
        if (from.dot(shape * from) > guess_.reach * guess_.reach) continue;
        if (std::abs(model_.distance(p)) <= band)
          pixels_.push(static_cast<float>(p.x()), static_cast<float>(p.y()), image_.at(column, row));
      }
    }
    return pixels_.size() >= kFewest;
  }

  static double largestOf(const Matrix2d& shape) {
    const double half = 0.5 * shape.trace();
    return half + std::sqrt(std::max(0.0, half * half - shape.determinant()));
  }

  // Estimates the mean grey levels on both sides; false without contrast.
  bool guessTones() {
    std::array<double, 2> sums{};
    std::array<double, 2> counts{};
    for (std::size_t i = 0; i < pixels_.size(); ++i) {
      const std::size_t side = model_.distance({pixels_.x()[i], pixels_.y()[i]}) > 0 ? 1 : 0;
      sums[side] += pixels_.grey()[i];
      counts[side] += 1;
    }
    if (counts[0] == 0 || counts[1] == 0) return false;
    const double inside = sums[0] / counts[0];
    const double outside = sums[1] / counts[1];
    model_[DiscModel::kMean] = 0.5 * (inside + outside);
    model_[DiscModel::kAmplitude] = 0.5 * (outside - inside);
    return std::abs(outside - inside) > 0;
  }

  [[nodiscard]] bool isSound() const {
    constexpr double kMostMove = 0.5;     // share of the radius
    constexpr double kMostGrowth = 2;     // factor on the mean radius, in both directions
    constexpr double kMinRadiusPx = 1.5;  // of the shorter semi-axis
    constexpr double kMostBlur = 0.8;     // share of the shorter semi-axis
    constexpr double kMinContrast = 4;    // grey levels
    const double shorter = 1 / std::sqrt(largestOf(model_.shape()));
    const double growth = std::pow(model_.shape().determinant(), -0.25);
    return model_.centre().norm() < kMostMove && growth < kMostGrowth && growth > 1 / kMostGrowth &&
           shorter * unit_px_ > kMinRadiusPx && model_[DiscModel::kBlur] < kMostBlur * shorter &&
           2 * std::abs(model_[DiscModel::kAmplitude]) > kMinContrast;
  }

  // Sums up the equal sections of the rim, counted from -x clockwise.
  void sumUpSections() {
    evaluateResiduals(pixels_, model_, residuals_);
    sections_ = {};
    parts_ = {};
    for (std::size_t i = 0; i < pixels_.size(); ++i) {
      const double angle =
          std::atan2(pixels_.y()[i] - model_[DiscModel::kY], pixels_.x()[i] - model_[DiscModel::kX]);
      const double turn = angle / (2 * std::numbers::pi) + 0.5;
      const auto section =
          std::min(static_cast<std::size_t>(std::max(0.0, turn * kNumSections)), kNumSections - 1);
      sections_[section].add(residuals_.slope[i], residuals_.residual[i]);
      parts_[section * kNumParts / kNumSections].add(residuals_.pattern[i], residuals_.residual[i]);
    }
  }

  // True if the rim is not an ellipse, for example that of a square or of a partly covered disc.
  [[nodiscard]] bool isOtherShape() const {
    constexpr double kMostOff = 0.04;  // share of the radius, RMS: the best ellipse for a square is 0.09 off
    double square = 0;
    for (const EdgeSection& section : sections_) {
      const double off = section.information > 0 ? section.score / section.information : 0;
      square += off * off;
    }
    return square > kMostOff * kMostOff * kNumSections;
  }

  // True if an object covers a part of the rim.
  [[nodiscard]] bool isCovered() const {
    constexpr double kMinShare = 0.6;
    constexpr double kMinVariance = 0.05;
    return std::ranges::any_of(parts_, [&](const EdgeContrast& part) {
      return !(part.share(model_[DiscModel::kAmplitude], 1, kMinVariance) > kMinShare);
    });
  }

  // Noise variance, squared grey levels, that explains the scatter of the rim's sections around the ellipse.
  [[nodiscard]] double noiseVariance() const {
    constexpr int kShapes = 5;  // deformations of the rim that the ellipse absorbs
    constexpr double kLeastVariance = 1.0 / 12;
    double square = 0;
    int count = 0;
    for (const EdgeSection& section : sections_) {
      if (!(section.information > 0)) continue;
      square += section.score * section.score / section.information;
      ++count;
    }
    const double by_rim = square / std::max(1, count - kShapes);
    return std::max(by_rim, kLeastVariance);
  }

  [[nodiscard]] std::optional<DiscFit> result() {
    sumUpSections();
    if (isCovered() || isOtherShape()) return std::nullopt;
    const DiscSums::Matrix inverse = sums_.hessian.inverse();
    const Matrix2d covariance = noiseVariance() * unit_px_ * unit_px_ * inverse.topLeftCorner<2, 2>();
    const DiscFit fit{.pixel = guess_.pixel + unit_px_ * model_.centre(),
                      .shape = model_.shape() / (unit_px_ * unit_px_),
                      .sigma_px = std::sqrt(0.5 * covariance.trace()),
                      .blur_px = model_[DiscModel::kBlur] * unit_px_,
                      .contrast = 2 * model_[DiscModel::kAmplitude]};
    constexpr double kMostSigmaShare = 0.1;  // share of the mean radius
    if (!std::isfinite(fit.sigma_px) || !(fit.sigma_px < kMostSigmaShare * unit_px_)) return std::nullopt;
    return fit;
  }

  const GrayImage& image_;
  const DiscGuess& guess_;
  double unit_px_;
  DiscModel model_;
  DiscSums sums_;
  EdgePixels pixels_;
  DiscResiduals residuals_;
  static constexpr std::size_t kNumSections = 24;
  static constexpr std::size_t kNumParts = 8;
  static_assert(kNumSections % kNumParts == 0);
  std::array<EdgeSection, kNumSections> sections_;
  std::array<EdgeContrast, kNumParts> parts_;
};

}  // namespace

std::optional<DiscFit> fitDisc(const GrayImage& image, const DiscGuess& guess) {
  const bool is_ellipse = guess.shape.allFinite() && guess.pixel.allFinite() && guess.shape(0, 0) > 0 &&
                          guess.shape.determinant() > 0;
  if (!is_ellipse) return std::nullopt;
  return DiscTask(image, guess).fit();
}

}  // namespace alidade
