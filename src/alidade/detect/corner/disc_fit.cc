// SPDX-License-Identifier: MIT
#include "alidade/detect/corner/disc_fit.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <vector>

#include <Eigen/LU>

#include "alidade/detect/corner/edge_fit.h"
#include "alidade/geometry/least_squares.h"

namespace alidade {
namespace {

using Eigen::Matrix2d;
using Eigen::Vector2d;

constexpr int kNumParameters = 10;
using DiscSums = NormalEquations<kNumParameters>;
using DiscVector = DiscSums::Vector;

// Parameters in the order of the solver's unknowns. Lengths are in units of the guess's mean radius, from its
// centre.
struct DiscModel {
  enum Parameter { kX, kY, kShapeXX, kShapeXY, kShapeYY, kBlur, kMean, kAmplitude, kShadeX, kShadeY };
  DiscVector values = DiscVector::Zero();

  [[nodiscard]] Matrix2d shape() const {
    return Matrix2d{{values(kShapeXX), values(kShapeXY)}, {values(kShapeXY), values(kShapeYY)}};
  }
  [[nodiscard]] bool isEllipse() const {
    return values(kShapeXX) > 0 && shape().determinant() > 0 && values(kBlur) > 0;
  }
};

struct RimPixel {
  double x, y, grey;
};

// The model at one pixel.
struct PixelValue {
  double distance;  // outwards from the rim
  double pattern;   // -1 inside, 1 outside
  double grey;
  double slope;  // d grey / d distance
  double px, py, norm;
  double shade, tone;
};

PixelValue evaluateRim(const DiscModel& model, double x, double y) {
  using P = DiscModel;
  const DiscVector& m = model.values;
  PixelValue at;
  const double dx = x - m(P::kX);
  const double dy = y - m(P::kY);
  at.px = m(P::kShapeXX) * dx + m(P::kShapeXY) * dy;
  at.py = m(P::kShapeXY) * dx + m(P::kShapeYY) * dy;
  const double root = std::sqrt(dx * at.px + dy * at.py);
  constexpr double kTiny = 1e-12;
  at.norm = std::max(std::hypot(at.px, at.py), kTiny);
  at.distance = (root - 1) * root / at.norm;
  const double z = at.distance / m(P::kBlur);
  at.pattern = std::erf(z * std::numbers::sqrt2 / 2);
  at.shade = 1 + m(P::kShadeX) * x + m(P::kShadeY) * y;
  at.tone = m(P::kMean) + m(P::kAmplitude) * at.pattern;
  at.grey = at.shade * at.tone;
  at.slope = at.shade * m(P::kAmplitude) * std::numbers::sqrt2 * std::numbers::inv_sqrtpi *
             std::exp(-0.5 * z * z) / m(P::kBlur);
  return at;
}

DiscVector rimDerivatives(const DiscModel& model, const RimPixel& pixel, const PixelValue& at) {
  using P = DiscModel;
  const double dx = pixel.x - model.values(P::kX);
  const double dy = pixel.y - model.values(P::kY);
  const double by_norm = at.slope / at.norm;
  DiscVector J;
  J << -by_norm * at.px, -by_norm * at.py, 0.5 * by_norm * dx * dx, by_norm * dx * dy,
      0.5 * by_norm * dy * dy, -at.slope * at.distance / model.values(P::kBlur), at.shade,
      at.shade * at.pattern, at.tone * pixel.x, at.tone * pixel.y;
  return J;
}

DiscSums sumUpRim(const DiscModel& model, const std::vector<RimPixel>& pixels) {
  DiscSums sums;
  for (const RimPixel& pixel : pixels) {
    const PixelValue at = evaluateRim(model, pixel.x, pixel.y);
    const DiscVector J = rimDerivatives(model, pixel, at);
    const double residual = pixel.grey - at.grey;
    sums.hessian.selfadjointView<Eigen::Lower>().rankUpdate(J);
    sums.gradient += residual * J;
    sums.cost += residual * residual;
  }
  sums.hessian.triangularView<Eigen::StrictlyUpper>() = sums.hessian.transpose();
  return sums;
}

double rimCost(const DiscModel& model, const std::vector<RimPixel>& pixels) {
  double cost = 0;
  for (const RimPixel& pixel : pixels) {
    const double residual = pixel.grey - evaluateRim(model, pixel.x, pixel.y).grey;
    cost += residual * residual;
  }
  return cost;
}

// False if no minimum was reached.
bool solveDisc(const std::vector<RimPixel>& pixels, double min_blur, DiscModel& model, DiscSums& sums) {
  constexpr double kStepShare = 0.02;  // share of the estimate's standard deviation
  sums = sumUpRim(model, pixels);
  const DampingRule rule{
      .start = 1e-3,
      .raised = [](double damping) { return 10 * damping < 1e8 ? 10 * damping : HUGE_VAL; },
      .lowered = [](double damping) { return std::max(1e-7, 0.1 * damping); },
      .max_steps = 30};
  return minimise(rule, [&](double damping) {
    const DiscVector step = sums.step(damping);
    if (!step.allFinite()) return StepResult::kFailed;
    const bool is_short = sums.isShort(step, kStepShare, pixels.size());
    DiscModel trial = model;
    trial.values += step;
    trial.values(DiscModel::kBlur) = std::max(trial.values(DiscModel::kBlur), min_blur);
    if (!trial.isEllipse() || !(rimCost(trial, pixels) <= sums.cost))
      return is_short ? StepResult::kConverged : StepResult::kWorse;  // the difference is rounding
    model = trial;
    if (is_short && damping < 0.1) return StepResult::kConverged;
    sums = sumUpRim(model, pixels);
    return StepResult::kBetter;
  });
}

// The fit of one disc.
class DiscTask {
 public:
  DiscTask(const GrayImage& image, const DiscGuess& guess)
      : image_(image), guess_(guess), unit_px_(std::pow(guess.shape.determinant(), -0.25)) {
    model_.values(DiscModel::kShapeXX) = guess.shape(0, 0) * unit_px_ * unit_px_;
    model_.values(DiscModel::kShapeXY) = guess.shape(0, 1) * unit_px_ * unit_px_;
    model_.values(DiscModel::kShapeYY) = guess.shape(1, 1) * unit_px_ * unit_px_;
    constexpr double kUsualBlurPx = 1;
    model_.values(DiscModel::kBlur) = kUsualBlurPx / unit_px_;
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
    constexpr std::size_t kFewest = 3 * kNumParameters;
    const DiscVector& m = model_.values;
    const double band = kBlurs * m(DiscModel::kBlur) + kMarginPx / unit_px_;
    const Matrix2d spread = model_.shape().inverse();
    const Vector2d rim = unit_px_ * spread.diagonal().cwiseSqrt();
    const Vector2d middle = guess_.pixel + unit_px_ * m.head<2>();
    const Vector2d last(image_.size.width - 1, image_.size.height - 1);
    const Vector2d slack = (middle - rim).cwiseMin(last - middle - rim);
    if (!(slack.minCoeff() >= kMarginPx + unit_px_ * m(DiscModel::kBlur))) return false;
    const double outermost = std::min(guess_.reach, 1 + band * std::sqrt(largestOf(model_.shape())));
    const Vector2d low = (middle - outermost * rim).cwiseMax(0.0);
    const Vector2d high = (middle + outermost * rim).cwiseMin(last);
    pixels_.clear();
    for (int row = static_cast<int>(std::ceil(low.y())); row <= high.y(); ++row) {
      for (int column = static_cast<int>(std::ceil(low.x())); column <= high.x(); ++column) {
        const Vector2d p = (Vector2d(column, row) - guess_.pixel) / unit_px_;
        const Vector2d from = p - m.head<2>();
        const double radius = std::sqrt(from.dot(model_.shape() * from));
        if (radius > guess_.reach || std::abs(evaluateRim(model_, p.x(), p.y()).distance) > band) continue;
        pixels_.push_back({p.x(), p.y(), static_cast<double>(image_.at(column, row))});
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
    for (const RimPixel& pixel : pixels_) {
      const std::size_t side = evaluateRim(model_, pixel.x, pixel.y).distance > 0 ? 1 : 0;
      sums[side] += pixel.grey;
      counts[side] += 1;
    }
    if (counts[0] == 0 || counts[1] == 0) return false;
    const double inside = sums[0] / counts[0];
    const double outside = sums[1] / counts[1];
    model_.values(DiscModel::kMean) = 0.5 * (inside + outside);
    model_.values(DiscModel::kAmplitude) = 0.5 * (outside - inside);
    return std::abs(outside - inside) > 0;
  }

  [[nodiscard]] bool isSound() const {
    constexpr double kMostMove = 0.5;     // share of the radius
    constexpr double kMostGrowth = 2;     // factor on the mean radius, in both directions
    constexpr double kMinRadiusPx = 1.5;  // of the shorter semi-axis
    constexpr double kMostBlur = 0.8;     // share of the shorter semi-axis
    constexpr double kMinContrast = 4;    // grey levels
    const DiscVector& m = model_.values;
    const double shorter = 1 / std::sqrt(largestOf(model_.shape()));
    const double growth = std::pow(model_.shape().determinant(), -0.25);
    return m.head<2>().norm() < kMostMove && growth < kMostGrowth && growth > 1 / kMostGrowth &&
           shorter * unit_px_ > kMinRadiusPx && m(DiscModel::kBlur) < kMostBlur * shorter &&
           2 * std::abs(m(DiscModel::kAmplitude)) > kMinContrast;
  }

  // Sums over equal sections of the rim; `add` gets the sum of a pixel's section, the model's value there,
  // and the residual.
  template <class Sums, std::size_t kCount, class Add>
  [[nodiscard]] std::array<Sums, kCount> alongRim(const Add& add) const {
    std::array<Sums, kCount> sums{};
    for (const RimPixel& pixel : pixels_) {
      const PixelValue at = evaluateRim(model_, pixel.x, pixel.y);
      const double angle =
          std::atan2(pixel.y - model_.values(DiscModel::kY), pixel.x - model_.values(DiscModel::kX));
      const double turn = angle / (2 * std::numbers::pi) + 0.5;
      constexpr int kLast = static_cast<int>(kCount) - 1;
      add(sums[static_cast<std::size_t>(
              std::clamp(static_cast<int>(turn * static_cast<int>(kCount)), 0, kLast))],
          at, pixel.grey - at.grey);
    }
    return sums;
  }

  static constexpr int kNumSections = 24;
  [[nodiscard]] std::array<EdgeSection, kNumSections> sections() const {
    return alongRim<EdgeSection, kNumSections>(
        [](EdgeSection& section, const PixelValue& at, double residual) { section.add(at.slope, residual); });
  }

  // True if the rim is not an ellipse, for example that of a square or of a partly covered disc.
  [[nodiscard]] bool isOtherShape() const {
    constexpr double kMostOff = 0.04;  // share of the radius, RMS: the best ellipse for a square is 0.09 off
    double square = 0;
    for (const EdgeSection& section : sections()) {
      const double off = section.information > 0 ? section.score / section.information : 0;
      square += off * off;
    }
    return square > kMostOff * kMostOff * kNumSections;
  }

  // True if an object covers a part of the rim.
  [[nodiscard]] bool isCovered() const {
    constexpr std::size_t kParts = 8;
    constexpr double kMinShare = 0.6;
    constexpr double kMinVariance = 0.05;
    const auto parts = alongRim<EdgeContrast, kParts>(
        [](EdgeContrast& part, const PixelValue& at, double residual) { part.add(at.pattern, residual); });
    return std::ranges::any_of(parts, [&](const EdgeContrast& part) {
      return !(part.share(model_.values(DiscModel::kAmplitude), 1, kMinVariance) > kMinShare);
    });
  }

  // Noise variance, squared grey levels, that explains the scatter of the rim's sections around the ellipse.
  [[nodiscard]] double noiseVariance() const {
    constexpr int kShapes = 5;  // deformations of the rim that the ellipse absorbs
    constexpr double kLeastVariance = 1.0 / 12;
    double square = 0;
    int count = 0;
    for (const EdgeSection& section : sections()) {
      if (!(section.information > 0)) continue;
      square += section.score * section.score / section.information;
      ++count;
    }
    const double by_rim = square / std::max(1, count - kShapes);
    return std::max(by_rim, kLeastVariance);
  }

  [[nodiscard]] std::optional<DiscFit> result() const {
    if (isCovered() || isOtherShape()) return std::nullopt;
    const DiscSums::Matrix inverse = sums_.hessian.inverse();
    const Matrix2d covariance = noiseVariance() * unit_px_ * unit_px_ * inverse.topLeftCorner<2, 2>();
    const DiscFit fit{.pixel = guess_.pixel + unit_px_ * model_.values.head<2>(),
                      .shape = model_.shape() / (unit_px_ * unit_px_),
                      .sigma_px = std::sqrt(0.5 * covariance.trace()),
                      .blur_px = model_.values(DiscModel::kBlur) * unit_px_,
                      .contrast = 2 * model_.values(DiscModel::kAmplitude)};
    constexpr double kMostSigmaShare = 0.1;  // share of the mean radius
    if (!std::isfinite(fit.sigma_px) || !(fit.sigma_px < kMostSigmaShare * unit_px_)) return std::nullopt;
    return fit;
  }

  const GrayImage& image_;
  const DiscGuess& guess_;
  double unit_px_;
  DiscModel model_;
  DiscSums sums_;
  std::vector<RimPixel> pixels_;
};

}  // namespace

std::optional<DiscFit> fitDisc(const GrayImage& image, const DiscGuess& guess) {
  const bool is_ellipse = guess.shape.allFinite() && guess.pixel.allFinite() && guess.shape(0, 0) > 0 &&
                          guess.shape.determinant() > 0;
  if (!is_ellipse) return std::nullopt;
  return DiscTask(image, guess).fit();
}

}  // namespace alidade
