// SPDX-License-Identifier: MIT
#pragma once

#include <cstddef>
#include <limits>
#include <optional>
#include <string>
#include <vector>

#include <Eigen/Core>

#include "alidade/fleet/fleet_unit.h"
#include "alidade/fleet/population.h"

namespace alidade {

/// Difference between two cameras. Lengths are in pixels, after the alignment.
struct UnitDifference {
  bool is_comparable = false;  ///< if not, the values below mean nothing
  double p95_px = 0;           ///< 95 % of the image differs by at most this
  double max_px = 0;
  double expected_rms_px = std::numeric_limits<double>::quiet_NaN();  ///< predicted by the uncertainties
  /// The difference in standard deviations, as a normal variable; NaN if undetermined.
  double sigmas = std::numeric_limits<double>::quiet_NaN();
  /// True if it exceeds chance, by the test of all units of the fleet together; see kFalseShare.
  bool is_significant = false;
};

/// The expected share of false reports among the units reported as deviating, and among those reported as
/// drifted, is at most this. If none deviates, it is the chance of any false report in the fleet.
inline constexpr double kFalseShare = 0.01;

/// The camera that represents the units of one model and image size.
struct TypicalCamera {
  AnyCamera camera;
  Population population;      ///< is_member: one per unit of `FleetGroup::units` that has this model
  std::size_t num_units = 0;  ///< of this model
  std::size_t num_without_covariance = 0;  ///< of these: treated as exact
  /// True if there are enough units to detect outliers; otherwise no unit is reported as deviating.
  bool can_judge = false;
};

/// Map over the image of the differences between units and typical camera.
struct FleetMap {
  int columns = 0;
  int rows = 0;
  std::vector<Eigen::Vector2d> pixels = {};
  std::vector<double> p95_px = {};  ///< 95 % of the units are within this distance; NaN if none sees it
  std::vector<double> median_px = {};
};

/// The units of one image size.
struct FleetGroup {
  ImageSize size;
  std::vector<std::size_t> units = {};  ///< indices, in order
  /// For the most frequent model; nothing with fewer than kFewestUnits units of it.
  std::optional<TypicalCamera> typical = {};
  std::vector<UnitDifference> differences = {};  ///< one per unit, from the typical camera; none without it
  double p95_px = std::numeric_limits<double>::quiet_NaN();     ///< 95 % of the units differ by at most this
  double median_px = std::numeric_limits<double>::quiet_NaN();  ///< half of them
  std::size_t num_within = 0;  ///< units that differ by at most the tolerance
  FleetMap map = {};

  [[nodiscard]] std::size_t numDeviating() const;
};
inline constexpr std::size_t kFewestUnits = 3;

/// A unit and its previous calibration.
struct UnitDrift {
  std::size_t unit = 0;
  std::string previous;     ///< its file
  std::string reason = {};  ///< reason why they cannot be compared; empty if they can
  UnitDifference difference = {};
};

struct Fleet {
  FleetFiles files;
  std::vector<FleetGroup> groups;      ///< largest first
  std::vector<UnitDrift> drifts = {};  ///< in the order of the units, only those with a previous calibration
  std::size_t num_unpaired = 0;        ///< units without a previous calibration, if any were given
  bool has_previous = false;
  std::vector<UnreadableFile> unreadable_previous = {};
  double tolerance_px = 1;

  [[nodiscard]] std::size_t numDeviating() const;
  [[nodiscard]] std::size_t numDrifted() const;
  [[nodiscard]] std::size_t count(std::optional<Verdict> verdict) const;
};

/// Analyses a population of cameras.
///
/// Units are grouped by image size. Units of the most frequent model of a group are treated as a sample of a
/// normal population of parameters (estimatePopulation()); its mean is the typical camera. Each unit of the
/// group, of any model, is compared with it by the projection difference. A unit deviates if its own
/// covariance and the spread between units do not explain its difference: Wald's statistic of
/// significanceOf(), with the F distribution because the spread is an estimate, and all units tested together
/// (falseDiscoveryTest()). A unit without a stated covariance is treated as exact, so that its errors count
/// as spread.
///
/// Drift is the difference of a unit from its previous calibration, by both covariances. Units are paired by
/// serial number, else by name, else by the place of the file in its folder, if these are unique.
/// @param previous  earlier calibrations; nothing if drift is not requested
/// @throws Cancelled
[[nodiscard]] Fleet analyseFleet(FleetFiles files, const std::optional<FleetFiles>& previous = {},
                                 const FleetOptions& options = {});

/// The typical camera as a record. Its covariance applies to an uncalibrated unit: the spread between units
/// plus the uncertainty of the mean. Its accuracy is FleetGroup::p95_px; if that exceeds the tolerance, the
/// camera is usable with reservations.
/// @pre the group has a typical camera
[[nodiscard]] CameraRecord typicalRecord(const FleetGroup& group, double tolerance_px,
                                         std::string created_by);

}  // namespace alidade
