// SPDX-License-Identifier: MIT
// Each row cites the reader or writer that defines the format; the numbers of all are those of
// cv::projectPoints or cv::fisheye where nothing else is said.
#include <algorithm>
#include <array>
#include <cmath>
#include <string>
#include <utility>

#include "alidade/camera/same_lens.h"
#include "alidade/core/text.h"
#include "alidade/files/formats/small_format.h"

namespace alidade::detail {
namespace small_formats {

constexpr std::string_view kPinhole = "fx fy cx cy";
constexpr std::string_view kRadtan = "fx fy cx cy k1 k2 p1 p2 k3";
constexpr std::string_view kRadtan4 = "fx fy cx cy k1 k2 p1 p2";
constexpr std::string_view kFisheye = "fx fy cx cy k1 k2 k3 k4";

void tell(CameraSource& all, const char* id, const std::string& text) {
  if (!all.cameras.empty()) all.cameras.front().remarks.push_back({id, text});
}

template <class Rename>
void renameAll(CameraSource& all, const Rename& rename) {
  for (StatedCamera& camera : all.cameras) rename(camera.name);
  for (RefusedCamera& camera : all.refused) rename(camera.name);
}

// PhotonVision (photon-core, CameraCalibrationCoefficients.java); older files call the coefficients
// cameraExtrinsics.
constexpr std::array<SmallLens, 1> kPhotonVision = {
    {{"|LENSMODEL_OPENCV|LENSMODEL_OPENCV4|LENSMODEL_OPENCV5|LENSMODEL_OPENCV8", "opencv", kPinhole,
      "K=cameraIntrinsics L=distCoeffs|cameraExtrinsics"}}};

// Autoware's calibration_publisher. Its pose is that of the camera in the frame of the lidar.
constexpr std::array<SmallLens, 2> kAutoware = {
    {{"|plumb_bob|rational_polynomial", "opencv", kPinhole, "K=CameraMat L=DistCoeff"},
     {"equidistant|fisheye", "kannala_brandt", kFisheye, "K=CameraMat L=DistCoeff"}}};

// MC-Calib (src/McCalib.cpp, saveCamerasParams): distortion_type 0 is Brown's lens, 1 Kannala's. Poses are
// those of the cameras in the frame of the first one, in the unit of the board.
constexpr std::array<SmallLens, 2> kMcCalib = {
    {{"0", "opencv", kPinhole, "K=camera_matrix L=distortion_vector"},
     {"1", "kannala_brandt", kFisheye, "K=camera_matrix L=distortion_vector"}}};

// multical (multical/io/export_calib.py). "b_to_a" is the motion that maps points of camera a to camera b,
// because the poses are those of the board in each camera divided by those in camera a.
constexpr std::array<SmallLens, 1> kMultical = {
    {{"standard|rational|thin_prism|tilted", "opencv", kPinhole, "K=K L=dist"}}};

// EasyMocap's intri.yml (easymocap/mytools/camera_utils.py), perhaps with the poses of its extri.yml.
constexpr std::array<SmallLens, 1> kEasyMocap = {{{"", "opencv", kPinhole, "K=K_* L=dist_*|D_*"}}};

// OpenSfM (opensfm/io.py, opensfm/features.py: normalized_image_coordinates).
constexpr std::array<SmallLens, 6> kOpenSfm = {
    {{"perspective", "radtan", "f k1 k2", "focal k1 k2"},
     {"brown", "radtan", kRadtan, "focal_x focal_y c_x c_y k1 k2 p1 p2 k3"},
     {"radial", "radtan", "fx fy cx cy k1 k2", "focal_x focal_y c_x c_y k1 k2"},
     {"simple_radial", "radtan", "fx fy cx cy k1", "focal_x focal_y c_x c_y k1"},
     {"fisheye", "kannala_brandt", "f k1 k2", "focal k1 k2"},
     {"fisheye_opencv", "kannala_brandt", kFisheye, "focal_x focal_y c_x c_y k1 k2 k3 k4"}}};

// BoofCV (CalibrationIO.java). The first pixel covers 0 to 1 (its wiki, "Coordinate Systems").
constexpr std::array<SmallLens, 3> kBoofCv = {
    {{"pinhole", "pinhole", "fx fy 0 cx cy", "pinhole.fx pinhole.fy pinhole.skew pinhole.cx pinhole.cy"},
     {"pinhole_radial_tangential", "radtan", "fx fy 0 cx cy p1 p2 k1 k2 k3",
      "pinhole.fx pinhole.fy pinhole.skew pinhole.cx pinhole.cy radial_tangential.t1 radial_tangential.t2 "
      "L=radial_tangential.radial?"},
     {"omnidirectional_universal", "omni", "fx fy 0 cx cy xi p1 p2 k1 k2",
      "pinhole.fx pinhole.fy pinhole.skew pinhole.cx pinhole.cy mirror_offset radial_tangential.t1 "
      "radial_tangential.t2 L=radial_tangential.radial?"}}};

// Gyroflow's lens profiles (src/core/lens_profile.rs, stabilization/distortion_models).
constexpr std::array<SmallLens, 2> kGyroflow = {
    {{"|opencv_fisheye", "kannala_brandt", kFisheye,
      "K=fisheye_params.camera_matrix L=fisheye_params.distortion_coeffs"},
     {"opencv_standard", "opencv", kPinhole,
      "K=fisheye_params.camera_matrix L=fisheye_params.distortion_coeffs"}}};

// A digital lens bends the image once more; without "asymmetrical" Gyroflow ignores the stated centre.
void finishGyroflow(const YamlNode& root, const ReadOptions&, CameraSource& all) {
  if (all.cameras.empty()) return;
  if (const auto lens = root.find("digital_lens"); lens && !lens->isNull()) {
    all.refused.push_back(
        {.name = all.cameras.front().name,
         .number = 0,
         .reason = UnsupportedCamera(lens->error(
             "the digital lens '" + lens->text() + "', which bends the image once more",
             "a profile of the lens alone", "use a profile of the camera's linear or wide mode"))});
    all.cameras.clear();
    return;
  }
  for (const char* key : {"input_horizontal_stretch", "input_vertical_stretch"}) {
    const auto factor = root.find(key);
    if (!factor || factor->isNull() || factor->number() == 0 || factor->number() == 1) continue;
    tell(all, "not_carried",
         root.whereKey(key) + ": the camera belongs to images that were stretched by this factor");
  }
  const auto flag = root.find("asymmetrical");
  if (flag && flag->text() == "true") return;
  tell(all, "assumed",
       root.whereKey("fisheye_params") +
           ": the stated principal point is used; Gyroflow itself takes "
           "the image centre, because the profile is not asymmetrical");
}

// Caliscope (cameras/camera_array.py) and aniposelib (cameras.py).
constexpr std::array<SmallLens, 2> kToml = {{{"|false", "opencv", kPinhole, "K=matrix L=distortions"},
                                             {"true", "kannala_brandt", kFisheye, "K=matrix L=distortions"}}};

// SN*.conf of Stereolabs' cameras (zed-open-capture, examples/include/calibration.hpp; k4 to k6 as in
// CalibrationParameters::disto of the ZED SDK).
constexpr std::array<SmallLens, 1> kZed = {
    {{"", "opencv", kPinhole, "fx fy cx cy k1 k2 p1? p2? k3? k4? k5? k6?"}}};

struct ZedMode {
  std::string_view end;  // of a section's name
  ImageSize size;
};
constexpr std::array<ZedMode, 6> kZedModes = {{{"_2K", {2208, 1242}},
                                               {"_FHD", {1920, 1080}},
                                               {"_HD", {1280, 720}},
                                               {"_VGA", {672, 376}},
                                               {"_FHD1200", {1920, 1200}},
                                               {"_SVGA", {960, 600}}}};

// Sections are named after the side and the mode, which says the image size.
void finishZed(const YamlNode&, const ReadOptions& options, CameraSource& all) {
  for (StatedCamera& camera : all.cameras) {
    for (const ZedMode& mode : kZedModes)
      if (camera.name.ends_with(mode.end)) camera.image_size = mode.size;
  }
  const auto isOther = [&options](const StatedCamera& camera) {
    return camera.image_size != options.image_size;
  };
  if (!options.image_size || std::ranges::all_of(all.cameras, isOther)) return;
  std::erase_if(all.cameras, isOther);
  for (std::size_t i = 0; i < all.cameras.size(); ++i) all.cameras[i].number = i;
}

// vikit (rpg_vikit, vikit_common: pinhole_camera, atan_camera; rpg_svo_pro, vikit_cameras; FAST-LIVO). The
// numbers of an ATAN camera are relative to the image size.
constexpr std::array<SmallLens, 3> kVikit = {
    {{"Pinhole|PinholeRadialTangential|PinholeNoDistortion", "radtan", kRadtan,
      "cam_fx cam_fy cam_cx cam_cy cam_d0? cam_d1? cam_d2? cam_d3? cam_d4?"},
     {"ATAN|PinholeAtan", "fov", "fx fy cx cy w", "cam_fx cam_fy cam_cx cam_cy cam_d0"},
     {"EquidistantCamera|PinholeEquidistant", "kannala_brandt", kFisheye,
      "cam_fx cam_fy cam_cx cam_cy k1|cam_d0 k2|cam_d1 k3|cam_d2 k4|cam_d3"}}};

void finishVikit(const YamlNode& root, const ReadOptions&, CameraSource& all) {
  const auto scale = root.find("scale");
  if (!scale || scale->number() == 1) return;
  tell(all, "not_carried",
       root.whereKey("scale") +
           ": the camera that was read is that of the stated size; the program "
           "reduces its images by this factor");
}

// ncamera files of SVO Pro, maplab and aslam_cv2 (aslam_cv_cameras/src/camera.cc).
constexpr std::string_view kAslamPaths = "L=camera.intrinsics L=camera.distortion.parameters";
constexpr std::array<SmallLens, 6> kAslam = {
    {{"pinhole+radial-tangential", "radtan", kRadtan4, kAslamPaths},
     {"pinhole+equidistant", "kannala_brandt", kFisheye, kAslamPaths},
     {"pinhole+fisheye", "fov", "fx fy cx cy w", kAslamPaths},
     {"pinhole+none|pinhole", "pinhole", kPinhole, "L=camera.intrinsics"},
     {"unified-projection+radial-tangential", "omni", "xi fx fy cx cy k1 k2 p1 p2", kAslamPaths},
     {"unified-projection+none|unified-projection", "omni", "xi fx fy cx cy", "L=camera.intrinsics"}}};

// KITTI's calib_cam_to_cam.txt and the calib.txt of its odometry (devkit, readme.txt; Geiger et al. 2013,
// section IV). The first has the cameras of the original images; P of the second projects from the frame of
// camera 0.
constexpr std::array<SmallLens, 1> kKitti = {{{"", "opencv", kPinhole, "K=K_* L=D_*"}}};
constexpr std::array<SmallLens, 1> kKittiOdometry = {{{"", "pinhole", kPinhole, "P=P*"}}};

// Azure Kinect's raw calibration (k4a, src/transformation/mode_specific_calibration.c: numbers relative to
// the size, from the corner of the first pixel; intrinsic_transformation.c; extrinsic_transformation.c). The
// centre of distortion is not used by this lens.
constexpr std::array<SmallLens, 1> kAzureKinect = {
    {{"CALIBRATION_LensDistortionModelBrownConrady", "rational", "cx cy fx fy k1 k2 k3 k4 k5 k6 0 0 p2 p1",
      "L=Intrinsics.ModelParameters"}}};

// "D0" and "PV0" instead of CALIBRATION_CameraLocationD0.
void finishAzureKinect(const YamlNode&, const ReadOptions&, CameraSource& all) {
  renameAll(all, [start = std::string_view("CALIBRATION_CameraLocation")](std::string& name) {
    if (name.starts_with(start)) name.erase(0, start.size());
  });
}

// Intrinsics of RealSense cameras as pyrealsense2 names them (librealsense, src/rs.cpp,
// rs2_project_point_to_pixel). The modified lens equals a pinhole if all coefficients are zero.
constexpr std::string_view kRealSensePaths = "fx fy ppx ppy L=coeffs";
constexpr std::array<SmallLens, 6> kRealSense = {
    {{"distortion.none|none|None", "pinhole", "fx fy cx cy 0", kRealSensePaths},
     {"distortion.inverse_brown_conrady|inverse_brown_conrady|Inverse Brown Conrady", "inverse_brown",
      kRadtan, kRealSensePaths},
     {"distortion.modified_brown_conrady|modified_brown_conrady|Modified Brown Conrady", "pinhole",
      "fx fy cx cy 0", kRealSensePaths},
     {"distortion.brown_conrady|brown_conrady|Brown Conrady", "radtan", kRadtan, kRealSensePaths},
     {"distortion.kannala_brandt4|kannala_brandt4|Kannala Brandt4", "kannala_brandt",
      "fx fy cx cy k1 k2 k3 k4 0", kRealSensePaths},
     {"distortion.ftheta|ftheta|F-Theta", "fov", "fx fy cx cy w 0", kRealSensePaths}}};

// DSO's camera.txt, also of the TUM monoVO dataset (src/util/Undistort.cpp); see notations.h.
constexpr std::array<SmallLens, 4> kDso = {
    {{"RadTan", "radtan", kRadtan4, "L=numbers"},
     {"KannalaBrandt|EquiDistant", "kannala_brandt", kFisheye, "L=numbers"},
     {"FOV", "fov", "fx fy cx cy w", "L=numbers"},
     {"Pinhole", "pinhole", "fx fy cx cy 0", "L=numbers"}}};

// Metashape (its user manual, "Camera models"; also the sensors in its cameras.xml): f, b1, b2, cx, cy from
// the image's centre, k1 to k4, and p1 and p2, which are p2 and p1 here. The centre of the first pixel is
// (0.5, 0.5).
void convertMetashape(std::vector<StatedNumber>& listed) {
  listed.resize(11);
  const double f = listed[0].value;
  const double fx = f + listed[1].value;
  listed[1] = {f};
  listed[0] = {fx};
  listed.push_back({listed[2].value / fx});
  listed.erase(listed.begin() + 2);
}
constexpr std::string_view kMetashapePaths = "f b1? b2? cx? cy? k1? k2? k3? k4? p1? p2?";
constexpr std::array<SmallLens, 2> kMetashape = {
    {{"frame", "brown", "fx fy cx cy k1 k2 k3 k4 p2 p1 skew", kMetashapePaths, convertMetashape},
     {"fisheye", "thin_prism_fisheye", "fx fy cx cy k1 k2 k3 k4 p2 p1 0", kMetashapePaths,
      convertMetashape}}};

// The usual models where they are the same lens. Cameras are named after the class of their calibration.
void finishMetashape(const YamlNode& root, const ReadOptions&, CameraSource& all) {
  for (StatedCamera& camera : all.cameras) {
    if (camera.name == "initial") {
      camera.remarks.push_back({"assumed", root.where() + ": calibration " + std::to_string(camera.number) +
                                               " is of class 'initial': its numbers are those before the "
                                               "adjustment of the photographs"});
    }
    for (const char* usual : {"radtan", "kannala_brandt"}) {
      if (const auto same = sameLensParameters(camera.camera, usual))
        camera.camera = AnyCamera::make(usual, *same);
    }
  }
  renameAll(all, [](std::string& name) { name.clear(); });
}

// WoodScape (its scripts/calibration/projection.py): r = k1 theta + ... + k4 theta^4 in pixels, stretched in
// y; the principal point is 0.5 size + offset - 0.5.
void convertWoodScape(std::vector<StatedNumber>& listed) {
  const std::vector<StatedNumber> k(listed.begin() + 3, listed.end());
  listed = {k[0], {k[0].value * listed[0].value}, listed[1], listed[2]};
  for (std::size_t i = 1; i < k.size(); ++i) listed.push_back({k[i].value / k[0].value});
}
constexpr std::array<SmallLens, 1> kWoodScape = {
    {{"radial_poly", "ftheta", "fx fy cx cy k1 k2 k3",
      "intrinsic.aspect_ratio intrinsic.cx_offset intrinsic.cy_offset intrinsic.k1 intrinsic.k2 intrinsic.k3 "
      "intrinsic.k4",
      convertWoodScape}}};

// NVIDIA DriveWorks (rig.json; FTheta camera model): a polynomial without constant term, from pixels to the
// angle or back, then [c d; e 1]. Which point of the first pixel is (0, 0) is not documented.
void convertDriveWorks(std::vector<StatedNumber>& listed, bool is_to_angle) {
  const double c = listed[2].value == 0 ? 1 : listed[2].value;
  const std::vector<StatedNumber> poly(listed.begin() + 5, listed.end());
  if (poly.size() < 2) return;  // has too few numbers, which is reported
  const double focal = is_to_angle ? 1 / poly[1].value : poly[1].value;
  std::vector<StatedNumber> numbers = {{c * focal}, {focal},   listed[0], listed[1],
                                       listed[3],   listed[4], poly[0]};
  for (std::size_t i = 2; i < poly.size(); ++i)
    numbers.push_back({poly[i].value * (is_to_angle ? std::pow(focal, static_cast<double>(i)) : 1 / focal)});
  listed = std::move(numbers);
  listed.resize(std::max<std::size_t>(listed.size(), 12));
}
constexpr std::string_view kDriveWorksOrder = "fx fy cx cy 0 0 0 k1 k2 k3 k4 k5";
constexpr std::array<SmallLens, 2> kDriveWorks = {
    {{"ftheta|ftheta+pixeldistance-to-angle", "ftheta_inverse", kDriveWorksOrder,
      "properties.cx properties.cy properties.linear-c? properties.linear-d? properties.linear-e? "
      "L=properties.polynomial|properties.bw-poly",
      [](std::vector<StatedNumber>& listed) { convertDriveWorks(listed, true); }},
     {"ftheta+angle-to-pixeldistance", "ftheta", kDriveWorksOrder,
      "properties.cx properties.cy properties.linear-c? properties.linear-d? properties.linear-e? "
      "L=properties.polynomial|properties.fw-poly",
      [](std::vector<StatedNumber>& listed) { convertDriveWorks(listed, false); }}}};

void finishDriveWorks(const YamlNode& root, const ReadOptions&, CameraSource& all) {
  tell(all, "assumed", root.whereKey("rig") + ": pixel (0, 0) is taken as the centre of the first pixel");
}

// Project Aria's online_calibration.jsonl, an estimate a line, and its device calibration (projectaria_tools,
// core/calibration). Sizes are not stated.
constexpr std::array<SmallLens, 3> kAria = {
    {{"FisheyeRadTanThinPrism", "fisheye624", "f cx cy k0 k1 k2 k3 k4 k5 p0 p1 s0 s1 s2 s3",
      "L=Projection.Params"},
     {"KannalaBrandtK3", "kannala_brandt", kFisheye, "L=Projection.Params"},
     {"Linear", "pinhole", kPinhole, "L=Projection.Params"}}};

void finishAria(const YamlNode& root, const ReadOptions&, CameraSource& all) {
  if (root.isSequence())
    tell(all, "assumed",
         root.where() + ": the first of " + std::to_string(root.node().size()) + " estimates was read");
}

// The EEPROM of Luxonis' OAK cameras (depthai-shared, CameraInfo and CameraModel; eepromToJsonFile()): pairs
// of a socket and its camera.
constexpr std::array<SmallLens, 2> kOak = {
    {{"0", "opencv", kPinhole, "K=intrinsicMatrix L=distortionCoeff"},
     {"1", "kannala_brandt", "fx fy cx cy k1 k2 k3 k4 0", "K=intrinsicMatrix L=distortionCoeff"}}};

// "CAM_A" instead of the number of its socket.
void finishOak(const YamlNode&, const ReadOptions&, CameraSource& all) {
  renameAll(all, [](std::string& name) {
    const auto socket = parseInt(name);
    if (socket && *socket >= 0 && *socket < 26) name = std::string("CAM_") + static_cast<char>('A' + *socket);
  });
}

// Bouguet's Calibration Toolbox for MATLAB (Calib_Results.mat; its parameters' page): 0 is the centre of the
// first pixel, kc has k1 k2 p1 p2 k3.
constexpr std::array<SmallLens, 1> kBouguet = {
    {{"", "radtan", "fx fy cx cy 0 k1 k2 p1 p2 k3", "L=fc L=cc alpha_c? L=kc"}}};

// A camera as people write it down for cv::projectPoints, without a program that defines it.
constexpr std::string_view kListed =
    "fx fy cx cy L=dist|distortion|dist_coeff|dist_coeffs|distortion_coeffs|distCoeffs|distortion_coefficients|coeffs|D|d";
constexpr std::string_view kBareNames = "|pinhole|perspective";
constexpr std::string_view kOrdinaryNames =
    "opencv|OPENCV|radtan|plumb_bob|brown_conrady|rational_polynomial|pinhole+opencv|pinhole+radtan|"
    "pinhole+plumb_bob|pinhole+brown_conrady|pinhole+rational_polynomial";
constexpr std::string_view kFisheyeNames =
    "fisheye|opencv_fisheye|OPENCV_FISHEYE|equidistant|kannala_brandt|kb4|pinhole+fisheye|pinhole+equidistant";
constexpr std::array<SmallLens, 4> kFlat = {{{kBareNames, "opencv?", kPinhole, kListed},
                                             {"none|pinhole+none", "pinhole", "fx fy cx cy 0", kListed},
                                             {kOrdinaryNames, "opencv", kPinhole, kListed},
                                             {kFisheyeNames, "kannala_brandt", kFisheye, kListed}}};
constexpr std::string_view kKeys = "fx fy cx cy k1 k2 p1 p2 k3? k4? k5? k6?";
constexpr std::array<SmallLens, 3> kFlatKeys = {
    {{kBareNames, "opencv", kPinhole, kKeys},
     {kOrdinaryNames, "opencv", kPinhole, kKeys},
     {kFisheyeNames, "kannala_brandt", kFisheye, "fx fy cx cy k1 k2 k3 k4"}}};
constexpr std::string_view kFlatSize = "width|image_width|w? height|image_height|h?";
constexpr std::string_view kFlatModel = "model|camera_model distortion_model";

const std::array kRows = {
    SmallFormat{.id = "photonvision",
                .title = "PhotonVision calibration (JSON)",
                .marks = "cameraIntrinsics.data distCoeffs|cameraExtrinsics",
                .size = "resolution.width resolution.height",
                .model = "lensmodel",
                .lenses = kPhotonVision,
                .known = "calobjectWarp calobjectSize calobjectSpacing observations"},
    SmallFormat{.id = "autoware",
                .title = "Autoware calibration (YAML)",
                .marks = "CameraMat DistCoeff",
                .size = "ImageSize",
                .model = "DistModel",
                .lenses = kAutoware,
                .known = "ReprojectionError",
                .not_carried = "CameraExtrinsicMat"},
    SmallFormat{.id = "mc_calib",
                .title = "MC-Calib cameras (YAML)",
                .marks = "camera_matrix distortion_vector distortion_type",
                .cameras = "camera_#",
                .size = "img_width img_height",
                .model = "distortion_type",
                .lenses = kMcCalib,
                .pose = "camera_pose_matrix",
                .is_rig_from_camera = true,
                .known = "nb_camera camera_group"},
    SmallFormat{.id = "multical",
                .title = "multical calibration (JSON)",
                .marks = "K dist image_size model",
                .cameras = "cameras.*",
                .size = "image_size",
                .model = "model",
                .lenses = kMultical,
                .pose = "/camera_poses.*.R|/camera_poses.*_to_~.R /camera_poses.*.T|/camera_poses.*_to_~.T",
                .known = "image_sets"},
    SmallFormat{.id = "easymocap",
                .title = "EasyMocap intri.yml",
                .marks = "/names K_*",
                .cameras = "K_*",
                .is_flat = true,
                .size = "W_*? H_*?",
                .lenses = kEasyMocap,
                .pose = "Rot_*|R_* T_*",
                .known = "names"},
    SmallFormat{.id = "opensfm",
                .title = "OpenSfM camera_models.json",
                .marks = "projection_type width height",
                .cameras = "* cameras.*",
                .size = "width height",
                .model = "projection_type",
                .lenses = kOpenSfm,
                .unit = SmallUnit::kLongSide,
                .known = "focal_prior k1_prior k2_prior"},
    SmallFormat{.id = "boofcv",
                .title = "BoofCV intrinsics (YAML)",
                .marks = "model pinhole.fx pinhole.skew",
                .size = "pinhole.width pinhole.height",
                .model = "model",
                .lenses = kBoofCv,
                .origin = 0.5,
                .known = "version"},
    SmallFormat{
        .id = "gyroflow",
        .title = "Gyroflow lens profile (JSON)",
        .marks = "calib_dimension.w fisheye_params.camera_matrix",
        .name = "name",
        .size = "calib_dimension.w calib_dimension.h",
        .model = "distortion_model",
        .lenses = kGyroflow,
        .known =
            "note calibrated_by camera_brand camera_model lens_model camera_setting orig_dimension "
            "output_dimension frame_readout_time frame_readout_direction gyro_lpf num_images fps official "
            "asymmetrical identifier calibrator_version date compatible_settings sync_settings "
            "digital_lens focal_length crop_factor global_shutter use_opencv_fisheye "
            "is_superview distortion_model_id digital_lens_params use_opencv_standard calib_params input_horizontal_stretch input_vertical_stretch",
        .not_carried = "crop interpolations",
        .finish = finishGyroflow},
    SmallFormat{.id = "caliscope",
                .title = "Caliscope and aniposelib (TOML)",
                .marks = "matrix distortions",
                .cameras = "cameras.* cam_#",
                .name = "name",
                .size = "size?",
                .model = "fisheye",
                .lenses = kToml,
                .pose = "rotation translation",
                .known = "metadata cam_id port error exposure grid_count ignore verified_resolutions",
                .not_carried = "rotation_count"},
    SmallFormat{.id = "zed",
                .title = "ZED SN*.conf (INI)",
                .marks = "fx fy cx cy k1 k2",
                .cameras = "LEFT_CAM_* RIGHT_CAM_*",
                .is_size_named = true,
                .lenses = kZed,
                .known = "MISC",
                .not_carried = "STEREO",
                .finish = finishZed},
    SmallFormat{.id = "vikit",
                .title = "vikit camera (YAML)",
                .marks = "cam_model cam_fx",
                .size = "cam_width cam_height",
                .model = "cam_model",
                .lenses = kVikit,
                .unit = SmallUnit::kSidesIfBelow1,
                .known = "scale cam_name",
                .not_carried = "Rcl Pcl",
                .finish = finishVikit},
    SmallFormat{.id = "aslam",
                .title = "SVO and maplab cameras (YAML)",
                .marks = "camera.image_width camera.intrinsics.data camera.type",
                .cameras = "cameras.*",
                .name = "camera.label",
                .size = "camera.image_width camera.image_height",
                .model = "camera.type camera.distortion.type",
                .lenses = kAslam,
                .pose = "T_B_C",
                .is_rig_from_camera = true,
                .known = "label id imu_params imu_initialization"},
    SmallFormat{.id = "kitti",
                .title = "KITTI calib_cam_to_cam.txt",
                .marks = "S_* K_* D_*",
                .cameras = "K_#",
                .is_flat = true,
                .size = "S_*",
                .lenses = kKitti,
                .pose = "R_* T_*",
                .known = "calib_time corner_dist P_rect_#"},
    SmallFormat{.id = "kitti_odometry",
                .title = "KITTI odometry calib.txt",
                .marks = "/P0 /P1",
                .cameras = "P#",
                .is_flat = true,
                .lenses = kKittiOdometry,
                .pose = "P=P*",
                .known = "calib_time R0_rect R_rect",
                .not_carried = "Tr Tr_velo_to_cam Tr_imu_to_velo Tr_velo_cam"},
    SmallFormat{.id = "azure_kinect",
                .title = "Azure Kinect calibration (JSON)",
                .marks = "Intrinsics.ModelParameters SensorWidth",
                .cameras = "CalibrationInformation.Cameras.*",
                .name = "Location",
                .size = "SensorWidth SensorHeight",
                .model = "Intrinsics.ModelType",
                .lenses = kAzureKinect,
                .unit = SmallUnit::kSides,
                .pose = "Rt.Rotation Rt.Translation",
                .known = "Purpose MetricRadius Shutter ThermalAdjustmentParams Metadata",
                .finish = finishAzureKinect},
    SmallFormat{.id = "realsense",
                .title = "RealSense intrinsics (JSON)",
                .marks = "fx fy ppx ppy coeffs model",
                .cameras = ". *",
                .size = "width height",
                .model = "model",
                .lenses = kRealSense},
    SmallFormat{.id = "dso",
                .title = "DSO camera.txt",
                .marks = "dso_model numbers size",
                .size = "size",
                .model = "dso_model",
                .lenses = kDso,
                .unit = SmallUnit::kSidesIfBelow1},
    SmallFormat{.id = "metashape",
                .title = "Agisoft Metashape calibration (XML)",
                .marks = "f projection|type width|resolution.width",
                .cameras = "calibration+ document.chunk+.sensors.sensor+.calibration+",
                .preferred = "class adjusted",
                .name = "class",
                .size = "width|resolution.width height|resolution.height",
                .model = "projection|type",
                .lenses = kMetashape,
                .unit = SmallUnit::kFromCentre,
                .zero = "p3 p4",
                .known = "date covariance document",
                .finish = finishMetashape},
    SmallFormat{.id = "woodscape",
                .title = "WoodScape calibration (JSON)",
                .marks = "intrinsic.model intrinsic.cx_offset",
                .name = "name",
                .size = "intrinsic.width intrinsic.height",
                .model = "intrinsic.model",
                .lenses = kWoodScape,
                .unit = SmallUnit::kFromCentre,
                .pose = "extrinsic.quaternion extrinsic.translation",
                .is_rig_from_camera = true},
    SmallFormat{.id = "driveworks",
                .title = "NVIDIA DriveWorks rig (JSON)",
                .marks = "properties.Model|properties.model properties.cx properties.width",
                .cameras = "rig.sensors.*",
                .name = "name",
                .size = "properties.width properties.height",
                .model = "properties.Model|properties.model properties.polynomial-type",
                .lenses = kDriveWorks,
                .known = "protocol parameter properties.fw-poly properties.bw-poly",
                .not_carried = "nominalSensor2Rig_FLU correction_sensor_R_FLU correction_rig_T",
                .finish = finishDriveWorks},
    SmallFormat{.id = "aria",
                .title = "Project Aria calibration (JSON lines)",
                .marks = "Projection.Name Projection.Params T_Device_Camera",
                .cameras = "CameraCalibrations.* 0.CameraCalibrations.*",
                .name = "Label",
                .model = "Projection.Name",
                .lenses = kAria,
                .known = "SerialNumber Calibrated",
                .not_carried = "T_Device_Camera",
                .finish = finishAria},
    SmallFormat{
        .id = "oak",
        .title = "Luxonis OAK calibration (JSON)",
        .marks = "intrinsicMatrix distortionCoeff cameraType",
        .cameras = "cameraData.*.*",
        .size = "width height",
        .model = "cameraType",
        .lenses = kOak,
        .known =
            "lensPosition specHfovDeg batchName batchTime boardConf boardName boardRev boardCustom boardOptions "
            "hardwareConf deviceName productName stereoEnableDistortionCorrection version "
            "miscellaneousData",
        .not_carried = "extrinsics imuExtrinsics stereoRectificationData housingExtrinsics "
                       "verticalCameraSocket",
        .finish = finishOak},
    SmallFormat{.id = "bouguet",
                .title = "Bouguet's Calib_Results.mat",
                .marks = "fc cc kc",
                .size = "nx? ny?",
                .lenses = kBouguet,
                .known = "*"},
    SmallFormat{
        .id = "flat",
        .title = "fx, fy, cx, cy and a list of coefficients",
        .marks =
            "fx fy cx cy !ppx !/alidade_camera "
            "dist|distortion|dist_coeff|dist_coeffs|distortion_coeffs|distCoeffs|distortion_coefficients|coeffs|D|d",
        .cameras = ". * cameras.*",
        .name = "name",
        .size = kFlatSize,
        .model = kFlatModel,
        .lenses = kFlat,
        .zero = "skew xi k1 k2 k3 k4 k5 k6 p1 p2"},
    SmallFormat{.id = "flat_keys",
                .title = "fx, fy, cx, cy, k1, k2, p1, p2 and perhaps k3 to k6",
                .marks = "fx fy cx cy k1 k2 p1 p2 !/alidade_camera",
                .name = "name",
                .size = kFlatSize,
                .model = kFlatModel,
                .lenses = kFlatKeys,
                .zero = "skew xi"}};

}  // namespace small_formats

std::span<const SmallFormat> smallFormats() {
  return small_formats::kRows;
}

}  // namespace alidade::detail
