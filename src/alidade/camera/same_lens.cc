// SPDX-License-Identifier: MIT
#include "alidade/camera/same_lens.h"

#include <algorithm>

#include "alidade/camera/model_traits.h"

namespace alidade {

std::vector<double> parametersByName(std::string_view from_id, std::span<const double> params,
                                     std::string_view model_id) {
  const auto own = parameterNames(from_id);
  std::vector<double> named;
  for (const std::string_view name : parameterNames(model_id)) {
    const auto i = parameterIndex(own, name);
    named.push_back(i ? params[*i] : 0.0);
  }
  return named;
}

namespace {

struct Lens {
  const ModelTraits* model;
  std::vector<double> params;  // in storage order
};

// The lens in another model by the names of the parameters; nothing if a parameter that the other model lacks
// is not zero.
std::optional<Lens> byName(const Lens& lens, const ModelTraits& other) {
  for (std::size_t i = 0; i < lens.params.size(); ++i) {
    if (lens.params[i] != 0 && !parameterIndex(other.parameter_names, lens.model->parameter_names[i]))
      return std::nullopt;
  }
  return Lens{.model = &other, .params = parametersByName(lens.model->id, lens.params, other.id)};
}

std::optional<Lens> converted(const Lens& lens, const ModelTraits& other, SharedLens::Conversion convert) {
  Lens result{.model = &other, .params = std::vector<double>(other.parameter_names.size())};
  const double factor = convert(lens.params.data() + kNumAffine, result.params.data() + kNumAffine);
  if (factor == 0) return std::nullopt;
  std::copy_n(lens.params.begin(), kNumAffine, result.params.begin());
  for (std::size_t i = 0; i < 2; ++i) result.params[i] *= factor;
  return result;
}

// The lens in all models that are one step away.
std::vector<Lens> neighbours(const Lens& lens) {
  std::vector<Lens> found;
  const auto add = [&](const SharedLens& shared, std::string_view other, SharedLens::Conversion convert) {
    if (!shared.isExtension() && convert == nullptr) return;
    const ModelTraits& model = modelTraits(other);
    auto next = shared.isExtension() ? byName(lens, model) : converted(lens, model, convert);
    if (next) found.push_back(*std::move(next));
  };
  for (const ModelTraits& model : allModelTraits()) {
    for (const SharedLens& shared : model.shared_lenses) {
      if (lens.model->id == model.id) add(shared, shared.model, shared.to);
      if (lens.model->id == shared.model) add(shared, model.id, shared.from);
    }
  }
  return found;
}

}  // namespace

std::optional<std::vector<double>> sameLensParameters(const AnyCamera& camera, std::string_view model_id) {
  const ModelTraits& target = modelTraits(model_id);
  // Grows at its end, so the search is breadth first and finds the shortest chain.
  std::vector<Lens> lenses = {{.model = &modelTraits(camera.modelId()),
                               .params = {camera.parameters().begin(), camera.parameters().end()}}};
  for (std::size_t i = 0; i < lenses.size(); ++i) {
    if (lenses[i].model == &target) return lenses[i].params;
    for (Lens& next : neighbours(lenses[i])) {
      if (std::ranges::find(lenses, next.model, &Lens::model) == lenses.end())
        lenses.push_back(std::move(next));
    }
  }
  return std::nullopt;
}

std::vector<double> closestByName(const AnyCamera& like, std::string_view model_id) {
  if (auto same = sameLensParameters(like, model_id)) return *std::move(same);
  return parametersByName(like.modelId(), like.parameters(), model_id);
}

}  // namespace alidade
