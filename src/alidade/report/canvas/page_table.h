// SPDX-License-Identifier: MIT
#pragma once

#include <string>
#include <vector>

namespace alidade {

// Tables of the report pages. Texts are plain.

struct PageColumn {
  std::string name;
  std::string kind = {};   ///< class of its cells: "words" for text instead of numbers
  bool has_links = false;  ///< to PageRow::link
};

struct PageRow {
  std::vector<std::string> cells;  ///< one for each column
  std::string kind = {};           ///< class of the row; may be empty
  std::string link = {};
};

/// A table, which narrow screens show row by row, as HTML.
/// @param title  what it shows, for readers who cannot see it
[[nodiscard]] std::string tableHtml(const std::string& title, const std::vector<PageColumn>& columns,
                                    const std::vector<PageRow>& rows);
/// A figure that is a table.
[[nodiscard]] std::string tableFigure(const std::string& id, const std::string& title,
                                      const std::vector<PageColumn>& columns,
                                      const std::vector<PageRow>& rows, const std::string& reading);

/// A value with as many decimals as its standard deviation makes sense of.
[[nodiscard]] std::string valueText(double value, double std);
/// The standard deviation of a value: "fixed" for 0, "unknown" for what is not finite.
[[nodiscard]] std::string deviationText(double value, double std);
/// Whether the value says nothing, because its standard deviation exceeds it.
[[nodiscard]] bool isUndetermined(double value, double std);

}  // namespace alidade
