// SPDX-License-Identifier: MIT
#include <algorithm>
#include <cmath>
#include <optional>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "alidade/core/error.h"
#include "alidade/core/error_text.h"
#include "alidade/core/mapped.h"
#include "alidade/core/median.h"
#include "alidade/core/number_text.h"
#include "alidade/core/size_groups.h"
#include "alidade/core/text.h"
#include "alidade/files/camera_source.h"
#include "alidade/files/text/atomic_file.h"
#include "alidade/fleet/fleet.h"
#include "alidade/fleet/fleet_findings.h"
#include "alidade/report/data/fleet_json.h"
#include "alidade/report/data/json_output.h"
#include "alidade/report/pages/fleet_page.h"
#include "camera_files.h"
#include "command.h"
#include "console.h"
#include "outputs.h"
#include "page_file.h"
#include "summary_lines.h"

namespace alidade {
namespace {

// "trustworthy 950, with reservations 40, rejected 2, none stated 8"
std::string verdictsText(const Fleet& fleet) {
  std::vector<std::string> parts;
  const auto add = [&](std::optional<Verdict> verdict, const char* words) {
    const std::size_t count = fleet.count(verdict);
    if (count > 0) parts.push_back(fmt::format("{} {}", count, words));
  };
  add(Verdict::kTrustworthy, "trustworthy");
  add(Verdict::kReservations, "usable with reservations");
  add(Verdict::kNo, "rejected");
  add(std::nullopt, "without a verdict");
  std::vector<double> accuracies;
  for (const FleetUnit& unit : fleet.files.units)
    if (std::isfinite(unit.accuracy_px)) accuracies.push_back(unit.accuracy_px);
  std::string text = join(parts, ", ");
  if (accuracies.empty()) return text;
  const double worst = std::ranges::max(accuracies);
  return text + fmt::format("; accuracy {} (median), worst {}", pixels(medianOf(std::move(accuracies))),
                            pixels(worst));
}

// "fx 1002.3 +- 3.5", with two digits of the spread between units.
Lines spreadLines(const TypicalCamera& typical) {
  constexpr std::size_t kPerLine = 4;
  const auto names = typical.camera.parameterNames();
  Lines lines;
  std::string line;
  for (std::size_t j = 0; j < names.size(); ++j) {
    const auto at = static_cast<Eigen::Index>(j);
    const double mean = typical.population.mean(at);
    const double std = std::sqrt(std::max(0.0, typical.population.between(at, at)));
    const int decimals = decimalsFor(std, std::abs(mean) < 10 ? 5 : 3);
    const std::string value = std > 0 ? fmt::format("{:.{}f} +- {:.{}f}", mean, decimals, std, decimals)
                                      : fmt::format("{:.5g} in all", mean);
    line += fmt::format("{:<20}  ", fmt::format("{} {}", names[j], value));
    if (j % kPerLine + 1 < kPerLine && j + 1 < names.size()) continue;
    line.erase(line.find_last_not_of(' ') + 1);
    lines.push_back(fmt::format("{:<{}}{}", lines.empty() ? "Spread" : "", kIndent, line));
    line.clear();
  }
  return lines;
}

Lines groupLines(const FleetGroup& group, double tolerance_px, bool has_spread) {
  Lines lines;
  if (group.typical) {
    const TypicalCamera& typical = *group.typical;
    addLines(lines, "Typical", "{}, {} px, from {} of {} units; 95 % of the units are within {} of it",
             typical.camera.modelId(), sizeText(group.size), typical.population.numMembers(),
             group.units.size(), pixels(group.p95_px));
    if (has_spread) append(lines, spreadLines(typical));
  }
  append(lines, wrapped("Serves", servingSentence(group, tolerance_px)));
  return lines;
}

std::string fleetSummary(const Fleet& fleet, bool is_verbose) {
  constexpr std::size_t kMostGroups = 2;
  constexpr std::size_t kMostFindings = 3;
  Lines lines = wrapped("Fleet", fmt::format("{} in {}", counted(fleet.files.units.size(), "camera"),
                                             counted(fleet.files.num_files, "file")));
  append(lines, wrapped("Verdicts", verdictsText(fleet)));
  const std::size_t num_groups =
      is_verbose ? fleet.groups.size() : std::min(kMostGroups, fleet.groups.size());
  for (std::size_t g = 0; g < num_groups; ++g)
    append(lines, groupLines(fleet.groups[g], fleet.tolerance_px, g == 0 || is_verbose));
  if (num_groups < fleet.groups.size())
    addLines(lines, "", "{} more image size{}", fleet.groups.size() - num_groups,
             fleet.groups.size() == num_groups + 1 ? "" : "s");
  if (fleet.has_previous) {
    addLines(lines, "Drift", "{} of {} units with a previous calibration changed", fleet.numDrifted(),
             fleet.drifts.size());
  }
  std::size_t num_warnings = 0;
  std::size_t num_notes = 0;
  std::size_t num_shown = 0;
  for (const Diagnosis& finding : fleetFindings(fleet)) {
    const Lines found = diagnosisLines(finding);
    const bool is_shown =
        is_verbose || (finding.severity >= Severity::kWarning && num_shown < kMostFindings &&
                       lines.size() + found.size() < kMaxLines);
    if (is_shown) {
      append(lines, found);
      ++num_shown;
    } else {
      ++(finding.severity >= Severity::kWarning ? num_warnings : num_notes);
    }
  }
  append(lines, moreLines(num_warnings, num_notes));
  return join(lines, "\n") + "\n";
}

class FleetCommand final : public Command {
 public:
  void setUp(Flags& flags) override {
    flags.explain(
        "Example: alidade fleet calibrations/ -o fleet.html\nExample: alidade fleet now/ --previous before/ "
        "--tolerance 0.5px -o fleet.csv --typical typical.yaml\nCameras of one image size are compared with "
        "their typical camera, after the best rotation. Units are paired with their\nprevious calibration by "
        "serial number, name or file name.\nExit code 1: no camera file can be read. Exit code 3 with "
        "--strict: a unit deviates or changed, or a file cannot be read.");
    flags.add("file", &files_, "Camera files, folders, or patterns in quotes", kFilePath);
    flags.add("-o,--output", &output_,
              "What to write: a page with figures (.html) or a row for each unit (.csv)",
              {.word = kFilePath.word, .complaint = outputComplaint});
    addDateFlag(flags, date_);
    flags.add("--typical", &typical_,
              "Camera file to write: the typical camera of the largest group, with the spread between "
              "units as its covariance",
              kFilePath);
    flags.add("--previous", &previous_,
              "Earlier calibrations of the same cameras: files, folders or patterns", kFilePath);
    flags.add("--tolerance", &tolerance_px_,
              "Largest accepted distance from the typical camera in pixels, for 95 % of the image",
              {.complaint = pixelComplaint, .number = pixelsOrNan});
    flags.addSwitch("--same-frame", same_frame_, "Do not align: all cameras have the same frame");
    flags.addSwitch("--strict", is_strict_,
                    "Exit code 3 if a unit deviates or changed, or a file cannot be read");
    flags.addSwitch("--verbose", is_verbose_, "Print all groups and findings");
    addReadOptions(flags, camera_);
    flags.addCommon(common_, true);
  }

  int run(const Flags&) override {
    if (files_.empty()) throw missing("no file", "camera files, or folders with camera files");
    checkUsage();
    common_.cancel = catchInterrupts();
    FleetFiles files = readFiles(files_, "reading");
    if (files.units.empty()) throw nothingToRead(files);
    std::optional<FleetFiles> previous;
    if (!previous_.empty()) previous = readFiles(previous_, "reading previous");
    const Fleet fleet = analyse(std::move(files), previous);
    write(fleet);
    answer([&] { return jsonText(fleetJson(fleet, programName())); },
           [&] { return fleetSummary(fleet, is_verbose_); });
    tell(fleet);
    const bool is_clean = fleet.numDeviating() == 0 && fleet.numDrifted() == 0 &&
                          fleet.files.unreadable.empty() && fleet.unreadable_previous.empty();
    return is_strict_ && !is_clean ? kUntrustworthyExit : 0;
  }

 private:
  static std::string outputComplaint(const std::string& text) {
    if (text.ends_with(".html") || text.ends_with(".csv")) return {};
    return "found '" + text + "', expected a file name that ends in .html or .csv";
  }

  // Outputs must not be among the files in the searched folders.
  void checkUsage() const {
    std::vector<std::string> sources;
    for (const auto* inputs : {&files_, &previous_}) {
      for (const ListedFile& file : listCameraFiles(*inputs)) sources.push_back(cameraFilePath(file.path));
    }
    sources.push_back(common_.config);
    checkOutputs(std::vector<Output>{{"--output", output_}, {"--typical", typical_}}, sources, common_);
  }

  [[nodiscard]] FleetFiles readFiles(const std::vector<std::string>& inputs, const char* label) const {
    ProgressBar bar(label, common_.quiet);
    return readFleetFiles(
        inputs,
        {.read = camera_, .jobs = common_.jobs, .cancel = common_.cancel, .progress = bar.reporter()});
  }

  [[nodiscard]] Fleet analyse(FleetFiles files, const std::optional<FleetFiles>& previous) const {
    ProgressBar bar("comparing", common_.quiet);
    FleetOptions options{.tolerance_px = tolerance_px_,
                         .jobs = common_.jobs,
                         .cancel = common_.cancel,
                         .progress = bar.reporter()};
    if (same_frame_) options.freed.reset();
    return analyseFleet(std::move(files), previous, options);
  }

  [[nodiscard]] Error nothingToRead(const FleetFiles& files) const {
    if (files.unreadable.empty()) {
      return inputError({.where = files_.front(),
                         .found = fmt::format("no camera file among {} files", files.other_files.size()),
                         .expected = "at least one",
                         .next_step = "see docs/formats.md for the formats"});
    }
    return inputError(
        {.where = files_.front(),
         .found = fmt::format("{} camera files, of which none can be read; the first: {}",
                              files.unreadable.size(), oneLine(files.unreadable.front().reason)),
         .expected = "at least one that can be read",
         .next_step = "run alidade validate on them"});
  }

  void write(const Fleet& fleet) const {
    if (output_.ends_with(".csv")) {
      writeFileAtomically(output_, fleetCsv(fleet));
    } else if (!output_.empty()) {
      writeFileAtomically(output_, fleetPage(fleet, originOf(files_, date_, {{"--previous", previous_}})));
    }
    if (typical_.empty()) return;
    if (!fleet.groups.front().typical) {
      throw inputError({.where = "--typical " + typical_,
                        .found = fmt::format("{} units of {} px", fleet.groups.front().units.size(),
                                             sizeText(fleet.groups.front().size)),
                        .expected = fmt::format("at least {} of one model", kFewestUnits),
                        .next_step = "add more files of this kind of camera"});
    }
    saveCamera(typical_, typicalRecord(fleet.groups.front(), tolerance_px_, maker()), "alidade");
  }

  void tell(const Fleet& fleet) const {
    if (common_.quiet) return;
    tellUnreadable(fleet.files.unreadable, "");
    tellUnreadable(fleet.unreadable_previous, "previous ");
    if (!output_.empty())
      printMessage((output_.ends_with(".csv") ? "table" : "report") + std::string(" written to ") + output_);
    if (!typical_.empty()) printMessage("typical camera written to " + typical_);
  }

  static void tellUnreadable(const std::vector<UnreadableFile>& files, const char* kind) {
    printListed(mapped(files, [](const UnreadableFile& file) { return oneLine(file.reason); }),
                fmt::format("warning: {} left out:", counted(files.size(), std::string(kind) + "file")));
  }

  std::vector<std::string> files_;
  std::string output_;
  std::string date_;
  std::string typical_;
  std::vector<std::string> previous_;
  double tolerance_px_ = 1;
  bool same_frame_ = false;
  bool is_strict_ = false;
  bool is_verbose_ = false;
  ReadOptions camera_;
};

}  // namespace

const CommandEntry kFleetCommand = {"fleet", "See what many camera files of one kind say together",
                                    made<FleetCommand>};

}  // namespace alidade
