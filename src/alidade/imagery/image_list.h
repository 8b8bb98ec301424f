// SPDX-License-Identifier: MIT
#pragma once

#include <span>
#include <string>
#include <vector>

namespace alidade {

/// Image files that a pattern such as frames/img%04d.png stands for, in the order of their numbers.
struct ImageSequence {
  std::string pattern;
  std::vector<std::string> files;
};

/// The files that inputs refer to, each in natural order (img2 before img10) and once, regardless of the
/// order of the inputs.
struct InputFiles {
  std::vector<std::string> images;
  std::vector<ImageSequence> sequences;
  std::vector<std::string> videos;

  /// All files, in this order.
  [[nodiscard]] std::vector<std::string> all() const;
};

/// Looks up inputs. An input is a folder, a file with any extension, or a pattern that is not itself a file
/// name. A folder means its files with an image extension, without hidden files and sub-folders. A pattern
/// with * ? or [ means its matches, and one with a single %d or %04d a sequence. A file is a video if its
/// name says so (hasVideoName()).
/// @throws Error (kUsage) without inputs; Error (kInput) for an input that does not exist, cannot be read, or
/// contains no image.
[[nodiscard]] InputFiles listInputs(std::span<const std::string> inputs);

/// The image files that inputs refer to, for uses that exclude videos; files of sequences count as images.
/// @throws Error as listInputs(); Error (kInput) for a video
[[nodiscard]] std::vector<std::string> listImages(std::span<const std::string> inputs);

/// The shortest unambiguous names of the images: paths without the folders that they all share.
/// @param paths  at least one
[[nodiscard]] std::vector<std::string> shortNames(const std::vector<std::string>& paths);

}  // namespace alidade
