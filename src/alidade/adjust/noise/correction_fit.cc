// SPDX-License-Identifier: MIT
#include "alidade/adjust/noise/correction_fit.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "alidade/adjust/board/solve.h"
#include "alidade/core/error.h"
#include "alidade/core/number_text.h"
#include "alidade/geometry/decompositions.h"
#include "alidade/geometry/symmetric_eigen.h"

namespace alidade {
namespace {

// The control points that move a corner's pixel, after the parameters.
struct CorrectionColumns {
  CorrectionGrid grid;

  [[nodiscard]] int size() const { return 2 * grid.numPoints(); }
  [[nodiscard]] ExtraElements<16> elements(const CornerRows& rows, int axis) const {
    // Where the camera sees the corner: at the observed pixel, a field could act like the errors themselves.
    const Eigen::Vector2d seen =
        rows.corner.pixel + Eigen::Vector2d(rows.error[0], rows.error[1]) / rows.root_weight;
    ExtraElements<16> elements{};
    std::size_t at = 0;
    grid.forEachWeight(seen, [&](int point, double weight) {
      elements.column[at] = 2 * point + axis;
      elements.value[at++] = rows.root_weight * weight;
    });
    return elements;
  }
};

// (1 + L)^2 for both coordinates of each point.
Eigen::MatrixXd smoothPrecision(const CorrectionGrid& grid) {
  const int across = grid.pointsAcross();
  const int count = grid.numPoints();
  Eigen::MatrixXd root = Eigen::MatrixXd::Identity(count, count);
  const auto connect = [&root](int a, int b) {
    root(a, a) += 1;
    root(b, b) += 1;
    root(a, b) -= 1;
    root(b, a) -= 1;
  };
  for (int i = 0; i < count; ++i) {
    if ((i + 1) % across != 0) connect(i, i + 1);
    if (i + across < count) connect(i, i + across);
  }
  const Eigen::MatrixXd of_one = root * root;
  Eigen::MatrixXd precision = Eigen::MatrixXd::Zero(2 * count, 2 * count);
  for (int i = 0; i < count; ++i) {
    for (int j = 0; j < count; ++j) precision(2 * i, 2 * j) = precision(2 * i + 1, 2 * j + 1) = of_one(i, j);
  }
  return precision;
}

}  // namespace

std::vector<View> freeOf(const CorrectionField& field, std::vector<View> views) {
  constexpr double kMostShare = 0.02;  // corners farther outside count as those of another image
  for (View& view : views) {
    if (field.largest() > kMostShare * std::max(view.size.width, view.size.height)) {
      throw inputError({.where = "correction field",
                        .found = "displacements of up to " + numberText("%.2g", field.largest()) + " px",
                        .expected = "at most 2 % of the longer side, to estimate poses with it",
                        .next_step = "fit a model to it: alidade convert CAMERA -o PLAIN --drop-correction"});
    }
    std::vector<Corner> free;
    for (Corner corner : view.corners) {
      const auto pixel = field.undisplaced(corner.pixel);
      if (!pixel) continue;
      corner.pixel = *pixel;
      free.push_back(corner);
    }
    view.corners = std::move(free);
  }
  return views;
}

void moveCorners(Fit& fit, const CorrectionField* from, const CorrectionField* to) {
  for (FitView& view : fit.views) {
    for (Observation& corner : view.corners) {
      const Eigen::Vector2d seen = from == nullptr ? corner.pixel : corner.pixel + from->at(corner.pixel);
      corner.pixel = to == nullptr ? seen : to->undisplaced(seen).value_or(seen);
    }
  }
}

CorrectionEquations::CorrectionEquations(const Fit& fit, const CorrectionGrid& grid,
                                         const CorrectionField* present)
    : grid_(grid), present_(Eigen::VectorXd::Zero(2 * grid.numPoints())), precision_(smoothPrecision(grid)) {
  const FitCamera& camera = onlyCamera(fit);
  const auto num_params = static_cast<Eigen::Index>(camera.params.size());
  const Eigen::Index size = num_params + present_.size();
  directions_ = freeDirections(static_cast<int>(num_params), camera.constraint);
  if (present != nullptr) {
    expect(present->points().size() == static_cast<std::size_t>(present_.size()), "a field of this grid");
    std::ranges::copy(present->points(), present_.begin());
  }
  const std::size_t num_views = fit.views.size();
  all_ = {.information = Eigen::MatrixXd::Zero(size, size), .gradient = Eigen::VectorXd::Zero(size)};
  of_fold_.resize(static_cast<std::size_t>(numFolds(num_views)), all_);
  double squares = 0;
  for (std::size_t v = 0; v < num_views; ++v) {
    const Reduced view = reduced(fit, fit.views[v], LossWeights::kUse, CorrectionColumns{grid});
    Sums& fold = of_fold_[static_cast<std::size_t>(foldOf(v, num_views))];
    fold.information += view.information;
    fold.gradient += view.gradient;
    squares += view.squares;
  }
  for (const Sums& fold : of_fold_) {
    all_.information += fold.information;
    all_.gradient += fold.gradient;
  }
  camera.weak_prior.prior.addTo(camera.params, all_.information, all_.gradient);
  for (Sums& fold : of_fold_)
    fold = {.information = all_.information - fold.information, .gradient = all_.gradient - fold.gradient};
  const OfField of = ofField(all_);
  cost_ = squares + present_.dot(2 * of.pull - of.information * present_);
  freedom_ = 2.0 * static_cast<double>(numCorners(fit)) - static_cast<double>(directions_.cols()) -
             6.0 * static_cast<double>(num_views) - numFreeOffsets(fit);
}

CorrectionEquations::OfField CorrectionEquations::ofField(const Sums& sums) const {
  const Eigen::Index n = directions_.rows();
  const Eigen::Index m = present_.size();
  OfField of{.information = sums.information.bottomRightCorner(m, m), .pull = -sums.gradient.tail(m)};
  if (directions_.cols() > 0) {
    const Eigen::MatrixXd own = directions_.transpose() * sums.information.topLeftCorner(n, n) * directions_;
    const Eigen::MatrixXd coupling = directions_.transpose() * sums.information.topRightCorner(n, m);
    const Eigen::VectorXd gradient = directions_.transpose() * sums.gradient.head(n);
    const Eigen::MatrixXd solved = solveSpd(own, coupling);
    of.information -= coupling.transpose() * solved;
    of.pull += solved.transpose() * gradient;
  }
  of.pull += of.information * present_;
  return of;
}

CorrectionEquations::Strength CorrectionEquations::likeliest() const {
  const OfField of = ofField(all_);
  const SymmetricEigen modes(of.information, precision_);
  if (!modes.isFound() || !(cost_ > 0) || !(freedom_ > 0)) return {};
  const Eigen::ArrayXd information = modes.eigenvalues().array().max(0);
  const Eigen::ArrayXd squared_pull = (modes.eigenvectors().transpose() * of.pull).array().square();
  // The variance of corners is eliminated.
  const auto gainOf = [&](double log_ratio) {
    const Eigen::ArrayXd strength = std::exp(log_ratio) / (1 + std::exp(log_ratio) * information);
    const double left = 1 - (squared_pull * strength).sum() / cost_;
    if (!(left > 0)) return -std::numeric_limits<double>::infinity();
    return -freedom_ * std::log(left) - (std::exp(log_ratio) * information).log1p().sum();
  };
  constexpr double kWeakest = -12;  // logarithms of the ratio
  constexpr double kStrongest = 8;  // 55 times the noise: more is a matter of the model
  constexpr double kStep = 0.25;
  double best = kWeakest;
  for (double at = kWeakest; at <= kStrongest; at += kStep) {
    if (gainOf(at) > gainOf(best)) best = at;
  }
  // A continuous strength, so that a slight change of the corners changes it slightly.
  double low = best - kStep;
  double high = std::min(best + kStep, kStrongest);
  constexpr double kGolden = 0.3819660112501051;
  constexpr int kSections = 30;
  for (int i = 0; i < kSections; ++i) {
    const double a = low + kGolden * (high - low);
    const double b = high - kGolden * (high - low);
    (gainOf(a) > gainOf(b) ? high : low) = gainOf(a) > gainOf(b) ? b : a;
  }
  best = (low + high) / 2;
  if (!(gainOf(best) > 0)) return {};
  return {.ratio = std::exp(best), .gain = gainOf(best)};
}

CorrectionPointer CorrectionEquations::field(double ratio, std::optional<int> without_fold) const {
  const OfField of = ofField(without_fold ? of_fold_[static_cast<std::size_t>(*without_fold)] : all_);
  const Eigen::VectorXd points = solveSpd(Eigen::MatrixXd(of.information + precision_ / ratio), of.pull);
  try {
    return std::make_shared<const CorrectionField>(grid_, std::vector<double>(points.begin(), points.end()));
  } catch (const Error&) {  // no smooth field explains the corners
    return nullptr;
  }
}

Eigen::MatrixXd CorrectionEquations::covariance(double ratio, double variance) const {
  const Eigen::Index n = directions_.rows();
  const Eigen::Index m = present_.size();
  const Eigen::Index free = directions_.cols();
  Eigen::MatrixXd free_of_all = Eigen::MatrixXd::Zero(n + m, free + m);
  free_of_all.topLeftCorner(n, free) = directions_;
  free_of_all.bottomRightCorner(m, m).setIdentity();
  Eigen::MatrixXd information = all_.information;
  information.bottomRightCorner(m, m) += precision_ / ratio;
  const Eigen::MatrixXd inverse = inverseSpd(free_of_all.transpose() * information * free_of_all);
  return variance * free_of_all * inverse * free_of_all.transpose();
}

Eigen::MatrixXd CorrectionEquations::covarianceWithout(double variance) const {
  const Eigen::Index n = directions_.rows();
  const Eigen::MatrixXd own = directions_.transpose() * all_.information.topLeftCorner(n, n) * directions_;
  return variance * directions_ * inverseSpd(own) * directions_.transpose();
}

CorrectedFit withCorrection(Fit fit, const CorrectionGrid& grid, CorrectionPointer present,
                            const CancelFlag* cancel) {
  constexpr int kRounds = 3;  // each leaves what is not linear in the steps of the camera
  CorrectedFit corrected{.fit = std::move(fit), .field = std::move(present), .strength = {}};
  for (int round = 0; round < kRounds; ++round) {
    const CorrectionEquations equations(corrected.fit, grid, corrected.field.get());
    corrected.strength = equations.likeliest();
    CorrectionPointer next =
        corrected.strength.ratio > 0 ? equations.field(corrected.strength.ratio) : nullptr;
    moveCorners(corrected.fit, corrected.field.get(), next.get());
    corrected.field = std::move(next);
    corrected.fit = solve(std::move(corrected.fit), {.cancel = cancel});
    if (corrected.field == nullptr) break;
  }
  return corrected;
}

std::optional<HeldOutErrors> heldOutErrors(const CorrectedFit& corrected, int jobs,
                                           const CancelFlag* cancel) {
  if (corrected.field == nullptr) return heldOutErrors(corrected.fit, jobs, cancel);
  const CorrectionEquations equations(corrected.fit, corrected.field->grid(), corrected.field.get());
  return heldOutErrors(corrected.fit, jobs, cancel, [&](int fold, Fit& fit) {
    moveCorners(fit, corrected.field.get(), equations.field(corrected.strength.ratio, fold).get());
  });
}

}  // namespace alidade
