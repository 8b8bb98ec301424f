// SPDX-License-Identifier: MIT
#pragma once

#include <string>
#include <vector>

#include "alidade/calibrate/start/calibration_options.h"
#include "alidade/core/diagnosis.h"
#include "alidade/report/pages/page_shell.h"
#include "detection.h"
#include "keywords.h"

namespace alidade::python {

/// The input of a calibration.
struct ViewsValue {
  std::vector<Board> boards;
  std::vector<View> views;
  GivenImages given;
  std::vector<std::pair<std::string, std::string>> paths = {};  ///< as in SurveyValue
  std::vector<std::string> images = {};                         ///< all that were searched; empty if unknown
};

/// Keyword arguments for finding or reading views, which calibrate() and calibrate_rig() share.
struct ViewsArguments {
  SearchArguments search = {};
  py::object image_size = py::none();
  py::object sigma_px = py::none();
};
[[nodiscard]] ViewsArguments viewsArguments(Keywords& keywords);

/// The views from images, a Survey, detections or corner arrays.
[[nodiscard]] ViewsValue gatheredViews(const py::object& views, const py::object& board,
                                       const ViewsArguments& arguments, const py::object& progress);

/// Options for one camera, from the keyword arguments that calibrate() and calibrate_rig() share.
[[nodiscard]] CalibratorOptions calibratorOptions(Keywords& keywords);

/// A figure of the report, and its caption.
struct CaptionedFigure {
  std::string file;  ///< as FigureFile::name
  std::string caption;
};

/// HTML of a result for a notebook: title, warnings and some figures of the report. The title may be empty.
[[nodiscard]] py::str resultHtml(const std::string& title, const std::vector<Diagnosis>& findings,
                                 const std::vector<FigureFile>& figures,
                                 const std::vector<CaptionedFigure>& shown);

/// The findings of at least this severity, as a list for Python.
[[nodiscard]] py::list findingsFrom(const std::vector<Diagnosis>& findings, Severity least);

/// Refuses to write a rejected result. @throws Error (kVerdict)
void requireUsable(const std::vector<Diagnosis>& findings, const std::string& path, bool keep_untrustworthy);

}  // namespace alidade::python
