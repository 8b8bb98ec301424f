// SPDX-License-Identifier: MIT
#include "alidade/files/robot_table.h"

#include <algorithm>
#include <cmath>
#include <initializer_list>
#include <map>
#include <numbers>
#include <numeric>
#include <optional>
#include <set>
#include <span>
#include <string_view>
#include <utility>
#include <vector>

#include <fmt/format.h>

#include "alidade/core/degrees.h"
#include "alidade/core/error.h"
#include "alidade/core/mapped.h"
#include "alidade/core/text.h"
#include "alidade/files/text/atomic_file.h"
#include "alidade/files/text/file_text.h"
#include "alidade/files/text/pose_forms.h"
#include "alidade/files/text/table_lines.h"
#include "alidade/geometry/rotation_conversions.h"

namespace alidade {
namespace {

using detail::TableLines;

// How the numbers of a row are meant: as x, y, z and a rotation, or as a matrix.
struct RowMeaning {
  std::string form;  // of the rotation, or of the matrix (pose_forms.h)
  double units_per_m = 1;
  bool is_by_columns = false;  // the matrix

  [[nodiscard]] bool isMatrix() const { return form.starts_with("matrix"); }
  [[nodiscard]] std::size_t numNumbers() const {
    return findPoseForm(form)->places.size() + (isMatrix() ? 0 : 3);
  }
};

constexpr double kMmPerM = 1000;
const std::map<std::string, RowMeaning> kMakers = {
    {"kuka", {"euler_zyx_deg", kMmPerM}},    {"abb", {"quaternion_wxyz", kMmPerM}},
    {"ur", {"rotation_vector_rad"}},         {"fanuc", {"euler_fixed_xyz_deg", kMmPerM}},
    {"staubli", {"euler_xyz_deg", kMmPerM}}, {"franka", {"matrix", 1, true}}};
// Columns of a rotation, and the form that they mean without a stated one.
const std::map<std::string, std::string> kRotationColumns = {{"qx qy qz qw", "quaternion_xyzw"},
                                                             {"q1 q2 q3 q4", "abb"},
                                                             {"rx ry rz", "ur"},
                                                             {"a b c", "kuka"},
                                                             {"w p r", "fanuc"},
                                                             {"roll pitch yaw", "euler_fixed_xyz_rad"}};
constexpr const char* kHeaderAdvice = "begin the table with a header, such as image,x_m,y_m,z_m,qx,qy,qz,qw";

RowMeaning meaningOf(const std::string& name) {
  if (const auto maker = kMakers.find(name); maker != kMakers.end()) return maker->second;
  const auto form = findPoseForm(name);
  const RowMeaning meaning{name};
  if (form && (meaning.isMatrix() || name.starts_with("quaternion") || form->places.size() == 3))
    return meaning;
  throw usageError({"form of robot poses", "'" + name + "'",
                    "abb, fanuc, franka, kuka, staubli, ur, matrix, or a form of a rotation, such as "
                    "quaternion_wxyz or euler_zyx_deg",
                    poseFormAdvice(name)});
}

SE3 poseOf(std::span<const double> numbers, const RowMeaning& meaning) {
  constexpr double kMaxError = 0.01;  // of lengths: pendants show few digits
  SE3 pose;
  if (meaning.isMatrix()) {
    Eigen::Matrix4d columns = Eigen::Matrix4d::Identity();  // those of the matrix, or its rows
    std::ranges::copy(numbers, columns.data());
    pose = motionFromMatrix(meaning.is_by_columns ? columns : columns.transpose(), kMaxError);
  } else {
    const NamedPose read = findPoseForm(meaning.form)->read(numbers.subspan(3));
    if (!(std::abs(read.quaternion_length - 1) <= kMaxError)) {
      throw inputError(
          {"", "found a quaternion of length " + exactText(read.quaternion_length), "length 1 (within 1 %)",
           "perhaps the numbers have another form: state that of the robot, such as ur or kuka"});
    }
    pose = {read.stated.rotation, Eigen::Vector3d(numbers.data())};
  }
  pose.translation /= meaning.units_per_m;
  return pose;
}

struct RobotRow {
  std::string place;  // in the file
  std::string image;
  std::vector<double> numbers;
};

std::vector<RobotPose> posesOf(const std::vector<RobotRow>& rows, const RowMeaning& meaning) {
  return mapped(rows, [&](const RobotRow& row) {
    return RobotPose{row.image, detail::withPlace(row.place, [&] { return poseOf(row.numbers, meaning); })};
  });
}

struct FoundColumns {
  std::vector<std::size_t> at = {};  // empty: not found
  std::string names = {};
  std::string unit = {};  // as stated
};
// The first of the alternatives that the header has all columns of.
FoundColumns findColumns(const std::vector<std::string>& header, const std::vector<std::string>& alternatives,
                         const std::vector<std::string>& units) {
  for (const std::string& names : alternatives) {
    for (const std::string& unit : units) {
      FoundColumns found{.names = names, .unit = unit};
      const std::vector<std::string> each = detail::words(names);
      for (const std::string& name : each) {
        if (const auto column = detail::findColumn(header, {name, unit}).index) found.at.push_back(*column);
      }
      if (found.at.size() == each.size()) return found;
    }
  }
  return {};
}
FoundColumns findTranslation(const std::vector<std::string>& header) {
  return findColumns(
      header, {"x y z", "tx ty tz", "px py pz", "pos_x pos_y pos_z", "position_x position_y position_z"},
      {"", "m", "mm"});
}

// Reads the lines of a table.
class RobotLines {
 public:
  RobotLines(const std::string& name, const RobotTableOptions& options)
      : lines_(name), stated_(options.form) {
    if (!stated_.empty()) form_ = meaningOf(stated_);
  }

  void line(std::string_view text) {
    const TableLines::Kind kind = lines_.take(text);
    if (kind == TableLines::Kind::kNothing) return;
    if (columns_.empty()) {
      const std::vector<std::string> fields = lines_.names();
      // A row may begin with the name of an image.
      const bool is_row = fields.size() > 1 && std::all_of(fields.begin() + 1, fields.end(), parseDouble);
      if (kind == TableLines::Kind::kHeader && !is_row) return readHeader(fields);
      const std::vector<std::string>& comment = lines_.commentNames();
      const bool is_header = comment.size() == fields.size() && !findTranslation(comment).at.empty();
      is_header ? readHeader(comment) : withoutHeader(fields);
    }
    addRow();
  }

  [[nodiscard]] const std::vector<RobotRow>& rows() const { return rows_; }
  [[nodiscard]] const RowMeaning& meaning() const { return meaning_; }

 private:
  void readHeader(const std::vector<std::string>& header) {
    const FoundColumns translation = findTranslation(header);
    const auto rotations = mapped(kRotationColumns, [](const auto& known) { return known.first; });
    const FoundColumns rotation = findColumns(header, rotations, {"", "rad", "deg"});
    columns_ = translation.at;
    columns_.insert(columns_.end(), rotation.at.begin(), rotation.at.end());
    std::set<std::size_t> used(columns_.begin(), columns_.end());
    for (const char* name : {"image", "filename", "file", "name", "id", "timestamp", "time"}) {
      for (std::size_t i = 0; i < header.size(); ++i) {
        const std::string first = header[i].substr(0, header[i].find_first_of(" _[("));  // without a unit
        if (detail::findColumn({first}, {name}).index && used.insert(i).second && !name_) name_ = i;
      }
    }
    const std::string expected =
        "a name (image), x, y, z in m or mm, and one rotation: " + join(rotations, "; ");
    for (std::size_t i = 0; i < header.size(); ++i) {
      if (used.contains(i)) continue;
      const bool is_double = std::ranges::count(header, header[i]) > 1;
      throw lines_.error((is_double ? "two columns '" : "unknown column '") + header[i] + "'", expected);
    }
    if (translation.at.empty() || rotation.at.empty())
      throw lines_.error(translation.at.empty() ? "no translation" : "no rotation", expected);
    meaning_ = form_.value_or(meaningOf(kRotationColumns.at(rotation.names)));
    if (meaning_.numNumbers() != columns_.size()) {
      throw lines_.error("the columns " + rotation.names,
                         "those of the stated form, " + std::to_string(meaning_.numNumbers()) + " numbers",
                         "state no form, or another one");
    }
    // A maker's form tells the unit, too; one of a quaternion, nothing but the order.
    constexpr std::string_view kNamedOrder = "quaternion_xyzw";
    const bool are_ordered = rotation.names == "qx qy qz qw";
    if (are_ordered && stated_ == meaning_.form && stated_ != kNamedOrder) {
      throw lines_.error(
          "the columns " + rotation.names + ", which name the order " + std::string(kNamedOrder),
          "those of the stated form, " + stated_, "state no form, or correct the header");
    }
    if (are_ordered) meaning_.form = kNamedOrder;
    if (!translation.unit.empty()) meaning_.units_per_m = translation.unit == "mm" ? kMmPerM : 1;
    if (!rotation.unit.empty() && rotation.at.size() == 3)
      meaning_.form.replace(meaning_.form.size() - 3, 3, rotation.unit);
  }

  void withoutHeader(const std::vector<std::string>& fields) {
    const bool has_name = !parseDouble(fields.front());
    std::vector<RowMeaning> known = mapped(detail::words("ur quaternion_xyzw matrix_3x4 matrix"), meaningOf);
    if (form_) known = {*form_};
    for (const RowMeaning& meaning : known) {
      const std::size_t needed = meaning.numNumbers();
      // Seven numbers are a quaternion rather than a number and a rotation vector.
      const bool may_have_name = has_name || form_ || needed > 6;
      if ((fields.size() != needed || has_name) && (fields.size() != needed + 1 || !may_have_name)) continue;
      meaning_ = meaning;
      columns_.resize(needed);
      std::iota(columns_.begin(), columns_.end(), fields.size() - needed);
      if (fields.size() != needed) name_ = 0;
      return;
    }
    const std::string numbers = form_ ? std::to_string(form_->numNumbers()) : "6, 7, 12 or 16";
    throw lines_.error(std::to_string(fields.size()) + " columns without a header",
                       numbers + " numbers, alone or behind a name", kHeaderAdvice);
  }

  void addRow() {
    RobotRow row{
        .place = lines_.place(), .image = name_ ? std::string(lines_.fields()[*name_]) : "", .numbers = {}};
    for (const std::size_t column : columns_) {
      const std::string label = "number " + std::to_string(column + 1);
      row.numbers.push_back(lines_.number(column, label));
      constexpr double kMost = 1e6;
      if (!(std::abs(row.numbers.back()) < kMost))
        throw lines_.error("'" + std::string(lines_.fields()[column]) + "' as " + label,
                           "a number nearer to 0 than a million", "remove rows without a pose");
    }
    if (!row.image.empty() && !images_.insert(row.image).second)
      throw lines_.error("'" + row.image + "' twice", "one pose per image");
    if (rows_.empty() && row.numbers.size() == 16 && !form_) {
      // 0 0 0 1 is the last row.
      const Eigen::Map<const Eigen::Matrix4d> by_columns(row.numbers.data());
      meaning_.is_by_columns =
          by_columns.row(3).head<3>().isZero(0) && !by_columns.col(3).head<3>().isZero(0);
    }
    rows_.push_back(std::move(row));
  }

  TableLines lines_;
  std::string stated_;              // the form's name
  std::optional<RowMeaning> form_;  // as stated
  RowMeaning meaning_;
  std::vector<std::size_t> columns_;  // of the numbers; empty: not known yet
  std::optional<std::size_t> name_;
  std::vector<RobotRow> rows_;
  std::set<std::string> images_;
};

// Other forms of a rotation, and how to say them.
std::vector<std::pair<std::string, std::string>> otherForms(const std::string& form,
                                                            const std::vector<RobotRow>& rows) {
  if (form == "quaternion_xyzw") return {{"quaternion_wxyz", "the quaternion as w, x, y, z"}};
  if (form == "quaternion_wxyz") return {{"quaternion_xyzw", "the quaternion as x, y, z, w"}};
  const std::string convention = form.substr(0, form.size() - 4);
  const bool is_deg = form.ends_with("_deg");
  const std::string unit = is_deg ? "radians" : "degrees";
  std::vector<std::pair<std::string, std::string>> others = {
      {convention + (is_deg ? "_rad" : "_deg"), "angles in " + unit}};
  // Robots state less than a turn in radians, and turn so far that some angle is larger in degrees.
  const bool seem_deg = std::ranges::any_of(rows, [](const RobotRow& row) {
    return Eigen::Vector3d(&row.numbers[3]).lpNorm<Eigen::Infinity>() > 2 * std::numbers::pi;
  });
  using Pairs = std::initializer_list<std::pair<const char*, const char*>>;
  for (const auto& [other, how] : Pairs{{"euler_zyx", "Euler angles as Rz(a) Ry(b) Rx(c)"},
                                        {"euler_fixed_xyz", "Euler angles as Rz(c) Ry(b) Rx(a)"},
                                        {"euler_xyz", "Euler angles as Rx(a) Ry(b) Rz(c)"},
                                        {"rotation_vector", "the angles as a rotation vector"}}) {
    if (other != convention)
      others.emplace_back(std::string(other) + (seem_deg ? "_deg" : "_rad"),
                          how + (seem_deg == is_deg ? "" : " in " + unit));
  }
  return others;
}

// All readings, the stated one first.
std::vector<RobotReading> readingsOf(const std::vector<RobotRow>& rows, const RowMeaning& stated) {
  std::vector<RobotReading> readings = {{"", posesOf(rows, stated)}};
  if (stated.isMatrix()) {
    readings.push_back({"columns of the matrices as rows", readings.front().poses});
    for (RobotPose& pose : readings.back().poses)
      pose.base_from_gripper.rotation = pose.base_from_gripper.rotation.inverse();
  } else {
    for (const auto& [form, how] : otherForms(stated.form, rows))
      readings.push_back({how, posesOf(rows, {form, stated.units_per_m})});
  }
  const bool is_mm = stated.units_per_m == kMmPerM;
  const std::string how = std::string("translations in ") + (is_mm ? "metres" : "millimetres");
  for (std::size_t i = 0, count = readings.size(); i < count; ++i) {
    RobotReading other = readings[i];
    other.how += (other.how.empty() ? "" : ", and ") + how;
    for (RobotPose& pose : other.poses) pose.base_from_gripper.translation *= is_mm ? kMmPerM : 1 / kMmPerM;
    readings.push_back(std::move(other));
  }
  return readings;
}

}  // namespace

RobotTable parseRobotTable(const std::string& text, const std::string& name,
                           const RobotTableOptions& options) {
  RobotLines lines(name, options);
  for (const std::string_view line : split(text, '\n')) lines.line(line);
  if (lines.rows().empty()) throw detail::errorAt(name, "no poses", "a row for each image", kHeaderAdvice);
  RobotTable table{.poses = {}, .others = readingsOf(lines.rows(), lines.meaning())};
  table.poses = std::move(table.others.front().poses);
  table.others.erase(table.others.begin());
  return table;
}

RobotTable readRobotTable(const std::string& path, const RobotTableOptions& options) {
  constexpr std::size_t kMaxBytes = std::size_t{64} << 20U;
  return parseRobotTable(readTextFile(path, kMaxBytes), path, options);
}

std::string robotTableText(const std::vector<RobotPose>& poses, std::optional<RobotMistake> mistake) {
  const bool are_vectors = mistake == RobotMistake::kDegrees;
  const bool are_angles = mistake == RobotMistake::kEulerOrder;
  std::string text = std::string("image,x_m,y_m,z_m,") + (are_vectors  ? "rx,ry,rz\n"
                                                          : are_angles ? "roll,pitch,yaw\n"
                                                                       : "qx,qy,qz,qw\n");
  for (const auto& [image, pose] : poses) {
    const Eigen::Vector3d t = pose.translation * (mistake == RobotMistake::kMillimetres ? kMmPerM : 1);
    const Eigen::Vector4d q = quaternionXyzw(pose.rotation);
    Eigen::VectorXd numbers = q;
    if (mistake == RobotMistake::kQuaternionOrder) numbers = Eigen::Vector4d(q[3], q[0], q[1], q[2]);
    if (are_vectors) numbers = kDegPerRad * pose.rotation.log();
    if (are_angles) numbers = eulerFromRotation(pose.rotation, *eulerOrder("xyz")).angles_rad;
    text += fmt::format("{},{},{},{}", image, t.x(), t.y(), t.z());
    for (const double number : numbers) text += fmt::format(",{}", number);
    text += '\n';
  }
  return text;
}

}  // namespace alidade
