// SPDX-License-Identifier: MIT
// Boards that are guessed from rendered images.
#include "alidade/detect/board/marker_guess.h"

#include <algorithm>
#include <cmath>
#include <cstdlib>

#include <gmock/gmock.h>

#include "alidade/core/random.h"
#include "alidade/detect/board/find_board.h"
#include "alidade/print/ink_of_board.h"
#include "alidade/simulate/random_views.h"
#include "alidade/simulate/render.h"
#include "alidade/target/board_spec.h"

namespace alidade {
namespace {

using testing::HasSubstr;
using testing::IsEmpty;

constexpr ImageSize kGuessSize{800, 600};

AnyCamera guessCamera() {
  return AnyCamera::make("radtan",
                         std::vector<double>{640, 640, 399.5, 299.5, -0.1, 0.03, 0.0005, -0.0003, 0});
}

RenderOptions someLight() {
  RenderOptions options;
  options.blur_px = 0.8;
  options.read_noise = 2;
  options.full_well_electrons = 0;
  options.samples = 34;
  return options;
}

struct GuessCase {
  std::string spec;
  std::string guess;
  InkOptions ink = {};
  bool is_inverted = false;
};

TEST(MarkerGuess, GivesTheBoardThatIsShown) {
  const std::vector<GuessCase> cases = {
      {"charuco:8x6:30mm:22.5mm:DICT_5X5_1000", "charuco:8x6:SQUARE:MARKER:DICT_5X5_50, with"},
      {"charuco:7x5:30mm:18mm:DICT_4X4_250",
       "charuco:7x5:SQUARE:MARKER:DICT_4X4_50, with the sides of a square and of a marker, which is about "
       "0.6 of it",
       {.is_bright_first = true}},
      {"charuco:5x7:30mm:24mm:DICT_APRILTAG_25h9", "charuco:5x7:SQUARE:MARKER:DICT_APRILTAG_25h9", {}, true},
      {"charuco:9x12:30mm:24mm:DICT_6X6_250", "charuco:9x12:SQUARE:MARKER:DICT_6X6_100"},
      {"aprilgrid:5x4:88mm:0.3", "an AprilGrid of 5x4 tags: --board aprilgrid:5x4:TAG:0.3, with"},
      {"aprilgrid:4x3:40mm:0.25:5", "aprilgrid:4x3:TAG:0.25:5", {.april_border = 1}},
      {"aprilgrid:5x4:88mm:0.4", "aprilgrid:5x4:TAG:0.4, with", {.april_border = 3}},
      {"aprilgrid:3x2:88mm:0.3", "aprilgrid:3x2:TAG:0.3, with", {.april_border = 8}},
      {"aprilgrid:5x4:88mm:0.3", "aprilgrid:5x4:TAG:0.3, with", {}, true}};
  const Renderer renderer(guessCamera(), kGuessSize);
  std::size_t num_checked = 0;
  for (const GuessCase& c : cases) {
    const Board board = parseBoardSpec(c.spec);
    Random random(12);
    MarkerGuess guess;
    for (const SE3& pose :
         randomViews(guessCamera(), kGuessSize, board, 2, random,
                     {.max_tilt_deg = 40, .max_roll_deg = 180, .min_fill = 0.7, .max_fill = 0.95})) {
      RenderOptions light = someLight();
      if (c.is_inverted) std::swap(light.dark_level, light.bright_level);
      guess.look(renderer.render(inkOf(board, c.ink), pose, light));
    }
    EXPECT_THAT(guess.text(), HasSubstr(c.guess)) << c.spec;
    ++num_checked;
  }
  EXPECT_EQ(num_checked, 9U);
}

// With lengths in place of their names.
TEST(MarkerGuess, GivesASpecThatFindsTheBoard) {
  const Renderer renderer(guessCamera(), kGuessSize);
  int num_found = 0;
  for (const std::string spec :
       {"charuco:7x5:35mm:25mm:DICT_5X5_100:17", "charuco:5x8:35mm:25mm:DICT_4X4_250:40",
        "charuco:6x4:35mm:25mm:DICT_6X6_1000:3", "charuco:8x6:35mm:25mm:DICT_5X5_100:24",
        "charuco:6x8:35mm:25mm:DICT_5X5_100", "aprilgrid:4x3:88mm:0.3:7"}) {
    const Board board = parseBoardSpec(spec);
    Random random(17);
    MarkerGuess guess;
    std::vector<GrayImage> images;
    for (const SE3& pose : randomViews(guessCamera(), kGuessSize, board, 2, random,
                                       {.max_tilt_deg = 40, .min_fill = 0.7, .max_fill = 0.95}))
      images.push_back(renderer.render(inkOf(board), pose, someLight()));
    for (const GrayImage& image : images) guess.look(image);
    std::string given = guess.text();
    given = given.substr(given.find("--board ") + 8);
    given.resize(given.find(','));
    for (const auto& [name, length] :
         {std::pair("SQUARE", "35mm"), std::pair("MARKER", "25mm"), std::pair("TAG", "88mm")}) {
      const std::size_t at = given.find(name);
      if (at != std::string::npos) given.replace(at, std::string(name).size(), length);
    }
    const Board proposed = parseBoardSpec(given);
    EXPECT_EQ(proposed.columns(), board.columns()) << given;
    EXPECT_EQ(proposed.markers()->first, board.markers()->first) << given;
    for (const GrayImage& image : images) {
      const Detection detection = std::visit(
          [&]<class Kind>(const Kind& kind) {
            if constexpr (std::is_same_v<Kind, CharucoBoard> || std::is_same_v<Kind, AprilGrid>)
              return findBoard(image, kind);
            return Detection{};
          },
          proposed.kind());
      EXPECT_EQ(detection.corners.size(), static_cast<std::size_t>(board.numCorners())) << given;
      ++num_found;
    }
  }
  EXPECT_EQ(num_found, 12);
}

// The ratio that a guess names: behind "TAG:" or "about ".
double ratioIn(const std::string& text) {
  const auto behind = [&](const std::string& word) {
    const std::size_t at = text.find(word);
    return at == std::string::npos ? 0.0 : std::atof(text.c_str() + at + word.size());
  };
  return text.find(":TAG:") == std::string::npos ? behind("about ") : behind(":TAG:");
}

// Whatever the board's size in the image and its tilt.
TEST(MarkerGuess, MeasuresProportionsToTwoPercent) {
  struct Case {
    std::string spec;
    double ratio;
    InkOptions ink = {};
  };
  const std::vector<Case> cases = {{"charuco:8x11:24mm:18.75mm:DICT_4X4_1000", 0.78125},
                                   {"charuco:7x5:30mm:21.9mm:DICT_6X6_250", 0.73},
                                   {"charuco:6x9:30mm:17mm:DICT_5X5_100", 0.5667},
                                   {"charuco:5x4:50mm:43mm:DICT_4X4_50", 0.86},
                                   {"aprilgrid:6x6:88mm:0.3", 0.3},
                                   {"aprilgrid:6x6:88mm:0.26", 0.26},
                                   {"aprilgrid:7x4:50mm:0.45:12", 0.45, {.april_border = 1}},
                                   {"aprilgrid:4x5:50mm:0.62", 0.62, {.april_border = 3}}};
  struct Shot {
    double least_fill;
    double tilt_deg;
  };
  const Renderer renderer(guessCamera(), kGuessSize);
  int num_checked = 0;
  double worst = 0;
  for (const Case& c : cases) {
    const Board board = parseBoardSpec(c.spec);
    for (const Shot shot : {Shot{0.85, 20}, Shot{0.5, 20}, Shot{0.7, 60}}) {
      Random random(31);
      MarkerGuess guess;
      for (const SE3& pose : randomViews(guessCamera(), kGuessSize, board, 2, random,
                                         {.max_tilt_deg = shot.tilt_deg,
                                         .max_roll_deg = 180,
                                         .min_fill = shot.least_fill,
                                         .max_fill = shot.least_fill + 0.1}))
        guess.look(renderer.render(inkOf(board, c.ink), pose, someLight()));
      const std::string counts = c.spec.substr(0, c.spec.find(':', c.spec.find(':') + 1));
      EXPECT_THAT(guess.text(), HasSubstr("--board " + counts + ":")) << c.spec << " " << shot.least_fill;
      const double off = std::abs(ratioIn(guess.text()) / c.ratio - 1);
      EXPECT_LE(off, 0.02) << c.spec << " " << shot.least_fill << " " << shot.tilt_deg << ": "
                           << guess.text();
      worst = std::max(worst, off);
      ++num_checked;
    }
  }
  std::printf("ratios off by at most %.2f %%\n", 100 * worst);
  EXPECT_EQ(num_checked, 24);
}

// A row that only the fifth image shows counts as well.
TEST(MarkerGuess, CountsWhatAllImagesShowTogether) {
  const Renderer renderer(guessCamera(), kGuessSize);
  for (const std::string spec : {"charuco:8x12:30mm:23mm:DICT_4X4_1000", "aprilgrid:4x7:60mm:0.3"}) {
    const Board board = parseBoardSpec(spec);
    const double height = board.span().y();
    MarkerGuess guess;
    int num_looks = 0;
    for (const double part : {0.2, 0.22, 0.24, 0.4, 0.6, 0.8, 0.8, 0.8}) {
      if (guess.isSure()) break;
      const SE3 pose{SO3::exp({0.15, 0.1, 0.05}), {-0.5 * board.span().x(), -part * height, 0.55 * height}};
      guess.look(renderer.render(inkOf(board), pose, someLight()));
      ++num_looks;
    }
    EXPECT_GE(num_looks, 7) << spec;
    EXPECT_THAT(guess.text(), HasSubstr("--board " + spec.substr(0, spec.find(':', 8)) + ":"));
    EXPECT_TRUE(guess.isSure());
  }
}

// Rows that no marker shows are told by the corners.
TEST(MarkerGuess, CountsRowsWhoseMarkersAreNotRead) {
  const Board board = parseBoardSpec("charuco:6x6:30mm:22mm:DICT_5X5_50");
  const SE3 pose{SO3::exp({0.1, 0.1, 0.05}), {-0.06, -0.06, 0.25}};
  BoardInk ink = inkOf(board);
  // Without the markers' bits: what is left of the last row are its squares.
  std::erase_if(ink.boxes, [](const Eigen::AlignedBox2d& box) {
    return box.min().y() > 0.12 && box.sizes().maxCoeff() < 0.029;
  });
  MarkerGuess guess;
  guess.look(Renderer(guessCamera(), kGuessSize).render(ink, pose, someLight()));
  EXPECT_THAT(guess.text(), HasSubstr("charuco:6x6:"));
}

TEST(MarkerGuess, SaysNothingWithoutMarkersBesideOneAnother) {
  const SE3 pose{SO3::exp({0.1, 0.1, 0.05}), {-0.1, -0.06, 0.3}};
  const Board checkerboard = parseBoardSpec("checkerboard:9x6:25mm");
  Random random(2);
  GrayImage noise{{320, 240}, std::vector<std::uint8_t>(320UL * 240)};
  for (std::uint8_t& pixel : noise.pixels) pixel = static_cast<std::uint8_t>(random.index(256));
  MarkerGuess guess;
  EXPECT_THAT(guess.text(), IsEmpty());
  guess.look(Renderer(guessCamera(), kGuessSize).render(inkOf(checkerboard), pose, someLight()));
  guess.look(noise);
  guess.look(GrayImage{{1, 1}, {0}});
  EXPECT_THAT(guess.text(), IsEmpty());
  EXPECT_FALSE(guess.isSure());
}

}  // namespace
}  // namespace alidade
