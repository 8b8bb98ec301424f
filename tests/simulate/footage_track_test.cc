// SPDX-License-Identifier: MIT
// The truth about simulated footage: poses and exact tracks, without pictures.
#include <gmock/gmock.h>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <limits>
#include <vector>

#include <Eigen/LU>
#include <Eigen/SVD>

#include "alidade/core/error.h"
#include "simulate/footage_support.h"

namespace alidade {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector2d;
using Eigen::Vector3d;
using testing::HasSubstr;

struct Pair {
  Vector2d from;
  Vector2d to;
};

// Points that are seen in both frames and do not move.
std::vector<Pair> pairs(const FootageSimulator& simulator, int frame, int next) {
  std::vector<Pair> found;
  for (const TrueTrack& track : simulator.trackPoints()) {
    const int at = frame - track.first_frame;
    const auto end = static_cast<int>(track.pixels.size());
    if (track.point.is_moving || at < 0 || at + next - frame >= end) continue;
    found.push_back({track.pixels[static_cast<std::size_t>(at)],
                     track.pixels[static_cast<std::size_t>(at + next - frame)]});
  }
  return found;
}

// The largest distance from where pure rotation would bring a point.
double offRotation(const FootageSimulator& simulator, int frame, int next) {
  const SO3 next_from_frame = (simulator.poseOf(next) * simulator.poseOf(frame).inverse()).rotation;
  double most = 0;
  for (const Pair& pair : pairs(simulator, frame, next)) {
    const Vector3d ray = *simulator.cameraOf(frame).unproject(pair.from);
    const Projection there = simulator.cameraOf(next).project(next_from_frame * ray);
    if (there.ok()) most = std::max(most, (there.pixel - pair.to).norm());
  }
  return most;
}

TEST(FootagePaths, MoveAsTheirNamesSay) {
  FootageScene scene = footageScene(footagePinhole());

  scene.path = FootagePath::kStatic;
  const FootageSimulator still(scene);
  const auto still_pairs = pairs(still, 2, 9);
  EXPECT_EQ(still_pairs.size(), 16U * 12U);
  for (const Pair& pair : still_pairs) EXPECT_LT((pair.from - pair.to).norm(), 1e-9);

  scene.path = FootagePath::kRotation;
  const FootageSimulator rotation(scene);
  EXPECT_GT(pairs(rotation, 2, 9).size(), 80U);
  EXPECT_LT(offRotation(rotation, 2, 9), 1e-6);
  EXPECT_LT(rotation.poseOf(9).translation.norm(), 1e-12);
  EXPECT_GT((rotation.poseOf(9).rotation * rotation.poseOf(2).rotation.inverse()).log().norm(), 0.02);

  scene.path = FootagePath::kWalk;
  const FootageSimulator walk(scene);
  EXPECT_GT(pairs(walk, 2, 9).size(), 80U);
  EXPECT_GT(offRotation(walk, 2, 9), 5);
  EXPECT_GT((walk.poseOf(9).rotation * walk.poseOf(2).rotation.inverse()).log().norm(), 0.02);

  scene.path = FootagePath::kStraight;
  const FootageSimulator straight(scene);
  const Vector2d centre(158, 121);
  const auto straight_pairs = pairs(straight, 2, 5);
  EXPECT_GT(straight_pairs.size(), 80U);
  for (const Pair& pair : straight_pairs) {
    // Away from the image of the direction of travel, on a straight line.
    const Vector2d from = pair.from - centre;
    const Vector2d to = pair.to - centre;
    EXPECT_GT(to.norm(), from.norm());
    EXPECT_LT(std::abs(from.x() * to.y() - from.y() * to.x()) / to.norm(), 0.02 * to.norm());
  }
  const SE3 step = straight.poseOf(6) * straight.poseOf(5).inverse();
  EXPECT_LT(step.rotation.log().norm(), 1e-12);
  EXPECT_LT((step.translation - (straight.poseOf(16) * straight.poseOf(15).inverse()).translation).norm(),
            1e-9);
  EXPECT_LT(step.translation.z(), -0.01);  // the world comes nearer
}

TEST(FootageSurroundings, HaveTheParallaxThatTheirNamesSay) {
  FootageScene scene = footageScene(footagePinhole());
  scene.surroundings = FootageSurroundings::kFar;
  const FootageSimulator far(scene);
  EXPECT_GT(pairs(far, 2, 9).size(), 60U);
  EXPECT_LT(offRotation(far, 2, 9), 1e-3);
  EXPECT_GT((far.poseOf(9) * far.poseOf(2).inverse()).translation.norm(), 0.01);

  // Two pictures of a plane by a pinhole camera are related by a homography, those of a room are not.
  const auto leastSquaresError = [](const std::vector<Pair>& matches) {
    Eigen::MatrixXd A(2 * static_cast<Eigen::Index>(matches.size()), 9);
    const auto scaled = [](const Vector2d& p) { return Vector2d((p - Vector2d(160, 120)) / 200); };
    for (std::size_t i = 0; i < matches.size(); ++i) {
      const Eigen::RowVector3d p = scaled(matches[i].from).homogeneous().transpose();
      const Vector2d q = scaled(matches[i].to);
      const auto row = 2 * static_cast<Eigen::Index>(i);
      A.row(row) << p, 0, 0, 0, -q.x() * p;
      A.row(row + 1) << 0, 0, 0, p, -q.y() * p;
    }
    const Eigen::JacobiSVD<Eigen::MatrixXd> svd(A);
    return svd.singularValues()(8) / std::sqrt(static_cast<double>(A.rows()));
  };
  scene.surroundings = FootageSurroundings::kPlane;
  const auto on_plane = pairs(FootageSimulator(scene), 2, 9);
  scene.surroundings = FootageSurroundings::kRoom;
  const auto in_room = pairs(FootageSimulator(scene), 2, 9);
  ASSERT_GT(on_plane.size(), 60U);
  ASSERT_GT(in_room.size(), 60U);
  EXPECT_LT(leastSquaresError(on_plane), 1e-10);
  EXPECT_GT(leastSquaresError(in_room), 1e-3);
}

TEST(FootageFlow, IsWhatWasAskedFor) {
  int num_checked = 0;
  for (const AnyCamera& camera : {footagePinhole(), footageFisheye()}) {
    for (const FootagePath path : {FootagePath::kWalk, FootagePath::kRotation, FootagePath::kStraight}) {
      for (const double flow : {2.0, 6.0}) {
        FootageScene scene = footageScene(camera);
        scene.path = path;
        scene.flow_px = flow;
        const FootageSimulator simulator(scene);
        double sum = 0;
        int count = 0;
        for (int frame = 0; frame + 1 < scene.num_frames; ++frame) {
          for (int y = 10; y < 240; y += 20) {
            for (int x = 10; x < 320; x += 20) {
              const auto point = simulator.pointAt(frame, {x, y});
              if (!point) continue;
              const Projection next = unhidden(simulator, *point, frame + 1);
              if (!next.ok()) continue;
              sum += (next.pixel - Vector2d(x, y)).norm();
              ++count;
            }
          }
        }
        EXPECT_GT(count, 3000);
        EXPECT_NEAR(sum / count, flow, 0.15 * flow) << camera.modelId() << " " << static_cast<int>(path);
        ++num_checked;
      }
    }
  }
  EXPECT_EQ(num_checked, 12);
}

TEST(FootageFlow, IsAnEightiethOfTheWidthByDefault) {
  FootageScene scene = footageScene(footagePinhole());
  scene.flow_px = 0;
  EXPECT_EQ(FootageSimulator(scene).scene().flow_px, 4);
}

TEST(FootageTracks, AreWhereTheirPointsProject) {
  for (const AnyCamera& camera : {footageRadtan(), footageFisheye()}) {
    FootageScene scene = footageScene(camera);
    scene.effects.moving_objects = 5;
    scene.effects.zoom = 1.3;
    const FootageSimulator simulator(scene);
    const auto tracks = simulator.trackPoints();
    int num_pixels = 0;
    int num_moving = 0;
    std::vector<int> num_in_frame(20);
    for (std::size_t i = 0; i < tracks.size(); ++i) {
      EXPECT_EQ(tracks[i].id, static_cast<int>(i));
      num_moving += tracks[i].point.is_moving ? 1 : 0;
      for (std::size_t k = 0; k < tracks[i].pixels.size(); ++k) {
        const int frame = tracks[i].first_frame + static_cast<int>(k);
        const Projection expected = unhidden(simulator, tracks[i].point, frame);
        ASSERT_TRUE(expected.ok());
        EXPECT_LT((expected.pixel - tracks[i].pixels[k]).norm(), 1e-9);
        ++num_in_frame[static_cast<std::size_t>(frame)];
        ++num_pixels;
      }
    }
    EXPECT_GT(num_pixels, 20 * 16 * 12 * 9 / 10);
    // At least one point for each cell, but for those without rays.
    EXPECT_GE(*std::ranges::min_element(num_in_frame), 16 * 12 * 9 / 10);
    EXPECT_GT(num_moving, 10);
  }
}

// A point that is seen is the one that its pixel shows; one that is not has something before it.
TEST(FootageTracks, EndWhereSomethingHidesThePoint) {
  for (const AnyCamera& camera : {footagePinhole(), footageFisheye()}) {
    FootageScene scene = footageScene(camera);
    scene.effects.moving_objects = 8;
    const FootageSimulator simulator(scene);
    int num_seen = 0;
    int num_hidden = 0;
    for (int y = 4; y < 240; y += 8) {
      for (int x = 4; x < 320; x += 8) {
        const auto point = simulator.pointAt(0, {x, y});
        if (!point) continue;
        const Projection place = unhidden(simulator, *point, 12);
        if (!place.ok() || place.pixel.minCoeff() < 0 || place.pixel.x() > 319 || place.pixel.y() > 239)
          continue;
        const auto there = simulator.pointAt(12, place.pixel);
        ASSERT_TRUE(there.has_value());
        const double distance = [&](const ScenePoint& p) {
          return (simulator.poseOf(12) * simulator.positionOf(p, simulator.timeOf(12))).norm();
        }(*there);
        const double own = (simulator.poseOf(12) * simulator.positionOf(*point, simulator.timeOf(12))).norm();
        if (simulator.pixelOf(*point, 12)) {
          EXPECT_NEAR(distance, own, 1e-6);
          EXPECT_EQ(there->body, point->body);
          ++num_seen;
        } else {
          EXPECT_LT(distance, own - 1e-6);
          ++num_hidden;
        }
      }
    }
    EXPECT_GT(num_seen, 300) << camera.modelId();
    EXPECT_GT(num_hidden, 20) << camera.modelId();
  }
}

TEST(FootageRollingShutter, TakesEachRowAtItsOwnTime) {
  FootageScene scene = footageScene(footageRadtan());
  scene.effects.moving_objects = 4;
  const FootageSimulator global(scene);
  scene.effects.rolling_shutter = 0.8;
  const FootageSimulator rolling(scene);
  int num_checked = 0;
  int num_right_way = 0;
  int num_far_from_middle = 0;
  for (const TrueTrack& track : rolling.trackPoints()) {
    for (std::size_t k = 0; k < track.pixels.size(); ++k) {
      const int frame = track.first_frame + static_cast<int>(k);
      const Vector2d& pixel = track.pixels[k];
      const double time = (frame + 0.8 * (pixel.y() - 119.5) / 240) / scene.frame_rate_hz;
      const Projection at_its_time =
          scene.camera.project(global.poseAt(time) * global.positionOf(track.point, time));
      ASSERT_TRUE(at_its_time.ok());
      EXPECT_LT((at_its_time.pixel - pixel).norm(), 1e-7);
      ++num_checked;
      // Rows above the middle are taken earlier: a point there has moved less.
      const Projection now = unhidden(global, track.point, frame);
      const Projection next = unhidden(global, track.point, frame + 1);
      if (!now.ok() || !next.ok() || std::abs(pixel.y() - 119.5) < 60) continue;
      ++num_far_from_middle;
      const double along = (pixel - now.pixel).dot(next.pixel - now.pixel);
      if ((along > 0) == (pixel.y() > 119.5)) ++num_right_way;
    }
  }
  EXPECT_GT(num_checked, 3000);
  EXPECT_GT(num_far_from_middle, 1000);
  EXPECT_GT(num_right_way, 0.98 * num_far_from_middle);
}

double shakiness(const FootageSimulator& simulator) {
  double sum2 = 0;
  for (int frame = 1; frame + 1 < simulator.numFrames(); ++frame) {
    const SO3 before = (simulator.poseOf(frame) * simulator.poseOf(frame - 1).inverse()).rotation;
    const SO3 after = (simulator.poseOf(frame + 1) * simulator.poseOf(frame).inverse()).rotation;
    sum2 += (after.log() - before.log()).squaredNorm();
  }
  return std::sqrt(sum2);
}

TEST(FootageStabilisation, SmoothsTheOrientationAndBreaksOnlyDistortedModels) {
  FootageScene scene = footageScene(footagePinhole());
  scene.effects.shake_px = 4;
  const double before = shakiness(FootageSimulator(scene));
  scene.effects.stabilisation_frames = 8;
  const FootageSimulator pinhole(scene);
  EXPECT_LT(shakiness(pinhole), 0.2 * before);
  scene.camera = footageRadtan();
  const FootageSimulator radtan(scene);
  const auto largestError = [](const FootageSimulator& simulator) {
    double most = 0;
    int count = 0;
    for (const TrueTrack& track : simulator.trackPoints()) {
      for (std::size_t k = 0; k < track.pixels.size(); ++k) {
        const Projection model = unhidden(simulator, track.point, track.first_frame + static_cast<int>(k));
        if (!model.ok()) continue;
        most = std::max(most, (model.pixel - track.pixels[k]).norm());
        ++count;
      }
    }
    EXPECT_GT(count, 3000);
    return most;
  };
  EXPECT_LT(largestError(pinhole), 1e-8);
  EXPECT_GT(largestError(radtan), 0.3);
  EXPECT_LT(largestError(radtan), 20);
}

TEST(FootageZoom, ChangesTheFocalLengthOverTheFrames) {
  FootageScene scene = footageScene(footagePinhole());
  scene.effects.zoom = 1.5;
  const FootageSimulator simulator(scene);
  EXPECT_NEAR(simulator.cameraOf(0).parameter("fx"), 250, 1e-9);
  EXPECT_NEAR(simulator.cameraOf(19).parameter("fx"), 375, 1e-9);
  EXPECT_NEAR(simulator.cameraOf(19).parameter("fy"), 378, 1e-9);
  EXPECT_EQ(simulator.cameraOf(19).parameter("cx"), 158);
}

TEST(FootageCrowd, CoversTheShareThatWasAskedFor) {
  int num_checked = 0;
  for (const FootagePath path : {FootagePath::kStatic, FootagePath::kWalk}) {
    for (const AnyCamera& camera : {footagePinhole(), footageFisheye()}) {
      FootageScene scene = footageScene(camera);
      scene.path = path;
      scene.effects.moving_objects = 40;
      scene.effects.moving_share = 0.75;
      const FootageSimulator simulator(scene);
      int num_moving = 0;
      int num_seen = 0;
      for (int frame = 0; frame < 20; ++frame) {
        for (int y = 6; y < 240; y += 12) {
          for (int x = 6; x < 320; x += 12) {
            const auto point = simulator.pointAt(frame, {x, y});
            if (!point) continue;
            ++num_seen;
            if (point->is_moving) ++num_moving;
          }
        }
      }
      ASSERT_GT(num_seen, 5000);
      EXPECT_NEAR(static_cast<double>(num_moving) / num_seen, 0.75, 0.06) << camera.modelId();
      ++num_checked;
    }
  }
  EXPECT_EQ(num_checked, 4);

  FootageScene scene = footageScene(footagePinhole());
  scene.effects.moving_objects = 1;
  scene.effects.moving_share = 0.95;
  try {
    const FootageSimulator simulator(scene);
    FAIL() << "one object cannot cover so much";
  } catch (const Error& error) {
    EXPECT_THAT(error.what(), HasSubstr("raise moving_objects"));
  }
}

TEST(FootageCrowd, MovesOnItsOwn) {
  FootageScene scene = footageScene(footagePinhole());
  scene.path = FootagePath::kStatic;
  scene.effects.moving_objects = 12;
  const FootageSimulator simulator(scene);
  double sum = 0;
  int num_steps = 0;
  for (const TrueTrack& track : simulator.trackPoints()) {
    for (std::size_t k = 1; k < track.pixels.size(); ++k) {
      const double step = (track.pixels[k] - track.pixels[k - 1]).norm();
      if (!track.point.is_moving) {
        EXPECT_LT(step, 1e-9);
        continue;
      }
      sum += step;
      ++num_steps;
    }
  }
  ASSERT_GT(num_steps, 300);
  EXPECT_GT(sum / num_steps, 0.5 * scene.flow_px);
  EXPECT_LT(sum / num_steps, 2 * scene.flow_px);
  // Those alone can be left out.
  int num_moving = 0;
  for (const TrueTrack& track : simulator.trackPoints({.on_moving_objects = false}))
    num_moving += track.point.is_moving ? 1 : 0;
  EXPECT_EQ(num_moving, 0);
}

TEST(FootageScene, RefusesWhatMakesNoFootage) {
  const auto complaint = [](auto change) -> std::string {
    FootageScene scene = footageScene(footagePinhole());
    change(scene);
    try {
      const FootageSimulator simulator(scene);
    } catch (const Error& error) {
      return error.what();
    }
    return "";
  };
  EXPECT_EQ(complaint([](FootageScene&) {}), "");
  EXPECT_THAT(complaint([](FootageScene& s) { s.num_frames = 0; }), HasSubstr("frames"));
  EXPECT_THAT(complaint([](FootageScene& s) { s.flow_px = -1; }), HasSubstr("flow_px"));
  EXPECT_THAT(complaint([](FootageScene& s) { s.effects.zoom = std::numeric_limits<double>::quiet_NaN(); }),
              HasSubstr("zoom"));
  EXPECT_THAT(complaint([](FootageScene& s) { s.effects.rolling_shutter = 1.5; }),
              HasSubstr("rolling_shutter"));
  EXPECT_THAT(complaint([](FootageScene& s) { s.effects.moving_share = 0.5; }), HasSubstr("moving_share"));
  // A lens so long that it sees nothing but the end of the corridor.
  EXPECT_THAT(complaint([](FootageScene& s) {
                s.camera = AnyCamera::make("pinhole", std::vector<double>{1e6, 1e6, 159.5, 119.5});
                s.path = FootagePath::kStraight;
                s.flow_px = 50;
              }),
              HasSubstr("flow_px: 50, but the greatest flow"));
  EXPECT_THAT(complaint([](FootageScene& s) {
                s.surroundings = FootageSurroundings::kFar;
                s.path = FootagePath::kStraight;
              }),
              HasSubstr("straight"));
}

}  // namespace
}  // namespace alidade
