// SPDX-License-Identifier: MIT
#include "alidade/io/camera_file.h"

#include <cmath>

#include <gmock/gmock.h>

namespace alidade {
namespace {

// As a fisheye has them in the corners of its image.
TEST(CameraFile, ReadsBackAGridWithPixelsWithoutARay) {
  const double nan = std::numeric_limits<double>::quiet_NaN();
  CameraFile file{.camera = AnyCamera::make("pinhole", std::vector<double>{500, 500, 320, 240}),
                  .image_size = {.width = 640, .height = 480},
                  .domain = {},
                  .self_check = {},
                  .calibration = CalibrationRecord{},
                  .created_by = ""};
  file.calibration->projection_std = ProjectionStdRecord{.center_px = nan,
                                                         .worst_px = 2,
                                                         .worst_pixel = {639, 0},
                                                         .columns = 2,
                                                         .rows = 2,
                                                         .std_px = {nan, 2, 1, nan}};
  const std::string text = cameraFileText(file);
  EXPECT_THAT(text, testing::HasSubstr("std_px: [~, 2, 1, ~]"));
  int num_read = 0;
  // Early files had the word in quotes.
  std::string quoted = text;
  for (std::size_t at = 0; (at = quoted.find('~', at)) != std::string::npos; at += 6)
    quoted.replace(at, 1, "\"null\"");
  for (const std::string& written : {text, quoted}) {
    const CameraFile back = parseCameraFile(written, "camera.yaml");
    const auto& std_px = back.calibration->projection_std->std_px;
    ASSERT_EQ(std_px.size(), 4u);
    EXPECT_TRUE(std::isnan(std_px[0]) && std::isnan(std_px[3]));
    EXPECT_EQ(std_px[1], 2);
    EXPECT_TRUE(std::isnan(back.calibration->projection_std->center_px));
    ++num_read;
  }
  EXPECT_EQ(num_read, 2);
}

}  // namespace
}  // namespace alidade
