// SPDX-License-Identifier: MIT
// TOML, INI, XML, JSON lines, .mat and cameras.bin: what they mean, and what hostile ones do.
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <zlib.h>

#include <cstring>
#include <limits>

#include "alidade/files/camera_source.h"
#include "alidade/files/formats/camera_document.h"
#include "alidade/files/formats/notations.h"
#include "alidade/files/text/yaml_node.h"
#include "files/formats/reading.h"

namespace alidade {
namespace {

using testing::HasSubstr;

template <class T>
std::string bytesOf(T value) {
  std::string bytes(sizeof(T), '\0');
  std::memcpy(bytes.data(), &value, sizeof(T));
  return bytes;
}

std::string element(std::uint32_t type, std::string data) {
  std::string bytes = bytesOf(type) + bytesOf(static_cast<std::uint32_t>(data.size())) + data;
  return bytes + std::string((8 - bytes.size() % 8) % 8, '\0');
}

// An array of class 6 (double), from a list of columns.
std::string matrix(const std::string& name, std::int32_t rows, std::int32_t columns,
                   const std::vector<double>& values) {
  std::string data;
  for (const double value : values) data += bytesOf(value);
  return element(14, element(6, bytesOf<std::uint32_t>(6) + bytesOf<std::uint32_t>(0)) +
                         element(5, bytesOf(rows) + bytesOf(columns)) + element(1, name) + element(9, data));
}

std::string structOf(const std::string& name,
                     const std::vector<std::pair<std::string, std::string>>& fields) {
  std::string names;
  std::string values;
  for (const auto& [key, value] : fields) {
    std::string padded = key;
    padded.resize(32, '\0');
    names += padded;
    values += value;
  }
  return element(14, element(6, bytesOf<std::uint32_t>(2) + bytesOf<std::uint32_t>(0)) +
                         element(5, bytesOf<std::int32_t>(1) + bytesOf<std::int32_t>(1)) + element(1, name) +
                         bytesOf<std::uint32_t>(5 | (4U << 16U)) + bytesOf<std::int32_t>(32) +
                         element(1, names) + values);
}

// Structs of one field each, in a 1xN array.
std::string structArray(const std::string& name, const std::vector<std::string>& values) {
  std::string field = "a";
  field.resize(32, '\0');
  std::string elements;
  for (const std::string& value : values) elements += value;
  return element(
      14, element(6, bytesOf<std::uint32_t>(2) + bytesOf<std::uint32_t>(0)) +
              element(5, bytesOf<std::int32_t>(1) + bytesOf(static_cast<std::int32_t>(values.size()))) +
              element(1, name) + bytesOf<std::uint32_t>(5 | (4U << 16U)) + bytesOf<std::int32_t>(32) +
              element(1, field) + elements);
}

std::string matFile(const std::string& elements) {
  std::string head = "MATLAB 5.0 MAT-file";
  head.resize(124, ' ');
  return head + std::string("\x00\x01", 2) + "IM" + elements;
}

std::string compressed(const std::string& data) {
  uLongf size = compressBound(data.size());
  std::string out(size, '\0');
  compress(reinterpret_cast<Bytef*>(out.data()), &size, reinterpret_cast<const Bytef*>(data.data()),
           data.size());
  out.resize(size);
  return bytesOf<std::uint32_t>(15) + bytesOf(static_cast<std::uint32_t>(size)) + out;
}

std::string matlabStruct() {
  return structOf("params", {{"IntrinsicMatrix", matrix("", 3, 3, {500, 0, 321, 0, 501, 241, 0, 0, 1})},
                             {"ImageSize", matrix("", 1, 2, {480, 640})},
                             {"RadialDistortion", matrix("", 1, 2, {-0.1, 0.02})},
                             {"TangentialDistortion", matrix("", 1, 2, {0.001, 0.002})},
                             {"WorldPoints", matrix("", 600, 2, std::vector<double>(1200, 1.0))}});
}

// toStruct(cameraParams) in a .mat file: columns first, so the transposed K has its centre in the last row.
TEST(Notations, OfMatlabAreReadAsItsJson) {
  for (const std::string& elements : {matlabStruct(), compressed(matlabStruct())}) {
    const CameraSource source = parseCameras(matFile(elements), "camera.mat");
    EXPECT_EQ(source.format, "matlab");
    ASSERT_EQ(source.cameras.size(), 1U);
    EXPECT_EQ(source.cameras[0].image_size, std::optional(ImageSize{640, 480}));
    EXPECT_THAT(source.cameras[0].camera.parameters(),
                testing::ElementsAre(500, 501, 320, 240, -0.1, 0.02, 0.001, 0.002, 0));
  }
  // Variables as SciPy writes them are those of OpenCV.
  const CameraSource opencv =
      parseCameras(matFile(matrix("cameraMatrix", 3, 3, {500, 0, 0, 0, 501, 0, 320, 240, 1}) +
                           matrix("distCoeffs", 1, 5, {-0.1, 0.02, 0.001, 0.002, 0.03})),
                   "camera.mat");
  EXPECT_EQ(opencv.format, "opencv");
  EXPECT_THAT(opencv.cameras.at(0).camera.parameters(),
              testing::ElementsAre(500, 501, 320, 240, -0.1, 0.02, 0.001, 0.002, 0.03));
}

// All of an array of structs, text of any width, and much that is equal.
TEST(Notations, OfMatlabAreReadWhole) {
  const auto rootOf = [](const std::string& elements) {
    return detail::CameraDocument(detail::binaryAsText(matFile(elements), "camera.mat"), "camera.mat").root();
  };
  const detail::YamlNode list =
      rootOf(matrix("x", 1, 1, {0}) +
             structArray("s", {matrix("", 1, 1, {1}), matrix("", 1, 1, {2}), matrix("", 1, 1, {3})}));
  ASSERT_EQ(list.at("s").items().size(), 3U);
  EXPECT_EQ(list.at("s").items()[2].at("a").number(), 3);
  // Of one variable, the array stands for the file: several cameras.
  std::string fields;
  for (const char* key : {"IntrinsicMatrix", "RadialDistortion"})
    fields += std::string(key).append(32 - std::strlen(key), '\0');
  std::string two;
  for (const double f : {500.0, 600.0})
    two += matrix("", 3, 3, {f, 0, 321, 0, f, 241, 0, 0, 1}) + matrix("", 1, 2, {-0.1, 0.02});
  const CameraSource cameras =
      parseCameras(matFile(element(14, element(6, bytesOf<std::uint32_t>(2) + bytesOf<std::uint32_t>(0)) +
                                           element(5, bytesOf<std::int32_t>(1) + bytesOf<std::int32_t>(2)) +
                                           element(1, "params") + bytesOf<std::uint32_t>(5 | (4U << 16U)) +
                                           bytesOf<std::int32_t>(32) + element(1, fields) + two)),
                   "camera.mat");
  EXPECT_EQ(cameras.format, "matlab");
  ASSERT_EQ(cameras.cameras.size(), 2U);
  EXPECT_EQ(cameras.cameras[1].camera.parameters()[0], 600);
  EXPECT_TRUE(rootOf(structArray("s", {}) + matrix("x", 1, 1, {1})).at("s").items().empty());
  for (const auto& [type, size] : {std::pair(17U, 2U), std::pair(18U, 4U)}) {
    std::string codes;
    for (const char c : std::string("frame")) codes += c + std::string(size - 1, '\0');
    EXPECT_EQ(rootOf(element(14, element(6, bytesOf<std::uint32_t>(4) + bytesOf<std::uint32_t>(0)) +
                                     element(5, bytesOf<std::int32_t>(1) + bytesOf<std::int32_t>(5)) +
                                     element(1, "t") + element(type, codes)))
                  .at("t")
                  .text(),
              "frame");
  }
  const std::string zeros = compressed(matrix("z", 1000, 500, std::vector<double>(500000, 0)));
  EXPECT_EQ(rootOf(compressed(matlabStruct()) + zeros).at("params").at("ImageSize").items().size(), 2U);
}

std::string colmapCamera(std::uint32_t id, std::uint32_t model, const std::vector<double>& parameters) {
  std::string bytes =
      bytesOf(id) + bytesOf(model) + bytesOf<std::uint64_t>(640) + bytesOf<std::uint64_t>(480);
  for (const double value : parameters) bytes += bytesOf(value);
  return bytes;
}

TEST(Notations, OfColmapsBinaryAreItsText) {
  const std::string two = bytesOf<std::uint64_t>(2) +
                          colmapCamera(7, 4, {500, 501, 320.5, 240.5, -0.1, 0.02, 0.001, 0.002}) +
                          colmapCamera(9, 0, {400, 320, 240});
  const CameraSource source = parseCameras(two, "cameras.bin");
  EXPECT_EQ(source.format, "colmap");
  ASSERT_EQ(source.cameras.size(), 2U);
  EXPECT_EQ(source.cameras[0].name, "7");
  EXPECT_THAT(source.cameras[0].camera.parameters(),
              testing::ElementsAre(500, 501, 320, 240, -0.1, 0.02, 0.001, 0.002, 0));
  EXPECT_EQ(source.cameras[1].camera.modelId(), "pinhole");
  EXPECT_THAT(complaintAbout(bytesOf<std::uint64_t>(1) + colmapCamera(1, 17, {0, 0})),
              HasSubstr("EQUIRECTANGULAR"));
}

// The values, and the line of a key, of each notation.
TEST(Notations, KeepValuesAndLines) {
  struct Case {
    std::string text;
    std::string key;
    std::string value;
    int line;
  };
  const std::vector<Case> cases = {{"# a\n[b]\nx = [1, 2.5]\n[a]\ny = \"two words\"\n", "y", "two words", 5},
                                   {"[a]\nfx=-.5\ny = 7\n; z\n", "y", "7", 3},
                                   {"<r>\n<a k='1'>\n<y>7 8</y>\n</a></r>\n", "y", "[7, 8]", 3},
                                   {"<r><a y='x y'/>\n</r>", "y", "x y", 1},
                                   {"{\"a\": {\"x\": 1}}\n\n{\"a\": {\"y\": 7}}\n", "y", "7", 3},
                                   {"a: 1\nP0: 1e0 2\n", "P0", "[1e0, 2]", 2},
                                   {"a: 1\ny: 1e0 2\n", "y", "1e0 2", 2}};
  int num_found = 0;
  for (const Case& c : cases) {
    const detail::CameraDocument document(c.text, "file");
    const std::function<void(const detail::YamlNode&)> search = [&](const detail::YamlNode& node) {
      if (node.isSequence()) {
        for (const detail::YamlNode& item : node.items()) search(item);
      } else if (node.isMap()) {
        for (const std::string& key : node.keys()) search(node.at(key));
        if (!node.has(c.key)) return;
        const auto values = node.at(c.key).texts();
        EXPECT_EQ(values.size() == 1 ? values[0] : "[" + values[0] + ", " + values[1] + "]", c.value)
            << c.text;
        EXPECT_EQ(node.lineOfKey(c.key), c.line) << c.text;
        ++num_found;
      }
    };
    search(document.root());
  }
  EXPECT_EQ(num_found, 7);
}

TEST(Notations, ThatAreDamagedOrHostileEndWithAPlace) {
  std::string deep_toml = "a";
  std::string deep_inline = "a = ";
  std::string deep_xml;
  for (int i = 0; i < 20000; ++i) deep_toml += ".a";
  for (int i = 0; i < 20000; ++i) deep_inline += "[{a=";
  for (int i = 0; i < 20000; ++i) deep_xml += "<a>";
  std::string deep_mat = matrix("", 1, 1, {1});
  for (int i = 0; i < 200; ++i) deep_mat = structOf("a", {{"a", deep_mat}});
  const std::string good = matFile(matlabStruct());
  const std::string bomb = compressed(std::string(40U << 20U, '\0'));
  std::string huge_count = bytesOf<std::uint64_t>(900'000) + colmapCamera(1, 1, {1, 1, 1, 1});
  const std::vector<std::pair<std::string, std::string>> cases = {
      {deep_toml + " = 1\n", "16 parts"},
      {"['" + std::string(50000, 'a') + "'." + deep_toml + "]\nx = 1\n", "16 parts"},
      {"x = ['''\nit's''', {" + deep_toml + " = 1}]\n", "16 parts"},
      {deep_inline, "TOML"},
      {deep_xml, "not valid XML"},
      {"<r>" + deep_xml + "</r>", "not valid XML"},
      {"[a]\nx = [1,\n", "TOML"},
      {"[a]\nx = 1\nx = 2\n", "file:3"},
      {"<calib><K a=\"1\"></calib>", "file:1: found text that is not valid XML"},
      {matFile(deep_mat), "byte"},
      {matFile(bomb), "damaged or larger"},
      {good.substr(0, 300), "byte"},
      {good.substr(0, 127), "byte"},
      {matFile(""), "toStruct"},
      {matFile(element(14, "")), "byte"},
      {matFile(std::string("\x0e\x00\x00\x00\xff\xff\xff\xff", 8)), "more bytes"},
      {"MATLAB 7.3 MAT-file" + std::string(109, ' '), "-v7"},
      {huge_count, "more bytes"},
      {bytesOf<std::uint64_t>(1) + colmapCamera(1, 1, {1, 1, 1}), "more bytes"},
      {bytesOf<std::uint64_t>(1) + colmapCamera(1, 1, {1, 1, 1, 1, 1}), "the end of 1 cameras"},
      {bytesOf<std::uint64_t>(1) + colmapCamera(1, 1, {std::numeric_limits<double>::quiet_NaN(), 1, 1, 1}),
       "nan"},
      {std::string("\x01\x00\x02", 3) + std::string(40, '\xff'), "a binary file"},
  };
  std::size_t num_refused = 0;
  for (const auto& [text, part] : cases) {
    std::string complaint;
    try {
      static_cast<void>(parseCameras(text, part == "16 parts" || part == "TOML" ? "file.toml" : "file"));
    } catch (const Error& error) {
      complaint = error.what();
    }
    EXPECT_THAT(complaint, testing::AllOf(HasSubstr("file"), HasSubstr(part))) << text.substr(0, 60);
    ++num_refused;
  }
  EXPECT_EQ(num_refused, 22U);
}

}  // namespace
}  // namespace alidade
