// SPDX-License-Identifier: MIT
#include "alidade/adjust/board/places.h"

#include <algorithm>
#include <cmath>
#include <utility>

namespace alidade {
namespace {

constexpr double kSamePlace = 0.005;  // of the image diagonal

// Both lists of corners are in ascending order of ids.
bool isSamePlace(const FitView& a, const FitView& b, double limit_px) {
  double sum = 0;
  std::size_t num_common = 0;
  auto at = b.corners.begin();
  for (const Observation& corner : a.corners) {
    while (at != b.corners.end() && at->id < corner.id) ++at;
    if (at == b.corners.end()) break;
    if (at->id != corner.id) continue;
    const double square = (at->pixel - corner.pixel).squaredNorm();
    // The first common corner decides for nearly all pairs, because it is far off.
    constexpr double kFar = 16;
    if (num_common == 0 && square > kFar * limit_px * limit_px) return false;
    sum += square;
    ++num_common;
  }
  return 2 * num_common >= std::max(a.corners.size(), b.corners.size()) &&
         sum <= limit_px * limit_px * static_cast<double>(num_common);
}

}  // namespace

std::vector<std::size_t> placesOf(const Fit& fit) {
  std::vector<std::size_t> first;  // first view of each place
  std::vector<std::size_t> places;
  for (std::size_t v = 0; v < fit.views.size(); ++v) {
    const FitView& view = fit.views[v];
    const ImageSize size = fit.cameras[view.camera].size;
    const double limit_px = kSamePlace * std::hypot(size.width, size.height);
    const auto same = std::find_if(first.begin(), first.end(), [&](std::size_t other) {
      return fit.views[other].camera == view.camera && fit.views[other].board == view.board &&
             isSamePlace(fit.views[other], view, limit_px);
    });
    places.push_back(static_cast<std::size_t>(same - first.begin()));
    if (same == first.end()) first.push_back(v);
  }
  return places;
}

std::size_t numPlaces(const Fit& fit) {
  const std::vector<std::size_t> places = placesOf(fit);
  return places.empty() ? 0 : *std::max_element(places.begin(), places.end()) + 1;
}

std::vector<Reduced> sumByPlace(std::vector<Reduced> views, std::span<const std::size_t> places) {
  std::vector<Reduced> sums;
  for (std::size_t v = 0; v < views.size(); ++v) {
    if (places[v] == sums.size()) {
      sums.push_back(std::move(views[v]));
      continue;
    }
    Reduced& sum = sums[places[v]];
    sum.information += views[v].information;
    sum.gradient += views[v].gradient;
    sum.squares += views[v].squares;
    sum.num_corners += views[v].num_corners;
  }
  return sums;
}

std::vector<Reduced> reducedByPlace(const Fit& fit, LossWeights weights) {
  return sumByPlace(reduced(fit, weights), placesOf(fit));
}

}  // namespace alidade
