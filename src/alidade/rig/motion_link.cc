// SPDX-License-Identifier: MIT
#include "alidade/rig/motion_link.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <optional>
#include <set>
#include <string_view>
#include <utility>
#include <vector>

#include <fmt/format.h>

#include "alidade/core/degrees.h"
#include "alidade/core/median.h"
#include "alidade/geometry/hand_eye_form.h"
#include "alidade/geometry/rotation_conversions.h"
#include "alidade/geometry/symmetric_eigen.h"

namespace alidade {
namespace {

constexpr std::size_t kFewestAgreeing = 3;  // frames that agree on a pose
constexpr std::size_t kFewestMoving = 5;    // frames that determine two poses

// A body as a part sees it in one frame: the view with most corners.
struct Sighting {
  SE3 part_from_body = {};
  double distance_m = 0;  // to the board or the body's origin, whichever is farther
  std::size_t num_corners = 0;
};
// By frame and body.
using Sightings = std::map<std::size_t, std::map<std::size_t, Sighting>>;

std::vector<Sightings> sightingsOf(const JointViews& views) {
  std::vector<Sightings> parts(views.num_parts);
  for (std::size_t v = 0; v < views.poses.size(); ++v) {
    const PosedView& pose = views.poses[v];
    Sighting& best = parts[views.part_of[pose.camera]][pose.frame][views.body_of[pose.board]];
    if (pose.view->corners.size() <= best.num_corners) continue;
    const SE3 part_from_body = views.rigFromBody(v, views.turnOf(v));
    best = {
        .part_from_body = part_from_body,
        .distance_m = std::max(pose.camera_from_board.translation.norm(), part_from_body.translation.norm()),
        .num_corners = pose.view->corners.size()};
  }
  return parts;
}

// A relative pose by one frame.
struct Candidate {
  SE3 pose;
  double distance_m;
};

// The pose on which nearly all frames agree, if there is one.
std::optional<SE3> agreedPose(const std::vector<Candidate>& candidates) {
  constexpr double kNearlyAll = 0.8;
  std::vector<SE3> best;
  for (const Candidate& candidate : candidates) {
    std::vector<SE3> same;
    for (const Candidate& other : candidates) {
      if (between(candidate.pose, other.pose).isWithin(kSamePose, other.distance_m))
        same.push_back(other.pose);
    }
    if (same.size() > best.size()) best = std::move(same);
  }
  const bool do_agree =
      best.size() >= kFewestAgreeing &&
      static_cast<double>(best.size()) >= kNearlyAll * static_cast<double>(candidates.size());
  return do_agree ? std::optional(meanPose(best).mean) : std::nullopt;
}

void joinBodies(std::size_t k, std::size_t l, SE3 k_from_l, JointViews& views) {
  if (l < k) {
    std::swap(k, l);
    k_from_l = k_from_l.inverse();
  }
  for (std::size_t b = 0; b < views.body_of.size(); ++b) {
    if (views.body_of[b] != l) continue;
    views.body_of[b] = k;
    views.body_from_board[b] = k_from_l * views.body_from_board[b];
  }
}

// @pre p < q
void joinParts(std::size_t p, std::size_t q, const SE3& p_from_q, JointViews& views) {
  for (std::size_t c = 0; c < views.part_of.size(); ++c) {
    if (views.part_of[c] == q) {
      views.part_of[c] = p;
      views.camera_from_rig[c] = views.camera_from_rig[c] * p_from_q.inverse();
    } else if (views.part_of[c] > q) {
      --views.part_of[c];
    }
  }
  --views.num_parts;
}

// Joins two bodies that a part sees at the same time, at the same place in nearly all frames.
bool joinSeenBodies(const std::vector<Sightings>& parts, JointViews& views) {
  std::map<std::pair<std::size_t, std::size_t>, std::vector<Candidate>> pairs;
  for (const Sightings& part : parts) {
    for (const auto& [frame, bodies] : part) {
      for (auto k = bodies.begin(); k != bodies.end(); ++k) {
        for (auto l = std::next(k); l != bodies.end(); ++l)
          pairs[{k->first, l->first}].push_back(
              {.pose = k->second.part_from_body.inverse() * l->second.part_from_body,
               .distance_m = std::max(k->second.distance_m, l->second.distance_m)});
      }
    }
  }
  for (const auto& [pair, candidates] : pairs) {
    const auto k_from_l = agreedPose(candidates);
    if (!k_from_l) continue;
    joinBodies(pair.first, pair.second, *k_from_l, views);
    return true;
  }
  return false;
}

// Joins two parts that see one body at the same time.
bool joinSeeingParts(const std::vector<Sightings>& parts, JointViews& views) {
  for (std::size_t p = 0; p < parts.size(); ++p) {
    for (std::size_t q = p + 1; q < parts.size(); ++q) {
      std::vector<Candidate> candidates;
      for (const auto& [frame, of_p] : parts[p]) {
        const auto of_q = parts[q].find(frame);
        if (of_q == parts[q].end()) continue;
        for (const auto& [body, seen] : of_p) {
          const auto other = of_q->second.find(body);
          if (other == of_q->second.end()) continue;
          candidates.push_back({.pose = seen.part_from_body * other->second.part_from_body.inverse(),
                                .distance_m = std::max(seen.distance_m, other->second.distance_m)});
        }
      }
      const auto p_from_q = agreedPose(candidates);
      if (!p_from_q) continue;
      joinParts(p, q, *p_from_q, views);
      return true;
    }
  }
  return false;
}

// Two parts and the bodies that each sees at the same time.
struct MotionPair {
  std::size_t p = 0;
  std::size_t q = 0;
  std::vector<std::pair<std::size_t, std::size_t>> bodies = {};
  std::vector<SeenFrom> frames = {};  // P as the robot, Q as its camera
  ClosedForm form = {};

  // Turns about a second axis, RMS, rad.
  [[nodiscard]] double turn() const { return std::sqrt(form.rotation_firmness); }
  [[nodiscard]] bool agrees() const {
    return form.median_rad < kSamePose.rotation_rad && form.median_share < kSamePose.translation;
  }
  [[nodiscard]] bool turnsEnough() const {
    constexpr double kLeast = 1 * kRadPerDeg;
    constexpr double kSure = 4;  // times the errors of single poses
    return turn() > (agrees() ? std::max(kLeast, kSure * form.median_rad) : kLeast);
  }
};

MotionPair motionPair(std::size_t p, std::size_t q, const std::vector<Sightings>& parts) {
  std::map<std::pair<std::size_t, std::size_t>, std::vector<SeenFrom>> by_bodies;
  for (const auto& [frame, of_p] : parts[p]) {
    const auto of_q = parts[q].find(frame);
    if (of_q == parts[q].end()) continue;
    for (const auto& [k, seen] : of_p) {
      for (const auto& [l, other] : of_q->second)
        by_bodies[{k, l}].push_back(
            {.motion = seen.part_from_body, .camera_from_board = other.part_from_body});
    }
  }
  MotionPair pair{.p = p, .q = q};
  for (auto& [bodies, frames] : by_bodies) {
    if (frames.size() < kFewestMoving || bodies.first == bodies.second) continue;
    for (SeenFrom& frame : frames) {
      frame.board = pair.bodies.size();
      pair.frames.push_back(frame);
    }
    pair.bodies.push_back(bodies);
  }
  if (!pair.frames.empty()) pair.form = closedForm(pair.frames, pair.bodies.size());
  return pair;
}

// True if the closed form explains the frames of two bodies.
bool explains(const MotionPair& pair, std::size_t bodies) {
  std::vector<double> turns;
  std::vector<double> shares;
  for (const SeenFrom& frame : pair.frames) {
    if (frame.board != bodies) continue;
    const SE3::Tangent left = leftOver(pair.form, frame);
    turns.push_back(left.tail<3>().norm());
    shares.push_back(left.head<3>().norm() / frame.camera_from_board.translation.norm());
  }
  return medianOf(turns) < kSamePose.rotation_rad && medianOf(shares) < kSamePose.translation;
}

// Joins the two parts whose motion tells most.
bool joinMovingParts(const std::vector<Sightings>& parts, JointViews& views) {
  std::optional<MotionPair> best;
  std::optional<MotionPair> turning;  // the one that turns most, but too little
  const auto worthOf = [](const MotionPair& pair) {
    return pair.form.rotation_firmness * static_cast<double>(pair.frames.size());
  };
  for (std::size_t p = 0; p < parts.size(); ++p) {
    for (std::size_t q = p + 1; q < parts.size(); ++q) {
      MotionPair pair = motionPair(p, q, parts);
      if (pair.frames.empty()) continue;
      const bool is_enough = pair.turnsEnough();
      auto& most = is_enough ? best : turning;
      if (is_enough && !pair.agrees()) continue;
      if (!most || worthOf(pair) > worthOf(*most)) most = std::move(pair);
    }
  }
  if (!best) {
    if (turning) {
      const auto cameraOf = [&](std::size_t part) {
        return static_cast<std::size_t>(std::ranges::find(views.part_of, part) - views.part_of.begin());
      };
      views.little_motion = LittleMotion{.first = cameraOf(turning->p),
                                         .second = cameraOf(turning->q),
                                         .turns = {.main_axis = turning->form.main_axis,
                                                   .main_rad = std::sqrt(turning->form.main_turn),
                                                   .second_rad = turning->turn()}};
    }
    return false;
  }
  joinParts(best->p, best->q, best->form.mount_from_camera, views);
  for (std::size_t i = 0; i < best->bodies.size(); ++i) {
    // Joined before, if other pairs share them.
    const auto [k, l] = best->bodies[i];
    const bool are_first = views.body_of[k] == k && views.body_of[l] == l;
    if (are_first && explains(*best, i)) joinBodies(k, l, best->form.world_from_boards[i], views);
  }
  return true;
}

}  // namespace

void linkByMotion(JointViews& views) {
  views.little_motion.reset();
  views.common_part_of.clear();
  if (views.num_parts == 1) return;
  const std::vector<std::size_t> by_boards = views.part_of;
  for (;;) {
    const std::vector<Sightings> parts = sightingsOf(views);
    if (joinSeenBodies(parts, views)) continue;
    if (views.num_parts == 1 || !(joinSeeingParts(parts, views) || joinMovingParts(parts, views))) break;
  }
  for (std::size_t b = 0; b < views.body_of.size(); ++b) {
    if (views.body_of[b] != b) views.common_part_of = by_boards;
  }
}

RigTurns turnsOf(const Fit& fit) {
  std::map<std::size_t, std::set<std::size_t>> boards;  // of each body
  for (const FitView& view : fit.views) boards[fit.placements[view.placement].body].insert(view.board);
  std::map<std::size_t, std::vector<SO3>> bodies;
  for (const FitPlacement& placement : fit.placements) {
    if (boards[placement.body].size() > 1) bodies[placement.body].push_back(placement.rig_from_body.rotation);
  }
  Eigen::Matrix3d scatter = Eigen::Matrix3d::Zero();
  double count = 0;
  for (const auto& [body, turns] : bodies) {
    for (std::size_t i = 0; i < turns.size(); ++i) {
      for (std::size_t k = i + 1; k < turns.size(); ++k) {
        const Eigen::Vector3d turn = (turns[i] * turns[k].inverse()).log();
        scatter += turn * turn.transpose();
        ++count;
      }
    }
  }
  const SymmetricEigen eigen(scatter / std::max(1.0, count));
  const auto rootOf = [&](int i) { return std::sqrt(std::max(0.0, eigen.eigenvalues()(i))); };
  return {.main_axis = eigen.eigenvectors().col(2), .main_rad = rootOf(2), .second_rad = rootOf(1)};
}

std::string turnsText(const RigTurns& turns, const std::string& camera) {
  const Eigen::Vector3d& axis = turns.main_axis;
  constexpr std::array<std::string_view, 3> kNames = {"the horizontal axis (x)", "the vertical axis (y)",
                                                      "the optical axis (z)"};
  constexpr double kNear = 0.9;  // cosine
  int largest = 0;
  axis.cwiseAbs().maxCoeff(&largest);
  const std::string named =
      std::abs(axis(largest)) > kNear * axis.norm()
          ? std::string(kNames[static_cast<std::size_t>(largest)])
          : fmt::format("the axis ({:.2f}, {:.2f}, {:.2f})", axis.x(), axis.y(), axis.z());
  return fmt::format("by {:.2g} degrees about {} of {}, and by {:.2g} degrees about others",
                     turns.main_rad * kDegPerRad, named, camera, turns.second_rad * kDegPerRad);
}

}  // namespace alidade
