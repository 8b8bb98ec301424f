// SPDX-License-Identifier: MIT
#include "alidade/files/formats/camera_document.h"

#include <algorithm>
#include <cctype>
#include <string_view>
#include <utility>
#include <vector>

#include <nlohmann/json.hpp>

#include "alidade/core/text.h"
#include "alidade/files/formats/notations.h"
#include "alidade/files/text/file_text.h"

namespace alidade::detail {
namespace {

constexpr std::size_t kMaxTreeBytes = 4U << 20U;

// In a stream each document ends with a line "---"; `rostopic echo -n1` prints one.
void dropEndOfDocument(std::string& text) {
  const std::size_t last = text.find_last_not_of(" \t\r\n");
  if (last == std::string::npos || last < 3 || text.compare(last - 3, 4, "\n---") != 0) return;
  text.resize(last - 2);
}

// A message without its header (time and count).
std::string withoutHeader(std::string_view message) {
  std::string said;
  bool is_in_header = false;
  for (const std::string_view line : split(message, '\n')) {
    if (trim(line).empty()) continue;
    is_in_header = line.starts_with("header:") || (is_in_header && line.front() == ' ');
    if (!is_in_header) said += std::string(trim(line)) + "\n";
  }
  return said;
}

// Keeps the first of several CameraInfo messages, as `rostopic echo` prints them with a line "---" after
// each, if all are equal except for their headers. Linear in the text.
void keepOneMessage(std::string& text, const std::string& file) {
  constexpr const char* kBetween = " \t\r\n-";
  const auto messageAt = [&text](std::size_t begin) {
    return std::string_view(text).substr(begin, text.find("\n---", begin) - begin);
  };
  const std::size_t start = text.find_first_not_of(kBetween);
  if (start == std::string::npos || text.compare(start, 7, "header:") != 0) return;
  const std::size_t end = start + messageAt(start).size();
  const std::string first = withoutHeader(messageAt(start));
  if (first.find("distortion_model:") == std::string::npos) return;
  for (std::size_t at = end; (at = text.find_first_not_of(kBetween, at)) != std::string::npos;) {
    const std::string_view message = messageAt(at);
    if (withoutHeader(message) != first) {
      throw errorAt(file + ":" + std::to_string(lineAt(text, at)),
                    "found a message that differs from the first one in this file",
                    "messages of one camera that differ only in their headers",
                    "record only one: rostopic echo -n 1 TOPIC, or ros2 topic echo --once TOPIC");
    }
    at += message.size();
  }
  text.resize(end);
}

// Replaces the value after each `key` that starts with `opening` by `instead`. `endOf` finds the end of a
// value from its start. Line numbers do not change.
template <class EndOf>
void replaceValues(std::string& text, std::string_view key, char opening, std::string_view instead,
                   const EndOf& endOf) {
  std::string kept;
  std::size_t from = 0;
  for (std::size_t at = 0; (at = text.find(key, at)) != std::string::npos;) {
    at += key.size();
    const std::size_t begin = text.find_first_not_of(" \t\r\n:", at);
    if (begin == std::string::npos || text[begin] != opening) continue;
    const std::size_t end = std::min(text.size(), endOf(begin));
    kept.append(text, from, begin - from);
    kept += instead;
    for (std::size_t i = begin; i < end; ++i) {
      if (text[i] == '\n') kept += '\n';
    }
    from = at = end;
  }
  if (from == 0) return;
  kept.append(text, from);
  text = std::move(kept);
}

// Removes the bytes b'...' of a whole calibration in mrcal's files, which are not YAML.
void dropPythonBytes(std::string& text) {
  replaceValues(text, "'optimization_inputs'", 'b', "'bytes'", [&text](std::size_t begin) {
    const std::size_t opening = text.find('\'', begin);
    const std::size_t closing = opening == std::string::npos ? opening : text.find('\'', opening + 1);
    return closing == std::string::npos ? closing : closing + 1;
  });
}

// Removes the poses of nerfstudio's thousands of images.
void dropTransformMatrices(std::string& text) {
  replaceValues(text, "\"transform_matrix\"", '[', "[]", [&text](std::size_t begin) {
    int depth = 0;
    std::size_t end = begin;
    do {
      if (text[end] == '[') ++depth;
      if (text[end] == ']') --depth;
      ++end;
    } while (depth > 0 && end < text.size());
    return end;
  });
}

// Converts OpenCV's YAML, which starts with %YAML:1.0 and whose parser (modules/core/src/persistence_yml.cpp)
// ends a key at the colon, whatever follows. The first line becomes a comment, and a value directly after its
// key's colon ("data:[1, 2]") gets the blank that YAML requires. This applies only to keys at the start of a
// line, possibly indented; a key further along its line, as within { }, still needs its blank. Linear in the
// text.
std::string openCvAsYaml(const std::string& text) {
  const auto isKeyCharacter = [](char c) {
    return std::isalnum(static_cast<unsigned char>(c)) != 0 || c == '_' || c == '.' || c == '-';
  };
  std::string yaml;
  for (const std::string_view line : split(text, '\n')) {
    const std::size_t begin = std::min(line.find_first_not_of(' '), line.size());
    std::size_t end = begin;
    while (end < line.size() && isKeyCharacter(line[end])) ++end;
    const bool is_key = end + 1 < line.size() && line[end] == ':' &&
                        (std::isalpha(static_cast<unsigned char>(line[begin])) != 0 || line[begin] == '_');
    const bool is_tight = is_key && std::string_view(" \t\r").find(line[end + 1]) == std::string_view::npos;
    yaml += is_tight ? std::string(line.substr(0, end)) + ": " + std::string(line.substr(end + 1))
                     : std::string(line);
    yaml += '\n';
  }
  yaml.front() = '#';  // keeps an unknown YAML directive as a comment
  return yaml;
}

// Converts the text to YAML in which every value keeps its line number.
YamlNode parseTree(std::string text, const std::string& file) {
  if (nlohmann::json::accept(text)) {
    // YAML does not allow tabs between values, but JSON does; inside its strings they are escaped.
    std::replace(text.begin(), text.end(), '\t', ' ');
    dropTransformMatrices(text);
  } else if (auto yaml = otherNotationAsYaml(text, file)) {
    text = std::move(*yaml);
  } else if (auto dso = dsoAsYaml(text)) {
    text = std::move(*dso);
  } else {
    if (text.starts_with("%YAML:")) text = openCvAsYaml(text);
    keepOneMessage(text, file);
    dropEndOfDocument(text);
    dropPythonBytes(text);
    text = numberLinesAsLists(text);
  }
  // Parsing takes a second for three megabytes, and no camera file is that large.
  if (text.size() > kMaxTreeBytes) {
    throw errorAt(file, std::to_string(text.size()) + " bytes",
                  "a camera file of at most " + std::to_string(kMaxTreeBytes) + " bytes",
                  "remove what does not describe the camera, such as lists of images, or "
                  "put fewer cameras in a file");
  }
  checkUtf8(text, file);  // XML entities may denote invalid characters
  return YamlNode::parse(text, file);
}

// Reason why a .json file that is not YAML either is not valid JSON.
std::optional<Error> jsonError(const std::string& text, const std::string& file) {
  if (!file.ends_with(".json")) return std::nullopt;
  try {
    [[maybe_unused]] const nlohmann::json parsed = nlohmann::json::parse(text);
  } catch (const nlohmann::json::parse_error& e) {
    // "[json.exception.parse_error.101] parse error at line 5, column 3: syntax error ...".
    const std::string_view what = e.what();
    const std::size_t at = what.find(": ");
    return errorAt(
        file + ":" + std::to_string(lineAt(text, e.byte)),
        "not valid JSON: " + std::string(at == std::string_view::npos ? what : what.substr(at + 2)), "",
        "correct the file near that line");
  }
  return std::nullopt;
}

}  // namespace

CameraDocument::CameraDocument(std::string text, std::string file)
    : text_(std::move(text)), file_(std::move(file)) {
  try {
    root_ = parseTree(text_, file_);
  } catch (const Error& e) {
    error_ = jsonError(text_, file_).value_or(e);
  }
  try {
    is_map_ = root_ && root_->isMap() && !root_->keys().empty();
  } catch (const Error&) {
    is_map_ = false;  // a template's "{{ name }}" has a map as a key
  }
}

const YamlNode& CameraDocument::root() const {
  if (!root_) throw *error_;
  return *root_;
}

}  // namespace alidade::detail
