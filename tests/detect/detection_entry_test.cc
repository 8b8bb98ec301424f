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
#include "alidade/print/ink_of_board.h"
#include "alidade/simulate/render.h"
#include "alidade/target/board_spec.h"
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

// The corners that a search finds in a rendered image, as one number.
double weightedSum(const std::string& spec) {
  const Board shown = parseBoardSpec(spec);
  const Renderer renderer(AnyCamera::make("pinhole", std::vector<double>{600, 600, 319.5, 239.5}),
                          {640, 480});
  SE3 pose;
  pose.rotation = SO3::exp({0.3, -0.2, 0.1});
  pose.translation = Eigen::Vector3d(0, 0, 0.5) - pose.rotation * shown.middle();
  RenderOptions options;
  options.blur_px = 0.8;
  options.read_noise = 0;
  options.full_well_electrons = 0;
  const Detection detection = findBoard(renderer.render(inkOf(shown), pose, options), shown);
  EXPECT_TRUE(detection.found()) << spec;
  double sum = 0;
  for (const Corner& corner : detection.corners)
    sum += (corner.id + 1) * (corner.pixel.x() + 2 * corner.pixel.y());
  return sum;
}

// Caches keep outcomes as long as their key is the same. If corners change on purpose, raise
// kDetectionVersion in detection_entry.cc and write the new sums here; they change with the renderer as well.
TEST(DetectionEntry, HasTheVersionOfTheseCorners) {
  constexpr double kNear = 0.01;  // processors with and without AVX2 differ by less
  EXPECT_THAT(entryKey("image", board()), HasSubstr("corners 4 "));
  EXPECT_NEAR(weightedSum("checkerboard:9x6:25mm"), 1266719.5613, kNear);
  EXPECT_NEAR(weightedSum("charuco:8x6:30mm:22mm:DICT_5X5_50"), 537401.9595, kNear);
  EXPECT_NEAR(weightedSum("aprilgrid:4x3:50mm:0.3"), 1022938.3632, kNear);
  EXPECT_NEAR(weightedSum("circles:8x6:25mm:15mm"), 1002345.1205, kNear);
  EXPECT_NEAR(weightedSum("acircles:4x11:20mm:14mm"), 861541.0584, kNear);
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
  const ImageOutcome again = detectInImages(images, std::vector{board()}, options).front().front();
  EXPECT_EQ(again.detection.reason, DetectionReason::kNoBoard);
  EXPECT_THAT(again.detection.corners, IsEmpty());
  EXPECT_THAT(cache.complaints(), ElementsAre(HasSubstr("is damaged; its result was computed again")));
  EXPECT_EQ(cache.find(key), entryText(again));
  // A right one is taken as it is.
  cache.keep(key, entryText(outcome()));
  EXPECT_EQ(entryText(detectInImages(images, std::vector{board()}, options).front().front()),
            entryText(outcome()));
}

}  // namespace
}  // namespace alidade
