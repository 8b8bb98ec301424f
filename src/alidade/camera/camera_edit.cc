// SPDX-License-Identifier: MIT
#include "alidade/camera/camera_edit.h"

#include <algorithm>
#include <array>
#include <cstdint>
#include <string>
#include <utility>

#include "alidade/camera/camera_variant.h"
#include "alidade/core/error.h"
#include "alidade/core/size_groups.h"

namespace alidade {
namespace {

constexpr Eigen::Index kFx = 0;
constexpr Eigen::Index kFy = 1;
constexpr Eigen::Index kCx = 2;
constexpr Eigen::Index kCy = 3;

// Parameters that a quarter turn of the image swaps: the new x is `sign` times the old y. Those of the lens
// are the components of a vector in the normalised plane. The tangential terms are r2 t + 2 (x . t) x with
// t = (p2, p1), the prism's r2 (s1, s3) + r2^2 (s2, s4).
struct SwappedPair {
  std::string_view x, y;
  double sign;
};
constexpr std::array<SwappedPair, 5> kSwapped = {
    {{"fx", "fy", 1}, {"cx", "cy", -1}, {"p2", "p1", -1}, {"s1", "s3", -1}, {"s2", "s4", -1}}};

// new parameters = J * old parameters + offset
struct ParameterMap {
  Eigen::MatrixXd J;
  Eigen::VectorXd offset;

  explicit ParameterMap(const AnyCamera& camera) {
    const auto n = static_cast<Eigen::Index>(camera.parameters().size());
    J.setIdentity(n, n);
    offset.setZero(n);
  }
};

EditedCamera apply(const ParameterMap& map, const AnyCamera& camera, ImageSize new_size) {
  const auto old = camera.parameters();
  const Eigen::VectorXd params =
      map.J * Eigen::Map<const Eigen::VectorXd>(old.data(), static_cast<Eigen::Index>(old.size())) +
      map.offset;
  return {
      .camera = AnyCamera::make(camera.modelId(), {params.data(), static_cast<std::size_t>(params.size())}),
      .size = new_size,
      .J_new_old = map.J};
}

EditedCamera scale(const AnyCamera& camera, double sx, double sy, ImageSize new_size) {
  ParameterMap map(camera);
  map.J(kFx, kFx) = map.J(kCx, kCx) = sx;
  map.J(kFy, kFy) = map.J(kCy, kCy) = sy;
  map.offset(kCx) = 0.5 * sx - 0.5;
  map.offset(kCy) = 0.5 * sy - 0.5;
  return apply(map, camera, new_size);
}

// Whether nothing but the pairs above gives the lens a direction. A model of which this is not so needs its
// parameters added to them.
bool isTurnedByPairs(const AnyCamera& camera) {
  return camera.visit([](const auto& c) {
    using M = typename std::decay_t<decltype(c)>::Model;
    auto params = c.params();
    const auto& names = kParamNames<M>;
    for (std::size_t i = 4; i < params.size(); ++i) {
      for (const SwappedPair& pair : kSwapped) {
        if (names[i] == pair.x || names[i] == pair.y) params[i] = 0;
      }
    }
    return M::isAxiallySymmetric(params.data() + 4);
  });
}

EditedCamera quarterTurn(const AnyCamera& camera, ImageSize size) {
  // In the plane (mx, my) becomes (-my, mx), and u = height - 1 - v, v = u.
  ParameterMap map(camera);
  map.offset(kCx) = size.height - 1;
  for (const auto& [x_name, y_name, sign] : kSwapped) {
    const auto x = parameterIndex(camera.parameterNames(), x_name);
    const auto y = parameterIndex(camera.parameterNames(), y_name);
    if (!x || !y) continue;
    const auto i = static_cast<Eigen::Index>(*x);
    const auto j = static_cast<Eigen::Index>(*y);
    map.J(i, i) = map.J(j, j) = 0;
    map.J(i, j) = sign;
    map.J(j, i) = 1;
  }
  EditedCamera edited = apply(map, camera, {.width = size.height, .height = size.width});
  edited.new_from_old << 0, -1, 0,  //
      1, 0, 0,                      //
      0, 0, 1;
  return edited;
}

}  // namespace

EditedCamera cropCamera(const AnyCamera& camera, ImageSize size, const PixelRect& part) {
  // Written so that no sum can overflow.
  const bool is_inside = part.x >= 0 && part.y >= 0 && part.width >= 1 && part.height >= 1 &&
                         part.width <= size.width - part.x && part.height <= size.height - part.y;
  if (!is_inside) {
    throw usageError({.where = "crop",
                      .found = std::to_string(part.width) + "x" + std::to_string(part.height) +
                               " pixels from (" + std::to_string(part.x) + ", " + std::to_string(part.y) +
                               ")",
                      .expected = "a part of the image, which has " + sizeText(size) + " pixels"});
  }
  ParameterMap map(camera);
  map.offset(kCx) = -part.x;
  map.offset(kCy) = -part.y;
  return apply(map, camera, {.width = part.width, .height = part.height});
}

EditedCamera resizeCamera(const AnyCamera& camera, ImageSize size, ImageSize new_size) {
  constexpr std::int64_t kMaxPixels = std::int64_t{1} << 30U;  // in all, as in a camera file
  if (std::min(new_size.width, new_size.height) < 1 ||
      std::max(new_size.width, new_size.height) > kMaxImageSide ||
      std::int64_t{new_size.width} * new_size.height > kMaxPixels) {
    throw usageError({.where = "resize",
                      .found = sizeText(new_size) + " pixels",
                      .expected = "1 to " + std::to_string(kMaxImageSide) + " pixels per side and at most " +
                                  std::to_string(kMaxPixels) + " in total"});
  }
  return scale(camera, static_cast<double>(new_size.width) / size.width,
               static_cast<double>(new_size.height) / size.height, new_size);
}

EditedCamera binCamera(const AnyCamera& camera, ImageSize size, int factor) {
  if (factor < 1 || factor > std::min(size.width, size.height)) {
    throw usageError({.where = "bin",
                      .found = std::to_string(factor),
                      .expected = "1 to " + std::to_string(std::min(size.width, size.height)) +
                                  ", because the image has " + sizeText(size) + " pixels"});
  }
  // What is cropped lies on the right and at the bottom, where it moves no coordinate.
  return scale(camera, 1.0 / factor, 1.0 / factor,
               {.width = size.width / factor, .height = size.height / factor});
}

EditedCamera rotateCamera(const AnyCamera& camera, ImageSize size, int quarter_turns) {
  expect(isTurnedByPairs(camera), "every lens parameter with a direction is known to camera_edit");
  EditedCamera all = apply(ParameterMap(camera), camera, size);
  const int num_turns = (quarter_turns % 4 + 4) % 4;
  for (int i = 0; i < num_turns; ++i) {
    EditedCamera next = quarterTurn(all.camera, all.size);
    next.new_from_old = next.new_from_old * all.new_from_old;
    next.J_new_old = next.J_new_old.view() * all.J_new_old.view();
    all = std::move(next);
  }
  return all;
}

}  // namespace alidade
