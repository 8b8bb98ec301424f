// SPDX-License-Identifier: MIT
#include <algorithm>
#include <cmath>
#include <numbers>
#include <optional>
#include <utility>

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <CLI/CLI.hpp>
#include <nlohmann/json.hpp>

#include "alidade/camera/camera_edit.h"
#include "alidade/camera/model_fit.h"
#include "alidade/core/error.h"
#include "alidade/core/size_groups.h"
#include "alidade/core/text.h"
#include "alidade/io/camera_file.h"
#include "command.h"
#include "converted_record.h"

namespace alidade {
namespace {

constexpr int kUntrustworthyExit = static_cast<int>(ErrorCode::kVerdict);
constexpr double kMaxUnreachedShare = 1e-3;
// The largest error anywhere may be this many times the RMS that is accepted.
constexpr double kMaxErrorFactor = 10;

// What was asked for, in the order in which it is done.
struct Step {
  std::string name;   ///< "crop"
  std::string value;  ///< "10,20,600,400"
  ImageSize size;     ///< afterwards
};

struct Reason {
  std::string id;  ///< stable, for scripts and the record in the file
  std::string message;
};

struct Conversion {
  EditedCamera edit;  ///< all edits in one
  std::vector<Step> steps;
  std::optional<ModelFit> fit;
  std::vector<Reason> reasons;  ///< why the answer is no; empty = it is not

  [[nodiscard]] const AnyCamera& camera() const { return fit ? fit->camera : edit.camera; }
};

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

std::string pixelText(const Eigen::Vector2d& pixel) {
  return fmt::format("({:.1f}, {:.1f})", pixel.x(), pixel.y());
}

class ConvertCommand final : public Command {
 public:
  void setUp(CLI::App& app) override {
    app.footer(
        "Example: alidade convert camera.yaml -o half.yaml --crop 0,60,640,360 --resize 320x180\n"
        "Example: alidade convert camera.yaml -o turned.yaml --rotate 90 --model radtan\n"
        "The image is cropped, binned, resized and rotated, in this order, and the model replaced last. "
        "Pixel "
        "(0, 0) is the\n"
        "centre of the top-left pixel. --rotate turns the axes of the camera frame with the image.\n"
        "Exit code 3: done, but the result is not to be trusted; no camera file is written then.");
    app.add_option("file", path_, "Camera file (YAML)");
    app.add_option("-o,--output", output_,
                   "Camera file to write (YAML); - for standard output instead of the summary");
    app.add_option("--crop", crop_, "Part of the image to keep: X,Y,WIDTH,HEIGHT, pixels");
    app.add_option("--bin", bin_, "Take N x N pixels together; what does not fill one is cropped");
    app.add_option("--resize", resize_, "New size of the image: WIDTHxHEIGHT, pixels");
    app.add_option("--rotate", rotate_, "Degrees clockwise, as seen")
        ->check(CLI::IsMember({0, 90, 180, 270}));
    app.add_option("--model", model_,
                   "Model to take instead: " + fmt::format("{}", fmt::join(modelIds(), ", ")))
        ->check(CLI::IsMember(modelIds()));
    app.add_option("--max-error", max_error_px_,
                   "RMS error of the new model that is accepted, pixels; ten times as much at any one pixel")
        ->check(CLI::Range(0.0, 1e6))
        ->capture_default_str();
    app.add_flag("--keep-untrustworthy", keep_untrustworthy_,
                 "Write the camera file even if the result is not to be trusted");
    addCommonOptions(app, common_, false);
  }

  int run(const CLI::App&) override {
    if (path_.empty())
      throw usageError({.where = "convert",
                        .found = "no camera file",
                        .expected = "a camera file (YAML)",
                        .next_step = "alidade convert --help"});
    if (output_.empty())
      throw usageError(
          {.where = "convert", .found = "no --output", .expected = "-o FILE, or -o - for standard output"});
    checkOutput(output_, {path_, common_.config}, common_);
    const CameraFile source = readCameraFile(path_);
    const Conversion conversion = convert(source);

    const bool is_good = conversion.reasons.empty();
    const bool is_kept = is_good || keep_untrustworthy_;
    const CameraFile file = converted(source, conversion);
    const bool to_stdout = output_ == "-";
    if (!to_stdout && is_kept) writeCameraFile(output_, file);

    if (common_.json) {
      printResult(json(source, conversion, file, is_kept));
    } else if (to_stdout) {
      if (is_kept) printResult(cameraFileText(file));
      if (!common_.quiet || !is_good) printMessage(summary(source, conversion, file));
    } else {
      printResult(summary(source, conversion, file));
    }
    if (!is_good) {
      printMessage(std::string("error: the converted camera is not to be trusted") +
                   (is_kept ? "" : "; " + output_ + " was not written (--keep-untrustworthy writes it)"));
      return kUntrustworthyExit;
    }
    if (!common_.quiet && !to_stdout) printMessage("written to " + output_);
    return 0;
  }

 private:
  [[nodiscard]] Conversion convert(const CameraFile& source) const {
    Conversion conversion{
        .edit = rotateCamera(source.camera, source.image_size, 0), .steps = {}, .fit = {}, .reasons = {}};
    const auto take = [&conversion](const char* name, std::string value, const EditedCamera& next) {
      EditedCamera& all = conversion.edit;
      all = {.camera = next.camera,
             .size = next.size,
             .new_from_old = next.new_from_old * all.new_from_old,
             .J_new_old = next.J_new_old * all.J_new_old};
      conversion.steps.push_back({name, std::move(value), next.size});
    };
    const EditedCamera& now = conversion.edit;
    if (!crop_.empty()) {
      const auto n =
          wholeNumbers("--crop", crop_, ',', 4, "X,Y,WIDTH,HEIGHT in pixels, such as 0,60,640,360");
      take("crop", crop_,
           cropCamera(now.camera, now.size, {.x = n[0], .y = n[1], .width = n[2], .height = n[3]}));
    }
    if (bin_) take("bin", std::to_string(*bin_), binCamera(now.camera, now.size, *bin_));
    if (!resize_.empty()) {
      const auto n = wholeNumbers("--resize", resize_, 'x', 2, "WIDTHxHEIGHT in pixels, such as 320x180");
      take("resize", resize_, resizeCamera(now.camera, now.size, {.width = n[0], .height = n[1]}));
    }
    if (rotate_) take("rotate", std::to_string(*rotate_), rotateCamera(now.camera, now.size, *rotate_ / 90));
    if (!model_.empty()) {
      conversion.fit = fitModel(now.camera, now.size, model_);
      conversion.steps.push_back({"model", model_, now.size});
    }
    conversion.reasons = reasonsAgainst(source, conversion);
    return conversion;
  }

  [[nodiscard]] std::vector<Reason> reasonsAgainst(const CameraFile& source,
                                                   const Conversion& conversion) const {
    std::vector<Reason> reasons;
    if (source.calibration && source.calibration->verdict == Verdict::kNo)
      reasons.push_back({"source_untrustworthy", path_ + " says of itself that it is not to be trusted"});
    if (!conversion.fit) return reasons;
    const ModelFit& fit = *conversion.fit;
    if (fit.unreachedShare() > kMaxUnreachedShare) {
      reasons.push_back({"unreached_pixels",
                         fmt::format("{} does not reach {:.3g} % of the pixels, such as {}; accepted {} %",
                                     model_, 100 * fit.unreachedShare(), pixelText(*fit.unreached_pixel),
                                     100 * kMaxUnreachedShare)});
    }
    if (fit.is_exact) return reasons;
    if (fit.rms_px > max_error_px_) {
      reasons.push_back(
          {"model_rms", fmt::format("{} misses the pixels by {:.3g} px (RMS); accepted {} px (--max-error)",
                                    model_, fit.rms_px, max_error_px_)});
    }
    if (fit.max_error_px > kMaxErrorFactor * max_error_px_) {
      reasons.push_back({"model_error",
                         fmt::format("{} misses pixel {} by {:.3g} px; accepted {} px ({} times --max-error)",
                                     model_, pixelText(fit.worst_pixel), fit.max_error_px,
                                     kMaxErrorFactor * max_error_px_, kMaxErrorFactor)});
    }
    return reasons;
  }

  [[nodiscard]] CameraFile converted(const CameraFile& source, const Conversion& conversion) const {
    const AnyCamera& camera = conversion.camera();
    const ImageSize size = conversion.edit.size;
    const DomainCertificate domain = conversion.fit ? conversion.fit->domain : certifyDomain(camera, size);
    CameraFile file{
        .camera = camera,
        .image_size = size,
        .domain = DomainClaim{.max_angle_rad = domain.cone.max_angle_rad, .full_image = domain.full_image},
        .self_check = makeSelfCheck(camera, size),
        .calibration = {},
        .created_by = provenance(source, conversion)};
    // A model that reaches no pixel has no error. A file needs a number, and has the finding that says it.
    const double fit_rms_px =
        conversion.fit && std::isfinite(conversion.fit->rms_px) ? conversion.fit->rms_px : 0.0;
    if (source.calibration) {
      file.calibration = editedRecord(*source.calibration, source.camera, conversion.edit);
      if (conversion.fit && camera.modelId() != source.camera.modelId())
        file.calibration = refittedRecord(*std::move(file.calibration), fit_rms_px);
    }
    if (!conversion.reasons.empty()) {
      // A file that was kept all the same says so, even one without a calibration of its own.
      if (!file.calibration) {
        file.calibration.emplace();
        file.calibration->rms_px = fit_rms_px;
      }
      file.calibration->verdict = Verdict::kNo;
      for (const Reason& reason : conversion.reasons) file.calibration->findings.push_back(reason.id);
    }
    return file;
  }

  // "alidade 0.1.0 convert crop 0,60,640,360, resize 320x180 of camera.yaml (alidade 0.1.0)"
  [[nodiscard]] std::string provenance(const CameraFile& source, const Conversion& conversion) const {
    std::vector<std::string> steps;
    for (const Step& step : conversion.steps) steps.push_back(step.name + " " + step.value);
    return programName() + " convert" + (steps.empty() ? "" : " " + join(steps, ", ")) + " of " + path_ +
           (source.created_by.empty() ? "" : " (" + source.created_by + ")");
  }

  [[nodiscard]] std::string summary(const CameraFile& source, const Conversion& conversion,
                                    const CameraFile& file) const {
    std::string text =
        fmt::format("From     {}: {}, {} px\n", path_, source.camera.modelId(), sizeText(source.image_size));
    for (const Step& step : conversion.steps) {
      if (step.name != "model")
        text += fmt::format("{:<8} {}: {} px\n", capitalised(step.name), step.value, sizeText(step.size));
    }
    if (!conversion.edit.new_from_old.isIdentity()) {
      const Eigen::Matrix3d& R = conversion.edit.new_from_old;
      text += fmt::format("         the camera frame turned: x_new = {}, y_new = {}, z_new = z\n",
                          axisText(R, 0), axisText(R, 1));
    }
    if (conversion.fit) text += fitText(*conversion.fit);
    text += fmt::format("Camera   {}, {} px\n", file.camera.modelId(), sizeText(file.image_size));
    for (std::size_t i = 0; i < file.camera.parameters().size(); ++i) {
      text += fmt::format("  {:<6} {}\n", file.camera.parameterNames()[i],
                          exactText(file.camera.parameters()[i]));
    }
    text += fmt::format("Domain   one-to-one up to {:.1f} degrees from the axis; {}",
                        file.domain->max_angle_rad * 180 / std::numbers::pi,
                        file.domain->full_image ? "every pixel of the image has a ray"
                                                : "NOT every pixel of the image has a ray");
    for (const Reason& reason : conversion.reasons)
      text += fmt::format("\nFAILED   {} [{}]", reason.message, reason.id);
    // Messages get their own end of line.
    return output_ == "-" ? text : text + "\n";
  }

  static std::string capitalised(std::string word) {
    word.front() = static_cast<char>(word.front() - 'a' + 'A');
    return word;
  }

  // What a new axis is, as "-y".
  static std::string axisText(const Eigen::Matrix3d& new_from_old, Eigen::Index row) {
    const Eigen::Index column = new_from_old(row, 0) != 0 ? 0 : 1;
    return std::string(new_from_old(row, column) < 0 ? "-" : "") + (column == 0 ? "x" : "y");
  }

  static std::string fitText(const ModelFit& fit) {
    std::string text = fmt::format(
        "Model    {}: {}\n", fit.camera.modelId(),
        fit.is_exact ? "exactly the same lens" : "the best fit over the image, not the same lens");
    if (fit.num_unreached < fit.num_pixels)
      text +=
          fmt::format("Error    RMS {:.3g} px, at most {:.3g} px at pixel {}; over {} pixels\n", fit.rms_px,
                      fit.max_error_px, pixelText(fit.worst_pixel), fit.num_pixels - fit.num_unreached);
    if (fit.num_unreached > 0) {
      text += fmt::format("Reach    {:.3g} % of the pixels are not reached, such as {}\n",
                          100 * fit.unreachedShare(), pixelText(*fit.unreached_pixel));
    }
    if (fit.num_without_ray > 0) {
      text += fmt::format("         {} of {} pixels have no ray in the old camera either and do not count\n",
                          fit.num_without_ray, fit.num_without_ray + fit.num_pixels);
    }
    return text;
  }

  [[nodiscard]] std::string json(const CameraFile& source, const Conversion& conversion,
                                 const CameraFile& file, bool is_kept) const {
    using nlohmann::json;
    const auto sizeJson = [](ImageSize size) { return json{{"width", size.width}, {"height", size.height}}; };
    json parameters = json::object();
    for (std::size_t i = 0; i < file.camera.parameters().size(); ++i)
      parameters[std::string(file.camera.parameterNames()[i])] = file.camera.parameters()[i];
    json steps = json::array();
    for (const Step& step : conversion.steps)
      steps.push_back({{"step", step.name}, {"value", step.value}, {"image_size", sizeJson(step.size)}});
    json rotation = json::array();
    for (const auto& row : conversion.edit.new_from_old.rowwise())
      rotation.push_back({row(0), row(1), row(2)});
    json reasons = json::array();
    for (const Reason& reason : conversion.reasons)
      reasons.push_back({{"id", reason.id}, {"message", reason.message}});
    json fit = nullptr;
    if (conversion.fit) {
      const ModelFit& f = *conversion.fit;
      fit = {{"exact", f.is_exact},
             {"rms_px", f.rms_px},
             {"max_error_px", f.max_error_px},
             {"worst_pixel", {f.worst_pixel.x(), f.worst_pixel.y()}},
             {"num_pixels", f.num_pixels},
             {"num_without_ray", f.num_without_ray},
             {"num_unreached", f.num_unreached},
             {"unreached_share", f.unreachedShare()},
             {"unreached_pixel",
              f.unreached_pixel ? json({f.unreached_pixel->x(), f.unreached_pixel->y()}) : json(nullptr)}};
    }
    return jsonText(
        {{"input", path_},
         {"output", output_},
         {"written", is_kept},
         {"from", {{"model", source.camera.modelId()}, {"image_size", sizeJson(source.image_size)}}},
         {"steps", steps},
         {"new_from_old", rotation},
         {"model", file.camera.modelId()},
         {"image_size", sizeJson(file.image_size)},
         {"parameters", parameters},
         {"fit", fit},
         {"domain", {{"max_angle_rad", file.domain->max_angle_rad}, {"full_image", file.domain->full_image}}},
         {"trustworthy", conversion.reasons.empty()},
         {"reasons", reasons}});
  }

  std::string path_;
  std::string output_;
  std::string crop_;
  std::optional<int> bin_;
  std::string resize_;
  std::optional<int> rotate_;
  std::string model_;
  double max_error_px_ = 0.1;
  bool keep_untrustworthy_ = false;
};

}  // namespace

std::unique_ptr<Command> makeConvertCommand() {
  return std::make_unique<ConvertCommand>();
}

}  // namespace alidade
