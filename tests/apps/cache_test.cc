// SPDX-License-Identifier: MIT
// The cache of detection: the same results with and without it, whatever happens to it.
#include <chrono>
#include <csignal>
#include <filesystem>
#include <random>
#include <thread>

#include <sys/stat.h>

#include "apps/command_line.h"

namespace alidade {
namespace {

namespace fs = std::filesystem;
using testing::AllOf;
using testing::HasSubstr;

class DetectionCache : public testing::Test {
 protected:
  [[nodiscard]] RunResult detect(std::vector<std::string> more) const {
    more.insert(more.begin(), {"detect", "--board", kBoardSpec, "--cache", scratch_.path("cache")});
    return runAlidade(more);
  }
  /// The files of entries.
  [[nodiscard]] std::vector<fs::path> entries() const {
    std::vector<fs::path> files;
    for (const auto& entry : fs::recursive_directory_iterator(scratch_.path("cache"))) {
      const std::string name = entry.path().filename();
      if (entry.is_regular_file() && name != "CACHEDIR.TAG" && !name.starts_with('.')) files.push_back(entry);
    }
    return files;
  }

  ScratchFolder scratch_;
};

TEST_F(DetectionCache, GivesTheSameBytes) {
  const std::string photos = linkImages(scratch_, "photos", 3);
  const RunResult plain = runAlidade({"detect", photos, "--board", kBoardSpec});
  const RunResult cold = detect({photos});
  const RunResult warm = detect({photos});
  ASSERT_THAT(plain, EndsWith(0));
  EXPECT_EQ(cold.out, plain.out);
  EXPECT_EQ(warm.out, plain.out);
  EXPECT_EQ(warm.err, plain.err);
  EXPECT_EQ(detect({photos, "--json"}).out,
            runAlidade({"detect", photos, "--board", kBoardSpec, "--json"}).out);
  EXPECT_EQ(entries().size(), 3u);
}

TEST_F(DetectionCache, KnowsImagesByTheirContent) {
  const std::string photos = linkImages(scratch_, "photos", 2);
  ASSERT_THAT(detect({photos}), EndsWith(0));
  // A copy under another name is known; a new image and another board are not.
  fs::copy_file(imagePath(2), scratch_.path("copy.png"));
  const RunResult copy = detect({scratch_.path("copy.png")});
  EXPECT_THAT(copy.out, HasSubstr("camera,copy.png,"));
  EXPECT_EQ(entries().size(), 2u);
  ASSERT_THAT(detect({photos, imagePath(3)}), EndsWith(0));
  EXPECT_EQ(entries().size(), 3u);
  ASSERT_THAT(
      runAlidade({"detect", photos, "--board", "checkerboard:9x6:30mm", "--cache", scratch_.path("cache")}),
      EndsWith(0));
  EXPECT_EQ(entries().size(), 5u);
}

TEST_F(DetectionCache, TellsOfDamagedEntries) {
  const std::string photos = linkImages(scratch_, "photos", 3);
  const RunResult cold = detect({photos});
  const std::vector<fs::path> files = entries();
  ASSERT_EQ(files.size(), 3u);
  std::string bytes = readFile(files[0]);
  bytes[bytes.size() / 2] ^= 1;
  scratch_.write(files[0].lexically_relative(scratch_.path()).string(), bytes);
  scratch_.write(files[1].lexically_relative(scratch_.path()).string(), "");
  const RunResult mended = detect({photos});
  ASSERT_THAT(mended, EndsWith(0));
  EXPECT_THAT(mended.err, AllOf(HasSubstr("note: 2 cache entries are damaged"), HasSubstr("computed again")));
  EXPECT_EQ(mended.out, cold.out);
  EXPECT_EQ(detect({photos}).err, cold.err);
}

TEST_F(DetectionCache, DoesNotUseEntriesOfOthers) {
  const std::string photos = linkImages(scratch_, "photos", 4);
  const RunResult cold = detect({photos});
  const std::vector<fs::path> files = entries();
  ASSERT_EQ(files.size(), 4u);
  const auto overwrite = [&](std::size_t i, const std::string& bytes) {
    scratch_.write(files[i].lexically_relative(scratch_.path()).string(), bytes);
  };
  const std::string bytes = readFile(files[0]);
  overwrite(0, replaced(bytes, "alidade_cache 1 ", "alidade_cache 2 "));
  overwrite(1, bytes);  // of another image
  overwrite(2, bytes.substr(0, bytes.size() - 1));
  overwrite(3, bytes.substr(0, bytes.find('\n') + 1) + R"({"corners":[[0,1e300,null,null]]})");
  const RunResult mended = detect({photos});
  ASSERT_THAT(mended, EndsWith(0));
  EXPECT_THAT(mended.err, AllOf(HasSubstr("note: 4 cache entries are damaged"), HasSubstr("computed again")));
  EXPECT_EQ(mended.out, cold.out);
  EXPECT_EQ(detect({photos}).err, cold.err);
}

TEST_F(DetectionCache, RefusesPipesAndDevices) {
  const std::string photos = linkImages(scratch_, "photos", 1);
  int num_refused = 0;
  for (const char* name : {"clip.mp4", "image.png"}) {
    ASSERT_EQ(::mkfifo(scratch_.path(name).c_str(), 0600), 0);
    EXPECT_THAT(detect({scratch_.path(name)}), FailsWith(1, HasSubstr(name)));
    const RunResult beside = detect({photos, scratch_.path(name)});
    EXPECT_THAT(beside, EndsWith(0));
    EXPECT_THAT(beside.err, HasSubstr(std::string(name) + ": unreadable"));
    ++num_refused;
  }
  EXPECT_EQ(num_refused, 2);
  EXPECT_THAT(detect({"/dev/null"}), FailsWith(1, HasSubstr("/dev/null")));
  EXPECT_EQ(entries().size(), 1u);
}

TEST_F(DetectionCache, IsWholeAfterAKill) {
  const std::string photos = linkImages(scratch_, "photos", 12);
  const RunResult plain = runAlidade({"detect", photos, "--board", kBoardSpec});
  std::mt19937 random(7);
  int num_killed = 0;
  for (int i = 0; i < 20; ++i) {
    if (i % 5 == 0) fs::remove_all(scratch_.path("cache"));
    RunningProgram program(alidadeProgram(), {"detect", photos, "--board", kBoardSpec, "--cache",
                                              scratch_.path("cache"), "--jobs", "2"});
    std::this_thread::sleep_for(std::chrono::milliseconds(20 + random() % 300));
    program.sendSignal(SIGKILL);
    num_killed += program.wait().signal == SIGKILL ? 1 : 0;
  }
  EXPECT_GT(num_killed, 5);
  const RunResult after = detect({photos});
  EXPECT_EQ(after.out, plain.out);
  EXPECT_EQ(after.err, plain.err);
}

TEST_F(DetectionCache, ServesSeveralRunsAtATime) {
  const std::string photos = linkImages(scratch_, "photos", 4);
  const RunResult plain = runAlidade({"detect", photos, "--board", kBoardSpec});
  std::vector<RunResult> results(4);
  std::vector<std::thread> threads;
  for (RunResult& result : results) threads.emplace_back([&] { result = detect({photos}); });
  for (std::thread& thread : threads) thread.join();
  int num_same = 0;
  for (const RunResult& result : results)
    num_same += result.out == plain.out && result.err == plain.err ? 1 : 0;
  EXPECT_EQ(num_same, 4);
  EXPECT_EQ(entries().size(), 4u);
}

TEST_F(DetectionCache, IsNoFolderOfOtherFiles) {
  const std::string photos = linkImages(scratch_, "photos", 1);
  EXPECT_THAT(runAlidade({"detect", photos, "--board", kBoardSpec, "--cache", photos}),
              FailsWith(2, AllOf(HasSubstr("--cache " + photos), HasSubstr("next: "))));
  EXPECT_EQ(scratch_.list().size(), 2u);
}

TEST_F(DetectionCache, ServesCalibrationToo) {
  const std::string photos = linkImages(scratch_, "photos", 12);
  const std::vector<std::string> args = {"calibrate", photos,   "--board", kBoardSpec,
                                         "--model",   "radtan", "-o",      "-"};
  std::vector<std::string> with_cache = args;
  with_cache.insert(with_cache.end(), {"--cache", scratch_.path("cache")});
  const RunResult plain = runAlidade(args);
  EXPECT_THAT(plain, EndsWith(0));
  EXPECT_EQ(runAlidade(with_cache).out, plain.out);
  EXPECT_EQ(runAlidade(with_cache).out, plain.out);
}

}  // namespace
}  // namespace alidade
