// SPDX-License-Identifier: MIT
#pragma once

#include <string>

namespace alidade {

/// The table of docs/formats.md, worked out by writing cameras and reading them back: which models each
/// format holds. Fails the test that calls it where a camera comes back as another one.
[[nodiscard]] std::string formatTables();

/// Takes the models of each format to each format and back. Fails the test that calls it where a camera comes
/// back as another one. @returns how many get there
[[nodiscard]] int countConversions();

}  // namespace alidade
