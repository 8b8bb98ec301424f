// SPDX-License-Identifier: MIT
#pragma once

#include <span>
#include <string>
#include <vector>

namespace alidade {

/// The image files that `inputs` stand for. An input is a folder (the files in it with the extension of an
/// image, without hidden files and sub-folders), a file (whatever its extension), or a pattern with * ? or [
/// that is not itself the name of a file (what it matches counts as if it had been given). The list is in
/// natural order (img2 before img10) and holds each file once, so the order of the inputs does not matter.
/// @throws Error (kUsage) without inputs; Error (kInput) for an input that does not exist, cannot be read,
/// is a video, or gives no image.
[[nodiscard]] std::vector<std::string> listImages(std::span<const std::string> inputs);

/// Names as short as they can be while telling the images apart: paths without the folders that all share.
/// @param paths  at least one
[[nodiscard]] std::vector<std::string> shortNames(const std::vector<std::string>& paths);

}  // namespace alidade
