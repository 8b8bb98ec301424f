// SPDX-License-Identifier: MIT
#include <cstdlib>
#include <fstream>
#include <sstream>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "alidade/files/camera_source.h"
#include "alidade/files/formats/camera_format.h"
#include "alidade/files/text/atomic_file.h"
#include "files/formats/format_tables.h"
#include "support/grid_difference.h"
#include "support/source_tree.h"

namespace alidade {
namespace {

constexpr std::string_view kBegin = "<!-- tables: written by scripts/formats_doc -->\n";
constexpr std::string_view kEnd = "<!-- end of the tables -->";

// Every model through every format: docs/formats.md says what comes of it.
TEST(FormatRoundTrip, IsWhatTheDocumentationSays) {
  const std::string path = sourcePath("docs/formats.md");
  const std::string text = readTextFile(path, 1U << 20U);
  const std::size_t begin = text.find(kBegin);
  const std::size_t end = text.find(kEnd);
  ASSERT_NE(begin, std::string::npos);
  ASSERT_NE(end, std::string::npos);
  const std::size_t first = begin + kBegin.size();
  const std::string tables = formatTables();
  if (std::getenv("ALIDADE_WRITE_FORMATS_DOC") != nullptr)
    writeFileAtomically(path, text.substr(0, first) + tables + text.substr(end));
  EXPECT_EQ(readTextFile(path, 1U << 20U), text.substr(0, first) + tables + text.substr(end))
      << "scripts/formats_doc writes the tables anew";
}

TEST(FormatRoundTrip, IsExactFromEachFormatToEach) {
  EXPECT_EQ(countConversions(), 563);
}

// Formats that hold several cameras hold them in order, each with its own lens and size.
TEST(FormatRoundTrip, KeepsSeveralCameras) {
  const std::vector<NamedCamera> cameras = {
      {.name = "left",
       .camera = AnyCamera::make("pinhole", std::array{500.0, 501.0, 320.0, 240.0}),
       .image_size = {640, 480}},
      {.name = "right",
       .camera = AnyCamera::make("kannala_brandt",
                                 std::array{300.0, 301.0, 376.0, 240.0, -0.01, 0.02, -0.03, 0.004}),
       .image_size = {752, 480}}};
  int num_formats = 0;
  for (const CameraFormat* format : cameraFormats()) {
    // One of OpenCV's has one kind of lens, and one of Alidade's has poses; see rig_formats_test.cc.
    if (format->max_cameras < CameraFormat::kAnyNumber || format->id == "alidade" || !format->write) continue;
    const CameraSource source = parseCameras(formatText(*format, cameras), "file");
    ASSERT_EQ(source.cameras.size(), 2u) << format->id;
    for (std::size_t i = 0; i < 2; ++i) {
      if (format->holds_size) {
        EXPECT_EQ(source.cameras[i].image_size, std::optional(cameras[i].image_size));
      }
      const GridDifference difference =
          gridDifference(cameras[i].camera, source.cameras[i].camera, cameras[i].image_size);
      EXPECT_LT(difference.worst_px, 1e-9) << format->id;
      EXPECT_GT(difference.num_points, 1000) << format->id;
    }
    ++num_formats;
  }
  EXPECT_EQ(num_formats, 4);
}

// What a format has no place for is named.
TEST(FormatRoundTrip, SaysWhatHasNoPlace) {
  const auto refusal = [](std::string_view format, std::string_view model,
                          std::vector<double> parameters) -> std::string {
    const std::vector<NamedCamera> cameras = {{.name = "",
                                               .camera = AnyCamera::make(model, parameters),
                                               .image_size = {640, 480},
                                               .where = "cam.yaml"}};
    try {
      return formatText(cameraFormat(format), cameras);
    } catch (const Error& error) {
      return error.what();
    }
  };
  using testing::AllOf;
  using testing::HasSubstr;
  EXPECT_THAT(
      refusal("kalibr", "radtan", {500, 500, 320, 240, -0.1, 0.02, 0, 0, 0.01}),
      AllOf(HasSubstr("cam.yaml"), HasSubstr("k3 = 0.01"), HasSubstr("Kalibr"), HasSubstr("--model")));
  EXPECT_THAT(refusal("colmap", "radtan", {500, 500, 320, 240, -0.1, 0.02, 0, 0, 0.01}),
              HasSubstr("FULL_OPENCV"));
  EXPECT_THAT(refusal("camodocal", "pinhole", {500, 500, 320, 240}), HasSubstr("PINHOLE"));
  EXPECT_THAT(refusal("mrcal", "fov", {300, 300, 320, 240, 0.9}),
              AllOf(HasSubstr("a fov camera"), HasSubstr("pinhole, radtan, rational, thin_prism")));
}

}  // namespace
}  // namespace alidade
