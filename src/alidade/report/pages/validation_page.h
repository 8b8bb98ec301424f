// SPDX-License-Identifier: MIT
#pragma once

#include <string>

#include <nlohmann/json_fwd.hpp>

#include "alidade/report/data/validation_data.h"
#include "alidade/report/figures/page_pictures.h"

namespace alidade {

/// The report of a validation: one self-contained HTML file. For one file it shows the verdict, the next
/// step, and figures of each camera; for several a table of verdicts, with each file's figures folded. The
/// document is in <script type="application/json" id="evidence">, its corners rounded to 0.0001 px. The same
/// result and images give identical bytes.
/// @param document  output of validate --json, plus the corners of its views and the other camera
/// @param pictures  of the views if one camera was tested; may be empty
/// @param num_jobs  threads for the images; 0: one per processor
[[nodiscard]] std::string validationPage(const ValidationResult& result, const nlohmann::json& document,
                                         const PictureSource& pictures, int num_jobs);

}  // namespace alidade
