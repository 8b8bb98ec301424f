// SPDX-License-Identifier: MIT
#include <chrono>
#include <csignal>
#include <cstdlib>
#include <filesystem>
#include <thread>

#include "alidade/core/random.h"
#include "apps/command_line.h"
#include "support/folder_content.h"

namespace alidade {
namespace {

namespace fs = std::filesystem;

// Somebody's folder, in which commands write results and people keep files of their own. What the contract of
// docs/files.md demands is known from what was done: a result that is as it was written may be replaced by
// the same command with --overwrite, and nothing else.
class Reference {
 public:
  explicit Reference(std::uint64_t seed) : random_(seed) {
    scratch_.write("scene.yaml",
                   "alidade_scene: 1\n"
                   "camera: {model: pinhole, image_size: {width: 96, height: 72},\n"
                   "         parameters: {fx: 80, fy: 80, cx: 47.5, cy: 35.5}}\n"
                   "board: checkerboard:4x3:30mm\nviews: {random: 2}\nrender: {samples: 8}\n");
    scratch_.write("lens.yaml", smallCamera());
  }

  void step() {
    switch (random_.index(6)) {
      case 0:
        return addFile();
      case 1:
        return changeFile();
      case 2:
        return removeFile();
      default:
        return runCommand();
    }
  }
  [[nodiscard]] int numReplaced() const { return num_replaced_; }
  [[nodiscard]] int numRefused() const { return num_refused_; }

 private:
  static constexpr const char* kFolder = "results";

  void addFile() {
    const std::vector<std::string> names = {"notes.txt",  "camera.yaml",         "corners.csv",
                                            "poses.yaml", "images/view_001.png", "projection.yaml"};
    const std::string name = names[random_.index(names.size())];
    scratch_.write(std::string(kFolder) + "/" + name, "mine " + std::to_string(++num_written_));
  }

  // One of the files that are there, the list of the result excepted: what it says is not what people edit.
  std::string anyFile() {
    std::vector<std::string> names;
    for (const auto& [name, text] : contentOf(scratch_.path(kFolder))) {
      if (!text.empty() && name != ".alidade_result") names.push_back(name);
    }
    return names.empty() ? "" : std::string(kFolder) + "/" + names[random_.index(names.size())];
  }
  void changeFile() {
    const std::string name = anyFile();
    if (!name.empty()) scratch_.write(name, scratch_.read(name) + "changed");
  }
  void removeFile() {
    const std::string name = anyFile();
    if (!name.empty()) fs::remove(scratch_.path(name));
  }

  void runCommand() {
    const std::vector<std::vector<std::string>> commands = {
        {"simulate", scratch_.path("scene.yaml"), "--corners-only"},
        {"simulate", scratch_.path("scene.yaml")},
        {"undistort", scratch_.path("lens.yaml"), "--camera-only"},
        {"undistort", scratch_.path("lens.yaml"), "--camera-only", "--projection", "cylindrical"}};
    std::vector<std::string> arguments = commands[random_.index(commands.size())];
    arguments.insert(arguments.end(), {"-o", scratch_.path(kFolder), "--quiet"});
    const bool may_replace = random_.uniform() < 0.7;
    if (may_replace) arguments.emplace_back("--overwrite");
    const FolderContent before = contentOf(scratch_.path(kFolder));
    const bool is_free = before.empty();
    const bool must_succeed = is_free || (may_replace && last_result_.mayBeReplacedBy(arguments[0], before));
    const bool is_killed = random_.uniform() < 0.2;
    const RunResult run = is_killed ? runAndKill(arguments) : runAlidade(arguments);
    const FolderContent after = contentOf(scratch_.path(kFolder));
    if (!must_succeed) {
      if (!is_killed) {
        EXPECT_THAT(run, EndsWith(1));
      }
      EXPECT_EQ(after, before);
      ++num_refused_;
      return;
    }
    if (!is_killed) {
      EXPECT_THAT(run, EndsWith(0));
    }
    if (is_killed && after == before) return;
    EXPECT_TRUE(after.contains(".alidade_result"));
    last_result_.set(arguments[0], after);
    num_replaced_ += is_free ? 0 : 1;
  }

  RunResult runAndKill(const std::vector<std::string>& arguments) {
    RunningProgram program(alidadeProgram(), arguments);
    std::this_thread::sleep_for(std::chrono::milliseconds(random_.index(150)));
    program.sendSignal(SIGKILL);
    return program.wait();
  }

  ScratchFolder scratch_;
  Random random_;
  LastResult last_result_;
  int num_written_ = 0;
  int num_replaced_ = 0;
  int num_refused_ = 0;
};

TEST(FolderContract, HoldsForAnySequenceOfCommandsAndFiles) {
  const char* more = std::getenv("ALIDADE_PROOF_SEQUENCES");
  const int num_sequences = more != nullptr ? std::atoi(more) : 40;
  constexpr int kSteps = 8;
  int num_replaced = 0;
  int num_refused = 0;
  for (int i = 0; i < num_sequences; ++i) {
    Reference reference(streamSeed(71, static_cast<std::uint64_t>(i)));
    for (int k = 0; k < kSteps; ++k) {
      SCOPED_TRACE("sequence " + std::to_string(i) + ", step " + std::to_string(k));
      reference.step();
    }
    num_replaced += reference.numReplaced();
    num_refused += reference.numRefused();
    if (testing::Test::HasFailure()) break;
  }
  EXPECT_GT(num_replaced, num_sequences / 8);
  EXPECT_GT(num_refused, num_sequences / 2);
}

}  // namespace
}  // namespace alidade
