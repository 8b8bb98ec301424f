// SPDX-License-Identifier: MIT
#pragma once

#include <string>
#include <vector>

#include "alidade/imagery/remap.h"
#include "alidade/report/data/json_output.h"
#include "flags.h"
#include "pending_folder.h"

// Folders of images that a table makes of others.

namespace alidade {

/// An image and its result.
struct RemappedImage {
  std::string path;
  std::string image;   ///< short name
  std::string output;  ///< name in the output folder
  std::string reason;  ///< why there is no output; empty = there is
  int exif_orientation = 1;
};

/// The images by their short names, and their names in the output folder: the same with the extension .png,
/// or as it is for JPEG files; folders become a part of the name. Where that would be the same for several
/// images, these keep their own extension before .png.
/// @throws Error (kInput) where two would still have the same name
[[nodiscard]] std::vector<RemappedImage> namedImages(const std::vector<std::string>& paths);

/// The options of remapAll().
struct RemapSettings {
  std::string label;      ///< of the progress bar
  std::string subfolder;  ///< of the output folder; empty: the folder itself
  Interpolation interpolation = Interpolation::kLinear;
  const CommonOptions& common;
};

/// Writes what the table makes of each image. An image that cannot be used gets a reason; one that cannot be
/// written ends the work.
/// @throws Error (kInput); Cancelled
void remapAll(std::vector<RemappedImage>& images, const RemapTable& table, const PendingFolder& folder,
              const RemapSettings& settings);

/// The share of the pixels that have no source.
[[nodiscard]] double darkShare(const RemapTable& table);

[[nodiscard]] std::size_t numSkipped(const std::vector<RemappedImage>& images);
/// Refuses images of which none could be used. @throws Error (kInput)
void requireAnImage(const std::vector<RemappedImage>& images);
/// Tells which images were skipped, and why. @returns whether any was
bool reportSkipped(const std::vector<RemappedImage>& images);
/// Sentences about the images' Exif orientations, which are ignored.
[[nodiscard]] std::vector<std::string> orientationNotes(const std::vector<RemappedImage>& images);
[[nodiscard]] json imagesJson(const std::vector<RemappedImage>& images);

}  // namespace alidade
