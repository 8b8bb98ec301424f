// SPDX-License-Identifier: MIT
// Camera files that earlier versions wrote are read for ever. Add a file when the format grows; change none.
#include <filesystem>
#include <set>

#include <gmock/gmock.h>

#include "alidade/files/camera_source.h"
#include "alidade/files/formats/alidade_writer.h"
#include "support/source_tree.h"

namespace alidade {
namespace {

TEST(OldCameraFiles, AreReadForEver) {
  std::set<std::string> names;
  for (const auto& entry : std::filesystem::directory_iterator(sourcePath("testdata/camera_files"))) {
    const CameraRecord file = loadCamera(entry.path().string());
    EXPECT_EQ(file.camera.modelId(), "radtan");
    EXPECT_DOUBLE_EQ(file.camera.parameters()[0], 534.9999849684601);
    names.insert(entry.path().filename().string());
    // What is read is written again, and read as the same.
    const CameraRecord again = onlyCamera(parseCameras(cameraFileText(file), "again"));
    EXPECT_EQ(cameraFileText(again), cameraFileText(file));
    ASSERT_EQ(again.calibration.has_value(), file.calibration.has_value());
  }
  EXPECT_EQ(names, (std::set<std::string>{"version_1.yaml", "version_1_by_hand.yaml"}));
  const CameraRecord full = loadCamera(sourcePath("testdata/camera_files/version_1.yaml"));
  EXPECT_EQ(full.self_check.size(), 9U);
  EXPECT_EQ(full.calibration->num_views, 12);
  EXPECT_EQ(full.calibration->covariance.size(), 45U);
  EXPECT_EQ(full.calibration->verdict, Verdict::kTrustworthy);
}

}  // namespace
}  // namespace alidade
