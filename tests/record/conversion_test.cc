// SPDX-License-Identifier: MIT
#include "alidade/record/conversion.h"

#include <vector>

#include <gmock/gmock.h>

#include "alidade/core/error.h"
#include "support/image_sizes.h"

namespace alidade {
namespace {

using testing::ElementsAre;

CameraRecord radtanRecord() {
  return bareRecord(AnyCamera::make("radtan", std::vector<double>{500, 501, 320, 240, -0.25, 0.06, 0, 0, 0}),
                    kVga, "test");
}

TEST(ConvertCamera, DoesAllStepsInTheirOrder) {
  const Conversion conversion = convertCamera(radtanRecord(), {.crop = PixelRect{0, 60, 640, 360},
                                                               .bin = 2,
                                                               .resize = ImageSize{160, 90},
                                                               .rotate_deg = 90,
                                                               .model = {}});
  std::vector<std::string> steps;
  for (const Conversion::Step& step : conversion.steps) steps.push_back(step.name + " " + step.value);
  EXPECT_THAT(steps, ElementsAre("crop 0,60,640,360", "bin 2", "resize 160x90", "rotate 90"));
  EXPECT_EQ(conversion.edit.size, (ImageSize{.width = 90, .height = 160}));
  EXPECT_TRUE(conversion.problems.empty());
  const CameraRecord record = convertedRecord(radtanRecord(), conversion, "what made it");
  EXPECT_EQ(record.image_size, conversion.edit.size);
  EXPECT_EQ(record.created_by, "what made it");
  EXPECT_FALSE(record.self_check.empty());
  EXPECT_FALSE(record.calibration.has_value()) << "the source has none";
}

TEST(ConvertCamera, SaysWhyItsResultIsNotToBeTrusted) {
  CameraRecord source = radtanRecord();
  source.calibration.emplace();
  source.calibration->verdict = Verdict::kNo;
  const Conversion conversion = convertCamera(
      source,
      {.crop = {}, .bin = {}, .resize = {}, .rotate_deg = {}, .model = "pinhole", .max_error_px = 0.1});
  EXPECT_THAT(conversion.problems, ElementsAre(ConversionProblem::kSourceUntrustworthy,
                                               ConversionProblem::kModelRms, ConversionProblem::kModelError));
  const CameraRecord record = convertedRecord(source, conversion, "test");
  ASSERT_TRUE(record.calibration.has_value());
  EXPECT_EQ(record.calibration->verdict, Verdict::kNo);
  EXPECT_THAT(record.calibration->findings, ElementsAre("source_untrustworthy", "model_rms", "model_error"));
}

TEST(ConvertCamera, RefusesAPartOutsideOfTheImage) {
  EXPECT_THROW(
      (void)convertCamera(
          radtanRecord(),
          {.crop = PixelRect{600, 0, 100, 100}, .bin = {}, .resize = {}, .rotate_deg = {}, .model = {}}),
      Error);
}

}  // namespace
}  // namespace alidade
