// SPDX-License-Identifier: MIT
#include "files/formats/examples.h"

#include "alidade/files/text/atomic_file.h"
#include "support/image_sizes.h"
#include "support/source_tree.h"

namespace alidade {
namespace {

const std::vector<double> kRadtan = {500, 501, 320, 240, -0.1, 0.02, 0.001, 0.002, 0.03};
const std::vector<double> kFisheye = {300, 301, 320, 240, -0.01, 0.02, -0.03, 0.004};

FormatExample ofFile(std::string_view format, const std::string& extension,
                     std::vector<ExampleCamera> cameras, std::vector<std::string> remarks = {}) {
  const std::string path = sourcePath("docs/examples/formats/" + std::string(format) + extension);
  return {format, "the file in docs", readBinaryFile(path, 1U << 20U), std::move(cameras),
          std::move(remarks)};
}

std::vector<FormatExample> ofRobotics() {
  constexpr ImageSize kTum{.width = 1280, .height = 1024};
  constexpr ImageSize kKitti{.width = 1392, .height = 512};
  constexpr ImageSize kDepth{.width = 1024, .height = 1024};
  constexpr ImageSize kColor{.width = 4096, .height = 3072};
  return {
      ofFile("photonvision", ".json",
             {{"", "rational", kVga, {500, 501, 320, 240, 0.1, 0.2, 0.001, 0.002, 0.03, 0.4, 0.05, 0.006}}}),
      ofFile("autoware", ".yaml", {{"", "radtan", kVga, kRadtan}}, {"not_carried"}),
      ofFile("vikit", ".yaml",
             {{"", "fov", kVga, {0.5 * 640, 0.7 * 480, 0.49 * 640 - 0.5, 0.51 * 480 - 0.5, 0.93}}}),
      ofFile("aslam", ".yaml",
             {{"cam0", "radtan", kVga, {500, 501, 320, 240, -0.1, 0.02, 0.001, 0.002, 0}},
              {"cam1", "omni", kVga, {900, 901, 320, 240, 1.3, -0.1, 0.05, 0.001, -0.002}}}),
      ofFile("kitti", ".txt",
             {{"00",
               "radtan",
               kKitti,
               {984.2439, 980.8141, 690, 233.1966, -0.3728755, 0.2037299, 2.219027e-3, 1.383707e-3,
                -0.07233722}},
              {"01",
               "radtan",
               kKitti,
               {989.5267, 987.8386, 702, 245.559, -0.3644661, 0.1790019, 1.148107e-3, -6.298563e-4,
                -0.05314062}}}),
      ofFile("kitti_odometry", ".txt",
             {{"0", "pinhole", kVga, {718.856, 718.856, 607.1928, 185.2157}},
              {"1", "pinhole", kVga, {718.856, 718.856, 607.1928, 185.2157}}}),
      ofFile("azure_kinect", ".json",
             {{"D0",
               "rational",
               kDepth,
               {0.48 * 1024, 0.485 * 1024, 0.5 * 1024 - 0.5, 0.49 * 1024 - 0.5, 4.7, 3.2, 0.00002, 0.0001,
                0.17, 5.0, 4.8, 0.88}},
              {"PV0",
               "rational",
               kColor,
               {0.48 * 4096, 0.64 * 3072, 0.51 * 4096 - 0.5, 0.52 * 3072 - 0.5, 0.4, -2.6, 0.0009, -0.00004,
                1.5, 0.28, -2.4, 1.43}}}),
      ofFile("realsense", ".json",
             {{"color", "radtan", kVga, kRadtan},
              {"depth", "inverse_brown", kVga, {380, 380, 321, 241, 0, 0, 0, 0, 0}}}),
      ofFile("dso", ".txt",
             {{"",
               "fov",
               kTum,
               {0.535719308086809 * 1280, 0.669566858850269 * 1024, 0.493248545285398 * 1280 - 0.5,
                0.500408664348414 * 1024 - 0.5, 0.897966326944875}}}),
      ofFile("zed", ".conf",
             {{"LEFT_CAM_2K",
               "radtan",
               {2208, 1242},
               {1400.5, 1400.25, 1080.5, 625.75, -0.17, 0.027, -6.1e-5, 1.6e-5, -0.001}},
              {"LEFT_CAM_HD",
               "radtan",
               {1280, 720},
               {699.5, 699.25, 626.75, 360.9, -0.17, 0.027, -6.1e-5, 1.6e-5, 0}},
              {"RIGHT_CAM_2K",
               "radtan",
               {2208, 1242},
               {1402.5, 1402.25, 1157.5, 590.75, -0.171, 0.0255, 0.00034, 4.9e-5, 0}}},
             {"not_carried"})};
}

std::vector<FormatExample> ofVision() {
  return {
      ofFile("mc_calib", ".yaml",
             {{"camera_0", "radtan", kVga, kRadtan}, {"camera_1", "kannala_brandt", kVga, kFisheye}}),
      ofFile("multical", ".json",
             {{"left", "radtan", kVga, kRadtan},
              {"right",
               "rational",
               kVga,
               {510, 511, 321, 241, 0.1, 0.2, 0.001, 0.002, 0.03, 0.4, 0.05, 0.006}}}),
      ofFile("easymocap", ".yaml",
             {{"01", "radtan", kVga, kRadtan},
              {"02", "radtan", kVga, {510, 511, 321, 241, -0.2, 0.03, 0.002, 0.001, 0.01}}}),
      ofFile(
          "opensfm", ".json",
          {{"v2 a phone",
            "radtan",
            kVga,
            {0.8 * 640, 0.81 * 640, 0.01 * 640 + 320 - 0.5, -0.02 * 640 + 240 - 0.5, -0.1, 0.02, 0.001, 0.002,
             0.03}},
           {"v2 another", "radtan", kVga, {512, 512, 319.5, 239.5, -0.1, 0.02, 0, 0, 0}},
           {"v2 an action camera", "kannala_brandt", {480, 640}, {320, 320, 239.5, 319.5, -0.01, 0.02, 0, 0}},
           {"v2 a fisheye",
            "kannala_brandt",
            kVga,
            {0.5 * 640, 0.51 * 640, 0.01 * 640 + 320 - 0.5, -0.02 * 640 + 240 - 0.5, -0.01, 0.02, -0.03,
             0.004}}}),
      ofFile("boofcv", ".yaml",
             {{"", "radtan", kVga, {500, 501, 319.5, 239.5, -0.1, 0.02, 0.001, 0.002, 0}}}),
      ofFile("gyroflow", ".json",
             {{"A camera_a lens_1080p",
               "kannala_brandt",
               kVga,
               {300, 301, 320.5, 241, -0.01, 0.02, -0.03, 0.004}}}),
      ofFile("caliscope", ".toml", {{"0", "radtan", kVga, kRadtan}, {"1", "kannala_brandt", kVga, kFisheye}}),
      {"caliscope",
       "aniposelib",
       R"([cam_0]
name = "A"
size = [ 640, 480,]
matrix = [ [ 500.0, 0.0, 320.0,], [ 0.0, 501.0, 240.0,], [ 0.0, 0.0, 1.0,],]
distortions = [ -0.1, 0.02, 0.001, 0.002, 0.03,]
rotation = [ 0.0, 0.0, 0.0,]
translation = [ 0.0, 0.0, 0.0,]

[metadata]
adjusted = true
error = 0.3
)",
       {{"A", "radtan", kVga, kRadtan}}},
      ofFile("bouguet", ".mat", {{"", "radtan", kVga, kRadtan}}),
      ofFile("flat", ".json", {{"", "radtan", kVga, kRadtan}}),
      ofFile("flat_keys", ".yaml",
             {{"", "radtan", kVga, {500, 501, 320, 240, -0.1, 0.02, 0.001, 0.002, 0}}})};
}

std::vector<FormatExample> ofVehicles() {
  constexpr ImageSize kWoodScape{.width = 1280, .height = 966};
  constexpr ImageSize kDrive{.width = 1920, .height = 1208};
  return {ofFile("metashape", ".xml",
                 {{"",
                   "brown",
                   kVga,
                   {501.25, 500, 321, 237.25, -0.1, 0.02, 0.002, 0.001, 0.03, -0.004, -0.5 / 501.25}}}),
          ofFile("woodscape", ".json",
                 {{"FV",
                   "ftheta",
                   kWoodScape,
                   {340, 340 * 1.01, 643, 480.25, -32.0 / 340, 48.0 / 340, -7.2 / 340, 0, 0}}}),
          ofFile("driveworks", ".json",
                 {{"camera:front:wide",
                   "ftheta_inverse",
                   kDrive,
                   {1000, 1000, 963.5, 602.25, -2e-3, 0.03, 4e-3, 0, 0}},
                  {"camera:rear",
                   "ftheta",
                   kDrive,
                   {950, 950, 959.5, 603.5, -3.0 / 950, -12.0 / 950, 2.0 / 950, 0, 0}}},
                 {"not_carried", "assumed"}),
          ofFile("aria", ".jsonl",
                 {{"camera-slam-left",
                   "fisheye624",
                   kVga,
                   {240, 240, 318.5, 239.25, -0.02, 0.1, -0.07, 0.012, 0.002, -0.0006, 0.0007, 0.0003, 0.0002,
                    -0.0001, -0.0003, 0.0004}}},
                 {"not_carried", "assumed"}),
          ofFile("oak", ".json",
                 {{"CAM_A",
                   "thin_prism",
                   kVga,
                   {500, 501, 320, 240, 0.1, 0.2, 0.001, 0.002, 0.03, 0.4, 0.05, 0.006, 0, 0, 0, 0}},
                  {"CAM_B", "kannala_brandt", kVga, kFisheye}},
                 {"not_carried"})};
}

}  // namespace

std::vector<FormatExample> smallExamples() {
  std::vector<FormatExample> all = ofRobotics();
  for (const FormatExample& example : ofVehicles()) all.push_back(example);
  for (const FormatExample& example : ofVision()) all.push_back(example);
  return all;
}

}  // namespace alidade
