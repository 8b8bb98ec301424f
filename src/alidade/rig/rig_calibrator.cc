// SPDX-License-Identifier: MIT
#include "alidade/rig/rig_calibrator.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <set>
#include <utility>

#include <fmt/format.h>

#include "alidade/adjust/covariance.h"
#include "alidade/adjust/errors.h"
#include "alidade/adjust/robust_weighting.h"
#include "alidade/adjust/shape_information.h"
#include "alidade/adjust/solve.h"
#include "alidade/calibrate/calibrator.h"
#include "alidade/calibrate/record_of.h"
#include "alidade/calibrate/uncertainty/view_covariance.h"
#include "alidade/core/error.h"
#include "alidade/core/mapped.h"
#include "alidade/core/median.h"
#include "alidade/core/text.h"
#include "alidade/rig/rig_information.h"
#include "alidade/rig/rig_start.h"

namespace alidade {
namespace {

constexpr double kNan = std::numeric_limits<double>::quiet_NaN();

// Errors name their camera.
std::vector<RigCamera> calibratedAlone(std::span<const Board> boards, const std::vector<RigViews>& cameras,
                                       const RigOptions& options) {
  std::vector<RigCamera> result;
  for (std::size_t c = 0; c < cameras.size(); ++c) {
    CalibratorOptions of_camera = options.camera;
    if (!options.models.empty()) of_camera.model = options.models[c];
    try {
      Calibration alone = calibrate(boards, cameras[c].views, of_camera);
      const double rms_px = rms(alone.fit);
      result.push_back(
          {.name = cameras[c].name, .alone = std::move(alone), .alone_rms_px = rms_px, .transfer_px = kNan});
    } catch (const Error& error) {
      throw Error(error.code(), {.where = cameras[c].name, .found = error.what()});
    }
  }
  return result;
}

// The views of all cameras that their calibrations use.
struct GivenView {
  PosedView pose;
  const FitView* view;
};

std::vector<GivenView> usedViews(const std::vector<RigCamera>& cameras, const RigFrames& frames) {
  std::vector<GivenView> views;
  for (std::size_t c = 0; c < cameras.size(); ++c) {
    const Fit& fit = cameras[c].alone.fit;
    for (const FitView& view : fit.views) {
      views.push_back({.pose = {.camera = c,
                                .frame = frames.frame_of[c][view.source],
                                .board = boardIndex(fit, view),
                                .camera_from_board = cameraFromBoard(fit, view)},
                       .view = &view});
    }
  }
  return views;
}

void requireOnePart(const std::vector<RigCamera>& cameras, const RigStart& start) {
  if (start.num_parts == 1) return;
  std::vector<std::string> parts(start.num_parts);
  for (std::size_t c = 0; c < cameras.size(); ++c) {
    std::string& part = parts[start.part_of[c]];
    part += (part.empty() ? "" : ", ") + cameras[c].name;
  }
  throw inputError({.where = "rig",
                    .found = "cameras that nothing links: " + join(parts, " | "),
                    .expected = "frames in which a camera of each part sees the same board at the same time",
                    .next_step = "check that the images' numbers or names match, or take frames in which "
                                 "both parts see the board"});
}

// Corners of a board that is turned, with weights in units of 1 / px^2.
std::vector<Observation> renumbered(const std::vector<Observation>& corners, const Board& board,
                                    const BoardTurn& turn, double sigma_px) {
  std::vector<Observation> result = corners;
  for (Observation& corner : result) {
    corner.id = turn.id_of[static_cast<std::size_t>(corner.id)];
    corner.p_board = board.corner(corner.id);
    corner.weight /= sigma_px * sigma_px;
  }
  std::ranges::sort(result, {}, &Observation::id);
  return result;
}

double sigmaOf(const Calibration& calibration) {
  return std::max(calibration.uncertainty.coordinate_sigma_px, kMinSigmaPx);
}

FitCamera jointCamera(const RigCamera& camera, const SE3& camera_from_rig, bool is_first) {
  FitCamera joint = onlyCamera(camera.alone.fit);
  const double sigma_px = sigmaOf(camera.alone);
  for (double& precision : joint.weak_prior.prior.precision) precision /= sigma_px * sigma_px;
  joint.camera_from_rig = camera_from_rig;
  joint.is_rig_pose_fixed = is_first;
  return joint;
}

// All cameras together, at the start.
Fit jointFit(const std::vector<RigCamera>& cameras, const std::vector<GivenView>& views,
             const RigStart& start) {
  Fit fit{.boards = cameras.front().alone.fit.boards, .loss = {.threshold_px = kLossSigmas}};
  for (std::size_t c = 0; c < cameras.size(); ++c) {
    fit.cameras.push_back(jointCamera(cameras[c], start.camera_from_rig[c], c == 0));
    for (std::size_t b = 0; b < fit.boards.size(); ++b) {
      const FitBoard& board = cameras[c].alone.fit.boards[b];
      if (fit.boards[b].is_shape_fixed && !board.is_shape_fixed) fit.boards[b] = board;
    }
  }
  std::map<std::pair<std::size_t, std::size_t>, std::size_t> placement_of;  // of frame and board
  for (std::size_t v = 0; v < views.size(); ++v) {
    const PosedView& pose = views[v].pose;
    const Board& board = fit.boards[pose.board].target;
    const BoardTurn turn = boardTurns(board)[start.turn_of[v]];
    const SE3 rig_from_board = start.camera_from_rig[pose.camera].inverse() * pose.camera_from_board *
                               turn.turned_from_board.inverse();
    std::size_t placement = fit.placements.size();
    if (start.agrees[v])
      placement = placement_of.try_emplace({pose.frame, pose.board}, placement).first->second;
    if (placement == fit.placements.size())
      fit.placements.push_back({.frame = pose.frame, .board = pose.board, .rig_from_board = rig_from_board});
    fit.views.push_back(
        {.camera = pose.camera,
         .placement = placement,
         .source = v,
         .corners = renumbered(views[v].view->corners, board, turn, sigmaOf(cameras[pose.camera].alone)),
         .image = views[v].view->image});
  }
  return fit;
}

// Mean square of a view's errors in units of its camera's noise.
double meanSquare(const FitView& view) {
  double sum = 0;
  for (std::size_t i = 0; i < view.corners.size(); ++i)
    sum += view.corners[i].weight * view.errors[i].squaredNorm();
  return sum / (2 * static_cast<double>(view.corners.size()));
}

std::vector<std::vector<std::size_t>> viewsOfPlacements(const Fit& fit) {
  std::vector<std::vector<std::size_t>> views(fit.placements.size());
  for (std::size_t v = 0; v < fit.views.size(); ++v) views[fit.views[v].placement].push_back(v);
  return views;
}

// The view whose own pose is farthest from those of the others; of two, the second.
std::size_t oddOne(const std::vector<std::size_t>& of_placement, const std::vector<SE3>& rig_from_board) {
  std::size_t odd = of_placement.front();
  double most = -1;
  for (const std::size_t v : of_placement) {
    double sum = 0;
    for (const std::size_t other : of_placement)
      sum += (rig_from_board[v].inverse() * rig_from_board[other]).log().norm();
    if (sum < most) continue;
    most = sum;
    odd = v;
  }
  return odd;
}

// Gives views that contradict the others of their frame a pose of their own. Returns whether there were any.
bool unlinkContradictions(Fit& fit, const std::vector<GivenView>& views,
                          const std::vector<RigCamera>& cameras, const std::vector<std::size_t>& turn_of,
                          std::vector<std::size_t>& unlinked) {
  constexpr double kContradiction = 9;  // three times the noise, root mean square
  std::vector<SE3> rig_from_board;      // by each view alone
  std::vector<double> alone;
  for (std::size_t v = 0; v < views.size(); ++v) {
    const PosedView& pose = views[v].pose;
    const BoardTurn turn = boardTurns(fit.boards[pose.board].target)[turn_of[v]];
    rig_from_board.push_back(fit.cameras[pose.camera].camera_from_rig.inverse() * pose.camera_from_board *
                             turn.turned_from_board.inverse());
    const double sigma_px = sigmaOf(cameras[pose.camera].alone);
    alone.push_back(meanSquare(*views[v].view) / (sigma_px * sigma_px));
  }
  bool is_any = false;
  for (const std::vector<std::size_t>& of_placement : viewsOfPlacements(fit)) {
    const bool contradicts = of_placement.size() > 1 && std::ranges::any_of(of_placement, [&](std::size_t v) {
                               return meanSquare(fit.views[v]) > kContradiction * std::max(1.0, alone[v]);
                             });
    if (!contradicts) continue;
    const std::size_t odd = oddOne(of_placement, rig_from_board);
    FitPlacement own = fit.placements[fit.views[odd].placement];
    own.rig_from_board = rig_from_board[odd];
    fit.views[odd].placement = fit.placements.size();
    fit.placements.push_back(own);
    unlinked.push_back(odd);
    is_any = true;
  }
  return is_any;
}

double rmsOf(const Fit& fit, std::size_t camera) {
  double sum = 0;
  double count = 0;
  for (const FitView& view : fit.views) {
    if (view.camera != camera) continue;
    for (const Eigen::Vector2d& error : view.errors) sum += error.squaredNorm();
    count += static_cast<double>(view.errors.size());
  }
  return std::sqrt(sum / count);
}

// The camera that sees the most boards together with this one.
std::size_t partnerOf(const Fit& fit, std::size_t camera) {
  std::vector<std::size_t> counts(fit.cameras.size());
  for (const std::vector<std::size_t>& of_placement : viewsOfPlacements(fit)) {
    const auto isOf = [&](std::size_t v) { return fit.views[v].camera == camera; };
    if (std::ranges::none_of(of_placement, isOf)) continue;
    for (const std::size_t v : of_placement) {
      if (!isOf(v)) ++counts[fit.views[v].camera];
    }
  }
  return static_cast<std::size_t>(std::ranges::max_element(counts) - counts.begin());
}

// A pixel of one camera, seen at a fixed distance, as a pixel of another one: its derivative by all unknowns.
class Transfer {
 public:
  Transfer(const Fit& fit, const RigColumns& columns, std::size_t from, std::size_t to)
      : columns_(columns),
        from_(from),
        to_(to),
        source_(AnyCamera::make(fit.cameras[from].model, fit.cameras[from].params)),
        target_(AnyCamera::make(fit.cameras[to].model, fit.cameras[to].params)),
        source_from_rig_(fit.cameras[from].camera_from_rig),
        target_from_rig_(fit.cameras[to].camera_from_rig) {}

  // 2 x columns; nothing where one of the cameras does not see the point.
  [[nodiscard]] std::optional<Eigen::MatrixXd> jacobian(const Eigen::Vector3d& p_rig) const {
    const Eigen::Vector3d p_source = source_from_rig_ * p_rig;
    Eigen::Matrix<double, 2, Eigen::Dynamic, Eigen::RowMajor> J_source_params(2, source_.parameters().size());
    Eigen::Matrix<double, 2, Eigen::Dynamic, Eigen::RowMajor> J_target_params(2, target_.parameters().size());
    Eigen::Matrix<double, 2, 3, Eigen::RowMajor> J_target;
    Eigen::Matrix<double, 3, 2, Eigen::RowMajor> J_ray;
    const Projection seen = source_.project(p_source, nullptr, J_source_params.data());
    if (!seen.ok() || !source_.unproject(seen.pixel, J_ray.data())) return std::nullopt;
    if (!target_.project(target_from_rig_ * p_rig, J_target.data(), J_target_params.data()).ok())
      return std::nullopt;
    // T S^-1 with S Exp(e) and T Exp(n): p_target = T Exp(n) Exp(-e) S^-1 p_source.
    Eigen::Matrix<double, 3, 6> J_point;
    J_point << Eigen::Matrix3d::Identity(), -hat(p_rig);
    const Eigen::Matrix<double, 2, 3> J_rig = J_target * target_from_rig_.rotation.matrix();
    Eigen::MatrixXd J = Eigen::MatrixXd::Zero(2, columns_.count);
    J.middleCols(columns_.params[to_], J_target_params.cols()) += J_target_params;
    J.middleCols(columns_.params[from_], J_source_params.cols()) -=
        J_rig * source_from_rig_.rotation.inverse().matrix() * (p_source.norm() * (J_ray * J_source_params));
    if (columns_.pose[to_] >= 0) J.middleCols<6>(columns_.pose[to_]) += J_rig * J_point;
    if (columns_.pose[from_] >= 0) J.middleCols<6>(columns_.pose[from_]) -= J_rig * J_point;
    return J;
  }

 private:
  const RigColumns& columns_;
  std::size_t from_;
  std::size_t to_;
  AnyCamera source_;
  AnyCamera target_;
  SE3 source_from_rig_;
  SE3 target_from_rig_;
};

// See RigCamera::transfer_px: the median over the boards that both cameras saw.
double transferErrorPx(const Fit& fit, const RigColumns& columns, std::size_t camera,
                       const Eigen::MatrixXd& covariance) {
  constexpr double kChi95 = 5.991;  // 95 % of chi^2 with two degrees of freedom
  const std::size_t partner = partnerOf(fit, camera);
  const Transfer transfer(fit, columns, partner, camera);
  std::vector<double> errors;
  for (const std::vector<std::size_t>& of_placement : viewsOfPlacements(fit)) {
    const auto sees = [&](std::size_t c) {
      return std::ranges::any_of(of_placement, [&](std::size_t v) { return fit.views[v].camera == c; });
    };
    if (!sees(camera) || !sees(partner)) continue;
    const FitView& view = fit.views[of_placement.front()];
    const auto J =
        transfer.jacobian(fit.placements[view.placement].rig_from_board * boardOf(fit, view).target.middle());
    if (J) errors.push_back(std::sqrt(kChi95 / 2 * (*J * covariance * J->transpose()).trace()));
  }
  return errors.empty() ? kNan : medianOf(std::move(errors));
}

// By the corners' noise, or by frames where these disagree by more.
void setCovariance(RigCalibration& rig, const RigColumns& columns) {
  const std::vector<Reduced> frames = rigInformation(rig.fit, columns);
  const Eigen::MatrixXd directions = rigDirections(rig.fit, columns);
  const std::vector<Eigen::Vector2d> errors = weightedErrors(rig.fit);
  const auto num_free =
      static_cast<int>(directions.cols() + 6 * static_cast<Eigen::Index>(rig.fit.placements.size()));
  const double variance = coordinateVariance(errors, rig.fit.loss, num_free);
  Eigen::MatrixXd information = Eigen::MatrixXd::Zero(columns.count, columns.count);
  for (const Reduced& frame : frames) information += frame.information;
  for (std::size_t c = 0; c < rig.fit.cameras.size(); ++c) {
    const std::vector<double>& precision = rig.fit.cameras[c].weak_prior.prior.precision;
    for (std::size_t i = 0; i < precision.size(); ++i) {
      const Eigen::Index at = columns.params[c] + static_cast<Eigen::Index>(i);
      information(at, at) += precision[i];
    }
  }
  const ScaledInverse inverse = scaledInverse(directions.transpose() * information * directions);
  const auto by_frames =
      viewCovariance(frames, directions, columns.count, variance, meanSlope(errors, rig.fit.loss));
  if (!inverse.inverse || !by_frames) return;
  rig.is_by_frames = by_frames->excess_sigmas > kBeyondChance;
  rig.covariance = variance * directions * *inverse.inverse * directions.transpose();
  if (rig.is_by_frames) rig.covariance = by_frames->larger;
}

void setUncertainty(RigCalibration& rig) {
  const RigColumns columns = rigColumns(rig.fit);
  setCovariance(rig, columns);
  if (rig.covariance.rows() == 0) return;
  for (std::size_t c = 0; c < rig.cameras.size(); ++c) {
    rig.cameras[c].transfer_px = transferErrorPx(rig.fit, columns, c, rig.covariance);
    if (columns.pose[c] < 0) continue;
    const Eigen::VectorXd variances = rig.covariance.view().diagonal().segment<6>(columns.pose[c]);
    rig.cameras[c].position_std_m = variances.head<3>().cwiseMax(0).cwiseSqrt();
    rig.cameras[c].rotation_std_rad = variances.tail<3>().cwiseMax(0).cwiseSqrt();
  }
}

std::vector<Diagnosis> judged(const RigCalibration& rig, double tolerance_px) {
  std::vector<Diagnosis> diagnoses;
  if (rig.fit.summary.termination != Termination::kConverged) {
    diagnoses.push_back({.severity = Severity::kFailure,
                         .id = "not_converged",
                         .cause = "the joint fit did not converge: " + rig.fit.summary.reason});
  }
  if (rig.covariance.rows() == 0) {
    diagnoses.push_back(
        {.severity = Severity::kFailure,
         .id = "undetermined",
         .cause = "the frames do not determine the poses of the cameras",
         .next_step = "take more frames in which several cameras see the board, tilted differently"});
  }
  const std::size_t num_links = rig.num_linked + rig.unlinked.size();
  if (!rig.unlinked.empty()) {
    constexpr std::size_t kMost = 5;
    std::vector<std::string> names;
    for (const UnlinkedView& view : rig.unlinked) {
      if (names.size() < kMost) names.push_back(rig.cameras[view.camera].name + "/" + view.image);
    }
    const bool are_many = 5 * rig.unlinked.size() > num_links;
    diagnoses.push_back(
        {.severity = are_many ? Severity::kFailure : Severity::kWarning,
         .id = "not_simultaneous",
         .cause = fmt::format("{} of {} common views of a board contradict the rig", rig.unlinked.size(),
                              num_links),
         .evidence = join(names, ", ") + (rig.unlinked.size() > kMost ? ", ..." : ""),
         .next_step = "hold the board still while the cameras take a frame, and check that names match"});
  }
  for (const RigCamera& camera : rig.cameras) {
    if (!(camera.transfer_px > 0)) continue;
    const Severity severity = severityOf(camera.transfer_px, tolerance_px);
    if (severity == Severity::kNote) continue;
    diagnoses.push_back(
        {.severity = severity,
         .id = "weak_link",
         .cause =
             fmt::format("points at the boards' distance move by {:.2f} px (95 %) from another camera to {}",
                         camera.transfer_px, camera.name),
         .next_step = "take more frames that it shares with other cameras, near and far, tilted",
         .effect_px = camera.transfer_px});
  }
  for (const RigCamera& camera : rig.cameras) {
    for (Diagnosis diagnosis : camera.alone.diagnoses) {
      diagnosis.cause = camera.name + ": " + diagnosis.cause;
      diagnoses.push_back(std::move(diagnosis));
    }
  }
  std::ranges::stable_sort(diagnoses, std::ranges::greater(), &Diagnosis::severity);
  return diagnoses;
}

}  // namespace

RigColumns rigColumns(const Fit& fit) {
  RigColumns columns;
  for (const FitCamera& camera : fit.cameras) {
    columns.params.push_back(columns.count);
    columns.count += static_cast<int>(camera.params.size());
  }
  for (const FitCamera& camera : fit.cameras) {
    columns.pose.push_back(camera.is_rig_pose_fixed ? -1 : columns.count);
    columns.count += camera.is_rig_pose_fixed ? 0 : 6;
  }
  for (const FitBoard& board : fit.boards) {
    columns.bend.push_back(board.is_shape_fixed ? -1 : columns.count);
    columns.count += board.is_shape_fixed ? 0 : kNumBends;
  }
  return columns;
}

RigCalibration calibrateRig(std::span<const Board> boards, std::vector<RigViews> cameras,
                            const RigOptions& options) {
  if (cameras.size() < 2) {
    throw usageError({.where = "rig", .found = "one camera", .expected = "the views of two or more cameras"});
  }
  RigFrames frames = matchFrames(cameras);
  RigCalibration rig;
  rig.cameras = calibratedAlone(boards, cameras, options);
  rig.frames = std::move(frames.names);
  const std::vector<GivenView> views = usedViews(rig.cameras, frames);
  const RigStart start = findRigStart(cameras.size(), boards, mapped(views, &GivenView::pose));
  requireOnePart(rig.cameras, start);
  rig.num_renumbered = static_cast<std::size_t>(
      std::ranges::count_if(start.turn_of, [](std::size_t turn) { return turn != 0; }));
  const SolveOptions solve_options{.cancel = options.camera.cancel};
  rig.fit = solve(jointFit(rig.cameras, views, start), solve_options);
  std::vector<std::size_t> unlinked;
  for (std::size_t v = 0; v < views.size(); ++v) {
    if (!start.agrees[v]) unlinked.push_back(v);
  }
  while (rig.fit.summary.termination != Termination::kFailed &&
         unlinkContradictions(rig.fit, views, rig.cameras, start.turn_of, unlinked))
    rig.fit = solve(std::move(rig.fit), solve_options);
  std::ranges::sort(unlinked);
  for (const std::size_t v : unlinked) {
    rig.unlinked.push_back({.camera = rig.fit.views[v].camera,
                            .image = rig.fit.views[v].image,
                            .frame = rig.frames[views[v].pose.frame]});
  }
  for (const auto& of_placement : viewsOfPlacements(rig.fit))
    rig.num_linked += of_placement.size() > 1 ? 1 : 0;
  for (std::size_t c = 0; c < rig.cameras.size(); ++c) rig.cameras[c].rms_px = rmsOf(rig.fit, c);
  setUncertainty(rig);
  rig.diagnoses = judged(rig, options.camera.tolerance_px);
  return rig;
}

RigRecord recordOf(const RigCalibration& rig, const std::string& created_by) {
  RigRecord record{.cameras = {},
                   .verdict = rig.verdict(),
                   .rms_px = rms(rig.fit),
                   .num_frames = 0,
                   .findings = {},
                   .created_by = created_by};
  std::set<std::size_t> linked_frames;
  for (const std::vector<std::size_t>& of_placement : viewsOfPlacements(rig.fit)) {
    if (of_placement.size() > 1)
      linked_frames.insert(rig.fit.placements[rig.fit.views[of_placement.front()].placement].frame);
  }
  record.num_frames = static_cast<int>(linked_frames.size());
  for (const Diagnosis& diagnosis : rig.diagnoses) {
    if (std::ranges::find(record.findings, diagnosis.id) == record.findings.end())
      record.findings.push_back(diagnosis.id);
  }
  const RigColumns columns = rigColumns(rig.fit);
  if (rig.covariance.rows() > 0) {
    const int num_kept = columns.pose.back() + 6;  // without the boards' bends
    record.covariance = lowerTriangle(rig.covariance.view().topLeftCorner(num_kept, num_kept));
  }
  for (std::size_t c = 0; c < rig.cameras.size(); ++c) {
    const RigCamera& camera = rig.cameras[c];
    Calibration joint = camera.alone;
    onlyCamera(joint.fit).params = rig.fit.cameras[c].params;
    joint.domain = certifyDomain(joint.camera(), joint.imageSize());
    CameraName name;
    name.name = camera.name;
    CameraRecord of_camera = recordOf(joint, {.created_by = "", .name = std::move(name)});
    if (of_camera.calibration && rig.covariance.rows() > 0) {
      const auto size = static_cast<Eigen::Index>(rig.fit.cameras[c].params.size());
      const Eigen::MatrixXd own =
          rig.covariance.view().block(columns.params[c], columns.params[c], size, size);
      of_camera.calibration->covariance = lowerTriangle(own);
      of_camera.calibration->is_covariance_by_views = rig.is_by_frames;
      of_camera.calibration->parameter_std.clear();
      for (Eigen::Index i = 0; i < size; ++i)
        of_camera.calibration->parameter_std.push_back(std::sqrt(std::max(0.0, own(i, i))));
      of_camera.calibration->rms_px = camera.rms_px;
    }
    record.cameras.push_back({.camera = std::move(of_camera),
                              .camera_from_rig = rig.fit.cameras[c].camera_from_rig,
                              .translation_std_m = camera.position_std_m,
                              .rotation_std_rad = camera.rotation_std_rad});
  }
  return record;
}

}  // namespace alidade
