// SPDX-License-Identifier: MIT
#pragma once

/// The front door of the component `camera`, which needs Eigen only.
///
/// AnyCamera is a camera of one of the models (modelIds()): make(id, parameters) makes it, project() gives
/// the pixel of a point of the camera frame or why there is none, and unproject() the ray of a pixel. Pixel
/// (0, 0) is the centre of the top-left pixel, points are in metres, and the camera frame is x right, y down,
/// z forward. projectBatch() and unprojectBatch() take arrays, with poses and Jacobians. cropCamera(),
/// binCamera(), resizeCamera() and rotateCamera() give the camera of an edited image, and fitModel() the
/// nearest camera of another model. Errors are alidade::Error.
#include "alidade/camera/any_camera.h"
#include "alidade/camera/batch.h"
#include "alidade/camera/camera_edit.h"
#include "alidade/camera/model_fit.h"
#include "alidade/core/error.h"
