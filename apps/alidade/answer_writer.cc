// SPDX-License-Identifier: MIT
#include "answer_writer.h"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <cstring>

#include <nlohmann/json.hpp>

#include "alidade/core/text.h"
#include "alidade/files/table_lines.h"
#include "command.h"

namespace alidade {
namespace {

constexpr std::size_t kBufferBytes = std::size_t{1} << 17U;
// Room for one number in text: the shortest that reads back as the same has at most 24 characters.
constexpr std::size_t kMaxNumberChars = 32;

char* put(char* out, std::string_view text) {
  std::memcpy(out, text.data(), text.size());
  return out + text.size();
}

char* putDigits(char* out, double value) {
  return std::to_chars(out, out + kMaxNumberChars, value).ptr;
}

char* putNumber(char* out, double value) {
  return value != value ? put(out, "nan") : putDigits(out, value);
}

char* putJsonNumber(char* out, double value) {
  return std::isfinite(value) ? putDigits(out, value) : put(out, "null");
}

}  // namespace

AnswerWriter::AnswerWriter(Format format) : format_(std::move(format)) {
  const auto keys = [&](const std::vector<std::string>& names, bool is_first) {
    std::vector<std::string> texts;
    for (const std::string& name : names) {
      texts.push_back((is_first ? "\"" : ", \"") + name + "\": ");
      max_row_size_ += texts.back().size() + kMaxNumberChars + 1;
      is_first = false;
    }
    return texts;
  };
  json_values_ = keys(format_.values, true);
  json_details_ = keys(format_.details, false);
  constexpr std::size_t kPunctuation = 32;
  max_row_size_ += kPunctuation;
}

void AnswerWriter::begin() {
  if (format_.is_json) return write("{\"points\": [");
  std::vector<std::string> names = format_.values;
  if (format_.has_pose) names.insert(names.begin(), "pose");
  names.emplace_back("status");
  names.insert(names.end(), format_.details.begin(), format_.details.end());
  write(join(names, ",") + "\n");
}

void AnswerWriter::setPose(const std::string& id) {
  using nlohmann::json;
  pose_ = format_.is_json
              ? "\"pose\": " + json(id).dump(-1, ' ', false, json::error_handler_t::replace) + ", "
              : detail::csvField(id) + ",";
}

void AnswerWriter::row(std::span<const double> values, std::string_view status,
                       std::span<const double> details) {
  char* const start = room(max_row_size_ + pose_.size() + status.size());
  char* const end =
      format_.is_json ? jsonRow(start, values, status, details) : csvRow(start, values, status, details);
  used_ += static_cast<std::size_t>(end - start);
  has_rows_ = true;
}

char* AnswerWriter::csvRow(char* out, std::span<const double> values, std::string_view status,
                           std::span<const double> details) const {
  out = put(out, pose_);
  for (const double value : values) {
    out = putNumber(out, value);
    *out++ = ',';
  }
  out = put(out, status);
  for (const double value : details) {
    *out++ = ',';
    out = putNumber(out, value);
  }
  *out++ = '\n';
  return out;
}

char* AnswerWriter::jsonRow(char* out, std::span<const double> values, std::string_view status,
                            std::span<const double> details) const {
  out = put(out, has_rows_ ? ",\n{" : "\n{");
  out = put(out, pose_);
  for (std::size_t i = 0; i < values.size(); ++i) out = putJsonNumber(put(out, json_values_[i]), values[i]);
  out = put(put(put(out, ", \"status\": \""), status), "\"");
  for (std::size_t i = 0; i < details.size(); ++i)
    out = putJsonNumber(put(out, json_details_[i]), details[i]);
  *out++ = '}';
  return out;
}

void AnswerWriter::end() {
  if (format_.is_json) write("\n]}\n");
  flush();
}

void AnswerWriter::flush() {
  has_sent_ = has_sent_ || used_ > 0;  // even if not all of it arrives
  printResult({buffer_.data(), used_});
  used_ = 0;
}

void AnswerWriter::write(std::string_view text) {
  put(room(text.size()), text);
  used_ += text.size();
}

char* AnswerWriter::room(std::size_t size) {
  if (used_ + size > buffer_.size()) {
    if (used_ > 0) flush();
    if (size > buffer_.size()) buffer_.resize(std::max(size, kBufferBytes));
  }
  return buffer_.data() + used_;
}

}  // namespace alidade
