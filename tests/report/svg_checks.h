// SPDX-License-Identifier: MIT
#pragma once

#include <string>

#include <gmock/gmock.h>

namespace alidade {

inline std::size_t countOf(const std::string& text, const std::string& part) {
  std::size_t count = 0;
  for (std::size_t at = text.find(part); at != std::string::npos; at = text.find(part, at + 1)) ++count;
  return count;
}

inline void expectGoodSvg(const std::string& svg) {
  EXPECT_THAT(svg, testing::StartsWith("<svg "));
  EXPECT_THAT(svg, testing::Not(testing::HasSubstr("nan")));
  EXPECT_THAT(svg, testing::Not(testing::HasSubstr("inf\"")));
  EXPECT_EQ(countOf(svg, "<g "), countOf(svg, "</g>"));
  EXPECT_EQ(countOf(svg, "<text "), countOf(svg, "</text>"));
  EXPECT_EQ(countOf(svg, "</svg>"), 1U);
  // XML takes a "<" of a style for an element.
  const std::size_t style = svg.find("<style><![CDATA[");
  const std::string outside = style == std::string::npos ? svg : svg.substr(svg.find("]]></style>", style));
  EXPECT_EQ(countOf(outside, "<use>"), 0U);
}

}  // namespace alidade
