// SPDX-License-Identifier: MIT
#include "alidade/target/board_spec.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <variant>

#include "alidade/core/aliases.h"
#include "alidade/core/error.h"
#include "alidade/core/mapped.h"
#include "alidade/core/text.h"

namespace alidade {
namespace {

// A SPEC during parsing, for the messages.
struct SpecText {
  std::string_view text;
  std::string example;

  [[nodiscard]] std::string where() const { return "board '" + std::string(text) + "'"; }
  [[nodiscard]] Error error(const std::string& found, const std::string& expected,
                            const std::string& next_step = {}) const {
    return usageError({.where = where(),
                       .found = found,
                       .expected = expected,
                       .next_step = next_step.empty() ? "for example " + example : next_step});
  }
  [[nodiscard]] int count(std::string_view part, const std::string& what) const {
    const auto count = parseInt(part);
    if (!count) throw error("'" + std::string(part) + "' as " + what, "a whole number");
    return *count;
  }
};

std::string upperCase(std::string text) {
  for (char& c : text) {
    if (c >= 'a' && c <= 'z') c = static_cast<char>(c - 'a' + 'A');
  }
  return text;
}

template <class Kind>
BoardKindName kindName() {
  BoardKindName kind{.name = std::string(Kind::kName),
                     .aliases = Kind::kAliases,
                     .example = std::string(Kind::kExample),
                     .keys = {}};
  for (const auto& field : Kind::fields()) {
    kind.keys.emplace_back(field.key);
    if (!field.is_optional) ++kind.num_required;
  }
  return kind;
}

// Reads a part of a SPEC into a member.
void readPart(const SpecText& spec, std::string_view part, std::string_view key, bool is_share,
              double& value) {
  if (!is_share) {
    value = parseLength(part, spec.where());
    return;
  }
  const auto share = parseDouble(part);
  if (!share) throw spec.error("'" + std::string(part) + "' as the " + std::string(key), "a plain number");
  value = *share;
}
void readPart(const SpecText& spec, std::string_view part, std::string_view key, bool, int& value) {
  value = spec.count(part, "the " + std::string(key));
}
void readPart(const SpecText&, std::string_view part, std::string_view, bool, std::string& value) {
  value = part;
}

template <class Kind>
Board readKind(const SpecText& spec, std::span<const std::string_view> parts) {
  Kind board;
  const std::vector<std::string_view> counts = split(parts[1], 'x');
  if (counts.size() != 2)
    throw spec.error("'" + std::string(parts[1]) + "' as the size", "COLUMNSxROWS, for example 9x6");
  board.columns = spec.count(counts[0], "a count");
  board.rows = spec.count(counts[1], "a count");
  const auto fields = Kind::fields();
  for (std::size_t i = 0; i + 2 < parts.size(); ++i) {
    std::visit(
        [&](const auto member) {
          readPart(spec, parts[i + 2], fields[i].key, fields[i].is_share, board.*member);
        },
        fields[i].member);
  }
  if (const auto fault = board.fault()) throw spec.error(fault->found, fault->expected, fault->next_step);
  return board;
}

template <class... Kinds>
std::vector<BoardKindName> namesOf(const std::variant<Kinds...>&) {
  return {kindName<Kinds>()...};
}

std::vector<AliasedName> aliasedKinds() {
  return mapped(boardKinds(), [](const BoardKindName& kind) { return AliasedName{kind.name, kind.aliases}; });
}

template <class... Kinds>
Board readKindAt(const std::variant<Kinds...>&, std::size_t index, const SpecText& spec,
                 std::span<const std::string_view> parts) {
  constexpr std::array kReaders = {readKind<Kinds>...};
  return kReaders[index](spec, parts);
}

}  // namespace

const std::vector<BoardKindName>& boardKinds() {
  static const std::vector<BoardKindName> kinds = namesOf(BoardKind());
  return kinds;
}

std::string boardKindOf(std::string_view word) {
  return meantName(word, aliasedKinds()).value_or(std::string(word));
}

double parseLength(std::string_view text, const std::string& where) {
  // Divided, not multiplied by 0.001: 25 / 1000 is the double nearest to 0.025.
  constexpr std::array<std::pair<std::string_view, double>, 3> kUnitsPerMetre = {
      {{"mm", 1000.0}, {"cm", 100.0}, {"m", 1.0}}};
  std::string_view number = trim(text);
  double metres_per_unit = 1.0;
  double units_per_metre = 1.0;
  if (number.ends_with("in")) {
    number.remove_suffix(2);
    metres_per_unit = 0.0254;
  } else {
    for (const auto& [unit, per_metre] : kUnitsPerMetre) {
      if (!number.ends_with(unit)) continue;
      number.remove_suffix(unit.size());
      units_per_metre = per_metre;
      break;
    }
  }
  const auto value = parseDouble(trim(number));
  if (!value || !std::isfinite(*value)) {
    throw usageError({.where = where,
                      .found = "'" + std::string(text) + "'",
                      .expected = "a length such as 25mm, 2.5cm, 0.025m or 1in"});
  }
  return *value * metres_per_unit / units_per_metre;
}

Board parseBoardSpec(std::string_view text) {
  const std::vector<std::string_view> parts = split(trim(text), ':');
  const std::string name = boardKindOf(parts.front());
  const auto& kinds = boardKinds();
  const auto kind = std::ranges::find(kinds, name, &BoardKindName::name);
  if (kind == kinds.end()) {
    const std::vector<std::string> names = mapped(kinds, &BoardKindName::name);
    const SpecText spec{text, kinds.front().example};
    throw spec.error("board kind '" + name + "'",
                     join(names, ", ") + ", or a YAML file that describes the board",
                     didYouMeanOne(name, aliasedKinds(), "for example " + spec.example));
  }
  const SpecText spec{text, kind->example};
  if (parts.size() < 2 + kind->num_required || parts.size() > 2 + kind->keys.size()) {
    std::string form = name + ":COLUMNSxROWS";
    for (std::size_t i = 0; i < kind->keys.size(); ++i)
      form += i < kind->num_required ? ":" + upperCase(kind->keys[i]) : "[:" + upperCase(kind->keys[i]) + "]";
    throw spec.error(std::to_string(parts.size()) + " part" + (parts.size() == 1 ? "" : "s"), form);
  }
  return readKindAt(BoardKind(), static_cast<std::size_t>(kind - kinds.begin()), spec, parts);
}

}  // namespace alidade
