// SPDX-License-Identifier: MIT
// Rigs in files of all tools: convert, validate and diff.
#include <nlohmann/json.hpp>

#include "alidade/files/formats/alidade_writer.h"
#include "alidade/files/rig_file.h"
#include "apps/command_line.h"

namespace alidade {
namespace {

using testing::AllOf;
using testing::HasSubstr;
using testing::Not;

// Two cameras 0.1 m apart, with standard deviations and a joint covariance.
RigRecord stereoRig() {
  RigRecord rig;
  for (int i = 0; i < 2; ++i) {
    const std::vector<double> parameters = {500.0 + i, 501, 320, 240};
    RigCameraRecord camera{
        .camera = bareRecord(AnyCamera::make("pinhole", parameters), {.width = 640, .height = 480}, ""),
        .camera_from_rig = {SO3::exp({0.01 * i, 0.02 * i, -0.03 * i}), {-0.1 * i, 0.01 * i, 0}}};
    camera.camera.name.name = i == 0 ? "left" : "right";
    camera.translation_std_m.setConstant(0.5 * i);
    camera.rotation_std_rad.setConstant(0.25 * i);
    camera.time_offset_s = 0.0125 * i;
    rig.cameras.push_back(std::move(camera));
  }
  rig.num_frames = 10;
  for (std::size_t row = 0; row < 4 + 4 + 6; ++row) {
    for (std::size_t column = 0; column <= row; ++column)
      rig.covariance.push_back(column < row ? 0.0 : row < 8 ? 1.0 : row < 11 ? 0.25 : 0.0625);
  }
  return rig;
}

class RigFiles : public testing::Test {
 protected:
  RigFiles() : rig_(scratch_.write("rig.yaml", rigFileText(stereoRig()) + "x_site: [roof]\n")) {}

  [[nodiscard]] RunResult convert(std::vector<std::string> args) const {
    args.insert(args.begin(), "convert");
    return runAlidade(args);
  }
  [[nodiscard]] std::string path(const std::string& name) const { return scratch_.path(name); }

  ScratchFolder scratch_;
  std::string rig_;
};

TEST_F(RigFiles, GoToEachFormatAndBack) {
  struct Case {
    std::string format;
    std::string file;
    std::vector<std::string> more;
  };
  int num_formats = 0;
  for (const auto& [format, file, more] :
       {Case{"opencv", "pair.yml", {}}, Case{"kalibr", "camchain.yaml", {}},
        Case{"basalt", "calibration.json", {}},
        Case{"colmap_rig", "rig_config.json", {"--image-size", "640x480"}},
        Case{"alidade", "again.yaml", {}}}) {
    const RunResult there = convert({rig_, "-o", path(file), "--to", format});
    ASSERT_THAT(there, EndsWith(0));
    EXPECT_THAT(there.out, HasSubstr(" mm from the first camera, turned by 2.144 degrees"));
    EXPECT_THAT(there.err, Not(HasSubstr("not written")));
    std::vector<std::string> back = {path(file), "-o", path("back.yaml")};
    back.insert(back.end(), more.begin(), more.end());
    ASSERT_THAT(convert(back), EndsWith(0));
    EXPECT_THAT(runAlidade({"diff", rig_, path("back.yaml"), "--tolerance", "1e-9"}), EndsWith(0)) << format;
    EXPECT_THAT(runAlidade({"validate", path(file)}).out, HasSubstr("0.1005 m apart")) << format;
    ++num_formats;
  }
  EXPECT_EQ(num_formats, 5);
}

TEST_F(RigFiles, StayWholeInTheirOwnFormat) {
  ASSERT_THAT(convert({rig_, "-o", path("again.yaml")}), EndsWith(0));
  const RigRecord before = loadRig(rig_);
  const RigRecord after = loadRig(path("again.yaml"));
  EXPECT_EQ(after.covariance, before.covariance);
  EXPECT_EQ(after.num_frames, 10);
  EXPECT_EQ(after.cameras[1].camera.name.name, "right");
  EXPECT_EQ(after.cameras[1].translation_std_m, before.cameras[1].translation_std_m);
  EXPECT_EQ(after.cameras[1].camera_from_rig.translation, before.cameras[1].camera_from_rig.translation);
  EXPECT_THAT(after.created_by, HasSubstr("convert of"));
  EXPECT_THAT(scratch_.read("again.yaml"), HasSubstr("\nx_site: [roof]\n"));
  // Of other lenses it is not known.
  ASSERT_THAT(convert({rig_, "-o", path("half.yaml"), "--resize", "320x240"}), EndsWith(0));
  const RigRecord half = loadRig(path("half.yaml"));
  EXPECT_TRUE(half.covariance.empty());
  EXPECT_EQ(half.cameras[1].camera.camera.parameters()[0], 250.5);
  EXPECT_EQ(half.cameras[1].rotation_std_rad, before.cameras[1].rotation_std_rad);
}

// A turned camera sees the same points at turned pixels: its frame turns with it.
TEST_F(RigFiles, TurnWithTheirCameras) {
  ASSERT_THAT(convert({rig_, "-o", path("turned.yaml"), "--rotate", "90"}), EndsWith(0));
  const RigRecord before = loadRig(rig_);
  const RigRecord after = loadRig(path("turned.yaml"));
  const Eigen::Vector3d point(0.3, -0.2, 2);
  for (std::size_t i = 0; i < 2; ++i) {
    const Eigen::Vector2d old =
        before.cameras[i].camera.camera.project(before.cameras[i].camera_from_rig * point).pixel;
    const Eigen::Vector2d now =
        after.cameras[i].camera.camera.project(after.cameras[i].camera_from_rig * point).pixel;
    EXPECT_LT((now - Eigen::Vector2d(479 - old.y(), old.x())).norm(), 1e-9);
  }
}

TEST_F(RigFiles, AreMadeOfFilesOfOneCamera) {
  const RunResult all = convert({rig_, "-o", path("all.cameramodel"), "--to", "mrcal"});
  EXPECT_THAT(all,
              FailsWith(1, AllOf(HasSubstr("2 cameras"), HasSubstr("alidade convert " + rig_ + "#left -o"))));
  for (const std::string name : {"left", "right"}) {
    const RunResult one = convert({rig_ + "#" + name, "-o", path(name + ".cameramodel"), "--to", "mrcal"});
    ASSERT_THAT(one, EndsWith(0));
    EXPECT_THAT(one.err, Not(HasSubstr("pose")));
  }
  ASSERT_THAT(convert({path("left.cameramodel"), path("right.cameramodel"), "-o", path("back.yaml")}),
              EndsWith(0));
  EXPECT_THAT(runAlidade({"diff", rig_, path("back.yaml"), "--tolerance", "1e-9"}), EndsWith(0));
  EXPECT_EQ(loadRig(path("back.yaml")).cameras[0].camera.name.name, "left");
  EXPECT_THAT(scratch_.read("back.yaml"), Not(HasSubstr("verdict")));  // nobody knows it
  // A file without a place for a pose says so.
  EXPECT_THAT(convert({rig_ + "#right", "-o", path("right.yaml")}).err,
              HasSubstr("the pose of the camera is not written"));
  EXPECT_THAT(convert({rig_ + "#left", "-o", path("left.yaml")}).err, Not(HasSubstr("pose")));
  EXPECT_THAT(convert({path("left.yaml"), path("right.yaml"), "-o", path("no.yaml")}),
              FailsWith(1, AllOf(HasSubstr("left.yaml"), HasSubstr("no pose"))));
  EXPECT_THAT(convert({path("left.cameramodel"), rig_, "-o", path("no.yaml")}),
              FailsWith(1, HasSubstr("rig.yaml#left")));
  EXPECT_THAT(convert({rig_ + "#left", rig_ + "#right", "-o", rig_}),
              FailsWith(2, HasSubstr("also an input")));
}

TEST_F(RigFiles, AreValidated) {
  const std::string good = scratch_.read("rig.yaml");
  EXPECT_THAT(runAlidade({"validate", rig_, "--verbose"}).out,
              AllOf(HasSubstr("PASS  extent"), HasSubstr("PASS  poses"), HasSubstr("PASS  rig_covariance"),
                    HasSubstr("PASS  rig_calibration"), Not(HasSubstr("WARN"))));
  struct Case {
    std::string from;
    std::string to;
    std::string row;
    int exit_code;
  };
  const std::vector<Case> cases = {
      {"[-0.1, 0.01, 0]", "[-100, 10, 0]", "WARN  extent", 0},
      {"[0.5, 0.5, 0.5]", "[0.5, 0.4, 0.5]", "FAIL  rig_covariance", 3},
      {"verdict: trustworthy", "verdict: rejected", "FAIL  rig_calibration", 3},
  };
  for (const Case& c : cases) {
    ASSERT_THAT(good, HasSubstr(c.from));
    const RunResult result =
        runAlidade({"validate", scratch_.write("odd.yaml", replaced(good, c.from, c.to)), "--verbose"});
    EXPECT_THAT(result.out, HasSubstr(c.row));
    EXPECT_EQ(result.exit_code, c.exit_code);
  }
  EXPECT_EQ(cases.size(), 3u);
  RigRecord copied = stereoRig();
  copied.cameras[1].camera_from_rig = copied.cameras[0].camera_from_rig;
  const RunResult same = runAlidade({"validate", scratch_.write("same.yaml", rigFileText(copied))});
  EXPECT_THAT(same, EndsWith(0));
  EXPECT_THAT(same.out, AllOf(HasSubstr("WARN"), HasSubstr("rig: poses: the same pose: left and right")));
  EXPECT_THAT(
      convert({scratch_.write("rejected.yaml", replaced(good, "verdict: trustworthy", "verdict: rejected")),
               "-o", path("no.yaml")}),
      EndsWith(3));
  EXPECT_THAT(nlohmann::json::parse(runAlidade({"validate", rig_, "--json"}).out)["files"][0]["rig_checks"],
              testing::SizeIs(4));
}

TEST_F(RigFiles, AreCompared) {
  RigRecord moved = stereoRig();
  moved.cameras[1].camera_from_rig.translation.x() -= 0.001;
  std::swap(moved.cameras[0], moved.cameras[1]);  // names tell
  moved.covariance.clear();
  const std::string other = scratch_.write("other.yaml", rigFileText(moved));
  const RunResult no = runAlidade({"diff", rig_, other, "--tolerance", "0.1", "--distance", "1m"});
  EXPECT_EQ(no.exit_code, 3);
  EXPECT_THAT(no.out, AllOf(HasSubstr("left       no difference"), HasSubstr("1 mm and 0 degrees different"),
                            HasSubstr("at 1 m from one camera")));
  EXPECT_THAT(no.out, testing::StartsWith("changed: "));
  EXPECT_THAT(no.err, HasSubstr("points from"));
  const RunResult yes = runAlidade({"diff", rig_, other, "--tolerance", "1", "--distance", "1m", "--json"});
  EXPECT_EQ(yes.exit_code, 0);
  const auto document = nlohmann::json::parse(yes.out);
  EXPECT_NEAR(document["cameras"][1]["place_difference_m"].get<double>(), 0.001, 1e-12);
  EXPECT_NEAR(document["cameras"][1]["transfer"]["rms_px"].get<double>(), 0.5, 0.1);  // 500 px * 1 mm / 1 m
  EXPECT_EQ(document["agrees"], true);

  EXPECT_THAT(runAlidade({"diff", rig_, rig_ + "#left"}),
              FailsWith(1, AllOf(HasSubstr("one camera"), HasSubstr("rig"))));
  RigRecord three = stereoRig();
  three.cameras.push_back(three.cameras[1]);
  three.cameras.back().camera.name.name = "third";
  three.covariance.clear();
  EXPECT_THAT(runAlidade({"diff", rig_, scratch_.write("three.yaml", rigFileText(three))}),
              FailsWith(1, HasSubstr("3 cameras: left, right, third")));
  ASSERT_THAT(convert({rig_, "-o", path("half.yaml"), "--resize", "320x240"}), EndsWith(0));
  EXPECT_THAT(runAlidade({"diff", rig_, path("half.yaml")}), FailsWith(1, HasSubstr("--resize 640x480")));
  EXPECT_THAT(runAlidade({"diff", rig_, other, "-o", path("x.svg")}), FailsWith(2, HasSubstr("two rigs")));
}

}  // namespace
}  // namespace alidade
