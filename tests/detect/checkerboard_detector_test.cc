// SPDX-License-Identifier: MIT
#include "alidade/detect/detect_images.h"

#include <gmock/gmock.h>

#include <cmath>

#include "alidade/core/error.h"
#include "alidade/simulate/render.h"
#include "support/simulated_set.h"

namespace alidade {
namespace {

const Checkerboard kBoard{.columns = 9, .rows = 6, .square_m = 0.025};

struct RenderedSet {
  SimulatedSet truth;
  std::vector<GrayImage> images;
};

RenderedSet rendered(ImageSize size, int num_views, std::uint64_t seed, double max_roll_deg = 30,
                     double blur_px = 0.7) {
  const double f = 0.85 * size.width;
  const std::vector<double> params = {f,     f,    0.5 * size.width, 0.5 * size.height, -0.28, 0.08, 8e-4,
                                      -4e-4, -0.01};
  RandomViewOptions options;
  options.max_roll_deg = max_roll_deg;
  RenderedSet set{.truth = simulateSet(AnyCamera::make("radtan", params), size, num_views, 0, seed, options),
                  .images = {}};
  const Renderer renderer(set.truth.camera, size);
  for (std::size_t i = 0; i < set.truth.poses.size(); ++i) {
    RenderOptions render;
    render.read_noise = 1.0;
    render.blur_px = blur_px;
    render.seed = seed + i;
    set.images.push_back(renderer.render(kBoard, set.truth.poses[i], render));
  }
  return set;
}

// Root mean square of du and dv together, per axis.
double perAxisRms(const Detection& detection, const View& truth) {
  double sum = 0;
  for (std::size_t i = 0; i < truth.corners.size(); ++i) {
    sum += (detection.corners[i].pixel - truth.corners[i].pixel).squaredNorm();
  }
  return std::sqrt(sum / (2.0 * static_cast<double>(truth.corners.size())));
}

TEST(DetectCheckerboard, FindsEveryCornerUnderItsOwnIdHoweverTheBoardIsTurned) {
  constexpr double kMaxRmsPx =
      0.08;  // a stock corner refinement at this noise; a wrong id would be tens of pixels
  const RenderedSet set = rendered({.width = 640, .height = 480}, 12, 3, 180);
  int num_found = 0;
  for (std::size_t i = 0; i < set.images.size(); ++i) {
    const Detection detection = findBoard(set.images[i], kBoard);
    ASSERT_TRUE(detection.found()) << "view " << i << ": " << detection.detail;
    ASSERT_EQ(detection.corners.size(), 54U);
    for (int id = 0; id < 54; ++id) EXPECT_EQ(detection.corners[static_cast<std::size_t>(id)].id, id);
    EXPECT_LE(perAxisRms(detection, set.truth.views[i]), kMaxRmsPx) << "view " << i;
    ++num_found;
  }
  EXPECT_EQ(num_found, 12);
}

TEST(DetectCheckerboard, RefinesOnTheFullImageWhatItFoundOnAReducedOne) {
  // Searched at 720 px and left there, the error would be half a reduced pixel, 1.4 px here.
  const RenderedSet set = rendered({.width = 2000, .height = 1500}, 3, 4);
  int num_found = 0;
  for (std::size_t i = 0; i < set.images.size(); ++i) {
    const Detection detection = findBoard(set.images[i], kBoard);
    ASSERT_TRUE(detection.found()) << detection.detail;
    EXPECT_LE(perAxisRms(detection, set.truth.views[i]), 0.08);
    ++num_found;
  }
  EXPECT_EQ(num_found, 3);
}

TEST(DetectCheckerboard, NeverTakesAPartOfALargerBoard) {
  const RenderedSet set = rendered({.width = 480, .height = 360}, 4, 5);
  int num_refused = 0;
  for (const GrayImage& image : set.images) {
    for (const auto& [columns, rows] :
         std::vector<std::pair<int, int>>{{8, 6}, {9, 5}, {8, 5}, {7, 6}, {3, 3}}) {
      const Detection detection =
          findBoard(image, Checkerboard{.columns = columns, .rows = rows, .square_m = 0.025});
      EXPECT_EQ(detection.reason, DetectionReason::kLargerBoard) << columns << "x" << rows;
      EXPECT_THAT(detection.detail, testing::HasSubstr("9x6"));
      EXPECT_TRUE(detection.corners.empty());
      ++num_refused;
    }
  }
  EXPECT_EQ(num_refused, 20);
}

TEST(DetectCheckerboard, NamesAWholeBoardOfFewerCorners) {
  const RenderedSet set = rendered({.width = 480, .height = 360}, 4, 5);
  int num_refused = 0;
  for (const GrayImage& image : set.images) {
    for (const auto& [columns, rows] : std::vector<std::pair<int, int>>{{10, 7}, {9, 7}, {10, 6}, {13, 12}}) {
      const Detection detection =
          findBoard(image, Checkerboard{.columns = columns, .rows = rows, .square_m = 0.025});
      EXPECT_EQ(detection.reason, DetectionReason::kOtherBoard) << columns << "x" << rows;
      ASSERT_TRUE(detection.seen);
      EXPECT_TRUE(detection.seen->is_closed);
      EXPECT_EQ(detection.seen->columns, 9);
      EXPECT_EQ(detection.seen->rows, 6);
      ++num_refused;
    }
  }
  EXPECT_EQ(num_refused, 16);
}

GrayImage cropped(const GrayImage& image, int x0, int y0, int width, int height) {
  GrayImage out{.size = {.width = width, .height = height}, .pixels = {}};
  for (int y = 0; y < height; ++y) {
    for (int x = 0; x < width; ++x) out.pixels.push_back(image.at(x0 + x, y0 + y));
  }
  return out;
}

// How many corners carry the id of the truth; any that does not is a failure. A corner that is half covered
// may be off, but must say so: usual sigmas here are 0.02, and calibration leaves out what is off by 8.
int countRightIds(const Detection& detection, const View& truth, Eigen::Vector2d offset) {
  constexpr double kSamePx = 1.0;  // neighbours are tens of pixels away
  int count = 0;
  for (const Corner& corner : detection.corners) {
    const Eigen::Vector2d expected = truth.corners[static_cast<std::size_t>(corner.id)].pixel - offset;
    EXPECT_LT((corner.pixel - expected).norm(), std::max(kSamePx, 8 * corner.sigma_px))
        << "corner " << corner.id << " sigma " << corner.sigma_px;
    ++count;
  }
  return count;
}

TEST(DetectCheckerboard, GivesABoardCutByTheBorderItsTrueIdsOrNone) {
  const RenderedSet set = rendered({.width = 640, .height = 480}, 10, 9, 180);
  int num_cut = 0;
  int num_placed = 0;
  int num_corners = 0;
  for (std::size_t i = 0; i < set.images.size(); ++i) {
    // The border runs through the board at a share of its extent, from each of the four sides.
    Eigen::Vector2d low(1e9, 1e9);
    Eigen::Vector2d high(-1e9, -1e9);
    for (const Corner& corner : set.truth.views[i].corners) {
      low = low.cwiseMin(corner.pixel);
      high = high.cwiseMax(corner.pixel);
    }
    for (const double share : {0.1, 0.25, 0.4}) {
      const auto x = [&](double s) { return static_cast<int>(low.x() + s * (high.x() - low.x())); };
      const auto y = [&](double s) { return static_cast<int>(low.y() + s * (high.y() - low.y())); };
      struct Crop {
        int x0, y0, width, height;
      };
      for (const Crop& crop : {Crop{x(share), 0, 640 - x(share), 480}, Crop{0, y(share), 640, 480 - y(share)},
                               Crop{0, 0, x(1 - share), 480}, Crop{0, 0, 640, y(1 - share)}}) {
        const GrayImage image = cropped(set.images[i], crop.x0, crop.y0, crop.width, crop.height);
        const Detection detection = findBoard(image, kBoard);
        ++num_cut;
        EXPECT_NE(detection.reason, DetectionReason::kFound);
        EXPECT_FALSE(detection.detail.empty());
        num_placed += detection.hasCorners() ? 1 : 0;
        num_corners += countRightIds(detection, set.truth.views[i], {crop.x0, crop.y0});
      }
    }
  }
  EXPECT_EQ(num_cut, 120);
  EXPECT_GE(num_placed, 60);
  EXPECT_GE(num_corners, 60 * 20);
}

TEST(DetectCheckerboard, FindsTheCornersBesideAHand) {
  const RenderedSet set = rendered({.width = 640, .height = 480}, 12, 10, 180);
  int num_placed = 0;
  int num_corners = 0;
  Random random(4);
  for (std::size_t i = 0; i < set.images.size(); ++i) {
    GrayImage image = set.images[i];
    const Eigen::Vector2d center = set.truth.views[i].corners[random.index(54)].pixel;
    constexpr double kRadius = 45;
    for (int y = 0; y < 480; ++y) {
      for (int x = 0; x < 640; ++x) {
        if ((Eigen::Vector2d(x, y) - center).norm() > kRadius) continue;
        image.pixels[static_cast<std::size_t>(y * 640 + x)] =
            static_cast<std::uint8_t>(150 + random.index(20));
      }
    }
    const Detection detection = findBoard(image, kBoard);
    EXPECT_NE(detection.reason, DetectionReason::kFound);
    num_placed += detection.hasCorners() ? 1 : 0;
    num_corners += countRightIds(detection, set.truth.views[i], {0, 0});
  }
  EXPECT_GE(num_placed, 11);
  EXPECT_GE(num_corners, 11 * 40);
}

TEST(DetectCheckerboard, RefusesTwoBoardsThatFitAndPatternsWithoutEnd) {
  // The same view twice, side by side.
  const RenderedSet set = rendered({.width = 480, .height = 360}, 3, 13);
  int num_refused = 0;
  for (const GrayImage& image : set.images) {
    GrayImage twice{.size = {.width = 960, .height = 360}, .pixels = {}};
    for (int y = 0; y < 360; ++y) {
      for (int x = 0; x < 960; ++x) twice.pixels.push_back(image.at(x % 480, y));
    }
    EXPECT_EQ(findBoard(twice, kBoard).reason, DetectionReason::kSeveralBoards);
    ++num_refused;
  }
  EXPECT_EQ(num_refused, 3);

  // A floor of squares of which just 9x6 corners come into the image.
  GrayImage floor{.size = {.width = 395, .height = 275}, .pixels = {}};
  for (int y = 0; y < 275; ++y) {
    for (int x = 0; x < 395; ++x) floor.pixels.push_back((x / 40 + y / 40) % 2 == 0 ? 40 : 210);
  }
  const Detection detection = findBoard(floor, kBoard);
  EXPECT_EQ(detection.reason, DetectionReason::kUnplaced);
  ASSERT_TRUE(detection.seen);
  EXPECT_EQ(detection.seen->num_corners, 54);
}

// A sheet of any brightness over the board on one side, and the image's border on the other: where the sheet
// begins is not where the board ends.
TEST(DetectCheckerboard, TakesNoCoverForTheMargin) {
  int num_checked = 0;
  const double square = 40;
  constexpr double kNoCover = 100;
  for (const int level : {130, 170, 220, 250}) {
    for (const double edge : {5.5, 6.3, 6.6, 7.5, kNoCover}) {  // in squares from the first line of corners
      View truth;
      for (int id = 0; id < 54; ++id) {
        Corner corner;
        corner.id = id;
        corner.pixel = {square * (id % 9) - 20, square * (id / 9) + 80};
        truth.corners.push_back(corner);
      }
      GrayImage image{.size = {.width = 480, .height = 400}, .pixels = {}};
      for (int y = 0; y < 400; ++y) {
        for (int x = 0; x < 480; ++x) {
          const double column = std::floor((x + 20.5) / square);
          const double row = std::floor((y - 79.5) / square);
          const bool is_board = column < 9 && row >= -1 && row < 6;
          const bool is_dark = is_board && (static_cast<int>(column + row) % 2 == 0);
          image.pixels.push_back(static_cast<std::uint8_t>((x + 20.5) / square > edge ? level
                                                           : is_dark                  ? 30
                                                           : is_board || row >= -2    ? 220
                                                                                      : 120));
        }
      }
      // Corners 0, 9, ... lie outside of the image.
      const Detection detection = findBoard(image, kBoard);
      const int num_corners = countRightIds(detection, truth, {0, 0});
      if (edge == kNoCover) {
        EXPECT_EQ(num_corners, 48) << detection.detail;
      }
      ++num_checked;
    }
  }
  EXPECT_EQ(num_checked, 20);
}

TEST(DetectCheckerboard, FindsSmallSquaresAndBlurredOnes) {
  int num_checked = 0;
  for (const int width : {200, 240}) {
    const RenderedSet small = rendered({.width = width, .height = width * 3 / 4}, 6, 11, 180);
    for (std::size_t i = 0; i < small.images.size(); ++i) {
      const Detection detection = findBoard(small.images[i], kBoard);
      EXPECT_TRUE(detection.hasCorners()) << width << " px, view " << i << ": " << detection.detail;
      countRightIds(detection, small.truth.views[i], {0, 0});
      ++num_checked;
    }
  }
  const RenderedSet soft = rendered({.width = 640, .height = 480}, 6, 12, 180, 4.0);
  for (std::size_t i = 0; i < soft.images.size(); ++i) {
    const Detection detection = findBoard(soft.images[i], kBoard);
    EXPECT_TRUE(detection.found()) << "blurred view " << i << ": " << detection.detail;
    countRightIds(detection, soft.truth.views[i], {0, 0});
    EXPECT_GT(detection.measures.blur_px, 3.5);
    EXPECT_LT(detection.measures.blur_px, 6) << "windows clear of the next squares are narrow for such blur";
    ++num_checked;
  }
  EXPECT_EQ(num_checked, 18);
}

TEST(DetectCheckerboard, SidewaysCountsFindTheSameCorners) {
  const RenderedSet set = rendered({.width = 640, .height = 480}, 2, 6);
  for (std::size_t i = 0; i < set.images.size(); ++i) {
    const Detection upright = findBoard(set.images[i], kBoard);
    const Detection sideways =
        findBoard(set.images[i], Checkerboard{.columns = 6, .rows = 9, .square_m = 0.025});
    ASSERT_TRUE(upright.found() && sideways.found());
    double worst = 0;
    for (const Corner& corner : sideways.corners) {
      double nearest = 1e9;
      for (const Corner& other : upright.corners)
        nearest = std::min(nearest, (corner.pixel - other.pixel).norm());
      worst = std::max(worst, nearest);
    }
    EXPECT_LT(worst, 0.1);
  }
}

TEST(DetectCheckerboard, FindsNothingInNoise) {
  Random random(1);
  GrayImage image{.size = {.width = 320, .height = 240}, .pixels = {}};
  for (int i = 0; i < 320 * 240; ++i) image.pixels.push_back(static_cast<std::uint8_t>(random.index(256)));
  const Detection detection = findBoard(image, kBoard);
  EXPECT_EQ(detection.reason, DetectionReason::kNoBoard);
  EXPECT_TRUE(detection.corners.empty());
}

TEST(DetectCheckerboard, FindsNothingInImagesOfAnyOddShape) {
  int num_checked = 0;
  for (const auto& [width, height] :
       std::vector<std::pair<int, int>>{{1, 1}, {5000, 1}, {1, 3000}, {15, 15}, {17, 3}}) {
    const GrayImage image{.size = {.width = width, .height = height},
                          .pixels = std::vector<std::uint8_t>(static_cast<std::size_t>(width * height), 128)};
    EXPECT_EQ(findBoard(image, kBoard).reason, DetectionReason::kNoBoard) << width << "x" << height;
    ++num_checked;
  }
  EXPECT_EQ(num_checked, 5);
}

TEST(DetectInImages, KeepsTheOrderAndReportsWhatCannotBeRead) {
  const RenderedSet set = rendered({.width = 640, .height = 480}, 3, 7);
  const std::vector<std::string> names = {"0", "broken", "2", "1"};
  const auto load = [&](const std::string& name) -> LoadedImage {
    if (name == "broken") throw inputError({.where = name, .found = "nothing"});
    return {.image = set.images[std::stoul(name)], .exif_orientation = name == "2" ? 6 : 1};
  };
  std::vector<std::vector<ImageOutcome>> runs;
  for (const int jobs : {1, 4}) {
    DetectImagesOptions options;
    options.num_jobs = jobs;
    std::size_t last_done = 0;
    options.progress = [&](std::size_t done, std::size_t total) {
      EXPECT_EQ(total, 4U);
      EXPECT_EQ(done, ++last_done);
    };
    runs.push_back(detectInImages(ImageSet(names, load), std::vector<Board>{kBoard}, options).front());
    EXPECT_EQ(last_done, 4U);
  }
  for (const auto& outcomes : runs) {
    ASSERT_EQ(outcomes.size(), 4U);
    EXPECT_EQ(outcomes[1].detection.reason, DetectionReason::kUnreadable);
    EXPECT_THAT(outcomes[1].detection.detail, testing::HasSubstr("broken: nothing"));
    EXPECT_EQ(outcomes[2].exif_orientation, 6);
    for (const std::size_t i : {0U, 2U, 3U}) {
      EXPECT_TRUE(outcomes[i].detection.found());
      EXPECT_EQ(outcomes[i].image, names[i]);
    }
  }
  for (std::size_t i = 0; i < 4; ++i) {
    ASSERT_EQ(runs[0][i].detection.corners.size(), runs[1][i].detection.corners.size());
    for (std::size_t k = 0; k < runs[0][i].detection.corners.size(); ++k) {
      EXPECT_EQ(runs[0][i].detection.corners[k].pixel, runs[1][i].detection.corners[k].pixel);
    }
  }
}

}  // namespace
}  // namespace alidade
