// SPDX-License-Identifier: MIT
#pragma once

#include <span>
#include <string>
#include <vector>

namespace alidade {

/// The image files that `inputs` refer to. An input is a folder, a file with any extension, or a pattern with
/// * ? or [ that is not itself a file name. A folder means its files with an image extension, without hidden
/// files and sub-folders. A pattern means its matches. The list is in natural order (img2 before img10) and
/// contains each file once, regardless of the order of the inputs.
/// @throws Error (kUsage) without inputs; Error (kInput) for an input that does not exist, cannot be read, is
/// a video, or contains no image.
[[nodiscard]] std::vector<std::string> listImages(std::span<const std::string> inputs);

/// The shortest unambiguous names of the images: paths without the folders that they all share.
/// @param paths  at least one
[[nodiscard]] std::vector<std::string> shortNames(const std::vector<std::string>& paths);

}  // namespace alidade
