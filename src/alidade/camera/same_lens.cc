// SPDX-License-Identifier: MIT
#include "alidade/camera/same_lens.h"

#include <algorithm>
#include <array>
#include <functional>
#include <map>
#include <span>
#include <string>

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
  [[nodiscard]] bool areZero(std::span<const std::string_view> names) const {
    return std::all_of(names.begin(), names.end(), [this](std::string_view name) { return at(name) == 0; });
  }
  // The same with another id, some parameters left out.
  [[nodiscard]] NamedLens renamed(std::string_view new_id,
                                  std::initializer_list<std::string_view> without = {}) const {
    NamedLens lens{.id = std::string(new_id), .params = params};
    for (const std::string_view name : without) lens.params.erase(std::string(name));
    return lens;
  }
  // The same with another id and value.
  [[nodiscard]] NamedLens with(std::string_view new_id, std::string_view name, double value) const {
    NamedLens lens = renamed(new_id);
    lens.params[std::string(name)] = value;
    return lens;
  }
  [[nodiscard]] NamedLens scaled(double factor) const {
    NamedLens lens = *this;
    lens.params["fx"] *= factor;
    lens.params["fy"] *= factor;
    return lens;
  }
};

using Names = std::span<const std::string_view>;

constexpr std::array<std::string_view, 4> kPerspective = {"pinhole", "radtan", "rational", "thin_prism"};
// What each of them adds to the one before.
constexpr std::array<std::string_view, 5> kRadtanTerms = {"k1", "k2", "p1", "p2", "k3"};
constexpr std::array<std::string_view, 3> kRationalTerms = {"k4", "k5", "k6"};
constexpr std::array<std::string_view, 4> kPrismTerms = {"s1", "s2", "s3", "s4"};
constexpr std::array<Names, 3> kAddedTerms = {kRadtanTerms, kRationalTerms, kPrismTerms};
constexpr std::array<std::string_view, 4> kOmniTerms = {"k1", "k2", "p1", "p2"};

// The lens in all models to which one step leads.
std::vector<NamedLens> neighbours(const NamedLens& lens) {
  std::vector<NamedLens> found;
  const auto at = std::find(kPerspective.begin(), kPerspective.end(), lens.id);
  if (at != kPerspective.end()) {
    const auto i = static_cast<std::size_t>(at - kPerspective.begin());
    if (i + 1 < kPerspective.size()) found.push_back(lens.renamed(kPerspective[i + 1]));
    if (i > 0 && lens.areZero(kAddedTerms[i - 1])) found.push_back(lens.renamed(kPerspective[i - 1]));
  }
  if (lens.id == "pinhole") {
    found.push_back(lens.with("ucm", "alpha", 0));
    found.push_back(lens.with("fov", "w", 0));
  }
  if (lens.id == "radtan" && lens.at("k3") == 0) found.push_back(lens.with("omni", "xi", 0));
  if (lens.id == "omni" && lens.at("xi") == 0) found.push_back(lens.renamed("radtan", {"xi"}));
  if (lens.id == "omni" && lens.areZero(kOmniTerms)) {
    const double xi = lens.at("xi");
    found.push_back(lens.with("ucm", "alpha", xi / (1 + xi)).scaled(1 / (1 + xi)));
  }
  if (lens.id == "ucm") {
    const double alpha = lens.at("alpha");
    if (alpha < 1) {
      const double xi = alpha / (1 - alpha);
      found.push_back(lens.renamed("omni", {"alpha"}).with("omni", "xi", xi).scaled(1 + xi));
    }
    found.push_back(lens.with("eucm", "beta", 1));
    found.push_back(lens.with("double_sphere", "xi", 0));
  }
  if (lens.id == "eucm" && lens.at("beta") == 1) found.push_back(lens.renamed("ucm", {"beta"}));
  if (lens.id == "double_sphere" && lens.at("xi") == 0) found.push_back(lens.renamed("ucm", {"xi"}));
  if ((lens.id == "ucm" || lens.id == "eucm") && lens.at("alpha") == 0)
    found.push_back(lens.renamed("pinhole", {"alpha", "beta"}));
  if (lens.id == "fov" && lens.at("w") == 0) found.push_back(lens.renamed("pinhole", {"w"}));
  return found;
}

}  // namespace

std::optional<std::vector<double>> sameLensParameters(const AnyCamera& camera, std::string_view model_id) {
  const Names target_names = parameterNames(model_id);
  NamedLens source{.id = std::string(camera.modelId()), .params = {}};
  for (std::size_t i = 0; i < camera.parameters().size(); ++i)
    source.params[std::string(camera.parameterNames()[i])] = camera.parameters()[i];

  std::vector<NamedLens> lenses = {source};  // grows at its end: breadth first, the shortest chain wins
  for (std::size_t i = 0; i < lenses.size(); ++i) {
    if (lenses[i].id == model_id) {
      std::vector<double> params;
      for (const std::string_view name : target_names) params.push_back(lenses[i].at(name));
      return params;
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
