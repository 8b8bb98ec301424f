// SPDX-License-Identifier: MIT
// Files that OpenCV's own FileStorage writes are read, and it reads ours and projects alike.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <opencv2/calib3d.hpp>
#include <opencv2/core.hpp>

#include "alidade/camera/camera_variant.h"
#include "alidade/files/camera_source.h"
#include "alidade/files/formats/camera_document.h"
#include "alidade/files/formats/camera_format.h"
#include "alidade/files/hand_eye_file.h"
#include "files/formats/reading.h"
#include "support/grid_difference.h"
#include "support/model_fixture.h"
#include "support/textbook_lens.h"

namespace alidade {
namespace {

constexpr double kOpencvTolerance = 1e-9;  // px

cv::Mat matrixOf(std::span<const double> p) {
  return cv::Mat(cv::Matx33d(p[0], 0, p[2], 0, p[1], p[3], 0, 0, 1));
}

cv::Mat column(std::span<const double> values) {
  return cv::Mat(std::vector<double>(values.begin(), values.end()), true);
}

std::string written(int format, const AnyCamera& camera, int fisheye) {
  cv::FileStorage file(format == cv::FileStorage::FORMAT_XML ? "a.xml" : "a",
                       cv::FileStorage::WRITE | cv::FileStorage::MEMORY | format);
  const std::span<const double> p = camera.parameters();
  file << "image_width" << kTestImage.width << "image_height" << kTestImage.height;
  if (fisheye >= 0) file << "fisheye_model" << fisheye;
  file << "camera_matrix" << matrixOf(p);
  if (camera.modelId() == "omni") {
    file << "xi" << column(p.subspan(4, 1)) << "distortion_coefficients" << column(p.subspan(5));
  } else {
    file << "distortion_coefficients" << column(p.subspan(4));
  }
  return file.releaseAndGetString();
}

template <class M>
std::vector<AnyCamera> camerasOf() {
  std::vector<AnyCamera> cameras;
  Random random(11);
  for (const auto& params : ModelFixture<M>::paramSets()) cameras.emplace_back(Camera<M>(params));
  for (int i = 0; i < 5; ++i) cameras.emplace_back(Camera<M>(ModelFixture<M>::randomParams(random)));
  return cameras;
}

template <class M>
int readTheirs() {
  int num_files = 0;
  for (const AnyCamera& camera : camerasOf<M>()) {
    for (const int format :
         {cv::FileStorage::FORMAT_YAML, cv::FileStorage::FORMAT_XML, cv::FileStorage::FORMAT_JSON}) {
      const bool has_four = camera.parameters().size() == 8;
      const std::string text = written(format, camera, has_four ? 1 : -1);
      const CameraSource source = parseCameras(text, "file");
      EXPECT_EQ(source.format, "opencv");
      const AnyCamera& read = source.cameras.at(0).camera;
      EXPECT_EQ(read.modelId(), camera.modelId());
      EXPECT_THAT(std::vector<double>(read.parameters().begin(), read.parameters().end()),
                  testing::ElementsAreArray(camera.parameters().begin(), camera.parameters().end()))
          << text;
      EXPECT_EQ(source.cameras[0].image_size, std::optional(kTestImage));
      ++num_files;
    }
  }
  return num_files;
}

TEST(OpenCvFiles, AreReadExactly) {
  const int num_files = readTheirs<Radtan>() + readTheirs<Rational>() + readTheirs<ThinPrism>() +
                        readTheirs<KannalaBrandt>() + readTheirs<Omni>();
  EXPECT_GE(num_files, 5 * 3 * 8);
}

// K, D and xi as OpenCV finds them in our file.
struct ReadByOpenCv {
  cv::Mat K;
  cv::Mat D;
  double xi = 0;
};

ReadByOpenCv readByOpenCv(const AnyCamera& camera, const std::string& path) {
  const std::string text =
      formatText(cameraFormat("opencv"),
                 std::vector<NamedCamera>{{.name = "", .camera = camera, .image_size = kTestImage}}, path);
  cv::FileStorage file(text, cv::FileStorage::READ | cv::FileStorage::MEMORY);
  ReadByOpenCv read;
  file["camera_matrix"] >> read.K;
  file["distortion_coefficients"] >> read.D;
  EXPECT_EQ(static_cast<int>(file["image_width"]), kTestImage.width);
  EXPECT_EQ(static_cast<int>(file["image_height"]), kTestImage.height);
  if (!file["xi"].empty()) read.xi = static_cast<double>(file["xi"]);
  return read;
}

// Worst difference of OpenCV's projection of rays that the camera sees in its image.
template <class M, class Project>
int compare(const Project& project) {
  int num_points = 0;
  int num_cameras = 0;
  for (const AnyCamera& camera : camerasOf<M>()) {
    constexpr std::array kPaths = {"camera.yaml", "camera.xml", "camera.json"};
    const ReadByOpenCv read =
        readByOpenCv(camera, kPaths[static_cast<std::size_t>(num_cameras++) % kPaths.size()]);
    for (int row = 0; row < 30; ++row) {
      for (int col = 0; col < 40; ++col) {
        const auto ray =
            camera.unproject({col * (kTestImage.width - 1) / 39.0, row * (kTestImage.height - 1) / 29.0});
        // Beyond it OpenCV computes from X / Z what no longer has digits, or mirrors the point.
        if (!ray || ray->z() < 0.05) continue;
        const Projection ours = camera.project(*ray);
        if (!ours.ok()) continue;
        const Eigen::Vector2d theirs = project(read, *ray);
        EXPECT_LT((theirs - ours.pixel).norm(), kOpencvTolerance) << camera.modelId();
        ++num_points;
      }
    }
  }
  return num_points;
}

Eigen::Vector2d projectPoints(const ReadByOpenCv& read, const Eigen::Vector3d& ray) {
  std::vector<cv::Point2d> pixels;
  cv::projectPoints(std::vector<cv::Point3d>{{ray.x(), ray.y(), ray.z()}}, cv::Vec3d(0, 0, 0),
                    cv::Vec3d(0, 0, 0), read.K, read.D, pixels);
  return {pixels[0].x, pixels[0].y};
}

Eigen::Vector2d projectFisheye(const ReadByOpenCv& read, const Eigen::Vector3d& ray) {
  std::vector<cv::Point2d> pixels;
  cv::fisheye::projectPoints(std::vector<cv::Point3d>{{ray.x(), ray.y(), ray.z()}}, pixels,
                             cv::Vec3d(0, 0, 0), cv::Vec3d(0, 0, 0), read.K, read.D);
  return {pixels[0].x, pixels[0].y};
}

// The formula of cv::omnidir, which is in a module that is not everywhere.
Eigen::Vector2d projectOmni(const ReadByOpenCv& read, const Eigen::Vector3d& ray) {
  const std::array<double, 5> k = {read.xi, read.D.at<double>(0), read.D.at<double>(1), read.D.at<double>(2),
                                   read.D.at<double>(3)};
  const RealVector2 m = TextbookLens<Omni>::project(k.data(), ray.cast<Real>()).value();
  return {static_cast<double>(read.K.at<double>(0, 0) * m.x() + read.K.at<double>(0, 2)),
          static_cast<double>(read.K.at<double>(1, 1) * m.y() + read.K.at<double>(1, 2))};
}

TEST(OpenCvFiles, OfOursAreReadByOpenCvAndProjectAlike) {
  int num_points = 0;
  num_points += compare<Pinhole>(projectPoints);
  num_points += compare<Radtan>(projectPoints);
  num_points += compare<Rational>(projectPoints);
  num_points += compare<ThinPrism>(projectPoints);
  num_points += compare<KannalaBrandt>(projectFisheye);
  num_points += compare<Omni>(projectOmni);
  EXPECT_GT(num_points, 20000);
}

// The other formats that are OpenCV's files inside: numbers are numbers, texts are texts.
TEST(OpenCvFiles, OfCamodocalAndOrbSlamAreReadByOpenCv) {
  const std::vector<NamedCamera> cameras = {
      {.name = "left",
       .camera = AnyCamera::make("kannala_brandt",
                                 std::array{300.0, 301.5, 320.25, 240.0, -0.01, 1e-5, -0.03, 4.0}),
       .image_size = {.width = 640, .height = 480}}};
  cv::FileStorage camodocal(formatText(cameraFormat("camodocal"), cameras),
                            cv::FileStorage::READ | cv::FileStorage::MEMORY);
  EXPECT_EQ(static_cast<std::string>(camodocal["model_type"]), "KANNALA_BRANDT");
  EXPECT_EQ(static_cast<std::string>(camodocal["camera_name"]), "left");
  EXPECT_EQ(static_cast<int>(camodocal["image_width"]), 640);
  const cv::FileNode parameters = camodocal["projection_parameters"];
  EXPECT_EQ(static_cast<double>(parameters["k2"]), -0.01);
  EXPECT_EQ(static_cast<double>(parameters["k3"]), 1e-5);
  EXPECT_EQ(static_cast<double>(parameters["mv"]), 301.5);
  EXPECT_EQ(static_cast<double>(parameters["u0"]), 320.25);

  cv::FileStorage orbslam(formatText(cameraFormat("orbslam"), cameras),
                          cv::FileStorage::READ | cv::FileStorage::MEMORY);
  EXPECT_EQ(static_cast<std::string>(orbslam["File.version"]), "1.0");
  EXPECT_EQ(static_cast<std::string>(orbslam["Camera.type"]), "KannalaBrandt8");
  EXPECT_TRUE(orbslam["Camera.width"].isInt());
  for (const char* key : {"Camera1.fx", "Camera1.k2", "Camera1.k4"})
    EXPECT_TRUE(orbslam[key].isReal()) << key;
  EXPECT_EQ(static_cast<double>(orbslam["Camera1.k2"]), 1e-5);
  EXPECT_EQ(static_cast<double>(orbslam["Camera1.cx"]), 320.25);
}

// OpenCV takes a value right behind the colon of its key, as in ORB-SLAM2's own files.
TEST(OpenCvFiles, MayHaveNoBlankBehindAColon) {
  const std::string text = R"(%YAML:1.0
---
# comment:[ "not a quotation mark
plain: don't
camera_matrix:!!opencv-matrix
   rows:3
   cols:3
   dt:d
   data:[ 500., 0., 320.,
      0., 501., 240., 0., 0., 1. ]
distortion_coefficients: { rows: 1,
   cols:5, dt: d,
   data:[-0.1,.02, 0.,0., 0.] }
nested:{ a: 5 }
word:"b:[6] # no comment, \" too"   # it's one: "
other:w
image_width:640
image_height:+480
aspectRatio:-1.5
)";
  const cv::FileStorage theirs(text, cv::FileStorage::READ | cv::FileStorage::MEMORY);
  cv::Mat K;
  cv::Mat D;
  theirs["camera_matrix"] >> K;
  theirs["distortion_coefficients"] >> D;
  ASSERT_EQ(K.total(), 9u);
  ASSERT_EQ(D.total(), 5u);

  const CameraSource source = parseCameras(text, "file");
  const AnyCamera& camera = source.cameras.at(0).camera;
  EXPECT_EQ(camera.parameters()[0], K.at<double>(0, 0));
  EXPECT_EQ(camera.parameters()[3], K.at<double>(1, 2));
  EXPECT_EQ(camera.parameters()[4], D.at<double>(0));
  EXPECT_EQ(camera.parameters()[5], D.at<double>(1));
  EXPECT_EQ(source.cameras.at(0).image_size, std::optional(ImageSize{.width = 640, .height = 480}));
  const detail::CameraDocument document(text, "file");
  const detail::YamlNode& root = document.root();
  EXPECT_EQ(static_cast<std::string>(theirs["word"]), "b:[6] # no comment, \" too");
  EXPECT_EQ(root.at("word").text(), "b:[6] # no comment, \" too");
  EXPECT_EQ(static_cast<std::string>(theirs["other"]), root.at("other").text());
  EXPECT_EQ(root.at("plain").text(), "don't");
  EXPECT_EQ(root.at("nested").at("a").integer(), static_cast<int>(theirs["nested"]["a"]));
  EXPECT_EQ(root.at("aspectRatio").number(), -1.5);
  EXPECT_EQ(root.lineOfKey("aspectRatio"), 19);
}

// As OpenCV 5 writes a cv::Mat of one dimension.
TEST(OpenCvFiles, MayHaveArraysOfOneDimension) {
  const auto textOf = [](const std::string& sizes) {
    return "%YAML:1.0\n---\nimage_width: 640\nimage_height: 480\n"
           "camera_matrix: !!opencv-matrix\n   rows: 3\n   cols: 3\n   dt: d\n"
           "   data: [ 500., 0., 320., 0., 501., 240., 0., 0., 1. ]\n"
           "distortion_coefficients: !!opencv-nd-matrix\n   sizes: " +
           sizes + "\n   dt: d\n   data: [ -0.25, 0.125, 0.5, 0.0625, 0.03125 ]\n";
  };
  int num_read = 0;
  for (const std::string sizes : {"[ 5 ]", "5", "[ 1, 5 ]", "[ 5, 1, 1 ]"}) {
    const CameraSource source = parseCameras(textOf(sizes), "file.yaml");
    const std::vector<double> expected = {500, 501, 320, 240, -0.25, 0.125, 0.5, 0.0625, 0.03125};
    const std::span<const double> found = source.cameras.at(0).camera.parameters();
    EXPECT_THAT(std::vector<double>(found.begin(), found.end()), testing::ElementsAreArray(expected));
    ++num_read;
  }
  EXPECT_EQ(num_read, 4);
  EXPECT_THAT(complaintAbout(textOf("[ 4 ]")),
              testing::HasSubstr("5 numbers; expected the product of sizes, 4"));
  EXPECT_THAT(complaintAbout(textOf("[ 5, -1 ]")), testing::HasSubstr("the product of sizes, 5 x -1"));
  EXPECT_THAT(complaintAbout(textOf("[ 99999, 99999, 99999 ]")), testing::HasSubstr("99999 x 99999"));
  EXPECT_THAT(complaintAbout(textOf("[ ]")), testing::HasSubstr("no number"));
}

// JSON has no comments, so people write keys "//".
TEST(OpenCvFiles, MayHaveCommentKeysAndAMapOfTheirOwn) {
  const std::string text = R"({
  "//": "a camera", "//": "of 640x480",
  "image_width": 640, "image_height": 480, "speed": 3,
  "intrinsics": {"//": "matrix", "camera_matrix": [[500, 0, 320], [0, 501, 240], [0, 0, 1]],
                 "//": "and the rest", "//2": "twice",
                 "distortion_coefficients": [[0.1, -0.05, 0.01, 0.02, 0.03, 0.4, -0.02, 0.01, 0, 0, 0, 0, 0, 0]]}
})";
  const CameraSource source = parseCameras(text, "file.json");
  const AnyCamera& camera = source.cameras.at(0).camera;
  EXPECT_EQ(camera.modelId(), "thin_prism");
  EXPECT_EQ(source.cameras.at(0).image_size, std::optional(ImageSize{.width = 640, .height = 480}));
  const std::vector<double> expected = {500,  501, 320,   240,  0.1, -0.05, 0.01, 0.02,
                                        0.03, 0.4, -0.02, 0.01, 0,   0,     0,    0};
  EXPECT_THAT(std::vector<double>(camera.parameters().begin(), camera.parameters().end()),
              testing::ElementsAreArray(expected));
  EXPECT_THAT(remarksOn(source.cameras.at(0)), testing::HasSubstr("file.json:3: speed is unknown"));
  EXPECT_THAT(remarksOn(source.cameras.at(0)), testing::Not(testing::HasSubstr("//")));
  // Other keys are still a contradiction.
  EXPECT_THAT(complaintAbout(R"({"camera_matrix": [], "camera_matrix": []})"),
              testing::HasSubstr("'camera_matrix' twice"));
}

TEST(OpenCvFiles, KeepTheTextInQuotationMarks) {
  const std::string text = R"(%YAML:1.0
# it's one "comment
note: "a text:[1] # no comment data:[2] \" key:3"   # it's one: "
'a:[b]': 'it''s a text # " data:[4]'
list: ["x key:5", 'y key:6']
last:7
)";
  const detail::CameraDocument document(text, "file");
  const detail::YamlNode& root = document.root();
  EXPECT_EQ(root.at("note").text(), "a text:[1] # no comment data:[2] \" key:3");
  EXPECT_EQ(root.at("a:[b]").text(), "it's a text # \" data:[4]");
  EXPECT_EQ(root.at("list").items().at(0).text(), "x key:5");
  EXPECT_EQ(root.at("list").items().at(1).text(), "y key:6");
  EXPECT_EQ(root.at("last").integer(), 7);
  EXPECT_EQ(root.lineOfKey("last"), 6);
  // YAML without OpenCV's header is left as it is.
  EXPECT_FALSE(detail::CameraDocument("a:[1]\n", "file").isMap());
}

TEST(OpencvFiles, OfHandEyeTransformsAreReadByOpencv) {
  const HandEyeRecord record{
      .mount_from_camera = SE3::exp((SE3::Tangent() << 1, 2e-5, 3, 0.4, 0.5, 0.6).finished()),
      .world_from_boards = {},
      .boards = {},
      .camera_name = "",
      .findings = {},
      .created_by = ""};
  cv::FileStorage file(handEyeText(record, "opencv"), cv::FileStorage::READ | cv::FileStorage::MEMORY);
  const cv::Mat rotation = file["R_cam2gripper"].mat();
  const cv::Mat translation = file["t_cam2gripper"].mat();
  ASSERT_EQ(rotation.size(), cv::Size(3, 3));
  ASSERT_EQ(translation.size(), cv::Size(1, 3));
  const SE3& pose = record.mount_from_camera;
  for (int i = 0; i < 3; ++i) {
    EXPECT_EQ(translation.at<double>(i), pose.translation[i]);
    for (int j = 0; j < 3; ++j) EXPECT_EQ(rotation.at<double>(i, j), pose.rotation.matrix()(i, j));
  }
}

}  // namespace
}  // namespace alidade
