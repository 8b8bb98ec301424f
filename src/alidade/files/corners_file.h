// SPDX-License-Identifier: MIT
#pragma once

#include <string>
#include <vector>

#include "alidade/target/checkerboard.h"
#include "alidade/target/view.h"

namespace alidade {

/// The corners of a board in many images: the seam between detection and calibration.
struct CornersFile {
  std::string camera = "camera";
  Checkerboard board;
  std::vector<View> views;            ///< in natural order of image name
  std::vector<std::string> comments;  ///< written as lines that start with '#'; not read back
};

/// Text of a corners file: '#' lines (a comment of several lines becomes several), then CSV with the header
/// camera,image,width,height,board,corner_id,col,row,u,v,sigma_px and a row a corner (sigma_px empty =
/// unknown).
/// @throws Error (kInput) for the name of an image or the camera with a line break in it
[[nodiscard]] std::string cornersFileText(const CornersFile& file);

/// Writes atomically. @throws Error (kInput)
void writeCornersFile(const std::string& path, const CornersFile& file);

/// Reads one; pieces written apart and concatenated (with their headers) read as one file.
/// @throws Error (kInput) naming the line: unknown or missing columns, numbers that are not, several boards
/// or cameras, a corner given twice.
[[nodiscard]] CornersFile readCornersFile(const std::string& path);

/// The same from text; `name` stands for the file in messages.
[[nodiscard]] CornersFile parseCornersFile(const std::string& text, const std::string& name);

}  // namespace alidade
