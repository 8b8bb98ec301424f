// SPDX-License-Identifier: MIT
#include <algorithm>
#include <filesystem>
#include <string>
#include <vector>

#include "apps/command_line.h"

namespace alidade {
namespace {

using testing::AllOf;
using testing::HasSubstr;
using testing::Not;

const std::vector<std::vector<std::string>> kTopics = {{},
                                                       {"calibrate"},
                                                       {"detect"},
                                                       {"rig"},
                                                       {"rig", "calibrate"},
                                                       {"rig", "validate"},
                                                       {"validate"},
                                                       {"diff"},
                                                       {"convert"},
                                                       {"report"},
                                                       {"rig", "rectify"},
                                                       {"rig", "triangulate"},
                                                       {"board"},
                                                       {"simulate"},
                                                       {"project"},
                                                       {"unproject"},
                                                       {"undistort"},
                                                       {"help"},
                                                       {"track"},
                                                       {"pose"},
                                                       {"formats"},
                                                       {"handeye"},
                                                       {"handeye", "calibrate"},
                                                       {"handeye", "validate"}};

TEST(Help, PrintsWhatTheFlagPrints) {
  std::size_t num_topics = 0;
  for (std::vector<std::string> topic : kTopics) {
    std::vector<std::string> by_command = topic;
    by_command.insert(by_command.begin(), "help");
    topic.emplace_back("--help");
    const RunResult expected = runAlidade(topic);
    const RunResult result = runAlidade(by_command);
    EXPECT_THAT(result, EndsWith(0)) << testing::PrintToString(by_command);
    EXPECT_EQ(result.out, expected.out);
    EXPECT_EQ(result.err, "");
    EXPECT_THAT(result.out, HasSubstr("Usage: alidade"));
    ++num_topics;
  }
  EXPECT_EQ(num_topics, 24u);
}

TEST(Help, RefusesWhatIsNoCommandAndNamesTheNearest) {
  struct Case {
    std::vector<std::string> args;
    std::string found;
    std::string next;
  };
  const std::vector<Case> cases = {
      {{"help", "calibrat"},
       "unknown command 'calibrat'; expected one of calibrate",
       "did you mean 'calibrate'?"},
      {{"help", "xyzzy"}, "unknown command 'xyzzy'", "alidade --help"},
      {{"help", "rig", "calibrat"}, "rig: unknown command 'calibrat'", "did you mean 'calibrate'?"},
      {{"help", "rig", "project"}, "expected one of calibrate, validate", "alidade rig --help"},
      {{"help", "calibrate", "photos"},
       "calibrate: this command has no command 'photos'",
       "calibrate --help"},
      {{"help", ""}, "command: an empty value", "check that it is set"},
      {{"help", "--hepl"}, "--hepl", "did you mean '--help'?"},
      {{"hlp"}, "unknown command 'hlp'", "did you mean 'help'?"},
  };
  const ScratchFolder scratch;
  std::size_t num_refused = 0;
  for (const Case& c : cases) {
    EXPECT_THAT(runAlidade(c.args, {.folder = scratch.path()}),
                FailsWith(2, AllOf(HasSubstr(c.found), HasSubstr(c.next))))
        << testing::PrintToString(c.args);
    ++num_refused;
  }
  EXPECT_EQ(num_refused, 8u);
  EXPECT_TRUE(std::filesystem::is_empty(scratch.path()));
}

TEST(Help, ExplainsBoards) {
  const RunResult result = runAlidade({"help", "boards"});
  EXPECT_THAT(result, EndsWith(0));
  EXPECT_THAT(result.out, AllOf(HasSubstr("\ncheckerboard:9x6:25mm (columns x rows of inner corners"),
                                HasSubstr("\naprilgrid:6x6:88mm:0.3"), HasSubstr("also read: chessboard"),
                                HasSubstr("MATLAB\ncounts their squares")));
}

// One screen for each command: the words of other programs that are answered are not among them.
TEST(Help, IsAtMostSixtyLines) {
  std::size_t num_topics = 0;
  for (std::vector<std::string> topic : kTopics) {
    topic.insert(topic.begin(), "help");
    const std::string text = runAlidade(topic).out;
    EXPECT_LE(std::count(text.begin(), text.end(), '\n'), 60) << testing::PrintToString(topic);
    EXPECT_THAT(text,
                AllOf(Not(HasSubstr("--square")), Not(HasSubstr("--alpha")), Not(HasSubstr("--scale"))));
    ++num_topics;
  }
  EXPECT_EQ(num_topics, 24u);
}

TEST(Help, SaysWhenItDoesNotArrive) {
  EXPECT_THAT(runAlidade({"help", "diff"}, {.output_path = "/dev/full"}),
              FailsWith(1, HasSubstr("standard output")));
}

TEST(Help, AnswersWhatShellsAskToCompleteAWord) {
  const auto complete = [](std::vector<std::string> words) {
    words.insert(words.begin(), "complete");
    return runAlidade(words).out;
  };
  EXPECT_THAT(complete({""}), HasSubstr("calibrate\tCalibrate a camera from images"));
  EXPECT_THAT(complete({"rig", ""}), AllOf(HasSubstr("rectify\t"), Not(HasSubstr("detect\t"))));
  EXPECT_THAT(complete({"diff", "--"}), HasSubstr("--tolerance\tLargest accepted difference in pixels\n"));
  EXPECT_THAT(complete({"calibrate", "photos", "--model", "ra"}), HasSubstr("radtan\t\n"));
  EXPECT_THAT(complete({"calibrate", "--"}), AllOf(HasSubstr("--board\t"), Not(HasSubstr("--square"))));
  EXPECT_THAT(complete({"calibrate", "photos", "--model", "=", "ra"}), HasSubstr("radtan\t\n"));
  EXPECT_THAT(complete({"calibrate", "--model=ra"}), HasSubstr("--model=radtan\t\n"));
  EXPECT_EQ(complete({"validate", "cam"}), ":file");
  EXPECT_EQ(complete({"calibrate", "--cache", ""}), ":folder");
  EXPECT_EQ(complete({"calibrate", "--tolerance", ""}), "");
  EXPECT_EQ(complete({"help", "calibrate", ""}), "");
  EXPECT_EQ(complete({"nonsense", "--"}), complete({"--"}));
}

}  // namespace
}  // namespace alidade
