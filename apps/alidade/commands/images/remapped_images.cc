// SPDX-License-Identifier: MIT
#include "commands/images/remapped_images.h"

#include <algorithm>
#include <filesystem>
#include <map>
#include <mutex>
#include <optional>
#include <utility>

#include <fmt/format.h>

#include "alidade/core/error.h"
#include "alidade/core/error_text.h"
#include "alidade/core/number_text.h"
#include "alidade/core/parallel.h"
#include "alidade/core/size_groups.h"
#include "alidade/imagery/image_file.h"
#include "alidade/imagery/image_list.h"
#include "command.h"
#include "console.h"

namespace alidade {
namespace {

namespace fs = std::filesystem;

std::optional<RasterImage> load(RemappedImage& image, ImageSize expected) {
  try {
    LoadedRaster loaded = readImage(image.path);
    image.exif_orientation = loaded.exif_orientation;
    const RasterImage& raster = loaded.image;
    if (raster.size != expected) {
      throw inputError({.where = image.path,
                        .found = "the image size is " + sizeText(raster.size) + " pixels",
                        .expected = sizeText(expected) + ", the image size of the camera file",
                        .next_step = "use the original images of this camera, not resized or rotated"});
    }
    if (hasJpegName(image.output) && (raster.bits_per_sample != 8 || raster.num_channels == 4)) {
      throw inputError({.where = image.path,
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

}  // namespace

std::vector<RemappedImage> namedImages(const std::vector<std::string>& paths) {
  const auto flat = [](std::string name) {
    std::replace(name.begin(), name.end(), '/', '_');
    return name;
  };
  if (paths.empty()) return {};
  std::vector<RemappedImage> images;
  std::map<std::string, int> counts;
  const std::vector<std::string> names = shortNames(paths);
  for (std::size_t i = 0; i < paths.size(); ++i) {
    const std::string file = flat(names[i]);
    images.push_back({.path = paths[i], .image = names[i], .output = file, .reason = {}});
    if (!hasJpegName(file)) images.back().output = fs::path(file).replace_extension(".png").string();
    ++counts[images.back().output];
  }
  std::map<std::string, std::string> sources;
  for (RemappedImage& image : images) {
    const std::string file = flat(image.image);
    if (counts.at(image.output) > 1 && !hasJpegName(file)) image.output = file + ".png";
    const auto [earlier, is_new] = sources.emplace(image.output, image.image);
    if (is_new) continue;
    throw inputError(
        {.where = image.image,
         .found = "this image and " + earlier->second + " would both be written to '" + image.output + "'",
         .expected = "different output names",
         .next_step = "process them in two runs with different output folders"});
  }
  return images;
}

void remapAll(std::vector<RemappedImage>& images, const RemapTable& table, const PendingFolder& folder,
              const RemapSettings& settings) {
  ProgressBar bar(settings.label, settings.is_quiet);
  const std::string prefix = settings.subfolder.empty() ? "" : settings.subfolder + "/";
  std::mutex mutex;
  std::size_t num_done = 0;
  // Idle threads help with the rows of other images.
  const int num_threads = resolveJobs(settings.num_jobs);
  const int num_row_jobs =
      std::max(1, num_threads / static_cast<int>(std::max<std::size_t>(1, images.size())));
  parallelFor(
      images.size(), num_threads,
      [&](std::size_t i) {
        if (const auto image = load(images[i], table.source_size))
          writeImage(folder.path(prefix + images[i].output),
                     remap(table, *image, settings.interpolation, num_row_jobs));
        const std::lock_guard lock(mutex);
        bar.update(++num_done, images.size());
      },
      settings.cancel);
}

std::size_t numSkipped(const std::vector<RemappedImage>& images) {
  return static_cast<std::size_t>(
      std::count_if(images.begin(), images.end(), [](const auto& image) { return !image.reason.empty(); }));
}

void requireAnImage(const std::vector<RemappedImage>& images) {
  if (images.empty() || numSkipped(images) < images.size()) return;
  const std::string& first = images.front().reason;
  if (images.size() == 1) throw inputError({.found = first});
  throw noneUsableError(images.size(), "none of them can be used", first);
}

bool reportSkipped(const std::vector<RemappedImage>& images) {
  const std::size_t num_skipped = numSkipped(images);
  if (num_skipped == 0) return false;
  for (const RemappedImage& image : images) {
    if (!image.reason.empty()) printMessage("error: " + oneLine(image.reason));
  }
  printMessage(fmt::format("error: {} of {} images were skipped", num_skipped, images.size()));
  return true;
}

std::vector<std::string> orientationNotes(const std::vector<RemappedImage>& images) {
  std::vector<std::string> notes;
  std::map<int, int> orientations;
  for (const RemappedImage& image : images) ++orientations[image.exif_orientation];
  orientations.erase(1);
  for (const auto& [orientation, count] : orientations) {
    notes.push_back(fmt::format(
        "{} {} an Exif orientation ({}); it is ignored, and the results are not rotated",
        counted(count, "image"), count == 1 ? "has" : "have", describeExifOrientation(orientation)));
  }
  return notes;
}

json imagesJson(const std::vector<RemappedImage>& images) {
  json list = json::array();
  for (const RemappedImage& image : images) {
    const bool is_written = image.reason.empty();
    list.push_back({{"image", image.image}, {"written", is_written}});
    list.back()[is_written ? "output" : "reason"] = is_written ? image.output : oneLine(image.reason);
  }
  return list;
}

}  // namespace alidade
