// SPDX-License-Identifier: MIT
#include <chrono>
#include <csignal>
#include <thread>

#include "apps/command_line.h"

namespace alidade {
namespace {

// Brings the signal into the midst of the work, which takes many seconds.
constexpr std::chrono::milliseconds kWait{200};

RunResult interrupted(const std::vector<std::string>& args, int signal) {
  RunningProgram program(ALIDADE_BINARY, args, {.time_limit = std::chrono::seconds(30)});
  EXPECT_TRUE(program.waitUntilItCatches(signal));
  std::this_thread::sleep_for(kWait);
  program.sendSignal(signal);
  return program.wait();
}

void expectInterrupted(const RunResult& result, int signal) {
  EXPECT_FALSE(result.is_late);
  EXPECT_EQ(result.signal, signal) << "exit code " << result.exit_code;
  EXPECT_EQ(result.err, "interrupted; nothing was written\n");
  EXPECT_EQ(result.out, "");
}

TEST(Interrupt, LeavesNothingBehind) {
  const ScratchFolder scratch;
  // Enough images to be at work for seconds.
  const std::string photos = linkImages(scratch, "photos", 600);
  const auto before = scratch.list();
  const std::string output = scratch.path("out");
  int num_interrupted = 0;
  for (const int signal : {SIGINT, SIGTERM, SIGHUP}) {
    expectInterrupted(
        interrupted({"calibrate", photos, "--board", kBoard, "-o", output, "--jobs", "1"}, signal), signal);
    ++num_interrupted;
  }
  expectInterrupted(interrupted({"detect", photos, "--board", kBoard, "-o", output, "--jobs", "2"}, SIGINT),
                    SIGINT);
  EXPECT_EQ(num_interrupted, 3);
  EXPECT_EQ(scratch.list(), before);
}

TEST(Interrupt, RemovesTheFolderThatASimulationWasFilling) {
  const ScratchFolder scratch;
  const std::string scene = scratch.write(
      "scene.yaml", replaced(readFile(ALIDADE_SOURCE_DIR "/config/scene.yaml"), "random: 12", "random: 50"));
  const auto before = scratch.list();
  int num_interrupted = 0;
  for (const int signal : {SIGINT, SIGTERM, SIGHUP}) {
    expectInterrupted(interrupted({"simulate", scene, "-o", scratch.path("out"), "--jobs", "1"}, signal),
                      signal);
    ++num_interrupted;
  }
  EXPECT_EQ(num_interrupted, 3);
  EXPECT_EQ(scratch.list(), before);
}

}  // namespace
}  // namespace alidade
