// SPDX-License-Identifier: MIT
#include "alidade/files/formats/ros_messages.h"

#include <algorithm>
#include <optional>
#include <string_view>

#include "alidade/core/error.h"
#include "alidade/core/text.h"

namespace alidade::detail {
namespace {

// The lines of a text, one after the other.
class Lines {
 public:
  explicit Lines(std::string_view text) : text_(text) {}

  // Nothing behind the last one.
  std::optional<std::string_view> next() {
    if (end_ >= text_.size()) return std::nullopt;
    const std::size_t begin = end_;
    const std::size_t newline = std::min(text_.find('\n', begin), text_.size());
    end_ = newline + 1;
    ++number_;
    return text_.substr(begin, newline - begin);
  }

  [[nodiscard]] std::size_t number() const { return number_; }  // of the last one, from 1
  [[nodiscard]] std::size_t end() const { return std::min(end_, text_.size()); }

 private:
  std::string_view text_;
  std::size_t end_ = 0;
  std::size_t number_ = 0;
};

struct Message {
  std::string said = {};  // without the header
  std::size_t line = 0;   // from 1
  std::size_t end = 0;    // in the text
};

// The next message; nothing where there is none.
std::optional<Message> nextMessage(Lines& lines) {
  std::optional<Message> message;
  bool is_in_header = false;
  while (const auto whole = lines.next()) {
    const std::string_view line = trim(*whole);
    if (line == "---") {
      if (message) break;
      continue;
    }
    if (line.empty()) continue;
    if (!message) message = Message{.said = "", .line = lines.number(), .end = 0};
    message->end = lines.end();
    is_in_header = whole->starts_with("header:") || (is_in_header && whole->front() == ' ');
    if (!is_in_header) message->said += std::string(line) + "\n";
  }
  return message;
}

}  // namespace

std::string onlyMessage(const std::string& text, const std::string& file) {
  const std::size_t first = text.find_first_not_of(" \t\r\n-");
  if (first == std::string::npos || text.compare(first, 7, "header:") != 0) return text;
  Lines lines(text);
  const auto message = nextMessage(lines);
  if (!message || message->said.find("distortion_model:") == std::string::npos) return text;
  while (const auto other = nextMessage(lines)) {
    if (other->said == message->said) continue;
    throw inputError(
        {.where = file + ":" + std::to_string(other->line),
         .found = "found a message that differs from the first one in this file",
         .expected = "messages of one camera that differ only in their headers",
         .next_step = "record only one: rostopic echo -n 1 TOPIC, or ros2 topic echo --once TOPIC"});
  }
  return text.substr(0, message->end);
}

bool isCalibratorIni(const std::string& text) {
  Lines lines(text);
  while (const auto whole = lines.next()) {
    const std::string_view line = trim(*whole);
    if (line.empty() || line.front() == '#') continue;
    return line == "[image]" && text.find("camera matrix") != std::string::npos;
  }
  return false;
}

}  // namespace alidade::detail
