// SPDX-License-Identifier: MIT
#pragma once

#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "alidade/camera/any_camera.h"
#include "alidade/camera/self_check.h"
#include "alidade/core/verdict.h"

namespace alidade {

enum class CheckStatus { kPass, kWarn, kFail };

/// "PASS", "WARN" or "FAIL".
[[nodiscard]] std::string_view checkStatusName(CheckStatus status);

/// One question asked of a camera, with its answer.
struct Check {
  std::string id;  ///< stable, for scripts
  CheckStatus status = CheckStatus::kPass;
  std::string value;          ///< what was found
  std::string limit;          ///< what is accepted
  std::string message;        ///< one sentence
  bool is_undecided = false;  ///< a warning, as what there is to judge by cannot tell
};

/// What a file claims about one standard deviation of pixels, px: see UncertaintyGrid.
struct ProjectionStdClaim {
  double center_px = 0;  ///< NaN: no ray
  double worst_px = 0;
  Eigen::Vector2d worst_pixel{0, 0};
  int columns = 0;
  int rows = 0;
  std::span<const double> std_px;  ///< row by row; NaN: no ray
};

/// A camera and what its file claims about it.
struct CameraClaims {
  const AnyCamera* camera = nullptr;
  ImageSize image_size;
  std::optional<DomainClaim> domain;
  std::span<const SelfCheckPoint> self_check;
  std::span<const double> parameter_std;           ///< empty = not stated
  std::span<const double> covariance;              ///< lower triangle row by row; empty = not stated
  std::span<const double> stated_covariance = {};  ///< the one to go by; empty = the one above
  std::optional<ProjectionStdClaim> projection_std = std::nullopt;  ///< nothing: not stated
  /// What the calibration said of itself; nothing = the file does not come from a calibration.
  std::optional<Verdict> verdict = std::nullopt;
  /// Does the file's format have room for a domain, self-check points, a covariance and a verdict? If not,
  /// they are not missed.
  bool can_say_more = true;
  /// The file does not state `image_size`: what rests on it is a warning at most.
  bool is_size_guessed = false;
};

/// Focal lengths, aspect, principal point, one-to-one over the image, the stated domain, self-check points,
/// covariance, the uncertainty of pixels, and what the calibration said of itself.
[[nodiscard]] std::vector<Check> checkCamera(const CameraClaims& claims);

}  // namespace alidade
