// SPDX-License-Identifier: MIT
#include <algorithm>

#include <nlohmann/json.hpp>

#include "alidade/io/corners_file.h"
#include "apps/command_line.h"

namespace alidade {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;

RunResult detect(const std::vector<int>& images, std::vector<std::string> more = {}) {
  std::vector<std::string> args = {"detect", "--board", kBoard};
  for (const int i : images) args.push_back(imagePath(i));
  args.insert(args.end(), more.begin(), more.end());
  return runAlidade(args);
}

TEST(Detect, WritesTheSameToFilesAndToStandardOutput) {
  const ScratchFolder scratch;
  const RunResult to_file = detect({1, 2}, {"-o", scratch.path("corners.csv")});
  ASSERT_THAT(to_file, EndsWith(0));
  EXPECT_EQ(to_file.out, "");
  EXPECT_THAT(to_file.err, HasSubstr("2 of 2 images show the whole board (54 corners each); written to"));
  const RunResult to_stdout = detect({1, 2});
  ASSERT_THAT(to_stdout, EndsWith(0));
  EXPECT_EQ(to_stdout.out, scratch.read("corners.csv"));
  EXPECT_EQ(detect({2, 1}, {"-o", "-", "--jobs", "2"}).out, to_stdout.out);
  EXPECT_THAT(scratch.list(), ElementsAre("corners.csv"));
}

TEST(Detect, FindsTheTrueCorners) {
  const RunResult result = detect({1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12}, {"--quiet"});
  ASSERT_THAT(result, EndsWith(0));
  EXPECT_EQ(result.err, "");
  const CornersFile found = parseCornersFile(result.out, "found");
  const CornersFile truth = readCornersFile(dataPath("corners.csv"));
  ASSERT_EQ(found.views.size(), truth.views.size());
  constexpr double kWorstPx = 0.3;  // images with noise; a corner on the wrong square would be 20 px off
  std::size_t num_corners = 0;
  double worst = 0;
  for (std::size_t v = 0; v < found.views.size(); ++v) {
    EXPECT_EQ(found.views[v].image, truth.views[v].image);
    const auto& corners = found.views[v].corners;
    ASSERT_EQ(corners.size(), 54u);
    // The board looks the same after half a turn.
    const auto worstOf = [&](bool is_turned) {
      double off = 0;
      for (std::size_t i = 0; i < corners.size(); ++i)
        off = std::max(off, (corners[i].pixel - truth.views[v].corners[is_turned ? 53 - i : i].pixel).norm());
      return off;
    };
    worst = std::max(worst, std::min(worstOf(false), worstOf(true)));
    num_corners += corners.size();
  }
  EXPECT_EQ(num_corners, 648u);
  EXPECT_LE(worst, kWorstPx);
}

TEST(Detect, WritesOneJsonDocument) {
  const ScratchFolder scratch;
  const RunResult result = detect({1, 2}, {"--json", "-o", scratch.path("corners.csv")});
  ASSERT_THAT(result, EndsWith(0));
  const auto images = nlohmann::json::parse(result.out).at("images");
  ASSERT_EQ(images.size(), 2u);
  const CornersFile file = readCornersFile(scratch.path("corners.csv"));
  for (std::size_t i = 0; i < 2; ++i) {
    EXPECT_EQ(images[i].at("image"), file.views[i].image);
    ASSERT_EQ(images[i].at("corners").size(), 54u);
    EXPECT_EQ(images[i].at("corners")[53].at("u").get<double>(), file.views[i].corners[53].pixel.x());
  }
}

TEST(Detect, MakesPiecesThatConcatenate) {
  const RunResult first = detect({1, 2});
  const RunResult second = detect({3, 4});
  const RunResult whole = detect({1, 2, 3, 4});
  ASSERT_THAT(whole, EndsWith(0));
  const CornersFile pieces = parseCornersFile(second.out + first.out, "pieces");
  const CornersFile at_once = parseCornersFile(whole.out, "whole");
  CornersFile joined = pieces;
  joined.comments = at_once.comments;
  EXPECT_EQ(cornersFileText(joined), cornersFileText(at_once));
}

}  // namespace
}  // namespace alidade
