// SPDX-License-Identifier: MIT
#include "alidade/report/pages/page_shell.h"

#include <algorithm>
#include <cmath>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "alidade/core/number_text.h"
#include "alidade/report/canvas/report_assets.h"

namespace alidade {
namespace {

using nlohmann::json;

// A sentence about a finding. Names of images and cameras keep their case.
std::string sentenceOf(const Diagnosis& finding, const std::vector<std::string>& names) {
  std::string sentence = finding.message();
  const bool has_name = std::ranges::any_of(names, [&](const std::string& name) {
    const bool is_first = !name.empty() && sentence.starts_with(name);
    return is_first &&
           (sentence.size() == name.size() || sentence[name.size()] == ':' || sentence[name.size()] == ' ');
  });
  const std::string word = sentence.substr(0, sentence.find(' '));
  const bool is_word = std::ranges::all_of(word, [](char c) { return c >= 'a' && c <= 'z'; });
  if (!has_name && is_word && !sentence.empty()) sentence[0] = static_cast<char>(sentence[0] - 'a' + 'A');
  return sentence;
}

// A full stop, unless the sentence already has an end.
const char* fullStopOf(const std::string& sentence) {
  return sentence.ends_with('.') || sentence.ends_with('?') ? "" : ".";
}

// "Effect on projected points: up to 3 px.", unless the finding already states it.
std::string effectText(const Diagnosis& finding) {
  if (!(std::isfinite(finding.effect_px) && finding.effect_px > 0)) return "";
  if (finding.message().find(twoDigits(finding.effect_px) + " px") != std::string::npos) return "";
  return fmt::format(" Effect on projected points: up to {}.", errorText(finding.effect_px));
}

// Findings of one kind, such as one per camera of a rig.
using FindingGroup = std::vector<const Diagnosis*>;

std::vector<FindingGroup> grouped(const std::vector<Diagnosis>& findings) {
  std::vector<FindingGroup> groups;
  for (const Diagnosis& finding : findings) {
    const auto like = std::ranges::find_if(groups, [&](const FindingGroup& group) {
      return group.front()->id == finding.id && group.front()->severity == finding.severity;
    });
    if (like == groups.end()) {
      groups.push_back({&finding});
    } else {
      like->push_back(&finding);
    }
  }
  return groups;
}

std::string groupHtml(const FindingGroup& group, const std::vector<std::string>& names) {
  const Severity severity = group.front()->severity;
  const char* name = severity == Severity::kFailure ? "Failure"
                     : severity <= Severity::kNote  ? "Note"
                                                    : "Warning";
  std::string sentences;
  std::vector<std::string> steps;
  for (const Diagnosis* finding : group) {
    const std::string sentence = sentenceOf(*finding, names);
    sentences += fmt::format("{}{}{}{}", sentences.empty() ? "" : "<br>", escapedMarkup(sentence),
                             fullStopOf(sentence), effectText(*finding));
    if (!finding->next_step.empty() && std::ranges::find(steps, finding->next_step) == steps.end())
      steps.push_back(finding->next_step);
  }
  std::string html = fmt::format("<li class=\"{}\"><span class=\"severity\">{}</span><span>{}</span>",
                                 severityName(severity), name, sentences);
  if (!steps.empty()) {
    std::string todo;
    for (const std::string& step : steps) todo += (todo.empty() ? "" : "; ") + step;
    html +=
        fmt::format("<span class=\"todo\">What to do: {}{}</span>", escapedMarkup(todo), fullStopOf(todo));
  }
  return html + "</li>\n";
}

// The accuracy assumes that nothing else is wrong: for a rejected camera it holds only if it is itself the
// reason.
bool doesAccuracyApply(const PageContent& page) {
  return page.verdict != Verdict::kNo || std::ranges::all_of(page.findings, [](const Diagnosis& finding) {
           return finding.severity < Severity::kFailure || finding.id == DiagnosisId("inaccurate");
         });
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

// The evidence as text for a script element. A "<" could end the element, and occurs only in texts.
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

// The expected accuracy, preceded by the reason if the camera is rejected.
std::string verdictSentence(const PageContent& page) {
  if (page.verdict != Verdict::kNo) return page.sentence;
  std::string text = mainFindingText(page.findings, page.names);
  const bool is_void =
      !doesAccuracyApply(page) && std::ranges::any_of(page.numbers, &PageNumber::is_accuracy);
  const std::string rest = is_void ? "The accuracy figures below do not apply." : page.sentence;
  return text + (text.empty() || rest.empty() ? "" : " ") + rest;
}

std::string topHtml(const PageContent& page) {
  const bool is_good = page.verdict == Verdict::kTrustworthy;
  const bool is_fair = page.verdict == Verdict::kReservations;
  std::string words = !page.headline.empty() ? page.headline
                      : is_good              ? "Trustworthy"
                      : is_fair              ? "Usable with reservations"
                                             : "Rejected: do not use this " + page.subject;
  if (is_fair && !page.reservation.empty()) words += ": " + page.reservation;
  std::string html = fmt::format(
      "<header><p class=\"kicker\">{} report</p>\n<h1>{}</h1>\n<p class=\"kicker\">{}</p></header>\n"
      "<section class=\"verdict {}\" aria-label=\"Verdict\"><strong>{}</strong><p>{}</p></section>\n",
      page.kind, escapedMarkup(page.title), escapedMarkup(page.subtitle),
      is_good   ? "good"
      : is_fair ? "fair"
                : "bad",
      escapedMarkup(words), escapedMarkup(verdictSentence(page)));
  html += findingsHtml(page.findings, page.names, page.next_text) + numbersHtml(page) +
          "<nav aria-label=\"Sections\">";
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

std::string findingsHtml(const std::vector<Diagnosis>& findings, const std::vector<std::string>& names,
                         const std::string& next_text) {
  constexpr int kMostShown = 8;
  std::string list;
  std::string notes;
  std::string others;  // shown on demand
  int num_notes = 0;
  int num_others = 0;
  for (const FindingGroup& group : grouped(findings)) {
    const bool is_note = group.front()->severity <= Severity::kNote;
    num_notes += is_note ? 1 : 0;
    num_others += is_note ? 0 : 1;
    std::string& to = is_note ? notes : num_others <= kMostShown ? list : others;
    to += groupHtml(group, names);
  }
  if (!next_text.empty()) {
    list += fmt::format(
        "<li class=\"advice\"><span class=\"severity\">Next</span><span>To improve the camera, take one more "
        "photograph: {} (<a href=\"#next-view\">see the drawing</a>).</span></li>\n",
        escapedMarkup(next_text));
  }
  std::string html = list.empty() ? "" : "<ul class=\"findings\">\n" + list + "</ul>\n";
  if (!others.empty())
    html += fmt::format("<details><summary>{}</summary>\n<ul class=\"findings\">\n{}</ul></details>\n",
                        counted(num_others - kMostShown, "more warning"), others);
  if (num_notes > 0) {
    html += fmt::format(
        "<details><summary>{} without effect on the verdict</summary>\n<ul "
        "class=\"findings\">\n{}</ul></details>\n",
        counted(num_notes, "note"), notes);
  }
  return html;
}

std::string mainFindingText(const std::vector<Diagnosis>& findings, const std::vector<std::string>& names) {
  const auto main = std::ranges::max_element(findings, {}, &Diagnosis::severity);
  if (main == findings.end() || main->severity < Severity::kWarning) return "";
  const auto num_more = std::ranges::count(findings, main->severity, &Diagnosis::severity) - 1;
  const std::string sentence = sentenceOf(*main, names);
  if (num_more == 0) return sentence + fullStopOf(sentence);
  return fmt::format("{} (and {}).", sentence,
                     counted(num_more, fmt::format("more {}", severityName(main->severity))));
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
    for (const Figure& figure : section.figures)
      files.push_back({.name = figure.id + ".svg", .svg = standaloneSvg(figure.svg)});
  }
  return files;
}

}  // namespace alidade
