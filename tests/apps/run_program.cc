// SPDX-License-Identifier: MIT
#include "apps/run_program.h"

#include <algorithm>
#include <array>
#include <cerrno>
#include <csignal>
#include <cstdint>
#include <fstream>
#include <ostream>
#include <stdexcept>
#include <string_view>
#include <system_error>
#include <thread>

#include <fcntl.h>
#include <poll.h>
#include <sys/wait.h>
#include <unistd.h>

namespace alidade {
namespace {

[[noreturn]] void fail(const std::string& what) {
  throw std::runtime_error(what + ": " + std::generic_category().message(errno));
}

void closeEnd(int& fd) {
  if (fd >= 0) ::close(fd);
  fd = -1;
}

struct Pipe {
  Pipe() {
    std::array<int, 2> ends{};
    if (::pipe2(ends.data(), O_CLOEXEC) != 0) fail("pipe");
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

int take(int& fd) {
  const int taken = fd;
  fd = -1;
  return taken;
}

// In the new process: only calls that are allowed between fork and exec.
[[noreturn]] void becomeProgram(char* const* argv, const RunOptions& options, int in, int out, int err) {
  constexpr int kCannotStart = 127;
  if (!options.input_path.empty()) in = ::open(options.input_path.c_str(), O_RDONLY);
  if (!options.output_path.empty()) out = ::open(options.output_path.c_str(), O_WRONLY);
  if (in < 0 || out < 0 || ::dup2(in, 0) < 0 || ::dup2(out, 1) < 0 || ::dup2(err, 2) < 0)
    ::_exit(kCannotStart);
  if (!options.folder.empty() && ::chdir(options.folder.c_str()) != 0) ::_exit(kCannotStart);
  for (const int signal : {SIGINT, SIGTERM, SIGHUP, SIGPIPE}) std::signal(signal, SIG_DFL);
  ::execv(argv[0], argv);
  ::_exit(kCannotStart);
}

// Appends what there is; false at the end.
bool readSome(int fd, std::string& text) {
  std::array<char, 65536> block{};
  const ssize_t count = ::read(fd, block.data(), block.size());
  if (count > 0) text.append(block.data(), static_cast<std::size_t>(count));
  return count > 0 || (count < 0 && errno == EINTR);
}

}  // namespace

void PrintTo(const RunResult& result, std::ostream* out) {
  *out << "exit code " << result.exit_code << ", signal " << result.signal
       << (result.is_late ? ", too late" : "") << ", " << result.out.size()
       << " bytes of output, and the messages\n"
       << result.err;
}

RunningProgram::RunningProgram(const std::string& program, const std::vector<std::string>& args,
                               RunOptions options)
    : options_(std::move(options)), deadline_(std::chrono::steady_clock::now() + options_.time_limit) {
  std::vector<std::string> words = {program};
  words.insert(words.end(), args.begin(), args.end());
  std::vector<char*> argv;
  for (std::string& word : words) argv.push_back(word.data());
  argv.push_back(nullptr);

  std::signal(SIGPIPE, SIG_IGN);  // a program that reads no input must not end the test
  Pipe in;
  Pipe out;
  Pipe err;
  pid_ = ::fork();
  if (pid_ < 0) fail("fork");
  if (pid_ == 0) becomeProgram(argv.data(), options_, in.read, out.write, err.write);
  in_ = take(in.write);
  out_ = take(out.read);
  err_ = take(err.read);
  // Feeding must never wait, or a program that waits for its output to be read would wait for ever.
  ::fcntl(in_, F_SETFL, O_NONBLOCK);
  if (options_.input.empty()) closeEnd(in_);
}

RunningProgram::~RunningProgram() {
  closeEnd(in_);
  closeEnd(out_);
  closeEnd(err_);
  if (pid_ > 0) {
    ::kill(pid_, SIGKILL);
    ::waitpid(pid_, nullptr, 0);
  }
}

void RunningProgram::sendSignal(int signal) const {
  if (pid_ > 0) ::kill(pid_, signal);
}

bool RunningProgram::waitUntilItCatches(int signal) const {
  const std::string status_path = "/proc/" + std::to_string(pid_) + "/status";
  const std::uint64_t bit = std::uint64_t{1} << static_cast<unsigned>(signal - 1);
  while (std::chrono::steady_clock::now() < deadline_) {
    std::ifstream status(status_path);
    std::uint64_t caught = 0;
    for (std::string word; status >> word;) {
      if (word == "SigCgt:") status >> std::hex >> caught;
    }
    if ((caught & bit) != 0) return true;
    std::this_thread::sleep_for(std::chrono::milliseconds(5));
  }
  return false;
}

void RunningProgram::closeOutput() {
  closeEnd(out_);
}

void RunningProgram::exchange(RunResult& result) {
  std::string_view input = options_.input;
  while (out_ >= 0 || err_ >= 0) {
    const auto left =
        std::chrono::duration_cast<std::chrono::milliseconds>(deadline_ - std::chrono::steady_clock::now());
    std::array<pollfd, 3> fds = {{{in_, POLLOUT, 0}, {out_, POLLIN, 0}, {err_, POLLIN, 0}}};
    const int num_ready = ::poll(fds.data(), fds.size(), std::max(0, static_cast<int>(left.count())));
    if (num_ready < 0 && errno == EINTR) continue;
    if (num_ready <= 0) {
      result.is_late = true;
      sendSignal(SIGKILL);
      return;
    }
    if (fds[0].revents != 0) {
      const ssize_t count = ::write(in_, input.data(), input.size());
      if (count > 0) input.remove_prefix(static_cast<std::size_t>(count));
      if (input.empty() || (count < 0 && errno != EAGAIN && errno != EINTR)) closeEnd(in_);
    }
    if (fds[1].revents != 0 && !readSome(out_, result.out)) closeEnd(out_);
    if (fds[2].revents != 0 && !readSome(err_, result.err)) closeEnd(err_);
  }
}

RunResult RunningProgram::wait() {
  RunResult result;
  exchange(result);
  closeEnd(in_);
  int status = 0;
  while (::waitpid(pid_, &status, 0) < 0 && errno == EINTR) {
  }
  pid_ = -1;
  if (WIFEXITED(status)) result.exit_code = WEXITSTATUS(status);
  if (WIFSIGNALED(status)) result.signal = WTERMSIG(status);
  return result;
}

RunResult runProgram(const std::string& program, const std::vector<std::string>& args, RunOptions options) {
  return RunningProgram(program, args, std::move(options)).wait();
}

}  // namespace alidade
