// SPDX-License-Identifier: MIT
#pragma once

#include <array>
#include <functional>
#include <string>
#include <string_view>
#include <vector>

namespace alidade {

/// Reads rows of numbers from a file or standard input in constant memory: fields apart by commas,
/// semicolons, blanks or tabs, with or without a header row, '#' lines and empty lines left out. A header may
/// name the columns in any order and have further ones, which are ignored; without a header the columns come
/// in order and none is extra.
class PointReader {
 public:
  /// @param path  a file; "-" or nothing for standard input
  /// @param before_read  called before each read, which may wait for whoever writes the input
  /// @throws Error (kInput)
  PointReader(
      const std::string& path, std::vector<std::string> columns, std::function<void()> before_read = [] {});
  ~PointReader();
  PointReader(const PointReader&) = delete;
  PointReader& operator=(const PointReader&) = delete;

  /// The next row's numbers in the order of `columns` (NaN and infinities are numbers here). False at the
  /// end.
  /// @throws Error (kInput) naming file, line and field
  bool next(std::array<double, 3>& values);

 private:
  bool nextLine(std::string_view& line);
  bool refill();
  void splitFields(std::string_view line);
  void readHeader();
  void parseRow(std::array<double, 3>& values);
  [[noreturn]] void fail(const std::string& found, const std::string& expected) const;

  std::string name_;
  int fd_;
  std::vector<std::string> columns_;
  std::function<void()> before_read_;
  std::vector<std::size_t> field_of_column_;
  std::size_t num_fields_ = 0;  // a row's; 0 = not known yet
  std::vector<std::string_view> fields_;
  std::vector<char> buffer_;
  std::size_t begin_ = 0;
  std::size_t end_ = 0;
  std::size_t line_ = 0;
  bool at_end_ = false;
};

/// Collects text for standard output and hands it on in large pieces. @throws Error (kInput) when it does not
/// arrive
class OutputStream {
 public:
  void write(std::string_view text);
  void writeNumber(double value);  ///< shortest exact form; "nan" for NaN
  void flush();

 private:
  std::string buffer_;
};

}  // namespace alidade
