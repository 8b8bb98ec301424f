// SPDX-License-Identifier: MIT
#include <algorithm>
#include <cmath>
#include <map>
#include <set>
#include <span>

#include "alidade/core/error.h"
#include "alidade/files/camera_source.h"
#include "alidade/files/text/atomic_file.h"
#include "alidade/imagery/image_list.h"
#include "alidade/imagery/image_set.h"
#include "alidade/report/data/json_output.h"
#include "alidade/report/data/rig_data.h"
#include "alidade/report/data/utf8.h"
#include "alidade/report/pages/page.h"
#include "board_views.h"
#include "camera_files.h"
#include "command.h"
#include "console.h"
#include "outputs.h"
#include "page_file.h"
#include "pending_folder.h"

namespace alidade {
namespace {

constexpr std::size_t kMaxEvidenceBytes = std::size_t{1} << 30U;

// The images of an evidence document, each once; none for any other document, which is refused later.
// @param camera  index; of one camera, views state none
std::set<std::string> viewNames(const json& evidence, std::size_t camera) {
  std::set<std::string> names;
  if (!evidence.is_object() || !evidence.contains("views") || !evidence["views"].is_array()) return names;
  for (const json& view : evidence["views"]) {
    if (view.is_object() && view.contains("image") && view["image"].is_string() &&
        view.value("camera", json(camera)) == json(camera))
      names.insert(view["image"].get<std::string>());
  }
  return names;
}

// The pictures of an evidence document, from images and videos that are given again.
PictureSource picturesFrom(const json& evidence, std::size_t camera, const std::vector<std::string>& paths) {
  const std::vector<std::string> short_names = shortNames(paths);
  std::map<std::string, std::string> path_of;
  for (std::size_t i = 0; i < paths.size(); ++i) path_of[validUtf8(short_names[i])] = paths[i];
  std::vector<std::string> names;
  std::vector<std::string> images;
  for (const std::string& name : viewNames(evidence, camera)) {
    const auto frame = parseFrameName(name);
    const auto file = path_of.find(name);
    if (file == path_of.end() && !(frame && path_of.contains(frame->first))) continue;
    names.push_back(name);
    images.push_back(file != path_of.end() ? file->second
                                           : path_of[frame->first] + "@" + std::to_string(frame->second));
  }
  return picturesOf(names, openNamed(images), nullptr);
}

class ReportCommand final : public Command {
 public:
  void setUp(Flags& flags) override {
    flags.explain(
        "Example: alidade report evidence.json -o page.html --images photos/\n"
        "The page is the same as that of alidade calibrate --report.");
    flags.add("file", &file_,
              "Evidence file (JSON) of alidade calibrate --evidence; or the camera file, with --evidence",
              kFilePath);
    flags.add("--evidence", &evidence_, "Evidence file of the camera file", kFilePath);
    flags.add("--images", &images_,
              "Images that the camera was calibrated from, for pictures of the views: folders, files, "
              "patterns or videos; of a rig, one for each camera",
              kFilePath);
    flags.add("--against", &against_, "Camera file (any format) to compare with", kFilePath);
    addReportFlag(flags, output_, "the calibration in figures", "-o,--output");
    flags.add("--figures", &figures_, "Folder to create, with the figures as SVG files", kFolder);
    flags.addSwitch("--overwrite", overwrite_,
                    "Replace an earlier, unchanged folder of figures; other files are never changed");
    flags.addCommon(common_, true);
  }

  int run(const Flags&) override {
    if (file_.empty()) throw missing("no file", "an evidence file, or a camera file with --evidence");
    if (output_.empty() && figures_.empty())
      throw missing("no --output", "-o FILE, for example -o page.html, or --figures FOLDER");
    const std::vector<std::string> images =
        images_.empty() ? std::vector<std::string>() : listInputs(images_).all();
    checkUsage(images);
    const json evidence = readEvidence();
    const PageOptions options = pageOptions(evidence);
    write(evidence, options);
    print();
    return 0;
  }

 private:
  [[nodiscard]] const std::string& evidenceFile() const { return evidence_.empty() ? file_ : evidence_; }

  void checkUsage(const std::vector<std::string>& images) const {
    std::vector<std::string> sources = images;
    append(sources, {cameraFilePath(file_), cameraFilePath(against_), evidence_, common_.config});
    checkOutput(output_, sources, common_);
    if (!figures_.empty()) refuseFolderOfInputs(figures_, sources);
  }

  [[nodiscard]] json readEvidence() const {
    const std::string text = readTextFile(evidenceFile(), kMaxEvidenceBytes);
    if (evidence_.empty() && !looksLikeJson(text)) {
      throw inputError({.where = file_,
                        .found = "no evidence file",
                        .expected = "the JSON file that alidade calibrate --evidence writes",
                        .next_step = "give it with --evidence"});
    }
    json evidence = parsedEvidence(text, evidenceFile());
    if (!evidence_.empty()) requireSameCamera(evidence);
    return evidence;
  }

  [[nodiscard]] PageOptions pageOptions(const json& evidence) const {
    PageOptions options{.num_jobs = common_.jobs};
    const std::size_t step = isRigEvidence(evidence) ? 1 : images_.size();
    for (std::size_t i = 0; i < images_.size(); i += step) {
      const std::vector<std::string> images = listInputs(std::span(images_).subspan(i, step)).all();
      options.pictures.push_back(picturesFrom(evidence, i, images));
    }
    if (against_.empty()) return options;
    const CameraRecord other = readCameraTelling(against_, {}, common_.quiet);
    options.rival = {.name = printable(against_),
                     .camera = other.camera,
                     .size = other.image_size,
                     .covariance = statedCovariance(other)};
    return options;
  }

  void write(const json& evidence, const PageOptions& options) const {
    if (!figures_.empty()) {
      PendingFolder folder(figures_, common_.command, overwrite_, common_.quiet);
      const std::vector<FigureFile> figures = reportFigures(evidence, evidenceFile(), options);
      folder.write([&] {
        for (const FigureFile& figure : figures) writeFileAtomically(folder.path(figure.name), figure.svg);
      });
      folder.commit();
    }
    if (!output_.empty()) writeFileAtomically(output_, reportPage(evidence, evidenceFile(), options));
  }

  void print() const {
    const auto orNone = [](const std::string& path) { return path.empty() ? json(nullptr) : json(path); };
    if (common_.json)
      return printResult(jsonText({{"output", orNone(output_)}, {"figures", orNone(figures_)}}));
    if (common_.quiet) return;
    if (!figures_.empty()) printMessage("figures written to " + figures_);
    if (!output_.empty()) printMessage("report written to " + output_);
  }

  static bool looksLikeJson(const std::string& text) {
    const std::size_t first = text.find_first_not_of(" \t\r\n");
    return first != std::string::npos && text[first] == '{';
  }

  static json parsedEvidence(const std::string& text, const std::string& file) {
    try {
      return json::parse(text);
    } catch (const json::exception& error) {
      throw inputError({.where = file,
                        .found = "no valid JSON (" + std::string(error.what()) + ")",
                        .expected = "the file that alidade calibrate --evidence writes"});
    }
  }

  // Checks that the camera file has the parameters of the evidence.
  void requireSameCamera(const json& evidence) const {
    const CameraRecord record = readCameraTelling(file_, {}, common_.quiet);
    if (!evidence.is_object() || !evidence.contains("parameters"))
      return;  // the page refuses it with its reason
    const json& values = evidence["parameters"];
    bool is_same = evidence.value("model", json()) == json(record.camera.modelId());
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

const CommandEntry kReportCommand = {
    "report", "Show a calibration in figures, as a page from its evidence file", made<ReportCommand>};

}  // namespace alidade
