// SPDX-License-Identifier: MIT
#include "alidade/io/formats/lens_numbers.h"

#include <algorithm>
#include <cmath>
#include <cstdint>

#include "alidade/core/text.h"

namespace alidade::detail {
namespace {

// Half a unit of the last digit of "-1.250e-03", 0 for "12".
double halfUnitOf(std::string_view text) {
  const std::size_t e = text.find_first_of("eE");
  const std::string_view mantissa = text.substr(0, e);
  const std::size_t point = mantissa.find('.');
  if (point == std::string_view::npos && e == std::string_view::npos) return 0;
  const auto num_decimals =
      point == std::string_view::npos ? 0 : static_cast<int>(mantissa.size() - point - 1);
  const int exponent = e == std::string_view::npos ? 0 : parseInt(text.substr(e + 1)).value_or(0);
  return 0.5 * std::pow(10.0, exponent - num_decimals);
}

void appendRow(const YamlNode& node, std::vector<StatedNumber>& numbers) {
  for (const YamlNode& item : node.items()) numbers.push_back(statedNumber(item));
}

}  // namespace

std::optional<StatedNumber> parseStated(std::string_view text) {
  const auto value = parseDouble(text);
  if (!value || !std::isfinite(*value)) return std::nullopt;
  return StatedNumber{.value = *value, .half_unit = halfUnitOf(text)};
}

StatedNumber statedNumber(const YamlNode& node) {
  return {.value = node.number(), .half_unit = halfUnitOf(node.text())};
}

std::vector<StatedNumber> statedNumbers(const YamlNode& node) {
  std::vector<StatedNumber> numbers;
  if (node.isMap()) {
    appendRow(node.at("data"), numbers);
    const int rows = node.at("rows").integer();
    const int columns = node.at("cols").integer();
    if (rows < 0 || columns < 0 ||
        std::int64_t{rows} * columns != static_cast<std::int64_t>(numbers.size())) {
      throw node.at("data").error(
          std::to_string(numbers.size()) + " numbers",
          "rows times cols, " + std::to_string(rows) + " x " + std::to_string(columns));
    }
    return numbers;
  }
  for (const YamlNode& item : node.items()) {
    if (item.isSequence()) {
      appendRow(item, numbers);
    } else {
      numbers.push_back(statedNumber(item));
    }
  }
  return numbers;
}

std::vector<StatedNumber> statedNumbers(const YamlNode& node, std::size_t count) {
  std::vector<StatedNumber> numbers = statedNumbers(node);
  if (numbers.size() != count)
    throw node.error(std::to_string(numbers.size()) + " numbers", std::to_string(count));
  return numbers;
}

std::vector<StatedNumber> readCameraMatrix(const YamlNode& node) {
  const std::vector<StatedNumber> K = statedNumbers(node, 9);
  const bool has_zeros = K[3].value == 0 && K[6].value == 0 && K[7].value == 0;
  if (K[2].value == 0 && K[5].value == 0 && (K[6].value != 0 || K[7].value != 0)) {
    throw node.error("a camera matrix whose principal point is in the last row",
                     "fx 0 cx, 0 fy cy, 0 0 1, row by row", "transpose it");
  }
  if (!has_zeros || K[8].value != 1) {
    throw node.error("a matrix that is no camera matrix", "fx 0 cx, 0 fy cy, 0 0 1, row by row");
  }
  if (K[1].value != 0) {
    throw node.error("skew " + exactText(K[1].value), "0: cameras with skewed pixels are not supported");
  }
  return {K[0], K[4], K[2], K[5]};
}

ImageSize readSize(const YamlNode& width, const YamlNode& height) {
  const auto side = [](const YamlNode& node) {
    // Some tools write 640.
    const double pixels = node.number();
    constexpr double kMaxSide = 1e6;
    if (!(pixels >= 1) || pixels > kMaxSide || pixels != std::floor(pixels))
      throw node.error("'" + node.text() + "'", "1 to 1000000 pixels");
    return static_cast<int>(pixels);
  };
  return {.width = side(width), .height = side(height)};
}

ImageSize readSize(const YamlNode& list) {
  const std::vector<YamlNode> items = list.items();
  if (items.size() != 2) throw list.error(std::to_string(items.size()) + " numbers", "width and height");
  return readSize(items[0], items[1]);
}

StatedCamera stateCamera(const YamlNode& place, std::string name, std::string_view model,
                         std::span<const StatedNumber> parameters, std::optional<ImageSize> image_size) {
  std::vector<double> values;
  std::vector<double> half_units;
  for (const StatedNumber& number : parameters) {
    values.push_back(number.value);
    half_units.push_back(number.half_unit);
  }
  const auto make = [&] {
    try {
      return AnyCamera::make(model, values);
    } catch (const Error& e) {
      throw inputError({.where = place.where(), .found = e.what(), .expected = "", .next_step = ""});
    }
  };
  return {.name = std::move(name),
          .camera = make(),
          .image_size = image_size,
          .half_units = std::move(half_units),
          .remarks = {},
          .own = {}};
}

void append(std::vector<StatedNumber>& numbers, std::span<const StatedNumber> more) {
  numbers.insert(numbers.end(), more.begin(), more.end());
}

void remarkUnknownKeys(const YamlNode& map, const std::vector<std::string>& known, StatedCamera& camera) {
  std::vector<std::string> unknown;
  for (const std::string& key : map.keys()) {
    if (std::find(known.begin(), known.end(), key) == known.end()) unknown.push_back(key);
  }
  if (unknown.empty()) return;
  constexpr std::size_t kMaxNamed = 8;
  const std::size_t num_more = unknown.size() - std::min(unknown.size(), kMaxNamed);
  unknown.resize(unknown.size() - num_more);
  camera.remarks.push_back(
      {"unknown_keys", map.where() + ": " + join(unknown, ", ") +
                           (num_more > 0 ? " and " + std::to_string(num_more) + " more" : "") +
                           " mean nothing to this program and were not used"});
}

}  // namespace alidade::detail
