// SPDX-License-Identifier: MIT
#include "alidade/imagery/image_set.h"

#include <gmock/gmock.h>
#include <opencv2/imgcodecs.hpp>

#include <algorithm>
#include <numeric>

#include <sys/stat.h>

#include "alidade/core/digest.h"
#include "alidade/core/parallel.h"
#include "alidade/files/content_cache.h"
#include "alidade/imagery/video_program.h"
#include "imagery/video_files.h"
#include "support/message_of.h"
#include "support/scratch_test.h"

namespace alidade {
namespace {

using testing::AllOf;
using testing::ElementsAre;
using testing::HasSubstr;

class OpenImages : public ScratchTest {
 protected:
  [[nodiscard]] ImageSet open(const std::vector<std::string>& names, OpenImagesOptions options = {}) const {
    std::vector<std::string> inputs;
    for (const std::string& name : names) inputs.push_back(path(name));
    return openImages(inputs, options);
  }
  void writeImages(const std::string& folder, int first, int count) const {
    std::filesystem::create_directories(path(folder));
    for (int i = first; i < first + count; ++i)
      cv::imwrite(path(cv::format("%s/img%03d.png", folder.c_str(), i)), movingSquare(i));
  }
};

std::vector<std::uint8_t> pixelsOf(const ImageSet& images, std::size_t i) {
  return images.read(i).decode().image.pixels;
}

TEST_F(OpenImages, ReadsChosenFramesOfAVideoInAnyOrder) {
  writeVideo(path("clip.avi"), movingSquares(120));
  const ImageSet images = open({"clip.avi"}, {.num_frames = 25});
  ASSERT_EQ(images.size(), 25u);
  EXPECT_THAT(images.notes(), ElementsAre(HasSubstr("25 of 120 frames are searched")));
  std::vector<std::vector<std::uint8_t>> expected;
  for (std::size_t i = 0; i < images.size(); ++i) {
    expected.push_back(pixelsOf(images, i));
    EXPECT_THAT(images.name(i), HasSubstr("clip.avi@"));
    EXPECT_EQ(images.sequenceOf(i), 0u);
    EXPECT_EQ(images.read(i).identity, "");  // not needed without a cache
  }
  std::size_t num_same = 0;
  for (std::size_t i = images.size(); i-- > 0;) num_same += pixelsOf(images, i) == expected[i] ? 1 : 0;
  EXPECT_EQ(num_same, images.size());
  std::vector<int> are_same(images.size());
  parallelFor(images.size(), 4,
              [&](std::size_t i) { are_same[i] = pixelsOf(images, i) == expected[i] ? 1 : 0; });
  EXPECT_EQ(std::accumulate(are_same.begin(), are_same.end(), 0), 25);
}

TEST_F(OpenImages, ReadsRunsOfEqualNumbersFromSeveralVideos) {
  writeVideo(path("a.avi"), movingSquares(120));
  writeVideo(path("b.avi"), movingSquares(101));
  const auto numbersOf = [&](const char* video, const OpenImagesOptions& options) {
    const ImageSet images = open({video}, options);
    std::vector<std::size_t> numbers;
    for (std::size_t i = 0; i < images.size(); ++i) {
      numbers.push_back(parseFrameName(images.name(i))->second);
      EXPECT_EQ(images.sequenceOf(i), std::nullopt);
    }
    return numbers;
  };
  std::vector<std::size_t> expected;  // of 30 frames a second every fourth; the first half without a gap
  for (std::size_t i = 0; i < 13; ++i) expected.push_back(4 * i);
  const std::vector<std::size_t> a = numbersOf("a.avi", {.num_frames = 25, .even_from = 0});
  const std::vector<std::size_t> b = numbersOf("b.avi", {.num_frames = 25, .even_from = 0});
  ASSERT_EQ(a.size(), 25u);
  EXPECT_EQ(std::vector(a.begin(), a.begin() + 13), expected);
  EXPECT_EQ(b.size(), 25u);
  EXPECT_EQ(numbersOf("a.avi", {.num_frames = 1, .even_from = 3}), std::vector<std::size_t>{3});
  const std::vector<std::size_t> later = numbersOf("a.avi", {.num_frames = 200, .even_from = 5});
  ASSERT_EQ(later.size(), 29u);
  EXPECT_EQ(later.front(), 5u);
  EXPECT_EQ(later.back(), 117u);
}

TEST_F(OpenImages, MakesAnUnreadableImageOfABadVideo) {
  writeVideo(path("clip.avi"), movingSquares(60));
  const std::string bytes = scratch_.read("clip.avi");
  scratch_.write("short.avi", bytes.substr(0, bytes.size() / 2));
  scratch_.write("text.mp4", "no video");
  writeImages("d", 0, 2);
  const ImageSet images = open({"short.avi", "text.mp4", "d"});
  ASSERT_EQ(images.size(), 4u);
  EXPECT_THAT(images.name(2), HasSubstr("short.avi"));
  EXPECT_THAT(messageOf([&] { (void)images.read(2); }),
              AllOf(HasSubstr("ends early"), HasSubstr("of 60 frames can be read"), HasSubstr("next: ")));
  EXPECT_THAT(messageOf([&] { (void)images.read(3); }), HasSubstr("cannot be opened"));
  EXPECT_FALSE(images.read(0).decode().image.empty());
}

TEST_F(OpenImages, DoesNotUseDamagedFrames) {
  writeVideo(path("clip.avi"), movingSquares(60));
  std::string bytes = scratch_.read("clip.avi");
  const std::size_t begin = bytes.find("\xFF\xD8", bytes.size() / 2);
  std::fill_n(bytes.begin() + static_cast<std::ptrdiff_t>(begin) + 2, 300, '\xFF');
  scratch_.write("clip.avi", bytes);
  const ImageSet images = open({"clip.avi"});
  EXPECT_THAT(images.notes(),
              ElementsAre(HasSubstr("frames are searched"), HasSubstr("1 of 60 frames are damaged")));
}

TEST_F(OpenImages, SaysThatAVideoEndsALittleEarly) {
  writeVideo(path("clip.avi"), movingSquares(100));
  const std::string bytes = scratch_.read("clip.avi");
  std::size_t at = bytes.find("idx1");
  for (int i = 0; i < 6; ++i) at = bytes.rfind("00dc", at - 1);
  scratch_.write("short.avi", bytes.substr(0, at));
  EXPECT_THAT(open({"clip.avi"}).notes(), ElementsAre(HasSubstr("frames are searched")));
  EXPECT_THAT(open({"short.avi"}).notes(),
              ElementsAre(HasSubstr("of 94 frames are searched"), HasSubstr("the file ends early")));
}

TEST_F(OpenImages, StopsWhenItIsCancelled) {
  writeVideo(path("clip.avi"), movingSquares(60));
  const ContentCache cache(path("cache"));
  CancelFlag cancel{false};
  std::size_t num_looked_at = 0;
  OpenImagesOptions options{.num_frames = 10,
                            .progress =
                                [&](std::size_t done, std::size_t) {
                                  num_looked_at = done;
                                  cancel = done == 3;
                                },
                            .cancel = &cancel};
  EXPECT_THROW((void)open({"clip.avi"}, options), Cancelled);
  EXPECT_EQ(num_looked_at, 3u);
  // Before the first frame, while the file is known by its bytes.
  options.cache = &cache;
  num_looked_at = 0;
  EXPECT_THROW((void)open({"clip.avi"}, options), Cancelled);
  EXPECT_EQ(num_looked_at, 0u);
  // On the way to a frame, with the choice from the cache.
  cancel = false;
  options.progress = {};
  (void)open({"clip.avi"}, options);
  const ImageSet images = open({"clip.avi"}, options);
  const EncodedImage last = images.read(images.size() - 1);
  cancel = true;
  EXPECT_THROW((void)last.decode(), Cancelled);
}

TEST_F(OpenImages, TakesNumberedImagesAsASequence) {
  writeImages("d", 8, 5);
  cv::imwrite(path("d/img013.png"), movingSquare(12));  // shows the same as the one before
  scratch_.write("d/img014.png", "no image");
  scratch_.write("d/img0015.png", "another number of digits");
  scratch_.write("d/img15.png", "another number of digits");
  const ImageSet images = open({"d/img%03d.png"});
  std::vector<std::string> names = images.names();
  for (std::string& name : names) name = name.substr(name.rfind('/') + 1);
  EXPECT_THAT(
      names, ElementsAre("img008.png", "img009.png", "img010.png", "img011.png", "img012.png", "img014.png"));
  EXPECT_THAT(images.notes(), ElementsAre(HasSubstr("5 of 6 images are searched")));
  EXPECT_EQ(images.sequenceOf(0), 0u);
  EXPECT_NE(images.read(0).identity, images.read(1).identity);
}

TEST_F(OpenImages, SaysWhyASequenceIsEmpty) {
  writeImages("d", 1, 2);
  EXPECT_THAT(messageOf([&] { (void)open({"d/img%04d.png"}); }),
              AllOf(HasSubstr("no file matches this pattern"), HasSubstr("next: ")));
  EXPECT_THAT(messageOf([&] { (void)open({"e/img%04d.png"}); }), HasSubstr("no such file or folder"));
  EXPECT_THAT(messageOf([&] { (void)open({"d/img%s.png"}); }), HasSubstr("no such file or folder"));
}

TEST_F(OpenImages, FindsTheChoiceInTheCache) {
  writeVideo(path("clip.mp4"), movingSquares(90));
  writeImages("d", 0, 12);
  const ContentCache cache(path("cache"));
  const std::vector<std::string> inputs = {"clip.mp4", "d/img%03d.png"};
  const ImageSet plain = open(inputs, {.num_frames = 10});
  const ImageSet cold = open(inputs, {.num_frames = 10, .cache = &cache});
  const ImageSet warm = open(inputs, {.num_frames = 10, .cache = &cache});
  EXPECT_EQ(plain.size(), 20u);
  EXPECT_EQ(cold.names(), plain.names());
  EXPECT_EQ(warm.names(), plain.names());
  EXPECT_EQ(warm.notes(), plain.notes());
  for (std::size_t i = 0; i < warm.size(); ++i) {
    EXPECT_NE(warm.read(i).identity, "");
    EXPECT_EQ(warm.read(i).identity, cold.read(i).identity);
    EXPECT_EQ(pixelsOf(warm, i), pixelsOf(plain, i));
  }
}

TEST_F(OpenImages, ChoosesAgainWhereTheCacheIsWrong) {
  const std::string clip = writeVideo(path("clip.mp4"), movingSquares(90));
  const ContentCache cache(path("cache"));
  const OpenImagesOptions options{.num_frames = 5, .cache = &cache};
  const ImageSet plain = open({"clip.mp4"}, {.num_frames = 5});
  ASSERT_EQ(plain.size(), 5u);
  const std::string key =
      "frames 3 5 " + digestOf(scratch_.read("clip.mp4")) + " " + videoDecoderVersion(path("clip.mp4"));
  std::size_t num_wrong = 0;
  for (const char* wrong :
       {"", "90", "90 0 0 0", "90 0 0 0 1 2 3 4 5 6", "90 0 0 0 3 2", "90 0 0 0 2 2", "90 0 0 0 90",
        "90 0 0 2 1", "90 90 0 0 1", "90 0 91 0 1", "90 0 0 0 -1", "90 0 0 0 1.5", "90 0 0 0 nan",
        "90 0 0 0 99999999999", "99999999999999999999 0 0 0 1", "90 0 0 0 1 ", " 90 0 0 0 1", "{}"}) {
    cache.keep(key, wrong);
    const ImageSet images = open({"clip.mp4"}, options);
    EXPECT_EQ(images.names(), plain.names()) << wrong;
    EXPECT_EQ(images.notes(), plain.notes()) << wrong;
    ++num_wrong;
  }
  EXPECT_EQ(num_wrong, 18u);
  EXPECT_THAT(cache.complaints(), ElementsAre(HasSubstr("18 cache entries are damaged")));
  // The key is the right one: a choice that could be is taken.
  cache.keep(key, "90 0 0 0 1 2");
  EXPECT_THAT(open({"clip.mp4"}, options).names(), ElementsAre(clip + "@1", clip + "@2"));
}

TEST_F(OpenImages, KeepsNothingOfAVideoThatChanges) {
  writeVideo(path("clip.avi"), movingSquares(60));
  const std::string bytes = scratch_.read("clip.avi");
  const ContentCache cache(path("cache"));
  OpenImagesOptions options{.num_frames = 10, .cache = &cache};
  const ImageSet images = open({"clip.avi"}, options);
  EXPECT_FALSE(images.read(0).decode().image.empty());
  scratch_.write("clip.avi", bytes + "more");
  EXPECT_THAT(messageOf([&] { (void)images.read(1).decode(); }),
              AllOf(HasSubstr("clip.avi: the video changed while it was read"), HasSubstr("next: wait")));
  // While its frames are looked at.
  options.progress = [&](std::size_t done, std::size_t) {
    if (done == 20) scratch_.write("clip.avi", bytes);
  };
  const ImageSet changed = open({"clip.avi"}, options);
  ASSERT_EQ(changed.size(), 1u);
  EXPECT_THAT(messageOf([&] { (void)changed.read(0); }), HasSubstr("changed while it was read"));
}

TEST_F(OpenImages, DoesNotWaitForAPipe) {
  ASSERT_EQ(::mkfifo(path("clip.mp4").c_str(), 0600), 0);
  const ContentCache cache(path("cache"));
  for (const ContentCache* used : {static_cast<const ContentCache*>(nullptr), &cache}) {
    const ImageSet images = open({"clip.mp4"}, {.cache = used});
    ASSERT_EQ(images.size(), 1u);
    EXPECT_THAT(messageOf([&] { (void)images.read(0); }), HasSubstr("clip.mp4: this is no ordinary file"));
  }
}

}  // namespace
}  // namespace alidade
