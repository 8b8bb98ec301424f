// SPDX-License-Identifier: MIT
#include "conversion.h"

#include <cmath>
#include <string_view>
#include <utility>

#include <fmt/format.h>

#include "alidade/camera/self_check.h"
#include "alidade/core/error.h"
#include "alidade/core/text.h"
#include "command.h"
#include "conversion_output.h"
#include "converted_record.h"

namespace alidade {
namespace {

constexpr double kMaxUnreachedShare = 1e-3;
// The largest error anywhere may be this many times the RMS that is accepted.
constexpr double kMaxErrorFactor = 10;

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

std::vector<Conversion::Reason> reasonsAgainst(const CameraRecord& source, const std::string& path,
                                               const Conversion& conversion, double max_error_px) {
  std::vector<Conversion::Reason> reasons;
  if (source.calibration && source.calibration->verdict == Verdict::kNo)
    reasons.push_back({"source_untrustworthy", path + " says of itself that it is not to be trusted"});
  if (!conversion.fit) return reasons;
  const ModelFit& fit = *conversion.fit;
  const std::string_view model = fit.camera.modelId();
  if (fit.unreachedShare() > kMaxUnreachedShare) {
    reasons.push_back(
        {"unreached_pixels",
         fmt::format("{} does not reach {:.3g} % of the pixels, such as {}; accepted {} %", model,
                     100 * fit.unreachedShare(), pixelText(*fit.unreached_pixel), 100 * kMaxUnreachedShare)});
  }
  if (fit.is_exact) return reasons;
  if (fit.rms_px > max_error_px) {
    reasons.push_back(
        {"model_rms", fmt::format("{} misses the pixels by {:.3g} px (RMS); accepted {} px (--max-error)",
                                  model, fit.rms_px, max_error_px)});
  }
  if (fit.max_error_px > kMaxErrorFactor * max_error_px) {
    reasons.push_back(
        {"model_error", fmt::format("{} misses pixel {} by {:.3g} px; accepted {} px ({} times --max-error)",
                                    model, pixelText(fit.worst_pixel), fit.max_error_px,
                                    kMaxErrorFactor * max_error_px, kMaxErrorFactor)});
  }
  return reasons;
}

// "alidade 0.1.0 convert crop 0,60,640,360, resize 320x180 of camera.yaml (alidade 0.1.0)"
std::string provenance(const CameraRecord& source, const std::string& path, const Conversion& conversion) {
  std::vector<std::string> steps;
  for (const Conversion::Step& step : conversion.steps) steps.push_back(step.name + " " + step.value);
  return programName() + " convert" + (steps.empty() ? "" : " " + join(steps, ", ")) + " of " + path +
         (source.created_by.empty() ? "" : " (" + source.created_by + ")");
}

}  // namespace

Conversion convertCamera(const CameraRecord& source, const std::string& path,
                         const ConversionRequest& request) {
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
  if (!request.crop.empty()) {
    const auto n =
        wholeNumbers("--crop", request.crop, ',', 4, "X,Y,WIDTH,HEIGHT in pixels, such as 0,60,640,360");
    take("crop", request.crop,
         cropCamera(now.camera, now.size, {.x = n[0], .y = n[1], .width = n[2], .height = n[3]}));
  }
  if (request.bin) take("bin", std::to_string(*request.bin), binCamera(now.camera, now.size, *request.bin));
  if (!request.resize.empty()) {
    const auto n =
        wholeNumbers("--resize", request.resize, 'x', 2, "WIDTHxHEIGHT in pixels, such as 320x180");
    take("resize", request.resize, resizeCamera(now.camera, now.size, {.width = n[0], .height = n[1]}));
  }
  if (request.rotate_deg)
    take("rotate", std::to_string(*request.rotate_deg),
         rotateCamera(now.camera, now.size, *request.rotate_deg / 90));
  if (!request.model.empty()) {
    conversion.fit = fitModel(now.camera, now.size, request.model, request.absent);
    conversion.steps.push_back({"model", request.model, now.size});
  }
  conversion.reasons = reasonsAgainst(source, path, conversion, request.max_error_px);
  return conversion;
}

CameraRecord convertedFile(const CameraRecord& source, const std::string& path,
                           const Conversion& conversion) {
  const AnyCamera& camera = conversion.camera();
  const ImageSize size = conversion.edit.size;
  const DomainCertificate domain = conversion.fit ? conversion.fit->domain : certifyDomain(camera, size);
  CameraRecord file{
      .camera = camera,
      .image_size = size,
      .domain = DomainClaim{.max_angle_rad = domain.cone.max_angle_rad, .full_image = domain.full_image},
      .self_check = makeSelfCheck(camera, size),
      .calibration = {},
      .created_by = provenance(source, path, conversion)};
  // A model that reaches no pixel has no error. A file needs a number, and has the finding that says it.
  const double fit_rms_px =
      conversion.fit && std::isfinite(conversion.fit->rms_px) ? conversion.fit->rms_px : 0.0;
  if (source.calibration) {
    file.calibration = editedRecord(*source.calibration, source.camera, conversion.edit);
    if (conversion.fit && (!conversion.fit->is_exact || camera.modelId() != source.camera.modelId()))
      file.calibration = refittedRecord(*std::move(file.calibration), fit_rms_px);
  }
  if (!conversion.reasons.empty()) {
    // A file that was kept all the same says so, even one without a calibration of its own.
    if (!file.calibration) {
      file.calibration.emplace();
      file.calibration->rms_px = fit_rms_px;
    }
    file.calibration->verdict = Verdict::kNo;
    for (const Conversion::Reason& reason : conversion.reasons)
      file.calibration->findings.push_back(reason.id);
  }
  return file;
}

}  // namespace alidade
