// SPDX-License-Identifier: MIT
#include "alidade/files/formats/opencv_pair.h"

#include <fmt/format.h>

#include "alidade/files/formats/lens_numbers.h"
#include "alidade/files/formats/pose_numbers.h"

namespace alidade::detail {

bool statesPair(const CameraDocument& document) {
  return document.isMap() && document.has("R") && document.has("T");
}

SE3 readPair(const YamlNode& root, std::vector<Remark>& remarks) {
  const YamlNode rotation = root.at("R");
  const YamlNode translation = root.at("T");
  const bool is_vector = statedNumbers(rotation).size() == 3;
  const SE3 second_from_first{is_vector ? SO3::exp(readVector(rotation)) : readRotation(rotation, remarks),
                              readVector(translation)};
  constexpr double kLongBaseline = 5;  // m
  const double length = second_from_first.translation.norm();
  if (length > kLongBaseline) {
    remarks.push_back({"assumed", translation.where() +
                                      fmt::format(": taken as metres, a baseline of {:.4g} m; OpenCV writes "
                                                  "it in the unit of the board's squares",
                                                  length)});
  }
  return second_from_first;
}

}  // namespace alidade::detail
