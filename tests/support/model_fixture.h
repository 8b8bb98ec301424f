// SPDX-License-Identifier: MIT
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <string>
#include <type_traits>
#include <vector>

#include <gtest/gtest.h>

#include "alidade/camera/camera.h"
#include "alidade/camera/model_list.h"
#include "alidade/core/random.h"
#include "support/rays.h"

namespace alidade {

/// Parameters to test a model with. A model without a specialisation does not compile into the typed suites:
/// adding a model means adding its sets here, and a generator of random ones.
template <CameraModel M>
struct ModelFixture;

/// True for models that state the ray of a pixel: where the ray turns back, their image moves infinitely
/// fast.
template <CameraModel M>
inline constexpr bool kIsStatedInverse = M::kEndMargin < 1e-6 || std::is_same_v<M, InverseBrown>;

template <>
struct ModelFixture<Pinhole> {
  static std::vector<Camera<Pinhole>::Params> paramSets() {
    return {{1003.1, 1001.7, 961.3, 597.2}, {320, 330, 955, 600}, {9000, 9010, 900, 650}};
  }
  static Camera<Pinhole>::Params randomParams(Random& random) {
    return {random.uniform(300, 3000), random.uniform(300, 3000), 955, 605};
  }
};

template <>
struct ModelFixture<Radtan> {
  static std::vector<Camera<Radtan>::Params> paramSets() {
    return {
        {1003.1, 1001.7, 961.3, 597.2, -0.28, 0.08, 5e-4, -4e-4, -0.01},  // an ordinary lens, with a fold
        {1003.1, 1001.7, 961.3, 597.2, 0, 0, 0, 0, 0},                    // no distortion at all
        {1400, 1398, 950, 610, -0.4, 0.1, 0, 0, 0},             // strong barrel that just does not fold
        {1200, 1190, 940, 580, 0.12, 0.05, 1e-3, 2e-3, 0.02},   // pincushion: no fold
        {700, 705, 955, 605, -0.2, 0.02, -3e-3, 4e-3, -0.001},  // tangential terms of a cheap lens
        {5000, 5010, 970, 590, -0.3, 40, 1e-3, -1e-3, -900},    // a tele lens with large coefficients
    };
  }
  static Camera<Radtan>::Params randomParams(Random& random) {
    return {random.uniform(300, 3000),
            random.uniform(300, 3000),
            955,
            605,
            random.uniform(-0.5, 0.5),
            random.uniform(-0.3, 0.3),
            random.uniform(-0.01, 0.01),
            random.uniform(-0.01, 0.01),
            random.uniform(-0.2, 0.2)};
  }
};

template <>
struct ModelFixture<InverseBrown> {
  static std::vector<Camera<InverseBrown>::Params> paramSets() {
    return {
        {1380.3, 1379.8, 958.2, 548.4, 0.153, -0.541, -3e-4, 1.1e-3, 0.484},  // a depth camera
        {1003.1, 1001.7, 961.3, 597.2, 0, 0, 0, 0, 0},                        // no distortion at all
        {1000, 1010, 960, 600, -0.1, 0.05, 2e-3, -1e-3, 0.02},                // towards and from the axis
        {900, 900, 955, 605, 0.3, 0.1, 4e-3, 3e-3, 0.05},                     // strong
        {1000, 1000, 960, 600, -0.3, 0, 2e-3, -1e-3, 0},                      // a fold
    };
  }
  static Camera<InverseBrown>::Params randomParams(Random& random) {
    return ModelFixture<Radtan>::randomParams(random);
  }
};

template <>
struct ModelFixture<Division> {
  static std::vector<Camera<Division>::Params> paramSets() {
    return {
        {900, 901, 960, 600, -0.3, 0},     // a wide lens, beyond 90 degrees
        {1003, 1001, 961, 597, 0, 0},      // a perspective
        {1000, 1000, 960, 600, 0.15, 0},   // a fold
        {700, 702, 955, 605, -0.4, 0.05},  // a fold after strong distortion
        {800, 800, 960, 600, 0.05, -0.1},
    };
  }
  static Camera<Division>::Params randomParams(Random& random) {
    return {random.uniform(300, 3000), random.uniform(300, 3000),  955, 605,
            random.uniform(-0.6, 0.4), random.uniform(-0.15, 0.15)};
  }
};

template <>
struct ModelFixture<Rational> {
  static std::vector<Camera<Rational>::Params> paramSets() {
    return {
        {1003.1, 1001.7, 961.3, 597.2, 0.35, 0.05, 5e-4, -4e-4, 0.01, 0.68, 0.12, 0.005},  // a wide lens
        {1003.1, 1001.7, 961.3, 597.2, 0, 0, 0, 0, 0, 0, 0, 0},                            // no distortion
        {1000, 1000, 960, 600, -0.9, 0, 0, 0, 0, -1.0, 0, 0},         // a pole at 45 degrees, inside the view
        {1000, 1010, 950, 610, -1.1, 0, 1e-4, 2e-4, 0, -1.0, 0, 0},   // the same pole with a fold before it
        {1000, 1000, 960, 600, -2.5 - 1e-7, 0, 0, 0, 0, -2.5, 0, 0},  // a pole that nearly cancels
        {800, 801, 955, 605, -0.28, 0.08, 1e-3, -2e-3, -0.01, 0.02, 0.01, -0.03},  // a fold, a pole beyond
        {600, 602, 955, 605, 18.2, 12.5, -2e-4, 3e-4, 0.9, 18.5, 17.6, 3.3},       // coefficients run away
    };
  }
  static Camera<Rational>::Params randomParams(Random& random) {
    return {random.uniform(300, 3000),
            random.uniform(300, 3000),
            955,
            605,
            random.uniform(-2, 2),
            random.uniform(-1, 1),
            random.uniform(-0.01, 0.01),
            random.uniform(-0.01, 0.01),
            random.uniform(-0.3, 0.3),
            random.uniform(-2, 2),
            random.uniform(-1, 1),
            random.uniform(-0.3, 0.3)};
  }
};

template <>
struct ModelFixture<ThinPrism> {
  static std::vector<Camera<ThinPrism>::Params> paramSets() {
    return {
        {1003.1, 1001.7, 961.3, 597.2, 0.35, 0.05, 5e-4, -4e-4, 0.01, 0.68, 0.12, 0.005, 1e-3, -2e-4, -8e-4,
         3e-4},
        {1003.1, 1001.7, 961.3, 597.2, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0},  // no distortion at all
        {1100, 1100, 950, 610, -0.3, 0.05, 1e-3, 1e-3, 0, 0, 0, 0, 5e-3, 1e-3, -4e-3, 2e-3},  // a fold
        {1000, 1000, 960, 600, 0, 0, 0, 0, 0, 0, 0, 0, 0.15, 0.02, -0.2, 0.03},  // a prism and nothing else
        {1000, 1000, 960, 600, -0.9, 0, 1e-3, 0, 0, -1.0, 0, 0, 2e-3, 0, 1e-3, 0},  // a pole
    };
  }
  static Camera<ThinPrism>::Params randomParams(Random& random) {
    return {random.uniform(300, 3000),
            random.uniform(300, 3000),
            955,
            605,
            random.uniform(-2, 2),
            random.uniform(-1, 1),
            random.uniform(-0.01, 0.01),
            random.uniform(-0.01, 0.01),
            random.uniform(-0.3, 0.3),
            random.uniform(-2, 2),
            random.uniform(-1, 1),
            random.uniform(-0.3, 0.3),
            random.uniform(-0.05, 0.05),
            random.uniform(-0.02, 0.02),
            random.uniform(-0.05, 0.05),
            random.uniform(-0.02, 0.02)};
  }
};

template <>
struct ModelFixture<Brown> {
  static std::vector<Camera<Brown>::Params> paramSets() {
    return {
        {3650.2, 3652.8, 961.3, 597.2, -0.057, 0.11, 4e-4, -3e-4, -0.09, 0.02, -1.1e-4},  // a drone
        {1003.1, 1001.7, 961.3, 597.2, 0, 0, 0, 0, 0, 0, 0},                              // no distortion
        {1003.1, 1001.7, 961.3, 597.2, -0.28, 0.08, 5e-4, -4e-4, -0.01, 0, 0},            // radtan, a fold
        {1200, 1190, 940, 580, 0.12, 0.05, 1e-3, 2e-3, 0.02, 0.01, 0.05},                 // strong skew
        {900, 905, 955, 605, -0.3, 0.2, 1e-3, 1e-3, -0.15, 0.05, -0.02},                  // four radial terms
    };
  }
  static Camera<Brown>::Params randomParams(Random& random) {
    return {random.uniform(300, 3000),
            random.uniform(300, 3000),
            955,
            605,
            random.uniform(-0.5, 0.5),
            random.uniform(-0.3, 0.3),
            random.uniform(-0.01, 0.01),
            random.uniform(-0.01, 0.01),
            random.uniform(-0.2, 0.2),
            random.uniform(-0.1, 0.1),
            random.uniform(-0.1, 0.1)};
  }
};

template <>
struct ModelFixture<Tilted> {
  static std::vector<Camera<Tilted>::Params> paramSets() {
    return {
        {1003.1, 1001.7, 961.3, 597.2, 0.35, 0.05, 5e-4, -4e-4, 0.01, 0.68, 0.12, 0.005, 1e-3, -2e-4, -8e-4,
         3e-4, -0.025, -0.006},
        {1003.1, 1001.7, 961.3, 597.2, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0},  // no distortion at all
        {1100, 1100, 950, 610, -0.3, 0.05, 1e-3, 1e-3, 0, 0, 0, 0, 5e-3, 1e-3, -4e-3, 2e-3, 0.1,
         0},                                                                     // a fold
        {1000, 1000, 960, 600, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, -0.15, 0.3},  // a tilt and nothing else
        {1000, 1000, 960, 600, 0.2, 0, 1e-3, 0, 0, -0.3, 0, 0, 2e-3, 0, 1e-3, 0, 0, 0.2},  // two poles
    };
  }
  static Camera<Tilted>::Params randomParams(Random& random) {
    Camera<Tilted>::Params params{};
    const auto prism = ModelFixture<ThinPrism>::randomParams(random);
    std::copy(prism.begin(), prism.end(), params.begin());
    params[16] = random.uniform(-0.3, 0.3);
    params[17] = random.uniform(-0.3, 0.3);
    return params;
  }
};

template <>
struct ModelFixture<KannalaBrandt> {
  static std::vector<Camera<KannalaBrandt>::Params> paramSets() {
    return {
        {560.3, 559.8, 961.2, 598.4, -0.012, 0.004, -0.003, 0.0006},       // an ordinary fisheye
        {400, 401, 955, 605, 0, 0, 0, 0},                                  // equidistant up to straight back
        {700, 698, 960, 600, -0.05, -0.01, 0.002, -0.0005},                // a fold beyond 90 degrees
        {1000, 1000, 960, 600, -0.3, 0.02, 0, 0},                          // a fold inside the image
        {900, 905, 950, 590, 1.0 / 3, 2.0 / 15, 17.0 / 315, 62.0 / 2835},  // nearly a perspective
    };
  }
  static Camera<KannalaBrandt>::Params randomParams(Random& random) {
    return {random.uniform(200, 1500),
            random.uniform(200, 1500),
            955,
            605,
            random.uniform(-0.3, 0.3),
            random.uniform(-0.1, 0.1),
            random.uniform(-0.03, 0.03),
            random.uniform(-0.01, 0.01)};
  }
};

template <>
struct ModelFixture<KannalaBrandtSkew> {
  static std::vector<Camera<KannalaBrandtSkew>::Params> paramSets() {
    return {
        {560.3, 559.8, 961.2, 598.4, -0.012, 0.004, -0.003, 0.0006, 0.0011},  // an ordinary fisheye
        {400, 401, 955, 605, 0, 0, 0, 0, 0},                                  // equidistant
        {1000, 1000, 960, 600, -0.3, 0.02, 0, 0, -0.1},                       // a fold inside the image
    };
  }
  static Camera<KannalaBrandtSkew>::Params randomParams(Random& random) {
    const auto p = ModelFixture<KannalaBrandt>::randomParams(random);
    return {p[0], p[1], p[2], p[3], p[4], p[5], p[6], p[7], random.uniform(-0.2, 0.2)};
  }
};

template <>
struct ModelFixture<ThinPrismFisheye> {
  static std::vector<Camera<ThinPrismFisheye>::Params> paramSets() {
    return {
        {560.3, 559.8, 961.2, 598.4, -0.012, 0.004, -0.003, 0.0006, 4e-4, -3e-4, 5e-4, -8e-4},  // ordinary
        {400, 401, 955, 605, 0, 0, 0, 0, 0, 0, 0, 0},                                           // equidistant
        {700, 698, 960, 600, -0.05, -0.01, 0.002, -0.0005, 3e-3, 2e-3, -1e-3, 4e-3},  // a fold beyond 90
        {1000, 1000, 960, 600, -0.3, 0.02, 0, 0, -2e-3, 1e-3, 5e-3, 2e-3},  // a fold inside the image
        {500, 500, 960, 600, 0, 0, 0, 0, 0, 0, 0.02, -0.015},               // a prism and nothing else
    };
  }
  static Camera<ThinPrismFisheye>::Params randomParams(Random& random) {
    const auto p = ModelFixture<KannalaBrandt>::randomParams(random);
    return {p[0],
            p[1],
            p[2],
            p[3],
            p[4],
            p[5],
            p[6],
            p[7],
            random.uniform(-0.01, 0.01),
            random.uniform(-0.01, 0.01),
            random.uniform(-0.03, 0.03),
            random.uniform(-0.03, 0.03)};
  }
};

template <>
struct ModelFixture<Fisheye624> {
  static std::vector<Camera<Fisheye624>::Params> paramSets() {
    return {
        {610.1, 609.7, 958.9, 597.6, 0.41, -0.49, 0.17, 1.13, -1.70, 0.65, 4e-4, 1e-5, 5e-4, -3e-4, 1e-3,
         -2e-4},                                                   // glasses
        {400, 401, 955, 605, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0},  // equidistant
        {700, 698, 960, 600, -0.05, -0.01, 0.002, -0.0005, 0, 0, 3e-3, 2e-3, -1e-3, 1e-3, 4e-3, -1e-3},
        {1000, 1000, 960, 600, -0.3, 0.02, 0, 0, 0.001, -0.001, 2e-3, 1e-3, 0, 0, 0,
         0},  // a fold in the image
    };
  }
  static Camera<Fisheye624>::Params randomParams(Random& random) {
    const auto p = ModelFixture<ThinPrismFisheye>::randomParams(random);
    return {p[0],
            p[1],
            p[2],
            p[3],
            p[4],
            p[5],
            p[6],
            p[7],
            random.uniform(-0.003, 0.003),
            random.uniform(-0.001, 0.001),
            p[8],
            p[9],
            p[10],
            random.uniform(-0.01, 0.01),
            p[11],
            random.uniform(-0.01, 0.01)};
  }
};

template <>
struct ModelFixture<FTheta> {
  static std::vector<Camera<FTheta>::Params> paramSets() {
    return {
        {340.749, 340.749, 962.2, 598.4, -0.0934, 0.1409, -0.0208, 0, 0},  // a car's camera of 190 degrees
        {400, 401, 955, 605, 0, 0, 0, 0, 0},                               // equidistant
        {930, 928, 960, 600, 0.01, -0.12, 0.02, -0.05, 0.006},             // a fold
        {700, 700, 960, 600, -0.3, 0.05, 0, 0, 0},  // the square of the angle dominates
    };
  }
  static Camera<FTheta>::Params randomParams(Random& random) {
    return {random.uniform(200, 1500),
            random.uniform(200, 1500),
            955,
            605,
            random.uniform(-0.2, 0.2),
            random.uniform(-0.2, 0.2),
            random.uniform(-0.05, 0.05),
            random.uniform(-0.02, 0.02),
            random.uniform(-0.005, 0.005)};
  }
};

template <>
struct ModelFixture<FThetaInverse> {
  static std::vector<Camera<FThetaInverse>::Params> paramSets() {
    return {
        {930.1, 929.8, 961.2, 598.4, 0.003, 0.021, -0.004, 0.008, -0.002},  // a car's camera of 120 degrees
        {400, 401, 955, 605, 0, 0, 0, 0, 0},                                // equidistant
        {500, 502, 960, 600, -0.1, -0.05, 0, 0, 0},                         // the angle turns back
        {450, 450, 960, 600, 0.2, 0.1, 0.05, 0, 0},                         // the radius nearly stops
    };
  }
  static Camera<FThetaInverse>::Params randomParams(Random& random) {
    return ModelFixture<FTheta>::randomParams(random);
  }
};

template <>
struct ModelFixture<Ocam> {
  static std::vector<Camera<Ocam>::Params> paramSets() {
    return {
        {430.2, 430.9, 961.2, 598.4, -0.251, 0.049, -0.027, 0, 0, 1e-4, -3e-4},  // an ordinary fisheye
        {1003.1, 1001.7, 961.3, 597.2, 0, 0, 0, 0, 0, 0, 0},                     // a perspective
        {500, 500, 960, 600, -1.0 / 3, 0, -1.0 / 45, 0, 0, 0, 0},                // nearly equidistant
        {600, 602, 950, 610, -0.2, -0.05, 0.02, -0.01, 0.008, 0.03, -0.02},      // a fold, strong shears
        {450, 450, 960, 600, -0.45, 0.2, -0.2, 0.07, -0.01, 0, 0},               // all terms
        {900, 900, 960, 600, 0.2, 0, 0, 0, 0, 0, 0.01},                          // a fold before 90 degrees
    };
  }
  static Camera<Ocam>::Params randomParams(Random& random) {
    return {random.uniform(300, 1500),
            random.uniform(300, 1500),
            955,
            605,
            random.uniform(-0.6, 0.3),
            random.uniform(-0.2, 0.2),
            random.uniform(-0.1, 0.1),
            random.uniform(-0.03, 0.03),
            random.uniform(-0.01, 0.01),
            random.uniform(-0.1, 0.1),
            random.uniform(-0.1, 0.1)};
  }
};

template <>
struct ModelFixture<Fov> {
  static std::vector<Camera<Fov>::Params> paramSets() {
    return {{600, 601, 960, 600, 0.93},   {1000, 1001, 955, 605, 0},    {1000, 1001, 955, 605, 1e-9},
            {1000, 1001, 955, 605, 9e-4}, {1000, 1001, 955, 605, 0.02}, {500, 500, 960, 600, 0.0301},
            {450, 452, 960, 600, 1.9},    {1500, 1500, 960, 600, 3.1}};
  }
  static Camera<Fov>::Params randomParams(Random& random) {
    return {random.uniform(200, 1500), random.uniform(200, 1500), 955, 605, random.uniform(0, 3.1)};
  }
};

template <>
struct ModelFixture<Ucm> {
  static std::vector<Camera<Ucm>::Params> paramSets() {
    return {{500, 501, 960, 600, 0.62},  // a fold beyond 90 degrees
            {1000, 999, 955, 605, 0},    // a perspective
            {800, 805, 950, 610, 0.3},   // a pole beyond 90 degrees
            {450, 452, 960, 600, 0.5},   // stereographic: sees all but straight back
            {900, 905, 960, 600, 0.97},  // a fold inside the image
            {1500, 1500, 960, 600, 1}};  // orthographic
  }
  static Camera<Ucm>::Params randomParams(Random& random) {
    return {random.uniform(200, 1500), random.uniform(200, 1500), 955, 605, random.uniform(0, 1)};
  }
};

template <>
struct ModelFixture<Omni> {
  static std::vector<Camera<Omni>::Params> paramSets() {
    return {{1300, 1302, 962, 598, 1.2, -0.15, 0.05, 1e-3, -8e-4},  // a fisheye
            {1000, 1001, 955, 605, 0, 0, 0, 0, 0},                  // a perspective
            {900, 905, 950, 610, 0.8, -0.2, 0.01, 5e-4, 5e-4},      // a mirror, with a fold of the distortion
            {1000, 1000, 960, 600, 1, 0, 0, 0, 0},                  // a parabolic mirror
            {2500, 2495, 960, 600, 2.7, 0.4, 1.5, -2e-3, 1e-3},     // the sphere's own fold
            {700, 702, 955, 605, 0.6, 0.1, 0.02, 1e-3, 2e-3}};      // pincushion
  }
  static Camera<Omni>::Params randomParams(Random& random) {
    return {random.uniform(500, 3000),
            random.uniform(500, 3000),
            955,
            605,
            random.uniform(0, 3),
            random.uniform(-0.5, 0.5),
            random.uniform(-0.3, 0.3),
            random.uniform(-0.01, 0.01),
            random.uniform(-0.01, 0.01)};
  }
};

template <>
struct ModelFixture<Eucm> {
  static std::vector<Camera<Eucm>::Params> paramSets() {
    return {{480, 481, 960, 600, 0.6, 1.1},  {1000, 1001, 955, 605, 0, 1.7}, {600, 602, 950, 610, 0.35, 0.7},
            {520, 518, 960, 600, 0.5, 2.5},  {700, 703, 960, 600, 0.8, 0.4}, {900, 900, 960, 600, 0.95, 1.3},
            {1100, 1100, 960, 600, 1.0, 0.9}};
  }
  static Camera<Eucm>::Params randomParams(Random& random) {
    return {random.uniform(200, 1500), random.uniform(200, 1500), 955, 605,
            random.uniform(0, 1),      random.uniform(0.2, 4)};
  }
};

template <>
struct ModelFixture<DoubleSphere> {
  static std::vector<Camera<DoubleSphere>::Params> paramSets() {
    return {{350, 351, 960, 600, -0.2, 0.59},  // an ordinary fisheye
            {500, 502, 955, 605, 0, 0.6},      // ucm
            {1000, 1001, 950, 610, 0, 0},      // a perspective
            {700, 703, 960, 600, 0.4, 0.3},    // a pole
            {600, 598, 960, 600, -0.6, 0.9},   // a fold before 90 degrees
            {900, 900, 960, 600, 0.9, 0.55},   // nearly all directions
            {1500, 1500, 960, 600, 1, 1}};
  }
  static Camera<DoubleSphere>::Params randomParams(Random& random) {
    return {random.uniform(200, 1500), random.uniform(200, 1500), 955, 605,
            random.uniform(-0.9, 1),   random.uniform(0, 1)};
  }
};

template <class List>
struct TypesOfList;
template <CameraModel... Models>
struct TypesOfList<ModelList<Models...>> {
  using type = ::testing::Types<Models...>;
};

/// All models, for TYPED_TEST_SUITE.
using AllModelTypes = TypesOfList<AllModels>::type;

/// Names typed tests after the models.
struct ModelName {
  template <class M>
  static std::string GetName(int) {
    return std::string(M::kId);
  }
};

}  // namespace alidade
