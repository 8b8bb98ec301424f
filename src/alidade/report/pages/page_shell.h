// SPDX-License-Identifier: MIT
#pragma once

#include <string>
#include <vector>

#include <nlohmann/json_fwd.hpp>

#include "alidade/core/diagnosis.h"
#include "alidade/report/canvas/figure_canvas.h"

namespace alidade {

// What all report pages have in common: a verdict on top, figures in sections, the evidence inside.

struct PageSection {
  std::string id;
  std::string title;
  std::vector<Figure> figures = {};
  std::string more = {};  ///< HTML after the figures
};

/// A number that matters, for the top of the page.
struct PageNumber {
  std::string name;
  std::string value;
  std::string more;          ///< in small letters
  bool is_accuracy = false;  ///< says nothing of a rejected camera
};

/// Texts are plain unless they say that they are HTML.
struct PageContent {
  std::string kind = "Calibration";  ///< of the report
  std::string title;
  std::string subtitle = {};
  std::string subject = {};   ///< of the verdict: "camera"
  std::string headline = {};  ///< the verdict in words; empty: those of a calibration
  Verdict verdict = Verdict::kNo;
  std::string reservation = {};  ///< stands behind "usable with reservations"; may be empty
  std::string sentence = {};     ///< what can be expected; behind the reason of a rejection
  std::vector<Diagnosis> findings = {};
  std::vector<std::string> names = {};  ///< of images and cameras, with which findings may begin
  std::string next_text = {};           ///< the photograph to take next; empty: none
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
/// What was found, failures and warnings first and notes in a list that opens, as HTML.
/// @param names  see PageContent
[[nodiscard]] std::string findingsHtml(const std::vector<Diagnosis>& findings,
                                       const std::vector<std::string>& names,
                                       const std::string& next_text = "");
/// The first of the most severe findings, and how many more of them there are: "The errors are large (and 3
/// more failures)." Nothing if there are neither failures nor warnings.
[[nodiscard]] std::string mainFindingText(const std::vector<Diagnosis>& findings,
                                          const std::vector<std::string>& names);
/// Figures in two columns, and HTML after them.
[[nodiscard]] std::string figuresHtml(const std::vector<Figure>& figures, const std::string& more);
/// A list that opens, as HTML; nothing for an empty one.
[[nodiscard]] std::string listHtml(const std::string& title, const std::vector<std::string>& lines);

/// The whole page, with the evidence in it: positions and errors of corners with four decimals.
[[nodiscard]] std::string pageText(const PageContent& page, const nlohmann::json& evidence);
[[nodiscard]] std::vector<FigureFile> figureFiles(const std::vector<PageSection>& sections);

}  // namespace alidade
