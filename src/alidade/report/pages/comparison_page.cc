// SPDX-License-Identifier: MIT
#include "alidade/report/pages/comparison_page.h"

#include <algorithm>
#include <array>
#include <utility>
#include <vector>

#include <fmt/format.h>

#include "alidade/core/number_text.h"
#include "alidade/report/canvas/page_table.h"
#include "alidade/report/pages/page_shell.h"

namespace alidade {
namespace {

// The first one that occurs decides.
constexpr std::array kMostSevereFirst = {Agreement::kBeyond, Agreement::kNotComparable, Agreement::kUncertain,
                                         Agreement::kWithin};

std::size_t numWith(std::span<const ComparedPair> pairs, std::string_view answer) {
  return static_cast<std::size_t>(std::ranges::count_if(
      pairs, [&](const ComparedPair& pair) { return answerOf(pair.agreement) == answer; }));
}

std::string pairsTable(const std::vector<const ComparedPair*>& order) {
  std::vector<PageRow> rows;
  for (const ComparedPair* pair : order) {
    rows.push_back({{std::string(answerOf(pair->agreement)), pair->name, pair->a.empty() ? "–" : pair->a,
                     pair->b.empty() ? "–" : pair->b, pair->reason}});
  }
  return tableFigure(
      "pairs", "Cameras",
      {{"Answer", "words"}, {"Camera", "words"}, {"A", "words"}, {"B", "words"}, {"Difference", "words"}},
      rows,
      "Cameras are the same if they differ by at most the limit in 95 % of the image. Where the uncertainty that "
      "the files state is larger than the limit, it cannot be told.");
}

}  // namespace

Agreement agreementOf(std::span<const ComparedPair> pairs) {
  return *std::ranges::find_if(kMostSevereFirst, [&](Agreement agreement) {
    return agreement == Agreement::kWithin ||
           std::ranges::find(pairs, agreement, &ComparedPair::agreement) != pairs.end();
  });
}

std::string answerText(std::span<const ComparedPair> pairs) {
  const std::string_view answer = answerOf(agreementOf(pairs));
  if (pairs.size() == 1) return fmt::format("{}: {}", answer, pairs.front().reason);
  const std::size_t count = numWith(pairs, answer);
  if (count == pairs.size()) return fmt::format("{}: all {} cameras", answer, count);
  std::string text = fmt::format("{}: {} of {} cameras", answer, count, pairs.size());
  for (const char* other : {"cannot tell", "same"}) {
    const std::size_t num_others = numWith(pairs, other);
    if (other != answer && num_others > 0) text += fmt::format("; {}: {}", other, num_others);
  }
  return text;
}

std::string comparisonPage(std::span<const ComparedPair> pairs, const RunOrigin& origin,
                           const nlohmann::json& document) {
  constexpr std::size_t kMostDrawn = 60;  // a page with more would open slowly
  std::vector<const ComparedPair*> order;
  for (const Agreement agreement : kMostSevereFirst) {
    for (const ComparedPair& pair : pairs) {
      if (pair.agreement == agreement) order.push_back(&pair);
    }
  }
  const Agreement worst = agreementOf(pairs);
  PageContent page{.kind = "Comparison",
                   .title = pairs.size() > 1             ? counted(pairs.size(), "camera")
                            : pairs.front().name.empty() ? pairs.front().b
                                                         : pairs.front().name,
                   .origin = origin,
                   .headline = answerText(pairs),
                   .verdict = worst == Agreement::kWithin      ? Verdict::kTrustworthy
                              : worst == Agreement::kUncertain ? Verdict::kReservations
                                                               : Verdict::kNo};
  page.headline.front() = static_cast<char>(page.headline.front() - 'a' + 'A');
  for (const char* answer : {"same", "changed", "cannot tell"})
    page.numbers.push_back({answer, std::to_string(numWith(pairs, answer)), "of all cameras"});
  page.sections = {{.id = "answers", .title = "Answers", .figures = {}, .more = pairsTable(order)},
                   {.id = "where", .title = "Where they differ"}};
  for (const ComparedPair* pair : order) {
    const bool is_dull = pair->agreement == Agreement::kWithin && pairs.size() > 1;
    if (!pair->drawing || is_dull) continue;
    if (page.sections.back().figures.size() == kMostDrawn) {
      page.sections.back().more =
          fmt::format("<p class=\"reading\">Only the first {} are drawn.</p>\n", kMostDrawn);
      break;
    }
    Figure figure = withPrefix(*pair->drawing, fmt::format("pair{}-", page.sections.back().figures.size()));
    if (!pair->name.empty()) figure.title = pair->name + ": " + figure.title;
    page.sections.back().figures.push_back(std::move(figure));
  }
  if (page.sections.back().figures.empty()) page.sections.pop_back();
  return pageText(page, document);
}

}  // namespace alidade
