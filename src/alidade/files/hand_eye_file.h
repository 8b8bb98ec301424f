// SPDX-License-Identifier: MIT
#pragma once

#include <span>
#include <string>
#include <string_view>

#include "alidade/record/hand_eye_record.h"

namespace alidade {

/// A format of hand-eye files.
struct HandEyeFormat {
  std::string_view id;  ///< "ros"
  std::string_view title;
  std::string (*write)(const HandEyeRecord& record);
};
/// All formats, Alidade's own one first, which is the only one that holds more than the transform.
[[nodiscard]] std::span<const HandEyeFormat> handEyeFormats();

/// Text of a hand-eye file. Numbers have the fewest digits that read back as the same ones.
/// @throws Error (kUsage) for an unknown format; (kInput) for a calibration without a solution
[[nodiscard]] std::string handEyeText(const HandEyeRecord& record, std::string_view format = "alidade");

/// Reads a hand-eye file of Alidade (docs/handeye.md). Quaternions are normalised, which may change their
/// last digit. Keys that begin with x_ are ignored.
/// @throws Error (kInput) naming line and key: unknown and missing keys, another version, and a transform
/// that moves the point of the self-check elsewhere than stated
[[nodiscard]] HandEyeRecord readHandEye(const std::string& path);

/// The same from text; messages use `name` as the file name.
[[nodiscard]] HandEyeRecord parseHandEye(const std::string& text, const std::string& name);

}  // namespace alidade
