// SPDX-License-Identifier: MIT
#include <zlib.h>

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <utility>
#include <vector>

#include "alidade/core/text.h"
#include "alidade/files/formats/lens_numbers.h"
#include "alidade/files/formats/notations.h"
#include "alidade/files/text/file_text.h"

static_assert(std::endian::native == std::endian::little, "numbers of files are copied as they are");

namespace alidade::detail {
namespace {

constexpr std::size_t kMaxBytes = 16U << 20U;  // of the numbers of a .mat file, uncompressed
constexpr std::size_t kMaxText = 4U << 20U;
constexpr std::size_t kMaxNumbers = 1000;  // of a matrix; larger ones are not those of a camera
constexpr std::string_view kMatlab5 = "MATLAB 5.0 MAT-file";
constexpr std::string_view kMatlab7 = "MATLAB 7.3 MAT-file";

// Bytes read in order, each value checked against the end.
class Bytes {
 public:
  Bytes(std::string_view bytes, const std::string& file) : bytes_(bytes), file_(file) {}

  [[nodiscard]] bool isAtEnd() const { return at_ >= bytes_.size(); }
  template <class T>
  T read() {
    T value;
    std::memcpy(&value, take(sizeof(T)).data(), sizeof(T));
    return value;
  }
  std::string_view take(std::uint64_t count) {
    if (count > bytes_.size() - at_)
      throw error("the end of the file", std::to_string(count) + " more bytes");
    at_ += count;
    return bytes_.substr(at_ - count, count);
  }
  void alignTo(std::size_t step) { at_ = std::min((at_ + step - 1) / step * step, bytes_.size()); }
  [[nodiscard]] Bytes part(std::string_view bytes) const { return {bytes, file_}; }
  [[nodiscard]] Error error(const std::string& found, const std::string& expected,
                            const std::string& next_step = "copy or export the file again") const {
    return errorAt(file_ + ": byte " + std::to_string(at_), "found " + found, expected, next_step);
  }

 private:
  std::string_view bytes_;
  std::string file_;
  std::size_t at_ = 0;
};

// True if the bytes begin as a cameras.bin: a number of cameras, and a camera with a known model and size.
bool startsAsColmap(std::string_view bytes) {
  constexpr std::uint64_t kMost = 1'000'000;
  Bytes head(bytes, "");
  constexpr std::size_t kHeadSize = 32;
  if (bytes.size() < kHeadSize) return false;
  const auto count = head.read<std::uint64_t>();
  head.take(sizeof(std::uint32_t));
  const auto model = head.read<std::uint32_t>();
  const auto width = head.read<std::uint64_t>();
  return count > 0 && count <= kMost && model < colmapLenses().size() && width > 0 && width <= kMost;
}

std::string colmapAsText(Bytes bytes) {
  std::string text;
  const auto count = bytes.read<std::uint64_t>();
  for (std::uint64_t i = 0; i < count; ++i) {
    const auto id = bytes.read<std::uint32_t>();
    const auto model = bytes.read<std::uint32_t>();
    if (model >= colmapLenses().size()) throw bytes.error("camera model " + std::to_string(model), "0 to 17");
    const LensLayout& lens = colmapLenses()[model];
    text += std::to_string(id) + " " + std::string(lens.name);
    text += " " + std::to_string(bytes.read<std::uint64_t>());
    text += " " + std::to_string(bytes.read<std::uint64_t>());
    for (std::size_t k = 0; k < words(lens.order).size(); ++k) text += " " + exactText(bytes.read<double>());
    text += '\n';
  }
  if (!bytes.isAtEnd()) throw bytes.error("more bytes", "the end of " + std::to_string(count) + " cameras");
  return text;
}

// Types of data elements that are not numbers, and classes of arrays.
constexpr std::uint32_t kMatrix = 14;
constexpr std::uint32_t kCompressed = 15;
enum ArrayClass : std::uint32_t {
  kCell = 1,
  kStruct,
  kObject,
  kChar,
  kSparse,
  kFirstNumeric,
  kLastNumeric = 15
};

struct Element {
  std::uint32_t type;
  std::string_view data;
};

// A tag and its data. Up to four bytes of data may stand within the tag.
Element nextElement(Bytes& bytes) {
  const auto word = bytes.read<std::uint32_t>();
  constexpr std::uint32_t kHalf = 16;
  if (const std::uint32_t size = word >> kHalf; size != 0) {
    const std::string_view data = bytes.take(4);
    if (size > data.size()) throw bytes.error("a small element of " + std::to_string(size) + " bytes", "4");
    return {word & 0xFFFFU, data.substr(0, size)};
  }
  const auto size = bytes.read<std::uint32_t>();
  const Element element = {word, bytes.take(size)};
  if (word != kCompressed) bytes.alignTo(8);
  return element;
}

template <class T>
std::vector<double> numbersOf(std::string_view data) {
  std::vector<double> numbers;
  for (std::size_t at = 0; at + sizeof(T) <= data.size() && numbers.size() <= kMaxNumbers; at += sizeof(T)) {
    T value;
    std::memcpy(&value, data.data() + at, sizeof(T));
    numbers.push_back(static_cast<double>(value));
  }
  return numbers;
}

using Reader = std::vector<double> (*)(std::string_view);
template <class T>
constexpr Reader kReader = numbersOf<T>;
template <>
constexpr Reader kReader<void> = nullptr;
template <class... T>
constexpr std::array<Reader, sizeof...(T)> kReadersOf = {kReader<T>...};

// By types of data elements; the last three are characters of UTF-8, UTF-16 and UTF-32.
std::vector<double> numbersOf(const Element& element, const Bytes& bytes) {
  constexpr auto& kReaders =
      kReadersOf<void, std::int8_t, std::uint8_t, std::int16_t, std::uint16_t, std::int32_t, std::uint32_t,
                 float, void, double, void, void, std::int64_t, std::uint64_t, void, void, std::uint8_t,
                 std::uint16_t, std::uint32_t>;
  if (element.type >= kReaders.size() || kReaders[element.type] == nullptr)
    throw bytes.error("data of type " + std::to_string(element.type), "numbers");
  return kReaders[element.type](element.data);
}

std::string writeArray(const Element& element, const Bytes& file, std::string& out, int depth);

void requireFewNumbers(const Bytes& bytes, const std::string& out) {
  if (out.size() > kMaxText) throw bytes.error("more than 4 MB of numbers", "those of cameras");
}

std::string textOf(const Element& element, const Bytes& bytes) {
  std::string text;
  for (const double code : numbersOf(element, bytes))
    text += code >= ' ' && code < 0x7F ? static_cast<char>(code) : '?';
  return text;
}

// A struct, or a list of those of an array.
void writeStruct(Bytes& bytes, double count, std::string& out, int depth) {
  const std::vector<double> length = numbersOf(nextElement(bytes), bytes);
  const Element names = nextElement(bytes);
  const auto step =
      length.empty() || length[0] < 1 ? names.data.size() + 1 : static_cast<std::size_t>(length[0]);
  out += count == 1 ? "" : "[";
  for (double i = 0; i < count; ++i) {
    out += '{';
    for (std::size_t at = 0; at + step <= names.data.size(); at += step) {
      const std::string_view name = names.data.substr(at, step);
      out += quotedYaml(name.substr(0, name.find('\0'))) + ": ";
      writeArray(nextElement(bytes), bytes, out, depth + 1);
      out += ", ";
    }
    out += count == 1 ? "}" : "},\n";
    requireFewNumbers(bytes, out);
  }
  out += count == 1 ? "" : "]";
}

// MATLAB stores columns one after the other.
void writeMatrix(const std::vector<double>& numbers, double rows, double columns, std::string& out) {
  if (numbers.size() > kMaxNumbers || rows * columns != static_cast<double>(numbers.size())) {
    out += "null";
    return;
  }
  const bool is_list = rows == 1 || columns == 1;
  const std::size_t step = is_list ? 1 : static_cast<std::size_t>(rows);
  out += numbers.size() == 1 ? "" : "[";
  for (std::size_t i = 0; i < step && !numbers.empty(); ++i) {
    out += is_list ? "" : "[";
    for (std::size_t at = i; at < numbers.size(); at += step)
      out += (at > i ? ", " : "") + (std::isfinite(numbers[at]) ? exactText(numbers[at]) : ".nan");
    out += is_list ? "" : "], ";
  }
  out += numbers.size() == 1 ? "" : "]";
}

// The name of an array, whose value is appended to `out`.
std::string writeArray(const Element& element, const Bytes& file, std::string& out, int depth) {
  Bytes bytes = file.part(element.data);
  if (element.type != kMatrix || depth > kMaxDepth)
    throw bytes.error("data of type " + std::to_string(element.type), "an array, nested a few levels deep");
  const std::vector<double> flags = numbersOf(nextElement(bytes), bytes);
  const auto array_class = flags.empty() ? 0U : static_cast<std::uint32_t>(flags[0]) & 0xFFU;
  const bool is_plain = array_class >= kCell && array_class <= kLastNumeric;
  if (!is_plain) {  // a handle to an object, which only MATLAB itself can read
    out += "null";
    return "";
  }
  const std::vector<double> sizes = numbersOf(nextElement(bytes), bytes);
  const std::string name(nextElement(bytes).data);
  if (array_class == kStruct || array_class == kObject) {
    if (array_class == kObject) nextElement(bytes);  // the name of its class
    double count = 1;
    for (const double size : sizes) count *= size;
    writeStruct(bytes, count, out, depth);
  } else if (array_class == kChar) {
    out += quotedYaml(textOf(nextElement(bytes), bytes));
  } else if (array_class >= kFirstNumeric && sizes.size() == 2) {
    writeMatrix(numbersOf(nextElement(bytes), bytes), sizes[0], sizes[1], out);
  } else {
    out += "null";
  }
  requireFewNumbers(bytes, out);
  return name;
}

std::string inflated(std::string_view data, const Bytes& bytes) {
  z_stream stream = {};
  if (inflateInit(&stream) != Z_OK) throw bytes.error("data that cannot be decompressed", "zlib data");
  stream.next_in = reinterpret_cast<Bytef*>(const_cast<char*>(data.data()));
  stream.avail_in = static_cast<uInt>(data.size());
  std::string out;
  int status = Z_OK;
  while (status == Z_OK && out.size() < kMaxBytes) {
    const std::size_t size = out.size();
    out.resize(std::max<std::size_t>(2 * size, 1U << 16U));
    stream.next_out = reinterpret_cast<Bytef*>(out.data() + size);
    stream.avail_out = static_cast<uInt>(out.size() - size);
    status = inflate(&stream, Z_NO_FLUSH);
    out.resize(out.size() - stream.avail_out);
    if (status == Z_OK && stream.avail_out > 0) break;  // the data ends early
  }
  inflateEnd(&stream);
  if (status != Z_STREAM_END)
    throw bytes.error("compressed data that is damaged or larger than 16 MB", "zlib data");
  return out;
}

std::string matAsYaml(Bytes bytes) {
  constexpr std::size_t kHeaderSize = 128;
  const std::string_view header = bytes.take(kHeaderSize);
  if (header.starts_with(kMatlab7)) {
    throw bytes.error("a .mat file of version 7.3 (HDF5)", "version 5 or 7",
                      "in MATLAB: save('camera.mat', 'params', '-v7'), with params = toStruct(cameraParams)");
  }
  if (!header.ends_with("IM"))
    throw bytes.error("a .mat file of a big-endian machine", "a little-endian one");
  std::string out = "{";
  std::string last;
  int num_variables = 0;
  std::size_t total = 0;
  while (!bytes.isAtEnd()) {
    Element element = nextElement(bytes);
    std::string data;
    if (element.type == kCompressed) {
      data = inflated(element.data, bytes);
      Bytes inner = bytes.part(data);
      element = nextElement(inner);
    }
    total += data.size();
    if (total > kMaxBytes) throw bytes.error("more than 16 MB of numbers", "those of cameras");
    std::string value;
    const std::string name = writeArray(element, bytes, value, 0);
    if (name.empty()) continue;  // an object, or what belongs to objects
    out += quotedYaml(name) + ": " + value + ",\n";
    last = std::move(value);
    requireFewNumbers(bytes, out);
    ++num_variables;
  }
  if (num_variables == 0) {
    throw bytes.error("a .mat file without structs and numbers; objects are readable in MATLAB only",
                      "a struct", "in MATLAB: params = toStruct(cameraParams); save('camera.mat', 'params')");
  }
  const bool is_struct = num_variables == 1 && (last.starts_with('{') || last.starts_with("[{"));
  return is_struct ? last : out + "}";
}

}  // namespace

bool isCameraBinary(std::string_view bytes) {
  return bytes.starts_with(kMatlab5) || bytes.starts_with(kMatlab7) || startsAsColmap(bytes);
}

std::string binaryAsText(std::string_view bytes, const std::string& file) {
  const Bytes all(bytes, file);
  return bytes.starts_with("MATLAB") ? matAsYaml(all) : colmapAsText(all);
}

}  // namespace alidade::detail
