// SPDX-License-Identifier: MIT
// Accuracy and time of corner refinement on rendered boards whose corners are known exactly, next to
// OpenCV's.
#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include <opencv2/calib3d.hpp>
#include <opencv2/imgproc.hpp>

#include <Eigen/LU>

#include "alidade/detect/corner/corner_fit.h"
#include "alidade/detect/corner/corner_task.h"
#include "alidade/detect/corner/edge_model.h"
#include "support/board_photo.h"
#include "support/degrade.h"

namespace alidade {
namespace {

struct Errors {
  std::vector<Eigen::Vector2d> errors;
  std::vector<double> sigmas;

  [[nodiscard]] double rms() const {
    double sum = 0;
    for (const auto& e : errors) sum += e.squaredNorm();
    return std::sqrt(sum / (2.0 * static_cast<double>(errors.size())));
  }
  [[nodiscard]] double bias() const {
    Eigen::Vector2d sum = Eigen::Vector2d::Zero();
    for (const auto& e : errors) sum += e;
    return (sum / static_cast<double>(errors.size())).cwiseAbs().maxCoeff();
  }
  // Stated sigmas over the actual errors.
  [[nodiscard]] double sigmaRatio() const {
    double sum = 0;
    for (const double s : sigmas) sum += s * s;
    return std::sqrt(sum / static_cast<double>(sigmas.size())) / rms();
  }
  // The same per corner: 1 if each corner's sigma is right.
  [[nodiscard]] double normalizedRatio() const {
    double sum = 0;
    for (std::size_t i = 0; i < errors.size(); ++i)
      sum += errors[i].squaredNorm() / (2 * sigmas[i] * sigmas[i]);
    return 1 / std::sqrt(sum / static_cast<double>(errors.size()));
  }
  [[nodiscard]] double worst() const {
    double w = 0;
    for (const auto& e : errors) w = std::max(w, e.norm());
    return w;
  }
};

struct Case {
  ImageSize size;
  int num_views = 0;
  double blur_px = 1;
  double noise = 0;
  Degradation degradation = Degradation::kNone;
  bool with_opencv = true;
};

// The smallest standard deviation of any unbiased estimate (Cramer-Rao bound): from the model's derivatives
// at the truth, with all its parameters unknown except the tone curve and the difference of the blurs, over
// the window of 0.8 steps. It covers the rendering's own blur and noise, but not later degradation of the
// image.
double cramerRao(const GrayImage& image, const CornerGuess& at_truth, double blur_px, double noise) {
  EdgeModel model;
  const Eigen::Vector2i origin(static_cast<int>(std::lround(at_truth.pixel.x())),
                               static_cast<int>(std::lround(at_truth.pixel.y())));
  model[EdgeModel::kX] = at_truth.pixel.x() - origin.x();
  model[EdgeModel::kY] = at_truth.pixel.y() - origin.y();
  model[EdgeModel::kAngle1] = std::atan2(at_truth.step_u.y(), at_truth.step_u.x());
  model[EdgeModel::kAngle2] = std::atan2(at_truth.step_v.y(), at_truth.step_v.x());
  model[EdgeModel::kBlur1] = model[EdgeModel::kBlur2] = std::sqrt(blur_px * blur_px + 1.0 / 12);
  model[EdgeModel::kMean] = 125;
  model[EdgeModel::kAmplitude] = 95;
  EdgeWindow window{.center = at_truth.pixel, .step_u = at_truth.step_u, .step_v = at_truth.step_v};
  const double length_u = at_truth.step_u.norm();
  const double length_v = at_truth.step_v.norm();
  const double sine =
      std::abs(at_truth.step_u.x() * at_truth.step_v.y() - at_truth.step_u.y() * at_truth.step_v.x()) /
      (length_u * length_v);
  const double margin = (1.5 * model[EdgeModel::kBlur1] + 0.5) / sine;
  window.reach_u = 0.8 - margin / length_u;
  window.reach_v = 0.8 - margin / length_v;
  EdgePixels pixels;
  gatherBands(image, window, origin, model, 4, {1e9, 1e9}, pixels);
  NormalEquations sums;
  sumNormalEquations(pixels, model, sums);
  auto& h = sums.hessian;
  h(EdgeModel::kTone, EdgeModel::kTone) += 1e12;
  h(EdgeModel::kBlur1, EdgeModel::kBlur1) += 1e12;
  h(EdgeModel::kBlur2, EdgeModel::kBlur2) += 1e12;
  h(EdgeModel::kBlur1, EdgeModel::kBlur2) -= 1e12 - 1;
  h(EdgeModel::kBlur2, EdgeModel::kBlur1) -= 1e12 - 1;
  Eigen::Matrix<double, NormalEquations::kSize, 1> scale = h.diagonal().cwiseSqrt().cwiseInverse();
  const Eigen::Matrix<double, NormalEquations::kSize, NormalEquations::kSize> covariance =
      scale.asDiagonal() * (scale.asDiagonal() * h * scale.asDiagonal()).inverse() * scale.asDiagonal();
  return noise * noise * 0.5 * (covariance(0, 0) + covariance(1, 1));
}

// Assigns each found point to the nearest true corner within a third of the spacing.
void addMatched(const std::vector<cv::Point2f>& found, const std::vector<CornerGuess>& truth,
                Errors& errors) {
  for (const CornerGuess& corner : truth) {
    double nearest = std::min(corner.step_u.norm(), corner.step_v.norm()) / 3;
    Eigen::Vector2d error = Eigen::Vector2d::Constant(NAN);
    for (const cv::Point2f& point : found) {
      const Eigen::Vector2d e = Eigen::Vector2d(point.x, point.y) - corner.pixel;
      if (e.norm() < nearest) {
        nearest = e.norm();
        error = e;
      }
    }
    if (error.allFinite()) errors.errors.push_back(error);
  }
}

// Rendering takes longer than everything else, so cases share it.
const BoardPhotos& photosOf(ImageSize size, int num_views, double blur_px) {
  static std::map<std::pair<int, double>, BoardPhotos> cache;
  const auto key = std::pair(size.width, blur_px);
  const auto found = cache.find(key);
  if (found != cache.end()) return found->second;
  return cache.emplace(key, renderPhotos(size, num_views, 17, blur_px)).first->second;
}

void run(const Case& c) {
  const BoardPhotos& photos = photosOf(c.size, c.num_views, c.blur_px);
  const Checkerboard& board = photos.truth.board;
  Errors ours, subpix, sb;
  int num_refused = 0;
  double microseconds = 0;
  double bound = 0;
  double window = 0;
  Random random(5);
  CornerFitter fitter;
  int num_corners = 0;
  for (std::size_t view = 0; view < photos.images.size(); ++view) {
    const GrayImage image = degraded(photos.images[view], c.degradation, c.noise, 100 + view);
    const View& truth = photos.truth.views[view];
    const auto guesses = perturbedGuesses(board, truth, random);
    Random none(1);
    const auto exact = perturbedGuesses(board, truth, none, 0, 0);
    const auto begin = std::chrono::steady_clock::now();
    std::vector<std::optional<CornerFit>> fits;
    for (const CornerGuess& guess : guesses) fits.push_back(fitter.fit(image, guess));
    microseconds +=
        std::chrono::duration<double, std::micro>(std::chrono::steady_clock::now() - begin).count();
    for (std::size_t i = 0; i < fits.size(); ++i) {
      ++num_corners;
      bound += cramerRao(image, exact[i], c.blur_px, c.noise);
      if (!fits[i]) {
        ++num_refused;
        continue;
      }
      ours.errors.push_back(fits[i]->pixel - exact[i].pixel);
      ours.sigmas.push_back(fits[i]->sigma_px);
      window += fits[i]->window;
    }
    if (!c.with_opencv) continue;
    const cv::Mat mat(image.size.height, image.size.width, CV_8U,
                      const_cast<std::uint8_t*>(image.pixels.data()));
    std::vector<cv::Point2f> points;
    for (const CornerGuess& guess : guesses)
      points.emplace_back(static_cast<float>(guess.pixel.x()), static_cast<float>(guess.pixel.y()));
    cv::cornerSubPix(mat, points, {5, 5}, {-1, -1},
                     {cv::TermCriteria::COUNT + cv::TermCriteria::EPS, 100, 1e-4});
    for (std::size_t i = 0; i < points.size(); ++i)
      subpix.errors.push_back(Eigen::Vector2d(points[i].x, points[i].y) - exact[i].pixel);
    std::vector<cv::Point2f> found;
    if (cv::findChessboardCornersSB(mat, {board.columns, board.rows}, found)) addMatched(found, exact, sb);
  }
  const double rms = ours.rms();
  char name[96];
  std::snprintf(name, sizeof name, "%dx%d b%.1f n%g %s", c.size.width, c.size.height, c.blur_px, c.noise,
                std::string(nameOf(c.degradation)).c_str());
  std::printf("%-36s %5d %3d | %7.4f %7.4f %7.3f %6.4f | %5.2f %5.2f | %4.2f %6.1f", name, num_corners,
              num_refused, rms, std::sqrt(bound / num_corners), ours.worst(), ours.bias(), ours.sigmaRatio(),
              ours.normalizedRatio(), window / static_cast<double>(ours.errors.size()),
              microseconds / num_corners);
  if (c.with_opencv) {
    std::printf(" | %7.4f %5.1fx | %7.4f %5.1fx (%zu)", subpix.rms(), subpix.rms() / rms, sb.rms(),
                sb.rms() / rms, sb.errors.size());
  }
  std::printf("\n");
  std::fflush(stdout);
}

void runAll(bool with_opencv, bool with_large, double degraded_noise) {
  std::printf(
      "%-36s %5s %3s | %7s %7s %7s %6s | %5s %5s | %4s %6s | cornerSubPix 5 | findChessboardCornersSB\n",
      "case", "corn.", "ref", "rms", "bound", "worst", "bias", "sigma", "each", "win", "us");
  const ImageSize small{.width = 640, .height = 480};
  const ImageSize medium{.width = 1920, .height = 1200};
  const ImageSize large{.width = 4000, .height = 3000};
  constexpr int kSmall = 24;
  constexpr int kMedium = 10;
  constexpr int kLarge = 5;
  const auto none = Degradation::kNone;
  run({small, kSmall, 1, 5, none, with_opencv});
  run({medium, kMedium, 1, 5, none, with_opencv});
  if (with_large) run({large, kLarge, 1, 5, none, with_opencv});
  run({small, kSmall, 1, 0, none, with_opencv});
  run({medium, kMedium, 1, 0, none, with_opencv});
  run({medium, kMedium, 0.5, 0, none, with_opencv});
  if (with_large) run({large, kLarge, 1, 0, none, with_opencv});
  run({small, kSmall, 0.5, 2, none, with_opencv});
  run({medium, kMedium, 1, 1, none, with_opencv});
  run({medium, kMedium, 1, 2, none, with_opencv});
  run({medium, kMedium, 2, 5, none, with_opencv});
  for (const ImageSize size : {medium, small}) {
    for (const Degradation degradation : kAllDegradations)
      run({size, size == medium ? kMedium : kSmall, 1, degraded_noise, degradation, with_opencv});
  }
}

}  // namespace
}  // namespace alidade

int main(int argc, char** argv) {
  cv::setNumThreads(1);
  bool with_opencv = true;
  bool with_large = true;
  double degraded_noise = 2;
  for (int i = 1; i < argc; ++i) {
    const std::string argument = argv[i];
    if (argument == "--only-ours") {
      with_opencv = false;
    } else if (argument == "--no-large") {
      with_large = false;
    } else if (argument == "--noise" && i + 1 < argc) {
      degraded_noise = std::atof(argv[++i]);
    } else {
      std::fprintf(stderr, "usage: corner_bench [--only-ours] [--no-large] [--noise LEVELS]\n");
      return 2;
    }
  }
  alidade::runAll(with_opencv, with_large, degraded_noise);
  return 0;
}
