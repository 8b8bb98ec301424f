// SPDX-License-Identifier: MIT
#include "alidade/camera/camera_edit.h"

#include <algorithm>
#include <cstdint>
#include <memory>
#include <string>
#include <utility>

#include "alidade/camera/correction_field.h"
#include "alidade/camera/model_traits.h"
#include "alidade/core/error.h"
#include "alidade/core/size_groups.h"

namespace alidade {
namespace {

constexpr Eigen::Index kFx = 0;
constexpr Eigen::Index kFy = 1;
constexpr Eigen::Index kCx = 2;
constexpr Eigen::Index kCy = 3;

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
  AnyCamera edited = camera.withParameters({params.data(), static_cast<std::size_t>(params.size())});
  if (camera.correction() != nullptr) {
    // Pixels follow the principal point.
    edited = edited.withCorrection(std::make_shared<const CorrectionField>(
        camera.correction()->mapped(map.J.block<2, 2>(kCx, kCx), map.offset.segment<2>(kCx))));
  }
  return {.camera = edited, .size = new_size, .J_new_old = map.J};
}

EditedCamera scale(const AnyCamera& camera, double sx, double sy, ImageSize new_size) {
  ParameterMap map(camera);
  map.J(kFx, kFx) = map.J(kCx, kCx) = sx;
  map.J(kFy, kFy) = map.J(kCy, kCy) = sy;
  map.offset(kCx) = 0.5 * sx - 0.5;
  map.offset(kCy) = 0.5 * sy - 0.5;
  return apply(map, camera, new_size);
}

EditedCamera quarterTurn(const AnyCamera& camera, ImageSize size) {
  // In the plane (mx, my) becomes (-my, mx), and u = height - 1 - v, v = u.
  ParameterMap map(camera);
  map.offset(kCx) = size.height - 1;
  const auto swap = [&map](Eigen::Index x, Eigen::Index y, double new_x, double new_y) {
    map.J(x, x) = map.J(y, y) = 0;
    map.J(x, y) = new_x;
    map.J(y, x) = new_y;
  };
  swap(kFx, kFy, 1, 1);
  swap(kCx, kCy, -1, 1);
  for (const LensVector& vector : modelTraits(camera.modelId()).vectors)
    swap(static_cast<Eigen::Index>(kNumAffine + vector.x), static_cast<Eigen::Index>(kNumAffine + vector.y),
         -1, vector.sign);
  EditedCamera edited = apply(map, camera, {.width = size.height, .height = size.width});
  edited.new_from_old << 0, -1, 0,  //
      1, 0, 0,                      //
      0, 0, 1;
  return edited;
}

}  // namespace

EditedCamera cropCamera(const AnyCamera& camera, ImageSize size, const PixelRect& part) {
  // Written without sums, which could overflow.
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
  constexpr std::int64_t kMaxPixels = std::int64_t{1} << 30U;  // in total, as in a camera file
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
  // Cropping on the right and at the bottom moves no coordinate.
  return scale(camera, 1.0 / factor, 1.0 / factor,
               {.width = size.width / factor, .height = size.height / factor});
}

EditedCamera rotateCamera(const AnyCamera& camera, ImageSize size, int quarter_turns) {
  EditedCamera all = apply(ParameterMap(camera), camera, size);
  const int num_turns = (quarter_turns % 4 + 4) % 4;
  if (num_turns % 2 == 1 &&
      !modelTraits(camera.modelId()).can_turn(camera.parameters().data() + kNumAffine)) {
    throw inputError(
        {.where = "camera of model " + std::string(camera.modelId()),
         .found = "a skewed or doubly tilted sensor, which the model cannot state after a turn by 90 degrees",
         .expected = "a turn by 180 degrees, or a camera that can turn",
         .next_step = "fit another model first: alidade convert CAMERA -o PLAIN --model " +
                      std::string(leadTraits(modelTraits(camera.modelId()).family).id)});
  }
  for (int i = 0; i < num_turns; ++i) {
    EditedCamera next = quarterTurn(all.camera, all.size);
    next.new_from_old = next.new_from_old * all.new_from_old;
    next.J_new_old = next.J_new_old.view() * all.J_new_old.view();
    all = std::move(next);
  }
  return all;
}

}  // namespace alidade
