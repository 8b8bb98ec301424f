// SPDX-License-Identifier: MIT
#include <filesystem>

#include <nlohmann/json.hpp>

#include "apps/command_line.h"

namespace alidade {
namespace {

using testing::AllOf;
using testing::ElementsAre;
using testing::HasSubstr;

// A small image, so that rendering takes no time.
std::string smallScene(const std::string& views = "{random: 3}") {
  return "alidade_scene: 1\n"
         "camera: {model: pinhole, image_size: {width: 96, height: 72},\n"
         "         parameters: {fx: 80, fy: 80, cx: 47.5, cy: 35.5}}\n"
         "board: checkerboard:4x3:30mm\n"
         "views: " +
         views +
         "\n"
         "seed: 3\n"
         "render: {samples: 32}\n";
}

TEST(Simulate, MakesTheSameBytesForAnyNumberOfThreads) {
  const ScratchFolder scratch;
  const std::string scene = scratch.write("scene.yaml", smallScene());
  ASSERT_THAT(runAlidade({"simulate", scene, "-o", scratch.path("one"), "--jobs", "1"}), EndsWith(0));
  ASSERT_THAT(runAlidade({"simulate", scene, "-o", scratch.path("two"), "--jobs", "2"}), EndsWith(0));
  int num_same = 0;
  for (const std::string name : {"camera.yaml", "corners.csv", "poses.yaml", "images/view_001.png",
                                 "images/view_002.png", "images/view_003.png"}) {
    ASSERT_TRUE(scratch.has("one/" + name)) << name;
    EXPECT_EQ(scratch.read("one/" + name), scratch.read("two/" + name)) << name;
    ++num_same;
  }
  EXPECT_EQ(num_same, 6);
  EXPECT_EQ(scratch.list().size(), 1 + 2 * 9u);
  EXPECT_THAT(runAlidade({"validate", scratch.path("one/camera.yaml")}), EndsWith(0));
}

TEST(Simulate, ReplacesOnlyWhatItMade) {
  const ScratchFolder scratch;
  const std::string scene = scratch.write("scene.yaml", smallScene());
  const std::string output = scratch.path("out");
  ASSERT_THAT(runAlidade({"simulate", scene, "-o", output}), EndsWith(0));
  const std::string image = scratch.read("out/images/view_001.png");
  const auto made = scratch.list();

  EXPECT_THAT(
      runAlidade({"simulate", scene, "-o", output}),
      FailsWith(1, AllOf(HasSubstr(output), HasSubstr("a new or empty folder"), HasSubstr("--overwrite"))));
  EXPECT_EQ(scratch.list(), made);

  scratch.write("scene.yaml", smallScene("{random: 2}"));
  EXPECT_THAT(runAlidade({"simulate", scene, "-o", output, "--overwrite"}), EndsWith(0));
  EXPECT_FALSE(scratch.has("out/images/view_003.png"));
  EXPECT_EQ(scratch.list().size(), made.size() - 1);

  // One file of somebody else's keeps the whole folder.
  int num_foreign = 0;
  for (const std::string foreign :
       {"notes.txt", "images/photo.png", "images/view_001.txt", "sub/camera.yaml"}) {
    scratch.write("out/" + foreign, "precious");
    const auto before = scratch.list();
    EXPECT_THAT(runAlidade({"simulate", scene, "-o", output, "--overwrite"}),
                FailsWith(1, AllOf(HasSubstr(output), HasSubstr("choose another name"))));
    EXPECT_EQ(scratch.list(), before);
    EXPECT_EQ(scratch.read("out/" + foreign), "precious");
    const std::filesystem::path path = scratch.path("out/" + foreign);
    std::filesystem::remove(path);
    if (path.parent_path().filename() == "sub") std::filesystem::remove(path.parent_path());
    ++num_foreign;
  }
  EXPECT_EQ(num_foreign, 4);
}

// People give the results of calibrate and detect the names that simulate uses.
TEST(Simulate, KnowsItsOwnResultsByWhatTheyHold) {
  const ScratchFolder scratch;
  const std::string scene = scratch.write("scene.yaml", smallScene());
  ASSERT_THAT(runAlidade({"simulate", scene, "--corners-only", "-o", scratch.path("out")}), EndsWith(0));
  const std::string camera = scratch.read("out/camera.yaml");
  int num_kept = 0;
  for (const char* name : {"camera.yaml", "corners.csv"}) {
    const std::string own = scratch.read(std::string("out/") + name);
    const std::string foreign = replaced(own, " simulate", "");
    scratch.write(std::string("out/") + name, foreign);
    EXPECT_THAT(runAlidade({"simulate", scene, "-o", scratch.path("out"), "--overwrite"}),
                FailsWith(1, HasSubstr("choose another name")));
    EXPECT_EQ(scratch.read(std::string("out/") + name), foreign);
    scratch.write(std::string("out/") + name, own);
    ++num_kept;
  }
  EXPECT_EQ(num_kept, 2);
  scratch.write("out/scene.yaml", smallScene());
  EXPECT_THAT(
      runAlidade({"simulate", scratch.path("out/scene.yaml"), "-o", scratch.path("out"), "--overwrite"}),
      FailsWith(2, HasSubstr("folder of the input")));
  // The camera that a scene names is an input as well.
  const std::string other = scratch.write(
      "other.yaml", "alidade_scene: 1\ncamera: out/camera.yaml\nboard: " + std::string(kBoardSpec) +
                        "\nviews: {random: 2}\n");
  EXPECT_THAT(runAlidade({"simulate", other, "-o", scratch.path("out"), "--overwrite"}),
              FailsWith(2, HasSubstr("folder of the input")));
  // A folder that is to come has its parent.
  std::filesystem::create_symlink(scratch.path("nowhere"), scratch.path("link"));
  EXPECT_THAT(runAlidade({"simulate", scene, "-o", scratch.path("link")}),
              FailsWith(1, HasSubstr("a link to a folder that does not exist")));
}

// No process has such a number.
TEST(Simulate, NamesWhatAKilledRunLeft) {
  const ScratchFolder scratch;
  const std::string scene = scratch.write("scene.yaml", smallScene());
  scratch.makeFolder(".out.999999999.tmp");
  scratch.makeFolder(".out.more.tmp");
  const RunResult run = runAlidade({"simulate", scene, "--corners-only", "-o", scratch.path("out")});
  ASSERT_THAT(run, EndsWith(0));
  EXPECT_THAT(run.err,
              AllOf(HasSubstr("'.out.999999999.tmp'"), HasSubstr("left over from an interrupted run")));
  EXPECT_EQ(run.err.find("more"), std::string::npos) << run.err;
  EXPECT_TRUE(scratch.has(".out.999999999.tmp"));
}

TEST(Simulate, KeepsThePermissionsOfAnEmptyFolder) {
  const ScratchFolder scratch;
  const std::string scene = scratch.write("scene.yaml", smallScene());
  scratch.makeFolder("private");
  std::filesystem::permissions(scratch.path("private"), std::filesystem::perms::owner_all);
  ASSERT_THAT(runAlidade({"simulate", scene, "--corners-only", "-o", scratch.path("private")}), EndsWith(0));
  EXPECT_EQ(std::filesystem::status(scratch.path("private")).permissions(),
            std::filesystem::perms::owner_all);
}

TEST(Simulate, NamesFoldersThatCannotBeMade) {
  const ScratchFolder scratch;
  const std::string scene = scratch.write("scene.yaml", smallScene());
  const auto before = scratch.list();
  EXPECT_THAT(runAlidade({"simulate", scene, "-o", scratch.path("missing/out")}),
              FailsWith(1, HasSubstr(scratch.path("missing/out"))));
  EXPECT_THAT(runAlidade({"simulate", scene, "-o", scene}),
              FailsWith(1, AllOf(HasSubstr(scene), HasSubstr("a file"))));
  EXPECT_THAT(runAlidade({"simulate", scene, "-o", scene + "/out"}), FailsWith(1, HasSubstr(scene)));
  EXPECT_EQ(scratch.list(), before);
}

TEST(Simulate, SaysWhenTheBoardIsOutOfSight) {
  const ScratchFolder scratch;
  const std::string behind = "{rotation_vector_rad: [0, 0, 0], translation_m: [0, 0, -1]}";
  const std::string turned = "{rotation_vector_rad: [0, 3.1, 0], translation_m: [0, 0, 1]}";
  const std::string seen = "{rotation_vector_rad: [0, 0, 0], translation_m: [-0.05, -0.03, 0.3]}";
  const auto simulate = [&](const std::string& poses, const std::string& output) {
    const std::string scene = scratch.write("scene.yaml", smallScene("{poses: [" + poses + "]}"));
    return runAlidade({"simulate", scene, "--corners-only", "--json", "-o", scratch.path(output)});
  };
  const RunResult none = simulate(behind + ", " + turned, "none");
  EXPECT_THAT(none, EndsWith(1));
  EXPECT_THAT(none.err,
              AllOf(testing::StartsWith("error: "), HasSubstr(scratch.path("scene.yaml")),
                    HasSubstr("no corner of the board is visible"), HasSubstr("next: check the poses")));
  EXPECT_EQ(nlohmann::json::parse(none.out).at("error").at("exit_code"), 1);
  EXPECT_THAT(scratch.list(), ElementsAre("scene.yaml"));

  const RunResult some = simulate(seen + ", " + behind + ", " + seen, "some");
  ASSERT_THAT(some, EndsWith(0));
  EXPECT_THAT(some.err, HasSubstr("warning: no corner of the board is visible in view_002.png"));
  const auto document = nlohmann::json::parse(some.out);
  EXPECT_EQ(document.at("num_corners"), 24);
  EXPECT_EQ(document.at("views_without_corners"), nlohmann::json::array({"view_002.png"}));
}

TEST(Simulate, FindsTheFilesThatASceneNames) {
  const ScratchFolder scratch;
  scratch.write("scenes/camera.yaml", smallCamera());
  scratch.write("scenes/board.yaml", "kind: checkerboard\ncolumns: 4\nrows: 3\nsquare: 30mm\n");
  const std::string scene = scratch.write(
      "scenes/scene.yaml", "alidade_scene: 1\ncamera: camera.yaml\nboard: board.yaml\nviews: {random: 2}\n");
  EXPECT_THAT(runAlidade({"simulate", scene, "--corners-only", "-o", scratch.path("out")}), EndsWith(0));
  EXPECT_THAT(scratch.read("out/corners.csv"), HasSubstr(",checkerboard:4x3:30mm,"));
}

TEST(Simulate, TellsWhatItAssumedOfAForeignCamera) {
  const ScratchFolder scratch;
  scratch.write("camera.yml",
                "%YAML:1.0\n---\nimage_width: 96\nimage_height: 72\n"
                "camera_matrix: [80.0, 0, 47.5, 0, 80.0, 35.5, 0, 0, 1]\nlens: unknown\n");
  const std::string scene = scratch.write("scene.yaml",
                                          "alidade_scene: 1\ncamera: camera.yml\n"
                                          "board: checkerboard:4x3:30mm\nviews: {random: 1}\n");
  const RunResult result = runAlidade({"simulate", scene, "-o", scratch.path("out"), "--corners-only"});
  ASSERT_THAT(result, EndsWith(0));
  EXPECT_THAT(result.err,
              AllOf(HasSubstr("note: "), HasSubstr("no distortion coefficients"), HasSubstr("lens")));
  EXPECT_EQ(runAlidade({"simulate", scene, "-o", scratch.path("quiet"), "--corners-only", "--quiet"}).err,
            "");
}

}  // namespace
}  // namespace alidade
