// SPDX-License-Identifier: MIT
#pragma once

#include <cstddef>
#include <string>
#include <utility>
#include <vector>

#include "alidade/detect/detect_images.h"
#include "alidade/report/data/evidence.h"
#include "alidade/target/board.h"
#include "alidade/target/view.h"
#include "arrays.h"
#include "interruptible.h"

namespace alidade::python {

/// A board in an image, or the reason why it was not found.
struct DetectionValue {
  std::string image;  ///< may be empty
  ImageSize size;
  Detection detection;
  Board board;
};

/// Boards in many images.
struct SurveyValue {
  std::vector<Board> boards;
  std::vector<DetectionValue> detections = {};  ///< board by board, in the order of the images
  GivenImages given = {};
  std::vector<std::pair<std::string, std::string>> paths = {};  ///< name and path of each image from a file
};

/// Options of a search in images.
struct SearchArguments {
  py::object names = py::none();
  std::string color = "bgr";
  std::size_t num_frames = 100;
  py::object cache = py::none();
  int jobs = 0;
};

/// A Board, a SPEC, a board file, or a sequence of these. @throws Error (kUsage) otherwise
[[nodiscard]] std::vector<Board> boardsOf(const py::handle& value);

/// True for an array of integers, which is an image; other arrays are corners.
[[nodiscard]] bool isImage(const py::handle& value);
/// True for a nonempty list or tuple of items of one kind.
[[nodiscard]] bool isListOf(const py::handle& value, bool (*is_kind)(const py::handle&));
/// True for a path, or a sequence of paths or images.
[[nodiscard]] bool areImages(const py::handle& value);

/// Finds boards in all images of a sequence of arrays, or of paths.
[[nodiscard]] SurveyValue surveyOf(const py::handle& images, const std::vector<Board>& boards,
                                   const SearchArguments& arguments, const py::object& progress);

/// The views of detections with corners.
/// @throws Error (kUsage) for detections of a board not in `boards`
[[nodiscard]] std::vector<View> viewsOf(const std::vector<DetectionValue>& detections,
                                        const std::vector<Board>& boards);

/// The names given for `count` items, or "view0000" and so on. @throws Error (kUsage) for a wrong number of
/// names
[[nodiscard]] std::vector<std::string> namesOf(const py::handle& names, std::size_t count,
                                               const std::string& prefix);

}  // namespace alidade::python
