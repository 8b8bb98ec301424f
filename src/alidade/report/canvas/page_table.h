// SPDX-License-Identifier: MIT
#pragma once

#include <string>
#include <vector>

namespace alidade {

// Tables of the report pages. Texts are plain.

/// Text as HTML: ids with an underscore and flags are set as code, and paths may break after a slash.
[[nodiscard]] std::string proseHtml(const std::string& text);

struct PageColumn {
  std::string name;
  std::string kind = {};   ///< class of its cells: "words" for text instead of numbers
  bool has_links = false;  ///< cells link to PageRow::link
};

struct PageRow {
  std::vector<std::string> cells;  ///< one for each column
  std::string kind = {};           ///< class of the row; may be empty
  std::string link = {};
};

/// A table as HTML, which narrow screens show row by row.
/// @param title  description for readers who cannot see it
[[nodiscard]] std::string tableHtml(const std::string& title, const std::vector<PageColumn>& columns,
                                    const std::vector<PageRow>& rows);
/// A table as a figure.
[[nodiscard]] std::string tableFigure(const std::string& id, const std::string& title,
                                      const std::vector<PageColumn>& columns,
                                      const std::vector<PageRow>& rows, const std::string& reading);

/// A value with as many decimals as its standard deviation justifies.
[[nodiscard]] std::string valueText(double value, double std);
/// The standard deviation of a value: "fixed" for 0, "unknown" if it is not finite.
[[nodiscard]] std::string deviationText(double value, double std);
/// True if the value is meaningless because its standard deviation exceeds it.
[[nodiscard]] bool isUndetermined(double value, double std);

}  // namespace alidade
