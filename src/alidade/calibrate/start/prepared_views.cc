// SPDX-License-Identifier: MIT
#include "alidade/calibrate/start/prepared_views.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <numeric>
#include <utility>

#include <Eigen/Core>

#include "alidade/core/error.h"
#include "alidade/core/mapped.h"
#include "alidade/core/median.h"
#include "alidade/core/number_text.h"
#include "alidade/core/size_groups.h"
#include "alidade/core/text.h"
#include "alidade/geometry/decompositions.h"

namespace alidade {
namespace {

void checkView(std::span<const Board> boards, const View& view, ImageSize size) {
  const auto error = [&](const std::string& found, const std::string& expected,
                         const std::string& next_step = "") {
    return inputError({.where = view.image.empty() ? "views" : view.image,
                       .found = found,
                       .expected = expected,
                       .next_step = next_step});
  };
  if (view.image.empty()) throw error("a view without a name", "View::image");
  if (view.board >= boards.size()) {
    throw error("a view of board " + std::to_string(view.board),
                "an index of the boards that are given, of which there are " + std::to_string(boards.size()));
  }
  const Board& board = boards[view.board];
  if (view.size.width <= 0 || view.size.height <= 0)
    throw error("an image of " + sizeText(view.size), "the size of the image in pixels");
  if (view.size != size) {
    throw error("an image of " + sizeText(view.size), sizeText(size) + " as in the other views",
                "calibrate images of one size at a time");
  }
  for (const Corner& corner : view.corners) {
    const auto id = [&] { return std::to_string(corner.id); };
    if (corner.id < 0 || corner.id >= board.numCorners()) {
      throw error("corner id " + id(),
                  "0 to " + std::to_string(board.numCorners() - 1) + " on " + board.spec());
    }
    if (corner.sigma_px < 0) {
      throw error("corner " + id() + " with a negative sigma",
                  "a standard deviation in pixels, or NaN where it is unknown");
    }
    if (!corner.pixel.allFinite())
      throw error("corner " + id() + " with a position that is not a number", "finite pixel coordinates");
    if (isInOrNearImage(corner.pixel, view.size)) continue;
    throw error("corner " + id() + " at (" + numberText("%.1f", corner.pixel.x()) + ", " +
                    numberText("%.1f", corner.pixel.y()) + "), outside the image of " + sizeText(view.size),
                "a corner inside the image",
                "check the image size: width and height may be swapped, or those of another image");
  }
}

void checkEnoughUsable(std::size_t num_usable, std::vector<std::string> reasons) {
  if (num_usable >= kMinViews) return;
  constexpr std::size_t kMaxReasons = 12;
  if (reasons.size() > kMaxReasons) {
    const std::string rest = "and " + std::to_string(reasons.size() - kMaxReasons) + " more";
    reasons.resize(kMaxReasons);
    reasons.push_back(rest);
  }
  throw inputError({.where = "calibration",
                    .found = std::to_string(num_usable) + " usable views (" + join(reasons, "; ") + ")",
                    .expected = "at least " + std::to_string(kMinViews),
                    .next_step = "check the board's size and that all images are of the same camera"});
}

std::vector<std::string> reasonsOf(const PreparedViews& given) {
  std::vector<std::string> reasons;
  for (const ExcludedView& view : given.dropped.views) reasons.push_back(view.image + ": " + view.reason);
  for (const RepeatedView& view : given.dropped.repeated)
    reasons.push_back(view.image + ": shows the board at the same place as " + view.same_as);
  return reasons;
}

void checkBoard(const Board& board) {
  if (board.columns() < 2 || board.rows() < 2 ||
      !(board.spacing() > 0)) {  // corners may come from other programs
    throw inputError({.where = "calibration",
                      .found = "a board of " + std::to_string(board.columns()) + "x" +
                               std::to_string(board.rows()) + " corners, " + exactText(board.spacing()) +
                               " m apart",
                      .expected = "two or more corners in each direction, some distance apart"});
  }
}

// Order by image, then by board.
bool isBefore(const View& a, const View& b) {
  return a.image == b.image ? a.board < b.board : naturalLess(a.image, b.image);
}

// Checks boards and views and puts the views and their corners in order.
// @returns the former index of each
std::vector<std::size_t> sortViews(std::span<const Board> boards, std::vector<View>& views) {
  for (const Board& board : boards) checkBoard(board);
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
  std::ranges::stable_sort(order, isBefore, [&](std::size_t v) -> const View& { return views[v]; });
  views = mapped(order, [&](std::size_t v) { return std::move(views[v]); });
  for (View& view : views) {
    checkView(boards, view, views.front().size);
    std::ranges::sort(view.corners, {}, &Corner::id);
    const auto same = std::ranges::adjacent_find(view.corners, {}, &Corner::id);
    if (same == view.corners.end()) continue;
    throw inputError({.where = view.image,
                      .found = "corner " + std::to_string(same->id) + " twice",
                      .expected = "each corner once"});
  }
  const auto twin = std::ranges::adjacent_find(
      views, [](const View& a, const View& b) { return a.image == b.image && a.board == b.board; });
  if (twin == views.end()) return order;
  throw inputError({.where = twin->image,
                    .found = "two views with this name",
                    .expected = boards.size() == 1 ? "one view per image" : "one view per image and board"});
}

constexpr double kFarPx = 10;            // px; noise of a corner that was found never moves it this far
constexpr double kScatterPx = 1;         // px, median residual of displacements that noise alone leaves
constexpr double kMinCommonShare = 0.5;  // of the view with more corners

// Calls f(corner of a, corner of b) for each corner that both views have, until f returns false.
template <class F>
void forEachCommon(const View& a, const View& b, F&& f) {
  auto at = b.corners.begin();
  for (const Corner& corner : a.corners) {
    while (at != b.corners.end() && at->id < corner.id) ++at;
    if (at == b.corners.end()) return;
    if (at->id == corner.id && !f(corner, *at)) return;
  }
}

// The first few corners decide most pairs of views.
bool areFarApart(const View& a, const View& b) {
  int num_far = 0;
  forEachCommon(a, b, [&](const Corner& x, const Corner& y) {
    if ((x.pixel - y.pixel).norm() > kFarPx) ++num_far;
    return 2 * num_far <= static_cast<int>(kMinCornersPerView);
  });
  return 2 * num_far > static_cast<int>(kMinCornersPerView);
}

bool repeats(const View& a, const View& b) {
  if (a.board != b.board) return false;
  if (areFarApart(a, b)) return false;
  std::size_t count = 0;
  std::vector<std::pair<Eigen::Vector2d, Eigen::Vector2d>> used;  // pixels and their displacements
  forEachCommon(a, b, [&](const Corner& x, const Corner& y) {
    ++count;
    // A corner that is wrong in one of the views says nothing about the pose.
    const Eigen::Vector2d move = y.pixel - x.pixel;
    if (move.norm() <= kFarPx) used.emplace_back(x.pixel, move);
    return true;
  });
  const std::size_t most = std::max(a.corners.size(), b.corners.size());
  if (count < kMinCornersPerView || static_cast<double>(count) < kMinCommonShare * static_cast<double>(most))
    return false;
  Eigen::MatrixXd basis(std::ssize(used), 3);
  Eigen::MatrixXd moves(basis.rows(), 2);
  for (Eigen::Index row = 0; row < basis.rows(); ++row) {
    const auto& [place, move] = used[static_cast<std::size_t>(row)];
    basis.row(row) << 1, place.transpose();
    moves.row(row) = move.transpose();
  }
  const Eigen::MatrixXd smooth = basis * leastSquares(basis, moves);
  std::vector<double> scatter;
  for (Eigen::Index row = 0; row < basis.rows(); ++row)
    scatter.push_back((moves.row(row) - smooth.row(row)).norm());
  const double smooth_rms = std::sqrt(smooth.squaredNorm() / static_cast<double>(smooth.rows()));
  return smooth_rms <= kSamePlacePx && medianOf(scatter) <= kScatterPx;
}

// Median; for an even count, the mean of the two middle values.
double middleOf(std::vector<double> values) {
  const double upper = medianOf(values);
  for (double& value : values) value = -value;
  return 0.5 * (upper - medianOf(values));
}

// All corners that any of the views has, each at the median of its positions.
std::vector<Corner> mergedCorners(const std::vector<View>& views, const std::vector<std::size_t>& group) {
  std::map<int, std::vector<Corner>> by_id;
  for (const std::size_t i : group) {
    for (const Corner& corner : views[i].corners) by_id[corner.id].push_back(corner);
  }
  std::vector<Corner> corners;
  for (const auto& [id, samples] : by_id) {
    // Until version 16, clang captures no structured bindings.
    const auto middle = [&all = samples](const auto& value) { return middleOf(mapped(all, value)); };
    Corner& corner = corners.emplace_back();
    corner.id = id;
    corner.pixel = {middle([](const Corner& c) { return c.pixel.x(); }),
                    middle([](const Corner& c) { return c.pixel.y(); })};
    const bool are_stated =
        std::ranges::none_of(samples, [](const Corner& c) { return std::isnan(c.sigma_px); });
    if (are_stated) corner.sigma_px = middle(&Corner::sigma_px);
  }
  return corners;
}

}  // namespace

PreparedViews prepareViews(std::span<const Board> boards, std::vector<View> views) {
  const std::vector<std::size_t> order = sortViews(boards, views);
  PreparedViews given{.boards = {boards.begin(), boards.end()}};
  for (std::size_t v = 0; v < views.size(); ++v) {
    View& view = views[v];
    if (view.corners.size() < kMinCornersPerView) {
      given.dropped.views.push_back({.image = view.image,
                                     .board = view.board,
                                     .reason = std::to_string(view.corners.size()) + " corners; at least " +
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

std::vector<std::vector<Observation>> cornersOf(const PreparedViews& given) {
  return mapped(given.views,
                [&](const View& view) { return observationsOf(given.boards[view.board], view); });
}

std::vector<std::size_t> viewsLeftOut(const PreparedViews& given, const Fit& fit) {
  std::vector<std::size_t> left_out;
  for (std::size_t v = 0; v < given.views.size(); ++v) {
    if (std::ranges::find(fit.views, v, &FitView::source) == fit.views.end()) left_out.push_back(v);
  }
  return left_out;
}

void requireViews(const PreparedViews& given, const Fit& fit) {
  std::vector<std::string> reasons = reasonsOf(given);
  for (const std::size_t v : viewsLeftOut(given, fit))
    reasons.push_back(given.views[v].image + ": does not fit the other views");
  checkEnoughUsable(fit.views.size(), std::move(reasons));
}

void mergeRepeatedViews(PreparedViews& given) {
  std::vector<View>& views = given.views;
  // Each view joins the first group whose first view it repeats; order of names makes the result unique.
  std::vector<std::vector<std::size_t>> groups;
  for (std::size_t v = 0; v < views.size(); ++v) {
    const auto same = std::ranges::find_if(
        groups, [&](const auto& group) { return repeats(views[group.front()], views[v]); });
    if (same == groups.end()) {
      groups.push_back({v});
    } else {
      same->push_back(v);
    }
  }
  if (groups.size() == views.size()) return;
  std::vector<View> merged;
  std::vector<std::size_t> sources;
  for (const auto& group : groups) {
    View view = views[group.front()];
    if (group.size() > 1) view.corners = mergedCorners(views, group);
    for (std::size_t i = 1; i < group.size(); ++i)
      given.dropped.repeated.push_back(
          {.image = views[group[i]].image, .board = view.board, .same_as = view.image});
    merged.push_back(std::move(view));
    sources.push_back(given.sources[group.front()]);
  }
  views = std::move(merged);
  given.sources = std::move(sources);
}

}  // namespace alidade
