// SPDX-License-Identifier: MIT
#include "judgement_output.h"

#include <algorithm>

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <nlohmann/json.hpp>

#include "alidade/core/text.h"

namespace alidade {
namespace {

std::string checkText(const Diagnosis& check) {
  // A message of several lines stays in its column.
  return fmt::format(
      "  {}  {:<18} {}\n        {:<18} found {}; accepted {}\n", checkStatusName(check.severity), check.id,
      fmt::join(split(check.cause, '\n'), fmt::format("\n{:27}", "")), "", check.evidence, check.limit);
}

std::string verdictText(const FileJudgement& judgement) {
  const std::size_t num_failed = judgement.count(Severity::kFailure);
  if (num_failed > 0) {
    return fmt::format("  NOT valid: {} of {} checks failed\n", num_failed, judgement.checks.size());
  }
  const std::size_t num_warned = judgement.count(Severity::kWarning);
  return num_warned == 0 ? "  valid\n"
                         : fmt::format("  valid\n  {} of {} checks have a warning (--strict fails them)\n",
                                       num_warned, judgement.checks.size());
}

}  // namespace

std::string judgementText(const FileJudgement& judgement) {
  std::string text = judgement.file + "\n";
  for (const Diagnosis& check : judgement.checks) text += checkText(check);
  text += verdictText(judgement);
  if (judgement.isValid() && !judgement.can_show_slips) {
    text +=
        "  nothing in this file can show a wrong number; --images, or --against another calibration, can\n";
  }
  return text;
}

std::string judgementTable(std::span<const FileJudgement> judgements) {
  std::size_t width = 4;
  for (const FileJudgement& j : judgements) width = std::max(width, j.file.size());
  std::string text =
      fmt::format("{:<7}  {:<{}}  {:<10}  {:<14}  {}\n", "", "file", width, "format", "model", "image");
  std::size_t num_valid = 0;
  for (const FileJudgement& j : judgements) {
    num_valid += j.isValid() ? 1 : 0;
    text += fmt::format("{:<7}  {:<{}}  {:<10}  {:<14}  {}\n", j.isValid() ? "valid" : "INVALID", j.file,
                        width, j.format.empty() ? "-" : j.format, j.model.empty() ? "-" : j.model,
                        j.size.empty() ? "-" : j.size);
    for (const Diagnosis& check : j.checks) {
      if (check.severity != Severity::kPass) text += checkText(check);
    }
  }
  return text + fmt::format("{} of {} valid\n", num_valid, judgements.size());
}

nlohmann::json judgementJson(const FileJudgement& judgement) {
  nlohmann::json list = nlohmann::json::array();
  for (const Diagnosis& check : judgement.checks) {
    list.push_back({{"id", check.id},
                    {"status", checkStatusName(check.severity)},
                    {"value", check.evidence},
                    {"limit", check.limit},
                    {"message", check.cause}});
  }
  return {{"file", judgement.file},  {"format", judgement.format},   {"model", judgement.model},
          {"image", judgement.size}, {"valid", judgement.isValid()}, {"checks", std::move(list)}};
}

}  // namespace alidade
