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

TEST(RigFrames, MatchesFramesOfVideos) {
  const std::vector<RigViews> cameras = {camera("a", {"clips/cam_0.mp4@0", "clips/cam_0.mp4@16"}),
                                         camera("b", {"cam_1.avi@16", "cam_1.avi@32"})};
  const RigFrames frames = matchFrames(cameras);
  EXPECT_THAT(frames.names, ElementsAre("0", "16", "32"));
  EXPECT_THAT(frames.frame_of, ElementsAre(ElementsAre(0, 1), ElementsAre(1, 2)));
  const std::vector<RigViews> same_name = {camera("a", {"clip.mp4@3", "clip.mp4@12"}),
                                           camera("b", {"clip.mp4@12"})};
  EXPECT_THAT(matchFrames(same_name).frame_of, ElementsAre(ElementsAre(0, 1), ElementsAre(1)));
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

TEST(RigFrames, MatchesNumbersLessTheLeads) {
  std::vector<RigViews> cameras = {camera("a", {"frame01_cam0.jpg", "frame12_cam0.jpg"}),
                                   camera("b", {"frame19_cam1.jpg", "frame3_cam1.jpg"})};
  cameras[1].lead = 7;
  const RigFrames frames = matchFrames(cameras);
  EXPECT_THAT(frames.names, ElementsAre("3", "8", "19"));
  EXPECT_THAT(frames.frame_of, ElementsAre(ElementsAre(1, 2), ElementsAre(2, 0)));
  // Thirds of 100: a lead of three intervals is 99 or 100.
  cameras = {camera("a", {"0.png", "33.png", "67.png", "100.png"}),
             camera("b", {"100.png", "133.png", "167.png", "200.png"})};
  cameras[1].lead = 99;
  EXPECT_THAT(matchFrames(cameras).frame_of, ElementsAre(ElementsAre(0, 1, 2, 3), ElementsAre(0, 1, 2, 3)));
  cameras[0].views[0].image = "none.png";
  EXPECT_THAT(messageOf([&] { (void)matchFrames(cameras); }), HasSubstr("no two images with the same name"));
}

TEST(RigFrames, KnowsTheTimesInNames) {
  const std::vector<RigViews> cameras = {
      camera("a", {"1700000000.000.png", "1700000000.033.png", "1700000000.067.png"}),
      camera("b", {"1700000000.001.png", "1700000000.034.png", "1700000000.068.png"})};
  const RigFrames frames = matchFrames(cameras);
  EXPECT_NEAR(frames.interval_s, 0.0335, 0.001);
  ASSERT_EQ(frames.times.size(), 3u);
  EXPECT_NEAR(frames.times[2], 2, 0.05);
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

// Two cameras of one clock, and a third one a little later.
TEST(RigFrames, MatchesACameraOfAnotherClockToThoseOfOne) {
  std::vector<std::string> exact;
  std::vector<std::string> late;
  for (const char* hundreds : {"0", "1", "2", "3"}) {
    exact.push_back("1700000" + std::string(hundreds) + "00000.png");
    late.push_back("1700000" + std::string(hundreds) + "00007.png");
  }
  const RigFrames frames =
      matchFrames(std::vector{camera("a", exact), camera("b", exact), camera("c", late)});
  for (std::size_t c = 0; c < 3; ++c) EXPECT_THAT(frames.frame_of[c], ElementsAre(0, 1, 2, 3)) << c;
  EXPECT_EQ(frames.time_spread, 7);
  // Equal times are nearest, whatever else is in reach.
  const RigFrames equal =
      matchFrames(std::vector{camera("a", {"100.000.png", "100.100.png", "100.200.png", "100.300.png"}),
                              camera("b", {"99.990.png", "100.000.png", "100.205.png", "100.310.png"})});
  EXPECT_THAT(equal.names, ElementsAre("99.990", "100.000", "100.100", "100.200", "100.300"));
  EXPECT_THAT(equal.frame_of, ElementsAre(ElementsAre(1, 2, 3, 4), ElementsAre(0, 1, 3, 4)));
}

TEST(RigFrames, TakesTheNearestTimeAndNotTheFirstInReach) {
  const RigFrames frames =
      matchFrames(std::vector{camera("a", {"100.100.png", "100.200.png", "100.300.png"}),
                              camera("b", {"100.080.png", "100.102.png", "100.199.png"})});
  EXPECT_THAT(frames.names, ElementsAre("100.080", "100.100", "100.199", "100.300"));
  EXPECT_THAT(frames.frame_of, ElementsAre(ElementsAre(1, 2, 3), ElementsAre(0, 1, 2)));
  EXPECT_NEAR(frames.time_spread, 0.002, 1e-9);
}

TEST(RigFrames, MatchesEqualNamesInEqualSubfolders) {
  const std::vector<RigViews> cameras = {camera("a", {"s1/000.png", "s1/001.png", "s2/000.png"}),
                                         camera("b", {"s1/000.jpg", "s2/000.jpg", "s2/001.jpg"})};
  const RigFrames frames = matchFrames(cameras);
  EXPECT_THAT(frames.names, ElementsAre("s1/000", "s1/001", "s2/000", "s2/001"));
  EXPECT_THAT(frames.frame_of, ElementsAre(ElementsAre(0, 1, 2), ElementsAre(0, 2, 3)));
  // Sub-folders that only one camera has tell nothing.
  EXPECT_THAT(messageOf([] {
                (void)matchFrames(std::vector{camera("a", {"s1/x.png", "s2/x.png"}), camera("b", {"x.png"})});
              }),
              HasSubstr("occurs twice in one camera: s1/x.png and s2/x.png of a"));
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
              AllOf(HasSubstr("--match: row 2"), HasSubstr("'x.png' of a"), HasSubstr("each image once")));
  cameras[0].images = {"x.png", "y.png", "z.png"};
  EXPECT_THAT(complaint({.cameras = {"a", "b"}, .rows = {{"w.png", ""}}}),
              AllOf(HasSubstr("row 1"), HasSubstr("'w.png', which is no image of a")));
}

// Without a list of all images, one that no view shows may have had no board; but not all of a column.
TEST(RigFrames, CountsNamesOfATableWithoutViews) {
  const std::vector<RigViews> cameras = {camera("a", {"x.png", "y.png", "z.png"}), camera("b", {"x.png"})};
  FrameTable table{.cameras = {"a", "b"},
                   .rows = {{"x.png", "x.png"}, {"y.png", "y.png"}, {"w.png", ""}},
                   .path = "frames.csv",
                   .lines = {2, 4, 5}};
  EXPECT_THAT(namedWithoutViews(table, cameras),
              ElementsAre(RigImage{0, "w.png", "frames.csv:5"}, RigImage{1, "y.png", "frames.csv:4"}));
  // The partner of y.png is known, that of z.png is not.
  const RigFrames frames = framesOf(table, cameras);
  EXPECT_THAT(frames.names, ElementsAre("a/z.png", "line 2", "line 4"));
  EXPECT_THAT(frames.unmatched, ElementsAre(RigImage{0, "z.png", "a/z.png"}));
  table.rows = {{"x.png", "p.png"}, {"y.png", "q.png"}, {"z.png", ""}};
  EXPECT_THAT(messageOf([&] { (void)framesOf(table, cameras); }),
              AllOf(HasSubstr("frames.csv:2"), HasSubstr("'p.png', which is no image of b"),
                    HasSubstr("such as 'x.png'")));
}

TEST(RigFrames, FollowsTheFoldersInATable) {
  std::vector<RigViews> cameras = {camera("a", {"01.png", "02.png"}), camera("b", {"01.png", "02.png"})};
  for (RigViews& of_camera : cameras) {
    of_camera.images = {"01.png", "02.png"};
    for (const std::string& image : of_camera.images)
      of_camera.paths.push_back("photos/" + of_camera.name + "/" + image);
  }
  FrameTable table{
      .cameras = {"a", "b"}, .rows = {{"a/01.png", "./photos/b/02.png"}}, .path = "frames.csv", .lines = {2}};
  EXPECT_THAT(framesOf(table, cameras).names, ElementsAre("a/02.png", "b/01.png", "line 2"));
  table.rows = {{"b/01.png", "b/02.png"}};
  EXPECT_THAT(messageOf([&] { (void)framesOf(table, cameras); }),
              AllOf(HasSubstr("frames.csv:2"), HasSubstr("'b/01.png', which is no image of a")));
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
