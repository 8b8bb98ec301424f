// SPDX-License-Identifier: MIT
#include <optional>
#include <string>
#include <tuple>
#include <utility>
#include <vector>

#include <fmt/format.h>
#include <CLI/CLI.hpp>
#include <nlohmann/json.hpp>

#include "alidade/compare/difference_significance.h"
#include "alidade/compare/projection_difference.h"
#include "alidade/compare/ray_alignment.h"
#include "alidade/core/error.h"
#include "alidade/core/size_groups.h"
#include "alidade/core/text.h"
#include "alidade/files/atomic_file.h"
#include "alidade/files/camera_source.h"
#include "alidade/record/camera_record.h"
#include "alidade/report/difference_svg.h"
#include "camera_options.h"
#include "command.h"
#include "difference_output.h"
#include "number_check.h"

namespace alidade {
namespace {

constexpr int kNoExit = static_cast<int>(ErrorCode::kVerdict);

class DiffCommand final : public Command {
 public:
  void setUp(CLI::App& app) override {
    app.footer(
        "Example: alidade diff left.yaml right.yaml --tolerance 0.5\nExample: alidade diff left.yaml "
        "right.yaml -o difference.svg\nA and B may have different formats, models and resolutions. "
        "Differences are in pixels of the image with the higher\nresolution. Swapping A and B gives the "
        "inverse rotation and the same differences.\nExit code 3: the cameras cannot be compared, or they "
        "differ significantly and by more than the tolerance.");
    app.add_option(
        "files", files_,
        "Two camera files of any format, A and B; FILE#NAME selects one camera of a file with several");
    app.add_option("--distance", distance_m_,
                   "Compare points at this distance in metres, and align by the best pose instead of the "
                   "best rotation")
        ->check(positiveNumber(), "above 0");
    app.add_flag("--same-frame", same_frame_, "Do not align: assume that both cameras have the same frame");
    app.add_option("--rotate", rotate_,
                   "Clockwise rotation of B's image relative to A's, in degrees. Default: 0, or 90 or 270 if "
                   "the image sizes require it")
        ->check(CLI::IsMember({0, 90, 180, 270}));
    app.add_option("--grid", grid_,
                   "Grid of pixels to compare: COLUMNSxROWS. Default: 40 along the longer side")
        ->check(gridComplaint, "");
    app.add_option("--tolerance", tolerance_px_,
                   "Largest accepted difference in pixels (95th percentile). Exit code 3 if it is exceeded "
                   "by a significant difference")
        ->check(nonNegativeNumber(), "0 or more");
    app.add_option("-o,--output", figure_,
                   "SVG file to write: the difference over the image of A, as colours and arrows")
        ->check(figureComplaint, "");
    addCameraOptions(app, camera_);
    addCommonOptions(app, common_, false);
  }

  int run(const CLI::App&) override {
    if (files_.size() != 2) {
      throw usageError({.where = "diff",
                        .found = fmt::format("{} files", files_.size()),
                        .expected = "two camera files",
                        .next_step = "alidade diff --help"});
    }
    if (same_frame_ && distance_m_) {
      throw usageError({.where = "--same-frame and --distance",
                        .found = "both",
                        .expected = "one of them",
                        .next_step = "remove --distance: without alignment the distance has no effect"});
    }
    checkOutput(figure_, {cameraFilePath(files_[0]), cameraFilePath(files_[1]), common_.config}, common_);
    const CameraRecord a = readCameraTelling(files_[0], camera_.readOptions(), common_.quiet);
    const CameraRecord b = readCameraTelling(files_[1], camera_.readOptions(), common_.quiet);
    const DifferenceOptions options = differenceOptions();
    const ComparedCamera in_a{&a.camera, a.image_size, statedCovariance(a)};
    const ComparedCamera in_b{&b.camera, b.image_size, statedCovariance(b)};
    const ProjectionDifference difference = projectionDifference(in_a, in_b, options);
    const auto significance = significanceOf(difference, in_a, in_b, options.freed);
    const auto no = complaint(difference, significance);

    if (!common_.quiet) {
      if (const auto crop = suspectCrop(in_a, in_b, difference.match)) printMessage(cropText(*crop));
      const std::string uneven = unevenSizeText(a.image_size, b.image_size, difference.match.quarter_turns);
      if (!uneven.empty()) printMessage(uneven);
    }
    const bool has_figures = difference.num_compared > 0 && difference.is_converged;
    std::string text = fileText("A", files_[0], a) + fileText("B", files_[1], b) + differenceText(difference);
    const std::string chance =
        has_figures ? "Test     " +
                          significanceText(difference, significance, in_a.covariance.has_value(),
                                           in_b.covariance.has_value()) +
                          "\n"
                    : "";
    if (!figure_.empty() && has_figures)
      writeFileAtomically(figure_, differenceSvg(in_a, in_b, difference, figureLines(text + chance)));

    if (common_.json) {
      nlohmann::json document = differenceJson(difference, significance);
      document["a"] = fileJson(files_[0], a);
      document["b"] = fileJson(files_[1], b);
      document["distance_m"] = distance_m_ ? nlohmann::json(*distance_m_) : nlohmann::json(nullptr);
      document["tolerance_px"] = tolerance_px_ ? nlohmann::json(*tolerance_px_) : nlohmann::json(nullptr);
      document["agrees"] = tolerance_px_ || no ? nlohmann::json(!no) : nlohmann::json(nullptr);
      document["reason"] = no ? nlohmann::json(*no) : nlohmann::json(nullptr);
      printResult(jsonText(document));
    } else {
      if (has_figures) text += differenceTable(difference) + chance;
      printResult(text + upsideDownText(in_a, in_b, difference));
    }
    if (!figure_.empty() && has_figures && !common_.quiet) printMessage("written to " + figure_);
    if (!no) return 0;
    printMessage("error: " + *no);
    if (!figure_.empty() && !has_figures)
      printMessage(figure_ + " was not written because there is nothing to draw");
    return kNoExit;
  }

 private:
  static std::optional<std::pair<int, int>> parseGrid(const std::string& text) {
    const auto parts = split(text, 'x');
    if (parts.size() != 2) return std::nullopt;
    const auto columns = parseInt(parts[0]);
    const auto rows = parseInt(parts[1]);
    constexpr int kMostPixels = 1'000'000;
    if (!columns || !rows || *columns < 1 || *rows < 1 || *columns > kMostPixels / *rows) return std::nullopt;
    return std::pair(*columns, *rows);
  }

  static std::string gridComplaint(const std::string& text) {
    if (parseGrid(text)) return {};
    return "found '" + text + "', expected COLUMNSxROWS such as 20x15, with at most a million pixels";
  }

  [[nodiscard]] DifferenceOptions differenceOptions() const {
    DifferenceOptions options;
    if (same_frame_) options.freed.reset();
    if (distance_m_) {
      options.freed = Freed::kPose;
      options.distance_m = *distance_m_;
    }
    if (rotate_) options.quarter_turns = *rotate_ / 90;
    if (grid_.empty()) return options;
    std::tie(options.columns, options.rows) = *parseGrid(grid_);
    const int num_pixels = options.columns * options.rows;
    if (options.freed && num_pixels < fewestPairs(*options.freed)) {
      throw usageError(
          {.where = "--grid " + grid_,
           .found = fmt::format("{} pixels", num_pixels),
           .expected = fmt::format("at least {} pixels to estimate the best {}", fewestPairs(*options.freed),
                                   distance_m_ ? "pose" : "rotation"),
           .next_step = "use a finer grid, or --same-frame to compare without alignment"});
    }
    return options;
  }

  // Why the answer is no.
  [[nodiscard]] std::optional<std::string> complaint(
      const ProjectionDifference& difference,
      const std::optional<DifferenceSignificance>& significance) const {
    if (difference.num_compared == 0)
      return "the cameras cannot be compared: no pixel is seen by both\n  next: check both files with "
             "alidade validate";
    if (!difference.is_converged) {
      return fmt::format(
          "the best {} was not found: the cameras have too little in common\n  next: check both files with "
          "alidade validate, and that both cameras belong to the same image",
          distance_m_ ? "pose" : "rotation");
    }
    if (!isComparable(difference)) {
      return fmt::format(
          "{} of {} pixels are seen by only one camera, or differ by more than the image diagonal: the "
          "cameras cannot be compared as a whole\n  next: check both files with alidade validate, and that "
          "both cameras belong to the same image",
          difference.num_seen_by_one, difference.pixels.size());
    }
    if (!tolerance_px_) return std::nullopt;
    switch (agreementOf(difference, significance, *tolerance_px_)) {
      case Agreement::kWithin:
      case Agreement::kUncertain:
      case Agreement::kNotComparable:
        return std::nullopt;
      case Agreement::kBeyond:
        return fmt::format("the cameras differ by {:.3g} px (95 %); limit {} px (--tolerance)",
                           difference.p95_px, *tolerance_px_);
    }
    return std::nullopt;
  }

  // Images that are upside down have the same size; that they are shall not be left to be guessed.
  [[nodiscard]] std::string upsideDownText(const ComparedCamera& a, const ComparedCamera& b,
                                           const ProjectionDifference& difference) const {
    constexpr double kFarLess = 0.1;
    constexpr double kWorthWhilePx = 0.1;
    if (rotate_ || !difference.is_converged || difference.match.quarter_turns != 0 ||
        !(difference.rms_px > kWorthWhilePx))
      return "";
    DifferenceOptions options = differenceOptions();
    options.quarter_turns = 2;
    const ProjectionDifference turned = projectionDifference(a, b, options);
    // Few pixels that suit by chance are no sign of a turned image.
    if (!turned.is_converged || turned.num_compared < difference.num_compared ||
        !(turned.rms_px < kFarLess * difference.rms_px))
      return "";
    return fmt::format(
        "Note     with B's image upside down relative to A's (--rotate 180), the RMS would be {:.4g} px "
        "instead of {:.4g} px\n",
        turned.rms_px, difference.rms_px);
  }

  static std::string figureComplaint(const std::string& text) {
    if (text.ends_with(".svg")) return {};
    return "found '" + text + "', expected a file name that ends in .svg";
  }

  [[nodiscard]] std::string cropText(const CropSuspicion& crop) const {
    const std::string& larger = files_[crop.is_a_larger ? 0 : 1];
    const std::string corner = crop.corner ? fmt::format("{},{}", crop.corner->x(), crop.corner->y()) : "X,Y";
    return fmt::format(
        "note: the image sizes differ, but the focal lengths agree ({:.6g} and {:.6g} px), as if one image "
        "were a crop of the other; this comparison assumes a resized image\n  next: if {}'s image is a crop "
        "of {}'s, run alidade convert {} -o cropped.yaml --crop {},{},{} and compare with its output",
        crop.focal_a_px, crop.focal_b_px, crop.is_a_larger ? "B" : "A", crop.is_a_larger ? "A" : "B", larger,
        corner, crop.part.width, crop.part.height);
  }

  static std::string fileText(const char* name, const std::string& path, const CameraRecord& file) {
    return fmt::format("{:<8} {}: {}, {} px\n", name, path, file.camera.modelId(), sizeText(file.image_size));
  }

  static nlohmann::json fileJson(const std::string& path, const CameraRecord& file) {
    return {{"file", path},
            {"model", file.camera.modelId()},
            {"image_size", {{"width", file.image_size.width}, {"height", file.image_size.height}}},
            {"has_covariance", statedCovariance(file).has_value()}};
  }

  std::vector<std::string> files_;
  CameraOptions camera_;
  std::optional<double> distance_m_;
  bool same_frame_ = false;
  std::optional<int> rotate_;
  std::string grid_;
  std::string figure_;
  std::optional<double> tolerance_px_;
};

}  // namespace

std::unique_ptr<Command> makeDiffCommand() {
  return std::make_unique<DiffCommand>();
}

}  // namespace alidade
