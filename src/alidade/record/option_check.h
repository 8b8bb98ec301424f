// SPDX-License-Identifier: MIT
#pragma once

namespace alidade::detail {

/// Checks an option of a simulation, which may come from a scene file.
/// @throws Error (kInput) naming the option when `value` is not in [low, high]; NaN never is.
void checkOption(const char* name, double value, double low, double high);

}  // namespace alidade::detail
