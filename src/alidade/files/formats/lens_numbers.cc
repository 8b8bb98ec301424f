// SPDX-License-Identifier: MIT
#include "alidade/files/formats/lens_numbers.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>

#include <fmt/format.h>

#include "alidade/core/mapped.h"
#include "alidade/core/size_groups.h"
#include "alidade/core/text.h"

namespace alidade::detail {
namespace {

// Half a unit of the last digit: of "-1.250e-03"; 0 for "12".
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

// Aliases let a small text expand to a list of billions.
constexpr std::size_t kMaxNumbers = 1000;

void appendRow(const YamlNode& node, std::vector<StatedNumber>& numbers) {
  for (const YamlNode& item : node.items()) {
    if (numbers.size() == kMaxNumbers)
      throw node.error("more than " + std::to_string(kMaxNumbers) + " numbers",
                       "only the parameters of a lens");
    numbers.push_back(statedNumber(item));
  }
}

bool isZeroOrUnit(std::span<const StatedNumber> numbers) {
  bool is_unit = numbers.size() == 9 || numbers.size() == 16;
  const std::size_t stride = numbers.size() == 9 ? 4 : 5;  // index step along the diagonal
  for (std::size_t i = 0; i < numbers.size(); ++i)
    is_unit = is_unit && numbers[i].value == (i % stride == 0 ? 1 : 0);
  return is_unit || areZero(numbers);
}

// "cam.yaml:8: cam0.a, b (line 12) and 3 more": keys of a map, with the first one's line as the place.
std::string keysText(const YamlNode& map, const std::vector<std::string>& keys) {
  constexpr std::size_t kMaxNamed = 8;
  const int first_line = map.lineOfKey(keys.front());
  std::string text = map.whereKey(keys.front());
  const std::size_t num_named = std::min(keys.size(), kMaxNamed);
  for (std::size_t i = 1; i < num_named; ++i) {
    const int line = map.lineOfKey(keys[i]);
    text += ", " + keys[i];
    if (line > 0 && line != first_line) text += " (line " + std::to_string(line) + ")";
  }
  return text + (keys.size() > num_named ? " and " + std::to_string(keys.size() - num_named) + " more" : "");
}

}  // namespace

bool isSameStated(const StatedNumber& a, const StatedNumber& b) {
  // A double's own rounding, if all digits are printed or a number is computed from others.
  const double rounding = 1e-12 * std::max(std::abs(a.value), std::abs(b.value));
  return std::abs(a.value - b.value) <= a.half_unit + b.half_unit + rounding;
}

bool isSameStated(std::span<const StatedNumber> a, std::span<const StatedNumber> b) {
  return std::ranges::equal(a, b,
                            [](const StatedNumber& x, const StatedNumber& y) { return isSameStated(x, y); });
}

bool areZero(std::span<const StatedNumber> numbers) {
  return std::ranges::all_of(numbers, [](const StatedNumber& number) { return number.value == 0; });
}

bool saysNothing(const YamlNode& node) {
  if (node.isNull()) return true;
  try {
    if (node.isSequence() || node.isMap()) return isZeroOrUnit(statedNumbers(node));
    return statedNumber(node).value == 0;
  } catch (const Error&) {
    return false;  // no numbers, so it states something
  }
}

StatedNumber statedNumber(const YamlNode& node) {
  return {.value = node.number(), .half_unit = halfUnitOf(node.text())};
}

std::vector<StatedNumber> statedNumbers(const YamlNode& node) {
  std::vector<StatedNumber> numbers;
  if (node.isMap()) {
    // OpenCV 5 writes matrices of one dimension in its format for any number of dimensions.
    const bool has_sizes = node.has("sizes") && !node.has("rows");
    constexpr int kMostNumbers = 1'000'000;
    const YamlNode data = node.at("data");
    if (data.isSequence()) {
      appendRow(data, numbers);
    } else {
      numbers.push_back(statedNumber(data));  // a single value, in XML
    }
    std::vector<YamlNode> sizes = {node.at(has_sizes ? "sizes" : "rows")};
    if (!has_sizes) sizes.push_back(node.at("cols"));
    if (has_sizes && sizes.front().isSequence()) sizes = sizes.front().items();
    if (sizes.empty()) throw node.at("sizes").error("no number", "the length of each dimension");
    std::int64_t count = 1;
    std::string product;
    for (const YamlNode& size : sizes) {
      count *= std::clamp(size.integer(), -1, kMostNumbers);
      product += (product.empty() ? "" : " x ") + size.text();
      if (count < 0 || count > kMostNumbers) break;
    }
    if (count != static_cast<std::int64_t>(numbers.size())) {
      throw data.error(std::to_string(numbers.size()) + " numbers",
                       (has_sizes ? "the product of sizes, " : "rows times cols, ") + product);
    }
    return numbers;
  }
  const std::vector<YamlNode> items = node.items();
  if (items.empty() || !items.front().isSequence()) {
    appendRow(node, numbers);
  } else {
    for (const YamlNode& item : items) appendRow(item, numbers);
  }
  return numbers;
}

std::vector<StatedNumber> statedNumbers(const YamlNode& node, std::size_t count) {
  std::vector<StatedNumber> numbers = statedNumbers(node);
  if (numbers.size() != count)
    throw node.error(std::to_string(numbers.size()) + " numbers", std::to_string(count));
  return numbers;
}

namespace {

UnsupportedCamera skewError(const YamlNode& matrix, const StatedNumber& skew) {
  return UnsupportedCamera(matrix.error("skew " + exactText(skew.value),
                                        "0: skewed pixels are supported for fisheyes (cv::fisheye) only",
                                        "calibrate without skew"));
}

}  // namespace

std::vector<StatedNumber> readCameraMatrix(const YamlNode& node, StatedNumber* skew) {
  const std::vector<StatedNumber> K = statedNumbers(node, 9);
  if (areZero(K)) {
    throw UnsupportedCamera(
        node.error("a camera matrix of zeros, which a driver publishes while the camera is not calibrated",
                   "fx 0 cx, 0 fy cy, 0 0 1, row by row",
                   "calibrate the camera: alidade calibrate IMAGES --board SPEC -o camera.yaml"));
  }
  const bool has_zeros = K[3].value == 0 && K[6].value == 0 && K[7].value == 0;
  if (K[2].value == 0 && K[5].value == 0 && (K[6].value != 0 || K[7].value != 0)) {
    throw node.error("a camera matrix whose principal point is in the last row",
                     "fx 0 cx, 0 fy cy, 0 0 1, row by row", "transpose it");
  }
  if (!has_zeros || K[8].value != 1) {
    throw node.error("a matrix that is not a camera matrix", "fx 0 cx, 0 fy cy, 0 0 1, row by row",
                     "check whether this is another matrix of the file");
  }
  if (skew == nullptr && K[1].value != 0) throw skewError(node, K[1]);
  if (skew != nullptr) *skew = K[1];
  return {K[0], K[4], K[2], K[5]};
}

std::string_view takeSkew(const YamlNode& matrix, std::string_view model, const StatedNumber& skew,
                          std::vector<StatedNumber>& parameters) {
  if (skew.value == 0) return model;
  if (model != "kannala_brandt") throw skewError(matrix, skew);
  parameters.push_back({skew.value / parameters.front().value});
  return "kannala_brandt_skew";
}

namespace {

// By how many pixels an ordinary lens and a fisheye with the same four coefficients differ in the direction
// of the pinhole's first pixel; empty if one of them has no such pixel.
std::string differenceOfReadings(std::span<const StatedNumber> pinhole, std::span<const StatedNumber> four) {
  std::vector<double> fisheye = mapped(pinhole, &StatedNumber::value);
  for (const StatedNumber& coefficient : four) fisheye.push_back(coefficient.value);
  std::vector<double> ordinary = fisheye;
  ordinary.push_back(0);
  for (std::size_t i = 0; i < 2; ++i)
    if (parameterComplaint("pinhole", i, fisheye[i])) return "";
  const Eigen::Vector3d ray(-fisheye[2] / fisheye[0], -fisheye[3] / fisheye[1], 1);
  const Projection a = AnyCamera::make("radtan", ordinary).projectPoint(ray);
  const Projection b = AnyCamera::make("kannala_brandt", fisheye).projectPoint(ray);
  return a.ok() && b.ok()
             ? fmt::format("; they differ by {:.2g} px at the corner", (a.pixel - b.pixel).norm())
             : "";
}

}  // namespace

std::string_view openCvModel(const YamlNode& node, std::span<const StatedNumber> pinhole,
                             std::vector<StatedNumber>& coefficients, const std::string& stated) {
  const std::size_t count = coefficients.size();
  if (count == 4 && stated.empty()) {
    throw node.error(
        "4 distortion coefficients, which may be k1 k2 p1 p2 of an ordinary lens or k1 k2 k3 k4 of a "
        "fisheye" +
            differenceOfReadings(pinhole, coefficients),
        "a key that states which: 'fisheye_model: 1' or 'fisheye_model: 0'",
        "add --read-as radtan or --read-as kannala_brandt");
  }
  if (stated != "kannala_brandt") return modelOfCoefficients(node, coefficients);
  if (count == 4) return "kannala_brandt";
  throw node.error(std::to_string(count) + " distortion coefficients", "4 for a fisheye");
}

std::span<const std::string_view> openCvModels() {
  static constexpr std::array<std::string_view, 5> kModels = {"pinhole", "radtan", "rational", "thin_prism",
                                                              "tilted"};
  return kModels;
}

std::string_view modelOfCoefficients(const YamlNode& place, std::vector<StatedNumber>& coefficients) {
  const std::size_t count = coefficients.size();
  if (count == 14 && areZero(std::span(coefficients).subspan(12))) coefficients.resize(12);
  if (count == 4) coefficients.resize(5);
  for (const std::string_view model : openCvModels())
    if (alidade::parameterNames(model).size() == 4 + coefficients.size()) return model;
  throw place.error(std::to_string(count) + " distortion coefficients", "none, 4, 5, 8, 12 or 14");
}

std::vector<StatedNumber> numbersOf(const YamlNode& map, std::span<const std::string> keys) {
  return mapped(keys, [&](const std::string& key) { return statedNumber(map.at(key)); });
}

ImageSize readSize(const YamlNode& width, const YamlNode& height) {
  const auto side = [](const YamlNode& node) {
    // Some tools write 640. (with a point).
    const double pixels = node.number();
    constexpr double kMaxSide = 1e6;
    if (!(pixels >= 1) || pixels > kMaxSide || pixels != std::floor(pixels))
      throw node.error("'" + node.text() + "'", "a whole number of pixels, 1 to 1000000",
                       pixels == std::floor(pixels) ? "correct it" : "use the size of the image files");
    return static_cast<int>(pixels);
  };
  return {.width = side(width), .height = side(height)};
}

ImageSize readSize(const YamlNode& list) {
  const std::vector<YamlNode> items = list.items();
  if (items.size() != 2) throw list.error(std::to_string(items.size()) + " numbers", "width and height");
  return readSize(items[0], items[1]);
}

std::optional<ImageSize> sizeOfSides(std::initializer_list<YamlNode> maps, const std::string& width_key,
                                     const std::string& height_key, const std::optional<ImageSize>& given,
                                     std::vector<Remark>& remarks) {
  const auto find = [&maps](const std::string& key) {
    const auto map = std::ranges::find_if(maps, [&key](const YamlNode& node) { return node.has(key); });
    return map == maps.end() ? std::nullopt : map->find(key);
  };
  const auto width = find(width_key);
  const auto height = find(height_key);
  if (width && height) return readSize(*width, *height);
  if (!width && !height) return std::nullopt;
  const YamlNode& stated = width ? *width : *height;
  const std::string& stated_key = width ? width_key : height_key;
  const std::string& missing_key = width ? height_key : width_key;
  const int side = readSize(stated, stated).width;
  if (!given) {
    throw stated.error("'" + stated_key + "' without '" + missing_key + "'", "both sides of the image",
                       "add " + missing_key + ", or --image-size WIDTHxHEIGHT");
  }
  const std::string size = sizeText(*given);
  if (side != (width ? given->width : given->height)) {
    throw stated.error("'" + stated.text() + "' as '" + stated_key + "' but no '" + missing_key + "'",
                       size + " from --image-size", "correct one of them");
  }
  remarks.push_back({"assumed", stated.where() + ": there is no " + missing_key + "; assumed to be " + size +
                                    " from --image-size"});
  return given;
}

const LensLayout* findLayout(std::span<const LensLayout> layouts, std::string_view name) {
  const auto found = std::ranges::find(layouts, name, &LensLayout::name);
  return found == layouts.end() ? nullptr : &*found;
}

std::vector<std::string> layoutNames(std::span<const LensLayout> layouts) {
  return mapped(layouts, [](const LensLayout& layout) { return std::string(layout.name); });
}

LensLayout layoutNamed(std::span<const LensLayout> layouts, const YamlNode& name, const std::string& advice) {
  if (const LensLayout* layout = findLayout(layouts, name.text())) return *layout;
  const std::vector<std::string> names = layoutNames(layouts);
  throw UnsupportedCamera(
      name.error("'" + name.text() + "'", join(names, ", "), didYouMean(name.text(), names, advice)));
}

const LensLayout& layoutOf(std::span<const LensLayout> layouts, std::string_view model) {
  const auto& found = *std::ranges::max_element(layouts, {}, [model](const LensLayout& layout) {
    return layout.model == model ? layout.order.size() : 0;
  });
  expect(found.model == model, "the format has a layout for each of its models");
  return found;
}

std::vector<StatedNumber> storageOrder(const LensLayout& layout, std::span<const StatedNumber> listed) {
  const auto names = split(layout.order, ' ');
  std::vector<StatedNumber> parameters;
  for (const std::string_view name : parameterNames(layout.model)) {
    const auto found = std::find_if(names.begin(), names.end(), [name](std::string_view listed_name) {
      return listed_name == name || (listed_name == "f" && (name == "fx" || name == "fy"));
    });
    parameters.push_back(found == names.end() ? StatedNumber{}
                                              : listed[static_cast<std::size_t>(found - names.begin())]);
  }
  return parameters;
}

std::vector<double> listedOrder(const LensLayout& layout, const AnyCamera& camera, double origin) {
  std::vector<double> listed;
  for (const std::string_view name : split(layout.order, ' ')) {
    listed.push_back(camera.parameter(name));
    if (name == "cx" || name == "cy") listed.back() += origin;
  }
  return listed;
}

void takeOrigin(std::span<StatedNumber> parameters, double origin) {
  parameters[2].value -= origin;
  parameters[3].value -= origin;
}

StatedCamera stateCamera(const std::string& place, std::string_view model,
                         std::span<const StatedNumber> parameters, std::optional<ImageSize> image_size,
                         std::vector<Remark> remarks) {
  std::vector<double> values = mapped(parameters, &StatedNumber::value);
  if (model == "inverse_brown" && !areZero(parameters.subspan(4))) {
    remarks.push_back(
        {"assumed", place + ": Inverse Brown Conrady is taken as the formula from pixels to rays, as in "
                            "older versions of librealsense; current ones iterate the modified formula"});
  }
  return {.camera = withPlace(place, [&] { return AnyCamera::make(model, values); }),
          .image_size = image_size,
          .remarks = std::move(remarks)};
}

void append(std::vector<StatedNumber>& numbers, std::span<const StatedNumber> more) {
  numbers.insert(numbers.end(), more.begin(), more.end());
}

std::string realText(double value) {
  std::string text = exactText(value);
  const std::size_t exponent = text.find('e');
  if (text.find('.') == std::string::npos)
    text.insert(exponent == std::string::npos ? text.size() : exponent, ".0");
  return text;
}

std::string listText(std::span<const double> values) {
  return "[" + join(mapped(values, realText), ", ") + "]";
}

std::string yamlText(const std::string& text) {
  YAML::Emitter out;
  out << text;
  return out.c_str();
}

void remarkUnknownKeys(const YamlNode& map, const std::vector<std::string>& known, StatedCamera& camera) {
  std::vector<std::string> unknown;
  for (const std::string& key : map.keys()) {
    if (!isCommentKey(key) && std::find(known.begin(), known.end(), key) == known.end())
      unknown.push_back(key);
  }
  if (unknown.empty()) return;
  camera.remarks.push_back(
      {"unknown_keys", keysText(map, unknown) + (unknown.size() == 1 ? " is unknown and was ignored"
                                                                     : " are unknown and were ignored")});
}

void remarkNotCarried(const YamlNode& map, const std::vector<std::string>& keys, StatedCamera& camera) {
  std::vector<std::string> dropped;
  for (const std::string& key : keys) {
    const auto node = map.find(key);
    if (node && !saysNothing(*node)) dropped.push_back(key);
  }
  if (dropped.empty()) return;
  camera.remarks.push_back(
      {"not_carried", keysText(map, dropped) + (dropped.size() == 1 ? " is" : " are") +
                          " ignored: only lenses, image sizes and where cameras are to each other are read"});
}

}  // namespace alidade::detail
