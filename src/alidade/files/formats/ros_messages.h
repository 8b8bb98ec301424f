// SPDX-License-Identifier: MIT
#pragma once

#include <string>

namespace alidade::detail {

/// Of several messages CameraInfo, as `rostopic echo` prints them with a line "---" behind each, the first,
/// where all say the same but for their headers (time and count); any other text as it is. Linear in the
/// text. @throws Error (kInput) with the line of a message that says something else
[[nodiscard]] std::string onlyMessage(const std::string& text, const std::string& file);

/// Is this the INI file that ROS' calibrator writes beside ost.yaml?
[[nodiscard]] bool isCalibratorIni(const std::string& text);

}  // namespace alidade::detail
