// SPDX-License-Identifier: MIT
#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "apps/project_support.h"

namespace alidade {
namespace {

using testing::AllOf;
using testing::HasSubstr;

const std::string kPoints = "0,0,1\n0.2,0.1,1.5\n-0.1,0.3,2\n";

// Poses given as a file, and the flags that go with it.
struct PoseFileCase {
  std::string content;
  std::vector<std::string> flags{};
  bool has_names = true;  ///< the ids are a and b, not 1 and 2
};

RunResult projectAll(const PoseFileCase& c, std::vector<std::string> more = {}) {
  const ScratchFolder scratch;
  std::vector<std::string> args = {"--poses", scratch.write("poses", c.content)};
  args.insert(args.end(), c.flags.begin(), c.flags.end());
  args.insert(args.end(), more.begin(), more.end());
  return project(kPoints, args);
}

TEST(Poses, ProjectsAllPointsForEachPose) {
  // Three poses without a turn, and the same as single ones.
  const std::vector<std::string> singles = {
      "{rotation_vector_rad: [0, 0, 0], translation_m: [0, 0, 1]}",
      "{rotation_vector_rad: [0, 0, 0], translation_m: [0.1, 0, 2]}",
      "{rotation_vector_rad: [0, 0, 0], translation_m: [0, -0.2, -1.2]}"};
  const RunResult all = projectAll({fmt::format("- {}\n- {}\n- {}\n", singles[0], singles[1], singles[2])});
  ASSERT_THAT(all, EndsWith(0));
  std::string expected = "pose,u,v,status\n";
  for (std::size_t i = 0; i < singles.size(); ++i) {
    for (const auto& row : rowsOf(project(kPoints, {"--pose", singles[i]}).out))
      expected += fmt::format("{},{},{},{}\n", i, row.at(0), row.at(1), row.at(2));
  }
  EXPECT_EQ(all.out, expected);
  EXPECT_EQ(rowsOf(all.out).size(), 9u);
  EXPECT_EQ(all.err, "8 ok, 1 behind\n");
}

TEST(Poses, ReadsThemAsTheyAreCommonlyWritten) {
  // Two poses: a quarter turn about z, moved by (0.1, -0.2, 1); and no turn, moved by (0, 0, 2). The camera
  // stands at (0.2, 0.1, -1) and (0, 0, -2).
  const std::string s = "0.7071067811865476";
  const std::vector<PoseFileCase> cases = {
      {fmt::format("- {{id: a, quaternion_xyzw: [0, 0, {0}, {0}], translation_m: [0.1, -0.2, 1]}}\n"
                   "- {{id: b, quaternion_xyzw: [0, 0, 0, 1], translation_m: [0, 0, 2]}}\n",
                   s)},
      {"poses:\n  - id: a\n    camera_from_world: {euler_zyx_deg: [90, 0, 0], translation_m: [0.1, -0.2, "
       "1]}\n"
       "  - id: b\n    world_from_camera: {rotation_vector_rad: [0, 0, 0], translation_m: [0, 0, -2]}\n"},
      {"[{id: a, matrix: [[0, -1, 0, 0.1], [1, 0, 0, -0.2], [0, 0, 1, 1], [0, 0, 0, 1]]},\n"
       " {id: b, rotation_vector_rad: [0, 0, 0], translation_m: [0, 0, 2]}]\n"},
      // As the simulator writes them.
      {fmt::format(
          "- {{image: a, camera_from_board: {{quaternion_xyzw: [0, 0, {0}, {0}], translation_m: [0.1, -0.2, "
          "1]}}}}\n- {{image: c, id: b, quaternion_xyzw: [0, 0, 0, 1], translation_m: [0, 0, 2]}}\n",
          s)},
      {fmt::format("- {{id: a, quaternion_xyzw: [0, 0, -{0}, {0}], translation_m: [0.2, 0.1, -1]}}\n"
                   "- {{id: b, quaternion_wxyz: [1, 0, 0, 0], translation_m: [0, 0, -2]}}\n",
                   s),
       {"--poses-are", "world_from_camera"}},
      // Tables.
      {fmt::format("id,tx,ty,tz,qx,qy,qz,qw\na,0.1,-0.2,1,0,0,{0},{0}\nb,0,0,2,0,0,0,1\n", s),
       {"--poses-are", "camera_from_world"}},
      {fmt::format("qw,qx,qy,qz,x,y,z,name,score\n{0},0,0,{0},0.1,-0.2,1,a,7\n1,0,0,0,0,0,2,b,8\n", s),
       {"--poses-are", "camera_from_world"}},
      {"\xef\xbb\xbf\"Image\";\"TX [m]\";\"TY [m]\";\"TZ [m]\";\"RX (rad)\";RY;RZ\r\n"
       "a;0.2;0.1;-1;0;0;-1.5707963267948966\r\nb;0;0;-2;0;0;0\r\n",
       {"--poses-are", "world_from_camera"}},
      {fmt::format("# id tx ty tz qw qx qy qz\n1 0.1 -0.2 1 {0} 0 0 {0}\n2 0 0 2 1 0 0 0\n", s),
       {"--poses-are", "camera_from_world"},
       false},
      {fmt::format("# timestamp tx ty tz qx qy qz qw\n1 0.2 0.1 -1 0 0 -{0} {0}\n2 0 0 -2 0 0 0 1\n", s),
       {},
       false},
      {fmt::format("1 0.2 0.1 -1 0 0 -{0} {0}\n2 0 0 -2 0 0 0 1\n", s), {}, false},
      // Other programs' words.
      {"- {id: a, rvec: [0, 0, 1.5707963267948966], tvec: [0.1, -0.2, 1]}\n"
       "- {id: b, camera_to_world: {rotation_vector_deg: [0, 0, 0], translation_m: [0, 0, -2]}}\n"},
      {fmt::format("id,tx,ty,tz,qx,qy,qz,qw\na,0.2,0.1,-1,0,0,-{0},{0}\nb,0,0,-2,0,0,0,1\n", s),
       {"--poses-are", "camera_to_world"}},
      {fmt::format(
          "# IMAGE_ID, QW, QX, QY, QZ, TX, TY, TZ, CAMERA_ID, NAME\n1 {0} 0 0 {0} 0.1 -0.2 1 1 a\n1.5 2 3\n"
          "2 1 0 0 0 0 0 2 1 b\n\n",
          s)},
      {"{\"frames\": [{\"file_path\": \"a\", \"transform_matrix\": [[0, -1, 0, 0.2], [-1, 0, 0, 0.1], [0, 0, -1, -1], "
       "[0, 0, 0, 1]]}, {\"file_path\": \"b\", \"transform_matrix\": [[1, 0, 0, 0], [0, -1, 0, 0], [0, 0, -1, -2], "
       "[0, 0, 0, 1]]}]}\n"},
  };
  constexpr double kSamePx = 1e-9;  // the forms carry 16 digits
  std::vector<std::vector<std::string>> expected;
  std::size_t num_files = 0;
  for (const PoseFileCase& c : cases) {
    const RunResult result = projectAll(c);
    ASSERT_THAT(result, EndsWith(0)) << c.content << result.err;
    const auto rows = rowsOf(result.out);
    ASSERT_EQ(rows.size(), 6u);
    if (expected.empty()) expected = rows;
    for (std::size_t i = 0; i < rows.size(); ++i) {
      EXPECT_EQ(rows[i].at(0), c.has_names ? (i < 3 ? "a" : "b") : (i < 3 ? "1" : "2"));
      EXPECT_EQ(rows[i].at(3), "ok");
      for (const std::size_t k : {1u, 2u})
        EXPECT_NEAR(numberIn(rows[i].at(k)), numberIn(expected[i].at(k)), kSamePx) << c.content;
    }
    ++num_files;
  }
  EXPECT_EQ(num_files, 15u);
}

TEST(Poses, SaysThatItTakesEightColumnsForATrajectory) {
  const std::string row = "1305031102.1758 0 0 -2 0 0 0 1\n";
  const RunResult assumed = projectAll({row});
  EXPECT_THAT(assumed.err, AllOf(HasSubstr("TUM trajectory"), HasSubstr("world_from_camera")));
  EXPECT_EQ(rowsOf(assumed.out).at(0).at(0), "1305031102.1758");
  EXPECT_EQ(projectAll({row, {"--poses-are", "world_from_camera"}}).err, "3 ok\n");
  EXPECT_EQ(projectAll({"# timestamp tx ty tz qx qy qz qw\n" + row}).err, "3 ok\n");
  EXPECT_EQ(projectAll({row, {"--poses-are", "camera_from_world"}}).err, "3 behind\n");
}

TEST(Poses, WritesTheirIdsAsCsvAndJsonDo) {
  const PoseFileCase c{"id,tx,ty,tz,rx,ry,rz\n\"a,\"\"b\"\"\",0,0,0,0,0,0\n",
                       {"--poses-are", "camera_from_world"}};
  EXPECT_THAT(projectAll(c).out, HasSubstr("\n\"a,\"\"b\"\"\",322.5,238.1,ok\n"));
  const auto points = nlohmann::json::parse(projectAll(c, {"--json", "--jacobian"}).out).at("points");
  ASSERT_EQ(points.size(), 3u);
  for (const auto& point : points) {
    EXPECT_EQ(point.at("pose"), "a,\"b\"");
    EXPECT_EQ(point.size(), 40u);
  }
}

TEST(Poses, NamesWhatIsWrong) {
  struct Case {
    PoseFileCase file;
    std::string found;
    std::string expected;
  };
  const std::vector<std::string> forward = {"--poses-are", "camera_from_world"};
  const std::vector<Case> cases = {
      {{""}, "poses: no pose", "a table with one row per pose"},
      {{"# nothing\n"}, "poses: no pose", "a table with one row per pose"},
      {{"tx,ty,tz,qx,qy,qz,qw\n"}, "poses:1: found poses without a direction", "--poses-are"},
      {{"# timestamp tx ty tz qw qx qy qz\n0 0 0 0 1 0 0 0\n"},
       "poses:2: found poses without a direction",
       "--poses-are"},
      {{"tx,ty,tz,qx,qy,qz,qw\n", forward}, "poses: no pose", "one row per pose"},
      {{"0 0 0 0 0 0 1\n"}, "poses:1: found poses without a direction", "--poses-are"},
      {{"0 0 0 0 0 1\n"}, "poses:1: found 6 columns without a header", "add a header"},
      {{"1 0 0 0 1 0 0 0 1\n", forward}, "poses: rotations without translations", "poses"},
      {{"- {imu_from_world: {rvec: [0, 0, 0], tvec: [0, 0, 0]}}\n"},
       "unknown key 'imu_from_world'",
       "one of"},
      {{"tx,ty,tz\n0,0,0\n", forward}, "poses:1: found no column qx in the header tx,ty,tz", "rx,ry,rz"},
      {{"tx,ty,tz,qx,qy,qz,qw,rx\n", forward},
       "poses:1: found both a quaternion and a rotation",
       "one rotation"},
      {{"tx_mm,ty,tz,rx,ry,rz\n", forward}, "poses:1: found the column 'tx_mm'", "metres"},
      {{"tx,ty,tz,rx_deg,ry_deg,rz_deg\n", forward}, "poses:1: found the column 'rx_deg'", "radians"},
      {{"tx,ty,tz,rx,ry,rz\n0,0,0,0,0,0\n0,0,zero,0,0,0\n", forward},
       "poses:3: found 'zero' as tz",
       "a number"},
      {{"tx,ty,tz,rx,ry,rz\n0,0,0,0,nan,0\n", forward}, "poses:2: found 'nan' as ry", "a finite number"},
      {{"tx,ty,tz,rx,ry,rz\n0,0,0,0,0\n", forward}, "poses:2: found 5 fields", "6 as in the previous rows"},
      {{"1 0 0 0 0 0 0 0\n"}, "poses:1: found a quaternion of length 0", "length 1"},
      {{"1 0 0 0 0 0 0 2\n"}, "poses:1: found a quaternion of length 2", "length 1"},
      {{"1 0 0 0 0 0 0 1\n1 0 0 1 0 0 0 1\n"}, "poses:2: found the pose '1' twice", "once"},
      {{"- {id: 1, camera_from_world: {rotation_vector_rad: [0, 0, 0]}}\n"},
       "poses:1: [0].camera_from_world",
       "translation_m"},
      {{"- {id: 1, translation_m: [0, 0, 0]}\n"}, "poses:1: [0]: found no rotation", "quaternion_xyzw"},
      {{"- {idd: 1, translation_m: [0, 0, 0]}\n"}, "unknown key 'idd'", "did you mean 'id'?"},
      {{"- {id: 1, matrix: [[1, 0, 0, 0], [0, 1, 0, 0], [0, 0, 1, 0], [0, 0, 0, 1]], translation_m: [0, 0, "
        "0]}\n"},
       "'matrix' and 'translation_m'",
       "only 'matrix'"},
      {{"- {camera_from_world: {rotation_vector_rad: [0, 0, 0], translation_m: [0, 0, 0]}}\n", forward},
       "poses:1: [0]: found a key that names the frames",
       "remove --poses-are"},
      {{"- {id: 1, rotation_vector_rad: [0, 0, 0], translation_m: [0, 0, 0]}\n"
        "- {id: 1, rotation_vector_rad: [0, 0, 0], translation_m: [0, 0, 0]}\n"},
       "poses:2: [1]: found the pose '1' twice",
       "once"},
  };
  std::size_t num_refused = 0;
  for (const Case& c : cases) {
    const RunResult result = projectAll(c.file);
    EXPECT_THAT(result, FailsWith(1, AllOf(HasSubstr(c.found), HasSubstr(c.expected)))) << c.file.content;
    ++num_refused;
  }
  EXPECT_EQ(num_refused, 25u);
}

TEST(Poses, KnowsManyFromOne) {
  const ScratchFolder scratch;
  const std::string list =
      scratch.write("list.yaml", "- {rotation_vector_rad: [0, 0, 0], translation_m: [0, 0, 1]}\n");
  const std::string table = scratch.write("table.txt", "1 0 0 0 0 0 0 1\n");
  for (const std::string& path : {list, table})
    EXPECT_THAT(project(kPoints, {"--pose", path}), FailsWith(1, HasSubstr("use --poses")));
  const std::string one =
      scratch.write("one.yaml", "{rotation_vector_rad: [0, 0, 0], translation_m: [0, 0, 1]}");
  EXPECT_EQ(project(kPoints, {"--poses", one}).out, project(kPoints, {"--poses", list}).out);
  EXPECT_THAT(project(kPoints, {"--poses", one, "--pose", one}),
              FailsWith(2, HasSubstr("both --pose and --poses")));
  EXPECT_THAT(project(kPoints, {"--poses-are", "world_from_camera"}),
              FailsWith(2, HasSubstr("--poses-are without --poses")));
  EXPECT_THAT(project(kPoints, {"--poses", one, "--poses-are", "backwards"}),
              FailsWith(2, HasSubstr("world_from_camera")));
  EXPECT_THAT(project(kPoints, {"--poses", scratch.path("lis.yaml")}),
              FailsWith(1, HasSubstr("did you mean")));
  EXPECT_EQ(project("", {"--poses", one}).out, "pose,u,v,status\n");
}

}  // namespace
}  // namespace alidade
