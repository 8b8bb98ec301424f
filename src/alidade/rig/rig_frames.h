// SPDX-License-Identifier: MIT
#pragma once

#include <cstddef>
#include <span>
#include <string>
#include <vector>

#include "alidade/target/frame_table.h"
#include "alidade/target/view.h"

namespace alidade {

/// An image of a camera.
struct RigImage {
  std::size_t camera = 0;
  std::string image;
  std::string frame;
  friend bool operator==(const RigImage&, const RigImage&) = default;
};

/// The views of one camera of a rig.
struct RigViews {
  std::string name;                      ///< of the camera
  std::vector<View> views;               ///< of one image size
  std::vector<std::string> images = {};  ///< all that were searched for boards; empty if unknown
  std::vector<std::string> paths = {};   ///< of these images; empty if unknown
  /// The numbers in the names of its images are larger by this than those of simultaneous images of a camera
  /// with lead 0. If any camera has a lead, images match by the nearest of these numbers.
  double lead = 0;
};

/// The instants at which a rig took images.
struct RigFrames {
  std::vector<std::string> names;                  ///< in natural order
  std::vector<std::vector<std::size_t>> frame_of;  ///< of each view of each camera, an index into `names`
  /// Images without a simultaneous image by a second camera; without a table, empty if RigViews::images is
  /// unknown for any camera.
  std::vector<RigImage> unmatched;
  /// The largest difference between the times of one frame, in the unit of the names; 0 if names match
  /// exactly.
  double time_spread = 0;
  /// Of each frame, in usual intervals: by the last numbers in the names, or else the indices.
  std::vector<double> times = {};
  /// The usual interval in these numbers; 0 without numbers that rise, and for a table.
  double step = 0;
  double interval_s = 0;           ///< of the usual interval; 0 if unknown
  std::vector<double> leads = {};  ///< RigViews::lead of each camera

  bool are_simultaneous = false;  ///< images of one frame were certainly taken at one instant

  /// True if recordings start at different times.
  [[nodiscard]] bool areShifted() const;
};

/// Finds which images were taken at the same time. Images match by the first of these that relates most
/// images of different cameras:
///
/// - the name with its folders, without the extension ("day1/000.png"),
/// - the name without folder and extension (with its number for a frame of a video, "clip@120"),
/// - the last number in it that differs between all images of each camera ("left01.jpg", "right1.png"; frames
/// of
///   videos have the same number),
/// - if these numbers are times (nine digits or a decimal point) and match for fewer than half of the images
///   of some camera: the nearest time, at most a quarter of the usual interval away.
/// @throws Error (kInput) if names have no such number
[[nodiscard]] RigFrames matchFrames(std::span<const RigViews> cameras);

/// Matches images by a table, which names them as given or by the last parts of their paths. An image that is
/// in no row is its own frame.
/// @throws Error (kInput) for a camera without a column or with a column that names none of its images, an
/// image in two rows, or one that was not given
[[nodiscard]] RigFrames framesOf(const FrameTable& table, std::span<const RigViews> cameras);

/// Images that the table names without a view, of cameras whose images are not all known: they may have had
/// no board, or be misspelt. RigImage::frame says where the table names them.
[[nodiscard]] std::vector<RigImage> namedWithoutViews(const FrameTable& table,
                                                      std::span<const RigViews> cameras);

}  // namespace alidade
