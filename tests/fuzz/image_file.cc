// SPDX-License-Identifier: MIT
// Files with the name of an image, through everything that comes before the pixels are used.
#include <cstdlib>

#include <sys/mman.h>
#include <unistd.h>

#include "alidade/imagery/image_file.h"
#include "fuzz.h"

namespace {

// A file in memory, of which readers know the path.
class MemoryFile {
 public:
  MemoryFile(const std::uint8_t* data, std::size_t size) : file_(::memfd_create("image", MFD_CLOEXEC)) {
    alidade::expect(::write(file_, data, size) == static_cast<ssize_t>(size), "a file in memory");
  }
  ~MemoryFile() { ::close(file_); }
  MemoryFile(const MemoryFile&) = delete;
  MemoryFile& operator=(const MemoryFile&) = delete;
  [[nodiscard]] std::string path() const { return "/proc/self/fd/" + std::to_string(file_); }

 private:
  int file_;
};

}  // namespace

int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace alidade;
  // Large images are allowed, but would take all the time.
  [[maybe_unused]] static const int kLimit = ::setenv("OPENCV_IO_MAX_IMAGE_PIXELS", "1000000", 1);
  const MemoryFile file(data, size);
  fuzz::read([&] { (void)readGrayImage(file.path()); });
  fuzz::read([&] { (void)readImage(file.path()); });
  return 0;
}
