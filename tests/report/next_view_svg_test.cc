// SPDX-License-Identifier: MIT
#include "alidade/report/figures/next_view_svg.h"

#include <regex>
#include <string>

#include <gmock/gmock.h>

#include "alidade/calibrate/calibrator.h"
#include "report/svg_checks.h"
#include "support/simulated_set.h"

namespace alidade {
namespace {

using testing::HasSubstr;

struct Drawn {
  Calibration result;
  Guidance guidance;
  SimulatedSet set;
};

Drawn makeDrawn() {
  const AnyCamera camera =
      AnyCamera::make("radtan", std::vector<double>{535, 534, 322, 238, -0.28, 0.08, 8e-4, -4e-4, -0.01});
  SimulatedSet set = simulateSet(camera, {.width = 640, .height = 480}, 5, 0.1, 11);
  Calibration result = calibrate(set.board, set.views, {.model = "radtan"});
  Guidance guidance = guide(result, set.views);
  return {.result = std::move(result), .guidance = std::move(guidance), .set = std::move(set)};
}

TEST(NextViewSvg, DrawsCornersUncertaintyAndTheBoard) {
  Drawn drawn = makeDrawn();
  ASSERT_TRUE(drawn.guidance.next && drawn.guidance.is_determined);
  const std::string svg = nextViewSvg(drawn.result, drawn.set.views, drawn.guidance);
  expectGoodSvg(svg);
  EXPECT_EQ(countOf(svg, "<circle"), 6u * 54u);  // five views and the next
  EXPECT_GT(countOf(svg, "<rect"), 40u * 30u);
  EXPECT_THAT(svg, HasSubstr("worst projection uncertainty from"));
}

TEST(NextViewSvg, MarksTheSidesThatAreNearer) {
  Drawn drawn = makeDrawn();
  NextView& next = *drawn.guidance.next;
  const SO3 rotation = tiltedBoard({.right_rad = -0.5, .lower_rad = 0});
  next.camera_from_board = {rotation, Eigen::Vector3d(0, 0, 0.4) - rotation * drawn.set.board.middle()};
  next.sighting = sightBoard(drawn.result.camera(), drawn.set.board, next.camera_from_board);
  const std::string svg = nextViewSvg(drawn.result, drawn.set.views, drawn.guidance);
  expectGoodSvg(svg);
  // One thick line and one word, both left of the image's middle.
  EXPECT_EQ(countOf(svg, ">nearer<"), 1u);
  std::smatch label;
  ASSERT_TRUE(std::regex_search(svg, label, std::regex("<text x=\"([-0-9.]+)\"[^>]*>nearer<")));
  EXPECT_LT(std::stod(label[1]), 260);
}

TEST(NextViewSvg, DrawsWhatThereIsWhereNothingIsKnown) {
  Drawn drawn = makeDrawn();
  drawn.result.uncertainty.covariance.reset();
  drawn.guidance = {};
  const std::string svg = nextViewSvg(drawn.result, drawn.set.views, drawn.guidance);
  expectGoodSvg(svg);
  EXPECT_EQ(countOf(svg, "<circle"), 5u * 54u);
  EXPECT_THAT(svg, HasSubstr("no further view"));
}

}  // namespace
}  // namespace alidade
