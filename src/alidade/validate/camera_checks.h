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
  std::string value;    ///< what was found
  std::string limit;    ///< what is accepted
  std::string message;  ///< one sentence
};

/// A camera and what its file claims about it.
struct CameraClaims {
  const AnyCamera* camera = nullptr;
  ImageSize image_size;
  std::optional<DomainClaim> domain;
  std::span<const SelfCheckPoint> self_check;
  std::span<const double> parameter_std;           ///< empty = not stated
  std::span<const double> covariance;              ///< lower triangle row by row; empty = not stated
  std::span<const double> stated_covariance = {};  ///< the same
  /// What the calibration said of itself; nothing = the file does not come from a calibration.
  std::optional<Verdict> verdict = std::nullopt;
  /// Does the file's format have room for a domain, self-check points, a covariance and a verdict? If not,
  /// they are not missed.
  bool can_say_more = true;
};

/// Focal lengths, aspect, principal point, one-to-one over the image, the stated domain, self-check points,
/// covariance, and what the calibration said of itself.
[[nodiscard]] std::vector<Check> checkCamera(const CameraClaims& claims);

}  // namespace alidade
