// SPDX-License-Identifier: MIT
// `validate --footage`: camera files tested on ordinary pictures.
#include <filesystem>
#include <map>

#include <fmt/format.h>
#include <nlohmann/json.hpp>
#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>
#include <pugixml.hpp>

#include "alidade/files/camera_file.h"
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

constexpr int kNumFrames = 30;

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
  RunResult text;
  RunResult structured;
  std::string junit_path = scratch.path("junit.xml");
  std::string page_path = scratch.path("page.html");

  Tested() {
    scratch.write("true.yaml", cameraText(320, 240, 250, 160, 119));
    scratch.write("focal.yaml", cameraText(320, 240, 300, 160, 119));
    scratch.write("large.yaml", cameraText(640, 480, 500, 320.5, 238.5));
    scratch.write("uncropped.yaml", cameraText(400, 300, 250, 200, 149));
    scratch.write("turned.yaml", cameraText(240, 320, 250, 120, 160));
    scratch.write("other.yaml", cameraText(640, 480, 900, 320.5, 238.5, 0.2));
    std::vector<std::string> args = {"validate"};
    for (const char* name : kNames) args.push_back(scratch.path(name));
    args.insert(args.end(), {"--footage", made.images, "--verbose"});
    text = runAlidade(args);
    args.insert(args.end(), {"--json", "--junit", junit_path, "--report", page_path});
    structured = runAlidade(args);
    const json document = json::parse(structured.out);
    for (const json& file : document.at("files"))
      files[std::filesystem::path(file.at("file").get<std::string>()).stem().string()] = file;
  }
  static constexpr std::array kNames = {"true.yaml",      "focal.yaml",  "large.yaml",
                                        "uncropped.yaml", "turned.yaml", "other.yaml"};

  [[nodiscard]] const json& footageOf(const std::string& name) const {
    return files.at(name).at("cameras").at(0).at("footage");
  }
  [[nodiscard]] std::string messageOf(const std::string& name) const {
    for (const json& check : files.at(name).at("cameras").at(0).at("checks"))
      if (check.at("id") == "footage") return check.at("message");
    return "no check";
  }
};

const Tested& tested() {
  static const Tested made;
  return made;
}

TEST(FootageCheckCommand, TellsARightCameraFromOneWithAnotherFocalLength) {
  const Tested& made = tested();
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

TEST(FootageCheckCommand, SaysHowImagesOfAnotherSizeWereMade) {
  const Tested& made = tested();
  struct Case {
    std::string name;
    std::string words;
    std::string flags;
  };
  int num_cases = 0;
  for (const Case& c : {Case{"large", "image resized without the file", "--resize 320x240"},
                        Case{"uncropped", "image cropped without the file", "--crop 40,30,320,240"},
                        Case{"turned", "image rotated without the file", "--rotate "}}) {
    SCOPED_TRACE(c.name);
    const std::string path = made.scratch.path(c.name + ".yaml");
    EXPECT_EQ(made.files.at(c.name).at("status"), "failure");
    EXPECT_EQ(made.footageOf(c.name).at("verdict"), "inconsistent");
    EXPECT_TRUE(made.footageOf(c.name).at("check").is_null());
    EXPECT_EQ(made.footageOf(c.name).at("edits").at(0).at("check").at("verdict"), "consistent");
    EXPECT_THAT(made.messageOf(c.name),
                AllOf(HasSubstr("inconsistent: " + c.words), HasSubstr("320x240"),
                      HasSubstr("next: alidade convert " + path + " -o OUT " + c.flags)));
    ++num_cases;
  }
  EXPECT_EQ(num_cases, 3);
  EXPECT_THAT(
      made.messageOf("other"),
      AllOf(HasSubstr("inconsistent: wrong image size; the images have 320x240 px, the file is for 640x480"),
            HasSubstr("neither cropped nor resized")));
}

// The command that is named makes a file that passes.
TEST(FootageCheckCommand, NamesACommandThatHelps) {
  const Tested& made = tested();
  const ScratchFolder scratch;
  const std::string out = scratch.path("small.yaml");
  ASSERT_THAT(runAlidade({"convert", made.scratch.path("large.yaml"), "-o", out, "--resize", "320x240"}),
              EndsWith(0));
  const RunResult result = runAlidade({"validate", out, "--footage", made.made.images});
  EXPECT_THAT(result, EndsWith(0));
  EXPECT_THAT(result.out, AllOf(testing::StartsWith("PASS  "), HasSubstr("footage: consistent: no "),
                                Not(HasSubstr("next:"))));
}

TEST(FootageCheckCommand, PrintsALinePerFileAndWhatToDo) {
  const Tested& made = tested();
  EXPECT_THAT(made.text, EndsWith(3));
  EXPECT_THAT(made.text.out, AllOf(HasSubstr("PASS  " + made.scratch.path("true.yaml")),
                                   HasSubstr("6 files: 1 passed"), HasSubstr("--resize 320x240: consistent"),
                                   HasSubstr("held-out error 0."), Not(HasSubstr("A file cannot show"))));
  const RunResult brief = runAlidade({"validate", made.scratch.path("focal.yaml"), "--footage",
                                      made.made.images, "--front-end", "flow", "--quiet"});
  EXPECT_THAT(brief, EndsWith(3));
  EXPECT_THAT(brief.out,
              AllOf(testing::StartsWith("FAIL  "), HasSubstr("footage: inconsistent: focal length -"),
                    HasSubstr("\n      next: ")));
  EXPECT_EQ(std::ranges::count(brief.out, '\n'), 2);
}

TEST(FootageCheckCommand, WritesJunitAndAPage) {
  const Tested& made = tested();
  pugi::xml_document xml;
  ASSERT_TRUE(xml.load_file(made.junit_path.c_str()));
  const pugi::xml_node suite = xml.child("testsuites").child("testsuite");
  std::map<std::string, int> num_of_class;
  int num_failed = 0;
  for (const pugi::xml_node test : suite.children("testcase")) {
    ++num_of_class[test.attribute("classname").value()];
    const std::string class_name = test.attribute("classname").value();
    if (class_name == "footage" && !test.child("failure").empty()) ++num_failed;
  }
  EXPECT_EQ(num_of_class["camera_file"], 6);
  EXPECT_EQ(num_of_class["footage"], 6);
  EXPECT_EQ(num_failed, 5);
  EXPECT_EQ(suite.attribute("tests").as_int(), 12);
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
    if (*c.gap != '\0') EXPECT_EQ(footage.at("check").at("gap"), c.gap);
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
  EXPECT_THAT(result.out,
              AllOf(testing::StartsWith("FAIL  "), HasSubstr("240x320"), HasSubstr("--rotate 90")));
}

TEST(FootageCheckCommand, RefusesWhatDoesNotGoWithIt) {
  const ScratchFolder scratch;
  EXPECT_THAT(runAlidade({"validate", walk().camera, "--front-end", "flow"}),
              FailsWith(2, HasSubstr("--footage")));
  EXPECT_THAT(checkFootage(walk().images, {"--front-end", "lines"}), FailsWith(2, HasSubstr("--front-end")));
  RigRecord record;
  for (const char* name : {"left", "right"}) {
    record.cameras.push_back({.camera = readCameraFile(walk().camera), .camera_from_rig = SE3()});
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
