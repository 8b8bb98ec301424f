// SPDX-License-Identifier: MIT
#pragma once

#include <cstddef>
#include <string>
#include <string_view>

#include "alidade/core/error.h"

namespace alidade {

/// Guarantee that a new file survives a loss of power.
enum class Durability {
  kSafe,   ///< flushed to the disk
  kQuick,  ///< for files whose damage is detected and harmless
};

/// Writes `content` (text or bytes) to `path` so that a reader sees the old file or the whole new one, never
/// a part: it is written to a temporary file in the same folder, is flushed to the disk and renamed. A
/// replaced file keeps its permissions, and one without write permission is not replaced; symbolic links are
/// followed. Where there is nothing to replace (/dev/stdout, a device, a pipe) `content` is written straight
/// to it.
/// @throws Error (kInput) when anything fails; the old file is then untouched and no temporary file is left.
void writeFileAtomically(const std::string& path, std::string_view content,
                         Durability durability = Durability::kSafe);

/// Reports a path to which writeFileAtomically cannot write, as far as this is known without writing; call it
/// before long work. @throws Error (kInput)
void checkWritable(const std::string& path);

/// The file that writing to a path creates or replaces, with all links followed, whether it exists or not.
[[nodiscard]] std::string writtenPath(const std::string& path);

/// Reads a whole file, device or pipe as bytes.
/// @throws Error (kInput) when it is missing (naming the nearest name that exists), a folder, unreadable, or
/// larger than `max_bytes`.
[[nodiscard]] std::string readBinaryFile(const std::string& path, std::size_t max_bytes);

/// As readBinaryFile, for UTF-8 text: a byte order mark is removed.
/// @throws Error (kInput) also when the file holds zero bytes ('\0'), as binary files and UTF-16 text do.
[[nodiscard]] std::string readTextFile(const std::string& path, std::size_t max_bytes);

/// The content of a file as readTextFile() returns it. @throws Error (kInput) as there
[[nodiscard]] std::string textOf(std::string content, const std::string& path);

/// The error for a path that does not exist: the missing part, and similar names in its folder.
[[nodiscard]] Error missingPathError(const std::string& path);

}  // namespace alidade
