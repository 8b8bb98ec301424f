// SPDX-License-Identifier: MIT
#include "alidade/files/formats/notations.h"

#include <algorithm>
#include <cctype>
#include <map>
#include <sstream>
#include <stdexcept>
#include <string_view>
#include <utility>
#include <vector>

#include <nlohmann/json.hpp>
#include <pugixml.hpp>

#include "alidade/core/text.h"
#include "alidade/files/text/file_text.h"

// Damaged text meets assertions of the TOML parser, which are errors here, in release builds too.
namespace alidade::detail {
constexpr void requireInToml(bool is_met) {
  if (!is_met) throw std::logic_error("text that cannot be parsed");
}
}  // namespace alidade::detail
#undef NDEBUG
#define TOML_ASSERT(expr) alidade::detail::requireInToml(static_cast<bool>(expr))
#define TOML_HEADER_ONLY 1
#define TOML_ENABLE_FORMATTERS 0
#include <toml++/toml.h>

namespace alidade::detail {
namespace {

std::string placeOf(const std::string& file, std::ptrdiff_t line) {
  return file + ":" + std::to_string(line);
}

bool areNumbers(const std::vector<std::string>& values) {
  return std::ranges::all_of(values, [](const std::string& value) { return parseDouble(value).has_value(); });
}

// Numbers separated by blanks are a list, anything else is one text.
std::string numbersOrText(std::string_view text) {
  const std::vector<std::string> values = words(text);
  return values.size() > 1 && areNumbers(values) ? "[" + join(values, ", ") + "]" : quotedYaml(trim(text));
}

// Writes a tree in flow style, with line breaks so that each key is on the line of its source, as far as
// lines ascend.
class TreeWriter {
 public:
  TreeWriter(std::string_view source, const std::string& file) : source_(source), file_(file) {}

  void goToLine(std::ptrdiff_t line) {
    for (; line_ < line; ++line_) out_ += '\n';
  }
  // Elements are in text order, so each line is counted once.
  void goToOffset(std::ptrdiff_t offset) {
    const std::size_t end =
        std::min(static_cast<std::size_t>(std::max<std::ptrdiff_t>(offset, 0)), source_.size());
    for (; offset_ < end; ++offset_) counted_ += source_[offset_] == '\n' ? 1 : 0;
    goToLine(counted_);
  }
  void key(std::string_view name) { out_ += quotedYaml(name) + ": "; }
  void open(char bracket) {
    if (++depth_ > kMaxDepth) {
      throw errorAt(placeOf(file_, line_),
                    "found elements nested more than " + std::to_string(kMaxDepth) + " levels deep",
                    "a few levels");
    }
    out_ += bracket;
  }
  void close(char bracket) {
    --depth_;
    out_ += bracket;
  }
  void raw(std::string_view text) { out_ += text; }
  // One value is a scalar, which also serves as a list of one.
  void values(const std::vector<std::string>& values) {
    if (values.size() == 1) {
      out_ += quotedYaml(values.front());
      return;
    }
    out_ += '[';
    for (const std::string& value : values) out_ += quotedYaml(value) + ", ";
    out_ += ']';
  }

  [[nodiscard]] std::string text() && { return std::move(out_); }

 private:
  std::string_view source_;
  const std::string& file_;
  std::string out_;
  std::ptrdiff_t line_ = 1;
  std::size_t offset_ = 0;
  std::ptrdiff_t counted_ = 1;
  int depth_ = 0;
};

// Values separated by blanks; quoted text is one value.
std::vector<std::string> valuesOf(const char* text) {
  std::istringstream stream(text);
  std::vector<std::string> values;
  for (std::string value; stream >> std::quoted(value, '"', '\0');) values.push_back(value);
  return values;
}

std::vector<pugi::xml_node> elementsOf(const pugi::xml_node& parent) {
  std::vector<pugi::xml_node> children;
  for (const pugi::xml_node& child : parent.children()) {
    if (child.type() == pugi::node_element) children.push_back(child);
  }
  return children;
}

// Of OpenCV's FileStorage: values separated by blanks are a list, and attributes say nothing.
void writeElement(const pugi::xml_node& element, bool is_opencv, TreeWriter& out) {
  const std::vector<pugi::xml_node> rest = elementsOf(element);
  if (is_opencv && rest.empty()) return out.values(valuesOf(element.text().get()));
  if (rest.empty() && !element.first_attribute()) return out.raw(numbersOrText(element.text().get()));
  const auto writeList = [&](auto begin, auto end) {
    out.open('[');
    for (auto item = begin; item != end; ++item) {
      out.goToOffset(item->offset_debug());
      writeElement(*item, is_opencv, out);
      out.raw(", ");
    }
    out.close(']');
  };
  if (!rest.empty() && std::string_view(rest.front().name()) == "_")
    return writeList(rest.begin(), rest.end());
  out.open('{');
  for (const pugi::xml_attribute& attribute : element.attributes()) {
    if (is_opencv) break;
    out.key(attribute.name());
    out.raw(numbersOrText(attribute.value()));
    out.raw(", ");
  }
  // By name, in the order of the first of each.
  std::vector<std::vector<pugi::xml_node>> groups;
  std::map<std::string_view, std::size_t> group_of;
  for (const pugi::xml_node& child : rest) {
    const std::size_t group = group_of.try_emplace(child.name(), groups.size()).first->second;
    // OpenCV has no such lists: a second one is reported as a duplicate key.
    if (is_opencv || group == groups.size()) groups.emplace_back();
    groups[is_opencv ? groups.size() - 1 : group].push_back(child);
  }
  for (const std::vector<pugi::xml_node>& group : groups) {
    out.goToOffset(group.front().offset_debug());
    out.key(group.front().name());
    group.size() > 1 ? writeList(group.begin(), group.end()) : writeElement(group.front(), is_opencv, out);
    out.raw(", ");
  }
  out.close('}');
}

std::string xmlAsYaml(const std::string& text, const std::string& file) {
  pugi::xml_document document;
  const pugi::xml_parse_result parsed =
      document.load_buffer(text.data(), text.size(), pugi::parse_default, pugi::encoding_utf8);
  if (!parsed) {
    throw errorAt(placeOf(file, lineAt(text, static_cast<std::size_t>(parsed.offset))),
                  std::string("found text that is not valid XML: ") + parsed.description(), "XML",
                  "correct the file near that line");
  }
  TreeWriter out(text, file);
  const pugi::xml_node root = document.document_element();
  const bool is_opencv = std::string_view(root.name()) == "opencv_storage";
  if (!is_opencv) out.open('{');
  if (!is_opencv) out.key(root.name());
  writeElement(root, is_opencv, out);
  if (!is_opencv) out.close('}');
  return std::move(out).text();
}

// Refuses a dotted key of very many parts before it becomes as many nested tables, which are destroyed
// recursively. Strings and comments are skipped as TOML defines them.
void checkDottedKeys(std::string_view text, const std::string& file) {
  constexpr int kMaxParts = 16;
  int num_dots = 0;
  for (std::size_t at = 0; at < text.size(); ++at) {
    const char c = text[at];
    if (c == '"' || c == '\'') {
      const std::string quotes(3, c);
      const bool is_long = text.substr(at, 3) == quotes;
      for (at += is_long ? 3 : 1; at < text.size(); ++at) {
        if (c == '"' && text[at] == '\\') {
          ++at;
        } else if (is_long ? text.substr(at, 3) == quotes : text[at] == c || text[at] == '\n') {
          break;
        }
      }
      if (is_long) at += 2;
    } else if (c == '#') {
      at = std::min(text.find('\n', at), text.size());
      num_dots = 0;
    } else if (c == '.') {
      if (++num_dots > kMaxParts)
        throw errorAt(placeOf(file, lineAt(text, at)), "found a key of more than 16 parts", "a few");
    } else if (std::string_view("=,[]{}\n").find(c) != std::string_view::npos) {
      num_dots = 0;
    }
  }
}

void writeToml(const toml::node& node, TreeWriter& out) {
  if (const toml::table* table = node.as_table()) {
    // Tables are sorted by name; in the order of the file the lines ascend.
    std::vector<std::pair<std::string_view, const toml::node*>> entries;
    for (const auto& [key, value] : *table) entries.emplace_back(key.str(), &value);
    std::ranges::stable_sort(entries, {},
                             [](const auto& entry) { return entry.second->source().begin.line; });
    out.open('{');
    for (const auto& [name, value] : entries) {
      out.goToLine(value->source().begin.line);
      out.key(name);
      writeToml(*value, out);
      out.raw(", ");
    }
    out.close('}');
  } else if (const toml::array* array = node.as_array()) {
    out.open('[');
    for (const toml::node& item : *array) {
      out.goToLine(item.source().begin.line);
      writeToml(item, out);
      out.raw(", ");
    }
    out.close(']');
  } else if (const auto text = node.value_exact<std::string_view>()) {
    out.raw(quotedYaml(*text));
  } else if (const auto flag = node.value_exact<bool>()) {
    out.raw(*flag ? "true" : "false");
  } else if (const auto whole = node.value_exact<std::int64_t>()) {
    out.raw(std::to_string(*whole));
  } else if (const auto number = node.value_exact<double>()) {
    out.raw(exactText(*number));
  } else {
    out.raw("a date");
  }
}

std::string tomlAsYaml(const std::string& text, const std::string& file) {
  checkDottedKeys(text, file);
  try {
    const toml::table root = toml::parse(text);
    TreeWriter out(text, file);
    writeToml(root, out);
    return std::move(out).text();
  } catch (const toml::parse_error& e) {
    throw errorAt(placeOf(file, e.source().begin.line),
                  "found text that is not valid TOML: " + std::string(e.description()), "TOML",
                  "correct the file near that line");
  } catch (const std::logic_error& e) {
    throw errorAt(file, "found " + std::string(e.what()), "TOML");
  }
}

// What a line of an INI or TOML file is.
enum class LineKind { kBlank, kSection, kEntry, kOther };

LineKind kindOf(std::string_view line) {
  line = trim(line);
  if (line.empty() || line.front() == '#' || line.front() == ';') return LineKind::kBlank;
  const std::size_t end = line.find_last_of(']');
  if (line.front() == '[' && end != std::string_view::npos) {
    const std::string_view after = trim(line.substr(end + 1));
    const bool has_name = line.substr(1, end - 1).find_first_of(",{") == std::string_view::npos;
    if (has_name && (after.empty() || after.front() == '#')) return LineKind::kSection;
  }
  const std::size_t equals = line.find('=');
  const bool is_key = equals != std::string_view::npos && equals > 0 &&
                      line.substr(0, equals).find_first_of(":{[(<,") == std::string_view::npos;
  return is_key ? LineKind::kEntry : LineKind::kOther;
}

// Line by line; nothing for text that is not INI.
std::optional<std::string> iniAsYaml(const std::string& text) {
  std::string yaml;
  std::string_view indent = "";
  for (const std::string_view whole : split(text, '\n')) {
    const std::string_view line = trim(whole);
    const LineKind kind = kindOf(line);
    if (kind == LineKind::kOther) return std::nullopt;
    if (kind == LineKind::kSection) {
      yaml += quotedYaml(trim(line.substr(1, line.find_last_of(']') - 1))) + ":";
      indent = " ";
    } else if (kind == LineKind::kEntry) {
      const std::size_t equals = line.find('=');
      yaml += std::string(indent) + quotedYaml(trim(line.substr(0, equals))) + ": " +
              numbersOrText(line.substr(equals + 1));
    }
    yaml += '\n';
  }
  return yaml;
}

// TOML and INI start with a section or an entry; YAML and JSON with neither.
std::optional<std::string> tomlOrIniAsYaml(const std::string& text, const std::string& file) {
  const auto lines = split(text, '\n');
  const auto first =
      std::ranges::find_if(lines, [](std::string_view line) { return kindOf(line) != LineKind::kBlank; });
  constexpr std::size_t kMaxSize = 4U << 20U;
  if (first == lines.end() || kindOf(*first) == LineKind::kOther || text.size() > kMaxSize)
    return std::nullopt;
  try {
    return tomlAsYaml(text, file);
  } catch (const Error&) {
    if (file.ends_with(".toml")) throw;
    if (auto ini = iniAsYaml(text)) return ini;
    if (kindOf(*first) == LineKind::kSection) throw;
    return std::nullopt;
  }
}

// One object a line, at least two.
std::optional<std::string> jsonLinesAsYaml(const std::string& text) {
  std::string yaml = "[";
  int num_objects = 0;
  for (const std::string_view line : split(text, '\n')) {
    const bool is_empty = trim(line).empty();
    if (!is_empty && (trim(line).front() != '{' || !nlohmann::json::accept(line))) return std::nullopt;
    num_objects += is_empty ? 0 : 1;
    yaml += std::string(line) + (is_empty ? "\n" : ",\n");
  }
  if (num_objects < 2) return std::nullopt;
  std::ranges::replace(yaml, '\t', ' ');
  return yaml + "]";
}

}  // namespace

std::string quotedYaml(std::string_view text) {
  std::string quoted = "\"";
  for (const char c : text) {
    if (c == '"' || c == '\\') quoted += '\\';
    quoted += static_cast<unsigned char>(c) < ' ' ? ' ' : c;
  }
  return quoted + '"';
}

std::optional<std::string> otherNotationAsYaml(const std::string& text, const std::string& file) {
  const std::size_t first = text.find_first_not_of(" \t\r\n");
  if (first == std::string::npos) return std::nullopt;
  if (text[first] == '<') return xmlAsYaml(text, file);
  if (text[first] == '{') return jsonLinesAsYaml(text);
  return tomlOrIniAsYaml(text, file);
}

std::string numberLinesAsLists(const std::string& text) {
  static const std::vector<std::string> kStems = words(
      "S_ K_ D_ R_ T_ P_ P S_rect_ R_rect_ P_rect_ R_rect R0_rect Tr Tr_velo_to_cam Tr_imu_to_velo "
      "Tr_velo_cam Tr_cam_to_road");
  std::string lists;
  for (const std::string_view line : split(text, '\n')) {
    const std::string_view key = line.substr(0, line.find(": "));
    const std::string_view stem = key.substr(0, key.find_last_not_of("0123456789") + 1);
    const bool is_entry = key.size() < line.size() && std::ranges::find(kStems, stem) != kStems.end();
    const std::string value = is_entry ? numbersOrText(line.substr(key.size() + 1)) : "";
    lists += value.starts_with('[') ? std::string(key) + ": " + value : std::string(line);
    lists += '\n';
  }
  lists.pop_back();
  return lists;
}

std::optional<std::string> dsoAsYaml(std::string_view text) {
  std::vector<std::vector<std::string>> lines;
  for (const std::string_view line : split(text, '\n')) {
    if (lines.size() > 4) return std::nullopt;
    if (!trim(line).empty() || lines.empty()) lines.push_back(words(line));
  }
  const auto isPair = [&lines](std::size_t i) { return lines[i].size() == 2 && areNumbers(lines[i]); };
  if (lines.size() != 4 || lines[0].empty() || !isPair(1) || !isPair(3)) return std::nullopt;
  std::string name = parseDouble(lines[0][0]) ? "" : lines[0][0];
  if (!name.empty()) lines[0].erase(lines[0].begin());
  if (!areNumbers(lines[0]) || (lines[0].size() != 5 && lines[0].size() != 8)) return std::nullopt;
  if (name.empty())
    name = lines[0].size() == 8 ? "RadTan" : parseDouble(lines[0][4]) == 0.0 ? "Pinhole" : "FOV";
  return "{dso_model: " + quotedYaml(name) + ", numbers: [" + join(lines[0], ", ") + "],\nsize: [" +
         join(lines[1], ", ") + "]}";
}

}  // namespace alidade::detail
