// SPDX-License-Identifier: MIT
#include <array>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "alidade/core/random.h"
#include "alidade/core/text.h"
#include "alidade/files/pose_list.h"
#include "apps/command_line.h"

namespace alidade {
namespace {

using testing::AllOf;
using testing::HasSubstr;

constexpr double kSamePose = 1e-12;  // some roundings of numbers near 1

RunResult pose(std::vector<std::string> args, const std::string& input = "") {
  args.insert(args.begin(), "pose");
  return runAlidade(args, {.input = input});
}

SE3 randomPose(Random& random) {
  const auto draw = [&] { return random.uniform(-2, 2); };
  SE3::Tangent xi;
  for (double& value : xi) value = draw();
  return SE3::exp(xi);
}

double difference(const SE3& a, const SE3& b) {
  return (a.matrix() - b.matrix()).cwiseAbs().maxCoeff();
}

// The stated pose of the only line of a text.
NamedPose statedIn(const std::string& text) {
  return readAnyPoses("{" + text.substr(1), "", std::nullopt).poses.at(0);
}

const std::string kForms =
    "quaternion_xyzw quaternion_wxyz rotation_vector_rad rotation_vector_deg axis_angle_rad axis_angle_deg "
    "rotation_matrix matrix matrix_3x4 xyz_xyzw euler_zyx_rad euler_zyx_deg euler_xyz_deg euler_zxz_rad "
    "euler_yxy_deg euler_fixed_xyz_rad euler_fixed_zxy_deg";

TEST(PoseForms, EachReadsWhatItWrites) {
  Random random(41);
  std::size_t num_checked = 0;
  for (const std::string_view name : split(kForms, ' ')) {
    const PoseForm form = findPoseForm(std::string(name)).value();
    for (int i = 0; i < 50; ++i, ++num_checked) {
      const SE3 given = randomPose(random);
      bool gimbal_lock = false;
      const NamedPose back = form.read(form.write(given, gimbal_lock));
      EXPECT_FALSE(gimbal_lock);
      EXPECT_LT(difference({back.stated.rotation, given.translation}, given), kSamePose) << name;
      if (form.hasTranslation()) {
        EXPECT_LT(difference(back.stated, given), kSamePose) << name;
      }
    }
  }
  EXPECT_EQ(num_checked, 17u * 50u);
}

TEST(PoseCommand, ConvertsToEachFormAndBack) {
  Random random(42);
  std::size_t num_checked = 0;
  for (const std::string_view name : split(kForms, ' ')) {
    const SE3 given = randomPose(random);
    std::vector<std::string> none;
    const std::string text = poseText({{.stated = given, .frames = "rig_from_board"}}, "matrix", none);
    const RunResult there = pose({text, "--to", std::string(name)});
    ASSERT_THAT(there, EndsWith(0)) << there.err;
    EXPECT_THAT(there.out,
                AllOf(HasSubstr("{rig_from_board: {" + std::string(name) + ": ["), HasSubstr("}}\n")));
    const NamedPose back = statedIn(pose({"-", "--to", "matrix"}, there.out).out);
    EXPECT_EQ(back.frames, "rig_from_board");
    EXPECT_LT(difference(back.stated, given), kSamePose) << name;
    ++num_checked;
  }
  EXPECT_EQ(num_checked, 17u);
}

TEST(PoseCommand, ReadsWhatOtherProgramsWrite) {
  // A quarter turn about z, moved by (1, 2, 3), in the direction of each program.
  struct Case {
    std::string input;
    std::string frames{};
    std::vector<std::string> flags{};
  };
  const std::string s = "0.7071067811865476";
  const std::vector<Case> cases = {
      {"{rvec: [0, 0, 1.5707963267948966], tvec: [1, 2, 3]}", "camera_from_object"},
      {"{rvec: [[0], [0], [1.5707963267948966]], tvec: [[1], [2], [3]]}", "camera_from_object"},
      {fmt::format("{{position: {{x: 1, y: 2, z: 3}}, orientation: {{x: 0, y: 0, z: {0}, w: {0}}}}}", s)},
      {fmt::format("{{translation: {{x: 1, y: 2, z: 3}}, rotation: {{x: 0, y: 0, z: {0}, w: {0}}}}}", s)},
      {"{camera_to_world: {R: [[0, -1, 0], [1, 0, 0], [0, 0, 1]], t: [1, 2, 3]}}", "world_from_camera"},
      {"{w2c: [[0, -1, 0, 1], [1, 0, 0, 2], [0, 0, 1, 3], [0, 0, 0, 1]]}", "camera_from_world"},
      {"{transform_matrix: [[0, 1, 0, 1], [1, 0, 0, 2], [0, 0, -1, 3], [0, 0, 0, 1]]}", "world_from_camera"},
      {"{\"fl_x\": 500, \"frames\": [{\"file_path\": \"a.png\", \"transform_matrix\": [[0, 1, 0, 1], [1, 0, 0, 2], "
       "[0, 0, -1, 3], [0, 0, 0, 1]]}]}",
       "world_from_camera"},
      {fmt::format("1 2 3 0 0 {0} {0}\n", s)},
      {fmt::format("17.5 1 2 3 0 0 {0} {0}\n", s), "world_from_camera"},
      {"0 -1 0 1 1 0 0 2 0 0 1 3\n", "world_from_camera"},
      {"0 -1 0 1 1 0 0 2 0 0 1 3 0 0 0 1\n"},
      {"[[0, -1, 0, 1],\n [1, 0, 0, 2],\n [0, 0, 1, 3]]\n"},
      {fmt::format("# Image list\n7 {0} 0 0 {0} 1 2 3 1 a b.jpg\n", s), "camera_from_world"},
      {"0 -1 0 1\n1 0 0 2\n0 0 1 3\n0 0 0 1\n", "", {"--from", "matrix"}},
      {fmt::format("id,x,y,z,qx,qy,qz,qw\na,1,2,3,0,0,{0},{0}\n", s),
       "camera_from_world",
       {"--poses-are", "world_to_camera"}},
  };
  SE3 expected;
  expected.rotation = SO3::exp({0, 0, 1.5707963267948966});
  expected.translation = {1, 2, 3};
  std::size_t num_read = 0;
  for (const Case& c : cases) {
    std::vector<std::string> args = {"-", "--to", "matrix"};
    args.insert(args.end(), c.flags.begin(), c.flags.end());
    const RunResult result = pose(args, c.input);
    ASSERT_THAT(result, EndsWith(0)) << c.input << result.err;
    const NamedPose read = statedIn(result.out);
    EXPECT_EQ(read.frames, c.frames) << c.input;
    EXPECT_LT(difference(read.stated, expected), kSamePose) << c.input;
    ++num_read;
  }
  EXPECT_EQ(num_read, 16u);
}

TEST(PoseCommand, SkipsThePointsOfColmapsImages) {
  const std::string images =
      "# IMAGE_ID, QW, QX, QY, QZ, TX, TY, TZ, CAMERA_ID, NAME\n1 1 0 0 0 1 2 3 1 a b.jpg\n10.5 20 -1 30 40 7\n"
      "2 1 0 0 0 0 0 1 1 c.jpg\n\n";
  const RunResult csv = pose({"-", "--to", "csv"}, images);
  EXPECT_EQ(csv.out, "id,tx,ty,tz,qx,qy,qz,qw\na b.jpg,1,2,3,0,0,0,1\nc.jpg,0,0,1,0,0,0,1\n");
  const RunResult kitti = pose({"-", "--to", "kitti"}, images);
  EXPECT_EQ(kitti.out, "1 0 0 -1 0 1 0 -2 0 0 1 -3\n1 0 0 0 0 1 0 0 0 0 1 -1\n");
  EXPECT_THAT(kitti.err, HasSubstr("so the poses are inverted"));
  EXPECT_THAT(pose({"-", "--to", "tum"}, images), FailsWith(2, HasSubstr("--to csv")));
  EXPECT_THAT(pose({"-"}, "1 1 0 0 0 1 2 3 1 a.jpg\n\n2 1 0 0 0 0 0 1\n3 1 0 0 0 1 2 3 1 c.jpg\n\n"),
              FailsWith(1, HasSubstr("standard input:3")));
}

TEST(PoseCommand, ComposesInvertsAndRelates) {
  Random random(43);
  const SE3 a = randomPose(random);
  const SE3 b = randomPose(random);
  std::vector<std::string> none;
  const auto text = [&](const SE3& value, const char* frames) {
    return poseText({{.stated = value, .frames = frames}}, "quaternion_wxyz", none);
  };
  const NamedPose composed =
      statedIn(pose({text(a, "world_from_rig"), "--compose", text(b, "rig_from_camera")}).out);
  EXPECT_EQ(composed.frames, "world_from_camera");
  EXPECT_LT(difference(composed.stated, a * b), kSamePose);
  const NamedPose relative =
      statedIn(pose({text(a, "world_from_left"), "--relative-to", text(b, "world_from_right")}).out);
  EXPECT_EQ(relative.frames, "right_from_left");
  EXPECT_LT(difference(relative.stated, b.inverse() * a), kSamePose);
  const NamedPose inverted = statedIn(pose({text(a, "world_from_left"), "--invert"}).out);
  EXPECT_EQ(inverted.frames, "left_from_world");
  EXPECT_LT(difference(inverted.stated, a.inverse()), kSamePose);
  EXPECT_THAT(pose({text(a, "world_from_rig"), "--compose", text(b, "camera_from_rig")}),
              FailsWith(1, AllOf(HasSubstr("rig and camera"), HasSubstr("--invert"))));
}

TEST(PoseCommand, StatesTheMeanAndItsSpread) {
  // Turned about z by -10, 0 and 10 degrees, and moved along x by -1, 0 and 1.
  std::string rows;
  for (const int i : {-1, 0, 1})
    rows += fmt::format("- {{euler_zyx_deg: [{}, 0, 0], translation_m: [{}, 0, 0]}}\n", 10 * i, i);
  const RunResult result = pose({"-", "--mean", "--json"}, rows);
  ASSERT_THAT(result, EndsWith(0));
  EXPECT_THAT(result.err, HasSubstr("mean of 3 poses; they are 8.165 degrees and 0.8165 m (RMS) from it"));
  const auto document = nlohmann::json::parse(result.out);
  EXPECT_NEAR(document.at("spread").at("rms_angle_rad").get<double>(), 0.1425055, 1e-6);
  EXPECT_NEAR(document.at("spread").at("rms_distance_m").get<double>(), 0.816497, 1e-6);
  EXPECT_NEAR(document.at("poses").at(0).at("quaternion_xyzw").at(3).get<double>(), 1, 1e-12);
  const std::string opposed =
      "- {rotation_vector_deg: [0, 0, 100]}\n- {rotation_vector_deg: [0, 0, -100]}\n- {rotation_vector_deg: [0, 0, 0]}\n";
  EXPECT_THAT(pose({"-", "--mean"}, opposed).err, HasSubstr("another one may be as good a mean"));
}

TEST(PoseCommand, ReportsGimbalLockAndQuaternionsOfAnotherLength) {
  const RunResult locked = pose({"{euler_zyx_deg: [30, 90, 10]}", "--to", "euler_zyx_deg"});
  ASSERT_THAT(locked, EndsWith(0));
  EXPECT_THAT(locked.err, HasSubstr("gimbal lock"));
  EXPECT_EQ(pose({"{euler_zyx_deg: [30, 80, 10]}", "--to", "euler_zyx_deg"}).err, "");
  EXPECT_THAT(pose({"{quaternion_xyzw: [0, 0, 0, 1.01]}"}).err, HasSubstr("length 1.01 instead of 1"));
  EXPECT_EQ(pose({"{quaternion_xyzw: [0, 0, 0, 1.0005]}"}).err, "");
  EXPECT_EQ(pose({"{quaternion_xyzw: [0, 0, 0, 1.01]}", "--quiet"}).err, "");
}

TEST(PoseCommand, SaysWhatToTypeInstead) {
  const ScratchFolder scratch;
  const std::string table = scratch.write("t.csv", "id,tx,ty,tz,qx,qy,qz,qw\na,1,2,3,0,0,0,1\n");
  const std::string image = scratch.write("image.png", std::string("\x89PNG\r\n\x1a\n\0\0", 10));
  struct Case {
    int code;
    std::vector<std::string> args;
    std::string found;
    std::string next;
  };
  const std::vector<Case> cases = {
      {2, {table, "--too", "csv"}, "--too", "did you mean '--to'?"},
      {2, {table, "--to", "quaternon_xyzw"}, "quaternon_xyzw", "did you mean 'quaternion_xyzw'?"},
      {2,
       {table, "--to", "euler_zyx"},
       "euler_zyx",
       "write euler_zyx_deg for degrees or euler_zyx_rad for radians"},
      {2, {table, "--to", "tum"}, "pose 'a'", "--to csv"},
      {1, {"{rotation_vector: [0, 0, 1]}"}, "no unit", "rotation_vector_deg"},
      {1, {"{quaternion: [0, 0, 0, 1]}"}, "unknown key 'quaternion'", "quaternion_wxyz: [w, x, y, z]"},
      {1, {"{rpy: [0, 0, 1]}"}, "unknown key 'rpy'", "euler_fixed_xyz_rad: [roll, pitch, yaw]"},
      {1, {"0 0 0 1"}, "4 columns without a header", "--from FORM"},
      {1,
       {"0 0 1", "--from", "quaternion_xyzw"},
       "found 3 numbers",
       "4 per pose of the form quaternion_xyzw"},
      {1, {table, "--from", "quaternion_xyzw"}, "found 'id'", "needs no --from"},
      {1, {"[[0, 1, 0], [1, 0, 0], [0, 0, 1]]"}, "a reflection, its determinant is -1", "right-handed"},
      {1, {"[[1, 0.1, 0], [0, 1, 0], [0, 0, 1]]"}, "column 1 has length 1.00", "more digits"},
      {1, {scratch.path("")}, "folder", "file"},
      {1, {scratch.path("s.csv")}, "s.csv", "did you mean"},
      {1, {image}, "image.png", "zero byte"},
      {1, {"-"}, "standard input: no pose", "alidade pose --help"},
      {1, {table, "-o", scratch.path("none/out.csv")}, "none", "folder"},
      {2, {table, "-o", table}, "also an input", "choose another name"},
      {2, {table, "--poses-are", "backwards"}, "backwards", "camera_to_world"},
  };
  std::size_t num_answered = 0;
  for (const Case& c : cases) {
    EXPECT_THAT(pose(c.args), FailsWith(c.code, AllOf(HasSubstr(c.found), HasSubstr(c.next)))) << c.found;
    ++num_answered;
  }
  EXPECT_EQ(num_answered, 19u);
}

TEST(PoseCommand, WritesTheFileInsteadOfStandardOutput) {
  const ScratchFolder scratch;
  const RunResult result =
      pose({"{rvec: [0, 0, 0], tvec: [1, 2, 3]}", "-o", scratch.path("pose.yaml"), "--json"});
  ASSERT_THAT(result, EndsWith(0));
  EXPECT_EQ(scratch.read("pose.yaml"),
            "{camera_from_object: {quaternion_xyzw: [0, 0, 0, 1], translation_m: [1, 2, 3]}}\n");
  EXPECT_EQ(nlohmann::json::parse(result.out).at("poses").at(0).at("frames"), "camera_from_object");
}

}  // namespace
}  // namespace alidade
