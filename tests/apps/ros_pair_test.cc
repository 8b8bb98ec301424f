// SPDX-License-Identifier: MIT
// The files of ROS for a rig of two cameras: rectification and projection as of cv::stereoRectify() and of
// image_geometry, and the rig again.
#include <filesystem>

#include <yaml-cpp/yaml.h>
#include <nlohmann/json.hpp>
#include <opencv2/calib3d.hpp>
#include <opencv2/core/eigen.hpp>

#include "alidade/camera/any_rig.h"
#include "alidade/core/random.h"
#include "alidade/files/formats/alidade_writer.h"
#include "alidade/files/rig_file.h"
#include "apps/command_line.h"
#include "apps/rig_support.h"
#include "support/peer.h"

namespace alidade {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;
using testing::HasSubstr;

constexpr double kSameNumber = 1e-9;

// The rectification of one file.
struct RosView {
  Eigen::Matrix3d R;
  Eigen::Matrix<double, 3, 4> P;
};

RosView viewIn(const std::string& text) {
  const YAML::Node root = YAML::Load(text);
  const auto numbers = [&](const char* key) { return root[key]["data"].as<std::vector<double>>(); };
  const std::vector<double> R = numbers("rectification_matrix");
  const std::vector<double> P = numbers("projection_matrix");
  return {.R = Eigen::Map<const Eigen::Matrix<double, 3, 3, Eigen::RowMajor>>(R.data()),
          .P = Eigen::Map<const Eigen::Matrix<double, 3, 4, Eigen::RowMajor>>(P.data())};
}

struct PairCase {
  std::string name;
  Vector3d turn;
  Vector3d place;                ///< of the second camera's origin, in the first one's frame, metres
  bool is_second_first = false;  ///< of the rectified pair
  Eigen::Index along = 0;
};

std::vector<PairCase> pairCases() {
  return {{"to the right", {0.02, -0.05, 0.03}, {0.12, 0.004, -0.002}},
          {"parallel", {0, 0, 0}, {0.1, 0, 0}},
          {"to the left", {0.02, 0.04, -0.03}, {-0.3, 0.01, 0.02}, true},
          {"below", {0.03, 0.01, 0.02}, {0.005, 0.2, 0.01}, false, 1},
          {"above", {-0.03, 0.01, 0.02}, {0.005, -0.2, 0.01}, true, 1}};
}

RigRecord rigFor(const PairCase& c) {
  RigRecord rig = pairOfCameras();
  rig.covariance.clear();
  const SO3 second_from_first = SO3::exp(c.turn);
  rig.cameras[1].camera_from_rig = {second_from_first, -(second_from_first * c.place)};
  return rig;
}

class RosPair : public testing::Test {
 protected:
  // Writes the two files of the rig.
  std::array<RosView, 2> convert(const RigRecord& rig) {
    const std::string path = scratch_.write("rig.yaml", rigFileText(rig));
    EXPECT_THAT(runAlidade({"convert", path, "--to", "ros", "-o", scratch_.path("pair")}), EndsWith(0));
    return {viewIn(scratch_.read("pair/left.yaml")), viewIn(scratch_.read("pair/right.yaml"))};
  }

  ScratchFolder scratch_;
};

TEST_F(RosPair, GivesTheRigAgain) {
  int num_checked = 0;
  for (const PairCase& c : pairCases()) {
    const RigRecord rig = rigFor(c);
    convert(rig);
    const std::string back = scratch_.path("back.yaml");
    ASSERT_THAT(runAlidade({"convert", scratch_.path("pair/left.yaml"), scratch_.path("pair/right.yaml"),
                            "-o", back}),
                EndsWith(0));
    const RigRecord read = loadRig(back);
    ASSERT_EQ(read.cameras.size(), 2U);
    const SE3 pose = read.cameras[1].camera_from_rig * read.cameras[0].camera_from_rig.inverse();
    const SE3& exact = rig.cameras[1].camera_from_rig;
    EXPECT_LT((pose.rotation.inverse() * exact.rotation).log().norm(), kSameNumber) << c.name;
    EXPECT_LT((pose.translation - exact.translation).norm(), kSameNumber) << c.name;
    for (std::size_t i = 0; i < 2; ++i) {
      const auto& camera = read.cameras[i].camera;
      const auto& given = rig.cameras[i].camera;
      EXPECT_EQ(camera.name.name, given.name.name);
      EXPECT_EQ(camera.camera.modelId(), given.camera.modelId());
      EXPECT_TRUE(std::ranges::equal(camera.camera.parameters(), given.camera.parameters()));
    }
    EXPECT_THAT(runAlidade({"validate", scratch_.path("pair")}), EndsWith(0));
    ++num_checked;
  }
  EXPECT_EQ(num_checked, 5);
}

// Two files that belong together state more than each by itself.
TEST_F(RosPair, IsCheckedAsAPair) {
  int num_checked = 0;
  for (const PairCase& c : pairCases()) {
    convert(rigFor(c));
    const std::string left = scratch_.path("pair/left.yaml");
    const RunResult good = runAlidade({"validate", left, scratch_.path("pair/right.yaml"), "--verbose"});
    EXPECT_THAT(good, EndsWith(0));
    EXPECT_THAT(good.out,
                testing::AllOf(HasSubstr("the rectified images share their "), HasSubstr(" m apart")));
    // Another right camera: its rows are elsewhere.
    YAML::Node other = YAML::LoadFile(scratch_.path("pair/right.yaml"));
    const std::size_t across = c.along == 0 ? 6 : 2;
    other["projection_matrix"]["data"][across] =
        other["projection_matrix"]["data"][across].as<double>() + 0.5;
    const std::string wrong = scratch_.write("wrong.yaml", YAML::Dump(other) + "\n");
    const RunResult bad = runAlidade({"validate", left, wrong});
    EXPECT_THAT(bad, EndsWith(3));
    EXPECT_THAT(bad.out,
                testing::AllOf(HasSubstr("rows: the rectified images have different "), HasSubstr("0.5 px")))
        << c.name;
    ++num_checked;
  }
  EXPECT_EQ(num_checked, 5);
  // Files of different cameras are no pair.
  const std::string alone = scratch_.write("alone.yaml", smallCamera());
  EXPECT_THAT(runAlidade({"validate", alone, scratch_.path("pair/left.yaml"), "--verbose"}).out,
              testing::Not(HasSubstr("the rectified images share")));
}

TEST_F(RosPair, IsValidatedAsARig) {
  writeCornersOfPair(scratch_);
  RigRecord rig = pairOfCameras();
  rig.covariance.clear();
  convert(rig);
  const auto validate = [&](const std::string& first, const std::string& second) {
    return runAlidade({"rig", "validate", scratch_.path("pair/" + first), scratch_.path("pair/" + second),
                       scratch_.path("left.csv"), scratch_.path("right.csv")});
  };
  const RunResult good = validate("left.yaml", "right.yaml");
  EXPECT_THAT(good, EndsWith(0));
  EXPECT_THAT(good.out, HasSubstr("the images confirm the rig"));
  rig.cameras[1].camera_from_rig.rotation =
      SO3::exp(Vector3d(0.01, 0, 0)) * rig.cameras[1].camera_from_rig.rotation;
  convert(rig);
  EXPECT_THAT(validate("left.yaml", "right.yaml"), EndsWith(3));
}

// A point's pixels in the images, undistorted, turned by R and projected by the left part of P, are those
// that P gives of the point itself; they differ along the baseline alone, by f B / z.
TEST_F(RosPair, PutsPointsIntoOneRow) {
  Random random(4);
  int num_points = 0;
  for (const PairCase& c : pairCases()) {
    const RigRecord rig = rigFor(c);
    const std::array<RosView, 2> views = convert(rig);
    const std::size_t first = c.is_second_first ? 1 : 0;
    const RosView& origin = views[first];
    EXPECT_TRUE(origin.P.col(3).isZero(0)) << c.name;
    const double f = origin.P(0, 0);
    const double baseline = c.place.norm();
    EXPECT_NEAR(views[1 - first].P(c.along, 3), -f * baseline, 1e-9) << c.name;
    EXPECT_TRUE(views[0].P.leftCols<3>() == views[1].P.leftCols<3>()) << c.name;
    const AnyRig mounted = rigOf(rig);
    for (int i = 0; i < 40; ++i) {
      const Vector3d point(random.uniform() - 0.5, random.uniform() - 0.5, 1.5 + random.uniform());
      const Vector3d in_first = mounted.camera(first).camera_from_rig * point;
      const Vector3d rectified = origin.R * in_first;
      std::array<Vector2d, 2> pixels;
      for (std::size_t k = 0; k < 2; ++k) {
        const Projection seen = mounted.project(k, point);
        ASSERT_TRUE(seen.ok()) << c.name;
        const auto ray = mounted.camera(k).camera.unproject(seen.pixel);
        ASSERT_TRUE(ray) << c.name;
        pixels[k] = (views[k].P.leftCols<3>() * (views[k].R * *ray)).hnormalized();
        const Vector2d stated = (views[k].P * rectified.homogeneous()).hnormalized();
        EXPECT_LT((pixels[k] - stated).norm(), 1e-6) << c.name;
      }
      const Vector2d apart = pixels[first] - pixels[1 - first];
      EXPECT_NEAR(apart[1 - c.along], 0, 1e-6) << c.name;
      EXPECT_NEAR(apart[c.along], f * baseline / rectified.z(), 1e-6) << c.name;
      ++num_points;
    }
  }
  EXPECT_EQ(num_points, 5 * 40);
}

// OpenCV shares the turn about the baseline in another way; all else is the same.
TEST_F(RosPair, FollowsStereoRectify) {
  const cv::Matx33d K(520, 0, 320, 0, 520, 240, 0, 0, 1);
  int num_checked = 0;
  for (const PairCase& c : pairCases()) {
    if (c.is_second_first) continue;  // OpenCV's first one is that which is given first
    RigRecord rig = rigFor(c);
    for (RigCameraRecord& camera : rig.cameras) {
      const std::string name = camera.camera.name.name;
      const std::vector<double> parameters = {520, 520, 320, 240};
      camera.camera = bareRecord(AnyCamera::make("pinhole", parameters), {640, 480}, "a test");
      camera.camera.name.name = name;
    }
    const std::array<RosView, 2> views = convert(rig);
    const SE3& pose = rig.cameras[1].camera_from_rig;
    cv::Mat R;
    cv::Mat T;
    cv::eigen2cv(pose.rotation.matrix(), R);
    cv::eigen2cv(pose.translation, T);
    std::array<cv::Matx33d, 2> rotations;
    std::array<cv::Matx34d, 2> projections;
    cv::Mat Q;
    cv::stereoRectify(K, cv::noArray(), K, cv::noArray(), {640, 480}, R, T, rotations[0], rotations[1],
                      projections[0], projections[1], Q);
    EXPECT_LT((views[1].R * pose.rotation.matrix() - views[0].R).norm(), kSameNumber) << c.name;
    for (std::size_t i = 0; i < 2; ++i) {
      Eigen::Matrix3d theirs;
      cv::cv2eigen(rotations[i], theirs);
      EXPECT_LT((views[i].R.row(c.along) - theirs.row(c.along)).norm(), kSameNumber) << c.name;
      EXPECT_LT((views[i].R - theirs).norm(), 2e-3) << c.name;
    }
    const auto along = static_cast<int>(c.along);
    EXPECT_NEAR(views[1].P(c.along, 3) / views[1].P(0, 0), projections[1](along, 3) / projections[1](0, 0),
                kSameNumber)
        << c.name;
    ++num_checked;
  }
  EXPECT_EQ(num_checked, 3);
}

constexpr const char* kStereoModel = R"(
import sys
import yaml
from types import SimpleNamespace as Record
from image_geometry import StereoCameraModel

def info(path):
    f = yaml.safe_load(open(path))
    roi = Record(x_offset=0, y_offset=0, width=0, height=0)
    return Record(K=f['camera_matrix']['data'], D=f['distortion_coefficients']['data'],
                  R=f['rectification_matrix']['data'], P=f['projection_matrix']['data'], width=f['image_width'],
                  height=f['image_height'], binning_x=0, binning_y=0, roi=roi, header=Record(frame_id='', stamp=0))

model = StereoCameraModel()
model.fromCameraInfo(info(sys.argv[1]), info(sys.argv[2]))
left, right = model.project3dToPixel((0.2, -0.1, 1.5))
print(*left, *right, *model.projectPixelTo3d(left, left[0] - right[0]))
)";

TEST_F(RosPair, IsWhatImageGeometryExpects) {
  ALIDADE_NEED_PEER("/usr/lib/python3/dist-packages/image_geometry/__init__.py", "python3-image-geometry");
  const std::array<RosView, 2> views = convert(rigFor(pairCases()[0]));
  const RunResult run = runProgram("/usr/bin/python3", {"-c", kStereoModel, scratch_.path("pair/left.yaml"),
                                                        scratch_.path("pair/right.yaml")});
  ASSERT_EQ(run.exit_code, 0) << run.err;
  std::istringstream numbers(run.out);
  const Vector3d point(0.2, -0.1, 1.5);
  for (const RosView& view : views) {
    const Vector2d pixel = (view.P * point.homogeneous()).hnormalized();
    for (const double expected : pixel) {
      double theirs = 0;
      numbers >> theirs;
      EXPECT_NEAR(theirs, expected, 1e-9);
    }
  }
  for (const double expected : point) {
    double theirs = 0;
    numbers >> theirs;
    EXPECT_NEAR(theirs, expected, 1e-9);
  }
  EXPECT_FALSE(numbers.fail());
}

TEST_F(RosPair, GoesIntoAFolder) {
  const std::string rig = scratch_.write("rig.yaml", rigFileText(rigFor(pairCases()[0])));
  const std::string file = scratch_.write("file", "");
  RigRecord sizes = rigFor(pairCases()[0]);
  sizes.cameras[1].camera = bareRecord(sizes.cameras[1].camera.camera, {600, 480}, "a test");
  sizes.cameras[1].camera.name.name = "right";
  RigRecord three = rigFor(pairCases()[0]);
  three.cameras.push_back(three.cameras[1]);
  three.cameras[2].camera.name.name = "third";
  three.cameras[2].camera_from_rig.translation.x() -= 0.1;
  RigRecord alike = rigFor(pairCases()[0]);
  alike.cameras[0].camera.name.name = "a/b";
  alike.cameras[1].camera.name.name = "a_b";
  struct Case {
    std::string input;
    std::string output;
    std::string message;
  };
  const std::vector<Case> cases = {
      {rig, "-", "standard output; expected the name of a folder"},
      {rig, scratch_.path("pair.yaml"), "the name of a file; expected the name of a folder"},
      {rig, file, "Not a directory"},
      {scratch_.write("sizes.yaml", rigFileText(sizes)), scratch_.path("new"),
       "found an image of 600x480 pixels; expected 640x480 as of the first camera"},
      {scratch_.write("three.yaml", rigFileText(three)), scratch_.path("new"),
       "3 cameras; expected one camera, or two with poses"},
      {scratch_.write("alike.yaml", rigFileText(alike)), scratch_.path("new"), "become the same file"}};
  int num_refused = 0;
  for (const Case& c : cases) {
    const RunResult run = runAlidade({"convert", c.input, "--to", "ros", "-o", c.output});
    EXPECT_NE(run.exit_code, 0);
    EXPECT_THAT(run.err, HasSubstr(c.message));
    ++num_refused;
  }
  EXPECT_EQ(num_refused, 6);
  EXPECT_FALSE(std::filesystem::exists(scratch_.path("new")));
  const RunResult run = runAlidade(
      {"convert", rig, "--to", "ros", "-o", scratch_.path("new"), "--resize", "320x240", "--json"});
  EXPECT_THAT(run, EndsWith(0));
  EXPECT_EQ(nlohmann::json::parse(run.out).at("files"),
            nlohmann::json({scratch_.path("new/left.yaml"), scratch_.path("new/right.yaml")}));
  EXPECT_THAT(scratch_.read("new/right.yaml"), HasSubstr("image_width: 320"));
  // An input is never overwritten.
  const std::string left = scratch_.path("new/left.yaml");
  const std::string right = scratch_.path("new/right.yaml");
  EXPECT_THAT(runAlidade({"convert", left, right, "--to", "ros", "-o", scratch_.path("new")}).err,
              HasSubstr("this is also an input"));
}

}  // namespace
}  // namespace alidade
