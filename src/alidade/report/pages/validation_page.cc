// SPDX-License-Identifier: MIT
#include "alidade/report/pages/validation_page.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <numbers>
#include <numeric>
#include <optional>
#include <set>
#include <utility>
#include <vector>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "alidade/core/diagnosis_order.h"
#include "alidade/core/error.h"
#include "alidade/core/number_text.h"
#include "alidade/report/data/validation_data.h"
#include "alidade/report/figures/footage_figures.h"
#include "alidade/report/figures/image_figures.h"
#include "alidade/report/figures/lens_figures.h"
#include "alidade/report/figures/residual_figures.h"
#include "alidade/report/figures/undistorted_figure.h"
#include "alidade/report/figures/validation_figures.h"
#include "alidade/report/figures/view_figures.h"
#include "alidade/report/pages/page_shell.h"
#include "alidade/report/pages/page_table.h"
#include "alidade/report/pages/view_sheet.h"

namespace alidade {
namespace {

constexpr double kDegreesOfPage = 180 / std::numbers::pi;
constexpr std::size_t kMostRows = 50;   // of the table, before the others are folded
constexpr std::size_t kMostDrawn = 60;  // cameras; the page of more would be slow to open

std::string sizeWords(const ImageSize& size) {
  return fmt::format("{} × {} px", size.width, size.height);
}

const char* statusWords(Severity status) {
  return status == Severity::kFailure ? "failed" : status == Severity::kWarning ? "warnings" : "passed";
}

const char* statusClass(Severity status) {
  return status == Severity::kFailure ? "bad" : status == Severity::kWarning ? "fair" : "good";
}

Verdict verdictFor(Severity status) {
  return status == Severity::kFailure   ? Verdict::kNo
         : status == Severity::kWarning ? Verdict::kReservations
                                        : Verdict::kTrustworthy;
}

// All checks, those of several cameras with their names.
std::vector<Diagnosis> checksOf(const ReportedFile& file) {
  std::vector<Diagnosis> all;
  for (const ReportedCameraJudgement& camera : file.cameras) {
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

// Those that are more than a pass, the most severe first.
std::vector<Diagnosis> findingsOf(const ReportedFile& file) {
  std::vector<Diagnosis> found = checksOf(file);
  if (file.error) found.push_back(*file.error);
  std::erase_if(found, [](const Diagnosis& check) { return check.severity == Severity::kPass; });
  sortDiagnoses(found);
  return found;
}

// With which findings may begin.
std::vector<std::string> cameraNames(const ReportedFile& file) {
  if (file.cameras.size() <= 1) return {};
  std::vector<std::string> names = {"rig"};
  for (const ReportedCameraJudgement& camera : file.cameras) names.push_back(camera.name);
  return names;
}

std::string heldOutSentence(const ReportedHeldOut& tested) {
  std::string text = fmt::format(
      "On {} views of a board it predicts corners that had no part in the pose within {} RMS, where noise "
      "alone makes {}",
      tested.view_fixed_px.size(), rmsText(tested.rms_px), rmsText(tested.noise_rms_px));
  if (std::isfinite(tested.p95_px)) {
    text += fmt::format(
        "; the camera that these images give by themselves differs from it by {} (95\u00a0%) where boards "
        "were seen, which is {} of the image",
        errorText(tested.p95_px), percentText(tested.covered_share));
  }
  return text + ".";
}

std::string statementSentence(const ReportedStatement& stated) {
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

// The verdict on a file in one or two sentences.
std::string fileSentence(const ReportedFile& file, bool is_compared) {
  if (file.status >= Severity::kWarning) {
    std::string text = mainFindingText(findingsOf(file), cameraNames(file));
    if (!text.empty()) return text;
  }
  if (file.cameras.size() != 1)
    return fmt::format("The numbers of its {} cameras are sound.", file.cameras.size());
  const ReportedCameraJudgement& camera = file.cameras.front();
  if (camera.held_out) return heldOutSentence(*camera.held_out);
  if (camera.footage && camera.footage->verdict == "consistent") return footageSentence(camera.checks);
  std::string text = camera.stated ? statementSentence(*camera.stated) : "Its numbers are sound.";
  const auto against = std::ranges::find(camera.checks, "against", &Diagnosis::id);
  if (against != camera.checks.end()) text += " Compared with the other camera: " + against->cause + ".";
  if (!is_compared)
    text += " A file cannot show that its numbers are right: test it with --images, --footage or --against.";
  return text;
}

std::string headlineOf(const ReportedFile& file) {
  if (file.status == Severity::kFailure)
    return file.error ? "Failed: it cannot be read" : "Failed: do not use this camera";
  if (file.status == Severity::kWarning) return "Passed, with warnings";
  const bool is_confirmed =
      !file.cameras.empty() && std::ranges::all_of(file.cameras, [](const auto& camera) {
        return camera.held_out || (camera.footage && camera.footage->verdict == "consistent");
      });
  return is_confirmed ? "Passed: the images confirm it" : "Passed: no problem found";
}

std::string checksTable(const ReportedFile& file) {
  const std::vector<Diagnosis> checks = checksOf(file);
  if (checks.empty()) return "";
  std::vector<PageRow> rows;
  for (const Diagnosis& check : checks)
    rows.push_back({{check.id, std::string(severityName(check.severity)), check.cause}});
  return fmt::format(
      "<details><summary>All {} checks</summary>{}</details>\n", checks.size(),
      tableHtml("Checks", {{"Check", "words"}, {"Result", "words"}, {"What was found", "words found"}},
                rows));
}

// The sections of a camera's figures, apart from pictures of its views.
std::vector<PageSection> sectionsOf(const ReportedCameraJudgement& camera,
                                    const std::optional<RivalCamera>& rival) {
  std::vector<PageSection> sections;
  if (!camera.data) return sections;
  const ReportData& data = *camera.data;
  if (camera.held_out) {
    PageSection errors{.id = "errors", .title = "Errors on the images"};
    if (!data.views.empty()) {
      errors.figures.push_back(imageResidualsFigure(data));
      for (std::size_t b = 0; b < data.boards.size(); ++b) {
        const bool is_used =
            std::ranges::any_of(data.views, [&](const ReportedView& view) { return view.board == b; });
        if (is_used) errors.figures.push_back(boardResidualsFigure(data, b));
      }
      errors.figures.push_back(histogramFigure(data));
      if (camera.held_out->freed) errors.figures.push_back(freedDifferenceFigure(data, *camera.held_out));
      errors.figures.push_back(viewErrorsFigure(data));
      if (camera.held_out->freed) errors.figures.push_back(fixedFreedFigure(data, *camera.held_out));
    }
    sections.push_back(std::move(errors));
  }
  if (camera.footage) {
    PageSection footage{
        .id = "footage", .title = "Footage", .figures = {}, .more = footageTables(*camera.footage, "")};
    if (std::optional<Figure> figure = footageErrorsFigure(*camera.footage))
      footage.figures.push_back(*figure);
    sections.push_back(std::move(footage));
  }
  PageSection lens{.id = "lens", .title = "Lens"};
  if (rival) {
    try {
      lens.figures.push_back(differenceFigure(data, *rival));
    } catch (const Error&) {
      // Images of another shape: a check says so.
    }
  }
  if (data.accuracy) lens.figures.push_back(accuracyFigure(data));
  lens.figures.push_back(distortionGridFigure(data));
  lens.figures.push_back(radialFigure(data));
  sections.push_back(std::move(lens));
  return sections;
}

std::vector<PageNumber> numbersOf(const ReportedCameraJudgement& camera) {
  std::vector<PageNumber> numbers;
  const auto add = [&](const char* name, const std::string& value, const std::string& more,
                       bool is_accuracy = false) {
    numbers.push_back({.name = name, .value = value, .more = more, .is_accuracy = is_accuracy});
  };
  const auto px = [](double value) { return std::isfinite(value) ? rmsText(value) : std::string("unknown"); };
  if (camera.held_out) {
    const ReportedHeldOut& tested = *camera.held_out;
    add("Held-out error", px(tested.rms_px), fmt::format("RMS; noise alone: {}", px(tested.noise_rms_px)));
    if (std::isfinite(tested.p95_px))
      add("Difference", errorText(tested.p95_px), "95 %, from the camera of these images");
    add("File’s camera", px(tested.fixed_rms_px), "RMS with all corners");
    if (tested.freed) add("Camera of the images", px(tested.freed_rms_px), "RMS with all corners");
    add("Views", fmt::format("{} of {}", tested.view_fixed_px.size(), tested.num_views_given), "tested");
    add("Corners", std::to_string(tested.num_corners), "tested");
  }
  if (camera.footage && !camera.footage->checks.empty()) {
    const ReportedFootageCheck& check = camera.footage->checks.front();
    add("Footage", footageVerdictWords(camera.footage->verdict), fmt::format("{} frames", check.num_frames));
    if (std::isfinite(check.holdout_rms_px))
      add("Footage error", px(check.holdout_rms_px), "RMS of unseen pixels of points");
  }
  if (camera.stated && std::isfinite(camera.stated->accuracy_px))
    add("Stated accuracy", errorText(camera.stated->accuracy_px), "95 %, where boards were seen", true);
  if (camera.data) {
    const double end = camera.data->camera.cone().max_angle_rad * kDegreesOfPage;
    add("Model ends at", fmt::format("{:.1f}°", end), "from the optical axis");
    if (camera.data->accuracy) {
      const ReportedAccuracy& accuracy = *camera.data->accuracy;
      add("Within tolerance", percentText(accuracy.shareWithin(camera.data->tolerance_px)),
          fmt::format("of {}, {:g} px", accuracy.wholeName(), camera.data->tolerance_px), true);
    }
  }
  return numbers;
}

std::string subtitleOf(const ReportedFile& file) {
  if (file.error) return "";
  if (file.cameras.size() != 1) return fmt::format("{}, {} cameras", file.format, file.cameras.size());
  const ReportedCameraJudgement& camera = file.cameras.front();
  return fmt::format("{}, {}{}", file.format, camera.model.empty() ? "not supported" : camera.model,
                     camera.data ? ", " + sizeWords(camera.data->size) : "");
}

// The figures of one camera in a fold of the page.
std::string foldedFigures(const ReportedCameraJudgement& camera, const std::optional<RivalCamera>& rival,
                          const std::string& prefix) {
  if (!camera.data) return "<p class=\"note\">There are no figures of a camera without an image size.</p>\n";
  std::vector<Figure> figures;
  for (PageSection& section : sectionsOf(camera, rival))
    for (Figure& figure : section.figures) figures.push_back(withPrefix(std::move(figure), prefix));
  const std::string tables = camera.footage ? footageTables(*camera.footage, prefix) : "";
  return figuresHtml(figures, tables + judgedParameters(camera, prefix));
}

std::string filesTable(const std::vector<const ReportedFile*>& files, const std::vector<std::size_t>& numbers,
                       bool is_compared) {
  std::vector<PageRow> rows;
  for (std::size_t i = 0; i < files.size(); ++i) {
    const ReportedFile& file = *files[i];
    rows.push_back(
        {.cells = {statusWords(file.status), file.name, subtitleOf(file), fileSentence(file, is_compared)},
         .kind = statusClass(file.status),
         .link = fmt::format("#file{}", numbers[i])});
  }
  return tableHtml("Files",
                   {{"Verdict", "words status"},
                    {"File", "words name", true},
                    {"Camera", "words"},
                    {"What was found", "words found"}},
                   rows);
}

// Files that fail first, otherwise in their order.
std::vector<std::size_t> bySeverity(const std::vector<ReportedFile>& files) {
  std::vector<std::size_t> order(files.size());
  std::iota(order.begin(), order.end(), 0);
  std::ranges::stable_sort(order,
                           [&](std::size_t a, std::size_t b) { return files[a].status > files[b].status; });
  return order;
}

PageContent pageOfMany(const ReportedValidation& validation, bool is_compared) {
  const std::vector<ReportedFile>& files = validation.files;
  const std::size_t num_failed = validation.count(Severity::kFailure);
  const std::size_t num_warned = validation.count(Severity::kWarning);
  const Severity worst = num_failed > 0   ? Severity::kFailure
                         : num_warned > 0 ? Severity::kWarning
                                          : Severity::kPass;
  PageContent page{.kind = "Validation",
                   .title = fmt::format("{} camera files", files.size()),
                   .verdict = verdictFor(worst),
                   .created_by = validation.created_by};
  page.headline = num_failed > 0 ? fmt::format("{} of {} files failed", num_failed, files.size())
                                 : fmt::format("All {} files passed", files.size());
  page.sentence = fmt::format("{} passed without a warning, {} with warnings, and {} failed.",
                              files.size() - num_failed - num_warned, num_warned, num_failed);
  if (!validation.other_files.empty())
    page.sentence += fmt::format(" {} other files name no camera.", validation.other_files.size());
  if (!is_compared)
    page.sentence +=
        " Files cannot show that their numbers are right: test them with --images, --footage or --against.";
  const std::vector<std::size_t> order = bySeverity(files);
  const auto tableOf = [&](std::size_t from, std::size_t to) {
    std::vector<const ReportedFile*> rows;
    std::vector<std::size_t> numbers;
    for (std::size_t i = from; i < to; ++i) {
      rows.push_back(&files[order[i]]);
      numbers.push_back(order[i]);
    }
    return filesTable(rows, numbers, is_compared);
  };
  const std::size_t num_shown = std::min(kMostRows, files.size());
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
  for (const std::size_t f : order) {
    const ReportedFile& file = files[f];
    folds.more +=
        fmt::format("<details class=\"file\" id=\"file{}\"><summary><b class=\"{}\">{}</b> {}</summary>\n", f,
                    statusClass(file.status), statusWords(file.status), escapedMarkup(file.name));
    // The findings say it otherwise.
    if (file.status < Severity::kWarning)
      folds.more += "<p>" + escapedMarkup(fileSentence(file, is_compared)) + "</p>\n";
    folds.more += findingsHtml(findingsOf(file), cameraNames(file)) + checksTable(file);
    for (std::size_t c = 0; c < file.cameras.size(); ++c) {
      if (file.cameras.size() > 1)
        folds.more += fmt::format("<h3 class=\"camera\">{}</h3>\n", escapedMarkup(file.cameras[c].name));
      folds.more += ++num_drawn > kMostDrawn
                        ? "<p class=\"note\">Validate this file alone to see its figures.</p>\n"
                        : foldedFigures(file.cameras[c], validation.rival, fmt::format("file{}-{}-", f, c));
    }
    folds.more += "</details>\n";
  }
  folds.more += "</div>\n";
  page.sections = {std::move(table), std::move(folds)};
  page.details =
      listHtml(fmt::format("{} other files", validation.other_files.size()), validation.other_files);
  return page;
}

PageContent pageOfOne(const ReportedValidation& validation, bool is_compared, PictureSource source,
                      int num_jobs) {
  const ReportedFile& file = validation.files.front();
  PageContent page{.kind = "Validation",
                   .title = file.name,
                   .subtitle = subtitleOf(file),
                   .headline = headlineOf(file),
                   .verdict = verdictFor(file.status),
                   // Why a file failed is said of every page.
                   .sentence = file.status == Severity::kFailure ? "" : fileSentence(file, is_compared),
                   .findings = findingsOf(file),
                   .names = cameraNames(file),
                   .created_by = validation.created_by};
  page.details = checksTable(file) + listHtml(fmt::format("{} other files", validation.other_files.size()),
                                              validation.other_files);
  if (file.cameras.size() != 1) {
    for (std::size_t c = 0; c < file.cameras.size(); ++c) {
      PageSection section{.id = fmt::format("camera{}", c), .title = escapedMarkup(file.cameras[c].name)};
      section.more = "<div class=\"wide\">" +
                     foldedFigures(file.cameras[c], validation.rival, fmt::format("camera{}-", c)) +
                     "</div>\n";
      page.sections.push_back(std::move(section));
    }
    return page;
  }
  const ReportedCameraJudgement& camera = file.cameras.front();
  page.numbers = numbersOf(camera);
  page.sections = sectionsOf(camera, validation.rival);
  if (!camera.data) return page;
  if (camera.held_out) {
    page.details +=
        listHtml(fmt::format("{} views without corners that can be tested", camera.held_out->untested.size()),
                 camera.held_out->untested);
  }
  page.sections.push_back(
      {.id = "values", .title = "Parameters", .figures = {}, .more = judgedParameters(camera, "")});
  if (camera.data->covariance) page.sections.back().figures.push_back(correlationFigure(*camera.data));
  if (camera.data->views.empty()) return page;
  source.image_of = keepingOne(source.image_of, undistortedImageName(*camera.data));
  const std::vector<std::string> pictures = viewPictures(*camera.data, source, num_jobs);
  PageSection views{
      .id = "views", .title = "Views", .figures = {}, .more = viewSheet(*camera.data, pictures)};
  page.sections.insert(page.sections.begin() + 1, std::move(views));
  if (std::optional<Figure> figure = undistortedFigure(*camera.data, source.image_of))
    std::ranges::find(page.sections, "lens", &PageSection::id)->figures.push_back(*std::move(figure));
  return page;
}

}  // namespace

std::string validationPage(const nlohmann::json& result, const PictureSource& source, int num_jobs) {
  const ReportedValidation validation = readValidation(result);
  bool has_views = false;
  for (const ReportedFile& file : validation.files)
    for (const ReportedCameraJudgement& camera : file.cameras)
      has_views = has_views || (camera.data && !camera.data->views.empty());
  bool has_footage = false;
  for (const ReportedFile& file : validation.files)
    for (const ReportedCameraJudgement& camera : file.cameras) has_footage = has_footage || camera.footage;
  const bool is_compared = has_views || has_footage || validation.rival.has_value();
  PageContent page = validation.files.size() == 1 ? pageOfOne(validation, is_compared, source, num_jobs)
                                                  : pageOfMany(validation, is_compared);
  if (has_views) page.dialog = viewerHtml();
  return pageText(page, result);
}

}  // namespace alidade
