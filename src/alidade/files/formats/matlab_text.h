// SPDX-License-Identifier: MIT
#pragma once

#include <string>
#include <string_view>

namespace alidade::detail {

/// Is this what MATLAB's command window prints of a camera, with the numbers or without them?
[[nodiscard]] bool isMatlabText(const std::string& text);

/// The same properties as YAML, each in its line; lines of other text become empty.
[[nodiscard]] std::string matlabTextAsYaml(const std::string& text);

/// Is this what is printed instead of a value: "[3x3 double]", "[1x1 cameraIntrinsics]"?
[[nodiscard]] bool isUnexpanded(std::string_view value);

/// @throws Error (kInput) with the line, and what to export, if the text has a camera's properties without
/// the focal length, because the command window did not expand the object or matrix that holds it;
/// UnsupportedCamera if that is a fisheye's
void refuseUnexpanded(const std::string& text, const std::string& file);

/// Is this a matrix of three columns as the command window prints it: "K =" and rows below?
[[nodiscard]] bool isPrintedMatrix(const std::string& text);

/// @throws Error (kInput) with the line, and what to export, if isPrintedMatrix
void refusePrintedMatrix(const std::string& text, const std::string& file);

}  // namespace alidade::detail
