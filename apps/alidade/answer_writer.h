// SPDX-License-Identifier: MIT
#pragma once

#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace alidade {

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

  explicit AnswerWriter(Format format);

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
  char* room(std::size_t size);
  void write(std::string_view text);
  char* csvRow(char* out, std::span<const double> values, std::string_view status,
               std::span<const double> details) const;
  char* jsonRow(char* out, std::span<const double> values, std::string_view status,
                std::span<const double> details) const;

  Format format_;
  std::vector<std::string> json_values_;  // keys as they are written
  std::vector<std::string> json_details_;
  std::size_t max_row_size_ = 0;  // but for the status and the pose
  std::string pose_;
  std::vector<char> buffer_;
  std::size_t used_ = 0;
  bool has_rows_ = false;
  bool has_sent_ = false;
};

}  // namespace alidade
