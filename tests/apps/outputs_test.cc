// SPDX-License-Identifier: MIT
#include <csignal>
#include <filesystem>

#include <unistd.h>

#include "apps/command_line.h"

namespace alidade {
namespace {

namespace fs = std::filesystem;
using testing::AllOf;
using testing::ElementsAre;
using testing::HasSubstr;
using testing::Not;

// Command lines that write to `output`, quick ones.
std::vector<std::vector<std::string>> writers(const std::string& output) {
  return {{"calibrate", dataPath("corners.csv"), "-o", output},
          {"detect", imagePath(1), "--board", kBoardSpec, "-o", output}};
}

// The number of a closed stream goes to the next file that is opened, and a message must not go into that.
TEST(Outputs, AClosedStreamFailsAndSpoilsNothing) {
  const ScratchFolder scratch;
  const std::string out = scratch.path("half.yaml");
  const auto shell = [](const std::string& args, const char* closed) {
    return runProgram("/bin/sh", {"-c", alidadeProgram() + " " + args + " " + closed});
  };
  EXPECT_EQ(shell("convert " + dataPath("camera.yaml") + " -o - --bin 2", ">&-").exit_code, 1);
  EXPECT_EQ(shell("convert " + dataPath("camera.yaml") + " -o " + out + " --bin 2", "2>&-").exit_code, 0);
  EXPECT_THAT(scratch.read("half.yaml"), testing::StartsWith("alidade_camera: 1"));
  EXPECT_EQ(shell("project " + dataPath("camera.yaml"), "<&-").exit_code, 1);
}

TEST(Outputs, RefusesPathsThatCannotBeWrittenBeforeAnyWork) {
  const ScratchFolder scratch;
  scratch.makeFolder("folder");
  scratch.write("file.txt", "kept");
  const auto before = scratch.list();
  struct Case {
    std::string output;
    std::string found;
    std::string next;
  };
  const std::vector<Case> cases = {
      {"missing/out", "No such file or directory", "create the folder first"},
      {"folder", "Is a directory", "add a file name"},
      {"folder/", "Is a directory", "add a file name"},
      {"file.txt/out", "Not a directory", "create the folder first"},
  };
  int num_refused = 0;
  for (const Case& c : cases) {
    const std::string output = scratch.path() + "/" + c.output;
    const auto refusal = FailsWith(1, AllOf(HasSubstr(output), HasSubstr(c.found), HasSubstr(c.next)));
    for (const auto& args : writers(output)) {
      EXPECT_THAT(runAlidade(args), refusal);
      ++num_refused;
    }
    // Inputs that do not exist show that the output was looked at first.
    EXPECT_THAT(runAlidade({"calibrate", scratch.path("none.csv"), "-o", output}), refusal);
    EXPECT_THAT(runAlidade({"detect", scratch.path("none"), "--board", kBoardSpec, "-o", output}), refusal);
  }
  EXPECT_EQ(num_refused, 8);
  EXPECT_EQ(scratch.list(), before);
  EXPECT_EQ(scratch.read("file.txt"), "kept");
}

TEST(Outputs, RefusesToOverwriteWhatItReads) {
  const ScratchFolder scratch;
  scratch.makeFolder("folder");
  for (int i = 1; i <= 3; ++i) {
    std::filesystem::copy_file(imagePath(i), scratch.path("folder/view_00" + std::to_string(i) + ".png"));
  }
  const std::string board =
      scratch.write("board.yaml", "kind: checkerboard\ncolumns: 9\nrows: 6\nsquare: 25mm\n");
  const std::string config = scratch.write("config.yaml", "quiet: true\n");
  const std::string image = scratch.read("folder/view_001.png");
  const auto before = scratch.list();
  int num_refused = 0;
  for (const std::string command : {"calibrate", "detect"}) {
    for (const std::string input : {"folder", "folder/*.png"}) {
      for (const std::string output : {"folder/view_001.png", "board.yaml", "config.yaml"}) {
        EXPECT_THAT(runAlidade({command, scratch.path(input), "--board", board, "--config", config, "-o",
                                scratch.path(output)}),
                    FailsWith(2, AllOf(HasSubstr(output), HasSubstr("would be overwritten"))));
        ++num_refused;
      }
    }
  }
  EXPECT_EQ(num_refused, 12);
  EXPECT_EQ(scratch.list(), before);
  EXPECT_EQ(scratch.read("folder/view_001.png"), image);
}

TEST(Outputs, RespectsWriteProtection) {
  const ScratchFolder scratch;
  scratch.write("closed/camera.yaml", "old");
  fs::permissions(scratch.path("closed"), fs::perms::owner_read | fs::perms::owner_exec);
  int num_runs = 0;
  for (const auto& args : writers(scratch.path("closed/new"))) {
    const RunResult result = runAlidade(args);
    if (::geteuid() == 0) {  // writes everywhere
      EXPECT_THAT(result, EndsWith(0));
    } else {
      EXPECT_THAT(result,
                  FailsWith(1, AllOf(HasSubstr("Permission denied"), HasSubstr(scratch.path("closed")))));
    }
    ++num_runs;
  }
  fs::permissions(scratch.path("closed"), fs::perms::owner_all);
  EXPECT_EQ(num_runs, 2);
}

TEST(Outputs, FailsOnAFullDisk) {
  int num_failed = 0;
  for (const auto& args : writers("/dev/full")) {
    const RunResult result = runAlidade(args);
    EXPECT_THAT(result, EndsWith(1));
    EXPECT_THAT(result.err, AllOf(HasSubstr("/dev/full"), HasSubstr("No space left"),
                                  HasSubstr("free some space"), Not(HasSubstr("written to"))));
    ++num_failed;
  }
  EXPECT_EQ(num_failed, 2);
}

TEST(Outputs, FailsWhenStandardOutputIsFull) {
  const std::string camera = dataPath("camera.yaml");
  const std::string corners = dataPath("corners.csv");
  const std::vector<std::vector<std::string>> lines = {{"calibrate", corners},
                                                       {"calibrate", corners, "-o", "-"},
                                                       {"calibrate", corners, "--json"},
                                                       {"detect", imagePath(1), "--board", kBoardSpec},
                                                       {"project", camera},
                                                       {"unproject", camera},
                                                       {"validate", camera},
                                                       {"validate", camera, "--json"}};
  int num_failed = 0;
  for (const auto& args : lines) {
    EXPECT_THAT(runAlidade(args, {.input = "1,1,1\n", .output_path = "/dev/full"}).exit_code, 1)
        << testing::PrintToString(args);
    ++num_failed;
  }
  EXPECT_EQ(num_failed, 8);
  EXPECT_THAT(runAlidade({"validate", camera}, {.output_path = "/dev/full"}),
              FailsWith(1, AllOf(HasSubstr("standard output"), HasSubstr("No space left"))));
}

TEST(Outputs, ReplacesAnEarlierFileOnlyWithAWholeOne) {
  const ScratchFolder scratch;
  const std::string output = scratch.write("camera.yaml", "old");
  EXPECT_THAT(runAlidade({"calibrate", scratch.write("bad.csv", "not,corners\n"), "-o", output}),
              EndsWith(1));
  EXPECT_EQ(scratch.read("camera.yaml"), "old");
  EXPECT_THAT(runAlidade({"calibrate", dataPath("corners.csv"), "-o", output}), EndsWith(0));
  EXPECT_EQ(parametersOf(scratch.read("camera.yaml")).size(), 9u);
  EXPECT_THAT(scratch.list(), ElementsAre("bad.csv", "camera.yaml"));
}

TEST(Outputs, EndsQuicklyWhenNobodyReads) {
  std::string points;
  for (int i = 0; i < 200'000; ++i) points += "0.1,0.1,1\n";
  RunningProgram program(alidadeProgram(), {"project", dataPath("camera.yaml")},
                         {.input = points, .time_limit = std::chrono::seconds(20)});
  program.closeOutput();
  const RunResult result = program.wait();
  EXPECT_FALSE(result.is_late);
  EXPECT_TRUE(result.signal == SIGPIPE || result.exit_code == 1) << result.signal << " " << result.exit_code;
}

}  // namespace
}  // namespace alidade
