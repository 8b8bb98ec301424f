// SPDX-License-Identifier: MIT
#include "apps/command_line.h"
#include "alidade/files/camera_source.h"
#include "support/source_tree.h"

#include <filesystem>
#include <fstream>

#include <fmt/format.h>

namespace alidade {

const std::string& alidadeProgram() {
  static const std::string path = ALIDADE_BINARY;
  return path;
}

RunResult runAlidade(const std::vector<std::string>& args, RunOptions options) {
  return runProgram(alidadeProgram(), args, std::move(options));
}

std::string dataPath(const std::string& name) {
  return sourcePath("testdata/checkerboard/" + name);
}

std::string imagePath(int i) {
  return dataPath(fmt::format("images/view_{:03}.png", i));
}

std::string linkImages(const ScratchFolder& scratch, const std::string& folder, int count) {
  const std::string path = scratch.makeFolder(folder);
  for (int i = 0; i < count; ++i) {
    std::filesystem::create_symlink(imagePath(1 + i % kNumImages),
                                    fmt::format("{}/view_{:03}.png", path, 1 + i));
  }
  return path;
}

std::string readFile(const std::string& path) {
  std::ifstream file(path, std::ios::binary);
  EXPECT_TRUE(file.is_open()) << path;
  return {std::istreambuf_iterator<char>(file), {}};
}

std::string replaced(std::string text, const std::string& from, const std::string& to) {
  const std::size_t at = text.find(from);
  EXPECT_NE(at, std::string::npos) << from;
  if (at == std::string::npos) return text;
  EXPECT_EQ(text.find(from, at + 1), std::string::npos) << from << " is there more than once";
  return text.replace(at, from.size(), to);
}

std::vector<double> parametersOf(const std::string& camera_text) {
  const CameraRecord file = onlyCamera(parseCameras(camera_text, "camera of the test"));
  const auto parameters = file.camera.parameters();
  return {parameters.begin(), parameters.end()};
}

std::string smallCamera() {
  return "alidade_camera: 1\n"
         "model: pinhole\n"
         "image_size: {width: 640, height: 480}\n"
         "parameters: {fx: 500, fy: 501, cx: 320, cy: 240}\n";
}

}  // namespace alidade
