// SPDX-License-Identifier: MIT
#pragma once

#include <cstddef>
#include <functional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include <Eigen/Core>

#include "alidade/files/table_lines.h"

namespace alidade {

/// Reads rows of two or three numbers from a file or standard input in constant memory, in the forms of
/// TableLines. A header may name the columns in any order and have further ones, which are ignored; without a
/// header (or a comment in its place) the columns come in order and none is extra.
class PointReader {
 public:
  /// Rows that are handed on at a time.
  static constexpr std::size_t kMaxRows = 512;

  /// @param path  a file; "-" or nothing for standard input
  /// @param before_read  called before each read, which may wait for whoever writes the input; all rows read
  /// so far have been handed on by then
  /// @throws Error (kInput)
  PointReader(const std::string& path, std::vector<detail::TableColumn> columns,
              std::function<void()> before_read);
  ~PointReader();
  PointReader(const PointReader&) = delete;
  PointReader& operator=(const PointReader&) = delete;

  /// The next rows' numbers in the order of `columns` (NaN and infinities are numbers here), with zero for a
  /// third column where there are two. False at the end.
  /// @throws Error (kInput) naming file, line and field
  bool next(std::vector<Eigen::Vector3d>& rows);

 private:
  void refill();
  void readLine(std::vector<Eigen::Vector3d>& rows);
  bool findColumns(const std::vector<std::string>& names, std::string& complaint);
  void setUpFields();

  detail::TableLines lines_;
  int fd_;
  std::vector<detail::TableColumn> columns_;
  std::function<void()> before_read_;
  std::vector<std::size_t> field_of_column_;
  bool has_rows_ = false;  // the fields of the columns are known
  std::vector<char> buffer_;
  // In the buffer: whole lines up to `lines_end_`, and the start of one more up to `end_`.
  const char* begin_;
  const char* lines_end_;
  const char* end_;
  bool at_end_ = false;
};

/// Writes rows of numbers with a status to standard output, as CSV or as one JSON document, in large pieces.
/// Numbers are written in the fewest digits that read back as the same; NaN is "nan", in JSON null.
/// The JSON is written piece by piece and not as a document of nlohmann-json, which would need memory for all
/// rows.
/// @throws Error (kInput), from any method, when it does not arrive
class AnswerWriter {
 public:
  struct Format {
    bool is_json = false;
    bool has_pose = false;             ///< rows start with the id of a pose
    std::vector<std::string> values;   ///< columns before the status
    std::vector<std::string> details;  ///< columns behind it
  };

  explicit AnswerWriter(Format format) : format_(std::move(format)) {}

  void begin();
  /// Of the rows to come.
  void setPose(const std::string& id);
  void row(std::span<const double> values, std::string_view status, std::span<const double> details);
  void end();
  void flush();

  [[nodiscard]] bool hasRows() const { return has_rows_; }
  /// Whether anything has left for standard output, so that what follows there must go on with it.
  [[nodiscard]] bool hasSent() const { return has_sent_; }

 private:
  void addNumber(const std::string& name, double value);

  Format format_;
  std::string pose_;
  std::string buffer_;
  bool has_rows_ = false;
  bool has_sent_ = false;
};

}  // namespace alidade
