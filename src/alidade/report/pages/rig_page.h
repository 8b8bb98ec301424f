// SPDX-License-Identifier: MIT
#pragma once

#include <vector>

#include "alidade/report/data/rig_data.h"
#include "alidade/report/figures/page_pictures.h"
#include "alidade/report/pages/page_shell.h"

namespace alidade {

/// The report of a rig.
/// @param pictures  of the views of each camera; each may be empty
/// @param num_jobs  threads for the images; 0: one per processor
[[nodiscard]] PageContent rigPage(const ReportedRig& rig, const std::vector<PictureSource>& pictures,
                                  int num_jobs);

}  // namespace alidade
