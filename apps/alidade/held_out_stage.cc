// SPDX-License-Identifier: MIT
#include "held_out_stage.h"

#include <algorithm>
#include <string>
#include <vector>

#include <CLI/CLI.hpp>

#include "alidade/core/error.h"
#include "alidade/record/camera_record.h"
#include "alidade/validate/held_out/own_images.h"
#include "camera_options.h"
#include "interrupt.h"
#include "number_check.h"

namespace alidade {
namespace {

ComparedCamera compared(const CameraRecord& file) {
  return {.camera = &file.camera, .size = file.image_size, .covariance = statedCovariance(file)};
}

Diagnosis failedCheck(const char* id, const Error& error) {
  return {.severity = Severity::kFailure,
          .id = id,
          .cause = error.what(),
          .evidence = "not possible",
          .limit = "a camera of the same image"};
}

bool isAnyUndecided(const std::vector<Diagnosis>& checks) {
  return std::any_of(checks.begin(), checks.end(), [](const Diagnosis& check) { return check.is_undecided; });
}

}  // namespace

void HeldOutStage::addOptions(CLI::App& app) {
  app.add_option(
      "--images", images_,
      "Images of a board that were not used for the calibration: folders, files or patterns, or one "
      "corners file (.csv)");
  addBoardOption(app, board_);
  app.add_option("--against", against_, "Camera file (any format) to compare with");
  app.add_option(
         "--tolerance", tolerance_px_,
         "Largest accepted error in pixels (95th percentile over the image), for --images and --against")
      ->check(positiveNumber(), "above 0")
      ->capture_default_str();
}

void HeldOutStage::prepare(const CommonOptions& options) {
  if (images_.empty() && !board_.empty()) {
    throw usageError({.where = "validate",
                      .found = "--board without --images",
                      .expected = "--images FOLDER, whose images show the board"});
  }
  if (!against_.empty()) other_ = readCameraTelling(against_, {}, options.quiet);
  if (images_.empty()) return;
  jobs_ = options.jobs;
  cancel_ = catchInterrupts();
  given_ = readViews({.command = "validate", .inputs = images_, .board = board_, .debug_folder = {}}, options,
                     cancel_);
  if (options.quiet) return;
  for (const std::string& reason : given_->input.reasons) printMessage("  " + reason);
  for (const std::string& note : given_->input.notes) printMessage("note: " + note);
}

void HeldOutStage::addChecks(const StatedCamera& camera, FileJudgement& judgement) const {
  std::vector<Diagnosis>& checks = judgement.checks;
  if (given_) {
    try {
      const CameraRecord file = recordOf(camera, judgement.file);
      const Checkerboard& board = given_->input.board;
      const HeldOutJudgement on_images =
          judgeOnImages(compared(file), board, given_->views,
                        {.is_covariance_by_views = isStatedByViews(file), .jobs = jobs_, .cancel = cancel_});
      const std::vector<Diagnosis> held_out = heldOutChecks(on_images, tolerance_px_);
      checks.insert(checks.end(), held_out.begin(), held_out.end());
      if (file.calibration && !file.calibration->views.empty()) {
        checks.push_back(
            ownImagesCheck(file.calibration->views, board, on_images.views, on_images.num_views_given));
      }
      if (!isAnyUndecided(held_out)) judgement.can_show_slips = true;
    } catch (const Error& error) {
      checks.push_back(failedCheck("held_out_error", error));
    }
  }
  if (other_) {
    try {
      const CameraRecord file = recordOf(camera, judgement.file);
      checks.push_back(againstCheck(compared(file), compared(*other_), tolerance_px_));
      if (!checks.back().is_undecided) judgement.can_show_slips = true;
    } catch (const Error& error) {
      checks.push_back(failedCheck("against", error));
    }
  }
}

}  // namespace alidade
