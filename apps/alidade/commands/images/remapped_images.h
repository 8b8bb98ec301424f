// SPDX-License-Identifier: MIT
#pragma once

#include <string>
#include <vector>

#include "alidade/core/cancel.h"
#include "alidade/imagery/remap.h"
#include "alidade/report/data/json_output.h"
#include "pending_folder.h"

// Remaps folders of images by a table.

namespace alidade {

/// An image and its result.
struct RemappedImage {
  std::string path;
  std::string image;   ///< short name
  std::string output;  ///< name in the output folder
  std::string reason;  ///< reason why there is no output; empty = there is one
  int exif_orientation = 1;
};

/// The images by their short names, and their names in the output folder: the same with the extension .png,
/// or unchanged for JPEG files; folders become a part of the name. If several images would get the same name,
/// these keep their own extension before .png.
/// @throws Error (kInput) if two would still have the same name
[[nodiscard]] std::vector<RemappedImage> namedImages(const std::vector<std::string>& paths);

/// The options of remapAll().
struct RemapSettings {
  std::string label;      ///< of the progress bar
  std::string subfolder;  ///< of the output folder; empty: none
  Interpolation interpolation = Interpolation::kLinear;
  int num_jobs = 0;
  bool is_quiet = false;
  const CancelFlag* cancel = nullptr;
};

/// Writes the remapped images. An image that cannot be used gets a reason; one that cannot be written ends
/// the work.
/// @throws Error (kInput); Cancelled
void remapAll(std::vector<RemappedImage>& images, const RemapTable& table, const PendingFolder& folder,
              const RemapSettings& settings);

[[nodiscard]] std::size_t numSkipped(const std::vector<RemappedImage>& images);
/// Throws if no image could be used. @throws Error (kInput)
void requireAnImage(const std::vector<RemappedImage>& images);
/// Prints the skipped images with reasons. @returns true if there were any
bool reportSkipped(const std::vector<RemappedImage>& images);
/// Sentences about the images' Exif orientations, which are ignored.
[[nodiscard]] std::vector<std::string> orientationNotes(const std::vector<RemappedImage>& images);
[[nodiscard]] json imagesJson(const std::vector<RemappedImage>& images);

}  // namespace alidade
