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
#include "files/formats/reading.h"
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

TEST(FormatDetection, NamesFilesOfOtherPrograms) {
  const std::vector<std::pair<std::string, std::string>> cases = {
      {"Calibration results \n====\nCamera-system parameters:\n\tcam0 (/image_raw):\n\t type: <class 'a'>\n",
       "Kalibr's report (results-cam.txt)"},
      {"[LEFT_CAM_2K]\r\nfx=1398.03\r\nfy=1398.03\r\n\r\n[STEREO]\r\nBaseline=62.8\r\n",
       "the settings of a ZED camera"},
      {"[cameras.0]\ncam_id = 0\nsize = [1280, 720]\nmatrix = [[700.0, 0.0, 630.0]]\ndistortions = [0.1, 0.0]\n",
       "TOML"},
      {"[cam_0]\nname = \"a\"\nsize = [ 640, 480 ]\ndistortions = [ 0.1, 0.0 ]\n", "TOML"},
      {"Dimensions = 6016 4016\nModel = CAHV = perspective, linear\nC = 0 0 0\nA = 0 0 1\n", "CAHV"},
      {"Model = CAHVOR = perspective, distortion\nC = 0 0 0\n", "CAHV"}};
  std::size_t num_named = 0;
  for (const auto& [text, name] : cases) {
    EXPECT_THAT(complaintAbout(text), testing::AllOf(testing::HasSubstr("file: found "),
                                                     testing::HasSubstr(name), testing::HasSubstr("next: ")));
    ++num_named;
  }
  EXPECT_EQ(num_named, 6U);
  EXPECT_THAT(complaintAbout("Dimensions = 6016 4016\n"), testing::HasSubstr("not a camera file"));
}

}  // namespace
}  // namespace alidade
