// SPDX-License-Identifier: MIT
#include "row_streams.h"

#include <array>
#include <cerrno>
#include <charconv>
#include <cmath>
#include <cstring>
#include <utility>

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include "alidade/core/error.h"
#include "alidade/core/text.h"
#include "alidade/files/atomic_file.h"
#include "alidade/files/table_lines.h"
#include "console.h"
#include "json_output.h"

namespace alidade {
namespace {

using detail::TableColumn;
using detail::TableLines;

constexpr std::size_t kReadBytes = std::size_t{1} << 18U;
constexpr std::size_t kMaxLineBytes = std::size_t{1} << 16U;

bool isStandardInput(const std::string& path) {
  return path.empty() || path == "-";
}

int openInput(const std::string& path) {
  if (isStandardInput(path)) return STDIN_FILENO;
  struct stat info {};
  if (stat(path.c_str(), &info) != 0 && errno == ENOENT) throw missingPathError(path);
  if (S_ISDIR(info.st_mode))
    throw inputError({.where = path, .found = "a folder", .expected = "a file of points"});
  const int fd = ::open(path.c_str(), O_RDONLY | O_CLOEXEC);
  if (fd < 0) throw inputError({.where = path, .found = std::strerror(errno), .expected = "a readable file"});
  return fd;
}

std::string namesOf(const std::vector<TableColumn>& columns) {
  std::vector<std::string> names;
  for (const TableColumn& column : columns) names.push_back(column.name);
  return join(names, ",");
}

}  // namespace

PointReader::PointReader(const std::string& path, std::vector<TableColumn> columns,
                         std::function<void()> before_read)
    : lines_(isStandardInput(path) ? "standard input" : path),
      fd_(openInput(path)),
      columns_(std::move(columns)),
      before_read_(std::move(before_read)),
      buffer_(kReadBytes + 1),  // and the end of a last line that has none
      begin_(buffer_.data()),
      lines_end_(begin_),
      end_(begin_) {}

PointReader::~PointReader() {
  if (fd_ != STDIN_FILENO) ::close(fd_);
}

bool PointReader::next(std::vector<Eigen::Vector3d>& rows) {
  rows.clear();
  for (;;) {
    while (begin_ != lines_end_ && rows.size() < kMaxRows) readLine(rows);
    if (!rows.empty()) return true;
    if (at_end_) return false;
    refill();
  }
}

void PointReader::refill() {
  const auto kept = static_cast<std::size_t>(end_ - begin_);
  if (kept > kMaxLineBytes) {
    lines_.countLine();
    throw lines_.error("a line longer than 64 KiB", "one row of numbers per line");
  }
  std::memmove(buffer_.data(), begin_, kept);
  before_read_();
  ssize_t got = 0;
  do {
    got = ::read(fd_, buffer_.data() + kept, kReadBytes - kept);
  } while (got < 0 && errno == EINTR);
  if (got < 0) throw lines_.error(std::strerror(errno), "readable data");
  char* end = buffer_.data() + kept + got;
  at_end_ = got == 0;
  if (at_end_ && kept > 0) *end++ = '\n';
  begin_ = buffer_.data();
  end_ = end;
  const auto* last =
      static_cast<const char*>(::memrchr(begin_, '\n', static_cast<std::size_t>(end_ - begin_)));
  lines_end_ = last == nullptr ? begin_ : last + 1;
}

void PointReader::readLine(std::vector<Eigen::Vector3d>& rows) {
  const auto* stop =
      static_cast<const char*>(std::memchr(begin_, '\n', static_cast<std::size_t>(lines_end_ - begin_)));
  const std::string_view line(begin_, static_cast<std::size_t>(stop - begin_));
  begin_ = stop + 1;
  const TableLines::Kind kind = lines_.take(line);
  if (kind == TableLines::Kind::kNothing) return;
  if (kind == TableLines::Kind::kHeader) {
    std::string complaint;
    if (!findColumns(lines_.names(), complaint))
      throw lines_.error(complaint, "columns " + namesOf(columns_) + " in " + columns_.front().unit);
    return;
  }
  if (!has_rows_) setUpFields();
  Eigen::Vector3d row = Eigen::Vector3d::Zero();
  for (std::size_t i = 0; i < columns_.size(); ++i)
    row[static_cast<Eigen::Index>(i)] = lines_.number(field_of_column_[i], columns_[i].name);
  rows.push_back(row);
}

// Looks each column up among the names of a header. @returns false, and why, if one is missing
bool PointReader::findColumns(const std::vector<std::string>& names, std::string& complaint) {
  std::vector<std::size_t> fields;
  for (const TableColumn& column : columns_) {
    const detail::ColumnSearch search = detail::findColumn(names, column);
    if (!search.index) {
      complaint = search.complaint.empty() ? "the header " + join(names, ",") : search.complaint;
      return false;
    }
    fields.push_back(*search.index);
  }
  field_of_column_ = std::move(fields);
  return true;
}

// At the first row: which of its fields are wanted.
void PointReader::setUpFields() {
  std::string ignored;
  if (field_of_column_.empty() && !findColumns(lines_.commentNames(), ignored)) {
    if (lines_.numFields() != columns_.size()) {
      throw lines_.error(std::to_string(lines_.numFields()) + " columns without a header",
                         std::to_string(columns_.size()) + ": " + namesOf(columns_));
    }
    for (std::size_t i = 0; i < columns_.size(); ++i) field_of_column_.push_back(i);
  }
  has_rows_ = true;
}

void AnswerWriter::begin() {
  if (format_.is_json) {
    buffer_ += "{\"points\": [";
    return;
  }
  std::vector<std::string> names = format_.values;
  if (format_.has_pose) names.insert(names.begin(), "pose");
  names.emplace_back("status");
  names.insert(names.end(), format_.details.begin(), format_.details.end());
  buffer_ += join(names, ",") + "\n";
}

void AnswerWriter::setPose(const std::string& id) {
  pose_ = format_.is_json
              ? "\"pose\": " + json(id).dump(-1, ' ', false, json::error_handler_t::replace) + ", "
              : detail::csvField(id) + ",";
}

void AnswerWriter::row(std::span<const double> values, std::string_view status,
                       std::span<const double> details) {
  constexpr std::size_t kBufferBytes = std::size_t{1} << 17U;
  const bool is_json = format_.is_json;
  const std::string_view separator = is_json ? ", " : ",";
  if (is_json) buffer_ += has_rows_ ? ",\n{" : "\n{";
  buffer_ += pose_;
  for (std::size_t i = 0; i < values.size(); ++i) {
    addNumber(format_.values[i], values[i]);
    buffer_ += separator;
  }
  if (is_json) buffer_ += "\"status\": \"";
  buffer_ += status;
  if (is_json) buffer_ += '"';
  for (std::size_t i = 0; i < details.size(); ++i) {
    buffer_ += separator;
    addNumber(format_.details[i], details[i]);
  }
  buffer_ += is_json ? '}' : '\n';
  has_rows_ = true;
  if (buffer_.size() >= kBufferBytes) flush();
}

// In JSON behind its name.
void AnswerWriter::addNumber(const std::string& name, double value) {
  if (format_.is_json) buffer_.append("\"").append(name).append("\": ");
  if (std::isnan(value) || (format_.is_json && std::isinf(value))) {
    buffer_ += format_.is_json ? "null" : "nan";
    return;
  }
  std::array<char, 32> digits{};  // the shortest that reads back as the same has at most 24 characters
  char* const end = std::to_chars(digits.data(), digits.data() + digits.size(), value).ptr;
  buffer_.append(digits.data(), end);
}

void AnswerWriter::end() {
  if (format_.is_json) buffer_ += "\n]}\n";
  flush();
}

void AnswerWriter::flush() {
  has_sent_ = has_sent_ || !buffer_.empty();  // even if not all of it arrives
  printResult(buffer_);
  buffer_.clear();
}

}  // namespace alidade
