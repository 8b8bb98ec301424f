// SPDX-License-Identifier: MIT
#include <cmath>
#include <filesystem>

#include <nlohmann/json.hpp>

#include "alidade/files/formats/alidade_writer.h"
#include "apps/command_line.h"
#include "apps/rig_support.h"

namespace alidade {
namespace {

using nlohmann::json;
using testing::AllOf;
using testing::HasSubstr;
using testing::Not;

std::string otherCamera(const ScratchFolder& scratch, const std::string& name, const std::string& from,
                        const std::string& to) {
  return scratch.write(name, replaced(smallCamera(), from, to));
}

json diffJson(std::vector<std::string> args, int exit_code = 0) {
  args.insert(args.begin(), "diff");
  args.emplace_back("--json");
  const RunResult result = runAlidade(args);
  EXPECT_THAT(result, EndsWith(exit_code));
  return json::parse(result.out);
}

TEST(Diff, OfACameraWithItselfIsZero) {
  const RunResult result = runAlidade(
      {"diff", dataPath("camera.yaml"), dataPath("camera.yaml"), "--tolerance", "1e-9", "--verbose"});
  ASSERT_THAT(result, EndsWith(0));
  EXPECT_THAT(result.out, testing::StartsWith("same: the cameras differ by 0 px (95 %); limit 1e-09 px\n"));
  EXPECT_THAT(result.out, AllOf(HasSubstr("by a rotation of 0 degrees"), HasSubstr("1200 of 1200 pixels"),
                                HasSubstr("Grid"), Not(HasSubstr("nan")), HasSubstr("Diff     none"),
                                Not(HasSubstr("e-1"))));
  EXPECT_EQ(result.err, "");
}

TEST(Diff, ReturnsTheQuarterTurnOfAConvertedCamera) {
  const ScratchFolder scratch;
  int num_checked = 0;
  for (const int degrees : {90, 180, 270}) {
    const std::string turned = scratch.path("turned.yaml");
    ASSERT_THAT(
        runAlidade({"convert", dataPath("camera.yaml"), "-o", turned, "--rotate", std::to_string(degrees)}),
        EndsWith(0));
    const json document = diffJson({dataPath("camera.yaml"), turned, "--rotate", std::to_string(degrees)});
    EXPECT_LE(document.at("max_px").get<double>(), 1e-9);
    EXPECT_NEAR(document.at("b_from_a").at("angle_deg").get<double>(), std::min(degrees, 360 - degrees),
                1e-9);
    EXPECT_EQ(document.at("image_turn_deg"), degrees);
    if (degrees != 180) {  // the sizes tell
      const json found = diffJson({dataPath("camera.yaml"), turned});
      EXPECT_EQ(found.at("image_turn_deg"), degrees);
      EXPECT_LE(found.at("max_px").get<double>(), 1e-9);
    } else {
      EXPECT_THAT(runAlidade({"diff", dataPath("camera.yaml"), turned}).out, HasSubstr("--rotate 180"));
    }
    ++num_checked;
  }
  EXPECT_EQ(num_checked, 3);
}

TEST(Diff, IsSymmetricAcrossResolutions) {
  const ScratchFolder scratch;
  const std::string half = scratch.path("half.yaml");
  ASSERT_THAT(runAlidade({"convert", dataPath("camera.yaml"), "-o", half, "--resize", "320x240", "--model",
                          "kannala_brandt", "--max-error", "5"}),
              EndsWith(0));
  const json there = diffJson({dataPath("camera.yaml"), half, "--tolerance", "5"});
  const json back = diffJson({half, dataPath("camera.yaml"), "--tolerance", "5"});
  for (const char* key : {"mean_px", "rms_px", "p95_px", "max_px"})
    EXPECT_NEAR(there.at(key).get<double>(), back.at(key).get<double>(), 1e-7) << key;
  EXPECT_EQ(there.at("pixels_of"), back.at("pixels_of"));
  EXPECT_EQ(there.at("pixels_of").at("width"), 640);
  const auto q = there.at("b_from_a").at("quaternion_xyzw");
  const auto p = back.at("b_from_a").at("quaternion_xyzw");
  for (std::size_t i = 0; i < 3; ++i) EXPECT_NEAR(q[i].get<double>(), -p[i].get<double>(), 1e-9);
}

TEST(Diff, ReturnsAKnownShiftInOneFrame) {
  const ScratchFolder scratch;
  const std::string a = scratch.write("a.yaml", smallCamera());
  const std::string b = otherCamera(scratch, "b.yaml", "cx: 320", "cx: 320.5");
  const json document = diffJson({a, b, "--same-frame", "--grid", "5x4"}, 3);
  EXPECT_NEAR(document.at("mean_px").get<double>(), 0.5, 1e-6);
  EXPECT_NEAR(document.at("max_px").get<double>(), 0.5, 1e-6);
  const json& grid = document.at("grid");
  EXPECT_EQ(grid.at("columns"), 5);
  ASSERT_EQ(grid.at("difference_px").size(), 4u);
  ASSERT_EQ(grid.at("difference_px")[0].size(), 5u);
  EXPECT_NEAR(grid.at("difference_px")[3][4][0].get<double>(), 0.5, 1e-6);
  EXPECT_NEAR(grid.at("difference_px")[3][4][1].get<double>(), 0, 1e-6);
  EXPECT_EQ(document.at("significance"), nullptr);
}

TEST(Diff, TakesOutAPoseAtADistance) {
  const ScratchFolder scratch;
  const std::string a = scratch.write("a.yaml", smallCamera());
  const std::string b = otherCamera(scratch, "b.yaml", "fx: 500", "fx: 505");
  const json far = diffJson({a, b}, 3);
  const json near = diffJson({a, b, "--distance", "2m"}, 3);
  const json nearer = diffJson({a, b, "--distance", "100 cm"}, 3);
  EXPECT_EQ(near, diffJson({a, b, "--distance", "2"}, 3));
  EXPECT_LT(near.at("rms_px").get<double>(), far.at("rms_px").get<double>());
  EXPECT_EQ(near.at("rms_px"), nearer.at("rms_px"));
  const double z = near.at("b_from_a").at("translation_m")[2];
  EXPECT_GT(std::abs(z), 1e-4);
  EXPECT_NEAR(z, 2 * nearer.at("b_from_a").at("translation_m")[2].get<double>(), 1e-9);
}

TEST(Diff, SaysNoBeyondTheTolerance) {
  const ScratchFolder scratch;
  const std::string a = scratch.write("a.yaml", smallCamera());
  const std::string b = otherCamera(scratch, "b.yaml", "fx: 500", "fx: 505");
  const RunResult usual = runAlidade({"diff", a, b});
  EXPECT_THAT(usual, EndsWith(3));
  EXPECT_THAT(usual.out, AllOf(testing::StartsWith("changed: the cameras differ by "),
                               HasSubstr("; limit 0.2 px\n"), Not(HasSubstr("Grid"))));
  const RunResult same = runAlidade({"diff", a, b, "--tolerance", "20"});
  EXPECT_THAT(same, EndsWith(0));
  EXPECT_THAT(same.out, testing::StartsWith("same: "));
  EXPECT_THAT(runAlidade({"diff", a, b, "--quiet"}).out, "");
  const RunResult result = runAlidade({"diff", a, b, "--tolerance", "0.5px"});
  EXPECT_THAT(result, EndsWith(3));
  EXPECT_THAT(result.err, HasSubstr("error: changed: the cameras differ by"));
  EXPECT_THAT(result.out, HasSubstr("neither file states a covariance"));
  EXPECT_EQ(diffJson({a, b, "--tolerance", "0.5"}, 3).at("agrees"), false);
}

TEST(Diff, SaysWhetherADifferenceIsSignificant) {
  const ScratchFolder scratch;
  const std::string all = scratch.path("all.yaml");
  ASSERT_THAT(runAlidade({"calibrate", dataPath("corners.csv"), "--model", "radtan", "-o", all}),
              EndsWith(0));
  // The truth, and the same with another focal length.
  const json truth = diffJson({dataPath("camera.yaml"), all});
  EXPECT_EQ(truth.at("answer"), "same");
  EXPECT_EQ(truth.at("agrees"), true);
  ASSERT_NE(truth.at("significance"), nullptr);
  EXPECT_EQ(truth.at("significance").at("significant"), false) << truth.at("significance");
  const std::string wrong = scratch.write(
      "wrong.yaml", replaced(replaced(smallCamera(), "fx: 500, fy: 501, cx: 320, cy: 240",
                                      "fx: 545, fy: 544, cx: 322.5, cy: 238.1, k1: -0.28, k2: 0.08, p1: "
                                      "0.0008, p2: -0.0004, k3: -0.01"),
                             "model: pinhole", "model: radtan"));
  const json other = diffJson({all, wrong, "--tolerance", "0.5"}, 3);
  EXPECT_EQ(other.at("significance").at("significant"), true) << other.at("significance");
  EXPECT_THAT(
      runAlidade({"diff", all, wrong}).out,
      AllOf(HasSubstr("sigma: significant"), HasSubstr("B states no covariance and is assumed to be exact")));
}

TEST(Diff, RefusesImagesOfDifferentShape) {
  const ScratchFolder scratch;
  const std::string a = scratch.write("a.yaml", smallCamera());
  const std::string b = otherCamera(scratch, "b.yaml", "height: 480", "height: 360");
  EXPECT_THAT(runAlidade({"diff", a, b}),
              FailsWith(1, AllOf(HasSubstr("640x480 and 640x360"), HasSubstr("--crop X,Y,640,360"))));
  EXPECT_THAT(runAlidade({"diff", a, a, "--rotate", "90"}),
              FailsWith(2, HasSubstr("a rotation by 90 degrees")));
}

TEST(Diff, DrawsTheDifference) {
  const ScratchFolder scratch;
  const std::string a = scratch.write("a&b\x01.yaml", smallCamera());
  const std::string b = otherCamera(scratch, "b.yaml", "fx: 500", "fx: 505");
  const std::string figure = scratch.path("figure.svg");
  const RunResult result = runAlidade({"diff", a, b, "-o", figure});
  ASSERT_THAT(result, EndsWith(3));
  EXPECT_THAT(result.err, HasSubstr("written to " + figure));
  EXPECT_THAT(scratch.read("figure.svg"),
              AllOf(testing::StartsWith("<svg "), HasSubstr(R"(a&amp;b\x01.yaml: pinhole, 640x480 px)"),
                    HasSubstr("b.yaml: pinhole"), HasSubstr("Aligned: by a rotation of"),
                    HasSubstr("Diff: mean"), HasSubstr("at most "), Not(HasSubstr("Grid"))));
  EXPECT_EQ(runAlidade({"diff", a, b, "-o", figure, "--json"}).out, runAlidade({"diff", a, b, "--json"}).out);

  int num_refused = 0;
  for (const std::string name : {"figure.png", "-", "figure.yaml", "svg"}) {
    EXPECT_THAT(runAlidade({"diff", a, b, "-o", name}), FailsWith(2, HasSubstr("ends in .svg")));
    ++num_refused;
  }
  EXPECT_EQ(num_refused, 4);
  EXPECT_THAT(runAlidade({"diff", a, b, "-o", scratch.path("none/figure.svg")}),
              FailsWith(1, HasSubstr("none")));
}

TEST(Diff, PrintsNoFigureWhereTheRotationIsNotFound) {
  const ScratchFolder scratch;
  // Of a long lens and a fisheye, no rotation makes one like the other.
  const std::string size = "alidade_camera: 1\nimage_size: {width: 640, height: 480}\n";
  const std::string a = scratch.write(
      "a.yaml",
      size +
          "model: radtan\nparameters: {fx: 533, fy: 532, cx: 342, cy: 234, k1: -0.28, k2: 0.06, p1: "
          "0.001, p2: -0.0005, k3: 0.01}\n");
  const std::string b = scratch.write(
      "b.yaml", size +
                    "model: kannala_brandt\nparameters: {fx: 190, fy: 190, cx: 320, cy: 240, k1: 0.01, k2: "
                    "-0.005, k3: 0.001, k4: 0}\n");
  const std::string figure = scratch.path("figure.svg");
  const RunResult result = runAlidade({"diff", a, b, "-o", figure});
  EXPECT_THAT(result, EndsWith(3));
  EXPECT_THAT(result.out,
              AllOf(HasSubstr("Aligned  no:"), Not(HasSubstr("Diff   ")), Not(HasSubstr("Grid"))));
  EXPECT_THAT(result.err, AllOf(HasSubstr("too little in common"), HasSubstr("figure.svg was not written")));
  EXPECT_FALSE(scratch.has("figure.svg"));

  const json document = diffJson({a, b}, 3);
  EXPECT_EQ(document.at("converged"), false);
  EXPECT_EQ(document.at("agrees"), nullptr);
  int num_null = 0;
  for (const char* key :
       {"b_from_a", "image_turn_deg", "num_compared", "num_seen_by_one", "num_seen_by_neither", "mean_px",
        "rms_px", "p95_px", "max_px", "worst_pixel", "significance"}) {
    EXPECT_EQ(document.at(key), nullptr) << key;
    ++num_null;
  }
  EXPECT_EQ(num_null, 11);
  std::size_t num_pixels = 0;
  for (const json& row : document.at("grid").at("difference_px")) {
    for (const json& difference : row) num_pixels += difference.is_null() ? 1 : 0;
  }
  EXPECT_EQ(num_pixels, 1200U);
}

TEST(Diff, SuspectsAPartOfAnImage) {
  const ScratchFolder scratch;
  const std::string whole = dataPath("camera.yaml");
  const std::string part = scratch.path("part.yaml");
  const std::string half = scratch.path("half.yaml");
  ASSERT_THAT(runAlidade({"convert", whole, "-o", part, "--crop", "100,50,320,240"}), EndsWith(0));
  ASSERT_THAT(runAlidade({"convert", whole, "-o", half, "--resize", "320x240"}), EndsWith(0));
  const std::string crop = "alidade convert " + whole + " -o cropped.yaml --crop 100,50,320,240";
  EXPECT_THAT(runAlidade({"diff", whole, part}).err, AllOf(HasSubstr("note: "), HasSubstr(crop)));
  EXPECT_THAT(runAlidade({"diff", part, whole}).err, AllOf(HasSubstr("note: "), HasSubstr(crop)));
  EXPECT_THAT(runAlidade({"diff", part, whole, "--quiet"}).err, Not(HasSubstr("note: ")));
  EXPECT_EQ(runAlidade({"diff", whole, half}).err, "");
  EXPECT_EQ(runAlidade({"diff", whole, whole}).err, "");
}

// A short fisheye and a radtan camera: both have a ray for every pixel, but the formula of the one puts what
// the other sees at its border anywhere.
TEST(Diff, CountsWhatIsFarOutsideTheImageAsSeenByOneCamera) {
  const ScratchFolder scratch;
  const std::string narrow =
      scratch.write("narrow.yaml",
                    "alidade_camera: 1\nmodel: radtan\nimage_size: {width: 640, height: 480}\n"
                    "parameters: {fx: 533, fy: 532, cx: 342, cy: 234, k1: -0.28, k2: 0.06, p1: 0.001, p2: "
                    "-0.0005, k3: 0.01}\n");
  const std::string wide = scratch.write(
      "wide.yaml",
      "alidade_camera: 1\nmodel: kannala_brandt\nimage_size: {width: 640, height: 480}\n"
      "parameters: {fx: 190, fy: 190, cx: 320, cy: 240, k1: 0.01, k2: -0.005, k3: 0.001, k4: 0}\n");
  constexpr double kDiagonalPx = 800;
  int num_compared = 0;
  for (const auto& files : {std::pair(narrow, wide), std::pair(wide, narrow)}) {
    const json document = diffJson({files.first, files.second, "--same-frame"}, 3);
    EXPECT_LE(document.at("max_px").get<double>(), kDiagonalPx);
    EXPECT_GT(document.at("num_seen_by_one").get<int>(), 60);  // 5 % of 1200
    EXPECT_GT(document.at("num_compared").get<int>(), 100);
    EXPECT_EQ(document.at("agrees"), nullptr);
    ++num_compared;
  }
  EXPECT_EQ(num_compared, 2);
  EXPECT_THAT(
      runAlidade({"diff", narrow, wide, "--same-frame"}),
      AllOf(EndsWith(3), testing::Field(&RunResult::err, HasSubstr("pixels are seen by both cameras")),
            testing::Field(&RunResult::out, Not(HasSubstr("upside down")))));
}

TEST(Diff, AsksForAGridThatIsFineEnough) {
  const ScratchFolder scratch;
  const std::string a = scratch.write("a.yaml", smallCamera());
  const std::string b = otherCamera(scratch, "b.yaml", "cx: 320", "cx: 320.5");
  for (const char* grid : {"1x1", "2x1", "1x2"})
    EXPECT_THAT(runAlidade({"diff", a, b, "--grid", grid}),
                FailsWith(2, AllOf(HasSubstr(std::string("--grid ") + grid), HasSubstr("at least 3 pixels"),
                                   HasSubstr("--same-frame"))))
        << grid;
  EXPECT_THAT(runAlidade({"diff", a, b, "--grid", "5x1", "--distance", "1"}),
              FailsWith(2, HasSubstr("at least 6 pixels")));
  EXPECT_THAT(runAlidade({"diff", a, b, "--grid", "3x1", "--tolerance", "9"}), EndsWith(0));
  EXPECT_THAT(runAlidade({"diff", a, b, "--grid", "3x2", "--distance", "1", "--tolerance", "9"}),
              EndsWith(0));
  EXPECT_THAT(runAlidade({"diff", a, b, "--grid", "1x1", "--same-frame", "--tolerance", "9"}), EndsWith(0));
}

TEST(Diff, TellsThatSizesWereRounded) {
  const ScratchFolder scratch;
  const std::string large = scratch.write("large.yaml", smallCamera());
  const std::string uneven = scratch.path("uneven.yaml");
  const std::string even = scratch.path("even.yaml");
  ASSERT_THAT(runAlidade({"convert", large, "-o", uneven, "--resize", "213x160"}), EndsWith(0));
  ASSERT_THAT(runAlidade({"convert", large, "-o", even, "--resize", "320x240"}), EndsWith(0));
  const std::string note = "213x160 px is not 640x480 px resized by one factor";
  EXPECT_THAT(runAlidade({"diff", large, uneven}).err,
              AllOf(HasSubstr(note), HasSubstr("up to 0.25 px (of the 640x480 image)")));
  EXPECT_THAT(runAlidade({"diff", uneven, large}).err, HasSubstr(note));
  EXPECT_EQ(runAlidade({"diff", uneven, large, "--quiet"}).err, "");
  EXPECT_EQ(runAlidade({"diff", large, even}).err, "");
}

// Neither of two files with a large covariance shows whether the camera is the same one.
TEST(Diff, SaysWhenNobodyCanTell) {
  const ScratchFolder scratch;
  const std::string first = scratch.path("first.yaml");
  const std::string second = dataPath("camera.yaml");  // the truth
  ASSERT_THAT(
      runAlidade({"calibrate", dataPath("images"), "--board", kBoardSpec, "--model", "radtan", "-o", first}),
      EndsWith(0));
  const RunResult unknown = runAlidade({"diff", first, second, "--tolerance", "0.001"});
  EXPECT_THAT(unknown, EndsWith(3));
  EXPECT_THAT(unknown.out, AllOf(testing::StartsWith("cannot tell: the cameras differ by "),
                                 HasSubstr("their uncertainty alone makes")));
  EXPECT_THAT(runAlidade({"diff", first, second, "--tolerance", "0.001", "--allow-unknown"}), EndsWith(0));
  // The same question to another command.
  const RunResult judged =
      runAlidade({"validate", first, "--against", second, "--tolerance", "0.001", "--verbose"});
  EXPECT_THAT(judged.out, HasSubstr("cannot tell: the cameras differ by "));
  EXPECT_THAT(runAlidade({"validate", first, "--against", second, "--tolerance", "0.001", "--strict"}),
              EndsWith(3));
  // A copy is the same, whatever its covariance.
  const std::string copy = scratch.path("copy.yaml");
  ASSERT_THAT(runAlidade({"convert", first, "-o", copy, "--to", "ros"}), EndsWith(0));
  EXPECT_THAT(runAlidade({"diff", first, copy, "--tolerance", "0.001"}), EndsWith(0));
}

class DiffFolders : public testing::Test {
 protected:
  DiffFolders() {
    for (const char* folder : {"a", "b"}) std::filesystem::create_directory(scratch_.path(folder));
    scratch_.write("a/one.yaml", smallCamera());
    scratch_.write("b/renamed.yaml", smallCamera() + "camera: {name: front}\n");
    scratch_.write("a/two.yaml", smallCamera());
    scratch_.write("b/two.yaml", replaced(smallCamera(), "fx: 500", "fx: 505"));
    scratch_.write("a/front.yaml", smallCamera() + "camera: {name: front}\n");
    scratch_.write("b/notes.yaml", "lens: none\n");
  }

  [[nodiscard]] RunResult diff(std::vector<std::string> more = {}) const {
    more.insert(more.begin(), {"diff", scratch_.path("a"), scratch_.path("b")});
    return runAlidade(more);
  }

  ScratchFolder scratch_;
};

TEST_F(DiffFolders, PairsTheirCameras) {
  const RunResult result = diff({"--junit", scratch_.path("r.xml"), "--report", scratch_.path("p.html")});
  EXPECT_THAT(result, EndsWith(3));
  EXPECT_THAT(result.out, AllOf(testing::StartsWith("changed: 1 of 3 cameras; cannot tell: 1; same: 1\n"),
                                HasSubstr("changed      two.yaml"), HasSubstr("same         front "),
                                HasSubstr("cannot tell  one.yaml"), HasSubstr("no such camera in B")));
  const std::string junit = scratch_.read("r.xml");
  EXPECT_THAT(junit, AllOf(HasSubstr(R"(tests="3" failures="2")"), HasSubstr(R"(name="two.yaml")"),
                           HasSubstr("changed: the cameras differ by")));
  EXPECT_THAT(scratch_.read("p.html"), AllOf(HasSubstr("Changed: 1 of 3 cameras"), HasSubstr("two.yaml"),
                                             HasSubstr("id=\"pair0-difference\"")));
  const json document = json::parse(diff({"--json"}).out);
  EXPECT_EQ(document.at("answer"), "changed");
  EXPECT_EQ(document.at("pairs").size(), 3U);
}

TEST_F(DiffFolders, MissNoCamera) {
  EXPECT_THAT(diff({"--tolerance", "20", "--allow-unknown"}), EndsWith(3));
  scratch_.write("b/one.yaml", smallCamera());
  EXPECT_THAT(diff({"--tolerance", "20"}), EndsWith(0));
  scratch_.write("b/broken.yaml", "alidade_camera: 1\nmodel: radtan\n");
  EXPECT_THAT(diff({"--tolerance", "20", "--allow-unknown"}), EndsWith(3));
}

// The report of an earlier run must not remain.
TEST_F(DiffFolders, ReportErrorsToo) {
  const std::string report = scratch_.path("r.xml");
  scratch_.write("b/one.yaml", smallCamera());
  ASSERT_THAT(diff({"--tolerance", "20", "--junit", report}), EndsWith(0));
  std::filesystem::create_directory(scratch_.path("empty"));
  EXPECT_THAT(runAlidade({"validate", scratch_.path("empty"), "--junit", report}),
              FailsWith(1, HasSubstr("no file")));
  EXPECT_THAT(scratch_.read("r.xml"), AllOf(HasSubstr(R"(errors="1")"), HasSubstr("alidade validate")));
}

// ROS states the place of a camera in a pair, which is no part of the camera.
TEST_F(DiffFolders, SayIfOnlyTheRigChanged) {
  const std::string rig = scratch_.write("rig.yaml", rigFileText(pairOfCameras()));
  RigRecord other = pairOfCameras();
  other.cameras[1].camera_from_rig.rotation =
      SO3::exp(Eigen::Vector3d(0.01, 0, 0)) * other.cameras[1].camera_from_rig.rotation;
  const std::string turned = scratch_.write("turned.yaml", rigFileText(other));
  const RunResult result = runAlidade({"diff", rig + "#right", turned + "#right"});
  EXPECT_THAT(result, EndsWith(0));
  EXPECT_THAT(result.out, testing::StartsWith("same: the cameras differ by 0 px (95 %); limit 0.2 px; their "
                                              "poses in a rig differ by 0.573 degrees"));
  EXPECT_THAT(runAlidade({"diff", rig, turned}).out, testing::StartsWith("changed: "));
}

TEST_F(DiffFolders, RefuseAFolderAndAFile) {
  EXPECT_THAT(runAlidade({"diff", scratch_.path("a"), scratch_.path("b/two.yaml")}),
              FailsWith(2, AllOf(HasSubstr("is a folder"), HasSubstr("name the file in the folder"))));
  EXPECT_THAT(diff({"-o", scratch_.path("x.svg")}), FailsWith(2, HasSubstr("--report page.html")));
  EXPECT_THAT(diff({"--junit", scratch_.path("a/two.yaml")}), FailsWith(2, HasSubstr("no JUnit report")));
  EXPECT_THAT(runAlidade({"diff", scratch_.path("a"), scratch_.path("nowhere")}),
              FailsWith(1, HasSubstr("nowhere: no such file or folder")));
  std::filesystem::create_directory(scratch_.path("empty"));
  EXPECT_THAT(runAlidade({"diff", scratch_.path("a"), scratch_.path("empty")}),
              FailsWith(1, HasSubstr("empty")));
}

TEST(Diff, ShortensLongNamesInTheFigure) {
  const ScratchFolder scratch;
  const std::string name = std::string(190, 'n') + ".yaml";
  const std::string file = scratch.write(name, smallCamera());
  const std::string figure = scratch.path("difference.svg");
  ASSERT_THAT(runAlidade({"diff", file, file, "-o", figure}), EndsWith(0));
  const std::string svg = readFile(figure);
  EXPECT_THAT(svg,
              AllOf(Not(HasSubstr(std::string(100, 'n'))), HasSubstr("nnn...nnn"), HasSubstr("nnn.yaml:")));
}

}  // namespace
}  // namespace alidade
