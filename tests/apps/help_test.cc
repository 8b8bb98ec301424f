// SPDX-License-Identifier: MIT
#include <filesystem>
#include <string>
#include <vector>

#include "apps/command_line.h"

namespace alidade {
namespace {

using testing::AllOf;
using testing::HasSubstr;
using testing::StartsWith;

const std::vector<std::vector<std::string>> kTopics = {
    {},           {"calibrate"}, {"detect"},  {"rig"},       {"rig", "calibrate"}, {"rig", "validate"},
    {"validate"}, {"diff"},      {"convert"}, {"report"},    {"rig", "rectify"},   {"rig", "triangulate"},
    {"board"},    {"simulate"},  {"project"}, {"unproject"}, {"undistort"},        {"help"},
    {"track"}};

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
  EXPECT_EQ(num_topics, 19u);
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
      {{"help", "--wirte", "folder"}, "--wirte", "did you mean '--write'?"},
      {{"help", "--write"}, "--write", "alidade help --help"},
      {{"help", "--write", "folder", "calibrate"}, "--write and a command", "one of them"},
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
  EXPECT_EQ(num_refused, 10u);
  EXPECT_TRUE(std::filesystem::is_empty(scratch.path()));
}

TEST(Help, SaysWhenItDoesNotArrive) {
  EXPECT_THAT(runAlidade({"help", "diff"}, {.output_path = "/dev/full"}),
              FailsWith(1, HasSubstr("standard output")));
  const ScratchFolder scratch;
  scratch.write("file", "not a folder");
  EXPECT_THAT(runAlidade({"help", "--write", "file"}, {.folder = scratch.path()}),
              FailsWith(1, AllOf(HasSubstr("file/man/man1: cannot be created"), HasSubstr("--write"))));
  EXPECT_EQ(readFile(scratch.path("file")), "not a folder");
}

TEST(Help, WritesPagesAndCompletionsAndLeavesOtherFilesAlone) {
  const ScratchFolder scratch;
  scratch.write("man/man1/other.1", "of another program");
  scratch.write("man/man1/alidade.1", "of an older version");
  const RunResult result = runAlidade({"help", "--write", scratch.path()});
  EXPECT_THAT(result, EndsWith(0));
  EXPECT_EQ(result.out + result.err, "");
  EXPECT_EQ(readFile(scratch.path("man/man1/other.1")), "of another program");
  EXPECT_THAT(readFile(scratch.path("man/man1/alidade.1")), StartsWith(".TH ALIDADE 1 "));
  EXPECT_THAT(readFile(scratch.path("man/man1/alidade-rig-calibrate.1")), HasSubstr("\\-\\-board"));
  EXPECT_THAT(readFile(scratch.path("bash-completion/completions/alidade")), HasSubstr("complete -F"));
  EXPECT_THAT(readFile(scratch.path("zsh/vendor-completions/_alidade")), StartsWith("#compdef alidade\n"));
  EXPECT_THAT(readFile(scratch.path("fish/vendor_completions.d/alidade.fish")),
              HasSubstr("complete -c alidade"));
}

}  // namespace
}  // namespace alidade
