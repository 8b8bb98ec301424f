// SPDX-License-Identifier: MIT
#include "detection.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <memory>
#include <optional>
#include <set>
#include <span>

#include <pybind11/stl.h>

#include "alidade/core/error.h"
#include "alidade/core/number_text.h"
#include "alidade/detect/board_set.h"
#include "alidade/detect/survey.h"
#include "alidade/files/board_file.h"
#include "alidade/files/content_cache.h"
#include "alidade/files/corners_file.h"
#include "alidade/imagery/gray_image.h"
#include "alidade/imagery/image_set.h"
#include "bindings.h"
#include "camera.h"

namespace alidade::python {
namespace {

using namespace pybind11::literals;

// An image of the caller; the array keeps it alive.
struct ArrayImage {
  py::array array;
  RasterView view;
};

ArrayImage imageOf(const py::handle& value, const std::string& color) {
  if (color != "bgr" && color != "rgb")
    throw usageError(
        {.where = "color", .found = "'" + color + "'", .expected = "'bgr' (as in OpenCV) or 'rgb'"});
  py::array array = py::array::ensure(value);
  const py::ssize_t channels = array.ndim() == 3 ? array.shape(2) : 1;
  const bool has_shape = (array.ndim() == 2 || array.ndim() == 3) && array.size() > 0 &&
                         (channels == 1 || channels == 3 || channels == 4);
  const bool has_type = array.dtype().kind() == 'u' && array.itemsize() <= 2;
  if (!has_shape || !has_type) {
    throw usageError({.where = "image",
                      .found = "an array of shape " + py::str(array.attr("shape")).cast<std::string>() +
                               " and dtype " + py::str(array.dtype()).cast<std::string>(),
                      .expected = "uint8 or uint16 of shape (height, width), or (height, width, 3) in color",
                      .next_step = "pass several images as a list"});
  }
  // Rows may have padding, as in a part of a larger image; pixels of a row must not.
  const bool is_native = array.dtype().attr("isnative").cast<bool>();
  const auto sample = static_cast<py::ssize_t>(array.itemsize());
  const bool is_dense = array.strides(1) == channels * sample &&
                        array.strides(0) >= array.shape(1) * channels * sample &&
                        (array.ndim() == 2 || array.strides(2) == sample);
  if (!is_dense || !is_native) {
    array = py::module_::import("numpy").attr("ascontiguousarray")(array,
                                                                   array.dtype().attr("newbyteorder")("="));
  }
  ArrayImage image{.array = array, .view = {}};
  image.view = {.samples = array.data(),
                .size = {static_cast<int>(array.shape(1)), static_cast<int>(array.shape(0))},
                .num_channels = static_cast<int>(channels),
                .bits_per_sample = static_cast<int>(8 * sample),
                .row_bytes = static_cast<std::size_t>(array.strides(0)),
                .is_blue_first = color == "bgr"};
  return image;
}

bool isPath(const py::handle& value) {
  return py::isinstance<py::str>(value) || py::isinstance<py::bytes>(value) ||
         py::hasattr(value, "__fspath__");
}

// Sources of images to search: files and videos, or arrays.
struct Inputs {
  std::vector<std::string> paths = {};
  std::vector<std::string> names = {};
  std::vector<ArrayImage> arrays = {};
};

Inputs inputsOf(const py::handle& images, const SearchArguments& arguments) {
  Inputs inputs;
  if (isPath(images)) {
    inputs.paths.push_back(pathOf(images));
    return inputs;
  }
  for (const py::handle item : images) {
    if (isPath(item)) {
      inputs.paths.push_back(pathOf(item));
    } else {
      inputs.arrays.push_back(imageOf(item, arguments.color));
    }
  }
  if (inputs.paths.empty() == inputs.arrays.empty()) {
    throw usageError({.where = "images",
                      .found = inputs.paths.empty() ? "none" : "paths and arrays together",
                      .expected = "paths, or a list of image arrays"});
  }
  inputs.names = namesOf(arguments.names, inputs.arrays.size(), "image");
  return inputs;
}

ImageSet openInputs(const Inputs& inputs, const OpenImagesOptions& options) {
  if (inputs.arrays.empty()) return openImages(inputs.paths, options);
  // Shared, because each image of the set has its own copy of the function below.
  const auto views = std::make_shared<std::map<std::string, RasterView>>();
  for (std::size_t i = 0; i < inputs.names.size(); ++i) (*views)[inputs.names[i]] = inputs.arrays[i].view;
  // Threads call this without the interpreter lock; they read only the arrays' memory.
  return {inputs.names,
          [views](const std::string& name) -> LoadedImage { return {.image = grayImage(views->at(name))}; }};
}

SurveyValue valueOf(const std::vector<BoardSurvey>& surveys, const ImageSet& images, bool are_files) {
  SurveyValue value;
  std::set<std::size_t> found;
  value.given.notes = images.notes();
  for (const BoardSurvey& survey : surveys) {
    value.boards.push_back(survey.board);
    for (const SurveyNote& note : survey.notes)
      value.given.notes.push_back(diagnosisOf(note, survey).message());
    for (std::size_t i = 0; i < survey.outcomes.size(); ++i) {
      const ImageOutcome& outcome = survey.outcomes[i];
      if (outcome.detection.hasCorners()) found.insert(i);
      value.detections.push_back({outcome.image, outcome.size, outcome.detection, survey.board});
      if (are_files && &survey == &surveys.front()) value.paths.emplace_back(outcome.image, survey.paths[i]);
    }
  }
  value.given.num_images = images.size();
  value.given.num_found = found.size();
  value.given.reasons = reasonLines(surveys);
  return value;
}

// Views of a corners file in the form of a new detection.
SurveyValue loadCorners(const py::object& path) {
  const std::string file = pathOf(path);
  const CornersFile corners = [&] {
    const py::gil_scoped_release without_lock;
    return readCornersFile(file);
  }();
  SurveyValue value{.boards = corners.boards};
  std::set<std::string> images;
  for (const View& view : corners.views) {
    const Board& board = corners.boards[view.board];
    const bool is_whole = view.corners.size() == static_cast<std::size_t>(board.numCorners());
    Detection detection{.reason = is_whole ? DetectionReason::kFound : DetectionReason::kPartial,
                        .detail = {},
                        .corners = view.corners,
                        .measures = {},
                        .seen = {}};
    value.detections.push_back({view.image, view.size, std::move(detection), board});
    images.insert(view.image);
  }
  value.given.num_images = value.given.num_found = images.size();
  return value;
}

void saveCorners(const SurveyValue& survey, const py::object& path, const std::string& camera) {
  CornersFile file{.camera = camera,
                   .boards = survey.boards,
                   .views = viewsOf(survey.detections, survey.boards),
                   .comments = {}};
  file.comments.push_back(creatorName() + "; pixel (0, 0) is the centre of the top-left pixel");
  const std::string to = pathOf(path);
  const py::gil_scoped_release without_lock;
  writeCornersFile(to, file);
}

py::array_t<int> idsOf(const DetectionValue& self) {
  py::array_t<int> ids(static_cast<py::ssize_t>(self.detection.corners.size()));
  std::ranges::transform(self.detection.corners, ids.mutable_data(), &Corner::id);
  return ids;
}

py::array_t<double> sigmasOf(const DetectionValue& self) {
  py::array_t<double> sigmas(static_cast<py::ssize_t>(self.detection.corners.size()));
  std::ranges::transform(self.detection.corners, sigmas.mutable_data(), &Corner::sigma_px);
  return sigmas;
}

py::array_t<double> foundPixels(const DetectionValue& self) {
  std::vector<Eigen::Vector2d> pixels;
  for (const Corner& corner : self.detection.corners) pixels.push_back(corner.pixel);
  return pixelsArray(pixels);
}

// Pixels of all points of the board; NaN for those not seen.
py::array_t<double> allPixels(const DetectionValue& self) {
  constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();
  std::vector<Eigen::Vector2d> pixels(static_cast<std::size_t>(self.board.numCorners()),
                                      Eigen::Vector2d(kNaN, kNaN));
  for (const Corner& corner : self.detection.corners)
    pixels[static_cast<std::size_t>(corner.id)] = corner.pixel;
  return pixelsArray(pixels);
}

std::string messageOf(const DetectionValue& self) {
  return self.detection.detail;
}

py::object detect(const py::object& images, const py::object& board, const py::object& names,
                  const std::string& color, std::size_t num_frames, const py::object& cache, int jobs,
                  const py::object& progress) {
  const std::vector<Board> boards = boardsOf(board);
  if (!isImage(images))
    return py::cast(surveyOf(images, boards, {names, color, num_frames, cache, jobs}, progress));
  if (boards.size() != 1) {
    throw usageError({.where = "board",
                      .found = std::to_string(boards.size()) + " boards for one image",
                      .expected = "one board",
                      .next_step = "pass the image in a list to search it for several boards"});
  }
  const ArrayImage image = imageOf(images, color);
  DetectionValue value{.image = {}, .size = image.view.size, .detection = {}, .board = boards.front()};
  runInterruptibly(progress, [&](const CancelFlag*, const ReportProgress&) {
    value.detection = findBoard(grayImage(image.view), value.board);
  });
  return py::cast(value);
}

void bindBoard(py::module_& module) {
  py::class_<Board>(module, "Board", doc("Board"))
      .def(py::init([](const py::object& spec) { return readBoard(pathOf(spec)); }), "spec"_a,
           doc("Board.__init__"))
      .def_property_readonly("spec", &Board::spec, doc("Board.spec"))
      .def_property_readonly("columns", &Board::columns, doc("Board.columns"))
      .def_property_readonly("rows", &Board::rows, doc("Board.rows"))
      .def_property_readonly(
          "points",
          [](const Board& self) {
            py::array_t<double> points({static_cast<py::ssize_t>(self.numCorners()), py::ssize_t{3}});
            double* out = points.mutable_data();
            for (const Eigen::Vector3d& point : self.corners())
              out = std::copy(point.begin(), point.end(), out);
            return points;
          },
          doc("Board.points"))
      .def(
          "__eq__", [](const Board& self, const Board& other) { return self == other; }, py::is_operator())
      .def("__hash__", [](const Board& self) { return py::hash(py::str(self.spec())); })
      .def("__repr__", [](const Board& self) { return "Board('" + self.spec() + "')"; })
      .def(py::pickle([](const Board& self) { return py::make_tuple(self.spec()); },
                      [](const py::tuple& state) { return readBoard(state[0].cast<std::string>()); }));
}

void bindDetectionClass(py::module_& module) {
  const auto measure = [](double ViewMeasures::*member) {
    return [member](const DetectionValue& self) { return self.detection.measures.*member; };
  };
  py::class_<DetectionValue>(module, "Detection", doc("Detection"))
      .def_property_readonly(
          "image", [](const DetectionValue& self) { return nameText(self.image); }, doc("Detection.image"))
      .def_property_readonly(
          "size", [](const DetectionValue& self) { return sizeTuple(self.size); }, doc("Detection.size"))
      .def_readonly("board", &DetectionValue::board, doc("Detection.board"))
      .def_property_readonly(
          "found", [](const DetectionValue& self) { return self.detection.hasCorners(); },
          doc("Detection.found"))
      .def_property_readonly(
          "reason", [](const DetectionValue& self) { return std::string(reasonCode(self.detection.reason)); },
          doc("Detection.reason"))
      .def_property_readonly("message", &messageOf, doc("Detection.message"))
      .def_property_readonly("ids", &idsOf, doc("Detection.ids"))
      .def_property_readonly("pixels", &foundPixels, doc("Detection.pixels"))
      .def_property_readonly("sigma_px", &sigmasOf, doc("Detection.sigma_px"))
      .def_property_readonly("all_pixels", &allPixels, doc("Detection.all_pixels"))
      .def_property_readonly("blur_px", measure(&ViewMeasures::blur_px), doc("Detection.blur_px"))
      .def_property_readonly("tilt_deg", measure(&ViewMeasures::tilt_deg), doc("Detection.tilt_deg"))
      .def("__bool__", [](const DetectionValue& self) { return self.detection.hasCorners(); })
      .def("__repr__", [](const DetectionValue& self) {
        return "<alidade.Detection: " + self.image + (self.image.empty() ? "" : ": ") +
               std::string(reasonCode(self.detection.reason)) + ", " +
               std::to_string(self.detection.corners.size()) + " of " +
               std::to_string(self.board.numCorners()) + " " + std::string(self.board.words().points) + ">";
      });
}

void bindSurvey(py::module_& module) {
  const auto at = [](const SurveyValue& self, py::ssize_t i) {
    const auto count = static_cast<py::ssize_t>(self.detections.size());
    if (i < -count || i >= count)
      throw py::index_error("the survey has " + std::to_string(count) + " detections");
    return self.detections[static_cast<std::size_t>(i < 0 ? i + count : i)];
  };
  py::class_<SurveyValue>(module, "Survey", doc("Survey"))
      .def_readonly("boards", &SurveyValue::boards, doc("Survey.boards"))
      .def_property_readonly(
          "num_images", [](const SurveyValue& self) { return self.given.num_images; },
          doc("Survey.num_images"))
      .def_property_readonly(
          "num_found", [](const SurveyValue& self) { return self.given.num_found; }, doc("Survey.num_found"))
      .def_property_readonly(
          "reasons", [](const SurveyValue& self) { return self.given.reasons; }, doc("Survey.reasons"))
      .def_property_readonly(
          "notes", [](const SurveyValue& self) { return self.given.notes; }, doc("Survey.notes"))
      .def("save", &saveCorners, "path"_a, "camera"_a = "camera", doc("Survey.save"))
      .def("__len__", [](const SurveyValue& self) { return self.detections.size(); })
      .def("__getitem__", at)
      .def(
          "__iter__",
          [](const SurveyValue& self) {
            return py::make_iterator(self.detections.begin(), self.detections.end());
          },
          py::keep_alive<0, 1>())
      .def("__repr__", [](const SurveyValue& self) {
        return "<alidade.Survey: boards in " + std::to_string(self.given.num_found) + " of " +
               std::to_string(self.given.num_images) + " images>";
      });
}

}  // namespace

std::vector<Board> boardsOf(const py::handle& value) {
  const auto boardOf = [](const py::handle& item) -> Board {
    if (py::isinstance<Board>(item)) return item.cast<Board>();
    if (isPath(item)) return readBoard(pathOf(item));
    throw usageError({.where = "board",
                      .found = "a " + py::str(py::type::of(item).attr("__name__")).cast<std::string>(),
                      .expected = "a Board or its SPEC, such as 'checkerboard:9x6:25mm'"});
  };
  std::vector<Board> boards;
  const bool is_list = py::isinstance<py::list>(value) || py::isinstance<py::tuple>(value);
  if (is_list) {
    for (const py::handle item : value) boards.push_back(boardOf(item));
  } else {
    boards.push_back(boardOf(value));
  }
  requireDistinguishable(boards);
  return boards;
}

bool isImage(const py::handle& value) {
  return py::isinstance<py::array>(value) && value.attr("dtype").attr("kind").cast<std::string>() == "u";
}

bool isListOf(const py::handle& value, bool (*is_kind)(const py::handle&)) {
  if (!py::isinstance<py::list>(value) && !py::isinstance<py::tuple>(value)) return false;
  for (const py::handle item : value) {
    if (!is_kind(item)) return false;
  }
  return py::len(value) > 0;
}

bool areImages(const py::handle& value) {
  return isPath(value) || isImage(value) ||
         isListOf(value, [](const py::handle& item) { return isPath(item) || isImage(item); });
}

std::vector<std::string> namesOf(const py::handle& names, std::size_t count, const std::string& prefix) {
  constexpr std::size_t kDigits = 4;  // so that names sort like the images
  std::vector<std::string> result;
  if (names.is_none()) {
    for (std::size_t i = 0; i < count; ++i) {
      const std::string number = std::to_string(i);
      result.push_back(prefix + std::string(kDigits - std::min(kDigits, number.size()), '0') + number);
    }
    return result;
  }
  for (const py::handle name : names) result.push_back(pathOf(name));
  const std::set<std::string> unique(result.begin(), result.end());
  if (result.size() != count || unique.size() != count) {
    throw usageError({.where = "names",
                      .found = std::to_string(unique.size()) + " different names",
                      .expected = std::to_string(count) + ", one for each image"});
  }
  return result;
}

std::vector<View> viewsOf(const std::vector<DetectionValue>& detections, const std::vector<Board>& boards) {
  std::vector<View> views;
  for (const DetectionValue& value : detections) {
    if (!value.detection.hasCorners()) continue;
    const auto board = std::ranges::find(boards, value.board);
    if (board == boards.end()) {
      throw usageError({.where = "detections",
                        .found = "the board " + value.board.spec(),
                        .expected = "a board that was passed to the call"});
    }
    views.push_back({.image = value.image,
                     .size = value.size,
                     .corners = value.detection.corners,
                     .board = static_cast<std::size_t>(board - boards.begin())});
  }
  return views;
}

SurveyValue surveyOf(const py::handle& images, const std::vector<Board>& boards,
                     const SearchArguments& arguments, const py::object& progress) {
  const Inputs inputs = inputsOf(images, arguments);
  std::optional<ContentCache> cache;
  if (!arguments.cache.is_none()) cache.emplace(pathOf(arguments.cache));
  SurveyValue value;
  runInterruptibly(progress, [&](const CancelFlag* cancel, const ReportProgress& report) {
    const ContentCache* const known = cache ? &*cache : nullptr;
    const ImageSet set = openInputs(
        inputs,
        {.num_frames = arguments.num_frames,
         .num_jobs = arguments.jobs,
         .progress = [&](std::size_t done, std::size_t total) { report("choosing frames", done, total); },
         .cancel = cancel,
         .cache = known});
    DetectImagesOptions options;
    options.num_jobs = arguments.jobs;
    options.progress = [&](std::size_t done, std::size_t total) { report("detecting boards", done, total); };
    options.cancel = cancel;
    options.cache = known;
    value = valueOf(surveyImages(set, boards, options), set, inputs.arrays.empty());
  });
  return value;
}

void bindDetection(py::module_& module) {
  bindBoard(module);
  bindDetectionClass(module);
  bindSurvey(module);
  module.def("detect", &detect, "images"_a, "board"_a, py::kw_only(), "names"_a = py::none(),
             "color"_a = "bgr", "num_frames"_a = 100, "cache"_a = py::none(), "jobs"_a = 0,
             "progress"_a = py::none(), doc("detect"));
  module.def("load_corners", &loadCorners, "path"_a, doc("load_corners"));
}

}  // namespace alidade::python
