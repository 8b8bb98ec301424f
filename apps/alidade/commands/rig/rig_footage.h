// SPDX-License-Identifier: MIT
#pragma once

#include <string>
#include <vector>

#include "alidade/core/cancel.h"
#include "alidade/footage/check/rig_check.h"
#include "alidade/record/rig_record.h"
#include "commands/rig/rig_inputs.h"

// `alidade rig validate --footage`: tests a rig on ordinary synchronous images.

namespace alidade {

/// The images of a rig, matched in pairs.
struct RigFootage {
  std::size_t num_instants = 0;  ///< with images of two or more cameras
  std::vector<RigPairMatches> pairs;
};

/// Finds which images were taken together and matches key points between them. If there are many instants, 40
/// are selected evenly. Prints, unless `common.quiet`, which images have no partner.
/// @param inputs  in the order of the rig's cameras: folders, images or patterns
/// @throws Error (kUsage) for a board or corners files; Error (kInput) for a rig of one camera, for images
/// that cannot be read or whose size differs from their camera's, and as matchFrames(); Cancelled
[[nodiscard]] RigFootage matchRigFootage(const RigRecord& rig, const RigInputs& inputs,
                                         const CommonOptions& common, const CancelFlag* cancel);

/// The result for people.
[[nodiscard]] std::string rigFootageText(const RigCheck& check, const AnyRig& rig);
/// All numbers, as JSON.
[[nodiscard]] std::string rigFootageJson(const RigCheck& check, const RigFootage& footage, const AnyRig& rig);
/// The finding on the first inconsistent pair, in one sentence.
[[nodiscard]] std::string rigContradiction(const RigCheck& check, const AnyRig& rig);

}  // namespace alidade
