// SPDX-License-Identifier: MIT
// One camera of many is read without making the others, and no damage of theirs is passed over.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "alidade/files/camera_source.h"
#include "files/formats/reading.h"

namespace alidade {
namespace {

using testing::HasSubstr;

const std::string kLines =
    "1 PINHOLE 640 480 500 501 320 240\n"
    "2 OPENCV 640 480 500 501 320.5 240.5 -0.1 0.02 0.001 0.002\n"
    "3 EQUIRECTANGULAR 640 480 0\n";

ReadOptions only(const std::string& name) {
  return {.image_size = {}, .model = "", .only = name};
}

TEST(ColmapFiles, OfManyCamerasGiveTheOneThatIsNamed) {
  const CameraSource all = parseCameras(kLines, "file");
  ASSERT_EQ(all.cameras.size(), 2u);
  for (const StatedCamera& expected : all.cameras) {
    const CameraSource source = parseCameras(kLines, "file", only(expected.name));
    ASSERT_EQ(source.cameras.size(), 1u);
    const StatedCamera& camera = source.cameras.front();
    EXPECT_EQ(camera.name, expected.name);
    EXPECT_EQ(camera.number, expected.number);
    EXPECT_EQ(camera.camera.modelId(), expected.camera.modelId());
    EXPECT_THAT(camera.camera.parameters(), testing::ElementsAreArray(expected.camera.parameters()));
    EXPECT_EQ(camera.image_size, expected.image_size);
    EXPECT_TRUE(source.refused.empty());
  }
  EXPECT_TRUE(parseCameras(kLines, "file", only("7")).cameras.empty());
  EXPECT_THAT(complaintAbout(kLines, only("3")), HasSubstr("file:3: found the camera model EQUIRECTANGULAR"));
}

TEST(ColmapFiles, WithDamageInAnotherCameraAreRefused) {
  int num_refused = 0;
  for (const std::string line :
       {"4 OPENCV 640 480 500 501 320 240\n", "4 PINHOLE 640 480 -500 501 320 240\n",
        "4 PINHOLE 0 480 500 501 320 240\n", "4 PINHOLE 640 480 nan 501 320 240\n",
        "4 FOV 640 480 500 501 320 240 -1\n", "2 PINHOLE 640 480 500 501 320 240\n"}) {
    const std::string of_all = complaintAbout(kLines + line);
    EXPECT_NE(of_all, "") << line;
    EXPECT_THAT(of_all, testing::Not(HasSubstr("THIN_PRISM")));  // which is no damage
    EXPECT_EQ(complaintAbout(kLines + line, only("1")), of_all) << line;
    ++num_refused;
  }
  EXPECT_EQ(num_refused, 6);
}

}  // namespace
}  // namespace alidade
