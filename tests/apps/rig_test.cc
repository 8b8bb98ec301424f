// SPDX-License-Identifier: MIT
#include <cmath>
#include <filesystem>
#include <numeric>
#include <regex>
#include <set>
#include <sstream>
#include <utility>

#include <nlohmann/json.hpp>

#include "alidade/files/camera_source.h"
#include "alidade/files/formats/alidade_writer.h"
#include "alidade/files/rig_file.h"
#include "apps/command_line.h"
#include "apps/report_page.h"
#include "apps/rig_support.h"

namespace alidade {
namespace {

using testing::AllOf;
using testing::HasSubstr;
using testing::Not;

constexpr const char* kModels = "radtan,kannala_brandt";

// Corners files of two different cameras, 120 mm from each other.
class RigCalibrate : public testing::Test {
 protected:
  RigCalibrate() { writeCornersOfPair(scratch_); }
  [[nodiscard]] RunResult calibrate(const std::vector<std::string>& more = {}) const {
    std::vector<std::string> args = {"rig", "calibrate", scratch_.path("left.csv"),
                                     scratch_.path("right.csv")};
    args.insert(args.end(), more.begin(), more.end());
    return runAlidade(args);
  }

  ScratchFolder scratch_;
};

TEST_F(RigCalibrate, WritesAFileOfItsCameras) {
  const RunResult result = calibrate({"--model", kModels, "-o", scratch_.path("rig.yaml")});
  ASSERT_THAT(result, EndsWith(0));
  EXPECT_THAT(result.out,
              AllOf(HasSubstr("2 cameras; 12 boards seen by two or more, in 12 frames"),
                    HasSubstr("Camera    left: radtan, 640x480 px; corners in 12 of 12 images"),
                    HasSubstr("          right: kannala_brandt, 640x480 px; corners in 12 of 12 images")));
  EXPECT_THAT(runAlidade({"validate", scratch_.path("rig.yaml")}), EndsWith(0));
  const std::string file = scratch_.read("rig.yaml");
  EXPECT_THAT(file, AllOf(HasSubstr("alidade_rig: 1\n"), HasSubstr("name: \"right\""),
                          HasSubstr("camera_from_rig_std")));
  const RigRecord rig = loadRig(scratch_.path("rig.yaml"));
  EXPECT_EQ(rigFileText(rig), file);
  ASSERT_EQ(rig.cameras.size(), 2u);
  EXPECT_EQ(rig.covariance.size(), (9u + 8 + 6) * (9 + 8 + 6 + 1) / 2);
  const SE3 truth = pairOfCameras().cameras[1].camera_from_rig;
  const SE3 error = truth.inverse() * rig.cameras[1].camera_from_rig;
  EXPECT_LT(error.translation.norm(), 0.001);
  EXPECT_LT(error.rotation.log().norm(), 0.002);
  // A changed digit is noticed as in a camera file.
  scratch_.write("bad.yaml", replaced(file, "alidade_rig: 1", "alidade_rig: 2"));
  EXPECT_THAT(runAlidade({"project", scratch_.path("bad.yaml#left")}), FailsWith(1, HasSubstr("version")));
}

TEST_F(RigCalibrate, WritesOneJsonDocument) {
  const RunResult result = calibrate({"--model", kModels, "--names", "a,b", "--json"});
  ASSERT_THAT(result, EndsWith(0));
  const auto document = nlohmann::json::parse(result.out);
  ASSERT_EQ(document.at("cameras").size(), 2u);
  EXPECT_EQ(document.at("cameras").at(1).at("name"), "b");
  EXPECT_EQ(document.at("num_linked"), 12);
  EXPECT_LT(document.at("rms_px").get<double>(), 0.1);
  // The distance changes by the part of the position that lies along it.
  const auto& right = document.at("cameras").at(1);
  const auto position_std_m = right.at("position_std_m").get<std::vector<double>>();
  ASSERT_EQ(position_std_m.size(), 3u);
  const double distance_std_m = right.at("distance_std_m");
  EXPECT_GT(distance_std_m, 0);
  EXPECT_LE(distance_std_m, std::hypot(position_std_m[0], position_std_m[1], position_std_m[2]));
  EXPECT_TRUE(document.at("board_shape").at("estimated").is_boolean());
  EXPECT_EQ(document.at("board_shape").at("uneven"), false);
  EXPECT_LT(std::abs(document.at("board_shape").at("bend_x_m").get<double>()), 0.001);
}

// One meaning of a number of frames, whatever other images there are.
TEST_F(RigCalibrate, CountsFramesAlikeEverywhere) {
  std::string corners = scratch_.read("right.csv");
  corners = std::regex_replace(corners, std::regex(",view_012"), ",view_013");
  scratch_.write("right.csv", corners);
  const std::string rig = scratch_.path("rig.yaml");
  const std::string evidence = scratch_.path("rig.json");
  const RunResult run = calibrate({"--model", kModels, "-o", rig, "--evidence", evidence, "--json"});
  ASSERT_THAT(run, EndsWith(0));
  EXPECT_EQ(loadRig(rig).num_frames, 11);
  EXPECT_EQ(nlohmann::json::parse(run.out).at("num_frames"), 11);
  EXPECT_EQ(nlohmann::json::parse(readFile(evidence)).at("num_frames"), 11);
  EXPECT_THAT(calibrate({"--model", kModels}).out, HasSubstr("in 11 frames"));
}

TEST_F(RigCalibrate, HasASummaryLikeThatOfACamera) {
  const auto linesOf = [](const std::string& text) {
    std::vector<std::string> lines;
    std::istringstream stream(text);
    for (std::string line; std::getline(stream, line);) lines.push_back(line);
    return lines;
  };
  int num_checked = 0;
  for (const std::string tolerance : {"1px", "0.1px", "0.001px"}) {
    const RunResult result =
        calibrate({"--model", kModels, "--tolerance", tolerance, "--board-shape", "flat"});
    const std::vector<std::string> lines = linesOf(result.out);
    ASSERT_GE(lines.size(), 8u) << result.err;
    EXPECT_LE(lines.size(), tolerance == "0.001px" ? 40u : 16u) << result.out;  // failures are always told
    for (const std::string& line : lines) EXPECT_LE(line.size(), 100u) << line;
    EXPECT_THAT(lines[0], testing::StartsWith("Verdict   "));
    EXPECT_THAT(lines[1],
                testing::MatchesRegex("Accuracy  within 0[.][0-9]+ px \\(95 %\\) from one camera .*"));
    EXPECT_THAT(result.out, HasSubstr("\nNext      "));
    const bool is_rejected = lines[0].find("rejected: do not use this rig") != std::string::npos;
    EXPECT_EQ(is_rejected, tolerance == "0.001px");
    EXPECT_EQ(is_rejected, lines[2].starts_with("FAILED    ")) << lines[2];
    ++num_checked;
  }
  EXPECT_EQ(num_checked, 3);
}

TEST_F(RigCalibrate, TellsAllDetailsOnRequest) {
  std::array<CornersFile, 2> files = cornersOfPair();
  files[0].views[3].corners[10].pixel.x() += 5;
  writeCornersFile(scratch_.path("left.csv"), files[0]);
  const std::vector<std::string> args = {"--model", kModels, "--tolerance", "0.1px", "--verbose"};
  const RunResult result = calibrate(args);
  ASSERT_THAT(result, EndsWith(0));
  EXPECT_THAT(result.out, AllOf(HasSubstr("Images    12 given, 12 with a board, 12 used"),
                                HasSubstr("Values    fx "), HasSubstr("Pose      at (119."),
                                HasSubstr("Outliers 1 of 648 corners"), HasSubstr("view_004.png corner 10")));
  EXPECT_THAT(std::regex_replace(result.out, std::regex("\\s+"), " "),
              HasSubstr("; 1 outlier Camera left: "));
  // Every diagnosis of the document is there, notes too; what a rig cannot show is not advised.
  std::vector<std::string> json_args = {"--model", kModels, "--tolerance", "0.1px", "--json"};
  const auto document = nlohmann::json::parse(calibrate(json_args).out);
  std::size_t num_advised = 0;
  for (const auto& diagnosis : document.at("diagnoses")) {
    const std::string id = diagnosis.at("id");
    EXPECT_THAT(result.out, HasSubstr("[" + id + "]"));
    num_advised += id == "poor_coverage" ? 1 : 0;
  }
  EXPECT_GE(num_advised, 1u);
  EXPECT_THAT(result.out, AllOf(HasSubstr("run alidade calibrate on the images of this camera"),
                                testing::Not(HasSubstr("the suggested view"))));
}

TEST_F(RigCalibrate, NamesCamerasAfterTheirInputs) {
  for (const std::string folder : {"a", "b"}) {
    scratch_.makeFolder(folder);
    scratch_.write(folder + "/corners.csv", scratch_.read(folder == "a" ? "left.csv" : "right.csv"));
    linkImages(scratch_, "cam." + folder, 1);
    linkImages(scratch_, folder + "/images", 1);
  }
  const RunResult result = runAlidade({"rig", "calibrate", scratch_.path("a/corners.csv"),
                                       scratch_.path("b/corners.csv"), "--model", kModels, "--json"});
  ASSERT_THAT(result, EndsWith(0));
  EXPECT_EQ(nlohmann::json::parse(result.out).at("cameras").at(0).at("name"), "a");
  // An error that names a camera tells the names without a search for boards.
  scratch_.write("camera.yaml", readFile(dataPath("camera.yaml")));
  const auto nameOfFirst = [&](const std::string& first, const std::string& second) {
    return runAlidade({"rig", "calibrate", scratch_.path(first), scratch_.path(second), "--fixed",
                       scratch_.path("camera.yaml") + ",-", "--model", "fov,fov"});
  };
  EXPECT_THAT(nameOfFirst("cam.a", "cam.b"), FailsWith(2, HasSubstr("fov for cam.a, whose lens")));
  EXPECT_THAT(nameOfFirst("a/images", "b/images/"), FailsWith(2, HasSubstr("fov for a, whose lens")));
  EXPECT_THAT(nameOfFirst("a/images/*.png", "b/images/*.png"),
              FailsWith(2, HasSubstr("fov for a, whose lens")));
  EXPECT_THAT(nameOfFirst("cam.a/v*.png", "cam.b/w*.png"), FailsWith(2, HasSubstr("fov for v, whose lens")));
}

TEST_F(RigCalibrate, RefusesOneInputForTwoCameras) {
  linkImages(scratch_, "images", 3);
  std::filesystem::create_directory_symlink(scratch_.path("images"), scratch_.path("other"));
  const auto run = [&](const std::string& first, const std::string& second) {
    return runAlidade({"rig", "calibrate", scratch_.path(first), scratch_.path(second), "--names", "a,b",
                       "--board", kBoardSpec});
  };
  EXPECT_THAT(run("images", "images"), FailsWith(2, HasSubstr("the same input for two cameras")));
  EXPECT_THAT(run("images", "./images/"), FailsWith(2, HasSubstr("the same input for two cameras")));
  EXPECT_THAT(run("images", "other"), FailsWith(2, HasSubstr("the same input for two cameras")));
  EXPECT_THAT(run("left.csv", "left.csv"), FailsWith(2, HasSubstr("the same input for two cameras")));
  EXPECT_THAT(run("images", "images/view_002*.png"),
              FailsWith(2, AllOf(HasSubstr("an image of two cameras"), HasSubstr("view_002.png"))));
  scratch_.write("rig.yaml", rigFileText(pairOfCameras()));
  for (const std::string command : {"validate", "rectify"}) {
    EXPECT_THAT(runAlidade({"rig", command, scratch_.path("rig.yaml"), scratch_.path("left.csv"),
                            scratch_.path("left.csv")}),
                FailsWith(2, HasSubstr("the same input for two cameras")))
        << command;
  }
}

TEST_F(RigCalibrate, WritesAReport) {
  const std::string page = scratch_.path("page.html");
  const std::string evidence = scratch_.path("evidence.json");
  ASSERT_THAT(calibrate({"--model", kModels, "--report", page, "--evidence", evidence}), EndsWith(0));
  const auto document = nlohmann::json::parse(readFile(evidence));
  EXPECT_EQ(document.at("views").size(), 24u);
  const std::string html = readFile(page);
  EXPECT_THAT(html, AllOf(HasSubstr("Rig of 2 cameras"), HasSubstr("id=\"scene\""),
                          HasSubstr("id=\"frame-errors\"")));
  // The cells of the figure have the RMS of the fit.
  const std::string figure = figureOf(html, "frame-errors");
  const std::regex cell("data-count=\"(\\d+)\" data-rms=\"([-0-9.e]+)\"");
  double sum = 0;
  double count = 0;
  for (std::sregex_iterator it(figure.begin(), figure.end(), cell), end; it != end; ++it) {
    sum += std::stod((*it)[1]) * std::pow(std::stod((*it)[2]), 2);
    count += std::stod((*it)[1]);
  }
  EXPECT_EQ(count, 2 * 12 * 54);
  EXPECT_NEAR(std::sqrt(sum / count), document.at("rms_px").get<double>(), 1e-8);
  ASSERT_THAT(runAlidade({"report", evidence, "-o", scratch_.path("again.html")}), EndsWith(0));
  EXPECT_TRUE(scratch_.read("again.html") == html);
  EXPECT_THAT(runAlidade({"report", evidence, "-o", page, "--images", dataPath("images")}),
              FailsWith(2, HasSubstr("--images: 1 inputs for the 2 cameras")));
  EXPECT_THAT(runAlidade({"report", evidence, "-o", page, "--against", dataPath("camera.yaml")}),
              FailsWith(2, HasSubstr("--against")));
  EXPECT_THAT(calibrate({"--report", page, "--evidence", page}), FailsWith(2, HasSubstr("the same file")));
}

TEST_F(RigCalibrate, ShowsEachCameraAsItsOwnPageWould) {
  const std::string page = scratch_.path("page.html");
  const std::string evidence = scratch_.path("evidence.json");
  ASSERT_THAT(calibrate({"--model", kModels, "--report", page, "--evidence", evidence, "--date", "May 2026",
                         "-o", scratch_.path("rig.yaml")}),
              EndsWith(0));
  const std::string html = readFile(page);
  EXPECT_THAT(html, Not(HasSubstr("data:image/jpeg")));
  const auto document = nlohmann::json::parse(readFile(evidence));
  std::set<std::string> opened;
  for (const std::string camera : {"camera0", "camera1"}) {
    EXPECT_THAT(html, AllOf(HasSubstr("<details class=\"file wide\" id=\"" + camera),
                            HasSubstr("href=\"#" + camera)));
    for (const char* id : {"accuracy", "coverage", "distortion-grid", "radial", "image-residuals"})
      EXPECT_THAT(html, HasSubstr("<figure id=\"" + camera + "-" + id + "\"")) << id;
    const std::vector<double> counts = valuesOf(figureOf(html, camera + "-coverage"), "data-count");
    EXPECT_EQ(std::accumulate(counts.begin(), counts.end(), 0.0), 12 * 54);
    const std::string sheet = figureOf(html, camera + "-view-sheet");
    const std::regex view("data-view=\"(\\d+)\"");
    for (std::sregex_iterator it(sheet.begin(), sheet.end(), view), end; it != end; ++it)
      opened.insert((*it)[1]);
  }
  EXPECT_EQ(opened.size(), document.at("views").size());
  const RigRecord rig = loadRig(scratch_.path("rig.yaml"));
  for (const RigCameraRecord& camera : rig.cameras) EXPECT_EQ(camera.camera.calibration->date, "May 2026");
  // Pictures belong to the views of their camera, although those of both have the same names.
  const std::string pictures = scratch_.path("pictures.html");
  scratch_.makeFolder("empty");
  ASSERT_THAT(runAlidade({"report", evidence, "-o", pictures, "--images", dataPath("images"), imagePath(1)}),
              EndsWith(0));
  const std::regex picture("data:image/jpeg");
  const auto numIn = [&](const std::string& id) {
    const std::string figure = figureOf(readFile(pictures), id);
    return std::distance(std::sregex_iterator(figure.begin(), figure.end(), picture), {});
  };
  EXPECT_EQ(numIn("camera0-view-sheet"), 12);
  EXPECT_EQ(numIn("camera1-view-sheet"), 1);
}

TEST_F(RigCalibrate, MatchesImagesByATable) {
  scratch_.write("frames.csv",
                 "left,right\nview_001.png,view_001.png\nview_002.png,view_002.png\n"
                 "view_003.png,view_003.png\nview_004.png,view_004.png\nview_005.png,\n");
  const RunResult result = calibrate({"--model", kModels, "--match", scratch_.path("frames.csv"), "--json"});
  EXPECT_EQ(nlohmann::json::parse(result.out).at("num_linked"), 4);
  EXPECT_THAT(result.err, testing::Not(HasSubstr("note")));
  EXPECT_EQ(nlohmann::json::parse(result.out).at("unmatched").size(), 8u + 8u);
  const RunResult text = calibrate({"--model", kModels, "--match", scratch_.path("frames.csv")});
  EXPECT_THAT(std::regex_replace(text.out, std::regex("\\s+"), " "),
              HasSubstr("; 16 images without a partner"));
  scratch_.write("rig.yaml", rigFileText(pairOfCameras()));
  const RunResult tested =
      runAlidade({"rig", "validate", scratch_.path("rig.yaml"), scratch_.path("left.csv"),
                  scratch_.path("right.csv"), "--match", scratch_.path("frames.csv")});
  EXPECT_THAT(tested, EndsWith(0));
  EXPECT_THAT(tested.out, HasSubstr("Note      16 images have no other camera's image"));
  // A name that no corners file has may be an image without a board, or wrong.
  scratch_.write("frames.csv",
                 "left,right\nview_001.png,view_001.png\nview_002.png,view_002.png\n\n"
                 "view_003.png,view_003.png\nview_004.png,view_004.png\nview_0005.png,view_005.png\n");
  const RunResult noted = calibrate({"--model", kModels, "--match", scratch_.path("frames.csv"), "--json"});
  EXPECT_EQ(nlohmann::json::parse(noted.out).at("num_linked"), 4);
  EXPECT_THAT(noted.err,
              AllOf(HasSubstr("note: 1 image of "), HasSubstr("for example 'view_0005.png' of left ("),
                    HasSubstr("frames.csv:7)")));
  scratch_.write("frames.csv", "left,right\nview_001.png,b/view_001.png\n");
  EXPECT_THAT(
      calibrate({"--quiet", "--match", scratch_.path("frames.csv")}),
      FailsWith(1, AllOf(HasSubstr("frames.csv:2"), HasSubstr("'b/view_001.png', which is no image"))));
  scratch_.write("frames.csv", "left,middle\nview_001.png,view_001.png\n");
  EXPECT_THAT(calibrate({"--quiet", "--match", scratch_.path("frames.csv")}),
              FailsWith(1, AllOf(HasSubstr("no column 'right'"), HasSubstr("left, middle"))));
  scratch_.write("frames.csv", "left,right\nview_001.png\n");
  EXPECT_THAT(calibrate({"--quiet", "--match", scratch_.path("frames.csv")}),
              FailsWith(1, AllOf(HasSubstr("frames.csv:2"), HasSubstr("1 fields"))));
  for (const std::string bad : {"", "left\nx\n", "left,left\nx,y\n", "left,right\n"}) {
    scratch_.write("frames.csv", bad);
    EXPECT_THAT(calibrate({"--quiet", "--match", scratch_.path("frames.csv")}),
                FailsWith(1, HasSubstr("frames.csv")))
        << bad;
  }
}

TEST_F(RigCalibrate, SaysThatItMatchedByNearestTimes) {
  for (const std::string name : {"left", "right"}) {
    const std::string corners = scratch_.read(name + ".csv");
    const std::string last = name == "left" ? "000" : "003";
    scratch_.write(name + ".csv", std::regex_replace(corners, std::regex(",view_(\\d+)"), ",10$1." + last));
  }
  const std::string rig = scratch_.path("rig.yaml");
  const RunResult result = calibrate({"--model", kModels, "-o", rig});
  EXPECT_THAT(result, EndsWith(0));
  const auto joined = [](const RunResult& run) {
    return std::regex_replace(run.out, std::regex("\\s+"), " ");
  };
  const std::string note =
      "Note images were matched by the nearest times in their names; those of one frame differ by up to "
      "0.003 in";
  EXPECT_THAT(joined(result), AllOf(HasSubstr("; matched by nearest times Camera"), HasSubstr(note)));
  const RunResult tested =
      runAlidade({"rig", "validate", rig, scratch_.path("left.csv"), scratch_.path("right.csv")});
  EXPECT_THAT(joined(tested), HasSubstr(note));
}

TEST_F(RigCalibrate, KeepsGivenLenses) {
  const std::string camera = scratch_.path("camera.yaml");
  ASSERT_THAT(runAlidade({"calibrate", scratch_.path("left.csv"), "--model", "radtan", "-o", camera}),
              EndsWith(0));
  const RunResult result = calibrate(
      {"--fixed", camera + ",-", "--model", "auto,kannala_brandt", "-o", scratch_.path("rig.yaml")});
  ASSERT_THAT(result, EndsWith(0));
  const RigRecord rig = loadRig(scratch_.path("rig.yaml"));
  const CameraRecord given = loadCamera(camera);
  EXPECT_THAT(rig.cameras[0].camera.camera.parameters(),
              testing::ElementsAreArray(given.camera.parameters()));
  EXPECT_EQ(rig.cameras[0].camera.calibration->accuracy_px, given.calibration->accuracy_px);
  EXPECT_THAT(calibrate({"--fixed", camera}), FailsWith(2, HasSubstr("1 files for 2 cameras")));
  EXPECT_THAT(calibrate({"--fixed", camera + "," + camera, "-o", camera}),
              FailsWith(2, HasSubstr("this is also an input")));
  EXPECT_THAT(calibrate({"--fixed", camera + ",-", "--model", "pinhole,auto"}),
              FailsWith(2, HasSubstr("pinhole for left, whose lens --fixed keeps")));
  EXPECT_THAT(calibrate({"--fixed", camera + "," + camera, "--model", "pinhole"}),
              FailsWith(2, HasSubstr("pinhole for left")));
}

// Files of cameras belong to the cameras of their names.
TEST_F(RigCalibrate, KeepsGivenLensesByName) {
  const RigRecord truth = pairOfCameras();
  scratch_.write("truth.yaml", rigFileText(truth));
  const std::string left = scratch_.path("truth.yaml#left");
  const std::string right = scratch_.path("truth.yaml#right");
  const std::string rig = scratch_.path("rig.yaml");
  int num_checked = 0;
  for (const std::string& fixed : {left + "," + right, right + "," + left}) {
    const RunResult result = calibrate({"--fixed", fixed, "-o", rig});
    ASSERT_THAT(result, EndsWith(0));
    const bool is_swapped = fixed.starts_with(right);
    EXPECT_EQ(result.err.find("--fixed were assigned to the cameras by their names") != std::string::npos,
              is_swapped);
    for (std::size_t c = 0; c < 2; ++c) {
      EXPECT_EQ(loadRig(rig).cameras[c].camera.camera.modelId(), truth.cameras[c].camera.camera.modelId());
      ++num_checked;
    }
  }
  EXPECT_EQ(num_checked, 4);
  // One file alone, in the wrong place; and one whose file is named.
  ASSERT_THAT(calibrate({"--fixed", right + ",-", "--model", "radtan", "-o", rig}), EndsWith(0));
  EXPECT_THAT(loadRig(rig).cameras[1].camera.camera.parameters(),
              testing::ElementsAreArray(truth.cameras[1].camera.camera.parameters()));
  scratch_.write("right.yaml", smallCamera());
  EXPECT_THAT(calibrate({"--fixed", scratch_.path("right.yaml") + ",-", "--model", "auto,fov", "--quiet"}),
              FailsWith(2, HasSubstr("fov for right, whose lens")));
}

TEST_F(RigCalibrate, IsValidatedByImages) {
  const std::string rig = scratch_.path("rig.yaml");
  ASSERT_THAT(calibrate({"--model", kModels, "-o", rig}), EndsWith(0));
  const std::vector<std::string> inputs = {scratch_.path("left.csv"), scratch_.path("right.csv")};
  const auto validate = [&](const std::string& file, const std::vector<std::string>& more) {
    std::vector<std::string> args = {"rig", "validate", file};
    args.insert(args.end(), more.begin(), more.end());
    return runAlidade(args);
  };
  // Its own images cannot show that it is wrong.
  const RunResult own = validate(rig, inputs);
  EXPECT_THAT(own, EndsWith(0));
  EXPECT_THAT(own.out, AllOf(HasSubstr("Verdict   the images confirm the rig with reservations\n"),
                             HasSubstr("left: the camera was calibrated from these images")));
  const std::string junit = scratch_.path("rig.xml");
  EXPECT_THAT(validate(rig, {inputs[0], inputs[1], "--strict", "--junit", junit}), EndsWith(3));
  EXPECT_THAT(readFile(junit), AllOf(HasSubstr(R"(failures="1")"), HasSubstr("only with reservations")));
  writeCornersOfPair(scratch_, 0.05, 8);
  EXPECT_THAT(validate(rig, {inputs[0], inputs[1], "--strict", "--junit", junit}), EndsWith(0));
  EXPECT_THAT(readFile(junit), HasSubstr(R"(failures="0")"));
  const RunResult run = validate(rig, {inputs[0], inputs[1], "--json"});
  EXPECT_THAT(run, EndsWith(0));
  EXPECT_LT(nlohmann::json::parse(run.out).at("rms_px").get<double>(), 0.1);
  const RunResult text = validate(rig, {inputs[1], inputs[0], "--names", "right,left"});
  EXPECT_THAT(text, EndsWith(0));
  EXPECT_THAT(text.out,
              AllOf(HasSubstr("Verdict   the images confirm the rig\n"), HasSubstr("Camera    left: RMS")));
  // Inputs with the names of the cameras are known by these; under false names, they contradict the rig.
  const RunResult sorted = validate(rig, {inputs[1], inputs[0]});
  EXPECT_THAT(sorted, EndsWith(0));
  EXPECT_THAT(sorted.err, AllOf(HasSubstr("note: the inputs were assigned to the cameras by their names: "),
                                HasSubstr("left.csv to left, "), HasSubstr("right.csv to right")));
  EXPECT_THAT(validate(rig, {inputs[0], inputs[1]}).err, testing::Not(HasSubstr("assigned")));
  EXPECT_THAT(validate(rig, {inputs[1], inputs[0], "--names", "left,right"}), EndsWith(3));
  RigRecord rejected = loadRig(rig);
  rejected.verdict = Verdict::kNo;
  scratch_.write("rejected.yaml", rigFileText(rejected));
  EXPECT_THAT(validate(scratch_.path("rejected.yaml"), inputs).err,
              HasSubstr("rejected.yaml says of itself that it must not be used (verdict: rejected"));
  // Elsewhere.
  RigRecord moved = loadRig(rig);
  moved.cameras[1].camera_from_rig.translation.y() += 0.05;
  scratch_.write("moved.yaml", rigFileText(moved));
  const RunResult no = validate(scratch_.path("moved.yaml"), inputs);
  EXPECT_THAT(no, EndsWith(3));
  EXPECT_THAT(no.err, HasSubstr("error: the images contradict the rig: right stands elsewhere"));
  const std::string page = scratch_.path("rig.html");
  EXPECT_THAT(validate(scratch_.path("moved.yaml"), {inputs[0], inputs[1], "--report", page}), EndsWith(3));
  EXPECT_THAT(readFile(page), AllOf(HasSubstr("The images contradict the rig"), HasSubstr("moved.yaml"),
                                    HasSubstr("Turns by, degrees")));
  EXPECT_THAT(validate(rig, {inputs[0], inputs[1], "--footage", "--report", page}),
              FailsWith(2, HasSubstr("--report with --footage")));
  EXPECT_THAT(validate(rig, {inputs[0]}),
              FailsWith(2, AllOf(HasSubstr("1 input"), HasSubstr("left, right"))));
  EXPECT_THAT(validate(rig, {inputs[0], inputs[1], "--names", "left,middle"}),
              FailsWith(2, AllOf(HasSubstr("'middle'"), HasSubstr("left, right"))));
  EXPECT_THAT(runAlidade({"rig", "validate"}), FailsWith(2, HasSubstr("no rig file")));
}

TEST_F(RigCalibrate, SaysWhatIsWrong) {
  EXPECT_THAT(runAlidade({"rig"}), FailsWith(2, AllOf(HasSubstr("rig: no command"), HasSubstr("calibrate"))));
  EXPECT_THAT(runAlidade({"rig", "solve"}), FailsWith(2, HasSubstr("solve")));
  EXPECT_THAT(runAlidade({"rig", "calibrate", scratch_.path("left.csv")}),
              FailsWith(2, HasSubstr("1 input")));
  EXPECT_THAT(calibrate({"--names", "left,left"}),
              FailsWith(2, AllOf(HasSubstr("a different name for each camera"), HasSubstr("--names"))));
  EXPECT_THAT(calibrate({"--model", "radtan,radtan,radtan"}),
              FailsWith(2, HasSubstr("3 models for 2 cameras")));
  EXPECT_THAT(calibrate({"--model", "radtam"}), FailsWith(2, HasSubstr("radtam")));
  EXPECT_THAT(calibrate({"-o", scratch_.path("left.csv")}), FailsWith(2, HasSubstr("this is also an input")));
  // Views of other moments link nothing.
  std::string others = scratch_.read("right.csv");
  for (std::size_t at = others.find(",view_0"); at != std::string::npos;
       at = others.find(",view_0", at + 1)) {
    others.replace(at, 7, ",view_9");
    std::swap(others[at + 7], others[at + 8]);  // in another order, or they would be a later recording
  }
  scratch_.write("right.csv", others);
  EXPECT_THAT(calibrate({"--quiet"}),
              FailsWith(1, AllOf(HasSubstr("nothing links: left | right"), HasSubstr("next: "))));
}

}  // namespace
}  // namespace alidade
