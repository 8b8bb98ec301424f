// SPDX-License-Identifier: MIT
// mrcal's .cameramodel: a Python literal that is also valid YAML (mrcal's documentation, "cameramodel: the
// camera model file format" and "lens models"; cameramodel.py names the keys of older files). Intrinsics: fx,
// fy, cx, cy, then OpenCV's coefficients. Pixel (0, 0) is a pixel's centre.
#include <array>
#include <cmath>
#include <cstdio>
#include <memory>
#include <numbers>
#include <string>

#include <fmt/format.h>

#include "alidade/camera/correction_field.h"
#include "alidade/files/formats/camera_document.h"
#include "alidade/files/formats/camera_format.h"
#include "alidade/files/formats/lens_numbers.h"
#include "alidade/files/formats/pose_numbers.h"

namespace alidade::detail::formats {
namespace mrcal_format {

constexpr std::array<LensLayout, 5> kLenses = {
    {{"LENSMODEL_PINHOLE", "pinhole", "fx fy cx cy"},
     {"LENSMODEL_OPENCV5", "radtan", "fx fy cx cy k1 k2 p1 p2 k3"},
     {"LENSMODEL_OPENCV4", "radtan", "fx fy cx cy k1 k2 p1 p2"},
     {"LENSMODEL_OPENCV8", "rational", "fx fy cx cy k1 k2 p1 p2 k3 k4 k5 k6"},
     {"LENSMODEL_OPENCV12", "thin_prism", "fx fy cx cy k1 k2 p1 p2 k3 k4 k5 k6 s1 s2 s3 s4"}}};
// 2 tan(theta / 2): the unified model with a fixed parameter and no coefficients.
constexpr LensLayout kStereographic = {"LENSMODEL_STEREOGRAPHIC", "ucm", "fx fy cx cy"};

// A stereographic lens with a displacement in its plane: a bicubic B-spline on a grid about the axis. Its
// name states the control points and the field of view that is between the outer rings.
const std::string kSplined = "LENSMODEL_SPLINED_STEREOGRAPHIC_";

constexpr std::array kModelKeys = {"lensmodel", "lens_model", "distortion_model"};  // of new and of old files
const std::string kNotCarried = "valid_intrinsics_region ";
// Rotation vector and translation, camera from reference.
constexpr std::array kPoseKeys = {"extrinsics", "rt_cam_ref"};
const std::string kOtherKeys =
    "extrinsics rt_cam_ref lensmodel lens_model distortion_model intrinsics imagersize icam_intrinsics "
    "icam_intrinsics_optimization_inputs optimization_inputs";

template <class Map>
const char* modelKey(const Map& map) {
  for (const char* key : kModelKeys) {
    if (map.has(key)) return key;
  }
  return nullptr;
}

bool recognises(const CameraDocument& document) {
  return modelKey(document) != nullptr && document.has("intrinsics") && document.has("imagersize");
}

const LensLayout& lensOf(const YamlNode& node) {
  std::string name = node.text();
  constexpr std::string_view kOldPrefix = "DISTORTION_";
  if (name.starts_with(kOldPrefix)) name = "LENSMODEL_" + name.substr(kOldPrefix.size());
  if (name == kStereographic.name) return kStereographic;
  if (const LensLayout* lens = findLayout(kLenses, name)) return *lens;
  throw node.error("'" + name + "'",
                   "LENSMODEL_PINHOLE, _OPENCV4, _OPENCV5, _OPENCV8, _OPENCV12, _STEREOGRAPHIC or "
                   "_SPLINED_STEREOGRAPHIC",
                   "convert it to one of these with mrcal-convert-lensmodel");
}

std::vector<SE3> readPoses(const YamlNode& root) {
  for (const char* key : kPoseKeys) {
    const auto node = root.find(key);
    if (!node) continue;
    const std::vector<StatedNumber> rt = statedNumbers(*node, 6);
    return {{SO3::exp({rt[0].value, rt[1].value, rt[2].value}), {rt[3].value, rt[4].value, rt[5].value}}};
  }
  return {};
}

struct SplinedName {
  int across = 0;  // control points
  int down = 0;
  double fov_x_deg = 0;
};

SplinedName splinedName(const YamlNode& node) {
  const std::string name = node.text();
  SplinedName of;
  int order = 0;
  int length = 0;
  const int num_read = std::sscanf(name.c_str() + kSplined.size(), "order=%d_Nx=%d_Ny=%d_fov_x_deg=%lf%n",
                                   &order, &of.across, &of.down, &of.fov_x_deg, &length);
  constexpr int kMost = CorrectionGrid::kMaxCells + 3;
  const bool is_known = num_read == 4 && kSplined.size() + static_cast<std::size_t>(length) == name.size() &&
                        order == 3 && std::min(of.across, of.down) >= 4 &&
                        std::max(of.across, of.down) <= kMost && of.fov_x_deg > 0 && of.fov_x_deg < 360;
  if (!is_known) {
    throw node.error("'" + name + "'",
                     kSplined + "order=3_Nx=NX_Ny=NY_fov_x_deg=DEGREES, with 4 to " + std::to_string(kMost) +
                         " control points each way",
                     "convert it to one of these, or to a parametric model, with mrcal-convert-lensmodel");
  }
  return of;
}

// True if every pixel is displaced from one within the grid.
bool coversImage(const CorrectionField& field, ImageSize size) {
  const CorrectionGrid& grid = field.grid();
  const Eigen::Array2d end(grid.columns, grid.rows);
  constexpr int kSteps = 32;
  for (int j = 0; j <= kSteps; ++j) {
    for (int i = 0; i <= kSteps; ++i) {
      const auto from =
          field.undisplaced({i * size.width / double{kSteps} - 0.5, j * size.height / double{kSteps} - 0.5});
      if (!from) return false;
      const Eigen::Array2d cell = (*from - grid.origin_px).array() / grid.cell_px.array();
      if ((cell < 0).any() || (cell > end).any()) return false;
    }
  }
  return true;
}

// mrcal.c, mrcal_precompute_lensmodel_data: the segments between control points cover the field in x.
StatedCamera readSplined(const YamlNode& name, const YamlNode& intrinsics, ImageSize size) {
  const SplinedName of = splinedName(name);
  std::vector<double> numbers =
      intrinsics.numbers(4 + 2 * static_cast<std::size_t>(of.across) * static_cast<std::size_t>(of.down));
  const Eigen::Vector2d focal(numbers[0], numbers[1]);
  const Eigen::Vector2d center(numbers[2], numbers[3]);
  const double edge = 2 * std::tan(of.fov_x_deg * std::numbers::pi / 720);
  const double segment = 2 * edge / (of.across - 3);
  CorrectionGrid grid{.columns = of.across - 3, .rows = of.down - 3};
  grid.cell_px = segment * focal;
  grid.origin_px =
      center + grid.cell_px.cwiseProduct(Eigen::Vector2d(1 - 0.5 * (of.across - 1), 1 - 0.5 * (of.down - 1)));
  for (std::size_t i = 4; i < numbers.size(); ++i) numbers[i] *= focal[static_cast<Eigen::Index>(i % 2)];
  const std::array<StatedNumber, 5> lens = {{{numbers[0]}, {numbers[1]}, {numbers[2]}, {numbers[3]}, {0.5}}};
  StatedCamera camera = stateCamera(intrinsics.where(), kStereographic.model, lens, size);
  camera.camera = camera.camera.withCorrection(withPlace(intrinsics.where(), [&] {
    return std::make_shared<const CorrectionField>(
        CorrectionField::soundPart(grid, std::vector<double>(numbers.begin() + 4, numbers.end()), center));
  }));
  if (!coversImage(*camera.camera.correction(), size)) {
    camera.remarks.push_back(
        {.id = "assumed",
         .message =
             intrinsics.where() + ": the splines end or fold inside the image; pixels beyond are left out"});
  }
  return camera;
}

StatedCamera readLens(const YamlNode& root) {
  const char* const key = modelKey(root);
  const YamlNode name = root.at(key == nullptr ? kModelKeys[0] : key);
  const YamlNode intrinsics = root.at("intrinsics");
  const ImageSize size = readSize(root.at("imagersize"));
  if (name.text().starts_with(kSplined)) return readSplined(name, intrinsics, size);
  const LensLayout& lens = lensOf(name);
  const std::size_t count = words(lens.order).size();
  std::vector<StatedNumber> parameters = storageOrder(lens, statedNumbers(intrinsics, count));
  if (&lens == &kStereographic) parameters.back().value = 0.5;
  return stateCamera(intrinsics.where(), lens.model, parameters, size);
}

CameraSource read(const CameraDocument& document, const ReadOptions&) {
  const YamlNode& root = document.root();
  StatedCamera camera = readLens(root);
  remarkUnknownKeys(root, words(kNotCarried + kOtherKeys), camera);
  remarkNotCarried(root, words(kNotCarried), camera);
  CameraSource all{.cameras = {camera}};
  statePoses(all, [&root](std::vector<Remark>&) { return readPoses(root); });
  return all;
}

std::string write(std::span<const NamedCamera> cameras, const std::string&) {
  const NamedCamera& named = cameras.front();
  const LensLayout& lens = layoutOf(kLenses, named.camera.modelId());
  const SE3 pose = named.camera_from_rig.value_or(SE3());
  Eigen::Matrix<double, 6, 1> rt;
  rt << pose.rotation.log(), pose.translation;
  return fmt::format(
      "{{\n    'lensmodel':  '{}',\n\n    # intrinsics are {}\n    'intrinsics': {},\n\n"
      "    # extrinsics are rt_fromref\n    'extrinsics': {},\n\n    'imagersize': [{}, {}]\n}}\n",
      lens.name, lens.order, listText(listedOrder(lens, named.camera)), listText(rowMajor(rt)),
      named.image_size.width, named.image_size.height);
}

}  // namespace mrcal_format

const CameraFormat& mrcal() {
  using namespace mrcal_format;
  static const CameraFormat kFormat = {.id = "mrcal",
                                       .title = "mrcal camera model (.cameramodel)",
                                       .aliases = "cameramodel",
                                       .models = {"pinhole", "radtan", "rational", "thin_prism"},
                                       .poses = CameraFormat::Poses::kFromRig,
                                       .marks = {"lensmodel", "intrinsics", "imagersize"},
                                       .recognises = recognises,
                                       .read = read,
                                       .write = write};
  return kFormat;
}

}  // namespace alidade::detail::formats
