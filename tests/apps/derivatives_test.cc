// SPDX-License-Identifier: MIT
#include <cmath>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "alidade/camera/any_camera.h"
#include "alidade/files/camera_source.h"
#include "alidade/geometry/se3.h"
#include "apps/project_support.h"

namespace alidade {
namespace {

using testing::HasSubstr;

// The pose (given as text to the program) and a point that it moves into the image.
const SE3 kPose{SO3::exp({0.1, -0.2, 0.3}), {0.05, -0.02, 1.5}};
const char* const kPoseText = "{rotation_vector_rad: [0.1, -0.2, 0.3], translation_m: [0.05, -0.02, 1.5]}";
const Eigen::Vector3d kPoint(0.2, -0.1, 0.3);

std::string textOf(const Eigen::Vector3d& p) {
  return fmt::format("{},{},{}\n", p.x(), p.y(), p.z());
}

// Numerical derivative of f at 0.
template <class F>
auto slope(const F& f) {
  constexpr double kStep = 1e-5;
  return ((f(kStep) - f(-kStep)) / (2 * kStep)).eval();
}

TEST(Jacobian, HasTheDerivativesThatItsHeaderNames) {
  const CameraRecord file = loadCamera(dataPath("camera.yaml"));
  const RunResult result = project(textOf(kPoint), {"--pose", kPoseText, "--jacobian"});
  ASSERT_THAT(result, EndsWith(0));
  const std::string inputs[] = {"x",  "y",  "z",  "tx", "ty", "tz", "rx", "ry", "rz",
                                "fx", "fy", "cx", "cy", "k1", "k2", "p1", "p2", "k3"};
  std::string header = "u,v,status";
  for (const char* output : {",du_d", ",dv_d"}) {
    for (const std::string& input : inputs) header += output + input;
  }
  EXPECT_EQ(headerOf(result.out), header);
  const std::vector<std::string> row = rowsOf(result.out).at(0);
  ASSERT_EQ(row.size(), 3u + 2 * 18);
  std::size_t num_checked = 0;
  for (std::size_t i = 0; i < 18; ++i) {
    const Eigen::Vector2d expected = slope([&](double step) {
      Eigen::Vector3d point = kPoint;
      Eigen::Matrix<double, 6, 1> xi = Eigen::Matrix<double, 6, 1>::Zero();
      std::vector<double> params(file.camera.parameters().begin(), file.camera.parameters().end());
      (i < 3   ? point[static_cast<Eigen::Index>(i)]
       : i < 9 ? xi[static_cast<Eigen::Index>(i) - 3]
               : params[i - 9]) += step;
      return AnyCamera::make("radtan", params).project(kPose * SE3::exp(xi) * point).pixel;
    });
    constexpr double kDifference = 1e-5;  // of a central difference, in pixels a unit, relative to 1 + |J|
    for (const std::size_t k : {0u, 1u}) {
      EXPECT_NEAR(numberIn(row[3 + 18 * k + i]), expected[static_cast<Eigen::Index>(k)],
                  kDifference * (1 + expected.norm()))
          << inputs[i];
      ++num_checked;
    }
  }
  EXPECT_EQ(num_checked, 36u);
}

TEST(Jacobian, LeavesThePixelAsItIs) {
  const std::string points = "0.1,0.2,1\n0.3,-0.1,2\n0,0,-1\n";
  const auto plain = rowsOf(project(points).out);
  const auto rows = rowsOf(project(points, {"--jacobian"}).out);
  ASSERT_EQ(rows.size(), 3u);
  for (std::size_t i = 0; i < rows.size(); ++i)
    EXPECT_EQ(std::vector<std::string>(rows[i].begin(), rows[i].begin() + 3), plain[i]);
  ASSERT_EQ(rows[2].size(), 39u);
  for (std::size_t i = 3; i < rows[2].size(); ++i) EXPECT_EQ(rows[2][i], "nan");
}

TEST(Jacobian, OfARayIsItsDerivativeByThePixel) {
  const CameraRecord file = loadCamera(dataPath("camera.yaml"));
  const RunResult result =
      runAlidade({"unproject", dataPath("camera.yaml"), "--jacobian"}, {.input = "100,350\n1e6,0\n"});
  ASSERT_THAT(result, EndsWith(0));
  EXPECT_EQ(headerOf(result.out), "x,y,z,status,dx_du,dx_dv,dy_du,dy_dv,dz_du,dz_dv");
  const auto rows = rowsOf(result.out);
  ASSERT_EQ(rows.size(), 2u);
  ASSERT_EQ(rows[0].size(), 10u);
  constexpr double kDifference = 1e-8;  // of a central difference; the derivatives are about 1e-3
  for (const std::size_t k : {0u, 1u}) {
    const Eigen::Vector3d expected = slope([&](double step) {
      Eigen::Vector2d pixel(100, 350);
      pixel[static_cast<Eigen::Index>(k)] += step;
      return file.camera.unproject(pixel).value();
    });
    for (const std::size_t i : {0u, 1u, 2u})
      EXPECT_NEAR(numberIn(rows[0][4 + 2 * i + k]), expected[static_cast<Eigen::Index>(i)], kDifference);
  }
  for (std::size_t i = 4; i < 10; ++i) EXPECT_EQ(rows[1].at(i), "nan");
}

TEST(Jacobian, IsInJsonToo) {
  const auto points =
      nlohmann::json::parse(project("0,0,1\n0,0,-1\n", {"--jacobian", "--json"}).out).at("points");
  ASSERT_EQ(points.size(), 2u);
  EXPECT_EQ(points[0].size(), 39u);
  EXPECT_EQ(points[0].at("du_dcx"), 1);
  EXPECT_EQ(points[0].at("dv_dcx"), 0);
  EXPECT_TRUE(points[1].at("dv_dk3").is_null());
}

TEST(Clip, TakesThePixelsOfTheImageOnly) {
  // The image is 640 x 480; its pixels cover [-0.5, 639.5) x [-0.5, 479.5).
  const std::string pixels = "320,240\n-0.5,-0.5\n-0.50001,0\n639.5,0\n639.49999,479.49999\n0,479.5\nnan,0\n";
  const RunResult rays = runAlidade({"unproject", dataPath("camera.yaml"), "--clip"}, {.input = pixels});
  ASSERT_THAT(rays, EndsWith(0));
  EXPECT_EQ(rays.err, "3 ok, 3 out_of_image, 1 outside\n");
  const auto rows = rowsOf(rays.out);
  const std::vector<std::string> expected = {"ok", "ok",           "out_of_image", "out_of_image",
                                             "ok", "out_of_image", "outside"};
  ASSERT_EQ(rows.size(), expected.size());
  for (std::size_t i = 0; i < rows.size(); ++i) EXPECT_EQ(rows[i].at(3), expected[i]);
  EXPECT_EQ(rows[2].at(0), "nan");

  const RunResult unclipped = runAlidade({"unproject", dataPath("camera.yaml")}, {.input = pixels});
  EXPECT_EQ(unclipped.err, rays.err);
  const auto all = rowsOf(unclipped.out);
  ASSERT_EQ(all.size(), expected.size());
  for (std::size_t i = 0; i < all.size(); ++i) EXPECT_EQ(all[i].at(3), expected[i]);
  EXPECT_LT(numberIn(all[2].at(0)), 0);
}

TEST(Clip, LeavesOutNumbersThatAreOtherwiseThere) {
  const std::string points = "0,0,1\n0.8,0,1\n0,0,-1\n";
  const RunResult all = project(points, {"--jacobian"});
  EXPECT_EQ(all.err, "1 ok, 1 out_of_image, 1 behind\n");
  EXPECT_EQ(rowsOf(all.out).at(1).at(2), "out_of_image");
  EXPECT_GT(numberIn(rowsOf(all.out).at(1).at(0)), 640);
  EXPECT_TRUE(std::isfinite(numberIn(rowsOf(all.out).at(1).at(3))));
  const RunResult clipped = project(points, {"--clip", "--jacobian"});
  ASSERT_THAT(clipped, EndsWith(0));
  EXPECT_EQ(clipped.err, "1 ok, 1 out_of_image, 1 behind\n");
  const auto rows = rowsOf(clipped.out);
  EXPECT_EQ(rows.at(0).at(2), "ok");
  EXPECT_EQ(std::vector<std::string>(rows.at(1).begin(), rows.at(1).begin() + 4),
            (std::vector<std::string>{"nan", "nan", "out_of_image", "nan"}));
  EXPECT_THAT(project(points, {"--clip", "--json"}).out,
              HasSubstr(R"({"u": null, "v": null, "status": "out_of_image"})"));
}

}  // namespace
}  // namespace alidade
