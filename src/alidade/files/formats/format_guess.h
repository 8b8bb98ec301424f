// SPDX-License-Identifier: MIT
#pragma once

#include <optional>
#include <string>

#include "alidade/files/formats/camera_format.h"

namespace alidade::detail {

/// The format that a text of no known format comes nearest to.
struct FormatGuess {
  const CameraFormat* format = nullptr;
  int line = 0;         ///< of `key`, from 1
  std::string key;      ///< the key in the text that names a camera: "camera_matix"
  std::string meant;    ///< the format's key that it is nearest to: "camera_matrix"
  std::string missing;  ///< the first key that the format needs and the text does not have; may be empty
};

/// Looks for keys of camera formats, or keys nearly spelled like them, in YAML, JSON or XML, damaged or not.
/// @returns std::nullopt if the text does not name a camera
[[nodiscard]] std::optional<FormatGuess> guessFormat(const std::string& text);

}  // namespace alidade::detail
