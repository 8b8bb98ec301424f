// SPDX-License-Identifier: MIT
#include "alidade/rig/rig_validation.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <numeric>
#include <utility>

#include <fmt/format.h>

#include "alidade/adjust/board/errors.h"
#include "alidade/adjust/board/solve.h"
#include "alidade/adjust/noise/correction_fit.h"
#include "alidade/adjust/noise/covariance.h"
#include "alidade/adjust/noise/joint_information.h"
#include "alidade/calibrate/uncertainty/print_errors.h"
#include "alidade/camera/any_camera.h"
#include "alidade/camera/triangulation.h"
#include "alidade/core/degrees.h"
#include "alidade/core/diagnosis.h"
#include "alidade/core/error.h"
#include "alidade/core/mapped.h"
#include "alidade/core/statistics.h"
#include "alidade/geometry/symmetric_eigen.h"
#include "alidade/rig/joint_fit.h"
#include "alidade/target/view.h"

namespace alidade {
namespace {

constexpr int kTangent = 6;

// The pose of a camera of the record, relative to the first one.
SE3 statedPose(const RigRecord& rig, std::size_t camera) {
  return rig.cameras[camera].camera_from_rig * rig.cameras.front().camera_from_rig.inverse();
}

// Refits the boards, with lenses and camera poses as stated.
Fit statedFit(const RigRecord& rig, const Fit& freed, const CancelFlag* cancel) {
  Fit stated = freed;
  fixShapes(stated);
  for (std::size_t c = 0; c < stated.cameras.size(); ++c) {
    stated.cameras[c].camera_from_rig = statedPose(rig, c);
    stated.cameras[c].is_rig_pose_fixed = true;
    stated.cameras[c].is_delay_fixed = true;
  }
  return solve(std::move(stated), {.cancel = cancel});
}

// See TestedRigCamera::effect_px.
double effectOf(const Fit& freed, const Fit& stated, std::size_t camera) {
  const AnyCamera lens = cameraOf(freed.cameras[camera]);
  const ImageSize size = freed.cameras[camera].size;
  const double outside = std::hypot(size.width, size.height);
  std::vector<double> distances;
  const auto isOf = [&](std::size_t v) { return freed.views[v].camera == camera; };
  // Of boards that others see at the same time, as far as this camera could see them; else of its own.
  const auto addPoints = [&](const std::vector<std::size_t>& of_placement, bool are_own) {
    if (std::ranges::none_of(of_placement, isOf)) return;
    for (const std::size_t v : of_placement) {
      if (isOf(v) != are_own) continue;
      const SE3 rig_from_board = rigFromBoard(freed, freed.views[v]);
      for (const Observation& corner : cornersOnShape(freed, freed.views[v])) {
        const Eigen::Vector3d p_rig = rig_from_board * corner.p_board;
        const Projection a = lens.projectPoint(freed.cameras[camera].camera_from_rig * p_rig);
        if (!a.ok() || !isInOrNearImage(a.pixel, size)) continue;
        const Projection b = lens.projectPoint(stated.cameras[camera].camera_from_rig * p_rig);
        distances.push_back(b.ok() ? (a.pixel - b.pixel).norm() : outside);
      }
    }
  };
  for (const bool are_own : {false, true}) {
    if (!distances.empty()) break;
    for (const std::vector<std::size_t>& of_placement : viewsOfPlacements(freed))
      addPoints(of_placement, are_own);
  }
  return distances.empty() ? outside : quantile95(std::move(distances));
}

// The covariance of the difference between the pose that the images give a camera, with the lenses as stated,
// and statedPose(). Errors of the stated lenses and poses are correlated: both poses follow those of the
// lenses. C Exp(e) F^-1 = C F^-1 Exp(Ad(F) e) for the first camera's pose F. Without a joint covariance, that
// of the images alone: the tolerance has to allow for the errors of the stored rig.
// @param at  column of the camera's pose in the covariance of `freed`
Eigen::MatrixXd poseDifferenceCovariance(const RigRecord& rig, const RigCovariance& freed, std::size_t camera,
                                         int at) {
  const Eigen::MatrixXd of_images = freed.of_images.view().block(at, at, kTangent, kTangent);
  if (rig.covariance.empty()) return of_images;
  const Eigen::MatrixXd by_lenses = freed.by_given.view().middleRows(at, kTangent);
  const Eigen::Index count = by_lenses.cols() + kTangent * (std::ssize(rig.cameras) - 1);
  Eigen::MatrixXd by_stated = Eigen::MatrixXd::Zero(kTangent, count);
  by_stated.leftCols(by_lenses.cols()) = -by_lenses;
  by_stated.middleCols(by_lenses.cols() + kTangent * (static_cast<Eigen::Index>(camera) - 1), kTangent) =
      rig.cameras.front().camera_from_rig.adjoint();
  return of_images + by_stated * fullMatrix(rig.covariance, count).view() * by_stated.transpose();
}

double sigmasOf(const RigRecord& rig, const RigCalibration& freed, std::size_t camera) {
  constexpr double kUnknown = std::numeric_limits<double>::quiet_NaN();
  const int at = jointColumns(freed.fit).pose[camera];
  if (at < 0) return 0;
  if (!freed.covariance.isKnown()) return kUnknown;
  const Eigen::VectorXd difference =
      (freed.fit.cameras[camera].camera_from_rig.inverse() * statedPose(rig, camera)).log();
  const ScaledInverse inverse = scaledInverse(poseDifferenceCovariance(rig, freed.covariance, camera, at));
  if (!inverse.inverse) return kUnknown;
  return std::max(0.0,
                  normalOfMeanSquare(difference.dot(*inverse.inverse * difference) / kTangent, kTangent));
}

// Scale of a board as measured by a rig: the least squares similarity from stated to measured points (Umeyama
// 1991, IEEE PAMI 13(4), equation 43). Noise of the measured points does not bias it.
double lengthRatio(const std::vector<Eigen::Vector3d>& measured, const std::vector<Eigen::Vector3d>& stated) {
  const auto meanOf = [](const std::vector<Eigen::Vector3d>& points) {
    return Eigen::Vector3d(std::accumulate(points.begin(), points.end(), Eigen::Vector3d(0, 0, 0)) /
                           static_cast<double>(points.size()));
  };
  const Eigen::Vector3d measured_mean = meanOf(measured);
  const Eigen::Vector3d stated_mean = meanOf(stated);
  Eigen::Matrix3d products = Eigen::Matrix3d::Zero();
  double squares = 0;
  for (std::size_t i = 0; i < measured.size(); ++i) {
    products += (measured[i] - measured_mean) * (stated[i] - stated_mean).transpose();
    squares += (stated[i] - stated_mean).squaredNorm();
  }
  // The trace of products^T R over the nearest rotation R is the sum of the singular values, two for the
  // points of a plane.
  const Eigen::Matrix3d gram = products.transpose() * products;
  const SymmetricEigen eigen(gram);
  return (std::sqrt(std::max(0.0, eigen.eigenvalues()(2))) +
          std::sqrt(std::max(0.0, eigen.eigenvalues()(1)))) /
         squares;
}

// The corners of a placement that several cameras see.
struct CommonPoint {
  std::vector<RigPixel> pixels;
  Eigen::Vector3d p_body;
};

// The common points of each placement; none on boards of discs, whose centroids do not project to centroids,
// and none of views that were not taken at one instant.
std::vector<std::vector<CommonPoint>> commonPoints(const Fit& fit) {
  std::vector<std::vector<CommonPoint>> points;
  for (const std::vector<std::size_t>& of_placement : viewsOfPlacements(fit)) {
    if (of_placement.size() < 2) continue;
    std::map<std::pair<std::size_t, int>, CommonPoint> of_corner;  // by board and id
    for (const std::size_t v : of_placement) {
      const FitView& view = fit.views[v];
      const FitBoard& board = boardOf(fit, view);
      if (view.deviation || board.target.discRadius() > 0) continue;
      for (const Observation& corner : cornersOnShape(fit, view)) {
        CommonPoint& point = of_corner[{view.board, corner.id}];
        point.pixels.push_back({.camera = view.camera, .pixel = corner.pixel});
        point.p_body = board.poseOf({}) * corner.p_board;
      }
    }
    std::vector<CommonPoint> common;
    for (auto& [id, point] : of_corner) {
      if (point.pixels.size() > 1) common.push_back(std::move(point));
    }
    if (!common.empty()) points.push_back(std::move(common));
  }
  return points;
}

// Returns NaN if there are too few points.
double lengthRatioOf(const AnyRig& rig, const std::vector<CommonPoint>& points) {
  constexpr std::size_t kFewest = 6;
  std::vector<Eigen::Vector3d> measured;
  std::vector<Eigen::Vector3d> in_body;
  for (const CommonPoint& point : points) {
    const Triangulation triangulated = triangulate(rig, point.pixels);
    if (!triangulated.ok()) continue;
    measured.push_back(triangulated.p_rig);
    in_body.push_back(point.p_body);
  }
  return measured.size() < kFewest ? std::numeric_limits<double>::quiet_NaN()
                                   : lengthRatio(measured, in_body);
}

// The mean over some placements.
double meanLengthRatio(const AnyRig& rig, const std::vector<std::vector<CommonPoint>>& points) {
  constexpr std::size_t kMost = 12;
  const std::size_t step = (points.size() + kMost - 1) / kMost;
  double sum = 0;
  double count = 0;
  for (std::size_t i = 0; i < points.size(); i += step) {
    const double ratio = lengthRatioOf(rig, points[i]);
    if (std::isnan(ratio)) continue;
    sum += ratio;
    ++count;
  }
  return sum / count;
}

// A rig after a step of its unknowns, see RigRecord::covariance.
AnyRig stepped(const AnyRig& rig, const Eigen::VectorXd& step) {
  std::vector<MountedCamera> cameras = rig.cameras();
  Eigen::Index at = 0;
  for (MountedCamera& camera : cameras) {
    const auto params = camera.camera.parameters();
    std::vector<double> changed(params.begin(), params.end());
    for (double& param : changed) param += step(at++);
    camera.camera = camera.camera.withParameters(changed);
  }
  for (std::size_t c = 1; c < cameras.size(); ++c, at += kTangent)
    cameras[c].camera_from_rig =
        cameras[c].camera_from_rig * SE3::exp(Eigen::Matrix<double, kTangent, 1>(step.segment<kTangent>(at)));
  return AnyRig(std::move(cameras));
}

// The part of the variance of the mean ratio due to the rig's stated covariance: squared changes for steps of
// one standard deviation along its axes. NaN if a model has no step along one of them.
double ratioVarianceOfRig(const RigRecord& record, const std::vector<std::vector<CommonPoint>>& points) {
  if (record.covariance.empty()) return 0;
  const AnyRig rig = rigOf(record);
  const Eigen::Index count = numRigUnknowns(rig);
  const DenseMatrix covariance = fullMatrix(record.covariance, count);
  const Eigen::VectorXd scale = covariance.view().diagonal().cwiseMax(1e-300).cwiseSqrt();
  const Eigen::VectorXd inverse = scale.cwiseInverse();
  const SymmetricEigen axes(inverse.asDiagonal() * covariance.view() * inverse.asDiagonal());
  constexpr double kNothing = 1e-9;                        // of the largest axis
  constexpr std::array kSmall = {0.1, -0.1, 1e-3, -1e-3};  // standard deviations; the ratio is linear there
  const double as_stated = meanLengthRatio(rig, points);
  double variance = 0;
  for (Eigen::Index k = 0; k < count; ++k) {
    const double value = axes.eigenvalues()(k);
    if (!(value > kNothing * axes.eigenvalues()(count - 1))) continue;
    const Eigen::VectorXd axis = scale.cwiseProduct(axes.eigenvectors().col(k)) * std::sqrt(value);
    double change = std::numeric_limits<double>::quiet_NaN();
    for (auto small = kSmall.begin(); std::isnan(change) && small != kSmall.end(); ++small) {
      try {
        change = (meanLengthRatio(stepped(rig, *small * axis), points) - as_stated) / *small;
      } catch (const Error&) {  // beyond the range of a model
      }
    }
    variance += change * change;
  }
  return variance;
}

// Points that two or more cameras see: their epipolar errors and the lengths between them.
void measurePoints(const RigRecord& record, const Fit& fit, RigValidation& result) {
  const AnyRig rig = rigOf(record);
  const std::vector<std::vector<CommonPoint>> points = commonPoints(fit);
  double sum = 0;
  std::size_t num_pairs = 0;
  std::vector<double> ratios;
  std::vector<std::vector<CommonPoint>> measured;
  for (const std::vector<CommonPoint>& of_placement : points) {
    result.num_points += of_placement.size();
    for (const CommonPoint& common : of_placement) {
      const Triangulation point = triangulate(rig, common.pixels);
      result.num_failed += point.ok() ? 0 : 1;
      for (auto a = common.pixels.begin(); a != common.pixels.end(); ++a) {
        for (auto b = a + 1; b != common.pixels.end(); ++b) {
          const auto distance =
              epipolarDistance(rig.camera(a->camera), rig.camera(b->camera), a->pixel, b->pixel);
          if (!distance) continue;
          sum += *distance * *distance;
          ++num_pairs;
        }
      }
    }
    const double ratio = lengthRatioOf(rig, of_placement);
    if (std::isnan(ratio)) continue;
    ratios.push_back(ratio);
    measured.push_back(of_placement);
  }
  if (num_pairs > 0) result.epipolar_px = std::sqrt(sum / static_cast<double>(num_pairs));
  if (ratios.size() < 2) return;
  const auto count = static_cast<double>(ratios.size());
  const double mean = std::accumulate(ratios.begin(), ratios.end(), 0.0) / count;
  double scatter = 0;
  for (const double ratio : ratios) scatter += (ratio - mean) * (ratio - mean);
  result.length_ratio = mean;
  result.length_ratio_std = std::sqrt(scatter / (count * (count - 1)) + ratioVarianceOfRig(record, measured) +
                                      std::pow(result.freed.covariance.size_std, 2));
}

// Differences that are certain, by their effect.
std::vector<Diagnosis> judged(const RigValidation& tested, bool has_covariance) {
  constexpr double kSure = 4;  // standard deviations
  const auto severityBeyond = [&](double effect_px) {
    constexpr double kSmall = 0.25;
    if (effect_px > tested.tolerance_px) return Severity::kFailure;
    return effect_px > kSmall * tested.tolerance_px ? Severity::kWarning : Severity::kNote;
  };
  constexpr double kWrongLength = 0.002;
  constexpr double kMmPerM = 1000;
  std::vector<Diagnosis> diagnoses;
  for (std::size_t c = 0; c < tested.cameras.size(); ++c) {
    const TestedRigCamera& camera = tested.cameras[c];
    if (std::isnan(camera.sigmas)) {
      diagnoses.push_back(
          {.id = "pose_untested",
           .cause = "these images do not determine how well the pose of " + camera.name + " is known",
           .next_step = "take more frames in which several cameras see the board"});
    }
    if (camera.sigmas > kSure) {
      diagnoses.push_back(
          {.id = "pose_contradicted",
           .severity = severityBeyond(camera.effect_px),
           .cause =
               fmt::format("{} stands elsewhere than the file says: by {:.2f} mm and {:.3f} degrees, which "
                           "moves points on the boards by {:.2f} px (95 %)",
                           camera.name, camera.freed_from_stated.translation.norm() * kMmPerM,
                           camera.freed_from_stated.rotation.log().norm() * kDegPerRad, camera.effect_px),
           .evidence = fmt::format("{:.1f} sigma", camera.sigmas),
           .next_step =
               "check that the inputs are in the order of the cameras; otherwise calibrate the rig again",
           .effect_px = camera.effect_px});
    }
    if (const auto& misfit = tested.freed.cameras[c].misfit) {
      diagnoses.push_back(
          {.id = "lens_contradicted",
           .severity = severityBeyond(misfit->sure_px),
           .cause = fmt::format("the images of {} contradict its lens by {:.2f} px (95 %)", camera.name,
                                misfit->effect_px),
           .evidence = fmt::format("{:.2f} px more than by chance", misfit->sure_px),
           .next_step = "check that the inputs are in the order of the cameras; otherwise calibrate it again",
           .effect_px = misfit->effect_px});
    }
  }
  const double wrong = std::abs(tested.length_ratio - 1);
  if (wrong > kWrongLength && wrong > kSure * tested.length_ratio_std) {
    diagnoses.push_back(
        {.id = "lengths_contradicted",
         .severity = has_covariance ? Severity::kFailure : Severity::kWarning,
         .cause = fmt::format("the rig measures lengths on the board {:.2f} % {} than the board states",
                              100 * wrong, tested.length_ratio > 1 ? "longer" : "shorter"),
         .evidence = fmt::format("standard deviation {:.2f} %", 100 * tested.length_ratio_std),
         .next_step = "measure the board; if it is as stated, calibrate the rig again"});
  }
  for (Diagnosis diagnosis : tested.freed.diagnoses) {
    const Subject about = diagnosis.id.kind().subject;
    if (isOfSpec(diagnosis)) diagnosis.severity = Severity::kWarning;
    if (isOfSpec(diagnosis) || about == Subject::kFit || about == Subject::kMatching ||
        about == Subject::kFrames)
      diagnoses.push_back(std::move(diagnosis));
  }
  sortDiagnoses(diagnoses);
  return diagnoses;
}

// Of cameras without correction fields.
RigValidation validatePlain(const RigRecord& rig, std::span<const Board> boards,
                            std::vector<RigViews> cameras, double tolerance_px, const RigOptions& options) {
  RigOptions kept = options;
  kept.models.clear();
  kept.given =
      mapped(rig.cameras, [](const RigCameraRecord& camera) { return std::optional(camera.camera); });
  RigValidation result;
  result.tolerance_px = tolerance_px;
  result.freed = calibrate(boards, std::move(cameras), kept);
  const Fit stated = statedFit(rig, result.freed.fit, options.camera.cancel);
  result.rms_px = rms(stated);
  result.freed_rms_px = rms(result.freed.fit);
  for (std::size_t c = 0; c < rig.cameras.size(); ++c) {
    result.cameras.push_back(
        {.name = result.freed.cameras[c].name,
         .rms_px = rmsOfCamera(stated, c),
         .freed_rms_px = result.freed.cameras[c].rms_px,
         .freed_from_stated = result.freed.fit.cameras[c].camera_from_rig * statedPose(rig, c).inverse(),
         .effect_px = effectOf(result.freed.fit, stated, c),
         .sigmas = sigmasOf(rig, result.freed, c)});
  }
  measurePoints(rig, stated, result);
  result.diagnoses = judged(result, !rig.covariance.empty());
  return result;
}

}  // namespace

RigValidation validateRig(const RigRecord& rig, std::span<const Board> boards, std::vector<RigViews> cameras,
                          double tolerance_px, const RigOptions& options) {
  expect(rig.cameras.size() == cameras.size(), "views of each camera of the rig");
  RigRecord plain = rig;
  for (std::size_t c = 0; c < cameras.size(); ++c) {
    AnyCamera& camera = plain.cameras[c].camera.camera;
    if (camera.correction() == nullptr) continue;
    cameras[c].views = freeOf(*camera.correction(), std::move(cameras[c].views));
    camera = camera.withCorrection(nullptr);
  }
  return validatePlain(plain, boards, std::move(cameras), tolerance_px, options);
}

}  // namespace alidade
