// SPDX-License-Identifier: MIT
#include <algorithm>
#include <filesystem>
#include <utility>

#include <fmt/format.h>

#include "alidade/camera/correction_field.h"
#include "alidade/camera/model_traits.h"
#include "alidade/core/degrees.h"
#include "alidade/core/error.h"
#include "alidade/core/mapped.h"
#include "alidade/core/size_groups.h"
#include "alidade/core/text.h"
#include "alidade/files/camera_source.h"
#include "alidade/files/formats/alidade_writer.h"
#include "alidade/files/formats/camera_format.h"
#include "alidade/files/rig_file.h"
#include "alidade/files/text/atomic_file.h"
#include "alidade/geometry/rotation_conversions.h"
#include "alidade/record/conversion.h"
#include "alidade/report/data/json_output.h"
#include "camera_files.h"
#include "command.h"
#include "commands/rig/rectified_pair.h"
#include "console.h"
#include "outputs.h"
#include "summary_lines.h"

namespace alidade {
namespace {

constexpr std::string_view kOwnFormat = "alidade";

// One camera of the input and its conversion.
struct Converted {
  std::string where;  // "rig.yaml#cam1"
  CameraRecord source;
  Conversion conversion;
  CameraRecord file;
  std::optional<SE3> camera_from_rig;  // of `file`
};

// "(12.0, 0.0, -1.5) mm from the first camera, turned by 1.234 degrees (...)".
std::string poseText(const SE3& camera_from_first) {
  constexpr double kMillimetres = 1000;
  // Adding 0 avoids negative zeros.
  const Eigen::Vector3d origin =
      Eigen::Vector3d::Zero() + camera_from_first.inverse().translation * kMillimetres;
  return fmt::format("({:.6g}, {:.6g}, {:.6g}) mm from the first camera, turned by {}", origin.x(),
                     origin.y(), origin.z(), turnText(camera_from_first.rotation.inverse()));
}

std::vector<int> pixelNumbers(const std::string& flag, const std::string& text, char separator,
                              std::size_t count, const std::string& expected) {
  if (auto numbers = wholeNumbers(text, separator, count)) return *numbers;
  throw flagError(flag, "'" + text + "'", expected, "alidade convert --help");
}

// The origin of a converted file: "alidade 0.1.0 convert crop 0,60,640,360, resize 320x180 of camera.yaml
// (...)".
std::string provenance(const std::string& maker, const std::string& path, const CameraRecord& source,
                       const Conversion& conversion) {
  const std::vector<std::string> steps =
      mapped(conversion.steps, [](const Conversion::Step& step) { return step.name + " " + step.value; });
  return maker + (steps.empty() ? "" : " " + join(steps, ", ")) + " of " + path +
         (source.created_by.empty() ? "" : " (" + source.created_by + ")");
}

// "(12.0, 34.5)"
std::string pixelText(const Eigen::Vector2d& pixel) {
  return fmt::format("({:.1f}, {:.1f})", pixel.x(), pixel.y());
}

// All problems except the first have a fit.
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

// A new axis by the old ones, as "-y".
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

// The edits and the resulting camera, for people; without a final line end.
std::string summaryText(const Converted& converted) {
  const auto& [where, source, conversion, file, pose] = converted;
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
  const EntrancePupil& pupil = file.camera.pupil();
  if (!pupil.isFixed())
    text += fmt::format("Pupil    s1 {} m, s2 {} m\n", exactText(pupil.s1_m), exactText(pupil.s2_m));
  if (const auto& field = file.camera.correction()) {
    text += fmt::format("Correction of {} by {} cells, up to {:.2g} px\n", field->grid().columns,
                        field->grid().rows, field->largest());
  }
  text +=
      fmt::format("Domain   valid up to {:.1f} degrees off-axis; {}", file.domain->max_angle_rad * kDegPerRad,
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
  const auto& [where, source, conversion, file, pose] = converted;
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
      {"entrance_pupil", json{{"s1", file.camera.pupil().s1_m}, {"s2", file.camera.pupil().s2_m}}},
      {"fit", conversion.fit ? fitJson(*conversion.fit) : json(nullptr)},
      {"camera_from_rig", orNull(pose)},
      {"domain", {{"max_angle_rad", file.domain->max_angle_rad}, {"full_image", file.domain->full_image}}},
      {"trustworthy", conversion.problems.empty()},
      {"reasons", reasons}};
}

class ConvertCommand final : public Command {
 public:
  void setUp(Flags& flags) override {
    flags.explain(
        "Example: alidade convert camera.yaml -o half.yaml --crop 0,60,640,360 --resize 320x180\nExample: "
        "alidade convert camera.yaml -o turned.yaml --rotate 90 --model radtan\nExample: alidade convert "
        "camchain.yaml#cam0 -o camera_info.yaml --to ros\nExample: alidade convert rig.yaml -o camchain.yaml "
        "--to kalibr\nExample: alidade convert rig.yaml -o camera_info --to ros\nExample: alidade convert "
        "left.cameramodel right.cameramodel -o rig.yaml\nThe format of FILE is detected from its content. "
        "FILE#NAME selects one camera of a file with several. Several\nfiles become one rig; each has one "
        "camera and its pose in a common frame. OpenCV's intrinsics.yml and\nextrinsics.yml are one pair. "
        "The edits are applied to each camera, in this order: crop, bin, resize, rotate, model.\nPixel (0, "
        "0) is the centre of the top-left pixel. --rotate also rotates the axes of the camera frame.\nExit "
        "code 3: the result must not be used; no camera file is written.");
    flags.add("file", &paths_, "Camera or rig file of any format (docs/formats.md), or the files of a rig",
              kFilePath);
    flags.add("-o,--output", &output_,
              "Camera file to write (a folder for the two files of a pair with --to ros); - writes it to "
              "standard output instead of the summary",
              kFilePath);
    addFormatFlag(flags, format_, "Format of the output: ", true);
    flags.add("--crop", &crop_, "Part of the image to keep, in pixels: X,Y,WIDTH,HEIGHT");
    flags.add("--bin", &request_.bin,
              "Combine N x N pixels into one; incomplete blocks at the edge are cropped");
    flags.add("--resize", &resize_, "New image size in pixels: WIDTHxHEIGHT");
    flags.redirect({"--scale"}, "--resize WIDTHxHEIGHT, for example --resize 320x240");
    flags.addQuarterTurns("--rotate", request_.rotate_deg, "Rotate the image clockwise by this many degrees");
    flags.add("--model", &request_.model, "Fit this lens model instead: " + join(modelIds(), ", "),
              oneOf(modelIds(), 0, aliasedModels()));
    flags.add("--max-error", &request_.max_error_px,
              "Largest accepted RMS error of the new model in pixels; the limit for a single pixel is "
              "ten times larger",
              {.complaint = nonNegativeNumber, .limits = "0 or more"});
    flags.addSwitch("--drop-pupil", request_.drops_pupil,
                    "Leave out an entrance pupil that moves, which near points see and far ones do not");
    flags.addSwitch("--drop-correction", request_.drops_correction,
                    "Leave out a correction field, and fit the model to the whole camera instead");
    flags.addSwitch("--keep-untrustworthy", keep_untrustworthy_,
                    "Write the camera file even if the result must not be used");
    addReadOptions(flags, camera_, true);
    flags.addCommon(common_, false);
  }

  int run(const Flags&) override {
    if (paths_.empty()) throw missing("no camera file", "a camera file");
    if (output_.empty()) throw missing("no --output", "-o FILE, or -o - for standard output");
    std::vector<std::string> inputs = mapped(paths_, cameraFilePath);
    inputs.push_back(common_.config);
    if (!format().holds_rectification) checkOutput(output_, inputs, common_);
    gathered_ = gatherCameras(paths_, camera_);
    const std::vector<std::string> outputs = outputPaths();
    const bool is_new_folder = outputs.size() > 1 && !std::filesystem::exists(output_);
    for (const std::string& output : is_new_folder ? std::vector{output_} : outputs)
      checkOutput(output, inputs, common_);
    convertAll();
    const bool is_kept = isGood() || keep_untrustworthy_;
    // A format that cannot store the camera is refused before anything is printed or written.
    const std::vector<std::string> contents = is_kept ? contentsOfAll() : std::vector<std::string>();
    if (output_ != "-") writeAll(outputs, contents);
    print(outputs, contents);
    if (!isGood()) {
      printRefusal("the converted camera must not be used", output_, is_kept);
      return kUntrustworthyExit;
    }
    if (!common_.quiet && output_ != "-") printMessage("written to " + join(outputs, " and "));
    return 0;
  }

 private:
  [[nodiscard]] const CameraFormat& format() const { return cameraFormat(format_); }
  [[nodiscard]] bool isRig() const { return cameras_.size() > 1 && cameras_.front().camera_from_rig; }
  [[nodiscard]] bool isGood() const {
    return std::ranges::all_of(cameras_, [](const Converted& c) { return c.conversion.problems.empty(); });
  }

  // @param contents  empty: nothing is written
  void print(const std::vector<std::string>& outputs, const std::vector<std::string>& contents) const {
    if (common_.json) return printResult(document(outputs, !contents.empty()));
    if (output_ != "-") {
      printResult(summary() + "\n");
    } else {
      if (!contents.empty()) printResult(contents.front());
      if (!common_.quiet || !isGood()) printHelp(summary() + "\n");
    }
    if (!common_.quiet) printNotes(notes());
  }

  [[nodiscard]] ConversionRequest request() const {
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
    request.absent = absentParameters(format(), request.model);  // the fit keeps them at 0
    return request;
  }

  // True if each camera gets its own file and both state the pose of the other.
  [[nodiscard]] bool isRectifiedPair() const {
    const CameraSource& source = gathered_.source;
    return format().holds_rectification && source.cameras.size() == 2 && source.refused.empty() &&
           source.cameras.front().camera_from_rig;
  }

  // The paths of the files to write.
  [[nodiscard]] std::vector<std::string> outputPaths() const {
    if (!isRectifiedPair()) return {output_};
    const std::filesystem::path folder(output_);
    if (output_ == "-" || folder.extension() == ".yaml" || folder.extension() == ".yml") {
      throw flagError("--output " + output_, output_ == "-" ? "standard output" : "the name of a file",
                      "the name of a folder, because a pair has a file for each camera in the format " +
                          std::string(format().title),
                      "use -o FOLDER, or select one camera: alidade convert " + gathered_.where.front() +
                          " -o FILE --to " + format_);
    }
    const auto paths = mapped(gathered_.source.cameras, [&](const StatedCamera& camera) {
      return (folder / (fileNameOf(cameraLabel(camera)) + ".yaml")).string();
    });
    if (paths[0] == paths[1]) {
      throw inputError({.where = gathered_.source.path,
                        .found = "names of cameras that become the same file, " + paths[0],
                        .expected = "names that differ in more than / and _",
                        .next_step = "rename one of the cameras"});
    }
    return paths;
  }

  void writeAll(const std::vector<std::string>& outputs, const std::vector<std::string>& contents) const {
    if (contents.size() > 1) {
      std::error_code failure;
      std::filesystem::create_directory(output_, failure);
      if (failure) {
        throw inputError({.where = output_,
                          .found = "cannot create the folder: " + failure.message(),
                          .expected = "a folder for the two files"});
      }
    }
    for (std::size_t i = 0; i < contents.size(); ++i) writeFileAtomically(outputs[i], contents[i]);
  }

  void requireRoom() const {
    const CameraSource& source = gathered_.source;
    const bool is_own = format_ == kOwnFormat;
    const std::size_t num_all = source.cameras.size() + source.refused.size();
    const bool has_room =
        is_own ? num_all == 1 || source.cameras.front().camera_from_rig : num_all <= format().max_cameras;
    if (has_room || isRectifiedPair()) return;
    const std::string first = gathered_.where.size() == num_all
                                  ? gathered_.where.front()
                                  : source.path + "#" + cameraLabel(source.cameras.front());
    const std::string most = format().max_cameras == 2      ? "at most two cameras"
                             : format().holds_rectification ? "one camera, or two with poses"
                                                            : "one camera";
    throw inputError({.where = source.path,
                      .found = std::to_string(num_all) + " cameras" + (is_own ? " without poses" : ""),
                      .expected = is_own ? "one camera, or cameras with poses, which become a rig"
                                         : most + ", because a file in the format " +
                                               std::string(format().title) + " holds only that",
                      .next_step = "select one, and write a file for each camera: alidade convert " + first +
                                   " -o FILE --to " + format_});
  }

  void convertAll() {
    requireRoom();
    requireAll(gathered_.source);
    const ConversionRequest asked = request();
    const auto& rig = gathered_.rig;
    // A problem of a rig affects each of its cameras.
    const bool is_rig_rejected = rig && rig->isCalibrated() && rig->verdict == Verdict::kNo;
    for (std::size_t i = 0; i < gathered_.source.cameras.size(); ++i) {
      const StatedCamera& stated = gathered_.source.cameras[i];
      const std::string& where = gathered_.where[i];
      CameraRecord source = recordOf(stated, where);
      Conversion conversion = convertCamera(source, asked);
      std::vector<ConversionProblem>& problems = conversion.problems;
      constexpr auto kRejected = ConversionProblem::kSourceUntrustworthy;
      if (is_rig_rejected && std::ranges::count(problems, kRejected) == 0) problems.push_back(kRejected);
      std::optional<SE3> pose = stated.camera_from_rig;
      if (pose) pose = SE3{rotationFromMatrix(conversion.edit.new_from_old), Eigen::Vector3d::Zero()} * *pose;
      CameraRecord file = convertedRecord(source, conversion, provenance(maker(), where, source, conversion));
      cameras_.push_back({where, std::move(source), std::move(conversion), std::move(file), pose});
    }
  }

  // The rig as read, or as far as known, with the converted cameras. The standard deviations are those of
  // motions in the rig's frame, so they stay valid when a camera is turned.
  [[nodiscard]] RigRecord wholeRig() const {
    RigRecord rig = gathered_.rig.value_or(RigRecord{});
    bool is_edited = false;
    for (std::size_t i = 0; i < cameras_.size(); ++i) {
      if (!gathered_.rig) rig.cameras.push_back({.camera = cameras_[i].file});
      rig.cameras[i].camera = cameras_[i].file;
      rig.cameras[i].camera.name.name = cameraLabel(gathered_.source.cameras[i]);
      rig.cameras[i].camera.created_by = cameras_[i].source.created_by;  // the rig states its own origin
      rig.cameras[i].camera_from_rig = *cameras_[i].camera_from_rig;
      is_edited = is_edited || !cameras_[i].conversion.steps.empty();
    }
    // The covariance belongs to the old parameters.
    if (is_edited) rig.covariance.clear();
    rig.created_by = maker() + " of " + join(gathered_.where, ", ") +
                     (rig.created_by.empty() ? "" : " (" + rig.created_by + ")");
    return rig;
  }

  // One text per file.
  [[nodiscard]] std::vector<std::string> contentsOfAll() const {
    if (format_ == kOwnFormat)
      return {isRig() ? rigFileText(wholeRig()) : cameraFileText(cameras_.front().file)};
    std::vector<NamedCamera> named;
    for (std::size_t i = 0; i < cameras_.size(); ++i) {
      const StatedCamera& stated = gathered_.source.cameras[i];
      const CameraRecord& file = cameras_[i].file;
      named.push_back({.name = isRectifiedPair() ? cameraLabel(stated) : stated.name,
                       .camera = file.camera,
                       .image_size = file.image_size,
                       .camera_from_rig = cameras_[i].camera_from_rig,
                       .where = cameras_[i].where});
    }
    if (isRectifiedPair()) return rectifiedPairTexts(format(), named);
    return {formatText(format(), named, output_)};
  }

  // A note on poses that are changed when written; empty if there are none.
  [[nodiscard]] std::string poseNote() const {
    const Converted& first = cameras_.front();
    const bool is_one = cameras_.size() == 1;
    if (!first.camera_from_rig || (format().holds_rectification && !is_one)) return "";
    const bool is_at_origin = first.camera_from_rig->log().isZero(0);
    if (is_one && is_at_origin) return "";
    using Poses = CameraFormat::Poses;
    const Poses poses = is_one && format_ == kOwnFormat ? Poses::kNone : format().poses;
    const std::string title(format().title);
    if (poses == Poses::kNone || (poses == Poses::kFromFirst && is_one)) {
      return first.where + ": " + (is_one ? "the pose of the camera is" : "the poses are") +
             " not written to a file of the format " + title;
    }
    if (poses != Poses::kFromFirst || is_at_origin) return "";
    return first.where + ": this camera becomes the origin of the rig, as the format " + title + " requires";
  }

  // Remarks that do not prevent the conversion.
  [[nodiscard]] std::vector<std::string> notes() const {
    std::vector<std::string> notes;
    for (const StatedCamera& camera : gathered_.source.cameras) {
      for (const Remark& remark : camera.remarks) {
        if (std::ranges::find(notes, remark.message) == notes.end()) notes.push_back(remark.message);
      }
    }
    const std::string title(format().title);
    for (const Converted& c : cameras_) {
      if (format_ == kOwnFormat || !c.source.calibration) continue;
      notes.push_back(c.where +
                      ": uncertainty, verdict and boards of the calibration cannot be stored in the " +
                      "format " + title);
    }
    if (const std::string note = poseNote(); !note.empty()) notes.push_back(note);
    if (!format().holds_size) notes.push_back("the image size cannot be stored in the format " + title);
    return notes;
  }

  [[nodiscard]] std::string summary() const {
    std::vector<std::string> texts;
    for (const Converted& c : cameras_) {
      texts.push_back(summaryText(c));
      if (isRig())
        texts.back() +=
            "\nPose     " + poseText(*c.camera_from_rig * cameras_.front().camera_from_rig->inverse());
    }
    return join(texts, "\n\n");
  }

  [[nodiscard]] std::string document(const std::vector<std::string>& outputs, bool is_kept) const {
    json all = {{"output", output_}, {"format", format_}, {"written", is_kept}, {"notes", notes()}};
    if (outputs.size() > 1) all["files"] = outputs;
    if (cameras_.size() == 1) {
      all.update(summaryJson(cameras_.front()));
    } else {
      all["cameras"] = mapped(cameras_, summaryJson);
    }
    return jsonText(all);
  }

  std::vector<std::string> paths_;
  std::string output_;
  std::string format_ = std::string(kOwnFormat);
  ReadOptions camera_;
  ConversionRequest request_;
  std::string crop_;
  std::string resize_;
  bool keep_untrustworthy_ = false;
  GatheredCameras gathered_;
  std::vector<Converted> cameras_;
};

}  // namespace

const CommandEntry kConvertCommand = {
    "convert", "Change the format, image size, orientation or lens model of a camera file",
    made<ConvertCommand>};

}  // namespace alidade
