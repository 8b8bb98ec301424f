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

/// Splits one CSV record (RFC 4180: fields may be quoted, a doubled quote stands for one). Nothing if a quote
/// is left open.
[[nodiscard]] std::optional<std::vector<std::string>> splitCsv(std::string_view line);

/// A field as it goes into a CSV record: quoted where it has to be.
[[nodiscard]] std::string csvField(const std::string& text);

/// A column that a table may have: its name, and the unit that its header may state ("m", "px", "rad"; empty
/// = none).
struct TableColumn {
  std::string name;
  std::string unit{};
};

/// Where the column is among the names of a header: named alike whatever the case, alone or with its unit (x,
/// X, x_m, "x [m]", "x (m)"). The very name goes before others. Nothing if there is none.
struct ColumnSearch {
  std::optional<std::size_t> index{};
  std::string complaint{};  ///< why the header cannot be used: two such columns, or another unit
};
[[nodiscard]] ColumnSearch findColumn(const std::vector<std::string>& names, const TableColumn& column);

/// A table of numbers as people and programs write them, line by line: fields apart by commas or by
/// semicolons (blanks around them do not count), or without either by blanks and tabs; quoted as in CSV where
/// need be; lines that start with '#' and empty lines left out; UTF-8 with or without a mark at the start;
/// ends of lines of either kind. The first row is a header if it does not start with a number.
class TableLines {
 public:
  enum class Kind { kNothing, kHeader, kRow };

  /// @param name  of the file, for messages
  explicit TableLines(std::string name) : name_(std::move(name)) {}

  /// Takes the next line (without its end) and says what it is.
  /// @throws Error (kInput): an open quote, commas beside semicolons, another number of fields than before
  Kind take(std::string_view line);
  /// Counts a line that could not be taken.
  void countLine() { ++line_; }

  /// Fields of the line taken last; they refer to it.
  [[nodiscard]] const std::vector<std::string_view>& fields() const { return fields_; }
  /// The same to keep.
  [[nodiscard]] std::vector<std::string> names() const { return {fields_.begin(), fields_.end()}; }
  /// Field `index` of the row as a finite or infinite number or NaN. @throws Error (kInput) naming `column`
  [[nodiscard]] double number(std::size_t index, const std::string& column) const;
  /// Names in the last comment before the first row that has as many fields as the row; none otherwise.
  [[nodiscard]] const std::vector<std::string>& commentNames() const { return comment_names_; }
  [[nodiscard]] std::size_t numFields() const { return num_fields_; }

  /// An error at this line.
  [[nodiscard]] Error error(const std::string& found, const std::string& expected,
                            const std::string& next_step = "") const;

 private:
  void split(std::string_view line);
  void addField(std::string_view text);

  std::string name_;
  std::size_t line_ = 0;
  std::size_t num_fields_ = 0;  // a row's; 0 = not known yet
  std::vector<std::string_view> fields_;
  std::deque<std::string> unquoted_;  // what fields with quotes refer to
  std::vector<std::string> comment_names_;
};

}  // namespace alidade::detail
