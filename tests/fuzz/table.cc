// SPDX-License-Identifier: MIT
// Tables of points, line by line, as project and unproject read them.
#include <string_view>

#include "alidade/core/text.h"
#include "alidade/files/text/table_lines.h"
#include "fuzz.h"

int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace alidade;
  const std::string text = fuzz::textOf(data, size);
  fuzz::read([&] {
    detail::TableLines lines("points.csv");
    for (const std::string_view line : split(text, '\n')) {
      (void)detail::splitCsv(line);
      if (lines.take(line) != detail::TableLines::Kind::kRow) continue;
      for (std::size_t i = 0; i < lines.numFields(); ++i) fuzz::read([&] { (void)lines.number(i, "x"); });
    }
  });
  return 0;
}
