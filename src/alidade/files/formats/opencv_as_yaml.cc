// SPDX-License-Identifier: MIT
#include "alidade/files/formats/opencv_as_yaml.h"

#include <algorithm>
#include <cctype>
#include <iomanip>
#include <sstream>
#include <string_view>
#include <utility>
#include <vector>

#include <pugixml.hpp>

#include "alidade/files/file_text.h"

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

constexpr int kMaxDepth = 100;

// Values that blanks separate; what stands in quotation marks is one.
std::vector<std::string> valuesOf(const char* text) {
  std::istringstream stream(text);
  std::vector<std::string> values;
  for (std::string value; stream >> std::quoted(value, '"', '\0');) values.push_back(value);
  return values;
}

// Writes the tree element by element and starts new lines so that each key stands where its element starts.
class XmlWriter {
 public:
  XmlWriter(const std::string& source, const std::string& file) : source_(source), file_(file) {}

  void writeElement(const pugi::xml_node& element, int depth) {
    if (depth > kMaxDepth) {
      throw inputError(
          {.where = file_ + ":" +
                    std::to_string(lineAt(source_, static_cast<std::size_t>(element.offset_debug()))),
           .found = "found elements nested deeper than " + std::to_string(kMaxDepth) + " deep",
           .expected = "a few levels"});
    }
    std::vector<pugi::xml_node> children;
    for (const pugi::xml_node& child : element.children()) {
      if (child.type() == pugi::node_element) children.push_back(child);
    }
    if (children.empty()) {
      writeValues(valuesOf(element.text().get()));
      return;
    }
    const bool is_list = std::string_view(children.front().name()) == "_";
    out_ += is_list ? "[" : "{";
    for (const pugi::xml_node& child : children) {
      goToLineOf(child);
      if (!is_list) out_ += quoted(child.name()) + ": ";
      writeElement(child, depth + 1);
      out_ += ", ";
    }
    out_ += is_list ? "]" : "}";
  }

  [[nodiscard]] std::string text() && { return std::move(out_); }

 private:
  // Elements come in the order of the text, so lines are counted once.
  void goToLineOf(const pugi::xml_node& element) {
    const auto offset = std::min(static_cast<std::size_t>(element.offset_debug()), source_.size());
    for (; offset_ < offset; ++offset_) {
      if (source_[offset_] == '\n') out_ += '\n';
    }
  }

  // One value is a scalar. Whoever wants a list of one takes it from a scalar too.
  void writeValues(const std::vector<std::string>& values) {
    if (values.size() == 1) {
      out_ += quoted(values.front());
      return;
    }
    out_ += '[';
    for (const std::string& value : values) out_ += quoted(value) + ", ";
    out_ += ']';
  }

  static std::string quoted(std::string_view value) {
    std::string text = "\"";
    for (const char c : value) {
      if (c == '"' || c == '\\') text += '\\';
      text += static_cast<unsigned char>(c) < ' ' ? ' ' : c;
    }
    return text + '"';
  }

  const std::string& source_;
  const std::string& file_;
  std::string out_;
  std::size_t offset_ = 0;
};

}  // namespace

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

std::string openCvXmlAsYaml(const std::string& text, const std::string& file) {
  pugi::xml_document document;
  const pugi::xml_parse_result parsed =
      document.load_buffer(text.data(), text.size(), pugi::parse_default, pugi::encoding_utf8);
  if (!parsed) {
    throw inputError(
        {.where = file + ":" + std::to_string(lineAt(text, static_cast<std::size_t>(parsed.offset))),
         .found = std::string("found text that is not valid XML: ") + parsed.description(),
         .expected = "XML as OpenCV writes it",
         .next_step = "correct the file near that line"});
  }
  const pugi::xml_node root = document.child("opencv_storage");
  if (!root) {
    throw inputError(
        {.where = file,
         .found = std::string("found XML with the root <") + document.document_element().name() + ">",
         .expected = "<opencv_storage>, as OpenCV writes it"});
  }
  XmlWriter writer(text, file);
  writer.writeElement(root, 0);
  return std::move(writer).text();
}

}  // namespace alidade::detail
