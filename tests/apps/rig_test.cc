// SPDX-License-Identifier: MIT
#include <cmath>
#include <regex>

#include <nlohmann/json.hpp>

#include "alidade/files/camera_source.h"
#include "alidade/files/rig_file.h"
#include "apps/command_line.h"

namespace alidade {
namespace {

using testing::AllOf;
using testing::HasSubstr;

// A camera beside itself: corners files of the same views.
class RigCalibrate : public testing::Test {
 protected:
  RigCalibrate() {
    scratch_.write("left.csv", readFile(dataPath("corners.csv")));
    scratch_.write("right.csv", readFile(dataPath("corners.csv")));
  }
  [[nodiscard]] RunResult calibrate(const std::vector<std::string>& more = {}) const {
    std::vector<std::string> args = {"rig", "calibrate", scratch_.path("left.csv"),
                                     scratch_.path("right.csv")};
    args.insert(args.end(), more.begin(), more.end());
    return runAlidade(args);
  }

  ScratchFolder scratch_;
};

TEST_F(RigCalibrate, WritesAFileOfItsCameras) {
  const RunResult result = calibrate({"--model", "radtan", "-o", scratch_.path("rig.yaml")});
  ASSERT_THAT(result, EndsWith(0));
  EXPECT_THAT(result.out,
              AllOf(HasSubstr("Verdict   "), HasSubstr("2 cameras, 12 frames; 12 boards seen by two"),
                    HasSubstr("left\n"), HasSubstr("right\n"), HasSubstr(" 0.00 mm from the first")));
  EXPECT_THAT(runAlidade({"validate", scratch_.path("rig.yaml")}), EndsWith(0));
  EXPECT_THAT(runAlidade({"diff", scratch_.path("rig.yaml#left"), scratch_.path("rig.yaml#right")}),
              EndsWith(0));
  const std::string file = scratch_.read("rig.yaml");
  EXPECT_THAT(file, AllOf(HasSubstr("alidade_rig: 1\n"), HasSubstr("name: \"right\""),
                          HasSubstr("camera_from_rig_std")));
  const RigRecord rig = loadRig(scratch_.path("rig.yaml"));
  EXPECT_EQ(rigFileText(rig), file);
  EXPECT_EQ(rig.cameras.size(), 2u);
  EXPECT_EQ(rig.covariance.size(), (9u + 9 + 6) * (9 + 9 + 6 + 1) / 2);
  // A changed digit is noticed as in a camera file.
  scratch_.write("bad.yaml", replaced(file, "alidade_rig: 1", "alidade_rig: 2"));
  EXPECT_THAT(runAlidade({"project", scratch_.path("bad.yaml#left")}), FailsWith(1, HasSubstr("version")));
}

TEST_F(RigCalibrate, WritesOneJsonDocument) {
  const RunResult result = calibrate({"--model", "radtan,radtan", "--names", "a,b", "--json"});
  ASSERT_THAT(result, EndsWith(0));
  const auto json = nlohmann::json::parse(result.out);
  ASSERT_EQ(json.at("cameras").size(), 2u);
  EXPECT_EQ(json.at("cameras").at(1).at("name"), "b");
  EXPECT_EQ(json.at("num_linked"), 12);
  EXPECT_LT(json.at("rms_px").get<double>(), 0.1);
}

TEST_F(RigCalibrate, WritesAReport) {
  const std::string page = scratch_.path("page.html");
  const std::string evidence = scratch_.path("evidence.json");
  ASSERT_THAT(calibrate({"--model", "radtan", "--report", page, "--evidence", evidence}), EndsWith(0));
  const auto document = nlohmann::json::parse(readFile(evidence));
  EXPECT_EQ(document.at("views").size(), 24u);
  const std::string html = readFile(page);
  EXPECT_THAT(html, AllOf(HasSubstr("Rig of 2 cameras"), HasSubstr("id=\"scene\""),
                          HasSubstr("id=\"frame-errors\"")));
  // The cells of the figure have the RMS of the fit.
  const std::string figure = html.substr(html.find("<figure id=\"frame-errors\""));
  const std::regex cell("data-count=\"(\\d+)\" data-rms=\"([-0-9.e]+)\"");
  double sum = 0;
  double count = 0;
  for (std::sregex_iterator it(figure.begin(), figure.end(), cell), end; it != end; ++it) {
    sum += std::stod((*it)[1]) * std::pow(std::stod((*it)[2]), 2);
    count += std::stod((*it)[1]);
  }
  EXPECT_EQ(count, 2 * 12 * 54);
  EXPECT_NEAR(std::sqrt(sum / count), document.at("rms_px").get<double>(), 1e-8);
  ASSERT_THAT(runAlidade({"report", evidence, "-o", scratch_.path("again.html")}), EndsWith(0));
  EXPECT_TRUE(scratch_.read("again.html") == html);
  EXPECT_THAT(runAlidade({"report", evidence, "-o", page, "--images", dataPath("images")}),
              FailsWith(2, HasSubstr("--images")));
  EXPECT_THAT(calibrate({"--report", page, "--evidence", page}), FailsWith(2, HasSubstr("the same file")));
}

TEST_F(RigCalibrate, MatchesImagesByATable) {
  scratch_.write("frames.csv",
                 "left,right\nview_001.png,view_001.png\nview_002.png,view_002.png\n"
                 "view_003.png,view_003.png\nview_004.png,view_004.png\nview_005.png,\n");
  const RunResult result = calibrate({"--model", "radtan", "--match", scratch_.path("frames.csv"), "--json"});
  EXPECT_EQ(nlohmann::json::parse(result.out).at("num_linked"), 4);
  scratch_.write("frames.csv", "left,middle\nview_001.png,view_001.png\n");
  EXPECT_THAT(calibrate({"--quiet", "--match", scratch_.path("frames.csv")}),
              FailsWith(1, AllOf(HasSubstr("no column 'right'"), HasSubstr("left, middle"))));
  scratch_.write("frames.csv", "left,right\nview_001.png\n");
  EXPECT_THAT(calibrate({"--quiet", "--match", scratch_.path("frames.csv")}),
              FailsWith(1, AllOf(HasSubstr("frames.csv:2"), HasSubstr("1 fields"))));
  for (const std::string bad : {"", "left\nx\n", "left,left\nx,y\n", "left,right\n"}) {
    scratch_.write("frames.csv", bad);
    EXPECT_THAT(calibrate({"--quiet", "--match", scratch_.path("frames.csv")}),
                FailsWith(1, HasSubstr("frames.csv")))
        << bad;
  }
}

TEST_F(RigCalibrate, SaysThatItMatchedByNearestTimes) {
  for (const std::string name : {"left", "right"}) {
    const std::string corners = scratch_.read(name + ".csv");
    const std::string last = name == "left" ? "000" : "003";
    scratch_.write(name + ".csv", std::regex_replace(corners, std::regex(",view_(\\d+)"), ",10$1." + last));
  }
  const RunResult result = calibrate({"--model", "radtan"});
  EXPECT_THAT(result, EndsWith(0));
  EXPECT_THAT(result.out,
              AllOf(HasSubstr("12 boards seen by two"), HasSubstr("Note      images were matched by"),
                    HasSubstr("differ by up to 0.003 in")));
}

TEST_F(RigCalibrate, KeepsGivenLenses) {
  const std::string camera = scratch_.path("camera.yaml");
  ASSERT_THAT(runAlidade({"calibrate", dataPath("corners.csv"), "--model", "radtan", "-o", camera}),
              EndsWith(0));
  const RunResult result =
      calibrate({"--fixed", camera + ",-", "--model", "radtan", "-o", scratch_.path("rig.yaml")});
  ASSERT_THAT(result, EndsWith(0));
  const RigRecord rig = loadRig(scratch_.path("rig.yaml"));
  const CameraRecord given = loadCamera(camera);
  EXPECT_THAT(rig.cameras[0].camera.camera.parameters(),
              testing::ElementsAreArray(given.camera.parameters()));
  EXPECT_EQ(rig.cameras[0].camera.calibration->accuracy_px, given.calibration->accuracy_px);
  EXPECT_THAT(calibrate({"--fixed", camera}), FailsWith(2, HasSubstr("1 files for 2 cameras")));
  EXPECT_THAT(calibrate({"--fixed", camera + "," + camera, "-o", camera}),
              FailsWith(2, HasSubstr("this is also an input")));
}

TEST_F(RigCalibrate, IsValidatedByImages) {
  const std::string rig = scratch_.path("rig.yaml");
  ASSERT_THAT(calibrate({"--model", "radtan", "-o", rig}), EndsWith(0));
  const std::vector<std::string> inputs = {scratch_.path("left.csv"), scratch_.path("right.csv")};
  const auto validate = [&](const std::string& file, const std::vector<std::string>& more) {
    std::vector<std::string> args = {"rig", "validate", file};
    args.insert(args.end(), more.begin(), more.end());
    return runAlidade(args);
  };
  const RunResult json = validate(rig, {inputs[0], inputs[1], "--json"});
  EXPECT_THAT(json, EndsWith(0));
  EXPECT_LT(nlohmann::json::parse(json.out).at("rms_px").get<double>(), 0.1);
  const RunResult text = validate(rig, {inputs[1], inputs[0], "--names", "right,left"});
  EXPECT_THAT(text, EndsWith(0));
  EXPECT_THAT(text.out, AllOf(HasSubstr("Verdict   the images confirm the rig\n"), HasSubstr("right\n")));
  // Elsewhere.
  RigRecord moved = loadRig(rig);
  moved.cameras[1].camera_from_rig.translation.y() += 0.05;
  scratch_.write("moved.yaml", rigFileText(moved));
  const RunResult no = validate(scratch_.path("moved.yaml"), inputs);
  EXPECT_THAT(no, EndsWith(3));
  EXPECT_THAT(no.err, HasSubstr("error: the images contradict the rig: right stands elsewhere"));
  EXPECT_THAT(validate(rig, {inputs[0]}),
              FailsWith(2, AllOf(HasSubstr("1 inputs"), HasSubstr("left, right"))));
  EXPECT_THAT(validate(rig, {inputs[0], inputs[1], "--names", "left,middle"}),
              FailsWith(2, AllOf(HasSubstr("'middle'"), HasSubstr("left, right"))));
  EXPECT_THAT(runAlidade({"rig", "validate"}), FailsWith(2, HasSubstr("no rig file")));
}

TEST_F(RigCalibrate, SaysWhatIsWrong) {
  EXPECT_THAT(runAlidade({"rig"}), FailsWith(2, AllOf(HasSubstr("rig: no command"), HasSubstr("calibrate"))));
  EXPECT_THAT(runAlidade({"rig", "solve"}), FailsWith(2, HasSubstr("solve")));
  EXPECT_THAT(runAlidade({"rig", "calibrate", scratch_.path("left.csv")}),
              FailsWith(2, HasSubstr("1 inputs")));
  EXPECT_THAT(runAlidade({"rig", "calibrate", scratch_.path("left.csv"), scratch_.path("left.csv")}),
              FailsWith(2, AllOf(HasSubstr("a different name for each camera"), HasSubstr("--names"))));
  EXPECT_THAT(calibrate({"--model", "radtan,radtan,radtan"}),
              FailsWith(2, HasSubstr("3 models for 2 cameras")));
  EXPECT_THAT(calibrate({"--model", "radtam"}), FailsWith(2, HasSubstr("radtam")));
  EXPECT_THAT(calibrate({"-o", scratch_.path("left.csv")}), FailsWith(2, HasSubstr("this is also an input")));
  // Views of other moments link nothing.
  std::string others = scratch_.read("right.csv");
  for (std::size_t at = others.find(",view_0"); at != std::string::npos; at = others.find(",view_0", at + 1))
    others.replace(at, 7, ",view_9");
  scratch_.write("right.csv", others);
  EXPECT_THAT(calibrate({"--quiet"}),
              FailsWith(1, AllOf(HasSubstr("nothing links: left | right"), HasSubstr("next: "))));
}

}  // namespace
}  // namespace alidade
