// SPDX-License-Identifier: MIT
#include <algorithm>
#include <cmath>

#include <gmock/gmock.h>

#include "alidade/core/error.h"
#include "support/answer.h"
#include "support/flawed_set.h"
#include "support/verdict_case.h"

namespace alidade {
namespace {

std::string idsOf(const Calibration& result) {
  std::string ids;
  for (const Diagnosis& f : result.diagnoses) ids += " " + std::string(f.id);
  return ids;
}

// bench/verdict_bench has the same in hundreds.
TEST(Verdict, NamesWhatIsWrong) {
  int num_sets = 0;
  for (const Flaw flaw : kFlaws) {
    if (flaw == Flaw::kNone) continue;
    const std::vector<DiagnosisId> expected = findingsFor(flaw);
    for (const char* model : {"radtan", "kannala_brandt"}) {
      for (std::uint64_t number = 0; number < 2; ++number) {
        const VerdictCase c = makeVerdictCase(flaw, model, number);
        const Calibration result = calibrate(c.set.board, c.set.views, c.options);
        // A view that was left out does no harm any more, and a lens may deviate by little.
        const bool is_harmless = flaw == Flaw::kSwappedImage || flaw == Flaw::kTooLean;
        const Severity least = is_harmless ? Severity::kNote : Severity::kWarning;
        if (least == Severity::kWarning) {
          EXPECT_NE(result.verdict(), Verdict::kTrustworthy)
              << flawName(flaw) << " " << model << " " << number;
        }
        EXPECT_TRUE(std::any_of(result.diagnoses.begin(), result.diagnoses.end(),
                                [&](const Diagnosis& f) {
                                  return f.severity >= least &&
                                         std::find(expected.begin(), expected.end(), f.id) != expected.end();
                                }))
            << flawName(flaw) << " " << model << " " << number << ":" << idsOf(result);
        ++num_sets;
      }
    }
  }
  EXPECT_EQ(num_sets, 44);
}

TEST(Verdict, HasNothingAgainstGoodSets) {
  int num_sets = 0;
  int num_trusted = 0;
  std::string ids;
  for (const char* model : {"radtan", "kannala_brandt"}) {
    for (std::uint64_t number = 0; number < 10; ++number) {
      const VerdictCase c = makeVerdictCase(Flaw::kNone, model, number);
      const Calibration result = calibrate(c.set.board, c.set.views, c.options);
      ++num_sets;
      num_trusted += result.verdict() == Verdict::kTrustworthy ? 1 : 0;
      if (result.verdict() != Verdict::kTrustworthy) ids += idsOf(result);
    }
  }
  EXPECT_EQ(num_sets, 20);
  EXPECT_GE(num_trusted, 19) << ids;
}

// Flaws that made the first edition call cameras trustworthy that were pixels off. bench/answer_bench has
// more kinds, in hundreds.
TEST(Verdict, TrustsNoCameraThatIsWrong) {
  const std::vector<std::string_view> names = {"graded",      "breathing", "two_cameras",
                                               "zoom_midway", "middle",    "few_places"};
  int num_sets = 0;
  for (const FlawKind& kind : flawKinds()) {
    if (std::ranges::find(names, kind.name) == names.end()) continue;
    for (const char* model : {"radtan", "kannala_brandt"}) {
      for (std::uint64_t number = 0; number < 2; ++number) {
        const FlawedSet flawed = drawFlawedSet(kind, model, streamSeed(77, number));
        const Answer answer = answerOf(flawed.set.board, flawed.set.views, {}, flawed.drawn.camera);
        EXPECT_FALSE(answer.verdict == Verdict::kTrustworthy && answer.p95_px > kTolerancePx)
            << kind.name << " " << model << " " << number << ": " << answer.p95_px << " px";
        ++num_sets;
      }
    }
  }
  EXPECT_EQ(num_sets, 24);
}

// With frontal views, whose images were stretched as well, all that could be said of pixels and board follows
// from a focal length that nobody knows.
TEST(Verdict, SaysFirstThatTheFocalLengthIsUnknown) {
  int num_sets = 0;
  int num_notes = 0;
  for (const char* model : {"radtan", "kannala_brandt"}) {
    for (std::uint64_t number = 0; number < 10; ++number) {
      VerdictCase c = makeVerdictCase(Flaw::kFrontoParallel, model, number);
      for (View& view : c.set.views) {
        for (Corner& corner : view.corners) corner.pixel.x() *= 1.06;
        view.size.width = static_cast<int>(1.06 * view.size.width) + 1;
      }
      const Calibration result = calibrate(c.set.board, c.set.views, c.options);
      const auto unknown = std::ranges::find_if(result.diagnoses, [](const Diagnosis& d) {
        return d.severity == Severity::kFailure && (d.id == "fronto_parallel" || d.id == "focal_uncertain");
      });
      if (unknown == result.diagnoses.end()) continue;
      ++num_sets;
      EXPECT_EQ(result.diagnoses.front().id, unknown->id) << idsOf(result);
      for (const Diagnosis& d : result.diagnoses) {
        if (!d.id.kind().needs_focal) continue;
        ++num_notes;
        EXPECT_EQ(d.severity, Severity::kNote) << d.id;
      }
    }
  }
  EXPECT_EQ(num_sets, 13);  // the others happen to determine it to 2 %
  EXPECT_GE(num_notes, 13);
}

// A lens that focuses on each board, calibrated with a model of more parameters than it determines: the step
// to the camera without the error is then poorly determined too, and once counted as none.
TEST(Verdict, TrustsNoBreathingLensWhoseModelIsUndetermined) {
  int num_sets = 0;
  const AnyCamera camera = AnyCamera::make("pinhole", std::vector<double>{1000, 1000, 640, 480});
  for (std::uint64_t number = 1; number <= 8; ++number) {
    SimulatedSet set = simulateSet(camera, {.width = 1280, .height = 960}, 20, 0.05, number);
    for (std::size_t v = 0; v < set.views.size(); ++v) {
      const double distance_m = (set.poses[v] * set.board.middle()).norm();
      for (Corner& corner : set.views[v].corners)
        corner.pixel += 0.004 / distance_m * (corner.pixel - Eigen::Vector2d(640, 480));
    }
    const Calibration result = calibrate(set.board, set.views, {.model = "double_sphere"});
    EXPECT_NE(result.verdict(), Verdict::kTrustworthy) << number;
    ++num_sets;
  }
  EXPECT_EQ(num_sets, 8);
}

// Frames of a video of a board that moves slowly, sheared by about a pixel each.
const std::vector<double> kShearedTruth = {1003, 1001, 645, 475, -0.28, 0.08, 8e-4, -4e-4, -0.01};
Calibration calibrationOfSheared(std::uint64_t number, double alike, double tolerance_px = 1) {
  constexpr double kShear = 1e-3;
  constexpr int kPlaces = 20;
  constexpr int kFramesEach = 4;
  const AnyCamera camera = AnyCamera::make("radtan", kShearedTruth);
  const ImageSize size{.width = 1280, .height = 960};
  const SimulatedSet set = simulateSet(camera, size, kPlaces, 0, number);
  Random random(streamSeed(91, number));
  double shear = random.normal();
  std::vector<View> frames;
  for (SE3 pose : set.poses) {
    for (int i = 0; i < kFramesEach; ++i) {
      frames.push_back(exactView(camera, size, set.board, pose, "frame_" + std::to_string(frames.size())));
      addCornerNoise(frames.back(), 0.05, random);
      for (Corner& corner : frames.back().corners)
        corner.pixel.x() += kShear * shear * (corner.pixel.y() - 0.5 * size.height);
      shear = alike * shear + std::sqrt(1 - alike * alike) * random.normal();
      pose.translation += Eigen::Vector3d(0.003, 0.002, 0.004);
    }
  }
  return calibrate(set.board, frames, {.model = "radtan", .tolerance_px = tolerance_px});
}

const Diagnosis* findingOf(const Calibration& result, const char* id) {
  const auto found = std::ranges::find(result.diagnoses, DiagnosisId::read(id), &Diagnosis::id);
  return found != result.diagnoses.end() ? &*found : nullptr;
}

TEST(Verdict, NamesFramesOfAVideoThatShareTheirErrors) {
  constexpr int kSets = 20;
  int num_named = 0;
  int num_covered = 0;
  int num_wrongly = 0;
  for (std::uint64_t number = 0; number < kSets; ++number) {
    const Calibration video = calibrationOfSheared(number, 0.9);
    num_named += findingOf(video, "correlated_views") != nullptr ? 1 : 0;
    const double off = std::abs(onlyCamera(video.fit).params[0] - kShearedTruth[0]);
    num_covered += off < 2 * video.uncertainty.parameterStd(0) ? 1 : 0;
    num_wrongly += findingOf(calibrationOfSheared(number, 0), "correlated_views") != nullptr ? 1 : 0;
  }
  EXPECT_GE(num_named, 17);  // in three, neighbours are alike by less than three standard deviations
  EXPECT_GE(num_covered, 18);
  EXPECT_EQ(num_wrongly, 0);
}

TEST(Verdict, SaysOfAnInaccurateVideoWhatBettersIt) {
  int num_videos = 0;
  int num_photographs = 0;
  for (std::uint64_t number = 0; number < 4; ++number) {
    const Calibration video = calibrationOfSheared(number, 0.9, 0.02);
    const Diagnosis* const inaccurate = findingOf(video, "inaccurate");
    const Diagnosis* const correlated = findingOf(video, "correlated_views");
    ASSERT_NE(inaccurate, nullptr) << number;
    if (correlated == nullptr) continue;
    EXPECT_EQ(inaccurate->next_step, correlated->next_step);
    ++num_videos;
    const Calibration photographs = calibrationOfSheared(number, 0, 0.02);
    const Diagnosis* const other = findingOf(photographs, "inaccurate");
    if (other == nullptr) continue;
    EXPECT_THAT(other->next_step, testing::HasSubstr("15 to 30 sharp views"));
    ++num_photographs;
  }
  EXPECT_GE(num_videos, 3);
  EXPECT_GE(num_photographs, 1);
}

TEST(Verdict, TheWorstFindingDecides) {
  const Diagnosis note{
      .id = "outliers", .severity = Severity::kNote, .cause = "", .evidence = "", .next_step = ""};
  Diagnosis warning = note;
  warning.severity = Severity::kWarning;
  Diagnosis failure = note;
  failure.severity = Severity::kFailure;
  using Findings = std::vector<Diagnosis>;
  EXPECT_EQ(verdictOf(Findings{}), Verdict::kTrustworthy);
  EXPECT_EQ(verdictOf(Findings{note}), Verdict::kTrustworthy);
  EXPECT_EQ(verdictOf(Findings{note, warning}), Verdict::kReservations);
  EXPECT_EQ(verdictOf(Findings{warning, failure, note}), Verdict::kNo);
  for (const Verdict verdict : {Verdict::kTrustworthy, Verdict::kReservations, Verdict::kNo})
    EXPECT_EQ(verdictOf(verdictName(verdict)), verdict);
  EXPECT_EQ(verdictOf(std::string_view("yes")), std::nullopt);
}

}  // namespace
}  // namespace alidade
