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

// Over the image (image_figures.cc).

/// The 95 % error of a projected point, as areas between multiples of the tolerance, with contours.
/// @pre there is an accuracy
/// @param is_by_covariance  it follows from a camera file, and nothing else is known
[[nodiscard]] Figure accuracyFigure(const ReportData& data, bool is_by_covariance = false);
/// The corners that were used, and how many lie in each cell of the image.
[[nodiscard]] Figure coverageFigure(const CalibrationEvidence& data);
/// Reprojection errors as arrows: a sample of single corners, and the mean and RMS in each cell. Cells carry
/// their RMS and their count as data-rms and data-count.
[[nodiscard]] Figure imageResidualsFigure(const ReportData& data);
/// Where the other camera projects distant points after the best rotation, compared with the calibrated one.
/// @throws Error (kInput) for a camera whose image has another shape
[[nodiscard]] Figure differenceFigure(const ReportData& data, const RivalCamera& rival);
/// An image without distortion, that of the view whose board takes most of it, with straight lines through
/// the rows and columns of the board. Nothing without an image.
[[nodiscard]] std::optional<Figure> undistortedFigure(const ReportData& data, const ImageOfView& image_of);
/// The name of the image that this figure shows; empty without views.
[[nodiscard]] std::string undistortedImageName(const ReportData& data);

// Of the lens (lens_figures.cc).

/// Straight lines of the scene as the camera shows them, over those of a pinhole camera.
[[nodiscard]] Figure distortionGridFigure(const ReportData& data);
/// Distance from the principal point over the angle from the optical axis, with the end of the model's domain
/// and of what boards covered.
[[nodiscard]] Figure radialFigure(const ReportData& data);
/// The correlations of the estimated parameters. @pre there is a covariance
[[nodiscard]] Figure correlationFigure(const ReportData& data);

// Of the reprojection errors (residual_figures.cc).

/// Where each point of a board seems to be displaced on the board, over all views that show it.
/// @param board  index into ReportData::boards
[[nodiscard]] Figure boardResidualsFigure(const ReportData& data, std::size_t board);
/// The same for each board that views show.
[[nodiscard]] std::vector<Figure> boardResidualsFigures(const ReportData& data);
/// The distribution of the errors, with the normal curve of the same standard deviation. Bars carry their
/// count as data-count.
[[nodiscard]] Figure histogramFigure(const ReportData& data);
/// Quantiles of the errors over those of the normal distribution.
[[nodiscard]] Figure normalPlotFigure(const ReportData& data);

// Of the views: how well each fits, and how the boards were held (view_figures.cc).

/// RMS and largest error of each view, in their order. Bars carry their view's index as data-view.
[[nodiscard]] Figure viewErrorsFigure(const ReportData& data);
/// Tilt of the board in each view, and the next one.
[[nodiscard]] Figure tiltFigure(const CalibrationEvidence& data);
/// Distance and tilt of the board in each view, and the next one.
[[nodiscard]] Figure distanceFigure(const CalibrationEvidence& data);
/// The photograph to take next as the photographer should see it. @pre there is a next view
[[nodiscard]] Figure nextViewFigure(const CalibrationEvidence& data);
/// A small drawing of a view's corners in its image, for views without an image.
[[nodiscard]] std::string cornersPicture(const ReportData& data, const ReportedView& view);

}  // namespace alidade
