// SPDX-License-Identifier: MIT
#include <filesystem>
#include <map>
#include <sstream>
#include <string>

#include <nlohmann/json.hpp>
#include <opencv2/imgcodecs.hpp>

#include "alidade/files/formats/alidade_writer.h"
#include "apps/command_line.h"
#include "apps/rig_support.h"
#include "imagery/video_files.h"
#include "support/source_tree.h"

namespace alidade {
namespace {

using testing::AllOf;
using testing::HasSubstr;
using testing::Not;
using testing::StartsWith;

const std::vector<std::string> kCommands = {"calibrate", "detect", "project", "unproject", "undistort",
                                            "validate",  "diff",   "convert", "simulate",  "fleet",
                                            "board",     "pose",   "formats"};

// Those of the group rig whose examples need no more than its files.
const std::vector<std::string> kRigCommands = {"rectify", "triangulate", "calibrate", "validate"};

TEST(Usage, ShowsTheHelpWithoutArguments) {
  const RunResult result = runAlidade({});
  EXPECT_THAT(result, EndsWith(2));
  EXPECT_EQ(result.out, "");
  for (const std::string& command : kCommands) EXPECT_THAT(result.err, HasSubstr("\n  " + command + " "));
}

TEST(Usage, HelpsOnRequest) {
  const RunResult all = runAlidade({"--help"});
  EXPECT_THAT(all, EndsWith(0));
  EXPECT_EQ(all.err, "");
  int num_commands = 0;
  for (const std::string& command : kCommands) {
    EXPECT_THAT(all.out, HasSubstr("\n  " + command + " "));
    const RunResult one = runAlidade({command, "--help"});
    EXPECT_THAT(one, EndsWith(0));
    EXPECT_EQ(one.err, "");
    EXPECT_THAT(one.out, AllOf(HasSubstr("Example: "), HasSubstr("--json"), HasSubstr("--config")));
    ++num_commands;
  }
  EXPECT_EQ(num_commands, 13);
}

TEST(Usage, TellsItsVersion) {
  const RunResult result = runAlidade({"--version"});
  EXPECT_THAT(result, EndsWith(0));
  EXPECT_THAT(result.out, StartsWith("alidade "));
  EXPECT_EQ(result.err, "");
}

TEST(Usage, FailsWhenTheHelpDoesNotArrive) {
  const std::vector<std::vector<std::string>> lines = {{"--help"}, {"--version"}, {"detect", "--help"}};
  int num_lines = 0;
  for (const auto& args : lines) {
    EXPECT_THAT(runAlidade(args, {.output_path = "/dev/full"}), FailsWith(1, HasSubstr("standard output")));
    ++num_lines;
  }
  EXPECT_EQ(num_lines, 3);
}

TEST(Usage, NamesWhatItDoesNotUnderstandAndTheNearestThing) {
  struct Case {
    std::vector<std::string> args;
    std::string found;
    std::string next;
  };
  const std::vector<Case> cases = {
      {{"calibrat"}, "unknown command 'calibrat'", "did you mean 'calibrate'?"},
      {{"unprojekt", "camera.yaml"}, "unknown command 'unprojekt'", "did you mean 'unproject'?"},
      {{"xyzzy"}, "expected one of calibrate, detect", "alidade --help"},
      {{"--hlp"}, "--hlp", "did you mean '--help'?"},
      {{"--verison"}, "--verison", "did you mean '--version'?"},
      {{"calibrate", "--bord", "x"}, "--bord", "did you mean '--board'?"},
      {{"calibrate", "--bord=x"}, "--bord", "did you mean '--board'?"},
      {{"detect", "--outptu", "x"}, "--outptu", "did you mean '--output'?"},
      {{"project", "--jobs", "2", "camera.yaml"}, "--jobs", "alidade project --help"},
      {{"simulate", "--corner-only"}, "--corner-only", "did you mean '--corners-only'?"},
      {{"calibrate", "photos", "--board"}, "--board", "alidade calibrate --help"},
      {{"detect", "photos", "-o"}, "--output", "alidade detect --help"},
      {{"calibrate", "photos", "--jobs", "many"}, "--jobs", "alidade calibrate --help"},
      {{"calibrate", "photos", "--jobs", "-1"}, "a whole number from 0 to 1024", "alidade calibrate --help"},
      {{"calibrate", "photos", "--jobs", "1.5"}, "'1.5'", "alidade calibrate --help"},
      {{"diff", "a.yaml", "b.yaml", "--distance", "0"}, "a finite number above 0", "alidade diff --help"},
      {{"diff", "a.yaml", "b.yaml", "--distance", "inf"}, "a finite number above 0", "alidade diff --help"},
      {{"diff", "a.yaml", "b.yaml", "--tolerance", "-1"},
       "a finite number, 0 or more",
       "alidade diff --help"},
      {{"diff", "a.yaml", "b.yaml", "--distance", "-2m"}, "a finite number above 0", "alidade diff --help"},
      {{"diff", "a.yaml", "b.yaml", "--distance", "2km"}, "found '2km'", "alidade diff --help"},
      {{"diff", "a.yaml", "b.yaml", "--tolerance", "x"}, "found 'x'", "alidade diff --help"},
      {{"diff", "a.yaml", "b.yaml", "--tolerance", "px"}, "found 'px'", "alidade diff --help"},
      {{"validate", "a.yaml", "--tolerance", "0px"}, "a positive number of pixels", "such as 0.1px"},
      {{"convert", "a.yaml", "--max-error", "-1"}, "a finite number, 0 or more", "alidade convert --help"},
      {{"calibrate", "photos", "--model", "radtn"}, "found 'radtn'", "did you mean 'radtan'?"},
      {{"calibrate"}, "no input", "alidade calibrate --help"},
      {{"detect"}, "no images", "alidade detect --help"},
      {{"project"}, "no camera file", "alidade project --help"},
      {{"unproject"}, "no camera file", "alidade unproject --help"},
      {{"undistort"}, "no camera file", "alidade undistort --help"},
      {{"undistort", "camera.yaml"}, "no images", "alidade undistort --help"},
      {{"undistort", "camera.yaml", "photos"}, "no --output", "-o FOLDER"},
      {{"undistort", "camera.yaml", "photos", "--interpolaton", "cubic"},
       "--interpolaton",
       "did you mean '--interpolation'?"},
      {{"validate"}, "no file", "alidade validate --help"},
      {{"validate", ""}, "file: an empty value", "check that it is set"},
      {{"validate", "camera.yaml", "--against", ""}, "--against: an empty value", "remove the flag"},
      {{"project", "camera.yaml", "--pose", ""}, "--pose: an empty value", "remove the flag"},
      {{"project", "camera.yaml", "--poses", ""}, "--poses: an empty value", "remove the flag"},
      {{"convert", "camera.yaml", "-o", "out.yaml", "--crop", ""},
       "--crop: an empty value",
       "remove the flag"},
      {{"diff", "camera.yaml"}, "1 file; expected", "alidade diff --help"},
      {{"diff", "a.yaml", "b.yaml", "--grid", "20"}, "'20'", "alidade diff --help"},
      {{"diff", "a.yaml", "b.yaml", "--same-frame", "--distance", "2"}, "both", "remove --distance"},
      {{"convert"}, "no camera file", "alidade convert --help"},
      {{"convert", "camera.yaml"}, "no --output", "-o FILE"},
      {{"simulate"}, "no scene file", "alidade simulate --help"},
      {{"simulate", "scene.yaml"}, "no --output", "-o FOLDER"},
      {{"calibrate", "photos"}, "no --board", "--board checkerboard:9x6:25mm"},
      {{"detect", "photos"}, "no --board", "--board checkerboard:9x6:25mm"},
      {{"detect", "photos", "--board", kBoardSpec, "--camera", "a\nb"},
       "line break in --camera",
       "without line breaks"},
  };
  std::size_t num_refused = 0;
  for (const Case& c : cases) {
    const RunResult result = runAlidade(c.args);
    EXPECT_THAT(result, FailsWith(2, AllOf(HasSubstr(c.found), HasSubstr(c.next))))
        << testing::PrintToString(c.args);
    ++num_refused;
  }
  EXPECT_EQ(num_refused, 49u);
}

TEST(Usage, ReadsTheWordsOfOtherPrograms) {
  const std::map<std::string, std::string> models = {
      {"plumb_bob", "radtan"},   {"Brown-Conrady", "radtan"}, {"pinhole-radtan", "radtan"},
      {"opencv8", "rational"},   {"opencv12", "thin_prism"},  {"rational_polynomial", "rational"},
      {"Perspective", "pinhole"}};
  const ScratchFolder scratch;
  std::size_t num_read = 0;
  for (const auto& [word, model] : models) {
    const std::string file = scratch.path(word + ".yaml");
    const RunResult result =
        runAlidade({"convert", dataPath("camera.yaml"), "-o", file, "--model", word, "--keep-untrustworthy"});
    EXPECT_THAT(scratch.read(word + ".yaml"), HasSubstr("\nmodel: " + model + "\n")) << result.err;
    ++num_read;
  }
  for (const auto& [word, mark] :
       {std::pair("ROS", "distortion_model"), std::pair("OpenCV", "%YAML"),
        std::pair("camera_info", "distortion_model"), std::pair("cameramodel", "lensmodel")}) {
    const RunResult result = runAlidade({"convert", dataPath("camera.yaml"), "-o", "-", "--to", word});
    EXPECT_THAT(result, EndsWith(0)) << word;
    EXPECT_THAT(result.out, HasSubstr(mark));
    ++num_read;
  }
  EXPECT_EQ(num_read, 11u);
  // A word for a model that this flag does not offer stands for nothing.
  EXPECT_THAT(runAlidade({"validate", dataPath("camera.yaml"), "--read-as", "ds"}),
              FailsWith(2, HasSubstr("expected one of radtan, kannala_brandt")));
}

TEST(Usage, RefusesTwoDocumentsForStandardOutput) {
  const ScratchFolder scratch;
  const std::string json_in_file = scratch.write("settings.yaml", "json: true\noutput: '-'\n");
  const std::vector<std::vector<std::string>> lines = {
      {"calibrate", dataPath("corners.csv"), "--json", "-o", "-"},
      {"detect", imagePath(1), "--board", kBoardSpec, "--json", "-o", "-"},
      {"calibrate", dataPath("corners.csv"), "--config", json_in_file},
      {"convert", dataPath("camera.yaml"), "--json", "-o", "-"},
  };
  int num_refused = 0;
  for (const auto& args : lines) {
    const RunResult result = runAlidade(args);
    EXPECT_THAT(result, EndsWith(2));
    EXPECT_THAT(result.err, AllOf(HasSubstr("error: "), HasSubstr("--json"), HasSubstr("--output -")));
    EXPECT_EQ(nlohmann::json::parse(result.out).at("error").at("exit_code"), 2);
    ++num_refused;
  }
  EXPECT_EQ(num_refused, 4);
}

// Who reads standard output alone is told of errors there too.
TEST(Usage, AnswersInJsonWhereItFails) {
  const ScratchFolder scratch;
  const std::string none = scratch.path("none.yaml");
  const std::string good = dataPath("camera.yaml");
  const std::string empty = scratch.makeFolder("empty");
  scratch.write("photos/a.png", "not looked at");
  struct Case {
    std::vector<std::string> args;
    int exit_code;
    const char* message;
  };
  const std::vector<Case> cases = {
      {{"validate"}, 2, "no file"},
      {{"validate", empty}, 1, "no file with the extension of a camera file"},
      {{"validate", scratch.path("photos")}, 1, "no file with the extension of a camera file"},
      {{"validate", good, "--against", none}, 1, "no such file"},
      {{"convert", none, "-o", scratch.path("out.yaml")}, 1, "no such file"},
      {{"diff", good, none}, 1, "no such file"},
      {{"diff", good}, 2, "1 file; expected"},
      {{"calibrate", none, "--board", kBoardSpec}, 1, "none.yaml"},
      {{"project", none, none}, 1, "no such file"},
      {{"project", good, none}, 1, "no such file"},
      {{"undistort", none, empty, "-o", scratch.path("out")}, 1, "no such file"},
  };
  int num_answered = 0;
  for (Case c : cases) {
    c.args.emplace_back("--json");
    const RunResult result = runAlidade(c.args);
    EXPECT_THAT(result, EndsWith(c.exit_code)) << testing::PrintToString(c.args);
    const auto error = nlohmann::json::parse(result.out, nullptr, false);
    ASSERT_TRUE(error.is_object()) << testing::PrintToString(c.args) << result.out;
    EXPECT_EQ(error.at("error").at("exit_code"), c.exit_code);
    EXPECT_THAT(error.at("error").at("message").get<std::string>(), HasSubstr(c.message));
    EXPECT_THAT(result.err, HasSubstr(c.message));
    ++num_answered;
  }
  EXPECT_EQ(num_answered, 11);
}

// Answers that were buffered are not begun on standard output: what is there is the error, whole.
TEST(Usage, AnswersInJsonWhereNoPointHasGoneOut) {
  const ScratchFolder scratch;
  struct Case {
    const char* command;
    const char* points;
    const char* message;
  };
  const std::vector<Case> cases = {{"project", "0,0,one\n", ":1"},
                                   {"project", "0,0\n", ":1"},
                                   {"project", "0,0,1\n0,zero,1\n", ":2"},
                                   {"unproject", "0,one\n", ":1"},
                                   {"unproject", "320,240\n0,one\n", ":2"}};
  std::size_t num_answered = 0;
  for (const Case& c : cases) {
    const std::string points = scratch.write("points.csv", c.points);
    const RunResult result = runAlidade({c.command, dataPath("camera.yaml"), points, "--json"});
    EXPECT_THAT(result, EndsWith(1)) << c.points;
    const auto error = nlohmann::json::parse(result.out, nullptr, false);
    ASSERT_TRUE(error.is_object()) << c.points << result.out;
    EXPECT_EQ(error.at("error").at("exit_code"), 1);
    EXPECT_THAT(error.at("error").at("message").get<std::string>(), HasSubstr(points + c.message));
    ++num_answered;
  }
  EXPECT_EQ(num_answered, cases.size());

  // Once answers have gone out, no other document follows them.
  std::string many;
  for (int i = 0; i < 20'000; ++i) many += "0,0,1\n";
  const std::string points = scratch.write("points.csv", many + "0,zero,1\n");
  const RunResult begun = runAlidade({"project", dataPath("camera.yaml"), points, "--json"});
  EXPECT_THAT(begun, EndsWith(1));
  EXPECT_THAT(begun.out, AllOf(StartsWith("{\"points\""), Not(HasSubstr("error"))));
}

// The words of a command line as a shell without variables reads it.
std::vector<std::string> wordsOf(const std::string& line) {
  std::vector<std::string> words;
  std::string word;
  bool is_quoted = false;
  for (const char c : line + " ") {
    if (c == '\'') {
      is_quoted = !is_quoted;
    } else if (c == ' ' && !is_quoted) {
      if (!word.empty()) words.push_back(word);
      word.clear();
    } else {
      word += c;
    }
  }
  return words;
}

struct Example {
  std::string input;
  std::vector<std::string> args;
};

// "Example: echo 0.1,-0.05,1.0 | alidade project camera.yaml"
std::vector<Example> examplesIn(const std::string& help) {
  std::vector<Example> examples;
  std::istringstream lines(help);
  for (std::string line; std::getline(lines, line);) {
    constexpr std::string_view kStart = "Example: ";
    if (!line.starts_with(kStart)) continue;
    Example example;
    std::string command = line.substr(kStart.size());
    if (const std::size_t bar = command.find(" | "); bar != std::string::npos) {
      example.input = wordsOf(command.substr(0, bar)).at(1) + "\n";
      command = command.substr(bar + 3);
    }
    example.args = wordsOf(command);
    EXPECT_EQ(example.args.front(), "alidade");
    example.args.erase(example.args.begin());
    examples.push_back(std::move(example));
  }
  return examples;
}

// The boards of testdata/ as a second camera sees them, 5 mm to the right of the first.
void renderSecondCamera(const ScratchFolder& scratch, const std::string& folder) {
  constexpr double kBaseline = 0.005;
  const std::string scene = readFile(dataPath("../checkerboard.yaml"));
  std::string poses = "views:\n  poses:\n";
  std::istringstream lines(readFile(dataPath("poses.yaml")));
  for (std::string line; std::getline(lines, line);) {
    const std::string pose_key = "camera_from_board: ";
    const std::string x_key = "translation_m: [";
    if (line.find(pose_key) == std::string::npos) continue;
    std::string pose = line.substr(line.find(pose_key) + pose_key.size());
    pose.pop_back();  // the brace of the list's entry
    const std::size_t first = pose.find(x_key) + x_key.size();
    const std::size_t length = pose.find(',', first) - first;
    const double x = std::stod(pose.substr(first, length));
    poses += "    - " + pose.replace(first, length, std::to_string(x - kBaseline)) + "\n";
  }
  scratch.write("second.yaml", replaced(scene, "views: {random: 12}\n", poses));
  ASSERT_THAT(runAlidade({"simulate", "second.yaml", "-o", "second", "--quiet"}, {.folder = scratch.path()}),
              EndsWith(0));
  std::filesystem::rename(scratch.path("second/images"), scratch.path(folder));
}

TEST(Usage, EveryExampleInTheHelpRuns) {
  const ScratchFolder scratch;
  linkImages(scratch, "photos", 4);
  for (const char* name : {"camera.yaml", "left.yaml", "right.yaml", "now/1.yaml", "now/2.yaml", "now/3.yaml",
                           "before/1.yaml", "before/2.yaml", "before/3.yaml"})
    scratch.write(name, readFile(dataPath("camera.yaml")));
  for (const char* name : {"camchain.yaml", "calibrations/camchain.yaml"}) {
    scratch.write(name,
                  "cam0: {camera_model: pinhole, distortion_model: none, distortion_coeffs: [], "
                  "intrinsics: [500.123456, 501.234567, 320.123456, 240.345678], resolution: [640, 480]}\n");
  }
  std::string rig = "alidade_rig: 1\ncameras:\n";
  for (const auto& [name, x] : {std::pair("left", "0"), std::pair("right", "-0.1")}) {
    rig +=
        std::string("  - name: ") + name +
        "\n    camera_from_rig: {quaternion_xyzw: [0, 0, 0, 1], translation_m: [" + x +
        ", 0, 0]}\n    camera: {alidade_camera: 1, model: pinhole, image_size: {width: 640, height: 480}, " +
        "parameters: {fx: 500, fy: 500, cx: 320, cy: 240}}\n";
    scratch.write(std::string(name) + ".cameramodel",
                  std::string("{'lensmodel': 'LENSMODEL_PINHOLE', 'intrinsics': [500, 500, 320, 240], ") +
                      "'extrinsics': [0, 0, 0, " + x + ", 0, 0], 'imagersize': [640, 480]}\n");
  }
  scratch.write("rig.yaml", rig);
  scratch.write("points.csv", "x,y,z\n0,0,1\n");
  scratch.write("pixels.csv", "id,camera,u,v\n1,left,310,240\n1,right,290,240\n");
  scratch.write("trajectory.txt", "1.5 0 0 -1 0 0 0 1\n");
  scratch.write("images.txt", "1 1 0 0 0 0 0 1 1 a.jpg\n\n");
  // Rendering one of its views shows as much as rendering all.
  scratch.write("config/scene.yaml",
                replaced(readFile(sourcePath("config/scene.yaml")), "{random: 12}", "{random: 1}"));
  scratch.write("config/footage.yaml",
                replaced(readFile(sourcePath("config/footage.yaml")), "frames: 60", "frames: 2"));
  scratch.write("config/robot.yaml",
                replaced(readFile(sourcePath("config/robot.yaml")), "poses: 15", "poses: 1"));
  // A camera that stands still: footage that cannot tell.
  writeVideo(scratch.path("walk.mp4"),
             std::vector<cv::Mat>(4, cv::imread(imagePath(1), cv::IMREAD_GRAYSCALE)));
  int num_examples = 0;
  for (const std::string& command : kCommands) {
    for (const Example& example : examplesIn(runAlidade({command, "--help"}).out)) {
      EXPECT_THAT(runAlidade(example.args, {.input = example.input, .folder = scratch.path()}), EndsWith(0))
          << testing::PrintToString(example.args);
      ++num_examples;
    }
  }
  EXPECT_EQ(num_examples, 31);
  // Of a rig.
  scratch.write("rig.yaml", rigFileText(pairOfCameras()));
  linkImages(scratch, "left", 12);
  renderSecondCamera(scratch, "right");
  for (const std::string& command : kRigCommands) {
    for (const Example& example : examplesIn(runAlidade({"rig", command, "--help"}).out)) {
      EXPECT_THAT(runAlidade(example.args, {.input = example.input, .folder = scratch.path()}), EndsWith(0))
          << testing::PrintToString(example.args);
      ++num_examples;
    }
  }
  EXPECT_EQ(num_examples, 37);
  EXPECT_TRUE(scratch.has("simulated/images/view_001.png"));
}

}  // namespace
}  // namespace alidade
