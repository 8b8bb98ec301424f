// SPDX-License-Identifier: MIT
#include <algorithm>

#include <gtest/gtest.h>

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
