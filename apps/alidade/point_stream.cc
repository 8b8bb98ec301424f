// SPDX-License-Identifier: MIT
#include "point_stream.h"

#include <algorithm>
#include <cerrno>
#include <charconv>
#include <cstring>
#include <utility>

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include "alidade/core/error.h"
#include "alidade/core/text.h"
#include "alidade/io/atomic_file.h"
#include "command.h"

namespace alidade {
namespace {

constexpr std::size_t kBufferBytes = std::size_t{1} << 20U;
constexpr std::size_t kMaxLineBytes = std::size_t{1} << 16U;

bool isSeparator(char c) {
  return c == ',' || c == ';';
}
bool isBlank(char c) {
  return c == ' ' || c == '\t' || c == '\r';
}

int openInput(const std::string& path) {
  if (path.empty() || path == "-") return STDIN_FILENO;
  struct stat info {};
  if (stat(path.c_str(), &info) != 0 && errno == ENOENT) throw missingPathError(path);
  if (S_ISDIR(info.st_mode))
    throw inputError({.where = path, .found = "a folder", .expected = "a file of points"});
  const int fd = ::open(path.c_str(), O_RDONLY | O_CLOEXEC);
  if (fd < 0) throw inputError({.where = path, .found = std::strerror(errno), .expected = "a readable file"});
  return fd;
}

}  // namespace

PointReader::PointReader(const std::string& path, std::vector<std::string> columns,
                         std::function<void()> before_read)
    : name_(path.empty() || path == "-" ? "standard input" : path),
      fd_(openInput(path)),
      columns_(std::move(columns)),
      before_read_(std::move(before_read)),
      buffer_(kBufferBytes) {}

PointReader::~PointReader() {
  if (fd_ != STDIN_FILENO) ::close(fd_);
}

bool PointReader::refill() {
  std::memmove(buffer_.data(), buffer_.data() + begin_, end_ - begin_);
  end_ -= begin_;
  begin_ = 0;
  before_read_();
  ssize_t got = 0;
  do {
    got = ::read(fd_, buffer_.data() + end_, buffer_.size() - end_);
  } while (got < 0 && errno == EINTR);
  if (got < 0) fail(std::strerror(errno), "readable data");
  end_ += static_cast<std::size_t>(got);
  return got > 0;
}

bool PointReader::nextLine(std::string_view& line) {
  for (;;) {
    const char* start = buffer_.data() + begin_;
    const void* stop = end_ > begin_ ? std::memchr(start, '\n', end_ - begin_) : nullptr;
    if (stop != nullptr || (at_end_ && end_ > begin_)) {
      const std::size_t length =
          stop != nullptr ? static_cast<std::size_t>(static_cast<const char*>(stop) - start) : end_ - begin_;
      line = {start, length};
      begin_ += length + (stop != nullptr ? 1 : 0);
      ++line_;
      return true;
    }
    if (at_end_) return false;
    if (end_ - begin_ > kMaxLineBytes) {
      ++line_;
      fail("a line of more than 64 KiB", "rows of numbers");
    }
    at_end_ = !refill();
  }
}

// Blanks around a comma belong to it; apart from commas, a run of blanks is one separator.
void PointReader::splitFields(std::string_view line) {
  fields_.clear();
  std::size_t i = 0;
  const auto skip = [&] {
    while (i < line.size() && isBlank(line[i])) ++i;
  };
  skip();
  while (i < line.size()) {
    const std::size_t start = i;
    while (i < line.size() && !isSeparator(line[i]) && !isBlank(line[i])) ++i;
    fields_.push_back(line.substr(start, i - start));
    skip();
    if (i < line.size() && isSeparator(line[i])) {
      ++i;
      skip();
      if (i == line.size()) fields_.push_back({});  // a trailing comma leaves an empty field
    }
  }
}

void PointReader::readHeader() {
  for (const std::string& column : columns_) {
    const auto at = std::find(fields_.begin(), fields_.end(), column);
    if (at == fields_.end()) {
      std::vector<std::string> names(fields_.begin(), fields_.end());
      fail("the header " + join(names, ","), "columns " + join(columns_, ","));
    }
    field_of_column_.push_back(static_cast<std::size_t>(at - fields_.begin()));
  }
}

bool PointReader::next(std::array<double, 3>& values) {
  std::string_view line;
  while (nextLine(line)) {
    splitFields(line);
    if (fields_.empty() || fields_.front().starts_with('#')) continue;
    if (num_fields_ == 0) {
      num_fields_ = fields_.size();
      if (!parseDouble(fields_.front())) {
        readHeader();
        continue;
      }
      if (num_fields_ != columns_.size()) {
        fail(std::to_string(num_fields_) + " columns without a header",
             std::to_string(columns_.size()) + ": " + join(columns_, ","));
      }
      for (std::size_t i = 0; i < columns_.size(); ++i) field_of_column_.push_back(i);
    }
    parseRow(values);
    return true;
  }
  return false;
}

void PointReader::parseRow(std::array<double, 3>& values) {
  if (fields_.size() != num_fields_) {
    fail(std::to_string(fields_.size()) + " fields", std::to_string(num_fields_) + " as in the rows before");
  }
  for (std::size_t i = 0; i < columns_.size(); ++i) {
    const std::string_view field = fields_[field_of_column_[i]];
    const auto value = parseDouble(field);
    if (!value) fail("'" + std::string(field.substr(0, 40)) + "' as " + columns_[i], "a number");
    values[i] = *value;
  }
}

void PointReader::fail(const std::string& found, const std::string& expected) const {
  throw inputError(
      {.where = name_ + ":" + std::to_string(line_), .found = "found " + found, .expected = expected});
}

void OutputStream::write(std::string_view text) {
  buffer_.append(text);
  if (buffer_.size() >= kBufferBytes) flush();
}

void OutputStream::writeNumber(double value) {
  if (value != value) return write("nan");
  std::array<char, 32> text{};
  const auto result = std::to_chars(text.data(), text.data() + text.size(), value);
  write({text.data(), static_cast<std::size_t>(result.ptr - text.data())});
}

void OutputStream::flush() {
  printResult(buffer_);
  buffer_.clear();
}

}  // namespace alidade
