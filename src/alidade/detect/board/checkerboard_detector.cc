// SPDX-License-Identifier: MIT
#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <numbers>
#include <utility>

#include <fmt/format.h>
#include <Eigen/Geometry>

#include "alidade/core/error.h"
#include "alidade/detect/board/board_placement.h"
#include "alidade/detect/board/find_board.h"
#include "alidade/detect/corner/corner_fit.h"
#include "alidade/geometry/decompositions.h"
#include "alidade/imagery/gray_image.h"

namespace alidade {
namespace {

using Eigen::Vector2d;

// Longest sides of the reduced copies that are searched: the first that is at most this long, then finer ones
// for distant boards, then coarser ones for blurred boards.
constexpr int kFirstSearchPx = 1280;
constexpr int kFinestSearchPx = 2600;
constexpr int kCoarsestSearchPx = 160;
constexpr std::size_t kMinMesh = 4;
constexpr std::size_t kMaxMeshes = 4;  // per level, the largest ones
constexpr std::size_t kMinSeen =
    9;  // fewest corners that count as a board; fewer are seen in window panes and tiles
constexpr std::size_t kMinPlaced = 8;  // corners that are worth placing on the board
constexpr double kMinSpacingPx = 5;
const Detection kNothing{.reason = DetectionReason::kNoBoard, .detail = "no checkerboard pattern found"};

// A mesh at one level of the pyramid, and its placement on the board.
struct BoardCandidate {
  CornerMesh mesh;
  MeshSides sides{};
  int level = 0;
  std::vector<Placement> placements;
  bool is_placed = false;
  Eigen::AlignedBox2d box;  // of its corners in the full-size image

  [[nodiscard]] bool isWhole(const Checkerboard& board) const {
    return is_placed && mesh.size() == static_cast<std::size_t>(board.numCorners());
  }
};

SeenGrid seenGrid(const BoardCandidate& candidate) {
  const CornerMesh& mesh = candidate.mesh;
  return {.columns = std::max(mesh.length(0), mesh.length(1)),
          .rows = std::min(mesh.length(0), mesh.length(1)),
          .num_corners = static_cast<int>(mesh.size()),
          .is_closed = std::all_of(candidate.sides.begin(), candidate.sides.end(),
                                   [](MeshSide side) { return side == MeshSide::kCloses; })};
}

// True if the mesh is this board. A mesh may also be a piece of another board, or of an endless pattern; it
// counts as this board if enough of the border is visible.
bool isConvincing(const BoardCandidate& candidate, const Checkerboard& board) {
  const auto num = [&](MeshSide side) {
    return std::count(candidate.sides.begin(), candidate.sides.end(), side);
  };
  const auto num_closing = num(MeshSide::kCloses);
  const double share = static_cast<double>(candidate.mesh.size()) / board.numCorners();
  constexpr std::size_t kManyCorners = 20;  // no other pattern has so many by chance
  const bool is_large = candidate.mesh.size() >= kManyCorners;
  // All corners are visible, not only as many as happen to fit into the image.
  if (share == 1.0)
    return num_closing >= 2 || (is_large && num(MeshSide::kOutside) + (num_closing > 0 ? 0 : 1) < 4);
  constexpr double kNearlyAll = 0.75;
  return num_closing >= 2 || (seenGrid(candidate).hasCountsOf(board.columns, board.rows) &&
                              share >= kNearlyAll && is_large && num_closing >= 1);
}

bool overlap(const BoardCandidate& a, const BoardCandidate& b) {
  constexpr double kShare = 0.25;  // share of the smaller box
  const Eigen::AlignedBox2d common = a.box.intersection(b.box);
  return !common.isEmpty() && common.volume() > kShare * std::min(a.box.volume(), b.box.volume());
}

// The largest mesh, at the finest level where it was found. A smaller mesh that can be placed is preferred
// only if it is elsewhere in the image: a placement that works only with fewer corners of the same board is
// not reliable. Candidates are sorted accordingly.
const BoardCandidate& choose(const std::vector<BoardCandidate>& candidates) {
  for (std::size_t c = 0; c < candidates.size(); ++c) {
    if (!candidates[c].is_placed) continue;
    const bool is_contradicted = std::any_of(
        candidates.begin(), candidates.begin() + static_cast<std::ptrdiff_t>(c),
        [&](const BoardCandidate& larger) { return !larger.is_placed && overlap(larger, candidates[c]); });
    if (!is_contradicted) return candidates[c];
  }
  return candidates.front();
}

// True if another board elsewhere in the image fits as well as the chosen one.
bool isOneOfSeveral(const std::vector<BoardCandidate>& candidates, const BoardCandidate& chosen) {
  constexpr double kAsLarge = 0.75;
  return std::any_of(candidates.begin(), candidates.end(), [&](const BoardCandidate& other) {
    return other.is_placed && other.level == chosen.level && !overlap(other, chosen) &&
           static_cast<double>(other.mesh.size()) >= kAsLarge * static_cast<double>(chosen.mesh.size());
  });
}

std::vector<int> levelsToSearch(const GrayImage& image) {
  std::vector<int> levels;
  const auto side = [&](int level) { return std::max(image.size.width, image.size.height) >> level; };
  int first = 0;
  while (side(first) > kFirstSearchPx) ++first;
  levels.push_back(first);
  for (int k = first - 1; k >= 0 && side(k) <= kFinestSearchPx; --k) levels.push_back(k);
  for (int k = first + 1; side(k) >= kCoarsestSearchPx; ++k) levels.push_back(k);
  return levels;
}

// The mesh in pixels of the full-size image.
CornerMesh inWholeImage(const CornerMesh& mesh, int level) {
  CornerMesh out;
  out.origin_square_is_dark = mesh.origin_square_is_dark;
  forEachNode(mesh, [&](MeshNode node, const MeshCorner& corner) {
    out.insert(node, {.pixel = fromHalved(corner.pixel, level), .contrast = corner.contrast});
  });
  return out;
}

// Adds the meshes of a level to `candidates`, laid on the board.
void searchLevel(const GrayImage& image, int level, const Checkerboard& board,
                 std::vector<BoardCandidate>& candidates) {
  const SmoothImage smooth = smoothed(image);
  std::vector<CornerMesh> meshes = joinCorners(smooth, findXCorners(smooth), kMinMesh);
  if (meshes.size() > kMaxMeshes) meshes.resize(kMaxMeshes);
  for (CornerMesh& mesh : meshes) {
    completeMesh(smooth, mesh);
    if (mesh.size() < kMinPlaced) continue;
    BoardCandidate candidate;
    candidate.sides = lookAtSides(smooth, mesh);
    candidate.placements = possiblePlacements(mesh, candidate.sides, board);
    const bool is_unique = areEquivalent(candidate.placements, mesh, board);
    candidate.level = level;
    forEachNode(mesh, [&](MeshNode, const MeshCorner& corner) {
      candidate.box.extend(fromHalved(corner.pixel, level));
    });
    candidate.mesh = std::move(mesh);
    candidate.is_placed = is_unique && isConvincing(candidate, board);
    // Two pieces of one board both grow to the whole board.
    const auto is_same = [&](const BoardCandidate& other) {
      return other.level == level && other.mesh.size() == candidate.mesh.size() && overlap(other, candidate);
    };
    if (std::none_of(candidates.begin(), candidates.end(), is_same))
      candidates.push_back(std::move(candidate));
  }
}

// Mean step of the mesh in a direction.
Vector2d meanStep(const CornerMesh& mesh, int direction) {
  Vector2d sum(0, 0);
  forEachNode(mesh, [&](MeshNode node, const MeshCorner& corner) {
    if (const MeshCorner* next = mesh.find(step(node, direction))) sum += next->pixel - corner.pixel;
  });
  return sum;
}

// Among placements that look the same, the one whose columns point most to the right.
Placement choosePlacement(const std::vector<Placement>& placements, const CornerMesh& mesh,
                          const Checkerboard& board) {
  const auto merit = [&](const Placement& placement) {
    const Vector2d x_axis = meanStep(mesh, placement.quarter_turns);
    const bool runs_across = board.symmetryStep() == 1 || std::abs(x_axis.x()) >= std::abs(x_axis.y());
    return runs_across ? x_axis.x() : x_axis.y();
  };
  return *std::max_element(placements.begin(), placements.end(),
                           [&](const Placement& a, const Placement& b) { return merit(a) < merit(b); });
}

// Explains why a mesh has no unique placement on the board.
Detection describeUnplaced(Detection detection, const BoardCandidate& candidate, const Checkerboard& board) {
  const SeenGrid seen = *detection.seen;
  if (candidate.mesh.size() < kMinSeen) return kNothing;
  const std::string counts = fmt::format("{}x{} inner corners", seen.columns, seen.rows);
  const std::string asked = fmt::format("{}x{}", board.columns, board.rows);
  if (seen.columns > std::max(board.columns, board.rows) || seen.rows > std::min(board.columns, board.rows))
    return detection.withdraw(DetectionReason::kLargerBoard,
                              "shows " + counts + ", more in one direction than the expected " + asked);
  if (seen.is_closed)
    return detection.withdraw(DetectionReason::kOtherBoard,
                              "shows a whole board of " + counts + ", not " + asked);
  if (candidate.placements.empty() && seen.hasCountsOf(board.columns, board.rows))
    return detection.withdraw(DetectionReason::kLargerBoard,
                              "the squares continue beyond " + asked + " inner corners");
  if (candidate.placements.empty())
    return detection.withdraw(DetectionReason::kOtherBoard,
                              "shows part of a board (" + counts + ") that does not fit " + asked);
  return detection.withdraw(
      DetectionReason::kUnplaced,
      "shows part of a board (" + counts + "); too little of its border is visible to identify the part");
}

// Expected places of corners that were not found, next to those that were.
std::vector<Vector2d> missingPlaces(const CornerMesh& mesh, const Placement& placement,
                                    const Checkerboard& board) {
  std::vector<Vector2d> places;
  for (int j = mesh.min().j - 1; j <= mesh.max().j + 1; ++j) {
    for (int i = mesh.min().i - 1; i <= mesh.max().i + 1; ++i) {
      const auto [column, row] = placement.cell(mesh, {i, j});
      const bool is_on_board = column >= 0 && row >= 0 && column < board.columns && row < board.rows;
      if (!is_on_board || mesh.find({i, j}) != nullptr) continue;
      if (const auto place = mesh.predict({i, j})) places.push_back(*place);
    }
  }
  return places;
}

// The corners of a mesh that could be refined, at their refined positions.
struct RefinedMesh {
  CornerMesh mesh;
  std::vector<std::pair<MeshNode, CornerFit>> fits;
};

// Refines every corner of `mesh`, whose pixels are those of `image`.
RefinedMesh refineMesh(const GrayImage& image, const CornerMesh& mesh) {
  RefinedMesh refined;
  refined.mesh.origin_square_is_dark = mesh.origin_square_is_dark;
  CornerFitter fitter;
  forEachNode(mesh, [&](MeshNode node, const MeshCorner& corner) {
    const auto u = mesh.stepAt(node, 0);
    const auto v = mesh.stepAt(node, 1);
    if (!u || !v) return;
    CornerGuess guess{.pixel = corner.pixel, .step_u = *u, .step_v = *v};
    for (int d = 0; d < 4; ++d)
      guess.is_outermost[static_cast<std::size_t>(d)] = mesh.find(step(node, d)) == nullptr;
    const auto fit = fitter.fit(image, guess);
    if (!fit || (fit->contrast > 0) != mesh.squareIsDark(node)) return;
    refined.mesh.insert(node, {.pixel = fit->pixel, .contrast = std::abs(fit->contrast)});
    refined.fits.emplace_back(node, *fit);
  });
  return refined;
}

// True if all squares have the same orientation, and no corner is far from the prediction of its neighbours.
bool isRegular(const CornerMesh& mesh) {
  bool is_regular = true;
  forEachNode(mesh, [&](MeshNode node, const MeshCorner& corner) {
    const MeshCorner* right = mesh.find(step(node, 0));
    const MeshCorner* below = mesh.find(step(node, 1));
    if (right != nullptr && below != nullptr &&
        !(crossProduct(right->pixel - corner.pixel, below->pixel - corner.pixel) > 0))
      is_regular = false;
    const auto predicted = mesh.predict(node);
    const auto u = mesh.stepAt(node, 0);
    const auto v = mesh.stepAt(node, 1);
    constexpr double kMaxMisfit = 0.3;
    if (predicted && u && v &&
        (*predicted - corner.pixel).norm() > kMaxMisfit * std::min(u->norm(), v->norm()))
      is_regular = false;
  });
  return is_regular;
}

// Measures of the view from its refined corners.
ViewMeasures measure(const RefinedMesh& refined, ImageSize size) {
  std::vector<double> blurs;
  std::vector<double> spacings;
  std::vector<double> tilts;
  double area = 0;
  for (const auto& [node, fit] : refined.fits) {
    blurs.push_back(fit.blur_px);
    const auto u = refined.mesh.stepAt(node, 0);
    const auto v = refined.mesh.stepAt(node, 1);
    if (!u || !v) continue;
    spacings.push_back(std::min(u->norm(), v->norm()));
    Eigen::Matrix2d steps;
    steps << *u, *v;
    const Eigen::Vector2d stretch = singularValuesOf(steps);
    tilts.push_back(std::acos(std::min(1.0, stretch(1) / stretch(0))));
    const MeshCorner* here = refined.mesh.find(node);
    const MeshCorner* right = refined.mesh.find(step(node, 0));
    const MeshCorner* below = refined.mesh.find(step(node, 1));
    const MeshCorner* across = refined.mesh.find(step(step(node, 0), 1));
    if (right != nullptr && below != nullptr && across != nullptr)
      area += 0.5 * std::abs(crossProduct(across->pixel - here->pixel, below->pixel - right->pixel));
  }
  return medianMeasures(std::move(blurs), std::move(spacings), std::move(tilts), area, size);
}

Detection placeAndRefine(const GrayImage& image, const BoardCandidate& candidate, const Checkerboard& board) {
  Detection detection;
  detection.seen = seenGrid(candidate);
  if (!candidate.is_placed) return describeUnplaced(std::move(detection), candidate, board);

  const CornerMesh mesh = inWholeImage(candidate.mesh, candidate.level);
  const Placement placement = choosePlacement(candidate.placements, mesh, board);
  const RefinedMesh refined = refineMesh(image, mesh);
  detection.measures = measure(refined, image.size);
  constexpr double kMostShare = 0.6;
  const bool most_refined =
      static_cast<double>(refined.fits.size()) >= kMostShare * static_cast<double>(mesh.size());
  if (!most_refined || refined.fits.size() < kMinPlaced) {
    return detection.withdraw(
        DetectionReason::kBlurred,
        fmt::format("the board is visible, but {} of its {} corners are not clear enough to be located",
                    mesh.size() - refined.fits.size(), mesh.size()));
  }
  if (detection.measures.spacing_px < kMinSpacingPx) {
    return detection.withdraw(DetectionReason::kTooSmall,
                              "the board is visible, but its squares are less than 5 pixels wide");
  }
  if (!isRegular(refined.mesh)) {
    return detection.withdraw(DetectionReason::kIrregular, "the corners found do not form a regular grid");
  }
  for (const auto& [node, fit] : refined.fits) {
    const auto [column, row] = placement.cell(mesh, node);
    detection.corners.push_back(
        {.id = row * board.columns + column, .pixel = fit.pixel, .sigma_px = fit.sigma_px});
  }
  std::ranges::sort(detection.corners, {}, &Corner::id);
  detection.describeMissing(board.numCorners(), "corners", missingPlaces(mesh, placement, board), image.size);
  return detection;
}

}  // namespace

Detection findBoard(const GrayImage& image, const Checkerboard& board) {
  expect(!image.empty(), "the image has pixels");
  std::vector<GrayImage> halves;  // made on demand
  const auto imageAt = [&](int level) -> const GrayImage& {
    while (static_cast<int>(halves.size()) < level)
      halves.push_back(detail::shrunk(halves.empty() ? image : halves.back(), 2));
    return level == 0 ? image : halves[static_cast<std::size_t>(level - 1)];
  };
  std::vector<BoardCandidate> candidates;
  for (const int level : levelsToSearch(image)) {
    searchLevel(imageAt(level), level, board, candidates);
    std::stable_sort(
        candidates.begin(), candidates.end(), [](const BoardCandidate& a, const BoardCandidate& b) {
          return a.mesh.size() != b.mesh.size() ? a.mesh.size() > b.mesh.size() : a.level < b.level;
        });
    if (!candidates.empty() && choose(candidates).isWhole(board)) break;
  }
  if (candidates.empty()) return kNothing;
  const BoardCandidate& chosen = choose(candidates);
  if (chosen.is_placed && isOneOfSeveral(candidates, chosen)) {
    return {.reason = DetectionReason::kSeveralBoards,
            .detail = "shows two or more boards that match; cover all but one"};
  }
  return placeAndRefine(image, chosen, board);
}

}  // namespace alidade
