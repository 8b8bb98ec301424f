// SPDX-License-Identifier: MIT
#include "alidade/footage/check/camera_check.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <memory>
#include <utility>

#include <fmt/format.h>

#include "alidade/core/parallel.h"
#include "alidade/core/statistics.h"

namespace alidade {
namespace {

constexpr double kPenalty = 6;  // of the score, for each unknown: 1 in 1000 and a choice of six kinds
// Of the score: tracks have errors in common that their scatter does not show.
constexpr double kEvidence = 10;
// Of the squared errors. All parameters together also absorb errors that the images share: a third of them
// on photographs by a camera that was calibrated with a board.
constexpr double kAllTogether = 0.5;
constexpr double kFailure = 5;  // times the tolerance, as for findings of boards
// Frames that must show a scene together before silence counts: pairs and triples of images with few matches
// have stated standard deviations that are several times too small.
constexpr std::size_t kFewestTogether = 5;
constexpr double kBlind = 10;  // times the tolerance: beyond, footage cannot tell
constexpr double kOneSided95 = 1.645;

struct Candidate {
  CameraChangeKind kind;
  Eigen::MatrixXd directions;
};

std::vector<Candidate> candidatesFor(const AnyCamera& camera) {
  const auto params = camera.parameters();
  const auto n = static_cast<Eigen::Index>(params.size());
  const Eigen::Map<const Eigen::VectorXd> at(params.data(), n);
  Eigen::VectorXd focal = Eigen::VectorXd::Zero(n);
  focal.head<2>() = at.head<2>();
  Eigen::VectorXd aspect = Eigen::VectorXd::Zero(n);
  aspect[0] = at[0];
  Eigen::MatrixXd principal = Eigen::MatrixXd::Zero(n, 2);
  principal(2, 0) = principal(3, 1) = 1;
  std::vector<Candidate> candidates = {{CameraChangeKind::kFocalLength, focal},
                                       {CameraChangeKind::kAspect, aspect},
                                       {CameraChangeKind::kPrincipalPoint, principal}};
  if (n > 4) {
    Eigen::VectorXd lens = Eigen::VectorXd::Zero(n);
    lens.tail(n - 4) = at.tail(n - 4);
    if (lens.norm() > 0) candidates.push_back({CameraChangeKind::kDistortion, lens});
    Eigen::VectorXd radial = Eigen::VectorXd::Zero(n);
    radial[4] = 1;
    // Of a lens with one parameter, the two are the same.
    if (n > 5 || lens.norm() == 0) candidates.push_back({CameraChangeKind::kFirstRadial, radial});
  }
  candidates.push_back({CameraChangeKind::kSeveral, Eigen::MatrixXd::Identity(n, n)});
  return candidates;
}

// Pixels at which the windows show points, some two thousand.
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

// The same for a step of the parameters, to first order; infinite where that cannot be told.
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

CameraChange changeBy(const AnyCamera& camera, const Candidate& candidate, const FreedCamera& given,
                      const FreedCamera& freed, const std::vector<Eigen::Vector2d>& pixels) {
  CameraChange change{.kind = candidate.kind, .camera = freed.camera};
  for (Eigen::Index i = 0; i < freed.amounts.size(); ++i) {
    change.amounts.push_back(freed.amounts[i]);
    change.std.push_back(std::sqrt(freed.amount_covariance(i, i)));
  }
  const double drop = given.cost - freed.cost;
  const double unit = freed.dispersion * std::max(1.0, freed.disagreement);
  change.cost_drop = drop / given.cost;
  change.score = drop / unit - kPenalty * static_cast<double>(candidate.directions.cols());
  change.effect_px = displacement(camera, freed.camera, pixels);
  const Eigen::Index n = candidate.directions.rows();
  const Eigen::MatrixXd covariance = freed.covariance.view();
  const double std_px = displacement(freed.camera, covariance.topLeftCorner(n, n), pixels);
  change.sure_px = std::max(0.0, change.effect_px - kOneSided95 * std_px);
  change.blind_px = kNormal95 * std_px;
  return change;
}

struct TriedChanges {
  std::vector<CameraChange> changes;
  /// Of one kind that might explain the footage and could not be solved for: silence then says nothing.
  bool has_open = false;
};

// The changes that can be tried, each with what is left of the error after it.
TriedChanges changesOf(const AnyCamera& camera, const CameraFreeing& freeing, const FreedCamera& given,
                       const std::vector<Eigen::Vector2d>& pixels) {
  TriedChanges tried;
  std::vector<CameraChange>& changes = tried.changes;
  const std::vector<Candidate> candidates = candidatesFor(camera);
  for (const Candidate& candidate : candidates) {
    const auto freed = candidate.kind == CameraChangeKind::kSeveral
                           ? freeing.all()
                           : freeing.predictedAlong(candidate.directions);
    if (freed) changes.push_back(changeBy(camera, candidate, given, *freed, pixels));
    tried.has_open = tried.has_open || (!freed && candidate.kind != CameraChangeKind::kSeveral);
  }
  // Those that may be the best explanation are solved for. How far windows agree is not predicted well, so
  // only what no windows could make significant is passed over.
  double best_drop = 0;
  for (const CameraChange& change : changes) {
    if (change.kind != CameraChangeKind::kSeveral) best_drop = std::max(best_drop, change.cost_drop);
  }
  if (best_drop * given.cost <= kPenalty) return tried;
  for (CameraChange& change : changes) {
    constexpr double kRival = 0.5;  // of the largest drop, as far as small changes tell
    if (change.kind == CameraChangeKind::kSeveral || change.cost_drop < kRival * best_drop) continue;
    const auto candidate = std::find_if(candidates.begin(), candidates.end(),
                                        [&](const Candidate& c) { return c.kind == change.kind; });
    const auto freed = freeing.along(candidate->directions);
    if (freed && freed->is_converged) {
      change = changeBy(camera, *candidate, given, *freed, pixels);
    } else {
      change.score = 0;
      tried.has_open = true;
    }
  }
  return tried;
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

std::size_t numPixels(const FootageWindows& found) {
  std::size_t count = 0;
  for (const Reconstruction& window : found.windows) count += window.fit->sightings.size();
  return count;
}

std::size_t longestWindow(const std::vector<Reconstruction>& windows) {
  std::size_t most = 0;
  for (const Reconstruction& window : windows) most = std::max(most, window.frames.size());
  return most;
}

// Chooses the explanation: of the significant changes of one kind, the one that takes away most; or all
// together, if they take away clearly more, and what they find is an error that counts.
// @returns whether the explanation makes the camera wrong
bool explain(FootageCheck& check) {
  const double limit_px = kFailure * check.tolerance_px;
  const auto isWrongBy = [&](const CameraChange& change) {
    return change.effect_px > limit_px && change.sure_px > 0.5 * limit_px;
  };
  double most = 0;
  for (std::size_t i = 0; i < check.changes.size(); ++i) {
    const CameraChange& change = check.changes[i];
    const bool is_blind = change.blind_px > kBlind * check.tolerance_px;
    if (change.kind == CameraChangeKind::kSeveral || is_blind || !(change.score > kEvidence)) continue;
    if (change.cost_drop <= most) continue;
    most = change.cost_drop;
    check.explanation = i;
  }
  bool is_wrong = check.explanation && isWrongBy(check.changes[*check.explanation]);
  for (std::size_t i = 0; i < check.changes.size(); ++i) {
    const CameraChange& change = check.changes[i];
    if (change.kind != CameraChangeKind::kSeveral || !(change.score > kEvidence) || !isWrongBy(change))
      continue;
    constexpr double kMore = 1.25;
    if (change.cost_drop < kMore * most || (!is_wrong && change.cost_drop < kAllTogether)) continue;
    check.explanation = i;
    is_wrong = true;
  }
  return is_wrong;
}

// Poses and points for another camera. @returns whether they were found
bool fitTo(const AnyCamera& camera, std::vector<Reconstruction>& windows,
           const FootageCheckOptions& options) {
  std::vector<char> is_fitted(windows.size(), 0);
  parallelFor(
      windows.size(), options.num_jobs,
      [&](std::size_t i) {
        SceneFit fit = *windows[i].fit;
        const double noise_before = noiseOf(fit);
        fit.camera = camera;
        fit.loss = kNoLoss;
        // Those that have no pixel with these poses: the solver could not start.
        removeOutliers(fit, std::numeric_limits<double>::infinity());
        fit = solveScene(std::move(fit),
                         {.max_iterations = 200, .function_tolerance = 1e-6, .cancel = options.cancel});
        is_fitted[i] = fit.summary.termination == Termination::kConverged ? 1 : 0;
        if (noise_before > 0) windows[i].noise_px *= noiseOf(fit) / noise_before;
        windows[i].fit = std::move(fit);
      },
      options.cancel);
  return std::all_of(is_fitted.begin(), is_fitted.end(), [](char ok) { return ok != 0; });
}

double meanOutliers(const FootageWindows& found) {
  double sum = 0;
  for (const Reconstruction& window : found.windows) sum += window.outlier_share;
  return found.windows.empty() ? 0 : sum / static_cast<double>(found.windows.size());
}

struct SolvedFootage {
  FootageWindows found;
  std::unique_ptr<CameraFreeing> freeing;  // nothing without windows
  double outlier_share = 0;                // with the camera as it is
};

// Reconstructs the footage with the camera, and starts again from what a camera shows that fits it better if
// there is one: a wrong camera makes outliers of the pixels that would show what is wrong with it, and leads
// windows astray.
SolvedFootage solveFor(const AnyCamera& camera, const FootageTracks& tracks,
                       const FootageCheckOptions& options) {
  SolvedFootage solved{.found = reconstructAll(camera, tracks, {.cancel = options.cancel}, options.num_jobs),
                       .freeing = nullptr};
  solved.outlier_share = meanOutliers(solved.found);
  constexpr int kRounds = 2;
  for (int round = 0; !solved.found.windows.empty(); ++round) {
    solved.freeing = std::make_unique<CameraFreeing>(
        camera, solved.found.windows, tracks,
        FreeingOptions{.num_jobs = options.num_jobs, .cancel = options.cancel});
    const auto freed = solved.freeing->all();
    if (round == kRounds || !freed ||
        displacement(camera, freed->camera, seenPixels(solved.found.windows)) <
            kFailure * options.tolerance_px)
      break;
    FootageWindows better =
        reconstructAll(freed->camera, tracks, {.cancel = options.cancel}, options.num_jobs);
    constexpr double kMore = 1.01;
    if (static_cast<double>(numPixels(better)) < kMore * static_cast<double>(numPixels(solved.found))) break;
    if (!fitTo(camera, better.windows, options)) break;
    solved.found = std::move(better);
  }
  return solved;
}

// Why nothing could be reconstructed.
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

std::string_view verdictId(FootageVerdict verdict) {
  switch (verdict) {
    case FootageVerdict::kConsistent:
      return "consistent";
    case FootageVerdict::kInconsistent:
      return "inconsistent";
    case FootageVerdict::kCannotTell:
      break;
  }
  return "cannot_tell";
}

std::string_view gapId(FootageGap gap) {
  switch (gap) {
    case FootageGap::kNone:
      break;
    case FootageGap::kFewPoints:
      return "too_few_points";
    case FootageGap::kNoMotion:
      return "no_motion";
    case FootageGap::kNoParallax:
      return "no_parallax";
    case FootageGap::kMovingScene:
      return "moving_scene";
    case FootageGap::kFewFrames:
      return "too_few_frames";
    case FootageGap::kUnsolved:
      return "unsolved";
    case FootageGap::kWeak:
      return "undetermined";
  }
  return "";
}

std::string_view changeId(CameraChangeKind kind) {
  switch (kind) {
    case CameraChangeKind::kFocalLength:
      return "focal_length";
    case CameraChangeKind::kAspect:
      return "aspect";
    case CameraChangeKind::kPrincipalPoint:
      return "principal_point";
    case CameraChangeKind::kDistortion:
      return "distortion";
    case CameraChangeKind::kFirstRadial:
      return "radial";
    case CameraChangeKind::kSeveral:
      break;
  }
  return "several";
}

FootageCheck checkOnFootage(const AnyCamera& camera, const FootageTracks& tracks,
                            const FootageCheckOptions& options) {
  FootageCheck check{.tolerance_px = options.tolerance_px};
  check.is_video = tracks.is_video;
  const SolvedFootage solved = solveFor(camera, tracks, options);
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
  for (const Reconstruction& window : found.windows) {
    check.num_frames += static_cast<int>(window.frames.size());
    check.num_pixels += static_cast<int>(window.fit->sightings.size());
    check.num_points += static_cast<int>(window.fit->points.size());
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
  TriedChanges tried = changesOf(camera, freeing, *given, pixels);
  check.changes = std::move(tried.changes);

  for (const CameraChange& change : check.changes) {
    if (change.kind == CameraChangeKind::kSeveral) continue;
    if (change.blind_px > kBlind * options.tolerance_px) check.undetermined.push_back(change.kind);
    const bool is_binding = change.kind == CameraChangeKind::kFocalLength ||
                            change.kind == CameraChangeKind::kDistortion ||
                            change.kind == CameraChangeKind::kFirstRadial;
    if (is_binding) check.blind_px = std::max(check.blind_px, change.blind_px);
  }
  const bool is_wrong = explain(check);
  constexpr double kMoving = 0.5;
  if (is_wrong) {
    check.verdict = outliers > kMoving ? FootageVerdict::kCannotTell : FootageVerdict::kInconsistent;
    if (outliers > kMoving) check.gap = FootageGap::kMovingScene;
  } else if (outliers > kMoving) {
    check.gap = FootageGap::kMovingScene;
  } else if (check.blind_px > kBlind * options.tolerance_px) {
    check.gap = FootageGap::kWeak;
  } else if (tried.has_open) {
    check.gap = FootageGap::kUnsolved;
  } else if (longestWindow(found.windows) < kFewestTogether) {
    check.gap = FootageGap::kFewFrames;
  } else {
    check.verdict = FootageVerdict::kConsistent;
  }
  return check;
}

std::string describe(const CameraChange& change) {
  const auto percent = [&](std::string_view name) {
    return fmt::format("{} {:+.1f} % +- {:.1f} %", name, 100 * change.amounts[0], 100 * change.std[0]);
  };
  switch (change.kind) {
    case CameraChangeKind::kFocalLength:
      return percent("focal length");
    case CameraChangeKind::kAspect:
      return percent("fx alone");
    case CameraChangeKind::kPrincipalPoint:
      return fmt::format("principal point {:+.1f} +- {:.1f} px in x and {:+.1f} +- {:.1f} px in y",
                         change.amounts[0], change.std[0], change.amounts[1], change.std[1]);
    case CameraChangeKind::kDistortion:
      return fmt::format("distortion times {:.2f} +- {:.2f}", 1 + change.amounts[0], change.std[0]);
    case CameraChangeKind::kFirstRadial:
      return fmt::format("{} {:+.3f} +- {:.3f}", std::string(change.camera.parameterNames()[4]),
                         change.amounts[0], change.std[0]);
    case CameraChangeKind::kSeveral:
      break;
  }
  return "several parameters at once";
}

}  // namespace alidade
