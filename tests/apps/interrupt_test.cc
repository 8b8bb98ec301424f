// SPDX-License-Identifier: MIT
#include <chrono>
#include <csignal>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <system_error>
#include <thread>

#include <fmt/format.h>

#include "alidade/files/formats/alidade_writer.h"
#include "alidade/imagery/image_file.h"
#include "apps/command_line.h"
#include "apps/rig_support.h"
#include "support/source_tree.h"

namespace alidade {
namespace {

// Brings the signal into the midst of the work, which takes many seconds.
constexpr std::chrono::milliseconds kWait{200};

RunResult interrupted(const std::vector<std::string>& args, int signal) {
  RunningProgram program(alidadeProgram(), args, {.time_limit = std::chrono::seconds(30)});
  EXPECT_TRUE(program.waitUntilItCatches(signal));
  std::this_thread::sleep_for(kWait);
  program.sendSignal(signal);
  return program.wait();
}

void expectInterrupted(const RunResult& result, int signal) {
  EXPECT_FALSE(result.is_late);
  EXPECT_EQ(result.signal, signal) << "exit code " << result.exit_code;
  EXPECT_EQ(result.err, "interrupted; no result was written\n");
  EXPECT_EQ(result.out, "");
}

// Enough images to be at work for seconds. Hard links, as of symbolic links to one file all but one are left
// out.
std::string manyImages(const ScratchFolder& scratch, const std::string& folder) {
  constexpr int kCount = 600;
  const std::string path = scratch.makeFolder(folder);
  const auto nameOf = [&path](int i) { return fmt::format("{}/view_{:03}.png", path, i); };
  for (int i = 1; i <= kCount; ++i) {
    if (i <= kNumImages) {
      std::filesystem::copy_file(imagePath(i), nameOf(i));
    } else {
      std::filesystem::create_hard_link(nameOf(1 + i % kNumImages), nameOf(i));
    }
  }
  return path;
}

TEST(Interrupt, LeavesNothingBehind) {
  const ScratchFolder scratch;
  const std::string photos = manyImages(scratch, "photos");
  const auto before = scratch.list();
  const std::string output = scratch.path("out");
  int num_interrupted = 0;
  for (const int signal : {SIGINT, SIGTERM, SIGHUP}) {
    expectInterrupted(
        interrupted({"calibrate", photos, "--board", kBoardSpec, "-o", output, "--jobs", "1"}, signal),
        signal);
    ++num_interrupted;
  }
  expectInterrupted(
      interrupted({"detect", photos, "--board", kBoardSpec, "-o", output, "--jobs", "2"}, SIGINT), SIGINT);
  EXPECT_EQ(num_interrupted, 3);
  EXPECT_EQ(scratch.list(), before);
}

// The programs whose arguments have these words.
int numRunning(const std::string& words) {
  int num_found = 0;
  std::error_code ended;  // of a program that ends meanwhile
  for (const auto& entry : std::filesystem::directory_iterator("/proc", ended)) {
    std::ifstream file(entry.path() / "cmdline", std::ios::binary);
    num_found +=
        std::string(std::istreambuf_iterator<char>(file), {}).find(words) != std::string::npos ? 1 : 0;
  }
  return num_found;
}

TEST(Interrupt, StopsWhileAVideoIsRead) {
  const ScratchFolder scratch;
  // Two thousand large frames, which take many seconds.
  writeImage(scratch.path("frame.jpg"),
             {.size = {1920, 1080}, .bytes = std::vector<std::uint8_t>(1920 * 1080, 90)});
  const std::string frame = scratch.read("frame.jpg");
  std::string frames;
  for (int i = 0; i < 2000; ++i) frames += frame;
  const std::string clip = scratch.write("clip.mjpeg", frames);
  std::filesystem::remove(scratch.path("frame.jpg"));
  const auto before = scratch.list();
  const std::string output = scratch.path("out");
  expectInterrupted(interrupted({"detect", clip, "--board", kBoardSpec, "-o", output}, SIGINT), SIGINT);
  expectInterrupted(interrupted({"calibrate", clip, "--board", kBoardSpec, "-o", output}, SIGTERM), SIGTERM);
  EXPECT_EQ(numRunning(clip), 0);  // neither do the programs that decode it
  EXPECT_EQ(scratch.list(), before);
}

TEST(Interrupt, StopsEveryLongCommand) {
  const ScratchFolder scratch;
  const std::string left = manyImages(scratch, "left");
  const std::string right = manyImages(scratch, "right");
  const std::string fleet = scratch.makeFolder("fleet");
  std::filesystem::copy_file(dataPath("camera.yaml"), fleet + "/0.yaml");
  for (int i = 1; i < 3000; ++i)
    std::filesystem::create_hard_link(fleet + "/0.yaml", fmt::format("{}/{}.yaml", fleet, i));
  const std::string rig = scratch.write("rig.yaml", rigFileText(pairOfCameras()));
  const auto before = scratch.list();
  const std::string output = scratch.path("out");
  const std::vector<std::vector<std::string>> commands = {
      {"rig", "calibrate", left, right, "--board", kBoardSpec, "-o", output},
      {"rig", "validate", rig, left, right, "--board", kBoardSpec, "--junit", output},
      {"rig", "rectify", rig, left, right, "-o", output},
      {"undistort", dataPath("camera.yaml"), left, "-o", output},
      {"validate", dataPath("camera.yaml"), "--images", left, "--board", kBoardSpec, "--report", output},
      {"track", left, "--camera", dataPath("camera.yaml"), "-o", output},
      {"fleet", fleet, "-o", output + ".html"}};
  int num_interrupted = 0;
  for (std::vector<std::string> command : commands) {
    if (command.front() != "track") command.insert(command.end(), {"--jobs", "1"});
    expectInterrupted(interrupted(command, SIGINT), SIGINT);
    EXPECT_EQ(scratch.list(), before) << command[0] << " " << command[1];
    ++num_interrupted;
  }
  EXPECT_EQ(num_interrupted, 7);
}

TEST(Interrupt, RemovesTheFolderThatASimulationWasFilling) {
  const ScratchFolder scratch;
  const std::string scene = scratch.write(
      "scene.yaml", replaced(readFile(sourcePath("config/scene.yaml")), "random: 12", "random: 50"));
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
