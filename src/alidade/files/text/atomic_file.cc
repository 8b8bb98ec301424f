// SPDX-License-Identifier: MIT
#include "alidade/files/text/atomic_file.h"

#include <fcntl.h>
#include <signal.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <atomic>
#include <cerrno>
#include <filesystem>
#include <optional>
#include <system_error>
#include <vector>

#include "alidade/core/text.h"
#include "alidade/files/text/file_text.h"

namespace alidade {
namespace {

namespace fs = std::filesystem;

std::string quoted(const fs::path& path) {
  return "'" + path.string() + "'";
}

std::string errorText(int error) {
  return std::generic_category().message(error);
}

std::string adviceForWriting(int error) {
  if (error == ENOENT || error == ENOTDIR) return "create the folder first, or choose another path";
  if (error == EACCES || error == EPERM || error == EROFS)
    return "choose a writable path, or change its permissions";
  if (error == ENOSPC || error == EDQUOT) return "free some space, or choose a path on another disk";
  if (error == EISDIR) return "add a file name to the path";
  if (error == ENAMETOOLONG) return "choose a shorter name";
  return "check the path, or choose another one";
}

/// `folder` is named if the error concerns creating a file in it.
Error writeError(const std::string& path, int error, const fs::path& folder = {}) {
  std::string found = "cannot be written: " + errorText(error);
  if (!folder.empty()) found += " (in the folder " + quoted(folder) + ")";
  return detail::errorAt(path.empty() ? "''" : path, found, "a writable path", adviceForWriting(error));
}

Error readError(const std::string& path, int error) {
  return detail::errorAt(path.empty() ? "''" : path, "cannot be read: " + errorText(error), "a readable file",
                         error == EACCES || error == EPERM
                             ? "change the permissions of the file and its folders (chmod u+r)"
                             : "check the path and the disk");
}

/// Owns a file descriptor.
class Descriptor {
 public:
  explicit Descriptor(int fd) : fd_(fd) {}
  Descriptor(const Descriptor&) = delete;
  Descriptor& operator=(const Descriptor&) = delete;
  ~Descriptor() {
    if (fd_ >= 0) ::close(fd_);
  }

  [[nodiscard]] int get() const { return fd_; }
  /// Network disks report a full disk only here. Returns 0 or the errno.
  [[nodiscard]] int close() {
    const int status = ::close(fd_);
    fd_ = -1;
    return status == 0 ? 0 : errno;
  }

 private:
  int fd_;
};

/// Delays signals that end the program until the end of the scope, so that no temporary file remains.
class SignalDelay {
 public:
  SignalDelay() {
    sigset_t delayed;
    sigemptyset(&delayed);
    for (const int signal : {SIGINT, SIGTERM, SIGHUP}) sigaddset(&delayed, signal);
    pthread_sigmask(SIG_BLOCK, &delayed, &previous_);
  }
  SignalDelay(const SignalDelay&) = delete;
  SignalDelay& operator=(const SignalDelay&) = delete;
  ~SignalDelay() { pthread_sigmask(SIG_SETMASK, &previous_, nullptr); }

 private:
  sigset_t previous_{};
};

/// Returns 0 or the errno.
[[nodiscard]] int writeAll(int fd, std::string_view content) {
  while (!content.empty()) {
    const ssize_t written = ::write(fd, content.data(), content.size());
    if (written < 0 && errno != EINTR) return errno;
    if (written > 0) content.remove_prefix(static_cast<std::size_t>(written));
  }
  return 0;
}

void writeStraight(const std::string& path, std::string_view content) {
  // Appending preserves earlier output of a shell's "command >> log" and our own.
  Descriptor file(::open(path.c_str(), O_WRONLY | O_APPEND | O_CLOEXEC));
  if (file.get() < 0) throw writeError(path, errno);
  if (const int error = writeAll(file.get(), content)) throw writeError(path, error);
  if (const int error = file.close()) throw writeError(path, error);
}

/// The end of a chain of symbolic links, which need not exist; nothing if the chain leads through /proc, to
/// which /dev/stdout and /dev/fd/3 point: those are open files without a name to rename to.
std::optional<fs::path> followLinks(const std::string& path) {
  constexpr int kMaxLinks = 40;  // as in the kernel
  fs::path target = path;
  std::error_code error;
  for (int i = 0; i < kMaxLinks && fs::is_symlink(fs::symlink_status(target, error)); ++i) {
    // The folder may itself be a link (/dev/fd leads to /proc/self/fd).
    const fs::path folder = fs::weakly_canonical(target.parent_path(), error);
    if (folder.string().starts_with("/proc/")) return std::nullopt;
    const fs::path next = fs::read_symlink(target, error);
    if (error) break;
    target = target.parent_path() / next;
  }
  return target;
}

/// A new empty file in `folder`, open for writing, with the permissions according to the user's umask.
/// Returns the descriptor, or -1 with errno set.
int createTemporary(const fs::path& folder, fs::path& path) {
  static std::atomic<unsigned> counter{0};
  int fd = -1;
  do {
    path = folder / (".alidade-" + std::to_string(::getpid()) + "-" + std::to_string(counter++) + ".tmp");
    constexpr mode_t kBeforeUmask = 0666;
    fd = ::open(path.c_str(), O_WRONLY | O_CREAT | O_EXCL | O_CLOEXEC, kBeforeUmask);
  } while (fd < 0 && errno == EEXIST);
  return fd;
}

/// The target of the rename (empty = nothing to replace, write directly), and the file that it replaces,
/// whose permissions and owner are kept.
std::pair<fs::path, std::optional<struct stat>> findTarget(const std::string& path) {
  struct stat existing {};
  const bool exists = ::stat(path.c_str(), &existing) == 0;
  if (!exists && errno != ENOENT) throw writeError(path, errno);
  if (exists && S_ISDIR(existing.st_mode)) throw writeError(path, EISDIR);
  const std::optional<fs::path> target = followLinks(path);
  if ((exists && !S_ISREG(existing.st_mode)) || !target) return {};
  if (!target->has_filename()) throw writeError(path, path.empty() ? ENOENT : EISDIR);
  // Renaming would silently replace a write-protected file.
  if (exists && ::access(path.c_str(), W_OK) != 0) throw writeError(path, errno);
  return {*target, exists ? std::optional(existing) : std::nullopt};
}

void replaceFile(const std::string& path, const fs::path& target, const std::optional<struct stat>& replaced,
                 std::string_view content, Durability durability) {
  const SignalDelay delay;
  fs::path temporary;
  const fs::path folder = target.parent_path();
  Descriptor file(createTemporary(folder, temporary));
  if (file.get() < 0) throw writeError(path, errno, folder);
  int error = 0;
  if (replaced) {
    // Only root may change the owner. Otherwise set-id bits must not carry over to a file that we own.
    const bool is_owned = ::fchown(file.get(), replaced->st_uid, replaced->st_gid) == 0;
    const mode_t kept = is_owned ? 07777 : 0777;
    if (::fchmod(file.get(), replaced->st_mode & kept) != 0) error = errno;
  }
  if (error == 0) error = writeAll(file.get(), content);
  if (error == 0 && durability == Durability::kSafe && ::fsync(file.get()) != 0) error = errno;
  if (error == 0) error = file.close();
  if (error == 0 && ::rename(temporary.c_str(), target.c_str()) != 0) error = errno;
  if (error == 0) return;
  ::unlink(temporary.c_str());
  throw writeError(path, error);
}

std::vector<std::string> namesIn(const fs::path& folder) {
  std::vector<std::string> names;
  std::error_code error;
  fs::directory_iterator entry(folder, error);
  for (; !error && entry != fs::directory_iterator(); entry.increment(error)) {
    names.push_back(entry->path().filename().string());
  }
  std::sort(names.begin(), names.end());
  return names;
}

}  // namespace

void writeFileAtomically(const std::string& path, std::string_view content, Durability durability) {
  const auto [target, replaced] = findTarget(path);
  if (target.empty()) return writeStraight(path, content);
  replaceFile(path, target, replaced, content, durability);
}

void checkWritable(const std::string& path) {
  const fs::path target = findTarget(path).first;
  if (target.empty()) return;
  const fs::path folder = target.parent_path();
  if (::access(folder.empty() ? "." : folder.c_str(), W_OK | X_OK) != 0)
    throw writeError(path, errno, folder);
}

std::string writtenPath(const std::string& path) {
  std::error_code error;
  const fs::path absolute = fs::absolute(followLinks(path).value_or(path), error);
  const fs::path canonical = fs::weakly_canonical(absolute, error);
  return error ? path : canonical.string();
}

std::string readBinaryFile(const std::string& path, std::size_t max_bytes) {
  struct stat status {};
  if (::stat(path.c_str(), &status) != 0) {
    if (errno == ENOENT || errno == ENOTDIR) throw missingPathError(path);
    throw readError(path, errno);
  }
  if (S_ISDIR(status.st_mode)) {
    throw detail::errorAt(path, "this is a folder", "a file", "give the path of a file in it");
  }
  const Descriptor file(::open(path.c_str(), O_RDONLY | O_CLOEXEC));
  if (file.get() < 0) throw readError(path, errno);

  // The size is only a hint: devices and pipes have none, and another program may be writing the file.
  std::string content;
  if (S_ISREG(status.st_mode)) content.reserve(std::min(static_cast<std::size_t>(status.st_size), max_bytes));
  constexpr std::size_t kBlock = std::size_t{1} << 16;
  std::vector<char> block(kBlock);
  for (;;) {
    const ssize_t count = ::read(file.get(), block.data(), block.size());
    if (count == 0) return content;
    if (count < 0 && errno == EINTR) continue;
    if (count < 0) throw readError(path, errno);
    if (static_cast<std::size_t>(count) > max_bytes - content.size()) {
      throw detail::errorAt(path, "the file is too large", "at most " + std::to_string(max_bytes) + " bytes",
                            "check that this is the file you meant");
    }
    content.append(block.data(), static_cast<std::size_t>(count));
  }
}

std::string readTextFile(const std::string& path, std::size_t max_bytes) {
  return textOf(readBinaryFile(path, max_bytes), path);
}

std::string textOf(std::string text, const std::string& path) {
  if (const std::size_t at = text.find('\0'); at != std::string::npos) {
    throw detail::errorAt(path, "a zero byte at offset " + std::to_string(at), "UTF-8 text",
                          "check that this is the file you meant, and save UTF-16 text as UTF-8");
  }
  constexpr std::string_view kByteOrderMark = "\xEF\xBB\xBF";
  if (text.starts_with(kByteOrderMark)) text.erase(0, kByteOrderMark.size());
  return text;
}

Error missingPathError(const std::string& path) {
  if (path.empty()) {
    return detail::errorAt("''", "the path is empty", "the path of a file or folder", "give a path");
  }
  // parent: the existing part; then the first missing name; then the rest.
  fs::path parent;
  fs::path missing;
  fs::path rest;
  std::error_code error;
  for (const fs::path& part : fs::path(path)) {
    const bool exists = missing.empty() && fs::exists(parent / part, error);
    fs::path& end = exists ? parent : missing.empty() ? missing : rest;
    end /= part;
  }
  if (!parent.empty() && !fs::is_directory(parent, error)) {
    return detail::errorAt(path, quoted(parent) + " is a file, not a folder", "the path of a file or folder",
                           "check the path");
  }
  const fs::path missing_path = parent / missing;
  std::string found = rest.empty() ? "no such file or folder" : "there is no folder " + quoted(missing_path);
  if (fs::is_symlink(fs::symlink_status(missing_path, error))) {
    found = "the link " + quoted(missing_path) + " is broken";
  }
  std::vector<std::string> names = namesIn(parent.empty() ? "." : parent);
  std::erase(names, missing.string());  // a dangling link
  std::string next_step = "check the path";
  if (fs::path(path).is_relative()) next_step += "; it is relative to " + quoted(fs::current_path(error));
  if (const std::optional<std::string> nearest = nearestName(missing.string(), names)) {
    fs::path suggestion = parent / *nearest;
    if (!rest.empty()) suggestion /= rest;
    next_step = "did you mean " + quoted(suggestion) + "?";
  }
  return detail::errorAt(path, found, "a file or folder that exists", next_step);
}

}  // namespace alidade
