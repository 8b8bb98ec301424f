// SPDX-License-Identifier: MIT
#include "alidade/files/formats/key_check.h"

#include <set>
#include <vector>

#include <yaml-cpp/eventhandler.h>
#include <yaml-cpp/mark.h>

#include "alidade/core/error.h"
#include "alidade/files/utf8_check.h"

namespace alidade::detail {
namespace {

constexpr std::size_t kMaxKeys = 1000;

class KeyChecker final : public YAML::EventHandler {
 public:
  explicit KeyChecker(const std::string& file) : file_(file) {}

  void OnDocumentStart(const YAML::Mark&) override {}
  void OnDocumentEnd() override {}
  void OnNull(const YAML::Mark&, YAML::anchor_t) override { takeValue(); }
  void OnAlias(const YAML::Mark&, YAML::anchor_t) override { takeValue(); }
  void OnScalar(const YAML::Mark& mark, const std::string&, YAML::anchor_t,
                const std::string& text) override {
    if (isKeyNext()) takeKey(mark, text);
    takeValue();
  }
  void OnSequenceStart(const YAML::Mark&, const std::string&, YAML::anchor_t,
                       YAML::EmitterStyle::value) override {
    open_.push_back({.is_map = false});
  }
  void OnSequenceEnd() override { close(); }
  void OnMapStart(const YAML::Mark&, const std::string&, YAML::anchor_t, YAML::EmitterStyle::value) override {
    open_.push_back({.is_map = true});
  }
  void OnMapEnd() override { close(); }

 private:
  struct Open {
    bool is_map = false;
    std::size_t num_nodes = 0;  // keys and values
    std::set<std::string> keys = {};
    std::string last_key = {};
  };

  [[nodiscard]] bool isKeyNext() const {
    return !open_.empty() && open_.back().is_map && open_.back().num_nodes % 2 == 0;
  }

  void takeKey(const YAML::Mark& mark, const std::string& text) {
    open_.back().last_key = text;
    std::set<std::string>& keys = open_.back().keys;
    if (!keys.insert(text).second) complain(mark, "the key '" + text + "' twice", "each key only once");
    if (keys.size() > kMaxKeys)
      complain(mark, "a map with more than " + std::to_string(kMaxKeys) + " keys", "a camera file");
  }

  void takeValue() {
    if (!open_.empty()) ++open_.back().num_nodes;
  }

  void close() {
    open_.pop_back();
    takeValue();
  }

  // "calibration.views[2]", as YamlNode calls it.
  [[nodiscard]] std::string pathOfMap() const {
    std::string path;
    for (std::size_t i = 0; i + 1 < open_.size(); ++i) {
      if (open_[i].is_map) {
        path += (path.empty() ? "" : ".") + open_[i].last_key;
      } else {
        path += "[" + std::to_string(open_[i].num_nodes) + "]";
      }
    }
    return path;
  }

  [[noreturn]] void complain(const YAML::Mark& mark, const std::string& found,
                             const std::string& expected) const {
    const std::string path = pathOfMap();
    throw inputError(
        {.where = file_ + ":" + std::to_string(mark.line + 1) + (path.empty() ? "" : ": " + path),
         .found = "found " + found,
         .expected = expected});
  }

  const std::string& file_;
  std::vector<Open> open_;
};

}  // namespace

YamlNode parseWithUniqueKeys(const std::string& text, const std::string& file) {
  checkUtf8(text, file);  // what XML calls a character may be none
  KeyChecker checker(file);
  return YamlNode::parse(text, file, &checker);
}

}  // namespace alidade::detail
