// SPDX-License-Identifier: MIT
#include "alidade/validate/held_out/held_scores.h"

#include <functional>
#include <map>
#include <string>

#include <gmock/gmock.h>

#include "alidade/validate/held_out/held_out_images.h"
#include "support/image_sizes.h"
#include "support/lens_draw.h"
#include "support/user_views.h"

namespace alidade {
namespace {

constexpr double kSlipNoisePx = 0.1;
constexpr int kViews = 30;
constexpr std::uint64_t kSeeds = 3;

using Params = std::vector<double>;

DrawnCamera narrowCamera() {
  return {AnyCamera::make("radtan", Params{535, 529, 322.5, 238.1, -0.28, 0.08, 2e-3, -9e-4, -0.01}), kVga,
          0.75};
}

DrawnCamera fisheyeCamera() {
  return {AnyCamera::make("kannala_brandt", Params{285, 281, 322.5, 238.1, 0.06, -0.02, 0.006, -0.001}), kVga,
          1.1};
}

// By the id of the slip that the file has after it: what was done to the right numbers.
std::map<std::string, std::function<void(Params&)>> slipsOf(std::string_view model) {
  std::map<std::string, std::function<void(Params&)>> slips = {
      {"k1_sign", [](Params& p) { p[4] *= -1; }},
      {"center_swapped", [](Params& p) { std::swap(p[2], p[3]); }},
      {"focal_swapped", [](Params& p) { std::swap(p[0], p[1]); }},
      {"fx", [](Params& p) { p[0] *= 1.1; }},
      {"fy", [](Params& p) { p[1] *= 0.97; }},
      {"scaled",
       [](Params& p) {
         for (std::size_t i = 0; i < 4; ++i) p[i] = i < 2 ? 2 * p[i] : 2 * (p[i] + 0.5) - 0.5;
       }},
      {"cropped", [](Params& p) {
         p[2] += 80;
         p[3] += 60;
       }}};
  if (model == "kannala_brandt") {
    slips["radial_sign"] = [](Params& p) {
      for (std::size_t i = 4; i < 8; ++i) p[i] *= -1;
    };
    return slips;
  }
  slips["radial_sign"] = [](Params& p) {
    for (const std::size_t i : {4, 5, 8}) p[i] *= -1;
  };
  slips["tangential_swapped"] = [](Params& p) { std::swap(p[6], p[7]); };
  slips["tangential_sign"] = [](Params& p) { p[6] *= -1, p[7] *= -1; };
  slips["p1_sign"] = [](Params& p) { p[6] *= -1; };
  slips["p2_sign"] = [](Params& p) { p[7] *= -1; };
  slips["tangential_order"] = [](Params& p) { std::tie(p[6], p[7], p[8]) = std::tuple(p[8], p[6], p[7]); };
  return slips;
}

UserSet slipViews(const DrawnCamera& drawn, int count, std::uint64_t seed) {
  Random random(seed);
  return drawUserViews(drawn, count, kSlipNoisePx, random);
}

TEST(Slips, AreNamedWithTheMendedNumbers) {
  constexpr double kEstimatedPx = 1;  // of numbers that come from the images
  int num_named = 0;
  for (const DrawnCamera& drawn : {narrowCamera(), fisheyeCamera()}) {
    const auto right = drawn.camera.parameters();
    for (const auto& [id, slip] : slipsOf(drawn.camera.modelId())) {
      Params wrong(right.begin(), right.end());
      slip(wrong);
      const AnyCamera tested = AnyCamera::make(drawn.camera.modelId(), wrong);
      for (std::uint64_t seed = 0; seed < kSeeds; ++seed) {
        const UserSet set = slipViews(drawn, kViews, seed);
        const HeldOutJudgement judgement = judgeOnImages({&tested, kVga}, set.board, set.views);
        const Slip* const named = namedSlip(judgement, kDefaultTolerancePx);
        ASSERT_NE(named, nullptr) << id << " " << seed;
        EXPECT_EQ(named->id, id);
        for (std::size_t i = 0; i < right.size(); ++i)
          EXPECT_NEAR(named->mended.parameters()[i], right[i], named->num_free > 0 ? kEstimatedPx : 1e-12)
              << id;
        EXPECT_THAT(heldOutChecks(judgement, kDefaultTolerancePx)[1].cause, testing::HasSubstr(named->text));
        ++num_named;
      }
    }
  }
  EXPECT_EQ(num_named, 21 * kSeeds);
}

// Half a pixel is nearly a turn of the camera, and takes more views.
TEST(Slips, ThatMoveTheOriginTakeMoreViews) {
  constexpr int kManyViews = 90;
  int num_named = 0;
  for (const DrawnCamera& drawn : {narrowCamera(), fisheyeCamera()}) {
    for (std::uint64_t seed = 0; seed < 6; ++seed) {
      const UserSet set = slipViews(drawn, kManyViews, seed);
      const AnyCamera tested =
          *changed(drawn.camera, CameraChangeKind::kPixelOrigin, seed % 2 == 0 ? 0.5 : -0.5);
      const HeldOutJudgement judgement = judgeOnImages({&tested, kVga}, set.board, set.views);
      const Slip* const named = namedSlip(judgement, kDefaultTolerancePx);
      if (named == nullptr) continue;
      EXPECT_EQ(named->id, "pixel_origin");
      EXPECT_NEAR(named->mended.parameters()[2], drawn.camera.parameters()[2], 1e-12);
      ++num_named;
    }
  }
  EXPECT_GE(num_named, 9);  // of 12
}

TEST(Slips, AreNotNamedInASoundFile) {
  int num_sets = 0;
  for (const DrawnCamera& drawn : {narrowCamera(), fisheyeCamera()}) {
    for (std::uint64_t seed = 0; seed < 10; ++seed) {
      const UserSet set = slipViews(drawn, seed % 2 == 0 ? 12 : kViews, seed);
      const HeldOutJudgement judgement = judgeOnImages({&drawn.camera, kVga}, set.board, set.views);
      EXPECT_EQ(namedSlip(judgement, kDefaultTolerancePx), nullptr) << seed;
      EXPECT_GE(judgement.slips.size(), 8u);
      ++num_sets;
    }
  }
  EXPECT_EQ(num_sets, 20);
}

}  // namespace
}  // namespace alidade
