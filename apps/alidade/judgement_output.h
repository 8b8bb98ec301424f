// SPDX-License-Identifier: MIT
#pragma once

#include <span>
#include <string>

#include <nlohmann/json_fwd.hpp>

#include "alidade/validate/file_judgement.h"

namespace alidade {

/// All checks of one camera, and what they come to.
[[nodiscard]] std::string judgementText(const FileJudgement& judgement);

/// A row for each camera, under it what did not pass, and at the end how many are valid.
[[nodiscard]] std::string judgementTable(std::span<const FileJudgement> judgements);

[[nodiscard]] nlohmann::json judgementJson(const FileJudgement& judgement);

}  // namespace alidade
