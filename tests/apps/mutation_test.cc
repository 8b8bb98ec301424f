// SPDX-License-Identifier: MIT
// Damaged files: whatever the bytes, the readers accept them or complain with an Error, and nothing else.
#include <optional>

#include "alidade/core/error.h"
#include "alidade/files/camera_source.h"
#include "alidade/files/corners_file.h"
#include "alidade/files/pose_list.h"
#include "alidade/files/scene_file.h"
#include "apps/command_line.h"
#include "support/mutator.h"
#include "support/source_tree.h"

namespace alidade {
namespace {

constexpr int kNumRuns = 3000;
struct Counts {
  int read = 0;
  int refused = 0;
};

template <class Read>
Counts readMutations(const std::string& good, std::uint32_t seed, const Read& read) {
  EXPECT_NO_THROW(read(good));
  Mutator mutate(seed);
  Counts counts;
  for (int run = 0; run < kNumRuns; ++run) {
    const std::string text = mutate(good);
    try {
      read(text);
      ++counts.read;
    } catch (const Error& error) {
      ++counts.refused;
      EXPECT_NE(error.code(), ErrorCode::kVerdict);
      EXPECT_STRNE(error.what(), "");
    } catch (const std::exception& error) {
      ADD_FAILURE() << "run " << run << ": " << error.what() << "\n" << text;
    }
  }
  EXPECT_EQ(counts.read + counts.refused, kNumRuns);
  return counts;
}

TEST(Mutations, OfACameraFileNeverSurprise) {
  const Counts counts =
      readMutations(readFile(dataPath("camera.yaml")) +
                        "calibration:\n  rms_px: 0.1\n  num_views: 3\n  num_corners: 162\n" +
                        "  board: checkerboard:9x6:25mm\n  findings: [a, b]\n",
                    1, [](const std::string& text) { (void)onlyCamera(parseCameras(text, "camera.yaml")); });
  EXPECT_GT(counts.read, kNumRuns / 30);
  EXPECT_GT(counts.refused, kNumRuns / 4);
}

TEST(Mutations, OfACornersFileNeverSurprise) {
  const std::string all = readFile(dataPath("corners.csv"));
  const std::string two_views = all.substr(0, all.find("camera,view_003.png"));
  const Counts counts = readMutations(
      two_views, 2, [](const std::string& text) { (void)parseCornersFile(text, "corners.csv"); });
  EXPECT_GT(counts.read, kNumRuns / 30);
  EXPECT_GT(counts.refused, kNumRuns / 4);
}

TEST(Mutations, OfASceneNeverSurprise) {
  for (const char* name : {"config/scene.yaml", "config/footage.yaml"}) {
    const Counts counts = readMutations(readFile(sourcePath(name)), 3, [](const std::string& text) {
      (void)parseSceneFile(text, "scene.yaml");
    });
    EXPECT_GT(counts.read, kNumRuns / 30) << name;
    EXPECT_GT(counts.refused, kNumRuns / 4) << name;
  }
}

TEST(Mutations, OfPosesNeverSurprise) {
  const std::vector<std::string> files = {
      "- {id: a, camera_from_world: {quaternion_xyzw: [0, 0, 0, 1], translation_m: [0, 0, 1]}}\n"
      "- {id: b, rotation_vector_rad: [0, 0.1, 0], translation_m: [0, 0, 2]}\n",
      "# timestamp tx ty tz qx qy qz qw\n1305031102.17 0.1 0 -2 0 0 0 1\n1305031102.20 0 0 -2 0.6 0 0 0.8\n",
      "name;tx [m];ty;tz;rx;ry;rz\n\"a;b\";0;0;1;0;0.1;0\nc;0;0;2;0;0;0.5\n",
  };
  std::uint32_t num_files = 0;
  for (const std::string& file : files) {
    const auto direction = num_files == 2 ? "camera_from_world" : "";
    const Counts counts = readMutations(
        file, 4 + num_files, [&](const std::string& text) { (void)parsePoseList(text, "poses", direction); });
    EXPECT_GT(counts.read, kNumRuns / 100);  // short files without much that may change
    EXPECT_GT(counts.refused, kNumRuns / 30);
    ++num_files;
  }
  EXPECT_EQ(num_files, 3u);
}

}  // namespace
}  // namespace alidade
