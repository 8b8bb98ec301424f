// SPDX-License-Identifier: MIT
#include <csignal>
#include <cstdlib>
#include <exception>
#include <new>

#include <fcntl.h>
#ifdef __GLIBC__
#include <malloc.h>
#endif
#include <sys/resource.h>
#include <unistd.h>

#include "alidade/core/cancel.h"
#include "console.h"
#include "program.h"

namespace alidade {
namespace {

// Exceptions cannot pass through C libraries and noexcept functions and end here. Too little memory is not a
// bug, and may also prevent the message.
[[noreturn]] void onTerminate() {
  try {
    if (std::current_exception()) std::rethrow_exception(std::current_exception());
  } catch (const std::bad_alloc&) {
    printHelp("error: ");
    printHelp(kOutOfMemory);
    printHelp("\n");
    ::_exit(kInputExit);
  } catch (...) {
  }
  std::abort();
}

// Shared libraries, too, can run out of memory before main().
void handleTermination(int, char**, char**) {
  std::set_terminate(onTerminate);
}
[[gnu::section(".preinit_array"), gnu::used]] void (*const before_libraries)(int, char**,
                                                                             char**) = handleTermination;

// Some image libraries crash if they cannot allocate memory at start-up.
[[nodiscard]] bool isMemoryTooSmall() {
  constexpr rlim_t kLeastBytes = rlim_t{320} << 20U;  // the libraries alone take 210 MB
  rlimit limit{};
  return ::getrlimit(RLIMIT_AS, &limit) == 0 && limit.rlim_cur < kLeastBytes;
}

// Memory that was returned to the kernel must be faulted in and zeroed again: a quarter of the time of
// calibrating an uneven board from 13 views.
void keepMemory() {
#ifdef __GLIBC__
  constexpr int kBytes = 32 << 20;  // the largest threshold that glibc accepts on 64 bits
  ::mallopt(M_MMAP_THRESHOLD, kBytes);
  ::mallopt(M_TRIM_THRESHOLD, 8 * kBytes);
#endif
}

}  // namespace
}  // namespace alidade

int main(int argc, char** argv) {
  using namespace alidade;
  // The next opened file would reuse a closed stream's number and receive messages. Using the stream must
  // still fail.
  for (const int stream : {STDIN_FILENO, STDOUT_FILENO, STDERR_FILENO}) {
    if (::fcntl(stream, F_GETFD) == -1)
      static_cast<void>(::open("/dev/null", stream == STDIN_FILENO ? O_WRONLY : O_RDONLY));
  }
  silenceLibraries();
  keepMemory();
  std::signal(SIGXFSZ, SIG_IGN);  // the write fails and reports an error
  if (isMemoryTooSmall()) {
    printMessage(
        "error: the memory limit (ulimit -v) is below 320 MB; expected a higher one, or none\n  next: ulimit "
        "-v unlimited");
    return kInputExit;
  }
  try {
    return runProgram(argc, argv);
  } catch (const Cancelled&) {
    printMessage("interrupted; no result was written");
    endByCaughtSignal();
  }
}
