// SPDX-License-Identifier: MIT
#include "alidade/core/error.h"
#include "alidade/files/corners_file.h"
#include "apps/command_line.h"

namespace alidade {
namespace {

using testing::AllOf;
using testing::HasSubstr;

constexpr const char* kHeader = "camera,image,width,height,board,corner_id,col,row,u,v,sigma_px\n";
constexpr const char* kRow = "cam,a.png,640,480,checkerboard:9x6:25mm,0,0,0,10,20,\n";

TEST(CornersFile, ThatIsWrongIsNamedWithItsLine) {
  const std::string good = std::string(kHeader) + kRow;
  const auto withRow = [&](const std::string& row) { return good + row + "\n"; };
  struct Case {
    std::string text;
    std::string place;
    std::string found;
  };
  const std::string prefix = "cam,a.png,640,480,checkerboard:9x6:25mm,";
  const std::vector<Case> cases = {
      {"", "", "no header"},
      {"u,v\n1,2\n", ":1", "found 'u,v'; expected the header camera,image"},
      {kRow, ":1", "expected the header"},
      {kHeader, "", "no corners"},
      {withRow(prefix + "1,1,0,ten,20,"), ":3", "'ten' as u; expected a finite number"},
      {withRow(prefix + "1,1,0,nan,20,"), ":3", "'nan' as u; expected a finite number"},
      {withRow(prefix + "1,1,0,10,inf,"), ":3", "'inf' as v; expected a finite number"},
      {withRow(prefix + "1,1,0,10,20,0"), ":3", "'0' as sigma_px; expected a positive number"},
      {withRow(prefix + "1,1,0,10,20"), ":3", "10 fields; expected 11"},
      {withRow(prefix + "1,1,0,10,20,,"), ":3", "12 fields; expected 11"},
      {withRow(prefix + "54,0,6,10,20,"), ":3", "'54' as corner_id; expected a whole number from 0 to 53"},
      {withRow(prefix + "-1,0,0,10,20,"), ":3", "'-1' as corner_id"},
      {withRow(prefix + "1,2,0,10,20,"), ":3", "corner_id = row * columns + col"},
      {withRow(prefix + "0,0,0,11,21,"), ": image a.png", "corner 0 twice"},
      {withRow("cam,a.png,640,480,checkerboard:8x6:25mm,48,0,6,10,20,"), ":3",
       "'48' as corner_id; expected a whole number from 0 to 47"},
      {withRow("cam,a.png,641,480,checkerboard:8x6:25mm,1,1,0,10,20,"), ":3", "with a different size"},
      {withRow("cam,a.png,640,480,chekerboard:9x6:25mm,1,1,0,10,20,"), ":3", "did you mean 'checkerboard'?"},
      {withRow("cam,a.png,641,480,checkerboard:9x6:25mm,1,1,0,10,20,"), ":3", "with a different size"},
      {withRow("cam,a.png,0,480,checkerboard:9x6:25mm,1,1,0,10,20,"), ":3", "'0' as width"},
      {withRow(prefix + "1,1,0,10,500,"), ":3",
       "corner 1 of 'a.png' at (10, 500), outside the image of 640x480"},
      {withRow("cam,b.png,480,640,checkerboard:9x6:25mm,1,1,0,600,20,"), ":3",
       "outside the image of 480x640"},
      {withRow("two,a.png,640,480,checkerboard:9x6:25mm,1,1,0,10,20,"), ":3", "camera 'two'"},
      {withRow("cam,\"a.png,640,480,checkerboard:9x6:25mm,1,1,0,10,20,"), ":3", "a quote that is not closed"},
      {std::string("\x89PNG\0", 5), "", "a zero byte"},
  };
  const ScratchFolder scratch;
  std::size_t num_refused = 0;
  for (const Case& c : cases) {
    const std::string path = scratch.write("corners.csv", c.text);
    EXPECT_THAT(runAlidade({"calibrate", path, "-o", scratch.path("camera.yaml")}),
                FailsWith(1, AllOf(HasSubstr(path + c.place), HasSubstr(c.found))))
        << c.text;
    ++num_refused;
  }
  EXPECT_EQ(num_refused, 24u);
  EXPECT_THAT(scratch.list(), testing::ElementsAre("corners.csv"));
}

TEST(CornersFile, IsReadHoweverItsLinesEndAndItsPiecesLie) {
  const std::string good = readFile(dataPath("corners.csv"));
  std::string with_crlf;
  for (const char c : good) with_crlf += c == '\n' ? std::string("\r\n") : std::string(1, c);
  // The first view moves to the end, in a piece with a header of its own.
  const std::size_t first = good.find(kHeader) + std::string(kHeader).size();
  const std::size_t second = good.find("camera,view_002.png");
  const std::string in_pieces = "# one\n" + std::string(kHeader) + good.substr(second) + "\n# two\n" +
                                kHeader + good.substr(first, second - first);
  const ScratchFolder scratch;
  const std::vector<double> expected =
      parametersOf(runAlidade({"calibrate", dataPath("corners.csv"), "-o", "-"}).out);
  int num_read = 0;
  for (const std::string& text : {with_crlf, in_pieces, "\xEF\xBB\xBF" + good}) {
    const RunResult result = runAlidade({"calibrate", scratch.write("corners.csv", text), "-o", "-"});
    ASSERT_THAT(result, EndsWith(0));
    EXPECT_EQ(parametersOf(result.out), expected);
    ++num_read;
  }
  EXPECT_EQ(num_read, 3);
}

TEST(CornersFile, HoldsSeveralBoards) {
  const std::string text = std::string(kHeader) + kRow +
                           "cam,b.png,640,480,checkerboard:9x6:0.025,0,0,0,10,20,\n"  // the same board
                           "cam,a.png,640,480,checkerboard:9x6:30mm,53,8,5,300,200,0.1\n"
                           "cam,a.png,640,480,aprilgrid:2x2:50mm:0.3:7,15,3,3,30,40,\n";
  const CornersFile file = parseCornersFile(text, "boards");
  ASSERT_EQ(file.boards.size(), 3U);
  EXPECT_EQ(file.boards[2].spec(), "aprilgrid:2x2:50mm:0.3:7");
  ASSERT_EQ(file.views.size(), 4U);
  const std::vector<std::pair<std::string, std::size_t>> expected = {
      {"a.png", 0}, {"a.png", 1}, {"a.png", 2}, {"b.png", 0}};
  for (std::size_t v = 0; v < expected.size(); ++v) {
    EXPECT_EQ(file.views[v].image, expected[v].first);
    EXPECT_EQ(file.views[v].board, expected[v].second);
    EXPECT_EQ(file.views[v].corners.size(), 1U);
  }
  EXPECT_EQ(cornersFileText(parseCornersFile(cornersFileText(file), "again")), cornersFileText(file));
}

TEST(CornersFile, StaysReadableWhateverItsCommentsAndNamesHold) {
  CornersFile file = parseCornersFile(std::string(kHeader) + kRow, "good");
  file.comments = {"two\nlines", "and\r\na return"};
  file.views.front().image = "a,\"b\" #.png";
  const std::string text = cornersFileText(file);
  EXPECT_THAT(text, testing::StartsWith("# two\n# lines\n# and \n# a return\ncamera,image,"));
  EXPECT_EQ(parseCornersFile(text, "again").views.front().image, file.views.front().image);
  file.views.front().image = "two\nlines.png";
  EXPECT_THROW((void)cornersFileText(file), Error);
}

}  // namespace
}  // namespace alidade
