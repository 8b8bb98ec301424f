// SPDX-License-Identifier: MIT
#include "alidade/files/camera_source.h"

#include <algorithm>
#include <filesystem>
#include <string>
#include <vector>

#include <gmock/gmock.h>

#include "alidade/files/formats/camera_format.h"
#include "support/scratch_test.h"

namespace alidade {
namespace {

class SaveCamera : public ScratchTest {
 protected:
  CameraRecord record_ =
      bareRecord(AnyCamera::make("radtan", std::vector<double>{500, 501, 320, 240, -0.25, 0.0625, 0, 0, 0}),
                 {640, 480}, "test");
};

TEST_F(SaveCamera, IsReadBackInEveryFormatThatHoldsTheModel) {
  int num_formats = 0;
  for (const CameraFormat* format : cameraFormats()) {
    if (!format->write || std::ranges::find(format->models, "radtan") == format->models.end()) continue;
    const std::string file = path(std::string(format->id) + ".yaml");
    saveCamera(file, record_, format->id);
    const CameraSource source = loadCameras(file);
    EXPECT_EQ(source.format, format->id);
    ASSERT_EQ(source.cameras.size(), 1U);
    EXPECT_TRUE(std::ranges::equal(source.cameras.front().camera.parameters(), record_.camera.parameters()));
    ++num_formats;
  }
  EXPECT_EQ(num_formats, 11);
}

TEST_F(SaveCamera, KeepsTheWholeRecordInItsOwnFormatOnly) {
  record_.calibration.emplace();
  record_.calibration->rms_px = 0.25;
  saveCamera(path("own.yaml"), record_);
  EXPECT_EQ(loadCamera(path("own.yaml")).calibration->rms_px, 0.25);
  saveCamera(path("ros.yaml"), record_, "ros");
  EXPECT_FALSE(loadCamera(path("ros.yaml")).calibration.has_value());
}

TEST_F(SaveCamera, RefusesAFormatThatDoesNotExistOrCannotHoldTheCamera) {
  EXPECT_THROW(saveCamera(path("a.yaml"), record_, "other"), Error);
  record_.camera = AnyCamera::make("double_sphere", std::vector<double>{300, 300, 320, 240, -0.2, 0.6});
  EXPECT_THROW(saveCamera(path("a.yaml"), record_, "matlab"), Error);
  EXPECT_FALSE(std::filesystem::exists(path("a.yaml")));
}

}  // namespace
}  // namespace alidade
