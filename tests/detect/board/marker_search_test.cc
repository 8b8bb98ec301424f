// SPDX-License-Identifier: MIT
// ChArUco boards and AprilGrids, rendered from what would be printed of them.
#include <algorithm>
#include <cmath>

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

constexpr ImageSize kSearchSize{960, 600};

AnyCamera searchCamera() {
  return AnyCamera::make("radtan",
                         std::vector<double>{720, 720, 479.5, 299.5, -0.1, 0.03, 0.0005, -0.0003, 0});
}

RenderOptions searchLight(std::uint64_t seed) {
  RenderOptions options;
  options.blur_px = 1;
  options.read_noise = 2;
  options.full_well_electrons = 0;
  options.falloff = 0;
  options.samples = 377;
  options.seed = seed;
  return options;
}

std::vector<SE3> someViews(const Board& board, int count, std::uint64_t seed) {
  Random random(seed);
  return randomViews(searchCamera(), kSearchSize, board, count, random,
                     {.max_tilt_deg = 55, .max_roll_deg = 180, .min_fill = 0.6, .max_fill = 0.95});
}

struct Deviations {
  std::size_t num_visible = 0;
  std::size_t num_found = 0;
  double square_sum = 0;
  double worst_px = 0;
  Eigen::Vector2d sum{0, 0};

  [[nodiscard]] double rms() const { return std::sqrt(square_sum / (2.0 * static_cast<double>(num_found))); }
};

void compare(const Detection& detection, const View& truth, Deviations& deviations) {
  deviations.num_visible += truth.corners.size();
  for (const Corner& corner : detection.corners) {
    const auto exact = std::ranges::find(truth.corners, corner.id, &Corner::id);
    ASSERT_NE(exact, truth.corners.end());
    const Eigen::Vector2d off = corner.pixel - exact->pixel;
    ++deviations.num_found;
    deviations.square_sum += off.squaredNorm();
    deviations.sum += off;
    deviations.worst_px = std::max(deviations.worst_px, off.norm());
  }
}

// The other way round than the image, as in a mirror.
TEST(MarkerSearch, FindsMirroredBoards) {
  std::size_t num_boards = 0;
  std::size_t num_found = 0;
  for (const char* spec : {"charuco:8x6:30mm:22mm:DICT_5X5_100", "charuco:4x5:54mm:40.5mm:DICT_4X4_1000",
                           "aprilgrid:6x5:88mm:0.3"}) {
    const Board board = parseBoardSpec(spec);
    const Renderer renderer(searchCamera(), kSearchSize);
    for (const SE3& pose : someViews(board, 12, 4)) {
      ++num_boards;
      const GrayImage image = renderer.render(inkOf(board), pose, searchLight(num_boards));
      const Detection upright = findBoard(image, board);
      const Detection mirrored = findBoard(mirroredOf(image), board);
      EXPECT_NEAR(static_cast<double>(mirrored.corners.size()), static_cast<double>(upright.corners.size()),
                  2)
          << spec;
      num_found += mirrored.hasCorners() ? 1 : 0;
      for (const Corner& corner : mirrored.corners) {
        const auto other = std::ranges::find(upright.corners, corner.id, &Corner::id);
        if (other == upright.corners.end()) continue;
        const Eigen::Vector2d back(kSearchSize.width - 1 - corner.pixel.x(), corner.pixel.y());
        EXPECT_LT((back - other->pixel).norm(), 0.02) << spec;
      }
    }
  }
  EXPECT_EQ(num_boards, 36u);
  EXPECT_EQ(num_found, 36u);
}

struct PrintCase {
  std::string spec;
  InkOptions ink = {};
  bool is_inverted = false;
};

TEST(MarkerBoards, AreFoundHoweverTheyArePrinted) {
  const std::string charuco = "charuco:8x6:30mm:23mm:DICT_5X5_100";
  const std::string grid = "aprilgrid:5x4:88mm:0.3";
  const std::vector<PrintCase> cases = {
      {.spec = charuco},
      {.spec = charuco, .ink = {.is_bright_first = true}},
      {.spec = charuco, .is_inverted = true},
      {.spec = grid},
      {.spec = grid, .ink = {.april_border = 1}},
      {.spec = grid, .ink = {.april_border = 3}},
      {.spec = "aprilgrid:5x4:88mm:0.5", .ink = {.april_border = 3}},
      {.spec = "aprilgrid:5x4:88mm:0.5", .is_inverted = true},
      {.spec = grid + ":40"},
  };
  const Renderer renderer(searchCamera(), kSearchSize);
  std::size_t num_checked = 0;
  for (const PrintCase& c : cases) {
    const Board board = parseBoardSpec(c.spec);
    Deviations deviations;
    std::uint64_t seed = 3;
    for (const SE3& pose : someViews(board, 3, 11)) {
      RenderOptions light = searchLight(seed++);
      if (c.is_inverted) std::swap(light.dark_level, light.bright_level);
      const GrayImage image = renderer.render(inkOf(board, c.ink), pose, light);
      compare(findBoard(image, board), exactView(searchCamera(), kSearchSize, board, pose, ""), deviations);
    }
    std::printf("%s: %zu of %zu corners, %.4f px, at most %.3f px\n", c.spec.c_str(), deviations.num_found,
                deviations.num_visible, deviations.rms(), deviations.worst_px);
    EXPECT_EQ(deviations.num_visible, 3U * static_cast<std::size_t>(board.numCorners()));
    EXPECT_GE(deviations.num_found, 0.98 * static_cast<double>(deviations.num_visible)) << c.spec;
    EXPECT_LE(deviations.rms(), 0.015) << c.spec;
    EXPECT_LE(deviations.worst_px, 0.1) << c.spec;
    ++num_checked;
  }
  EXPECT_EQ(num_checked, 9U);
}

// Whatever the width of their tags' borders, black on white and white on black.
TEST(MarkerBoards, OfTagsAreFoundWithEveryBorder) {
  const Board board = parseBoardSpec("aprilgrid:4x3:88mm:0.3");
  const Renderer renderer(searchCamera(), kSearchSize);
  Random random(17);
  const std::vector<SE3> poses =
      randomViews(searchCamera(), kSearchSize, board, 2, random,
                  {.max_tilt_deg = 40, .max_roll_deg = 180, .min_fill = 0.6, .max_fill = 0.95});
  int num_checked = 0;
  for (int border = 1; border <= 8; ++border) {
    for (const bool is_inverted : {false, true}) {
      Deviations deviations;
      for (const SE3& pose : poses) {
        RenderOptions light = searchLight(static_cast<std::uint64_t>(border));
        light.samples = 89;
        if (is_inverted) std::swap(light.dark_level, light.bright_level);
        const GrayImage image = renderer.render(inkOf(board, {.april_border = border}), pose, light);
        const Detection detection = findBoard(image, board);
        EXPECT_TRUE(detection.hasCorners())
            << border << (is_inverted ? ", inverted: " : ": ") << detection.detail;
        compare(detection, exactView(searchCamera(), kSearchSize, board, pose, ""), deviations);
        ++num_checked;
      }
      EXPECT_EQ(deviations.num_visible, 96U);
      EXPECT_EQ(deviations.num_found, 96U) << border << (is_inverted ? ", inverted" : "");
      EXPECT_LE(deviations.rms(), 0.015) << border << (is_inverted ? ", inverted" : "");
      EXPECT_LE(deviations.worst_px, 0.1) << border << (is_inverted ? ", inverted" : "");
    }
  }
  EXPECT_EQ(num_checked, 32);
}

// All four corners of which are found.
int numWholeTags(const Detection& detection, const AprilGrid& grid) {
  int count = 0;
  for (int tag = 0; tag < grid.columns * grid.rows; ++tag) {
    const int first = 4 * grid.columns * (tag / grid.columns) + 2 * (tag % grid.columns);
    const auto isFound = [&](int id) { return std::ranges::count(detection.corners, id, &Corner::id) == 1; };
    const int below = first + 2 * grid.columns;
    count += isFound(first) && isFound(first + 1) && isFound(below) && isFound(below + 1) ? 1 : 0;
  }
  return count;
}

TEST(MarkerBoards, AreAccurateInLargeAndInSmallImages) {
  struct Case {
    std::string spec;
    ImageSize size;
    double most_px;
    int least_tags;  // of an AprilGrid, in each image
  };
  const std::vector<Case> cases = {{"charuco:8x11:24mm:18.75mm:DICT_4X4_1000", {1920, 1200}, 0.015, 0},
                                   {"aprilgrid:6x6:88mm:0.3", {1920, 1200}, 0.012, 34},
                                   {"aprilgrid:6x6:88mm:0.3", {640, 480}, 0.05, 30}};
  int num_checked = 0;
  for (const Case& c : cases) {
    const Board board = parseBoardSpec(c.spec);
    const ImageSize size = c.size;
    const double f = 0.75 * size.width;
    const AnyCamera camera =
        AnyCamera::make("radtan", std::vector<double>{f, f, 0.5 * (size.width - 1), 0.5 * (size.height - 1),
                                                      -0.1, 0.03, 0.0005, -0.0003, 0});
    const Renderer renderer(camera, size);
    Random random(21);
    Deviations deviations;
    int least_tags = 1000;
    std::uint64_t seed = 5;
    for (const SE3& pose :
         randomViews(camera, size, board, 4, random,
                     {.max_tilt_deg = 55, .max_roll_deg = 180, .min_fill = 0.6, .max_fill = 0.95})) {
      RenderOptions light = searchLight(seed++);
      light.samples = 144;
      const Detection detection = findBoard(renderer.render(inkOf(board), pose, light), board);
      compare(detection, exactView(camera, size, board, pose, ""), deviations);
      if (const auto* grid = std::get_if<AprilGrid>(&board.kind()))
        least_tags = std::min(least_tags, numWholeTags(detection, *grid));
    }
    const Eigen::Vector2d bias = deviations.sum / static_cast<double>(deviations.num_found);
    std::printf("%s, %d px wide: %zu of %zu corners, %.4f px, bias %.4f %.4f, whole tags at least %d\n",
                c.spec.c_str(), size.width, deviations.num_found, deviations.num_visible, deviations.rms(),
                bias.x(), bias.y(), least_tags);
    EXPECT_GE(deviations.num_found, 0.98 * static_cast<double>(deviations.num_visible));
    EXPECT_LE(deviations.rms(), c.most_px);
    EXPECT_LE(bias.cwiseAbs().maxCoeff(), 0.002);
    EXPECT_GE(least_tags, c.least_tags);
    ++num_checked;
  }
  EXPECT_EQ(num_checked, 3);
}

// What covers markers takes their ids, but the corners beside them have those of their neighbours.
TEST(MarkerBoards, KeepTheirIdsWhereACoverHidesMarkers) {
  const Board board = parseBoardSpec("charuco:8x6:30mm:23mm:DICT_5X5_100");
  const SE3 pose = someViews(board, 1, 5).front();
  GrayImage image = Renderer(searchCamera(), kSearchSize).render(inkOf(board), pose, searchLight(1));
  const View truth = exactView(searchCamera(), kSearchSize, board, pose, "");
  const Eigen::Vector2d middle = truth.corners[truth.corners.size() / 2].pixel;
  for (int y = 0; y < kSearchSize.height; ++y) {
    for (int x = static_cast<int>(middle.x()); x < kSearchSize.width; ++x)
      image.pixels[static_cast<std::size_t>(y * kSearchSize.width + x)] = 120;
  }
  const Detection detection = findBoard(image, board);
  EXPECT_EQ(detection.reason, DetectionReason::kPartial);
  Deviations deviations;
  compare(detection, truth, deviations);
  EXPECT_GE(deviations.num_found, 10U);
  EXPECT_LE(deviations.worst_px, 1);
  // The cover's own edge is part of the nearest corners' windows; their sigmas say so.
  Detection sure = detection;
  std::erase_if(sure.corners, [](const Corner& corner) { return corner.sigma_px > 0.05; });
  Deviations of_sure;
  compare(sure, truth, of_sure);
  EXPECT_GE(of_sure.num_found, 10U);
  EXPECT_LE(of_sure.worst_px, 0.1);
}

TEST(MarkerBoards, AreToldApartByTheirIds) {
  const Board first = parseBoardSpec("aprilgrid:3x3:50mm:0.3");
  const Board second = parseBoardSpec("aprilgrid:3x3:50mm:0.3:9");
  const Eigen::Vector2d shift(0.25, 0);
  BoardInk both = inkOf(first);
  for (const Eigen::AlignedBox2d& box : inkOf(second).boxes) both.boxes.push_back(box.translated(shift));
  both.extent.extend(Eigen::Vector2d(both.extent.max() + shift));
  const SE3 first_pose{SO3::exp({0.3, -0.2, 0.1}), {-0.2, -0.1, 0.5}};
  const SE3 second_pose = first_pose * SE3{{}, {shift.x(), 0, 0}};
  const GrayImage image = Renderer(searchCamera(), kSearchSize).render(both, first_pose, searchLight(2));
  for (const auto& [board, pose] : {std::pair(first, first_pose), std::pair(second, second_pose)}) {
    Deviations deviations;
    compare(findBoard(image, board), exactView(searchCamera(), kSearchSize, board, pose, ""), deviations);
    EXPECT_EQ(deviations.num_found, 36U);
    EXPECT_LE(deviations.worst_px, 0.1);
  }
}

TEST(MarkerBoards, AreRefusedWhereTwoHaveTheSameIds) {
  const Board board = parseBoardSpec("aprilgrid:3x3:50mm:0.3");
  BoardInk both = inkOf(board);
  const Eigen::Vector2d shift(0.25, 0);
  for (const Eigen::AlignedBox2d& box : inkOf(board).boxes) both.boxes.push_back(box.translated(shift));
  both.extent.extend(Eigen::Vector2d(both.extent.max() + shift));
  const SE3 pose{SO3::exp({0.3, -0.2, 0.1}), {-0.2, -0.1, 0.5}};
  const GrayImage image = Renderer(searchCamera(), kSearchSize).render(both, pose, searchLight(2));
  EXPECT_EQ(findBoard(image, board).reason, DetectionReason::kSeveralBoards);
}

TEST(MarkerBoards, AreNotFoundInImagesOfAnyOddShape) {
  const std::vector<Board> boards = {parseBoardSpec("charuco:8x6:30mm:23mm:DICT_4X4_50"),
                                     parseBoardSpec("aprilgrid:5x4:88mm:0.3")};
  Random random(6);
  int num_checked = 0;
  for (const ImageSize size :
       {ImageSize{1, 1}, ImageSize{2, 3}, ImageSize{1, 5000}, ImageSize{5000, 1}, ImageSize{11, 12},
        ImageSize{13, 12}, ImageSize{40, 3000}, ImageSize{2401, 13}}) {
    GrayImage image{size, std::vector<std::uint8_t>(static_cast<std::size_t>(size.width) *
                                                    static_cast<std::size_t>(size.height))};
    for (std::uint8_t& pixel : image.pixels) pixel = static_cast<std::uint8_t>(random.index(256));
    for (const Board& board : boards) {
      EXPECT_FALSE(findBoard(image, board).hasCorners()) << size.width << "x" << size.height;
      ++num_checked;
    }
  }
  EXPECT_EQ(num_checked, 16);
}

// Each of OpenCV's dictionaries, in turn of either layout and of either print.
TEST(MarkerBoards, OfEveryDictionaryAreFound) {
  constexpr ImageSize kSmall{640, 480};
  const AnyCamera camera =
      AnyCamera::make("radtan", std::vector<double>{500, 500, 319.5, 239.5, -0.1, 0.02, 0, 0, 0});
  const Renderer renderer(camera, kSmall);
  const SE3 pose{SO3::exp({0.25, -0.3, 0.2}), {-0.06, -0.05, 0.28}};
  std::vector<std::string> names = {"ARUCO_ORIGINAL", "APRILTAG_16h5", "APRILTAG_25h9", "APRILTAG_36h10",
                                    "APRILTAG_36h11"};
  for (const std::string bits : {"4X4_", "5X5_", "6X6_", "7X7_"}) {
    for (const std::string count : {"50", "100", "250", "1000"}) names.push_back(bits + count);
  }
  std::size_t num_checked = 0;
  for (const std::string& name : names) {
    const Board board = parseBoardSpec("charuco:6x5:30mm:23mm:DICT_" + name);
    RenderOptions light = searchLight(num_checked);
    light.samples = 89;
    if (num_checked % 3 == 2) std::swap(light.dark_level, light.bright_level);
    const GrayImage image =
        renderer.render(inkOf(board, {.is_bright_first = num_checked % 2 == 1}), pose, light);
    Deviations deviations;
    compare(findBoard(image, board), exactView(camera, kSmall, board, pose, ""), deviations);
    EXPECT_EQ(deviations.num_visible, 20U) << name;
    EXPECT_EQ(deviations.num_found, 20U) << name;
    EXPECT_LE(deviations.worst_px, 0.1) << name;
    ++num_checked;
  }
  EXPECT_EQ(num_checked, 21U);
}

// No board is found where there is none.
TEST(MarkerBoards, AreNotFoundInHostileImages) {
  const std::vector<Board> boards = {parseBoardSpec("charuco:8x6:30mm:23mm:DICT_4X4_1000"),
                                     parseBoardSpec("charuco:8x6:30mm:23mm:DICT_ARUCO_ORIGINAL"),
                                     parseBoardSpec("aprilgrid:5x4:88mm:0.3")};
  const ImageSize size{320, 240};
  const auto paint = [&](const auto& grey) {
    GrayImage image{size, {}};
    for (int y = 0; y < size.height; ++y) {
      for (int x = 0; x < size.width; ++x) image.pixels.push_back(static_cast<std::uint8_t>(grey(x, y)));
    }
    return image;
  };
  Random random(8);
  std::vector<GrayImage> images = {paint([](int, int) { return 0; }),
                                   paint([](int, int) { return 255; }),
                                   paint([](int x, int) { return x % 256; }),
                                   paint([](int x, int y) { return (x + y) % 2 * 255; }),
                                   paint([](int x, int y) { return (x / 12 + y / 12) % 2 * 255; }),
                                   paint([&](int, int) { return random.index(2) * 255; }),
                                   paint([](int x, int y) { return x % 24 < 12 && y % 24 < 12 ? 0 : 255; }),
                                   paint([](int x, int y) { return (x * x + y * y) / 40 % 256; })};
  std::vector<int> cells(27 * 20);
  for (int& cell : cells) cell = static_cast<int>(random.index(2)) * 255;
  images.push_back(
      paint([&](int x, int y) { return cells[static_cast<std::size_t>(y / 12 * 27 + x / 12)]; }));
  std::size_t num_checked = 0;
  for (const GrayImage& image : images) {
    for (const Board& board : boards) {
      EXPECT_FALSE(findBoard(image, board).hasCorners()) << num_checked;
      ++num_checked;
    }
  }
  EXPECT_EQ(num_checked, 27U);
}

// As many markers as an image can hold, of a far larger board and of one id.
TEST(MarkerBoards, AreNotFoundInFieldsOfMarkers) {
  const Board field = parseBoardSpec("charuco:44x33:10mm:8mm:DICT_4X4_1000");
  const AnyCamera camera = AnyCamera::make("pinhole", std::vector<double>{1000, 1000, 479.5, 359.5});
  RenderOptions light = searchLight(9);
  light.samples = 21;
  const SE3 pose{SO3::exp({0, 0, 0}), {-0.21, -0.155, 0.46}};
  GrayImage image = Renderer(camera, {960, 720}).render(inkOf(field), pose, light);
  const Detection whole = findBoard(image, field);
  EXPECT_GE(whole.corners.size(), 0.9 * field.numCorners());
  EXPECT_FALSE(findBoard(image, parseBoardSpec("charuco:8x6:30mm:23mm:DICT_4X4_1000")).hasCorners());
  // The same marker everywhere.
  for (int y = 0; y < 720; ++y) {
    for (int x = 0; x < 960; ++x) {
      if (x >= 96 || y >= 96) image.pixels[static_cast<std::size_t>(y * 960 + x)] = image.at(x % 96, y % 96);
    }
  }
  EXPECT_FALSE(findBoard(image, field).hasCorners());
}

TEST(MarkerBoards, AreToldOfInTheirOwnWords) {
  const Board grid = parseBoardSpec("aprilgrid:3x3:50mm:0.3");
  const Renderer renderer(searchCamera(), kSearchSize);
  const SE3 pose = someViews(grid, 1, 5).front();
  BoardInk one_tag = inkOf(grid);
  std::erase_if(one_tag.boxes, [](const Eigen::AlignedBox2d& box) { return box.max().maxCoeff() > 0.055; });
  const GrayImage shown = renderer.render(inkOf(grid), pose, searchLight(1));
  GrayImage half = shown;
  const Eigen::Vector2d middle = exactView(searchCamera(), kSearchSize, grid, pose, "").corners[14].pixel;
  for (int y = 0; y < kSearchSize.height; ++y) {
    for (int x = static_cast<int>(middle.x()); x < kSearchSize.width; ++x)
      half.pixels[static_cast<std::size_t>(y * kSearchSize.width + x)] = 120;
  }
  struct Case {
    GrayImage image;
    std::string spec;
    std::string detail;
  };
  const GrayImage blank{kSearchSize, std::vector<std::uint8_t>(960UL * 600, 120)};
  const std::vector<Case> cases = {
      {blank, grid.spec(), "no tag of DICT_APRILTAG_36h11 was found"},
      {blank, "charuco:8x6:30mm:23mm:DICT_4X4_50", "no marker of DICT_4X4_50 was found"},
      {renderer.render(one_tag, pose, searchLight(2)), grid.spec(),
       "found 1 of 9 tags, too few to place the board"},
      {shown, grid.spec() + ":40",
       " tags of DICT_APRILTAG_36h11, but with other ids than aprilgrid:3x3:50mm:0.3:40 has"},
      {half, grid.spec(), " of 36 tag corners; the others are covered"}};
  int num_checked = 0;
  for (const Case& c : cases) {
    EXPECT_THAT(findBoard(c.image, parseBoardSpec(c.spec)).detail, testing::HasSubstr(c.detail)) << c.spec;
    ++num_checked;
  }
  EXPECT_EQ(num_checked, 5);
}

// Ids that lie in another arrangement than the SPEC says would be given to the wrong corners.
TEST(MarkerBoards, OfOtherCountsAreRefused) {
  const Board shown = parseBoardSpec("aprilgrid:7x4:50mm:0.3");
  const SE3 pose = someViews(shown, 1, 8).front();
  const GrayImage image = Renderer(searchCamera(), kSearchSize).render(inkOf(shown), pose, searchLight(4));
  EXPECT_TRUE(findBoard(image, shown).found());
  const Detection detection = findBoard(image, parseBoardSpec("aprilgrid:4x7:50mm:0.3"));
  EXPECT_EQ(detection.reason, DetectionReason::kOtherBoard) << detection.detail;
  EXPECT_THAT(detection.detail, testing::HasSubstr("tags do not lie as on"));
  EXPECT_TRUE(detection.corners.empty());
  const Detection none = findBoard(image, parseBoardSpec("charuco:8x6:30mm:23mm:DICT_4X4_50"));
  EXPECT_FALSE(none.hasCorners()) << none.detail;
}

}  // namespace
}  // namespace alidade
