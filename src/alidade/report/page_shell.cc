// SPDX-License-Identifier: MIT
#include "alidade/report/page_shell.h"

#include <algorithm>
#include <cmath>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "alidade/report/report_assets.h"

namespace alidade {
namespace {

using nlohmann::json;

// A sentence about a finding. Names of images and cameras keep their letters.
std::string sentenceOf(const Diagnosis& finding, const std::vector<std::string>& names) {
  std::string sentence = finding.message();
  const bool has_name = std::ranges::any_of(
      names, [&](const std::string& name) { return !name.empty() && sentence.starts_with(name); });
  const std::string word = sentence.substr(0, sentence.find(' '));
  const bool is_word = std::ranges::all_of(word, [](char c) { return c >= 'a' && c <= 'z'; });
  if (!has_name && is_word && !sentence.empty()) sentence[0] = static_cast<char>(sentence[0] - 'a' + 'A');
  return sentence;
}

// "Effect on projected points: up to 3 px.", unless the finding says so itself.
std::string effectText(const Diagnosis& finding) {
  if (!(std::isfinite(finding.effect_px) && finding.effect_px > 0)) return "";
  if (finding.message().find(twoDigits(finding.effect_px) + " px") != std::string::npos) return "";
  return fmt::format(" Effect on projected points: up to {}.", errorText(finding.effect_px));
}

// Findings of one kind, such as one for each camera of a rig.
struct FindingGroup {
  std::vector<const Diagnosis*> findings;

  [[nodiscard]] const Diagnosis& first() const { return *findings.front(); }
};

std::vector<FindingGroup> grouped(const std::vector<Diagnosis>& findings) {
  std::vector<FindingGroup> groups;
  for (const Diagnosis& finding : findings) {
    const auto like = std::ranges::find_if(groups, [&](const FindingGroup& group) {
      return group.first().id == finding.id && group.first().severity == finding.severity;
    });
    if (like == groups.end()) {
      groups.push_back({{&finding}});
    } else {
      like->findings.push_back(&finding);
    }
  }
  return groups;
}

std::string groupHtml(const FindingGroup& group, const std::vector<std::string>& names) {
  const Severity severity = group.first().severity;
  const char* name = severity == Severity::kFailure ? "Failure"
                     : severity <= Severity::kNote  ? "Note"
                                                    : "Warning";
  std::string sentences;
  std::vector<std::string> steps;
  for (const Diagnosis* finding : group.findings) {
    sentences += fmt::format("{}{}.{}", sentences.empty() ? "" : "<br>",
                             escapedMarkup(sentenceOf(*finding, names)), effectText(*finding));
    if (!finding->next_step.empty() && std::ranges::find(steps, finding->next_step) == steps.end())
      steps.push_back(finding->next_step);
  }
  std::string html = fmt::format("<li class=\"{}\"><span class=\"severity\">{}</span><span>{}</span>",
                                 severityName(severity), name, sentences);
  if (!steps.empty()) {
    std::string todo;
    for (const std::string& step : steps) todo += (todo.empty() ? "" : "; ") + step;
    html += fmt::format("<span class=\"todo\">What to do: {}.</span>", escapedMarkup(todo));
  }
  return html + "</li>\n";
}

std::string findingsHtml(const PageContent& page) {
  constexpr int kMostShown = 8;
  std::string list;
  std::string notes;
  std::string others;  // that open on demand
  int num_notes = 0;
  int num_others = 0;
  for (const FindingGroup& group : grouped(page.findings)) {
    const bool is_note = group.first().severity <= Severity::kNote;
    num_notes += is_note ? 1 : 0;
    num_others += is_note ? 0 : 1;
    std::string& to = is_note ? notes : num_others <= kMostShown ? list : others;
    to += groupHtml(group, page.names);
  }
  if (!page.next_text.empty()) {
    list += fmt::format(
        "<li class=\"advice\"><span class=\"severity\">Next</span><span>To improve the camera, take one more "
        "photograph: {} (<a href=\"#next-view\">see the drawing</a>).</span></li>\n",
        escapedMarkup(page.next_text));
  }
  std::string html = list.empty() ? "" : "<ul class=\"findings\">\n" + list + "</ul>\n";
  if (!others.empty())
    html += fmt::format(
        "<details><summary>{} more warning{}</summary>\n<ul class=\"findings\">\n{}</ul></details>\n",
        num_others - kMostShown, num_others == kMostShown + 1 ? "" : "s", others);
  if (num_notes > 0) {
    html += fmt::format(
        "<details><summary>{} note{} without effect on the verdict</summary>\n<ul class=\"findings\">\n{}"
        "</ul></details>\n",
        num_notes, num_notes == 1 ? "" : "s", notes);
  }
  return html;
}

// The accuracy assumes that nothing else is wrong: it holds for a rejected camera only where that is the
// reason itself.
bool doesAccuracyApply(const PageContent& page) {
  return page.verdict != Verdict::kNo || std::ranges::all_of(page.findings, [](const Diagnosis& finding) {
           return finding.severity < Severity::kFailure || finding.id == "inaccurate";
         });
}

// "The main reason (and 3 more failures)."
std::string rejectionSentence(const PageContent& page) {
  const auto isFailure = [](const Diagnosis& finding) { return finding.severity == Severity::kFailure; };
  const auto main = std::ranges::find_if(page.findings, isFailure);
  if (main == page.findings.end()) return "";
  const auto num_more = std::ranges::count_if(page.findings, isFailure) - 1;
  return sentenceOf(*main, page.names) +
         (num_more == 0 ? "." : fmt::format(" (and {} more failure{}).", num_more, num_more == 1 ? "" : "s"));
}

std::string numbersHtml(const PageContent& page) {
  const bool does_apply = doesAccuracyApply(page);
  std::string html = "<dl class=\"numbers\">\n";
  for (const PageNumber& number : page.numbers) {
    html += fmt::format("<div{}><dt>{}</dt><dd>{}<small>{}</small></dd></div>\n",
                        number.is_accuracy && !does_apply ? " class=\"void\"" : "",
                        escapedMarkup(number.name), escapedMarkup(number.value), escapedMarkup(number.more));
  }
  return html + "</dl>\n";
}

std::string figureHtml(const Figure& figure) {
  return fmt::format(
      "<figure id=\"{}\"><h3>{}</h3>\n{}<figcaption class=\"reading\">{}</figcaption></figure>\n", figure.id,
      escapedMarkup(figure.title), figure.svg, escapedMarkup(figure.reading));
}

// The evidence as text for a script element. A "<" could end that, and stands in texts alone.
std::string embeddedEvidence(const json& evidence) {
  json document = evidence;
  const auto rounded = [](json& value) {
    if (value.is_number_float()) value = std::round(1e4 * value.get<double>()) / 1e4;
  };
  for (json& view : document["views"]) {
    for (json& corner : view["corners"]) {
      for (const char* key : {"u", "v", "dx", "dy"}) rounded(corner[key]);
    }
  }
  std::string text;
  for (const char c : document.dump(-1, ' ', false, json::error_handler_t::replace)) {
    if (c == '<') {
      text += "\\u003c";
    } else {
      text += c;
    }
  }
  return text;
}

std::string headHtml(const std::string& title) {
  return fmt::format(
      "<!DOCTYPE html>\n<html lang=\"en\">\n<head>\n<meta charset=\"utf-8\">\n<meta name=\"viewport\" "
      "content=\"width=device-width, initial-scale=1\">\n<meta http-equiv=\"Content-Security-Policy\" "
      "content=\"default-src 'none'; style-src 'unsafe-inline'; script-src 'unsafe-inline'; img-src "
      "data:\">\n"
      "<meta name=\"color-scheme\" content=\"light "
      "dark\">\n<title>{}</title>\n<style>\n{}{}{}</style>\n</head>\n",
      escapedMarkup(title), paletteCss(), figureCss(), pageCss());
}

std::string topHtml(const PageContent& page) {
  const bool is_good = page.verdict == Verdict::kTrustworthy;
  const bool is_fair = page.verdict == Verdict::kReservations;
  std::string words = is_good   ? "Trustworthy"
                      : is_fair ? "Usable with reservations"
                                : "Rejected: do not use this " + page.subject;
  if (is_fair && !page.reservation.empty()) words += ": " + page.reservation;
  std::string sentence = page.sentence;
  if (page.verdict == Verdict::kNo) {
    sentence = rejectionSentence(page) + " " +
               (doesAccuracyApply(page) || std::ranges::none_of(page.numbers, &PageNumber::is_accuracy)
                    ? page.sentence
                    : "The accuracy figures below do not apply.");
  }
  std::string html = fmt::format(
      "<header><p class=\"kicker\">Calibration report</p>\n<h1>{}</h1>\n<p class=\"kicker\">{}</p></header>\n"
      "<section class=\"verdict {}\" aria-label=\"Verdict\"><strong>{}</strong><p>{}</p></section>\n",
      escapedMarkup(page.title), escapedMarkup(page.subtitle),
      is_good   ? "good"
      : is_fair ? "fair"
                : "bad",
      escapedMarkup(words), escapedMarkup(sentence));
  html += findingsHtml(page) + numbersHtml(page) + "<nav aria-label=\"Sections\">";
  for (const PageSection& section : page.sections)
    html += fmt::format("<a href=\"#{}\">{}</a>\n", section.id, section.title);
  return html + "</nav>\n";
}

}  // namespace

std::string errorText(double px) {
  return twoDigits(px) + "\u00a0px";
}

std::string rmsText(double px) {
  return shortNumber(px) + "\u00a0px";
}

std::string tableFigure(const std::string& id, const std::string& title,
                        const std::vector<PageColumn>& columns, const std::vector<PageRow>& rows,
                        const std::string& reading) {
  const auto kindOf = [](const PageColumn& column) { return column.has_words ? " class=\"words\"" : ""; };
  std::string html = fmt::format(
      "<figure id=\"{}\"{}><h3>{}</h3><div class=\"scroll\" tabindex=\"0\" role=\"region\" "
      "aria-label=\"{}\"><table class=\"rows\"><thead><tr>",
      id, columns.size() > 3 ? " class=\"wide\"" : "", escapedMarkup(title), escapedMarkup(title));
  for (const PageColumn& column : columns)
    html += fmt::format("<th scope=\"col\"{}>{}</th>", kindOf(column), escapedMarkup(column.name));
  html += "</tr></thead><tbody>\n";
  for (const PageRow& row : rows) {
    html += row.kind.empty() ? "<tr>" : fmt::format("<tr class=\"{}\">", row.kind);
    for (std::size_t c = 0; c < columns.size(); ++c)
      html += fmt::format("<td{} data-name=\"{}\">{}</td>", kindOf(columns[c]),
                          escapedMarkup(columns[c].name), escapedMarkup(row.cells[c]));
    html += "</tr>\n";
  }
  return html + fmt::format("</tbody></table></div><figcaption class=\"reading\">{}</figcaption></figure>\n",
                            escapedMarkup(reading));
}

std::string listHtml(const std::string& title, const std::vector<std::string>& lines) {
  if (lines.empty()) return "";
  std::string html = fmt::format("<details><summary>{}</summary><ul>\n", title);
  for (const std::string& line : lines) html += "<li>" + escapedMarkup(line) + "</li>\n";
  return html + "</ul></details>\n";
}

std::string pageText(const PageContent& page, const json& evidence) {
  std::string html = headHtml("Calibration: " + page.title) + "<body>\n" + topHtml(page) + "<main>\n";
  for (const PageSection& section : page.sections) {
    html += fmt::format("<h2 id=\"{}\">{}</h2>\n<div class=\"figures\">\n", section.id, section.title);
    for (const Figure& figure : section.figures) html += figureHtml(figure);
    html += section.more + "</div>\n";
  }
  html += "<h2 id=\"details\">Details</h2>\n" + page.details + "</main>\n" + page.dialog;
  html +=
      fmt::format("<footer>Made by {}. The data are embedded in this file (element “evidence”).</footer>\n",
                  escapedMarkup(page.created_by));
  html += "<script type=\"application/json\" id=\"evidence\">" + embeddedEvidence(evidence) +
          "</script>\n<script>\n";
  html += pageScript();
  return html + "</script>\n</body>\n</html>\n";
}

std::vector<FigureFile> figureFiles(const std::vector<PageSection>& sections) {
  std::vector<FigureFile> files;
  for (const PageSection& section : sections) {
    for (const Figure& figure : section.figures) {
      // The style goes into the drawing, with a ground of its own.
      const std::size_t end_of_tag = figure.svg.find('>') + 1;
      files.push_back({.name = figure.id + ".svg",
                       .svg = "<svg xmlns=\"http://www.w3.org/2000/svg\"" +
                              figure.svg.substr(4, end_of_tag - 4) +
                              fmt::format("\n<style>\n{}{}svg {{ background: var(--ground); }}\n</style>\n",
                                          paletteCss(), figureCss()) +
                              figure.svg.substr(end_of_tag)});
    }
  }
  return files;
}

}  // namespace alidade
