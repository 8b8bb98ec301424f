// SPDX-License-Identifier: MIT
#include "alidade/io/formats/camera_document.h"

#include <algorithm>
#include <cctype>
#include <string_view>

#include <nlohmann/json.hpp>

#include "alidade/io/formats/xml_as_yaml.h"

namespace alidade::detail {
namespace {

constexpr std::size_t kMaxTreeBytes = 4U << 20U;

// OpenCV starts its files with %YAML:1.0, which YAML does not know as a directive. The line stays, as a
// comment.
void commentOutDirective(std::string& text) {
  if (text.starts_with("%YAML:")) text.front() = '#';
}

// YAML has no tabs between values, JSON has. Outside of strings they become blanks.
void replaceTabs(std::string& text) {
  bool in_string = false;
  for (std::size_t i = 0; i < text.size(); ++i) {
    if (in_string && text[i] == '\\') {
      ++i;
    } else if (text[i] == '"') {
      in_string = !in_string;
    } else if (text[i] == '\t' && !in_string) {
      text[i] = ' ';
    }
  }
}

// Takes out what YAML cannot read of mrcal's files, the bytes b'...' of a whole calibration; quotes stay.
void dropPythonBytes(std::string& text) {
  for (std::size_t at = 0; (at = text.find(": b'", at)) != std::string::npos;) {
    const std::size_t begin = at + 4;
    const std::size_t end = text.find('\'', begin);
    if (end == std::string::npos) return;
    text.erase(begin, end - begin);
    text[at + 2] = ' ';
    at = begin;
  }
}

YamlNode parseTree(std::string text, const std::string& file) {
  const std::size_t first = text.find_first_not_of(" \t\r\n");
  if (first != std::string::npos && text[first] == '<') return YamlNode::parse(xmlAsYaml(text, file), file);
  if (nlohmann::json::accept(text)) {
    replaceTabs(text);
  } else {
    commentOutDirective(text);
    dropPythonBytes(text);
  }
  // A tree costs a second for three megabytes, and no camera needs one.
  if (text.size() > kMaxTreeBytes) {
    throw inputError({.where = file,
                      .found = std::to_string(text.size()) + " bytes",
                      .expected = "a camera file of at most " + std::to_string(kMaxTreeBytes) + " bytes",
                      .next_step = "leave out what is not the camera, such as lists of images"});
  }
  return YamlNode::parse(text, file);
}

}  // namespace

CameraDocument::CameraDocument(std::string text, std::string file)
    : text_(std::move(text)), file_(std::move(file)) {
  try {
    root_ = parseTree(text_, file_);
  } catch (const Error& e) {
    error_ = e;
  }
}

const YamlNode& CameraDocument::root() const {
  if (!root_) throw *error_;
  return *root_;
}

}  // namespace alidade::detail
