// SPDX-License-Identifier: MIT
// Cameras that were calibrated with a board, and wrong ones, on photographs of ordinary scenes: BoofCV's
// chair and wall, and stills of the sequence freiburg2_desk of the TUM RGB-D benchmark.
#include <algorithm>
#include <array>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

#include <gtest/gtest.h>

#include "alidade/camera/any_camera.h"
#include "alidade/footage/check/camera_check.h"
#include "alidade/footage/follow/footage_frames.h"

namespace alidade {
namespace {

namespace fs = std::filesystem;

constexpr std::array kFiles = {"as calibrated", "focal length x 0.9", "focal length x 1.1", "no distortion"};

AnyCamera wrongCamera(std::vector<double> params, std::size_t file) {
  for (std::size_t i = 0; i < params.size(); ++i) {
    if (file == 1 && i < 2) params[i] *= 0.9;
    if (file == 2 && i < 2) params[i] *= 1.1;
    if (file == 3 && i >= 4) params[i] = 0;
  }
  return AnyCamera::make("radtan", params);
}

std::vector<std::string> pathsThatBegin(const std::string& begin) {
  std::vector<std::string> paths;
  const fs::path folder = fs::path(begin).parent_path();
  if (!fs::exists(folder)) return paths;
  for (const auto& entry : fs::directory_iterator(folder)) {
    if (entry.path().string().starts_with(begin)) paths.push_back(entry.path().string());
  }
  std::sort(paths.begin(), paths.end());
  return paths;
}

struct Footage {
  std::string images;  // how their paths begin, below the folder of footage
  std::vector<double> params;
  std::array<std::string_view, kFiles.size()> verdicts;  // of kFiles
};

TEST(Footage, TellsWrongCamerasFromCalibratedOnes) {
  const char* root = std::getenv("ALIDADE_REAL_DATA");
  if (root == nullptr) GTEST_SKIP() << "no photographs";
  // The wall is one plane, the desk ten stills with little in common: they show some errors, and never that
  // there is none.
  const std::vector<Footage> all = {{"boofcv_chair/image",
                                     {477.1153682877197, 478.4056498615274, 317.3166700073147,
                                      241.06065005426453, 0.01748195441951721, 0.045233434344806055, 0, 0, 0},
                                     {"consistent", "inconsistent", "inconsistent", "inconsistent"}},
                                    {"tum_fr2_desk_stills/ch12/",
                                     {520.9, 521.0, 325.1, 249.7, 0.2312, -0.7849, -0.0033, -0.0001, 0.9172},
                                     {"cannot_tell", "inconsistent", "cannot_tell", "cannot_tell"}},
                                    {"boofcv_sony_wall_jar/mono_wall_",
                                     {701.0116882676376, 698.6537946928421, 308.4551818095542,
                                      246.84300560315452, -0.25559248570886445, 0.09997127476560613, 0, 0, 0},
                                     {"cannot_tell", "cannot_tell", "cannot_tell", "inconsistent"}}};
  int num_checked = 0;
  for (const Footage& footage : all) {
    const std::vector<std::string> inputs = pathsThatBegin(std::string(root) + "/footage/" + footage.images);
    if (inputs.empty()) continue;
    FootagePass pass;
    const FootageTracks tracks = trackFootage(inputs, FrontEndKind::kKeyPoints, pass);
    for (std::size_t file = 0; file < kFiles.size(); ++file) {
      const FootageCheck check = checkOnFootage(wrongCamera(footage.params, file), tracks);
      const std::string_view verdict = verdictId(check.verdict);
      std::printf("%s, %s: %s %s %s\n", footage.images.c_str(), kFiles.at(file), std::string(verdict).c_str(),
                  std::string(gapId(check.gap)).c_str(),
                  check.explanation ? describe(check.changes[*check.explanation]).c_str() : "");
      EXPECT_EQ(verdict, footage.verdicts.at(file)) << footage.images << ", " << kFiles.at(file);
      ++num_checked;
    }
  }
  EXPECT_EQ(num_checked, 12);
}

}  // namespace
}  // namespace alidade
