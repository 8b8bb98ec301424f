// SPDX-License-Identifier: MIT
// Where cameras are, in files of each format that says it: round trips, what the other programs make of our
// files, and we of theirs.
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <opencv2/calib3d.hpp>
#include <opencv2/core.hpp>
#include <opencv2/core/eigen.hpp>

#include "alidade/core/random.h"
#include "alidade/core/text.h"
#include "alidade/files/camera_source.h"
#include "alidade/files/formats/camera_format.h"
#include "alidade/files/rig_file.h"
#include "apps/run_program.h"
#include "files/formats/reading.h"
#include "support/image_sizes.h"
#include "support/message_of.h"
#include "support/peer.h"
#include "support/scratch_folder.h"

namespace alidade {
namespace {

using testing::AllOf;
using testing::HasSubstr;

constexpr double kTolerance = 1e-9;  // m and rad

// How far apart: the sum of the distance of the origins, m, and the angle, rad.
double distance(const SE3& a, const SE3& b) {
  return (a.translation - b.translation).norm() + (a.rotation.inverse() * b.rotation).log().norm();
}

SE3 randomPose(Random& random) {
  const auto number = [&random] { return 2 * random.uniform() - 1; };
  Eigen::Matrix<double, 6, 1> xi;
  for (double& value : xi) value = number();
  return SE3::exp(xi);
}

std::vector<NamedCamera> randomRig(Random& random, std::size_t num_cameras) {
  std::vector<NamedCamera> cameras;
  for (std::size_t i = 0; i < num_cameras; ++i) {
    const double x = static_cast<double>(i);
    cameras.push_back({.name = "eye" + std::to_string(i),
                       .camera = AnyCamera::make("pinhole", std::array{500.0 + x, 501.0 + x, 320.0, 240.0}),
                       .image_size = kVga,
                       .camera_from_rig = randomPose(random)});
  }
  return cameras;
}

TEST(RigFormats, KeepPoses) {
  Random random(5);
  int num_poses = 0;
  std::vector<std::string_view> ids;
  for (const CameraFormat* format : cameraFormats()) {
    using Poses = CameraFormat::Poses;
    if (format->poses == Poses::kNone) continue;
    ids.push_back(format->id);
    for (int repeat = 0; repeat < 5; ++repeat) {
      // More than ten: names sort otherwise than numbers.
      const std::vector<NamedCamera> cameras =
          randomRig(random, std::min<std::size_t>(format->max_cameras, 12));
      const CameraSource source = parseCameras(formatText(*format, cameras), "file");
      EXPECT_EQ(source.format, format->id);
      ASSERT_EQ(source.cameras.size(), cameras.size());
      const SE3 rig_from_origin =
          format->poses == Poses::kFromRig ? SE3() : cameras.front().camera_from_rig->inverse();
      for (std::size_t i = 0; i < cameras.size(); ++i) {
        EXPECT_EQ(source.cameras[i].camera.parameters()[0], 500.0 + static_cast<double>(i));
        EXPECT_EQ(remarksOn(source.cameras[i]), "");
        const bool is_mono = cameras.size() == 1 && format->poses == Poses::kFromFirst;
        if (is_mono) continue;
        ASSERT_TRUE(source.cameras[i].camera_from_rig) << format->id;
        EXPECT_LT(distance(*source.cameras[i].camera_from_rig, *cameras[i].camera_from_rig * rig_from_origin),
                  kTolerance)
            << format->id;
        ++num_poses;
      }
    }
  }
  EXPECT_THAT(ids, testing::ElementsAre("alidade", "opencv", "kalibr", "colmap_rig", "mrcal", "basalt"));
  EXPECT_EQ(num_poses, 5 * (12 + 2 + 12 + 12 + 1 + 12));
}

// kalibr_common writes the names in order of their letters.
TEST(RigFormats, FollowKalibrsChainByNumber) {
  const auto camera = [](const std::string& name, double x) {
    return name + ":\n  camera_model: pinhole\n  intrinsics: [500.0, 500.0, 320.0, 240.0]\n" +
           "  distortion_model: none\n  distortion_coeffs: []\n  resolution: [640, 480]\n" +
           (x == 0 ? std::string()
                   : "  T_cn_cnm1:\n  - [1.0, 0.0, 0.0, " + exactText(x) +
                         "]\n  - [0.0, 1.0, 0.0, 0.0]\n  - [0.0, 0.0, 1.0, 0.0]\n  - [0.0, 0.0, 0.0, 1.0]\n");
  };
  const CameraSource source =
      parseCameras(camera("cam0", 0) + camera("cam10", 100) + camera("cam2", 3) + camera("cam1", 20), "file");
  std::vector<double> x;
  for (const StatedCamera& read : source.cameras) x.push_back(read.camera_from_rig->translation.x());
  EXPECT_EQ(x, (std::vector<double>{0, 123, 23, 20}));
}

// OpenVINS and EuRoC say where the IMU is from each camera; Kalibr says it too beside its chain.
TEST(RigFormats, TakeTheImuForTheRigWithoutAChain) {
  const std::string lens =
      "camera_model: pinhole\nintrinsics: [500, 500, 320, 240]\ndistortion_model: none\ndistortion_coeffs: "
      "[]\nresolution: [640, 480]\n";
  const std::string turned = "{rows: 4, cols: 4, data: [0, -1, 0, 1, 1, 0, 0, 2, 0, 0, 1, 3, 0, 0, 0, 1]}\n";
  Eigen::Matrix4d T;
  T << 0, -1, 0, 1, 1, 0, 0, 2, 0, 0, 1, 3, 0, 0, 0, 1;
  int num_cases = 0;
  for (const auto& [key, camera_from_imu] : {std::pair<std::string, Eigen::Matrix4d>("T_cam_imu", T),
                                             {"T_imu_cam", T.inverse()},
                                             {"T_BS", T.inverse()}}) {
    const StatedCamera camera = parseCameras(lens + key + ": " + turned, "file").cameras.at(0);
    EXPECT_EQ(remarksOn(camera), "");
    ASSERT_TRUE(camera.camera_from_rig) << key;
    EXPECT_LT((camera.camera_from_rig->matrix() - camera_from_imu).norm(), kTolerance) << key;
    ++num_cases;
  }
  EXPECT_EQ(num_cases, 3);
}

TEST(RigFormats, ReadLensesBesideDamagedPoses) {
  const std::string mrcal =
      "{ 'lensmodel': 'LENSMODEL_PINHOLE', 'intrinsics': [ 500, 501, 320, 240 ], 'imagersize': [ 640, 480 "
      "], ";
  const std::string opencv =
      "image_size: [640, 480]\nM1: [[500, 0, 320], [0, 500, 240], [0, 0, 1]]\nD1: [0, 0, 0, 0, 0]\n"
      "M2: [[500, 0, 320], [0, 500, 240], [0, 0, 1]]\nD2: [0, 0, 0, 0, 0]\n";
  struct Case {
    std::string text;
    std::string remark;
  };
  const std::vector<Case> cases = {
      {mrcal + "'extrinsics': [ 0, 0, 0, 1 ] }", "bad_pose: file:1"},
      {mrcal + "'extrinsics': [ 0, 0, 0, 1, 2, .nan ] }", "bad_pose: file:1"},
      {opencv + "R: [1, 0, 0, 0, 0.9, 0, 0, 0, 1]\nT: [1, 0, 0]\n",
       "bad_pose: file:6: R: rotation matrix: column 1 has length 0.9"},
      {opencv + "R: [1, 0, 0, 0, 1, 0, 0, 0, -1]\nT: [1, 0, 0]\n", "a reflection"},
      {opencv + "R: [1, 0, 0, 0, 1, 0, 0, 0, 1]\nT: [1, 0]\n", "bad_pose: file:7: T"},
      {R"({"value0": {"intrinsics": [{"camera_type": "pinhole", "intrinsics": {"fx": 500, "fy": 500, "cx": 320, "cy": 240}}],
"resolution": [[640, 480]], "T_imu_cam": [{"px": 0, "py": 0, "pz": 1, "qx": 0, "qy": 0, "qz": 0, "qw": 0}]}})",
       "bad_pose: file:2"},
  };
  for (const Case& one : cases) {
    const CameraSource source = parseCameras(one.text, "file");
    EXPECT_FALSE(source.cameras.at(0).camera_from_rig);
    EXPECT_EQ(source.cameras.at(0).camera.parameters()[0], 500.0);
    EXPECT_THAT(remarksOn(source.cameras.at(0)), HasSubstr(one.remark));
  }
  EXPECT_EQ(cases.size(), 6u);
  // Three decimals are a rotation, and a remark.
  const CameraSource rounded =
      parseCameras(opencv + "R: [0.707, -0.707, 0, 0.707, 0.707, 0, 0, 0, 1]\nT: [1, 0, 0]\n", "file");
  EXPECT_THAT(remarksOn(rounded.cameras.at(0)), HasSubstr("assumed: file:6: R"));
  EXPECT_NEAR(rounded.cameras.at(1).camera_from_rig.value().rotation.log().z(), std::acos(-1.0) / 4, 1e-12);
  // A board in millimetres.
  EXPECT_THAT(remarksOn(parseCameras(opencv + "R: [0, 0, 0]\nT: [-60, 0, 0]\n", "file").cameras.at(0)),
              AllOf(HasSubstr("assumed: file:7: T"), HasSubstr("60 m")));
}

TEST(RigFormats, OfColmapHaveOneReference) {
  const auto file = [](const std::string& more, const std::string& first = "\"ref_sensor\": true,") {
    const std::string lens = R"("camera_model_name": "PINHOLE", "camera_params": [500, 500, 320.5, 240.5]})";
    return "[{\"cameras\": [{\"image_prefix\": \"rig1/a/\", " + first + lens +
           ",\n{\"image_prefix\": \"rig1/b/\", " + more + lens + "]}]";
  };
  const std::string pose =
      R"("cam_from_rig_rotation": [0.0, 0.0, 0.0, 2.0], "cam_from_rig_translation": [1, 2, 3], )";
  const CameraSource source = parseCameras(file(pose), "file");
  EXPECT_EQ(source.format, "colmap_rig");
  EXPECT_EQ(source.cameras.at(0).name, "a");
  EXPECT_EQ(source.cameras.at(1).name, "b");
  EXPECT_EQ(source.cameras.at(1).image_size, std::nullopt);
  EXPECT_EQ(source.cameras.at(1).camera.parameters()[2], 320.0);
  const SE3 expected{SO3::fromQuaternion({0, 0, 0, 1}), {1, 2, 3}};
  EXPECT_LT(distance(source.cameras.at(1).camera_from_rig.value(), expected), kTolerance);
  EXPECT_EQ(source.cameras.at(0).camera_from_rig.value().log().norm(), 0);
  // COLMAP may find the poses itself.
  EXPECT_FALSE(parseCameras(file(""), "file").cameras.at(0).camera_from_rig);
  EXPECT_THAT(remarksOn(parseCameras(file(pose + "\"ref_sensor\": true, "), "file").cameras.at(0)),
              HasSubstr("reference sensor"));
  EXPECT_THAT(remarksOn(parseCameras(file(pose, pose), "file").cameras.at(0)),
              HasSubstr("0 cameras with ref_sensor"));
  EXPECT_THAT(complaintAbout(R"([{"cameras": [{"image_prefix": "a/", "ref_sensor": true}]}])"),
              AllOf(HasSubstr("file:1"), HasSubstr("camera_model_name and camera_params")));
}

// cv::FileStorage and cv::stereoRectify() with what we write; the sample stereo_calib's two files, as it
// writes them, for us.
TEST(RigFormats, OfOpenCvGoBothWays) {
  Random random(3);
  const ScratchFolder folder;
  const std::vector<NamedCamera> pair = randomRig(random, 2);
  const SE3 second_from_first = *pair[1].camera_from_rig * pair[0].camera_from_rig->inverse();
  int num_files = 0;
  for (const char* name : {"pair.yml", "pair.xml", "pair.json"}) {
    folder.write(name, formatText(cameraFormat("opencv"), pair, name));
    const cv::FileStorage file(folder.path(name), cv::FileStorage::READ);
    cv::Mat R;
    cv::Mat T;
    cv::Mat M2;
    file["R"] >> R;
    file["T"] >> T;
    file["M2"] >> M2;
    Eigen::Matrix3d rotation;
    Eigen::Vector3d translation;
    cv::cv2eigen(R, rotation);
    cv::cv2eigen(T, translation);
    EXPECT_LT((rotation - second_from_first.rotation.matrix()).norm(), kTolerance);
    EXPECT_LT((translation - second_from_first.translation).norm(), kTolerance);
    EXPECT_EQ(M2.at<double>(0, 0), 501.0);
    ++num_files;
  }
  EXPECT_EQ(num_files, 3);

  const cv::Mat K(cv::Matx33d(500, 0, 320, 0, 501, 240, 0, 0, 1));
  const cv::Mat D(cv::Matx<double, 1, 5>(-0.1, 0.02, 0.001, 0.002, 0.003));
  cv::Mat R;
  cv::Mat T;
  cv::eigen2cv(second_from_first.rotation.matrix(), R);
  cv::eigen2cv(second_from_first.translation, T);
  {
    cv::FileStorage lenses(folder.path("intrinsics.yml"), cv::FileStorage::WRITE);
    lenses << "M1" << K << "D1" << D << "M2" << K << "D2" << D;
    cv::FileStorage poses(folder.path("extrinsics.yml"), cv::FileStorage::WRITE);
    cv::Mat R1;
    cv::Mat R2;
    cv::Mat P1;
    cv::Mat P2;
    cv::Mat Q;
    cv::stereoRectify(K, D, K, D, {640, 480}, R, T, R1, R2, P1, P2, Q);
    poses << "R" << R << "T" << T << "R1" << R1 << "R2" << R2 << "P1" << P1 << "P2" << P2 << "Q" << Q;
  }
  const ReadOptions options{.image_size = kVga, .model = ""};
  const std::vector<std::string> paths = {folder.path("intrinsics.yml"), folder.path("extrinsics.yml")};
  const GatheredCameras gathered = gatherCameras(paths, options);
  ASSERT_EQ(gathered.source.cameras.size(), 2u);
  EXPECT_LT(distance(gathered.source.cameras[1].camera_from_rig.value(), second_from_first), 1e-9);
  EXPECT_EQ(gathered.source.cameras[0].camera_from_rig.value().log().norm(), 0);
  EXPECT_THAT(messageOf([&] {
                (void)gatherCameras(std::array{paths[1], paths[1]}, options);
              }),
              HasSubstr("extrinsics.yml"));
}

// ROS' calibrator writes a pair as rectification and projection.
TEST(RigFormats, OfRosComeFromTheRectification) {
  Random random(4);
  const ScratchFolder folder;
  const cv::Mat K(cv::Matx33d(500, 0, 320, 0, 501, 240, 0, 0, 1));
  const cv::Mat D = cv::Mat::zeros(1, 5, CV_64F);
  int num_pairs = 0;
  for (const Eigen::Vector3d& t : {Eigen::Vector3d(-0.12, 0.01, 0.005), Eigen::Vector3d(0.01, -0.2, 0.01)}) {
    const SE3 right_from_left{SO3::exp(0.05 * randomPose(random).translation), t};
    cv::Mat R;
    cv::Mat T;
    cv::eigen2cv(right_from_left.rotation.matrix(), R);
    cv::eigen2cv(right_from_left.translation, T);
    std::array<cv::Mat, 2> rotations;
    std::array<cv::Mat, 2> projections;
    cv::Mat Q;
    cv::stereoRectify(K, D, K, D, {640, 480}, R, T, rotations[0], rotations[1], projections[0],
                      projections[1], Q);
    std::vector<std::string> paths;
    for (std::size_t i = 0; i < 2; ++i) {
      const auto list = [](const cv::Mat& matrix) {
        std::vector<std::string> numbers;
        for (const double value : cv::Mat_<double>(matrix)) numbers.push_back(exactText(value));
        return "[" + join(numbers, ", ") + "]\n";
      };
      paths.push_back(folder.write(i == 0 ? "left.yaml" : "right.yaml",
                                   "width: 640\nheight: 480\ndistortion_model: plumb_bob\nD: " + list(D) +
                                       "K: " + list(K) + "R: " + list(rotations[i]) +
                                       "P: " + list(projections[i])));
    }
    const std::vector<StatedCamera> cameras = gatherCameras(paths, {}).source.cameras;
    const SE3 read = *cameras.at(1).camera_from_rig * cameras.at(0).camera_from_rig->inverse();
    EXPECT_LT(distance(read, right_from_left), kTolerance);
    EXPECT_EQ(cameras.at(0).name, "left");
    EXPECT_EQ(cameras.at(1).name, "right");
    ++num_pairs;
  }
  EXPECT_EQ(num_pairs, 2);
  // Drivers of cameras that rectify their images write a rotation of zeros.
  const std::string zeros =
      "width: 640\nheight: 480\ndistortion_model: plumb_bob\nD: [0, 0, 0, 0, 0]\n"
      "K: [500, 0, 320, 0, 500, 240, 0, 0, 1]\nR: [0, 0, 0, 0, 0, 0, 0, 0, 0]\n";
  const std::string left =
      folder.write("zero_left.yaml", zeros + "P: [500, 0, 320, 0, 0, 500, 240, 0, 0, 0, 1, 0]\n");
  const std::string right =
      folder.write("zero_right.yaml", zeros + "P: [500, 0, 320, -60, 0, 500, 240, 0, 0, 0, 1, 0]\n");
  EXPECT_THAT(remarksOn(loadCameras(right).cameras.at(0)),
              testing::AllOf(testing::HasSubstr("no_pose: "), testing::HasSubstr(":6: R: only zeros"),
                             testing::HasSubstr("P states a baseline of 0.12 m")));
  EXPECT_THAT(messageOf([&] {
                (void)gatherCameras(std::vector<std::string>{left, right}, {});
              }),
              testing::HasSubstr("already rectified"));
  // Drivers without a calibration write zeros.
  EXPECT_FALSE(
      parseCameras("width: 640\nheight: 480\ndistortion_model: plumb_bob\nD: [0, 0, 0, 0, 0]\nK: [500, 0, "
                   "320, 0, 500, 240, 0, 0, 1]\nR: [0, 0, 0, 0, 0, 0, 0, 0, 0]\nP: [0, 0, 0, 0, 0, 0, 0, "
                   "0, 0, 0, 0, 0]\n",
                   "file")
          .cameras.at(0)
          .camera_from_rig);
}

// For each of our files: where mrcal sees points of the reference frame, and the same model written anew.
constexpr const char* kMrcalScript = R"(
import sys
import numpy as np
import mrcal

folder = sys.argv[1]
points = np.loadtxt(folder + '/points.txt')
for i in range(3):
    model = mrcal.cameramodel(folder + '/our_%d.cameramodel' % i)
    in_camera = mrcal.transform_point_rt(model.extrinsics_rt_fromref(), points)
    np.savetxt(folder + '/pixels_%d.txt' % i, mrcal.project(in_camera, *model.intrinsics()), fmt='%.17g')
    model.write(folder + '/their_%d.cameramodel' % i)
)";

TEST(RigFormats, OfMrcalGoBothWays) {
  ALIDADE_NEED_PEER("/usr/lib/python3/dist-packages/mrcal/__init__.py", "python3-mrcal");
  Random random(8);
  const ScratchFolder folder;
  std::vector<NamedCamera> rig = randomRig(random, 3);
  std::vector<Eigen::Vector3d> points;
  std::string text;
  while (points.size() < 50) {
    const Eigen::Vector3d p = 4 * randomPose(random).translation + Eigen::Vector3d(0, 0, 6);
    const bool is_seen = std::all_of(rig.begin(), rig.end(), [&p](const NamedCamera& camera) {
      return camera.camera.project(*camera.camera_from_rig * p).ok();
    });
    if (!is_seen) continue;
    points.push_back(p);
    text += exactText(p.x()) + " " + exactText(p.y()) + " " + exactText(p.z()) + "\n";
  }
  folder.write("points.txt", text);
  std::vector<std::string> theirs;
  for (std::size_t i = 0; i < rig.size(); ++i) {
    folder.write("our_" + std::to_string(i) + ".cameramodel",
                 formatText(cameraFormat("mrcal"), {&rig[i], 1}));
    theirs.push_back(folder.path("their_" + std::to_string(i) + ".cameramodel"));
  }
  const RunResult run = runProgram("/usr/bin/python3", {"-c", kMrcalScript, folder.path()});
  ASSERT_EQ(run.exit_code, 0) << run.err;
  int num_points = 0;
  for (std::size_t i = 0; i < rig.size(); ++i) {
    std::istringstream pixels(folder.read("pixels_" + std::to_string(i) + ".txt"));
    for (const Eigen::Vector3d& p : points) {
      Eigen::Vector2d theirs_px;
      pixels >> theirs_px.x() >> theirs_px.y();
      EXPECT_LT((rig[i].camera.project(*rig[i].camera_from_rig * p).pixel - theirs_px).norm(), 1e-9);
      ++num_points;
    }
  }
  EXPECT_EQ(num_points, 150);
  const GatheredCameras back = gatherCameras(theirs, {});
  for (std::size_t i = 0; i < rig.size(); ++i) {
    EXPECT_LT(distance(*back.source.cameras[i].camera_from_rig, *rig[i].camera_from_rig), kTolerance);
    EXPECT_EQ(back.source.cameras[i].name, "their_" + std::to_string(i));
  }
}

TEST(RigFormats, OfSeveralFilesAreRefusedWhereTheyAreNoRig) {
  const ScratchFolder folder;
  Random random(2);
  std::vector<NamedCamera> rig = randomRig(random, 2);
  const auto write = [&folder](const std::string& name, const NamedCamera& camera, const char* format) {
    return folder.write(name, formatText(cameraFormat(format), {&camera, 1}));
  };
  const std::string left = write("left.cameramodel", rig[0], "mrcal");
  const std::string right = write("right.cameramodel", rig[1], "mrcal");
  const auto refusal = [](std::vector<std::string> paths) {
    return messageOf([&] { (void)gatherCameras(paths, {}); });
  };
  EXPECT_THAT(refusal({left, left}), AllOf(HasSubstr("same pose"), HasSubstr("rig calibrate")));
  EXPECT_THAT(refusal({left, write("own.yaml", rig[1], "alidade")}),
              AllOf(HasSubstr("own.yaml"), HasSubstr("no pose")));
  const std::string both = folder.write("rig.yaml", formatText(cameraFormat("alidade"), rig));
  EXPECT_THAT(refusal({both, left}), HasSubstr("rig.yaml#eye0"));
  const std::vector<StatedCamera> parts =
      gatherCameras(std::array{both + "#eye1", both + "#eye0"}, {}).source.cameras;
  EXPECT_EQ(parts.at(0).name, "eye1");
  EXPECT_EQ(parts.at(1).name, "eye0");
  EXPECT_THAT(messageOf([&] { (void)loadRig(both + "#eye0"); }), HasSubstr("the whole rig"));
  // Folders tell EuRoC's files apart.
  for (int i = 0; i < 2; ++i) {
    std::filesystem::create_directory(folder.path("cam" + std::to_string(i)));
    write("cam" + std::to_string(i) + "/model.cameramodel", rig[static_cast<std::size_t>(i)], "mrcal");
  }
  const std::vector<StatedCamera> named =
      gatherCameras(std::array{folder.path("cam0/model.cameramodel"), folder.path("cam1/model.cameramodel")},
                    {})
          .source.cameras;
  EXPECT_EQ(named.at(0).name, "cam0");
  EXPECT_EQ(named.at(1).name, "cam1");
}

}  // namespace
}  // namespace alidade
