// SPDX-License-Identifier: MIT
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include <Eigen/Core>

#include "alidade/camera/camera_change.h"
#include "alidade/core/cancel.h"

namespace alidade {

/// The answer of footage about a camera or a rig.
enum class FootageVerdict : std::uint8_t {
  kConsistent,
  kInconsistent,
  kCannotTell,
};
/// "consistent", "inconsistent", "cannot_tell".
[[nodiscard]] std::string_view verdictId(FootageVerdict verdict);

/// Reason why footage cannot decide.
enum class FootageGap : std::uint8_t {
  kNone,
  kFewPoints,    ///< too few points could be tracked
  kNoMotion,     ///< all frames are alike
  kNoParallax,   ///< the camera turned in place, or everything is far away
  kMovingScene,  ///< too few points agree with one motion of the camera
  kFewFrames,    ///< fewer than five frames could be reconstructed together
  kUnsolved,     ///< a change that may explain the footage could not be solved for
  kWeak,         ///< the motion does not determine the camera's parameters
  kShutter,      ///< a change explains the footage only with a readout that no camera has
  kInstants,     ///< a pose of its own for each pair of images explains more than any change of the rig
};
/// "too_few_points", "no_motion", "no_parallax", "moving_scene", "too_few_frames",
/// "unsolved", "undetermined", "impossible_readout", "not_one_instant"; empty for kNone.
[[nodiscard]] std::string_view gapId(FootageGap gap);

struct FootageCheckOptions {
  double tolerance_px = 1;
  int num_jobs = 0;
  const CancelFlag* cancel = nullptr;
};

/// The change of one kind that fits footage best.
struct ChangeFit {
  CameraChangeKind kind = CameraChangeKind::kSeveral;
  std::vector<double> amounts = {};  ///< see CameraChangeKind
  std::vector<double> std = {};      ///< of each
  double cost_drop = 0;              ///< share of the sum of squared errors that the change removes
  double gain = 0;                   ///< part of the drop that counts in the choice between changes
  double prior_cost = 0;             ///< half the squared amounts in units of their usual size
  double score = 0;                  ///< half the drop in units of its variance, less kPenalty per unknown
  double needed_score = 0;           ///< with a smaller score, beyond chance, it is undecided
  /// 95th percentile of the displacement by the change, where points were seen; and its value after reducing
  /// the change by 1.645 standard deviations.
  double effect_px = 0;
  double sure_px = 0;
  /// The same percentile for 1.96 standard deviations: the size of a change of this kind that goes unnoticed.
  double blind_px = 0;

  /// Sets amounts, their standard deviations and the score.
  /// @param drop  of the cost
  /// @param unit  its variance over that of independent pixels
  void setFit(const Eigen::VectorXd& by, const Eigen::MatrixXd& covariance, double drop, double unit);
  /// @param std_px  95th percentile of the standard deviation of the displacement
  void setEffect(double displacement_px, double std_px);
};

/// The result of testing all changes.
struct FootageOutcome {
  FootageVerdict verdict = FootageVerdict::kCannotTell;
  FootageGap gap = FootageGap::kNone;
  std::optional<std::size_t> explanation = {};  ///< the change that explains the footage best, if any
  std::vector<std::size_t> alternatives = {};   ///< of rigs: other changes that explain nine tenths as much
  double tolerance_px = 0;
  double blind_px = 0;  ///< the largest relevant change that would go unnoticed
  double noise_px = 0;  ///< of a coordinate
  double parallax_px = 0;

  [[nodiscard]] double failurePx() const { return 5 * tolerance_px; }      ///< as for findings of boards
  [[nodiscard]] double blindLimitPx() const { return 10 * tolerance_px; }  ///< beyond it, no verdict
};

/// Penalty on a score per unknown: 1 in 1000, and a choice of six kinds.
inline constexpr double kPenalty = 6;

/// Sets the explanation: the significant change of one kind that explains most, or all unknowns together if
/// they explain clearly more, find a relevant error and are determined; if they are not, or a change
/// has less than its needed score, and nothing else shows the file to be wrong, the gap is kWeak.
/// For rigs, changes that show the file to be wrong take precedence, and the alternatives are set.
/// @returns true if the explanation shows the file to be wrong
bool explain(FootageOutcome& outcome, const std::vector<const ChangeFit*>& changes, bool is_rig);

/// A change of a camera's parameters: "focal length of left +3.1 % +- 0.2 %".
/// @param camera  names the parameters
/// @param of  " of left", with more digits if they are certain; may be empty
[[nodiscard]] std::string describe(const ChangeFit& change, const AnyCamera& camera, std::string_view of);

/// Digits after the point that a standard deviation requires; at least `usual`.
[[nodiscard]] int digitsFor(double std, int usual);

}  // namespace alidade
