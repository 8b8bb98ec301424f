// SPDX-License-Identifier: MIT
#pragma once

#include <cstddef>
#include <optional>
#include <string>
#include <string_view>

namespace alidade {

/// What parameter `i` (in storage order) of a model has to be, in words for a message: finite, positive for
/// fx and fy, in its range for the lens. Nothing where `value` is.
/// @pre the model is of the list, and has such a parameter
[[nodiscard]] std::optional<std::string> parameterComplaint(std::string_view model_id, std::size_t i,
                                                            double value);

}  // namespace alidade
