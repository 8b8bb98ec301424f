// SPDX-License-Identifier: MIT
#include "io/formats/examples.h"

namespace alidade {
namespace {

constexpr ImageSize kVga{.width = 640, .height = 480};

std::vector<FormatExample> ofOrbslam() {
  return {
      {"orbslam",
       "OpenVSLAM",
       R"(Camera.name: "a fisheye"
Camera.setup: "monocular"
Camera.model: "fisheye"
Camera.fx: 300.0
Camera.fy: 301.0
Camera.cx: 320.0
Camera.cy: 240.0
Camera.k1: -0.01
Camera.k2: 0.02
Camera.k3: -0.03
Camera.k4: 0.004
Camera.fps: 20.0
Camera.cols: 640
Camera.rows: 480
Camera.color_order: "Gray"
Feature.max_num_keypoints: 1000
)",
       {{"Camera1", "kannala_brandt", kVga, {300, 301, 320, 240, -0.01, 0.02, -0.03, 0.004}}}},
      {"orbslam",
       "stella_vslam",
       R"(Camera:
  name: "an ordinary lens"
  setup: "monocular"
  model: "perspective"
  fx: 500.0
  fy: 501.0
  cx: 320.0
  cy: 240.0
  k1: -0.1
  k2: 0.02
  p1: 0.001
  p2: 0.002
  k3: 0.03
  fps: 30.0
  cols: 640
  rows: 480
  color_order: "RGB"
Preprocessing:
  min_size: 800
)",
       {{"", "radtan", kVga, {500, 501, 320, 240, -0.1, 0.02, 0.001, 0.002, 0.03}}}},
  };
}

}  // namespace

std::vector<FormatExample> dialectExamples() {
  return ofOrbslam();
}

}  // namespace alidade
