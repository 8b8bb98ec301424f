// SPDX-License-Identifier: MIT
#pragma once

#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include <Eigen/Core>

#include "alidade/camera/any_camera.h"
#include "alidade/camera/projection_uncertainty.h"
#include "alidade/compare/image_match.h"
#include "alidade/core/image.h"
#include "alidade/geometry/dense_matrix.h"
#include "alidade/geometry/se3.h"

namespace alidade {

/// A camera to compare, with the covariance of its parameters.
struct ComparedCamera {
  const AnyCamera* camera = nullptr;
  ImageSize size;
  std::optional<DenseMatrix> covariance = std::nullopt;  ///< N x N in storage order; empty: unknown
};

struct DifferenceOptions {
  /// Motion to align first; empty: both cameras have the same frame.
  std::optional<Freed> freed = Freed::kRotation;
  /// Distance of the points from either camera for Freed::kPose, positive and finite. Their sphere looks the
  /// same at any distance, so it only scales the translation.
  double distance_m = 1;
  /// Clockwise quarter turns of image b relative to image a, 0 to 3. Default: 0 if the sizes allow it,
  /// otherwise 1 or 3, depending on which gives the smaller difference.
  std::optional<int> quarter_turns = std::nullopt;
  /// Size of the grid over image a; 0: 40 along the longer side, in square cells. With alignment, at least
  /// fewestPairs() pixels in total.
  int columns = 0;
  int rows = 0;
  /// Pixels of image a to compare instead of the grid.
  std::vector<Eigen::Vector2d> pixels = {};
};

/// The projection difference of two cameras.
///
/// All lengths are in pixels of the finer of the two images, along a's axes.
struct ProjectionDifference {
  ImageMatch match;
  /// The alignment, in metres; without translation unless the pose was aligned.
  SE3 b_from_a;
  bool is_converged = false;  ///< if not, the values below are meaningless
  int columns = 0;            ///< of the grid; 0 for pixels that were given
  int rows = 0;
  std::vector<Eigen::Vector2d> pixels;  ///< of image a
  /// One per pixel: the projection by b minus the projection by a. NaN if they cannot be compared.
  std::vector<Eigen::Vector2d> difference_px;
  std::vector<double> weights;  ///< one per pixel: its weight in the alignment
  int num_compared = 0;
  /// Pixels for which one camera has a ray, and the other has no ray, no pixel, or a pixel farther away than
  /// the diagonal of the finer image.
  int num_seen_by_one = 0;
  int num_seen_by_neither = 0;
  double mean_px = 0;  ///< mean length; NaN, like the values below, if num_compared is 0
  double rms_px = 0;
  double p95_px = 0;  ///< 95th percentile of the lengths
  double max_px = 0;
  Eigen::Vector2d worst_pixel{0, 0};  ///< of image a

  [[nodiscard]] double lengthAt(std::size_t i) const { return difference_px[i].norm(); }
};

/// Compares two cameras of any models whose images have the same shape.
///
/// A point in the direction of pixel q through camera a is compared with its projection by b after the best
/// rotation (or pose) of b. A point in the direction of the same place through camera b is compared with its
/// projection by a. The two are opposite to first order, so the difference is half of the first minus half of
/// the second. The best alignment minimises the sum of squares of both over all pixels; see alignRays().
/// Swapping the cameras therefore gives the inverse motion and the same lengths.
///
/// A projection farther away than the diagonal of the finer image is an extrapolation far outside the image.
/// Such a pixel counts as seen by only one camera and affects neither the alignment nor the statistics.
///
/// All pixels have equal weight, unless there are covariances; then the weight is 1 / (variance of the
/// difference + (0.1 px)^2). Otherwise an image corner without board corners would distort the alignment of
/// the rest.
///
/// The comparison after the best transformation, weighted by the uncertainties, follows mrcal's projection
/// difference (Kogan, mrcal.secretsauce.net, "Projection differences").
///
///
/// @throws Error (kInput) for images of different shape; (kUsage) for a rotation that the sizes do not allow,
/// a distance that is not positive and finite, a grid of negative numbers, or one with too few pixels for the
/// alignment
[[nodiscard]] ProjectionDifference projectionDifference(const ComparedCamera& a, const ComparedCamera& b,
                                                        const DifferenceOptions& options = {});

/// Tells whether a difference is larger than the uncertainty of the two cameras explains.
struct DifferenceSignificance {
  /// One per pixel, px: standard deviation of the difference along the direction in which it is largest; NaN
  /// where there is no difference.
  std::vector<double> std_px;
  double expected_rms_px = 0;  ///< RMS difference that the covariances predict
  /// The difference in standard deviations: the value that a normal variable exceeds as often as Wald's
  /// statistic, the sum of squares below, is exceeded by chance.
  double sigmas = 0;
  /// Squared difference in standard deviations, summed over all directions in which the cameras' uncertainty
  /// moves it, and its expected value, the number of directions, each with its weight.
  double squares = 0;
  double directions = 0;
  /// The part of p95_px that chance does not explain: p95 between a and the nearest camera on the way to b
  /// that differs from b by chance in only 1 of 1000 cases. 0 if not significant.
  double sure_p95_px = 0;
  double share_beyond = 0;  ///< share of compared pixels outside their 95 % ellipse; 0.05 by chance

  /// True if chance exceeds it in less than 1 of 1000 cases.
  [[nodiscard]] bool isSignificant() const;
};

/// Propagates the covariances of both cameras to the difference (differenceFactor). A camera without
/// covariance is assumed to be exact; nothing if neither has one.
[[nodiscard]] std::optional<DifferenceSignificance> significanceOf(const ProjectionDifference& difference,
                                                                   const ComparedCamera& a,
                                                                   const ComparedCamera& b,
                                                                   std::optional<Freed> freed);

/// Largest error or difference (95 %) of a camera that is not called wrong, px; docs/comparing.md derives it.
inline constexpr double kDefaultTolerancePx = 0.2;

/// Projecting one camera twice differs by less, px.
inline constexpr double kEqualPx = 1e-9;

/// The result of comparing a difference with a tolerance.
enum class Agreement {
  kWithin,         ///< 95 % of the image agrees within the tolerance
  kBeyond,         ///< it does not, and uncertainty does not explain the difference
  kUncertain,      ///< neither is sure
  kNotComparable,  ///< too much of the image is seen by only one of the cameras
};

/// Compares the 95th percentile of the difference with the tolerance, because a tolerance applies to the
/// image and not to its worst pixel. A larger difference is kBeyond if it is significant, a smaller one is
/// kWithin. Where the uncertainties predict more than the tolerance (RMS), the part that is surely real must
/// exceed it, and only copies, which agree far better than two estimates can, are kWithin. If the
/// significance is unknown, the cameras are assumed to be exact.
[[nodiscard]] Agreement agreementOf(const ProjectionDifference& difference,
                                    const std::optional<DifferenceSignificance>& significance,
                                    double tolerance_px);

/// The answer in a word or two, for people: "same", "changed" or "cannot tell".
[[nodiscard]] std::string_view answerOf(Agreement agreement);

/// The numbers behind the answer: "the cameras differ by 0.12 px (95 %); limit 0.2 px".
[[nodiscard]] std::string agreementText(const ProjectionDifference& difference,
                                        const std::optional<DifferenceSignificance>& significance,
                                        double tolerance_px);

/// True if enough of the image could be compared to judge it as a whole.
[[nodiscard]] bool isComparable(const ProjectionDifference& difference);

/// The part of the larger of two images that the smaller one may show.
struct CropSuspicion {
  bool is_a_larger = false;
  double focal_a_px = 0;  ///< at the image centre: geometric mean of both axes
  double focal_b_px = 0;
  ImageSize part;                         ///< in the larger image
  std::optional<Eigen::Vector2i> corner;  ///< from the principal points; nothing: unknown
};

/// Images of the same shape but different sizes are assumed to be resized. If the sides differ by more than a
/// tenth, but the focal lengths in pixels by at most 2 %, one image is probably a crop of the other: resizing
/// changes both, but cropping changes only the sides.
///
///
/// @returns nothing if there is no such suspicion
[[nodiscard]] std::optional<CropSuspicion> suspectCrop(const ComparedCamera& a, const ComparedCamera& b,
                                                       const ImageMatch& match);

}  // namespace alidade
