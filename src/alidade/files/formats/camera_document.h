// SPDX-License-Identifier: MIT
#pragma once

#include <optional>
#include <string>

#include "alidade/files/text/yaml_node.h"

namespace alidade::detail {

/// The text of a camera file of any format, and its tree if it is YAML, JSON, mrcal's Python literal, or one
/// of the notations of notations.h. The tree keeps the line numbers of the text.
class CameraDocument {
 public:
  /// `file` is only a name for messages.
  CameraDocument(std::string text, std::string file);

  [[nodiscard]] const std::string& text() const { return text_; }
  [[nodiscard]] const std::string& file() const { return file_; }

  /// The tree's root. @throws Error (kInput) with the place if the text cannot be parsed
  [[nodiscard]] const YamlNode& root() const;
  [[nodiscard]] bool isTree() const { return root_.has_value(); }
  /// True if there is a tree whose root is a map with names as keys.
  [[nodiscard]] bool isMap() const { return is_map_; }
  /// True if there is a tree whose root is a map with this key.
  [[nodiscard]] bool has(const std::string& key) const { return root_ && root_->has(key); }

 private:
  std::string text_;
  std::string file_;
  std::optional<YamlNode> root_;
  bool is_map_ = false;
  std::optional<Error> error_;  ///< reason why there is no tree
};

}  // namespace alidade::detail
