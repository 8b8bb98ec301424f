// SPDX-License-Identifier: MIT
#pragma once

#include <array>
#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "alidade/calibrate/calibrator.h"
#include "support/user_views.h"

namespace alidade {

/// What the corners of a set have besides noise.
enum class Trouble {
  kNone,
  kOutliers,   ///< 5 % of the corners are moved by 10 px, each in a direction of its own
  kBentBoard,  ///< the board is bent by 0.3 mm along one of its axes, to one side or the other; held flat
  kMotion,     ///< all corners of a view are displaced in one direction, by amounts that grow over the board
};
inline constexpr std::array kAllTroubles = {Trouble::kNone, Trouble::kOutliers, Trouble::kBentBoard,
                                            Trouble::kMotion};
[[nodiscard]] std::string_view troubleName(Trouble trouble);

/// A camera of 50 to 90 degrees (radtan) or 90 to 135 degrees (kannala_brandt), 12 to 30 views of a board of
/// 24 cm as someone takes them, noise of 0.1 px.
struct TroubledSet {
  DrawnCamera drawn;
  UserSet views;
};
[[nodiscard]] TroubledSet drawTroubledSet(std::string_view model, Trouble trouble, std::uint64_t seed);

/// Where the projection is looked at.
enum class Place { kCenter, kMid, kCorner };
inline constexpr std::array kAllPlaces = {Place::kCenter, Place::kMid, Place::kCorner};

/// The errors of one calibration beside what it said of them.
struct Judged {
  struct Parameter {
    double error = 0;
    double std = 0;           ///< by the corners' noise
    double std_by_views = 0;  ///< effective; NaN without
    double stated_std = 0;    ///< the one to go by
  };
  std::vector<Parameter> parameters;  ///< those that are estimated
  struct Projection {
    double error_px = 0;  ///< along the direction in which the stated one is largest
    double std_px = 0;
    double squared_sigmas = 0;  ///< error^T covariance^-1 error, 2 on average
  };
  std::array<Projection, 3> projections;  ///< at infinity, one a Place
  bool is_converged = false;
  bool is_noise_exceeded = false;
  double excess = 0;
};

/// Calibrates the set, with the board held flat where it is bent.
[[nodiscard]] Judged judgeSet(const TroubledSet& set, Trouble trouble);

/// Shares and moments over many sets; pooled over the parameters where `parameter` is -1.
struct Coverage {
  int count = 0;
  double mean = 0;     ///< of error / std
  double std = 0;      ///< of error / std
  double covered = 0;  ///< share of errors within 1.96 std
};
[[nodiscard]] Coverage coverageOf(const std::vector<Judged>& sets, double Judged::Parameter::*std,
                                  int parameter = -1);
[[nodiscard]] Coverage coverageOf(const std::vector<Judged>& sets, Place place);
/// Share of the sets in which the projection's error lies in its 95 % ellipse.
[[nodiscard]] double ellipseShare(const std::vector<Judged>& sets, Place place);

}  // namespace alidade
