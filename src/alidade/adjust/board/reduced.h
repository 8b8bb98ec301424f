// SPDX-License-Identifier: MIT
#pragma once

#include <array>
#include <cstddef>
#include <functional>
#include <span>
#include <string_view>
#include <utility>
#include <vector>

#include <Eigen/Core>

#include "alidade/adjust/board/fit.h"

namespace alidade {

/// The normal equations of one view with its pose eliminated (Schur complement): the information of the view
/// about the intrinsics and any further columns, with a free pose.
struct Reduced {
  Eigen::MatrixXd information;  ///< J^T W J, K x K for N parameters and K - N further columns, per px^2
  Eigen::VectorXd gradient;     ///< J^T W psi, where psi is the error times the loss weight; 0 over all views
                                ///< at the optimum, in the columns of free parameters
  double squares = 0;   ///< weighted sum of squared errors that no pose removes, px^2; with LossWeights::kUse
  int num_corners = 0;  ///< number of corners that project
};

/// Use of the loss weights in the information. The gradient always includes them.
enum class LossWeights {
  kLeaveOut,  ///< information of a fit without a loss
  kUse,       ///< information of iteratively reweighted least squares
};

/// A corner as the input of further columns. The Jacobians and the error of each axis include the square root
/// of the weight.
struct CornerRows {
  const Observation& corner;
  const SE3& camera_from_board;
  double root_weight;
  std::array<const double*, 2> J_px_pose;    ///< 6 for u, 6 for v: translation, rotation
  std::array<const double*, 2> J_px_params;  ///< N each
  std::array<double, 2> error;               ///< projected minus observed
};

/// Non-zero elements of the further columns in one row.
template <std::size_t kCount>
struct ExtraElements {
  std::array<int, kCount> column;
  std::array<double, kCount> value;  ///< including the square root of the corner's weight
};

/// Columns that are appended to the Jacobian after the intrinsics: derivatives of the corner's pixel with
/// respect to unknowns other than pose and intrinsics. Few of them are non-zero in any row.
struct ExtraColumns {
  ExtraColumns() = default;  ///< none
  /// @param columns  with size() and elements(rows, axis), which returns ExtraElements
  template <class Columns>
  requires requires(const Columns& columns, const CornerRows& rows) { columns.elements(rows, 0).column; }
  ExtraColumns(const Columns& columns)
      : size(columns.size()),
        addElements([columns](const CornerRows& rows, int axis, std::vector<std::pair<int, double>>& to) {
          const auto elements = columns.elements(rows, axis);
          for (std::size_t i = 0; i < elements.column.size(); ++i)
            to.emplace_back(elements.column[i], elements.value[i]);
        }) {}

  int size = 0;
  /// Appends columns and values of the non-zero elements of a row.
  std::function<void(const CornerRows& rows, int axis, std::vector<std::pair<int, double>>& to)> addElements;
};

/// Number of columns for the BoardShape of a board, after those of the intrinsics.
inline constexpr int kNumBends = 2;

/// bend_x and bend_y of the shapes of boards as additional columns, for the views of one board.
/// @param board        of the view; null if its bend is not among the columns
/// @param first        its first column
/// @param num_columns  of all boards
[[nodiscard]] ExtraColumns bendColumns(const Board* board, int first = 0, int num_columns = kNumBends);

namespace detail {

/// Sums of products of the columns of a view: pose, parameters, additional ones, error.
struct ViewGram {
  Eigen::MatrixXd lower;  ///< triangle; zero above the diagonal
  /// With PointShifts::kInclude, three rows per corner that projects: shifts of its point on the board, with
  /// all columns. The first three columns are also those with itself.
  Eigen::MatrixXd points;
  std::vector<int> ids = {};  ///< of these corners
  double sum_of_rho = 0;
  int num_corners = 0;  ///< number of corners that project
};

enum class PointShifts { kLeaveOut, kInclude };

/// Corners that do not project are skipped.
[[nodiscard]] ViewGram gramOf(std::string_view model_id, std::span<const double> params,
                              const SE3& camera_from_board, std::span<const Observation> view, HuberLoss loss,
                              LossWeights weights, const ExtraColumns& extra = {},
                              PointShifts shifts = PointShifts::kLeaveOut);

}  // namespace detail

/// The equations of one view with its pose eliminated and the bend of a flexible board held. Corners that do
/// not project are skipped.
[[nodiscard]] Reduced reducedByPose(const Fit& fit, const FitView& view, LossWeights weights,
                                    const ExtraColumns& extra = {});

/// The same with the bend of a flexible board eliminated as well.
[[nodiscard]] Reduced reduced(const Fit& fit, const FitView& view, LossWeights weights,
                              const ExtraColumns& extra = {});

/// One per view, in the order of the views.
[[nodiscard]] std::vector<Reduced> reduced(const Fit& fit, LossWeights weights,
                                           const ExtraColumns& extra = {});

}  // namespace alidade
