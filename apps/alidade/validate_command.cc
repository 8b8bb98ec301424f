// SPDX-License-Identifier: MIT
#include <algorithm>
#include <array>
#include <cstddef>
#include <filesystem>
#include <fstream>
#include <optional>
#include <sstream>

#include <fmt/format.h>
#include <CLI/CLI.hpp>
#include <pugixml.hpp>

#include "alidade/core/error.h"
#include "alidade/core/error_text.h"
#include "alidade/core/parallel.h"
#include "alidade/core/size_groups.h"
#include "alidade/core/text.h"
#include "alidade/files/atomic_file.h"
#include "alidade/files/camera_list.h"
#include "alidade/files/camera_source.h"
#include "alidade/report/json_output.h"
#include "alidade/validate/camera_checks.h"
#include "alidade/validate/file_tests.h"
#include "board_views.h"
#include "console.h"
#include "options.h"

namespace alidade {
namespace {

// All that was found out.
struct ValidationResult {
  std::vector<FileJudgement> files;
  std::vector<std::string> other_files;  // in folders; not camera files
  bool is_strict = false;                // a warning fails a file

  [[nodiscard]] bool isFailed(const FileJudgement& file) const {
    return file.severity() >= (is_strict ? Severity::kWarning : Severity::kFailure);
  }
};

// A failure, a warning or a pass.
Severity outcomeOf(const ValidationResult& result, const FileJudgement& file) {
  if (result.isFailed(file)) return Severity::kFailure;
  return file.severity() == Severity::kWarning ? Severity::kWarning : Severity::kPass;
}

struct Totals {
  std::size_t num_files = 0;
  std::size_t num_failed = 0;
  std::size_t num_warned = 0;  // passed, with warnings
  std::size_t num_others = 0;
};

Totals totalsOf(const ValidationResult& result) {
  Totals totals{.num_files = result.files.size(), .num_others = result.other_files.size()};
  for (const FileJudgement& file : result.files) {
    const Severity outcome = outcomeOf(result, file);
    totals.num_failed += outcome == Severity::kFailure ? 1 : 0;
    totals.num_warned += outcome == Severity::kWarning ? 1 : 0;
  }
  return totals;
}

// "PASS", "NOTE", "WARN" or "FAIL".
std::string_view statusLabel(Severity severity) {
  constexpr std::array<std::string_view, 4> kLabels = {"PASS", "NOTE", "WARN", "FAIL"};
  return kLabels.at(static_cast<std::size_t>(severity));
}

std::string totalsText(const Totals& totals) {
  std::string text = fmt::format("{} file{}: {} passed", totals.num_files, totals.num_files == 1 ? "" : "s",
                                 totals.num_files - totals.num_failed);
  if (totals.num_warned > 0) text += fmt::format(" ({} with warnings)", totals.num_warned);
  text += fmt::format(", {} failed", totals.num_failed);
  if (totals.num_others > 0) {
    text += fmt::format("; {} other file{} without a camera", totals.num_others,
                        totals.num_others == 1 ? "" : "s");
  }
  return text + "\n";
}

std::string cameraSizeText(const CameraJudgement& camera) {
  return camera.image_size ? sizeText(*camera.image_size) : "-";
}

std::string modelText(const CameraJudgement& camera) {
  return camera.camera ? std::string(camera.camera->modelId()) : "-";
}

// What a column says of all cameras of a file.
template <class TextOf>
std::string commonText(const FileJudgement& file, const TextOf& textOf) {
  if (file.cameras.empty()) return "-";
  const std::string first = textOf(file.cameras.front());
  const bool is_common = std::all_of(file.cameras.begin(), file.cameras.end(),
                                     [&](const CameraJudgement& camera) { return textOf(camera) == first; });
  return is_common ? first : "several";
}

// The most severe of what was found, and how much more there is; empty if the file passed.
std::string reasonText(const FileJudgement& file) {
  const Severity worst = file.severity();
  if (worst < Severity::kWarning) return "";
  if (!file.error.empty()) return printable(oneLine(file.error));
  std::vector<std::string> reasons;
  for (const CameraJudgement& camera : file.cameras) {
    for (const FileCheck& check : camera.checks) {
      if (check.severity != worst) continue;
      // A check that names a slip tells more than the others.
      reasons.insert(check.mended ? reasons.begin() : reasons.end(),
                     (file.cameras.size() > 1 ? camera.name + ": " : "") + check.id + ": " +
                         check.message.substr(0, check.message.find("\n  next: ")));
    }
  }
  for (const FileCheck& check : file.rig_checks) {
    if (check.severity == worst) reasons.push_back("rig: " + check.id + ": " + check.message);
  }
  if (reasons.size() > 1) reasons[0] += fmt::format(" (and {} more)", reasons.size() - 1);
  return printable(oneLine(reasons[0]));
}

// Outcome, file, model, image size, and what the file states of its calibration and what is wrong with it.
using Row = std::array<std::string, 5>;

Row rowOf(const ValidationResult& result, const FileJudgement& file) {
  const std::size_t num_cameras = file.cameras.size();
  std::string remark = reasonText(file);
  if (!file.rig_checks.empty() && remark.empty()) remark = "rig: " + file.rig_checks.front().message;
  if (num_cameras == 1 && file.cameras[0].calibration && !result.isFailed(file))
    remark = calibrationText(*file.cameras[0].calibration) + (remark.empty() ? "" : "; ") + remark;
  return {std::string(statusLabel(outcomeOf(result, file))), printable(file.file),
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

// Further lines of a message stay in its column.
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

std::string cameraText(const FileJudgement& file, const CameraJudgement& camera) {
  std::string text;
  if (file.cameras.size() > 1)
    text += fmt::format("  {}: {} {}\n", printable(camera.name), modelText(camera), cameraSizeText(camera));
  return text + checkLines(camera.checks);
}

std::string fileText(const ValidationResult& result, const FileJudgement& file) {
  std::string text = rowsText({rowOf(result, file)});
  if (!file.error.empty()) return text;
  for (const CameraJudgement& camera : file.cameras) text += cameraText(file, camera);
  if (!file.rig_checks.empty()) text += "  rig\n" + checkLines(file.rig_checks);
  const bool can_show_slips = std::all_of(file.cameras.begin(), file.cameras.end(),
                                          [](const CameraJudgement& c) { return c.can_show_slips; });
  if (!can_show_slips && !result.isFailed(file))
    text += "    A file cannot show that its numbers are right. Test it with --images or --against.\n";
  return text;
}

json checksJson(const std::vector<FileCheck>& list) {
  json checks = json::array();
  for (const FileCheck& check : list) {
    json values = json::object();
    for (const CheckValue& value : check.values) values[value.name] = value.value;
    checks.push_back({{"id", check.id},
                      {"status", severityName(check.severity)},
                      {"values", std::move(values)},
                      {"message", check.message}});
    if (check.mended) {
      checks.back()["slip"] = {
          {"id", check.slip},
          {"parameters", parametersJson(check.mended->parameterNames(), check.mended->parameters())}};
    }
  }
  return checks;
}

json cameraJson(const CameraJudgement& camera) {
  json document = {{"name", camera.name},
                   {"model", nullptr},
                   {"image_size", orNull(camera.image_size)},
                   {"calibration", nullptr},
                   {"checks", checksJson(camera.checks)}};
  if (const auto& stated = camera.calibration) {
    document["calibration"] = {{"verdict", verdictName(stated->verdict)},
                               {"accuracy_px", stated->accuracy_px},
                               {"accuracy_distance_m", stated->accuracy_distance_m},
                               {"covered_share", stated->covered_share}};
  }
  if (camera.camera) {
    document["model"] = camera.camera->modelId();
    document["parameters"] = parametersJson(camera.camera->parameterNames(), camera.camera->parameters());
  }
  return document;
}

// A line for each file, or only for those that failed.
std::string filesText(const ValidationResult& result, bool only_failed) {
  std::vector<Row> rows;
  for (const FileJudgement& file : result.files) {
    if (!only_failed || result.isFailed(file)) rows.push_back(rowOf(result, file));
  }
  return rowsText(rows);
}

// A line for each check of each file.
std::string checksText(const ValidationResult& result) {
  std::string text;
  for (const FileJudgement& file : result.files) text += fileText(result, file);
  for (const std::string& file : result.other_files)
    text += fmt::format("other {}  not a camera file\n", printable(file));
  return text;
}

std::string judgementJson(const ValidationResult& result) {
  const auto textOrNull = [](const std::string& text) { return text.empty() ? json(nullptr) : json(text); };
  json files = json::array();
  for (const FileJudgement& file : result.files) {
    json cameras = json::array();
    for (const CameraJudgement& camera : file.cameras) cameras.push_back(cameraJson(camera));
    files.push_back({{"file", file.file},
                     {"status", severityName(outcomeOf(result, file))},
                     {"format", textOrNull(file.format)},
                     {"error", textOrNull(file.error)},
                     {"cameras", std::move(cameras)},
                     {"rig_checks", checksJson(file.rig_checks)}});
  }
  const Totals totals = totalsOf(result);
  return jsonText({{"created_by", programName()},
                   {"strict", result.is_strict},
                   {"totals",
                    {{"files", totals.num_files},
                     {"passed", totals.num_files - totals.num_failed},
                     {"passed_with_warnings", totals.num_warned},
                     {"failed", totals.num_failed},
                     {"other_files", totals.num_others}}},
                   {"files", std::move(files)},
                   {"other_files", result.other_files}});
}

bool isJunitReport(const std::string& path) {
  std::ifstream file(path);
  std::string line;
  for (int i = 0; i < 2 && std::getline(file, line); ++i) {
    if (line.starts_with("<testsuites")) return true;
  }
  return false;
}

// JUnit XML: a test case for each file.
std::string junitText(const ValidationResult& result) {
  const Totals totals = totalsOf(result);
  pugi::xml_document document;
  pugi::xml_node declaration = document.append_child(pugi::node_declaration);
  declaration.append_attribute("version") = "1.0";
  declaration.append_attribute("encoding") = "UTF-8";
  pugi::xml_node suites = document.append_child("testsuites");
  pugi::xml_node suite = suites.append_child("testsuite");
  suite.append_attribute("name") = "alidade validate";
  for (pugi::xml_node node : {suites, suite}) {
    node.append_attribute("tests") = static_cast<unsigned long long>(totals.num_files);
    node.append_attribute("failures") = static_cast<unsigned long long>(totals.num_failed);
    node.append_attribute("errors") = 0;
  }
  for (const FileJudgement& file : result.files) {
    pugi::xml_node test = suite.append_child("testcase");
    test.append_attribute("classname") = "camera_file";
    test.append_attribute("name") = printable(file.file).c_str();
    const std::string text = fileText(result, file);
    if (result.isFailed(file)) {
      pugi::xml_node failure = test.append_child("failure");
      failure.append_attribute("message") = reasonText(file).c_str();
      failure.text().set(text.c_str());
    } else {
      test.append_child("system-out").text().set(text.c_str());
    }
  }
  std::ostringstream out;
  document.save(out, "  ", pugi::format_default, pugi::encoding_utf8);
  return out.str();
}

class ValidateCommand final : public Command {
 public:
  void setUp(CLI::App& app) override {
    app.footer(
        "Example: alidade validate camera.yaml\nExample: alidade validate calibrations/ --strict --junit "
        "report.xml\nExample: alidade validate camera.yaml --images photos/ --board "
        "checkerboard:9x6:25mm\nPrints a line for each file and the totals; --verbose adds a line for each "
        "check, --quiet prints only files that fail.\nFolders are searched with their sub-folders for yaml, "
        "yml, json, xml, txt, cameramodel and cam. Files that do not name\na camera are only counted. Of a "
        "rig, "
        "the poses are checked too.\n"
        "--images tests the camera on photographs that were not used for its calibration. Use 10 or "
        "more.\nFiles may have any supported format (docs/formats.md); FILE#NAME selects one camera of a "
        "file with several.\nExit code 0: no file failed; 1: no camera file, or --images or --against cannot "
        "be used; 3: a file failed.");
    app.add_option("file", files_, "Camera files, folders, or patterns in quotes");
    app.add_flag("--strict", is_strict_, "Treat warnings as failures");
    app.add_flag("--verbose", is_verbose_, "Print every check");
    app.add_option("--junit", junit_path_, "Write the result as JUnit XML to this file");
    addCameraOptions(app, camera_);
    app.add_option("--images", images_,
                   "Images of a board that were not used for the calibration: folders, files or patterns, or "
                   "corners files (.csv or .vnl)");
    addBoardOption(app, boards_);
    addDetectionOptions(app, detection_);
    app.add_option("--against", against_, "Camera file (any format) to compare with");
    takePixels(*app.add_option("--tolerance", tolerance_px_,
                               "Largest accepted error in pixels (95th percentile; --images: where boards "
                               "were seen), for --images and --against")
                    ->check(positiveNumber, "above 0")
                    ->capture_default_str());
    addCommonOptions(app, common_, true);
  }

  int run(const CLI::App&) override {
    if (files_.empty())
      throw missingError("validate", "no file", "camera files, or folders with camera files");
    const std::vector<ListedFile> listed = listCameraFiles(files_);
    checkJunitPath(listed);
    prepareComparisons();
    const ValidationResult result = judgeAll(listed);
    if (result.files.empty()) {
      throw inputError({.where = files_.front(),
                        .found = fmt::format("no camera file among {} file{}", listed.size(),
                                             listed.size() == 1 ? "" : "s"),
                        .expected = "at least one",
                        .next_step = "see docs/formats.md for the formats"});
    }
    if (!junit_path_.empty()) writeFileAtomically(junit_path_, junitText(result));
    print(result);
    const bool is_any_failed = std::any_of(result.files.begin(), result.files.end(),
                                           [&](const auto& file) { return result.isFailed(file); });
    return is_any_failed ? kUntrustworthyExit : 0;
  }

 private:
  void checkJunitPath(const std::vector<ListedFile>& listed) const {
    if (junit_path_ == "-") {
      throw usageError({.where = "--junit -",
                        .found = "standard output, which is used for the results",
                        .expected = "a file"});
    }
    std::vector<std::string> sources;
    for (const ListedFile& file : listed) {
      // A report of an earlier run in the same folder is replaced.
      if (!file.is_from_folder) sources.push_back(cameraFilePath(file.path));
    }
    checkOutput(junit_path_, sources, common_, "--junit");
    namespace fs = std::filesystem;
    std::error_code error;
    if (!junit_path_.empty() && fs::is_regular_file(junit_path_, error) && !isJunitReport(junit_path_)) {
      throw usageError({.where = "--junit " + junit_path_,
                        .found = "an existing file that is no JUnit report",
                        .expected = "a new file, or an earlier report",
                        .next_step = "choose another name, otherwise the file would be overwritten"});
    }
  }

  // Finds the boards and reads the other camera, once for all files that are tested.
  void prepareComparisons() {
    if (images_.empty() && !boards_.empty()) {
      throw usageError({.where = "validate",
                        .found = "--board without --images",
                        .expected = "--images FOLDER with images of the board"});
    }
    tests_.tolerance_px = tolerance_px_;
    tests_.jobs = common_.jobs;
    if (!against_.empty()) tests_.other = readCameraTelling(against_, {}, common_.quiet);
    if (images_.empty()) return;
    tests_.cancel = catchInterrupts();
    const GivenViews given = readViews({.command = "validate",
                                        .inputs = images_,
                                        .boards = boards_,
                                        .detection = detection_,
                                        .image_size = camera_.readOptions().image_size},
                                       common_, tests_.cancel);
    tests_.boards = given.boards;
    tests_.views = given.views;
    if (common_.quiet) return;
    for (const std::string& reason : given.reasons) printMessage("  " + reason);
    for (const std::string& note : given.notes) printMessage("note: " + note);
  }

  [[nodiscard]] ValidationResult judgeAll(const std::vector<ListedFile>& listed) const {
    std::vector<std::optional<FileJudgement>> judgements(listed.size());
    // The checks with images share out their own work.
    const int num_jobs = tests_.views.empty() ? common_.jobs : 1;
    parallelFor(listed.size(), num_jobs,
                [&](std::size_t i) { judgements[i] = judgeFile(listed[i], camera_.readOptions(), tests_); });
    ValidationResult result{.files = {}, .other_files = {}, .is_strict = is_strict_};
    for (std::size_t i = 0; i < listed.size(); ++i) {
      if (judgements[i]) {
        result.files.push_back(*std::move(judgements[i]));
      } else {
        result.other_files.push_back(listed[i].path);
      }
    }
    return result;
  }

  void print(const ValidationResult& result) const {
    if (common_.json) return printResult(judgementJson(result));
    if (common_.quiet) return printResult(filesText(result, true));
    printResult((is_verbose_ ? checksText(result) : filesText(result, false)) + totalsText(totalsOf(result)));
  }

  std::vector<std::string> files_;
  std::string junit_path_;
  bool is_strict_ = false;
  bool is_verbose_ = false;
  CameraOptions camera_;
  std::vector<std::string> images_;
  std::vector<std::string> boards_;
  DetectionOptions detection_;
  std::string against_;
  double tolerance_px_ = kDefaultTolerancePx;
  FileTests tests_;
};

}  // namespace

std::unique_ptr<Command> makeValidateCommand() {
  return std::make_unique<ValidateCommand>();
}

}  // namespace alidade
