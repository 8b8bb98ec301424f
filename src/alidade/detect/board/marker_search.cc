// SPDX-License-Identifier: MIT
#include "alidade/detect/board/marker_search.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <numbers>
#include <optional>
#include <set>
#include <utility>

#include <fmt/format.h>
#include <Eigen/QR>

#include "alidade/core/error.h"
#include "alidade/detect/board/one_colour.h"
#include "alidade/detect/corner/corner_fit.h"
#include "alidade/geometry/decompositions.h"

namespace alidade {
namespace {

using Eigen::Vector2d;

constexpr int kNumNeighbours = 8;
constexpr std::size_t kMinCorners = 6;
constexpr std::size_t kNumNear = 12;
constexpr std::size_t kMostNear = 24;  // with those that are as near as the last one

// A point of the board and its pixel.
struct Sighting {
  Vector2d board;
  Vector2d pixel;
  double weight = 1;
  int corner = -1;  ///< id of the corner at this point; -1 if there is none
  bool is_of_marker = false;
};

// Sightings near a place of the board, and their squared distances.
using NearSightings = std::vector<std::pair<double, const Sighting*>>;

// The homography that maps the sightings near `at` to their pixels, expanded there; steps have the length
// `step_m`. Nothing if there are too few nearby.
std::optional<CornerGuess> viewAbout(const NearSightings& near, const Vector2d& at, double step_m) {
  constexpr int kMostEquations = 2 * kMostNear;
  using Rows = Eigen::Matrix<double, Eigen::Dynamic, 8, 0, kMostEquations, 8>;
  using Column = Eigen::Matrix<double, Eigen::Dynamic, 1, 0, kMostEquations, 1>;
  const Vector2d origin = near.front().second->pixel;
  double scale = 0;
  for (const auto& [distance, s] : near) scale = std::max(scale, (s->pixel - origin).norm());
  if (!(scale > 0)) return std::nullopt;
  const auto count = static_cast<Eigen::Index>(near.size());
  Rows rows(2 * count, 8);
  Column right(2 * count);
  for (Eigen::Index i = 0; i < count; ++i) {
    const Sighting& s = *near[static_cast<std::size_t>(i)].second;
    const Vector2d p = (s.board - at) / step_m;
    const Vector2d q = (s.pixel - origin) / scale;
    const double weight = s.weight / (0.5 + p.squaredNorm());
    rows.row(2 * i) << p.x(), p.y(), 1, 0, 0, 0, -q.x() * p.x(), -q.x() * p.y();
    rows.row(2 * i + 1) << 0, 0, 0, p.x(), p.y(), 1, -q.y() * p.x(), -q.y() * p.y();
    rows.middleRows<2>(2 * i) *= weight;
    right.segment<2>(2 * i) = weight * q;
  }
  const Eigen::ColPivHouseholderQR<Rows> qr(rows);
  if (qr.rank() < 8) return std::nullopt;
  const Eigen::Matrix<double, 8, 1> h = qr.solve(right);
  const Vector2d q(h(2), h(5));
  CornerGuess view{.pixel = origin + scale * q,
                   .step_u = scale * (Vector2d(h(0), h(3)) - h(6) * q),
                   .step_v = scale * (Vector2d(h(1), h(4)) - h(7) * q)};
  if (!view.pixel.allFinite() || !view.step_u.allFinite() || !view.step_v.allFinite()) return std::nullopt;
  return view;
}

// Pixel of a place of the board, predicted by the corners of one marker alone.
Vector2d placeBy(const Marker& of, const SeenMarker& seen, const Vector2d& at) {
  const Vector2d u = of.corners[1] - of.corners[0];
  const Vector2d v = of.corners[3] - of.corners[0];
  const Vector2d offset = at - middleOf(of.corners);
  const Vector2d pixel_u = 0.5 * (seen.corners[1] - seen.corners[0] + seen.corners[2] - seen.corners[3]);
  const Vector2d pixel_v = 0.5 * (seen.corners[3] - seen.corners[0] + seen.corners[2] - seen.corners[1]);
  return middleOf(seen.corners) + offset.dot(u) / u.squaredNorm() * pixel_u +
         offset.dot(v) / v.squaredNorm() * pixel_v;
}

// A marker of the pattern and a marker in the image with the same id.
struct MarkerPair {
  const Marker* of = nullptr;
  const SeenMarker* seen = nullptr;
};

// A pattern and the visible markers.
struct ChosenPattern {
  const MarkerPattern* pattern = nullptr;
  std::vector<SeenMarker> seen = {};
  std::vector<MarkerPair> agreeing = {};  // pairs of one id that most of their nearest pairs confirm
  std::size_t num_others = 0;             // number of pairs of one id that are not confirmed
  std::size_t num_framed = 0;             // outlines that look like markers

  // In a mirror, markers have codes of no marker, or of a wrong one.
  [[nodiscard]] bool mayBeMirrored() const {
    constexpr std::size_t kFewest = 4;
    return agreeing.size() < 2 && num_framed >= kFewest && 2 * seen.size() < num_framed;
  }
};

void pairMarkers(ChosenPattern& chosen) {
  std::map<int, const Marker*> by_id;
  for (const Marker& marker : chosen.pattern->markers) by_id[marker.id] = &marker;
  std::vector<MarkerPair> pairs;
  for (const SeenMarker& marker : chosen.seen) {
    const auto found = by_id.find(marker.id);
    if (found != by_id.end()) pairs.push_back({found->second, &marker});
  }
  constexpr double kMostOff = 0.3;  // share of the distance on the board, changed by perspective
  const auto confirms = [&](const MarkerPair& a, const MarkerPair& b) {
    const Vector2d from = middleOf(a.of->corners);
    const Vector2d to = middleOf(b.of->corners);
    const double off = (placeBy(*a.of, *a.seen, to) - middleOf(b.seen->corners)).norm();
    return off <= kMostOff * (middleOf(b.seen->corners) - middleOf(a.seen->corners)).norm() && from != to;
  };
  for (const MarkerPair& pair : pairs) {
    std::vector<std::pair<double, const MarkerPair*>> others;
    for (const MarkerPair& other : pairs) {
      if (&other == &pair) continue;
      others.emplace_back((middleOf(other.of->corners) - middleOf(pair.of->corners)).squaredNorm(), &other);
    }
    const std::size_t count = std::min<std::size_t>(kNumNeighbours, others.size());
    std::partial_sort(others.begin(), others.begin() + static_cast<std::ptrdiff_t>(count), others.end());
    others.resize(count);
    const auto num = std::ranges::count_if(others, [&](const auto& other) {
      return confirms(pair, *other.second) && confirms(*other.second, pair);
    });
    if (2 * num >= static_cast<std::ptrdiff_t>(count) && num > 0) chosen.agreeing.push_back(pair);
  }
  chosen.num_others = pairs.size() - chosen.agreeing.size();
}

// Looks closer until a quarter of a pattern's markers agree; the corners reveal the rest. A quick look misses
// small markers, so it must have found three quarters.
ChosenPattern choosePattern(const GrayImage& image, const std::vector<MarkerPattern>& patterns) {
  std::vector<MarkerPrint> prints;
  for (const MarkerPattern& pattern : patterns) {
    if (std::ranges::count(prints, pattern.print) == 0) prints.push_back(pattern.print);
  }
  ChosenPattern chosen{.pattern = &patterns.front()};
  bool are_framed = false;
  std::size_t num_framed = 0;
  for (const MarkerLook& look : markerLooks(image.size)) {
    if (look.scale > 1 && !are_framed) break;
    const double enough =
        (look.is_quick ? 0.75 : 0.25) * static_cast<double>(patterns.front().markers.size());
    const SeenMarkers seen = seeMarkers(image, prints, look, static_cast<std::size_t>(std::ceil(enough)));
    are_framed = seen.areFramed();
    num_framed = std::max(num_framed, static_cast<std::size_t>(seen.num_framed));
    for (const MarkerPattern& pattern : patterns) {
      const auto print = static_cast<std::size_t>(std::ranges::find(prints, pattern.print) - prints.begin());
      ChosenPattern candidate{.pattern = &pattern, .seen = seen.of_prints[print]};
      pairMarkers(candidate);
      const bool is_better = candidate.agreeing.size() > chosen.agreeing.size();
      if (is_better || (chosen.seen.empty() && chosen.agreeing.empty())) chosen = std::move(candidate);
    }
    if (static_cast<double>(chosen.agreeing.size()) >= enough) break;
  }
  chosen.num_framed = num_framed;
  return chosen;
}

struct FoundCorner {
  CornerFit fit;
  CornerGuess view;
  Vector2d failed = Vector2d::Constant(NAN);  // a guess from other corners alone that led to no fit
};

// State of the search for the corners of a board.
class CornerSearch {
 public:
  CornerSearch(const GrayImage& image, const Board& board, const ChosenPattern& chosen)
      : image_(image), board_(board), pattern_(*chosen.pattern) {
    // Corners of outlines are whole pixels, and those of tags extend into the adjacent small squares.
    constexpr double kMarkerWeight = 0.02;
    for (const MarkerPair& pair : chosen.agreeing) {
      for (std::size_t k = 0; k < 4; ++k) {
        const Vector2d& place = pair.of->corners[k];
        markers_.push_back({place, pair.seen->corners[k], kMarkerWeight, cornerAt(place), true});
      }
    }
    found_.resize(static_cast<std::size_t>(board.numCorners()));
  }

  // Continues from known corners until nothing is added, then repeats once, because positions are then better
  // known. In the end, the corners hardly depend on those of the markers.
  void run() {
    constexpr int kPasses = 2;
    gatherSightings();
    constexpr int kMaxRounds = 40;
    for (int pass = 0; pass < kPasses; ++pass) {
      tried_.clear();
      int round = 0;
      while (round < kMaxRounds && extend()) ++round;
      if (round == 0) break;
      keepOneColour(found_, [&](std::size_t i, const FoundCorner& corner) {
        return (corner.fit.contrast > 0) == shouldBeDark(static_cast<int>(i));
      });
      gatherSightings();
      refit();
    }
    constexpr int kMaxRefits = 4;
    for (int i = 0; i < kMaxRefits && refit(); ++i) continue;
  }

  [[nodiscard]] const std::vector<std::optional<FoundCorner>>& found() const { return found_; }
  // Sightings that predict a corner.
  enum class From { kAll, kOthers, kOtherCorners };

  [[nodiscard]] std::optional<CornerGuess> predict(int id, From from = From::kAll) const {
    constexpr std::size_t kLeastNear = 6;
    const Vector2d at = board_.corner(id).head<2>();
    NearSightings near;
    near.reserve(sightings_.size());
    for (const Sighting& s : sightings_) {
      if (from == From::kAll || (s.corner != id && (from == From::kOthers || !s.is_of_marker)))
        near.emplace_back((s.board - at).squaredNorm(), &s);
    }
    std::size_t count = std::min(kMostNear, near.size());
    std::partial_sort(near.begin(), near.begin() + static_cast<std::ptrdiff_t>(count), near.end());
    // Rounding must not choose between neighbours at the same distance.
    constexpr double kSameDistance = 1 + 1e-9;
    while (count > kNumNear && near[count - 1].first > kSameDistance * near[kNumNear - 1].first) --count;
    near.resize(count);
    const double reach =
        1.6 * std::max(pattern_.step_m, board_.span().x() / std::max(1, board_.columns() - 1));
    if (count < kLeastNear || near.front().first > reach * reach) return std::nullopt;
    auto view = viewAbout(near, at, pattern_.step_m);
    if (view) view->clear_share = pattern_.clear_share;
    return view;
  }

 private:
  [[nodiscard]] bool shouldBeDark(int id) const {
    return ((id % board_.columns() + id / board_.columns()) % 2 == 0) == pattern_.is_first_dark;
  }

  // The corner at a place of the board; -1 if there is none.
  [[nodiscard]] int cornerAt(const Vector2d& place) const {
    const double same = 1e-3 * pattern_.step_m;
    const auto at = std::ranges::find_if(board_.corners(), [&](const Eigen::Vector3d& corner) {
      return (corner.head<2>() - place).squaredNorm() < same * same;
    });
    return at == board_.corners().end() ? -1 : static_cast<int>(at - board_.corners().begin());
  }

  // Nothing if the corner is not where its neighbours predict it.
  [[nodiscard]] std::optional<CornerFit> fitAt(const CornerGuess& view) {
    const auto fit = fitter_.fit(image_, view);
    const double short_step = std::min(view.step_u.norm(), view.step_v.norm());
    return fit && (fit->pixel - view.pixel).norm() < kMostOffShare * short_step ? fit : std::nullopt;
  }

  bool extend() {
    std::vector<std::pair<std::size_t, FoundCorner>> added;
    for (std::size_t i = 0; i < found_.size(); ++i) {
      if (found_[i]) continue;
      const auto view = predict(static_cast<int>(i));
      if (!view) continue;
      constexpr double kNearPx = 0.5;
      if (tried_.contains(i) && (tried_[i] - view->pixel).norm() < kNearPx) continue;
      tried_[i] = view->pixel;
      if (const auto fit = fitAt(*view)) added.push_back({i, {*fit, *view}});
    }
    for (auto& [i, corner] : added) found_[i] = corner;
    gatherSightings();
    return !added.empty();
  }

  // Collects found corners, and the corners of markers at places without a found corner.
  void gatherSightings() {
    sightings_.clear();
    for (std::size_t i = 0; i < found_.size(); ++i) {
      const int id = static_cast<int>(i);
      if (found_[i]) sightings_.push_back({board_.corner(id).head<2>(), found_[i]->fit.pixel, 1, id});
    }
    for (const Sighting& marker : markers_) {
      if (marker.corner < 0 || !found_[static_cast<std::size_t>(marker.corner)]) sightings_.push_back(marker);
    }
  }

  // Repeats the fits with guesses from the other corners, because those from markers are coarse. A corner
  // whose guess has not changed is kept. Returns true if one has changed.
  bool refit() {
    std::vector<std::optional<FoundCorner>> refitted(found_.size());
    bool has_changed = false;
    for (std::size_t i = 0; i < found_.size(); ++i) {
      if (!found_[i]) continue;
      FoundCorner corner = *found_[i];
      for (const From from : {From::kOtherCorners, From::kOthers}) {
        const auto view = predict(static_cast<int>(i), from);
        if (!view || (view->pixel - corner.failed).norm() < kSamePx) continue;
        const bool is_same = isSame(*view, corner.view);
        const auto fit = is_same ? corner.fit : fitAt(*view);
        if (fit && (fit->contrast > 0) == (corner.fit.contrast > 0)) {
          refitted[i] = is_same ? corner : FoundCorner{*fit, *view, corner.failed};
          has_changed = has_changed || !is_same;
          break;
        }
        if (from == From::kOtherCorners) corner.failed = view->pixel;
      }
      has_changed = has_changed || !refitted[i];
    }
    found_ = std::move(refitted);
    gatherSightings();
    return has_changed;
  }

  static bool isSame(const CornerGuess& a, const CornerGuess& b) {
    return (a.pixel - b.pixel).norm() < kSamePx && (a.step_u - b.step_u).norm() < kSamePx &&
           (a.step_v - b.step_v).norm() < kSamePx;
  }

  static constexpr double kMostOffShare = 0.25;
  static constexpr double kSamePx = 1e-3;  // between guesses that give the same fit

  CornerFitter fitter_;
  const GrayImage& image_;
  const Board& board_;
  const MarkerPattern& pattern_;
  std::vector<Sighting> markers_;
  std::vector<Sighting> sightings_;
  std::vector<std::optional<FoundCorner>> found_;
  std::map<std::size_t, Vector2d> tried_;
};

ViewMeasures measure(const CornerSearch& search, const Board& board, double step_m, ImageSize size) {
  std::vector<double> blurs;
  std::vector<double> spacings;
  std::vector<double> tilts;
  double area = 0;
  const double area_in_steps = board.span().prod() / board.numCorners() / (step_m * step_m);
  for (const auto& corner : search.found()) {
    if (!corner) continue;
    blurs.push_back(corner->fit.blur_px);
    Eigen::Matrix2d steps;
    steps << corner->view.step_u, corner->view.step_v;
    const Vector2d stretch = singularValuesOf(steps);
    spacings.push_back(board.spacing() / step_m *
                       std::min(corner->view.step_u.norm(), corner->view.step_v.norm()));
    tilts.push_back(std::acos(std::min(1.0, stretch(1) / stretch(0))));
    area += stretch.prod() * area_in_steps;
  }
  return medianMeasures(std::move(blurs), std::move(spacings), std::move(tilts), area, size);
}

// Number of the board's markers that are seen at two places.
int numSeenTwice(const ChosenPattern& chosen) {
  std::set<int> twice;
  for (const SeenMarker& a : chosen.seen) {
    const bool is_of_board = std::ranges::count(chosen.pattern->markers, a.id, &Marker::id) > 0;
    const double side = (a.corners[1] - a.corners[0]).norm();
    const bool is_elsewhere = std::ranges::any_of(chosen.seen, [&](const SeenMarker& b) {
      return b.id == a.id && (middleOf(a.corners) - middleOf(b.corners)).norm() > side;
    });
    if (is_of_board && is_elsewhere) twice.insert(a.id);
  }
  return static_cast<int>(twice.size());
}

// A sentence about markers that fit no place of the board.
std::string tellStrays(const ChosenPattern& chosen, const Board& board) {
  const std::string marker(board.words().marker);
  const std::string& dictionary = chosen.pattern->print.dictionary;
  if (chosen.seen.empty()) return fmt::format("no {} of {} was found", marker, dictionary);
  const std::size_t num_own = chosen.num_others;
  if (num_own == 0) {
    return fmt::format("found {} {}{} of {}, but with other ids than {} has", chosen.seen.size(), marker,
                       chosen.seen.size() == 1 ? "" : "s", dictionary, board.spec());
  }
  return fmt::format("found {} of {} {}s, {}", num_own, chosen.pattern->markers.size(), marker,
                     num_own == 1 ? "too few to place the board" : "but no two as on " + board.spec());
}

// Corners along one line do not determine a pose.
bool spansArea(const std::vector<Corner>& corners, int columns) {
  const auto differ = [&](auto part) {
    return std::ranges::any_of(corners, [&](const Corner& c) { return part(c.id) != part(corners[0].id); });
  };
  return differ([&](int id) { return id % columns; }) && differ([&](int id) { return id / columns; });
}

// The board with the corners around the chosen markers.
Detection boardAround(const ChosenPattern& chosen, const GrayImage& image, const Board& board) {
  const std::size_t num_agreeing = chosen.agreeing.size();
  const std::string_view points = board.words().points;
  const std::string_view marker = board.words().marker;
  // Two markers, or one in fifty of many, may be read where there is none.
  const int num_accidents = std::max(2, static_cast<int>(chosen.seen.size() / 50));
  if (const int num_twice = numSeenTwice(chosen); num_twice > num_accidents) {
    return {.reason = DetectionReason::kSeveralBoards,
            .detail = fmt::format("shows {} of the board's {}s at two places", num_twice, marker)};
  }
  if (chosen.num_others > std::max<std::size_t>(1, num_agreeing / 2)) {  // a single marker may be a mistake
    return {.reason = DetectionReason::kOtherBoard,
            .detail = fmt::format("{} of {} {}s do not lie as on {}", chosen.num_others,
                                  chosen.num_others + num_agreeing, marker, board.spec())};
  }
  if (num_agreeing == 0) {
    return {.reason = chosen.seen.empty() ? DetectionReason::kNoBoard : DetectionReason::kUnplaced,
            .detail = tellStrays(chosen, board)};
  }
  CornerSearch search(image, board, chosen);
  search.run();
  Detection detection;
  std::vector<Vector2d> missing;
  for (int id = 0; id < board.numCorners(); ++id) {
    if (const auto& found = search.found()[static_cast<std::size_t>(id)]) {
      detection.corners.push_back({.id = id, .pixel = found->fit.pixel, .sigma_px = found->fit.sigma_px});
    } else if (const auto view = search.predict(id)) {
      missing.push_back(view->pixel);
    }
  }
  if (detection.corners.size() < kMinCorners || !spansArea(detection.corners, board.columns())) {
    return detection.withdraw(
        DetectionReason::kBlurred,
        fmt::format("found {} of {} {}s, but only {} {} are clear enough to be located", num_agreeing,
                    chosen.pattern->markers.size(), marker, detection.corners.size(), points));
  }
  detection.measures = measure(search, board, chosen.pattern->step_m, image.size);
  detection.describeMissing(board.numCorners(), points, missing, image.size);
  return detection;
}

}  // namespace

Marker squareMarker(int id, const Vector2d& low, double side) {
  return {.id = id,
          .corners = {low, low + Vector2d(side, 0), low + Vector2d(side, side), low + Vector2d(0, side)}};
}

Detection findMarkerBoard(const GrayImage& image, const Board& board,
                          const std::vector<MarkerPattern>& patterns) {
  expect(!image.empty() && !patterns.empty(), "an image with pixels, and a pattern");
  const ChosenPattern chosen = choosePattern(image, patterns);
  if (chosen.mayBeMirrored()) {
    const GrayImage mirror = mirroredOf(image);
    const ChosenPattern mirrored = choosePattern(mirror, patterns);
    Detection detection = boardAround(mirrored, mirror, board);
    for (Corner& corner : detection.corners) corner.pixel.x() = image.size.width - 1 - corner.pixel.x();
    if (detection.hasCorners()) return detection;
  }
  return boardAround(chosen, image, board);
}

}  // namespace alidade
