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

/// How a unit differs from the typical camera of its group, or from its previous calibration. Lengths are in
/// pixels, after the alignment.
struct UnitDifference {
  std::size_t unit = 0;        ///< index into FleetFiles::units
  std::string previous = {};   ///< file of the previous calibration; empty for the typical camera
  bool is_comparable = false;  ///< if not, the values below mean nothing
  double p95_px = 0;           ///< 95 % of the image differs by at most this
  double max_px = 0;
  double expected_rms_px = std::numeric_limits<double>::quiet_NaN();  ///< that the uncertainties predict
  /// The difference in standard deviations, as a normal variable; NaN: it cannot be told.
  double sigmas = std::numeric_limits<double>::quiet_NaN();
  /// Whether it exceeds chance, by the test of all units of the fleet together; see kFalseShare.
  bool is_significant = false;
};

/// Of the units that are said to deviate, and of those that are said to have drifted, at most this share is
/// expected to be false; where there are none, it is the chance that any unit of the fleet is accused.
inline constexpr double kFalseShare = 0.01;

/// The camera that stands for the units of one model and image size.
struct TypicalCamera {
  AnyCamera camera;
  Population population;      ///< is_member: one per unit of `FleetGroup::units` that has this model
  std::size_t num_units = 0;  ///< of this model
  std::size_t num_without_covariance = 0;  ///< of these: treated as exact
  /// Outliers can be told from so many units; with fewer no unit is said to deviate.
  bool can_judge = false;
};

/// Where in the image the units differ from the typical camera.
struct FleetMap {
  int columns = 0;
  int rows = 0;
  std::vector<Eigen::Vector2d> pixels = {};
  std::vector<double> p95_px = {};  ///< 95 % of the units are within this distance; NaN: none sees it
  std::vector<double> median_px = {};
};

/// The units of one image size.
struct FleetGroup {
  ImageSize size;
  std::vector<std::size_t> units = {};  ///< indices, in order
  /// Of the model that most of them have; nothing with fewer than kFewestUnits of it.
  std::optional<TypicalCamera> typical = {};
  std::vector<UnitDifference> differences = {};  ///< one per unit, from the typical camera; none without it
  double p95_px = std::numeric_limits<double>::quiet_NaN();     ///< 95 % of the units differ by at most this
  double median_px = std::numeric_limits<double>::quiet_NaN();  ///< half of them
  std::size_t num_within = 0;  ///< units that differ by at most the tolerance
  FleetMap map = {};

  [[nodiscard]] std::size_t numDeviating() const;
};
inline constexpr std::size_t kFewestUnits = 3;

struct Fleet {
  FleetFiles files;
  std::vector<FleetGroup> groups;           ///< the largest first
  std::vector<UnitDifference> drifts = {};  ///< in the order of the units; of those with a previous one
  std::size_t num_unpaired = 0;             ///< units without one, if there are previous calibrations at all
  bool has_previous = false;
  std::vector<UnreadableFile> unreadable_previous = {};
  double tolerance_px = 1;

  [[nodiscard]] std::size_t numDeviating() const;
  [[nodiscard]] std::size_t numDrifted() const;
  [[nodiscard]] std::size_t count(std::optional<Verdict> verdict) const;
};

/// Analyses a population of cameras.
///
/// Units are grouped by their image size. Those of the most frequent model of a group are treated as a sample
/// of a normal population of parameters (estimatePopulation()); its mean is the typical camera. Each unit of
/// the group, of any model, is compared with it by the projection difference. A unit deviates if its
/// difference is larger than its own covariance and the spread between units explain: Wald's statistic of
/// significanceOf(), with the F distribution for the spread that was itself estimated, and all units tested
/// together (falseDiscoveryTest()). A unit that states no covariance is treated as exact, so that its
/// errors count as spread.
///
/// Drift is the difference of a unit from its previous calibration, by both covariances. Units are paired by
/// serial number, else by name, else by the place of the file in its folder, wherever these are unique.
/// @param previous  earlier calibrations; nothing: drift is not asked for
/// @throws Cancelled
[[nodiscard]] Fleet analyseFleet(FleetFiles files, const std::optional<FleetFiles>& previous = {},
                                 const FleetOptions& options = {});

/// The typical camera as a record. Its covariance is that of a unit that is not known better: the spread
/// between units and the uncertainty of the mean. Its accuracy is FleetGroup::p95_px; beyond
/// the tolerance it is usable with reservations.
/// @pre the group has a typical camera
[[nodiscard]] CameraRecord typicalRecord(const FleetGroup& group, double tolerance_px,
                                         std::string created_by);

}  // namespace alidade
