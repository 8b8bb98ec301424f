// SPDX-License-Identifier: MIT
#pragma once

#include <array>
#include <cstddef>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include <Eigen/Geometry>

#include "alidade/calibrate/calibrator.h"
#include "alidade/target/board.h"
#include "alidade/target/view.h"

namespace alidade {

/// Rotation of a board out of the pose in which the lens shows it square, radians. In that pose no side
/// appears larger than the opposite one: parallel to the image for a pinhole, facing the line of sight for an
/// equidistant fisheye. Sides are those of the image, regardless of the print.
struct BoardTilt {
  double right_rad = 0;  ///< positive: the right side is nearer to the camera than the left one
  double lower_rad = 0;  ///< positive: the lower side is nearer than the upper one

  /// Angle between the board and its square pose.
  [[nodiscard]] double total() const;
};

/// Place and tilt of a board, as the camera's user sees them.
struct BoardSighting {
  Eigen::Vector2d middle_px{0, 0};  ///< centre of the board's corners; NaN if the camera does not see it
  double distance_m = 0;            ///< from the camera to that centre
  BoardTilt tilt;
};

/// camera_from_square: z is the normal, away from the camera, of the plane that `camera` shows square around
/// a pixel, x runs to the right in the image. Nothing if the pixel has no ray.
[[nodiscard]] std::optional<SO3> squarePose(const AnyCamera& camera, const Eigen::Vector2d& pixel);

[[nodiscard]] BoardSighting sightBoard(const AnyCamera& camera, const Board& board,
                                       const SE3& camera_from_board);

/// The rotation square_from_board of an upright board with this tilt; less than 90 degrees each.
[[nodiscard]] SO3 tiltedBoard(const BoardTilt& tilt);

/// "its left side nearer to you by 40 degrees and its upper side by 20 degrees"; "not tilted" below 5 degrees
/// in both directions.
[[nodiscard]] std::string tiltText(const BoardTilt& tilt);

/// A ninth of an image: thirds of its width and of its height.
struct ImageRegion {
  int column = 0;  ///< 0 left, 1 middle, 2 right
  int row = 0;     ///< 0 upper, 1 middle, 2 lower

  friend bool operator==(const ImageRegion&, const ImageRegion&) = default;
};

/// The region that holds a pixel; pixels beyond the image belong to the nearest region.
[[nodiscard]] ImageRegion regionAt(const Eigen::Vector2d& pixel, ImageSize size);

/// "upper left corner", "left border", "centre", ...
[[nodiscard]] std::string regionName(const ImageRegion& region);

/// "in the upper left corner", "at the left border", "in the centre", ...
[[nodiscard]] std::string placeName(const ImageRegion& region);

/// The larger of the shares of the image's width and height that a box of pixels spans; 0 for an empty box.
[[nodiscard]] double fillOf(const Eigen::AlignedBox2d& box, ImageSize size);

/// The board as one view shows it.
struct ViewCoverage {
  std::string image;
  std::size_t board = 0;  ///< index into Fit::boards
  BoardSighting sighting;
  double fill = 0;  ///< fillOf() the view's corners
};

inline constexpr double kTiltedRad = 0.26179938779914941;  ///< 15 degrees
inline constexpr double kSteepRad = 0.52359877559829882;   ///< 30 degrees

/// Sides of a board, as the image shows it.
inline constexpr std::array<const char*, 4> kSideNames = {"left", "right", "upper", "lower"};

/// Coverage of the image, of tilts and of distances by the views of a calibration.
struct CoverageReport {
  /// Cells of a grid over the image, eight along its longer side and nearly square, row by row.
  int columns = 0;
  int rows = 0;
  std::vector<int> num_corners;  ///< used corners in each cell; -1 if the lens has no ray there
  /// Shares of the cells with a ray that hold corners: of all such cells, and of those along the image's
  /// border.
  double share = 0;
  double border_share = 0;
  int num_image_corners = 0;  ///< how many of the four cells in the image's corners hold corners
  /// Ninths of the image in which less than a quarter of the cells hold corners.
  std::vector<ImageRegion> empty_regions;

  std::vector<ViewCoverage> views;  ///< in the result's order
  /// Numbers of views in which a side (kSideNames) is nearer to the camera than the opposite one by more than
  /// kTiltedRad.
  std::array<int, 4> num_tilted_to{};
  double nearest_m = 0;  ///< smallest and largest distance of the board's centre
  double farthest_m = 0;

  /// Views tilted by more than this in all.
  [[nodiscard]] std::ptrdiff_t numTilted(double angle_rad) const;
};

/// Pixels of the corners that a result used, one list for each of its views.
/// @param views  those given to the calibration
[[nodiscard]] std::vector<std::vector<Eigen::Vector2d>> usedCorners(const Calibration& calibration,
                                                                    std::span<const View> views);

/// The coverage of the image alone, by the corners of each view.
[[nodiscard]] CoverageReport imageCoverage(const AnyCamera& camera, ImageSize size,
                                           std::span<const std::vector<Eigen::Vector2d>> corners);

/// @param views  those given to the calibration; only the ones that the result used count
[[nodiscard]] CoverageReport coverageOf(const Calibration& calibration, std::span<const View> views);

/// Text for users: one line if nothing is missing, otherwise one more line for each gap. Lines are not
/// indented and end with a newline.
[[nodiscard]] std::string coverageText(const CoverageReport& report);

}  // namespace alidade
