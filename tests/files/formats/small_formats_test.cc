// SPDX-License-Identifier: MIT
// The formats of the table, each against the formulas of its own program, written anew from the numbers of
// the examples in docs/examples/formats.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <functional>

#include "alidade/files/camera_source.h"
#include "alidade/files/formats/camera_format.h"
#include "alidade/files/text/atomic_file.h"
#include "files/formats/examples.h"
#include "files/formats/reading.h"
#include "support/source_tree.h"

namespace alidade {
namespace {

using Vec2 = Eigen::Vector2d;

std::string pathOf(const std::string& name) {
  return sourcePath("docs/examples/formats/" + name);
}

std::string textOfExample(const std::string& name) {
  return readBinaryFile(pathOf(name), 1U << 20U);
}

const StatedCamera& cameraOf(const CameraSource& source, const std::string& name) {
  for (const StatedCamera& camera : source.cameras)
    if (camera.name == name) return camera;
  throw std::logic_error("no camera " + name);
}

// The rational lens of cv::projectPoints: k1 k2 p1 p2 k3 k4 k5 k6.
Vec2 brown(const Vec2& m, const std::array<double, 8>& k) {
  const double r2 = m.squaredNorm();
  const double a = 1 + r2 * (k[0] + r2 * (k[1] + r2 * k[4]));
  const double b = 1 + r2 * (k[5] + r2 * (k[6] + r2 * k[7]));
  return {m.x() * a / b + 2 * k[2] * m.x() * m.y() + k[3] * (r2 + 2 * m.x() * m.x()),
          m.y() * a / b + k[2] * (r2 + 2 * m.y() * m.y()) + 2 * k[3] * m.x() * m.y()};
}

// cv::fisheye.
Vec2 fisheye(const Vec2& m, const std::array<double, 4>& k) {
  const double theta = std::atan(m.norm());
  const double t2 = theta * theta;
  const double d = theta * (1 + t2 * (k[0] + t2 * (k[1] + t2 * (k[2] + t2 * k[3]))));
  return m.norm() > 0 ? Vec2(m * d / m.norm()) : m;
}

// PTAM's and DSO's ATAN camera.
Vec2 atan(const Vec2& m, double w) {
  return m.norm() > 0 ? Vec2(m * std::atan(2 * m.norm() * std::tan(w / 2)) / (w * m.norm())) : m;
}

// Mei's unified projection.
Vec2 mei(const Vec2& m, double xi, const std::array<double, 8>& k) {
  return brown(m / (1 + xi * std::sqrt(1 + m.squaredNorm())), k);
}

Vec2 pixel(const Vec2& d, double fx, double fy, double cx, double cy) {
  return {fx * d.x() + cx, fy * d.y() + cy};
}

constexpr std::array<double, 8> kBrown = {-0.1, 0.02, 0.001, 0.002, 0.03, 0, 0, 0};
constexpr std::array<double, 8> kRational = {0.1, 0.2, 0.001, 0.002, 0.03, 0.4, 0.05, 0.006};
constexpr std::array<double, 4> kFisheye = {-0.01, 0.02, -0.03, 0.004};

struct PixelCase {
  std::string file;
  std::string camera;
  std::function<Vec2(const Vec2&)> project;  // of (x / z, y / z)
};

std::vector<PixelCase> pixelCases() {
  const auto plain = [](const Vec2& m) { return pixel(brown(m, kBrown), 500, 501, 320, 240); };
  const auto round = [](const Vec2& m) { return pixel(fisheye(m, kFisheye), 300, 301, 320, 240); };
  return {
      {"photonvision.json", "", [](const Vec2& m) { return pixel(brown(m, kRational), 500, 501, 320, 240); }},
      {"autoware.yaml", "", plain},
      {"mc_calib.yaml", "camera_0", plain},
      {"mc_calib.yaml", "camera_1", round},
      {"multical.json", "left", plain},
      {"multical.json", "right",
       [](const Vec2& m) { return pixel(brown(m, kRational), 510, 511, 321, 241); }},
      {"easymocap.yaml", "01", plain},
      // OpenSfM: u = d max(w, h), and the pixel is u + (w - 1) / 2.
      {"opensfm.json", "v2 a phone",
       [](const Vec2& m) {
         const Vec2 d = brown(m, kBrown);
         return Vec2((0.8 * d.x() + 0.01) * 640 + 319.5, (0.81 * d.y() - 0.02) * 640 + 239.5);
       }},
      {"opensfm.json", "v2 another",
       [](const Vec2& m) {
         const double r2 = m.squaredNorm();
         return Vec2(0.8 * m * (1 + r2 * (-0.1 + 0.02 * r2)) * 640 + Vec2(319.5, 239.5));
       }},
      {"opensfm.json", "v2 an action camera",
       [](const Vec2& m) {
         return Vec2(0.5 * fisheye(m, {-0.01, 0.02, 0, 0}) * 640 + Vec2(239.5, 319.5));
       }},
      {"opensfm.json", "v2 a fisheye",
       [](const Vec2& m) {
         const Vec2 d = fisheye(m, kFisheye);
         return Vec2((0.5 * d.x() + 0.01) * 640 + 319.5, (0.51 * d.y() - 0.02) * 640 + 239.5);
       }},
      // BoofCV's first pixel has its centre at 0.5.
      {"boofcv.yaml", "",
       [](const Vec2& m) {
         return Vec2(pixel(brown(m, {-0.1, 0.02, 0.001, 0.002, 0, 0, 0, 0}), 500, 501, 320, 240) -
                     Vec2(0.5, 0.5));
       }},
      {"gyroflow.json", "A camera_a lens_1080p",
       [](const Vec2& m) { return pixel(fisheye(m, kFisheye), 300, 301, 320.5, 241); }},
      {"caliscope.toml", "0", plain},
      {"caliscope.toml", "1", round},
      {"zed.conf", "RIGHT_CAM_2K",
       [](const Vec2& m) {
         return pixel(brown(m, {-0.171, 0.0255, 0.00034, 4.9e-5, 0, 0, 0, 0}), 1402.5, 1402.25, 1157.5,
                      590.75);
       }},
      {"vikit.yaml", "",
       [](const Vec2& m) {
         const Vec2 d = atan(m, 0.93);
         return Vec2(640 * (0.5 * d.x() + 0.49) - 0.5, 480 * (0.7 * d.y() + 0.51) - 0.5);
       }},
      {"aslam.yaml", "cam0",
       [](const Vec2& m) {
         return pixel(brown(m, {-0.1, 0.02, 0.001, 0.002, 0, 0, 0, 0}), 500, 501, 320, 240);
       }},
      {"aslam.yaml", "cam1",
       [](const Vec2& m) {
         return pixel(mei(m, 1.3, {-0.1, 0.05, 0.001, -0.002, 0, 0, 0, 0}), 900, 901, 320, 240);
       }},
      {"kitti.txt", "01",
       [](const Vec2& m) {
         return pixel(brown(m, {-0.3644661, 0.1790019, 1.148107e-3, -6.298563e-4, -0.05314062, 0, 0, 0}),
                      989.5267, 987.8386, 702, 245.559);
       }},
      {"kitti_odometry.txt", "1",
       [](const Vec2& m) { return pixel(m, 718.856, 718.856, 607.1928, 185.2157); }},
      {"azure_kinect.json", "PV0",
       [](const Vec2& m) {
         const Vec2 d = brown(m, {0.4, -2.6, 0.0009, -0.00004, 1.5, 0.28, -2.4, 1.43});
         return Vec2(4096 * (0.48 * d.x() + 0.51) - 0.5, 3072 * (0.64 * d.y() + 0.52) - 0.5);
       }},
      {"messages of two cameras", "left", plain},
      {"messages of two cameras", "right", round},
      {"realsense.json", "color", plain},
      {"realsense.json", "depth", [](const Vec2& m) { return pixel(m, 380, 380, 321, 241); }},
      {"dso.txt", "",
       [](const Vec2& m) {
         const Vec2 d = atan(m, 0.897966326944875);
         return Vec2(1280 * (0.535719308086809 * d.x() + 0.493248545285398) - 0.5,
                     1024 * (0.669566858850269 * d.y() + 0.500408664348414) - 0.5);
       }},
      {"bouguet.mat", "", plain},
      // Metashape's manual, with P1 and P2 as it has them.
      {"metashape.xml", "",
       [](const Vec2& m) {
         const double x = m.x(), y = m.y(), r2 = m.squaredNorm();
         const double a = 1 + r2 * (-0.1 + r2 * (0.02 + r2 * (0.03 + r2 * -0.004)));
         const double P1 = 0.001, P2 = 0.002;
         const double dx = x * a + P1 * (r2 + 2 * x * x) + 2 * P2 * x * y;
         const double dy = y * a + P2 * (r2 + 2 * y * y) + 2 * P1 * x * y;
         return Vec2(320 + 1.5 + dx * 500 + dx * 1.25 + dy * -0.5 - 0.5, 240 - 2.25 + dy * 500 - 0.5);
       }},
      {"woodscape.json", "FV",
       [](const Vec2& m) {
         const double theta = std::atan(m.norm());
         const double rho = theta * (340 + theta * (-32 + theta * (48 + theta * -7.2)));
         const Vec2 d = m.norm() > 0 ? Vec2(m * rho / m.norm()) : m;
         return Vec2(d.x() + 0.5 * 1280 + 3.5 - 0.5, 1.01 * d.y() + 0.5 * 966 - 2.25 - 0.5);
       }},
      {"driveworks.json", "camera:rear",
       [](const Vec2& m) {
         const double theta = std::atan(m.norm());
         const double r = theta * (950 + theta * (-3 + theta * (-12 + theta * 2)));
         return Vec2((m.norm() > 0 ? Vec2(m * r / m.norm()) : m) + Vec2(959.5, 603.5));
       }},
      {"driveworks.json", "camera:front:wide",
       [](const Vec2& m) {
         const double theta = std::atan(m.norm());
         double r = 1000 * theta;
         for (int i = 0; i < 100; ++i) r = theta / (1e-3 + r * (-2e-9 + r * (3e-11 + r * 4e-15)));
         return Vec2((m.norm() > 0 ? Vec2(m * r / m.norm()) : m) + Vec2(963.5, 602.25));
       }},
      {"aria.jsonl", "camera-slam-left",
       [](const Vec2& m) {
         const double theta = std::atan(m.norm()), t2 = theta * theta;
         const double a =
             1 + t2 * (-0.02 + t2 * (0.1 + t2 * (-0.07 + t2 * (0.012 + t2 * (0.002 + t2 * -0.0006)))));
         const Vec2 p = m.norm() > 0 ? Vec2(m * theta * a / m.norm()) : m;
         const double r2 = p.squaredNorm(), p0 = 0.0007, p1 = 0.0003;
         const Vec2 tangential((2 * p.x() * p.x() + r2) * p0 + 2 * p.x() * p.y() * p1,
                               (2 * p.y() * p.y() + r2) * p1 + 2 * p.x() * p.y() * p0);
         const Vec2 prism(0.0002 * r2 - 0.0001 * r2 * r2, -0.0003 * r2 + 0.0004 * r2 * r2);
         return Vec2(240 * (p + tangential + prism) + Vec2(318.5, 239.25));
       }},
      {"oak.json", "CAM_A", [](const Vec2& m) { return pixel(brown(m, kRational), 500, 501, 320, 240); }},
      {"oak.json", "CAM_B", round},
      {"flat.json", "", plain},
      {"flat_keys.yaml", "",
       [](const Vec2& m) {
         return pixel(brown(m, {-0.1, 0.02, 0.001, 0.002, 0, 0, 0, 0}), 500, 501, 320, 240);
       }},
  };
}

TEST(SmallFormats, ProjectAsTheirProgramsDo) {
  int num_points = 0;
  for (const PixelCase& c : pixelCases()) {
    const auto example = std::ranges::find(formatExamples(), c.file, &FormatExample::name);
    const CameraSource source =
        example == formatExamples().end() ? loadCameras(pathOf(c.file)) : parseCameras(example->text, "file");
    const AnyCamera& camera = cameraOf(source, c.camera).camera;
    for (int i = -3; i <= 3; ++i) {
      for (int j = -3; j <= 3; ++j) {
        const Vec2 m(0.12 * i, 0.1 * j);
        const Projection p = camera.projectPoint({2 * m.x(), 2 * m.y(), 2});
        ASSERT_TRUE(p.ok()) << c.file;
        EXPECT_LT((p.pixel - c.project(m)).norm(), 1e-9) << c.file << " " << c.camera;
        ++num_points;
      }
    }
  }
  EXPECT_EQ(num_points, 37 * 49);
}

// A point of the first camera's frame, in the second's: every example has a turn by 90 degrees about y.
TEST(SmallFormats, StandWhereTheirProgramsSay) {
  const Eigen::Vector3d x(0.3, -0.2, 1.5);
  const auto forward = [&x](double tx, double ty, double tz) {
    return Eigen::Vector3d(x.z() + tx, x.y() + ty, -x.x() + tz);
  };
  const auto backward = [&x](double tx, double ty, double tz) {
    return Eigen::Vector3d(-(x.z() - tz), x.y() - ty, x.x() - tx);
  };
  const double f = 718.856;
  const double depth = 2e-3;
  const std::vector<std::pair<std::string, Eigen::Vector3d>> cases = {
      {"mc_calib.yaml", backward(0.1, 0, 0.05)},
      {"aslam.yaml", backward(0.1, 0, 0.05)},
      {"multical.json", forward(-0.1, 0, 0.02)},
      {"caliscope.toml", forward(-0.1, 0, 0.02)},
      {"kitti.txt", forward(-0.537, 4.822061e-3, -1.252488e-2)},
      {"azure_kinect.json", forward(-0.032, -0.002, 0.004)},
      {"kitti_odometry.txt",
       x + Eigen::Vector3d((-386.1448 - 607.1928 * depth) / f, -185.2157 * depth / f, depth)}};
  int num_poses = 0;
  for (const auto& [file, expected] : cases) {
    const CameraSource source = loadCameras(pathOf(file));
    ASSERT_EQ(source.cameras.size(), 2U) << file;
    ASSERT_TRUE(source.cameras[0].camera_from_rig && source.cameras[1].camera_from_rig) << file;
    const SE3 second_from_first =
        *source.cameras[1].camera_from_rig * source.cameras[0].camera_from_rig->inverse();
    EXPECT_LT((second_from_first * x - expected).norm(), 1e-12) << file;
    ++num_poses;
  }
  EXPECT_EQ(num_poses, 7);
}

struct SmallRefusal {
  std::string file;
  std::string from;
  std::string to;
  std::vector<std::string> message;
};

TEST(SmallFormats, RefuseWhatTheyCannotSay) {
  const std::vector<SmallRefusal> refusals = {
      {"photonvision.json",
       "[0.1, 0.2, 0.001, 0.002, 0.03, 0.4, 0.05, 0.006]",
       "[0.1, 0.2]",
       {"file:3", "2 numbers"}},
      {"photonvision.json", "\"resolution\"", "\"size\"", {"no key 'resolution.width'"}},
      {"autoware.yaml", "plumb_bob", "ocam", {"file:20: DistModel", "'ocam'", "plumb_bob"}},
      {"mc_calib.yaml", "distortion_type: 1", "distortion_type: 2", {"'2'", "0, 1"}},
      {"multical.json", "\"standard\"", "\"fisheye\"", {"'fisheye'", "rational"}},
      {"easymocap.yaml", "dist_02", "distortion_02", {"no key 'dist_02'"}},
      {"opensfm.json", "\"fisheye\"", "\"dual\"", {"file:4", "'dual'", "simple_radial"}},
      {"opensfm.json",
       "\"width\": 640, \"height\": 480, \"focal_x\": 0.8",
       "\"width\": 0, \"height\": 480, \"focal_x\": 0.8",
       {"1 to 1000000"}},
      {"boofcv.yaml", "skew: 0.0", "skew: 0.5", {"0.5 as number 3", "not supported"}},
      {"boofcv.yaml",
       "pinhole_radial_tangential",
       "kannala_brandt",
       {"'kannala_brandt'", "omnidirectional_universal"}},
      {"gyroflow.json",
       "\"identifier\"",
       "\"distortion_model\": \"poly5\", \"identifier\"",
       {"'poly5'", "opencv_fisheye"}},
      {"gyroflow.json",
       "\"identifier\"",
       "\"digital_lens\": \"gopro_superview\", \"identifier\"",
       {"digital lens 'gopro_superview'"}},
      {"caliscope.toml", "[-0.1, 0.02", "[nan, 0.02", {"file:10", "'nan'"}},
      {"caliscope.toml",
       "fisheye = false",
       "fisheye = true",
       {"file:10", "9 numbers of the lens", "k1 k2 k3 k4"}},
      {"zed.conf", "fy=699.25", "fy=wide", {"file:25", "'wide'"}},
      {"vikit.yaml", "ATAN", "Ocam", {"file:1", "'Ocam'", "EquidistantCamera"}},
      {"aslam.yaml", "type: unified-projection", "type: double-sphere", {"double-sphere+radial-tangential"}},
      {"kitti.txt", "S_01: 1.392000e+03 5.120000e+02", "S_01: 1.392000e+03", {"S_01"}},
      {"azure_kinect.json", "BrownConrady\"}", "Rational6KT\"}", {"Rational6KT"}},
      {"azure_kinect.json", "0.88, 0, 0", "0.88, 0, 0.1", {"number 12"}},
      {"realsense.json",
       "inverse_brown_conrady\", \"coeffs\": [0.0",
       "modified_brown_conrady\", \"coeffs\": [0.1",
       {"0.1 as number 5", "modified_brown_conrady"}},
      {"metashape.xml", "<projection>frame", "<projection>spherical", {"'spherical'", "fisheye"}},
      {"metashape.xml", "<projection>frame", "<projection>fisheye", {"as number 11", "not supported"}},
      {"woodscape.json", "\"radial_poly\"", "\"unified\"", {"'unified'", "radial_poly"}},
      {"driveworks.json", "\"0 1.0e-03", "\"0 x 1.0e-03", {"'x'", "finite numbers"}},
      {"oak.json", "\"cameraType\": 1", "\"cameraType\": 2", {"'2'", "0, 1"}},
      {"flat.json",
       "-0.1, 0.02, 0.001, 0.002, 0.03",
       "-0.1, 0.02, 0.001, 0.002",
       {"4 distortion coefficients", "fisheye; they differ by ", " px at the corner", "--read-as"}},
      {"flat.json", "\"width\"", "\"model\": \"division\", \"width\"", {"'division'", "kannala_brandt"}},
  };
  int num_refused = 0;
  for (const SmallRefusal& refusal : refusals) {
    std::string text = textOfExample(refusal.file);
    const std::size_t at = text.find(refusal.from);
    ASSERT_NE(at, std::string::npos) << refusal.file << ": " << refusal.from;
    text.replace(at, refusal.from.size(), refusal.to);
    const std::string complaint = complaintAbout(text);
    for (const std::string& part : refusal.message)
      EXPECT_THAT(complaint, testing::HasSubstr(part)) << refusal.file << ": " << refusal.to;
    ++num_refused;
  }
  EXPECT_EQ(num_refused, 28);
}

// Two readings become one with --read-as, and a missing size is asked for.
TEST(SmallFormats, TakeWhatTheFileLeavesOpenFromTheUser) {
  const std::string four =
      R"({"fx": 500, "fy": 501, "cx": 320, "cy": 240, "dist": [-0.1, 0.02, 0.001, 0.002]})";
  for (const std::string model : {"radtan", "kannala_brandt"}) {
    const CameraSource source =
        parseCameras(four, "file", {.image_size = ImageSize{640, 480}, .model = model});
    EXPECT_EQ(source.cameras.at(0).camera.modelId(), model);
    EXPECT_EQ(source.cameras.at(0).image_size, std::optional(ImageSize{640, 480}));
  }
  // The size chooses among the modes of a ZED.
  const CameraSource zed =
      parseCameras(textOfExample("zed.conf"), "file", {.image_size = ImageSize{1280, 720}, .model = ""});
  ASSERT_EQ(zed.cameras.size(), 1U);
  EXPECT_EQ(zed.cameras[0].name, "LEFT_CAM_HD");
  // Pixels and relative numbers of DSO's files.
  const CameraSource dso =
      parseCameras("RadTan 500 501 320 240 -0.1 0.02 0.001 0.002\n640 480\ncrop\n640 480\n", "file");
  EXPECT_THAT(dso.cameras.at(0).camera.parameters(),
              testing::ElementsAre(500, 501, 320, 240, -0.1, 0.02, 0.001, 0.002, 0));
  // A camera that is not calibrated is told.
  std::string text = textOfExample("caliscope.toml");
  text.erase(text.find("matrix"), text.find("distortions") - text.find("matrix"));
  const CameraSource one = parseCameras(text, "file");
  ASSERT_EQ(one.cameras.size(), 1U);
  EXPECT_THAT(remarksOn(one.cameras[0]), testing::HasSubstr("file:1: cameras.0: not a calibrated camera"));
  // Gyroflow's own centre and stretched images are told.
  std::string profile = textOfExample("gyroflow.json");
  profile.replace(profile.find("\"asymmetrical\": true"), 20, "\"input_horizontal_stretch\": 1.33");
  EXPECT_THAT(
      remarksOn(parseCameras(profile, "file").cameras.at(0)),
      testing::AllOf(testing::HasSubstr("stretched by this factor"), testing::HasSubstr("not asymmetrical")));
  // They are only read.
  EXPECT_THROW((void)formatText(cameraFormat("dso"), std::vector<NamedCamera>{}), Error);
}

}  // namespace
}  // namespace alidade
