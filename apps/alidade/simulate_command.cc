// SPDX-License-Identifier: MIT
#include <filesystem>

#include <unistd.h>

#include <fmt/format.h>
#include <CLI/CLI.hpp>
#include <nlohmann/json.hpp>

#include "alidade/camera/self_check.h"
#include "alidade/core/error.h"
#include "alidade/io/atomic_file.h"
#include "alidade/io/camera_file.h"
#include "alidade/io/corners_file.h"
#include "alidade/io/image_file.h"
#include "alidade/io/scene_file.h"
#include "alidade/simulate/observe.h"
#include "command.h"
#include "interrupt.h"
#include "progress.h"

namespace alidade {
namespace {

namespace fs = std::filesystem;

/// A folder that appears under its name only when it is complete; until then it has another one beside it.
class PendingFolder {
 public:
  PendingFolder(fs::path target, bool may_replace) : target_(std::move(target)) {
    if (!target_.has_filename()) target_ = target_.parent_path();
    std::error_code error;
    const bool is_there = fs::exists(target_, error);
    if (is_there && !fs::is_directory(target_, error)) {
      throw inputError(
          {.where = target_.string(), .found = "a file", .expected = "the name of a folder to make"});
    }
    if (is_there && !fs::is_empty(target_, error) && !may_replace) {
      throw inputError(
          {.where = target_.string(),
           .found = "a folder that is not empty",
           .expected = "a new or empty folder",
           .next_step = "choose another name, or give --overwrite to replace the folder and all in it"});
    }
    const fs::path parent = target_.has_parent_path() ? target_.parent_path() : ".";
    pending_ = parent / fmt::format(".{}.{}.tmp", target_.filename().string(), getpid());
    make(pending_);
  }
  ~PendingFolder() {
    std::error_code ignored;
    if (!pending_.empty()) fs::remove_all(pending_, ignored);
  }
  PendingFolder(const PendingFolder&) = delete;
  PendingFolder& operator=(const PendingFolder&) = delete;

  void make(const fs::path& folder) const {
    std::error_code error;
    fs::create_directories(folder, error);
    if (!error) return;
    throw inputError({.where = folder.string(),
                      .found = "cannot make the folder: " + error.message(),
                      .expected = "a place that can be written to"});
  }

  [[nodiscard]] std::string path(const std::string& name) const { return (pending_ / name).string(); }

  void commit() {
    std::error_code error;
    fs::remove_all(target_, error);
    if (!error) fs::rename(pending_, target_, error);
    if (error)
      throw inputError({.where = target_.string(), .found = "cannot be put in place: " + error.message()});
    pending_.clear();
  }

 private:
  fs::path target_;
  fs::path pending_;
};

class SimulateCommand final : public Command {
 public:
  void setUp(CLI::App& app) override {
    app.footer(
        "Example: alidade simulate config/scene.yaml -o simulated\n"
        "Makes images/*.png, camera.yaml (the true camera), corners.csv (the true corners) and poses.yaml.");
    app.add_option("scene", scene_path_, "Scene file (YAML): camera, board, views");
    app.add_option("-o,--output", output_, "Folder to make");
    app.add_flag("--corners-only", corners_only_, "Only the truth, no images");
    app.add_flag("--overwrite", overwrite_, "Replace the output folder if it exists");
    addCommonOptions(app, common_, true);
  }

  int run(const CLI::App&) override {
    if (scene_path_.empty())
      throw usageError({.where = "simulate",
                        .found = "no scene file",
                        .expected = "a scene file (YAML)",
                        .next_step = "alidade simulate --help"});
    if (output_.empty())
      throw usageError({.where = "simulate", .found = "no --output", .expected = "-o FOLDER"});
    const CancelFlag* cancel = catchInterrupts();
    const Scene scene = readSceneFile(scene_path_);
    std::vector<SE3> poses = scene.camera_from_board;
    if (poses.empty()) {
      Random random(streamSeed(scene.seed, 0));
      poses = randomViews(scene.camera, scene.image_size, scene.board, scene.num_random_views, random,
                          scene.random_views);
    }
    std::vector<std::string> names;
    for (std::size_t i = 0; i < poses.size(); ++i) names.push_back(fmt::format("view_{:03}.png", i + 1));

    PendingFolder folder(output_, overwrite_);
    const CornersFile corners = trueCorners(scene, poses, names);
    writeCornersFile(folder.path("corners.csv"), corners);
    writeCameraFile(folder.path("camera.yaml"), trueCamera(scene));
    writeFileAtomically(folder.path("poses.yaml"), posesText(names, poses));
    if (!corners_only_) renderAll(scene, poses, names, folder, cancel);
    folder.commit();

    std::size_t num_corners = 0;
    for (const View& view : corners.views) num_corners += view.corners.size();
    if (common_.json) {
      printResult(
          nlohmann::json{{"folder", output_}, {"num_views", poses.size()}, {"num_corners", num_corners}}.dump(
              2) +
          "\n");
    } else if (!common_.quiet) {
      printResult(fmt::format("{}: {} views, {} corners{}\n", output_, poses.size(), num_corners,
                              corners_only_ ? ", no images" : ""));
    }
    return 0;
  }

 private:
  static CornersFile trueCorners(const Scene& scene, const std::vector<SE3>& poses,
                                 const std::vector<std::string>& names) {
    CornersFile file;
    file.board = scene.board;
    file.comments.push_back(fmt::format(
        "{} simulate; {}", programName(),
        scene.corner_noise_px > 0 ? fmt::format("noise of {} px an axis", scene.corner_noise_px) : "exact"));
    for (std::size_t i = 0; i < poses.size(); ++i) {
      View view = exactView(scene.camera, scene.image_size, scene.board, poses[i], names[i]);
      Random random(streamSeed(scene.seed, 1 + i));
      if (scene.corner_noise_px > 0) addCornerNoise(view, scene.corner_noise_px, random);
      file.views.push_back(std::move(view));
    }
    return file;
  }

  static CameraFile trueCamera(const Scene& scene) {
    const DomainCertificate domain = certifyDomain(scene.camera, scene.image_size);
    return {
        .camera = scene.camera,
        .image_size = scene.image_size,
        .domain = DomainClaim{.max_angle_rad = domain.cone.max_angle_rad, .full_image = domain.full_image},
        .self_check = makeSelfCheck(scene.camera, scene.image_size),
        .calibration = {},
        .created_by = programName()};
  }

  void renderAll(const Scene& scene, const std::vector<SE3>& poses, const std::vector<std::string>& names,
                 const PendingFolder& folder, const CancelFlag* cancel) const {
    folder.make(folder.path("images"));
    ProgressBar bar("rendering", common_.quiet);
    const Renderer renderer(scene.camera, scene.image_size, common_.jobs);
    for (std::size_t i = 0; i < poses.size(); ++i) {
      RenderOptions options = scene.render;
      options.num_jobs = common_.jobs;
      options.seed = streamSeed(scene.seed, 1'000'000 + i);
      writeGrayPng(folder.path("images/" + names[i]),
                   renderer.render(scene.board, poses[i], options, cancel));
      bar.update(i + 1, poses.size());
    }
  }

  std::string scene_path_;
  std::string output_;
  bool corners_only_ = false;
  bool overwrite_ = false;
};

}  // namespace

std::unique_ptr<Command> makeSimulateCommand() {
  return std::make_unique<SimulateCommand>();
}

}  // namespace alidade
