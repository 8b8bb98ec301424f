// SPDX-License-Identifier: MIT
#pragma once

#include <string>

namespace alidade::detail {

/// Texts of camera files get into YAML, JSON and HTML of ours, which others could not read with bytes that
/// are no UTF-8. `file` is only a name for messages.
/// @throws Error (kInput) with the line and the first such bytes, as \xNN
void checkUtf8(const std::string& text, const std::string& file);

/// The text with each byte that is no UTF-8 as \xNN: names of images may be any bytes, our files may not.
[[nodiscard]] std::string withBytesShown(const std::string& text);

}  // namespace alidade::detail
