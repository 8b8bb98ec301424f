// SPDX-License-Identifier: MIT
#include "alidade/simulate/scene_bodies.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <limits>
#include <numbers>

#include "alidade/core/random.h"
#include "alidade/geometry/decompositions.h"

namespace alidade {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector2d;
using Eigen::Vector3d;

constexpr double kInfinity = std::numeric_limits<double>::infinity();
constexpr double kHallHalfHeightM = 3;

// Face 2 i is at -half_size of axis i, face 2 i + 1 at +half_size.
void setFace(SurfaceHit& hit, int axis, bool is_high, const Vector3d& at, double cos_incidence) {
  hit.face = 2 * axis + (is_high ? 1 : 0);
  hit.on_face = {at[(axis + 1) % 3], at[(axis + 2) % 3]};
  hit.cos_incidence = cos_incidence;
}

void hitBox(const Vector3d& half, const Vector3d& origin, const Vector3d& ray, SurfaceHit& hit) {
  double enter = -kInfinity;
  double leave = kInfinity;
  int axis = 0;
  for (int i = 0; i < 3; ++i) {
    const double inverse = 1 / ray[i];
    const double a = (-half[i] - origin[i]) * inverse;
    const double b = (half[i] - origin[i]) * inverse;
    const double near = std::min(a, b);
    if (near > enter) {
      enter = near;
      axis = i;
    }
    leave = std::min(leave, std::max(a, b));
  }
  if (!(enter < leave) || enter <= 0 || enter >= hit.distance_m) return;
  hit.distance_m = enter;
  setFace(hit, axis, ray[axis] < 0, origin + enter * ray, std::abs(ray[axis]));
}

void hitRoom(const Vector3d& half, const Vector3d& origin, const Vector3d& ray, SurfaceHit& hit) {
  double leave = kInfinity;
  int axis = 0;
  for (int i = 0; i < 3; ++i) {
    const double far = ((ray[i] < 0 ? -half[i] : half[i]) - origin[i]) / ray[i];
    if (far < leave) {
      leave = far;
      axis = i;
    }
  }
  if (!(leave > 0) || leave >= hit.distance_m) return;
  hit.distance_m = leave;
  setFace(hit, axis, ray[axis] > 0, origin + leave * ray, std::abs(ray[axis]));
}

void hitPlane(const Vector3d& origin, const Vector3d& ray, SurfaceHit& hit) {
  if (origin.z() >= 0 || ray.z() <= 0) return;
  const double distance = -origin.z() / ray.z();
  if (distance >= hit.distance_m) return;
  hit.distance_m = distance;
  setFace(hit, 2, false, origin + distance * ray, ray.z());
}

SO3 aboutVertical(double angle_rad) {
  return SO3::exp({0, angle_rad, 0});
}

// A box or a pillar around (x, z), at most `width_m` wide along x and z.
SceneBody standingBox(double x, double z, double width_m, Random& random) {
  SceneBody box{.shape = SceneBody::Shape::kBox};
  const double half_x = 0.5 * width_m * random.uniform(0.6, 1);
  const double half_z = 0.5 * width_m * random.uniform(0.6, 1);
  const double kind = random.uniform();
  double half_y = kHallHalfHeightM;  // a pillar
  double y = 0;
  if (kind > 0.35) {
    half_y = random.uniform(0.25, 0.9);
    // Some boxes hang, so that there is something at all heights.
    y = kind > 0.65 ? random.uniform(-1.6, 1.6) : kHallHalfHeightM - half_y;
  }
  box.half_size = {half_x, half_y, half_z};
  box.world_from_body = {aboutVertical(random.uniform(0, std::numbers::pi)), {x, y, z}};
  return box;
}

// Adds two rings of boxes around the path, so that each direction has something nearer than the wall.
void addRings(std::vector<SceneBody>& bodies, Random& random) {
  constexpr int kNumBoxes = 14;
  for (int i = 0; i < kNumBoxes; ++i) {
    const double angle = 2 * std::numbers::pi * (i + random.uniform(0.2, 0.8)) / kNumBoxes;
    const double distance = i % 2 == 0 ? random.uniform(2.5, 3.2) : random.uniform(3.8, 5);
    bodies.push_back(
        standingBox(distance * std::sin(angle), distance * std::cos(angle), i % 2 == 0 ? 0.7 : 1.1, random));
  }
}

// Adds a row of boxes on either side of a straight path.
void addRows(std::vector<SceneBody>& bodies, double last_m, std::uint64_t seed) {
  constexpr double kSpacingM = 1.6;
  constexpr double kFirstM = -4;
  for (int i = 0; kFirstM + kSpacingM * i < last_m; ++i) {
    // Each box has its own random stream, so that a longer path only adds boxes.
    Random random(streamSeed(seed, static_cast<std::uint64_t>(i)));
    const double side = i % 2 == 0 ? 1 : -1;
    bodies.push_back(standingBox(side * random.uniform(1.1, 2.2),
                                 kFirstM + kSpacingM * (i + random.uniform(0, 0.6)), 0.8, random));
  }
}

// Distance from the origin along a direction that is free of everything but boxes.
double freeDistance(const std::vector<SceneBody>& still, const Vector3d& direction) {
  double distance = kInfinity;
  for (const SceneBody& body : still) {
    if (body.shape == SceneBody::Shape::kBox) continue;
    const auto views = viewBodies({body}, SE3(), 0);
    const SurfaceHit hit = castRay({body}, views, views, 0, direction);
    if (hit.body >= 0) distance = std::min(distance, hit.distance_m);
  }
  return distance;
}

// The ray of a place in the image; moved towards the centre until it exists.
Vector3d rayNear(const FootageScene& scene, const Vector2d& share) {
  const Vector2d centre(0.5 * (scene.image_size.width - 1), 0.5 * (scene.image_size.height - 1));
  Vector2d offset(scene.image_size.width * (share.x() - 0.5), scene.image_size.height * (share.y() - 0.5));
  constexpr int kMaxAttempts = 50;
  constexpr double kReduction = 0.9;
  for (int i = 0; i < kMaxAttempts; ++i, offset *= kReduction) {
    if (const auto ray = scene.camera.unproject(centre + offset)) return *ray;
  }
  return Vector3d::UnitZ();
}

// Sinusoids of about the same frequency along the three axes.
SmoothCurve wandering(const Vector3d& amplitude, double frequency, Random& random) {
  SmoothCurve curve;
  curve.amplitudes[0] = amplitude;
  for (int i = 0; i < 3; ++i) {
    curve.frequencies[0][i] = frequency * random.uniform(0.75, 1.25);
    curve.phases[0][i] = random.uniform(0, 2 * std::numbers::pi);
  }
  return curve;
}

}  // namespace

SE3 SceneBody::worldFromBodyAt(double time_frames) const {
  if (!is_moving) return world_from_body;
  return {world_from_body.rotation * SO3::exp(turn.at(time_frames)),
          world_from_body * wander.at(time_frames) + time_frames * velocity};
}

std::vector<BodyView> viewBodies(const std::vector<SceneBody>& bodies, const SE3& camera_from_world,
                                 double time_frames) {
  // Allows for the turn of a fast camera between neighbouring rows, a part of a pixel; a wide pixel is 0.01
  // rad.
  constexpr double kSlack = 0.004;
  std::vector<BodyView> views(bodies.size());
  for (std::size_t i = 0; i < bodies.size(); ++i) {
    const SE3 camera_from_body = camera_from_world * bodies[i].worldFromBodyAt(time_frames);
    BodyView& view = views[i];
    view.body_from_camera = camera_from_body.rotation.inverse().matrix();
    view.camera_in_body = -(view.body_from_camera * camera_from_body.translation);
    view.axis = camera_from_body.translation;
    if (bodies[i].shape != SceneBody::Shape::kBox) continue;
    const double distance = view.axis.norm();
    const double radius = bodies[i].half_size.norm();
    if (distance > radius) {
      view.axis /= distance;
      const double sine = radius / distance;
      view.cos_angle = std::sqrt(1 - sine * sine) - kSlack;
    }
  }
  return views;
}

SurfaceHit castRay(const std::vector<SceneBody>& bodies, const std::vector<BodyView>& views,
                   const std::vector<BodyView>& next_views, double share, const Vector3d& ray) {
  SurfaceHit hit;
  hit.distance_m = kInfinity;
  for (std::size_t i = 0; i < bodies.size(); ++i) {
    const BodyView& view = views[i];
    if (view.cos_angle > -1 && view.axis.dot(ray) < view.cos_angle) continue;
    Vector3d origin = view.camera_in_body;
    Vector3d direction = view.body_from_camera * ray;
    if (share > 0) {
      origin += share * (next_views[i].camera_in_body - origin);
      direction += share * (next_views[i].body_from_camera * ray - direction);
    }
    const double before = hit.distance_m;
    switch (bodies[i].shape) {
      case SceneBody::Shape::kBox:
        hitBox(bodies[i].half_size, origin, direction, hit);
        break;
      case SceneBody::Shape::kRoom:
        hitRoom(bodies[i].half_size, origin, direction, hit);
        break;
      case SceneBody::Shape::kPlane:
        hitPlane(origin, direction, hit);
        break;
    }
    if (hit.distance_m < before) hit.body = static_cast<int>(i);
  }
  return hit;
}

std::vector<SceneBody> stillBodies(const FootageScene& scene, double travel_m) {
  const bool is_straight = scene.path == FootagePath::kStraight;
  Random random(streamSeed(scene.seed, 2));
  std::vector<SceneBody> bodies;
  switch (scene.surroundings) {
    case FootageSurroundings::kRoom: {
      SceneBody room{.shape = SceneBody::Shape::kRoom, .half_size = {6, kHallHalfHeightM, 6.5}};
      if (is_straight) {
        constexpr double kBehindM = 6;
        constexpr double kAheadM = 30;
        room.half_size = {3, kHallHalfHeightM, 0.5 * (kBehindM + travel_m + kAheadM)};
        room.world_from_body.translation.z() = room.half_size.z() - kBehindM;
      }
      bodies.push_back(room);
      if (is_straight) {
        constexpr double kBoxesAheadM = 24;
        addRows(bodies, travel_m + kBoxesAheadM, streamSeed(scene.seed, 3));
      } else {
        addRings(bodies, random);
      }
      break;
    }
    case FootageSurroundings::kPlane: {
      SceneBody plane{.shape = SceneBody::Shape::kPlane};
      if (is_straight) {
        constexpr double kHeightM = 1.2;  // height of the camera above the ground
        plane.world_from_body = {SO3::exp({-0.5 * std::numbers::pi, 0, 0}), {0, kHeightM, 0}};
      } else {
        constexpr double kAheadM = 3.5;
        plane.world_from_body = {SO3::exp({random.uniform(-0.2, 0.2), random.uniform(-0.2, 0.2), 0}),
                                 {0, 0, kAheadM}};
      }
      bodies.push_back(plane);
      break;
    }
    case FootageSurroundings::kFar: {
      constexpr double kFarM = 1e7;  // a sideways metre moves it by 1e-7 rad
      bodies.push_back({.shape = SceneBody::Shape::kRoom,
                        .half_size = Vector3d::Constant(kFarM),
                        .texture_scale = kFarM / 5});
      break;
    }
  }
  for (std::size_t i = 0; i < bodies.size(); ++i)
    bodies[i].seed = static_cast<std::uint32_t>(streamSeed(streamSeed(scene.seed, 4), i));
  return bodies;
}

std::vector<SceneBody> movingBodies(const FootageScene& scene, const FootageMotion& motion,
                                    const std::vector<SceneBody>& still, double focal_px, double scale) {
  constexpr double kClearM = 0.5;           // between the camera's reach and a body
  constexpr double kDistancePerHalf = 1.8;  // more than the half diagonal of a cube
  constexpr double kFreeShare = 0.85;       // share of the distance to the walls
  constexpr double kMaxFrequency = 0.3;     // radians per frame
  // A wave of amplitude a and frequency w moves by 2 / pi a w per frame on average, along each of two axes.
  const double swing = std::clamp(scene.flow_px / (focal_px * kMaxFrequency), 0.12, 0.5);
  const double frequency = std::min(kMaxFrequency, scene.flow_px / (0.9 * swing * focal_px));
  std::vector<SceneBody> bodies;
  for (int i = 0; i < scene.effects.moving_objects; ++i) {
    Random random(streamSeed(streamSeed(scene.seed, 5), static_cast<std::uint64_t>(i)));
    // A sequence that fills the image evenly for any number of points (Roberts 2018, R2).
    const double n = i + 1;
    const Vector2d share(std::fmod(0.5 + 0.7548776662466927 * n, 1),
                         std::fmod(0.5 + 0.5698402909980532 * n, 1));
    const Vector3d ray = rayNear(scene, share);
    const double start = motion.reach() + kClearM;
    const double most_half =
        std::max(0.02, (kFreeShare * freeDistance(still, ray) - start) / kDistancePerHalf);
    SceneBody body{.shape = SceneBody::Shape::kBox, .is_moving = true, .velocity = motion.velocity()};
    const double half = std::min(most_half, scale * random.uniform(0.2, 0.4));
    body.half_size = half * Vector3d(1, random.uniform(0.7, 1), random.uniform(0.5, 1));
    const double distance = start + kDistancePerHalf * half;
    const SO3 facing = SO3::fromQuaternion(shortestTurn(Vector3d::UnitZ(), ray));
    body.world_from_body = {facing, distance * ray};
    // Sideways, so that it does not come closer.
    body.wander = wandering(distance * Vector3d(swing, swing, 0.03), frequency, random);
    body.turn = wandering(Vector3d(0.3, 0.3, 0.2), 0.5 * frequency, random);
    body.seed =
        static_cast<std::uint32_t>(streamSeed(streamSeed(scene.seed, 6), static_cast<std::uint64_t>(i)));
    bodies.push_back(body);
  }
  return bodies;
}

}  // namespace alidade
