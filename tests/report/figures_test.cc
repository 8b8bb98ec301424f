// SPDX-License-Identifier: MIT
#include <cmath>
#include <numbers>
#include <regex>
#include <string>
#include <vector>

#include <fmt/format.h>
#include <gmock/gmock.h>

#include "alidade/report/canvas/level_map.h"
#include "alidade/report/data/distinct_parts.h"
#include "alidade/report/figures/camera_figures.h"
#include "alidade/target/board_spec.h"
#include "report/svg_checks.h"

namespace alidade {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;

// A camera that saw a board from four sides; one of the board's points is printed beside its place.
ReportData withMisplacedPoint(int id, const Eigen::Vector3d& by_m) {
  ReportData data{.camera = AnyCamera::make(
                      "radtan", std::vector<double>{535, 534, 322, 238, -0.28, 0.08, 8e-4, -4e-4, -0.01}),
                  .size = {640, 480}};
  data.boards = {{.target = parseBoardSpec("checkerboard:9x6:25mm"), .shape = {}}};
  data.coordinate_sigma_px = 0.1;
  for (int k = 0; k < 4; ++k) {
    ReportedView view{.image = std::to_string(k)};
    // Turned about the line of sight too: what stands still on the board moves in the image.
    const SO3 rotation = SO3::exp(Eigen::Vector3d(0.3 * std::cos(1.6 * k), 0.3 * std::sin(1.6 * k), 1.5 * k));
    view.camera_from_board = {rotation,
                              Eigen::Vector3d(0, 0, 0.4) - rotation * data.boards[0].target.middle()};
    for (int i = 0; i < data.boards[0].target.numCorners(); ++i) {
      const Eigen::Vector3d& point = data.boards[0].target.corner(i);
      const Projection expected = data.camera.project(view.camera_from_board * point);
      const Projection seen =
          data.camera.project(view.camera_from_board *
                              Eigen::Vector3d(point + (i == id ? by_m : Eigen::Vector3d::Zero().eval())));
      view.corners.push_back({.id = i, .pixel = seen.pixel, .error_px = expected.pixel - seen.pixel});
    }
    data.views.push_back(view);
  }
  return data;
}

TEST(BoardResiduals, PointToWhereAPointIsPrinted) {
  const Figure figure = boardResidualsFigure(withMisplacedPoint(22, {0.5e-3, 0, 0}), 0);
  expectGoodSvg("<svg " + figure.svg.substr(5));
  EXPECT_THAT(figure.alt, HasSubstr("at most 0.50"));
  // The only arrow: its shaft runs to the right from the third row's fifth point.
  const std::regex shaft("class=\"mean\" d=\".*?M([-0-9.]+),([-0-9.]+) L([-0-9.]+),([-0-9.]+) M");
  std::smatch found;
  ASSERT_TRUE(std::regex_search(figure.svg, found, shaft));
  EXPECT_GT(std::stod(found[3]), std::stod(found[1]) + 10);
  EXPECT_NEAR(std::stod(found[4]), std::stod(found[2]), 0.5);
}

TEST(BoardResiduals, AreNothingForExactViews) {
  const Figure figure = boardResidualsFigure(withMisplacedPoint(0, {0, 0, 0}), 0);
  EXPECT_THAT(figure.alt, HasSubstr("at most 0"));
}

TEST(ViewErrors, DrawABarForEachView) {
  const ReportData data = withMisplacedPoint(3, {1e-3, 0, 0});
  EXPECT_EQ(countOf(viewErrorsFigure(data).svg, "class=\"bar\" data-view"), 4u);
}

// The numbers of an attribute, in their order.
std::vector<double> attributesOf(const std::string& text, const std::string& attribute) {
  std::vector<double> values;
  const std::regex pattern(attribute + "=\"([-0-9.e]+)\"");
  for (std::sregex_iterator i(text.begin(), text.end(), pattern), end; i != end; ++i)
    values.push_back(std::stod((*i)[1]));
  return values;
}

double degreesOf(const AnyCamera& camera, const Eigen::Vector2d& pixel) {
  const auto ray = camera.unproject(pixel);
  return ray ? std::acos(ray->z()) * 180 / std::numbers::pi : std::nan("");
}

TEST(RadialFigure, MarksTheAngleOfTheImageCorner) {
  const ReportData data = withMisplacedPoint(0, {0, 0, 0});
  double corner_deg = 0;
  for (const double u : {0.0, 639.0})
    for (const double v : {0.0, 479.0}) corner_deg = std::max(corner_deg, degreesOf(data.camera, {u, v}));
  const Figure figure = lensFigures(data).at(1);
  ASSERT_TRUE(std::isfinite(corner_deg));
  EXPECT_THAT(figure.svg, HasSubstr(fmt::format("image corner at {:.1f}°", corner_deg)));
  EXPECT_THAT(figure.svg, testing::Not(HasSubstr("no ray")));
}

TEST(RadialFigure, SaysThatAnImageCornerHasNoRay) {
  ReportData data = withMisplacedPoint(0, {0, 0, 0});
  // Its curve turns back inside the image's corners, beyond the middles of its sides.
  data.camera = AnyCamera::make("kannala_brandt", std::vector<double>{300, 300, 319.5, 239.5, 0, -0.2, 0, 0});
  ASSERT_TRUE(std::isnan(degreesOf(data.camera, {0, 0})));
  const Figure figure = lensFigures(data).at(1);
  const double corner_px = std::hypot(319.5, 239.5);
  const std::vector<double> radii = attributesOf(figure.svg, "data-radius");
  ASSERT_EQ(radii.size(), 1u);
  EXPECT_NEAR(radii[0], corner_px, 1e-3);
  EXPECT_THAT(figure.svg, HasSubstr("image corner, 399 px: no ray"));
  EXPECT_THAT(figure.svg, testing::AllOf(HasSubstr("last border pixel with a ray"),
                                         testing::Not(HasSubstr("image corner at"))));
  EXPECT_THAT(figure.reading, HasSubstr("ends before the image corner"));
}

TEST(TiltFigure, PlacesAViewTowardsItsNearerSide) {
  ReportData data = withMisplacedPoint(0, {0, 0, 0});
  data.views[2].tilt.right_rad = 0.4;
  const std::string svg = tiltFigure(CalibrationEvidence{data}).svg;
  const std::regex dot("<circle cx=\"([-0-9.]+)\" cy=\"([-0-9.]+)\" r=\"4\" class=\"view\"");
  std::vector<Eigen::Vector2d> dots;
  for (std::sregex_iterator i(svg.begin(), svg.end(), dot), end; i != end; ++i)
    dots.emplace_back(std::stod((*i)[1]), std::stod((*i)[2]));
  ASSERT_EQ(dots.size(), 4u);
  // The outer ring is at 75 degrees.
  const double ring = attributesOf(svg, "r").at(0);
  EXPECT_NEAR(dots[2].x() - dots[0].x(), ring * 0.4 * 180 / std::numbers::pi / 75, 0.1);
  EXPECT_NEAR(dots[2].y(), dots[0].y(), 0.01);
}

TEST(ViewErrors, NameImagesBrieflyAndMarkThoseOfWarnings) {
  ReportData data = withMisplacedPoint(3, {1e-3, 0, 0});
  for (std::size_t v = 0; v < 4; ++v) data.views[v].image = fmt::format("left0{}.jpg", v + 1);
  data.findings = {{.id = "influential_view", .severity = Severity::kWarning, .cause = "left02.jpg"},
                   {.id = "outliers", .severity = Severity::kNote, .cause = "left03.jpg"}};
  const std::string svg = viewErrorsFigure(data).svg;
  EXPECT_THAT(svg, testing::AllOf(HasSubstr(">01<"), HasSubstr(">04<"), HasSubstr("named in a warning")));
  EXPECT_THAT(svg, HasSubstr("class=\"bar named\" data-view=\"1\""));
  EXPECT_EQ(countOf(svg, "class=\"bar named\" data-view"), 1u);
}

TEST(DistinctParts, LeaveOutWhatAllNamesShare) {
  EXPECT_THAT(distinctParts({"a/left01.jpg", "a/left02.jpg", "a/left10.jpg"}), ElementsAre("01", "02", "10"));
  EXPECT_THAT(distinctParts({"7", "8", "10"}), ElementsAre("7", "8", "10"));
  EXPECT_THAT(distinctParts({"left.png", "left2.png"}), ElementsAre("left.png", "left2.png"));
  EXPECT_THAT(distinctParts({"x.png", "y.jpg"}), ElementsAre("x.png", "y.jpg"));
  EXPECT_THAT(distinctParts({"one.png"}), ElementsAre("one"));
}

// Areas by the shoelace formula.
double areaOf(const std::string& path) {
  const std::regex point("([MLl]?)([-0-9.]+),([-0-9.]+)");  // without a letter: a step like the last one
  std::vector<Eigen::Vector2d> ring;
  double area = 0;
  bool is_step = false;
  const auto closeRing = [&] {
    for (std::size_t i = 0; i < ring.size(); ++i) {
      const Eigen::Vector2d& a = ring[i];
      const Eigen::Vector2d& b = ring[(i + 1) % ring.size()];
      area += 0.5 * (a.x() * b.y() - a.y() * b.x());
    }
    ring.clear();
  };
  for (std::sregex_iterator i(path.begin(), path.end(), point), end; i != end; ++i) {
    if ((*i)[1] == "M") closeRing();
    if ((*i)[1] != "") is_step = (*i)[1] == "l";
    const Eigen::Vector2d from = is_step && !ring.empty() ? ring.back() : Eigen::Vector2d(0, 0);
    ring.push_back(from + Eigen::Vector2d(std::stod((*i)[2]), std::stod((*i)[3])));
  }
  closeRing();
  return area;
}

LevelMap slope() {
  LevelMap map{.columns = 11, .rows = 6};
  for (int row = 0; row < map.rows; ++row) {
    for (int column = 0; column < map.columns; ++column) {
      map.values.push_back(column);
      map.points.emplace_back(10.0 * column, 10.0 * row);
    }
  }
  return map;
}

TEST(LevelMap, DrawsTheAreaFromALevelOn) {
  EXPECT_NEAR(areaOf(areaFrom(slope(), -1)), 100 * 50, 1e-6);
  EXPECT_NEAR(areaOf(areaFrom(slope(), 2.5)), 75 * 50, 1e-6);
  EXPECT_EQ(areaFrom(slope(), 11), "");
  for (const ContourSegment& segment : contourAt(slope(), 2.5)) {
    EXPECT_NEAR(segment.first.x(), 25, 1e-9);
    EXPECT_NEAR(segment.second.x(), 25, 1e-9);
  }
  EXPECT_EQ(contourAt(slope(), 2.5).size(), 5u);
}

TEST(LevelMap, LeavesOutWhereThereIsNoValue) {
  LevelMap map = slope();
  map.values[0] = std::nan("");
  EXPECT_NEAR(areaOf(areaFrom(map, -1)), 100 * 50 - 100, 1e-6);
}

TEST(FigureCanvas, MarksRoundValues) {
  EXPECT_THAT(roundTicks(0, 10, 5), ElementsAre(0, 2, 4, 6, 8, 10));
  EXPECT_THAT(roundTicks(-0.5, 639.5, 7), ElementsAre(0, 100, 200, 300, 400, 500, 600));
  EXPECT_THAT(roundTicks(1, 1, 5), ElementsAre());
  EXPECT_EQ(shortNumber(0.12345), "0.123");
  EXPECT_EQ(twoDigits(0.0997), "0.100");  // as in the summary
  EXPECT_EQ(twoDigits(12.3), "12");
  EXPECT_EQ(coordinate(-0.001), "0");
  EXPECT_EQ(escapedMarkup("<a b=\"c\">&'\x01"), "&lt;a b=&quot;c&quot;&gt;&amp;&#39;\\x01");
}

}  // namespace
}  // namespace alidade
