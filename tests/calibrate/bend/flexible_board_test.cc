// SPDX-License-Identifier: MIT
#include "alidade/calibrate/bend/flex_fit.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cstdint>
#include <string_view>
#include <vector>

#include "support/answer.h"
#include "support/flawed_set.h"

namespace alidade {
namespace {

struct Counts {
  int num_sets = 0;
  int num_named = 0;
  int num_blamed = 0;  // another cause was named
  int num_usable = 0;
  int num_within = 0;  // 95 % of the covered pixels have less than the stated error
  double worst_px = 0;
};

Counts countOver(std::string_view name, std::uint64_t num_sets) {
  Counts counts;
  for (const FlawKind& kind : flawKinds()) {
    if (kind.name != name) continue;
    for (const char* model : {"radtan", "kannala_brandt"}) {
      for (std::uint64_t number = 0; number < num_sets; ++number) {
        const FlawedSet flawed = drawFlawedSet(kind, model, streamSeed(88, number));
        const Answer answer = answerOf(flawed.set.board, flawed.set.views, {}, flawed.drawn.camera);
        ++counts.num_sets;
        const bool is_named = answer.isNamed("board_flexes");
        counts.num_named += is_named ? 1 : 0;
        counts.num_blamed += answer.isNamed("focal_changed") || answer.isNamed("two_cameras") ||
                                     answer.isNamed("rolling_shutter")
                                 ? 1
                                 : 0;
        if (!is_named) continue;
        counts.num_usable += answer.verdict != Verdict::kNo ? 1 : 0;
        counts.num_within +=
            static_cast<double>(answer.num_within) >= 0.95 * static_cast<double>(answer.num_covered) ? 1 : 0;
        counts.worst_px = std::max(counts.worst_px, answer.p95_px);
      }
    }
  }
  return counts;
}

// bench/answer_bench has the same in hundreds. Weak bends are part of the noise, and not named.
TEST(FlexibleBoard, IsNamedAndCameraSurvives) {
  for (const char* name : {"flexing", "flexed_midway"}) {
    const Counts counts = countOver(name, 8);
    EXPECT_EQ(counts.num_sets, 16);
    EXPECT_GE(counts.num_named, 6) << name;
    EXPECT_LE(counts.num_blamed, 1) << name;
    EXPECT_GE(3 * counts.num_usable, 2 * counts.num_named) << name;  // others: strongly bent as well
    EXPECT_GE(counts.num_within, counts.num_named - 1) << name;
    EXPECT_LE(counts.worst_px, 1) << name;
  }
}

TEST(FlexibleBoard, IsNotBlamedForOtherFlaws) {
  int num_sets = 0;
  for (const char* name : {"none", "cylinder", "wave", "misprint", "two_cameras", "zoom_midway", "breathing",
                           "entrance_pupil", "rolling_shutter", "shaken", "few_views", "stabilised"}) {
    const Counts counts = countOver(name, 2);
    EXPECT_EQ(counts.num_named, 0) << name;
    num_sets += counts.num_sets;
  }
  EXPECT_EQ(num_sets, 48);
}

}  // namespace
}  // namespace alidade
