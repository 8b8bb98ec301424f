// SPDX-License-Identifier: MIT
#pragma once

#include <string>

#include <nlohmann/json_fwd.hpp>

#include "alidade/report/data/validation_data.h"
#include "alidade/report/figures/page_pictures.h"

namespace alidade {

/// The report of a validation: one HTML file that needs nothing else. Of one file it shows the verdict, what
/// to do, and figures of each camera; of several a table of verdicts, each file's figures folded. The
/// document is in <script type="application/json" id="evidence">, its corners rounded to 0.0001 px. The same
/// result and images give the same bytes.
/// @param document  what validate --json prints, with the corners of its views and the other camera
/// @param pictures  for pictures of the views where one camera was tested; may be empty
/// @param num_jobs  threads for the images; 0: one per processor
[[nodiscard]] std::string validationPage(const ValidationResult& result, const nlohmann::json& document,
                                         const PictureSource& pictures, int num_jobs);

}  // namespace alidade
