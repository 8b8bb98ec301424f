// SPDX-License-Identifier: MIT
#pragma once

#include <algorithm>
#include <iterator>
#include <string>
#include <vector>

#include <nlohmann/json_fwd.hpp>

#include "alidade/core/diagnosis.h"
#include "alidade/report/canvas/figure_canvas.h"
#include "alidade/report/data/report_data.h"

namespace alidade {

// Common parts of all report pages: a verdict on top, figures in sections, the evidence inside.

struct PageSection {
  std::string id;
  std::string title;
  std::vector<Figure> figures = {};
  std::string more = {};  ///< HTML after the figures
};

/// Appends items.
template <class Item>
void append(std::vector<Item>& to, std::vector<Item> more) {
  std::ranges::move(more, std::back_inserter(to));
}

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
  RunOrigin origin = {};
  std::string headline = {};  ///< the verdict in words
  Verdict verdict = Verdict::kNo;
  std::string sentence = {};             ///< expected performance, after the reason if rejected
  std::vector<Diagnosis> findings = {};  ///< see asSentences()
  std::string next_text = {};            ///< the photograph to take next; empty if none
  std::vector<PageNumber> numbers = {};
  std::vector<PageSection> sections = {};
  std::string details = {};  ///< HTML
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
/// "good", "fair" or "bad": the class of elements that show a verdict.
[[nodiscard]] const char* verdictClass(Verdict verdict);
/// The verdict of a calibration in words. @param subject  of the verdict: "camera"
[[nodiscard]] std::string verdictHeadline(Verdict verdict, const std::string& subject);
/// Findings with a capital first letter, unless they begin with one of these names of images and cameras.
[[nodiscard]] std::vector<Diagnosis> asSentences(std::vector<Diagnosis> findings,
                                                 const std::vector<std::string>& names);
/// The findings as HTML: failures and warnings first, then notes in a list that opens.
[[nodiscard]] std::string findingsHtml(const std::vector<Diagnosis>& findings,
                                       const std::string& next_text = "");
/// The first of the most severe findings, and the number of others: "The errors are large (and 3 more
/// failures)." Empty if there are neither failures nor warnings.
[[nodiscard]] std::string mainFindingText(const std::vector<Diagnosis>& findings);
/// Figures in two columns, followed by HTML.
[[nodiscard]] std::string figuresHtml(const std::vector<Figure>& figures, const std::string& more);
/// A list that opens, as HTML; empty for an empty list.
[[nodiscard]] std::string listHtml(const std::string& title, const std::vector<std::string>& lines);

/// Buttons with pictures that open the views, the largest error first, as HTML.
/// @param pictures  one per view, see viewPictures(); for an empty one its corners are drawn
/// @param prefix    of its id, see withPrefix()
[[nodiscard]] std::string viewSheet(const ReportData& data, const std::vector<std::string>& pictures,
                                    const std::string& prefix = "");

/// The share of the image that is accurate, for the top of a page. @pre there is an accuracy
[[nodiscard]] PageNumber withinTolerance(const ReportData& data);

/// The whole page, including the evidence: positions and errors of corners with four decimals.
[[nodiscard]] std::string pageText(const PageContent& page, const nlohmann::json& evidence);
[[nodiscard]] std::vector<FigureFile> figureFiles(const std::vector<PageSection>& sections);

}  // namespace alidade
