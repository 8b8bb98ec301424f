// SPDX-License-Identifier: MIT
#pragma once

#include <optional>
#include <string>
#include <type_traits>
#include <variant>
#include <vector>

#include <Eigen/Core>
#include <Eigen/Geometry>

#include "alidade/target/board_kinds.h"

namespace alidade {

/// The kinds of boards.
using BoardKind = std::variant<Checkerboard, CharucoBoard, AprilGrid, CircleGrid, AsymmetricCircleGrid>;

/// A board of any kind: points in columns and rows on a plane, which detectors find. Point ids run along the
/// columns first: id = row * columns + column. Board frame: origin at point 0, x along the columns, y along
/// the rows, z into the board; metres.
class Board {
 public:
  Board() = default;  ///< without points
  template <class Kind>
  requires(std::is_convertible_v<const Kind&, BoardKind> && !std::is_same_v<Kind, Board>)
      Board(const Kind& board)
      : kind_(board) {
    layOut();
  }

  [[nodiscard]] const BoardKind& kind() const { return kind_; }
  /// Columns of points; a SPEC may count other things.
  [[nodiscard]] int columns() const { return layout_.columns; }
  [[nodiscard]] int rows() const { return layout_.rows; }
  [[nodiscard]] int numCorners() const { return static_cast<int>(corners_.size()); }
  /// The positions of the points on the board, by id.
  [[nodiscard]] const std::vector<Eigen::Vector3d>& corners() const { return corners_; }
  [[nodiscard]] const Eigen::Vector3d& corner(int id) const { return corners_[static_cast<std::size_t>(id)]; }
  /// Width and height of the points' bounding box, whose first corner is the origin.
  [[nodiscard]] const Eigen::Vector2d& span() const { return span_m_; }
  [[nodiscard]] Eigen::Vector3d middle() const { return {0.5 * span_m_.x(), 0.5 * span_m_.y(), 0.0}; }
  /// The printed area, around the points.
  [[nodiscard]] const Eigen::AlignedBox2d& printed() const { return printed_; }
  /// Shortest distance between neighbouring points.
  [[nodiscard]] double spacing() const { return layout_.spacing_m; }
  /// Radius of the discs whose centroids are observed in place of the points, metres; 0: the points
  /// themselves are observed.
  [[nodiscard]] double discRadius() const { return layout_.disc_radius_m; }
  /// The smallest number of quarter turns after which the board looks the same; 4 if only a full turn does.
  [[nodiscard]] int symmetryStep() const { return layout_.symmetry_step; }
  /// True if the board looks the same in another position, so that ids may differ from view to view.
  [[nodiscard]] bool isAmbiguous() const { return layout_.symmetry_step < 4; }
  /// Words for its parts in messages.
  [[nodiscard]] BoardWords words() const;
  /// Columns and rows as in the SPEC: "8x11 squares".
  [[nodiscard]] std::string countsText() const;
  [[nodiscard]] BoardPattern pattern() const;
  /// Nothing for boards without markers.
  [[nodiscard]] std::optional<MarkerIds> markers() const;
  /// The gap between tags as a share of their side; nothing for boards of other kinds.
  [[nodiscard]] std::optional<double> gap() const;
  /// The gap that a SPEC stated for this board, which images contradicted; see withGap().
  [[nodiscard]] std::optional<double> refutedGap() const { return refuted_gap_; }
  /// The same board with the gap that images show; it remembers the stated one. @pre a board of tags
  [[nodiscard]] Board withGap(double gap) const;
  /// True for two boards with different lengths that are otherwise the same.
  [[nodiscard]] bool differsInLengthsFrom(const Board& other) const;
  /// As on the command line: "checkerboard:9x6:25mm".
  [[nodiscard]] std::string spec() const;

  friend bool operator==(const Board& a, const Board& b) { return a.kind_ == b.kind_; }

 private:
  void layOut();

  BoardKind kind_;
  PointLayout layout_;
  std::vector<Eigen::Vector3d> corners_;
  Eigen::Vector2d span_m_{0, 0};
  Eigen::AlignedBox2d printed_;
  std::optional<double> refuted_gap_;
};

}  // namespace alidade
