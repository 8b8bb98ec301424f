// SPDX-License-Identifier: MIT
#include "alidade/validate/projection_std_check.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>
#include <string>
#include <utility>

#include <fmt/format.h>

#include "alidade/camera/projection_uncertainty.h"
#include "alidade/core/error.h"

namespace alidade {
namespace {

// Half a unit of the fourth digit.
double halfUnit(double value) {
  return value > 0 ? 0.5 * std::pow(10.0, std::floor(std::log10(value)) - 3) : 0;
}

// Stated and recomputed with room for rounding: `lost` is how much of the variance may be rounding.
bool agree(double stated, double recomputed, double lost) {
  if (std::isnan(stated) || std::isnan(recomputed)) return std::isnan(stated) == std::isnan(recomputed);
  constexpr double kShare = 1e-9;  // a number half way between two of four digits
  const double low = std::sqrt(std::max(0.0, recomputed * recomputed - lost));
  const double high = std::sqrt(recomputed * recomputed + lost);
  const double half = std::max(halfUnit(stated), halfUnit(recomputed));
  return stated >= low * (1 - kShare) - half && stated <= high * (1 + kShare) + half;
}

// The claim's length bounds what is recomputed, so that no file makes work out of all proportion to its size.
bool hasSquareCells(const ProjectionStdRecord& claim, ImageSize size) {
  const auto length = static_cast<std::size_t>(std::max(claim.columns, 0)) *
                      static_cast<std::size_t>(std::max(claim.rows, 0));
  if (length == 0 || claim.std_px.size() != length) return false;
  if (claim.columns > size.width || claim.rows > size.height) return false;
  if (claim.columns < 2) return size.width < 2 && claim.rows <= 2;
  const double cells = (size.height - 1.0) / (size.width - 1.0) * (claim.columns - 1);
  return std::abs(std::max(cells, size.height < 2 ? 0.0 : 1.0) - (claim.rows - 1)) < 0.51;
}

// What is stated at a place of the image, and what the covariance leads to.
struct Differing {
  std::string where;
  double stated = 0;
  double recomputed = 0;
};

std::optional<Differing> firstDifference(const CameraRecord& record, const ProjectionStdRecord& claim,
                                         const Eigen::MatrixXd& covariance) {
  const ProjectionUncertainty uncertainty(record.camera, record.image_size,
                                          std::numeric_limits<double>::infinity(), std::nullopt,
                                          std::max(claim.columns, 2));
  const UncertaintyGrid grid = uncertainty.grid(covariance);
  const Eigen::VectorXd std = covariance.diagonal().cwiseSqrt();
  expect(grid.std_px.size() == claim.std_px.size(), "a grid of the same cells");
  double lost = 0;  // the most of all pixels
  for (std::size_t i = 0; i < grid.pixels.size(); ++i) {
    // The variance is a sum of terms as large as this times the machine's precision, or smaller.
    constexpr double kPrecision = 1e-13;  // of some hundred terms
    const double terms = (uncertainty.jacobian(static_cast<int>(i)).cwiseAbs() * std).norm();
    const double lost_here = kPrecision * terms * terms;
    lost = std::max(lost, lost_here);
    if (agree(claim.std_px[i], grid.std_px[i], lost_here)) continue;
    return Differing{.where = fmt::format("pixel ({:.0f}, {:.0f})", grid.pixels[i].x(), grid.pixels[i].y()),
                     .stated = claim.std_px[i],
                     .recomputed = grid.std_px[i]};
  }
  if (!agree(claim.center_px, grid.center_px, lost))
    return Differing{"the image's centre", claim.center_px, grid.center_px};
  if (!agree(claim.worst_px, grid.worst_px, lost))
    return Differing{"the worst pixel", claim.worst_px, grid.worst_px};
  // Several pixels may be the worst but for rounding.
  const auto nearest = std::min_element(
      grid.pixels.begin(), grid.pixels.end(), [&](const Eigen::Vector2d& a, const Eigen::Vector2d& b) {
        return (a - claim.worst_pixel).squaredNorm() < (b - claim.worst_pixel).squaredNorm();
      });
  const double there = grid.std_px[static_cast<std::size_t>(nearest - grid.pixels.begin())];
  if ((*nearest - claim.worst_pixel).norm() > 0.5 || !agree(claim.worst_px, there, lost)) {
    return Differing{fmt::format("pixel ({:.6g}, {:.6g}), which is called the worst", claim.worst_pixel.x(),
                                 claim.worst_pixel.y()),
                     claim.worst_px, there};
  }
  return std::nullopt;
}

std::string stdText(double value) {
  return std::isnan(value) ? "no ray" : fmt::format("{:.4g} px", value);
}

}  // namespace

std::optional<Diagnosis> checkProjectionStd(const CameraRecord& record) {
  if (!record.calibration) return std::nullopt;
  const CalibrationRecord& calibration = *record.calibration;
  const auto& claim = calibration.projection_std;
  const auto& covariance =
      calibration.stated_covariance.empty() ? calibration.covariance : calibration.stated_covariance;
  if (!claim && covariance.empty()) return std::nullopt;
  Diagnosis check{.severity = Severity::kWarning,
                  .id = "projection_std",
                  .cause = "the file does not say how well pixels are known, though its covariance tells",
                  .evidence = "not stated",
                  .limit = "what the covariance leads to, in four digits"};
  if (!claim) return check;
  check.evidence =
      fmt::format("{} at the centre, {} at worst", stdText(claim->center_px), stdText(claim->worst_px));
  if (covariance.empty()) {
    check.cause = "it cannot be recomputed: the file states no covariance";
    return check;
  }
  check.severity = Severity::kFailure;
  if (!hasSquareCells(*claim, record.image_size)) {
    check.evidence = fmt::format("a grid of {}x{}", claim->columns, claim->rows);
    check.limit = fmt::format("square cells from border to border of {}x{} px", record.image_size.width,
                              record.image_size.height);
    check.cause = "the grid does not suit the image; was its size changed?";
    return check;
  }
  const auto n = static_cast<Eigen::Index>(record.camera.parameters().size());
  if (const auto differing = firstDifference(record, *claim, fullMatrix(covariance, n))) {
    check.evidence = fmt::format("{} at {}", stdText(differing->stated), differing->where);
    check.limit = fmt::format("{}, what the covariance leads to", stdText(differing->recomputed));
    check.cause = "the stated uncertainty of pixels is not that of the covariance; were numbers edited?";
    return check;
  }
  check.severity = Severity::kPass;
  check.cause = "the uncertainty of pixels is that of the covariance, all over the image";
  return check;
}

}  // namespace alidade
