// SPDX-License-Identifier: MIT
#include "files/formats/examples.h"

#include "support/image_sizes.h"

namespace alidade {
namespace {

std::vector<FormatExample> ofOpenCv() {
  return {
      {"opencv",
       "interactive-calibration",
       R"(<?xml version="1.0"?>
<opencv_storage>
<calibrationDate>"Wed 03 Jul 2019 12:00:00"</calibrationDate>
<framesCount>13</framesCount>
<cameraResolution>
  640 480</cameraResolution>
<cameraMatrix type_id="opencv-matrix">
  <rows>3</rows>
  <cols>3</cols>
  <dt>d</dt>
  <data>
    500. 0. 320. 0. 501. 240. 0. 0. 1.</data></cameraMatrix>
<cameraMatrix_std_dev type_id="opencv-matrix">
  <rows>4</rows>
  <cols>1</cols>
  <dt>d</dt>
  <data>
    0. 1.25 0.5 0.25</data></cameraMatrix_std_dev>
<dist_coeffs type_id="opencv-matrix">
  <rows>1</rows>
  <cols>5</cols>
  <dt>d</dt>
  <data>
    -1.e-01 2.e-02 1.e-03 2.e-03 3.e-02</data></dist_coeffs>
<dist_coeffs_std_dev type_id="opencv-matrix">
  <rows>5</rows>
  <cols>1</cols>
  <dt>d</dt>
  <data>
    0. 0. 0. 0. 0.</data></dist_coeffs_std_dev>
<avg_reprojection_error>1.8e-01</avg_reprojection_error>
</opencv_storage>
)",
       {{"", "radtan", kVga, {500, 501, 320, 240, -0.1, 0.02, 0.001, 0.002, 0.03}}}},
  };
}

std::vector<FormatExample> ofKalibr() {
  return {
      {"kalibr",
       "a sensor of EuRoC",
       R"(# General sensor definitions.
sensor_type: camera
comment: VI-Sensor cam0 (MT9M034)

# Sensor extrinsics wrt. the body-frame.
T_BS:
  cols: 4
  rows: 4
  data: [0.0148655429818, -0.999880929698, 0.00414029679422, -0.0216401454975,
         0.999557249008, 0.0149672133247, 0.025715529948, -0.064676986768,
        -0.0257744366974, 0.00375618835797, 0.999660727178, 0.00981073058949,
         0.0, 0.0, 0.0, 1.0]

# Camera specific definitions.
rate_hz: 20
resolution: [640, 480]
camera_model: pinhole
intrinsics: [500.0, 501.0, 320.0, 240.0] #fu, fv, cu, cv
distortion_model: radial-tangential
distortion_coefficients: [-0.1, 0.02, 0.001, 0.002]
)",
       {{"", "radtan", kVga, {500, 501, 320, 240, -0.1, 0.02, 0.001, 0.002, 0}}}},
  };
}

std::vector<FormatExample> ofRos() {
  return {
      {"ros",
       "two messages",
       R"(header:
  stamp:
    sec: 1690000000
    nanosec: 12345
  frame_id: camera
height: 480
width: 640
distortion_model: None
d: []
k: [500.0, 0.0, 320.0, 0.0, 501.0, 240.0, 0.0, 0.0, 1.0]
---
header:
  stamp:
    sec: 1690000000
    nanosec: 54321
  frame_id: camera
height: 480
width: 640
distortion_model: None
d: []
k: [500.0, 0.0, 320.0, 0.0, 501.0, 240.0, 0.0, 0.0, 1.0]
---
)",
       {{"", "pinhole", kVga, {500, 501, 320, 240}}}},
      {"ros",
       "messages of two cameras",
       R"(left:
  width: 640
  height: 480
  distortion_model: plumb_bob
  d: [-0.1, 0.02, 0.001, 0.002, 0.03]
  k: [500.0, 0.0, 320.0, 0.0, 501.0, 240.0, 0.0, 0.0, 1.0]
  r: [1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0]
right:
  width: 640
  height: 480
  distortion_model: equidistant
  d: [-0.01, 0.02, -0.03, 0.004]
  k: [300.0, 0.0, 320.0, 0.0, 301.0, 240.0, 0.0, 0.0, 1.0]
  r: [1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0]
)",
       {{"left", "radtan", kVga, {500, 501, 320, 240, -0.1, 0.02, 0.001, 0.002, 0.03}},
        {"right", "kannala_brandt", kVga, {300, 301, 320, 240, -0.01, 0.02, -0.03, 0.004}}}},
  };
}

std::vector<FormatExample> ofOrbslam() {
  return {
      {"orbslam",
       "a rectified pair of ORB-SLAM2",
       R"(%YAML:1.0
Camera.fx: 435.25
Camera.fy: 435.25
Camera.cx: 367.5
Camera.cy: 252.25
Camera.k1: 0.0
Camera.k2: 0.0
Camera.p1: 0.0
Camera.p2: 0.0
Camera.width: 640
Camera.height: 480
Camera.bf: 47.90639384423901
LEFT.D: !!opencv-matrix
   rows: 1
   cols: 5
   dt: d
   data:[-0.28340811, 0.07395907, 0.00019359, 1.76187114e-05, 0.0]
LEFT.K: !!opencv-matrix
   rows: 3
   cols: 3
   dt: d
   data:[458.654, 0.0, 367.215, 0.0, 457.296, 248.375, 0.0, 0.0, 1.0]
)",
       {{"Camera1", "radtan", kVga, {435.25, 435.25, 367.5, 252.25, 0, 0, 0, 0, 0}}},
       {"assumed", "not_carried"}},
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
  std::vector<FormatExample> all;
  for (const auto& more : {ofOpenCv(), ofRos(), ofKalibr(), ofOrbslam()})
    all.insert(all.end(), more.begin(), more.end());
  return all;
}

}  // namespace alidade
