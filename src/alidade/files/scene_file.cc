// SPDX-License-Identifier: MIT
#include "alidade/files/scene_file.h"

#include <cstdint>
#include <filesystem>
#include <utility>

#include "alidade/core/size_groups.h"
#include "alidade/files/board_file.h"
#include "alidade/files/camera_source.h"
#include "alidade/files/formats/alidade_reader.h"
#include "alidade/files/text/pose_node.h"
#include "alidade/files/text/yaml_writer.h"

namespace alidade {
namespace {

using detail::withPlace;
using detail::YamlNode;

// Fields of an options struct by their names in the file, which are their names in the code.
template <class Options>
struct Field {
  const char* key;
  double Options::*value;
};

constexpr Field<RandomViewOptions> kRandomFields[] = {{"max_tilt_deg", &RandomViewOptions::max_tilt_deg},
                                                      {"max_roll_deg", &RandomViewOptions::max_roll_deg},
                                                      {"min_fill", &RandomViewOptions::min_fill},
                                                      {"max_fill", &RandomViewOptions::max_fill},
                                                      {"margin_px", &RandomViewOptions::margin_px}};

constexpr Field<RenderOptions> kRenderFields[] = {
    {"blur_px", &RenderOptions::blur_px},
    {"dark_level", &RenderOptions::dark_level},
    {"bright_level", &RenderOptions::bright_level},
    {"background_level", &RenderOptions::background_level},
    {"border_square", &RenderOptions::border_square},
    {"falloff", &RenderOptions::falloff},
    {"vignetting_exponent", &RenderOptions::vignetting_exponent},
    {"read_noise", &RenderOptions::read_noise},
    {"full_well_electrons", &RenderOptions::full_well_electrons}};

constexpr Field<FootageScene> kFootageFields[] = {
    {"frame_rate_hz", &FootageScene::frame_rate_hz},
    {"flow_px", &FootageScene::flow_px},
    {"shake_px", &FootageScene::shake_px},
    {"moving_share", &FootageScene::moving_share},
    {"rolling_shutter", &FootageScene::rolling_shutter},
    {"stabilisation_frames", &FootageScene::stabilisation_frames},
    {"zoom", &FootageScene::zoom}};

constexpr Field<FootageScene> kFootageRenderFields[] = {{"blur_px", &FootageScene::blur_px},
                                                        {"read_noise", &FootageScene::read_noise}};

constexpr std::pair<const char*, FootageSurroundings> kSurroundings[] = {
    {"room", FootageSurroundings::kRoom},
    {"plane", FootageSurroundings::kPlane},
    {"far", FootageSurroundings::kFar}};

constexpr std::pair<const char*, FootagePath> kPaths[] = {{"walk", FootagePath::kWalk},
                                                          {"rotation", FootagePath::kRotation},
                                                          {"static", FootagePath::kStatic},
                                                          {"straight", FootagePath::kStraight}};

template <class Options, std::size_t kCount>
void readFields(const YamlNode& node, const Field<Options> (&fields)[kCount],
                std::vector<std::string> other_keys, Options& options) {
  std::vector<std::string> keys = std::move(other_keys);
  for (const auto& field : fields) keys.emplace_back(field.key);
  node.allowKeys(keys);
  for (const auto& field : fields) {
    if (const auto value = node.find(field.key)) options.*(field.value) = value->number();
  }
}

// The scene's line goes before complaints about what it only names: the mistake may be on either side.
Board readSceneBoard(const YamlNode& node, const std::filesystem::path& folder,
                     std::vector<std::string>& files) {
  std::string source = node.text();
  if (source.find(':') == std::string::npos) {
    source = (folder / source).string();
    files.push_back(source);
  }
  return withPlace(node.where(), [&] { return readBoard(source); });
}

// `node` is the one that says how large the images are. Rendering takes memory for several of them.
void checkRenderSize(const YamlNode& node, const ImageSize& size) {
  constexpr std::int64_t kMaxPixels = 100'000'000;
  if (std::int64_t{size.width} * size.height <= kMaxPixels) return;
  throw node.error("images of " + sizeText(size) + " pixels",
                   "at most " + std::to_string(kMaxPixels) + " pixels in total for a scene");
}

// The camera of a scene, and what is known of the file that it comes from.
struct SceneCamera {
  AnyCamera camera;
  ImageSize image_size;
  std::vector<std::string> remarks = {};
  std::vector<std::string> files = {};
};

SceneCamera readSceneCamera(const YamlNode& node, const std::filesystem::path& folder) {
  if (node.isMap()) {
    node.allowKeys({"model", "image_size", "parameters"});
    const YamlNode size_node = node.at("image_size");
    const ImageSize size = detail::readImageSize(size_node);
    checkRenderSize(size_node, size);
    return {.camera = detail::readCamera(node), .image_size = size};
  }
  const std::string file = (folder / node.text()).string();
  const CameraSource source = withPlace(node.where(), [&] { return loadCameras(file); });
  const CameraRecord read = withPlace(node.where(), [&] { return onlyCamera(source); });
  checkRenderSize(node, read.image_size);
  SceneCamera result{.camera = read.camera, .image_size = read.image_size, .files = {cameraFilePath(file)}};
  for (const Remark& remark : source.cameras.front().remarks) result.remarks.push_back(remark.message);
  return result;
}

Scene readBasics(const YamlNode& root, const std::filesystem::path& folder) {
  std::vector<std::string> files;
  const Board board = readSceneBoard(root.at("board"), folder, files);
  const SceneCamera camera = readSceneCamera(root.at("camera"), folder);
  files.insert(files.end(), camera.files.begin(), camera.files.end());
  return {.camera = camera.camera,
          .image_size = camera.image_size,
          .board = board,
          .camera_remarks = camera.remarks,
          .files = files};
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

Scene boardSceneFrom(const YamlNode& root, const std::filesystem::path& folder) {
  Scene scene = readBasics(root, folder);
  readViews(root.at("views"), scene);
  scene.seed = readSeed(root, scene.seed);
  if (const auto n = root.find("random")) {
    readFields(*n, kRandomFields, {}, scene.random_views);
    withPlace(n->where(), [&] { scene.random_views.validate(); });
  }
  if (const auto n = root.find("render")) {
    readFields(*n, kRenderFields, {"samples"}, scene.render);
    if (const auto samples = n->find("samples")) scene.render.samples = samples->integer();
    withPlace(n->where(), [&] { scene.render.validate(); });
  }
  if (const auto n = root.find("corner_noise_px")) {
    scene.corner_noise_px = n->number();
    if (scene.corner_noise_px < 0) throw n->error("'" + n->text() + "'", "0 or more");
  }
  return scene;
}

// One of a few words.
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

FootageScene footageSceneFrom(const YamlNode& root, const std::filesystem::path& folder) {
  root.allowKeys({"alidade_scene", "camera", "footage", "seed", "render"});
  const SceneCamera camera = readSceneCamera(root.at("camera"), folder);
  FootageScene scene{.camera = camera.camera,
                     .image_size = camera.image_size,
                     .camera_remarks = camera.remarks,
                     .files = camera.files};
  const YamlNode footage = root.at("footage");
  readFields(footage, kFootageFields, {"surroundings", "path", "frames", "moving_objects"}, scene);
  readChoice(footage, "surroundings", kSurroundings, scene.surroundings);
  readChoice(footage, "path", kPaths, scene.path);
  if (const auto n = footage.find("frames")) scene.num_frames = n->integer();
  if (const auto n = footage.find("moving_objects")) scene.moving_objects = n->integer();
  if (const auto n = root.find("render")) readFields(*n, kFootageRenderFields, {}, scene);
  scene.seed = readSeed(root, scene.seed);
  withPlace(footage.where(), [&] { scene.validate(); });
  return scene;
}

AnyScene sceneFrom(const YamlNode& root, const std::string& name) {
  root.allowKeys({"alidade_scene", "camera", "board", "views", "footage", "seed", "random", "render",
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
