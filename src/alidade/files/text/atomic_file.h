// SPDX-License-Identifier: MIT
#pragma once

#include <cstddef>
#include <string>
#include <string_view>

#include "alidade/core/error.h"

namespace alidade {

/// Whether a file that was just written survives a loss of power.
enum class Durability {
  kSafe,   ///< flushed to the disk
  kQuick,  ///< for files whose damage is noticed and does no harm
};

/// Writes `content` (text or bytes) to `path` so that a reader sees the old file or the whole new one, never
/// a part: it goes to a temporary file in the same folder, is flushed to the disk and renamed. A replaced
/// file keeps its permissions, and one without write permission is not replaced; symbolic links are followed.
/// Where there is nothing to replace (/dev/stdout, a device, a pipe) `content` is written straight to it.
/// @throws Error (kInput) when anything fails; the old file is then untouched and no temporary file is left.
void writeFileAtomically(const std::string& path, std::string_view content,
                         Durability durability = Durability::kSafe);

/// Complains now about a path to which writeFileAtomically cannot write, as far as that can be known without
/// writing: for before long work. @throws Error (kInput)
void checkWritable(const std::string& path);

/// The file that writing to a path creates or replaces, with all links followed, whether it exists or not.
[[nodiscard]] std::string writtenPath(const std::string& path);

/// Reads the whole of a file, device or pipe as bytes.
/// @throws Error (kInput) when it is missing (naming the nearest name that exists), a folder, unreadable, or
/// larger than `max_bytes`.
[[nodiscard]] std::string readBinaryFile(const std::string& path, std::size_t max_bytes);

/// As readBinaryFile, for UTF-8 text: a byte order mark is taken off.
/// @throws Error (kInput) also when the file holds zero bytes ('\0'), as binary files and UTF-16 text do.
[[nodiscard]] std::string readTextFile(const std::string& path, std::size_t max_bytes);

/// The complaint about a path that does not exist: which part of it is missing, and what its folder holds
/// under a similar name.
[[nodiscard]] Error missingPathError(const std::string& path);

}  // namespace alidade
