// SPDX-License-Identifier: MIT
#pragma once

/// The main header of the component `camera`, which needs only Eigen.
///
/// AnyCamera is a camera of one of the models (modelIds()). make(id, parameters) creates it.
/// projectPoint() returns the pixel of a point in the camera frame, and project() that of a ray, or a status
/// if there is no pixel. unproject() returns the ray of a pixel. Pixel (0, 0) is the centre of the top-left
/// pixel, points are in metres, and the camera frame is x right, y down, z forward. projectBatch() and
/// unprojectBatch() take arrays, with poses and Jacobians. cropCamera(), binCamera(), resizeCamera() and
/// rotateCamera() return the camera of an edited image, and fitModel() the closest camera of another model.
/// AnyRig holds cameras that are fixed to each other; triangulate() returns the point that several of them
/// see. Errors are thrown as alidade::Error.
///
///     const std::vector<double> params = {532, 533, 321, 237, -0.28, 0.06, 1e-3, -5e-4, 0};
///     const auto camera = alidade::AnyCamera::make("radtan", params);
///     const alidade::Projection projection = camera.projectPoint({0.1, -0.05, 1});
///     if (projection.ok()) std::printf("(%.2f, %.2f) px\n", projection.pixel.x(), projection.pixel.y());
///     if (const auto ray = camera.unproject({320, 240})) std::printf("%.3f along the axis\n", ray->z());
///     const auto half = alidade::resizeCamera(camera, {640, 480}, {320, 240});
///     std::printf("fx of the small image: %.1f px\n", half.camera.parameters()[0]);
#include "alidade/camera/any_camera.h"
#include "alidade/camera/any_rig.h"
#include "alidade/camera/batch.h"
#include "alidade/camera/camera_edit.h"
#include "alidade/camera/correction_field.h"
#include "alidade/camera/image_domain.h"
#include "alidade/camera/model_fit.h"
#include "alidade/camera/triangulation.h"
#include "alidade/core/error.h"
