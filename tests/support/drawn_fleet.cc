// SPDX-License-Identifier: MIT
#include "support/drawn_fleet.h"

#include <cmath>

#include <Eigen/Cholesky>

#include "alidade/camera/projection_uncertainty.h"

namespace alidade {
namespace {

constexpr Eigen::Index kNumDrawn = 9;  // parameters of radtan

AnyCamera populationMean() {
  return AnyCamera::make("radtan",
                         std::vector<double>{1002, 1001.5, 641, 477, -0.21, 0.075, 6e-4, -4e-4, -0.012});
}

// What units of one type have in common by their making: both focal lengths change together, and the
// coefficients of the distortion make up for each other.
Eigen::MatrixXd populationRoot() {
  Eigen::MatrixXd root = Eigen::MatrixXd::Zero(kNumDrawn, kNumDrawn);
  root(0, 0) = 3.5;
  root(1, 0) = 3.5;
  root(1, 1) = 0.4;
  root(2, 2) = 5;
  root(3, 3) = 4;
  root(4, 0) = 5e-4;
  root(4, 4) = 2e-3;
  root(5, 4) = -3e-3;
  root(5, 5) = 1.5e-3;
  root(6, 6) = 1.2e-4;
  root(7, 7) = 1.2e-4;
  root(8, 5) = -1e-3;
  root(8, 8) = 8e-4;
  return root;
}

// Of 1000 corners all over the image whose poses are free to turn, and now and then are not.
Eigen::MatrixXd calibrationCovariance(const AnyCamera& camera, ImageSize size) {
  std::vector<Eigen::Vector2d> pixels;
  for (int y = 60; y < size.height; y += 35)
    for (int x = 40; x < size.width; x += 35) pixels.emplace_back(x, y);
  const auto informationOf = [&](std::optional<Freed> freed) -> Eigen::MatrixXd {
    const AlignedJacobians by_params = alignedJacobians(camera, pixels, {}, freed);
    return by_params.transposed.view() * by_params.transposed.view().transpose();
  };
  constexpr double kShareNotFree = 0.02;
  const Eigen::MatrixXd information =
      informationOf(Freed::kRotation) + kShareNotFree * informationOf(std::nullopt);
  // Scaled, as the units of the parameters differ.
  const Eigen::VectorXd scale = information.diagonal().cwiseSqrt().cwiseInverse();
  const Eigen::MatrixXd scaled = scale.asDiagonal() * information * scale.asDiagonal();
  return scale.asDiagonal() * scaled.llt().solve(Eigen::MatrixXd::Identity(kNumDrawn, kNumDrawn)) *
         scale.asDiagonal();
}

Eigen::VectorXd normalVector(Random& random) {
  Eigen::VectorXd z(kNumDrawn);
  for (double& value : z) value = random.normal();
  return z;
}

Eigen::MatrixXd rootByUnits(const Eigen::MatrixXd& covariance) {
  const Eigen::VectorXd scale = covariance.diagonal().cwiseSqrt();
  const Eigen::VectorXd inverse = scale.cwiseInverse();
  const Eigen::MatrixXd correlation = inverse.asDiagonal() * covariance * inverse.asDiagonal();
  return scale.asDiagonal() * Eigen::MatrixXd(correlation.llt().matrixL());
}

}  // namespace

CameraPopulation::CameraPopulation() : mean_(populationMean()), root_(populationRoot()) {
  between_ = root_ * root_.transpose();
  unit_noise_ = calibrationCovariance(mean_, size());
  unit_root_ = rootByUnits(unit_noise_);
}

Eigen::VectorXd CameraPopulation::drawUnit(Random& random) const {
  const auto values = mean_.parameters();
  return Eigen::Map<const Eigen::VectorXd>(values.data(), kNumDrawn) + root_ * normalVector(random);
}

CameraRecord CameraPopulation::calibrated(const Eigen::VectorXd& unit, double noise_px,
                                          Random& random) const {
  const Eigen::VectorXd found = unit + noise_px * unit_root_ * normalVector(random);
  CameraRecord record = bareRecord(AnyCamera::make("radtan", std::vector<double>(found.begin(), found.end())),
                                   size(), "a test");
  const Eigen::MatrixXd covariance = noise_px * noise_px * unit_noise_;
  CalibrationRecord stated;
  stated.accuracy_px = 2 * noise_px;
  stated.covered_share = 0.9;
  stated.num_views = 20;
  stated.num_corners = 1000;
  stated.rms_px = noise_px;
  stated.covariance = lowerTriangle(covariance);
  for (Eigen::Index j = 0; j < kNumDrawn; ++j) stated.parameter_std.push_back(std::sqrt(covariance(j, j)));
  record.calibration = stated;
  return record;
}

std::vector<CameraRecord> CameraPopulation::drawFleet(std::size_t count, std::uint64_t seed) const {
  std::vector<CameraRecord> records;
  for (std::size_t i = 0; i < count; ++i) {
    Random random(streamSeed(seed, i));
    const Eigen::VectorXd unit = drawUnit(random);
    records.push_back(calibrated(unit, random.uniform(0.05, 0.2), random));
  }
  return records;
}

Eigen::VectorXd withFocalError(const Eigen::VectorXd& unit, ImageSize size, double px) {
  const double half_diagonal = 0.5 * std::hypot(size.width, size.height);
  Eigen::VectorXd changed = unit;
  changed.head<2>() *= 1 + px / half_diagonal;
  return changed;
}

}  // namespace alidade
