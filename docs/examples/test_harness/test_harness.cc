// SPDX-License-Identifier: MIT
// How to test a projection of your own against Alidade's: many points, exact pixels, derivatives, and a
// reason for each point without a pixel. Needs only Eigen.
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <vector>

#include "alidade/camera/batch.h"

namespace {

// The code under test: k1 and k2 of OpenCV's model, in single precision, as a tracker may have it.
struct MyCamera {
  float fx, fy, cx, cy, k1, k2;

  bool project(float x, float y, float z, float& u, float& v) const {
    if (z <= 0) return false;
    const float a = x / z;
    const float b = y / z;
    const float r2 = a * a + b * b;
    const float scale = 1 + r2 * (k1 + r2 * k2);
    u = fx * scale * a + cx;
    v = fy * scale * b + cy;
    return true;
  }
};

}  // namespace

int main() {
  const MyCamera mine{.fx = 500, .fy = 500, .cx = 320, .cy = 240, .k1 = -0.25F, .k2 = 0.01F};
  const std::vector<double> parameters = {500, 500, 320, 240, -0.25, static_cast<double>(0.01F), 0, 0, 0};
  const auto camera = alidade::AnyCamera::make("radtan", parameters);

  // Points in a world frame, one array per coordinate: grids 40 m wide, 5 m in front of and behind the
  // camera.
  std::vector<double> x, y, z;
  for (int k = -1; k <= 1; k += 2) {
    for (int j = -40; j <= 40; ++j) {
      for (int i = -40; i <= 40; ++i) {
        x.push_back(0.5 * i);
        y.push_back(0.5 * j);
        z.push_back(5.0 * k);
      }
    }
  }
  const alidade::SE3 camera_from_world;  // the identity here

  const std::size_t count = x.size();
  std::vector<double> u(count), v(count), by_pose(12 * count);
  std::vector<alidade::ProjectStatus> status(count);
  alidade::projectBatch(camera, camera_from_world, {x, y, z}, {u, v, status}, {.by_pose = by_pose.data()});

  double worst = 0;
  int num_ok = 0;
  int num_behind = 0;
  int num_folded = 0;
  for (std::size_t i = 0; i < count; ++i) {
    float my_u = 0;
    float my_v = 0;
    const bool is_mine = mine.project(static_cast<float>(x[i]), static_cast<float>(y[i]),
                                      static_cast<float>(z[i]), my_u, my_v);
    switch (status[i]) {
      case alidade::ProjectStatus::kOk:
        if (!is_mine) return 1;
        worst = std::max(worst, std::hypot(my_u - u[i], my_v - v[i]));
        ++num_ok;
        break;
      case alidade::ProjectStatus::kBehind:
        if (is_mine) return 1;
        ++num_behind;
        break;
      case alidade::ProjectStatus::kOutsideDomain:
        num_folded += is_mine ? 1 : 0;  // mine gives a pixel, the lens has none
        break;
    }
  }
  std::printf("%d points agree to %.1e px, %d are behind the camera\n", num_ok, worst, num_behind);
  std::printf("%d points get a pixel of mine although the polynomial has folded there\n", num_folded);

  // And back: the ray of each pixel, with its derivatives with respect to the pixel.
  std::vector<double> ray_x(count), ray_y(count), ray_z(count), by_pixel(6 * count);
  alidade::unprojectBatch(camera, {u, v}, {ray_x, ray_y, ray_z, status}, by_pixel.data());
  double worst_ray = 0;
  for (std::size_t i = 0; i < count; ++i) {
    if (status[i] != alidade::ProjectStatus::kOk) continue;  // had no pixel
    const double length = std::hypot(x[i], y[i], z[i]);
    worst_ray = std::max(
        worst_ray, std::hypot(ray_x[i] - x[i] / length, ray_y[i] - y[i] / length, ray_z[i] - z[i] / length));
  }
  std::printf("rays come back to %.1e rad\n", worst_ray);
  return worst < 1e-3 && worst_ray < 1e-9 && num_ok > 100 && num_folded > 100 ? 0 : 1;
}
