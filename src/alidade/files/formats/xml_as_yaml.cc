// SPDX-License-Identifier: MIT
#include "alidade/files/formats/xml_as_yaml.h"

#include <algorithm>
#include <cctype>
#include <string_view>
#include <vector>

#include <pugixml.hpp>

#include "alidade/core/error.h"
#include "alidade/core/text.h"

namespace alidade::detail {
namespace {

constexpr int kMaxDepth = 100;

int lineAt(const std::string& text, std::ptrdiff_t offset) {
  const auto length = std::clamp<std::ptrdiff_t>(offset, 0, static_cast<std::ptrdiff_t>(text.size()));
  return 1 + static_cast<int>(std::count(text.begin(), text.begin() + length, '\n'));
}

// Values that blanks separate; what stands in quotation marks is one.
std::vector<std::string> valuesOf(std::string_view text) {
  std::vector<std::string> values;
  std::size_t i = 0;
  while (i < text.size()) {
    if (std::isspace(static_cast<unsigned char>(text[i])) != 0) {
      ++i;
      continue;
    }
    std::size_t end = i + 1;
    if (text[i] == '"') {
      end = text.find('"', i + 1);
      if (end == std::string_view::npos) end = text.size();
      values.emplace_back(text.substr(i + 1, end - i - 1));
      i = end + 1;
      continue;
    }
    while (end < text.size() && std::isspace(static_cast<unsigned char>(text[end])) == 0) ++end;
    values.emplace_back(text.substr(i, end - i));
    i = end;
  }
  return values;
}

// Writes the tree element by element and starts new lines so that each key stands where its element starts.
class Writer {
 public:
  Writer(const std::string& source, const std::string& file) : source_(source), file_(file) {}

  void writeElement(const pugi::xml_node& element, int depth) {
    if (depth > kMaxDepth) {
      throw inputError({.where = file_ + ":" + std::to_string(lineAt(source_, element.offset_debug())),
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

std::string xmlAsYaml(const std::string& text, const std::string& file) {
  pugi::xml_document document;
  const pugi::xml_parse_result parsed =
      document.load_buffer(text.data(), text.size(), pugi::parse_default, pugi::encoding_utf8);
  if (!parsed) {
    throw inputError({.where = file + ":" + std::to_string(lineAt(text, parsed.offset)),
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
  Writer writer(text, file);
  writer.writeElement(root, 0);
  return std::move(writer).text();
}

}  // namespace alidade::detail
