// SPDX-License-Identifier: MIT
#pragma once

#include <optional>
#include <vector>

#include <Eigen/Core>

#include "alidade/camera/any_camera.h"
#include "alidade/camera/freed.h"
#include "alidade/core/image.h"
#include "alidade/geometry/dense_matrix.h"

namespace alidade {

/// One standard deviation of the pixel at which a fixed point appears, all over an image.
struct UncertaintyGrid {
  int columns = 0;
  int rows = 0;
  std::vector<Eigen::Vector2d> pixels;  ///< row by row
  /// One a pixel, px: along the direction in which it is largest. NaN where the pixel has no ray.
  std::vector<double> std_px;
  double center_px = 0;  ///< at the image's centre; NaN if it has no ray
  double worst_px = 0;   ///< the largest of the grid; NaN if no pixel has a ray, or the covariance has NaN
  Eigen::Vector2d worst_pixel{0, 0};  ///< where
};

/// Carries a covariance of a camera's parameters to the pixels: how far the pixel of a fixed point of the
/// scene, a given distance away, may be off.
///
/// A change of the parameters can look like a turn of the camera, and every use of a camera fits its
/// orientation anyway. So what counts is what is left of the change after the rotation (or the pose) that
/// best undoes it: A(q) = J_params(q) - J_rot(q) W, with J_rot W the least-squares fit, in pixels and to
/// first order, of the rotation to J_params over all pixels of a grid over the image that have a ray; then
/// cov(q) = A(q) cov(params) A(q)^T.
///
/// The idea is that of "projection uncertainty" in mrcal's documentation (Kogan, mrcal.secretsauce.net,
/// "Projection uncertainty"), which takes the rotation and translation from how the calibration's own board
/// poses move on average. Here they are those that fit best over the image, so that nothing but the camera
/// and its covariance is needed, and a pixel far from all boards counts as much as one amid them.
///
/// Points on a sphere about the camera look the same from a sphere of any size: with Freed::kPose the result
/// is the same for every finite distance, and with Freed::kRotation it is that at infinity.
class ProjectionUncertainty {
 public:
  static constexpr int kDefaultColumns = 40;

  /// @param distance_m  of the points from the camera, positive; may be infinite
  /// @param freed       nothing: the rotation at infinity, the pose at a finite distance
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

  /// A(q), 2 x parameters: the change of the pixel by the parameters, px per unit; zero without a ray.
  /// Valid as long as this object lives.
  [[nodiscard]] Eigen::Map<const Eigen::Matrix<double, 2, Eigen::Dynamic, Eigen::RowMajor>> jacobian(
      int i) const;

  /// Covariance of the pixel of grid pixel i, px^2; NaN where it has no ray.
  /// @param parameter_covariance  N x N in storage order
  [[nodiscard]] UnalignedMatrix2d covariance(int i, const Eigen::MatrixXd& parameter_covariance) const;

  [[nodiscard]] UncertaintyGrid grid(const Eigen::MatrixXd& parameter_covariance) const;

  struct Worst {
    double std_px = 0;  ///< as UncertaintyGrid::worst_px
    int index = -1;     ///< of the grid pixel; -1 if there is none
  };
  /// The largest standard deviation of the grid without the rest of it; nothing is allocated.
  [[nodiscard]] Worst worst(const Eigen::MatrixXd& parameter_covariance) const;

 private:
  // Calls f(i, covariance) for pixels of the grid; the one after the last is the image's centre.
  template <class F>
  void forEachCovariance(Eigen::Index first, Eigen::Index end, const Eigen::MatrixXd& parameter_covariance,
                         F&& f) const;

  int columns_ = 0;
  int rows_ = 0;
  std::vector<Eigen::Vector2d> pixels_;
  std::vector<bool> has_ray_;
  bool center_has_ray_ = false;
  // A(q)^T, two columns a pixel of the grid, and two more for the image's centre.
  DenseMatrix jacobians_;
};

}  // namespace alidade
