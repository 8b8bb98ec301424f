// SPDX-License-Identifier: MIT
#include "alidade/io/formats/format_text.h"

#include <yaml-cpp/yaml.h>

#include "alidade/core/text.h"

namespace alidade::detail {

std::string listText(std::span<const double> values) {
  std::string text = "[";
  for (std::size_t i = 0; i < values.size(); ++i) text += (i == 0 ? "" : ", ") + exactText(values[i]);
  return text + "]";
}

std::string realText(double value) {
  std::string text = exactText(value);
  if (text.find_first_of(".e") == std::string::npos) text += ".0";
  return text;
}

std::string yamlText(const std::string& text) {
  YAML::Emitter out;
  out << text;
  return out.c_str();
}

}  // namespace alidade::detail
