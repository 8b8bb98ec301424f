// SPDX-License-Identifier: MIT
#pragma once

#include <span>
#include <string>
#include <vector>

#include "alidade/target/board.h"
#include "alidade/target/view.h"

namespace alidade {

/// The corners of boards in many images: the interface between detection and calibration.
struct CornersFile {
  std::string camera = "camera";
  std::vector<Board> boards;          ///< in the order in which rows name them
  std::vector<View> views;            ///< in natural order of image name, then of the boards
  std::vector<std::string> comments;  ///< written as lines that start with '#'; not read
};

/// Text of a corners file: '#' lines (a comment of several lines becomes several), then CSV with the header
/// camera,image,width,height,board,corner_id,col,row,u,v,sigma_px and one row per corner (sigma_px empty =
/// unknown).
/// @throws Error (kInput) if the name of an image or the camera contains a line break
[[nodiscard]] std::string cornersFileText(const CornersFile& file);

/// Writes atomically. @throws Error (kInput)
void writeCornersFile(const std::string& path, const CornersFile& file);

/// Reads a corners file. Concatenated files (with their headers) are read as one file.
/// @throws Error (kInput) naming the line: unknown or missing columns, invalid numbers, several cameras, ids
/// that the row's board does not have, or a repeated corner.
[[nodiscard]] CornersFile readCornersFile(const std::string& path);

/// Reads the corners of one camera from several files. Images of one board have different names.
[[nodiscard]] CornersFile readCornersFiles(std::span<const std::string> paths);

/// The same from text; messages use `name` as the file name.
[[nodiscard]] CornersFile parseCornersFile(const std::string& text, const std::string& name);

}  // namespace alidade
