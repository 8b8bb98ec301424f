// SPDX-License-Identifier: MIT
#pragma once

/// The front door of the component `files`, which needs neither OpenCV nor Ceres.
///
/// loadCamera() reads the only camera of a file of any format, or the one that FILE#NAME names; loadCameras()
/// reads all of them with what was noticed about them; saveCamera() writes one in any format. What a file
/// holds is a CameraRecord: camera, image size, and where it was calibrated what is known of that, such as
/// statedCovariance(). readCornersFile(), readPoseList() and readBoard() read what the program reads. Errors
/// are alidade::Error (kInput), which names file, line and key.
#include "alidade/core/error.h"
#include "alidade/files/board_file.h"
#include "alidade/files/camera_save.h"
#include "alidade/files/camera_source.h"
#include "alidade/files/corners_file.h"
#include "alidade/files/pose_list.h"
