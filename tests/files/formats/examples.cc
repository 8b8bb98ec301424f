// SPDX-License-Identifier: MIT
#include "files/formats/examples.h"

#include "support/image_sizes.h"

namespace alidade {
namespace {

constexpr ImageSize kEuroc{.width = 752, .height = 480};

std::vector<FormatExample> ownAndOpenCv() {
  return {
      {"alidade",
       "a file by hand",
       R"(alidade_camera: 1
model: radtan
image_size: {width: 640, height: 480}
parameters: {fx: 532.8, fy: 532.9, cx: 342.5, cy: 233.9, k1: -0.281, k2: 0.025, p1: 0.0012, p2: -0.0001, k3: 0.163}
)",
       {{"", "radtan", kVga, {532.8, 532.9, 342.5, 233.9, -0.281, 0.025, 0.0012, -0.0001, 0.163}}}},
      {"opencv",
       "YAML",
       R"(%YAML:1.0
---
calibration_time: "Sun Nov  2 10:00:00 2025"
image_width: 640
image_height: 480
camera_matrix: !!opencv-matrix
   rows: 3
   cols: 3
   dt: d
   data: [ 5.3280000000000000e+02, 0., 3.4250000000000000e+02, 0., 5.3290000000000000e+02,
       2.3390000000000000e+02, 0., 0., 1. ]
distortion_coefficients: !!opencv-matrix
   rows: 5
   cols: 1
   dt: d
   data: [ -2.8100000000000003e-01, 2.5000000000000001e-02, 1.2000000000000001e-03,
       -1.0000000000000000e-04, 1.6300000000000001e-01 ]
avg_reprojection_error: 1.9500000000000001e-01
)",
       {{"", "radtan", kVga, {532.8, 532.9, 342.5, 233.9, -0.281, 0.025, 0.0012, -0.0001, 0.163}}}},
      {"opencv",
       "XML",
       R"(<?xml version="1.0"?>
<opencv_storage>
<image_Width>640</image_Width>
<image_Height>480</image_Height>
<fisheye_model>1</fisheye_model>
<camera_matrix type_id="opencv-matrix">
  <rows>3</rows>
  <cols>3</cols>
  <dt>d</dt>
  <data>
    300. 0. 320. 0. 301. 240. 0. 0. 1.</data></camera_matrix>
<distortion_coefficients type_id="opencv-matrix">
  <rows>4</rows>
  <cols>1</cols>
  <dt>d</dt>
  <data>
    -0.01 0.02 -0.03 0.004</data></distortion_coefficients>
</opencv_storage>
)",
       {{"", "kannala_brandt", kVga, {300, 301, 320, 240, -0.01, 0.02, -0.03, 0.004}}}},
      {"opencv",
       "JSON of a pair",
       R"({
    "image_size": [640, 480],
    "M1": {"type_id": "opencv-matrix", "rows": 3, "cols": 3, "dt": "d", "data": [500.0, 0.0, 320.0, 0.0, 501.0, 240.0, 0.0, 0.0, 1.0]},
    "D1": {"type_id": "opencv-matrix", "rows": 1, "cols": 8, "dt": "d", "data": [0.1, 0.2, 0.001, 0.002, 0.03, 0.4, 0.05, 0.006]},
    "M2": {"type_id": "opencv-matrix", "rows": 3, "cols": 3, "dt": "d", "data": [510.0, 0.0, 321.0, 0.0, 511.0, 241.0, 0.0, 0.0, 1.0]},
    "D2": {"type_id": "opencv-matrix", "rows": 1, "cols": 5, "dt": "d", "data": [-0.1, 0.02, 0.001, 0.002, 0.03]},
    "T": {"type_id": "opencv-matrix", "rows": 3, "cols": 1, "dt": "d", "data": [-0.1, 0.0, 0.0]}
}
)",
       {{"1", "rational", kVga, {500, 501, 320, 240, 0.1, 0.2, 0.001, 0.002, 0.03, 0.4, 0.05, 0.006}},
        {"2", "radtan", kVga, {510, 511, 321, 241, -0.1, 0.02, 0.001, 0.002, 0.03}}},
       {"not_carried"}},
      {"ros",
       "camera_info",
       R"(image_width: 640
image_height: 480
camera_name: left
camera_matrix:
  rows: 3
  cols: 3
  data: [532.8,   0. , 342.5,
           0. , 532.9, 233.9,
           0. ,   0. ,   1. ]
distortion_model: plumb_bob
distortion_coefficients:
  rows: 1
  cols: 5
  data: [-0.281000, 0.025000, 0.001200, -0.000100, 0.163000]
rectification_matrix:
  rows: 3
  cols: 3
  data: [1., 0., 0., 0., 1., 0., 0., 0., 1.]
projection_matrix:
  rows: 3
  cols: 4
  data: [500., 0., 342., 0., 0., 501., 233., 0., 0., 0., 1., 0.]
)",
       {{"left", "radtan", kVga, {532.8, 532.9, 342.5, 233.9, -0.281, 0.025, 0.0012, -0.0001, 0.163}}},
       {"not_carried"}},
      {"ros",
       "a message of ROS 2",
       R"(header:
  frame_id: cam
height: 480
width: 640
distortion_model: equidistant
d: [-0.01, 0.02, -0.03, 0.004]
k: [300.0, 0.0, 320.0, 0.0, 301.0, 240.0, 0.0, 0.0, 1.0]
r: [0.0, 1.0, 0.0, -1.0, 0.0, 0.0, 0.0, 0.0, 1.0]
p: [300.0, 0.0, 320.0, 0.0, 0.0, 301.0, 240.0, 0.0, 0.0, 0.0, 1.0, 0.0]
binning_x: 0
binning_y: 0
roi: {x_offset: 0, y_offset: 0, height: 0, width: 0, do_rectify: false}
)",
       {{"", "kannala_brandt", kVga, {300, 301, 320, 240, -0.01, 0.02, -0.03, 0.004}}}},
  };
}

std::vector<FormatExample> kalibrColmapMrcal() {
  return {
      {"kalibr",
       "a chain",
       R"(cam0:
  cam_overlaps: [1, 2, 3, 4]
  camera_model: pinhole
  distortion_coeffs: [-0.28340811, 0.07395907, 0.00019359, 1.76187114e-05]
  distortion_model: radtan
  intrinsics: [458.654, 457.296, 367.215, 248.375]
  resolution: [752, 480]
  rostopic: /cam0/image_raw
cam1:
  T_cn_cnm1:
  - [0.99999, 0.0023, 0.0003, -0.11007]
  - [-0.0023, 0.99989, -0.0142, 0.00039]
  - [-0.0003, 0.0142, 0.99989, -0.00085]
  - [0.0, 0.0, 0.0, 1.0]
  camera_model: pinhole
  distortion_coeffs: [-0.01, 0.02, -0.03, 0.004]
  distortion_model: equidistant
  intrinsics: [458.0, 457.0, 367.0, 248.0]
  resolution: [752, 480]
  rostopic: /cam1/image_raw
  timeshift_cam_imu: 0.005
cam2:
  camera_model: pinhole
  distortion_coeffs: [0.93]
  distortion_model: fov
  intrinsics: [458.0, 457.0, 367.0, 248.0]
  resolution: [752, 480]
  rostopic: /cam2/image_raw
cam3:
  camera_model: omni
  distortion_coeffs: [-0.1, 0.05, 0.001, -0.002]
  distortion_model: radtan
  intrinsics: [1.3, 900.0, 901.0, 367.0, 248.0]
  resolution: [752, 480]
  rostopic: /cam3/image_raw
cam4:
  camera_model: eucm
  distortion_coeffs: []
  distortion_model: none
  intrinsics: [0.6, 1.1, 458.0, 457.0, 367.0, 248.0]
  resolution: [752, 480]
  rostopic: /cam4/image_raw
)",
       {{"cam0",
         "radtan",
         kEuroc,
         {458.654, 457.296, 367.215, 248.375, -0.28340811, 0.07395907, 0.00019359, 1.76187114e-05, 0}},
        {"cam1", "kannala_brandt", kEuroc, {458, 457, 367, 248, -0.01, 0.02, -0.03, 0.004}},
        {"cam2", "fov", kEuroc, {458, 457, 367, 248, 0.93}},
        {"cam3", "omni", kEuroc, {900, 901, 367, 248, 1.3, -0.1, 0.05, 0.001, -0.002}},
        {"cam4", "eucm", kEuroc, {458, 457, 367, 248, 0.6, 1.1}}}},
      {"kalibr",
       "OpenVINS",
       R"(%YAML:1.0

cam0:
  T_imu_cam:
    - [0.0, -1.0, 0.0, 0.0]
    - [1.0, 0.0, 0.0, 0.0]
    - [0.0, 0.0, 1.0, 0.1]
    - [0.0, 0.0, 0.0, 1.0]
  cam_overlaps: []
  camera_model: ds
  distortion_coeffs: []
  distortion_model: none
  intrinsics: [-0.2, 0.6, 158.0, 157.0, 367.0, 248.0]
  resolution: [752, 480]
  rostopic: /cam0/image_raw
cam1:
  camera_model: omni
  distortion_model: none
  distortion_coeffs: []
  intrinsics: [1.3, 900.0, 901.0, 367.0, 248.0]
  resolution: [752, 480]
)",
       {{"cam0", "double_sphere", kEuroc, {158, 157, 367, 248, -0.2, 0.6}},
        {"cam1", "omni", kEuroc, {900, 901, 367, 248, 1.3, 0, 0, 0, 0}}},
       {"not_carried"}},
      {"colmap",
       "cameras.txt",
       R"(# Camera list with one line of data per camera:
#   CAMERA_ID, MODEL, WIDTH, HEIGHT, PARAMS[]
# Number of cameras: 12
1 SIMPLE_PINHOLE 640 480 500 320 240
2 PINHOLE 640 480 500 501 320 240
3 SIMPLE_RADIAL 640 480 500 320 240 -0.1
4 RADIAL 640 480 500 320 240 -0.1 0.02
5 OPENCV 640 480 500 501 320 240 -0.1 0.02 0.001 0.002
6 OPENCV_FISHEYE 640 480 300 301 320 240 -0.01 0.02 -0.03 0.004
7 FULL_OPENCV 640 480 500 501 320 240 0.1 0.2 0.001 0.002 0.03 0.4 0.05 0.006
8 FOV 640 480 300 301 320 240 0.93
9 SIMPLE_RADIAL_FISHEYE 640 480 300 320 240 -0.01
10 RADIAL_FISHEYE 640 480 300 320 240 -0.01 0.02
11 EUCM 640 480 300 301 320 240 0.6 1.1
12 FISHEYE 640 480 300 301 320 240
)",
       {{"1", "pinhole", kVga, {500, 500, 319.5, 239.5}},
        {"2", "pinhole", kVga, {500, 501, 319.5, 239.5}},
        {"3", "radtan", kVga, {500, 500, 319.5, 239.5, -0.1, 0, 0, 0, 0}},
        {"4", "radtan", kVga, {500, 500, 319.5, 239.5, -0.1, 0.02, 0, 0, 0}},
        {"5", "radtan", kVga, {500, 501, 319.5, 239.5, -0.1, 0.02, 0.001, 0.002, 0}},
        {"6", "kannala_brandt", kVga, {300, 301, 319.5, 239.5, -0.01, 0.02, -0.03, 0.004}},
        {"7", "rational", kVga, {500, 501, 319.5, 239.5, 0.1, 0.2, 0.001, 0.002, 0.03, 0.4, 0.05, 0.006}},
        {"8", "fov", kVga, {300, 301, 319.5, 239.5, 0.93}},
        {"9", "kannala_brandt", kVga, {300, 300, 319.5, 239.5, -0.01, 0, 0, 0}},
        {"10", "kannala_brandt", kVga, {300, 300, 319.5, 239.5, -0.01, 0.02, 0, 0}},
        {"11", "eucm", kVga, {300, 301, 319.5, 239.5, 0.6, 1.1}},
        {"12", "kannala_brandt", kVga, {300, 301, 319.5, 239.5, 0, 0, 0, 0}}}},
      {"colmap_rig",
       "rig_config.json",
       R"([
  {
    "cameras": [
      {
        "image_prefix": "rig1/left/",
        "ref_sensor": true,
        "camera_model_name": "OPENCV",
        "camera_params": [500.0, 501.0, 320.5, 240.5, -0.1, 0.02, 0.001, 0.002]
      },
      {
        "image_prefix": "rig1/right/",
        "cam_from_rig_rotation": [0.7071067811865475, 0.0, 0.7071067811865476, 0.0],
        "cam_from_rig_translation": [-0.1, 0, 0],
        "camera_model_name": "SIMPLE_PINHOLE",
        "camera_params": [500, 320.5, 240.5]
      }
    ]
  }
]
)",
       {{"left", "radtan", kVga, {500, 501, 320, 240, -0.1, 0.02, 0.001, 0.002, 0}},
        {"right", "pinhole", kVga, {500, 500, 320, 240}}}},
      {"mrcal",
       "a calibration",
       R"(# generated by mrcal-calibrate-cameras
{
    'lensmodel':  'LENSMODEL_OPENCV8',

    # intrinsics are fx,fy,cx,cy,distortion0,distortion1,....
    'intrinsics': [ 500, 501, 320.25, 240.5, 0.1, 0.2, 0.001, 0.002, 0.03, 0.4, 0.05, 0.006,],

    'valid_intrinsics_region': [
    [ 1, 2 ],
    [ 600, 2 ],
    [ 1, 2 ],
],

    # extrinsics are rt_fromref
    'extrinsics': [ 0, 0, 0, 0, 0, 0,],

    'imagersize': [ 640, 480,],

    'icam_intrinsics': 0,

    # The optimization inputs contain all the data used to compute this model.
    'optimization_inputs': b'P)h>@6aWAK2mk;8K>)Y{Q{;(#0001F000+T003lhZ*',

}
)",
       {{"", "rational", kVga, {500, 501, 320.25, 240.5, 0.1, 0.2, 0.001, 0.002, 0.03, 0.4, 0.05, 0.006}}},
       {"not_carried"}},
      {"mrcal",
       "the sphere from its pole",
       R"({ 'lensmodel': 'LENSMODEL_STEREOGRAPHIC', 'intrinsics': [ 500, 501, 320, 240 ],
  'extrinsics': [ 0, 0, 0, 0, 0, 0 ], 'imagersize': [ 640, 480 ] })",
       {{"", "ucm", kVga, {500, 501, 320, 240, 0.5}}}},
      {"mrcal",
       "an old file",
       R"({ 'distortion_model': 'DISTORTION_OPENCV4', 'intrinsics': [ 500, 501, 320, 240, -0.1, 0.02, 0.001, 0.002 ],
  'extrinsics': [ 0, 0, 0, 0.1, 0, 0 ], 'imagersize': [ 640, 480 ] })",
       {{"", "radtan", kVga, {500, 501, 320, 240, -0.1, 0.02, 0.001, 0.002, 0}}}},
  };
}

std::vector<FormatExample> basaltAndNerfstudio() {
  return {
      {"basalt",
       "two cameras",
       R"({
    "value0": {
        "T_imu_cam": [
            {"px": -0.0168, "py": -0.0689, "pz": 0.0051, "qx": -0.0072, "qy": 0.0077, "qz": 0.7022, "qw": 0.7119},
            {"px": -0.0151, "py": 0.0412, "pz": 0.0032, "qx": -0.0023, "qy": 0.0129, "qz": 0.7024, "qw": 0.7116}
        ],
        "intrinsics": [
            {"camera_type": "ds", "intrinsics": {"fx": 349.7, "fy": 348.7, "cx": 365.8, "cy": 249.3, "xi": -0.24, "alpha": 0.56}},
            {"camera_type": "kb4", "intrinsics": {"fx": 300.0, "fy": 301.0, "cx": 320.0, "cy": 240.0, "k1": -0.01, "k2": 0.02, "k3": -0.03, "k4": 0.004}}
        ],
        "resolution": [[752, 480], [640, 480]],
        "calib_accel_bias": [0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0],
        "calib_gyro_bias": [0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0],
        "imu_update_rate": 200.0,
        "cam_time_offset_ns": 0,
        "vignette": []
    }
}
)",
       {{"cam0", "double_sphere", kEuroc, {349.7, 348.7, 365.8, 249.3, -0.24, 0.56}},
        {"cam1", "kannala_brandt", kVga, {300, 301, 320, 240, -0.01, 0.02, -0.03, 0.004}}}},
      {"basalt",
       "the other lenses",
       R"({"value0": {"resolution": [[640, 480], [640, 480], [640, 480], [640, 480], [640, 480]], "intrinsics": [
  {"camera_type": "pinhole", "intrinsics": {"fx": 500.0, "fy": 501.0, "cx": 320.0, "cy": 240.0}},
  {"camera_type": "pinhole-radtan8", "intrinsics": {"fx": 500.0, "fy": 501.0, "cx": 320.0, "cy": 240.0, "k1": 0.1, "k2": 0.2,
     "p1": 0.001, "p2": 0.002, "k3": 0.03, "k4": 0.4, "k5": 0.05, "k6": 0.006, "rpmax": 0.0}},
  {"camera_type": "ucm", "intrinsics": {"fx": 300.0, "fy": 301.0, "cx": 320.0, "cy": 240.0, "alpha": 0.6}},
  {"camera_type": "eucm", "intrinsics": {"fx": 300.0, "fy": 301.0, "cx": 320.0, "cy": 240.0, "alpha": 0.6, "beta": 1.1}},
  {"camera_type": "fov", "intrinsics": {"fx": 300.0, "fy": 301.0, "cx": 320.0, "cy": 240.0, "w": 0.93}}]}}
)",
       {{"cam0", "pinhole", kVga, {500, 501, 320, 240}},
        {"cam1", "rational", kVga, {500, 501, 320, 240, 0.1, 0.2, 0.001, 0.002, 0.03, 0.4, 0.05, 0.006}},
        {"cam2", "ucm", kVga, {300, 301, 320, 240, 0.6}},
        {"cam3", "eucm", kVga, {300, 301, 320, 240, 0.6, 1.1}},
        {"cam4", "fov", kVga, {300, 301, 320, 240, 0.93}}}},
      {"nerfstudio",
       "one camera for all frames",
       R"({
	"w": 640,
	"h": 480,
	"fl_x": 500.0,
	"fl_y": 501.0,
	"cx": 320.0,
	"cy": 240.0,
	"k1": -0.1,
	"k2": 0.02,
	"k3": 0.03,
	"k4": 0.0,
	"p1": 0.001,
	"p2": 0.002,
	"camera_model": "OPENCV",
	"applied_transform": [[1.0, 0.0, 0.0, 0.0], [0.0, 0.0, 1.0, 0.0], [0.0, -1.0, 0.0, 0.0]],
	"frames": [
		{"file_path": "images/frame_00001.png", "transform_matrix": [[1.0, 0.0, 0.0, 0.0], [0.0, 1.0, 0.0, 0.0], [0.0, 0.0, 1.0, 2.0], [0.0, 0.0, 0.0, 1.0]]}
	]
}
)",
       {{"", "radtan", kVga, {500, 501, 319.5, 239.5, -0.1, 0.02, 0.001, 0.002, 0.03}}}},
      {"nerfstudio",
       "a camera in each frame",
       R"({
  "camera_model": "OPENCV_FISHEYE",
  "frames": [
    {"file_path": "a.png", "w": 640, "h": 480, "fl_x": 300.0, "fl_y": 301.0, "cx": 320.0, "cy": 240.0, "k1": -0.01, "k2": 0.02, "k3": -0.03, "k4": 0.004, "transform_matrix": [[1.0]]},
    {"file_path": "b.png", "w": 640, "h": 480, "fl_x": 300.0, "fl_y": 301.0, "cx": 320.0, "cy": 240.0, "k1": -0.01, "k2": 0.02, "k3": -0.03, "k4": 0.004, "transform_matrix": [[1.0]]},
    {"file_path": "c.png", "w": 752, "h": 480, "fl_x": 310.0, "fl_y": 311.0, "cx": 376.0, "cy": 240.0, "transform_matrix": [[1.0]]}
  ]
}
)",
       {{"a.png", "kannala_brandt", kVga, {300, 301, 319.5, 239.5, -0.01, 0.02, -0.03, 0.004}},
        {"c.png", "kannala_brandt", kEuroc, {310, 311, 375.5, 239.5, 0, 0, 0, 0}}}},
      {"nerfstudio",
       "instant-ngp",
       R"({"camera_angle_x": 1.13, "fl_x": 500.0, "fl_y": 501.0, "cx": 320.0, "cy": 240.0, "w": 640.0, "h": 480.0, "aabb_scale": 16, "frames": []})",
       {{"", "pinhole", kVga, {500, 501, 319.5, 239.5}}},
       {"assumed"}},
  };
}

std::vector<FormatExample> camodocalOrbslamMatlab() {
  return {
      {"camodocal",
       "MEI",
       R"(%YAML:1.0
---
model_type: MEI
camera_name: left
image_width: 640
image_height: 480
mirror_parameters:
   xi: 1.3
distortion_parameters:
   k1: -0.1
   k2: 0.05
   p1: 0.001
   p2: -0.002
projection_parameters:
   gamma1: 900.
   gamma2: 901.
   u0: 320.
   v0: 240.
)",
       {{"left", "omni", kVga, {900, 901, 320, 240, 1.3, -0.1, 0.05, 0.001, -0.002}}}},
      {"camodocal",
       "PINHOLE",
       R"(%YAML:1.0
---
model_type: PINHOLE
camera_name: camera
image_width: 640
image_height: 480
distortion_parameters: {k1: -0.1, k2: 0.02, p1: 0.001, p2: 0.002}
projection_parameters:
   fx: 500.
   fy: 501.
   cx: 320.
   cy: 240.
)",
       {{"camera", "radtan", kVga, {500, 501, 320, 240, -0.1, 0.02, 0.001, 0.002, 0}}}},
      {"camodocal",
       "KANNALA_BRANDT",
       R"(%YAML:1.0
---
model_type: KANNALA_BRANDT
camera_name: camera
image_width: 640
image_height: 480
projection_parameters:
   k2: -0.01
   k3: 0.02
   k4: -0.03
   k5: 0.004
   mu: 300.
   mv: 301.
   u0: 320.
   v0: 240.
)",
       {{"camera", "kannala_brandt", kVga, {300, 301, 320, 240, -0.01, 0.02, -0.03, 0.004}}}},
      {"orbslam",
       "two cameras",
       R"(%YAML:1.0

# Camera Parameters
File.version: "1.0"
Camera.type: "PinHole"
Camera1.fx: 458.654
Camera1.fy: 457.296
Camera1.cx: 367.215
Camera1.cy: 248.375
Camera1.k1: -0.28340811
Camera1.k2: 0.07395907
Camera1.p1: 0.00019359
Camera1.p2: 1.76187114e-05
Camera2.fx: 457.587
Camera2.fy: 456.134
Camera2.cx: 379.999
Camera2.cy: 255.238
Camera2.k1: -0.28368365
Camera2.k2: 0.07451284
Camera2.p1: -0.00010473
Camera2.p2: -3.55590700e-05
Camera2.k3: 0.01
Camera.width: 752
Camera.height: 480
Camera.newWidth: 600
Camera.newHeight: 350
Camera.fps: 20
Camera.RGB: 1
Stereo.ThDepth: 60.0
Stereo.T_c1_c2: !!opencv-matrix
  rows: 4
  cols: 4
  dt: f
  data: [1.0, 0.0, 0.0, 0.110, 0.0, 1.0, 0.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 0.0, 1.0]
ORBextractor.nFeatures: 1200
Viewer.KeyFrameSize: 0.05
)",
       {{"Camera1",
         "radtan",
         kEuroc,
         {458.654, 457.296, 367.215, 248.375, -0.28340811, 0.07395907, 0.00019359, 1.76187114e-05, 0}},
        {"Camera2",
         "radtan",
         kEuroc,
         {457.587, 456.134, 379.999, 255.238, -0.28368365, 0.07451284, -0.00010473, -3.555907e-05, 0.01}}},
       {"not_carried"}},
      {"orbslam",
       "an older fisheye",
       R"(%YAML:1.0
Camera.type: "KannalaBrandt8"
Camera.fx: 300.0
Camera.fy: 301.0
Camera.cx: 320.0
Camera.cy: 240.0
Camera.k1: -0.01
Camera.k2: 0.02
Camera.k3: -0.03
Camera.k4: 0.004
Camera.width: 640
Camera.height: 480
Camera.bf: 19.3
)",
       {{"Camera1", "kannala_brandt", kVga, {300, 301, 320, 240, -0.01, 0.02, -0.03, 0.004}}}},
      {"matlab",
       "cameraIntrinsics",
       R"({"FocalLength":[500,501],"PrincipalPoint":[320,240],"ImageSize":[480,640],"RadialDistortion":[-0.1,0.02],"TangentialDistortion":[0.001,0.002],"Skew":0,"K":[[500,0,320],[0,501,240],[0,0,1]]})",
       {{"", "radtan", kVga, {500, 501, 319, 239, -0.1, 0.02, 0.001, 0.002, 0}}}},
      {"matlab",
       "stereoParameters",
       R"({"CameraParameters1":{"RadialDistortion":[-0.1,0.02,0.03],"TangentialDistortion":[0.001,0.002],"ImageSize":[480,640],
"IntrinsicMatrix":[[500,0,0],[0,501,0],[320,240,1]],"EstimateSkew":false},
"CameraParameters2":{"Intrinsics":{"FocalLength":[510,511],"PrincipalPoint":[321,241],"ImageSize":[480,640],"RadialDistortion":[0,0],"TangentialDistortion":[0,0]}},
"RotationOfCamera2":[[1,0,0],[0,1,0],[0,0,1]],"TranslationOfCamera2":[-100,0,0],"Version":{"Name":"MATLAB"}})",
       {{"CameraParameters1", "radtan", kVga, {500, 501, 319, 239, -0.1, 0.02, 0.001, 0.002, 0.03}},
        {"CameraParameters2", "radtan", kVga, {510, 511, 320, 240, 0, 0, 0, 0, 0}}},
       {"not_carried"}},
  };
}

// Scaramuzza's lens; a_i is divided by a0 and multiplied by its power.
std::vector<FormatExample> ofScaramuzza() {
  const double a2 = -1.1e-3 / 280 * 280 * 280;
  const double a3 = 2e-7 / 280 * 280 * 280 * 280;
  const double a4 = -1.5e-9 / 280 * 280 * 280 * 280 * 280;
  const double c = 1.001;
  return {
      {"ocam",
       "calib_results.txt",
       "#direct\n\n5 -280.0 0.0 0.0011 -2.0e-07 1.5e-09\n\n#inverse\n\n7 459.8019 314.7246 38.4858 54.2281 50.42284 "
       "22.00378 3.543526\n\n#center\n\n241.5 318.25\n\n#affine\n\n1.001 0.002 -0.003\n\n#size\n\n480 640\n",
       {{"", "ocam", kVga, {280, c * 280, 318.25, 241.5, a2, a3, a4, 0, 0, -0.003, 0.002 / c}}}},
      {"matlab",
       "fisheyeIntrinsics",
       "{\"MappingCoefficients\": [280.0, -1.1e-03, 2.0e-07, -1.5e-09], \"DistortionCenter\": [319.25, 242.5], "
       "\"StretchMatrix\": [[1.001, 0.002], [-0.003, 1.0]], \"ImageSize\": [480, 640]}\n",
       {{"", "ocam", kVga, {c * 280, 280, 318.25, 241.5, a2, a3, a4, 0, 0, 0.002 / c, -0.003}}}},
      {"camodocal",
       "scaramuzza",
       "%YAML:1.0\n---\nmodel_type: scaramuzza\ncamera_name: front\nimage_width: 640\nimage_height: 480\n"
       "poly_parameters:\n   p0: -280.0\n   p1: 0.0\n   p2: 1.1e-03\n   p3: -2.0e-07\n   p4: 1.5e-09\n"
       "inv_poly_parameters:\n   p0: 420.0\naffine_parameters:\n   ac: 1.001\n   ad: 0.002\n   ae: -0.003\n"
       "   cx: 318.25\n   cy: 241.5\n",
       {{"front", "ocam", kVga, {c * 280, 280, 318.25, 241.5, a2, a3, a4, 0, 0, 0.002 / c, -0.003}}}},
      {"colmap",
       "fisheyes",
       "1 THIN_PRISM_FISHEYE 640 480 300 301 320.5 240.5 0.01 0.02 0.001 0.002 0.003 0.004 0.0003 0.0004\n"
       "2 RAD_TAN_THIN_PRISM_FISHEYE 640 480 300 301 320.5 240.5 0.01 0.02 0.003 0.004 0.0005 0.0006 0.001 0.002 "
       "0.0003 0.0004 0.0005 0.0006\n3 DIVISION 640 480 500 501 320.5 240.5 -0.12\n4 SIMPLE_DIVISION 640 480 500 320.5 240.5 -0.12\n",
       {{"1",
         "thin_prism_fisheye",
         kVga,
         {300, 301, 320, 240, 0.01, 0.02, 0.003, 0.004, 0.001, 0.002, 0.0003, 0.0004}},
        {"2",
         "fisheye624",
         kVga,
         {300, 301, 320, 240, 0.01, 0.02, 0.003, 0.004, 0.0005, 0.0006, 0.001, 0.002, 0.0003, 0.0004, 0.0005,
          0.0006}},
        {"3", "division", kVga, {500, 501, 320, 240, -0.12, 0}},
        {"4", "division", kVga, {500, 500, 320, 240, -0.12, 0}}}},
      {"opencv",
       "a tilted sensor",
       "image_width: 640\nimage_height: 480\ncamera_matrix: [500, 0, 320, 0, 501, 240, 0, 0, 1]\ndist_coeffs: "
       "[0.1, 0.2, 0.001, 0.002, 0.03, 0.4, 0.05, 0.006, 0, 0, 0, 0, -0.025, -0.006]\n",
       {{"",
         "tilted",
         kVga,
         {500, 501, 320, 240, 0.1, 0.2, 0.001, 0.002, 0.03, 0.4, 0.05, 0.006, 0, 0, 0, 0, -0.025, -0.006}}}},
      {"ros",
       "a fisheye with skew",
       "image_width: 640\nimage_height: 480\ncamera_name: a\ndistortion_model: equidistant\ncamera_matrix: {rows: 3, "
       "cols: 3, data: [300, 3, 320, 0, 301, 240, 0, 0, 1]}\ndistortion_coefficients: {rows: 1, cols: 4, data: [-0.01, "
       "0.02, -0.03, 0.004]}\n",
       {{"a", "kannala_brandt_skew", kVga, {300, 301, 320, 240, -0.01, 0.02, -0.03, 0.004, 0.01}}}}};
}

}  // namespace

const std::vector<FormatExample>& formatExamples() {
  static const std::vector<FormatExample> kExamples = [] {
    std::vector<FormatExample> all = ownAndOpenCv();
    for (const auto& more : {kalibrColmapMrcal(), basaltAndNerfstudio(), camodocalOrbslamMatlab(),
                             ofScaramuzza(), dialectExamples(), smallExamples()})
      all.insert(all.end(), more.begin(), more.end());
    return all;
  }();
  return kExamples;
}

}  // namespace alidade
