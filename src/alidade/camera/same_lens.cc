// SPDX-License-Identifier: MIT
#include "alidade/camera/same_lens.h"
#include "alidade/core/mapped.h"

#include <algorithm>
#include <array>
#include <functional>
#include <map>
#include <string>
#include <utility>

namespace alidade {
namespace {

// A lens by the names of its parameters; one that is not there is zero.
struct NamedLens {
  std::string id;
  std::map<std::string, double, std::less<>> params;

  [[nodiscard]] double at(std::string_view name) const {
    const auto found = params.find(name);
    return found == params.end() ? 0.0 : found->second;
  }
  // The same parameters in another model, except those that are `changed`.
  [[nodiscard]] NamedLens with(std::string_view new_id,
                               std::initializer_list<std::pair<std::string_view, double>> changed) const {
    NamedLens lens{.id = std::string(new_id), .params = params};
    for (const auto& [name, value] : changed) lens.params[std::string(name)] = value;
    return lens;
  }
  [[nodiscard]] NamedLens scaled(double factor) const {
    return with(id, {{"fx", factor * at("fx")}, {"fy", factor * at("fy")}});
  }
  // True if all parameters that the model does not have are zero.
  [[nodiscard]] bool fits(std::string_view model_id) const {
    const auto names = parameterNames(model_id);
    return std::all_of(params.begin(), params.end(), [&](const auto& param) {
      return param.second == 0 || parameterIndex(names, param.first);
    });
  }
};

// Models that are the same lens, both ways, as long as the parameters that the other does not have are zero.
constexpr std::array<std::array<std::string_view, 2>, 7> kSameByName = {{{"pinhole", "radtan"},
                                                                         {"radtan", "rational"},
                                                                         {"rational", "thin_prism"},
                                                                         {"pinhole", "ucm"},
                                                                         {"pinhole", "fov"},
                                                                         {"radtan", "omni"},
                                                                         {"ucm", "double_sphere"}}};

// The lens in all models to which one step leads.
std::vector<NamedLens> neighbours(const NamedLens& lens) {
  std::vector<NamedLens> found;
  for (const auto& [a, b] : kSameByName) {
    const std::string_view other = lens.id == a ? b : lens.id == b ? a : "";
    if (!other.empty() && lens.fits(other)) found.push_back(lens.with(other, {}));
  }
  const double xi = lens.at("xi");
  const double alpha = lens.at("alpha");
  if (lens.id == "omni" && lens.with("omni", {{"xi", 0}}).fits("ucm"))
    found.push_back(lens.with("ucm", {{"xi", 0}, {"alpha", xi / (1 + xi)}}).scaled(1 / (1 + xi)));
  if (lens.id == "ucm" && alpha < 1) {
    const double xi_of_alpha = alpha / (1 - alpha);
    found.push_back(lens.with("omni", {{"alpha", 0}, {"xi", xi_of_alpha}}).scaled(1 + xi_of_alpha));
  }
  if (lens.id == "ucm") found.push_back(lens.with("eucm", {{"beta", 1}}));
  if (lens.id == "eucm" && lens.at("beta") == 1) found.push_back(lens.with("ucm", {{"beta", 0}}));
  if (lens.id == "eucm" && alpha == 0) found.push_back(lens.with("pinhole", {{"beta", 0}}));
  return found;
}

}  // namespace

std::optional<std::vector<double>> sameLensParameters(const AnyCamera& camera, std::string_view model_id) {
  const auto target_names = parameterNames(model_id);
  NamedLens source{.id = std::string(camera.modelId()), .params = {}};
  for (std::size_t i = 0; i < camera.parameters().size(); ++i)
    source.params[std::string(camera.parameterNames()[i])] = camera.parameters()[i];

  std::vector<NamedLens> lenses = {source};  // grows at its end: breadth first, the shortest chain wins
  for (std::size_t i = 0; i < lenses.size(); ++i) {
    if (lenses[i].id == model_id) {
      return mapped(target_names, [&](std::string_view name) { return lenses[i].at(name); });
    }
    for (NamedLens& next : neighbours(lenses[i])) {
      const bool is_new = std::none_of(lenses.begin(), lenses.end(),
                                       [&next](const NamedLens& lens) { return lens.id == next.id; });
      if (is_new) lenses.push_back(std::move(next));
    }
  }
  return std::nullopt;
}

}  // namespace alidade
