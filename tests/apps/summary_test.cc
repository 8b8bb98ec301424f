// SPDX-License-Identifier: MIT
#include <algorithm>
#include <filesystem>
#include <sstream>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "apps/command_line.h"

namespace alidade {
namespace {

using testing::HasSubstr;
using testing::StartsWith;

std::vector<std::string> linesOf(const std::string& text) {
  std::istringstream stream(text);
  std::vector<std::string> lines;
  for (std::string line; std::getline(stream, line);) lines.push_back(line);
  return lines;
}

TEST(Summary, HasSixteenLinesOfAHundredColumnsAtMost) {
  int num_checked = 0;
  int num_reasons = 0;
  for (const char* model : {"auto", "radtan", "thin_prism", "pinhole", "kannala_brandt"}) {
    for (const char* tolerance : {"1px", "0.001px"}) {
      const RunResult result = runAlidade({"calibrate", dataPath("corners.csv"), "--model", model,
                                           "--tolerance", tolerance, "--target-sigma", "1px"});
      const std::vector<std::string> lines = linesOf(result.out);
      ASSERT_GE(lines.size(), 8u) << result.err;
      EXPECT_LE(lines.size(), 16u) << result.out;
      for (const std::string& line : lines) EXPECT_LE(line.size(), 100u) << line;
      EXPECT_THAT(lines[0], StartsWith("Verdict   "));
      EXPECT_THAT(lines[1], StartsWith("Accuracy  "));
      // The reason for anything but trust.
      const auto hasLine = [&](const char* label) {
        return std::ranges::any_of(lines, [&](const std::string& line) { return line.starts_with(label); });
      };
      if (lines[0].find("trustworthy") == std::string::npos) {
        EXPECT_TRUE(hasLine("Warning   ") || hasLine("FAILED    ")) << result.out;
        ++num_reasons;
      }
      ++num_checked;
    }
  }
  EXPECT_EQ(num_checked, 10);
  EXPECT_GE(num_reasons, 5);
}

// The same number in the summary and in JSON.
TEST(Summary, StatesTheAccuracyOfTheDocument) {
  const std::vector<std::string> args = {"calibrate", dataPath("images"), "--board", kBoardSpec};
  const RunResult text = runAlidade(args);
  std::vector<std::string> json_args = args;
  json_args.emplace_back("--json");
  const auto accuracy = nlohmann::json::parse(runAlidade(json_args).out).at("accuracy");
  const std::string covered =
      fmt::format("within {:.3f} px (95 %) where boards were seen ({:.0f} % of the image)",
                  accuracy.at("covered_px").get<double>(), 100 * accuracy.at("covered_share").get<double>());
  EXPECT_THAT(text.out, HasSubstr(covered));
  EXPECT_EQ(accuracy.at("error_px").size(),
            accuracy.at("columns").get<std::size_t>() * accuracy.at("rows").get<std::size_t>());
}

// What a user accepts decides what is worth a warning.
TEST(Summary, JudgesByTheTolerance) {
  const std::vector<std::string> args = {"calibrate", dataPath("images"), "--board", kBoardSpec,
                                         "--tolerance"};
  const auto verdictFor = [&](const char* tolerance) {
    std::vector<std::string> all = args;
    all.emplace_back(tolerance);
    return linesOf(runAlidade(all).out).at(0);
  };
  EXPECT_THAT(verdictFor("1px"), HasSubstr("trustworthy"));
  EXPECT_THAT(verdictFor("0.02px"), HasSubstr("usable with reservations"));
  EXPECT_THAT(verdictFor("0.0005px"), HasSubstr("rejected"));
  EXPECT_THAT(runAlidade({"calibrate", dataPath("images"), "--board", kBoardSpec, "--tolerance", "-1"}),
              FailsWith(2, HasSubstr("--tolerance")));
}

// Only for people: what goes to a file or another program is text alone.
TEST(Summary, DrawsTheCoverageOnATerminal) {
  const std::string terminal = "/usr/bin/script";
  if (!std::filesystem::exists(terminal)) GTEST_SKIP() << "no program that provides a terminal";
  const std::string command = fmt::format("{} calibrate {}", alidadeProgram(), dataPath("corners.csv"));
  const RunResult shown = runProgram(terminal, {"-qec", command, "/dev/null"});
  EXPECT_THAT(shown, EndsWith(0));
  EXPECT_THAT(shown.out, testing::AllOf(HasSubstr("Seen      "), HasSubstr("██"), HasSubstr("··")));
  EXPECT_THAT(runAlidade({"calibrate", dataPath("corners.csv")}).out, testing::Not(HasSubstr("Seen")));
}

}  // namespace
}  // namespace alidade
