// SPDX-License-Identifier: MIT
#pragma once

#include <optional>

#include <Eigen/Core>

namespace alidade {

/// The inverse of a symmetric matrix, and how near it is to having none.
struct ScaledInverse {
  /// Ratio of the smallest to the largest eigenvalue after scaling the diagonal to 1, at least 0; 0 where an
  /// element of the diagonal is not positive.
  double condition = 0;
  std::optional<Eigen::MatrixXd> inverse;  ///< nothing where the matrix is singular to working precision
};

/// Scales the diagonal to 1 first, so that parameters of any unit compare.
/// @param singular  the condition up to which what looks like an eigenvalue is rounding
[[nodiscard]] ScaledInverse scaledInverse(const Eigen::MatrixXd& matrix, double singular = 1e-13);

}  // namespace alidade
