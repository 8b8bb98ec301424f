// SPDX-License-Identifier: MIT
#pragma once

#include <optional>
#include <string_view>

namespace alidade {

/// Whether a calibration may be used.
enum class Verdict {
  kTrustworthy,   ///< no problem was found
  kReservations,  ///< usable if the reported problems do not matter to the user
  kNo,            ///< must not be used
};

/// Stable name for files and JSON.
[[nodiscard]] constexpr std::string_view verdictName(Verdict verdict) {
  if (verdict == Verdict::kTrustworthy) return "trustworthy";
  return verdict == Verdict::kReservations ? "usable_with_reservations" : "rejected";
}

/// The verdict with this name; std::nullopt if the name is unknown.
[[nodiscard]] constexpr std::optional<Verdict> verdictOf(std::string_view name) {
  for (const Verdict verdict : {Verdict::kTrustworthy, Verdict::kReservations, Verdict::kNo}) {
    if (verdictName(verdict) == name) return verdict;
  }
  return std::nullopt;
}

}  // namespace alidade
