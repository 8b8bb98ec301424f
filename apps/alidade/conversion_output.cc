// SPDX-License-Identifier: MIT
#include "conversion_output.h"

#include <numbers>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "alidade/core/size_groups.h"
#include "alidade/core/text.h"
#include "command.h"

namespace alidade {

namespace {

// "(12.0, 34.5)"
std::string pixelText(const Eigen::Vector2d& pixel) {
  return fmt::format("({:.1f}, {:.1f})", pixel.x(), pixel.y());
}

// There is a fit for all problems but the first.
std::string problemText(ConversionProblem problem, const std::string& path, const Conversion& conversion) {
  if (problem == ConversionProblem::kSourceUntrustworthy)
    return path + ": its own verdict says that it must not be used";
  const ModelFit& fit = conversion.fit.value();
  const std::string_view model = fit.camera.modelId();
  switch (problem) {
    case ConversionProblem::kUnreachedPixels:
      return fmt::format("{} cannot represent {:.3g} % of the pixels, for example {}; limit {} %", model,
                         100 * fit.unreachedShare(), pixelText(*fit.unreached_pixel),
                         100 * kMaxUnreachedShare);
    case ConversionProblem::kModelRms:
      return fmt::format("{} has an RMS error of {:.3g} px; limit {} px (--max-error)", model, fit.rms_px,
                         conversion.max_error_px);
    default:
      return fmt::format("{0} has an error of {2:.3g} px at pixel {1}; limit {3} px ({4} times --max-error)",
                         model, pixelText(fit.worst_pixel), fit.max_error_px,
                         kMaxErrorFactor * conversion.max_error_px, kMaxErrorFactor);
  }
}

std::string capitalised(std::string word) {
  word.front() = static_cast<char>(word.front() - 'a' + 'A');
  return word;
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

}  // namespace

std::string provenance(const std::string& path, const CameraRecord& source, const Conversion& conversion) {
  std::vector<std::string> steps;
  for (const Conversion::Step& step : conversion.steps) steps.push_back(step.name + " " + step.value);
  return programName() + " convert" + (steps.empty() ? "" : " " + join(steps, ", ")) + " of " + path +
         (source.created_by.empty() ? "" : " (" + source.created_by + ")");
}

std::string conversionSummary(const std::string& path, const CameraRecord& source,
                              const Conversion& conversion, const CameraRecord& file) {
  std::string text =
      fmt::format("From     {}: {}, {} px\n", path, source.camera.modelId(), sizeText(source.image_size));
  for (const Conversion::Step& step : conversion.steps) {
    if (step.name != "model")
      text += fmt::format("{:<8} {}: {} px\n", capitalised(step.name), step.value, sizeText(step.size));
  }
  if (!conversion.edit.new_from_old.isIdentity()) {
    const Eigen::Matrix3d& R = conversion.edit.new_from_old;
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
    text += fmt::format("\nFAILED   {} [{}]", problemText(problem, path, conversion), problemId(problem));
  return text;
}

nlohmann::json conversionJson(const std::string& path, const CameraRecord& source,
                              const Conversion& conversion, const CameraRecord& file) {
  using nlohmann::json;
  const auto sizeJson = [](ImageSize size) { return json{{"width", size.width}, {"height", size.height}}; };
  json parameters = json::object();
  for (std::size_t i = 0; i < file.camera.parameters().size(); ++i)
    parameters[std::string(file.camera.parameterNames()[i])] = file.camera.parameters()[i];
  json steps = json::array();
  for (const Conversion::Step& step : conversion.steps)
    steps.push_back({{"step", step.name}, {"value", step.value}, {"image_size", sizeJson(step.size)}});
  json rotation = json::array();
  for (const auto& row : conversion.edit.new_from_old.rowwise()) rotation.push_back({row(0), row(1), row(2)});
  json reasons = json::array();
  for (const ConversionProblem problem : conversion.problems)
    reasons.push_back({{"id", problemId(problem)}, {"message", problemText(problem, path, conversion)}});
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
  return {
      {"input", path},
      {"from", {{"model", source.camera.modelId()}, {"image_size", sizeJson(source.image_size)}}},
      {"steps", steps},
      {"new_from_old", rotation},
      {"model", file.camera.modelId()},
      {"image_size", sizeJson(file.image_size)},
      {"parameters", parameters},
      {"fit", fit},
      {"domain", {{"max_angle_rad", file.domain->max_angle_rad}, {"full_image", file.domain->full_image}}},
      {"trustworthy", conversion.problems.empty()},
      {"reasons", reasons}};
}

}  // namespace alidade
