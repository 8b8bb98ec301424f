// SPDX-License-Identifier: MIT
#include <cmath>
#include <filesystem>
#include <regex>

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

// A calibration of the images of testdata/ with all its files.
struct Made {
  ScratchFolder scratch;
  std::string page_path = scratch.path("page.html");
  std::string evidence_path = scratch.path("evidence.json");
  std::string camera_path = scratch.path("camera.yaml");
  std::string page;
  json evidence;

  Made() {
    const RunResult result = runAlidade({"calibrate", dataPath("images"), "--board", kBoardSpec, "-o",
                                         camera_path, "--evidence", evidence_path, "--report", page_path});
    EXPECT_THAT(result, EndsWith(0));
    EXPECT_THAT(result.err, HasSubstr("report written to " + page_path));
    page = readFile(page_path);
    evidence = json::parse(readFile(evidence_path));
  }
};

const Made& made() {
  static const Made result;
  return result;
}

TEST(Report, HoldsTheEvidence) {
  const json embedded = embeddedEvidenceOf(made().page);
  const json& evidence = made().evidence;
  for (const auto& [key, value] : evidence.items()) {
    if (key != "views") {
      EXPECT_EQ(embedded.at(key), value) << key;
    }
  }
  ASSERT_EQ(embedded.at("views").size(), evidence.at("views").size());
  std::size_t num_corners = 0;
  double sum = 0;
  for (std::size_t v = 0; v < embedded.at("views").size(); ++v) {
    const json& corners = embedded.at("views")[v].at("corners");
    const json& exact = evidence.at("views")[v].at("corners");
    ASSERT_EQ(corners.size(), exact.size());
    for (std::size_t i = 0; i < corners.size(); ++i) {
      EXPECT_EQ(corners[i].at("id"), exact[i].at("id"));
      EXPECT_NEAR(corners[i].at("u").get<double>(), exact[i].at("u").get<double>(), 1e-4);
      sum += std::pow(corners[i].at("dx").get<double>(), 2) + std::pow(corners[i].at("dy").get<double>(), 2);
    }
    num_corners += corners.size();
  }
  EXPECT_EQ(num_corners, evidence.at("num_corners").get<std::size_t>());
  EXPECT_NEAR(std::sqrt(sum / static_cast<double>(num_corners)), evidence.at("rms_px").get<double>(), 1e-4);
}

TEST(Report, DrawsTheErrorsOfTheFit) {
  const std::string figure = figureOf(made().page, "image-residuals");
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
  EXPECT_EQ(count, made().evidence.at("num_corners").get<double>());
  EXPECT_NEAR(std::sqrt(sum / count), made().evidence.at("rms_px").get<double>(), 1e-8);
}

TEST(Report, CountsTheCornersOfEveryFigure) {
  const auto num_corners = made().evidence.at("num_corners").get<double>();
  const auto sumIn = [&](const char* id) {
    double sum = 0;
    for (const double count : valuesOf(figureOf(made().page, id), "data-count")) sum += count;
    return sum;
  };
  EXPECT_EQ(sumIn("coverage"), num_corners);
  EXPECT_EQ(sumIn("histogram"), 2 * num_corners);
  const std::vector<double> bars = valuesOf(figureOf(made().page, "view-errors"), "data-rms");
  const json& views = made().evidence.at("views");
  ASSERT_EQ(bars.size(), views.size());
  for (std::size_t v = 0; v < bars.size(); ++v)
    EXPECT_NEAR(bars[v], views[v].at("rms_px").get<double>(), 1e-8);
}

TEST(Report, AgreesWithTheCameraFile) {
  const json accuracy = embeddedEvidenceOf(made().page).at("accuracy");
  double covered = 0;
  for (std::size_t i = 0; i < accuracy.at("error_px").size(); ++i) {
    if (accuracy.at("is_covered")[i].get<bool>())
      covered = std::max(covered, accuracy.at("error_px")[i].get<double>());
  }
  const std::string camera = readFile(made().camera_path);
  std::smatch stated;
  ASSERT_TRUE(std::regex_search(camera, stated, std::regex("accuracy_px: ([-0-9.e]+)")));
  EXPECT_NEAR(covered, std::stod(stated[1]), 5e-3 * covered);  // three digits
  EXPECT_THAT(made().page, HasSubstr("Trustworthy"));
}

TEST(Report, IsTheSameFromTheEvidenceFile) {
  const std::string again = made().scratch.path("again.html");
  for (const char* jobs : {"1", "2"}) {
    ASSERT_THAT(runAlidade({"report", made().evidence_path, "-o", again, "--images", dataPath("images"),
                            "--jobs", jobs}),
                EndsWith(0));
    EXPECT_TRUE(readFile(again) == made().page);
  }
  ASSERT_THAT(runAlidade({"report", made().camera_path, "--evidence", made().evidence_path, "-o", again,
                          "--images", dataPath("images")}),
              EndsWith(0));
  EXPECT_TRUE(readFile(again) == made().page);
  // Without images each view has its corners instead.
  ASSERT_THAT(runAlidade({"report", made().evidence_path, "-o", again}), EndsWith(0));
  const std::string without = readFile(again);
  EXPECT_THAT(without, Not(HasSubstr("data:image/jpeg")));
  EXPECT_EQ(figureOf(without, "accuracy"), figureOf(made().page, "accuracy"));
}

TEST(Report, NeedsNothingElse) {
  EXPECT_THAT(made().page,
              AllOf(Not(HasSubstr("=\"http")), Not(HasSubstr("@import")), Not(HasSubstr("url(\"")),
                    Not(HasSubstr(">nan")), Not(HasSubstr("\"nan")), HasSubstr("default-src 'none'")));
}

TEST(Report, KeepsNamesFromBeingMarkup) {
  const ScratchFolder scratch;
  const std::string folder = scratch.path("images");
  fs::create_directory(folder);
  const std::vector<std::string> names = {"</script><script>alert(1)</script>",
                                          "\"><img src=x onerror=alert(1)>", "'a' & \xF0\x9F\x93\xB7",
                                          "bytes \xFF\xFE", "${alert(1)}"};
  for (int i = 1; i <= kNumImages; ++i) {
    std::string name = fmt::format("{}.png", i);
    if (static_cast<std::size_t>(i) <= names.size())
      name = replaced(names[static_cast<std::size_t>(i - 1)] + "#", "#", name);
    for (char& c : name) c = c == '/' ? '|' : c;
    fs::create_symlink(imagePath(i), folder + "/" + name);
  }
  const std::string path = scratch.path("page.html");
  ASSERT_THAT(runAlidade({"calibrate", folder, "--board", kBoardSpec, "--report", path, "--evidence",
                          scratch.path("evidence.json")}),
              EndsWith(0));
  const std::string page = readFile(path);
  EXPECT_THAT(page, AllOf(Not(HasSubstr("<script>alert")), Not(HasSubstr("<img src=x")),
                          HasSubstr("\xF0\x9F\x93\xB7"), HasSubstr("\xEF\xBF\xBD")));
  EXPECT_EQ(valuesOf(figureOf(page, "view-sheet"), "data-view").size(), 12u);
  EXPECT_EQ(embeddedEvidenceOf(page).at("views").size(), 12u);
  ASSERT_THAT(runAlidade({"report", scratch.path("evidence.json"), "-o", scratch.path("again.html"),
                          "--images", folder}),
              EndsWith(0));
  EXPECT_TRUE(readFile(scratch.path("again.html")) == page);
}

TEST(Report, WritesItsFiguresAsFiles) {
  const std::string folder = made().scratch.path("figures");
  ASSERT_THAT(
      runAlidade({"report", made().evidence_path, "--figures", folder, "--images", dataPath("images")}),
      EndsWith(0));
  int num_drawings = 0;
  for (const auto& entry : fs::directory_iterator(folder)) {
    if (entry.path().extension() != ".svg") continue;
    const std::string svg = readFile(entry.path());
    EXPECT_THAT(svg, testing::StartsWith("<svg xmlns=\"http://www.w3.org/2000/svg\"")) << entry.path();
    EXPECT_THAT(svg, AllOf(HasSubstr("<style>"), testing::EndsWith("</svg>\n"), Not(HasSubstr("\"nan")),
                           Not(HasSubstr(",nan"))))
        << entry.path();
    ++num_drawings;
  }
  EXPECT_GE(num_drawings, 14);
  const std::vector<std::string> again = {"report", made().evidence_path, "--figures", folder};
  EXPECT_THAT(runAlidade(again), FailsWith(1, HasSubstr("figures")));
}

TEST(Report, ComparesWithAnotherCameraAsDiffDoes) {
  const std::string path = made().scratch.path("against.html");
  const std::string other = dataPath("camera.yaml");
  ASSERT_THAT(runAlidade({"report", made().evidence_path, "-o", path, "--against", other}), EndsWith(0));
  const std::vector<double> drawn = valuesOf(figureOf(readFile(path), "difference"), "data-p95");
  const RunResult diff = runAlidade({"diff", made().camera_path, other, "--json"});
  const double expected = json::parse(diff.out).at("p95_px").get<double>();
  ASSERT_EQ(drawn.size(), 1u);
  EXPECT_NEAR(drawn[0], expected, 1e-3 * expected);  // the camera file has fewer digits of the covariance
}

TEST(Report, ShowsWhyACameraWasRejected) {
  const ScratchFolder scratch;
  const std::string path = scratch.path("page.html");
  const RunResult result = runAlidade(
      {"calibrate", dataPath("images"), "--board", kBoardSpec, "--tolerance", "0.0005px", "--report", path});
  EXPECT_THAT(result, EndsWith(3));
  EXPECT_THAT(readFile(path), AllOf(HasSubstr("Rejected: do not use this camera"), HasSubstr("Failure")));
}

// The page that an evidence document gives.
std::string pageOf(const json& evidence) {
  const ScratchFolder scratch;
  scratch.write("evidence.json", evidence.dump());
  const std::string path = scratch.path("page.html");
  EXPECT_THAT(runAlidade({"report", scratch.path("evidence.json"), "-o", path}), EndsWith(0));
  return readFile(path);
}

json findingOf(const char* severity, const char* id, const char* cause, const char* details) {
  return {{"severity", severity}, {"id", id},        {"cause", cause},      {"evidence", details},
          {"limit", ""},          {"next_step", ""}, {"effect_px", nullptr}};
}

TEST(Report, SaysWhatAShareIsOf) {
  EXPECT_THAT(made().page, HasSubstr("<small>of the image, 1 px</small>"));
  json evidence = made().evidence;
  json& errors = evidence["accuracy"]["error_px"];
  for (std::size_t i = 0; i < errors.size(); i += 7) errors[i] = nullptr;
  const std::string page = pageOf(evidence);
  EXPECT_THAT(page, HasSubstr("<small>of the pixels with a ray, 1 px</small>"));
  EXPECT_THAT(page, Not(HasSubstr("of the image is within")));
}

TEST(Report, NeverRoundsAShareToAllOrNothing) {
  json evidence = made().evidence;
  evidence["findings"] = json::array();
  json& errors = evidence["accuracy"]["error_px"];
  ASSERT_GT(errors.size(), 300u);
  for (json& error : errors) error = 0.1;
  EXPECT_THAT(pageOf(evidence), HasSubstr("<dd>100 %<small>"));
  errors[0] = 1.5;
  EXPECT_THAT(pageOf(evidence), HasSubstr("<dd>&gt; 99 %<small>"));
  for (json& error : errors) error = 1.5;
  errors[0] = 0.1;
  EXPECT_THAT(pageOf(evidence), HasSubstr("<dd>&lt; 1 %<small>"));
}

TEST(Report, SaysHowMuchOfTheImageIsUsable) {
  json evidence = made().evidence;
  evidence["verdict"] = "usable_with_reservations";
  json& errors = evidence["accuracy"]["error_px"];
  for (std::size_t i = 0; i < errors.size(); ++i) errors[i] = i % 4 == 0 ? 0.2 : 3.0;
  EXPECT_THAT(pageOf(evidence),
              HasSubstr("Usable with reservations: only 25 % of the image is within 1\u00a0px"));
}

TEST(Report, ClaimsNoAccuracyForARejectedCamera) {
  json evidence = made().evidence;
  evidence["verdict"] = "rejected";
  evidence["findings"] = {
      findingOf("failure", "two_cameras", "the views fall into two groups", "10 of 20 views"),
      findingOf("failure", "misfit", "the errors are large", "")};
  const std::string page = pageOf(evidence);
  EXPECT_THAT(page, HasSubstr("<p>The views fall into two groups: 10 of 20 views (and 1 more failure). The "
                              "accuracy figures below do not apply.</p>"));
  EXPECT_THAT(page, HasSubstr("<div class=\"void\"><dt>Accuracy</dt>"));
  // Nor does another photograph help.
  EXPECT_THAT(page, AllOf(Not(HasSubstr("id=\"next-view\"")), Not(HasSubstr("take one more"))));
  EXPECT_THAT(made().page, AllOf(HasSubstr("id=\"next-view\""), Not(HasSubstr("class=\"void\""))));
}

TEST(Report, KeepsTheLettersOfNames) {
  json evidence = made().evidence;
  evidence["views"][0]["image"] = "left";
  evidence["findings"] = {findingOf("warning", "influential_view", "left", "contradicts the other views"),
                          findingOf("warning", "view_left_out", "left08.jpg", "does not fit"),
                          findingOf("warning", "odd_aspect", "pixels are not square", "")};
  EXPECT_THAT(pageOf(evidence), AllOf(HasSubstr(">left: contradicts"), HasSubstr(">left08.jpg: does not fit"),
                                      HasSubstr(">Pixels are not square.")));
}

TEST(Report, RefusesWhatIsNoEvidence) {
  const ScratchFolder scratch;
  const std::string path = scratch.path("page.html");
  const auto refused = [&](const std::string& text) {
    scratch.write("bad.json", text);
    EXPECT_THAT(runAlidade({"report", scratch.path("bad.json"), "-o", path}),
                FailsWith(1, HasSubstr("bad.json")));
    EXPECT_FALSE(fs::exists(path));
  };
  refused("");
  refused("[]");
  refused("{}");
  refused("{\"model\": ");
  refused("alidade_camera: 1\n");
  const std::string other = scratch.path("other.yaml");
  scratch.write("other.yaml", smallCamera());
  EXPECT_THAT(runAlidade({"report", other, "--evidence", made().evidence_path, "-o", path}),
              FailsWith(1, HasSubstr("another camera")));
  EXPECT_THAT(runAlidade({"report", made().evidence_path}), FailsWith(2, HasSubstr("--output")));
  EXPECT_THAT(runAlidade({"report", "-o", path}), FailsWith(2, HasSubstr("no file")));
  EXPECT_THAT(runAlidade({"report", made().evidence_path, "-o", made().evidence_path}),
              FailsWith(2, HasSubstr("also an input")));
}

// Every value of the document, replaced by one of another kind, is refused or of no matter; nothing crashes.
TEST(Report, SurvivesSpoiledEvidence) {
  json small = made().evidence;
  small["views"].erase(small["views"].begin() + 3, small["views"].end());
  small["coverage"]["views"].erase(small["coverage"]["views"].begin() + 3, small["coverage"]["views"].end());
  for (json& view : small["views"]) view["corners"].erase(view["corners"].begin() + 4, view["corners"].end());
  const ScratchFolder scratch;
  const std::string path = scratch.path("page.html");
  int num_refused = 0;
  int num_tried = 0;
  const json flat = small.flatten();
  std::size_t i = 0;
  for (const auto& [pointer, value] : flat.items()) {
    // Grids have thousands of equal values.
    const bool is_grid =
        pointer.find("error_px") != std::string::npos || pointer.find("_std") != std::string::npos;
    if (++i % (is_grid ? 900 : 40) != 0) continue;
    for (const json& other : {json(-1e300), json("x"), json(nullptr)}) {
      json spoiled = small;
      spoiled[json::json_pointer(pointer)] = other;
      scratch.write("bad.json", spoiled.dump());
      const RunResult result = runAlidade({"report", scratch.path("bad.json"), "-o", path});
      ++num_tried;
      if (result.exit_code == 0) continue;
      EXPECT_THAT(result, FailsWith(1, HasSubstr("bad.json"))) << pointer << " " << other;
      ++num_refused;
    }
  }
  EXPECT_GT(num_tried, 60);
  EXPECT_GT(num_refused, 20);
}

}  // namespace
}  // namespace alidade
