// SPDX-License-Identifier: MIT
#pragma once

#include <mutex>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace alidade {

/// A folder of texts, each under the digest of all that it was computed from. Entries never change and are
/// written completely or not at all, so several programs may use one folder at the same time, and one that is
/// killed leaves a valid cache. An entry with wrong bytes counts as missing. All functions may be called from
/// several threads.
class ContentCache {
 public:
  /// Makes the folder if it does not exist. It holds CACHEDIR.TAG, which tells backup programs to pass it by.
  /// @throws Error (kInput) if it cannot be made; (kUsage) for a folder that holds other files
  explicit ContentCache(std::string folder);

  /// The text that was kept for a key, or nothing.
  [[nodiscard]] std::optional<std::string> find(std::string_view key) const;

  /// Counts the entry of a key as damaged: its text, though whole, is not what the caller kept.
  void reject(std::string_view key) const;

  /// Keeps a text for a key. A failure (a full disk) is no reason to end: complaints() tells it.
  void keep(std::string_view key, std::string_view text) const;

  /// What was wrong with entries, one sentence for each kind of trouble.
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
