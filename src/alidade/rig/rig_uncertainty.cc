// SPDX-License-Identifier: MIT
#include "alidade/rig/rig_stages.h"

#include <algorithm>
#include <cmath>
#include <optional>
#include <set>
#include <utility>

#include "alidade/adjust/board/errors.h"
#include "alidade/adjust/noise/board_offsets.h"
#include "alidade/adjust/noise/covariance.h"
#include "alidade/adjust/noise/joint_information.h"
#include "alidade/adjust/noise/pose_deviations.h"
#include "alidade/adjust/noise/shape_information.h"
#include "alidade/calibrate/uncertainty/print_errors.h"
#include "alidade/calibrate/uncertainty/view_evidence.h"
#include "alidade/camera/any_camera.h"
#include "alidade/core/median.h"

namespace alidade {
namespace {

constexpr double kNan = std::numeric_limits<double>::quiet_NaN();

// The camera that shares the most boards with this one.
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

// Derivative of a pixel of one camera, transferred to a second one at a fixed distance, by all unknowns: 2 x
// columns; nothing if one of the cameras does not see the point.
// @param is_by_motion  the cameras see different boards: of a point that is exact in the first one's frame
std::optional<Eigen::MatrixXd> transferJacobian(const Fit& fit, const JointColumns& columns, std::size_t from,
                                                std::size_t to, const Eigen::Vector3d& p_rig,
                                                bool is_by_motion) {
  const AnyCamera source = cameraOf(fit.cameras[from]);
  const AnyCamera target = cameraOf(fit.cameras[to]);
  const SE3& source_from_rig = fit.cameras[from].camera_from_rig;
  const SE3& target_from_rig = fit.cameras[to].camera_from_rig;
  const Eigen::Vector3d p_source = source_from_rig * p_rig;
  Eigen::Matrix<double, 2, Eigen::Dynamic, Eigen::RowMajor> J_source_params(2, source.parameters().size());
  Eigen::Matrix<double, 2, Eigen::Dynamic, Eigen::RowMajor> J_target_params(2, target.parameters().size());
  Eigen::Matrix<double, 2, 3, Eigen::RowMajor> J_target;
  Eigen::Matrix<double, 3, 2, Eigen::RowMajor> J_ray;
  const Projection seen = source.project(p_source, nullptr, J_source_params.data());
  const bool is_seen = seen.ok() && source.unproject(seen.pixel, J_ray.data());
  if (!is_seen && !is_by_motion) return std::nullopt;
  if (!target.project(target_from_rig * p_rig, J_target.data(), J_target_params.data()).ok())
    return std::nullopt;
  // T S^-1 with S Exp(e) and T Exp(n): p_target = T Exp(n) Exp(-e) S^-1 p_source.
  Eigen::Matrix<double, 3, 6> J_point;
  J_point << Eigen::Matrix3d::Identity(), -hat(p_rig);
  const Eigen::Matrix<double, 2, 3> J_rig = J_target * target_from_rig.rotation.matrix();
  Eigen::MatrixXd J = Eigen::MatrixXd::Zero(2, columns.count);
  J.middleCols(columns.params[to], J_target_params.cols()) += J_target_params;
  if (!is_by_motion)
    J.middleCols(columns.params[from], J_source_params.cols()) -=
        J_rig * source_from_rig.rotation.inverse().matrix() * (p_source.norm() * (J_ray * J_source_params));
  if (columns.pose[to] >= 0) J.middleCols<6>(columns.pose[to]) += J_rig * J_point;
  if (columns.pose[from] >= 0) J.middleCols<6>(columns.pose[from]) -= J_rig * J_point;
  return J;
}

// See CameraLink::transfer_px: the median over the boards that both cameras saw, or over those of a body of
// which both saw one.
double transferErrorPx(const Fit& fit, const JointColumns& columns, std::size_t camera, std::size_t partner,
                       const Eigen::MatrixXd& covariance) {
  constexpr double kChi95 = 5.991;  // 95 % of chi^2 with two degrees of freedom
  std::vector<double> errors;
  for (const std::vector<std::size_t>& of_placement : viewsOfPlacements(fit)) {
    const auto viewOf = [&](std::size_t c) {
      return std::ranges::find_if(of_placement, [&](std::size_t v) { return fit.views[v].camera == c; });
    };
    if (viewOf(camera) == of_placement.end() || viewOf(partner) == of_placement.end()) continue;
    const FitView& view = fit.views[*viewOf(camera)];
    const auto J = transferJacobian(fit, columns, partner, camera,
                                    rigFromBoard(fit, view) * boardOf(fit, view).target.middle(),
                                    view.board != fit.views[*viewOf(partner)].board);
    if (J) errors.push_back(std::sqrt(kChi95 / 2 * (*J * covariance * J->transpose()).trace()));
  }
  return errors.empty() ? kNan : medianOf(std::move(errors));
}

// True if both cameras see one board in some frame.
bool doShareBoard(const Fit& fit, std::size_t a, std::size_t b) {
  std::set<std::pair<std::size_t, std::size_t>> of_a;  // placement and board
  for (const FitView& view : fit.views) {
    if (view.camera == a) of_a.emplace(view.placement, view.board);
  }
  return std::ranges::any_of(fit.views, [&](const FitView& view) {
    return view.camera == b && of_a.contains({view.placement, view.board});
  });
}

// Counts the views of each camera with links.
void countLinkedViews(const Fit& fit, std::vector<CameraLink>& links) {
  for (const std::vector<std::size_t>& of_placement : viewsOfPlacements(fit)) {
    if (of_placement.size() < 2) continue;
    for (const std::size_t v : of_placement) {
      const SE3 camera_from_board = cameraFromBoard(fit, fit.views[v]);
      const Eigen::Vector3d line_of_sight = camera_from_board * boardOf(fit, fit.views[v]).target.middle();
      const Eigen::Vector3d normal = camera_from_board.rotation * Eigen::Vector3d::UnitZ();
      const double cosine = std::abs(line_of_sight.normalized().dot(normal));
      CameraLink& link = links[fit.views[v].camera];
      ++link.num_views;
      link.num_grazing += cosine < std::cos(kGrazingRad) ? 1 : 0;
    }
  }
}

// The information of all frames, plus prior knowledge of the lenses.
Eigen::MatrixXd informationOf(const Fit& fit, const JointColumns& columns,
                              const std::vector<Reduced>& frames) {
  Eigen::MatrixXd information = Eigen::MatrixXd::Zero(columns.count, columns.count);
  for (const Reduced& frame : frames) information += frame.information;
  for (std::size_t c = 0; c < fit.cameras.size(); ++c) {
    const std::vector<double>& precision = fit.cameras[c].weak_prior.prior.precision;
    for (std::size_t i = 0; i < precision.size(); ++i) {
      const Eigen::Index at = columns.params[c] + static_cast<Eigen::Index>(i);
      information(at, at) += precision[i];
    }
  }
  return information;
}

void setPoseStd(const Eigen::Matrix<double, 6, 6>& covariance, const Baseline& baseline, CameraLink& link) {
  const auto stdOf = [](const Eigen::VectorXd& variances) {
    return Eigen::Vector3d(variances.cwiseMax(0).cwiseSqrt());
  };
  link.translation_std_m = stdOf(covariance.diagonal().head<3>());
  link.rotation_std_rad = stdOf(covariance.diagonal().tail<3>());
  link.position_std_m = stdOf(baseline.covariance.diagonal());
  link.distance_std_m = baseline.lengthStd();
}

// Standard deviation of the size of the boards, as a share of it: the largest. Each is judged by the camera
// that knows its stretch best; one with held parameters takes their errors for a stretch.
double sizeStdOf(const Fit& fit, std::span<const Calibration> alone) {
  double largest = 0;
  for (std::size_t b = 0; b < fit.boards.size(); ++b) {
    const Calibration* best = nullptr;
    std::pair<bool, double> least;
    for (const Calibration& camera : alone) {
      const CommonError* stretch = findError(camera.uncertainty.common_errors, CommonCause::kStretch, b);
      if (stretch == nullptr) continue;
      const std::pair own(!onlyCamera(camera.fit).constraint.held.empty(), stretch->sigma);
      if (best == nullptr || own < least) {
        best = &camera;
        least = own;
      }
    }
    if (best != nullptr)
      largest = std::max(largest, sizeStd(fit.boards[b], best->uncertainty.common_errors, b));
  }
  return largest;
}

// Changes of the unknowns by errors of the print, one standard deviation each, one per column: the size,
// which scales all lengths, and each board's stretch that the fit ignores.
Eigen::MatrixXd effectsOfPrint(const Fit& fit, const JointColumns& columns, double size_std,
                               std::span<const Calibration> alone) {
  Eigen::MatrixXd effects = Eigen::MatrixXd::Zero(columns.count, 1 + std::ssize(fit.boards));
  for (std::size_t c = 0; c < fit.cameras.size(); ++c) {
    const SE3& pose = fit.cameras[c].camera_from_rig;
    if (columns.pose[c] >= 0)
      effects.col(0).segment<3>(columns.pose[c]) = size_std * (pose.rotation.inverse() * pose.translation);
    const DenseMatrix stretches = ignoredStretches(fit.boards, alone[c].uncertainty.common_errors);
    effects.block(columns.params[c], 1, stretches.rows(), stretches.cols()) = stretches.view();
  }
  for (std::size_t b = 0; b < fit.boards.size(); ++b) {
    const SE3 place = fit.boards[b].poseOf({});
    if (columns.body[b] >= 0)
      effects.col(0).segment<3>(columns.body[b]) = size_std * (place.rotation.inverse() * place.translation);
  }
  return effects;
}

}  // namespace

RigCovariance rigCovariance(const Fit& fit, std::span<const std::optional<CameraRecord>> given,
                            std::span<const Calibration> alone) {
  const JointColumns columns = jointColumns(fit);
  const std::vector<Reduced> frames = jointInformation(fit, columns);
  const std::vector<Eigen::Vector2d> errors = weightedErrors(fit);
  const Eigen::MatrixXd information = informationOf(fit, columns, frames);
  const Eigen::MatrixXd directions = jointDirections(fit, columns, information);
  const auto num_free =
      static_cast<int>(directions.cols() + 6 * static_cast<Eigen::Index>(fit.placements.size())) +
      static_cast<int>(std::lround(numFreeOffsets(fit) + deviationScatter(fit).num_free));
  const double variance = coordinateVariance(errors, fit.loss, num_free);
  const ScaledInverse inverse = scaledInverse(directions.transpose() * information * directions);
  const auto by_frames =
      viewCovariance(frames, directions, columns.count, variance, meanSlope(errors, fit.loss));
  const auto offsets = offsetShare(fit);
  if (!inverse.inverse || !by_frames || !offsets) return {};
  const Eigen::MatrixXd gains = directions * *inverse.inverse * directions.transpose();
  RigCovariance covariance{.matrix = variance * gains,
                           .is_by_frames = by_frames->excess_sigmas > kBeyondChance,
                           .frame_variance = variance * std::max(1.0, by_frames->excess)};
  if (covariance.is_by_frames) covariance.matrix = by_frames->larger;
  covariance.matrix = covariance.matrix.view() + covariance.frame_variance * *offsets;
  covariance.size_std = sizeStdOf(fit, alone);
  const Eigen::MatrixXd by_print = effectsOfPrint(fit, columns, covariance.size_std, alone);
  covariance.matrix = covariance.matrix.view() + by_print * by_print.transpose();
  // An error of a given lens affects all estimates.
  covariance.of_images = covariance.matrix;
  Eigen::MatrixXd by_given(columns.count, 0);
  for (std::size_t c = 0; c < given.size(); ++c) {
    if (!given[c]) continue;
    const Eigen::Index at = columns.params[c];
    const auto count = static_cast<Eigen::Index>(fit.cameras[c].numLensParams());
    Eigen::MatrixXd response = Eigen::MatrixXd::Zero(columns.count, count);
    response.middleRows(at, count).setIdentity();
    response -= gains * information.middleCols(at, count);
    if (const auto stated = statedCovariance(*given[c]))
      covariance.matrix = covariance.matrix.view() + response * stated->view() * response.transpose();
    by_given.conservativeResize(Eigen::NoChange, by_given.cols() + count);
    by_given.rightCols(count) = response;
  }
  covariance.by_given = by_given;
  return covariance;
}

double Baseline::lengthStd() const {
  const Eigen::Vector3d direction = vector_m.stableNormalized();
  return std::sqrt(std::max(0.0, direction.dot(covariance * direction)));
}

Baseline baselineOf(const Fit& fit, const RigCovariance& covariance, std::size_t from, std::size_t to) {
  const JointColumns columns = jointColumns(fit);
  Eigen::MatrixXd J = Eigen::MatrixXd::Zero(3, columns.count);
  Eigen::Vector3d vector = Eigen::Vector3d::Zero();
  for (const auto& [camera, sign] : {std::pair(from, -1.0), std::pair(to, 1.0)}) {
    const Eigen::Vector3d centre = fit.cameras[camera].camera_from_rig.inverse().translation;
    vector += sign * centre;
    if (columns.pose[camera] < 0) continue;
    // The centre of C Exp([v, w]) is Exp(-[v, w]) c for the centre c of C, that is c - v + c x w.
    J.middleCols<3>(columns.pose[camera]) = -sign * Eigen::Matrix3d::Identity();
    J.middleCols<3>(columns.pose[camera] + 3) = sign * hat(centre);
  }
  return {.vector_m = vector, .covariance = J * covariance.matrix.view() * J.transpose()};
}

std::vector<CameraLink> cameraLinks(const Fit& fit, const RigCovariance& covariance) {
  const JointColumns columns = jointColumns(fit);
  std::vector<CameraLink> links(fit.cameras.size());
  countLinkedViews(fit, links);
  for (std::size_t c = 0; c < links.size(); ++c) {
    if (columns.pose[c] < 0) setPoseStd(Eigen::Matrix<double, 6, 6>::Zero(), {}, links[c]);
    if (!covariance.isKnown()) continue;
    if (columns.delay[c] >= 0)
      links[c].delay_std_intervals = std::sqrt(covariance.matrix.view()(columns.delay[c], columns.delay[c]));
    links[c].partner = partnerOf(fit, c);
    links[c].is_by_motion = !doShareBoard(fit, c, links[c].partner);
    links[c].transfer_px = transferErrorPx(fit, columns, c, links[c].partner, covariance.matrix);
    if (columns.pose[c] < 0) continue;
    setPoseStd(covariance.matrix.view().block<6, 6>(columns.pose[c], columns.pose[c]),
               baselineOf(fit, covariance, 0, c), links[c]);
  }
  return links;
}

}  // namespace alidade
