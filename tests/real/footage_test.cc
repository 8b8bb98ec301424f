// SPDX-License-Identifier: MIT
// The path of a camera against motion capture: nine frames of the sequence freiburg1_desk of the TUM RGB-D
// benchmark (Sturm et al. 2012).
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <string>
#include <utility>
#include <vector>

#include <gtest/gtest.h>
#include <Eigen/Geometry>

#include "alidade/core/text.h"
#include "alidade/files/pose_list.h"
#include "alidade/footage/follow/footage_frames.h"
#include "alidade/footage/map/odometry.h"
#include "alidade/imagery/image_list.h"

namespace alidade {
namespace {

namespace fs = std::filesystem;

// Rolling shutter and the clock of the motion capture: an adjustment of all frames and points together is 2.4
// % off as well.
constexpr double kMostShare = 0.03;

std::string deskFolder() {
  const char* root = std::getenv("ALIDADE_REAL_DATA");
  return (root != nullptr ? std::string(root) : std::string("/nonexistent")) + "/footage/tum_fr1_desk/";
}

// Where motion capture saw the camera at a time, between its two nearest samples.
Eigen::Vector3d placeAt(const PoseList& truth, double time) {
  std::size_t next = 1;
  while (next + 1 < truth.poses.size() && parseDouble(truth.poses[next].id).value() < time) ++next;
  const double before = parseDouble(truth.poses[next - 1].id).value();
  const double after = parseDouble(truth.poses[next].id).value();
  const double share = (time - before) / (after - before);
  return (1 - share) * truth.poses[next - 1].camera_from_x.inverse().translation +
         share * truth.poses[next].camera_from_x.inverse().translation;
}

TEST(Footage, OfADeskGivesThePathOfItsCamera) {
  if (!fs::exists(deskFolder())) {
    ASSERT_EQ(std::getenv("ALIDADE_REAL_DATA"), nullptr) << "it is set, but has no " << deskFolder();
    GTEST_SKIP() << "no footage of the desk";
  }
  const std::vector<std::string> inputs = {deskFolder() + "rgb"};
  const std::vector<std::string> images = listImages(inputs);
  ASSERT_EQ(images.size(), 9u);
  const PoseList truth = readPoseList(deskFolder() + "groundtruth.txt", "world_from_camera");
  Eigen::Matrix3Xd places(3, static_cast<Eigen::Index>(images.size()));
  double length = 0;
  for (Eigen::Index i = 0; i < places.cols(); ++i) {
    const std::string time = fs::path(images[static_cast<std::size_t>(i)]).stem().string();
    places.col(i) = placeAt(truth, parseDouble(time).value());
    if (i > 0) length += (places.col(i) - places.col(i - 1)).norm();
  }
  const AnyCamera camera = AnyCamera::make(
      "radtan", std::vector<double>{517.3, 516.5, 318.6, 255.3, 0.2624, -0.9531, -0.0054, 0.0026, 1.1633});
  int num_checked = 0;
  for (const auto& [name, kind] :
       {std::pair("flow", FrontEndKind::kFlow), std::pair("keypoints", FrontEndKind::kKeyPoints)}) {
    Odometry odometry(camera, {640, 480});
    const auto front_end = makeFrontEnd(kind);
    forEachFrame(inputs,
                 [&](const auto& frame) { odometry.add(frame.number, front_end->follow(frame.image)); });
    const Path path = odometry.finish();
    ASSERT_EQ(path.segments.size(), 1u) << name;
    ASSERT_EQ(path.numPosed(), images.size()) << name;
    Eigen::Matrix3Xd found(3, places.cols());
    for (Eigen::Index i = 0; i < places.cols(); ++i)
      found.col(i) = path.frames[static_cast<std::size_t>(i)].camera_from_world.inverse().translation;
    const Eigen::Matrix4d similarity = Eigen::umeyama(found, places, true);
    const Eigen::Matrix3Xd moved = similarity.topRows<3>() * found.colwise().homogeneous();
    const double error = std::sqrt((moved - places).squaredNorm() / static_cast<double>(places.cols()));
    std::printf("desk by %s: %.1f mm off a path of %.0f mm (%.2f %%), reprojection RMS %.2f px\n", name,
                1e3 * error, 1e3 * length, 100 * error / length, path.rms_px);
    EXPECT_LT(error, kMostShare * length) << name;
    ++num_checked;
  }
  EXPECT_EQ(num_checked, 2);
}

}  // namespace
}  // namespace alidade
