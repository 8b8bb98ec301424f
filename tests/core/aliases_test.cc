// SPDX-License-Identifier: MIT
#include "alidade/core/aliases.h"

#include <vector>

#include <gmock/gmock.h>

namespace alidade {
namespace {

const std::vector<AliasedName> kNames = {
    {"radtan", "plumb_bob opencv5"}, {"kannala_brandt", "fisheye pinhole-equi"}, {"-"}};

TEST(Aliases, AreReadInAnyCaseWithAndWithoutSigns) {
  int num_read = 0;
  for (const char* word : {"radtan", "RADTAN", "plumb_bob", "plumb-bob", "PlumbBob", "OPENCV5"}) {
    EXPECT_EQ(meantName(word, kNames), "radtan") << word;
    ++num_read;
  }
  for (const char* word : {"kannala-brandt", "Fisheye", "pinhole_equi"}) {
    EXPECT_EQ(meantName(word, kNames), "kannala_brandt") << word;
    ++num_read;
  }
  EXPECT_EQ(meantName("-", kNames), "-");
  EXPECT_EQ(num_read, 9);
}

TEST(Aliases, StandForNothingElse) {
  int num_refused = 0;
  for (const char* word : {"", "rad", "fish eye", "plumb_bobs", "_", "plumb_bob opencv5"}) {
    EXPECT_EQ(meantName(word, kNames), std::nullopt) << word;
    ++num_refused;
  }
  EXPECT_EQ(num_refused, 6);
}

TEST(Aliases, LeadFromAMisspeltWordToTheName) {
  EXPECT_EQ(didYouMeanOne("radtn", kNames), "did you mean 'radtan'?");
  EXPECT_EQ(didYouMeanOne("plum_bob", kNames), "did you mean 'radtan'?");
  EXPECT_EQ(didYouMeanOne("FISHEY", kNames), "did you mean 'kannala_brandt'?");
  EXPECT_EQ(didYouMeanOne("spline", kNames), "");
  EXPECT_EQ(didYouMeanOne("spline", kNames, "for example radtan"), "for example radtan");
}

}  // namespace
}  // namespace alidade
