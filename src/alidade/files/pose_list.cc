// SPDX-License-Identifier: MIT
#include "alidade/files/pose_list.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <set>
#include <string_view>

#include "alidade/core/error.h"
#include "alidade/core/text.h"
#include "alidade/files/text/atomic_file.h"
#include "alidade/files/text/pose_node.h"
#include "alidade/files/text/table_lines.h"
#include "alidade/files/text/yaml_node.h"

namespace alidade {
namespace {

using detail::TableColumn;
using detail::TableLines;
using detail::YamlNode;

constexpr std::size_t kMaxPoseFileBytes = std::size_t{256} << 20U;

const std::vector<std::string> kTumNames = {"timestamp", "tx", "ty", "tz", "qx", "qy", "qz", "qw"};
const std::vector<TableColumn> kTranslation = {{"tx", "m"}, {"ty", "m"}, {"tz", "m"}};
const std::vector<TableColumn> kPlainTranslation = {{"x", "m"}, {"y", "m"}, {"z", "m"}};
const std::vector<TableColumn> kQuaternion = {{"qx"}, {"qy"}, {"qz"}, {"qw"}};
const std::vector<TableColumn> kRotationVector = {{"rx", "rad"}, {"ry", "rad"}, {"rz", "rad"}};
const std::string kHowToSay =
    "add --poses-are camera_from_world (transforms points to the camera) or world_from_camera (position of "
    "the camera)";

SE3 cameraFromWorld(const SE3& pose, PoseDirection direction) {
  return direction == PoseDirection::kCameraFromWorld ? pose : pose.inverse();
}

// A table with one pose per row.
class PoseTable {
 public:
  PoseTable(const std::string& name, std::optional<PoseDirection> direction)
      : lines_(name), direction_(direction) {}

  void line(std::string_view text) {
    const TableLines::Kind kind = lines_.take(text);
    if (kind == TableLines::Kind::kNothing) return;
    if (kind == TableLines::Kind::kHeader) return readHeader(lines_.names());
    if (list_.poses.empty() && rotation_.empty()) withoutHeader();
    list_.poses.push_back(row());
  }

  PoseList finish() { return std::move(list_); }

 private:
  // Handles a first row without a header, or with one in a comment.
  void withoutHeader() {
    const auto& comment = lines_.commentNames();
    if (detail::findColumn(comment, {"qw"}).index && detail::findColumn(comment, {"qx"}).index) {
      if (comment == kTumNames && !direction_) direction_ = PoseDirection::kWorldFromCamera;
      return readHeader(comment);
    }
    if (lines_.numFields() != kTumNames.size()) {
      throw lines_.error(std::to_string(lines_.numFields()) + " columns without a header",
                         "a header that names tx,ty,tz,qx,qy,qz,qw or tx,ty,tz,rx,ry,rz, or the 8 columns of "
                         "a TUM trajectory, " +
                             join(kTumNames, " "),
                         "add a header");
    }
    list_.is_assumed_tum = !direction_;
    if (!direction_) direction_ = PoseDirection::kWorldFromCamera;
    readHeader(kTumNames);
  }

  void readHeader(const std::vector<std::string>& names) {
    const bool has_quaternion = detail::findColumn(names, {"qw"}).index.has_value();
    const detail::ColumnSearch vector = detail::findColumn(names, {"rx", "rad"});
    const bool has_vector = vector.index || (!has_quaternion && !vector.complaint.empty());
    if (has_quaternion && has_vector)
      throw lines_.error("both a quaternion and a rotation vector",
                         "only one rotation, qx,qy,qz,qw or rx,ry,rz");
    const bool is_plain =
        !detail::findColumn(names, {"tx", "m"}).index && detail::findColumn(names, {"x", "m"}).index;
    const std::vector<TableColumn>& translation = is_plain ? kPlainTranslation : kTranslation;
    const std::vector<TableColumn>& rotation = has_vector ? kRotationVector : kQuaternion;
    for (const TableColumn& column : translation) translation_.push_back(indexOf(names, column));
    for (const TableColumn& column : rotation) rotation_.push_back(indexOf(names, column));
    for (const char* id : {"id", "pose", "name", "image", "frame", "timestamp", "time"}) {
      // A time may be in seconds or any other unit; here it serves as a name.
      for (std::size_t i = 0; i < names.size() && !id_; ++i) {
        if (detail::findColumn({names[i]}, {id}).index || names[i].starts_with(std::string(id) + " ["))
          id_ = i;
      }
    }
    names_ = names;
    if (!direction_) {
      throw lines_.error("poses without a direction", "a direction", kHowToSay);
    }
  }

  std::size_t indexOf(const std::vector<std::string>& names, const TableColumn& column) {
    const detail::ColumnSearch search = detail::findColumn(names, column);
    if (search.index) return *search.index;
    throw lines_.error(search.complaint.empty()
                           ? "no column " + column.name + " in the header " + join(names, ",")
                           : search.complaint,
                       "tx,ty,tz (metres) with qx,qy,qz,qw or with rx,ry,rz (radians)");
  }

  double number(std::size_t index) {
    const double value = lines_.number(index, names_[index]);
    if (!std::isfinite(value))
      throw lines_.error("'" + std::string(lines_.fields()[index]) + "' as " + names_[index],
                         "a finite number");
    return value;
  }

  SO3 rotation() {
    std::array<double, 4> r{};
    for (std::size_t i = 0; i < rotation_.size(); ++i) r[i] = number(rotation_[i]);
    if (rotation_.size() == 3) return SO3::exp({r[0], r[1], r[2]});
    const Eigen::Quaterniond q(r[3], r[0], r[1], r[2]);
    // Allows for rounding to two digits; numbers of other columns deviate more.
    constexpr double kMaxLengthError = 0.01;
    if (!(std::abs(q.norm() - 1) <= kMaxLengthError)) {
      throw lines_.error("a quaternion of length " + exactText(q.norm()), "qx,qy,qz,qw of length 1",
                         "check that the columns match the header");
    }
    return SO3::fromQuaternion(q);
  }

  NamedPose row() {
    NamedPose pose;
    pose.id = id_ ? std::string(lines_.fields()[*id_]) : std::to_string(list_.poses.size());
    if (id_ && !ids_.insert(pose.id).second)
      throw lines_.error("the pose '" + pose.id + "' twice", "each " + names_[*id_] + " once");
    SE3 stated;
    stated.rotation = rotation();
    stated.translation = {number(translation_[0]), number(translation_[1]), number(translation_[2])};
    pose.camera_from_x = cameraFromWorld(stated, *direction_);
    return pose;
  }

  TableLines lines_;
  std::optional<PoseDirection> direction_;
  std::vector<std::string> names_;
  std::vector<std::size_t> translation_;
  std::vector<std::size_t> rotation_;
  std::optional<std::size_t> id_;
  std::set<std::string> ids_;
  PoseList list_;
};

PoseList readYaml(const YamlNode& root, std::optional<PoseDirection> direction) {
  std::vector<YamlNode> items;
  if (root.isSequence()) {
    items = root.items();
  } else if (root.has("poses")) {
    root.allowKeys({"poses"});
    items = root.at("poses").items();
  } else {
    items = {root};
  }
  PoseList list;
  std::set<std::string> ids;
  for (const YamlNode& item : items) {
    const std::vector<std::string> names = {"id", "image"};
    const auto framed = detail::readFramedPose(item, names);
    const SE3 pose = framed ? *framed
                            : cameraFromWorld(detail::readPose(item, names),
                                              direction.value_or(PoseDirection::kCameraFromWorld));
    const auto id = item.has("id") ? item.find("id") : item.find("image");
    if (framed && direction) {
      throw item.error("a key that names the frames, together with --poses-are", "only one of them",
                       "remove --poses-are: the key already states the direction of the pose");
    }
    list.poses.push_back({.id = id ? id->text() : std::to_string(list.poses.size()), .camera_from_x = pose});
    if (!ids.insert(list.poses.back().id).second)
      throw item.error("the pose '" + list.poses.back().id + "' twice",
                       "each id (or image, without an id) only once");
  }
  return list;
}

// Lines of a table contain neither of YAML's marks for lists and maps.
bool looksLikeYaml(std::string_view text) {
  for (std::string_view line : split(text, '\n')) {
    line = trim(line);
    if (line.empty() || line.starts_with('#')) continue;
    return line == "-" || line.starts_with("- ") || line.starts_with("---") ||
           std::string_view("{[%").find(line.front()) != std::string_view::npos || line.ends_with(':') ||
           line.find(": ") != std::string_view::npos;
  }
  return false;
}

}  // namespace

SE3 readPoseSource(const std::string& source) {
  const bool is_text = trim(source).starts_with('{');
  if (trim(source).starts_with('[')) {
    throw inputError({.where = "pose",
                      .found = "a list, '" + source + "'",
                      .expected = "a map with a rotation and a translation, in braces",
                      .next_step = "for example: {quaternion_xyzw: [0, 0, 0, 1], translation_m: [0, 0, 0]}"});
  }
  const YamlNode root = is_text ? YamlNode::parse(source, "pose") : YamlNode::readFile(source);
  if (!is_text && !root.isMap()) {
    throw root.error(root.isSequence() ? "a list" : "no pose",
                     "one pose: a map with a rotation and translation_m",
                     "for a list or table of poses, use --poses");
  }
  const auto framed = detail::readFramedPose(root);
  return framed ? *framed : detail::readPose(root);
}

PoseList parsePoseList(const std::string& text, const std::string& name,
                       std::optional<PoseDirection> direction) {
  PoseList list;
  if (looksLikeYaml(text)) {
    list = readYaml(YamlNode::parse(text, name), direction);
  } else {
    PoseTable table(name, direction);
    for (const std::string_view line : split(text, '\n')) table.line(line);
    list = table.finish();
  }
  if (list.poses.empty()) {
    throw inputError({.where = name,
                      .found = "no pose",
                      .expected = "a YAML list of poses, or a table with one row per pose",
                      .next_step = "see alidade project --help"});
  }
  return list;
}

PoseList readPoseList(const std::string& path, std::optional<PoseDirection> direction) {
  return parsePoseList(readTextFile(path, kMaxPoseFileBytes), path, direction);
}

std::string tumText(const std::vector<double>& times_s, const std::vector<SE3>& camera_from_world) {
  expect(times_s.size() == camera_from_world.size(), "one time per pose");
  std::string text = "# timestamp tx ty tz qx qy qz qw\n";
  for (std::size_t i = 0; i < times_s.size(); ++i) {
    const SE3 world_from_camera = camera_from_world[i].inverse();
    const Eigen::Vector3d& t = world_from_camera.translation;
    SO3::Quaternion q = world_from_camera.rotation.quaternion();
    if (q.w() < 0) q.coeffs() = -q.coeffs();
    text += exactText(times_s[i]);
    for (const double value : {t.x(), t.y(), t.z(), q.x(), q.y(), q.z(), q.w()})
      text += " " + exactText(value);
    text += "\n";
  }
  return text;
}

}  // namespace alidade
