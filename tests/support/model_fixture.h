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
#include "alidade/core/image.h"

namespace alidade {

/// Parameters to test a model with. A model without a specialisation does not compile into the typed suites:
/// adding a model means adding its sets here.
template <CameraModel M>
struct ModelFixture;

inline constexpr ImageSize kTestImage{.width = 1920, .height = 1200};

template <>
struct ModelFixture<Pinhole> {
  static std::vector<Camera<Pinhole>::Params> paramSets() {
    return {{1003.1, 1001.7, 961.3, 597.2}, {320, 330, 955, 600}, {9000, 9010, 900, 650}};
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

/// Unit ray at an angle from the optical axis, in the direction `azimuth` from x towards y.
inline Eigen::Vector3d rayAt(double angle, double azimuth) {
  return {std::sin(angle) * std::cos(azimuth), std::sin(angle) * std::sin(azimuth), std::cos(angle)};
}

/// Angle between two unit vectors, exact for small ones.
inline double angleBetween(const Eigen::Vector3d& a, const Eigen::Vector3d& b) {
  return 2 * std::asin(std::min(1.0, 0.5 * (a - b).norm()));
}

}  // namespace alidade
