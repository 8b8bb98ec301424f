// SPDX-License-Identifier: MIT
#pragma once

#include <optional>
#include <string>
#include <string_view>

// Camera files in notations other than YAML and JSON, rewritten as YAML in which keys keep their lines.
namespace alidade::detail {

/// Lists or maps nested deeper than this are refused.
constexpr int kMaxDepth = 100;

/// XML, TOML, INI or JSON lines as YAML; nothing for other text. In XML, elements and their attributes are
/// the keys of a map, elements of one name and those named "_" (OpenCV) a list; in INI, sections are maps.
/// Numbers separated by blanks are a list.
/// @throws Error (kInput) with the place if the text cannot be parsed
[[nodiscard]] std::optional<std::string> otherNotationAsYaml(const std::string& text,
                                                             const std::string& file);

/// Rewrites KITTI's lines of numbers ("P0: 718.9 0.0 607.2") as lists.
[[nodiscard]] std::string numberLinesAsLists(const std::string& text);

/// DSO's camera.txt, which has neither keys nor structure: the map of dso_model, numbers and size, or nothing
/// for other text. The first line has fx fy cx cy and the coefficients, perhaps after the name of the lens,
/// the second the image size, the third and fourth describe the rectified image (DSO,
/// src/util/Undistort.cpp).
[[nodiscard]] std::optional<std::string> dsoAsYaml(std::string_view text);

/// True for the binary files that binaryAsText() reads: MATLAB's .mat, COLMAP's cameras.bin.
[[nodiscard]] bool isCameraBinary(std::string_view bytes);

/// The content of such a file as text: a YAML map of the variables of a .mat file (level 5: numbers, text and
/// structs; MATLAB's "MAT-File Format"), of which a single struct stands for the file; or the lines of
/// COLMAP's cameras.txt (its documentation, "Output format").
/// @throws Error (kInput) with the byte for damaged files, more than a few megabytes, and MATLAB 7.3 (HDF5)
[[nodiscard]] std::string binaryAsText(std::string_view bytes, const std::string& file);

/// Text as a YAML scalar in double quotes.
[[nodiscard]] std::string quotedYaml(std::string_view text);

}  // namespace alidade::detail
