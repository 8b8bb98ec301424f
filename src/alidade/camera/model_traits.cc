// SPDX-License-Identifier: MIT
#include "alidade/camera/model_traits.h"

#include <algorithm>
#include <array>
#include <string>
#include <vector>

#include "alidade/camera/model_list.h"
#include "alidade/camera/projection.h"
#include "alidade/core/error.h"
#include "alidade/core/mapped.h"
#include "alidade/core/text.h"

namespace alidade {
namespace {

template <class... Models>
constexpr std::array<ModelTraits, sizeof...(Models)> traitsOf(ModelList<Models...>) {
  return {ModelTraits{.id = Models::kId,
                      .parameter_names = kParamNames<Models>,
                      .lens_ranges = Models::kLensRanges,
                      .start_lens = Models::kStartLens,
                      .family = Models::kFamily,
                      .is_stiff = Models::kIsStiff,
                      .is_polynomial = Models::kIsPolynomial,
                      .flexible_id = Models::kFlexibleId,
                      .vectors = Models::kVectors,
                      .shared_lenses = Models::kSharedLenses,
                      .aliases = Models::kAliases,
                      .redundant = Models::kRedundant,
                      .is_candidate = Models::kIsCandidate,
                      .can_turn = &Models::canTurn,
                      .project = &projectFormulaJacobian<Models>}...};
}

constexpr auto kTraits = traitsOf(AllModels());

constexpr bool isKnown(std::string_view id) {
  return std::ranges::find(kTraits, id, &ModelTraits::id) != kTraits.end();
}
static_assert(std::ranges::all_of(kTraits,
                                  [](const ModelTraits& model) {
                                    return (model.flexible_id.empty() || isKnown(model.flexible_id)) &&
                                           std::ranges::all_of(model.shared_lenses, isKnown,
                                                               &SharedLens::model);
                                  }),
              "models name others by their ids");

}  // namespace

std::span<const ModelTraits> allModelTraits() {
  return kTraits;
}

std::vector<AliasedName> aliasedModels() {
  return mapped(kTraits, [](const ModelTraits& model) {
    return AliasedName{std::string(model.id), model.aliases};
  });
}

const ModelTraits& modelTraits(std::string_view id) {
  const auto found = std::ranges::find(kTraits, id, &ModelTraits::id);
  if (found != kTraits.end()) return *found;
  const std::vector<AliasedName> models = aliasedModels();
  throw usageError({.where = "camera model",
                    .found = "'" + std::string(id) + "'",
                    .expected = "one of " + join(mapped(models, &AliasedName::name), ", "),
                    .next_step = didYouMeanOne(id, models)});
}

const ModelTraits& leadTraits(LensFamily family) {
  return modelTraits(family == LensFamily::kPerspective ? Radtan::kId : KannalaBrandt::kId);
}

bool ModelTraits::extends(std::string_view model) const {
  return std::ranges::any_of(shared_lenses, [model](const SharedLens& shared) {
    return shared.has_all && (shared.model == model || modelTraits(shared.model).extends(model));
  });
}

const ModelTraits* nextLargerModel(std::string_view model) {
  const auto found = std::ranges::find_if(kTraits, [model](const ModelTraits& larger) {
    return larger.family == LensFamily::kPerspective && larger.is_candidate && larger.extends(model);
  });
  return found == kTraits.end() ? nullptr : &*found;
}

}  // namespace alidade
