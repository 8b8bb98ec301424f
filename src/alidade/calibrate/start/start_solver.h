// SPDX-License-Identifier: MIT
#pragma once

#include <span>
#include <string_view>
#include <vector>

#include "alidade/adjust/pose_search.h"
#include "alidade/core/cancel.h"

namespace alidade {

/// A camera that may become the start.
struct StartCandidate : PosedCamera {
  double cost = 0;  ///< with what is charged for views without a pose
};

/// Views without a pose for fewer than this: they say nothing.
inline constexpr std::size_t kMinPosedViews = 3;

/// Relative change of the cost at which to stop on the way to another solve.
inline constexpr double kCoarseTolerance = 1e-3;

/// Solves candidates on some of the views. May be used by several threads at once.
class StartSolver {
 public:
  /// @param views  the corners of each view
  StartSolver(const Checkerboard& board, ImageSize size, std::vector<std::vector<Observation>> views,
              const CancelFlag* cancel);

  [[nodiscard]] std::span<const std::vector<Observation>> views() const { return views_; }
  [[nodiscard]] ImageSize size() const { return size_; }
  [[nodiscard]] const CancelFlag* cancel() const { return cancel_; }

  /// Poses by the corners' rays and the cost of these; infinite where too few views can be posed.
  void findPoses(std::string_view model_id, StartCandidate& candidate) const;

  /// Focal lengths, the first coefficient of the distortion and poses alone. With more, views with a wrong
  /// tilt would bend the principal point and the higher coefficients to themselves, and stay. False if the
  /// candidate is none.
  bool solveLeanly(std::string_view model_id, StartCandidate& candidate) const;

  /// Solves until no pose by rays is better than the one that a view came to. False if the candidate is none.
  bool solve(std::string_view model_id, StartCandidate& candidate) const;

  /// Once, with parameters held or under a prior. False if the candidate is none.
  bool solve(std::string_view model_id, StartCandidate& candidate, double tolerance, std::vector<int> held,
             const LensPrior& prior = {}) const;

  /// The prior of natural sizes (LensScale) for a model in the likeness of a candidate of another one, and
  /// with it the noise that the candidate leaves.
  [[nodiscard]] LensPrior naturalPrior(std::string_view model_id, const AnyCamera& like,
                                       const StartCandidate& candidate) const;

  /// Same cost and same projections of all corners.
  [[nodiscard]] bool isSameOptimum(std::string_view model_id, const StartCandidate& a,
                                   const StartCandidate& b) const;

 private:
  [[nodiscard]] double missingViewCost(std::size_t num_corners) const;

  Checkerboard board_;
  ImageSize size_;
  std::vector<std::vector<Observation>> views_;
  HuberLoss loss_;
  const CancelFlag* cancel_;
};

}  // namespace alidade
