// SPDX-License-Identifier: MIT
#include "alidade/files/scene_file.h"

#include <cstdint>
#include <filesystem>
#include <initializer_list>
#include <utility>

#include "alidade/core/size_groups.h"
#include "alidade/files/board_file.h"
#include "alidade/files/camera_source.h"
#include "alidade/files/formats/alidade_format.h"
#include "alidade/files/text/pose_node.h"
#include "alidade/files/text/yaml_writer.h"

namespace alidade {
namespace {

using detail::withPlace;
using detail::YamlNode;

constexpr std::pair<const char*, FootageSurroundings> kSurroundings[] = {
    {"room", FootageSurroundings::kRoom},
    {"plane", FootageSurroundings::kPlane},
    {"far", FootageSurroundings::kFar}};

constexpr std::pair<const char*, FootagePath> kPaths[] = {{"walk", FootagePath::kWalk},
                                                          {"rotation", FootagePath::kRotation},
                                                          {"static", FootagePath::kStatic},
                                                          {"straight", FootagePath::kStraight}};

// Reads the numbers of a map that has no other keys. Keys are the names in the code.
void readNumbers(const YamlNode& map, std::vector<std::string> other_keys,
                 std::initializer_list<std::pair<const char*, double*>> numbers) {
  for (const auto& [key, number] : numbers) other_keys.emplace_back(key);
  map.allowKeys(other_keys);
  for (const auto& [key, number] : numbers) {
    if (const auto value = map.find(key)) *number = value->number();
  }
}

// Errors in the board file also name the scene's line, as the mistake may be on either side.
Board readSceneBoard(const YamlNode& node, const std::filesystem::path& folder,
                     std::vector<std::string>& files) {
  std::string source = node.text();
  if (source.find(':') == std::string::npos) {
    source = (folder / source).string();
    files.push_back(source);
  }
  return withPlace(node.where(), [&] { return readBoard(source); });
}

// `node` states the image size. Rendering needs memory for several images.
void checkRenderSize(const YamlNode& node, const ImageSize& size) {
  constexpr std::int64_t kMaxPixels = 100'000'000;
  if (std::int64_t{size.width} * size.height <= kMaxPixels) return;
  throw node.error("images of " + sizeText(size) + " pixels",
                   "at most " + std::to_string(kMaxPixels) + " pixels in total for a scene");
}

// Reads a camera, and adds the path of its file and the remarks on it.
CameraRecord readSceneCamera(const YamlNode& node, const std::filesystem::path& folder,
                             std::vector<std::string>& remarks, std::vector<std::string>& files) {
  if (node.isMap()) {
    node.allowKeys({"model", "image_size", "parameters", "pupil", "correction"});
    const YamlNode size_node = node.at("image_size");
    const ImageSize size = detail::readImageSize(size_node);
    checkRenderSize(size_node, size);
    return {.camera = detail::readCamera(node), .image_size = size};
  }
  const std::string file = (folder / node.text()).string();
  const CameraSource source = withPlace(node.where(), [&] { return loadCameras(file); });
  CameraRecord camera = withPlace(node.where(), [&] { return onlyCamera(source); });
  checkRenderSize(node, camera.image_size);
  files.push_back(cameraFilePath(file));
  for (const Remark& remark : source.cameras.front().remarks) remarks.push_back(remark.message);
  return camera;
}

std::uint64_t readSeed(const YamlNode& root, std::uint64_t otherwise) {
  const auto node = root.find("seed");
  if (!node) return otherwise;
  if (node->integer() < 0) throw node->error("'" + node->text() + "'", "0 or more");
  return static_cast<std::uint64_t>(node->integer());
}

void readViews(const YamlNode& node, Scene& scene) {
  node.allowKeys({"random", "poses"});
  if (node.has("random") == node.has("poses"))
    throw node.error("both or neither of random and poses", "exactly one of them");
  if (node.has("random")) {
    const YamlNode count = node.at("random");
    scene.num_random_views = count.integer();
    constexpr int kMaxViews = 100'000;
    if (scene.num_random_views < 1 || scene.num_random_views > kMaxViews) {
      throw count.error("'" + count.text() + "'", "1 to 100000 views");
    }
    return;
  }
  for (const YamlNode& item : node.at("poses").items())
    scene.camera_from_board.push_back(detail::readPose(item));
  if (scene.camera_from_board.empty()) throw node.at("poses").error("no pose", "at least one");
}

// One of a few fixed words.
template <class Choice, std::size_t kCount>
void readChoice(const YamlNode& map, const char* key, const std::pair<const char*, Choice> (&choices)[kCount],
                Choice& choice) {
  const auto node = map.find(key);
  if (!node) return;
  std::string expected;
  for (std::size_t i = 0; i < kCount; ++i) {
    if (node->text() == choices[i].first) {
      choice = choices[i].second;
      return;
    }
    expected += (i == 0 ? "" : i + 1 == kCount ? " or " : ", ") + std::string(choices[i].first);
  }
  throw node->error("'" + node->text() + "'", expected);
}

constexpr std::pair<const char*, CameraOn> kPlaces[] = {{"hand", CameraOn::kHand}, {"base", CameraOn::kBase}};
constexpr std::pair<const char*, RobotMistake> kMistakes[] = {
    {"quaternion_order", RobotMistake::kQuaternionOrder},
    {"millimetres", RobotMistake::kMillimetres},
    {"degrees", RobotMistake::kDegrees},
    {"euler_order", RobotMistake::kEulerOrder},
    {"inverted", RobotMistake::kInverted},
    {"left_handed", RobotMistake::kLeftHanded},
    {"other_recording", RobotMistake::kOtherRecording},
    {"shifted", RobotMistake::kShifted},
    {"swapped", RobotMistake::kSwapped},
    {"board_moved", RobotMistake::kBoardMoved},
    {"one_pose_wrong", RobotMistake::kOnePoseWrong},
    {"mirrored_images", RobotMistake::kMirroredImages}};

SceneRobot readRobot(const YamlNode& node) {
  SceneRobot robot;
  readNumbers(node, {"camera_on", "poses", "mistake"},
              {{"rotation_noise_rad", &robot.noise.rotation_rad},
               {"translation_noise_m", &robot.noise.translation_m}});
  readChoice(node, "camera_on", kPlaces, robot.camera_on);
  if (const auto n = node.find("mistake")) readChoice(node, "mistake", kMistakes, robot.mistake.emplace());
  if (const auto n = node.find("poses")) {
    robot.num_poses = n->integer();
    if (robot.num_poses < 1 || robot.num_poses > 1000)
      throw n->error("'" + n->text() + "'", "1 to 1000 poses");
  }
  if (!(robot.noise.rotation_rad >= 0) || !(robot.noise.translation_m >= 0))
    throw node.error("noise below 0", "0 or more");
  return robot;
}

Scene boardSceneFrom(const YamlNode& root, const std::filesystem::path& folder) {
  std::vector<std::string> remarks;
  std::vector<std::string> files;
  const Board board = readSceneBoard(root.at("board"), folder, files);
  const CameraRecord camera = readSceneCamera(root.at("camera"), folder, remarks, files);
  Scene scene{.camera = camera.camera,
              .image_size = camera.image_size,
              .board = board,
              .camera_remarks = remarks,
              .files = files};
  if (const auto n = root.find("robot")) {
    if (root.has("views")) throw n->error("robot beside views", "one of the two");
    scene.robot = readRobot(*n);
  } else {
    readViews(root.at("views"), scene);
  }
  scene.seed = readSeed(root, scene.seed);
  if (const auto n = root.find("random")) {
    RandomViewOptions& views = scene.random_views;
    readNumbers(*n, {},
                {{"max_tilt_deg", &views.max_tilt_deg},
                 {"max_roll_deg", &views.max_roll_deg},
                 {"min_fill", &views.min_fill},
                 {"max_fill", &views.max_fill},
                 {"margin_px", &views.margin_px}});
    withPlace(n->where(), [&] { views.validate(); });
  }
  if (const auto n = root.find("render")) {
    RenderOptions& render = scene.render;
    readNumbers(*n, {"samples"},
                {{"blur_px", &render.blur_px},
                 {"dark_level", &render.dark_level},
                 {"bright_level", &render.bright_level},
                 {"background_level", &render.background_level},
                 {"border_square", &render.border_square},
                 {"falloff", &render.falloff},
                 {"vignetting_exponent", &render.vignetting_exponent},
                 {"read_noise", &render.read_noise},
                 {"full_well_electrons", &render.full_well_electrons}});
    if (const auto samples = n->find("samples")) render.samples = samples->integer();
    withPlace(n->where(), [&] { render.validate(); });
  }
  if (const auto n = root.find("corner_noise_px")) {
    scene.corner_noise_px = n->number();
    if (scene.corner_noise_px < 0) throw n->error("'" + n->text() + "'", "0 or more");
  }
  return scene;
}

FootageScene footageSceneFrom(const YamlNode& root, const std::filesystem::path& folder) {
  root.allowKeys({"alidade_scene", "camera", "footage", "seed", "render"});
  std::vector<std::string> remarks;
  std::vector<std::string> files;
  const CameraRecord camera = readSceneCamera(root.at("camera"), folder, remarks, files);
  if (!camera.camera.pupil().isFixed()) remarks.emplace_back("its entrance pupil does not move in footage");
  FootageScene scene{.camera = camera.camera.withPupil({}),
                     .image_size = camera.image_size,
                     .camera_remarks = remarks,
                     .files = files};
  const YamlNode footage = root.at("footage");
  FootageEffects& effects = scene.effects;
  readNumbers(footage, {"surroundings", "path", "frames", "moving_objects"},
              {{"frame_rate_hz", &scene.frame_rate_hz},
               {"flow_px", &scene.flow_px},
               {"shake_px", &effects.shake_px},
               {"moving_share", &effects.moving_share},
               {"rolling_shutter", &effects.rolling_shutter},
               {"stabilisation_frames", &effects.stabilisation_frames},
               {"zoom", &effects.zoom}});
  readChoice(footage, "surroundings", kSurroundings, scene.surroundings);
  readChoice(footage, "path", kPaths, scene.path);
  if (const auto n = footage.find("frames")) scene.num_frames = n->integer();
  if (const auto n = footage.find("moving_objects")) effects.moving_objects = n->integer();
  if (const auto n = root.find("render"))
    readNumbers(*n, {}, {{"blur_px", &effects.blur_px}, {"read_noise", &effects.read_noise}});
  scene.seed = readSeed(root, scene.seed);
  withPlace(footage.where(), [&] { scene.validate(); });
  return scene;
}

AnyScene sceneFrom(const YamlNode& root, const std::string& name) {
  root.allowKeys({"alidade_scene", "camera", "board", "views", "robot", "footage", "seed", "random", "render",
                  "corner_noise_px"});
  const YamlNode version = root.at("alidade_scene");
  if (version.integer() != 1) throw version.error("format version " + version.text(), "1");
  const std::filesystem::path folder = std::filesystem::path(name).parent_path();
  if (root.has("footage")) return footageSceneFrom(root, folder);
  return boardSceneFrom(root, folder);
}

}  // namespace

AnyScene readSceneFile(const std::string& path) {
  return sceneFrom(YamlNode::readFile(path), path);
}

AnyScene parseSceneFile(const std::string& text, const std::string& name) {
  return sceneFrom(YamlNode::parse(text, name), name);
}

std::string posesText(const std::vector<std::string>& images, const std::string& key,
                      const std::vector<SE3>& camera_from_x) {
  expect(images.size() == camera_from_x.size(), "one pose per image");
  YAML::Emitter out;
  out << YAML::BeginSeq;
  for (std::size_t i = 0; i < images.size(); ++i) {
    const auto writePose = [&](YAML::Emitter& to) { detail::writePose(to, camera_from_x[i]); };
    detail::flowMap("image", images[i], key, writePose)(out);
  }
  out << YAML::EndSeq;
  return detail::documentText(out);
}

}  // namespace alidade
