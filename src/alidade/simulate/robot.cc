// SPDX-License-Identifier: MIT
#include "alidade/simulate/robot.h"

#include <array>
#include <cmath>
#include <string>
#include <utility>

#include "alidade/core/degrees.h"
#include "alidade/core/error.h"
#include "alidade/geometry/decompositions.h"
#include "alidade/geometry/rotation_conversions.h"
#include "alidade/simulate/observe.h"

namespace alidade {
namespace {

using Eigen::Vector3d;

Vector3d inPlane(double length, Random& random) {
  const double azimuth = random.uniform(0, 360 * kRadPerDeg);
  return length * Vector3d(std::cos(azimuth), std::sin(azimuth), 0);
}

// A turn about z, and then a tilt about an axis of the xy plane, uniform over the disc of tilts.
SO3 tiltAndTurn(double max_tilt_deg, double max_turn_deg, Random& random) {
  const double tilt = kRadPerDeg * max_tilt_deg * std::sqrt(random.uniform());
  const SO3 tilted = SO3::exp(inPlane(tilt, random));
  return tilted * SO3::exp({0, 0, kRadPerDeg * max_turn_deg * random.uniform(-1, 1)});
}

void placeCameraAndBoard(RobotSet& set, Random& random) {
  auto& [rotation, translation] = set.mount_from_camera;
  Vector3d middle(0.6, 0, 0);
  if (set.scene.camera_on == CameraOn::kHand) {
    rotation = tiltAndTurn(15, 180, random);
    translation = inPlane(1, random);
    translation.z() = random.uniform();
    translation *= random.uniform(0.05, 0.12) / translation.norm();
  } else {
    // It looks at the base: its z axis is -x of the base, and its y axis -z.
    rotation = SO3::fromQuaternion({0.5, -0.5, -0.5, 0.5}) * tiltAndTurn(15, 15, random);
    translation = Vector3d(1, 0, 0.4) + inPlane(0.05, random);
    middle = {0, 0, 0.08};
  }
  // The printed side, which is that of -z, looks towards z of the world.
  const SO3 lying = SO3::exp({180 * kRadPerDeg, 0, 0}) * tiltAndTurn(2, 180, random);
  middle += inPlane(0.02, random) - lying * set.scene.board.middle();
  set.world_from_boards = {{lying, middle}};
}

// An attempt; false if the camera does not see enough of the board.
bool addView(RobotSet& set, const std::string& image, Random& random, Random& noise) {
  const auto& [camera, size, board, camera_on, num_views, robot_noise, corner_noise_px] = set.scene;
  const double x = random.uniform(-0.5, size.width - 0.5);
  const double y = random.uniform(-0.5, size.height - 0.5);
  const SO3 seen = tiltAndTurn(35, 60, random);
  const auto ray = camera.unproject({x, y});
  if (!ray) return false;
  const SO3 rotation = SO3::fromQuaternion(shortestTurn(Vector3d::UnitZ(), *ray)) * seen;
  const SE3 camera_from_board{rotation, random.uniform(0.3, 0.6) * *ray - rotation * board.middle()};
  View view = exactView(camera, size, board, camera_from_board, image);
  if (static_cast<double>(view.corners.size()) < 0.6 * board.numCorners()) return false;
  if (corner_noise_px > 0) addCornerNoise(view, corner_noise_px, noise);
  set.views.push_back(std::move(view));
  const SE3 mount_from_world = set.mount_from_camera * camera_from_board * set.world_from_boards[0].inverse();
  const SE3 truth = camera_on == CameraOn::kHand ? mount_from_world.inverse() : mount_from_world;
  SE3::Tangent deviation = SE3::Tangent::NullaryExpr([&](Eigen::Index) { return noise.normal(); });
  deviation.head<3>() *= robot_noise.translation_m;
  deviation.tail<3>() *= robot_noise.rotation_rad;
  set.base_from_gripper.push_back(truth);
  set.robot.poses.push_back({image, truth * SE3::exp(-deviation)});
  return true;
}

// What stands in the table where the mistake of this number is made.
constexpr std::array kReadings = {"the quaternion as x, y, z, w", "lengths in millimetres",
                                  "the rotation vector in degrees", "Euler angles about moving axes"};

std::vector<RobotPose> misread(std::size_t reading, std::vector<RobotPose> poses) {
  for (auto& [image, pose] : poses) {
    const Eigen::Vector4d q = quaternionXyzw(pose.rotation);
    const Vector3d angles = eulerFromRotation(pose.rotation).angles_rad;
    if (reading == 0) pose.rotation = SO3::fromQuaternion({q[0], q[1], q[2], q[3]});
    if (reading == 1) pose.translation *= 1000;
    if (reading == 2) pose.rotation = SO3::exp(kDegPerRad * pose.rotation.log());
    if (reading == 3) pose.rotation = rotationFromEuler(angles, {.is_fixed = true});
  }
  return poses;
}

}  // namespace

RobotSet simulateRobot(const RobotScene& scene, std::uint64_t seed) {
  Random random(streamSeed(seed, 0));
  Random noise(streamSeed(seed, 1));
  RobotSet set{.scene = scene};
  placeCameraAndBoard(set, random);
  for (int i = 0; i < scene.num_views; ++i) {
    const std::string image = std::to_string(1000 + i).substr(1) + ".png";
    for (int attempt = 0; !addView(set, image, random, noise); ++attempt)
      if (attempt == 1000)
        throw inputError({image, "no pose shows 60 % of the corners", "", "simulate a smaller board"});
  }
  return set;
}

void apply(RobotMistake mistake, RobotSet& set, Random& random) {
  std::vector<RobotPose>& poses = set.robot.poses;
  const std::size_t one = random.index(poses.size());
  const auto reading = static_cast<std::size_t>(mistake);
  const int columns = set.scene.board.columns();
  SE3& stated = poses[one].base_from_gripper;
  switch (mistake) {
    case RobotMistake::kInverted:
      for (auto& [image, pose] : poses) pose = pose.inverse();
      break;
    case RobotMistake::kLeftHanded:
      for (auto& [image, pose] : poses) {
        pose.translation.z() *= -1;
        pose.rotation = SO3::exp(pose.rotation.log().cwiseProduct(Vector3d(-1, -1, 1)));
      }
      break;
    case RobotMistake::kOtherRecording:
      poses = simulateRobot(set.scene, random.index(1'000'000'000)).robot.poses;
      break;
    case RobotMistake::kShifted:
      for (std::size_t i = 0; i + 1 < poses.size(); ++i)
        std::swap(poses[i].base_from_gripper, poses[i + 1].base_from_gripper);
      break;
    case RobotMistake::kSwapped:
      std::swap(stated, poses[(one + poses.size() / 2) % poses.size()].base_from_gripper);
      break;
    case RobotMistake::kBoardMoved: {
      const SE3 moved{SO3::exp({0, 0, 5 * kRadPerDeg}), inPlane(0.1, random)};
      // In the world. The gripper follows, so that the images stay the same.
      const SE3 motion = set.world_from_boards[0] * moved * set.world_from_boards[0].inverse();
      for (std::size_t i = poses.size() / 2; i < poses.size(); ++i) {
        SE3& truth = set.base_from_gripper[i];
        const SE3 deviation = truth.inverse() * poses[i].base_from_gripper;
        truth = set.scene.camera_on == CameraOn::kHand ? motion * truth : truth * motion.inverse();
        poses[i].base_from_gripper = truth * deviation;
      }
      break;
    }
    case RobotMistake::kOnePoseWrong:
      stated = stated * SE3{SO3::exp(inPlane(3 * kRadPerDeg, random)), inPlane(0.03, random)};
      break;
    case RobotMistake::kMirroredImages:
      for (View& view : set.views)
        for (auto& [id, pixel, sigma_px] : view.corners) {
          pixel.x() = view.size.width - 1 - pixel.x();
          id += columns - 1 - 2 * (id % columns);
        }
      break;
    default:
      set.robot.others = {{kReadings[reading], poses}};
      poses = misread(reading, poses);
      for (const std::size_t other : {(reading + 1) % kReadings.size(), (reading + 2) % kReadings.size()})
        set.robot.others.push_back({kReadings[other], misread(other, poses)});
      std::swap(set.robot.others[0], set.robot.others[random.index(3)]);
  }
}

}  // namespace alidade
