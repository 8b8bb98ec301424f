// SPDX-License-Identifier: MIT
#include "commands/validate/validation_output.h"

#include <algorithm>
#include <array>
#include <cstddef>
#include <vector>

#include <fmt/format.h>

#include "alidade/core/error_text.h"
#include "alidade/core/number_text.h"
#include "alidade/core/size_groups.h"
#include "alidade/core/text.h"
#include "console.h"
#include "junit.h"

namespace alidade {
namespace {

constexpr std::string_view kFootageStart = "footage: ";  // prefix of the check's reason
constexpr std::string_view kNextLine = "\n  next: ";
constexpr const char* kNoCamera = "not a camera file of a known format";

// "PASS", "NOTE", "WARN" or "FAIL".
std::string_view statusLabel(Severity severity) {
  constexpr std::array<std::string_view, 4> kLabels = {"PASS", "NOTE", "WARN", "FAIL"};
  return kLabels.at(static_cast<std::size_t>(severity));
}

std::string cameraSizeText(const CameraJudgement& camera) {
  return camera.image_size ? sizeText(*camera.image_size) : "-";
}

std::string modelText(const CameraJudgement& camera) {
  return camera.camera ? std::string(camera.camera->modelId()) : "-";
}

// The text of a column, for all cameras of a file.
template <class TextOf>
std::string commonText(const FileJudgement& file, const TextOf& textOf) {
  if (file.cameras.empty()) return "-";
  const std::string first = textOf(file.cameras.front());
  const bool is_common = std::all_of(file.cameras.begin(), file.cameras.end(),
                                     [&](const CameraJudgement& camera) { return textOf(camera) == first; });
  return is_common ? first : "several";
}

// The most severe finding, and the number of others; empty if the file passed.
std::string reasonText(const FileJudgement& file) {
  const Severity worst = file.severity();
  if (worst < Severity::kWarning) return "";
  if (!file.error.empty()) return printable(oneLine(file.error));
  std::vector<std::string> reasons;
  for (const CameraJudgement& camera : file.cameras) {
    for (const FileCheck& check : camera.checks) {
      if (check.severity != worst) continue;
      // A check that names a slip is the most informative.
      reasons.insert(check.mended ? reasons.begin() : reasons.end(),
                     (file.cameras.size() > 1 ? camera.name + ": " : "") + std::string(check.id) + ": " +
                         check.message.substr(0, check.message.find(kNextLine)));
    }
  }
  for (const FileCheck& check : file.rig_checks) {
    if (check.severity == worst) reasons.push_back("rig: " + std::string(check.id) + ": " + check.message);
  }
  if (reasons.size() > 1) reasons[0] += fmt::format(" (and {} more)", reasons.size() - 1);
  return printable(oneLine(reasons[0]));
}

// 0: no camera of the file folds over inside its image; 1: before a corner; 2: before the edge. `text` gets
// the finding.
int foldOf(const FileJudgement& file, std::string* text = nullptr) {
  int fold = 0;
  for (const CameraJudgement& camera : file.cameras) {
    for (const FileCheck& check : camera.checks) {
      const auto found =
          std::ranges::find(check.values, "folds_before_edge", &CheckValues::value_type::first);
      if (found == check.values.end()) continue;
      fold = std::max(fold, found->second > 0 ? 2 : 1);
      if (text != nullptr) *text = std::string(check.id) + ": " + check.message;
    }
  }
  return fold;
}

// The check of the file's only camera on footage, if there was one.
const FileCheck* footageCheckOf(const FileJudgement& file) {
  if (file.cameras.size() != 1) return nullptr;
  const std::vector<FileCheck>& checks = file.cameras.front().checks;
  const auto found = std::ranges::find(checks, "footage", &FileCheck::id);
  return found == checks.end() ? nullptr : &*found;
}

// "footage: consistent ...", if footage found nothing wrong.
std::string footageRemark(const FileJudgement& file) {
  const FileCheck* const check = footageCheckOf(file);
  if (check == nullptr || check->severity >= Severity::kWarning) return "";
  return printable(oneLine(std::string(kFootageStart) + check->message));
}

// A separate line with the next step, if the reason in a file's line comes from footage.
std::string footageNextStep(const FileJudgement& file) {
  const FileCheck* const check = footageCheckOf(file);
  if (check == nullptr || !reasonText(file).starts_with(kFootageStart)) return "";
  const std::size_t end = check->message.find(kNextLine);
  return end == std::string::npos ? "" : "\n      " + printable(oneLine(check->message.substr(end + 3)));
}

// Outcome, file, model, image size, and the stated calibration with the errors found.
using Row = std::array<std::string, 5>;

Row rowOf(const ValidationResult& result, const FileJudgement& file) {
  const std::size_t num_cameras = file.cameras.size();
  std::string remark = reasonText(file);
  std::string fold;
  if (foldOf(file, &fold) > 0 && remark.find("one_to_one: ") == std::string::npos)
    remark += (remark.empty() ? "" : "; ") + fold;
  if (!file.rig_checks.empty() && remark.empty()) remark = "rig: " + file.rig_checks.front().message;
  if (const std::string more = footageRemark(file); !more.empty())
    remark += (remark.empty() ? "" : "; ") + more;
  if (num_cameras == 1 && file.cameras[0].calibration && !result.isFailed(file))
    remark = calibrationText(*file.cameras[0].calibration) + (remark.empty() ? "" : "; ") + remark;
  return {std::string(statusLabel(result.outcomeOf(file))), printable(file.file),
          (num_cameras > 1 ? std::to_string(num_cameras) + " " : "") + commonText(file, modelText),
          commonText(file, cameraSizeText), remark};
}

std::string rowsText(const std::vector<Row>& rows) {
  // One long name must not push all other rows to the right.
  constexpr std::array<std::size_t, 5> kMaxWidths = {4, 60, 1000, 1000, 0};
  std::array<std::size_t, 5> widths{};
  for (const Row& row : rows) {
    for (std::size_t c = 0; c < row.size(); ++c)
      widths[c] = std::max(widths[c], std::min(kMaxWidths[c], row[c].size()));
  }
  std::string text;
  for (const Row& row : rows) {
    std::string line = row[0];
    for (std::size_t c = 1; c < row.size(); ++c) line += fmt::format("  {:<{}}", row[c], widths[c]);
    line.erase(line.find_last_not_of(' ') + 1);
    text += line + "\n";
  }
  return text;
}

// Continuation lines of a message stay in its column.
std::string indented(const std::string& message) {
  std::string text;
  for (const std::string_view line : split(message, '\n'))
    text += (text.empty() ? "" : fmt::format("\n{:27}", "")) + printable(line);
  return text;
}

std::string checkLines(const std::vector<FileCheck>& checks) {
  std::string text;
  for (const FileCheck& check : checks) {
    text +=
        fmt::format("    {}  {:<17}  {}\n", statusLabel(check.severity), check.id, indented(check.message));
  }
  return text;
}

std::string changeLines(const FootageCheck& check) {
  std::string text;
  for (std::size_t i = 0; i < check.changes.size(); ++i) {
    const CameraChange& change = check.changes[i];
    text += fmt::format(
        "      {:<15}  {}; displaces points by {:.1f} px, surely by {:.1f} px; squared errors {:.0f} % "
        "less{}\n",
        changeId(change.kind), describe(change), change.effect_px, change.sure_px,
        std::max(0.0, 100 * change.cost_drop), check.explanation == i ? "; best explanation" : "");
  }
  return text;
}

std::string footageCheckLines(const FootageJudgement& judgement, const FootageCheck& check) {
  std::string text =
      fmt::format("      {} of {} frames in {}, {} points, {} pixels; parallax {:.0f} px\n", check.num_frames,
                  judgement.num_frames_given, counted(check.num_windows, "window"), check.num_points,
                  check.num_pixels, check.parallax_px);
  if (check.num_windows > 0)
    text += fmt::format("      held-out error {:.2f} px RMS, noise {:.2f} px\n", check.holdout_rms_px,
                        check.noise_px);
  return text + changeLines(check);
}

// The details of the footage check: the changes tried, and their results. Lines are indented.
std::string footageLines(const FootageJudgement& judgement) {
  if (judgement.edits.empty()) return footageCheckLines(judgement, judgement.check);
  std::string text;
  for (const FootageEdit& edit : judgement.edits) {
    text += fmt::format("    {}: {}\n", editFlags(edit.request), verdictId(edit.check.verdict));
    text += footageCheckLines(judgement, edit.check);
  }
  return text;
}

std::string fileText(const ValidationResult& result, const FileJudgement& file) {
  std::string text = rowsText({rowOf(result, file)});
  if (!file.error.empty()) return text;
  for (const CameraJudgement& camera : file.cameras) {
    if (file.cameras.size() > 1)
      text += fmt::format("  {}: {} {}\n", printable(camera.name), modelText(camera), cameraSizeText(camera));
    text += checkLines(camera.checks);
    if (camera.footage) text += footageLines(*camera.footage);
  }
  if (!file.rig_checks.empty()) text += "  rig\n" + checkLines(file.rig_checks);
  const bool can_show_slips = std::all_of(file.cameras.begin(), file.cameras.end(),
                                          [](const CameraJudgement& c) { return c.can_show_slips; });
  if (!can_show_slips && !result.isFailed(file))
    text +=
        "    A file cannot show that its numbers are right. Test it with --images, --footage or --against.\n";
  return text;
}

// A file without its footage findings, which are a separate test case.
FileJudgement withoutFootage(FileJudgement file) {
  for (CameraJudgement& camera : file.cameras) {
    std::erase_if(camera.checks, [](const FileCheck& check) { return check.id.starts_with("footage"); });
    camera.footage.reset();
  }
  return file;
}

TestCase testCase(const ValidationResult& result, const FileJudgement& file, const char* kind) {
  TestCase test{.kind = kind, .name = file.file, .text = fileText(result, file)};
  if (result.isFailed(file)) test.failure = reasonText(file);
  return test;
}

}  // namespace

std::size_t numWith(const ValidationResult& result, Severity outcome) {
  return static_cast<std::size_t>(std::ranges::count_if(
      result.files, [&](const FileJudgement& file) { return result.outcomeOf(file) == outcome; }));
}

std::string totalsText(const ValidationResult& result) {
  const std::size_t num_failed = numWith(result, Severity::kFailure);
  const std::size_t num_warned = numWith(result, Severity::kWarning);
  const std::size_t num_others = result.other_files.size();
  const auto numFolding = [&](int least) {
    return std::ranges::count_if(result.files,
                                 [&](const FileJudgement& file) { return foldOf(file) >= least; });
  };
  constexpr int kEdge = 2;
  const std::string folds =
      numFolding(1) < 2
          ? ""
          : fmt::format(
                "{} files have a lens that folds over before the image corner, {} of them before "
                "the edge (one_to_one)\n",
                numFolding(1), numFolding(kEdge));
  return folds + fmt::format("{}: {} passed{}, {} failed{}\n", counted(result.files.size(), "file"),
                             result.files.size() - num_failed,
                             num_warned > 0 ? fmt::format(" ({} with warnings)", num_warned) : "", num_failed,
                             num_others > 0
                                 ? "; " + counted(num_others, "other file") + " without a readable camera"
                                 : "");
}

std::string filesText(const ValidationResult& result, bool only_failed) {
  std::vector<Row> rows;
  for (const FileJudgement& file : result.files) {
    if (only_failed && !result.isFailed(file)) continue;
    rows.push_back(rowOf(result, file));
    rows.back().back() += footageNextStep(file);
  }
  return rowsText(rows);
}

std::string checksText(const ValidationResult& result) {
  std::string text;
  for (const FileJudgement& file : result.files) text += fileText(result, file);
  for (const std::string& file : result.other_files)
    text += fmt::format("other {}  {}\n", printable(file), kNoCamera);
  return text;
}

std::string junitText(const ValidationResult& result) {
  std::vector<TestCase> cases;
  for (const FileJudgement& file : result.files) {
    cases.push_back(testCase(result, withoutFootage(file), "camera_file"));
    if (footageCheckOf(file) == nullptr) continue;
    FileJudgement on_footage = file;
    std::erase_if(on_footage.cameras.front().checks,
                  [](const FileCheck& check) { return !check.id.starts_with("footage"); });
    cases.push_back(testCase(result, on_footage, "footage"));
  }
  for (const std::string& file : result.other_files)
    cases.push_back({.kind = "other_file", .name = file, .skipped = kNoCamera});
  return junitText("alidade validate", cases);
}

}  // namespace alidade
