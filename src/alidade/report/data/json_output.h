// SPDX-License-Identifier: MIT
#pragma once

#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <utility>

#include <nlohmann/json.hpp>

#include "alidade/camera/any_camera.h"
#include "alidade/core/diagnosis.h"
#include "alidade/core/image.h"
#include "alidade/geometry/se3.h"

// JSON output of the program. Numbers that are not finite become null, because JSON has none.

namespace alidade {

using nlohmann::json;

/// A document as text. File names may contain any bytes; those that are not UTF-8 become U+FFFD.
[[nodiscard]] inline std::string jsonText(const json& document) {
  return document.dump(2, ' ', false, json::error_handler_t::replace) + "\n";
}

template <class T>
[[nodiscard]] json orNull(const std::optional<T>& value) {
  return value ? json(*value) : json(nullptr);
}

[[nodiscard]] inline json vectorJson(const Eigen::Vector2d& v) {
  return {v.x(), v.y()};
}
[[nodiscard]] inline json vectorJson(const Eigen::Vector3d& v) {
  return {v.x(), v.y(), v.z()};
}

/// A corner of a view. @param error_px  projected minus observed
[[nodiscard]] inline json cornerJson(int id, const Eigen::Vector2d& pixel, const Eigen::Vector2d& error_px) {
  return {{"id", id}, {"u", pixel.x()}, {"v", pixel.y()}, {"dx", error_px.x()}, {"dy", error_px.y()}};
}

/// The parameters by name.
[[nodiscard]] inline json parametersJson(std::span<const std::string_view> names,
                                         std::span<const double> values) {
  json parameters = json::object();
  for (std::size_t i = 0; i < names.size(); ++i) parameters[std::string(names[i])] = values[i];
  return parameters;
}

/// The values of a grid, `valueAt(i)` row by row, as an array of its rows.
template <class ValueAt>
[[nodiscard]] json rowsJson(int columns, int rows, const ValueAt& valueAt) {
  json list = json::array();
  for (int row = 0; row < rows; ++row) {
    json values = json::array();
    for (int column = 0; column < columns; ++column)
      values.push_back(valueAt(static_cast<std::size_t>(row) * static_cast<std::size_t>(columns) +
                               static_cast<std::size_t>(column)));
    list.push_back(std::move(values));
  }
  return list;
}

// Conversions that nlohmann-json finds automatically.
inline void to_json(json& j, const ImageSize& size) {
  j = {{"width", size.width}, {"height", size.height}};
}
inline void to_json(json& j, const Diagnosis& diagnosis) {
  j = {{"id", diagnosis.id},
       {"severity", severityName(diagnosis.severity)},
       {"cause", diagnosis.cause},
       {"evidence", diagnosis.evidence},
       {"effect_px", diagnosis.effect_px},
       {"message", diagnosis.message()},
       {"next_step", diagnosis.next_step}};
}
inline void to_json(json& j, const SE3& pose) {
  const Eigen::Quaterniond& q = pose.rotation.quaternion();
  const Eigen::Vector3d& t = pose.translation;
  j = {{"quaternion_xyzw", {q.x(), q.y(), q.z(), q.w()}}, {"translation_m", {t.x(), t.y(), t.z()}}};
}

}  // namespace alidade
