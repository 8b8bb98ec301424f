// SPDX-License-Identifier: MIT
#pragma once

#include <map>
#include <optional>
#include <string>
#include <vector>

#include <benchmark/benchmark.h>

namespace alidade {

/// Prints the usual table and stores the median CPU time of each case, so that the program can print the
/// ratios between cases that matter.
class MedianReporter final : public benchmark::ConsoleReporter {
 public:
  void ReportRuns(const std::vector<Run>& runs) override;

  /// Median CPU seconds of one iteration of the case called `name` ("calibrate/alidade/100"); nothing if it
  /// did not run.
  [[nodiscard]] std::optional<double> medianSeconds(const std::string& name) const;

  /// Time of `slow` over time of `fast`; nothing unless both ran.
  [[nodiscard]] std::optional<double> ratio(const std::string& slow, const std::string& fast) const;

 private:
  std::map<std::string, double> median_seconds_;
};

}  // namespace alidade
