// SPDX-License-Identifier: MIT
#include <algorithm>
#include <chrono>
#include <cmath>
#include <thread>

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "apps/project_support.h"

namespace alidade {
namespace {

using testing::AllOf;
using testing::HasSubstr;
using testing::IsEmpty;

// Points in front of the camera, all in the image, spread without a pattern.
std::string manyPoints(int count) {
  std::string text;
  for (int i = 0; i < count; ++i)
    text += fmt::format("{:.4f},{:.4f},{:.4f}\n", -0.4 + 0.8 * (i % 1009) / 1009,
                        -0.3 + 0.6 * (i % 997) / 997, 1 + (i % 991) / 991.0);
  return text;
}

TEST(Project, AnswersBeforeItsInputEnds) {
  const ScratchFolder scratch;
  const std::string fifo = scratch.path("points");
  ASSERT_EQ(::mkfifo(fifo.c_str(), 0600), 0);
  const int points = ::open(fifo.c_str(), O_RDWR | O_CLOEXEC);  // open for both, so that nobody waits here
  ASSERT_GE(points, 0);
  RunningProgram program(alidadeProgram(), {"project", dataPath("camera.yaml")},
                         {.input_path = fifo, .output_path = scratch.write("out.csv", "")});
  int num_answers = 0;
  for (const std::string point : {"0,0,1\n", "0.1,0,1\n"}) {
    ASSERT_EQ(::write(points, point.data(), point.size()), static_cast<ssize_t>(point.size()));
    const auto numLines = [&] {
      const std::string out = scratch.read("out.csv");
      return std::count(out.begin(), out.end(), '\n');
    };
    constexpr int kMaxTries = 1000;
    for (int i = 0; i < kMaxTries && numLines() < num_answers + 2; ++i)
      std::this_thread::sleep_for(std::chrono::milliseconds(10));
    ++num_answers;
    EXPECT_EQ(numLines(), num_answers + 1);
  }
  EXPECT_EQ(num_answers, 2);
  ::close(points);
  EXPECT_THAT(program.wait(), EndsWith(0));
}

TEST(Project, StreamsAMillionPoints) {
  constexpr int kCount = 1'000'000;
  const RunResult result = project(
      manyPoints(kCount), {"--pose", "{rotation_vector_rad: [0, 0.02, 0], translation_m: [0, 0, 0.5]}"});
  ASSERT_THAT(result, EndsWith(0));
  EXPECT_EQ(std::count(result.out.begin(), result.out.end(), '\n'), kCount + 1);
  EXPECT_EQ(result.err, "1000000 ok\n");
}

TEST(Project, ReachesTheSamePixelsFromEveryFormOfAPose) {
  // Half a turn about x + y, moved by (0.1, -0.2, 1.5): exact in every form.
  const std::string t = "translation_m: [0.1, -0.2, 1.5]";
  const std::vector<std::string> poses = {
      "{quaternion_xyzw: [1, 1, 0, 0], " + t + "}",
      "{quaternion_wxyz: [0, 1, 1, 0], " + t + "}",
      "{rotation_vector_rad: [2.221441469079183, 2.221441469079183, 0], " + t + "}",
      "{rotation_matrix: [[0, 1, 0], [1, 0, 0], [0, 0, -1]], " + t + "}",
      "{rotation_matrix: [0, 1, 0, 1, 0, 0, 0, 0, -1], " + t + "}",
      "{euler_zyx_deg: [90, 0, 180], " + t + "}",
      "{euler_zyx_rad: [1.5707963267948966, 0, 3.141592653589793], " + t + "}",
      "{matrix: [[0, 1, 0, 0.1], [1, 0, 0, -0.2], [0, 0, -1, 1.5], [0, 0, 0, 1]]}",
      "{camera_from_board: {quaternion_xyzw: [1, 1, 0, 0], " + t + "}}",
      "{world_from_camera: {quaternion_xyzw: [1, 1, 0, 0], translation_m: [0.2, -0.1, 1.5]}}",
  };
  constexpr double kSamePx = 1e-9;  // the forms carry 16 digits
  const std::string points = "0,0,0\n0.2,0.1,0.05\n-0.1,0.3,0.2\n";
  std::vector<std::vector<std::string>> expected;
  std::size_t num_forms = 0;
  for (const std::string& pose : poses) {
    const RunResult result = project(points, {"--pose", pose});
    ASSERT_THAT(result, EndsWith(0)) << pose;
    const auto rows = rowsOf(result.out);
    ASSERT_EQ(rows.size(), 3u);
    if (expected.empty()) expected = rows;
    for (std::size_t i = 0; i < rows.size(); ++i) {
      EXPECT_EQ(rows[i].at(2), "ok");
      EXPECT_NEAR(numberIn(rows[i].at(0)), numberIn(expected[i].at(0)), kSamePx) << pose;
      EXPECT_NEAR(numberIn(rows[i].at(1)), numberIn(expected[i].at(1)), kSamePx) << pose;
    }
    ++num_forms;
  }
  EXPECT_EQ(num_forms, 10u);
  const ScratchFolder scratch;
  const RunResult from_file = project(points, {"--pose", scratch.write("pose.yaml", poses.front())});
  EXPECT_EQ(rowsOf(from_file.out), expected);
}

TEST(Project, SaysWhyAPointHasNoPixel) {
  const RunResult result = project("0,0,1\n0,0,-1\n0,0,0\n100,0,0.01\nnan,0,1\n0,inf,1\n");
  ASSERT_THAT(result, EndsWith(0));
  const auto rows = rowsOf(result.out);
  ASSERT_EQ(rows.size(), 6u);
  EXPECT_EQ(rows[0].at(2), "ok");
  EXPECT_EQ(rows[1].at(2), "behind");
  for (std::size_t i = 1; i < rows.size(); ++i) {
    EXPECT_EQ(rows[i].at(0), "nan");
    EXPECT_EQ(rows[i].at(1), "nan");
    EXPECT_NE(rows[i].at(2), "ok") << "row " << i;
  }
  EXPECT_EQ(rows[3].at(2), "outside");
}

TEST(Project, ReadsTablesAsPeopleWriteThem) {
  const std::string expected = project("0.1,-0.05,1.0\n0.2,0.1,2\n").out;
  const std::vector<std::string> tables = {
      "x,y,z\n0.1,-0.05,1.0\n0.2,0.1,2\n",
      "z,name,x,y\n1.0,a,0.1,-0.05\n2,b,0.2,0.1\n",
      "0.1 -0.05 1.0\n0.2 0.1 2\n",
      "0.1\t-0.05\t1.0\n0.2\t0.1\t2\n",
      "0.1;-0.05;1.0\n0.2;0.1;2\n",
      "0.1 , -0.05 , 1.0\r\n0.2 , 0.1 , 2\r\n",
      "# points\n\nx y z\n  0.1 -0.05 1.0\n# more\n0.2 0.1 2",
      // From Excel: a mark at the start, ends of lines with carriage returns, quotes, capitals, units.
      "\xef\xbb\xbfX,Y,Z\r\n0.1,-0.05,1.0\r\n0.2,0.1,2\r\n",
      "\xef\xbb\xbf\"Name\";\"X [m]\";\"Y (m)\";\"z_m\"\r\n\"a \"\"b\"\"; "
      "c\";0.1;-0.05;1.0\r\nd;0.2;0.1;2\r\n",
      "\"x\",\"y\",\"z\"\n\"0.1\",\"-0.05\",\"1.0\"\n\"0.2\",\"0.1\",\"2\"\n",
      "x [m], y [m], z [m]\n0.1, -0.05, 1.0\n0.2, 0.1, 2\n",
      "name,x,y,z\nthe first,0.1,-0.05,1.0\n,0.2,0.1,2\n",
      "x,y,z,X,Y,Z\n0.1,-0.05,1.0,7,8,9\n0.2,0.1,2,7,8,9\n",
      // From NumPy: signs, exponents, many digits, the header as a comment.
      "+0.1 -0.05 1.0\n+2e-1 +1E-01 2.\n",
      "1.000000000000000056e-01 -5.000000000000000278e-02 1.000000000000000000e+00\n.2 .1 2\n",
      "# z y x\n1.0 -0.05 0.1\n2 0.1 0.2\n",
      "# x y z in metres of \"board, 1\n0.1 -0.05 1.0\n0.2 0.1 2\n",
      "name x y z\n\"a b\" 0.1 -0.05 1.0\nc 0.2 0.1 2\n",
  };
  ASSERT_EQ(rowsOf(expected).size(), 2u);
  std::size_t num_tables = 0;
  for (const std::string& table : tables) {
    const RunResult result = project(table);
    EXPECT_THAT(result, EndsWith(0)) << table;
    EXPECT_EQ(result.out, expected) << table;
    ++num_tables;
  }
  EXPECT_EQ(num_tables, 18u);
}

TEST(Project, NamesTheLineThatIsWrong) {
  struct Case {
    std::string points;
    std::string place;
    std::string found;
    std::string expected;
  };
  const std::vector<Case> cases = {
      {"0,0,1\n0,zero,1\n", ":2", "'zero' as y", "a number"},
      {"0,0,1\n\n# note\n0,0\n", ":4", "2 fields", "3 as in the previous rows"},
      {"0,0\n", ":1", "2 columns without a header", "x,y,z"},
      {"x,y\n0,0\n", ":1", "the header x,y", "columns x,y,z"},
      {"u,v,w\n0,0,1\n", ":1", "the header u,v,w", "columns x,y,z"},
      {"0,0,1,\n", ":1", "4 columns without a header", "x,y,z"},
      {"0,,1\n", ":1", "'' as y", "a number"},
      {"0,0x10,1\n", ":1", "'0x10' as y", "a number"},
      {"x,y,z_mm\n0,0,1\n", ":1", "the column 'z_mm'", "columns x,y,z in m"},
      {"X,x_m,y,z\n0,0,0,1\n", ":1", "two columns 'X' and 'x_m'", "columns x,y,z"},
      {"x,y,z,x\n0,0,1,2\n", ":1", "two columns 'x' and 'x'", "columns x,y,z"},
      {"x;y;z\n0,5;0;1\n", ":2", "both commas and semicolons", "decimal commas"},
      {"0,0,1\n0,5;0;1\n", ":2", "both commas and semicolons", "decimal commas"},
      {"0;0;1\n0;0;\"1,5\"\n", ":2", "'1,5' as z", "replace the decimal comma with a point"},
      {"x,y,z\n0,0,\"1\n", ":2", "a quote that is not closed", "a closing quote at the end of the field"},
      {"0 0 1\n0 0,1\n", ":2", "2 fields", "3 as in the previous rows"},
      {"0,0,1e999\n", ":1", "'1e999' as z", "a number"},
      {"0,0,+1\n0,0,1 2\n", ":2", "'1 2' as z", "a number"},
      {"0,0,+-1\n", ":1", "'+-1' as z", "a number"},
      {std::string("0,0,1\n0,0\0,1\n", 13), ":2", "'0\\0' as y", "a number"},
      {"\xff\xfex\n", ":1", "UTF-16 text", "CSV (UTF-8)"},
      {std::string(70'000, '1'), ":1", "a line longer than 64 KiB", "one row of numbers per line"},
  };
  std::size_t num_refused = 0;
  for (const Case& c : cases) {
    const RunResult result = project(c.points);
    EXPECT_THAT(result, EndsWith(1)) << c.points.substr(0, 80);
    EXPECT_THAT(result.err, AllOf(HasSubstr("error: standard input" + c.place), HasSubstr(c.found),
                                  HasSubstr(c.expected)));
    ++num_refused;
  }
  EXPECT_EQ(num_refused, 22u);
  const ScratchFolder scratch;
  scratch.write("points.csv", "0,0,one\n");
  EXPECT_THAT(runAlidade({"project", dataPath("camera.yaml"), scratch.path("points.csv")}).err,
              HasSubstr(scratch.path("points.csv") + ":1: found 'one' as z"));
  EXPECT_THAT(runAlidade({"project", dataPath("camera.yaml"), scratch.path("point.csv")}).err,
              HasSubstr("did you mean '" + scratch.path("points.csv") + "'?"));
  EXPECT_THAT(runAlidade({"project", dataPath("camera.yaml"), scratch.path()}), EndsWith(1));
}

TEST(Project, TakesNoPointsForAnAnswer) {
  const RunResult table = project("");
  ASSERT_THAT(table, EndsWith(0));
  EXPECT_EQ(table.out, "u,v,status\n");
  EXPECT_EQ(table.err, "no points\n");
  const RunResult json = project("", {"--json"});
  ASSERT_THAT(json, EndsWith(0));
  EXPECT_THAT(nlohmann::json::parse(json.out).at("points"), IsEmpty());
}

TEST(Project, WritesValidJson) {
  const RunResult result = project("0,0,1\n0,0,-1\n", {"--json", "--quiet"});
  ASSERT_THAT(result, EndsWith(0));
  EXPECT_EQ(result.err, "");
  const auto points = nlohmann::json::parse(result.out).at("points");
  ASSERT_EQ(points.size(), 2u);
  EXPECT_EQ(points[0].at("status"), "ok");
  EXPECT_TRUE(points[0].at("u").is_number());
  EXPECT_EQ(points[1].at("status"), "behind");
  EXPECT_TRUE(points[1].at("u").is_null());
}

TEST(Unproject, IsTheWayBack) {
  const std::string points = manyPoints(1000);
  const RunResult pixels = project(points);
  ASSERT_THAT(pixels, EndsWith(0));
  const RunResult rays = runAlidade({"unproject", dataPath("camera.yaml")}, {.input = pixels.out});
  ASSERT_THAT(rays, EndsWith(0));
  const RunResult again = project(rays.out);
  ASSERT_THAT(again, EndsWith(0));
  const auto expected = rowsOf(pixels.out);
  const auto found = rowsOf(again.out);
  ASSERT_EQ(expected.size(), 1000u);
  ASSERT_EQ(found.size(), expected.size());
  double worst = 0;
  for (std::size_t i = 0; i < found.size(); ++i) {
    for (const std::size_t k : {0u, 1u})
      worst = std::max(worst, std::abs(numberIn(found[i].at(k)) - numberIn(expected[i].at(k))));
  }
  constexpr double kRoundTripPx = 1e-7;  // an iterative inverse
  EXPECT_LE(worst, kRoundTripPx);
}

TEST(Unproject, SaysWhereNoRayLeads) {
  const RunResult result =
      runAlidade({"unproject", dataPath("camera.yaml")}, {.input = "320,240\n1e6,0\nnan,0\n"});
  ASSERT_THAT(result, EndsWith(0));
  const auto rows = rowsOf(result.out);
  ASSERT_EQ(rows.size(), 3u);
  EXPECT_EQ(rows[0].at(3), "ok");
  EXPECT_EQ(rows[1].at(3), "outside");
  EXPECT_EQ(rows[2], (std::vector<std::string>{"nan", "nan", "nan", "outside"}));
}

}  // namespace
}  // namespace alidade
