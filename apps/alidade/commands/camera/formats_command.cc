// SPDX-License-Identifier: MIT
#include <algorithm>
#include <cmath>
#include <limits>
#include <map>

#include <fmt/format.h>

#include "alidade/camera/model_fit.h"
#include "alidade/camera/model_traits.h"
#include "alidade/core/text.h"
#include "alidade/files/formats/camera_format.h"
#include "alidade/report/data/json_output.h"
#include "command.h"
#include "summary_lines.h"

namespace alidade {
namespace {

class FormatsCommand final : public Command {
 public:
  void setUp(Flags& flags) override {
    flags.explain(
        "Example: alidade formats\nExample: alidade formats kannala_brandt\nPrints each format of camera files, how "
        "many cameras a file has and whether it states their poses, and\nthe models that it holds exactly: \"ucm as omni\" "
        "is ucm as an equal lens of omni. With MODEL, what each format\nmakes of this model; where it is not exact, the "
        "closest model with its RMS error in pixels, for a lens of\n640x480 pixels in which every coefficient is at "
        "work. alidade convert says the error of your lens.");
    flags.add("model", &model_, "Lens model: " + join(modelIds(), ", "),
              oneOf(modelIds(), 0, aliasedModels()));
    flags.addCommon(common_, false);
  }

  int run(const Flags&) override {
    json formats = json::array();
    Lines lines;
    for (const CameraFormat* format : cameraFormats()) {
      formats.push_back(
          {{"format", format->id}, {"title", format->title}, {"written", format->write != nullptr}});
      const std::string text =
          model_.empty() ? addModels(*format, formats.back()) : addHolding(*format, formats.back());
      append(lines,
             wrapped(std::string(format->id) + " ", text + (format->write == nullptr ? " [only read]" : "")));
    }
    answer([&] { return jsonText({{"formats", formats}}); }, [&] { return join(lines, "\n") + "\n"; });
    return 0;
  }

 private:
  // Adds all that the format holds to its document; returns the lines for people.
  static std::string addModels(const CameraFormat& format, json& document) {
    std::vector<std::string> names;
    document["models"] = json::array();
    for (const HeldModel& held : heldModels(format)) {
      document["models"].push_back({{"model", held.model}, {"as", held.as}, {"zero", held.absent}});
      const std::string as = held.as == held.model ? "" : " as " + std::string(held.as);
      names.push_back(std::string(held.model) + (held.absent.empty() ? as : " (" + zeroText(held) + ")"));
    }
    const bool is_any = format.max_cameras >= CameraFormat::kAnyNumber;
    document["max_cameras"] = is_any ? json(nullptr) : json(format.max_cameras);
    const bool is_any_read = std::max(format.max_cameras, format.max_read) >= CameraFormat::kAnyNumber;
    document["max_cameras_read"] =
        is_any_read ? json(nullptr) : json(std::max(format.max_cameras, format.max_read));
    const bool has_poses = format.holdsPoses() || format.reads_poses;
    document["poses"] = has_poses;
    return fmt::format("{}{}: {}", format.camerasText(), has_poses ? " with poses" : "", join(names, ", "));
  }

  static std::string zeroText(const HeldModel& held) {
    std::vector<std::string> zero;
    for (const std::string_view parameter : held.absent) zero.push_back(std::string(parameter) + " = 0");
    return join(zero, ", ");
  }

  // The same for one model; if the format does not hold it exactly, with its model that fits exampleLens()
  // best.
  std::string addHolding(const CameraFormat& format, json& document) {
    const std::vector<HeldModel> all = heldModels(format);
    const auto held = std::ranges::find(all, model_, &HeldModel::model);
    const bool is_held = held != all.end();
    const bool is_whole = is_held && held->absent.empty();
    std::string how = !is_held ? "" : held->as == model_ ? "exactly" : "exactly, as " + std::string(held->as);
    if (is_held && !is_whole) how += " with " + zeroText(*held) + "; else ";
    document.update({{"as", is_held ? json(held->as) : json(nullptr)},
                     {"zero", is_held ? held->absent : std::vector<std::string_view>()}});
    const std::string_view fitted =
        is_whole || format.write == nullptr
            ? std::string_view()
            : *std::ranges::min_element(format.models, {},
                                        [&](std::string_view target) { return errorOf(target); });
    document["fitted"] = document["typical_rms_px"] = nullptr;
    if (!fitted.empty() && std::isfinite(errorOf(fitted))) {
      how += fmt::format("fitted by {}, typically {:.2g} px RMS", fitted, errorOf(fitted));
      document.update({{"fitted", fitted}, {"typical_rms_px", errorOf(fitted)}});
    }
    return how.empty() ? "not" : how;
  }

  // RMS error of the closest camera of another model, px; infinite if it does not reach each pixel.
  double errorOf(std::string_view target) {
    const auto [known, is_new] = errors_.try_emplace(target, std::numeric_limits<double>::infinity());
    if (is_new && target != model_) {
      const NamedCamera lens = exampleLens(model_);
      const ModelFit fit = fitModel(lens.camera, lens.image_size, target);
      if (fit.unreachedShare() == 0) known->second = fit.rms_px;
    }
    return known->second;
  }

  std::string model_;
  std::map<std::string_view, double> errors_;  // formats share models
};

}  // namespace

const CommandEntry kFormatsCommand = {
    "formats", "List the formats of camera files and the lens models they hold", made<FormatsCommand>};

}  // namespace alidade
