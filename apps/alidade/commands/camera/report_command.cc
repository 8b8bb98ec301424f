// SPDX-License-Identifier: MIT
#include <algorithm>
#include <cmath>

#include <CLI/CLI.hpp>

#include "alidade/core/error.h"
#include "alidade/files/camera_source.h"
#include "alidade/files/text/atomic_file.h"
#include "alidade/imagery/image_list.h"
#include "alidade/report/data/json_output.h"
#include "console.h"
#include "options.h"
#include "pending_folder.h"
#include "report_output.h"

namespace alidade {
namespace {

constexpr std::size_t kMaxEvidenceBytes = std::size_t{1} << 30U;

class ReportCommand final : public Command {
 public:
  void setUp(CLI::App& app) override {
    app.footer(
        "Example: alidade report evidence.json -o page.html --images photos/\n"
        "The page is the same as that of alidade calibrate --report.");
    app.add_option(
           "file", file_,
           "Evidence file (JSON) of alidade calibrate --evidence; or the camera file, with --evidence")
        ->type_name(kFileValue);
    app.add_option("--evidence", evidence_, "Evidence file of the camera file")->type_name(kFileValue);
    app.add_option("--images", images_,
                   "Images that the camera was calibrated from, for pictures of the views: folders, files, "
                   "patterns or videos")
        ->type_name(kFileValue);
    app.add_option("--against", against_, "Camera file (any format) to compare with")->type_name(kFileValue);
    app.add_option("-o,--output", output_, "HTML page to write")->type_name(kFileValue);
    app.add_option("--figures", figures_, "Folder to create, with the figures as SVG files")
        ->type_name(kFolderValue);
    app.add_flag("--overwrite", overwrite_,
                 "Replace an earlier, unchanged folder of figures; other files are never changed");
    addCommonOptions(app, common_, true);
  }

  int run(const CLI::App&) override {
    if (file_.empty())
      throw missingError("report", "no file", "an evidence file, or a camera file with --evidence");
    if (output_.empty() && figures_.empty())
      throw missingError("report", "no --output", "-o FILE, for example -o page.html, or --figures FOLDER");
    const std::string evidence_file = evidence_.empty() ? file_ : evidence_;
    std::vector<std::string> images;
    if (!images_.empty()) images = listInputs(images_).all();
    std::vector<std::string> sources = images;
    sources.insert(sources.end(),
                   {cameraFilePath(file_), cameraFilePath(against_), evidence_, common_.config});
    checkOutput(output_, sources, common_);
    if (!figures_.empty()) refuseFolderOfInputs(figures_, sources);
    const std::string evidence = readTextFile(evidence_file, kMaxEvidenceBytes);
    if (!evidence_.empty()) requireSameCamera(evidence);
    if (evidence_.empty() && !looksLikeJson(evidence)) {
      throw inputError({.where = file_,
                        .found = "no evidence file",
                        .expected = "the JSON file that alidade calibrate --evidence writes",
                        .next_step = "give it with --evidence"});
    }
    PageOptions options{.num_jobs = common_.jobs};
    if (!images.empty()) options.pictures = picturesFrom(evidence, images);
    if (!against_.empty()) {
      const CameraRecord other = readCameraTelling(against_, {}, common_.quiet);
      options.rival = {.name = printable(against_),
                       .camera = other.camera,
                       .size = other.image_size,
                       .covariance = statedCovariance(other)};
    }
    if (!figures_.empty()) {
      PendingFolder folder(figures_, "report", overwrite_);
      if (!common_.quiet) noteLeftovers(folder);
      writeFigures(folder, evidence, evidence_file, options);
      folder.commit();
    }
    if (!output_.empty()) writeReport(output_, evidence, evidence_file, options);
    if (common_.json) {
      const auto orNone = [](const std::string& path) { return path.empty() ? json(nullptr) : json(path); };
      printResult(jsonText({{"output", orNone(output_)}, {"figures", orNone(figures_)}}));
    } else if (!common_.quiet) {
      if (!figures_.empty()) printMessage("figures written to " + figures_);
      if (!output_.empty()) printMessage("report written to " + output_);
    }
    return 0;
  }

 private:
  static bool looksLikeJson(const std::string& text) {
    const std::size_t first = text.find_first_not_of(" \t\r\n");
    return first != std::string::npos && text[first] == '{';
  }

  // The camera file has the parameters that the evidence tells about.
  void requireSameCamera(const std::string& evidence) const {
    const CameraRecord record = readCameraTelling(file_, {}, common_.quiet);
    const json document = json::parse(evidence, nullptr, false);
    if (document.is_discarded() || !document.is_object() || !document.contains("parameters"))
      return;  // refused with its reason when the page is made
    const json& values = document["parameters"];
    bool is_same = document.value("model", json()) == json(record.camera.modelId());
    const auto names = record.camera.parameterNames();
    for (std::size_t i = 0; is_same && i < names.size(); ++i) {
      const json value = values.is_object() ? values.value(std::string(names[i]), json()) : json();
      const double own = record.camera.parameters()[i];
      is_same =
          value.is_number() && std::abs(value.get<double>() - own) <= 1e-9 * std::max(1.0, std::abs(own));
    }
    if (is_same) return;
    throw inputError({.where = evidence_,
                      .found = "the evidence of another camera than " + file_,
                      .expected = "the evidence of the calibration that wrote this camera file",
                      .next_step = "write both in one run: alidade calibrate ... -o camera.yaml --evidence "
                                   "evidence.json"});
  }

  std::string file_;
  std::string evidence_;
  std::vector<std::string> images_;
  std::string against_;
  std::string output_;
  std::string figures_;
  bool overwrite_ = false;
};

}  // namespace

std::unique_ptr<Command> makeReportCommand() {
  return std::make_unique<ReportCommand>();
}

}  // namespace alidade
