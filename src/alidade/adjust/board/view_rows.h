// SPDX-License-Identifier: MIT
#pragma once

#include <array>
#include <cstddef>
#include <span>
#include <string_view>

#include <Eigen/Core>

#include "alidade/adjust/board/corner_groups.h"
#include "alidade/adjust/board/elimination.h"
#include "alidade/core/lanes.h"
#include "alidade/geometry/se3.h"

namespace alidade::detail {

/// The columns of a corner's two rows [J r]. Most are in both rows: the pose (its tangent: translation,
/// rotation), the lens and, last, the error. They are followed by the columns of one axis, its focal length
/// and principal point; those of the other axis are zero and left out. A parameter that moves both
/// coordinates of a pixel belongs among the shared columns.
struct RowLayout {
  static constexpr std::size_t kPose = 6;
  static constexpr std::size_t kOwn = 2;

  constexpr explicit RowLayout(std::size_t num_lens)
      : num_shared(kPose + num_lens + 1), width(num_shared + kOwn), size(num_shared + 4) {
    for (std::size_t axis = 0; axis < 2; ++axis) {
      for (std::size_t c = 0; c < num_shared - 1; ++c) column[axis][c] = c < kPose ? c : c + 4;
      column[axis][num_shared - 1] = size - 1;
      column[axis][num_shared] = kPose + axis;
      column[axis][num_shared + 1] = kPose + axis + 2;
    }
  }

  std::size_t num_shared;
  std::size_t width;
  std::size_t size;  ///< of both axes together: pose, parameters, error
  std::array<std::array<std::size_t, kMaxColumns>, 2>
      column{};  ///< index in the full set, of each column in a row of u and of v
};

/// Number of groups whose rows fit into the L1 cache, and the largest number of lanes in these rows.
inline constexpr std::size_t kChunk = 24;
inline constexpr std::size_t kMaxChunkRows = 2 * kChunk * kMaxColumns;

/// Calls f(chunk) for each chunk in order, until it returns false.
template <class F>
bool forEachChunk(std::span<const CornerGroup> corners, const F& f) {
  for (; corners.size() > kChunk; corners = corners.subspan(kChunk)) {
    if (!f(corners.first(kChunk))) return false;
  }
  return f(corners);
}

/// Rows of Jacobian and error of corners that are points, for one camera model; several at a time.
class ViewRows {
 public:
  virtual ~ViewRows() = default;

  [[nodiscard]] virtual const RowLayout& layout() const = 0;

  /// Writes both rows of each corner, u first, 2 layout().width lanes per group, times the square roots of
  /// its weight and of the loss weight, and adds its rho. Corners that do not project (behind the camera,
  /// beyond a pole, or beyond a fold of the lens) get zeros; false if there are any.
  virtual bool write(const double* params, const SE3& camera_from_board, std::span<const CornerGroup> groups,
                     HuberLoss loss, Lanes* rows, Lanes& sum_rho) const = 0;

  /// Writes the errors in u and v of each group, px, not weighted; NaN for a corner that does not project.
  virtual void writeErrors(const double* params, const SE3& camera_from_board,
                           std::span<const CornerGroup> groups, Lanes* errors) const = 0;

  /// Same as ViewKernel::errors() and rows(), for points.
  void errors(const double* params, const SE3& camera_from_board, std::span<const CornerGroup> corners,
              std::span<Eigen::Vector2d> errors) const;
  void rows(const double* params, const SE3& camera_from_board, std::span<const CornerGroup> corners,
            std::span<double> rows) const;
};

/// The rows of a known model.
[[nodiscard]] const ViewRows& viewRows(std::string_view model_id);

/// The loss and weights for a group's errors.
struct GroupLoss {
  ALIDADE_ALWAYS_INLINE GroupLoss(const Lanes* px, const CornerGroup& group, HuberLoss loss)
      : root(lane::load(group.root_weight.data())) {
    const Lanes s = root * root * (px[0] * px[0] + px[1] * px[1]);
    rho = s;
    const double threshold = loss.threshold_px;
    const LaneMask is_far = s > threshold * threshold;
    if (!lane::isAny(is_far)) return;
    // HuberLoss, in lanes.
    const Lanes length = lane::squareRoot(s);
    rho = lane::select(is_far, 2 * threshold * length - threshold * threshold, s);
    root = lane::select(is_far, root * lane::squareRoot(Lanes(threshold / length)), root);
  }
  Lanes root;  ///< square root of the weight times that of the loss weight
  Lanes rho;
};

}  // namespace alidade::detail
