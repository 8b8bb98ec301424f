// SPDX-License-Identifier: MIT
#include "alidade/detect/survey.h"

#include <gmock/gmock.h>

#include "alidade/detect/draw_detection.h"
#include "support/image_sizes.h"
#include "support/source_tree.h"

namespace alidade {
namespace {

using testing::HasSubstr;

const Checkerboard kSurveyBoard{.columns = 9, .rows = 6, .square_m = 0.025};

ImageOutcome found(const std::string& name, double shift, bool is_closed = true) {
  ImageOutcome outcome;
  outcome.image = name;
  outcome.size = kVga;
  outcome.detection.reason = DetectionReason::kFound;
  for (int id = 0; id < 54; ++id) {
    Corner corner;
    corner.id = id;
    corner.pixel = {40.0 * (id % 9) + shift, 40.0 * (id / 9) + 7};
    corner.sigma_px = 0.02;
    outcome.detection.corners.push_back(corner);
  }
  outcome.detection.seen = SeenGrid{.columns = 9, .rows = 6, .num_corners = 54, .is_closed = is_closed};
  return outcome;
}

ImageOutcome seen(int columns, int rows, bool is_closed,
                  DetectionReason reason = DetectionReason::kOtherBoard) {
  ImageOutcome outcome;
  outcome.image = "other";
  outcome.size = kVga;
  outcome.detection.reason = reason;
  outcome.detection.seen =
      SeenGrid{.columns = columns, .rows = rows, .num_corners = columns * rows, .is_closed = is_closed};
  return outcome;
}

std::vector<Diagnosis> triaged(std::vector<ImageOutcome>& outcomes, const Board& board) {
  std::vector<BoardSurvey> surveys = {
      {.board = board, .paths = {}, .outcomes = std::move(outcomes), .notes = {}}};
  triage(surveys);
  outcomes = std::move(surveys.front().outcomes);
  return surveys.front().notes;
}

TEST(Triage, KeepsTheFirstOfImagesThatShowTheSame) {
  std::vector<ImageOutcome> outcomes = {found("a", 100), found("b", 160), found("c", 100.2),
                                        found("d", 100.6), found("e", 160)};
  triaged(outcomes, kSurveyBoard);
  EXPECT_TRUE(outcomes[0].detection.hasCorners());
  EXPECT_TRUE(outcomes[1].detection.hasCorners());
  EXPECT_EQ(outcomes[2].detection.reason, DetectionReason::kDuplicate);
  EXPECT_EQ(outcomes[2].detection.detail, "shows the same corners as a");
  EXPECT_TRUE(outcomes[2].detection.corners.empty());
  EXPECT_TRUE(outcomes[3].detection.hasCorners()) << "moved by more than a quarter of a pixel";
  EXPECT_EQ(outcomes[4].detection.detail, "shows the same corners as b");
}

TEST(Triage, KnowsTheSameImageWithoutACornerOrTwo) {
  std::vector<ImageOutcome> outcomes = {found("a", 100), found("b", 100), found("c", 100)};
  std::erase_if(outcomes[1].detection.corners, [](const Corner& corner) { return corner.id < 2; });
  std::erase_if(outcomes[2].detection.corners, [](const Corner& corner) { return corner.id > 50; });
  triaged(outcomes, kSurveyBoard);
  EXPECT_EQ(outcomes[1].detection.reason, DetectionReason::kDuplicate);
  EXPECT_TRUE(outcomes[2].detection.hasCorners());
}

TEST(Triage, RefusesImagesOfAnotherSizeAndSaysSo) {
  std::vector<ImageOutcome> outcomes = {found("a", 100), found("b", 160), found("c", 200)};
  outcomes[1].size = {.width = 641, .height = 480};
  const auto notes = triaged(outcomes, kSurveyBoard);
  EXPECT_EQ(outcomes[1].detection.reason, DetectionReason::kOtherSize);
  EXPECT_THAT(outcomes[1].detection.detail, HasSubstr("641x480"));
  ASSERT_EQ(notes.size(), 1U);
  EXPECT_EQ(notes[0].id, "several_sizes");
  EXPECT_EQ(notes[0].cause, "images of two different sizes were given; only the 2 of 640x480 are used");
}

TEST(Triage, DoubtsPartsWhereMostImagesShowAnotherBoardWhole) {
  std::vector<ImageOutcome> outcomes = {found("a", 100, false), found("b", 160, true), seen(10, 7, true),
                                        seen(10, 7, true), seen(10, 7, true)};
  triaged(outcomes, kSurveyBoard);
  EXPECT_EQ(outcomes[0].detection.reason, DetectionReason::kOtherBoard);
  EXPECT_THAT(outcomes[0].detection.detail, HasSubstr("10x7"));
  EXPECT_TRUE(outcomes[1].detection.hasCorners()) << "its border was seen";

  // A stray image of another board casts no doubt on the others.
  outcomes = {found("a", 100, false), found("b", 160, false), seen(10, 7, true)};
  triaged(outcomes, kSurveyBoard);
  EXPECT_TRUE(outcomes[0].detection.hasCorners() && outcomes[1].detection.hasCorners());
}

TEST(Triage, RefusesASpecWithALineThatNoImageShows) {
  // 9x6 corners of a board given as 10x6, one end unseen: each image alone could be right.
  const Checkerboard asked{.columns = 10, .rows = 6, .square_m = 0.025};
  std::vector<ImageOutcome> outcomes = {found("a", 100, false), found("b", 160, false),
                                        found("c", 220, false), found("d", 280, false)};
  for (ImageOutcome& outcome : outcomes) outcome.detection.reason = DetectionReason::kPartial;
  std::vector<ImageOutcome> with_all = outcomes;
  triaged(outcomes, asked);
  for (const ImageOutcome& outcome : outcomes) {
    EXPECT_EQ(outcome.detection.reason, DetectionReason::kOtherBoard);
    EXPECT_THAT(outcome.detection.detail, HasSubstr("most show 9x6"));
  }
  const auto hint = diagnoseBoard(outcomes, asked);
  ASSERT_TRUE(hint);
  EXPECT_EQ(hint->columns, 9);

  with_all[2].detection.seen = SeenGrid{.columns = 10, .rows = 6, .num_corners = 60, .is_closed = false};
  triaged(with_all, asked);
  for (const ImageOutcome& outcome : with_all) EXPECT_TRUE(outcome.detection.hasCorners());
}

TEST(Triage, LetsImagesWithoutTheBoardHaveNoSayInTheSize) {
  std::vector<ImageOutcome> outcomes = {found("a", 100), found("b", 160)};
  for (int i = 0; i < 3; ++i) {
    outcomes.emplace_back();
    outcomes.back().image = "noise";
    outcomes.back().size = {.width = 600, .height = 500};
  }
  triaged(outcomes, kSurveyBoard);
  EXPECT_TRUE(outcomes[0].detection.hasCorners() && outcomes[1].detection.hasCorners());
  EXPECT_EQ(outcomes[2].detection.reason, DetectionReason::kOtherSize);
}

TEST(DiagnoseBoard, DoesNotTakeTheBoardAskedForForAnother) {
  std::vector<ImageOutcome> outcomes = {seen(9, 6, true, DetectionReason::kTooSmall),
                                        seen(9, 6, true, DetectionReason::kTooSmall), found("c", 100, false)};
  EXPECT_FALSE(diagnoseBoard(outcomes, kSurveyBoard));
  triaged(outcomes, kSurveyBoard);
  EXPECT_TRUE(outcomes[2].detection.hasCorners());
}

TEST(Triage, NamesImagesThatAreMuchMoreBlurred) {
  std::vector<ImageOutcome> outcomes = {found("a", 100), found("b", 160), found("c", 200)};
  for (ImageOutcome& outcome : outcomes) outcome.detection.measures.blur_px = 0.9;
  EXPECT_TRUE(triaged(outcomes, kSurveyBoard).empty());
  outcomes[1].detection.measures.blur_px = 2.4;
  const auto notes = triaged(outcomes, kSurveyBoard);
  ASSERT_EQ(notes.size(), 1U);
  EXPECT_EQ(notes[0].id, "blurred_images");
  EXPECT_EQ(notes[0].cause, "much more blurred than the others: b");
  EXPECT_TRUE(outcomes[1].detection.hasCorners());
}

TEST(DiagnoseBoard, PrefersBoardsSeenWhole) {
  EXPECT_FALSE(diagnoseBoard(std::vector<ImageOutcome>{found("a", 100)}, kSurveyBoard));
  const auto hint =
      diagnoseBoard(std::vector<ImageOutcome>{seen(8, 5, false), seen(8, 5, false), seen(8, 5, false),
                                              seen(13, 12, true), seen(13, 12, true)},
                    kSurveyBoard);
  ASSERT_TRUE(hint);
  EXPECT_EQ(hint->columns, 13);
  EXPECT_EQ(hint->rows, 12);
  EXPECT_EQ(hint->num_images, 2);
  EXPECT_TRUE(hint->is_closed);
}

TEST(HintText, NamesTheLikelySlipAndTheSpecInTheOrderAsked) {
  const BoardHint hint{.columns = 13, .rows = 12, .num_images = 12, .is_closed = true};
  EXPECT_THAT(
      hintText(hint, Checkerboard{.columns = 14, .rows = 13, .square_m = 0.025}),
      HasSubstr("12 images show 13x12 inner corners; did you count squares? Use checkerboard:13x12:25mm"));
  EXPECT_THAT(hintText(hint, Checkerboard{.columns = 13, .rows = 14, .square_m = 0.025}),
              HasSubstr("12x13 inner corners; did you count squares? Use checkerboard:12x13:25mm"));
  EXPECT_THAT(hintText(hint, Checkerboard{.columns = 12, .rows = 11, .square_m = 0.025}),
              HasSubstr("did you miss one line"));
  const BoardHint part{.columns = 7, .rows = 5, .num_images = 1, .is_closed = false};
  EXPECT_THAT(hintText(part, kSurveyBoard), HasSubstr("1 image shows at least 7x5"));
}

TEST(SurveyDiagnosis, NamesImagesWithoutTheWholeBoard) {
  ImageOutcome outcome;
  outcome.image = "a.png";
  outcome.detection.reason = DetectionReason::kFound;
  EXPECT_FALSE(diagnosisOf(outcome));
  outcome.detection.reason = DetectionReason::kPartial;
  outcome.detection.detail = "50 of 54 corners";
  EXPECT_EQ(diagnosisOf(outcome)->severity, Severity::kNote);
  outcome.detection.reason = DetectionReason::kBlurred;
  EXPECT_EQ(diagnosisOf(outcome)->severity, Severity::kWarning);
  EXPECT_EQ(diagnosisOf(outcome)->id, "blurred");
  EXPECT_EQ(diagnosisOf(outcome)->message(), "a.png: 50 of 54 corners");
}

TEST(SurveyDiagnosis, SaysHowAnAmbiguousBoardCanBeTurned) {
  const auto text = [](int columns, int rows) {
    return ambiguityOf(Checkerboard{.columns = columns, .rows = rows, .square_m = 0.02}).cause;
  };
  EXPECT_THAT(text(8, 6), HasSubstr("a rotation by 180 degrees"));
  EXPECT_THAT(text(7, 7), HasSubstr("a rotation by 180 degrees"));
  EXPECT_THAT(text(6, 6), HasSubstr("90, 180 or 270"));
}

TEST(SurveyImages, KeepsAnOutcomeForEachImageAndNotesWhatItSaw) {
  const std::string folder = sourcePath("testdata/checkerboard/images/");
  const std::vector<std::string> paths = {folder + "view_001.png", folder + "missing.png",
                                          folder + "view_001.png"};
  const BoardSurvey survey = surveyImages(paths, kSurveyBoard);
  ASSERT_EQ(survey.outcomes.size(), 3U);
  EXPECT_EQ(survey.paths, paths);
  EXPECT_EQ(survey.outcomes[0].image, "view_001.png");
  EXPECT_EQ(survey.outcomes[0].detection.reason, DetectionReason::kFound);
  EXPECT_EQ(survey.outcomes[1].detection.reason, DetectionReason::kUnreadable);
  EXPECT_EQ(survey.outcomes[2].detection.reason, DetectionReason::kDuplicate);
  EXPECT_EQ(survey.outcomes[2].detection.detail, "shows the same corners as view_001.png");
  EXPECT_EQ(survey.numFound(), 1U);
  EXPECT_EQ(survey.numWhole(), 1U);
  ASSERT_EQ(survey.views().size(), 1U);
  EXPECT_EQ(survey.views()[0].corners.size(), 54U);
  EXPECT_TRUE(survey.notes.empty());
}

TEST(DrawDetection, MarksCornersInColourAndLeavesTheImageSize) {
  const GrayImage image{.size = kVga, .pixels = std::vector<std::uint8_t>(640 * 480, 90)};
  const std::vector<Board> boards = {kSurveyBoard};
  const RasterImage plain = drawDetections(image, std::vector<ImageOutcome>(1), boards);
  const RasterImage drawn = drawDetections(image, std::vector{found("a", 100)}, boards);
  EXPECT_EQ(drawn.size, kVga);
  ASSERT_EQ(drawn.bytes.size(), 3U * 640 * 480);
  int num_coloured = 0;
  for (std::size_t i = 0; i < drawn.bytes.size(); ++i)
    num_coloured += drawn.bytes[i] != plain.bytes[i] ? 1 : 0;
  EXPECT_GT(num_coloured, 54 * 40);
}

}  // namespace
}  // namespace alidade
