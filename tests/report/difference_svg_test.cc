// SPDX-License-Identifier: MIT
#include "alidade/report/figures/difference_svg.h"

#include <regex>
#include <string>
#include <vector>

#include <gmock/gmock.h>

#include "alidade/report/canvas/figure_canvas.h"
#include "report/svg_checks.h"
#include "support/image_sizes.h"

namespace alidade {
namespace {

using testing::AllOf;
using testing::HasSubstr;
using testing::Not;

AnyCamera pinhole(double f) {
  return AnyCamera::make("pinhole", std::vector<double>{f, f, 319.5, 239.5});
}

std::string drawn(const AnyCamera& a, const AnyCamera& b, const DifferenceOptions& options = {},
                  const std::vector<std::string>& lines = {}) {
  const ComparedCamera in_a{&a, kVga, {}};
  const ComparedCamera in_b{&b, kVga, {}};
  const std::string svg = differenceSvg(in_a, in_b, projectionDifference(in_a, in_b, options), lines);
  expectGoodSvg(svg);
  return svg;
}

struct Arrow {
  double x = 0;
  double y = 0;
  double dx = 0;
  double dy = 0;
};

// The shafts of the arrows over the image; heads have three points.
std::vector<Arrow> arrowsIn(const std::string& svg) {
  const std::size_t start = svg.find("<g class=\"arrows\">");
  const std::string group = svg.substr(start, svg.find("</g>", start) - start);
  const std::regex shaft("M([-0-9.]+),([-0-9.]+) L([-0-9.]+),([-0-9.]+) (?=[M\"])");
  std::vector<Arrow> arrows;
  for (std::sregex_iterator i(group.begin(), group.end(), shaft), end; i != end; ++i) {
    const auto number = [&](int k) { return std::stod((*i)[static_cast<std::size_t>(k)]); };
    arrows.push_back({number(1), number(2), number(3) - number(1), number(4) - number(2)});
  }
  return arrows;
}

TEST(DifferenceSvg, DrawsALongerFocalLengthAsArrowsFromTheMiddle) {
  const std::string svg = drawn(pinhole(500), pinhole(505), {.freed = std::nullopt});
  const std::vector<Arrow> arrows = arrowsIn(svg);
  int num_outward = 0;
  const Eigen::Vector2d middle = imageArea(kVga, FigureCanvas::kFileWidth).at(319.5, 239.5);
  for (const Arrow& arrow : arrows)
    num_outward += (arrow.x - middle.x()) * arrow.dx + (arrow.y - middle.y()) * arrow.dy > 0 ? 1 : 0;
  EXPECT_GT(num_outward, 150);
  EXPECT_EQ(num_outward, static_cast<int>(arrows.size()));
  EXPECT_GE(countOf(svg, "<rect"), 40U * 30U);
  // A corner is 399.3 px from the middle: half of what it moves from A to B, and half of that back.
  EXPECT_THAT(svg, AllOf(HasSubstr(">at most 3.973 px<"), HasSubstr(">0 px<"),
                         HasSubstr("from the projection by A")));
  EXPECT_THAT(svg, Not(HasSubstr("seen by")));
}

TEST(DifferenceSvg, CutsArrowsWhereTheScaleEndsAndSaysSo) {
  const AnyCamera a = AnyCamera::make("radtan", std::vector<double>{500, 500, 319.5, 239.5, 0, 0, 0, 0, 0});
  const AnyCamera b =
      AnyCamera::make("radtan", std::vector<double>{500, 500, 319.5, 239.5, 0, 0, 0, 0, 0.05});
  const std::string svg = drawn(a, b, {.freed = std::nullopt});
  EXPECT_THAT(svg, AllOf(HasSubstr(">more<"), HasSubstr(" px or more, from the projection by A")));
  double longest = 0;
  for (const Arrow& arrow : arrowsIn(svg)) longest = std::max(longest, std::hypot(arrow.dx, arrow.dy));
  EXPECT_NEAR(longest, 0.8 * imageArea(kVga, FigureCanvas::kFileWidth).box.sizes().x() / 18, 0.2);
}

TEST(DifferenceSvg, HatchesWhatOneOrNoneOfTheCamerasSees) {
  const AnyCamera wide =
      AnyCamera::make("kannala_brandt", std::vector<double>{90, 90, 319.5, 239.5, 0, 0, 0, 0});
  const AnyCamera wider =
      AnyCamera::make("kannala_brandt", std::vector<double>{85, 85, 319.5, 239.5, 0, 0, 0, 0});
  const std::string svg = drawn(wide, wider);
  EXPECT_THAT(svg,
              AllOf(HasSubstr(">seen by only one of the cameras<"), HasSubstr(">seen by neither camera<")));
  EXPECT_GT(countOf(svg, "fill=\"url(#one)\""), 20U);
  EXPECT_GT(countOf(svg, "fill=\"url(#neither)\""), 100U);
  EXPECT_GT(arrowsIn(svg).size(), 50U);
}

TEST(DifferenceSvg, DrawsRoundingAsNoDifference) {
  const std::string svg = drawn(pinhole(500), pinhole(500));
  EXPECT_TRUE(arrowsIn(svg).empty());
  EXPECT_THAT(svg, AllOf(HasSubstr(">0.001 px<"), Not(HasSubstr("at most"))));
  EXPECT_EQ(countOf(svg, "fill=\"" + rampColour(0) + "\""), 40U * 30U + 1);  // and the scale's first step
}

TEST(DifferenceSvg, StaysSmallForALargeGridAndShowsItsLargest) {
  const std::string svg =
      drawn(pinhole(500), pinhole(505), {.freed = std::nullopt, .columns = 640, .rows = 480});
  EXPECT_LT(countOf(svg, "<rect"), 120U * 120U + 100U);
  EXPECT_THAT(svg, AllOf(HasSubstr("6x6 pixels of the grid"), HasSubstr("at most 3.973 px")));
}

TEST(DifferenceSvg, KeepsNamesFromBeingXml) {
  const std::string svg = drawn(pinhole(500), pinhole(505), {}, {"A: <b>&\".yaml", "B: \xC3\xA4.yaml"});
  EXPECT_THAT(svg, AllOf(HasSubstr("A: &lt;b&gt;&amp;&quot;.yaml"), HasSubstr("B: \xC3\xA4.yaml"),
                         Not(HasSubstr("<b>"))));
}

}  // namespace
}  // namespace alidade
