// SPDX-License-Identifier: MIT
#pragma once

#include <mutex>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace alidade {

/// A folder of texts, each under the digest of everything that it was computed from. Entries never change and
/// are written completely or not at all, so several programs may share one folder, and a killed program
/// leaves a valid cache. An entry with wrong bytes counts as missing. All functions are thread-safe.
class ContentCache {
 public:
  /// Creates the folder if it does not exist. It holds CACHEDIR.TAG, which tells backup programs to skip it.
  /// @throws Error (kInput) if it cannot be created; (kUsage) for a folder that holds other files
  explicit ContentCache(std::string folder);

  /// The text stored for a key, or nothing.
  [[nodiscard]] std::optional<std::string> find(std::string_view key) const;

  /// Marks the entry of a key as damaged: its text is complete but is not what the caller stored.
  void reject(std::string_view key) const;

  /// Stores a text for a key. A failure (a full disk) does not throw; complaints() reports it.
  void keep(std::string_view key, std::string_view text) const;

  /// Problems with entries, one sentence per kind.
  [[nodiscard]] std::vector<std::string> complaints() const;

 private:
  [[nodiscard]] std::string pathOf(std::string_view key) const;
  void noteDamaged(const std::string& path) const;

  std::string folder_;
  mutable std::mutex mutex_;
  mutable std::size_t num_damaged_ = 0;
  mutable std::string damaged_;  // the first one
  mutable std::string unwritten_;
};

}  // namespace alidade
