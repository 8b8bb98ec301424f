// SPDX-License-Identifier: MIT
#pragma once

#include <cstddef>
#include <vector>

#include "alidade/camera/any_camera.h"
#include "alidade/core/diagnosis.h"
#include "alidade/files/text/yaml_node.h"

// Parts of Alidade's camera files that scene and hand-eye files share. They are read strictly: unknown,
// missing, duplicate and misspelt keys, wrong types, numbers that are not finite and unknown models are
// errors that name line, key, found and expected.
namespace alidade::detail {

/// Reads {width: ..., height: ...}, pixels.
[[nodiscard]] ImageSize readImageSize(const YamlNode& node);

/// Reads the keys model and parameters of a map (other keys are the caller's to check).
[[nodiscard]] AnyCamera readCamera(const YamlNode& node);

/// Checks that a format's version is 1.
void checkVersion(const YamlNode& version);
/// A whole number from 0.
[[nodiscard]] int readCount(const YamlNode& node);
[[nodiscard]] Verdict readVerdict(const YamlNode& node);
/// The lower triangle of a symmetric matrix, one row per item.
[[nodiscard]] std::vector<double> readTriangle(const YamlNode& node, std::size_t num_rows);

}  // namespace alidade::detail
