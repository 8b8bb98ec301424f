// SPDX-License-Identifier: MIT
#include "alidade/calibrate/start/held_params.h"

#include <algorithm>
#include <cmath>
#include <span>
#include <string_view>

#include "alidade/camera/model_fit.h"
#include "alidade/camera/model_traits.h"
#include "alidade/core/error.h"
#include "alidade/core/size_groups.h"
#include "alidade/core/text.h"

namespace alidade {
namespace {

constexpr int kFx = 0;
constexpr int kFy = 1;
constexpr int kCx = 2;

// True if the parameter can be held without a given value. A focal length cannot, nor can a lens parameter
// that must not be zero.
bool hasOwnValue(std::string_view model_id, int i) {
  if (static_cast<std::size_t>(i) < kNumAffine) return i >= kCx;
  const ParamRange& range = modelTraits(model_id).lens_ranges[static_cast<std::size_t>(i) - kNumAffine];
  return range.min <= 0 && range.max >= 0;
}

}  // namespace

std::string namedModel(const CalibratorOptions& options) {
  const bool is_open = options.model == kAutoModel && options.initial.has_value();
  return is_open ? std::string(options.initial->camera.modelId()) : options.model;
}

ParamConstraint constraintOf(const CalibratorOptions& options) {
  const std::string model = namedModel(options);
  const bool is_open = model == kAutoModel;
  const auto names = is_open ? std::span<const std::string_view>(kAffineParamNames) : parameterNames(model);
  const std::vector<std::string> known(names.begin(), names.end());
  ParamConstraint constraint{.held = {}, .same_focal = options.same_focal};
  if (!is_open) {
    if (const auto i = parameterIndex(names, modelTraits(model).redundant))
      constraint.held.push_back(static_cast<int>(*i));
  }
  for (std::string name : options.held) {
    if (const std::size_t dot = name.find('.'); dot != std::string::npos) {
      const std::string owner = name.substr(0, dot);
      name.erase(0, dot + 1);
      if (owner != model && parameterIndex(parameterNames(owner), name)) continue;
      if (owner != model) {
        throw usageError({.where = "parameters to hold",
                          .found = "'" + name + "' of " + owner,
                          .expected = "a parameter of that model"});
      }
    }
    const auto at = std::ranges::find(known, name);
    if (at == known.end()) {
      const auto nearest = nearestName(name, known);
      throw usageError(
          {.where = "parameters to hold",
           .found = "'" + name + "'",
           .expected = (is_open ? "parameters that all models have, since the model is to be chosen: "
                                : "parameters of " + model + ": ") +
                       join(known, ", "),
           .next_step = is_open   ? "name the model with --model"
                        : nearest ? "did you mean '" + *nearest + "'?"
                                  : ""});
    }
    const int i = static_cast<int>(at - known.begin());
    if (!options.initial && !hasOwnValue(model, i)) {
      throw usageError({.where = "parameters to hold",
                        .found = "'" + name + "' without a value",
                        .expected = "an initial camera, whose value it keeps",
                        .next_step = "give a camera file with --init"});
    }
    if (!constraint.holds(i)) constraint.held.push_back(i);
  }
  std::ranges::sort(constraint.held);
  // A given lens keeps its entrance pupil, too.
  for (std::size_t i = 0;
       !is_open && constraint.held.size() == known.size() + i && i < options.num_pupil.value_or(0); ++i)
    constraint.held.push_back(static_cast<int>(known.size() + i));
  return constraint;
}

std::vector<double> initialParameters(const CalibratorOptions& options, ImageSize size) {
  const InitialCamera& initial = *options.initial;
  if (initial.size != size) {
    throw inputError({.where = "initial camera",
                      .found = "images of " + sizeText(initial.size),
                      .expected = sizeText(size) + " as the views have",
                      .next_step = "adapt the camera with alidade convert --resize or --crop"});
  }
  const AnyCamera camera = initial.camera.modelId() == options.model
                               ? initial.camera
                               : fitModel(initial.camera, size, options.model).camera;
  return {camera.parameters().begin(), camera.parameters().end()};
}

bool applyConstraint(const CalibratorOptions& options, const ParamConstraint& constraint, ImageSize size,
                     std::vector<double>& params) {
  const std::vector<double> before = params;
  if (!options.initial) {
    for (const int i : constraint.held) {
      const double centre = i == kCx ? 0.5 * (size.width - 1) : 0.5 * (size.height - 1);
      params[static_cast<std::size_t>(i)] = static_cast<std::size_t>(i) < kNumAffine ? centre : 0.0;
    }
  }
  if (constraint.same_focal) {
    const double mean = std::sqrt(params[kFx] * params[kFy]);
    const double focal = constraint.holds(kFx) ? params[kFx] : constraint.holds(kFy) ? params[kFy] : mean;
    params[kFx] = params[kFy] = focal;
  }
  return params != before;
}

}  // namespace alidade
