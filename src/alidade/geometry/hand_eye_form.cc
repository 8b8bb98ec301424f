// SPDX-License-Identifier: MIT
#include "alidade/geometry/hand_eye_form.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "alidade/core/median.h"
#include "alidade/geometry/decompositions.h"
#include "alidade/geometry/rotation_conversions.h"
#include "alidade/geometry/symmetric_eigen.h"

namespace alidade {
namespace {

constexpr int kNumRounds = 6;  // of weighting down

// Motions of the mount and of the camera between two frames.
struct Pair {
  SE3 of_mount, of_camera;
  Eigen::Vector3d mount_turn, camera_turn;
};

// All pairs of few frames; of many, those at growing distances.
std::vector<Pair> pairsOf(std::span<const SeenFrom> frames) {
  constexpr std::size_t kFew = 60;
  constexpr double kFarthest = 170 * std::numbers::pi / 180;  // beyond, the sign of the axis is uncertain
  std::vector<Pair> pairs;
  const std::size_t n = frames.size();
  for (std::size_t step = 1; step < n; step = n <= kFew ? step + 1 : step + (step + 1) / 2) {
    for (std::size_t i = 0; i + step < n; ++i) {
      const SeenFrom& a = frames[i];
      const SeenFrom& b = frames[i + step];
      if (a.part != b.part || a.board != b.board) continue;
      Pair pair{.of_mount = a.motion * b.motion.inverse(),
                .of_camera = a.camera_from_board * b.camera_from_board.inverse(),
                .mount_turn = {},
                .camera_turn = {}};
      pair.mount_turn = pair.of_mount.rotation.log();
      pair.camera_turn = pair.of_camera.rotation.log();
      if (std::max(pair.mount_turn.norm(), pair.camera_turn.norm()) < kFarthest) pairs.push_back(pair);
    }
  }
  return pairs;
}

// Weights of residuals that are far beyond their median.
std::vector<double> weightsOf(const std::vector<double>& sizes) {
  if (sizes.empty()) return {};
  const double usual = std::max(1e-12, medianOf(sizes));
  std::vector<double> weights;
  for (const double size : sizes) weights.push_back(1 / (1 + std::pow(size / (2 * usual), 4)));
  return weights;
}

void solveRotation(const std::vector<Pair>& pairs, ClosedForm& form) {
  std::vector<double> weights(pairs.size(), 1.0);
  for (int round = 0; round < kNumRounds; ++round) {
    Eigen::Matrix3d K = Eigen::Matrix3d::Zero();
    Eigen::Matrix3d turns = Eigen::Matrix3d::Zero();
    double sum = 0;
    for (std::size_t i = 0; i < pairs.size(); ++i) {
      K += weights[i] * pairs[i].mount_turn * pairs[i].camera_turn.transpose();
      turns += weights[i] * pairs[i].camera_turn * pairs[i].camera_turn.transpose();
      sum += weights[i];
    }
    const Svd3 svd = svdOf(K);
    Eigen::Matrix3d R = svd.U * svd.V.transpose();
    if (R.determinant() < 0) R -= 2 * svd.U.col(2) * svd.V.col(2).transpose();
    form.mount_from_camera.rotation = SO3::fromQuaternion(SO3::Quaternion(R));
    const SymmetricEigen eigen(turns);
    // Two turns about different axes suffice.
    form.rotation_firmness = sum > 0 ? std::max(0.0, eigen.eigenvalues()(1)) / sum : 0;
    form.main_axis = eigen.eigenvectors().col(2);
    form.main_turn = sum > 0 ? std::max(0.0, eigen.eigenvalues()(2)) / sum : 0;
    std::vector<double> sizes;
    for (const Pair& pair : pairs) sizes.push_back((pair.mount_turn - R * pair.camera_turn).norm());
    weights = weightsOf(sizes);
  }
}

void solveTranslation(const std::vector<Pair>& pairs, ClosedForm& form) {
  const SO3& R = form.mount_from_camera.rotation;
  std::vector<double> weights(pairs.size(), 1.0);
  for (int round = 0; round < kNumRounds; ++round) {
    Eigen::Matrix3d AtA = Eigen::Matrix3d::Zero();
    Eigen::Vector3d Atb = Eigen::Vector3d::Zero();
    for (std::size_t i = 0; i < pairs.size(); ++i) {
      const Eigen::Matrix3d A = pairs[i].of_mount.rotation.matrix() - Eigen::Matrix3d::Identity();
      AtA += weights[i] * A.transpose() * A;
      Atb +=
          weights[i] * A.transpose() * (R * pairs[i].of_camera.translation - pairs[i].of_mount.translation);
    }
    const SymmetricEigen eigen(AtA);
    // What the turns do not determine stays at zero.
    constexpr double kDetermined = 1e-9;
    Eigen::Vector3d t = Eigen::Vector3d::Zero();
    for (int k = 0; k < 3; ++k) {
      if (!(eigen.eigenvalues()(k) > kDetermined * std::max(1e-12, eigen.eigenvalues()(2)))) continue;
      const Eigen::Vector3d axis = eigen.eigenvectors().col(k);
      t += axis.dot(Atb) / eigen.eigenvalues()(k) * axis;
    }
    form.mount_from_camera.translation = t;
    std::vector<double> sizes;
    for (const Pair& pair : pairs)
      sizes.push_back((pair.of_mount * t - R * pair.of_camera.translation - t).norm());
    weights = weightsOf(sizes);
  }
}

// The mean of the places of a board without those far from most.
SE3 placeOf(const std::vector<SE3>& places) {
  constexpr double kFar = 4;
  if (places.size() <= 2) return places.empty() ? SE3() : places.front();
  const auto from = [&places](const SE3& centre) {
    std::vector<double> sizes;
    for (const SE3& place : places) sizes.push_back((centre.inverse() * place).log().norm());
    return sizes;
  };
  const SE3* best = &places.front();
  double least = HUGE_VAL;
  constexpr std::size_t kMostTried = 50;
  for (std::size_t i = 0; i < places.size(); i += 1 + places.size() / kMostTried) {
    const double median = medianOf(from(places[i]));
    if (median < least) best = &places[i], least = median;
  }
  std::vector<SE3> near;
  const std::vector<double> sizes = from(*best);
  for (std::size_t i = 0; i < places.size(); ++i)
    if (sizes[i] <= kFar * least) near.push_back(places[i]);
  return near.empty() ? *best : meanPose(near).mean;
}

}  // namespace

SE3::Tangent leftOver(const ClosedForm& form, const SeenFrom& frame) {
  const SE3 predicted = form.mount_from_camera.inverse() * frame.motion * form.world_from_boards[frame.board];
  return (predicted.inverse() * frame.camera_from_board).log();
}

ClosedForm closedForm(std::span<const SeenFrom> frames, std::size_t num_boards) {
  ClosedForm form;
  const std::vector<Pair> pairs = pairsOf(frames);
  solveRotation(pairs, form);
  solveTranslation(pairs, form);
  std::vector<double> turns;
  std::vector<double> shares;
  const std::size_t num_parts = 1 + std::ranges::max(frames, {}, &SeenFrom::part).part;
  form.world_from_boards.resize(num_boards);
  for (std::size_t part = 0; part < num_parts; ++part) {
    for (std::size_t board = 0; board < num_boards; ++board) {
      std::vector<SE3> places;
      for (const SeenFrom& frame : frames) {
        if (frame.part == part && frame.board == board)
          places.push_back(frame.motion.inverse() * form.mount_from_camera * frame.camera_from_board);
      }
      if (!places.empty()) form.world_from_boards[board] = placeOf(places);
    }
    for (const SeenFrom& frame : frames) {
      if (frame.part != part) continue;
      const SE3::Tangent left = leftOver(form, frame);
      turns.push_back(left.tail<3>().norm());
      shares.push_back(left.head<3>().norm() / frame.camera_from_board.translation.norm());
    }
  }
  form.median_rad = medianOf(turns);
  form.median_share = medianOf(shares);
  return form;
}

}  // namespace alidade
