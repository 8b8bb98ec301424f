// SPDX-License-Identifier: MIT
#pragma once

#include <cstddef>
#include <optional>
#include <string>
#include <vector>

#include "alidade/report/canvas/figure_canvas.h"
#include "alidade/report/data/report_data.h"
#include "alidade/report/figures/page_pictures.h"

namespace alidade {

// Figures of a camera and of views of boards.

// Figures over the image (image_figures.cc).

/// The 95 % error of a projected point, as areas between multiples of the tolerance, with contours.
/// @pre there is an accuracy
/// @param is_by_covariance  computed only from the covariance in a camera file
[[nodiscard]] Figure accuracyFigure(const ReportData& data, bool is_by_covariance = false);
/// The used corners, and their number in each cell of the image.
[[nodiscard]] Figure coverageFigure(const CalibrationEvidence& data);
/// Reprojection errors as arrows: a sample of single corners, and the mean and RMS in each cell. Cells carry
/// their RMS and their count as data-rms and data-count.
[[nodiscard]] Figure imageResidualsFigure(const ReportData& data);
/// Displacement of distant points between the calibrated camera and the other one, after the best rotation.
/// @throws Error (kInput) for a camera with a different image aspect ratio
[[nodiscard]] Figure differenceFigure(const ReportData& data, const RivalCamera& rival);
/// The image of the view with the largest board, without distortion, with straight lines through the rows and
/// columns of the board. Nothing without an image.
[[nodiscard]] std::optional<Figure> undistortedFigure(const ReportData& data, const ImageOfView& image_of);
/// The name of the image that this figure shows; empty without views.
[[nodiscard]] std::string undistortedImageName(const ReportData& data);

// Figures of the lens (lens_figures.cc).

/// What the lens does: its distortion and, where it has one, its moving pupil and its correction field.
[[nodiscard]] std::vector<Figure> lensFigures(const ReportData& data);
/// The correlations of the estimated parameters. @pre there is a covariance
[[nodiscard]] Figure correlationFigure(const ReportData& data);

// Figures of the reprojection errors (residual_figures.cc).

/// Apparent displacement of each point on a board, over all views that show it.
/// @param board  index into ReportData::boards
[[nodiscard]] Figure boardResidualsFigure(const ReportData& data, std::size_t board);
/// The same for each board that views show.
[[nodiscard]] std::vector<Figure> boardResidualsFigures(const ReportData& data);
/// The distribution of the errors, with the normal curve of the same standard deviation. Bars carry their
/// count as data-count.
[[nodiscard]] Figure histogramFigure(const ReportData& data);
/// Quantiles of the errors over those of the normal distribution.
[[nodiscard]] Figure normalPlotFigure(const ReportData& data);

// Figures of the views: errors of each, and poses of the boards (view_figures.cc).

/// RMS and largest error of each view, in their order. Bars carry their view's index as data-view.
[[nodiscard]] Figure viewErrorsFigure(const ReportData& data);
/// Tilt of the board in each view, and the next one.
[[nodiscard]] Figure tiltFigure(const CalibrationEvidence& data);
/// Distance and tilt of the board in each view, and the next one.
[[nodiscard]] Figure distanceFigure(const CalibrationEvidence& data);
/// The photograph to take next, as seen by the photographer. @pre there is a next view
[[nodiscard]] Figure nextViewFigure(const CalibrationEvidence& data);
/// A small drawing of a view's corners in its image, for views without an image.
[[nodiscard]] std::string cornersPicture(const ReportData& data, const ReportedView& view);

}  // namespace alidade
