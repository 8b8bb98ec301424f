// SPDX-License-Identifier: MIT
// `validate --footage`: camera files tested on ordinary pictures.
#include <filesystem>
#include <map>

#include <fmt/format.h>
#include <nlohmann/json.hpp>
#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>
#include <pugixml.hpp>

#include "alidade/files/camera_source.h"
#include "alidade/files/rig_file.h"
#include "apps/command_line.h"
#include "apps/report_page.h"
#include "imagery/video_files.h"

namespace alidade {
namespace {

using nlohmann::json;
using testing::AllOf;
using testing::HasSubstr;
using testing::Not;

constexpr int kNumFrames = 16;

std::string cameraText(int width, int height, double focal, double cx, double cy, double k1 = -0.2) {
  return fmt::format(
      "alidade_camera: 1\nmodel: radtan\nimage_size: {{width: {}, height: {}}}\n"
      "parameters: {{fx: {}, fy: {}, cx: {}, cy: {}, k1: {}, k2: 0.03, p1: 0, p2: 0, k3: 0}}\n",
      width, height, focal, focal, cx, cy, k1);
}

// A walk through a room, simulated once: footage/images/frame_00000.png and so on, 320x240 px.
struct Walk {
  ScratchFolder scratch;
  std::string images = scratch.path("footage/images/frame_%05d.png");
  std::string camera = scratch.write("true.yaml", cameraText(320, 240, 250, 160, 119));

  Walk() {
    const std::string scene = scratch.write(
        "scene.yaml",
        fmt::format(
            "alidade_scene: 1\n"
            "camera: {{model: radtan, image_size: {{width: 320, height: 240}},\n"
            "         parameters: {{fx: 250, fy: 250, cx: 160, cy: 119, k1: -0.2, k2: 0.03, p1: 0, p2: 0, "
            "k3: 0}}}}\n"
            "footage: {{frames: {}, flow_px: 8}}\nseed: 5\nrender: {{blur_px: 0.6, read_noise: 1.5}}\n",
            kNumFrames));
    EXPECT_THAT(runAlidade({"simulate", scene, "-o", scratch.path("footage")}), EndsWith(0));
  }

  [[nodiscard]] cv::Mat frame(int i) const {
    return cv::imread(scratch.path(fmt::format("footage/images/frame_{:05}.png", i)), cv::IMREAD_GRAYSCALE);
  }
};

const Walk& walk() {
  static const Walk made;
  return made;
}

// Each of these files has one thing wrong, or nothing; they are tested in one run.
struct Tested {
  const Walk& made = walk();
  ScratchFolder scratch;
  std::map<std::string, json> files;  // by name
  RunResult structured;
  std::string junit_path = scratch.path("junit.xml");
  std::string page_path = scratch.path("page.html");

  Tested() {
    scratch.write("true.yaml", cameraText(320, 240, 250, 160, 119));
    scratch.write("focal.yaml", cameraText(320, 240, 300, 160, 119));
    scratch.write("small.yaml", cameraText(160, 120, 125, 79.75, 59.25));
    std::vector<std::string> args = {"validate"};
    for (const char* name : kNames) args.push_back(scratch.path(name));
    args.insert(args.end(),
                {"--footage", made.images, "--json", "--junit", junit_path, "--report", page_path});
    RunOptions options;
    options.time_limit = std::chrono::seconds(250);  // several reconstructions
    structured = runAlidade(args, options);
    const json document = json::parse(structured.out);
    for (const json& file : document.at("files"))
      files[std::filesystem::path(file.at("file").get<std::string>()).stem().string()] = file;
  }
  static constexpr std::array kNames = {"true.yaml", "focal.yaml", "small.yaml"};

  [[nodiscard]] const json& footageOf(const std::string& name) const {
    return files.at(name).at("cameras").at(0).at("footage");
  }
  [[nodiscard]] std::string messageOf(const std::string& name) const {
    for (const json& check : files.at(name).at("cameras").at(0).at("checks"))
      if (check.at("id") == "footage") return check.at("message");
    return "no check";
  }
};

void expectVerdicts(const Tested& made) {
  ASSERT_THAT(made.structured, EndsWith(3));
  ASSERT_EQ(made.files.size(), Tested::kNames.size());
  EXPECT_EQ(made.files.at("true").at("status"), "pass");
  EXPECT_EQ(made.footageOf("true").at("verdict"), "consistent");
  EXPECT_THAT(made.messageOf("true"), testing::StartsWith("consistent: no "));
  const json& check = made.footageOf("true").at("check");
  EXPECT_EQ(check.at("cells").size(), 48U);
  EXPECT_LT(check.at("holdout_rms_px").get<double>(), 0.6);
  EXPECT_GT(check.at("num_points").get<int>(), 100);

  EXPECT_EQ(made.files.at("focal").at("status"), "failure");
  EXPECT_EQ(made.footageOf("focal").at("verdict"), "inconsistent");
  EXPECT_EQ(made.footageOf("focal").at("check").at("explanation"), "focal_length");
  EXPECT_THAT(made.messageOf("focal"),
              AllOf(testing::ContainsRegex(
                        "^inconsistent: focal length -1[4-9][.][0-9] % \\+- [0-9.]+ % explains the "
                        "footage; displaces points by [0-9]+ px"),
                    HasSubstr("\n  next: "), HasSubstr("zoom")));
  int num_changes = 0;
  for (const json& change : check.at("changes")) {
    EXPECT_EQ(change.at("amounts").size(), change.at("std").size());
    EXPECT_EQ(change.at("parameters").size(), 9U);
    ++num_changes;
  }
  EXPECT_GE(num_changes, 5);
}

void expectEdit(const Tested& made) {
  const json& footage = made.footageOf("small");
  EXPECT_EQ(made.files.at("small").at("status"), "failure");
  EXPECT_EQ(footage.at("verdict"), "inconsistent");
  EXPECT_TRUE(footage.at("check").is_null());
  ASSERT_EQ(footage.at("edits").size(), 1U);
  const json& edit = footage.at("edits").at(0);
  EXPECT_EQ(edit.at("id"), "resized");
  EXPECT_EQ(edit.at("resize"), json({{"width", 320}, {"height", 240}}));
  EXPECT_TRUE(edit.at("crop").is_null());
  EXPECT_EQ(edit.at("check").at("verdict"), "consistent");
  // It is the true camera then.
  EXPECT_EQ(edit.at("check").at("num_points"), made.footageOf("true").at("check").at("num_points"));
  EXPECT_EQ(
      made.messageOf("small"),
      "inconsistent: image resized without the file; the images have 320x240 px, the file is for 160x120\n"
      "  next: alidade convert " +
          made.scratch.path("small.yaml") + " -o OUT --resize 320x240");
}

void expectJunit(const Tested& made) {
  pugi::xml_document xml;
  ASSERT_TRUE(xml.load_file(made.junit_path.c_str()));
  const pugi::xml_node suite = xml.child("testsuites").child("testsuite");
  std::map<std::string, int> num_of_class;
  std::map<std::string, int> num_failed;
  std::string texts;
  for (const pugi::xml_node test : suite.children("testcase")) {
    const std::string class_name = test.attribute("classname").value();
    ++num_of_class[class_name];
    num_failed[class_name] += test.child("failure") ? 1 : 0;
    if (class_name == "footage")
      texts += std::string(test.child_value("failure")) + test.child_value("system-out");
  }
  EXPECT_EQ(num_of_class["camera_file"], 3);
  EXPECT_EQ(num_failed["camera_file"], 0);
  EXPECT_EQ(num_of_class["footage"], 3);
  EXPECT_EQ(num_failed["footage"], 2);
  EXPECT_EQ(suite.attribute("tests").as_int(), 6);
  EXPECT_EQ(suite.attribute("failures").as_int(), 2);
  // All that --verbose prints of it.
  EXPECT_THAT(texts, AllOf(HasSubstr("    PASS  footage "), HasSubstr("held-out error 0."),
                           HasSubstr("--resize 320x240: consistent"), HasSubstr("; best explanation\n"),
                           Not(HasSubstr("A file cannot show"))));
}

void expectPage(const Tested& made) {
  const std::string page = readFile(made.page_path);
  const json evidence = embeddedEvidenceOf(page);
  int num_figures = 0;
  for (std::size_t f = 0; f < 3; ++f) {
    const json& footage = evidence.at("files").at(f).at("cameras").at(0).at("footage");
    const bool is_edited = footage.at("check").is_null();
    const json& check = is_edited ? footage.at("edits").at(0).at("check") : footage.at("check");
    const std::string prefix = fmt::format("file{}-0-", f);
    std::vector<double> rms;
    for (const json& cell : check.at("cells"))
      if (cell.at("num_pixels") > 0) rms.push_back(cell.at("rms_px"));
    const std::vector<double> shown = valuesOf(figureOf(page, prefix + "footage-errors"), "data-rms");
    ASSERT_GT(rms.size(), 24U);
    ASSERT_EQ(shown.size(), rms.size());
    for (std::size_t i = 0; i < rms.size(); ++i) EXPECT_NEAR(shown[i], rms[i], 1e-8);
    const std::string table = figureOf(page, prefix + "footage-changes");
    for (const json& change : check.at("changes"))
      EXPECT_THAT(table, HasSubstr(change.at("text").get<std::string>()));
    EXPECT_EQ(table.find("best explanation") != std::string::npos, !check.at("explanation").is_null());
    ++num_figures;
  }
  EXPECT_EQ(num_figures, 3);
}

// One test, because the run takes seconds.
TEST(FootageCheckCommand, TellsARightFileFromWrongOnes) {
  const Tested made;
  expectVerdicts(made);
  expectEdit(made);
  expectJunit(made);
  expectPage(made);
}

// ---- footage that tells nothing, or is no footage ----

RunResult checkFootage(const std::string& footage, std::vector<std::string> more = {}) {
  std::vector<std::string> args = {"validate", walk().camera, "--footage", footage};
  args.insert(args.end(), more.begin(), more.end());
  return runAlidade(args);
}

TEST(FootageCheckCommand, CannotTellFromPicturesThatShowNothing) {
  const ScratchFolder scratch;
  const std::vector<cv::Mat> black(12, cv::Mat::zeros(240, 320, CV_8U));
  const std::vector<cv::Mat> still(12, walk().frame(0));
  const std::vector<cv::Mat> two = {walk().frame(0), walk().frame(1)};
  struct Case {
    const char* name;
    const std::vector<cv::Mat>& frames;
    const char* words;
    const char* gap;
  };
  int num_cases = 0;
  for (const Case& c : {Case{"black.avi", black, "too few points", "too_few_points"},
                        Case{"still.avi", still, "all images show the same; move the camera", "no_motion"},
                        Case{"two.avi", two, "cannot tell: ", ""}}) {
    SCOPED_TRACE(c.name);
    const std::string clip = writeVideo(scratch.path(c.name), c.frames);
    const RunResult result = checkFootage(clip);
    EXPECT_THAT(result, EndsWith(0));
    EXPECT_THAT(result.out, AllOf(testing::StartsWith("WARN  "), HasSubstr("footage: cannot tell: "),
                                  HasSubstr(c.words), HasSubstr("1 passed (1 with warnings)")));
    EXPECT_THAT(checkFootage(clip, {"--strict"}), EndsWith(3));
    const RunResult structured = checkFootage(clip, {"--json"});
    EXPECT_THAT(structured, EndsWith(0));
    const json footage = json::parse(structured.out).at("files").at(0).at("cameras").at(0).at("footage");
    EXPECT_EQ(footage.at("verdict"), "cannot_tell");
    if (*c.gap != '\0') {
      EXPECT_EQ(footage.at("check").at("gap"), c.gap);
    }
    ++num_cases;
  }
  EXPECT_EQ(num_cases, 3);
  const std::string photo = scratch.path("one.png");
  ASSERT_TRUE(cv::imwrite(photo, walk().frame(0)));
  EXPECT_THAT(checkFootage(photo).out, HasSubstr("only one image; take several, from different places"));
}

TEST(FootageCheckCommand, RefusesFootageThatCannotBeRead) {
  const ScratchFolder scratch;
  std::vector<cv::Mat> frames;
  for (int i = 0; i < kNumFrames; ++i) frames.push_back(walk().frame(i));
  const std::string whole = readFile(writeVideo(scratch.path("whole.avi"), frames));
  const std::string cut = scratch.write("cut.avi", whole.substr(0, whole.size() / 2));
  EXPECT_THAT(checkFootage(cut),
              FailsWith(1, AllOf(HasSubstr("cut.avi"), HasSubstr("next: copy the video again"))));
  EXPECT_THAT(checkFootage(scratch.write("noise.mp4", std::string(2000, 'x'))),
              FailsWith(1, HasSubstr("noise.mp4")));
  EXPECT_THAT(checkFootage(scratch.makeFolder("empty")), FailsWith(1, HasSubstr("empty")));
  EXPECT_THAT(checkFootage(scratch.path("whole.av")), FailsWith(1, HasSubstr("whole.avi")));  // did you mean
  const std::string broken = scratch.makeFolder("photos");
  ASSERT_TRUE(cv::imwrite(broken + "/a.png", walk().frame(0)));
  scratch.write("photos/b.png", "no picture");
  EXPECT_THAT(checkFootage(broken), FailsWith(1, HasSubstr("b.png")));
  ASSERT_TRUE(cv::imwrite(broken + "/b.png", frames[1].rowRange(0, 200)));
  EXPECT_THAT(checkFootage(broken), FailsWith(1, AllOf(HasSubstr("b.png"), HasSubstr("320x200"))));
}

TEST(FootageCheckCommand, SaysWhatAPortraitVideoNeeds) {
  const ScratchFolder scratch;
  std::vector<cv::Mat> frames;
  for (int i = 0; i < 6; ++i) cv::rotate(walk().frame(i), frames.emplace_back(), cv::ROTATE_90_CLOCKWISE);
  const RunResult result = checkFootage(writeVideo(scratch.path("portrait.avi"), frames));
  EXPECT_THAT(result, EndsWith(3));
  EXPECT_THAT(result.out, AllOf(testing::StartsWith("FAIL  "), HasSubstr("240x320"),
                                HasSubstr("\n      next: "), HasSubstr("--rotate 90")));
}

TEST(FootageCheckCommand, RefusesWhatDoesNotGoWithIt) {
  const ScratchFolder scratch;
  EXPECT_THAT(runAlidade({"validate", walk().camera, "--front-end", "flow"}),
              FailsWith(2, HasSubstr("--footage")));
  EXPECT_THAT(checkFootage(walk().images, {"--front-end", "lines"}), FailsWith(2, HasSubstr("--front-end")));
  RigRecord record;
  for (const char* name : {"left", "right"}) {
    record.cameras.push_back({.camera = loadCamera(walk().camera), .camera_from_rig = SE3()});
    record.cameras.back().camera.name.name = name;
  }
  const std::string rig = scratch.path("rig.yaml");
  saveRig(rig, record);
  EXPECT_THAT(runAlidade({"validate", rig, "--footage", walk().images}),
              FailsWith(2, AllOf(HasSubstr("2 cameras"), HasSubstr("rig.yaml#left"))));
  const std::string frame = walk().scratch.path("footage/images/frame_00000.png");
  EXPECT_THAT(checkFootage(walk().images, {"--report", frame}), FailsWith(2, HasSubstr("--report")));
  EXPECT_FALSE(walk().frame(0).empty());
}

}  // namespace
}  // namespace alidade
