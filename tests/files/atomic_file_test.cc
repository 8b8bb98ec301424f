// SPDX-License-Identifier: MIT
#include "alidade/files/text/atomic_file.h"

#include <fcntl.h>
#include <gmock/gmock.h>
#include <sys/resource.h>
#include <sys/stat.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <csignal>
#include <filesystem>
#include <functional>
#include <string>
#include <thread>
#include <vector>

#include "alidade/core/error.h"
#include "support/message_of.h"
#include "support/scratch_test.h"

namespace alidade {
namespace {

namespace fs = std::filesystem;
using testing::AllOf;
using testing::ElementsAre;
using testing::HasSubstr;
using testing::Not;

constexpr std::size_t kEnough = std::size_t{1} << 24;

class AtomicFile : public ScratchTest {
 protected:
  [[nodiscard]] unsigned modeOf(const std::string& name) const {
    struct stat status {};
    EXPECT_EQ(::stat(path(name).c_str(), &status), 0);
    return status.st_mode & 07777U;
  }
};

TEST_F(AtomicFile, WritesAndReplaces) {
  const std::string binary("a\0b\xFF", 4);
  writeFileAtomically(path("a"), "a long first content");
  writeFileAtomically(path("a"), binary);
  EXPECT_EQ(readBinaryFile(path("a"), kEnough), binary);
  writeFileAtomically(path("a"), "");
  EXPECT_EQ(readBinaryFile(path("a"), kEnough), "");
  EXPECT_THAT(scratch_.list(), ElementsAre("a"));
}

TEST_F(AtomicFile, WritesIntoTheCurrentFolder) {
  const fs::path previous = fs::current_path();
  fs::current_path(folder_);
  writeFileAtomically("bare", "x");
  fs::current_path(previous);
  EXPECT_THAT(scratch_.list(), ElementsAre("bare"));
}

TEST_F(AtomicFile, WritesNamesOfTheGreatestLength) {
  const std::string name(255, 'n');
  writeFileAtomically(path(name), "x");
  EXPECT_THAT(scratch_.list(), ElementsAre(name));
  EXPECT_THAT(messageOf([&] { writeFileAtomically(path(name + "n"), "x"); }), HasSubstr("a shorter name"));
}

TEST_F(AtomicFile, GivesNewFilesTheUmaskAndKeepsTheModeOfOldOnes) {
  const mode_t previous = ::umask(027);
  writeFileAtomically(path("new"), "x");
  EXPECT_EQ(modeOf("new"), 0640U);
  ASSERT_EQ(::chmod(path("new").c_str(), 0606), 0);
  writeFileAtomically(path("new"), "y");
  EXPECT_EQ(modeOf("new"), 0606U);
  ::umask(previous);
}

TEST_F(AtomicFile, FollowsLinks) {
  fs::create_directory(folder_ / "sub");
  fs::create_symlink("sub/target", folder_ / "link");
  fs::create_symlink("link", folder_ / "link_to_link");
  writeFileAtomically(path("link_to_link"), "new");  // the target does not exist yet
  EXPECT_EQ(readTextFile(path("sub/target"), kEnough), "new");
  writeFileAtomically(path("link"), "newer");
  EXPECT_EQ(readTextFile(path("sub/target"), kEnough), "newer");
  EXPECT_TRUE(fs::is_symlink(folder_ / "link"));
  EXPECT_TRUE(fs::is_symlink(folder_ / "link_to_link"));

  fs::create_symlink("loop", folder_ / "loop");
  EXPECT_THAT(messageOf([&] { writeFileAtomically(path("loop"), "x"); }), HasSubstr("cannot be written"));
  EXPECT_TRUE(fs::is_symlink(folder_ / "loop"));
}

TEST_F(AtomicFile, WritesStraightToPipesAndDevices) {
  ASSERT_EQ(::mkfifo(path("fifo").c_str(), 0600), 0);
  std::string received;
  std::thread reader([&] { received = readBinaryFile(path("fifo"), kEnough); });
  const std::string content(1 << 18, 'x');  // more than a pipe holds at once
  writeFileAtomically(path("fifo"), content);
  reader.join();
  EXPECT_EQ(received, content);
  EXPECT_TRUE(fs::is_fifo(folder_ / "fifo"));
  writeFileAtomically("/dev/null", content);
  EXPECT_TRUE(fs::is_character_file("/dev/null"));
}

TEST_F(AtomicFile, AppendsToAnOpenFileGivenByItsDescriptor) {
  writeFileAtomically(path("log"), "before ");
  const int fd = ::open(path("log").c_str(), O_WRONLY | O_APPEND);
  ASSERT_GE(fd, 0);
  writeFileAtomically("/dev/fd/" + std::to_string(fd), "after");
  ::close(fd);
  EXPECT_EQ(readTextFile(path("log"), kEnough), "before after");
}

TEST_F(AtomicFile, ReportsAFullDisk) {
  EXPECT_THAT(messageOf([] { writeFileAtomically("/dev/full", "x"); }),
              AllOf(HasSubstr("/dev/full"), HasSubstr("No space left"), HasSubstr("free some space")));
}

TEST_F(AtomicFile, KeepsTheOldFileWhenWritingFails) {
  writeFileAtomically(path("a"), "old");
  // A limit on the size of files makes write() fail half way, as a full disk does.
  rlimit previous{};
  ASSERT_EQ(::getrlimit(RLIMIT_FSIZE, &previous), 0);
  const auto previous_handler = std::signal(SIGXFSZ, SIG_IGN);
  const rlimit limit{.rlim_cur = 1000, .rlim_max = previous.rlim_max};
  ASSERT_EQ(::setrlimit(RLIMIT_FSIZE, &limit), 0);
  const std::string message = messageOf([&] { writeFileAtomically(path("a"), std::string(5000, 'x')); });
  ASSERT_EQ(::setrlimit(RLIMIT_FSIZE, &previous), 0);
  (void)std::signal(SIGXFSZ, previous_handler);

  EXPECT_THAT(message, AllOf(HasSubstr(path("a")), HasSubstr("too large")));
  EXPECT_EQ(readTextFile(path("a"), kEnough), "old");
  EXPECT_THAT(scratch_.list(), ElementsAre("a"));
}

TEST_F(AtomicFile, RefusesPlacesThatCannotBeWritten) {
  writeFileAtomically(path("file"), "x");
  EXPECT_THAT(messageOf([&] { writeFileAtomically(path("no/such/out"), "x"); }),
              AllOf(HasSubstr(path("no/such/out")), HasSubstr(path("no/such") + "'"), HasSubstr("create")));
  EXPECT_THAT(messageOf([&] { writeFileAtomically(path("file/out"), "x"); }), HasSubstr("Not a directory"));
  EXPECT_THAT(messageOf([&] { writeFileAtomically(folder_.string(), "x"); }), HasSubstr("add a file name"));
  EXPECT_THAT(messageOf([&] { writeFileAtomically(path("new/"), "x"); }), HasSubstr("add a file name"));
  EXPECT_THAT(messageOf([] { writeFileAtomically("", "x"); }), HasSubstr("''"));
  EXPECT_THAT(scratch_.list(), ElementsAre("file"));
}

TEST_F(AtomicFile, RespectsWriteProtection) {
  fs::create_directory(folder_ / "closed");
  writeFileAtomically(path("closed/protected"), "old");
  fs::permissions(folder_ / "closed/protected", fs::perms::owner_read);
  const auto overwrite = [&] { writeFileAtomically(path("closed/protected"), "new"); };
  if (::geteuid() == 0) {  // may write everywhere, and the protection stays
    overwrite();
    EXPECT_EQ(modeOf("closed/protected"), 0400U);
  } else {
    EXPECT_THAT(messageOf(overwrite), HasSubstr("Permission denied"));
    fs::permissions(folder_ / "closed", fs::perms::owner_read | fs::perms::owner_exec);
    EXPECT_THAT(messageOf([&] { writeFileAtomically(path("closed/new"), "x"); }),
                HasSubstr("Permission denied"));
    fs::permissions(folder_ / "closed", fs::perms::owner_all);
    EXPECT_EQ(readTextFile(path("closed/protected"), kEnough), "old");
  }
}

TEST_F(AtomicFile, LeavesAWholeFileAndNothingElseWhenTerminated) {
  constexpr int kNumRuns = 20;
  const std::string contents[] = {std::string(1 << 20, 'a'), std::string(1 << 20, 'b')};
  writeFileAtomically(path("a"), contents[0]);
  int num_terminated = 0;
  for (int run = 0; run < kNumRuns; ++run) {
    const pid_t child = ::fork();
    ASSERT_GE(child, 0);
    if (child == 0) {
      for (unsigned i = 0;; ++i) writeFileAtomically(path("a"), contents[i % 2]);
    }
    ::usleep(static_cast<useconds_t>(2000 + 700 * run));
    ::kill(child, SIGTERM);
    int status = 0;
    ASSERT_EQ(::waitpid(child, &status, 0), child);
    num_terminated += WIFSIGNALED(status) && WTERMSIG(status) == SIGTERM ? 1 : 0;
    const std::string content = readBinaryFile(path("a"), kEnough);
    EXPECT_TRUE(content == contents[0] || content == contents[1]);
    EXPECT_THAT(scratch_.list(), ElementsAre("a"));
  }
  EXPECT_EQ(num_terminated, kNumRuns);
}

TEST_F(AtomicFile, ReadsUpToTheLimit) {
  const std::string content(100'000, 'x');
  writeFileAtomically(path("a"), content);
  EXPECT_EQ(readBinaryFile(path("a"), content.size()), content);
  EXPECT_THAT(messageOf([&] { (void)readBinaryFile(path("a"), content.size() - 1); }),
              AllOf(HasSubstr("too large"), HasSubstr("at most 99999 bytes")));
  EXPECT_THAT(messageOf([] { (void)readBinaryFile("/dev/zero", 1 << 20); }), HasSubstr("too large"));
}

TEST_F(AtomicFile, ReadsTextOnly) {
  writeFileAtomically(path("bom"), "\xEF\xBB\xBFmodel: radtan");
  EXPECT_EQ(readTextFile(path("bom"), kEnough), "model: radtan");
  writeFileAtomically(path("utf16"), std::string_view("\xFF\xFEm\0o\0", 6));
  EXPECT_THAT(messageOf([&] { (void)readTextFile(path("utf16"), kEnough); }),
              AllOf(HasSubstr("zero byte at offset 3"), HasSubstr("UTF-8")));
}

TEST_F(AtomicFile, NamesTheNearestPath) {
  fs::create_directory(folder_ / "left");
  writeFileAtomically(path("left/camera.yaml"), "x");
  fs::create_symlink("nowhere", folder_ / "dangling");
  const auto read = [this](const std::string& name) {
    return messageOf([&] { (void)readTextFile(path(name), kEnough); });
  };
  EXPECT_THAT(read("left/camra.yaml"), HasSubstr("did you mean '" + path("left/camera.yaml") + "'?"));
  EXPECT_THAT(read("lest/camera.yaml"), AllOf(HasSubstr("there is no folder '" + path("lest") + "'"),
                                              HasSubstr("did you mean '" + path("left/camera.yaml") + "'?")));
  EXPECT_THAT(read("quite_different"), AllOf(HasSubstr("no such file"), Not(HasSubstr("it is relative to"))));
  EXPECT_THAT(read("left/camera.yaml/x"), HasSubstr(path("left/camera.yaml") + "' is a file"));
  EXPECT_THAT(read("dangling"), HasSubstr("is broken"));
  EXPECT_THAT(read("left"), HasSubstr("this is a folder"));
  EXPECT_THAT(messageOf([] { (void)readTextFile("quite_different", kEnough); }),
              HasSubstr("it is relative to"));
  EXPECT_THAT(messageOf([] { (void)readTextFile("", kEnough); }), HasSubstr("the path is empty"));
}

TEST_F(AtomicFile, NamesUnreadableFiles) {
  writeFileAtomically(path("secret"), "x");
  fs::permissions(folder_ / "secret", fs::perms::none);
  // Root reads everything but the memory of a process at address 0.
  const std::string unreadable = ::geteuid() == 0 ? "/proc/self/mem" : path("secret");
  EXPECT_THAT(messageOf([&] { (void)readTextFile(unreadable, kEnough); }),
              AllOf(HasSubstr(unreadable), HasSubstr("cannot be read: ")));
}

}  // namespace
}  // namespace alidade
