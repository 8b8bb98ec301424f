// SPDX-License-Identifier: MIT
#include "alidade/camera/parameter_complaint.h"

#include <cmath>

#include "alidade/camera/model_list.h"
#include "alidade/core/error.h"
#include "alidade/core/text.h"

namespace alidade {
namespace {

std::string rangeText(const ParamRange& range) {
  if (std::isfinite(range.max))
    return "a number from " + exactText(range.min) + " to " + exactText(range.max);
  if (std::isfinite(range.min)) return "a number of at least " + exactText(range.min);
  return "a finite number";
}

}  // namespace

std::optional<std::string> parameterComplaint(std::string_view model_id, std::size_t i, double value) {
  std::optional<ParamRange> range;
  forEachModel(AllModels{}, [&](auto tag) {
    using M = typename decltype(tag)::Model;
    if (M::kId != model_id) return;
    expect(i < static_cast<std::size_t>(kNumParams<M>), "a parameter of the model");
    range = i < 4 ? ParamRange{} : M::kLensRanges[i - 4];
  });
  expect(range.has_value(), "a known model");
  const bool is_focal = i < 2;
  const bool is_in_range = value >= range->min && value <= range->max;
  if (std::isfinite(value) && (is_focal ? value > 0 : is_in_range)) return std::nullopt;
  return is_focal ? "a positive focal length in pixels" : rangeText(*range);
}

}  // namespace alidade
