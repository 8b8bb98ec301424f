// SPDX-License-Identifier: MIT
#include "alidade/footage/check/rig_check.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <memory>
#include <numbers>
#include <utility>

#include <fmt/format.h>
#include <Eigen/Geometry>

#include "alidade/core/median.h"
#include "alidade/core/parallel.h"
#include "alidade/core/statistics.h"
#include "alidade/footage/follow/front_end.h"

namespace alidade {
namespace {

constexpr double kMostOutliers = 0.5;
// Fewer are not enough, because errors common to one image do not show in its scatter.
constexpr int kFewestInstants = 3;
constexpr std::size_t kFewest = TwoView::kFewestInliers;
constexpr double kSigmaByMedian = 1.4826;  // of a normal variable
constexpr double kOutlier = 3.5;           // times the noise
constexpr double kLeastNoise = 1e-3;       // in units of sigma_px
constexpr double kFar = 10;                // baselines; distance for stated effects

// Stated pixels in both cameras of points at kFar.
std::vector<PixelMatch> probesOf(const PosedPair& pair, std::span<const TimedMatch> matches,
                                 ImageSize second_size) {
  std::vector<PixelMatch> inside;
  std::vector<PixelMatch> all;
  const std::size_t step = 1 + matches.size() / 1000;
  for (std::size_t i = 0; i < matches.size(); i += step) {
    const auto ray = pair.first.unproject(matches[i].pixels.a);
    if (!ray) continue;
    const Projection seen = pair.second.project(pair.second_from_first * (kFar * *ray));
    if (!seen.ok()) continue;
    all.push_back({matches[i].pixels.a, seen.pixel});
    const Eigen::Vector2d& at = seen.pixel;
    if (at.x() >= 0 && at.y() >= 0 && at.x() < second_size.width && at.y() < second_size.height)
      inside.push_back(all.back());
  }
  return inside.size() < kFewest ? all : inside;
}

double quantileOfFinite(std::vector<double> values) {
  std::erase_if(values, [](double value) { return !std::isfinite(value); });
  return values.empty() ? std::numeric_limits<double>::infinity() : quantile95(std::move(values));
}

// Sets the effect and the size that would go unnoticed.
void addEffects(RigChange& change, std::span<const std::optional<PairShift>> shifts,
                const Eigen::MatrixXd& covariance) {
  std::vector<double> effects;
  std::vector<double> across_stds;
  std::vector<double> whole_stds;
  for (const auto& shift : shifts) {
    if (!shift) continue;
    const Eigen::Matrix3d of_shift = shift->J * covariance * shift->J.transpose();
    effects.push_back(std::abs(shift->across_x_y[0]));
    across_stds.push_back(std::sqrt(of_shift(0, 0)));
    whole_stds.push_back(std::sqrt(of_shift(1, 1) + of_shift(2, 2)));
  }
  change.setEffect(quantileOfFinite(std::move(effects)), quantileOfFinite(std::move(across_stds)));
  change.depth_blind_px = kNormal95 * quantileOfFinite(std::move(whole_stds));
}

double rmsOf(const PosedPair& pair, std::span<const TimedMatch> matches) {
  double sum = 0;
  double count = 0;
  for (const double error : sampsonErrors(pair, matches)) {
    if (!std::isfinite(error)) continue;
    sum += error * error;
    count += 1;
  }
  return count > 0 ? std::sqrt(sum / count) : 0;
}

// The standard deviation of a coordinate in units of sigma_px, from the median of errors within a limit.
double pairNoise(const PosedPair& pair, std::span<const TimedMatch> matches, double limit_px) {
  const std::vector<double> errors = sampsonErrors(pair, matches);
  std::vector<double> units;
  for (std::size_t i = 0; i < errors.size(); ++i) {
    if (std::abs(errors[i]) < limit_px) units.push_back(std::abs(errors[i]) / matches[i].pixels.sigma_px);
  }
  return units.empty() ? 1 : std::max(kLeastNoise, kSigmaByMedian * medianOf(std::move(units)));
}

std::vector<TimedMatch> within(const PosedPair& pair, std::span<const TimedMatch> matches, double limit_px,
                               double limit) {
  const std::vector<double> errors = sampsonErrors(pair, matches);
  std::vector<TimedMatch> close;
  for (std::size_t i = 0; i < errors.size(); ++i) {
    if (std::abs(errors[i]) < limit_px && std::abs(errors[i]) < limit * matches[i].pixels.sigma_px)
      close.push_back(matches[i]);
  }
  return close;
}

constexpr double kAnyError = std::numeric_limits<double>::infinity();

// The test of one pair, step by step.
class PairTest {
 public:
  PairTest(const MountedCamera& first, const MountedCamera& second, const FootageCheckOptions& options)
      : second_size_(second.image_size),
        stated_{first.camera, second.camera, second.camera_from_rig * first.camera_from_rig.inverse()},
        options_(options) {
    // The errors resemble those of the coarser camera.
    threshold_px_ = std::min(agreementPx(first.image_size), agreementPx(second.image_size));
    stated_.second_from_first.translation.normalize();
    freedoms_ = pairFreedoms(stated_, {first.image_size.width, second.image_size.width});
    check_.tolerance_px = options.tolerance_px;
  }

  RigPairCheck run(const std::vector<std::vector<PixelMatch>>& instants) {
    for (std::size_t k = 0; k < instants.size(); ++k) {
      for (const PixelMatch& match : instants[k]) {
        if (stated_.first.unproject(match.a) && stated_.second.unproject(match.b))
          matches_.push_back({match, k});
      }
    }
    check_.num_matches = static_cast<int>(matches_.size());
    if (matches_.size() < 2 * kFewest) {
      check_.gap = FootageGap::kFewPoints;
      return check_;
    }
    findUsed();
    countUsed(instants.size());
    if (check_.outlier_share > kMostOutliers || used_.size() < 2 * kFewest) {
      const bool are_few = check_.outlier_share <= kMostOutliers;
      check_.gap = are_few ? FootageGap::kFewPoints : FootageGap::kMovingScene;
      return check_;
    }
    if (testSides()) return check_;
    freeAll();
    judge();
    return check_;
  }

 private:
  // Fits a group to the matches within a limit, which decreases from wide to narrow.
  [[nodiscard]] Eigen::VectorXd searched(const PairFreedom& freedom, std::span<const TimedMatch> some) const {
    std::vector<double> sizes;
    for (const double error : sampsonErrors(stated_, some)) sizes.push_back(std::abs(error));
    constexpr double kWidest = 64;  // px
    double limit = std::clamp(3 * medianOf(std::move(sizes)), threshold_px_, kWidest);
    Eigen::VectorXd at = Eigen::VectorXd::Zero(freedom.size());
    for (bool is_last = false; !is_last; limit = std::max(threshold_px_, limit / 2)) {
      is_last = limit == threshold_px_;
      const auto pair = changedPair(stated_, freedom, at);
      const std::vector<TimedMatch> close = within(*pair, some, limit, kAnyError);
      if (close.size() < kFewest) continue;
      const double noise = pairNoise(*pair, close, limit);
      at = fitPair(stated_, freedom, close, at, noise, 6, options_.cancel).amounts;
    }
    return at;
  }

  // Chooses the matches for the verdict: those that agree with the stated pair, or with a changed one if that
  // explains clearly more.
  void findUsed() {
    std::vector<TimedMatch> some;
    const std::size_t step = 1 + matches_.size() / 1500;
    for (std::size_t i = 0; i < matches_.size(); i += step) some.push_back(matches_[i]);
    starts_.resize(freedoms_.size());
    parallelFor(
        freedoms_.size(), options_.num_jobs,
        [&](std::size_t i) { starts_[i] = searched(freedoms_[i], some); }, options_.cancel);
    const auto truncatedSum = [&](const PosedPair& pair) {
      double sum = 0;
      for (const double error : sampsonErrors(pair, matches_))
        sum += std::abs(error) < threshold_px_ ? error * error : threshold_px_ * threshold_px_;
      return sum;
    };
    constexpr double kClearly = 1.02;
    best_ = stated_;
    double least = truncatedSum(stated_);
    const double stated_sum = least;
    for (std::size_t i = 0; i < freedoms_.size(); ++i) {
      const auto pair = changedPair(stated_, freedoms_[i], starts_[i]);
      const double sum = truncatedSum(*pair);
      // Each unknown can fit one false match by chance.
      const double by_chance = threshold_px_ * threshold_px_ * static_cast<double>(freedoms_[i].size() + 3);
      if (sum >= least || kClearly * sum + by_chance >= stated_sum) continue;
      least = sum;
      best_ = *pair;
    }
    noise_ = pairNoise(best_, matches_, threshold_px_);
    used_ = within(best_, matches_, threshold_px_, kOutlier * noise_);
    check_.outlier_share = 1 - static_cast<double>(within(best_, matches_, threshold_px_, kAnyError).size()) /
                                   static_cast<double>(matches_.size());
  }

  void countUsed(std::size_t num_instants) {
    check_.num_used = static_cast<int>(used_.size());
    std::vector<std::size_t> counts(num_instants);
    std::vector<double> sigmas;
    for (const TimedMatch& match : used_) {
      ++counts[match.instant];
      sigmas.push_back(noise_ * match.pixels.sigma_px);
    }
    if (used_.empty()) return;
    check_.noise_px = medianOf(std::move(sigmas));
    check_.num_instants =
        static_cast<int>(std::ranges::count_if(counts, [](std::size_t n) { return n >= kFewest; }));
    check_.rms_px = rmsOf(stated_, used_);
  }

  // True if most points lie behind the stated cameras; epipolar curves alone cannot show this.
  bool testSides() {
    std::vector<double> parallaxes;
    std::size_t num_near = 0;
    std::size_t num_behind = 0;
    for (const TimedMatch& match : used_) {
      const auto a = stated_.first.unproject(match.pixels.a);
      const auto b = stated_.second.unproject(match.pixels.b);
      if (!a || !b) continue;
      const Eigen::Vector3d infinity = stated_.second_from_first.rotation * *a;
      const Projection far = stated_.second.project(infinity);
      if (!far.ok()) continue;
      parallaxes.push_back((far.pixel - match.pixels.b).norm());
      if (parallaxes.back() < std::max(3.0, 5 * check_.noise_px)) continue;
      ++num_near;
      num_behind += (depthsOf({*a, *b}, stated_.second_from_first) > 0).all() ? 0 : 1;
    }
    if (!parallaxes.empty()) check_.parallax_px = medianOf(std::move(parallaxes));
    constexpr double kMost = 0.8;
    constexpr double kLeast = 0.25;  // of all matches; fewer may be false
    if (num_near < kFewest || static_cast<double>(num_near) < kLeast * static_cast<double>(used_.size()) ||
        static_cast<double>(num_behind) < kMost * static_cast<double>(num_near))
      return false;
    check_.is_behind = true;
    check_.verdict = FootageVerdict::kInconsistent;
    return true;
  }

  [[nodiscard]] std::optional<RigChange> changeBy(std::size_t i,
                                                  const std::vector<PixelMatch>& probes) const {
    const PairFreedom& freedom = freedoms_[i];
    const auto fitTo = [&](const std::vector<TimedMatch>& some, const Eigen::VectorXd& start) {
      return fitPair(stated_, freedom, some, start, noise_, 30, options_.cancel);
    };
    // A match that nearly determines an unknown by itself may be false without showing it.
    std::vector<TimedMatch> judged = used_;
    PairFit fit = fitTo(judged, starts_[i]);
    for (int round = 0; round < 5 && fit.is_converged; ++round) {
      const double share = static_cast<double>(freedom.size()) / static_cast<double>(judged.size());
      const double limit = std::max(0.3, 3 * share);
      std::vector<TimedMatch> kept;
      for (std::size_t k = 0; k < judged.size(); ++k) {
        if (fit.leverages[k] <= limit) kept.push_back(judged[k]);
      }
      if (kept.size() == judged.size()) break;
      judged = std::move(kept);
      fit = fitTo(judged, Eigen::VectorXd::Zero(freedom.size()));
    }
    if (!fit.is_converged) return std::nullopt;
    const double given_cost = costOf(stated_, judged, noise_);
    RigChange change{{.kind = freedom.kind}, freedom.side, *changedPair(stated_, freedom, fit.amounts)};
    const double drop = given_cost - fit.cost;
    change.prior_cost = fit.prior_cost;
    change.setFit(fit.amounts, fit.covariance, drop - fit.prior_cost,
                  fit.dispersion * std::max(1.0, fit.disagreement));
    if (freedom.kind == CameraChangeKind::kRotation || freedom.kind == CameraChangeKind::kPosition ||
        freedom.kind == CameraChangeKind::kPose) {
      const Eigen::Index n = freedom.kind == CameraChangeKind::kPosition ? 2 : 3;
      const Eigen::VectorXd along = fit.amounts.head(n).normalized();
      change.angle_std = std::sqrt(along.dot(fit.covariance.topLeftCorner(n, n) * along));
    }
    change.rms_px = rmsOf(change.pair, used_);
    change.cost_drop = drop / given_cost;
    change.gain = (drop - fit.prior_cost - kPenalty * static_cast<double>(freedom.size())) / given_cost;
    addEffects(change, shiftsBy(stated_, freedom, fit.amounts, probes, kFar), fit.covariance);
    return change;
  }

  void freeAll() {
    const std::vector<PixelMatch> probes = probesOf(stated_, used_, second_size_);
    std::vector<std::optional<RigChange>> found(freedoms_.size());
    parallelFor(
        freedoms_.size(), options_.num_jobs, [&](std::size_t i) { found[i] = changeBy(i, probes); },
        options_.cancel);
    for (std::size_t i = 0; i < found.size(); ++i) {
      if (found[i]) check_.changes.push_back(*found[i]);
      if (found[i] || freedoms_[i].kind == CameraChangeKind::kSeveral) continue;
      // The direction of the baseline has no optimum if everything is far away.
      (freedoms_[i].kind == CameraChangeKind::kPosition ? is_position_open_ : has_open_) = true;
    }
  }

  // True if a separate pose for each instant explains matches that neither the explanation nor one pose does:
  // the two cameras did not see the same instants.
  [[nodiscard]] bool doInstantsDiffer() const {
    const auto pose = std::ranges::find(freedoms_, CameraChangeKind::kPose, &PairFreedom::kind);
    if (pose == freedoms_.end()) return false;
    const auto byInstant = [](const std::vector<TimedMatch>& matches) {
      std::map<std::size_t, std::vector<TimedMatch>> instants;
      for (const TimedMatch& match : matches) instants[match.instant].push_back(match);
      std::erase_if(instants, [](const auto& instant) { return instant.second.size() < kFewest; });
      return instants;
    };
    const auto used = byInstant(used_);
    if (used.size() < 2) return false;
    double explained_share = 0;  // by the explanation, or one pose for all instants
    for (std::size_t i = 0; i < check_.changes.size(); ++i) {
      if (check_.changes[i].kind == CameraChangeKind::kPose || check_.explanation == i)
        explained_share = std::max(explained_share, check_.changes[i].cost_drop);
    }
    double drop = 0;
    for (const auto& [instant, matches] : used) {
      const PairFit fit =
          fitPair(stated_, *pose, matches, Eigen::VectorXd::Zero(pose->size()), noise_, 30, options_.cancel);
      const double gain = costOf(stated_, matches, noise_) - fit.cost;
      drop += std::max(0.0, gain - kPenalty * static_cast<double>(pose->size()));
    }
    constexpr double kMost = 0.5;
    constexpr double kNotSmall = 0.05;  // of what the change explains
    const double cost = costOf(stated_, used_, noise_);
    const double further = drop / cost - explained_share;
    const double further_px = noise_ * std::sqrt(2 * cost * further / static_cast<double>(used_.size()));
    if (further > kMost * (1 - explained_share) && further > kNotSmall * explained_share &&
        further_px > check_.tolerance_px)
      return true;
    // Each unknown can fit one false match by chance.
    const auto by_chance = static_cast<std::size_t>(pose->size());
    std::size_t num_explained = 0;
    std::size_t num_in_common = 0;
    for (const auto& [instant, matches] : byInstant(matches_)) {
      const auto own = changedPair(stated_, *pose, searched(*pose, matches));
      const std::size_t in_common = within(best_, matches, threshold_px_, kAnyError).size();
      const std::size_t by_own = within(*own, matches, threshold_px_, kAnyError).size();
      num_in_common += in_common;
      num_explained += std::max(in_common, by_own - std::min(by_own, by_chance));
    }
    constexpr double kMoreMatches = 1.1;
    return static_cast<double>(num_explained) > kMoreMatches * static_cast<double>(num_in_common);
  }

  void judge() {
    std::vector<const ChangeFit*> fits;
    for (const RigChange& change : check_.changes) fits.push_back(&change);
    const bool is_wrong = explain(check_, fits, true);
    double far_px = is_position_open_ ? std::numeric_limits<double>::infinity() : 0;
    double lens_px = 0;
    for (const RigChange& change : check_.changes) {
      if (change.kind == CameraChangeKind::kPosition) far_px = std::max(far_px, change.blind_px);
      if (change.kind == CameraChangeKind::kRotation || change.kind == CameraChangeKind::kFocalLength ||
          change.kind == CameraChangeKind::kDistortion || change.kind == CameraChangeKind::kFirstRadial)
        lens_px = std::max(lens_px, change.blind_px);
    }
    check_.blind_px = std::max(far_px, lens_px);
    if (doInstantsDiffer()) {
      check_.gap = FootageGap::kInstants;
      check_.explanation.reset();
      check_.alternatives.clear();
    } else if (is_wrong) {
      check_.verdict = FootageVerdict::kInconsistent;
    } else if (check_.gap == FootageGap::kWeak || lens_px > check_.blindLimitPx()) {
      check_.gap = FootageGap::kWeak;
    } else if (far_px > check_.blindLimitPx()) {
      check_.gap = FootageGap::kNoParallax;
    } else if (has_open_) {
      check_.gap = FootageGap::kUnsolved;
    } else if (check_.num_instants < kFewestInstants) {
      check_.gap = FootageGap::kFewFrames;
    } else {
      check_.verdict = FootageVerdict::kConsistent;
    }
  }

  ImageSize second_size_;
  PosedPair stated_;
  PosedPair best_ = stated_;
  FootageCheckOptions options_;
  double threshold_px_ = 2;
  double noise_ = 1;
  std::vector<PairFreedom> freedoms_;
  std::vector<Eigen::VectorXd> starts_;
  std::vector<TimedMatch> matches_;
  std::vector<TimedMatch> used_;
  bool has_open_ = false;
  bool is_position_open_ = false;
  RigPairCheck check_;
};

// True if consistent pairs connect all cameras.
bool areConnected(std::size_t num_cameras, const std::vector<RigPairCheck>& pairs) {
  std::vector<std::size_t> group(num_cameras);
  for (std::size_t i = 0; i < num_cameras; ++i) group[i] = i;
  for (const RigPairCheck& pair : pairs) {
    if (pair.verdict != FootageVerdict::kConsistent) continue;
    const std::size_t from = group[pair.second];
    std::replace(group.begin(), group.end(), from, std::size_t{group[pair.first]});
  }
  return std::all_of(group.begin(), group.end(), [&](std::size_t g) { return g == group.front(); });
}

constexpr double kDegrees = 180 / std::numbers::pi;

std::string turnWords(const RigChange& change, std::string_view turned, std::string_view against) {
  const Eigen::Vector3d w(change.amounts[0], change.amounts[1], change.amounts[2]);
  Eigen::Index axis = 0;
  const double most = w.cwiseAbs().maxCoeff(&axis);
  constexpr double kDominates = 0.9;
  const bool has_axis = most > kDominates * w.norm();
  const int digits = digitsFor(kDegrees * change.angle_std, 2);
  const std::string angle = has_axis ? fmt::format("{:+.{}f}", kDegrees * w[axis], digits)
                                     : fmt::format("{:.{}f}", kDegrees * w.norm(), digits);
  const std::string about = has_axis ? fmt::format(" about its {} axis", "xyz"[axis]) : "";
  return fmt::format("{} turned by {} deg +- {:.{}f} deg{} against {}", turned, angle,
                     kDegrees * change.angle_std, digits, about, against);
}

}  // namespace

std::vector<PixelMatch> matchImages(const GrayImage& first, const GrayImage& second, std::size_t num_points) {
  const std::unique_ptr<FrontEnd> tracker = makeFrontEnd(FrontEndKind::kKeyPoints, num_points);
  const std::vector<TrackPixel> a = tracker->follow(first);
  const std::vector<TrackPixel> b = tracker->follow(second);
  std::vector<PixelMatch> matches;
  // The first patch defines the point; the second one is aligned with it and contains the errors of both.
  for (const auto& [i, j] : commonTracks(a, b)) matches.push_back({a[i].pixel, b[j].pixel, b[j].sigma_px});
  return matches;
}

RigCheck checkRigOnFootage(const AnyRig& rig, std::span<const RigPairMatches> matches,
                           const FootageCheckOptions& options) {
  RigCheck check;
  for (const MountedCamera& camera : rig.cameras()) camera.camera.requireUncorrected();
  for (const RigPairMatches& pair : matches) {
    const MountedCamera& first = rig.camera(pair.first);
    const MountedCamera& second = rig.camera(pair.second);
    RigPairCheck result;
    const SE3 second_from_first = second.camera_from_rig * first.camera_from_rig.inverse();
    constexpr double kLeastBaseline = 1e-6;  // m
    if (second_from_first.translation.norm() > kLeastBaseline) {
      result = PairTest(first, second, options).run(pair.instants);
    } else {
      result.gap = FootageGap::kWeak;  // without a baseline there are no epipolar curves
    }
    result.first = pair.first;
    result.second = pair.second;
    check.pairs.push_back(std::move(result));
  }
  if (std::ranges::find(check.pairs, FootageVerdict::kInconsistent, &RigPairCheck::verdict) !=
      check.pairs.end()) {
    check.verdict = FootageVerdict::kInconsistent;
  } else if (areConnected(rig.size(), check.pairs)) {
    check.verdict = FootageVerdict::kConsistent;
  }
  return check;
}

std::string describe(const RigChange& change, std::string_view first, std::string_view second) {
  const bool is_first = change.side == PairSide::kFirst;
  const std::string_view one = is_first ? first : second;
  const std::string_view other = is_first ? second : first;
  const std::vector<double>& by = change.amounts;
  switch (change.kind) {
    case CameraChangeKind::kRotation:
      return turnWords(change, one, other);
    case CameraChangeKind::kPosition: {
      const double std = kDegrees * change.angle_std;
      return fmt::format("the direction from {} to {} turned by {:.{}f} deg +- {:.{}f} deg", first, second,
                         kDegrees * std::hypot(by[0], by[1]), digitsFor(std, 2), std, digitsFor(std, 2));
    }
    case CameraChangeKind::kPose:
      return fmt::format("{}, and the direction between them by {:.2f} deg", turnWords(change, one, other),
                         kDegrees * std::hypot(by[3], by[4]));
    case CameraChangeKind::kSeveral:
      return fmt::format("pose and lenses of {} and {} at once", first, second);
    default:
      break;
  }
  const std::string of = change.side == PairSide::kBoth ? fmt::format(" of {} and {}", first, second)
                                                        : fmt::format(" of {}", one);
  return describe(change, is_first ? change.pair.first : change.pair.second, of);
}

}  // namespace alidade
