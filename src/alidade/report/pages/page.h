// SPDX-License-Identifier: MIT
#pragma once

#include <optional>
#include <string>
#include <vector>

#include <nlohmann/json_fwd.hpp>

#include "alidade/report/data/report_data.h"
#include "alidade/report/figures/page_pictures.h"
#include "alidade/report/pages/page_shell.h"

namespace alidade {

/// Optional parts of a report besides the evidence.
struct PageOptions {
  std::vector<PictureSource> pictures = {};         ///< of each camera, for thumbnails; may be empty
  std::optional<RivalCamera> rival = std::nullopt;  ///< for comparison
  int num_jobs = 0;                                 ///< threads for the images; 0: one per processor
};

/// The report of a calibration: one self-contained HTML file with the verdict, the next step, figures, and
/// the evidence itself in <script type="application/json" id="evidence">, its corners rounded to 0.0001 px.
/// The same evidence and images give identical bytes.
/// @param evidence  the document of calibrate --evidence, or of rig calibrate --evidence
/// @param file      its name, for messages
/// @throws Error (kInput) for a document that is not the evidence of a calibration
[[nodiscard]] std::string reportPage(const nlohmann::json& evidence, const std::string& file,
                                     const PageOptions& options = {});

/// The figures of the page as separate files. @throws Error like reportPage()
[[nodiscard]] std::vector<FigureFile> reportFigures(const nlohmann::json& evidence, const std::string& file,
                                                    const PageOptions& options = {});

}  // namespace alidade
