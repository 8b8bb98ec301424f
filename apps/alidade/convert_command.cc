// SPDX-License-Identifier: MIT
#include <algorithm>
#include <optional>
#include <utility>

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <CLI/CLI.hpp>
#include <nlohmann/json.hpp>

#include "alidade/core/error.h"
#include "alidade/core/text.h"
#include "alidade/files/atomic_file.h"
#include "alidade/files/camera_file.h"
#include "alidade/files/camera_source.h"
#include "alidade/files/formats/camera_format.h"
#include "camera_options.h"
#include "command.h"
#include "conversion_output.h"
#include "number_check.h"

namespace alidade {
namespace {

constexpr std::string_view kOwnFormat = "alidade";

// One camera of the input and what became of it.
struct Converted {
  std::string where;  // "rig.yaml#cam1"
  std::string name;
  CameraRecord source;
  Conversion conversion;
  CameraRecord file;
};

std::vector<std::string> formatIds() {
  std::vector<std::string> ids;
  for (const CameraFormat* format : cameraFormats()) ids.emplace_back(format->id);
  return ids;
}

// "600x400" or "10,20,600,400" as so many whole numbers.
std::vector<int> wholeNumbers(const std::string& flag, const std::string& text, char separator,
                              std::size_t count, const std::string& expected) {
  std::vector<int> numbers;
  for (const std::string_view part : split(text, separator)) {
    if (const auto number = parseInt(trim(part))) numbers.push_back(*number);
  }
  if (numbers.size() != count || split(text, separator).size() != count) {
    throw usageError({.where = flag,
                      .found = "'" + text + "'",
                      .expected = expected,
                      .next_step = "alidade convert --help"});
  }
  return numbers;
}

class ConvertCommand final : public Command {
 public:
  void setUp(CLI::App& app) override {
    app.footer(
        "Example: alidade convert camera.yaml -o half.yaml --crop 0,60,640,360 --resize 320x180\nExample: "
        "alidade convert camera.yaml -o turned.yaml --rotate 90 --model radtan\nExample: alidade convert "
        "camchain.yaml#cam0 -o camera_info.yaml --to ros\nThe format of FILE is detected from its content. "
        "FILE#NAME selects one camera of a file with several. The edits are\napplied in this order: crop, "
        "bin, resize, rotate, model. Pixel (0, 0) is the centre of the top-left pixel. --rotate\nalso "
        "rotates the axes of the camera frame.\nExit code 3: the result must not be used; no camera file is "
        "written.");
    app.add_option("file", path_, "Camera file of any format (docs/formats.md)");
    app.add_option("-o,--output", output_,
                   "Camera file to write; - writes it to standard output instead of the summary");
    app.add_option("--to", format_,
                   "Format of the output: " + fmt::format("{}", fmt::join(formatIds(), ", ")))
        ->check(CLI::IsMember(formatIds()))
        ->capture_default_str();
    app.add_option("--crop", crop_, "Part of the image to keep, in pixels: X,Y,WIDTH,HEIGHT");
    app.add_option("--bin", request_.bin,
                   "Combine N x N pixels into one; incomplete blocks at the edge are cropped");
    app.add_option("--resize", resize_, "New image size in pixels: WIDTHxHEIGHT");
    app.add_option("--rotate", request_.rotate_deg, "Rotate the image clockwise by this many degrees")
        ->check(CLI::IsMember({0, 90, 180, 270}));
    app.add_option("--model", request_.model,
                   "Fit this lens model instead: " + fmt::format("{}", fmt::join(modelIds(), ", ")))
        ->check(CLI::IsMember(modelIds()));
    app.add_option("--max-error", request_.max_error_px,
                   "Largest accepted RMS error of the new model in pixels; the limit for a single pixel is "
                   "ten times larger")
        ->check(nonNegativeNumber(), "0 or more")
        ->capture_default_str();
    app.add_flag("--keep-untrustworthy", keep_untrustworthy_,
                 "Write the camera file even if the result must not be used");
    addCameraOptions(app, camera_);
    addCommonOptions(app, common_, false);
  }

  int run(const CLI::App&) override {
    if (path_.empty())
      throw usageError({.where = "convert",
                        .found = "no camera file",
                        .expected = "a camera file",
                        .next_step = "alidade convert --help"});
    if (output_.empty())
      throw usageError(
          {.where = "convert", .found = "no --output", .expected = "-o FILE, or -o - for standard output"});
    checkOutput(output_, {cameraFilePath(path_), common_.config}, common_);
    const CameraFormat& format = cameraFormat(format_);
    const CameraSource source = loadCameras(path_, camera_.readOptions());
    const std::vector<Converted> cameras = convertAll(source, format);
    const bool is_good = std::all_of(cameras.begin(), cameras.end(),
                                     [](const Converted& c) { return c.conversion.problems.empty(); });
    const bool is_kept = is_good || keep_untrustworthy_;
    // What the format cannot hold is told before anything is printed or written.
    const std::string content = is_kept ? contentOf(cameras, format) : "";
    const std::vector<std::string> notes = notesOn(source, cameras, format);
    const bool to_stdout = output_ == "-";
    if (!to_stdout && is_kept) writeFileAtomically(output_, content);

    if (common_.json) {
      printResult(json(cameras, notes, is_kept));
    } else if (to_stdout) {
      if (is_kept) printResult(content);
      if (!common_.quiet || !is_good) printMessage(summary(cameras));
    } else {
      printResult(summary(cameras) + "\n");
    }
    if (!common_.json && !common_.quiet) {
      for (const std::string& note : notes) printMessage("note: " + note);
    }
    if (!is_good) {
      printMessage(
          std::string("error: the converted camera must not be used") +
          (is_kept ? "" : "; " + output_ + " was not written (use --keep-untrustworthy to write it anyway)"));
      return kUntrustworthyExit;
    }
    if (!common_.quiet && !to_stdout) printMessage("written to " + output_);
    return 0;
  }

 private:
  [[nodiscard]] std::vector<Converted> convertAll(const CameraSource& source,
                                                  const CameraFormat& format) const {
    const std::size_t num_all = source.cameras.size() + source.refused.size();
    if (num_all > 1 && !format.holds_several) {
      throw inputError(
          {.where = source.path,
           .found = std::to_string(num_all) + " cameras",
           .expected = "one camera: a file of the format " + std::string(format.title) + " holds only one",
           .next_step = "select one: " + source.path + "#" + cameraLabel(source.cameras.front())});
    }
    requireAll(source);
    ConversionRequest request = request_;
    if (!crop_.empty()) {
      const auto n =
          wholeNumbers("--crop", crop_, ',', 4, "X,Y,WIDTH,HEIGHT in pixels, such as 0,60,640,360");
      request.crop = {.x = n[0], .y = n[1], .width = n[2], .height = n[3]};
    }
    if (!resize_.empty()) {
      const auto n = wholeNumbers("--resize", resize_, 'x', 2, "WIDTHxHEIGHT in pixels, such as 320x180");
      request.resize = {.width = n[0], .height = n[1]};
    }
    // What the format cannot say of the model is fitted around.
    for (const AbsentParameter& absent : format.absent) {
      if (absent.model == request.model) request.absent.push_back(absent.parameter);
    }
    std::vector<Converted> all;
    for (std::size_t i = 0; i < source.cameras.size(); ++i) {
      const StatedCamera& stated = source.cameras[i];
      const std::string where = source.cameras.size() > 1 ? source.path + "#" + cameraLabel(stated) : path_;
      CameraRecord file = recordOf(stated, where);
      Conversion conversion = convertCamera(file, request);
      CameraRecord converted = convertedRecord(file, conversion, provenance(where, file, conversion));
      all.push_back({.where = where,
                     .name = stated.name,
                     .source = std::move(file),
                     .conversion = std::move(conversion),
                     .file = std::move(converted)});
    }
    return all;
  }

  [[nodiscard]] std::string contentOf(const std::vector<Converted>& cameras,
                                      const CameraFormat& format) const {
    if (format.id == kOwnFormat) return cameraFileText(cameras.front().file);
    std::vector<NamedCamera> named;
    for (const Converted& c : cameras) {
      named.push_back(
          {.name = c.name, .camera = c.file.camera, .image_size = c.file.image_size, .where = c.where});
    }
    return formatText(format, named, output_);
  }

  // What is worth knowing and is no reason to refuse.
  [[nodiscard]] static std::vector<std::string> notesOn(const CameraSource& source,
                                                        const std::vector<Converted>& cameras,
                                                        const CameraFormat& format) {
    std::vector<std::string> notes;
    for (const StatedCamera& camera : source.cameras) {
      for (const Remark& remark : camera.remarks) {
        if (std::find(notes.begin(), notes.end(), remark.message) == notes.end())
          notes.push_back(remark.message);
      }
    }
    for (const Converted& c : cameras) {
      if (format.id != kOwnFormat && c.source.calibration) {
        notes.push_back(
            c.where + ": uncertainty, verdict and poses of the calibration cannot be stored in the format " +
            std::string(format.title));
      }
    }
    return notes;
  }

  [[nodiscard]] static std::string summary(const std::vector<Converted>& cameras) {
    std::vector<std::string> texts;
    for (const Converted& c : cameras)
      texts.push_back(conversionSummary(c.where, c.source, c.conversion, c.file));
    return join(texts, "\n\n");
  }

  [[nodiscard]] std::string json(const std::vector<Converted>& cameras, const std::vector<std::string>& notes,
                                 bool is_kept) const {
    nlohmann::json list = nlohmann::json::array();
    for (const Converted& c : cameras)
      list.push_back(conversionJson(c.where, c.source, c.conversion, c.file));
    nlohmann::json document = {
        {"output", output_}, {"format", format_}, {"written", is_kept}, {"notes", notes}};
    if (list.size() == 1) {
      document.update(list.front());
    } else {
      document["cameras"] = std::move(list);
    }
    return jsonText(document);
  }

  std::string path_;
  std::string output_;
  std::string format_ = std::string(kOwnFormat);
  CameraOptions camera_;
  ConversionRequest request_;
  std::string crop_;
  std::string resize_;
  bool keep_untrustworthy_ = false;
};

}  // namespace

std::unique_ptr<Command> makeConvertCommand() {
  return std::make_unique<ConvertCommand>();
}

}  // namespace alidade
