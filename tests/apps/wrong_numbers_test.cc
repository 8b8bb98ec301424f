// SPDX-License-Identifier: MIT
// The slips that happen when intrinsics are copied by hand or read by another convention, and who sees them.
#include <cmath>
#include <utility>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "alidade/core/text.h"
#include "alidade/files/camera_source.h"
#include "apps/command_line.h"

namespace alidade {
namespace {

struct Slip {
  std::string name;
  AnyCamera camera;
  ImageSize image_size;
};

// Of a radtan camera.
std::vector<Slip> slipsOf(const CameraRecord& file) {
  const std::vector<double> good(file.camera.parameters().begin(), file.camera.parameters().end());
  std::vector<Slip> slips;
  const auto add = [&](const std::string& name, const auto& change) {
    std::vector<double> p = good;
    change(p);
    slips.push_back({name, AnyCamera::make("radtan", p), file.image_size});
  };
  add("p1 and p2 swapped", [](auto& p) { std::swap(p[6], p[7]); });
  add("k3 moved before p1", [](auto& p) { p = {p[0], p[1], p[2], p[3], p[4], p[5], p[8], p[6], p[7]}; });
  add("cx and cy swapped", [](auto& p) { std::swap(p[2], p[3]); });
  add("half a pixel", [](auto& p) {
    p[2] += 0.5;
    p[3] += 0.5;
  });
  add("digits cut", [](auto& p) {
    for (double& value : p) value = *parseDouble(fmt::format("{:.2g}", value));
  });
  for (std::size_t i = 4; i < good.size(); ++i)
    add(fmt::format("sign of {}", file.camera.parameterNames()[i]), [i](auto& p) { p[i] = -p[i]; });
  slips.push_back({"width and height swapped",
                   file.camera,
                   {.width = file.image_size.height, .height = file.image_size.width}});
  slips.push_back({"radtan read as fisheye",
                   AnyCamera::make("kannala_brandt", std::vector<double>(good.begin(), good.begin() + 8)),
                   file.image_size});
  return slips;
}

// Noisy corners of a camera that has all coefficients, calibrated.
std::string calibratedCamera(const ScratchFolder& scratch) {
  const std::string path = scratch.path("camera.yaml");
  EXPECT_THAT(runAlidade({"calibrate", dataPath("corners.csv"), "--model", "radtan", "-o", path}),
              EndsWith(0));
  return path;
}

TEST(WrongNumbers, AreCaughtByTheSelfCheck) {
  const ScratchFolder scratch;
  const CameraRecord good = loadCamera(calibratedCamera(scratch));
  EXPECT_THAT(runAlidade({"validate", scratch.path("camera.yaml")}), EndsWith(0));
  int num_caught = 0;
  const std::vector<Slip> slips = slipsOf(good);
  for (const Slip& slip : slips) {
    CameraRecord file = good;
    file.camera = slip.camera;
    file.image_size = slip.image_size;
    // Sigmas go by the names of the model's parameters.
    if (slip.camera.modelId() != "radtan") file.calibration.reset();
    saveCamera(scratch.path("slip.yaml"), file);
    const RunResult result = runAlidade({"validate", scratch.path("slip.yaml"), "--verbose"});
    EXPECT_THAT(result, EndsWith(3)) << slip.name;
    EXPECT_THAT(result.out, testing::HasSubstr("FAIL  self_check")) << slip.name;
    num_caught += result.exit_code == 3 ? 1 : 0;
  }
  EXPECT_EQ(num_caught, 12);
}

TEST(WrongNumbers, AreCaughtByImages) {
  const ScratchFolder scratch;
  const std::vector<double> truth = {535.123, 534.567, 322.5, 238.1, -0.28, 0.08, 0.0012, -0.0007, -0.02};
  const CameraRecord good{.camera = AnyCamera::make("radtan", truth),
                          .image_size = {.width = 640, .height = 480},
                          .domain = {},
                          .self_check = {},
                          .calibration = {},
                          .created_by = {}};
  saveCamera(scratch.path("good.yaml"), good);
  scratch.write("scene.yaml",
                "alidade_scene: 1\ncamera: good.yaml\nboard: checkerboard:9x6:25mm\nviews: {random: 30}\n"
                "corner_noise_px: 0.1\nseed: 11\n");
  ASSERT_THAT(
      runAlidade({"simulate", scratch.path("scene.yaml"), "-o", scratch.path("views"), "--corners-only"}),
      EndsWith(0));
  const auto validate = [&](const CameraRecord& file) {
    saveCamera(scratch.path("tested.yaml"), file);
    return runAlidade({"validate", scratch.path("tested.yaml"), "--images", scratch.path("views/corners.csv"),
                       "--verbose"});
  };
  EXPECT_THAT(validate(good), EndsWith(0));
  int num_caught = 0;
  int num_turns = 0;
  for (const Slip& slip : slipsOf(good)) {
    CameraRecord file = good;
    file.camera = slip.camera;
    file.image_size = slip.image_size;
    const RunResult result = validate(file);
    // Half a pixel is a turn of the camera: what is left of it is far below what the images could show.
    if (slip.name == "half a pixel") {
      const RunResult diff =
          runAlidade({"diff", scratch.path("good.yaml"), scratch.path("tested.yaml"), "--json"});
      EXPECT_LT(nlohmann::json::parse(diff.out).at("max_px").get<double>(), 0.2);
      ++num_turns;
      continue;
    }
    EXPECT_THAT(result, EndsWith(3)) << slip.name << "\n" << result.out;
    EXPECT_THAT(result.out, testing::ContainsRegex("FAIL  (held_out_error|images_agree)")) << slip.name;
    num_caught += result.exit_code == 3 ? 1 : 0;
  }
  EXPECT_EQ(num_caught, 11);
  EXPECT_EQ(num_turns, 1);
}

}  // namespace
}  // namespace alidade
