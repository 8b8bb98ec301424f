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
  return {.severity = Severity::kFailure, .id = id, .cause = error.what(), .evidence = {}, .limit = {}};
}

std::vector<CheckValue> valuesOf(const std::string& id, const HeldOutJudgement& judgement,
                                 double tolerance_px) {
  if (id == "held_out_error") {
    return {{"rms_px", judgement.held_out_rms_px},
            {"noise_rms_px", judgement.noise_rms_px},
            {"tolerance_px", tolerance_px},
            {"num_corners", static_cast<double>(judgement.num_corners)},
            {"num_views", static_cast<double>(judgement.views.size())}};
  }
  if (id != "images_agree" || !judgement.difference) return {};
  return {{"p95_px", judgement.difference->p95_px},
          {"tolerance_px", tolerance_px},
          {"covered_share", judgement.covered_share}};
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

void HeldOutStage::addChecks(const StatedCamera& camera, const std::string& file,
                             CameraJudgement& judgement) const {
  std::vector<FileCheck>& checks = judgement.checks;
  if (given_) {
    try {
      const CameraRecord record = recordOf(camera, file);
      const Checkerboard& board = given_->input.board;
      const HeldOutJudgement on_images = judgeOnImages(
          compared(record), board, given_->views,
          {.is_covariance_by_views = isStatedByViews(record), .jobs = jobs_, .cancel = cancel_});
      const std::vector<Diagnosis> held_out = heldOutChecks(on_images, tolerance_px_);
      for (const Diagnosis& check : held_out) {
        checks.push_back(fileCheck(check));
        checks.back().values = valuesOf(check.id, on_images, tolerance_px_);
      }
      if (record.calibration && !record.calibration->views.empty()) {
        checks.push_back(fileCheck(
            ownImagesCheck(record.calibration->views, board, on_images.views, on_images.num_views_given)));
      }
      if (!isAnyUndecided(held_out)) judgement.can_show_slips = true;
    } catch (const Error& error) {
      checks.push_back(fileCheck(failedCheck("held_out_error", error)));
    }
  }
  if (other_) {
    try {
      const CameraRecord record = recordOf(camera, file);
      const Diagnosis check = againstCheck(compared(record), compared(*other_), tolerance_px_);
      checks.push_back(fileCheck(check));
      if (!check.is_undecided) judgement.can_show_slips = true;
    } catch (const Error& error) {
      checks.push_back(fileCheck(failedCheck("against", error)));
    }
  }
}

}  // namespace alidade
