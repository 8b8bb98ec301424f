// SPDX-License-Identifier: MIT
#pragma once

/// The main header of the component `files`, which needs neither OpenCV nor Ceres.
///
/// loadCamera() reads the only camera of a file of any format, or the camera selected by FILE#NAME.
/// loadCameras() reads all cameras, with remarks. saveCamera() writes a camera in any format. The
/// content of a file is a CameraRecord: camera, image size and calibration data, such as statedCovariance().
/// loadRig() reads several cameras and where they are; saveRig() writes a rig file.
/// readCornersFile(), readPoseList(), readRobotTable() and readBoard() read the other input files;
/// readHandEye() and handEyeText() hand-eye files. Errors are thrown as alidade::Error (kInput); the message
/// names the file, line and key.
///
///     const alidade::CameraRecord record = alidade::loadCamera("camchain.yaml#cam0");
///     std::printf("fx: %g px\n", record.camera.parameters()[0]);
///     if (const auto covariance = alidade::statedCovariance(record))
///       std::printf("its standard deviation: %g px\n", std::sqrt((*covariance)(0, 0)));
///     alidade::saveCamera("camera_info.yaml", record, "ros");
#include "alidade/core/error.h"
#include "alidade/files/board_file.h"
#include "alidade/files/camera_source.h"
#include "alidade/files/corners_file.h"
#include "alidade/files/hand_eye_file.h"
#include "alidade/files/pose_list.h"
#include "alidade/files/rig_file.h"
#include "alidade/files/robot_table.h"
