// SPDX-License-Identifier: MIT
#include "alidade/files/text/yaml_node.h"

#include <algorithm>
#include <cmath>
#include <sstream>

#include <yaml-cpp/depthguard.h>
#include <yaml-cpp/eventhandler.h>
#include <yaml-cpp/parser.h>

#include "alidade/core/mapped.h"
#include "alidade/core/text.h"
#include "alidade/files/text/atomic_file.h"

namespace alidade::detail {
namespace {

// "cam.yaml:4"
std::string placeInFile(const std::string& file, const YAML::Mark& mark) {
  return mark.is_null() ? file : file + ":" + std::to_string(mark.line + 1);
}

// Ignores the content of a document.
class DocumentSkipper final : public YAML::EventHandler {
 public:
  void OnDocumentStart(const YAML::Mark&) override {}
  void OnDocumentEnd() override {}
  void OnNull(const YAML::Mark&, YAML::anchor_t) override {}
  void OnAlias(const YAML::Mark&, YAML::anchor_t) override {}
  void OnScalar(const YAML::Mark&, const std::string&, YAML::anchor_t, const std::string&) override {}
  void OnSequenceStart(const YAML::Mark&, const std::string&, YAML::anchor_t,
                       YAML::EmitterStyle::value) override {}
  void OnSequenceEnd() override {}
  void OnMapStart(const YAML::Mark&, const std::string&, YAML::anchor_t, YAML::EmitterStyle::value) override {
  }
  void OnMapEnd() override {}
};

// Counts up to two: YAML::LoadAll() never ends if a stray bracket or comma makes it read empty documents.
int countDocuments(const std::string& text) {
  std::istringstream stream(text);
  YAML::Parser parser(stream);
  DocumentSkipper skipper;
  if (!parser.HandleNextDocument(skipper)) return 0;
  return parser.HandleNextDocument(skipper) ? 2 : 1;
}

}  // namespace

YamlNode YamlNode::parse(const std::string& text, const std::string& file) {
  if (text.starts_with("%YAML:1.0")) {
    throw errorAt(file + ":1", "found %YAML:1.0, which marks OpenCV's own format", "YAML 1.2",
                  "OpenCV files are accepted only as camera files");
  }
  try {
    const int num_documents = countDocuments(text);
    if (num_documents == 0) {
      throw errorAt(file, text.empty() ? "an empty file" : "a file with only spaces and comments",
                    "YAML or JSON",
                    "check the path, and whether the program that wrote the file was interrupted");
    }
    if (num_documents > 1) {
      throw errorAt(file, "at least 2 YAML documents", "one",
                    "keep only one; they are separated by lines with ---");
    }
    YamlNode root(YAML::Load(text), file, "");
    std::set<std::pair<int, bool>> seen;
    root.checkKeys(seen);
    return root;
  } catch (const YAML::DeepRecursion& e) {
    throw errorAt(placeInFile(file, e.mark),
                  "lists or maps nested more than " + std::to_string(e.depth()) + " levels deep",
                  "a few levels", "check for brackets or dashes that were repeated by mistake");
  } catch (const YAML::Exception& e) {
    throw errorAt(placeInFile(file, e.mark), "not valid YAML: " + e.msg, "YAML 1.2",
                  "correct the file near that line");
  }
}

YamlNode YamlNode::readFile(const std::string& path) {
  return parse(readTextFile(path, kMaxBytes), path);
}

void YamlNode::allowKeys(const std::vector<std::string>& allowed) const {
  if (!node_.IsMap()) throw error(describe(), "a map with the keys " + join(allowed, ", "));
  for (const auto& entry : node_) {
    const YamlNode key(entry.first, file_, path_);
    const std::string name = key.text();
    if (isUserKey(name) || std::find(allowed.begin(), allowed.end(), name) != allowed.end()) continue;
    throw key.error("unknown key '" + name + "'", "one of " + join(allowed, ", "),
                    didYouMean(name, allowed, "your own keys must start with x_"));
  }
}

// `seen` contains positions of lists and maps: an alias has the position of its value, whose keys are checked
// once, so that shared values do not expand.
void YamlNode::checkKeys(std::set<std::pair<int, bool>>& seen) const {
  constexpr std::size_t kMaxKeys = 1000;
  if (!(isMap() || isSequence()) || !seen.emplace(node_.Mark().pos, isMap()).second) return;
  if (isSequence()) {
    for (const YamlNode& item : items()) item.checkKeys(seen);
    return;
  }
  std::set<std::string> names;
  for (const auto& entry : node_) {
    if (!entry.first.IsScalar()) continue;
    const std::string& name = entry.first.Scalar();
    const YamlNode key(entry.first, file_, path_);
    if (!names.insert(name).second && !isCommentKey(name))
      throw key.error("the key '" + name + "' twice", "each key only once");
    if (names.size() > kMaxKeys)
      throw key.error("a map with more than " + std::to_string(kMaxKeys) + " keys", "fewer");
    YamlNode(entry.second, file_, path_.empty() ? name : path_ + "." + name).checkKeys(seen);
  }
}

bool YamlNode::has(const std::string& key) const {
  const YAML::Node& node = node_;
  return node.IsMap() && node[key].IsDefined();
}

YamlNode YamlNode::at(const std::string& key) const {
  if (!node_.IsMap()) throw error(describe(), "a map with the key '" + key + "'");
  if (!has(key)) {
    const std::string present = join(keys(), ", ");
    throw error("no key '" + key + "'",
                "'" + key + "'" + (present.empty() ? "" : " in addition to " + present), "add it");
  }
  const YAML::Node& node = node_;
  return {node[key], file_, path_.empty() ? key : path_ + "." + key};
}

std::optional<YamlNode> YamlNode::find(const std::string& key) const {
  if (!has(key)) return std::nullopt;
  return at(key);
}

std::vector<std::string> YamlNode::keys() const {
  if (!node_.IsMap()) throw error(describe(), "a map");
  return mapped(node_, [&](const auto& entry) { return YamlNode(entry.first, file_, path_).text(); });
}

int YamlNode::lineOfKey(const std::string& key) const {
  if (!node_.IsMap()) return 0;
  for (const auto& entry : node_) {
    if (!entry.first.IsScalar() || entry.first.Scalar() != key) continue;
    const YAML::Mark mark = entry.first.Mark();
    return mark.is_null() ? 0 : mark.line + 1;
  }
  return 0;
}

std::vector<YamlNode> YamlNode::items(std::size_t most) const {
  if (!node_.IsSequence()) throw error(describe(), "a list");
  std::vector<YamlNode> all;
  for (std::size_t i = 0; i < std::min(most, node_.size()); ++i) {
    const YAML::Node& node = node_;
    all.push_back({node[i], file_, path_ + "[" + std::to_string(i) + "]"});
  }
  return all;
}

std::string YamlNode::text() const {
  if (!node_.IsScalar()) throw error(describe(), "a single value");
  return node_.Scalar();
}

std::vector<std::string> YamlNode::texts() const {
  if (!isSequence()) return {text()};
  return mapped(items(), &YamlNode::text);
}

double YamlNode::number() const {
  if (!node_.IsScalar()) throw error(describe(), "a number");
  const auto value = parseDouble(node_.Scalar());
  if (!value || !std::isfinite(*value)) throw error("'" + node_.Scalar() + "'", "a finite number");
  return *value;
}

int YamlNode::integer() const {
  if (!node_.IsScalar()) throw error(describe(), "a whole number");
  const auto value = parseInt(node_.Scalar());
  if (!value) throw error("'" + node_.Scalar() + "'", "a whole number");
  return *value;
}

bool YamlNode::boolean() const {
  const std::string value = text();
  if (value == "true") return true;
  if (value == "false") return false;
  throw error("'" + value + "'", "true or false");
}

std::vector<double> YamlNode::numbers(std::size_t count) const {
  std::vector<double> values = mapped(items(), &YamlNode::number);
  if (count != 0 && values.size() != count) {
    throw error(std::to_string(values.size()) + (values.size() == 1 ? " number" : " numbers"),
                std::to_string(count));
  }
  return values;
}

std::string YamlNode::where() const {
  std::string place = placeInFile(file_, node_.Mark());
  if (!path_.empty()) place += ": " + path_;
  return place;
}

std::string YamlNode::whereKey(const std::string& key) const {
  const int line = lineOfKey(key);
  return file_ + (line > 0 ? ":" + std::to_string(line) : "") + ": " + (path_.empty() ? "" : path_ + ".") +
         key;
}

Error YamlNode::error(const std::string& found, const std::string& expected,
                      const std::string& next_step) const {
  return errorAt(where(), "found " + found, expected, next_step);
}

std::string YamlNode::describe() const {
  switch (node_.Type()) {
    case YAML::NodeType::Map:
      return "a map";
    case YAML::NodeType::Sequence:
      return "a list";
    case YAML::NodeType::Scalar:
      return "'" + node_.Scalar() + "'";
    default:
      return "nothing";
  }
}

}  // namespace alidade::detail
