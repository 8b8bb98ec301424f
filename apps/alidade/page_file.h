// SPDX-License-Identifier: MIT
#pragma once

#include <string>
#include <utility>
#include <vector>

#include "alidade/report/data/report_data.h"
#include "flags.h"

// Report pages as outputs of commands, and what they state of their origin.

namespace alidade {

/// A flag for a page. Pages are not written as PDF.
/// @param content  of the page: "what was found, with figures"
void addReportFlag(Flags& flags, std::string& path, const std::string& content,
                   const char* names = "--report");
/// The flag --date.
void addDateFlag(Flags& flags, std::string& date);
/// The text that a value of --date means: "today" is this day, as 2026-11-30.
[[nodiscard]] std::string dateText(const std::string& date);

/// The origin of results of this program, of this day only if --date says so.
/// @param more  flags with further inputs; those without a value are left out
[[nodiscard]] RunOrigin originOf(
    std::vector<std::string> inputs, const std::string& date,
    const std::vector<std::pair<std::string, std::vector<std::string>>>& more = {});

}  // namespace alidade
