// SPDX-License-Identifier: MIT
#pragma once

#include <cstddef>
#include <optional>
#include <set>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include <yaml-cpp/yaml.h>

#include "alidade/core/error.h"
#include "alidade/files/text/file_text.h"

namespace alidade::detail {

/// True for a comment, as in JSON, which has no others.
[[nodiscard]] inline bool isCommentKey(std::string_view key) {
  return key.starts_with("//");
}
/// True if this key of a map belongs to the user and is ignored.
[[nodiscard]] inline bool isUserKey(std::string_view key) {
  return key.starts_with("x_") || isCommentKey(key);
}

/// A YAML node that knows its file and its path from the root, so that every error can name both. Strict: a
/// value has the requested type, or there is an Error (kInput) with line, found, expected and next step.
class YamlNode {
 public:
  static constexpr std::size_t kMaxBytes = 64u << 20u;  ///< of a file

  YamlNode(const YamlNode&) = default;
  /// Refers to the other node; YAML::Node's own assignment would change the document.
  YamlNode& operator=(const YamlNode& other) {
    node_.reset(other.node_);
    file_ = other.file_;
    path_ = other.path_;
    return *this;
  }
  ~YamlNode() = default;

  /// Parses a document; `file` is only a name for messages. A duplicate key in a map is an error, because
  /// readers differ in which one they take, and so is a map with more keys than any camera file has.
  [[nodiscard]] static YamlNode parse(const std::string& text, const std::string& file);
  [[nodiscard]] static YamlNode readFile(const std::string& path);

  /// Checks that this is a map with no other keys than these (keys starting with x_ are the user's own).
  void allowKeys(const std::vector<std::string>& keys) const;

  [[nodiscard]] const YAML::Node& node() const { return node_; }
  [[nodiscard]] bool isMap() const { return node_.IsMap(); }
  [[nodiscard]] bool isNull() const { return node_.IsNull(); }
  [[nodiscard]] bool isScalar() const { return node_.IsScalar(); }
  [[nodiscard]] bool isSequence() const { return node_.IsSequence(); }
  [[nodiscard]] bool has(const std::string& key) const;
  /// The value of a key of this map; missing is an error.
  [[nodiscard]] YamlNode at(const std::string& key) const;
  [[nodiscard]] std::optional<YamlNode> find(const std::string& key) const;
  /// Keys of this map in the file's order; anything but a map is an error.
  [[nodiscard]] std::vector<std::string> keys() const;
  /// The line of a key itself, from 1, as its value may begin further down; 0 = unknown.
  [[nodiscard]] int lineOfKey(const std::string& key) const;
  /// The first `most` items of this list.
  [[nodiscard]] std::vector<YamlNode> items(std::size_t most = kMaxBytes) const;

  [[nodiscard]] std::string text() const;
  /// A scalar, or a list of scalars.
  [[nodiscard]] std::vector<std::string> texts() const;
  [[nodiscard]] double number() const;  ///< finite
  [[nodiscard]] int integer() const;
  [[nodiscard]] bool boolean() const;
  /// A sequence of finite numbers; `count` 0 = any.
  [[nodiscard]] std::vector<double> numbers(std::size_t count = 0) const;

  /// "cam.yaml:4: parameters.fx"
  [[nodiscard]] std::string where() const;
  /// "cam.yaml:4: parameters.fx", where 4 is the line of that key of this map, not where its value begins;
  /// omitted if unknown.
  [[nodiscard]] std::string whereKey(const std::string& key) const;
  [[nodiscard]] Error error(const std::string& found, const std::string& expected,
                            const std::string& next_step = "") const;

 private:
  YamlNode(const YAML::Node& node, std::string file, std::string path)
      : node_(node), file_(std::move(file)), path_(std::move(path)) {}
  [[nodiscard]] std::string describe() const;
  void checkKeys(std::set<std::pair<int, bool>>& seen) const;

  YAML::Node node_;
  std::string file_;
  std::string path_;
};

}  // namespace alidade::detail
