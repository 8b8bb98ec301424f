// SPDX-License-Identifier: MIT
#include "held_out_stage.h"

#include <filesystem>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include <fmt/format.h>
#include <CLI/CLI.hpp>

#include "alidade/core/error.h"
#include "camera_options.h"
#include "interrupt.h"
#include "number_check.h"
#include "uncertainty_record.h"

namespace alidade {
namespace {

ComparedCamera compared(const CameraFile& file) {
  return {.camera = &file.camera, .size = file.image_size, .covariance = statedCovariance(file)};
}

Check failedCheck(const char* id, const Error& error) {
  return {.id = id,
          .status = CheckStatus::kFail,
          .value = "not possible",
          .limit = "a camera of the same image",
          .message = error.what()};
}

}  // namespace

void HeldOutStage::addOptions(CLI::App& app) {
  app.add_option(
      "--images", images_,
      "Images of a board that the camera was not calibrated from: folders, files or patterns, or one "
      "corners file (.csv)");
  addBoardOption(app, board_);
  app.add_option("--against", against_, "Camera file to compare with, of any format");
  app.add_option("--tolerance", tolerance_px_,
                 "Pixels by which 95 % of the image may be off, for --images and --against")
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

std::optional<Check> HeldOutStage::ownImagesCheck(const CameraFile& file) const {
  if (!file.calibration || file.calibration->views.empty()) return std::nullopt;
  const auto nameOf = [](const std::string& image) {
    return std::filesystem::path(image).filename().string();
  };
  std::set<std::string> own;
  for (const ViewRecord& view : file.calibration->views) own.insert(nameOf(view.image));
  std::vector<std::string> shared;
  for (const View& view : given_->views) {
    if (own.contains(nameOf(view.image))) shared.push_back(view.image);
  }
  const bool is_clean = shared.empty();
  return Check{
      .id = "held_out_names",
      .status = is_clean ? CheckStatus::kPass : CheckStatus::kWarn,
      .value = fmt::format("{} of {} images", shared.size(), given_->views.size()),
      .limit = "none named like the images of the file's own calibration",
      .message =
          is_clean ? "the images have other names than those that the camera was calibrated from"
                   : "images have the names of the file's own views, such as " + shared.front() +
                         ": if they are the same, they were fitted and cannot show that the camera is wrong; "
                         "take others"};
}

void HeldOutStage::addChecks(const StatedCamera& camera, FileJudgement& judgement) const {
  std::vector<Check>& checks = judgement.checks;
  if (given_) {
    try {
      const CameraFile file = cameraFileOf(camera, judgement.file);
      const std::vector<Check> held_out = heldOutChecks(
          judgeOnImages(compared(file), given_->input.board, given_->views,
                        {.is_covariance_by_views = isStatedByViews(file), .jobs = jobs_, .cancel = cancel_}),
          tolerance_px_);
      checks.insert(checks.end(), held_out.begin(), held_out.end());
      if (auto check = ownImagesCheck(file)) checks.push_back(*std::move(check));
      judgement.can_show_slips = true;
    } catch (const Error& error) {
      checks.push_back(failedCheck("held_out_error", error));
    }
  }
  if (other_) {
    try {
      const CameraFile file = cameraFileOf(camera, judgement.file);
      checks.push_back(againstCheck(compared(file), compared(*other_), tolerance_px_));
      judgement.can_show_slips = true;
    } catch (const Error& error) {
      checks.push_back(failedCheck("against", error));
    }
  }
}

}  // namespace alidade
