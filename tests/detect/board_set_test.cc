// SPDX-License-Identifier: MIT
// Several boards in the same images.
#include "alidade/detect/board_set.h"

#include <gmock/gmock.h>

#include "alidade/core/error.h"
#include "alidade/detect/draw_detection.h"
#include "alidade/detect/survey.h"
#include "alidade/imagery/image_file.h"
#include "alidade/print/ink_of_board.h"
#include "alidade/simulate/observe.h"
#include "alidade/simulate/render.h"
#include "alidade/target/board_spec.h"
#include "support/scratch_folder.h"

namespace alidade {
namespace {

using testing::AllOf;
using testing::ElementsAre;
using testing::HasSubstr;

constexpr ImageSize kSize{1280, 640};

std::vector<Board> boardsOf(const std::vector<std::string>& specs) {
  std::vector<Board> boards;
  for (const std::string& spec : specs) boards.push_back(parseBoardSpec(spec));
  return boards;
}

std::string complaintAbout(const std::vector<std::string>& specs) {
  try {
    requireDistinguishable(boardsOf(specs));
  } catch (const Error& error) {
    EXPECT_EQ(error.code(), ErrorCode::kUsage);
    return error.what();
  }
  return "";
}

TEST(BoardSet, RefusesBoardsThatLookAlike) {
  struct Case {
    std::vector<std::string> specs;
    std::string complaint;  // empty: they differ
  };
  const std::vector<Case> cases = {
      {{"checkerboard:9x6:25mm"}, ""},
      {{"checkerboard:9x6:25mm", "checkerboard:7x5:25mm"}, ""},
      {{"checkerboard:9x6:25mm", "checkerboard:9x6:25mm"}, "the same board twice"},
      {{"checkerboard:9x6:25mm", "checkerboard:6x9:30mm"}, "the same numbers of corners"},
      {{"checkerboard:7x10:25mm", "charuco:8x11:24mm:18mm:DICT_4X4_250"}, "the same numbers of corners"},
      {{"checkerboard:9x6:25mm", "charuco:8x11:24mm:18mm:DICT_4X4_250"}, ""},
      {{"charuco:8x11:24mm:18mm:DICT_4X4_250", "charuco:5x7:24mm:18mm:DICT_4X4_1000"},
       "ids 0 to 17 of DICT_4X4"},
      {{"charuco:8x11:24mm:18mm:DICT_4X4_250", "charuco:8x11:24mm:18mm:DICT_5X5_250"}, ""},
      {{"aprilgrid:6x6:88mm:0.3", "aprilgrid:6x6:88mm:0.3:36"}, ""},
      {{"aprilgrid:6x6:88mm:0.3", "aprilgrid:6x6:88mm:0.3:35"}, "ids 35 to 35 of DICT_APRILTAG_36h11"},
      {{"aprilgrid:6x6:88mm:0.3", "charuco:8x11:24mm:18mm:DICT_APRILTAG_36h11"}, "ids 0 to 35"},
      {{"charuco:8x11:24mm:18mm:DICT_APRILTAG_36h10", "charuco:8x11:24mm:18mm:DICT_APRILTAG_36h11"}, ""},
      {{"circles:10x8:25mm:15mm", "circles:8x10:20mm:12mm"}, "the same numbers of circles"},
      {{"circles:10x8:25mm:15mm", "checkerboard:10x8:25mm"}, ""},
      {{"aprilgrid:6x6:88mm:0.3", "checkerboard:9x6:25mm", "checkerboard:9x6:30mm"},
       "the same numbers of corners"},
  };
  std::size_t num_checked = 0;
  for (const Case& c : cases) {
    const std::string complaint = complaintAbout(c.specs);
    if (c.complaint.empty()) {
      EXPECT_EQ(complaint, "");
    } else {
      EXPECT_THAT(complaint, AllOf(HasSubstr(c.complaint), HasSubstr(c.specs.back())));
    }
    ++num_checked;
  }
  EXPECT_EQ(num_checked, 15U);
}

// A claim of so many corners in a row from a pixel on.
ImageOutcome claimOf(int count, double first_px, DetectionReason reason) {
  ImageOutcome outcome;
  outcome.image = "a.png";
  outcome.size = kSize;
  outcome.detection.reason = reason;
  for (int id = 0; id < count; ++id)
    outcome.detection.corners.push_back({.id = id, .pixel = {first_px + 20 * id, 100}});
  return outcome;
}

TEST(BoardSet, SettlesWhichBoardCornersBelongTo) {
  constexpr DetectionReason kFound = DetectionReason::kFound;
  constexpr DetectionReason kPartial = DetectionReason::kPartial;
  struct Case {
    std::vector<std::string> specs;
    DetectionReason first;
    DetectionReason second;
    double second_px;  // where the second board's corners begin; those of the first begin at 10
    bool is_first_kept;
    bool is_second_kept;
  };
  const std::vector<std::string> kPlain = {"checkerboard:9x6:25mm", "checkerboard:7x5:25mm"};
  const std::vector<std::string> kMarked = {"checkerboard:9x6:25mm", "charuco:8x11:24mm:18mm:DICT_4X4_250"};
  const std::vector<Case> cases = {
      {kPlain, kFound, kFound, 900, true, true},     {kPlain, kFound, kPartial, 11, true, false},
      {kPlain, kPartial, kFound, 11, false, true},   {kPlain, kPartial, kPartial, 11, false, false},
      {kPlain, kPartial, kPartial, 18, true, true},   // between the others
      {kPlain, kPartial, kPartial, 150, true, true},  // three in common
      {kMarked, kFound, kPartial, 11, false, true},
  };
  std::size_t num_checked = 0;
  for (const Case& c : cases) {
    SCOPED_TRACE(num_checked);
    const std::vector<Board> boards = boardsOf(c.specs);
    std::vector<std::vector<ImageOutcome>> outcomes = {{claimOf(10, 10, c.first)},
                                                       {claimOf(10, c.second_px, c.second)}};
    settleClaims(boards, outcomes);
    EXPECT_EQ(outcomes[0][0].detection.hasCorners(), c.is_first_kept);
    EXPECT_EQ(outcomes[1][0].detection.hasCorners(), c.is_second_kept);
    for (std::size_t b = 0; b < 2; ++b) {
      const Detection& detection = outcomes[b][0].detection;
      if (detection.hasCorners()) continue;
      EXPECT_EQ(detection.reason, DetectionReason::kUnplaced);
      EXPECT_THAT(detection.detail, HasSubstr(boards[1 - b].spec()));
      EXPECT_TRUE(detection.corners.empty());
    }
    ++num_checked;
  }
  EXPECT_EQ(num_checked, cases.size());
}

// One image of two boards, side by side, as two renderings of its halves.
struct TwoBoardImage {
  std::vector<Board> boards;
  GrayImage image;
  std::vector<View> truth;
};

TwoBoardImage renderSideBySide(const std::vector<std::string>& specs) {
  TwoBoardImage two{.boards = boardsOf(specs), .image = {}, .truth = {}};
  const AnyCamera camera = AnyCamera::make(
      "radtan", std::vector<double>{1000, 1000, 639.5, 319.5, -0.1, 0.03, 0.0005, -0.0003, 0});
  const Renderer renderer(camera, kSize);
  RenderOptions light;
  light.blur_px = 1;
  light.read_noise = 2;
  light.full_well_electrons = 0;
  light.falloff = 0;
  light.samples = 144;
  const int half = kSize.width / 2;
  for (std::size_t b = 0; b < 2; ++b) {
    const Board& board = two.boards[b];
    const SO3 rotation = SO3::exp(Eigen::Vector3d(0.3, b == 0 ? -0.2 : 0.25, 0.1));
    // As large as half of the image allows.
    const double distance_m =
        1000 * 1.35 * std::max(board.span().x() / half, board.span().y() / kSize.height);
    const Eigen::Vector3d middle = distance_m * Eigen::Vector3d(b == 0 ? -0.32 : 0.32, 0, 1);
    const SE3 pose{rotation, middle - rotation * board.middle()};
    const GrayImage rendered = renderer.render(inkOf(board), pose, light);
    if (b == 0) two.image = rendered;
    for (int y = 0; y < kSize.height && b == 1; ++y) {
      const auto row = static_cast<std::ptrdiff_t>(y) * kSize.width;
      std::copy_n(rendered.pixels.begin() + row + half, half, two.image.pixels.begin() + row + half);
    }
    two.truth.push_back(exactView(camera, kSize, board, pose, "both"));
  }
  return two;
}

TEST(BoardSet, FindsTwoBoardsInOneImage) {
  const std::vector<std::vector<std::string>> pairs = {
      {"checkerboard:9x6:25mm", "checkerboard:7x5:30mm"},
      {"charuco:7x6:30mm:22mm:DICT_4X4_50", "aprilgrid:4x4:40mm:0.3:200"},
      {"checkerboard:9x6:25mm", "charuco:7x6:30mm:22mm:DICT_5X5_50"},
  };
  std::size_t num_corners = 0;
  for (const auto& specs : pairs) {
    SCOPED_TRACE(specs[0] + " and " + specs[1]);
    const TwoBoardImage two = renderSideBySide(specs);
    const std::vector<std::string> names = {"both"};
    std::size_t num_loads = 0;
    const auto load = [&](const std::string&) {
      ++num_loads;
      return LoadedImage{.image = two.image};
    };
    DetectImagesOptions options;
    options.num_jobs = 1;
    RasterImage drawing;
    options.inspect = [&](const GrayImage& image, std::span<const ImageOutcome> outcomes) {
      drawing = drawDetections(image, outcomes, two.boards);
    };
    auto outcomes = detectInImages(ImageSet(names, load), two.boards, options);
    settleClaims(two.boards, outcomes);
    EXPECT_EQ(num_loads, 1U) << "each image is loaded once";
    EXPECT_EQ(drawing.size, kSize);
    for (std::size_t b = 0; b < 2; ++b) {
      const Detection& detection = outcomes[b].front().detection;
      EXPECT_EQ(detection.reason, DetectionReason::kFound)
          << reasonCode(detection.reason) << " " << detection.detail;
      ASSERT_EQ(detection.corners.size(), two.truth[b].corners.size());
      for (std::size_t i = 0; i < detection.corners.size(); ++i) {
        EXPECT_EQ(detection.corners[i].id, two.truth[b].corners[i].id);
        EXPECT_LT((detection.corners[i].pixel - two.truth[b].corners[i].pixel).norm(), 0.2);
        ++num_corners;
      }
    }
  }
  EXPECT_EQ(num_corners, 54U + 35 + 30 + 64 + 54 + 30);
}

TEST(BoardSet, IsSurveyedTogether) {
  const TwoBoardImage two = renderSideBySide({"checkerboard:9x6:25mm", "checkerboard:7x5:30mm"});
  const ScratchFolder scratch;
  const int half = kSize.width / 2;
  // The left half, the whole image, and both again as copies of a smaller image.
  RasterImage whole{.size = kSize, .num_channels = 1, .bytes = two.image.pixels};
  RasterImage left{.size = {half, kSize.height}, .num_channels = 1, .bytes = {}};
  for (int y = 0; y < kSize.height; ++y) {
    const auto row = two.image.pixels.begin() + static_cast<std::ptrdiff_t>(y) * kSize.width;
    left.bytes.insert(left.bytes.end(), row, row + half);
  }
  const std::vector<std::string> paths = {scratch.path("a.png"), scratch.path("b.png"),
                                          scratch.path("left.png")};
  writeImage(paths[0], whole);
  writeImage(paths[1], whole);
  writeImage(paths[2], left);
  const std::vector<BoardSurvey> surveys = surveyImages(paths, two.boards);
  ASSERT_EQ(surveys.size(), 2U);
  for (std::size_t b = 0; b < 2; ++b) {
    const BoardSurvey& survey = surveys[b];
    EXPECT_EQ(survey.board, two.boards[b]);
    EXPECT_EQ(survey.outcomes[0].detection.reason, DetectionReason::kFound);
    EXPECT_EQ(survey.outcomes[1].detection.reason, DetectionReason::kDuplicate);
    EXPECT_EQ(survey.outcomes[2].detection.reason, DetectionReason::kOtherSize)
        << "by the images of both boards";
    ASSERT_EQ(survey.views().size(), 1U);
    EXPECT_EQ(survey.views()[0].board, b);
    EXPECT_EQ(survey.views()[0].image, "a.png");
    for (const Diagnosis& note : survey.notes)
      EXPECT_NE(note.id, "other_board") << "the other one is among those that were asked for";
  }
  EXPECT_EQ(surveys[0].notes.size(), 1U) << "the sizes are noted once";
}

}  // namespace
}  // namespace alidade
