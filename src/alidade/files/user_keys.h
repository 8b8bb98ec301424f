// SPDX-License-Identifier: MIT
#pragma once

#include <string>
#include <string_view>

namespace alidade::detail {

/// Is this key of a map the user's own, of which this program takes no notice?
[[nodiscard]] inline bool isUserKey(std::string_view key) {
  return key.starts_with("x_");
}

/// The user's own keys of a document's root, with their values, as lines of YAML; empty if there are none.
/// Strings keep their quotes and shared values their anchors; comments are lost.
/// @param text  a document that YAML reads and whose root is a map
[[nodiscard]] std::string userKeys(const std::string& text);

}  // namespace alidade::detail
