// SPDX-License-Identifier: MIT
#include "alidade/imagery/child_process.h"

#include <array>
#include <cerrno>
#include <csignal>
#include <cstring>
#include <string_view>
#include <system_error>

#include <fcntl.h>
#include <poll.h>
#include <spawn.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

extern char** environ;

namespace alidade {
namespace {

void check(int error, const std::string& what) {
  if (error != 0) throw std::system_error(error, std::generic_category(), what);
}

void closeEnd(int& end) {
  if (end >= 0) ::close(end);
  end = -1;
}

// Ends that no other child inherits: it would keep a pipe open.
struct Pipe {
  Pipe() {
    std::array<int, 2> ends{};
#ifdef __linux__
    check(::pipe2(ends.data(), O_CLOEXEC) == 0 ? 0 : errno, "pipe");
#else
    check(::pipe(ends.data()) == 0 ? 0 : errno, "pipe");
    for (const int end : ends) ::fcntl(end, F_SETFD, FD_CLOEXEC);
#endif
    read = ends[0];
    write = ends[1];
  }
  ~Pipe() {
    closeEnd(read);
    closeEnd(write);
  }
  Pipe(const Pipe&) = delete;
  Pipe& operator=(const Pipe&) = delete;

  int read = -1;
  int write = -1;
};

struct SpawnSettings {
  SpawnSettings() {
    check(::posix_spawn_file_actions_init(&files), "posix_spawn");
    check(::posix_spawnattr_init(&attributes), "posix_spawn");
  }
  ~SpawnSettings() {
    ::posix_spawn_file_actions_destroy(&files);
    ::posix_spawnattr_destroy(&attributes);
  }
  SpawnSettings(const SpawnSettings&) = delete;
  SpawnSettings& operator=(const SpawnSettings&) = delete;

  posix_spawn_file_actions_t files{};
  posix_spawnattr_t attributes{};
};

// Reads what there is, and closes the end if nothing is to come.
std::size_t readSome(int& end, char* data, std::size_t size) {
  const ssize_t count = ::read(end, data, size);
  if (count > 0) return static_cast<std::size_t>(count);
  if (count == 0 || (errno != EINTR && errno != EAGAIN)) closeEnd(end);
  return 0;
}

bool isReadable(int end, int milliseconds) {
  pollfd polled{end, POLLIN, 0};
  return end >= 0 && ::poll(&polled, 1, milliseconds) > 0;
}

}  // namespace

ChildProcess::ChildProcess(const std::vector<std::string>& command, std::size_t max_bytes) {
  std::vector<char*> words;
  for (const std::string& word : command) words.push_back(const_cast<char*>(word.c_str()));
  words.push_back(nullptr);
  // Without the variables that colour FFmpeg's messages, or write them to a file.
  std::vector<char*> variables;
  for (char** variable = environ; *variable != nullptr; ++variable) {
    const std::string_view text = *variable;
    if (!text.starts_with("AV_LOG_") && !text.starts_with("FFREPORT=")) variables.push_back(*variable);
  }
  variables.push_back(nullptr);
  Pipe out;
  Pipe err;
  SpawnSettings settings;
  ::posix_spawn_file_actions_addopen(&settings.files, 0, "/dev/null", O_RDONLY, 0);
  ::posix_spawn_file_actions_adddup2(&settings.files, out.write, 1);
  ::posix_spawn_file_actions_adddup2(&settings.files, err.write, 2);
#if defined(__GLIBC__) && (__GLIBC__ > 2 || __GLIBC_MINOR__ >= 34)
  ::posix_spawn_file_actions_addclosefrom_np(&settings.files, 3);
#endif
  // A group of its own: Ctrl-C is for this program, which kills the whole group in its time.
  sigset_t signals;
  ::sigemptyset(&signals);
  ::posix_spawnattr_setsigmask(&settings.attributes, &signals);
  for (const int signal : {SIGPIPE, SIGINT, SIGTERM, SIGHUP, SIGXFSZ}) ::sigaddset(&signals, signal);
  ::posix_spawnattr_setsigdefault(&settings.attributes, &signals);
  ::posix_spawnattr_setpgroup(&settings.attributes, 0);
  ::posix_spawnattr_setflags(&settings.attributes,
                             POSIX_SPAWN_SETSIGMASK | POSIX_SPAWN_SETSIGDEF | POSIX_SPAWN_SETPGROUP);
  check(::posix_spawnp(&pid_, words.front(), &settings.files, &settings.attributes, words.data(),
                       variables.data()),
        command.front());
#ifdef __linux__
  const rlimit limit{max_bytes, max_bytes};
  ::prlimit(pid_, RLIMIT_AS, &limit, nullptr);
  constexpr int kPipeBytes = 1 << 20;  // spares switches between the programs
  for (const Pipe* pipe : {&out, &err}) ::fcntl(pipe->read, F_SETPIPE_SZ, kPipeBytes);
#endif
  ::fcntl(err.read, F_SETFL, O_NONBLOCK);
  std::swap(out_, out.read);
  std::swap(err_, err.read);
}

ChildProcess::~ChildProcess() {
  closeEnd(out_);
  closeEnd(err_);
  if (pid_ < 0) return;
  ::kill(-pid_, SIGKILL);
  (void)failure();
}

std::size_t ChildProcess::read(char* data, std::size_t size, std::string& messages,
                               const CancelFlag* cancel) {
  const std::size_t num_before = messages.size();
  for (;;) {
    throwIfCancelled(cancel);
    // Messages come in many small pieces, so they are looked at from time to time, and when there is output.
    constexpr int kPieceMilliseconds = 5;
    constexpr int kCancelMilliseconds = 100;
    const bool is_ready = isReadable(out_, kPieceMilliseconds);
    if (out_ < 0 || (is_ready && size == 0)) (void)isReadable(err_, kCancelMilliseconds);
    if (err_ >= 0) {
      std::array<char, 65536> block;  // NOLINT(cppcoreguidelines-pro-type-member-init)
      messages.append(block.data(), readSome(err_, block.data(), block.size()));
    }
    if (is_ready && size > 0) return readSome(out_, data, size);
    if (messages.size() > num_before || (err_ < 0 && (out_ < 0 || size == 0))) return 0;
  }
}

std::string ChildProcess::failure() {
  int status = 0;
  pid_t ended = -1;
  do {
    ended = ::waitpid(pid_, &status, 0);
  } while (ended < 0 && errno == EINTR);
  pid_ = -1;
  if (ended < 0)
    return "an unknown status";  // somebody else asked for it, or signals of children are ignored
  if (WIFSIGNALED(status))
    return "signal " + std::to_string(WTERMSIG(status)) + " (" + ::strsignal(WTERMSIG(status)) + ")";
  return WEXITSTATUS(status) == 0 ? "" : "status " + std::to_string(WEXITSTATUS(status));
}

}  // namespace alidade
