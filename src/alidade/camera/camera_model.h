// SPDX-License-Identifier: MIT
#pragma once

#include <algorithm>
#include <array>
#include <concepts>
#include <cstddef>
#include <limits>
#include <span>
#include <string_view>

namespace alidade {

/// The inclusive range of a lens parameter.
struct ParamRange {
  double min = -std::numeric_limits<double>::infinity();
  double max = std::numeric_limits<double>::infinity();
};

/// Families of lenses, by the geometry that their formula starts from.
enum class LensFamily {
  kPerspective,  ///< from the plane x = X/Z, y = Y/Z, which ends before 90 degrees
  kWide,         ///< from the field angle or a sphere: fisheye lenses and mirrors
};

/// Largest number of parameters, including fx fy cx cy, that code without the model's type has room for.
inline constexpr int kMostParams = 32;

/// Two lens parameters, by index, that are the components of a vector in the normalised plane. They rotate
/// with the image: after a quarter turn, x is -y and y is `sign` x.
struct LensVector {
  std::size_t x, y;
  double sign = 1;  ///< -1: a pair of shears instead
};

/// A model that shares some lenses with a second model. Without functions, this model extends `model`: it has
/// the same parameters by the same names, and its additional ones are 0 in the shared lenses.
struct SharedLens {
  /// Converts the lens parameters of one model to those of the other and returns the factor by which fx and
  /// fy change; 0 if the lens is not shared.
  using Conversion = double (*)(const double* from, double* to);

  std::string_view model;
  Conversion to = nullptr;                          ///< the lens of `model` from this model's
  Conversion from = nullptr;                        ///< and back
  bool has_all = to == nullptr && from == nullptr;  ///< this model has all lenses of `model`

  [[nodiscard]] constexpr bool isExtension() const { return to == nullptr && from == nullptr; }
};

/// Requirements of a camera model. A model is a stateless struct that describes the *lens*: the map from a
/// ray in the camera frame (any length > 0, any direction) to the normalised plane, m = lens(ray). The affine
/// step to pixels, u = fx mx + cx and v = fy my + cy, is the same for all models and is written once
/// (projection.h).
///
///   kId              the name in files and on the command line
///   kNumLensParams   number of parameters after fx fy cx cy
///   kLensParamNames  their names, in storage order
///   kLensRanges      the values that each may take; the lens has no value outside
///   kStartLens       initial values for a calibration: a perspective without distortion, or a typical wide
///                    lens
///   kMaxAngle        largest angle from the optical axis at which the formula makes sense, radians; models
///                    that stop at or before 90 degrees report points behind the camera as kBehind
///   kIsOneToOneWithoutFold  true if a lens that folds nowhere in a cone about the axis is one-to-one there
///                    for a reason in the model's comment; false: the rim of the cone is checked too
///   maxAngle(k)      the first pole or fold of the lens with these parameters, if it has a closed form;
///                    otherwise kMaxAngle
///   kEndMargin       distance of the domain from a fold, radians: at a fold, the inverse loses all digits;
///   by
///                    default so far that it keeps 1e-9 rad
///   isAxiallySymmetric(k)  true if the lens treats all azimuths alike
///   hasValue(k, ray)  false if the formula has no value; always true in the cone of certifyCone()
///   formula(k, ray, m, J_m_ray, J_m_lens)  the map itself if it has a value, with row-major 2x3 and 2xN
///                    Jacobians (null: not computed); for double, Lanes and automatic differentiation, so
///                    without a branch on the ray
///   quickUnlens(k, start, m, max_angle, ray)  the inverse, for double and Lanes: the unit ray inside the
///   cone
///                    of half-angle max_angle, in which the lens is one-to-one; without safeguards: NaN or a
///                    ray outside the cone if there is none, or if more iterations would be needed
///   unlens(k, m, max_angle, ray)  the same for the points where that gives no ray, with safeguards: the ray
///                    inside the cone or a nanoradian beyond; false without one
///   Start, makeStart(k, max_angle)  precomputed values for quickUnlens()
///
/// and properties of the model, which have no defaults:
///
///   kFamily          perspective or wide. Searches begin with the lead of the family (leadTraits())
///   kIsStiff         true if one or two numbers describe the whole lens. The real lens may then deviate
///                    even where boards were seen, by too little to show in the errors
///   kIsPolynomial    true if parameters of 0 mean no distortion, and multiples of all parameters are
///                    multiples of the same distortion
///   kFlexibleId      a more flexible model of the same kind of lens; empty if there is none
///   kVectors         the parameters that rotate with the image; if they are 0, isAxiallySymmetric()
///   kSharedLenses    the models with which it shares lenses; one model of each pair lists the other
///   canTurn(k)       false if the model has no such lens turned by 90 degrees; by default it has
///   kRedundant       name of a parameter that a rotation about the axis can stand in for, which a
///   calibration
///                    holds; by default there is none
///   kIsCandidate     false: the automatic choice leaves the model out; by default it considers it
///   kAliases         names of the model in other programs, separated by blanks; by default there are none
///
/// LensFormula makes lens() from hasValue() and formula(), and holds the common part of most models.
template <class M>
concept CameraModel = requires(const double* in, double* out, double angle) {
  { M::kId } -> std::convertible_to<std::string_view>;
  { M::kMaxAngle } -> std::convertible_to<double>;
  { M::kIsOneToOneWithoutFold } -> std::convertible_to<bool>;
  requires 4 + M::kNumLensParams <= kMostParams;
  requires M::kLensParamNames.size() == M::kNumLensParams;
  requires M::kLensRanges.size() == M::kNumLensParams;
  requires M::kStartLens.size() == M::kNumLensParams;
  { M::kEndMargin } -> std::convertible_to<double>;
  { M::maxAngle(in) } -> std::same_as<double>;
  { M::isAxiallySymmetric(in) } -> std::same_as<bool>;
  { M::hasValue(in, in) } -> std::same_as<bool>;
  { M::formula(in, in, out, out, out) } -> std::same_as<void>;
  { M::unlens(in, in, angle, out) } -> std::same_as<bool>;
  { M::kFamily } -> std::convertible_to<LensFamily>;
  { M::kIsStiff } -> std::convertible_to<bool>;
  { M::kIsPolynomial } -> std::convertible_to<bool>;
  { M::kFlexibleId } -> std::convertible_to<std::string_view>;
  { M::kVectors } -> std::convertible_to<std::span<const LensVector>>;
  { M::kSharedLenses } -> std::convertible_to<std::span<const SharedLens>>;
  { M::canTurn(in) } -> std::same_as<bool>;
  { M::kRedundant } -> std::convertible_to<std::string_view>;
  { M::kIsCandidate } -> std::convertible_to<bool>;
  { M::kAliases } -> std::convertible_to<std::string_view>;
};

/// The map of one ray, derived from the formula of a model, for double and for automatic differentiation; and
/// the defaults for a lens with `kNum` parameters: symmetric without its vectors, with parameters of any size
/// that start at zero, and with an inverse in closed form.
template <class M, std::size_t kNum>
struct LensFormula {
  static constexpr int kNumLensParams = kNum;
  static constexpr std::array<ParamRange, kNum> kLensRanges = {};
  static constexpr std::array<double, kNum> kStartLens = {};
  static constexpr bool kIsOneToOneWithoutFold = true;
  static constexpr std::string_view kAliases = "";
  static constexpr std::string_view kRedundant = "";
  static constexpr bool kIsCandidate = true;
  static bool canTurn(const double*) { return true; }
  static constexpr double kEndMargin = 1e-5;
  static double maxAngle(const double*) { return M::kMaxAngle; }
  static bool isAxiallySymmetric(const double* k) {
    return std::ranges::all_of(M::kVectors,
                               [k](const LensVector& v) { return k[v.x] == 0.0 && k[v.y] == 0.0; });
  }

  /// m of a ray (any length), and the Jacobian by the ray, null: not computed; false if the formula has no
  /// value.
  template <class T>
  static bool lens(const T* k, const T* ray, T* m, T* J_m_ray = nullptr) {
    if (!M::hasValue(k, ray)) return false;
    T* const not_wanted = nullptr;
    M::formula(k, ray, m, J_m_ray, not_wanted);
    return true;
  }

  /// An inverse in closed form needs no safeguards.
  static bool unlens(const double* k, const double* m, double max_angle, double* ray) {
    M::quickUnlens(k, Start(), m, max_angle, ray);
    return M::hasValue(k, ray);
  }
  struct Start {};
  static Start makeStart(const double*, double) { return {}; }
};

/// Parameters of the affine step, which every model stores first.
inline constexpr std::array<std::string_view, 4> kAffineParamNames = {"fx", "fy", "cx", "cy"};
inline constexpr std::size_t kNumAffine = kAffineParamNames.size();

template <CameraModel M>
inline constexpr int kNumParams = 4 + M::kNumLensParams;

/// Names of all parameters in storage order: fx fy cx cy, then the lens.
template <CameraModel M>
inline constexpr auto kParamNames = [] {
  std::array<std::string_view, static_cast<std::size_t>(kNumParams<M>)> names{};
  std::size_t i = 0;
  for (const std::string_view name : kAffineParamNames) names[i++] = name;
  for (const std::string_view name : M::kLensParamNames) names[i++] = name;
  return names;
}();

}  // namespace alidade
