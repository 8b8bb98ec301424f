// SPDX-License-Identifier: MIT
#pragma once

#include <optional>
#include <span>
#include <vector>

#include <Eigen/Core>

#include "alidade/camera/any_camera.h"
#include "alidade/core/image.h"
#include "alidade/geometry/dense_matrix.h"

namespace alidade {

struct CorrectionGrid;

/// Pose parameters that users of a camera estimate themselves. Equivalent errors of the camera parameters are
/// harmless.
enum class Freed {
  kRotation,  ///< the camera's orientation
  kPose,      ///< orientation and position
};

/// Change of the pixels of fixed scene points with a camera's parameters, to first order, after alignment by
/// the rotation (or pose) that best undoes the change over all `pixels`: A(q) = J_params(q) - J_freed(q) W,
/// with J_freed W the least-squares fit, in pixels, of J_freed to J_params over those of the pixels that have
/// a ray.
struct AlignedJacobians {
  /// A(q)^T, N x 2 (pixels + others): two columns per pixel, px per unit; zero where a pixel has no ray.
  DenseMatrix transposed;
  std::vector<bool> has_ray;  ///< one per pixel, then one for each of the others
};

/// @param pixels  where the points are seen; the fit is over these
/// @param others  further pixels that do not take part in the fit
/// @param weights of the squared pixel changes in the fit, positive; empty: all equal
/// @param freed   nothing: no alignment, A = J_params
/// @param grid    of a CorrectionField, whose points count as further parameters; null: none
[[nodiscard]] AlignedJacobians alignedJacobians(
    const AnyCamera& camera, std::span<const Eigen::Vector2d> pixels, std::span<const Eigen::Vector2d> others,
    std::optional<Freed> freed, std::span<const double> weights = {}, const CorrectionGrid* grid = nullptr);

/// Standard deviation of the pixel of a fixed scene point, over the whole image.
struct UncertaintyGrid {
  int columns = 0;
  int rows = 0;
  std::vector<Eigen::Vector2d> pixels;  ///< row by row
  /// One per pixel, px: along the direction in which it is largest. NaN if the pixel has no ray.
  std::vector<double> std_px;
  double center_px = 0;  ///< at the image's centre; NaN if it has no ray
  double worst_px = 0;   ///< the largest of the grid; NaN if no pixel has a ray, or the covariance has NaN
  Eigen::Vector2d worst_pixel{0, 0};  ///< the pixel with worst_px
};

/// Propagates a covariance of the camera parameters to pixels: how uncertain the pixel of a fixed scene point
/// at a given distance is.
///
/// A change of the parameters can look like a rotation of the camera, and users of a camera estimate its
/// orientation anyway. Therefore only the change that remains after alignment by the best rotation (or pose)
/// counts: A(q) = J_params(q) - J_rot(q) W, with J_rot W the least-squares fit, in pixels and to first order,
/// of the rotation to J_params over all pixels of a grid over the image that have a ray; then cov(q) = A(q)
/// cov(params) A(q)^T.
///
/// The idea is that of "projection uncertainty" in mrcal's documentation (Kogan, mrcal.secretsauce.net,
/// "Projection uncertainty"), which takes the rotation and translation from the average motion of the board
/// poses of the calibration. Here they are the best fit over the image. This needs only the camera and its
/// covariance, and pixels far from all boards count as much as those among them.
///
/// Points on a sphere around the camera look the same for every radius. With Freed::kPose the result is
/// therefore the same for every finite distance, and with Freed::kRotation it is that at infinity.
class ProjectionUncertainty {
 public:
  static constexpr int kDefaultColumns = 40;

  /// @param distance_m  of the points from the camera, positive; may be infinite
  /// @param freed       default: the rotation at infinity, the pose at a finite distance
  /// @param columns     pixels across the image, the outermost ones on its border; the rows follow so that
  ///                    cells are square. At most as many as the image has
  /// @throws Error (kUsage): a distance that is not positive, a pose to free at infinity, fewer than 2
  /// columns
  ProjectionUncertainty(const AnyCamera& camera, ImageSize size, double distance_m,
                        std::optional<Freed> freed = std::nullopt, int columns = kDefaultColumns);

  [[nodiscard]] int columns() const { return columns_; }
  [[nodiscard]] int rows() const { return rows_; }
  [[nodiscard]] const std::vector<Eigen::Vector2d>& pixels() const { return pixels_; }
  [[nodiscard]] bool hasRay(int i) const { return has_ray_[static_cast<std::size_t>(i)]; }

  /// A(q), 2 x parameters: the change of the pixel by the parameters, px per unit; zero without a ray. Valid
  /// for the lifetime of this object.
  [[nodiscard]] Eigen::Map<const Eigen::Matrix<double, 2, Eigen::Dynamic, Eigen::RowMajor>> jacobian(
      int i) const;

  /// @param parameter_covariance  N x N in storage order
  [[nodiscard]] UncertaintyGrid grid(const Eigen::MatrixXd& parameter_covariance) const;

  struct Worst {
    double std_px = 0;  ///< same as UncertaintyGrid::worst_px
    int index = -1;     ///< index of the grid pixel; -1 if there is none
  };
  /// Only the largest standard deviation of the grid; allocates no memory.
  [[nodiscard]] Worst worst(const Eigen::MatrixXd& parameter_covariance) const;

 private:
  // Calls f(i, covariance) for the pixels of the grid; the last call is for the image centre.
  template <class F>
  void forEachCovariance(const Eigen::MatrixXd& parameter_covariance, F&& f) const;

  int columns_ = 0;
  int rows_ = 0;
  std::vector<Eigen::Vector2d> pixels_;
  std::vector<bool> has_ray_;
  bool center_has_ray_ = false;
  // A(q)^T, two columns per pixel of the grid, and two more for the image centre.
  DenseMatrix jacobians_;
};

}  // namespace alidade
