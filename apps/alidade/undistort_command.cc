// SPDX-License-Identifier: MIT
#include <algorithm>
#include <filesystem>
#include <map>
#include <mutex>
#include <numbers>
#include <optional>
#include <set>

#include <fmt/format.h>
#include <CLI/CLI.hpp>
#include <nlohmann/json.hpp>

#include "alidade/camera/self_check.h"
#include "alidade/core/error.h"
#include "alidade/core/parallel.h"
#include "alidade/core/size_groups.h"
#include "alidade/core/text.h"
#include "alidade/files/camera_file.h"
#include "alidade/files/camera_source.h"
#include "alidade/imagery/image_file.h"
#include "alidade/imagery/image_list.h"
#include "alidade/imagery/projection_file.h"
#include "alidade/imagery/remap.h"
#include "alidade/imagery/undistortion_view.h"
#include "camera_options.h"
#include "command.h"
#include "interrupt.h"
#include "one_line.h"
#include "pending_folder.h"
#include "progress.h"
#include "undistort_files.h"

namespace alidade {
namespace {

constexpr double kDegrees = 180 / std::numbers::pi;
constexpr const char* kCameraName = "camera.yaml";
constexpr const char* kProjectionName = "projection.yaml";

// "1920x1200"; nothing for anything else.
std::optional<ImageSize> parseSize(const std::string& text) {
  const auto sides = split(text, 'x');
  if (sides.size() != 2) return std::nullopt;
  const auto width = parseInt(sides[0]);
  const auto height = parseInt(sides[1]);
  if (!width || !height || *width < 1 || *height < 1) return std::nullopt;
  return ImageSize{*width, *height};
}

// What comes of one image.
struct UndistortedImage {
  std::string image;   // short name
  std::string output;  // name in the output folder
  std::string reason;  // why there is no output; empty = there is
  int exif_orientation = 1;
};

class UndistortCommand final : public Command {
 public:
  void setUp(CLI::App& app) override {
    app.footer(
        "Example: alidade undistort camera.yaml photos/ -o undistorted\nWithout --fov and --keep, the focal "
        "length and the principal point are kept, scaled if --size is given.\nWrites PNG files with the "
        "colours and "
        "bit depth of the inputs (JPEG files for JPEG inputs), and camera.yaml, the\nmatching pinhole "
        "camera. The other projections get projection.yaml instead.");
    app.add_option("camera", camera_path_, "Camera file of any format (docs/formats.md)");
    app.add_option("input", inputs_, "Folders, image files or patterns");
    app.add_option("-o,--output", output_, "Folder to create");
    app.add_option("--projection", projection_,
                   "Output projection; rectilinear keeps straight lines straight")
        ->check(CLI::IsMember(projectionNames()))
        ->capture_default_str();
    app.add_option("--fov", fov_deg_, "Horizontal field of view in degrees");
    app.add_option("--keep", keep_,
                   "all: every input pixel is visible; valid: the largest view without black pixels")
        ->check(CLI::IsMember({"all", "valid"}));
    app.add_option("--size", size_, "Size of the output, for example 1280x720. Default: size of the input")
        ->check(
            [](const std::string& text) {
              return parseSize(text) ? std::string()
                                     : "--size: found '" + text + "', expected WIDTHxHEIGHT in pixels";
            },
            "");
    app.add_option("--interpolation", interpolation_,
                   "Interpolation; cubic is sharper but may overshoot at edges")
        ->check(CLI::IsMember({"linear", "cubic"}))
        ->capture_default_str();
    app.add_flag("--camera-only", camera_only_,
                 "Write only the camera or projection file; do not read inputs");
    app.add_flag("--overwrite", overwrite_,
                 "Replace an earlier result for these inputs; other files in the folder are never changed");
    addCameraOptions(app, camera_);
    addCommonOptions(app, common_, true);
  }

  int run(const CLI::App& app) override {
    checkUsage(app);
    const CancelFlag* cancel = catchInterrupts();
    const CameraRecord source = readCameraTelling(camera_path_, camera_.readOptions(), common_.quiet);
    const std::vector<std::string> paths = camera_only_ ? std::vector<std::string>() : listImages(inputs_);
    std::vector<std::string> sources = paths;
    sources.insert(sources.end(), {cameraFilePath(camera_path_), common_.config});
    refuseFolderOfInputs(output_, sources);
    std::vector<UndistortedImage> images = namesOf(paths);

    const ViewChoice choice = chooseView(source.camera, source.image_size, request(app));
    std::set<std::string> own_names = {kCameraName, kProjectionName};
    for (const UndistortedImage& image : images) own_names.insert(image.output);
    PendingFolder folder(output_, overwrite_, [&own_names](const std::filesystem::path& relative) {
      return own_names.contains(relative.string());
    });
    const RemapTable table =
        makeRemapTable(source.camera, source.image_size, choice.view, common_.jobs, cancel);
    undistortAll(paths, images, table, folder, cancel);
    const auto num_skipped = static_cast<std::size_t>(
        std::count_if(images.begin(), images.end(), [](const auto& image) { return !image.reason.empty(); }));
    if (!images.empty() && num_skipped == images.size()) throwNoImage(images);
    writeView(choice.view, folder);
    folder.commit();

    const double dark_share = static_cast<double>(table.num_without_source) /
                              static_cast<double>(std::max<std::size_t>(1, table.pixels.size()));
    const std::vector<std::string> notes = notesOn(choice, images);
    if (common_.json) {
      printResult(jsonText(json(choice, images, dark_share, notes)));
    } else if (!common_.quiet) {
      printResult(summary(choice.view, images.size() - num_skipped, images.size(), dark_share));
    }
    if (!common_.quiet) {
      for (const std::string& note : notes) printMessage("note: " + note);
    }
    if (num_skipped == 0) return 0;
    for (const UndistortedImage& image : images) {
      if (!image.reason.empty()) printMessage("error: " + oneLine(image.reason));
    }
    printMessage(fmt::format("error: {} of {} images were skipped", num_skipped, images.size()));
    return static_cast<int>(ErrorCode::kInput);
  }

 private:
  void checkUsage(const CLI::App& app) const {
    if (camera_path_.empty())
      throw usageError({.where = "undistort",
                        .found = "no camera file",
                        .expected = "a camera file (YAML) and images",
                        .next_step = "alidade undistort --help"});
    if (inputs_.empty() && !camera_only_)
      throw usageError({.where = "undistort",
                        .found = "no images",
                        .expected = "folders, files or patterns, or --camera-only",
                        .next_step = "alidade undistort --help"});
    if (output_.empty())
      throw usageError({.where = "undistort", .found = "no --output", .expected = "-o FOLDER"});
    if (app.count("--fov") > 0 && !keep_.empty())
      throw usageError({.where = "undistort",
                        .found = "--fov and --keep",
                        .expected = "one of them: both set the field of view"});
  }

  [[nodiscard]] ViewRequest request(const CLI::App& app) const {
    ViewRequest request;
    request.projection = projectionOf(projection_);
    request.horizontal_field_rad = fov_deg_ / kDegrees;
    if (app.count("--fov") > 0) request.extent = ViewExtent::kFieldOfView;
    if (keep_ == "all") request.extent = ViewExtent::kAll;
    if (keep_ == "valid") request.extent = ViewExtent::kValid;
    if (!size_.empty()) request.size = parseSize(size_);
    return request;
  }

  static std::vector<UndistortedImage> namesOf(const std::vector<std::string>& paths) {
    std::vector<UndistortedImage> images;
    if (paths.empty()) return images;
    const std::vector<std::string> names = shortNames(paths);
    const std::vector<std::string> outputs = outputNames(names);
    for (std::size_t i = 0; i < paths.size(); ++i)
      images.push_back({.image = names[i], .output = outputs[i], .reason = {}});
    return images;
  }

  // An image that cannot be used gets a reason; one that cannot be written ends the work.
  void undistortAll(const std::vector<std::string>& paths, std::vector<UndistortedImage>& images,
                    const RemapTable& table, const PendingFolder& folder, const CancelFlag* cancel) const {
    ProgressBar bar("undistorting", common_.quiet);
    std::mutex mutex;
    std::size_t num_done = 0;
    const auto interpolation = interpolation_ == "cubic" ? Interpolation::kCubic : Interpolation::kLinear;
    // Threads that have no image of their own help with the others' rows.
    const int num_threads = resolveJobs(common_.jobs);
    const int num_row_jobs =
        std::max(1, num_threads / static_cast<int>(std::max<std::size_t>(1, paths.size())));
    parallelFor(
        paths.size(), num_threads,
        [&](std::size_t i) {
          if (const auto image = load(paths[i], table.source_size, images[i]))
            writeImage(folder.path(images[i].output), remap(table, *image, interpolation, num_row_jobs));
          const std::lock_guard lock(mutex);
          bar.update(++num_done, paths.size());
        },
        cancel);
  }

  static std::optional<RasterImage> load(const std::string& path, ImageSize expected,
                                         UndistortedImage& image) {
    try {
      LoadedRaster loaded = readImage(path);
      image.exif_orientation = loaded.exif_orientation;
      const RasterImage& raster = loaded.image;
      if (raster.size != expected) {
        throw inputError({.where = path,
                          .found = "the image size is " + sizeText(raster.size) + " pixels",
                          .expected = sizeText(expected) + ", the image size of the camera file",
                          .next_step = "use the original images of this camera, not resized or rotated"});
      }
      if (hasJpegName(image.output) && (raster.bits_per_sample != 8 || raster.num_channels == 4)) {
        throw inputError({.where = path,
                          .found = "16-bit samples or an alpha channel in a file with a JPEG name",
                          .expected = "a file extension that matches the content",
                          .next_step = "rename it to .png or .tiff"});
      }
      return std::move(loaded.image);
    } catch (const Error& error) {
      image.reason = error.what();
      return std::nullopt;
    }
  }

  [[noreturn]] static void throwNoImage(const std::vector<UndistortedImage>& images) {
    const std::string& first = images.front().reason;
    if (images.size() == 1) throw inputError({.where = first});
    throw inputError({.where = fmt::format("{} images", images.size()),
                      .found = "none of them can be used",
                      .expected = "images from this camera",
                      .next_step = "the error of the first one: " + oneLine(first)});
  }

  static void writeView(const OutputView& view, const PendingFolder& folder) {
    if (view.projection != ViewProjection::kRectilinear)
      return writeProjectionFile(folder.path(kProjectionName), {.view = view, .created_by = programName()});
    writeCameraFile(folder.path(kCameraName), bareRecord(pinholeOf(view), view.size, programName()));
  }

  static std::vector<std::string> notesOn(const ViewChoice& choice,
                                          const std::vector<UndistortedImage>& images) {
    std::vector<std::string> notes;
    if (choice.cut_share > 0) {
      notes.push_back(fmt::format(
          "{:.2g} % of the input pixels are more than {:.0f} degrees from the {} and were cut off; {}",
          100 * choice.cut_share, kMaxTangentAngleRad * kDegrees,
          choice.view.projection == ViewProjection::kCylindrical ? "horizon" : "axis",
          "--projection equirectangular shows them all"));
    } else if (choice.is_limited_by_projection) {
      notes.push_back(fmt::format("a {} view cannot show all pixels of the input",
                                  projectionName(choice.view.projection)));
    }
    std::map<int, int> orientations;
    for (const UndistortedImage& image : images) ++orientations[image.exif_orientation];
    orientations.erase(1);
    for (const auto& [orientation, count] : orientations) {
      notes.push_back(fmt::format(
          "{} image{} {} an Exif orientation ({}); it is ignored, and the results are not rotated", count,
          count == 1 ? "" : "s", count == 1 ? "has" : "have", describeExifOrientation(orientation)));
    }
    return notes;
  }

  [[nodiscard]] std::string summary(const OutputView& view, std::size_t num_written, std::size_t num_images,
                                    double dark_share) const {
    const std::string what =
        camera_only_ ? "no images" : fmt::format("{} of {} images", num_written, num_images);
    const std::string scale = view.projection == ViewProjection::kRectilinear
                                  ? fmt::format("focal length {:.2f} px", view.scale_px.x())
                                  : fmt::format("{:.4g} px per degree", view.scale_px.x() / kDegrees);
    return fmt::format(
        "{}: {}; {}, {} px, {:.1f} degrees wide, {}, {:.2g} % of the pixels are black (no source)\n", output_,
        what, projectionName(view.projection), sizeText(view.size), view.horizontalFieldRad() * kDegrees,
        scale, 100 * dark_share);
  }

  [[nodiscard]] nlohmann::json json(const ViewChoice& choice, const std::vector<UndistortedImage>& images,
                                    double dark_share, const std::vector<std::string>& notes) const {
    const OutputView& view = choice.view;
    nlohmann::json list = nlohmann::json::array();
    for (const UndistortedImage& image : images) {
      nlohmann::json entry = {{"image", image.image}, {"written", image.reason.empty()}};
      if (image.reason.empty()) {
        entry["output"] = image.output;
      } else {
        entry["reason"] = oneLine(image.reason);
      }
      list.push_back(entry);
    }
    const bool is_flat = view.projection == ViewProjection::kRectilinear;
    return {{"folder", output_},
            {"file", is_flat ? kCameraName : kProjectionName},
            {"projection", projectionName(view.projection)},
            {"image_size", {{"width", view.size.width}, {"height", view.size.height}}},
            {is_flat ? "focal_px" : "pixels_per_radian", {view.scale_px.x(), view.scale_px.y()}},
            {"axis_pixel", {view.axis_px.x(), view.axis_px.y()}},
            {"horizontal_fov_deg", view.horizontalFieldRad() * kDegrees},
            {"share_without_source", dark_share},
            {"share_cut", choice.cut_share},
            {"images", list},
            {"notes", notes}};
  }

  std::string camera_path_;
  CameraOptions camera_;
  std::vector<std::string> inputs_;
  std::string output_;
  std::string projection_ = "rectilinear";
  double fov_deg_ = 0;
  std::string keep_;
  std::string size_;
  std::string interpolation_ = "linear";
  bool camera_only_ = false;
  bool overwrite_ = false;
};

}  // namespace

std::unique_ptr<Command> makeUndistortCommand() {
  return std::make_unique<UndistortCommand>();
}

}  // namespace alidade
