// SPDX-License-Identifier: MIT
#include "alidade/handeye/hand_eye.h"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <limits>
#include <set>
#include <span>
#include <utility>

#include <fmt/format.h>

#include "alidade/adjust/board/errors.h"
#include "alidade/adjust/noise/robust_weighting.h"
#include "alidade/core/error.h"
#include "alidade/core/mapped.h"
#include "alidade/core/median.h"
#include "alidade/core/text.h"
#include "alidade/handeye/doctor.h"
#include "alidade/handeye/hand_eye_judge.h"
#include "alidade/handeye/joint_fit.h"
#include "alidade/handeye/next_pose.h"
#include "alidade/handeye/pose_matching.h"

namespace alidade {
namespace {

// The views of the camera's fit that have a robot pose, with the frames.
struct Frames {
  std::vector<std::string> images;                // sorted as the views
  std::vector<std::vector<std::size_t>> views;    // indices into Fit::views
  std::vector<std::optional<std::size_t>> poses;  // rows of the table
};

Frames framesOf(const Fit& fit, std::span<const std::string> images, const RobotTable& robot,
                std::vector<Diagnosis>& diagnoses) {
  Frames frames;
  for (std::size_t v = 0; v < fit.views.size(); ++v) {
    if (frames.images.empty() || frames.images.back() != fit.views[v].image) {
      frames.images.push_back(fit.views[v].image);
      frames.views.emplace_back();
    }
    frames.views.back().push_back(v);
  }
  frames.poses = matchedRows(frames.images, images, robot.poses, diagnoses);
  return frames;
}

// Boards after the move stand for themselves.
Fit withMovedBoards(Fit fit, const std::vector<bool>& is_after) {
  const std::size_t num_boards = fit.boards.size();
  for (std::size_t b = 0; b < num_boards; ++b) fit.boards.push_back(fit.boards[b]);
  for (std::size_t v = 0; v < fit.views.size(); ++v)
    if (is_after[v]) fit.views[v].board += num_boards;
  return fit;
}

// Leaves out the frames of a fit; returns what is left.
RobotFit withoutFrames(const RobotFit& fit, const std::vector<bool>& is_out) {
  std::vector<bool> is_view_out(fit.fit.views.size(), false);
  for (std::size_t f = 0; f < fit.frames.size(); ++f)
    for (const std::size_t v : fit.frames[f].views) is_view_out[v] = is_out[f];
  RobotFit rest = fit;
  rest.fit = withoutViews(fit.fit, is_view_out);
  rest.frames.clear();
  std::size_t next = 0;
  for (std::size_t f = 0; f < fit.frames.size(); ++f) {
    if (is_out[f]) continue;
    RobotFrame frame = fit.frames[f];
    for (std::size_t& v : frame.views) v = next++;
    rest.frames.push_back(std::move(frame));
  }
  return rest;
}

// Solves without robot poses that others contradict.
// @param index     of each frame among those given, of which it loses some
// @param left_out  gets these
RobotFit settled(RobotFit fit, std::vector<std::size_t> index, std::vector<std::size_t>& left_out,
                 const CancelFlag* cancel) {
  constexpr double kFar = 3;  // times the median
  constexpr double kLeastUsual = 0.3;
  const std::size_t fewest = std::max(kFewestPoses, index.size() - index.size() / 4);
  fit = solved(std::move(fit), cancel);
  while (fit.frames.size() > fewest) {
    const std::vector<double> sizes = mapped(fit.frames, &RobotFrame::sigmas);
    // The worst, and others as bad.
    constexpr double kAsBad = 0.5;
    const double worst = std::ranges::max(sizes);
    if (!(worst > kFar * std::max(medianOf(sizes), kLeastUsual))) break;
    std::vector<bool> is_out(fit.frames.size(), false);
    std::vector<std::size_t> rest;
    for (std::size_t f = 0; f < sizes.size(); ++f) {
      is_out[f] = sizes[f] > std::max(kAsBad * worst, kFar * std::max(medianOf(sizes), kLeastUsual)) &&
                  fit.frames.size() - (f - rest.size()) > fewest;
      (is_out[f] ? left_out : rest).push_back(index[f]);
    }
    index = std::move(rest);
    fit = solved(withoutFrames(fit, is_out), cancel);
  }
  return fit;
}

// Boards that no view in use shows have no place.
void dropUnseenBoards(RobotFit& fit) {
  std::vector<std::size_t> kept;
  for (std::size_t b = 0; b < fit.fit.boards.size(); ++b) {
    if (numViews(fit.fit, b) > 0) kept.push_back(b);
  }
  for (FitView& view : fit.fit.views)
    view.board = static_cast<std::size_t>(std::ranges::find(kept, view.board) - kept.begin());
  const auto first = static_cast<Eigen::Index>(fit.numParams()) + 6;
  const Eigen::MatrixXd all = fit.covariance;
  Eigen::MatrixXd selection = Eigen::MatrixXd::Zero(all.rows(), first + 6 * std::ssize(kept));
  selection.topLeftCorner(first, first).setIdentity();
  for (std::size_t i = 0; i < kept.size(); ++i) {
    selection
        .block<6, 6>(first + 6 * static_cast<Eigen::Index>(kept[i]), first + 6 * static_cast<Eigen::Index>(i))
        .setIdentity();
  }
  fit.covariance = selection.transpose() * all * selection;
  fit.fit.boards = mapped(kept, [boards = fit.fit.boards](std::size_t b) { return boards[b]; });
  fit.world_from_boards = mapped(kept, [places = fit.world_from_boards](std::size_t b) { return places[b]; });
}

// The frames of an image sequence with robot poses, from the matching to the solution.
class HandEye {
 public:
  HandEye(Fit fit, std::span<const std::string> images, const RobotTable& robot, HandEyeCalibration& result)
      : fit_(std::move(fit)),
        robot_(robot),
        result_(result),
        frames_(framesOf(fit_, images, robot, result.diagnoses)) {}

  // Finds the likeliest reading of the table.
  void read(std::optional<CameraOn> camera_on) {
    std::vector<MatchedView> matches;
    std::vector<std::size_t> frame_of;
    for (std::size_t f = 0; f < frames_.images.size(); ++f) {
      if (!frames_.poses[f]) continue;
      for (const std::size_t v : frames_.views[f]) {
        matches.push_back({*frames_.poses[f], fit_.views[v].board, cameraFromBoard(fit_, fit_.views[v])});
        frame_of.push_back(f);
      }
    }
    const std::size_t num_posed = std::set(frame_of.begin(), frame_of.end()).size();
    if (num_posed < kFewestPoses) {
      throw inputError({.where = "robot poses",
                        .found = fmt::format("{} images with a board and a pose", num_posed),
                        .expected = fmt::format("at least {}", kFewestPoses),
                        .next_step = "name the images in the table's first column, or take more"});
    }
    reading_ = likeliestReading(matches, fit_.boards.size(), robot_, camera_on);
    std::ranges::copy(reading_.diagnoses, std::back_inserter(result_.diagnoses));
    stated_.resize(frames_.images.size());
    std::vector<bool> is_after(fit_.views.size(), false);
    for (std::size_t i = 0; i < matches.size(); ++i) {
      stated_[frame_of[i]] = reading_.base_from_gripper[i];
      for (const std::size_t v : frames_.views[frame_of[i]]) is_after[v] = i >= reading_.moved_at;
    }
    if (reading_.moved_at == matches.size()) return;
    fit_ = withMovedBoards(std::move(fit_), is_after);
    result_.diagnoses.push_back(
        {.id = "robot_board_moved",
         .cause = "the board was moved during the recording",
         .evidence = "from " + frames_.images[frame_of[reading_.moved_at]] + " on it stands elsewhere",
         .next_step = "nothing, if that was meant: both places are estimated"});
  }

  [[nodiscard]] const ClosedForm& form() const { return reading_.form; }

  // @param left_out  gets the frames that contradict the others
  RobotFit solve(std::vector<std::size_t>& left_out, const CancelFlag* cancel) {
    RobotFit start{.fit = fit_,
                   .camera_on = reading_.camera_on,
                   .mount_from_camera = reading_.form.mount_from_camera,
                   .world_from_boards = reading_.form.world_from_boards};
    std::vector<double> sizes;
    for (std::size_t f = 0; f < frames_.images.size(); ++f) {
      const SE3 pose = stated_[f].value_or(SE3());
      const FitView& view = fit_.views[frames_.views[f].front()];
      seen_.push_back({motionOf(reading_.camera_on, pose), cameraFromBoard(fit_, view), view.board});
      start.frames.push_back({.base_from_gripper = pose, .views = frames_.views[f]});
      result_.frames.push_back({.image = frames_.images[f],
                                .base_from_gripper = pose,
                                .reason = stated_[f]         ? ""
                                          : frames_.poses[f] ? "no pose is left of the shifted table"
                                                             : "no robot pose"});
      result_.board_distance_m += distanceAt(f);
      if (stated_[f]) sizes.push_back(misfitAt(f));
    }
    result_.board_distance_m /= static_cast<double>(frames_.images.size());
    start.corner_sigma_px = noiseSigma(fit_);
    start.noise = {.rotation_rad = std::max(1e-4, reading_.form.median_rad),
                   .translation_m = std::max(1e-5, reading_.form.median_share * result_.board_distance_m)};
    // Those that would lead the fit astray; the fit finds others.
    constexpr double kFar = 8;
    constexpr double kLeastUsual = 1e-4;  // rad, and share of the distance
    const double usual = std::max(kLeastUsual, medianOf(sizes));
    std::vector<bool> is_out(frames_.images.size());
    std::vector<std::size_t> used;
    for (std::size_t f = 0; f < is_out.size(); ++f) {
      const bool is_far = stated_[f] && misfitAt(f) > kFar * usual;
      if (is_far) left_out.push_back(f);
      is_out[f] = !stated_[f] || is_far;
      if (!is_out[f]) used.push_back(f);
    }
    RobotFit fit = settled(withoutFrames(start, is_out), used, left_out, cancel);
    std::ranges::sort(left_out);
    for (const std::size_t f : left_out)
      result_.frames[f].reason = "robot and image disagree here, unlike elsewhere";
    nameSwaps(fit, left_out);
    dropUnseenBoards(fit);
    return fit;
  }

 private:
  [[nodiscard]] double distanceAt(std::size_t f) const {
    return seen_[f].camera_from_board.translation.norm();
  }
  [[nodiscard]] double misfitAt(std::size_t f) const {
    const SE3::Tangent left = leftOver(reading_.form, seen_[f]);
    return std::hypot(left.tail<3>().norm(), left.head<3>().norm() / distanceAt(f));
  }

  // True if an image shows the board as it would from another image's pose.
  [[nodiscard]] bool agrees(const RobotFit& fit, std::size_t image, std::size_t pose) const {
    constexpr double kNear = 5;      // standard deviations
    constexpr double kImage = 0.01;  // rad, and share of the distance, by which an image may be off
    const SE3 motion = fit.mount_from_camera * seen_[image].camera_from_board *
                       fit.world_from_boards[seen_[image].board].inverse();
    const SE3 gripper = fit.camera_on == CameraOn::kHand ? motion.inverse() : motion;
    const SE3::Tangent off = (stated_[pose]->inverse() * gripper).log();
    return off.tail<3>().norm() < kNear * fit.noise.rotation_rad + kImage &&
           off.head<3>().norm() < kNear * fit.noise.translation_m + kImage * distanceAt(image);
  }

  // Names two images of which each fits the pose of the other, and takes them from the unexplained ones.
  void nameSwaps(const RobotFit& fit, std::vector<std::size_t>& left_out) {
    std::set<std::size_t> swapped;
    for (const std::size_t a : left_out) {
      for (const std::size_t b : left_out) {
        if (a >= b || !agrees(fit, a, b) || !agrees(fit, b, a)) continue;
        for (const auto& [image, other] : {std::pair(a, b), std::pair(b, a)})
          result_.frames[image].reason = "its pose is that of " + frames_.images[other];
        swapped.insert({a, b});
        result_.diagnoses.push_back(
            {.id = "robot_poses_swapped",
             .cause = "two images have each other's robot pose",
             .evidence = frames_.images[a] + " and " + frames_.images[b] + "; both are left out",
             .next_step = "exchange them"});
      }
    }
    std::erase_if(left_out, [&](std::size_t f) { return swapped.contains(f); });
  }

  Fit fit_;
  const RobotTable& robot_;
  HandEyeCalibration& result_;
  Frames frames_;
  LikelyReading reading_ = {};
  std::vector<std::optional<SE3>> stated_ = {};  // of each frame
  std::vector<SeenFrom> seen_ = {};
};

// Takes what the fit says of each frame.
void takeFrames(const RobotFit& fit, std::vector<HandEyeFrame>& frames) {
  auto at = fit.frames.begin();
  for (HandEyeFrame& frame : frames) {
    if (!frame.reason.empty()) continue;
    frame.deviation = at->deviation;
    frame.sigmas = at->sigmas;
    double squares = 0;
    double count = 0;
    for (const std::size_t v : at->views) {
      for (const Eigen::Vector2d& error : fit.fit.views[v].errors) squares += error.squaredNorm();
      count += static_cast<double>(fit.fit.views[v].errors.size());
    }
    frame.rms_px = std::sqrt(squares / count);
    ++at;
  }
}

}  // namespace

HandEyeCalibration calibrateHandEye(std::span<const Board> boards, std::vector<View> views,
                                    const RobotTable& robot, const HandEyeOptions& options) {
  HandEyeCalibration result;
  result.camera = calibrate(boards, std::move(views), options.camera);
  Fit fit = result.camera.fit;
  stiffen(fit);
  const auto at_times = tableAtTimes(mapped(fit.views, &FitView::image), robot, result.diagnoses);
  HandEye hand_eye(std::move(fit), options.images, at_times ? *at_times : robot, result);
  hand_eye.read(options.camera_on);
  judgeMotion(hand_eye.form(), result);
  if (!result.isUsable()) {
    sortDiagnoses(result.diagnoses);
    return result;
  }
  std::vector<std::size_t> left_out;
  const RobotFit joint = hand_eye.solve(left_out, options.camera.cancel);
  takeFrames(joint, result.frames);
  judgeHandEye(joint, left_out, options, result);
  if (result.isUsable()) result.next_pose = nextPose(joint, result);
  return result;
}

void keepLens(const CameraRecord& record, CalibratorOptions& options) {
  record.camera.requireUncorrected();
  options.model = record.camera.modelId();
  options.initial = {.camera = record.camera, .size = record.image_size};
  for (const std::string_view name : record.camera.parameterNames()) options.held.emplace_back(name);
}

HandEyeRecord recordOf(const HandEyeCalibration& calibration, std::string created_by) {
  HandEyeRecord record;
  record.created_by = std::move(created_by);
  record.verdict = calibration.verdict();
  for (const Diagnosis& diagnosis : calibration.diagnoses)
    if (diagnosis.severity >= Severity::kWarning) record.findings.emplace_back(diagnosis.id);
  if (!calibration.isSolved()) {
    constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();
    record.mount_from_camera.translation.setConstant(kNaN);
    record.robot_noise = {.rotation_rad = kNaN, .translation_m = kNaN};
    record.error_m = record.rms_px = kNaN;
    return record;
  }
  record.camera_on = calibration.camera_on;
  record.mount_from_camera = calibration.mount_from_camera;
  record.covariance = calibration.covariance.topLeftCorner<6, 6>();
  record.world_from_boards = calibration.world_from_boards;
  for (const FitBoard& board : calibration.fit.boards) record.boards.push_back(board.target.spec());
  record.robot_noise = calibration.robot_noise;
  record.num_poses = static_cast<int>(std::ranges::count(calibration.frames, "", &HandEyeFrame::reason));
  record.error_m = calibration.error_m;
  record.rms_px = rms(calibration.fit);
  return record;
}

}  // namespace alidade
