// SPDX-License-Identifier: MIT
#pragma once

#include <string>
#include <vector>

#include "alidade/report/figures/page_pictures.h"
#include "alidade/report/pages/page.h"
#include "board_views.h"
#include "pending_folder.h"

namespace alidade {

/// The images that boards were found in, by the names that the evidence has for them, in which bytes that are
/// not UTF-8 are replaced. An image that cannot be read has no picture.
/// @param passing  pictures made while these images were searched; outlives the source
[[nodiscard]] PictureSource picturesOf(const GivenViews& given, const PassingPictures& passing);

/// The same for images that are given again, by names of an evidence document.
/// @param evidence  the document's text
/// @param paths     of images and videos
[[nodiscard]] PictureSource picturesFrom(const std::string& evidence, const std::vector<std::string>& paths);

/// Writes the figures of an evidence document into a folder, as SVG files. Otherwise like writeReport().
void writeFigures(const PendingFolder& folder, const std::string& evidence, const std::string& evidence_file,
                  const PageOptions& options);

/// Writes the report page of an evidence document.
/// @param evidence       the document's text
/// @param evidence_file  its name for messages; may be empty
/// @throws Error (kInput) for a document that is not the evidence of a calibration, and when the page cannot
/// be written
void writeReport(const std::string& path, const std::string& evidence, const std::string& evidence_file,
                 const PageOptions& options);

/// Writes the report page of a validation. @param evidence  see validationEvidenceJson()
void writeValidationReport(const std::string& path, const std::string& evidence, const PageOptions& options);

}  // namespace alidade
