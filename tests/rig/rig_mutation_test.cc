// SPDX-License-Identifier: MIT
// Spoilt rigs end in an Error that names the input, or in a result of finite numbers.
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <limits>
#include <map>
#include <string>
#include <utility>
#include <vector>

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "alidade/core/error.h"
#include "alidade/files/formats/alidade_writer.h"
#include "alidade/report/data/evidence.h"
#include "rig_scene.h"

namespace alidade {
namespace {

View& anyView(std::vector<RigViews>& rig, Random& random) {
  RigViews& camera = rig[random.index(rig.size())];
  return camera.views[random.index(camera.views.size())];
}

// Spoils the views of one or two cameras, as recordings of people may be.
void spoil(std::vector<RigViews>& rig, Random& random) {
  RigViews& camera = rig[random.index(rig.size())];
  RigViews& other = rig[random.index(rig.size())];
  switch (random.index(13)) {
    case 0:  // most views are missing
      camera.views.resize(1 + random.index(3));
      break;
    case 1:
      std::erase_if(camera.views, [&](const View&) { return random.uniform() < 0.5; });
      if (camera.views.empty()) camera.views.push_back(anyView(rig, random));
      break;
    case 2:  // the frames of one camera are in another order
      for (View& view : camera.views)
        std::swap(view.corners, camera.views[random.index(camera.views.size())].corners);
      break;
    case 3:
      std::swap(camera.views, other.views);
      break;
    case 4:  // the same images twice
      camera.views = other.views;
      break;
    case 5:
      for (View& view : camera.views) view.corners = camera.views.front().corners;
      break;
    case 6:  // gross errors
      for (Corner& corner : anyView(rig, random).corners)
        corner.pixel += 200 * Eigen::Vector2d(random.normal(), random.normal());
      break;
    case 7:
      for (View& view : camera.views) {
        for (Corner& corner : view.corners)
          corner.pixel = {random.uniform(0, view.size.width - 1), random.uniform(0, view.size.height - 1)};
      }
      break;
    case 8:  // few corners
      for (View& view : camera.views) view.corners.resize(std::min<std::size_t>(view.corners.size(), 6));
      break;
    case 9:  // zoom
      for (std::size_t v = camera.views.size() / 2; v < camera.views.size(); ++v) {
        for (Corner& corner : camera.views[v].corners) corner.pixel *= 1.2;
      }
      break;
    case 10:  // a mirror
      for (View& view : camera.views) {
        for (Corner& corner : view.corners) corner.pixel.x() = view.size.width - 1 - corner.pixel.x();
      }
      break;
    case 11:  // all corners nearly at one place
      for (Corner& corner : anyView(rig, random).corners)
        corner.pixel = Eigen::Vector2d(100, 100) + 0.01 * corner.pixel;
      break;
    default:  // later numbers
      for (std::size_t v = 0; v < camera.views.size(); ++v)
        camera.views[v].image =
            "frame" + std::to_string(v + 1 + random.index(3)) + "x" + std::to_string(v) + ".png";
      break;
  }
}

struct Outcomes {
  int num_usable = 0;
  int num_rejected = 0;
  int num_errors = 0;
};

// Rigs of two to four cameras, each spoilt in up to three ways.
void trySpoiltRigs(std::uint64_t first_seed, int count, Outcomes& outcomes) {
  const std::vector<Board> boards = {
      CharucoBoard{
          .columns = 5, .rows = 6, .square_m = 0.045, .marker_m = 0.03, .dictionary = "DICT_4X4_250"},
      Checkerboard{.columns = 6, .rows = 4, .square_m = 0.04}};
  const std::vector<std::string> models = {"auto",          "auto",     "radtan", "kannala_brandt",
                                           "double_sphere", "rational", "pinhole"};
  const std::vector<BoardShapeMode> shapes = {BoardShapeMode::kAuto, BoardShapeMode::kAuto,
                                              BoardShapeMode::kFlat, BoardShapeMode::kUneven,
                                              BoardShapeMode::kFlexible};
  const std::vector<double> lens = {600, 600, 319.5, 239.5, -0.2, 0.05, 0, 0, 0};
  for (int i = 0; i < count; ++i) {
    Random random(first_seed + static_cast<std::uint64_t>(i));
    std::vector<TrueCamera> cameras;
    for (std::uint64_t c = 0; c < 2 + random.index(3); ++c) {
      const double across = 0.2 * static_cast<double>(c);
      cameras.push_back({AnyCamera::make("radtan", lens), {640, 480}, poseAt(-across, 0.01, 0.02, across)});
    }
    const Board& board = boards[random.index(boards.size())];
    RigScene scene = sceneOf(cameras, board, 6 + static_cast<int>(random.index(8)), 0.1, random.index(1000));
    for (RigViews& camera : scene.views) {
      if (camera.views.empty()) camera.views = scene.views.front().views;
    }
    const std::uint64_t num_ways = 1 + random.index(3);
    for (std::uint64_t k = 0; k < num_ways; ++k) spoil(scene.views, random);
    RigOptions options;
    options.camera.jobs = 2;
    options.camera.model = models[random.index(models.size())];
    options.camera.board_shape = shapes[random.index(shapes.size())];
    try {
      const RigCalibration rig = calibrate(board, scene.views, options);
      ++(rig.isUsable() ? outcomes.num_usable : outcomes.num_rejected);
      // Throws unless all numbers are finite.
      EXPECT_FALSE(rigFileText(recordOf(rig, "test")).empty());
      EXPECT_FALSE(rigEvidenceDocument(rig, 1, {.created_by = "test"}).empty());
    } catch (const Error& error) {
      ++outcomes.num_errors;
      EXPECT_EQ(error.code(), ErrorCode::kInput) << "seed " << first_seed + static_cast<std::uint64_t>(i);
    } catch (const std::exception& error) {
      ADD_FAILURE() << "seed " << first_seed + static_cast<std::uint64_t>(i) << ": " << error.what();
    }
  }
  std::printf("%d spoilt rigs: %d usable, %d rejected, %d errors\n", count, outcomes.num_usable,
              outcomes.num_rejected, outcomes.num_errors);
  EXPECT_EQ(outcomes.num_usable + outcomes.num_rejected + outcomes.num_errors, count);
}

TEST(RigMutation, EndsInAResultOrAnError) {
  Outcomes outcomes;
  trySpoiltRigs(1, 60, outcomes);
  EXPECT_GE(outcomes.num_usable, 5);
  EXPECT_GE(outcomes.num_rejected, 10);
}

TEST(ManyRigMutations, EndInAResultOrAnError) {
  Outcomes outcomes;
  trySpoiltRigs(1000, 500, outcomes);
  EXPECT_GE(outcomes.num_usable, 50);
  EXPECT_GE(outcomes.num_rejected, 100);
}

}  // namespace
}  // namespace alidade
