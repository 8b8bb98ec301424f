// SPDX-License-Identifier: MIT
#include <nlohmann/json.hpp>

#include "apps/command_line.h"

namespace alidade {
namespace {

using nlohmann::json;
using testing::AllOf;
using testing::ElementsAre;
using testing::HasSubstr;
using testing::Not;
using testing::StartsWith;
using testing::UnorderedElementsAre;

std::string cornersPath() {
  return dataPath("corners.csv");
}

json jsonOf(std::vector<std::string> args, const std::string& input = cornersPath()) {
  args.insert(args.begin(), {"calibrate", input, "--json"});
  const RunResult result = runAlidade(args);
  EXPECT_THAT(result, EndsWith(0));
  return json::parse(result.out);
}

TEST(Advice, StandsInTheSummary) {
  EXPECT_THAT(runAlidade({"calibrate", cornersPath()}).out, HasSubstr("\nNext      put the board"));
  const RunResult result = runAlidade({"calibrate", cornersPath(), "--verbose"});
  ASSERT_THAT(result, EndsWith(0));
  EXPECT_THAT(result.out,
              AllOf(HasSubstr("\nCoverage board corners in "), Not(HasSubstr("\nNext      put the board")),
                    HasSubstr("\nNext     the board"), HasSubstr("worst projection uncertainty from "),
                    Not(HasSubstr("\nTarget"))));
}

TEST(Advice, StandsInTheDocument) {
  const ScratchFolder scratch;  // the corners file is exact, and leaves no uncertainty
  const json document =
      jsonOf({"--board", kBoardSpec, "--target-sigma", "0.001px"}, linkImages(scratch, "photos", 6));
  const json& coverage = document["coverage"];
  EXPECT_EQ(coverage["grid"]["columns"], 8);
  EXPECT_EQ(coverage["grid"]["num_corners"].size(), 48u);
  EXPECT_EQ(coverage["views"].size(), 6u);
  std::vector<double> fills;
  for (const json& view : coverage["views"]) fills.push_back(view["fill"]);
  EXPECT_EQ(coverage["smallest_fill"], *std::min_element(fills.begin(), fills.end()));
  EXPECT_EQ(coverage["largest_fill"], *std::max_element(fills.begin(), fills.end()));
  EXPECT_GT(coverage["share"], 0.3);
  const json& next = document["next_view"];
  EXPECT_TRUE(next["determined"]);
  EXPECT_LT(next["worst_then_px"], next["worst_now_px"]);
  EXPECT_GT(next["distance_m"], 0.05);
  EXPECT_EQ(next["camera_from_board"]["quaternion_xyzw"].size(), 4u);
  const json& target = document["target"];
  EXPECT_EQ(target["target_px"], 0.001);
  EXPECT_FALSE(target["reached"]);
  EXPECT_TRUE(target["num_more_views"].is_null());
  EXPECT_LT(target["forecast_px"], next["worst_then_px"]);
  EXPECT_TRUE(jsonOf({})["target"].is_null());
}

TEST(Advice, SaysWhetherTheTargetIsReached) {
  const RunResult result = runAlidade({"calibrate", cornersPath(), "--target-sigma", "50 px"});
  ASSERT_THAT(result, EndsWith(0));
  EXPECT_THAT(result.out, HasSubstr("Target    50 px: reached"));
  EXPECT_EQ(jsonOf({"--target-sigma", "50"})["target"]["num_more_views"], 0);
  const ScratchFolder scratch;
  const std::string settings = scratch.write("settings.yaml", "target-sigma: 50px\n");
  EXPECT_EQ(jsonOf({"--config", settings})["target"]["reached"], true);
}

TEST(Advice, RefusesTargetsThatAreNoPixels) {
  int num_refused = 0;
  for (const char* value : {"", "0", "-0.1px", "0.1mm", "nan", "inf", "px", "0.1pxx", "1e400"}) {
    EXPECT_THAT(runAlidade({"calibrate", cornersPath(), "--target-sigma", value}),
                FailsWith(2, AllOf(HasSubstr("--target-sigma"), HasSubstr("0.1px"))))
        << value;
    ++num_refused;
  }
  EXPECT_EQ(num_refused, 9);
}

TEST(Advice, DrawsTheNextView) {
  const ScratchFolder scratch;
  const std::string drawing = scratch.path("next.svg");
  ASSERT_THAT(runAlidade({"calibrate", cornersPath(), "--next-view", drawing}), EndsWith(0));
  EXPECT_THAT(scratch.read("next.svg"), AllOf(StartsWith("<svg "), HasSubstr("Next: the board")));
  EXPECT_THAT(scratch.list(), ElementsAre("next.svg"));
}

TEST(Advice, LeavesTheCameraFileAsItIs) {
  const ScratchFolder scratch;
  const RunResult plain = runAlidade({"calibrate", cornersPath(), "-o", "-"});
  const RunResult advised = runAlidade({"calibrate", cornersPath(), "-o", "-", "--next-view",
                                        scratch.path("next.svg"), "--target-sigma", "0.1px"});
  EXPECT_EQ(plain.out, advised.out);
  EXPECT_THAT(plain.out, HasSubstr("alidade_camera: 1"));
}

TEST(Advice, RefusesToDrawOverOtherFiles) {
  const ScratchFolder scratch;
  const std::string corners = scratch.write("corners.csv", readFile(cornersPath()));
  const std::string camera = scratch.path("camera.yaml");
  EXPECT_THAT(runAlidade({"calibrate", corners, "--next-view", corners}),
              FailsWith(2, AllOf(HasSubstr("--next-view"), HasSubstr("this is also an input"))));
  EXPECT_THAT(runAlidade({"calibrate", corners, "-o", camera, "--next-view", camera}),
              FailsWith(2, HasSubstr("the same file as --output")));
  EXPECT_THAT(runAlidade({"calibrate", corners, "--next-view", "-"}),
              FailsWith(2, HasSubstr("standard output")));
  EXPECT_THAT(runAlidade({"calibrate", corners, "--next-view", scratch.path("nowhere/next.svg")}),
              FailsWith(1, HasSubstr("nowhere")));
  EXPECT_EQ(scratch.read("corners.csv"), readFile(cornersPath()));
  EXPECT_THAT(scratch.list(), UnorderedElementsAre("corners.csv"));
}

}  // namespace
}  // namespace alidade
