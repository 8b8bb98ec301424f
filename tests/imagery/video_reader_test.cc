// SPDX-License-Identifier: MIT
#include "alidade/imagery/video_reader.h"

#include <gmock/gmock.h>

#include <cstdlib>
#include <random>

#include "imagery/video_files.h"
#include "support/message_of.h"
#include "support/scratch_test.h"

namespace alidade {
namespace {

using testing::AllOf;
using testing::HasSubstr;

class VideoFile : public ScratchTest {};

// Mean and largest difference of grey values.
std::pair<double, int> differenceOf(const GrayImage& a, const cv::Mat& b) {
  int largest = 0;
  double sum = 0;
  for (int y = 0; y < b.rows; ++y) {
    for (int x = 0; x < b.cols; ++x) {
      const int difference = std::abs(a.at(x, y) - b.at<std::uint8_t>(y, x));
      largest = std::max(largest, difference);
      sum += difference;
    }
  }
  return {sum / static_cast<double>(b.total()), largest};
}

TEST_F(VideoFile, GivesItsFramesInTheirOrder) {
  int num_frames = 0;
  for (const char* name : {"clip.avi", "clip.mp4"}) {
    VideoReader reader(writeVideo(path(name), movingSquares(30)));
    for (std::size_t i = 0; reader.advance(); ++i, ++num_frames) {
      EXPECT_EQ(reader.number(), i);
      EXPECT_TRUE(reader.isIntact());
      EXPECT_FALSE(reader.isInterlaced());
      EXPECT_NEAR(reader.seconds(), static_cast<double>(i) / 30, 1e-3);
      const LoadedImage frame = reader.image();
      EXPECT_EQ(frame.exif_orientation, 1);
      ASSERT_EQ(frame.image.size, (ImageSize{160, 120}));
      // Codecs lose a little, and mp4v keeps luma between 16 and 235.
      EXPECT_LT(differenceOf(frame.image, movingSquare(static_cast<int>(i))).first, 6) << name << i;
      EXPECT_GT(differenceOf(frame.image, movingSquare(static_cast<int>(i) + 10)).first, 9) << name << i;
    }
    EXPECT_EQ(reader.statedFrames(), 30u);
    EXPECT_NEAR(reader.statedSeconds(), 1, 0.05);
    EXPECT_EQ(reader.numLost(), 0u);
  }
  EXPECT_EQ(num_frames, 60);
}

TEST_F(VideoFile, RefusesWhatIsNoVideo) {
  const auto complaint = [](const std::string& file) { return messageOf([&] { VideoReader reader(file); }); };
  scratch_.write("text.mp4", "not a video");
  scratch_.write("empty.mp4", "");
  // A list of addresses, which FFmpeg would follow.
  scratch_.write("list.mp4", "#EXTM3U\n#EXT-X-TARGETDURATION:5\n#EXTINF:5,\nclip.ts\n#EXT-X-ENDLIST\n");
  scratch_.write("concat.mp4", "ffconcat version 1.0\nfile clip.avi\n");
  int num_files = 0;
  for (const char* name : {"text.mp4", "empty.mp4", "list.mp4", "concat.mp4"}) {
    EXPECT_THAT(complaint(path(name)), AllOf(HasSubstr(path(name)), HasSubstr("next: "))) << name;
    ++num_files;
  }
  EXPECT_EQ(num_files, 4);
  EXPECT_THAT(complaint(path("missing.mp4")), HasSubstr("no such file or folder"));
  EXPECT_THAT(complaint(folder_.string()), HasSubstr("no ordinary file"));
}

TEST_F(VideoFile, NoticesDamage) {
  // Every frame on its own: most damage breaks the codes of one frame.
  const std::string whole = path("clip.avi");
  writeVideo(whole, movingSquares(40));
  const std::string bytes = scratch_.read("clip.avi");
  std::mt19937 random(3);
  int num_noticed = 0;
  int num_wrong = 0;  // frames that passed as intact with something else in them
  constexpr int kNumFiles = 40;
  for (int k = 0; k < kNumFiles; ++k) {
    std::string damaged = bytes;
    const std::size_t at = bytes.size() / 5 + random() % (bytes.size() / 2);
    for (std::size_t i = at; i < at + 20; ++i) damaged[i] = static_cast<char>(random());
    scratch_.write("damaged.avi", damaged);
    VideoReader reader(path("damaged.avi"));
    bool is_noticed = false;
    int i = 0;
    for (; reader.advance(); ++i) {
      if (!reader.isIntact()) {
        is_noticed = true;
        continue;
      }
      const int number = i + static_cast<int>(reader.numLost());
      if (differenceOf(reader.image().image, movingSquare(number)).first > 8) ++num_wrong;
    }
    num_noticed += is_noticed || reader.numLost() > 0 ? 1 : 0;
  }
  EXPECT_GE(num_noticed, 30);
  EXPECT_LE(num_wrong, 4);
}

TEST(VideoName, IsKnownByItsExtension) {
  for (const char* name : {"a.mp4", "b.MOV", "c/d.mkv", "e.avi"}) EXPECT_TRUE(hasVideoName(name));
  for (const char* name : {"a.png", "mp4", "b.mp4.jpg", ""}) EXPECT_FALSE(hasVideoName(name));
}

}  // namespace
}  // namespace alidade
