// SPDX-License-Identifier: MIT
// The camera file does not depend, to the last byte, on the number of threads, the order of the inputs, or
// whether detection ran apart.
#include <algorithm>
#include <sstream>

#include "apps/command_line.h"

namespace alidade {
namespace {

using testing::HasSubstr;

std::vector<std::string> linesOf(const std::string& text) {
  std::vector<std::string> lines;
  std::istringstream in(text);
  for (std::string line; std::getline(in, line);) lines.push_back(line);
  return lines;
}

std::string joined(const std::vector<std::string>& lines) {
  std::string text;
  for (const std::string& line : lines) text += line + "\n";
  return text;
}

// The camera file that a command writes to standard output.
std::string cameraFile(std::vector<std::string> args) {
  args.insert(args.begin(), "calibrate");
  args.insert(args.end(), {"-o", "-", "--quiet", "--keep-untrustworthy"});
  const RunResult result = runAlidade(args);
  EXPECT_TRUE(result.exit_code == 0 || result.exit_code == 3) << result.err;
  EXPECT_THAT(result.out, HasSubstr("alidade_camera: 1\n"));
  return result.out;
}

// Rows of a corners file, comments and header aside, view by view in another order.
std::string withViewsReversed(const std::string& corners) {
  std::vector<std::string> head;
  std::vector<std::vector<std::string>> views;
  std::string last;
  for (const std::string& line : linesOf(corners)) {
    if (line.starts_with('#') || line.starts_with("camera,image,")) {
      head.push_back(line);
      continue;
    }
    const std::string image = line.substr(0, line.find(',', line.find(',') + 1));
    if (views.empty() || image != last) views.emplace_back();
    last = image;
    views.back().push_back(line);
  }
  EXPECT_EQ(views.size(), static_cast<std::size_t>(kNumImages));
  std::reverse(views.begin(), views.end());
  std::string text = joined(head);
  for (const auto& view : views) text += joined(view);
  return text;
}

// Models whose search goes by several shapes of the lens have more work to share out, and one that these
// views do not determine is held together besides.
TEST(SameBytes, ForAnyNumberOfThreads) {
  int num_compared = 0;
  for (const char* model : {"pinhole", "radtan", "rational", "kannala_brandt", "omni", "double_sphere"}) {
    const std::string one = cameraFile({dataPath("corners.csv"), "--model", model, "--jobs", "1"});
    for (const char* jobs : {"2", "8", "0"}) {
      EXPECT_EQ(cameraFile({dataPath("corners.csv"), "--model", model, "--jobs", jobs}), one)
          << model << ", " << jobs;
      ++num_compared;
    }
  }
  EXPECT_EQ(num_compared, 6 * 3);
}

TEST(SameBytes, ForAnyOrderOfTheViewsInACornersFile) {
  const ScratchFolder scratch;
  const std::string reversed =
      scratch.write("corners.csv", withViewsReversed(readFile(dataPath("corners.csv"))));
  int num_compared = 0;
  for (const char* model : {"radtan", "omni"}) {
    EXPECT_EQ(cameraFile({reversed, "--model", model}),
              cameraFile({dataPath("corners.csv"), "--model", model}))
        << model;
    ++num_compared;
  }
  EXPECT_EQ(num_compared, 2);
}

TEST(SameBytes, FromImagesAndFromTheirCorners) {
  const ScratchFolder scratch;
  const std::string photos = linkImages(scratch, "photos", 6);
  const std::string corners = scratch.path("corners.csv");
  ASSERT_THAT(runAlidade({"detect", photos, "--board", kBoardSpec, "-o", corners}), EndsWith(0));
  const std::string at_once = cameraFile({photos, "--board", kBoardSpec, "--jobs", "2"});
  EXPECT_EQ(cameraFile({corners}), at_once);
  EXPECT_THAT(at_once, HasSubstr("view_centers:"));
}

}  // namespace
}  // namespace alidade
