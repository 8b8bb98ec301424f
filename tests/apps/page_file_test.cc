// SPDX-License-Identifier: MIT
#include <regex>

#include <nlohmann/json.hpp>

#include "alidade/files/camera_source.h"
#include "apps/command_line.h"
#include "apps/report_page.h"

namespace alidade {
namespace {

using testing::AllOf;
using testing::HasSubstr;
using testing::MatchesRegex;
using testing::Not;

// What a page states of its origin: the text of each name.
std::string originOf(const std::string& page, const std::string& name) {
  const std::string header = page.substr(page.find("<dl class=\"origin\">"), page.find("</header>"));
  const std::string start = "<dt>" + name + "</dt><dd>";
  const std::size_t at = header.find(start);
  if (at == std::string::npos) return "";
  const std::string text = header.substr(at + start.size(), header.find("</dd>", at) - at - start.size());
  return std::regex_replace(text, std::regex("<[^>]*>"), "");
}

class PageFile : public testing::Test {
 protected:
  // Corners calibrate faster than images.
  [[nodiscard]] RunResult calibrate(const std::vector<std::string>& more) const {
    std::vector<std::string> args = {"calibrate", dataPath("corners.csv"), "--model", "radtan"};
    args.insert(args.end(), more.begin(), more.end());
    return runAlidade(args);
  }
  [[nodiscard]] std::string path(const std::string& name) const { return scratch_.path(name); }

  ScratchFolder scratch_;
};

TEST_F(PageFile, StatesItsOriginAndADateOnlyIfGiven) {
  ASSERT_THAT(calibrate({"--name", "front <1>", "--serial", "0042", "--date", "May 2026", "-o",
                         path("a.yaml"), "--report", path("a.html"), "--evidence", path("a.json")}),
              EndsWith(0));
  const std::string page = scratch_.read("a.html");
  EXPECT_EQ(originOf(page, "Camera"), "front &lt;1&gt;");
  EXPECT_EQ(originOf(page, "Serial number"), "0042");
  EXPECT_EQ(originOf(page, "Date"), "May 2026");
  EXPECT_EQ(originOf(page, "Inputs"), dataPath("corners.csv"));
  EXPECT_THAT(originOf(page, "Made by"), MatchesRegex("alidade [0-9.]+.*"));
  ASSERT_THAT(runAlidade({"report", path("a.json"), "-o", path("again.html")}), EndsWith(0));
  EXPECT_TRUE(scratch_.read("again.html") == page);
  // Evidence of an older version states only the program.
  auto older = nlohmann::json::parse(scratch_.read("a.json"));
  older.erase("origin");
  ASSERT_THAT(runAlidade({"report", scratch_.write("old.json", older.dump()), "-o", path("old.html")}),
              EndsWith(0));
  EXPECT_EQ(originOf(scratch_.read("old.html"), "Inputs"), "");
  older["origin"] = {{"inputs", 3}};
  EXPECT_THAT(runAlidade({"report", scratch_.write("bad.json", older.dump()), "-o", path("old.html")}),
              FailsWith(1, HasSubstr("origin.inputs")));

  ASSERT_THAT(calibrate({"-o", path("b.yaml"), "--report", path("b.html")}), EndsWith(0));
  EXPECT_EQ(originOf(scratch_.read("b.html"), "Date"), "");
  EXPECT_THAT(scratch_.read("b.yaml"), Not(HasSubstr("date")));
  ASSERT_THAT(calibrate({"-o", path("today.yaml"), "--date", "today"}), EndsWith(0));
  EXPECT_THAT(loadCamera(path("today.yaml")).calibration->date, MatchesRegex("[0-9]{4}-[0-9]{2}-[0-9]{2}"));
}

TEST_F(PageFile, KeepsTheDateOfAConvertedCamera) {
  ASSERT_THAT(calibrate({"-o", path("a.yaml"), "--date", "2026-05-06", "--serial", "17"}), EndsWith(0));
  EXPECT_THAT(scratch_.read("a.yaml"), HasSubstr("\n  date: \"2026-05-06\"\n"));
  for (const std::vector<std::string>& edit :
       {std::vector<std::string>{"--crop", "10,20,600,400"}, {"--model", "rational"}}) {
    std::vector<std::string> args = {"convert", path("a.yaml"), "-o", path("b.yaml")};
    args.insert(args.end(), edit.begin(), edit.end());
    ASSERT_THAT(runAlidade(args), EndsWith(0));
    EXPECT_EQ(loadCamera(path("b.yaml")).calibration->date, "2026-05-06") << edit.front();
  }
  // The page of its validation states what the file does, and its own date.
  ASSERT_THAT(runAlidade({"validate", path("a.yaml"), "--against", dataPath("camera.yaml"), "--date", "June",
                          "--report", path("v.html")}),
              testing::AnyOf(EndsWith(0), EndsWith(3)));
  const std::string page = scratch_.read("v.html");
  EXPECT_EQ(originOf(page, "Serial number"), "17");
  EXPECT_EQ(originOf(page, "Date"), "June");
  EXPECT_EQ(originOf(page, "Inputs"), path("a.yaml") + ", --against " + dataPath("camera.yaml"));
  EXPECT_THAT(page, HasSubstr("calibrated: 2026-05-06"));
}

TEST_F(PageFile, SaysHowToPrint) {
  const std::string pdf = path("page.pdf");
  const auto says = FailsWith(2, AllOf(HasSubstr("page.pdf"), HasSubstr("print it to a PDF file")));
  EXPECT_THAT(calibrate({"--report", pdf}), says);
  EXPECT_THAT(runAlidade({"validate", dataPath("camera.yaml"), "--report", pdf}), says);
  EXPECT_THAT(runAlidade({"fleet", dataPath("camera.yaml"), "-o", pdf}),
              FailsWith(2, HasSubstr(".html or .csv")));
  EXPECT_THAT(runAlidade({"report", dataPath("camera.yaml"), "-o", path("PAGE.PDF")}),
              FailsWith(2, HasSubstr("PAGE.PDF")));
  EXPECT_TRUE(scratch_.list().empty());
}

}  // namespace
}  // namespace alidade
