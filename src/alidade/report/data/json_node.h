// SPDX-License-Identifier: MIT
#pragma once

#include <cmath>
#include <cstddef>
#include <limits>
#include <string>
#include <vector>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "alidade/camera/any_camera.h"
#include "alidade/core/diagnosis.h"
#include "alidade/core/error.h"
#include "alidade/core/image.h"
#include "alidade/geometry/se3.h"
#include "alidade/report/data/utf8.h"

namespace alidade {

/// A value of an evidence document and its place. The text of a place is made only for messages. Every reader
/// throws Error (kInput) that names the place.
class JsonNode {
 public:
  JsonNode(const nlohmann::json& value, const std::string& file) : value_(&value), file_(&file) {}

  [[nodiscard]] JsonNode operator[](const char* key) const {
    if (!value_->is_object()) refuse("an object");
    const auto found = value_->find(key);
    if (found == value_->end())
      throw errorAt((place().empty() ? "" : place() + ".") + key, "missing",
                    "the evidence of a calibration of one camera");
    return {*found, *this, key, 0};
  }
  [[nodiscard]] JsonNode at(std::size_t i) const { return {(*value_)[i], *this, nullptr, i}; }
  [[nodiscard]] bool has(const char* key) const { return value_->is_object() && value_->contains(key); }
  [[nodiscard]] bool isNull() const { return value_->is_null(); }
  [[nodiscard]] bool isArray() const { return value_->is_array(); }

  /// NaN for null, which also stands for infinite values, as JSON has neither.
  [[nodiscard]] double number() const {
    if (value_->is_null()) return std::numeric_limits<double>::quiet_NaN();
    if (!value_->is_number()) refuse("a number");
    const double value = value_->get<double>();
    return std::isfinite(value) ? value : std::numeric_limits<double>::quiet_NaN();
  }
  [[nodiscard]] double finite() const {
    const double value = number();
    if (!std::isfinite(value)) refuse("a number");
    return value;
  }
  [[nodiscard]] int whole(int least, int most) const {
    const double value = number();
    if (!(value >= least && value <= most) || value != std::floor(value))
      refuse(fmt::format("a whole number from {} to {}", least, most));
    return static_cast<int>(value);
  }
  [[nodiscard]] std::string text() const {
    if (!value_->is_string()) refuse("a text");
    return validUtf8(value_->get_ref<const std::string&>());
  }
  [[nodiscard]] bool flag() const {
    if (!value_->is_boolean()) refuse("true or false");
    return value_->get<bool>();
  }
  [[nodiscard]] std::size_t size() const {
    if (!value_->is_array()) refuse("a list");
    return value_->size();
  }
  /// Requires a list of `count` elements.
  void requireSize(std::size_t count) const {
    if (size() != count) refuse(fmt::format("a list of {} elements", count));
  }
  template <class Read>
  [[nodiscard]] auto list(Read read) const {
    std::vector<decltype(read(*this))> values;
    const std::size_t count = size();
    values.reserve(count);
    for (std::size_t i = 0; i < count; ++i) values.push_back(read(at(i)));
    return values;
  }

  /// The result of `make`; its errors get this place.
  template <class Make>
  [[nodiscard]] auto made(Make make) const {
    try {
      return make();
    } catch (const Error& error) {
      const std::string complaint = error.what();
      throw errorAt(place(), complaint.substr(0, complaint.find('\n')), "");
    }
  }
  [[noreturn]] void refuse(const std::string& expected) const {
    throw errorAt(place(), value_->is_structured() ? "a value of another kind" : value_->dump(), expected);
  }

 private:
  JsonNode(const nlohmann::json& value, const JsonNode& parent, const char* key, std::size_t index)
      : value_(&value), file_(parent.file_), parent_(&parent), key_(key), index_(index) {}

  [[nodiscard]] Error errorAt(const std::string& at, const std::string& found,
                              const std::string& expected) const {
    return inputError({.where = *file_ + (at.empty() ? "" : ": " + at),
                       .found = found,
                       .expected = expected,
                       .next_step = "write it again with alidade calibrate --evidence"});
  }
  [[nodiscard]] std::string place() const {
    if (parent_ == nullptr) return "";
    const std::string before = parent_->place();
    if (key_ == nullptr) return fmt::format("{}[{}]", before, index_);
    return before.empty() ? key_ : before + "." + key_;
  }

  const nlohmann::json* value_;
  const std::string* file_;
  const JsonNode* parent_ = nullptr;
  const char* key_ = nullptr;
  std::size_t index_ = 0;
};

// Readers of values that occur in several documents.

[[nodiscard]] std::string textOf(const JsonNode& node);
/// A list of kSize finite numbers.
template <int kSize>
[[nodiscard]] Eigen::Vector<double, kSize> readVector(const JsonNode& node) {
  node.requireSize(kSize);
  Eigen::Vector<double, kSize> vector;
  for (std::size_t i = 0; i < kSize; ++i) vector(static_cast<Eigen::Index>(i)) = node.at(i).finite();
  return vector;
}
[[nodiscard]] ImageSize readSize(const JsonNode& node);
[[nodiscard]] SE3 readPose(const JsonNode& node);
[[nodiscard]] std::vector<Diagnosis> readFindings(const JsonNode& node);
[[nodiscard]] Severity readSeverity(const JsonNode& node);
[[nodiscard]] Verdict readVerdict(const JsonNode& node);
/// Reads the keys "model" and "parameters" of an object.
[[nodiscard]] AnyCamera readCamera(const JsonNode& node);

}  // namespace alidade
