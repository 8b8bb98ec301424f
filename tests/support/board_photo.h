// SPDX-License-Identifier: MIT
#pragma once

#include <algorithm>
#include <vector>

#include "alidade/core/random.h"
#include "alidade/detect/corner/corner_fit.h"
#include "alidade/simulate/render.h"
#include "support/simulated_set.h"

namespace alidade {

/// Vector to the neighbouring corner along the columns (direction 0) or rows (1): half the way between both
/// neighbours, or the way to or from the only one at the rim. `pixels` are all corners by id.
inline Eigen::Vector2d stepAt(const Checkerboard& board, const std::vector<Eigen::Vector2d>& pixels, int id,
                              int direction) {
  const int stride = direction == 0 ? 1 : board.columns;
  const int at = direction == 0 ? id % board.columns : id / board.columns;
  const int count = direction == 0 ? board.columns : board.rows;
  const auto pixel = [&](int i) { return pixels[static_cast<std::size_t>(i)]; };
  // Beyond the rim the steps go on changing as they do inside.
  if (at == 0) return 2 * (pixel(id + stride) - pixel(id)) - 0.5 * (pixel(id + 2 * stride) - pixel(id));
  if (at == count - 1)
    return 2 * (pixel(id) - pixel(id - stride)) - 0.5 * (pixel(id) - pixel(id - 2 * stride));
  return 0.5 * (pixel(id + stride) - pixel(id - stride));
}

/// Steps from the true neighbours; the corner itself off by up to `max_share` of the spacing and `max_px` in
/// each coordinate, evenly.
inline std::vector<CornerGuess> perturbedGuesses(const Checkerboard& board, const View& truth, Random& random,
                                                 double max_share = 0.15, double max_px = 4) {
  std::vector<Eigen::Vector2d> pixels;
  for (const Corner& corner : truth.corners) pixels.push_back(corner.pixel);
  std::vector<CornerGuess> guesses;
  for (int id = 0; id < board.numCorners(); ++id) {
    CornerGuess guess{.pixel = pixels[static_cast<std::size_t>(id)],
                      .step_u = stepAt(board, pixels, id, 0),
                      .step_v = stepAt(board, pixels, id, 1)};
    const double off = std::min(max_px, max_share * std::min(guess.step_u.norm(), guess.step_v.norm()));
    guess.pixel += Eigen::Vector2d(random.uniform(-off, off), random.uniform(-off, off));
    guesses.push_back(guess);
  }
  return guesses;
}

/// A camera like common ones: a field of view of some 60 degrees, with a lens that bends lines.
inline AnyCamera commonCamera(ImageSize size) {
  const double f = 0.85 * size.width;
  const std::vector<double> params = {f,     f,    0.5 * size.width, 0.5 * size.height, -0.28, 0.08, 8e-4,
                                      -4e-4, -0.01};
  return AnyCamera::make("radtan", params);
}

/// Views of a board rendered without noise, with where its corners are.
struct BoardPhotos {
  SimulatedSet truth;
  std::vector<GrayImage> images;
};

inline BoardPhotos renderPhotos(ImageSize size, int num_views, std::uint64_t seed, double blur_px) {
  RandomViewOptions views;
  BoardPhotos photos{.truth = simulateSet(commonCamera(size), size, num_views, 0, seed, views), .images = {}};
  const Renderer renderer(photos.truth.camera, size);
  for (const SE3& pose : photos.truth.poses) {
    RenderOptions render;
    render.blur_px = blur_px;
    render.read_noise = 0;
    render.full_well_electrons = 0;
    photos.images.push_back(renderer.render(photos.truth.board, pose, render));
  }
  return photos;
}

}  // namespace alidade
