// SPDX-License-Identifier: MIT
#include <gmock/gmock.h>

#include <array>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "alidade/core/random.h"
#include "alidade/core/text.h"
#include "alidade/files.h"
#include "alidade/files/corners_file.h"
#include "alidade/files/hand_eye_file.h"
#include "alidade/files/robot_table.h"
#include "alidade/geometry/rotation_conversions.h"
#include "alidade/simulate/robot.h"
#include "apps/command_line.h"
#include "support/scratch_test.h"

namespace alidade {
namespace {

using testing::AllOf;
using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;
using testing::Not;

const AnyCamera& trueCamera() {
  static const AnyCamera camera =
      AnyCamera::make("radtan", std::vector<double>{510, 512, 324, 236, -0.25, 0.08, 5e-4, -3e-4, 0});
  return camera;
}

// A folder with corners.csv, poses.csv and camera.yaml of a robot that is good for 0.5 mrad and 0.2 mm.
class HandEyeCommand : public ScratchTest {
 protected:
  HandEyeCommand() { draw(CameraOn::kHand); }

  void draw(CameraOn camera_on, std::uint64_t seed = 5) {
    set_ = simulateRobot({.camera = trueCamera(),
                          .size = {.width = 640, .height = 480},
                          .board = Checkerboard{.columns = 9, .rows = 6, .square_m = 0.025},
                          .camera_on = camera_on,
                          .robot_noise = {.rotation_rad = 5e-4, .translation_m = 2e-4},
                          .corner_noise_px = 0.1},
                         seed);
    write();
  }
  void spoil(RobotMistake mistake) {
    Random random(1);
    apply(mistake, set_, random);
    write();
  }
  void write() const {
    writeCornersFile(path("corners.csv"),
                     {.boards = {set_.scene.board}, .views = set_.views, .comments = {}});
    scratch_.write("poses.csv", robotTableText(set_.robot.poses));
    saveCamera(path("camera.yaml"), bareRecord(trueCamera(), set_.scene.size, "a test"), "alidade");
  }

  // With corners.csv, poses.csv and the model radtan, which is not sought then.
  [[nodiscard]] RunResult calibrate(std::vector<std::string> more = {}) const {
    std::vector<std::string> args = {"handeye", "calibrate", "corners.csv", "--poses", "poses.csv"};
    if (std::ranges::find(more, "--camera") == more.end()) more.insert(more.end(), {"--model", "radtan"});
    args.insert(args.end(), more.begin(), more.end());
    return runAlidade(args, {.folder = scratch_.path()});
  }
  [[nodiscard]] double shiftOf(const HandEyeRecord& record) const {
    return (record.mount_from_camera.translation - set_.mount_from_camera.translation).norm();
  }
  [[nodiscard]] std::vector<std::string> written() const {
    std::vector<std::string> names = scratch_.list();
    std::erase_if(names, [](const std::string& name) {
      return name == "corners.csv" || name == "poses.csv" || name == "camera.yaml";
    });
    return names;
  }

  RobotSet set_{.scene = {.camera = trueCamera(), .size = {}, .board = Checkerboard{}}};
};

TEST_F(HandEyeCommand, WritesAFileThatStatesTheTransform) {
  for (const CameraOn camera_on : {CameraOn::kHand, CameraOn::kBase}) {
    draw(camera_on);
    const RunResult result = calibrate({"-o", "handeye.yaml", "--tolerance", "5mm", "--date", "2026-02-03"});
    EXPECT_THAT(result, EndsWith(0));
    EXPECT_THAT(result.out,
                AllOf(HasSubstr("Verdict   trustworthy\n"), HasSubstr("(95 %)"),
                      HasSubstr(fmt::format("Camera    on the {}", cameraOnName(camera_on))),
                      HasSubstr("15 of 15 images"), HasSubstr("Board     checkerboard:9x6:25mm at (")));
    EXPECT_THAT(result.err, HasSubstr("written to handeye.yaml"));
    const HandEyeRecord record = readHandEye(path("handeye.yaml"));
    EXPECT_EQ(record.camera_on, camera_on);
    EXPECT_LT(shiftOf(record), 2e-3);
    EXPECT_EQ(record.num_poses, 15);
    EXPECT_EQ(record.date, "2026-02-03");
    EXPECT_THAT(record.created_by, HasSubstr("alidade"));
    EXPECT_THAT(written(), ElementsAre("handeye.yaml"));
  }
}

TEST_F(HandEyeCommand, PrintsTheFileOrOneDocument) {
  const RunResult text = calibrate({"-o", "-", "--tolerance", "5mm"});
  EXPECT_THAT(text, EndsWith(0));
  EXPECT_LT(shiftOf(parseHandEye(text.out, "standard output")), 2e-3);
  EXPECT_THAT(text.err, HasSubstr("Verdict   trustworthy"));
  const RunResult result = calibrate({"--json", "--tolerance", "5mm"});
  EXPECT_THAT(result, EndsWith(0));
  const auto document = nlohmann::json::parse(result.out);
  std::vector<std::string> keys;
  for (const auto& [key, value] : document.items()) keys.push_back(key);
  EXPECT_THAT(keys,
              testing::UnorderedElementsAre("verdict", "camera_on", "gripper_from_camera", "base_from_board",
                                            "error_m", "tool_error_m", "board_distance_m", "robot_noise",
                                            "rms_px", "num_poses", "frames", "diagnoses", "next_pose"));
  EXPECT_EQ(document["verdict"], "trustworthy");
  EXPECT_EQ(document["frames"].size(), 15U);
  EXPECT_EQ(document["frames"][3]["image"], "003.png");
  EXPECT_LT(document["error_m"], 5e-3);
  EXPECT_THAT(written(), IsEmpty());
}

TEST_F(HandEyeCommand, WritesOtherFormats) {
  const std::vector<std::pair<std::string, std::string>> formats = {
      {"ros", "static_transform_publisher"}, {"urdf", "<joint"}, {"opencv", "R_cam2gripper"}};
  for (const auto& [format, word] : formats) {
    EXPECT_THAT(calibrate({"-o", "out", "--to", format, "--tolerance", "5mm"}), EndsWith(0)) << format;
    EXPECT_THAT(scratch_.read("out"), HasSubstr(word));
  }
  EXPECT_THAT(calibrate({"-o", "other", "--to", "kalibr"}), FailsWith(2, HasSubstr("urdf")));
  EXPECT_FALSE(scratch_.has("other"));
}

TEST_F(HandEyeCommand, KeepsTheLensOfACamera) {
  const RunResult result = calibrate({"--camera", "camera.yaml", "-o", "handeye.yaml", "--tolerance", "5mm"});
  EXPECT_THAT(result, EndsWith(0));
  EXPECT_EQ(readHandEye(path("handeye.yaml")).camera_name, "camera.yaml");
  EXPECT_LT(shiftOf(readHandEye(path("handeye.yaml"))), 1e-3);
  EXPECT_THAT(calibrate({"--camera", "camera.yaml", "--model", "radtan"}),
              FailsWith(2, HasSubstr("one of the two flags")));
  saveCamera(path("camera.yaml"), bareRecord(trueCamera(), {.width = 1280, .height = 960}, "another camera"),
             "alidade");
  EXPECT_THAT(calibrate({"--camera", "camera.yaml"}),
              FailsWith(1, AllOf(HasSubstr("1280x960"), HasSubstr("640x480"))));
}

TEST_F(HandEyeCommand, SaysWhenTheCameraIsAtTheOtherPlace) {
  const RunResult result = calibrate({"--camera-on", "base", "--tolerance", "5mm", "-o", "handeye.yaml"});
  EXPECT_THAT(result, EndsWith(0));
  EXPECT_THAT(result.out, AllOf(HasSubstr("usable with reservations"), HasSubstr("were inverted"),
                                HasSubstr("--camera-on")));
  EXPECT_THAT(readHandEye(path("handeye.yaml")).findings, ElementsAre("robot_poses_inverted"));
}

TEST_F(HandEyeCommand, WritesNothingThatMustNotBeUsed) {
  spoil(RobotMistake::kOtherRecording);
  scratch_.write("handeye.yaml", "before\n");
  const RunResult result = calibrate({"-o", "handeye.yaml"});
  EXPECT_THAT(result, EndsWith(3));
  EXPECT_THAT(result.out, AllOf(HasSubstr("contradict each other"), HasSubstr("matched by name")));
  EXPECT_EQ(scratch_.read("handeye.yaml"), "before\n");
  EXPECT_THAT(written(), ElementsAre("handeye.yaml"));
  const RunResult printed = calibrate({"-o", "-"});
  EXPECT_THAT(printed, EndsWith(3));
  EXPECT_THAT(printed.out, IsEmpty());
  // Without a transform there is nothing to keep.
  EXPECT_THAT(calibrate({"-o", "handeye.yaml", "--keep-untrustworthy"}), EndsWith(3));
  EXPECT_EQ(scratch_.read("handeye.yaml"), "before\n");
  draw(CameraOn::kHand);
  const RunResult kept = calibrate({"-o", "handeye.yaml", "--keep-untrustworthy", "--tolerance", "0.01mm"});
  EXPECT_THAT(kept, EndsWith(3));
  EXPECT_EQ(readHandEye(path("handeye.yaml")).verdict, Verdict::kNo);
}

TEST_F(HandEyeCommand, JudgesByTheTolerance) {
  EXPECT_THAT(calibrate({"--tolerance", "0.01mm"}), EndsWith(3));
  EXPECT_THAT(calibrate({"--tolerance", "0"}), FailsWith(2, HasSubstr("--tolerance")));
  EXPECT_THAT(calibrate({"--tolerance", "1"}),
              FailsWith(2, HasSubstr("a length above 0 with its unit, such as 1mm")));
  EXPECT_THAT(calibrate({"--tolerance", "-1mm"}), FailsWith(2, HasSubstr("--tolerance")));
}

// What the doctor says of simulated robots with each mistake, and of sound ones.
TEST_F(HandEyeCommand, NamesTheMistakesOfSimulatedRobots) {
  const std::vector<std::pair<std::string, std::string>> mistakes = {
      {"", ""},
      {"quaternion_order", "robot_poses_misread"},
      {"millimetres", "robot_poses_misread"},
      {"degrees", "robot_poses_misread"},
      {"euler_order", "robot_poses_misread"},
      {"inverted", "robot_poses_inverted"},
      {"left_handed", "robot_mirrored"},
      {"other_recording", "robot_contradicts"},
      {"shifted", "robot_poses_shifted"},
      {"swapped", "robot_poses_swapped"},
      {"board_moved", "robot_board_moved"},
      {"one_pose_wrong", "robot_poses_left_out"},
      {"mirrored_images", "robot_mirrored"}};
  int num_named = 0;
  int num_sound = 0;
  for (const auto& [mistake, id] : mistakes) {
    for (const int seed : {1, 2}) {
      scratch_.write("scene.yaml",
                     fmt::format("alidade_scene: 1\ncamera: camera.yaml\nboard: checkerboard:9x6:25mm\n"
                                 "robot: {{camera_on: hand, poses: 15{}}}\nseed: {}\n"
                                 "corner_noise_px: 0.1\n",
                                 mistake.empty() ? "" : ", mistake: " + mistake, seed));
      ASSERT_THAT(
          runAlidade({"simulate", path("scene.yaml"), "-o", path("robot"), "--truth-only", "--overwrite"}),
          EndsWith(0));
      const RunResult result = runAlidade({"handeye", "calibrate", path("robot/corners.csv"), "--poses",
                                           path("robot/robot.csv"), "--model", "radtan", "--camera-on",
                                           "hand", "--json", "--tolerance", "5mm", "-o", path("found.yaml")});
      std::vector<std::string> ids;
      const auto document = nlohmann::json::parse(result.out);
      for (const auto& diagnosis : document.at("diagnoses")) ids.push_back(diagnosis.at("id"));
      std::erase(ids, "camera_on_found");
      if (id.empty()) {
        EXPECT_THAT(ids, IsEmpty()) << seed;
        const SE3 truth = readHandEye(path("robot/handeye.yaml")).mount_from_camera;
        EXPECT_LT((truth.inverse() * readHandEye(path("found.yaml")).mount_from_camera).log().norm(), 4e-3);
        ++num_sound;
      } else {
        EXPECT_THAT(ids, testing::Contains(id)) << mistake << " " << seed;
        ++num_named;
      }
    }
  }
  EXPECT_EQ(num_named, 24);
  EXPECT_EQ(num_sound, 2);
}

TEST_F(HandEyeCommand, NamesTheFileWhereACameraIsWanted) {
  ASSERT_THAT(calibrate({"-o", "handeye.yaml", "--tolerance", "5mm"}), EndsWith(0));
  scratch_.write("points.csv", "1 2 3\n");
  const auto names = AllOf(HasSubstr("a hand-eye file, which says where a camera is on a robot"),
                           HasSubstr("alidade handeye validate"));
  const RunResult result = runAlidade({"validate", path("handeye.yaml")});
  EXPECT_EQ(result.exit_code, 3);
  EXPECT_THAT(result.out, names);
  EXPECT_THAT(runAlidade({"convert", path("handeye.yaml"), "--to", "ros", "-o", path("out.yaml")}),
              FailsWith(1, names));
  EXPECT_THAT(runAlidade({"project", path("handeye.yaml"), path("points.csv")}), FailsWith(1, names));
}

TEST_F(HandEyeCommand, SaysWhereToDriveNext) {
  const RunResult text = calibrate({"--tolerance", "5mm"});
  EXPECT_THAT(text.out, HasSubstr("Next      drive the gripper to "));
  const auto document = nlohmann::json::parse(calibrate({"--tolerance", "5mm", "--json"}).out);
  EXPECT_LT(document.at("next_pose").at("error_m").get<double>(), document.at("error_m").get<double>());
}

TEST_F(HandEyeCommand, ReadsTablesAsPeopleNameTheirColumns) {
  ASSERT_THAT(calibrate({"-o", "one.yaml", "--tolerance", "5mm"}), EndsWith(0));
  const std::string header = "image,x_m,y_m,z_m,qx,qy,qz,qw";
  const std::string table = scratch_.read("poses.csv");
  int num_read = 0;
  for (const char* other : {"filename,pos_x,pos_y,pos_z,qx,qy,qz,qw", "file,px,py,pz,qx,qy,qz,qw",
                            "name,position_x_m,position_y_m,position_z_m,qx,qy,qz,qw"}) {
    scratch_.write("poses.csv", replaced(table, header, other));
    ASSERT_THAT(calibrate({"-o", "other.yaml", "--tolerance", "5mm"}), EndsWith(0)) << other;
    EXPECT_EQ(scratch_.read("one.yaml"), scratch_.read("other.yaml")) << other;
    ++num_read;
  }
  EXPECT_EQ(num_read, 3);
}

TEST_F(HandEyeCommand, ShowsEachImageIfAsked) {
  spoil(RobotMistake::kOnePoseWrong);
  const RunResult result = calibrate({"--verbose", "--tolerance", "5mm"});
  EXPECT_THAT(result, EndsWith(0));
  EXPECT_THAT(result.out, AllOf(HasSubstr("14 of 15 images"), HasSubstr("\n  000.png: "),
                                HasSubstr("robot and image disagree here"), HasSubstr("left out")));
}

TEST_F(HandEyeCommand, RefusesWrongTables) {
  struct Case {
    std::string text;
    std::string found;
  };
  const std::string header = "image,x_m,y_m,z_m,qx,qy,qz,qw\n";
  const std::vector<Case> cases = {
      {"", "poses.csv"},
      {header, "poses.csv"},
      {header + "000.png,0,0,0,0,0,0,1\n001.png,0,0,0,0,0,0,1\n", "2 poses"},
      {header + "000.png,nan,0,0,0,0,0,1\n", "poses.csv:2"},
      {header + "a,0,0,0,0,0,0,1\nb,0,0,0,0,0,0,1\nc,0,0,0,0,0,0,1\n", "name the images"}};
  for (const auto& [text, found] : cases) {
    scratch_.write("poses.csv", text);
    EXPECT_THAT(calibrate({"-o", "handeye.yaml"}), FailsWith(1, HasSubstr(found))) << text;
  }
  EXPECT_EQ(cases.size(), 5U);
  EXPECT_THAT(written(), IsEmpty());
}

TEST_F(HandEyeCommand, OverwritesNoInput) {
  const std::string before = scratch_.read("poses.csv");
  EXPECT_THAT(calibrate({"-o", "poses.csv"}), FailsWith(2, HasSubstr("poses.csv")));
  EXPECT_THAT(calibrate({"-o", "corners.csv"}), FailsWith(2, HasSubstr("corners.csv")));
  EXPECT_THAT(calibrate({"--camera", "camera.yaml", "-o", "camera.yaml"}),
              FailsWith(2, HasSubstr("camera.yaml")));
  EXPECT_EQ(scratch_.read("poses.csv"), before);
}

// The views of a robot by turns in two files, with one table.
TEST_F(HandEyeCommand, IsTestedOnOtherImagesAndAgainstOtherFiles) {
  for (const CameraOn camera_on : {CameraOn::kHand, CameraOn::kBase}) {
    draw(camera_on);
    std::array<CornersFile, 2> halves;
    for (std::size_t i = 0; i < set_.views.size(); ++i) {
      halves[i % 2].boards = {set_.scene.board};
      halves[i % 2].views.push_back(set_.views[i]);
    }
    writeCornersFile(path("first.csv"), halves[0]);
    writeCornersFile(path("second.csv"), halves[1]);
    const auto run = [&](const std::string& command) {
      std::vector<std::string> args = {"handeye"};
      for (const std::string_view word : split(command, ' ')) args.emplace_back(word);
      return runAlidade(args, {.folder = scratch_.path()});
    };
    const std::string poses = " --poses poses.csv --model radtan --tolerance 10mm";
    ASSERT_THAT(run("calibrate first.csv -o handeye.yaml" + poses), EndsWith(0));
    const RunResult same = run("validate handeye.yaml second.csv" + poses);
    EXPECT_THAT(same, EndsWith(0));
    EXPECT_THAT(same.out, HasSubstr("PASS"));
    HandEyeRecord moved = readHandEye(path("handeye.yaml"));
    moved.mount_from_camera.translation.x() += 0.02;
    scratch_.write("moved.yaml", handEyeText(moved));
    const RunResult elsewhere = run("validate moved.yaml second.csv" + poses);
    EXPECT_THAT(elsewhere, EndsWith(3));
    EXPECT_THAT(elsewhere.err, HasSubstr("error: a point at 0.4"));
    EXPECT_THAT(elsewhere.err, HasSubstr("more than 10 mm"));
    EXPECT_THAT(elsewhere.out, HasSubstr("FAILED"));
    const auto document = nlohmann::json::parse(run("validate moved.yaml second.csv --json" + poses).out);
    EXPECT_EQ(document.at("verdict"), "FAILED");
    EXPECT_NEAR(document.at("translation_difference_m").get<double>(), 0.02, 2e-3);
    const RunResult open =
        run("validate handeye.yaml second.csv --poses poses.csv --model radtan --tolerance 0.01mm");
    EXPECT_THAT(open, EndsWith(3));
    EXPECT_THAT(open.err, HasSubstr("could be chance"));
    EXPECT_THAT(run("validate handeye.yaml handeye.yaml"), EndsWith(0));
    const RunResult files = run("validate handeye.yaml moved.yaml");
    EXPECT_THAT(files, EndsWith(3));
    EXPECT_THAT(files.err, HasSubstr("20 mm elsewhere"));
    EXPECT_THAT(run("validate handeye.yaml second.csv"), FailsWith(2, HasSubstr("--poses poses.csv")));
  }
}

}  // namespace
}  // namespace alidade
