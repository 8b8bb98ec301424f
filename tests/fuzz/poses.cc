// SPDX-License-Identifier: MIT
#include "alidade/files/hand_eye_file.h"
#include "alidade/files/pose_list.h"
#include "alidade/files/robot_table.h"
#include "fuzz.h"

int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace alidade;
  const std::string text = fuzz::textOf(data, size);
  fuzz::read([&] { (void)parsePoseList(text, "poses"); });
  fuzz::read([&] { (void)parsePoseList(text, "poses", "camera_from_world"); });
  fuzz::read([&] { (void)parseRobotTable(text, "poses"); });
  fuzz::read([&] { (void)parseHandEye(text, "handeye"); });
  // Text in braces is a pose itself; anything else would be the name of a file.
  fuzz::read([&] { (void)readPoseSource("{" + text); });
  return 0;
}
