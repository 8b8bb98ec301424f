// SPDX-License-Identifier: MIT
// Damaged camera files of all formats: a camera, or an Error that names the file, and nothing else.
#include <cmath>
#include <cstdlib>
#include <string>

#include <gtest/gtest.h>

#include "alidade/core/error.h"
#include "alidade/files/camera_source.h"
#include "alidade/files/formats/camera_format.h"
#include "files/formats/examples.h"
#include "support/mutator.h"

namespace alidade {
namespace {

// At least, over all examples. ALIDADE_PROOF_MUTATIONS asks for more, such as a million.
int numRuns() {
  const char* more = std::getenv("ALIDADE_PROOF_MUTATIONS");
  return more == nullptr ? 20000 : std::stoi(more);
}

void expectSound(const CameraSource& source) {
  EXPECT_FALSE(source.cameras.empty());
  for (const StatedCamera& camera : source.cameras) {
    for (const double value : camera.camera.parameters()) EXPECT_TRUE(std::isfinite(value));
    EXPECT_TRUE(!camera.image_size || (camera.image_size->width > 0 && camera.image_size->height > 0));
  }
}

TEST(FormatMutations, NeverSurprise) {
  // Each camera takes a millisecond, so examples of many have fewer runs.
  double total_weight = 0;
  for (const FormatExample& example : formatExamples())
    total_weight += 1.0 / static_cast<double>(example.cameras.size());
  const int num_runs = numRuns();
  int num_read = 0;
  int num_refused = 0;
  int num_placed = 0;  // with the line
  std::uint32_t seed = 1;
  for (const FormatExample& example : formatExamples()) {
    Mutator mutate(seed++);
    const int num_each =
        1 + static_cast<int>(num_runs / total_weight / static_cast<double>(example.cameras.size()));
    for (int run = 0; run < num_each; ++run) {
      const std::string text = mutate(example.text);
      try {
        expectSound(parseCameras(text, "damaged.file"));
        ++num_read;
      } catch (const Error& error) {
        EXPECT_EQ(error.code(), ErrorCode::kInput) << text;
        EXPECT_NE(std::string(error.what()).find("damaged.file"), std::string::npos) << error.what() << "\n"
                                                                                     << text;
        ++num_refused;
        num_placed += std::string(error.what()).find("damaged.file:") != std::string::npos ? 1 : 0;
      } catch (const std::exception& error) {
        ADD_FAILURE() << error.what() << "\n" << text;
      }
    }
  }
  EXPECT_GE(num_read + num_refused, num_runs);
  EXPECT_GT(num_read, num_runs / 20);
  EXPECT_GT(num_refused, num_runs / 4);
  // Two documents, or none, have no line.
  EXPECT_GT(num_placed, num_refused - num_refused / 100);
}

// Small texts that stand for very much, or for themselves.
TEST(FormatMutations, OfExplodingTextsEnd) {
  const std::string many_ones = [] {
    std::string text = "[1";
    for (int i = 0; i < 5000; ++i) text += ",1";
    return text + "]";
  }();
  std::string rows = "[";
  for (int i = 0; i < 5000; ++i) rows += "*a,";
  rows += "]";
  std::string frames;
  for (int i = 0; i < 20000; ++i) frames += "*f,";
  const std::vector<std::string> texts = {
      "x: &a " + many_ones + "\ncamera_matrix: " + rows + "\n",
      "{\"frames\": &f [*f], \"fl_x\": *f}",
      "{Intrinsics: &a {Intrinsics: *a, K: 1}, FocalLength: *a}",
      "f: &f {file_path: a}\nframes: [" + frames + "]\n",
      "{\"frames\": [" + std::string(100000, '[') + std::string(100000, ']') + "]}",
      "<opencv_storage>" + std::string(3000, '\n') + "<a>" + std::string(200000, ' ') +
          "</a></opencv_storage>",
      "{'optimization_inputs': b'" + std::string(1000000, 'x'),
      "\"transform_matrix\": " + std::string(1000000, '['),
      std::string(1000000, '['),
      std::string(5000000, ' ') + "fl_x: 1",
      "{.fx\": 500.0, \"fy\": 501.0, \"cx\": 320.0, \"cy\": 240.0}",
  };
  int num_refused = 0;
  for (const std::string& text : texts) {
    try {
      (void)parseCameras(text, "exploding.file");
      ADD_FAILURE() << text.substr(0, 60);
    } catch (const Error& error) {
      EXPECT_EQ(error.code(), ErrorCode::kInput);
      EXPECT_NE(std::string(error.what()).find("exploding.file"), std::string::npos) << error.what();
      ++num_refused;
    }
  }
  EXPECT_EQ(num_refused, 11);
}

// A scene of thousands of images is a camera with many poses, which are not read.
TEST(FormatMutations, OfAVeryLargeSceneAreRead) {
  std::string text =
      R"({"camera_model": "OPENCV", "fl_x": 500.0, "fl_y": 501.0, "cx": 320.0, "cy": 240.0, "w": 640, "h": 480, "frames": [)";
  for (int i = 0; i < 20000; ++i) {
    text +=
        (i == 0 ? "\n" : ",\n") + std::string(R"({"file_path": "images/)") + std::to_string(i) +
        R"(.png", "transform_matrix": [[0.123456789012, 0.2345678901, 0.34567890123, 1.0], [0.123456789012, 0.2345678901, 0.34567890123, 1.0],
[0.123456789012, 0.2345678901, 0.34567890123, 1.0], [0.0, 0.0, 0.0, 1.0]]})";
  }
  text += "]}";
  EXPECT_GT(text.size(), 4U << 20U);
  EXPECT_EQ(parseCameras(text, "transforms.json").cameras.at(0).camera.parameters()[2], 319.5);
}

}  // namespace
}  // namespace alidade
