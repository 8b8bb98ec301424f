// SPDX-License-Identifier: MIT
#include "alidade/footage/map/reconstruction.h"

#include <algorithm>
#include <cmath>
#include <functional>
#include <limits>
#include <map>
#include <set>
#include <utility>

#include "alidade/core/mapped.h"
#include "alidade/core/median.h"
#include "alidade/core/parallel.h"
#include "alidade/footage/geometry/resection.h"

namespace alidade {
namespace {

constexpr std::uint64_t kSeed = 1;

double startScore(std::size_t num_points, double parallax_px) {
  constexpr double kEnough = 60;  // px of parallax; more does not improve the start
  return std::sqrt(static_cast<double>(num_points)) * std::min(kEnough, parallax_px);
}

// All pairs of frames, the best starting pair first.
std::vector<std::pair<std::size_t, std::size_t>> rankedPairs(
    const FootageTracks& tracks, std::span<const std::size_t> frames,
    const std::vector<std::vector<std::optional<Eigen::Vector3d>>>& rays, double focal_px) {
  std::vector<std::pair<double, std::pair<std::size_t, std::size_t>>> scored;
  for (std::size_t i = 0; i < frames.size(); ++i) {
    for (std::size_t j = i + 1; j < frames.size(); ++j) {
      std::vector<RayPair> common;
      for (const auto& [a, b] : commonTracks(tracks.frames[frames[i]], tracks.frames[frames[j]])) {
        if (rays[i][a] && rays[j][b]) common.push_back({*rays[i][a], *rays[j][b]});
      }
      if (common.size() < TwoView::kFewestInliers) continue;
      const double parallax = focal_px * parallaxAngle(common);
      // False matches in photographs may have any parallax.
      const auto num_common = static_cast<double>(common.size());
      scored.push_back({tracks.is_video ? startScore(common.size(), parallax) : num_common, {i, j}});
    }
  }
  std::ranges::stable_sort(scored, std::greater(), [](const auto& pair) { return pair.first; });
  return mapped(scored, [](const auto& pair) { return pair.second; });
}

// Finds poses and points step by step.
class Builder {
 public:
  Builder(const AnyCamera& camera, const FootageTracks& tracks, std::span<const std::size_t> frames,
          const CancelFlag* cancel)
      : camera_(camera),
        tracks_(tracks),
        frames_(frames.begin(), frames.end()),
        cancel_(cancel),
        threshold_px_(agreementPx(tracks.size)),
        poses_(frames.size()) {
    for (const std::size_t frame : frames_) {
      auto& rays = rays_.emplace_back();
      for (const TrackPixel& at : tracks.frames[frame]) rays.push_back(camera.unproject(at.pixel));
    }
  }

  Reconstruction build() {
    Reconstruction result;
    if (!start(result)) return result;
    while (addFrame()) triangulate();
    settle(result);
    return result;
  }

 private:
  bool start(Reconstruction& result) {
    const double focal_px = 0.5 * (camera_.parameters()[0] + camera_.parameters()[1]);
    const auto pairs = rankedPairs(tracks_, frames_, rays_, focal_px);
    // False matches distort the ranking, but not the two-view estimate of a pair.
    const std::size_t most_tried = tracks_.is_video ? 4 : 40;
    double best = 0;
    for (std::size_t k = 0; k < std::min(most_tried, pairs.size()); ++k) {
      const auto& a = tracks_.frames[frames_[pairs[k].first]];
      const auto& b = tracks_.frames[frames_[pairs[k].second]];
      const std::vector<PixelMatch> matches = matchesOf(a, b);
      const TwoView two = estimateTwoView(camera_, matches, tracks_.size, kSeed + k);
      result.parallax_px = std::max(result.parallax_px, two.parallax_px);
      if (two.kind == TwoViewKind::kRotation && best == 0) result.kind = two.kind;
      if (two.kind != TwoViewKind::kGeneral && two.kind != TwoViewKind::kPlane) continue;
      // If most matches are false, some may agree by chance.
      const double share = static_cast<double>(two.num_inliers) / static_cast<double>(matches.size());
      const double score = share * share * startScore(two.num_inliers, two.parallax_px);
      if (score <= best) continue;
      best = score;
      result.kind = two.kind;
      std::fill(poses_.begin(), poses_.end(), std::nullopt);
      points_.clear();
      poses_[pairs[k].first] = SE3();
      poses_[pairs[k].second] = two.b_from_a;
      const auto common = commonTracks(a, b);
      for (std::size_t i = 0; i < common.size(); ++i) {
        if (two.is_inlier[i]) points_[a[common[i].first].track] = two.points[i];
      }
    }
    return best > 0;
  }

  // Adds the frame with the most known points; false if there is none left.
  bool addFrame() {
    throwIfCancelled(cancel_);
    constexpr std::size_t kFewestKnown = 15;
    std::size_t best = frames_.size();
    std::size_t most = kFewestKnown - 1;
    for (std::size_t i = 0; i < frames_.size(); ++i) {
      if (poses_[i] || refused_.contains(i)) continue;
      std::size_t count = 0;
      for (const TrackPixel& at : tracks_.frames[frames_[i]]) count += points_.contains(at.track) ? 1 : 0;
      if (count > most) {
        most = count;
        best = i;
      }
    }
    if (best == frames_.size()) return false;
    std::vector<KnownPoint> known;
    for (const TrackPixel& at : tracks_.frames[frames_[best]]) {
      const auto found = points_.find(at.track);
      if (found != points_.end()) known.push_back({found->second, at.pixel, at.sigma_px});
    }
    const auto pose = resect(camera_, known, nearestPose(best), 2 * threshold_px_, kSeed + best);
    if (pose && 2 * pose->num_inliers > known.size()) {
      poses_[best] = pose->camera_from_world;
    } else {
      refused_.insert(best);
    }
    return true;
  }

  [[nodiscard]] std::optional<SE3> nearestPose(std::size_t frame) const {
    std::optional<SE3> nearest;
    std::size_t least = frames_.size();
    for (std::size_t i = 0; i < frames_.size(); ++i) {
      const std::size_t distance = i > frame ? i - frame : frame - i;
      if (!poses_[i] || distance >= least) continue;
      least = distance;
      nearest = poses_[i];
    }
    return nearest;
  }

  // Triangulates tracks in two or more posed frames that have no point yet.
  void triangulate() {
    std::map<std::uint32_t, std::vector<std::pair<std::size_t, std::size_t>>> seen;
    for (std::size_t i = 0; i < frames_.size(); ++i) {
      if (!poses_[i]) continue;
      const auto& frame = tracks_.frames[frames_[i]];
      for (std::size_t k = 0; k < frame.size(); ++k) {
        if (rays_[i][k] && !points_.contains(frame[k].track)) seen[frame[k].track].emplace_back(i, k);
      }
    }
    for (const auto& [track, sightings] : seen) {
      if (sightings.size() < 2) continue;
      std::vector<SE3> poses;
      std::vector<Eigen::Vector3d> rays;
      for (const auto& [i, k] : sightings) {
        poses.push_back(*poses_[i]);
        rays.push_back(*rays_[i][k]);
      }
      const Eigen::Vector4d point = pointOnRays(poses, rays);
      std::size_t num_close = 0;
      for (const auto& [i, k] : sightings) {
        const Eigen::Vector2d& pixel = tracks_.frames[frames_[i]][k].pixel;
        num_close += errorOf(camera_, *poses_[i], point, pixel) < 3 * threshold_px_ ? 1 : 0;
      }
      if (num_close == sightings.size()) points_[track] = point;
    }
  }

  void settle(Reconstruction& result) {
    // Makes the first posed frame the world.
    std::vector<std::size_t> posed;
    for (std::size_t i = 0; i < frames_.size(); ++i) {
      if (poses_[i]) posed.push_back(i);
    }
    const SE3 world_from_first = poses_[posed.front()]->inverse();
    SceneFit fit{
        .camera = camera_, .camera_from_world = {}, .points = {}, .sightings = {}, .size = tracks_.size};
    for (const std::size_t i : posed) {
      result.frames.push_back(frames_[i]);
      fit.camera_from_world.push_back(*poses_[i] * world_from_first);
    }
    const Eigen::Matrix4d first_from_world = world_from_first.inverse().matrix();
    std::map<std::uint32_t, std::uint32_t> index_of;
    for (const auto& [track, point] : points_) {
      index_of[track] = static_cast<std::uint32_t>(fit.points.size());
      fit.points.push_back((first_from_world * point).normalized());
    }
    std::size_t num_pixels = 0;
    for (std::size_t k = 0; k < posed.size(); ++k) {
      for (const TrackPixel& at : tracks_.frames[frames_[posed[k]]]) {
        const auto found = index_of.find(at.track);
        if (found == index_of.end()) continue;
        ++num_pixels;
        SceneSighting sighting{
            .frame = static_cast<std::uint32_t>(k),
            .point = found->second,
            .pixel = at.pixel,
            .sigma_px = at.sigma_px,
            .readout_px = at.velocity_px * ((at.pixel.y() + 0.5) / tracks_.size.height - 0.5)};
        if (sightingError(fit, sighting).norm() < 10 * threshold_px_) fit.sightings.push_back(sighting);
      }
    }
    std::ranges::stable_sort(fit.sightings, {}, &SceneSighting::point);
    fit.loss = {.threshold_px = threshold_px_ / medianSigma(fit)};
    removeOutliers(fit, std::numeric_limits<double>::infinity());
    for (int round = 0; round < 3; ++round) {
      fit = solveScene(std::move(fit), {.max_iterations = 50, .function_tolerance = 1e-6, .cancel = cancel_});
      if (fit.summary.termination == Termination::kFailed) return;
      const double noise = noiseOf(fit);
      constexpr double kHuber = 2.5;
      constexpr double kOutlier = 5;
      fit.loss = {.threshold_px = kHuber * noise};
      removeOutliers(fit, kOutlier * noise);
      if (fit.sightings.size() < 4 * TwoView::kFewestInliers) return;
    }
    fit = solveScene(std::move(fit), {.max_iterations = 100, .function_tolerance = 1e-8, .cancel = cancel_});
    if (fit.summary.termination == Termination::kFailed) return;
    result.noise_px = noiseOf(fit) * medianSigma(fit);
    result.outlier_share = 1 - static_cast<double>(fit.sightings.size()) /
                                   static_cast<double>(std::max<std::size_t>(1, num_pixels));
    result.fit = std::move(fit);
  }

  static double medianSigma(const SceneFit& fit) {
    std::vector<double> sigmas;
    for (const SceneSighting& sighting : fit.sightings) sigmas.push_back(sighting.sigma_px);
    return sigmas.empty() ? 1 : medianOf(std::move(sigmas));
  }

  const AnyCamera& camera_;
  const FootageTracks& tracks_;
  std::vector<std::size_t> frames_;
  const CancelFlag* cancel_;
  double threshold_px_;
  std::vector<std::vector<std::optional<Eigen::Vector3d>>> rays_;
  std::vector<std::optional<SE3>> poses_;
  std::set<std::size_t> refused_;
  std::map<std::uint32_t, Eigen::Vector4d> points_;
};

}  // namespace

double noiseOf(const SceneFit& fit) {
  if (fit.sightings.empty()) return 0;
  std::vector<double> errors;
  for (const SceneSighting& sighting : fit.sightings)
    errors.push_back(sightingError(fit, sighting).norm() / sighting.sigma_px);
  // The median of the length of a normal 2-vector; poses and points absorb a share of the errors.
  constexpr double kMedianLength = 1.17741;
  double num_points = 0;
  for (std::size_t i = 0; i < fit.sightings.size(); ++i)
    num_points += i == 0 || fit.sightings[i].point != fit.sightings[i - 1].point ? 1 : 0;
  const double coordinates = 2 * static_cast<double>(fit.sightings.size());
  const double unknowns = 3 * num_points + 6 * static_cast<double>(fit.camera_from_world.size()) - 7;
  const double left = std::max(0.1, 1 - unknowns / coordinates);
  return medianOf(std::move(errors)) / kMedianLength / std::sqrt(left);
}

void removeOutliers(SceneFit& fit, double limit) {
  std::erase_if(fit.sightings, [&](const SceneSighting& sighting) {
    return !(sightingError(fit, sighting).norm() <= limit * sighting.sigma_px);
  });
  std::vector<std::size_t> count(fit.points.size(), 0);
  for (const SceneSighting& sighting : fit.sightings) ++count[sighting.point];
  std::erase_if(fit.sightings, [&](const SceneSighting& sighting) { return count[sighting.point] < 2; });
}

Reconstruction reconstruct(const AnyCamera& camera, const FootageTracks& tracks,
                           std::span<const std::size_t> frames, const CancelFlag* cancel) {
  return Builder(camera, tracks, frames, cancel).build();
}

FootageWindows reconstructAll(const AnyCamera& camera, const FootageTracks& tracks, int num_jobs,
                              const CancelFlag* cancel) {
  constexpr std::size_t kMost = 12;
  const auto groups = chooseWindows(tracks, kMost);
  std::vector<std::vector<Reconstruction>> found(groups.size());
  parallelFor(
      groups.size(), num_jobs,
      [&](std::size_t g) {
        std::vector<std::size_t> left = groups[g];
        while (left.size() >= 2 && found[g].size() < kMost) {
          const Reconstruction& window = found[g].emplace_back(reconstruct(camera, tracks, left, cancel));
          if (!window.fit || tracks.is_video) break;
          std::erase_if(left, [&](std::size_t frame) {
            return std::ranges::find(window.frames, frame) != window.frames.end();
          });
        }
      },
      cancel);
  FootageWindows result;
  for (auto& group : found) {
    for (Reconstruction& window : group)
      (window.fit ? result.windows : result.without_fit).push_back(std::move(window));
  }
  return result;
}

bool solveWindows(std::vector<Reconstruction>& windows, int num_jobs, const CancelFlag* cancel) {
  parallelFor(
      windows.size(), num_jobs,
      [&](std::size_t i) {
        SceneFit& fit = *windows[i].fit;
        fit =
            solveScene(std::move(fit), {.max_iterations = 200, .function_tolerance = 1e-6, .cancel = cancel});
      },
      cancel);
  return std::ranges::all_of(windows, [](const Reconstruction& window) {
    return window.fit->summary.termination == Termination::kConverged;
  });
}

}  // namespace alidade
