// SPDX-License-Identifier: MIT
#pragma once

#include <string>
#include <vector>

#include <nlohmann/json_fwd.hpp>

#include "alidade/report/data/rig_data.h"
#include "alidade/report/pages/page_shell.h"

namespace alidade {

/// The report of a rig. @throws Error (kInput) like readRig()
[[nodiscard]] std::string rigPage(const nlohmann::json& evidence, const std::string& file);
/// Its figures as files. @throws Error (kInput) like readRig()
[[nodiscard]] std::vector<FigureFile> rigFigures(const nlohmann::json& evidence, const std::string& file);

}  // namespace alidade
