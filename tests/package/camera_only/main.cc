// SPDX-License-Identifier: MIT
// Projects points with cameras whose pixels are known beforehand, with nothing but alidade::camera.
#include "all_headers.h"

#include "../own_eigen.h"

#if defined(CV_VERSION) || defined(CV_VERSION_MAJOR)
#error "a header of alidade::camera includes OpenCV"
#endif
#if defined(CERES_VERSION_MAJOR) || defined(CERES_PUBLIC_CERES_H_)
#error "a header of alidade::camera includes Ceres"
#endif

#include <cstdio>
#include <numbers>
#include <vector>

namespace {

int num_checks = 0;
int num_failures = 0;

void check(bool is_right, const char* what) {
  ++num_checks;
  if (is_right) return;
  ++num_failures;
  std::fprintf(stderr, "camera_only: wrong: %s\n", what);
}

// Of a type whose alignment would depend on the compiler's flags if it were Eigen's alone.
alidade::SE3 poseOf(double angle_rad, double distance_m) {
  alidade::SE3 pose;
  pose.rotation = alidade::SO3::exp({0, 0, angle_rad});
  pose.translation = {0, 0, distance_m};
  return pose;
}

bool isNear(const Eigen::Vector2d& a, const Eigen::Vector2d& b) {
  constexpr double kRoundingPx = 1e-9;
  return (a - b).norm() <= kRoundingPx;
}

}  // namespace

int main() {
  using alidade::AnyCamera;
  const Eigen::Vector3d point(0.2, -0.1, 2.0);

  const AnyCamera pinhole = AnyCamera::make("pinhole", std::vector<double>{800, 820, 319.5, 239.5});
  check(isNear(pinhole.project(point).pixel, {399.5, 198.5}), "pixel of the pinhole camera");

  // Brown's formula written out for x = 0.1, y = -0.05, r^2 = 0.0125.
  const AnyCamera radtan =
      AnyCamera::make("radtan", std::vector<double>{800, 820, 319.5, 239.5, -0.2, 0.05, 1e-3, -2e-3, 0.0});
  const double a = 1 - 0.2 * 0.0125 + 0.05 * 0.0125 * 0.0125;
  const double mx = 0.1 * a + 2 * 1e-3 * 0.1 * -0.05 - 2e-3 * (0.0125 + 2 * 0.01);
  const double my = -0.05 * a + 1e-3 * (0.0125 + 2 * 0.0025) - 2 * 2e-3 * 0.1 * -0.05;
  check(isNear(radtan.project(point).pixel, {800 * mx + 319.5, 820 * my + 239.5}),
        "pixel of the radtan camera");

  const auto ray = radtan.unproject(radtan.project(point).pixel);
  check(ray && (*ray - point.normalized()).norm() < 1e-9, "ray of that pixel");
  check(radtan.project(-point).status == alidade::ProjectStatus::kBehind, "a point behind the camera");

  // The board's second corner, seen from half a metre with the board turned by 90 degrees about the axis.
  const alidade::Checkerboard board{.columns = 9, .rows = 6, .square_m = 0.025};
  const std::vector<alidade::SE3> poses = {poseOf(0, 1), poseOf(std::numbers::pi / 2, 0.5)};
  const alidade::SE3& camera_from_board = poses[1];
  check(isNear(pinhole.project(camera_from_board * board.corner(1)).pixel, {319.5, 239.5 + 820 * 0.05}),
        "pixel of a board's corner");

  // A pose's size and alignment are the library's: it writes the pixel of the same point as the loop above.
  double u = 0;
  double v = 0;
  alidade::ProjectStatus status{};
  const Eigen::Vector3d corner = board.corner(1);
  alidade::projectBatch(pinhole, camera_from_board, {{&corner.x(), 1}, {&corner.y(), 1}, {&corner.z(), 1}},
                        {{&u, 1}, {&v, 1}, {&status, 1}});
  check(isNear({u, v}, {319.5, 239.5 + 820 * 0.05}), "pixel of a batch with a pose");

  // The library allocates the matrix, and this program frees it.
  alidade::EditedCamera half = alidade::binCamera(radtan, {640, 480}, 2);
  const Eigen::MatrixXd J = half.J_new_old;
  half = alidade::rotateCamera(half.camera, half.size, 1);
  check(J.rows() == 9 && J(0, 0) == 0.5 && half.J_new_old(0, 1) == 1, "derivatives of an edited camera");

  check(ownEigenWorks(), "linear systems solved by this program");
  const Eigen::MatrixXd covariance = Eigen::MatrixXd::Identity(9, 9) * 1e-6;
  const alidade::ComparedCamera compared{.camera = &radtan, .size = {640, 480}, .covariance = covariance};
  const auto difference = alidade::projectionDifference(compared, compared);
  check(difference.num_compared > 0 && difference.p95_px < 1e-6, "difference of a camera from itself");

  constexpr int kNumChecks = 9;
  return num_failures == 0 && num_checks == kNumChecks ? 0 : 1;
}
