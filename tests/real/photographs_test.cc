// SPDX-License-Identifier: MIT
#include <gmock/gmock.h>

#include <algorithm>
#include <cstdio>
#include <cstdlib>
#include <filesystem>

#include "alidade/calibrate/calibrator.h"
#include "alidade/detect/detect_images.h"
#include "alidade/io/image_file.h"
#include "alidade/io/image_list.h"
#include "alidade/target/board_spec.h"

namespace alidade {
namespace {

namespace fs = std::filesystem;

// Photographs that this project does not hold: those of Debian's package opencv-doc, and a folder of public
// sets that ALIDADE_REAL_DATA names. Sets that are not there are not tested, and the first test says which.
struct PhotoSet {
  std::string name;
  std::string pattern;
  std::string board;
  int num_images;
  int min_found;
  double max_rms_px;  // of radtan, no corner dropped
  double fx;          // what other programs find on the same files, and how far they are from each other
  double fx_spread;
};

std::string publicData(const std::string& path) {
  const char* root = std::getenv("ALIDADE_REAL_DATA");
  return (root != nullptr ? std::string(root) : std::string("/nonexistent")) + "/" + path;
}

std::vector<PhotoSet> photoSets() {
  const std::string opencv = "/usr/share/doc/opencv-doc/examples/data/";
  // The limits are a little above what stock corners reach on these very files.
  return {
      {"opencv_left", opencv + "left[0-9][0-9].jpg", "checkerboard:9x6:25mm", 13, 13, 0.20, 533, 3},
      {"opencv_right", opencv + "right[0-9][0-9].jpg", "checkerboard:9x6:25mm", 13, 13, 0.21, 537.5, 3},
      {"sony_chess", publicData("sony_chess"), "checkerboard:4x6:30mm", 13, 13, 0.16, 701.5, 10},
      {"bumblebee2_left", publicData("bumblebee2_stereo_chess/left*.jpg"), "checkerboard:4x6:30mm", 11, 11,
       0.10, 525.5, 5},
      {"bumblebee2_right", publicData("bumblebee2_stereo_chess/right*.jpg"), "checkerboard:4x6:30mm", 11, 11,
       0.10, 525.5, 5},
      {"gloworm_320", publicData("photonvision_chess/gloworm_320_8x6"), "checkerboard:8x6:25.4mm", 25, 20,
       0.20, 266, 25},
  };
}

bool isThere(const PhotoSet& set) {
  return fs::exists(fs::path(set.pattern).parent_path());
}

std::vector<PhotoSet> setsThatAreThere() {
  std::vector<PhotoSet> sets = photoSets();
  std::erase_if(sets, [](const PhotoSet& set) { return !isThere(set); });
  return sets;
}

TEST(Photographs, AreFoundOrNamed) {
  const bool is_promised = std::getenv("ALIDADE_REAL_DATA") != nullptr;
  for (const PhotoSet& set : photoSets()) {
    if (isThere(set)) continue;
    std::printf("not there, so not tested: %s\n", set.name.c_str());
    const bool is_public = set.pattern.find("opencv-doc") == std::string::npos;
    EXPECT_FALSE(is_promised && is_public) << "ALIDADE_REAL_DATA is set, but has no " << set.name;
  }
}

class PhotoSetTest : public testing::TestWithParam<PhotoSet> {};
GTEST_ALLOW_UNINSTANTIATED_PARAMETERIZED_TEST(PhotoSetTest);
INSTANTIATE_TEST_SUITE_P(Photographs, PhotoSetTest, testing::ValuesIn(setsThatAreThere()),
                         [](const auto& set) { return set.param.name; });

TEST_P(PhotoSetTest, CalibratesWithinItsLimits) {
  const PhotoSet& set = GetParam();
  const std::vector<std::string> inputs = {set.pattern};
  const std::vector<std::string> images = listImages(inputs);
  ASSERT_EQ(static_cast<int>(images.size()), set.num_images);
  const Checkerboard board = parseBoardSpec(set.board);
  const auto load = [](const std::string& path) {
    LoadedImage loaded = readGrayImage(path);
    return SourceImage{.image = std::move(loaded.image), .exif_orientation = loaded.exif_orientation};
  };
  std::vector<View> views;
  for (const ImageOutcome& outcome : detectInImages(images, load, board)) {
    if (outcome.detection.found()) views.push_back({outcome.image, outcome.size, outcome.detection.corners});
  }
  EXPECT_GE(static_cast<int>(views.size()), set.min_found);
  const CalibrationResult result = calibrate(board, views);
  std::printf("%s: %zu views, RMS %.4f px, fx %.2f +- %.2f\n", set.name.c_str(), views.size(), result.rms_px,
              result.camera.parameters()[0], result.parameterStd(0));
  EXPECT_EQ(result.solver.termination, Termination::kConverged);
  EXPECT_LE(result.rms_px, set.max_rms_px);
  EXPECT_NEAR(result.camera.parameters()[0], set.fx, set.fx_spread);
  EXPECT_TRUE(result.outliers.empty());
  EXPECT_EQ(result.num_corners, static_cast<int>(views.size()) * board.numCorners());
}

}  // namespace
}  // namespace alidade
