// SPDX-License-Identifier: MIT
#pragma once

#include <string>
#include <vector>

#include <nlohmann/json_fwd.hpp>

#include "alidade/core/diagnosis.h"
#include "alidade/report/canvas/figure_canvas.h"

namespace alidade {

// Common parts of all report pages: a verdict on top, figures in sections, the evidence inside.

struct PageSection {
  std::string id;
  std::string title;
  std::vector<Figure> figures = {};
  std::string more = {};  ///< HTML after the figures
};

/// A key number for the top of the page.
struct PageNumber {
  std::string name;
  std::string value;
  std::string more;          ///< in small print
  bool is_accuracy = false;  ///< meaningless for a rejected camera
};

/// Texts are plain unless marked as HTML.
struct PageContent {
  std::string kind = "Calibration";  ///< of the report
  std::string title;
  std::string subtitle = {};
  std::string subject = {};   ///< of the verdict: "camera"
  std::string headline = {};  ///< the verdict in words; empty: the standard text for calibrations
  Verdict verdict = Verdict::kNo;
  std::string reservation = {};  ///< follows "usable with reservations"; may be empty
  std::string sentence = {};     ///< expected performance, after the reason if rejected
  std::vector<Diagnosis> findings = {};
  std::vector<std::string> names = {};  ///< of images and cameras; findings may begin with one
  std::string next_text = {};           ///< the photograph to take next; empty if none
  std::vector<PageNumber> numbers = {};
  std::vector<PageSection> sections = {};
  std::string details = {};  ///< HTML
  std::string dialog = {};   ///< HTML
  std::string created_by = {};
};

/// A file with a figure.
struct FigureFile {
  std::string name;  ///< "accuracy.svg"
  std::string svg;   ///< with its style
};

/// An error, with two digits and its unit, as in the summary of a calibration.
[[nodiscard]] std::string errorText(double px);
/// An RMS, with three digits and its unit.
[[nodiscard]] std::string rmsText(double px);
/// The findings as HTML: failures and warnings first, then notes in a list that opens.
/// @param names  see PageContent
[[nodiscard]] std::string findingsHtml(const std::vector<Diagnosis>& findings,
                                       const std::vector<std::string>& names,
                                       const std::string& next_text = "");
/// The first of the most severe findings, and the number of others: "The errors are large (and 3 more
/// failures)." Empty if there are neither failures nor warnings.
[[nodiscard]] std::string mainFindingText(const std::vector<Diagnosis>& findings,
                                          const std::vector<std::string>& names);
/// Figures in two columns, followed by HTML.
[[nodiscard]] std::string figuresHtml(const std::vector<Figure>& figures, const std::string& more);
/// A list that opens, as HTML; empty for an empty list.
[[nodiscard]] std::string listHtml(const std::string& title, const std::vector<std::string>& lines);

/// The whole page, including the evidence: positions and errors of corners with four decimals.
[[nodiscard]] std::string pageText(const PageContent& page, const nlohmann::json& evidence);
[[nodiscard]] std::vector<FigureFile> figureFiles(const std::vector<PageSection>& sections);

}  // namespace alidade
