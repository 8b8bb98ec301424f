// SPDX-License-Identifier: MIT
#pragma once

#include <cstddef>
#include <functional>
#include <limits>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include <Eigen/Core>

#include "alidade/camera/any_camera.h"
#include "alidade/compare/projection_difference.h"
#include "alidade/core/cancel.h"
#include "alidade/core/diagnosis.h"
#include "alidade/core/image.h"
#include "alidade/files/camera_list.h"
#include "alidade/files/camera_source.h"
#include "alidade/record/camera_record.h"

namespace alidade {

/// A camera of a fleet. Holds only the necessary parts of its file, because there may be many.
struct FleetUnit {
  std::string file;   ///< path as found, with "#NAME" if the file has several cameras
  std::string place;  ///< path relative to the named folder, to find it in a different folder
  CameraName name = {};
  AnyCamera camera;
  ImageSize size;
  std::vector<double> covariance = {};  ///< as in CalibrationRecord; empty if not stated
  std::optional<Verdict> verdict = {};  ///< nothing if not stated
  double accuracy_px = std::numeric_limits<double>::quiet_NaN();  ///< as stated; NaN if not stated

  [[nodiscard]] ComparedCamera compared() const;
};

/// A file named as a camera file that cannot be used.
struct UnreadableFile {
  std::string file;
  std::string reason;
};

struct FleetFiles {
  std::vector<FleetUnit> units = {};            ///< in the order of the files
  std::vector<UnreadableFile> unreadable = {};  ///< damaged, or without an image size
  std::size_t num_files = 0;                    ///< camera files, including those that cannot be read
  std::vector<std::string> other_files = {};    ///< files that are not camera files
};

/// Options for reading and analysing a fleet.
struct FleetOptions {
  ReadOptions read = {};
  /// Alignment before two cameras are compared, see DifferenceOptions; empty: none.
  std::optional<Freed> freed = Freed::kRotation;
  double tolerance_px = 1;  ///< for a unit's distance from the typical camera
  int jobs = 0;             ///< threads; 0: one per processor. The result does not depend on it.
  const CancelFlag* cancel = nullptr;
  std::function<void(std::size_t, std::size_t)> progress = {};  ///< (done, total); one call at a time
};

/// The cameras of a record, as a unit. @param file, place  see FleetUnit
[[nodiscard]] FleetUnit unitOf(const CameraRecord& record, std::string file, std::string place);

/// Reads camera files of any format; each camera of a file is a unit. A file that cannot be read is listed
/// and skipped. The result does not depend on the number of threads.
/// @param inputs  files, folders and patterns, see listCameraFiles()
/// @throws Error (kInput) as listCameraFiles(); Cancelled
[[nodiscard]] FleetFiles readFleetFiles(std::span<const std::string> inputs,
                                        const FleetOptions& options = {});

}  // namespace alidade
