// SPDX-License-Identifier: MIT
#include <algorithm>
#include <numbers>
#include <utility>

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <CLI/CLI.hpp>

#include "alidade/core/error.h"
#include "alidade/core/mapped.h"
#include "alidade/core/size_groups.h"
#include "alidade/core/text.h"
#include "alidade/files/atomic_file.h"
#include "alidade/files/camera_file.h"
#include "alidade/files/camera_source.h"
#include "alidade/files/formats/camera_format.h"
#include "alidade/record/conversion.h"
#include "console.h"
#include "json_output.h"
#include "options.h"

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

std::vector<int> pixelNumbers(const std::string& flag, const std::string& text, char separator,
                              std::size_t count, const std::string& expected) {
  if (auto numbers = wholeNumbers(text, separator, count)) return *numbers;
  throw usageError({.where = flag,
                    .found = "'" + text + "'",
                    .expected = expected,
                    .next_step = "alidade convert --help"});
}

// What made a converted file: "alidade 0.1.0 convert crop 0,60,640,360, resize 320x180 of camera.yaml (...)".
std::string provenance(const std::string& path, const CameraRecord& source, const Conversion& conversion) {
  const std::vector<std::string> steps =
      mapped(conversion.steps, [](const Conversion::Step& step) { return step.name + " " + step.value; });
  return programName() + " convert" + (steps.empty() ? "" : " " + join(steps, ", ")) + " of " + path +
         (source.created_by.empty() ? "" : " (" + source.created_by + ")");
}

// "(12.0, 34.5)"
std::string pixelText(const Eigen::Vector2d& pixel) {
  return fmt::format("({:.1f}, {:.1f})", pixel.x(), pixel.y());
}

// There is a fit for all problems but the first.
std::string problemText(ConversionProblem problem, const Converted& converted) {
  if (problem == ConversionProblem::kSourceUntrustworthy)
    return converted.where + ": its own verdict says that it must not be used";
  const double limit_px = converted.conversion.max_error_px;
  const ModelFit& fit = converted.conversion.fit.value();
  const std::string_view model = fit.camera.modelId();
  switch (problem) {
    case ConversionProblem::kUnreachedPixels:
      return fmt::format("{} cannot represent {:.3g} % of the pixels, for example {}; limit {} %", model,
                         100 * fit.unreachedShare(), pixelText(*fit.unreached_pixel),
                         100 * kMaxUnreachedShare);
    case ConversionProblem::kModelRms:
      return fmt::format("{} has an RMS error of {:.3g} px; limit {} px (--max-error)", model, fit.rms_px,
                         limit_px);
    default:
      return fmt::format("{} has an error of {:.3g} px at pixel {}; limit {} px ({} times --max-error)",
                         model, fit.max_error_px, pixelText(fit.worst_pixel), kMaxErrorFactor * limit_px,
                         kMaxErrorFactor);
  }
}

// What a new axis is, as "-y".
std::string axisText(const Eigen::Matrix3d& new_from_old, Eigen::Index row) {
  const Eigen::Index column = new_from_old(row, 0) != 0 ? 0 : 1;
  return std::string(new_from_old(row, column) < 0 ? "-" : "") + (column == 0 ? "x" : "y");
}

std::string fitText(const ModelFit& fit) {
  std::string text =
      fmt::format("Model    {}: {}\n", fit.camera.modelId(),
                  fit.is_exact ? "identical lens" : "best fit over the image; the lens is not identical");
  if (fit.num_unreached < fit.num_pixels)
    text +=
        fmt::format("Error    RMS {:.3g} px, at most {:.3g} px at pixel {}; {} pixels compared\n", fit.rms_px,
                    fit.max_error_px, pixelText(fit.worst_pixel), fit.num_pixels - fit.num_unreached);
  if (fit.num_unreached > 0) {
    text += fmt::format("Missing  {:.3g} % of the pixels cannot be represented, for example {}\n",
                        100 * fit.unreachedShare(), pixelText(*fit.unreached_pixel));
  }
  if (fit.num_without_ray > 0) {
    text += fmt::format("         {} of {} pixels were ignored because they have no ray in the old camera\n",
                        fit.num_without_ray, fit.num_without_ray + fit.num_pixels);
  }
  return text;
}

// What was done and what came out, for people; without an end of line.
std::string summaryText(const Converted& converted) {
  const auto& [where, name, source, conversion, file] = converted;
  std::string text = fmt::format("From     {}: {}, {} px\n", printable(where), source.camera.modelId(),
                                 sizeText(source.image_size));
  for (const Conversion::Step& step : conversion.steps) {
    if (step.name == "model") continue;
    std::string label = step.name;
    label.front() = static_cast<char>(std::toupper(label.front()));
    text += fmt::format("{:<8} {}: {} px\n", label, step.value, sizeText(step.size));
  }
  const Eigen::Matrix3d& R = conversion.edit.new_from_old;
  if (!R.isIdentity()) {
    text += fmt::format("         camera frame rotated: x_new = {}, y_new = {}, z_new = z\n", axisText(R, 0),
                        axisText(R, 1));
  }
  if (conversion.fit) text += fitText(*conversion.fit);
  text += fmt::format("Camera   {}, {} px\n", file.camera.modelId(), sizeText(file.image_size));
  for (std::size_t i = 0; i < file.camera.parameters().size(); ++i) {
    text +=
        fmt::format("  {:<6} {}\n", file.camera.parameterNames()[i], exactText(file.camera.parameters()[i]));
  }
  text += fmt::format("Domain   valid up to {:.1f} degrees off-axis; {}",
                      file.domain->max_angle_rad * 180 / std::numbers::pi,
                      file.domain->full_image ? "every pixel of the image has a ray"
                                              : "some pixels of the image have NO ray");
  for (const ConversionProblem problem : conversion.problems)
    text += fmt::format("\nFAILED   {} [{}]", problemText(problem, converted), problemId(problem));
  return text;
}

json fitJson(const ModelFit& fit) {
  return {{"exact", fit.is_exact},
          {"rms_px", fit.rms_px},
          {"max_error_px", fit.max_error_px},
          {"worst_pixel", vectorJson(fit.worst_pixel)},
          {"num_pixels", fit.num_pixels},
          {"num_without_ray", fit.num_without_ray},
          {"num_unreached", fit.num_unreached},
          {"unreached_share", fit.unreachedShare()},
          {"unreached_pixel", fit.unreached_pixel ? vectorJson(*fit.unreached_pixel) : json(nullptr)}};
}

// The same for programs.
json summaryJson(const Converted& converted) {
  const auto& [where, name, source, conversion, file] = converted;
  const json steps = mapped(conversion.steps, [](const Conversion::Step& step) -> json {
    return {{"step", step.name}, {"value", step.value}, {"image_size", step.size}};
  });
  const json reasons = mapped(conversion.problems, [&](ConversionProblem problem) -> json {
    return {{"id", problemId(problem)}, {"message", problemText(problem, converted)}};
  });
  const Eigen::Matrix3d& R = conversion.edit.new_from_old;
  return {
      {"input", where},
      {"from", {{"model", source.camera.modelId()}, {"image_size", source.image_size}}},
      {"steps", steps},
      {"new_from_old", rowsJson(3, 3, [&](std::size_t i) { return R(i / 3, i % 3); })},
      {"model", file.camera.modelId()},
      {"image_size", file.image_size},
      {"parameters", parametersJson(file.camera.parameterNames(), file.camera.parameters())},
      {"fit", conversion.fit ? fitJson(*conversion.fit) : json(nullptr)},
      {"domain", {{"max_angle_rad", file.domain->max_angle_rad}, {"full_image", file.domain->full_image}}},
      {"trustworthy", conversion.problems.empty()},
      {"reasons", reasons}};
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
        ->check(nonNegativeNumber, "0 or more")
        ->capture_default_str();
    app.add_flag("--keep-untrustworthy", keep_untrustworthy_,
                 "Write the camera file even if the result must not be used");
    addCameraOptions(app, camera_);
    addCommonOptions(app, common_, false);
  }

  int run(const CLI::App&) override {
    if (path_.empty()) throw missingError("convert", "no camera file", "a camera file");
    if (output_.empty()) throw missingError("convert", "no --output", "-o FILE, or -o - for standard output");
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
      printResult(document(cameras, notes, is_kept));
    } else if (to_stdout) {
      if (is_kept) printResult(content);
      if (!common_.quiet || !is_good) printHelp(summary(cameras) + "\n");
    } else {
      printResult(summary(cameras) + "\n");
    }
    if (!common_.json && !common_.quiet) {
      for (const std::string& note : notes) printMessage("note: " + note);
    }
    if (!is_good) {
      printRefusal("the converted camera must not be used", output_, is_kept);
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
           .expected =
               "one camera, because a file in the format " + std::string(format.title) + " holds only one",
           .next_step = "select one: " + source.path + "#" + cameraLabel(source.cameras.front())});
    }
    requireAll(source);
    ConversionRequest request = request_;
    if (!crop_.empty()) {
      const auto n =
          pixelNumbers("--crop", crop_, ',', 4, "X,Y,WIDTH,HEIGHT in pixels, such as 0,60,640,360");
      request.crop = {.x = n[0], .y = n[1], .width = n[2], .height = n[3]};
    }
    if (!resize_.empty()) {
      const auto n = pixelNumbers("--resize", resize_, 'x', 2, "WIDTHxHEIGHT in pixels, such as 320x180");
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
    return join(mapped(cameras, summaryText), "\n\n");
  }

  [[nodiscard]] std::string document(const std::vector<Converted>& cameras,
                                     const std::vector<std::string>& notes, bool is_kept) const {
    json all = {{"output", output_}, {"format", format_}, {"written", is_kept}, {"notes", notes}};
    if (cameras.size() == 1) {
      all.update(summaryJson(cameras.front()));
    } else {
      all["cameras"] = mapped(cameras, summaryJson);
    }
    return jsonText(all);
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
