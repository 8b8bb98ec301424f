// SPDX-License-Identifier: MIT
#include "alidade/rig/rig_frames.h"

#include <gmock/gmock.h>

#include "support/message_of.h"

namespace alidade {
namespace {

using testing::AllOf;
using testing::ElementsAre;
using testing::HasSubstr;

RigViews camera(const std::string& name, const std::vector<std::string>& images) {
  RigViews views{.name = name, .views = {}};
  for (const std::string& image : images) views.views.push_back({.image = image});
  return views;
}

TEST(RigFrames, MatchesEqualNames) {
  const std::vector<RigViews> cameras = {camera("a", {"2.png", "10.png", "7_x1.png"}),
                                         camera("b", {"sub/10.jpg", "7_x1.jpg", "3.jpg"})};
  const RigFrames frames = matchFrames(cameras);
  EXPECT_THAT(frames.names, ElementsAre("2", "3", "7_x1", "10"));
  EXPECT_THAT(frames.frame_of, ElementsAre(ElementsAre(0, 3, 2), ElementsAre(3, 2, 1)));
}

TEST(RigFrames, MatchesTheLastNumbers) {
  const std::vector<RigViews> cameras = {camera("a", {"left01.jpg", "left12.jpg"}),
                                         camera("b", {"cam2_right0012.png", "cam2_right3.png"})};
  const RigFrames frames = matchFrames(cameras);
  EXPECT_THAT(frames.names, ElementsAre("1", "3", "12"));
  EXPECT_THAT(frames.frame_of, ElementsAre(ElementsAre(0, 2), ElementsAre(2, 1)));
}

TEST(RigFrames, TakesViewsOfSeveralBoardsInOneImage) {
  std::vector<RigViews> cameras = {camera("a", {"1.png", "1.png"}), camera("b", {"1.png"})};
  cameras[0].views[1].board = 1;
  EXPECT_THAT(matchFrames(cameras).frame_of, ElementsAre(ElementsAre(0, 0), ElementsAre(0)));
}

TEST(RigFrames, RefusesNamesThatDoNotMatch) {
  EXPECT_THAT(messageOf([] {
                (void)matchFrames(std::vector{camera("a", {"x.png"}), camera("b", {"y.png"})});
              }),
              AllOf(HasSubstr("a: x.png"), HasSubstr("no number in the name")));
  EXPECT_THAT(messageOf([] {
                (void)matchFrames(std::vector{camera("a", {"x1.png", "y1.png"}), camera("b", {"z1.png"})});
              }),
              AllOf(HasSubstr("a: y1.png"), HasSubstr("the same number as x1.png")));
}

}  // namespace
}  // namespace alidade
