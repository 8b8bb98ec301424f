// SPDX-License-Identifier: MIT
// Each file is of one format, whichever is asked first, and is read as what it is.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <filesystem>
#include <set>

#include "alidade/files/camera_source.h"
#include "alidade/files/formats/camera_document.h"
#include "alidade/files/formats/camera_format.h"
#include "alidade/files/text/atomic_file.h"
#include "files/formats/examples.h"
#include "support/source_tree.h"

namespace alidade {
namespace {

TEST(FormatDetection, KnowsEachExampleByOneFormatAlone) {
  int num_pairs = 0;
  std::set<std::string_view> seen;
  for (const FormatExample& example : formatExamples()) {
    const detail::CameraDocument document(example.text, "file");
    for (const CameraFormat* format : cameraFormats()) {
      EXPECT_EQ(format->recognises(document), format->id == example.format)
          << format->id << " of " << example.format << ", " << example.name;
      ++num_pairs;
    }
    seen.insert(example.format);
  }
  EXPECT_EQ(seen.size(), cameraFormats().size());
  EXPECT_EQ(num_pairs, static_cast<int>(formatExamples().size() * cameraFormats().size()));
}

TEST(FormatDetection, ReadsWhatEachExampleSays) {
  int num_cameras = 0;
  for (const FormatExample& example : formatExamples()) {
    SCOPED_TRACE(std::string(example.format) + ", " + example.name);
    const CameraSource source = parseCameras(example.text, "file");
    EXPECT_EQ(source.format, example.format);
    ASSERT_EQ(source.cameras.size(), example.cameras.size());
    for (std::size_t i = 0; i < source.cameras.size(); ++i) {
      const StatedCamera& camera = source.cameras[i];
      const ExampleCamera& expected = example.cameras[i];
      EXPECT_EQ(camera.name, expected.name);
      EXPECT_EQ(camera.camera.modelId(), expected.model);
      const bool has_size = cameraFormat(example.format).holds_size;
      EXPECT_EQ(camera.image_size, has_size ? std::optional(expected.size) : std::nullopt);
      EXPECT_THAT(std::vector<double>(camera.camera.parameters().begin(), camera.camera.parameters().end()),
                  testing::Pointwise(testing::DoubleEq(), expected.parameters));
      ++num_cameras;
    }
    std::vector<std::string> ids;
    for (const Remark& remark : source.cameras.front().remarks) {
      ids.push_back(remark.id);
      EXPECT_THAT(remark.message, testing::HasSubstr("file:"));
    }
    EXPECT_EQ(ids, example.remarks);
  }
  EXPECT_EQ(num_cameras, 57);
}

// docs/formats.md shows an example of each format of other tools.
TEST(FormatDetection, ReadsTheExamplesOfTheDocumentation) {
  int num_examples = 0;
  for (const auto& entry : std::filesystem::directory_iterator(sourcePath("docs/examples/formats"))) {
    const CameraSource source = parseCameras(readTextFile(entry.path().string(), 1U << 20U), "example");
    EXPECT_EQ(source.format, entry.path().stem().string());
    EXPECT_EQ(source.cameras.size(), 1u);
    ++num_examples;
  }
  EXPECT_EQ(num_examples, static_cast<int>(cameraFormats().size()) - 1);  // all but this program's own
}

}  // namespace
}  // namespace alidade
