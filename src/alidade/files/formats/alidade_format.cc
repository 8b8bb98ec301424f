// SPDX-License-Identifier: MIT
// Alidade's own camera and rig files (docs/files.md).
#include "alidade/files/formats/alidade_format.h"

#include <algorithm>
#include <cstdint>
#include <limits>
#include <map>
#include <memory>
#include <set>

#include "alidade/camera/any_camera.h"
#include "alidade/camera/correction_field.h"
#include "alidade/camera/model_traits.h"
#include "alidade/core/error.h"
#include "alidade/core/mapped.h"
#include "alidade/core/text.h"
#include "alidade/files/formats/alidade_writer.h"
#include "alidade/files/formats/camera_document.h"
#include "alidade/files/formats/camera_format.h"
#include "alidade/files/formats/pose_numbers.h"
#include "alidade/files/text/pose_node.h"
#include "alidade/files/text/yaml_writer.h"

namespace alidade::detail {
namespace {

std::vector<std::string> strings(std::span<const std::string_view> names) {
  return {names.begin(), names.end()};
}

// Checks that the only keys of a map are a model's parameters, `names`. @throws Error (kInput), naming the
// other model if all keys belong to one
void allowParameters(const YamlNode& map, std::string_view own) {
  const auto names = parameterNames(own);
  const std::vector<std::string> listed = map.isMap() ? map.keys() : std::vector<std::string>();
  const std::set<std::string> keys(listed.begin(), listed.end());
  const auto areKeysOf = [&keys](std::string_view id) {
    const auto theirs = parameterNames(id);
    return std::set<std::string>(theirs.begin(), theirs.end()) == keys;
  };
  std::string other;  // the first, because two models may have parameters of the same names
  if (!areKeysOf(own)) {
    const auto found = std::ranges::find_if(modelIds(), areKeysOf);
    if (found != modelIds().end()) other = *found;
  }
  if (!other.empty()) {
    throw map.error("the keys of the model " + other + ": " +
                        join(std::vector<std::string>(keys.begin(), keys.end()), ", "),
                    "the keys of " + std::string(own) + ": " + join(strings(names), ", "),
                    "if only the model name was changed, change it back to " + other +
                        "; to fit another model, run: alidade convert --model " + std::string(own));
  }
  map.allowKeys(strings(names));
}

std::vector<double> readByName(const YamlNode& node, std::string_view model) {
  allowParameters(node, model);
  return mapped(strings(parameterNames(model)),
                [&](const std::string& name) { return node.at(name).number(); });
}

EntrancePupil readPupil(const YamlNode& node) {
  node.allowKeys(strings(EntrancePupil::kNames));
  const auto valueAt = [&](std::string_view name) {
    const auto value = node.find(std::string(name));
    if (!value) return 0.0;
    if (const auto expected = EntrancePupil::complaint(value->number()))
      throw value->error(value->text(), *expected);
    return value->number();
  };
  return {.s1_m = valueAt(EntrancePupil::kNames[0]), .s2_m = valueAt(EntrancePupil::kNames[1])};
}

CorrectionField readCorrection(const YamlNode& node) {
  node.allowKeys({"grid", "coefficients"});
  const YamlNode grid = node.at("grid");
  grid.allowKeys({"columns", "rows", "x", "y", "cell_width", "cell_height", "bounded"});
  const auto bounded = grid.find("bounded");
  const int columns = grid.at("columns").integer();
  if (columns < 1 || columns > CorrectionGrid::kMaxCells)
    throw grid.at("columns").error(std::to_string(columns),
                                   "1 to " + std::to_string(CorrectionGrid::kMaxCells));
  std::vector<double> points;
  for (const YamlNode& row : node.at("coefficients").items()) {
    const std::vector<double> numbers = row.numbers(2 * (static_cast<std::size_t>(columns) + 3));
    points.insert(points.end(), numbers.begin(), numbers.end());
  }
  return withPlace(node.where(), [&] {
    return CorrectionField({.columns = columns,
                            .rows = grid.at("rows").integer(),
                            .origin_px = {grid.at("x").number(), grid.at("y").number()},
                            .cell_px = {grid.at("cell_width").number(), grid.at("cell_height").number()},
                            .is_bounded = bounded && bounded->boolean()},
                           std::move(points));
  });
}

void checkConventions(const YamlNode& node) {
  node.allowKeys({"pixel_origin", "length_unit", "pose"});
  for (const auto& [key, expected] :
       {std::pair<std::string, std::string>{"pixel_origin", "top_left_pixel_center"},
        {"length_unit", "m"},
        {"pose", "camera_from_board"}}) {
    const auto value = node.find(key);
    if (value && value->text() != expected)
      throw value->error("'" + value->text() + "'", "'" + expected + "', the only convention of this format");
  }
}

DomainClaim readDomain(const YamlNode& node) {
  node.allowKeys({"max_angle_rad", "full_image"});
  return {.max_angle_rad = node.at("max_angle_rad").number(), .full_image = node.at("full_image").boolean()};
}

std::vector<SelfCheckPoint> readSelfCheck(const YamlNode& node) {
  std::vector<SelfCheckPoint> points;
  for (const YamlNode& item : node.items()) {
    item.allowKeys({"point", "pixel"});
    const std::vector<double> point = item.at("point").numbers(3);
    const std::vector<double> pixel = item.at("pixel").numbers(2);
    points.push_back({{point[0], point[1], point[2]}, {pixel[0], pixel[1]}});
  }
  return points;
}

WarpRecord readWarp(const YamlNode& node) {
  WarpRecord warp;
  warp.shape = {.bend_x_m = node.at("bend_x_m").number(), .bend_y_m = node.at("bend_y_m").number()};
  warp.std_m = {node.at("bend_x_std_m").number(), node.at("bend_y_std_m").number()};
  return warp;
}

// A map for a single board; for several, a list of maps that name their boards.
std::vector<WarpRecord> readWarps(const YamlNode& node, const std::vector<std::string>& boards) {
  const std::vector<std::string> keys = {"bend_x_m", "bend_y_m", "bend_x_std_m", "bend_y_std_m"};
  if (!node.isSequence()) {
    node.allowKeys(keys);
    return {readWarp(node)};
  }
  std::vector<WarpRecord> warps;
  for (const YamlNode& item : node.items()) {
    std::vector<std::string> allowed = keys;
    allowed.emplace_back("board");
    item.allowKeys(allowed);
    const YamlNode name = item.at("board");
    const auto board = std::ranges::find(boards, name.text());
    if (board == boards.end())
      throw name.error("'" + name.text() + "'", "a board of 'board': " + join(boards, ", "));
    warps.push_back(readWarp(item));
    warps.back().board = static_cast<std::size_t>(board - boards.begin());
  }
  return warps;
}

CameraName readName(const YamlNode& node) {
  node.allowKeys({"name", "serial", "lens"});
  CameraName name;
  if (const auto n = node.find("name")) name.name = n->text();
  if (const auto n = node.find("serial")) name.serial = n->text();
  if (const auto n = node.find("lens")) name.lens = n->text();
  return name;
}

std::vector<Eigen::Vector2d> readPixels(const YamlNode& node) {
  std::vector<Eigen::Vector2d> pixels;
  for (const YamlNode& item : node.items()) {
    const std::vector<double> pixel = item.numbers(2);
    pixels.emplace_back(pixel[0], pixel[1]);
  }
  return pixels;
}

// The place of a value in the text; an alias has the place of its value.
using Place = std::pair<int, YAML::NodeType::value>;

Place placeOf(const YAML::Node& node) {
  return {node.Mark().pos, node.Type()};
}

// Counts the uses of each value; shared values are visited once.
void countUses(const YAML::Node& node, std::map<Place, int>& uses) {
  if (++uses[placeOf(node)] > 1) return;
  for (const auto& item : node) {
    if (!node.IsMap()) {
      countUses(item, uses);
    } else {
      countUses(item.first, uses);
      countUses(item.second, uses);
    }
  }
}

// Writes a value of the user unchanged: shared values are written once with an anchor, and strings keep their
// quotes, which yaml-cpp would drop.
void writeAsStated(YAML::Emitter& out, const YAML::Node& node, const std::map<Place, int>& uses,
                   std::map<Place, std::string>& names) {
  if (uses.at(placeOf(node)) > 1) {
    const auto [entry, is_new] = names.emplace(placeOf(node), std::to_string(names.size() + 1));
    if (!is_new) {
      out << YAML::Alias(entry->second);
      return;
    }
    out << YAML::Anchor(entry->second);
  }
  const std::string& tag = node.Tag();
  const bool is_quoted = tag == "!";
  if (!tag.empty() && tag != "?" && !is_quoted) out << YAML::VerbatimTag(tag);
  if (node.Style() == YAML::EmitterStyle::Flow) out << YAML::Flow;
  if (node.IsNull()) {
    out << YAML::Null;
  } else if (node.IsScalar()) {
    if (is_quoted) out << YAML::DoubleQuoted;
    out << node.Scalar();
  } else {
    out << (node.IsMap() ? YAML::BeginMap : YAML::BeginSeq);
    for (const auto& item : node) {
      if (!node.IsMap()) {
        writeAsStated(out, item, uses, names);
      } else {
        writeAsStated(out, item.first, uses, names);
        writeAsStated(out, item.second, uses, names);
      }
    }
    out << (node.IsMap() ? YAML::EndMap : YAML::EndSeq);
  }
}

// The user's own keys of a file's root, with their values, as lines of YAML; comments are lost.
std::string userKeys(const YAML::Node& root) {
  YAML::Node own(YAML::NodeType::Map);
  for (const auto& entry : root) {
    if (isUserKey(entry.first.Scalar())) own.force_insert(entry.first, entry.second);
  }
  if (own.size() == 0) return "";
  std::map<Place, int> uses;
  std::map<Place, std::string> names;
  countUses(own, uses);
  YAML::Emitter out;
  writeAsStated(out, own, uses, names);
  return documentText(out);
}

void readPoseStd(const YamlNode& entry, RigCameraRecord& record) {
  const auto std = entry.find("camera_from_rig_std");
  if (!std) return;
  std->allowKeys({"translation_m", "rotation_rad"});
  record.translation_std_m = Eigen::Vector3d(std->at("translation_m").numbers(3).data());
  record.rotation_std_rad = Eigen::Vector3d(std->at("rotation_rad").numbers(3).data());
}

// NaN if corners of a calibration that must not be used cannot be projected.
double readRms(const YamlNode& calibration, Verdict verdict) {
  const bool may_lack = verdict == Verdict::kNo && !calibration.find("rms_px");
  return may_lack ? std::numeric_limits<double>::quiet_NaN() : calibration.at("rms_px").number();
}

CalibrationRecord readCalibration(const YamlNode& node, std::string_view model) {
  node.allowKeys(
      words("verdict date accuracy_px accuracy_distance_m covered_share rms_px holdout_rms_px num_views "
            "num_corners board board_warp findings parameter_std pupil_std covariance covariance_by "
            "view_centers"));
  CalibrationRecord record;
  if (const auto n = node.find("verdict")) record.verdict = readVerdict(*n);
  if (const auto n = node.find("date")) record.date = n->text();
  if (const auto n = node.find("accuracy_px")) record.accuracy_px = n->number();
  if (const auto n = node.find("accuracy_distance_m")) {
    record.accuracy_distance_m = n->number();
    if (record.accuracy_distance_m <= 0) throw n->error(n->text(), "metres above 0");
  }
  if (const auto n = node.find("covered_share")) record.covered_share = n->number();
  record.rms_px = readRms(node, record.verdict);
  if (const auto n = node.find("holdout_rms_px")) record.holdout_rms_px = n->number();
  record.num_views = readCount(node.at("num_views"));
  record.num_corners = readCount(node.at("num_corners"));
  if (const auto n = node.find("board")) record.boards = n->texts();
  if (const auto n = node.find("board_warp")) record.warps = readWarps(*n, record.boards);
  if (const auto n = node.find("findings")) {
    for (const YamlNode& item : n->items()) record.findings.push_back(item.text());
  }
  if (const auto n = node.find("parameter_std")) record.parameter_std = readByName(*n, model);
  if (const auto n = node.find("pupil_std")) {
    n->allowKeys(strings(EntrancePupil::kNames));
    for (const std::string_view name : EntrancePupil::kNames) {
      const auto std = n->find(std::string(name));
      if (!std && name == EntrancePupil::kNames.front()) throw n->error("no s1", "s1, or s1 and s2");
      if (std && std->number() < 0) throw std->error(std->text(), "0 or more");
      if (std) record.pupil_std.push_back(std->number());
    }
  }
  if (const auto n = node.find("covariance"))
    record.covariance = readTriangle(*n, parameterNames(model).size());
  if (const auto n = node.find("covariance_by")) {
    if (n->text() != "views") throw n->error("'" + n->text() + "'", "'views'");
    record.is_covariance_by_views = true;
  }
  if (const auto n = node.find("view_centers")) record.view_centers = readPixels(*n);
  return record;
}

}  // namespace

void checkVersion(const YamlNode& version) {
  if (version.integer() == 1) return;
  throw version.error("format version " + version.text(), "1",
                      "the file may come from a newer release of Alidade; update the program");
}

int readCount(const YamlNode& node) {
  const int count = node.integer();
  if (count < 0) throw node.error(std::to_string(count), "a count");
  return count;
}

Verdict readVerdict(const YamlNode& node) {
  const auto verdict = verdictOf(node.text());
  if (!verdict)
    throw node.error("'" + node.text() + "'", "'trustworthy', 'usable_with_reservations' or 'rejected'");
  return *verdict;
}

std::vector<double> readTriangle(const YamlNode& node, std::size_t num_rows) {
  const std::vector<YamlNode> items = node.items();
  if (items.size() != num_rows) {
    throw node.error(std::to_string(items.size()) + " rows",
                     std::to_string(num_rows) + " rows, one for each parameter");
  }
  std::vector<double> triangle;
  for (std::size_t i = 0; i < num_rows; ++i) {
    const std::vector<double> row = items[i].numbers(i + 1);
    triangle.insert(triangle.end(), row.begin(), row.end());
  }
  return triangle;
}

ImageSize readImageSize(const YamlNode& node) {
  node.allowKeys({"width", "height"});
  const auto side = [&](const char* key) {
    const YamlNode value = node.at(key);
    constexpr int kMaxSide = 1'000'000;
    const int pixels = value.integer();
    if (pixels < 1 || pixels > kMaxSide) throw value.error(std::to_string(pixels), "1 to 1000000 pixels");
    return pixels;
  };
  const ImageSize size{.width = side("width"), .height = side("height")};
  constexpr std::int64_t kMaxPixels = std::int64_t{1} << 30U;
  if (std::int64_t{size.width} * size.height > kMaxPixels) {
    throw node.error(std::to_string(size.width) + "x" + std::to_string(size.height) + " pixels",
                     "at most " + std::to_string(kMaxPixels) + " pixels in total");
  }
  return size;
}

AnyCamera readCamera(const YamlNode& root) {
  const YamlNode model = root.at("model");
  const std::string id = model.text();
  if (std::find(modelIds().begin(), modelIds().end(), id) == modelIds().end()) {
    throw model.error("unknown camera model '" + id + "'", "one of " + join(modelIds(), ", "),
                      didYouMeanOne(id, aliasedModels()));
  }
  const YamlNode parameters = root.at("parameters");
  const std::vector<double> values = readByName(parameters, id);
  for (std::size_t i = 0; i < values.size(); ++i) {
    if (const auto complaint = parameterComplaint(id, i, values[i]))
      throw parameters.at(std::string(parameterNames(id)[i])).error(exactText(values[i]), *complaint);
  }
  AnyCamera camera = AnyCamera::make(id, values);
  if (const auto pupil = root.find("pupil")) camera = camera.withPupil(readPupil(*pupil));
  if (const auto correction = root.find("correction"))
    camera = camera.withCorrection(std::make_shared<const CorrectionField>(readCorrection(*correction)));
  return camera;
}

namespace {

// Reads a whole camera file, of which only the first four keys are required.
CameraRecord readCameraRoot(const YamlNode& root) {
  if (!root.isMap() || !root.has("alidade_camera")) {
    throw root.error("a file without the key 'alidade_camera'", "an Alidade camera file",
                     "add the line: alidade_camera: 1");
  }
  checkVersion(root.at("alidade_camera"));
  root.allowKeys({"alidade_camera", "model", "image_size", "parameters", "pupil", "correction", "camera",
                  "conventions", "domain", "self_check", "calibration", "created_by"});
  CameraRecord file{.camera = readCamera(root), .image_size = readImageSize(root.at("image_size"))};
  if (const auto n = root.find("camera")) file.name = readName(*n);
  if (const auto n = root.find("conventions")) checkConventions(*n);
  if (const auto n = root.find("domain")) file.domain = readDomain(*n);
  if (const auto n = root.find("self_check")) file.self_check = readSelfCheck(*n);
  if (const auto n = root.find("calibration")) file.calibration = readCalibration(*n, file.camera.modelId());
  if (const auto n = root.find("created_by")) file.created_by = n->text();
  file.user_keys = userKeys(root.node());
  return file;
}

// Reads an item of a rig file's `cameras`.
RigCameraRecord readRigCamera(const YamlNode& entry) {
  entry.allowKeys({"name", "camera_from_rig", "camera_from_rig_std", "time_offset_s", "camera"});
  RigCameraRecord record{.camera = readCameraRoot(entry.at("camera")),
                         .camera_from_rig = readPose(entry.at("camera_from_rig"))};
  record.camera.name.name = entry.at("name").text();
  readPoseStd(entry, record);
  return record;
}

// Reads the rest of a rig file; `rig` already has its cameras and their poses.
void readRigRest(const YamlNode& root, RigRecord& rig) {
  const std::vector<YamlNode> entries = root.at("cameras").items();
  expect(entries.size() == rig.cameras.size(), "a rig is read whole");
  std::size_t num_columns = 6 * (entries.size() - 1);
  for (std::size_t c = 0; c < entries.size(); ++c) {
    readPoseStd(entries[c], rig.cameras[c]);
    if (const auto offset = entries[c].find("time_offset_s")) rig.cameras[c].time_offset_s = offset->number();
    num_columns += rig.cameras[c].camera.camera.parameters().size();
  }
  if (const auto calibration = root.find("calibration")) {
    calibration->allowKeys({"verdict", "rms_px", "num_frames", "findings"});
    rig.verdict = readVerdict(calibration->at("verdict"));
    rig.rms_px = readRms(*calibration, rig.verdict);
    rig.num_frames = calibration->at("num_frames").integer();
    rig.findings = calibration->at("findings").texts();
  }
  if (const auto covariance = root.find("covariance"))
    rig.covariance = readTriangle(*covariance, num_columns);
  if (const auto created_by = root.find("created_by")) rig.created_by = created_by->text();
  rig.user_keys = userKeys(root.node());
}

}  // namespace

namespace formats {
namespace alidade_format {

bool recognises(const CameraDocument& document) {
  return document.has("alidade_camera") || document.has("alidade_rig") || document.has("alidade_handeye");
}

// The cameras of a rig file.
CameraSource readRig(const YamlNode& root, const ReadOptions& options) {
  root.allowKeys({"alidade_rig", "conventions", "cameras", "calibration", "covariance", "created_by"});
  checkVersion(root.at("alidade_rig"));
  CameraSource cameras{.readRigRest = [root](RigRecord& rig) { readRigRest(root, rig); }};
  for (const YamlNode& entry : root.at("cameras").items()) {
    const std::string name = entry.at("name").text();
    if (!options.only.empty() && options.only != name) {
      cameras.passed.push_back(name);
      continue;
    }
    cameras.add(name, [&] {
      RigCameraRecord record = readRigCamera(entry);
      return StatedCamera{.name = name,
                          .camera = record.camera.camera,
                          .image_size = record.camera.image_size,
                          .camera_from_rig = record.camera_from_rig,
                          .own = std::move(record.camera)};
    });
  }
  return cameras;
}

CameraSource read(const CameraDocument& document, const ReadOptions& options) {
  if (document.has("alidade_rig")) return readRig(document.root(), options);
  if (document.has("alidade_handeye"))
    throw document.root().error("a hand-eye file, which says where a camera is on a robot",
                                "a camera or rig file", "test it with 'alidade handeye validate'");
  CameraRecord file = readCameraRoot(document.root());
  return {.cameras = {{.camera = file.camera, .image_size = file.image_size, .own = std::move(file)}}};
}

// Several cameras make a rig. How it was calibrated is unknown here.
std::string write(std::span<const NamedCamera> cameras, const std::string&) {
  if (cameras.size() > 1) {
    const std::vector<SE3> poses = posesOf(cameras);
    if (poses.empty()) {
      throw errorAt(cameras.front().where, std::to_string(cameras.size()) + " cameras without poses",
                    "one camera, or cameras with poses, which are a rig", "select a camera with FILE#NAME");
    }
    RigRecord rig;
    for (std::size_t i = 0; i < cameras.size(); ++i) {
      rig.cameras.push_back(
          {.camera = bareRecord(cameras[i].camera, cameras[i].image_size, ""), .camera_from_rig = poses[i]});
      rig.cameras.back().camera.name.name = cameras[i].name.empty() ? std::to_string(i) : cameras[i].name;
    }
    return rigFileText(rig);
  }
  return cameraFileText(bareRecord(cameras.front().camera, cameras.front().image_size, ""));
}

}  // namespace alidade_format

const CameraFormat& alidade() {
  using namespace alidade_format;
  static const CameraFormat kFormat = {.id = "alidade",
                                       .title = "Alidade camera file (YAML)",
                                       .models = {modelIds().begin(), modelIds().end()},
                                       .max_cameras = CameraFormat::kAnyNumber,
                                       .poses = CameraFormat::Poses::kFromRig,
                                       .holds_pupil = true,
                                       .holds_correction = true,
                                       .marks = {"alidade_camera", "alidade_rig"},
                                       .recognises = recognises,
                                       .read = read,
                                       .write = write};
  return kFormat;
}

}  // namespace formats

}  // namespace alidade::detail
