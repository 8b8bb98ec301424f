// SPDX-License-Identifier: MIT
#include <array>
#include <cstdint>
#include <cstdlib>
#include <filesystem>

#include <fmt/format.h>
#include <boost/crc.hpp>

#include "alidade/core/random.h"
#include "apps/command_line.h"
#include "support/source_tree.h"

namespace alidade {
namespace {

namespace fs = std::filesystem;

// Spoils images: bytes, numbers, pieces, and the start of one kind before the rest of another.
class ImageSpoiler {
 public:
  ImageSpoiler() : random_(91) {
    const std::string folder = sourcePath("testdata/fuzz/image_file");
    std::vector<std::string> paths;
    for (const auto& entry : fs::directory_iterator(folder)) paths.push_back(entry.path().string());
    std::sort(paths.begin(), paths.end());
    for (const std::string& path : paths) images_.push_back(readFile(path));
  }
  [[nodiscard]] std::size_t numKinds() const { return images_.size(); }

  std::string next() {
    std::string image = images_[random_.index(images_.size())];
    if (random_.uniform() < 0.06) {
      constexpr std::array<std::size_t, 6> kStarts = {2, 4, 8, 16, 32, 132};
      const std::size_t start = kStarts[random_.index(kStarts.size())];
      if (image.size() > start) image.replace(0, start, images_[random_.index(images_.size())], 0, start);
    }
    const std::size_t num_changes = 1 + random_.index(4);
    for (std::size_t i = 0; i < num_changes && !image.empty(); ++i) change(image);
    if (image.starts_with("\x89PNG") && random_.uniform() < 0.7) mendChecksums(image);
    return image;
  }

 private:
  void change(std::string& image) {
    constexpr std::array<std::size_t, 4> kHeads = {24, 64, 256, 1 << 20};
    std::size_t at = random_.index(std::min(kHeads[random_.index(kHeads.size())], image.size()));
    if (random_.uniform() < 0.15) at = image.size() - 1 - at;  // directories of TIFF files are at the end
    switch (random_.index(6)) {
      case 0:
        image.erase(at, 1 + random_.index(20));
        break;
      case 1:
        image.insert(at, 1 + random_.index(20), static_cast<char>(random_.index(256)));
        break;
      case 2:
        if (random_.uniform() < 0.3) image.resize(at);
        break;
      case 3:
      case 4:
        for (std::size_t i = 0; i < 4 && at + i < image.size(); ++i)
          image[at + i] = static_cast<char>(random_.uniform() < 0.5 ? 0xff : 0);
        break;
      default:
        image[at] = static_cast<char>(random_.index(256));
    }
  }

  // Otherwise no damage would get past them.
  static void mendChecksums(std::string& png) {
    const auto byte = [&](std::size_t i) {
      return static_cast<std::uint32_t>(static_cast<unsigned char>(png[i]));
    };
    for (std::size_t at = 8; at + 12 <= png.size();) {
      const std::size_t length = byte(at) << 24U | byte(at + 1) << 16U | byte(at + 2) << 8U | byte(at + 3);
      if (length > png.size() - at - 12) return;
      boost::crc_32_type crc;
      crc.process_bytes(png.data() + at + 4, length + 4);
      for (std::size_t i = 0; i < 4; ++i)
        png[at + 8 + length + i] = static_cast<char>(crc.checksum() >> (24 - 8 * i) & 0xffU);
      at += length + 12;
    }
  }

  Random random_;
  std::vector<std::string> images_;
};

// Where the program's libraries put temporary copies.
class TemporaryFolder {
 public:
  explicit TemporaryFolder(std::string path) : path_(std::move(path)) {
    ::setenv("TMPDIR", path_.c_str(), 1);
  }
  ~TemporaryFolder() { ::unsetenv("TMPDIR"); }
  TemporaryFolder(const TemporaryFolder&) = delete;
  TemporaryFolder& operator=(const TemporaryFolder&) = delete;
  [[nodiscard]] bool isEmpty() const { return fs::is_empty(path_); }

 private:
  std::string path_;
};

TEST(HostileImages, HarmNoRunAndNoOtherImage) {
  const char* more = std::getenv("ALIDADE_PROOF_IMAGES");
  const int num_images = more != nullptr ? std::atoi(more) : 2000;
  constexpr int kBatch = 250;
  ImageSpoiler spoiler;
  ASSERT_GE(spoiler.numKinds(), 40u);
  const ScratchFolder scratch;
  const TemporaryFolder temporary(scratch.makeFolder("temporary"));
  int num_spoiled = 0;
  int num_refused = 0;
  while (num_spoiled < num_images) {
    const std::string folder = linkImages(scratch, "photos", 2);
    for (int i = 0; i < kBatch; ++i, ++num_spoiled)
      scratch.write(fmt::format("photos/spoiled_{:03}.{}", i, i % 2 == 0 ? "png" : "jpg"), spoiler.next());
    SCOPED_TRACE(fmt::format("images {} to {}", num_spoiled - kBatch, num_spoiled));
    const RunResult result = runAlidade(
        {"detect", folder, "--board", kBoardSpec, "--jobs", "2", "-o", scratch.path("corners.csv")},
        {.time_limit = std::chrono::seconds(10)});
    ASSERT_THAT(result, EndsWith(0)) << result.err;
    const std::string corners = scratch.read("corners.csv");
    for (const char* good : {"view_001.png,found", "view_002.png,found"})
      EXPECT_THAT(corners, testing::HasSubstr(good));
    for (std::size_t at = 0; (at = corners.find(",unreadable", at)) != std::string::npos; ++at) ++num_refused;
    EXPECT_TRUE(temporary.isEmpty());
    fs::remove_all(folder);
  }
  EXPECT_GT(num_refused, num_images / 2);
}

}  // namespace
}  // namespace alidade
