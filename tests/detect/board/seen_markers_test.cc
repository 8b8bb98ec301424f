// SPDX-License-Identifier: MIT
#include "alidade/detect/board/seen_markers.h"

#include <algorithm>
#include <cstdint>
#include <cstdio>
#include <vector>

#include <gtest/gtest.h>

#include "alidade/core/random.h"
#include "alidade/print/ink_of_board.h"
#include "alidade/simulate/render.h"
#include "alidade/target/board_spec.h"

namespace alidade {
namespace {

const std::vector<MarkerPrint> kCharucoPrints = {{.dictionary = "DICT_4X4_1000"}};

// Squares of random colours, of one size after another over each other.
GrayImage clutter(ImageSize size, std::uint64_t seed) {
  Random random(seed);
  GrayImage image{size, std::vector<std::uint8_t>(static_cast<std::size_t>(size.width) *
                                                  static_cast<std::size_t>(size.height))};
  for (const int side : {160, 40, 12, 5, 2}) {
    const int across = size.width / side + 1;
    std::vector<int> levels(static_cast<std::size_t>(across) *
                            static_cast<std::size_t>(size.height / side + 1));
    for (int& level : levels) level = static_cast<int>(random.index(51));
    for (int y = 0; y < size.height; ++y) {
      for (int x = 0; x < size.width; ++x) {
        auto& pixel = image.pixels[static_cast<std::size_t>(y * size.width + x)];
        pixel =
            static_cast<std::uint8_t>(pixel + levels[static_cast<std::size_t>(y / side * across + x / side)]);
      }
    }
  }
  return image;
}

// The closer look takes four times as long as the usual one, so it must not be taken in every picture.
TEST(SeenMarkers, AreFramedWhereACloserLookSeesMore) {
  const ImageSize size{640, 480};
  const Board board = parseBoardSpec("charuco:8x11:24mm:18.75mm:DICT_4X4_1000");
  const Renderer renderer(AnyCamera::make("pinhole", std::vector<double>{550, 550, 319.5, 239.5}), size);
  Random random(3);
  int num_small = 0;
  int num_framed = 0;
  for (int i = 0; i < 40; ++i) {
    const double side_px = random.uniform(10, 15);
    const SE3 pose{SO3::exp({random.uniform(-0.5, 0.5), random.uniform(-0.5, 0.5), random.uniform(-3, 3)}),
                   {random.uniform(-0.1, 0), random.uniform(-0.1, 0), 550 * 0.01875 / side_px}};
    RenderOptions light;
    light.blur_px = random.uniform(0.6, 0.9);
    light.read_noise = 2;
    light.samples = 64;
    light.seed = static_cast<std::uint64_t>(i);
    const GrayImage image = renderer.render(inkOf(board), pose, light);
    const SeenMarkers usual = seeMarkers(image, kCharucoPrints, {.scale = 1});
    const SeenMarkers close = seeMarkers(image, kCharucoPrints, {.scale = 2});
    if (close.of_prints[0].size() < usual.of_prints[0].size() + 4) continue;
    ++num_small;
    num_framed += usual.areFramed() ? 1 : 0;
  }
  std::printf("of %d boards whose markers the usual look misses, %d have framed outlines\n", num_small,
              num_framed);
  EXPECT_GE(num_small, 15);
  EXPECT_EQ(num_framed, num_small);

  int num_clutters = 0;
  for (std::uint64_t seed = 1; seed <= 20; ++seed) {
    const SeenMarkers seen = seeMarkers(clutter(size, seed), kCharucoPrints, {.scale = 1});
    num_clutters += seen.areFramed() ? 1 : 0;
  }
  std::printf("of 20 pictures of clutter, %d have framed outlines\n", num_clutters);
  EXPECT_LE(num_clutters, 2);
}

// Inside a wide border runs an outline that can be read as that of a narrower border, also where the outer
// one is joined to the squares at the corners of the tag. Most markers tell the right one.
TEST(SeenMarkers, AreMostlyReadWithTheirOwnBorder) {
  const ImageSize size{960, 600};
  const Board board = parseBoardSpec("aprilgrid:5x4:88mm:0.3");
  std::vector<MarkerPrint> prints;
  for (const int border : AprilGrid::kBorders)
    prints.push_back({.dictionary = std::string(AprilGrid::kDictionary), .border = border, .is_apart = true});
  const Renderer renderer(AnyCamera::make("pinhole", std::vector<double>{720, 720, 479.5, 299.5}), size);
  for (const int border : {1, 2, 3}) {
    RenderOptions light;
    light.blur_px = 0.7;
    light.samples = 64;
    const SE3 pose{SO3::exp({0.2, 0.3, 0.1}), {-0.25, -0.2, 0.85}};
    const SeenMarkers seen = seeMarkers(renderer.render(inkOf(board, {.april_border = border}), pose, light),
                                        prints, {.scale = 1});
    std::size_t most_others = 0;
    std::size_t num_right = 0;
    for (std::size_t p = 0; p < prints.size(); ++p) {
      const std::size_t num = seen.of_prints[p].size();
      (prints[p].border == border ? num_right : most_others) =
          prints[p].border == border ? num : std::max(num, most_others);
    }
    std::printf("border of %d cells: %zu of 20 read, at most %zu as of another width\n", border, num_right,
                most_others);
    EXPECT_GE(num_right, 11U) << border;
    EXPECT_LT(most_others, num_right) << border;
  }
}

}  // namespace
}  // namespace alidade
