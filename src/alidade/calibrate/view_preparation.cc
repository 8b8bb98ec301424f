// SPDX-License-Identifier: MIT
#include "alidade/calibrate/view_preparation.h"

#include <algorithm>
#include <utility>

#include "alidade/calibrate/repeated_views.h"
#include "alidade/core/error.h"
#include "alidade/core/size_groups.h"
#include "alidade/core/text.h"

namespace alidade {
namespace {

void checkView(const Checkerboard& board, const View& view, ImageSize size) {
  if (view.size != size) {
    throw inputError({.where = view.image,
                      .found = "an image of " + sizeText(view.size),
                      .expected = sizeText(size) + " as in the other views",
                      .next_step = "calibrate images of one size at a time"});
  }
  for (const Corner& corner : view.corners) {
    if (corner.id < 0 || corner.id >= board.numCorners()) {
      throw inputError(
          {.where = view.image,
           .found = "corner id " + std::to_string(corner.id),
           .expected = "0 to " + std::to_string(board.numCorners() - 1) + " on " + specText(board)});
    }
    if (corner.sigma_px < 0) {
      throw inputError({.where = view.image,
                        .found = "corner " + std::to_string(corner.id) + " with a negative sigma",
                        .expected = "a standard deviation in pixels, or NaN where it is unknown"});
    }
    if (corner.pixel.allFinite()) continue;
    throw inputError(
        {.where = view.image,
         .found = "corner " + std::to_string(corner.id) + " with a position that is not a number",
         .expected = "finite pixel coordinates"});
  }
}

}  // namespace

void prepareViews(const Checkerboard& board, std::vector<View>& views) {
  if (views.size() < kMinViews) {
    throw inputError(
        {.where = "calibration",
         .found = std::to_string(views.size()) + " view" + (views.size() == 1 ? "" : "s") + " of the board",
         .expected = "at least " + std::to_string(kMinViews),
         .next_step =
             "take more photographs of the whole board, tilted by 20 to 50 degrees, all over the image"});
  }
  std::sort(views.begin(), views.end(),
            [](const View& a, const View& b) { return naturalLess(a.image, b.image); });
  for (View& view : views) {
    checkView(board, view, views.front().size);
    std::sort(view.corners.begin(), view.corners.end(),
              [](const Corner& a, const Corner& b) { return a.id < b.id; });
  }
  const auto twin = std::adjacent_find(views.begin(), views.end(),
                                       [](const View& a, const View& b) { return a.image == b.image; });
  if (twin == views.end()) return;
  throw inputError(
      {.where = twin->image, .found = "two views with this name", .expected = "one view an image"});
}

void excludeUnusable(Estimation& e) {
  for (std::size_t v = e.views.size(); v-- > 0;) {
    if (e.views[v].corners.size() < kMinCornersPerView) {
      exclude(e, v,
              std::to_string(e.views[v].corners.size()) + " corners; at least " +
                  std::to_string(kMinCornersPerView) + " are needed");
    }
  }
  mergeRepeatedViews(e);
  requireViews(e);
}

}  // namespace alidade
