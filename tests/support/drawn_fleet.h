// SPDX-License-Identifier: MIT
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include <Eigen/Core>

#include "alidade/core/random.h"
#include "alidade/record/camera_record.h"

namespace alidade {

/// A population of `radtan` cameras of 1280x960 px, from which units are drawn as their files would have
/// them.
class CameraPopulation {
 public:
  CameraPopulation();

  [[nodiscard]] const AnyCamera& mean() const { return mean_; }
  [[nodiscard]] const Eigen::MatrixXd& between() const { return between_; }
  [[nodiscard]] ImageSize size() const { return {.width = 1280, .height = 960}; }

  /// The true parameters of a unit.
  [[nodiscard]] Eigen::VectorXd drawUnit(Random& random) const;
  /// A calibration of a unit: its parameters with an error, and the covariance of that error, which is
  /// `noise_px` squared times that of a calibration with noise of 1 px.
  [[nodiscard]] CameraRecord calibrated(const Eigen::VectorXd& unit, double noise_px, Random& random) const;
  /// So many units, each calibrated once, with noise of 0.05 to 0.2 px.
  [[nodiscard]] std::vector<CameraRecord> drawFleet(std::size_t count, std::uint64_t seed) const;

 private:
  AnyCamera mean_;
  Eigen::MatrixXd between_;
  Eigen::MatrixXd root_;        // root_ root_^T = between_
  Eigen::MatrixXd unit_noise_;  // covariance of a calibration with noise of 1 px
  Eigen::MatrixXd unit_root_;
};

/// The same unit with another focal length, so that points move by `px` in the corners of the image (more
/// than that nowhere), the rotation taken out.
[[nodiscard]] Eigen::VectorXd withFocalError(const Eigen::VectorXd& unit, ImageSize size, double px);

}  // namespace alidade
