// SPDX-License-Identifier: MIT
#include "alidade/calibrate/start/prepared_views.h"

#include <algorithm>
#include <numeric>
#include <utility>

#include "alidade/calibrate/start/repeated_views.h"
#include "alidade/core/error.h"
#include "alidade/core/size_groups.h"
#include "alidade/core/text.h"

namespace alidade {
namespace {

void checkView(const Checkerboard& board, const View& view, ImageSize size) {
  if (view.image.empty())
    throw inputError({.where = "views", .found = "a view without a name", .expected = "View::image"});
  if (view.size.width <= 0 || view.size.height <= 0) {
    throw inputError({.where = view.image,
                      .found = "an image of " + sizeText(view.size),
                      .expected = "the size of the image in pixels"});
  }
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

void checkEnoughUsable(std::size_t num_usable, std::vector<std::string> reasons) {
  if (num_usable >= kMinViews) return;
  throw inputError({.where = "calibration",
                    .found = std::to_string(num_usable) + " usable views (" + join(reasons, "; ") + ")",
                    .expected = "at least " + std::to_string(kMinViews),
                    .next_step = "check the board's size and that all images are of the same camera"});
}

std::vector<std::string> reasonsOf(const PreparedViews& given) {
  std::vector<std::string> reasons;
  for (const ExcludedView& view : given.excluded) reasons.push_back(view.image + ": " + view.reason);
  for (const RepeatedView& view : given.repeated)
    reasons.push_back(view.image + ": shows the board at the same place as " + view.same_as);
  return reasons;
}

// Checks views and puts them and their corners in order.
// @returns the index that each has had
std::vector<std::size_t> sortViews(const Checkerboard& board, std::vector<View>& views) {
  if (views.size() < kMinViews) {
    throw inputError(
        {.where = "calibration",
         .found = std::to_string(views.size()) + " view" + (views.size() == 1 ? "" : "s") + " of the board",
         .expected = "at least " + std::to_string(kMinViews),
         .next_step =
             "take more photographs of the whole board, tilted by 20 to 50 degrees, all over the image"});
  }
  std::vector<std::size_t> order(views.size());
  std::iota(order.begin(), order.end(), 0);
  std::stable_sort(order.begin(), order.end(),
                   [&](std::size_t a, std::size_t b) { return naturalLess(views[a].image, views[b].image); });
  std::vector<View> sorted;
  for (const std::size_t v : order) sorted.push_back(std::move(views[v]));
  views = std::move(sorted);
  for (View& view : views) {
    checkView(board, view, views.front().size);
    std::sort(view.corners.begin(), view.corners.end(),
              [](const Corner& a, const Corner& b) { return a.id < b.id; });
  }
  const auto twin = std::adjacent_find(views.begin(), views.end(),
                                       [](const View& a, const View& b) { return a.image == b.image; });
  if (twin == views.end()) return order;
  throw inputError(
      {.where = twin->image, .found = "two views with this name", .expected = "one view an image"});
}

}  // namespace

PreparedViews prepareViews(const Checkerboard& board, std::vector<View> views) {
  const std::vector<std::size_t> order = sortViews(board, views);
  PreparedViews given;
  for (std::size_t v = 0; v < views.size(); ++v) {
    View& view = views[v];
    if (view.corners.size() < kMinCornersPerView) {
      given.excluded.push_back({view.image, std::to_string(view.corners.size()) + " corners; at least " +
                                                std::to_string(kMinCornersPerView) + " are needed"});
    } else {
      given.views.push_back(std::move(view));
      given.sources.push_back(order[v]);
    }
  }
  mergeRepeatedViews(given);
  checkEnoughUsable(given.views.size(), reasonsOf(given));
  return given;
}

std::vector<std::size_t> viewsLeftOut(const PreparedViews& given, const Fit& fit) {
  std::vector<std::size_t> left_out;
  auto at = fit.views.begin();
  for (std::size_t v = 0; v < given.views.size(); ++v) {
    if (at != fit.views.end() && at->source == v) {
      ++at;
    } else {
      left_out.push_back(v);
    }
  }
  return left_out;
}

void requireViews(const PreparedViews& given, const Fit& fit) {
  std::vector<std::string> reasons = reasonsOf(given);
  for (const std::size_t v : viewsLeftOut(given, fit))
    reasons.push_back(given.views[v].image + ": does not fit the other views");
  checkEnoughUsable(fit.views.size(), std::move(reasons));
}

}  // namespace alidade
