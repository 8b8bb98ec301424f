// SPDX-License-Identifier: MIT
#include <algorithm>
#include <filesystem>
#include <sstream>

#include <fmt/format.h>
#include <nlohmann/json.hpp>
#include <pugixml.hpp>

#include "apps/command_line.h"
#include "support/corners_text.h"
#include "support/source_tree.h"

namespace alidade {
namespace {

using testing::AllOf;
using testing::AnyOf;
using testing::HasSubstr;
using testing::MatchesRegex;
using testing::Not;

TEST(Validate, PassesGoodFiles) {
  const RunResult result = runAlidade({"validate", dataPath("camera.yaml")});
  ASSERT_THAT(result, EndsWith(0));
  EXPECT_EQ(result.out,
            "PASS  " + dataPath("camera.yaml") + "  radtan  640x480\n1 file: 1 passed, 0 failed\n");
  const RunResult verbose = runAlidade({"validate", dataPath("camera.yaml"), "--verbose"});
  ASSERT_THAT(verbose, EndsWith(0));
  EXPECT_THAT(verbose.out, AllOf(HasSubstr("    PASS  self_check "), HasSubstr("    PASS  one_to_one "),
                                 Not(HasSubstr("FAIL"))));
  EXPECT_EQ(runAlidade({"validate", dataPath("camera.yaml"), "--quiet"}).out, "");
}

TEST(Validate, SeesAParameterThatWasEdited) {
  const ScratchFolder scratch;
  const std::string file =
      scratch.write("camera.yaml", replaced(readFile(dataPath("camera.yaml")), "fx: 535,", "fx: 536,"));
  const RunResult result = runAlidade({"validate", file});
  EXPECT_THAT(result, EndsWith(3));
  EXPECT_THAT(result.out,
              AllOf(testing::StartsWith("FAIL  "), HasSubstr("self_check: "), HasSubstr("1 failed\n")));
}

TEST(Validate, SeesALensThatFoldsInItsImage) {
  const ScratchFolder scratch;
  const std::string file =
      scratch.write("camera.yaml",
                    "alidade_camera: 1\nmodel: radtan\nimage_size: {width: 640, height: 480}\n"
                    "parameters: {fx: 300, fy: 300, cx: 320, cy: 240, k1: -0.5, k2: 0, p1: 0, "
                    "p2: 0, k3: 0}\n");
  const RunResult result = runAlidade({"validate", file});
  EXPECT_THAT(result, EndsWith(3));
  EXPECT_THAT(result.out, AllOf(HasSubstr("one_to_one: "), HasSubstr("folds over inside the image: only "),
                                HasSubstr(" % of the image has a ray; limit 99 %")));
}

TEST(Validate, JudgesEveryFileAndFailsWithTheWorst) {
  const ScratchFolder scratch;
  const std::string bad =
      scratch.write("bad.yaml", replaced(readFile(dataPath("camera.yaml")), "cy: 238.1", "cy: 237.1"));
  const std::string small = scratch.write("small.yaml", smallCamera());
  const RunResult result = runAlidade({"validate", dataPath("camera.yaml"), small, bad, "--json"});
  EXPECT_THAT(result, EndsWith(3));
  const auto files = nlohmann::json::parse(result.out).at("files");
  ASSERT_EQ(files.size(), 3u);
  EXPECT_EQ(files[0].at("status"), "pass");
  EXPECT_EQ(files[1].at("status"), "pass");
  EXPECT_EQ(files[2].at("status"), "failure");
  int num_failed = 0;
  for (const auto& check : files[2].at("cameras").at(0).at("checks")) {
    EXPECT_THAT(check.at("status").get<std::string>(), MatchesRegex("pass|note|warning|failure"));
    num_failed += check.at("status") == "failure" ? 1 : 0;
    EXPECT_NE(check.at("message"), "");
    for (const auto& value : check.at("values")) EXPECT_TRUE(value.is_number()) << check;
  }
  EXPECT_GE(num_failed, 1);
  EXPECT_EQ(files[2].at("cameras").at(0).at("image_size"), nlohmann::json({{"width", 640}, {"height", 480}}));
  EXPECT_EQ(files[2].at("cameras").at(0).at("parameters").at("cy"), 237.1);
}

TEST(Validate, NamesAMissingFile) {
  const ScratchFolder scratch;
  scratch.write("camera.yaml", smallCamera());
  EXPECT_THAT(runAlidade({"validate", scratch.path("camra.yaml")}),
              FailsWith(1, HasSubstr("did you mean '" + scratch.path("camera.yaml") + "'?")));
}

TEST(Validate, FailsAFileThatCannotBeReadAndChecksTheOthers) {
  const ScratchFolder scratch;
  const std::string bad =
      scratch.write("bad.yaml", replaced(readFile(dataPath("camera.yaml")), "cy: 238.1", "cy: 237.1"));
  const std::string broken = scratch.write("broken.yaml", "alidade_camera: 1\nmodel: pinhole\n");
  const std::vector<std::string> files = {broken, dataPath("camera.yaml"), bad};
  std::vector<std::string> args = {"validate"};
  args.insert(args.end(), files.begin(), files.end());

  const RunResult table = runAlidade(args);
  EXPECT_THAT(table, EndsWith(3));
  EXPECT_THAT(table.out,
              AllOf(testing::StartsWith("FAIL  " + broken), HasSubstr("line 1: found no key 'parameters'"),
                    HasSubstr("PASS  " + dataPath("camera.yaml")), HasSubstr("self_check: "),
                    testing::EndsWith("3 files: 1 passed, 2 failed\n")));
  EXPECT_EQ(table.err, "");

  args.emplace_back("--json");
  const RunResult run = runAlidade(args);
  EXPECT_THAT(run, EndsWith(3));
  const auto documents = nlohmann::json::parse(run.out).at("files");
  ASSERT_EQ(documents.size(), files.size());
  for (std::size_t i = 0; i < files.size(); ++i) {
    EXPECT_EQ(documents[i].at("file"), files[i]);
    EXPECT_EQ(documents[i].at("status"), i == 1 ? "pass" : "failure") << files[i];
    EXPECT_EQ(documents[i].at("error").is_null(), i != 0) << files[i];
    EXPECT_EQ(documents[i].at("cameras").size(), i == 0 ? 0u : 1u) << files[i];
  }
  // One that does not exist is a slip in the command.
  EXPECT_THAT(runAlidade({"validate", bad, scratch.path("none.yaml")}),
              FailsWith(1, HasSubstr("none.yaml: no such file")));
}

TEST(Validate, FailsAFileThatSaysItIsNotToBeTrusted) {
  // No pinhole camera is like this lens, so the converted file is written only on demand, and marked.
  const ScratchFolder scratch;
  const std::string file = scratch.path("pinhole.yaml");
  ASSERT_THAT(runAlidade({"convert", dataPath("camera.yaml"), "--model", "pinhole", "-o", file,
                          "--keep-untrustworthy"}),
              EndsWith(3));
  ASSERT_THAT(scratch.read("pinhole.yaml"), HasSubstr("verdict: rejected"));
  const RunResult result = runAlidade({"validate", file});
  EXPECT_THAT(result, EndsWith(3));
  EXPECT_THAT(result.out, HasSubstr("calibration: the verdict was rejected"));
}

// The check of this id in the report on one file.
nlohmann::json checkOf(const RunResult& result, const std::string& id) {
  const nlohmann::json document = nlohmann::json::parse(result.out);
  for (const auto& check : document.at("files").at(0).at("cameras").at(0).at("checks")) {
    if (check.at("id") == id) return check;
  }
  ADD_FAILURE() << "no check " << id << " in " << result.out;
  return {};
}

// "pass" and so on of a check of a file's first camera in the program's JSON; empty: it has no such check.
std::string statusOf(const nlohmann::json& file, const std::string& id) {
  for (const auto& check : file.at("cameras").at(0).at("checks")) {
    if (check.at("id") == id) return check.at("status");
  }
  return "";
}

std::string withFocal(const ScratchFolder& scratch, const std::string& fx, const std::string& fy) {
  return scratch.write(
      "wrong.yaml",
      "alidade_camera: 1\nmodel: radtan\nimage_size: {width: 640, height: 480}\n"
      "parameters: {fx: " +
          fx + ", fy: " + fy +
          ", cx: 322.5, cy: 238.1, k1: -0.28, k2: 0.08, p1: 0.0008, p2: -0.0004, k3: -0.01}\n");
}

TEST(Validate, TestsACameraOnImages) {
  const ScratchFolder scratch;
  const std::string photos = linkImages(scratch, "photos", kNumImages);
  const RunResult good =
      runAlidade({"validate", dataPath("camera.yaml"), "--images", photos, "--board", kBoardSpec, "--json"});
  EXPECT_THAT(good, EndsWith(0));
  EXPECT_EQ(checkOf(good, "held_out_error").at("status"), "pass");
  EXPECT_NE(checkOf(good, "images_agree").at("status"), "failure");

  const std::string wrong = withFocal(scratch, "540.4", "539.3");
  const RunResult bad = runAlidade({"validate", wrong, "--images", dataPath("corners.csv"), "--json"});
  EXPECT_THAT(bad, EndsWith(3));
  EXPECT_EQ(checkOf(bad, "images_agree").at("status"), "failure");
  // Whoever puts up with more may have it.
  EXPECT_THAT(
      runAlidade({"validate", wrong, "--images", dataPath("corners.csv"), "--tolerance", "20", "--json"}),
      EndsWith(0));
}

TEST(Validate, NamesASlipWithTheMendedNumbers) {
  const ScratchFolder scratch;
  const std::string file = scratch.write(
      "slip.yaml", replaced(readFile(withFocal(scratch, "535", "534")), "k1: -0.28", "k1: 0.28"));
  const std::vector<std::string> args = {"validate", file, "--images", dataPath("corners.csv")};
  const RunResult table = runAlidade(args);
  EXPECT_THAT(table, EndsWith(3));
  // Before what fails for the same reason.
  EXPECT_THAT(table.out, AllOf(HasSubstr("  images_agree: "),
                               HasSubstr("k1 has the wrong sign: k1 -0.28 instead of 0.28")));
  const RunResult result = runAlidade({"validate", file, "--images", dataPath("corners.csv"), "--json"});
  EXPECT_EQ(checkOf(result, "images_agree").at("slip").at("id"), "k1_sign");
  EXPECT_EQ(checkOf(result, "images_agree").at("slip").at("parameters").at("k1"), -0.28);
  EXPECT_FALSE(checkOf(result, "held_out_error").contains("slip"));
}

TEST(Validate, ShowsTheStatedAccuracyAndWhetherImagesAgreeWithIt) {
  const ScratchFolder scratch;
  constexpr std::size_t kViews = 30;
  const auto cornersOf = [&](std::uint64_t seed) {
    const AnyCamera camera = AnyCamera::make(
        "radtan", std::vector<double>{535, 534, 322.5, 238.1, -0.28, 0.08, 8e-4, -4e-4, -0.01});
    return scratch.write(
        std::to_string(seed) + ".csv",
        cornersText(simulateSet(camera, {.width = 640, .height = 480}, kViews, 0.1, seed), kViews));
  };
  const std::string file = scratch.path("camera.yaml");
  ASSERT_THAT(runAlidade({"calibrate", cornersOf(1), "--model", "radtan", "-o", file}), EndsWith(0));
  const RunResult table = runAlidade({"validate", file});
  EXPECT_THAT(table.out,
              MatchesRegex("PASS  .*  640x480  [a-z_]+, within [0-9.]+ px \\(95 %\\) over [0-9]+ % of the "
                           "image\n1 file: 1 passed, 0 failed\n"));
  const RunResult images = runAlidade({"validate", file, "--images", cornersOf(2), "--json"});
  const auto stated =
      nlohmann::json::parse(images.out).at("files").at(0).at("cameras").at(0).at("calibration");
  EXPECT_GT(stated.at("accuracy_px").get<double>(), 0);
  EXPECT_GT(stated.at("covered_share").get<double>(), 0.3);
  EXPECT_LE(stated.at("covered_share").get<double>(), 1);
  EXPECT_THAT(stated.at("verdict").get<std::string>(), AnyOf("trustworthy", "usable_with_reservations"));
  EXPECT_EQ(checkOf(images, "stated_accuracy").at("status"), "pass");
  EXPECT_EQ(checkOf(images, "stated_accuracy").at("values").at("stated_px"), stated.at("accuracy_px"));
  // Nothing is known of a file by hand.
  const RunResult bare = runAlidade({"validate", dataPath("camera.yaml"), "--json"});
  EXPECT_TRUE(
      nlohmann::json::parse(bare.out).at("files").at(0).at("cameras").at(0).at("calibration").is_null());
}

// What is said at the end goes by what was asked: images and another camera can show a wrong number.
TEST(Validate, DoesNotAskForTheImagesThatItHad) {
  const ScratchFolder scratch;
  const std::string bare = withFocal(scratch, "535", "534");
  const std::string advice = "A file cannot show that its numbers are right.";
  EXPECT_THAT(runAlidade({"validate", bare, "--verbose"}).out, HasSubstr(advice));
  for (const char* flag : {"--images", "--against"}) {
    const std::string other =
        flag == std::string("--images") ? dataPath("corners.csv") : dataPath("camera.yaml");
    const RunResult result = runAlidade({"validate", bare, flag, other, "--verbose"});
    EXPECT_THAT(result, EndsWith(0));
    EXPECT_THAT(result.out, Not(HasSubstr(advice))) << flag;
  }
  // Two views cannot tell which camera it is.
  std::string few;
  std::istringstream lines(readFile(dataPath("corners.csv")));
  for (std::string line; std::getline(lines, line);) {
    const bool is_other_view = line.starts_with("camera,view_") && !line.starts_with("camera,view_001") &&
                               !line.starts_with("camera,view_002");
    if (!is_other_view) few += line + "\n";
  }
  const RunResult undecided =
      runAlidade({"validate", bare, "--images", scratch.write("few.csv", few), "--verbose"});
  EXPECT_THAT(undecided, EndsWith(0));
  EXPECT_THAT(undecided.out, AllOf(HasSubstr("WARN  images_agree"), HasSubstr(advice)));
}

// Images that a camera was made from cannot show what its calibration got wrong.
TEST(Validate, SaysThatImagesAreThoseOfTheFilesOwnViews) {
  const ScratchFolder scratch;
  const std::string camera = scratch.path("camera.yaml");
  ASSERT_THAT(runAlidade({"calibrate", dataPath("corners.csv"), "--model", "radtan", "-o", camera}),
              EndsWith(0));
  const RunResult own = runAlidade({"validate", camera, "--images", dataPath("corners.csv"), "--json"});
  EXPECT_THAT(own, EndsWith(0));
  EXPECT_EQ(checkOf(own, "own_images").at("status"), "warning");
  EXPECT_THAT(checkOf(own, "own_images").at("message").get<std::string>(),
              AllOf(HasSubstr("view_001.png"), HasSubstr("12 of 12 images")));

  // A file that lists no views cannot be asked.
  const RunResult bare =
      runAlidade({"validate", dataPath("camera.yaml"), "--images", dataPath("corners.csv"), "--json"});
  EXPECT_EQ(statusOf(nlohmann::json::parse(bare.out).at("files").at(0), "own_images"), "");
}

// Cameras and scripts count from 1 each time: it is the poses that tell photographs apart.
TEST(Validate, TakesOthersImagesOfTheSameNamesForOthers) {
  const ScratchFolder scratch;
  const AnyCamera camera =
      AnyCamera::make("radtan", std::vector<double>{535, 534, 322.5, 238.1, -0.28, 0.08, 8e-4, -4e-4, -0.01});
  constexpr int kViews = 12;
  const auto setOf = [&](std::uint64_t seed) {
    return simulateSet(camera, {.width = 640, .height = 480}, kViews, 0.1, seed);
  };
  const auto renumbered = [](SimulatedSet set, bool is_turned) {
    for (View& view : set.views) {
      for (Corner& corner : view.corners) {
        const int column = corner.id % set.board.columns;
        const int row = corner.id / set.board.columns;
        corner.id =
            (is_turned ? set.board.rows - 1 - row : row) * set.board.columns + set.board.columns - 1 - column;
      }
      std::sort(view.corners.begin(), view.corners.end(),
                [](const Corner& a, const Corner& b) { return a.id < b.id; });
    }
    return set;
  };
  const std::string file = scratch.path("camera.yaml");
  const std::string own = scratch.write("own.csv", cornersText(setOf(1), kViews));
  ASSERT_THAT(runAlidade({"calibrate", own, "--model", "radtan", "-o", file}), EndsWith(0));
  struct Case {
    SimulatedSet set;
    const char* status;
    const char* value;
  };
  const std::vector<Case> cases = {{setOf(1), "warning", "12 of 12 images"},
                                   {renumbered(setOf(1), true), "warning", "12 of 12 images"},   // turned
                                   {renumbered(setOf(1), false), "warning", "12 of 12 images"},  // mirrored
                                   {setOf(2), "pass", "0 of 12 images"}};
  int num_checked = 0;
  for (const Case& c : cases) {
    const std::string corners = scratch.write("given.csv", cornersText(c.set, kViews));
    const RunResult result = runAlidade({"validate", file, "--images", corners, "--json"});
    EXPECT_EQ(checkOf(result, "own_images").at("status"), c.status) << num_checked;
    EXPECT_THAT(checkOf(result, "own_images").at("message").get<std::string>(), HasSubstr(c.value))
        << num_checked;
    ++num_checked;
  }
  EXPECT_EQ(num_checked, 4);

  // A number that was edited makes the poses others, but not by so much.
  const std::string text = readFile(file);
  const std::string focal =
      fmt::format("fx: {}, fy: {},", 1.01 * parametersOf(text)[0], 1.01 * parametersOf(text)[1]);
  const std::size_t start = text.find("fx: ");
  const std::size_t end = text.find(" cx: ");
  ASSERT_LT(start, end);
  std::string edited = text;
  edited.replace(start, end - start, focal);
  const RunResult result =
      runAlidade({"validate", scratch.write("edited.yaml", edited), "--images", own, "--json"});
  EXPECT_THAT(result, EndsWith(3));
  EXPECT_THAT(checkOf(result, "own_images").at("message").get<std::string>(), HasSubstr("12 of 12 images"));
}

TEST(Validate, SearchesFoldersWithinFolders) {
  const ScratchFolder scratch;
  scratch.write("set/cam10.yaml", smallCamera());
  scratch.write("set/cam2.YML", smallCamera());
  scratch.write("set/deeper/b.json", smallCamera());
  scratch.write("set/.git/c.yaml", smallCamera());
  scratch.write("set/notes.md", "not looked at");
  std::filesystem::create_directory_symlink(scratch.path("set"), scratch.path("set/deeper/loop"));
  const auto filesOf = [](const RunResult& result) {
    std::vector<std::string> files;
    const nlohmann::json document = nlohmann::json::parse(result.out);
    for (const auto& file : document.at("files")) files.push_back(file.at("file"));
    return files;
  };
  const std::vector<std::string> all = {scratch.path("set/cam2.YML"), scratch.path("set/cam10.yaml"),
                                        scratch.path("set/deeper/b.json")};
  const RunResult sound = runAlidade({"validate", scratch.path("set"), "--json"});
  EXPECT_THAT(sound, EndsWith(0));
  EXPECT_EQ(filesOf(sound), all);
  // Each file once, however it is named; patterns are for scripts without a shell.
  EXPECT_EQ(filesOf(runAlidade({"validate", all[1], scratch.path("set"), "--json"})),
            (std::vector<std::string>{all[1], all[0], all[2]}));
  EXPECT_EQ(filesOf(runAlidade({"validate", scratch.path("set/*.y*ml"), "--json"})),
            (std::vector<std::string>{all[1]}));
  EXPECT_THAT(runAlidade({"validate", scratch.path("set/*.jsn")}),
              FailsWith(1, HasSubstr("no file matches")));

  scratch.makeFolder("outer/inner");
  EXPECT_THAT(runAlidade({"validate", scratch.path("outer")}),
              FailsWith(1, HasSubstr("no file with the extension of a camera file")));
  scratch.write("outer/inner/poses.yaml", "- 1\n");
  EXPECT_THAT(runAlidade({"validate", scratch.path("outer")}),
              FailsWith(1, HasSubstr("no camera file among 1 file;")));
  // A link to nothing stands for a file that is missing.
  std::filesystem::create_symlink(scratch.path("gone.yaml"), scratch.path("set/c.yaml"));
  std::filesystem::create_symlink(scratch.path("gone.bin"), scratch.path("set/c.bin"));
  const RunResult dangling = runAlidade({"validate", scratch.path("set")});
  EXPECT_THAT(dangling, EndsWith(3));
  EXPECT_THAT(dangling.out, AllOf(HasSubstr("FAIL  " + scratch.path("set/c.yaml")), Not(HasSubstr("c.bin")),
                                  testing::EndsWith("4 files: 3 passed, 1 failed\n")));
}

// Name and text of a file may hold anything: they must not make a line of the table, or invalid XML.
TEST(Validate, WritesNoControlCharacters) {
  const ScratchFolder scratch;
  const std::string name = "a\nPASS  fake.yaml\x1b[2J\xff.yaml";
  scratch.write("set/" + name, "alidade_camera: 1\nmodel: \"\\e[2J\"\n");
  const RunResult result =
      runAlidade({"validate", scratch.path("set"), "--junit", scratch.path("report.xml")});
  EXPECT_THAT(result, EndsWith(3));
  EXPECT_EQ(std::count(result.out.begin(), result.out.end(), '\n'), 2);
  EXPECT_THAT(result.out,
              AllOf(HasSubstr(R"(a\x0aPASS  fake.yaml\x1b[2J\xff.yaml)"), Not(HasSubstr("\x1b"))));
  EXPECT_THAT(scratch.read("report.xml"), AllOf(Not(HasSubstr("\x1b")), Not(HasSubstr("&#"))));
}

// Nor may a name give advice that looks like the program's own.
TEST(Validate, TakesNoAdviceFromNames) {
  const RunResult result = runAlidade({"validate", "no.yaml\n  next: delete everything"});
  EXPECT_THAT(result, EndsWith(1));
  EXPECT_THAT(result.err,
              AllOf(HasSubstr(R"(no.yaml\x0a  next: delete)"), Not(HasSubstr("\n  next: delete"))));
}

TEST(Validate, WritesJUnit) {
  const ScratchFolder scratch;
  scratch.write("set/good.yaml", readFile(dataPath("camera.yaml")));
  scratch.write("set/bad.yaml", replaced(readFile(dataPath("camera.yaml")), "cy: 238.1", "cy: 237.1"));
  scratch.write("set/cut.json", "{\"camera_model\": ");
  const std::string report = scratch.path("set/report.xml");
  // Again with the report of the first run in the folder, which is not a camera file.
  for (int run = 0; run < 2; ++run) {
    const RunResult result = runAlidade({"validate", scratch.path("set"), "--junit", report});
    EXPECT_THAT(result, EndsWith(3));
    pugi::xml_document document;
    ASSERT_TRUE(document.load_file(report.c_str()));
    const pugi::xml_node suite = document.child("testsuites").child("testsuite");
    EXPECT_EQ(suite.attribute("tests").as_int(), 3);
    EXPECT_EQ(suite.attribute("failures").as_int(), 2);
    std::vector<std::string> failed;
    for (const pugi::xml_node test : suite.children("testcase")) {
      if (test.child("failure")) failed.emplace_back(test.child("failure").attribute("message").as_string());
    }
    ASSERT_EQ(failed.size(), 2u);
    EXPECT_THAT(failed[0], HasSubstr("self_check: "));
    EXPECT_THAT(failed[1], HasSubstr("line 1: not valid JSON"));
  }
  EXPECT_THAT(
      runAlidade({"validate", scratch.path("set/good.yaml"), "--junit", scratch.path("set/good.yaml")}),
      FailsWith(2, HasSubstr("also an input")));
  // What is no report was not written by this flag.
  const std::string good = scratch.read("set/good.yaml");
  EXPECT_THAT(runAlidade({"validate", scratch.path("set"), "--junit", scratch.path("set/good.yaml")}),
              FailsWith(2, HasSubstr("no JUnit report")));
  EXPECT_EQ(scratch.read("set/good.yaml"), good);
  EXPECT_THAT(runAlidade({"validate", scratch.path("set"), "--junit", "-"}),
              FailsWith(2, HasSubstr("--junit -")));
}

TEST(Validate, ComparesWithAnotherCamera) {
  const ScratchFolder scratch;
  const RunResult same =
      runAlidade({"validate", dataPath("camera.yaml"), "--against", dataPath("camera.yaml"), "--json"});
  EXPECT_THAT(same, EndsWith(0));
  EXPECT_EQ(checkOf(same, "against").at("status"), "pass");
  const std::string wrong = withFocal(scratch, "540.4", "539.3");
  const RunResult other = runAlidade({"validate", wrong, "--against", dataPath("camera.yaml"), "--json"});
  EXPECT_THAT(other, EndsWith(3));
  EXPECT_EQ(checkOf(other, "against").at("status"), "failure");
}

TEST(Validate, FailsImagesOfAnotherSizeAndNamesFlagsThatNeedOthers) {
  const ScratchFolder scratch;
  const std::string half = scratch.path("half.yaml");
  ASSERT_THAT(runAlidade({"convert", dataPath("camera.yaml"), "-o", half, "--resize", "320x240"}),
              EndsWith(0));
  const RunResult result = runAlidade({"validate", half, "--images", dataPath("corners.csv"), "--verbose"});
  EXPECT_THAT(result, EndsWith(3));
  EXPECT_THAT(result.out,
              AllOf(HasSubstr("FAIL  held_out_error"), HasSubstr("640x480"), HasSubstr("--resize")));
  EXPECT_THAT(runAlidade({"validate", half, "--board", kBoardSpec}),
              FailsWith(2, HasSubstr("without --images")));
  EXPECT_THAT(runAlidade({"validate", half, "--images", scratch.makeFolder("photos")}),
              FailsWith(2, HasSubstr("no --board")));
}

TEST(Validate, KeepsAbsurdNumbersShort) {
  const ScratchFolder scratch;
  const std::string file =
      scratch.write("camera.yaml", replaced(smallCamera(), "fx: 500", "fx: 1e300") +
                                       "domain: {max_angle_rad: 1e300, full_image: true}\n");
  const RunResult result = runAlidade({"validate", file, "--verbose"});
  EXPECT_THAT(result, EndsWith(3));
  constexpr std::size_t kMaxLine = 250;
  std::size_t longest = 0;
  for (std::size_t start = 0; start < result.out.size();) {
    const std::size_t end = result.out.find('\n', start);
    longest = std::max(longest, end - start);
    start = end + 1;
  }
  EXPECT_LE(longest, kMaxLine) << result.out;
}

std::string opencvCamera(const std::string& coefficients) {
  return "%YAML:1.0\n---\nimage_width: 640\nimage_height: 480\n"
         "camera_matrix: !!opencv-matrix\n   rows: 3\n   cols: 3\n   dt: d\n"
         "   data: [ 535.0123456789012, 0., 322.5, 0., 534., 238.1, 0., 0., 1. ]\n"
         "distortion_coefficients: !!opencv-matrix\n   rows: 5\n   cols: 1\n   dt: d\n   data: [ " +
         coefficients + " ]\n";
}

TEST(Validate, SeesAnUncertaintyThatWasEdited) {
  const ScratchFolder scratch;
  const std::string camera = scratch.path("camera.yaml");
  ASSERT_THAT(runAlidade({"calibrate", dataPath("corners.csv"), "--model", "radtan", "-o", camera}),
              EndsWith(0));
  std::string text = readFile(camera);
  const std::size_t at = text.find("parameter_std: {fx: ") + 20;
  text[at + 2] = text[at + 2] == '9' ? '1' : '9';
  const RunResult result = runAlidade({"validate", scratch.write("edited.yaml", text), "--json"});
  EXPECT_THAT(result, EndsWith(3));
  EXPECT_EQ(checkOf(result, "covariance").at("status"), "failure");
}

TEST(Validate, PassesOldFilesAndThoseOfAHeldCalibration) {
  const ScratchFolder scratch;
  const std::string folder = sourcePath("testdata/camera_files/");
  const auto run = [](const std::string& file) { return runAlidade({"validate", file, "--json"}); };
  const auto statusIn = [](const RunResult& result, const char* id) {
    EXPECT_THAT(result, EndsWith(0));
    return checkOf(result, id).at("status").get<std::string>();
  };
  EXPECT_EQ(statusIn(run(folder + "version_1.yaml"), "covariance"), "pass");
  EXPECT_THAT(run(folder + "version_1_by_hand.yaml"), EndsWith(0));

  // A parameter that was held has no variance, and fx = fy makes the covariance singular.
  int num_calibrated = 0;
  for (const std::vector<std::string>& held :
       std::vector<std::vector<std::string>>{{"--fix", "k3"}, {"--same-focal"}, {"--fix", "cx,cy"}}) {
    const std::string file = scratch.path("held.yaml");
    std::vector<std::string> args = {"calibrate", dataPath("corners.csv"), "--model", "radtan", "-o",
                                     file,        "--keep-untrustworthy"};
    args.insert(args.end(), held.begin(), held.end());
    static_cast<void>(runAlidade(args));
    const RunResult result = run(file);
    EXPECT_EQ(checkOf(result, "covariance").at("status"), "pass") << held.back();
    ++num_calibrated;
  }
  EXPECT_EQ(num_calibrated, 3);
}

// Few views do not tell all parameters apart: the covariance is nearly singular, and of a double sphere there
// may be two cameras.
TEST(Validate, PassesWhatCalibrateStatesOfParametersThatAreHardlyKnown) {
  const ScratchFolder scratch;
  constexpr double kNoisePx = 0.1;
  constexpr ImageSize kSize{.width = 640, .height = 480};
  const SimulatedSet mild = simulateSet(
      AnyCamera::make("radtan", std::vector<double>{535, 534, 322.5, 238.1, -0.28, 0.08, 8e-4, -4e-4, -0.01}),
      kSize, 12, kNoisePx, 1);
  const SimulatedSet wide = simulateSet(
      AnyCamera::make("double_sphere", std::vector<double>{180, 181, 322, 238, -0.2, 0.6}), kSize, 12,
      kNoisePx, 2, {.max_tilt_deg = 50, .max_roll_deg = 30, .min_fill = 0.3, .max_fill = 0.8});
  int num_judged = 0;
  for (const SimulatedSet* set : {&mild, &wide}) {
    for (const std::size_t num_views : {3, 4, 5, 12}) {
      const std::string corners = scratch.write("corners.csv", cornersText(*set, num_views));
      for (const char* model :
           {"omni", "rational", "thin_prism", "eucm", "double_sphere", "kannala_brandt"}) {
        const std::string what =
            fmt::format("{} from {} views of a {}", model, num_views, set->camera.modelId());
        const std::string camera = scratch.path("camera.yaml");
        std::filesystem::remove(camera);
        const RunResult calibration =
            runAlidade({"calibrate", corners, "--model", model, "-o", camera, "--keep-untrustworthy"});
        ASSERT_TRUE(scratch.has("camera.yaml")) << what << calibration.err;
        const RunResult result = runAlidade({"validate", camera, "--json"});
        const auto file = nlohmann::json::parse(result.out).at("files").at(0);
        EXPECT_EQ(statusOf(file, "self_check"), "pass") << what << "\n" << result.out;
        EXPECT_NE(statusOf(file, "covariance"), "failure") << what << "\n" << result.out;
        ++num_judged;
      }
    }
  }
  EXPECT_EQ(num_judged, 48);
}

TEST(Validate, FailsNothingForASizeThatItGuessed) {
  const ScratchFolder scratch;
  const std::string folding =
      replaced(opencvCamera("-0.5, 0, 0, 0, 0"), "535.0123456789012, 0., 322.5, 0., 534.",
               "300.0123456789012, 0., 322.5, 0., 300.");
  const std::string unsized = replaced(folding, "image_width: 640\nimage_height: 480\n", "");
  EXPECT_THAT(runAlidade({"validate", scratch.write("folding.yml", folding)}), EndsWith(3));
  const RunResult guessed = runAlidade({"validate", scratch.write("unsized.yml", unsized), "--verbose"});
  EXPECT_THAT(guessed, EndsWith(0));
  EXPECT_THAT(guessed.out, AllOf(HasSubstr("WARN  one_to_one"), HasSubstr("does not state the image size")));
  EXPECT_THAT(runAlidade({"validate", scratch.path("unsized.yml"), "--image-size", "640x480"}), EndsWith(3));
}

TEST(Validate, ReadsAsOnlyWhatLeavesItsModelOpen) {
  const ScratchFolder scratch;
  const std::string open = opencvCamera("0.01, 0.02, 0.001, 0.002");
  scratch.write("open.yml", replaced(open, "rows: 5", "rows: 4"));
  scratch.write("five.yml", opencvCamera("-0.28, 0.08, 8e-4, -4e-4, -0.01"));
  scratch.write("own.yaml", smallCamera());
  const RunResult result =
      runAlidade({"validate", scratch.path(""), "--read-as", "kannala_brandt", "--json"});
  EXPECT_THAT(result, EndsWith(0));
  const auto files = nlohmann::json::parse(result.out).at("files");
  ASSERT_EQ(files.size(), 3U);
  EXPECT_EQ(files[0].at("cameras").at(0).at("model"), "radtan");
  EXPECT_EQ(files[1].at("cameras").at(0).at("model"), "kannala_brandt");
  EXPECT_EQ(files[2].at("cameras").at(0).at("model"), "pinhole");
  // Who names a file means it.
  const RunResult named = runAlidade({"validate", scratch.path("own.yaml"), "--read-as", "kannala_brandt"});
  EXPECT_THAT(named, EndsWith(3));
  EXPECT_THAT(named.out, HasSubstr("from --read-as"));
}

TEST(Validate, NamesOnlyFlagsThatItHas) {
  const ScratchFolder scratch;
  const std::string photo = scratch.write("flat.pgm", "P5 64 48 255\n" + std::string(64 * 48, 'x'));
  const RunResult result =
      runAlidade({"validate", dataPath("camera.yaml"), "--images", photo, "--board", kBoardSpec});
  EXPECT_THAT(result, FailsWith(1, HasSubstr("alidade detect --debug FOLDER")));
  EXPECT_THAT(runAlidade({"detect", photo, "--board", kBoardSpec, "-o", scratch.path("corners.csv")}).err,
              AllOf(HasSubstr("; --debug FOLDER"), Not(HasSubstr("alidade detect"))));
}

TEST(Validate, StrictFailsWarnings) {
  const ScratchFolder scratch;
  const std::string odd =
      scratch.write("odd.yml", opencvCamera("-0.28, 0.08, 8e-4, -4e-4, -0.01") + "lens: a\n");
  const RunResult passed = runAlidade({"validate", odd});
  EXPECT_THAT(passed, EndsWith(0));
  EXPECT_THAT(passed.out, AllOf(testing::StartsWith("WARN  "), HasSubstr("unknown_keys: "),
                                testing::EndsWith("1 file: 1 passed (1 with warnings), 0 failed\n")));
  const RunResult strict = runAlidade({"validate", odd, "--strict"});
  EXPECT_THAT(strict, EndsWith(3));
  EXPECT_THAT(strict.out,
              AllOf(testing::StartsWith("FAIL  "), testing::EndsWith("1 file: 0 passed, 1 failed\n")));
  // What a file may leave out is no warning.
  EXPECT_THAT(runAlidade({"validate", scratch.write("camera.yaml", smallCamera()), "--strict"}), EndsWith(0));
}

TEST(Validate, SuspectsWhatAFileCannotShowByItself) {
  const ScratchFolder scratch;
  struct Case {
    std::string text;
    std::string row;
    std::string hint;
  };
  const std::string good = opencvCamera("-0.28, 0.08, 8e-4, -4e-4, -0.01");
  const std::vector<Case> cases = {
      // k1 k2 k3 p1 p2
      {opencvCamera("-0.28, 0.08, -0.05, 8e-4, -4e-4"), "FAIL  tangential", "k1 k2 k3 p1 p2"},
      {opencvCamera("0.08, -0.28, -0.1, 0.2, -0.01"), "FAIL  tangential", "in the right order"},
      {opencvCamera("-0.28, 0.08, 0.02, 0.02, 0"), "WARN  tangential", "in the right order"},
      {replaced(replaced(good, "322.5", "238.1"), "534., 238.1", "534., 322.5"), "FAIL  principal_point",
       "swapped"},
      {replaced(replaced(good, "width: 640", "width: 480"), "height: 480", "height: 640"),
       "FAIL  principal_point", "swapped"},
      {replaced(good, "322.5", "450.5"), "WARN  principal_point", "cropped"},
      {replaced(good, "534.", "470."), "WARN  aspect", "square"},
      {replaced(replaced(good, "image_width: 640\n", ""), "image_height: 480\n", ""), "NOTE  image_size",
       "--image-size"},
      {good + "lens: unknown\n", "WARN  unknown_keys", "lens"},
      {good + "R1: [1, 0, 0, 0, 0.9, 0, 0, 0, 1]\n", "NOTE  not_carried", "R1"},
      {good.substr(0, good.find("distortion_coefficients")), "NOTE  assumed", "no distortion coefficients"},
  };
  const std::string path = scratch.write("good.yml", good);
  EXPECT_THAT(runAlidade({"validate", path, "--verbose"}).out,
              Not(AnyOf(HasSubstr("WARN"), HasSubstr("FAIL"))));
  int num_seen = 0;
  for (const Case& c : cases) {
    const RunResult result = runAlidade({"validate", scratch.write("odd.yml", c.text), "--verbose"});
    EXPECT_THAT(result.out, AllOf(HasSubstr(c.row), HasSubstr(c.hint))) << c.text;
    ++num_seen;
  }
  EXPECT_EQ(num_seen, 11);
}

// The camera of a part of an image may have its principal point anywhere. The self-check proves the numbers.
TEST(Validate, PassesTheCameraOfACroppedImage) {
  const ScratchFolder scratch;
  const std::string corner = scratch.path("corner.yaml");
  ASSERT_THAT(runAlidade({"convert", dataPath("camera.yaml"), "-o", corner, "--crop", "400,300,200,150"}),
              EndsWith(0));
  EXPECT_THAT(runAlidade({"validate", corner, "--strict"}), EndsWith(0));
  EXPECT_THAT(runAlidade({"validate", corner, "--verbose"}).out, HasSubstr("NOTE  principal_point"));
}

}  // namespace
}  // namespace alidade
