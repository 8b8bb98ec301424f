// SPDX-License-Identifier: MIT
#pragma once

#include <regex>
#include <string>
#include <vector>

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

// What tests ask of report pages.

namespace alidade {

inline constexpr const char* kEvidenceTag = "<script type=\"application/json\" id=\"evidence\">";

/// What a script gets from a page.
inline nlohmann::json embeddedEvidenceOf(const std::string& page) {
  const std::size_t start = page.find(kEvidenceTag) + std::string(kEvidenceTag).size();
  return nlohmann::json::parse(page.substr(start, page.find("</script>", start) - start));
}

/// The markup of a figure.
inline std::string figureOf(const std::string& page, const std::string& id) {
  const std::size_t start = page.find("<figure id=\"" + id + "\"");
  EXPECT_NE(start, std::string::npos) << id;
  return page.substr(start, page.find("</figure>", start) - start);
}

/// The numbers of an attribute, in their order.
inline std::vector<double> valuesOf(const std::string& text, const std::string& attribute) {
  std::vector<double> values;
  const std::regex pattern(attribute + "=\"([-0-9.e]+)\"");
  for (std::sregex_iterator i(text.begin(), text.end(), pattern), end; i != end; ++i)
    values.push_back(std::stod((*i)[1]));
  return values;
}

}  // namespace alidade
