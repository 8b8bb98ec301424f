// SPDX-License-Identifier: MIT
#pragma once

#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "alidade/core/image.h"
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

/// True for the name of a corners file as mrcal and mrgingham write it.
[[nodiscard]] bool isVnlFile(const std::string& path);

/// True for a text that starts as the files of corners do, whatever its name.
[[nodiscard]] bool startsLikeCorners(std::string_view text);

/// Checks before any long work that such a file can hold the corners of these boards in these images: of one
/// board with points in evenly spaced columns and rows, which is all that mrcal supports, and of images with
/// names in ASCII characters without blanks and '#'. @throws Error (kInput)
void checkVnl(std::span<const Board> boards, std::span<const std::string> images);

/// Text of a .vnl file: the comments as lines that start with '##', the legend "# filename x y" and one row
/// per corner of the board, "-" for x and y if the image does not show it. The format has no negative
/// coordinates, so corners that need one at the left or upper border are written as not seen.
///
/// There is no column for sigmas. mrcal reads a fourth column as levels or, with a flag, as weights, but
/// treats three columns as equal weights. It has no tau (see CornerNoise), and without it the sigmas of
/// detection are poor weights: they raise the cross-validation error of two sets of photographs by 3 to 5 %.
/// @throws Error (kInput) as checkVnl()
[[nodiscard]] std::string vnlFileText(const CornersFile& file);

/// Writes atomically. @throws Error (kInput)
void writeVnlFile(const std::string& path, const CornersFile& file);

/// Reads .vnl files of one camera, which state neither the board nor the size of the images. A corner is not
/// seen if one of its values is "-" or a coordinate is negative, or the level, or the weight is not positive.
/// Images without corners are skipped.
///
/// The sigma of a corner at level L is proportional to 2^L, that of a corner with weight w to 1/w. If these
/// are equal for all corners, sigma_px is NaN. Otherwise the best corners get a sigma of 1 px and the others
/// proportionally more. That exceeds the errors of any usable corner, so CornerNoise finds no tau, and the
/// calibration weights the corners by their ratios in the files.
/// @throws Error (kInput) naming the line: unknown legend, an unexpected number of values or of rows per
/// image, invalid numbers, corners outside the image, or a repeated image
[[nodiscard]] CornersFile readVnlFiles(std::span<const std::string> paths, const Board& board,
                                       ImageSize size);

/// The same from text; messages use `name` as the file name.
[[nodiscard]] CornersFile parseVnlFile(const std::string& text, const std::string& name, const Board& board,
                                       ImageSize size);

}  // namespace alidade
