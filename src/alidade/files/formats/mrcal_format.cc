// SPDX-License-Identifier: MIT
// mrcal's .cameramodel: a Python literal that is also valid YAML (mrcal's documentation, "cameramodel: the
// camera model file format" and "lens models"; cameramodel.py names the keys of older files). Intrinsics: fx,
// fy, cx, cy, then OpenCV's coefficients. Pixel (0, 0) is a pixel's centre.
#include <array>
#include <string>

#include <fmt/format.h>

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

constexpr std::array kModelKeys = {"lensmodel", "lens_model", "distortion_model"};  // of new and of old files
const std::string kNotCarried = "valid_intrinsics_region ";
// Rotation vector and translation, camera from reference.
constexpr std::array kPoseKeys = {"extrinsics", "rt_cam_ref"};
const std::string kOtherKeys =
    "extrinsics rt_cam_ref lensmodel lens_model distortion_model intrinsics imagersize icam_intrinsics "
    "icam_intrinsics_optimization_inputs optimization_inputs";

const char* modelKey(const CameraDocument& document) {
  for (const char* key : kModelKeys) {
    if (document.has(key)) return key;
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
                   "LENSMODEL_PINHOLE, _OPENCV4, _OPENCV5, _OPENCV8, _OPENCV12 or _STEREOGRAPHIC",
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

StatedCameras read(const CameraDocument& document, const ReadOptions&) {
  const YamlNode& root = document.root();
  const LensLayout& lens = lensOf(root.at(modelKey(document)));
  const std::size_t count = words(lens.order).size();
  std::vector<StatedNumber> parameters = storageOrder(lens, statedNumbers(root.at("intrinsics"), count));
  if (&lens == &kStereographic) parameters.back().value = 0.5;
  StatedCamera camera =
      stateCamera(root.at("intrinsics").where(), "", lens.model, parameters, readSize(root.at("imagersize")));
  remarkUnknownKeys(root, words(kNotCarried + kOtherKeys), camera);
  remarkNotCarried(root, words(kNotCarried), camera);
  StatedCameras all{.cameras = {camera}};
  statePoses(all, [&root](std::vector<Remark>&) { return readPoses(root); });
  return all;
}

std::string write(std::span<const NamedCamera> cameras) {
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
                                       .models = {"pinhole", "radtan", "rational", "thin_prism"},
                                       .poses = CameraFormat::Poses::kFromRig,
                                       .marks = {"lensmodel", "intrinsics", "imagersize"},
                                       .recognises = recognises,
                                       .read = read,
                                       .write = write};
  return kFormat;
}

}  // namespace alidade::detail::formats
