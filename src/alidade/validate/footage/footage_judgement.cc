// SPDX-License-Identifier: MIT
#include "alidade/validate/footage/footage_judgement.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <utility>

#include <fmt/format.h>

#include "alidade/core/size_groups.h"

namespace alidade {
namespace {

ImageSize turnedSize(ImageSize size) {
  return {.width = size.height, .height = size.width};
}

bool isUpright(ImageSize size) {
  return size.height > size.width;
}

// True if one size is a resized version of the other; a side may be rounded.
bool haveOneShape(ImageSize a, ImageSize b) {
  const double scale = static_cast<double>(b.width) / a.width;
  return std::abs(a.height * scale - b.height) <= 0.5 * std::max(1.0, scale);
}

PixelRect centred(ImageSize image, ImageSize part) {
  return {.x = (image.width - part.width) / 2,
          .y = (image.height - part.height) / 2,
          .width = part.width,
          .height = part.height};
}

// The largest centred part with the aspect ratio of a second image.
PixelRect centredPartOfShape(ImageSize image, ImageSize shape) {
  const auto side = [](std::int64_t length, std::int64_t over, std::int64_t under) {
    return static_cast<int>(std::max<std::int64_t>(1, (2 * length * over + under) / (2 * under)));
  };
  const bool is_wider = std::int64_t{shape.width} * image.height > std::int64_t{image.width} * shape.height;
  const ImageSize part = is_wider ? ImageSize{image.width, side(image.width, shape.height, shape.width)}
                                  : ImageSize{side(image.height, shape.width, shape.height), image.height};
  return centred(image, part);
}

ConversionRequest requestOf(std::optional<PixelRect> crop, std::optional<ImageSize> resize) {
  ConversionRequest request;
  request.crop = crop;
  request.resize = resize;
  return request;
}

// Edits without rotation, the most common ones first.
std::vector<ConversionRequest> plainEdits(ImageSize from, ImageSize to) {
  if (from == to) return {ConversionRequest{}};
  std::vector<ConversionRequest> edits;
  const bool has_shape = haveOneShape(from, to);
  if (has_shape) edits.push_back(requestOf({}, to));
  if (to.width <= from.width && to.height <= from.height) edits.push_back(requestOf(centred(from, to), {}));
  if (!has_shape) {
    edits.push_back(requestOf(centredPartOfShape(from, to), to));
    edits.push_back(requestOf({}, to));  // stretched
    // If nothing is left to resize, the crop and the part of that shape are the same.
    std::erase_if(edits, [&](const ConversionRequest& edit) {
      return edit.crop && edit.resize && ImageSize{edit.crop->width, edit.crop->height} == to;
    });
  }
  return edits;
}

}  // namespace

const FootageEdit* FootageJudgement::foundEdit() const {
  const bool is_found = !edits.empty() && edits.front().check.verdict == FootageVerdict::kConsistent;
  return is_found ? &edits.front() : nullptr;
}

FootageVerdict FootageJudgement::verdict() const {
  return isOtherSize() ? FootageVerdict::kInconsistent : check.verdict;
}

std::vector<ConversionRequest> editsBetween(ImageSize from, ImageSize to) {
  if (from == to) return {};
  if (isUpright(from) == isUpright(to)) return plainEdits(from, to);
  std::vector<ConversionRequest> edits;
  for (const ConversionRequest& plain : plainEdits(from, turnedSize(to))) {
    for (const int degrees : {90, 270}) {
      edits.push_back(plain);
      edits.back().rotate_deg = degrees;
    }
  }
  if (to.width <= from.width && to.height <= from.height) edits.push_back(requestOf(centred(from, to), {}));
  return edits;
}

std::string editWords(const ConversionRequest& edit) {
  std::string words;
  const auto add = [&](const char* word) { words += (words.empty() ? "" : " and ") + std::string(word); };
  if (edit.crop) add("cropped");
  if (edit.resize) add("resized");
  if (edit.rotate_deg) add("rotated");
  return words;
}

std::string editFlags(const ConversionRequest& edit) {
  std::vector<std::string> flags;
  if (edit.crop) {
    flags.push_back(
        fmt::format("--crop {},{},{},{}", edit.crop->x, edit.crop->y, edit.crop->width, edit.crop->height));
  }
  if (edit.resize) flags.push_back("--resize " + sizeText(*edit.resize));
  if (edit.rotate_deg) flags.push_back(fmt::format("--rotate {}", *edit.rotate_deg));
  return fmt::format("{}", fmt::join(flags, " "));
}

FootageJudgement judgeOnFootage(const CameraRecord& camera, const FootageTracks& tracks,
                                const FootageCheckOptions& options, std::size_t num_frames_given) {
  FootageJudgement judgement{.camera_size = camera.image_size,
                             .image_size = tracks.size,
                             .num_frames_given = num_frames_given,
                             .check = {}};
  if (!judgement.isOtherSize()) {
    judgement.check = checkOnFootage(camera.camera, tracks, options);
    return judgement;
  }
  for (ConversionRequest& edit : editsBetween(camera.image_size, tracks.size)) {
    FootageCheck check = checkOnFootage(convertCamera(camera, edit).camera(), tracks, options);
    judgement.edits.push_back({.request = std::move(edit), .check = std::move(check)});
  }
  std::ranges::stable_sort(judgement.edits, [](const FootageEdit& a, const FootageEdit& b) {
    if (a.check.verdict != b.check.verdict) return a.check.verdict < b.check.verdict;
    return a.check.verdict == FootageVerdict::kConsistent && a.check.holdout_rms_px < b.check.holdout_rms_px;
  });
  if (!judgement.edits.empty()) judgement.check = judgement.edits.front().check;
  return judgement;
}

}  // namespace alidade
