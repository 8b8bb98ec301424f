// SPDX-License-Identifier: MIT
#include "alidade/detect/board/circle_grid_detector.h"

namespace alidade {

Detection findBoard(const GrayImage&, const CircleGrid&) {
  return {};
}

Detection findBoard(const GrayImage&, const AsymmetricCircleGrid&) {
  return {};
}

}  // namespace alidade
