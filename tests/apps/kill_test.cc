// SPDX-License-Identifier: MIT
// A command that is killed while it writes leaves what was there, or the whole of what it was to write.
#include <algorithm>
#include <chrono>
#include <csignal>
#include <cstdlib>
#include <filesystem>
#include <functional>
#include <map>
#include <random>
#include <thread>

#include "apps/command_line.h"

namespace alidade {
namespace {

namespace fs = std::filesystem;

// Files below a folder by their path in it, without those that a killed command left under its own hidden
// names.
std::map<std::string, std::string> contentsOf(const fs::path& folder) {
  std::map<std::string, std::string> contents;
  for (const auto& entry : fs::recursive_directory_iterator(folder)) {
    const std::string name = entry.path().lexically_relative(folder).string();
    if (entry.is_regular_file() && !name.starts_with('.')) contents[name] = readFile(entry.path());
  }
  return contents;
}

struct Outcomes {
  int old = 0;
  int complete = 0;
  int finished = 0;  // before they could be killed
};

// Kills `args` at random moments, each time over what `restore` puts in place.
Outcomes killAtRandom(const ScratchFolder& scratch, const std::vector<std::string>& args,
                      const std::function<void()>& restore, int num_kills, unsigned seed) {
  restore();
  const auto old_contents = contentsOf(scratch.path());
  const auto start = std::chrono::steady_clock::now();
  EXPECT_THAT(runAlidade(args), EndsWith(0));
  const auto duration = std::chrono::steady_clock::now() - start;
  const auto new_contents = contentsOf(scratch.path());
  EXPECT_NE(old_contents, new_contents);

  Outcomes outcomes;
  std::mt19937 random(seed);
  // Most of a run is no writing, so many moments are taken from its end.
  std::uniform_real_distribution<double> early(0, 1);
  std::uniform_real_distribution<double> late(0.8, 1.1);
  for (int i = 0; i < num_kills; ++i) {
    restore();
    RunningProgram program(alidadeProgram(), args);
    std::this_thread::sleep_for((i % 3 == 0 ? early(random) : late(random)) * duration);
    program.sendSignal(SIGKILL);
    const RunResult result = program.wait();
    outcomes.finished += result.signal == SIGKILL ? 0 : 1;
    const auto contents = contentsOf(scratch.path());
    outcomes.old += contents == old_contents ? 1 : 0;
    outcomes.complete += contents == new_contents ? 1 : 0;
  }
  return outcomes;
}

TEST(Kill, LeavesTheOldFileOrTheNewOne) {
  // Each with its waiting takes longer than most tests; what a change must pass asks for more.
  const char* more = std::getenv("ALIDADE_PROOF_KILLS");
  const int num_each = (more == nullptr ? 80 : std::stoi(more)) / 4;
  int num_kills = 0;
  int num_old = 0;
  const auto kill = [&](const ScratchFolder& scratch, const std::vector<std::string>& args,
                        const std::function<void()>& restore, int count) {
    const Outcomes outcomes = killAtRandom(scratch, args, restore, count, static_cast<unsigned>(num_kills));
    EXPECT_EQ(outcomes.old + outcomes.complete, count) << args.front();
    num_kills += count;
    num_old += outcomes.old;
  };
  const std::string camera = dataPath("camera.yaml");
  {
    const ScratchFolder scratch;
    const auto restore = [&] { scratch.write("out", "an older file\n"); };
    const std::string out = scratch.path("out");
    kill(scratch, {"convert", camera, "-o", out, "--resize", "320x240"}, restore, num_each);
    kill(scratch, {"calibrate", dataPath("corners.csv"), "--model", "radtan", "-o", out}, restore, num_each);
    kill(scratch, {"detect", imagePath(1), "--board", kBoardSpec, "-o", out}, restore, num_each);
  }
  {
    // A folder is replaced as a whole.
    const ScratchFolder scratch;
    const std::string out = scratch.path("out");
    const ScratchFolder saved;
    ASSERT_THAT(runAlidade({"undistort", camera, "--camera-only", "-o", saved.path("out")}), EndsWith(0));
    const auto restore = [&] {
      fs::remove_all(out);
      fs::copy(saved.path("out"), out);
    };
    kill(scratch,
         {"undistort", camera, imagePath(1), imagePath(2), "-o", out, "--overwrite", "--size", "320x240"},
         restore, num_each);
  }
  EXPECT_EQ(num_kills, 4 * num_each);
  EXPECT_GT(num_old, num_kills / 10);
  EXPECT_LT(num_old, num_kills);
}

}  // namespace
}  // namespace alidade
