// SPDX-License-Identifier: MIT
#include <algorithm>

#include <nlohmann/json.hpp>

#include "apps/command_line.h"

namespace alidade {
namespace {

using testing::AllOf;
using testing::HasSubstr;
using testing::MatchesRegex;
using testing::Not;

TEST(Validate, PassesGoodFiles) {
  const RunResult result = runAlidade({"validate", dataPath("camera.yaml")});
  ASSERT_THAT(result, EndsWith(0));
  EXPECT_THAT(result.out, AllOf(HasSubstr(dataPath("camera.yaml")), HasSubstr("PASS  self_check"),
                                HasSubstr("  valid\n"), Not(HasSubstr("FAIL"))));
}

TEST(Validate, SeesAParameterThatWasEdited) {
  const ScratchFolder scratch;
  const std::string file =
      scratch.write("camera.yaml", replaced(readFile(dataPath("camera.yaml")), "fx: 535,", "fx: 536,"));
  const RunResult result = runAlidade({"validate", file});
  EXPECT_THAT(result, EndsWith(3));
  EXPECT_THAT(result.out, AllOf(HasSubstr("FAIL  self_check"), HasSubstr("NOT valid")));
}

TEST(Validate, SeesALensThatFoldsInItsImage) {
  const ScratchFolder scratch;
  const std::string file =
      scratch.write("camera.yaml",
                    "alidade_camera: 1\nmodel: radtan\nimage_size: {width: 640, height: 480}\n"
                    "parameters: {fx: 300, fy: 300, cx: 320, cy: 240, k1: -0.5, k2: 0, p1: 0, "
                    "p2: 0, k3: 0}\n");
  const RunResult result = runAlidade({"validate", file});
  EXPECT_THAT(result, EndsWith(3));
  EXPECT_THAT(result.out, AllOf(HasSubstr("FAIL  one_to_one"), HasSubstr("folds over inside the image")));
}

TEST(Validate, JudgesEveryFileAndFailsWithTheWorst) {
  const ScratchFolder scratch;
  const std::string bad =
      scratch.write("bad.yaml", replaced(readFile(dataPath("camera.yaml")), "cy: 238.1", "cy: 237.1"));
  const std::string small = scratch.write("small.yaml", smallCamera());
  const RunResult result = runAlidade({"validate", dataPath("camera.yaml"), small, bad, "--json"});
  EXPECT_THAT(result, EndsWith(3));
  const auto files = nlohmann::json::parse(result.out).at("files");
  ASSERT_EQ(files.size(), 3u);
  EXPECT_EQ(files[0].at("valid"), true);
  EXPECT_EQ(files[1].at("valid"), true);
  EXPECT_EQ(files[2].at("valid"), false);
  int num_failed = 0;
  for (const auto& check : files[2].at("checks")) {
    EXPECT_THAT(check.at("status").get<std::string>(), MatchesRegex("PASS|WARN|FAIL"));
    num_failed += check.at("status") == "FAIL" ? 1 : 0;
    for (const char* key : {"id", "value", "limit", "message"}) EXPECT_NE(check.at(key), "") << key;
  }
  EXPECT_GE(num_failed, 1);
}

TEST(Validate, NamesAMissingFile) {
  const ScratchFolder scratch;
  scratch.write("camera.yaml", smallCamera());
  EXPECT_THAT(runAlidade({"validate", scratch.path("camra.yaml")}),
              FailsWith(1, HasSubstr("did you mean '" + scratch.path("camera.yaml") + "'?")));
}

TEST(Validate, ChecksTheOtherFilesWhenOneCannotBeRead) {
  const ScratchFolder scratch;
  const std::string bad =
      scratch.write("bad.yaml", replaced(readFile(dataPath("camera.yaml")), "cy: 238.1", "cy: 237.1"));
  const std::string broken = scratch.write("broken.yaml", "alidade_camera: 1\nmodel: pinhole\n");
  const std::vector<std::string> files = {broken, dataPath("camera.yaml"), scratch.path("none.yaml"), bad};
  std::vector<std::string> args = {"validate"};
  args.insert(args.end(), files.begin(), files.end());

  const RunResult table = runAlidade(args);
  EXPECT_THAT(table, EndsWith(1));  // worse than a check that failed
  EXPECT_THAT(table.out, AllOf(HasSubstr("FAIL  schema"), HasSubstr("no such file"), HasSubstr("  valid\n"),
                               HasSubstr("FAIL  self_check")));
  EXPECT_EQ(table.err, "error: 2 of 4 files cannot be read\n");

  args.emplace_back("--json");
  const RunResult json = runAlidade(args);
  EXPECT_THAT(json, EndsWith(1));
  const auto documents = nlohmann::json::parse(json.out).at("files");
  ASSERT_EQ(documents.size(), files.size());
  for (std::size_t i = 0; i < files.size(); ++i) {
    EXPECT_EQ(documents[i].at("file"), files[i]);
    EXPECT_EQ(documents[i].at("valid"), i == 1) << files[i];
    const auto& schema = documents[i].at("checks").at(0);
    EXPECT_EQ(schema.at("id"), "schema");
    EXPECT_EQ(schema.at("status"), i % 2 == 0 ? "FAIL" : "PASS") << files[i];
  }
  const auto& missing = documents[2].at("checks");
  EXPECT_EQ(missing.size(), 1u);
  EXPECT_THAT(missing[0].at("message").get<std::string>(), HasSubstr("no such file"));
}

TEST(Validate, FailsAFileThatSaysItIsNotToBeTrusted) {
  // No pinhole camera is like this lens, so the converted file is written only on demand, and marked.
  const ScratchFolder scratch;
  const std::string file = scratch.path("pinhole.yaml");
  ASSERT_THAT(runAlidade({"convert", dataPath("camera.yaml"), "--model", "pinhole", "-o", file,
                          "--keep-untrustworthy"}),
              EndsWith(3));
  ASSERT_THAT(scratch.read("pinhole.yaml"), HasSubstr("verdict: no"));
  const RunResult result = runAlidade({"validate", file});
  EXPECT_THAT(result, EndsWith(3));
  EXPECT_THAT(result.out, AllOf(HasSubstr("FAIL  calibration"), HasSubstr("NOT valid")));
}

TEST(Validate, KeepsAbsurdNumbersShort) {
  const ScratchFolder scratch;
  const std::string file =
      scratch.write("camera.yaml", replaced(smallCamera(), "fx: 500", "fx: 1e300") +
                                       "domain: {max_angle_rad: 1e300, full_image: true}\n");
  const RunResult result = runAlidade({"validate", file});
  EXPECT_THAT(result, EndsWith(3));
  constexpr std::size_t kMaxLine = 200;
  std::size_t longest = 0;
  for (std::size_t start = 0; start < result.out.size();) {
    const std::size_t end = result.out.find('\n', start);
    longest = std::max(longest, end - start);
    start = end + 1;
  }
  EXPECT_LE(longest, kMaxLine) << result.out;
}

}  // namespace
}  // namespace alidade
