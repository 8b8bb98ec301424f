// SPDX-License-Identifier: MIT
#include <filesystem>

#include <unistd.h>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "apps/command_line.h"

namespace alidade {
namespace {

namespace fs = std::filesystem;
using testing::AllOf;
using testing::ElementsAre;
using testing::HasSubstr;

std::vector<std::string> calibrateLine(const std::vector<std::string>& inputs, const std::string& output) {
  std::vector<std::string> args = {"calibrate", "--verbose", "--board", kBoardSpec, "-o", output};
  args.insert(args.end(), inputs.begin(), inputs.end());
  return args;
}

TEST(Inputs, NamesWhatIsWrongWithAFolder) {
  const ScratchFolder scratch;
  scratch.makeFolder("empty");
  scratch.write("notes/readme.txt", "no image");
  linkImages(scratch, "photos", 3);
  const std::string output = scratch.path("camera.yaml");
  const auto before = scratch.list();
  struct Case {
    std::string input;
    std::string found;
    std::string next;
  };
  const std::vector<Case> cases = {
      {"empty", "it is empty", "give the folder that contains the images"},
      {"notes", "contains 1 file, readme.txt", "give the folder that contains the images"},
      {"photo", "no such file or folder", "did you mean '" + scratch.path("photos") + "'?"},
      {"photos/view_01.png", "no such file", "did you mean '" + scratch.path("photos/view_001.png") + "'?"},
      {"photos/*.jpg", "no file matches", "check the pattern"},
      {"notes/readme.txt/a.png", "is a file, not a folder", "check the path"},
      {"", "a folder without images", "one level below"},
  };
  int num_refused = 0;
  for (const Case& c : cases) {
    const std::string input = scratch.path(c.input);
    for (const auto& args :
         {calibrateLine({input}, output),
          std::vector<std::string>{"detect", input, "--board", kBoardSpec, "-o", output}}) {
      EXPECT_THAT(runAlidade(args),
                  FailsWith(1, AllOf(HasSubstr(input), HasSubstr(c.found), HasSubstr(c.next))));
      ++num_refused;
    }
  }
  EXPECT_EQ(num_refused, 14);
  EXPECT_EQ(scratch.list(), before);
}

TEST(Inputs, NamesWhatCannotBeReadForLackOfPermission) {
  const ScratchFolder scratch;
  linkImages(scratch, "closed", 4);
  fs::permissions(scratch.path("closed"), fs::perms::none);
  const RunResult result = runAlidade(calibrateLine({scratch.path("closed")}, scratch.path("camera.yaml")));
  fs::permissions(scratch.path("closed"), fs::perms::owner_all);
  if (::geteuid() == 0) {  // reads everything
    EXPECT_THAT(result, EndsWith(0));
  } else {
    EXPECT_THAT(result,
                FailsWith(1, AllOf(HasSubstr(scratch.path("closed")), HasSubstr("Permission denied"))));
  }
}

struct BadImage {
  std::string name;
  std::string bytes;
  std::string reason;
};

std::vector<BadImage> badImages() {
  const std::string good = readFile(imagePath(1));
  return {{"view_101.png", "", "0 bytes"},
          {"view_102.png", good.substr(0, good.size() / 2), "truncated"},
          {"view_103.jpg", "hello, this is text\n", "not an image"}};
}

TEST(Inputs, RefusesAnImageThatCannotBeRead) {
  const ScratchFolder scratch;
  const std::string output = scratch.path("camera.yaml");
  int num_refused = 0;
  for (const BadImage& bad : badImages()) {
    const std::string path = scratch.write(bad.name, bad.bytes);
    const auto refusal = FailsWith(1, AllOf(HasSubstr(path), HasSubstr(bad.reason), HasSubstr("\n  next: ")));
    EXPECT_THAT(runAlidade(calibrateLine({path}, output)), refusal);
    EXPECT_THAT(runAlidade({"detect", path, "--board", kBoardSpec, "-o", output}), refusal);
    num_refused += 2;
  }
  EXPECT_EQ(num_refused, 6);
  EXPECT_THAT(runAlidade(calibrateLine({scratch.path()}, output)),
              FailsWith(1, AllOf(HasSubstr("3 images: none of them can be read; the first error: "),
                                 HasSubstr("\n  next: "))));
  EXPECT_THAT(scratch.list(), ElementsAre("view_101.png", "view_102.png", "view_103.jpg"));
}

TEST(Inputs, SkipsImagesThatCannotBeReadAndNamesThem) {
  const ScratchFolder scratch;
  linkImages(scratch, "photos", 8);
  int num_bad = 0;
  for (const BadImage& bad : badImages()) {
    scratch.write("photos/" + bad.name, bad.bytes);
    ++num_bad;
  }
  ASSERT_EQ(num_bad, 3);
  const RunResult result = runAlidade(calibrateLine({scratch.path("photos")}, scratch.path("camera.yaml")));
  ASSERT_THAT(result, EndsWith(0));
  EXPECT_THAT(result.out, HasSubstr("11 given, 8 with the board, 8 used"));
  for (const BadImage& bad : badImages())
    EXPECT_THAT(result.out, AllOf(HasSubstr("\n  " + bad.name + ": unreadable"), HasSubstr(bad.reason)))
        << result.out;
  EXPECT_TRUE(scratch.has("camera.yaml"));

  // The reasons stay comments of the corners file, which reads back.
  const std::string corners = scratch.path("corners.csv");
  ASSERT_THAT(runAlidade({"detect", scratch.path("photos"), "--board", kBoardSpec, "-o", corners}),
              EndsWith(0));
  for (const BadImage& bad : badImages())
    EXPECT_THAT(scratch.read("corners.csv"), HasSubstr("\n# " + bad.name + ",unreadable,"));
  EXPECT_THAT(runAlidade({"calibrate", corners}), EndsWith(0));
}

TEST(Inputs, TakesNamesOfAnyBytesButLineBreaks) {
  const ScratchFolder scratch;
  const std::string folder = scratch.makeFolder("photos");
  const std::vector<std::string> names = {"latin\xE9.png", "comma, quote\" #.png", "b lank.png", "-dash.png"};
  int image = 0;
  for (const std::string& name : names) fs::create_symlink(imagePath(++image), fs::path(folder) / name);
  fs::create_symlink(imagePath(++image), fs::path(folder) / "two\nlines.png");
  ASSERT_EQ(image, 5);

  const std::string corners = scratch.path("corners.csv");
  const RunResult detected = runAlidade({"detect", folder, "--board", kBoardSpec, "-o", corners, "--json"});
  ASSERT_THAT(detected, EndsWith(0));
  EXPECT_THAT(detected.err, AllOf(HasSubstr("4 of 5 images"), HasSubstr("a line break in the name")));
  const auto document = nlohmann::json::parse(detected.out);
  EXPECT_EQ(document.at("images").size(), 5u);

  const RunResult calibrated =
      runAlidade({"calibrate", corners, "--json", "-o", scratch.path("camera.yaml")});
  ASSERT_THAT(calibrated, EndsWith(0));
  EXPECT_EQ(nlohmann::json::parse(calibrated.out).at("views").size(), 4u);
  EXPECT_THAT(calibrated.out, HasSubstr("\"latin"));
  EXPECT_THAT(runAlidade({"validate", scratch.path("camera.yaml")}), EndsWith(0));

  const RunResult direct = runAlidade(calibrateLine({folder}, scratch.path("direct.yaml")));
  ASSERT_THAT(direct, EndsWith(0));
  EXPECT_THAT(direct.out, HasSubstr("two lines.png: unreadable"));
}

TEST(Inputs, NeedsThreeViews) {
  const ScratchFolder scratch;
  const std::string output = scratch.path("camera.yaml");
  EXPECT_THAT(runAlidade(calibrateLine({imagePath(1), imagePath(2)}, output)),
              FailsWith(1, AllOf(HasSubstr("the board was found in 2 of 2 images; expected"),
                                 HasSubstr("at least 3 views"), HasSubstr("take more photographs"))));
  EXPECT_THAT(scratch.list(), ElementsAre());
  // Three are enough to calibrate sharp images like these, but few.
  const RunResult three = runAlidade(calibrateLine({imagePath(1), imagePath(2), imagePath(3)}, output));
  EXPECT_THAT(three, EndsWith(0));
  EXPECT_THAT(three.out, AllOf(HasSubstr("3 used"), HasSubstr("[few_views]")));
}

TEST(Inputs, UsesTheLargestSizeOfACornersFileAndNamesTheRest) {
  const ScratchFolder scratch;
  std::string mixed = readFile(dataPath("corners.csv"));
  for (const char* name : {"view_011.png", "view_012.png"}) {
    const std::string from = fmt::format("{},640,480,", name);
    for (std::size_t at = mixed.find(from); at != std::string::npos; at = mixed.find(from, at))
      mixed.replace(at, from.size(), fmt::format("{},641,481,", name));
  }
  const RunResult run = runAlidade({"calibrate", scratch.write("corners.csv", mixed), "--verbose"});
  EXPECT_EQ(run.exit_code, 0);
  EXPECT_THAT(run.out, AllOf(HasSubstr("12 given, 12 with the board, 10 used"),
                             HasSubstr("view_011.png: other_size: 641x481, while most images are 640x480"),
                             HasSubstr("view_012.png: other_size")));
}

// Two files of one camera, with a change of each thing in which they may disagree.
TEST(Inputs, OfSeveralCornersFilesMustAgree) {
  const std::string all = readFile(dataPath("corners.csv"));
  const std::size_t first = all.find("camera,view_001.png");
  const std::size_t half = all.find("camera,view_007.png");
  const std::string header = all.substr(0, first);
  const std::string a = header + all.substr(first, half - first);
  const std::string b = header + all.substr(half);
  const auto replacedIn = [](std::string text, const std::string& from, const std::string& to) {
    for (std::size_t at = text.find(from); at != std::string::npos; at = text.find(from, at + to.size()))
      text.replace(at, from.size(), to);
    return text;
  };
  const ScratchFolder scratch;
  const std::string a_path = scratch.write("a.csv", a);
  const auto calibrateWith = [&](const std::string& text) {
    return runAlidade({"calibrate", a_path, scratch.write("b.csv", text), "-o", scratch.path("c.yaml")});
  };
  const RunResult good = calibrateWith(b);
  ASSERT_THAT(good, EndsWith(0));
  EXPECT_THAT(good.err, testing::Not(HasSubstr("warning:")));

  const std::string other = replacedIn(b, kBoardSpec, "checkerboard:9x6:25.5mm");
  ASSERT_NE(other, b);
  const RunResult scaled = calibrateWith(other);
  ASSERT_THAT(scaled, EndsWith(0));
  EXPECT_THAT(scaled.err, HasSubstr(std::string("warning: ") + kBoardSpec +
                                    " and checkerboard:9x6:25.5mm differ in lengths alone"));
  const RunResult json = runAlidade({"calibrate", a_path, scratch.path("b.csv"), "--json"});
  EXPECT_THAT(json.out, HasSubstr("differ in lengths alone"));

  struct Case {
    std::string text;
    std::string found;
  };
  const std::vector<Case> refused = {
      {replacedIn(a, kBoardSpec, "checkerboard:9x6:25.5mm"),
       std::string("image view_001.png: the same corners of ") + kBoardSpec +
           " and of checkerboard:9x6:25.5mm"},
      {a, "image view_001.png: corner 0 twice"},
      {replacedIn(a, ",640,480,", ",641,480,"), "image 'view_001.png' with a different size"},
      {replacedIn(b, "camera,view", "another,view"), "camera 'another'"},
      {replacedIn(b, ",640,480,", ",641,480,"), "6 of 640x480 and 6 of 641x480"}};
  std::size_t num_refused = 0;
  for (const Case& c : refused) {
    EXPECT_THAT(calibrateWith(c.text), FailsWith(1, HasSubstr(c.found)));
    ++num_refused;
  }
  EXPECT_EQ(num_refused, 5U);
}

TEST(Inputs, RefuseTwoSizesInEqualNumber) {
  const ScratchFolder scratch;
  std::string mixed = readFile(dataPath("corners.csv"));
  for (int i = 7; i <= kNumImages; ++i) {
    const std::string from = fmt::format("view_{:03}.png,640,480,", i);
    for (std::size_t at = mixed.find(from); at != std::string::npos; at = mixed.find(from, at))
      mixed.replace(at, from.size(), fmt::format("view_{:03}.png,641,481,", i));
  }
  EXPECT_THAT(runAlidade({"calibrate", scratch.write("corners.csv", mixed)}),
              FailsWith(1, HasSubstr("6 of 640x480 and 6 of 641x481")));
}

TEST(Inputs, OfAnotherKindMakeLibrariesSilent) {
  const ScratchFolder scratch;
  // libpng has something to say of the text chunk, and says it without a file's name.
  std::string png = readFile(imagePath(1));
  const std::string chunk("\0\0\0\4tEXtabcd\0\0\0\0", 16);
  png.insert(33, chunk);
  const RunResult run = runAlidade({"detect", scratch.write("a.png", png), "--board", kBoardSpec, "--quiet"});
  EXPECT_EQ(run.err.find("libpng"), std::string::npos) << run.err;
}

TEST(Inputs, WithLineBreaksInTheirNamesForgeNoLine) {
  const ScratchFolder scratch;
  const RunResult run = runAlidade({"validate", scratch.write("a\nerror: all is well.yaml", "x")});
  EXPECT_EQ(run.err.find("\nerror: all"), std::string::npos) << run.err;
  EXPECT_EQ(run.out.find("\nerror: all"), std::string::npos) << run.out;
}

TEST(Inputs, AreNeverOverwrittenByTheOutput) {
  const ScratchFolder scratch;
  const std::string corners = readFile(dataPath("corners.csv"));
  const std::string path = scratch.write("corners.csv", corners);
  EXPECT_THAT(runAlidade({"calibrate", path, "-o", path}), FailsWith(2, HasSubstr("this is also an input")));
  EXPECT_EQ(readFile(path), corners);
}

}  // namespace
}  // namespace alidade
