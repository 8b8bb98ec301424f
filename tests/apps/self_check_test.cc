// SPDX-License-Identifier: MIT
// A camera file whose numbers were changed by hand is not computed with, whatever the command.
#include <string>
#include <vector>

#include "apps/command_line.h"

namespace alidade {
namespace {

using testing::AllOf;
using testing::HasSubstr;

// A camera file of this program with a sign flipped.
std::string slipped(const ScratchFolder& scratch) {
  const std::string text = readFile(dataPath("camera.yaml"));
  const std::size_t at = text.find("k1: -");
  EXPECT_NE(at, std::string::npos);
  std::string changed = text;
  changed.erase(at + 4, 1);
  return scratch.write("slip.yaml", changed);
}

// The file without its self-check, which is the last key or is followed by one at the line's beginning.
std::string withoutSelfCheck(std::string text) {
  const std::size_t begin = text.find("\nself_check:") + 1;
  std::size_t end = text.find('\n', begin) + 1;
  while (end < text.size() && (text[end] == ' ' || text[end] == '-')) end = text.find('\n', end) + 1;
  return text.erase(begin, end - begin);
}

TEST(SelfCheck, StopsEveryCommandThatComputes) {
  const ScratchFolder scratch;
  const std::string slip = slipped(scratch);
  const std::string good = dataPath("camera.yaml");
  scratch.write("points.csv", "x,y,z\n0.1,0.2,1\n");
  scratch.write("pixels.csv", "u,v\n100,200\n");
  scratch.write("scene.yaml",
                "alidade_scene: 1\ncamera: slip.yaml\nboard: checkerboard:9x6:25mm\nviews: {random: 1}\n");
  const std::string out = scratch.path("out");
  const std::vector<std::vector<std::string>> commands = {
      {"project", slip, scratch.path("points.csv")},
      {"unproject", slip, scratch.path("pixels.csv")},
      {"diff", slip, good},
      {"diff", good, slip},
      {"convert", slip, "-o", out},
      {"convert", slip, "-o", "-", "--to", "opencv"},
      {"convert", slip, "-o", out, "--model", "pinhole", "--keep-untrustworthy"},
      {"undistort", slip, imagePath(1), "-o", out},
      {"simulate", scratch.path("scene.yaml"), "-o", out},
      {"validate", good, "--against", slip},
  };
  int num_stopped = 0;
  for (const std::vector<std::string>& command : commands) {
    const RunResult result = runAlidade(command);
    EXPECT_THAT(
        result,
        FailsWith(
            1, AllOf(HasSubstr("slip.yaml: self_check["), HasSubstr("px away from its stated pixel ("),
                     HasSubstr("a number in the file was changed; expected a difference of at most 1e-06 px"),
                     HasSubstr("next: alidade validate "), HasSubstr("delete self_check"))))
        << command.front();
    num_stopped += result.exit_code == 1 ? 1 : 0;
    EXPECT_FALSE(scratch.has("out")) << command.front();
  }
  EXPECT_EQ(num_stopped, 10);
}

TEST(SelfCheck, IsARowOfValidate) {
  const ScratchFolder scratch;
  const RunResult result = runAlidade({"validate", slipped(scratch)});
  EXPECT_THAT(result, EndsWith(3));
  EXPECT_THAT(result.out, HasSubstr("self_check: "));
}

TEST(SelfCheck, NoticesAnotherSizeOfTheImage) {
  const ScratchFolder scratch;
  const std::string text = readFile(dataPath("camera.yaml"));
  const std::string smaller =
      scratch.write("smaller.yaml", replaced(text, "width: 640, height: 480", "width: 480, height: 640"));
  EXPECT_THAT(runAlidade({"convert", smaller, "-o", "-"}),
              FailsWith(1, AllOf(HasSubstr("smaller.yaml: self_check["),
                                 HasSubstr("outside the image of 480x640 px"))));
}

TEST(SelfCheck, IsNotMissedWhereItWasDeletedOnPurpose) {
  const ScratchFolder scratch;
  const std::string text = withoutSelfCheck(readFile(slipped(scratch)));
  ASSERT_EQ(text.find("self_check"), std::string::npos);
  const std::string path = scratch.write("bare.yaml", text);
  EXPECT_THAT(runAlidade({"convert", path, "-o", scratch.path("out.yaml")}), EndsWith(0));
}

}  // namespace
}  // namespace alidade
