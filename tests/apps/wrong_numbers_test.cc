// SPDX-License-Identifier: MIT
// The slips that happen when intrinsics are copied by hand or read by another convention, and who sees them.
#include <cmath>
#include <utility>

#include <fmt/format.h>

#include "alidade/core/text.h"
#include "alidade/io/camera_file.h"
#include "apps/command_line.h"

namespace alidade {
namespace {

struct Slip {
  std::string name;
  AnyCamera camera;
  ImageSize image_size;
};

// Of a radtan camera.
std::vector<Slip> slipsOf(const CameraFile& file) {
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
    for (double& value : p) value = *parseDouble(fmt::format("{:.3g}", value));
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
  const CameraFile good = readCameraFile(calibratedCamera(scratch));
  EXPECT_THAT(runAlidade({"validate", scratch.path("camera.yaml")}), EndsWith(0));
  int num_caught = 0;
  const std::vector<Slip> slips = slipsOf(good);
  for (const Slip& slip : slips) {
    CameraFile file = good;
    file.camera = slip.camera;
    file.image_size = slip.image_size;
    // Sigmas go by the names of the model's parameters.
    if (slip.camera.modelId() != "radtan") file.calibration.reset();
    writeCameraFile(scratch.path("slip.yaml"), file);
    const RunResult result = runAlidade({"validate", scratch.path("slip.yaml")});
    EXPECT_THAT(result, EndsWith(3)) << slip.name;
    EXPECT_THAT(result.out, testing::HasSubstr("FAIL  self_check")) << slip.name;
    num_caught += result.exit_code == 3 ? 1 : 0;
  }
  EXPECT_EQ(num_caught, 12);
}

}  // namespace
}  // namespace alidade
