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

TEST(RigFrames, MatchesTheNumberThatDiffers) {
  const std::vector<RigViews> cameras = {camera("a", {"frame01_cam0.jpg", "frame12_cam0.jpg"}),
                                         camera("b", {"frame12_cam1.jpg", "frame3_cam1.jpg"})};
  const RigFrames frames = matchFrames(cameras);
  EXPECT_THAT(frames.names, ElementsAre("1", "3", "12"));
  EXPECT_THAT(frames.frame_of, ElementsAre(ElementsAre(0, 2), ElementsAre(2, 1)));
}

TEST(RigFrames, MatchesTheNearestTimes) {
  const std::vector<RigViews> cameras = {
      camera("a", {"100.000.png", "100.100.png", "100.200.png", "100.500.png"}),
      camera("b", {"99.998.png", "100.103.png", "100.240.png", "100.499.png"})};
  const RigFrames frames = matchFrames(cameras);
  EXPECT_THAT(frames.names, ElementsAre("99.998", "100.100", "100.200", "100.240", "100.499"));
  EXPECT_THAT(frames.frame_of, ElementsAre(ElementsAre(0, 1, 2, 4), ElementsAre(0, 1, 3, 4)));
  EXPECT_NEAR(frames.time_spread, 0.003, 1e-9);
  // Nanoseconds since 1970.
  const RigFrames ns =
      matchFrames(std::vector{camera("a", {"1403636579763555584.png", "1403636579813555456.png"}),
                              camera("b", {"1403636579763555684.png", "1403636579813555056.png"})});
  EXPECT_THAT(ns.frame_of, ElementsAre(ElementsAre(0, 1), ElementsAre(0, 1)));
  EXPECT_NEAR(ns.time_spread, 400, 1);
}

TEST(RigFrames, NamesImagesWithoutPartner) {
  std::vector<RigViews> cameras = {camera("a", {"1.png", "2.png"}), camera("b", {"2.png"})};
  EXPECT_TRUE(matchFrames(cameras).unmatched.empty());  // the images without a board are not known
  cameras[0].images = {"1.png", "2.png", "3.png"};
  cameras[1].images = {"1.png", "2.png", "4.png"};
  EXPECT_THAT(matchFrames(cameras).unmatched,
              ElementsAre(RigImage{0, "3.png", "3"}, RigImage{1, "4.png", "4"}));
}

TEST(RigFrames, FollowsATable) {
  std::vector<RigViews> cameras = {camera("a", {"x.png", "y.png", "z.png"}),
                                   camera("b", {"in/p.png", "in/q.png"})};
  const FrameTable table{.cameras = {"b", "a"},
                         .rows = {{"q.png", "x.png"}, {"", "y.png"}, {"in/p.png", ""}}};
  const RigFrames frames = framesOf(table, cameras);
  EXPECT_THAT(frames.names, ElementsAre("a/z.png", "row 1", "row 2", "row 3"));
  EXPECT_THAT(frames.frame_of, ElementsAre(ElementsAre(1, 2, 0), ElementsAre(3, 1)));
  // A camera's name may look like that of a row.
  std::vector<RigViews> rows = cameras;
  rows[0].name = "rows";
  EXPECT_EQ(framesOf({.cameras = {"b", "rows"}, .rows = table.rows}, rows).names.size(), 4u);
  const auto complaint = [&](const FrameTable& other) {
    return messageOf([&] { (void)framesOf(other, cameras); });
  };
  EXPECT_THAT(complaint({.cameras = {"a", "c"}, .rows = {{"x.png", ""}}}), HasSubstr("no column 'b'"));
  EXPECT_THAT(complaint({.cameras = {"a", "b"}, .rows = {{"x.png", ""}, {"x.png", ""}}}),
              AllOf(HasSubstr("--match: a"), HasSubstr("each image once")));
  cameras[0].images = {"x.png", "y.png", "z.png"};
  EXPECT_THAT(complaint({.cameras = {"a", "b"}, .rows = {{"w.png", ""}}}),
              AllOf(HasSubstr("row 1"), HasSubstr("'w.png', which is no image of a")));
}

TEST(RigFrames, RefusesNamesThatDoNotMatch) {
  EXPECT_THAT(messageOf([] {
                (void)matchFrames(std::vector{camera("a", {"x.png"}), camera("b", {"y.png"})});
              }),
              AllOf(HasSubstr("for example a/x.png and b/y.png"), HasSubstr("--match")));
  EXPECT_THAT(messageOf([] {
                (void)matchFrames(std::vector{camera("a", {"x1.png", "y1.png"}), camera("b", {"z1.png"})});
              }),
              HasSubstr("for example a/x1.png and b/z1.png"));
}

}  // namespace
}  // namespace alidade
