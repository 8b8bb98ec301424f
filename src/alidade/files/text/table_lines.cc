// SPDX-License-Identifier: MIT
#include "alidade/files/text/table_lines.h"

#include <algorithm>
#include <cctype>

#include "alidade/core/text.h"
#include "alidade/files/text/file_text.h"

namespace alidade::detail {
namespace {

std::string lowerCase(std::string_view text) {
  std::string lower(text);
  for (char& c : lower) c = static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
  return lower;
}

// The unit's symbol for its various spellings; empty if it is not a unit.
std::string unitSymbol(const std::string& text) {
  for (const char* spellings : {"m meter meters metre metres", "mm", "cm", "um", "km", "in inch inches", "ft",
                                "px pixel pixels", "rad radians", "deg degree degrees"}) {
    const std::vector<std::string> names = words(spellings);
    if (std::find(names.begin(), names.end(), text) != names.end()) return names.front();
  }
  return "";
}

// The rest of a header's field after the column's name: empty, or a unit in brackets or after a blank or '_'.
// Nothing if the field is a different name.
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
  const std::string symbol = unitSymbol(std::string(rest));
  return symbol.empty() ? std::nullopt : std::optional(symbol);
}

// Accepts numbers that overflow a double or contain a typo. No column name starts like a number.
bool startsNumber(std::string_view field) {
  const std::size_t first = field.find_first_not_of("+-.");
  return parseDouble(field) ||
         (first != std::string_view::npos && std::isdigit(static_cast<unsigned char>(field[first])) != 0);
}

}  // namespace

std::optional<std::vector<std::string>> splitCsv(std::string_view line) {
  std::vector<std::string> fields(1);
  bool is_quoted = false;
  for (std::size_t i = 0; i < line.size(); ++i) {
    const char c = line[i];
    if (is_quoted) {
      if (c != '"') {
        fields.back() += c;
      } else if (i + 1 < line.size() && line[i + 1] == '"') {
        fields.back() += '"';
        ++i;
      } else {
        is_quoted = false;
      }
    } else if (c == '"' && fields.back().empty()) {
      is_quoted = true;
    } else if (c == ',') {
      fields.emplace_back();
    } else {
      fields.back() += c;
    }
  }
  if (is_quoted) return std::nullopt;
  return fields;
}

std::string csvField(const std::string& text) {
  if (text.find_first_of(",\"\n\r#") == std::string::npos) return text;
  std::string quoted = "\"";
  for (const char c : text) {
    if (c == '"') quoted += '"';
    quoted += c;
  }
  return quoted + '"';
}

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
      comment_names_ = names();
    } catch (const Error&) {
      comment_names_.clear();  // a comment may contain anything, such as one quotation mark
    }
    return Kind::kNothing;
  }
  split(line);
  if (num_fields_ == 0) {
    num_fields_ = fields_.size();
    if (!startsNumber(fields_.front())) return Kind::kHeader;
    if (comment_names_.size() != num_fields_) comment_names_.clear();
    return Kind::kRow;
  }
  if (fields_.size() != num_fields_)
    throw error(std::to_string(fields_.size()) + " fields",
                std::to_string(num_fields_) + " as in the previous rows");
  return Kind::kRow;
}

void TableLines::split(std::string_view line) {
  fields_.clear();
  unquoted_.clear();
  // Calls `visit` with the position of each character outside quotes.
  const auto visitUnquoted = [line](const auto& visit) {
    bool is_quoted = false;
    for (std::size_t i = 0; i < line.size(); ++i) {
      if (line[i] == '"') is_quoted = !is_quoted;
      if (!is_quoted) visit(i);
    }
    return is_quoted;
  };
  bool has_comma = false;
  bool has_semicolon = false;
  const bool is_open = visitUnquoted([&](std::size_t i) {
    has_comma = has_comma || line[i] == ',';
    has_semicolon = has_semicolon || line[i] == ';';
  });
  if (is_open) throw error("a quote that is not closed", "a closing quote at the end of the field");
  if (has_comma && has_semicolon)
    throw error("both commas and semicolons",
                "only one of them, between fields, and a decimal point in numbers",
                "if the numbers have decimal commas, replace them with points");
  const std::string_view separators = has_comma ? "," : has_semicolon ? ";" : " \t\r";
  const bool are_blanks = separators.size() > 1;
  std::size_t start = 0;
  const auto endField = [&](std::size_t end) {
    const std::string_view field = trim(line.substr(start, end - start));
    if (!are_blanks || !field.empty()) addField(field);  // consecutive blanks separate like one
    start = end + 1;
  };
  visitUnquoted([&](std::size_t i) {
    if (separators.find(line[i]) != std::string_view::npos) endField(i);
  });
  endField(line.size());
}

void TableLines::addField(std::string_view text) {
  if (!text.starts_with('"')) {
    fields_.push_back(text);
    return;
  }
  const auto unquoted = splitCsv(text);
  fields_.emplace_back(unquoted_.emplace_back(unquoted ? unquoted->front() : std::string(text)));
}

double TableLines::number(std::size_t index, const std::string& column) const {
  const std::string_view field = fields_[index];
  const auto value = parseDouble(field);
  if (!value) {
    const bool is_decimal_comma = field.find(',') != std::string_view::npos;
    const bool is_beyond = field.find_first_not_of("0123456789.eE+-") == std::string_view::npos;
    throw error("'" + std::string(field.substr(0, 40)) + "' as " + column,
                is_beyond ? "a number between 1e-307 and 1e308" : "a number",
                is_decimal_comma ? "replace the decimal comma with a point" : "");
  }
  return *value;
}

Error TableLines::error(const std::string& found, const std::string& expected,
                        const std::string& next_step) const {
  return errorAt(place(), "found " + found, expected, next_step);
}

}  // namespace alidade::detail
