// SPDX-License-Identifier: MIT
#include "alidade/core/number_text.h"

#include <gmock/gmock.h>

#include "alidade/core/diagnosis_order.h"

namespace alidade {
namespace {

TEST(PercentText, SaysAllAndNothingOnlyOfExactlyThat) {
  EXPECT_EQ(percentText(1), "100 %");
  EXPECT_EQ(percentText(0.9958), "> 99 %");
  EXPECT_EQ(percentText(0.99999), "> 99 %");
  EXPECT_EQ(percentText(0.99), "99 %");
  EXPECT_EQ(percentText(0.0149), "1 %");
  EXPECT_EQ(percentText(0.0099), "< 1 %");
  EXPECT_EQ(percentText(1e-9), "< 1 %");
  EXPECT_EQ(percentText(0), "0 %");
}

TEST(NumberText, NeedsNoExponentForWhatPeopleMeasure) {
  EXPECT_EQ(numberText("%.2g", 113.4), "110");
  EXPECT_EQ(numberText("%.2g", 0.0683), "0.068");
  EXPECT_EQ(numberText("%.3g", 4332.5), "4330");
  EXPECT_EQ(numberText("%.2g", -1234), "-1200");
  EXPECT_EQ(numberText("%.1g", 1.3e17), "1e+17");
  EXPECT_EQ(numberText("%.4f", 1234.5), "1234.5000");
}

TEST(SortDiagnoses, PutsCausesBeforeWhatFollowsFromThem) {
  std::vector<Diagnosis> diagnoses = {{.severity = Severity::kWarning, .id = "poor_coverage", .cause = ""},
                                      {.severity = Severity::kFailure, .id = "inaccurate", .cause = ""},
                                      {.severity = Severity::kWarning, .id = "odd_aspect", .cause = ""},
                                      {.severity = Severity::kFailure, .id = "folds_in_image", .cause = ""},
                                      {.severity = Severity::kFailure, .id = "two_cameras", .cause = ""}};
  sortDiagnoses(diagnoses);
  std::vector<std::string> ids;
  for (const Diagnosis& diagnosis : diagnoses) ids.push_back(diagnosis.id);
  EXPECT_THAT(ids, testing::ElementsAre("two_cameras", "folds_in_image", "inaccurate", "odd_aspect",
                                        "poor_coverage"));
}

}  // namespace
}  // namespace alidade
