// SPDX-License-Identifier: MIT
// Grids of circles, rendered from what would be printed of them.
#include "alidade/detect/board/find_board.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <numbers>
#include <utility>

#include <gmock/gmock.h>

#include "alidade/core/random.h"
#include "alidade/detect/detect_images.h"
#include "alidade/print/ink_of_board.h"
#include "alidade/simulate/observe.h"
#include "alidade/simulate/random_views.h"
#include "alidade/simulate/render.h"
#include "alidade/target/board_spec.h"

namespace alidade {
namespace {

using testing::HasSubstr;

constexpr ImageSize kSize{960, 600};

AnyCamera someCamera() {
  return AnyCamera::make("radtan",
                         std::vector<double>{720, 720, 479.5, 299.5, -0.1, 0.03, 0.0005, -0.0003, 0});
}

RenderOptions someLight(std::uint64_t seed) {
  RenderOptions options;
  options.blur_px = 1;
  options.read_noise = 2;
  options.full_well_electrons = 0;
  options.falloff = 0.2;
  options.samples = 377;
  options.seed = seed;
  return options;
}

GrayImage photoOf(const Board& board, const SE3& pose, const RenderOptions& light) {
  return Renderer(someCamera(), kSize).render(inkOf(board), pose, light);
}

std::vector<SE3> someViews(const Board& board, int count, double max_roll_deg, std::uint64_t seed) {
  Random random(seed);
  return randomViews(someCamera(), kSize, board, count, random,
                     {.max_tilt_deg = 55, .max_roll_deg = max_roll_deg, .min_fill = 0.6, .max_fill = 0.95});
}

struct CircleErrors {
  std::size_t num_found = 0;
  std::size_t num_visible = 0;
  Eigen::Vector2d sum{0, 0};
  double square_sum = 0;
  double score_sum = 0;  // squares over the stated variances

  [[nodiscard]] double rms() const { return std::sqrt(square_sum / (2.0 * static_cast<double>(num_found))); }
  [[nodiscard]] double scoreRms() const {
    return std::sqrt(score_sum / (2.0 * static_cast<double>(num_found)));
  }
};

void compare(const Detection& detection, const View& truth, CircleErrors& errors) {
  errors.num_visible += truth.corners.size();
  for (const Corner& corner : detection.corners) {
    const auto exact = std::ranges::find(truth.corners, corner.id, &Corner::id);
    ASSERT_NE(exact, truth.corners.end());
    const Eigen::Vector2d off = corner.pixel - exact->pixel;
    ++errors.num_found;
    errors.sum += off;
    errors.square_sum += off.squaredNorm();
    errors.score_sum += off.squaredNorm() / (corner.sigma_px * corner.sigma_px);
  }
}

TEST(CircleGrids, AreFoundWhereTheirCentroidsAre) {
  struct Case {
    std::string spec;
    bool is_inverted;
    double max_roll_deg;
  };
  // Where a turned grid looks the same, ids are only as expected if it is not turned much.
  const std::vector<Case> cases = {{"circles:10x8:25mm:15mm", false, 20},
                                   {"circles:7x5:30mm:24mm", true, 20},
                                   {"acircles:4x11:20mm:14mm", false, 180},
                                   {"acircles:5x7:20mm:18mm", true, 180}};
  for (const Case& c : cases) {
    const Board board = parseBoardSpec(c.spec);
    CircleErrors errors;
    std::uint64_t seed = 3;
    for (const SE3& pose : someViews(board, 4, c.max_roll_deg, 11)) {
      RenderOptions light = someLight(seed++);
      if (c.is_inverted) std::swap(light.dark_level, light.bright_level);
      const Detection detection = findBoard(photoOf(board, pose, light), board);
      EXPECT_TRUE(detection.found()) << c.spec << ": " << detection.detail;
      compare(detection, exactView(someCamera(), kSize, board, pose, ""), errors);
    }
    std::printf("%s: %zu of %zu, %.4f px, %.2f of the stated sigmas, bias %.4f %.4f\n", c.spec.c_str(),
                errors.num_found, errors.num_visible, errors.rms(), errors.scoreRms(),
                errors.sum.x() / static_cast<double>(errors.num_found),
                errors.sum.y() / static_cast<double>(errors.num_found));
    EXPECT_EQ(errors.num_visible, 4U * static_cast<std::size_t>(board.numCorners()));
    EXPECT_EQ(errors.num_found, errors.num_visible);
    EXPECT_LE(errors.rms(), 0.01);
    EXPECT_GE(errors.scoreRms(), 0.8);
    EXPECT_LE(errors.scoreRms(), 1.3);
    EXPECT_LE((errors.sum / static_cast<double>(errors.num_found)).norm(), 0.001);
  }
}

TEST(CircleGrids, OfAnyOrientationHaveTheirColumnsToTheRight) {
  const Board board = CircleGrid{.columns = 5, .rows = 4, .spacing_m = 0.05, .diameter_m = 0.03};
  int num_checked = 0;
  for (const double roll_deg : {-170.0, -100.0, -80.0, -10.0, 0.0, 30.0, 80.0, 100.0, 175.0}) {
    const double roll = roll_deg * std::numbers::pi / 180;
    const SO3 turn = SO3::exp({0, 0, roll});
    const SE3 pose{turn, Eigen::Vector3d(0, 0, 0.5) - turn * board.middle()};
    const Detection detection = findBoard(photoOf(board, pose, someLight(7)), board);
    ASSERT_TRUE(detection.found()) << roll_deg << ": " << detection.detail;
    const Eigen::Vector2d step = detection.corners[1].pixel - detection.corners[0].pixel;
    EXPECT_TRUE(std::abs(step.x()) >= std::abs(step.y()) ? step.x() > 0 : step.y() > 0) << roll_deg;
    ++num_checked;
  }
  EXPECT_EQ(num_checked, 9);
}

TEST(CircleGrids, MayBeCoveredInside) {
  const Board board = CircleGrid{.columns = 8, .rows = 6, .spacing_m = 0.03, .diameter_m = 0.02};
  const SE3 pose{SO3::exp({0.3, 0.2, 0.1}), {-0.1, -0.07, 0.35}};
  GrayImage image = photoOf(board, pose, someLight(2));
  const View truth = exactView(someCamera(), kSize, board, pose, "");
  const Eigen::Vector2d at = truth.corners[static_cast<std::size_t>(2 * 8 + 3)].pixel;
  for (int y = static_cast<int>(at.y()) - 30; y < at.y() + 50; ++y) {
    for (int x = static_cast<int>(at.x()) - 25; x < at.x() + 60; ++x)
      image.pixels[static_cast<std::size_t>(y * kSize.width + x)] = 140;
  }
  const Detection detection = findBoard(image, board);
  EXPECT_EQ(detection.reason, DetectionReason::kPartial);
  EXPECT_GE(detection.corners.size(), 40U);
  EXPECT_LE(detection.corners.size(), 46U);
  EXPECT_THAT(detection.detail, HasSubstr("of 48 circles"));
  CircleErrors errors;
  compare(detection, truth, errors);
  EXPECT_LE(errors.scoreRms(), 1.5);
  // What the cover leaves of a disc may look like one; its sigma says how little it is to be trusted.
  Detection sure = detection;
  std::erase_if(sure.corners, [](const Corner& corner) { return corner.sigma_px > 0.02; });
  CircleErrors of_sure;
  compare(sure, truth, of_sure);
  EXPECT_GE(of_sure.num_found, 40U);
  EXPECT_LE(of_sure.rms(), 0.01);
}

TEST(CircleGrids, OfOtherCountsAreRefused) {
  const Board shown = CircleGrid{.columns = 7, .rows = 5, .spacing_m = 0.03, .diameter_m = 0.02};
  const SE3 pose{SO3::exp({0.3, 0.2, 0.1}), {-0.09, -0.06, 0.35}};
  const GrayImage image = photoOf(shown, pose, someLight(2));
  const auto reasonAs = [&](const std::string& spec) { return findBoard(image, parseBoardSpec(spec)); };
  EXPECT_TRUE(reasonAs("circles:7x5:30mm:20mm").found());
  EXPECT_TRUE(reasonAs("circles:5x7:30mm:20mm").found());  // read the other way round
  EXPECT_EQ(reasonAs("circles:8x5:30mm:20mm").reason, DetectionReason::kUnplaced);
  EXPECT_EQ(reasonAs("circles:6x5:30mm:20mm").reason, DetectionReason::kOtherBoard);
  EXPECT_EQ(reasonAs("acircles:4x5:30mm:20mm").reason, DetectionReason::kOtherBoard);
  EXPECT_THAT(reasonAs("circles:6x5:30mm:20mm").detail, HasSubstr("7x5 circles, not 6x5 circles"));
  EXPECT_EQ(reasonAs("checkerboard:7x5:30mm").reason, DetectionReason::kNoBoard);
}

// Their centroids would be taken for those of other discs.
TEST(CircleGrids, OfOtherProportionsAreRefused) {
  const Board shown = CircleGrid{.columns = 7, .rows = 5, .spacing_m = 0.03, .diameter_m = 0.02};
  for (const SE3& pose : someViews(shown, 3, 20, 4)) {
    const GrayImage image = photoOf(shown, pose, someLight(2));
    for (const std::string diameter : {"18mm", "20mm", "22mm"})
      EXPECT_TRUE(findBoard(image, parseBoardSpec("circles:7x5:30mm:" + diameter)).found()) << diameter;
    for (const std::string diameter : {"10mm", "16mm", "25mm"}) {
      const Detection detection = findBoard(image, parseBoardSpec("circles:7x5:30mm:" + diameter));
      EXPECT_EQ(detection.reason, DetectionReason::kOtherBoard) << diameter;
      EXPECT_FALSE(detection.hasCorners());
      EXPECT_THAT(detection.detail, HasSubstr("diameters of 0.6"));
    }
  }
}

// Each disc has six neighbours at the same distance.
TEST(CircleGrids, OfHexagonsAreNoAsymmetricOnes) {
  const Board board = AsymmetricCircleGrid{.columns = 5, .rows = 9, .spacing_m = 0.02, .diameter_m = 0.014};
  BoardInk ink = inkOf(board);
  const double stretch = std::numbers::sqrt3;
  for (Eigen::AlignedBox2d& disc : ink.discs) {
    const Eigen::Vector2d shift(0, (stretch - 1) * disc.center().y());
    disc.translate(shift);
  }
  ink.extent.extend(Eigen::Vector2d(ink.extent.max() + Eigen::Vector2d(0, 0.12)));
  const SE3 pose{SO3::exp({0.3, 0.2, 0.1}), {-0.09, -0.12, 0.45}};
  const GrayImage image = Renderer(someCamera(), kSize).render(ink, pose, someLight(2));
  const Detection detection = findBoard(image, board);
  EXPECT_EQ(detection.reason, DetectionReason::kOtherBoard);
  EXPECT_THAT(detection.detail, HasSubstr("rows of circles are 1.73 times as far apart"));
  EXPECT_FALSE(seenCircleGrid(image).has_value());
}

// As a perforated plate: more than a board can have.
TEST(CircleGrids, AreNotFoundInFieldsOfDots) {
  const ImageSize size{1500, 1200};
  GrayImage image{size, {}};
  for (int y = 0; y < size.height; ++y) {
    for (int x = 0; x < size.width; ++x)
      image.pixels.push_back(std::hypot(x % 12 - 6, y % 12 - 6) < 4 ? 20 : 230);
  }
  EXPECT_FALSE(findBoard(image, CircleGrid{.columns = 10, .rows = 8, .spacing_m = 0.02, .diameter_m = 0.014})
                   .hasCorners());
  EXPECT_FALSE(seenCircleGrid(image).has_value());
}

TEST(CircleGrids, OfAnImageWithoutThemAreNotFound) {
  const Board board = Checkerboard{.columns = 9, .rows = 6, .square_m = 0.025};
  const SE3 pose{SO3::exp({0.3, 0.2, 0.1}), {-0.09, -0.06, 0.35}};
  const Board asked = CircleGrid{.columns = 9, .rows = 6, .spacing_m = 0.025, .diameter_m = 0.015};
  EXPECT_EQ(findBoard(photoOf(board, pose, someLight(2)), asked).reason, DetectionReason::kNoBoard);
  Random random(6);
  int num_checked = 0;
  for (const ImageSize size :
       {ImageSize{1, 1}, ImageSize{2, 3}, ImageSize{1, 5000}, ImageSize{5000, 1}, ImageSize{11, 12},
        ImageSize{40, 3000}, ImageSize{2401, 13}, ImageSize{900, 700}}) {
    GrayImage image{size, std::vector<std::uint8_t>(static_cast<std::size_t>(size.width) *
                                                    static_cast<std::size_t>(size.height))};
    EXPECT_FALSE(findBoard(image, asked).hasCorners());
    for (std::uint8_t& pixel : image.pixels) pixel = static_cast<std::uint8_t>(random.index(256));
    EXPECT_FALSE(findBoard(image, asked).hasCorners()) << size.width << "x" << size.height;
    ++num_checked;
  }
  EXPECT_EQ(num_checked, 8);
}

TEST(CircleGrids, OfTheSameCountsTwiceAreRefused) {
  const Board board = CircleGrid{.columns = 4, .rows = 4, .spacing_m = 0.03, .diameter_m = 0.02};
  BoardInk both = inkOf(board);
  const Eigen::Vector2d shift(0.2, 0);
  for (const Eigen::AlignedBox2d& disc : inkOf(board).discs) both.discs.push_back(disc.translated(shift));
  both.extent.extend(Eigen::Vector2d(both.extent.max() + shift));
  const SE3 pose{SO3::exp({0.1, -0.1, 0.1}), {-0.14, -0.05, 0.4}};
  const GrayImage image = Renderer(someCamera(), kSize).render(both, pose, someLight(2));
  EXPECT_EQ(findBoard(image, board).reason, DetectionReason::kSeveralBoards);
}

TEST(SeenCircleGrid, TellsKindAndCounts) {
  struct Case {
    std::string spec;
    CircleCounts counts;
    double diameter;
  };
  const std::vector<Case> cases = {{"circles:8x10:25mm:15mm", {false, 10, 8}, 0.6},
                                   {"acircles:4x11:20mm:14mm", {true, 4, 11}, 0.7}};
  for (const Case& c : cases) {
    const Board board = parseBoardSpec(c.spec);
    for (const SE3& pose : someViews(board, 3, 180, 5)) {
      const auto seen = seenCircleGrid(photoOf(board, pose, someLight(1)));
      ASSERT_TRUE(seen.has_value()) << c.spec;
      EXPECT_EQ(seen->counts, c.counts) << c.spec;
      EXPECT_NEAR(seen->diameter.value(), c.diameter, 0.01) << c.spec;
    }
  }
  const Board checkerboard = Checkerboard{.columns = 9, .rows = 6, .square_m = 0.025};
  const SE3 pose{SO3::exp({0.3, 0.2, 0.1}), {-0.09, -0.06, 0.35}};
  EXPECT_FALSE(seenCircleGrid(photoOf(checkerboard, pose, someLight(1))).has_value());
}

}  // namespace
}  // namespace alidade
