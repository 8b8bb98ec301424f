// SPDX-License-Identifier: MIT
#include "alidade/compare/crop_suspicion.h"

#include <algorithm>
#include <cmath>
#include <utility>

namespace alidade {
namespace {

// Pixels a radian about the optical axis. What models call fx may be another thing.
double focalLength(const AnyCamera& camera) {
  Eigen::Matrix<double, 2, 3, Eigen::RowMajor> J_point;
  J_point.setZero();
  const Eigen::Vector3d axis(0, 0, 1);
  static_cast<void>(camera.project(axis, J_point.data(), nullptr));
  return std::sqrt(std::abs(J_point(0, 0) * J_point(1, 1)));
}

double ratio(double one, double other) {
  return std::max(one / other, other / one);
}

}  // namespace

std::optional<CropSuspicion> suspectCrop(const ComparedCamera& a, const ComparedCamera& b,
                                         const ImageMatch& match) {
  constexpr double kOtherSize = 1.1;
  constexpr double kSameFocal = 1.02;
  const int longer_a = std::max(a.size.width, a.size.height);
  const int longer_b = std::max(b.size.width, b.size.height);
  CropSuspicion found{.is_a_larger = longer_a > longer_b,
                      .focal_a_px = focalLength(*a.camera),
                      .focal_b_px = focalLength(*b.camera),
                      .part = {},
                      .corner = {}};
  // Written so that a focal length of zero raises no suspicion.
  if (!(ratio(longer_a, longer_b) > kOtherSize && ratio(found.focal_a_px, found.focal_b_px) <= kSameFocal))
    return std::nullopt;
  const ComparedCamera& larger = found.is_a_larger ? a : b;
  const ComparedCamera& smaller = found.is_a_larger ? b : a;
  found.part = smaller.size;
  if (match.quarter_turns % 2 != 0) std::swap(found.part.width, found.part.height);
  if (match.quarter_turns != 0) return found;
  const auto in_larger = larger.camera->parameters();
  const auto in_smaller = smaller.camera->parameters();
  const double x = std::round(in_larger[2] - in_smaller[2]);
  const double y = std::round(in_larger[3] - in_smaller[3]);
  if (x >= 0 && y >= 0 && x <= larger.size.width - found.part.width &&
      y <= larger.size.height - found.part.height)
    found.corner = Eigen::Vector2i(static_cast<int>(x), static_cast<int>(y));
  return found;
}

}  // namespace alidade
