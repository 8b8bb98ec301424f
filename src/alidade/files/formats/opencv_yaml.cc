// SPDX-License-Identifier: MIT
// cv::FileStorage's parser (OpenCV's modules/core/src/persistence_yml.cpp) ends a key at the colon, whatever
// comes next.
#include "alidade/files/formats/opencv_yaml.h"

#include <cctype>
#include <string_view>
#include <utility>

namespace alidade::detail {
namespace {

bool isKeyCharacter(char c) {
  return std::isalnum(static_cast<unsigned char>(c)) != 0 || c == '_' || c == '.' || c == '-';
}

bool isSpace(char c) {
  return c == ' ' || c == '\t' || c == '\r' || c == '\n';
}

// Where a key at the start of the line that begins at `begin` has its colon, right behind which a value
// starts; npos if there is no such thing.
std::size_t tightColonOf(const std::string& text, std::size_t begin) {
  std::size_t i = begin;
  while (i < text.size() && text[i] == ' ') ++i;
  if (i == text.size() || (std::isalpha(static_cast<unsigned char>(text[i])) == 0 && text[i] != '_'))
    return std::string::npos;
  while (i < text.size() && isKeyCharacter(text[i])) ++i;
  const bool is_tight = i + 1 < text.size() && text[i] == ':' && !isSpace(text[i + 1]);
  return is_tight ? i : std::string::npos;
}

// Follows a text through its parts in quotation marks and its comments.
class Scanner {
 public:
  [[nodiscard]] bool isInQuotes() const { return quote_ != '\0'; }

  void take(char c) {
    const bool is_escaped = std::exchange(is_escaped_, false);
    const bool is_just_closed = std::exchange(is_just_closed_, false);
    if (isInQuotes()) {
      is_escaped_ = quote_ == '"' && c == '\\' && !is_escaped;
      is_just_closed_ = c == quote_ && !is_escaped;
      if (is_just_closed_) quote_ = '\0';
      last_ = last_mark_ = c;
      return;
    }
    if (is_comment_) {
      is_comment_ = c != '\n';
    } else if (c == '#') {
      is_comment_ = isSpace(last_);  // "a#b" is none
    } else if (c == '\'' || c == '"') {
      // They open a text only where a value may start, not in "don't"; but '' within one goes on with it.
      const auto isOneOf = [](std::string_view marks, char mark) {
        return marks.find(mark) != std::string_view::npos;
      };
      const bool is_start = (isSpace(last_) || isOneOf("[{,:", last_)) && isOneOf("\n[{,:-", last_mark_);
      if (is_start || (c == '\'' && is_just_closed && last_ == '\'')) quote_ = c;
    }
    last_ = c;
    if (!isSpace(c) || c == '\n') last_mark_ = c;
  }

 private:
  char quote_ = '\0';
  char last_ = '\n';
  char last_mark_ = '\n';  // but blanks
  bool is_escaped_ = false;
  bool is_comment_ = false;
  bool is_just_closed_ = false;
};

}  // namespace

bool isOpenCvYaml(const std::string& text) {
  return text.starts_with("%YAML:");
}

std::string openCvAsYaml(const std::string& text) {
  std::string yaml;
  yaml.reserve(text.size() + 64);
  Scanner scanner;
  std::size_t colon = std::string::npos;
  for (std::size_t i = 0; i < text.size(); ++i) {
    if ((i == 0 || text[i - 1] == '\n') && !scanner.isInQuotes()) colon = tightColonOf(text, i);
    scanner.take(text[i]);
    yaml += text[i];
    if (i == colon) yaml += ' ';
  }
  yaml.front() = '#';  // what YAML does not know as a directive stays as a comment
  return yaml;
}

}  // namespace alidade::detail
