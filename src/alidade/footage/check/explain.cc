// SPDX-License-Identifier: MIT
#include "alidade/footage/check/explain.h"

#include <algorithm>
#include <array>
#include <cmath>

#include <fmt/format.h>

#include "alidade/core/statistics.h"

namespace alidade {
namespace {

// Least score. It exceeds pure chance because tracks share errors that their scatter does not show.
constexpr double kEvidence = 10;
// Share of the squared errors. All parameters together also absorb errors common to the images: a third of
// the squared errors in photographs by a camera that was calibrated with a board.
constexpr double kAllTogether = 0.5;
constexpr double kMore = 1.25;   // times the squared errors removed by one kind, for all parameters
constexpr double kUnusual = 10;  // of the prior: 4.5 standard deviations
constexpr double kNearly = 0.9;  // of the largest gain
constexpr double kOneSided95 = 1.645;

// True for a relative rotation, whichever camera turned.
bool isMotion(const ChangeFit& change) {
  return change.kind == CameraChangeKind::kRotation || change.kind == CameraChangeKind::kPose;
}

}  // namespace

std::string_view verdictId(FootageVerdict verdict) {
  constexpr std::array<std::string_view, 3> kIds = {"consistent", "inconsistent", "cannot_tell"};
  return kIds.at(static_cast<std::size_t>(verdict));
}

std::string_view gapId(FootageGap gap) {
  constexpr std::array<std::string_view, 10> kIds = {
      "",         "too_few_points", "no_motion",          "no_parallax",    "moving_scene", "too_few_frames",
      "unsolved", "undetermined",   "impossible_readout", "not_one_instant"};
  return kIds.at(static_cast<std::size_t>(gap));
}

void ChangeFit::setFit(const Eigen::VectorXd& by, const Eigen::MatrixXd& covariance, double drop,
                       double unit) {
  for (Eigen::Index i = 0; i < by.size(); ++i) {
    amounts.push_back(by[i]);
    std.push_back(std::sqrt(covariance(i, i)));
  }
  score = drop / unit - kPenalty * static_cast<double>(by.size());
}

void ChangeFit::setEffect(double displacement_px, double std_px) {
  effect_px = displacement_px;
  sure_px = std::max(0.0, effect_px - kOneSided95 * std_px);
  blind_px = kNormal95 * std_px;
}

bool explain(FootageOutcome& outcome, const std::vector<const ChangeFit*>& changes, bool is_rig) {
  // The first change with this share of the largest gain is taken; all unknowns together need this multiple
  // of the effect that is a failure.
  const double as_much = is_rig ? 0.98 : 1;
  const double several = is_rig ? 2 : 1;
  const auto isSeveral = [&](std::size_t i) { return changes[i]->kind == CameraChangeKind::kSeveral; };
  const auto isWrong = [&](std::size_t i) {
    return changes[i]->effect_px > outcome.failurePx() && changes[i]->sure_px > 0.5 * outcome.failurePx();
  };
  std::vector<std::size_t> candidates;
  for (std::size_t i = 0; i < changes.size(); ++i) {
    const ChangeFit& change = *changes[i];
    if (change.score > kEvidence && change.score < change.needed_score) {
      if (isWrong(i)) outcome.gap = FootageGap::kWeak;
      continue;
    }
    if (!isSeveral(i) && change.score > kEvidence && change.blind_px <= outcome.blindLimitPx() &&
        change.prior_cost < kUnusual)
      candidates.push_back(i);
  }
  if (is_rig && std::ranges::any_of(candidates, isWrong))
    std::erase_if(candidates, [&](std::size_t i) { return !isWrong(i); });
  double best = 0;
  for (const std::size_t i : candidates) best = std::max(best, changes[i]->gain);
  const auto chosen =
      std::ranges::find_if(candidates, [&](std::size_t i) { return changes[i]->gain >= as_much * best; });
  bool is_wrong = false;
  double most = 0;
  if (chosen != candidates.end()) {
    outcome.explanation = *chosen;
    is_wrong = isWrong(*chosen);
    most = changes[*chosen]->cost_drop;
    for (const std::size_t i : candidates) {
      const bool is_same = isMotion(*changes[i]) && isMotion(*changes[*chosen]);
      if (is_rig && i != *chosen && changes[i]->gain >= kNearly * best && !is_same)
        outcome.alternatives.push_back(i);
    }
  }
  for (std::size_t i = 0; i < changes.size(); ++i) {
    const ChangeFit& change = *changes[i];
    if (!isSeveral(i) || !(change.score > kEvidence) || !isWrong(i) ||
        change.effect_px < several * outcome.failurePx() || change.cost_drop < kMore * most ||
        (!is_wrong && change.cost_drop < kAllTogether))
      continue;
    if (!(change.blind_px <= outcome.blindLimitPx())) {
      outcome.gap = FootageGap::kWeak;
      continue;
    }
    outcome.explanation = i;
    outcome.alternatives.clear();
    is_wrong = true;
  }
  if (is_wrong) outcome.gap = FootageGap::kNone;  // another change may still be undecided
  return is_wrong;
}

int digitsFor(double std, int usual) {
  if (!(std > 0) || !std::isfinite(std)) return usual;
  constexpr int kMost = 4;
  return std::clamp(static_cast<int>(std::floor(-std::log10(std))) + 1, usual, kMost);
}

std::string describe(const ChangeFit& change, const AnyCamera& camera, std::string_view of) {
  const auto digitsOf = [&](double std, int usual) { return of.empty() ? usual : digitsFor(std, usual); };
  const auto signedAmount = [&](std::size_t i, int usual) {
    const int digits = digitsOf(change.std[i], usual);
    return fmt::format("{:+.{}f} +- {:.{}f}", change.amounts[i], digits, change.std[i], digits);
  };
  const auto percent = [&](std::string_view name) {
    const double std = 100 * change.std[0];
    const int digits = digitsOf(std, 1);
    return fmt::format("{}{} {:+.{}f} % +- {:.{}f} %", name, of, 100 * change.amounts[0], digits, std,
                       digits);
  };
  switch (change.kind) {
    case CameraChangeKind::kFocalLength:
      return percent("focal length");
    case CameraChangeKind::kAspect:
      return percent("fx alone");
    case CameraChangeKind::kPrincipalPoint:
      return fmt::format("principal point{} {} px in x and {} px in y", of, signedAmount(0, 1),
                         signedAmount(1, 1));
    case CameraChangeKind::kDistortion: {
      const int digits = digitsOf(change.std[0], 2);
      return fmt::format("distortion{} times {:.{}f} +- {:.{}f}", of, 1 + change.amounts[0], digits,
                         change.std[0], digits);
    }
    case CameraChangeKind::kFirstRadial:
      return fmt::format("{}{} {}", camera.parameterNames()[4], of, signedAmount(0, 3));
    default:
      return "several parameters at once";
  }
}

}  // namespace alidade
