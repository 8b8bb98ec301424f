// SPDX-License-Identifier: MIT
#include <cmath>
#include <filesystem>
#include <regex>
#include <set>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "apps/command_line.h"
#include "apps/report_page.h"

namespace alidade {
namespace {

using nlohmann::json;
using testing::AllOf;
using testing::HasSubstr;
using testing::Not;

namespace fs = std::filesystem;

// The page of a validation with images and another camera, and what --json says of the same.
struct ValidationMade {
  ScratchFolder scratch;
  std::string page_path = scratch.path("page.html");
  std::vector<std::string> args = {
      "validate", dataPath("camera.yaml"), "--images", dataPath("images"), "--board", kBoardSpec,
      "--against"};
  std::string page;
  json result;

  ValidationMade() {
    args.push_back(scratch.write("other.yaml", smallCamera()));
    std::vector<std::string> with_page = args;
    with_page.insert(with_page.end(), {"--report", page_path});
    EXPECT_THAT(runAlidade(with_page).err, HasSubstr("report written to " + page_path));
    page = readFile(page_path);
    std::vector<std::string> with_json = args;
    with_json.emplace_back("--json");
    result = json::parse(runAlidade(with_json).out);
  }
};

const ValidationMade& validationMade() {
  static const ValidationMade made;
  return made;
}

TEST(ValidationReport, HoldsTheResult) {
  json embedded = embeddedEvidenceOf(validationMade().page);
  EXPECT_EQ(embedded.at("against").at("model"), "pinhole");
  embedded.erase("against");
  embedded.erase("origin");
  json& tested = embedded.at("files").at(0).at("cameras").at(0).at("held_out");
  double sum = 0;
  std::size_t num_corners = 0;
  for (json& view : tested.at("views")) {
    double of_view = 0;
    for (const json& corner : view.at("corners")) {
      of_view += std::pow(corner.at("dx").get<double>(), 2) + std::pow(corner.at("dy").get<double>(), 2);
    }
    const auto count = static_cast<double>(view.at("corners").size());
    EXPECT_NEAR(std::sqrt(of_view / count), view.at("rms_px").get<double>(), 1e-4);
    sum += of_view;
    num_corners += view.at("corners").size();
    view.erase("corners");
  }
  EXPECT_EQ(num_corners, tested.at("num_corners").get<std::size_t>());
  EXPECT_GT(num_corners, 500u);
  EXPECT_NEAR(std::sqrt(sum / static_cast<double>(num_corners)), tested.at("rms_px").get<double>(), 1e-4);
  EXPECT_EQ(embedded, validationMade().result);
}

TEST(ValidationReport, DrawsTheErrorsOfTheCheck) {
  const json& camera = validationMade().result.at("files").at(0).at("cameras").at(0);
  const json& tested = camera.at("held_out");
  double stated_px = 0;
  for (const json& check : camera.at("checks"))
    if (check.at("id") == "held_out_error") stated_px = check.at("values").at("rms_px").get<double>();
  const std::string figure = figureOf(validationMade().page, "image-residuals");
  const std::vector<double> counts = valuesOf(figure, "data-count");
  const std::vector<double> rms = valuesOf(figure, "data-rms");
  ASSERT_GT(counts.size(), 20u);
  ASSERT_EQ(counts.size(), rms.size());
  double sum = 0;
  double count = 0;
  for (std::size_t i = 0; i < counts.size(); ++i) {
    sum += counts[i] * rms[i] * rms[i];
    count += counts[i];
  }
  EXPECT_EQ(count, tested.at("num_corners").get<double>());
  EXPECT_NEAR(std::sqrt(sum / count), stated_px, 1e-8);
  const std::vector<double> bars = valuesOf(figureOf(validationMade().page, "fixed-freed"), "data-rms");
  ASSERT_EQ(bars.size(), 2 * tested.at("views").size());
  for (std::size_t v = 0; v < tested.at("views").size(); ++v) {
    EXPECT_NEAR(bars[2 * v], tested.at("views")[v].at("fixed_rms_px").get<double>(), 1e-8);
    EXPECT_NEAR(bars[2 * v + 1], tested.at("views")[v].at("freed_rms_px").get<double>(), 1e-8);
  }
}

TEST(ValidationReport, ComparesAsDiffDoes) {
  const std::vector<double> drawn = valuesOf(figureOf(validationMade().page, "difference"), "data-p95");
  const RunResult diff =
      runAlidade({"diff", dataPath("camera.yaml"), validationMade().args.back(), "--json"});
  ASSERT_EQ(drawn.size(), 1u);
  const double expected = json::parse(diff.out).at("p95_px").get<double>();
  EXPECT_NEAR(drawn[0], expected, 1e-6 * expected);
}

TEST(ValidationReport, IsTheSameTwice) {
  const std::string again = validationMade().scratch.path("again.html");
  for (const char* jobs : {"1", "2"}) {
    std::vector<std::string> args = validationMade().args;
    args.insert(args.end(), {"--report", again, "--jobs", jobs});
    static_cast<void>(runAlidade(args));
    EXPECT_TRUE(readFile(again) == validationMade().page) << jobs;
  }
  EXPECT_THAT(validationMade().page,
              AllOf(Not(HasSubstr("=\"http")), Not(HasSubstr(">nan")), Not(HasSubstr("\"nan")),
                    HasSubstr("Validation report"), HasSubstr("data:image/jpeg")));
}

TEST(ValidationReport, ListsTheFilesOfAFolder) {
  const ScratchFolder scratch;
  const std::string hostile = "<img src=x onerror=alert(1)>\xFF.yaml";
  scratch.write("set/" + hostile, smallCamera());
  scratch.write("set/deeper/b.yaml", smallCamera());
  scratch.write("set/bad.yaml", replaced(smallCamera(), "fx: ", "fx: -"));
  scratch.write("set/other.json", "{\"a\": 1}\n");
  const std::string page_path = scratch.path("page.html");
  EXPECT_THAT(runAlidade({"validate", scratch.path("set"), "--report", page_path}), EndsWith(3));
  const std::string page = readFile(page_path);
  EXPECT_THAT(page, AllOf(Not(HasSubstr("<img src=x")), HasSubstr("&lt;img src=x"),
                          HasSubstr("1 of 3 files failed"), HasSubstr("\xEF\xBF\xBD")));
  const json embedded = embeddedEvidenceOf(page);
  ASSERT_EQ(embedded.at("files").size(), 3u);
  const std::regex row("<tr class=\"(good|fair|bad)\">");
  const auto num_rows = std::distance(std::sregex_iterator(page.begin(), page.end(), row), {});
  EXPECT_EQ(num_rows, 3);
  // Every id stands for one element.
  std::set<std::string> ids;
  std::size_t num_ids = 0;
  const std::regex pattern(" id=\"([^\"]+)\"");
  for (std::sregex_iterator i(page.begin(), page.end(), pattern), end; i != end; ++i) {
    EXPECT_TRUE(ids.insert((*i)[1]).second) << (*i)[1];
    ++num_ids;
  }
  EXPECT_GT(num_ids, 10u);
}

TEST(ValidationReport, ShowsAFileThatCannotBeRead) {
  const ScratchFolder scratch;
  const std::string bad = scratch.write("bad.yaml", "alidade_camera: 1\nmodel: <b>\n");
  const std::string page_path = scratch.path("page.html");
  EXPECT_THAT(runAlidade({"validate", bad, "--report", page_path}), EndsWith(3));
  EXPECT_THAT(readFile(page_path),
              AllOf(HasSubstr("Failed: it cannot be read"), HasSubstr("&lt;b&gt;"), Not(HasSubstr("<b>"))));
}

TEST(ValidationReport, SaysWhyWarningsFailedAFile) {
  const ScratchFolder scratch;
  const std::string odd = scratch.write("odd.yaml", replaced(smallCamera(), "fy: 501", "fy: 570"));
  const std::string page_path = scratch.path("page.html");
  const auto pageOf = [&](std::vector<std::string> args) {
    args.insert(args.end(), {"--report", page_path});
    static_cast<void>(runAlidade(args));
    return readFile(page_path);
  };
  EXPECT_THAT(pageOf({"validate", odd}),
              AllOf(HasSubstr("Passed, with warnings"), HasSubstr("<code>aspect</code>"),
                    Not(HasSubstr("<code>--strict</code>"))));
  EXPECT_THAT(pageOf({"validate", odd, "--strict"}),
              AllOf(HasSubstr("Failed: it has warnings, and <code>--strict</code> was given"),
                    HasSubstr("warnings count as failures"), Not(HasSubstr("do not use this camera"))));
  EXPECT_THAT(pageOf({"validate", odd, dataPath("camera.yaml"), "--strict"}),
              AllOf(HasSubstr("1 of 2 files failed"), HasSubstr("warnings count as failures")));
  const std::string bad = scratch.write("bad.yaml", replaced(smallCamera(), "fy: 501", "fy: 1570"));
  EXPECT_THAT(pageOf({"validate", bad, "--strict"}),
              AllOf(HasSubstr("Failed: do not use this camera"), Not(HasSubstr("warnings count"))));
}

TEST(ValidationReport, OverwritesNoInput) {
  const ScratchFolder scratch;
  const std::string camera = scratch.write("camera.yaml", smallCamera());
  const std::string page_path = scratch.path("page.html");
  EXPECT_THAT(runAlidade({"validate", camera, "--report", camera}), FailsWith(2, HasSubstr("also an input")));
  EXPECT_THAT(runAlidade({"validate", scratch.path(), "--report", camera}),
              FailsWith(2, HasSubstr("also an input")));
  EXPECT_THAT(runAlidade({"validate", dataPath("camera.yaml"), "--against", camera, "--report", camera}),
              FailsWith(2, HasSubstr("also an input")));
  EXPECT_THAT(runAlidade({"validate", camera, "--report", "-"}), FailsWith(2, HasSubstr("standard output")));
  EXPECT_THAT(runAlidade({"validate", camera, "--report", page_path, "--junit", page_path}),
              FailsWith(2, HasSubstr("--junit")));
  EXPECT_THAT(readFile(camera), testing::StrEq(smallCamera()));
  EXPECT_FALSE(fs::exists(page_path));
}

}  // namespace
}  // namespace alidade
