// SPDX-License-Identifier: MIT
#include "alidade/report/canvas/page_table.h"

#include <algorithm>
#include <cmath>
#include <cstddef>

#include <fmt/format.h>

#include "alidade/core/text.h"
#include "alidade/report/canvas/figure_canvas.h"

namespace alidade {
namespace {

bool isEstimated(double std) {
  return std > 0 && std::isfinite(std);
}

}  // namespace

std::string proseHtml(const std::string& text) {
  std::string html;
  for (const std::string_view word : split(text, ' ')) {
    const std::string_view core = word.substr(0, word.find_last_not_of(".,;:)") + 1);
    std::string inner;
    for (const char c : escapedMarkup(core)) inner += c == '/' ? std::string("/<wbr>") : std::string(1, c);
    const bool is_id = core.find('_') != std::string_view::npos &&
                       core.find_first_not_of("abcdefghijklmnopqrstuvwxyz_") == std::string_view::npos;
    if (is_id || core.starts_with("--")) inner = "<code>" + inner + "</code>";
    html += (word.data() == text.data() ? "" : " ") + inner + escapedMarkup(word.substr(core.size()));
  }
  return html;
}

std::string tableHtml(const std::string& title, const std::vector<PageColumn>& columns,
                      const std::vector<PageRow>& rows) {
  const auto kindOf = [](const std::string& kind) {
    return kind.empty() ? std::string() : fmt::format(" class=\"{}\"", kind);
  };
  std::string html = fmt::format(
      "<div class=\"scroll\" tabindex=\"0\" role=\"region\" aria-label=\"{}\"><table "
      "class=\"rows\"><thead><tr>",
      escapedMarkup(title));
  for (const PageColumn& column : columns)
    html += fmt::format("<th scope=\"col\"{}>{}</th>", kindOf(column.kind), escapedMarkup(column.name));
  html += "</tr></thead><tbody>\n";
  for (const PageRow& row : rows) {
    html += fmt::format("<tr{}>", kindOf(row.kind));
    for (std::size_t c = 0; c < columns.size(); ++c) {
      std::string cell = proseHtml(row.cells[c]);
      if (columns[c].has_links) cell = fmt::format("<a href=\"{}\">{}</a>", escapedMarkup(row.link), cell);
      html += fmt::format("<td{} data-name=\"{}\">{}</td>", kindOf(columns[c].kind),
                          escapedMarkup(columns[c].name), cell);
    }
    html += "</tr>\n";
  }
  return html + "</tbody></table></div>";
}

std::string tableFigure(const std::string& id, const std::string& title,
                        const std::vector<PageColumn>& columns, const std::vector<PageRow>& rows,
                        const std::string& reading) {
  return fmt::format(
      "<figure id=\"{}\"{}><h3>{}</h3>{}<figcaption class=\"reading\">{}</figcaption></figure>\n", id,
      columns.size() > 3 ? " class=\"wide\"" : "", escapedMarkup(title), tableHtml(title, columns, rows),
      escapedMarkup(reading));
}

std::string valueText(double value, double std) {
  if (!isEstimated(std)) return fmt::format("{:.6g}", value);
  const std::string text =
      fmt::format("{:.{}f}", value, std::clamp(1 - static_cast<int>(std::floor(std::log10(std))), 0, 8));
  // Avoids "-0.00".
  return text.find_first_of("123456789") == std::string::npos && text[0] == '-' ? text.substr(1) : text;
}

std::string deviationText(double value, double std) {
  if (!std::isfinite(std)) return "unknown";
  if (!isEstimated(std)) return "fixed";
  return valueText(std, std) + (isUndetermined(value, std) ? ", not determined" : "");
}

bool isUndetermined(double value, double std) {
  return isEstimated(std) && std > std::abs(value);
}

}  // namespace alidade
