// SPDX-License-Identifier: MIT
#pragma once

/// The main header of the component `camera`, which needs only Eigen.
///
/// AnyCamera is a camera of one of the models (modelIds()). make(id, parameters) creates it. project()
/// returns the pixel of a point in the camera frame, or a status if it has no pixel. unproject() returns the
/// ray of a pixel. Pixel (0, 0) is the centre of the top-left pixel, points are in metres, and the camera
/// frame is x right, y down, z forward. projectBatch() and unprojectBatch() take arrays, with poses and
/// Jacobians. cropCamera(), binCamera(), resizeCamera() and rotateCamera() return the camera of an edited
/// image, and fitModel() the closest camera of another model. AnyRig holds cameras that are fixed to each
/// other; triangulate() returns the point that several of them see. Errors are thrown as alidade::Error.
#include "alidade/camera/any_camera.h"
#include "alidade/camera/any_rig.h"
#include "alidade/camera/batch.h"
#include "alidade/camera/camera_edit.h"
#include "alidade/camera/model_fit.h"
#include "alidade/camera/triangulation.h"
#include "alidade/core/error.h"
