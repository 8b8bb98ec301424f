// SPDX-License-Identifier: MIT
#include "alidade/files/formats/opencv_text.h"

#include "alidade/core/text.h"
#include "alidade/files/formats/format_text.h"

namespace alidade::detail {
namespace {

std::string valuesText(const OpenCvNode& node, std::string_view separator) {
  std::vector<std::string> texts;
  for (const double value : node.values) texts.push_back(realText(value));
  return join(texts, separator);
}

std::string numberText(const OpenCvNode& node) {
  return node.values.empty() ? std::to_string(node.whole) : realText(node.values.front());
}

}  // namespace

std::string openCvYaml(std::span<const OpenCvNode> nodes) {
  std::string text = "%YAML:1.0\n---\n";
  for (const OpenCvNode& node : nodes) {
    text += node.key + ": ";
    if (node.rows == 0) {
      text += numberText(node) + "\n";
    } else {
      text += "!!opencv-matrix\n   rows: " + std::to_string(node.rows) +
              "\n   cols: " + std::to_string(node.columns) + "\n   dt: d\n   data: [ " +
              valuesText(node, ", ") + " ]\n";
    }
  }
  return text;
}

std::string openCvXml(std::span<const OpenCvNode> nodes) {
  std::string text = "<?xml version=\"1.0\"?>\n<opencv_storage>\n";
  for (const OpenCvNode& node : nodes) {
    if (node.rows == 0) {
      text += "<" + node.key + ">" + numberText(node) + "</" + node.key + ">\n";
    } else {
      text += "<" + node.key + " type_id=\"opencv-matrix\">\n  <rows>" + std::to_string(node.rows) +
              "</rows>\n  <cols>" + std::to_string(node.columns) + "</cols>\n  <dt>d</dt>\n  <data>\n    " +
              valuesText(node, " ") + "</data></" + node.key + ">\n";
    }
  }
  return text + "</opencv_storage>\n";
}

std::string openCvJson(std::span<const OpenCvNode> nodes) {
  std::vector<std::string> parts;
  for (const OpenCvNode& node : nodes) {
    std::string part = "    \"" + node.key + "\": ";
    if (node.rows == 0) {
      part += numberText(node);
    } else {
      part += "{\n        \"type_id\": \"opencv-matrix\",\n        \"rows\": " + std::to_string(node.rows) +
              ",\n        \"cols\": " + std::to_string(node.columns) +
              ",\n        \"dt\": \"d\",\n        \"data\": [" + valuesText(node, ", ") + "]\n    }";
    }
    parts.push_back(part);
  }
  return "{\n" + join(parts, ",\n") + "\n}\n";
}

}  // namespace alidade::detail
