// SPDX-License-Identifier: MIT
#include <fmt/format.h>

#include "alidade/core/degrees.h"
#include "alidade/core/error.h"
#include "alidade/core/size_groups.h"
#include "alidade/files/camera_source.h"
#include "alidade/files/text/atomic_file.h"
#include "alidade/imagery/image_list.h"
#include "alidade/imagery/projection_file.h"
#include "alidade/imagery/remap.h"
#include "alidade/imagery/undistortion_view.h"
#include "alidade/report/data/json_output.h"
#include "camera_files.h"
#include "command.h"
#include "commands/images/remapped_images.h"
#include "console.h"
#include "pending_folder.h"
#include "view_options.h"

namespace alidade {
namespace {

constexpr const char* kCameraName = "camera.yaml";
constexpr const char* kProjectionName = "projection.yaml";

class UndistortCommand final : public Command {
 public:
  void setUp(Flags& flags) override {
    flags.explain(
        "Example: alidade undistort camera.yaml photos/ -o undistorted\nWithout --fov or --keep, the focal "
        "length and the principal point are kept, scaled if --size is given.\nWrites PNG files with the "
        "channels and bit depth of the inputs (JPEG files for JPEG inputs), and camera.yaml, the\nmatching "
        "pinhole camera. The other projections get projection.yaml instead.");
    flags.add("camera", &camera_path_, "Camera file of any format (docs/formats.md)", kFilePath);
    flags.add("input", &inputs_, "Folders, image files or patterns", kFilePath);
    flags.add("-o,--output", &output_, "Folder to create", kFolder);
    view_.addOptions(flags, "; rectilinear keeps straight lines straight", "size of the input");
    flags.addSwitch("--camera-only", camera_only_,
                    "Write only the camera or projection file; do not read inputs");
    addReadOptions(flags, camera_);
    flags.addCommon(common_, true);
  }

  int run(const Flags& flags) override {
    checkUsage(flags);
    common_.cancel = catchInterrupts();
    const CameraRecord source = readCameraTelling(camera_path_, camera_, common_.quiet);
    const std::vector<std::string> paths = camera_only_ ? std::vector<std::string>() : listImages(inputs_);
    std::vector<std::string> sources = paths;
    append(sources, {cameraFilePath(camera_path_), common_.config});
    refuseFolderOfInputs(output_, sources);
    images_ = namedImages(paths);
    choice_ = chooseView(source.camera, source.image_size, view_.request(flags));
    write(source);
    answer([&] { return viewJson(); }, [&] { return summary(); });
    if (!common_.quiet) printNotes(notes());
    return reportSkipped(images_) ? static_cast<int>(ErrorCode::kInput) : 0;
  }

 private:
  void write(const CameraRecord& source) {
    PendingFolder folder(output_, common_.command, view_.may_overwrite, common_.quiet);
    const RemapTable table =
        makeRemapTable(source.camera, source.image_size, choice_.view, common_.jobs, common_.cancel);
    folder.write([&] {
      remapAll(images_, table, folder,
               {.label = "undistorting",
                .subfolder = "",
                .interpolation = view_.interpolationKind(),
                .common = common_});
    });
    requireAnImage(images_);
    folder.write([&] { writeView(folder); });
    folder.commit();
    dark_share_ = darkShare(table);
  }

  void checkUsage(const Flags& flags) const {
    if (camera_path_.empty()) throw missing("no camera file", "a camera file (YAML) and images");
    if (inputs_.empty() && !camera_only_)
      throw missing("no images", "folders, files or patterns, or --camera-only");
    if (output_.empty()) throw missing("no --output", "-o FOLDER");
    view_.checkUsage(flags);
  }

  void writeView(const PendingFolder& folder) const {
    const OutputView& view = choice_.view;
    if (view.projection != ViewProjection::kRectilinear)
      return writeFileAtomically(folder.path(kProjectionName), projectionFileText(view, maker()));
    saveCamera(folder.path(kCameraName), bareRecord(pinholeOf(view), view.size, maker()));
  }

  [[nodiscard]] std::vector<std::string> notes() const {
    std::vector<std::string> notes;
    if (choice_.cut_share > 0) {
      notes.push_back(fmt::format(
          "{:.2g} % of the input pixels are more than {:.0f} degrees from the {} and were cut off; {}",
          100 * choice_.cut_share, kMaxTangentAngleRad * kDegPerRad,
          choice_.view.projection == ViewProjection::kCylindrical ? "horizon" : "axis",
          "--projection equirectangular shows them all"));
    } else if (choice_.is_limited_by_projection) {
      notes.push_back(fmt::format("a {} view cannot show all pixels of the input",
                                  projectionName(choice_.view.projection)));
    }
    append(notes, orientationNotes(images_));
    return notes;
  }

  [[nodiscard]] std::string summary() const {
    const OutputView& view = choice_.view;
    const std::string what =
        camera_only_ ? "no images"
                     : fmt::format("{} of {} images", images_.size() - numSkipped(images_), images_.size());
    const std::string scale = view.projection == ViewProjection::kRectilinear
                                  ? fmt::format("focal length {:.2f} px", view.scale_px.x())
                                  : fmt::format("{:.4g} px per degree", view.scale_px.x() / kDegPerRad);
    return fmt::format(
        "{}: {}; {}, {} px, {:.1f} degrees wide, {}, {:.2g} % of the pixels are black (no source)\n",
        printable(output_), what, projectionName(view.projection), sizeText(view.size),
        view.horizontalFieldRad() * kDegPerRad, scale, 100 * dark_share_);
  }

  [[nodiscard]] std::string viewJson() const {
    const OutputView& view = choice_.view;
    const bool is_flat = view.projection == ViewProjection::kRectilinear;
    return jsonText({{"folder", output_},
                     {"file", is_flat ? kCameraName : kProjectionName},
                     {"projection", projectionName(view.projection)},
                     {"image_size", view.size},
                     {is_flat ? "focal_px" : "pixels_per_radian", vectorJson(view.scale_px)},
                     {"axis_pixel", vectorJson(view.axis_px)},
                     {"horizontal_fov_deg", view.horizontalFieldRad() * kDegPerRad},
                     {"share_without_source", dark_share_},
                     {"share_cut", choice_.cut_share},
                     {"images", imagesJson(images_)},
                     {"notes", notes()}});
  }

  std::string camera_path_;
  ReadOptions camera_;
  std::vector<std::string> inputs_;
  std::string output_;
  ViewOptions view_;
  bool camera_only_ = false;
  std::vector<RemappedImage> images_;
  ViewChoice choice_;
  double dark_share_ = 0;  // share of the view's pixels without a source
};

}  // namespace

const CommandEntry kUndistortCommand = {"undistort", "Remove lens distortion from images",
                                        made<UndistortCommand>};

}  // namespace alidade
