// SPDX-License-Identifier: MIT
#include "alidade/simulate/footage_simulator.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <string>
#include <utility>
#include <vector>

#include "alidade/core/error.h"
#include "alidade/core/random.h"
#include "alidade/core/text.h"
#include "alidade/record/scene.h"

namespace alidade {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;

FootageScene checked(FootageScene scene) {
  scene.validate();
  constexpr double kDefaultFlowOfWidth = 1.0 / 80;
  if (scene.flow_px == 0) scene.flow_px = kDefaultFlowOfWidth * scene.image_size.width;
  return scene;
}

// The scene with only motion and bodies, without the effects that change measured pixels.
FootageScene withoutEffects(FootageScene scene) {
  scene.effects.shake_px = 0;
  scene.effects.rolling_shutter = 0;
  scene.effects.stabilisation_frames = 0;
  scene.effects.zoom = 1;
  return scene;
}

// Cameras of all frames of footage with zoom, or one camera for all frames.
std::vector<AnyCamera> zoomedCameras(const FootageScene& scene) {
  if (scene.effects.zoom == 1 || scene.num_frames == 1) return {scene.camera};
  std::vector<AnyCamera> cameras;
  const auto given = scene.camera.parameters();
  for (int frame = 0; frame < scene.num_frames; ++frame) {
    std::vector<double> params(given.begin(), given.end());
    const double focal_scale =
        std::lerp(1.0, scene.effects.zoom, static_cast<double>(frame) / (scene.num_frames - 1));
    params[0] *= focal_scale;
    params[1] *= focal_scale;
    cameras.push_back(scene.camera.withParameters(params));
  }
  return cameras;
}

// Calls visit(place, hit) for each place of a grid at which a frame shows a surface.
template <class Visit>
void forEachHit(const FootageFrame& frame, ImageSize size, int columns, int rows, const Visit& visit) {
  for (int j = 0; j < rows; ++j) {
    for (int i = 0; i < columns; ++i) {
      const Vector2d place(size.width * (i + 0.5) / columns - 0.5, size.height * (j + 0.5) / rows - 0.5);
      const SurfaceHit hit = frame.look(place);
      if (hit.body >= 0) visit(place, hit);
    }
  }
}

// Frames at which a quantity is measured, spread over the footage.
std::vector<int> sampleFrames(int num_frames, int count) {
  std::vector<int> frames;
  for (int i = 0; i < std::min(count, num_frames); ++i)
    frames.push_back(static_cast<int>((i + 0.5) * num_frames / std::min(count, num_frames)));
  return frames;
}

}  // namespace

FootageSimulator::FootageSimulator(FootageScene scene)
    : scene_(checked(std::move(scene))),
      cameras_(zoomedCameras(scene_)),
      focal_px_(focalAtCentre(scene_.camera).mean()),
      motion_(scene_, focal_px_) {
  findSpeed();
  addMovingBodies();
}

double FootageSimulator::meanFlow() const {
  constexpr int kColumns = 8;
  constexpr int kRows = 6;
  constexpr int kNumFrames = 15;
  const FootageScene plain = withoutEffects(scene_);
  const FootageMotion motion = [&] {
    FootageMotion without_shake(plain, focal_px_);
    without_shake.setSpeed(motion_.speed());
    return without_shake;
  }();
  double sum = 0;
  int count = 0;
  for (const int index : sampleFrames(scene_.num_frames, kNumFrames)) {
    const FootageFrame now(plain, plain.camera, motion, bodies_, index);
    const FootageFrame next(plain, plain.camera, motion, bodies_, index + 1);
    forEachHit(now, scene_.image_size, kColumns, kRows, [&](const Vector2d& from, const SurfaceHit& hit) {
      const auto to = next.project(hit.body, pointOf(hit).in_body);
      if (!to) return;
      sum += (*to - from).norm();
      ++count;
    });
  }
  return count > 0 ? sum / count : 0;
}

void FootageSimulator::findSpeed() {
  bodies_ = stillBodies(scene_, 0);
  if (scene_.path == FootagePath::kStatic) return;
  // Searches the first crossing from slow to fast. Flow is continuous, but only roughly proportional to
  // speed: at a different speed, the camera passes different parts of the path and, on a straight one, more
  // of the surroundings.
  const bool is_straight = scene_.path == FootagePath::kStraight;
  constexpr double kMaxMetres = 5;       // per frame
  constexpr double kMaxParameter = 0.5;  // per frame; the shortest period of the curves is about three
  const double most = is_straight ? kMaxMetres : kMaxParameter;
  const auto flowAt = [&](double speed) {
    setSpeed(speed);
    return meanFlow();
  };
  constexpr double kStep = 1.4;
  double low = 0;
  double high = std::min(most, 0.25 * scene_.flow_px / focal_px_);  // at speed 1, about 0.7 focal lengths
  double flow = flowAt(high);
  while (flow < scene_.flow_px && high < most) {
    low = high;
    high = std::min(most, kStep * high);
    flow = flowAt(high);
  }
  if (flow < scene_.flow_px) {
    throw inputError({.where = "flow_px",
                      .found = exactText(scene_.flow_px) +
                               ", but the greatest flow with this camera and path is " +
                               exactText(std::floor(10 * flow) / 10),
                      .next_step = "reduce flow_px, or change the path or the surroundings"});
  }
  constexpr int kNumBisections = 6;
  for (int i = 0; i < kNumBisections; ++i) {
    const double middle = 0.5 * (low + high);
    (flowAt(middle) < scene_.flow_px ? low : high) = middle;
  }
  setSpeed(high);
}

void FootageSimulator::setSpeed(double speed) {
  motion_.setSpeed(speed);
  bodies_ = stillBodies(scene_, motion_.velocity().z() * scene_.num_frames);
}

double FootageSimulator::movingShare() const {
  constexpr int kColumns = 24;
  constexpr int kRows = 18;
  constexpr int kNumFrames = 6;
  int num_moving = 0;
  int num_rays = 0;
  for (const int index : sampleFrames(scene_.num_frames, kNumFrames)) {
    forEachHit(frame(index), scene_.image_size, kColumns, kRows, [&](const Vector2d&, const SurfaceHit& hit) {
      ++num_rays;
      if (pointOf(hit).is_moving) ++num_moving;
    });
  }
  return num_rays > 0 ? static_cast<double>(num_moving) / num_rays : 0;
}

void FootageSimulator::addMovingBodies() {
  if (scene_.effects.moving_objects == 0) return;
  const std::vector<SceneBody> still = bodies_;
  const auto shareAt = [&](double scale) {
    bodies_ = still;
    const auto moving = movingBodies(scene_, motion_, still, focal_px_, scale);
    bodies_.insert(bodies_.end(), moving.begin(), moving.end());
    return movingShare();
  };
  constexpr double kLargestScale = 20;
  if (scene_.effects.moving_share == 0) {
    shareAt(1);
    return;
  }
  const double most = shareAt(kLargestScale);
  if (most < scene_.effects.moving_share) {
    throw inputError({.where = "moving_share",
                      .found = exactText(scene_.effects.moving_share) + ", but " +
                               std::to_string(scene_.effects.moving_objects) +
                               " moving objects cover at most " + exactText(std::floor(100 * most) / 100) +
                               " of the image",
                      .next_step = "raise moving_objects, or reduce moving_share"});
  }
  double low = 0.01;
  double high = kLargestScale;
  constexpr int kNumBisections = 10;
  for (int i = 0; i < kNumBisections; ++i) {
    const double middle = std::sqrt(low * high);
    (shareAt(middle) < scene_.effects.moving_share ? low : high) = middle;
  }
  shareAt(high);
}

SE3 FootageSimulator::poseAt(double time_s) const {
  return motion_.pose(time_s * scene_.frame_rate_hz);
}

SE3 FootageSimulator::poseOf(int frame_index) const {
  return SE3{frame(frame_index).correction(), Vector3d::Zero()} * motion_.pose(frame_index);
}

GrayImage FootageSimulator::renderFrame(int frame_index, const CancelFlag* cancel) const {
  const std::uint64_t noise_seed =
      streamSeed(streamSeed(scene_.seed, 7), static_cast<std::uint64_t>(frame_index));
  return renderFootageFrame(scene_, bodies_, frame(frame_index), noise_seed, cancel);
}

std::optional<ScenePoint> FootageSimulator::pointAt(int frame_index, const Vector2d& pixel) const {
  const SurfaceHit hit = frame(frame_index).look(pixel);
  return hit.body < 0 ? std::nullopt : std::optional(pointOf(hit));
}

ScenePoint FootageSimulator::pointOf(const SurfaceHit& hit) const {
  const SceneBody& body = bodies_[static_cast<std::size_t>(hit.body)];
  ScenePoint point{.body = hit.body, .face = hit.face, .in_body = {}, .is_moving = body.is_moving};
  if (body.shape == SceneBody::Shape::kPlane) {
    point.in_body = {hit.on_face.x(), hit.on_face.y(), 0};
    return point;
  }
  const int axis = hit.face / 2;
  point.in_body[axis] = hit.face % 2 == 1 ? body.half_size[axis] : -body.half_size[axis];
  point.in_body[(axis + 1) % 3] = hit.on_face.x();
  point.in_body[(axis + 2) % 3] = hit.on_face.y();
  return point;
}

std::optional<Vector2d> FootageSimulator::pixelOf(const ScenePoint& point, int frame_index) const {
  return frame(frame_index).see(point.body, point.in_body);
}

Vector3d FootageSimulator::positionOf(const ScenePoint& point, double time_s) const {
  return bodies_.at(static_cast<std::size_t>(point.body)).worldFromBodyAt(time_s * scene_.frame_rate_hz) *
         point.in_body;
}

std::vector<TrueTrack> FootageSimulator::trackPoints(const TrackOptions& options) const {
  detail::checkOption("columns", options.columns, 1, scene_.image_size.width);
  detail::checkOption("rows", options.rows, 1, scene_.image_size.height);
  const auto cellAt = [&](int i, int j) {
    return static_cast<std::size_t>(j) * static_cast<std::size_t>(options.columns) +
           static_cast<std::size_t>(i);
  };
  const auto cellOf = [&](const Vector2d& p) {
    const auto i = static_cast<int>((p.x() + 0.5) * options.columns / scene_.image_size.width);
    const auto j = static_cast<int>((p.y() + 0.5) * options.rows / scene_.image_size.height);
    return cellAt(std::min(i, options.columns - 1), std::min(j, options.rows - 1));
  };
  Random random(streamSeed(scene_.seed, 8));
  std::vector<TrueTrack> tracks;
  std::vector<std::size_t> active;
  for (int index = 0; index < scene_.num_frames; ++index) {
    const FootageFrame now = frame(index);
    std::vector<bool> is_taken(cellAt(0, options.rows));
    std::erase_if(active, [&](std::size_t i) {
      const auto pixel = now.see(tracks[i].point.body, tracks[i].point.in_body);
      if (!pixel) return true;
      tracks[i].pixels.push_back(*pixel);
      is_taken[cellOf(*pixel)] = true;
      return false;
    });
    for (int j = 0; j < options.rows; ++j) {
      for (int i = 0; i < options.columns; ++i) {
        if (is_taken[cellAt(i, j)]) continue;
        const double u = scene_.image_size.width * (i + random.uniform()) / options.columns - 0.5;
        const double v = scene_.image_size.height * (j + random.uniform()) / options.rows - 0.5;
        const SurfaceHit hit = now.look({u, v});
        if (hit.body < 0) continue;
        const ScenePoint point = pointOf(hit);
        if (point.is_moving && !options.on_moving_objects) continue;
        const auto pixel = now.see(point.body, point.in_body);
        if (!pixel) continue;  // exactly on the border, by rounding
        active.push_back(tracks.size());
        tracks.push_back({static_cast<int>(tracks.size()), point, index, {*pixel}});
      }
    }
  }
  return tracks;
}

}  // namespace alidade
