// SPDX-License-Identifier: MIT
#pragma once

#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace alidade::detail {

/// Splits one CSV record (RFC 4180: fields may be quoted, a doubled quote stands for one). Nothing if a quote
/// is left open.
[[nodiscard]] std::optional<std::vector<std::string>> splitCsv(std::string_view line);

/// A field as it goes into a CSV record: quoted where it has to be.
[[nodiscard]] std::string csvField(const std::string& text);

}  // namespace alidade::detail
