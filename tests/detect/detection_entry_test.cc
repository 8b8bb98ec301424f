// SPDX-License-Identifier: MIT
#include "alidade/detect/detection_entry.h"

#include <gmock/gmock.h>

#include <cmath>
#include <limits>
#include <optional>
#include <string>
#include <utility>

#include "alidade/detect/detect_images.h"
#include "alidade/files/content_cache.h"
#include "support/scratch_test.h"

namespace alidade {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;

constexpr double kNan = std::numeric_limits<double>::quiet_NaN();

Board board() {
  return Checkerboard{.columns = 3, .rows = 2, .square_m = 0.025};
}

ImageOutcome outcome() {
  ImageOutcome outcome;
  outcome.size = {640, 480};
  outcome.exif_orientation = 6;
  outcome.detection = {.reason = DetectionReason::kPartial,
                       .detail = "2 of 6 corners",
                       .corners = {{.id = 1, .pixel = {100.1, 1.0 / 3}, .sigma_px = 0.03},
                                   {.id = 4, .pixel = {-0.25, 479.5}, .sigma_px = kNan}},
                       .measures = {.blur_px = 0.7, .spacing_px = kNan, .area_share = 0.2, .tilt_deg = 12},
                       .seen = SeenGrid{.columns = 2, .rows = 1, .num_corners = 2, .is_closed = true}};
  return outcome;
}

std::string replaced(std::string text, const std::string& from, const std::string& to) {
  const std::size_t at = text.find(from);
  EXPECT_NE(at, std::string::npos) << from;
  return at == std::string::npos ? text : text.replace(at, from.size(), to);
}

TEST(DetectionEntry, IsReadAsItWasWritten) {
  const ImageOutcome written = outcome();
  const std::optional<ImageOutcome> read = parseEntry(entryText(written), board());
  ASSERT_TRUE(read.has_value());
  EXPECT_EQ(read->size, written.size);
  EXPECT_EQ(read->exif_orientation, 6);
  EXPECT_EQ(read->detection.reason, DetectionReason::kPartial);
  EXPECT_EQ(read->detection.detail, "2 of 6 corners");
  ASSERT_EQ(read->detection.corners.size(), 2u);
  EXPECT_EQ(read->detection.corners[0].pixel, Eigen::Vector2d(100.1, 1.0 / 3));
  EXPECT_EQ(read->detection.corners[0].sigma_px, 0.03);
  EXPECT_TRUE(std::isnan(read->detection.corners[1].sigma_px));
  EXPECT_EQ(read->detection.measures.blur_px, 0.7);
  EXPECT_TRUE(std::isnan(read->detection.measures.spacing_px));
  ASSERT_TRUE(read->detection.seen.has_value());
  EXPECT_TRUE(read->detection.seen->is_closed);
  EXPECT_EQ(entryText(*read), entryText(written));
}

TEST(DetectionEntry, IsOfNoUseOtherwise) {
  const std::string text = entryText(outcome());
  const std::pair<const char*, const char*> kChanges[] = {{"\"size\":[640,480]", "\"size\":[640]"},
                                                          {"640,480", "640,0"},
                                                          {"640,480", "-640,480"},
                                                          {"640,480", "640.5,480"},
                                                          {"640,480", "1e300,480"},
                                                          {"640,480", "99999999999,480"},
                                                          {"640,480", "18446744073709551615,480"},
                                                          {"640,480", "true,480"},
                                                          {"640,480", "\"640\",480"},
                                                          {"640,480", "64,48"},  // corners outside
                                                          {"\"orientation\":6", "\"orientation\":0"},
                                                          {"\"orientation\":6", "\"orientation\":9"},
                                                          {"partial", "unreadable"},
                                                          {"partial", "fine"},
                                                          {"partial", "no_board"},  // with corners
                                                          {"partial", "found"},     // with too few
                                                          {"[1,100.1", "[-1,100.1"},
                                                          {"[1,100.1", "[6,100.1"},  // of a larger board
                                                          {"[1,100.1", "[4,100.1"},  // twice
                                                          {"[1,100.1", "[5,100.1"},  // out of order
                                                          {"[1,100.1", "[1.5,100.1"},
                                                          {"100.1", "1e999"},
                                                          {"100.1", "1e300"},
                                                          {"100.1", "-100.1"},
                                                          {"100.1", "null"},
                                                          {"100.1", "NaN"},
                                                          {"100.1", "\"nan\""},
                                                          {"0.03", "-0.03"},
                                                          {"0.03]", "]"},
                                                          {"\"measures\":[0.7", "\"measures\":[-0.7"},
                                                          {"\"measures\":[0.7", "\"measures\":[false"},
                                                          {"\"seen\":[2", "\"seen\":[-2"},
                                                          {"\"seen\":[2", "\"seen\":[4294967297"},
                                                          {"\"seen\":[2,1,2,true", "\"seen\":[2,1,2,1"},
                                                          {"\"seen\"", "\"see\""},
                                                          {"\"corners\"", "\"corner\""}};
  int num_changes = 0;
  for (const auto& [from, to] : kChanges) {
    EXPECT_FALSE(parseEntry(replaced(text, from, to), board())) << from << " -> " << to;
    ++num_changes;
  }
  EXPECT_EQ(num_changes, 36);
  std::size_t num_cuts = 0;
  for (std::size_t i = 0; i < text.size(); ++i, ++num_cuts)
    EXPECT_FALSE(parseEntry(text.substr(0, i), board())) << i;
  EXPECT_GT(num_cuts, 100u);
  EXPECT_FALSE(parseEntry(text + "x", board()));
  EXPECT_FALSE(parseEntry(text, Checkerboard{.columns = 2, .rows = 2, .square_m = 0.025}));
  EXPECT_FALSE(parseEntry(std::string(100'000, '['), board()));
}

class EntryInCache : public ScratchTest {};

TEST_F(EntryInCache, IsSearchedForAgainIfItIsWrong) {
  const ImageSet images({{.name = "a",
                          .read =
                              [](const std::string&) {
                                return EncodedImage{.identity = "a", .decode = [] {
                                                      GrayImage gray{.size = {64, 48}, .pixels = {}};
                                                      gray.pixels.resize(std::size_t{64} * 48, 100);
                                                      return LoadedImage{.image = gray,
                                                                         .exif_orientation = 1};
                                                    }};
                              }}},
                        {});
  const ContentCache cache(path("cache"));
  const std::string key = entryKey("a", board());
  cache.keep(key, replaced(entryText(outcome()), "100.1", "1e300"));
  DetectImagesOptions options;
  options.cache = &cache;
  const ImageOutcome again = detectInImages(images, board(), options).front();
  EXPECT_EQ(again.detection.reason, DetectionReason::kNoBoard);
  EXPECT_THAT(again.detection.corners, IsEmpty());
  EXPECT_THAT(cache.complaints(), ElementsAre(HasSubstr("is damaged; its result was computed again")));
  EXPECT_EQ(cache.find(key), entryText(again));
  // A right one is taken as it is.
  cache.keep(key, entryText(outcome()));
  EXPECT_EQ(entryText(detectInImages(images, board(), options).front()), entryText(outcome()));
}

}  // namespace
}  // namespace alidade
