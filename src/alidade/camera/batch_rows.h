// SPDX-License-Identifier: MIT
#pragma once

#include <span>

#include "alidade/camera/any_camera.h"
#include "alidade/camera/batch.h"
#include "alidade/geometry/se3.h"

namespace alidade {

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
