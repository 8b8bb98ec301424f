// SPDX-License-Identifier: MIT
#pragma once

#include <array>
#include <cstddef>
#include <limits>
#include <optional>
#include <stdexcept>
#include <string>
#include <string_view>
#include <vector>

namespace alidade {

enum class Severity {
  kPass,     ///< a check that found no problem
  kNote,     ///< for information; the result is not affected
  kWarning,  ///< a reservation: the result may be worse than it looks
  kFailure,  ///< the result must not be used
};

/// The subject of a diagnosis.
enum class Subject {
  kFit,       ///< existence of a solution
  kLens,      ///< the lens as these views show it; irrelevant for a lens that was given
  kViews,     ///< photographs and their corners
  kBoard,     ///< the board's shape and print
  kMatching,  ///< images of a rig's cameras that belong together
  kFrames,    ///< contents of the frames of a rig
  kRig,       ///< places of a rig's cameras
  kImage,     ///< whether the board is in an image
  kFile,      ///< the numbers of a camera file
  kTest,      ///< a camera tested on images or footage, or against another camera
  kFleet,     ///< many camera files of one kind
  kRobot,     ///< poses of a robot, and what follows from them
};

/// Order in which to read equally severe diagnoses.
enum class Rank {
  kCause,  ///< photographs or settings are wrong, so that more photographs of the same kind cannot help
  kOrdinary,
  kConsequence,  ///< usually follows from another diagnosis, such as large errors of any cause
};

struct DiagnosisKind {
  std::string_view id;  ///< stable, for scripts
  Subject subject;
  std::optional<Severity> severity = std::nullopt;  ///< nothing: set by the effect, or by another rule
  Rank rank = Rank::kOrdinary;
  bool needs_focal = false;  ///< means little, and is a note, if the focal length of the camera is unknown
};

namespace detail {
inline constexpr std::optional<Severity> kByRule;
inline constexpr bool kNeedsFocal = true;
}  // namespace detail

/// All diagnoses. docs/verdict.md, docs/rigs.md and docs/handeye.md describe those of one camera, a rig and a
/// robot; a test checks that none is missing. Diagnoses of one camera with equal severity and rank are
/// listed in the order of these rows.
inline constexpr DiagnosisKind kDiagnosisKinds[] = {
    {"not_converged", Subject::kFit, Severity::kFailure},
    {"not_settled", Subject::kViews, Severity::kFailure},
    {"corners_outside_domain", Subject::kViews, Severity::kFailure, Rank::kCause},
    {"folds_in_image", Subject::kLens, Severity::kFailure},
    {"principal_point_outside", Subject::kLens, Severity::kFailure, Rank::kOrdinary, detail::kNeedsFocal},
    {"fronto_parallel", Subject::kLens},
    {"unobservable", Subject::kLens, Severity::kFailure},
    {"focal_uncertain", Subject::kLens, Severity::kFailure},
    {"views_disagree", Subject::kViews, Severity::kFailure, Rank::kCause},
    {"two_cameras", Subject::kViews, detail::kByRule, Rank::kCause},
    {"inaccurate", Subject::kLens, Severity::kFailure, Rank::kConsequence},
    {"misfit", Subject::kLens, detail::kByRule, Rank::kConsequence},
    {"model_too_lean", Subject::kLens, detail::kByRule, Rank::kCause},
    {"lens_deviates", Subject::kLens},
    {"model_rejected", Subject::kLens, Severity::kWarning},
    {"few_views", Subject::kLens},
    {"held_value", Subject::kLens, detail::kByRule, Rank::kCause},
    {"ambiguous_optimum", Subject::kLens},
    {"centre_moves", Subject::kViews, detail::kByRule, Rank::kConsequence, detail::kNeedsFocal},
    {"focus_breathes", Subject::kViews, detail::kByRule, Rank::kConsequence, detail::kNeedsFocal},
    {"correlated_views", Subject::kViews, detail::kByRule, Rank::kCause},
    {"focal_changed", Subject::kViews, detail::kByRule, Rank::kCause},
    {"rolling_shutter", Subject::kViews, detail::kByRule, Rank::kCause},
    {"board_gap", Subject::kBoard, detail::kByRule, Rank::kCause},
    {"board_not_square", Subject::kBoard, detail::kByRule, Rank::kOrdinary, detail::kNeedsFocal},
    {"board_graded", Subject::kBoard, detail::kByRule, Rank::kOrdinary, detail::kNeedsFocal},
    {"board_twisted", Subject::kBoard, detail::kByRule, Rank::kOrdinary, detail::kNeedsFocal},
    {"corners_biased", Subject::kViews, detail::kByRule, Rank::kOrdinary, detail::kNeedsFocal},
    {"odd_aspect", Subject::kLens, detail::kByRule, Rank::kOrdinary, detail::kNeedsFocal},
    {"bent_board", Subject::kBoard},
    {"board_flexes", Subject::kBoard, Severity::kWarning, Rank::kCause},
    {"board_even", Subject::kBoard, Severity::kNote},
    {"pupil_undetermined", Subject::kLens, Severity::kNote},
    {"uneven_board", Subject::kBoard, Severity::kNote},
    {"bend_ignored", Subject::kBoard},
    {"influential_view", Subject::kViews, detail::kByRule, Rank::kOrdinary, detail::kNeedsFocal},
    {"poor_coverage", Subject::kLens, Severity::kWarning, Rank::kConsequence},
    {"ill_conditioned", Subject::kLens, Severity::kNote},
    {"parameter_at_limit", Subject::kLens, Severity::kNote},
    {"pixels_without_ray", Subject::kLens, Severity::kNote},
    {"bend_unknown", Subject::kBoard, Severity::kNote},
    {"mirrored_view", Subject::kViews, Severity::kNote},
    {"view_left_out", Subject::kViews, Severity::kNote},
    {"outliers", Subject::kViews},
    {"repeated_views", Subject::kViews, Severity::kNote},

    {"undetermined", Subject::kFit, Severity::kFailure},
    {"camera_moved", Subject::kFrames, detail::kByRule, Rank::kCause},
    {"not_simultaneous", Subject::kFrames, detail::kByRule, Rank::kCause},
    {"exposures_differ", Subject::kFrames, detail::kByRule, Rank::kCause},
    {"starts_differ", Subject::kMatching, Severity::kNote},
    {"times_differ", Subject::kMatching, Severity::kNote},
    {"unmatched_images", Subject::kMatching, Severity::kNote},
    {"frames_disagree", Subject::kRig, Severity::kWarning},
    {"weak_link", Subject::kRig, detail::kByRule, Rank::kConsequence},
    {"unchecked_link", Subject::kRig, Severity::kWarning},
    {"linked_by_motion", Subject::kRig, Severity::kNote},
    {"no_holdout", Subject::kRig, Severity::kNote},
    {"holdout_error", Subject::kRig},
    {"same_images", Subject::kMatching, Severity::kFailure, Rank::kCause},
    {"no_baseline", Subject::kMatching, Severity::kWarning, Rank::kCause},
    {"points_lost", Subject::kFrames, Severity::kNote},
    {"given_lens_untested", Subject::kFrames, Severity::kNote},
    {"given_lens_misfits", Subject::kRig},
    {"given_lens_verdict", Subject::kRig},
    {"pose_contradicted", Subject::kRig},
    {"pose_untested", Subject::kRig, Severity::kWarning},
    {"lens_contradicted", Subject::kRig},
    {"lengths_contradicted", Subject::kRig, detail::kByRule},

    {"robot_contradicts", Subject::kRobot, Severity::kFailure, Rank::kCause},
    {"robot_motion_poor", Subject::kRobot, Severity::kFailure, Rank::kCause},
    {"robot_poses_misread", Subject::kRobot, Severity::kWarning, Rank::kCause},
    {"robot_poses_inverted", Subject::kRobot, Severity::kWarning, Rank::kCause},
    {"robot_mirrored", Subject::kRobot, Severity::kFailure, Rank::kCause},
    {"robot_poses_shifted", Subject::kRobot, Severity::kWarning, Rank::kCause},
    {"robot_poses_swapped", Subject::kRobot, Severity::kWarning, Rank::kCause},
    {"robot_board_moved", Subject::kRobot, Severity::kWarning, Rank::kCause},
    {"robot_poses_left_out", Subject::kRobot, Severity::kWarning},
    {"robot_scale", Subject::kRobot, detail::kByRule, Rank::kCause},
    {"hand_eye_inaccurate", Subject::kRobot, detail::kByRule, Rank::kConsequence},
    {"camera_on_found", Subject::kRobot, detail::kByRule},
    {"robot_poses_by_order", Subject::kRobot, Severity::kNote},
    {"robot_poses_by_time", Subject::kRobot, Severity::kNote},

    {"several_sizes", Subject::kImage, Severity::kNote},
    {"blurred_images", Subject::kImage, Severity::kNote},
    {"exif_orientation", Subject::kImage, Severity::kNote},
    {"ambiguous_board", Subject::kImage, Severity::kNote},
    {"partial", Subject::kImage},
    {"cut", Subject::kImage},
    {"no_board", Subject::kImage},
    {"unplaced", Subject::kImage},
    {"larger_board", Subject::kImage},
    {"other_board", Subject::kImage},
    {"several_boards", Subject::kImage},
    {"irregular", Subject::kImage},
    {"blurred", Subject::kImage},
    {"too_small", Subject::kImage},
    {"duplicate", Subject::kImage},
    {"unreadable", Subject::kImage},
    {"other_size", Subject::kImage},

    {"focal_length", Subject::kFile},
    {"aspect", Subject::kFile},
    {"principal_point", Subject::kFile},
    {"projection_matrix", Subject::kFile},
    {"tangential", Subject::kFile},
    {"one_to_one", Subject::kFile},
    {"domain", Subject::kFile},
    {"self_check", Subject::kFile},
    {"covariance", Subject::kFile},
    {"calibration", Subject::kFile},
    {"image_size", Subject::kFile, Severity::kNote},
    {"model", Subject::kFile, Severity::kFailure},
    {"extent", Subject::kFile},
    {"poses", Subject::kFile},
    {"rig_calibration", Subject::kFile},
    {"rig_covariance", Subject::kFile},
    {"rows", Subject::kFile},

    {"held_out_error", Subject::kTest},
    {"images_agree", Subject::kTest},
    {"stated_accuracy", Subject::kTest},
    {"own_images", Subject::kTest},
    {"footage", Subject::kTest},
    {"footage_fit", Subject::kTest, Severity::kNote},
    {"footage_shutter", Subject::kTest, Severity::kNote},
    {"against", Subject::kTest},

    {"too_few_units", Subject::kFleet, Severity::kNote},
    {"too_few_to_judge", Subject::kFleet, Severity::kNote},
    {"no_covariance", Subject::kFleet, Severity::kNote},
    {"several_kinds", Subject::kFleet, Severity::kWarning},
    {"deviating_units", Subject::kFleet, Severity::kWarning},
    {"drifted_units", Subject::kFleet, Severity::kWarning},
    {"rejected_units", Subject::kFleet, Severity::kWarning},
    {"unreadable_files", Subject::kFleet, Severity::kWarning},
    {"unreadable_previous", Subject::kFleet, Severity::kWarning},
    {"no_previous", Subject::kFleet, Severity::kNote},
};

/// The id of a diagnosis. An id in code that is missing from kDiagnosisKinds does not compile.
class DiagnosisId : public std::string_view {
 public:
#if defined(__clang__) && __clang_major__ < 17
  constexpr  // crashes where consteval makes an object of a derived class (LLVM's issue 60166)
#else
  consteval
#endif
      DiagnosisId(const char* id)
      : std::string_view(id) {
    for (const DiagnosisKind& kind : kDiagnosisKinds) {
      if (kind.id == id) return;
    }
    throw std::invalid_argument("add a row to kDiagnosisKinds");
  }
  /// An id from a file, which another version may have written.
  [[nodiscard]] static DiagnosisId read(std::string_view id);

  /// The kind from the table; a kind of its own for an id of another version.
  [[nodiscard]] DiagnosisKind kind() const;

 private:
  DiagnosisId() = default;
};

/// A finding of a calibration, a file check or a detection, and what the user should do about it.
struct Diagnosis {
  DiagnosisId id;
  Severity severity = id.kind().severity.value_or(Severity::kWarning);
  std::string cause;           ///< what is wrong
  std::string evidence = {};   ///< the computed value; may be empty
  std::string limit = {};      ///< the limit for it; empty if there is no limit
  std::string next_step = {};  ///< what to do about it; may be empty
  /// Displacement (95 %) in pixels that the cause may give projected points, in the part of the image that
  /// the views cover; NaN if it has no such effect.
  double effect_px = std::numeric_limits<double>::quiet_NaN();
  /// Not decided by these data, but more views could decide it. The covariance includes the information in
  /// the data.
  bool is_undecided = false;
  bool is_cause = false;  ///< here, although its kind usually follows from another diagnosis

  /// Cause and evidence in one sentence.
  [[nodiscard]] std::string message() const { return evidence.empty() ? cause : cause + ": " + evidence; }
};

/// The severity of a cause that may displace projected points by `effect_px`, for a user who accepts
/// `tolerance_px`: a note below a quarter of it, a failure above five times it. NaN: a note.
[[nodiscard]] Severity severityOf(double effect_px, double tolerance_px);

/// Stable name for JSON.
[[nodiscard]] constexpr std::string_view severityName(Severity severity) {
  constexpr std::array<std::string_view, 4> kNames = {"pass", "note", "warning", "failure"};
  return kNames[static_cast<std::size_t>(severity)];
}

/// Usability of a calibration.
enum class Verdict {
  kTrustworthy,   ///< no problem was found
  kReservations,  ///< usable if the reported problems do not matter to the user
  kNo,            ///< must not be used
};

/// Stable name for files and JSON.
[[nodiscard]] constexpr std::string_view verdictName(Verdict verdict) {
  if (verdict == Verdict::kTrustworthy) return "trustworthy";
  return verdict == Verdict::kReservations ? "usable_with_reservations" : "rejected";
}

/// The verdict with this name; std::nullopt if the name is unknown.
[[nodiscard]] constexpr std::optional<Verdict> verdictOf(std::string_view name) {
  for (const Verdict verdict : {Verdict::kTrustworthy, Verdict::kReservations, Verdict::kNo}) {
    if (verdictName(verdict) == name) return verdict;
  }
  return std::nullopt;
}

/// The verdict that follows from the most severe diagnosis.
[[nodiscard]] Verdict verdictOf(const std::vector<Diagnosis>& diagnoses);

/// Most severe first; equally severe ones by Rank.
void sortDiagnoses(std::vector<Diagnosis>& diagnoses);

}  // namespace alidade
