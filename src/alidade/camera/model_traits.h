// SPDX-License-Identifier: MIT
#pragma once

#include <span>
#include <string_view>
#include <vector>

#include "alidade/camera/camera_model.h"
#include "alidade/core/aliases.h"

namespace alidade {

/// Statements of a model's header, for code that does not know its type; see CameraModel.
struct ModelTraits {
  std::string_view id;
  std::span<const std::string_view> parameter_names;  ///< of all parameters, in storage order
  std::span<const ParamRange> lens_ranges;
  std::span<const double> start_lens;
  LensFamily family;
  bool is_stiff;
  bool is_polynomial;
  std::string_view flexible_id;
  std::span<const LensVector> vectors;
  std::span<const SharedLens> shared_lenses;
  std::string_view aliases;
  std::string_view redundant;
  bool is_candidate;
  bool (*can_turn)(const double* lens);
  /// projectFormulaJacobian() of the model.
  bool (*project)(const double* params, const double* ray, double* px, double* J_px_ray, double* J_px_params);

  /// True if this model is `model` with more parameters, directly or through other models.
  [[nodiscard]] bool extends(std::string_view model) const;
};

/// One for each model, in the order of the model list.
[[nodiscard]] std::span<const ModelTraits> allModelTraits();

/// The ids of all models with their names in other programs.
[[nodiscard]] std::vector<AliasedName> aliasedModels();

/// @throws Error (kUsage) for an unknown id, naming the known ones
[[nodiscard]] const ModelTraits& modelTraits(std::string_view id);

/// The model that follows every lens of a family at least roughly. Searches in the family begin with it.
[[nodiscard]] const ModelTraits& leadTraits(LensFamily family);

/// The perspective model that comes next after `model` in size and extends it, or null. Wide models bend the
/// image by different shapes rather than by more terms.
[[nodiscard]] const ModelTraits* nextLargerModel(std::string_view model);

}  // namespace alidade
