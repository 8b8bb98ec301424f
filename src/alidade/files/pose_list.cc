// SPDX-License-Identifier: MIT
#include "alidade/files/pose_list.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numeric>
#include <set>
#include <string_view>

#include "alidade/core/error.h"
#include "alidade/core/mapped.h"
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

const std::vector<TableColumn> kTranslation = {{"tx", "m"}, {"ty", "m"}, {"tz", "m"}};
const std::vector<TableColumn> kPlainTranslation = {{"x", "m"}, {"y", "m"}, {"z", "m"}};
const std::vector<TableColumn> kQuaternion = {{"qx"}, {"qy"}, {"qz"}, {"qw"}};
const std::vector<TableColumn> kRotationVector = {{"rx", "rad"}, {"ry", "rad"}, {"rz", "rad"}};
const std::string kHowToSay =
    "add --poses-are camera_from_world (transforms points to the camera) or world_from_camera (position of "
    "the camera)";

// What is known about poses beside their text.
struct Context {
  std::string name;    // of the text
  std::string frames;  // of poses that do not state theirs; empty if unknown
  bool is_any;         // see readStatedPose()
};

// A table with one pose per row.
class PoseTable {
 public:
  // @param form  of the numbers in a row; otherwise a header or their count tells
  explicit PoseTable(const Context& context, std::optional<PoseForm> form = {})
      : context_(context), lines_(context.name), frames_(context.frames), form_(std::move(form)) {
    if (form_) names_.resize(form_->places.size());
  }

  void line(std::string_view text) {
    const TableLines::Kind kind = lines_.take(text);
    if (kind == TableLines::Kind::kNothing) return;
    if (kind == TableLines::Kind::kHeader && form_)
      throw lines_.error("'" + std::string(lines_.fields().front()) + "'",
                         "only numbers of the form " + form_->name,
                         "remove what is no number; a table with a header needs no --from");
    if (kind == TableLines::Kind::kHeader) return readHeader(lines_.names());
    if (names_.empty()) withoutHeader();
    list_.poses.push_back(row());
  }
  // Counts a line that is no part of the table.
  void skipLine() { lines_.countLine(); }

  void readHeader(const std::vector<std::string>& names) {
    names_ = names;
    if (!form_) findColumns(names);
    if (frames_.empty() && !context_.is_any)
      throw lines_.error("poses without a direction", "a direction", kHowToSay);
  }

  PoseList finish() { return std::move(list_); }

 private:
  // Handles a first row without a header, or with one in a comment.
  void withoutHeader() {
    const auto& comment = lines_.commentNames();
    const bool is_named =
        detail::findColumn(comment, {"qw"}).index && detail::findColumn(comment, {"qx"}).index;
    for (const auto& [name, names, form, frames, title] : poseRows()) {
      if (lines_.numFields() != names.size() || name == "csv" || (is_named && comment != names)) continue;
      if (frames_.empty() && !is_named) list_.remarks.push_back(context_.name + " is read as a " + title);
      if (frames_.empty()) frames_ = frames;
      if (names.front().empty()) form_ = findPoseForm(form);
      return readHeader(names);
    }
    if (is_named) return readHeader(comment);
    throw lines_.error(
        std::to_string(lines_.numFields()) + " columns without a header",
        "a header that names tx,ty,tz,qx,qy,qz,qw or tx,ty,tz,rx,ry,rz, or the 8 columns of a "
        "TUM trajectory, 12 of KITTI, 7 of x y z qx qy qz qw or 16 of 4x4 matrices",
        "add a header, or say what the numbers are: alidade pose --from FORM, such as matrix for a "
        "4x4 matrix in four lines");
  }

  void findColumns(const std::vector<std::string>& names) {
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
  }

  std::size_t indexOf(const std::vector<std::string>& names, const TableColumn& column) {
    const detail::ColumnSearch search = detail::findColumn(names, column);
    if (search.index) return *search.index;
    throw lines_.error(search.complaint.empty()
                           ? "no column " + column.name + " in the header " + join(names, ",")
                           : search.complaint,
                       "tx,ty,tz (metres) with qx,qy,qz,qw or with rx,ry,rz (radians)");
  }

  std::vector<double> numbersAt(const std::vector<std::size_t>& columns) {
    return mapped(columns, [&](std::size_t index) {
      const std::string name = names_[index].empty() ? "number " + std::to_string(index + 1) : names_[index];
      const double value = lines_.number(index, name);
      if (!std::isfinite(value))
        throw lines_.error("'" + std::string(lines_.fields()[index]) + "' as " + name, "a finite number");
      return value;
    });
  }

  NamedPose stated() {
    if (form_) {
      std::vector<std::size_t> all(names_.size());
      std::iota(all.begin(), all.end(), 0U);
      const std::vector<double> numbers = numbersAt(all);
      return detail::withPlace(lines_.place(), [&] { return form_->read(numbers); });
    }
    const std::vector<double> r = numbersAt(rotation_);
    // Allows for rounding to two digits; numbers of other columns deviate more.
    constexpr double kMaxLengthError = 0.01;
    const double length = Eigen::Map<const Eigen::VectorXd>(r.data(), std::ssize(r)).norm();
    if (r.size() == 4 && !(std::abs(length - 1) <= kMaxLengthError)) {
      throw lines_.error("a quaternion of length " + exactText(length), "qx,qy,qz,qw of length 1",
                         "check that the columns match the header");
    }
    NamedPose pose = findPoseForm(r.size() == 4 ? "quaternion_xyzw" : "rotation_vector_rad")->read(r);
    pose.stated.translation = Eigen::Vector3d(numbersAt(translation_).data());
    pose.has_translation = true;
    return pose;
  }

  NamedPose row() {
    NamedPose pose = stated();
    pose.id = id_ ? std::string(lines_.fields()[*id_]) : std::to_string(list_.poses.size());
    if (id_ && !ids_.insert(pose.id).second)
      throw lines_.error("the pose '" + pose.id + "' twice", "each " + names_[*id_] + " once");
    pose.frames = frames_;
    return pose;
  }

  const Context& context_;
  TableLines lines_;
  std::string frames_;
  std::optional<PoseForm> form_;
  std::vector<std::string> names_;
  std::vector<std::size_t> translation_;
  std::vector<std::size_t> rotation_;
  std::optional<std::size_t> id_;
  std::set<std::string> ids_;
  PoseList list_;
};

// The nine numbers and the name in a line of an image in images.txt of COLMAP; none for other lines.
std::vector<std::string> imageLine(std::string_view line) {
  std::vector<std::string> fields;
  std::string_view rest = trim(line);
  while (fields.size() < 9 && !rest.empty()) {
    const std::size_t end = std::min(rest.find_first_of(" \t"), rest.size());
    fields.emplace_back(rest.substr(0, end));
    rest = trim(rest.substr(end));
  }
  if (rest.empty() || parseDouble(detail::words(rest).front()) ||
      !std::all_of(fields.begin(), fields.end(), parseDouble))
    return {};
  fields.emplace_back(rest);
  return fields;
}

// The line below that of an image holds its points, and may be empty.
PoseList readColmap(const std::vector<std::string_view>& lines, Context context) {
  context.frames = context.frames.empty() ? "camera_from_world" : context.frames;
  PoseTable table(context);
  table.readHeader(detail::words("number qw qx qy qz tx ty tz camera image"));
  bool was_image = false;
  for (const std::string_view line : lines) {
    const std::vector<std::string> fields = imageLine(line);
    if (!fields.empty()) {
      table.line(join(std::span(fields).first(9), ",") + "," + detail::csvField(fields.back()));
    } else if (was_image || line.starts_with('#')) {
      table.skipLine();
    } else {
      table.line(line);  // which finds the fault
    }
    was_image = !fields.empty();
  }
  return table.finish();
}

// Plain numbers in any number of lines, with or without brackets and commas.
PoseList readNumbers(const std::string& text, const Context& context, std::optional<PoseForm> form) {
  std::string plain;
  for (const std::string_view line : split(text, '\n'))
    if (!trim(line).starts_with('#')) plain += std::string(line) + "\n";
  for (const char mark : {'[', ']', '(', ')', ',', ';'}) std::ranges::replace(plain, mark, ' ');
  const std::vector<std::string> all = detail::words(plain);
  for (const PoseForm& other : poseForms()) {
    // Of three and four numbers there are several forms.
    if (!form && all.size() > 4 && other.places.size() == all.size()) form = other;
  }
  const std::size_t count = form ? form->places.size() : std::max<std::size_t>(all.size(), 1);
  if (all.size() % count != 0) {
    throw detail::errorAt(context.name, "found " + std::to_string(all.size()) + " numbers",
                          std::to_string(count) + " per pose of the form " + form->name,
                          "count them, or choose another form: alidade pose --help lists all");
  }
  PoseTable table(context, form);
  for (std::size_t i = 0; i < all.size(); i += count) table.line(join(std::span(all).subspan(i, count), " "));
  return table.finish();
}

PoseList readYaml(const YamlNode& root, const Context& context) {
  const bool is_nerf = root.has("frames");
  std::vector<YamlNode> items = {root};
  if (root.isSequence()) items = root.items();
  if (is_nerf || root.has("poses")) items = root.at(is_nerf ? "frames" : "poses").items();
  if (!is_nerf && root.has("poses")) root.allowKeys({"poses"});
  PoseList list;
  std::set<std::string> ids;
  for (const YamlNode& item : items) {
    std::vector<std::string> names = is_nerf ? item.keys() : detail::words("id image");  // not of the pose
    std::erase(names, "transform_matrix");
    NamedPose pose = detail::readStatedPose(item, names, context.is_any);
    if (!pose.frames.empty() && !context.frames.empty()) {
      throw item.error("a key that names the frames, together with --poses-are", "only one of them",
                       "remove --poses-are: the key already states the direction of the pose");
    }
    if (pose.frames.empty()) pose.frames = context.frames;
    pose.id = std::to_string(list.poses.size());
    for (const char* key : {"file_path", "image", "id"}) {
      if (item.has(key)) pose.id = item.at(key).text();
    }
    list.poses.push_back(pose);
    if (!ids.insert(pose.id).second)
      throw item.error("the pose '" + pose.id + "' twice", "each id (or image, without an id) only once");
  }
  if (root.has("transform_matrix") || is_nerf)
    list.remarks.push_back(context.name +
                           ": transform_matrix is read as world_from_camera with OpenGL's axes, and turned "
                           "to x right, y down, z forward");
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

bool areNumbers(std::string_view text) {
  return text.find_first_not_of("0123456789+-.eE,; \t\r\n[]()") == std::string_view::npos;
}

PoseList parse(const std::string& text, const Context& context, const std::optional<PoseForm>& form = {}) {
  const std::vector<std::string_view> lines = split(text, '\n');
  PoseList list;
  if (form || (areNumbers(text) && trim(text).starts_with('['))) {
    list = readNumbers(text, context, form);
  } else if (looksLikeYaml(text)) {
    list = readYaml(YamlNode::parse(text, context.name), context);
  } else if (std::ranges::any_of(lines, [](std::string_view line) { return !imageLine(line).empty(); })) {
    list = readColmap(lines, context);
  } else {
    PoseTable table(context);
    for (const std::string_view line : lines) table.line(line);
    list = table.finish();
  }
  if (list.poses.empty()) {
    throw detail::errorAt(context.name, "no pose", "a YAML list of poses, or a table with one row per pose",
                          "see alidade pose --help");
  }
  double worst = 1;
  for (NamedPose& pose : list.poses) {
    if (!context.is_any && !pose.has_translation)
      throw detail::errorAt(context.name, "rotations without translations", "poses");
    pose.camera_from_x = pose.frames.ends_with("_from_camera") ? pose.stated.inverse() : pose.stated;
    if (std::abs(pose.quaternion_length - 1) > std::abs(worst - 1)) worst = pose.quaternion_length;
  }
  constexpr double kRounding = 1e-3;
  if (std::abs(worst - 1) > kRounding)
    list.remarks.push_back(context.name + ": a quaternion has length " + exactText(worst) +
                           " instead of 1, and is normalised");
  return list;
}

// The frames that these words mean.
std::string directionOf(const std::string& words) {
  if (words.empty() || std::ranges::count(kPoseDirections, words) > 0) return detail::poseFrames(words, true);
  throw usageError({"direction of poses", "'" + words + "'", "one of " + join(kPoseDirections, ", "),
                    didYouMean(words, kPoseDirections)});
}

// The numbers in brackets, those of a matrix by rows.
std::string listText(const std::vector<double>& numbers) {
  const std::size_t columns = numbers.size() < 9 ? numbers.size() : numbers.size() == 9 ? 3 : 4;
  std::string text;
  for (std::size_t i = 0; i < numbers.size(); ++i)
    text += (i == 0 ? "" : i % columns == 0 ? "], [" : ", ") + exactText(numbers[i]);
  return numbers.size() < 9 ? "[" + text + "]" : "[[" + text + "]]";
}

std::string yamlText(const NamedPose& pose, const PoseForm& form, bool has_id, bool& gimbal_lock) {
  YAML::Emitter id;
  id << YAML::DoubleQuoted << pose.id;
  std::string text = (has_id ? "- {id: " + std::string(id.c_str()) + ", " : "{");
  if (!pose.frames.empty()) text += pose.frames + ": {";
  text += form.name + ": " + listText(form.write(pose.stated, gimbal_lock));
  const Eigen::Vector3d& t = pose.stated.translation;
  if (!form.hasTranslation() && pose.has_translation)
    text += ", translation_m: " + listText({t.x(), t.y(), t.z()});
  return text + (pose.frames.empty() ? "}\n" : "}}\n");
}

}  // namespace

SE3 readPoseSource(const std::string& source) {
  const bool is_text = trim(source).starts_with('{');
  if (trim(source).starts_with('[')) {
    throw detail::errorAt("pose", "a list, '" + source + "'",
                          "a map with a rotation and a translation, in braces",
                          "for example: {quaternion_xyzw: [0, 0, 0, 1], translation_m: [0, 0, 0]}");
  }
  const YamlNode root = is_text ? YamlNode::parse(source, "pose") : YamlNode::readFile(source);
  if (!is_text && !root.isMap()) {
    throw root.error(root.isSequence() ? "a list" : "no pose",
                     "one pose: a map with a rotation and translation_m",
                     "for a list or table of poses, use --poses");
  }
  const NamedPose pose = detail::readStatedPose(root, {}, false);
  return pose.frames.ends_with("_from_camera") ? pose.stated.inverse() : pose.stated;
}

PoseList parsePoseList(const std::string& text, const std::string& name, const std::string& frames) {
  return parse(text, {name, directionOf(frames), false});
}

PoseList readPoseList(const std::string& path, const std::string& frames) {
  return parsePoseList(readTextFile(path, kMaxPoseFileBytes), path, frames);
}

PoseList readAnyPoses(const std::string& source, const std::string& frames,
                      const std::optional<PoseForm>& form) {
  const bool is_text = trim(source).find_first_of("{[") == 0 ||
                       (areNumbers(source) && source.find_first_of(" ,") != std::string::npos);
  const std::string name = is_text ? "pose" : source == "-" ? "standard input" : source;
  const std::string path = source == "-" ? "/dev/stdin" : source;
  return parse(is_text ? source : readTextFile(path, kMaxPoseFileBytes), {name, directionOf(frames), true},
               form);
}

const std::vector<PoseRows>& poseRows() {
  static const std::vector<PoseRows> kRows = {
      {"csv", detail::words("id tx ty tz qx qy qz qw"), "xyz_xyzw", "", "table of id,tx,ty,tz,qx,qy,qz,qw"},
      {"tum", detail::words("timestamp tx ty tz qx qy qz qw"), "xyz_xyzw", "world_from_camera",
       "TUM trajectory (timestamp tx ty tz qx qy qz qw, world_from_camera)"},
      {"kitti", std::vector<std::string>(12), "matrix_3x4", "world_from_camera",
       "KITTI trajectory (3x4 matrices, world_from_camera)"},
      {"", detail::words("tx ty tz qx qy qz qw"), "xyz_xyzw", "",
       "table of tx ty tz qx qy qz qw, as ROS prints transforms"},
      {"", std::vector<std::string>(9), "rotation_matrix", "", "table of 3x3 matrices, row by row"},
      {"", std::vector<std::string>(16), "matrix", "", "table of 4x4 matrices, row by row"}};
  return kRows;
}

std::string poseText(const std::vector<NamedPose>& poses, const std::string& form,
                     std::vector<std::string>& remarks) {
  const auto rows = std::ranges::find(poseRows(), form, &PoseRows::name);
  const bool is_table = rows != poseRows().end();
  const PoseForm numbers = findPoseForm(is_table ? rows->form : form).value();
  const bool has_id = is_table && !rows->columns.front().empty();
  const std::string separator = form == "csv" ? "," : " ";
  std::string text = has_id ? (form == "csv" ? "" : "# ") + join(rows->columns, separator) + "\n" : "";
  bool has_lock = false;
  bool has_turned = false;
  bool is_assumed = false;  // the direction of the rows
  bool is_at_origin = false;
  for (const NamedPose& pose : poses) {
    is_at_origin = is_at_origin || (numbers.hasTranslation() && !pose.has_translation);
    if (!is_table) {
      text += yamlText(pose, numbers, poses.size() > 1, has_lock);
      continue;
    }
    if (has_id && rows->columns.front() == "timestamp" && !parseDouble(pose.id))
      throw usageError({"pose '" + pose.id + "'", "no number", "a time, with which such rows begin",
                        "--to csv takes any id"});
    const bool is_turned = !rows->frames.empty() && pose.frames.starts_with("camera_from_");
    is_assumed = is_assumed || (!rows->frames.empty() && pose.frames.empty());
    if (!rows->frames.empty() && !is_turned && !pose.frames.empty() && !pose.frames.ends_with("_from_camera"))
      throw usageError({"pose '" + pose.id + "'", pose.frames, rows->frames + ", which such rows mean",
                        "--to csv takes any frames"});
    has_turned = has_turned || is_turned;
    std::vector<std::string> fields =
        mapped(numbers.write(is_turned ? pose.stated.inverse() : pose.stated, has_lock), exactText);
    if (has_id) fields.insert(fields.begin(), detail::csvField(pose.id));
    text += join(fields, separator) + "\n";
  }
  if (has_turned)
    remarks.push_back("rows of " + form + " are " + rows->frames + ", so the poses are inverted");
  if (form == "csv" && !poses.front().frames.empty())
    remarks.push_back("rows of csv do not state the direction, which is " + poses.front().frames +
                      ": add it where they are read, such as --poses-are world_from_camera");
  if (is_assumed)
    remarks.push_back("rows of " + form + " are " + rows->frames + ", and so are poses without a direction");
  if (is_at_origin) remarks.push_back("rotations without a translation are written with one of 0");
  if (has_lock) {
    remarks.push_back(
        "gimbal lock: the first and the last Euler angle turn about one axis; only their sum or difference "
        "is determined, and one is given as 0");
  }
  return text;
}

std::string tumText(const std::vector<double>& times_s, const std::vector<SE3>& camera_from_world) {
  expect(times_s.size() == camera_from_world.size(), "one time per pose");
  std::vector<NamedPose> poses;
  for (std::size_t i = 0; i < times_s.size(); ++i)
    poses.push_back({.id = exactText(times_s[i]), .stated = camera_from_world[i].inverse()});
  std::vector<std::string> none;
  return poseText(poses, "tum", none);
}

}  // namespace alidade
