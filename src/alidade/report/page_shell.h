// SPDX-License-Identifier: MIT
#pragma once

#include <string>
#include <vector>

#include <nlohmann/json_fwd.hpp>

#include "alidade/core/diagnosis.h"
#include "alidade/report/figure_canvas.h"

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

/// A column of a table.
struct PageColumn {
  std::string name;
  bool has_words = false;  ///< instead of numbers
};

struct PageRow {
  std::vector<std::string> cells;  ///< one for each column
  std::string kind = {};           ///< class of the row; may be empty
};

/// Texts are plain unless they say that they are HTML.
struct PageContent {
  std::string title;
  std::string subtitle = {};
  std::string subject;  ///< of the verdict: "camera"
  Verdict verdict = Verdict::kNo;
  std::string reservation = {};  ///< stands behind "usable with reservations"; may be empty
  std::string sentence;          ///< what can be expected
  std::vector<Diagnosis> findings;
  std::vector<std::string> names = {};  ///< of images and cameras, with which findings may begin
  std::string next_text = {};           ///< the photograph to take next; empty: none
  std::vector<PageNumber> numbers;
  std::vector<PageSection> sections;
  std::string details = {};  ///< HTML
  std::string dialog = {};   ///< HTML
  std::string created_by;
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
/// A figure that is a table; narrow screens show it row by row. Texts are plain.
[[nodiscard]] std::string tableFigure(const std::string& id, const std::string& title,
                                      const std::vector<PageColumn>& columns,
                                      const std::vector<PageRow>& rows, const std::string& reading);
/// A list that opens, as HTML; nothing for an empty one.
[[nodiscard]] std::string listHtml(const std::string& title, const std::vector<std::string>& lines);

/// The whole page, with the evidence in it: positions and errors of corners with four decimals.
[[nodiscard]] std::string pageText(const PageContent& page, const nlohmann::json& evidence);
[[nodiscard]] std::vector<FigureFile> figureFiles(const std::vector<PageSection>& sections);

}  // namespace alidade
