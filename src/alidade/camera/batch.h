// SPDX-License-Identifier: MIT
#pragma once

#include <span>

#include "alidade/camera/any_camera.h"
#include "alidade/geometry/se3.h"

namespace alidade {

/// Arrays of points, rays or pixels, one array per coordinate. All arrays of one call have the same length.
/// Results may be written to the input arrays; otherwise no arrays may overlap. Arrays of different lengths
/// are a caller's bug and throw std::logic_error.
struct PointColumns {
  std::span<const double> x, y, z;
};
struct PixelColumns {
  std::span<const double> u, v;
};
struct PixelResults {
  std::span<double> u, v;  ///< NaN unless the status is kOk
  std::span<ProjectStatus> status;
};
struct RayResults {
  std::span<double> x, y, z;  ///< of unit length; NaN unless the status is kOk
  std::span<ProjectStatus> status;
};

/// Output arrays for the Jacobians of the pixels (null: not computed): row-major, one point after another;
/// NaN unless the status is kOk.
struct PixelJacobians {
  double* by_point = nullptr;   ///< n times 2x3, of the point as given, before the pose
  double* by_pose = nullptr;    ///< n times 2x6, of xi = [translation, rotation] in T Exp(xi), see SE3
  double* by_params = nullptr;  ///< n times 2xN, of the N parameters of the camera in storage order
};

/// Projects many points in the camera frame. The results agree with those of AnyCamera::projectPoint() to
/// 1e-12 relative. It processes several points at a time, with AVX2 if the processor supports it, which may
/// change the last digits. It allocates no memory.
void projectBatch(const AnyCamera& camera, const PointColumns& points_cam, const PixelResults& pixels,
                  const PixelJacobians& jacobians = {});

/// The same for points in another frame.
void projectBatch(const AnyCamera& camera, const SE3& camera_from_points, const PointColumns& points,
                  const PixelResults& pixels, const PixelJacobians& jacobians = {});

/// The same for points in the camera frame, with values as results.
void projectBatch(const AnyCamera& camera, std::span<const Eigen::Vector3d> points_cam,
                  std::span<Projection> out);

/// Rays of many pixels; they agree with those of AnyCamera::unproject() to 1e-12. The status is
/// kOutsideDomain if no ray projects to the pixel. `J_ray_pixel`, if not null, receives n row-major 3x2
/// Jacobians.
void unprojectBatch(const AnyCamera& camera, const PixelColumns& pixels, const RayResults& rays,
                    double* J_ray_pixel = nullptr);

/// projectBatch() for arrays of rows: points x, y, z and pixels u, v side by side. They agree to the last
/// digit.
/// @param camera_from_points  null: the points are in the camera frame
/// @param points  3 numbers per point; `pixels` gets 2 and `status` one
void projectRows(const AnyCamera& camera, const SE3* camera_from_points, std::span<const double> points,
                 std::span<double> pixels, std::span<ProjectStatus> status,
                 const PixelJacobians& jacobians = {});

/// unprojectBatch() for arrays of rows. They agree to the last digit.
/// @param pixels  2 numbers per pixel; `rays` gets 3 and `status` one
void unprojectRows(const AnyCamera& camera, std::span<const double> pixels, std::span<double> rays,
                   std::span<ProjectStatus> status, double* J_ray_pixel = nullptr);

}  // namespace alidade
