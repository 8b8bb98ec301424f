// SPDX-License-Identifier: MIT
#include "alidade/core/diagnosis.h"

#include <algorithm>
#include <cmath>
#include <fstream>
#include <map>
#include <set>
#include <sstream>

#include <gmock/gmock.h>

#include "support/source_tree.h"

namespace alidade {
namespace {

std::string pageText(const char* name) {
  std::ifstream file(sourcePath(std::string("docs/") + name));
  return {std::istreambuf_iterator<char>(file), {}};
}

// The texts of the rows "| `a`, `b` | text", by id.
std::map<std::string, std::string> rowsOf(const std::string& page) {
  std::map<std::string, std::string> rows;
  std::istringstream lines(page);
  for (std::string line; std::getline(lines, line);) {
    if (!line.starts_with("| `")) continue;
    const std::size_t end = line.find('|', 1);
    for (std::size_t at = line.find('`'); at < end; at = line.find('`', at + 1)) {
      const std::size_t close = line.find('`', at + 1);
      rows[line.substr(at + 1, close - at - 1)] = line.substr(end);
      at = close;
    }
  }
  return rows;
}

TEST(DiagnosisKinds, AreDescribedInTheDocumentation) {
  std::map<std::string, std::string> of_camera = rowsOf(pageText("verdict.md"));
  for (const char* verdict : {"trustworthy", "usable_with_reservations", "rejected"})
    of_camera.erase(verdict);
  std::map<std::string, std::string> of_hand_eye = rowsOf(pageText("handeye.md"));
  std::erase_if(of_hand_eye, [](const auto& row) {
    return !row.first.starts_with("robot_") && !row.first.starts_with("hand_eye_") &&
           !row.first.starts_with("camera_on_f");
  });
  const std::string of_rig = pageText("rigs.md");
  for (const DiagnosisKind& kind : kDiagnosisKinds) {
    if (kind.subject == Subject::kRobot) {
      const auto row = of_hand_eye.find(std::string(kind.id));
      ASSERT_TRUE(row != of_hand_eye.end()) << kind.id;
      const std::string severity =
          kind.severity ? "| " + std::string(severityName(*kind.severity)) + " |" : ", failure |";
      EXPECT_THAT(row->second, testing::HasSubstr(severity)) << kind.id;
      of_hand_eye.erase(row);
      continue;
    }
    if (kind.subject > Subject::kRig) continue;
    const auto row = of_camera.find(std::string(kind.id));
    if (row == of_camera.end()) {
      EXPECT_TRUE(of_rig.find("`" + std::string(kind.id) + "`") != std::string::npos) << kind.id;
      continue;
    }
    if (kind.severity) {
      EXPECT_THAT(row->second, testing::HasSubstr(std::string(severityName(*kind.severity)))) << kind.id;
    }
    of_camera.erase(row);
  }
  EXPECT_THAT(of_camera, testing::IsEmpty()) << "a row of docs/verdict.md is of no diagnosis";
  EXPECT_THAT(of_hand_eye, testing::IsEmpty()) << "a row of docs/handeye.md is of no diagnosis";
}

TEST(DiagnosisKinds, HaveDifferentIds) {
  std::set<std::string_view> ids;
  for (const DiagnosisKind& kind : kDiagnosisKinds) EXPECT_TRUE(ids.insert(kind.id).second) << kind.id;
}

TEST(DiagnosisId, KeepsTheIdsOfOtherVersions) {
  const DiagnosisId known = DiagnosisId::read(std::string("misfit"));
  EXPECT_EQ(known, DiagnosisId("misfit"));
  EXPECT_EQ(known.kind().rank, Rank::kConsequence);
  const DiagnosisId unknown = DiagnosisId::read(std::string("of_the_future"));
  EXPECT_EQ(unknown, "of_the_future");
  EXPECT_EQ(unknown.kind().rank, Rank::kOrdinary);
}

TEST(Diagnosis, HasTheSeverityOfItsEffect) {
  EXPECT_EQ(severityOf(0.24, 1), Severity::kNote);
  EXPECT_EQ(severityOf(0.25, 1), Severity::kWarning);
  EXPECT_EQ(severityOf(5.01, 1), Severity::kFailure);
  EXPECT_EQ(severityOf(NAN, 1), Severity::kNote);
}

TEST(Diagnosis, HasTheSeverityOfItsKind) {
  EXPECT_EQ((Diagnosis{.id = "folds_in_image", .cause = ""}).severity, Severity::kFailure);
  EXPECT_EQ((Diagnosis{.id = "mirrored_view", .cause = ""}).severity, Severity::kNote);
}

TEST(SortDiagnoses, PutsCausesBeforeWhatFollowsFromThem) {
  std::vector<Diagnosis> diagnoses = {{.id = "poor_coverage", .severity = Severity::kWarning, .cause = ""},
                                      {.id = "inaccurate", .severity = Severity::kFailure, .cause = ""},
                                      {.id = "odd_aspect", .severity = Severity::kWarning, .cause = ""},
                                      {.id = "folds_in_image", .severity = Severity::kFailure, .cause = ""},
                                      {.id = "two_cameras", .severity = Severity::kFailure, .cause = ""}};
  sortDiagnoses(diagnoses);
  std::vector<std::string> ids;
  for (const Diagnosis& diagnosis : diagnoses) ids.emplace_back(diagnosis.id);
  EXPECT_THAT(ids, testing::ElementsAre("two_cameras", "folds_in_image", "inaccurate", "odd_aspect",
                                        "poor_coverage"));
}

}  // namespace
}  // namespace alidade
