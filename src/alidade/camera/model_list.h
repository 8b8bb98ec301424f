// SPDX-License-Identifier: MIT
#pragma once

#include <string_view>
#include <variant>

#include "alidade/camera/camera_model.h"
#include "alidade/camera/double_sphere.h"
#include "alidade/camera/eucm.h"
#include "alidade/camera/fov.h"
#include "alidade/camera/kannala_brandt.h"
#include "alidade/camera/omni.h"
#include "alidade/camera/pinhole.h"
#include "alidade/camera/radtan.h"
#include "alidade/camera/rational.h"
#include "alidade/camera/thin_prism.h"
#include "alidade/camera/ucm.h"

namespace alidade {

template <CameraModel... Models>
struct ModelList {
  /// One of Of<Model> for each model.
  template <template <class> class Of>
  using Variant = std::variant<Of<Models>...>;
};

/// THE list of camera models. The variant, the names in files and on the command line, the cost functions and
/// the tests all come from it: a new model needs one header, its include above and its name here.
using AllModels =
    ModelList<Pinhole, Radtan, Rational, ThinPrism, KannalaBrandt, Fov, Ucm, Omni, Eucm, DoubleSphere>;

/// Models that extend the one before them by parameters; with these at zero the lenses are identical.
using NestedModels = ModelList<Pinhole, Radtan, Rational, ThinPrism>;

/// Represents a model where only its type is needed.
template <CameraModel M>
struct ModelTag {
  using Model = M;
};

/// Calls f(ModelTag<M>{}) for each model of the list.
template <class F, CameraModel... Models>
void forEachModel(ModelList<Models...>, F&& f) {
  (f(ModelTag<Models>{}), ...);
}

/// Calls f(ModelTag<M>{}) for the model called `id`. @returns whether there is one
template <class F>
bool withModel(std::string_view id, F&& f) {
  bool is_known = false;
  forEachModel(AllModels{}, [&](auto tag) {
    if (decltype(tag)::Model::kId != id) return;
    is_known = true;
    f(tag);
  });
  return is_known;
}

}  // namespace alidade
