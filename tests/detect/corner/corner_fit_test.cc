// SPDX-License-Identifier: MIT
#include "alidade/detect/corner/corner_fit.h"

#include <gmock/gmock.h>

#include <cmath>
#include <functional>
#include <limits>
#include <numbers>
#include <string>

#include "alidade/core/parallel.h"
#include "support/board_photo.h"
#include "support/degrade.h"

namespace alidade {
namespace {

constexpr ImageSize kSmall{.width = 640, .height = 480};
constexpr ImageSize kMedium{.width = 1920, .height = 1200};

struct Outcome {
  int num_corners = 0;
  int num_fits = 0;
  double rms = 0;           // per axis, px
  double bias = 0;          // larger of both axes', px
  double sigma_ratio = 0;   // root mean square of the sigmas over rms
  double worst_sigmas = 0;  // largest error in its own sigmas
};

Outcome outcomeOf(const std::vector<std::optional<CornerFit>>& fits,
                  const std::vector<Eigen::Vector2d>& truth) {
  Outcome outcome;
  double square = 0;
  double sigma2 = 0;
  Eigen::Vector2d sum = Eigen::Vector2d::Zero();
  for (std::size_t i = 0; i < fits.size(); ++i) {
    ++outcome.num_corners;
    if (!fits[i]) continue;
    ++outcome.num_fits;
    const Eigen::Vector2d error = fits[i]->pixel - truth[i];
    sum += error;
    square += 0.5 * error.squaredNorm();
    sigma2 += fits[i]->sigma_px * fits[i]->sigma_px;
    outcome.worst_sigmas = std::max(outcome.worst_sigmas, error.norm() / fits[i]->sigma_px);
  }
  outcome.rms = std::sqrt(square / outcome.num_fits);
  outcome.bias = (sum / outcome.num_fits).cwiseAbs().maxCoeff();
  outcome.sigma_ratio = std::sqrt(sigma2 / outcome.num_fits) / outcome.rms;
  return outcome;
}

struct Condition {
  double noise = 0;
  Degradation degradation = Degradation::kNone;
  double max_share = 0.15;  // of the spacing, by which guesses are off
  double max_px = 4;
};

Outcome fitAll(const BoardPhotos& photos, const Condition& condition) {
  std::vector<std::optional<CornerFit>> fits;
  std::vector<Eigen::Vector2d> pixels;
  Random random(7);
  CornerFitter fitter;
  for (std::size_t view = 0; view < photos.images.size(); ++view) {
    const GrayImage image = degraded(photos.images[view], condition.degradation, condition.noise, 50 + view);
    const View& truth = photos.truth.views[view];
    for (const CornerGuess& guess :
         perturbedGuesses(photos.truth.board, truth, random, condition.max_share, condition.max_px)) {
      fits.push_back(fitter.fit(image, guess));
    }
    for (const Corner& corner : truth.corners) pixels.push_back(corner.pixel);
  }
  return outcomeOf(fits, pixels);
}

// Rendered once for all tests.
const BoardPhotos& smallPhotos() {
  static const BoardPhotos photos = renderPhotos(kSmall, 12, 17, 1);
  return photos;
}
const BoardPhotos& sharpPhotos() {
  static const BoardPhotos photos = renderPhotos(kSmall, 6, 18, 0.5);
  return photos;
}
const BoardPhotos& mediumPhotos() {
  static const BoardPhotos photos = renderPhotos(kMedium, 2, 17, 1);
  return photos;
}

// An image of tones (0 dark, 1 bright) as a lens without distortion shows it: grey levels 40 and 200, blurred
// by `blur_px`, averaged over 12 x 12 places a pixel.
GrayImage paint(ImageSize size, double blur_px, double noise, std::uint64_t seed,
                const std::function<double(double, double)>& tone) {
  constexpr int kPlaces = 12;
  std::vector<double> sharp;
  for (int y = 0; y < size.height; ++y) {
    for (int x = 0; x < size.width; ++x) {
      double sum = 0;
      for (int i = 0; i < kPlaces * kPlaces; ++i) {
        sum += tone(x + (i % kPlaces + 0.5) / kPlaces - 0.5, y + (i / kPlaces + 0.5) / kPlaces - 0.5);
      }
      sharp.push_back(40 + 160 * sum / (kPlaces * kPlaces));
    }
  }
  const int half = static_cast<int>(std::ceil(5 * blur_px));
  const auto blurAlong = [&](const std::vector<double>& from, int dx, int dy) {
    std::vector<double> to;
    for (int y = 0; y < size.height; ++y) {
      for (int x = 0; x < size.width; ++x) {
        double sum = 0;
        double weights = 0;
        for (int k = -half; k <= half; ++k) {
          const int px = std::clamp(x + k * dx, 0, size.width - 1);
          const int py = std::clamp(y + k * dy, 0, size.height - 1);
          const double weight = std::exp(-0.5 * k * k / (blur_px * blur_px));
          sum += weight * from[static_cast<std::size_t>(py * size.width + px)];
          weights += weight;
        }
        to.push_back(sum / weights);
      }
    }
    return to;
  };
  Random random(seed);
  GrayImage image{.size = size, .pixels = {}};
  for (const double grey : blurAlong(blurAlong(sharp, 1, 0), 0, 1)) {
    image.pixels.push_back(
        static_cast<std::uint8_t>(std::clamp(std::round(grey + noise * random.normal()), 0.0, 255.0)));
  }
  return image;
}

// A plane of squares: corner (0, 0) at `corner`, neighbours `step_u` and `step_v` away; the square between
// both steps is dark.
struct PaintedBoard {
  Eigen::Vector2d corner{40.3, 37.8};
  Eigen::Vector2d step_u{23, 3};
  Eigen::Vector2d step_v{-4, 22};

  [[nodiscard]] Eigen::Vector2d shares(double x, double y) const {
    const double dx = x - corner[0];
    const double dy = y - corner[1];
    const double area = step_u[0] * step_v[1] - step_u[1] * step_v[0];
    return {(dx * step_v[1] - dy * step_v[0]) / area, (dy * step_u[0] - dx * step_u[1]) / area};
  }
  [[nodiscard]] double tone(double x, double y) const {
    const Eigen::Vector2d at = shares(x, y);
    return (static_cast<int>(std::floor(at.x())) + static_cast<int>(std::floor(at.y()))) % 2 == 0 ? 0 : 1;
  }
  [[nodiscard]] CornerGuess guess(const Eigen::Vector2d& off = {1.1, -0.8}) const {
    return {.pixel = corner + off, .step_u = step_u, .step_v = step_v};
  }
};

GrayImage paintBoard(const PaintedBoard& board, double noise = 2, std::uint64_t seed = 1,
                     double blur_px = 0.9) {
  return paint({.width = 90, .height = 80}, blur_px, noise, seed,
               [&board](double x, double y) { return board.tone(x, y); });
}

TEST(FitCorner, ReachesTheBoundOfNoise) {
  const Outcome small = fitAll(smallPhotos(), {.noise = 5});
  EXPECT_EQ(small.num_corners, 648);
  EXPECT_EQ(small.num_fits, small.num_corners);
  EXPECT_LE(small.rms, 0.018);
  EXPECT_LE(small.bias, 0.002);  // of so few corners; 0.0006 is its own standard deviation
  const Outcome medium = fitAll(mediumPhotos(), {.noise = 5});
  EXPECT_EQ(medium.num_corners, 108);
  EXPECT_EQ(medium.num_fits, medium.num_corners);
  EXPECT_LE(medium.rms, 0.010);
  EXPECT_LE(medium.bias, 0.002);
}

TEST(FitCorner, IsExactToThousandthsWithoutNoise) {
  for (const BoardPhotos* photos : {&smallPhotos(), &sharpPhotos(), &mediumPhotos()}) {
    const Outcome outcome = fitAll(*photos, {});
    EXPECT_GE(outcome.num_corners, 108);
    EXPECT_EQ(outcome.num_fits, outcome.num_corners);
    EXPECT_LE(outcome.rms, 0.003);
    EXPECT_LE(outcome.bias, 0.0005);
  }
}

TEST(FitCorner, SigmaIsTheErrorUnderSensorNoise) {
  int num_corners = 0;
  for (const double noise : {1.0, 2.0, 5.0, 10.0}) {
    for (const BoardPhotos* photos : {&smallPhotos(), &sharpPhotos(), &mediumPhotos()}) {
      const Outcome outcome = fitAll(*photos, {.noise = noise});
      num_corners += outcome.num_fits;
      EXPECT_GE(outcome.sigma_ratio, 0.8) << noise;
      EXPECT_LE(outcome.sigma_ratio, 1.25) << noise;
      EXPECT_LE(outcome.worst_sigmas, 6) << noise;
    }
  }
  EXPECT_EQ(num_corners, 4 * (648 + 324 + 108));
}

TEST(FitCorner, StaysAccurateAndHonestInPoorImages) {
  struct Limit {
    Degradation degradation;
    double small_rms;
    double medium_rms;
  };
  const Limit limits[] = {
      {Degradation::kMotionBlur, 0.013, 0.007}, {Degradation::kDefocus, 0.013, 0.007},
      {Degradation::kGamma, 0.009, 0.005},      {Degradation::kClippedWhite, 0.008, 0.005},
      {Degradation::kSharpened, 0.010, 0.006},  {Degradation::kJpeg, 0.028, 0.015}};
  int num_checked = 0;
  for (const Limit& limit : limits) {
    for (const BoardPhotos* photos : {&smallPhotos(), &mediumPhotos()}) {
      const Outcome outcome = fitAll(*photos, {.noise = 2, .degradation = limit.degradation});
      const std::string name(nameOf(limit.degradation));
      EXPECT_EQ(outcome.num_fits, outcome.num_corners) << name;
      EXPECT_LE(outcome.rms, photos == &smallPhotos() ? limit.small_rms : limit.medium_rms) << name;
      EXPECT_LE(outcome.bias, 0.002) << name;
      EXPECT_GE(outcome.sigma_ratio, 0.5) << name;
      EXPECT_LE(outcome.sigma_ratio, 2) << name;
      num_checked += outcome.num_fits;
    }
  }
  EXPECT_EQ(num_checked, 6 * (648 + 108));
}

TEST(FitCorner, FindsItsWayFromFarOff) {
  // Guesses a fifth of the spacing off in x and y, at most 4 px; the same corner must come out as from near.
  int num_checked = 0;
  const auto check = [&num_checked](const BoardPhotos& photos, double max_share, double max_px) {
    const GrayImage image = degraded(photos.images[0], Degradation::kNone, 3, 1);
    const View& view = photos.truth.views[0];
    Random random(3);
    const auto exact = perturbedGuesses(photos.truth.board, view, random, 0, 0);
    CornerFitter fitter;
    for (CornerGuess guess : exact) {
      const Eigen::Vector2d truth = guess.pixel;
      const double off = std::min(max_px, max_share * std::min(guess.step_u.norm(), guess.step_v.norm())) /
                         std::numbers::sqrt2;
      for (const auto& [sx, sy] : {std::pair{1, 1}, {-1, 1}, {1, -1}, {-1, -1}}) {
        guess.pixel = truth + off * Eigen::Vector2d(sx, sy);
        const auto fit = fitter.fit(image, guess);
        ASSERT_TRUE(fit) << truth.transpose();
        EXPECT_LE((fit->pixel - truth).norm(), 0.08);
        ++num_checked;
      }
    }
  };
  check(smallPhotos(), 0.2, 4);
  check(mediumPhotos(), 0.2, 8);
  EXPECT_EQ(num_checked, 2 * 4 * 54);
}

// Lines that may turn freely in a window of 4 px around a guess miss its corner.
TEST(FitCorner, FindsItsWayBetweenMarkers) {
  const PaintedBoard board{.step_u = {37, 6}, .step_v = {-7, 36}};
  const GrayImage image = paintBoard(board);
  CornerFitter fitter;
  int num_checked = 0;
  for (const double turn : {-0.1, 0.0, 0.1}) {
    for (double x = -2.5; x <= 2.5; x += 0.25) {
      for (double y = -2.5; y <= 2.5; y += 0.25) {
        CornerGuess guess = board.guess({x, y});
        guess.step_u += turn * board.step_v;
        guess.step_v -= turn * board.step_u;
        guess.clear_share = 0.11;
        const auto fit = fitter.fit(image, guess);
        EXPECT_TRUE(fit && (fit->pixel - board.corner).norm() <= 0.1) << x << " " << y << " " << turn;
        ++num_checked;
      }
    }
  }
  EXPECT_EQ(num_checked, 3 * 21 * 21);
}

TEST(FitCorner, TellsDarkFromBrightHoweverTheStepsAreGiven) {
  const PaintedBoard board;
  const GrayImage image = paintBoard(board);
  int num_checked = 0;
  for (const double su : {1.0, -1.0}) {
    for (const double sv : {1.0, -1.0}) {
      for (const bool swapped : {false, true}) {
        CornerGuess guess = board.guess();
        guess.step_u *= su;
        guess.step_v *= sv;
        if (swapped) std::swap(guess.step_u, guess.step_v);
        const auto fit = CornerFitter().fit(image, guess);
        ASSERT_TRUE(fit);
        EXPECT_NEAR(fit->contrast, su * sv * 160, 6);
        EXPECT_NEAR(fit->blur_px, std::hypot(0.9, std::sqrt(1.0 / 12)), 0.05);
        EXPECT_LE((fit->pixel - board.corner).norm(), 0.03);
        EXPECT_NEAR(fit->sigma_px * fit->sigma_px, 0.5 * fit->covariance.trace(), 1e-12);
        ++num_checked;
      }
    }
  }
  EXPECT_EQ(num_checked, 8);
}

TEST(FitCorner, UsesWhatABorderLeaves) {
  std::vector<std::optional<CornerFit>> fits;
  std::vector<Eigen::Vector2d> truth;
  for (int i = 0; i < 60; ++i) {
    PaintedBoard board;
    Random random(static_cast<std::uint64_t>(i));
    const double from_border = random.uniform(1, 8);
    board.corner = i % 2 == 0 ? Eigen::Vector2d(from_border, random.uniform(30, 50))
                              : Eigen::Vector2d(random.uniform(30, 50), 79 - from_border);
    fits.push_back(CornerFitter().fit(paintBoard(board, 2, static_cast<std::uint64_t>(i)), board.guess()));
    truth.push_back(board.corner);
  }
  const Outcome outcome = outcomeOf(fits, truth);
  EXPECT_EQ(outcome.num_corners, 60);
  EXPECT_EQ(outcome.num_fits, 60);
  EXPECT_LE(outcome.rms, 0.04);
  EXPECT_GE(outcome.sigma_ratio, 0.6);
  EXPECT_LE(outcome.sigma_ratio, 1.7);
}

TEST(FitCorner, LeavesOutWhatABoardOfHalfSquaresEndsIn) {
  // Beyond half a square to the left and above the paper is bright.
  std::vector<std::optional<CornerFit>> fits;
  std::vector<Eigen::Vector2d> truth;
  for (int i = 0; i < 40; ++i) {
    PaintedBoard board;
    Random random(static_cast<std::uint64_t>(i));
    board.corner += Eigen::Vector2d(random.uniform(-0.5, 0.5), random.uniform(-0.5, 0.5));
    board.step_u *= 1.5;
    board.step_v *= 1.5;
    const GrayImage image = paint({.width = 90, .height = 80}, 0.9, 2, static_cast<std::uint64_t>(i),
                                  [&board](double x, double y) {
                                    const Eigen::Vector2d at = board.shares(x, y);
                                    return at.x() < -0.5 || at.y() < -0.5 ? 1.0 : board.tone(x, y);
                                  });
    fits.push_back(CornerFitter().fit(image, board.guess()));
    truth.push_back(board.corner);
    ASSERT_TRUE(fits.back());
    EXPECT_LE(fits.back()->window, 0.5);
  }
  const Outcome outcome = outcomeOf(fits, truth);
  EXPECT_EQ(outcome.num_fits, 40);
  EXPECT_LE(outcome.rms, 0.02);
  EXPECT_GE(outcome.sigma_ratio, 0.6);
  EXPECT_LE(outcome.sigma_ratio, 1.7);
}

TEST(FitCorner, TrustsLessWhatIsPartlyCovered) {
  // A grey thing covers what lies beyond 0.35 steps on one side: the corner must be refused or still be
  // right.
  int num_checked = 0;
  int num_fits = 0;
  for (int i = 0; i < 40; ++i) {
    PaintedBoard board;
    board.step_u *= 1.5;
    board.step_v *= 1.5;
    const GrayImage image = paint({.width = 90, .height = 80}, 0.9, 2, static_cast<std::uint64_t>(i),
                                  [&board, i](double x, double y) {
                                    const Eigen::Vector2d at = board.shares(x, y);
                                    const double along = i % 2 == 0 ? at.x() + 0.3 * at.y() : at.x();
                                    return along > 0.35 ? 0.3 : board.tone(x, y);
                                  });
    const auto fit = CornerFitter().fit(image, board.guess({0.5, 0.5}));
    ++num_checked;
    if (!fit) continue;
    ++num_fits;
    EXPECT_LE((fit->pixel - board.corner).norm(), 5 * fit->sigma_px) << i;
  }
  EXPECT_EQ(num_checked, 40);
  EXPECT_GE(num_fits, 20);
}

TEST(FitCorner, ManagesSquaresOfAFewPixels) {
  std::vector<std::optional<CornerFit>> fits;
  std::vector<Eigen::Vector2d> truth;
  for (int i = 0; i < 60; ++i) {
    PaintedBoard board;
    Random random(static_cast<std::uint64_t>(i));
    board.corner += Eigen::Vector2d(random.uniform(-0.5, 0.5), random.uniform(-0.5, 0.5));
    const double side = random.uniform(4.5, 7);
    board.step_u *= side / board.step_u.norm();
    board.step_v *= side / board.step_v.norm();
    const Eigen::Vector2d off(random.uniform(-0.6, 0.6), random.uniform(-0.6, 0.6));
    fits.push_back(CornerFitter().fit(paintBoard(board, 2, static_cast<std::uint64_t>(i)), board.guess(off)));
    truth.push_back(board.corner);
    ASSERT_TRUE(fits.back()) << side;
    EXPECT_GT(fits.back()->contrast, 40);
  }
  const Outcome outcome = outcomeOf(fits, truth);
  EXPECT_EQ(outcome.num_fits, 60);
  EXPECT_LE(outcome.rms, 0.04);
  EXPECT_GE(outcome.sigma_ratio, 0.5);
  EXPECT_LE(outcome.sigma_ratio, 2);
}

TEST(FitCorner, RefusesWhatIsNoCorner) {
  const PaintedBoard board;
  const std::vector<std::pair<std::string, std::function<double(double, double)>>> scenes = {
      {"plain edge", [&](double x, double y) { return board.shares(x, y).x() > 0 ? 1.0 : 0.0; }},
      {"T junction",
       [&](double x, double y) {
         const Eigen::Vector2d at = board.shares(x, y);
         return at.x() < 0 ? 0.0 : (at.y() < 0 ? 1.0 : 0.4);
       }},
      {"L corner",
       [&](double x, double y) {
         const Eigen::Vector2d at = board.shares(x, y);
         return at.x() > 0 && at.y() > 0 ? 0.0 : 1.0;
       }},
      {"rim of the board",
       [&](double x, double y) {
         const Eigen::Vector2d at = board.shares(x, y);
         return at.x() < 0 ? 1.0 : board.tone(x, y);
       }},
      {"blob",
       [&](double x, double y) {
         return std::hypot(x - board.corner.x(), y - board.corner.y()) < 6 ? 0.0 : 1.0;
       }},
      {"bar", [&](double x, double y) { return std::abs(board.shares(x, y).x()) < 0.15 ? 0.0 : 1.0; }},
      {"nothing", [](double, double) { return 0.5; }}};
  int num_refused = 0;
  for (const auto& [name, tone] : scenes) {
    for (std::uint64_t seed = 0; seed < 12; ++seed) {
      Random random(seed);
      const GrayImage image = paint({.width = 90, .height = 80}, 0.9, 3, seed, tone);
      const auto fit = CornerFitter().fit(image, board.guess({random.uniform(-2, 2), random.uniform(-2, 2)}));
      EXPECT_FALSE(fit) << name << " " << seed << (fit ? fit->sigma_px : 0);
      if (!fit) ++num_refused;
    }
  }
  EXPECT_EQ(num_refused, 7 * 12);
}

TEST(FitCorner, RefusesNoiseOfAnyStrengthNearlyAlways) {
  int num_fits = 0;
  int num_checked = 0;
  for (const double noise : {2.0, 20.0, 80.0}) {
    for (std::uint64_t seed = 0; seed < 100; ++seed) {
      PaintedBoard board;
      if (seed % 2 == 1) {
        board.step_u /= 4;
        board.step_v /= 4;
      }
      Random random(seed);
      GrayImage image{.size = {.width = 90, .height = 80}, .pixels = {}};
      for (int i = 0; i < 90 * 80; ++i)
        image.pixels.push_back(
            static_cast<std::uint8_t>(std::clamp(128 + noise * random.normal(), 0.0, 255.0)));
      if (CornerFitter().fit(image, board.guess())) ++num_fits;
      ++num_checked;
    }
  }
  EXPECT_EQ(num_checked, 300);
  EXPECT_LE(num_fits, 9);
}

TEST(FitCorner, TakesAnyArguments) {
  const PaintedBoard board;
  const GrayImage image = paintBoard(board);
  const double nan = std::numeric_limits<double>::quiet_NaN();
  const double huge = 1e300;
  int num_checked = 0;
  for (const double bad : {nan, huge, -huge, std::numeric_limits<double>::infinity(), 0.0}) {
    for (int i = 0; i < 6; ++i) {
      CornerGuess guess = board.guess();
      (i < 2 ? guess.pixel : i < 4 ? guess.step_u : guess.step_v)[i % 2] = bad;
      (void)CornerFitter().fit(image, guess);  // must only come back
      ++num_checked;
    }
  }
  EXPECT_EQ(num_checked, 30);
  EXPECT_FALSE(CornerFitter().fit(GrayImage{}, board.guess()));
  const GrayImage dot{.size = {.width = 1, .height = 1}, .pixels = {77}};
  EXPECT_FALSE(CornerFitter().fit(dot, {.pixel = {0, 0}, .step_u = {10, 0}, .step_v = {0, 10}}));
}

TEST(FitCorner, GivesTheSameOnEveryThread) {
  const GrayImage image = degraded(smallPhotos().images[0], Degradation::kNone, 5, 3);
  Random random(9);
  const auto guesses = perturbedGuesses(smallPhotos().truth.board, smallPhotos().truth.views[0], random);
  CornerFitter fitter;
  std::vector<std::optional<CornerFit>> alone;
  for (const CornerGuess& guess : guesses) alone.push_back(fitter.fit(image, guess));
  std::vector<std::optional<CornerFit>> together(guesses.size());
  parallelFor(guesses.size(), 4, [&](std::size_t i) { together[i] = CornerFitter().fit(image, guesses[i]); });
  int num_checked = 0;
  for (std::size_t i = 0; i < guesses.size(); ++i) {
    ASSERT_TRUE(alone[i] && together[i]);
    EXPECT_EQ(alone[i]->pixel, together[i]->pixel);
    EXPECT_EQ(alone[i]->covariance, together[i]->covariance);
    ++num_checked;
  }
  EXPECT_EQ(num_checked, 54);
}

}  // namespace
}  // namespace alidade
