// SPDX-License-Identifier: MIT
#include <gmock/gmock.h>
#include <cmath>
#include <nlohmann/json.hpp>

#include "alidade/files/camera_source.h"
#include "alidade/files/formats/alidade_writer.h"
#include "command_line.h"
#include "run_program.h"
#include "support/scratch_folder.h"

namespace alidade {
namespace {

using testing::AllOf;
using testing::ContainsRegex;
using testing::HasSubstr;
using testing::Not;

TEST(ModelChoice, IsPrintedWrittenAndRead) {
  const ScratchFolder scratch;
  const std::string output = scratch.path("camera.yaml");
  const RunResult text = runAlidade({"calibrate", dataPath("corners.csv"), "-o", output, "--verbose"});
  ASSERT_THAT(text, EndsWith(0));
  EXPECT_THAT(text.out, AllOf(HasSubstr("cross-validation "), HasSubstr("for a field of view of 6"),
                              ContainsRegex("radtan +9 .*chosen"),
                              ContainsRegex("pinhole +4 .*fits corners worse than radtan"),
                              ContainsRegex("rational +12 .*fits no better than radtan")));
  const CameraRecord file = loadCamera(output);
  ASSERT_TRUE(file.calibration);
  EXPECT_GE(file.calibration->holdout_rms_px, 0);
  EXPECT_EQ(cameraFileText(file), scratch.read("camera.yaml"));
  const auto json = nlohmann::json::parse(runAlidade({"calibrate", dataPath("corners.csv"), "--json"}).out);
  EXPECT_EQ(json.at("holdout_rms_px").get<double>(), file.calibration->holdout_rms_px);
  EXPECT_EQ(json.at("holdout").at("num_folds"), 5);
  EXPECT_EQ(json.at("model_choice").at("best"), "radtan");
  const nlohmann::json& candidates = json.at("model_choice").at("candidates");
  ASSERT_EQ(candidates.size(), 5u);
  EXPECT_EQ(candidates[1].at("model"), "radtan");
  EXPECT_EQ(candidates[1].at("verdict"), "chosen");
  EXPECT_EQ(candidates[0].at("verdict"), "worse");
  EXPECT_TRUE(candidates[0].at("excess").is_null());
  EXPECT_TRUE(json.at("image_bias").contains("z"));
}

TEST(ModelChoice, IsLeftOutWhereAModelIsNamed) {
  const ScratchFolder scratch;
  const std::string output = scratch.path("camera.yaml");
  const RunResult named =
      runAlidade({"calibrate", dataPath("corners.csv"), "--model", "radtan", "-o", output, "--verbose"});
  ASSERT_THAT(named, EndsWith(0));
  EXPECT_THAT(named.out, AllOf(HasSubstr("cross-validation "), Not(HasSubstr("chosen"))));
  // The initial camera's model, not another choice.
  const RunResult again = runAlidade({"calibrate", dataPath("corners.csv"), "--init", output, "--json"});
  ASSERT_THAT(again, EndsWith(0));
  EXPECT_TRUE(nlohmann::json::parse(again.out).at("model_choice").is_null());
}

TEST(ModelChoice, HoldsOnlyWhatAllModelsHave) {
  EXPECT_THAT(runAlidade({"calibrate", dataPath("corners.csv"), "--fix", "k3"}),
              FailsWith(2, AllOf(HasSubstr("'k3'"), HasSubstr("fx, fy, cx, cy"), HasSubstr("--model"))));
  EXPECT_THAT(runAlidade({"calibrate", dataPath("corners.csv"), "--fix", "k3", "--model", "radtan"}),
              testing::Not(FailsWith(2, HasSubstr("k3"))));
}

TEST(ModelChoice, IsTheSameWithAnyNumberOfThreads) {
  const auto run = [](const char* jobs) {
    return runAlidade({"calibrate", dataPath("corners.csv"), "--jobs", jobs, "--json"}).out;
  };
  const std::string one = run("1");
  EXPECT_EQ(one, run("4"));
  EXPECT_THAT(one, HasSubstr("model_choice"));
}

}  // namespace
}  // namespace alidade
