// SPDX-License-Identifier: MIT
#pragma once

#include <cstddef>
#include <span>
#include <string>
#include <vector>

#include "alidade/adjust/board/fit.h"
#include "alidade/calibrate/start/calibration_options.h"
#include "alidade/calibrate/start/reports.h"
#include "alidade/calibrate/uncertainty/uncertainty.h"
#include "alidade/camera/any_camera.h"
#include "alidade/camera/image_domain.h"
#include "alidade/core/diagnosis.h"
#include "alidade/record/camera_record.h"
#include "alidade/target/board.h"
#include "alidade/target/view.h"

namespace alidade {

/// A calibrated camera, and what is known about it.
struct Calibration {
  Fit fit = {};                           ///< one camera; views in order of image name and board
  Dropped dropped = {};                   ///< corners and views that were given and are not in the fit
  Choice choice = {};                     ///< how the fit was found
  Uncertainty uncertainty = {};           ///< how accurate the camera is
  std::vector<Diagnosis> diagnoses = {};  ///< problems, failures first
  DomainCertificate domain = {};          ///< region in which the camera is one-to-one

  /// Created by each call.
  [[nodiscard]] AnyCamera camera() const;
  [[nodiscard]] ImageSize imageSize() const { return onlyCamera(fit).size; }
  [[nodiscard]] Verdict verdict() const { return verdictOf(diagnoses); }
  /// False if any diagnosis is a failure; the parameters must then not be used.
  [[nodiscard]] bool isUsable() const { return verdict() != Verdict::kNo; }
};

/// Calibrates one camera from views of one board or of several; an initial guess is not needed. An image may
/// show several boards: each is a view of its own, with the index of its board in View::board. The views are
/// sorted by image name and board first, so the result does not depend on their order. Corners that state
/// different sigmas are weighted (CornerNoise).
/// @throws Error (kInput) for fewer than kMinViews views, views without a name or size, views of different
/// image sizes, two views of one board in one image, a board index that does not exist, corner ids that the
/// board does not have or that occur twice in a view, corners that are not finite, negative sigmas, views
/// that no camera explains, or an initial camera of a different image size; Error (kUsage) for a board
/// without rows, columns or square size, an unknown model, an unknown fixed parameter, or a fixed parameter
/// without a value; Cancelled. A poor result does not throw: see Calibration::diagnoses. Views that cannot be
/// used are left out: see Calibration::dropped.
[[nodiscard]] Calibration calibrate(std::span<const Board> boards, std::vector<View> views,
                                    const CalibratorOptions& options = {});
[[nodiscard]] Calibration calibrate(const Board& board, std::vector<View> views,
                                    const CalibratorOptions& options = {});

/// All problems found with a calibration, failures first; pure judgement, no estimation.
///
/// A failure makes the answer wrong or meaningless whatever the tolerance. Every other diagnosis states its
/// effect in pixels, from which its severity follows by severityOf().
/// @param calibration   all but its `diagnoses`
/// @param tolerance_px  see CalibratorOptions
[[nodiscard]] std::vector<Diagnosis> judge(const Calibration& calibration, double tolerance_px = 1);

/// Outcome of a calibration for one view.
struct ViewSummary {
  std::string image;
  std::size_t board = 0;  ///< index into Fit::boards
  int num_corners = 0;    ///< used, outliers left out
  int num_outliers = 0;
  double rms_px = 0;  ///< sqrt(mean over used corners of dx^2 + dy^2)
  double max_error_px = 0;
};

/// One per view of the fit.
[[nodiscard]] std::vector<ViewSummary> viewSummaries(const Calibration& calibration);

/// All that a camera file holds of a calibration: the camera with its domain and self-check points,
/// accuracy, covariance, verdict and findings. Write it with saveCamera().
/// @param created_by  program and version
[[nodiscard]] CameraRecord recordOf(const Calibration& calibration, std::string created_by,
                                    CameraName name = {});

}  // namespace alidade
