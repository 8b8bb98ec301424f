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

std::string numbersHtml(const std::vector<PageNumber>& numbers) {
  std::string html = "<dl class=\"numbers\">\n";
  for (const PageNumber& number : numbers) {
    html += fmt::format("<div><dt>{}</dt><dd>{}<small>{}</small></dd></div>\n", escapedMarkup(number.name),
                        escapedMarkup(number.value), escapedMarkup(number.more));
  }
  return html + "</dl>\n";
}

std::string figureHtml(const Figure& figure) {
  // Wide drawings scroll where the page is narrow.
  return fmt::format(
      "<figure id=\"{}\"{}><h3>{}</h3>\n{}{}{}<figcaption class=\"reading\">{}</figcaption></figure>\n",
      figure.id, figure.is_wide ? " class=\"wide\"" : "", escapedMarkup(figure.title),
      figure.is_wide ? "<div class=\"scroll\">" : "", figure.svg, figure.is_wide ? "</div>" : "",
      escapedMarkup(figure.reading));
}

// The evidence as text for a script element. A "<" could end that, and stands in texts alone.
std::string embeddedEvidence(const json& evidence) {
  json document = evidence;
  const auto rounded = [](json& value) {
    if (value.is_number_float()) value = std::round(1e4 * value.get<double>()) / 1e4;
  };
  const auto roundViews = [&](json& of) {
    if (!of.is_object() || !of.contains("views")) return;
    for (json& view : of["views"]) {
      for (json& corner : view["corners"]) {
        for (const char* key : {"u", "v", "dx", "dy"}) rounded(corner[key]);
      }
    }
  };
  roundViews(document);
  if (document.contains("files")) {
    for (json& file : document["files"]) {
      for (json& camera : file["cameras"]) roundViews(camera["held_out"]);
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
  const std::string words = !page.headline.empty() ? page.headline
                            : is_good              ? "Trustworthy"
                            : is_fair              ? "Usable with reservations"
                                                   : "Rejected: do not use this " + page.subject;
  std::string html = fmt::format(
      "<header><p class=\"kicker\">{} report</p>\n<h1>{}</h1>\n<p class=\"kicker\">{}</p></header>\n"
      "<section class=\"verdict {}\" aria-label=\"Verdict\"><strong>{}</strong><p>{}</p></section>\n",
      page.kind, escapedMarkup(page.title), escapedMarkup(page.subtitle),
      is_good   ? "good"
      : is_fair ? "fair"
                : "bad",
      escapedMarkup(words), escapedMarkup(page.sentence));
  html += findingsHtml(page.findings, page.names, page.next_text) + numbersHtml(page.numbers) +
          "<nav aria-label=\"Sections\">";
  for (const PageSection& section : page.sections)
    html += fmt::format("<a href=\"#{}\">{}</a>\n", section.id, section.title);
  return html + "</nav>\n";
}

}  // namespace

std::string errorText(double px) {
  return (px >= 100 ? fmt::format("{:.0f}", px) : twoDigits(px)) + "\u00a0px";
}

std::string findingsHtml(const std::vector<Diagnosis>& findings, const std::vector<std::string>& names,
                         const std::string& next_text) {
  std::string list;
  std::string notes;
  std::string others;  // that open on demand
  int num_notes = 0;
  int num_others = 0;
  for (const Diagnosis& finding : findings) {
    const bool is_note = finding.severity <= Severity::kNote;
    const char* name = finding.severity == Severity::kFailure ? "Failure" : is_note ? "Note" : "Warning";
    const std::string effect =
        std::isfinite(finding.effect_px) && finding.effect_px > 0
            ? fmt::format(" Effect on projected points: up to {}.", errorText(finding.effect_px))
            : "";
    std::string sentence = finding.message();
    const bool has_name = std::ranges::any_of(
        names, [&](const std::string& known) { return sentence.starts_with(known + ":"); });
    if (!has_name && !sentence.empty() && sentence[0] >= 'a' && sentence[0] <= 'z')
      sentence[0] = static_cast<char>(sentence[0] - 'a' + 'A');
    constexpr int kMostShown = 8;
    num_notes += is_note ? 1 : 0;
    num_others += is_note ? 0 : 1;
    std::string& to = is_note ? notes : num_others <= kMostShown ? list : others;
    // A sentence that has an end keeps it.
    const bool is_ended = !sentence.empty() && (sentence.back() == '.' || sentence.back() == '?');
    to += fmt::format("<li class=\"{}\"><span class=\"severity\">{}</span><span>{}{}{}</span>",
                      severityName(finding.severity), name, escapedMarkup(sentence), is_ended ? "" : ".",
                      effect);
    if (!finding.next_step.empty())
      to += fmt::format("<span class=\"todo\">What to do: {}.</span>", escapedMarkup(finding.next_step));
    to += "</li>\n";
  }
  if (!next_text.empty()) {
    list += fmt::format(
        "<li class=\"advice\"><span class=\"severity\">Next</span><span>To improve the camera, take one more "
        "photograph: {} (<a href=\"#next-view\">see the drawing</a>).</span></li>\n",
        escapedMarkup(next_text));
  }
  std::string html = list.empty() ? "" : "<ul class=\"findings\">\n" + list + "</ul>\n";
  if (!others.empty())
    html += "<details><summary>All other warnings</summary>\n<ul class=\"findings\">\n" + others +
            "</ul></details>\n";
  if (num_notes > 0) {
    html += fmt::format(
        "<details><summary>{} note{} without effect on the verdict</summary>\n<ul class=\"findings\">\n{}"
        "</ul></details>\n",
        num_notes, num_notes == 1 ? "" : "s", notes);
  }
  return html;
}

std::string figuresHtml(const std::vector<Figure>& figures, const std::string& more) {
  std::string html = "<div class=\"figures\">\n";
  for (const Figure& figure : figures) html += figureHtml(figure);
  return html + more + "</div>\n";
}

std::string listHtml(const std::string& title, const std::vector<std::string>& lines) {
  if (lines.empty()) return "";
  std::string html = fmt::format("<details><summary>{}</summary><ul>\n", title);
  for (const std::string& line : lines) html += "<li>" + escapedMarkup(line) + "</li>\n";
  return html + "</ul></details>\n";
}

std::string pageText(const PageContent& page, const json& evidence) {
  std::string html = headHtml(page.kind + ": " + page.title) + "<body>\n" + topHtml(page) + "<main>\n";
  for (const PageSection& section : page.sections) {
    html += fmt::format("<h2 id=\"{}\">{}</h2>\n", section.id, section.title);
    html += figuresHtml(section.figures, section.more);
  }
  if (!page.details.empty()) html += "<h2 id=\"details\">Details</h2>\n" + page.details;
  html += "</main>\n" + page.dialog;
  html += fmt::format(
      "<footer>Made by {}. The numbers behind this page are part of it: see the element with the id "
      "“evidence”.</footer>\n",
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
