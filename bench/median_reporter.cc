// SPDX-License-Identifier: MIT
#include "median_reporter.h"

namespace alidade {

void MedianReporter::ReportRuns(const std::vector<Run>& runs) {
  ConsoleReporter::ReportRuns(runs);
  for (const Run& run : runs) {
    const bool is_single = run.run_type == Run::RT_Iteration && run.repetitions == 1;
    if (run.error_occurred || (run.aggregate_name != "median" && !is_single)) continue;
    const std::string& args = run.run_name.args;
    const std::string name = run.run_name.function_name + (args.empty() ? "" : "/" + args);
    median_seconds_[name] = run.GetAdjustedCPUTime() / benchmark::GetTimeUnitMultiplier(run.time_unit);
  }
}

std::optional<double> MedianReporter::medianSeconds(const std::string& name) const {
  const auto found = median_seconds_.find(name);
  if (found == median_seconds_.end()) return std::nullopt;
  return found->second;
}

std::optional<double> MedianReporter::ratio(const std::string& slow, const std::string& fast) const {
  const auto slow_seconds = medianSeconds(slow);
  const auto fast_seconds = medianSeconds(fast);
  if (!slow_seconds || !fast_seconds) return std::nullopt;
  return *slow_seconds / *fast_seconds;
}

}  // namespace alidade
