// SPDX-License-Identifier: MIT
#pragma once

#include <string>

namespace alidade {

/// The tables of docs/formats.md, worked out by writing cameras and reading them back: which models each
/// format holds, and which of a format's models get to each other format and back. Fails the test that calls
/// it where a camera comes back as another one.
[[nodiscard]] std::string formatTables();

}  // namespace alidade
