// SPDX-License-Identifier: MIT
#include "alidade/validate/footage/footage_judgement.h"

#include <gmock/gmock.h>

namespace alidade {
namespace {

using ::testing::AllOf;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::StartsWith;

std::vector<std::string> flagsBetween(ImageSize from, ImageSize to) {
  std::vector<std::string> flags;
  for (const ConversionRequest& edit : editsBetween(from, to)) flags.push_back(editFlags(edit));
  return flags;
}

TEST(FootageEdits, AreThoseThatMakeTheSize) {
  EXPECT_TRUE(editsBetween({640, 480}, {640, 480}).empty());
  EXPECT_THAT(flagsBetween({640, 480}, {320, 240}),
              ElementsAre("--resize 320x240", "--crop 160,120,320,240"));
  EXPECT_THAT(flagsBetween({640, 480}, {1280, 960}), ElementsAre("--resize 1280x960"));
  EXPECT_THAT(flagsBetween({640, 480}, {640, 360}), ElementsAre("--crop 0,60,640,360", "--resize 640x360"));
  EXPECT_THAT(flagsBetween({640, 480}, {1280, 720}),
              ElementsAre("--crop 0,60,640,360 --resize 1280x720", "--resize 1280x720"));
  EXPECT_THAT(
      flagsBetween({1920, 1080}, {640, 480}),
      ElementsAre("--crop 640,300,640,480", "--crop 240,0,1440,1080 --resize 640x480", "--resize 640x480"));
  // A side may be rounded: 1000x667 is half of 2000x1333.
  EXPECT_THAT(flagsBetween({2000, 1333}, {1000, 667}),
              ElementsAre("--resize 1000x667", "--crop 500,333,1000,667"));
  EXPECT_THAT(flagsBetween({640, 480}, {480, 640}), ElementsAre("--rotate 90", "--rotate 270"));
  EXPECT_THAT(flagsBetween({640, 480}, {240, 320}),
              ElementsAre("--resize 320x240 --rotate 90", "--resize 320x240 --rotate 270",
                          "--crop 160,120,320,240 --rotate 90", "--crop 160,120,320,240 --rotate 270",
                          "--crop 200,80,240,320"));
}

// What is named in words and in flags is what the edit does.
TEST(FootageEdits, MakeTheSizeTheyAreFor) {
  const AnyCamera camera = AnyCamera::make("pinhole", std::vector<double>{500, 500, 319.5, 239.5});
  int num_edits = 0;
  for (const ImageSize to : {ImageSize{320, 240}, ImageSize{240, 320}, ImageSize{333, 777}, ImageSize{1, 1},
                             ImageSize{640, 360}, ImageSize{1280, 720}, ImageSize{4000, 100}}) {
    for (const ConversionRequest& edit : editsBetween({640, 480}, to)) {
      EXPECT_EQ(convertCamera({.camera = camera, .image_size = {640, 480}}, edit).edit.size, to)
          << editFlags(edit);
      EXPECT_EQ(editWords(edit).empty(), editFlags(edit).empty());
      ++num_edits;
    }
  }
  EXPECT_EQ(num_edits, 2 + 5 + 4 + 2 + 2 + 2 + 2);
}

CameraRecord radtanRecord() {
  return {.camera = AnyCamera::make("radtan", std::vector<double>{500, 500, 320, 240, -0.2, 0.03, 0, 0, 0}),
          .image_size = {640, 480}};
}

CameraChange changeOf(CameraChangeKind kind, double amount, double std) {
  CameraChange change{{.kind = kind, .amounts = {amount, amount}, .std = {std, std}}, radtanRecord().camera};
  change.effect_px = 9.81;
  change.sure_px = 9.2;
  change.blind_px = 0.7;
  return change;
}

FootageJudgement judgementWith(const CameraChange& change) {
  FootageJudgement judgement{
      .camera_size = {640, 480}, .image_size = {640, 480}, .num_frames_given = 30, .check = {}};
  judgement.check.changes = {change};
  judgement.check.explanation = 0;
  judgement.check.verdict = FootageVerdict::kInconsistent;
  return judgement;
}

Diagnosis firstFinding(const FootageJudgement& judgement) {
  return footageFindings(judgement, radtanRecord(), "cam.yaml").at(0);
}

TEST(FootageFindings, NameTheChangeAndItsLikelyCause) {
  const Diagnosis found = firstFinding(judgementWith(changeOf(CameraChangeKind::kFocalLength, 0.031, 0.002)));
  EXPECT_EQ(found.severity, Severity::kFailure);
  EXPECT_EQ(found.cause,
            "inconsistent: focal length +3.1 % +- 0.2 % explains the footage; displaces points by 9.8 px");
  EXPECT_THAT(found.next_step, AllOf(HasSubstr("zoom"), HasSubstr("focus"), HasSubstr("cropped and scaled")));
  const auto causeOf = [](CameraChangeKind kind, double amount, double std) {
    return likelyCause(changeOf(kind, amount, std), radtanRecord().camera);
  };
  EXPECT_THAT(causeOf(CameraChangeKind::kAspect, 0.1, 0.01), HasSubstr("stretched"));
  EXPECT_THAT(causeOf(CameraChangeKind::kPrincipalPoint, 20, 1),
              AllOf(HasSubstr("cropped off"), HasSubstr("stab")));
  EXPECT_THAT(causeOf(CameraChangeKind::kDistortion, -0.98, 0.02), HasSubstr("already undistorted"));
  EXPECT_THAT(causeOf(CameraChangeKind::kDistortion, -0.5, 0.02), HasSubstr("another lens"));
  EXPECT_THAT(causeOf(CameraChangeKind::kFirstRadial, -0.1, 0.02), HasSubstr("another lens"));
  EXPECT_THAT(causeOf(CameraChangeKind::kSeveral, 0, 0), HasSubstr("another camera or lens"));
  const AnyCamera bare = AnyCamera::make("radtan", std::vector<double>{500, 500, 320, 240, 0, 0, 0, 0, 0});
  EXPECT_THAT(likelyCause(changeOf(CameraChangeKind::kFirstRadial, -0.1, 0.02), bare),
              HasSubstr("no distortion"));
}

TEST(FootageFindings, SayWhichFootageWouldTell) {
  FootageJudgement judgement{
      .camera_size = {640, 480}, .image_size = {640, 480}, .num_frames_given = 30, .check = {}};
  struct Case {
    FootageGap gap;
    const char* words;
  };
  int num_cases = 0;
  for (const Case& c :
       {Case{FootageGap::kFewPoints, "full of detail"}, Case{FootageGap::kNoMotion, "move the camera"},
        Case{FootageGap::kNoParallax, "no parallax; film while moving sideways past near and far"},
        Case{FootageGap::kMovingScene, "in which nothing moves"},
        Case{FootageGap::kFewFrames, "fewer than five images"},
        Case{FootageGap::kUnsolved, "could not be computed"},
        Case{FootageGap::kShutter, "more slowly than any camera"},
        Case{FootageGap::kWeak, "an error of 14 px would go unnoticed"}}) {
    judgement.check.gap = c.gap;
    judgement.check.blind_px = 14.2;
    const Diagnosis found = firstFinding(judgement);
    EXPECT_EQ(found.severity, Severity::kWarning);
    EXPECT_TRUE(found.is_undecided);
    EXPECT_THAT(found.cause, AllOf(StartsWith("cannot tell: "), HasSubstr(c.words)));
    ++num_cases;
  }
  EXPECT_EQ(num_cases, 8);
}

TEST(FootageFindings, NoteWhatIsNotEnoughToFail) {
  FootageJudgement judgement = judgementWith(changeOf(CameraChangeKind::kFocalLength, 0.004, 0.001));
  judgement.check.verdict = FootageVerdict::kConsistent;
  judgement.check.blind_px = 1.23;
  judgement.check.is_video = true;
  judgement.check.readout = 0.42;
  const std::vector<Diagnosis> found = footageFindings(judgement, radtanRecord(), "cam.yaml");
  ASSERT_EQ(found.size(), 3U);
  EXPECT_EQ(found[0].severity, Severity::kPass);
  EXPECT_EQ(found[0].cause, "consistent: no error that counts; one below 1.2 px would go unnoticed");
  EXPECT_EQ(found[1].id, "footage_fit");
  EXPECT_EQ(found[1].severity, Severity::kNote);
  EXPECT_THAT(found[1].cause, StartsWith("focal length +0.4 % +- 0.1 % fits better"));
  EXPECT_EQ(found[2].id, "footage_shutter");
  EXPECT_THAT(found[2].cause, HasSubstr("0.42 of the time between frames"));
  judgement.check.readout = 0.05;
  EXPECT_EQ(footageFindings(judgement, radtanRecord(), "cam.yaml").size(), 2U);
}

TEST(FootageFindings, TellWhatWasDoneToImagesOfAnotherSize) {
  FootageJudgement judgement{
      .camera_size = {640, 480}, .image_size = {320, 240}, .num_frames_given = 30, .check = {}};
  for (const ConversionRequest& edit : editsBetween(judgement.camera_size, judgement.image_size)) {
    judgement.edits.push_back({.request = edit, .check = {}});
    judgement.edits.back().check.verdict = FootageVerdict::kInconsistent;
  }
  EXPECT_EQ(judgement.verdict(), FootageVerdict::kInconsistent);
  Diagnosis found = firstFinding(judgement);
  EXPECT_EQ(found.severity, Severity::kFailure);
  EXPECT_THAT(found.cause,
              AllOf(StartsWith("inconsistent: wrong image size"), HasSubstr("neither cropped nor")));

  judgement.edits[0].check.verdict = judgement.edits[1].check.verdict = FootageVerdict::kCannotTell;
  found = firstFinding(judgement);
  EXPECT_EQ(found.severity, Severity::kFailure);
  EXPECT_THAT(found.cause,
              AllOf(StartsWith("inconsistent: wrong image size"), HasSubstr("cannot tell what was done")));
  EXPECT_THAT(found.next_step, HasSubstr("--resize 320x240, or --crop 160,120,320,240"));

  judgement.edits[0].check.verdict = FootageVerdict::kConsistent;
  found = firstFinding(judgement);
  EXPECT_EQ(
      found.cause,
      "inconsistent: image resized without the file; the images have 320x240 px, the file is for 640x480");
  EXPECT_EQ(found.next_step, "alidade convert cam.yaml -o OUT --resize 320x240");
  judgement.edits[1].check.verdict = FootageVerdict::kConsistent;
  EXPECT_THAT(firstFinding(judgement).next_step, HasSubstr("; --crop 160,120,320,240 is consistent too"));
}

}  // namespace
}  // namespace alidade
