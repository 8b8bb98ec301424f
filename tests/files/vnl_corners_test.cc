// SPDX-License-Identifier: MIT
// The corners files of mrcal: what they may hold, what is refused, and that mrcal reads ours.
#include "alidade/files/corners_file.h"

#include <map>
#include <sstream>

#include <gmock/gmock.h>

#include "alidade/core/text.h"
#include "alidade/target/board_spec.h"
#include "apps/run_program.h"
#include "support/image_sizes.h"
#include "support/message_of.h"
#include "support/peer.h"
#include "support/scratch_folder.h"

namespace alidade {
namespace {

using testing::HasSubstr;

constexpr const char* kMrcal = "/usr/lib/python3/dist-packages/mrcal/__init__.py";

Board board() {
  return Checkerboard{.columns = 3, .rows = 2, .square_m = 0.025};  // small, for short texts
}

CornersFile parse(const std::string& text) {
  return parseVnlFile(text, "corners.vnl", board(), kVga);
}

// The six rows of an image, whose last column (with the blank before it) is `extra`.
std::string rowsOf(const std::string& image, const std::string& extra = "") {
  std::string rows;
  for (int id = 0; id < 6; ++id)
    rows += image + " " + std::to_string(100 + 10 * (id % 3)) + ".5 " + std::to_string(200 + id / 3) + extra +
            "\n";
  return rows;
}

// Three views with all corners, with some, and with one at the left border.
CornersFile threeViews() {
  CornersFile file;
  file.boards = {board()};
  for (const char* image : {"img1.png", "img2.png", "img10.png"}) {
    View view{.image = image, .size = kVga};
    for (int id = 0; id < 6; ++id) {
      if (file.views.size() == 1 && id == 4) continue;
      view.corners.push_back(
          {.id = id,
           .pixel = {100 + 10 * (id % 3) + 0.1 * static_cast<double>(file.views.size()), 200.0 + id / 3},
           .sigma_px = 0.01 * (1 + id)});
    }
    file.views.push_back(view);
  }
  file.views[2].corners[0].pixel.x() = -0.25;
  return file;
}

TEST(VnlFile, HoldsARowForEachCornerOfTheBoard) {
  CornersFile file = threeViews();
  file.views.resize(2);
  file.comments = {"two\nlines", "\xC3\xA4"};
  EXPECT_EQ(vnlFileText(file),
            "## two\n## lines\n## ??\n# filename x y\n"
            "img1.png 100 200\nimg1.png 110 200\nimg1.png 120 200\n"
            "img1.png 100 201\nimg1.png 110 201\nimg1.png 120 201\n"
            "img2.png 100.1 200\nimg2.png 110.1 200\nimg2.png 120.1 200\n"
            "img2.png 100.1 201\nimg2.png - -\nimg2.png 120.1 201\n");
}

TEST(VnlFile, ReadsBackWhatItWrote) {
  const CornersFile file = threeViews();
  const CornersFile read = parse(vnlFileText(file));
  EXPECT_EQ(read.boards, file.boards);
  ASSERT_EQ(read.views.size(), 3u);
  std::size_t num_corners = 0;
  for (std::size_t v = 0; v < 3; ++v) {
    EXPECT_EQ(read.views[v].image, file.views[v].image);
    EXPECT_EQ(read.views[v].size, kVga);
    std::vector<Corner> expected = file.views[v].corners;
    if (v == 2) expected.erase(expected.begin());  // its x is negative
    ASSERT_EQ(read.views[v].corners.size(), expected.size());
    for (std::size_t i = 0; i < expected.size(); ++i) {
      const Corner& corner = read.views[v].corners[i];
      EXPECT_EQ(corner.id, expected[i].id);
      EXPECT_EQ(corner.pixel, expected[i].pixel);
      EXPECT_TRUE(std::isnan(corner.sigma_px));
      ++num_corners;
    }
  }
  EXPECT_EQ(num_corners, 16u);
}

TEST(VnlFile, KnowsWhatWasNotFound) {
  const CornersFile read = parse("## of mrgingham\n\n# any remark\n# filename x y level\r\n" +
                                 rowsOf("b10.png", " 0\r") + "none.png - - -\n" + rowsOf("b9.png", " -1") +
                                 "c.png - - -\nc.png 100 -1 0\nc.png 100 200 -\nc.png 100 200 -1\nc.png - "
                                 "200 0\n c.png\t639.5  479.5 0");
  ASSERT_EQ(read.views.size(), 2u);
  EXPECT_EQ(read.views[0].image, "b10.png");
  EXPECT_EQ(read.views[0].corners.size(), 6u);
  EXPECT_EQ(read.views[1].image, "c.png");
  ASSERT_EQ(read.views[1].corners.size(), 1u);
  EXPECT_EQ(read.views[1].corners[0].id, 5);
  EXPECT_EQ(read.views[1].corners[0].pixel, Eigen::Vector2d(639.5, 479.5));
}

TEST(VnlFile, GivesTheBestCornersASigmaOfOnePixel) {
  const auto sigmas = [](const std::string& legend, const std::vector<std::string>& extras) {
    std::string text = "# filename x y " + legend + "\n";
    for (std::size_t i = 0; i < extras.size(); ++i) text += rowsOf(std::to_string(i), " " + extras[i]);
    std::vector<double> result;
    for (const View& view : parse(text).views) result.push_back(view.corners.back().sigma_px);
    return result;
  };
  EXPECT_THAT(sigmas("level", {"1", "3", "2"}), testing::ElementsAre(1, 4, 2));
  EXPECT_THAT(sigmas("weight", {"0.5", "2", "8", "0"}), testing::ElementsAre(16, 4, 1));
  for (const char* same : {"0", "2"})
    EXPECT_THAT(sigmas("level", {same, same}), testing::Each(testing::IsNan()));
  EXPECT_THAT(sigmas("weight", {"0.3", "0.3"}), testing::Each(testing::IsNan()));
}

TEST(VnlFile, ReadsSeveralFilesAsOne) {
  const ScratchFolder scratch;
  const std::vector<std::string> paths = {
      scratch.write("a.vnl", "# filename x y weight\n" + rowsOf("b.png", " 0.5")),
      scratch.write("b.vnl", "# filename x y\n" + rowsOf("a.png"))};
  const CornersFile read = readVnlFiles(paths, board(), kVga);
  ASSERT_EQ(read.views.size(), 2u);
  EXPECT_EQ(read.views[0].image, "a.png");
  EXPECT_EQ(read.views[0].corners[0].sigma_px, 1);
  EXPECT_EQ(read.views[1].corners[0].sigma_px, 2);
  const std::vector<std::string> twice = {paths[0], paths[0]};
  EXPECT_THAT(messageOf([&] { (void)readVnlFiles(twice, board(), kVga); }),
              HasSubstr(paths[0] + ":2: found image 'b.png' again"));
}

TEST(VnlFile, ThatIsWrongIsNamedWithItsLine) {
  const std::string good = "# filename x y level\n" + rowsOf("a.png", " 0");
  const std::string weights = "# filename x y weight\n";
  struct Case {
    std::string text;
    std::string message;
  };
  const std::vector<Case> cases = {
      {"", "corners.vnl: no legend; expected the legend '# filename x y'"},
      {"## filename x y\n", "corners.vnl: no legend"},
      {rowsOf("a.png", " 0"), "corners.vnl:1: found 'a.png 100.5 200 0'; expected the legend"},
      {"# filename x y sigma\n",
       "corners.vnl:1: found the legend '# filename x y sigma'; expected the legend"},
      {"# filename x y level\n", "corners.vnl: no corners"},
      {"# filename x y level\na.png - - -\n", "corners.vnl: no corners"},
      {good + "b.png 1 2\n", "corners.vnl:8: found 3 values; expected 4 as in the legend"},
      {good + "b.png 1 2 0 0\n", "corners.vnl:8: found 5 values; expected 4"},
      {good + "b.png ten 2 0\n", "corners.vnl:8: found 'ten' as x; expected a finite number, or -"},
      {good + "b.png 1 nan 0\n", "corners.vnl:8: found 'nan' as y; expected a finite number"},
      {good + "b.png 1 2 high\n", "corners.vnl:8: found 'high' as level; expected a finite number"},
      {good + "b.png 1 2 0.5\n", "name the column so: # filename x y weight"},
      {good + "b.png 1 2 31\n", "corners.vnl:8: found '31' as level; expected a whole number from 0 to 30"},
      {weights + "b.png 1 2 inf\n", "corners.vnl:2: found 'inf' as weight; expected a finite number"},
      {good + "b.png 660 2 0\n",
       "corners.vnl:8: found a corner of 'b.png' at (660, 2), outside the image of 640x480"},
      {good + "b.png 2 500 0\n", "check --image-size: width and height may be swapped"},
      {good + "b.png 1 2 0\n", "corners.vnl:8: found image 'b.png' with 1 row; expected 6"},
      {good + "b.png - - -\nb.png - - -\n", "found image 'b.png' with 2 rows; expected 6"},
      {good + "a.png - - -\n",
       "corners.vnl:2: found image 'a.png' with 7 rows; expected 6, one per corner of "
       "checkerboard:3x2:25mm "
       "(3 columns x 2 rows)"},
      {good + "b.png - - -\n" + rowsOf("a.png", " 0"), "corners.vnl:9: found image 'a.png' again"},
  };
  std::size_t num_refused = 0;
  for (const Case& c : cases) {
    EXPECT_THAT(messageOf([&] { (void)parse(c.text); }), HasSubstr(c.message)) << c.text;
    ++num_refused;
  }
  EXPECT_EQ(num_refused, 20u);
}

TEST(VnlFile, HoldsEvenlySpacedBoardsAlone) {
  const std::vector<std::string> images = {"a.png"};
  int num_checked = 0;
  for (const char* spec :
       {"checkerboard:9x6:25mm", "charuco:8x11:24mm:18.75mm:DICT_4X4_1000", "circles:10x8:25mm:15mm"}) {
    const std::vector<Board> boards = {parseBoardSpec(spec)};
    EXPECT_NO_THROW(checkVnl(boards, images)) << spec;
    ++num_checked;
  }
  for (const char* spec : {"aprilgrid:6x6:88mm:0.3", "acircles:4x11:20mm:14mm"}) {
    const std::vector<Board> boards = {parseBoardSpec(spec)};
    EXPECT_THAT(messageOf([&] { checkVnl(boards, images); }),
                testing::AllOf(HasSubstr("evenly spaced"), HasSubstr("write a .csv file")))
        << spec;
    ++num_checked;
  }
  EXPECT_EQ(num_checked, 5);
  CornersFile file = threeViews();
  file.boards.push_back(parseBoardSpec("checkerboard:4x5:25mm"));
  EXPECT_THAT(messageOf([&] { (void)vnlFileText(file); }), HasSubstr("expected one board"));
}

TEST(VnlFile, HoldsNamesThatMrcalReads) {
  int num_refused = 0;
  for (const char* name : {"", "a b.png", "a\tb.png", "a\nb.png", "#1.png", "\xC3\xA4.png"}) {
    CornersFile file = threeViews();
    file.views[1].image = name;
    EXPECT_THAT(messageOf([&] { (void)vnlFileText(file); }),
                HasSubstr("a name that a .vnl file cannot hold"));
    ++num_refused;
  }
  EXPECT_EQ(num_refused, 6);
}

// Prints each corner as mrcal reads it: image, row, column, x, y, weight.
constexpr const char* kScript = R"(
import os, sys
import mrcal

path, kind = sys.argv[1:]
observations, _, paths = mrcal.compute_chessboard_corners(
    3, 2, corners_cache_vnl=path, weight_column_kind=None if kind == 'none' else kind)
for grid, image in zip(observations, paths):
    for row in range(2):
        for column in range(3):
            print(os.path.basename(image), row, column, *(repr(float(v)) for v in grid[row, column]))
)";

struct MrcalCorner {
  Eigen::Vector2d pixel;
  double weight;
};

// By image and id, without those that mrcal leaves aside.
std::map<std::pair<std::string, int>, MrcalCorner> cornersInMrcal(const std::string& path,
                                                                  const std::string& kind) {
  const RunResult run = runProgram("/usr/bin/python3", {"-c", kScript, path, kind});
  EXPECT_EQ(run.exit_code, 0) << run.err;
  std::map<std::pair<std::string, int>, MrcalCorner> corners;
  std::istringstream stream(run.out);
  std::string image;
  int row = 0;
  int column = 0;
  for (MrcalCorner corner;
       stream >> image >> row >> column >> corner.pixel.x() >> corner.pixel.y() >> corner.weight;) {
    if (corner.weight > 0) corners[{image, 3 * row + column}] = corner;
  }
  return corners;
}

TEST(VnlFile, IsReadByMrcalWithAnyOfItsFlags) {
  ALIDADE_NEED_PEER(kMrcal, "python3-mrcal");
  const ScratchFolder scratch;
  const CornersFile file = threeViews();
  writeVnlFile(scratch.path("corners.vnl"), file);
  std::size_t num_compared = 0;
  for (const char* kind : {"level", "weight", "none"}) {
    auto corners = cornersInMrcal(scratch.path("corners.vnl"), kind);
    for (const View& view : file.views) {
      for (const Corner& corner : view.corners) {
        if (corner.pixel.x() < 0) continue;
        const auto found = corners.extract({view.image, corner.id});
        ASSERT_FALSE(found.empty()) << view.image << " " << corner.id;
        EXPECT_EQ(found.mapped().pixel, corner.pixel);
        EXPECT_EQ(found.mapped().weight, 1);
        ++num_compared;
      }
    }
    EXPECT_TRUE(corners.empty());
  }
  EXPECT_EQ(num_compared, 48u);
}

TEST(VnlFile, IsReadAsMrcalReadsIt) {
  ALIDADE_NEED_PEER(kMrcal, "python3-mrcal");
  const ScratchFolder scratch;
  std::size_t num_compared = 0;
  for (const std::string kind : {"level", "weight"}) {
    std::string text = "## remark\n# filename x y " + kind + "\nnone.png - - -\n";
    for (const char* extra : {"1", "2", "4"}) {
      text += rowsOf(std::string(extra) + ".png", std::string(" ") + extra);
    }
    text += "few.png - - -\nfew.png 1.5 2 3\nfew.png 2.5 2 -\nfew.png 1 3 3\nfew.png 2 3 3\nfew.png 3 3 3\n";
    const auto corners = cornersInMrcal(scratch.write(kind + ".vnl", text), kind);
    const CornersFile read = parse(text);
    ASSERT_EQ(read.views.size(), 4u);
    const double best = kind == "level" ? 0.5 : 4;  // mrcal's weight of the corners to which we give 1 px
    for (const View& view : read.views) {
      for (const Corner& corner : view.corners) {
        const auto found = corners.find({view.image, corner.id});
        ASSERT_NE(found, corners.end()) << view.image << " " << corner.id;
        EXPECT_EQ(found->second.pixel, corner.pixel);
        EXPECT_DOUBLE_EQ(found->second.weight * corner.sigma_px, best);
        ++num_compared;
      }
    }
    EXPECT_EQ(corners.size(), 22u);
  }
  EXPECT_EQ(num_compared, 44u);
}

}  // namespace
}  // namespace alidade
