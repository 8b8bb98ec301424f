// SPDX-License-Identifier: MIT
#include "alidade/report/data/rig_data.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <optional>

#include <nlohmann/json.hpp>

#include "alidade/camera/triangulation.h"
#include "alidade/core/diagnosis.h"
#include "alidade/core/mapped.h"
#include "alidade/report/data/json_node.h"
#include "alidade/target/board_spec.h"

namespace alidade {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;

constexpr int kMostItems = 10'000'000;

std::size_t readIndex(const JsonNode& node, std::size_t count) {
  return static_cast<std::size_t>(node.whole(0, static_cast<int>(count) - 1));
}

double lengthOf(const JsonNode& node) {
  node.requireSize(3);
  return Vector3d(node.at(0).number(), node.at(1).number(), node.at(2).number()).norm();
}

ReportedRigCamera readRigCamera(const JsonNode& node) {
  ReportedRigCamera camera{
      .name = node["name"].text(), .camera = readCamera(node), .size = readSize(node["image_size"])};
  camera.camera_from_rig = readPose(node["camera_from_rig"]);
  camera.rotation_std_rad = lengthOf(node["rotation_std_rad"]);
  camera.distance_std_m = node["distance_std_m"].number();
  camera.rms_px = node["rms_px"].number();
  camera.alone_rms_px = node["alone_rms_px"].number();
  camera.transfer_px = node["transfer_px"].number();
  if (node.has("accuracy")) camera.accuracy = readAccuracy(node["accuracy"]);
  return camera;
}

ReportedView readRigView(const JsonNode& node, const ReportedRig& rig) {
  ReportedView view;
  view.camera = readIndex(node["camera"], rig.cameras.size());
  view.placement = readIndex(node["placement"], rig.placements.size());
  view.image = node["image"].text();
  view.rms_px = node["rms_px"].number();
  const Board& board = rig.boards[rig.placements[view.placement].board];
  view.corners = node["corners"].list([&](const JsonNode& corner) { return readCorner(corner, board); });
  return view;
}

}  // namespace

CalibrationEvidence cameraData(const ReportedRig& rig, std::size_t camera) {
  const ReportedRigCamera& of = rig.cameras[camera];
  CalibrationEvidence data{
      ReportData{.camera = of.camera, .size = of.size, .tolerance_px = rig.tolerance_px}};
  data.accuracy = of.accuracy;
  data.rms_px = of.rms_px;
  std::vector<std::vector<Vector2d>> pixels;
  for (const ReportedView& view : rig.views) {
    if (view.camera < camera) ++data.first_view;
    if (view.camera != camera) continue;
    data.views.push_back(view);
    pixels.push_back(mapped(view.corners, &CornerError::pixel));
  }
  data.coverage = imageCoverage(of.camera, of.size, pixels);
  return data;
}

bool isRigEvidence(const nlohmann::json& evidence) {
  return evidence.is_object() && evidence.value("kind", nlohmann::json()) == "rig";
}

ReportedRig readRig(const nlohmann::json& evidence, const std::string& file) {
  const JsonNode root(evidence, file);
  ReportedRig rig{.verdict = readVerdict(root["verdict"]), .tolerance_px = root["tolerance_px"].finite()};
  rig.rms_px = root["rms_px"].number();
  rig.holdout_rms_px = root["holdout_rms_px"].number();
  rig.num_linked = root["num_linked"].whole(0, kMostItems);
  rig.cameras = root["cameras"].list(readRigCamera);
  if (rig.cameras.empty()) root["cameras"].refuse("at least one camera");
  rig.boards = root["boards"].list(
      [](const JsonNode& node) { return node.made([&] { return parseBoardSpec(node.text()); }); });
  rig.frames = root["frames"].list(textOf);
  rig.placements = root["placements"].list([&](const JsonNode& node) {
    return ReportedPlacement{.frame = readIndex(node["frame"], rig.frames.size()),
                             .board = readIndex(node["board"], rig.boards.size()),
                             .rig_from_board = readPose(node["rig_from_board"])};
  });
  rig.views = root["views"].list([&](const JsonNode& node) { return readRigView(node, rig); });
  rig.findings = readFindings(root["diagnoses"]);
  sortDiagnoses(rig.findings);
  rig.origin = readOrigin(root);
  return rig;
}

std::vector<EpipolarPair> epipolarPairs(const ReportedRig& rig) {
  // Views by placement, then by camera.
  std::map<std::size_t, std::vector<const ReportedView*>> by_placement;
  for (const ReportedView& view : rig.views) by_placement[view.placement].push_back(&view);
  const auto mounted = mapped(rig.cameras, [](const ReportedRigCamera& camera) {
    return MountedCamera{.name = camera.name,
                         .camera = camera.camera,
                         .image_size = camera.size,
                         .camera_from_rig = camera.camera_from_rig};
  });
  std::map<std::pair<std::size_t, std::size_t>, std::map<std::size_t, SquareSum>> sums;
  for (auto& [placement, views] : by_placement) {
    std::ranges::stable_sort(views, {}, &ReportedView::camera);
    for (std::size_t i = 0; i < views.size(); ++i) {
      std::map<int, Vector2d> pixel_of;
      for (const CornerError& corner : views[i]->corners) pixel_of[corner.id] = corner.pixel;
      for (std::size_t k = i + 1; k < views.size(); ++k) {
        const std::size_t first = views[i]->camera;
        const std::size_t second = views[k]->camera;
        if (first == second) continue;
        SquareSum& sum = sums[{first, second}][rig.placements[placement].frame];
        for (const CornerError& corner : views[k]->corners) {
          const auto other = pixel_of.find(corner.id);
          if (other == pixel_of.end()) continue;
          const auto distance =
              epipolarDistance(mounted[first], mounted[second], other->second, corner.pixel);
          if (!distance) continue;
          sum.sum += *distance * *distance;
          ++sum.count;
        }
      }
    }
  }
  std::vector<EpipolarPair> pairs;
  for (const auto& [cameras, frames] : sums) {
    EpipolarPair pair{.first = cameras.first, .second = cameras.second};
    SquareSum all;
    for (const auto& [frame, of_frame] : frames) {
      if (of_frame.count == 0) continue;
      pair.by_frame.emplace_back(frame, of_frame.rms());
      all.sum += of_frame.sum;
      all.count += of_frame.count;
    }
    if (all.count == 0) continue;
    pair.num_corners = all.count;
    pair.rms_px = all.rms();
    pairs.push_back(pair);
  }
  return pairs;
}

}  // namespace alidade
