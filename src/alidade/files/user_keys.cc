// SPDX-License-Identifier: MIT
#include "alidade/files/user_keys.h"

#include <map>
#include <sstream>
#include <vector>

#include <yaml-cpp/eventhandler.h>
#include <yaml-cpp/parser.h>
#include <yaml-cpp/yaml.h>

namespace alidade::detail {
namespace {

// What the parser tells of a document. Nodes of a tree would not say which strings are in quotes.
class Events final : public YAML::EventHandler {
 public:
  void OnDocumentStart(const YAML::Mark&) override {}
  void OnDocumentEnd() override {}
  void OnNull(const YAML::Mark&, YAML::anchor_t anchor) override { add({.kind = kNull, .anchor = anchor}); }
  void OnAlias(const YAML::Mark&, YAML::anchor_t anchor) override {
    events_.push_back({.kind = kAlias, .anchor = anchor});
  }
  void OnScalar(const YAML::Mark&, const std::string& tag, YAML::anchor_t anchor,
                const std::string& value) override {
    add({.kind = kScalar, .anchor = anchor, .tag = tag, .value = value});
  }
  void OnSequenceStart(const YAML::Mark&, const std::string& tag, YAML::anchor_t anchor,
                       YAML::EmitterStyle::value style) override {
    add({.kind = kSequence, .anchor = anchor, .tag = tag, .is_flow = style == YAML::EmitterStyle::Flow});
  }
  void OnSequenceEnd() override { events_.push_back({.kind = kEnd}); }
  void OnMapStart(const YAML::Mark&, const std::string& tag, YAML::anchor_t anchor,
                  YAML::EmitterStyle::value style) override {
    add({.kind = kMap, .anchor = anchor, .tag = tag, .is_flow = style == YAML::EmitterStyle::Flow});
  }
  void OnMapEnd() override { events_.push_back({.kind = kEnd}); }

  // The root's keys of the user, and their values, as entries of a map of `out`.
  void writeUserKeys(YAML::Emitter& out) const {
    Names written;
    std::size_t at = 1;  // behind the root's own start
    while (events_[at].kind != kEnd) {
      const Event& key = events_[at];
      if (key.kind != kScalar || !isUserKey(key.value)) {
        at = behind(behind(at));
        continue;
      }
      out << YAML::Key;
      at = write(out, at, written);
      out << YAML::Value;
      at = write(out, at, written);
    }
  }

 private:
  using Names = std::map<YAML::anchor_t, std::string>;  // of the values that stand already
  enum Kind { kNull, kAlias, kScalar, kSequence, kMap, kEnd };
  struct Event {
    Kind kind = kNull;
    YAML::anchor_t anchor = 0;  // 0 = none
    std::string tag = {};       // "!" of a string in quotes
    std::string value = {};
    bool is_flow = false;
  };

  void add(Event event) {
    if (event.anchor != 0) definitions_[event.anchor] = events_.size();
    events_.push_back(std::move(event));
  }

  // The event that follows the value that begins at one.
  [[nodiscard]] std::size_t behind(std::size_t at) const {
    int depth = 0;
    do {
      const Kind kind = events_[at++].kind;
      if (kind == kSequence || kind == kMap) ++depth;
      if (kind == kEnd) --depth;
    } while (depth > 0);
    return at;
  }

  // Writes the value that begins at an event, and returns the event behind it. A value with a name stands
  // where it is first called for.
  std::size_t write(YAML::Emitter& out, std::size_t at, Names& written) const {
    const Event& event = events_[at];
    if (event.kind == kAlias && !written.contains(event.anchor)) {
      write(out, definitions_.at(event.anchor), written);
      return at + 1;
    }
    if (written.contains(event.anchor)) {
      out << YAML::Alias(written.at(event.anchor));
      return behind(at);
    }
    if (event.anchor != 0) {
      const std::string name = std::to_string(written.size() + 1);
      written.emplace(event.anchor, name);
      out << YAML::Anchor(name);
    }
    if (!event.tag.empty() && event.tag != "?" && event.tag != "!") out << YAML::VerbatimTag(event.tag);
    if (event.is_flow) out << YAML::Flow;
    ++at;
    if (event.kind == kNull) {
      out << YAML::Null;
    } else if (event.kind == kScalar) {
      if (event.tag == "!") out << YAML::DoubleQuoted;
      out << event.value;
    } else {
      out << (event.kind == kMap ? YAML::BeginMap : YAML::BeginSeq);
      while (events_[at].kind != kEnd) {
        if (event.kind == kMap) out << YAML::Key;
        at = write(out, at, written);
        if (event.kind != kMap) continue;
        out << YAML::Value;
        at = write(out, at, written);
      }
      out << (event.kind == kMap ? YAML::EndMap : YAML::EndSeq);
      ++at;
    }
    return at;
  }

  std::vector<Event> events_;
  std::map<YAML::anchor_t, std::size_t> definitions_;  // by anchor, where its value begins
};

}  // namespace

std::string userKeys(const std::string& text) {
  std::istringstream stream(text);
  YAML::Parser parser(stream);
  Events events;
  parser.HandleNextDocument(events);
  YAML::Emitter out;
  out << YAML::BeginMap;
  events.writeUserKeys(out);
  out << YAML::EndMap;
  const std::string lines(out.c_str(), out.size());
  return lines == "{}" ? "" : lines + "\n";
}

}  // namespace alidade::detail
