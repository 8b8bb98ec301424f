// SPDX-License-Identifier: MIT
#include "alidade/report/pages/page_shell.h"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <span>
#include <string_view>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "alidade/core/mapped.h"
#include "alidade/core/number_text.h"
#include "alidade/core/text.h"
#include "alidade/report/canvas/page_table.h"
#include "alidade/report/canvas/report_assets.h"
#include "alidade/report/data/distinct_parts.h"
#include "alidade/report/data/utf8.h"
#include "alidade/report/figures/camera_figures.h"

namespace alidade {
namespace {

using nlohmann::json;

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
    (like == groups.end() ? groups.emplace_back() : *like).push_back(&finding);
  }
  return groups;
}

std::string groupHtml(const FindingGroup& group) {
  const Severity severity = group.front()->severity;
  const char* name = severity == Severity::kFailure ? "Failure"
                     : severity <= Severity::kNote  ? "Note"
                                                    : "Warning";
  std::string sentences;
  std::vector<std::string> steps;
  for (const Diagnosis* finding : group) {
    const std::string sentence = finding->message();
    sentences += fmt::format("{}{}{}{}", sentences.empty() ? "" : "<br>", proseHtml(sentence),
                             fullStopOf(sentence), effectText(*finding));
    if (!finding->next_step.empty() && std::ranges::find(steps, finding->next_step) == steps.end())
      steps.push_back(finding->next_step);
  }
  const std::string todo = join(steps, "; ");
  return fmt::format(
      "<li class=\"{}\"><span class=\"severity\">{}</span><span>{} <code>{}</code></span>{}</li>\n",
      severityName(severity), name, sentences, escapedMarkup(group.front()->id),
      steps.empty()
          ? ""
          : fmt::format("<span class=\"todo\">What to do: {}{}</span>", proseHtml(todo), fullStopOf(todo)));
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
  for (const char c : document.dump(-1, ' ', false, json::error_handler_t::replace))
    text += c == '<' ? std::string_view("\\u003c") : std::string_view(&c, 1);
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
  const std::string text = mainFindingText(page.findings);
  const bool is_void =
      !doesAccuracyApply(page) && std::ranges::any_of(page.numbers, &PageNumber::is_accuracy);
  const std::string rest = is_void ? "The accuracy figures below do not apply." : page.sentence;
  return text + (text.empty() || rest.empty() ? "" : " ") + rest;
}

// Whose result it is, what it was made from, by which program and when.
std::string originHtml(const RunOrigin& origin) {
  constexpr std::size_t kMostInputs = 8;
  const std::size_t num_shown = std::min(kMostInputs, origin.inputs.size());
  std::string inputs = join(std::span(origin.inputs).first(num_shown), ", ");
  if (num_shown < origin.inputs.size())
    inputs += fmt::format(" and {} more", origin.inputs.size() - num_shown);
  std::string html = "<dl class=\"origin\">\n";
  for (const auto& [name, value] : {std::pair("Camera", origin.camera.name),
                                    {"Serial number", origin.camera.serial},
                                    {"Date", origin.date},
                                    {"Inputs", inputs},
                                    {"Made by", origin.created_by}}) {
    if (!value.empty())
      html += fmt::format("<div><dt>{}</dt><dd>{}</dd></div>\n", name, proseHtml(validUtf8(value)));
  }
  return html + "</dl>";
}

std::string topHtml(const PageContent& page) {
  std::string html = fmt::format(
      "<header><p class=\"kicker\">{} report</p>\n<h1>{}</h1>\n<p class=\"kicker\">{}</p>\n{}</header>\n"
      "<section class=\"verdict {}\" aria-label=\"Verdict\"><strong>{}</strong><p>{}</p></section>\n",
      page.kind, proseHtml(page.title), escapedMarkup(page.subtitle), originHtml(page.origin),
      verdictClass(page.verdict), proseHtml(page.headline), proseHtml(verdictSentence(page)));
  html += findingsHtml(page.findings, page.next_text) + numbersHtml(page) + "<nav aria-label=\"Sections\">";
  for (const PageSection& section : page.sections)
    html += fmt::format("<a href=\"#{}\">{}</a>\n", section.id, section.title);
  return html + "</nav>\n";
}

// The dialog in which the script shows a view.
constexpr std::string_view kViewer =
    "<dialog id=\"viewer\" aria-labelledby=\"viewer-name\"><div class=\"viewer\"><header><h3 "
    "id=\"viewer-name\"></h3><label>Errors drawn <select id=\"viewer-times\"><option value=\"1\">true to "
    "scale</option><option value=\"10\">10 times longer</option><option value=\"50\">50 times "
    "longer</option><option value=\"200\">200 times longer</option></select></label><span "
    "class=\"controls\"><button class=\"plain\" id=\"viewer-before\" type=\"button\" aria-label=\"Previous "
    "view\">←</button><button class=\"plain\" id=\"viewer-after\" type=\"button\" aria-label=\"Next "
    "view\">→</button><button class=\"plain\" id=\"viewer-close\" autofocus "
    "type=\"button\">Close</button></span></header><svg id=\"viewer-drawing\" role=\"img\" "
    "aria-labelledby=\"viewer-words\"></svg><footer><span id=\"viewer-words\"></span><span "
    "id=\"viewer-key\">circle: detected; cross: projected</span></footer></div></dialog>\n";

}  // namespace

std::string errorText(double px) {
  return twoDigits(px) + "\u00a0px";
}

std::string rmsText(double px) {
  return shortNumber(px) + "\u00a0px";
}

const char* verdictClass(Verdict verdict) {
  return verdict == Verdict::kTrustworthy ? "good" : verdict == Verdict::kReservations ? "fair" : "bad";
}

std::string verdictHeadline(Verdict verdict, const std::string& subject) {
  return verdict == Verdict::kTrustworthy    ? "Trustworthy"
         : verdict == Verdict::kReservations ? "Usable with reservations"
                                             : "Rejected: do not use this " + subject;
}

std::vector<Diagnosis> asSentences(std::vector<Diagnosis> findings, const std::vector<std::string>& names) {
  for (Diagnosis& finding : findings) {
    const std::string sentence = finding.message();
    const bool has_name = std::ranges::any_of(names, [&](const std::string& name) {
      return !name.empty() && sentence.starts_with(name) &&
             (sentence.size() == name.size() || sentence[name.size()] == ':' || sentence[name.size()] == ' ');
    });
    const std::string word = sentence.substr(0, sentence.find(' '));
    const bool is_word = !word.empty() && word != "fx" && word != "cx" &&
                         std::ranges::all_of(word, [](char c) { return c >= 'a' && c <= 'z'; });
    if (!has_name && is_word) finding.cause[0] = static_cast<char>(finding.cause[0] - 'a' + 'A');
  }
  return findings;
}

std::string findingsHtml(const std::vector<Diagnosis>& findings, const std::string& next_text) {
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
    to += groupHtml(group);
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

std::string mainFindingText(const std::vector<Diagnosis>& findings) {
  const auto main = std::ranges::max_element(findings, {}, &Diagnosis::severity);
  if (main == findings.end() || main->severity < Severity::kWarning) return "";
  const auto num_more = std::ranges::count(findings, main->severity, &Diagnosis::severity) - 1;
  const std::string sentence = main->message();
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
  for (const std::string& line : lines) html += "<li>" + proseHtml(line) + "</li>\n";
  return html + "</ul></details>\n";
}

std::string viewSheet(const ReportData& data, const std::vector<std::string>& pictures,
                      const std::string& prefix) {
  std::vector<std::size_t> order(data.views.size());
  std::iota(order.begin(), order.end(), 0);
  std::ranges::stable_sort(
      order, [&](std::size_t a, std::size_t b) { return data.views[a].rms_px > data.views[b].rms_px; });
  std::string html =
      "<figure id=\"" + prefix +
      "view-sheet\" class=\"views wide\"><h3>Views, the largest error first</h3><figcaption "
      "class=\"reading\">Open a view to see its detected corners (circles) and where the camera projects "
      "them (crosses).</figcaption><div class=\"sheet-of-views\">\n";
  constexpr std::size_t kFew = 18;  // shown without folding
  const std::size_t num_shown = order.size() <= kFew ? order.size() : 12;
  constexpr std::size_t kLong = 12;  // a shared beginning so long that it hides the rest
  const std::size_t shared = sharedPrefix(mapped(data.views, &ReportedView::image));
  const std::size_t num_alike = shared >= kLong ? shared : 0;
  for (std::size_t i = 0; i < order.size(); ++i) {
    if (i == num_shown)
      html += fmt::format("</div><details><summary>{} more views</summary><div class=\"sheet-of-views\">\n",
                          order.size() - i);
    const std::size_t v = order[i];
    const ReportedView& view = data.views[v];
    const std::string name = escapedMarkup(view.image);
    const std::string words = "RMS " + rmsText(view.rms_px);
    html += fmt::format(
        "<button class=\"thumb\" type=\"button\" data-view=\"{}\" aria-label=\"Open view {}, {}\">",
        data.first_view + v, name, words);
    html += pictures[v].empty() ? cornersPicture(data, view)
                                : fmt::format("<img alt=\"\" width=\"{}\" height=\"{}\" src=\"{}\">",
                                              data.size.width, data.size.height, pictures[v]);
    const std::string shown =
        num_alike > 0 ? "…" + escapedMarkup(std::string_view(view.image).substr(num_alike)) : name;
    html +=
        fmt::format("<span class=\"name\">{}</span><span class=\"error\">{}</span></button>\n", shown, words);
  }
  return html + (order.size() > num_shown ? "</div></details></figure>\n" : "</div></figure>\n");
}

PageNumber withinTolerance(const ReportData& data) {
  return {"Within tolerance", percentText(data.accuracy->shareWithin(data.tolerance_px)),
          fmt::format("of {}, {:g} px", wholeName(*data.accuracy), data.tolerance_px), true};
}

std::string pageText(const PageContent& page, const json& evidence) {
  std::string html = headHtml(page.kind + ": " + page.title) + "<body>\n" + topHtml(page) + "<main>\n";
  for (const PageSection& section : page.sections) {
    html += fmt::format("<h2 id=\"{}\">{}</h2>\n", section.id, section.title);
    html += figuresHtml(section.figures, section.more);
  }
  if (!page.details.empty()) html += "<h2 id=\"details\">Details</h2>\n" + page.details;
  html += "</main>\n";
  if (html.find(" data-view=") != std::string::npos) html += kViewer;
  html += "<footer>The data are embedded in this file (element “evidence”).</footer>\n";
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
