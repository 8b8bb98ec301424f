// SPDX-License-Identifier: MIT
#pragma once

#include <cstddef>
#include <deque>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "alidade/core/error.h"

namespace alidade::detail {

/// Splits one CSV record (RFC 4180: fields may be quoted, with doubled quotes inside). Nothing if a quote is
/// left open.
[[nodiscard]] std::optional<std::vector<std::string>> splitCsv(std::string_view line);

/// A field for a CSV record, quoted if necessary.
[[nodiscard]] std::string csvField(const std::string& text);

/// A column that a table may have: its name, and the unit that its header may state ("m", "px", "rad"; empty
/// = none).
struct TableColumn {
  std::string name;
  std::string unit{};
};

/// Search for a column in the names of a header: ignores case, with or without the unit (x, X, x_m, "x [m]",
/// "x (m)"). An exact match takes precedence. Nothing if there is none.
struct ColumnSearch {
  std::optional<std::size_t> index{};
  std::string complaint{};  ///< reason why the header cannot be used: two such columns, or a different unit
};
[[nodiscard]] ColumnSearch findColumn(const std::vector<std::string>& names, const TableColumn& column);

/// A table of numbers, written by people or programs, line by line: fields separated by commas or semicolons
/// (ignoring blanks around them), or otherwise by blanks and tabs; quoted as in CSV if necessary; lines that
/// start with '#' and empty lines are skipped; UTF-8 with or without a byte order mark; line ends of either
/// kind. The first row is a header if it does not start with a number.
class TableLines {
 public:
  enum class Kind { kNothing, kHeader, kRow };

  /// @param name  of the file, for messages
  explicit TableLines(std::string name) : name_(std::move(name)) {}

  /// Takes the next line (without its end) and classifies it.
  /// @throws Error (kInput): an open quote, commas beside semicolons, a different number of fields than
  /// before
  Kind take(std::string_view line);
  /// Counts a line that could not be parsed.
  void countLine() { ++line_; }

  /// Fields of the last line; they refer to its text.
  [[nodiscard]] const std::vector<std::string_view>& fields() const { return fields_; }
  /// Copies of the fields.
  [[nodiscard]] std::vector<std::string> names() const { return {fields_.begin(), fields_.end()}; }
  /// Field `index` of the row as a finite or infinite number or NaN. @throws Error (kInput) naming `column`
  [[nodiscard]] double number(std::size_t index, const std::string& column) const;
  /// Names in the last comment before the first row that has as many fields as the row; none otherwise.
  [[nodiscard]] const std::vector<std::string>& commentNames() const { return comment_names_; }
  [[nodiscard]] std::size_t numFields() const { return num_fields_; }

  /// "poses.csv:4"
  [[nodiscard]] std::string place() const { return name_ + ":" + std::to_string(line_); }
  /// An error with the place of this line.
  [[nodiscard]] Error error(const std::string& found, const std::string& expected,
                            const std::string& next_step = "") const;

 private:
  void split(std::string_view line);
  void addField(std::string_view text);

  std::string name_;
  std::size_t line_ = 0;
  std::size_t num_fields_ = 0;  // per row; 0 = not known yet
  std::vector<std::string_view> fields_;
  std::deque<std::string> unquoted_;  // text of fields with quotes
  std::vector<std::string> comment_names_;
};

}  // namespace alidade::detail
