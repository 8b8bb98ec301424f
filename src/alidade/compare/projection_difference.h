// SPDX-License-Identifier: MIT
#pragma once

#include <optional>
#include <vector>

#include <Eigen/Core>

#include "alidade/camera/any_camera.h"
#include "alidade/camera/freed.h"
#include "alidade/compare/image_match.h"
#include "alidade/core/image.h"
#include "alidade/geometry/dense_matrix.h"
#include "alidade/geometry/se3.h"

namespace alidade {

/// A camera that is compared, with what is known of its parameters.
struct ComparedCamera {
  const AnyCamera* camera = nullptr;
  ImageSize size;
  std::optional<DenseMatrix> covariance = std::nullopt;  ///< N x N in storage order; nothing: unknown
};

struct DifferenceOptions {
  /// What is taken out first; nothing: the frames are one.
  std::optional<Freed> freed = Freed::kRotation;
  /// Of the points from either camera, for Freed::kPose: positive and finite. Their sphere looks the same at
  /// any distance, so it scales the translation and nothing else.
  double distance_m = 1;
  /// Clockwise turn of image b against image a, 0 to 3. Nothing: none where the sizes allow that, otherwise
  /// the one of 1 and 3 that leaves less.
  std::optional<int> quarter_turns = std::nullopt;
  /// Of the grid over image a; 0: 40 along the longer side, in square cells. At least fewestPairs() in all
  /// where something is taken out.
  int columns = 0;
  int rows = 0;
  /// Pixels of image a to compare at instead of the grid.
  std::vector<Eigen::Vector2d> pixels = {};
};

/// How far apart two cameras put what they see.
///
/// All lengths are in pixels of the finer of the two images, along a's axes.
struct ProjectionDifference {
  ImageMatch match;
  /// What was taken out: metres; without translation unless a pose was freed.
  SE3 b_from_a;
  bool is_converged = false;  ///< if not, nothing below says how far apart the cameras are
  int columns = 0;            ///< of the grid; 0 for pixels that were given
  int rows = 0;
  std::vector<Eigen::Vector2d> pixels;  ///< of image a
  /// One a pixel: where b puts a point less where a puts it. NaN where they cannot be compared.
  std::vector<Eigen::Vector2d> difference_px;
  std::vector<double> weights;  ///< one a pixel: how much it counted for what was taken out
  int num_compared = 0;
  /// Pixels for which one camera has a ray, and the other has none, no pixel, or one that is farther off than
  /// the finer image's diagonal.
  int num_seen_by_one = 0;
  int num_seen_by_neither = 0;
  double mean_px = 0;  ///< of the lengths of the differences; these and those below NaN if there are none
  double rms_px = 0;
  double p95_px = 0;  ///< 95 % are at most as long
  double max_px = 0;
  Eigen::Vector2d worst_pixel{0, 0};  ///< of image a

  [[nodiscard]] double lengthAt(std::size_t i) const { return difference_px[i].norm(); }
};

/// Compares two cameras of any models, of images of one shape.
///
/// A point in the direction of pixel q through camera a is compared with where b puts it, once b has been
/// turned (or moved) as suits best; and a point in the direction of the same place through camera b with
/// where a puts it. The difference is half of the first less half of the second, which are opposite to first
/// order, and the best turn is the one for which the sum of squares of both over all pixels is least: see
/// alignRays(). So exchanging the cameras gives the inverse motion and the same lengths.
///
/// What one of the cameras puts farther from there than the finer image's diagonal is an extrapolation of its
/// formula far outside its image, and counts neither for the turn nor for the figures: such a pixel is seen
/// by one camera only.
///
/// Each pixel counts alike, as an error does to whoever looks at the whole image, unless covariances say that
/// it is known badly: then by 1 / (variance of the difference + (0.1 px)^2). A corner of the image in which
/// no board was ever seen would otherwise turn the rest.
///
/// The idea of comparing after the best transformation, weighted by the uncertainties, is that of mrcal's
/// projection difference (Kogan, mrcal.secretsauce.net, "Projection differences").
///
/// @throws Error (kInput) for images of different shape; (kUsage) for a turn that the sizes do not allow, a
/// distance that is not positive and finite, a grid of negative numbers, or one of too few pixels to find
/// what is taken out
[[nodiscard]] ProjectionDifference projectionDifference(const ComparedCamera& a, const ComparedCamera& b,
                                                        const DifferenceOptions& options = {});

}  // namespace alidade
