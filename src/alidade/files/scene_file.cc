// SPDX-License-Identifier: MIT
#include "alidade/files/scene_file.h"

#include <cstdint>
#include <filesystem>

#include "alidade/core/size_groups.h"
#include "alidade/files/board_file.h"
#include "alidade/files/camera_source.h"
#include "alidade/files/nodes.h"
#include "alidade/files/yaml_writer.h"

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

Scene readBasics(const YamlNode& root, const std::filesystem::path& folder) {
  const YamlNode camera = root.at("camera");
  std::vector<std::string> files;
  const Board board = readSceneBoard(root.at("board"), folder, files);
  if (camera.isMap()) {
    camera.allowKeys({"model", "image_size", "parameters"});
    const YamlNode size_node = camera.at("image_size");
    const ImageSize size = detail::readImageSize(size_node);
    checkRenderSize(size_node, size);
    return {.camera = detail::readCamera(camera), .image_size = size, .board = board, .files = files};
  }
  const std::string file = (folder / camera.text()).string();
  const CameraSource source = withPlace(camera.where(), [&] { return loadCameras(file); });
  const CameraRecord read = withPlace(camera.where(), [&] { return onlyCamera(source); });
  checkRenderSize(camera, read.image_size);
  files.push_back(cameraFilePath(file));
  Scene scene{.camera = read.camera, .image_size = read.image_size, .board = board, .files = files};
  for (const Remark& remark : source.cameras.front().remarks) scene.camera_remarks.push_back(remark.message);
  return scene;
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

Scene sceneFrom(const YamlNode& root, const std::string& name) {
  root.allowKeys(
      {"alidade_scene", "camera", "board", "views", "seed", "random", "render", "corner_noise_px"});
  const YamlNode version = root.at("alidade_scene");
  if (version.integer() != 1) throw version.error("format version " + version.text(), "1");
  Scene scene = readBasics(root, std::filesystem::path(name).parent_path());
  readViews(root.at("views"), scene);
  if (const auto n = root.find("seed")) {
    if (n->integer() < 0) throw n->error("'" + n->text() + "'", "0 or more");
    scene.seed = static_cast<std::uint64_t>(n->integer());
  }
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

}  // namespace

Scene readSceneFile(const std::string& path) {
  return sceneFrom(YamlNode::readFile(path), path);
}

Scene parseSceneFile(const std::string& text, const std::string& name) {
  return sceneFrom(YamlNode::parse(text, name), name);
}

std::string posesText(const std::vector<std::string>& images, const std::vector<SE3>& camera_from_board) {
  expect(images.size() == camera_from_board.size(), "one pose per image");
  YAML::Emitter out;
  out << YAML::BeginSeq;
  for (std::size_t i = 0; i < images.size(); ++i) {
    const auto writePose = [&](YAML::Emitter& to) { detail::writePose(to, camera_from_board[i]); };
    detail::flowMap("image", images[i], "camera_from_board", writePose)(out);
  }
  out << YAML::EndSeq;
  return detail::documentText(out);
}

}  // namespace alidade
