// SPDX-License-Identifier: MIT
#include "alidade/footage/check/camera_check.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <memory>
#include <utility>

#include "alidade/core/mapped.h"
#include "alidade/core/statistics.h"
#include "alidade/footage/check/camera_freeing.h"

namespace alidade {
namespace {

// Fewest frames that must show a scene together for a lack of evidence to count: with pairs and triples of
// images that share few matches, stated standard deviations are several times too small.
constexpr std::size_t kFewestTogether = 5;

std::vector<CameraChangeKind> kindsFor(const AnyCamera& camera) {
  using enum CameraChangeKind;
  std::vector<CameraChangeKind> kinds = {kFocalLength, kAspect, kPrincipalPoint};
  const auto lens = camera.parameters().subspan(4);
  const bool has_distortion = std::ranges::any_of(lens, [](double value) { return value != 0; });
  if (has_distortion) kinds.push_back(kDistortion);
  // For a lens with one parameter, the two kinds are identical.
  if (lens.size() > 1 || (lens.size() == 1 && !has_distortion)) kinds.push_back(kFirstRadial);
  kinds.push_back(kSeveral);
  return kinds;
}

// Pixels at which the windows show points, about two thousand.
std::vector<Eigen::Vector2d> seenPixels(const std::vector<Reconstruction>& windows) {
  std::vector<Eigen::Vector2d> all;
  for (const Reconstruction& window : windows) {
    for (const SceneSighting& sighting : window.fit->sightings) all.push_back(sighting.pixel);
  }
  const std::size_t step = 1 + all.size() / 2000;
  std::vector<Eigen::Vector2d> some;
  for (std::size_t i = 0; i < all.size(); i += step) some.push_back(all[i]);
  return some;
}

// 95th percentile of the displacement between two cameras of one frame.
double displacement(const AnyCamera& a, const AnyCamera& b, const std::vector<Eigen::Vector2d>& pixels) {
  std::vector<double> lengths;
  for (const Eigen::Vector2d& pixel : pixels) {
    const auto ray = a.unproject(pixel);
    if (!ray) continue;
    const Projection projection = b.project(*ray);
    if (projection.ok()) lengths.push_back((projection.pixel - pixel).norm());
  }
  return lengths.empty() ? 0 : quantile95(std::move(lengths));
}

// The same for a step of the parameters, to first order; infinite if undetermined.
double displacement(const AnyCamera& camera, const Eigen::MatrixXd& parameter_covariance,
                    const std::vector<Eigen::Vector2d>& pixels) {
  std::vector<double> lengths;
  const Eigen::Index n = parameter_covariance.rows();
  Eigen::Matrix<double, 2, Eigen::Dynamic, Eigen::RowMajor> J(2, n);
  for (const Eigen::Vector2d& pixel : pixels) {
    const auto ray = camera.unproject(pixel);
    if (!ray || !camera.project(*ray, nullptr, J.data()).ok()) continue;
    lengths.push_back(std::sqrt((J * parameter_covariance * J.transpose()).trace()));
    if (!std::isfinite(lengths.back())) return std::numeric_limits<double>::infinity();
  }
  return lengths.empty() ? std::numeric_limits<double>::infinity() : quantile95(std::move(lengths));
}

CameraChange changeBy(const AnyCamera& camera, CameraChangeKind kind, const FreedCamera& given,
                      const FreedCamera& freed, const std::vector<Eigen::Vector2d>& pixels) {
  CameraChange change{{.kind = kind}, freed.camera, freed.readout};
  const double drop = given.cost - freed.cost;
  change.cost_drop = change.gain = drop / given.cost;
  change.setFit(freed.amounts, freed.amount_covariance.view(), drop,
                freed.dispersion * std::max(1.0, freed.disagreement));
  const auto n = static_cast<Eigen::Index>(camera.parameters().size());
  const Eigen::MatrixXd covariance = freed.covariance.view();
  change.readout_std = std::sqrt(covariance(n, n));
  change.setEffect(displacement(camera, freed.camera, pixels),
                   displacement(freed.camera, covariance.topLeftCorner(n, n), pixels));
  return change;
}

// True if a frame would be read for longer than until the next one: the footage is not what the fit assumes.
// Below 0, the image is upside down.
bool isReadoutImpossible(double readout, double std) {
  constexpr double kCertain = 3;  // standard deviations
  constexpr double kSlack = 0.1;  // frames, for errors that the deviation does not show
  return std::abs(readout) > 1 + kSlack + kCertain * std;
}

// The changes that can be tried, each with the remaining error.
// @param has_open  set if a kind that might explain the footage could not be solved for; a lack of evidence
// then means nothing
std::vector<CameraChange> changesOf(const AnyCamera& camera, const CameraFreeing& freeing,
                                    const FreedCamera& given, const std::vector<Eigen::Vector2d>& pixels,
                                    bool& has_open) {
  constexpr CameraChangeKind kSeveral = CameraChangeKind::kSeveral;
  std::vector<CameraChange> changes;
  for (const CameraChangeKind kind : kindsFor(camera)) {
    const auto freed = kind == kSeveral ? freeing.all() : freeing.predictedAlong(directionsOf(kind, camera));
    if (freed) changes.push_back(changeBy(camera, kind, given, *freed, pixels));
    has_open = has_open || (!freed && kind != kSeveral);
  }
  // Candidates for the best explanation are solved for. The agreement of windows is hard to predict, so only
  // changes are skipped that no agreement could make significant.
  double best_drop = 0;
  for (const CameraChange& change : changes) {
    if (change.kind != kSeveral) best_drop = std::max(best_drop, change.cost_drop);
  }
  if (best_drop * given.cost <= kPenalty) return changes;
  for (CameraChange& change : changes) {
    constexpr double kRival = 0.5;  // of the largest predicted drop
    if (change.kind == kSeveral || change.cost_drop < kRival * best_drop) continue;
    const auto freed = freeing.along(directionsOf(change.kind, camera));
    if (freed && freed->is_converged) {
      change = changeBy(camera, change.kind, given, *freed, pixels);
    } else {
      change.score = 0;
      has_open = true;
    }
  }
  return changes;
}

void addErrors(FootageCheck& check, const std::vector<Reconstruction>& windows, ImageSize size) {
  check.cells.resize(std::size_t{FootageCheck::kColumns} * FootageCheck::kRows);
  double sum = 0;
  double count = 0;
  for (const Reconstruction& window : windows) {
    const std::vector<Eigen::Vector2d> errors = heldOutErrors(*window.fit);
    for (std::size_t i = 0; i < errors.size(); ++i) {
      if (!errors[i].allFinite()) continue;
      const Eigen::Vector2d& pixel = window.fit->sightings[i].pixel;
      const int column = std::clamp(static_cast<int>((pixel.x() + 0.5) / size.width * FootageCheck::kColumns),
                                    0, FootageCheck::kColumns - 1);
      const int row = std::clamp(static_cast<int>((pixel.y() + 0.5) / size.height * FootageCheck::kRows), 0,
                                 FootageCheck::kRows - 1);
      FootageCell& cell = check.cells[static_cast<std::size_t>(row * FootageCheck::kColumns + column)];
      ++cell.num_pixels;
      cell.rms_px += errors[i].squaredNorm();
      cell.mean_px += errors[i];
      sum += errors[i].squaredNorm();
      count += 1;
    }
  }
  for (FootageCell& cell : check.cells) {
    if (cell.num_pixels == 0) continue;
    cell.rms_px = std::sqrt(cell.rms_px / cell.num_pixels);
    cell.mean_px /= cell.num_pixels;
  }
  check.holdout_rms_px = count > 0 ? std::sqrt(sum / count) : 0;
}

// The sum of a value over all windows.
double sumOver(const FootageWindows& found, double (*of)(const Reconstruction&)) {
  double sum = 0;
  for (const Reconstruction& window : found.windows) sum += of(window);
  return sum;
}

double numPixels(const Reconstruction& window) {
  return static_cast<double>(window.fit->sightings.size());
}

// Poses and points for a different camera. @returns false on failure
bool fitTo(const AnyCamera& camera, std::vector<Reconstruction>& windows,
           const FootageCheckOptions& options) {
  const auto noises = mapped(windows, [](const Reconstruction& window) { return noiseOf(*window.fit); });
  for (Reconstruction& window : windows) {
    window.fit->camera = camera;
    window.fit->loss = kNoLoss;
    // Removes those without a pixel at these poses, from which the solver could not start.
    removeOutliers(*window.fit, std::numeric_limits<double>::infinity());
  }
  const bool is_fitted = solveWindows(windows, options.num_jobs, options.cancel);
  for (std::size_t i = 0; i < windows.size(); ++i) {
    if (noises[i] > 0) windows[i].noise_px *= noiseOf(*windows[i].fit) / noises[i];
  }
  return is_fitted;
}

struct SolvedFootage {
  FootageWindows found;
  std::unique_ptr<CameraFreeing> freeing;  // null without windows
  double outlier_share = 0;                // with the unchanged camera
};

// Reconstructs the footage with the camera, and starts again from the scene of a better-fitting camera if
// there is one: with a wrong camera, the pixels that would reveal the error become outliers and windows
// converge to wrong results.
SolvedFootage solveFor(const AnyCamera& camera, const FootageTracks& tracks,
                       const FootageCheckOptions& options, double far_px) {
  SolvedFootage solved{.found = reconstructAll(camera, tracks, options.num_jobs, options.cancel),
                       .freeing = nullptr};
  if (!solved.found.windows.empty()) {
    const double sum =
        sumOver(solved.found, [](const Reconstruction& window) { return window.outlier_share; });
    solved.outlier_share = sum / static_cast<double>(solved.found.windows.size());
  }
  constexpr int kRounds = 2;
  for (int round = 0; !solved.found.windows.empty(); ++round) {
    solved.freeing = std::make_unique<CameraFreeing>(camera, solved.found.windows, tracks, options.num_jobs,
                                                     options.cancel);
    const auto freed = solved.freeing->all();
    if (round == kRounds || !freed ||
        displacement(camera, freed->camera, seenPixels(solved.found.windows)) < far_px)
      break;
    FootageWindows better = reconstructAll(freed->camera, tracks, options.num_jobs, options.cancel);
    constexpr double kClearly = 1.01;
    if (sumOver(better, numPixels) < kClearly * sumOver(solved.found, numPixels)) break;
    if (!fitTo(camera, better.windows, options)) break;
    solved.found = std::move(better);
  }
  return solved;
}

// Reason why nothing could be reconstructed.
FootageGap gapOf(const FootageTracks& tracks, const FootageWindows& found) {
  if (tracks.frames.size() < 2) return tracks.frames.empty() ? FootageGap::kFewPoints : FootageGap::kNoMotion;
  std::size_t most = 0;
  for (std::size_t i = 1; i < tracks.frames.size(); ++i)
    most = std::max(most, commonTracks(tracks.frames[i - 1], tracks.frames[i]).size());
  if (most < 2 * TwoView::kFewestInliers) return FootageGap::kFewPoints;
  for (const Reconstruction& window : found.without_fit) {
    if (window.kind == TwoViewKind::kRotation) return FootageGap::kNoParallax;
  }
  return FootageGap::kMovingScene;
}

}  // namespace

FootageCheck checkOnFootage(const AnyCamera& camera, const FootageTracks& given_tracks,
                            const FootageCheckOptions& options) {
  camera.requireUncorrected();
  const FootageTracks tracks = withoutFixed(given_tracks);
  FootageCheck check;
  check.tolerance_px = options.tolerance_px;
  check.is_video = tracks.is_video;
  const SolvedFootage solved = solveFor(camera, tracks, options, check.failurePx());
  const FootageWindows& found = solved.found;
  for (const auto* list : {&found.windows, &found.without_fit}) {
    for (const Reconstruction& window : *list)
      check.parallax_px = std::max(check.parallax_px, window.parallax_px);
  }
  if (found.windows.empty()) {
    check.gap = gapOf(tracks, found);
    return check;
  }
  const double outliers = solved.outlier_share;
  std::size_t most_together = 0;  // frames
  for (const Reconstruction& window : found.windows) {
    check.num_frames += static_cast<int>(window.frames.size());
    check.num_pixels += static_cast<int>(window.fit->sightings.size());
    check.num_points += static_cast<int>(window.fit->points.size());
    most_together = std::max(most_together, window.frames.size());
  }
  check.num_windows = static_cast<int>(found.windows.size());

  const CameraFreeing& freeing = *solved.freeing;
  check.noise_px = freeing.noisePx();
  addErrors(check, freeing.windows(), tracks.size);
  const auto given = freeing.given();
  if (!given) {
    check.gap = FootageGap::kMovingScene;
    return check;
  }
  check.readout = given->readout;
  const std::vector<Eigen::Vector2d> pixels = seenPixels(freeing.windows());
  bool has_open = false;
  check.changes = changesOf(camera, freeing, *given, pixels, has_open);
  std::vector<const ChangeFit*> fits;
  for (CameraChange& change : check.changes) {
    // A rolling shutter stretches images too. At 0.7 to 0.9 of a frame, true cameras reached 21.
    constexpr double kBeyondShutter = 25;
    if (check.is_video && change.kind == CameraChangeKind::kAspect) change.needed_score = kBeyondShutter;
    fits.push_back(&change);
    if (change.kind == CameraChangeKind::kSeveral) continue;
    if (change.blind_px > check.blindLimitPx()) check.undetermined.push_back(change.kind);
    const bool is_binding = change.kind == CameraChangeKind::kFocalLength ||
                            change.kind == CameraChangeKind::kDistortion ||
                            change.kind == CameraChangeKind::kFirstRadial;
    if (is_binding) check.blind_px = std::max(check.blind_px, change.blind_px);
  }
  const bool is_wrong = explain(check, fits, false);
  const auto n = static_cast<Eigen::Index>(camera.parameters().size());
  const CameraChange* const change = is_wrong ? &check.changes[*check.explanation] : nullptr;
  const bool is_readout_impossible =
      change != nullptr ? isReadoutImpossible(change->readout, change->readout_std)
                        : isReadoutImpossible(given->readout, std::sqrt(given->covariance.view()(n, n)));
  constexpr double kMoving = 0.5;
  if (outliers > kMoving) {
    check.gap = FootageGap::kMovingScene;
  } else if (is_readout_impossible) {
    check.gap = FootageGap::kShutter;
  } else if (is_wrong) {
    check.verdict = FootageVerdict::kInconsistent;
  } else if (check.gap == FootageGap::kWeak || check.blind_px > check.blindLimitPx()) {
    check.gap = FootageGap::kWeak;
  } else if (has_open) {
    check.gap = FootageGap::kUnsolved;
  } else if (most_together < kFewestTogether) {
    check.gap = FootageGap::kFewFrames;
  } else {
    check.verdict = FootageVerdict::kConsistent;
  }
  return check;
}

std::string describe(const CameraChange& change) {
  return describe(change, change.camera, "");
}

}  // namespace alidade
