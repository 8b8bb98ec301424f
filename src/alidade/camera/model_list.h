// SPDX-License-Identifier: MIT
#pragma once

#include <variant>

#include "alidade/camera/brown.h"
#include "alidade/camera/camera_model.h"
#include "alidade/camera/division.h"
#include "alidade/camera/double_sphere.h"
#include "alidade/camera/eucm.h"
#include "alidade/camera/fisheye624.h"
#include "alidade/camera/fov.h"
#include "alidade/camera/ftheta.h"
#include "alidade/camera/ftheta_inverse.h"
#include "alidade/camera/inverse_brown.h"
#include "alidade/camera/kannala_brandt.h"
#include "alidade/camera/kannala_brandt_skew.h"
#include "alidade/camera/ocam.h"
#include "alidade/camera/omni.h"
#include "alidade/camera/pinhole.h"
#include "alidade/camera/radtan.h"
#include "alidade/camera/rational.h"
#include "alidade/camera/thin_prism.h"
#include "alidade/camera/thin_prism_fisheye.h"
#include "alidade/camera/tilted.h"
#include "alidade/camera/ucm.h"

namespace alidade {

namespace detail {
/// Makes the compiler name the requirement that a model lacks.
template <class M>
struct CompleteModel {
  static_assert(CameraModel<M>, "this camera model lacks a member that CameraModel requires");
};
}  // namespace detail

template <class... Models>
struct ModelList : detail::CompleteModel<Models>... {
  /// The list of Of<Model> for all models.
  template <template <class> class Of>
  using Variant = std::variant<Of<Models>...>;

  /// Calls f.operator()<M>() for each model.
  template <class F>
  static void forEach(F&& f) {
    (f.template operator()<Models>(), ...);
  }
};

/// THE list of camera models. The variant, the names in files and on the command line, the cost functions,
/// the candidates of the automatic choice and the tests all come from it: a new model needs one header, its
/// include above and its name here.
using AllModels = ModelList<Pinhole, Radtan, Brown, InverseBrown, Rational, ThinPrism, Tilted, Division,
                            KannalaBrandt, KannalaBrandtSkew, ThinPrismFisheye, Fisheye624, FTheta,
                            FThetaInverse, Ocam, Fov, Ucm, Omni, Eucm, DoubleSphere>;

}  // namespace alidade
