// SPDX-License-Identifier: MIT
#include <algorithm>
#include <cmath>
#include <filesystem>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "alidade/core/text.h"
#include "alidade/files/camera_source.h"
#include "alidade/files/formats/alidade_writer.h"
#include "alidade/files/formats/camera_format.h"
#include "apps/command_line.h"
#include "support/corners_text.h"

namespace alidade {
namespace {

using testing::AllOf;
using testing::ElementsAre;
using testing::HasSubstr;
using testing::Not;

TEST(Calibrate, RecoversTheTrueCamera) {
  const ScratchFolder scratch;
  const std::string output = scratch.path("camera.yaml");
  const RunResult result =
      runAlidade({"calibrate", dataPath("images"), "--board", kBoardSpec, "-o", output, "--verbose"});
  ASSERT_THAT(result, EndsWith(0));
  EXPECT_THAT(result.err, HasSubstr("written to " + output));
  EXPECT_THAT(result.out, AllOf(HasSubstr("12 given, 12 with the board, 12 used"), Not(HasSubstr("FAILED"))));
  const CameraRecord truth = onlyCamera(parseCameras(readFile(dataPath("camera.yaml")), "truth"));
  const CameraRecord found = onlyCamera(parseCameras(scratch.read("camera.yaml"), "found"));
  ASSERT_TRUE(found.calibration);
  ASSERT_EQ(found.calibration->parameter_std.size(), 9u);
  constexpr double kSigmas = 4;
  for (std::size_t i = 0; i < 9; ++i) {
    EXPECT_NEAR(found.camera.parameters()[i], truth.camera.parameters()[i],
                kSigmas * found.calibration->parameter_std[i])
        << found.camera.parameterNames()[i];
  }
  EXPECT_THAT(runAlidade({"validate", output}), EndsWith(0));
  EXPECT_THAT(scratch.list(), ElementsAre("camera.yaml"));
}

// The images of testdata/, and those of a camera with a longer lens, in two folders with names that match.
TEST(Calibrate, NamesTheCommandForFoldersOfTwoCameras) {
  const ScratchFolder scratch;
  const std::string scene = readFile(dataPath("../checkerboard.yaml"));
  scratch.write("scene.yaml", replaced(scene, "fx: 535, fy: 534", "fx: 635, fy: 634"));
  const RunOptions here = {.folder = scratch.path()};
  ASSERT_THAT(runAlidade({"simulate", "scene.yaml", "-o", "long", "--quiet"}, here), EndsWith(0));
  std::filesystem::rename(scratch.path("long/images"), scratch.path("right"));
  linkImages(scratch, "left", kNumImages);
  const std::string command =
      std::string("alidade rig calibrate left right --board ") + kBoardSpec + " -o rig.yaml";
  const RunResult both =
      runAlidade({"calibrate", "left", "right", "--board", kBoardSpec, "-o", "c.yaml"}, here);
  EXPECT_THAT(both, EndsWith(3));
  EXPECT_THAT(both.err,
              AllOf(HasSubstr("note: images match by name; if each folder is of one camera: " + command),
                    HasSubstr("several cameras"), HasSubstr("\n  next: fix zoom and focus"),
                    HasSubstr("separately; if each folder is of one camera: " + command + "\n")));
  // One camera in two folders whose names do not match gets no hint, and is calibrated.
  linkImages(scratch, "more", kNumImages);
  for (const auto& entry : std::filesystem::directory_iterator(scratch.path("more"))) {
    const std::string name = entry.path().filename().string();
    std::filesystem::rename(entry.path(), entry.path().parent_path() / ("9" + name.substr(name.size() - 7)));
  }
  const RunResult one = runAlidade({"calibrate", "left", "more", "--board", kBoardSpec}, here);
  EXPECT_THAT(one, EndsWith(0));
  EXPECT_THAT(one.err, Not(HasSubstr("rig calibrate")));
}

TEST(Calibrate, StatesItsUncertaintyEverywhereAlike) {
  const ScratchFolder scratch;
  const std::string output = scratch.path("camera.yaml");
  const RunResult result = runAlidade({"calibrate", dataPath("corners.csv"), "-o", output, "--verbose"});
  ASSERT_THAT(result, EndsWith(0));
  EXPECT_THAT(result.out,
              AllOf(HasSubstr("distant points"), HasSubstr("at worst"), HasSubstr("board distance")));
  const RunResult as_json = runAlidade({"calibrate", dataPath("corners.csv"), "--json", "-o", output});
  ASSERT_THAT(as_json, EndsWith(0));
  const nlohmann::json document = nlohmann::json::parse(as_json.out);
  const nlohmann::json& infinity = document.at("projection_std").at("infinity");
  const nlohmann::json& near = document.at("projection_std").at("board_distance");
  EXPECT_LT(near.at("worst_px").get<double>(), infinity.at("worst_px").get<double>());
  ASSERT_EQ(infinity.at("std_px").size(), infinity.at("rows").get<std::size_t>());
  ASSERT_EQ(infinity.at("std_px").at(0).size(), infinity.at("columns").get<std::size_t>());
  EXPECT_EQ(document.at("covariance").size(), 45u);
  EXPECT_GT(document.at("parameter_std_by_view").at("fx").get<double>(), 0);

  const std::string text = scratch.read("camera.yaml");
  const CameraRecord file = onlyCamera(parseCameras(text, "camera.yaml"));
  ASSERT_TRUE(file.calibration);
  EXPECT_NEAR(file.calibration->accuracy_px, document.at("accuracy").at("covered_px").get<double>(),
              0.006 * file.calibration->accuracy_px);
  EXPECT_EQ(file.calibration->covariance, document.at("covariance").get<std::vector<double>>());
  EXPECT_LE(std::count(text.begin(), text.end(), '\n'), 60);
  EXPECT_LE(text.size(), 4096u);
  EXPECT_EQ(cameraFileText(file), text) << "read back equal";
}

TEST(Calibrate, WritesAnyFormatWithAModelThatItHolds) {
  int num_formats = 0;
  for (const CameraFormat* const known : cameraFormats()) {
    const std::string format(known->id);
    if (known->write == nullptr || !known->holds_size || format == "alidade") continue;
    SCOPED_TRACE(format);
    const ScratchFolder scratch;
    const std::string output =
        scratch.path(format == "colmap" || format == "ocam" ? "camera.txt" : "camera.yaml");
    const RunResult result = runAlidade({"calibrate", dataPath("corners.csv"), "--to", format, "-o", output});
    ASSERT_THAT(result, EndsWith(0)) << format;
    EXPECT_THAT(result.err, HasSubstr("without accuracy and verdict"));
    const RunResult check = runAlidade({"validate", output, "--json"});
    ASSERT_THAT(check, EndsWith(0)) << format;
    EXPECT_EQ(nlohmann::json::parse(check.out).at("files").at(0).at("format"), format);
    const RunResult difference = runAlidade({"diff", output, dataPath("camera.yaml"), "--json"});
    const auto found = nlohmann::json::parse(difference.out);
    // Some lack k3, and only the even powers of ocam make a perspective.
    const double limit_px = format == "ocam" ? 0.6 : 0.5;
    ASSERT_TRUE(found.contains("p95_px")) << difference.out;
    EXPECT_LT(found.at("p95_px").get<double>(), limit_px);
    ++num_formats;
  }
  EXPECT_EQ(num_formats, 11);
}

TEST(Calibrate, RefusesAModelThatTheFormatDoesNotHold) {
  EXPECT_THAT(runAlidade({"calibrate", dataPath("corners.csv"), "--to", "kalibr", "--model", "rational"}),
              FailsWith(2, AllOf(HasSubstr("rational"), HasSubstr("radtan"), HasSubstr("--to kalibr"))));
  EXPECT_THAT(runAlidade({"calibrate", dataPath("corners.csv"), "--to", "calibur"}),
              FailsWith(2, HasSubstr("--to")));
}

TEST(Calibrate, StartsFromACameraWithMoreThanTheFormatHolds) {
  const ScratchFolder scratch;
  const std::string output = scratch.path("chain.yaml");
  const RunResult result = runAlidade({"calibrate", dataPath("corners.csv"), "--init",
                                       dataPath("camera.yaml"), "--to", "kalibr", "-o", output, "--quiet"});
  ASSERT_THAT(result, EndsWith(0));
  EXPECT_EQ(result.out + result.err, "");
  EXPECT_THAT(scratch.read("chain.yaml"), HasSubstr("distortion_coeffs"));
}

TEST(Calibrate, GivesTheSameBytesForAnyOrderAndNumberOfThreads) {
  const ScratchFolder scratch;
  const std::vector<int> orders[] = {{1, 2, 3, 4, 5, 6}, {6, 5, 4, 3, 2, 1}, {3, 1, 6, 2, 5, 4, 3}};
  std::vector<std::string> files;
  for (const auto& order : orders) {
    for (const char* jobs : {"1", "2", "8"}) {
      std::vector<std::string> args = {"calibrate", "--board", kBoardSpec, "--jobs",
                                       jobs,        "-o",      "-",        "--quiet"};
      for (const int i : order) args.push_back(imagePath(i));
      const RunResult result = runAlidade(args);
      ASSERT_THAT(result, EndsWith(0));
      EXPECT_EQ(result.err, "");
      files.push_back(result.out);
    }
  }
  ASSERT_EQ(files.size(), 9u);
  EXPECT_THAT(files.front(), HasSubstr("alidade_camera: 1\n"));
  EXPECT_EQ(std::count(files.begin(), files.end(), files.front()), 9);
}

TEST(Calibrate, GivesTheSameParametersFromACornersFile) {
  const ScratchFolder scratch;
  const std::string photos = linkImages(scratch, "photos", 5);
  const std::string corners = scratch.path("corners.csv");
  ASSERT_THAT(runAlidade({"detect", photos, "--board", kBoardSpec, "-o", corners}), EndsWith(0));
  const RunResult apart = runAlidade({"calibrate", corners, "-o", "-"});
  const RunResult at_once = runAlidade({"calibrate", photos, "--board", kBoardSpec, "-o", "-"});
  ASSERT_THAT(apart, EndsWith(0));
  ASSERT_THAT(at_once, EndsWith(0));
  EXPECT_EQ(parametersOf(apart.out), parametersOf(at_once.out));
  EXPECT_THAT(apart.err, AllOf(HasSubstr("\nAccuracy  "), testing::EndsWith("\n")));
  EXPECT_THAT(
      runAlidade({"calibrate", corners, "--board", "checkerboard:9x6:30mm"}),
      FailsWith(1, AllOf(HasSubstr(corners), HasSubstr("board checkerboard:9x6:25mm"),
                         HasSubstr("checkerboard:9x6:30mm from --board"), HasSubstr("remove --board"))));
  EXPECT_THAT(
      runAlidade({"calibrate", corners, photos}),
      FailsWith(2, AllOf(HasSubstr(photos), HasSubstr("no corners file"), HasSubstr("images alone"))));
}

TEST(Calibrate, TakesTheCornersOfOneCameraFromSeveralFiles) {
  const ScratchFolder scratch;
  const std::string all = readFile(dataPath("corners.csv"));
  const std::size_t begin = all.find("\ncamera,image,") + 1;
  const std::size_t rows = all.find('\n', begin) + 1;
  const std::string header = all.substr(begin, rows - begin);
  // Cut between two rows of different images.
  const auto imageOf = [&](std::size_t row) {
    return all.substr(row, all.find(',', all.find(',', row) + 1) - row);
  };
  std::size_t cut = all.find('\n', rows + (all.size() - rows) / 2) + 1;
  for (const std::string image = imageOf(cut); imageOf(cut) == image;) cut = all.find('\n', cut) + 1;
  const std::string first = scratch.write("a.csv", header + all.substr(rows, cut - rows));
  const std::string second = scratch.write("b.csv", header + all.substr(cut));
  const RunResult one = runAlidade({"calibrate", dataPath("corners.csv"), "-o", "-"});
  const RunResult two = runAlidade({"calibrate", second, first, "-o", "-"});
  ASSERT_THAT(two, EndsWith(0));
  EXPECT_EQ(parametersOf(one.out), parametersOf(two.out));
  EXPECT_THAT(runAlidade({"calibrate", first, second, first}),
              FailsWith(1, AllOf(HasSubstr(first + ": image"), HasSubstr("the same file was given twice"))));
}

TEST(Calibrate, WritesOneJsonDocument) {
  const ScratchFolder scratch;
  const RunResult result =
      runAlidade({"calibrate", dataPath("corners.csv"), "--json", "-o", scratch.path("camera.yaml")});
  ASSERT_THAT(result, EndsWith(0));
  const auto document = nlohmann::json::parse(result.out);
  EXPECT_EQ(document.at("model"), "radtan");
  EXPECT_EQ(document.at("verdict"), "trustworthy");
  EXPECT_EQ(document.at("board"), kBoardSpec);
  EXPECT_EQ(document.at("views").size(), 12u);
  EXPECT_EQ(document.at("parameters").size(), 9u);
  const std::vector<double> parameters = parametersOf(scratch.read("camera.yaml"));
  EXPECT_EQ(document.at("parameters").at("fx").get<double>(), parameters[0]);
}

// Of the image's line for (column, row), `from` becomes `to`.
void replaceInLine(std::string& text, const std::string& image, const std::string& from,
                   const std::string& to) {
  const std::size_t line = text.find(image + ",640,480,checkerboard:9x6:25mm" + from);
  ASSERT_NE(line, std::string::npos);
  const std::size_t at = text.find(from, line);
  text.replace(at, from.size(), to);
}

TEST(Calibrate, NamesTheCornersAndViewsThatItLeavesOut) {
  const ScratchFolder scratch;
  std::string text = readFile(dataPath("corners.csv"));
  // A corner 10 px off, and an image numbered along the columns first (marked, so that none is read twice).
  replaceInLine(text, "view_001.png", ",0,0,0,232.3", ",0,0,0,242.3");
  for (int row = 0; row < 6; ++row) {
    for (int column = 0; column < 9; ++column) {
      const int id = column * 6 + row;
      replaceInLine(text, "view_005.png", fmt::format(",{},{},{},", row * 9 + column, column, row),
                    fmt::format(",#{},{},{},", id, id % 9, id / 9));
    }
  }
  std::erase(text, '#');
  text.insert(0, "#");
  const std::string corners = scratch.write("corners.csv", text);
  const RunResult json = runAlidade({"calibrate", corners, "--json"});
  ASSERT_THAT(json, EndsWith(0));
  const auto document = nlohmann::json::parse(json.out);
  ASSERT_EQ(document.at("outliers").size(), 1u);
  EXPECT_EQ(document.at("outliers")[0].at("image"), "view_001.png");
  EXPECT_EQ(document.at("outliers")[0].at("corner_id"), 0);
  EXPECT_NEAR(document.at("outliers")[0].at("dx").get<double>(), -10, 0.01);
  EXPECT_DOUBLE_EQ(document.at("outlier_share").get<double>(), 1.0 / (11 * 54));
  ASSERT_EQ(document.at("excluded_views").size(), 1u);
  EXPECT_EQ(document.at("excluded_views")[0].at("image"), "view_005.png");
  EXPECT_TRUE(document.at("common_errors").at("stretch").contains("sigma"));
  EXPECT_TRUE(document.at("views")[0].at("influence").contains("move_sigmas"));
  EXPECT_THAT(runAlidade({"calibrate", corners, "--verbose"}).out,
              AllOf(HasSubstr("view_001.png corner 0: error (-10.00, "),
                    HasSubstr("Outliers 1 of 594 corners (0.17 %)"),
                    HasSubstr("view_005.png: its corners are numbered differently"),
                    HasSubstr("column by column"), HasSubstr("11 used")));
}

TEST(Calibrate, EstimatesTheBoardsShapeIfAsked) {
  const ScratchFolder scratch;
  const std::string output = scratch.path("camera.yaml");
  const auto run = [&](const char* shape) {
    const RunResult result = runAlidade({"calibrate", dataPath("images"), "--board", kBoardSpec,
                                         "--board-shape", shape, "-o", output, "--json"});
    EXPECT_THAT(result, EndsWith(0));
    return nlohmann::json::parse(result.out).at("board_shape");
  };
  const auto warp = run("warp");
  EXPECT_TRUE(warp.at("estimated"));
  const CameraRecord file = onlyCamera(parseCameras(scratch.read("camera.yaml"), "camera.yaml"));
  ASSERT_TRUE(file.calibration && file.calibration->warps.size() == 1);
  EXPECT_EQ(file.calibration->warps.front().shape.bend_x_m, warp.at("bend_x_m"));
  EXPECT_EQ(file.calibration->warps.front().shape.bend_y_m, warp.at("bend_y_m"));
  EXPECT_EQ(file.calibration->warps.front().std_m.x(), warp.at("bend_x_std_m"));
  EXPECT_EQ(file.calibration->warps.front().std_m.y(), warp.at("bend_y_std_m"));
  // The rendered board is flat.
  EXPECT_LT(std::abs(file.calibration->warps.front().shape.bend_x_m),
            4 * file.calibration->warps.front().std_m.x());
  EXPECT_LT(std::abs(file.calibration->warps.front().shape.bend_y_m),
            4 * file.calibration->warps.front().std_m.y());
  EXPECT_THAT(runAlidade({"validate", output}), EndsWith(0));

  const auto by_default = run("auto");
  EXPECT_FALSE(by_default.at("estimated"));
  EXPECT_LT(by_default.at("f"), 6.9);
  const auto flat = run("flat");
  EXPECT_FALSE(flat.at("estimated"));
  EXPECT_TRUE(flat.at("f").is_null());
  EXPECT_THAT(scratch.read("camera.yaml"), Not(HasSubstr("board_warp")));
}

TEST(Calibrate, TellsWhatTheStatedSigmasLeaveUnexplained) {
  const ScratchFolder scratch;
  const RunResult unknown = runAlidade({"calibrate", dataPath("corners.csv"), "--json"});
  EXPECT_TRUE(nlohmann::json::parse(unknown.out).at("unexplained_sigma_px").is_null());
  std::string text = readFile(dataPath("corners.csv"));
  bool is_poor = false;
  for (std::size_t at = 0; (at = text.find(",\n", at)) != std::string::npos; is_poor = !is_poor) {
    text.insert(at + 1, is_poor ? "0.5" : "0.05");
  }
  const std::string corners = scratch.write("corners.csv", text);
  const auto document = nlohmann::json::parse(runAlidade({"calibrate", corners, "--json"}).out);
  EXPECT_EQ(document.at("unexplained_sigma_px"), 0.0);
  EXPECT_LT(document.at("weighted_rms_px"), 1e-6);
  EXPECT_THAT(runAlidade({"calibrate", corners, "--verbose"}).out,
              HasSubstr("0 px of it is not explained by the detector's standard deviations"));
}

TEST(Calibrate, TakesFlagsBeforeTheSettingsFileBeforeTheDefault) {
  const ScratchFolder scratch;
  const std::string config = scratch.write("settings.yaml", "model: pinhole\nboard: checkerboard:9x6:25mm\n");
  const auto modelOf = [&](const std::vector<std::string>& more) {
    const std::string evidence = scratch.path("evidence.json");
    std::vector<std::string> args = {"calibrate", dataPath("corners.csv"), "--evidence", evidence};
    args.insert(args.end(), more.begin(), more.end());
    static_cast<void>(runAlidade(args));
    const nlohmann::json document = nlohmann::json::parse(readFile(evidence));
    EXPECT_EQ(document.at("views").at(0).at("corners").at(0).size(), 5u);
    std::string settings;
    for (const auto& [key, values] : document.at("settings").items())
      settings += fmt::format(" {}={}", key, join(values.get<std::vector<std::string>>(), ","));
    return document.at("model").get<std::string>() + ":" + settings;
  };
  EXPECT_EQ(modelOf({}),
            "radtan: board-shape=auto correction=auto model=auto pupil=auto to=alidade tolerance=1px");
  EXPECT_EQ(modelOf({"--config", config}),
            "pinhole: board=checkerboard:9x6:25mm board-shape=auto correction=auto model=pinhole pupil=auto "
            "to=alidade tolerance=1px");
  EXPECT_EQ(modelOf({"--config", config, "--model", "radtan"}),
            "radtan: board=checkerboard:9x6:25mm board-shape=auto correction=auto model=radtan pupil=auto "
            "to=alidade tolerance=1px");
}

// Boards that are all parallel to the image, at several distances.
std::string frontoParallelScene(double noise_px) {
  std::string poses;
  for (int i = 0; i < 6; ++i) {
    poses += fmt::format("    - {{rotation_vector_rad: [0, 0, {}], translation_m: [{}, {}, {}]}}\n", 0.1 * i,
                         -0.1 + 0.01 * i, -0.07 + 0.005 * i, 0.4 + 0.05 * i);
  }
  return fmt::format(
      "alidade_scene: 1\n"
      "camera: {{model: pinhole, image_size: {{width: 640, height: 480}},\n"
      "         parameters: {{fx: 500, fy: 500, cx: 320, cy: 240}}}}\n"
      "board: checkerboard:9x6:25mm\nviews:\n  poses:\n{}corner_noise_px: {}\n",
      poses, noise_px);
}

TEST(Calibrate, SaysNoWhereTheFocalLengthCannotBeSeen) {
  const ScratchFolder scratch;
  int num_refused = 0;
  for (const double noise_px : {0.0, 0.1}) {
    const std::string name = fmt::format("noise_{}", noise_px);
    const std::string scene = scratch.write(name + ".yaml", frontoParallelScene(noise_px));
    ASSERT_THAT(runAlidade({"simulate", scene, "--corners-only", "-o", scratch.path(name)}), EndsWith(0));
    const std::string corners = scratch.path(name + "/corners.csv");
    const std::string output = scratch.path(name + "/out.yaml");
    for (const char* model : {"pinhole", "radtan"}) {
      const RunResult result =
          runAlidade({"calibrate", corners, "--model", model, "-o", output, "--verbose"});
      EXPECT_THAT(result, EndsWith(3)) << model;
      EXPECT_THAT(result.out, AllOf(HasSubstr("FAILED"), HasSubstr("[fronto_parallel]"),
                                    HasSubstr("next: add views with the board tilted")));
      EXPECT_THAT(result.err, AllOf(HasSubstr("must not be used"),
                                    HasSubstr("use --keep-untrustworthy to write it anyway")));
      EXPECT_FALSE(scratch.has(name + "/out.yaml"));
      ++num_refused;
    }
    const RunResult to_stdout = runAlidade({"calibrate", corners, "-o", "-"});
    EXPECT_THAT(to_stdout, EndsWith(3));
    EXPECT_EQ(to_stdout.out, "");
    const RunResult json = runAlidade({"calibrate", corners, "--json"});
    EXPECT_THAT(json, EndsWith(3));
    EXPECT_EQ(nlohmann::json::parse(json.out).at("verdict"), "rejected");
    const RunResult kept =
        runAlidade({"calibrate", corners, "--model", "pinhole", "-o", output, "--keep-untrustworthy"});
    EXPECT_THAT(kept, EndsWith(3));
    EXPECT_THAT(readFile(output), HasSubstr("findings: [fronto_parallel"));
  }
  EXPECT_EQ(num_refused, 4);
}

TEST(Calibrate, NamesAnOlderFileThatItLeavesAlone) {
  const ScratchFolder scratch;
  const std::string scene = scratch.write("scene.yaml", frontoParallelScene(0.1));
  ASSERT_THAT(runAlidade({"simulate", scene, "--corners-only", "-o", scratch.path("set")}), EndsWith(0));
  const std::string output = scratch.write("camera.yaml", "older\n");
  const RunResult result =
      runAlidade({"calibrate", scratch.path("set/corners.csv"), "-o", output, "--quiet"});
  EXPECT_THAT(result, FailsWith(3, AllOf(HasSubstr("was not written"), HasSubstr("is an older one"))));
  EXPECT_EQ(scratch.read("camera.yaml"), "older\n");
}

// The finding says it in words.
TEST(Calibrate, ListsOtherCamerasThatExplainTheCorners) {
  const ScratchFolder scratch;
  const AnyCamera camera =
      AnyCamera::make("double_sphere", std::vector<double>{180, 181, 322, 238, -0.2, 0.6});
  int num_ambiguous = 0;
  int num_clear = 0;
  for (std::uint64_t seed = 0; seed < 6; ++seed) {
    const SimulatedSet set =
        simulateSet(camera, {.width = 640, .height = 480}, 5, 0.1, seed,
                    {.max_tilt_deg = 50, .max_roll_deg = 30, .min_fill = 0.3, .max_fill = 0.8});
    const RunResult result = runAlidade({"calibrate", scratch.write("corners.csv", cornersText(set, 5)),
                                         "--model", "double_sphere", "--json"});
    const auto document = nlohmann::json::parse(result.out);
    bool is_found = false;
    for (const auto& finding : document.at("findings")) is_found |= finding.at("id") == "ambiguous_optimum";
    const auto& others = document.at("other_optima");
    ASSERT_EQ(!others.empty(), is_found) << seed;
    if (!is_found) {
      ++num_clear;
      continue;
    }
    const auto& other = others.at(0);
    EXPECT_EQ(other.size(), 5u);
    EXPECT_EQ(other.at("parameters").size(), 6u);
    EXPECT_GT(other.at("parameters").at("fx").get<double>(), 50);
    EXPECT_NEAR(other.at("rms_px").get<double>(), document.at("weighted_rms_px").get<double>(), 0.02);
    EXPECT_LT(other.at("excess_chi2").get<double>(), 9);
    EXPECT_GT(other.at("sigmas").get<double>(), 3);
    EXPECT_GT(other.at("projection_px").get<double>(), 0);
    ++num_ambiguous;
  }
  EXPECT_EQ(num_ambiguous + num_clear, 6);
  EXPECT_GE(num_ambiguous, 1);
  EXPECT_GE(num_clear, 1);
}

}  // namespace
}  // namespace alidade
