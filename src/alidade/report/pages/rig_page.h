// SPDX-License-Identifier: MIT
#pragma once

#include "alidade/report/data/rig_data.h"
#include "alidade/report/pages/page_shell.h"

namespace alidade {

/// The report of a rig.
[[nodiscard]] PageContent rigPage(const ReportedRig& rig);

}  // namespace alidade
