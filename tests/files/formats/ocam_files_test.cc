// SPDX-License-Identifier: MIT
// Scaramuzza's lens in the files of four programs, against his own definition.
#include <cmath>
#include <functional>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "alidade/files/camera_source.h"
#include "files/formats/reading.h"

namespace alidade {
namespace {

using testing::HasSubstr;

struct Toolbox {
  std::vector<double> a;  // a0 a1 a2 ...
  double c, d, e;
  double x_centre, y_centre;
};

// (x, y) of the pixel of a ray in the toolbox's frame, whose z has the sign of a0: A (x, y) + centre with
// z / |(X, Y)| = f(r) / r, by bisection from the axis outwards.
Eigen::Vector2d imageOf(const Toolbox& lens, double X, double Y, double Z) {
  const double rho = std::hypot(X, Y);
  const auto excess = [&](double r) {
    double f = 0;
    for (std::size_t i = lens.a.size(); i-- > 0;) f = f * r + lens.a[i];
    return (f * rho - Z * r) * (lens.a[0] > 0 ? 1 : -1);  // positive on the axis
  };
  double low = 0;
  double high = 1;
  while (excess(high) > 0) high += 1;
  for (int i = 0; i < 200; ++i) {
    const double middle = 0.5 * (low + high);
    (excess(middle) > 0 ? low : high) = middle;
  }
  const double x = low * X / rho;
  const double y = low * Y / rho;
  return {lens.c * x + lens.d * y + lens.x_centre, lens.e * x + y + lens.y_centre};
}

const std::string kText =
    "#polynomial coefficients for the DIRECT mapping function\n\n5 -2.8e+02 0.0 1.1e-03 -2.0e-07 1.5e-09 \n\n"
    "#polynomial coefficients for the inverse mapping function\n\n3 420.0 200.0 5.0\n\n#center\n\n241.5 318.25\n\n"
    "#affine\n\n1.001 0.002 -0.003\n\n#height and width\n\n480 640\n";

const std::string kJson =
    R"({"camera_name": "front", "taylor_coefficient": [280.0, 0.0, -1.1e-03, 2.0e-07, -1.5e-09],
  "distortion_center": [318.25, 241.5], "stretch_matrix": [[1.001, 0.002], [-0.003, 1.0]], "inverse_poly": [1, 2]})";

const std::string kMatlab = R"({"MappingCoefficients": [280.0, -1.1e-03, 2.0e-07, -1.5e-09],
  "DistortionCenter": [319.25, 242.5], "StretchMatrix": [[1.001, 0.002], [-0.003, 1.0]], "ImageSize": [480, 640]})";

const std::string kCamodocal = R"(%YAML:1.0
---
model_type: scaramuzza
camera_name: front
image_width: 640
image_height: 480
poly_parameters: {p0: -280.0, p1: 0.0, p2: 1.1e-03, p3: -2.0e-07, p4: 1.5e-09}
inv_poly_parameters: {p0: 420.0, p1: 200.0}
affine_parameters: {ac: 1.001, ad: 0.002, ae: -0.003, cx: 318.25, cy: 241.5}
)";

TEST(OcamFiles, ProjectAsTheToolboxDefinesIt) {
  const Toolbox rows = {{-280, 0, 1.1e-3, -2e-7, 1.5e-9}, 1.001, 0.002, -0.003, 241.5, 318.25};
  const Toolbox columns = {{280, 0, -1.1e-3, 2e-7, -1.5e-9}, 1.001, 0.002, -0.003, 318.25, 241.5};
  struct Case {
    const char* format;
    std::string text;
    std::function<Eigen::Vector2d(double, double, double)> pixel;  // of a ray right, down, forward
  };
  const auto of_rows = [&](double X, double Y, double Z) {
    const Eigen::Vector2d row_first = imageOf(rows, Y, X, -Z);
    return Eigen::Vector2d(row_first.y(), row_first.x());
  };
  const auto of_columns = [&](double X, double Y, double Z) { return imageOf(columns, X, Y, Z); };
  const std::vector<Case> cases = {{"ocam", kText, of_rows},
                                   {"ocam", kJson, of_columns},
                                   {"matlab", kMatlab, of_columns},
                                   {"camodocal", kCamodocal, of_columns}};
  int num_rays = 0;
  for (const Case& one : cases) {
    const CameraSource source =
        parseCameras(one.text, "file", {.image_size = ImageSize{640, 480}, .model = {}});
    ASSERT_EQ(source.cameras.size(), 1u) << one.text;
    EXPECT_EQ(source.format, one.format);
    EXPECT_EQ(source.cameras[0].image_size, std::optional(ImageSize{640, 480}));
    for (double angle = 0.05; angle < 1.75; angle += 0.1) {
      for (double azimuth = 0.1; azimuth < 6.2; azimuth += 0.5) {
        const Eigen::Vector3d ray(std::sin(angle) * std::cos(azimuth), std::sin(angle) * std::sin(azimuth),
                                  std::cos(angle));
        const Projection projected = source.cameras[0].camera.project(ray);
        ASSERT_TRUE(projected.ok()) << one.format << " " << angle;
        EXPECT_LT((projected.pixel - one.pixel(ray.x(), ray.y(), ray.z())).norm(), 1e-9)
            << one.format << " " << angle;
        ++num_rays;
      }
    }
  }
  EXPECT_EQ(num_rays, 4 * 17 * 13);
}

TEST(OcamFiles, SayWhatIsWrong) {
  const auto changed = [](std::string text, const std::string& from, const std::string& to) {
    EXPECT_NE(text.find(from), std::string::npos) << from;
    return text.replace(text.find(from), from.size(), to);
  };
  const std::vector<std::pair<std::string, std::string>> cases = {
      {changed(kText, "5 -2.8e+02 0.0", "5 -2.8e+02 0.1"), "file:3: found a polynomial"},
      {changed(kText, "5 -2.8e+02 0.0 1.1e-03", "9 -2.8e+02 0.0 1e-20 1e-20 1e-20 1e-20 1.1e-03"),
       "degree 8"},
      {changed(kText, "480 640", "480.5 640"), "480.5"},
      {changed(kJson, "-0.003, 1.0", "-0.003, 2.0"), "another last element than 1"},
      {changed(kMatlab, "[280.0, -1.1e-03, 2.0e-07, -1.5e-09]", "[]"), "a0 a2 a3 a4"},
      {changed(kCamodocal, "p0: -280.0", "p0: 0.0"), "without constant term"},
  };
  for (const auto& [text, complaint] : cases)
    EXPECT_THAT(complaintAbout(text, {.image_size = ImageSize{640, 480}, .model = {}}), HasSubstr(complaint))
        << text;
  // The inverse polynomial above is a rough one.
  EXPECT_THAT(remarksOn(parseCameras(kText, "file").cameras.at(0)), HasSubstr("misses the direct one"));
}

}  // namespace
}  // namespace alidade
