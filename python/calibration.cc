// SPDX-License-Identifier: MIT
#include "calibration.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <memory>
#include <optional>
#include <span>
#include <utility>

#include <pybind11/stl.h>
#include <nlohmann/json.hpp>

#include "alidade/adjust/board/errors.h"
#include "alidade/calibrate/calibrator.h"
#include "alidade/calibrate/start/prepared_views.h"
#include "alidade/core/error.h"
#include "alidade/core/number_text.h"
#include "alidade/core/size_groups.h"
#include "alidade/files/camera_source.h"
#include "alidade/files/text/atomic_file.h"
#include "alidade/imagery/image_set.h"
#include "alidade/report/data/json_output.h"
#include "alidade/report/pages/page.h"
#include "bindings.h"
#include "camera.h"

namespace alidade::python {
namespace {

using namespace pybind11::literals;

// A result in Python, with the additional data for its documents.
struct CalibrationValue {
  Calibration result;
  ViewsValue from;
  Guidance guidance;
  CalibratorOptions options;
  CameraRecord record;

  [[nodiscard]] nlohmann::json evidence() const {
    return evidenceDocument(result, from.given, guidance,
                            {.settings = {{"model", {options.model}}},
                             .tolerance_px = options.tolerance_px,
                             .run = {.created_by = creatorName(), .camera = record.name}});
  }
};

View cornersView(const py::handle& item, const Board& board, ImageSize size, const std::string& name,
                 const py::object& sigma_px) {
  View view{.image = name, .size = size, .corners = {}};
  py::object pixels = py::reinterpret_borrow<py::object>(item);
  py::object sigmas = sigma_px;
  std::optional<std::vector<int>> ids;
  if (py::isinstance<py::tuple>(item)) {  // (ids, pixels) or (ids, pixels, sigma_px)
    const auto parts = py::reinterpret_borrow<py::tuple>(item);
    if (parts.size() != 2 && parts.size() != 3)
      throw usageError(
          {.where = name, .found = "a tuple", .expected = "(ids, pixels) or (ids, pixels, sigma_px)"});
    ids = parts[0].cast<std::vector<int>>();
    pixels = parts[1];
    if (parts.size() == 3) sigmas = parts[2];
  }
  const Rows rows = rowsOf(pixels, 2, name);
  const std::size_t expected = ids ? ids->size() : static_cast<std::size_t>(board.numCorners());
  if (rows.count != expected) {
    throw usageError(
        {.where = name,
         .found = std::to_string(rows.count) + " corners",
         .expected = std::to_string(expected) + (ids ? ", one for each id" : " of " + board.spec()),
         .next_step = "give corners that are not seen as NaN, or pass (ids, pixels)"});
  }
  std::vector<double> sigma(rows.count, std::numeric_limits<double>::quiet_NaN());
  if (!sigmas.is_none()) {
    const Rows given = rowsOf(
        py::module_::import("numpy").attr("reshape")(
            py::module_::import("numpy").attr("broadcast_to")(sigmas, rows.count), py::make_tuple(-1, 1)),
        1, "sigma_px");
    std::copy_n(given.data(), rows.count, sigma.begin());
  }
  for (std::size_t i = 0; i < rows.count; ++i) {
    const Eigen::Vector2d pixel(rows.data()[2 * i], rows.data()[2 * i + 1]);
    if (!ids && pixel.hasNaN()) continue;
    view.corners.push_back(
        {.id = ids ? (*ids)[i] : static_cast<int>(i), .pixel = pixel, .sigma_px = sigma[i]});
  }
  return view;
}

ViewsValue fromCorners(const py::object& corners, const std::vector<Board>& boards,
                       const ViewsArguments& arguments) {
  if (boards.size() != 1)
    throw usageError(
        {.where = "board", .found = "several boards", .expected = "one board for corner arrays"});
  if (arguments.image_size.is_none()) {
    throw usageError({.where = "calibrate()",
                      .found = "corner arrays without image_size",
                      .expected = "image_size=(width, height) of the images in pixels"});
  }
  const ImageSize size = sizeOf(arguments.image_size, "image_size");
  const std::size_t count = py::len(corners);
  const std::vector<std::string> names = namesOf(arguments.search.names, count, "view");
  ViewsValue value{.boards = boards, .views = {}, .given = {}};
  std::size_t i = 0;
  for (const py::handle item : corners) {
    View view = cornersView(item, boards.front(), size, names[i++], arguments.sigma_px);
    if (!view.corners.empty()) value.views.push_back(std::move(view));
  }
  value.given.num_images = count;
  value.given.num_found = value.views.size();
  return value;
}

ViewsValue fromSurvey(SurveyValue survey) {
  ViewsValue value{.boards = survey.boards,
                   .views = viewsOf(survey.detections, survey.boards),
                   .given = std::move(survey.given),
                   .paths = std::move(survey.paths)};
  for (const DetectionValue& detection : survey.detections) {
    if (detection.board == survey.boards.front()) value.images.push_back(detection.image);
  }
  return value;
}

ViewsValue fromDetections(const py::sequence& list, const std::vector<Board>& boards,
                          const py::object& given_names) {
  SurveyValue survey{.boards = boards};
  const std::vector<std::string> names = namesOf(given_names, list.size(), "image");
  std::size_t i = 0;
  for (const py::handle item : list) {
    survey.detections.push_back(item.cast<DetectionValue>());
    std::string& image = survey.detections.back().image;
    if (image.empty() || !given_names.is_none()) image = names[i];
    survey.given.num_found += survey.detections.back().detection.hasCorners() ? 1 : 0;
    ++i;
  }
  survey.given.num_images = list.size();
  return fromSurvey(std::move(survey));
}

void requireViews(const ViewsValue& value) {
  constexpr std::size_t kMostReasons = 12;
  if (value.views.size() >= static_cast<std::size_t>(kMinViews)) return;
  std::vector<std::string> reasons = value.given.reasons;
  if (reasons.size() > kMostReasons) reasons.resize(kMostReasons);
  throw inputError({.where = "calibrate()",
                    .found = "only " + std::to_string(value.views.size()) + " of " +
                             std::to_string(value.given.num_images) + " views are usable",
                    .expected = "at least " + std::to_string(kMinViews),
                    .next_step = reasons.empty()
                                     ? "take more photographs of the board, tilted by 20 to 50 degrees"
                                     : join(reasons, "\n        ")});
}

BoardShapeMode shapeModeOf(const std::string& name) {
  if (const auto mode = boardShapeMode(name)) return *mode;
  throw usageError(
      {.where = "board_shape",
       .found = "'" + name + "'",
       .expected = join(std::vector<std::string>(kBoardShapeModes.begin(), kBoardShapeModes.end()), ", ")});
}

CalibrationValue calibrated(const py::object& views, const py::object& board, const py::kwargs& given) {
  Keywords keywords("calibrate", given);
  CalibrationValue value{
      .result = {},
      .from = {},
      .guidance = {},
      .options = calibratorOptions(keywords),
      .record = bareRecord(AnyCamera::make("pinhole", std::vector<double>{1, 1, 0, 0}), {1, 1}, "")};
  value.options.correction_cells =
      keywords.take<std::optional<std::array<int, 2>>>("correction", std::nullopt);
  if (const auto initial = keywords.take<py::object>("initial", py::none()); !initial.is_none()) {
    const CameraRecord& record = initial.cast<const CameraValue&>().record;
    value.options.initial = {.camera = record.camera, .size = record.image_size};
  }
  const CameraName name{.name = keywords.take<std::string>("name", ""),
                        .serial = keywords.take<std::string>("serial", ""),
                        .lens = {}};
  const auto progress = keywords.take<py::object>("progress", py::none());
  const ViewsArguments arguments = viewsArguments(keywords);
  keywords.finish();
  value.options.jobs = arguments.search.jobs;
  value.from = gatheredViews(views, board, arguments, progress);
  requireViews(value.from);
  runInterruptibly(progress, [&](const CancelFlag* cancel, const ReportProgress& report) {
    report("calibrating", 0, 1);
    CalibratorOptions options = value.options;
    options.cancel = cancel;
    value.result = calibrate(value.from.boards, value.from.views, options);
    value.guidance = guide(value.result, value.from.views);
    value.record = recordOf(value.result, creatorName(), name);
    report("calibrating", 1, 1);
  });
  return value;
}

// Images for a notebook or a page: those that are files, and frames of videos.
PageOptions pageOptions(const ViewsValue& from) {
  std::vector<std::string> paths;
  std::map<std::string, std::size_t> index_of;
  for (const auto& [name, path] : from.paths) {
    index_of[name] = paths.size();
    paths.push_back(path);
  }
  const ImageOfView image_of = [index_of, set = openNamed(paths)](const std::string& name) {
    const auto found = index_of.find(name);
    std::optional<GrayImage> image;
    if (found == index_of.end()) return image;
    try {
      image = set.read(found->second).decode().image;
    } catch (const Error&) {
      return image;  // the page shows the corners instead
    }
    return image;
  };
  return {.pictures = {{.image_of = image_of}}};
}

void writeReport(const CalibrationValue& self, const py::object& path) {
  const std::string file = pathOf(path);
  const py::gil_scoped_release without_lock;
  writeFileAtomically(file, reportPage(self.evidence(), "the evidence", pageOptions(self.from)));
}

std::string titleOf(const CalibrationValue& self) {
  const auto& accuracy = self.result.uncertainty.accuracy;
  std::string text = onlyCamera(self.result.fit).model + ", " + sizeText(self.result.imageSize()) + " px, " +
                     std::string(verdictName(self.result.verdict()));
  if (accuracy)
    text += ", within " + numberText("%.2g", accuracy->covered_px) + " px (95 %) where boards were seen";
  return text + ", RMS " + numberText("%.3f", rms(self.result.fit)) + " px, " +
         std::to_string(self.result.fit.views.size()) + " views";
}

py::str htmlOf(const CalibrationValue& self) {
  std::vector<FigureFile> figures;
  {
    const py::gil_scoped_release without_lock;
    figures = reportFigures(self.evidence(), "the evidence");
  }
  return resultHtml(titleOf(self), self.result.diagnoses, figures,
                    {{"accuracy.svg", "Error of a projected point, 95 %, and where boards were seen"},
                     {"image-residuals.svg", "Errors of the corners over the image"}});
}

void save(const CalibrationValue& self, const py::object& path, const std::string& format,
          bool keep_untrustworthy) {
  const std::string file = pathOf(path);
  requireUsable(self.result.diagnoses, file, keep_untrustworthy);
  const py::gil_scoped_release without_lock;
  saveCamera(file, self.record, format);
}

// The views of a result, each with a reference to it.
struct ViewValue {
  std::shared_ptr<const CalibrationValue> of;
  std::size_t index;
  ViewSummary summary;

  [[nodiscard]] const FitView& view() const { return of->result.fit.views[index]; }
};

std::vector<ViewValue> viewsOfResult(const std::shared_ptr<CalibrationValue>& self) {
  std::vector<ViewValue> views;
  for (const ViewSummary& summary : viewSummaries(self->result))
    views.push_back({self, views.size(), summary});
  return views;
}

py::object accuracyOfResult(const CalibrationValue& self) {
  if (!self.result.uncertainty.accuracy) return py::none();
  return py::cast(*self.result.uncertainty.accuracy);
}

double accuracyPx(const CalibrationValue& self) {
  const auto& accuracy = self.result.uncertainty.accuracy;
  return accuracy ? accuracy->covered_px : std::numeric_limits<double>::quiet_NaN();
}

template <class T, class Values>
py::array_t<T> gridArray(const Accuracy& self, const Values& values) {
  py::array_t<T> array({static_cast<py::ssize_t>(self.rows), static_cast<py::ssize_t>(self.columns)});
  std::copy(values.begin(), values.end(), array.mutable_data());
  return array;
}

void bindAccuracy(py::module_& module) {
  py::class_<Accuracy>(module, "AccuracyMap", doc("AccuracyMap"))
      .def_property_readonly(
          "pixels",
          [](const Accuracy& self) -> py::object {
            return pixelsArray(self.pixels).attr("reshape")(self.rows, self.columns, 2);
          },
          doc("AccuracyMap.pixels"))
      .def_property_readonly(
          "error_px", [](const Accuracy& self) { return gridArray<double>(self, self.error_px); },
          doc("AccuracyMap.error_px"))
      .def_property_readonly(
          "is_covered", [](const Accuracy& self) { return gridArray<bool>(self, self.is_covered); },
          doc("AccuracyMap.is_covered"))
      .def_readonly("distance_m", &Accuracy::distance_m, doc("AccuracyMap.distance_m"))
      .def_readonly("covered_share", &Accuracy::covered_share, doc("AccuracyMap.covered_share"))
      .def_readonly("covered_px", &Accuracy::covered_px, doc("AccuracyMap.covered_px"))
      .def_readonly("worst_px", &Accuracy::worst_px, doc("AccuracyMap.worst_px"))
      .def("share_within", &Accuracy::shareWithin, "tolerance_px"_a, doc("AccuracyMap.share_within"))
      .def("__repr__", [](const Accuracy& self) {
        return "<alidade.AccuracyMap: " + std::to_string(self.columns) + "x" + std::to_string(self.rows) +
               ", within " + numberText("%.2g", self.covered_px) + " px (95 %) where boards were seen>";
      });
}

void bindFinding(py::module_& module) {
  py::class_<Diagnosis>(module, "Finding", doc("Finding"))
      .def_property_readonly(
          "severity", [](const Diagnosis& self) { return std::string(severityName(self.severity)); },
          doc("Finding.severity"))
      .def_property_readonly(
          "id", [](const Diagnosis& self) { return std::string(self.id); }, doc("Finding.id"))
      .def_property_readonly("message", &Diagnosis::message, doc("Finding.message"))
      .def_readonly("next_step", &Diagnosis::next_step, doc("Finding.next_step"))
      .def_readonly("effect_px", &Diagnosis::effect_px, doc("Finding.effect_px"))
      .def("__repr__", [](const Diagnosis& self) {
        return "<alidade.Finding: " + std::string(severityName(self.severity)) + ", " + std::string(self.id) +
               ": " + self.message() + ">";
      });
}

void bindView(py::module_& module) {
  py::class_<ViewValue>(module, "CalibrationView", doc("CalibrationView"))
      .def_property_readonly(
          "image", [](const ViewValue& self) { return nameText(self.summary.image); },
          doc("CalibrationView.image"))
      .def_property_readonly(
          "board",
          [](const ViewValue& self) { return self.of->result.fit.boards[self.summary.board].target; },
          doc("CalibrationView.board"))
      .def_property_readonly(
          "ids",
          [](const ViewValue& self) {
            py::array_t<int> ids(static_cast<py::ssize_t>(self.view().corners.size()));
            std::ranges::transform(self.view().corners, ids.mutable_data(), &Observation::id);
            return ids;
          },
          doc("CalibrationView.ids"))
      .def_property_readonly(
          "pixels",
          [](const ViewValue& self) {
            std::vector<Eigen::Vector2d> pixels;
            for (const Observation& corner : self.view().corners)
              pixels.push_back(seenPixel(onlyCamera(self.of->result.fit), corner.pixel));
            return pixelsArray(pixels);
          },
          doc("CalibrationView.pixels"))
      .def_property_readonly(
          "residuals", [](const ViewValue& self) { return pixelsArray(self.view().errors); },
          doc("CalibrationView.residuals"))
      .def_property_readonly(
          "camera_from_board",
          [](const ViewValue& self) { return poseArray(cameraFromBoard(self.of->result.fit, self.view())); },
          doc("CalibrationView.camera_from_board"))
      .def_property_readonly(
          "rms_px", [](const ViewValue& self) { return self.summary.rms_px; }, doc("CalibrationView.rms_px"))
      .def_property_readonly(
          "max_error_px", [](const ViewValue& self) { return self.summary.max_error_px; },
          doc("CalibrationView.max_error_px"))
      .def_property_readonly(
          "num_outliers", [](const ViewValue& self) { return self.summary.num_outliers; },
          doc("CalibrationView.num_outliers"))
      .def("__repr__", [](const ViewValue& self) {
        return "<alidade.CalibrationView: " + self.summary.image + ", " +
               std::to_string(self.summary.num_corners) + " corners, RMS " +
               numberText("%.3f", self.summary.rms_px) + " px>";
      });
}

void bindResult(py::module_& module) {
  py::class_<CalibrationValue, std::shared_ptr<CalibrationValue>>(module, "Calibration", doc("Calibration"))
      .def_property_readonly(
          "camera", [](const CalibrationValue& self) { return CameraValue{self.record}; },
          doc("Calibration.camera"))
      .def_property_readonly(
          "verdict",
          [](const CalibrationValue& self) { return std::string(verdictName(self.result.verdict())); },
          doc("Calibration.verdict"))
      .def_property_readonly(
          "is_usable", [](const CalibrationValue& self) { return self.result.isUsable(); },
          doc("Calibration.is_usable"))
      .def_property_readonly("accuracy_px", &accuracyPx, doc("Calibration.accuracy_px"))
      .def_property_readonly("accuracy", &accuracyOfResult, doc("Calibration.accuracy"))
      .def_property_readonly(
          "rms_px", [](const CalibrationValue& self) { return rms(self.result.fit); },
          doc("Calibration.rms_px"))
      .def_property_readonly(
          "holdout_rms_px",
          [](const CalibrationValue& self) { return self.result.uncertainty.holdout.rms_px; },
          doc("Calibration.holdout_rms_px"))
      .def_property_readonly(
          "findings",
          [](const CalibrationValue& self) { return findingsFrom(self.result.diagnoses, Severity::kPass); },
          doc("Calibration.findings"))
      .def_property_readonly(
          "warnings",
          [](const CalibrationValue& self) {
            return findingsFrom(self.result.diagnoses, Severity::kWarning);
          },
          doc("Calibration.warnings"))
      .def_property_readonly("views", &viewsOfResult, doc("Calibration.views"))
      .def_property_readonly(
          "reasons", [](const CalibrationValue& self) { return self.from.given.reasons; },
          doc("Calibration.reasons"))
      .def_property_readonly(
          "next_view",
          [](const CalibrationValue& self) {
            return shortNextViewText(self.guidance, self.result.imageSize());
          },
          doc("Calibration.next_view"))
      .def_property_readonly(
          "evidence",
          [](const CalibrationValue& self) {
            return py::module_::import("json").attr("loads")(jsonText(self.evidence()));
          },
          doc("Calibration.evidence"))
      .def("save", &save, "path"_a, "format"_a = "alidade", py::kw_only(), "keep_untrustworthy"_a = false,
           doc("Calibration.save"))
      .def("report", &writeReport, "path"_a, doc("Calibration.report"))
      .def("__repr__",
           [](const CalibrationValue& self) { return "<alidade.Calibration: " + titleOf(self) + ">"; })
      .def("_repr_html_", &htmlOf);
}

}  // namespace

ViewsArguments viewsArguments(Keywords& keywords) {
  ViewsArguments arguments;
  arguments.search.names = keywords.take<py::object>("names", py::none());
  arguments.search.color = keywords.take<std::string>("color", "bgr");
  arguments.search.num_frames = keywords.take<std::size_t>("num_frames", 100);
  arguments.search.cache = keywords.take<py::object>("cache", py::none());
  arguments.search.jobs = keywords.take<int>("jobs", 0);
  arguments.image_size = keywords.take<py::object>("image_size", py::none());
  arguments.sigma_px = keywords.take<py::object>("sigma_px", py::none());
  return arguments;
}

ViewsValue gatheredViews(const py::object& views, const py::object& board, const ViewsArguments& arguments,
                         const py::object& progress) {
  if (py::isinstance<SurveyValue>(views)) return fromSurvey(views.cast<SurveyValue>());
  if (isListOf(views, [](const py::handle& item) { return py::isinstance<DetectionValue>(item); })) {
    std::vector<Board> boards;
    if (board.is_none()) {
      for (const py::handle item : views) {
        const Board of = item.cast<DetectionValue>().board;
        if (std::ranges::find(boards, of) == boards.end()) boards.push_back(of);
      }
    } else {
      boards = boardsOf(board);
    }
    return fromDetections(views, boards, arguments.search.names);
  }
  if (board.is_none()) {
    throw usageError({.where = "calibrate()",
                      .found = "no board",
                      .expected = "a Board or its SPEC, for example 'checkerboard:9x6:25mm'"});
  }
  const std::vector<Board> boards = boardsOf(board);
  if (areImages(views)) return fromSurvey(surveyOf(views, boards, arguments.search, progress));
  return fromCorners(views, boards, arguments);
}

CalibratorOptions calibratorOptions(Keywords& keywords) {
  CalibratorOptions options{.model = keywords.take<std::string>("model", kAutoModel),
                            .held = keywords.take<std::vector<std::string>>("fix", {}),
                            .same_focal = keywords.take<bool>("same_focal", false)};
  options.board_shape = shapeModeOf(keywords.take<std::string>("board_shape", "auto"));
  options.num_pupil = keywords.take<std::optional<std::size_t>>("pupil", std::nullopt);
  options.tolerance_px = keywords.take<double>("tolerance_px", 1);
  options.distance_m = keywords.take<double>("distance_m", std::numeric_limits<double>::infinity());
  for (const auto& [name, value] :
       {std::pair("tolerance_px", options.tolerance_px), std::pair("distance_m", options.distance_m)}) {
    if (!(value > 0))
      throw usageError({.where = name, .found = numberText("%g", value), .expected = "a number above 0"});
  }
  return options;
}

py::list findingsFrom(const std::vector<Diagnosis>& findings, Severity least) {
  py::list list;
  for (const Diagnosis& finding : findings) {
    if (finding.severity >= least) list.append(finding);
  }
  return list;
}

void requireUsable(const std::vector<Diagnosis>& findings, const std::string& path, bool keep_untrustworthy) {
  if (keep_untrustworthy || verdictOf(findings) != Verdict::kNo) return;
  const Diagnosis& worst = findings.front();
  throw Error(ErrorCode::kVerdict,
              {.where = path,
               .found = "not written, because the result must not be used: " + worst.message(),
               .next_step = worst.next_step});
}

py::str resultHtml(const std::string& title, const std::vector<Diagnosis>& findings,
                   const std::vector<FigureFile>& figures, const std::vector<CaptionedFigure>& shown) {
  const py::object escape = py::module_::import("html").attr("escape");
  const auto escaped = [&](const std::string& text) { return escape(nameText(text)).cast<std::string>(); };
  std::string html = title.empty() ? "" : "<p><b>" + escaped(title) + "</b></p>";
  std::string list;
  for (const Diagnosis& finding : findings) {
    if (finding.severity < Severity::kWarning) continue;
    list += "<li>" + escaped(std::string(severityName(finding.severity)) + ": " + finding.message());
    if (!finding.next_step.empty()) list += "; " + escaped(finding.next_step);
    list += "</li>";
  }
  if (!list.empty()) html += "<ul>" + list + "</ul>";
  // As separate pictures, because the style of a drawing must not affect the notebook or other drawings.
  for (const CaptionedFigure& figure : shown) {
    const auto file = std::ranges::find(figures, figure.file, &FigureFile::name);
    if (file == figures.end()) continue;
    const py::object encoded =
        py::module_::import("base64").attr("b64encode")(py::bytes(file->svg)).attr("decode")();
    html += "<figure style=\"display: inline-block; width: 46%; margin: 1%\"><figcaption>" +
            escaped(figure.caption) + "</figcaption><img style=\"width: 100%\" alt=\"" +
            escaped(figure.caption) + "\" src=\"data:image/svg+xml;base64," + encoded.cast<std::string>() +
            "\"></figure>";
  }
  return html;
}

void bindCalibration(py::module_& module) {
  bindFinding(module);
  bindAccuracy(module);
  bindView(module);
  bindResult(module);
  module.def(
      "calibrate",
      [](const py::object& views, const py::object& board, const py::kwargs& options) {
        return std::make_shared<CalibrationValue>(calibrated(views, board, options));
      },
      "views"_a, "board"_a = py::none(), doc("calibrate"));
}

}  // namespace alidade::python
