// SPDX-License-Identifier: MIT
#include "alidade/footage/geometry/two_view.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <utility>

#include <Eigen/LU>

#include "alidade/adjust/scene/scene_fit.h"
#include "alidade/core/median.h"
#include "alidade/core/random.h"
#include "alidade/geometry/rotation_conversions.h"
#include "alidade/geometry/symmetric_eigen.h"

namespace alidade {
namespace {

constexpr int kTrials = 300;

// A match as unit rays, and their derivatives by the pixels.
struct RayMatch {
  RayPair rays;
  Eigen::Matrix<double, 3, 2> J_a;
  Eigen::Matrix<double, 3, 2> J_b;
  std::size_t index = 0;
};

std::vector<RayMatch> rayMatches(const AnyCamera& camera, std::span<const PixelMatch> matches) {
  std::vector<RayMatch> rays;
  rays.reserve(matches.size());
  Eigen::Matrix<double, 3, 2, Eigen::RowMajor> J_a;
  Eigen::Matrix<double, 3, 2, Eigen::RowMajor> J_b;
  for (std::size_t i = 0; i < matches.size(); ++i) {
    const auto a = camera.unproject(matches[i].a, J_a.data());
    const auto b = camera.unproject(matches[i].b, J_b.data());
    if (a && b) rays.push_back({{*a, *b}, J_a, J_b, i});
  }
  return rays;
}

// Squared, px: the error of the epipolar constraint over its standard deviation for pixels of 1 px
// (Sampson 1982).
double sampson(const Eigen::Matrix3d& E, const RayMatch& match) {
  const Eigen::Vector3d line_b = E * match.rays.a;
  const Eigen::Vector3d line_a = E.transpose() * match.rays.b;
  const double error = match.rays.b.dot(line_b);
  const double variance =
      (match.J_a.transpose() * line_a).squaredNorm() + (match.J_b.transpose() * line_b).squaredNorm();
  return error * error / variance;
}

// Squared distance, px, from the ray of b to another direction, in the tangent plane of the sphere at b.
double offset(const RayMatch& match, const Eigen::Vector3d& direction) {
  const double cosine = direction.dot(match.rays.b);
  if (!(cosine > 0.5 * direction.norm())) return std::numeric_limits<double>::infinity();
  const Eigen::Vector3d across = direction / cosine - match.rays.b;
  const Eigen::Matrix2d normal = match.J_b.transpose() * match.J_b;
  return (normal.inverse() * (match.J_b.transpose() * across)).squaredNorm();
}

Eigen::Matrix3d homography(std::span<const RayPair> pairs) {
  Eigen::Matrix<double, 9, 9> normal = Eigen::Matrix<double, 9, 9>::Zero();
  for (const RayPair& pair : pairs) {
    // b x (H a) = 0, H by rows.
    const Eigen::Matrix3d B = hat(pair.b);
    Eigen::Matrix<double, 3, 9> rows;
    for (Eigen::Index i = 0; i < 3; ++i) rows.middleCols<3>(3 * i) = B.col(i) * pair.a.transpose();
    normal += rows.transpose() * rows;
  }
  const Eigen::Matrix<double, 9, 1> h = SymmetricEigen(normal).eigenvectors().col(0);
  Eigen::Matrix3d H = Eigen::Map<const Eigen::Matrix<double, 3, 3, Eigen::RowMajor>>(h.data());
  double side = 0;
  for (const RayPair& pair : pairs) side += pair.b.dot(H * pair.a) > 0 ? 1 : -1;
  return side < 0 ? Eigen::Matrix3d(-H) : H;
}

template <class Error>
double truncatedSum(std::span<const RayMatch> matches, double limit, const Error& error) {
  double sum = 0;
  for (const RayMatch& match : matches) {
    const double e = error(match);
    sum += e < limit ? e : limit;  // NaN counts as an outlier
  }
  return sum;
}

template <std::size_t kCount>
std::array<RayPair, kCount> sampleOf(std::span<const RayMatch> matches, Random& random) {
  std::array<std::size_t, kCount> chosen{};
  std::array<RayPair, kCount> sample;
  for (std::size_t i = 0; i < kCount; ++i) {
    bool is_new = false;
    while (!is_new) {
      chosen[i] = random.index(matches.size());
      is_new = std::find(chosen.begin(), chosen.begin() + static_cast<std::ptrdiff_t>(i), chosen[i]) ==
               chosen.begin() + static_cast<std::ptrdiff_t>(i);
    }
    sample[i] = matches[chosen[i]].rays;
  }
  return sample;
}

// Number of trials for a nearly certain sample without outliers.
int trialsFor(double inlier_share, int sample_size) {
  constexpr double kMissed = 1e-4;
  const double good = std::pow(inlier_share, sample_size);
  if (good >= 1 - 1e-9) return 1;
  return static_cast<int>(std::min<double>(kTrials, std::ceil(std::log(kMissed) / std::log1p(-good))));
}

std::size_t largestHomographySupport(std::span<const RayMatch> matches, double limit, Random& random) {
  double best = std::numeric_limits<double>::infinity();
  Eigen::Matrix3d H = Eigen::Matrix3d::Identity();
  const auto score = [&](const Eigen::Matrix3d& candidate) {
    const double sum =
        truncatedSum(matches, limit, [&](const RayMatch& m) { return offset(m, candidate * m.rays.a); });
    if (!(sum < best)) return false;
    best = sum;
    H = candidate;
    return true;
  };
  const auto agreeing = [&] {
    std::vector<RayPair> pairs;
    for (const RayMatch& m : matches) {
      if (offset(m, H * m.rays.a) < limit) pairs.push_back(m.rays);
    }
    return pairs;
  };
  for (int trial = 0; trial < 100; ++trial) score(homography(sampleOf<4>(matches, random)));
  for (int round = 0; round < 5; ++round) {
    const std::vector<RayPair> inliers = agreeing();
    if (inliers.size() < 4 || !score(homography(inliers))) break;
  }
  return agreeing().size();
}

// The essential matrix from random samples with the most agreeing matches.
Eigen::Matrix3d bestEssential(std::span<const RayMatch> matches, double limit, Random& random) {
  constexpr int kFewestTrials = 20;
  double best = std::numeric_limits<double>::infinity();
  Eigen::Matrix3d E = Eigen::Matrix3d::Zero();
  int num_trials = kTrials;
  for (int trial = 0; trial < num_trials; ++trial) {
    for (const Eigen::Matrix3d& candidate : essentialMatrices(sampleOf<5>(matches, random))) {
      const double sum =
          truncatedSum(matches, limit, [&](const RayMatch& m) { return sampson(candidate, m); });
      if (!(sum < best)) continue;
      best = sum;
      E = candidate;
      const auto count =
          std::ranges::count_if(matches, [&](const RayMatch& m) { return sampson(E, m) < limit; });
      const double share = static_cast<double>(count) / static_cast<double>(matches.size());
      num_trials = std::max(kFewestTrials, trialsFor(share, 5));
    }
  }
  return E;
}

// The one of the four motions of an essential matrix with the most points in front of both cameras, and their
// number.
std::pair<SE3, std::size_t> motionInFront(const Eigen::Matrix3d& E, std::span<const RayMatch> matches) {
  std::pair<SE3, std::size_t> best;
  for (const SE3& motion : motionsOf(E)) {
    const auto count = static_cast<std::size_t>(std::ranges::count_if(
        matches, [&](const RayMatch& m) { return (depthsOf(m.rays, motion) > 0).all(); }));
    if (count > best.second) best = {motion, count};
  }
  return best;
}

// Median distance, px, between rays of b and rotated rays of a.
double parallaxOf(std::span<const RayMatch> matches, const SO3& rotation) {
  std::vector<double> displacements;
  for (const RayMatch& match : matches)
    displacements.push_back(std::sqrt(std::min(1e12, offset(match, rotation * match.rays.a))));
  return medianOf(std::move(displacements));
}

// The two images as a scene of the matched points that both see; the two sightings of a point are adjacent.
SceneFit pairScene(const AnyCamera& camera, std::span<const PixelMatch> matches,
                   std::span<const RayMatch> inliers, const SE3& b_from_a, double farthest_px) {
  SceneFit fit{.camera = camera,
               .camera_from_world = {SE3(), b_from_a},
               .points = {},
               .sightings = {},
               .loss = {.threshold_px = 3}};
  fit.points.assign(matches.size(), Eigen::Vector4d::Zero());
  for (const RayMatch& match : inliers) {
    const std::array<Eigen::Vector3d, 2> rays = {match.rays.a, match.rays.b};
    const auto id = static_cast<std::uint32_t>(match.index);
    fit.points[id] = pointOnRays(fit.camera_from_world, rays);
    const PixelMatch& pixels = matches[id];
    const std::array<SceneSighting, 2> sightings = {
        SceneSighting{.frame = 0, .point = id, .pixel = pixels.a, .sigma_px = pixels.sigma_px},
        SceneSighting{.frame = 1, .point = id, .pixel = pixels.b, .sigma_px = pixels.sigma_px}};
    const bool is_seen = std::ranges::all_of(sightings, [&](const SceneSighting& sighting) {
      return sightingError(fit, sighting).norm() < farthest_px;
    });
    if (is_seen) fit.sightings.insert(fit.sightings.end(), sightings.begin(), sightings.end());
  }
  return fit;
}

// Solves a scene; false if it shows too little, or cannot be solved.
bool trySolve(SceneFit& scene, double function_tolerance) {
  if (scene.sightings.size() < 2 * TwoView::kFewestInliers) return false;
  scene = solveScene(std::move(scene), {.max_iterations = 30, .function_tolerance = function_tolerance});
  return scene.summary.termination != Termination::kFailed;
}

SE3 motionOf(const SceneFit& fit) {
  SE3 motion = fit.camera_from_world[1];
  const double length = motion.translation.norm();
  if (length > 0) motion.translation /= length;
  return motion;
}

// Covariance of the motion. Its translation has length 1 by definition, without information.
Eigen::Matrix<double, 6, 6> motionCovariance(const SceneFit& fit) {
  const SceneEquations equations = sceneEquations(fit);
  const SE3& motion = fit.camera_from_world[1];
  const double length = motion.translation.norm();
  Eigen::Matrix<double, 6, 6> covariance = equations.pose_covariance.view();
  covariance.topRows<3>() /= length;
  covariance.leftCols<3>() /= length;
  const Eigen::Vector3d along = (motion.rotation.inverse() * motion.translation).normalized();
  Eigen::Matrix<double, 6, 6> held = Eigen::Matrix<double, 6, 6>::Identity();
  held.topLeftCorner<3, 3>() -= along * along.transpose();
  const double variance = 2 * equations.cost / std::max(1.0, equations.num_redundant);
  return variance * held * covariance * held.transpose();
}

// Checks if a rotation, or a plane, explains all but a few matches: with fewer unknowns, and with two errors
// per match instead of one.
TwoViewKind kindOf(std::span<const RayMatch> matches, const SO3& rotation, double parallax_px,
                   double sigma_px, Random& random) {
  constexpr double kAll = 0.95;
  const double limit = std::pow(std::max(4 * sigma_px, 0.5), 2);
  const auto isAll = [&](std::size_t count) {
    return static_cast<double>(count) >= kAll * static_cast<double>(matches.size());
  };
  const auto num_turned = static_cast<std::size_t>(std::ranges::count_if(
      matches, [&](const RayMatch& m) { return offset(m, rotation * m.rays.a) < limit; }));
  if (isAll(num_turned) || parallax_px < 3 * sigma_px) return TwoViewKind::kRotation;
  return isAll(largestHomographySupport(matches, limit, random)) ? TwoViewKind::kPlane
                                                                 : TwoViewKind::kGeneral;
}

}  // namespace

std::vector<PixelMatch> matchesOf(const std::vector<TrackPixel>& a, const std::vector<TrackPixel>& b) {
  std::vector<PixelMatch> matches;
  for (const auto& [i, j] : commonTracks(a, b))
    matches.push_back({a[i].pixel, b[j].pixel, std::hypot(a[i].sigma_px, b[j].sigma_px) / std::sqrt(2.0)});
  return matches;
}

double agreementPx(ImageSize size) {
  return std::max(2.0, 0.002 * std::hypot(size.width, size.height));
}

SO3 commonRotation(std::span<const RayPair> pairs) {
  // Iteratively reweighted: the weight of a pair is the inverse of its distance (the L1 norm).
  SO3 rotation;
  std::vector<double> weights(pairs.size(), 1.0);
  for (int round = 0; round < 15; ++round) {
    Eigen::Matrix3d correlation = Eigen::Matrix3d::Zero();
    for (std::size_t i = 0; i < pairs.size(); ++i)
      correlation += weights[i] * pairs[i].b * pairs[i].a.transpose();
    rotation = bestRotation(correlation);
    for (std::size_t i = 0; i < pairs.size(); ++i)
      weights[i] = 1 / std::max(1e-4, (pairs[i].b - rotation * pairs[i].a).norm());
  }
  return rotation;
}

double parallaxAngle(std::span<const RayPair> pairs) {
  const SO3 rotation = commonRotation(pairs);
  std::vector<double> angles;
  for (const RayPair& pair : pairs) angles.push_back((pair.b - rotation * pair.a).norm());
  return medianOf(std::move(angles));
}

Eigen::Vector4d pointOnRays(std::span<const SE3> camera_from_world, std::span<const Eigen::Vector3d> rays) {
  Eigen::Matrix4d normal = Eigen::Matrix4d::Zero();
  for (std::size_t i = 0; i < rays.size(); ++i) {
    Eigen::Matrix<double, 3, 4> pose;
    pose << camera_from_world[i].rotation.matrix(), camera_from_world[i].translation;
    const Eigen::Matrix<double, 3, 4> rows = hat(rays[i]) * pose;
    normal += rows.transpose() * rows;
  }
  Eigen::Vector4d point = SymmetricEigen(normal).eigenvectors().col(0);
  double side = 0;
  for (std::size_t i = 0; i < rays.size(); ++i) {
    const Eigen::Vector3d at = camera_from_world[i].rotation * Eigen::Vector3d(point.head<3>()) +
                               camera_from_world[i].translation * point.w();
    side += rays[i].dot(at) > 0 ? 1 : -1;
  }
  return side < 0 ? Eigen::Vector4d(-point) : point;
}

TwoView estimateTwoView(const AnyCamera& camera, std::span<const PixelMatch> matches, ImageSize size,
                        std::uint64_t seed) {
  TwoView result;
  result.is_inlier.assign(matches.size(), false);
  result.points.assign(matches.size(), Eigen::Vector4d::Zero());
  const std::vector<RayMatch> rays = rayMatches(camera, matches);
  if (rays.size() < TwoView::kFewestInliers) return result;
  const double threshold = agreementPx(size);
  Random random(seed);
  const Eigen::Matrix3d E = bestEssential(rays, threshold * threshold, random);
  std::vector<RayMatch> inliers;
  std::vector<RayPair> pairs;
  for (const RayMatch& match : rays) {
    if (!(sampson(E, match) < threshold * threshold)) continue;
    inliers.push_back(match);
    pairs.push_back(match.rays);
  }
  if (inliers.size() < TwoView::kFewestInliers) return result;
  const auto [start, num_in_front] = motionInFront(E, inliers);
  const SO3 rotation = commonRotation(pairs);
  result.b_from_a = start;
  result.parallax_px = parallaxOf(inliers, rotation);

  // Solves motion and points together.
  SceneFit scene = pairScene(camera, matches, inliers, start, 5 * threshold);
  if (!trySolve(scene, 1e-6)) return result;
  // The noise, from the remaining errors: each match has one redundant coordinate. An error far beyond it is
  // a false match that lies by chance near its epipolar line.
  const Eigen::Matrix3d refined = essentialMatrix(motionOf(scene));
  std::vector<double> errors;
  for (const RayMatch& match : inliers) errors.push_back(std::sqrt(sampson(refined, match)));
  constexpr double kSigmaByMedian = 1.4826;  // of a normal variable
  const double sigma = std::max(0.02, kSigmaByMedian * medianOf(std::move(errors)));
  const double close_px = std::min(threshold, 3.5 * sigma);
  std::vector<RayMatch> close;
  std::vector<bool> is_close(matches.size());
  for (const RayMatch& match : inliers) {
    if (!(sampson(refined, match) < close_px * close_px)) continue;
    close.push_back(match);
    is_close[match.index] = true;
  }
  std::erase_if(scene.sightings, [&](const SceneSighting& sighting) { return !is_close[sighting.point]; });
  if (!trySolve(scene, 1e-8)) return result;

  result.b_from_a = motionOf(scene);
  const double length = scene.camera_from_world[1].translation.norm();
  for (const SceneSighting& sighting : scene.sightings) {
    if (sighting.frame > 0) continue;
    Eigen::Vector4d point = scene.points[sighting.point];
    if (length > 0) point.head<3>() /= length;
    result.points[sighting.point] = point.normalized();
    result.is_inlier[sighting.point] = true;
    ++result.num_inliers;
  }
  if (2 * num_in_front < inliers.size()) return result;  // not a single motion
  result.kind = kindOf(close, rotation, result.parallax_px, sigma, random);
  if (result.kind == TwoViewKind::kRotation) {
    result.b_from_a = {rotation, Eigen::Vector3d::Zero()};
  } else {
    result.covariance = motionCovariance(scene);
  }
  return result;
}

}  // namespace alidade
