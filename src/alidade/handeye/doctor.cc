// SPDX-License-Identifier: MIT
#include "alidade/handeye/doctor.h"

#include <algorithm>
#include <cmath>
#include <map>

#include <fmt/format.h>

#include "alidade/core/degrees.h"
#include "alidade/core/median.h"
#include "alidade/handeye/joint_fit.h"

namespace alidade {
namespace {

// Beyond this misfit (rad, and shares of the boards' distance), no robot is so inexact.
constexpr double kContradicts = 0.04;
// Below this one, a table needs no mending.
constexpr double kAgrees = 0.01;
// A mistake is named if the misfit is so much smaller without it.
constexpr double kFarBetter = 0.3;

// A change of the table.
struct Mistake {
  const RobotReading* reading = nullptr;  // null: as stated
  bool is_inverted = false;
  bool is_mirrored = false;
  int shift = 0;  // the image belongs to the pose so many rows later

  [[nodiscard]] int count() const {
    return (reading != nullptr ? 1 : 0) + (is_inverted ? 1 : 0) + (is_mirrored ? 1 : 0) +
           (shift != 0 ? 1 : 0);
  }
};

// The same motion in a frame whose z axis points the other way.
SE3 mirrored(const SE3& pose) {
  const Eigen::Vector3d z(1, 1, -1);
  const Eigen::Matrix3d R = z.asDiagonal() * pose.rotation.matrix() * z.asDiagonal();
  return {SO3::fromQuaternion(SO3::Quaternion(R)), z.cwiseProduct(pose.translation)};
}

// The pose of a view; nothing beyond the ends of a shifted table.
std::optional<SE3> poseOf(const MatchedView& view, const RobotTable& table, const Mistake& mistake) {
  const auto row = static_cast<std::ptrdiff_t>(view.pose) + mistake.shift;
  const std::vector<RobotPose>& poses = mistake.reading != nullptr ? mistake.reading->poses : table.poses;
  if (row < 0 || row >= std::ssize(poses)) return std::nullopt;
  SE3 pose = poses[static_cast<std::size_t>(row)].base_from_gripper;
  if (mistake.is_mirrored) pose = mirrored(pose);
  return mistake.is_inverted ? pose.inverse() : pose;
}

struct Tried {
  Mistake mistake;
  CameraOn camera_on;
  ClosedForm form;
};

std::vector<SeenFrom> seenFrom(std::span<const MatchedView> views, const RobotTable& table,
                               const Mistake& mistake, CameraOn camera_on) {
  std::vector<SeenFrom> frames;
  for (const MatchedView& view : views) {
    if (const auto pose = poseOf(view, table, mistake))
      frames.push_back({motionOf(camera_on, *pose), view.camera_from_board, view.board});
  }
  return frames;
}

std::vector<Tried> tryAll(std::span<const MatchedView> views, std::size_t num_boards, const RobotTable& table,
                          std::optional<CameraOn> camera_on) {
  // A camera on the hand with inverted poses is the same as one on the base.
  std::vector<std::pair<CameraOn, bool>> kinds = {{CameraOn::kHand, false}, {CameraOn::kBase, false}};
  if (camera_on) kinds = {{*camera_on, false}, {*camera_on, true}};
  std::vector<const RobotReading*> readings = {nullptr};
  for (const RobotReading& reading : table.others) readings.push_back(&reading);
  constexpr std::size_t kEnough = 60;
  const auto some = views.first(std::min(views.size(), kEnough));
  std::vector<Tried> all;
  for (const auto& [on, is_inverted] : kinds) {
    for (const RobotReading* reading : readings) {
      for (const bool is_mirrored : {false, true}) {
        for (const int shift : {0, 1, -1}) {
          const Mistake mistake{reading, is_inverted, is_mirrored, shift};
          const std::size_t fewest = shift == 0 ? 3 : 5;  // of fewer, a shift leaves too little
          const std::vector<SeenFrom> frames = seenFrom(some, table, mistake, on);
          if (mistake.count() > 2 || frames.size() < fewest) continue;
          all.push_back({mistake, on, closedForm(frames, num_boards)});
        }
      }
    }
  }
  std::ranges::stable_sort(all, {}, [](const Tried& tried) { return tried.mistake.count(); });
  return all;
}

std::string misfitText(const ClosedForm& form) {
  return fmt::format("{:.3g} degrees and {:.3g} % of the distance", form.median_rad * kDegPerRad,
                     100 * form.median_share);
}

// What was wrong with the table, in the order in which the user would mend it.
void nameMistake(const Tried& best, const Tried& stated, std::vector<Diagnosis>& diagnoses) {
  const Mistake& mistake = best.mistake;
  const auto add = [&](DiagnosisId id, const std::string& cause, const std::string& next_step) {
    diagnoses.push_back({.id = id,
                         .cause = cause,
                         .evidence = fmt::format("robot and images then agree to {}, before to {}",
                                                 misfitText(best.form), misfitText(stated.form)),
                         .next_step = next_step});
  };
  if (mistake.reading != nullptr)
    add("robot_poses_misread", "the robot's poses were read with " + mistake.reading->how,
        "state what the numbers mean with --pose-form");
  if (mistake.is_inverted)
    add("robot_poses_inverted",
        fmt::format(
            "the robot's poses were inverted, because they are gripper_from_base for a camera on the {}",
            cameraOnName(best.camera_on)),
        "write base_from_gripper, or check --camera-on");
  if (mistake.is_mirrored)
    add("robot_mirrored",
        "robot and camera are mirror images of each other: the robot's frame is left-handed, or the images are flipped",
        "if a camera in mirror mode took the images, say so with --mirrored image; else turn one axis of the table's "
        "poses around");
  if (mistake.shift != 0)
    add("robot_poses_shifted",
        fmt::format("each image was matched with the {} pose of the table, because it belongs to that one",
                    mistake.shift > 0 ? "next" : "previous"),
        "check the table's first column, and which pose or image is missing at the beginning");
}

double meanSquare(const ClosedForm& form, std::span<const SeenFrom> frames) {
  double sum = 0;
  for (const SeenFrom& frame : frames) sum += leftOver(form, frame).squaredNorm();
  return sum / static_cast<double>(frames.size());
}

// The boards of the frames from the k-th on are others.
std::vector<SeenFrom> movedAt(std::size_t k, std::vector<SeenFrom> frames, std::size_t num_boards) {
  for (std::size_t i = k; i < frames.size(); ++i) {
    frames[i].part = 1;
    frames[i].board += num_boards;
  }
  return frames;
}

// True if each part has enough of every board that it has.
bool areParts(const std::vector<SeenFrom>& moved) {
  constexpr int kFewest = 3;
  std::map<std::size_t, int> counts;
  for (const SeenFrom& frame : moved) ++counts[frame.board];
  return std::ranges::all_of(counts, [](const auto& board) { return board.second >= kFewest; });
}

// The first of the frames `from`, `from + step` and so on up to `to` from which on all boards stand
// elsewhere; the number of frames if there is none.
// @param pose_of  of each frame; one pose is not of two parts
std::size_t moveAmong(const std::vector<SeenFrom>& frames, const std::vector<std::size_t>& pose_of,
                      const ClosedForm& whole, std::size_t num_boards, std::size_t from, std::size_t to) {
  constexpr double kExplained = 0.1;  // of the squares
  const double before = meanSquare(whole, frames);
  double least = before;
  std::size_t best = frames.size();
  for (std::size_t k = std::max<std::size_t>(1, from); k < std::min(to, frames.size()); ++k) {
    const std::vector<SeenFrom> moved = movedAt(k, frames, num_boards);
    if (pose_of[k] == pose_of[k - 1] || !areParts(moved)) continue;
    const double after = meanSquare(closedForm(moved, 2 * num_boards), moved);
    if (after < least) least = after, best = k;
  }
  return least < kExplained * before ? best : frames.size();
}

// The first frame from which on all boards stand elsewhere; the number of frames if there is none. Of many
// frames, some are looked at first.
std::size_t moveOf(const std::vector<SeenFrom>& frames, const std::vector<std::size_t>& pose_of,
                   const ClosedForm& whole, std::size_t num_boards) {
  constexpr std::size_t kMany = 100;
  const std::size_t n = frames.size();
  if (n <= kMany) return moveAmong(frames, pose_of, whole, num_boards, 0, n);
  const std::size_t step = 1 + n / kMany;
  std::vector<SeenFrom> some;
  std::vector<std::size_t> some_poses;
  for (std::size_t i = 0; i < n; i += step) {
    some.push_back(frames[i]);
    some_poses.push_back(pose_of[i]);
  }
  const std::size_t near =
      moveAmong(some, some_poses, closedForm(some, num_boards), num_boards, 0, some.size());
  if (near == some.size()) return n;
  return moveAmong(frames, pose_of, whole, num_boards, (near - 1) * step, (near + 1) * step);
}

// Whether the place of the camera, which the user did not state, is sure.
void judgePlace(const Tried& best, const std::vector<Tried>& all, std::vector<Diagnosis>& diagnoses) {
  const auto other = std::ranges::find_if(all, [&](const Tried& tried) {
    return tried.mistake.count() == 0 && tried.camera_on != best.camera_on;
  });
  if (other == all.end()) return;
  const bool is_sure = best.form.misfit() < kFarBetter * other->form.misfit();
  const std::string place(cameraOnName(best.camera_on));
  const std::string next_step = "state it: --camera-on hand or --camera-on base";
  if (is_sure)
    diagnoses.push_back({.id = "camera_on_found",
                         .severity = Severity::kNote,
                         .cause = "the camera was taken to be on the " + place +
                                  "; if it is not, the table states inverted poses",
                         .next_step = next_step});
  else
    diagnoses.push_back(
        {.id = "camera_on_found",
         .severity = Severity::kFailure,
         .cause = "these poses do not tell whether the camera is on the hand or on the base",
         .evidence = fmt::format("on the {}, {} are left; on the {}, {}", place, misfitText(best.form),
                                 cameraOnName(other->camera_on), misfitText(other->form)),
         .next_step = next_step});
}

// What is left if no reading agrees.
Diagnosis contradictionOf(const std::vector<SeenFrom>& frames, const ClosedForm& form) {
  std::vector<double> angles;
  for (std::size_t i = 1; i < frames.size(); ++i) {
    const auto angle = [](const SE3& a, const SE3& b) { return (a * b.inverse()).rotation.log().norm(); };
    angles.push_back(std::abs(angle(frames[i].motion, frames[i - 1].motion) -
                              angle(frames[i].camera_from_board, frames[i - 1].camera_from_board)));
  }
  return {.id = "robot_contradicts",
          .cause = "robot and camera contradict each other, whatever the table's numbers mean",
          .evidence = fmt::format("from one image to the next they turn by angles that differ by {:.2g} "
                                  "degrees; with the best transform {} are left",
                                  kDegPerRad * medianOf(angles), misfitText(form)),
          .limit = fmt::format("{:.2g}", kContradicts),
          .next_step = "check that images and poses are of one recording, and matched by name"};
}

}  // namespace

LikelyReading likeliestReading(std::span<const MatchedView> views, std::size_t num_boards,
                               const RobotTable& table, std::optional<CameraOn> camera_on) {
  const std::vector<Tried> all = tryAll(views, num_boards, table, camera_on);
  const auto misfit = [](const Tried& tried) { return tried.form.misfit(); };
  const auto least = std::ranges::min_element(all, {}, misfit);
  // As stated, for either place of the camera.
  const auto stated = std::ranges::min_element(
      all, {}, [&](const Tried& tried) { return tried.mistake.count() == 0 ? misfit(tried) : HUGE_VAL; });
  // The fewest mistakes that explain as much as any.
  const auto simplest = std::ranges::find_if(all, [&](const Tried& tried) {
    return misfit(tried) <= 2 * misfit(*least) && misfit(tried) < kContradicts;
  });
  const bool is_mended =
      misfit(*stated) > kAgrees && simplest != all.end() && misfit(*simplest) < kFarBetter * misfit(*stated);
  const Tried& best = is_mended ? *simplest : *stated;
  LikelyReading reading{.camera_on = best.camera_on, .moved_at = views.size()};
  if (is_mended) nameMistake(best, *stated, reading.diagnoses);
  std::vector<std::size_t> view_of;
  std::vector<std::size_t> pose_of;
  for (const MatchedView& view : views) {
    reading.base_from_gripper.push_back(poseOf(view, table, best.mistake));
    if (!reading.base_from_gripper.back()) continue;
    view_of.push_back(reading.base_from_gripper.size() - 1);
    pose_of.push_back(view.pose);
  }
  std::vector<SeenFrom> frames = seenFrom(views, table, best.mistake, best.camera_on);
  reading.form = closedForm(frames, num_boards);
  // Turns about one axis agree with anything.
  constexpr double kLeastTurn = 0.5 / kDegPerRad;
  if (reading.form.rotation_firmness < kLeastTurn * kLeastTurn) return reading;
  const std::size_t move = moveOf(frames, pose_of, reading.form, num_boards);
  if (move < frames.size()) {
    reading.moved_at = view_of[move];
    frames = movedAt(move, std::move(frames), num_boards);
    reading.form = closedForm(frames, 2 * num_boards);
  }
  if (!(reading.form.misfit() < kContradicts))
    reading.diagnoses.push_back(contradictionOf(frames, reading.form));
  else if (!camera_on && move >= frames.size())
    judgePlace(best, all, reading.diagnoses);
  return reading;
}

}  // namespace alidade
