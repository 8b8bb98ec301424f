// SPDX-License-Identifier: MIT
#include "alidade/report/pages/validation_page.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <numeric>
#include <optional>
#include <span>
#include <utility>
#include <vector>

#include <fmt/format.h>

#include "alidade/core/degrees.h"
#include "alidade/core/diagnosis.h"
#include "alidade/core/error.h"
#include "alidade/core/mapped.h"
#include "alidade/core/number_text.h"
#include "alidade/report/canvas/page_table.h"
#include "alidade/report/data/utf8.h"
#include "alidade/report/figures/camera_figures.h"
#include "alidade/report/figures/footage_figures.h"
#include "alidade/report/figures/validation_figures.h"
#include "alidade/report/pages/page_shell.h"

namespace alidade {
namespace {

constexpr const char* kOnlyWarnings = "Nothing else is wrong: with --strict, warnings count as failures.";
constexpr std::size_t kMostListed = 50;  // rows of the table before the rest is folded
constexpr std::size_t kMostDrawn = 60;   // cameras; a page with more would open slowly

std::string sizeWords(const ImageSize& size) {
  return fmt::format("{} × {} px", size.width, size.height);
}

const char* statusWords(Severity status) {
  return status == Severity::kFailure ? "failed" : status == Severity::kWarning ? "warnings" : "passed";
}

Verdict verdictFor(Severity status) {
  return status == Severity::kFailure   ? Verdict::kNo
         : status == Severity::kWarning ? Verdict::kReservations
                                        : Verdict::kTrustworthy;
}

const char* statusClass(Severity status) {
  return verdictClass(verdictFor(status));
}

// All checks; if there are several cameras, with their names.
std::vector<Diagnosis> checksOf(const JudgedFile& file) {
  std::vector<Diagnosis> all;
  for (const JudgedCamera& camera : file.cameras) {
    for (Diagnosis check : camera.checks) {
      if (file.cameras.size() > 1) check.cause = camera.name + ": " + check.cause;
      all.push_back(std::move(check));
    }
  }
  for (Diagnosis check : file.rig_checks) {
    check.cause = "rig: " + check.cause;
    all.push_back(std::move(check));
  }
  return all;
}

// The findings other than passes, the most severe first, as sentences. Names of cameras stay as they are.
std::vector<Diagnosis> findingsOf(const JudgedFile& file) {
  std::vector<std::string> names;
  if (file.cameras.size() > 1) names = mapped(file.cameras, &JudgedCamera::name);
  if (!names.empty()) names.emplace_back("rig");
  std::vector<Diagnosis> found = checksOf(file);
  if (file.error) found.push_back(*file.error);
  std::erase_if(found, [](const Diagnosis& check) { return check.severity == Severity::kPass; });
  sortDiagnoses(found);
  return asSentences(std::move(found), names);
}

std::string heldOutSentence(const JudgedCamera& camera) {
  const HeldOutJudgement& held_out = *camera.heldOut();
  std::string text = fmt::format(
      "On {} views of a board it predicts corners that had no part in the pose within {} RMS, where noise "
      "alone makes {}",
      camera.tested.size(), rmsText(held_out.held_out_rms_px), rmsText(held_out.noise_rms_px));
  if (held_out.difference && std::isfinite(held_out.difference->p95_px)) {
    text += fmt::format(
        "; the camera that these images give by themselves differs from it by {} (95\u00a0%) where boards "
        "were seen, which is {} of the image",
        errorText(held_out.difference->p95_px), percentText(held_out.covered_share));
  }
  return text + ".";
}

std::string statementSentence(const CalibrationRecord& stated) {
  std::string text = fmt::format("Its calibration was {}",
                                 stated.verdict == Verdict::kTrustworthy    ? "trustworthy"
                                 : stated.verdict == Verdict::kReservations ? "usable with reservations"
                                                                            : "rejected");
  if (std::isfinite(stated.accuracy_px)) {
    text += fmt::format(", accurate to {} (95\u00a0%) where boards were seen", errorText(stated.accuracy_px));
    if (std::isfinite(stated.covered_share))
      text += fmt::format(", which is {} of the image", percentText(stated.covered_share));
  }
  return text + ".";
}

// True if the camera was checked, either unchanged or edited for the image size.
bool hasCheck(const FootageJudgement& footage) {
  return !footage.isOtherSize() || !footage.edits.empty();
}

bool isConfirmedByFootage(const JudgedCamera& camera) {
  const auto& footage = camera.judgement->footage;
  return footage && footage->verdict() == FootageVerdict::kConsistent;
}

// The verdict on a file in one or two sentences.
std::string fileSentence(const JudgedFile& file, bool is_compared) {
  if (file.status >= Severity::kWarning) {
    std::string text = mainFindingText(findingsOf(file));
    if (file.isFailedByWarnings()) text += std::string(" ") + kOnlyWarnings;
    if (!text.empty()) return text;
  }
  if (file.cameras.size() != 1)
    return fmt::format("The numbers of its {} cameras are sound.", file.cameras.size());
  const JudgedCamera& camera = file.cameras.front();
  if (camera.heldOut() != nullptr) return heldOutSentence(camera);
  if (isConfirmedByFootage(camera)) return footageSentence(camera.checks);
  const auto& stated = camera.judgement->calibration;
  std::string text = stated ? statementSentence(*stated) : "Its numbers are sound.";
  const auto against = std::ranges::find(camera.checks, "against", &Diagnosis::id);
  if (against != camera.checks.end()) text += " Compared with the other camera: " + against->cause + ".";
  if (!is_compared)
    text += " A file cannot show that its numbers are right: test it with --images, --footage or --against.";
  return text;
}

std::string headlineOf(const JudgedFile& file) {
  if (file.status == Severity::kFailure)
    return file.error                  ? "Failed: it cannot be read"
           : file.isFailedByWarnings() ? "Failed: it has warnings, and --strict was given"
           : findingsOf(file).front().id == DiagnosisId("against")
               ? "Failed: it differs from the other camera"
           : file.cameras.size() > 1 ? "Failed: do not use this file"
                                     : "Failed: do not use this camera";
  if (file.status == Severity::kWarning) return "Passed, with warnings";
  const bool is_confirmed =
      !file.cameras.empty() && std::ranges::all_of(file.cameras, [](const auto& camera) {
        return camera.heldOut() != nullptr || isConfirmedByFootage(camera);
      });
  return is_confirmed ? "Passed: the images confirm it" : "Passed: no problem found";
}

std::string checksTable(const JudgedFile& file) {
  const std::vector<Diagnosis> checks = checksOf(file);
  if (checks.empty()) return "";
  std::vector<PageRow> rows;
  for (const Diagnosis& check : checks)
    rows.push_back({{std::string(check.id), std::string(severityName(check.severity)), check.cause}});
  return fmt::format(
      "<details><summary>All {} checks</summary>{}</details>\n", checks.size(),
      tableHtml("Checks", {{"Check", "words id"}, {"Result", "words"}, {"What was found", "words found"}},
                rows));
}

// The sections of a camera's figures, except pictures of its views.
std::vector<PageSection> sectionsOf(const JudgedCamera& camera, const std::optional<RivalCamera>& rival) {
  std::vector<PageSection> sections;
  if (!camera.data) return sections;
  const ReportData& data = *camera.data;
  if (const HeldOutJudgement* const held_out = camera.heldOut()) {
    PageSection errors{.id = "errors", .title = "Errors on the images"};
    if (!data.views.empty()) {
      errors.figures.push_back(imageResidualsFigure(data));
      append(errors.figures, boardResidualsFigures(data));
      errors.figures.push_back(histogramFigure(data));
      if (held_out->freed) errors.figures.push_back(freedDifferenceFigure(data, *held_out->freed));
      errors.figures.push_back(viewErrorsFigure(data));
      if (held_out->freed) errors.figures.push_back(fixedFreedFigure(camera));
    }
    sections.push_back(std::move(errors));
  }
  if (const auto& footage = camera.judgement->footage) {
    PageSection section{
        .id = "footage", .title = "Footage", .figures = {}, .more = footageTables(*footage, "")};
    if (std::optional<Figure> figure = footageErrorsFigure(*footage)) section.figures.push_back(*figure);
    sections.push_back(std::move(section));
  }
  PageSection lens{.id = "lens", .title = "Lens"};
  if (rival) {
    try {
      lens.figures.push_back(differenceFigure(data, *rival));
    } catch (const Error&) {
      // The aspect ratio differs; a check reports it.
    }
  }
  if (data.accuracy) lens.figures.push_back(accuracyFigure(data, true));
  append(lens.figures, lensFigures(data));
  sections.push_back(std::move(lens));
  return sections;
}

std::vector<PageNumber> numbersOf(const JudgedCamera& camera) {
  std::vector<PageNumber> numbers;
  const auto px = [](double value) { return std::isfinite(value) ? rmsText(value) : std::string("unknown"); };
  if (const HeldOutJudgement* const held_out = camera.heldOut()) {
    numbers.push_back({"Held-out error", px(held_out->held_out_rms_px),
                       fmt::format("RMS; noise alone: {}", px(held_out->noise_rms_px))});
    if (held_out->difference && std::isfinite(held_out->difference->p95_px))
      numbers.push_back(
          {"Difference", errorText(held_out->difference->p95_px), "95 %, from the camera of these images"});
    numbers.push_back({"File’s camera", px(held_out->fixed_rms_px), "RMS with all corners"});
    if (held_out->freed)
      numbers.push_back({"Camera of the images", px(held_out->freedRmsPx()), "RMS with all corners"});
    numbers.push_back(
        {"Views", fmt::format("{} of {}", camera.tested.size(), held_out->num_views_given), "tested"});
    numbers.push_back({"Corners", std::to_string(held_out->numCorners()), "tested"});
  }
  if (const auto& footage = camera.judgement->footage; footage && hasCheck(*footage)) {
    const FootageCheck& check = footage->check;
    numbers.push_back(
        {"Footage", footageVerdictWords(footage->verdict()), fmt::format("{} frames", check.num_frames)});
    if (check.num_windows > 0 && std::isfinite(check.holdout_rms_px))
      numbers.push_back({"Footage error", px(check.holdout_rms_px), "RMS of unseen pixels of points"});
  }
  if (const auto& stated = camera.judgement->calibration; stated && std::isfinite(stated->accuracy_px))
    numbers.push_back(
        {"Stated accuracy", errorText(stated->accuracy_px), "95 %, where boards were seen", true});
  if (camera.data) {
    const double end = camera.data->camera.cone().max_angle_rad * kDegPerRad;
    numbers.push_back({"Model ends at", fmt::format("{:.1f}°", end), "from the optical axis"});
    if (camera.data->accuracy) numbers.push_back(withinTolerance(*camera.data));
  }
  return numbers;
}

std::string subtitleOf(const JudgedFile& file) {
  if (file.error) return "";
  const std::string& format = file.judgement->format;
  if (file.cameras.size() != 1) return fmt::format("{}, {} cameras", format, file.cameras.size());
  const CameraJudgement& camera = *file.cameras.front().judgement;
  const std::string date = camera.calibration ? validUtf8(camera.calibration->date) : "";
  return fmt::format("{}, {}{}{}", format, camera.camera ? camera.camera->modelId() : "not supported",
                     camera.camera && camera.image_size ? ", " + sizeWords(*camera.image_size) : "",
                     date.empty() ? "" : ", calibrated: " + date);
}

// The figures of one camera in a foldable part of the page.
std::string foldedFigures(const JudgedCamera& camera, const std::optional<RivalCamera>& rival,
                          const std::string& prefix) {
  if (!camera.data) return "<p class=\"note\">There are no figures of a camera without an image size.</p>\n";
  std::vector<Figure> figures;
  for (PageSection& section : sectionsOf(camera, rival))
    for (Figure& figure : section.figures) figures.push_back(withPrefix(std::move(figure), prefix));
  const auto& footage = camera.judgement->footage;
  const std::string tables = footage ? footageTables(*footage, prefix) : "";
  return figuresHtml(figures, tables + judgedParameters(camera, prefix));
}

// @param numbers  indices of the files to list
std::string filesTable(const std::vector<JudgedFile>& files, std::span<const std::size_t> numbers,
                       bool is_compared) {
  std::vector<PageRow> rows;
  for (const std::size_t f : numbers) {
    const JudgedFile& file = files[f];
    rows.push_back(
        {.cells = {statusWords(file.status), file.name, subtitleOf(file), fileSentence(file, is_compared)},
         .kind = statusClass(file.status),
         .link = fmt::format("#file{}", f)});
  }
  return tableHtml("Files",
                   {{"Verdict", "words status"},
                    {"File", "words name", true},
                    {"Camera", "words"},
                    {"What was found", "words found"}},
                   rows);
}

// Files with failures first, otherwise in their original order.
std::vector<std::size_t> bySeverity(const std::vector<JudgedFile>& files) {
  std::vector<std::size_t> order(files.size());
  std::iota(order.begin(), order.end(), 0);
  std::ranges::stable_sort(order,
                           [&](std::size_t a, std::size_t b) { return files[a].status > files[b].status; });
  return order;
}

// A file's findings and figures, folded. Only the first kMostDrawn cameras of a page have figures.
std::string fileFold(const JudgedFile& file, std::size_t number, const std::optional<RivalCamera>& rival,
                     bool is_compared, std::size_t& num_drawn) {
  std::string html =
      fmt::format("<details class=\"file\" id=\"file{}\"><summary><b class=\"{}\">{}</b> {}</summary>\n",
                  number, statusClass(file.status), statusWords(file.status), escapedMarkup(file.name));
  // Otherwise the findings state it.
  if (file.status < Severity::kWarning)
    html += "<p>" + escapedMarkup(fileSentence(file, is_compared)) + "</p>\n";
  html += findingsHtml(findingsOf(file)) + checksTable(file);
  for (std::size_t c = 0; c < file.cameras.size(); ++c) {
    if (file.cameras.size() > 1)
      html += fmt::format("<h3 class=\"camera\">{}</h3>\n", escapedMarkup(file.cameras[c].name));
    html += ++num_drawn > kMostDrawn
                ? "<p class=\"note\">Validate this file alone to see its figures.</p>\n"
                : foldedFigures(file.cameras[c], rival, fmt::format("file{}-{}-", number, c));
  }
  return html + "</details>\n";
}

std::string otherFilesHtml(const ValidationResult& result) {
  return listHtml(counted(result.other_files.size(), "other file"), mapped(result.other_files, validUtf8));
}

// Numbers of verdicts, for several files.
void addTotals(const std::vector<JudgedFile>& files, const ValidationResult& result, bool is_compared,
               PageContent& page) {
  const auto numOf = [&](Severity status) {
    return static_cast<std::size_t>(std::ranges::count(files, status, &JudgedFile::status));
  };
  const std::size_t num_failed = numOf(Severity::kFailure);
  const std::size_t num_warned = numOf(Severity::kWarning);
  page.verdict = verdictFor(num_failed > 0   ? Severity::kFailure
                            : num_warned > 0 ? Severity::kWarning
                                             : Severity::kPass);
  page.headline = num_failed > 0 ? fmt::format("{} of {} files failed", num_failed, files.size())
                                 : fmt::format("All {} files passed", files.size());
  page.sentence = fmt::format("{} passed without a warning, {} with warnings, and {} failed.",
                              files.size() - num_failed - num_warned, num_warned, num_failed);
  if (result.is_strict) page.sentence += " With --strict, warnings count as failures.";
  if (!result.other_files.empty())
    page.sentence +=
        " Not among them: " + counted(result.other_files.size(), "other file") + " without a camera.";
  if (!is_compared)
    page.sentence +=
        " Files cannot show that their numbers are right: test them with --images, --footage or --against.";
}

PageContent pageOfMany(const std::vector<JudgedFile>& files, const ValidationResult& result,
                       bool is_compared) {
  PageContent page{
      .kind = "Validation", .title = fmt::format("{} camera files", files.size()), .origin = result.origin};
  addTotals(files, result, is_compared, page);
  const std::vector<std::size_t> order = bySeverity(files);
  const auto tableOf = [&](std::size_t from, std::size_t to) {
    return filesTable(files, std::span(order).subspan(from, to - from), is_compared);
  };
  const std::size_t num_shown = std::min(kMostListed, files.size());
  PageSection table{.id = "files", .title = "Files"};
  table.more = "<div class=\"wide\">" + tableOf(0, num_shown);
  if (num_shown < files.size()) {
    table.more += fmt::format("<details><summary>{} more files</summary>{}</details>",
                              files.size() - num_shown, tableOf(num_shown, files.size()));
  }
  table.more += "</div>\n";
  PageSection folds{.id = "each", .title = "Each file"};
  folds.more = "<div class=\"wide\">\n";
  std::size_t num_drawn = 0;
  for (const std::size_t f : order) folds.more += fileFold(files[f], f, result.rival, is_compared, num_drawn);
  folds.more += "</div>\n";
  page.sections = {std::move(table), std::move(folds)};
  page.details = otherFilesHtml(result);
  return page;
}

PageContent pageOfOne(const JudgedFile& file, const ValidationResult& result, bool is_compared,
                      PictureSource source, int num_jobs) {
  PageContent page{.kind = "Validation",
                   .title = file.name,
                   .subtitle = subtitleOf(file),
                   .origin = result.origin,
                   .headline = headlineOf(file),
                   .verdict = verdictFor(file.status),
                   // Every page states the reason of a failure anyway.
                   .sentence = file.isFailedByWarnings()           ? kOnlyWarnings
                               : file.status == Severity::kFailure ? ""
                                                                   : fileSentence(file, is_compared),
                   .findings = findingsOf(file),
                   .details = checksTable(file) + otherFilesHtml(result)};
  if (file.cameras.size() != 1) {
    for (std::size_t c = 0; c < file.cameras.size(); ++c) {
      PageSection section{.id = fmt::format("camera{}", c), .title = escapedMarkup(file.cameras[c].name)};
      section.more = "<div class=\"wide\">" +
                     foldedFigures(file.cameras[c], result.rival, fmt::format("camera{}-", c)) + "</div>\n";
      page.sections.push_back(std::move(section));
    }
    return page;
  }
  const JudgedCamera& camera = file.cameras.front();
  page.origin.camera = camera.judgement->label;
  page.numbers = numbersOf(camera);
  page.sections = sectionsOf(camera, result.rival);
  if (!camera.data) return page;
  if (camera.heldOut() != nullptr) {
    page.details += listHtml(
        fmt::format("{} views without corners that can be tested", camera.untested.size()), camera.untested);
  }
  page.sections.push_back(
      {.id = "values", .title = "Parameters", .figures = {}, .more = judgedParameters(camera, "")});
  if (camera.data->covariance) page.sections.back().figures.push_back(correlationFigure(*camera.data));
  if (camera.data->views.empty()) return page;
  source.image_of = keepingOne(source.image_of, undistortedImageName(*camera.data));
  const std::vector<std::string> pictures =
      viewPictures(*camera.data, camera.heldOut()->num_views_given, source, num_jobs);
  PageSection views{
      .id = "views", .title = "Views", .figures = {}, .more = viewSheet(*camera.data, pictures)};
  page.sections.insert(page.sections.begin() + 1, std::move(views));
  if (std::optional<Figure> figure = undistortedFigure(*camera.data, source.image_of))
    std::ranges::find(page.sections, "lens", &PageSection::id)->figures.push_back(*std::move(figure));
  return page;
}

}  // namespace

std::string validationPage(const ValidationResult& result, const nlohmann::json& document,
                           const PictureSource& source, int num_jobs) {
  const std::vector<JudgedFile> files = judgedFiles(result);
  bool is_compared = result.rival.has_value();
  for (const JudgedFile& file : files)
    for (const JudgedCamera& camera : file.cameras)
      is_compared = is_compared || !camera.tested.empty() || camera.judgement->footage;
  const PageContent page = files.size() == 1 ? pageOfOne(files.front(), result, is_compared, source, num_jobs)
                                             : pageOfMany(files, result, is_compared);
  return pageText(page, document);
}

}  // namespace alidade
