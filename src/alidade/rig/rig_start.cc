// SPDX-License-Identifier: MIT
#include "alidade/rig/rig_start.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <numeric>
#include <set>
#include <string>
#include <utility>

#include "alidade/core/mapped.h"
#include "alidade/core/text.h"
#include "alidade/rig/motion_link.h"

namespace alidade {
namespace {

constexpr PoseDistance kPossible = {0.4, 0.3};  // the joint fit decides whether they are the same

// Views of one body in one frame.
using Placements = std::map<std::pair<std::size_t, std::size_t>, std::vector<std::size_t>>;

Placements placementsOf(const JointViews& views) {
  Placements placements;
  for (std::size_t v = 0; v < views.poses.size(); ++v)
    placements[{views.poses[v].frame, views.body_of[views.poses[v].board]}].push_back(v);
  return placements;
}

using Links = std::map<std::pair<std::size_t, std::size_t>, PairLink>;

// The tracks before each camera; none unless the frames are evenly spaced, except for gaps.
std::vector<Tracks> tracksOf(std::span<const PosedView> views, const RigFrames& frames,
                             std::size_t num_cameras) {
  constexpr double kEven = 0.1;
  constexpr double kMostTime = 1e5;
  const bool is_even = !frames.are_simultaneous && frames.step > 0 && frames.time_spread == 0 &&
                       frames.times.back() < kMostTime && std::ranges::all_of(frames.times, [](double time) {
                         return std::abs(time - std::round(time)) < kEven;
                       });
  std::vector<Tracks> tracks(num_cameras);
  if (!is_even) return tracks;
  for (const PosedView& view : views) {
    const double time = frames.times[frames.frame_of[view.camera][view.view->source]];
    tracks[view.camera][view.board].emplace_back(std::llround(time), view.camera_from_board);
  }
  for (Tracks& of_camera : tracks) {
    for (auto& [board, track] : of_camera) std::ranges::sort(track, {}, &Track::value_type::first);
  }
  return tracks;
}

Links linksOf(const JointViews& all, const Placements& placements) {
  std::map<std::pair<std::size_t, std::size_t>, std::vector<SharedBoard>> common;
  for (const auto& [place, of_place] : placements) {
    for (std::size_t i = 0; i < of_place.size(); ++i) {
      for (std::size_t k = i + 1; k < of_place.size(); ++k) {
        const PosedView* a = &all.poses[of_place[i]];
        const PosedView* b = &all.poses[of_place[k]];
        if (a->camera > b->camera) std::swap(a, b);
        common[{a->camera, b->camera}].push_back({.a_from_board = a->camera_from_board,
                                                  .b_from_board = b->camera_from_board,
                                                  .board = place.second});
      }
    }
  }
  const std::vector<Tracks> tracks = tracksOf(all.poses, all.frames, all.alone.size());
  Links links;
  for (std::size_t b = 1; b < tracks.size(); ++b) {
    for (std::size_t a = 0; a < b; ++a) {
      if (const auto link = linkOf(common[{a, b}], tracks[a], tracks[b], all.boards)) links[{a, b}] = *link;
    }
  }
  return links;
}

// Reaches each camera of a part from the first one, along the links with most frames. Each board is a body.
// @param fewest  frames of a link that counts
void placeCameras(const Links& links, std::size_t fewest, JointViews& start) {
  constexpr std::size_t kNone = static_cast<std::size_t>(-1);
  const std::size_t num_cameras = start.alone.size();
  start.num_parts = 0;
  start.body_of.resize(start.boards.size());
  std::iota(start.body_of.begin(), start.body_of.end(), 0);
  start.body_from_board.assign(start.boards.size(), SE3());
  start.part_of.assign(num_cameras, kNone);
  start.camera_from_rig.assign(num_cameras, SE3());
  start.lags.assign(num_cameras, 0);
  start.are_mirrored.assign(num_cameras, false);
  for (std::size_t first = 0; first < num_cameras; ++first) {
    if (start.part_of[first] != kNone) continue;
    start.part_of[first] = start.num_parts;
    for (;;) {
      const PairLink* best = nullptr;
      std::pair<std::size_t, std::size_t> best_pair;
      for (const auto& [pair, link] : links) {
        const bool has_first = start.part_of[pair.first] == start.num_parts;
        const bool has_second = start.part_of[pair.second] == start.num_parts;
        if (has_first == has_second || link.num_frames < fewest ||
            (best != nullptr && link.num_frames <= best->num_frames))
          continue;
        best = &link;
        best_pair = pair;
      }
      if (best == nullptr) break;
      const auto [a, b] = best_pair;
      if (start.part_of[a] == start.num_parts) {
        start.camera_from_rig[b] = best->b_from_a * start.camera_from_rig[a];
        start.part_of[b] = start.num_parts;
        start.lags[b] = start.lags[a] + best->lag;
        start.are_mirrored[b] = start.are_mirrored[a] != best->is_mirrored;
      } else {
        start.camera_from_rig[a] = best->b_from_a.inverse() * start.camera_from_rig[b];
        start.part_of[a] = start.num_parts;
        start.lags[a] = start.lags[b] - best->lag;
        start.are_mirrored[a] = start.are_mirrored[b] != best->is_mirrored;
      }
    }
    ++start.num_parts;
  }
}

// Takes a board for another print of it before each part that sees it, and links these by motion. False, and
// nothing changes but the links, unless all parts are linked.
bool linkByOwnPrints(const Links& links, std::size_t fewest, JointViews& all) {
  placeCameras(links, fewest, all);
  const std::size_t num_boards = all.boards.size();
  std::map<std::pair<std::size_t, std::size_t>, std::size_t> print_of;  // by board and part
  std::map<std::size_t, const PosedView*> seen;                         // the first view of each board
  std::vector<std::pair<const PosedView*, std::size_t>> others;         // and the other prints of it
  for (PosedView& pose : all.poses) {
    const auto [print, is_new] = print_of.try_emplace({pose.board, all.part_of[pose.camera]}, pose.board);
    const auto [first, is_first] = seen.try_emplace(pose.board, &pose);
    if (is_new && !is_first) {
      print->second = all.boards.size();
      others.emplace_back(first->second, print->second);
      all.boards.push_back(all.boards[pose.board]);
      for (Calibration& alone : all.alone) alone.fit.boards.push_back(alone.fit.boards[pose.board]);
    }
    pose.board = print->second;
  }
  placeCameras(links, fewest, all);
  if (all.boards.size() > num_boards) linkByMotion(all);
  // One board at one place was seen at different times.
  const bool are_prints = std::ranges::none_of(others, [&](const auto& other) {
    const PosedView& of = *other.first;
    return all.body_of[of.board] == all.body_of[other.second] &&
           between(all.body_from_board[of.board], all.body_from_board[other.second])
               .isWithin(kSamePose, of.camera_from_board.translation.norm());
  });
  if (all.num_parts == 1 && are_prints) return true;
  for (PosedView& pose : all.poses) pose.board = pose.view->board;
  all.boards.erase(all.boards.begin() + static_cast<std::ptrdiff_t>(num_boards), all.boards.end());
  for (Calibration& alone : all.alone) alone.fit.boards.resize(num_boards, alone.fit.boards.front());
  return false;
}

// Numbers all views of a placement like its first one. With more than two, the majority decides. Boards that
// are fixed to each other are all turned as they were in the first frame.
void numberViews(const std::vector<std::size_t>& of_place, JointViews& start) {
  const auto turnsOf = [&](std::size_t v) -> const std::vector<BoardTurn>& {
    return start.boards[start.poses[v].board].turns;
  };
  const bool are_several = std::ranges::any_of(
      of_place, [&](std::size_t v) { return start.poses[v].board != start.poses[of_place.front()].board; });
  std::pair<std::size_t, double> most;  // that agree, and how little they differ
  for (const std::size_t base : of_place) {
    for (const BoardTurn& base_turn :
         std::span(turnsOf(base)).first(are_several ? turnsOf(base).size() : 1)) {
      const SE3 expected = start.rigFromBody(base, base_turn);
      const double distance_m = start.poses[base].camera_from_board.translation.norm();
      std::vector<std::size_t> turn_of;
      std::vector<bool> agrees;
      double sum = 0;
      for (const std::size_t v : of_place) {
        const auto costOf = [&](const BoardTurn& turn) {
          return between(expected, start.rigFromBody(v, turn)).cost(distance_m);
        };
        const auto best = std::ranges::min_element(turnsOf(v), {}, costOf);
        turn_of.push_back(static_cast<std::size_t>(best - turnsOf(v).begin()));
        agrees.push_back(between(expected, start.rigFromBody(v, *best)).isWithin(kPossible, distance_m));
        sum += costOf(*best);
      }
      const std::pair found(static_cast<std::size_t>(std::ranges::count(agrees, true)),
                            are_several ? -sum : 0.0);
      if (found <= most) continue;
      most = found;
      for (std::size_t i = 0; i < of_place.size(); ++i) {
        start.turn_of[of_place[i]] = turn_of[i];
        start.agrees[of_place[i]] = agrees[i];
      }
    }
  }
}

using Frames = std::set<std::size_t>;

// True if a camera has separate views in several of these frames.
bool isToldApart(const Frames& frames, const Frames& of_camera) {
  return std::ranges::count_if(frames, [&](std::size_t frame) { return of_camera.contains(frame); }) > 1;
}

// For each board and frame: the first of the frames that count as one because the board did not move.
std::vector<std::vector<std::size_t>> firstFrames(const RigFrames& frames, std::span<const RigViews> given,
                                                  std::span<const Calibration> alone) {
  std::vector<std::vector<std::size_t>> all(alone.front().fit.boards.size(),
                                            std::vector<std::size_t>(frames.names.size()));
  for (std::size_t b = 0; b < all.size(); ++b) {
    std::vector<std::size_t>& first_of = all[b];
    std::iota(first_of.begin(), first_of.end(), 0);
    std::vector<Frames> together;  // for each frame that is the first of a group
    for (std::size_t frame = 0; frame < first_of.size(); ++frame) together.push_back({frame});
    std::vector<Frames> of_camera(alone.size());
    for (std::size_t c = 0; c < alone.size(); ++c) {
      const Fit& fit = alone[c].fit;
      for (const FitView& view : fit.views) {
        if (view.board == b) of_camera[c].insert(frames.frame_of[c][view.source]);
      }
    }
    for (std::size_t c = 0; c < alone.size(); ++c) {
      std::map<std::string, std::size_t> frame_of_image;
      for (std::size_t v = 0; v < given[c].views.size(); ++v)
        frame_of_image[given[c].views[v].image] = frames.frame_of[c][v];
      for (const RepeatedView& repeated : alone[c].dropped.repeated) {
        if (repeated.board != b) continue;
        const std::size_t one = first_of[frame_of_image.at(repeated.image)];
        const std::size_t other = first_of[frame_of_image.at(repeated.same_as)];
        if (one == other) continue;
        Frames both = together[one];
        both.insert(together[other].begin(), together[other].end());
        if (std::ranges::any_of(of_camera, [&](const Frames& own) { return isToldApart(both, own); }))
          continue;
        const std::size_t first = std::min(one, other);
        for (const std::size_t frame : both) first_of[frame] = first;
        together[first] = std::move(both);
      }
    }
  }
  return all;
}

}  // namespace

std::string partsText(std::span<const std::string> names, std::span<const std::size_t> part_of) {
  std::map<std::size_t, std::vector<std::string>> parts;
  for (std::size_t c = 0; c < names.size(); ++c) parts[part_of[c]].push_back(names[c]);
  return join(mapped(parts, [](const auto& part) { return join(part.second, ", "); }), " | ");
}

JointViews jointViews(std::span<const Board> boards, RigFrames frames, std::span<const RigViews> given,
                      std::vector<Calibration> cameras) {
  JointViews all;
  all.alone = std::move(cameras);
  all.frames = std::move(frames);
  const std::vector<std::vector<std::size_t>> first_of = firstFrames(all.frames, given, all.alone);
  for (std::size_t c = 0; c < all.alone.size(); ++c) {
    const Calibration& alone = all.alone[c];
    all.sigma_px.push_back(std::max(alone.uncertainty.coordinate_sigma_px, kMinSigmaPx));
    for (const FitView& view : alone.fit.views) {
      all.poses.push_back({.camera = c,
                           .frame = first_of[view.board][all.frames.frame_of[c][view.source]],
                           .board = view.board,
                           .camera_from_board = cameraFromBoard(alone.fit, view),
                           .view = &view});
    }
  }
  for (const Board& board : boards) all.boards.emplace_back(board);
  all.turn_of.resize(all.poses.size());
  all.agrees.resize(all.poses.size());
  placeCameras({}, 0, all);
  const Links links = linksOf(all, placementsOf(all));
  constexpr std::size_t kFirm = 5;  // frames; boards that are fixed to each other tell more than fewer ones
  placeCameras(links, kFirm, all);
  linkByMotion(all);
  if (all.num_parts > 1 && !linkByOwnPrints(links, kFirm, all)) {
    placeCameras(links, 1, all);
    linkByMotion(all);
  }
  for (const auto& [place, of_place] : placementsOf(all)) numberViews(of_place, all);
  return all;
}

}  // namespace alidade
