// SPDX-License-Identifier: MIT
#include "alidade/files/table_lines.h"

#include <algorithm>
#include <array>
#include <cctype>
#include <utility>

#include "alidade/core/text.h"

namespace alidade::detail {
namespace {

constexpr std::string_view kBlanks = " \t\r";

bool isBlank(char c) {
  return kBlanks.find(c) != std::string_view::npos;
}

std::string lowerCase(std::string_view text) {
  std::string lower(text);
  for (char& c : lower) c = static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
  return lower;
}

// The unit's symbol for the ways of writing it; empty for what is none.
std::string_view unitSymbol(std::string_view text) {
  using Spelling = std::pair<std::string_view, std::string_view>;
  constexpr std::array<Spelling, 21> kSpellings = {
      {{"m", "m"},        {"meter", "m"},   {"meters", "m"},    {"metre", "m"}, {"metres", "m"},
       {"mm", "mm"},      {"cm", "cm"},     {"um", "um"},       {"km", "km"},   {"in", "in"},
       {"inch", "in"},    {"inches", "in"}, {"ft", "ft"},       {"px", "px"},   {"pixel", "px"},
       {"pixels", "px"},  {"rad", "rad"},   {"radians", "rad"}, {"deg", "deg"}, {"degree", "deg"},
       {"degrees", "deg"}}};
  for (const auto& [spelling, symbol] : kSpellings) {
    if (spelling == text) return symbol;
  }
  return {};
}

// What follows the column's name in a header's field: nothing, or a unit in brackets or after a blank or '_'.
// Nothing at all for a field that is another name.
std::optional<std::string> unitBehind(std::string_view field, const std::string& column) {
  const std::string text = lowerCase(trim(field));
  if (!text.starts_with(column)) return std::nullopt;
  std::string_view rest = std::string_view(text).substr(column.size());
  if (rest.empty()) return "";
  constexpr std::string_view kAround = " _[]()";
  if (kAround.find(rest.front()) == std::string_view::npos) return std::nullopt;
  const std::size_t first = rest.find_first_not_of(kAround);
  if (first == std::string_view::npos) return "";
  rest = rest.substr(first, rest.find_last_not_of(kAround) - first + 1);
  const std::string_view symbol = unitSymbol(rest);
  if (symbol.empty()) return std::nullopt;
  return std::string(symbol);
}

}  // namespace

ColumnSearch findColumn(const std::vector<std::string>& names, const TableColumn& column) {
  std::vector<std::size_t> exact;
  std::vector<std::size_t> alike;
  std::string complaint;
  for (std::size_t i = 0; i < names.size(); ++i) {
    if (names[i] == column.name) exact.push_back(i);
    const auto unit = unitBehind(names[i], column.name);
    if (!unit) continue;
    if (unit->empty() || *unit == column.unit) {
      alike.push_back(i);
    } else if (complaint.empty()) {
      complaint = "the column '" + names[i] + "'";
    }
  }
  const std::vector<std::size_t>& found = exact.empty() ? alike : exact;
  if (found.size() > 1)
    return {.complaint = "two columns '" + names[found[0]] + "' and '" + names[found[1]] + "'"};
  if (found.size() == 1) return {.index = found.front()};
  return {.complaint = complaint};
}

TableLines::Kind TableLines::take(std::string_view line) {
  ++line_;
  if (line_ == 1) {
    if (line.starts_with("\xff\xfe") || line.starts_with("\xfe\xff"))
      throw error("UTF-16 text", "UTF-8 or ASCII", "save the table as CSV (UTF-8)");
    if (line.starts_with("\xef\xbb\xbf")) line.remove_prefix(3);
  }
  line = trim(line);
  if (line.empty()) return Kind::kNothing;
  if (line.starts_with('#')) {
    if (num_fields_ != 0) return Kind::kNothing;
    line = trim(line.substr(std::min(line.find_first_not_of('#'), line.size())));
    try {
      split(line);
      comment_names_ = fields_;
    } catch (const Error&) {
      comment_names_.clear();  // a remark may hold anything, such as one quotation mark
    }
    return Kind::kNothing;
  }
  split(line);
  if (num_fields_ == 0) {
    num_fields_ = fields_.size();
    if (!parseDouble(fields_.front())) return Kind::kHeader;
    if (comment_names_.size() != num_fields_) comment_names_.clear();
    return Kind::kRow;
  }
  if (fields_.size() != num_fields_)
    throw error(std::to_string(fields_.size()) + " fields",
                std::to_string(num_fields_) + " as in the rows before");
  return Kind::kRow;
}

void TableLines::split(std::string_view line) {
  fields_.clear();
  bool has_comma = false;
  bool has_semicolon = false;
  bool is_quoted = false;
  for (const char c : line) {
    if (c == '"') is_quoted = !is_quoted;
    if (is_quoted) continue;
    has_comma = has_comma || c == ',';
    has_semicolon = has_semicolon || c == ';';
  }
  if (is_quoted) throw error("an open quote", "a quote at the field's end too");
  if (has_comma && has_semicolon)
    throw error("commas beside semicolons", "one of them between fields, and a point in numbers",
                "if the numbers have decimal commas, write points instead");
  if (has_comma || has_semicolon) return splitAt(line, has_comma ? ',' : ';');
  for (std::size_t i = 0; i < line.size();) {
    i = takeField(line, i, kBlanks);
    while (i < line.size() && isBlank(line[i])) ++i;
  }
}

void TableLines::splitAt(std::string_view line, char separator) {
  const std::string_view ends(&separator, 1);
  for (std::size_t i = 0;;) {
    while (i < line.size() && isBlank(line[i])) ++i;
    i = takeField(line, i, ends);
    if (i == line.size()) return;
    ++i;
  }
}

// Adds the field that starts at `start` and goes on to one of `ends` outside of quotes. @returns its end
std::size_t TableLines::takeField(std::string_view line, std::size_t start, std::string_view ends) {
  std::size_t i = start;
  bool is_quoted = false;
  for (; i < line.size() && (is_quoted || ends.find(line[i]) == std::string_view::npos); ++i) {
    if (line[i] == '"') is_quoted = !is_quoted;
  }
  const std::string_view text = trim(line.substr(start, i - start));
  if (!text.starts_with('"')) {
    fields_.emplace_back(text);
    return i;
  }
  std::string field;
  is_quoted = false;
  for (std::size_t k = 0; k < text.size(); ++k) {
    if (text[k] != '"') {
      field += text[k];
    } else {
      if (!is_quoted && k > 0) field += '"';  // a doubled one inside
      is_quoted = !is_quoted;
    }
  }
  fields_.push_back(std::move(field));
  return i;
}

double TableLines::number(std::size_t index, const std::string& column) const {
  const std::string& field = fields_[index];
  const auto value = parseDouble(field);
  if (!value) {
    const bool is_decimal_comma = field.find(',') != std::string::npos;
    throw error("'" + field.substr(0, 40) + "' as " + column, "a number",
                is_decimal_comma ? "write a decimal point instead of the comma" : "");
  }
  return *value;
}

Error TableLines::error(const std::string& found, const std::string& expected,
                        const std::string& next_step) const {
  return inputError({.where = name_ + ":" + std::to_string(line_),
                     .found = "found " + found,
                     .expected = expected,
                     .next_step = next_step});
}

}  // namespace alidade::detail
