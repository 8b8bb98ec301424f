// SPDX-License-Identifier: MIT
#include "alidade/rig/rig_stages.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <optional>
#include <utility>

#include "alidade/camera/any_camera.h"
#include "alidade/core/median.h"

namespace alidade {
namespace {

constexpr int kPose = 6;
constexpr std::size_t kFewest = 3;  // views on each side of a motion

// A view of a body that a second camera saw at the same time.
struct CommonView {
  std::size_t view = 0;
  std::size_t frame = 0;
  bool is_linked = true;
  SE3 rig_from_rig = {};  // from the camera's pose in the fit to its pose by this view, in the rig's frame
};

// The common views of each camera, in the order of frames.
std::vector<std::vector<CommonView>> commonViews(const JointViews& views, const JointFit& joint) {
  std::map<std::pair<std::size_t, std::size_t>, std::vector<std::size_t>> of_body;  // by frame and body
  for (std::size_t v = 0; v < views.poses.size(); ++v)
    of_body[{views.poses[v].frame, views.body_of[views.poses[v].board]}].push_back(v);
  const auto isLinked = [&](std::size_t v) { return !std::ranges::binary_search(joint.unlinked, v); };
  std::vector<std::vector<CommonView>> common(views.sigma_px.size());
  for (const auto& [place, of_place] : of_body) {
    for (const std::size_t v : of_place) {
      // Prefer a view that agrees with the rig and has many corners.
      std::optional<std::size_t> other;
      const auto worth = [&](std::size_t w) {
        return std::pair(isLinked(w), views.poses[w].view->corners.size());
      };
      for (const std::size_t w : of_place) {
        if (w != v && (!other || worth(w) > worth(*other))) other = w;
      }
      if (!other) continue;
      common[views.poses[v].camera].push_back(
          {.view = v,
           .frame = place.first,
           .is_linked = isLinked(v),
           .rig_from_rig = joint.rig_from_body[v] * joint.rig_from_body[*other].inverse()});
    }
  }
  return common;
}

// Median displacement in the images of the views of points at the middle of the board, px; the image's
// diagonal if they leave the camera's domain.
double effectOf(const SE3& rig_from_rig, const JointFit& joint, std::size_t camera,
                const std::vector<std::size_t>& of_camera) {
  const FitCamera& of = joint.fit.cameras[camera];
  const AnyCamera lens = cameraOf(of);
  std::vector<double> distances;
  for (const std::size_t v : of_camera) {
    const FitView& view = joint.fit.views[v];
    const Eigen::Vector3d p_body =
        boardOf(joint.fit, view).poseOf({}) * boardOf(joint.fit, view).target.middle();
    const Projection before = lens.projectPoint(of.camera_from_rig * joint.rig_from_body[v] * p_body);
    const Projection after =
        lens.projectPoint(of.camera_from_rig * rig_from_rig * joint.rig_from_body[v] * p_body);
    const bool are_seen = before.ok() && after.ok();
    distances.push_back(are_seen ? (after.pixel - before.pixel).norm()
                                 : std::hypot(of.size.width, of.size.height));
  }
  return medianOf(std::move(distances));
}

SE3 meanOf(const std::vector<const CommonView*>& views) {
  SE3 mean = views[views.size() / 2]->rig_from_rig;
  constexpr int kRounds = 3;  // for a mean of nearby poses
  for (int round = 0; round < kRounds; ++round) {
    Eigen::Matrix<double, kPose, 1> sum = Eigen::Matrix<double, kPose, 1>::Zero();
    for (const CommonView* view : views) sum += (mean.inverse() * view->rig_from_rig).log();
    mean = mean * SE3::exp(sum / static_cast<double>(views.size()));
  }
  return mean;
}

// A motion that unlinked all the camera's views before or after it.
std::optional<CameraMotion> largeMotion(const JointFit& joint, std::size_t camera,
                                        const std::vector<CommonView>& common,
                                        const std::vector<std::string>& frames) {
  constexpr double kShare = 0.8;  // of the views on that side, and of all unlinked views
  constexpr double kSure = 4;     // standard errors of the mean pose
  const auto num_unlinked =
      static_cast<std::size_t>(std::ranges::count(common, false, &CommonView::is_linked));
  if (num_unlinked < kFewest || common.size() - num_unlinked < kFewest) return std::nullopt;
  // The split that most views on both sides agree with.
  std::size_t best = 0;
  std::size_t at = 0;
  bool is_late = true;
  std::size_t unlinked_before = 0;
  for (std::size_t i = 0; i < common.size(); ++i) {
    const std::size_t late = (i - unlinked_before) + (num_unlinked - unlinked_before);
    for (const bool after : {true, false}) {
      const std::size_t agreeing = after ? late : common.size() - late;
      if (agreeing <= best) continue;
      best = agreeing;
      at = i;
      is_late = after;
    }
    unlinked_before += common[i].is_linked ? 0 : 1;
  }
  std::vector<const CommonView*> moved;
  for (std::size_t i = is_late ? at : 0; i < (is_late ? common.size() : at); ++i) {
    if (!common[i].is_linked) moved.push_back(&common[i]);
  }
  const auto num_side = static_cast<double>(is_late ? common.size() - at : at);
  const auto num_moved = static_cast<double>(moved.size());
  if (moved.size() < kFewest || num_moved < kShare * num_side ||
      num_moved < kShare * static_cast<double>(num_unlinked))
    return std::nullopt;
  const SE3 mean = meanOf(moved);
  std::vector<std::size_t> of_camera;
  std::vector<double> spreads_px;
  for (const CommonView* view : moved) {
    of_camera.push_back(view->view);
    spreads_px.push_back(effectOf(mean.inverse() * view->rig_from_rig, joint, camera, {view->view}));
  }
  const double effect_px = effectOf(mean, joint, camera, of_camera);
  if (kSure * medianOf(std::move(spreads_px)) > std::sqrt(num_moved) * effect_px) return std::nullopt;
  const SE3 camera_from_rig = joint.fit.cameras[camera].camera_from_rig;
  // The fit has the camera's pose before a late motion, or after an early one.
  const SE3 change = is_late ? mean : mean.inverse();
  return CameraMotion{.camera = camera,
                      .from_frame = frames[common[at].frame],
                      .after_from_before = camera_from_rig * change * camera_from_rig.inverse(),
                      .effect_px = effect_px,
                      .num_after = common.size() - at};
}

std::optional<CameraMotion> smallMotion(const JointFit& joint,
                                        const std::vector<std::vector<CommonView>>& common,
                                        const std::vector<std::string>& frames, double frame_variance) {
  const auto step = likeliestPoseStep(joint.fit, frame_variance);
  if (!step) return std::nullopt;
  std::vector<std::size_t> before;
  std::vector<std::size_t> after;
  for (const CommonView& view : common[step->camera]) {
    if (view.is_linked) (view.frame < step->first_frame ? before : after).push_back(view.view);
  }
  if (before.empty() || after.empty()) return std::nullopt;
  const SE3 in_rig = SE3::exp(step->tangent);
  const SE3 camera_from_rig = joint.fit.cameras[step->camera].camera_from_rig;
  return CameraMotion{
      .camera = step->camera,
      .from_frame = frames[step->first_frame],
      .after_from_before = camera_from_rig * in_rig * camera_from_rig.inverse(),
      // Views on one side alone may say little about a step far from where they see the board.
      .effect_px = std::min(effectOf(in_rig, joint, step->camera, before),
                            effectOf(in_rig, joint, step->camera, after)),
      .num_after = after.size()};
}

}  // namespace

std::vector<CameraMotion> cameraMotions(const JointViews& views, const JointFit& joint,
                                        const RigCovariance& covariance) {
  if (!covariance.isKnown()) return {};  // nothing is known of the poses
  const std::vector<std::string>& frames = views.frames.names;
  const std::vector<std::vector<CommonView>> common = commonViews(views, joint);
  std::vector<CameraMotion> motions;
  for (std::size_t c = 0; c < common.size(); ++c) {
    if (auto motion = largeMotion(joint, c, common[c], frames)) motions.push_back(std::move(*motion));
  }
  if (motions.empty()) {
    // Between frames, the path of a board is known to some per cent of its motion, the same for many frames.
    constexpr double kPathError = 0.06;
    const double least_px = joint.exposure ? kPathError * joint.exposure->shift_px : 0;
    auto motion = smallMotion(joint, common, frames, covariance.frame_variance);
    if (motion && motion->effect_px > least_px) motions.push_back(std::move(*motion));
  }
  std::ranges::stable_sort(motions, std::ranges::greater(), &CameraMotion::effect_px);
  return motions;
}

}  // namespace alidade
