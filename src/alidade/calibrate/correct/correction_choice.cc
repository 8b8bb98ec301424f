// SPDX-License-Identifier: MIT
#include "alidade/calibrate/correct/correction_choice.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>
#include <vector>

#include "alidade/calibrate/uncertainty/accuracy.h"
#include "alidade/calibrate/uncertainty/uncertainty_of.h"
#include "alidade/camera/projection_uncertainty.h"
#include "alidade/geometry/decompositions.h"
#include "alidade/geometry/symmetric_eigen.h"

namespace alidade {
namespace {

// Coarse to fine; cells are about square.
std::vector<CorrectionGrid> gridsFor(ImageSize size, const CalibratorOptions& options) {
  if (options.correction_cells) {
    const auto [columns, rows] = *options.correction_cells;
    return {CorrectionGrid::over(size, columns, rows)};
  }
  std::vector<CorrectionGrid> grids;
  for (const int along : {4, 8, 16}) {
    const double cell = static_cast<double>(std::max(size.width, size.height)) / along;
    const auto cells = [cell](int side) { return std::max(1, static_cast<int>(std::lround(side / cell))); };
    grids.push_back(CorrectionGrid::over(size, cells(size.width), cells(size.height)));
  }
  return grids;
}

// The uncertainty of pixels, and that of the parameters as far as they act like it, if a field is estimated
// too.
class JointUncertainty {
 public:
  // @param fit  free of the field
  JointUncertainty(const CorrectedFit& corrected, const Uncertainty& known)
      : grid_(corrected.field->grid()),
        lens_(cameraOf(onlyCamera(corrected.fit).model, onlyCamera(corrected.fit).params)) {
    const CorrectionEquations equations(corrected.fit, grid_, corrected.field.get());
    const double variance = known.coordinate_sigma_px * known.coordinate_sigma_px;
    const Eigen::MatrixXd all = equations.covariance(corrected.strength.ratio, variance);
    // Without the entrance pupil, which lies between.
    const auto n = static_cast<Eigen::Index>(lens_.parameters().size());
    const Eigen::Index m = 2 * grid_.numPoints();
    without_ = equations.covarianceWithout(variance).topLeftCorner(n, n);
    for (Eigen::Index k = n; k < all.rows() - m; ++k) pupil_variances_.push_back(all(k, k));
    covariance_.resize(n + m, n + m);
    covariance_ << all.topLeftCorner(n, n), all.topRightCorner(n, m), all.bottomLeftCorner(m, n),
        all.bottomRightCorner(m, m);
  }

  // How much less is known of the parameters that act most like the whole camera where boards were seen than
  // if the field were known; nothing negative.
  [[nodiscard]] Eigen::MatrixXd moreOfParameters(const std::vector<Eigen::Vector2d>& covered,
                                                 const Eigen::MatrixXd& free) const {
    const auto n = free.rows();
    if (free.cols() == 0 || covered.empty()) return Eigen::MatrixXd::Zero(n, n);
    const AlignedJacobians aligned = alignedJacobians(lens_, covered, {}, Freed::kRotation, {}, &grid_);
    const Eigen::MatrixXd by_all = aligned.transposed.view().transpose();
    const Eigen::Index m = by_all.cols() - n;
    Eigen::MatrixXd act(n, n + m);
    act << Eigen::MatrixXd::Identity(n, n),
        free * leastSquares(Eigen::MatrixXd(by_all.leftCols(n) * free), Eigen::MatrixXd(by_all.rightCols(m)));
    const Eigen::VectorXd scale = without_.diagonal().unaryExpr(
        [](double variance) { return variance > 0 ? std::sqrt(variance) : 0.0; });
    const Eigen::VectorXd inverse = scale.unaryExpr([](double size) { return size > 0 ? 1 / size : 0.0; });
    const Eigen::MatrixXd more = act * covariance_ * act.transpose() - without_;
    const SymmetricEigen modes(inverse.asDiagonal() * more * inverse.asDiagonal());
    const Eigen::MatrixXd positive = modes.eigenvectors() * modes.eigenvalues().cwiseMax(0).asDiagonal() *
                                     modes.eigenvectors().transpose();
    return scale.asDiagonal() * positive * scale.asDiagonal();
  }

  [[nodiscard]] double pupilStd(std::size_t i) const { return std::sqrt(pupil_variances_[i]); }

  // Radii that the errors of far pixels do not exceed with a probability of 95 %.
  [[nodiscard]] std::vector<double> radii(const Accuracy& accuracy) const {
    const std::vector<Eigen::Vector2d> covered = coveredPixels(accuracy.pixels, accuracy.is_covered);
    const AlignedJacobians aligned =
        alignedJacobians(lens_, covered, accuracy.pixels,
                         std::isinf(accuracy.distance_m) ? Freed::kRotation : Freed::kPose, {}, &grid_);
    std::vector<double> radii;
    for (std::size_t i = 0; i < accuracy.pixels.size(); ++i) {
      const auto at = 2 * static_cast<Eigen::Index>(covered.size() + i);
      const auto A = aligned.transposed.view().middleCols(at, 2);
      radii.push_back(radius95(Eigen::Matrix2d(A.transpose() * covariance_ * A)));
    }
    return radii;
  }

 private:
  CorrectionGrid grid_;
  AnyCamera lens_;
  Eigen::MatrixXd covariance_;  // of the lens' parameters, then the field's points
  Eigen::MatrixXd without_;     // of the parameters if the field were known
  std::vector<double> pupil_variances_;
};

void include(const JointUncertainty& joint, double excess, Uncertainty& known) {
  Accuracy& accuracy = *known.accuracy;
  const std::vector<Eigen::Vector2d> covered = coveredPixels(accuracy.pixels, accuracy.is_covered);
  const Eigen::MatrixXd more = joint.moreOfParameters(covered, known.free_directions.view());
  known.covariance = Eigen::MatrixXd(known.covariance->view() + more);
  if (known.by_views) known.by_views->larger = Eigen::MatrixXd(known.by_views->larger.view() + excess * more);
  for (std::size_t i = 0; i < known.pupil_std_m.size(); ++i)
    known.pupil_std_m[i] = std::max(known.pupil_std_m[i], std::sqrt(excess) * joint.pupilStd(i));
  const std::vector<double> radii = joint.radii(accuracy);
  accuracy.covered_px = accuracy.worst_px = std::numeric_limits<double>::quiet_NaN();
  for (std::size_t i = 0; i < radii.size(); ++i) {
    double& error = accuracy.error_px[i];
    if (std::isnan(error)) continue;  // no ray
    error = std::max(error, std::sqrt(excess) * radii[i] + accuracy.deviation_px);
    if (accuracy.is_covered[i]) accuracy.covered_px = std::fmax(accuracy.covered_px, error);
    if (!(error <= accuracy.worst_px)) {
      accuracy.worst_px = error;
      accuracy.worst_pixel = accuracy.pixels[i];
    }
  }
}

}  // namespace

std::optional<CorrectedFit> chooseCorrection(const Fit& fit, const CalibratorOptions& options,
                                             CorrectionReport& report) {
  const bool is_requested = options.correction_cells.has_value();
  HeldOutScore without;
  if (!is_requested) {
    const auto errors = heldOutErrors(fit, options.jobs, options.cancel);
    if (!errors) return std::nullopt;
    without = scoreOf(*errors, fit);
  }
  std::optional<CorrectedFit> best;
  for (const CorrectionGrid& grid : gridsFor(onlyCamera(fit).size, options)) {
    CorrectedFit corrected = withCorrection(fit, grid, nullptr, options.cancel);
    if (corrected.field == nullptr) continue;
    if (is_requested) return corrected;
    const auto errors = heldOutErrors(corrected, options.jobs, options.cancel);
    if (!errors) continue;
    constexpr std::size_t kCountsAs = 4;  // parameters
    const HeldOutExcess excess = excessOf(without, scoreOf(*errors, corrected.fit));
    if (!excess.isWorth(kCountsAs) || (report.excess && excess.share <= report.excess->share)) continue;
    report.excess = excess;
    report.holdout_rms_px = holdoutReport(errors).rms_px;
    best = std::move(corrected);
  }
  return best;
}

void includeCorrection(const CorrectedFit& corrected, Uncertainty& known) {
  if (!known.covariance || !known.accuracy) return;
  const double excess = known.isNoiseExceeded() ? std::max(1.0, known.by_views->excess) : 1.0;
  include(JointUncertainty(corrected, known), excess, known);
  setProjected(corrected.fit, known);
}

void measureCorrection(const CorrectedFit& corrected, CorrectionReport& report) {
  double squares = 0;
  for (const FitView& view : corrected.fit.views) {
    for (const Observation& corner : view.corners) {
      const double displaced_px = corrected.field->at(corner.pixel).norm();
      squares += displaced_px * displaced_px;
      report.worst_px = std::max(report.worst_px, displaced_px);
    }
  }
  report.rms_px = std::sqrt(squares / static_cast<double>(numCorners(corrected.fit)));
}

}  // namespace alidade
