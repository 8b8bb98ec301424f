// SPDX-License-Identifier: MIT
#include "alidade/core/distinct_names.h"

#include <gmock/gmock.h>

namespace alidade {
namespace {

using testing::ElementsAre;
using testing::IsEmpty;

std::vector<std::string> namesFor(std::vector<std::string> names, const std::vector<std::string>& paths) {
  return distinctNames(std::move(names), paths);
}

TEST(DistinctNames, AreThoseOfTheNearestFoldersThatDiffer) {
  EXPECT_THAT(namesFor({"left", "right"}, {"x/images", "y/images"}), ElementsAre("left", "right"));
  EXPECT_THAT(namesFor({"images", "images"}, {"x/images/", "y/./images"}), ElementsAre("x", "y"));
  EXPECT_THAT(namesFor({"", ""}, {"x/day1/*.png", "y/day1/*.png"}), ElementsAre("x", "y"));
  EXPECT_THAT(namesFor({"a", "a", "a"}, {"x/a", "x/b/a", "y/a"}), ElementsAre("x", "b", "y"));
  EXPECT_THAT(namesFor({"a", "a"}, {"x/a", "x/a"}), IsEmpty());
}

}  // namespace
}  // namespace alidade
