// SPDX-License-Identifier: MIT
#include "alidade/files/formats/format_text.h"

#include <yaml-cpp/yaml.h>

#include <nlohmann/json.hpp>

#include "alidade/core/text.h"

namespace alidade::detail {

std::string listText(std::span<const double> values) {
  std::string text = "[";
  for (std::size_t i = 0; i < values.size(); ++i) text += (i == 0 ? "" : ", ") + realText(values[i]);
  return text + "]";
}

std::string realText(double value) {
  std::string text = exactText(value);
  const std::size_t exponent = text.find('e');
  if (text.find('.') == std::string::npos)
    text.insert(exponent == std::string::npos ? text.size() : exponent, ".0");
  return text;
}

std::string yamlText(const std::string& text) {
  YAML::Emitter out;
  out << text;
  return out.c_str();
}

std::string jsonFileText(const nlohmann::ordered_json& document) {
  return document.dump(2) + "\n";
}

}  // namespace alidade::detail
