// SPDX-License-Identifier: MIT
// Each file is of one format, whichever is asked first, and is read as what it is.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <filesystem>
#include <set>

#include "alidade/files/camera_source.h"
#include "alidade/files/formats/camera_document.h"
#include "alidade/files/formats/camera_format.h"
#include "alidade/files/formats/notations.h"
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
    const detail::CameraDocument document(
        detail::isCameraBinary(example.text) ? detail::binaryAsText(example.text, "file") : example.text,
        "file");
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
  EXPECT_EQ(num_cameras, 110);
}

// docs/formats.md shows an example of each format of other tools.
TEST(FormatDetection, ReadsTheExamplesOfTheDocumentation) {
  int num_examples = 0;
  for (const auto& entry : std::filesystem::directory_iterator(sourcePath("docs/examples/formats"))) {
    const CameraSource source = loadCameras(entry.path().string());
    EXPECT_EQ(source.format, entry.path().stem().string());
    EXPECT_GE(source.cameras.size(), 1u);
    ++num_examples;
  }
  EXPECT_EQ(num_examples, static_cast<int>(cameraFormats().size()) - 1);  // all but this program's own
}

TEST(FormatDetection, NamesFilesOfOtherPrograms) {
  const std::vector<std::pair<std::string, std::string>> cases = {
      {"Calibration results \n====\nCamera-system parameters:\n\tcam0 (/image_raw):\n\t type: <class 'a'>\n",
       "Kalibr's report (results-cam.txt)"},
      {"<?xml version='1.0'?>\n<calibration qtm-version=\"2\"><cameras/></calibration>\n", "Qualisys"},
      {"<lensdatabase version=\"2\"><lens><model>a</model></lens></lensdatabase>\n", "lensfun"},
      {"<x:xmpmeta><rdf:RDF xcr:DistortionModel=\"brown3\"/></x:xmpmeta>\n", "RealityCapture"},
      {"fileName imageWidth imageHeight\ncamera calibration matrix K [3x3]\n", "Pix4D"},
      {"Dimensions = 6016 4016\nModel = CAHV = perspective, linear\nC = 0 0 0\nA = 0 0 1\n", "CAHV"},
      {"Model = CAHVOR = perspective, distortion\nC = 0 0 0\n", "CAHV"},
      {"[left]\nfx = 700.5\nfy = 701.5\nname = x\n",
       "an INI file, which has numbers of a camera: fx 700.5, fy 701.5 (from line 2)"},
      {"[left]\nmatrix = [[700.5, 0.0, 320.1], [0, 701.5, 240.2], [0, 0, 1]]\n",
       "a TOML file, which has numbers of a camera: a camera matrix with fx 700.5, fy 701.5, cx 320.1, cy 240.2 (line 2)"},
      {"a,b\n1,2\n3,4\n", "a table (CSV)"},
      {"version https://git-lfs.github.com/spec/v1\noid sha256:00\nsize 12\n", "a pointer of Git LFS"},
      {"[array([[700., 0., 320.], [0., 701., 240.], [0., 0., 1.]])]\n",
       "NumPy arrays as Python prints them, which has numbers of a camera: a camera matrix"},
      {"<?xml version='1.0'?>\n<calibration><cameras><camera><fov_marker left=\"0\"/></camera></cameras></calibration>\n",
       "Qualisys"},
      {"<robot name=\"r\">\n</robot>\n", "URDF"},
      {std::string("\0\0\0\x18", 4) + "ftypheic" + std::string(9, '\0'), "a HEIC photograph"},
      {std::string("\0\0\0\x18", 4) + "ftypisom" + std::string(9, '\0'), "a video"},
      {"\xFF\xD8\xFF\xE0 JFIF", "a JPEG image"},
      {"#ROSBAG V2.0\n\x01\x02\xFF", "a ROS bag"},
      {"SQLite format 3" + std::string(3, '\0'), "ROS 2 bag"},
      {"PK\x03\x04\xFF\xFE", "a ZIP archive"},
      {"\x93NUMPY\x01" + std::string(3, '\0'), "a NumPy array"},
      {"\x80\x04\x95\xFF", "a Python pickle"},
      {"\x01\x02" + std::string(9, '\0'), "a binary file of unknown kind"}};
  std::size_t num_named = 0;
  for (const auto& [text, name] : cases) {
    EXPECT_THAT(complaintAbout(text), testing::AllOf(testing::HasSubstr("file: found "),
                                                     testing::HasSubstr(name), testing::HasSubstr("next: ")));
    ++num_named;
  }
  EXPECT_EQ(num_named, cases.size());
  EXPECT_THAT(complaintAbout("Dimensions = 6016 4016\n"), testing::HasSubstr("not a camera file"));
}

// A key is only proposed if the file can then be read.
TEST(FormatDetection, ProposesKeysThatMakeTheFileReadable) {
  const std::string K = "[500.0, 0.0, 320.0, 0.0, 501.0, 240.0, 0.0, 0.0, 1.0]";
  const std::string size = "image_width: 640\nimage_height: 480\n";
  struct Case {
    std::string text;
    std::string advice;
  };
  const std::vector<Case> helped = {
      {size + "camera_matirx: {rows: 3, cols: 3, data: " + K +
           "}\ndistortion_coefficients: [0.1, 0, 0, 0, 0]\n",
       "did you mean 'camera_matrix'?"},
      {size + "camera_matirx: " + K + "\ndistortion_coeficients: [0.1, 0, 0, 0, 0]\n",
       "did you mean 'camera_matrix'?"}};
  for (const Case& one : helped) EXPECT_THAT(complaintAbout(one.text), testing::HasSubstr(one.advice));
  const std::vector<Case> not_helped = {
      {size + "camera_matirx: [1, 2]\n", "a file of unknown format"},
      {"{\"cameraData\": {\"distortionCoeff\": [0.1], \"intrinsicMatrix\": [[500.5, 0, 320], [0, 501, 240], [0, 0, 1]]}}",
       "a camera matrix with fx 500.5"}};
  for (const Case& one : not_helped) {
    EXPECT_THAT(complaintAbout(one.text), testing::AllOf(testing::HasSubstr(one.advice),
                                                         testing::Not(testing::HasSubstr("did you mean"))));
  }
  EXPECT_EQ(helped.size() + not_helped.size(), 4U);
}

// A format can be forced upon any file: the answer is a camera or the place of what it lacks.
TEST(FormatDetection, ReadsEachExampleAsAFormatThatIsGiven) {
  int num_read = 0;
  int num_refused = 0;
  for (const FormatExample& example : formatExamples()) {
    for (const CameraFormat* format : cameraFormats()) {
      SCOPED_TRACE(std::string(format->id) + " of " + example.name);
      const std::string complaint =
          complaintAbout(example.text, {.image_size = {}, .model = "", .format = std::string(format->id)});
      EXPECT_TRUE(complaint.empty() || format->id != example.format) << complaint;
      EXPECT_TRUE(complaint.empty() || complaint.find("file") != std::string::npos) << complaint;
      ++(complaint.empty() ? num_read : num_refused);
    }
  }
  EXPECT_GE(num_read, static_cast<int>(formatExamples().size()));
  EXPECT_GT(num_refused, 8 * num_read);
}

}  // namespace
}  // namespace alidade
