// SPDX-License-Identifier: MIT
#include "alidade/imagery/video_reader.h"

#include <gmock/gmock.h>
#include <opencv2/imgcodecs.hpp>

#include <array>
#include <cerrno>
#include <cmath>
#include <csignal>
#include <cstdlib>
#include <random>
#include <thread>

#include <sys/resource.h>
#include <sys/wait.h>

#include "alidade/imagery/video_program.h"

#include "imagery/coded_video.h"
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

TEST_F(VideoFile, MayBeImagesOneAfterAnother) {
  std::string frames;
  for (int i = 0; i < 20; ++i) {
    std::vector<std::uint8_t> frame;
    cv::imencode(".jpg", movingSquare(i), frame);
    frames.append(frame.begin(), frame.end());
  }
  scratch_.write("clip.mjpeg", frames);
  VideoReader reader(path("clip.mjpeg"));
  int num_frames = 0;
  for (; reader.advance(); ++num_frames)
    EXPECT_LT(differenceOf(reader.image().image, movingSquare(num_frames)).first, 2) << num_frames;
  EXPECT_EQ(num_frames, 20);
  EXPECT_EQ(reader.missingShare(), 0);
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

// All grey values of a ramp, with every remainder.
unsigned ramp(int x, int y, int depth) {
  const auto place = static_cast<unsigned>(64 * y + x);
  return place * 21 % (1U << static_cast<unsigned>(depth));
}

struct Depth {
  const char* file;
  const char* codec;
  const char* pixel_format;
  int bits;
};

TEST_F(VideoFile, RoundsLumaToEightBits) {
  constexpr std::array<Depth, 9> kDepths = {{{"a.mkv", "ffv1", "yuv420p", 8},
                                             {"packed.avi", "rawvideo", "nv12", 8},
                                             {"b.mov", "rawvideo", "uyvy422", 8},
                                             {"c.mkv", "ffv1", "yuv420p10le", 10},
                                             {"d.mov", "rawvideo", "yuyv422", 8},
                                             {"e.mkv", "ffv1", "gray12le", 12},
                                             {"f.mkv", "ffv1", "yuv444p12le", 12},
                                             {"g.mkv", "ffv1", "gray16le", 16},
                                             {"h.mkv", "ffv1", "yuv444p16le", 16}}};
  int num_files = 0;
  for (const Depth& depth : kDepths) {
    SCOPED_TRACE(depth.pixel_format);
    VideoReader reader(
        writeVideo(path(depth.file), {.codec = depth.codec,
                                      .pixel_format = depth.pixel_format,
                                      .sample = [&](int x, int y, int) { return ramp(x, y, depth.bits); }}));
    ASSERT_TRUE(reader.advance());
    const GrayImage image = reader.image().image;
    ASSERT_EQ(image.size, (ImageSize{64, 48}));
    int num_wrong = 0;
    const double step = std::exp2(depth.bits - 8);
    for (int y = 0; y < 48; ++y) {
      for (int x = 0; x < 64; ++x) {
        const double rounded = std::min(std::floor(ramp(x, y, depth.bits) / step + 0.5), 255.0);
        num_wrong += image.at(x, y) == rounded ? 0 : 1;
      }
    }
    EXPECT_EQ(num_wrong, 0);
    ++num_files;
  }
  EXPECT_EQ(num_files, 9);
}

TEST_F(VideoFile, MakesColourGreyWithoutNoise) {
  constexpr std::array<Depth, 3> kDepths = {
      {{"a.mkv", "ffv1", "bgr0", 8}, {"b.mkv", "ffv1", "gbrp10le", 10}, {"c.mkv", "ffv1", "gbrp12le", 12}}};
  int num_files = 0;
  for (const Depth& depth : kDepths) {
    SCOPED_TRACE(depth.pixel_format);
    VideoReader reader(
        writeVideo(path(depth.file), {.codec = depth.codec,
                                      .pixel_format = depth.pixel_format,
                                      .sample = [&](int x, int y, int) { return ramp(x, y, depth.bits); }}));
    ASSERT_TRUE(reader.advance());
    const GrayImage image = reader.image().image;
    double worst = 0;
    for (int y = 0; y < 48; ++y) {
      for (int x = 0; x < 64; ++x)
        worst =
            std::max(worst, std::abs(image.at(x, y) - ramp(x, y, depth.bits) / std::exp2(depth.bits - 8)));
    }
    EXPECT_LE(worst, 1.5);  // FFmpeg 9 makes 255, not 254.75, of the largest of 10 bits
    ++num_files;
  }
  EXPECT_EQ(num_files, 3);
}

TEST_F(VideoFile, RefusesLargeFramesBeforeTheyAreDecoded) {
  const std::string clip = writeVideo(path("clip.avi"), movingSquares(5));
  EXPECT_NO_THROW(VideoReader(clip, {.max_pixels = 160 * 120}));
  EXPECT_THAT(messageOf([&] { VideoReader reader(clip, {.max_pixels = 160 * 120 - 1}); }),
              AllOf(HasSubstr("clip.avi: frames of 160x120 pixels"), HasSubstr("at most 19199 pixels")));
  // Frames that grow beyond what the header says: SOF0, precision, height, width.
  std::string bytes = scratch_.read("clip.avi");
  std::size_t num_changed = 0;
  const std::string size("\xFF\xC0\0\x11\x08\0\x78\0\xA0", 9);
  std::size_t at = bytes.find(size);
  while ((at = bytes.find(size, at + 1)) != std::string::npos) {
    bytes.replace(at + 5, 4, "\xFF\xF0\xFF\xF0");
    ++num_changed;
  }
  ASSERT_EQ(num_changed, 4u);
  scratch_.write("large.avi", bytes);
  VideoReader reader(path("large.avi"));
  ASSERT_TRUE(reader.advance());
  EXPECT_FALSE(reader.advance());
  EXPECT_EQ(reader.numLost(), 4u);
}

TEST_F(VideoFile, KnowsWhenItsEndIsMissing) {
  // The table of contents of an MP4 file has to be at its beginning to survive a cut.
  const auto cut = [&](const std::string& name, double share) {
    const std::string bytes = scratch_.read(name);
    scratch_.write("cut_" + name, bytes.substr(0, static_cast<std::size_t>(share * bytes.size())));
    return path("cut_" + name);
  };
  const auto missingIn = [](const std::string& file) {
    VideoReader reader(file);
    while (reader.advance()) {
    }
    return reader.missingShare();
  };
  int num_containers = 0;
  for (const char* name : {"a.mkv", "b.avi", "c.mov", "d.webm"}) {
    SCOPED_TRACE(name);
    const bool is_webm = std::string(name) == "d.webm";
    if (is_webm && !hasEncoder("libvpx")) continue;
    const auto noise = [](int x, int y, int i) {
      return (x * 7919U + y * 104729U + i * 1299709U) % 97U + 60;
    };
    writeVideo(path(name), {.codec = is_webm ? "libvpx" : "mjpeg",
                            .pixel_format = is_webm ? "yuv420p" : "yuvj420p",
                            .num_frames = 60,
                            .sample = noise,
                            .is_header_first = true});
    EXPECT_LT(missingIn(path(name)), 0.005);
    EXPECT_NEAR(missingIn(cut(name, 0.5)), 0.5, 0.1);
    EXPECT_NEAR(missingIn(cut(name, 0.8)), 0.2, 0.06);
    ++num_containers;
  }
  EXPECT_GE(num_containers, 3);
  // Nothing is stated here.
  writeVideo(path("e.ts"), {.codec = "mpeg2video",
                            .pixel_format = "yuv420p",
                            .num_frames = 60,
                            .sample = [](int x, int y, int i) { return (x * y + 9U * i) % 97U; }});
  EXPECT_EQ(missingIn(cut("e.ts", 0.5)), 0);
  // Few frames, each shown for long.
  writeVideo(path("slow.mkv"), {.codec = "ffv1",
                                .pixel_format = "gray",
                                .num_frames = 3,
                                .sample = [](int x, int y, int) { return static_cast<unsigned>(x + y); },
                                .frames_per_second = 0.5});
  EXPECT_LT(missingIn(path("slow.mkv")), 0.005);
}

TEST_F(VideoFile, MayHideFramesByItsEdits) {
  writeVideo(path("clip.mov"), {.codec = "mjpeg",
                                .pixel_format = "yuvj420p",
                                .num_frames = 60,
                                .sample = [](int x, int y, int i) { return (x * y + 9U * i) % 97U; }});
  // The player is to show half of it, as after a cut in a phone.
  std::string bytes = scratch_.read("clip.mov");
  std::size_t num_halved = 0;
  for (const auto& [box, offset] : {std::pair{"mvhd", 20}, {"tkhd", 24}, {"elst", 12}}) {
    const std::size_t at = bytes.find(box) + static_cast<std::size_t>(offset);
    ASSERT_LT(at, bytes.size());
    const auto byteAt = [&](std::size_t i) { return static_cast<std::uint8_t>(bytes[at + i]); };
    const int duration = byteAt(2) * 256 + byteAt(3);
    ASSERT_EQ(duration, 2000) << box;  // ms
    bytes[at + 2] = 1000 / 256;
    bytes[at + 3] = static_cast<char>(1000 % 256);
    ++num_halved;
  }
  EXPECT_EQ(num_halved, 3u);
  scratch_.write("half.mov", bytes);
  VideoReader reader(path("half.mov"));
  int num_frames = 0;
  while (reader.advance()) ++num_frames;
  EXPECT_NEAR(num_frames, 30, 2);
  EXPECT_LT(reader.missingShare(), 0.02);
  EXPECT_FALSE(reader.isCut());
}

// A number of a box in MP4, most significant byte first.
std::string bigEndian(std::size_t number) {
  std::string bytes;
  for (const unsigned shift : {24U, 16U, 8U, 0U}) bytes += static_cast<char>(number >> shift & 0xFFU);
  return bytes;
}

TEST_F(VideoFile, DoesNotReadTheSameDataWithoutEnd) {
  constexpr std::size_t kNumFrames = 100;
  writeVideo(path("clip.mp4"), {.codec = "mjpeg",
                                .pixel_format = "yuvj420p",
                                .num_frames = kNumFrames,
                                .sample = [](int x, int y, int i) { return (x * y + 9U * i) % 97U; }});
  std::string bytes = scratch_.read("clip.mp4");
  const std::size_t data = bytes.find("mdat") + 4;
  const std::size_t num_data = bytes.find("moov") - 4 - data;
  // Each of the frames is the whole of the data, at the same place.
  const std::size_t sizes = bytes.find("stsz") + 16;
  for (std::size_t i = 0; i < kNumFrames; ++i) bytes.replace(sizes + 4 * i, 4, bigEndian(num_data));
  bytes.replace(bytes.find("stsc") + 16, 4, bigEndian(1));  // frames in a chunk
  const std::size_t chunks = bytes.find("stco") + 8;
  ASSERT_EQ(bytes.substr(chunks, 4), bigEndian(1));
  bytes.replace(chunks, 4, bigEndian(kNumFrames));
  std::string more;
  for (std::size_t i = 1; i < kNumFrames; ++i) more += bigEndian(data);
  bytes.insert(chunks + 8, more);
  for (const char* box : {"moov", "trak", "mdia", "minf", "stbl", "stco"}) {
    const std::size_t at = bytes.find(box) - 4;
    const auto byteAt = [&](std::size_t i) { return static_cast<std::uint8_t>(bytes[at + i]); };
    bytes.replace(at, 4, bigEndian(byteAt(2) * 256 + byteAt(3) + more.size()));
  }
  scratch_.write("bomb.mp4", bytes);
  ASSERT_GT(kNumFrames * num_data, 5 * bytes.size() + (1U << 20U));
  EXPECT_THAT(messageOf([&] {
                VideoReader reader(path("bomb.mp4"));
                while (reader.advance()) {
                }
              }),
              AllOf(HasSubstr("bomb.mp4"), HasSubstr("more data than the file holds")));
}

TEST_F(VideoFile, TakesNoMemoryForFramesThatCannotBe) {
  writeVideo(path("clip.mov"), {.codec = "mjpeg",
                                .pixel_format = "yuvj420p",
                                .num_frames = 2,
                                .sample = [](int x, int y, int i) { return (x * y + 9U * i) % 97U; }});
  // Forty million frames of one byte, which FFmpeg would list in a gigabyte.
  std::string bytes = scratch_.read("clip.mov");
  const std::string many = bigEndian(40'000'000);
  bytes.replace(bytes.find("stsz") + 8, 8, bigEndian(1) + many);
  bytes.replace(bytes.find("stsc") + 16, 4, many);
  bytes.replace(bytes.find("stts") + 12, 4, many);
  scratch_.write("bomb.mov", bytes);
  const auto peakMegabytes = [](int of_whom) {
    rusage usage{};
    getrusage(of_whom, &usage);
    return usage.ru_maxrss / 1024;
  };
  const long before = peakMegabytes(RUSAGE_SELF);
  try {
    VideoReader reader(path("bomb.mov"));
    while (reader.advance()) EXPECT_FALSE(reader.isIntact());
  } catch (const Error& error) {
    EXPECT_THAT(error.what(), HasSubstr("bomb.mov"));
  }
  EXPECT_LT(peakMegabytes(RUSAGE_SELF) - before, 100);
  EXPECT_LT(peakMegabytes(RUSAGE_CHILDREN), 500);  // of the largest program that was started
}

TEST_F(VideoFile, StopsWhenItIsCancelled) {
  const std::string clip = writeVideo(path("clip.avi"), movingSquares(10));
  CancelFlag cancel{false};
  VideoReader reader(clip, {.cancel = &cancel});
  ASSERT_TRUE(reader.advance());
  cancel = true;
  EXPECT_THROW((void)reader.advance(), Cancelled);
  EXPECT_THROW(VideoReader(clip, {.cancel = &cancel}), Cancelled);
}

// A texture that moves, with something new in each frame.
unsigned movingTexture(int x, int y, int frame) {
  const unsigned place = static_cast<unsigned>((x + 3 * frame) / 5 * 7919 + (y + frame) / 4 * 104729);
  return 60 + place * 31 % 131;
}

TEST_F(VideoFile, NoticesDamageOfH264) {
  if (!hasEncoder("libx264")) GTEST_SKIP() << "FFmpeg without libx264";
  writeVideo(path("clip.mkv"), {.codec = "libx264",
                                .pixel_format = "yuv420p",
                                .size = {160, 120},
                                .num_frames = 40,
                                .sample = movingTexture});
  std::vector<std::vector<std::uint8_t>> frames;
  {
    VideoReader reader(path("clip.mkv"));
    while (reader.advance()) {
      EXPECT_TRUE(reader.isIntact());
      frames.push_back(reader.image().image.pixels);
    }
    EXPECT_EQ(reader.numLost(), 0u);
  }
  ASSERT_EQ(frames.size(), 40u);
  const std::string bytes = scratch_.read("clip.mkv");
  std::mt19937 random(5);
  int num_damaged = 0;
  int num_noticed = 0;
  int num_intact = 0;
  int num_wrong = 0;  // frames that passed as intact with something else in them
  for (; num_damaged < 60; ++num_damaged) {
    std::string damaged = bytes;
    const std::size_t at = bytes.size() / 10 + random() % (bytes.size() * 8 / 10);
    damaged[at] = static_cast<char>(damaged[at] ^ (1 << random() % 8));
    scratch_.write("damaged.mkv", damaged);
    VideoReader reader(path("damaged.mkv"));
    bool is_noticed = false;
    while (reader.advance()) {
      is_noticed = is_noticed || !reader.isIntact();
      if (!reader.isIntact()) continue;
      ++num_intact;
      num_wrong += std::ranges::count(frames, reader.image().image.pixels) > 0 ? 0 : 1;
    }
    num_noticed += is_noticed || reader.numLost() > 0 ? 1 : 0;
  }
  // Many a changed bit leaves valid codes, and the encoder's stream depends on its version and the processor.
  // Twelve sequences of places: 40 to 54 files noticed (mean 45, standard deviation 4), 27 to 114 frames
  // wrong (mean 73, standard deviation 20).
  EXPECT_GE(num_noticed, 33);
  EXPECT_GT(num_intact, 10 * num_damaged);
  EXPECT_LE(num_wrong, 140);
}

TEST_F(VideoFile, NoticesMissingPacketsOfMatroska) {
  writeVideo(path("clip.mkv"), {.codec = "mpeg4",
                                .pixel_format = "yuv420p",
                                .size = {160, 120},
                                .num_frames = 40,
                                .sample = movingTexture});
  std::string bytes = scratch_.read("clip.mkv");
  // Without the head of the second cluster, the reader goes on at the third.
  const std::string head = "\x1F\x43\xB6\x75";
  const std::size_t second = bytes.find(head, bytes.find(head) + 1);
  ASSERT_NE(second, std::string::npos);
  bytes.replace(second, 30, 30, '\0');
  scratch_.write("gap.mkv", bytes);
  VideoReader reader(path("gap.mkv"));
  std::size_t num_frames = 0;
  while (reader.advance()) ++num_frames;
  EXPECT_LT(num_frames, 35u);
  EXPECT_EQ(reader.numLost(), 1u);
  EXPECT_TRUE(reader.isIntact());  // since a key frame
}

TEST_F(VideoFile, HasItsFramesAndTimesInTheOrderInWhichTheyAreShown) {
  // Frame i is all of one brightness, and is shown after i(i+1)/2 thirtieths of a second, in whole
  // milliseconds; B-frames are stored after later ones.
  const auto sample = [](int, int, int frame) { return 20U + 7U * static_cast<unsigned>(frame); };
  VideoReader reader(writeVideo(path("clip.mkv"), {.codec = "mpeg4",
                                                   .pixel_format = "yuv420p",
                                                   .num_frames = 30,
                                                   .sample = sample,
                                                   .options = {"-bf", "2", "-vf", "setpts=N*(N+1)/60/TB"}}));
  std::size_t num_frames = 0;
  for (; reader.advance(); ++num_frames) {
    const auto i = static_cast<double>(num_frames);
    EXPECT_EQ(reader.number(), num_frames);
    EXPECT_DOUBLE_EQ(reader.seconds(), std::round(i * (i + 1) / 60 * 1000) / 1000) << i;
    EXPECT_NEAR(reader.image().image.at(32, 24), 20 + 7 * i, 2) << i;
    EXPECT_TRUE(reader.isIntact());
  }
  EXPECT_EQ(num_frames, 30u);
  EXPECT_FALSE(reader.advance());  // still at the end
}

TEST_F(VideoFile, KnowsHowPlayersTurnIt) {
  writeVideo(path("clip.mov"),
             {.codec = "mjpeg", .pixel_format = "yuvj420p", .num_frames = 2, .sample = [](int x, int y, int) {
                return static_cast<unsigned>(x + y);
              }});
  const std::string bytes = scratch_.read("clip.mov");
  const std::size_t matrix = bytes.find("tkhd") + 4 + 40;
  const std::string one("\0\1\0\0", 4);
  const std::string minus_one("\xFF\xFF\0\0", 4);
  const std::string zero(4, '\0');
  ASSERT_EQ(bytes.substr(matrix, 8), one + zero);
  struct Turn {
    int exif_orientation;
    std::array<std::string, 4> matrix;  // x to x, x to y, y to x, y to y; y points down
  };
  int num_turns = 0;
  for (const Turn& turn :
       {Turn{1, {one, zero, zero, one}}, Turn{6, {zero, one, minus_one, zero}},
        Turn{3, {minus_one, zero, zero, minus_one}}, Turn{8, {zero, minus_one, one, zero}}}) {
    std::string turned = bytes;
    for (std::size_t i = 0; i < 4; ++i) turned.replace(matrix + 4 * (i + i / 2), 4, turn.matrix[i]);
    scratch_.write("turned.mov", turned);
    VideoReader reader(path("turned.mov"));
    ASSERT_TRUE(reader.advance());
    EXPECT_EQ(reader.image().exif_orientation, turn.exif_orientation);
    EXPECT_EQ(reader.image().image.size, (ImageSize{64, 48}));
    ++num_turns;
  }
  EXPECT_EQ(num_turns, 4);
}

TEST_F(VideoFile, SaysThatItIsInterlaced) {
  VideoReader reader(
      writeVideo(path("clip.mkv"), {.codec = "mpeg2video",
                                    .pixel_format = "yuv420p",
                                    .num_frames = 5,
                                    .sample = movingTexture,
                                    .options = {"-flags", "+ildct+ilme", "-vf", "setfield=tff"}}));
  int num_interlaced = 0;
  while (reader.advance()) num_interlaced += reader.isInterlaced() ? 1 : 0;
  EXPECT_EQ(num_interlaced, 5);
}

TEST_F(VideoFile, MayChangeItsSize) {
  std::string frames;
  for (int i = 0; i < 9; ++i) {
    cv::Mat image = movingSquare(i);
    if (i % 3 != 0) cv::resize(image, image, {100 + 20 * i, 80 + 10 * i});
    std::vector<std::uint8_t> frame;
    cv::imencode(".jpg", image, frame);
    frames.append(frame.begin(), frame.end());
  }
  scratch_.write("clip.mjpeg", frames);
  VideoReader reader(path("clip.mjpeg"));
  int i = 0;
  for (; reader.advance(); ++i) {
    const ImageSize expected = i % 3 == 0 ? ImageSize{160, 120} : ImageSize{100 + 20 * i, 80 + 10 * i};
    const GrayImage image = reader.image().image;
    ASSERT_EQ(image.size, expected) << i;
    cv::Mat square = movingSquare(i);
    cv::resize(square, square, {expected.width, expected.height});
    EXPECT_LT(differenceOf(image, square).first, 3) << i;
  }
  EXPECT_EQ(i, 9);
}

TEST_F(VideoFile, MayHaveAnyName) {
  const std::string bytes = scratch_.read(
      std::filesystem::path(writeVideo(path("clip.avi"), movingSquares(3))).filename().string());
  int num_files = 0;
  for (const char* name : {"-i.avi", "a b.avi", "it's \"so\".avi", "file:c.avi", "http://d.avi", "100%d.avi",
                           "two\nlines.avi", "Bär 板.avi", "$(touch x)|;&.avi", "e.avi?f=1.avi"}) {
    scratch_.write(name, bytes);
    VideoReader reader(path(name));
    int num_frames = 0;
    while (reader.advance()) ++num_frames;
    EXPECT_EQ(num_frames, 3) << name;
    scratch_.write(name, "no video");
    EXPECT_THAT(messageOf([&] { VideoReader bad(path(name)); }), HasSubstr("cannot be opened (")) << name;
    ++num_files;
  }
  // Without a folder before it.
  const std::filesystem::path before = std::filesystem::current_path();
  std::filesystem::current_path(folder_);
  scratch_.write("-i.avi", bytes);
  EXPECT_TRUE(VideoReader("-i.avi").advance());
  std::filesystem::current_path(before);
  EXPECT_EQ(num_files, 10);
}

// Programs that stand before or instead of those in PATH.
class VideoProgram : public VideoFile {
 protected:
  void SetUp() override { writeVideo(clip_, movingSquares(10)); }
  void TearDown() override { ::setenv("PATH", path_.c_str(), 1); }

  void usePath(const std::string& path) const { ::setenv("PATH", path.c_str(), 1); }
  void addScript(const std::string& name, const std::string& text) const {
    const std::string file = scratch_.write("bin/" + name, "#!/bin/sh\nPATH='" + path_ + "'\n" + text);
    std::filesystem::permissions(file, std::filesystem::perms::owner_all);
  }
  [[nodiscard]] std::string complaint() const {
    return messageOf([&] {
      VideoReader reader(clip_);
      while (reader.advance()) {
      }
    });
  }

  std::string path_ = std::getenv("PATH");
  std::string clip_ = path("clip.avi");
};

TEST_F(VideoProgram, IsNamedIfItIsMissing) {
  usePath(path("bin"));
  const auto names = [&](const std::string& name) {
    return AllOf(HasSubstr(clip_), HasSubstr("program " + name), HasSubstr("not found"),
                 HasSubstr("sudo apt install ffmpeg"));
  };
  EXPECT_THAT(complaint(), names("ffprobe"));
  EXPECT_THAT(messageOf([&] { (void)videoDecoderVersion(clip_); }), names("ffmpeg"));
  addScript("ffprobe", "exec ffprobe \"$@\"");
  EXPECT_THAT(complaint(), names("ffmpeg"));
  addScript("ffmpeg", "exec ffmpeg \"$@\"");
  EXPECT_EQ(complaint(), "nothing was thrown");
}

TEST_F(VideoProgram, MayBeBroken) {
  usePath(path("bin") + ":" + path_);
  const std::string broken = "echo 'error while loading: libx.so' >&2; echo more >&2; exit 127";
  addScript("ffmpeg", broken);
  const auto explains = [&](const std::string& name) {
    return AllOf(HasSubstr(clip_), HasSubstr("program " + name),
                 HasSubstr("status 127: error while loading: libx.so"), testing::Not(HasSubstr("more")),
                 HasSubstr("next: "));
  };
  EXPECT_THAT(complaint(), explains("ffmpeg"));
  EXPECT_THAT(messageOf([&] { (void)videoDecoderVersion(clip_); }), explains("ffmpeg"));
  addScript("ffprobe", broken);
  EXPECT_THAT(complaint(), explains("ffprobe"));
  addScript("ffprobe", "exit 0");
  EXPECT_THAT(complaint(), HasSubstr("nothing to show"));
  // Prints what is unknown.
  std::filesystem::remove(path("bin/ffprobe"));
  addScript("ffmpeg", "ffmpeg \"$@\" 2>/dev/null");
  EXPECT_THAT(complaint(), HasSubstr("more pixels than it announced"));
}

TEST_F(VideoProgram, MayDieHalfWay) {
  usePath(path("bin") + ":" + path_);
  addScript("ffmpeg", "ffmpeg \"$@\" | head -c 67200; kill -SEGV $$");  // three frames and a half
  VideoReader reader(clip_);
  int num_frames = 0;
  const std::string message = messageOf([&] {
    for (; reader.advance(); ++num_frames) {
      EXPECT_TRUE(reader.isIntact());
      EXPECT_LT(differenceOf(reader.image().image, movingSquare(num_frames)).first, 6);
    }
  });
  EXPECT_EQ(num_frames, 3);
  EXPECT_THAT(message, AllOf(HasSubstr(clip_), HasSubstr("signal 11"), HasSubstr("next: ")));
}

TEST_F(VideoProgram, EndsWithItsReader) {
  // Waits for ever before its frames.
  usePath(path("bin") + ":" + path_);
  addScript("ffmpeg", "echo $$ > '" + path("pid") + "'; sleep 1000; ffmpeg \"$@\"");
  CancelFlag cancel{false};
  VideoReader reader(clip_, {.cancel = &cancel});
  std::thread canceller([&] {
    while (scratch_.read("pid").empty()) std::this_thread::yield();
    cancel = true;
  });
  EXPECT_THROW((void)reader.advance(), Cancelled);
  canceller.join();
  const pid_t group = std::stoi(scratch_.read("pid"));
  EXPECT_EQ(::kill(-group, 0), 0);
  { const VideoReader ended = std::move(reader); }
  EXPECT_EQ(::waitpid(-1, nullptr, WNOHANG), -1);  // no child, not even a dead one
  EXPECT_EQ(errno, ECHILD);
}

TEST(VideoName, IsKnownByItsExtension) {
  for (const char* name : {"a.mp4", "b.MOV", "c/d.mkv", "e.avi"}) EXPECT_TRUE(hasVideoName(name));
  for (const char* name : {"a.png", "mp4", "b.mp4.jpg", ""}) EXPECT_FALSE(hasVideoName(name));
}

}  // namespace
}  // namespace alidade
