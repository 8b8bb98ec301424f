// SPDX-License-Identifier: MIT
#pragma once

#include <cstddef>
#include <utility>
#include <variant>

#include "alidade/camera/camera_model.h"
#include "alidade/camera/pinhole.h"
#include "alidade/camera/radtan.h"

namespace alidade {

template <CameraModel... Models>
struct ModelList {
  static constexpr std::size_t kSize = sizeof...(Models);
};

/// THE list of camera models. The variant, the names in files and on the command line, the cost functions and
/// the tests all come from it: adding a model is one header, its include above and its name here.
using AllModels = ModelList<Pinhole, Radtan>;

/// Stands for a model where only its type is wanted.
template <CameraModel M>
struct ModelTag {
  using Model = M;
};

/// Calls f(ModelTag<M>{}) for each model of the list.
template <class F, CameraModel... Models>
void forEachModel(ModelList<Models...>, F&& f) {
  (f(ModelTag<Models>{}), ...);
}

}  // namespace alidade
