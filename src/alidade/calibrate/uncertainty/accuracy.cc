// SPDX-License-Identifier: MIT
#include "alidade/calibrate/uncertainty/accuracy.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <optional>
#include <string>
#include <string_view>

#include "alidade/adjust/board/lens_prior.h"
#include "alidade/adjust/noise/covariance.h"
#include "alidade/calibrate/uncertainty/aligned_difference.h"
#include "alidade/camera/model_fit.h"
#include "alidade/camera/model_traits.h"
#include "alidade/camera/projection_uncertainty.h"
#include "alidade/core/error.h"
#include "alidade/core/mapped.h"

namespace alidade {
namespace {

constexpr double kNan = std::numeric_limits<double>::quiet_NaN();

// The covariance of a flexible fit from its views and only a general prior on lenses.
std::optional<Eigen::MatrixXd> flexibleCovariance(const Fit& flexible, const Fit& fit, double variance) {
  const FitCamera& of = onlyCamera(flexible);
  Eigen::MatrixXd information = intrinsicsInformation(flexible).information;
  // Width for LensScale: the deviation of a lens from a stiff model in the corner of the image, 5 % of its
  // diagonal, or a tenth of that if the model has its own polynomial.
  const double deviation = modelTraits(onlyCamera(fit).model).is_polynomial ? 0.01 : 0.1;
  const LensPrior prior = lensScale(of.model, cameraOf(of), of.size).prior(deviation, variance);
  for (std::size_t i = 0; i < prior.precision.size(); ++i) {
    const auto at = static_cast<Eigen::Index>(i);
    information(at, at) += prior.precision[i];
  }
  constexpr double kHeld = 1e12;
  for (const int i : onlyCamera(fit).constraint.held) {
    if (i < static_cast<int>(kNumAffine)) information(i, i) *= kHeld;  // the same numbers in both models
  }
  const ScaledInverse scaled = scaledInverse(information);
  if (!scaled.inverse) return std::nullopt;
  const auto num_lens = static_cast<Eigen::Index>(of.numLensParams());
  return variance * scaled.inverse->topLeftCorner(num_lens, num_lens);
}

using Polygon = std::vector<Eigen::Vector2d>;

// Twice the area of the triangle, positive if c is to the left of the line from a to b (y up).
double turn(const Eigen::Vector2d& a, const Eigen::Vector2d& b, const Eigen::Vector2d& c) {
  const Eigen::Vector2d ab = b - a;
  const Eigen::Vector2d ac = c - a;
  return ab.x() * ac.y() - ab.y() * ac.x();
}

// One side of the hull of points in order of x: removes each point that the next one passes on the wrong
// side.
void addChain(const Polygon& points, Polygon& hull) {
  const std::size_t first = hull.size();
  for (const Eigen::Vector2d& point : points) {
    while (hull.size() >= first + 2 && turn(hull[hull.size() - 2], hull.back(), point) <= 0) hull.pop_back();
    hull.push_back(point);
  }
  hull.pop_back();  // the other side starts there
}

// Andrew 1979, Another efficient algorithm for convex hulls in two dimensions.
Polygon hullOf(const View& view) {
  Polygon points;
  for (const Corner& corner : view.corners) points.push_back(corner.pixel);
  std::ranges::sort(points, [](const Eigen::Vector2d& a, const Eigen::Vector2d& b) {
    return a.x() != b.x() ? a.x() < b.x() : a.y() < b.y();
  });
  Polygon hull;
  if (points.size() < 3) return hull;
  addChain(points, hull);
  std::ranges::reverse(points);
  addChain(points, hull);
  return hull;
}

bool isInside(const Polygon& hull, const Eigen::Vector2d& pixel) {
  if (hull.size() < 3) return false;
  for (std::size_t i = 0; i < hull.size(); ++i) {
    if (turn(hull[i], hull[(i + 1) % hull.size()], pixel) < 0) return false;
  }
  return true;
}

// The corners of a fit as views, for isCovered().
std::vector<View> seenCorners(const Fit& fit) {
  std::vector<View> views;
  for (const FitView& view : fit.views) {
    View& seen = views.emplace_back();
    for (const Observation& corner : view.corners) seen.corners.push_back({.pixel = corner.pixel});
  }
  return views;
}

// Derivatives of the pixels by the parameters, after the best alignment by a rotation (or pose) where boards
// were seen.
class Alignment {
 public:
  Alignment(const AnyCamera& camera, std::span<const Eigen::Vector2d> pixels,
            const std::vector<bool>& is_covered, double distance_m) {
    std::vector<Eigen::Vector2d> covered;
    std::vector<Eigen::Vector2d> others;
    for (std::size_t i = 0; i < pixels.size(); ++i) {
      index_.push_back(is_covered[i] ? covered.size() : others.size());
      (is_covered[i] ? covered : others).push_back(pixels[i]);
    }
    for (std::size_t i = 0; i < pixels.size(); ++i) {
      if (!is_covered[i]) index_[i] += covered.size();
    }
    aligned_ =
        alignedJacobians(camera, covered, others, std::isinf(distance_m) ? Freed::kRotation : Freed::kPose);
  }

  [[nodiscard]] bool hasRay(std::size_t i) const { return aligned_.has_ray[index_[i]]; }
  [[nodiscard]] double error(std::size_t i, const Eigen::MatrixXd& covariance) const {
    const auto A = aligned_.transposed.view().middleCols(2 * static_cast<Eigen::Index>(index_[i]), 2);
    return radius95(Eigen::Matrix2d(A.transpose() * covariance * A));
  }

 private:
  std::vector<std::size_t> index_;
  AlignedJacobians aligned_;
};

// The radius about the origin that a circular normal variable in the plane does not exceed with a probability
// of 95 % if its mean is `offset` away and `radius` is that about the mean: the quantile of Rice's
// distribution, within 0.7 %. For a long narrow distribution it is too small by up to 7 % or too large by up
// to 23 %.
double displacedRadius95(double offset, double radius) {
  constexpr double kAlong = 1.6449 / 2.4477;  // one coordinate's 95 % over the plane's, for large offsets
  return kAlong * radius + std::hypot(offset, (1 - kAlong) * radius);
}

// Largest differences to cameras that explain the corners equally well, px; 0 where these have no ray.
std::vector<double> largestDifferences(const AnyCamera& camera, std::span<const AnyCamera> alternatives,
                                       const std::vector<Eigen::Vector2d>& pixels,
                                       const std::vector<bool>& is_covered, double distance_m) {
  const std::vector<Eigen::Vector2d> covered = coveredPixels(pixels, is_covered);
  std::vector<double> largest(pixels.size(), 0.0);
  for (const AnyCamera& alternative : alternatives) {
    const std::vector<double> differences =
        alignedDifferences(camera, alternative, pixels, covered, distance_m);
    for (std::size_t i = 0; i < pixels.size(); ++i) largest[i] = std::fmax(largest[i], differences[i]);
  }
  return largest;
}

}  // namespace

// Leenhouts 1985, On the computation of bi-normal radial error, Navigation 32(1): within 0.2 %.
double radius95(const Eigen::Matrix2d& covariance) {
  const double mean = 0.5 * covariance.trace();
  const double half = 0.5 * (covariance(0, 0) - covariance(1, 1));
  const double root = std::sqrt(half * half + covariance(0, 1) * covariance(0, 1));
  const double large = mean + root;
  if (!(large > 0)) return large == 0 ? 0.0 : kNan;
  const double c = std::sqrt(std::max(0.0, mean - root) / large);
  return std::sqrt(large) * (1.960790 + c * (0.004071 + c * (0.114276 + c * 0.371625)));
}

std::vector<bool> isCovered(std::span<const Eigen::Vector2d> pixels, std::span<const View> views) {
  const std::vector<Polygon> hulls = mapped(views, hullOf);
  return mapped(pixels, [&](const Eigen::Vector2d& pixel) {
    return std::ranges::any_of(hulls, [&](const Polygon& hull) { return isInside(hull, pixel); });
  });
}

std::vector<Eigen::Vector2d> coveredPixels(std::span<const Eigen::Vector2d> pixels,
                                           const std::vector<bool>& is_covered) {
  std::vector<Eigen::Vector2d> covered;
  for (std::size_t i = 0; i < pixels.size(); ++i) {
    if (is_covered[i]) covered.push_back(pixels[i]);
  }
  return covered;
}

std::optional<Fit> flexibleFit(const Fit& fit) {
  const FitCamera& camera = onlyCamera(fit);
  const std::string_view flexible_id = modelTraits(camera.model).flexible_id;
  if (flexible_id.empty()) return std::nullopt;
  Fit flexible = fit;
  FitCamera& of = onlyCamera(flexible);
  try {
    const AnyCamera same = fitModel(cameraOf(camera), camera.size, std::string(flexible_id)).camera;
    setLens(flexible_id, same.parameters(), of);
  } catch (const Error&) {  // a lens that sees hardly anything of its image
    return std::nullopt;
  }
  of.constraint = {};
  of.weak_prior = {};
  return flexible;
}

Accuracy accuracyOf(const Fit& fit, const Uncertainty& known, std::span<const AnyCamera> alternatives,
                    double distance_m) {
  const FitCamera& camera = onlyCamera(fit);
  const UncertaintyGrid& grid = *known.projection_far;
  Accuracy accuracy{
      .distance_m = distance_m, .columns = grid.columns, .rows = grid.rows, .pixels = grid.pixels};
  accuracy.is_covered = isCovered(accuracy.pixels, seenCorners(fit));
  const AnyCamera result = cameraOf(camera);
  const Alignment stated(result, accuracy.pixels, accuracy.is_covered, distance_m);
  const Eigen::MatrixXd covariance = known.statedCovariance();
  double variance = known.coordinate_sigma_px * known.coordinate_sigma_px;
  if (known.isNoiseExceeded()) variance *= std::max(1.0, known.by_views->excess);
  const std::optional<Fit> flexible = flexibleFit(fit);
  const auto flexible_covariance = flexible ? flexibleCovariance(*flexible, fit, variance) : std::nullopt;
  const bool is_stiff = modelTraits(camera.model).is_stiff;
  std::optional<Alignment> open;
  if (flexible_covariance) {
    open.emplace(cameraOf(onlyCamera(*flexible)), accuracy.pixels, accuracy.is_covered, distance_m);
  }
  const std::vector<double> open_px =
      largestDifferences(result, alternatives, accuracy.pixels, accuracy.is_covered, distance_m);
  // The 95 % radius of a deviation whose two coordinates are normally distributed over the image.
  constexpr double kPlanar95 = 2.4477;
  if (known.hasBias()) accuracy.deviation_px = kPlanar95 / std::sqrt(2.0) * known.image_bias.rms_px;
  std::size_t num_rays = 0;
  std::size_t num_covered = 0;
  for (std::size_t i = 0; i < accuracy.pixels.size(); ++i) {
    double& error = accuracy.error_px.emplace_back(kNan);
    if (!stated.hasRay(i)) continue;
    ++num_rays;
    error = stated.error(i, covariance);
    const bool is_covered = accuracy.is_covered[i];
    double other = open_px[i];
    if ((!is_covered || is_stiff) && open && open->hasRay(i)) {
      const double flexible_px = open->error(i, *flexible_covariance);
      // The flexible camera, from which a stiff one is known to differ, has its own uncertainty.
      other = is_covered ? displacedRadius95(other, flexible_px) : std::max(other, flexible_px);
    }
    error = std::max(error, other);
    error += accuracy.deviation_px;
    if (is_covered) {
      ++num_covered;
      accuracy.covered_px = std::fmax(accuracy.covered_px, error);
    }
    if (!(error <= accuracy.worst_px)) {
      accuracy.worst_px = error;
      accuracy.worst_pixel = accuracy.pixels[i];
    }
  }
  accuracy.covered_share =
      num_rays == 0 ? 0.0 : static_cast<double>(num_covered) / static_cast<double>(num_rays);
  return accuracy;
}

}  // namespace alidade
