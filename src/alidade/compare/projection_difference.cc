// SPDX-License-Identifier: MIT
#include "alidade/compare/projection_difference.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <span>
#include <string>
#include <utility>

#include "alidade/camera/lens_shapes.h"
#include "alidade/camera/projection_uncertainty.h"
#include "alidade/compare/ray_alignment.h"
#include "alidade/core/error.h"
#include "alidade/core/mapped.h"
#include "alidade/core/number_text.h"
#include "alidade/core/size_groups.h"
#include "alidade/core/statistics.h"
#include "alidade/core/text.h"
#include "alidade/geometry/symmetric_eigen.h"

namespace alidade {
namespace {

constexpr double kNan = std::numeric_limits<double>::quiet_NaN();

Error refusal(const std::string& found, const std::string& expected, const std::string& next_step = "") {
  return usageError({"projection difference", found, expected, next_step});
}

void check(const DifferenceOptions& options) {
  if (options.freed == Freed::kPose && !(options.distance_m > 0 && std::isfinite(options.distance_m))) {
    throw refusal("a distance of " + exactText(options.distance_m) + " m",
                  "a positive distance; at infinity only the rotation can be aligned");
  }
  constexpr int kMaxPixels = 1'000'000;
  const bool is_grid = options.columns >= 0 && options.rows >= 0 && options.columns <= kMaxPixels &&
                       options.rows <= kMaxPixels / std::max(1, options.columns);
  const std::string grid =
      "a grid of " + std::to_string(options.columns) + "x" + std::to_string(options.rows) + " pixels";
  if (!is_grid) throw refusal(grid, "columns and rows of 1 or more, and at most a million in total");
  const int num_pixels = options.columns * options.rows;
  if (options.freed && num_pixels > 0 && num_pixels < fewestPairs(*options.freed)) {
    throw refusal(grid,
                  "at least " + std::to_string(fewestPairs(*options.freed)) +
                      " pixels to estimate the best " +
                      (*options.freed == Freed::kRotation ? "rotation" : "pose"),
                  "use a finer grid, or compare without alignment");
  }
}

// Advises to crop first, because a crop may have a different shape.
std::string cropAdvice(ImageSize a, ImageSize b) {
  const auto holds = [](ImageSize whole, ImageSize part) {
    return whole.width >= part.width && whole.height >= part.height;
  };
  const std::string command = "alidade convert --crop X,Y,";
  if (!holds(a, b) && !holds(b, a))
    return "first crop the camera of the image that shows more: " + command + "WIDTH,HEIGHT";
  const ImageSize whole = holds(a, b) ? a : b;
  const ImageSize part = holds(a, b) ? b : a;
  return "if the image of " + sizeText(part) + " is a crop of the other, first crop the camera of " +
         sizeText(whole) + ": " + command + std::to_string(part.width) + "," + std::to_string(part.height);
}

std::vector<int> turnsToTry(const ComparedCamera& a, const ComparedCamera& b,
                            const DifferenceOptions& options) {
  const std::vector<int> turns = possibleTurns(a.size, b.size);
  if (turns.empty()) {
    throw inputError(
        {.where = "projection difference",
         .found = "images of " + sizeText(a.size) + " and " + sizeText(b.size) + " px",
         .expected =
             "images with the same aspect ratio, possibly resized or rotated by a multiple of 90 degrees",
         .next_step = cropAdvice(a.size, b.size)});
  }
  if (!options.quarter_turns) return turns.front() == 0 ? std::vector<int>{0} : turns;
  if (std::find(turns.begin(), turns.end(), *options.quarter_turns) == turns.end()) {
    throw refusal("a rotation by " + std::to_string(90 * *options.quarter_turns) + " degrees for images of " +
                      sizeText(a.size) + " and " + sizeText(b.size) + " px",
                  std::to_string(90 * turns.front()) + " or " + std::to_string(90 * turns.back()));
  }
  return {*options.quarter_turns};
}

void setFigures(ProjectionDifference& result) {
  std::vector<double> lengths;
  double sum = 0;
  double sum_of_squares = 0;
  result.max_px = -1;
  for (std::size_t i = 0; i < result.pixels.size(); ++i) {
    if (!result.difference_px[i].allFinite()) continue;
    const double length = result.lengthAt(i);
    lengths.push_back(length);
    sum += length;
    sum_of_squares += length * length;
    if (length > result.max_px) {
      result.max_px = length;
      result.worst_pixel = result.pixels[i];
    }
  }
  result.num_compared = static_cast<int>(lengths.size());
  if (lengths.empty()) {
    result.mean_px = result.rms_px = result.p95_px = result.max_px = kNan;
    result.worst_pixel.setConstant(kNan);
    return;
  }
  const auto n = static_cast<double>(lengths.size());
  result.mean_px = sum / n;
  result.rms_px = std::sqrt(sum_of_squares / n);
  result.p95_px = quantile95(std::move(lengths));
}

// S with S S^T = covariance, which may be singular: parameters that are held have no variance.
Eigen::MatrixXd rootOf(const Eigen::MatrixXd& covariance) {
  // Scaled first, because the units of the parameters span ten orders of magnitude.
  const Eigen::VectorXd scale = covariance.diagonal().cwiseMax(0).cwiseSqrt();
  const Eigen::VectorXd inverse = scale.unaryExpr([](double s) { return s > 0 ? 1 / s : 0.0; });
  const SymmetricEigen solver(inverse.asDiagonal() * covariance * inverse.asDiagonal());
  return scale.asDiagonal() * solver.eigenvectors() *
         Eigen::MatrixXd(solver.eigenvalues().cwiseMax(0).cwiseSqrt().asDiagonal());
}

Eigen::MatrixXd factorOf(const ComparedCamera& camera, std::span<const Eigen::Vector2d> pixels,
                         const Eigen::Matrix2d& unit, std::optional<Freed> freed,
                         std::span<const double> weights) {
  const auto n = static_cast<Eigen::Index>(camera.camera->parameters().size());
  if (!camera.covariance) return Eigen::MatrixXd(2 * static_cast<Eigen::Index>(pixels.size()), 0);
  expect(camera.covariance->rows() == n && camera.covariance->cols() == n,
         "the covariance has a row and a column for each of the camera's parameters");
  Eigen::MatrixXd rows =
      alignedJacobians(*camera.camera, pixels, {}, freed, weights).transposed.view().transpose() *
      rootOf(*camera.covariance);
  for (Eigen::Index i = 0; i < rows.rows(); i += 2)
    rows.middleRows<2>(i) = (unit * rows.middleRows<2>(i)).eval();
  return rows;
}

// F, 2 rows per pixel, px of the finer image along a's axes: to first order F F^T is the covariance of the
// differences caused by the uncertainty of the two cameras, with the alignment refitted for every change of
// the parameters. A camera without covariance is assumed to be exact; without any covariance, F has no
// columns. All `pixels` (of image a) have a ray in both cameras; `weights` are their weights in the
// alignment, empty if equal.
Eigen::MatrixXd differenceFactor(const ComparedCamera& a, const ComparedCamera& b, const ImageMatch& match,
                                 std::span<const Eigen::Vector2d> pixels, std::optional<Freed> freed,
                                 std::span<const double> weights) {
  const auto in_b = mapped(pixels, [&](const Eigen::Vector2d& pixel) { return match.inB(pixel); });
  const Eigen::MatrixXd by_a = factorOf(a, pixels, match.unit_from_a, freed, weights);
  const Eigen::MatrixXd by_b = factorOf(b, in_b, match.unit_from_b, freed, weights);
  Eigen::MatrixXd factor(by_a.rows(), by_a.cols() + by_b.cols());
  factor << by_a, by_b;
  return factor;
}

// Weights of the pixels in the alignment: smaller where the covariances make the difference uncertain.
void setWeights(const ComparedCamera& a, const ComparedCamera& b, const ImageMatch& match,
                std::optional<Freed> freed, std::vector<PixelPair>& pairs) {
  constexpr double kFloorPx = 0.1;
  if (!a.covariance && !b.covariance) return;
  const std::vector<Eigen::Vector2d> pixels = mapped(pairs, &PixelPair::pixel_a);
  const Eigen::MatrixXd factor = differenceFactor(a, b, match, pixels, freed, {});
  for (std::size_t i = 0; i < pairs.size(); ++i) {
    const double variance = 0.5 * factor.middleRows<2>(2 * static_cast<Eigen::Index>(i)).squaredNorm();
    pairs[i].weight = kFloorPx * kFloorPx / (kFloorPx * kFloorPx + variance);
  }
}

// True if both projections are within the diagonal of the image; farther ones are extrapolations.
bool isInSight(const std::optional<TwoDifferences>& found, ImageSize image) {
  const double diagonal = std::hypot(image.width, image.height);
  return found && found->a_to_b.norm() <= diagonal && found->b_to_a.norm() <= diagonal;
}

// Aligns without pixels that one camera projects far outside its image: they would dominate the fit.
RayAlignment alignWithinSight(const CameraPair& cameras, std::vector<PixelPair>& pairs,
                              std::optional<Freed> freed) {
  while (true) {
    RayAlignment alignment = alignRays(cameras, pairs, freed);
    if (!freed || !alignment.is_converged) return alignment;
    const std::size_t num_far = std::erase_if(pairs, [&](const PixelPair& pair) {
      const auto found = differencesAt(cameras, pair, alignment.b_from_a);
      return found && !isInSight(found, cameras.match.unit_size);
    });
    if (num_far == 0) return alignment;
  }
}

ProjectionDifference compare(const ComparedCamera& a, const ComparedCamera& b,
                             const DifferenceOptions& options, int quarter_turns) {
  ProjectionDifference result;
  result.match = matchImages(a.size, b.size, quarter_turns);
  if (options.pixels.empty()) {
    MatchedGrid grid = matchedGrid(a.size, b.size, result.match, options.columns, options.rows);
    result.columns = grid.columns;
    result.rows = grid.rows;
    result.pixels = std::move(grid.pixels);
  } else {
    result.pixels = options.pixels;
  }
  const CameraPair cameras{.a = a.camera, .b = b.camera, .match = result.match};
  std::vector<PixelPair> pairs;
  for (std::size_t i = 0; i < result.pixels.size(); ++i) {
    const Eigen::Vector2d pixel_b = result.match.inB(result.pixels[i]);
    const auto ray_a = a.camera->unproject(result.pixels[i]);
    const auto ray_b = b.camera->unproject(pixel_b);
    if (!ray_a && !ray_b) ++result.num_seen_by_neither;
    if (!ray_a || !ray_b) continue;
    pairs.push_back(
        {.pixel_a = result.pixels[i], .pixel_b = pixel_b, .ray_a = *ray_a, .ray_b = *ray_b, .index = i});
  }
  result.difference_px.assign(result.pixels.size(), Eigen::Vector2d::Constant(kNan));
  result.weights.assign(result.pixels.size(), 0.0);
  if (!pairs.empty()) {
    setWeights(a, b, result.match, options.freed, pairs);
    const RayAlignment alignment = alignWithinSight(cameras, pairs, options.freed);
    result.b_from_a = alignment.b_from_a;
    result.is_converged = alignment.is_converged;
    for (const PixelPair& pair : pairs) {
      result.weights[pair.index] = pair.weight;
      const auto found = differencesAt(cameras, pair, alignment.b_from_a);
      if (isInSight(found, result.match.unit_size))
        result.difference_px[pair.index] = 0.5 * (found->a_to_b - found->b_to_a);
    }
    result.b_from_a.translation *= options.distance_m;
  }
  setFigures(result);
  result.num_seen_by_one =
      static_cast<int>(result.pixels.size()) - result.num_compared - result.num_seen_by_neither;
  return result;
}

// Pixels per radian about the optical axis. In some models, fx is something else.
double focalLength(const AnyCamera& camera) {
  const Eigen::Vector2d by_axis = axisFocal(camera);
  return std::sqrt(std::abs(by_axis.x() * by_axis.y()));
}

double ratio(double one, double other) {
  return std::max(one / other, other / one);
}

// Sets `squares` and `directions`.
void setWald(const Eigen::MatrixXd& factor, const Eigen::VectorXd& difference,
             DifferenceSignificance& result) {
  // Least uncertainty of a direction (RMS over the image), because pixels depend on the parameters linearly
  // only to first order.
  constexpr double kFloorPx = 0.005;
  constexpr double kNoDirection = 1e-12;  // of the largest variance
  const SymmetricEigen solver(factor.transpose() * factor);
  const double floor = 0.5 * static_cast<double>(factor.rows()) * kFloorPx * kFloorPx;
  for (Eigen::Index i = 0; i < factor.cols(); ++i) {
    const double variance = solver.eigenvalues()(i);
    if (!(variance > kNoDirection * solver.eigenvalues()(factor.cols() - 1))) continue;
    const Eigen::VectorXd moved = factor * solver.eigenvectors().col(i);
    const double along = moved.dot(difference);
    result.squares += along * along / variance / (variance + floor);
    result.directions += variance / (variance + floor);
  }
}

}  // namespace

ProjectionDifference projectionDifference(const ComparedCamera& a, const ComparedCamera& b,
                                          const DifferenceOptions& options) {
  check(options);
  std::optional<ProjectionDifference> best;
  for (const int turns : turnsToTry(a, b, options)) {
    ProjectionDifference found = compare(a, b, options, turns);
    // Cameras with a centred principal point may fit both ways equally well; rounding must not decide.
    constexpr double kSame = 1e-9;
    const bool is_better =
        !best || (found.is_converged && !best->is_converged) ||
        (found.is_converged == best->is_converged && !(best->rms_px <= found.rms_px * (1 + kSame) + kSame));
    if (is_better) best = std::move(found);
  }
  return *best;
}

bool DifferenceSignificance::isSignificant() const {
  return sigmas > kNormalOneInThousand;
}

std::optional<DifferenceSignificance> significanceOf(const ProjectionDifference& difference,
                                                     const ComparedCamera& a, const ComparedCamera& b,
                                                     std::optional<Freed> freed) {
  if ((!a.covariance && !b.covariance) || difference.num_compared == 0) return std::nullopt;
  std::vector<std::size_t> compared;
  std::vector<Eigen::Vector2d> pixels;
  std::vector<double> weights;
  for (std::size_t i = 0; i < difference.pixels.size(); ++i) {
    if (!difference.difference_px[i].allFinite()) continue;
    compared.push_back(i);
    pixels.push_back(difference.pixels[i]);
    weights.push_back(difference.weights[i]);
  }
  Eigen::MatrixXd factor = differenceFactor(a, b, difference.match, pixels, freed, weights);

  // Differences below this are rounding errors, regardless of the covariance.
  const auto n = static_cast<double>(compared.size());
  DifferenceSignificance result;
  result.std_px.assign(difference.pixels.size(), kNan);
  result.expected_rms_px = std::sqrt(factor.squaredNorm() / n);
  Eigen::VectorXd weighted(factor.rows());
  int num_beyond = 0;
  for (std::size_t i = 0; i < compared.size(); ++i) {
    const auto row = 2 * static_cast<Eigen::Index>(i);
    const Eigen::Vector2d& d = difference.difference_px[compared[i]];
    const Eigen::Matrix2d covariance = factor.middleRows<2>(row) * factor.middleRows<2>(row).transpose() +
                                       kEqualPx * kEqualPx * Eigen::Matrix2d::Identity();
    const SymmetricEigen solver(covariance);
    result.std_px[compared[i]] = std::sqrt(solver.eigenvalues()(1));
    constexpr double kEllipse95 = 5.991464547107979;  // of the sum of squares of two normal variables
    const Eigen::Vector2d along = solver.eigenvectors().transpose() * d;
    num_beyond += along.cwiseAbs2().cwiseQuotient(solver.eigenvalues()).sum() > kEllipse95 ? 1 : 0;
    const double root = std::sqrt(weights[i]);
    factor.middleRows<2>(row) *= root;
    weighted.segment<2>(row) = root * d;
  }
  result.share_beyond = num_beyond / n;
  setWald(factor, weighted, result);
  const double m = std::max(1.0, result.directions);
  result.sigmas = normalOfMeanSquare(result.squares / m, m);
  const double limit = m * meanSquareOfNormal(kNormalOneInThousand, m);
  if (result.squares > limit)
    result.sure_p95_px = (1 - std::sqrt(limit / result.squares)) * difference.p95_px;
  return result;
}

bool isComparable(const ProjectionDifference& difference) {
  // The domains of different models end at slightly different places near the rim of the image circle.
  constexpr double kMaxShareOfOne = 0.05;
  const double num_seen = difference.num_compared + difference.num_seen_by_one;
  return difference.is_converged && difference.num_compared > 0 &&
         difference.num_seen_by_one <= kMaxShareOfOne * num_seen;
}

Agreement agreementOf(const ProjectionDifference& difference,
                      const std::optional<DifferenceSignificance>& significance, double tolerance_px) {
  constexpr double kCopy = 0.05;  // of the predicted difference
  if (!isComparable(difference)) return Agreement::kNotComparable;
  if (difference.p95_px < kEqualPx) return Agreement::kWithin;
  if (!significance) return difference.p95_px <= tolerance_px ? Agreement::kWithin : Agreement::kBeyond;
  const bool is_known = significance->expected_rms_px <= tolerance_px;
  if (difference.p95_px <= tolerance_px) {
    const bool is_copy = difference.rms_px < kCopy * significance->expected_rms_px;
    return is_known || is_copy ? Agreement::kWithin : Agreement::kUncertain;
  }
  return significance->sure_p95_px > (is_known ? 0 : tolerance_px) ? Agreement::kBeyond
                                                                   : Agreement::kUncertain;
}

std::string_view answerOf(Agreement agreement) {
  return agreement == Agreement::kWithin   ? "same"
         : agreement == Agreement::kBeyond ? "changed"
                                           : "cannot tell";
}

std::string agreementText(const ProjectionDifference& difference,
                          const std::optional<DifferenceSignificance>& significance, double tolerance_px) {
  if (!difference.is_converged)
    return "the best alignment was not found, because the cameras have too little in common";
  if (!isComparable(difference)) {
    return "only " + std::to_string(difference.num_compared) + " of " +
           counted(difference.pixels.size(), "pixel") + " are seen by both cameras";
  }
  const double p95_px = difference.p95_px < kEqualPx ? 0 : difference.p95_px;
  std::string text = "the cameras differ by " + numberText("%.3g", p95_px) + " px (95 %)";
  if (agreementOf(difference, significance, tolerance_px) == Agreement::kUncertain) {
    text += ", but their uncertainty alone makes " + numberText("%.2g", significance->expected_rms_px) +
            " px (RMS)";
  }
  return text + "; limit " + numberText("%g", tolerance_px) + " px";
}

std::optional<CropSuspicion> suspectCrop(const ComparedCamera& a, const ComparedCamera& b,
                                         const ImageMatch& match) {
  constexpr double kOtherSize = 1.1;
  constexpr double kSameFocal = 1.02;
  const int longer_a = std::max(a.size.width, a.size.height);
  const int longer_b = std::max(b.size.width, b.size.height);
  CropSuspicion found{.is_a_larger = longer_a > longer_b,
                      .focal_a_px = focalLength(*a.camera),
                      .focal_b_px = focalLength(*b.camera),
                      .part = {},
                      .corner = {}};
  // Written so that a focal length of zero raises no suspicion.
  if (!(ratio(longer_a, longer_b) > kOtherSize && ratio(found.focal_a_px, found.focal_b_px) <= kSameFocal))
    return std::nullopt;
  const ComparedCamera& larger = found.is_a_larger ? a : b;
  const ComparedCamera& smaller = found.is_a_larger ? b : a;
  found.part = smaller.size;
  if (match.quarter_turns % 2 != 0) std::swap(found.part.width, found.part.height);
  if (match.quarter_turns != 0) return found;
  const auto in_larger = larger.camera->parameters();
  const auto in_smaller = smaller.camera->parameters();
  const double x = std::round(in_larger[2] - in_smaller[2]);
  const double y = std::round(in_larger[3] - in_smaller[3]);
  if (x >= 0 && y >= 0 && x <= larger.size.width - found.part.width &&
      y <= larger.size.height - found.part.height)
    found.corner = Eigen::Vector2i(static_cast<int>(x), static_cast<int>(y));
  return found;
}

}  // namespace alidade
