// SPDX-License-Identifier: MIT
// Tables of robot poses, against matrices that are multiplied here as the makers define them.
#include "alidade/files/robot_table.h"

#include <cmath>
#include <functional>
#include <numbers>
#include <random>
#include <set>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "alidade/core/error.h"
#include "alidade/core/text.h"
#include "support/message_of.h"
#include "support/mutator.h"

namespace alidade {
namespace {

using Eigen::Matrix3d;
using Eigen::Matrix4d;
using Numbers = std::vector<double>;

constexpr int kNumPoses = 25;

// Elementary rotations of the right hand.
Matrix3d turnX(double a) {
  Matrix3d m;
  m << 1, 0, 0, 0, std::cos(a), -std::sin(a), 0, std::sin(a), std::cos(a);
  return m;
}
Matrix3d turnY(double a) {
  Matrix3d m;
  m << std::cos(a), 0, std::sin(a), 0, 1, 0, -std::sin(a), 0, std::cos(a);
  return m;
}
Matrix3d turnZ(double a) {
  Matrix3d m;
  m << std::cos(a), -std::sin(a), 0, std::sin(a), std::cos(a), 0, 0, 0, 1;
  return m;
}
// Rodrigues' formula.
Matrix3d turnAbout(double x, double y, double z) {
  const double angle = std::sqrt(x * x + y * y + z * z);
  Matrix3d k;
  k << 0, -z, y, z, 0, -x, -y, x, 0;
  k /= angle;
  return Matrix3d::Identity() + std::sin(angle) * k + (1 - std::cos(angle)) * k * k;
}
Matrix3d ofQuaternion(double w, double x, double y, double z) {
  Matrix3d m;
  m << 1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y),  //
      2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x),   //
      2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y);
  return m;
}
double radians(double degrees) {
  return degrees * std::numbers::pi / 180;
}

// Draws numbers of rotations.
struct Draw {
  std::mt19937 random{7};
  double operator()(double size) { return std::uniform_real_distribution<double>(-size, size)(random); }
  Numbers angles(double size) {
    Draw& draw = *this;
    return {draw(size), draw(size), draw(size)};
  }
  Numbers unit() {
    Eigen::Vector4d q((*this)(1), (*this)(1), (*this)(1), (*this)(1));
    q.normalize();
    return {q[0], q[1], q[2], q[3]};
  }
  Numbers rotation() {  // row by row
    const Numbers q = unit();
    const Matrix3d m = ofQuaternion(q[0], q[1], q[2], q[3]).transpose();
    return {m.data(), m.data() + 9};
  }
};

Matrix3d fromRows(const Numbers& n) {
  return Eigen::Map<const Matrix3d>(n.data()).transpose();
}

// A way to state poses: how rotations are drawn, what they mean by definition, and how the numbers of a row
// follow from x, y, z (metres) and them.
struct Convention {
  std::string form;
  std::function<Numbers(Draw&)> draw;
  std::function<Matrix3d(const Numbers&)> rotation;
  double units_per_m = 1;
  std::function<Numbers(const Numbers&, const Numbers&)> row = [](Numbers t, const Numbers& r) {
    t.insert(t.end(), r.begin(), r.end());
    return t;
  };
};

Numbers drawDegrees(Draw& draw) {
  return draw.angles(180);
}
Numbers drawRadians(Draw& draw) {
  return draw.angles(1.7);
}
Numbers drawUnit(Draw& draw) {
  return draw.unit();
}
Numbers drawRotation(Draw& draw) {
  return draw.rotation();
}
Matrix3d zyx(const Numbers& n) {
  return turnZ(n[0]) * turnY(n[1]) * turnX(n[2]);
}
Matrix3d fixedXyz(const Numbers& n) {
  return turnZ(n[2]) * turnY(n[1]) * turnX(n[0]);
}
Matrix3d xyz(const Numbers& n) {
  return turnX(n[0]) * turnY(n[1]) * turnZ(n[2]);
}
Matrix3d vector(const Numbers& n) {
  return turnAbout(n[0], n[1], n[2]);
}
Matrix3d wxyz(const Numbers& n) {
  return ofQuaternion(n[0], n[1], n[2], n[3]);
}
Matrix3d xyzw(const Numbers& n) {
  return ofQuaternion(n[3], n[0], n[1], n[2]);
}
std::function<Matrix3d(const Numbers&)> inDegrees(Matrix3d (*of)(const Numbers&)) {
  return [of](Numbers n) {
    for (double& value : n) value = radians(value);
    return of(n);
  };
}
Numbers matrixRow(const Numbers& t, const Numbers& r) {
  return {r[0], r[1], r[2], t[0], r[3], r[4], r[5], t[1], r[6], r[7], r[8], t[2], 0, 0, 0, 1};
}
Numbers matrixColumns(const Numbers& t, const Numbers& r) {
  return {r[0], r[3], r[6], 0, r[1], r[4], r[7], 0, r[2], r[5], r[8], 0, t[0], t[1], t[2], 1};
}
Numbers shortMatrixRow(const Numbers& t, const Numbers& r) {
  Numbers row = matrixRow(t, r);
  row.resize(12);
  return row;
}

const std::vector<Convention>& conventions() {
  static const std::vector<Convention> kAll = {{"kuka", drawDegrees, inDegrees(zyx), 1000},
                                               {"abb", drawUnit, wxyz, 1000},
                                               {"ur", drawRadians, vector},
                                               {"fanuc", drawDegrees, inDegrees(fixedXyz), 1000},
                                               {"staubli", drawDegrees, inDegrees(xyz), 1000},
                                               {"franka", drawRotation, fromRows, 1, matrixColumns},
                                               {"matrix", drawRotation, fromRows, 1, matrixRow},
                                               {"matrix_3x4", drawRotation, fromRows, 1, shortMatrixRow},
                                               {"quaternion_xyzw", drawUnit, xyzw},
                                               {"quaternion_wxyz", drawUnit, wxyz},
                                               {"rotation_vector_rad", drawRadians, vector},
                                               {"rotation_vector_deg", drawDegrees, inDegrees(vector)},
                                               {"euler_zyx_deg", drawDegrees, inDegrees(zyx)},
                                               {"euler_zyx_rad", drawRadians, zyx},
                                               {"euler_fixed_xyz_deg", drawDegrees, inDegrees(fixedXyz)},
                                               {"euler_fixed_xyz_rad", drawRadians, fixedXyz},
                                               {"euler_xyz_deg", drawDegrees, inDegrees(xyz)},
                                               {"euler_xyz_rad", drawRadians, xyz}};
  return kAll;
}
const Convention& conventionOf(const std::string& form) {
  for (const Convention& convention : conventions()) {
    if (convention.form == form) return convention;
  }
  throw std::logic_error(form);
}

struct Drawn {
  std::string text;
  std::vector<Matrix4d> truth;
};
Drawn drawTable(const Convention& convention, const std::string& separator = ",", bool has_name = true) {
  Draw draw;
  Drawn drawn;
  for (int i = 0; i < kNumPoses; ++i) {
    const Numbers t = draw.angles(1.5);
    const Numbers r = convention.draw(draw);
    Matrix4d pose = Matrix4d::Identity();
    pose.topLeftCorner<3, 3>() = convention.rotation(r);
    pose.topRightCorner<3, 1>() << t[0], t[1], t[2];
    drawn.truth.push_back(pose);
    const double scale = convention.units_per_m;
    Numbers row = convention.row({t[0] * scale, t[1] * scale, t[2] * scale}, r);
    if (has_name) drawn.text += "image" + std::to_string(i) + ".png" + separator;
    for (std::size_t k = 0; k < row.size(); ++k) drawn.text += (k == 0 ? "" : separator) + exactText(row[k]);
    drawn.text += "\n";
  }
  return drawn;
}

bool areEqual(const std::vector<RobotPose>& poses, const std::vector<Matrix4d>& truth) {
  if (poses.size() != truth.size()) return false;
  for (std::size_t i = 0; i < poses.size(); ++i) {
    if (!((poses[i].base_from_gripper.matrix() - truth[i]).cwiseAbs().maxCoeff() < 1e-12)) return false;
  }
  return true;
}

TEST(RobotTable, ReadsTheConventionsOfMakers) {
  int num_checked = 0;
  for (const Convention& convention : conventions()) {
    for (const std::string separator : {",", ";", " ", "\t", " , "}) {
      for (const bool has_name : {true, false}) {
        const Drawn drawn = drawTable(convention, separator, has_name);
        const RobotTable table = parseRobotTable(drawn.text, "poses.csv", {convention.form});
        EXPECT_TRUE(areEqual(table.poses, drawn.truth)) << convention.form;
        ASSERT_EQ(table.poses.size(), drawn.truth.size());
        EXPECT_EQ(table.poses[3].image, has_name ? "image3.png" : "");
        ++num_checked;
      }
    }
  }
  EXPECT_EQ(num_checked, 180);
}

TEST(RobotTable, FindsOutWhatRowsWithoutAFormMean) {
  int num_checked = 0;
  for (const char* form : {"ur", "quaternion_xyzw", "matrix_3x4", "matrix", "franka"}) {
    for (const bool has_name : {true, false}) {
      const Drawn drawn = drawTable(conventionOf(form), ",", has_name);
      EXPECT_TRUE(areEqual(parseRobotTable(drawn.text, "poses.csv").poses, drawn.truth)) << form;
      ++num_checked;
    }
  }
  EXPECT_EQ(num_checked, 10);
  const RobotTable tum =
      parseRobotTable("# ground truth\n# file: x\n1305031102.1 1 2 3 0.6 0 0 0.8\n", "tum.txt");
  ASSERT_EQ(tum.poses.size(), 1U);
  EXPECT_EQ(tum.poses[0].image, "1305031102.1");
  EXPECT_NEAR(tum.poses[0].base_from_gripper.rotation.quaternion().x(), 0.6, 1e-15);
}

TEST(RobotTable, ReadsHeaders) {
  struct Header {
    std::string text;
    std::string form;     // stated
    std::string meaning;  // of the rotation
    double units_per_m = 1;
  };
  const std::vector<Header> kHeaders = {
      {"image,x_m,y_m,z_m,qx,qy,qz,qw", "", "quaternion_xyzw"},
      {"image,x_mm,y_mm,z_mm,qx,qy,qz,qw", "", "quaternion_xyzw", 1000},
      {"image,x_mm,y_mm,z_mm,qx,qy,qz,qw", "abb", "quaternion_xyzw", 1000},
      {"image,x,y,z,qx,qy,qz,qw", "abb", "quaternion_xyzw", 1000},
      {"name,X,Y,Z,Qx,Qy,Qz,Qw", "", "quaternion_xyzw"},
      {"id,tx,ty,tz,q1,q2,q3,q4", "", "quaternion_wxyz", 1000},
      {"timestamp,tx_m,ty_m,tz_m,q1,q2,q3,q4", "", "quaternion_wxyz"},
      {"time [s],x [mm],y [mm],z [mm],rx,ry,rz", "", "rotation_vector_rad", 1000},
      {"image,x,y,z,rx,ry,rz", "", "rotation_vector_rad"},
      {"image,x,y,z,rx_deg,ry_deg,rz_deg", "", "rotation_vector_deg"},
      {"image,x,y,z,rx,ry,rz", "staubli", "euler_xyz_deg", 1000},
      {"image,x_m,y_m,z_m,rx,ry,rz", "staubli", "euler_xyz_deg"},
      {"image,x_m,y_m,z_m,rx_rad,ry_rad,rz_rad", "staubli", "euler_xyz_rad"},
      {"image,X,Y,Z,A,B,C", "", "euler_zyx_deg", 1000},
      {"image,X,Y,Z,W,P,R", "", "euler_fixed_xyz_deg", 1000},
      {"image,x,y,z,roll,pitch,yaw", "", "euler_fixed_xyz_rad"},
      {"image,x,y,z,roll_deg,pitch_deg,yaw_deg", "", "euler_fixed_xyz_deg"},
  };
  int num_checked = 0;
  for (const Header& header : kHeaders) {
    Convention convention = conventionOf(header.meaning);
    convention.units_per_m = header.units_per_m;
    const Drawn drawn = drawTable(convention);
    for (const char* mark : {"", "# ", "\xef\xbb\xbf"}) {
      const RobotTable table =
          parseRobotTable(mark + header.text + "\r\n" + drawn.text, "p.csv", {header.form});
      EXPECT_TRUE(areEqual(table.poses, drawn.truth)) << header.text;
      EXPECT_EQ(table.poses.at(24).image, "image24.png");
      ++num_checked;
    }
  }
  EXPECT_EQ(num_checked, 51);
  const RobotTable table = parseRobotTable(
      "qw;z_mm;time;qx;qy;x_mm;qz;y_mm;image\n0.8;3000;7;0.6;0;1000;0;2000;a b.png\n", "p.csv");
  ASSERT_EQ(table.poses.size(), 1U);
  EXPECT_EQ(table.poses[0].image, "a b.png");
  EXPECT_EQ(table.poses[0].base_from_gripper.translation, Eigen::Vector3d(1, 2, 3));
  EXPECT_NEAR(table.poses[0].base_from_gripper.rotation.quaternion().x(), 0.6, 1e-15);
}

// A table of `is` that is taken for one of `stated`: one of the other readings must be the truth.
TEST(RobotTable, OtherReadingsAreTheTruthAfterMistakes) {
  struct Mistake {
    std::string is;
    std::string stated;
    std::string how;
  };
  const std::string kZyx = "Euler angles as Rz(a) Ry(b) Rx(c)";
  const std::string kFixed = "Euler angles as Rz(c) Ry(b) Rx(a)";
  const std::string kXyz = "Euler angles as Rx(a) Ry(b) Rz(c)";
  const std::string kVector = "the angles as a rotation vector";
  const std::vector<Mistake> kMistakes = {
      {"quaternion_wxyz", "quaternion_xyzw", "the quaternion as w, x, y, z"},
      {"quaternion_xyzw", "quaternion_wxyz", "the quaternion as x, y, z, w"},
      {"rotation_vector_deg", "rotation_vector_rad", "angles in degrees"},
      {"rotation_vector_rad", "rotation_vector_deg", "angles in radians"},
      {"euler_zyx_deg", "euler_zyx_rad", "angles in degrees"},
      {"euler_zyx_rad", "euler_zyx_deg", "angles in radians"},
      {"euler_zyx_rad", "rotation_vector_rad", kZyx},
      {"euler_fixed_xyz_rad", "rotation_vector_rad", kFixed},
      {"euler_xyz_rad", "rotation_vector_rad", kXyz},
      {"euler_zyx_deg", "rotation_vector_rad", kZyx + " in degrees"},
      {"euler_fixed_xyz_deg", "rotation_vector_rad", kFixed + " in degrees"},
      {"euler_xyz_deg", "rotation_vector_rad", kXyz + " in degrees"},
      {"euler_fixed_xyz_deg", "euler_zyx_deg", kFixed},
      {"euler_xyz_deg", "euler_zyx_deg", kXyz},
      {"rotation_vector_deg", "euler_zyx_deg", kVector},
      {"rotation_vector_rad", "euler_zyx_deg", kVector + " in radians"},
      {"euler_fixed_xyz_rad", "euler_zyx_deg", kFixed + " in radians"},
      {"euler_xyz_rad", "euler_zyx_deg", kXyz + " in radians"},
      {"euler_zyx_deg", "euler_xyz_deg", kZyx},
      {"euler_fixed_xyz_deg", "euler_xyz_deg", kFixed},
      {"euler_xyz_deg", "euler_fixed_xyz_deg", kXyz},
      {"rotation_vector_rad", "euler_xyz_rad", kVector},
      {"rotation_vector_deg", "euler_xyz_rad", kVector + " in degrees"},
      {"euler_zyx_rad", "euler_xyz_deg", kZyx + " in radians"},
  };
  int num_checked = 0;
  std::set<std::string> proven;
  for (const Mistake& mistake : kMistakes) {
    for (const std::string unit : {"", "millimetres"}) {
      Convention is = conventionOf(mistake.is);
      is.units_per_m = unit.empty() ? 1 : 1000;
      const Drawn drawn = drawTable(is);
      const std::string how = mistake.how + (unit.empty() ? "" : ", and translations in " + unit);
      const RobotTable table = parseRobotTable(drawn.text, "p.csv", {mistake.stated});
      EXPECT_FALSE(areEqual(table.poses, drawn.truth));
      EXPECT_LE(table.others.size(), 12U);
      int num_true = 0;
      for (const RobotReading& other : table.others) {
        EXPECT_FALSE(other.how.empty());
        EXPECT_EQ(areEqual(other.poses, drawn.truth), other.how == how)
            << mistake.stated << ": " << other.how;
        num_true += other.how == how ? 1 : 0;
        EXPECT_EQ(other.poses.back().image, "image24.png");
      }
      EXPECT_EQ(num_true, 1) << how;
      proven.insert(how);
      ++num_checked;
    }
  }
  EXPECT_EQ(num_checked, 48);
  // Every reading that tables of these forms have is the truth of one of the mistakes.
  for (const Mistake& mistake : kMistakes) {
    for (const RobotReading& other :
         parseRobotTable(drawTable(conventionOf(mistake.is)).text, "p.csv", {mistake.stated}).others)
      EXPECT_TRUE(proven.contains(other.how) || other.how == "translations in millimetres") << other.how;
  }
}

TEST(RobotTable, OtherReadingsChangeTheUnitOfLength) {
  int num_checked = 0;
  for (const Convention& convention : conventions()) {
    Convention is = convention;
    is.units_per_m = convention.units_per_m == 1 ? 1000 : 1;
    const Drawn drawn = drawTable(is);
    const std::string how = is.units_per_m == 1 ? "translations in metres" : "translations in millimetres";
    for (const RobotReading& other : parseRobotTable(drawn.text, "p.csv", {is.form}).others) {
      EXPECT_EQ(areEqual(other.poses, drawn.truth), other.how == how) << is.form << ": " << other.how;
      num_checked += other.how == how ? 1 : 0;
    }
  }
  EXPECT_EQ(num_checked, 18);
}

TEST(RobotTable, OtherReadingsOfMatricesExchangeRowsAndColumns) {
  int num_checked = 0;
  for (const char* form : {"matrix", "matrix_3x4", "franka"}) {
    Convention is = conventionOf(form);
    is.rotation = [](const Numbers& n) -> Matrix3d { return Eigen::Map<const Matrix3d>(n.data()); };
    const Drawn drawn = drawTable(is);
    const RobotTable table = parseRobotTable(drawn.text, "p.csv", {form});
    EXPECT_FALSE(areEqual(table.poses, drawn.truth));
    ASSERT_EQ(table.others.size(), 3U);
    EXPECT_EQ(table.others[0].how, "columns of the matrices as rows");
    EXPECT_TRUE(areEqual(table.others[0].poses, drawn.truth));
    EXPECT_EQ(table.others[2].how, "columns of the matrices as rows, and translations in millimetres");
    ++num_checked;
  }
  EXPECT_EQ(num_checked, 3);
}

TEST(RobotTable, NamesFaultAndLine) {
  struct Fault {
    std::string text;
    std::string form;
    std::string message;  // a part of it
  };
  const std::string kHeader = "image,x_m,y_m,z_m,qx,qy,qz,qw\n";
  const std::vector<Fault> kFaults = {
      {"", "", "p.csv: no poses"},
      {"# nothing\n" + kHeader, "", "p.csv: no poses"},
      {kHeader + "a,1,2,3,0,0,0,1\nb,1,2,3,0,0,1\n", "", "p.csv:3: found 7 fields"},
      {"1 2 3 0 0 0\n\n1 2 3 0 0\n", "", "p.csv:3: found 5 fields"},
      {kHeader + "a,1,nan,3,0,0,0,1\n", "", "p.csv:2: found 'nan' as number 3"},
      {kHeader + "a,1,2,3,0,0,0,inf\n", "", "p.csv:2: found 'inf' as number 8"},
      {kHeader + "a,1,2,1e200,0,0,0,1\n", "", "p.csv:2: found '1e200' as number 4"},
      {kHeader + "a,1,2,x,0,0,0,1\n", "", "p.csv:2: found 'x' as number 4"},
      {kHeader + "a,1,2,3,0,0,0,1\nb,1,2,3,0,0,0.5,1\n", "", "p.csv:3: found a quaternion of length 1.118"},
      {kHeader + "a,1,2,3,0,0,0,0\n", "", "p.csv:2: quaternion"},
      {"1 2 3 0 0 0 1.02\n", "", "perhaps the numbers have another form"},
      {"1 0 0 1 0 1 0 2 0 0 1.02 3\n", "", "p.csv:1: rotation matrix: column 2 has length 1.02"},
      {"1 0 0 1 0 1 0 2 0 0 -1 3\n", "", "a reflection"},
      {"1 0 0 0 0 1 0 0 0 0 1 0 1 2 3 1\n", "matrix", "p.csv:1: homogeneous matrix: the last row is 1 2 3 1"},
      {"image,x_m,y_m,z_m,qx,qy,qz,qw,joint1\n", "", "p.csv:1: found unknown column 'joint1'"},
      {"image,x_cm,y_cm,z_cm,qx,qy,qz,qw\n", "", "unknown column 'x_cm'"},
      {"image,x,x,y,z,qx,qy,qz,qw\n", "", "two columns 'x'"},
      {"image,x,y,z,qx,qy,qz,qw,rx,ry,rz\n", "", "unknown column 'rx'"},
      {kHeader + "a,1,2,3,0,0,0,1\na,1,2,3,0,0,0,1\n", "", "p.csv:3: found 'a' twice"},
      {"a 1 2 3 0 0 0\na 1 2 3 0 0 0\n", "", "p.csv:2: found 'a' twice"},
      {"image,qx,qy,qz,qw\na,0,0,0,1\n", "", "p.csv:1: found no translation"},
      {"image,x,y,z\na,0,0,0\n", "", "p.csv:1: found no rotation"},
      {"0 0 0 1\n", "", "p.csv:1: found 4 columns without a header"},
      {"a 0 0 0 1\n", "quaternion_xyzw", "7 numbers, alone or behind a name"},
      {"1 0 0 0 1 0 0 0 1\n", "", "9 columns without a header"},
      {kHeader, "kuka", "those of the stated form, 6 numbers"},
      {"1,2;3\n", "", "both commas and semicolons"},
  };
  int num_checked = 0;
  for (const auto& [text, form, message] : kFaults) {
    const std::string told = messageOf([&] { (void)parseRobotTable(text, "p.csv", {form}); });
    EXPECT_NE(told.find(message), std::string::npos) << told;
    ++num_checked;
  }
  EXPECT_EQ(num_checked, 27);
  for (const char* form : {"mitsubishi", "euler_zyx", "rotation_matrix", "xyz_xyzw", "axis_angle_deg"}) {
    try {
      (void)parseRobotTable("1 2 3 0 0 0\n", "p.csv", {form});
      ADD_FAILURE() << form;
    } catch (const Error& error) {
      EXPECT_EQ(error.code(), ErrorCode::kUsage);
    }
  }
  EXPECT_THROW((void)readRobotTable("/nowhere/poses.csv"), Error);
}

// Pendants show three decimals.
TEST(RobotTable, AllowsForFewDigits) {
  const RobotTable quaternion = parseRobotTable("a 0.1 0.2 0.3 0.35 0.35 0.61 0.62\n", "p.txt");
  EXPECT_NEAR(quaternion.poses.at(0).base_from_gripper.rotation.quaternion().norm(), 1, 1e-15);
  const RobotTable matrix = parseRobotTable("0.866 -0.5 0 1 0.5 0.866 0 2 0 0 1 3\n", "p.txt");
  EXPECT_NEAR(matrix.poses.at(0).base_from_gripper.rotation.log().z(), std::numbers::pi / 6, 1e-3);
}

TEST(RobotTable, DamageNeverSurprises) {
  int num_read = 0;
  int num_refused = 0;
  for (std::uint32_t seed = 0; seed < 3000; ++seed) {
    const Convention& is = conventions()[seed % conventions().size()];
    Mutator mutate(seed);
    const std::string header = is.form == "quaternion_xyzw" ? "image,x_m,y_m,z_m,qx,qy,qz,qw\n" : "";
    const std::string rows = drawTable(is, ",", seed % 2 == 0).text;
    const std::string text = mutate(header + rows.substr(0, rows.find('\n', 500)));
    try {
      const RobotTable table = parseRobotTable(text, "p.csv", {seed % 3 == 0 ? "" : is.form});
      for (const RobotPose& pose : table.poses)
        EXPECT_TRUE(pose.base_from_gripper.matrix().allFinite()) << text;
      for (const RobotReading& other : table.others) EXPECT_EQ(other.poses.size(), table.poses.size());
      ++num_read;
    } catch (const Error& error) {
      EXPECT_EQ(error.code(), ErrorCode::kInput);
      EXPECT_EQ(std::string(error.what()).find("p.csv"), 0U) << error.what();
      ++num_refused;
    }
  }
  EXPECT_EQ(num_read + num_refused, 3000);
  EXPECT_GT(num_refused, 500);
  EXPECT_GT(num_read, 500);
}

TEST(RobotTable, RefusesAFormThatTheHeaderContradicts) {
  const std::string rows = "image,x_m,y_m,z_m,qx,qy,qz,qw\n0,1,2,3,0,0,0,1\n";
  EXPECT_THAT([&] { static_cast<void>(parseRobotTable(rows, "poses.csv", {.form = "quaternion_wxyz"})); },
              testing::ThrowsMessage<Error>(testing::HasSubstr("which name the order quaternion_xyzw")));
  EXPECT_EQ(parseRobotTable(rows, "poses.csv", {.form = "quaternion_xyzw"}).poses.size(), 1U);
}

}  // namespace
}  // namespace alidade
