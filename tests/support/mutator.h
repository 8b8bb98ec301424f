// SPDX-License-Identifier: MIT
#pragma once

#include <algorithm>
#include <cstdint>
#include <iterator>
#include <random>
#include <string>
#include <string_view>

namespace alidade {

/// Damages texts as accidents and careless hands do, the same way for the same seed: bytes changed to ones
/// that mean something in YAML, JSON and CSV, or to any; pieces and lines dropped or doubled; numbers
/// replaced.
class Mutator {
 public:
  explicit Mutator(std::uint32_t seed) : random_(seed) {}

  std::string operator()(std::string text) {
    const std::size_t num_changes = 1 + below(kMaxChanges);
    for (std::size_t i = 0; i < num_changes && !text.empty(); ++i) change(text);
    return text;
  }

 private:
  static constexpr std::size_t kMaxChanges = 2;
  static constexpr std::size_t kNumKinds = 8;

  void change(std::string& text) {
    constexpr std::string_view kTelling = "[]{}<>():,-#&*!|>'\"%@`\n\t 0123456789.eEnaif";
    const std::size_t at = below(text.size());
    switch (below(kNumKinds)) {
      case 0:
        text[at] = static_cast<char>(below(256));
        break;
      case 1:
      case 2:
        text[at] = kTelling[below(kTelling.size())];
        break;
      case 3:
        text.erase(at, 1 + below(20));
        break;
      case 4:
        text.insert(below(text.size()), text.substr(at, 1 + below(20)));
        break;
      case 5:
        dropOrDoubleLine(text, at);
        break;
      default:
        replaceNumber(text, at);
    }
  }

  void dropOrDoubleLine(std::string& text, std::size_t at) {
    const std::size_t before = text.rfind('\n', at);
    const std::size_t begin = before == std::string::npos ? 0 : before + 1;
    const std::size_t end = std::min(text.find('\n', begin), text.size() - 1) + 1;
    if (below(2) == 0) {
      text.erase(begin, end - begin);
    } else {
      text.insert(begin, text.substr(begin, end - begin));
    }
  }

  // The first number at or behind `at`.
  void replaceNumber(std::string& text, std::size_t at) {
    constexpr std::string_view kOfNumbers = "0123456789.eE+-";
    constexpr std::string_view kNumbers[] = {
        "0",       "-1",   "nan", ".nan", "inf", "1e999", "1e308",
        "-1e-320", "1e20", "0.5", "",     "2x",  "0x10",  "123456789012345678901234567890"};
    const std::size_t begin = text.find_first_of("0123456789", at);
    if (begin == std::string::npos) return;
    const std::size_t end = std::min(text.find_first_not_of(kOfNumbers, begin), text.size());
    text.replace(begin, end - begin, kNumbers[below(std::size(kNumbers))]);
  }

  std::size_t below(std::size_t limit) { return random_() % limit; }

  std::mt19937 random_;
};

}  // namespace alidade
