// SPDX-License-Identifier: MIT
#include "alidade/footage/map/odometry.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "alidade/core/error.h"
#include "alidade/core/mapped.h"
#include "alidade/core/median.h"

namespace alidade {
namespace {

constexpr std::size_t kFewestForScale = 25;  // points at a known distance that carry over the scale

}  // namespace

std::size_t Path::numPosed() const {
  return static_cast<std::size_t>(
      std::ranges::count_if(frames, [](const PathFrame& frame) { return frame.segment.has_value(); }));
}

Odometry::Odometry(const AnyCamera& camera, ImageSize size)
    : camera_(camera), size_(size), scale_(camera_, size), start_(std::in_place, camera_, size_, scale_) {}

void Odometry::add(std::size_t number, std::span<const TrackPixel> tracks) {
  expect(path_.frames.empty() || path_.frames.back().number < number, "frames come in their order");
  const std::size_t index = path_.frames.size();
  path_.frames.push_back({.number = number, .segment = {}, .camera_from_world = {}});
  if (!is_tracking_ && start_->isCutOff(tracks)) {
    if (const auto motion = start_->lastChance()) begin(*motion);
  }
  if (is_tracking_) {
    if (follow(index, tracks)) return;
    is_tracking_ = false;
    start_.emplace(camera_, size_, scale_);
    // Starts from the last key frame, so that the motion of two views may be joined to it.
    static_cast<void>(start_->add(key_, map_->lastTracks()));
  } else if (map_) {
    if (const auto placed = map_->relocate(tracks, index)) {
      record(index, *placed);
      is_tracking_ = true;
      step_ = SE3();
      last_ = placed->camera_from_world;
      makeKeyFrame(index, tracks);
      return;
    }
  }
  if (const auto motion = start_->add(index, tracks)) begin(*motion);
}

Path Odometry::finish() {
  if (!is_tracking_) {
    if (const auto motion = start_->lastChance()) begin(*motion);
  }
  // The last frames are adjusted like earlier ones.
  if (is_tracking_ && !path_.frames.back().is_key) makeKeyFrame(path_.frames.size() - 1, last_tracks_);
  path_.obstacle = is_tracking_ ? StartObstacle::kNone : start_->obstacle();
  fixPoses();
  for (PathFrame& frame : path_.frames) {
    if (!frame.segment) continue;
    PathSegment& segment = path_.segments[*frame.segment];
    segment.end = static_cast<std::size_t>(&frame - path_.frames.data()) + 1;
    segment.num_keys += frame.is_key ? 1 : 0;
  }
  for (std::size_t s = 0; s < path_.segments.size(); ++s) path_.segments[s].length = lengthOf(s);
  path_.rms_px = num_errors_ > 0 ? std::sqrt(squared_error_px2_ / static_cast<double>(num_errors_)) : 0;
  return std::move(path_);
}

bool Odometry::follow(std::size_t index, std::span<const TrackPixel> tracks) {
  const auto placed = map_->place(tracks, step_ * last_, index);
  if (!placed) return false;
  step_ = placed->camera_from_world * last_.inverse();
  last_ = placed->camera_from_world;
  record(index, *placed);
  if (placed->num_points < kFewestForScale) {
    auto& breaks = path_.segments.back().scale_breaks;
    if (!is_scale_lost_) breaks.push_back(index);
    is_scale_lost_ = true;
  } else {
    is_scale_lost_ = false;
  }
  last_tracks_.assign(tracks.begin(), tracks.end());
  if (map_->needsKeyFrame(tracks, *placed)) makeKeyFrame(index, tracks);
  return true;
}

void Odometry::makeKeyFrame(std::size_t index, std::span<const TrackPixel> tracks) {
  map_->addKeyFrame(index, tracks, last_);
  map_->settle();
  last_ = map_->lastPose();
  key_ = index;
  setKey(index);
}

void Odometry::setKey(std::size_t index) {
  path_.frames[index].is_key = true;
  relative_[index] = {index, SE3()};
}

void Odometry::record(std::size_t index, const PlacedFrame& placed) {
  PathFrame& frame = path_.frames[index];
  frame.segment = path_.segments.size() - 1;
  frame.num_points = placed.num_points + placed.num_distant;
  relative_[index] = {key_, placed.camera_from_world * map_->poses().at(key_).inverse()};
  squared_error_px2_ += placed.squared_error_px2;
  num_errors_ += placed.num_points + placed.num_distant;
}

Odometry::Joint Odometry::jointOf(const TwoView& motion, const std::vector<std::uint32_t>& tracks) const {
  Joint joint;
  if (!map_ || start_->waiting().front().index != key_) return joint;
  joint.camera_from_world = map_->lastPose();
  joint.is_joined = true;
  const Eigen::Vector3d centre = joint.camera_from_world.inverse().translation;
  std::vector<double> ratios;
  std::vector<double> distances;
  for (std::size_t i = 0; i < tracks.size(); ++i) {
    const Eigen::Vector4d& point = motion.points[i];
    if (!motion.is_inlier[i] || !(point.w() > 0)) continue;
    distances.push_back(point.head<3>().norm() / point.w());
    if (const auto known = map_->placeOf(tracks[i]))
      ratios.push_back((*known - centre).norm() / distances.back());
  }
  joint.is_scale_assumed = ratios.size() < kFewestForScale;
  if (!joint.is_scale_assumed) {
    joint.scale = medianOf(std::move(ratios));
  } else if (!distances.empty()) {
    joint.scale = map_->depth() / medianOf(std::move(distances));
  }
  return joint;
}

// Starts with two key frames, a few between them, and the poses of all waiting frames.
void Odometry::begin(const TwoView& motion) {
  const std::deque<WaitingFrame>& waiting = start_->waiting();
  const WaitingFrame& first = waiting.front();
  const WaitingFrame& last = waiting.back();
  const std::size_t end = waiting.size() - 1;  // of the frames between
  const auto tracks = mapped(commonTracks(first.tracks, last.tracks),
                             [&](const auto& common) { return first.tracks[common.first].track; });
  const Joint joint = jointOf(motion, tracks);
  const SE3 world_from_first = joint.camera_from_world.inverse();
  LocalMap map(camera_, scale_);
  for (std::size_t i = 0; i < tracks.size(); ++i) {
    if (!motion.is_inlier[i]) continue;
    Eigen::Vector4d point = motion.points[i];
    point.head<3>() *= joint.scale;
    map.setPoint(tracks[i], (world_from_first.matrix() * point).normalized());
  }
  SE3 step = motion.b_from_a;
  step.translation *= joint.scale;
  map.addKeyFrame(first.index, first.tracks, joint.camera_from_world);
  // The frames between them, each placed from the previous one.
  std::vector<std::optional<PlacedFrame>> between;
  SE3 guess = joint.camera_from_world;
  std::size_t num_placed = 0;
  for (std::size_t i = 1; i < end; ++i) {
    between.push_back(map.place(waiting[i].tracks, guess, waiting[i].index));
    if (!between.back()) continue;
    guess = between.back()->camera_from_world;
    ++num_placed;
  }
  constexpr double kEnough = 0.7;
  if (static_cast<double>(num_placed) < kEnough * static_cast<double>(between.size())) {
    start_->reject();
    return;
  }
  std::vector<std::size_t> keys = {0};
  constexpr std::size_t kParts = 5;  // of the path between the two
  for (std::size_t part = 1; part < kParts; ++part) {
    const std::size_t i = part * end / kParts;
    if (i <= keys.back() || i >= end || !between[i - 1]) continue;
    map.addKeyFrame(waiting[i].index, waiting[i].tracks, between[i - 1]->camera_from_world);
    keys.push_back(i);
  }
  map.addKeyFrame(last.index, last.tracks, step * joint.camera_from_world);
  keys.push_back(end);
  map.settle();

  fixPoses();
  if (!joint.is_joined)
    path_.segments.push_back({.begin = first.index, .end = last.index + 1, .scale_breaks = {}, .points = {}});
  if (joint.is_scale_assumed && !is_scale_lost_) path_.segments.back().scale_breaks.push_back(last.index);
  is_scale_lost_ = false;
  map_.emplace(std::move(map));
  for (const std::size_t i : keys) {
    key_ = waiting[i].index;
    if (const auto placed = map_->place(waiting[i].tracks, map_->poses().at(key_), key_))
      record(key_, *placed);
    path_.frames[key_].segment = path_.segments.size() - 1;
    setKey(key_);
  }
  // Again, with the adjusted points.
  key_ = first.index;
  last_ = joint.camera_from_world;
  for (std::size_t i = 1; i < end; ++i) {
    const std::size_t index = waiting[i].index;
    if (path_.frames[index].is_key) {
      key_ = index;
      last_ = map_->poses().at(index);
      continue;
    }
    const SE3& near = between[i - 1] ? between[i - 1]->camera_from_world : last_;
    const auto placed = map_->place(waiting[i].tracks, near, index);
    if (!placed) continue;
    record(index, *placed);
    last_ = placed->camera_from_world;
  }
  if (!joint.is_joined) placeEarlier(first.index);
  key_ = last.index;
  step_ = end > 1 ? map_->lastPose() * last_.inverse() : SE3();
  last_ = map_->lastPose();
  is_tracking_ = true;
}

// Places the frames before the first one if they show the same points.
void Odometry::placeEarlier(std::size_t first) {
  key_ = first;
  SE3 guess;
  const std::deque<WaitingFrame>& earlier = start_->earlier();
  for (auto frame = earlier.rbegin(); frame != earlier.rend(); ++frame) {
    if (path_.frames[frame->index].segment) break;
    const auto placed = map_->place(frame->tracks, guess, frame->index);
    if (!placed) break;
    record(frame->index, *placed);
    guess = placed->camera_from_world;
    path_.segments.back().begin = frame->index;
  }
}

// Fixes poses of the frames so far, as their key frames no longer change.
void Odometry::fixPoses() {
  if (!map_) return;
  for (const auto& [index, relative] : relative_)
    path_.frames[index].camera_from_world = relative.second * map_->poses().at(relative.first);
  relative_.clear();
  const std::vector<Eigen::Vector3d> points = map_->points();
  std::vector<Eigen::Vector3d>& all = path_.segments.back().points;
  all.insert(all.end(), points.begin(), points.end());
  map_.reset();
}

double Odometry::lengthOf(std::size_t segment) const {
  double length = 0;
  std::optional<Eigen::Vector3d> last;
  for (const PathFrame& frame : path_.frames) {
    if (frame.segment != segment) continue;
    const Eigen::Vector3d centre = frame.camera_from_world.inverse().translation;
    if (last) length += (centre - *last).norm();
    last = centre;
  }
  return length;
}

}  // namespace alidade
