// SPDX-License-Identifier: MIT
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <string>
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
